#include "defe/fe/hex8.h"

#include <algorithm>
#include <cmath>
#include <sstream>

namespace defe::fe {

Eigen::Matrix<double, 8, 1> shape(const Vec3 &xi)
{
  Eigen::Matrix<double, 8, 1> N;
  for (int a = 0; a < 8; ++a)
    N[a] = 0.125 * (1.0 + hex_sign[a][0] * xi[0]) * (1.0 + hex_sign[a][1] * xi[1]) *
        (1.0 + hex_sign[a][2] * xi[2]);
  return N;
}

Eigen::Matrix<double, 8, 3> shape_gradient(const Vec3 &xi)
{
  Eigen::Matrix<double, 8, 3> dN;
  for (int a = 0; a < 8; ++a) {
    const double sx = hex_sign[a][0], sy = hex_sign[a][1], sz = hex_sign[a][2];
    const double nx = 1.0 + sx * xi[0], ny = 1.0 + sy * xi[1], nz = 1.0 + sz * xi[2];
    dN(a, 0) = 0.125 * sx * ny * nz;
    dN(a, 1) = 0.125 * sy * nx * nz;
    dN(a, 2) = 0.125 * sz * nx * ny;
  }
  return dN;
}

const std::array<Vec3, 8> &gauss_points()
{
  static const std::array<Vec3, 8> points = [] {
    std::array<Vec3, 8> p;
    for (int a = 0; a < 8; ++a)
      p[a] = Vec3(hex_sign[a][0], hex_sign[a][1], hex_sign[a][2]) / std::sqrt(3.0);
    return p;
  }();
  return points;
}

Vec3 interpolate(const HexCoords &X, const Vec3 &xi)
{
  return X * shape(xi);
}

Mat3 jacobian(const HexCoords &X, const Vec3 &xi)
{
  return X * shape_gradient(xi);
}

Mat3 deformation_gradient(const HexCoords &x, const HexCoords &X, const Vec3 &xi)
{
  return jacobian(x.colwise() - x.col(0), xi) * jacobian(X.colwise() - X.col(0), xi).inverse();
}

namespace {

  // node 0 as origin: far from the origin the products below would lose digits
  HexCoords relative_to_first(const HexCoords &X)
  {
    return X.colwise() - X.col(0);
  }

  double mean_edge(const HexCoords &X)
  {
    double sum = 0.0;
    for (int a = 0; a < 8; ++a)
      for (int axis = 0; axis < 3; ++axis)
        sum += (X.col(hex_edge_neighbor(a, axis)) - X.col(a)).norm();
    return sum / 24.0;    // each of the 12 edges was met twice
  }

}    // namespace

double volume(const HexCoords &X)
{
  const HexCoords Y = relative_to_first(X);
  double sum = 0.0;
  for (const Vec3 &xi : gauss_points()) sum += jacobian(Y, xi).determinant();
  return sum;
}

double nodal_mass(const HexCoords &X, double rho)
{
  return 0.125 * rho * volume(X);
}

double face_area(const Vec3 p[4])
{
  // r(s, t) = [p0 (1-s)(1-t) + p1 (1+s)(1-t) + p2 (1+s)(1+t) + p3 (1-s)(1+t)] / 4
  const double g = 1.0 / std::sqrt(3.0);
  double sum = 0.0;
  for (double s : {-g, g})
    for (double t : {-g, g}) {
      const Vec3 rs = 0.25 * ((1.0 - t) * (p[1] - p[0]) + (1.0 + t) * (p[2] - p[3]));
      const Vec3 rt = 0.25 * ((1.0 - s) * (p[3] - p[0]) + (1.0 + s) * (p[2] - p[1]));
      sum += rs.cross(rt).norm();
    }
  return sum;
}

double characteristic_length(const HexCoords &X)
{
  double largest = 0.0;
  for (const auto &face : hex_face) {
    const Vec3 p[4] = {X.col(face[0]), X.col(face[1]), X.col(face[2]), X.col(face[3])};
    largest = std::max(largest, face_area(p));
  }
  return volume(X) / largest;
}

double max_diagonal(const HexCoords &X)
{
  double longest = 0.0;
  for (int a = 0; a < 8; ++a)
    for (int b = 0; b < a; ++b) longest = std::max(longest, (X.col(a) - X.col(b)).norm());
  return longest;
}

double max_face_diagonal(const HexCoords &X)
{
  double longest = 0.0;
  for (const auto &n : hex_face)
    for (int a = 0; a < 2; ++a) longest = std::max(longest, (X.col(n[a + 2]) - X.col(n[a])).norm());
  return longest;
}

HexCheck check_hex(const HexCoords &X)
{
  HexCheck check;
  const HexCoords Y = relative_to_first(X);
  if (!Y.allFinite()) {
    check.verdict = HexCheck::bad;
    check.min_gauss_jacobian = check.min_corner_jacobian = std::nan("");
    return check;
  }

  check.min_gauss_jacobian = check.min_corner_jacobian = HUGE_VAL;
  for (int a = 0; a < 8; ++a) {
    const Vec3 corner(hex_sign[a][0], hex_sign[a][1], hex_sign[a][2]);
    check.min_gauss_jacobian =
        std::min(check.min_gauss_jacobian, jacobian(Y, gauss_points()[a]).determinant());
    check.min_corner_jacobian =
        std::min(check.min_corner_jacobian, jacobian(Y, corner).determinant());
  }

  const double flat = 1e-6 * std::pow(0.5 * mean_edge(Y), 3);
  if (!(check.min_gauss_jacobian > flat))
    check.verdict = HexCheck::bad;
  else if (!(check.min_corner_jacobian > 0.0))
    check.verdict = HexCheck::suspicious;
  else
    check.verdict = HexCheck::good;
  return check;
}

std::string describe_bad_hex(long long id, const HexCoords &X, const HexCheck &check)
{
  std::ostringstream text;
  text.precision(8);
  text << "hexahedron " << id;
  if (check.verdict == HexCheck::good)
    text << " is good";
  else if (check.verdict == HexCheck::suspicious)
    text << " has a corner with Jacobian " << check.min_corner_jacobian
         << " (positive at all Gauss points, at least " << check.min_gauss_jacobian << ")";
  else if (std::isnan(check.min_gauss_jacobian))
    text << " has a coordinate that is not a finite number";
  else if (check.min_gauss_jacobian <= 0.0)
    text << " is inverted: Jacobian " << check.min_gauss_jacobian << " at a Gauss point";
  else
    text << " is flat: Jacobian " << check.min_gauss_jacobian << " at a Gauss point";
  text << "; nodes";
  for (int a = 0; a < 8; ++a) text << " (" << X(0, a) << " " << X(1, a) << " " << X(2, a) << ")";
  return text.str();
}

namespace {

