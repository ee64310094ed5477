// Stable step of the DE lattice: safe against the exact largest eigenfrequency, and not wasteful.

#include "de_block.h"

#include "defe/fe/stable_step.h"

#include <Eigen/Eigenvalues>
#include <gtest/gtest.h>

#include <cstdio>
#include <limits>
#include <memory>

using namespace defe;
using namespace defe::test;

namespace {

/// M^-1/2 K M^-1/2 w at the reference state, by the forces themselves (central differences: the
/// third order of the energy drops out).
Vectors apply_stiffness(const Block &block, const Vectors &w)
{
  const std::size_t n = w.size();
  Vectors u(n, Vec3::Zero()), x(n), plus, minus;
  double largest = 0.0;
  for (std::size_t i = 0; i < n; ++i) {
    if (block.mass[i] > 0.0) u[i] = w[i] / std::sqrt(block.mass[i]);
    largest = std::max(largest, u[i].norm());
  }
  const double eps = 1e-5 / largest;
  for (std::size_t i = 0; i < n; ++i) x[i] = block.X[i] + eps * u[i];
  block.forces(x, plus);
  for (std::size_t i = 0; i < n; ++i) x[i] = block.X[i] - eps * u[i];
  block.forces(x, minus);
  for (std::size_t i = 0; i < n; ++i)
    u[i] = block.mass[i] > 0.0 ? Vec3((minus[i] - plus[i]) / (2.0 * eps * std::sqrt(block.mass[i])))
                               : Vec3(Vec3::Zero());
  return u;
}

/// Critical step from the largest eigenvalue, by Lanczos' method.
double exact_step(const Block &block, int iterations = 60)
{
  const auto dot = [](const Vectors &a, const Vectors &b) {
    double sum = 0.0;
    for (std::size_t i = 0; i < a.size(); ++i) sum += a[i].dot(b[i]);
    return sum;
  };
  std::mt19937 random(1);
  Vectors v(block.X.size()), old(v.size(), Vec3::Zero());
  for (std::size_t i = 0; i < v.size(); ++i) {
    v[i] = random_vector(random, 1.0);
    if (block.mass[i] == 0.0) v[i].setZero();
  }
  double beta = std::sqrt(dot(v, v));
  for (Vec3 &c : v) c /= beta;
  std::vector<double> diagonal, off;    // the tridiagonal matrix
  beta = 0.0;
  for (int k = 0; k < iterations; ++k) {
    Vectors w = apply_stiffness(block, v);
    diagonal.push_back(dot(v, w));
    for (std::size_t i = 0; i < v.size(); ++i) w[i] -= diagonal[k] * v[i] + beta * old[i];
    beta = std::sqrt(dot(w, w));
    off.push_back(beta);
    old = v;
    for (std::size_t i = 0; i < v.size(); ++i) v[i] = w[i] / beta;
  }
  // bisection with Sturm's count: no negative pivot of (c - T) means c is above all eigenvalues
  double low = 0.0, high = 0.0;
  for (int k = 0; k < iterations; ++k)
    high = std::max(high, diagonal[k] + off[k] + (k ? off[k - 1] : 0.0));
  for (int bisection = 0; bisection < 60; ++bisection) {
    const double c = 0.5 * (low + high);
    bool above = true;
    double pivot = c - diagonal[0];
    for (int k = 1; k < iterations && above; ++k) {
      above = pivot > 0.0;
      pivot = c - diagonal[k] - off[k - 1] * off[k - 1] / pivot;
    }
    (above && pivot > 0.0 ? high : low) = c;
  }
  return 2.0 / std::sqrt(high);
}

/// What a program would take: least over all DEs, and the elements with a quarter of their mass
/// where they carry ties.
double safe_step(const Block &block)
{
  double step = std::numeric_limits<double>::infinity();
  for (const auto &p : block.de) {
    double mass[6];
    for (int s = 0; s < 6; ++s)    // of a tie: see discrete_steps()
      mass[s] = 0.5 * block.split.along() * p.birth.mass;
    for (int s = 0; s < 6; ++s)
      if (p.present >> s & 1u && p.nb[s] >= 0) mass[s] = block.de[p.nb[s]].birth.mass;
    step =
        std::min(step, lattice_critical_step(p.cell, p.present, block.moduli, p.birth.mass, mass));
  }
  for (std::size_t e = 0; e < block.mesh.hex.size(); ++e)
    if (!block.converted[e])
      step = std::min(step,
                      0.5 * fe::critical_step(block.mesh.coords(e, block.mesh.X), block.material));
  return step;
}

void compare(const char *what, const Block &block, double waste)
{
  const double exact = exact_step(block), safe = safe_step(block);
  std::printf("%-32s nu %.2f  exact %.4f  bound %.4f  (%.1f %% less)\n", what, block.material.nu,
              exact, safe, 100.0 * (1.0 - safe / exact));
  EXPECT_LE(safe, exact * (1.0 + 1e-6)) << what;
  EXPECT_GE(safe, exact * (1.0 - waste)) << what;
}

}    // namespace

