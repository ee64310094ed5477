/* ----------------------------------------------------------------------
   DEFE: adaptive finite elements to bonded discrete elements for LAMMPS
   https://www.lammps.org/
   This software is distributed under the GNU General Public License.
------------------------------------------------------------------------- */

// Conversion of elements into discrete elements: coupling plans it (conversion_plan.h), here it is carried
// out.

#include "defe_system.h"
#include "lammps_releases.h"

#include "atom.h"
#include "atom_vec.h"
#include "comm.h"
#include "domain.h"
#include "error.h"
#include "group.h"
#include "irregular.h"
#include "modify.h"
#include "region.h"
#include "update.h"

#include "defe/fe/hex8.h"

#include <Eigen/LU>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <memory>

using namespace LAMMPS_NS;
using defe::Vec3;
using defe::fe::HexCoords;

DefeConversion::DefeConversion(DefeSystem &system) : DefeComponent(system), marked(system) {}

/** An element of this rank that converts. */
struct DefeConversion::Own {
  HexRecord *hex;
  const defe::ConvertingHex *planned;
  const std::array<int, 8> *idx;
  const defe::fe::HexKernel *kernel;
};

/** One conversion, of all ranks together. */
struct DefeConversion::Draft {
  /** What an atom is made of; small, since all elements of a rank may convert at once. */
  struct Birth {
    std::unique_ptr<DERecord> record;    // the one that it keeps
    Vec3 X, x, v, omega;
    double mass, radius, strength;    // the last by its flaws
    std::unique_ptr<const defe::Mat3> prestress;
    DefeTiedDEs::List tied;
    tagint tag, node;    // node of the element beside it, 0: none
    imageint image;
  };
  std::vector<Own> own;    // by ID
  std::unique_ptr<const defe::ConversionPlan> plan;
  std::vector<DefeSurface::BallShare> from_balls;
  std::vector<Birth> births;
};

/* ----------------------------------------------------------------------
   first setup of a run: what is to be discrete from the start converts
------------------------------------------------------------------------- */

void DefeConversion::convert_start()
{
  if (start_done_) return;
  start_done_ = true;
  if (!any_start()) return;
  sys.ghosts.make_for_setup();
  sys.tables.build();
  mark_start();
  convert();
  sys.ghosts.provide(0.0);
}

bool DefeConversion::any_start() const
{
  bool any = false;
  for (const auto &p : sys.model.parts) {
    if (p.start.empty()) continue;
    any = true;
    if (p.start == "all") continue;
    auto region = domain->get_region_by_id(p.start);
    if (!region)
      error->all(FLERR, "Fix defe convert {}: start region {} does not exist any more", p.name,
                 p.start);
    region->prematch();
  }
  return any;
}

void DefeConversion::mark_start()
{
  const auto &batches = sys.elements.batches();
  for (size_t k = 0; k < batches.size(); k++) {
    const DefeBatch &b = batches[k];
    const DefePart &p = sys.model.parts[b.part()];
    if (!b.convertible || p.start.empty()) continue;
    for (int e = 0; e < b.size(); e++) {
      bool in = (p.start == "all");
      if (!in) {
        auto region = domain->get_region_by_id(p.start);
        double c[3] = {0.0, 0.0, 0.0};
        for (int a = 0; a < 8; a++)
          for (int k = 0; k < 3; k++) c[k] += 0.125 * atom->x[b.nodes(e)[a]][k];
        domain->remap(c);
        in = region->match(c[0], c[1], c[2]) != 0;
      }
      if (in) sys.elements.mark(static_cast<int>(k), e);
    }
  }
}

/* ----------------------------------------------------------------------
   a DE was tied to a face of an element that converts. If a joint to the DE at this place of it, behind that face, takes
   the place of the tie: 0; else the distance below which the two, which stay unbonded, are in contact.
   The ranks of both DEs compute the same answer.
------------------------------------------------------------------------- */

