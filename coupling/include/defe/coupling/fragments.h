#ifndef DEFE_COUPLING_FRAGMENTS_H
#define DEFE_COUPLING_FRAGMENTS_H

/// \file
/// Pieces that hold together (fragments): connected components of a graph whose vertices, atoms
/// with unique IDs > 0, are spread over ranks. The label of a fragment is the lowest ID in it, on any
/// number of ranks.
///
/// Each rank first joins what it knows (DisjointSets, nearly linear) and labels each of its sets by
/// the lowest ID in it, ghosts included. A set that two ranks share may then have two labels: these
/// pairs are the edges of a second, much smaller graph, whose vertices are labels; its size goes
/// with the borders between ranks, not with the number of atoms. LabelMerge finds its components by
/// alternating "large-star" and "small-star" operations (Kiveris et al., Connected components in
/// MapReduce and beyond, SoCC 2014): every vertex has a home rank, a round sends each edge to the
/// homes of its ends, and the number of rounds grows with the logarithm of the longest chain, not with
/// its length.

#include <cstdint>
#include <unordered_map>
#include <vector>

namespace defe {

/// Disjoint sets of the numbers 0 to n - 1.
class DisjointSets {
 public:
  explicit DisjointSets(int n);
  int find(int a);    ///< representative of the set of a
  void join(int a, int b);

 private:
  std::vector<int> parent;
};

/// Lowest ID in the set of each of the n numbers.
std::vector<std::int64_t> lowest_of_sets(DisjointSets &sets, const std::vector<std::int64_t> &id);

/// One end of an edge between two labels, on its way to the home of `at`.
struct LabelEdge {
  std::int64_t at, other;
};

/// Merges labels that belong to one fragment. One object per rank; between the two halves of a
/// round the caller brings every LabelEdge to the home of its `at` (any function of the label):
///
///   add(a, b) for all pairs that are seen; then
///   do {
///     take_large(route(edges_for_large()));
///     take_small(route(edges_for_small()));
///   } while (changed() on any rank);
///   lowest(a) at the home of a
class LabelMerge {
 public:
  void add(std::int64_t a, std::int64_t b);
  /// Edges at this rank: those that were added, or are left.
  const std::vector<LabelEdge> &edges() const { return edge; }

  std::vector<LabelEdge> edges_for_large();
  void take_large(std::vector<LabelEdge> arrived);
  std::vector<LabelEdge> edges_for_small();
  void take_small(std::vector<LabelEdge> arrived);

  /// Whether the last round changed an edge that came here.
  bool changed() const { return change; }

  /// After the last round, at the home of the label: the lowest label of its fragment.
  std::int64_t lowest(std::int64_t label) const;

 private:
  std::vector<LabelEdge> edge;
  std::unordered_map<std::int64_t, std::int64_t> root;    // of labels at home here
  bool change = false;
};

/// What there is to say of one fragment, or of a rank's share of it.
struct FragmentShare {
  std::int64_t label;
  double mass;
  std::int64_t des, elements;
};

/// Joins shares of one label; the order of the result is that of the labels.
std::vector<FragmentShare> sum_shares(std::vector<FragmentShare> shares);

/// Sums over fragments; those of several ranks add up (the largest mass: their maximum).
struct FragmentTotals {
  std::int64_t fragments = 0, single_des = 0;    ///< single: one DE and nothing else
  double mass = 0.0, single_mass = 0.0;
  double largest_mass = 0.0;

  void add(const FragmentShare &whole);
};

/// Of these fragments, the lowest label of those of the largest mass; INT64_MAX if there is none.
/// Masses within 1e-9 of the largest are equal to it: sums of masses depend on the number of ranks
/// by rounding, which must not decide between equal halves.
std::int64_t largest_fragment(const std::vector<FragmentShare> &whole, double largest_mass);

}    // namespace defe

#endif
