/* ----------------------------------------------------------------------
   DEFE: adaptive finite elements to bonded discrete elements for LAMMPS
   https://www.lammps.org/
   This software is distributed under the GNU General Public License.

   Is all as it must be? The records of elements and joints against each other, and a
   watch over atoms that move in a way that nothing physical does.
   What belongs together meets on the rank that its ID is dealt to, so the check itself
   costs no rank more than its share.
------------------------------------------------------------------------- */

#include "fix_defe.h"

#include "rendezvous.h"

#include "atom.h"
#include "comm.h"
#include "domain.h"
#include "error.h"
#include "force.h"
#include "group.h"
#include "modify.h"
#include "output.h"
#include "thermo.h"
#include "update.h"

#include "defe/fe/hex8.h"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <limits>
#include <unordered_map>
#include <unordered_set>

using namespace LAMMPS_NS;
using defe::fe::HexCoords;
using Rendezvous::Letters;

/* ----------------------------------------------------------------------
   elements, nodes, DEs and joints as the ranks know them, against each other
   needs no ghosts and no tables; collective
------------------------------------------------------------------------- */

void FixDefe::check_records(const char *when)
{
  const int nlocal = atom->nlocal;
  bigint mine[3] = {0, 0, des_gone}, all[3];
  for (int i = 0; i < nlocal; i++) {
    mine[0] += static_cast<bigint>(hexes[i].size());
    mine[1] += de[i] ? 1 : 0;
  }
  MPI_Allreduce(mine, all, 3, MPI_LMP_BIGINT, MPI_SUM, world);
  if (all[0] != hexes_total || all[1] != des_total - all[2])
    error->all(FLERR,
               "Fix defe {} at step {}: {} elements and {} DEs are here, {} and {} should be", when,
               update->ntimestep, all[0], all[1], hexes_total, des_total - all[2]);

  // elements: at their first node, and once

  struct Element {
    tagint id;
    HexPod pod;
  };
  Letters<Element> elements(lmp);
  for (int i = 0; i < nlocal; i++)
    for (const auto &h : hexes[i]) {
      if (h.node[0] != atom->tag[i])
        error->one(
            FLERR,
            "Fix defe {} at step {}: element {} of part {} belongs to node {}, but is kept by "
            "atom {}: atom IDs were changed (use delete_atoms with 'compress no')",
            when, update->ntimestep, h.id, parts[h.part].name, h.node[0], atom->tag[i]);
      elements.to_id(h.id, {h.id, h});
    }
  const auto here = elements.send();
  std::unordered_map<tagint, const HexPod *> known;
  for (const auto &e : here)
    if (!known.emplace(e.id, &e.pod).second)
      error->one(FLERR, "Fix defe {} at step {}: element {} is known to two ranks", when,
                 update->ntimestep, e.id);

  // neighbours are mutual; what is said to be converted is no longer an element

  struct Side {
    tagint to, from;
    int face, from_face;
  };
  Letters<Side> sides(lmp);
  for (int i = 0; i < nlocal; i++)
    for (const auto &h : hexes[i])
      for (int f = 0; f < 6; f++)
        if (h.nb[f] != 0) sides.to_id(std::abs(h.nb[f]), {h.nb[f], h.id, h.nbface[f], f});
  for (const auto &s : sides.send()) {
    const auto found = known.find(std::abs(s.to));
    if (s.to < 0) {    // a lot: of the number of the element, or beyond all elements
      if (found != known.end())
        error->one(FLERR, "Fix defe {} at step {}: element {} takes its neighbour {} for converted",
                   when, update->ntimestep, s.from, -s.to);
      continue;
    }
    if (found == known.end())
      error->one(
          FLERR,
          "Fix defe {} at step {}: element {} was lost or deleted, its neighbour {} was not: "
          "only whole bodies can be deleted",
          when, update->ntimestep, s.to, s.from);
    if (found->second->nb[s.face] != s.from || found->second->nbface[s.face] != s.from_face)
      error->one(FLERR, "Fix defe {} at step {}: element {} does not know its neighbour {}", when,
                 update->ntimestep, s.to, s.from);
  }

  // nodes: each there, and with as many elements as it believes to have

  struct Use {
    tagint node, element;
    int count, is_node, part;
  };
  Letters<Use> uses(lmp);
  for (int i = 0; i < nlocal; i++) {
    if (!de[i] && nelem[i] > 0) uses.to_id(atom->tag[i], {atom->tag[i], 0, nelem[i], 1, 0});
    for (const auto &h : hexes[i])
      for (tagint t : h.node) uses.to_id(t, {t, h.id, 1, 0, h.part});
  }
  {
    auto came = uses.send();
    std::sort(came.begin(), came.end(), [](const Use &a, const Use &b) {
      if (a.node != b.node) return a.node < b.node;
      return a.is_node != b.is_node ? a.is_node > b.is_node : a.element < b.element;
    });
    for (size_t k = 0; k < came.size();) {
      const auto &node = came[k];
      if (!node.is_node)
        error->one(FLERR,
                   "Fix defe {} at step {}: node {} of element {} of part {} was lost or deleted: "
                   "only whole bodies can be deleted",
                   when, update->ntimestep, node.node, node.element, parts[node.part].name);
      int count = 0;
      for (k++; k < came.size() && came[k].node == node.node; k++) {
        if (came[k].is_node)
          error->one(FLERR, "Fix defe {} at step {}: node {} is known to two ranks", when,
                     update->ntimestep, node.node);
        count++;
      }
      if (count != node.count)
        error->one(
            FLERR,
            "Fix defe {} at step {}: node {} has {} elements, not {}: some were deleted; only "
            "whole bodies can be",
            when, update->ntimestep, node.node, count, node.count);
    }
  }

  // DEs and their joints: both sides there, and in one state; ties end at elements

  struct Joint {
    tagint to, from;    // from = 0: this is the DE `to` itself
    int slot, partner, state;
    tagint element;
  };
  Letters<Joint> joints(lmp);
  struct Tie {
    tagint element, from;
    tagint node[4];
  };
  Letters<Tie> ties(lmp);
  for (int i = 0; i < nlocal; i++) {
    if (!de[i]) continue;
    const DERecord &r = *de[i];
    const tagint me = atom->tag[i];
    if (me != de_tag(r.lot, r.corner))
      error->one(FLERR,
                 "Fix defe {} at step {}: DE {} of element {} has the atom ID {}: atom IDs were "
                 "changed (use delete_atoms with 'compress no')",
                 when, update->ntimestep, r.corner + 1, r.element, me);
    joints.to_id(me, {me, 0, 0, 0, 0, r.element});
    for (int s = 0; s < 6; s++) {
      const JointSlot &slot = r.slot[s];
      if (slot.kind == DefeJoint::DE)
        joints.to_id(slot.other, {slot.other, me, s, slot.partner, slot.state, r.element});
      else if (slot.kind == DefeJoint::TIE && slot.state != DefeJoint::CONTACT) {
        Tie t{slot.other, me, {0, 0, 0, 0}};
        for (int k = 0; k < 4; k++) t.node[k] = slot.face_node[k];
        ties.to_id(slot.other, t);
      }
    }
  }
  // each half of a joint looks for the other one: (to, from, partner) = (from, to, slot)
  auto came = joints.send();
  std::unordered_set<tagint> des;
  for (const auto &j : came) {
    if (j.from) continue;
    if (!des.insert(j.to).second || known.count(j.element))
      error->one(FLERR, "Fix defe {} at step {}: DE {} exists twice, or beside its element {}",
                 when, update->ntimestep, j.to, j.element);
  }
  Letters<Joint> halves(lmp);    // to the rank on which the lower of the two IDs meets
  for (const auto &j : came) {
    if (!j.from) continue;
    if (!des.count(j.to)) {
      if (j.state != DefeJoint::CONTACT)
        error->one(
            FLERR,
            "Fix defe {} at step {}: DE {} was lost or deleted while it was joined to DE {}: "
            "only whole fragments can be deleted",
            when, update->ntimestep, j.to, j.from);
      continue;
    }
    halves.to_id(MIN(j.to, j.from), j);
  }
  auto pairs = halves.send();
  auto low = [](const Joint &j) {
    return MIN(j.to, j.from);
  };
  auto low_slot = [](const Joint &j) {
    return j.from < j.to ? j.slot : j.partner;
  };
  std::sort(pairs.begin(), pairs.end(), [&](const Joint &a, const Joint &b) {
    if (low(a) != low(b)) return low(a) < low(b);
    if (low_slot(a) != low_slot(b)) return low_slot(a) < low_slot(b);
    return a.from < b.from;
  });
  for (size_t k = 0; k < pairs.size(); k += 2) {
    const Joint &a = pairs[k];
    const Joint *b = k + 1 < pairs.size() ? &pairs[k + 1] : nullptr;
    if (!b || b->from != a.to || b->to != a.from || b->slot != a.partner || b->partner != a.slot) {
      // the other side was deleted after the joint had broken
      if (a.state == DefeJoint::CONTACT &&
          (!b || low(*b) != low(a) || low_slot(*b) != low_slot(a))) {
        k--;
        continue;
      }
      error->one(FLERR, "Fix defe {} at step {}: DE {} does not know its joint with DE {}", when,
                 update->ntimestep, a.to, a.from);
    }
    if (a.state != b->state)
      error->one(
          FLERR,
          "Fix defe {} at step {}: the joint of DEs {} and {} has state {} for one and {} for "
          "the other",
          when, update->ntimestep, a.from, b->from, a.state, b->state);
  }
  for (const auto &t : ties.send()) {
    const auto found = known.find(t.element);
    bool on_face = found != known.end();
    for (int k = 0; k < 4 && on_face; k++)
      on_face = std::find(found->second->node, found->second->node + 8, t.node[k]) !=
          found->second->node + 8;
    if (!on_face)
      error->one(FLERR,
                 "Fix defe {} at step {}: DE {} is tied to element {}, which was lost or deleted: "
                 "only whole bodies can be deleted",
                 when, update->ntimestep, t.from, t.element);
  }
}

