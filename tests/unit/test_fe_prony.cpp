// Viscoelastic hexahedra: relaxation, creep, oscillation and start of shear flow against closed
// forms; what the history is worth in energy; objectivity; lists of elements.

#include "test_fe_common.h"

#include "defe/fe/mooney_rivlin.h"
#include "defe/fe/prony.h"
#include "defe/fe/stable_step.h"

#include <gtest/gtest.h>

#include <complex>
#include <functional>
#include <stdexcept>

using namespace defe;
using namespace defe::fe;
using namespace defe::fe::test;

namespace {

// glass-like at once, rubber-like after long; three decades of decay
const Prony pvb{20e9, 1100.0, 0.69e6, {{0.2e9, 12.6}, {0.1e9, 300.0}, {0.03e9, 5e4}}};
// of order 1
const Prony soft{2.0, 1.0, 0.3, {{0.5, 1.0}, {0.2, 7.0}}};

/// Relaxation modulus at time t after the strain has risen in the time `rise` before.
double modulus(const Prony &m, double t, double rise)
{
  double G = m.G_inf;
  for (const auto &term : m.terms) {
    const double h = term.beta * rise;
    G += term.G * -std::expm1(-h) / h * std::exp(-term.beta * t);
  }
  return G;
}

/// One element with its history.
struct Sample {
  PronyKernel kernel;
  HexCoords X;
  Histories state;
  double energy = 0.0, dissipation = 0.0;

  Sample(const Prony &m, const HexCoords &X) : kernel(m), X(X), state(kernel, 1) {}

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

