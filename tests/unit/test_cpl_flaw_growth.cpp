// Flaws that grow before they break: against their depth, integrated in time, and closed forms.

#include "defe/coupling/flaw_growth.h"

#include <gmock/gmock.h>

#include <cmath>

using namespace defe;
using testing::HasSubstr;

namespace {

FlawGrowth glass()
{
  FlawGrowth g;
  g.v_0 = 6e-3;
  g.K_Ic = 0.75e6;
  return g;
}

constexpr double fresh = 50e6;

/// Tension at which a flaw breaks that is loaded with a constant rate: steps of a share 1/n of the whole.
double breaks_at(const FlawGrowth &g, double rate, double n)
{
  const double dt = fresh / rate / n;
  double S = fresh, tension = 0.0;
  for (int k = 0; tension < S; k++) {
    S = g.weakened(S, rate * (k + 0.5) * dt, dt);
    tension = rate * (k + 1) * dt;
  }
  return tension;
}

/// The same from the closed form.
double closed_form(const FlawGrowth &g, double rate)
{
  double low = 0.0, high = fresh;
  for (int k = 0; k < 100; k++) {
    const double s = 0.5 * (low + high);
    const double all =
        std::pow(s / fresh, g.n + 1.0) * std::pow(fresh, 3.0) / ((g.n + 1.0) * g.B() * rate);
    (all + std::pow(s / fresh, g.n - 2.0) < 1.0 ? low : high) = s;
  }
  return low;
}

/// The depth of the crack itself, by Runge and Kutta's method of the fourth order.
double depth_breaks_at(const FlawGrowth &g, double rate, int steps)
{
  const auto depth = [&](double S) {
    return std::pow(g.K_Ic / (g.Y * S), 2.0) / M_PI;
  };
  const auto speed = [&](double a, double tension) {
    return g.v_0 * std::pow(g.Y * tension * std::sqrt(M_PI * a) / g.K_Ic, g.n);
  };
  double a = depth(fresh), t = 0.0;
  const double dt = fresh / rate / steps;
  while (g.Y * rate * t * std::sqrt(M_PI * a) < g.K_Ic) {
    const double k1 = speed(a, rate * t), k2 = speed(a + 0.5 * dt * k1, rate * (t + 0.5 * dt)),
                 k3 = speed(a + 0.5 * dt * k2, rate * (t + 0.5 * dt)),
                 k4 = speed(a + dt * k3, rate * (t + dt));
    a += dt / 6.0 * (k1 + 2.0 * k2 + 2.0 * k3 + k4);
    t += dt;
  }
  return rate * t;
}

const double rates[] = {1e4, 1e6, 1e8, 1e12};    // Pa/s

}    // namespace

TEST(FlawGrowth, StrengthAtFourRatesIsThatOfTheClosedForm)
{
  const auto g = glass();
  for (double rate : rates) {
    SCOPED_TRACE(rate);
    EXPECT_NEAR(breaks_at(g, rate, 4000.0) / closed_form(g, rate), 1.0, 1e-3);
  }
}

TEST(FlawGrowth, StrengthAtFourRatesIsThatOfADeepeningCrack)
{
  const auto g = glass();
  for (double rate : rates) {
    SCOPED_TRACE(rate);
    EXPECT_NEAR(breaks_at(g, rate, 4000.0) / depth_breaks_at(g, rate, 100000), 1.0, 1e-3);
  }
}

TEST(FlawGrowth, SlowStrengthRisesWithTheRateAndFastStrengthIsInert)
{
  for (double n : {12.0, 16.0, 25.0}) {
    auto g = glass();
    g.n = n;
    const double slope =
        std::log(breaks_at(g, 1e6, 20000.0) / breaks_at(g, 1e4, 20000.0)) / std::log(100.0);
    EXPECT_NEAR(slope * (n + 1.0), 1.0, 0.01) << n;
    EXPECT_NEAR(breaks_at(g, 1e13, 4000.0) / fresh, 1.0, 1e-3) << n;
    EXPECT_NEAR(breaks_at(g, g.inert_rate(fresh), 20000.0) / fresh, 0.99, 1e-3) << n;
  }
}

