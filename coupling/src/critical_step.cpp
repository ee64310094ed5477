// Stable step of a lattice of corner-strain joints.
//
// Infinite cubic lattice. For a wave u exp(i theta.n) the mean of the eight one-sided strain
// energies gives  rho d^2 omega^2 u = [(lambda + mu) Q + mu tr(Q) I] u  with Q_aa = 4 sin^2(theta_a/2),
// Q_ab = sin(theta_a) sin(theta_b). The largest value lies at theta_a all equal; with
// q = sin^2(theta_a/2) it is 4 q (3 - 2 q)(lambda + mu) + 12 q mu, largest at q = 1 (neighbours in
// opposite phase, 4 (lambda + 4 mu)) as long as lambda <= 2 mu, else at
// q = 3 (lambda + 2 mu) / (4 (lambda + mu)).
//
// Any lattice. The strain energy is a sum over DEs, each term (the DE's own eight corners) a
// quadratic form K_i of the displacements of the DE and of its up to six joint ends. If the masses
// are split among the terms, M = sum M_i, then  u.K u = sum u.K_i u <= max_i lambda_max(K_i, M_i)
// u.M u: the largest local eigenvalue bounds omega_max^2 (the element eigenvalue theorem of
// finite elements). The split must be the same rule for everybody: of a DE's mass, `own` goes to
// its own term and a sixth of the rest to each of its six neighbours' terms. For the cubic lattice
// the breathing mode of the neighbours and the mode of opposite phase then have
// (9 lambda + 6 mu)/(1 - own) and (lambda + 4 mu)(1/own + 1/(1 - own)); equal for the choice below.
// Of each face node's m_e/8, a finite element keeps a quarter; three faces may share the rest, and
// among the four ties of a face it counts in full for each, because the weights' matrix is a
// contraction (eigenvalues 1, 1/2, 1/2, 1/4): sum |v_I|^2 >= sum |v_tie|^2.

#include "defe/coupling/corner_strain.h"

#include "corner_metric.h"

#include <algorithm>
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
  const double own = std::min(0.5, (lambda + 4.0 * mu) / (9.0 * lambda + 6.0 * mu));

  // K from the gradient of the half forces would do; the quadratic form is as short. Row of the
  // displacement of the DE: 18..20, of joint end s: 3 s..3 s + 2.
  Matrix21 K = Matrix21::Zero();
  for (int corner = 0; corner < 8; ++corner) {
    const CornerMetric m(cell, present, corner);
    const double w = corner_volume(cell, corner), lambda_e = reduced_lambda(moduli, m.joints);
    Vec3 g[3];    // dual to the joints within their span
    Mat3 P = Mat3::Zero();
    for (int a = 0; a < m.joints; ++a) {
      g[a].setZero();
      for (int b = 0; b < m.joints; ++b) g[a] += m.inverse(a, b) * cell.dX[m.slot[b]];
      P += cell.dX[m.slot[a]] * g[a].transpose();
    }
    // second derivative of w (lambda_e/2 tr^2 + mu E:E), E = sym of P grad u P, P onto the span
    for (int a = 0; a < m.joints; ++a)
      for (int b = 0; b < m.joints; ++b) {
        const Mat3 k = w * (lambda_e * g[a] * g[b].transpose() +
                            mu * (g[b] * g[a].transpose() + g[a].dot(g[b]) * P));
        const int r = 3 * m.slot[a], c = 3 * m.slot[b];
        K.block<3, 3>(r, c) += k;
        K.block<3, 3>(r, 18) -= k;
        K.block<3, 3>(18, c) -= k;
        K.block<3, 3>(18, 18) += k;
      }
  }

  // Only joints that are there have rows; the others' stay zero and do no harm.
  Eigen::Matrix<double, 21, 1> scale;
  for (int s = 0; s < 6; ++s) {
    const double other = neighbor_mass ? neighbor_mass[s] : mass;
    const double share = cell.tie >> s & 1 ? 0.25 : (1.0 - own) / 6.0;
    const bool there = present >> s & 1u;
    scale.segment<3>(3 * s).setConstant(there ? 1.0 / std::sqrt(share * other) : 0.0);
  }
  scale.tail<3>().setConstant(1.0 / std::sqrt(own * mass));
  K = scale.asDiagonal() * K * scale.asDiagonal();
  const double omega2 = largest_eigenvalue(K);
  return omega2 > 0.0 ? 2.0 / std::sqrt(omega2) : std::numeric_limits<double>::infinity();
}

}    // namespace defe
