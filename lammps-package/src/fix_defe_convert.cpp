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

#include "defe/coupling/conversion.h"
#include "defe/fe/hex8.h"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <unordered_map>
#include <unordered_set>

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

double FixDefe::de_energy(int d, unsigned present) const
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
    return defe::corner_strain_general(jt.cell[d - jt.north], y, present, moduli, hf);

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
  return defe::corner_strain_orthogonal(one, xs, nullptr, &moduli, force, energy);
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

void FixDefe::tell_neighbours(std::vector<Converting> &&mine)
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
   convert all marked elements, of all ranks, together
------------------------------------------------------------------------- */

void FixDefe::convert_marked()
{
  const int nlocal = atom->nlocal;
  const int nall = nlocal + atom->nghost;

  ghost_positions();
  note_energy_in_walls();
  double **x = atom->x;
  double **v = atom->v;
  if (contact_factor > 0.0) {
    ledger.conv_strain += contact_energy_now();
    contact_to_book = true;
  }

  // every rank learns which elements near its own convert now

  struct Own {
    HexRecord *hex;
    tagint id, lot;
    const std::array<int, 8> *idx;
    int kernel;
  };
  std::vector<Own> own;
  for (auto &b : batches) {
    if (!b.convertible) continue;
    for (size_t e = 0; e < b.hex.size(); e++)
      if (b.hex[e]->marked) own.push_back({b.hex[e], b.hex[e]->id, 0, &b.node[e], b.kernel});
  }
  std::sort(own.begin(), own.end(), [](const Own &a, const Own &b) {
    return a.id < b.id;
  });
  {
    std::vector<tagint> ids;
    for (const auto &o : own) ids.push_back(o.id);
    const auto lots = deal_lots(ids);
    std::vector<Converting> mine(own.size());
    for (size_t k = 0; k < own.size(); k++) {
      mine[k].id = own[k].id;
      mine[k].lot = own[k].lot = lots[k];
      for (int a = 0; a < 8; a++) {
        mine[k].node[a] = own[k].hex->node[a];
        for (int d = 0; d < 3; d++) mine[k].x[a][d] = x[(*own[k].idx)[a]][d];
      }
    }
    tell_neighbours(std::move(mine));
  }
  std::unordered_map<tagint, const Converting *> now_gone;
  std::unordered_map<tagint, std::vector<const Converting *>> at_node;
  for (const auto &c : converting) {
    now_gone[c.id] = &c;
    for (tagint t : c.node) at_node[t].push_back(&c);
  }
  std::vector<BallShare> from_balls;
  ball_shares(now_gone, from_balls);
  const auto coords_of = [](const Converting &c) {
    HexCoords nodes;
    for (int a = 0; a < 8; a++) nodes.col(a) = Vec3(c.x[a]);
    return nodes;
  };

  // strain energy before: of the elements, and of the DEs that are tied to them

  for (const auto &o : own) {
    HexCoords xe, Xe;
    hex_coords(o.idx->data(), xe, Xe);
    ledger.conv_strain += kernels[o.kernel].kernel->energy(xe, Xe);
  }

  // DEs tied to them get joints instead of ties

  for (int d = 0; d < jt.nde; d++) {
    if (d + 2 < jt.nde) prefetch(jt.rec[d + 2]);
    DERecord &r = *jt.rec[d];
    bool touched = false;
    for (auto &slot : r.slot)
      if (slot.kind == DefeJoint::TIE && now_gone.count(slot.other)) touched = true;
    if (!touched) continue;
    if (!r.newborn) ledger.conv_strain += de_energy(d, jt.present[d]);
    r.newborn = 1;
    for (auto &slot : r.slot)
      if (slot.kind == DefeJoint::TIE && now_gone.count(slot.other)) {
        const Converting &behind = *now_gone[slot.other];
        slot.apart = distance_if_swung(jt.self[d], slot.face_node, slot.corner, coords_of(behind),
                                       slot.part);
        if (slot.apart > 0.0) slot.state = DefeJoint::CONTACT;
        slot.kind = DefeJoint::DE;
        slot.other = de_tag(behind.lot, slot.corner);
      }
  }

  // elements beside them: the face behind is free now, and the crack shields them

  std::vector<char> beside(nall, 0);
  for (const auto &c : at_node)
    for (int i = local_of(c.first); i >= 0; i = atom->sametag[i]) beside[i] = 1;
  for (auto &b : batches)
    for (size_t e = 0; e < b.hex.size(); e++) {
      const auto &idx = b.node[e];
      if (std::none_of(idx.begin(), idx.end(), [&beside](int i) {
            return beside[i] != 0;
          }))
        continue;
      HexRecord &h = *b.hex[e];
      if (now_gone.count(h.id)) continue;
      for (tagint &nb : h.nb) {
        const auto gone = nb > 0 ? now_gone.find(nb) : now_gone.end();
        if (gone != now_gone.end()) nb = -gone->second->lot;
      }
      if (!b.convertible || !shield) continue;
      std::unordered_set<tagint> seen;
      double centre[3] = {0.0, 0.0, 0.0};
      for (int a = 0; a < 8; a++) {
        auto found = at_node.find(h.node[a]);
        if (found == at_node.end()) continue;
        if (seen.empty())
          for (int c = 0; c < 8; c++)
            for (int k = 0; k < 3; k++) centre[k] += 0.125 * x[b.node[e][c]][k];
        for (const auto *c : found->second) {
          if (!seen.insert(c->id).second) continue;
          double del[3];
          for (int k = 0; k < 3; k++) {
            del[k] = -centre[k];
            for (const auto &xa : c->x) del[k] += 0.125 * xa[k];
          }
          for (int k = 0; k < 3; k++)
            if (domain->periodicity[k])
              del[k] -= domain->prd[k] * std::round(del[k] / domain->prd[k]);
          defe::Shield s;
          s.direction = Vec3(del[0], del[1], del[2]);
          s.time = now();
          h.with_extra().shields.push_back(s);
        }
      }
      // at most one entry per neighbour: the oldest ones have had their time
      if (h.extra)
        while (h.extra->shields.size() > 26) h.extra->shields.erase(h.extra->shields.begin());
    }

  // the new DEs

  struct Birth {
    defe::NewDE de;
    DERecord record;
    tagint tag, node;
    int part;
    imageint image;
  };
  std::vector<Birth> births;
  loss_mass.assign(nall, 0.0);
  loss_count.assign(nall, 0);
  for (const auto &o : own) {
    const HexRecord &h = *o.hex;
    const Part &p = parts[h.part];
    HexCoords Xe, xe, ve;
    hex_coords(o.idx->data(), xe, Xe);
    for (int a = 0; a < 8; a++)
      for (int k = 0; k < 3; k++) ve(k, a) = v[(*o.idx)[a]][k];
    const double mass = element_mass(p, h.volume);
    for (int a = 0; a < 8; a++) {
      loss_mass[(*o.idx)[a]] += 0.125 * mass;
      loss_count[(*o.idx)[a]]++;
    }
    const auto eight = defe::convert_hex(Xe, xe, ve, mass);
    ledger.conv_kinetic += defe::conversion_kinetic_loss(ve, mass, eight);

    for (int k = 0; k < 8; k++) {
      Birth birth;
      birth.de = eight[k];
      birth.part = h.part;
      birth.node = h.node[k];
      birth.image = atom->image[(*o.idx)[0]];    // positions are in the frame of that node
      birth.tag = de_tag(o.lot, k);
      memset(static_cast<void *>(&birth.record), 0, sizeof(DERecord));
      DERecord &r = birth.record;
      r.element = h.id;
      r.corner = k;
      r.part = h.part;
      r.volume = eight[k].volume;
      r.newborn = 1;
      r.lot = o.lot;
      for (int s = 0; s < 6; s++) {
        JointSlot &slot = r.slot[s];
        const double area = eight[k].area[s];
        slot.area = area;
        for (int c = 0; c < 3; c++) {
          slot.face[c] = eight[k].face[s][c];
          slot.normal[c] = area > 0.0 ? eight[k].area_normal[s][c] / area : 0.0;
        }
        slot.state = DefeJoint::CONNECTIVE;
        if (!defe::slot_is_outer(k, s)) {
          const int other = defe::fe::hex_edge_neighbor(k, s / 2);
          slot.kind = DefeJoint::DE;
          slot.other = de_tag(o.lot, other);
          slot.partner = static_cast<signed char>(s ^ 1);
          slot.corner = static_cast<signed char>(other);
          continue;
        }
        const tagint nb = h.nb[s];
        if (nb == 0) {
          slot.kind = DefeJoint::NONE;
          continue;
        }
        const int pos = defe::fe::hex_face_position(s, k);
        const int q = (h.nbrot[s] - pos + 4) % 4;
        const int corner = defe::fe::hex_face[static_cast<int>(h.nbface[s])][q];
        slot.corner = static_cast<signed char>(corner);
        slot.partner = h.nbface[s];
        tagint face_node[4];
        for (int c = 0; c < 4; c++) face_node[c] = h.node[defe::fe::hex_face[s][(pos + c) % 4]];
        if (nb < 0 || now_gone.count(nb)) {
          slot.kind = DefeJoint::DE;
          slot.other = de_tag(nb < 0 ? -nb : now_gone[nb]->lot, corner);
          const int j = nb < 0 ? domain->closest_image((*o.idx)[k], local_of(slot.other)) : -1;
          if (j < 0) continue;    // born now, too; or deleted
          slot.apart = distance_if_swung(j, face_node, k, xe, h.part);
          if (slot.apart > 0.0) {
            slot.state = DefeJoint::CONTACT;
            defe::Event e{update->ntimestep,
                          now(),
                          defe::EventKind::BROKEN,
                          birth.tag,
                          slot.other,
                          {},
                          {},
                          1.0};
            if (e.a > e.b) std::swap(e.a, e.b);
            const Vec3 middle = 0.5 * (eight[k].X + Vec3(xframe[j]));
            domain->unmap(middle.data(), birth.image, e.x);
            for (int c = 0; c < 3; c++) e.n[c] = slot.normal[c];
            record_event(e);
            note_damage();
          }
        } else {
          slot.kind = DefeJoint::TIE;
          slot.other = nb;
          slot.part = h.nbpart[s];
          for (int c = 0; c < 4; c++) slot.face_node[c] = face_node[c];
        }
      }
      for (const auto &slot : r.slot) {
        if (slot.kind != DefeJoint::NONE) continue;
        const double distance = Vec3(slot.face).dot(Vec3(slot.normal));
        if (r.outer_distance > 0.0 && distance >= r.outer_distance) continue;
        r.outer_distance = distance;
        r.outer_area = slot.area;
      }
      if (r.outer_distance == 0.0) {
        r.outer_distance = eight[k].radius;
        r.outer_area = 4.0 * eight[k].radius * eight[k].radius;
      }
      births.push_back(birth);
    }

    defe::Event e;
    e.step = update->ntimestep;
    e.time = now();
    e.what = defe::EventKind::CONVERT;
    e.a = h.id;
    e.b = h.part + 1;
    const Vec3 centre = Xe.rowwise().mean();
    domain->unmap(centre.data(), atom->image[(*o.idx)[0]], e.x);    // never wrapped
    for (double &n : e.n) n = 0.0;
    e.value = mass;
    record_event(e);
  }

  // nodes lose an eighth of each; those without elements go

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
  for (const auto &o : own) {
    auto &list = hexes[(*o.idx)[0]];
    list.erase(std::find_if(list.begin(), list.end(), [&o](const HexRecord &h) {
      return h.id == o.id;
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

  for (const auto &b : births) {
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
    auto share = std::lower_bound(
        from_balls.begin(), from_balls.end(), first, [](const BallShare &p, const BallShare &q) {
          return p.element != q.element ? p.element < q.element : p.node < q.node;
        });
    for (;
         share != from_balls.end() && share->element == first.element && share->node == first.node;
         ++share) {
      auto &list = touch_at(i).spheres;
      if (list.empty() || list.back().other != share->ball)
        list.push_back({share->ball, {0.0, 0.0, 0.0}, 0.0, 0.0, 0.0});
      list.back().inherit += share->energy;
      list.back().push += share->push;
    }
  }
  // a DE may be born up to 3/4 of an element outside the sub-domain of its element, and LAMMPS'
  // exchange moves atoms by one sub-domain only

  bool thin = false;
  for (int d = 0; d < 3; d++) {
    const double width = domain->subhi[d] - domain->sublo[d];
    thin = thin || (width < domain->prd[d] && width < max_diagonal);
  }

  bigint mine[4] = {atom->nlocal, static_cast<bigint>(own.size()), nodes_gone, thin ? 1 : 0},
         all[4];
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

  // local indices are void until the next reneighbouring

  for (auto &b : batches) b.clear();
  exposed.clear();
  converting = {};
  jt.clear();
  surface.clear();
  facet_nodes.clear();
}
