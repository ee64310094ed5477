// Elements in batches of one kernel: which elements share one, forces, energies, bounds, histories and faults as by
// the kernel itself, and the longest diagonal.

#include "test_fe_common.h"

#include "defe/fe/element_batch.h"
#include "defe/fe/element_sizes.h"

#include <gtest/gtest.h>

namespace defe::fe {
namespace {

  using test::box;

  std::shared_ptr<const MaterialLaw> law(const std::string &words)
  {
    std::vector<std::string> list;
    for (size_t at = 0; at < words.size();) {
      const size_t end = std::min(words.find(' ', at), words.size());
      list.push_back(words.substr(at, end - at));
      at = end + 1;
    }
    const auto parsed = parse_material(list);
    EXPECT_EQ(parsed.complaint, "");
    return parsed.law;
  }

  const auto glass = law("elastic 74.09e9 0.2 2500");
  const auto rigid = law("rigid 7800");

  /// Two unit cubes side by side along x, in one array of nodes, moved and stretched.
  struct Pair {
    std::vector<Vec3> X, x;
    std::array<int, 8> first, second;

    explicit Pair(double size = 1.0)
    {
      const HexCoords one = box(size, size, size);
      for (int e = 0; e < 2; e++)
        for (int a = 0; a < 8; a++) {
          X.push_back(one.col(a) + Vec3(e * size, 0.0, 0.0));
          (e ? second : first)[a] = 8 * e + a;
        }
      test::Random random(5);
      for (const auto &p : X) x.push_back(1.001 * p + random.matrix<Vec3>(1e-4 * size));
    }
    HexCoords coords(const std::vector<Vec3> &from, int e) const
    {
      HexCoords c;
      for (int a = 0; a < 8; a++) c.col(a) = from[8 * e + a];
      return c;
    }
    HexCoords shape(int e) const { return coords(X, e); }
  };

  ElementBatch batch_of(const MaterialLaw &law, const HexCoords &X, KernelRules rules = {})
  {
    return ElementBatch(0, law, KernelChoice(law, X, rules));
  }

  /// Of both elements.
  ElementBatch batch_of(const MaterialLaw &law, const Pair &pair)
  {
    ElementBatch b = batch_of(law, pair.shape(0));
    b.add(pair.first, nullptr);
    b.add(pair.second, nullptr);
    b.finish();
    return b;
  }

  TEST(ElementBatch, BoxesOfOneShapeAndPartShareAKernel)
  {
    const auto b = batch_of(*glass, box(1.0, 2.0, 3.0));
    const HexCoords moved = box(1.0, 2.0, 3.0).colwise() + Vec3(5.0, 6.0, 7.0);
    EXPECT_TRUE(b.takes(0, KernelChoice(*glass, moved, {})));
    EXPECT_FALSE(b.takes(1, KernelChoice(*glass, moved, {}))) << "another part";
    EXPECT_FALSE(b.takes(0, KernelChoice(*glass, box(1.0, 2.0, 3.001), {}))) << "another shape";
    test::Random random(1);
    EXPECT_FALSE(b.takes(0, KernelChoice(*glass, test::random_hex(random), {}))) << "no box";
  }

  TEST(ElementBatch, AllOtherShapesOfAPartShareOne)
  {
    test::Random random(2);
    const auto b = batch_of(*glass, test::random_hex(random));
    EXPECT_TRUE(b.takes(0, KernelChoice(*glass, test::random_hex(random), {})));
    EXPECT_FALSE(b.takes(0, KernelChoice(*glass, box(1.0, 1.0, 1.0), {})));
    KernelRules rules;
    rules.lagrangian = true;
    const auto all = batch_of(*glass, test::random_hex(random), rules);
    EXPECT_TRUE(all.takes(0, KernelChoice(*glass, box(1.0, 1.0, 1.0), rules)));
  }

  // Elements of one mesh differ by rounding. Which of them comes first must not matter then.
  TEST(ElementBatch, WithExactRulesShapesAreRounded)
  {
    KernelRules rules;
    rules.exact = true;
    const HexCoords X = box(0.1, 0.2, 0.3);
    const HexCoords other = X.colwise() + Vec3(1.7, -2.9, 0.4);
    const KernelChoice a(*glass, X, rules), b(*glass, other, rules);
    EXPECT_EQ(a.shape, b.shape);
    EXPECT_TRUE(ElementBatch(0, *glass, a).takes(0, b));
  }

