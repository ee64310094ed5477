/* ----------------------------------------------------------------------
   DEFE: adaptive finite elements to bonded discrete elements for LAMMPS
   https://www.lammps.org/
   This software is distributed under the GNU General Public License.

   Contact of surfaces: the search. The forces are in coupling (surface_forces.h).
   The rank that owns the node or DE treats it against the facets of all elements around, so
   each pair is treated once on any decomposition; facets of other ranks' elements come with
   the ghosts of their first nodes. Balls, spheres that are no DEs, are treated by the rank
   that owns the facet; their forces come back with the ghosts.
------------------------------------------------------------------------- */

#include "fix_defe.h"

#include "cells.h"

#include "atom.h"
#include "comm.h"
#include "domain.h"
#include "error.h"
#include "force.h"
#include "neighbor.h"
#include "update.h"

#include "defe/coupling/penalty.h"
#include "defe/coupling/surface_contact.h"
#include "defe/fe/hex8.h"

#include <algorithm>
#include <cmath>
#include <deque>
#include <map>
#include <tuple>
#include <unordered_map>
#include <utility>

using namespace LAMMPS_NS;
using defe::Vec3;
using defe::fe::HexCoords;

// A ball may begin this deep in a face, in radii: a rounding of the mesh or a ball that rests, not a mistake.
static constexpr double BALL_SHARE = 0.01;

// Two facets whose normals have no component above this against each other, on any axis, do not press
// on each other: facing_limit / 3 less what normals may turn until the next search.
static constexpr double OPPOSED = 0.04;

// a node's facet looks against another one from here on: facing_limit less what normals may turn
static constexpr double LOOKS = defe::facing_limit - 0.15;

// A bit for each direction along an axis, +x, -x, +y, ..., in which a normal has a component. Two normals
// with n.m < -LOOKS have components of opposite sign above LOOKS / 3 on some axis.
static unsigned directions(const double *normal)
{
  unsigned bits = 0;
  for (int d = 0; d < 3; d++) {
    if (normal[d] > 0.3 * LOOKS) bits |= 1u << (2 * d);
    if (normal[d] < -0.3 * LOOKS) bits |= 2u << (2 * d);
  }
  return bits;
}
static unsigned opposite(unsigned bits)
{
  return ((bits & 21u) << 1) | ((bits >> 1) & 21u);
}

// faces at an edge that form an angle of more than 30 degrees: a rim
static constexpr double RIM_COSINE = 0.866;

// overlaps from before the first step are eased out within this many stable steps of the elements
static constexpr double EASE_STEPS = 2000.0;

static double dist_sq(const double *a, const double *b)
{
  const double x = a[0] - b[0], y = a[1] - b[1], z = a[2] - b[2];
  return x * x + y * y + z * z;
}

namespace LAMMPS_NS {

/** Finds facets near points, who may touch what; once per reneighbouring. Keeps its memory: new pages
    would cost more than the search. */
class DefeSurfaceSearch {
 public:
  explicit DefeSurfaceSearch(FixDefe *host) :
      fix(*host), atom(host->atom), domain(host->domain), table(host->surface)
  {
  }
  void run();

 private:
  FixDefe &fix;
  Atom *atom;
  Domain *domain;
  defe::SurfaceTables &table;
  double **x = nullptr;
  int nlocal = 0;
  double skin = 0.0;
  void begin();

  struct Exposed {
    const HexPod *hex;
    const int *idx;
  };
  std::vector<Exposed> around;    // elements with a free face: mine, and those of the ranks around
  std::deque<std::array<int, 8>> ghost_idx;

  struct Face {
    int hex, face;    // index into around, local number
    int node[4];
    double centre[3], normal[3];
    double extent;    // squared distance of its farthest node
    size_t cell;
  };
  std::vector<Face> all_faces;
  double extent_max = 0.0;
  std::vector<int> balls, large_balls;    // owned and ghost

  // of each entry of table.facets
  struct Side {
    double centre[3], extent;
    int hex, face;    // face: index into all_faces
    bool outer, mine, complete, used;
    unsigned directions;    // of its normal
  };
  std::vector<Side> sides;

  struct Point {
    int atom, part;
    double r, aside;     // how far beside a facet it still counts
    unsigned against;    // directions of normals that it may press on
  };
  std::vector<Point> points;
  std::vector<int> part_of;                  // of owned nodes on outer faces
  std::vector<int> first_corner, corners;    // outer facets of each owned node
  std::vector<std::pair<int, int>> near;     // indices of point and facet

  void gather_elements();
  void gather_ghost_elements();
  void make_faces();
  void choose_facets();
  void add_facet(const Face &);
  void complete(int facet);
  void use(int facet)
  {
    complete(facet);
    sides[facet].used = true;
  }
  std::vector<int> first_face, faces_at;    // all faces at each atom
  void list_faces_of_atoms();
  std::vector<Vec3> normals;    // of all faces in the reference configuration
  std::vector<char> normal_known;
  const Vec3 &reference_normal(int face);
  void find_rims(int facet);
  std::vector<char> sharp_node;    // of owned nodes: 0 no, 1 yes, 2 not looked at
  bool sharp(int node);
  bool ball_is_near(int ball, const double *centre, double extent) const;
  void pair_balls();
  void find_corners();
  void find_points();
  void find_near();
  bool by_identity(int a, int b) const;
  bool joined(int node, const defe::ContactFacet &) const;
  bool faces(int node, int facet) const;
  bool goes_on(const Point &, const double *xp, int facet);
  void make_points();
  void keep_used();
};

}    // namespace LAMMPS_NS

