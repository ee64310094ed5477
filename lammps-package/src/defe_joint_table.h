/* ----------------------------------------------------------------------
   DEFE: adaptive finite elements to bonded discrete elements for LAMMPS
   https://www.lammps.org/
   This software is distributed under the GNU General Public License.
------------------------------------------------------------------------- */

#ifndef LMP_DEFE_JOINT_TABLE_H
#define LMP_DEFE_JOINT_TABLE_H

#include "defe_records.h"

namespace LAMMPS_NS {

/** The table of joints, whose records are those of the DEs of this rank. */
struct JointTable : defe::JointTable {
  DERecord *rec(int d) const { return static_cast<DERecord *>(records[d]); }
};

}    // namespace LAMMPS_NS

#endif
