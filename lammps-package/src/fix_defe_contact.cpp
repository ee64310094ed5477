/* ----------------------------------------------------------------------
   DEFE: adaptive finite elements to bonded discrete elements for LAMMPS
   https://www.lammps.org/
   This software is distributed under the GNU General Public License.

   Contact of surfaces: nodes and DEs against facets of elements, by penalty.
   The rank that owns the node or DE decides which facet it touches, so each pair
   is treated once on any decomposition; facets of other ranks' elements come with
   the ghosts of their first nodes.
   Balls, spheres that are no DEs: one that is smaller than a facet is such a point. Against
   facets of its own size and smaller ones it presses on their area, by the rank that owns the
   facet; its force comes back with the ghosts.
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

#include "defe/coupling/facet.h"
#include "defe/coupling/friction.h"
#include "defe/coupling/penalty.h"
#include "defe/fe/hex8.h"

#include <algorithm>
#include <cmath>
#include <deque>
#include <map>
#include <unordered_map>
#include <utility>

using namespace LAMMPS_NS;
using defe::Vec3;
using defe::fe::HexCoords;

// a point this far (in natural coordinates) beside a facet still counts as over it: the two sides
// of a contact strain differently, and a node must not drop off an edge that it is flush with
static constexpr double EDGE_MARGIN = 0.15;

static double dist_sq(const double *a, const double *b)
{
  const double x = a[0] - b[0], y = a[1] - b[1], z = a[2] - b[2];
  return x * x + y * y + z * z;
}

// largest distance from the middle of a facet to a point behind it, from the distance of its farthest
// node, the depth there, and the deviation of its corners from a parallelogram
static double farthest_behind(double extent, double depth, double skew)
{
  return std::hypot((1.0 + EDGE_MARGIN) * extent + skew, depth + skew);
}

// a ball whose diameter is not less than the facet's diagonal presses on its area
static bool presses_on_area(double radius, double size)
{
  return 2.0 * radius >= size;
}

// viscous coefficient of a ball's friction where it hardly slides, in masses per time step: each node
// takes that of up to 16 points, with weights that add up to 4
static constexpr double STICK = 0.1;

/* ----------------------------------------------------------------------
   facets near my points and who may touch what; once per reneighbouring
------------------------------------------------------------------------- */

