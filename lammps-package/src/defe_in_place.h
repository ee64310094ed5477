/* ----------------------------------------------------------------------
   DEFE: adaptive finite elements to bonded discrete elements for LAMMPS
   https://www.lammps.org/
   This software is distributed under the GNU General Public License.
------------------------------------------------------------------------- */

#ifndef LMP_DEFE_IN_PLACE_H
#define LMP_DEFE_IN_PLACE_H

#include "defe_component.h"

#include <unordered_map>
#include <vector>

namespace LAMMPS_NS {

class Fix;

/** Conversions without a reneighbouring, which takes passes over all atoms while a few of them change. Atoms come and go between
    the local ones and the ghosts, and what LAMMPS knows by their indices follows: its map, its lists of what goes to other
    ranks, its positions at the last reneighbouring. Only far from the borders of sub-domains, where no other rank knows
    these atoms, and only if nobody has lists of neighbours. */
class DefeInPlace : protected DefeComponent {
 public:
  using DefeComponent::DefeComponent;

  /** Before a run. */
  void look_at_commands();
  /** No set-up command of LAMMPS forbids it. */
  bool allowed() const { return allowed_; }
  /** The elements that are marked now can convert so; collective. */
  bool possible();

  // one conversion, in this order

  void begin();
  bool going_on() const { return going_on_; }
  /** A node goes, while it is still at its place; and the last local atom has been copied to a place that is free now. */
  void remove(tagint);
  void moved(int from, int to);
  /** Room for n atoms in arrays of them that grow with each conversion: growing is a pass over all atoms. */
  static int roomy(int n) { return n + n / 16; }
  /** All that go have gone: ghosts make room for so many DEs. */
  void make_room(int born);
  void add(int i);                        // a DE, with its ID
  int shift() const { return shift_; }    // of ghosts
  /** Makes those of all fixes of this package anew. */
  void make_tables();
  /** While they are made: this node may be in contact from now on. */
  void watch(int i);
  void end() { going_on_ = false; }

  /** What the tables must allow for, as they are made at the positions of now: how much nearer two atoms may come until they are
      made again, a little more than the skin. */
  double slack() const;

 private:
  bool allowed_ = false, going_on_ = false;
  bool moved_too_far = false;
  std::vector<Fix *> ours;    // that have tables
  int listed = 0;             // local atoms before
  int shift_ = 0;
  std::unordered_map<int, int> place_before;    // of atoms that were moved, by where they are

  std::vector<int> gone_on;    // have moved farther, where no other rank needs to know
  /** more: by so much farther; also from borders of the box. */
  bool away_from_borders(int i, double more) const;
  bool near_last_place(int i);
  void see_again();
  bool hardly_moved();
  void shift_ghosts(int by);
  void shift_messages(int by);
};

}    // namespace LAMMPS_NS

#endif
