// The cohesive joint against its closed form.

#include "defe/coupling/cohesive.h"

#include "defe/coupling/corner_strain.h"
#include "defe/fe/elastic.h"

#include <Eigen/Geometry>
#include <gtest/gtest.h>

#include <cmath>
#include <cstring>
#include <random>

using namespace defe;

namespace {

// the glass of the beam, joints of 1 mm
const fe::IsotropicElastic glass{74.09e9, 0.2, 2500.0};
const JointStiffness stiff = joint_stiffness(glass.lambda(), glass.mu(), 1e-3);
const CohesiveParameters strength{60e6, 10.0, 0.1, false};
const Vec3 zero = Vec3::Zero();

double delta_c(const CohesiveState &s, const CohesiveParameters &p)
{
  return 2.0 * p.G_f / s.s0;
}

double uniform(std::mt19937 &random, double low, double high)
{
  return std::uniform_real_distribution<double>(low, high)(random);
}

}    // namespace

TEST(Cohesive, Stiffness)
{
  EXPECT_NEAR(stiff.k_c, glass.E / 1e-3, 1e-3 * 1e3);
  EXPECT_DOUBLE_EQ(stiff.k_s, glass.mu() / 1e-3);
  EXPECT_DOUBLE_EQ(stiff.k_n, (glass.lambda() + 2.0 * glass.mu()) / 1e-3);
}

// Why these stiffnesses: minimising the corner energy over the joint that leaves takes exactly
// t_n^2/(2 (lambda + 2 mu)) + t_s^2/(2 mu) per volume out of it, whatever the strain, and that is
// what the cohesive joint starts with. Energy does not jump at the switch.
TEST(Cohesive, EnergyIsContinuousAtTheSwitch)
{
  std::mt19937 random(3);
  const double d = 1e-3;
  for (bool tie : {false, true}) {
    GeneralCell cell;
    cell.tie = tie ? 2 : 0;
    for (int s = 0; s < 6; ++s) {
      cell.face[s].setZero();
      cell.face[s][s / 2] = s % 2 ? 0.5 * d : -0.5 * d;
      cell.dX[s] = (tie && s == 1 ? 1.0 : 2.0) * cell.face[s];
    }
    const CornerModuli moduli{glass.lambda(), glass.mu()};
    Mat3 H;
    for (int k = 0; k < 9; ++k) H(k / 3, k % 3) = uniform(random, -1e-9, 1e-9);
    Vec3 y[6], half[6];
    for (int s = 0; s < 6; ++s) y[s] = cell.dX[s] + H * cell.dX[s];
    const double ends = tie ? 1.0 : 2.0;    // the DE at the other end has the same again
    const double with = ends * corner_strain_general(cell, y, 0x3f, moduli, half);
    const Vec3 traction = ends * half[1] / (d * d);
    const double without = ends * corner_strain_general(cell, y, 0x3f & ~2u, moduli, half);
    const JointStiffness k = joint_stiffness(moduli.lambda, moduli.mu, cell.dX[1].norm());
    const double t_n = std::abs(traction[0]);    // the state only needs a positive one
    CohesiveState s = cohesive_start(t_n, Vec3(0.0, traction[1], traction[2]), k, strength);
    const CohesiveResult r = cohesive_update(s, 0.0, zero, k, strength);
    EXPECT_NEAR(without + r.stored * d * d, with, 1e-6 * with);
  }
}

TEST(Cohesive, EquivalentTraction)
{
  EXPECT_DOUBLE_EQ(equivalent_traction(3.0, 40.0, strength), 5.0);
  EXPECT_DOUBLE_EQ(equivalent_traction(-3.0, 40.0, strength), 4.0);
  const CohesiveParameters reciprocal{60e6, 10.0, 0.1, true};
  EXPECT_DOUBLE_EQ(equivalent_traction(30.0, 4.0, reciprocal), 50.0);
  // with beta = 0.1 the reciprocal reading means 6 MPa in shear
  EXPECT_DOUBLE_EQ(equivalent_traction(0.0, 6e6, reciprocal), 60e6);
}