/* ---------------------------------------------------------------------- */

void FixDefe::build_surfaces()
{
  surface.clear();
  facet_nodes.clear();
  surface_at.clear();
  fresh.clear();
  for (int i : jt.self)
    if (i < atom->nlocal && touch[i] && touch[i]->fresh) fresh.push_back(i);
  if (!(contact_factor > 0.0)) return;
  if (!surface_search) surface_search = std::make_shared<DefeSurfaceSearch>(this);
  surface_search->run();
}

void DefeSurfaceSearch::begin()
{
  x = atom->x;
  nlocal = atom->nlocal;
  skin = fix.neighbor->skin;
  around.clear();
  ghost_idx.clear();
  all_faces.clear();
  extent_max = 0.0;
  balls.clear();
  large_balls.clear();
  sides.clear();
  points.clear();
  near.clear();
  sharp_node.assign(nlocal, 2);
}

void DefeSurfaceSearch::run()
{
  begin();
  gather_elements();
  make_faces();
  list_faces_of_atoms();
  choose_facets();
  fix.pack_facet_nodes();
  fix.update_planes();
  fix.planes_fresh = true;
  pair_balls();
  find_corners();
  find_points();
  if (!table.facets.empty() && !points.empty()) {
    find_near();
    make_points();
  }
  keep_used();
}

/* ---------------------------------------------------------------------- */

void DefeSurfaceSearch::gather_elements()
{
  const bool ghosts = fix.comm->nprocs > 1 || domain->xperiodic || domain->yperiodic ||
      domain->zperiodic;
  around.reserve(fix.exposed.size());
  for (const auto &e : fix.exposed) {
    const auto &b = fix.batches[e.first];
    around.push_back({b.hex[e.second], b.node[e.second].data()});
    if (ghosts) fix.surface_at[b.node[e.second][0]].push_back(*b.hex[e.second]);
  }
  if (ghosts) gather_ghost_elements();
}

void DefeSurfaceSearch::gather_ghost_elements()
{
  fix.comm_mode = FixDefe::SURFACE;
  for (fix.comm_round = 0; fix.comm_round < fix.hexes_per_node; fix.comm_round++)
    fix.comm->forward_comm(&fix, FixDefe::SURFACE_SIZE);
  std::vector<int> anchors;
  for (const auto &s : fix.surface_at)
    if (s.first >= nlocal) anchors.push_back(s.first);
  std::sort(anchors.begin(), anchors.end());
  double **xframe = fix.xframe;
  for (int anchor : anchors)
    for (const auto &h : fix.surface_at[anchor]) {
      std::array<int, 8> idx;
      idx[0] = anchor;
      bool complete = true;
      for (int a = 1; a < 8 && complete; a++) {
        const int j = fix.local_of(h.node[a]);
        complete = j >= 0;
        if (!complete) continue;
        // beside a ghost anchor the right image of a node may be missing: then this is another one
        idx[a] = domain->closest_image(anchor, j);
        complete =
            dist_sq(xframe[idx[a]], xframe[anchor]) < 1.01 * fix.max_diagonal * fix.max_diagonal;
      }
      // otherwise it is farther away than anything of mine can touch
      if (!complete) continue;
      ghost_idx.push_back(idx);
      around.push_back({&h, ghost_idx.back().data()});
    }
}

/* ----------------------------------------------------------------------
   their faces, as they are now
------------------------------------------------------------------------- */

void DefeSurfaceSearch::make_faces()
{
  all_faces.reserve(2 * around.size());
  const double *coords = around.empty() ? nullptr : &x[0][0];
  for (size_t e = 0; e < around.size(); e++)
    for (int f = 0; f < 6; f++) {
      if (around[e].hex->nb[f] > 0) continue;
      all_faces.emplace_back();
      Face &face = all_faces.back();
      const double *p[4];
      for (int a = 0; a < 4; a++) {
        face.node[a] = around[e].idx[defe::fe::hex_face[f][a]];
        p[a] = coords + 3 * static_cast<std::ptrdiff_t>(face.node[a]);
      }
      face.hex = static_cast<int>(e);
      face.face = f;
      face.extent = 0.0;
      double d1[3], d2[3];
      for (int d = 0; d < 3; d++) {
        face.centre[d] = 0.25 * (p[0][d] + p[1][d] + p[2][d] + p[3][d]);
        d1[d] = p[2][d] - p[0][d];
        d2[d] = p[3][d] - p[1][d];
      }
      double length = 0.0;
      for (int d = 0; d < 3; d++) {
        face.normal[d] = d1[(d + 1) % 3] * d2[(d + 2) % 3] - d1[(d + 2) % 3] * d2[(d + 1) % 3];
        length += face.normal[d] * face.normal[d];
      }
      length = std::sqrt(length);
      for (double &n : face.normal) n /= length;
      for (const double *q : p) face.extent = std::max(face.extent, dist_sq(q, face.centre));
      extent_max = std::max(extent_max, face.extent);
    }
  extent_max = std::sqrt(extent_max);
}

/* ----------------------------------------------------------------------
   facets that can meet anything: in a grid, those with another part, a DE, a ball, or a face of
   their own part that looks against them, within the range in which two facets can touch
------------------------------------------------------------------------- */