// The formula for the infinite lattice against a scan of all waves.
TEST(CriticalStep, InfiniteLattice)
{
  for (double nu : {-0.2, 0.0, 0.2, 0.3, 1.0 / 3.0, 0.36, 0.4, 0.45, 0.49}) {
    const fe::IsotropicElastic m{1.0, nu, 1.0};
    const double lambda = m.lambda(), mu = m.mu(), pi = std::acos(-1.0);
    double omega2 = 0.0;
    const int n = 48;
    for (int i = 0; i <= n; ++i)
      for (int j = 0; j <= i; ++j)
        for (int k = 0; k <= j; ++k) {
          const double theta[3] = {pi * i / n, pi * j / n, pi * k / n};
          Mat3 Q;
          for (int a = 0; a < 3; ++a)
            for (int b = 0; b < 3; ++b)
              Q(a, b) = a == b ? 4.0 * std::pow(std::sin(theta[a] / 2.0), 2)
                               : std::sin(theta[a]) * std::sin(theta[b]);
          Eigen::SelfAdjointEigenSolver<Mat3> solver;
          solver.computeDirect((lambda + mu) * Q + mu * Q.trace() * Mat3::Identity());
          omega2 = std::max(omega2, solver.eigenvalues()(2));
        }
    const double step = lattice_critical_step(1.0, {lambda, mu}, 1.0);
    EXPECT_LE(step, 2.0 / std::sqrt(omega2) * (1.0 + 1e-12)) << nu;
    EXPECT_GE(step, 2.0 / std::sqrt(omega2) * (1.0 - 1e-3)) << nu;
    if (nu <= 0.3) { EXPECT_NEAR(step, 1.0 / std::sqrt(lambda + 4.0 * mu), 1e-14); }
  }
  // the glass of the beam
  const fe::IsotropicElastic glass{74.09e9, 0.2, 2500.0};
  EXPECT_NEAR(lattice_critical_step(1e-3, {glass.lambda(), glass.mu()}, glass.rho), 1.317e-7,
              1e-10);
}

// Springs of (lambda + 2 mu) area/length between all DEs, as stiff along as across: omega^2 = 4 sum over the axes.
TEST(CriticalStep, SofteningJoints)
{
  const double lambda = 0.5, mu = 0.8, a = 0.25, b = 0.5;
  const Mesh mesh = box_mesh(3, 3, 3, 1.0, [](const Vec3 &X) {
    return Vec3(0.5 * X[0], X[1], X[2]);
  });
  const fe::IsotropicElastic elastic{mu * (3.0 * lambda + 2.0 * mu) / (lambda + mu),
                                     0.5 * lambda / (lambda + mu), 2.0};
  const Block block(mesh, std::vector<char>(27, 1), elastic);
  const double omega2 = 4.0 * (lambda + 2.0 * mu) / 2.0 * (1.0 / (a * a) + 2.0 / (b * b));
  for (int i = 0; i < block.des(); ++i) {
    const auto &de = block.de[i];
    const double step = softening_critical_step(de.cell, de.present, block.moduli, de.birth.mass);
    if (de.present == 0x3f)
      EXPECT_NEAR(step, 2.0 / std::sqrt(omega2), 1e-12);
    else
      EXPECT_GT(step, 2.0 / std::sqrt(omega2));
  }
}

