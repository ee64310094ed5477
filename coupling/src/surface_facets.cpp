#include "surface_facets.h"

#include "surface_kept.h"

#include "defe/coupling/penalty.h"
#include "defe/fe/hex8.h"

#include <Eigen/Geometry>

#include <algorithm>
#include <cmath>
#include <utility>

namespace defe::search {

// Two facets whose normals are opposed by no more than this on any axis do not press on each
// other: facing_limit / 3 less what normals may turn until the next search.
static constexpr double opposed = 0.04;

// Two normals with n.m < -c have components of opposite sign above c / 3 on some axis.
static constexpr double component_of_facing = 0.3 * KeptSearch::facing_kept;

bool ContactFacets::ball_is_near(int ball, const double *centre, double extent) const
{
  const double far = scene->particles.radius[ball] + extent + scene->skin;
  return dist_sq(scene->particles.at(ball), centre) < far * far;
}

bool ContactFacets::meets_large_ball(const Face &face) const
{
  return std::any_of(large_balls.begin(), large_balls.end(), [&](int i) {
    return ball_is_near(i, face.centre, faces->extent_max);
  });
}

void ContactFacets::collect_balls()
{
  balls.clear();
  large_balls.clear();
  const auto look_at = [this](int i) {
    if (!is_ball(i)) return;
    balls.push_back(i);
    if (is_large(i)) large_balls.push_back(i);
  };
  if (scene->spheres)
    for (int i : *scene->spheres) look_at(i);
  else
    for (int i = 0; i < scene->particles.nall; i++) look_at(i);
}

/* ----------------------------------------------------------------------
   a grid in which all that a facet can touch, except large balls, is at most two cells away
------------------------------------------------------------------------- */

Cells ContactFacets::neighbourhoods() const
{
  const Particles &all = scene->particles;
  double rmax = 0.0;
  Cells space;
  for (const auto &face : faces->all) space.add(face.centre);
  const SurfaceDEs &des = scene->des;
  for (int d = 0; d < des.count; d++) {
    rmax = std::max(rmax, des.distance[des.particle[d]]);
    space.add(all.at(des.particle[d]));
  }
  for (int i : balls) {
    space.add(all.at(i));
    if (!is_large(i)) rmax = std::max(rmax, all.radius[i]);
  }
  // from the middle of a facet to a point that it touches, and to the middle of that one's facet
  const double extent_max = faces->extent_max;
  const double range =
      std::max(2.5 * extent_max, 2.0 * extent_max + 2.0 * rmax) + 1.5 * scene->skin;
  space.divide(0.5 * range);
  return space;
}

/* ----------------------------------------------------------------------
   facets that can meet anything: those with another part, a DE, a ball, or a face of their own part
   that faces them, within the range in which two facets can touch
------------------------------------------------------------------------- */

void ContactFacets::choose(const SurfaceScene &s, SurfaceFaces &f, SurfaceTables &t)
{
  scene = &s;
  faces = &f;
  tables = &t;
  sides.clear();
  collect_balls();

  // a bit for each part; parts beyond the last bit, DEs and balls count as several
  constexpr unsigned several = 3u << 30;
  const auto bit = [](int part) {
    return part < 30 ? 1u << part : several;
  };
  const Cells space = neighbourhoods();
  std::vector<unsigned> who(space.count(), 0), where(space.count(), 0);
  for (auto &face : faces->all) {
    face.cell = space.of(face.centre);
    who[face.cell] |= bit(s.elements[face.element].part);
    where[face.cell] |= directions(face.normal, opposed);
  }
  for (int d = 0; d < s.des.count; d++) who[space.of(s.particles.at(s.des.particle[d]))] |= several;
  for (int i : balls) who[space.of(s.particles.at(i))] |= several;
  space.spread(who, 2);
  space.spread(where, 2);

  for (const auto &face : faces->all) {
    const unsigned there = who[face.cell], axes = where[face.cell];
    const bool alone = (there & (there - 1)) == 0;
    const bool unopposed = (axes & (axes >> 1) & positive_directions) == 0;
    if (alone && unopposed && !meets_large_ball(face)) continue;
    add(face);
  }
  find_planes();
}

void ContactFacets::add(const Face &face)
{
  const SurfaceElement &e = scene->elements[face.element];
  ContactFacet facet;
  facet.element = e.id;
  facet.part = e.part;
  for (int k = 0; k < 4; k++) facet.node[k] = face.node[k];
  facet.k_area = scene->parts[e.part].rigid ? -1.0 : 0.0;
  facet.area = facet.half_xi = facet.half_eta = facet.depth_max = 0.0;    // see measure()
  for (bool &rim : facet.rim) rim = true;
  facet.outer = e.free >> face.face & 1;
  tables->facets.push_back(facet);
  Side side;
  for (int d = 0; d < 3; d++) side.centre[d] = face.centre[d];
  side.extent = std::sqrt(face.extent);
  side.element = face.element;
  side.face = static_cast<int>(&face - faces->all.data());
  side.outer = facet.outer;
  side.mine = (e.node[0] < scene->particles.nlocal);
  side.complete = side.used = false;
  side.directions = directions(face.normal, component_of_facing);
  sides.push_back(side);
}

void ContactFacets::find_planes()
{
  nodes.clear();
  for (const auto &f : tables->facets)
    nodes.push_back({f.node[0], f.node[1], f.node[2], f.node[3]});
  const int n = static_cast<int>(nodes.size());
  tables->planes.resize(n);
  if (n)
    facet_planes(n, reinterpret_cast<const int(*)[4]>(nodes.data()), scene->particles.x,
                 tables->planes.data());
}

void ContactFacets::measure(int k)
{
  sides[k].complete = true;
  ContactFacet &f = tables->facets[k];
  Vec3 P[4];
  for (int a = 0; a < 4; a++) P[a] = Vec3(scene->particles.reference(f.node[a]));
  f.area = fe::face_area(P);
  const Vec3 a = 0.25 * (P[1] + P[2] - P[0] - P[3]), b = 0.25 * (P[2] + P[3] - P[0] - P[1]);
  const double cross = a.cross(b).norm();
  f.half_xi = cross / b.norm();
  f.half_eta = cross / a.norm();
  const double volume = scene->elements[sides[k].element].volume;
  faces->find_rims(sides[k].face, f.rim);
  // half of the element: beyond, a point would be nearer to its far side
  f.depth_max = 0.5 * std::min(volume / f.area, std::sqrt(f.area));
  if (f.k_area < 0.0) return;
  f.k_area = penalty_stiffness_per_area(scene->factor, scene->parts[f.part].bulk, f.area, volume);
}

void ContactFacets::recall(int k, int before)
{
  if (measured_at[before] < 0) return;
  const ContactFacet &then = measured[measured_at[before]];
  ContactFacet &f = tables->facets[k];
  f.area = then.area;
  f.k_area = then.k_area;
  f.half_xi = then.half_xi;
  f.half_eta = then.half_eta;
  f.depth_max = then.depth_max;
  std::copy_n(then.rim, 4, f.rim);
  sides[k].complete = true;
}

/* ----------------------------------------------------------------------
   balls against facets of this rank's elements; a ball is rigid, as rigid parts are
------------------------------------------------------------------------- */

void ContactFacets::pair_ball(int ball, int k)
{
  if (!sides[k].mine || tables->facets[k].k_area < 0.0) return;
  if (!ball_is_near(ball, sides[k].centre, sides[k].extent)) return;
  use(k);
  tables->balls.push_back({ball, k});
}

void ContactFacets::pair_balls()
{
  if (balls.empty()) return;
  const Particles &all = scene->particles;
  for (int ball : large_balls)
    for (int k = 0; k < count(); k++) pair_ball(ball, k);
  if (large_balls.size() < balls.size()) {
    struct Item {
      double x[3];
      int facet;
    };
    std::vector<Item> items;
    double largest = 0.0;
    for (int i : balls)
      if (!is_large(i)) largest = std::max(largest, all.radius[i]);
    for (int k = 0; k < count(); k++)
      items.push_back({{sides[k].centre[0], sides[k].centre[1], sides[k].centre[2]}, k});
    const CellList<Item> list(std::move(items), largest + faces->extent_max + scene->skin);
    for (int ball : balls)
      if (!is_large(ball))
        list.runs_around(all.at(ball), [&](int first, int last) {
          for (int c = first; c < last; c++) pair_ball(ball, list.all()[c].facet);
        });
  }
  // an order that does not depend on the order of particles or facets
  std::sort(tables->balls.begin(), tables->balls.end(), [&](const auto &a, const auto &b) {
    if (all.id[a.atom] != all.id[b.atom]) return all.id[a.atom] < all.id[b.atom];
    if (a.facet != b.facet) return by_identity(a.facet, b.facet);
    return a.atom < b.atom;
  });
}

void ContactFacets::keep_used()
{
  auto &t = *tables;
  auto &now = measured_at;
  now.assign(t.facets.size(), -1);
  int n = 0;
  for (std::size_t k = 0; k < t.facets.size(); k++) {
    if (!sides[k].used) continue;
    now[k] = n;
    t.facets[n] = t.facets[k];
    t.planes[n] = t.planes[k];
    n++;
  }
  t.facets.resize(n);
  t.planes.resize(n);
  for (int &k : t.candidates) k = now[k];
  for (auto &patch : t.patches) patch.facet = now[patch.facet];
  for (auto &pair : t.balls) pair.facet = now[pair.facet];
  measured = t.facets;
}

}    // namespace defe::search