  Mat3 stress(const HexCoords &x, const Vec3 &xi = Vec3::Zero()) const
  {
    return kernel.stress(x, X, xi, history());
  }
};

Mat3 simple_shear(double g)
{
  Mat3 F = Mat3::Identity();
  F(0, 1) = g;
  return F;
}

/// G times the deviator of b/J^(2/3), by J: Cauchy stress of a neo-Hookean body less its pressure
Mat3 shear_stress(double G, const Mat3 &F)
{
  const double J = F.determinant();
  const Mat3 b = std::cbrt(1.0 / (J * J)) * F * F.transpose();
  return G / J * (b - b.trace() / 3.0 * Mat3::Identity());
}

TEST(Prony, HeldStrainRelaxesByTheSeriesHoweverLargeItIs)
{
  // The strain rises within the first step and is held then. Steps of any length.
  for (const Prony &m : {soft, pvb})
    for (unsigned seed = 0; seed < 10; ++seed) {
      Random random(seed);
      Sample s(m, random_hex(random));
      Mat3 F;
      do F = Mat3::Identity() + random.matrix<Mat3>(0.8);
      while (F.determinant() < 0.2);
      const HexCoords x = F * s.X;
      const double pressure = m.K * (F.determinant() - 1.0), unit = 1.0 / m.terms[0].beta;
      double t = 0.0, rise = 0.0;
      for (int i = 0; i < 50; ++i) {
        const double dt = unit * std::pow(10.0, random.uniform(-5.0, -0.5));
        if (i == 0)
          rise = dt;
        else
          t += dt;
        s.advance(x, dt);
        const Mat3 expected = shear_stress(modulus(m, t, rise), F) + pressure * Mat3::Identity();
        for (const Vec3 &xi : {Vec3(0.0, 0.0, 0.0), Vec3(1.0, -1.0, 0.3)})
          EXPECT_LT((s.stress(x, xi) - expected).norm(),
                    2e-13 * (expected.norm() + m.G_0() + std::abs(m.K)))
              << t;
      }
    }
}

TEST(Prony, FastIsGlassAndSlowIsRubber)
{
  Random random(1);
  const HexCoords X = random_hex(random);
  const HexCoords x = X + random.matrix<HexCoords>(0.15);
  const MooneyRivlinKernel glassy({0.5 * pvb.G_0(), 0.0, pvb.K, pvb.rho}),
      rubbery({0.5 * pvb.G_inf, 0.0, pvb.K, pvb.rho});
  const HexCoords at_once = forces(glassy, x, X), after_long = forces(rubbery, x, X);
  ASSERT_GT((at_once - after_long).norm(), 0.01 * at_once.norm());

  Sample s(pvb, X);
  EXPECT_LT((s.advance(x, 0.0) - at_once).norm(), 1e-14 * at_once.norm());
  EXPECT_NEAR(s.energy, glassy.energy(x, X), 1e-13 * s.energy);
  EXPECT_LT((s.advance(x, 1e-12) - at_once).norm(), 1e-7 * at_once.norm());
  s.advance(x, 10.0);
  s.advance(x, 10.0);
  // rounding: of G_0 where only G_inf is left
  EXPECT_LT((s.advance(x, 10.0) - after_long).norm(), 1e-13 * at_once.norm());
  EXPECT_NEAR(s.energy, rubbery.energy(x, X), 1e-13 * s.energy);
}

TEST(Prony, HalvesOfAStepAtHeldStrainMakeTheStep)
{
  Random random(2);
  const HexCoords X = random_hex(random), x = X + random.matrix<HexCoords>(0.1);
  Sample one(soft, X), two(soft, X);
  one.advance(x, 0.1);
  two.advance(x, 0.1);
  one.advance(x, 0.5);
  for (int i = 0; i < 5; ++i) two.advance(x, 0.1);
  for (size_t i = 0; i < one.state.values.size(); ++i)
    EXPECT_NEAR(one.state.values[i], two.state.values[i], 1e-15);
  EXPECT_NEAR(one.dissipation, two.dissipation, 1e-15);
}

TEST(Prony, StartOfSimpleShearAtLargeStrain)
{
  // the network of Green and Tobolsky (upper-convected Maxwell) at shear rate k from rest:
  // sigma_xy = G_inf g + sum G k/beta (1 - e^-bt),
  // sigma_xx - sigma_yy = G_inf g^2 + sum 2 G (k/beta)^2 (1 - (1 + bt) e^-bt), sigma_yy = sigma_zz
  const double k = 3.0, time = 2.0;
  double error[2];
  for (int fine = 0; fine < 2; ++fine) {
    Sample s(soft, box(1.0, 0.5, 2.0));
    const int steps = fine ? 400 : 200;
    for (int i = 1; i <= steps; ++i)
      s.advance(simple_shear(k * time * i / steps) * s.X, time / steps);
    const double g = k * time;
    double xy = soft.G_inf * g, normal = soft.G_inf * g * g;
    for (const auto &term : soft.terms) {
      const double h = term.beta * time, w = k / term.beta;
      xy += term.G * w * -std::expm1(-h);
      normal += 2.0 * term.G * w * w * (1.0 - (1.0 + h) * std::exp(-h));
    }
    const Mat3 sigma = s.stress(simple_shear(g) * s.X);
    EXPECT_NEAR(sigma(0, 1), xy, 1e-4 * xy);
    EXPECT_NEAR(sigma(0, 0) - sigma(1, 1), normal, 1e-4 * normal);
    EXPECT_NEAR(sigma(1, 1), sigma(2, 2), 1e-14);
    error[fine] = sigma(0, 0) - sigma(1, 1) - normal;
  }
  EXPECT_NEAR(error[0] / error[1], 4.0, 0.1);
}

TEST(Prony, FastTermsKeepTheirViscosityInLongSteps)
{
  // decayed within a step or not, a slow flow at rate k meets the viscosity G/beta
  const double k = 1e-4, dt = 0.5;
  for (double beta : {0.5, 5.0, 500.0, 5e5}) {
    Sample s({1e7, 1.0, 0.1, {{beta, beta}}}, box(1.0, 1.0, 1.0));
    const int steps = 100;
    for (int i = 1; i <= steps; ++i) s.advance(simple_shear(k * i * dt) * s.X, dt);
    const double g = k * steps * dt;
    EXPECT_NEAR(s.stress(simple_shear(g) * s.X)(0, 1), 0.1 * g + k, 1e-9) << beta;
  }
}

TEST(Prony, Creep)
{
  // standard linear solid under constant shear stress:
  // g = stress [1/G_inf - (1/G_inf - 1/G_0) exp(-beta t G_inf/G_0)]
  const Prony m{10.0, 1.0, 0.25, {{0.75, 2.0}}};
  const double target = 1e-4, dt = 0.01;
  Sample s(m, box(1.0, 1.0, 1.0));
  for (int i = 0; i <= 1000; ++i) {
    // the stress is linear in g to 1e-8, for given history
    const std::vector<double> before = s.state.values;
    const auto at = [&](double g) {
      s.state.values = before;
      s.advance(simple_shear(g) * s.X, i == 0 ? 1e-9 : dt);
      return s.stress(simple_shear(g) * s.X)(0, 1);
    };
    const double low = at(0.0), high = at(1e-4);
    const double g = 1e-4 * (target - low) / (high - low);
    EXPECT_NEAR(at(g), target, 1e-10);
    const double t = i * dt;
    const double expected = target * (4.0 - (4.0 - 1.0) * std::exp(-2.0 * t * 0.25));
    EXPECT_NEAR(g, expected, 1e-5 * expected) << t;
  }
}

TEST(Prony, StorageAndLossModulus)
{
  // small shear g0 sin(w t): G' + i G'' = G_inf + sum G i w/(beta + i w); the energy lost in a cycle
  // is pi g0^2 G'' per volume, and none is stored
  const double g0 = 1e-4;
  for (double w : {0.1, 1.0, 5.0, 40.0}) {
    Sample s(soft, box(1.0, 2.0, 0.5));    // of volume 1
    const int per_cycle = 1000;
    const double period = 2.0 * M_PI / w, dt = period / per_cycle;
    // from rest to beyond all transients
    const int cycles = 2 + int(std::ceil(20.0 / period));
    std::complex<double> G = 0.0;
    double start_energy = 0.0, start_dissipation = 0.0;
    for (int i = 1; i <= cycles * per_cycle; ++i) {
      const HexCoords x = simple_shear(g0 * std::sin(w * i * dt)) * s.X;
      s.advance(x, dt);
      if (i == (cycles - 1) * per_cycle) {
        start_energy = s.energy;
        start_dissipation = s.dissipation;
      }
      if (i > (cycles - 1) * per_cycle)
        G += 2.0 / per_cycle / g0 * s.stress(x)(0, 1) *
            std::complex<double>(std::sin(w * i * dt), std::cos(w * i * dt));
    }
    std::complex<double> expected = soft.G_inf;
    for (const auto &term : soft.terms)
      expected += term.G * std::complex<double>(0.0, w) / std::complex<double>(term.beta, w);
    EXPECT_NEAR(G.real(), expected.real(), 1e-5) << w;
    EXPECT_NEAR(G.imag(), expected.imag(), 1e-5) << w;
    const double lost = s.dissipation - start_dissipation;
    EXPECT_NEAR(lost, M_PI * g0 * g0 * expected.imag(), 1e-4 * lost) << w;
    EXPECT_NEAR(s.energy, start_energy, 1e-5 * lost) << w;
  }
}

TEST(Prony, HeldStrainTurnsStoredEnergyIntoDissipation)
{
  for (unsigned seed = 0; seed < 5; ++seed) {
    Random random(seed);
    Sample s(soft, random_hex(random));
    const HexCoords x = s.X + random.matrix<HexCoords>(0.15);
    s.advance(x, 1e-3);
    const double start = s.energy;
    double dissipation = s.dissipation = 0.0, energy = start;
    for (int i = 0; i < 40; ++i) {
      s.advance(x, random.uniform(0.0, 0.5));
      EXPECT_GT(s.dissipation, dissipation);
      EXPECT_LT(s.energy, energy);
      EXPECT_NEAR(s.energy + s.dissipation, start, 1e-14 * start);
      dissipation = s.dissipation;
      energy = s.energy;
    }
    EXPECT_GT(dissipation, 0.1 * start);
  }
}

TEST(Prony, DissipationOfSmallStrainsKeepsItsDigits)
{
  // in one step of h = 1e-6 at a shear of 1e-5: 1e-16 of G_0; ten equal steps lose ten times as much
  Sample s(soft, box(1.0, 1.0, 1.0));
  const HexCoords x = simple_shear(1e-5) * s.X;
  s.advance(x, 1e-12);
  s.dissipation = 0.0;
  for (int i = 0; i < 10; ++i) s.advance(x, 1e-6);
  double rate = 0.0;
  for (const auto &term : soft.terms) rate += term.G * term.beta * 1e-10;
  EXPECT_NEAR(s.dissipation, 1e-5 * rate, 1e-3 * 1e-5 * rate);
}

TEST(Prony, WorkIsStoredOrDissipated)
{
  // an element twisted and stretched to and fro; work by the trapezoidal rule as velocity Verlet
  // does it
  Random random(7);
  const HexCoords X = random_hex(random), A = random.matrix<HexCoords>(0.15),
                  B = random.matrix<HexCoords>(0.15);
  const auto imbalance = [&](int steps) {
    Sample s(soft, X);
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
    EXPECT_GT(s.dissipation, 0.1 * std::abs(work));
    EXPECT_GE(lowest, 0.0);
    EXPECT_NEAR(s.energy, s.kernel.energy(x, X, s.history()), 1e-14);
    return (work - s.energy - s.dissipation) / s.dissipation;
  };
  const double coarse = imbalance(300), fine = imbalance(600);
  EXPECT_LT(std::abs(fine), 1e-3);
  EXPECT_NEAR(coarse / fine, 4.0, 0.4);
}

TEST(Prony, ExplicitRunBalancesEnergy)
{
  // a block of one element thrown out of shape in the units of a real interlayer; decay within the
  // run (300/s would do nothing in it)
  Prony m = pvb;
  m.terms[0].beta = 1e6;
  m.terms[1].beta = 2e5;
  const HexCoords X = box(1e-3, 1e-3, 0.76e-3);
  const auto drift = [&](double factor) {
    Random random(8);
    Sample s(m, X);
    const double mass = nodal_mass(X, m.rho),
                 dt = factor * critical_step_fbar(X, s.kernel.material());
    HexCoords x = X, v = random.matrix<HexCoords>(50.0), f = HexCoords::Zero();
    const double start = 0.5 * mass * v.squaredNorm();
    double worst = 0.0;
    for (int i = 0; i < int(400 / factor); ++i) {
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
  EXPECT_LT(coarse, 0.02);
  EXPECT_NEAR(coarse / fine, 4.0, 1.0);
}

TEST(Prony, RotationInEveryStepChangesNothingButTheAxes)
{
  Random random(9);
  const HexCoords X = random_hex(random), A = random.matrix<HexCoords>(0.15);
  Sample still(soft, X), turning(soft, X);
  for (int i = 1; i <= 50; ++i) {
    const HexCoords x = X + std::sin(0.2 * i) * A;
    const Mat3 R = random.rotation();
    const HexCoords turned = (R * x).colwise() + random.matrix<Vec3>(1.0);
    const HexCoords f = still.advance(x, 0.1), g = turning.advance(turned, 0.1);
    EXPECT_LT((g - R * f).norm(), 1e-13);
    const Vec3 xi = random.matrix<Vec3>(1.0);
    EXPECT_LT((turning.stress(turned, xi) - R * still.stress(x, xi) * R.transpose()).norm(), 1e-13);
  }
  for (size_t i = 0; i < still.state.values.size(); ++i)
    EXPECT_NEAR(still.state.values[i], turning.state.values[i], 1e-13);
  EXPECT_NEAR(still.dissipation, turning.dissipation, 1e-13);
}

TEST(Prony, WithoutTimeNothingAdvancesAndNothingChanges)
{
  Random random(10);
  const HexCoords X = random_hex(random);
  Sample s(soft, X);
  HexCoords x, f;
  for (int i = 0; i < 5; ++i) f = s.advance(x = X + random.matrix<HexCoords>(0.1), 0.3);
  const std::vector<double> history = s.state.values;
  const double energy = s.energy, dissipation = s.dissipation;
  EXPECT_EQ((s.advance(x, 0.0) - f).norm(), 0.0);    // bit for bit
  EXPECT_EQ(s.energy, energy);
  EXPECT_EQ(s.dissipation, dissipation);
  // elsewhere as well
  s.advance(X, 0.0);
  EXPECT_EQ(s.state.values, history);
  EXPECT_EQ(s.dissipation, dissipation);
}

namespace {

  /// Elements of any shape, deformed, with nodes of their own.
  struct Separate {
    std::vector<std::array<int, 8>> hexes;
    std::vector<HexCoords> x, X;

    Separate(int n, Random &random) : hexes(n), x(n), X(n)
    {
      for (int e = 0; e < n; ++e) {
        for (int a = 0; a < 8; ++a) hexes[e][a] = 8 * e + a;
        X[e] = random_hex(random);
        x[e] = X[e] + random.matrix<HexCoords>(0.1);
      }
    }
    const int (*nodes() const)[8] { return reinterpret_cast<const int(*)[8]>(hexes.data()); }
  };

}    // namespace

TEST(Prony, ListsOfAnyLengthAndAnyOutputsAdvanceAlike)
{
  const PronyKernel kernel(soft);
  Random random(11);
  for (int n : {1, 3, 8, 19}) {
    Separate elements(n, random);
    std::vector<HexCoords> &x = elements.x, &X = elements.X;
    const auto nodes = elements.nodes();
    Histories whole(kernel, n), pieces(kernel, n), all(kernel, n);
    std::vector<double> f(24 * n), f_pieces(24 * n), f_all(24 * n), energy(n), bound(n);
    double dissipation = 0.0, dissipation_pieces = 0.0, virial[6] = {};
    for (int step = 0; step < 3; ++step) {
      std::fill(f.begin(), f.end(), 0.0);
      f_pieces = f_all = f;
      HexKernel::Output out = whole.output(0.2);
      out.dissipation = &dissipation;
      kernel.add_forces(n, nodes, x[0].data(), X[0].data(), f.data(), out);
      for (int e = 0; e < n; ++e) {
        HexKernel::Output one = pieces.output(0.2);
        one.history = pieces.of_element.data() + e;
        one.dissipation = &dissipation_pieces;
        kernel.add_forces(1, nodes + e, x[0].data(), X[0].data(), f_pieces.data(), one);
      }
      HexKernel::Output every = all.output(0.2);
      every.energy = energy.data();
      every.stress_bound = bound.data();
      every.virial = virial;
      kernel.add_forces(n, nodes, x[0].data(), X[0].data(), f_all.data(), every);
      for (HexCoords &xe : x) xe += random.matrix<HexCoords>(0.02);
    }
    EXPECT_EQ(f, f_pieces);
    EXPECT_EQ(whole.values, pieces.values);
    EXPECT_NEAR(dissipation, dissipation_pieces, 1e-15 * n);
    EXPECT_GT(dissipation, 0.0);
    for (size_t i = 0; i < whole.values.size(); ++i)
      EXPECT_NEAR(whole.values[i], all.values[i], 1e-15);
    for (int i = 0; i < 24 * n; ++i) EXPECT_NEAR(f[i], f_all[i], 1e-14);
  }
}

TEST(Prony, LostElementsLeaveTheirNeighboursAlone)
{
  const PronyKernel kernel(soft);
  Random random(12);
  const int n = 11;
  Separate elements(n, random);
  std::vector<HexCoords> &x = elements.x, &X = elements.X;
  const auto nodes = elements.nodes();
  const auto run = [&](Histories &h, std::vector<double> &f, double &dissipation) {
    int inverted = 99;
    HexKernel::Output out = h.output(0.2);
    out.inverted = &inverted;
    out.dissipation = &dissipation;
    kernel.add_forces(n, nodes, x[0].data(), X[0].data(), f.data(), out);
    return inverted;
  };
  Histories sound(kernel, n), damaged(kernel, n);
  std::vector<double> f(24 * n, 0.0), g(24 * n, 0.0);
  double lost = 0.0, lost_damaged = 0.0;
  EXPECT_EQ(run(sound, f, lost), -1);
  x[4].row(1) *= -1.0;
  x[9](0, 3) = std::nan("");
  EXPECT_EQ(run(damaged, g, lost_damaged), 4);
  EXPECT_TRUE(std::isnan(lost_damaged));
  for (int e = 0; e < n; ++e)
    for (int i = 0; i < 24; ++i) {
      if (e == 4 || e == 9)
        EXPECT_TRUE(std::isnan(g[24 * e + i]));
      else
        EXPECT_EQ(g[24 * e + i], f[24 * e + i]);
    }
  const int size = kernel.history_size();
  for (int e : {0, 3, 5, 8, 10})
    for (int i = 0; i < size; ++i) EXPECT_EQ(damaged.of_element[e][i], sound.of_element[e][i]) << e;
  EXPECT_TRUE(std::isnan(kernel.energy(x[4], X[4])));
  EXPECT_TRUE(std::isnan(kernel.energy(x[9], X[9])));
}

TEST(Prony, GrosslyStrainedElementsStayStable)
{
  // crushed to 5 %, stretched twentyfold, sheared by 10, over many decay times: A stays positive
  // definite, energy and dissipation finite and positive
  Random random(13);
  Sample s(soft, box(1.0, 1.0, 1.0));
  double dissipation = 0.0;
  for (int i = 1; i <= 400; ++i) {
    const double l = std::exp(3.0 * std::sin(0.05 * i));
    Mat3 F = Vec3(l, 1.0 / std::sqrt(l), 1.0 / std::sqrt(l)).asDiagonal();
    F(0, 1) = 10.0 * std::sin(0.02 * i);
    s.advance(random.rotation() * F * s.X, 0.05);
    EXPECT_TRUE(std::isfinite(s.energy));
    EXPECT_GT(s.energy, 0.0);
    EXPECT_GT(s.dissipation, dissipation);
    dissipation = s.dissipation;
  }
}

TEST(Prony, NeedsItsHistoryAndATime)
{
  const PronyKernel kernel(soft);
  EXPECT_EQ(kernel.history_size(), 8 * 6 * 3);
  const HexCoords X = box(1.0, 1.0, 1.0);
  HexCoords f = HexCoords::Zero();
  HexKernel::Output none;
  EXPECT_THROW(kernel.add_forces(1, first_hex, X.data(), X.data(), f.data(), none),
               std::invalid_argument);
  const Histories h(kernel, 1);
  EXPECT_THROW(kernel.add_forces(1, first_hex, X.data(), X.data(), f.data(), h.output(-1.0)),
               std::invalid_argument);
  EXPECT_THROW(
      kernel.add_forces(1, first_hex, X.data(), X.data(), f.data(), h.output(std::nan(""))),
      std::invalid_argument);
  EXPECT_NO_THROW(kernel.add_forces(0, first_hex, X.data(), X.data(), f.data(), none));
}

TEST(Prony, WithoutTermsIsNeoHooke)
{
  Random random(14);
  const HexCoords X = random_hex(random), x = X + random.matrix<HexCoords>(0.1);
  Sample s({2.0, 1.0, 0.6, {}}, X);
  const MooneyRivlinKernel neo_hooke({0.3, 0.0, 2.0, 1.0});
  EXPECT_LT((s.advance(x, 0.1) - forces(neo_hooke, x, X)).norm(), 1e-14);
  EXPECT_EQ(s.dissipation, 0.0);
}

TEST(Prony, RefusesBadConstants)
{
  EXPECT_EQ(pvb.validate(), "");
  EXPECT_EQ(soft.validate(), "");
  const auto complaint = [](const std::function<void(Prony &)> &change) {
    Prony m = soft;
    change(m);
    return m.validate();
  };
  EXPECT_NE(complaint([](Prony &m) {
              m.K = 0.1;
            }).find("bulk modulus"),
            std::string::npos);
  EXPECT_NE(complaint([](Prony &m) {
              m.K = std::nan("");
            }).find("bulk modulus"),
            std::string::npos);
  EXPECT_NE(complaint([](Prony &m) {
              m.K = 1e20;
            }).find("too large"),
            std::string::npos);
  EXPECT_NE(complaint([](Prony &m) {
              m.rho = 0.0;
            }).find("density"),
            std::string::npos);
  EXPECT_NE(complaint([](Prony &m) {
              m.G_inf = -1.0;
            }).find("G_inf"),
            std::string::npos);
  EXPECT_NE(complaint([](Prony &m) {
              m.terms[1].G = 0.0;
            }).find("G of Prony term 2"),
            std::string::npos);
  EXPECT_NE(complaint([](Prony &m) {
              m.terms[0].beta = -3.0;
            }).find("beta of Prony term 1"),
            std::string::npos);
  EXPECT_NE(complaint([](Prony &m) {
              m.G_inf = 0.0;
              m.terms.clear();
            }).find("needs G_inf > 0 or a term"),
            std::string::npos);
  EXPECT_NE(complaint([](Prony &m) {
              m.terms.resize(33, m.terms[0]);
            }).find("32 terms"),
            std::string::npos);
  EXPECT_THROW(PronyKernel(Prony{}), std::invalid_argument);
}

}    // namespace