void FixDefe::build_surfaces()
{
  facets.clear();
  facet_nodes.clear();
  contact_pairs.clear();
  contact_facets.clear();
  own_facets.clear();
  ball_pairs.clear();
  surface_at.clear();
  if (!(contact_factor > 0.0)) return;

  const int nlocal = atom->nlocal;
  // elements with a face to the outside: mine, and those of the ranks around

  struct Exposed {
    const HexPod *hex;
    const int *idx;
  };
  std::vector<Exposed> around;
  around.reserve(exposed.size());
  std::deque<std::array<int, 8>> ghost_idx;
  const bool ghosts = comm->nprocs > 1 || domain->xperiodic || domain->yperiodic ||
      domain->zperiodic;
  for (const auto &e : exposed) {
    const Batch &b = batches[e.first];
    around.push_back({b.hex[e.second], b.node[e.second].data()});
    if (ghosts) surface_at[b.node[e.second][0]].push_back(*b.hex[e.second]);
  }
  if (ghosts) {
    comm_mode = SURFACE;
    for (comm_round = 0; comm_round < hexes_per_node; comm_round++)
      comm->forward_comm(this, SURFACE_SIZE);
    std::vector<int> anchors;
    for (const auto &s : surface_at)
      if (s.first >= nlocal) anchors.push_back(s.first);
    std::sort(anchors.begin(), anchors.end());
    for (int anchor : anchors)
      for (const auto &h : surface_at[anchor]) {
        std::array<int, 8> idx;
        idx[0] = anchor;
        bool complete = true;
        for (int a = 1; a < 8 && complete; a++) {
          const int j = local_of(h.node[a]);
          complete = j >= 0;
          if (!complete) continue;
          // beside a ghost anchor the right image of a node may be missing: then this is another one
          idx[a] = domain->closest_image(anchor, j);
          double rsq = 0.0;
          for (int d = 0; d < 3; d++) {
            const double del = xframe[idx[a]][d] - xframe[anchor][d];
            rsq += del * del;
          }
          complete = rsq < 1.01 * max_diagonal * max_diagonal;
        }
        // otherwise it is farther away than anything of mine can touch
        if (!complete) continue;
        ghost_idx.push_back(idx);
        around.push_back({&h, ghost_idx.back().data()});
      }
  }

  // their faces, as they are now

  struct Face {
    int hex, face;    // index into around, local number
    double centre[3];
    double extent, skew;    // squared, see farthest_behind()
    size_t cell;
  };
  std::vector<Face> faces;
  faces.reserve(2 * around.size());
  double **x = atom->x;
  const double *coords = around.empty() ? nullptr : &x[0][0];
  double extent_max = 0.0, skew_max = 0.0;
  Cells space;
  for (size_t e = 0; e < around.size(); e++)
    for (int f = 0; f < 6; f++) {
      if (around[e].hex->nb[f] > 0) continue;
      const double *p[4];
      for (int a = 0; a < 4; a++) p[a] = coords + 3 * around[e].idx[defe::fe::hex_face[f][a]];
      faces.emplace_back();
      Face &face = faces.back();
      face.hex = static_cast<int>(e);
      face.face = f;
      face.extent = face.skew = 0.0;
      for (int d = 0; d < 3; d++) {
        face.centre[d] = 0.25 * (p[0][d] + p[1][d] + p[2][d] + p[3][d]);
        const double skew = 0.25 * (p[0][d] - p[1][d] + p[2][d] - p[3][d]);
        face.skew += skew * skew;
      }
      for (const double *q : p) face.extent = std::max(face.extent, dist_sq(q, face.centre));
      extent_max = std::max(extent_max, face.extent);
      skew_max = std::max(skew_max, face.skew);
      space.add(face.centre);
    }
  extent_max = std::sqrt(extent_max);
  skew_max = std::sqrt(skew_max);

  // which parts are where, in a grid: far from all others, and from DEs, there is nothing to do
  // A facet is needed if it can meet a point of another part, or belongs to a point that can meet a
  // facet of another part: either way the centres of two facets are within `range`.

  double rmax = 0.0;
  for (int d = 0; d < jt.nde; d++) rmax = std::max(rmax, outer_reach[jt.self[d]]);
  std::vector<int> balls, large_balls;
  for (int i = 0; i < nlocal + atom->nghost; i++) {
    if (!is_ball(i)) continue;
    balls.push_back(i);
    if (atom->radius[i] > max_diagonal)
      large_balls.push_back(i);
    else
      rmax = std::max(rmax, atom->radius[i]);
  }
  const auto ball_is_near = [&](int ball, const double *centre, double extent) {
    const double far = atom->radius[ball] + extent + neighbor->skin;
    return dist_sq(x[ball], centre) < far * far;
  };
  // of a point in front of a facet, or behind it
  const double reach =
      std::max(extent_max + rmax, farthest_behind(extent_max, MAX_DEPTH * max_facet, skew_max)) +
      neighbor->skin;
  const double range = reach + extent_max;

  for (int d = 0; d < jt.nde; d++) space.add(x[jt.self[d]]);
  for (int i : balls) space.add(x[i]);
  // a bit for each part; parts beyond the last bit, DEs and balls are always several
  constexpr unsigned SEVERAL = 3u << 30;
  const auto bit = [](int part) {
    return part < 30 ? 1u << part : SEVERAL;
  };
  space.divide(0.5 * range);
  std::vector<unsigned> who(space.count(), 0);
  for (auto &face : faces) {
    face.cell = space.of(face.centre);
    who[face.cell] |= bit(around[face.hex].hex->part);
  }
  for (int d = 0; d < jt.nde; d++) who[space.of(x[jt.self[d]])] |= SEVERAL;
  for (int i : balls) who[space.of(x[i])] |= SEVERAL;
  space.spread(who, 2);

  std::vector<int> hex_of_facet;
  std::vector<double> extent, behind;
  for (const auto &face : faces) {
    const HexPod &h = *around[face.hex].hex;
    const unsigned there = who[face.cell];
    if ((there & (there - 1)) == 0) {    // one part only
      bool hit = false;
      for (int i : large_balls) hit = hit || ball_is_near(i, face.centre, extent_max);
      if (!hit) continue;
    }
    facets.emplace_back();
    Facet &facet = facets.back();
    facet.element = h.id;
    facet.face = face.face;
    facet.part = h.part;
    facet.outer = (h.nb[face.face] == 0);
    facet.mine = (around[face.hex].idx[0] < nlocal);
    for (int d = 0; d < 3; d++) facet.centre[d] = face.centre[d];
    for (int k = 0; k < 4; k++)
      facet.node[k] = around[face.hex].idx[defe::fe::hex_face[face.face][k]];
    facet_nodes.push_back({facet.node[0], facet.node[1], facet.node[2], facet.node[3]});
    facet.size = std::sqrt(std::max(dist_sq(xframe[facet.node[2]], xframe[facet.node[0]]),
                                    dist_sq(xframe[facet.node[3]], xframe[facet.node[1]])));
    facet.used = false;
    facet.k_area = material_of(parts[h.part]).rigid() ? -1.0 : 0.0;
    hex_of_facet.push_back(face.hex);
    extent.push_back(std::sqrt(face.extent));
    behind.push_back(farthest_behind(extent.back(), MAX_DEPTH * facet.size, std::sqrt(face.skew)));
  }
  update_planes();
  planes_fresh = true;

  // area and stiffness only of facets that are used

  const auto complete = [&](int k) {
    Facet &f = facets[k];
    if (f.used) return;
    f.used = true;
    Vec3 P[4];
    for (int a = 0; a < 4; a++) P[a] = Vec3(xframe[f.node[a]]);
    f.area = defe::fe::face_area(P);
    if (f.k_area < 0.0) return;
    const double bulk = material_of(parts[f.part]).elastic().bulk();
    const double volume = around[hex_of_facet[k]].hex->volume;
    f.k_area = defe::penalty_stiffness_per_area(contact_factor, bulk, f.area, volume);
  };

  for (size_t k = 0; k < facets.size() && !balls.empty(); k++) {
    const Facet &f = facets[k];
    if (!f.mine || f.k_area < 0.0) continue;    // a ball is rigid, too
    for (int i : balls)
      if (presses_on_area(atom->radius[i], f.size) && ball_is_near(i, f.centre, extent[k])) {
        complete(static_cast<int>(k));
        ball_pairs.push_back({i, static_cast<int>(k)});
      }
  }

  // points: my nodes on outer faces, my DEs, and small balls

  struct Point {
    int atom, part;
    double r;
    bool ball;
  };
  std::vector<Point> points;
  std::vector<int> part_of(nlocal, MAXSMALLINT);
  for (const auto &f : facets) {
    if (!f.outer) continue;
    for (int i : f.node)
      if (i < nlocal) part_of[i] = MIN(part_of[i], f.part);    // one that parts share: the first
  }
  for (int i = 0; i < nlocal; i++)
    if (part_of[i] < MAXSMALLINT) points.push_back({i, part_of[i], 0.0, false});
  for (int d = 0; d < jt.nde; d++)
    points.push_back({jt.self[d], jt.rec[d]->part, outer_reach[jt.self[d]], false});
  for (int i : balls)
    if (i < nlocal && !presses_on_area(atom->radius[i], max_diagonal))
      points.push_back({i, -1, atom->radius[i], true});
  if (facets.empty() || points.empty()) {
    keep_used_facets();
    return;
  }

  // facets around each point, in cells as large as their reach: a grid per class of sizes

  struct Candidate {
    double x[3];
    double front, behind;    // largest distances of a point without radius
    int part, facet;
  };
  struct SizeClass {
    double reach = 0.0;
    std::vector<Candidate> candidates;
  };
  std::map<int, SizeClass> classes;
  for (size_t k = 0; k < facets.size(); k++) {
    const Facet &f = facets[k];
    const double mine = std::max(extent[k] + rmax, behind[k]) + neighbor->skin;
    auto &c = classes[std::ilogb(reach / mine)];
    c.reach = std::max(c.reach, mine);
    c.candidates.push_back({{f.centre[0], f.centre[1], f.centre[2]},
                            extent[k],
                            behind[k],
                            f.part,
                            static_cast<int>(k)});
  }
  std::vector<CellList<Candidate>> lists;
  for (auto &c : classes) lists.emplace_back(std::move(c.second.candidates), c.second.reach);

  const bool born_loose = force->pair_match("defe/contact", 1) != nullptr;    // ties hold nothing
  // beside its edges a facet that turns moves farther than its nodes
  const double drift = (1.0 + EDGE_MARGIN) * neighbor->skin;
  std::vector<std::pair<int, int>> near;    // indices of point and facet
  // an order that no list of atoms or facets has made
  const auto by_identity = [this](int a, int b) {
    const Facet &fa = facets[a], &fb = facets[b];
    if (fa.part != fb.part) return fa.part < fb.part;
    return fa.element != fb.element ? fa.element < fb.element : fa.face < fb.face;
  };

  for (size_t n = 0; n < points.size(); n++) {
    const Point &p = points[n];
    const double *xp = x[p.atom];
    const bool is_node = p.r == 0.0, de_point = !is_node && !p.ball;
    const bool rigid = !p.ball && material_of(parts[p.part]).rigid();
    const size_t before = near.size();
    for (const auto &list : lists)
      list.runs_around(xp, [&](int first, int last) {
        for (int c = first; c < last; c++) {
          const Candidate &f = list.all()[c];
          const bool same = (f.part == p.part);
          if (same && is_node) continue;
          // nothing of its own part gets behind a face
          const double cut =
              (same ? f.front + p.r : std::max(f.front + p.r, f.behind)) + neighbor->skin;
          if (dist_sq(xp, f.x) > cut * cut) continue;
          const Facet &facet = facets[f.facet];
          const double depth = same ? 0.0 : MAX_DEPTH * facet.size;
          if (facet_planes[f.facet].beyond(Vec3(xp), p.r, depth, drift)) continue;
          if (p.ball && presses_on_area(p.r, facet.size)) continue;
          if (facet.k_area < 0.0 && (p.ball || rigid)) continue;
          // a DE is tied to this element; if that cannot end, it need not be looked at again
          if (de_point && !born_loose && !adhesive_of(p.part, f.part) &&
              tied(p.atom, facet.element))
            continue;
          near.emplace_back(static_cast<int>(n), f.facet);
        }
      });
    if (near.size() > before + 1)
      std::sort(near.begin() + before, near.end(), [&](const auto &a, const auto &b) {
        return by_identity(a.second, b.second);
      });
  }

  // the outer facets of each node among them, of all parts

  std::vector<int> first_corner(1, 0), corners;    // by number of the node: ~number is in part_of
  for (const auto &n : near) {
    if (points[n.first].r > 0.0 || part_of[points[n.first].atom] < 0) continue;
    part_of[points[n.first].atom] = ~static_cast<int>(first_corner.size() - 1);
    first_corner.push_back(0);
  }
  const auto for_corners = [&](auto f) {
    for (size_t k = 0; k < facets.size(); k++)
      if (facets[k].outer)
        for (int i : facets[k].node)
          if (i < nlocal && part_of[i] < 0) f(~part_of[i], static_cast<int>(k));
  };
  for_corners([&](int node, int) {
    first_corner[node + 1]++;
  });
  for (size_t k = 1; k < first_corner.size(); k++) first_corner[k] += first_corner[k - 1];
  corners.resize(first_corner.back());
  std::vector<int> next(first_corner.begin(), first_corner.end() - 1);
  for_corners([&](int node, int facet) {
    corners[next[node]++] = facet;
  });

  // pairs of a point with each part

  for (size_t k = 0; k < near.size();) {
    const int n = near[k].first;
    const Point &p = points[n];
    ContactPair cp;
    cp.point = p.atom;
    cp.own = static_cast<int>(own_facets.size());
    cp.area = 0.0;
    cp.k_own = -1.0;    // a ball is rigid
    cp.ball = p.ball;
    // nodes are met a second time, by the nodes of the other side against their facets
    cp.weight = p.r > 0.0 ? 1.0 : 0.5;
    if (p.ball)
      cp.area = 4.0 * std::atan(1.0) * p.r * p.r;
    else if (p.r > 0.0) {
      cp.area = jt.rec[jt.of_atom[p.atom]]->outer_area;
      cp.k_own = ball_stiffness(p.part, p.atom) / cp.area;
    } else {
      double sum = 0.0;
      const int node = ~part_of[p.atom];
      std::sort(&corners[first_corner[node]], &corners[0] + first_corner[node + 1], by_identity);
      for (int c = first_corner[node]; c < first_corner[node + 1]; c++) {
        const int own = corners[c];
        if (facets[own].part != p.part) continue;
        complete(own);
        sum += facets[own].k_area;
        own_facets.push_back(own);
      }
      cp.k_own = sum / (static_cast<int>(own_facets.size()) - cp.own);
    }
    cp.nown = static_cast<int>(own_facets.size()) - cp.own;
    while (k < near.size() && near[k].first == n) {
      cp.part = facets[near[k].second].part;
      cp.same = (cp.part == p.part);
      cp.first = static_cast<int>(contact_facets.size());
      // against its own part a DE is a sphere: those of tall cells reach beyond it only outwards
      cp.r = cp.same ? std::min(p.r, atom->radius[p.atom]) : p.r;
      // spheres of flat cells reach through the face that they were tied to from the start
      if (p.r > 0.0 && !p.ball)
        for (const auto &slot : jt.rec[jt.of_atom[p.atom]]->slot)
          if (slot.kind == DefeJoint::TIE && slot.part == cp.part)
            cp.r = std::min(cp.r, Vec3(slot.face).dot(Vec3(slot.normal)));
      for (; k < near.size() && near[k].first == n && facets[near[k].second].part == cp.part; k++) {
        complete(near[k].second);
        contact_facets.push_back(near[k].second);
      }
      cp.count = static_cast<int>(contact_facets.size()) - cp.first;
      contact_pairs.push_back(cp);
    }
  }
  keep_used_facets();
}

