// What a run needs to know of a mesh: stable steps of its elements and of the DEs that these become, radii, sizes.

#include "defe/coupling/mesh_measure.h"

#include "defe/coupling/conversion.h"
#include "defe/fe/hex8.h"
#include "defe/fe/stable_step.h"

#include <gtest/gtest.h>

namespace defe {
namespace {

  using fe::HexCoords;

  HexCoords box(double a, double b, double c)
  {
    HexCoords X;
    for (int n = 0; n < 8; n++)
      X.col(n) << (fe::hex_sign[n][0] + 1) / 2 * a, (fe::hex_sign[n][1] + 1) / 2 * b,
          (fe::hex_sign[n][2] + 1) / 2 * c;
    return X;
  }

  std::shared_ptr<const fe::MaterialLaw> law(const std::vector<std::string> &words)
  {
    return fe::parse_material(words).law;
  }

  const auto glass = law({"elastic", "74.09e9", "0.2", "2500"});
  const auto rubber = law({"elastic", "1e9", "0.4", "1000"});
  const auto rigid = law({"rigid", "7800"});

  /// Part 0: glass that converts to type 2; 1: rubber; 2: rigid.
  MeshMeasure measure(bool exact = false)
  {
    return MeshMeasure({{glass.get(), true, 2}, {rubber.get(), false, 0}, {rigid.get(), false, 0}},
                       2, exact);
  }

  void add(MeshMeasure &m, int part, const HexCoords &X)
  {
    const fe::MaterialLaw *laws[3] = {glass.get(), rubber.get(), rigid.get()};
    const double volume = fe::volume(X);
    m.add(part, X, volume, laws[part]->elastic().rho * volume);
  }

  TEST(MeshMeasure, StepsAreTheSmallestOfAllElements)
  {
    auto m = measure();
    EXPECT_EQ(m.steps().elements, 1.0e300);
    add(m, 1, box(1.0, 1.0, 1.0));
    EXPECT_EQ(m.steps().elements, rubber->critical_step(box(1.0, 1.0, 1.0)));
    EXPECT_EQ(m.steps().des, 1.0e300) << "rubber does not convert";
    add(m, 0, box(0.2, 0.2, 0.2));
    add(m, 0, box(0.1, 0.1, 0.1));
    EXPECT_EQ(m.steps().elements, glass->critical_step(box(0.1, 0.1, 0.1)));
    const auto expected = discrete_steps(box(0.1, 0.1, 0.1), glass->elastic(), 2500.0 * 1e-3);
    EXPECT_NEAR(m.steps().des, expected.des, 1e-12 * expected.des);
    EXPECT_NEAR(m.steps().joints, expected.joints, 1e-12 * expected.joints);
  }

  TEST(MeshMeasure, RigidElementsLimitNoStepAndBearNoForce)
  {
    auto m = measure();
    add(m, 2, box(1e-6, 1e-6, 1e-6));
    EXPECT_EQ(m.steps().elements, 1.0e300);
    EXPECT_EQ(m.sizes().largest_force, 0.0);
    EXPECT_DOUBLE_EQ(m.sizes().shortest_edge, 1e-6);
  }

  // Eight spheres in an element of edge h have the radius h/4; in a flat one they are those of its volume.
  TEST(MeshMeasure, RadiiOfTheDEsByType)
  {
    auto m = measure();
    add(m, 0, box(0.4, 0.4, 0.4));
    add(m, 0, box(0.2, 0.2, 0.2));
    add(m, 1, box(4.0, 4.0, 4.0));
    EXPECT_NEAR(m.de_radius()[2], 0.1, 1e-14);
    EXPECT_EQ(m.de_radius()[1], 0.0);
    HexCoords X = box(0.4, 0.4, 0.4);
    X.col(6) += Vec3(0.1, 0.1, 0.1);
    add(m, 0, X);
    double largest = 0.0;
    for (const auto &d : convert_hex(X, X, HexCoords::Zero(), 1.0))
      largest = std::max(largest, d.radius);
    EXPECT_EQ(m.de_radius()[2], largest);
    EXPECT_GT(largest, 0.1);
  }

  TEST(MeshMeasure, MeanSizesOfParts)
  {
    auto m = measure();
    add(m, 0, box(1.0, 1.0, 8.0));
    add(m, 0, box(1.0, 1.0, 1.0));
    add(m, 2, box(3.0, 3.0, 3.0));
    EXPECT_DOUBLE_EQ(m.part_sums()[0].size, 3.0);
    EXPECT_EQ(m.part_sums()[0].number, 2.0);
    EXPECT_EQ(m.part_sums()[1].number, 0.0);
    EXPECT_DOUBLE_EQ(m.part_sums()[2].size, 3.0);
  }

  TEST(MeshMeasure, ElementsMuchLongerThanThick)
  {
    EXPECT_DOUBLE_EQ(slenderness(box(3.0, 1.5, 1.0)), 3.0);
    auto m = measure();
    add(m, 0, box(2.5, 2.5, 1.0));    // not yet
    add(m, 0, box(1.0, 2.6, 2.0));
    add(m, 1, box(1.0, 1.0, 8.0));
    add(m, 1, box(1.0, 8.0, 8.0));
    EXPECT_EQ(m.part_sums()[0].slender, 1.0);
    EXPECT_EQ(m.part_sums()[1].slender, 2.0);
    EXPECT_EQ(m.part_sums()[2].slender, 0.0);
  }

  // Elements that differ by rounding only: whichever comes first, the steps are the same bits.
  TEST(MeshMeasure, ExactStepsDoNotDependOnWhoComesFirst)
  {
    const HexCoords X = box(0.1, 0.2, 0.3);
    const HexCoords other = X.colwise() + Vec3(1.7, -2.9, 0.4);
    ASSERT_NE(HexCoords(other.colwise() - Vec3(other.col(0))), X);
    auto one = measure(true), two = measure(true);
    add(one, 0, X);
    add(two, 0, other);
    EXPECT_EQ(one.steps().elements, two.steps().elements);
    EXPECT_EQ(one.steps().des, two.steps().des);
    EXPECT_EQ(one.steps().joints, two.steps().joints);
  }

  // Ties add stiffness, and a quarter of an element's mass is left at their other ends.
  TEST(DiscreteSteps, BelowThatOfTheElementAndScaleWithSize)
  {
    const auto &e = glass->elastic();
    const auto small = discrete_steps(box(0.1, 0.1, 0.1), e, e.rho * 1e-3);
    const auto large = discrete_steps(box(0.2, 0.2, 0.2), e, e.rho * 8e-3);
    EXPECT_LE(small.des, 0.5 * fe::critical_step(box(0.1, 0.1, 0.1), e));
    EXPECT_LE(small.des, small.joints);
    EXPECT_NEAR(large.des, 2.0 * small.des, 1e-6 * large.des);
    EXPECT_NEAR(large.joints, 2.0 * small.joints, 1e-6 * large.joints);
  }

}    // namespace
}    // namespace defe
