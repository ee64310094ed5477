// Elements with a stress before any load: at the places where they were put they have exactly that stress, by either
// kernel, and its energy.

#include "test_fe_common.h"

#include "defe/fe/element_batch.h"
#include "defe/fe/prestress.h"

#include <gtest/gtest.h>

namespace defe::fe {
namespace {

  using test::box;
  using test::glass;

  std::shared_ptr<const MaterialLaw> law_of(bool enhanced)
  {
    return parse_material({"elastic", "74.09e9", "0.2", "2500", enhanced ? "enhanced" : "plain"})
        .law;
  }

  const std::shared_ptr<const MaterialLaw> laws[] = {law_of(false), law_of(true)}, &law = laws[1];

  Mat3 tempered(double surface)
  {
    return Vec3(surface, surface, 0.0).asDiagonal();
  }

  Mat3 any_stress(unsigned seed)
  {
    test::Random random(seed);
    const Mat3 A = random.matrix<Mat3>(150e6);
    return 0.5 * (A + A.transpose());
  }

  ElementBatch batch_of(const HexCoords &X, const Mat3 &sigma, KernelRules rules = {},
                        bool enhanced = true)
  {
    const auto &law = laws[enhanced];
    ElementBatch b(0, *law, KernelChoice(*law, X, rules, &sigma));
    HexCoords free = X.colwise() - X.col(0);
    if (b.own_reference()) free = b.stress_free_map(sigma) * free;
    b.add({0, 1, 2, 3, 4, 5, 6, 7}, nullptr, b.own_reference() ? &free : nullptr);
    b.finish();
    return b;
  }

  HexCoords forces(ElementBatch &b, const HexCoords &x)
  {
    const HexCoords none =
        HexCoords::Constant(1e99);    // where it was placed must not matter any more
    HexCoords f = HexCoords::Zero();
    EXPECT_EQ(b.forces(x.data(), none.data(), f.data(), {}).inverted, -1);
    return f;
  }

  double energy(ElementBatch &b, const HexCoords &x)
  {
    HexCoords unused = HexCoords::Zero();
    double sum = 0.0;
    b.energy(x.data(), x.data(), unused.data(), sum);
    return sum;
  }

  /// -integral of sigma grad N
  HexCoords closed_form(const HexCoords &X, const Mat3 &sigma)
  {
    HexCoords f = HexCoords::Zero();
    for (const Vec3 &xi : gauss_points()) {
      const Mat3 J = jacobian(X, xi);
      f -= J.determinant() * sigma * (shape_gradient(xi) * J.inverse()).transpose();
    }
    return f;
  }

  struct Case {
    HexCoords X;
    Mat3 sigma;
    KernelRules rules;
    bool own;
    bool enhanced = false;
  };

  std::vector<Case> cases()
  {
    test::Random random(3);
    const Mat3 turn = Eigen::AngleAxisd(0.7, Vec3::UnitZ()).toRotationMatrix();
    const Mat3 tilt = random.rotation();
    const HexCoords brick = 1e-3 * box(1.0, 2.0, 0.5), hex = 1e-3 * test::random_hex(random);
    KernelRules lagrangian, each, exact;
    lagrangian.lagrangian = each.own_stress = exact.exact = true;
    std::vector<Case> all = {{brick, tempered(-100e6), {}, false},
                             {brick, tempered(50e6), exact, false},
                             {turn * brick, tempered(-100e6), {}, false},    // stays a box
                             {tilt * brick, tempered(-100e6), {}, true},     // does not
                             {brick, any_stress(4), {}, true},
                             {brick, tempered(-100e6), lagrangian, true},
                             {brick, tempered(-100e6), each, true},
                             {hex, tempered(-160e6), {}, true},
                             {hex, any_stress(5), each, true}};
    const size_t plain = all.size();
    for (size_t k = 0; k < plain; ++k) {
      all.push_back(all[k]);
      all.back().enhanced = true;
    }
    return all;
  }

  TEST(Prestress, ForcesAndEnergyOfOneElement)
  {
    for (const Case &c : cases()) {
      auto b = batch_of(c.X, c.sigma, c.rules, c.enhanced);
      EXPECT_EQ(b.own_reference(), c.own);
      const HexCoords expected = closed_form(c.X, c.sigma);
      // a rounded shape is 4e-13 of its size away from the true one, against a strain of some 1e-3
      const double near = c.rules.exact ? 1e-9 : 1e-12;
      EXPECT_LT((forces(b, c.X) - expected).norm(), near * expected.norm());
      // the laws differ from small strain by some times the strain
      const double strain = strain_of_stress(c.sigma, glass).norm();
      const double small = energy_of_stress(c.sigma, glass) * volume(c.X);
      EXPECT_GT(strain, 5e-4);
      EXPECT_NEAR(energy(b, c.X), small, 3.0 * strain * small);
    }
  }

