/* ----------------------------------------------------------------------
   DEFE: adaptive finite elements to bonded discrete elements for LAMMPS
   https://www.lammps.org/
   This software is distributed under the GNU General Public License.
------------------------------------------------------------------------- */

#ifndef LMP_DEFE_EXACT_SUMS_H
#define LMP_DEFE_EXACT_SUMS_H

#include "defe_component.h"

#include "defe/coupling/force_sums.h"

namespace LAMMPS_NS {

/** reproducible yes: forces and torques as sums of multiples of one quantum, which are exact. */
class DefeExactSums : protected DefeComponent {
 public:
  using DefeComponent::DefeComponent;
  void make_grids();

  const defe::SumGrid &force_grid() const
  {
    return rounding_.force_grid();
  }    // on if reproducible
  const defe::SumGrid &torque_grid() const { return rounding_.torque_grid(); }
  defe::RoundedForces &rounding() { return rounding_; }

  /** A contribution to f[i] or torque[i], rounded to its grid if there is one. */
  double on_grid(const defe::SumGrid &grid, double value, int i)
  {
    return rounding_.on_grid(grid, value, i);
  }
  defe::Vec3 rounded_force(const defe::Vec3 &value, int i) { return rounding_.force(value, i); }
  defe::Vec3 rounded_torque(const defe::Vec3 &value, int i) { return rounding_.torque(value, i); }
  /** This atom has a force or torque that is too large. */
  void set_beyond(int i) { rounding_.set_beyond(i); }
  /** Stops if there is one; sums: those of all, after the ghosts' have arrived. */
  void check_range(bool sums);

 private:
  defe::RoundedForces rounding_;
  void note_unreproducible() const;
};

}    // namespace LAMMPS_NS

#endif
