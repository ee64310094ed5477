#include "defe/coupling/friction.h"

#include <algorithm>
#include <cmath>

namespace defe {

FrictionResult coulomb_friction(TangentialSpring &spring, const Vec3 &n, const Vec3 &slip,
                                double kt, double limit)
{
  Vec3 old(spring.s);
  const double length = old.norm();
  old -= old.dot(n) * n;
  const double left = old.norm();
  if (left > 0.0) old *= length / left;

  // the mean of both steps: work by the mean force is stored to the third order in the step
  const double root = std::sqrt(kt), root_before = spring.root > 0.0 ? spring.root : root;
  const double mean = 0.5 * (root_before + root);
  const Vec3 trial = old + mean * (slip - slip.dot(n) * n);
  Vec3 s = trial;
  FrictionResult r;
  r.rubbed = 0.0;
  const double pull = root * trial.norm();
  r.slipping = pull > limit;
  if (r.slipping) {
    s *= limit / pull;
    // the mean force of the step times the way that the point slipped
    const Vec3 force = 0.5 * (root_before * old + root * s);
    r.rubbed = std::max(0.0, force.dot(trial - s) / mean);
  }
  r.force = -root * s;
  r.stored = 0.5 * s.squaredNorm();
  for (int k = 0; k < 3; ++k) spring.s[k] = s[k];
  spring.root = root;
  return r;
}

}    // namespace defe
