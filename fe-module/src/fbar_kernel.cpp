#include "defe/fe/fbar_kernel.h"

#include "defe/fe/hex8.h"

#include <limits>
#include <stdexcept>

namespace defe::fe {

namespace {

  constexpr double nan = std::numeric_limits<double>::quiet_NaN();

}    // namespace

IsotropicElastic elastic_from_bulk_shear(double bulk, double shear, double rho)
{
  const double denominator = 3.0 * bulk + shear;
  return {9.0 * bulk * shear / denominator, 0.5 * (3.0 * bulk - 2.0 * shear) / denominator, rho};
}

FBarKernel::FBarKernel(const std::string &complaint, double bulk, const IsotropicElastic &initial) :
    bulk(bulk), initial(initial)
{
  if (!complaint.empty()) throw std::invalid_argument(complaint);
}

double FBarKernel::energy(const HexCoords &x, const HexCoords &X, const double *history) const
{
  const double V = volume(X), dv = volume(x) - V;
  double sum = 0.5 * bulk * dv * dv / V;
  if (!(deformation_gradient(x, X, Vec3::Zero()).determinant() > 0.0)) return nan;
  for (int p = 0; p < 8; ++p) {
    const Vec3 &xi = gauss_points()[p];
    const Mat3 F = deformation_gradient(x, X, xi);
    if (!(F.determinant() > 0.0)) return nan;
    const double dV = jacobian(X.colwise() - X.col(0), xi).determinant();
    sum += dV * shear_energy(F, history ? history + p * point_history_size() : nullptr);
  }
  return sum;
}

Mat3 FBarKernel::stress(const HexCoords &x, const HexCoords &X, const Vec3 &xi,
                        const double *history) const
{
  const Mat3 F = deformation_gradient(x, X, xi);
  if (!(F.determinant() > 0.0)) return Mat3::Constant(nan);

  double here[max_point_history];
  const int size = point_history_size();
  if (history && size) {
    // the trilinear function through the values at the Gauss points, nodes of a hex in sqrt(3) xi
    const Eigen::Matrix<double, 8, 1> N = shape(std::sqrt(3.0) * xi);
    for (int i = 0; i < size; ++i) {
      here[i] = 0.0;
      for (int p = 0; p < 8; ++p) here[i] += N[p] * history[p * size + i];
    }
    history = here;
  } else {
    history = nullptr;
  }
  const double V = volume(X), v = volume(x);
  Mat3 s = V / v * shear_stress(F, history);
  s.diagonal().array() += bulk * (v - V) / V;
  return s;
}

}    // namespace defe::fe
