/* -*- c++ -*- ----------------------------------------------------------
   DEFE: adaptive finite elements to bonded discrete elements for LAMMPS
   https://www.lammps.org/
   This software is distributed under the GNU General Public License.
------------------------------------------------------------------------- */

#ifdef COMPUTE_CLASS
// clang-format off
ComputeStyle(defe/joint/local,ComputeDefeJointLocal);
// clang-format on
#else

#ifndef LMP_COMPUTE_DEFE_JOINT_LOCAL_H
#define LMP_COMPUTE_DEFE_JOINT_LOCAL_H

#include "compute.h"

#include "pair_defe_joint.h"

#include <vector>

namespace LAMMPS_NS {

class ComputeDefeJointLocal : public Compute {
 public:
  ComputeDefeJointLocal(class LAMMPS *, int, char **);
  ~ComputeDefeJointLocal() override;
  void init() override;
  void compute_local() override;
  int pack_forward_comm(int, int *, double *, int, int *) override;
  void unpack_forward_comm(int, int, double *) override;
  double memory_usage() override;

 private:
  enum Quantity {
    ID1,
    ID2,
    ATOM2,
    KIND,
    STATE,
    PART,
    DAMAGE,
    OPENING,
    SLIP,
    TN,
    TS,
    X,
    Y,
    Z,
    NX,
    NY,
    NZ,
    AREA,
    LENGTH,
    LENGTH0
  };
  std::vector<Quantity> what;
  bool views = false;    // the output needs more than the records hold
  int nmax = 0;
  struct DefeSystem *sys = nullptr;
  PairDefeJoint *pair = nullptr;
  bool counts(int d, int s) const;
  void grow(int n);
  double value_of(Quantity, int d, int s, const defe::JointView &) const;
  double value_of_tied(Quantity, int d, int s, const defe::JointView &) const;
};

}    // namespace LAMMPS_NS

#endif
#endif
