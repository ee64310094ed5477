/* ----------------------------------------------------------------------
   DEFE: adaptive finite elements to bonded discrete elements for LAMMPS
   https://www.lammps.org/
   This software is distributed under the GNU General Public License.
------------------------------------------------------------------------- */

#include "defe_system.h"

#include "atom.h"
#include "comm.h"
#include "domain.h"
#include "error.h"
#include "update.h"

#include <algorithm>

using namespace LAMMPS_NS;
using defe::Vec3;

DefeTables::DefeTables(DefeSystem &system) : DefeComponent(system), outer(system) {}

/* ----------------------------------------------------------------------
   local indices of everything; once per reneighbouring
------------------------------------------------------------------------- */

void DefeTables::build()
{
  sys.account.begin_run();
  if (sys.ids.natoms_changed()) sys.ids.check_newcomers();
  update_frames();
  sys.work.list_forced();
  sys.elements.build();
  sys.tied.build();
  sys.strengths.elements_listed();
  build_joints();
  sys.strengths.joints_listed();
  sys.surface.build();
  built_++;
  sys.account.forget();
  if (sys.model.checking) {
    sys.elements.check();
    sys.audit.records("after reneighbouring");
    sys.audit.masses();
  }
}

void DefeTables::forget()
{
  sys.tied.forget();
  sys.tied_des.forget();
  sys.joints.clear();
  tied_.clear();
  sys.surface.forget();
}

/* ----------------------------------------------------------------------
   reference positions in the periodic frame of x, for owned and ghost atoms, and DEs seen from outside
------------------------------------------------------------------------- */

void DefeTables::update_frames()
{
  sys.mesh.check_closed();
  const int nlocal = atom->nlocal;
  const int nall = nlocal + atom->nghost;
  const auto at_home = (static_cast<imageint>(IMGMAX) << IMG2BITS) |
      (static_cast<imageint>(IMGMAX) << IMGBITS) | IMGMAX;
  const auto update_frame = [&](int i) {
    double *X = sys.store.x_frame(i);
    for (int k = 0; k < 3; k++) X[k] = sys.store.x_ref(i)[k];
    if (atom->image[i] != at_home) domain->unmap_inv(X, atom->image[i]);
  };
  if (sys.elements.repairable()) {    // the others are in the images in which they were
    for (int i : sys.store.changed())
      if (i < nlocal) update_frame(i);
  } else
    for (int i = 0; i < nlocal; i++) update_frame(i);
  outer.clear();
  outer.resize(nall);
  find_others();
  const auto &des = sys.store.de_atoms();
  for (size_t k = 0; k < des.size(); k++) {
    if (k + 6 < des.size()) __builtin_prefetch(sys.store.de(des[k + 6]));
    const int i = des[k];
    const DERecord *r = sys.store.de(i);
    outer.set(i, r->outer_distance,
              sys.model.parts[r->part].split.half() * r->outer_area * r->outer_area / r->volume,
              sys.tied_des.of_de(i) ? r->part + 1 : 0);
  }
  sys.ghosts.forward(outer, Outer::SIZE);
}

/* ----------------------------------------------------------------------
   most atoms are nodes, and are left alone
------------------------------------------------------------------------- */

void DefeTables::Outer::set(int i, double distance, double its_length, int glue)
{
  known.push_back(i);
  reach[i] = distance;
  length[i] = its_length;
  glued[i] = glue;
}

void DefeTables::Outer::clear()
{
  for (int i : known) {
    reach[i] = length[i] = 0.0;
    glued[i] = 0;
  }
  known.clear();
}

void DefeTables::Outer::resize(int n)
{
  reach.resize(n, 0.0);
  length.resize(n, 0.0);
  glued.resize(n, 0);
}

/* ----------------------------------------------------------------------
   spheres that are no DEs, owned and ghost
------------------------------------------------------------------------- */

void DefeTables::find_others()
{
  const int nall = atom->nlocal + atom->nghost;
  const auto is_one = [this](int i) {
    return atom->radius[i] > 0.0 && !(i < atom->nlocal && sys.store.de(i));
  };
  if (!sys.in_place.going_on()) {
    others_.clear();
    for (int i = 0; i < nall; i++)
      if (is_one(i)) others_.push_back(i);
    return;
  }
  others_.erase(std::remove_if(others_.begin(), others_.end(),
                               [this](int i) {
                                 return sys.store.changed(i);
                               }),
                others_.end());
  for (int i : sys.store.changed())
    if (i < nall && is_one(i)) others_.push_back(i);
  std::sort(others_.begin(), others_.end());
}

bool DefeTables::glued(int i, int j) const
{
  return outer.glued[i] && outer.glued[j] &&
      sys.model.are_tied(outer.glued[i] - 1, outer.glued[j] - 1);
}

