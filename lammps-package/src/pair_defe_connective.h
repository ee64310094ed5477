/* -*- c++ -*- ----------------------------------------------------------
   DEFE: adaptive finite elements to bonded discrete elements for LAMMPS
   https://www.lammps.org/
   This software is distributed under the GNU General Public License.
------------------------------------------------------------------------- */

#ifdef PAIR_CLASS
// clang-format off
PairStyle(defe/connective,PairDefeConnective);
// clang-format on
#else

#ifndef LMP_PAIR_DEFE_CONNECTIVE_H
#define LMP_PAIR_DEFE_CONNECTIVE_H

#include "pair_defe_joint.h"

namespace LAMMPS_NS {

/** Joints that never break, and no contact. */
class PairDefeConnective : public PairDefeJoint {
 public:
  PairDefeConnective(class LAMMPS *lmp) : PairDefeJoint(lmp)
  {
    laws.with_cohesive = laws.with_contact = false;
  }
};

}    // namespace LAMMPS_NS

#endif
#endif
