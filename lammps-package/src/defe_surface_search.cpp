/* ----------------------------------------------------------------------
   DEFE: adaptive finite elements to bonded discrete elements for LAMMPS
   https://www.lammps.org/
   This software is distributed under the GNU General Public License.
------------------------------------------------------------------------- */

// What the search of coupling (surface_search.h) works on. Facets of other ranks' elements come with the
// ghosts of the elements' first nodes.

#include "defe_surface_search.h"

#include "defe_system.h"

#include "atom.h"
#include "comm.h"
#include "error.h"
#include "fix.h"
#include "force.h"
#include "neighbor.h"
#include "update.h"

#include <algorithm>
#include <cmath>
#include <cstring>

using namespace LAMMPS_NS;
using defe::Vec3;

DefeSurfaceSearch::DefeSurfaceSearch(DefeSystem &system) :
    DefeComponent(system), ties(system), exposed(atom)
{
}

void DefeSurfaceSearch::run(defe::SurfaceTables &tables)
{
  const bool any = atom->nlocal + atom->nghost > 0;
  auto &all = scene.particles;
  all.nlocal = atom->nlocal;
  all.nall = atom->nlocal + atom->nghost;
  all.x = any ? &atom->x[0][0] : nullptr;
  all.X = any ? sys.store.x_frame(0) : nullptr;
  all.radius = atom->radius;
  all.id = atom->tag;

  scene.ties = &ties;
  scene.spheres = &sys.tables.others();
  scene.factor = sys.model.contact_factor;
  scene.skin = sys.in_place.slack();
  scene.element_size = sys.mesh.max_diagonal();
  ties.born_loose = force->pair_match("defe/contact", 1) != nullptr;
  gather_parts();
  const bool few = sys.in_place.going_on() && unnoticed;
  if (few) {
    if (sys.in_place.at_border()) send_beside();
    notice_around_gone();
  } else
    send_elements(sys.elements.exposed());
  gather_elements(few ? sys.elements.noticed() : sys.elements.exposed());
  gather_des();
  if (update->setupflag) search.forget();    // between two runs all may have changed
  search.run(scene, tables);
  if (!few) keep_noticed();
  if (sys.model.checking) check(tables, few);
}

void DefeSurfaceSearch::check(const defe::SurfaceTables &tables, bool among_few)
{
  if (among_few) gather_elements(sys.elements.exposed());
  if (!defe::search_agrees(scene, tables))
    error->one(FLERR, "Fix defe at step {}: a whole search finds other contacts on proc {}",
               update->ntimestep, comm->me);
}

void DefeSurfaceSearch::gather_parts()
{
  scene.parts.clear();
  for (const auto &part : sys.model.parts) {
    const auto &m = sys.model.material_of(part);
    scene.parts.push_back({m.rigid(), m.elastic().bulk()});
  }
  scene.tied_parts.clear();
  for (const auto &pair : sys.model.tied) scene.tied_parts.emplace_back(pair.a, pair.b);
}

void DefeSurfaceSearch::gather_des()
{
  const auto &jt = sys.joints;
  auto &des = scene.des;
  des.count = jt.nde;
  des.particle = jt.self.data();
  des.distance = sys.tables.outer_reach().data();
  des.length = sys.tables.outer_length().data();
  des.part.resize(jt.nde);
  des.area.resize(jt.nde);
  for (int d = 0; d < jt.nde; d++) {
    des.part[d] = jt.material[d];
    des.area[d] = sys.tables.outer_area(d);
  }
}

bool DefeSurfaceSearch::Ties::lasting(int de, int part, std::int64_t element) const
{
  const auto &jt = sys.joints;    // on this rank DEs of the scene are those of the joint table
  return !born_loose && !sys.model.adhesive_of(jt.material[de], part) &&
      jt.tied(jt.self[de], static_cast<tagint>(element));
}

double DefeSurfaceSearch::Ties::tied_face(int de, int part) const
{
  double nearest = HUGE_VAL;
  for (int k = sys.tables.first_tied(de); k < sys.tables.first_tied(de + 1); k++) {
    const auto &tied = sys.tables.tied()[k];
    if (tied.part == part) nearest = std::min(nearest, tied.distance);
  }
  return std::min(nearest, sys.tied_des.contact_distance(de, part));
}

/* ---------------------------------------------------------------------- */

void DefeSurfaceSearch::add_element(const HexPod &h, const int *idx)
{
  unsigned bare = 0, free = 0;
  for (int f = 0; f < 6; f++) {
    bare |= static_cast<unsigned>(h.nb[f] <= 0) << f;
    free |= static_cast<unsigned>(h.nb[f] == 0) << f;
  }
  scene.elements.push_back({h.id, idx, h.volume, h.part, static_cast<unsigned char>(bare),
                            static_cast<unsigned char>(free)});
}

