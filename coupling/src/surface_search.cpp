#include "defe/coupling/surface_search.h"

#include "surface_points.h"

#include <algorithm>
#include <map>
#include <tuple>

namespace defe {

struct SurfaceSearch::Work {
  search::KeptSearch kept;
  search::SurfaceFaces faces;
  search::ContactFacets facets;
  search::ContactPoints points;
};

SurfaceSearch::SurfaceSearch() : work(std::make_unique<Work>()) {}
SurfaceSearch::~SurfaceSearch() = default;

void SurfaceSearch::run(const SurfaceScene &scene, SurfaceTables &tables)
{
  tables.clear();
  work->faces.build(scene);
  work->facets.choose(scene, work->faces, tables);
  work->kept.compare(scene, work->faces, work->facets);
  for (int k = 0; k < work->facets.count(); k++)
    if (work->kept.facet_before(k) >= 0) work->facets.recall(k, work->kept.facet_before(k));
  work->facets.pair_balls();
  work->points.run(scene, work->faces, work->facets, work->kept, tables);
  work->facets.keep_used();
}

void SurfaceSearch::forget()
{
  work->kept.forget();
}

int SurfaceSearch::searched_for() const
{
  return work->points.searched_for();
}

int SurfaceSearch::looked_at() const
{
  return work->facets.count();
}

void SurfaceSearch::find_noticed(std::vector<char> &elements) const
{
  const auto &faces = work->faces;
  std::fill(elements.begin(), elements.end(), 0);
  for (int k = 0; k < work->facets.count(); k++)
    for (int node : faces.all[work->facets.side(k).face].node)
      for (int at = faces.first_of(node); at < faces.end_of(node); at++)
        elements[faces.all[faces.at_nodes(at)].element] = 1;
}

namespace {

  /// Of each facet of these tables: where it is in the others, -1: nowhere.
  std::vector<int> facets_in(const SurfaceTables &tables, const SurfaceTables &others)
  {
    const auto key = [](const ContactFacet &f) {
      return std::make_tuple(f.element, f.node[0], f.node[1], f.node[2], f.node[3]);
    };
    std::map<decltype(key(others.facets.front())), int> place;
    for (std::size_t k = 0; k < others.facets.size(); k++)
      place[key(others.facets[k])] = static_cast<int>(k);
    std::vector<int> there;
    for (const auto &f : tables.facets) {
      const auto found = place.find(key(f));
      there.push_back(found == place.end() ? -1 : found->second);
    }
    return there;
  }

}    // namespace

bool search_agrees(const SurfaceScene &scene, const SurfaceTables &tables)
{
  SurfaceTables whole;
  SurfaceSearch().run(scene, whole);
  const auto there = facets_in(tables, whole);
  const auto same_point = [](const ContactPoint &a, const ContactPoint &b) {
    const auto members = [](const ContactPoint &p) {
      return std::tie(p.atom, p.part, p.sharp, p.first, p.count, p.own, p.nown, p.r, p.area,
                      p.k_own, p.half);
    };
    return members(a) == members(b);
  };
  const auto same_facet = [](const ContactFacet &a, const ContactFacet &b) {
    const auto members = [](const ContactFacet &f) {
      return std::tie(f.part, f.element, f.area, f.k_area, f.half_xi, f.half_eta, f.depth_max,
                      f.outer);
    };
    return std::equal(a.rim, a.rim + 4, b.rim) && members(a) == members(b);
  };
  if (tables.facets.size() != whole.facets.size()) return false;
  for (std::size_t k = 0; k < there.size(); k++)
    if (there[k] < 0 || !same_facet(tables.facets[k], whole.facets[there[k]])) return false;
  const auto same = [](const auto &a, const auto &b, auto equal) {
    return std::equal(a.begin(), a.end(), b.begin(), b.end(), equal);
  };
  return same(tables.points, whole.points, same_point) &&
      same(tables.candidates, whole.candidates,
           [&there](int a, int b) {
             return there[a] == b;
           }) &&
      same(tables.patches, whole.patches,
           [&there](const ContactPatch &a, const ContactPatch &b) {
             return there[a.facet] == b.facet && a.corner == b.corner;
           }) &&
      same(tables.balls, whole.balls, [&there](const ContactBall &a, const ContactBall &b) {
           return a.atom == b.atom && there[a.facet] == b.facet;
         });
}

}    // namespace defe
