// Crack shielding: truth table.

#include "defe/coupling/shielding.h"

#include <gtest/gtest.h>

#include <cmath>

using namespace defe;

namespace {

constexpr double criterion = 56e6, tau = 1e-6;
const Vec3 x(1.0, 0.0, 0.0);

bool waits(const Vec3 &towards, double sigma1, double age)
{
  const Shield s{towards, 5e-6};
  return shielded(x, sigma1, criterion, 5e-6 + age, tau, &s, 1);
}

}    // namespace

TEST(Shielding, TruthTable)
{
  const Vec3 along(-2e-3, 0.0, 0.0), plane(0.0, 2e-3, 0.0), diagonal(1.0, 1.0, 0.0),
      corner(1.0, 1.0, 1.0);
  EXPECT_TRUE(waits(along, 57e6, 0.5e-6));
  EXPECT_TRUE(waits(along, 57e6, 0.0));         // in this very step
  EXPECT_FALSE(waits(along, 57e6, 1.01e-6));    // too long ago
  EXPECT_FALSE(waits(along, 57e6, 2.0e-6));
  EXPECT_FALSE(waits(along, 1.2 * criterion, 0.5e-6));    // far above the criterion
  EXPECT_TRUE(waits(along, 1.19 * criterion, 0.5e-6));
  EXPECT_FALSE(waits(plane, 57e6, 0.5e-6));      // in the plane of the crack
  EXPECT_TRUE(waits(diagonal, 57e6, 0.5e-6));    // cos 45 degrees = 0.707 > 0.7
  EXPECT_FALSE(waits(corner, 57e6, 0.5e-6));     // 0.577
}

TEST(Shielding, DirectionsNeedNoLengthAndNoSign)
{
  const Shield s{Vec3(1e-3, 0.2e-3, 0.0), 0.0};
  for (double f : {1.0, -1.0, 1e-6, -1e6})
    EXPECT_TRUE(shielded(f * x, 57e6, criterion, 0.0, tau, &s, 1));
}

TEST(Shielding, AnyOfSeveral)
{
  const Shield s[3] = {{Vec3(0, 1, 0), 0.0}, {Vec3(1, 0, 0), -5e-6}, {Vec3(1, 0, 0), 0.0}};
  EXPECT_FALSE(shielded(x, 57e6, criterion, 0.0, tau, s, 0));
  EXPECT_FALSE(shielded(x, 57e6, criterion, 0.0, tau, s, 2));
  EXPECT_TRUE(shielded(x, 57e6, criterion, 0.0, tau, s, 3));
  EXPECT_FALSE(shielded(x, 57e6, criterion, 0.0, 0.0, s, 3));         // tau = 0: off
  EXPECT_FALSE(shielded(x, 57e6, criterion, 0.0, tau, s, 3, 1.0));    // nothing is that close
  EXPECT_FALSE(shielded(x, 57e6, criterion, 0.0, tau, s, 3, 0.7, 1.01));
}

TEST(Shielding, TimeOfTheGlassBeam)
{
  const double E = 74.09e9, nu = 0.2;
  const double mu = E / (2.0 * (1.0 + nu)), lambda = E * nu / ((1.0 + nu) * (1.0 - 2.0 * nu));
  EXPECT_NEAR(shielding_time(2e-3, lambda, mu, 2500.0), 1.05e-6, 0.01e-6);
}
