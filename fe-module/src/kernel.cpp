#include "defe/fe/kernel.h"

#include "corotational.h"
#include "defe/fe/hex8.h"
#include "enhanced.h"

#include <algorithm>
#include <cmath>
#include <stdexcept>

namespace defe::fe {

HexKernel::~HexKernel() = default;

Mat3 polar_rotation(const Mat3 &F)
{
  // Newton's iteration for the orthogonal factor, scaled while far away (Higham 1986); it converges
  // for every F with det F > 0, at the end quadratically.
  Mat3 R = F;
  for (int i = 0; i < 40; ++i) {
    const Mat3 inverse_transpose = R.inverse().transpose();
    const double scale = std::sqrt(inverse_transpose.norm() / R.norm());
    const Mat3 next = 0.5 * (scale * R + inverse_transpose / scale);
    const double change = (next - R).norm();
    R = next;
    if (!(change > 1e-9)) break;    // the error left is its square; NaN ends here, too
  }
  return R;
}

CorotationalShape::CorotationalShape(const HexCoords &X, const Mat3 &Q)
{
  const Mat3 inverse = jacobian(Q.transpose() * (X.colwise() - X.col(0)), Vec3::Zero()).inverse();
  for (int k = 0; k < 3; ++k) G[k] = inverse(k, k) / 8.0;
}

CorotationalKernel::CorotationalKernel(const HexCoords &X, const IsotropicElastic &material,
                                       ElementType type) :
    type(type),
    elastic(material), shape0(X.colwise() - X.col(0))
{
  const std::string complaint = material.validate();
  if (!complaint.empty()) throw std::invalid_argument(complaint);
  const HexCheck check = check_hex(X);
  if (check.verdict == HexCheck::bad) throw std::invalid_argument(describe_bad_hex(0, X, check));
  K = type == ElementType::enhanced ? stiffness_enhanced(shape0, material)
                                    : stiffness(shape0, material);
}

namespace {

  // Rotation of the element and the displacements that are left, in reference axes.
  struct Corotated {
    Mat3 R;
    HexCoords u;
  };

  Corotated corotate(const HexCoords &x, const HexCoords &reference)
  {
    const HexCoords y = x.colwise() - x.col(0);
    const Mat3 F = jacobian(y, Vec3::Zero()) * jacobian(reference, Vec3::Zero()).inverse();
    const Mat3 R = F.determinant() > 0.0 ? polar_rotation(F) : Mat3::Constant(lanes::nan);
    return {R, R.transpose() * y - reference};
  }

}    // namespace

double CorotationalKernel::energy(const HexCoords &x, const HexCoords &, const double *) const
{
  const HexCoords u = corotate(x, shape0).u;
  const Eigen::Map<const Eigen::Matrix<double, 24, 1>> v(u.data());
  return 0.5 * v.dot(K * v);
}

Mat3 CorotationalKernel::stress(const HexCoords &x, const HexCoords &, const Vec3 &xi,
                                const double *) const
{
  const Corotated c = corotate(x, shape0);
  Mat3 s = linear_stress(shape0, c.u, elastic, xi);
  if (type == ElementType::enhanced && !xi.isZero(0.0)) {    // at the centre it vanishes
    EnhancedStrain enhanced(shape0, elastic);
    for (const Vec3 &point : gauss_points())
      enhanced.add(point, linear_stress(shape0, c.u, elastic, point));
    s += elastic_stress(enhanced.at(xi), elastic);
  }
  return c.R * s * c.R.transpose();
}

bool is_box(const HexCoords &X, double tol)
{
  const Vec3 edge[3] = {X.col(1) - X.col(0), X.col(3) - X.col(0), X.col(4) - X.col(0)};
  const double diagonal = max_diagonal(X);
  if (!(edge[0].cross(edge[1]).dot(edge[2]) > 0.0)) return false;

  for (int i = 0; i < 3; ++i) {
    const Vec3 &a = edge[i], &b = edge[(i + 1) % 3];
    // the shorter edge times the cosine is how far its end is out of place
    if (!(std::abs(a.dot(b)) <= tol * diagonal * std::max(a.norm(), b.norm()))) return false;
  }
  for (int a = 0; a < 8; ++a) {
    Vec3 corner = X.col(0);
    for (int k = 0; k < 3; ++k)
      if (hex_sign[a][k] > 0) corner += edge[k];
    if (!((X.col(a) - corner).norm() <= tol * diagonal)) return false;
  }
  return true;
}

bool congruent(const HexCoords &A, const HexCoords &B, double tol)
{
  const HexCoords difference = (A.colwise() - A.col(0)) - (B.colwise() - B.col(0));
  return difference.colwise().norm().maxCoeff() <= tol * max_diagonal(A);
}

HexCoords rounded_shape(const HexCoords &X)
{
  HexCoords shape = X.colwise() - X.col(0);
  // no powers of two of lengths or places that a mesh is likely to have
  const int by_size = std::ilogb(1.37 * shape.cwiseAbs().maxCoeff()) - 42;
  const int by_place = std::ilogb(1.37 * X.cwiseAbs().maxCoeff()) - 52 + 6;
  const double quantum = std::ldexp(1.0, std::max(by_size, by_place));
  for (int a = 0; a < 8; ++a)
    for (int k = 0; k < 3; ++k) shape(k, a) = quantum * std::nearbyint(shape(k, a) / quantum);
  return shape;
}

}    // namespace defe::fe