TEST(Cohesive, ContinuesWithTheTractionOfTheSwitch)
{
  const Vec3 t_s(0.0, 3e6, -4e6);
  CohesiveState s = cohesive_start(60e6, t_s, stiff, strength);
  const CohesiveResult r = cohesive_update(s, 0.0, zero, stiff, strength);
  EXPECT_NEAR(r.t_n, 60e6, 1e-6);
  EXPECT_LT((r.t_s - t_s).norm(), 1e-6);
  EXPECT_EQ(r.dissipated, 0.0);
  EXPECT_EQ(r.damage, 0.0);
  EXPECT_FALSE(r.broken);
  EXPECT_NEAR(r.stored, 0.5 * (60e6 * 60e6 / stiff.k_n + 25e12 / stiff.k_s), 1e-9);
}

// Pulled apart in tension: work G_f, released in all s0 (kappa0 + delta_c)/2, in one increment or
// in many, also if the last one goes far beyond the end.
TEST(Cohesive, TensionTakesExactlyTheFractureEnergy)
{
  for (double t0 : {60e6, 63.7e6})    // a step may carry the traction above the strength
    for (int increments : {1, 2, 3, 10, 1000})
      for (double beyond : {1.0, 1.3, 50.0}) {
        CohesiveState s = cohesive_start(t0, zero, stiff, strength);
        const double step = beyond * delta_c(s, strength) / increments;
        CohesiveResult r = cohesive_update(s, 0.0, zero, stiff, strength);
        const double stored = r.stored;
        double work = 0.0, dissipated = 0.0;
        int breaks = 0;
        for (int k = 0; k < increments; ++k) {
          const double before = r.t_n;
          r = cohesive_update(s, step, zero, stiff, strength);
          work += 0.5 * (before + r.t_n) * step;    // exact as long as the law is linear
          dissipated += r.dissipated;
          breaks += r.broken && breaks == 0;
        }
        if (beyond == 1.0) {    // D = 1 up to the rounding of the sum of increments
          EXPECT_NEAR(work, strength.G_f, 1e-11 * strength.G_f);
          EXPECT_NEAR(r.damage, 1.0, 1e-11);
        } else {
          EXPECT_TRUE(r.broken);
          EXPECT_EQ(r.damage, 1.0);
          EXPECT_EQ(r.stored, 0.0);
          EXPECT_EQ(r.t_n, 0.0);
        }
        EXPECT_NEAR(dissipated - stored, strength.G_f, 1e-10 * strength.G_f);
        EXPECT_NEAR(dissipated, cohesive_total_release(t0, stiff, strength), 1e-10 * dissipated);
      }
}

// 34 J/m2 in all for this glass with joints of 1 mm; delta_c 0.333 um; 0.41 mm.
TEST(Cohesive, FiguresOfTheGlassBeam)
{
  const CohesiveState s = cohesive_start(60e6, zero, stiff, strength);
  EXPECT_NEAR(delta_c(s, strength), 0.333e-6, 0.001e-6);
  EXPECT_NEAR(toughness_limit(glass.E, strength.G_f, strength.sigma_t), 0.41e-3, 0.005e-3);
  // Uniaxial stress stretches the joint by sigma l/E = 0.810 um, 34.3 J/m2; the joint's own spring
  // is stiffer (lambda + 2 mu), the rest stays with the other joints of the corners.
  const double kappa0 = 60e6 / stiff.k_n;
  EXPECT_NEAR(cohesive_total_release(60e6, stiff, strength), 0.5 * 60e6 * (kappa0 + 0.33333e-6),
              1e-3);
  EXPECT_NEAR(0.5 * 60e6 * (60e6 / stiff.k_c + 0.33333e-6), 34.3, 0.1);
}

