// Plastic hexahedra: tension, cycles, shear, rate and heat against closed forms; what plastic work is worth in energy;
// objectivity; the limit load of a bar in bending.

#include "test_fe_common.h"

#include "defe/fe/plastic.h"
#include "defe/fe/stable_step.h"

#include <gtest/gtest.h>

#include <stdexcept>

using namespace defe;
using namespace defe::fe;
using namespace defe::fe::test;

namespace {

Plastic metal(double yield, double hardening, double kinematic = 0.0)
{
  const IsotropicElastic steel{210e9, 0.3, 7800.0};
  Plastic m;
  m.K = steel.bulk();
  m.G = steel.mu();
  m.rho = steel.rho;
  m.yield = yield;
  m.hardening = hardening;
  m.kinematic = kinematic;
  return m;
}

/// 4340 steel of Johnson and Cook (1983)
Plastic johnson_cook()
{
  Plastic m = metal(792e6, 510e6);
  m.exponent = 0.26;
  m.rate_factor = 0.014;
  return m;
}

/// One element with its history.
struct Sample {
  PlasticKernel kernel;
  HexCoords X;
  Histories state;
  double energy = 0.0, dissipation = 0.0;

  explicit Sample(const Plastic &m, const HexCoords &X = box(1.0, 1.0, 1.0)) :
      kernel(m), X(X), state(kernel, 1)
  {
  }

  const double *history() const { return state.values.data(); }

  HexCoords advance(const HexCoords &x, double dt)
  {
    HexCoords f = HexCoords::Zero();
    HexKernel::Output out = state.output(dt);
    out.energy = &energy;
    out.dissipation = &dissipation;
    kernel.add_forces(1, first_hex, x.data(), X.data(), f.data(), out);
    return f;
  }

