// Coulomb friction against closed forms: stick, slip, the energy of a spring whose stiffness changes.

#include "defe/coupling/friction.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

using defe::TangentialSpring;
using defe::Vec3;

TEST(Friction, SticksBelowTheLimitAndGivesItsEnergyBack)
{
  TangentialSpring spring{};
  const Vec3 n(0.0, 0.0, 1.0);
  const double kt = 2.0e6;
  defe::FrictionResult r{};
  for (int i = 0; i < 10; ++i) r = defe::coulomb_friction(spring, n, Vec3(1e-7, 0, 5e-6), kt, 1e9);
  EXPECT_NEAR(r.force[0], -kt * 1e-6, 1e-9);
  EXPECT_NEAR(r.stored, 0.5 * kt * 1e-12, 1e-18);
  for (int i = 0; i < 10; ++i) {
    r = defe::coulomb_friction(spring, n, Vec3(-1e-7, 0, 0), kt, 1e9);
    EXPECT_EQ(r.rubbed, 0.0);
  }
  EXPECT_NEAR(r.stored, 0.0, 1e-25);
}

TEST(Friction, SlipsAtTheLimitAndWorkIsStoredPlusRubbed)
{
  TangentialSpring spring{};
  const Vec3 n(0.0, 1.0, 0.0);
  const double kt = 1.0e6, limit = 3.0, step = 1e-9;
  double work = 0.0, rubbed = 0.0, before = 0.0;
  defe::FrictionResult r{};
  for (int i = 0; i < 20000; ++i) {
    r = defe::coulomb_friction(spring, n, Vec3(0, 0, step), kt, limit);
    work += 0.5 * (before - r.force[2]) * step;
    before = -r.force[2];
    rubbed += r.rubbed;
    if (i + 1 != 3000) { EXPECT_EQ(r.slipping, i + 1 > 3000); }    // at the limit rounding says
  }
  EXPECT_NEAR(r.force.norm(), limit, 1e-12);
  // all that goes beyond the 3 um that the spring takes is slip against 3 N
  EXPECT_NEAR(rubbed, limit * (20000 * step - limit / kt), 1e-12);
  EXPECT_NEAR(work, r.stored + rubbed, 1e-10 * work);
}

TEST(Friction, TurnsWithTheSurface)
{
  TangentialSpring spring{{1e-3, 0.0, 0.0}, 1e3};
  const double a = 0.3;
  const Vec3 n(-std::sin(a), 0.0, std::cos(a));
  const auto r = defe::coulomb_friction(spring, n, Vec3::Zero(), 1e6, 1e9);
  EXPECT_NEAR(Vec3(spring.s).norm(), 1e-3, 1e-15);
  EXPECT_NEAR(Vec3(spring.s).dot(n), 0.0, 1e-15);
  EXPECT_NEAR(r.force.norm(), 1.0, 1e-12);
}

// What the stiffness does is no work: a loaded spring keeps its energy while the contact gets stiffer and softer, and
// gives it all back if it is let go where it was loaded. (With k_t times the elongation it would have 4 times of it.)
TEST(Friction, AStiffnessThatChangesDoesNoWork)
{
  const Vec3 n(0.0, 0.0, 1.0), way(2e-6, -1e-6, 0.0), none = Vec3::Zero();
  TangentialSpring spring{};
  const double kt = 1e6, stored = 0.5 * kt * way.squaredNorm();
  EXPECT_NEAR(defe::coulomb_friction(spring, n, way, kt, 1e9).stored, stored, 1e-14 * stored);
  for (double k : {2e6, 4e6, 1e5, 0.0, 3e6, 1e6}) {
    const auto r = defe::coulomb_friction(spring, n, none, k, 1e9);
    EXPECT_NEAR(r.stored, stored, 1e-14 * stored) << k;
    EXPECT_NEAR(r.force.norm(), std::sqrt(k * kt) * way.norm(), 1e-12) << k;
  }
  EXPECT_LT(defe::coulomb_friction(spring, n, -way, kt, 1e9).stored, 1e-25 * stored);
}

namespace {

/// A way and a stiffness that go to and fro at random, both smooth.
class RandomPath {
 public:
  explicit RandomPath(int seed)
  {
    std::mt19937 random(seed);
    std::uniform_real_distribution<double> any(0.5, 1.5);
    for (double *of : {amplitude, frequency, phase})
      for (int k = 0; k < 12; ++k) of[k] = any(random);
  }
  Vec3 place(double t) const
  {
    return 1e-6 * Vec3(at(0, t) - at(0, 0.0), at(3, t) - at(3, 0.0), at(6, t) - at(6, 0.0));
  }
  double stiffness(double t) const { return 1e6 * std::exp(at(9, t)); }    // by a factor of 100