/* ----------------------------------------------------------------------
   the mass of each node is that of its elements' eighths, and no mass is lost
   after the tables were made; collective
------------------------------------------------------------------------- */

void FixDefe::check_masses()
{
  const int nlocal = atom->nlocal;
  struct Share {
    tagint node;
    int is_node;
    double mass;
  };
  Letters<Share> shares(lmp);
  double mine = mass_gone, all = 0.0;
  for (int i = 0; i < nlocal; i++) {
    if (de[i] || nelem[i] > 0) mine += atom->rmass[i];
    if (!de[i] && nelem[i] > 0) shares.to_id(atom->tag[i], {atom->tag[i], 1, atom->rmass[i]});
  }
  HexCoords x, X;
  for (const auto &b : batches)
    for (size_t e = 0; e < b.node.size(); e++) {
      hex_coords(b.node[e].data(), x, X);
      const HexRecord &h = *b.hex[e];
      const double mass = 0.125 * material_of(parts[h.part]).elastic().rho * defe::fe::volume(X);
      for (tagint t : h.node) shares.to_id(t, {t, 0, mass});
    }
  auto came = shares.send();
  std::sort(came.begin(), came.end(), [](const Share &a, const Share &b) {
    return a.node != b.node ? a.node < b.node : a.is_node > b.is_node;
  });
  for (size_t k = 0; k < came.size();) {
    const auto &node = came[k];
    double sum = 0.0;
    for (k++; k < came.size() && came[k].node == node.node; k++) sum += came[k].mass;
    if (!(std::abs(sum - node.mass) <= 1.0e-11 * sum))
      error->one(FLERR, "Fix defe at step {}: node {} has mass {:.15g}, its elements give {:.15g}",
                 update->ntimestep, node.node, node.mass, sum);
  }
  MPI_Allreduce(&mine, &all, 1, MPI_DOUBLE, MPI_SUM, world);
  if (!(std::abs(all - mass_total) <= 1.0e-12 * mass_total))
    error->all(FLERR, "Fix defe at step {}: the total mass is {:.15g}, it was {:.15g}",
               update->ntimestep, all, mass_total);
}