int DefeTables::Outer::pack_forward(int n, const int *list, const double *shift, double *buf)
{
  int m = 0;
  for (int ii = 0; ii < n; ii++) {
    for (int k = 0; k < 3; k++) buf[m++] = sys.store.x_frame(list[ii])[k] + shift[k];
    buf[m++] = reach[list[ii]];
    buf[m++] = length[list[ii]];
    buf[m++] = ubuf(glued[list[ii]]).d;
  }
  return m;
}

void DefeTables::Outer::unpack_forward(int n, int first, const double *buf)
{
  int m = 0;
  for (int i = first; i < first + n; i++) {
    for (int k = 0; k < 3; k++) sys.store.x_frame(i)[k] = buf[m++];
    if (buf[m] > 0.0) set(i, buf[m], buf[m + 1], static_cast<int>(ubuf(buf[m + 2]).i));
    m += 3;
  }
}

/* ----------------------------------------------------------------------
   discrete elements and their joints: first those with orthogonal cells
------------------------------------------------------------------------- */

void DefeTables::build_joints()
{
  auto &jt = sys.joints;
  const int nlocal = atom->nlocal;
  jt.clear();
  sys.tied_des.forget();
  tied_.clear();
  first_tied_.assign(1, 0);
  fresh_.clear();
  outer_area_.clear();
  jt.of_atom.resize(nlocal + atom->nghost, -1);
  if (sys.census.des() == 0) return;
  general_drafts.clear();
  const auto &des = sys.store.de_atoms();
  for (size_t k = 0; k < des.size(); k++) {
    if (k + 2 < des.size()) prefetch(sys.store.de(des[k + 2]));
    const int i = des[k];
    Draft draft;
    defe::GeneralCell cell;
    draft_cell(i, draft, cell);
    const bool tied = sys.tied_des.shape(i, cell);
    if (sys.prestress.on()) make_stress_free(draft, cell);
    if (!tied && defe::is_orthogonal(cell))
      add_de(draft);
    else {
      general_drafts.push_back(draft);
      jt.cell.push_back(cell);
    }
  }
  jt.orthogonal = static_cast<int>(jt.self.size());
  for (const Draft &draft : general_drafts) add_de(draft);
  list_des();
  for (int d = 0; d < jt.nde; d++) {
    if (d + 4 < jt.nde) prefetch(jt.rec(d + 4));
    if (d + 2 < jt.nde) {
      prefetch(jt.rec(d + 2)->soft.get());
      prefetch(jt.rec(d + 2)->tie.get());
    }
    fill_slots(d);
  }
  for (int d = jt.orthogonal; d < jt.nde; d++) sys.tied_des.add_places(jt, d);
  jt.tie_point.assign(3 * (jt.tie_node.size() + jt.places()) + 3, 0.0);
}

void DefeTables::draft_cell(int i, Draft &draft, defe::GeneralCell &cell)
{
  DERecord &r = *sys.store.de(i);
  draft.atom = i;
  cell.tie = cell.free = 0;
  for (int s = 0; s < 6; s++) {
    JointRecord &slot = r.slot[s];
    if (slot.kind == DefeJoint::NONE) cell.free |= 1 << s;
    draft.nb[s] = i;
    cell.dX[s].setZero();
    cell.face[s] = Vec3(slot.face);
    draft.len[s] = draft.half[s] = cell.face[s].norm();
    if (slot.kind == DefeJoint::DE && (slot.state != DefeJoint::CONTACT || slot.plane)) {
      const int j = sys.ids.nearest_to(i, r.other[s]);
      if (j < 0 && slot.plane) {    // the other fragment was deleted
        slot.plane = 0;
        continue;
      }
      if (j < 0)
        error->one(FLERR,
                   "DE {} is joined to DE {}, which is missing on proc {} at step {}: it was "
                   "lost or deleted, or the communication cutoff is too small",
                   atom->tag[i], r.other[s], comm->me, update->ntimestep);
      for (int k = 0; k < 3; k++) cell.dX[s][k] = sys.store.x_frame(j)[k] - sys.store.x_frame(i)[k];
      draft.nb[s] = j;
      draft.len[s] = cell.dX[s].norm();
    } else if (slot.kind == DefeJoint::TIE && slot.state != DefeJoint::CONTACT) {
      cell.tie |= 1 << s;
      cell.dX[s] = cell.face[s];
    }
  }
}

/* ----------------------------------------------------------------------
   what a DE's corners measure strain from, if its body has a stress before any load
------------------------------------------------------------------------- */

void DefeTables::make_stress_free(Draft &draft, defe::GeneralCell &cell)
{
  draft.stress_free = sys.prestress.map_of_de(draft.atom);
  cell = defe::stress_free_cell(cell, draft.stress_free);
  for (int s = 0; s < 6; s++) {
    draft.half[s] = cell.face[s].norm();
    draft.len[s] = cell.dX[s].squaredNorm() > 0.0 ? cell.dX[s].norm() : draft.half[s];
  }
}

