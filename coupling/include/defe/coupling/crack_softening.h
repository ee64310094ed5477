#ifndef DEFE_COUPLING_CRACK_SOFTENING_H
#define DEFE_COUPLING_CRACK_SOFTENING_H

/// \file
/// Joint that a crack with a normal of its own cuts: softening along that normal, then a closed plane.
///
/// With a the area vector of the joint, d the vector between its two DEs and m the crack's normal (crack_growth.h)
/// the cut carries A_p = |a.m| over the length l_p = |d.m| (at least a tenth of |a|, |d|).
/// Since sum of a (x) d over the joints is V I on any mesh, the projected areas of a staircase add up to the
/// area of the crack, whatever its direction: pulled apart along m a joint takes G_f A_p after the switch.
///
/// Law of cohesive.h with normal m in the reference frame: stretch
///
///   e = e_0 + R^T y - (R^T y)_switch,   force on the near DE  F = R A_p t(e.m, e - (e.m) m)
///
/// with R the mean rotation of the two DEs, each by the joints and ties that it still has. k_m = (lambda + 2 mu)/l_p, k_c = E/l_p. At the switch
/// the force goes on unchanged, and k_p (along the plane) is such that the joint stores what the corners let go,
/// within mu/l_p to k_m. Where that would be more than they let go (several joints of a DE in one step) both are stiffened,
/// up to twice, and beyond that the force is reduced: energy is never made. m = N gives the joint of cohesive.h.
///
/// The weight of the shear is the user's where the crack crosses the joint squarely, and goes to 1 where the joint
/// lies in its plane. Steps of a staircase slide as the crack opens: with beta = 0.1 those beside a waiting
/// front would be sheared without softening (1.28 G_f in place of 1.01 at 45 degrees).
///
/// F is not along y, so the pair has a moment. The spins of DEs cannot take it (their inertia is so small that
/// they would roll away within the crack's opening): as R is a function of the neighbours' positions, its derivative
/// gives forces on them, exact but for the square of the two DEs' turn against each other, that
/// keep angular momentum and energy. About some axis a DE may be held by one joint alone (two joints, or three in a T). As the joint across
/// from a cut one it would be a lever: the cut one sheared by twice the DE's motion, with four times the stiffness, and the stable step
/// 0.7 of what it should be. There the cut joint itself is among those that say how the DE has turned, and shears by half. Not so where it
/// is the second one: R would follow the cut joint's own shear, and turn over where the two come to lie on a line. A DE on a single joint, or whose joints
/// are on a line, has no R: the other one's is taken; without either R turns with the spins, which take the moment.
/// When a DE loses or gains joints R jumps; e does not (the offset is set anew). Nor does it when a DE's joints have come to lie
/// on a line, where they say nothing about the rotation about it, and turn it over as they pass through.
///
/// Once broken, the plane presses where it is closed (k_c along m) and rubs (Coulomb, with a spring k_p = mu/l_p). When the
/// two DEs have moved by a fifth of |d| the pair is for the contact of spheres.
///
/// Units as in cohesive.h; forces in N, energies in J.

#include "defe/coupling/cohesive.h"
#include "defe/coupling/corner_strain.h"
#include "defe/coupling/de_rotation.h"

