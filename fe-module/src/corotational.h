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
// Everything is done on modes (hex_modes.h): the linear ones are the centre's gradient, so F, U
// and the correction involve only them, and K has 21 rows instead of 24.

#include "defe/fe/kernel.h"
#include "hex_modes.h"

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

  /// A -> the rotation R of A = R U. NaN in lanes where det A > 0 does not hold; returns their mask.
  ///
  /// R = A (A^T A)^(-1/2) by its Taylor series in S = A^T A - I: the second-order step leaves 5/8
  /// S^3, the first-order one 3/4 S^2, so a strain of 1e-3 takes one of each. Lanes with large S
  /// get R from polar_rotation() and then only the final step. A lane that has converged waits
  /// unchanged for the others, so that its result does not depend on them.
  DEFE_INLINE simd::Mask polar(Pack A[3][3])
  {
    constexpr double converged = 4e-9;    // the final step squares it
    constexpr double too_far = 0.3;
    const simd::Mask valid = determinant(A) > 0.0;

    Pack S[6];    // xx yy zz xy xz yz
    const auto error = [&A, &S] {
      Pack size = Pack{};
      constexpr int row[6] = {0, 1, 2, 0, 0, 1}, column[6] = {0, 1, 2, 1, 2, 2};
      for (int k = 0; k < 6; ++k) {
        const int i = row[k], j = column[k];
        S[k] = A[0][i] * A[0][j] + A[1][i] * A[1][j] + A[2][i] * A[2][j];
        if (k < 3) S[k] -= 1.0;
        size = simd::max(simd::abs(S[k]), size);
      }
      return size;
    };

    Pack size = error();
    if (__builtin_expect(simd::any(size > too_far), false)) {
      for (int l = 0; l < simd::width; ++l) {
        if (!(size[l] > too_far) || !valid[l]) continue;
        Mat3 F;
        for (int i = 0; i < 3; ++i)
          for (int j = 0; j < 3; ++j) F(i, j) = A[i][j][l];
        const Mat3 R = polar_rotation(F);
        for (int i = 0; i < 3; ++i)
          for (int j = 0; j < 3; ++j) A[i][j][l] = R(i, j);
      }
      size = error();
    }

    // lost lanes may diverge: they do not keep the others waiting
    simd::Mask busy = (size > converged) & valid;
    while (simd::any(busy)) {
      Pack C[6];    // -S/2 + 3/8 S^2
      C[0] = 0.375 * (S[0] * S[0] + S[3] * S[3] + S[4] * S[4]) - 0.5 * S[0];
      C[1] = 0.375 * (S[3] * S[3] + S[1] * S[1] + S[5] * S[5]) - 0.5 * S[1];
      C[2] = 0.375 * (S[4] * S[4] + S[5] * S[5] + S[2] * S[2]) - 0.5 * S[2];
      C[3] = 0.375 * (S[0] * S[3] + S[3] * S[1] + S[4] * S[5]) - 0.5 * S[3];
      C[4] = 0.375 * (S[0] * S[4] + S[3] * S[5] + S[4] * S[2]) - 0.5 * S[4];
      C[5] = 0.375 * (S[3] * S[4] + S[1] * S[5] + S[5] * S[2]) - 0.5 * S[5];
      for (int i = 0; i < 3; ++i) {
        const Pack x = A[i][0], y = A[i][1], z = A[i][2];
        A[i][0] = busy ? x + (x * C[0] + y * C[3] + z * C[4]) : x;
        A[i][1] = busy ? y + (x * C[3] + y * C[1] + z * C[5]) : y;
        A[i][2] = busy ? z + (x * C[4] + y * C[5] + z * C[2]) : z;
      }
      busy = (error() > converged) & valid;
    }

    for (int i = 0; i < 3; ++i) {
      const Pack x = A[i][0], y = A[i][1], z = A[i][2];
      const Pack none = simd::broadcast(nan);
      A[i][0] = valid ? x - 0.5 * (x * S[0] + y * S[3] + z * S[4]) : none;
      A[i][1] = valid ? y - 0.5 * (x * S[3] + y * S[1] + z * S[5]) : none;
      A[i][2] = valid ? z - 0.5 * (x * S[4] + y * S[5] + z * S[2]) : none;
    }
    return ~valid;
  }

  /// x <- A^-1 x for symmetric A (xx yy zz xy xz yz).
  DEFE_INLINE void solve_symmetric(const Pack A[6], Pack x[3])
  {
    const Pack c0 = A[1] * A[2] - A[5] * A[5];
    const Pack c3 = A[4] * A[5] - A[3] * A[2];
    const Pack c4 = A[3] * A[5] - A[4] * A[1];
    const Pack c1 = A[0] * A[2] - A[4] * A[4];
    const Pack c5 = A[3] * A[4] - A[0] * A[5];
    const Pack c2 = A[0] * A[1] - A[3] * A[3];
    const Pack inverse_det = 1.0 / (A[0] * c0 + A[3] * c3 + A[4] * c4);
    const Pack b0 = x[0] * inverse_det, b1 = x[1] * inverse_det, b2 = x[2] * inverse_det;
    x[0] = c0 * b0 + c3 * b1 + c4 * b2;
    x[1] = c3 * b0 + c1 * b1 + c5 * b2;
    x[2] = c4 * b0 + c5 * b1 + c2 * b2;
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

  /// Strain (xx yy zz xy xz yz) of a displacement gradient.
  DEFE_INLINE void symmetric(const Pack H[3][3], Pack e[6])
  {
    for (int i = 0; i < 3; ++i) e[i] = H[i][i];
    e[3] = 0.5 * (H[0][1] + H[1][0]);
    e[4] = 0.5 * (H[0][2] + H[2][0]);
    e[5] = 0.5 * (H[1][2] + H[2][1]);
  }

}    // namespace lanes