/* ----------------------------------------------------------------------
   before a run: were atoms deleted since the last one, and may they be?
------------------------------------------------------------------------- */

void FixDefe::account_for_deleted()
{
  bigint mine[4] = {0, 0, 0, des_gone}, all[4];
  double mass = mass_gone;
  for (int i = 0; i < atom->nlocal; i++) {
    mine[0] += static_cast<bigint>(hexes[i].size());
    mine[1] += de[i] ? 1 : 0;
    mine[2] += (!de[i] && nelem[i] > 0) ? 1 : 0;
    if (de[i] || nelem[i] > 0) mass += atom->rmass[i];
    const bool renumbered = de[i] ? atom->tag[i] != de_tag(de[i]->lot, de[i]->corner)
                                  : !hexes[i].empty() && hexes[i].front().node[0] != atom->tag[i];
    if (renumbered)
      error->one(
          FLERR,
          "Atom IDs were changed since fix defe made its records (atom {} is an example): use "
          "delete_atoms with 'compress no', and no reset_atoms id",
          atom->tag[i]);
  }
  MPI_Allreduce(mine, all, 4, MPI_LMP_BIGINT, MPI_SUM, world);
  if (all[0] == hexes_total && all[1] + all[3] == des_total && all[2] == nodes_total) return;
  hexes_total = all[0];
  des_total = all[1] + all[3];
  nodes_total = all[2];
  MPI_Allreduce(&mass, &mass_total, 1, MPI_DOUBLE, MPI_SUM, world);
  check_records("after atoms were deleted");

  // elements do not know their ties, but which DEs are behind their faces

  if (force->pair_match("defe/contact", 1)) return;    // there they hold nothing
  struct Behind {
    tagint de, element;    // element = 0: the DE itself
  };
  Letters<Behind> letters(lmp);
  for (int i = 0; i < atom->nlocal; i++) {
    if (de[i]) letters.to_id(atom->tag[i], {atom->tag[i], 0});
    for (const auto &h : hexes[i])
      for (int f = 0; f < 6; f++)
        // behind an adhesive the DE may have come loose before it was deleted: nobody knows now
        if (h.nb[f] < 0 && !adhesive_of(h.nbpart[f], h.part))
          for (int k : defe::fe::hex_face[static_cast<int>(h.nbface[f])]) {
            const tagint tag = de_tag(-h.nb[f], k);
            letters.to_id(tag, {tag, h.id});
          }
  }
  const auto came = letters.send();
  std::unordered_set<tagint> des;
  for (const auto &b : came)
    if (!b.element) des.insert(b.de);
  for (const auto &b : came)
    if (b.element && !des.count(b.de))
      error->one(FLERR,
                 "Fix defe after atoms were deleted at step {}: DE {} was lost or deleted while it "
                 "was tied to element {}: only whole bodies and loose DEs can be deleted",
                 update->ntimestep, b.de, b.element);
}

