/* ----------------------------------------------------------------------
   DEFE: adaptive finite elements to bonded discrete elements for LAMMPS
   https://www.lammps.org/
   This software is distributed under the GNU General Public License.
------------------------------------------------------------------------- */

#ifndef LMP_DEFE_VTK_FILE_H
#define LMP_DEFE_VTK_FILE_H

#include "defe/coupling/vtk_grid.h"

#include <mpi.h>

#include <string>

namespace LAMMPS_NS {

/** Package whose lack lets this build write no such files, or null: it can. */
const char *vtk_files_need();

/** The grids of all ranks as one file of VTKHDF 1.0, which is replaced if it is there; all ranks call it, and all
    have the same fields. What is wrong, the same on all ranks, or "". */
std::string write_vtk_file(const std::string &file, const defe::VtkGrid &, MPI_Comm);

}    // namespace LAMMPS_NS

#endif