/// Constants of one shape in its own frame (rotated by Q from the global axes), for
/// add_corotational_forces().
struct CorotationalShape {
  /// inverse Jacobian matrices dxi_k/dY_j divided by 8, at the Gauss points and (8) the centre
  double G[9][3][3];
  /// modes of the reference positions relative to node 0, times 8 (hex_modes.h)
  double Y[3][8];

  CorotationalShape(const HexCoords &X, const Mat3 &Q);
};

namespace lanes {

  /// D = gradient by natural coordinates times 8, H = D G with a diagonal G
  DEFE_INLINE void to_local(const Pack D[3][3], const double G[3][3], Pack H[3][3])
  {
    for (int i = 0; i < 3; ++i)
      for (int j = 0; j < 3; ++j) H[i][j] = D[i][j] * G[j][j];
  }

  /// Displacement gradient at the centre, of modes.
  DEFE_INLINE void centre_gradient(const Pack u[3][8], const CorotationalShape &shape, Pack H[3][3])
  {
    Pack D[3][3];
    for (int i = 0; i < 3; ++i)
      for (int k = 0; k < 3; ++k) D[i][k] = u[i][1 << k];
    to_local(D, shape.G[8], H);
  }

  /// u = R^T y - Y.
  DEFE_INLINE void local_displacements(const Pack R[3][3], const Pack y[3][8],
                                       const CorotationalShape &shape, Pack u[3][8])
  {
    for (int m = 1; m < 8; ++m)
      for (int i = 0; i < 3; ++i) {
        u[i][m] = R[0][i] * y[0][m] + R[1][i] * y[1][m] + R[2][i] * y[2][m];
        if (m == 1 << i) u[i][m] -= shape.Y[i][m];
      }
  }

  DEFE_INLINE Pack strain_energy(const Pack u[3][8], const Pack p[3][8])
  {
    Pack twice = Pack{};
    for (int m = 1; m < 8; ++m)
      for (int i = 0; i < 3; ++i) twice += u[i][m] * p[i][m];
    return 0.5 * twice;
  }

  /// Moment m of the forces p, then q = (tr(U) I - U)^-1 m with U - I = the centre's strain.
  DEFE_INLINE void rotation_response(const Pack u[3][8], const Pack p[3][8], const Pack strain[6],
                                     Pack q[3])
  {
    for (int i = 0; i < 3; ++i) q[i] = Pack{};
    for (int m = 1; m < 8; ++m) {
      q[0] += u[1][m] * p[2][m] - u[2][m] * p[1][m];
      q[1] += u[2][m] * p[0][m] - u[0][m] * p[2][m];
      q[2] += u[0][m] * p[1][m] - u[1][m] * p[0][m];
    }
    const Pack A[6] = {2.0 + strain[1] + strain[2],
                       2.0 + strain[0] + strain[2],
                       2.0 + strain[0] + strain[1],
                       -strain[3],
                       -strain[4],
                       -strain[5]};
    solve_symmetric(A, q);
  }