/* ----------------------------------------------------------------------
   adhesives need a pair style that softens joints and contact for afterwards; ties that soften
   (after a restart) need their adhesive
------------------------------------------------------------------------- */

void FixDefe::check_adhesives()
{
  if (!adhesives.empty() && !force->pair_match("defe/joint", 1) &&
      !force->pair_match("defe/cohesive", 1))
    error->all(FLERR,
               "Fix defe adhesive: ties soften with pair_style defe/joint or defe/cohesive only");
  if (!adhesives.empty() && !(contact_factor > 0.0) && comm->me == 0)
    error->warning(
        FLERR,
        "Fix defe adhesive without the keyword contact: what has debonded passes through "
        "the faces");
  int mine[2] = {-1, -1}, all[2];
  for (int i = 0; i < atom->nlocal; i++) {
    if (!de[i]) continue;
    for (const auto &slot : de[i]->slot)
      if (slot.kind == DefeJoint::TIE && (slot.state == DefeJoint::COHESIVE || slot.pending) &&
          !adhesive_of(de[i]->part, slot.part)) {
        mine[0] = de[i]->part;
        mine[1] = slot.part;
      }
  }
  MPI_Allreduce(mine, all, 2, MPI_INT, MPI_MAX, world);
  if (all[0] >= 0)
    error->all(FLERR,
               "Fix defe: ties of part {} to part {} are softening, but no adhesive is given for "
               "them: give 'adhesive' as before the restart",
               parts[all[0]].name, parts[all[1]].name);
}

