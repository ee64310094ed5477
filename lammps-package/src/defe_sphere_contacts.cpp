/* ----------------------------------------------------------------------
   DEFE: adaptive finite elements to bonded discrete elements for LAMMPS
   https://www.lammps.org/
   This software is distributed under the GNU General Public License.
------------------------------------------------------------------------- */

#include "defe_sphere_contacts.h"

#include "defe_system.h"

#include "atom.h"
#include "neighbor.h"
#include "update.h"

#include "defe/coupling/near_pairs.h"

#include <algorithm>
#include <cmath>

using namespace LAMMPS_NS;
using defe::Vec3;

namespace {

/// Of one end of a pair (sign 1), or as the other sees it (-1).
defe::TangentialSpring along(const defe::TangentialSpring &t, double sign)
{
  return {{sign * t.s[0], sign * t.s[1], sign * t.s[2]}, t.root};
}

}    // namespace

DefeSphereContacts::DefeSphereContacts(DefeSystem &system, const defe::JointLaws &l) :
    DefeComponent(system), laws(l)
{
}

bool DefeSphereContacts::outdated() const
{
  return built != sys.tables.built();
}

/* ----------------------------------------------------------------------
   spheres near each other that no joint holds
   LAMMPS' neighbour lists would be built over all nodes, so they are found here. Each owner computes its
   side of a pair that two ranks share.
------------------------------------------------------------------------- */

void DefeSphereContacts::add(int i, int j, double distance)
{
  if (!laws.with_contact || j < 0) return;    // a tie: the face takes over
  if (j < atom->nlocal && j < i) std::swap(i, j);
  candidates.push_back({i, j, distance, false});
  broken_now.emplace_back(MIN(atom->tag[i], atom->tag[j]), MAX(atom->tag[i], atom->tag[j]));
}

void DefeSphereContacts::search()
{
  built = sys.tables.built();
  candidates.clear();
  const auto &jt = sys.joints;
  const double *radius = atom->radius;

  // DEs and spheres of other origin that are not much larger go into a grid; large ones, of which
  // there are few, meet all others

  std::vector<int> small(jt.self.begin(), jt.self.end()), large;
  double largest = 0.0;
  for (int i : small) largest = MAX(largest, MAX(radius[i], sys.surface.reach_of(i)));
  const double limit = 4.0 * largest;
  for (int i : sys.tables.others()) {
    if (!jt.of_atom.empty() && jt.of_atom[i] >= 0) continue;
    if (!laws.meets_des[atom->type[i]]) continue;
    (radius[i] <= limit ? small : large).push_back(i);
    if (radius[i] <= limit) largest = MAX(largest, radius[i]);
  }
  if (jt.self.empty()) return;    // spheres of other origin have no law between them
  defe::for_near_pairs(small, large, &atom->x[0][0], 2.0 * largest + sys.in_place.slack(),
                       [this](int i, int j) {
                         consider(i, j);
                       });
}

void DefeSphereContacts::consider(int i, int j)
{
  const auto &jt = sys.joints;
  const int nlocal = atom->nlocal;
  if (i >= nlocal) std::swap(i, j);
  if (i >= nlocal) return;
  if (j < nlocal && j < i) std::swap(i, j);
  const int di = jt.of_atom[i], dj = jt.of_atom[j];
  if (di < 0 && dj < 0) return;
  if (!laws.acts_on(atom->type[i], atom->type[j])) return;
  const bool with_ball = di < 0 || dj < 0;
  // with a ball: by the rank of the DE alone; the ball's force comes back with the ghosts
  if (with_ball && di < 0) {
    if (j >= nlocal) return;
    std::swap(i, j);
  }
  const double reach = (with_ball ? sys.surface.reach_of(i) + sys.surface.reach_of(j)
                                  : atom->radius[i] + atom->radius[j]) +
      sys.in_place.slack();
  const double *xi = atom->x[i], *xj = atom->x[j];
  double rsq = 0.0;
  for (int k = 0; k < 3; k++) rsq += (xi[k] - xj[k]) * (xi[k] - xj[k]);
  if (rsq >= reach * reach) return;
  if (!with_ball && joined(di, j)) return;
  double distance = with_ball ? 0.0 : jt.contact_distance(di, atom->tag[j]);
  if (!with_ball && sys.tables.glued(i, j)) distance = 0.5 * (atom->radius[i] + atom->radius[j]);
  candidates.push_back({i, j, distance, false});
}

