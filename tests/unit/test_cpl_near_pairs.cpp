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

  struct Item {
    double x[3];
    int index;
  };

  TEST(CellList, RunsHoldAllWithinReachOnceAndNoneFarAway)
  {
    std::vector<Item> items;
    const auto x = cloud(500, 1.0, 7);
    for (int i = 0; i < 500; i++) items.push_back({{x[3 * i], x[3 * i + 1], x[3 * i + 2]}, i});
    const auto places = cloud(200, 3.0, 8);    // also outside of the cells
    for (double size : {0.11, 0.3})
      for (int far : {1, 2, 3})
        for (double beyond : {0.0, 0.07}) {
          const CellList<Item> list(std::vector<Item>(items), size, far);
          int looked_at = 0, wanted = 0;
          for (std::size_t p = 0; p + 2 < places.size(); p += 3) {
            const double at[3] = {places[p] - 1.0, places[p + 1] - 1.0, places[p + 2] - 1.0};
            std::vector<int> times(items.size(), 0);
            list.runs_around(
                at,
                [&](int first, int last) {
                  for (int k = first; k < last; k++) times[list.all()[k].index]++;
                },
                beyond);
            for (const auto &item : items) {
              double rsq = 0.0;
              for (int d = 0; d < 3; d++) rsq += std::pow(item.x[d] - at[d], 2);
              const double reach = size + beyond, cell = 1.5 * size / far;
              const int k = times[item.index];
              EXPECT_LE(k, 1);
              if (rsq <= reach * reach) {
                EXPECT_EQ(k, 1);
                EXPECT_TRUE(list.may_reach(at, beyond));
                wanted++;
              }
              if (rsq > std::pow(std::sqrt(2.0) * reach + 3.0 * cell, 2)) { EXPECT_EQ(k, 0); }
              looked_at += k;
            }
          }
          EXPECT_GT(wanted, 20);
          EXPECT_LT(looked_at, 8 * wanted);
        }
  }

  TEST(NearPairs, OnlyThoseThatAreListed)
  {
    const std::vector<double> x(9, 0.0);
    EXPECT_EQ(found({0, 2}, {}, x, 1.0), (Pairs{{0, 2}}));
    EXPECT_EQ(found({}, {}, x, 1.0), Pairs());
  }

}    // namespace
}    // namespace defe
