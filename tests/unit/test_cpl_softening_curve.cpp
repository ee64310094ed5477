// All registered softening curves alike: their ends, G_f as the area below, and that what is dissipated is the work; and
// the closed form of each.

#include "defe/coupling/cohesive.h"

#include <gtest/gtest.h>

#include <cmath>

namespace defe {
namespace {

  constexpr double sigma = 60e6, G_f = 10.0;
  const JointStiffness stiff = joint_stiffness(20e9, 30e9, 1e-3);
  const double kappa0 = sigma / stiff.k_n;

  class Curve : public ::testing::TestWithParam<int> {
   protected:
    const SofteningCurve &curve = softening_curve(GetParam());
    const double length = curve.length(sigma, G_f);
    const CohesiveParameters law{sigma, G_f, 0.5, false, static_cast<unsigned char>(GetParam())};
    /// Traction at a share of the way to the end.
    double traction(double share) const
    {
      return sigma * (1.0 - curve.damage(kappa0, kappa0 + share * length, kappa0, length));
    }
  };
  INSTANTIATE_TEST_SUITE_P(All, Curve,
                           ::testing::Range(0, static_cast<int>(softening_curves().size())),
                           [](const auto &info) {
                             return std::string(softening_curve(info.param).name());
                           });

  TEST_P(Curve, IsFoundByItsName)
  {
    EXPECT_EQ(find_softening_curve(curve.name()), GetParam());
    EXPECT_EQ(find_softening_curve("sudden"), -1);
  }

  TEST_P(Curve, FallsFromStrengthToNothing)
  {
    EXPECT_DOUBLE_EQ(traction(0.0), sigma);
    EXPECT_NEAR(traction(1.0), 0.0, 1e-12 * sigma);
    for (int k = 0; k < 100; ++k) EXPECT_GT(traction(0.01 * k), traction(0.01 * (k + 1)));
  }

  TEST_P(Curve, ItsAreaIsTheFractureEnergy)
  {
    constexpr int n = 2000;    // Simpson
    double sum = 0.0;
    for (int k = 0; k <= n; ++k)
      sum += (k == 0 || k == n ? 1.0 : k % 2 ? 4.0 : 2.0) * traction(1.0 * k / n);
    EXPECT_NEAR(sum / (3.0 * n) * length, G_f, 1e-10 * G_f);
  }

  // Pulled apart in many small steps or in a few: the work after the switch is G_f, and what is dissipated is that and
  // what was stored at the switch.
  TEST_P(Curve, PulledApartAJointDissipatesTheFractureEnergyAndWhatItHeld)
  {
    for (int n : {7, 1000}) {
      CohesiveState s = cohesive_start(sigma, Vec3::Zero(), stiff, law);
      double dissipated = 0.0;
      CohesiveResult r{};
      for (int k = 0; k <= n && !r.broken; ++k) {
        r = cohesive_update(s, length / n, Vec3::Zero(), stiff, law);
        dissipated += r.dissipated;
      }
      ASSERT_TRUE(r.broken);
      EXPECT_NEAR(dissipated, G_f + 0.5 * sigma * kappa0, 1e-10 * G_f);
    }
  }

  // Unloaded and loaded again along another direction nothing is lost until the stretch is larger than ever.
  TEST_P(Curve, EnergyIsKeptInMixedMode)
  {
    CohesiveState s = cohesive_start(0.8 * sigma, Vec3(0.0, 0.5 * sigma, 0.0), stiff, law);
    double before = cohesive_update(s, 0.0, Vec3::Zero(), stiff, law).stored, lost = 0.0,
           work = 0.0;
    const double start = before;
    for (int k = 0; k < 20000; ++k) {
      const double way = 0.6 * length / 20000 * std::cos(4e-4 * k);
      const auto r = cohesive_update(s, way, Vec3(0.0, 0.3 * way, 0.1 * way), stiff, law);
      work += r.work;
      lost += r.dissipated;
      EXPECT_GE(r.dissipated, 0.0);
      before = r.stored;
    }
    EXPECT_GT(lost, 0.1 * G_f);
    EXPECT_NEAR(work, before - start + lost, 1e-5 * work);
  }

  TEST(SofteningCurve, Linear)
  {
    const auto &c = softening_curve(find_softening_curve("linear"));
    EXPECT_DOUBLE_EQ(c.length(sigma, G_f), 2.0 * G_f / sigma);
    EXPECT_DOUBLE_EQ(
        c.damage(kappa0, kappa0 + 0.25 * c.length(sigma, G_f), kappa0, c.length(sigma, G_f)), 0.25);
    const CohesiveParameters unless_another_is_given{sigma, G_f, 0.5, false};
    EXPECT_EQ(&softening_curve(unless_another_is_given.softening), &c);
  }

  TEST(SofteningCurve, Exponential)
  {
    const auto &c = softening_curve(find_softening_curve("exponential"));
    const double length = c.length(sigma, G_f), L = length / 6.0;
    EXPECT_NEAR(L, G_f / sigma, 0.02 * G_f / sigma) << "but for the end that of exp(-x sigma/G_f)";
    const double left = 1.0 - c.damage(kappa0, kappa0 + L, kappa0, length);
    EXPECT_NEAR(left, (std::exp(-1.0) - std::exp(-6.0)) / (1.0 - std::exp(-6.0)), 1e-14);
  }

}    // namespace
}    // namespace defe
