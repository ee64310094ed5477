/* -*- c++ -*- ----------------------------------------------------------
   DEFE: adaptive finite elements to bonded discrete elements for LAMMPS
   https://www.lammps.org/
   This software is distributed under the GNU General Public License.
------------------------------------------------------------------------- */

#ifdef COMPUTE_CLASS
// clang-format off
ComputeStyle(defe/fragment/atom,ComputeDefeFragmentAtom);
// clang-format on
#else

#ifndef LMP_COMPUTE_DEFE_FRAGMENT_ATOM_H
#define LMP_COMPUTE_DEFE_FRAGMENT_ATOM_H

#include "compute.h"

#include <cstdint>
#include <string>
#include <vector>

namespace defe {
class DisjointSets;
}

namespace LAMMPS_NS {

class ComputeDefeFragmentAtom : public Compute {
 public:
  ComputeDefeFragmentAtom(class LAMMPS *, int, char **);
  ~ComputeDefeFragmentAtom() override;
  void init() override;
  void compute_peratom() override;
  void compute_vector() override;
  int pack_forward_comm(int, int *, double *, int, int *) override;
  void unpack_forward_comm(int, int, double *) override;
  int pack_reverse_comm(int, int, double *) override;
  void unpack_reverse_comm(int, int *, double *) override;
  double memory_usage() override;

 private:
  std::vector<std::string> part_names;    // none = all
  std::vector<char> selected;             // by part
  struct DefeSystem *sys = nullptr;
  double *fragment = nullptr;
  int nmax = 0;

  // nothing is done as long as no joint breaks and no table is made anew
  bigint labelled_tables = -1, labelled_first = -1, labelled_broken = -1;
  bool up_to_date() const;

  // of owned and ghost atoms, while labels are made
  enum Comm { MASK, ACTIVE, LABEL, SHARED } comm_mode = ACTIVE;
  std::vector<char> active;    // takes part
  std::vector<char> shared;    // its fragment has atoms of other ranks
  std::vector<std::int64_t> label, owner_label;

  int local_of(tagint) const;
  bool takes_part(const struct HexPod &, int *node) const;
  void label_fragments();
  void find_active();
  void join(defe::DisjointSets &);
  std::vector<std::int64_t> merged_labels(defe::DisjointSets &);
  void sum_up(defe::DisjointSets &, const std::vector<std::int64_t> &whole);
};

}    // namespace LAMMPS_NS

#endif
#endif
