/* ----------------------------------------------------------------------
   DEFE: adaptive finite elements to bonded discrete elements for LAMMPS
   https://www.lammps.org/
   This software is distributed under the GNU General Public License.
------------------------------------------------------------------------- */

#include "defe_system.h"
#include "rendezvous.h"

#include "atom.h"
#include "error.h"
#include "force.h"
#include "update.h"

#include "defe/fe/hex8.h"

#include <algorithm>
#include <cmath>
#include <unordered_set>

using namespace LAMMPS_NS;
using defe::fe::HexCoords;
using Rendezvous::Letters;

struct DefeAudit::Element {
  tagint id;
  HexPod pod;
};

/** One half of a joint. */
struct DefeAudit::Joint {
  tagint to, from;    // from = 0: this is the DE `to` itself
  int slot, partner, state;
  tagint element;

  // both halves have the same
  tagint low() const { return MIN(to, from); }
  int low_slot() const { return from < to ? slot : partner; }
};

struct DefeAudit::Tie {
  tagint element, from;
  tagint node[4];
};

/* ----------------------------------------------------------------------
   elements, nodes, DEs and joints as the ranks know them, against each other
   needs no ghosts and no tables; collective
------------------------------------------------------------------------- */

void DefeAudit::records(const char *when) const
{
  sys.census.check(when);
  std::vector<Element> here;
  Known known;
  elements(when, here, known);
  neighbours(when, known);
  nodes(when);
  joints(when, known);
}

/* ----------------------------------------------------------------------
   elements: at their first node, and once
------------------------------------------------------------------------- */

void DefeAudit::elements(const char *when, std::vector<Element> &here, Known &known) const
{
  const int nlocal = atom->nlocal;
  Letters<Element> elements(lmp);
  for (int i = 0; i < nlocal; i++)
    for (const auto &h : sys.store.hexes(i)) {
      if (h.node[0] != atom->tag[i])
        error->one(
            FLERR,
            "Fix defe {} at step {}: element {} of part {} belongs to node {}, but is kept by "
            "atom {}: atom IDs were changed (use delete_atoms with 'compress no')",
            when, update->ntimestep, h.id, sys.model.parts[h.part].name, h.node[0], atom->tag[i]);
      elements.to_id(h.id, {h.id, h});
    }
  here = elements.send();
  for (const auto &e : here)
    if (!known.emplace(e.id, &e.pod).second)
      error->one(FLERR, "Fix defe {} at step {}: element {} is known to two ranks", when,
                 update->ntimestep, e.id);
}

/* ----------------------------------------------------------------------
   neighbours are mutual; what is said to be converted is no longer an element
------------------------------------------------------------------------- */

void DefeAudit::neighbours(const char *when, const Known &known) const
{
  const int nlocal = atom->nlocal;
  struct Side {
    tagint to, from;
    int face, from_face;
  };
  Letters<Side> sides(lmp);
  for (int i = 0; i < nlocal; i++)
    for (const auto &h : sys.store.hexes(i))
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
}

/* ----------------------------------------------------------------------
   nodes: each there, and with as many elements as it believes to have
------------------------------------------------------------------------- */

void DefeAudit::nodes(const char *when) const
{
  const int nlocal = atom->nlocal;
  struct Use {
    tagint node, element;
    int count, is_node, part;
  };
  Letters<Use> uses(lmp);
  for (int i = 0; i < nlocal; i++) {
    if (sys.store.is_node(i))
      uses.to_id(atom->tag[i], {atom->tag[i], 0, sys.store.elements_at(i), 1, 0});
    for (const auto &h : sys.store.hexes(i))
      for (tagint t : h.node) uses.to_id(t, {t, h.id, 1, 0, h.part});
  }
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
                 when, update->ntimestep, node.node, node.element, sys.model.parts[node.part].name);
    int count = 0;
    for (k++; k < came.size() && came[k].node == node.node; k++) {
      if (came[k].is_node)
        error->one(FLERR, "Fix defe {} at step {}: node {} is known to two ranks", when,
                   update->ntimestep, node.node);
      count++;
    }
    if (count != node.count)
      error->one(FLERR,
                 "Fix defe {} at step {}: node {} has {} elements, not {}: some were deleted; only "
                 "whole bodies can be",
                 when, update->ntimestep, node.node, count, node.count);
  }
}

/* ----------------------------------------------------------------------
   DEs and their joints: both sides there, and in one state; ties end at elements
------------------------------------------------------------------------- */

void DefeAudit::joints(const char *when, const Known &known) const
{
  const int nlocal = atom->nlocal;
  Letters<Joint> joints(lmp);
  Letters<Tie> ties(lmp);
  for (int i = 0; i < nlocal; i++) {
    if (!sys.store.de(i)) continue;
    const DERecord &r = *sys.store.de(i);
    const tagint me = atom->tag[i];
    if (me != sys.ids.de_tag(r.lot, r.corner))
      error->one(FLERR,
                 "Fix defe {} at step {}: DE {} of element {} has the atom ID {}: atom IDs were "
                 "changed (use delete_atoms with 'compress no')",
                 when, update->ntimestep, r.corner + 1, r.element, me);
    joints.to_id(me, {me, 0, 0, 0, 0, r.element});
    for (int s = 0; s < 6; s++) {
      const JointRecord &slot = r.slot[s];
      if (slot.kind == DefeJoint::DE)
        joints.to_id(r.other[s], {r.other[s], me, s, slot.partner, slot.state, r.element});
      else if (slot.kind == DefeJoint::TIE && slot.state != DefeJoint::CONTACT) {
        Tie t{r.other[s], me, {0, 0, 0, 0}};
        for (int k = 0; k < 4; k++) t.node[k] = r.tie->of[s][k];
        ties.to_id(r.other[s], t);
      }
    }
  }
  both_sides(when, one_side(when, joints.send(), known));
  ends_of_ties(when, ties.send(), known);
}

