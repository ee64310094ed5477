/* -*- c++ -*- ----------------------------------------------------------
   DEFE: adaptive finite elements to bonded discrete elements for LAMMPS
   https://www.lammps.org/
   This software is distributed under the GNU General Public License.
------------------------------------------------------------------------- */

#ifdef FIX_CLASS
// clang-format off
FixStyle(defe/vtk,FixDefeVTK);
// clang-format on
#else

#ifndef LMP_FIX_DEFE_VTK_H
#define LMP_FIX_DEFE_VTK_H

#include "fix.h"

#include "defe_vtk_file.h"

#include "defe/coupling/vtk_series.h"

#include <map>
#include <memory>
#include <string>
#include <vector>

namespace LAMMPS_NS {

class DefeVtkKind;

/** Writes elements, spheres and joints for ParaView, from all ranks into one file per kind and step. */
class FixDefeVTK : public Fix {
 public:
  FixDefeVTK(class LAMMPS *, int, char **);
  ~FixDefeVTK() override;
  int setmask() override;
  void init() override;
  void setup(int) override;
  void end_of_step() override;
  void write_restart(FILE *) override;
  void restart(char *) override;
  int pack_forward_comm(int, int *, double *, int, int *) override;
  void unpack_forward_comm(int, int, double *) override;
  int pack_reverse_comm(int, int, double *) override;
  void unpack_reverse_comm(int, int *, double *) override;

 private:
  std::string base;    // of the names of the files
  std::string region_id;
  class Region *region = nullptr;
  std::vector<std::unique_ptr<DefeVtkKind>> kinds;
  DefeVtkKind *active = nullptr;    // whose data are communicated
  std::unique_ptr<defe::VtkSeries> series;
  std::map<std::string, VtkWritten>
      written;    // of each kind, by this fix: not that of an earlier run

  void check_base() const;
  void parse(int narg, char **arg);
  void add_kind(const std::string &name, const std::vector<std::string> &fields);
  void write();
  void stop_by_first_rank(std::string complaint) const;
};

}    // namespace LAMMPS_NS

#endif
#endif