  // A turn and a further load: the stress turns with the body, and the elastic answer is that of the law.
  TEST(Prestress, TurnsAndRespondsElastically)
  {
    test::Random random(7);
    for (const Case &c : cases()) {
      auto b = batch_of(c.X, c.sigma, c.rules, c.enhanced);
      const Mat3 R = random.rotation();
      const HexCoords turned = R * c.X, f = forces(b, c.X);
      EXPECT_LT((forces(b, turned) - R * f).norm(), 1e-11 * f.norm());
      const HexCoords u = random.matrix<HexCoords>(1e-4 * max_diagonal(c.X) * 1e-3);
      const Eigen::Map<const Eigen::Matrix<double, 24, 1>> v(u.data());
      const Eigen::Matrix<double, 24, 1> linear =
          -(c.enhanced ? stiffness_enhanced(c.X, glass) : stiffness(c.X, glass)) * v;
      const HexCoords change = forces(b, c.X + u) - f;
      const Eigen::Map<const Eigen::Matrix<double, 24, 1>> df(change.data());
      EXPECT_LT((df - linear).norm(), 0.05 * linear.norm());
    }
  }

  // Layers of a pane share kernels, by shape and stress.
  TEST(Prestress, ElementsOfALayerShareAKernel)
  {
    const HexCoords X = box(1.0, 1.0, 1.0);
    const Mat3 sigma = tempered(-100e6), other = tempered(-99e6);
    const auto b = batch_of(X, sigma);
    const HexCoords moved = X.colwise() + Vec3(5.0, 6.0, 7.0);
    EXPECT_TRUE(b.takes(0, KernelChoice(*law, moved, {}, &sigma)));
    EXPECT_FALSE(b.takes(0, KernelChoice(*law, X, {}, &other)));
    EXPECT_FALSE(b.takes(0, KernelChoice(*law, X, {})));
    EXPECT_FALSE(b.takes(0, KernelChoice(*law, 1.01 * X, {}, &sigma)));
    KernelRules each;
    each.own_stress = true;
    const auto own = batch_of(X, sigma, each);
    EXPECT_TRUE(own.takes(0, KernelChoice(*law, 1.01 * X, each, &other)));
    EXPECT_FALSE(own.takes(0, KernelChoice(*law, 1.01 * X, each)));
  }

  // Over the thickness neither force nor moment, and the profile itself within a thin layer.
  TEST(Prestress, ParabolaIsInEquilibrium)
  {
    const ParabolaStress pane{1, -0.001, 0.007, -100e6};
    const double heights[] = {-0.001, 0.0, 0.0011, 0.002, 0.0045, 0.005, 0.007};    // graded
    double force = 0.0, moment = 0.0, size = 0.0;
    for (int k = 0; k < 6; ++k) {
      HexCoords X = 1e-3 * box(1.0, 1.0, 1.0);
      for (int a = 0; a < 8; ++a) X(1, a) = heights[k + (hex_sign[a][1] > 0)];
      const Mat3 s = pane.over(X);
      EXPECT_EQ(s(0, 0), s(2, 2));
      EXPECT_EQ(s(1, 1), 0.0);
      const double t = heights[k + 1] - heights[k];
      force += s(0, 0) * t;
      size += std::abs(s(0, 0)) * t;
    }
    for (int k = 0; k < 8; ++k) {    // even layers: the moments cancel
      HexCoords X = 1e-3 * box(1.0, 1.0, 1.0);
      X.row(1).array() += 1e-3 * (k - 1);
      moment += pane.over(X)(0, 0) * (k - 3.5);
    }
    EXPECT_LT(std::abs(force), 1e-14 * size);
    EXPECT_LT(std::abs(moment), 1e-13 * 100e6);
    for (const auto &[y, s] : {std::pair(-0.001, -100e6), {0.003, 50e6}, {0.007, -100e6}}) {
      HexCoords X = 1e-6 * box(1.0, 1.0, 1.0);
      X.row(1).array() += y - 0.5e-6;
      EXPECT_NEAR(pane.over(X)(0, 0), s, 1e2);
    }
  }

  TEST(Prestress, RoundingIsBelowWhatPositionsTell)
  {
    const Mat3 sigma = any_stress(9), noisy = (1.0 + 1e-15) * sigma;
    EXPECT_EQ(rounded_stress(sigma, glass), rounded_stress(noisy, glass));
    EXPECT_LT((rounded_stress(sigma, glass) - sigma).norm(), 2e-4);
  }

}    // namespace
}    // namespace defe::fe
