// All registered laws of the normal force of spheres alike: a potential, restitution, energy of oblique collisions,
// what an element hands on; and the closed form of each.

#include "sphere_pair.h"

#include "defe/coupling/joint_laws.h"
#include "defe/coupling/penalty.h"

#include <gtest/gtest.h>

#include <utility>
#include <vector>

namespace defe {
namespace {

  constexpr double E = 74e9, nu = 0.2, r = 0.5e-3;
  const DEPair des{{{E, nu}, {E, nu}}, {r, r}, 2.0 * r};
  const SphereOnDE ball{3e-3, {E, nu}, r, 1e-6, 4e12};

  class Law : public ::testing::TestWithParam<int> {
   protected:
    const NormalLaw &law = normal_law(GetParam());
    using Spring = std::function<NormalSpring(double)>;
    std::vector<Spring> both() const
    {
      return {[this](double g) {
                return law.between_des(g, des);
              },
              [this](double g) {
                return law.sphere_on_de(g, ball);
              }};
    }
    /// Two DEs, with the mass of cubes of glass.
    test::SpherePair pair(double e, double friction) const
    {
      test::SpherePair p({1.0, 1.0, e, friction, damping_ratio(e)});
      p.ri = p.rj = r;
      p.distance = 2.0 * r;
      p.mi = 2500.0 * 8.0 * r * r * r;
      p.mj = 2.0 * p.mi;
      p.spring = [this](double g) {
        return law.between_des(g, des);
      };
      return p;
    }
  };
  INSTANTIATE_TEST_SUITE_P(All, Law, ::testing::Range(0, static_cast<int>(normal_laws().size())),
                           [](const auto &info) {
                             return std::string(normal_law(info.param).name());
                           });

  TEST_P(Law, IsFoundByItsName)
  {
    EXPECT_EQ(find_normal_law(law.name()), GetParam());
    EXPECT_EQ(find_normal_law("rigid"), -1);
  }

  TEST_P(Law, ForceIsTheDerivativeOfTheEnergy)
  {
    for (const auto &spring : both())
      for (double g : {1e-9, 1e-7, 1e-6, 2e-5, 1e-4}) {
        const double step = 1e-5 * g;
        const NormalSpring s = spring(g), plus = spring(g + step), minus = spring(g - step);
        EXPECT_NEAR((plus.energy - minus.energy) / (2.0 * step) / s.force, 1.0, 1e-8) << g;
        EXPECT_NEAR(s.kn * g / s.force, 1.0, 1e-14);
        EXPECT_NEAR(0.5 * s.kn * g * g + s.energy_beyond(g), s.energy, 1e-14 * s.energy);
        EXPECT_GT(s.force, 0.0);
        EXPECT_GE(s.kt, 0.0);
      }
  }

  // Joints, of which the stable time step is, are stiffer than what two DEs press with.
  TEST_P(Law, DEsAreNoStifferThanTheJointBetweenThem)
  {
    for (double g = 1e-3 * r; g < r; g *= 1.1) {
      const double step = 1e-5 * g;
      const double slope =
          (law.between_des(g + step, des).force - law.between_des(g, des).force) / step;
      EXPECT_LE(slope, 1.00001 * E * 2.0 * r) << g;
      EXPECT_LE(law.between_des(g, des).kt, E * 2.0 * r);
    }
  }

  TEST_P(Law, AnElementHandsItsEnergyOn)
  {
    for (double g : {1e-8, 1e-6, 5e-5})
      EXPECT_NEAR(law.overlap_of_energy(law.sphere_on_de(g, ball).energy, ball) / g, 1.0, 1e-12);
    EXPECT_EQ(law.overlap_of_energy(0.0, ball), 0.0);
  }

