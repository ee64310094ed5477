#ifndef DEFE_COUPLING_PENALTY_H
#define DEFE_COUPLING_PENALTY_H

/// \file
/// Penalty stiffness of surface contact.

namespace defe {

/// Stiffness per area, N/m3, of the LS-DYNA standard form k = f_s K A^2 / V for a segment of area
/// A of a solid element: k/A = f_s K A / V. K, A, V: bulk modulus, segment area and element volume
/// of the softer deformable side. A node or a DE takes this times the area it stands for, so that
/// the compliance of a contact does not change when elements become DEs.
double penalty_stiffness_per_area(double f_s, double K, double A, double V);

/// A ball of radius R that presses by `overlap` on the middle of a round patch of area A with the penalty
/// pressure k_A times the local depth (overlap - s^2/2R at the distance s from the middle):
/// E = pi k_A R/3 (o^3 - max(0, o - A/(2 pi R))^3). As the integral over a plane of facets while the disc of
/// contact is smaller than the patch, and linear with k_A A beyond.
struct BallOnPatch {
  double energy, force;
  double slope;    ///< of the force
  /// Factor of the damping ratio of a linear spring of stiffness force/overlap that gives about the same
  /// restitution with this spring: sqrt((1 + n)/2), n = overlap slope/force the local exponent (see NormalSpring).
  double damping_factor;
};
BallOnPatch ball_on_patch(double overlap, double R, double A, double k_A);

/// The overlap at which ball_on_patch() has this energy (>= 0).
double overlap_of_energy(double energy, double R, double A, double k_A);

}    // namespace defe

#endif