void DefeTables::add_de(const Draft &c)
{
  auto &jt = sys.joints;
  jt.of_atom[c.atom] = static_cast<int>(jt.self.size());
  jt.self.push_back(c.atom);
  jt.records.push_back(sys.store.de(c.atom));
  jt.nb.push_back(c.nb);
  jt.len.push_back(c.len);
  jt.half.push_back(c.half);
  if (sys.prestress.on()) jt.stress_free.push_back(c.stress_free);
}

/* ----------------------------------------------------------------------
   ghosts, and what there is of each
------------------------------------------------------------------------- */

void DefeTables::list_des()
{
  auto &jt = sys.joints;
  const int n = jt.nde = static_cast<int>(jt.self.size());
  for (int i = atom->nlocal; i < atom->nlocal + atom->nghost; i++)
    if (outer.reach[i] > 0.0) {
      jt.of_atom[i] = static_cast<int>(jt.self.size());
      jt.self.push_back(i);
    }
  jt.nall = static_cast<int>(jt.self.size());
  jt.partner.resize(n);
  jt.present.assign(n, 0);
  jt.free.assign(n, 0);
  jt.material.resize(n);
  jt.half_force.assign(18 * static_cast<size_t>(jt.nall), 0.0);
  jt.energy.assign(jt.nall, 0.0);
  jt.state.assign(6 * static_cast<size_t>(jt.nall), DefeJoint::CONNECTIVE);
}

void DefeTables::fill_slots(int d)
{
  auto &jt = sys.joints;
  DERecord &r = *jt.rec(d);
  jt.material[d] = static_cast<unsigned char>(r.part);
  outer_area_.push_back(r.outer_area);
  if (r.newborn) jt.newborn.push_back(d);
  if (r.fresh) fresh_.push_back(d);
  for (int s = 0; s < 6; s++) {
    const JointRecord &slot = r.slot[s];
    if (slot.kind == DefeJoint::TIE)
      tied_.push_back({d, slot.part, r.other[s], Vec3(slot.face).dot(Vec3(slot.normal))});
    if (slot.kind == DefeJoint::NONE) jt.free[d] |= 1 << s;
    jt.partner[d][s] = -1;
    jt.state[6 * d + s] = slot.plane ? DefeJoint::PLANE : slot.state;
    if (r.contact_distance(s) > 0.0)
      jt.contact_distances.push_back({d, r.other[s], r.contact_distance(s)});
    if (slot.kind == DefeJoint::NONE || jt.state[6 * d + s] == DefeJoint::CONTACT) continue;
    if (slot.kind == DefeJoint::DE) {
      const int j = jt.nb[d][s];
      if (jt.of_atom[j] >= 0) jt.partner[d][s] = 6 * jt.of_atom[j] + slot.partner;
    } else
      add_tie(d, s);
    if (slot.state == DefeJoint::CONNECTIVE) jt.present[d] |= 1 << s;
    if (slot.pending == 1) jt.pending.push_back(6 * d + s);
    // a joint is computed by its lower ID, a tie by its only DE
    if ((slot.state == DefeJoint::COHESIVE || slot.plane) &&
        (slot.kind == DefeJoint::TIE || atom->tag[jt.self[d]] < r.other[s]))
      jt.cohesive.push_back(6 * d + s);
  }
  first_tied_.push_back(static_cast<int>(tied_.size()));
}

void DefeTables::add_tie(int d, int s)
{
  auto &jt = sys.joints;
  const int i = jt.self[d];
  const DERecord &r = *jt.rec(d);
  std::array<int, 4> node;
  for (int k = 0; k < 4; k++) {
    node[k] = sys.ids.nearest_to(i, r.tie->of[s][k]);
    if (node[k] < 0)
      error->one(FLERR, "Node {} of the face that DE {} is tied to is missing at step {}",
                 r.tie->of[s][k], atom->tag[i], update->ntimestep);
  }
  jt.nb[d][s] = ~static_cast<int>(jt.tie_node.size());
  jt.tie_node.push_back(node);
  jt.tie_element.push_back(r.other[s]);
  jt.tie_part.push_back(r.slot[s].part);
  jt.tie_spot.push_back(sys.model.parts[r.part].split.spot(r.corner, s));
  if (r.slot[s].asks) jt.asking.push_back(6 * d + s);
}

/* ----------------------------------------------------------------------
   strain energy of the corners of one owned DE at the current positions
------------------------------------------------------------------------- */

double DefeTables::de_energy(int d, unsigned present) const
{
  Vec3 half_force[6];
  return sys.joints.corner_energy(d, present, &atom->x[0][0],
                                  sys.model.corner_moduli[sys.joints.material[d]], half_force);
}
