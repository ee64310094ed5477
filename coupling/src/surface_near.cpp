#include "defe/coupling/surface_near.h"

#include <algorithm>
#include <cmath>
#include <cstddef>

namespace defe {

namespace {

  /// Whether surface_forces() may give this pair a share before both have moved by drift/2.
  bool may_touch(const ContactPoint &point, const ContactFacet &facet, const FacetPlane &plane,
                 const Vec3 &p, double drift)
  {
    const bool sphere = point.r > 0.0;
    bool rim = false;
    for (bool edge : facet.rim) rim = rim || edge;
    // beside a rim a node can be far below the plane, and its patch still press
    const double depth = !sphere && rim ? HUGE_VAL : 1.5 * facet.depth_max;
    // there the reach aside is measured on the reference facet
    const double stretched =
        std::max({1.0, plane.half_xi() / facet.half_xi, plane.half_eta() / facet.half_eta});
    const double aside = (sphere ? 1.0 : 1.1) * point.half * stretched;
    return !plane.out_of_reach(p, point.r, depth, aside, drift);
  }

}    // namespace

void NearSurface::list_atoms(const SurfaceTables &tables)
{
  atoms.clear();
  const auto add = [this](int atom) {
    const auto i = static_cast<std::size_t>(atom);
    if (i >= listed.size()) listed.resize(2 * i + 8, 0);
    if (listed[i]) return;
    listed[i] = 1;
    atoms.push_back(atom);
  };
  for (const auto &facet : tables.facets)
    for (int node : facet.node) add(node);
  for (const auto &point : tables.points) add(point.atom);
  for (int atom : atoms) listed[atom] = 0;
}

bool NearSurface::moved(const double *x) const
{
  const double limit = 0.25 * margin * margin;
  double most = 0.0;
  for (std::size_t k = 0; k < atoms.size(); ++k) {
    const double *now = x + 3 * static_cast<std::ptrdiff_t>(atoms[k]), *then = &held[3 * k];
    double square = 0.0;
    for (int d = 0; d < 3; ++d) square += (now[d] - then[d]) * (now[d] - then[d]);
    most = std::max(most, square);
  }
  return !(most <= limit);
}

/// Pairs are to last for some ten steps: more would be far from touching.
void NearSurface::choose_margin(double skin)
{
  constexpr double least = 0.02, most = 0.5;
  if (margin == 0.0)
    margin = 0.1 * skin;
  else if (steps < 8)
    margin *= 1.5;
  else if (steps > 32)
    margin /= 1.5;
  margin = std::clamp(margin, least * skin, most * skin);
}

void NearSurface::choose(const SurfaceTables &tables, const double *x, ContactMemory &memory)
{
  pairs.points.clear();
  pairs.candidates.clear();
  for (const auto &all : tables.points) {
    const Vec3 p(x + 3 * static_cast<std::ptrdiff_t>(all.atom));
    ContactPoint point = all;
    point.first = static_cast<int>(pairs.candidates.size());
    for (int k = all.first; k < all.first + all.count; ++k) {
      const int facet = tables.candidates[k];
      if (may_touch(all, tables.facets[facet], tables.planes[facet], p, margin))
        pairs.candidates.push_back(facet);
    }
    point.count = static_cast<int>(pairs.candidates.size()) - point.first;
    if (point.count > 0 || memory.find(all.atom, all.part)) pairs.points.push_back(point);
  }
}

const ContactPairs &NearSurface::find(const SurfaceTables &tables, const double *x,
                                      ContactMemory &memory, double skin)
{
  if (known && !moved(x)) {
    ++steps;
    return pairs;
  }
  if (!known)
    list_atoms(tables);
  else
    choose_margin(skin);
  if (margin == 0.0) choose_margin(skin);
  choose(tables, x, memory);
  held.resize(3 * atoms.size());
  for (std::size_t k = 0; k < atoms.size(); ++k)
    std::copy_n(x + 3 * static_cast<std::ptrdiff_t>(atoms[k]), 3, &held[3 * k]);
  known = true;
  steps = 0;
  return pairs;
}

}    // namespace defe