double DefeConversion::contact_distance_if_separated(int i, const tagint *face, int place, int side,
                                                     const HexCoords &element, int part) const
{
  Vec3 X[4], x[4];
  for (int k = 0; k < 4; k++) {
    const int j = sys.ids.nearest_to(i, face[k]);
    if (j < 0)
      error->one(FLERR,
                 "Node {} of the face that DE {} is tied to is missing on proc {} at step {}: it "
                 "was lost, or the communication cutoff is too small (raise it with comm_modify "
                 "cutoff)",
                 face[k], atom->tag[i], comm->me, update->ntimestep);
    X[k] = Vec3(sys.store.x_frame(j));
    x[k] = Vec3(atom->x[j]);
  }
  const DefePart &p = sys.model.parts[part];
  const double strain = p.stress / sys.model.material_of(p).elastic().E;
  if (defe::tie_rotation(Vec3(sys.store.x_frame(i)), Vec3(atom->x[i]), X, x,
                         p.split.spot(place, side)) < defe::tie_rotation_limit * strain)
    return 0.0;
  Vec3 between = defe::place_of_de(element, place, p.split) - Vec3(atom->x[i]);
  minimum_image(*domain, between.data());
  // a little less, so that rounding does not bring the two into contact in this very step on some numbers of
  // ranks only
  return (1.0 - 1.0e-9) * between.norm();
}

/* ----------------------------------------------------------------------
   every rank that has a node of an element that converts learns of it: the ranks that own its nodes
   have its first node as a ghost, and all others have one of these nodes
------------------------------------------------------------------------- */

void DefeConversion::tell_neighbours(std::vector<defe::ConvertingHex> &&mine)
{
  auto &converting = marked.converting;
  converting = std::move(mine);
  if (comm->nprocs == 1 && atom->nghost == 0) return;
  for (int hop = 0; hop < 2; hop++) {
    for (size_t k = 0; k < converting.size(); k++)
      for (int a = 0; a < (hop ? 8 : 1); a++) {
        const int i = sys.ids.local_of(converting[k].node[a]);
        if (i >= 0 && i < atom->nlocal) marked.at[i].emplace_back(static_cast<int>(k), a);
      }
    int most = 0, rounds = 0;
    for (const auto &at : marked.at) most = MAX(most, static_cast<int>(at.second.size()));
    MPI_Allreduce(&most, &rounds, 1, MPI_INT, MPI_MAX, world);
    for (marked.round = 0; marked.round < rounds; marked.round++)
      sys.ghosts.forward(marked, MARKED_SIZE);
    marked.at.clear();

    // one of each: this rank's own are the first

    std::stable_sort(converting.begin(), converting.end(), [](const auto &a, const auto &b) {
      return a.id < b.id;
    });
    converting.erase(std::unique(converting.begin(), converting.end(),
                                 [](const auto &a, const auto &b) {
                                   return a.id == b.id;
                                 }),
                     converting.end());
  }
}

int DefeConversion::Marked::pack_forward(int n, const int *list, const double *, double *buf)
{
  int m = 1;
  for (int ii = 0; ii < n && !at.empty(); ii++) {
    const auto found = at.find(list[ii]);
    if (found == at.end() || round >= static_cast<int>(found->second.size())) continue;
    // positions from the atom that it goes with, so that no image matters
    const auto which = found->second[round];
    const defe::ConvertingHex &c = converting[which.first];
    buf[m++] = ubuf(ii).d;
    buf[m++] = ubuf(c.id).d;
    buf[m++] = ubuf(c.lot).d;
    for (auto t : c.node) buf[m++] = ubuf(t).d;
    for (const auto &xa : c.x)
      // bit for bit, they are those of the element's first node: who uses them takes the nearest image
      for (int k = 0; k < 3; k++)
        buf[m++] = sys.model.reproducible ? xa[k] : xa[k] - c.x[which.second][k];
  }
  buf[0] = ubuf(m).d;
  return m;
}

