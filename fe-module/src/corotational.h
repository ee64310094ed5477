#ifndef DEFE_FE_COROTATIONAL_H
#define DEFE_FE_COROTATIONAL_H

// Corotational element forces of boxes, one element per lane (BrickKernel).
//
// F = sum_a y_a g_a^T = R U is the deformation gradient at the centre (y_a = x_a - x_0, g_a: the
// gradient of shape function a there), u_a = R^T y_a - Y_a with Y_a = X_a - X_0, W = 1/2 u.K u and
// p = K u. R is a function of x: with R^T dR = [w]x (spin) and b_a = R^T dx_a
//   du_a = b_a - w x (R^T y_a),  so  dW = sum_a p_a . b_a - w . m,  m = sum_a (R^T y_a) x p_a.
// The spin follows from F = R U: R^T dF = sum_a b_a g_a^T = [w]x U + dU, and the skew part of this
// is (tr(U) I - U) w = sum_a g_a x b_a. With q = (tr(U) I - U)^-1 m (symmetric)
//   dW = sum_a (p_a - q x g_a) . b_a,  f_a = -R (p_a - q x g_a).
// The second term is small, m being of second order in strain, but without it a deformed element
// exerts a net moment m and does not conserve energy. Since K annihilates rigid rotations,
// sum_a Y_a x p_a = 0, and m = sum_a u_a x p_a.
//
// Everything is done on modes (hex_modes.h). The linear ones are the centre's gradient: there u is E = U - I,
// symmetric, and p = V S with the stress S = lambda tr(E) I + 2 mu E of the centre and the volume V, since K of a box
// does not couple them with others. So R is needed for the other modes only, and m comes from these alone: S and E have
// the same axes.

#include "defe/fe/kernel.h"
#include "tangents.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace defe::fe {

/// Rotation of the polar decomposition F = R U, for det F > 0 of any size.
Mat3 polar_rotation(const Mat3 &F);

namespace lanes {

  inline constexpr double nan = std::numeric_limits<double>::quiet_NaN();

  DEFE_INLINE Pack determinant(const Pack A[3][3])
  {
    return A[0][0] * (A[1][1] * A[2][2] - A[1][2] * A[2][1]) -
        A[0][1] * (A[1][0] * A[2][2] - A[1][2] * A[2][0]) +
        A[0][2] * (A[1][0] * A[2][1] - A[1][1] * A[2][0]);
  }

  // symmetric tensors: xx yy zz xy xz yz
  inline constexpr int symmetric_row[6] = {0, 1, 2, 0, 0, 1},
                       symmetric_column[6] = {0, 1, 2, 1, 2, 2};

  DEFE_INLINE void set_adjugate(const Pack S[6], Pack adj[6])
  {
    adj[0] = S[1] * S[2] - S[5] * S[5];
    adj[1] = S[0] * S[2] - S[4] * S[4];
    adj[2] = S[0] * S[1] - S[3] * S[3];
    adj[3] = S[4] * S[5] - S[3] * S[2];
    adj[4] = S[3] * S[5] - S[4] * S[1];
    adj[5] = S[3] * S[4] - S[0] * S[5];
  }

