// What all kernels have in common: forces are the exact gradient of the energy, rigid motions
// cost nothing, both momenta balance; and what relates them to each other.
//
// Sizes, moduli and forces are of order 1, so a tolerance of 1e-14 means some 50 roundings.

#include "test_fe_common.h"

#include "defe/fe/enhanced_kernel.h"
#include "defe/fe/mooney_rivlin.h"
#include "defe/fe/plastic.h"
#include "defe/fe/principal.h"
#include "defe/fe/prony.h"

#include <Eigen/Eigenvalues>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <functional>
#include <memory>
#include <stdexcept>
#include <string>

using namespace defe;
using namespace defe::fe;
using namespace defe::fe::test;

namespace {

struct Case {
  std::string name;
  HexCoords X;
  std::unique_ptr<HexKernel> kernel;
  std::vector<double> history;    // empty: never strained

  const double *state() const { return history.empty() ? nullptr : history.data(); }
};

/// The laws with F-bar, at strains where they are neither new nor linear: the Cauchy stress of a
/// uniform deformation that comes at once.
Mat3 rubber_stress(const Mat3 &F, double C10, double C01, double K)
{
  const double J = F.determinant();
  const Mat3 b = std::cbrt(1.0 / (J * J)) * F * F.transpose();
  const Mat3 s = 2.0 * (C10 + C01 * b.trace()) * b - 2.0 * C01 * b * b;
  return (s - s.trace() / 3.0 * Mat3::Identity()) / J + K * (J - 1.0) * Mat3::Identity();
}

// with the small-strain constants of `unit`
MooneyRivlin unit_rubber()
{
  return {0.3 * unit.mu(), 0.2 * unit.mu(), unit.bulk(), unit.rho};
}

Prony unit_prony()
{
  return {
      unit.bulk(), unit.rho, 0.3 * unit.mu(), {{0.5 * unit.mu(), 10.0}, {0.2 * unit.mu(), 1.0}}};
}

Plastic unit_metal(bool johnson_cook)
{
  Plastic m;
  m.K = unit.bulk();
  m.G = unit.mu();
  m.rho = unit.rho;
  m.yield = 0.2 * unit.mu();
  m.hardening = m.kinematic = 0.1;
  if (johnson_cook) m.exponent = 0.3;
  return m;
}

bool is_fbar(const Case &c)
{
  return dynamic_cast<const FBarKernel *>(c.kernel.get());
}

bool is_enhanced(const Case &c)
{
  return c.name.rfind("enhanced", 0) == 0;
}

HexCoords random_box(Random &random)
{
  const HexCoords X =
      box(random.uniform(0.5, 2.0), random.uniform(0.5, 2.0), random.uniform(0.5, 2.0));
  return (random.rotation() * X).colwise() + random.matrix<Vec3>(1.0);
}

std::vector<Case> all_kernels(unsigned seed, bool with_history = false)
{
  Random random(seed);
  std::vector<Case> cases(12);
  cases[0].name = "brick";
  cases[0].X = random_box(random);
  cases[0].kernel = std::make_unique<BrickKernel>(cases[0].X, unit, ElementType::plain);
  cases[1].name = "lagrangian";
  cases[1].X = random_hex(random);
  cases[1].kernel = std::make_unique<LagrangianKernel>(unit);
  cases[2].name = "lagrangian box";
  cases[2].X = random_box(random);
  cases[2].kernel = std::make_unique<LagrangianKernel>(unit);
  cases[3].name = "mooney";
  cases[3].X = random_hex(random);
  cases[3].kernel = std::make_unique<MooneyRivlinKernel>(unit_rubber());
  cases[4].name = "mooney box";
  cases[4].X = random_box(random);
  cases[4].kernel = std::make_unique<MooneyRivlinKernel>(unit_rubber());
  cases[5].name = "prony";
  cases[5].X = random_hex(random);
  cases[5].kernel = std::make_unique<PronyKernel>(unit_prony());
  cases[6].name = "prony box";
  cases[6].X = random_box(random);
  cases[6].kernel = std::make_unique<PronyKernel>(unit_prony());
  cases[7].name = "enhanced brick";
  cases[7].X = random_box(random);
  cases[7].kernel = std::make_unique<BrickKernel>(cases[7].X, unit);
  cases[8].name = "enhanced";
  cases[8].X = random_hex(random);
  cases[8].kernel = std::make_unique<EnhancedKernel>(unit);
  cases[9].name = "enhanced box";
  cases[9].X = random_box(random);
  cases[9].kernel = std::make_unique<EnhancedKernel>(unit);
  for (int i = 10; i < 12; ++i) {
    cases[i].name = i == 10 ? "plastic" : "johnson-cook";
    cases[i].X = random_hex(random);
    cases[i].kernel = std::make_unique<PlasticKernel>(unit_metal(i == 11));
  }
  if (with_history)
    for (Case &c : cases)
      for (int i = 0; i < c.kernel->history_size(); ++i)
        c.history.push_back(random.uniform(-0.2, 0.2));
  return cases;
}

/// Every node moved on its own by up to `strain`, then everything turned and shifted.
HexCoords deformed(Random &random, const HexCoords &X, double strain)
{
  return (random.rotation() * (X + random.matrix<HexCoords>(strain))).colwise() +
      random.matrix<Vec3>(1.0);
}

/// -dW/dx by central differences of fourth order. The step balances truncation (step^4) against
/// rounding (1e-16/step): some 1e-12 of either.
HexCoords differenced_forces(const HexKernel &kernel, const HexCoords &x, const HexCoords &X,
                             const double *history)
{
  const double step = 1e-3;
  HexCoords f;
  for (int i = 0; i < 24; ++i) {
    const auto W = [&](double s) {
      HexCoords moved = x;
      moved.data()[i] += s;
      return kernel.energy(moved, X, history);
    };
    f.data()[i] = -(8.0 * (W(step) - W(-step)) - (W(2.0 * step) - W(-2.0 * step))) / (12.0 * step);
  }
  return f;
}

TEST(Kernel, ForceIsTheGradientOfTheEnergy)
{
  for (unsigned seed = 0; seed < 10; ++seed)
    for (const Case &c : all_kernels(seed, true)) {
      Random random(100 + seed);
      const HexCoords x = deformed(random, c.X, 0.2);
      const HexCoords f = forces(*c.kernel, x, c.X, c.state()),
                      g = differenced_forces(*c.kernel, x, c.X, c.state());
      EXPECT_LT((f - g).norm(), 1e-9 * f.norm()) << c.name;
      EXPECT_GT(f.norm(), 0.01);
    }
}

TEST(Kernel, ForceIsTheGradientFarBeyondSmallStrain)
{
  // Stretches of 1/3 to 3 and shears of 1: the rotation does not come from the series here.
  for (unsigned seed = 0; seed < 10; ++seed)
    for (const Case &c : all_kernels(seed, true)) {
      Random random(200 + seed);
      Mat3 F;
      F << 3.0, 1.0, 0.0, 0.0, 1.0, -1.0, 0.0, 0.0, 1.0 / 3.0;
      const HexCoords x =
          random.rotation() * F * (random.rotation() * c.X + random.matrix<HexCoords>(0.02));
      const HexCoords f = forces(*c.kernel, x, c.X, c.state()),
                      g = differenced_forces(*c.kernel, x, c.X, c.state());
      EXPECT_LT((f - g).norm(), 1e-8 * f.norm()) << c.name;
    }
}

TEST(Kernel, ForceIsTheGradientAtSmallStrain)
{
  // Where boxes have their rotation by the series, on either side of where they do not any more.
  for (double strain : {1e-4, 1e-3, 3e-3, 6e-3, 1e-2})
    for (unsigned seed = 0; seed < 4; ++seed)
      for (const Case &c : all_kernels(seed, true)) {
        Random random(250 + seed);
        const HexCoords x = deformed(random, c.X, strain);
        const HexCoords f = forces(*c.kernel, x, c.X, c.state()),
                        g = differenced_forces(*c.kernel, x, c.X, c.state());
        EXPECT_LT((f - g).norm(), 1e-9 * f.norm() + 2e-12) << c.name << " " << strain;
      }
}

TEST(Kernel, BricksHaveTheSameEnergyByTheSeriesAsByIteration)
{
  // energy() iterates for the rotation. A stretch that is wrong by d makes the energy wrong by E strain d.
  for (unsigned seed = 0; seed < 4; ++seed)
    for (ElementType type : {ElementType::plain, ElementType::enhanced}) {
      Random random(270 + seed);
      const HexCoords X = random_box(random);
      const BrickKernel kernel(X, unit, type);
      for (double strain : {0.0, 1e-8, 1e-5, 1e-3, 2e-3, 3e-3, 4e-3, 5e-3, 7e-3, 1e-2, 3e-2})
        for (int i = 0; i < 50; ++i) {
          const HexCoords x = deformed(random, X, strain);
          double energy;
          HexKernel::Output out;
          out.energy = &energy;
          HexCoords f = HexCoords::Zero();
          kernel.add_forces(1, first_hex, x.data(), X.data(), f.data(), out);
          EXPECT_NEAR(energy, kernel.energy(x, X), 1e-14 * strain + 1e-28) << strain;
        }
    }
}

TEST(Kernel, MomentaBalance)
{
  for (unsigned seed = 0; seed < 20; ++seed)
    for (const Case &c : all_kernels(seed, true)) {
      Random random(300 + seed);
      for (double strain : {1e-4, 1e-2, 0.2}) {
        const HexCoords x = deformed(random, c.X, strain);
        const HexCoords f = forces(*c.kernel, x, c.X, c.state());
        // a force is a sum of E h^2 (strain + rounding)
        const double tolerance = 2e-14 * strain + 1e-15;
        EXPECT_LT(f.rowwise().sum().norm(), tolerance) << c.name << " " << strain;
        EXPECT_LT(moment(x, f).norm(), 1e-13 * f.norm() + 1e-15) << c.name << " " << strain;
      }
    }
}

TEST(Kernel, RigidMotionGivesNoForce)
{
  const auto check = [](const Case &c, const Mat3 &R, const Vec3 &shift) {
    const HexCoords x = (R * c.X).colwise() + shift;
    const HexCoords f = forces(*c.kernel, x, c.X, c.state());
    EXPECT_LT(f.cwiseAbs().maxCoeff(), 1e-14 * (1.0 + shift.norm())) << c.name << "\n" << R;
  };
  Random random(4);
  for (const Case &c : all_kernels(4)) {
    for (int i = 0; i < 100; ++i) check(c, random.rotation(), random.matrix<Vec3>(10.0));
    for (int axis = 0; axis < 3; ++axis)
      for (int degrees = 0; degrees <= 360; degrees += 15)
        check(c, Eigen::AngleAxisd(degrees * M_PI / 180.0, Vec3::Unit(axis)).toRotationMatrix(),
              Vec3::Zero());
    for (int i = 0; i < 20; ++i)
      check(c, Eigen::AngleAxisd(M_PI, random.rotation().col(0)).toRotationMatrix(), Vec3::Zero());
  }
}

TEST(Kernel, UndeformedLagrangianHasExactlyNoForce)
{
  Random random(5);
  const HexCoords X = random_hex(random);
  EXPECT_EQ(forces(LagrangianKernel(unit), X, X).norm(), 0.0);
  EXPECT_EQ(forces(EnhancedKernel(unit), X, X).norm(), 0.0);
}

TEST(Kernel, RotatingAStrainedStateRotatesForcesAndStress)
{
  for (const Case &c : all_kernels(6, true)) {
    Random random(6);
    for (int i = 0; i < 20; ++i) {
      const HexCoords x = deformed(random, c.X, 0.2);
      const Mat3 R = random.rotation();
      const HexCoords turned = (R * x).colwise() + random.matrix<Vec3>(1.0);
      EXPECT_LT(
          (forces(*c.kernel, turned, c.X, c.state()) - R * forces(*c.kernel, x, c.X, c.state()))
              .norm(),
          2e-14)
          << c.name;
      EXPECT_NEAR(c.kernel->energy(turned, c.X, c.state()), c.kernel->energy(x, c.X, c.state()),
                  1e-14);
      const Vec3 xi = random.matrix<Vec3>(1.0);
      const Mat3 s = c.kernel->stress(x, c.X, xi, c.state());
      EXPECT_LT((c.kernel->stress(turned, c.X, xi, c.state()) - R * s * R.transpose()).norm(),
                1e-13);
      EXPECT_LT((s - s.transpose()).norm(), 1e-14);
    }
  }
}

/// Tangent stiffness -df/dx at the reference, by central differences of fourth order.
Eigen::Matrix<double, 24, 24> tangent(const HexKernel &kernel, const HexCoords &X)
{
  const double step = 1e-3;
  Eigen::Matrix<double, 24, 24> K;
  for (int i = 0; i < 24; ++i) {
    const auto f = [&](double s) {
      HexCoords x = X;
      x.data()[i] += s;
      return forces(kernel, x, X);
    };
    const HexCoords d =
        (8.0 * (f(step) - f(-step)) - (f(2.0 * step) - f(-2.0 * step))) / (12.0 * step);
    K.col(i) = -Eigen::Map<const Eigen::Matrix<double, 24, 1>>(d.data());
  }
  return K;
}

TEST(Kernel, SixZeroEnergyModesAndNoMore)
{
  for (unsigned seed = 0; seed < 5; ++seed)
    for (const Case &c : all_kernels(seed)) {
      const auto K = tangent(*c.kernel, c.X);
      EXPECT_LT((K - K.transpose()).norm(), 1e-9);
      const auto expected = is_fbar(c) ? stiffness_fbar(c.X, unit)
          : is_enhanced(c)             ? stiffness_enhanced(c.X, unit)
                                       : stiffness(c.X, unit);
      EXPECT_LT((K - expected).norm(), 1e-9) << c.name;
      const Eigen::VectorXd values =
          Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd>(K, Eigen::EigenvaluesOnly).eigenvalues();
      EXPECT_LT(values.head(6).cwiseAbs().maxCoeff(), 1e-9 * values[23]) << c.name;
      EXPECT_GT(values[6], 1e-3 * values[23]) << c.name;
    }
}

TEST(Kernel, UniformStrainHasTheForcesOfItsStress)
{
  // f_a = - P sum over Gauss points of grad N_a, P the first Piola-Kirchhoff stress: F S, or
  // R (C : (U - I)) for the corotational law, or J sigma F^-T.
  for (const Case &c : all_kernels(7)) {
    Random random(7);
    for (int i = 0; i < 10; ++i) {
      const Mat3 A = random.matrix<Mat3>(0.2);
      const Mat3 U = Mat3::Identity() + 0.5 * (A + A.transpose()), R = random.rotation();
      const Mat3 green = 0.5 * (U * U - Mat3::Identity());
      const bool is_lagrangian = c.kernel->uses_reference();
      const Mat3 e = is_lagrangian ? green : Mat3(U - Mat3::Identity());
      const Mat3 S = unit.lambda() * e.trace() * Mat3::Identity() + 2.0 * unit.mu() * e;
      Mat3 P = R * (is_lagrangian ? U : Mat3::Identity()) * S;
      Mat3 cauchy = is_lagrangian ? Mat3(P * U * R.transpose() / U.determinant())
                                  : Mat3(P * R.transpose());
      if (is_fbar(c)) {
        const MooneyRivlin m = unit_rubber();
        cauchy = c.name[0] == 'm' ? rubber_stress(R * U, m.C10, m.C01, m.K)
                                  : rubber_stress(R * U, 0.5 * unit.mu(), 0.0, unit.bulk());
        P = U.determinant() * cauchy * R * U.inverse();
      }

      Eigen::Matrix<double, 8, 3> flux = Eigen::Matrix<double, 8, 3>::Zero();
      for (const Vec3 &xi : gauss_points()) {
        const Mat3 J = jacobian(c.X, xi);
        flux += J.determinant() * shape_gradient(xi) * J.inverse();
      }
      const HexCoords x = R * U * c.X;
      EXPECT_LT((forces(*c.kernel, x, c.X, c.state()) + P * flux.transpose()).norm(), 1e-13)
          << c.name;
      EXPECT_LT((c.kernel->stress(x, c.X, random.matrix<Vec3>(1.0)) - cauchy).norm(), 1e-13)
          << c.name;
    }
  }
}

TEST(Kernel, UniaxialStressInclinedAndTurned)
{
  // stretched by e along n and by -nu e across: stress E e along n (first order in e)
  const double e = 1e-6;
  for (const Case &c : all_kernels(8)) {
    Random random(8);
    const Vec3 n = random.rotation().col(0);
    const Mat3 R = random.rotation();
    const Mat3 U = Mat3::Identity() * (1.0 - unit.nu * e) + (1.0 + unit.nu) * e * n * n.transpose();
    const Mat3 s = c.kernel->stress(R * U * c.X, c.X, Vec3::Zero());
    Vec3 direction;
    EXPECT_NEAR(max_principal(s, direction) / e, unit.E, 1e-5);
    EXPECT_NEAR(std::abs(direction.dot(R * n)), 1.0, 1e-8);
  }
}

// --- lists of elements and optional outputs -----------------------------------------------------

/// n separate, congruent elements, each deformed in another way.
struct Pile {
  std::vector<std::array<int, 8>> hexes;
  std::vector<double> x, X;