void DefeSurfaceSearch::choose_facets()
{
  const auto &jt = fix.jt;
  double rmax = 0.0;
  Cells space;
  for (const auto &face : all_faces) space.add(face.centre);
  for (int d = 0; d < jt.nde; d++) {
    rmax = std::max(rmax, fix.outer_reach[jt.self[d]]);
    space.add(x[jt.self[d]]);
  }
  for (int i = 0; i < nlocal + atom->nghost; i++) {
    if (!fix.is_ball(i)) continue;
    balls.push_back(i);
    space.add(x[i]);
    if (atom->radius[i] > fix.max_diagonal)
      large_balls.push_back(i);
    else
      rmax = std::max(rmax, atom->radius[i]);
  }
  // from the middle of a facet to a point that it touches, and to the middle of that one's facet
  const double range = std::max(2.5 * extent_max, 2.0 * extent_max + 2.0 * rmax) + 1.5 * skin;

  // a bit for each part; parts beyond the last bit, DEs and balls are always several
  constexpr unsigned SEVERAL = 3u << 30;
  const auto bit = [](int part) {
    return part < 30 ? 1u << part : SEVERAL;
  };
  space.divide(0.5 * range);
  std::vector<unsigned> who(space.count(), 0), where(space.count(), 0);
  for (auto &face : all_faces) {
    face.cell = space.of(face.centre);
    who[face.cell] |= bit(around[face.hex].hex->part);
    for (int d = 0; d < 3; d++) {
      if (face.normal[d] > OPPOSED) where[face.cell] |= 1u << (2 * d);
      if (face.normal[d] < -OPPOSED) where[face.cell] |= 2u << (2 * d);
    }
  }
  for (int d = 0; d < jt.nde; d++) who[space.of(x[jt.self[d]])] |= SEVERAL;
  for (int i : balls) who[space.of(x[i])] |= SEVERAL;
  space.spread(who, 2);
  space.spread(where, 2);

  for (const auto &face : all_faces) {
    const unsigned there = who[face.cell], axes = where[face.cell];
    if ((there & (there - 1)) == 0 && (axes & (axes >> 1) & 21u) == 0) {
      bool hit = false;
      for (int i : large_balls) hit = hit || ball_is_near(i, face.centre, extent_max);
      if (!hit) continue;
    }
    add_facet(face);
  }
}

void DefeSurfaceSearch::add_facet(const Face &face)
{
  const HexPod &h = *around[face.hex].hex;
  defe::ContactFacet facet;
  facet.element = h.id;
  facet.part = h.part;
  for (int k = 0; k < 4; k++) facet.node[k] = face.node[k];
  facet.k_area = fix.material_of(fix.parts[h.part]).rigid() ? -1.0 : 0.0;
  facet.area = facet.half_xi = facet.half_eta = facet.depth_max = 0.0;    // see complete()
  for (bool &rim : facet.rim) rim = true;
  facet.outer = (h.nb[face.face] == 0);
  table.facets.push_back(facet);
  Side side;
  for (int d = 0; d < 3; d++) side.centre[d] = face.centre[d];
  side.extent = std::sqrt(face.extent);
  side.hex = face.hex;
  side.face = static_cast<int>(&face - all_faces.data());
  side.outer = facet.outer;
  side.mine = (around[face.hex].idx[0] < nlocal);
  side.complete = side.used = false;
  side.directions = directions(face.normal);
  sides.push_back(side);
}

/* ----------------------------------------------------------------------
   reference geometry and stiffness, only of facets that are near something
------------------------------------------------------------------------- */

void DefeSurfaceSearch::complete(int k)
{
  if (sides[k].complete) return;
  sides[k].complete = true;
  defe::ContactFacet &f = table.facets[k];
  Vec3 P[4];
  for (int a = 0; a < 4; a++) P[a] = Vec3(fix.xframe[f.node[a]]);
  f.area = defe::fe::face_area(P);
  const Vec3 a = 0.25 * (P[1] + P[2] - P[0] - P[3]), b = 0.25 * (P[2] + P[3] - P[0] - P[1]);
  const double cross = a.cross(b).norm();
  f.half_xi = cross / b.norm();
  f.half_eta = cross / a.norm();
  const double volume = around[sides[k].hex].hex->volume;
  find_rims(k);
  // half of the element, so that a point is not nearer to its far side
  f.depth_max = 0.5 * std::min(volume / f.area, std::sqrt(f.area));
  if (f.k_area < 0.0) return;
  const double bulk = fix.material_of(fix.parts[f.part]).elastic().bulk();
  f.k_area = defe::penalty_stiffness_per_area(fix.contact_factor, bulk, f.area, volume);
}

/* ----------------------------------------------------------------------
   where a surface ends or bends sharply, in the reference configuration: such edges are rims
------------------------------------------------------------------------- */

void DefeSurfaceSearch::list_faces_of_atoms()
{
  const int nall = nlocal + atom->nghost;
  first_face.assign(nall + 1, 0);
  for (const auto &face : all_faces)
    for (int node : face.node) first_face[node + 1]++;
  for (int i = 0; i < nall; i++) first_face[i + 1] += first_face[i];
  faces_at.resize(first_face[nall]);
  std::vector<int> next(first_face.begin(), first_face.end() - 1);
  for (size_t f = 0; f < all_faces.size(); f++)
    for (int node : all_faces[f].node) faces_at[next[node]++] = static_cast<int>(f);
  normals.resize(all_faces.size());
  normal_known.assign(all_faces.size(), 0);
}

