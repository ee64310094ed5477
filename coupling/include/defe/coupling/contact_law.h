#ifndef DEFE_COUPLING_CONTACT_LAW_H
#define DEFE_COUPLING_CONTACT_LAW_H

/// \file
/// Contact of two spheres: spring and dashpot along the normal, tangential spring with a
/// Coulomb limit. Used for broken joints and for loose DEs. Which spring: normal_law.h.
///
/// With n from j to i, r = |x_i - x_j|, overlap g = contact_distance - r:
///
///   F_n = max(0, kn g - c n.v_rel),  c = 2 zeta sqrt(kn m_eff)
///   F_t = -sqrt(kt) s,  |F_t| <= mu F_n,  ds = sqrt(kt) dxi   (xi: tangential displacement of the contact point)
///
/// kn and kt may depend on g. Then kn is the secant, and s keeps the energy of the tangential spring (friction.h).
///
/// The damping ratio zeta belongs to the restitution coefficient of exactly this law, with the
/// contact ending when the force would become attractive (Schwager and Poeschel, Granular Matter 9
/// (2007) 465): e = exp(-(b/w) phi), b = zeta w0, w = sqrt(w0^2 - b^2),
/// phi = atan2(2 b w, b^2 - w^2).
///
/// Lever arms share the actual distance r in the ratio of the radii, so that angular momentum is
/// conserved exactly and a pair that rotates as a rigid body does not slip.

#include "defe/coupling/friction.h"

namespace defe {

struct ContactParameters {
  double kn;             ///< normal stiffness, N/m: force over overlap
  double kt;             ///< tangential stiffness, N/m
  double restitution;    ///< 0 < e <= 1
  double friction;       ///< Coulomb coefficient, >= 0
  /// Of critical damping, damping_ratio(restitution). Negative: found anew at every call, slow.
  double damping_ratio = -1.0;
};

struct ContactResult {
  Vec3 force;        ///< on i; j takes the opposite
  Vec3 torque_i;     ///< on i, about its centre
  Vec3 torque_j;     ///< on j, about its centre
  double overlap;    ///< contact_distance - r; <= 0: no contact, all else is 0
  double stored;     ///< energy of both springs, that of the normal one with kn
  double damped;     ///< energy lost in the dashpot during dt
  double rubbed;     ///< energy lost in friction during dt
  bool slipping = false;
};

/// Damping ratio that gives this coefficient of restitution. 1 at e = exp(-2) = 0.135; as e goes
/// to 0 it grows as 1/(2 sqrt(e)). Values below e = 1e-4 are taken as 1e-4.
double damping_ratio(double restitution);

/// Parameters with the damping ratio filled in. Throws std::invalid_argument if out of range.
ContactParameters contact_parameters(double kn, double kt, double restitution, double friction);

/// \param xi_minus_xj       of the centres
/// \param v_rel             velocity of i less that of j, at the half step before as velocity Verlet
///                          has it when forces are computed
/// \param contact_distance  of the centres at which contact begins: r_i + r_j, or less for spheres
///                          that overlap in the reference state
/// \param reduced_mass      m_i m_j / (m_i + m_j)
/// \param tangential        spring of i against j, updated; start with zeros. Reset when they separate.
ContactResult sphere_contact(const Vec3 &xi_minus_xj, const Vec3 &v_rel, const Vec3 &omega_i,
                             const Vec3 &omega_j, double ri, double rj, double contact_distance,
                             double reduced_mass, double dt, TangentialSpring &tangential,
                             const ContactParameters &);

}    // namespace defe

#endif
