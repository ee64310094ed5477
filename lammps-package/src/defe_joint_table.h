/* ----------------------------------------------------------------------
   DEFE: adaptive finite elements to bonded discrete elements for LAMMPS
   https://www.lammps.org/
   This software is distributed under the GNU General Public License.
------------------------------------------------------------------------- */

#ifndef LMP_DEFE_JOINT_TABLE_H
#define LMP_DEFE_JOINT_TABLE_H

#include "defe_records.h"

namespace LAMMPS_NS {

/** The table of joints with the records of the DEs of this rank. */
struct JointTable : defe::JointTable {
  std::vector<DERecord *> rec;
  void add(DERecord *r)
  {
    rec.push_back(r);
    add_records(&r->slot[0], sizeof(JointSlot));
  }
  void clear()
  {
    defe::JointTable::clear();
    rec.clear();
  }
};

}    // namespace LAMMPS_NS

#endif