const Vec3 &DefeSurfaceSearch::reference_normal(int face)
{
  Vec3 &n = normals[face];
  if (normal_known[face]) return n;
  normal_known[face] = 1;
  const int *node = all_faces[face].node;
  double **X = fix.xframe;
  n = (Vec3(X[node[2]]) - Vec3(X[node[0]])).cross(Vec3(X[node[3]]) - Vec3(X[node[1]])).normalized();
  return n;
}

void DefeSurfaceSearch::find_rims(int k)
{
  defe::ContactFacet &f = table.facets[k];
  const int face = sides[k].face;
  const Vec3 &n = reference_normal(face);
  static constexpr int edge_at[4] = {1, 3, 2, 0};    // xi = 1: nodes 1 and 2, ...
  for (int e = 0; e < 4; e++) {
    const int a = f.node[edge_at[e]], b = f.node[(edge_at[e] + 1) % 4];
    f.rim[e] = true;
    for (int c = first_face[a]; c < first_face[a + 1] && f.rim[e]; c++) {
      const int other = faces_at[c];
      if (other == face) continue;
      const int *node = all_faces[other].node;
      if (node[0] != b && node[1] != b && node[2] != b && node[3] != b) continue;
      if (reference_normal(other).dot(n) > RIM_COSINE) f.rim[e] = false;
    }
  }
}

// the faces of its part at the node do not lie in one plane, or the surface ends there
bool DefeSurfaceSearch::sharp(int i)
{
  char &known = sharp_node[i];
  if (known != 2) return known == 1;
  known = 0;
  for (int c = first_face[i]; c < first_face[i + 1] && !known; c++)
    for (int d = first_face[i]; d < c && !known; d++)
      if (reference_normal(faces_at[c]).dot(reference_normal(faces_at[d])) <= RIM_COSINE) known = 1;
  return known == 1;
}

/* ----------------------------------------------------------------------
   balls against facets of this rank; a ball is rigid, too
------------------------------------------------------------------------- */

bool DefeSurfaceSearch::ball_is_near(int ball, const double *centre, double extent) const
{
  const double far = atom->radius[ball] + extent + skin;
  return dist_sq(x[ball], centre) < far * far;
}

void DefeSurfaceSearch::pair_balls()
{
  if (balls.empty()) return;
  const auto consider = [this](int ball, int k) {
    if (!sides[k].mine || table.facets[k].k_area < 0.0) return;
    if (!ball_is_near(ball, sides[k].centre, sides[k].extent)) return;
    use(k);
    table.balls.push_back({ball, k});
  };
  for (int ball : large_balls)
    for (size_t k = 0; k < sides.size(); k++) consider(ball, static_cast<int>(k));
  if (large_balls.size() < balls.size()) {
    struct Item {
      double x[3];
      int facet;
    };
    std::vector<Item> items;
    double largest = 0.0;
    for (int i : balls)
      if (atom->radius[i] <= fix.max_diagonal) largest = std::max(largest, atom->radius[i]);
    for (size_t k = 0; k < sides.size(); k++)
      items.push_back(
          {{sides[k].centre[0], sides[k].centre[1], sides[k].centre[2]}, static_cast<int>(k)});
    const CellList<Item> list(std::move(items), largest + extent_max + skin);
    for (int ball : balls)
      if (atom->radius[ball] <= fix.max_diagonal)
        list.runs_around(x[ball], [&](int first, int last) {
          for (int c = first; c < last; c++) consider(ball, list.all()[c].facet);
        });
  }
  // an order that no list of atoms or facets has made
  std::sort(table.balls.begin(), table.balls.end(), [this](const auto &a, const auto &b) {
    if (atom->tag[a.atom] != atom->tag[b.atom]) return atom->tag[a.atom] < atom->tag[b.atom];
    if (a.facet != b.facet) return by_identity(a.facet, b.facet);
    return a.atom < b.atom;
  });
}

/* ----------------------------------------------------------------------
   the outer facets of each node of this rank
------------------------------------------------------------------------- */

void DefeSurfaceSearch::find_corners()
{
  part_of.assign(nlocal, MAXSMALLINT);
  first_corner.assign(nlocal + 1, 0);
  const auto for_corners = [&](auto f) {
    for (size_t k = 0; k < sides.size(); k++)
      if (sides[k].outer)
        for (int i : table.facets[k].node)
          if (i < nlocal) f(i, static_cast<int>(k));
  };
  for_corners([&](int node, int facet) {
    first_corner[node + 1]++;
    part_of[node] = MIN(part_of[node], table.facets[facet].part);    // that parts share: the first
  });
  for (int i = 0; i < nlocal; i++) first_corner[i + 1] += first_corner[i];
  corners.resize(first_corner[nlocal]);
  std::vector<int> next(first_corner.begin(), first_corner.end() - 1);
  for_corners([&](int node, int facet) {
    corners[next[node]++] = facet;
  });
}

/* ----------------------------------------------------------------------
   points: my nodes on outer faces, my DEs
------------------------------------------------------------------------- */

void DefeSurfaceSearch::find_points()
{
  for (int i = 0; i < nlocal; i++) {
    if (part_of[i] == MAXSMALLINT) continue;
    // a patch reaches beyond its node's place by its own size at the most
    double own = 0.0;
    unsigned looks = 0;
    for (int c = first_corner[i]; c < first_corner[i + 1]; c++) {
      own = std::max(own, sides[corners[c]].extent);
      looks |= sides[corners[c]].directions;
    }
    points.push_back({i, part_of[i], 0.0, 1.1 * own, opposite(looks)});
  }
  const auto &jt = fix.jt;
  for (int d = 0; d < jt.nde; d++) {
    const int i = jt.self[d];
    points.push_back(
        {i, jt.rec[d]->part, fix.outer_reach[i], 0.5 * std::sqrt(jt.rec[d]->outer_area), ~0u});
  }
}