bool DefeSphereContacts::joined(int de, int j) const
{
  const auto &jt = sys.joints;
  for (int s = 0; s < 6; s++) {
    const int nb = jt.nb[de][s];    // a joint may have broken since the tables were made
    if (nb >= 0 && nb != jt.self[de] && atom->tag[nb] == atom->tag[j] &&
        jt.state[6 * de + s] != DefeJoint::CONTACT)    // its plane may still take it
      return true;
  }
  return false;
}

/* ---------------------------------------------------------------------- */

void DefeSphereContacts::forces(const defe::VirialTally &tally)
{
  std::sort(broken_now.begin(), broken_now.end());
  for (auto &c : candidates) {
    if (sys.joints.of_atom[c.j] < 0)
      contact_with_ball(c.i, c.j, tally);
    else
      contact(c, tally);
  }
  broken_now.clear();
}

/* ----------------------------------------------------------------------
   distance below which two DEs are in contact, given the square of that now; 0 if they are not.
   Spheres of flat cells overlap from the start: contact begins at the reference distance.
------------------------------------------------------------------------- */

double DefeSphereContacts::reach_of(const Candidate &c, double rsq) const
{
  double reach = atom->radius[c.i] + atom->radius[c.j];
  if (rsq >= reach * reach) return 0.0;
  const double *Xa = sys.store.x_frame(c.i), *Xb = sys.store.x_frame(c.j);
  double ref = 0.0;
  for (int k = 0; k < 3; k++) ref += (Xa[k] - Xb[k]) * (Xa[k] - Xb[k]);
  reach = MIN(reach, std::sqrt(ref));
  if (c.distance > 0.0) reach = MIN(reach, c.distance);
  return rsq >= reach * reach ? 0.0 : reach;
}

/* ---------------------------------------------------------------------- */

defe::DEMaterial DefeSphereContacts::material_of(int i) const
{
  const int part = sys.joints.material[sys.joints.of_atom[i]];
  return {laws.young[part], laws.poisson(part)};
}

defe::NormalSpring DefeSphereContacts::spring_of(int i, int j, double reach, double overlap) const
{
  const auto &law = defe::normal_law(laws.of(atom->type[i], atom->type[j]).normal_law);
  return law.between_des(
      overlap, {{material_of(i), material_of(j)}, {atom->radius[i], atom->radius[j]}, reach});
}

defe::ContactParameters DefeSphereContacts::parameters(int i, int j,
                                                       const defe::NormalSpring &spring) const
{
  const defe::JointCoeff &coeff = laws.of(atom->type[i], atom->type[j]);
  return {spring.kn, spring.kt, coeff.restitution, coeff.friction,
          coeff.damping_ratio * spring.damping_factor};
}

