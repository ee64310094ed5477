#include "defe/coupling/shielding.h"

#include <cmath>

namespace defe {

bool shielded(const Vec3 &tension_direction, double sigma1, double criterion, double now,
              double tau, const Shield *shields, int n, double cos_limit, double override)
{
  if (sigma1 >= override * criterion) return false;
  for (int i = 0; i < n; ++i) {
    const Shield &s = shields[i];
    if (now - s.time >= tau) continue;
    const double along = std::abs(tension_direction.dot(s.direction));
    if (along > cos_limit * std::sqrt(tension_direction.squaredNorm() * s.direction.squaredNorm()))
      return true;
  }
  return false;
}

double shielding_time(double h, double lambda, double mu, double rho)
{
  return 3.0 * h / std::sqrt((lambda + 2.0 * mu) / rho);
}

}    // namespace defe