// an order that no list of atoms or facets has made
bool DefeSurfaceSearch::by_identity(int a, int b) const
{
  const auto &fa = table.facets[a], &fb = table.facets[b];
  if (fa.part != fb.part) return fa.part < fb.part;
  if (fa.element != fb.element) return fa.element < fb.element;
  return a < b;    // faces of one element are in order
}

/* ----------------------------------------------------------------------
   a node is joined to a facet of its part that shares a node with one of its own
------------------------------------------------------------------------- */

bool DefeSurfaceSearch::joined(int node, const defe::ContactFacet &facet) const
{
  const tagint *tag = atom->tag;
  for (int c = first_corner[node]; c < first_corner[node + 1]; c++)
    for (int mine : table.facets[corners[c]].node)
      for (int other : facet.node)
        if (tag[mine] == tag[other]) return true;
  return false;
}

/* ----------------------------------------------------------------------
   one of the node's facets looks against this one, or may do so before the next search
------------------------------------------------------------------------- */

bool DefeSurfaceSearch::faces(int node, int facet) const
{
  const Vec3 &n = table.planes[facet].normal;
  for (int c = first_corner[node]; c < first_corner[node + 1]; c++)
    if (-table.planes[corners[c]].normal.dot(n) > LOOKS) return true;
  return false;
}

/* ----------------------------------------------------------------------
   a node beside an edge beyond which the surface goes on counts no farther than half a patch
------------------------------------------------------------------------- */

bool DefeSurfaceSearch::goes_on(const Point &p, const double *xp, int k)
{
  complete(k);
  const defe::ContactFacet &f = table.facets[k];
  const defe::LocalPoint at = defe::local_point(table.planes[k], Vec3(xp));
  const double way[4] = {1.0 - at.xi, 1.0 + at.xi, 1.0 - at.eta, 1.0 + at.eta};
  for (int e = 0; e < 4; e++)
    if (!f.rim[e] && -way[e] * (e < 2 ? f.half_xi : f.half_eta) > 0.5 * p.aside + 1.5 * skin)
      return true;
  return false;
}

/* ----------------------------------------------------------------------
   facets around each point, in cells as large as their reach: a grid per class of sizes
------------------------------------------------------------------------- */

void DefeSurfaceSearch::find_near()
{
  struct Candidate {
    double x[3];
    double extent;
    int part, facet;
    unsigned directions;
  };
  struct SizeClass {
    double reach = 0.0;
    std::vector<Candidate> candidates;
  };
  // of what a node and a DE add to a facet's own size: nodes' patches reach much farther
  double most[2] = {0.0, 0.0};
  for (const auto &p : points) {
    double &its = most[p.r > 0.0];
    its = std::max(its, p.r > 0.0 ? std::max(p.r, p.aside) : 1.5 * p.aside);
  }
  const double drift = 1.5 * skin;
  std::vector<CellList<Candidate>> lists[2];
  std::vector<std::vector<unsigned>>
      there;    // directions of the facets around each cell, for nodes
  for (int kind = 0; kind < 2; kind++) {
    if (most[kind] == 0.0) continue;    // none
    std::map<int, SizeClass> classes;
    for (size_t k = 0; k < sides.size(); k++) {
      // depths are below 0.5 extents
      const double mine = 1.5 * sides[k].extent + most[kind] + drift;
      auto &c = classes[std::ilogb((1.5 * extent_max + most[kind] + drift) / mine)];
      c.reach = std::max(c.reach, mine);
      const double *at = sides[k].centre;
      c.candidates.push_back({{at[0], at[1], at[2]},
                              sides[k].extent,
                              table.facets[k].part,
                              static_cast<int>(k),
                              sides[k].directions});
    }
    for (auto &c : classes) {
      lists[kind].emplace_back(std::move(c.second.candidates), c.second.reach, 2);
      if (kind == 0)
        there.push_back(lists[kind].back().bits_around([](const Candidate &f) {
          return f.directions;
        }));
    }
  }

  const bool born_loose =
      fix.force->pair_match("defe/contact", 1) != nullptr;    // ties hold nothing
  for (size_t n = 0; n < points.size(); n++) {
    const Point &p = points[n];
    const double *xp = x[p.atom];
    const bool is_node = p.r == 0.0;
    const bool rigid = fix.material_of(fix.parts[p.part]).rigid();
    const size_t before = near.size();
    for (size_t l = 0; l < lists[!is_node].size(); l++) {
      const auto &list = lists[!is_node][l];
      if (is_node && !(there[l][list.cell_of(xp)] & p.against)) continue;
      list.runs_around(xp, [&](int first, int last) {
        for (int c = first; c < last; c++) {
          const Candidate &f = list.all()[c];
          if (is_node && !(f.directions & p.against)) continue;
          const double cut =
              1.5 * f.extent + (is_node ? 1.5 * p.aside : std::max(p.r, p.aside)) + drift;
          if (dist_sq(xp, f.x) > cut * cut) continue;
          const defe::ContactFacet &facet = table.facets[f.facet];
          if (facet.k_area < 0.0 && rigid) continue;
          const double behind = 0.75 * f.extent + (is_node ? p.aside : 0.0);
          if (table.planes[f.facet].out_of_reach(Vec3(xp), is_node ? p.aside : p.r, behind, p.aside,
                                                 skin))
            continue;
          if (is_node) {
            if (!faces(p.atom, f.facet) || goes_on(p, xp, f.facet)) continue;
            if (f.part == p.part && joined(p.atom, facet)) continue;
          } else if (!born_loose && !fix.adhesive_of(p.part, f.part) &&
                     fix.tied(p.atom, facet.element))
            continue;    // that tie cannot end: the facet need not be looked at again
          near.emplace_back(static_cast<int>(n), f.facet);
        }
      });
    }
    if (near.size() > before + 1)
      std::sort(near.begin() + before, near.end(), [&](const auto &a, const auto &b) {
        return by_identity(a.second, b.second);
      });
  }
}

