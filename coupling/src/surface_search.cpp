#include "defe/coupling/surface_search.h"

#include "surface_points.h"

#include <algorithm>
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

bool search_agrees(const SurfaceScene &scene, const SurfaceTables &tables)
{
  SurfaceTables whole;
  SurfaceSearch().run(scene, whole);
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
    return std::equal(a.node, a.node + 4, b.node) && std::equal(a.rim, a.rim + 4, b.rim) &&
        members(a) == members(b);
  };
  const auto same = [](const auto &a, const auto &b, auto equal) {
    return std::equal(a.begin(), a.end(), b.begin(), b.end(), equal);
  };
  return tables.candidates == whole.candidates && same(tables.points, whole.points, same_point) &&
      same(tables.facets, whole.facets, same_facet) &&
      same(tables.patches, whole.patches,
           [](const ContactPatch &a, const ContactPatch &b) {
             return a.facet == b.facet && a.corner == b.corner;
           }) &&
      same(tables.balls, whole.balls, [](const ContactBall &a, const ContactBall &b) {
           return a.atom == b.atom && a.facet == b.facet;
         });
}

}    // namespace defe