TEST(Cohesive, UnloadingGoesToTheOriginAndBack)
{
  CohesiveState s = cohesive_start(60e6, zero, stiff, strength);
  const double e0 = s.e_n;
  CohesiveResult r = cohesive_update(s, 0.4 * delta_c(s, strength), zero, stiff, strength);
  EXPECT_NEAR(r.damage, 0.4, 1e-12);
  EXPECT_NEAR(r.t_n, 0.6 * 60e6, 1e-3);
  const double e_max = s.e_n, t_max = r.t_n;
  EXPECT_NEAR(e_max, e0 + 0.4 * delta_c(s, strength), 1e-20);
  for (double f : {0.9, 0.5, 0.1, 0.0, 0.3, 1.0}) {
    r = cohesive_update(s, f * e_max - s.e_n, zero, stiff, strength);
    EXPECT_NEAR(r.t_n, f * t_max, 1e-6);
    EXPECT_NEAR(r.stored, 0.5 * f * f * t_max * e_max, 1e-9);
    EXPECT_EQ(r.dissipated, 0.0);
    EXPECT_NEAR(r.damage, 0.4, 1e-12);
  }
  r = cohesive_update(s, 0.1 * delta_c(s, strength), zero, stiff,
                      strength);    // on along the branch
  EXPECT_NEAR(r.t_n, 0.5 * 60e6, 1e-3);
}

TEST(Cohesive, ClosingIsNotDamaged)
{
  CohesiveState s = cohesive_start(60e6, zero, stiff, strength);
  CohesiveResult r = cohesive_update(s, 0.99 * delta_c(s, strength), zero, stiff, strength);
  EXPECT_FALSE(r.broken);
  r = cohesive_update(s, -s.e_n - 1e-6, zero, stiff, strength);
  EXPECT_NEAR(r.t_n, -stiff.k_c * 1e-6, 1e-3);
  EXPECT_NEAR(r.stored, 0.5 * stiff.k_c * 1e-12, 1e-9);
  EXPECT_EQ(r.dissipated, 0.0);
}

// Shear alone: traction s0/beta that fades linearly, work G_f k_n/(beta^2 k_s).
// From closed to farther open than ever before in one increment: what it dissipates is that of small ones, not that of a
// shear which is not there.
TEST(Cohesive, OpensFromClosedInOneIncrement)
{
  for (double shear : {0.0, 1e-12}) {
    CohesiveState once = cohesive_start(strength.sigma_t, zero, stiff, strength);
    const double kappa0 = once.s0 / stiff.k_n;
    cohesive_update(once, -3.0 * kappa0, Vec3(shear, 0.0, 0.0), stiff, strength);
    CohesiveState slowly = once;
    const double way = 3.2 * kappa0;
    const CohesiveResult r = cohesive_update(once, way, zero, stiff, strength);
    double dissipated = 0.0;
    for (int k = 0; k < 1000; ++k)
      dissipated += cohesive_update(slowly, way / 1000.0, zero, stiff, strength).dissipated;
    EXPECT_GT(dissipated, 0.0);
    EXPECT_NEAR(r.dissipated, dissipated, 1e-6 * dissipated) << shear;
    EXPECT_NEAR(once.kappa, slowly.kappa, 1e-12 * slowly.kappa);
  }
}

TEST(Cohesive, PureShear)
{
  for (const CohesiveParameters &p :
       {CohesiveParameters{60e6, 10.0, 0.5, false}, CohesiveParameters{60e6, 10.0, 2.0, true}}) {
    const double beta = 0.5;
    const Vec3 direction = Vec3(0.0, 1.0, 2.0).normalized();
    CohesiveState s = cohesive_start(0.0, 60e6 / beta * direction, stiff, p);
    EXPECT_NEAR(s.s0, 60e6, 1e-6);
    const double width = delta_c(s, p) * stiff.k_n / (beta * stiff.k_s);
    CohesiveResult r = cohesive_update(s, 0.0, zero, stiff, p);
    double work = 0.0;
    for (int k = 1; k <= 7; ++k) {
      const Vec3 before = r.t_s;
      r = cohesive_update(s, 0.0, width / 7.0 * direction, stiff, p);
      work += 0.5 * (before + r.t_s).dot(direction) * width / 7.0;
      EXPECT_NEAR(r.t_s.dot(direction), 60e6 / beta * (1.0 - k / 7.0), 1e-2);
      EXPECT_EQ(r.t_n, 0.0);
    }
    EXPECT_NEAR(work, p.G_f * stiff.k_n / (beta * beta * stiff.k_s), 1e-9 * work);
  }
}