  Pile(Random &random, const HexCoords &shape, int n, double strain)
  {
    for (int e = 0; e < n; ++e) {
      std::array<int, 8> hex;
      for (int a = 0; a < 8; ++a) hex[a] = 8 * e + a;
      hexes.push_back(hex);
      const HexCoords xe = deformed(random, shape, strain);
      x.insert(x.end(), xe.data(), xe.data() + 24);
      X.insert(X.end(), shape.data(), shape.data() + 24);
    }
  }

  const int (*nodes() const)[8] { return reinterpret_cast<const int(*)[8]>(hexes.data()); }
  HexCoords at(int e) const { return HexCoords(x.data() + 24 * e); }
};

TEST(KernelOutput, AgreesWithTheScalarFunctionsForAnyLengthOfList)
{
  for (const Case &c : all_kernels(9, true)) {
    Random random(9);
    std::vector<int> lengths{31, 32, 33, 63, 64, 65};    // whole lots of packs, too
    for (int n = 0; n <= 20; ++n) lengths.push_back(n);
    for (int n : lengths) {
      const Pile pile(random, c.X, n, n % 3 ? 0.1 : 1e-3);
      std::vector<double> f(24 * n, 0.0), energy(n), bound(n), gauss_bound(n);
      double virial[6] = {1.0, 2.0, 3.0, 4.0, 5.0, 6.0};
      int inverted = 99;
      const Histories histories(*c.kernel, n, c.state());
      HexKernel::Output out = histories.output();
      out.energy = energy.data();
      out.stress_bound = bound.data();
      const StressBound weights = n % 2 ? StressBound() : StressBound{0.3, 1.7};
      out.bound_weights = weights;
      out.virial = virial;
      out.inverted = &inverted;
      c.kernel->add_forces(n, pile.nodes(), pile.x.data(), pile.X.data(), f.data(), out);
      EXPECT_EQ(inverted, -1);

      HexKernel::Output gauss = histories.output();
      gauss.stress_bound = gauss_bound.data();
      gauss.bound_weights = weights;
      gauss.bound_at_gauss_points = true;
      std::vector<double> again(24 * n, 0.0);
      c.kernel->add_forces(n, pile.nodes(), pile.x.data(), pile.X.data(), again.data(), gauss);

      Mat3 sum = Mat3::Zero();
      for (int e = 0; e < n; ++e) {
        const HexCoords x = pile.at(e), fe(f.data() + 24 * e);
        EXPECT_LT((HexCoords(again.data() + 24 * e) - fe).norm(), 1e-14);
        EXPECT_NEAR(energy[e], c.kernel->energy(x, c.X, c.state()), 1e-14) << c.name;
        EXPECT_NEAR(bound[e],
                    stress_bound(c.kernel->stress(x, c.X, Vec3::Zero(), c.state()), weights), 1e-13)
            << c.name;
        double largest = -HUGE_VAL;
        for (const Vec3 &xi : gauss_points())
          largest =
              std::max(largest, stress_bound(c.kernel->stress(x, c.X, xi, c.state()), weights));
        EXPECT_NEAR(gauss_bound[e], largest, 1e-13) << c.name;
        sum += x * fe.transpose();
      }
      const double expected[6] = {sum(0, 0), sum(1, 1), sum(2, 2), sum(0, 1), sum(0, 2), sum(1, 2)};
      for (int k = 0; k < 6; ++k)
        EXPECT_NEAR(virial[k] - (k + 1), expected[k], 1e-13 * (n + 1)) << c.name;
    }
  }
}

TEST(KernelOutput, EveryCombinationGivesTheSameForces)
{
  for (const Case &c : all_kernels(10, true)) {
    Random random(10);
    const int n = 11;
    const Pile pile(random, c.X, n, 0.1);
    const Histories histories(*c.kernel, n, c.state());
    std::vector<double> reference(24 * n, 0.0), energy(n), bound(n);
    double virial[6];
    c.kernel->add_forces(n, pile.nodes(), pile.x.data(), pile.X.data(), reference.data(),
                         histories.output());
    for (int wanted = 0; wanted < 8; ++wanted) {
      HexKernel::Output out = histories.output();
      if (wanted & 1) out.energy = energy.data();
      if (wanted & 2) out.stress_bound = bound.data();
      if (wanted & 4) out.virial = virial;
      std::vector<double> f(24 * n, 0.0);
      c.kernel->add_forces(n, pile.nodes(), pile.x.data(), pile.X.data(), f.data(), out);
      for (int i = 0; i < 24 * n; ++i) EXPECT_NEAR(f[i], reference[i], 1e-14);
    }
  }
}

TEST(KernelOutput, ForcesAreAddedAndSharedNodesSumUp)
{
  for (const Case &c : all_kernels(11, true)) {
    Random random(11);
    const HexCoords x = deformed(random, c.X, 0.1);
    const HexCoords start = random.matrix<HexCoords>(1.0);
    // the same element nine times: more than one pack on any machine
    std::vector<std::array<int, 8>> hexes(9, {0, 1, 2, 3, 4, 5, 6, 7});
    HexCoords f = start;
    const Histories histories(*c.kernel, 9, c.state());
    c.kernel->add_forces(9, reinterpret_cast<const int(*)[8]>(hexes.data()), x.data(), c.X.data(),
                         f.data(), histories.output());
    EXPECT_LT((f - start - 9.0 * forces(*c.kernel, x, c.X, c.state())).norm(), 1e-13) << c.name;
  }
}

TEST(KernelOutput, DoesNotDependOnHowTheListIsCut)
{
  // bit for bit, also when one of the neighbours in a pack is strained a thousand times more
  for (const Case &c : all_kernels(12, true)) {
    Random random(12);
    const int n = 75;
    Pile pile(random, c.X, n, 1e-3);
    for (int e : {3, 8, 45}) {
      const HexCoords x = deformed(random, c.X, 0.3);
      std::copy(x.data(), x.data() + 24, pile.x.begin() + 24 * e);
    }
    const Histories histories(*c.kernel, n, c.state());
    std::vector<double> whole(24 * n, 0.0), pieces(24 * n, 0.0);
    c.kernel->add_forces(n, pile.nodes(), pile.x.data(), pile.X.data(), whole.data(),
                         histories.output());
    for (int e = 0; e < n; ++e)
      c.kernel->add_forces(1, pile.nodes() + e, pile.x.data(), pile.X.data(), pieces.data(),
                           histories.output());
    EXPECT_EQ(whole, pieces) << c.name;
  }
}

TEST(KernelOutput, ReportsTheFirstLostElementAndLeavesTheOthersAlone)
{
  for (const Case &c : all_kernels(13, true)) {
    Random random(13);
    const int first = 45, n = first + 8;    // not in the first lot of packs
    Pile pile(random, c.X, n, 0.05);
    std::vector<double> before(24 * n, 0.0);
    int inverted = 99;
    const Histories histories(*c.kernel, n, c.state());
    HexKernel::Output out = histories.output();
    out.inverted = &inverted;
    c.kernel->add_forces(n, pile.nodes(), pile.x.data(), pile.X.data(), before.data(), out);
    EXPECT_EQ(inverted, -1);

    for (int a = 0; a < 8; ++a) {
      pile.x[24 * first + 3 * a + 2] *= -1.0;    // mirrored: strainless, but inside out
      pile.x[24 * (first + 4) + 3 * a] *=
          -1e-3;    // a little beyond flat (rounding may make flat ones right)
    }
    pile.x[24 * (first + 5) + 5] = std::nan("");
    std::vector<double> energy(n), bound(n), after(24 * n, 0.0);
    out.energy = energy.data();
    out.stress_bound = bound.data();
    c.kernel->add_forces(n, pile.nodes(), pile.x.data(), pile.X.data(), after.data(), out);
    EXPECT_EQ(inverted, first) << c.name;
    for (int e = 0; e < n; ++e) {
      const bool lost = e == first || e == first + 4 || e == first + 5;
      EXPECT_EQ(std::isnan(energy[e]), lost) << c.name << e;
      EXPECT_EQ(std::isnan(bound[e]), lost) << c.name << e;
      for (int i = 24 * e; i < 24 * e + 24; ++i) {
        if (lost)
          EXPECT_TRUE(std::isnan(after[i])) << c.name << e;
        else
          EXPECT_NEAR(after[i], before[i], 1e-14) << c.name << e;
      }
    }

    const int start = first + 1;
    c.kernel->add_forces(n - start, pile.nodes() + start, pile.x.data(), pile.X.data(),
                         after.data(), out);
    EXPECT_EQ(inverted, 3) << c.name;    // counted from the start of the list
    EXPECT_TRUE(std::isnan(c.kernel->energy(pile.at(first + 5), c.X, c.state())));
  }
}

// --- the kernels among each other ---------------------------------------------------------------

TEST(Kernels, CorotationalAndLagrangianDifferAtSecondOrder)
{
  Random random(15);
  const HexCoords X = random_box(random), u = random.matrix<HexCoords>(1.0);
  const BrickKernel plain(X, unit, ElementType::plain), enhanced(X, unit);
  const LagrangianKernel plain_lagrangian(unit);
  const EnhancedKernel enhanced_lagrangian(unit);
  const auto compare = [&](const HexKernel &corotational, const HexKernel &lagrangian) {
    const auto difference = [&](double strain) {
      const HexCoords x = X + strain * u;
      return (forces(corotational, x, X) - forces(lagrangian, x, X)).norm();
    };
    const double coarse = difference(1e-3), fine = difference(1e-4);
    EXPECT_NEAR(coarse / fine, 100.0, 2.0);
    EXPECT_LT(coarse, 1e-5);
  };
  compare(plain, plain_lagrangian);
  compare(enhanced, enhanced_lagrangian);
}

TEST(Kernels, WhoKeepsTheReference)
{
  const BrickKernel brick(box(1.0, 2.0, 3.0), glass);
  EXPECT_FALSE(brick.uses_reference());
  EXPECT_EQ(brick.material().E, glass.E);
  EXPECT_TRUE(LagrangianKernel(glass).uses_reference());
}

TEST(Kernels, IsBox)
{
  Random random(17);
  for (int i = 0; i < 20; ++i) {
    const HexCoords X = random_box(random);
    EXPECT_TRUE(is_box(X));
    for (int a = 0; a < 8; ++a)
      for (int k = 0; k < 3; ++k) {
        HexCoords moved = X;
        moved(k, a) += 1e-9;
        EXPECT_FALSE(is_box(moved));
        EXPECT_TRUE(is_box(moved, 1e-8));
      }
  }
  EXPECT_TRUE(is_box(box(1.0, 1e-3, 1e3)));
  Mat3 shear = Mat3::Identity();
  shear(0, 1) = 1e-9;
  EXPECT_FALSE(is_box(shear * box(1.0, 1.0, 1.0)));
  HexCoords mirrored = box(1.0, 2.0, 3.0);
  mirrored.row(0) *= -1.0;
  EXPECT_FALSE(is_box(mirrored));
  EXPECT_FALSE(is_box(HexCoords::Zero()));
  EXPECT_FALSE(is_box(HexCoords::Constant(std::nan(""))));
}

TEST(Kernels, Congruent)
{
  Random random(18);
  const HexCoords X = random_hex(random);
  HexCoords Y = X.colwise() + random.matrix<Vec3>(10.0);
  EXPECT_TRUE(congruent(X, Y));
  EXPECT_FALSE(congruent(X, random.rotation() * X));
  Y(1, 5) += 1e-9;
  EXPECT_FALSE(congruent(X, Y));
  EXPECT_TRUE(congruent(X, Y, 1e-8));
  EXPECT_FALSE(congruent(X, HexCoords::Constant(std::nan(""))));
}

TEST(Kernels, RefuseBadShapesAndMaterials)
{
  Random random(19);
  HexCoords mirrored = box(1.0, 1.0, 1.0);
  mirrored.row(2) *= -1.0;
  EXPECT_THROW(BrickKernel(random_hex(random), unit), std::invalid_argument);
  EXPECT_THROW(BrickKernel(mirrored, unit), std::invalid_argument);
  EXPECT_THROW(BrickKernel(HexCoords::Zero(), unit), std::invalid_argument);
  const IsotropicElastic bad{1.0, 0.5, 1.0};
  EXPECT_THROW(BrickKernel(box(1.0, 1.0, 1.0), bad), std::invalid_argument);
  EXPECT_THROW(LagrangianKernel{bad}, std::invalid_argument);
  EXPECT_THROW(EnhancedKernel{bad}, std::invalid_argument);
}

}    // namespace
