#ifndef DEFE_COUPLING_DE_ROTATION_H
#define DEFE_COUPLING_DE_ROTATION_H

/// \file
/// Rotation of a DE, by the joints around it: the polar factor of sum y dX^T, the rotation that brings the reference
/// vectors dX nearest to the present ones y. By the largest eigenvalue of Horn's matrix of quaternions (J. Opt. Soc. Am. A
/// 4 (1987) 629), which is a simple root of its characteristic polynomial unless the joints are on a line.

#include "defe/types.h"

namespace defe {

/// Rotation and what small motions make of it.
struct DERotation {
  bool defined = false;    ///< false: too few joints, or nearly on a line, then or now
  bool poor = true;        ///< by the reference: some axis is held by hardly more than one joint
  Mat3 R = Mat3::Identity();
  double quaternion[4] = {0.0, 0.0, 0.0, 1.0};    ///< x y z w
  Mat3 response = Mat3::Zero();    ///< d theta = response * sum (R dX) x dy, in space
};

/// A DE as the joints around it see it.
struct CrackEnd {
  const Vec3 *dX;      ///< [6] reference joint vectors
  const Vec3 *y;       ///< [6] current ones; also of joints that are no longer connective
  unsigned present;    ///< connective joints and ties
  // what the caller has already of de_rotation()
  const DERotation *turn = nullptr;    ///< of those present
  const DERotation *with[6] = {};      ///< of those present and this one
};

/// What the caller has of it, null: nothing.
const DERotation *known_rotation(const CrackEnd &end, unsigned use);

/// By the joints in `use`.
DERotation de_rotation(const CrackEnd &end, unsigned use);

/// Of n DEs, each by its joints that are present: several at a time, each as if it were alone.
void de_rotations(int n, const CrackEnd *end, DERotation *out);

/// Forces on the other ends of the joints in `use` that a moment on the DE's rotation stands for; the DE
/// itself takes the opposite of their sum.
void add_moment(const DERotation &, const CrackEnd &end, unsigned use, const Vec3 &moment,
                Vec3 force[6]);

}    // namespace defe

#endif