void DefeConversion::Marked::unpack_forward(int, int first, const double *buf)
{
  const Atom *atom = sys.lmp->atom;
  int m = 0;
  const int end = static_cast<int>(ubuf(buf[m++]).i);
  while (m < end) {
    const int i = first + static_cast<int>(ubuf(buf[m++]).i);
    defe::ConvertingHex c;
    c.id = static_cast<tagint>(ubuf(buf[m++]).i);
    c.lot = static_cast<tagint>(ubuf(buf[m++]).i);
    for (auto &t : c.node) t = ubuf(buf[m++]).i;
    for (auto &xa : c.x)
      for (int k = 0; k < 3; k++)
        xa[k] = sys.model.reproducible ? buf[m++] : atom->x[i][k] + buf[m++];
    const auto *corner = std::find(std::begin(c.node), std::end(c.node), atom->tag[i]);
    at[i].emplace_back(static_cast<int>(converting.size()),
                       static_cast<int>(corner - std::begin(c.node)));
    converting.push_back(c);
  }
}

/* ----------------------------------------------------------------------
   one conversion, of all ranks together
------------------------------------------------------------------------- */

void DefeConversion::convert()
{
  sys.ghosts.update_positions();
  sys.marks.mark_asked();
  sys.marks.done();
  convert_marked();
}

bool DefeConversion::convert_in_place()
{
  if (!sys.in_place.allowed()) return false;
  sys.ghosts.update_positions();
  sys.marks.mark_asked();
  if (!sys.in_place.possible()) return false;
  sys.marks.done();
  sys.in_place.begin();
  convert_marked();
  sys.in_place.make_tables();
  sys.in_place.end();
  return true;
}

void DefeConversion::convert_marked()
{
  sys.checks.note_energy_in_walls();
  sys.surface.begin_conversion();

  Draft c;
  collect_marked(c);
  sys.surface.ball_shares(*c.plan, c.from_balls);
  sys.surface.elements_gone(c.plan->all());
  for (const auto &o : c.own) {    // strain energy before
    HexCoords xe, Xe;
    sys.elements.kernel_coords(*o.hex, o.idx->data(), xe, Xe);
    sys.ledger.conv_strain += o.kernel->energy(xe, Xe);
  }
  sys.tied.end(*c.plan);
  sys.tied_des.book(*c.plan);
  ties_to_joints(*c.plan);
  update_beside(*c.plan);

  loss.begin(atom->nlocal + atom->nghost);
  size_t born = 0;
  for (const auto &o : c.own) born += sys.model.parts[o.hex->part].split.des();
  c.births.reserve(born);
  for (const auto &o : c.own) {
    add_births(c, o);
    record_conversion(o);
  }
  sys.tied.warn();
  sys.tied_des.replace_ends(*c.plan);
  const bigint nodes_gone = remove_converted(c);
  if (sys.in_place.going_on()) sys.in_place.make_room(static_cast<int>(c.births.size()));
  create_des(c);
  if (sys.in_place.going_on()) sys.in_place.tell();
  const size_t converted = c.own.size();
  c = Draft();    // before LAMMPS moves atoms
  finish(static_cast<bigint>(converted), nodes_gone, static_cast<bigint>(born));
}

void DefeConversion::record_conversion(const Own &o)
{
  defe::Event e{};
  e.step = update->ntimestep;
  e.time = sys.clock.now();
  e.what = defe::EventKind::CONVERT;
  e.a = o.hex->id;
  e.b = o.hex->part + 1;
  HexCoords xe, Xe;
  sys.elements.coords(o.idx->data(), xe, Xe);
  const Vec3 centre = Xe.rowwise().mean();
  domain->unmap(centre.data(), atom->image[(*o.idx)[0]], e.x);    // never wrapped
  e.value = sys.model.element_mass(sys.model.parts[o.hex->part], o.hex->volume);
  sys.events.record(e);
}

