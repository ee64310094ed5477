/* ----------------------------------------------------------------------
   DEFE: adaptive finite elements to bonded discrete elements for LAMMPS
   https://www.lammps.org/
   This software is distributed under the GNU General Public License.
------------------------------------------------------------------------- */

// Joints and ties from their strength to their end: the law is coupling/joint_softening.h.

#include "pair_defe_joint.h"

#include "defe_system.h"

#include "atom.h"
#include "update.h"

#include <cmath>

using namespace LAMMPS_NS;
using defe::Vec3;

/* ----------------------------------------------------------------------
   does a joint, or a tie, start to soften?
------------------------------------------------------------------------- */

bool PairDefeJoint::starts(int d, int s)
{
  const auto &jt = sys->joints;
  JointSlot &slot = jt.rec[d]->slot[s];
  const double *h = &jt.half_force[d][3 * s];
  const auto stiffness = laws.stiffness(jt.material[d], jt.len[d][s]);
  auto joint = softening(slot);
  if (jt.nb[d][s] < 0) {    // a tie: all of its force is the DE's half
    const auto &law = sys->model.adhesive_of(jt.material[d], slot.part)->law;
    const auto tie = tie_point(d, s);
    return defe::start_softening(joint, Vec3(h) / slot.area, tie.normal(), tie.normal(),
                                 tie.length(), stiffness, law);
  }
  const int i = jt.self[d], j = jt.nb[d][s], other = jt.partner[d][s];
  const double *g = &jt.half_force[other / 6][3 * (other % 6)];
  const Vec3 t = Vec3(h[0] - g[0], h[1] - g[1], h[2] - g[2]) / slot.area;
  const Vec3 y = Vec3(atom->x[j]) - Vec3(atom->x[i]);
  const double length = y.norm();
  const Vec3 along = y / length;
  const Vec3 normal = d < jt.north ? along : face_normal(d, s, along);
  return defe::start_softening(joint, t, normal, along, length, stiffness,
                               laws.of(atom->type[i], atom->type[j]).cohesive);
}

defe::SofteningJoint PairDefeJoint::softening(JointSlot &slot)
{
  return {slot.cohesive, slot.length0, slot.area, slot.stored, slot.lost, slot.pending};
}

/* ----------------------------------------------------------------------
   softening joints and ties, each by the rank of its lower ID
------------------------------------------------------------------------- */

void PairDefeJoint::cohesive_forces()
{
  auto &jt = sys->joints;
  jt.debonded.clear();
  if (with_cracks) take_over_cracks();
  size_t kept = 0;
  for (size_t q = 0; q < jt.cohesive.size(); q++) {
    const int d = jt.cohesive[q] / 6, s = jt.cohesive[q] % 6;
    const JointSlot &slot = jt.rec[d]->slot[s];
    if (slot.kind == DefeJoint::TIE)
      cohesive_tie(d, s);
    else if (by_crack(d, s))
      crack_forces(d, s);
    else
      cohesive_joint(d, s);
    if (slot.state == DefeJoint::COHESIVE || slot.plane) jt.cohesive[kept++] = jt.cohesive[q];
  }
  jt.cohesive.resize(kept);
}

void PairDefeJoint::cohesive_tie(int d, int s)
{
  auto &jt = sys->joints;
  const int i = jt.self[d];
  JointSlot &slot = jt.rec[d]->slot[s];
  const auto &node = jt.tie_node[~jt.nb[d][s]];
  const double dt = update->setupflag ? 0.0 : update->dt;
  const auto &law = sys->model.adhesive_of(jt.material[d], slot.part)->law;
  const auto tie = tie_point(d, s);
  Vec3 v[4];
  for (int a = 0; a < 4; a++) v[a] = Vec3(atom->v[node[a]]);
  auto joint = softening(slot);
  const auto step =
      defe::soften(joint, tie.normal(), tie.length(), dt * tie.slide(Vec3(atom->v[i]), v),
                   !update->setupflag, laws.stiffness(jt.material[d], jt.len[d][s]), law);
  book(step);
  if (step.law.broken) {
    set_broken(d, s);
    jt.debonded.push_back(6 * d + s);
    event(d, s, defe::EventKind::DEBONDED, step.law.damage);
    return;
  }
  sys->stored.cohesive += slot.stored;

  Vec3 on_node[4];
  tie.reactions(step.force, on_node);
  const auto &grid = sys->sums.force_grid();
  for (int k = 0; k < 3; k++) atom->f[i][k] += sys->sums.on_grid(grid, step.force[k], i);
  for (int a = 0; a < 4; a++) {
    for (int k = 0; k < 3; k++)
      atom->f[node[a]][k] += sys->sums.on_grid(grid, on_node[a][k], node[a]);
    if (!tally.on()) continue;
    // relative to the DE: its own force has no share then
    const double *xa = atom->x[node[a]], *xi = atom->x[i];
    const double del[3] = {xa[0] - xi[0], xa[1] - xi[1], xa[2] - xi[2]};
    tally(del, on_node[a].data(), i);
  }
}