  Mat3 stress(const HexCoords &x) const { return kernel.stress(x, X, Vec3::Zero(), history()); }
  PlasticState flown() const { return kernel.plastic_state(history()); }
};

/// Stretches of a bar under the uniaxial Kirchhoff stress tau whose plastic part is e^strain along it. That is
/// G (b - b^-1/2) = tau for the elastic strain b along it, and K (J - 1) J = tau/3.
Mat3 bar(const Plastic &m, double tau, double strain)
{
  double b = 1.0;
  for (int i = 0; i < 50; ++i)
    b -= (m.G * (b - 1.0 / std::sqrt(b)) - tau) / (m.G * (1.0 + 0.5 * std::pow(b, -1.5)));
  const double J = 0.5 + std::sqrt(0.25 + tau / (3.0 * m.K)), size = std::cbrt(J);
  const double across = size * std::pow(b, -0.25) * std::exp(-0.5 * strain);
  return Vec3(size * std::sqrt(b) * std::exp(strain), across, across).asDiagonal();
}

void expect_bar(const Sample &s, const Mat3 &F, double tau, double strain, double tolerance)
{
  Mat3 expected = Mat3::Zero();
  expected(0, 0) = tau / F.determinant();
  EXPECT_LT((s.stress(F * s.X) - expected).norm(), tolerance * std::abs(tau)) << strain;
  EXPECT_NEAR(s.flown().strain, strain, tolerance * strain);
}

Mat3 simple_shear(double g)
{
  Mat3 F = Mat3::Identity();
  F(0, 1) = g;
  return F;
}

TEST(Plastic, TensionFollowsTheHardening)
{
  for (double sign : {1.0, -1.0})
    for (double hardening : {0.0, 1e9, 50e9})
      for (int steps : {1, 10, 100}) {
        const Plastic m = metal(400e6, hardening);
        Sample s(m);
        const double last = 0.3;
        for (int i = 1; i <= steps; ++i) {
          const double eps = last * i / steps, tau = sign * (m.yield + hardening * eps);
          const Mat3 F = bar(m, tau, sign * eps);
          s.advance(F * s.X, 1.0);
          // steps of any length give the stress that belongs to their plastic strain; this to the square of the step
          const double step = last / steps;
          expect_bar(s, F, tau, eps, steps == 100 ? 1e-6 : 0.08 * step * step);
          const Mat3 sigma = s.stress(F * s.X);
          EXPECT_NEAR((sigma(0, 0) - sigma(1, 1)) * F.determinant(),
                      sign * (m.yield + hardening * s.flown().strain), 1e-7 * std::abs(tau));
        }
      }
}

TEST(Plastic, BelowYieldItIsElasticAndLosesNothing)
{
  const Plastic m = metal(400e6, 1e9);
  Sample s(m);
  for (double tau : {100e6, 399e6, -399e6, 200e6, 0.0}) {
    const Mat3 F = bar(m, tau, 0.0);
    s.advance(F * s.X, 1.0);
    EXPECT_NEAR(s.stress(F * s.X)(0, 0), tau / F.determinant(), 1e-3) << tau;
    // Young's modulus, up to the second order in strain
    EXPECT_NEAR(tau, 210e9 * (F(0, 0) - 1.0), 3e-3 * std::abs(tau) + 1e-6);
  }
  EXPECT_EQ(s.flown().strain, 0.0);
  EXPECT_EQ(s.dissipation, 0.0);
  EXPECT_NEAR(s.energy, 0.0, 1e-10);
}

TEST(Plastic, UnloadingIsElasticAndCyclesHardenIsotropically)
{
  const Plastic m = metal(400e6, 5e9);
  Sample s(m);
  double eps = 0.0, strain = 0.0, yield = m.yield;
  for (int cycle = 0; cycle < 3; ++cycle)
    for (double sign : {1.0, -1.0}) {
      for (int i = 0; i < 20; ++i) {
        eps += 1e-3;
        strain += sign * 1e-3;
        yield = m.yield + m.hardening * eps;
        const Mat3 F = bar(m, sign * yield, strain);
        s.advance(F * s.X, 1.0);
        Mat3 expected = Mat3::Zero();
        expected(0, 0) = sign * yield / F.determinant();
        EXPECT_LT((s.stress(F * s.X) - expected).norm(), 1e-6 * yield);
        EXPECT_NEAR(s.flown().strain, eps, 1e-6 * eps);
      }
      // to just above yield on the other side: the plastic strain stays
      for (double part : {0.5, 0.0, -0.5, -0.9999}) {
        const double tau = part * sign * yield;
        const Mat3 F = bar(m, tau, strain);
        const double before = s.dissipation;
        s.advance(F * s.X, 1.0);
        EXPECT_NEAR(s.stress(F * s.X)(0, 0), tau / F.determinant(), 1e-6 * yield);
        EXPECT_EQ(s.dissipation, before);
      }
    }
}

TEST(Plastic, KinematicHardeningMovesTheYieldSurface)
{
  // Prager, at small strain: tension and compression are 2 sigma_y apart, both with the slope H_k (and H)
  const double yield = 400e6, slope = 4e9;
  for (double isotropic : {0.0, 2e9}) {
    const Plastic m = metal(yield, isotropic, slope);
    Sample s(m);
    double eps = 0.0, strain = 0.0;
    for (double sign : {1.0, -1.0, 1.0})
      for (int i = 0; i < 50; ++i) {
        eps += 1e-4;
        strain += sign * 1e-4;
        const double tau = slope * strain + sign * (yield + isotropic * eps);
        const Mat3 F = bar(m, tau, strain);
        s.advance(F * s.X, 1.0);
        EXPECT_NEAR(s.stress(F * s.X)(0, 0), tau, 5e-3 * yield) << strain;
        EXPECT_NEAR(s.flown().strain, eps, 5e-3 * eps + 1e-6);
      }
    // stored, but for what is elastic: H_k/2 times the square of the plastic strain
    const Mat3 released = bar(m, 0.0, strain);
    s.advance(released * s.X, 1.0);
    EXPECT_GT(s.energy, 0.3 * slope * strain * strain);
  }
}

TEST(Plastic, SimpleShear)
{
  // stress at yield sigma_y/sqrt(3) for any shear; normal stresses of second order in the elastic strain
  const Plastic m = metal(400e6, 0.0);
  Sample s(m);
  const double k = m.yield / std::sqrt(3.0), last = 2.0;
  const int steps = 4000;
  for (int i = 1; i <= steps; ++i) {
    const double g = last * i / steps;
    s.advance(simple_shear(g) * s.X, 1.0);
    const double expected = std::min(m.G * g, k);
    if (std::abs(m.G * g - k) > 0.2 * k) {
      EXPECT_NEAR(s.stress(simple_shear(g) * s.X)(0, 1), expected, 1e-4 * k) << g;
    }
  }
  EXPECT_NEAR(s.flown().strain, (last - k / m.G) / std::sqrt(3.0), 1e-4);
  // all work is dissipated, but for the elastic part
  EXPECT_NEAR(s.dissipation, k * (last - k / m.G), 2e-4 * k * last);
  EXPECT_NEAR(s.energy, 0.5 * k * k / m.G, 2e-3 * s.energy);
}

TEST(Plastic, ShearWithHardening)
{
  const Plastic m = metal(400e6, 2e9);
  Sample s(m);
  for (int i = 1; i <= 200; ++i) {
    const double g = 5e-4 * i;
    s.advance(simple_shear(g) * s.X, 1.0);
    // (sigma_y + H e)/sqrt(3) = G (g - sqrt(3) e)
    const double eps =
        std::max(0.0, (std::sqrt(3.0) * m.G * g - m.yield) / (3.0 * m.G + m.hardening));
    EXPECT_NEAR(s.stress(simple_shear(g) * s.X)(0, 1), m.G * (g - std::sqrt(3.0) * eps),
                2e-4 * m.yield);
    EXPECT_NEAR(s.flown().strain, eps, 1e-5);
  }
}

TEST(Plastic, JohnsonCookHardensWithStrainAndRate)
{
  // the plastic strain of a step by its length is the rate
  const Plastic m = johnson_cook();
  for (double rate : {0.1, 1.0, 30.0, 1e4, 1e6}) {
    Sample s(m);
    const double step = 1e-3, dt = step / rate;
    for (int i = 1; i <= 200; ++i) {
      const double eps = i * step;
      const double tau = (m.yield + m.hardening * std::pow(eps, m.exponent)) *
          (1.0 + m.rate_factor * std::log(std::max(rate, 1.0)));
      const Mat3 F = bar(m, tau, eps);
      s.advance(F * s.X, dt);
      expect_bar(s, F, tau, eps, 1e-6);
    }
  }
}

TEST(Plastic, RateCountsInItsUnit)
{
  Plastic m = johnson_cook();
  m.rate_unit = 1e3;
  Sample s(m);
  const double eps = 0.01, rate = 5e4;
  const double tau =
      (m.yield + m.hardening * std::pow(eps, m.exponent)) * (1.0 + m.rate_factor * std::log(50.0));
  const Mat3 F = bar(m, tau, eps);
  s.advance(F * s.X, eps / rate);
  expect_bar(s, F, tau, eps, 1e-6);
}

TEST(Plastic, PlasticWorkHeatsAndSoftens)
{
  // sigma = A (1 - T/T_m), dT/deps = heating sigma: T = T_m (1 - exp(-heating A eps/T_m))
  Plastic m = metal(800e6, 0.0);
  m.softening = 1.0;
  m.melting = 1000.0;
  m.heating = 0.9 / (7800.0 * 477.0);
  double error[2];
  for (int fine = 0; fine < 2; ++fine) {
    Sample s(m);
    const int steps = fine ? 400 : 200;
    const double last = 1.0, rate = m.heating * m.yield / m.melting;
    for (int i = 1; i <= steps; ++i) {
      const double eps = last * i / steps;
      s.advance(bar(m, m.yield * std::exp(-rate * eps), eps) * s.X, 1e-3);
    }
    const double T = m.melting * -std::expm1(-rate * last);
    error[fine] = s.flown().temperature - T;
    EXPECT_NEAR(error[fine], 0.0, 1e-3 * T);
    EXPECT_NEAR(s.flown().strain, last, 1e-3);
  }
  EXPECT_NEAR(error[0] / error[1], 2.0, 0.1);
  // molten: no shear stress is left
  Sample s(m);
  for (int i = 1; i <= 2000; ++i) s.advance(simple_shear(0.05 * i) * s.X, 1e-3);
  EXPECT_NEAR(s.flown().temperature, m.melting, 0.01 * m.melting);
  EXPECT_LT(std::abs(s.stress(simple_shear(100.0) * s.X)(0, 1)), 0.01 * m.yield);
}

TEST(Plastic, PlasticWorkIsDissipated)
{
  const Plastic m = metal(400e6, 3e9);
  Sample s(m);
  const int steps = 2000;
  const double last = 0.2;
  for (int i = 1; i <= steps; ++i) {
    const double eps = last * i / steps;
    s.advance(bar(m, m.yield + m.hardening * eps, eps) * s.X, 1.0);
  }
  const double work = m.yield * last + 0.5 * m.hardening * last * last;
  EXPECT_NEAR(s.dissipation, work, 1e-3 * work);
}

/// Of order 1: yields at strains of some per cent.
std::vector<Plastic> soft_metals()
{
  Plastic linear;
  linear.K = 2.0;
  linear.G = 1.0;
  linear.rho = 1.0;
  linear.yield = 0.1;
  linear.hardening = 0.2;
  Plastic back = linear, full = linear;
  back.kinematic = 0.3;
  full.exponent = 0.4;
  full.rate_factor = 0.02;
  full.rate_unit = 0.01;
  full.softening = 1.1;
  full.heating = 0.5;
  return {linear, back, full};
}

TEST(Plastic, WorkIsStoredOrDissipated)
{
  for (const Plastic &m : soft_metals()) {
    Random random(7);
    const HexCoords X = random_hex(random), A = random.matrix<HexCoords>(0.15),
                    B = random.matrix<HexCoords>(0.15);
    const auto imbalance = [&](int steps) {
      Sample s(m, X);
      const double dt = 6.0 / steps;
      HexCoords x = X, f = HexCoords::Zero();
      double work = 0.0, lowest = 0.0;
      for (int i = 1; i <= steps; ++i) {
        const double t = i * dt;
        const HexCoords next = X + std::sin(t) * A + std::sin(2.3 * t) * B;
        const double before = s.dissipation;
        const HexCoords g = s.advance(next, dt);
        lowest = std::min(lowest, s.dissipation - before);
        work -= 0.5 * (f + g).cwiseProduct(next - x).sum();
        x = next;
        f = g;
      }
      EXPECT_GT(s.dissipation, 0.3 * std::abs(work));
      EXPECT_GE(lowest, 0.0);
      EXPECT_NEAR(s.energy, s.kernel.energy(x, X, s.history()), 1e-14);
      return std::abs(work - s.energy - s.dissipation) / s.dissipation;
    };
    const double coarse = imbalance(300), fine = imbalance(1200);
    EXPECT_LT(fine, 1e-4);
    EXPECT_LT(fine, 0.2 * coarse);
  }
}

TEST(Plastic, ExplicitRunBalancesEnergy)
{
  const Plastic m = metal(400e6, 1e9);
  const HexCoords X = box(1e-3, 1e-3, 0.8e-3);
  const auto drift = [&](double factor) {
    Random random(8);
    Sample s(m, X);
    const double mass = nodal_mass(X, m.rho),
                 dt = factor * critical_step_fbar(X, s.kernel.material());
    HexCoords x = X, v = random.matrix<HexCoords>(60.0), f = HexCoords::Zero();
    const double start = 0.5 * mass * v.squaredNorm();
    double worst = 0.0;
    for (int i = 0; i < int(1000 / factor); ++i) {
      v += 0.5 * dt / mass * f;
      x += dt * v;
      f = s.advance(x, dt);
      v += 0.5 * dt / mass * f;
      const double total = 0.5 * mass * v.squaredNorm() + s.energy + s.dissipation;
      worst = std::max(worst, std::abs(total - start) / start);
    }
    EXPECT_GT(s.dissipation, 0.2 * start);
    return worst;
  };
  const double coarse = drift(0.2), fine = drift(0.1);
  EXPECT_LT(coarse, 0.01);
  EXPECT_LT(fine, 0.4 * coarse);
}

TEST(Plastic, RunsUpToTheCriticalStep)
{
  // of the elastic element, which yielding makes softer
  const Plastic m = metal(400e6, 1e9);
  const HexCoords X = box(1e-3, 1e-3, 0.8e-3);
  const double mass = nodal_mass(X, m.rho);
  const auto kinetic = [&](double speed, double factor, double &flown) {
    Random random(8);
    Sample s(m, X);
    const double dt = factor * critical_step_fbar(X, s.kernel.material());
    HexCoords x = X, v = random.matrix<HexCoords>(speed), f = HexCoords::Zero();
    const double start = v.squaredNorm();
    for (int i = 0; i < 2000; ++i) {
      v += dt / mass * f;
      x += dt * v;
      f = s.advance(x, dt);
    }
    flown = s.flown().strain;
    return v.squaredNorm() / start;
  };
  double flown;
  EXPECT_LT(kinetic(2.0, 0.98, flown), 4.0);
  EXPECT_EQ(flown, 0.0);
  EXPECT_LT(kinetic(60.0, 0.98, flown), 1.0);
  EXPECT_GT(flown, 0.01);
  kinetic(2.0, 1.1, flown);    // an elastic element would be thrown apart; this one flows
  EXPECT_GT(flown, 0.01);
}

TEST(Plastic, RotationInEveryStepChangesNothingButTheAxes)
{
  for (const Plastic &m : soft_metals()) {
    Random random(9);
    const HexCoords X = random_hex(random), A = random.matrix<HexCoords>(0.15);
    Sample still(m, X), turning(m, X);
    for (int i = 1; i <= 50; ++i) {
      const HexCoords x = X + std::sin(0.2 * i) * A;
      const Mat3 R = i % 2 ? random.rotation()
                           : Mat3(Eigen::AngleAxisd(0.5 * M_PI, Vec3::UnitZ()).toRotationMatrix());
      const HexCoords turned = (R * x).colwise() + random.matrix<Vec3>(1.0);
      const HexCoords f = still.advance(x, 0.1), g = turning.advance(turned, 0.1);
      EXPECT_LT((g - R * f).norm(), 1e-12);
      EXPECT_LT((turning.stress(turned) - R * still.stress(x) * R.transpose()).norm(), 1e-12);
    }
    EXPECT_GT(still.flown().strain, 0.1);
    for (size_t i = 0; i < still.state.values.size(); ++i)
      EXPECT_NEAR(still.state.values[i], turning.state.values[i], 1e-12);
    EXPECT_NEAR(still.dissipation, turning.dissipation, 1e-12);
  }
}

TEST(Plastic, TensionTurnedByARightAngleWhileItYields)
{
  const Plastic m = metal(400e6, 1e9);
  Sample s(m);
  const int steps = 90;
  Mat3 R = Mat3::Identity();
  for (int i = 1; i <= steps; ++i) {
    const double eps = 1e-3 * i, tau = m.yield + m.hardening * eps;
    R = Eigen::AngleAxisd(0.5 * M_PI * i / steps, Vec3::UnitZ()).toRotationMatrix();
    const Mat3 F = bar(m, tau, eps);
    s.advance(R * F * s.X, 1.0);
    Mat3 expected = Mat3::Zero();
    expected(0, 0) = tau / F.determinant();
    EXPECT_LT((s.stress(R * F * s.X) - R * expected * R.transpose()).norm(), 1e-6 * tau) << i;
  }
}

TEST(Plastic, WithoutTimeNothingAdvancesAndNothingChanges)
{
  for (const Plastic &m : soft_metals()) {
    Random random(10);
    const HexCoords X = random_hex(random);
    Sample s(m, X);
    HexCoords x, f;
    for (int i = 0; i < 5; ++i) f = s.advance(x = X + random.matrix<HexCoords>(0.1), 0.3);
    EXPECT_GT(s.flown().strain, 0.1);
    const std::vector<double> history = s.state.values;
    const double energy = s.energy, dissipation = s.dissipation;
    EXPECT_EQ((s.advance(x, 0.0) - f).norm(), 0.0);    // bit for bit
    EXPECT_EQ(s.energy, energy);
    EXPECT_EQ(s.dissipation, dissipation);
    s.advance(X, 0.0);
    EXPECT_EQ(s.state.values, history);
    EXPECT_EQ(s.dissipation, dissipation);
  }
}

TEST(Plastic, ListsOfAnyLengthAdvanceAlike)
{
  // some elements yield, some do not, and none heeds its neighbours
  for (const Plastic &m : soft_metals()) {
    const PlasticKernel kernel(m);
    Random random(11);
    const int n = 19;
    std::vector<std::array<int, 8>> hexes(n);
    std::vector<HexCoords> x(n), X(n);
    for (int e = 0; e < n; ++e) {
      for (int a = 0; a < 8; ++a) hexes[e][a] = 8 * e + a;
      X[e] = random_hex(random);
      x[e] = X[e] + random.matrix<HexCoords>(e % 3 ? 0.2 : 0.005);
    }
    const auto nodes = reinterpret_cast<const int(*)[8]>(hexes.data());
    Histories whole(kernel, n), pieces(kernel, n);
    std::vector<double> f(24 * n), g(24 * n);
    double dissipation = 0.0, dissipation_pieces = 0.0;
    for (int step = 0; step < 3; ++step) {
      std::fill(f.begin(), f.end(), 0.0);
      g = f;
      HexKernel::Output out = whole.output(0.2);
      out.dissipation = &dissipation;
      kernel.add_forces(n, nodes, x[0].data(), X[0].data(), f.data(), out);
      for (int e = 0; e < n; ++e) {
        HexKernel::Output one = pieces.output(0.2);
        one.history = pieces.of_element.data() + e;
        one.dissipation = &dissipation_pieces;
        kernel.add_forces(1, nodes + e, x[0].data(), X[0].data(), g.data(), one);
      }
      for (int e = 0; e < n; ++e) x[e] += random.matrix<HexCoords>(e % 3 ? 0.03 : 0.001);
    }
    EXPECT_EQ(f, g);
    EXPECT_EQ(whole.values, pieces.values);
    EXPECT_NEAR(dissipation, dissipation_pieces, 1e-14 * n);
    EXPECT_GT(dissipation, 0.0);
    EXPECT_EQ(kernel.plastic_state(whole.of_element[0]).strain, 0.0);
  }
}

TEST(Plastic, GrosslyStrainedElementsStaySound)
{
  // single steps of hundreds of per cent: energy and dissipation finite, A keeps its determinant
  for (const Plastic &m : soft_metals()) {
    Random random(13);
    Sample s(m);
    const int size = s.kernel.point_history_size();
    for (int i = 1; i <= 200; ++i) {
      const double l = std::exp(2.5 * std::sin(1.7 * i));
      Mat3 F = Vec3(l, 1.0 / std::sqrt(l), 1.0 / std::sqrt(l)).asDiagonal();
      F(0, 1) = 5.0 * std::sin(0.9 * i);
      s.advance(random.rotation() * F * s.X, 0.05);
      EXPECT_TRUE(std::isfinite(s.energy)) << i;
      EXPECT_GT(s.energy, -1e-12) << i;    // 0 if molten
      EXPECT_TRUE(std::isfinite(s.dissipation)) << i;
      EXPECT_GT(s.flown().strain, 0.1 * i) << i;
      for (int p = 0; p < 8; ++p) {
        const double *B = s.history() + p * size + 6;
        Mat3 A;
        A << 1.0 + B[0], B[3], B[4], B[3], 1.0 + B[1], B[5], B[4], B[5], 1.0 + B[2];
        EXPECT_NEAR(A.determinant(), 1.0, 1e-6 * std::pow(A.norm(), 3)) << i;
      }
    }
  }
}

/// Plastic moment of a bar of height and width 1 in plane strain by that of beam theory, 2/sqrt(3) sigma_y/4: a
/// column of cubes, whose ends are turned against each other, crept into equilibrium.
double plastic_moment(int layers)
{
  Plastic m = metal(400e6, 0.0);
  const double h = 1.0 / layers;
  Mesh column;
  for (int j = 0; j <= layers; ++j)
    for (int i = 0; i < 2; ++i)
      for (int k = 0; k < 2; ++k) column.X.emplace_back((i - 0.5) * h, j * h - 0.5, k * h);
  const auto node = [](int i, int j, int k) {
    return 4 * j + 2 * i + k;
  };
  for (int j = 0; j < layers; ++j) {
    std::array<int, 8> hex;
    for (int a = 0; a < 8; ++a)
      hex[a] =
          node((hex_sign[a][0] + 1) / 2, j + (hex_sign[a][1] + 1) / 2, (hex_sign[a][2] + 1) / 2);
    column.hexes.push_back(hex);
  }
  const PlasticKernel kernel(m);
  const Histories state(kernel, layers);
  const size_t n = column.X.size();
  const double dt = 0.5 * critical_step_fbar(column.shape(0), kernel.material()),
               mass = nodal_mass(column.shape(0), m.rho);
  std::vector<Vec3> x = column.X;
  std::vector<double> f(3 * n), v(n, 0.0);
  const int steps = 20000;
  const double strain = 0.02;    // of the outer fibre: ten times that at yield
  double moment = 0.0;
  for (int i = 1; i <= steps; ++i) {
    for (size_t a = 0; a < n; ++a)
      x[a][0] = column.X[a][0] * (1.0 + 2.0 * strain * i / steps * column.X[a][1]);
    std::fill(f.begin(), f.end(), 0.0);
    kernel.add_forces(layers, column.nodes(), x[0].data(), column.coordinates(), f.data(),
                      state.output(dt));
    moment = 0.0;
    for (size_t a = 0; a < n; ++a) {
      v[a] = 0.9 * (v[a] + dt / mass * f[3 * a + 1]);
      x[a][1] += dt * v[a];
      if (column.X[a][0] > 0.0) moment -= f[3 * a] * column.X[a][1] / h;
    }
  }
  return moment / (m.yield * 2.0 / std::sqrt(3.0) * 0.25);
}

TEST(Plastic, LimitLoadOfABarInBendingDoesNotLock)
{
  // a part of each element's strength goes into parasitic shear, as the square of its size
  const double two = plastic_moment(2), four = plastic_moment(4), eight = plastic_moment(8);
  EXPECT_NEAR(four, 1.0, 0.025);
  EXPECT_NEAR(eight, 1.0, 0.01);
  EXPECT_LT(eight - 1.0, 0.4 * (four - 1.0));
  EXPECT_LT(four - 1.0, 0.4 * (two - 1.0));
}

TEST(Plastic, ValuesOutOfRangeAreRefused)
{
  const auto refused = [](const Plastic &m, const std::string &text) {
    EXPECT_NE(m.validate().find(text), std::string::npos) << m.validate();
    EXPECT_THROW(PlasticKernel kernel(m), std::invalid_argument);
  };
  refused(metal(0.0, 1e9), "yield stress must be positive");
  refused(metal(400e9, 1e9), "check the units");
  refused(metal(400e6, -1e9), "hardening must not be negative");
  refused(metal(400e6, std::nan("")), "hardening must not be negative");
  refused(metal(400e6, 1e9, -1.0), "kinematic");
  Plastic m = johnson_cook();
  m.exponent = 0.0;
  refused(m, "exponent");
  m = johnson_cook();
  m.rate_unit = 0.0;
  refused(m, "reference rate");
  m = johnson_cook();
  m.melting = -3.0;
  refused(m, "melting");
}

}    // namespace
