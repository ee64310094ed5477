#include "defe/coupling/crack_stress.h"

#include "corner_metric.h"
#include "selective_shear.h"

#include "defe/simd.h"

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

  /// Adds the selective shear of a flat cell to volume times stress of its corners.
  void add_selective_shear(const SelectiveShear &selective, const GeneralCell &cell,
                           const Vec3 y[6], unsigned present, const CornerModuli &moduli,
                           const double w[8], Mat3 stress[8])
  {
    constexpr int at[3][3] = {{0, 3, 4}, {3, 1, 5}, {4, 5, 2}};
    double inverse[6][8] = {}, E[6][8] = {};
    for (int corner = 0; corner < 8; ++corner) {
      const CornerMetric m(cell, present, corner);
      for (int a = 0; a < 3; ++a) inverse[a][corner] = 1.0;
      for (int a = 0; a < m.joints; ++a)
        for (int b = a; b < m.joints; ++b) {
          const int s = m.slot[a], t = m.slot[b];
          const Vec3 us = y[s] - cell.dX[s], ut = y[t] - cell.dX[t];
          inverse[at[s / 2][t / 2]][corner] = m.inverse(a, b);
          E[at[s / 2][t / 2]][corner] =
              0.25 * (us.dot(y[t] + cell.dX[t]) + ut.dot(y[s] + cell.dX[s]));
        }
    }
    ShearTerm terms[3];
    const int n = selective.terms(cell, present, moduli, inverse, w, terms);
    for (int k = 0; k < n; ++k) {
      const double e = terms[k].scale * terms[k].of(E);
      for (int corner = 0; corner < 8; ++corner)
        for (int a = 0; a < 3; ++a)
          for (int b = 0; b < 3; ++b) {
            const int s = corner_slot(corner, a), t = corner_slot(corner, b);
            if (present >> s & present >> t & 1u)
              stress[corner] -=
                  e * terms[k].S[at[a][b]][corner] * cell.dX[s] * cell.dX[t].transpose();
          }
    }
  }

}    // namespace

CrackStress crack_stress(const GeneralCell &cell, const Vec3 y[6], unsigned present,
                         const CornerModuli &moduli)
{
  CrackStress sum{};
  double w[8];
  Mat3 stress[8];
  for (int corner = 0; corner < 8; ++corner) {
    const unsigned all =
        1u << corner_slot(corner, 0) | 1u << corner_slot(corner, 1) | 1u << corner_slot(corner, 2);
    w[corner] = corner_volume(cell, corner);
    if ((present & all) == all)
      stress[corner] = full_stress(cell, y, corner, w[corner], moduli);
    else if (present & all)
      stress[corner] = reduced_stress(cell, y, present, corner, w[corner], moduli);
    else
      stress[corner].setZero();
  }
  const SelectiveShear selective(cell);
  if (selective.any()) add_selective_shear(selective, cell, y, present, moduli, w, stress);
  for (int corner = 0; corner < 8; ++corner) {
    const unsigned all =
        1u << corner_slot(corner, 0) | 1u << corner_slot(corner, 1) | 1u << corner_slot(corner, 2);
    if (!(present & all)) continue;
    for (int a = 0; a < 3; ++a) {
      const int s = corner_slot(corner, a);
      if (!(present >> s & 1u)) continue;
      add(sum.slot[s], stress[corner]);
      sum.slot_volume[s] += w[corner];
    }
    if ((present & all) == all) {
      add(sum.full, stress[corner]);
      sum.full_volume += w[corner];
    }
  }
  return sum;
}

// Boxes, one per lane, along the axes of their cells. With u/L of slot s, towards the positive axis, as g_s, the strains
// of pairs of slots are E_ss = g_a + g.g/2 and E_st = (g_s.g_t + g_s,b + g_t,a)/2.
namespace {

  using simd::Pack;

  constexpr int first_of[3] = {1, 0, 0}, second_of[3] = {2, 2, 1};    // axes of the shears yz xz xy

  struct BoxLanes {
    Pack axes[3][3], g[6][3], there[6], half[6];
    Pack free[6];           // 1 where there never was a joint
    Pack lambda[4], mu2;    // by joints at a corner; 2 mu

