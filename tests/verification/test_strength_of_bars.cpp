// 200 small bars of glass with flaws on their surface, on two meshes, pulled and bent until they break: the distribution of their
// strength is that of the flaws on what is under tension, whatever the mesh. Two minutes. 100 bars on one mesh are
// lammps/test_strength_field.cpp.
//
// ranks: 1
// timeout: 1800

#include "glass_bars.h"

#include <gtest/gtest.h>

#include <cstdio>

using namespace defe::test;

namespace {

constexpr double shape = 7.0, scale = 50e6, area = 4e-5;

Bars bars_of(int along, int across, bool bend, int seed)
{
  Bars bars;
  bars.rows = 20;
  bars.along = along;
  bars.across = across;
  bars.bend = bend;
  bars.most = 90e6;
  bars.strength = "strength glass weibull 7 50e6 area 4e-5 seed " + std::to_string(seed) +
      " surface all strength glass constant 300e6";
  return bars;
}

/// Of maximum likelihood, in 99 of 100 samples of n (Thoman, Bain, Antle, Technometrics 11 (1969) 445, for large n).
double band_of_shape(double n)
{
  return 2.58 * 0.78 / std::sqrt(n);
}

double band_of_scale(double n)
{
  return 2.58 * 1.053 / (shape * std::sqrt(n));
}

/// Fit of the scale that belongs to the reference area.
Fit broken(const Bars &bars)
{
  const auto result = break_all(bars, "bars.txt");
  const double share = bars.effective_surface(shape) / area;
  const auto below = [&](double s) {
    return 1.0 - std::exp(-share * std::pow(s / scale, shape));
  };
  const double distance = kolmogorov(result.tension, below);
  EXPECT_LT(distance, kolmogorov_1_percent);
  Fit fit = fit_weibull(result.tension);
  fit.scale *= std::pow(share, 1.0 / shape);
  std::printf("%d x %d x %d, %s: shape %.2f, scale %.1f MPa, Kolmogorov-Smirnov %.2f\n", bars.along,
              bars.across, bars.across, bars.bend ? "bent" : "pulled", fit.shape, fit.scale / 1e6,
              distance);
  EXPECT_NEAR(fit.shape / shape, 1.0, band_of_shape(bars.count()));
  EXPECT_NEAR(fit.scale / scale, 1.0, band_of_scale(bars.count()));
  return fit;
}

void expect_alike(const Bars &coarse_bars, const Bars &fine_bars)
{
  const Fit coarse = broken(coarse_bars), fine = broken(fine_bars);
  const double both = std::sqrt(2.0), n = coarse_bars.count();
  EXPECT_NEAR(fine.shape / coarse.shape, 1.0, both * band_of_shape(n));
  EXPECT_NEAR(fine.scale / coarse.scale, 1.0, both * band_of_scale(n));
}

}    // namespace

TEST(StrengthOfBars, PulledOnTwoMeshes)
{
  expect_alike(bars_of(4, 2, false, 31), bars_of(8, 4, false, 32));
}

// Strength is the tension in the middle of the outermost DEs. With two elements through the thickness, which are too
// stiff in bending, bars break 7 % early.
TEST(StrengthOfBars, BentOnTwoMeshes)
{
  expect_alike(bars_of(8, 4, true, 31), bars_of(12, 6, true, 32));
}