  /// Polar decomposition A = R U by the series of R = A (I + S)^(-1/2) in S = A^T A - I; E = U - I = (I + S)^(1/2) - I.
  /// Returns the lanes that are near enough to a rotation for that, strains up to 0.3 %. What is cut off, 0.2 S^7, is less than rounding there.
  ///
  /// With the invariants I1, I2, I3 of S a polynomial in it is a + b S + c S^2, since S^3 = I1 S^2 - I2 S + I3; and
  /// S^2 = adj S + I1 S - I2.
  DEFE_INLINE simd::Mask polar_near(const Pack A[3][3], Pack R[3][3], Pack E[6])
  {
    constexpr double near = 8e-3;
    Pack S[6], adj[6];
    for (int k = 0; k < 6; ++k) {
      const int i = symmetric_row[k], j = symmetric_column[k];
      S[k] = A[0][i] * A[0][j] + A[1][i] * A[1][j] + A[2][i] * A[2][j];
      if (k < 3) S[k] -= 1.0;
    }
    set_adjugate(S, adj);
    const Pack I1 = S[0] + S[1] + S[2], I2 = adj[0] + adj[1] + adj[2];
    const Pack I3 = S[0] * adj[0] + S[3] * adj[3] + S[4] * adj[4];

    // Horner's scheme; at the end the 1 of (I + S)^(-1/2) is left out of a
    constexpr double binomial[7] = {1.0,        -1.0 / 2,    3.0 / 8,     -5.0 / 16,
                                    35.0 / 128, -63.0 / 256, 231.0 / 1024};
    Pack a = simd::broadcast(binomial[4]), b = simd::broadcast(binomial[5]);
    Pack c = simd::broadcast(binomial[6]);
    for (int k = 3; k >= 0; --k) {
      const Pack a_times_S = c * I3, b_times_S = a - c * I2, c_times_S = b + c * I1;
      a = k ? binomial[k] + a_times_S : a_times_S;
      b = b_times_S;
      c = c_times_S;
    }

    {    // U - I = M - I + S M, M = (I + S)^(-1/2)
      const Pack c_E = c + (b + c * I1), of_I = a + c * I3 - c_E * I2;
      const Pack of_S = (1.0 + (a + b)) - c * I2 + c_E * I1;
      for (int k = 0; k < 6; ++k) {
        E[k] = of_S * S[k] + c_E * adj[k];
        if (k < 3) E[k] += of_I;
      }
    }
    Pack M[6];
    const Pack of_I = 1.0 + (a - c * I2), of_S = b + c * I1;
    for (int k = 0; k < 6; ++k) {
      M[k] = of_S * S[k] + c * adj[k];
      if (k < 3) M[k] += of_I;
    }
    for (int i = 0; i < 3; ++i) {
      R[i][0] = A[i][0] * M[0] + A[i][1] * M[3] + A[i][2] * M[4];
      R[i][1] = A[i][0] * M[3] + A[i][1] * M[1] + A[i][2] * M[5];
      R[i][2] = A[i][0] * M[4] + A[i][1] * M[5] + A[i][2] * M[2];
    }
    return (I1 * I1 - 2.0 * I2 < near * near) &
        (determinant(A) > 0.0);    // the sum of squares of S
  }

  /// The same in one lane for any A. False, and NaN, where det A > 0 does not hold.
  inline bool polar_far(const Pack A[3][3], int lane, Pack R[3][3], Pack E[6])
  {
    Mat3 F;
    for (int i = 0; i < 3; ++i)
      for (int j = 0; j < 3; ++j) F(i, j) = A[i][j][lane];
    const bool valid = F.determinant() > 0.0;
    const Mat3 rotation = valid ? polar_rotation(F) : Mat3::Constant(nan);
    const Mat3 U = rotation.transpose() * F;
    for (int i = 0; i < 3; ++i)
      for (int j = 0; j < 3; ++j) R[i][j][lane] = rotation(i, j);
    for (int k = 0; k < 6; ++k) {
      const int i = symmetric_row[k], j = symmetric_column[k];
      E[k][lane] = 0.5 * (U(i, j) + U(j, i)) - (i == j ? 1.0 : 0.0);
    }
    return valid;
  }

  /// x <- A^-1 x for symmetric A (xx yy zz xy xz yz).
  DEFE_INLINE void solve_symmetric(const Pack A[6], Pack x[3])
  {
    Pack c[6];
    set_adjugate(A, c);
    const Pack inverse_det = 1.0 / (A[0] * c[0] + A[3] * c[3] + A[4] * c[4]);
    const Pack b0 = x[0] * inverse_det, b1 = x[1] * inverse_det, b2 = x[2] * inverse_det;
    x[0] = c[0] * b0 + c[3] * b1 + c[4] * b2;
    x[1] = c[3] * b0 + c[1] * b1 + c[5] * b2;
    x[2] = c[4] * b0 + c[5] * b1 + c[2] * b2;
  }

  /// stress_bound() of lambda tr(e) I + 2 mu e, for the strain e (xx yy zz xy xz yz): of_trace tr(e) + of_shear sqrt(J2(e)).
  struct BoundOfStrain {
    double of_trace, of_shear;
    BoundOfStrain(const IsotropicElastic &material, const StressBound &weights) :
        of_trace(weights.mean * (material.lambda() + 2.0 / 3.0 * material.mu())),
        of_shear(2.0 * material.mu() * weights.shear / std::sqrt(3.0))
    {
    }
    DEFE_INLINE Pack operator()(const Pack e[6]) const
    {
      const Pack xy = e[0] - e[1], yz = e[1] - e[2], zx = e[2] - e[0];
      const Pack J2 =
          (1.0 / 6.0) * (xy * xy + yz * yz + zx * zx) + (e[3] * e[3] + e[4] * e[4] + e[5] * e[5]);
      return of_trace * (e[0] + e[1] + e[2]) + of_shear * simd::sqrt(J2);
    }
  };

}    // namespace lanes