/* ----------------------------------------------------------------------
   every rank learns which elements near its own convert now
------------------------------------------------------------------------- */

void DefeConversion::collect_marked(Draft &c)
{
  double **x = atom->x;
  for (const auto &one : sys.elements.marked()) {
    const DefeBatch &b = sys.elements.batches()[one.first];
    c.own.push_back({b.hex[one.second], nullptr, &b.nodes(one.second), &b.kernel()});
  }
  std::sort(c.own.begin(), c.own.end(), [](const auto &p, const auto &q) {
    return p.hex->id < q.hex->id;
  });
  std::vector<tagint> ids;
  for (const auto &o : c.own) ids.push_back(o.hex->id);
  const auto lots = sys.ids.deal_lots(ids);
  std::vector<defe::ConvertingHex> mine(c.own.size());
  for (size_t k = 0; k < c.own.size(); k++) {
    mine[k].id = ids[k];
    mine[k].lot = lots[k];
    for (int a = 0; a < 8; a++) {
      mine[k].node[a] = c.own[k].hex->node[a];
      for (int d = 0; d < 3; d++) mine[k].x[a][d] = x[(*c.own[k].idx)[a]][d];
    }
  }
  tell_neighbours(std::move(mine));
  c.plan = std::make_unique<const defe::ConversionPlan>(
      sys.ids.base(), std::move(marked.converting), sys.model.lot_size());
  for (auto &o : c.own) o.planned = c.plan->converting(o.hex->id);
}

/* ----------------------------------------------------------------------
   DEs that are tied to elements that convert get joints instead of ties
------------------------------------------------------------------------- */

void DefeConversion::ties_to_joints(const defe::ConversionPlan &plan)
{
  int last = -1;
  for (const auto &tied : sys.tables.tied()) {
    const int d = tied.de;
    if (d == last || !plan.converting(tied.element)) continue;
    last = d;
    DERecord &r = *sys.joints.rec(d);
    if (!r.newborn) sys.ledger.conv_strain += sys.tables.de_energy(d, sys.joints.present[d]);
    r.newborn = 1;
    bool tied_still = false;
    for (int s = 0; s < 6; s++) {
      JointRecord &slot = r.slot[s];
      if (slot.kind != DefeJoint::TIE) continue;
      const auto *converts = plan.converting(r.other[s]);
      tied_still = tied_still || !converts;
      if (!converts) continue;
      const int place = sys.model.parts[slot.part].split.place_of_code(slot.corner);
      const double distance = contact_distance_if_separated(
          sys.joints.self[d], r.tie->of[s], place, slot.partner, converts->coords(), slot.part);
      r.set_contact_distance(s, distance);
      if (distance > 0.0) slot.state = DefeJoint::CONTACT;
      slot.asks = 0;
      slot.kind = DefeJoint::DE;
      r.other[s] = static_cast<tagint>(plan.joint_of_tie(r.other[s], place));
    }
    if (!tied_still) r.tie.reset();
  }
}

/* ----------------------------------------------------------------------
   elements beside them: the face behind is free now, and the crack shields them
------------------------------------------------------------------------- */

void DefeConversion::update_beside(const defe::ConversionPlan &plan)
{
  std::vector<int> at;    // nodes of elements that convert, and their images
  plan.for_nodes([&](tagint node) {
    for (int i = sys.ids.local_of(node); i >= 0; i = atom->sametag[i]) at.push_back(i);
  });
  sys.elements.for_elements_at(at, [&](int batch, int e) {
    const DefeBatch &b = sys.elements.batches()[batch];
    HexRecord &h = *b.hex[e];
    if (plan.converting(h.id)) return;
    const auto &idx = b.nodes(e);
    bool bare = false;
    for (tagint &nb : h.nb) {
      const auto now = static_cast<tagint>(plan.behind_now(nb));
      bare = bare || now != nb;
      nb = now;
    }
    if (bare) {
      sys.store.touch(idx[0]);
      sys.surface.element_beside(h);
    }
    if (b.convertible && sys.model.shield) add_shields(plan, h, idx);
  });
}

