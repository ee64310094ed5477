#include "defe/coupling/penalty.h"

#include <algorithm>
#include <cmath>

namespace defe {

double penalty_stiffness_per_area(double f_s, double K, double A, double V)
{
  return f_s * K * A / V;
}

namespace {
  constexpr double pi = 3.14159265358979323846;
}

BallOnPatch ball_on_patch(double overlap, double R, double A, double k_A)
{
  if (overlap <= 0.0) return {0.0, 0.0, 0.0, 1.0};
  const double rest = std::max(0.0, overlap - A / (2.0 * pi * R));
  const double k = pi * k_A * R;
  BallOnPatch r;
  r.energy = k / 3.0 * (overlap * overlap * overlap - rest * rest * rest);
  r.force = k * (overlap * overlap - rest * rest);
  r.slope = 2.0 * k * (overlap - rest);
  r.damping_factor = std::sqrt(0.5 * (1.0 + overlap * r.slope / r.force));
  return r;
}

double overlap_of_energy(double energy, double R, double A, double k_A)
{
  if (energy <= 0.0) return 0.0;
  // not below the answer: E(o) is the less curved the larger o is; Newton's method falls from there
  double o = std::cbrt(3.0 * energy / (pi * k_A * R)) + std::sqrt(2.0 * energy / (k_A * A)) +
      A / (2.0 * pi * R);
  for (int i = 0; i < 100; i++) {
    const BallOnPatch at = ball_on_patch(o, R, A, k_A);
    const double step = (at.energy - energy) / at.force;
    o -= step;
    if (std::abs(step) < 1e-15 * o) break;
  }
  return o;
}

}    // namespace defe
