#include "defe/fe/periodic.h"

#include <cmath>

namespace defe::fe {

unsigned join_across_border(HexCoords &X, const Vec3 &periods)
{
  unsigned axes = 0;
  for (int k = 0; k < 3; ++k) {
    const double period = periods[k];
    if (!std::isfinite(period) || !(X.row(k).maxCoeff() - X.row(k).minCoeff() > 0.5 * period))
      continue;
    Eigen::Matrix<double, 1, 8> near = X.row(k);
    for (int a = 1; a < 8; ++a) near[a] -= period * std::round((near[a] - near[0]) / period);
    // else it is as long as it was given, and an image of it would be another element
    if (!(near.maxCoeff() - near.minCoeff() <= 0.25 * period)) continue;
    X.row(k) = near;
    axes |= 1u << k;
  }
  return axes;
}

}    // namespace defe::fe