    BoxLanes(int n, const CrackBox *box)
    {
      const auto of = [&](const auto &value) {
        return simd::generate([&](int l) {
          return value(box[l < n ? l : 0]);
        });
      };
      for (int i = 0; i < 3; ++i)
        for (int a = 0; a < 3; ++a)
          axes[i][a] = of([=](const CrackBox &b) {
            return b.axes(i, a);
          });
      for (int s = 0; s < 6; ++s) {
        const double sign = s % 2 ? 1.0 : -1.0;
        there[s] = of([=](const CrackBox &b) {
          return b.present >> s & 1u ? 1.0 : 0.0;
        });
        half[s] = of([=](const CrackBox &b) {
          return b.half[s];
        });
        free[s] = of([=](const CrackBox &b) {
          return b.free >> s & 1u ? 1.0 : 0.0;
        });
        const Pack length = of([=](const CrackBox &b) {
          return b.present >> s & 1u ? b.length[s] : 1.0;
        });
        const Pack inverse = there[s] * sign / length;
        Pack u[3];    // by displacements, so that nothing cancels when the strain is small
        for (int i = 0; i < 3; ++i)
          u[i] = of([=](const CrackBox &b) {
                   return b.y[s][i];
                 }) -
              sign * length * axes[i][s / 2];
        for (int a = 0; a < 3; ++a)
          g[s][a] = inverse * (axes[0][a] * u[0] + axes[1][a] * u[1] + axes[2][a] * u[2]);
      }
      for (int joints = 0; joints < 4; ++joints)
        lambda[joints] = of([=](const CrackBox &b) {
          return reduced_lambda(b.moduli, joints);
        });
      mu2 = of([](const CrackBox &b) {
        return 2.0 * b.moduli.mu;
      });
    }

    Pack normal(int s) const
    {
      const Pack *v = g[s];
      return v[s / 2] + 0.5 * (v[0] * v[0] + v[1] * v[1] + v[2] * v[2]);
    }
    Pack shear(int s, int t) const
    {
      const Pack *v = g[s], *w = g[t];
      return 0.5 * (v[0] * w[0] + v[1] * w[1] + v[2] * w[2] + v[t / 2] + w[s / 2]) * there[s] *
          there[t];
    }
  };

  struct SumLanes {
    Pack slot[6][6], slot_volume[6], full[6], full_volume;
  };

  /// A tensor given along the axes, in space.
  void turn_into_space(const Pack axes[3][3], Pack S[6])
  {
    constexpr int row[6] = {0, 1, 2, 1, 0, 0}, column[6] = {0, 1, 2, 2, 2, 1};
    const Pack T[3][3] = {{S[0], S[5], S[4]}, {S[5], S[1], S[3]}, {S[4], S[3], S[2]}};
    Pack A[3][3];
    for (int i = 0; i < 3; ++i)
      for (int b = 0; b < 3; ++b)
        A[i][b] = axes[i][0] * T[0][b] + axes[i][1] * T[1][b] + axes[i][2] * T[2][b];
    for (int k = 0; k < 6; ++k) {
      const int i = row[k], j = column[k];
      S[k] = A[i][0] * axes[j][0] + A[i][1] * axes[j][1] + A[i][2] * axes[j][2];
    }
  }

  /// Selective shear: E of the corners on either side of a longer axis, each less its share of the difference.
  void reduce_shear(const BoxLanes &box, Pack shear[6][6])
  {
    const auto at = [&](int s, int t) -> Pack & {
      return s < t ? shear[s][t] : shear[t][s];
    };
    Pack length[3];
    for (int a = 0; a < 3; ++a) length[a] = box.half[2 * a] + box.half[2 * a + 1];
    for (int a = 0; a < 3; ++a)
      for (int b = 0; b < 3; ++b) {
        if (a == b) continue;
        const Pack drop = simd::generate([&](int l) {
          const double ratio = length[b][l] / length[a][l];
          return shear_to_drop(ratio * ratio);
        });
        bool any = false;
        for (int l = 0; l < simd::width; ++l) any |= drop[l] > 0.0;
        if (!any) continue;
        const int side[2] = {2 * a, 2 * a + 1}, t = 2 * b, u = 2 * b + 1;
        const Pack ht = box.there[t] * box.half[t], hu = box.there[u] * box.half[u];
        const Pack across = simd::max(ht + hu, 1e-6 * length[b]);    // without joints E is 0
        Pack mean[2];
        for (int i = 0; i < 2; ++i) mean[i] = (ht * at(side[i], t) + hu * at(side[i], u)) / across;
        for (int i = 0; i < 2; ++i) {
          const Pack part = box.half[side[i]] / length[a];
          const Pack alone = (1.0 - box.there[side[1 - i]]) * (1.0 - box.free[side[1 - i]]);
          const Pack weight = box.there[side[1 - i]] + alone / (1.0 - drop * part);
          // of either side the other one's part; mean is 0 where there is no joint
          const Pack less =
              drop * (1.0 - part) * weight * (mean[i] - mean[1 - i]) * box.there[side[i]];
          at(side[i], t) -= less * box.there[t];
          at(side[i], u) -= less * box.there[u];
        }
      }
  }