/* ----------------------------------------------------------------------
   pairs of a point with each part
------------------------------------------------------------------------- */

void DefeSurfaceSearch::make_points()
{
  const auto &jt = fix.jt;
  for (size_t k = 0; k < near.size();) {
    const int n = near[k].first;
    const Point &p = points[n];
    defe::ContactPoint cp;
    cp.atom = p.atom;
    cp.own = static_cast<int>(table.patches.size());
    cp.area = 0.0;
    cp.half = p.aside;
    cp.k_own = -1.0;
    const DERecord *record = nullptr;
    if (p.r > 0.0) {
      record = jt.rec[jt.of_atom[p.atom]];
      cp.area = record->outer_area;
      cp.k_own = fix.ball_stiffness(p.part, p.atom) / cp.area;
    } else {
      std::vector<int> own;
      for (int c = first_corner[p.atom]; c < first_corner[p.atom + 1]; c++)
        if (table.facets[corners[c]].part == p.part) own.push_back(corners[c]);
      std::sort(own.begin(), own.end(), [this](int a, int b) {
        return by_identity(a, b);
      });
      for (int facet : own) {
        use(facet);
        const int *node = table.facets[facet].node;
        table.patches.push_back(
            {facet, static_cast<int>(std::find(node, node + 4, p.atom) - node)});
      }
    }
    cp.nown = static_cast<int>(table.patches.size()) - cp.own;
    cp.sharp = !record && sharp(p.atom);
    while (k < near.size() && near[k].first == n) {
      cp.part = table.facets[near[k].second].part;
      cp.first = static_cast<int>(table.candidates.size());
      // against its own part a DE is a sphere: those of tall cells reach beyond it only outwards
      cp.r = cp.part == p.part ? std::min(p.r, atom->radius[p.atom]) : p.r;
      // spheres of flat cells reach through the face that they were tied to from the start
      if (record)
        for (const auto &slot : record->slot)
          if (slot.kind == DefeJoint::TIE && slot.part == cp.part)
            cp.r = std::min(cp.r, Vec3(slot.face).dot(Vec3(slot.normal)));
      for (; k < near.size() && near[k].first == n && table.facets[near[k].second].part == cp.part;
           k++) {
        use(near[k].second);
        table.candidates.push_back(near[k].second);
      }
      cp.count = static_cast<int>(table.candidates.size()) - cp.first;
      table.points.push_back(cp);
    }
  }
}

/* ----------------------------------------------------------------------
   only the facets of contacts are looked at in each step
------------------------------------------------------------------------- */

void DefeSurfaceSearch::keep_used()
{
  std::vector<int> now(table.facets.size(), -1);
  int n = 0;
  for (size_t k = 0; k < table.facets.size(); k++) {
    if (!sides[k].used) continue;
    now[k] = n;
    table.facets[n] = table.facets[k];
    table.planes[n] = table.planes[k];
    n++;
  }
  table.facets.resize(n);
  table.planes.resize(n);
  for (int &k : table.candidates) k = now[k];
  for (auto &patch : table.patches) patch.facet = now[patch.facet];
  for (auto &pair : table.balls) pair.facet = now[pair.facet];
  fix.pack_facet_nodes();
}

/* ----------------------------------------------------------------------
   the facets at the positions now
------------------------------------------------------------------------- */

void FixDefe::pack_facet_nodes()
{
  facet_nodes.clear();
  for (const auto &f : surface.facets)
    facet_nodes.push_back({f.node[0], f.node[1], f.node[2], f.node[3]});
}

void FixDefe::update_planes()
{
  const int n = static_cast<int>(surface.facets.size());
  surface.planes.resize(n);
  if (n)
    defe::facet_planes(n, reinterpret_cast<const int(*)[4]>(facet_nodes.data()), &atom->x[0][0],
                       surface.planes.data());
}

/* ---------------------------------------------------------------------- */

bool FixDefe::is_ball(int i) const
{
  return atom->radius[i] > 0.0 && outer_reach[i] == 0.0;
}

double FixDefe::reach_of(int i) const
{
  return outer_reach[i] > 0.0 ? outer_reach[i] : atom->radius[i];
}

double FixDefe::ball_stiffness(int part, int i) const
{
  return contact_factor * material_of(parts[part]).elastic().bulk() * outer_length[i];
}

/* ----------------------------------------------------------------------
   a DE has no contact with an element that it is tied to
------------------------------------------------------------------------- */

