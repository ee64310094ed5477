/* ----------------------------------------------------------------------
   DEFE: adaptive finite elements to bonded discrete elements for LAMMPS
   https://www.lammps.org/
   This software is distributed under the GNU General Public License.
------------------------------------------------------------------------- */

#ifndef LMP_DEFE_IDS_H
#define LMP_DEFE_IDS_H

#include "defe_component.h"

#include <vector>

namespace LAMMPS_NS {

/** IDs of DEs, and of atoms that others insert, which must not be theirs. */
class DefeIds : protected DefeComponent {
 public:
  /** What restart files keep. */
  struct State {
    tagint base, last_element, last_id, last_born;
    bigint lots_moved;
  };

  using DefeComponent::DefeComponent;
  /** Index of an atom, -1 if it is not here. */
  int local_of(tagint) const;
  /** Of its images the one nearest to atom i. */
  int nearest_to(int i, tagint) const;
  /** The DEs of an element have the IDs of one lot, by their places: that with the number of the element, as
      long as no other atoms have come; see deal_lots(). */
  tagint de_tag(tagint lot, int place) const;
  tagint base() const { return now.base; }

  /** IDs follow those of all atoms and elements that there are; collective. */
  void begin();
  /** Lots for the elements of this rank that convert now, given by ID; collective. */
  std::vector<tagint> deal_lots(const std::vector<tagint> &elements);
  /** No DE has a higher ID after so many elements have converted, of which this is the last one; collective. */
  bigint highest_born(tagint last_element, bigint elements);

  void forget_newcomers();
  void set_natoms(bigint n) { natoms_known = n; }
  bool natoms_changed() const;
  void giving_birth(bool yes) { birth = yes; }
  bool giving_birth() const { return birth; }
  /** A fix has just inserted this atom. */
  void register_newcomer(int i);
  void check_newcomers();

  /** After DEs were born, the last so many of the local atoms, and with the map empty; collective. */
  void make_room_in_map(int born);

  void pack(State &s) const { s = now; }
  void unpack(const State &s) { now = s; }

 private:
  // DEs have the IDs above base; lots are dealt in the order of birth once they have moved
  State now{};
  bool birth = false;
  bigint natoms_known = -1;                  // at the last reneighbouring
  bool looked = false;                       // at all atoms of this rank
  std::vector<tagint> doubtful_newcomers;    // IDs of inserted atoms that a DE may have

  tagint last_de() const;
  void look_at_all();    // collective
  bigint last_lot_in_use() const;
  bigint deal_behind_all(const std::vector<tagint> &elements, std::vector<tagint> &lots) const;
};

}    // namespace LAMMPS_NS

#endif
