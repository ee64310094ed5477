#include "defe/fe/hex8.h"
#include "tangents.h"

#include <limits>
#include <stdexcept>

// Total Lagrangian St Venant-Kirchhoff in convected coordinates, one element per lane.
//
// With the columns of the two Jacobian matrices X_i = dX/dxi_i, x_i = dx/dxi_i = X_i + u_i and the
// metric G_ij = X_i . X_j (inverse G^ij), Green's strain has the covariant components
//   E_ij = (x_i . x_j - X_i . X_j)/2 = (u_i . M_j + M_i . u_j)/2,  M_i = (X_i + x_i)/2,
// the second form without cancellation. Then
//   S^ij = lambda (G^kl E_kl) G^ij + 2 mu G^ik E_kl G^lj,  W = sum over points of J S^ij E_ij / 2,
//   dW/dx_i = J S^ij x_j with J = det(X_1 X_2 X_3).
// This needs neither F nor gradients by X. By the symmetry of S the moments of the forces balance.

namespace defe::fe {

namespace {

  // One point of the element. All tangents are those above, 8 times too long; S^ij is then 64
  // times too small, which makes up for it wherever two of them meet.
  struct Point {
    Pack x[3][3];          // x_k, by k and component
    Pack Sx[3][3];         // S^kl x_l, by k and component
    Pack J;                // det(dX/dxi)
    Pack volume_change;    // det(dx/dX)
    Pack energy;           // per reference volume

    DEFE_INLINE Point(const Pack X[3][3], const Pack u[3][3], double lambda, double mu)
    {
      Pack M[3][3], n[3][3], nx[3];
      for (int k = 0; k < 3; ++k)
        for (int i = 0; i < 3; ++i) {
          x[k][i] = X[k][i] + u[k][i];
          M[k][i] = X[k][i] + 0.5 * u[k][i];
        }
      for (int k = 0; k < 3; ++k) cross(X[(k + 1) % 3], X[(k + 2) % 3], n[k]);
      const Pack det = dot(X[0], n[0]), inverse = 1.0 / det;
      J = det * (1.0 / 512.0);
      cross(x[1], x[2], nx);
      volume_change = dot(x[0], nx) * inverse;

      Pack G[3][3], E[3][3], A[3][3], S[3][3];    // G^kl, E_kl, A^k_l = G^km E_ml, S^kl
      for (int k = 0; k < 3; ++k)
        for (int i = 0; i < 3; ++i) n[k][i] *= inverse;
      for (int k = 0; k < 3; ++k)
        for (int l = k; l < 3; ++l) {
          G[k][l] = G[l][k] = dot(n[k], n[l]);
          E[k][l] = E[l][k] = 0.5 * (dot(u[k], M[l]) + dot(M[k], u[l]));
        }
      for (int k = 0; k < 3; ++k)
        for (int l = 0; l < 3; ++l)
          A[k][l] = G[k][0] * E[0][l] + G[k][1] * E[1][l] + G[k][2] * E[2][l];
      const Pack trace = A[0][0] + A[1][1] + A[2][2];
      for (int k = 0; k < 3; ++k)
        for (int l = k; l < 3; ++l)
          S[k][l] = S[l][k] = (lambda * trace) * G[k][l] +
              (2.0 * mu) * (A[k][0] * G[0][l] + A[k][1] * G[1][l] + A[k][2] * G[2][l]);
      for (int k = 0; k < 3; ++k)
        for (int i = 0; i < 3; ++i)
          Sx[k][i] = S[k][0] * x[0][i] + S[k][1] * x[1][i] + S[k][2] * x[2][i];
      energy = 0.5 * (S[0][0] * E[0][0] + S[1][1] * E[1][1] + S[2][2] * E[2][2]) +
          (S[0][1] * E[0][1] + S[0][2] * E[0][2] + S[1][2] * E[1][2]);
    }

    // of the Cauchy stress S^kl x_k x_l / det(dx/dX)
    DEFE_INLINE Pack stress_bound(const StressBound &weights) const
    {
      Pack s[6];
      constexpr int row[6] = {0, 1, 2, 0, 0, 1}, column[6] = {0, 1, 2, 1, 2, 2};
      for (int c = 0; c < 6; ++c)
        s[c] = x[0][row[c]] * Sx[0][column[c]] + x[1][row[c]] * Sx[1][column[c]] +
            x[2][row[c]] * Sx[2][column[c]];
      return symmetric_bound(s, weights) / volume_change;
    }
  };

