#include "defe/fe/enhanced_kernel.h"

#include "defe/fe/hex8.h"
#include "enhanced.h"
#include "tangents.h"

#include <stdexcept>

// Total Lagrangian St Venant-Kirchhoff with enhanced strain (enhanced.h), one element per lane.
//
// Cartesian, unlike lagrangian_kernel.cpp: the enhanced strain's axes are those of the centre, not the point's. With the
// tangents X_k = dX/dxi_k and u_k = du/dxi_k, c_k = X_l x X_m (cyclic), J = X_k . c_k,
//   H = du/dX = sum_k u_k c_k^T / J,  E = sym H + 1/2 H^T H,  dW/du_k = (I + H) S c_k.
// The first pass over the Gauss points leaves what h needs, the second adds C : E~ to S.
// All tangents are 8 times too long, so c is 64 times and J 512 times too large, and so are g and w^-1 of
// enhanced.h: h and a make up for each other.

namespace defe::fe {

namespace {

  constexpr int row[6] = {0, 1, 2, 0, 0, 1}, column[6] = {0, 1, 2, 1, 2, 2};
  constexpr int position[3][3] = {{0, 3, 4}, {3, 1, 5}, {4, 5, 2}};    // in xx yy zz xy xz yz

  DEFE_INLINE void elastic_stress(const Pack E[6], double lambda, double mu, Pack S[6])
  {
    const Pack pressure = lambda * (E[0] + E[1] + E[2]);
    for (int c = 0; c < 3; ++c) S[c] = pressure + (2.0 * mu) * E[c];
    for (int c = 3; c < 6; ++c) S[c] = (2.0 * mu) * E[c];
  }

  DEFE_INLINE void times(const Pack S[6], const Pack v[3], Pack Sv[3])
  {
    for (int i = 0; i < 3; ++i)
      Sv[i] = S[position[i][0]] * v[0] + S[position[i][1]] * v[1] + S[position[i][2]] * v[2];
  }

  // One point of the element, with the stress of the compatible strain.
  struct Point {
    Pack c[3][3];
    Pack H[3][3];
    Pack S[6];
    Pack inverse;          // 1/J
    Pack volume_change;    // det(I + H)

    DEFE_INLINE void set(const Pack X[3][3], const Pack u[3][3], double lambda, double mu)
    {
      for (int k = 0; k < 3; ++k) cross(X[(k + 1) % 3], X[(k + 2) % 3], c[k]);
      inverse = 1.0 / dot(X[0], c[0]);
      for (int i = 0; i < 3; ++i)
        for (int j = 0; j < 3; ++j)
          H[i][j] = inverse * (u[0][i] * c[0][j] + u[1][i] * c[1][j] + u[2][i] * c[2][j]);
      Pack E[6];
      for (int e = 0; e < 6; ++e) {
        const int i = row[e], j = column[e];
        E[e] =
            0.5 * (H[i][j] + H[j][i] + (H[0][i] * H[0][j] + H[1][i] * H[1][j] + H[2][i] * H[2][j]));
      }
      elastic_stress(E, lambda, mu, S);
      const Pack x = 1.0 + H[0][0], y = 1.0 + H[1][1], z = 1.0 + H[2][2];
      volume_change = x * (y * z - H[1][2] * H[2][1]) -
          H[0][1] * (H[1][0] * z - H[1][2] * H[2][0]) + H[0][2] * (H[1][0] * H[2][1] - y * H[2][0]);
    }

    DEFE_INLINE Pack energy(double lambda, double mu) const    // J S : C^-1 S / 2
    {
      const Pack trace = S[0] + S[1] + S[2];
      const Pack squares =
          S[0] * S[0] + S[1] * S[1] + S[2] * S[2] + 2.0 * (S[3] * S[3] + S[4] * S[4] + S[5] * S[5]);
      return (squares - (lambda / (3.0 * lambda + 2.0 * mu)) * trace * trace) /
          ((4.0 * mu) * inverse);
    }

    // of the Cauchy stress F S F^T / det F
    DEFE_INLINE Pack stress_bound(const StressBound &weights) const
    {
      Pack P[3][3], s[6];
      for (int i = 0; i < 3; ++i) {
        times(S, H[i], P[i]);
        for (int j = 0; j < 3; ++j) P[i][j] += S[position[i][j]];
      }
      for (int e = 0; e < 6; ++e) {
        const int i = row[e], j = column[e];
        s[e] = P[i][j] + P[i][0] * H[j][0] + P[i][1] * H[j][1] + P[i][2] * H[j][2];
      }
      return symmetric_bound(s, weights) / volume_change;
    }