void DefeSurfaceSearch::gather_elements(const List &list)
{
  scene.elements.clear();
  scene.elements.reserve(list.size());
  for (const auto &e : list) {
    const auto &b = sys.elements.batches()[e.first];
    add_element(*b.hex[e.second], b.nodes(e.second).data());
  }
  if (sys.ghosts.any()) add_ghost_elements();
}

/* ----------------------------------------------------------------------
   to the ranks around, by their first nodes, and what comes from there
------------------------------------------------------------------------- */

void DefeSurfaceSearch::send_elements(const List &list)
{
  exposed.of_others.clear();
  if (!sys.ghosts.any()) return;
  auto &first = exposed.first;
  first.assign(atom->nlocal + 1, 0);
  const auto first_node = [this](const List::value_type &e) {
    return sys.elements.batches()[e.first].nodes(e.second)[0];
  };
  for (const auto &e : list) first[first_node(e) + 1]++;
  for (int i = 0; i < atom->nlocal; i++) first[i + 1] += first[i];
  std::vector<int> next(first.begin(), first.end() - 1);
  exposed.own.resize(list.size());
  for (const auto &e : list)
    exposed.own[next[first_node(e)]++] = sys.elements.batches()[e.first].hex[e.second];
  send_exposed();
}

void DefeSurfaceSearch::send_exposed()
{
  const int rounds = sys.mesh.hexes_per_node();
  for (exposed.round = 0; exposed.round < rounds; exposed.round++)
    sys.ghosts.forward(exposed, MESSAGE_SIZE);
  exposed.keep();
}

/* ----------------------------------------------------------------------
   in place: what was sent before is still true, but for what has converted and what that has laid bare
------------------------------------------------------------------------- */

void DefeSurfaceSearch::send_beside()
{
  for (const auto &one : gone) exposed.forget(one);
  auto &few = exposed.few;
  few.clear();
  for (const auto &one : beside) {
    const int i = sys.ids.local_of(one.first);
    if (i < 0 || i >= atom->nlocal) continue;
    for (const auto &h : sys.store.hexes(i))
      if (h.id == one.second) few[i].push_back(&h);
  }
  exposed.first.clear();
  send_exposed();
  few.clear();
}

/* ----------------------------------------------------------------------
   as far as all of their nodes are here
------------------------------------------------------------------------- */

void DefeSurfaceSearch::add_ghost_elements()
{
  ghost_idx.clear();
  std::vector<std::pair<int, const std::vector<HexPod> *>> anchors;
  for (const auto &one : exposed.of_others)
    for (int i = sys.ids.local_of(one.first); i >= 0; i = atom->sametag[i])
      if (i >= atom->nlocal) anchors.emplace_back(i, &one.second);
  std::sort(anchors.begin(), anchors.end());
  const double size = sys.mesh.max_diagonal();
  for (const auto &one : anchors)
    for (const auto &h : *one.second) {
      const int anchor = one.first;
      const Vec3 X(sys.store.x_frame(anchor));
      std::array<int, 8> idx;
      idx[0] = anchor;
      bool complete = true;
      for (int a = 1; a < 8 && complete; a++) {
        // beside a ghost anchor the right image of a node may be missing: then this is another one
        idx[a] = sys.ids.nearest_to(anchor, h.node[a]);
        complete = idx[a] >= 0;
        if (!complete) continue;
        complete = (Vec3(sys.store.x_frame(idx[a])) - X).squaredNorm() < 1.01 * size * size;
      }
      // otherwise it is farther away than anything of mine can touch
      if (!complete) continue;
      ghost_idx.push_back(idx);
      add_element(h, ghost_idx.back().data());
    }
}

/* ----------------------------------------------------------------------
   A search among all has left most elements aside, with nothing beside them. Until the next one they matter only if
   something new comes near: what converts, and what that lays bare.
------------------------------------------------------------------------- */

/** From an element that converts to the middle of one that its DEs, or faces that it lays bare, may touch: two halves and what contacts
    reach (neighbourhoods of facets, at most two diagonals), stretched, and what they have moved. */
double DefeSurfaceSearch::far() const
{
  return 4.0 * sys.mesh.max_diagonal() + 2.0 * scene.skin;
}

void DefeSurfaceSearch::keep_noticed()
{
  unnoticed.reset();
  if (!sys.in_place.allowed()) return;
  std::vector<char> which(scene.elements.size());
  search.find_noticed(which);
  sys.elements.notice_only(which);
  std::vector<Unnoticed> rest;
  for (const auto &e : sys.elements.exposed()) {
    const DefeBatch &b = sys.elements.batches()[e.first];
    const HexRecord &h = *b.hex[e.second];
    if (h.noticed) continue;
    Unnoticed one{{0.0, 0.0, 0.0}, h.node[0], h.id};
    for (int i : b.nodes(e.second))
      for (int k = 0; k < 3; k++) one.x[k] += 0.125 * atom->x[i][k];
    rest.push_back(one);
  }
  unnoticed = std::make_unique<const defe::CellList<Unnoticed>>(std::move(rest), far());
}