/// Constants of one box, for add_corotational_forces().
struct CorotationalShape {
  double G[3];    ///< dxi_k/dY_k along its edges, divided by 8

  /// \param Q  rotation of its edges from the global axes
  CorotationalShape(const HexCoords &X, const Mat3 &Q);
};

namespace lanes {

  /// Displacement gradient at the centre, of modes.
  DEFE_INLINE void centre_gradient(const Pack u[3][8], const CorotationalShape &shape, Pack H[3][3])
  {
    for (int i = 0; i < 3; ++i)
      for (int k = 0; k < 3; ++k) H[i][k] = u[i][1 << k] * shape.G[k];
  }

  /// Modes that are neither the mean nor linear.
  constexpr bool is_higher(int mode)
  {
    return (mode & (mode - 1)) != 0;
  }

  /// u = R^T y of the higher modes, where the reference positions have none.
  DEFE_INLINE void higher_displacements(const Pack R[3][3], const Pack y[3][8], Pack u[3][8])
  {
    for (int m = 1; m < 8; ++m)
      if (is_higher(m))
        for (int i = 0; i < 3; ++i)
          u[i][m] = R[0][i] * y[0][m] + R[1][i] * y[1][m] + R[2][i] * y[2][m];
  }

  DEFE_INLINE Pack strain_energy(const Pack E[6], const Pack VS[6], const Pack u[3][8],
                                 const Pack p[3][8])
  {
    Pack twice = E[0] * VS[0] + E[1] * VS[1] + E[2] * VS[2];
    twice += 2.0 * (E[3] * VS[3] + E[4] * VS[4] + E[5] * VS[5]);
    for (int m = 1; m < 8; ++m)
      if (is_higher(m))
        for (int i = 0; i < 3; ++i) twice += u[i][m] * p[i][m];
    return 0.5 * twice;
  }

  /// m = sum of u x p, of the higher modes.
  DEFE_INLINE void moment(const Pack u[3][8], const Pack p[3][8], Pack m[3])
  {
    Pack sum[3] = {};
    for (int k = 1; k < 8; ++k)
      if (is_higher(k)) {
        sum[0] += u[1][k] * p[2][k] - u[2][k] * p[1][k];
        sum[1] += u[2][k] * p[0][k] - u[0][k] * p[2][k];
        sum[2] += u[0][k] * p[1][k] - u[1][k] * p[0][k];
      }
    for (int i = 0; i < 3; ++i) m[i] = sum[i];
  }

  /// q = (tr(U) I - U)^-1 m with U - I = E.
  DEFE_INLINE void rotation_response(const Pack m[3], const Pack E[6], Pack q[3])
  {
    for (int i = 0; i < 3; ++i) q[i] = m[i];
    const Pack A[6] = {
        2.0 + E[1] + E[2], 2.0 + E[0] + E[2], 2.0 + E[0] + E[1], -E[3], -E[4], -E[5]};
    solve_symmetric(A, q);
  }