  template <bool with_energy, bool with_bound, bool seldom>
  void add_lagrangian_forces(const IsotropicElastic &material, int n, const int (*nodes)[8],
                             const double *x, const double *X, double *f,
                             const HexKernel::Output &out)
  {
    constexpr int W = simd::width;
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

      Tangents tX, tu, tf;
      modes_to_tangents(Y, tX);
      modes_to_tangents(u, tu);
      for (auto &k : tf)
        for (auto &q : k)
          for (Pack &i : q) i = Pack{};

      simd::Mask valid = ~simd::Mask{};
      Pack energy = Pack{}, bound = Pack{};
      for (int a = 0; a < 8; ++a) {
        Pack Xk[3][3], uk[3][3];
        for (int k = 0; k < 3; ++k)
          for (int i = 0; i < 3; ++i) {
            Xk[k][i] = tX[k][tangent_index(a, k)][i];
            uk[k][i] = tu[k][tangent_index(a, k)][i];
          }
        const Point point(Xk, uk, lambda, mu);
        valid &= point.volume_change > 0.0;
        for (int k = 0; k < 3; ++k)
          for (int i = 0; i < 3; ++i) tf[k][tangent_index(a, k)][i] += point.J * point.Sx[k][i];
        if constexpr (with_energy) energy += point.J * point.energy;
        if constexpr (with_bound)
          if (out.bound_at_gauss_points) {
            const Pack here = point.stress_bound(out.bound_weights);
            bound = a == 0 ? here : simd::max(here, bound);
          }
      }

      const Pack poison = lost.poison(elements, first, valid);

      if constexpr (with_energy) store_lanes(elements, energy + poison, out.energy + first);
      if constexpr (with_bound) {
        if (!out.bound_at_gauss_points) {
          Pack Xk[3][3], uk[3][3];
          for (int k = 0; k < 3; ++k)
            for (int i = 0; i < 3; ++i) {
              Xk[k][i] = Y[i][1 << k];
              uk[k][i] = u[i][1 << k];
            }
          bound = Point(Xk, uk, lambda, mu).stress_bound(out.bound_weights);
        }
        store_lanes(elements, bound + poison, out.stress_bound + first);
      }

      Pack force[3][8];
      tangents_to_forces(tf, force);
      for (int i = 0; i < 3; ++i) force[i][7] += poison;
      if constexpr (seldom)
        scatter_seldom(elements, first, y, force, f, virial, out);
      else
        scatter_modes(elements, force, f);
    }

    if (out.virial) sum_lanes(virial, out.virial);
    if (out.inverted) *out.inverted = lost.first;
  }

}    // namespace

LagrangianKernel::LagrangianKernel(const IsotropicElastic &material) : elastic(material)
{
  const std::string complaint = material.validate();
  if (!complaint.empty()) throw std::invalid_argument(complaint);
}

void LagrangianKernel::add_forces(int n, const int (*nodes)[8], const double *x, const double *X,
                                  double *f, const Output &out) const
{
  choose_outputs(out, [&](auto energy, auto bound, auto seldom) {
    add_lagrangian_forces<energy(), bound(), seldom()>(elastic, n, nodes, x, X, f, out);
  });
}

double LagrangianKernel::energy(const HexCoords &x, const HexCoords &X, const double *) const
{
  double sum = 0.0;
  for (const Vec3 &xi : gauss_points()) {
    const Mat3 F = deformation_gradient(x, X, xi);
    const Mat3 green = 0.5 * (F.transpose() * F - Mat3::Identity());
    const double J = jacobian(X.colwise() - X.col(0), xi).determinant();
    sum += 0.5 * J * elastic_stress(green, elastic).cwiseProduct(green).sum();
  }
  return sum;
}

Mat3 LagrangianKernel::stress(const HexCoords &x, const HexCoords &X, const Vec3 &xi,
                              const double *) const
{
  const Mat3 F = deformation_gradient(x, X, xi);
  const Mat3 green = 0.5 * (F.transpose() * F - Mat3::Identity());
  return F * elastic_stress(green, elastic) * F.transpose() / F.determinant();
}

}    // namespace defe::fe
