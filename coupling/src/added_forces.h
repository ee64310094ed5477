#ifndef DEFE_COUPLING_ADDED_FORCES_H
#define DEFE_COUPLING_ADDED_FORCES_H

// Vectors of atoms in plain arrays, and what is added to them.

#include "defe/coupling/surface_forces.h"
#include "defe/types.h"

#include <cstddef>

namespace defe {

inline Vec3 vector_at(const double *x, int i)
{
  return Vec3(x[3 * static_cast<std::ptrdiff_t>(i)], x[3 * static_cast<std::ptrdiff_t>(i) + 1],
              x[3 * static_cast<std::ptrdiff_t>(i) + 2]);
}

/// Adds to forces and torques; exact: multiples of the quanta of the arrays' grids.
template <bool exact> class AddedForces {
 public:
  explicit AddedForces(const SurfaceArrays &arrays) : a(arrays) {}
  int beyond = -1;    ///< an atom with something beyond the grids

  void force(int i, const Vec3 &v) { add(a.f, i, v, a.force_grid); }
  void torque(int i, const Vec3 &v) { add(a.torque, i, v, a.torque_grid); }

 private:
  const SurfaceArrays &a;

  void add(double *array, int i, const Vec3 &v, const SumGrid &grid)
  {
    double *p = array + 3 * static_cast<std::ptrdiff_t>(i);
    for (int k = 0; k < 3; ++k)
      if constexpr (exact) {
        const double rounded = grid.round(v[k]);
        p[k] += rounded;
        if (grid.beyond(rounded)) beyond = i;
      } else
        p[k] += v[k];
  }
};

}    // namespace defe

#endif
