#include "defe/coupling/crack_stress.h"

#include "corner_metric.h"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>

namespace defe {

namespace {

  void add(double sum[6], const Mat3 &S)
  {
    constexpr int row[6] = {0, 1, 2, 1, 0, 0}, column[6] = {0, 1, 2, 2, 2, 1};
    for (int k = 0; k < 6; ++k) sum[k] += S(row[k], column[k]);
  }

  /// Volume times stress of a corner with all its joints, by the gradient of displacement.
  Mat3 full_stress(const GeneralCell &cell, const Vec3 y[6], int corner, double w,
                   const CornerModuli &moduli)
  {
    Mat3 M, u;
    for (int a = 0; a < 3; ++a) {
      const int s = corner_slot(corner, a);
      M.col(a) = cell.dX[s];
      u.col(a) = y[s] - cell.dX[s];
    }
    const Mat3 G = u * M.inverse();
    const Mat3 E = 0.5 * (G + G.transpose() + G.transpose() * G);
    return w * (moduli.lambda * E.trace() * Mat3::Identity() + 2.0 * moduli.mu * E);
  }

  /// The same of one that lacks some, with the reduced law in the plane or line of those that are left.
  Mat3 reduced_stress(const GeneralCell &cell, const Vec3 y[6], unsigned present, int corner,
                      double w, const CornerModuli &moduli)
  {
    const CornerMetric m(cell, present, corner);
    double E[3][3], trace = 0.0;
    for (int a = 0; a < m.joints; ++a)
      for (int b = 0; b < m.joints; ++b) {
        // by displacements, so that nothing cancels when the strain is small
        const int s = m.slot[a], t = m.slot[b];
        const Vec3 us = y[s] - cell.dX[s], ut = y[t] - cell.dX[t];
        E[a][b] = 0.25 * (us.dot(y[t] + cell.dX[t]) + ut.dot(y[s] + cell.dX[s]));
        trace += m.inverse(a, b) * E[a][b];
      }
    // contravariant S^ab = lambda_e G^ab tr(E) + 2 mu G^ac E_cd G^db
    const double p = reduced_lambda(moduli, m.joints) * trace;
    Mat3 S = Mat3::Zero();
    for (int a = 0; a < m.joints; ++a)
      for (int b = 0; b < m.joints; ++b) {
        double s = p * m.inverse(a, b);
        for (int c = 0; c < m.joints; ++c)
          for (int d = 0; d < m.joints; ++d)
            s += 2.0 * moduli.mu * m.inverse(a, c) * E[c][d] * m.inverse(d, b);
        S += w * s * cell.dX[m.slot[a]] * cell.dX[m.slot[b]].transpose();
      }
    return S;
  }

}    // namespace

CrackStress crack_stress(const GeneralCell &cell, const Vec3 y[6], unsigned present,
                         const CornerModuli &moduli)
{
  CrackStress sum{};
  for (int corner = 0; corner < 8; ++corner) {
    const unsigned all =
        1u << corner_slot(corner, 0) | 1u << corner_slot(corner, 1) | 1u << corner_slot(corner, 2);
    if (!(present & all)) continue;
    const bool full = (present & all) == all;
    const double w = corner_volume(cell, corner);
    const Mat3 S = full ? full_stress(cell, y, corner, w, moduli)
                        : reduced_stress(cell, y, present, corner, w, moduli);
    for (int a = 0; a < 3; ++a) {
      const int s = corner_slot(corner, a);
      if (!(present >> s & 1u)) continue;
      add(sum.slot[s], S);
      sum.slot_volume[s] += w;
    }
    if (full) {
      add(sum.full, S);
      sum.full_volume += w;
    }
  }
  return sum;
}

namespace {

  using Six = Eigen::Matrix<double, 6, 1>;    // xx yy zz yz xz xy

