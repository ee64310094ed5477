#ifndef DEFE_COUPLING_FORCE_SUMS_H
#define DEFE_COUPLING_FORCE_SUMS_H

/// \file
/// Where joints and contacts of spheres add their forces: to the arrays of the particles, and to the virial.

#include "defe/exact_sum.h"
#include "defe/types.h"

#include <cstddef>

namespace defe {

/// Contributions as multiples of one quantum, so that their sums are exact; as they are if there is no grid.
class RoundedForces {
 public:
  void set_grids(const SumGrid &force, const SumGrid &torque)
  {
    force_grid_ = force;
    torque_grid_ = torque;
  }
  const SumGrid &force_grid() const { return force_grid_; }
  const SumGrid &torque_grid() const { return torque_grid_; }

  /// A contribution to a force or torque of particle i.
  double on_grid(const SumGrid &grid, double value, int i)
  {
    if (!grid.on()) return value;
    const double rounded = grid.round(value);
    if (grid.beyond(rounded)) beyond_ = i;
    return rounded;
  }
  Vec3 force(Vec3 value, int i)
  {
    for (double &v : value) v = on_grid(force_grid_, v, i);
    return value;
  }
  Vec3 torque(Vec3 value, int i)
  {
    for (double &v : value) v = on_grid(torque_grid_, v, i);
    return value;
  }

  /// A particle with a contribution that is too large for its grid; -1: none.
  int beyond() const { return beyond_; }
  void set_beyond(int i) { beyond_ = i; }

 private:
  SumGrid force_grid_, torque_grid_;
  int beyond_ = -1;
};

/// Where forces are added to the virial, if it is asked for. Order xx yy zz xy xz yz.
struct VirialTally {
  double *all = nullptr;      ///< [6]
  double **each = nullptr;    ///< [particles][6]
  bool on() const { return all || each; }

  /// A force on particle i, del = x_i - (point of the reaction).
  void operator()(const double *del, const double *force, int i) const
  {
    const double v[6] = {del[0] * force[0], del[1] * force[1], del[2] * force[2],
                         del[0] * force[1], del[0] * force[2], del[1] * force[2]};
    if (all)
      for (int k = 0; k < 6; ++k) all[k] += v[k];
    if (each)
      for (int k = 0; k < 6; ++k) each[i][k] += v[k];
  }
};

/// Arrays of the particles, three numbers each, and how contributions are rounded.
struct ForceSums {
  double *f = nullptr, *torque = nullptr;
  RoundedForces *rounding = nullptr;
  VirialTally tally;

  double *force_on(int i) const { return f + 3 * static_cast<std::ptrdiff_t>(i); }
  double *torque_on(int i) const { return torque + 3 * static_cast<std::ptrdiff_t>(i); }
};

}    // namespace defe

#endif
