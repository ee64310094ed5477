#include "selective_shear.h"

#include "defe/simd.h"

#include <algorithm>
#include <cmath>

namespace defe {

namespace {

  using simd::Pack;

  constexpr int C = 8, P = C / simd::width;    // corners, packs of them
  constexpr int row[6] = {0, 1, 2, 0, 0, 1}, column[6] = {0, 1, 2, 1, 2, 2};
  constexpr int at[3][3] = {{0, 3, 4}, {3, 1, 5}, {4, 5, 2}};

  struct Corners {
    Pack of[P];

    Corners() = default;
    explicit Corners(const double v[C])
    {
      for (int p = 0; p < P; ++p)
        of[p] = simd::generate([&](int l) {
          return v[p * simd::width + l];
        });
    }
    double sum() const
    {
      Pack all = of[0];
      for (int p = 1; p < P; ++p) all += of[p];
      double total = 0.0;
      for (int l = 0; l < simd::width; ++l) total += all[l];
      return total;
    }
  };

  /// T of a term at the corners, within the span of the joints that are there. Any multiple of it serves.
  struct ShearTensor {
    Corners a[3], b[3];    ///< covariant components of the two vectors
    Corners stress[6];     ///< contravariant: derivative of psi at T

    /// Sum over the corners of weight times the energy's inner product.
    double times(const ShearTensor &other, const Corners &weight) const
    {
      Corners result;
      for (int p = 0; p < P; ++p) {
        Pack sum = simd::broadcast(0.0);
        for (int i = 0; i < 3; ++i) {
          Pack inner = stress[at[i][0]].of[p] * other.b[0].of[p];
          for (int j = 1; j < 3; ++j) inner += stress[at[i][j]].of[p] * other.b[j].of[p];
          sum += other.a[i].of[p] * inner;
        }
        result.of[p] = weight.of[p] * sum;
      }
      return result.sum();
    }
  };

  void fill(ShearTensor &T, const Vec3 &a, const Vec3 &b, const GeneralCell &cell, unsigned present,
            const Corners &lambda, double mu, const Corners inverse[6])
  {
    double along[6], across[6];
    for (int s = 0; s < 6; ++s) {
      const bool there = present >> s & 1u;
      along[s] = there ? cell.dX[s].dot(a) : 0.0;
      across[s] = there ? cell.dX[s].dot(b) : 0.0;
    }
    for (int i = 0; i < 3; ++i)
      for (int p = 0; p < P; ++p) {
        const auto at_corners = [&](const double *of_slot) {
          return simd::generate([&](int l) {
            return of_slot[corner_slot(p * simd::width + l, i)];
          });
        };
        T.a[i].of[p] = at_corners(along);
        T.b[i].of[p] = at_corners(across);
      }
    for (int p = 0; p < P; ++p) {
      Pack v[3], u[3], trace = simd::broadcast(0.0);
      for (int i = 0; i < 3; ++i) {
        v[i] = inverse[at[i][0]].of[p] * T.a[0].of[p];
        u[i] = inverse[at[i][0]].of[p] * T.b[0].of[p];
        for (int j = 1; j < 3; ++j) {
          v[i] += inverse[at[i][j]].of[p] * T.a[j].of[p];
          u[i] += inverse[at[i][j]].of[p] * T.b[j].of[p];
        }
        trace += v[i] * T.b[i].of[p];
      }
      const Pack normal = lambda.of[p] * trace;
      for (int j = 0; j < 6; ++j)
        T.stress[j].of[p] =
            normal * inverse[j].of[p] + mu * (v[row[j]] * u[column[j]] + v[column[j]] * u[row[j]]);
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
  for (int a = 0; a < 3; ++a) dual[a] = g[(a + 1) % 3].cross(g[(a + 2) % 3]);
  for (int i = 0; i < 2; ++i)
    for (int j = i + 1; j < 3; ++j) {
      const int a = order[i], b = order[j];
      const double drop = shear_to_drop(size2[b] / size2[a]);
      if (drop > 0.0) list[n++] = {a, b, dual[a], dual[b], drop};
    }
}

/// f, and 1 - s, or what takes its place where one side is missing.
double SelectiveShear::weights(const Pair &t, const GeneralCell &cell, unsigned present,
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

double ShearTerm::of(const double E[6][8]) const
{
  double normal = 0.0, shear = 0.0;
  for (int j = 0; j < 3; ++j)
    for (int c = 0; c < C; ++c) {
      normal += S[j][c] * E[j][c];
      shear += S[3 + j][c] * E[3 + j][c];
    }
  return normal + 2.0 * shear;
}

int SelectiveShear::terms(const GeneralCell &cell, unsigned present, const CornerModuli &moduli,
                          const double inverse[6][8], const double w[8], ShearTerm out[3]) const
{
  double of_joints[4], lambda[C];
  for (int k = 0; k < 4; ++k) of_joints[k] = reduced_lambda(moduli, k);
  for (int c = 0; c < C; ++c) {
    int joints = 0;
    for (int a = 0; a < 3; ++a) joints += present >> corner_slot(c, a) & 1u;
    lambda[c] = of_joints[joints];
  }
  Corners metric[6];
  for (int j = 0; j < 6; ++j) metric[j] = Corners(inverse[j]);
  const Corners lambdas(lambda), volume(w);
  ShearTensor T[3];
  Corners f[3], weight;
  double drop[3], norm2[3], others[3] = {};
  for (int k = 0; k < n; ++k) {
    fill(T[k], list[k].a, list[k].b, cell, present, lambdas, moduli.mu, metric);
    double at_corner[C];
    drop[k] = weights(list[k], cell, present, w, at_corner);
    f[k] = Corners(at_corner);
    for (int p = 0; p < P; ++p) weight.of[p] = volume.of[p] * f[k].of[p] * f[k].of[p];
    norm2[k] = T[k].times(T[k], weight);
    if (!(norm2[k] > 0.0)) drop[k] = 0.0;
    for (int l = 0; l < k; ++l) {
      if (drop[k] == 0.0 || drop[l] == 0.0) continue;
      for (int p = 0; p < P; ++p) weight.of[p] = volume.of[p] * f[k].of[p] * f[l].of[p];
      const double common = std::abs(T[k].times(T[l], weight)) / std::sqrt(norm2[k] * norm2[l]);
      others[k] += common;
      others[l] += common;
    }
  }

  int count = 0;
  for (int k = 0; k < n; ++k) {
    if (drop[k] == 0.0) continue;
    ShearTerm &t = out[count++];
    t.scale = drop[k] / ((1.0 + others[k]) * norm2[k]);
    for (int p = 0; p < P; ++p) {
      const Pack wf = volume.of[p] * f[k].of[p];
      for (int j = 0; j < 6; ++j) {
        const Pack s = wf * T[k].stress[j].of[p];
        for (int l = 0; l < simd::width; ++l) t.S[j][p * simd::width + l] = s[l];
      }
    }
  }
  return count;
}

}    // namespace defe