    // t_k += J dW/du_k
    DEFE_INLINE void add_forces(int point, Tangents t) const
    {
      for (int k = 0; k < 3; ++k) {
        Pack Sc[3];
        times(S, c[k], Sc);
        for (int i = 0; i < 3; ++i)
          t[k][tangent_index(point, k)][i] +=
              Sc[i] + (H[i][0] * Sc[0] + H[i][1] * Sc[1] + H[i][2] * Sc[2]);
      }
    }
  };

  // J E~ and what it adds to the energy. Signs of the Gauss points in place of xi: their length cancels.
  struct Modes {
    Pack E[3][6];
    Pack energy;

    DEFE_INLINE Modes(const Point points[8], const Pack centre[3][3], double lambda, double mu)
    {
      Pack sum[3][6],
          w[4];    // of 1/J times 1 and the products of two signs, the third one's absent
      for (auto &of_k : sum)
        for (Pack &s : of_k) s = Pack{};
      for (Pack &p : w) p = Pack{};
      for (int a = 0; a < 8; ++a) {
        for (int k = 0; k < 3; ++k) {
          for (int e = 0; e < 6; ++e)
            sum[k][e] = hex_sign[a][k] > 0 ? sum[k][e] + points[a].S[e]
                                           : sum[k][e] - points[a].S[e];
          const int sign = hex_sign[a][(k + 1) % 3] * hex_sign[a][(k + 2) % 3];
          w[k] = sign > 0 ? w[k] + points[a].inverse : w[k] - points[a].inverse;
        }
        w[3] += points[a].inverse;
      }

      energy = Pack{};
      for (int k = 0; k < 3; ++k) {
        Pack g[3], h[3];
        cross(centre[(k + 1) % 3], centre[(k + 2) % 3], g);
        times(sum[k], g, h);
        const Pack weight = w[3] + simd::abs(w[(k + 1) % 3]) + simd::abs(w[(k + 2) % 3]);
        const Pack g2 = dot(g, g);
        const Pack scale = -1.0 / (mu * weight * g2);
        const Pack along = ((lambda + mu) / (lambda + 2.0 * mu)) * dot(g, h) / g2;
        Pack a[3];
        for (int i = 0; i < 3; ++i) a[i] = scale * (h[i] - along * g[i]);
        energy += 0.5 * dot(a, h);
        for (int e = 0; e < 6; ++e)
          E[k][e] = 0.5 * (a[row[e]] * g[column[e]] + a[column[e]] * g[row[e]]);
      }
    }

    DEFE_INLINE void add_stress(int point, double lambda, double mu, Point &p) const
    {
      Pack strain[6], stress[6];
      for (int e = 0; e < 6; ++e) {
        Pack sum = hex_sign[point][0] > 0 ? E[0][e] : -E[0][e];
        sum = hex_sign[point][1] > 0 ? sum + E[1][e] : sum - E[1][e];
        sum = hex_sign[point][2] > 0 ? sum + E[2][e] : sum - E[2][e];
        strain[e] = p.inverse * sum;
      }
      elastic_stress(strain, lambda, mu, stress);
      for (int e = 0; e < 6; ++e) p.S[e] += stress[e];
    }
  };

  DEFE_INLINE void centre_tangents(const Pack v[3][8], Pack t[3][3])
  {
    for (int k = 0; k < 3; ++k)
      for (int i = 0; i < 3; ++i) t[k][i] = v[i][1 << k];
  }

