/* ----------------------------------------------------------------------
   DEFE: adaptive finite elements to bonded discrete elements for LAMMPS
   https://www.lammps.org/
   This software is distributed under the GNU General Public License.
------------------------------------------------------------------------- */

#ifndef LMP_DEFE_BORDER_SWAPS_H
#define LMP_DEFE_BORDER_SWAPS_H

#include "defe_component.h"

#include <vector>

namespace LAMMPS_NS {

class CommBrick;

/** A few atoms near borders of sub-domains have gone and come: what each swap of LAMMPS' ghosts sends and receives is edited, and
    ghosts make room for each other, instead of being made anew. A message tells which entries of the last list have gone, and has the
    atoms that are new in it. Of comm_style brick only. */
class DefeBorderSwaps : protected DefeComponent {
 public:
  using DefeComponent::DefeComponent;

  /** An entry of LAMMPS' lists of sent atoms whose atom has gone. */
  static constexpr int GONE = -1;

  /** Ghosts, from this index on, are about to move in memory: LAMMPS' map knows of none of them until edit() is done. */
  void forget_ghosts(int first);
  /** Local atoms from index `first` on that belong to other ranks leave; what they have is sent there.
      \return those of other ranks that belong to this one, as AtomVec::pack_exchange() packs them. Collective. */
  std::vector<double> send_home(int first);
  /** Whether an atom at this place does. */
  bool is_other_ranks(const double *x) const;
  /** \param born   index of the first local atom that no list has yet
      \param wider  atoms may have moved by so much since lists were made: what is new is sent from as much farther
      Collective. */
  void edit(int born, double wider);
  /** Index of a ghost that was there before, by its number; -1: it has gone. */
  int place_of(int ghost) const { return now[ghost]; }

 private:
  CommBrick *brick = nullptr;
  struct New {
    int first, count;    // ghosts that have come, in the order of swaps
  };
  std::vector<char> gone;    // by ghost before
  std::vector<int> now;      // index of each ghost, those that have come behind those before
  std::vector<New> came;     // by swap
  std::vector<std::vector<int>> lists;
  int ghosts = 0, ghosts_came = 0;

  bool is_mine(double x, int dim) const;
  std::vector<double> pass_on(const std::vector<double> &, int to, int from) const;
  void exchange(int swap, std::vector<int> &add);
  void arrange();
  void enter_in_map(const std::vector<tagint> &ids_gone);
};

}    // namespace LAMMPS_NS

#endif
