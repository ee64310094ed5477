// A joint or tie from its strength to its end: when it starts, and that the entries of the account add up to the
// work that is done on it.

#include "defe/coupling/joint_softening.h"

#include <gtest/gtest.h>

namespace defe {
namespace {

  const CohesiveParameters glass{60e6, 10.0, 0.5, false};
  const JointStiffness stiffness = joint_stiffness(20e9, 30e9, 1e-3);
  const Vec3 ex(1.0, 0.0, 0.0), ey(0.0, 1.0, 0.0);

  struct Joint {
    double state[CohesiveState::size] = {0.0, 0.0, 0.0, 0.0, 0.0, 0.0};
    double length0 = 0.0, stored = 0.0, lost = 0.0;
    signed char pending = 0;
    SofteningJoint view() { return {state, length0, 4e-6, stored, lost, pending}; }
    CohesiveState now() const { return CohesiveState::unpack(state); }
  };

  bool starts(Joint &j, const Vec3 &traction, const Vec3 &normal = ex, const Vec3 &along = ex)
  {
    auto view = j.view();
    return start_softening(view, traction, normal, along, 1.1e-3, stiffness, opening_law_of_ties(),
                           glass);
  }

  TEST(JointSoftening, StartsAtItsStrengthAndOnlyInTension)
  {
    Joint j;
    EXPECT_FALSE(starts(j, 59e6 * ex));
    EXPECT_EQ(j.length0, 0.0) << "nothing is set";
    EXPECT_FALSE(starts(j, -100e6 * ex + 200e6 * ey));
    EXPECT_TRUE(starts(j, 61e6 * ex));
    EXPECT_DOUBLE_EQ(j.now().s0, 61e6);
    EXPECT_DOUBLE_EQ(j.length0, 1.1e-3 - 61e6 / stiffness.k_n);
  }

  // sqrt(40^2 + (0.5 * 100)^2) = 64
  TEST(JointSoftening, ShearCountsByItsWeight)
  {
    Joint j;
    EXPECT_TRUE(starts(j, 40e6 * ex + 100e6 * ey));
    EXPECT_NEAR(j.now().s0, std::hypot(40e6, 50e6), 1.0);
    EXPECT_FALSE(starts(j, 40e6 * ex + 80e6 * ey));
  }

  // In a distorted cell the joint does not stretch along the normal of the face that its strength is judged by.
  TEST(JointSoftening, StrengthByTheFaceStretchAlongTheJoint)
  {
    const Vec3 along = Vec3(0.8, 0.6, 0.0);
    Joint j;
    ASSERT_TRUE(starts(j, 70e6 * ex, ex, along));
    EXPECT_NEAR(j.now().e_n, 0.8 * 70e6 / stiffness.k_n, 1e-12);
    EXPECT_NEAR(j.now().e_s.norm(), 0.6 * 70e6 / stiffness.k_s, 1e-12);
    EXPECT_NEAR(j.now().e_s.dot(along), 0.0, 1e-18);
  }

  /// Pulled apart in n steps by `most` in all; returns what is lost: fracture, released, beside.
  std::array<double, 3> pull(Joint &j, int n, double most, double &work, bool &broken)
  {
    std::array<double, 3> sum = {0.0, 0.0, 0.0};
    work = 0.0;
    double force = 61e6 * 4e-6;
    broken = false;
    for (int k = 1; k <= n && !broken; k++) {
      auto view = j.view();
      const auto step =
          soften(view, ex, 1.1e-3 + k * most / n, Vec3::Zero(), true, stiffness, glass);
      broken = step.law.broken;
      const double now = broken ? 0.0 : step.force.dot(ex);
      work += 0.5 * (force + now) * most / n;
      force = now;
      sum[0] += step.fracture;
      sum[1] += step.released;
      sum[2] += step.beside;
    }
    return sum;
  }

  TEST(JointSoftening, PulledApartTheFractureEnergyIsGfTimesItsArea)
  {
    Joint j;
    ASSERT_TRUE(starts(j, 61e6 * ex));
    const double held = 0.5 * 61e6 * 61e6 / stiffness.k_n * 4e-6;    // in the joint at its start
    double work;
    bool broken;
    const auto sum = pull(j, 4000, 1e-6, work, broken);
    ASSERT_TRUE(broken);
    EXPECT_EQ(j.stored, 0.0);
    EXPECT_NEAR(sum[0], 10.0 * 4e-6, 1e-3 * 4e-5);
    EXPECT_NEAR(sum[0] + sum[1], j.lost, 1e-12 * j.lost);
    EXPECT_NEAR(sum[0] + sum[1] + sum[2], work + held, 1e-9 * held);
  }

  // Coarse steps lose more than the law; that is booked, too: nothing is missing after a few steps.
  TEST(JointSoftening, CoarseStepsLeaveNoEnergyUnbooked)
  {
    Joint j;
    ASSERT_TRUE(starts(j, 61e6 * ex));
    const double held = 0.5 * 61e6 * 61e6 / stiffness.k_n * 4e-6;
    double work;
    bool broken;
    const auto sum = pull(j, 3, 0.2e-6, work, broken);
    ASSERT_FALSE(broken);
    EXPECT_GT(j.stored, 0.0);
    EXPECT_NEAR(sum[0] + sum[1] + sum[2] + j.stored, work + held, 1e-12 * held);
  }

  // At the first force, what corners let go was booked as released before: what the joint has of it is given back.
  TEST(JointSoftening, FirstForceTakesOverWhatTheCornersLetGo)
  {
    Joint j;
    ASSERT_TRUE(starts(j, 61e6 * ex));
    j.pending = 2;
    auto view = j.view();
    const auto step = soften(view, ex, 1.1e-3 + 1e-9, Vec3::Zero(), true, stiffness, glass);
    EXPECT_EQ(j.pending, 0);
    EXPECT_NEAR(step.beside, 4e-6 * (step.law.work_new - step.law.dissipated) - j.stored,
                1e-15 * j.stored);
    EXPECT_LT(step.beside, 0.0);
  }

  TEST(JointSoftening, AnEvaluationBeforeARunChangesNothing)
  {
    Joint j;
    ASSERT_TRUE(starts(j, 61e6 * ex));
    const Joint before = j;
    auto view = j.view();
    soften(view, ex, 1.1e-3, Vec3::Zero(), false, stiffness, glass);
    EXPECT_TRUE(std::equal(std::begin(j.state), std::end(j.state), std::begin(before.state)));
    EXPECT_EQ(j.stored, before.stored);
  }

  TEST(JointSoftening, SlidingPullsBack)
  {
    Joint j;
    ASSERT_TRUE(starts(j, 61e6 * ex));
    auto view = j.view();
    const auto step = soften(view, ex, 1.1e-3, 1e-8 * ey, true, stiffness, glass);
    EXPECT_GT(step.force.dot(ey), 0.0);
    EXPECT_GT(step.force.dot(ex), 0.0);
  }

}    // namespace
}    // namespace defe