void DefeConversion::add_shields(const defe::ConversionPlan &plan, HexRecord &h,
                                 const std::array<int, 8> &idx)
{
  const auto around = plan.around(h.node);
  if (around.empty()) return;
  Vec3 centre = Vec3::Zero();
  for (int i : idx)
    for (int k = 0; k < 3; k++) centre[k] += 0.125 * atom->x[i][k];
  for (const auto *c : around) {
    Vec3 del = defe::direction_to(*c, centre);
    for (int k = 0; k < 3; k++)
      if (domain->periodicity[k]) del[k] -= domain->prd[k] * std::round(del[k] / domain->prd[k]);
    h.with_extra().shields.push_back({del, sys.clock.now()});
  }
  // at most one entry per neighbour: the oldest ones have had their time
  auto &list = h.extra->shields;
  if (list.size() > 26) list.erase(list.begin(), list.end() - 26);
}

/* ----------------------------------------------------------------------
   the DEs of one element, and what its nodes lose
------------------------------------------------------------------------- */

void DefeConversion::add_births(Draft &c, const Own &o)
{
  const HexRecord &h = *o.hex;
  const auto &idx = *o.idx;
  HexCoords Xe, xe, ve;
  sys.elements.coords(idx.data(), xe, Xe);
  for (int a = 0; a < 8; a++)
    for (int k = 0; k < 3; k++) ve(k, a) = atom->v[idx[a]][k];
  const double mass = sys.model.element_mass(sys.model.parts[h.part], h.volume);
  for (int i : idx) loss.add(i, defe::ConversionPlan::node_share * mass, 1);
  const auto split = sys.model.parts[h.part].split;
  const auto all = defe::convert_hex(Xe, xe, ve, mass, split);
  sys.ledger.conv_kinetic += defe::conversion_kinetic_loss(ve, mass, all);

  defe::HexNeighbors neighbors;
  for (int f = 0; f < 6; f++) {
    neighbors.behind[f] = h.nb[f];
    neighbors.face[f] = h.nbface[f];
    neighbors.rotation[f] = h.nbrot[f];
    neighbors.part[f] = h.nbpart[f];
  }
  neighbors.tied = sys.tied_des.faces(idx[0], h.id);
  const auto planned = c.plan->births(*o.planned, neighbors, all, split);
  const auto *strengths = sys.strengths.of_places(idx[0], h);
  const defe::Mat3 *prestress = sys.prestress.of_element(idx[0], h);
  for (int k = 0; k < split.des(); k++) {
    Draft::Birth birth;
    birth.X = all[k].X;
    birth.x = all[k].x;
    birth.v = all[k].v;
    birth.omega = all[k].omega;
    birth.mass = all[k].mass;
    birth.radius = all[k].radius;
    birth.strength = strengths ? (*strengths)[k] : HUGE_VAL;
    if (prestress) birth.prestress = std::make_unique<const defe::Mat3>(*prestress);
    birth.node = split.node_at(k) < 0 ? 0 : h.node[split.node_at(k)];
    birth.image = atom->image[idx[0]];    // positions are in the frame of that node
    birth.tag = static_cast<tagint>(planned[k].id);
    birth.record = std::make_unique<DERecord>();
    DERecord &r = *birth.record;
    fill_record(r, all[k], planned[k]);
    r.element = h.id;
    r.corner = static_cast<short>(k);
    r.part = static_cast<short>(h.part);
    r.lot = static_cast<tagint>(o.planned->lot);
    for (int s = 0; s < 6; s++)
      if (planned[k].slot[s].to_older)
        break_joint_to_older(birth.tag, r, s, planned[k], all[k], idx, xe);
    if (neighbors.tied) {
      const Vec3 xi = split.centre(k);
      bool lost = false;
      birth.tied = sys.tied_des.born(
          idx[0], h.id, all[k], defe::fe::jacobian(xe, xi) * defe::fe::jacobian(Xe, xi).inverse(),
          lost);
      sys.tied_des.replace_ends(*c.plan, birth.tied);
      if (lost) sys.tied.let_go(h.id);
    }
    c.births.push_back(std::move(birth));
  }
}