bool FixDefe::tied(int i, tagint element) const
{
  const int d = jt.of_atom[i];
  for (int s = 0; s < 6; s++)
    if (jt.nb[d][s] < 0 && jt.tie_element[~jt.nb[d][s]] == element &&
        jt.state[6 * d + s] != DefeJoint::CONTACT)
      return true;
  return false;
}

/* ----------------------------------------------------------------------
   contacts of an atom from step to step
------------------------------------------------------------------------- */

namespace LAMMPS_NS {
class DefeContactMemory : public defe::ContactMemory {
 public:
  explicit DefeContactMemory(FixDefe *host) : fix(*host) {}
  defe::ContactHistory *find(int i, int part) override
  {
    AtomTouch *t = fix.touches(i);
    if (t)
      for (auto &face : t->faces)
        if (face.part == part) return &face;
    return nullptr;
  }
  defe::ContactHistory &make(int i, int part) override
  {
    auto &list = fix.touch_at(i).faces;
    list.emplace_back();
    list.back().part = part;
    return list.back();
  }
  void drop(int i, int part) override
  {
    auto &list = fix.touch_at(i).faces;
    for (auto &face : list)
      if (face.part == part) {
        face = list.back();
        list.pop_back();
        return;
      }
  }
  bool tied(int i, std::int64_t element) override
  {
    return fix.tied(i, static_cast<tagint>(element));
  }
  bool inherits(int i, int part) override
  {
    // a DE that was an element with this contact a step ago
    const AtomTouch *t = fix.touches(i);
    if (t && t->fresh && fix.de_record(i) && fix.de_record(i)->part != part) return true;
    // a tie that broke by shear while it was pressed
    for (int ds : fix.jt.debonded)
      if (fix.jt.self[ds / 6] == i && fix.jt.rec[ds / 6]->slot[ds % 6].part == part) return true;
    return false;
  }

 private:
  FixDefe &fix;
};
}    // namespace LAMMPS_NS

defe::SurfaceArrays FixDefe::surface_arrays() const
{
  defe::SurfaceArrays a;
  const bool any = atom->nlocal + atom->nghost > 0;
  a.x = any ? &atom->x[0][0] : nullptr;
  a.v = any ? &atom->v[0][0] : nullptr;
  a.f = any ? &atom->f[0][0] : nullptr;
  a.omega = any ? &atom->omega[0][0] : nullptr;
  a.torque = any ? &atom->torque[0][0] : nullptr;
  a.radius = atom->radius;
  a.mass = atom->rmass;
  a.dt = update->dt;
  a.friction = contact_friction;
  a.moving = !update->setupflag && update->whichflag != 2;
  a.minimizing = !update->setupflag && update->whichflag == 2;
  a.virial = vflag_global;
  a.force_grid = force_grid;
  a.torque_grid = torque_grid;
  a.ease = dt_finite > 0.0 ? MIN(1.0, update->dt / (EASE_STEPS * dt_finite)) : 0.0;
  return a;
}

/* ----------------------------------------------------------------------
   forces, onto owned and ghost atoms
------------------------------------------------------------------------- */

void FixDefe::contact_forces()
{
  if (!planes_fresh) update_planes();
  planes_fresh = false;
  DefeContactMemory memory(this);
  const auto arrays = surface_arrays();
  const auto r = defe::surface_forces(surface, arrays, memory);
  contact_energy = r.energy + r.springs;
  if (r.beyond >= 0) beyond_grid = r.beyond;
  ledger.friction += r.friction;
  ledger.external += r.eased;
  for (int k = 0; k < 6; k++) virial_fe[k] += r.virial[k];
  // what a broken tie held is still here
  for (const auto &one : r.inherited)
    if (!touches(one.atom)->fresh) ledger.release -= one.energy;
  if (contact_to_book) {
    ledger.conv_strain -= r.energy - r.eased;
    contact_to_book = false;
  }
  for (const auto &t : r.let_through) {
    ledger.through += t.energy;
    if (t.counts) note_let_through(t.atom, t.depth);
  }
  if (!arrays.moving && r.offset_count > 0) {
    overlaps += r.offset_count;
    if (r.offset_max > overlap_depth) {
      overlap_depth = r.offset_max;
      overlap_tag = atom->tag[r.offset_atom];
    }
  }
  if (!balls_placed && r.ball_atom >= 0) {
    ball_energy = r.ball_energy;
    ball_depth = r.ball_depth;
    ball_share = ball_depth / atom->radius[r.ball_atom];
    ball_tag = atom->tag[r.ball_atom];
  }
  balls_placed = true;
  for (int i : fresh)
    if (touches(i)) touches(i)->fresh = false;
  fresh.clear();
}

/* ----------------------------------------------------------------------
   energy of contact at the positions now, with the tables of before a conversion
------------------------------------------------------------------------- */

double FixDefe::contact_energy_now(std::vector<double> &energy)
{
  update_planes();
  planes_fresh = false;
  DefeContactMemory memory(this);
  defe::surface_forces(surface, surface_arrays(), memory, &energy);
  double sum = 0.0;
  for (double e : energy) sum += e;
  return sum;
}

/* ----------------------------------------------------------------------
   points that got deeper than they can be followed: the first one is named, all are counted
------------------------------------------------------------------------- */

void FixDefe::note_let_through(int i, double depth)
{
  through_count++;
  if (first_through.step >= 0) return;
  first_through.step = update->ntimestep;
  first_through.tag = atom->tag[i];
  first_through.depth = depth;
  for (int k = 0; k < 3; k++) first_through.x[k] = atom->x[i][k];
}

