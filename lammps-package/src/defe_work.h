/* ----------------------------------------------------------------------
   DEFE: adaptive finite elements to bonded discrete elements for LAMMPS
   https://www.lammps.org/
   This software is distributed under the GNU General Public License.
------------------------------------------------------------------------- */

#ifndef LMP_DEFE_WORK_H
#define LMP_DEFE_WORK_H

#include "defe_component.h"

#include <vector>

namespace LAMMPS_NS {

/** Work that the forces of other fixes do on atoms of the account. */
class DefeWork : protected DefeComponent {
 public:
  using DefeComponent::DefeComponent;

  /** Does this atom count in the kinetic energy of the account, and the work of other fixes on it as external work?
      Balls do if they are in the group and meet anything of ours. */
  bool in_account(int i) const;
  double kinetic_energy(int i) const;

  void find_forced_groups();
  void list_forced();    // with the neighbour lists, before DefeStore::settle()
  /** Up to here all forces are those of DEFE. */
  void keep_internal();
  /** True if it is the first one after a setup. */
  bool begin_step();
  /** Half a kick before the positions, and one after. */
  void first_half();
  void second_half();
  void after_setup() { setup = true; }
  /** A setup came last: this is the first step of a run, or there is none yet. */
  bool after_setup_only() const { return setup; }

  /** Owned atoms that other fixes may put forces on, and of the q-th one force and torque before that. */
  const std::vector<int> &forced() const { return forced_; }
  const double *internal(size_t q) const { return &f_internal[6 * q]; }

 private:
  std::vector<int> forced_;
  std::vector<double> f_internal;
  int forced_bits = 0;    // groups of these atoms
  double external_power = 0.0;
  bool setup = false;
  double power_of_others() const;
  int groups_forced() const;
};

}    // namespace LAMMPS_NS

#endif
