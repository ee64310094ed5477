#ifndef DEFE_COUPLING_SURFACE_FACETS_H
#define DEFE_COUPLING_SURFACE_FACETS_H

// Part of the search for contacts (surface_search.h): facets that something may touch.

#include "surface_faces.h"

#include "defe/coupling/bins.h"
#include "defe/coupling/surface_contact.h"

#include <array>
#include <vector>

namespace defe::search {

/// Cosine from which on a node's facet faces another one: facing_limit less what normals may turn until the
/// next search.
constexpr double facing = facing_limit - 0.15;

/// A bit for each direction along an axis, +x, -x, +y, ..., in which a vector has a component above `limit`.
inline unsigned directions(const double *v, double limit)
{
  unsigned bits = 0;
  for (int d = 0; d < 3; d++) {
    if (v[d] > limit) bits |= 1u << (2 * d);
    if (v[d] < -limit) bits |= 2u << (2 * d);
  }
  return bits;
}
constexpr unsigned positive_directions = 21u;
inline unsigned opposite(unsigned bits)
{
  return ((bits & positive_directions) << 1) | ((bits >> 1) & positive_directions);
}

class ContactFacets {
 public:
  /// What the search needs of each facet of the tables.
  struct Side {
    double centre[3], extent;
    int element, face;    // face: index into SurfaceFaces::all
    bool outer, mine, complete, used;
    unsigned directions;    // of its normal
  };

  void choose(const SurfaceScene &, SurfaceFaces &, SurfaceTables &);
  void pair_balls();
  /// This one was facet `before` of the last search, with the same neighbours: what was measured then holds.
  void recall(int k, int before);
  /// Leaves only facets that are used in the tables: all are looked at in every step.
  void keep_used();

  int count() const { return static_cast<int>(sides.size()); }
  const Side &side(int k) const { return sides[k]; }
  double largest_extent() const { return faces->extent_max; }

  /// Reference geometry, rims and stiffness: only of facets that are near something.
  void complete(int k)
  {
    if (!sides[k].complete) measure(k);
  }
  void use(int k)
  {
    complete(k);
    sides[k].used = true;
  }
  /// An order that depends on IDs only.
  bool by_identity(int a, int b) const
  {
    const auto &fa = tables->facets[a], &fb = tables->facets[b];
    if (fa.part != fb.part) return fa.part < fb.part;
    if (fa.element != fb.element) return fa.element < fb.element;
    return a < b;    // faces of one element are in order
  }

 private:
  const SurfaceScene *scene = nullptr;
  SurfaceFaces *faces = nullptr;
  SurfaceTables *tables = nullptr;
  std::vector<Side> sides;
  std::vector<int> balls, large_balls;    // owned and ghost
  std::vector<std::array<int, 4>> nodes;
  std::vector<ContactFacet> measured;    // in the last search
  std::vector<int> measured_at;          // by facet, -1: it was not

  void add(const Face &);
  void measure(int k);
  void find_planes();
  bool is_ball(int i) const
  {
    return scene->particles.radius[i] > 0.0 && scene->des.distance[i] == 0.0;
  }
  bool is_large(int ball) const { return scene->particles.radius[ball] > scene->element_size; }
  bool ball_is_near(int ball, const double *centre, double extent) const;
  void collect_balls();
  bool meets_large_ball(const Face &) const;
  Cells neighbourhoods() const;
  void pair_ball(int ball, int k);
};

}    // namespace defe::search

#endif
