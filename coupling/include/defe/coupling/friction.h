#ifndef DEFE_COUPLING_FRICTION_H
#define DEFE_COUPLING_FRICTION_H

/// \file
/// Coulomb friction of a point on a surface: a tangential spring that slips at the limit.

#include "defe/types.h"

namespace defe {

struct FrictionResult {
  Vec3 force;       ///< on the point; the surface takes the opposite
  double stored;    ///< energy of the spring
  double rubbed;    ///< energy lost in slipping during the increment
};

/// \param shear   tangential displacement of the point on the surface since it stuck, updated;
///                turned into the plane of n with its length kept
/// \param n       unit normal of the surface
/// \param slip    displacement of the point relative to the surface in this step; the part along n
///                is left out
/// \param kt      stiffness of the spring, > 0
/// \param limit   friction coefficient times normal force, >= 0
FrictionResult coulomb_friction(Vec3 &shear, const Vec3 &n, const Vec3 &slip, double kt,
                                double limit);

}    // namespace defe

#endif
