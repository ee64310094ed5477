/* ----------------------------------------------------------------------
   DEFE: adaptive finite elements to bonded discrete elements for LAMMPS
   https://www.lammps.org/
   This software is distributed under the GNU General Public License.
------------------------------------------------------------------------- */

#ifndef LMP_DEFE_WATCH_H
#define LMP_DEFE_WATCH_H

#include "defe_component.h"

#include <string>

namespace LAMMPS_NS {

/** Watches for atoms that move in a way that nothing physical does. */
class DefeWatch : protected DefeComponent {
 public:
  using DefeComponent::DefeComponent;

  /** Does any node or DE move faster than anything physical? */
  void speed() const;
  void walls();
  void rigid_elements() const;

 private:
  std::string describe(int i) const;
  void stop_exploded() const;
};

}    // namespace LAMMPS_NS

#endif