 private:
  double amplitude[12], frequency[12], phase[12];
  double at(int first, double t) const
  {
    double sum = 0.0;
    for (int k = first; k < first + 3; ++k)
      sum += amplitude[k] * std::sin(7.0 * frequency[k] * t + 5.0 * phase[k]);
    return sum;
  }
};

struct PathWork {
  double work = 0.0, stored = 0.0, rubbed = 0.0, most = 0.0;
};

/// Along the path in equal steps; work: by the mean force of each, as velocity Verlet does it.
PathWork follow(const RandomPath &path, int steps, double mu, double push_over_k)
{
  PathWork sum;
  TangentialSpring spring{};
  const Vec3 n(0.0, 0.6, 0.8);
  Vec3 last = Vec3::Zero(), at = path.place(0.0);
  for (int i = 1; i <= steps; ++i) {
    const Vec3 next = path.place(static_cast<double>(i) / steps), way = next - at;
    const double k = path.stiffness(static_cast<double>(i) / steps);
    const auto r = defe::coulomb_friction(spring, n, way, k, mu * push_over_k * k);
    sum.work -= 0.5 * (last + r.force).dot(way);
    EXPECT_GE(r.rubbed, 0.0);
    EXPECT_LE(r.force.norm(), mu * push_over_k * k * (1.0 + 1e-12));
    EXPECT_LT(std::abs(r.force.dot(n)), 1e-12 * (1.0 + r.force.norm()));
    sum.rubbed += r.rubbed;
    sum.stored = r.stored;
    sum.most = std::max(sum.most, r.stored);
    last = r.force;
    at = next;
  }
  return sum;
}

}    // namespace

// Stiffness and way change together, by a factor of a hundred: what the motion puts in is in the spring.
TEST(Friction, WorkOfARandomPathIsInTheSpring)
{
  for (int seed = 0; seed < 2; ++seed) {
    const RandomPath path(seed);
    double last = 0.0;
    for (int steps : {10000, 100000, 1000000}) {
      const PathWork sum = follow(path, steps, 1e9, 1.0);
      EXPECT_EQ(sum.rubbed, 0.0);
      const double off = std::abs(sum.work - sum.stored) / sum.most;
      if (steps > 10000 && off > 1e-11) { EXPECT_LT(off, 0.02 * last) << "not of second order"; }
      last = off;
    }
    EXPECT_LT(last, 1e-10) << seed;
  }
}

TEST(Friction, WorkOfARandomPathThatSlipsIsStoredAndRubbed)
{
  for (int seed = 0; seed < 8; ++seed) {
    const PathWork sum = follow(RandomPath(seed), 100000, 0.3, 1e-6);
    EXPECT_GT(sum.rubbed, sum.most) << "it hardly slips";
    EXPECT_NEAR((sum.work - sum.stored) / sum.rubbed, 1.0, 2e-9) << seed;
  }
}

// Slipping one way throughout while limit and stiffness change: what is lost is the limit times the way that is left
// of the motion when the spring has taken its own, ds/sqrt(k_t) with s = limit/sqrt(k_t).
TEST(Friction, DissipationIsTheLimitTimesTheSlip)
{
  const Vec3 n(0.0, 0.0, 1.0);
  const int steps = 100000;
  const double way = 400e-6 / steps;
  const auto limit = [](double t) {
    return 3.0 + 2.0 * std::sin(9.0 * t);
  };
  const auto root = [](double t) {
    return 1e3 * std::exp(std::sin(5.0 * t));
  };
  TangentialSpring spring{};
  coulomb_friction(spring, n, Vec3(1e-3, 0.0, 0.0), root(0.0) * root(0.0), limit(0.0));
  double rubbed = 0.0, expected = 0.0;
  for (int i = 0; i < steps; ++i) {
    const double a = static_cast<double>(i) / steps, b = (i + 1.0) / steps, m = 0.5 * (a + b);
    const auto r = coulomb_friction(spring, n, Vec3(way, 0.0, 0.0), root(b) * root(b), limit(b));
    EXPECT_TRUE(r.slipping) << i;
    rubbed += r.rubbed;
    expected += limit(m) * (way - (limit(b) / root(b) - limit(a) / root(a)) / root(m));
  }
  EXPECT_NEAR(rubbed / expected, 1.0, 1e-8);
}
