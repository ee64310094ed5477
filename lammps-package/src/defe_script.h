/* ----------------------------------------------------------------------
   DEFE: adaptive finite elements to bonded discrete elements for LAMMPS
   https://www.lammps.org/
   This software is distributed under the GNU General Public License.
------------------------------------------------------------------------- */

#ifndef LMP_DEFE_SCRIPT_H
#define LMP_DEFE_SCRIPT_H

#include "defe_component.h"

#include <map>
#include <string>

namespace LAMMPS_NS {

/** What the script said, in restart files: materials and parts must be the same when a run goes on; of
    other settings, what has changed is said. */
class DefeScript : protected DefeComponent {
 public:
  using DefeComponent::DefeComponent;
  std::string pack() const;
  /** Returns the name of the event file. */
  std::string unpack(const char *data, size_t bytes);

 private:
  using Settings = std::map<std::string, std::string>;
  Settings settings() const;
  void check_parts(const std::string &of_file) const;
  void check_strengths(const Settings &before) const;
  void check_prestress(const Settings &before) const;
  void check_tied(const Settings &before) const;
  void note_changes(const Settings &before) const;
};

}    // namespace LAMMPS_NS

#endif