  template <bool with_energy, bool with_bound, bool seldom>
  void add_enhanced_forces(const IsotropicElastic &material, int n, const int (*nodes)[8],
                           const double *x, const double *X, double *f,
                           const HexKernel::Output &out)
  {
    constexpr int W = simd::width;
    constexpr double to_volume = 1.0 / 512.0;
    const double lambda = material.lambda(), mu = material.mu();
    LostElements lost;
    Pack virial[6] = {};

    for (int first = 0; first < n; first += W) {
      const LaneElements elements{nodes + first, n - first < W ? n - first : W};

      Pack Y[3][8], y[3][8], u[3][8];
      gather_modes(elements, X, Y);
      gather_modes(elements, x, y);
      for (int i = 0; i < 3; ++i)
        for (int m = 1; m < 8; ++m) u[i][m] = y[i][m] - Y[i][m];

      Tangents tX, tu;
      modes_to_tangents(Y, tX);
      modes_to_tangents(u, tu);

      simd::Mask valid = ~simd::Mask{};
      Pack energy = Pack{}, bound = Pack{};
      Point points[8];
      for (int a = 0; a < 8; ++a) {
        Pack Xk[3][3], uk[3][3];
        for (int k = 0; k < 3; ++k)
          for (int i = 0; i < 3; ++i) {
            Xk[k][i] = tX[k][tangent_index(a, k)][i];
            uk[k][i] = tu[k][tangent_index(a, k)][i];
          }
        points[a].set(Xk, uk, lambda, mu);
        valid &= points[a].volume_change > 0.0;
        if constexpr (with_energy) energy += points[a].energy(lambda, mu);
      }
      const Pack poison = lost.poison(elements, first, valid);

      Pack centre[3][3];
      centre_tangents(Y, centre);
      const Modes modes(points, centre, lambda, mu);
      if constexpr (with_energy)
        store_lanes(elements, to_volume * (energy + modes.energy) + poison, out.energy + first);

      Tangents tf;
      for (auto &k : tf)
        for (auto &q : k)
          for (Pack &i : q) i = Pack{};
      for (int a = 0; a < 8; ++a) {
        modes.add_stress(a, lambda, mu, points[a]);
        points[a].add_forces(a, tf);
        if constexpr (with_bound)
          if (out.bound_at_gauss_points) {
            const Pack here = points[a].stress_bound(out.bound_weights);
            bound = a == 0 ? here : simd::max(here, bound);
          }
      }
      if constexpr (with_bound) {
        if (!out.bound_at_gauss_points) {    // there E~ vanishes
          Pack uk[3][3];
          centre_tangents(u, uk);
          Point middle;
          middle.set(centre, uk, lambda, mu);
          bound = middle.stress_bound(out.bound_weights);
        }
        store_lanes(elements, bound + poison, out.stress_bound + first);
      }

      Pack force[3][8];
      tangents_to_forces(tf, force);
      for (int i = 0; i < 3; ++i) {
        for (int m = 1; m < 8; ++m) force[i][m] *= to_volume;
        force[i][7] += poison;
      }
      if constexpr (seldom)
        scatter_seldom(elements, first, y, force, f, virial, out);
      else
        scatter_modes(elements, force, f);
    }

    if (out.virial) sum_lanes(virial, out.virial);
    if (out.inverted) *out.inverted = lost.first;
  }

  // E, S = C : E and J at the Gauss points, and the enhanced strain that belongs to them
  struct Compatible {
    double energy = 0.0;
    EnhancedStrain enhanced;

    Compatible(const HexCoords &x, const HexCoords &X, const IsotropicElastic &material) :
        enhanced(X, material)
    {
      for (const Vec3 &xi : gauss_points()) {
        const Mat3 green = green_strain(x, X, xi), S = elastic_stress(green, material);
        const double J = jacobian(X.colwise() - X.col(0), xi).determinant();
        energy += 0.5 * J * S.cwiseProduct(green).sum();
        enhanced.add(xi, S);
      }
    }

    static Mat3 green_strain(const HexCoords &x, const HexCoords &X, const Vec3 &xi)
    {
      const Mat3 F = deformation_gradient(x, X, xi);
      return 0.5 * (F.transpose() * F - Mat3::Identity());
    }
  };

}    // namespace

EnhancedKernel::EnhancedKernel(const IsotropicElastic &material) : elastic(material)
{
  const std::string complaint = material.validate();
  if (!complaint.empty()) throw std::invalid_argument(complaint);
}

void EnhancedKernel::add_forces(int n, const int (*nodes)[8], const double *x, const double *X,
                                double *f, const Output &out) const
{
  choose_outputs(out, [&](auto energy, auto bound, auto seldom) {
    add_enhanced_forces<energy(), bound(), seldom()>(elastic, n, nodes, x, X, f, out);
  });
}

double EnhancedKernel::energy(const HexCoords &x, const HexCoords &X, const double *) const
{
  const Compatible c(x, X, elastic);
  return c.energy + c.enhanced.energy();
}

Mat3 EnhancedKernel::stress(const HexCoords &x, const HexCoords &X, const Vec3 &xi,
                            const double *) const
{
  const Mat3 F = deformation_gradient(x, X, xi);
  Mat3 strain = Compatible::green_strain(x, X, xi);
  if (!xi.isZero(0.0))
    strain += Compatible(x, X, elastic).enhanced.at(xi);    // at the centre it vanishes
  return F * elastic_stress(strain, elastic) * F.transpose() / F.determinant();
}

}    // namespace defe::fe
