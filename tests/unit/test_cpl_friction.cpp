// Coulomb friction of surface contact against closed forms.

#include "defe/coupling/friction.h"

#include <gtest/gtest.h>

#include <cmath>

using defe::Vec3;

TEST(Friction, SticksBelowTheLimitAndGivesItsEnergyBack)
{
  Vec3 shear = Vec3::Zero();
  const Vec3 n(0.0, 0.0, 1.0);
  const double kt = 2.0e6;
  defe::FrictionResult r{};
  for (int i = 0; i < 10; ++i) r = defe::coulomb_friction(shear, n, Vec3(1e-7, 0, 5e-6), kt, 1e9);
  EXPECT_NEAR(r.force[0], -kt * 1e-6, 1e-9);
  EXPECT_NEAR(r.stored, 0.5 * kt * 1e-12, 1e-18);
  for (int i = 0; i < 10; ++i) {
    r = defe::coulomb_friction(shear, n, Vec3(-1e-7, 0, 0), kt, 1e9);
    EXPECT_EQ(r.rubbed, 0.0);
  }
  EXPECT_NEAR(r.stored, 0.0, 1e-25);
}

TEST(Friction, SlipsAtTheLimitAndWorkIsStoredPlusRubbed)
{
  Vec3 shear = Vec3::Zero();
  const Vec3 n(0.0, 1.0, 0.0);
  const double kt = 1.0e6, limit = 3.0, step = 1e-9;
  double work = 0.0, rubbed = 0.0, before = 0.0;
  defe::FrictionResult r{};
  for (int i = 0; i < 20000; ++i) {
    r = defe::coulomb_friction(shear, n, Vec3(0, 0, step), kt, limit);
    work += 0.5 * (before - r.force[2]) * step;
    before = -r.force[2];
    rubbed += r.rubbed;
  }
  EXPECT_NEAR(r.force.norm(), limit, 1e-12);
  // all that goes beyond the 3 um that the spring takes is slip against 3 N
  EXPECT_NEAR(rubbed, limit * (20000 * step - limit / kt), 1e-12);
  EXPECT_NEAR(work, r.stored + rubbed, 1e-6 * work);
}

TEST(Friction, TurnsWithTheSurface)
{
  Vec3 shear(1e-6, 0.0, 0.0);
  const double a = 0.3;
  const Vec3 n(-std::sin(a), 0.0, std::cos(a));
  const auto r = defe::coulomb_friction(shear, n, Vec3::Zero(), 1e6, 1e9);
  EXPECT_NEAR(shear.norm(), 1e-6, 1e-18);
  EXPECT_NEAR(shear.dot(n), 0.0, 1e-18);
  EXPECT_NEAR(r.force.norm(), 1.0, 1e-12);
}