/* ----------------------------------------------------------------------
   every DE that may be born must be moved by one fix, and no node by two
------------------------------------------------------------------------- */

void FixDefe::check_integrators()
{
  if (update->whichflag != 1 || update->nsteps == 0) return;
  std::vector<Fix *> movers;
  for (auto *ifix : modify->get_fix_list())
    if (ifix->time_integrate) movers.push_back(ifix);

  for (const auto &p : parts) {
    if (!p.convertible) continue;
    const int bits = 1 | group->bitmask[p.group];
    std::vector<std::string> found;
    for (auto *ifix : movers)
      if (!ifix->rigid_flag && (ifix->groupbit & bits)) found.push_back(ifix->id);
    if (found.empty())
      error->all(FLERR,
                 "DEs of part {} (group {}) would be moved by no fix: add 'fix ID {} nve/sphere'",
                 p.name, group->names[p.group], group->names[p.group]);
    if (found.size() > 1)
      error->all(FLERR,
                 "DEs of part {} (group {}) would be moved by fix {} and fix {}: give each fix a "
                 "group of its own",
                 p.name, group->names[p.group], found[0], found[1]);
  }

  for (int i = 0; i < atom->nlocal; i++) {
    if (!de[i] && nelem[i] == 0) continue;
    const Fix *first = nullptr;
    for (const auto *ifix : movers) {
      if (!(atom->mask[i] & ifix->groupbit)) continue;
      if (first)
        error->one(FLERR,
                   "{} {} is moved by fix {} and by fix {}: give each fix a group of its own",
                   de[i] ? "DE" : "Node", atom->tag[i], first->id, ifix->id);
      first = ifix;
    }
  }
}

/* ----------------------------------------------------------------------
   bonds of bpm styles keep their state by local indices between reneighbourings: it must be put away
   before conversions delete nodes
   When one breaks, LAMMPS (4Feb2025) looks it up in all neighbour lists, also in the one from which
   hybrid takes those of its styles: marks of touching pairs, which are cleared in the style's own list
   only, are taken for parts of atom indices there, and the program crashes.
------------------------------------------------------------------------- */

void FixDefe::check_bond_fixes(bool converting)
{
  bool after = false, breaking = false, history = false;
  const char *bonds = force->bond_style ? force->bond_style : "bpm";
  for (const auto *ifix : modify->get_fix_list()) {
    if (ifix == this) after = true;
    const bool special = utils::strmatch(ifix->style, "^UPDATE_SPECIAL_BONDS$");
    if (converting && after && (special || utils::strmatch(ifix->style, "^BOND_HISTORY$")))
      error->all(FLERR,
                 "Bond_style {} must be given before fix {} defe: conversions would mix up the "
                 "states of its bonds",
                 bonds, id);
    breaking = breaking || special;
    history = history || utils::strmatch(ifix->style, "^NEIGH_HISTORY");
  }
  if (breaking && history && force->pair_match("^hybrid", 0))
    error->all(FLERR,
               "Bond_style {} with bonds that break crashes LAMMPS beside contact histories in "
               "pair_style hybrid: use granular styles without history, or bonds with 'break no'",
               bonds);
}

/* ----------------------------------------------------------------------
   part and element of an atom, in words
------------------------------------------------------------------------- */

std::string FixDefe::describe(int i) const
{
  const double *x = atom->x[i];
  std::string where = fmt::format(" at {:.6g} {:.6g} {:.6g} (reference {:.6g} {:.6g} {:.6g})", x[0],
                                  x[1], x[2], xref[i][0], xref[i][1], xref[i][2]);
  if (de[i])
    return fmt::format("DE {} of element {} of part {}", atom->tag[i], de[i]->element,
                       parts[de[i]->part].name) +
        where;
  for (const auto &b : batches)
    for (size_t e = 0; e < b.node.size(); e++)
      for (int a : b.node[e])
        if (a == i)
          return fmt::format("Node {} of element {} of part {}", atom->tag[i], b.hex[e]->id,
                             parts[b.hex[e]->part].name) +
              where;
  return fmt::format("{} {}", nelem[i] > 0 ? "Node" : "Atom", atom->tag[i]) + where;
}

