/* ----------------------------------------------------------------------
   DEFE: adaptive finite elements to bonded discrete elements for LAMMPS
   https://www.lammps.org/
   This software is distributed under the GNU General Public License.
------------------------------------------------------------------------- */

#ifndef LMP_DEFE_VTK_FILE_H
#define LMP_DEFE_VTK_FILE_H

#include "defe/coupling/vtk_grid.h"

#include <mpi.h>

#include <cstddef>
#include <map>
#include <string>
#include <string_view>

namespace LAMMPS_NS {

/** Package whose lack lets this build write no such files, or null: it can. */
const char *vtk_files_need();

/** Where the data sets of a series are that its next file may refer to: each as it was written last. */
class VtkWritten {
 public:
  /** \param data  of this rank. True: the last file of this data set has just the same. */
  bool has(const std::string &path, std::string_view data) const;
  const std::string &file_of(const std::string &path) const { return sets.at(path).file; }
  void keep(const std::string &path, std::string_view data, const std::string &file);

 private:
  struct Set {
    std::size_t size, hash;    // 64 bits: the data itself would be as much as all elements take
    std::string file;
  };
  std::map<std::string, Set> sets;
};

/** The grids of all ranks as one file of VTKHDF 1.0, which is replaced if it is there; all ranks call it, and all
    have the same fields. A data set that did not change since it was written last is an external link to it: VTK and
    ParaView read through it. What is wrong, the same on all ranks, or "". */
std::string write_vtk_file(const std::string &file, const defe::VtkGrid &, VtkWritten &, MPI_Comm);

}    // namespace LAMMPS_NS

#endif
