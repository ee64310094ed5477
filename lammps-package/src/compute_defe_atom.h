/* -*- c++ -*- ----------------------------------------------------------
   DEFE: adaptive finite elements to bonded discrete elements for LAMMPS
   https://www.lammps.org/
   This software is distributed under the GNU General Public License.
------------------------------------------------------------------------- */

#ifdef COMPUTE_CLASS
// clang-format off
ComputeStyle(defe/atom,ComputeDefeAtom);
// clang-format on
#else

#ifndef LMP_COMPUTE_DEFE_ATOM_H
#define LMP_COMPUTE_DEFE_ATOM_H

#include "compute.h"

#include <array>
#include <string>
#include <vector>

namespace LAMMPS_NS {

class ComputeDefeAtom : public Compute {
 public:
  ComputeDefeAtom(class LAMMPS *, int, char **);
  ~ComputeDefeAtom() override;
  void init() override;
  void compute_peratom() override;
  int pack_reverse_comm(int, int, double *) override;
  void unpack_reverse_comm(int, int *, double *) override;
  double memory_usage() override;

 private:
  enum Quantity {
    DAMAGE,
    CONNECTIVE,
    COHESIVE,
    CONTACT,
    TIES,
    ELEMENT,
    ELEMENTS,
    STRENGTH,
    VONMISES,
    S1
  };
  std::vector<Quantity> what;
  bool stresses = false;
  int nmax = 0;
  struct DefeSystem *sys = nullptr;
  double **sum = nullptr;    // 6 stresses and the number of elements of each node
  void grow();
  void add_stresses();
  std::array<int, 4> joints_of(int i) const;
  double value_of(Quantity, int i, const std::array<int, 4> &joints) const;
  double stress_of(Quantity, int i) const;
};

}    // namespace LAMMPS_NS

#endif
#endif