  TEST(ElementBatch, RigidElementsHaveNoKernelAndNoForces)
  {
    Pair pair;
    auto b = batch_of(*rigid, pair.shape(0));
    EXPECT_TRUE(b.rigid());
    EXPECT_EQ(b.history_size(), 0);
    test::Random random(3);
    EXPECT_TRUE(b.takes(0, KernelChoice(*rigid, test::random_hex(random), {})));
    b.add(pair.first, nullptr);
    b.finish();
    std::vector<double> f(3 * 16, 0.0);
    double sum = 0.0;
    EXPECT_EQ(b.forces(pair.x[0].data(), pair.X[0].data(), f.data(), {}).inverted, -1);
    b.energy(pair.x[0].data(), pair.X[0].data(), f.data(), sum);
    EXPECT_EQ(sum, 0.0);
    EXPECT_EQ(f, std::vector<double>(3 * 16, 0.0));
  }

  TEST(ElementBatch, ForcesEnergyAndBoundAreThoseOfTheKernel)
  {
    Pair pair;
    auto b = batch_of(*glass, pair);
    ASSERT_EQ(b.size(), 2);
    EXPECT_EQ(b.bound(1), 0.0);

    std::vector<double> f(3 * 16, 1.0), unused(3 * 16, 0.0);    // they are added
    const StressBound weights;
    ElementBatch::Output out;
    out.bound = &weights;
    EXPECT_EQ(b.forces(pair.x[0].data(), pair.X[0].data(), f.data(), out).inverted, -1);
    double sum = 100.0, expected = 100.0;
    b.energy(pair.x[0].data(), pair.X[0].data(), unused.data(), sum);
    for (int e = 0; e < 2; e++) {
      const HexCoords x = pair.coords(pair.x, e), X = pair.shape(e);
      const HexCoords forces = test::forces(b.kernel(), x, X);
      const double size = forces.cwiseAbs().maxCoeff();
      for (int a = 0; a < 8; a++)
        for (int k = 0; k < 3; k++)
          EXPECT_NEAR(f[3 * (8 * e + a) + k], 1.0 + forces(k, a), 1e-12 * size);
      expected += b.kernel().energy(x, X);
      const double largest = max_principal(b.kernel().stress(x, X, Vec3::Zero()));
      EXPECT_GE(b.bound(e), largest * (1.0 - 1e-12));
      EXPECT_GT(largest, 0.0);
    }
    EXPECT_NEAR(sum, expected, 1e-12 * expected);
  }

  // The history belongs to the element, not to its place in the batch.
  TEST(ElementBatch, HistoriesAdvanceWhereTheElementKeepsThem)
  {
    const auto pvb = law("prony 2.0e9 1070 1.0e6 1 1.0e8 1.0e6");
    Pair pair;
    auto b = batch_of(*pvb, pair.shape(0));
    ASSERT_GT(b.history_size(), 0);
    std::vector<double> mine(b.history_size(), 0.0), unused(3 * 16, 0.0);
    b.add(pair.first, mine.data());
    b.finish();
    EXPECT_TRUE(b.has_histories());
    double lost = 0.0;
    ElementBatch::Output out;
    out.dissipation = &lost;
    b.forces(pair.x[0].data(), pair.X[0].data(), unused.data(), out);
    EXPECT_EQ(mine, std::vector<double>(mine.size(), 0.0)) << "time stands still";
    out.history_step = 1e-6;
    b.forces(pair.x[0].data(), pair.X[0].data(), unused.data(), out);
    EXPECT_NE(mine, std::vector<double>(mine.size(), 0.0));
    EXPECT_GT(lost, 0.0);
  }

  TEST(ElementBatch, AnElementThatIsInsideOutIsNamed)
  {
    Pair pair;
    auto b = batch_of(*glass, pair);
    for (int a = 0; a < 8; a++) pair.x[8 + a].x() *= -1.0;
    std::vector<double> f(3 * 16, 0.0);
    EXPECT_EQ(b.forces(pair.x[0].data(), pair.X[0].data(), f.data(), {}).inverted, 1);
  }

  TEST(ElementBatch, ForcesBeyondTheGridAreNamed)
  {
    Pair pair;
    auto b = batch_of(*glass, pair.shape(0));
    b.add(pair.first, nullptr);
    b.finish();
    std::vector<double> f(3 * 16, 0.0);
    const SumGrid wide = sum_grid(1e12), narrow = sum_grid(1.0);
    ElementBatch::Output out;
    out.grid = &wide;
    EXPECT_EQ(b.forces(pair.x[0].data(), pair.X[0].data(), f.data(), out).beyond, -1);
    out.grid = &narrow;
    EXPECT_EQ(b.forces(pair.x[0].data(), pair.X[0].data(), f.data(), out).beyond, 0);
  }