  TEST_P(Law, RestitutionIsTheGivenOneAtAnySpeed)
  {
    for (double e : {1.0, 0.9, 0.5, 0.2, 0.05})
      for (double speed : {0.1, 10.0}) {
        auto p = pair(e, 0.0);
        p.xi = Vec3(2.0 * r, 0.0, 0.0);
        p.vi = Vec3(-speed, 0.0, 0.0);
        const double before = p.kinetic();
        p.collide_until_no_force(1e-10);
        EXPECT_NEAR((p.vi - p.vj)[0] / speed, e, 4e-3 * std::max(e, 0.2)) << speed;
        EXPECT_NEAR((p.kinetic() + p.damped + p.r.stored) / before, 1.0, 2e-3);
      }
  }

  // The tangential spring gets stiffer and softer again while it is loaded. With k_t times the elongation as its force
  // a ball would gain 3 % or lose 6 %.
  TEST_P(Law, AnObliqueCollisionKeepsItsEnergy)
  {
    for (bool on_ball : {false, true})
      for (double friction : {0.1, 0.4, 10.0}) {
        auto p = pair(1.0, friction);
        if (on_ball) {
          p.rj = ball.R;
          p.distance = r + ball.R;
          p.mj = 2500.0 * 4.19 * ball.R * ball.R * ball.R;
          p.spring = [this](double g) {
            return law.sphere_on_de(g, ball);
          };
        }
        p.xi = Vec3(p.distance, 0.0, 0.0);
        p.vi = Vec3(-2.0, 1.0, 0.5);
        p.wi = Vec3(0.0, 500.0, 0.0);
        const double before = p.kinetic();
        const Vec3 momentum = p.momentum(), angular = p.angular_momentum();
        p.collide(1e-10);
        EXPECT_NEAR((p.kinetic() + p.rubbed) / before, 1.0, 5e-4) << on_ball << ' ' << friction;
        EXPECT_LT((p.momentum() - momentum).norm(), 1e-10 * momentum.norm());
        EXPECT_LT((p.angular_momentum() - angular).norm(), 1e-9 * angular.norm());
        EXPECT_NE(p.wj.norm(), 0.0);
      }
  }

  // Damped and rubbed, on a body that is so large and heavy that the line of centres does not turn: the restitution along it is that of a
  // head-on collision, whatever the tangential spring does, and the energy adds up. (With k_t' xi^2/2 in the normal force: 0.46 for 0.5.)
  TEST_P(Law, FrictionLeavesTheRestitutionAlone)
  {
    for (bool on_ball : {false, true})
      for (double e : {0.9, 0.5, 0.2})
        for (double across : {0.3, 1.0, 2.0, 4.0})
          for (double friction : {0.1, 0.4, 10.0}) {
            auto p = pair(e, friction);
            p.rj = 1e6 * r;
            p.mj = 1e12 * p.mi;
            p.distance = p.ri + p.rj;
            if (on_ball) p.spring = both()[1];
            p.xi = Vec3(0.0, 0.0, 0.0);
            p.xj = Vec3(-p.distance * (1.0 + 1e-15), 0.0, 0.0);
            p.vi = Vec3(-1.0, across, 0.0);
            auto straight = p;
            straight.vi[1] = 0.0;
            const double before = p.kinetic();
            p.collide_until_no_force(1e-9);
            straight.collide_until_no_force(1e-9);
            EXPECT_NEAR(p.vi[0], straight.vi[0], 1e-6)
                << on_ball << ' ' << across << ' ' << friction;
            EXPECT_NEAR(p.vi[0], e, on_ball ? 0.02 : 4e-3);
            EXPECT_NEAR((p.kinetic() + p.damped + p.rubbed + p.r.stored) / before, 1.0, 2e-3);
            EXPECT_GE(p.rubbed, 0.0);
            EXPECT_LT(p.vi[1], across);
          }
  }