// The tensile and the shear traction fade together.
TEST(Cohesive, ShearFadesWithDamage)
{
  CohesiveState s = cohesive_start(50e6, Vec3(0.0, 100e6, 0.0), stiff, strength);
  const Vec3 e_s = s.e_s;
  double last = 100e6;
  for (int k = 0; k < 20; ++k) {
    const CohesiveResult r = cohesive_update(s, 0.05 * delta_c(s, strength), zero, stiff, strength);
    EXPECT_LT(r.t_s.norm(), last);
    last = r.t_s.norm();
    EXPECT_NEAR(r.t_s.norm() * e_s.norm(), r.t_s.dot(e_s), 1e-9);
    EXPECT_NEAR(r.t_n / (stiff.k_n * s.e_n), r.t_s.norm() / (stiff.k_s * e_s.norm()), 1e-12);
  }
  EXPECT_GT(last, 0.0);
}

// Any path: the dissipation is never negative, damage never heals, and stored and dissipated energy
// add up to the work, with an error that falls with the square of the increments.
TEST(Cohesive, RandomPathsBalanceEnergy)
{
  std::mt19937 random(1);
  int broken = 0;
  for (bool reciprocal : {false, true})
    for (int path = 0; path < 40; ++path) {
      const CohesiveParameters p{60e6, 10.0, reciprocal ? 1.5 : 0.7, reciprocal};
      const Vec3 t0(uniform(random, 1e6, 60e6), uniform(random, -60e6, 60e6),
                    uniform(random, -60e6, 60e6));
      const CohesiveState start = cohesive_start(t0[0], Vec3(0.0, t0[1], t0[2]), stiff, p);
      Vec3 corner[6];    // of a polygon of separations (normal, two tangential)
      corner[0].setZero();
      for (int k = 1; k < 6; ++k)
        for (int c = 0; c < 3; ++c) corner[k][c] = uniform(random, -0.7e-6, 0.7e-6);

      double error[2];
      for (int fine = 0; fine < 2; ++fine) {
        const int n = fine ? 400 : 100;
        CohesiveState s = start;
        CohesiveResult r = cohesive_update(s, 0.0, zero, stiff, p);
        const double first = r.stored;
        double work = 0.0, dissipated = 0.0, damage = 0.0;
        for (int k = 0; k < 5; ++k)
          for (int i = 0; i < n; ++i) {
            const Vec3 de = (corner[k + 1] - corner[k]) / n, e_s(0.0, de[1], de[2]);
            const CohesiveResult before = r;
            r = cohesive_update(s, de[0], e_s, stiff, p);
            work += 0.5 * (before.t_n + r.t_n) * de[0] + 0.5 * (before.t_s + r.t_s).dot(e_s);
            EXPECT_GE(r.dissipated, 0.0);
            EXPECT_GE(r.damage, damage);
            EXPECT_LE(r.damage, 1.0);
            EXPECT_EQ(r.broken, r.damage == 1.0);
            damage = r.damage;
            dissipated += r.dissipated;
          }
        broken += fine && r.broken;
        error[fine] = std::abs(first + work - r.stored - dissipated) / (first + dissipated);
      }
      EXPECT_LT(error[0], 1e-3);
      EXPECT_LT(error[1], 1e-4);
      EXPECT_LT(error[1], 0.5 * error[0] + 1e-6);
    }
  EXPECT_GT(broken, 5);
  EXPECT_LT(broken, 75);
}

