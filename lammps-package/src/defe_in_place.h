/* ----------------------------------------------------------------------
   DEFE: adaptive finite elements to bonded discrete elements for LAMMPS
   https://www.lammps.org/
   This software is distributed under the GNU General Public License.
------------------------------------------------------------------------- */

#ifndef LMP_DEFE_IN_PLACE_H
#define LMP_DEFE_IN_PLACE_H

#include "defe_border_swaps.h"
#include "defe_component.h"

#include <unordered_map>
#include <unordered_set>
#include <vector>

namespace LAMMPS_NS {

class Fix;
struct DefeBatch;

/** Conversions without a reneighbouring, which takes passes over all atoms while a few of them change. Atoms come and go between
    the local ones and the ghosts, and what LAMMPS knows by their indices follows: its map, its lists of what goes to other
    ranks, its positions at the last reneighbouring; near borders of sub-domains its ghosts, too, and DEs go to the rank that they
    belong to (defe_border_swaps.h). Only if nobody has lists of neighbours. */
class DefeInPlace : protected DefeComponent {
 public:
  explicit DefeInPlace(DefeSystem &);

  /** Before a run. */
  void look_at_commands();
  /** No set-up command of LAMMPS forbids it. */
  bool allowed() const { return allowed_; }
  /** The elements that are marked now can convert so; collective. */
  bool possible();

  // one conversion, in this order

  void begin();
  bool going_on() const { return going_on_; }
  /** Something that converts is a ghost of some rank, or has images. */
  bool at_border() const { return at_border_; }
  /** A node goes, while it is still at its place; and the last local atom has been copied to a place that is free now. */
  void remove(int i);
  void moved(int from, int to);
  /** Room for n atoms in arrays of them that grow with each conversion: growing is a pass over all atoms. */
  static int roomy(int n) { return n + n / 16; }
  /** All that go have gone: ghosts make room for so many DEs, which become the last local atoms. */
  void make_room(int births);
  /** They have: LAMMPS learns of them, and other ranks of what has gone and come. */
  void tell();
  /** Where a ghost is now; -1: it has gone. */
  int place_of_ghost(int before) const
  {
    return at_border_ ? swaps.place_of(before - listed) : before + ghosts_at - listed;
  }
  /** Makes those of all fixes of this package anew. */
  void make_tables();
  /** While they are made: this node may be in contact from now on. */
  void watch(int i);
  void end() { going_on_ = false; }

  /** What the tables must allow for, as they are made at the positions of now: how much nearer two atoms may come until they are
      made again, a little more than the skin. */
  double slack() const;

 private:
  DefeBorderSwaps swaps;
  bool allowed_ = false, going_on_ = false, at_border_ = false;
  bool leaving = false;    // some DE belongs to another rank than its element
  bool moved_too_far = false;
  std::vector<Fix *> ours;                      // that have tables
  int listed = 0;                               // local atoms before
  int first_born = 0;                           // index of the first DE
  int ghosts_at = 0;                            // of the first ghost, now
  std::unordered_map<int, int> place_before;    // of atoms that were moved, by where they are
  std::unordered_set<int> gone;                 // places before

  std::vector<int> gone_on;    // have moved farther, where no other rank needs to know
  /** more: by so much farther; also from borders of the box. */
  bool away_from_borders(int i, double more) const;
  bool borders_can_change() const;
  bool births_stay(const DefeBatch &, int e) const;
  bool thin() const;
  bool near_last_place(int i);
  void see_again();
  bool hardly_moved();
  int take_place_before(int i);
  void update_messages();
  void shift_ghosts(int to);
  void shift_in_map();
  void take_in(std::vector<double> &&atoms);
};

}    // namespace LAMMPS_NS

#endif
