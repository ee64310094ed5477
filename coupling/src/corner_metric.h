#ifndef DEFE_COUPLING_CORNER_METRIC_H
#define DEFE_COUPLING_CORNER_METRIC_H

#include "defe/coupling/corner_strain.h"

#include <Eigen/Geometry>
#include <Eigen/LU>
#include <cmath>

namespace defe {

/// The three slots of corner 0..7: bit a of the corner is the side on axis a.
constexpr int corner_slot(int corner, int axis)
{
  return 2 * axis + ((corner >> axis) & 1);
}

inline double corner_volume(const GeneralCell &cell, int corner)
{
  const Vec3 *const h = cell.face;
  return std::abs(
      h[corner_slot(corner, 0)].dot(h[corner_slot(corner, 1)].cross(h[corner_slot(corner, 2)])));
}

/// Inverse of the metric G_ab = M_a . M_b of the joints that are present at a corner, zero in rows
/// and columns of absent ones. Restricted to the present joints it is the metric of their plane or
/// line, so one formula serves solid, plane stress and uniaxial corners.
struct CornerMetric {
  int slot[3];
  int joints = 0;    ///< slot[0..joints-1] are present
  Mat3 inverse;      ///< only the leading joints x joints block is set

  CornerMetric(const GeneralCell &cell, unsigned present, int corner)
  {
    for (int a = 0; a < 3; ++a) {
      const int s = corner_slot(corner, a);
      if (present >> s & 1u) slot[joints++] = s;
    }
    const auto G = [&](int a, int b) {
      return cell.dX[slot[a]].dot(cell.dX[slot[b]]);
    };
    if (joints == 3) {
      Mat3 metric;
      metric << G(0, 0), G(0, 1), G(0, 2), G(0, 1), G(1, 1), G(1, 2), G(0, 2), G(1, 2), G(2, 2);
      inverse = metric.inverse();
    } else if (joints == 2) {
      const double g00 = G(0, 0), g01 = G(0, 1), g11 = G(1, 1), det = g00 * g11 - g01 * g01;
      inverse(0, 0) = g11 / det;
      inverse(1, 1) = g00 / det;
      inverse(0, 1) = inverse(1, 0) = -g01 / det;
    } else if (joints == 1) {
      inverse(0, 0) = 1.0 / G(0, 0);
    }
  }
};

}    // namespace defe

#endif
