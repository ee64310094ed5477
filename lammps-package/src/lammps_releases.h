/* -*- c++ -*- ----------------------------------------------------------
   DEFE: adaptive finite elements to bonded discrete elements for LAMMPS
   https://www.lammps.org/
   This software is distributed under the GNU General Public License.

   What differs between the releases of LAMMPS that DEFE compiles with.
------------------------------------------------------------------------- */

#ifndef LMP_DEFE_LAMMPS_RELEASES_H
#define LMP_DEFE_LAMMPS_RELEASES_H

#include "domain.h"
#include "pointers.h"

namespace LAMMPS_NS {

namespace release {
  // since 2025 it wants to know where it is called; `int` is the better match where it compiles
  template <class D>
  auto minimum_image(const D &domain, double *delta, int)
      -> decltype(domain.minimum_image(FLERR, delta))
  {
    domain.minimum_image(FLERR, delta);
  }
  template <class D> void minimum_image(const D &domain, double *delta, long)
  {
    domain.minimum_image(delta);
  }
}    // namespace release

inline void minimum_image(const Domain &domain, double *delta)
{
  release::minimum_image(domain, delta, 0);
}

}    // namespace LAMMPS_NS

#endif