/* ----------------------------------------------------------------------
   only the facets of contacts are looked at in each step
------------------------------------------------------------------------- */

void FixDefe::keep_used_facets()
{
  std::vector<int> now(facets.size(), -1);
  int n = 0;
  for (size_t k = 0; k < facets.size(); k++) {
    if (!facets[k].used) continue;
    now[k] = n;
    facets[n] = facets[k];
    facet_nodes[n] = facet_nodes[k];
    facet_planes[n] = facet_planes[k];
    n++;
  }
  facets.resize(n);
  facet_nodes.resize(n);
  facet_planes.resize(n);
  for (int &k : contact_facets) k = now[k];
  for (int &k : own_facets) k = now[k];
  for (auto &pair : ball_pairs) pair.facet = now[pair.facet];
}

/* ----------------------------------------------------------------------
   the facets at the positions now
------------------------------------------------------------------------- */

void FixDefe::update_planes()
{
  const int n = static_cast<int>(facets.size());
  facet_planes.resize(n);
  if (n)
    defe::facet_planes(n, reinterpret_cast<const int(*)[4]>(facet_nodes.data()), &atom->x[0][0],
                       facet_planes.data());
}

/* ----------------------------------------------------------------------
   area of a node that faces a surface with this normal, 0 if it looks another way
   Only surfaces that face each other: where two edges lie flush, a node that comes free of one
   face must not be taken for inside of the face round the corner.
   With the normals of this step: the result must not depend on when the lists were made.
------------------------------------------------------------------------- */