TEST(CriticalStep, BlockOfDEs)
{
  for (double nu : {0.0, 0.2, 0.3, 0.4}) {
    const Mesh mesh = box_mesh(4, 4, 4, 1.0);
    Block block(mesh, std::vector<char>(64, 1), {1.0, nu, 1.0});
    compare("cubes", block, nu < 0.35 ? 0.03 : 0.10);

    // the infinite lattice is never faster, whatever is missing
    const double infinite = lattice_critical_step(0.5, block.moduli, 1.0);
    EXPECT_LE(infinite, exact_step(block) * (1.0 + 1e-9));
    std::mt19937 random(2);
    for (int i = 0; i < block.des(); ++i)
      for (int s = 0; s < 6; ++s)
        if (uniform(random, 0.0, 1.0) < 0.2) block.remove(i, s);
    EXPECT_LE(infinite, exact_step(block) * (1.0 + 1e-9));
    EXPECT_LE(safe_step(block), exact_step(block) * (1.0 + 1e-6));
  }
}

TEST(CriticalStep, BlockWithTies)
{
  std::mt19937 random(3);
  for (double nu : {0.0, 0.2, 0.4})
    for (double fraction : {0.0, 0.5, 0.9}) {
      const Mesh mesh = box_mesh(4, 4, 4, 1.0);
      std::vector<char> converted(64, 0);
      for (char &c : converted) c = uniform(random, 0.0, 1.0) < fraction;
      if (fraction == 0.0) converted[21] = 1;
      const Block block(mesh, converted, {1.0, nu, 1.0});
      compare(("cubes, converted " + std::to_string(fraction)).c_str(), block, 0.3);
    }
}

TEST(CriticalStep, OtherSplits)
{
  std::mt19937 random(5);
  const Mesh mesh = box_mesh(4, 4, 4, 1.0);
  for (int along : {1, 3})
    for (double fraction : {0.5, 1.0}) {
      std::vector<char> converted(64, 0);
      for (char &c : converted) c = uniform(random, 0.0, 1.0) <= fraction;
      const Block block(mesh, converted, {1.0, 0.2, 1.0}, ElementSplit(along));
      // few DEs: the lattice is far from an infinite one
      compare(("split " + std::to_string(along)).c_str(), block, along == 1 ? 0.45 : 0.3);
    }
}

TEST(CriticalStep, OtherShapes)
{
  std::mt19937 random(4);
  const auto graded = [](const Vec3 &X) {
    return Vec3(X[0] < 0.0 ? 0.5 * X[0] : X[0], X[1], X[2]);
  };
  const auto shaken = [&](const Vec3 &X) {
    return Vec3(X + random_vector(random, 0.15));
  };
  for (double fraction : {0.5, 1.0})
    for (int shape = 0; shape < 2; ++shape) {
      const Mesh mesh = shape ? box_mesh(4, 4, 4, 1.0, shaken) : box_mesh(4, 4, 4, 1.0, graded);
      std::vector<char> converted(64, 0);
      for (char &c : converted) c = uniform(random, 0.0, 1.0) <= fraction;
      const Block block(mesh, converted, {1.0, 0.2, 1.0});
      compare(shape ? "distorted" : "graded", block, 0.3);
    }
}

TEST(CriticalStep, NoJointsNoLimit)
{
  const Mesh mesh = box_mesh(1, 1, 1, 1.0);
  const Block block(mesh, {1}, {1.0, 0.2, 1.0});
  EXPECT_TRUE(std::isinf(lattice_critical_step(block.de[0].cell, 0, block.moduli, 1.0)));
}
