/* ----------------------------------------------------------------------
   DEFE: adaptive finite elements to bonded discrete elements for LAMMPS
   https://www.lammps.org/
   This software is distributed under the GNU General Public License.
------------------------------------------------------------------------- */

#ifndef LMP_DEFE_JOINT_TABLE_H
#define LMP_DEFE_JOINT_TABLE_H

#include "defe_records.h"

#include <array>
#include <vector>

namespace LAMMPS_NS {

/** Local indices of the DEs of this rank and of its ghosts, and of their joints and ties. Made anew
    with the neighbour lists. */
struct JointTable {
  int nde = 0;                 // owned DEs
  int north = 0;               // of these, the first ones have orthogonal cells
  int nall = 0;                // owned and ghost DEs
  std::vector<int> self;       // atom index
  std::vector<int> of_atom;    // DE of an atom, -1 = none
  std::vector<DERecord *> rec;
  std::vector<std::array<int, 6>> nb;         // atom index, or ~(index of tie point)
  std::vector<std::array<int, 6>> partner;    // 6 * (DE index) + slot, -1 = none
  std::vector<unsigned char> present;         // bit per slot: acts in the corner strains
  std::vector<std::array<double, 6>> len, half;
  std::vector<unsigned char> material;
  std::vector<defe::GeneralCell> cell;    // of the DEs from north on
  std::vector<std::array<double, 18>> half_force;
  std::vector<double> energy;
  std::vector<unsigned char> state;    // 6 per DE, owned and ghost
  std::vector<std::array<double, 6>> area;
  std::vector<std::array<int, 4>> tie_node;    // per tie, as the next two
  std::vector<tagint> tie_element;
  std::vector<signed char> tie_part;
  std::vector<double> tie_point;
  struct Apart {
    int de;
    tagint other;
    double distance;
  };
  std::vector<Apart> apart;    // JointSlot::apart, where there is one; by DE
  double distance_apart(int d, tagint other) const;
  /** A DE has no contact with an element that it is tied to. */
  bool tied(int atom, tagint element) const;
  std::vector<int> pending;     // 6 * DE + slot of the joints that switch in the next step
  std::vector<int> newborn;     // DEs whose first force evaluation is to come
  std::vector<int> cohesive;    // 6 * DE + slot of the cohesive joints and ties that I compute
  std::vector<int> debonded;    // 6 * DE + slot of the ties that broke in this step
  std::vector<int> asking;      // 6 * DE + slot of the ties with JointSlot::asks
  void clear();
};

}    // namespace LAMMPS_NS

#endif