double FixDefe::facing_area(const ContactPair &cp, const Vec3 &normal)
{
  double area = 0.0;
  for (int k = cp.own; k < cp.own + cp.nown; k++) {
    const double cosine = facet_planes[own_facets[k]].normal.dot(normal);
    if (cosine < -0.3) area -= 0.25 * facets[own_facets[k]].area * cosine;
  }
  return area;
}

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
   balls against facets that are not larger: the penalty pressure k_A g over four points per facet,
   natural coordinates +-1/2, a quarter of the area each. These are the points and areas of
   the DEs that the element would become.
   Friction has no history: Coulomb's, and viscous where that is less.
------------------------------------------------------------------------- */

void FixDefe::ball_forces()
{
  double **x = atom->x;
  double **v = atom->v;
  double **f = atom->f;
  double **omega = atom->omega;
  double **torque = atom->torque;
  const double *rmass = atom->rmass;
  static constexpr double pi = 3.14159265358979323846;
  static constexpr double quarter[4][2] = {{-0.5, -0.5}, {0.5, -0.5}, {0.5, 0.5}, {-0.5, 0.5}};
  double N[4][4];
  for (int q = 0; q < 4; q++) defe::facet_shape(quarter[q][0], quarter[q][1], N[q]);

  for (const auto &pair : ball_pairs) {
    const Facet &facet = facets[pair.facet];
    const int i = pair.ball;
    const double R = atom->radius[i];
    const Vec3 c(x[i]);
    const defe::FacetPlane &g = facet_planes[pair.facet];
    const double far = R + 0.5 * facet.size;
    if ((c - g.mid).squaredNorm() > far * far) continue;
    if (std::abs((c - g.mid).dot(g.normal)) > R + g.warp) continue;
    const double area = 0.25 * facet.area;
    for (const auto &shape : N) {
      Vec3 p = Vec3::Zero();
      for (int a = 0; a < 4; a++) p += shape[a] * Vec3(x[facet.node[a]]);
      const Vec3 off = c - p;
      const double distance = off.norm();
      const double overlap = R - distance;
      if (overlap <= 0.0 || off.dot(g.normal) <= 0.0) continue;
      const Vec3 n = off / distance;
      const double k = facet.k_area * area;
      const double push = k * overlap;
      contact_energy += 0.5 * push * overlap;
      Vec3 force = push * n;
      if (contact_friction > 0.0) {
        Vec3 slip = Vec3(v[i]) - Vec3(omega[i]).cross(off);
        double mass = HUGE_VAL;
        for (int a = 0; a < 4; a++) {
          slip -= shape[a] * Vec3(v[facet.node[a]]);
          mass = std::min(mass, rmass[facet.node[a]]);
        }
        slip -= slip.dot(n) * n;
        const double speed = slip.norm();
        // as many points as the ball can cover share its mass
        const double points = 1.0 + pi * R * R / area;
        const double viscous = STICK / (update->dt * (1.0 / mass + points / rmass[i]));
        if (speed > 0.0) {
          const double drag = std::min(contact_friction * push, viscous * speed);
          force -= drag / speed * slip;
          if (!update->setupflag) ledger.friction += drag * speed * update->dt;
        }
      }
      const Vec3 moment = force.cross(off);
      for (int d = 0; d < 3; d++) {
        f[i][d] += force[d];
        torque[i][d] += moment[d];
      }
      for (int a = 0; a < 4; a++)
        for (int d = 0; d < 3; d++) f[facet.node[a]][d] -= shape[a] * force[d];
      const double w[6] = {off[0] * force[0], off[1] * force[1], off[2] * force[2],
                           off[0] * force[1], off[0] * force[2], off[1] * force[2]};
      for (int d = 0; d < 6; d++) virial_fe[d] += w[d];
    }
  }
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
   penalty forces, onto owned and ghost atoms
   Sides are kept: a point gets into a body only by crossing a facet, so it can be no
   deeper than it was a step ago plus the way it has gone since. What is deeper, lies
   behind a face round the corner, or behind one that a conversion has just bared.
------------------------------------------------------------------------- */

void FixDefe::contact_forces()
{
  double **x = atom->x;
  double **v = atom->v;
  double **f = atom->f;
  const double dt = update->dt;
  const bool minimizing = (update->whichflag == 2);    // then there are no velocities
  contact_energy = 0.0;
  if (!planes_fresh) update_planes();
  planes_fresh = false;
  if (!ball_pairs.empty()) ball_forces();

  for (const auto &cp : contact_pairs) {
    const Vec3 p(x[cp.point]);
    DefeTouch *old = nullptr;
    if (touch[cp.point])
      for (auto &t : touch[cp.point]->faces)
        if (t.part == cp.part) old = &t;
    const double was = old ? old->depth : 0.0;
    const Facet *best = nullptr;
    defe::FacetPoint at;
    Vec3 n, slip;
    double nearest = 1.0e300, depth = 0.0, area = 0.0;
    for (int k = cp.first; k < cp.first + cp.count; k++) {
      const Facet &facet = facets[contact_facets[k]];

      // cheap tests first: distance to the middle of the facet, to its plane, and over it or not

      const defe::FacetPlane &g = facet_planes[contact_facets[k]];
      const Vec3 del = p - g.mid;
      const double cut = facet.size * (0.5 + EDGE_MARGIN + MAX_DEPTH) + cp.r;
      if (del.squaredNorm() > cut * cut) continue;
      const double height = del.dot(g.normal);
      if (height > cp.r + g.warp) continue;
      if (height < -MAX_DEPTH * facet.size - g.warp) continue;
      const double over_xi = std::max(0.0, std::abs(del.dot(g.to_xi)) - 1.0);
      const double over_eta = std::max(0.0, std::abs(del.dot(g.to_eta)) - 1.0);
      if (cp.r == 0.0) {
        if (over_xi > defe::FacetPlane::margin || over_eta > defe::FacetPlane::margin) continue;
      } else if (height > 0.0) {
        // a sphere beside the facet; four fifths are on the safe side for skewed ones
        const double beside =
            0.8 * std::max(over_xi * g.half_xi(), over_eta * g.half_eta()) - g.warp;
        const double above = std::max(0.0, height - g.warp);
        if (beside > 0.0 && beside * beside + above * above > cp.r * cp.r) continue;
      }
      double facing = cp.area;
      if (cp.r == 0.0) {
        facing = facing_area(cp, g.normal);
        if (facing == 0.0) continue;
      } else if (cp.ball)
        facing = std::min(facing, facet.area);
      else if (tied(cp.point, facet.element))
        continue;
      const Vec3 q[4] = {Vec3(x[facet.node[0]]), Vec3(x[facet.node[1]]), Vec3(x[facet.node[2]]),
                         Vec3(x[facet.node[3]])};
      defe::FacetPoint here;
      double overlap, distance;
      Vec3 direction;
      if (cp.r > 0.0 && height > -g.warp) {
        // a sphere in front: against the closest point, be it on a face or an edge
        here = defe::closest_point(p, q);
        distance = std::abs(here.distance);
        overlap = cp.r - distance;
        direction = (p - here.closest) / distance;
      }
      if (cp.r == 0.0 || height <= -g.warp || here.distance < 0.0) {
        // a point behind: only if it is over the facet, less a margin at the edges
        if (cp.same) continue;
        here = defe::project_point(p, q, del.dot(g.to_xi), del.dot(g.to_eta));
        const double beside_xi = std::max(0.0, std::abs(here.xi) - 1.0);
        const double beside_eta = std::max(0.0, std::abs(here.eta) - 1.0);
        if (here.distance > 0.0 || beside_xi > EDGE_MARGIN || beside_eta > EDGE_MARGIN) continue;
        overlap = cp.r - here.distance;
        direction = here.normal;
        const double beside_sq = beside_xi * beside_xi + beside_eta * beside_eta;
        distance =
            std::sqrt(here.distance * here.distance + 0.25 * facet.size * facet.size * beside_sq);
        if (!minimizing) {
          Vec3 speed(v[cp.point]);
          for (int a = 0; a < 4; a++) speed -= here.N[a] * Vec3(v[facet.node[a]]);
          if (overlap > was + 2.0 * dt * speed.norm() + 1.0e-7 * facet.size) continue;
        }
      }
      if (overlap <= 0.0 || distance >= nearest) continue;
      nearest = distance;
      depth = overlap;
      n = direction;
      at = here;
      best = &facet;
      area = facing;
    }
    if (!best || depth <= 0.0) {
      if (old) {
        ledger.friction += old->stored;    // the spring is let go
        *old = touch[cp.point]->faces.back();
        touch[cp.point]->faces.pop_back();
      }
      continue;
    }
    if (!old) {
      auto &list = touch_at(cp.point).faces;
      list.push_back({cp.part, 0, 0.0, {0.0, 0.0, 0.0}, 0.0});
      old = &list.back();
    }
    old->depth = depth;

    double k = cp.k_own;
    if (k < 0.0 || (best->k_area > 0.0 && best->k_area < k)) k = best->k_area;
    k *= area * cp.weight;
    contact_energy += 0.5 * k * depth * depth;
    // a tie that broke by shear while it was pressed: this much of what it held is still here
    for (int ds : jt.debonded)
      if (jt.self[ds / 6] == cp.point && jt.rec[ds / 6]->slot[ds % 6].other == best->element)
        ledger.release -= 0.5 * k * depth * depth;
    Vec3 force = k * depth * n;
    if (contact_friction > 0.0) {
      for (int d = 0; d < 3; d++) slip[d] = v[cp.point][d];
      for (int a = 0; a < 4; a++) slip -= at.N[a] * Vec3(v[best->node[a]]);
      if (cp.ball) slip += Vec3(atom->omega[cp.point]).cross(at.closest - p);
      Vec3 shear(old->shear);
      const auto r =
          defe::coulomb_friction(shear, n, update->setupflag ? Vec3::Zero() : Vec3(dt * slip), k,
                                 contact_friction * k * depth);
      force += r.force;
      contact_energy += r.stored;
      // the evaluation before a run is no step: springs stay as they are, nothing is rubbed off
      if (!update->setupflag) {
        for (int d = 0; d < 3; d++) old->shear[d] = shear[d];
        old->stored = r.stored;
        ledger.friction += r.rubbed;
      }
    }
    for (int d = 0; d < 3; d++) f[cp.point][d] += force[d];
    for (int a = 0; a < 4; a++)
      for (int d = 0; d < 3; d++) f[best->node[a]][d] -= at.N[a] * force[d];
    const Vec3 off = p - at.closest;
    if (cp.ball) {
      const Vec3 moment = force.cross(off);
      for (int d = 0; d < 3; d++) atom->torque[cp.point][d] += moment[d];
    }
    const double w[6] = {off[0] * force[0], off[1] * force[1], off[2] * force[2],
                         off[0] * force[1], off[0] * force[2], off[1] * force[2]};
    for (int d = 0; d < 6; d++) virial_fe[d] += w[d];
  }
}
