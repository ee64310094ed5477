// Fragments: sets and their labels on one rank, merging of labels between ranks, sums.

#include "defe/coupling/fragments.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <random>

using namespace defe;

namespace {

using Edges = std::vector<std::pair<std::int64_t, std::int64_t>>;

/// What LAMMPS' ranks do, one after the other: every edge is seen by some rank.
struct Ranks {
  std::vector<LabelMerge> merge;
  int rounds = 0;
  size_t most_edges = 0;

  explicit Ranks(int n) : merge(n) {}
  size_t home(std::int64_t label) const { return label % merge.size(); }

  template <class Send> std::vector<std::vector<LabelEdge>> route(const Send &send)
  {
    std::vector<std::vector<LabelEdge>> arrived(merge.size());
    size_t edges = 0;
    for (auto &m : merge)
      for (const auto &e : send(m)) {
        arrived[home(e.at)].push_back(e);
        edges++;
      }
    most_edges = std::max(most_edges, edges);
    return arrived;
  }

  void run()
  {
    bool changed = true;
    while (changed && rounds < 100) {
      auto large = route([](LabelMerge &m) {
        return m.edges_for_large();
      });
      for (size_t p = 0; p < merge.size(); p++) merge[p].take_large(large[p]);
      auto small = route([](LabelMerge &m) {
        return m.edges_for_small();
      });
      changed = false;
      for (size_t p = 0; p < merge.size(); p++) {
        merge[p].take_small(small[p]);
        changed = changed || merge[p].changed();
      }
      rounds++;
    }
  }

  std::int64_t lowest(std::int64_t label) const { return merge[home(label)].lowest(label); }
};

/// Lowest vertex of each component, by breadth-first search.
std::map<std::int64_t, std::int64_t> components(const Edges &edges)
{
  std::map<std::int64_t, std::vector<std::int64_t>> next;
  for (const auto &e : edges) {
    next[e.first].push_back(e.second);
    next[e.second].push_back(e.first);
  }
  std::map<std::int64_t, std::int64_t> lowest;
  for (const auto &v : next) {    // ascending
    if (lowest.count(v.first)) continue;
    std::vector<std::int64_t> front = {v.first};
    lowest[v.first] = v.first;
    while (!front.empty()) {
      const auto u = front.back();
      front.pop_back();
      for (const auto w : next[u])
        if (lowest.emplace(w, v.first).second) front.push_back(w);
    }
  }
  return lowest;
}

int rounds_of(const Edges &edges, int nranks)
{
  Ranks ranks(nranks);
  for (size_t k = 0; k < edges.size(); k++)
    ranks.merge[k * 7 % nranks].add(edges[k].first, edges[k].second);
  ranks.run();
  EXPECT_LT(ranks.rounds, 100);
  EXPECT_LE(ranks.most_edges, 2 * edges.size());    // both ends of each
  for (const auto &v : components(edges)) EXPECT_EQ(ranks.lowest(v.first), v.second);
  return ranks.rounds;
}

/// A chain of n vertices whose labels are 10, 11, ... in order, or shuffled.
Edges chain(int n, unsigned seed)
{
  std::vector<std::int64_t> label(n);
  for (int i = 0; i < n; i++) label[i] = 10 + i;
  if (seed) {
    std::mt19937 random(seed);
    std::shuffle(label.begin(), label.end(), random);
  }
  Edges edges;
  for (int i = 1; i < n; i++) edges.emplace_back(label[i - 1], label[i]);
  return edges;
}

}    // namespace

TEST(Fragments, SetsAreLabelledByTheirLowestId)
{
  const std::vector<std::int64_t> id = {70, 20, 90, 10, 50, 30};
  DisjointSets sets(6);
  sets.join(0, 2);
  sets.join(5, 4);
  sets.join(2, 1);
  sets.join(0, 1);    // again
  EXPECT_EQ(lowest_of_sets(sets, id), (std::vector<std::int64_t>{20, 20, 20, 10, 30, 30}));
  EXPECT_EQ(sets.find(0), sets.find(1));
  EXPECT_NE(sets.find(0), sets.find(3));
}

TEST(Fragments, NothingToMerge)
{
  Ranks ranks(3);
  ranks.merge[1].add(5, 5);    // both ranks agree: no edge
  EXPECT_TRUE(ranks.merge[1].edges().empty());
  ranks.run();
  EXPECT_EQ(ranks.rounds, 1);
  EXPECT_EQ(ranks.lowest(5), 5);
}

TEST(Fragments, RandomGraphsOnAnyNumberOfRanks)
{
  std::mt19937 random(3);
  for (int trial = 0; trial < 200; trial++) {
    const int vertices = 2 + static_cast<int>(random() % 60);
    const int count = 1 + static_cast<int>(random() % (2 * vertices));
    Edges edges;
    for (int k = 0; k < count; k++)
      edges.emplace_back(1 + static_cast<std::int64_t>(random() % vertices) * 1000003,
                         1 + static_cast<std::int64_t>(random() % vertices) * 1000003);
    for (int ranks : {1, 2, 5, 64}) rounds_of(edges, ranks);
  }
}

// A body that a row of 4096 ranks shares: a naive exchange with neighbours would take 4095 rounds.
TEST(Fragments, RoundsGrowWithTheLogarithmOfAChain)
{
  for (unsigned seed : {0, 1, 2})
    for (int n : {2, 16, 256, 4096})
      EXPECT_LE(rounds_of(chain(n, seed), 16), 2 + std::log2(n)) << n << ", seed " << seed;
  Edges zigzag;    // low, high, low, high
  for (int i = 0; i < 2047; i++) {
    zigzag.emplace_back(10 + i, 5000 + i);
    zigzag.emplace_back(5000 + i, 11 + i);
  }
  EXPECT_LE(rounds_of(zigzag, 16), 14);
}

TEST(Fragments, SharesAndTotals)
{
  // a body of elements and DEs on two ranks, a loose DE, a pair of DEs, and a single element
  const auto whole =
      sum_shares({{9, 1.0, 1, 0}, {3, 2.0, 4, 1}, {7, 2.0, 2, 0}, {3, 5.0, 0, 6}, {12, 3.5, 0, 1}});
  ASSERT_EQ(whole.size(), 4u);
  EXPECT_EQ(whole[0].label, 3);
  EXPECT_EQ(whole[0].mass, 7.0);
  EXPECT_EQ(whole[0].des, 4);
  EXPECT_EQ(whole[0].elements, 7);
  FragmentTotals totals;
  for (const auto &w : whole) totals.add(w);
  EXPECT_EQ(totals.fragments, 4);
  EXPECT_EQ(totals.single_des, 1);
  EXPECT_EQ(totals.mass, 13.5);
  EXPECT_EQ(totals.single_mass, 1.0);
  EXPECT_EQ(totals.largest_mass, 7.0);
  EXPECT_EQ(largest_fragment(whole, totals.largest_mass), 3);
  EXPECT_EQ(largest_fragment({}, 0.0), INT64_MAX);
}

TEST(Fragments, RoundingDoesNotDecideBetweenEqualHalves)
{
  const double m = 0.1, same = (0.1 + 0.2) - 0.2;
  ASSERT_NE(m, same);
  EXPECT_EQ(largest_fragment({{4, m, 8, 0}, {2, same, 8, 0}}, std::max(m, same)), 2);
  EXPECT_EQ(largest_fragment({{4, same, 8, 0}, {2, m, 8, 0}}, std::max(m, same)), 2);
  EXPECT_EQ(largest_fragment({{4, m, 8, 0}, {2, 0.99 * m, 8, 0}}, m), 4);
}