// t = B (S_i^(n-2) - sigma^(n-2))/sigma^n, however it is divided into steps.
TEST(FlawGrowth, LifetimeUnderAConstantTension)
{
  const auto g = glass();
  for (double share : {0.3, 0.5, 0.8}) {
    const double sigma = share * fresh;
    const double life = g.B() * (std::pow(share, -14.0) - 1.0) / (sigma * sigma);
    EXPECT_NEAR(g.weakened(fresh, sigma, (1.0 - 1e-12) * life) / sigma, 1.0, 1e-5);
    double S = fresh;
    for (int k = 0; k < 1000; k++) S = g.weakened(S, sigma, 0.5e-3 * life);
    EXPECT_NEAR(S / g.weakened(fresh, sigma, 0.5 * life), 1.0, 1e-12);
  }
}

TEST(FlawGrowth, WhatIsLeftOutIsNothing)
{
  auto g = glass();
  for (double n : {8.0, 16.0, 40.0}) {
    g.n = n;
    const double share = g.least_share(), life = g.B() / (fresh * fresh);    // at its strength
    EXPECT_NEAR(g.weakened(fresh, share * fresh, 1e6 * life) / fresh, 1.0, 1e-6);
    EXPECT_LT(g.weakened(fresh, share * fresh, 1e12 * life) / fresh, 0.9);
  }
  g.n = 16.0;
  EXPECT_NEAR(g.least_share(), 0.178, 1e-3);
}

TEST(FlawGrowth, StrengthNeverRisesAndNeverVanishes)
{
  const auto g = glass();
  EXPECT_EQ(g.weakened(fresh, 0.0, 1.0), fresh);
  EXPECT_EQ(g.weakened(fresh, -1e8, 1e9), fresh);
  EXPECT_EQ(g.weakened(fresh, fresh, 1.0), fresh) << "it breaks now";
  EXPECT_EQ(g.weakened(fresh, 2.0 * fresh, 1e9), fresh);
  EXPECT_EQ(g.weakened(HUGE_VAL, 1e9, 1.0), HUGE_VAL) << "there is no flaw";
  EXPECT_EQ(g.weakened(fresh, 40e6, 1e9), 20e6) << "half of the tension";
}

TEST(FlawGrowth, AsItIsGiven)
{
  auto parsed = parse_growth({"rate", "6e-3", "0.75e6", "contact", "0.1"});
  EXPECT_EQ(parsed.complaint, "");
  EXPECT_EQ(parsed.used, 3);
  EXPECT_EQ(parsed.growth.words(), "rate 0.006 7.5e+05 exponent 16 geometry 1.12");
  EXPECT_NEAR(parsed.growth.B(), 2.0 * std::pow(0.75e6, 2.0) / (14.0 * 6e-3 * 1.2544 * M_PI), 1.0);
  parsed = parse_growth({"rate", "2.5", "0.75e6", "geometry", "0.637", "exponent", "18"});
  EXPECT_EQ(parsed.complaint, "");
  EXPECT_EQ(parsed.used, 7);
  EXPECT_EQ(parsed.growth.n, 18.0);
  EXPECT_EQ(parsed.growth.Y, 0.637);
  const auto complaint = [](const std::vector<std::string> &words) {
    return parse_growth(words).complaint;
  };
  EXPECT_THAT(complaint({"rate"}), HasSubstr("v0"));
  EXPECT_THAT(complaint({"rate", "6e-3"}), HasSubstr("KIc"));
  EXPECT_THAT(complaint({"rate", "0", "0.75e6"}), HasSubstr("v0 must be > 0, not 0"));
  EXPECT_THAT(complaint({"rate", "1", "1e6", "exponent", "2"}),
              HasSubstr("exponent must be 5 to 200, not 2"));
  EXPECT_THAT(complaint({"rate", "1", "1e6", "exponent"}),
              HasSubstr("exponent must be a number > 0, not nothing"));
  EXPECT_THAT(complaint({"rate", "1", "1e6", "geometry", "1", "geometry", "1"}),
              HasSubstr("geometry is given twice"));
}
