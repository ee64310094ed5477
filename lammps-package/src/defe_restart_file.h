/* ----------------------------------------------------------------------
   DEFE: adaptive finite elements to bonded discrete elements for LAMMPS
   https://www.lammps.org/
   This software is distributed under the GNU General Public License.
------------------------------------------------------------------------- */

#ifndef LMP_DEFE_RESTART_FILE_H
#define LMP_DEFE_RESTART_FILE_H

#include <cstdio>
#include <string>

// Restart files as a whole, LAMMPS' own parts included. LAMMPS believes sizes and positions that it
// reads: of a damaged file it may hang, crash, or take all memory. So each file gets a seal behind its
// end, and DEFE checks it when LAMMPS comes to the pair style, of which it reads before all fixes and
// atoms. Of a set (% in the name) the base file's seal holds the checksums of the others.

namespace LAMMPS_NS {

/// After LAMMPS has written and closed it. Collective; stops if the file is not complete.
void seal_restart_file(class LAMMPS *lmp, const std::string &name);

/// In a pair style's settings, by rank 0: such a file has a seal.
void mark_restart_file(FILE *fp);

/// While LAMMPS reads: the mark, and the seal. Collective; fp is open on rank 0, and stays where it
/// is behind the mark. Stops if the file, or one of its set, is damaged.
void check_restart_file(class LAMMPS *lmp, FILE *fp);

}    // namespace LAMMPS_NS

#endif