void PairDefeJoint::cohesive_joint(int d, int s)
{
  auto &jt = sys->joints;
  double **v = atom->v, **omega = atom->omega;
  const int i = jt.self[d], j = jt.nb[d][s];
  JointSlot &slot = jt.rec[d]->slot[s];
  const double dt = update->setupflag ? 0.0 : update->dt;
  const Vec3 y = Vec3(atom->x[j]) - Vec3(atom->x[i]);
  const double length = y.norm();
  const Vec3 n = y / length;
  const Vec3 w(0.5 * (omega[i][0] + omega[j][0]), 0.5 * (omega[i][1] + omega[j][1]),
               0.5 * (omega[i][2] + omega[j][2]));
  Vec3 slide = Vec3(v[j][0] - v[i][0], v[j][1] - v[i][1], v[j][2] - v[i][2]) - w.cross(y);
  slide -= slide.dot(n) * n;
  auto joint = softening(slot);
  const auto step = defe::soften(joint, n, length, dt * slide, !update->setupflag,
                                 laws.stiffness(jt.material[d], jt.len[d][s]),
                                 laws.of(atom->type[i], atom->type[j]).cohesive);
  book(step);
  if (step.law.broken) {
    set_broken(d, s);
    event(d, s, defe::EventKind::BROKEN, step.law.damage);
    return;
  }
  sys->stored.cohesive += slot.stored;

  const Vec3 force = sys->sums.rounded_force(step.force, i);
  const Vec3 moment = sys->sums.rounded_torque(0.5 * y.cross(force), i);
  for (int k = 0; k < 3; k++) {
    atom->f[i][k] += force[k];
    atom->f[j][k] -= force[k];
    atom->torque[i][k] += moment[k];
    atom->torque[j][k] += moment[k];
  }
  if (tally.on()) {
    const double del[3] = {-y[0], -y[1], -y[2]};
    tally(del, force.data(), i);
  }
}

void PairDefeJoint::book(const defe::SofteningStep &step)
{
  sys->ledger.fracture += step.fracture;
  sys->ledger.release += step.released;
  sys->ledger.release += step.beside;
}

/* ----------------------------------------------------------------------
   normal of the face that a joint crosses, turned with the DE's cell
------------------------------------------------------------------------- */

Vec3 PairDefeJoint::face_normal(int d, int s, const Vec3 &along) const
{
  const auto &jt = sys->joints;
  const Vec3 xi(atom->x[jt.self[d]]);
  Vec3 y[6];
  for (int q = 0; q < 6; q++) {
    const int nb = jt.nb[d][q];
    y[q] = Vec3(nb >= 0 ? atom->x[nb] : &jt.tie_point[3 * ~nb]) - xi;
  }
  return defe::turned_normal(jt.cell[d - jt.north], jt.present[d], y,
                             Vec3(jt.rec[d]->slot[s].normal), along);
}

defe::TiePoint PairDefeJoint::tie_point(int d, int s) const
{
  const auto &jt = sys->joints;
  Vec3 face[4];
  for (int a = 0; a < 4; a++) face[a] = Vec3(atom->x[jt.tie_node[~jt.nb[d][s]][a]]);
  return {Vec3(atom->x[jt.self[d]]), face};
}