  /// Adds the enhanced strain of a box (enhanced.h) at a Gauss point. There it is explicit: no shear strain is linear in
  /// one of its own two coordinates, and no normal stress in its own.
  DEFE_INLINE void add_enhanced_strain(const Pack u[3][8], int point, const double G[3][3],
                                       double side, Pack strain[6])
  {
    constexpr double g = 0.57735026918962576451;    // 1/sqrt(3)
    for (int k = 0; k < 3; ++k) {
      const int i = (k + 1) % 3, j = (k + 2) % 3;
      const double xi = g * hex_sign[point][i], xj = g * hex_sign[point][j];
      const double xk = g * hex_sign[point][k];
      const int ij = 1 << i | 1 << j;
      strain[5 - k] -= 0.5 * ((xi * G[j][j]) * u[i][ij] + (xj * G[i][i]) * u[j][ij]);
      strain[k] -=
          (side * xk) * (G[i][i] * u[i][1 << i | 1 << k] + G[j][j] * u[j][1 << j | 1 << k]);
    }
  }

  /// \param side  lambda/(lambda + 2 mu), of enhanced elements
  template <bool enhanced>
  DEFE_INLINE Pack bound_at_gauss_points(const Pack u[3][8], const CorotationalShape &shape,
                                         const BoundOfStrain &bound_of, double side)
  {
    Pack D[3][3], H[3][3], strain[6], bound;
    for (int point = 0; point < 8; ++point) {
      gradient_at_gauss_point(u, point, D);
      to_local(D, shape.G[point], H);
      symmetric(H, strain);
      if constexpr (enhanced) add_enhanced_strain(u, point, shape.G[point], side, strain);
      const Pack here = bound_of(strain);
      bound = point == 0 ? here : simd::max(here, bound);
    }
    return bound;
  }

  /// Takes the moment out of the forces p: what the rotation's dependence on the positions adds.
  DEFE_INLINE void balance_moment(const Pack q[3], const CorotationalShape &shape, Pack p[3][8])
  {
    for (int k = 0; k < 3; ++k) {
      const double *g = shape.G[8][k];
      const int m = 1 << k;
      const int i = (k + 1) % 3, j = (k + 2) % 3;    // q x e_k = q_j e_i - q_i e_j
      p[i][m] -= q[j] * g[k];
      p[j][m] += q[i] * g[k];
    }
  }

  /// Forces on the nodes in space: -R p.
  DEFE_INLINE void to_space(const Pack R[3][3], const Pack p[3][8], Pack force[3][8])
  {
    for (int i = 0; i < 3; ++i) force[i][0] = Pack{};
    for (int m = 1; m < 8; ++m)
      for (int i = 0; i < 3; ++i)
        force[i][m] = -(R[i][0] * p[0][m] + R[i][1] * p[1][m] + R[i][2] * p[2][m]);
  }

}    // namespace lanes

/// Stiffness: has an ElementType `type`, a CorotationalShape `shape`, of which G is diagonal and Y has linear modes only, and apply(u, p):
/// modes of the displacements times 8 -> modes of the forces K u.
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

  LostElements lost;
  Pack virial[6] = {};

  for (int first = 0; first < n; first += W) {
    const LaneElements elements{nodes + first, n - first < W ? n - first : W};

    Pack y[3][8];
    gather_modes(elements, x, y);

    Pack R[3][3];
    lanes::centre_gradient(y, shape, R);
    const simd::Mask flipped = lanes::polar(R);
    if (__builtin_expect(simd::any(flipped), false)) lost.note(elements, first, flipped);

    Pack u[3][8], p[3][8];
    lanes::local_displacements(R, y, shape, u);
    stiffness.apply(u, p);
    if constexpr (with_energy)
      store_lanes(elements, lanes::strain_energy(u, p), out.energy + first);

    Pack H[3][3], strain[6], q[3];
    lanes::centre_gradient(u, shape, H);
    lanes::symmetric(H, strain);
    lanes::rotation_response(u, p, strain, q);
    if constexpr (with_bound) {
      Pack bound;
      if (!out.bound_at_gauss_points)
        bound = bound_of(strain);
      else if (stiffness.type == ElementType::enhanced)
        bound = lanes::bound_at_gauss_points<true>(u, shape, bound_of, side);
      else
        bound = lanes::bound_at_gauss_points<false>(u, shape, bound_of, side);
      store_lanes(elements, bound, out.stress_bound + first);
    }

    Pack force[3][8];
    lanes::balance_moment(q, shape, p);
    lanes::to_space(R, p, force);
    if constexpr (seldom)
      scatter_seldom(elements, first, y, force, f, virial, out);
    else
      scatter_modes(elements, force, f);
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