void DefeSurfaceSearch::notice_around_gone()
{
  std::vector<int> nodes;
  const double limit = far() * far();
  for (const auto &one : gone) {
    Vec3 centre = Vec3::Zero();
    for (int a = 0; a < 8; a++) {
      for (int k = 0; k < 3; k++) centre[k] += 0.125 * one.x[a][k];
      const int i = sys.ids.local_of(static_cast<tagint>(one.node[a]));
      if (i >= 0) nodes.push_back(i);
    }
    unnoticed->runs_around(centre.data(), [&](int first, int last) {
      for (int c = first; c < last; c++) {
        const Unnoticed &other = unnoticed->all()[c];
        if ((Vec3(other.x) - centre).squaredNorm() > limit) continue;
        const int i = sys.ids.local_of(other.first);
        if (i < 0 || i >= atom->nlocal) continue;
        for (const auto &h : sys.store.hexes(i))
          if (h.id == other.id && !h.noticed) add_nodes(h, nodes);
      }
    });
  }
  // and those beside them: whether the surface goes on beyond an edge is seen from there
  const size_t known = sys.elements.noticed().size();
  sys.elements.notice_at(nodes);
  const auto &list = sys.elements.noticed();
  const auto nodes_from = [&](size_t first) {
    nodes.clear();
    for (size_t k = first; k < list.size(); k++)
      add_nodes(*sys.elements.batches()[list[k].first].hex[list[k].second], nodes);
  };
  nodes_from(known);
  sys.elements.notice_at(nodes);
  nodes_from(known);
  for (int i : nodes) sys.in_place.watch(i);
}

void DefeSurfaceSearch::add_nodes(const HexPod &h, std::vector<int> &nodes) const
{
  for (tagint node : h.node) {
    const int i = sys.ids.local_of(node);
    if (i >= 0) nodes.push_back(i);
  }
}

/* ----------------------------------------------------------------------
   only atoms that have something send it, one element a round
------------------------------------------------------------------------- */

const HexPod *DefeSurfaceSearch::Exposed::of_round(int i) const
{
  if (i + 1 < static_cast<int>(first.size()))
    return first[i] + round < first[i + 1] ? own[first[i] + round] : nullptr;
  const auto known = few.find(i);
  if (known != few.end())
    return round < static_cast<int>(known->second.size()) ? known->second[round] : nullptr;
  const auto found = passing.find(i);
  if (found == passing.end() || round >= static_cast<int>(found->second.size())) return nullptr;
  return &found->second[round];
}

int DefeSurfaceSearch::Exposed::pack_forward(int n, const int *list, const double *, double *buf)
{
  int m = 1;
  const bool none = first.empty() && few.empty() && passing.empty();
  for (int ii = 0; ii < n && !none; ii++) {
    const HexPod *h = of_round(list[ii]);
    if (!h) continue;
    buf[m++] = ubuf(ii).d;
    memcpy(static_cast<void *>(&buf[m]), h, sizeof(HexPod));
    m += HEX_SIZE;
  }
  buf[0] = ubuf(m).d;
  return m;
}

void DefeSurfaceSearch::Exposed::unpack_forward(int, int first, const double *buf)
{
  int m = 0;
  const int end = static_cast<int>(ubuf(buf[m++]).i);
  while (m < end) {
    const int i = first + static_cast<int>(ubuf(buf[m++]).i);
    HexPod h;
    memcpy(static_cast<void *>(&h), &buf[m], sizeof(HexPod));
    m += HEX_SIZE;
    passing[i].push_back(h);
  }
}

/* ----------------------------------------------------------------------
   a node may be here more than once, as ghosts on either side
------------------------------------------------------------------------- */

void DefeSurfaceSearch::Exposed::keep()
{
  for (const auto &at : passing) {
    auto &list = of_others[atom->tag[at.first]];
    for (const auto &h : at.second) {
      const auto known = std::find_if(list.begin(), list.end(), [&h](const HexPod &one) {
        return one.id == h.id;
      });
      if (known == list.end())
        list.push_back(h);
      else
        *known = h;
    }
  }
  passing.clear();
}

void DefeSurfaceSearch::Exposed::forget(const defe::ConvertingHex &gone)
{
  const auto at = of_others.find(static_cast<tagint>(gone.node[0]));
  if (at == of_others.end()) return;
  auto &list = at->second;
  list.erase(std::remove_if(list.begin(), list.end(),
                            [&gone](const HexPod &one) {
                              return one.id == gone.id;
                            }),
             list.end());
  if (list.empty()) of_others.erase(at);
}
