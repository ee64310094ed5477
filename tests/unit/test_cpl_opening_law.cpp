// All registered laws of opening alike; and a further one, its file and its line, from the strength of a joint to its
// end.

#include "opening_tension.cpp"

#include "joint_world.h"

#include <gtest/gtest.h>

namespace defe {
namespace {

  std::vector<const OpeningLaw *> with_the_new_law()
  {
    auto all = opening_laws();
    all.push_back(&tension_opening);
    return all;
  }

  CohesiveParameters glass(double beta, bool reciprocal = false)
  {
    return {60e6, 10.0, beta, reciprocal};
  }

  class Opening : public ::testing::TestWithParam<const OpeningLaw *> {};
  INSTANTIATE_TEST_SUITE_P(All, Opening, ::testing::ValuesIn(with_the_new_law()),
                           [](const auto &info) {
                             return std::string(info.param->name());
                           });

  TEST_P(Opening, NothingStartsBelowTheLeastTraction)
  {
    const OpeningLaw &law = *GetParam();
    for (const auto &par :
         {glass(0.1), glass(1.0), glass(3.0), glass(0.1, true), glass(3.0, true)}) {
      const double least = std::min(law.least_traction(par), 1e12);
      EXPECT_GT(least, 0.0);
      for (int k = 0; k <= 36; ++k) {
        const double angle = k * std::acos(-1.0) / 36.0;
        EXPECT_FALSE(
            law.starts(0.999999 * least * std::cos(angle), 0.999999 * least * std::sin(angle), par))
            << angle;
      }
    }
  }

  TEST_P(Opening, AJointStartsAtItsStrengthOrACrackOpensIt)
  {
    const OpeningLaw &law = *GetParam();
    EXPECT_EQ(law.starts(60.001e6, 0.0, glass(0.1)), !law.by_cracks());
    EXPECT_FALSE(law.starts(59.999e6, 0.0, glass(0.1)));
    EXPECT_FALSE(law.starts(-1e9, 0.0, glass(0.1))) << "pressed";
  }

  TEST(OpeningLaw, IsFoundByItsName)
  {
    const auto &all = opening_laws();
    for (std::size_t k = 0; k < all.size(); ++k)
      EXPECT_EQ(find_opening_law(all[k]->name()), static_cast<int>(k));
    EXPECT_EQ(find_opening_law("tension"), -1) << "not registered";
    EXPECT_EQ(JointCoeff().opening, find_opening_law("rings")) << "unless another is given";
    EXPECT_EQ(names_of_opening_laws(true), "rings");
    EXPECT_EQ(names_of_opening_laws(false), "lattice");
    EXPECT_FALSE(opening_law_of_ties().by_cracks()) << "no crack runs along a face";
  }

  // sqrt(t_n^2 + (beta t_s)^2), or t_s/beta
  TEST(OpeningLaw, ShearCountsByItsWeightInTheLattice)
  {
    const OpeningLaw &law = *opening_laws()[find_opening_law("lattice")];
    EXPECT_FALSE(law.starts(40e6, 80e6, glass(0.5)));
    EXPECT_TRUE(law.starts(40e6, 100e6, glass(0.5)));
    EXPECT_FALSE(law.starts(40e6, 20e6, glass(0.5, true)));
    EXPECT_TRUE(law.starts(40e6, 25e6, glass(0.5, true)));
    EXPECT_FALSE(law.starts(-1.0, 1e9, glass(0.5))) << "under pressure";
  }

  const fe::IsotropicElastic material{74.09e9, 0.2, 2500.0};
  constexpr double h = 2e-3;

  test::JointWorld bar(const OpeningLaw *law, double beta)
  {
    JointCoeff c;
    c.cohesive = glass(beta);
    c.has_connective = c.has_cohesive = true;
    const auto all = with_the_new_law();
    while (all[c.opening] != law) ++c.opening;
    return test::JointWorld(
        {test::box_mesh(2, 1, 1, h), {1, 1}, material}, c,
        [](int) {
          return 0;
        },
        true, all);
  }

  // Sheared: joints of the lattice open, of the new law none.
  TEST(NewOpeningLaw, DecidesWhenJointsStart)
  {
    const OpeningLaw *lattice = opening_laws()[find_opening_law("lattice")];
    for (const OpeningLaw *law : {lattice, &tension_opening}) {
      SCOPED_TRACE(law->name());
      auto w = bar(law, 3.0);
      const double shear = 25e6 / material.mu(), pull = 10e6 / material.E;
      for (std::size_t i = 0; i < w.x.size(); ++i)
        w.x[i] = w.block.X[i] + Vec3(pull, shear, 0.0) * w.block.X[i][0];
      w.forces(1e-9);
      EXPECT_EQ(w.ranks[0]->jt.pending.empty(), law == &tension_opening);
    }
  }

  // Torn in two, all that it was is motion, joints, and in the account.
  TEST(NewOpeningLaw, KeepsTheEnergyToTheEnd)
  {
    auto w = bar(&tension_opening, 0.1);
    for (std::size_t i = 0; i < w.x.size(); ++i) w.v[i][0] = w.block.X[i][0] < 0.0 ? -8.0 : 8.0;
    w.forces(2e-9, false);
    const double start = w.kinetic();
    for (int k = 0; k < 600; ++k) w.step(2e-9);
    EXPECT_GE(w.count(EventKind::BROKEN), 4);
    EXPECT_NEAR(w.kinetic() + w.stored() + w.sum(&EnergyLedger::fracture) +
                    w.sum(&EnergyLedger::release),
                start, 2e-3 * start);
  }

}    // namespace
}    // namespace defe
