#ifndef DEFE_COUPLING_FRICTION_H
#define DEFE_COUPLING_FRICTION_H

/// \file
/// Coulomb friction at a point of contact: a tangential spring that slips at the limit.
///
/// The stiffness k_t may change with the contact: with its overlap (normal_law.h) or with the area that presses. Then
/// a spring that is known by its elongation xi, F = -k_t xi, has its energy k_t xi^2/2 changed without work. To take that from the
/// motion along the normal, by a force k_t' xi^2/2 there, balances the account; but with a dashpot beside it the
/// limit of slip is higher on the way in than on the way out, so is that force, and the restitution along the normal is not
/// the given one (0.46 for 0.50). Here the state is s, the elongation weighted by the root of the stiffness at which it came about,
///
///   ds = sqrt(k_t) dxi,   F = -sqrt(k_t) s,   energy s^2/2,
///
/// so that the energy changes by the work F dxi alone, whatever k_t does meanwhile, and nothing acts along the normal.
/// At constant k_t it is the linear spring.

#include "defe/types.h"

namespace defe {

/// Tangential spring of a contact; zeros: a new one. Plain data.
struct TangentialSpring {
  double s[3];    ///< of the point against the surface, sqrt(N m)
  double root;    ///< sqrt(k_t) of the last step, sqrt(N/m); 0: there was none

  double stored() const { return 0.5 * (s[0] * s[0] + s[1] * s[1] + s[2] * s[2]); }
};

struct FrictionResult {
  Vec3 force;       ///< on the point; the surface takes the opposite
  double stored;    ///< energy of the spring
  double rubbed;    ///< energy lost in slipping during the increment, >= 0
  bool slipping;
};

/// \param spring  updated; turned into the plane of n with its energy kept
/// \param n       unit normal of the surface
/// \param slip    displacement of the point relative to the surface in this step; the part along n
///                is left out
/// \param kt      stiffness of the spring now, >= 0
/// \param limit   friction coefficient times normal force, >= 0
FrictionResult coulomb_friction(TangentialSpring &spring, const Vec3 &n, const Vec3 &slip,
                                double kt, double limit);

}    // namespace defe

#endif
