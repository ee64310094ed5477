/* ----------------------------------------------------------------------
   DEFE: adaptive finite elements to bonded discrete elements for LAMMPS
   https://www.lammps.org/
   This software is distributed under the GNU General Public License.
------------------------------------------------------------------------- */

#include "defe_joint_table.h"

#include <algorithm>

using namespace LAMMPS_NS;

void JointTable::clear()
{
  nde = north = nall = 0;
  self.clear();
  of_atom.clear();
  rec.clear();
  nb.clear();
  partner.clear();
  present.clear();
  area.clear();
  tie_element.clear();
  tie_part.clear();
  apart.clear();
  len.clear();
  half.clear();
  material.clear();
  cell.clear();
  half_force.clear();
  energy.clear();
  state.clear();
  tie_node.clear();
  tie_point.clear();
  cohesive.clear();
  debonded.clear();
  asking.clear();
  newborn.clear();
  pending.clear();
}

double JointTable::distance_apart(int d, tagint other) const
{
  auto found = std::lower_bound(apart.begin(), apart.end(), d, [](const Apart &a, int de) {
    return a.de < de;
  });
  for (; found != apart.end() && found->de == d; ++found)
    if (found->other == other) return found->distance;
  return 0.0;
}

bool JointTable::tied(int atom, tagint element) const
{
  const int d = of_atom[atom];
  for (int s = 0; s < 6; s++)
    if (nb[d][s] < 0 && tie_element[~nb[d][s]] == element && state[6 * d + s] != DefeJoint::CONTACT)
      return true;
  return false;
}
