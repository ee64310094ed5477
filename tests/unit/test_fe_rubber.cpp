// Mooney-Rivlin at large strain against closed forms, at the true compressibility or in the limit of none.
// The forces of one element give nominal stresses: force on a face by its first area.

#include "test_fe_common.h"

#include "defe/fe/mooney_rivlin.h"
#include "defe/fe/stable_step.h"

#include <Eigen/Eigenvalues>
#include <gtest/gtest.h>

#include <functional>

using namespace defe;
using namespace defe::fe;
using namespace defe::fe::test;

namespace {

// PVB as in much of the literature on impact
constexpr double C10 = 1.60e6, C01 = 0.06e6, nu = 0.495, rho = 1100.0;
constexpr double mu = 2.0 * (C10 + C01), K = 2.0 * mu * (1.0 + nu) / (3.0 * (1.0 - 2.0 * nu));
const MooneyRivlin pvb{C10, C01, K, rho};

const double a = 1e-3, b = 2e-3, c = 0.76e-3;    // edges of the element

HexCoords stretched(double x, double y, double z)
{
  return Vec3(x, y, z).asDiagonal() * box(a, b, c);
}

/// Force that must be put on the face xi_axis = +1 in direction i, by the face's first area.
double nominal_stress(const HexKernel &kernel, const HexCoords &x, int axis, int i)
{
  const HexCoords f = forces(kernel, x, box(a, b, c));
  const double area[3] = {b * c, a * c, a * b};
  double sum = 0.0;
  for (int n = 0; n < 8; ++n)
    if (hex_sign[n][axis] > 0) sum -= f(i, n);
  return sum / area[axis];
}

double root(double lo, double hi, const std::function<double(double)> &g)
{
  const bool rising = g(hi) > g(lo);
  for (int i = 0; i < 200; ++i) {
    const double mid = 0.5 * (lo + hi);
    ((g(mid) > 0.0) == rising ? hi : lo) = mid;
  }
  return 0.5 * (lo + hi);
}

TEST(MooneyRivlin, UniaxialTensionAndCompression)
{
  // Incompressible: P = 2 (C10 + C01/l) (l - l^-2). A law with K has the same deviator at the
  // stretches l and t = sqrt(J/l) across, and P_across = 0 gives J; then sigma = the difference of
  // the principal Kirchhoff stresses by J.
  const MooneyRivlinKernel kernel(pvb);
  for (double l : {0.3, 0.5, 0.9, 1.1, 2.0, 4.0, 7.0}) {
    const double t = root(0.3 / std::sqrt(l), 1.5 / std::sqrt(l), [&](double s) {
      return nominal_stress(kernel, stretched(l, s, s), 1, 1);
    });
    const double J = l * t * t, L = l / std::cbrt(J);    // isochoric stretch
    const double P = nominal_stress(kernel, stretched(l, t, t), 0, 0);
    EXPECT_NEAR(P * l, 2.0 * (C10 + C01 / L) * (L * L - 1.0 / L), 1e-9 * std::abs(P * l)) << l;
    // sigma_m = sigma/3 = K (J - 1)
    EXPECT_NEAR(K * (J - 1.0), P * l / J / 3.0, 1e-7 * std::abs(P)) << l;
  }
}

TEST(MooneyRivlin, UniaxialInTheIncompressibleLimit)
{
  MooneyRivlin m = pvb;
  m.K = 1e5 * mu;
  const MooneyRivlinKernel kernel(m);
  for (double l : {0.5, 0.9, 1.1, 2.0, 4.0}) {
    const double t = root(0.9 / std::sqrt(l), 1.1 / std::sqrt(l), [&](double s) {
      return nominal_stress(kernel, stretched(l, s, s), 1, 1);
    });
    const double P = nominal_stress(kernel, stretched(l, t, t), 0, 0);
    const double expected = 2.0 * (C10 + C01 / l) * (l - 1.0 / (l * l));
    EXPECT_NEAR(P, expected, 2e-4 * std::abs(expected)) << l;
  }
}

TEST(MooneyRivlin, EquibiaxialTension)
{
  // P = 2 (C10 + C01 l^2) (l - l^-5)
  MooneyRivlin m = pvb;
  m.K = 1e5 * mu;
  const MooneyRivlinKernel kernel(m);
  for (double l : {0.7, 0.95, 1.05, 1.5, 2.5}) {
    const double t = root(0.9 / (l * l), 1.1 / (l * l), [&](double s) {
      return nominal_stress(kernel, stretched(l, s, l), 1, 1);
    });
    const HexCoords x = stretched(l, t, l);
    const double expected = 2.0 * (C10 + C01 * l * l) * (l - std::pow(l, -5));
    EXPECT_NEAR(nominal_stress(kernel, x, 0, 0), expected, 5e-4 * std::abs(expected)) << l;
    EXPECT_NEAR(nominal_stress(kernel, x, 2, 2), expected, 5e-4 * std::abs(expected)) << l;
  }
}

TEST(MooneyRivlin, SimpleShear)
{
  // sigma_xy = 2 (C10 + C01) g, sigma_xx - sigma_yy = 2 (C10 + C01) g^2 (Rivlin's universal
  // relation), sigma_yy - sigma_zz = -2 C01 g^2; no volume change and so no pressure: the deviator
  const MooneyRivlinKernel kernel(pvb);
  const HexCoords X = box(a, b, c);
  for (double g : {1e-3, 0.3, 1.0, 3.0}) {
    Mat3 F = Mat3::Identity();
    F(0, 1) = g;
    const Mat3 s = kernel.stress(F * X, X, Vec3(0.3, -0.2, 0.5));
    EXPECT_NEAR(s(0, 1), mu * g, 1e-9 * mu * g);
    EXPECT_NEAR(s(0, 0) - s(1, 1), mu * g * g, 1e-9 * mu * g);
    EXPECT_NEAR(s(1, 1) - s(2, 2), -2.0 * C01 * g * g, 1e-9 * mu * g);
    EXPECT_NEAR(s.trace(), 0.0, 1e-8 * mu * g);
    EXPECT_NEAR(s(0, 2), 0.0, 1e-9 * mu * g);
    EXPECT_NEAR(nominal_stress(kernel, F * X, 1, 0), mu * g, 1e-9 * mu * g);
    EXPECT_NEAR(kernel.energy(F * X, X), 0.5 * mu * g * g * a * b * c,
                1e-9 * mu * (g + g * g) * a * b * c);
  }
}

TEST(MooneyRivlin, VolumeChangeCostsTheBulkModulusOnly)
{
  const MooneyRivlinKernel kernel(pvb);
  const HexCoords X = box(a, b, c);
  for (double l : {0.8, 0.99, 1.0, 1.01, 1.3}) {
    const double J = l * l * l;
    EXPECT_NEAR(nominal_stress(kernel, l * X, 2, 2), K * (J - 1.0) * l * l, 1e-7 * K * 1e-3) << l;
    EXPECT_NEAR(kernel.energy(l * X, X), 0.5 * K * (J - 1.0) * (J - 1.0) * a * b * c,
                1e-12 * K * a * b * c);
    EXPECT_LT((kernel.stress(l * X, X, Vec3::Zero()) - K * (J - 1.0) * Mat3::Identity()).norm(),
              1e-8 * mu);
  }
}

TEST(MooneyRivlin, EnergyIsTheWorkOfAnyPath)
{
  // from rest to a stretched, sheared, warped and turned element: work of the forces by the
  // trapezoidal rule
  Random random(3);
  const HexCoords X = box(a, b, c);
  // by 0.7 rad: on the straight way to it the element must not turn inside out
  const Mat3 R = Eigen::AngleAxisd(0.7, Vec3(1.0, 2.0, 2.0) / 3.0).toRotationMatrix();
  const HexCoords target = R * (X + random.matrix<HexCoords>(0.15e-3));
  const MooneyRivlinKernel kernel(pvb);
  const auto work = [&](int steps) {
    double sum = 0.0;
    HexCoords x = X, f = forces(kernel, X, X);
    for (int i = 1; i <= steps; ++i) {
      const double s = double(i) / steps;
      const HexCoords next = (1.0 - s) * X + s * target + s * (1.0 - s) * 0.1 * X;
      const HexCoords g = forces(kernel, next, X);
      sum -= 0.5 * (f + g).cwiseProduct(next - x).sum();
      x = next;
      f = g;
    }
    return sum;
  };
  ASSERT_GT((target - X).norm(), 1e-4);
  const double W = kernel.energy(target, X);
  const double coarse = work(400) - W, fine = work(800) - W;
  EXPECT_NEAR(fine, 0.0, 1e-4 * W);
  EXPECT_NEAR(coarse / fine, 4.0, 0.1);
}

TEST(MooneyRivlin, SmallStrainConstants)
{
  const MooneyRivlinKernel kernel(pvb);
  EXPECT_NEAR(kernel.material().nu, nu, 1e-12);
  EXPECT_NEAR(kernel.material().mu(), mu, 1e-9 * mu);
  EXPECT_NEAR(kernel.material().bulk(), K, 1e-9 * K);
  EXPECT_EQ(kernel.material().rho, rho);
  EXPECT_EQ(kernel.history_size(), 0);
}

TEST(MooneyRivlin, RefusesBadConstants)
{
  const auto complaint = [](double C10, double C01, double K, double rho) {
    return MooneyRivlin{C10, C01, K, rho}.validate();
  };
  EXPECT_EQ(pvb.validate(), "");
  EXPECT_NE(complaint(-1.0, 1.0, 100.0, 1.0).find("C10 must not be negative, not -1"),
            std::string::npos);
  EXPECT_NE(complaint(1.0, -0.5, 100.0, 1.0).find("C01 must not be negative, not -0.5"),
            std::string::npos);
  EXPECT_NE(complaint(0.0, 0.0, 100.0, 1.0).find("must be positive"), std::string::npos);
  EXPECT_NE(complaint(1.0, 0.0, 0.495, 1.0).find("bulk modulus must be at least"),
            std::string::npos);
  EXPECT_NE(complaint(1.0, 0.0, 1e20, 1.0).find("too large"), std::string::npos);
  EXPECT_NE(complaint(1.0, 0.0, 100.0, 0.0).find("density"), std::string::npos);
  EXPECT_NE(complaint(std::nan(""), 0.0, 100.0, 1.0), "");
  EXPECT_NE(complaint(1.0, std::nan(""), 100.0, 1.0), "");
  EXPECT_NE(complaint(1.0, 0.0, std::nan(""), 1.0), "");
  EXPECT_NE(complaint(1.0, 0.0, 100.0, std::nan("")), "");
  EXPECT_THROW(MooneyRivlinKernel(MooneyRivlin{1.0, -0.5, 100.0, 1.0}), std::invalid_argument);
}

TEST(MooneyRivlin, CriticalStepIsThatOfAFreeElement)
{
  // velocity Verlet just below the step stays bounded, just above it does not
  Random random(4);
  const HexCoords X = 1e-3 * random_hex(random);
  const MooneyRivlinKernel kernel(pvb);
  const double dt = critical_step_fbar(X, kernel.material()), mass = nodal_mass(X, rho);
  const auto largest = [&](double step) {
    HexCoords x = X + random.matrix<HexCoords>(1e-12), v = HexCoords::Zero();
    HexCoords f = forces(kernel, x, X);
    double size = 0.0;
    for (int i = 0; i < 2000 && size < 1e-6; ++i) {
      v += 0.5 * step / mass * f;
      x += step * v;
      f = forces(kernel, x, X);
      v += 0.5 * step / mass * f;
      size = (x - X).norm();
    }
    return size;
  };
  EXPECT_LT(largest(0.995 * dt), 1e-9);
  EXPECT_GT(largest(1.005 * dt), 1e-7);
}

TEST(MooneyRivlin, ExplicitRunConservesEnergy)
{
  // one element thrown out of shape: the error of velocity Verlet, of second order and bounded
  const HexCoords X = box(a, b, c);
  const MooneyRivlinKernel kernel(pvb);
  const double mass = nodal_mass(X, rho);
  const auto drift = [&](double factor) {
    Random random(5);
    const double dt = factor * critical_step_fbar(X, kernel.material());
    HexCoords x = X + random.matrix<HexCoords>(0.15e-3), v = random.matrix<HexCoords>(5.0);
    HexCoords f = forces(kernel, x, X);
    const double start = kernel.energy(x, X) + 0.5 * mass * v.squaredNorm();
    double worst = 0.0;
    for (int i = 0; i < int(2000 / factor); ++i) {
      v += 0.5 * dt / mass * f;
      x += dt * v;
      f = forces(kernel, x, X);
      v += 0.5 * dt / mass * f;
      worst = std::max(
          worst, std::abs(kernel.energy(x, X) + 0.5 * mass * v.squaredNorm() - start) / start);
    }
    return worst;
  };
  const double coarse = drift(0.1), fine = drift(0.05);
  EXPECT_LT(coarse, 0.02);
  EXPECT_NEAR(coarse / fine, 4.0, 1.0);
}

}    // namespace
