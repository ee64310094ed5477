#include "defe/fe/principal.h"

#include <Eigen/Eigenvalues>
#include <cmath>

namespace defe::fe {

double max_principal(const Mat3 &s)
{
  return Eigen::SelfAdjointEigenSolver<Mat3>(s, Eigen::EigenvaluesOnly).eigenvalues()[2];
}

double max_principal(const Mat3 &s, Vec3 &direction)
{
  const Eigen::SelfAdjointEigenSolver<Mat3> solver(s);
  direction = solver.eigenvectors().col(2);
  return solver.eigenvalues()[2];
}

double von_mises(const double *s)
{
  return std::sqrt(0.5 *
                       ((s[0] - s[1]) * (s[0] - s[1]) + (s[1] - s[2]) * (s[1] - s[2]) +
                        (s[2] - s[0]) * (s[2] - s[0])) +
                   3.0 * (s[3] * s[3] + s[4] * s[4] + s[5] * s[5]));
}

double stress_bound(const Mat3 &s, const StressBound &weights)
{
  const double p = s.trace() / 3.0;
  const double dx = s(0, 0) - p, dy = s(1, 1) - p, dz = s(2, 2) - p;
  const double J2 = 0.5 * (dx * dx + dy * dy + dz * dz) + s(1, 0) * s(1, 0) + s(2, 0) * s(2, 0) +
      s(2, 1) * s(2, 1);
  return weights.mean * p + weights.shear * std::sqrt(J2 / 3.0);
}

double max_principal_bound(const Mat3 &s)
{
  return stress_bound(s, StressBound());
}

}    // namespace defe::fe
