/* -*- c++ -*- ----------------------------------------------------------
   DEFE: adaptive finite elements to bonded discrete elements for LAMMPS
   https://www.lammps.org/
   This software is distributed under the GNU General Public License.
------------------------------------------------------------------------- */

#ifdef PAIR_CLASS
// clang-format off
PairStyle(defe/cohesive,PairDefeCohesive);
// clang-format on
#else

#ifndef LMP_PAIR_DEFE_COHESIVE_H
#define LMP_PAIR_DEFE_COHESIVE_H

#include "pair_defe_joint.h"

namespace LAMMPS_NS {

/** Joints that soften and break, and no contact. */
class PairDefeCohesive : public PairDefeJoint {
 public:
  PairDefeCohesive(class LAMMPS *lmp) : PairDefeJoint(lmp) { laws.with_contact = false; }
};

}    // namespace LAMMPS_NS

#endif
#endif
