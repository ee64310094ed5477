/* ----------------------------------------------------------------------
   DEFE: adaptive finite elements to bonded discrete elements for LAMMPS
   https://www.lammps.org/
   This software is distributed under the GNU General Public License.
------------------------------------------------------------------------- */

#ifndef LMP_DEFE_EXACT_SUMS_H
#define LMP_DEFE_EXACT_SUMS_H

#include "defe_component.h"

#include "defe/exact_sum.h"
#include "defe/types.h"

namespace LAMMPS_NS {

/** reproducible yes: forces and torques as sums of multiples of one quantum, which are exact. */
class DefeExactSums : protected DefeComponent {
 public:
  using DefeComponent::DefeComponent;
  void make_grids();

  const defe::SumGrid &force_grid() const { return force_grid_; }    // on if reproducible
  const defe::SumGrid &torque_grid() const { return torque_grid_; }

  /** A contribution to f[i] or torque[i], rounded to its grid if there is one. */
  double on_grid(const defe::SumGrid &grid, double value, int i)
  {
    if (!grid.on()) return value;
    const double rounded = grid.round(value);
    if (grid.beyond(rounded)) beyond_grid = i;
    return rounded;
  }
  defe::Vec3 rounded_force(defe::Vec3 value, int i)
  {
    for (double &v : value) v = on_grid(force_grid_, v, i);
    return value;
  }
  defe::Vec3 rounded_torque(defe::Vec3 value, int i)
  {
    for (double &v : value) v = on_grid(torque_grid_, v, i);
    return value;
  }
  /** This atom has a force or torque that is too large. */
  void set_beyond(int i) { beyond_grid = i; }
  /** Stops if there is one; sums: those of all, after the ghosts' have arrived. */
  void check_range(bool sums);

 private:
  defe::SumGrid force_grid_, torque_grid_;
  int beyond_grid = -1;
  void note_unreproducible() const;
};

}    // namespace LAMMPS_NS

#endif