/* ----------------------------------------------------------------------
   record of a DE as it is planned
------------------------------------------------------------------------- */

void DefeConversion::fill_record(DERecord &r, const defe::NewDE &de, const defe::PlannedDE &planned)
{
  static_assert(static_cast<int>(defe::PlannedSlot::JOINT) == DefeJoint::DE &&
                    static_cast<int>(defe::PlannedSlot::TIE) == DefeJoint::TIE,
                "the same kinds");
  r.volume = de.volume;
  r.newborn = r.fresh = 1;
  r.outer_distance = planned.outer_distance;
  r.outer_area = planned.outer_area;
  for (int s = 0; s < 6; s++) {
    const auto &plan = planned.slot[s];
    JointRecord &slot = r.slot[s];
    const double area = de.area[s];
    slot.area = area;
    for (int c = 0; c < 3; c++) {
      slot.face[c] = de.face[s][c];
      slot.normal[c] = area > 0.0 ? de.area_normal[s][c] / area : 0.0;
    }
    slot.state = DefeJoint::CONNECTIVE;
    slot.kind = plan.kind;
    r.other[s] = static_cast<tagint>(plan.other);
    slot.partner = plan.partner;
    slot.corner = plan.corner;
    slot.part = plan.part;
    if (plan.kind != defe::PlannedSlot::TIE) continue;
    if (!r.tie) r.tie = std::make_unique<TieNodes>();
    for (int c = 0; c < 4; c++) r.tie->of[s][c] = static_cast<tagint>(plan.face_node[c]);
  }
}

/* ----------------------------------------------------------------------
   a joint to a DE that was tied to the element: if the tie has rotated too far, it is broken from the start
------------------------------------------------------------------------- */

void DefeConversion::break_joint_to_older(tagint tag, DERecord &r, int s,
                                          const defe::PlannedDE &planned, const defe::NewDE &de,
                                          const std::array<int, 8> &idx, const HexCoords &element)
{
  JointRecord &slot = r.slot[s];
  const int near = sys.model.parts[r.part].split.first_on_face(r.corner, s);
  const int j = sys.ids.nearest_to(idx[defe::fe::hex_face[s][near]], r.other[s]);
  if (j < 0) return;    // deleted
  tagint face_node[4];
  for (int c = 0; c < 4; c++) face_node[c] = static_cast<tagint>(planned.slot[s].face_node[c]);
  r.set_contact_distance(s,
                         contact_distance_if_separated(j, face_node, r.corner, s, element, r.part));
  if (!(r.contact_distance(s) > 0.0)) return;
  slot.state = DefeJoint::CONTACT;
  defe::Event e{};
  e.step = update->ntimestep;
  e.time = sys.clock.now();
  e.what = defe::EventKind::BROKEN;
  e.a = MIN(tag, r.other[s]);
  e.b = MAX(tag, r.other[s]);
  const Vec3 middle = 0.5 * (de.X + Vec3(sys.store.x_frame(j)));
  domain->unmap(middle.data(), atom->image[idx[0]], e.x);
  for (int c = 0; c < 3; c++) e.n[c] = slot.normal[c];
  e.value = 1.0;
  sys.events.record(e);
  sys.account.note_damage();
}

/* ----------------------------------------------------------------------
   the elements go, and nodes that have none any more; returns how many nodes of this rank
------------------------------------------------------------------------- */