  TEST(ElementBatch, LongestDiagonalUnlessItIsCertainlyShort)
  {
    Pair pair;
    auto b = batch_of(*glass, pair);
    for (int a = 0; a < 8; a++) pair.x[8 + a] = 2.0 * pair.X[8 + a];
    const double *x = pair.x[0].data();
    EXPECT_DOUBLE_EQ(b.longest(x, 0.0, 0.0), 2.0 * std::sqrt(3.0));
    EXPECT_EQ(b.longest(x, 10.0, 0.0), 0.0);
    EXPECT_EQ(b.longest(x, 0.0, 5.0), 5.0);
  }

  // Whatever an element brought goes and moves with it: nodes, history, stress-free shape.
  TEST(ElementBatch, TheLastTakesThePlaceOfOneThatIsRemoved)
  {
    Mat3 stress = Mat3::Identity();
    const HexCoords X = box(1.0, 1.0, 1.0);
    KernelRules rules;
    rules.own_stress = true;
    ElementBatch b(0, *glass, KernelChoice(*glass, X, rules, &stress));
    ASSERT_TRUE(b.own_reference());
    double history[4];
    const auto nodes = [](int e) {
      std::array<int, 8> list;
      for (int a = 0; a < 8; a++) list[a] = 8 * e + a;
      return list;
    };
    for (int e = 0; e < 4; e++) {
      const HexCoords shape = (1.0 + e) * X;
      b.add(nodes(e), &history[e], &shape);
    }
    const auto expect = [&](const std::vector<int> &list) {
      ASSERT_EQ(b.size(), static_cast<int>(list.size()));
      for (int e = 0; e < b.size(); e++) {
        EXPECT_EQ(b.nodes(e), nodes(list[e]));
        EXPECT_EQ(b.reference(e), HexCoords((1.0 + list[e]) * X));
      }
    };
    b.remove(1);
    expect({0, 3, 2});
    b.remove(2);
    expect({0, 3});
    b.remove(0);
    expect({3});
    b.remove(0);
    expect({});
    EXPECT_FALSE(b.has_histories());
  }

  TEST(ElementBatch, ClearedItIsEmptyAndKeepsItsKernel)
  {
    Pair pair;
    auto b = batch_of(*glass, pair.shape(0));
    const auto *kernel = &b.kernel();
    b.add(pair.first, nullptr);
    b.finish();
    b.clear();
    EXPECT_EQ(b.size(), 0);
    EXPECT_EQ(&b.kernel(), kernel);
  }

  // ---- sizes ----

  TEST(ElementSizes, ExtremesOfAMesh)
  {
    ElementSizes s;
    s.add(box(1.0, 2.0, 2.0));
    s.add(box(0.5, 1.0, 1.0));
    EXPECT_DOUBLE_EQ(s.diagonal, 3.0);
    EXPECT_DOUBLE_EQ(s.face_diagonal, std::sqrt(8.0));
    EXPECT_DOUBLE_EQ(s.shortest_edge, 0.5);
    EXPECT_EQ(s.largest_force, 0.0) << "rigid elements bear none";
    const IsotropicElastic &e = glass->elastic();
    s.add_force(box(1.0, 2.0, 2.0), e);
    EXPECT_NEAR(s.largest_force, (e.lambda() + 2.0 * e.mu()) * 4.0, 1e-12 * s.largest_force);
  }

  TEST(ShapeCache, FindsWhatHasTheSameShapeAndPart)
  {
    ShapeCache<int> cache(false);
    cache.add(0, cache.shape(box(1.0, 2.0, 3.0)), 7);
    const HexCoords moved = box(1.0, 2.0, 3.0).colwise() + Vec3(1.0, 0.0, 0.0);
    ASSERT_NE(cache.find(0, moved), nullptr);
    EXPECT_EQ(*cache.find(0, moved), 7);
    EXPECT_EQ(cache.find(1, moved), nullptr);
    EXPECT_EQ(cache.find(0, box(1.0, 2.0, 3.1)), nullptr);
  }

  TEST(ShapeCache, ForgetsNothingButDoesNotGrowWithoutEnd)
  {
    ShapeCache<int> cache(false);
    for (int k = 1; k <= 100; k++) cache.add(0, box(k, 1.0, 1.0), k);
    ASSERT_NE(cache.find(0, box(1.0, 1.0, 1.0)), nullptr);
    EXPECT_EQ(*cache.find(0, box(1.0, 1.0, 1.0)), 1);
    EXPECT_EQ(cache.find(0, box(100.0, 1.0, 1.0)), nullptr);
  }

}    // namespace
}    // namespace defe::fe
