#include "defe/coupling/fragments.h"

#include <algorithm>
#include <numeric>

namespace defe {

DisjointSets::DisjointSets(int n) : parent(n)
{
  std::iota(parent.begin(), parent.end(), 0);
}

int DisjointSets::find(int a)
{
  while (parent[a] != a) {
    parent[a] = parent[parent[a]];
    a = parent[a];
  }
  return a;
}

void DisjointSets::join(int a, int b)
{
  a = find(a);
  b = find(b);
  if (a < b)
    parent[b] = a;
  else
    parent[a] = b;
}

std::vector<std::int64_t> lowest_of_sets(DisjointSets &sets, const std::vector<std::int64_t> &id)
{
  const int n = static_cast<int>(id.size());
  std::vector<std::int64_t> lowest(id);
  for (int i = 0; i < n; i++) {
    auto &l = lowest[sets.find(i)];
    l = std::min(l, id[i]);
  }
  for (int i = 0; i < n; i++) lowest[i] = lowest[sets.find(i)];
  return lowest;
}

// ---- labels of several ranks ----

void LabelMerge::add(std::int64_t a, std::int64_t b)
{
  if (a != b) edge.push_back({std::max(a, b), std::min(a, b)});
}

static void sort_unique(std::vector<LabelEdge> &edges)
{
  const auto before = [](const LabelEdge &a, const LabelEdge &b) {
    return a.at != b.at ? a.at < b.at : a.other < b.other;
  };
  const auto same = [](const LabelEdge &a, const LabelEdge &b) {
    return a.at == b.at && a.other == b.other;
  };
  std::sort(edges.begin(), edges.end(), before);
  edges.erase(std::unique(edges.begin(), edges.end(), same), edges.end());
}

/// visit(u, first, last) for the ascending neighbours of every vertex u.
template <class Visit> static void each_vertex(std::vector<LabelEdge> &edges, const Visit &visit)
{
  sort_unique(edges);
  for (auto first = edges.begin(); first != edges.end();) {
    auto last = first;
    while (last != edges.end() && last->at == first->at) ++last;
    visit(first->at, first, last);
    first = last;
  }
}

std::vector<LabelEdge> LabelMerge::edges_for_large()
{
  sort_unique(edge);
  std::vector<LabelEdge> both(edge);
  for (const auto &e : edge) both.push_back({e.other, e.at});
  edge.clear();
  return both;
}

// every larger neighbour of u is connected to the lowest one instead of u

void LabelMerge::take_large(std::vector<LabelEdge> arrived)
{
  change = false;
  each_vertex(arrived, [this](std::int64_t u, auto first, auto last) {
    const std::int64_t m = std::min(u, first->other);
    for (auto e = first; e != last; ++e)
      if (e->other > u) {
        edge.push_back({e->other, m});
        change = change || m != u;
      }
  });
}

std::vector<LabelEdge> LabelMerge::edges_for_small()
{
  sort_unique(edge);
  return std::move(edge);    // each goes to its larger end
}

// u and its smaller neighbours are connected to the lowest of them

void LabelMerge::take_small(std::vector<LabelEdge> arrived)
{
  edge.clear();
  root.clear();
  each_vertex(arrived, [this](std::int64_t u, auto first, auto last) {
    const std::int64_t m = first->other;
    root[u] = m;
    edge.push_back({u, m});
    for (auto e = first + 1; e != last; ++e) edge.push_back({e->other, m});
    change = change || last - first > 1;
  });
}

std::int64_t LabelMerge::lowest(std::int64_t label) const
{
  const auto found = root.find(label);
  return found == root.end() ? label : found->second;
}

// ---- sums ----

std::vector<FragmentShare> sum_shares(std::vector<FragmentShare> shares)
{
  std::stable_sort(shares.begin(), shares.end(),
                   [](const FragmentShare &a, const FragmentShare &b) {
                     return a.label < b.label;
                   });
  std::vector<FragmentShare> sums;
  for (const auto &s : shares) {
    if (sums.empty() || sums.back().label != s.label) {
      sums.push_back(s);
      continue;
    }
    sums.back().mass += s.mass;
    sums.back().des += s.des;
    sums.back().elements += s.elements;
  }
  return sums;
}

void FragmentTotals::add(const FragmentShare &whole)
{
  fragments++;
  mass += whole.mass;
  if (whole.des == 1 && whole.elements == 0) {
    single_des++;
    single_mass += whole.mass;
  }
  largest_mass = std::max(largest_mass, whole.mass);
}

std::int64_t largest_fragment(const std::vector<FragmentShare> &whole, double largest_mass)
{
  std::int64_t label = INT64_MAX;
  for (const auto &w : whole)
    if (w.mass >= (1.0 - 1e-9) * largest_mass) label = std::min(label, w.label);
  return label;
}

}    // namespace defe
