#include "defe/coupling/surface_search.h"

#include "surface_points.h"

namespace defe {

struct SurfaceSearch::Work {
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
  work->facets.pair_balls();
  work->points.run(scene, work->faces, work->facets, tables);
  work->facets.keep_used();
}

int SurfaceSearch::looked_at() const
{
  return work->facets.count();
}

}    // namespace defe
