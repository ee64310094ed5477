/* -*- c++ -*- ----------------------------------------------------------
   DEFE: adaptive finite elements to bonded discrete elements for LAMMPS
   https://www.lammps.org/
   This software is distributed under the GNU General Public License.
------------------------------------------------------------------------- */

#ifdef FIX_CLASS
// clang-format off
FixStyle(defe,FixDefe);
// clang-format on
#else

#ifndef LMP_FIX_DEFE_H
#define LMP_FIX_DEFE_H

#include "fix.h"

#include <memory>

namespace LAMMPS_NS {

struct DefeSystem;

/** The hooks of a step, in their order; what happens in them is in the parts of DefeSystem. */
class FixDefe : public Fix {
 public:
  FixDefe(class LAMMPS *, int, char **);
  ~FixDefe() override;
  int setmask() override;
  void init() override;
  void setup_pre_exchange() override;
  void setup_pre_neighbor() override { pre_neighbor(); }
  void setup_pre_reverse(int eflag, int vflag) override { pre_reverse(eflag, vflag); }
  void setup(int) override;
  void min_pre_neighbor() override { pre_neighbor(); }
  void min_pre_reverse(int eflag, int vflag) override { pre_reverse(eflag, vflag); }
  void initial_integrate(int) override;
  void post_integrate() override;
  void pre_exchange() override;
  void min_pre_exchange() override;
  void pre_neighbor() override;
  void pre_reverse(int, int) override;
  void post_force(int) override;
  void end_of_step() override;
  void reset_dt() override;
  void post_run() override;

  void grow_arrays(int) override;
  void copy_arrays(int, int, int) override;
  void set_arrays(int) override;
  int pack_exchange(int, double *) override;
  int unpack_exchange(int, double *) override;
  int pack_restart(int, double *) override;
  void unpack_restart(int, int) override;
  int size_restart(int) override;
  int maxsize_restart() override;
  void write_restart(FILE *) override;
  void write_restart_file(const char *) override;
  void restart(char *) override;

  int pack_forward_comm(int, int *, double *, int, int *) override;
  void unpack_forward_comm(int, int, double *) override;
  int pack_reverse_comm(int, int, double *) override;
  void unpack_reverse_comm(int, int *, double *) override;

  void read_data_header(char *) override;
  void read_data_section(char *, int, char *, tagint) override;
  bigint read_data_skip_lines(char *) override;
  void write_data_header(FILE *, int) override;
  void write_data_section_size(int, int &, int &) override;
  void write_data_section_pack(int, double **) override;
  void write_data_section_keyword(int, FILE *) override;
  void write_data_section(int, FILE *, int, double **, int) override;

  double compute_scalar() override;
  double compute_vector(int) override;
  int image(int *&, double **&) override;
  void *extract(const char *, int &) override;
  double memory_usage() override;

 private:
  const std::unique_ptr<DefeSystem> system;
  DefeSystem &sys;

  void check_commands(int narg);
  void set_flags();
  void check_rerun();
  void init_computes_of_mass();
};

}    // namespace LAMMPS_NS

#endif
#endif
