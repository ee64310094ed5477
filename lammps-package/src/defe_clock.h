/* ----------------------------------------------------------------------
   DEFE: adaptive finite elements to bonded discrete elements for LAMMPS
   https://www.lammps.org/
   This software is distributed under the GNU General Public License.
------------------------------------------------------------------------- */

#ifndef LMP_DEFE_CLOCK_H
#define LMP_DEFE_CLOCK_H

#include "defe_component.h"

#include "defe/coupling/subcycle.h"

namespace LAMMPS_NS {

/** Time and step at which the last one ended, and the clock of the finite elements. */
class DefeClock : protected DefeComponent {
 public:
  using DefeComponent::DefeComponent;
  double now() const;    // simulated time
  defe::Subcycle &subcycle() { return subcycle_; }
  const defe::Subcycle &subcycle() const { return subcycle_; }

  double time() const { return time_; }
  bigint last_step() const { return last_step_; }
  void begin() { time_ = now(); }
  void step_done();
  void restarted_at(bigint step) { last_step_ = step; }
  /** The clock may have been put back or forward since the last step (reset_timestep). */
  void follow(bigint step);

 private:
  defe::Subcycle subcycle_;
  double time_ = 0.0;
  bigint last_step_ = -1;
};

}    // namespace LAMMPS_NS

#endif
