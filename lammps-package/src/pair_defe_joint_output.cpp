/* ----------------------------------------------------------------------
   DEFE: adaptive finite elements to bonded discrete elements for LAMMPS
   https://www.lammps.org/
   This software is distributed under the GNU General Public License.

   What one can see of a joint: for compute defe/joint/local.
------------------------------------------------------------------------- */

#include "pair_defe_joint.h"

#include "defe_cracks.h"
#include "defe_system.h"

#include "atom.h"

#include <Eigen/Geometry>

using namespace LAMMPS_NS;
using defe::Vec3;

/* ----------------------------------------------------------------------
   of the positions and half forces of the last force evaluation, as in criterion() and in
   cohesive_forces()
------------------------------------------------------------------------- */

PairDefeJoint::JointView PairDefeJoint::view(int d, int s) const
{
  const auto &jt = sys->joints;
  const JointSlot &slot = jt.rec[d]->slot[s];
  const bool tie = slot.kind == DefeJoint::TIE;
  const int i = jt.self[d], j = jt.nb[d][s];
  const Vec3 xi(atom->x[i]);
  JointView v;
  Vec3 y;
  if (tie) {
    const auto point = tie_point(d, s);
    y = point.y();
    v.normal = point.normal();
    v.point = xi + y;
  } else {
    y = Vec3(atom->x[j]) - xi;
    v.normal = y.normalized();
    v.point = xi + 0.5 * y;
  }
  v.length = y.norm();
  v.damage = v.opening = v.slip = 0.0;

  if (slot.state == DefeJoint::CONNECTIVE) {
    Vec3 force(&jt.half_force[d][3 * s]);
    if (!tie) {
      const int other = jt.partner[d][s];
      force -= Vec3(&jt.half_force[other / 6][3 * (other % 6)]);
      if (d >= jt.north) v.normal = face_normal(d, s, v.normal);
    }
    const Vec3 t = force / slot.area;
    v.t_n = t.dot(v.normal);
    v.t_s = (t - v.t_n * v.normal).norm();
    return v;
  }

  if (!tie && by_crack(d, s)) {    // along the crack and its plane
    const auto &law = laws.of(atom->type[i], atom->type[j]).cohesive;
    defe::CrackJoint crack = cracks->find(6 * d + s)->law;
    const auto r = cracks->look(6 * d + s, law, crack);
    const Vec3 m(crack.m), e(crack.e);
    const Eigen::Quaterniond turn(crack.turn[3], crack.turn[0], crack.turn[1], crack.turn[2]);
    v.normal = turn * m;
    v.point = xi + crack.f * y;
    const Vec3 t = r.force / slot.area;
    v.t_n = t.dot(v.normal);
    v.t_s = (t - v.t_n * v.normal).norm();
    v.damage = r.damage;
    v.opening = e.dot(m);
    v.slip = (e - v.opening * m).norm();
    return v;
  }

  const auto stiffness = laws.stiffness(jt.material[d], jt.len[d][s]);
  const auto &law = tie ? sys->model.adhesive_of(jt.material[d], slot.part)->law
                        : laws.of(atom->type[i], atom->type[j]).cohesive;
  auto state = defe::CohesiveState::unpack(slot.cohesive);
  const auto r = defe::cohesive_update(state, 0.0, Vec3::Zero(), stiffness, law);
  v.t_n = r.t_n;
  v.t_s = r.t_s.norm();
  v.damage = r.damage;
  v.opening = state.e_n;
  v.slip = state.e_s.norm();
  return v;
}