/* ----------------------------------------------------------------------
   DEs are there once, and so are those that they are joined to; returns the halves of joints that meet here
------------------------------------------------------------------------- */

std::vector<DefeAudit::Joint> DefeAudit::one_side(const char *when, const std::vector<Joint> &came,
                                                  const Known &known) const
{
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
  return halves.send();
}

/* ----------------------------------------------------------------------
   each half of a joint looks for the other one: (to, from, partner) = (from, to, slot)
------------------------------------------------------------------------- */

void DefeAudit::both_sides(const char *when, std::vector<Joint> pairs) const
{
  std::sort(pairs.begin(), pairs.end(), [](const Joint &a, const Joint &b) {
    if (a.low() != b.low()) return a.low() < b.low();
    if (a.low_slot() != b.low_slot()) return a.low_slot() < b.low_slot();
    return a.from < b.from;
  });
  for (size_t k = 0; k < pairs.size(); k += 2) {
    const Joint &a = pairs[k];
    const Joint *b = k + 1 < pairs.size() ? &pairs[k + 1] : nullptr;
    if (!b || b->from != a.to || b->to != a.from || b->slot != a.partner || b->partner != a.slot) {
      // the other side was deleted after the joint had broken
      if (a.state == DefeJoint::CONTACT &&
          (!b || b->low() != a.low() || b->low_slot() != a.low_slot())) {
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
}

void DefeAudit::ends_of_ties(const char *when, const std::vector<Tie> &ties,
                             const Known &known) const
{
  for (const auto &t : ties) {
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

void DefeAudit::masses() const
{
  const int nlocal = atom->nlocal;
  struct Share {
    tagint node;
    int is_node;
    double mass;
  };
  Letters<Share> shares(lmp);
  double mine = sys.census.mass_gone(), all = 0.0;
  for (int i = 0; i < nlocal; i++) {
    if (sys.store.is_ours(i)) mine += atom->rmass[i];
    if (sys.store.is_node(i)) shares.to_id(atom->tag[i], {atom->tag[i], 1, atom->rmass[i]});
  }
  HexCoords x, X;
  for (const auto &b : sys.elements.batches())
    for (int e = 0; e < b.size(); e++) {
      sys.elements.coords(b.nodes(e).data(), x, X);
      const HexRecord &h = *b.hex[e];
      const double volume = defe::fe::volume(X);
      if (!(std::abs(volume - h.volume) <= 1.0e-11 * volume))
        error->one(FLERR,
                   "Fix defe at step {}: element {} has volume {:.15g}, its nodes give {:.15g}",
                   update->ntimestep, h.id, h.volume, volume);
      const double mass = 0.125 * sys.model.element_mass(sys.model.parts[h.part], h.volume);
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
  if (!(std::abs(all - sys.census.mass()) <= 1.0e-12 * sys.census.mass()))
    error->all(FLERR, "Fix defe at step {}: the total mass is {:.15g}, it was {:.15g}",
               update->ntimestep, all, sys.census.mass());
}

/* ----------------------------------------------------------------------
   before a run: were atoms deleted since the last one, and may they be?
------------------------------------------------------------------------- */

void DefeAudit::account_for_deleted() const
{
  for (int i = 0; i < atom->nlocal; i++) {
    const DERecord *r = sys.store.de(i);
    const auto &list = sys.store.hexes(i);
    const bool renumbered = r ? atom->tag[i] != sys.ids.de_tag(r->lot, r->corner)
                              : !list.empty() && list.front().node[0] != atom->tag[i];
    if (renumbered)
      error->one(
          FLERR,
          "Atom IDs were changed since fix defe made its records (atom {} is an example): use "
          "delete_atoms with 'compress no', and no reset_atoms id",
          atom->tag[i]);
  }
  if (!sys.census.recount()) return;
  records("after atoms were deleted");
  if (!force->pair_match("defe/contact", 1)) ties_of_faces();    // there they hold nothing
}

/* ----------------------------------------------------------------------
   elements do not know their ties, but which DEs are behind their faces
------------------------------------------------------------------------- */

void DefeAudit::ties_of_faces() const
{
  struct Behind {
    tagint de, element;    // element = 0: the DE itself
  };
  Letters<Behind> letters(lmp);
  for (int i = 0; i < atom->nlocal; i++) {
    if (sys.store.de(i)) letters.to_id(atom->tag[i], {atom->tag[i], 0});
    for (const auto &h : sys.store.hexes(i))
      for (int f = 0; f < 6; f++)
        // behind an adhesive the DE may have come loose before it was deleted: nobody knows now
        if (h.nb[f] < 0 && !sys.model.adhesive_of(h.nbpart[f], h.part))
          for (int k : sys.model.parts[h.nbpart[f]].split.on_face(h.nbface[f])) {
            const tagint tag = sys.ids.de_tag(-h.nb[f], k);
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