  Eigen::Matrix<double, 24, 24> stiffness(const HexCoords &Y, double lambda, double mu)
  {
    Eigen::Matrix<double, 24, 24> K = Eigen::Matrix<double, 24, 24>::Zero();
    for (const Vec3 &xi : gauss_points()) {
      const Mat3 J = jacobian(Y, xi);
      const double w = J.determinant();
      const Eigen::Matrix<double, 8, 3> g = shape_gradient(xi) * J.inverse();
      for (int a = 0; a < 8; ++a)
        for (int b = 0; b <= a; ++b) {
          Mat3 block = lambda * g.row(a).transpose() * g.row(b);
          block += mu * g.row(b).transpose() * g.row(a);
          block.diagonal().array() += mu * g.row(a).dot(g.row(b));
          K.block<3, 3>(3 * a, 3 * b) += w * block;
        }
    }
    for (int a = 0; a < 8; ++a)
      for (int b = a + 1; b < 8; ++b)
        K.block<3, 3>(3 * a, 3 * b) = K.block<3, 3>(3 * b, 3 * a).transpose();
    return K;
  }

}    // namespace

Eigen::Matrix<double, 24, 24> stiffness(const HexCoords &X, const IsotropicElastic &material)
{
  return stiffness(relative_to_first(X), material.lambda(), material.mu());
}

Eigen::Matrix<double, 24, 24> stiffness_fbar(const HexCoords &X, const IsotropicElastic &material)
{
  const HexCoords Y = relative_to_first(X);
  Eigen::Matrix<double, 24, 1> dv = Eigen::Matrix<double, 24, 1>::Zero();    // dv/du
  for (const Vec3 &xi : gauss_points()) {
    const Mat3 J = jacobian(Y, xi);
    const Eigen::Matrix<double, 8, 3> g = shape_gradient(xi) * J.inverse();
    for (int a = 0; a < 8; ++a) dv.segment<3>(3 * a) += J.determinant() * g.row(a).transpose();
  }
  return stiffness(Y, -2.0 / 3.0 * material.mu(), material.mu()) +
      material.bulk() / volume(X) * dv * dv.transpose();
}

Mat3 elastic_stress(const Mat3 &strain, const IsotropicElastic &material)
{
  Mat3 s = 2.0 * material.mu() * strain;
  s.diagonal().array() += material.lambda() * strain.trace();
  return s;
}

Mat3 linear_stress(const HexCoords &X, const HexCoords &u, const IsotropicElastic &material,
                   const Vec3 &xi)
{
  const Mat3 J = jacobian(relative_to_first(X), xi);
  const Mat3 H = jacobian(relative_to_first(u), xi) * J.inverse();
  return elastic_stress(0.5 * (H + H.transpose()), material);
}

}    // namespace defe::fe