  /// A tensor given along perpendicular unit axes, in space.
  void turn_into(double out[6], const Six &S, const Mat3 &axes)
  {
    Mat3 T;
    T << S[0], S[5], S[4], S[5], S[1], S[3], S[4], S[3], S[2];
    T = (axes * T * axes.transpose()).eval();
    add(out, T);
  }

}    // namespace

CrackStress crack_stress_orthogonal(const Mat3 &axes, const double length[6], const double half[6],
                                    const Vec3 y[6], unsigned present, const CornerModuli &moduli)
{
  // along the axes of the cell: displacement per length at each slot, strains from pairs of them
  double normal[6] = {};
  Vec3 g[6], stretched[6];    // u/L and y/L, both towards the positive axis
  for (int s = 0; s < 6; ++s) {
    if (!(present >> s & 1u)) continue;
    const double inverse = (s % 2 ? 1.0 : -1.0) / length[s];
    stretched[s] = inverse * y[s];
    g[s] = inverse * (y[s] - (s % 2 ? length[s] : -length[s]) * axes.col(s / 2));
    normal[s] = 0.5 * g[s].dot(stretched[s] + axes.col(s / 2));
  }
  const auto shear = [&](int s, int t) {
    return 0.5 * (g[s].dot(stretched[t]) + axes.col(s / 2).dot(g[t]));
  };
  double pair[6][6];
  for (int s = 0; s < 4; ++s)
    for (int t = 2 * (s / 2) + 2; t < 6; ++t)
      if (present >> s & 1u && present >> t & 1u) pair[s][t] = shear(s, t);

  Six slot[6], full = Six::Zero();
  CrackStress sum{};
  for (Six &one : slot) one.setZero();
  for (int corner = 0; corner < 8; ++corner) {
    const int s[3] = {corner_slot(corner, 0), corner_slot(corner, 1), corner_slot(corner, 2)};
    bool there[3];
    double trace = 0.0;
    int joints = 0;
    for (int a = 0; a < 3; ++a) {
      there[a] = present >> s[a] & 1u;
      joints += there[a];
      if (there[a]) trace += normal[s[a]];
    }
    if (joints == 0) continue;
    const double w = half[s[0]] * half[s[1]] * half[s[2]];
    const double p = reduced_lambda(moduli, joints) * trace, mu2 = 2.0 * moduli.mu;
    Six S = Six::Zero();
    for (int a = 0; a < 3; ++a) {
      if (there[a]) S[a] = w * (p + mu2 * normal[s[a]]);
      const int b = (a + 1) % 3, c = (a + 2) % 3;    // S[3 + a] is that of the two other axes
      if (there[b] && there[c]) S[3 + a] = w * mu2 * pair[s[b < c ? b : c]][s[b < c ? c : b]];
    }
    for (int a = 0; a < 3; ++a)
      if (there[a]) {
        slot[s[a]] += S;
        sum.slot_volume[s[a]] += w;
      }
    if (joints == 3) {
      full += S;
      sum.full_volume += w;
    }
  }
  for (int s = 0; s < 6; ++s)
    if (sum.slot_volume[s] > 0.0) turn_into(sum.slot[s], slot[s], axes);
  turn_into(sum.full, full, axes);
  return sum;
}

Mat3 crack_tensor(const double s[6])
{
  Mat3 S;
  S << s[0], s[5], s[4], s[5], s[1], s[3], s[4], s[3], s[2];
  return S;
}

double crack_quiet_energy(double volume, const CornerModuli &moduli, double sigma_t, double share)
{
  const double s = share * sigma_t;
  return 0.5 * volume * 0.5 * s * s / (moduli.lambda + 2.0 * moduli.mu);
}

double largest_principal_bound(const Mat3 &S)
{
  const double p = S.trace() / 3.0;
  return p + std::sqrt((S - p * Mat3::Identity()).squaredNorm() * 2.0 / 3.0);
}

Principal largest_principal(const Mat3 &S)
{
  const Eigen::SelfAdjointEigenSolver<Mat3> solver(S);
  return {solver.eigenvalues()[2], solver.eigenvectors().col(2)};
}

Principal largest_principal(const Mat3 &S, const Vec3 &wish)
{
  const Eigen::SelfAdjointEigenSolver<Mat3> solver(S);
  const Vec3 &value = solver.eigenvalues();
  const Mat3 &axes = solver.eigenvectors();
  const double gap = 1e-6 * value.cwiseAbs().maxCoeff();
  Vec3 direction = wish;
  for (int k = 0; k < 2; ++k)
    if (value[2] - value[k] > gap) direction -= wish.dot(axes.col(k)) * axes.col(k);
  const bool single = value[2] - value[1] > gap;
  if (single || direction.norm() < 1e-3 * wish.norm()) return {value[2], axes.col(2)};
  return {value[2], direction.normalized()};
}

}    // namespace defe
