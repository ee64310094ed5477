/* ----------------------------------------------------------------------
   DEFE: adaptive finite elements to bonded discrete elements for LAMMPS
   https://www.lammps.org/
   This software is distributed under the GNU General Public License.
------------------------------------------------------------------------- */

#ifndef LMP_DEFE_NOTES_H
#define LMP_DEFE_NOTES_H

#include "defe_component.h"

#include <string>
#include <vector>

namespace LAMMPS_NS {

/** Notes at the first run: what is allowed, but probably not intended. One line each, once. */
class DefeNotes : protected DefeComponent {
 public:
  using DefeComponent::DefeComponent;
  void mesh_made() { due = true; }
  void go_on(bool started) { due = !started; }
  void say_all();    // at the first run after the mesh was made or has grown; collective
  void say(const std::string &note);

 private:
  bool due = false;    // the mesh was made or has grown since the last run
  std::vector<std::string> said;
  void strengths();
  void laws();
  void collecting();
  void slender();
  void bodies();
  void balls(bool deformable);
  void untied();
};

}    // namespace LAMMPS_NS

#endif