  /// The largest bound at the Gauss points, of the strain E at the centre and the higher modes u.
  ///
  /// With xi_k = sign_k/sqrt(3) and (i, j, k) cyclic the strains there are
  ///   e_kk = E_kk + G_k (xi_i u_k,ki + xi_j u_k,kj + xi_i xi_j u_k,7),
  ///   e_ij = E_ij + 1/2 G_j (xi_i u_i,ij + xi_k u_i,jk + xi_i xi_k u_i,7) + 1/2 G_i (xi_j u_j,ij + xi_k u_j,ik + xi_j xi_k u_j,7).
  /// The enhanced strain of a box (enhanced.h) is explicit: no shear strain is linear in one of its own two coordinates, so that
  /// the first terms of the brackets vanish, and no normal stress in its own, which takes side xi_k (G_i u_i,ik + G_j u_j,jk) from e_kk.
  /// \param side  lambda/(lambda + 2 mu), of enhanced elements
  template <bool enhanced>
  DEFE_INLINE Pack bound_at_gauss_points(const Pack E[6], const Pack u[3][8],
                                         const CorotationalShape &shape,
                                         const BoundOfStrain &bound_of, double side)
  {
    constexpr double g = gauss;
    // by the signs of xi_i and xi_j (bits 0 and 1): normal strain, shear strain, and what xi_k adds to it
    Pack normal[3][4], shear[3][4], twist[3][4], across[3];
    for (int k = 0; k < 3; ++k) {
      const int i = (k + 1) % 3, j = (k + 2) % 3;
      const int ij = 1 << i | 1 << j, ik = 1 << i | 1 << k, jk = 1 << j | 1 << k;
      const double Gi = g * shape.G[i], Gj = g * shape.G[j], Gk = g * shape.G[k];
      const auto by_signs = [](const Pack &middle, const Pack &by_i, const Pack &by_j,
                               const Pack &by_both, Pack value[4]) {
        const Pack low = middle - by_i, high = middle + by_i;
        const Pack j_low = by_j - by_both, j_high = by_j + by_both;
        value[0] = low - j_low;
        value[1] = high - j_high;
        value[2] = low + j_low;
        value[3] = high + j_high;
      };
      by_signs(E[k], Gk * u[k][ik], Gk * u[k][jk], (g * Gk) * u[k][7], normal[k]);
      by_signs(0.5 * (Gj * u[i][jk] + Gi * u[j][ik]), (0.5 * g * Gj) * u[i][7],
               (0.5 * g * Gi) * u[j][7], Pack{}, twist[k]);
      if constexpr (enhanced)
        across[k] = side * (Gi * u[i][ik] + Gj * u[j][jk]);
      else
        by_signs(E[5 - k], (0.5 * Gj) * u[i][ij], (0.5 * Gi) * u[j][ij], Pack{}, shear[k]);
    }
    Pack bound;
    for (int point = 0; point < 8; ++point) {
      Pack strain[6];
      for (int k = 0; k < 3; ++k) {
        const int q = tangent_index(point, k);
        const double sign = hex_sign[point][k];
        strain[k] = enhanced ? normal[k][q] - sign * across[k] : normal[k][q];
        strain[5 - k] = (enhanced ? E[5 - k] : shear[k][q]) + sign * twist[k][q];
      }
      const Pack here = bound_of(strain);
      bound = point == 0 ? here : simd::max(here, bound);
    }
    return bound;
  }

  /// Forces on the nodes in space, -R p, of the higher modes.
  DEFE_INLINE void higher_to_space(const Pack R[3][3], const Pack p[3][8], Pack force[3][8])
  {
    for (int m = 1; m < 8; ++m)
      if (is_higher(m))
        for (int i = 0; i < 3; ++i)
          force[i][m] = -(R[i][0] * p[0][m] + R[i][1] * p[1][m] + R[i][2] * p[2][m]);
  }

  /// Those of the linear modes, -R (V S - [q]x) G, in which q takes the moment out that the higher ones have.
  DEFE_INLINE void linear_to_space(const Pack R[3][3], const Pack VS[6], const Pack q[3],
                                   const CorotationalShape &shape, Pack force[3][8])
  {
    const Pack T[3][3] = {{VS[0], VS[3] + q[2], VS[4] - q[1]},
                          {VS[3] - q[2], VS[1], VS[5] + q[0]},
                          {VS[4] + q[1], VS[5] - q[0], VS[2]}};
    for (int i = 0; i < 3; ++i) {
      force[i][0] = Pack{};
      for (int k = 0; k < 3; ++k)
        force[i][1 << k] =
            -shape.G[k] * (R[i][0] * T[0][k] + R[i][1] * T[1][k] + R[i][2] * T[2][k]);
    }
  }

}    // namespace lanes

