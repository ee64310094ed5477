#include "defe/fe/prestress.h"

#include "defe/fe/hex8.h"

#include <cmath>

namespace defe::fe {

Mat3 strain_of_stress(const Mat3 &sigma, const IsotropicElastic &m)
{
  Mat3 strain = (1.0 + m.nu) / m.E * sigma;
  strain.diagonal().array() -= m.nu / m.E * sigma.trace();
  return strain;
}

double energy_of_stress(const Mat3 &sigma, const IsotropicElastic &m)
{
  return 0.5 * sigma.cwiseProduct(strain_of_stress(sigma, m)).sum();
}

Mat3 stress_free_map(const Mat3 &sigma, const IsotropicElastic &m)
{
  return stress_free_map(sigma, m, [&m](const Mat3 &F) {
    const Mat3 green = 0.5 * (F.transpose() * F - Mat3::Identity());
    Mat3 S = 2.0 * m.mu() * green;
    S.diagonal().array() += m.lambda() * green.trace();
    return Mat3(F * S * F.transpose() / F.determinant());
  });
}

Mat3 mean_cauchy_stress(const HexKernel &kernel, const HexCoords &x, const HexCoords &X)
{
  const int nodes[1][8] = {{0, 1, 2, 3, 4, 5, 6, 7}};
  HexCoords f = HexCoords::Zero();
  double v[6] = {0.0, 0.0, 0.0, 0.0, 0.0, 0.0};
  HexKernel::Output out;
  out.virial = v;
  kernel.add_forces(1, nodes, x.data(), X.data(), f.data(), out);
  Mat3 sum;
  sum << v[0], v[3], v[4], v[3], v[1], v[5], v[4], v[5], v[2];
  return -sum / volume(x);
}

Mat3 ParabolaStress::over(const HexCoords &X) const
{
  const double middle = 0.5 * (lower + upper), half = 0.5 * (upper - lower);
  double mean = 0.0;
  for (const Vec3 &xi : gauss_points()) {
    const double depth = (interpolate(X, xi)[axis] - middle) / half;
    mean += 0.125 * 0.5 * surface * (3.0 * depth * depth - 1.0);
  }
  Mat3 sigma = Mat3::Zero();
  for (int k = 0; k < 3; ++k)
    if (k != axis) sigma(k, k) = mean;
  return sigma;
}

Mat3 rounded_stress(const Mat3 &sigma, const IsotropicElastic &m)
{
  const double quantum = std::ldexp(1.0, std::ilogb(m.E) - 50);
  Mat3 rounded;
  for (int i = 0; i < 3; ++i)
    for (int k = 0; k < 3; ++k) rounded(i, k) = quantum * std::nearbyint(sigma(i, k) / quantum);
  return rounded;
}

}    // namespace defe::fe
