#include "defe/coupling/joint_softening.h"

namespace defe {

bool start_softening(SofteningJoint &joint, const Vec3 &traction, const Vec3 &normal,
                     const Vec3 &along, double length, const JointStiffness &stiffness,
                     const OpeningLaw &opening, const CohesiveParameters &law)
{
  const double tn = traction.dot(normal);
  const double ts = (traction - tn * normal).norm();
  if (!opening.starts(tn, ts, law)) return false;
  const double an = traction.dot(along);
  const auto state = cohesive_start(an, traction - an * along, stiffness, law);
  state.pack(joint.state);
  joint.length0 = length - state.e_n;
  return true;
}

SofteningStep soften(SofteningJoint &joint, const Vec3 &normal, double length, const Vec3 &slip,
                     bool moving, const JointStiffness &stiffness, const CohesiveParameters &law)
{
  SofteningStep step;
  auto state = CohesiveState::unpack(joint.state);
  cohesive_rotate(state, normal);
  auto &r = step.law;
  r = cohesive_update(state, length - joint.length0 - state.e_n, slip, stiffness, law);
  if (moving) state.pack(joint.state);

  // G_f of the whole, G_f + s0^2/(2 k_n), both over s0/2
  const double of_crack = 2.0 * law.G_f / state.s0;
  const double share = of_crack / (of_crack + state.s0 / stiffness.k_n);
  const double lost = joint.area * r.dissipated;
  step.fracture = share * lost;
  step.released = (1.0 - share) * lost;
  joint.lost += lost;
  if (moving) joint.stored = joint.area * r.stored;
  if (r.broken) joint.stored = 0.0;
  if (joint.pending) {
    joint.pending = 0;
    step.beside = joint.area * (r.work_new - r.dissipated) - joint.stored;
  } else
    step.beside = joint.area * r.excess;
  if (!r.broken) step.force = joint.area * (r.t_n * normal + r.t_s);
  return step;
}

}    // namespace defe