/* ----------------------------------------------------------------------
   an atom that goes a quarter of an edge in one step, or nowhere that is a number:
   the run has exploded. Named is the fastest one.
------------------------------------------------------------------------- */

void FixDefe::stop_exploded()
{
  const double limit = max_step_length / update->dt;
  int worst = -1;
  double fastest = 0.0;
  for (int i = 0; i < atom->nlocal; i++) {
    if (!de[i] && nelem[i] == 0) continue;
    const double *v = atom->v[i], *f = atom->f[i], *x = atom->x[i];
    const double speed = std::sqrt(v[0] * v[0] + v[1] * v[1] + v[2] * v[2]);
    const bool lost = !std::isfinite(speed + f[0] + f[1] + f[2] + x[0] + x[1] + x[2]);
    if (!lost && !(speed > MAX(limit, fastest))) continue;
    worst = i;
    fastest = speed;
    if (lost) break;
  }
  if (worst < 0) return;
  if (fastest > limit)
    error->one(
        FLERR,
        "{} moves by {:.4g} per step at step {}, more than a quarter of the shortest edge: the "
        "run has become unstable; use a smaller timestep, or look at what pushes it",
        describe(worst), fastest * update->dt, update->ntimestep);
  error->one(
      FLERR,
      "{} has a position, velocity or force that is no number at step {}: the run has become "
      "unstable; use a smaller timestep, or look at what pushes it",
      describe(worst), update->ntimestep);
}

/* ---------------------------------------------------------------------- */

bool FixDefe::is_loose(int i) const
{
  if (!de[i]) return false;
  return std::all_of(std::begin(de[i]->slot), std::end(de[i]->slot), [](const JointSlot &slot) {
    return slot.kind == DefeJoint::NONE || slot.state == DefeJoint::CONTACT;
  });
}

/* ----------------------------------------------------------------------
   LAMMPS deletes atoms that leave through a fixed wall of the box and says how many.
   Named before that, as long as they are here. Loose DEs may go if the user says so
   (thermo_modify lost ignore or warn).
------------------------------------------------------------------------- */

void FixDefe::watch_walls()
{
  // a quick look first

  double lo[3], hi[3];
  for (int d = 0; d < 3; d++) {
    lo[d] = domain->boundary[d][0] == 1 ? domain->boxlo[d] : -std::numeric_limits<double>::max();
    hi[d] = domain->boundary[d][1] == 1 ? domain->boxhi[d] : HUGE_VAL;
  }
  const double *all = atom->nlocal ? atom->x[0] : nullptr;
  int outside = 0;
  for (int i = 0; i < atom->nlocal; i++)
    for (int d = 0; d < 3; d++) outside += !(all[3 * i + d] >= lo[d] && all[3 * i + d] < hi[d]);
  if (!outside) return;

  const bool may_go = output->thermo && output->thermo->lostflag != Thermo::ERROR;
  for (int i = 0; i < atom->nlocal; i++) {
    if (!de[i] && nelem[i] == 0) continue;
    const double *x = atom->x[i];
    int out = -1;
    for (int d = 0; d < 3; d++) {
      if (domain->periodicity[d]) continue;
      if (domain->boundary[d][0] == 1 && !(x[d] >= domain->boxlo[d])) out = d;
      if (domain->boundary[d][1] == 1 && !(x[d] < domain->boxhi[d])) out = d;
      if (!std::isfinite(x[d])) out = d;
    }
    if (out < 0) continue;
    const bool loose = is_loose(i);
    if (!may_go || !loose)
      error->one(
          FLERR,
          "{} has left the box through its wall in {} at step {}: make the box larger or its "
          "boundary s or m{}",
          describe(i), "xyz"[out], update -> ntimestep,
          loose ? ", or let fragments go with thermo_modify lost ignore" : "");
    des_gone++;
    mass_gone += atom->rmass[i];
    ledger.external -= kinetic_energy(i);    // it takes its energy along
  }
}