bigint DefeConversion::remove_converted(const Draft &c)
{
  sys.ghosts.reverse(loss, 2);
  take_losses();
  if (!sys.in_place.going_on())
    atom->map_clear();    // before atoms go: LAMMPS clears the places of those only that it has
  for (const auto &o : c.own) {
    auto &list = sys.store.hexes((*o.idx)[0]);
    sys.store.touch((*o.idx)[0]);
    list.erase(std::find_if(list.begin(), list.end(), [&o](const HexRecord &h) {
      return h.id == o.planned->id;
    }));
    sys.strengths.remove((*o.idx)[0], o.planned->id);
    sys.prestress.remove((*o.idx)[0], o.planned->id);
    sys.tied_des.remove((*o.idx)[0], o.planned->id);
  }
  return delete_nodes();
}

void DefeConversion::Loss::begin(int n)
{
  for (int i : nodes) {
    mass[i] = 0.0;
    count[i] = 0;
  }
  nodes.clear();
  if (static_cast<size_t>(n) > mass.capacity()) {
    mass.reserve(DefeInPlace::roomy(n));
    count.reserve(DefeInPlace::roomy(n));
  }
  mass.resize(n, 0.0);
  count.resize(n, 0);
}

void DefeConversion::Loss::add(int i, double m, int n)
{
  if (count[i] == 0) nodes.push_back(i);
  mass[i] += m;
  count[i] += n;
}

int DefeConversion::Loss::pack_reverse(int n, int first, double *buf)
{
  int m = 0;
  for (int i = first; i < first + n; i++) {
    buf[m++] = mass[i];
    buf[m++] = count[i];
  }
  return m;
}

void DefeConversion::Loss::unpack_reverse(int n, const int *list, const double *buf)
{
  int m = 0;
  for (int ii = 0; ii < n; ii++, m += 2) {
    const int lost = static_cast<int>(std::lround(buf[m + 1]));
    if (lost > 0) add(list[ii], buf[m], lost);
  }
}

void DefeConversion::take_losses()
{
  std::sort(loss.nodes.begin(), loss.nodes.end());
  for (int i : loss.nodes) {
    if (i >= atom->nlocal) break;
    const int left = sys.store.elements_at(i) - loss.count[i];
    sys.store.set_elements_at(i, left);
    atom->rmass[i] -= loss.mass[i];
    if (left < 0)
      error->one(FLERR, "Fix defe: node {} lost more elements than it had", atom->tag[i]);
    if (left == 0 ? std::abs(atom->rmass[i]) > 1.0e-6 * loss.mass[i] : !(atom->rmass[i] > 0.0))
      error->one(FLERR,
                 "Node {} does not have the mass of its elements when they convert at step {}: do "
                 "not change masses of nodes with 'set', change the density of the material",
                 atom->tag[i], update->ntimestep);
  }
}

bigint DefeConversion::delete_nodes()
{
  bigint nodes_gone = 0;
  int n = atom->nlocal;
  for (auto node = loss.nodes.rbegin(); node != loss.nodes.rend(); ++node) {    // from the last one
    const int i = *node;
    if (i < atom->nlocal && sys.store.elements_at(i) == 0) {
      nodes_gone++;
      if (const auto *t = sys.store.contacts_of(i))
        for (const auto &face : t->faces)
          sys.ledger.friction += face.tangential.stored();    // let go
      const bool in_place = sys.in_place.going_on();
      if (in_place) sys.in_place.remove(i);
      if (i != n - 1)
        atom->avec->copy(n - 1, i, 1);
      else
        sys.store.forget(i);
      if (in_place && i != n - 1) sys.in_place.moved(n - 1, i);
      n--;
    }
  }
  atom->nlocal = n;
  return nodes_gone;
}

/* ----------------------------------------------------------------------
   atoms for the new DEs
------------------------------------------------------------------------- */