/// Stiffness of boxes: has an ElementType `type`, a CorotationalShape `shape`; set_stress(E, VS):
/// strain at the centre -> volume times stress; and apply(u, p): higher modes of the displacements times 8 -> higher modes of the forces K u.
template <class Stiffness, bool with_energy, bool with_bound, bool seldom>
void add_corotational_forces(const Stiffness &stiffness, const IsotropicElastic &material, int n,
                             const int (*nodes)[8], const double *x, double *f,
                             const HexKernel::Output &out)
{
  constexpr int W = simd::width;
  const CorotationalShape &shape = stiffness.shape;
  [[maybe_unused]] const lanes::BoundOfStrain bound_of(material, out.bound_weights);
  [[maybe_unused]] const double side =
      material.lambda() / (material.lambda() + 2.0 * material.mu());

  // Phase by phase for a lot of packs: what is alive in a phase nearly fits into the registers, and its packs, which do not depend on each
  // other, overlap. All at once for one pack, most of the time went into reading and writing what did not fit.
  constexpr int packs_of_lot = 32 / W;
  struct Work {
    Pack y[3][8];    // positions
    Pack p[3][8];    // forces: of the higher modes in the element's axes, then all, in space
    Pack R[3][3], E[6];
    Pack m[3];
  };
  Work lot[packs_of_lot];

  LostElements lost;
  Pack virial[6] = {};

  for (int start = 0; start < n; start += W * packs_of_lot) {
    const int packs = std::min(packs_of_lot, (n - start + W - 1) / W);
    const auto elements_of = [&](int k) {
      const int first = start + W * k;
      return LaneElements{nodes + first, std::min(W, n - first)};
    };

    for (int k = 0; k < packs; ++k) gather_modes(elements_of(k), x, lot[k].y);

    unsigned far[packs_of_lot];    // lanes
    for (int k = 0; k < packs; ++k) {
      Work &w = lot[k];
      Pack F[3][3];
      lanes::centre_gradient(w.y, shape, F);
      far[k] = simd::bits(~lanes::polar_near(F, w.R, w.E));
    }
    for (int k = 0; k < packs; ++k)
      if (__builtin_expect(far[k], false)) {
        Pack F[3][3];
        lanes::centre_gradient(lot[k].y, shape, F);
        for (int l = 0; l < W; ++l)
          if (far[k] >> l & 1 && !lanes::polar_far(F, l, lot[k].R, lot[k].E))
            lost.note(elements_of(k), start + W * k, l);
      }

    for (int k = 0; k < packs; ++k) {
      Work &w = lot[k];
      Pack u[3][8], p[3][8];
      lanes::higher_displacements(w.R, w.y, u);
      stiffness.apply(u, p);
      lanes::moment(u, p, w.m);
      if constexpr (with_energy) {
        Pack VS[6];
        stiffness.set_stress(w.E, VS);
        store_lanes(elements_of(k), lanes::strain_energy(w.E, VS, u, p),
                    out.energy + start + W * k);
      }
      lanes::higher_to_space(w.R, p, w.p);
    }

    if constexpr (with_bound)
      if (out.bound_at_gauss_points)
        for (int k = 0; k < packs; ++k) {
          const Work &w = lot[k];
          Pack u[3][8];
          lanes::higher_displacements(w.R, w.y, u);
          store_lanes(elements_of(k),
                      stiffness.type == ElementType::enhanced
                          ? lanes::bound_at_gauss_points<true>(w.E, u, shape, bound_of, side)
                          : lanes::bound_at_gauss_points<false>(w.E, u, shape, bound_of, side),
                      out.stress_bound + start + W * k);
        }

    for (int k = 0; k < packs; ++k) {
      Work &w = lot[k];
      Pack VS[6], q[3];
      stiffness.set_stress(w.E, VS);
      if constexpr (with_bound)
        if (!out.bound_at_gauss_points)
          store_lanes(elements_of(k), bound_of(w.E), out.stress_bound + start + W * k);
      lanes::rotation_response(w.m, w.E, q);
      lanes::linear_to_space(w.R, VS, q, shape, w.p);
    }

    for (int k = 0; k < packs; ++k)
      if constexpr (seldom)
        scatter_seldom(elements_of(k), start + W * k, lot[k].y, lot[k].p, f, virial, out);
      else
        scatter_modes(elements_of(k), lot[k].p, f);
  }

  if (out.virial) sum_lanes(virial, out.virial);
  if (out.inverted) *out.inverted = lost.first;
}

/// Chooses the instance for the outputs that are wanted.
template <class Stiffness>
void add_corotational_forces(const Stiffness &stiffness, const IsotropicElastic &material, int n,
                             const int (*nodes)[8], const double *x, double *f,
                             const HexKernel::Output &out)
{
  choose_outputs(out, [&](auto energy, auto bound, auto seldom) {
    add_corotational_forces<Stiffness, energy(), bound(), seldom()>(stiffness, material, n, nodes,
                                                                    x, f, out);
  });
}

}    // namespace defe::fe

#endif