  void sum_corners(const BoxLanes &box, SumLanes &sum)
  {
    Pack normal[6], shear[6][6];
    for (int s = 0; s < 6; ++s) normal[s] = box.normal(s);
    for (int s = 0; s < 4; ++s)
      for (int t = 2 * (s / 2) + 2; t < 6; ++t) shear[s][t] = box.shear(s, t);
    reduce_shear(box, shear);
    sum = SumLanes{};
    for (int corner = 0; corner < 8; ++corner) {
      const int s[3] = {corner_slot(corner, 0), corner_slot(corner, 1), corner_slot(corner, 2)};
      const Pack x = box.there[s[0]], y = box.there[s[1]], z = box.there[s[2]];
      const Pack three = x * y * z, pairs = x * y + x * z + y * z;
      const Pack two = pairs - 3.0 * three, one = x + y + z - 2.0 * pairs + 3.0 * three;
      const Pack lambda = one * box.lambda[1] + two * box.lambda[2] + three * box.lambda[3];
      const Pack w = box.half[s[0]] * box.half[s[1]] * box.half[s[2]];
      const Pack p = lambda * (normal[s[0]] + normal[s[1]] + normal[s[2]]);
      Pack S[6];
      for (int a = 0; a < 3; ++a) {
        S[a] = w * box.there[s[a]] * (p + box.mu2 * normal[s[a]]);
        S[3 + a] = w * box.mu2 * shear[s[first_of[a]]][s[second_of[a]]];
      }
      for (int a = 0; a < 3; ++a) {
        for (int k = 0; k < 6; ++k) sum.slot[s[a]][k] += box.there[s[a]] * S[k];
        sum.slot_volume[s[a]] += box.there[s[a]] * w;
      }
      for (int k = 0; k < 6; ++k) sum.full[k] += three * S[k];
      sum.full_volume += three * w;
    }
    for (int s = 0; s < 6; ++s) turn_into_space(box.axes, sum.slot[s]);
    turn_into_space(box.axes, sum.full);
  }

}    // namespace

void crack_stress_orthogonal(int n, const CrackBox *box, CrackStress *out)
{
  for (int first = 0; first < n; first += simd::width) {
    const int count = std::min(simd::width, n - first);
    SumLanes sum;
    sum_corners(BoxLanes(count, box + first), sum);
    for (int l = 0; l < count; ++l) {
      CrackStress &o = out[first + l];
      for (int s = 0; s < 6; ++s) {
        for (int k = 0; k < 6; ++k) o.slot[s][k] = sum.slot[s][k][l];
        o.slot_volume[s] = sum.slot_volume[s][l];
      }
      for (int k = 0; k < 6; ++k) o.full[k] = sum.full[k][l];
      o.full_volume = sum.full_volume[l];
    }
  }
}

Mat3 crack_tensor(const double s[6])
{
  Mat3 S;
  S << s[0], s[5], s[4], s[5], s[1], s[3], s[4], s[3], s[2];
  return S;
}

double crack_least_volume(const GeneralCell &cell)
{
  double volume[6] = {};
  for (int corner = 0; corner < 8; ++corner)
    for (int a = 0; a < 3; ++a) volume[corner_slot(corner, a)] += corner_volume(cell, corner);
  return *std::min_element(volume, volume + 6);
}

double crack_quiet_energy(double least_volume, const CornerModuli &moduli, double sigma_t,
                          double share)
{
  const double s = share * sigma_t;
  return least_volume * 0.5 * s * s / (moduli.lambda + 2.0 * moduli.mu);
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
