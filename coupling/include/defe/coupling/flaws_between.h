#ifndef DEFE_COUPLING_FLAWS_BETWEEN_H
#define DEFE_COUPLING_FLAWS_BETWEEN_H

#include <algorithm>
#include <cmath>

namespace defe {

/// Strength of what starts between two DEs of these strengths by flaws (strength_field.h); sigma_t where flaws have no say.
inline double strength_between(double a, double b, double sigma_t)
{
  const double least = std::min(a, b);
  return std::isfinite(least) ? least : sigma_t;
}

}    // namespace defe

#endif
