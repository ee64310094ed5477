#ifndef DEFE_FE_PRINCIPAL_H
#define DEFE_FE_PRINCIPAL_H

#include "defe/types.h"

namespace defe::fe {

/// Largest eigenvalue of a symmetric tensor (only its lower triangle is read).
double max_principal(const Mat3 &s);

/// The same with its unit eigenvector; the sign of the vector is arbitrary.
double max_principal(const Mat3 &s, Vec3 &direction);

/// Upper bound of the largest eigenvalue in a few flops: p + 2 sqrt(J2/3), p = tr(s)/3, where the
/// exact value is p + 2 sqrt(J2/3) cos(theta), 0 <= theta <= pi/3 (theta: Lode angle). So it is
/// exact in uniaxial tension and at most sqrt(J2/3) too high.
double max_principal_bound(const Mat3 &s);

}    // namespace defe::fe

#endif
