#ifndef DEFE_FE_PRINCIPAL_H
#define DEFE_FE_PRINCIPAL_H

#include "defe/types.h"

namespace defe::fe {

/// Largest eigenvalue of a symmetric tensor (only its lower triangle is read).
double max_principal(const Mat3 &s);

/// The same with its unit eigenvector; the sign of the vector is arbitrary.
double max_principal(const Mat3 &s, Vec3 &direction);

/// Equivalent stress of von Mises, of xx yy zz xy xz yz.
double von_mises(const double *stress6);

/// Weights of mean p + shear sqrt(J2/3), p = tr(s)/3: with the right ones an upper bound of any isotropic measure
/// of a stress that is piecewise linear in its principal values (see coupling/criterion.h).
struct StressBound {
  double mean = 1.0, shear = 2.0;    ///< the largest principal value
  bool operator==(const StressBound &b) const { return mean == b.mean && shear == b.shear; }
};

double stress_bound(const Mat3 &s, const StressBound &weights);

/// Upper bound of the largest eigenvalue in a few flops: p + 2 sqrt(J2/3), p = tr(s)/3, where the
/// exact value is p + 2 sqrt(J2/3) cos(theta), 0 <= theta <= pi/3 (theta: Lode angle). So it is
/// exact in uniaxial tension and at most sqrt(J2/3) too high.
double max_principal_bound(const Mat3 &s);

}    // namespace defe::fe

#endif