  TEST(NormalLaw, LinearIsTheSolidOfTheSofterOne)
  {
    const auto &law = normal_law(find_normal_law("linear"));
    DEPair unlike = des;
    unlike.material[1] = {30e9, 0.3};
    unlike.reach = 1.5 * r;
    for (int turned = 0; turned < 2; ++turned) {
      const NormalSpring s = law.between_des(1e-5, unlike);
      EXPECT_DOUBLE_EQ(s.force, 30e9 * 1.5 * r * 1e-5);
      EXPECT_DOUBLE_EQ(s.kt, s.kn * 2.0 * 0.7 / 1.7);
      std::swap(unlike.material[0], unlike.material[1]);
    }
    EXPECT_DOUBLE_EQ(law.sphere_on_de(1e-5, ball).force,
                     ball_on_patch(1e-5, ball.R, ball.area, ball.k_area).force);
    EXPECT_EQ(JointCoeff().normal_law, find_normal_law("linear")) << "unless another is given";
  }

  TEST(NormalLaw, HertzAndMindlin)
  {
    const auto &law = normal_law(find_normal_law("hertz"));
    DEPair unlike = des;
    unlike.material[1] = {30e9, 0.3};
    unlike.radius[1] = 2.0 * r;
    const double R = 2.0 / 3.0 * r, G[2] = {E / 2.4, 30e9 / 2.6}, g = 2e-6;
    const double E_star = 1.0 / ((1.0 - 0.04) / E + (1.0 - 0.09) / 30e9);
    const NormalSpring s = law.between_des(g, unlike);
    EXPECT_NEAR(s.force / (4.0 / 3.0 * E_star * std::sqrt(R) * std::pow(g, 1.5)), 1.0, 1e-14);
    EXPECT_NEAR(s.energy / (8.0 / 15.0 * E_star * std::sqrt(R) * std::pow(g, 2.5)), 1.0, 1e-14);
    EXPECT_NEAR(s.kt / (8.0 * std::sqrt(R * g) / (1.8 / G[0] + 1.7 / G[1])), 1.0, 1e-14);
    // of one material: Mindlin's ratio to the slope of the normal force
    const NormalSpring same = law.between_des(g, des);
    EXPECT_NEAR(same.kt / mindlin_stiffness(1.5 * same.kn, nu), 1.0, 1e-14);
    // a sphere of other origin is rigid
    const NormalSpring hard = law.sphere_on_de(g, ball);
    const double R_ball = 3e-3 * r / (3e-3 + r);
    EXPECT_NEAR(hard.force / (4.0 / 3.0 * E / 0.96 * std::sqrt(R_ball) * std::pow(g, 1.5)), 1.0,
                1e-14);
    EXPECT_NEAR(hard.kt / mindlin_stiffness(1.5 * hard.kn, nu), 1.0, 1e-14);
  }

  // Johnson, Contact Mechanics, 1985, 11.24: 2.87 (m*^2/(R* E*^2 v))^(1/5), here with all its digits.
  TEST(NormalLaw, DurationOfHertzCollision)
  {
    const auto &law = normal_law(find_normal_law("hertz"));
    for (double speed : {0.1, 1.0, 10.0}) {
      test::SpherePair p({1.0, 0.0, 1.0, 0.0, 0.0});
      p.ri = p.rj = r;
      p.distance = 2.0 * r;
      p.mi = p.mj = 2500.0 * 8.0 * r * r * r;
      p.spring = [&](double g) {
        return law.between_des(g, des);
      };
      p.xi = Vec3(2.0 * r, 0.0, 0.0);
      p.vi = Vec3(-speed, 0.0, 0.0);
      const double E_star = 0.5 * E / (1.0 - nu * nu), m = p.reduced();
      const double duration = 2.868265 * std::pow(m * m / (0.5 * r * E_star * E_star * speed), 0.2);
      const double dt = duration / 2000.0;
      EXPECT_NEAR(p.collide(dt) * dt / duration, 1.0, 1e-3) << speed;
    }
  }

}    // namespace
}    // namespace defe
