#include "enhanced.h"

#include "defe/fe/hex8.h"

#include <Eigen/Geometry>
#include <Eigen/LU>

namespace defe::fe {

EnhancedStrain::EnhancedStrain(const HexCoords &reference, const IsotropicElastic &material) :
    X(reference.colwise() - reference.col(0)), lambda(material.lambda()), mu(material.mu())
{
  const Mat3 J0 = jacobian(X, Vec3::Zero());
  for (int k = 0; k < 3; ++k) {
    g[k] = J0.col((k + 1) % 3).cross(J0.col((k + 2) % 3));
    sum[k].setZero();
  }
  Mat3 products = Mat3::Zero();
  for (const Vec3 &xi : gauss_points())
    products += xi * xi.transpose() / jacobian(X, xi).determinant();
  w = products.cwiseAbs().rowwise().sum();
}

void EnhancedStrain::add(const Vec3 &gauss_point, const Mat3 &stress)
{
  for (int k = 0; k < 3; ++k) sum[k] += gauss_point[k] * stress;
}

Vec3 EnhancedStrain::solve(int k, const Vec3 &h) const
{
  const double g2 = g[k].squaredNorm();
  const double along = (lambda + mu) / (lambda + 2.0 * mu) * g[k].dot(h) / g2;
  return (h - along * g[k]) / (w[k] * mu * g2);
}

Mat3 EnhancedStrain::at(const Vec3 &xi) const
{
  Mat3 H = Mat3::Zero();
  for (int k = 0; k < 3; ++k) H += xi[k] * amplitude(k) * g[k].transpose();
  return 0.5 * (H + H.transpose()) / jacobian(X, xi).determinant();
}

double EnhancedStrain::energy() const
{
  double twice = 0.0;
  for (int k = 0; k < 3; ++k) twice += amplitude(k).dot(sum[k] * g[k]);
  return 0.5 * twice;
}

Eigen::Matrix<double, 24, 24> stiffness_enhanced(const HexCoords &X,
                                                 const IsotropicElastic &material)
{
  const HexCoords Y = X.colwise() - X.col(0);
  const EnhancedStrain enhanced(Y, material);
  Eigen::Matrix<double, 24, 24> K = stiffness(Y, material);
  for (int k = 0; k < 3; ++k) {
    const Vec3 &g = enhanced.direction(k);
    Eigen::Matrix<double, 3, 24> h = Eigen::Matrix<double, 3, 24>::Zero(),
                                 solved;    // of unit displacements
    for (const Vec3 &xi : gauss_points()) {
      const Eigen::Matrix<double, 8, 3> gradient = shape_gradient(xi) * jacobian(Y, xi).inverse();
      for (int a = 0; a < 8; ++a) {
        const Vec3 n = gradient.row(a);
        Mat3 block = material.lambda() * g * n.transpose() + material.mu() * n * g.transpose();
        block.diagonal().array() += material.mu() * n.dot(g);
        h.block<3, 3>(0, 3 * a) += xi[k] * block;
      }
    }
    for (int i = 0; i < 24; ++i) solved.col(i) = enhanced.solve(k, h.col(i));
    K -= h.transpose() * solved;
  }
  return 0.5 * (K + K.transpose());
}

}    // namespace defe::fe