void DefeSphereContacts::contact(Candidate &c, const defe::VirialTally &tally)
{
  const int i = c.i, j = c.j;
  double **v = atom->v, **omega = atom->omega;
  // the two owners compute the same numbers if both begin with the same DE
  const bool turned = sys.model.reproducible && atom->tag[i] > atom->tag[j];
  const int a = turned ? j : i, b = turned ? i : j;
  const double sign = turned ? -1.0 : 1.0;
  const bool whole = j < atom->nlocal;    // else the other half belongs to the other owner
  const double *xa = atom->x[a], *xb = atom->x[b], *mass = atom->rmass;
  const Vec3 del = Vec3(xa) - Vec3(xb);
  const double rsq = del[0] * del[0] + del[1] * del[1] + del[2] * del[2];
  const double reach = reach_of({a, b, c.distance, false}, rsq);
  const double overlap = reach > 0.0 ? reach - del.norm() : 0.0;
  if (!(overlap > 0.0)) {
    if (c.apart) return;    // most are, and looking for their records costs more than all else
    c.apart = true;
    const double rest = forget_contact(i, j);
    if (whole) forget_contact(j, i);
    if (!update->setupflag) sys.ledger.friction += (whole ? 1.0 : 0.5) * rest;
    return;
  }
  c.apart = false;
  const auto push = spring_of(a, b, reach, overlap);
  const auto par = parameters(a, b, push);
  const double dt = update->setupflag ? 0.0 : update->dt;
  defe::TangentialSpring &tangential = spring(i, j), of_a = along(tangential, sign);
  auto r = defe::sphere_contact(del, Vec3(v[a]) - Vec3(v[b]), Vec3(omega[a]), Vec3(omega[b]),
                                atom->radius[a], atom->radius[b], reach,
                                mass[a] * mass[b] / (mass[a] + mass[b]), dt, of_a, par);
  r.stored += push.energy_beyond(overlap);
  // the evaluation before a run is no step: springs stay as they are, nothing is rubbed off
  if (update->setupflag)
    r.stored += tangential.stored() - of_a.stored();
  else {
    tangential = along(of_a, sign);
    if (whole) spring(j, i) = along(of_a, -sign);
  }

  const Vec3 force = sys.sums.rounded_force(r.force, i);
  const Vec3 torque_i = sys.sums.rounded_torque(turned ? r.torque_j : r.torque_i, i);
  for (int k = 0; k < 3; k++) {
    atom->f[i][k] += sign * force[k];
    atom->torque[i][k] += torque_i[k];
  }
  if (whole) {
    const Vec3 torque_j = sys.sums.rounded_torque(turned ? r.torque_i : r.torque_j, j);
    for (int k = 0; k < 3; k++) {
      atom->f[j][k] -= sign * force[k];
      atom->torque[j][k] += torque_j[k];
    }
  }
  const double share = whole ? 1.0 : 0.5;
  book(i, j, share, r);
  if (tally.on()) {
    const Vec3 half = share * del;
    tally(half.data(), r.force.data(), i);
  }
}

void DefeSphereContacts::book(int i, int j, double share, const defe::ContactResult &r)
{
  sys.stored.contact += share * r.stored;
  // a joint that broke while it was pressed: this much of what it held is still here
  if (!broken_now.empty() &&
      std::binary_search(
          broken_now.begin(), broken_now.end(),
          std::make_pair(MIN(atom->tag[i], atom->tag[j]), MAX(atom->tag[i], atom->tag[j]))))
    sys.ledger.release -= share * r.stored;
  if (update->setupflag) return;
  sys.ledger.damping += share * r.damped;
  sys.ledger.friction += share * r.rubbed;
}

/* ----------------------------------------------------------------------
   a DE of this rank and a sphere of other origin, owned or ghost; a DE that was just born takes over what the face
   of its element stored
------------------------------------------------------------------------- */

