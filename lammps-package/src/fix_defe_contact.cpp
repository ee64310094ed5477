/* ----------------------------------------------------------------------
   DEFE: adaptive finite elements to bonded discrete elements for LAMMPS
   https://www.lammps.org/
   This software is distributed under the GNU General Public License.

   Contact of surfaces: what the search and the forces in coupling (surface_search.h,
   surface_forces.h) work on, and what they found, booked and reported. Facets of other ranks'
   elements come with the ghosts of the elements' first nodes; forces on balls go back with theirs.
------------------------------------------------------------------------- */

#include "fix_defe.h"

#include "atom.h"
#include "comm.h"
#include "domain.h"
#include "error.h"
#include "force.h"
#include "neighbor.h"
#include "update.h"

#include "defe/coupling/surface_contact.h"
#include "defe/coupling/surface_search.h"

#include <algorithm>
#include <cmath>
#include <deque>
#include <tuple>
#include <unordered_map>
#include <utility>

using namespace LAMMPS_NS;
using defe::Vec3;

// A ball may begin this deep in a face, in radii: a rounding of the mesh or a ball that rests, not a mistake.
static constexpr double BALL_SHARE = 0.01;

// overlaps from before the first step are eased out within this many stable steps of the elements
static constexpr double EASE_STEPS = 2000.0;

namespace LAMMPS_NS {

/** Lets the search see the mesh and the DEs of this rank and what comes from the ranks around; once per
    reneighbouring. */
class DefeSurfaceSearch : private defe::SurfaceTies {
 public:
  explicit DefeSurfaceSearch(FixDefe *host) :
      fix(*host), atom(host->atom), domain(host->domain), jt(host->jt)
  {
  }
  void run();

 private:
  FixDefe &fix;
  Atom *atom;
  Domain *domain;
  const JointTable &jt;
  defe::SurfaceSearch search;
  defe::SurfaceScene scene;
  std::deque<std::array<int, 8>> ghost_idx;
  bool born_loose = false;    // ties hold nothing

  void gather_elements();
  void gather_ghost_elements();
  void add_element(const HexPod &, const int *idx);
  void gather_des();
  void gather_parts();
  bool lasting(int de, int part, std::int64_t element) const override;
  double tied_face(int de, int part) const override;
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

void DefeSurfaceSearch::run()
{
  const bool any = atom->nlocal + atom->nghost > 0;
  auto &all = scene.particles;
  all.nlocal = atom->nlocal;
  all.nall = atom->nlocal + atom->nghost;
  all.x = any ? &atom->x[0][0] : nullptr;
  all.X = any ? &fix.xframe[0][0] : nullptr;
  all.radius = atom->radius;
  all.id = atom->tag;

  scene.ties = this;
  scene.factor = fix.contact_factor;
  scene.skin = fix.neighbor->skin;
  scene.element_size = fix.max_diagonal;
  born_loose = fix.force->pair_match("defe/contact", 1) != nullptr;
  gather_parts();
  gather_elements();
  gather_des();
  search.run(scene, fix.surface);
  fix.pack_facet_nodes();
  fix.planes_fresh = true;
}

void DefeSurfaceSearch::gather_parts()
{
  scene.parts.clear();
  for (const auto &part : fix.parts) {
    const auto &m = fix.material_of(part);
    scene.parts.push_back({m.rigid(), m.elastic().bulk()});
  }
}

void DefeSurfaceSearch::gather_des()
{
  auto &des = scene.des;
  des.count = jt.nde;
  des.particle = jt.self.data();
  des.distance = fix.outer_reach.data();
  des.length = fix.outer_length.data();
  des.part.resize(jt.nde);
  des.area.resize(jt.nde);
  for (int d = 0; d < jt.nde; d++) {
    des.part[d] = jt.rec[d]->part;
    des.area[d] = jt.rec[d]->outer_area;
  }
}

// on this rank DEs of the scene are those of the joint table
bool DefeSurfaceSearch::lasting(int de, int part, std::int64_t element) const
{
  return !born_loose && !fix.adhesive_of(jt.rec[de]->part, part) &&
      fix.tied(jt.self[de], static_cast<tagint>(element));
}

double DefeSurfaceSearch::tied_face(int de, int part) const
{
  double nearest = HUGE_VAL;
  for (const auto &slot : jt.rec[de]->slot)
    if (slot.kind == DefeJoint::TIE && slot.part == part)
      nearest = std::min(nearest, Vec3(slot.face).dot(Vec3(slot.normal)));
  return nearest;
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

void DefeSurfaceSearch::gather_elements()
{
  const bool ghosts = fix.comm->nprocs > 1 || domain->xperiodic || domain->yperiodic ||
      domain->zperiodic;
  scene.elements.clear();
  ghost_idx.clear();
  scene.elements.reserve(fix.exposed.size());
  for (const auto &e : fix.exposed) {
    const auto &b = fix.batches[e.first];
    add_element(*b.hex[e.second], b.node[e.second].data());
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
    if (s.first >= atom->nlocal) anchors.push_back(s.first);
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
        complete = (Vec3(xframe[idx[a]]) - Vec3(xframe[anchor])).squaredNorm() <
            1.01 * fix.max_diagonal * fix.max_diagonal;
      }
      // otherwise it is farther away than anything of mine can touch
      if (!complete) continue;
      ghost_idx.push_back(idx);
      add_element(h, ghost_idx.back().data());
    }
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
  auto arrays = surface_arrays();
  arrays.changed = contact_to_book;
  const auto r = defe::surface_forces(surface, arrays, memory);
  contact_energy = r.energy + r.springs;
  if (r.beyond >= 0) beyond_grid = r.beyond;
  ledger.friction += r.friction;
  ledger.external += r.eased;
  for (int k = 0; k < 6; k++) virial_fe[k] += r.virial[k];
  book_contacts(r);
  if (contact_to_book) {
    ledger.conv_strain -= r.energy - r.eased;
    contact_to_book = false;
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
   energies that an evaluation of contacts has found to be gone or to come from elsewhere
------------------------------------------------------------------------- */

void FixDefe::book_contacts(const defe::SurfaceResult &r)
{
  // what a broken tie held is still here
  for (const auto &one : r.inherited)
    if (!touches(one.atom)->fresh) ledger.release -= one.energy;
  for (const auto &t : r.let_through) {
    ledger.through += t.energy;
    if (t.counts) note_let_through(t.atom, t.depth);
  }
}

/* ----------------------------------------------------------------------
   energy of contact at the positions now, with the tables of before a conversion
------------------------------------------------------------------------- */

double FixDefe::contact_energy_now()
{
  update_planes();
  planes_fresh = false;
  DefeContactMemory memory(this);
  auto arrays = surface_arrays();
  arrays.energy_only = true;
  const auto r = defe::surface_forces(surface, arrays, memory);
  book_contacts(r);
  return r.energy;
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

void FixDefe::ball_shares(const defe::ConversionPlan &plan, std::vector<BallShare> &shares)
{
  for (const auto &pair : surface.balls) {
    const auto &facet = surface.facets[pair.facet];
    const auto element = static_cast<tagint>(facet.element);
    if (!facet.outer || !plan.converting(element)) continue;
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
