#ifndef DEFE_COUPLING_JOINT_SOFTENING_H
#define DEFE_COUPLING_JOINT_SOFTENING_H

/// \file
/// A joint or a tie from the strength to its end, by the laws of opening_law.h and cohesive.h: when it starts, what it does in a step,
/// and which entries of the account of energies take what it loses.

#include "defe/coupling/opening_law.h"

namespace defe {

/// What is kept of a softening joint; a view of its record.
struct SofteningJoint {
  double *state;      ///< [CohesiveState::size]
  double &length0;    ///< length at which e_n vanishes
  double area;
  double &stored, &lost;    ///< energies (J): now, and dissipated so far
  signed char &pending;     ///< not 0: its energy is to be booked with its first force
};

/// A joint with this traction (on the end that `along` points away from) starts if the law of opening says so: then its
/// state is set, and true is returned.
/// \param normal  of the face that it crosses, by which strength is judged
/// \param along   direction in which the joint stretches from now on, and its length
bool start_softening(SofteningJoint &, const Vec3 &traction, const Vec3 &normal, const Vec3 &along,
                     double length, const JointStiffness &, const OpeningLaw &,
                     const CohesiveParameters &);

struct SofteningStep {
  CohesiveResult law;
  Vec3 force;    ///< on the end that `normal` points away from; not set if it breaks
  /// Of all that is lost until it breaks, G_f is the share of the fracture energy; the rest is released, as is what
  /// coarse steps lose beside it (`beside`), and at the first force, this much less of what the corners let go.
  double fracture = 0.0, released = 0.0, beside = 0.0;
};

/// One step. Its stretch along the unit vector `normal` is `length` less length0, its slip in the step is `slip`,
/// perpendicular to it.
/// \param moving  false: an evaluation before a run, which changes nothing that is kept, but for `lost`
SofteningStep soften(SofteningJoint &, const Vec3 &normal, double length, const Vec3 &slip,
                     bool moving, const JointStiffness &, const CohesiveParameters &);

}    // namespace defe

#endif
