#ifndef DEFE_COUPLING_COHESIVE_H
#define DEFE_COUPLING_COHESIVE_H

/// \file
/// Cohesive joint: what a joint between two DEs does after it has reached the tensile strength.
///
/// At the switch the joint leaves the corner strains with the traction it carries there. From then
/// on it is a damaging elastic layer, per unit area, with the elastic stretch (e_n, e_s):
///
///   t_n = (1 - w) k_n e_n  (e_n > 0),   k_c e_n  (e_n < 0, not damaged),   t_s = (1 - w) k_s e_s
///   s     = sqrt((k_n <e_n>)^2 + (beta k_s |e_s|)^2)        undamaged equivalent traction
///   kappa = max over time of s / k_n,  kappa_0 = s_0 / k_n
///   D(kappa) in [0, 1],   1 - w = (kappa_0 / kappa) (1 - D)
///
/// so that the equivalent traction falls from s_0 to 0 as s_0 (1 - D), by a curve of softening_curve.h: linearly unless
/// another is given, D = (kappa - kappa_0) / delta_c, delta_c = 2 G_f / s_0. D = 1 is broken, for good.
/// Unloading goes to e = 0, the joint's natural length. Stored energy
///   psi = (1 - w) (k_n <e_n>^2 + k_s |e_s|^2) / 2 + k_c <-e_n>^2 / 2,
/// dissipation (k_n <e_n>^2 + k_s |e_s|^2) / 2 dw >= 0 on every path.
///
/// Pulled apart in tension, the joint takes the work G_f per area after the switch, exactly, and
/// releases s_0 kappa_0 / 2 + G_f in all: G_f plus the elastic energy that a lattice of this
/// spacing cannot resolve (strength-controlled, see toughness_limit()). In pure shear
/// the work is G_f k_n / (beta^2 k_s).
///
/// Units: tractions N/m2, displacements m, stiffness N/m3, energies J/m2, or any consistent ones.
/// After Gao and Zang, Eng. Anal. Bound. Elem. 42 (2014) 27, made thermodynamically consistent; linear softening
/// with G_f as its area is that of Hillerborg, Modeer and Petersson, Cem. Concr. Res. 6 (1976) 773.

#include "defe/coupling/softening_curve.h"
#include "defe/types.h"

namespace defe {

struct CohesiveParameters {
  double sigma_t;                 ///< tensile strength, > 0
  double G_f;                     ///< fracture energy per area, > 0
  double beta;                    ///< weight of the shear traction, >= 0 (> 0 if reciprocal)
  bool reciprocal;                ///< shear enters as |t_s| / beta instead of beta |t_s|
  unsigned char softening = 0;    ///< number of the curve, see softening_curve.h
};

/// Stiffness per area of a joint of length l: k_n = (lambda + 2 mu)/l in tension, k_c = E/l in
/// compression, k_s = mu/l in shear.
struct JointStiffness {
  double k_n, k_c, k_s;
};

JointStiffness joint_stiffness(double lambda, double mu, double length);

/// Everything a softening joint remembers. e_s is kept perpendicular to the joint's normal.
struct CohesiveState {
  static constexpr int size = 6;    ///< doubles in a buffer

  double e_n;      ///< elastic stretch along the normal
  Vec3 e_s;        ///< tangential
  double s0;       ///< equivalent traction at the switch
  double kappa;    ///< largest s/k_n so far

  void pack(double *buffer) const;
  static CohesiveState unpack(const double *buffer);
};

struct CohesiveResult {
  double t_n;       ///< normal traction, tension positive
  Vec3 t_s;         ///< tangential traction: on the end that e_s is measured from, pulls along e_s
  double stored;    ///< per area
  double dissipated;    ///< per area, of this increment
  /// Work of the tractions at both ends of the increment, (t_old + t_new)/2 times the increment, which is
  /// what the kicks of velocity Verlet take; a joint that breaks pulls no more at the new end.
  double work;
  double work_new;    ///< the half of it that belongs to the new end
  /// work - (stored - stored before) - dissipated: what a coarse increment loses beyond the law.
  double excess;
  double damage;    ///< D
  bool broken;      ///< D = 1: drop the state, the pair is a contact from now on
};

/// sqrt(<t_n>^2 + (beta |t_s|)^2), or with |t_s| / beta. A joint switches when this reaches sigma_t
/// and t_n > 0.
double equivalent_traction(double t_n, double t_s, const CohesiveParameters &);

/// State at the switch. t_s is perpendicular to the normal; the equivalent traction must be > 0.
/// The curve is taken with the traction at the switch, which a time step may have carried above
/// sigma_t, so that the fracture energy is G_f all the same.
CohesiveState cohesive_start(double t_n, const Vec3 &t_s, const JointStiffness &,
                             const CohesiveParameters &);

/// Advance by an increment of the separation. The dissipation is integrated along the straight
/// increment: exact when the direction of the stretch does not change, second order otherwise.
CohesiveResult cohesive_update(CohesiveState &, double de_n, const Vec3 &de_s,
                               const JointStiffness &, const CohesiveParameters &);

/// Turn e_s with the joint: perpendicular to the unit vector n_new, length kept.
void cohesive_rotate(CohesiveState &, const Vec3 &n_new);

/// Work per area that a joint takes from the switch to the end, in tension, plus what it stores
/// at the switch: s0^2/(2 k_n) + G_f.
double cohesive_total_release(double s0, const JointStiffness &, const CohesiveParameters &);

/// Joint length above which the elastic energy of a joint at sigma_t exceeds G_f, so that the
/// lattice is strength-controlled: 2 E G_f / sigma_t^2.
double toughness_limit(double E, double G_f, double sigma_t);

}    // namespace defe

#endif
