/* -*- c++ -*- ----------------------------------------------------------
   DEFE: adaptive finite elements to bonded discrete elements for LAMMPS
   https://www.lammps.org/
   This software is distributed under the GNU General Public License.
------------------------------------------------------------------------- */

#ifdef COMPUTE_CLASS
// clang-format off
ComputeStyle(defe/hex/local,ComputeDefeHexLocal);
// clang-format on
#else

#ifndef LMP_COMPUTE_DEFE_HEX_LOCAL_H
#define LMP_COMPUTE_DEFE_HEX_LOCAL_H

#include "compute.h"

#include <vector>

namespace LAMMPS_NS {

class ComputeDefeHexLocal : public Compute {
 public:
  ComputeDefeHexLocal(class LAMMPS *, int, char **);
  ~ComputeDefeHexLocal() override;
  void init() override;
  void compute_local() override;
  double memory_usage() override;

 private:
  enum Quantity {
    ID,
    PART,
    X,
    Y,
    Z,
    SXX,
    SYY,
    SZZ,
    SXY,
    SXZ,
    SYZ,
    S1,
    VONMISES,
    STRENGTH,
    PLASTIC,
    HEATING
  };
  std::vector<Quantity> what;
  int nmax = 0;
  struct DefeSystem *sys = nullptr;
};

}    // namespace LAMMPS_NS

#endif
#endif
