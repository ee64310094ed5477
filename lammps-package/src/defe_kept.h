/* ----------------------------------------------------------------------
   DEFE: adaptive finite elements to bonded discrete elements for LAMMPS
   https://www.lammps.org/
   This software is distributed under the GNU General Public License.
------------------------------------------------------------------------- */

#ifndef LMP_DEFE_KEPT_H
#define LMP_DEFE_KEPT_H

#include "defe_component.h"
#include "defe_store.h"

#include <cstdint>
#include <vector>

namespace LAMMPS_NS {

/** Runs in pieces: the forces of the last step are kept, and the next setup takes them if nothing was
    changed in between. */
class DefeKept : protected DefeComponent, public DefeField {
 public:
  /** What restart files keep. */
  struct State {
    bigint step, natoms;
    uint64_t law;
  };

  using DefeComponent::DefeComponent;
  void keep();
  void drop();
  /** At a setup: takes them if they belong to the present step and settings. */
  void take();

  bool running() const { return running_; }    // between the first step of a run and its end
  void begin_run();    // the first step of one, for which there may have been no setup
  void end_run() { running_ = false; }
  /** LAMMPS was initialized, which may move atoms to other ranks. */
  void initialized() { needs_setup = true; }
  void set_up() { needs_setup = false; }
  /** The clock was set to `step`. */
  void follow(bigint last_step, bigint step);

  /** Checksum of the settings that forces depend on. */
  uint64_t laws() const;

  void pack(State &s) const { s = now; }
  void unpack(const State &s) { now = s; }
  double memory_usage() const;

  // ---- by atom ----

  void clear(int i);
  void grow(int n) override;
  void move(int from, int to) override;
  int size(int i) const override { return has(i) ? 1 + SIZE : 1; }
  int pack(int i, double *buf) const override;
  int unpack(int i, const double *buf) override;
  int most() const override { return kept.empty() ? 1 : 1 + SIZE; }

 private:
  /** The forces on an atom at the end of a run, for a next one that goes on from there. */
  struct Forces {
    double x[3];    // unwrapped
    double f[3], torque[3];
    uint64_t motion = 0;    // checksum of velocity, spin, radius, mass and type
  };
  static constexpr int SIZE = doubles_of(sizeof(Forces));
  std::vector<Forces> kept;    // by atom; empty while a run goes on
  int room = 0;
  State now{-1, 0, 0};
  bool running_ = false, needs_setup = false;

  bool has(int i) const { return !kept.empty() && kept[i].motion != 0; }
  uint64_t motion_of(int i) const;
  bool places_are_those() const;
};

}    // namespace LAMMPS_NS

#endif