TEST(Cohesive, BrokenStaysBroken)
{
  CohesiveState s = cohesive_start(60e6, zero, stiff, strength);
  CohesiveResult r = cohesive_update(s, 10.0 * delta_c(s, strength), zero, stiff, strength);
  EXPECT_TRUE(r.broken);
  r = cohesive_update(s, -0.99 * s.e_n, Vec3(0.0, 1e-7, 0.0), stiff, strength);
  EXPECT_TRUE(r.broken);
  EXPECT_EQ(r.t_n, 0.0);
  EXPECT_EQ(r.t_s.norm(), 0.0);
  EXPECT_EQ(r.dissipated, 0.0);
}

TEST(Cohesive, RotationKeepsTheShearPerpendicularAndItsLength)
{
  std::mt19937 random(2);
  CohesiveState s = cohesive_start(50e6, Vec3(0.0, 1e6, 2e6), stiff, strength);
  const double length = s.e_s.norm();
  // a quarter turn about the direction across e_s in 100 steps takes e_s along
  const Vec3 e0 = s.e_s, axis = Vec3::UnitX().cross(e0).normalized();
  Vec3 n = Vec3::UnitX();
  for (int k = 1; k <= 100; ++k) {
    const Mat3 R = Eigen::AngleAxisd(0.5 * std::acos(-1.0) * k / 100.0, axis).toRotationMatrix();
    n = R * Vec3::UnitX();
    cohesive_rotate(s, n);
    EXPECT_NEAR(s.e_s.norm(), length, 1e-14 * length);
    EXPECT_LT(std::abs(s.e_s.dot(n)), 1e-14 * length);
    EXPECT_LT((s.e_s - R * e0).norm(), 1e-12 * length);
  }
  CohesiveState none = cohesive_start(60e6, zero, stiff, strength);
  cohesive_rotate(none, Vec3::UnitY());
  EXPECT_EQ(none.e_s, zero);
}

TEST(Cohesive, StatePacks)
{
  const CohesiveState s{1.0, Vec3(2.0, 3.0, 4.0), 5.0, 6.0};
  double buffer[CohesiveState::size];
  s.pack(buffer);
  const CohesiveState t = CohesiveState::unpack(buffer);
  EXPECT_EQ(t.e_n, s.e_n);
  EXPECT_EQ(t.e_s, s.e_s);
  EXPECT_EQ(t.s0, s.s0);
  EXPECT_EQ(t.kappa, s.kappa);
}

// What a coarse increment takes from the ends of a joint is the trapezium of the tractions. Along the
// softening line that is what is stored and dissipated; in a joint that breaks within one increment it is
// what the traction of before has done in half of it, and the excess is the difference.
TEST(Cohesive, ExcessOfCoarseIncrements)
{
  const auto pull_apart = [](int increments, double end, double &work) {
    CohesiveState s = cohesive_start(60e6, zero, stiff, strength);
    const double start = s.e_n, first = cohesive_update(s, 0.0, zero, stiff, strength).stored;
    double excess = 0.0, dissipated = 0.0;
    CohesiveResult r{};
    work = 0.0;
    for (int i = 0; i < increments; ++i) {
      r = cohesive_update(s, (end - start) / increments, zero, stiff, strength);
      work += r.work;
      excess += r.excess;
      dissipated += r.dissipated;
    }
    EXPECT_NEAR(work, (r.broken ? 0.0 : r.stored) - first + dissipated + excess, 1e-12 * work);
    return excess;
  };
  double work;
  const double elastic = 60e6 / stiff.k_n;
  const double half_way = elastic + 0.5 * 2.0 * strength.G_f / 60e6;
  // linear softening: the trapezium is exact
  const double excess_of_four = pull_apart(4, half_way, work);
  EXPECT_LT(std::abs(excess_of_four), 1e-9 * work);

  // at once: t_old/2 times the way, against the energy at the switch and G_f
  const double way = 1e-6;
  const double excess = pull_apart(1, elastic + way, work);
  EXPECT_NEAR(work, 0.5 * 60e6 * way, 1e-9 * work);
  EXPECT_NEAR(excess, 0.5 * 60e6 * way + 0.5 * 60e6 * elastic - strength.G_f - 0.5 * 60e6 * elastic,
              1.0);
}
