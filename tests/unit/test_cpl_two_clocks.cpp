// Impulses of slow forces on a fast oscillation: where they can make energy.

#include "defe/coupling/two_clocks.h"

#include <gtest/gtest.h>

#include <cmath>

using namespace defe;

namespace {

/// One mass on a fast spring, taken by velocity Verlet with step dt, and a slow spring that acts m-fold at
/// every m-th step: largest distance from the origin in 40 000 impulses, of the first one.
double growth(int m, double dt, double fast, double slow)
{
  double x = 1.0, v = 0.0, largest = 0.0;
  const auto force = [&](int step) {
    return -(fast * fast + (step % m == 0 ? m * slow * slow : 0.0)) * x;
  };
  double f = force(0);
  for (int step = 1; step <= 40000 * m && largest < 1e6; ++step) {
    v += 0.5 * dt * f;
    x += dt * v;
    f = force(step);
    v += 0.5 * dt * f;
    if (step % m == 0) largest = std::max(largest, std::abs(x));
  }
  return largest;
}

}    // namespace

TEST(TwoClocks, ImpulsesInStepWithAnOscillation)
{
  constexpr double pi = 3.14159265358979323846;
  const double omega = 2.0, slow = 0.05 * omega;    // stable step 1
  for (int m : {2, 3, 5}) {
    // phase pi from impulse to impulse
    const double at = std::sin(0.5 * pi / m);
    EXPECT_TRUE(clocks_resonate(m, at * (1.0 + 1e-9), 1.0)) << m;
    EXPECT_FALSE(clocks_resonate(m, at * (1.0 - 1e-9), 1.0)) << m;
    // the band of growth lies against pi from below: 2 atan(slow^2 m dt/(2 omega)) of phase wide, so that
    // its edge comes to pi as the slow spring gets weak
    EXPECT_GT(growth(m, at * (1.0 - 1e-3), omega, slow), 1e6) << m;
    EXPECT_LT(growth(m, 0.97 * at, omega, slow), 10.0) << m;
    EXPECT_LT(growth(m, 0.5 * at, omega, slow), 1.5) << m;
  }
}

TEST(TwoClocks, OneClockDoesNotResonate)
{
  EXPECT_FALSE(clocks_resonate(1, 2.0, 1.0));
  EXPECT_TRUE(clocks_resonate(2, 1.0, 1.0));    // the fast step itself is not stable
}
