/* ----------------------------------------------------------------------
   DEFE: adaptive finite elements to bonded discrete elements for LAMMPS
   https://www.lammps.org/
   This software is distributed under the GNU General Public License.
------------------------------------------------------------------------- */

#ifndef LMP_DEFE_COMPONENT_H
#define LMP_DEFE_COMPONENT_H

#include "pointers.h"

namespace LAMMPS_NS {

struct DefeSystem;

/** One of the parts that a DefeSystem is made of: it sees LAMMPS and the other parts. */
class DefeComponent : protected Pointers {
 public:
  explicit DefeComponent(DefeSystem &);

 protected:
  DefeSystem &sys;
};

}    // namespace LAMMPS_NS

#endif
