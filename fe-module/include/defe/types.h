#ifndef DEFE_TYPES_H
#define DEFE_TYPES_H

// Geometry and LU: without them cross(), inverse() and determinant() are declared, not defined.
#include <Eigen/Core>
#include <Eigen/Geometry>
#include <Eigen/LU>

namespace defe {

using Vec3 = Eigen::Vector3d;
using Mat3 = Eigen::Matrix3d;

}    // namespace defe

#endif
