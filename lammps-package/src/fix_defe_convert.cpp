/* ----------------------------------------------------------------------
   DEFE: adaptive finite elements to bonded discrete elements for LAMMPS
   https://www.lammps.org/
   This software is distributed under the GNU General Public License.

   Conversion of elements into discrete elements, in pre_exchange of the step after
   the criterion was met: LAMMPS then migrates the new atoms and rebuilds its lists.
------------------------------------------------------------------------- */

#include "fix_defe.h"

#include "atom.h"
#include "atom_vec.h"
#include "comm.h"
#include "domain.h"
#include "error.h"
#include "group.h"
#include "irregular.h"
#include "modify.h"
#include "update.h"

#include "defe/coupling/conversion_plan.h"
#include "defe/fe/hex8.h"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <unordered_map>

using namespace LAMMPS_NS;
using defe::Vec3;
using defe::fe::HexCoords;

double FixDefe::now() const
{
  return update->atime + (update->ntimestep - update->atimestep) * update->dt;
}

/* ----------------------------------------------------------------------
   on a reneighbouring step LAMMPS does not update ghosts: they still are where
   they were a step ago. Fresh positions and velocities for what follows.
------------------------------------------------------------------------- */

void FixDefe::ghost_positions()
{
  comm_mode = POSVEL;
  comm->forward_comm(this, 6);
}

/* ----------------------------------------------------------------------
   strain energy of the corners of one owned DE at the current positions
------------------------------------------------------------------------- */

double FixDefe::de_energy(int d, unsigned present, Vec3 *half_force) const
{
  double **x = atom->x;
  const int i = jt.self[d];
  defe::Vec3 y[6], hf[6];
  for (int s = 0; s < 6; s++) {
    y[s].setZero();
    if (!(present & (1u << s))) continue;
    const int nb = jt.nb[d][s];
    if (nb >= 0) {
      for (int k = 0; k < 3; k++) y[s][k] = x[nb][k] - x[i][k];
    } else {
      const auto &node = jt.tie_node[~nb];
      for (int k = 0; k < 3; k++) {
        double p = 0.0;
        for (int a = 0; a < 4; a++) p += defe::tie_weight[a] * x[node[a]][k];
        y[s][k] = p - x[i][k];
      }
    }
  }
  const auto &moduli = corner_moduli[jt.material[d]];
  if (d >= jt.north)
    return defe::corner_strain_general(jt.cell[d - jt.north], y, present, moduli,
                                       half_force ? half_force : hf);

  // one orthogonal DE: neighbours as points of its own

  double xs[21];
  for (int k = 0; k < 3; k++) xs[k] = 0.0;
  int nb[1][6];
  double len[1][6], half[1][6], force[1][6][3], energy[1];
  for (int s = 0; s < 6; s++) {
    nb[0][s] = s + 1;
    len[0][s] = jt.len[d][s];
    half[0][s] = jt.half[d][s];
    for (int k = 0; k < 3; k++) xs[3 * (s + 1) + k] = y[s][k];
  }
  const int self = 0;
  const auto bits = static_cast<unsigned char>(present);
  const defe::OrthogonalLattice one{1, &self, nb, &bits, len, half, nullptr};
  const double sum = defe::corner_strain_orthogonal(one, xs, nullptr, &moduli, force, energy);
  for (int s = 0; half_force && s < 6; s++) half_force[s] = Vec3(force[0][s]);
  return sum;
}

/* ----------------------------------------------------------------------
   a DE was tied to a face of an element that converts: 0 if a joint to the DE of that corner takes
   the place of the tie, else the distance of the two, which stay apart
   The ranks of both DEs ask, with the same answer.
------------------------------------------------------------------------- */

double FixDefe::distance_if_swung(int i, const tagint *face, int corner, const HexCoords &element,
                                  int part) const
{
  Vec3 X[4], x[4];
  for (int k = 0; k < 4; k++) {
    const int j = domain->closest_image(i, local_of(face[k]));
    if (j < 0)
      error->one(FLERR,
                 "Node {} of the face that DE {} is tied to is missing on proc {} at step {}: it "
                 "was lost, or the communication cutoff is too small (raise it with comm_modify "
                 "cutoff)",
                 face[k], atom->tag[i], comm->me, update->ntimestep);
    X[k] = Vec3(xframe[j]);
    x[k] = Vec3(atom->x[j]);
  }
  const Part &p = parts[part];
  const double strain = p.stress / material_of(p).elastic().E;
  if (defe::tie_swing(Vec3(xframe[i]), Vec3(atom->x[i]), X, x) < defe::swing_limit * strain)
    return 0.0;
  Vec3 apart = defe::place_of_de(element, corner) - Vec3(atom->x[i]);
  domain->minimum_image(apart.data());
  // less by what rounding cannot make up for: the two must not be in contact in this very step on
  // some numbers of ranks only
  return (1.0 - 1.0e-9) * apart.norm();
}