/* ----------------------------------------------------------------------
   what contacts have met since the last report, each kind said once; collective
------------------------------------------------------------------------- */

void FixDefe::report_contacts()
{
  bigint mine[2] = {through_count, overlaps}, all[2];
  MPI_Allreduce(mine, all, 2, MPI_LMP_BIGINT, MPI_SUM, world);
  through_total = all[0];

  if (all[0] > 0 && !through_told) {
    through_told = true;
    // the first one, of all ranks
    struct {
      double step;
      int rank;
    } first = {first_through.step < 0 ? HUGE_VAL : static_cast<double>(first_through.step),
               comm->me},
      winner;
    MPI_Allreduce(&first, &winner, 1, MPI_DOUBLE_INT, MPI_MINLOC, world);
    MPI_Bcast(&first_through, sizeof(first_through), MPI_BYTE, winner.rank, world);
    if (comm->me == 0)
      error->warning(
          FLERR,
          "Contact of fix defe: atom {} got {:.4g} deep at step {} near {:.6g} {:.6g} {:.6g}, "
          "deeper "
          "than contact reaches, and is let through: raise the factor of contact, or take smaller "
          "elements or a smaller timestep (all cases are counted in entry 29 of f_{})",
          first_through.tag, first_through.depth, first_through.step, first_through.x[0],
          first_through.x[1], first_through.x[2], id);
  }

  if (all[1] > 0 && !overlaps_told) {
    overlaps_told = true;
    struct {
      double depth;
      int rank;
    } deepest = {overlap_depth, comm->me}, winner;
    MPI_Allreduce(&deepest, &winner, 1, MPI_DOUBLE_INT, MPI_MAXLOC, world);
    tagint tag = overlap_tag;
    MPI_Bcast(&tag, 1, MPI_LMP_TAGINT, winner.rank, world);
    if (refuse_overlaps)
      error->all(
          FLERR,
          "Contact of fix defe: {} contacts overlap before the first step, the deepest by {:.4g} "
          "(atom {}): "
          "move the bodies apart, or let overlaps be eased out with 'contact {} overlap ease'",
          all[1], winner.depth, tag, contact_factor);
    if (comm->me == 0)
      error->warning(FLERR,
                     "Contact of fix defe: {} contacts overlap before the first step, the deepest "
                     "by {:.4g} (atom "
                     "{}); they are eased out, and the work of that counts as external",
                     all[1], winner.depth, tag);
  }
  if (balls_placed && !balls_told) report_balls();
}

/* ----------------------------------------------------------------------
   a ball that begins in a face: it has no memory by which it could be eased out, and what is deep would
   throw it out with energy from nothing
------------------------------------------------------------------------- */

void FixDefe::report_balls()
{
  balls_told = true;
  struct {
    double depth;
    int rank;
  } mine = {ball_depth, comm->me}, deepest;
  MPI_Allreduce(&mine, &deepest, 1, MPI_DOUBLE_INT, MPI_MAXLOC, world);
  if (deepest.depth == 0.0) return;
  double energy;
  MPI_Allreduce(&ball_energy, &energy, 1, MPI_DOUBLE, MPI_SUM, world);
  MPI_Bcast(&ball_tag, 1, MPI_LMP_TAGINT, deepest.rank, world);
  MPI_Bcast(&ball_share, 1, MPI_DOUBLE, deepest.rank, world);
  const auto what = fmt::format("Contact of fix defe: ball {} begins {:.4g} deep in a face",
                                ball_tag, deepest.depth);
  if (refuse_overlaps) error->all(FLERR, "{}: move it out", what);
  if (ball_share > BALL_SHARE && !ease_overlaps)
    error->all(FLERR,
               "{}, {:.3g} % of its radius: it would be thrown out with the energy {:.4g} that "
               "contacts of balls store; move it out (or write 'contact {} overlap ease')",
               what, 100.0 * ball_share, energy, contact_factor);
  if (comm->me == 0)
    error->warning(FLERR,
                   "{}: what contacts of balls store at the start, {:.4g}, throws them out; move "
                   "balls out of the body",
                   what, energy);
}

/* ----------------------------------------------------------------------
   energy of balls on the quarters of elements of this rank that convert now, by element and corner node:
   their DEs take it over
------------------------------------------------------------------------- */

void FixDefe::ball_shares(const std::unordered_map<tagint, const Converting *> &gone,
                          std::vector<BallShare> &shares)
{
  for (const auto &pair : surface.balls) {
    const auto &facet = surface.facets[pair.facet];
    const auto element = static_cast<tagint>(facet.element);
    if (!facet.outer || !gone.count(element)) continue;
    Vec3 force = Vec3::Zero();
    defe::FacetLoad load;
    const auto r =
        defe::ball_on_facet(Vec3(atom->x[pair.atom]), atom->radius[pair.atom],
                            surface.planes[pair.facet], facet.k_area, facet.area, force, load);
    for (int q = 0; q < 4; q++)
      if (r.quarter[q] > 0.0)
        shares.push_back({element, atom->tag[facet.node[q]], atom->tag[pair.atom], r.quarter[q],
                          r.quarter_push[q]});
  }
  // several faces of one DE may have met the same ball
  std::sort(shares.begin(), shares.end(), [](const BallShare &a, const BallShare &b) {
    return std::tie(a.element, a.node, a.ball) < std::tie(b.element, b.node, b.ball);
  });
}