namespace defe {

/// Reference geometry of a joint, from its near to its far end. The near one is that of the lower ID.
struct CrackGeometry {
  Vec3 d;    ///< between the centres
  Vec3 a;    ///< area vector
  int slot[2] = {
      -1, -1};    ///< the joint, as seen from its near and from its far DE; -1: not among theirs
};

/// Everything that a cut joint remembers. Plain data, a fixed size: packed as bytes, kept over restarts.
struct CrackJoint {
  double m[3];         ///< crack normal, reference frame, towards the far end
  double f;            ///< where the crack passes: X + f d
  double offset[3];    ///< e = offset + R^T y
  double k_m, k_p;     ///< per area
  double s0, kappa;    ///< see CohesiveState
  double e[3];         ///< stretch at the last evaluation
  double turn[4];      ///< R at the last evaluation: quaternion x y z w
  double stored;       ///< J, at the last evaluation
  double taken;        ///< J, at the switch
  unsigned char
      used[2];    ///< joints that R is taken from, at either end; bit 6: they say how it has turned
  unsigned char broken;
  unsigned char pad[5];    ///< always 0
};

/// Whether the rotation of a DE beside a cut joint is taken from this joint, too. A DE that is poor in joints is held about some
/// axis by one joint alone; what this joint turns by would be the shear of the cut one, with more than its stiffness. Not
/// beside a single joint: about that one the cut one alone would say how the DE has turned, its frame would follow its own
/// shear, and turn over where the two come to lie on a line.
/// \param turn  by the joints that are present
bool crack_joint_has_a_say(const DERotation &turn, unsigned present);

/// Strain energy that a DE's corners let go when joints `leaving` leave them together, shared out
/// among these as each would let go alone.
/// \return the whole
double crack_release(const GeneralCell &cell, const Vec3 y[6], unsigned present, unsigned leaving,
                     const CornerModuli &moduli, double share[6]);

/// The joint at the switch, first half: normal, frame and traction of this moment.
/// \param m, f    decision of crack_growth.h
/// \param force   on the near end by the joint, current frame
/// \return false if the crack is not pulled open (force along m not positive): the joint stays as it is
bool crack_start(CrackJoint &joint, const Vec3 &m, double f, const CrackGeometry &geometry,
                 const Vec3 &force, const CrackEnd &near, const CrackEnd &far, const Vec3 &y);

/// Second half, once both ends have said what they let go: stiffness and stretch.
/// \param budget  sum of the shares of crack_release at both ends
void crack_take_over(CrackJoint &joint, const CrackGeometry &geometry, double budget,
                     const CornerModuli &moduli, const CohesiveParameters &parameters);

/// Whether the rotation of this end (0 near, 1 far) was known at the last evaluation, by joints.
bool crack_frame_from(const CrackJoint &joint, int end);

/// Turns a joint with the spins of its DEs, in a step in which crack_update() is not needed.
void crack_turn(CrackJoint &joint, const Vec3 &spin);

/// A joint that is broken from the start, such as a notch: y is its natural length.
CrackJoint crack_broken(const Vec3 &m, double f, const CrackGeometry &geometry,
                        const CornerModuli &moduli, const CohesiveParameters &parameters);

struct CrackForces {
  Vec3 force;        ///< on the near end; the far one takes the opposite
  Vec3 arm[2][6];    ///< on the other ends of the joints used[0], used[1] of either DE
  Vec3 at[2];        ///< on the near and the far DE, to balance these
  Vec3 torque;       ///< on either spin; 0 unless neither DE has a rotation
  double dissipated;
  /// Share of it that the surroundings have paid since the switch, at D = 1 the work done on the joint: G_f A_p if it is
  /// drawn apart along m. The rest, in all what was taken over at the switch, is elastic energy of the lattice.
  double fracture;
  double excess;      ///< as in CohesiveResult, times the area
  double work_new;    ///< same
  double rubbed;      ///< by the friction of a closed plane
  double damage;
  bool newly_broken;
  bool separated;    ///< broken and so far away that it is for the contact of spheres
};

/// Advance to the present positions. Calling it twice without motion changes nothing.
/// \param spin      mean increment of the spins' rotation; used where neither DE has a rotation
/// \param friction  coefficient, of the broken plane
CrackForces crack_update(CrackJoint &joint, const CrackGeometry &geometry, const CrackEnd &near,
                         const CrackEnd &far, const Vec3 &y, const Vec3 &spin,
                         const CornerModuli &moduli, const CohesiveParameters &parameters,
                         double friction = 0.0);

/// A broken joint between two DEs whose rotations are known: CrackEnd::turn, and CrackEnd::with of this joint where a DE is poor.
struct BrokenPlane {
  CrackJoint *joint;
  const CrackEnd *near, *far;
  int slot[2];    ///< as in CrackGeometry
  Vec3 spin;      ///< see crack_update()
};

/// Most planes of broken joints are open, and then there is no force. These are advanced as by crack_update(), several at a
/// time, each as if it were alone; all others stay as they are, for crack_update(): also where R has jumped or is not known, and where the two have moved
/// so far that they separate.
/// \param open  [n] true for those that were advanced
void crack_update_open(int n, const BrokenPlane *planes, bool *open);

}    // namespace defe

#endif