/* ----------------------------------------------------------------------
   every rank that has a node of an element that converts learns of it: the ranks that own its nodes
   have its first node as a ghost, and all others have one of these nodes
------------------------------------------------------------------------- */

void FixDefe::tell_neighbours(std::vector<defe::ConvertingHex> &&mine)
{
  converting = std::move(mine);
  if (comm->nprocs == 1 && atom->nghost == 0) return;
  comm_mode = MARKED;
  for (int hop = 0; hop < 2; hop++) {
    for (size_t k = 0; k < converting.size(); k++)
      for (int a = 0; a < (hop ? 8 : 1); a++) {
        const int i = local_of(converting[k].node[a]);
        if (i >= 0 && i < atom->nlocal) marked_at[i].emplace_back(static_cast<int>(k), a);
      }
    int most = 0, rounds = 0;
    for (const auto &at : marked_at) most = MAX(most, static_cast<int>(at.second.size()));
    MPI_Allreduce(&most, &rounds, 1, MPI_INT, MPI_MAX, world);
    for (comm_round = 0; comm_round < rounds; comm_round++) comm->forward_comm(this, MARKED_SIZE);
    marked_at.clear();

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

/* ----------------------------------------------------------------------
   elements that a crack wants to go on in (slot.asks), told by the DEs before them: the rank of an element
   has these as ghosts
------------------------------------------------------------------------- */

void FixDefe::mark_asked_elements()
{
  if (!cracks_ask) return;
  asked.clear();
  for (int ds : jt.asking) {
    const tagint element = jt.rec[ds / 6]->slot[ds % 6].other;
    asked_at[jt.self[ds / 6]].push_back(element);
    asked.insert(element);
  }
  if (comm->nprocs > 1 || atom->nghost > 0) {
    comm_mode = ASKED;
    comm->forward_comm(this, MARKED_SIZE);
  }
  asked_at.clear();
  if (asked.empty()) return;
  for (auto &b : batches)
    if (b.convertible)
      for (auto *h : b.hex)
        if (asked.count(h->id)) h->marked = 1;
}

/* ----------------------------------------------------------------------
   one conversion, of all ranks together
------------------------------------------------------------------------- */

/** An element of this rank that converts. */
struct FixDefe::OwnConversion {
  HexRecord *hex;
  const defe::ConvertingHex *planned;
  const std::array<int, 8> *idx;
  int kernel;
};

struct FixDefe::Conversion {
  struct Birth {
    defe::NewDE de;
    DERecord record;
    tagint tag, node;
    int part;
    imageint image;
  };
  std::vector<OwnConversion> own;    // by ID
  std::unique_ptr<const defe::ConversionPlan> plan;
  std::vector<BallShare> from_balls;
  std::vector<Birth> births;
};

void FixDefe::convert_marked()
{
  ghost_positions();
  mark_asked_elements();
  note_energy_in_walls();
  if (contact_factor > 0.0) {
    ledger.conv_strain += contact_energy_now();
    contact_to_book = true;
  }

  Conversion c;
  collect_marked(c);
  ball_shares(*c.plan, c.from_balls);
  for (const auto &o : c.own) {    // strain energy before
    HexCoords xe, Xe;
    hex_coords(o.idx->data(), xe, Xe);
    ledger.conv_strain += kernels[o.kernel].kernel->energy(xe, Xe);
  }
  ties_to_joints(*c.plan);
  update_beside(*c.plan);

  loss_mass.assign(atom->nlocal + atom->nghost, 0.0);
  loss_count.assign(atom->nlocal + atom->nghost, 0);
  for (const auto &o : c.own) {
    add_births(c, o);
    defe::Event e{};
    e.step = update->ntimestep;
    e.time = now();
    e.what = defe::EventKind::CONVERT;
    e.a = o.hex->id;
    e.b = o.hex->part + 1;
    HexCoords xe, Xe;
    hex_coords(o.idx->data(), xe, Xe);
    const Vec3 centre = Xe.rowwise().mean();
    domain->unmap(centre.data(), atom->image[(*o.idx)[0]], e.x);    // never wrapped
    e.value = element_mass(parts[o.hex->part], o.hex->volume);
    record_event(e);
  }
  const bigint nodes_gone = remove_converted(c);
  create_des(c);
  finish_conversion(static_cast<bigint>(c.own.size()), nodes_gone);
}

/* ----------------------------------------------------------------------
   every rank learns which elements near its own convert now
------------------------------------------------------------------------- */

void FixDefe::collect_marked(Conversion &c)
{
  double **x = atom->x;
  for (auto &b : batches) {
    if (!b.convertible) continue;
    for (size_t e = 0; e < b.hex.size(); e++)
      if (b.hex[e]->marked) c.own.push_back({b.hex[e], nullptr, &b.node[e], b.kernel});
  }
  std::sort(c.own.begin(), c.own.end(), [](const auto &p, const auto &q) {
    return p.hex->id < q.hex->id;
  });
  std::vector<tagint> ids;
  for (const auto &o : c.own) ids.push_back(o.hex->id);
  const auto lots = deal_lots(ids);
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
  c.plan = std::make_unique<const defe::ConversionPlan>(de_base, std::move(converting));
  for (auto &o : c.own) o.planned = c.plan->converting(o.hex->id);
}

/* ----------------------------------------------------------------------
   DEs that are tied to elements that convert get joints instead of ties
------------------------------------------------------------------------- */

void FixDefe::ties_to_joints(const defe::ConversionPlan &plan)
{
  const auto ends = [&plan](const JointSlot &slot) {
    return slot.kind == DefeJoint::TIE && plan.converting(slot.other);
  };
  for (int d = 0; d < jt.nde; d++) {
    if (d + 2 < jt.nde) prefetch(jt.rec[d + 2]);
    DERecord &r = *jt.rec[d];
    if (std::none_of(std::begin(r.slot), std::end(r.slot), ends)) continue;
    if (!r.newborn) ledger.conv_strain += de_energy(d, jt.present[d]);
    r.newborn = 1;
    for (auto &slot : r.slot) {
      if (!ends(slot)) continue;
      const auto element = plan.converting(slot.other)->coords();
      slot.apart = distance_if_swung(jt.self[d], slot.face_node, slot.corner, element, slot.part);
      if (slot.apart > 0.0) slot.state = DefeJoint::CONTACT;
      slot.asks = 0;
      slot.kind = DefeJoint::DE;
      slot.other = static_cast<tagint>(plan.joint_of_tie(slot.other, slot.corner));
    }
  }
}

/* ----------------------------------------------------------------------
   elements beside them: the face behind is free now, and the crack shields them
------------------------------------------------------------------------- */

void FixDefe::update_beside(const defe::ConversionPlan &plan)
{
  std::vector<char> beside(atom->nlocal + atom->nghost, 0);
  plan.for_nodes([&](tagint node) {
    for (int i = local_of(node); i >= 0; i = atom->sametag[i]) beside[i] = 1;
  });
  for (auto &b : batches)
    for (size_t e = 0; e < b.hex.size(); e++) {
      const auto &idx = b.node[e];
      if (std::none_of(idx.begin(), idx.end(), [&beside](int i) {
            return beside[i] != 0;
          }))
        continue;
      HexRecord &h = *b.hex[e];
      if (plan.converting(h.id)) continue;
      for (tagint &nb : h.nb) nb = static_cast<tagint>(plan.behind_now(nb));
      if (b.convertible && shield) add_shields(plan, h, idx);
    }
}

void FixDefe::add_shields(const defe::ConversionPlan &plan, HexRecord &h,
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
    h.with_extra().shields.push_back({del, now()});
  }
  // at most one entry per neighbour: the oldest ones have had their time
  auto &list = h.extra->shields;
  if (list.size() > 26) list.erase(list.begin(), list.end() - 26);
}

/* ----------------------------------------------------------------------
   the eight DEs of one element, and what its nodes lose
------------------------------------------------------------------------- */

void FixDefe::add_births(Conversion &c, const OwnConversion &o)
{
  const HexRecord &h = *o.hex;
  const auto &idx = *o.idx;
  HexCoords Xe, xe, ve;
  hex_coords(idx.data(), xe, Xe);
  for (int a = 0; a < 8; a++)
    for (int k = 0; k < 3; k++) ve(k, a) = atom->v[idx[a]][k];
  const double mass = element_mass(parts[h.part], h.volume);
  for (int i : idx) {
    loss_mass[i] += defe::ConversionPlan::node_share * mass;
    loss_count[i]++;
  }
  const auto eight = defe::convert_hex(Xe, xe, ve, mass);
  ledger.conv_kinetic += defe::conversion_kinetic_loss(ve, mass, eight);

  defe::HexNeighbors neighbors;
  for (int f = 0; f < 6; f++) {
    neighbors.behind[f] = h.nb[f];
    neighbors.face[f] = h.nbface[f];
    neighbors.rotation[f] = h.nbrot[f];
    neighbors.part[f] = h.nbpart[f];
  }
  const auto planned = c.plan->births(*o.planned, neighbors, eight);
  for (int k = 0; k < 8; k++) {
    Conversion::Birth birth;
    birth.de = eight[k];
    birth.part = h.part;
    birth.node = h.node[k];
    birth.image = atom->image[idx[0]];    // positions are in the frame of that node
    birth.tag = static_cast<tagint>(planned[k].id);
    DERecord &r = birth.record;
    fill_record(r, eight[k], planned[k]);
    r.element = h.id;
    r.corner = k;
    r.part = h.part;
    r.lot = static_cast<tagint>(o.planned->lot);
    for (int s = 0; s < 6; s++)
      if (planned[k].slot[s].to_older) hold_apart(birth.tag, r, s, planned[k], eight[k], idx, xe);
    c.births.push_back(birth);
  }
}

/* ----------------------------------------------------------------------
   record of a DE as it is planned
------------------------------------------------------------------------- */

void FixDefe::fill_record(DERecord &r, const defe::NewDE &de, const defe::PlannedDE &planned)
{
  static_assert(static_cast<int>(defe::PlannedSlot::JOINT) == DefeJoint::DE &&
                    static_cast<int>(defe::PlannedSlot::TIE) == DefeJoint::TIE,
                "the same kinds");
  memset(static_cast<void *>(&r), 0, sizeof(DERecord));
  r.volume = de.volume;
  r.newborn = 1;
  r.outer_distance = planned.outer_distance;
  r.outer_area = planned.outer_area;
  for (int s = 0; s < 6; s++) {
    const auto &plan = planned.slot[s];
    JointSlot &slot = r.slot[s];
    const double area = de.area[s];
    slot.area = area;
    for (int c = 0; c < 3; c++) {
      slot.face[c] = de.face[s][c];
      slot.normal[c] = area > 0.0 ? de.area_normal[s][c] / area : 0.0;
    }
    slot.state = DefeJoint::CONNECTIVE;
    slot.kind = plan.kind;
    slot.other = static_cast<tagint>(plan.other);
    slot.partner = plan.partner;
    slot.corner = plan.corner;
    slot.part = plan.part;
    if (plan.kind == defe::PlannedSlot::TIE)
      for (int c = 0; c < 4; c++) slot.face_node[c] = static_cast<tagint>(plan.face_node[c]);
  }
}

/* ----------------------------------------------------------------------
   a joint to a DE that was tied to the element: where that has swung too far, it is broken from the start
------------------------------------------------------------------------- */

void FixDefe::hold_apart(tagint tag, DERecord &r, int s, const defe::PlannedDE &planned,
                         const defe::NewDE &de, const std::array<int, 8> &idx,
                         const HexCoords &element)
{
  JointSlot &slot = r.slot[s];
  const int j = domain->closest_image(idx[r.corner], local_of(slot.other));
  if (j < 0) return;    // deleted
  tagint face_node[4];
  for (int c = 0; c < 4; c++) face_node[c] = static_cast<tagint>(planned.slot[s].face_node[c]);
  slot.apart = distance_if_swung(j, face_node, r.corner, element, r.part);
  if (!(slot.apart > 0.0)) return;
  slot.state = DefeJoint::CONTACT;
  defe::Event e{};
  e.step = update->ntimestep;
  e.time = now();
  e.what = defe::EventKind::BROKEN;
  e.a = MIN(tag, slot.other);
  e.b = MAX(tag, slot.other);
  const Vec3 middle = 0.5 * (de.X + Vec3(xframe[j]));
  domain->unmap(middle.data(), atom->image[idx[0]], e.x);
  for (int c = 0; c < 3; c++) e.n[c] = slot.normal[c];
  e.value = 1.0;
  record_event(e);
  note_damage();
}

/* ----------------------------------------------------------------------
   the elements go, and nodes that have none any more; returns how many nodes of this rank
------------------------------------------------------------------------- */

bigint FixDefe::remove_converted(const Conversion &c)
{
  const int nlocal = atom->nlocal;
  comm_mode = LOSS;
  comm->reverse_comm(this, 2);
  for (int i = 0; i < nlocal; i++) {
    if (loss_count[i] == 0) continue;
    nelem[i] -= loss_count[i];
    atom->rmass[i] -= loss_mass[i];
    if (nelem[i] < 0)
      error->one(FLERR, "Fix defe: node {} lost more elements than it had", atom->tag[i]);
    if (nelem[i] == 0 ? std::abs(atom->rmass[i]) > 1.0e-6 * loss_mass[i] : !(atom->rmass[i] > 0.0))
      error->one(FLERR,
                 "Node {} does not have the mass of its elements when they convert at step {}: do "
                 "not change masses of nodes with 'set', change the density of the material",
                 atom->tag[i], update->ntimestep);
  }
  for (const auto &o : c.own) {
    auto &list = hexes[(*o.idx)[0]];
    list.erase(std::find_if(list.begin(), list.end(), [&o](const HexRecord &h) {
      return h.id == o.planned->id;
    }));
  }
  bigint nodes_gone = 0;
  int n = nlocal;
  for (int i = nlocal - 1; i >= 0; i--)
    if (loss_count[i] > 0 && nelem[i] == 0) {
      nodes_gone++;
      if (touch[i])
        for (const auto &t : touch[i]->faces) ledger.friction += t.stored;    // springs let go
      if (i != n - 1)
        atom->avec->copy(n - 1, i, 1);
      else {
        hexes[i].clear();
        de[i].reset();
        touch[i].reset();
      }
      n--;
    }
  atom->nlocal = n;
  return nodes_gone;
}

/* ----------------------------------------------------------------------
   atoms for the new DEs
------------------------------------------------------------------------- */

void FixDefe::create_des(const Conversion &c)
{
  for (const auto &b : c.births) {
    const Part &p = parts[b.part];
    double xnew[3] = {b.de.x[0], b.de.x[1], b.de.x[2]};
    atom->avec->create_atom(p.type, xnew);
    const int i = atom->nlocal - 1;
    atom->tag[i] = b.tag;
    atom->mask[i] = 1 | group->bitmask[p.group];
    atom->radius[i] = b.de.radius;
    atom->rmass[i] = b.de.mass;
    for (int k = 0; k < 3; k++) {
      atom->v[i][k] = b.de.v[k];
      atom->omega[i][k] = b.de.omega[k];
    }
    giving_birth = true;
    modify->create_attribute(i);
    giving_birth = false;
    atom->image[i] = b.image;
    double ref[3];
    domain->unmap(b.de.X.data(), b.image, ref);
    set_reference(i, ref);
    de[i] = std::make_unique<DERecord>(b.record);
    touch_at(i).fresh = true;
    const BallShare first{b.record.element, b.node, 0, 0.0, 0.0};
    auto share = std::lower_bound(c.from_balls.begin(), c.from_balls.end(), first,
                                  [](const BallShare &p, const BallShare &q) {
                                    return p.element != q.element ? p.element < q.element
                                                                  : p.node < q.node;
                                  });
    for (; share != c.from_balls.end() && share->element == first.element &&
         share->node == first.node;
         ++share) {
      auto &list = touch_at(i).spheres;
      if (list.empty() || list.back().other != share->ball)
        list.push_back({share->ball, {0.0, 0.0, 0.0}, 0.0, 0.0, 0.0});
      list.back().inherit += share->energy;
      list.back().push += share->push;
    }
  }
}

/* ----------------------------------------------------------------------
   totals, and the atom map; local indices are void until the next reneighbouring
------------------------------------------------------------------------- */

void FixDefe::finish_conversion(bigint converted, bigint nodes_gone)
{
  // a DE may be born up to 3/4 of an element outside the sub-domain of its element, and LAMMPS'
  // exchange moves atoms by one sub-domain only

  bool thin = false;
  for (int d = 0; d < 3; d++) {
    const double width = domain->subhi[d] - domain->sublo[d];
    thin = thin || (width < domain->prd[d] && width < max_diagonal);
  }

  bigint mine[4] = {atom->nlocal, converted, nodes_gone, thin ? 1 : 0}, all[4];
  MPI_Allreduce(mine, all, 4, MPI_LMP_BIGINT, MPI_SUM, world);
  nodes_total -= all[2];
  atom->natoms = natoms_known = all[0];
  conversions_total += all[1];
  hexes_total -= all[1];
  des_total += 8 * all[1];
  if (all[1] > 0 && first_conversion < 0.0) first_conversion = now();
  atom->nghost = 0;
  atom->map_init();
  atom->map_set();
  if (all[3]) {
    domain->pbc();
    if (domain->nonperiodic == 2) domain->reset_box();
    Irregular irregular(lmp);
    irregular.migrate_atoms(1);
  }

  for (auto &b : batches) b.clear();
  exposed.clear();
  converting = {};
  jt.clear();
  surface.clear();
  facet_nodes.clear();
}
