// Stable step of a lattice of corner-strain joints.
//
// Infinite cubic lattice. For a wave u exp(i theta.n) the mean of the eight one-sided strain
// energies gives  rho d^2 omega^2 u = [(lambda + mu) Q + mu tr(Q) I] u  with
// Q_aa = 4 sin^2(theta_a/2), Q_ab = sin(theta_a) sin(theta_b). The largest value lies at theta_a
// all equal; with q = sin^2(theta_a/2) it is 4 q (3 - 2 q)(lambda + mu) + 12 q mu, largest at q = 1
// (neighbours in opposite phase, 4 (lambda + 4 mu)) as long as lambda <= 2 mu, else at
// q = 3 (lambda + 2 mu) / (4 (lambda + mu)).
//
// Any lattice. The strain energy is a sum over DEs, each term (the DE's own eight corners) a
// quadratic form K_i of the displacements of the DE and of its up to six joint ends. If the masses
// are split among the terms, M = sum M_i, then  u.K u = sum u.K_i u <= max_i lambda_max(K_i, M_i)
// u.M u: the largest local eigenvalue bounds omega_max^2 (the element eigenvalue theorem of
// finite elements). The pieces may be tensors, and everybody must follow one rule:
// - the term of the neighbour at the other end of a joint with unit vector n takes of a DE's mass
//     B(n) = [mu I + (lambda + mu) n n^T] / (4 (lambda + 4 mu)),
//   in proportion to the joint's stiffness along and across n; the rest is the DE's own. With six
//   perpendicular joints that is half. For the cubic lattice and nu <= 1/3 the bound is exact.
// - each of the three faces of a finite element at a node takes 3 B(n) of the node's m_e/8, so that
//   the element keeps a quarter (if the n are perpendicular), and the four ties of a face each
//   count that share in full: their weights are a contraction (a symmetric matrix with eigenvalues
//   1, 1/2, 1/2, 1/4), so sum |v_node|^2 >= sum |v_tie|^2.
// Where joints are missing the energy is minimised over them, so omega_max can only fall.

#include "defe/coupling/corner_strain.h"

#include "corner_metric.h"

#include <Eigen/Cholesky>
#include <cmath>
#include <limits>

namespace defe {

namespace {

  using Matrix21 = Eigen::Matrix<double, 21, 21>;

  /// Upper bound of the largest eigenvalue of a symmetric positive semidefinite matrix, within
  /// 0.3 %: the 1024th root of the norm of its 1024th power. (Unlike an iteration for the
  /// eigenvector it cannot end up below.)
  double largest_eigenvalue(Matrix21 A)
  {
    double log_bound = 0.0, weight = 1.0;
    for (int k = 0; k < 10; ++k, weight *= 0.5) {
      const double norm = A.norm();
      if (!(norm > 0.0)) return 0.0;
      log_bound += weight * std::log(norm);
      A /= norm;
      A = A.lazyProduct(A).eval();
    }
    return std::exp(log_bound + weight * std::log(A.norm()));
  }

  /// K_i in the displacements of the six joint ends (rows 3 s) and of the DE (rows 18..20).
  Matrix21 stiffness(const GeneralCell &cell, unsigned present, const CornerModuli &moduli)
  {
    Matrix21 K = Matrix21::Zero();
    for (int corner = 0; corner < 8; ++corner) {
      const CornerMetric m(cell, present, corner);
      const double w = corner_volume(cell, corner);
      const double lambda_e = reduced_lambda(moduli, m.joints);
      Vec3 g[3];    // dual to the joints, within their span
      Mat3 P = Mat3::Zero();
      for (int a = 0; a < m.joints; ++a) {
        g[a].setZero();
        for (int b = 0; b < m.joints; ++b) g[a] += m.inverse(a, b) * cell.dX[m.slot[b]];
        P += cell.dX[m.slot[a]] * g[a].transpose();
      }
      // second derivative of w (lambda_e/2 tr^2 + mu E:E), E = sym of P grad u P, P onto the span
      for (int a = 0; a < m.joints; ++a)
        for (int b = 0; b < m.joints; ++b) {
          const Mat3 k = w *
              (lambda_e * g[a] * g[b].transpose() +
               moduli.mu * (g[b] * g[a].transpose() + g[a].dot(g[b]) * P));
          const int r = 3 * m.slot[a], c = 3 * m.slot[b];
          K.block<3, 3>(r, c) += k;
          K.block<3, 3>(r, 18) -= k;
          K.block<3, 3>(18, c) -= k;
          K.block<3, 3>(18, 18) += k;
        }
    }
    return K;
  }

}    // namespace

double lattice_critical_step(double d, const CornerModuli &m, double rho)
{
  double q = 1.0;
  if (m.lambda > 2.0 * m.mu) q = 0.75 * (m.lambda + 2.0 * m.mu) / (m.lambda + m.mu);
  const double omega2 = (4.0 * q * (3.0 - 2.0 * q) * (m.lambda + m.mu) + 12.0 * q * m.mu) / rho;
  return 2.0 * d / std::sqrt(omega2);
}

double lattice_critical_step(const GeneralCell &cell, unsigned present, const CornerModuli &moduli,
                             double mass, const double *neighbor_mass)
{
  const double lambda = moduli.lambda, mu = moduli.mu;

  // inverse Cholesky factors of the mass tensors; rows of absent joints are zero in K anyway
  Mat3 factor[7], own = Mat3::Identity();
  for (int s = 0; s < 6; ++s) {
    factor[s].setZero();
    if (!(present >> s & 1u)) continue;
    const bool tie = cell.tie >> s & 1u;
    const Vec3 n = cell.dX[s].normalized();
    const Mat3 B =
        (mu * Mat3::Identity() + (lambda + mu) * n * n.transpose()) / (4.0 * (lambda + 4.0 * mu));
    if (!tie) own -= B;
    const Mat3 share = (tie ? 3.0 : 1.0) * (neighbor_mass ? neighbor_mass[s] : mass) * B;
    factor[s] = Mat3(share.llt().matrixL()).inverse();
  }
  const Eigen::LLT<Mat3> cholesky(mass * own);
  if (cholesky.info() != Eigen::Success) return 0.0;
  factor[6] = Mat3(cholesky.matrixL()).inverse();

  Matrix21 K = stiffness(cell, present, moduli);
  for (int r = 0; r < 7; ++r)
    for (int c = 0; c < 7; ++c) {
      const Mat3 k = K.block<3, 3>(3 * r, 3 * c);
      K.block<3, 3>(3 * r, 3 * c) = factor[r] * k * factor[c].transpose();
    }
  const double omega2 = largest_eigenvalue(K);
  return omega2 > 0.0 ? 2.0 / std::sqrt(omega2) : std::numeric_limits<double>::infinity();
}

double softening_critical_step(const GeneralCell &cell, unsigned present,
                               const CornerModuli &moduli, double mass)
{
  Vec3 half_area[6];
  corner_areas(cell, present, half_area);
  double stiffness = 0.0;
  for (int s = 0; s < 6; ++s)
    if (present >> s & 1u) stiffness += 2.0 * half_area[s].norm() / cell.dX[s].norm();
  stiffness *= moduli.lambda + 2.0 * moduli.mu;
  return stiffness > 0.0 ? std::sqrt(2.0 * mass / stiffness)
                         : std::numeric_limits<double>::infinity();
}

}    // namespace defe
