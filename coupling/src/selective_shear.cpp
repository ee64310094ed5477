#include "selective_shear.h"

#include <algorithm>
#include <cmath>

namespace defe {

namespace {

  constexpr int C = 8;
  constexpr int row[6] = {0, 1, 2, 0, 0, 1}, column[6] = {0, 1, 2, 1, 2, 2};
  constexpr int at[3][3] = {{0, 3, 4}, {3, 1, 5}, {4, 5, 2}};

  /// T of a term at the corners, within the span of the joints that are there.
  struct ShearTensor {
    double a[3][C], b[3][C];    ///< covariant components of the two vectors
    double stress[6][C];        ///< contravariant: derivative of psi at T

    /// Energy's inner product with a covariant strain.
    double times(const double E[6][C], int c) const
    {
      double sum = 0.0;
      for (int j = 0; j < 6; ++j) sum += (j < 3 ? 1.0 : 2.0) * stress[j][c] * E[j][c];
      return sum;
    }
    double times(const ShearTensor &other, int c) const
    {
      double sum = 0.0;
      for (int i = 0; i < 3; ++i)
        for (int j = 0; j < 3; ++j) sum += stress[at[i][j]][c] * other.a[i][c] * other.b[j][c];
      return sum;
    }
  };

  void fill(ShearTensor &T, const Vec3 &a, const Vec3 &b, const GeneralCell &cell, unsigned present,
            const double lambda[C], double mu, const double inverse[6][C])
  {
    double along[6], across[6];
    for (int s = 0; s < 6; ++s) {
      const bool there = present >> s & 1u;
      along[s] = there ? cell.dX[s].dot(a) : 0.0;
      across[s] = there ? cell.dX[s].dot(b) : 0.0;
    }
    for (int c = 0; c < C; ++c)
      for (int i = 0; i < 3; ++i) {
        T.a[i][c] = along[corner_slot(c, i)];
        T.b[i][c] = across[corner_slot(c, i)];
      }
    for (int c = 0; c < C; ++c) {
      double v[3] = {}, u[3] = {}, trace = 0.0;
      for (int i = 0; i < 3; ++i)
        for (int j = 0; j < 3; ++j) {
          v[i] += inverse[at[i][j]][c] * T.a[j][c];
          u[i] += inverse[at[i][j]][c] * T.b[j][c];
        }
      for (int i = 0; i < 3; ++i) trace += v[i] * T.b[i][c];
      for (int j = 0; j < 6; ++j)
        T.stress[j][c] = lambda[c] * trace * inverse[j][c] +
            mu * (v[row[j]] * u[column[j]] + v[column[j]] * u[row[j]]);
    }
  }

}    // namespace

SelectiveShear::SelectiveShear(const GeneralCell &cell)
{
  Vec3 g[3];
  double size2[3];
  int order[3] = {0, 1, 2};
  for (int a = 0; a < 3; ++a) {
    g[a] = cell.face[2 * a + 1] - cell.face[2 * a];
    size2[a] = g[a].squaredNorm();
  }
  const auto longest_first = [&](int i, int j) {
    if (size2[order[i]] < size2[order[j]]) std::swap(order[i], order[j]);
  };
  longest_first(0, 1);
  longest_first(1, 2);
  longest_first(0, 1);
  if (!(size2[order[2]] < cube_from * cube_from * size2[order[0]])) return;

  Vec3 dual[3];
  for (int a = 0; a < 3; ++a) dual[a] = g[(a + 1) % 3].cross(g[(a + 2) % 3]).normalized();
  for (int i = 0; i < 2; ++i)
    for (int j = i + 1; j < 3; ++j) {
      const int a = order[i], b = order[j];
      const double drop = shear_to_drop(std::sqrt(size2[a]), std::sqrt(size2[b]));
      if (drop > 0.0) list[n++] = {a, b, dual[a], dual[b], drop};
    }
}

/// f, and 1 - s, or what takes its place where one side is missing.
double SelectiveShear::weights(const Term &t, const GeneralCell &cell, unsigned present,
                               const double w[8], double f[8]) const
{
  const int slot[2] = {2 * t.along, 2 * t.along + 1};
  const bool there[2] = {(present >> slot[0] & 1u) != 0, (present >> slot[1] & 1u) != 0};
  const auto has = [&](int corner) {
    return (present >> corner_slot(corner, t.across) & 1u) != 0;
  };
  double side[2] = {0.0, 0.0};
  for (int c = 0; c < C; ++c)
    if (has(c)) side[c >> t.along & 1] += w[c];
  for (int c = 0; c < C; ++c) f[c] = 0.0;
  if (!(side[0] > 0.0 && side[1] > 0.0)) return 0.0;
  for (int c = 0; c < C; ++c) {
    const int i = c >> t.along & 1;
    if (has(c) && there[i]) f[c] = (i ? 1.0 : -1.0) / side[i];
  }
  if (there[0] && there[1]) return t.drop;
  if (!there[0] && !there[1]) return 0.0;
  const int missing = there[0] ? 1 : 0;
  const double left = side[1 - missing] / (side[0] + side[1]);
  const bool free = cell.free >> slot[missing] & 1u;
  return free ? 0.0 : t.drop * (1.0 - left) / (1.0 - t.drop * left);
}

double SelectiveShear::add(const GeneralCell &cell, unsigned present, const CornerModuli &moduli,
                           const double inverse[6][8], const double E[6][8], const double w[8],
                           double S[6][8]) const
{
  double of_joints[4], lambda[C];
  for (int k = 0; k < 4; ++k) of_joints[k] = reduced_lambda(moduli, k);
  for (int c = 0; c < C; ++c) {
    int joints = 0;
    for (int a = 0; a < 3; ++a) joints += present >> corner_slot(c, a) & 1u;
    lambda[c] = of_joints[joints];
  }
  ShearTensor T[3];
  double f[3][C], drop[3], norm2[3];
  for (int k = 0; k < n; ++k) {
    fill(T[k], list[k].a, list[k].b, cell, present, lambda, moduli.mu, inverse);
    drop[k] = weights(list[k], cell, present, w, f[k]);
    norm2[k] = 0.0;
    for (int c = 0; c < C; ++c) norm2[k] += w[c] * f[k][c] * f[k][c] * T[k].times(T[k], c);
    if (!(norm2[k] > 0.0)) drop[k] = 0.0, norm2[k] = 1.0;
  }
  double others[3] = {};
  for (int k = 0; k < n; ++k)
    for (int l = 0; l < k; ++l) {
      double common = 0.0;
      for (int c = 0; c < C; ++c) common += w[c] * f[k][c] * f[l][c] * T[k].times(T[l], c);
      common = std::abs(common) / std::sqrt(norm2[k] * norm2[l]);
      if (drop[k] > 0.0 && drop[l] > 0.0) {
        others[k] += common;
        others[l] += common;
      }
    }

  double energy = 0.0;
  for (int k = 0; k < n; ++k) {
    double difference = 0.0;
    for (int c = 0; c < C; ++c) difference += w[c] * f[k][c] * T[k].times(E, c);
    const double e = drop[k] / (1.0 + others[k]) * difference / norm2[k];
    energy -= 0.5 * e * difference;
    for (int j = 0; j < 6; ++j)
      for (int c = 0; c < C; ++c) S[j][c] -= e * w[c] * f[k][c] * T[k].stress[j][c];
  }
  return energy;
}

}    // namespace defe