void DefeSphereContacts::contact_with_ball(int i, int j, const defe::VirialTally &tally)
{
  double **x = atom->x;
  double **v = atom->v;
  double **omega = atom->omega;
  const auto &jt = sys.joints;
  const double dt = update->setupflag ? 0.0 : update->dt;
  const Vec3 del = Vec3(x[i]) - Vec3(x[j]), speed = Vec3(v[i]) - Vec3(v[j]);
  const double ri = sys.surface.reach_of(i), rj = atom->radius[j], distance = del.norm();
  const double overlap = ri + rj - distance;
  SphereContact *known = find_contact(i, j);
  const bool inherits = known && known->inherit >= 0.0;
  const double offset = known ? known->offset : 0.0;
  if (!inherits && overlap <= offset) {
    const double rest = forget_contact(i, j);
    if (!update->setupflag) sys.ledger.friction += rest;
    return;
  }
  const int part = jt.material[jt.of_atom[i]];
  const double area = jt.rec(jt.of_atom[i])->outer_area;
  const double k_area = sys.surface.ball_stiffness(part, i) / area;
  if (!(k_area > 0.0)) return;
  const auto &law = defe::normal_law(laws.of(atom->type[i], atom->type[j]).normal_law);
  const defe::SphereOnDE pair{rj, material_of(i), atom->radius[i], area, k_area};
  if (!known) {
    known = &new_contact(i, j);
    // an overlap that no motion has made
    if (overlap > 4.0 * dt * speed.norm() + 1.0e-6 * ri) known->offset = overlap;
  } else if (inherits)
    known->offset = overlap - law.overlap_of_energy(known->inherit, pair);
  const double deep = overlap - known->offset;
  if (!(deep > 0.0)) {
    if (inherits) known->inherit = -1.0;
    return;
  }

  const auto push = law.sphere_on_de(deep, pair);
  const auto par = parameters(i, j, push);
  defe::TangentialSpring tangential = known->tangential;
  auto r = defe::sphere_contact(
      del, speed, Vec3(omega[i]), Vec3(omega[j]), ri, rj, ri + rj - known->offset,
      atom->rmass[i] * atom->rmass[j] / (atom->rmass[i] + atom->rmass[j]), dt, tangential, par);
  r.stored += push.energy_beyond(deep);
  if (inherits) {
    // the kicks of velocity Verlet belong to the old force up to half-way between the two steps
    sys.ledger.conv_strain -=
        push.energy + 0.5 * dt * (push.force - known->push) * speed.dot(del) / distance;
    known->inherit = -1.0;
  }
  // the evaluation before a run is no step: springs stay as they are, nothing is rubbed off
  if (update->setupflag)
    r.stored += known->tangential.stored() - tangential.stored();
  else {
    known->tangential = tangential;
    sys.ledger.damping += r.damped;
    sys.ledger.friction += r.rubbed;
  }
  const Vec3 force = sys.sums.rounded_force(r.force, i);
  const Vec3 torque_i = sys.sums.rounded_torque(r.torque_i, i);
  const Vec3 torque_j = sys.sums.rounded_torque(r.torque_j, j);
  for (int k = 0; k < 3; k++) {
    atom->f[i][k] += force[k];
    atom->f[j][k] -= force[k];
    atom->torque[i][k] += torque_i[k];
    atom->torque[j][k] += torque_j[k];
  }
  sys.stored.contact += r.stored;
  if (tally.on()) tally(del.data(), r.force.data(), i);
}

/* ----------------------------------------------------------------------
   contacts of atom i
------------------------------------------------------------------------- */

SphereContact *DefeSphereContacts::find_contact(int i, int j) const
{
  AtomContacts *t = sys.store.contacts_of(i);
  if (t)
    for (auto &s : t->spheres)
      if (s.other == atom->tag[j]) return &s;
  return nullptr;
}

SphereContact &DefeSphereContacts::new_contact(int i, int j)
{
  auto &list = sys.store.contacts_at(i).spheres;
  list.push_back({atom->tag[j], {}, 0.0, -1.0, 0.0});
  return list.back();
}

defe::TangentialSpring &DefeSphereContacts::spring(int i, int j)
{
  SphereContact *known = find_contact(i, j);
  return (known ? *known : new_contact(i, j)).tangential;
}

/// Returns the energy that its spring still had.
double DefeSphereContacts::forget_contact(int i, int j)
{
  AtomContacts *t = sys.store.contacts_of(i);
  if (!t) return 0.0;
  for (auto &s : t->spheres)
    if (s.other == atom->tag[j]) {
      const double rest = s.tangential.stored();
      s = t->spheres.back();
      t->spheres.pop_back();
      return rest;
    }
  return 0.0;
}

double DefeSphereContacts::memory_usage() const
{
  return static_cast<double>(candidates.capacity()) * sizeof(Candidate);
}
