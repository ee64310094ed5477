// Near pairs by cells against all pairs.

#include "defe/coupling/near_pairs.h"

#include <gtest/gtest.h>
#include <random>
#include <set>

namespace defe {
namespace {

  using Pairs = std::multiset<std::pair<int, int>>;

  std::vector<double> cloud(int n, double size, unsigned seed)
  {
    std::mt19937 engine(seed);
    std::uniform_real_distribution<double> at(0.0, size);
    std::vector<double> x(3 * n);
    for (double &v : x) v = at(engine);
    return x;
  }

  Pairs found(const std::vector<int> &small, const std::vector<int> &large,
              const std::vector<double> &x, double farthest)
  {
    Pairs pairs;
    for_near_pairs(small, large, x.data(), farthest, [&](int i, int j) {
      pairs.insert(std::minmax(i, j));
    });
    return pairs;
  }

  TEST(NearPairs, EachOnceAndNoneForgotten)
  {
    const auto x = cloud(400, 1.0, 1);
    std::vector<int> all;
    for (int i = 0; i < 400; i++) all.push_back(i);
    for (double farthest : {0.05, 0.2, 3.0}) {
      Pairs expected;
      for (int i = 0; i < 400; i++)
        for (int j = i + 1; j < 400; j++) {
          double rsq = 0.0;
          for (int k = 0; k < 3; k++) rsq += std::pow(x[3 * i + k] - x[3 * j + k], 2);
          if (rsq < farthest * farthest) expected.emplace(i, j);
        }
      ASSERT_FALSE(expected.empty());
      EXPECT_EQ(found(all, {}, x, farthest), expected);
    }
  }

  TEST(NearPairs, LargeOnesMeetAllSmallOnesAndNotEachOther)
  {
    const auto x = cloud(6, 100.0, 2);
    EXPECT_EQ(found({0, 2, 4}, {1, 5}, x, 1e-6),
              (Pairs{{0, 1}, {1, 2}, {1, 4}, {0, 5}, {2, 5}, {4, 5}}));
  }

  TEST(NearPairs, OnlyThoseThatAreListed)
  {
    const std::vector<double> x(9, 0.0);
    EXPECT_EQ(found({0, 2}, {}, x, 1.0), (Pairs{{0, 2}}));
    EXPECT_EQ(found({}, {}, x, 1.0), Pairs());
  }

}    // namespace
}    // namespace defe
