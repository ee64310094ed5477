/* ----------------------------------------------------------------------
   DEFE: adaptive finite elements to bonded discrete elements for LAMMPS
   https://www.lammps.org/
   This software is distributed under the GNU General Public License.
------------------------------------------------------------------------- */

#ifndef LMP_DEFE_ACCOUNT_H
#define LMP_DEFE_ACCOUNT_H

#include "defe_component.h"

#include "defe/coupling/ledger.h"

namespace LAMMPS_NS {

/** The vector of the fix: energies and counts of all ranks. */
class DefeAccount : protected DefeComponent {
 public:
  /** What restart files keep. */
  struct State {
    double conversion, damage;    // times of the first of either kind
  };

  using DefeComponent::DefeComponent;
  /** The values of this step, computed once; collective. */
  const defe::EntryValues &values();
  /** The same without the largest stress (0), for which elements are looked at one by one. */
  const defe::EntryValues &energies();
  double scalar();    // elastic energy of elements and surface contact
  void forget() { step = -1; }
  /** Between runs the values are those of the last one. */
  void end_run();
  /** A run goes on, and tables are made. */
  void begin_run() { between_runs = false; }

  void note_damage();
  void note_conversion();

  void pack(State &) const;    // collective
  void unpack(const State &s) { first = s; }

 private:
  State first{-1.0, -1.0};
  defe::EntryValues vector{};
  double surface_energy = 0.0;
  bigint step = -1;
  bool between_runs = false;    // and there was one
  void fill(bool with_stress);
  void first_times(double times[2]) const;
  void count_joints_and_motion(defe::EntryValues &);
};

}    // namespace LAMMPS_NS

#endif
