/* ----------------------------------------------------------------------
   DEFE: adaptive finite elements to bonded discrete elements for LAMMPS
   https://www.lammps.org/
   This software is distributed under the GNU General Public License.
------------------------------------------------------------------------- */

#ifndef LMP_DEFE_PICTURE_H
#define LMP_DEFE_PICTURE_H

#include "defe_component.h"

#include <vector>

namespace LAMMPS_NS {

/** Outer faces of the finite elements for dump image. */
class DefePicture : protected DefeComponent {
 public:
  using DefeComponent::DefeComponent;
  int draw(int *&objs, double **&parms);

 private:
  std::vector<double> data;
  std::vector<double *> rows;
  std::vector<int> kinds;
};

}    // namespace LAMMPS_NS

#endif
