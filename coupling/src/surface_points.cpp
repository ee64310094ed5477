#include "surface_points.h"

#include "defe/simd.h"

#include <algorithm>
#include <climits>
#include <cmath>
#include <cstddef>

namespace defe::search {

void ContactPoints::run(const SurfaceScene &s, SurfaceFaces &fa, ContactFacets &f,
                        const KeptSearch &k, SurfaceTables &t)
{
  scene = &s;
  faces = &fa;
  facets = &f;
  kept = &k;
  tables = &t;
  skin = KeptSearch::skins * s.skin;
  keep_last();
  find_corners();
  find_points();
  choose_points();
  find_near(anew, nullptr, near_anew);
  find_near(rest, &kept->new_facets(), near_rest);
  merge();
  make_tables();
}

/* ----------------------------------------------------------------------
   what is kept of the last search
------------------------------------------------------------------------- */

void ContactPoints::keep_last()
{
  std::swap(points, points_before);
  std::swap(near, near_before);
  std::swap(first_near, first_near_before);
  points.clear();
  for (std::size_t n = 0; n < points_before.size(); n++) {
    const auto at = static_cast<std::size_t>(points_before[n].particle);
    if (at >= point_at.size()) point_at.resize(at + 1);
    point_at[at] = static_cast<int>(n);
  }
}

int ContactPoints::point_before(const Point &p) const
{
  if (p.particle >= static_cast<int>(point_at.size()) || !kept->still(p.particle)) return -1;
  const int n = point_at[p.particle];    // of any search, if it was none in the last one
  if (n >= static_cast<int>(points_before.size())) return -1;
  const Point &then = points_before[n];
  if (then.particle != p.particle || then.part != p.part || (then.de < 0) != (p.de < 0)) return -1;
  if (p.de >= 0) return then.r == p.r && then.aside == p.aside ? n : -1;
  for (int c = corners_from(p.particle); c < corners_to(p.particle); c++)
    if (kept->facet_before(corners[c]) < 0) return -1;
  return n;
}

void ContactPoints::choose_points()
{
  before.resize(points.size());
  anew.clear();
  rest.clear();
  for (std::size_t n = 0; n < points.size(); n++) {
    before[n] = point_before(points[n]);
    if (before[n] < 0)
      anew.push_back(static_cast<int>(n));
    else
      points[n].sharp = points_before[before[n]].sharp;
  }
  choose_of_rest();
}

/* ----------------------------------------------------------------------
   points that are kept, but may touch one of the facets that are new: by cells, in one of the directions that count
------------------------------------------------------------------------- */

void ContactPoints::choose_of_rest()
{
  if (kept->new_facets().empty() || anew.size() == points.size()) return;
  double farthest = 0.0;
  for (const auto &p : points) farthest = std::max(farthest, reach_of(p));
  struct Item {
    double x[3];
    unsigned directions;
  };
  std::vector<Item> items;
  double widest = 0.0;
  for (int k : kept->new_facets()) {
    const ContactFacets::Side &side = facets->side(k);
    items.push_back({{side.centre[0], side.centre[1], side.centre[2]}, side.directions});
    widest = std::max(widest, side.extent);
  }
  const CellList<Item> list(std::move(items), 1.5 * widest + farthest, 2);
  const auto around = list.bits_around([](const Item &item) {
    return item.directions;
  });
  for (std::size_t n = 0; n < points.size(); n++) {
    const double *x = scene->particles.at(points[n].particle);
    if (before[n] >= 0 && list.may_reach(x, 0.0) && (around[list.cell_of(x)] & points[n].against))
      rest.push_back(static_cast<int>(n));
  }
}

/* ----------------------------------------------------------------------
   the free facets of each node of this rank
------------------------------------------------------------------------- */

void ContactPoints::find_corners()
{
  const int nlocal = scene->particles.nlocal, count = faces->count_of_nodes();
  part_of.assign(count, INT_MAX);
  first_corner.assign(count + 1, 0);
  nodes.clear();
  const auto for_corners = [&](auto f) {
    for (int k = 0; k < facets->count(); k++)
      if (facets->side(k).outer)
        for (int i : tables->facets[k].node)
          if (i < nlocal) f(i, faces->number_of(i), k);
  };
  for_corners([&](int node, int n, int facet) {
    if (part_of[n] == INT_MAX) nodes.push_back(node);
    first_corner[n + 1]++;
    // that parts share: the first
    part_of[n] = std::min(part_of[n], tables->facets[facet].part);
  });
  std::sort(nodes.begin(), nodes.end());
  for (int n = 0; n < count; n++) first_corner[n + 1] += first_corner[n];
  corners.resize(first_corner[count]);
  std::vector<int> next(first_corner.begin(), first_corner.end() - 1);
  for_corners([&](int, int n, int facet) {
    corners[next[n]++] = facet;
  });
}

void ContactPoints::find_points()
{
  for (int i : nodes) {
    // a patch reaches beyond its node by at most its own size
    double own = 0.0;
    unsigned looks = 0;
    for (int c = corners_from(i); c < corners_to(i); c++) {
      own = std::max(own, facets->side(corners[c]).extent);
      looks |= facets->side(corners[c]).directions;
    }
    points.push_back({i, part_of[faces->number_of(i)], -1, 0.0, 1.1 * own, opposite(looks), -1, 0});
  }
  const SurfaceDEs &des = scene->des;
  for (int d = 0; d < des.count; d++) {
    const int i = des.particle[d];
    points.push_back({i, des.part[d], d, des.distance[i], 0.5 * std::sqrt(des.area[d]), ~0u, 0, 0});
  }
  // from the smallest on, so that those of one mesh are mostly of one class
  double least[2] = {HUGE_VAL, HUGE_VAL};
  for (const auto &p : points) least[p.de >= 0] = std::min(least[p.de >= 0], own_reach(p));
  for (auto &p : points) p.size = std::ilogb(own_reach(p) / least[p.de >= 0]);
}

/* ----------------------------------------------------------------------
   a node is joined to a facet of its part that shares a node with one of its own
------------------------------------------------------------------------- */

bool ContactPoints::joined(int node, const ContactFacet &facet) const
{
  const Ids &id = scene->particles.id;
  for (int c = corners_from(node); c < corners_to(node); c++)
    for (int mine : tables->facets[corners[c]].node)
      for (int other : facet.node)
        if (id[mine] == id[other]) return true;
  return false;
}

/* ----------------------------------------------------------------------
   one of the node's facets faces this one, or may do so before the next search
------------------------------------------------------------------------- */

bool ContactPoints::faces_it(int node, int facet, double least) const
{
  const Vec3 &n = tables->planes[facet].normal;
  for (int c = corners_from(node); c < corners_to(node); c++)
    if (-tables->planes[corners[c]].normal.dot(n) > least) return true;
  return false;
}

/* ----------------------------------------------------------------------
   beside an edge beyond which the surface goes on, a node counts up to half a patch away from it
------------------------------------------------------------------------- */

bool ContactPoints::goes_on(const Point &p, const double *x, int k, double far)
{
  facets->complete(k);
  const ContactFacet &f = tables->facets[k];
  const LocalPoint at = local_point(tables->planes[k], Vec3(x));
  const double way[4] = {1.0 - at.xi, 1.0 + at.xi, 1.0 - at.eta, 1.0 + at.eta};
  for (int e = 0; e < 4; e++)
    if (!f.rim[e] && -way[e] * (e < 2 ? f.half_xi : f.half_eta) > 0.5 * p.aside + 1.5 * far)
      return true;
  return false;
}

/* ----------------------------------------------------------------------
   facets in cells as large as their reach: a grid per class of sizes
------------------------------------------------------------------------- */

void ContactPoints::sort_facets()
{
  // what points add to a facet's own size: a few large ones must not make cells of all facets large
  struct SizeOfPoints {
    double most = 0.0;
    double lo[3] = {HUGE_VAL, HUGE_VAL, HUGE_VAL}, hi[3] = {-HUGE_VAL, -HUGE_VAL, -HUGE_VAL};
  };
  std::map<int, SizeOfPoints> sizes[2];
  for (int n : *sought) {
    const Point &p = points[n];
    SizeOfPoints &its = sizes[p.de >= 0][p.size];
    its.most = std::max(its.most, own_reach(p));
    const double *x = scene->particles.at(p.particle);
    for (int d = 0; d < 3; d++) {
      its.lo[d] = std::min(its.lo[d], x[d]);
      its.hi[d] = std::max(its.hi[d], x[d]);
    }
  }
  const double drift = 1.5 * skin, extent_max = facets->largest_extent();
  struct Sorted {
    double reach = 0.0;
    std::vector<Candidate> candidates;
  };
  for (int kind = 0; kind < 2; kind++)
    for (const auto &size : sizes[kind]) {
      const SizeOfPoints &its = size.second;
      std::map<std::pair<int, unsigned>, Sorted> classes;
      const int count = those ? static_cast<int>(those->size()) : facets->count();
      for (int one = 0; one < count; one++) {
        const int k = those ? (*those)[one] : one;
        const ContactFacets::Side &side = facets->side(k);
        // depths are below 0.5 extents
        const double mine = 1.5 * side.extent + its.most + drift;
        const double *at = side.centre;
        bool far = false;
        for (int d = 0; d < 3; d++)
          far = far || !(at[d] > its.lo[d] - mine && at[d] < its.hi[d] + mine);
        if (far) continue;
        const int of_facet = std::ilogb((1.5 * extent_max + its.most + drift) / mine);
        const Candidate candidate{
            {at[0], at[1], at[2]}, side.extent, tables->facets[k].part, k, side.directions};
        const auto add = [&](unsigned direction) {
          auto &c = classes[{of_facet, direction}];
          c.reach = std::max(c.reach, mine);
          c.candidates.push_back(candidate);
        };
        if (kind == 1)
          add(~0u);
        else
          for (unsigned bit = 1; bit <= side.directions; bit <<= 1)
            if (side.directions & bit) add(bit);
      }
      auto &sorted = lists[kind][size.first];
      for (auto &c : classes) {
        sorted.push_back(
            {List(std::move(c.second.candidates), c.second.reach, 2), c.first.second, {}});
        if (kind == 0)
          sorted.back().near_cell = sorted.back().list.bits_around([](const Candidate &) {
            return 1u;
          });
      }
    }
}

/* ----------------------------------------------------------------------
   of these facets those around each of these points, in the order of their IDs
------------------------------------------------------------------------- */

void ContactPoints::find_near(const std::vector<int> &which, const std::vector<int> *only,
                              Pairs &pairs)
{
  sought = &which;
  those = only;
  found = &pairs;
  pairs.clear();
  if (which.empty() || (only ? only->empty() : facets->count() == 0)) return;
  sort_facets();
  const int count = static_cast<int>(which.size());
  for (int n = 0; n < count;) {
    const int last = group_from(n);
    find_near_group(n, last);
    n = last;
  }
  for (auto &kind : lists) kind.clear();
}

/* ----------------------------------------------------------------------
   together with what holds of the last search
------------------------------------------------------------------------- */

void ContactPoints::merge()
{
  near.clear();
  first_near.assign(1, 0);
  const auto by_identity = [this](int a, int b) {
    return facets->by_identity(a, b);
  };
  std::size_t of_anew = 0, of_rest = 0;
  const auto take = [this](const Pairs &pairs, std::size_t &k, int n) {
    for (; k < pairs.size() && pairs[k].first == n; k++) near.push_back(pairs[k].second);
  };
  for (std::size_t n = 0; n < points.size(); n++) {
    const int then = before[n];
    if (then >= 0)
      for (int c = first_near_before[then]; c < first_near_before[then + 1]; c++) {
        const int k = kept->facet_now(near_before[c]);
        if (k >= 0) near.push_back(k);
      }
    const std::size_t middle = near.size();
    take(near_anew, of_anew, static_cast<int>(n));
    take(near_rest, of_rest, static_cast<int>(n));
    if (middle < near.size() && middle > static_cast<std::size_t>(first_near.back()))
      std::inplace_merge(near.begin() + first_near.back(), near.begin() + middle, near.end(),
                         by_identity);
    first_near.push_back(static_cast<int>(near.size()));
  }
}

/* ----------------------------------------------------------------------
   points that follow each other in the list and are close to each other, as neighbours in a mesh and the DEs of one
   element are, are searched for together; returns the index behind the last one
------------------------------------------------------------------------- */

int ContactPoints::group_from(int first)
{
  const double wide = 1.5 * facets->largest_extent();
  const bool nodes = point(first).de < 0;
  double lo[3], hi[3];
  group.radius = group.reach = 0.0;
  group.against = 0;
  int last = first;
  for (; last < static_cast<int>(sought->size()) && last < first + most; last++) {
    const Point &p = point(last);
    if ((p.de < 0) != nodes || p.size != point(first).size) break;
    const double *x = scene->particles.at(p.particle);
    double square = 0.0, low[3], high[3];
    for (int d = 0; d < 3; d++) {
      low[d] = last == first ? x[d] : std::min(lo[d], x[d]);
      high[d] = last == first ? x[d] : std::max(hi[d], x[d]);
      square += (high[d] - low[d]) * (high[d] - low[d]);
    }
    if (square > wide * wide) break;
    std::copy_n(low, 3, lo);
    std::copy_n(high, 3, hi);
    group.radius = 0.5 * std::sqrt(square);
    group.reach = std::max(group.reach, reach_of(p));
    group.against |= p.against;
  }
  for (int d = 0; d < 3; d++) group.x[d] = 0.5 * (lo[d] + hi[d]);
  return last;
}

double ContactPoints::own_reach(const Point &p) const
{
  return p.de < 0 ? 1.5 * p.aside : std::max(p.r, p.aside);    // nodes' patches reach much farther
}

double ContactPoints::reach_of(const Point &p) const
{
  return own_reach(p) + 1.5 * skin;
}

void ContactPoints::find_near_group(int first, int last)
{
  const int kind = point(first).de >= 0;
  around.clear();
  for (const Facing &facing : lists[kind].at(point(first).size)) {
    if (!(facing.direction & group.against)) continue;
    const List &list = facing.list;
    if (!list.may_reach(group.x, group.radius)) continue;
    if (kind == 0 && !any_near(facing, first, last)) continue;
    list.runs_around(
        group.x,
        [&](int begin, int end) {
          for (int c = begin; c < end; c++) {
            const Candidate &f = list.all()[c];
            // those aslant only once: by the first direction that counts
            const unsigned shared = f.directions & group.against;
            if (kind == 0 && (shared & (0u - shared)) != facing.direction) continue;
            const double cut = 1.5 * f.extent + group.reach + group.radius * (1.0 + 1e-9);
            if (dist_sq(group.x, f.x) <= cut * cut) around.push_back(f);
          }
        },
        group.radius);
  }
  if (around.empty()) return;
  fill_lanes(first, last);
  for (auto &left : of_lane) left.clear();
  for (std::size_t k = 0; k < around.size(); k++)
    for (unsigned lane = 0, left = within_reach(around[k]); left; lane++, left >>= 1)
      if (left & 1u) of_lane[lane].push_back(static_cast<int>(k));
  for (int n = first; n < last; n++) {
    const std::size_t before = found->size();
    for (int k : of_lane[n - first]) look_at(n, around[k]);
    if (found->size() > before + 1)
      std::sort(found->begin() + before, found->end(), [&](const auto &a, const auto &b) {
        return facets->by_identity(a.second, b.second);
      });
  }
}

void ContactPoints::fill_lanes(int first, int last)
{
  for (int l = 0; l < most; l++) {
    const Point &p = point(std::min(first + l, last - 1));
    const double *x = scene->particles.at(p.particle);
    for (int d = 0; d < 3; d++) lanes.x[d][l] = x[d];
    lanes.r[l] = p.de < 0 ? p.aside : p.r;
    lanes.aside[l] = p.aside;
    lanes.behind[l] = p.de < 0 ? p.aside : 0.0;
    lanes.reach[l] = first + l < last ? reach_of(p) : -HUGE_VAL;
  }
}

/* ----------------------------------------------------------------------
   for which of the lanes the facet is near enough (FacetPlane::out_of_reach): all of them at once, and with some room for
   rounding. Most are not
------------------------------------------------------------------------- */

unsigned ContactPoints::within_reach(const Candidate &f) const
{
  using simd::Mask;
  using simd::Pack;
  constexpr double room = 1.0 + 1e-9;
  static_assert(most % simd::width == 0);
  const FacetPlane &plane = tables->planes[f.facet];
  unsigned all = 0;
  for (int first = 0; first < most; first += simd::width) {
    const auto load = [first](const double *lane) {
      return simd::generate([&](int l) {
        return lane[first + l];
      });
    };
    const Pack x = load(lanes.x[0]), y = load(lanes.x[1]), z = load(lanes.x[2]);
    const Pack px = x - f.x[0], py = y - f.x[1], pz = z - f.x[2];
    const Pack cut = 1.5 * f.extent + load(lanes.reach);
    const Mask near = px * px + py * py + pz * pz <= cut * cut * room;
    const Mask there = cut > 0.0;
    if (!simd::any(near & there)) continue;
    const Pack dx = x - plane.mid[0], dy = y - plane.mid[1], dz = z - plane.mid[2];
    const auto along = [&](const Vec3 &v) {
      return dx * v[0] + dy * v[1] + dz * v[2];
    };
    const Pack height = along(plane.normal), xi = simd::abs(along(plane.to_xi)),
               eta = simd::abs(along(plane.to_eta));
    const Pack moved = 0.5 * skin * (2.0 + xi + eta);
    const Pack aside = (load(lanes.aside) + moved) * room;
    const Mask over = height <= (load(lanes.r) + moved) * room;
    const Mask below = -height <= (0.75 * f.extent + load(lanes.behind) + moved) * room;
    const Mask beside =
        ((xi - 1.0) * plane.half_xi() <= aside) & ((eta - 1.0) * plane.half_eta() <= aside);
    all |= simd::bits(near & there & over & below & beside) << first;
  }
  return all;
}

/* ----------------------------------------------------------------------
   the same of one point and one facet, without room for what is kept
------------------------------------------------------------------------- */

bool ContactPoints::is_near(const Point &p, int k)
{
  const double *x = scene->particles.at(p.particle);
  const ContactFacets::Side &side = facets->side(k);
  const FacetPlane &plane = tables->planes[k];
  const double cut = 1.5 * side.extent + own_reach(p) + 1.5 * scene->skin;
  if (dist_sq(x, side.centre) > cut * cut) return false;
  const LocalPoint at = local_point(plane, Vec3(x));
  const double xi = std::abs(at.xi), eta = std::abs(at.eta);
  const double moved = 0.5 * scene->skin * (2.0 + xi + eta);
  const double over = p.de < 0 ? p.aside : p.r, behind = p.de < 0 ? p.aside : 0.0;
  if (at.h > over + moved || -at.h > 0.75 * side.extent + behind + moved) return false;
  if ((xi - 1.0) * plane.half_xi() > p.aside + moved ||
      (eta - 1.0) * plane.half_eta() > p.aside + moved)
    return false;
  if (p.de < 0) return faces_it(p.particle, k, facing) && !goes_on(p, x, k, scene->skin);
  // a lasting tie: the facet need not be looked at until the next search
  const ContactFacet &facet = tables->facets[k];
  return !scene->ties->lasting(p.de, facet.part, facet.element);
}

bool ContactPoints::any_near(const Facing &facing, int first, int last) const
{
  for (int n = first; n < last; n++)
    if (facing.near_cell[facing.list.cell_of(scene->particles.at(point(n).particle))]) return true;
  return false;
}

inline void ContactPoints::look_at(int n, const Candidate &f)
{
  const Point &p = point(n);
  if (p.de < 0 && !(f.directions & p.against)) return;
  if (scene->parts[p.part].rigid && tables->facets[f.facet].k_area < 0.0) return;
  if (may_touch(p, f)) found->emplace_back((*sought)[n], f.facet);
}

bool ContactPoints::may_touch(const Point &p, const Candidate &f)
{
  const double *xp = scene->particles.at(p.particle);
  const ContactFacet &facet = tables->facets[f.facet];
  if (p.de >= 0) return true;
  if (!faces_it(p.particle, f.facet, KeptSearch::facing_kept) || goes_on(p, xp, f.facet, skin))
    return false;
  if (f.part == p.part) return !joined(p.particle, facet);
  return scene->tied_parts.empty() || !glued(p, facet);
}

/* ----------------------------------------------------------------------
   a node of a glued part that the facet, or one beside it, was under from the start
------------------------------------------------------------------------- */

bool ContactPoints::glued(const Point &p, const ContactFacet &facet) const
{
  const auto &tied = scene->tied_parts;
  if (std::none_of(tied.begin(), tied.end(), [&](const auto &t) {
        return (t.first == p.part && t.second == facet.part) ||
            (t.second == p.part && t.first == facet.part);
      }))
    return false;
  Vec3 centre = Vec3::Zero();
  for (int n : facet.node) centre += 0.25 * Vec3(scene->particles.reference(n));
  double extent = 0.0;
  for (int n : facet.node)
    extent = std::max(extent, (Vec3(scene->particles.reference(n)) - centre).norm());
  const double beside = 1.5 * (extent + p.aside);
  return (Vec3(scene->particles.reference(p.particle)) - centre).squaredNorm() < beside * beside;
}

/* ----------------------------------------------------------------------
   tables: a point for each part that a node or DE is near
------------------------------------------------------------------------- */

void ContactPoints::add_patches(const Point &p)
{
  own.clear();
  for (int c = corners_from(p.particle); c < corners_to(p.particle); c++)
    if (tables->facets[corners[c]].part == p.part) own.push_back(corners[c]);
  std::sort(own.begin(), own.end(), [this](int a, int b) {
    return facets->by_identity(a, b);
  });
  for (int facet : own) {
    facets->use(facet);
    const int *node = tables->facets[facet].node;
    tables->patches.push_back(
        {facet, static_cast<int>(std::find(node, node + 4, p.particle) - node)});
  }
}

double ContactPoints::radius_against(const Point &p, int part) const
{
  if (p.de < 0) return p.r;
  // against its own part a DE is a sphere: those of tall cells reach beyond it only outwards
  const double r = part == p.part ? std::min(p.r, scene->particles.radius[p.particle]) : p.r;
  // spheres of flat cells reach through the face that they were tied to from the start
  return std::min(r, scene->ties->tied_face(p.de, part));
}

bool ContactPoints::sharp(Point &p)
{
  if (p.sharp < 0) p.sharp = faces->sharp(p.particle);
  return p.sharp == 1;
}

void ContactPoints::make_tables()
{
  auto &t = *tables;
  for (std::size_t n = 0; n < points.size(); n++) {
    Point &p = points[n];
    met.clear();
    for (int k = first_near[n]; k < first_near[n + 1]; k++)
      if (is_near(p, near[k])) met.push_back(near[k]);
    if (met.empty()) continue;
    ContactPoint cp;
    cp.atom = p.particle;
    cp.own = static_cast<int>(t.patches.size());
    cp.area = 0.0;
    cp.half = p.aside;
    cp.k_own = -1.0;
    if (p.de >= 0) {
      cp.area = scene->des.area[p.de];
      cp.k_own =
          scene->factor * scene->parts[p.part].bulk * scene->des.length[p.particle] / cp.area;
    } else
      add_patches(p);
    cp.nown = static_cast<int>(t.patches.size()) - cp.own;
    cp.sharp = p.de < 0 && sharp(p);
    for (std::size_t k = 0; k < met.size();) {
      cp.part = t.facets[met[k]].part;
      cp.first = static_cast<int>(t.candidates.size());
      cp.r = radius_against(p, cp.part);
      for (; k < met.size() && t.facets[met[k]].part == cp.part; k++) {
        facets->use(met[k]);
        t.candidates.push_back(met[k]);
      }
      cp.count = static_cast<int>(t.candidates.size()) - cp.first;
      t.points.push_back(cp);
    }
  }
}

}    // namespace defe::search
