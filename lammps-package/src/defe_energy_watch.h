/* ----------------------------------------------------------------------
   DEFE: adaptive finite elements to bonded discrete elements for LAMMPS
   https://www.lammps.org/
   This software is distributed under the GNU General Public License.
------------------------------------------------------------------------- */

#ifndef LMP_DEFE_ENERGY_WATCH_H
#define LMP_DEFE_ENERGY_WATCH_H

#include "defe_component.h"

#include <string>

namespace LAMMPS_NS {

/** Watches over the balance of energies of a run. */
class DefeEnergyWatch : protected DefeComponent {
 public:
  using DefeComponent::DefeComponent;
  void prepare();    // before a run: can its balance be watched?
  void begin();      // the first step, before anything moves
  void look();       // entries that are not numbers, energy from nowhere; collective

 private:
  bool on = false, balance_known = false, told = false;
  double balance_start = 0.0, balance_last = 0.0, put_in = 0.0, swing_start = 0.0;
  std::string unseen_work() const;
  double swing() const;
};

}    // namespace LAMMPS_NS

#endif