void DefeConversion::create_des(Draft &c)
{
  for (auto &b : c.births) {
    const DefePart &p = sys.model.parts[b.record->part];
    double xnew[3] = {b.x[0], b.x[1], b.x[2]};
    atom->avec->create_atom(p.type, xnew);
    const int i = atom->nlocal - 1;
    atom->tag[i] = b.tag;
    atom->mask[i] = 1 | group->bitmask[p.group];
    atom->radius[i] = b.radius;
    atom->rmass[i] = b.mass;
    for (int k = 0; k < 3; k++) {
      atom->v[i][k] = b.v[k];
      atom->omega[i][k] = b.omega[k];
    }
    sys.ids.giving_birth(true);
    modify->create_attribute(i);
    sys.ids.giving_birth(false);
    atom->image[i] = b.image;
    double ref[3];
    domain->unmap(b.X.data(), b.image, ref);
    sys.store.set_reference(i, ref);
    const tagint element = b.record->element;
    sys.store.set_de(i, std::move(b.record));
    sys.strengths.set_de(i, b.strength);
    if (b.prestress) sys.prestress.set_de(i, *b.prestress);
    sys.tied_des.set_de(i, b.tied);
    take_ball_shares(i, c, element, b.node, p.split.des() == 1);
  }
}

/* ----------------------------------------------------------------------
   what balls had pressed on the element at the node beside a DE; a single DE takes that of all nodes
------------------------------------------------------------------------- */

void DefeConversion::take_ball_shares(int i, const Draft &c, tagint element, tagint node,
                                      bool of_all_nodes)
{
  const auto &shares = c.from_balls;
  const DefeSurface::BallShare first{element, of_all_nodes ? 0 : node, 0, 0.0, 0.0};
  auto share =
      std::lower_bound(shares.begin(), shares.end(), first, [](const auto &p, const auto &q) {
        return p.element != q.element ? p.element < q.element : p.node < q.node;
      });
  if (share == shares.end() || share->element != element) return;
  auto &list = sys.store.contacts_at(i).spheres;
  for (;
       share != shares.end() && share->element == element && (of_all_nodes || share->node == node);
       ++share) {
    auto known = std::find_if(list.begin(), list.end(), [share](const SphereContact &one) {
      return one.other == share->ball;
    });
    if (known == list.end()) known = list.insert(known, {share->ball, {}, 0.0, 0.0, 0.0});
    known->inherit += share->energy;
    known->push += share->push;
  }
}

/* ----------------------------------------------------------------------
   totals
------------------------------------------------------------------------- */

void DefeConversion::finish(bigint converted, bigint nodes_gone, bigint born)
{
  bigint mine[4] = {atom->nlocal, converted, nodes_gone, born}, all[4];
  MPI_Allreduce(mine, all, 4, MPI_LMP_BIGINT, MPI_SUM, world);
  atom->natoms = all[0];
  sys.ids.set_natoms(all[0]);
  sys.census.convert(all[1], all[2], all[3]);
  if (all[1] > 0) sys.account.note_conversion();
  marked.converting = {};
  if (!sys.in_place.going_on()) leave_to_reneighbouring(static_cast<int>(born));
  sys.tables.forget();
}

/* ----------------------------------------------------------------------
   local indices are invalid until then, and the map of atoms is empty: borders() fills it. A DE may be born up to 3/4 of an
   element outside the sub-domain of its element, and LAMMPS' exchange moves atoms by one sub-domain only.
------------------------------------------------------------------------- */

void DefeConversion::leave_to_reneighbouring(int born)
{
  atom->nghost = 0;
  sys.ids.make_room_in_map(born);
  int thin = 0, any = 0;
  for (int d = 0; d < 3; d++) {
    const double width = domain->subhi[d] - domain->sublo[d];
    if (width < domain->prd[d] && width < sys.mesh.max_diagonal()) thin = 1;
  }
  MPI_Allreduce(&thin, &any, 1, MPI_INT, MPI_MAX, world);
  if (!any) return;
  domain->pbc();
  if (domain->nonperiodic == 2) domain->reset_box();
  Irregular irregular(lmp);
  irregular.migrate_atoms(1);
}
