/* -*- c++ -*- ----------------------------------------------------------
   DEFE: adaptive finite elements to bonded discrete elements for LAMMPS
   https://www.lammps.org/
   This software is distributed under the GNU General Public License.
------------------------------------------------------------------------- */

#ifdef PAIR_CLASS
// clang-format off
PairStyle(defe/contact,PairDefeContact);
// clang-format on
#else

#ifndef LMP_PAIR_DEFE_CONTACT_H
#define LMP_PAIR_DEFE_CONTACT_H

#include "pair_defe_joint.h"

namespace LAMMPS_NS {

/** Contact alone. */
class PairDefeContact : public PairDefeJoint {
 public:
  PairDefeContact(class LAMMPS *lmp) : PairDefeJoint(lmp)
  {
    laws.with_connective = laws.with_cohesive = false;
  }
};

}    // namespace LAMMPS_NS

#endif
#endif
