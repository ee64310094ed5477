#include "defe/coupling/friction.h"

#include <cmath>

namespace defe {

FrictionResult coulomb_friction(Vec3 &shear, const Vec3 &n, const Vec3 &slip, double kt,
                                double limit)
{
  const double length = shear.norm();
  shear -= shear.dot(n) * n;
  const double left = shear.norm();
  if (left > 0.0) shear *= length / left;

  shear += slip - slip.dot(n) * n;
  FrictionResult r{-kt * shear, 0.0, 0.0};
  const double pull = r.force.norm();
  if (pull > limit) {
    // the spring keeps what the limit holds; the rest is slip against the limit
    r.rubbed = limit * (pull - limit) / kt;
    const Vec3 kept = limit / pull * shear;
    shear = kept;
    r.force = -kt * shear;
  }
  r.stored = 0.5 * kt * shear.squaredNorm();
  return r;
}

}    // namespace defe
