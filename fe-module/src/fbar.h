#ifndef DEFE_FE_FBAR_H
#define DEFE_FE_FBAR_H

// The loop of all FBarKernels, one element per lane. A law gives w(F) and Q, where
//   dw/dF = Q - (Q : F)/3 F^-T
// is the isochoric part of Q; the loop does the projection, Jbar = v/V and the volumetric part,
//   V U(v/V), with derivative U'(Jbar) by v = sum over Gauss points of det(x_1 x_2 x_3).
//
// Law:
//   double bulk;
//   static constexpr int centre_size;   // packs of history that the centre needs
//   template <bool with_energy> void at_gauss_point(const Deformation &d, const LaneHistory &h,
//                 Pack centre[], Pack Q[3][3], Pack &energy, Pack &dissipated) const;
//       h: the history of this Gauss point; adds an eighth to `centre`; sets Q and (with_energy)
//       energy per volume; sets `dissipated` per volume if h.dissipation
//   void at_centre(const Deformation &d, const Pack centre[], Pack Q[3][3]) const;

#include "defe/fe/fbar_kernel.h"
#include "tangents.h"

#include <limits>
#include <stdexcept>

namespace defe::fe {

/// Deformation at one point.
struct Deformation {
  Pack F[3][3];
  Pack J;    // det F
  Pack j;    // J^(-1/3)
};

/// The history of one Gauss point of each lane's element.
struct LaneHistory {
  double *lane[simd::width];    // of the lanes' elements
  int valid;                    // lanes with an element of their own
  int offset;                   // to this Gauss point's
  bool advance, dissipation;

  DEFE_INLINE Pack load(int i) const
  {
    return simd::generate([&](int l) {
      return lane[l][offset + i];
    });
  }
  DEFE_INLINE void store(int i, const Pack &value) const
  {
    if (__builtin_expect(valid == simd::width, true))
      for (int l = 0; l < simd::width; ++l) lane[l][offset + i] = value[l];
    else
      for (int l = 0; l < valid; ++l) lane[l][offset + i] = value[l];
  }
};

namespace lanes {

  /// x^(-1/3) for x > 0 to some 2 ulp; no NaN or trap for any other x, but no meaning either.
  DEFE_INLINE Pack inverse_cube_root(const Pack &x)
  {
    // A third of the bit pattern is a third of the logarithm, to 4 %; then y <- y (1 - e)^(-1/3)
    // with e = 1 - x y^3, expanded to e^2, makes e of 0.1 to some 1e-3, 1e-9, 1e-27.
    simd::Mask bits;
    __builtin_memcpy(&bits, &x, sizeof(bits));
    const Pack third = __builtin_convertvector(bits, Pack) * (-1.0 / 3.0) + 6.1427980e18;
    bits = __builtin_convertvector(third, simd::Mask);
    Pack y;
    __builtin_memcpy(&y, &bits, sizeof(y));
    for (int i = 0; i < 3; ++i) {
      const Pack e = 1.0 - x * y * (y * y);
      y += y * e * (1.0 / 3.0 + (2.0 / 9.0) * e);
    }
    return y;
  }

  /// Kirchhoff stress: deviator of Q F^T (xx yy zz xy xz yz)
  DEFE_INLINE void deviatoric_kirchhoff(const Pack Q[3][3], const Pack F[3][3], Pack s[6])
  {
    constexpr int row[6] = {0, 1, 2, 0, 0, 1}, column[6] = {0, 1, 2, 1, 2, 2};
    for (int c = 0; c < 6; ++c) {
      const int i = row[c], j = column[c];
      s[c] = Q[i][0] * F[j][0] + Q[i][1] * F[j][1] + Q[i][2] * F[j][2];
    }
    const Pack mean = (s[0] + s[1] + s[2]) * (1.0 / 3.0);
    for (int i = 0; i < 3; ++i) s[i] -= mean;
  }

}    // namespace lanes

/// Tangents and deformation at one point from the tangents X and u, all times 8.
struct FBarPoint : Deformation {
  Pack dual[3][3];      // X^k with X^k . X_l = delta_kl, by k and component; an eighth
  Pack normal[3][3];    // x_(k+1) x x_(k+2): derivative of det(x_1 x_2 x_3) by x_k
  Pack det_X, det_x;

  DEFE_INLINE FBarPoint(const Pack X[3][3], const Pack u[3][3])
  {
    Pack x[3][3];
    for (int k = 0; k < 3; ++k)
      for (int i = 0; i < 3; ++i) x[k][i] = X[k][i] + u[k][i];
    for (int k = 0; k < 3; ++k) {
      cross(X[(k + 1) % 3], X[(k + 2) % 3], dual[k]);
      cross(x[(k + 1) % 3], x[(k + 2) % 3], normal[k]);
    }
    det_X = dot(X[0], dual[0]);
    det_x = dot(x[0], normal[0]);
    const Pack inverse = 1.0 / det_X;
    for (int k = 0; k < 3; ++k)
      for (int i = 0; i < 3; ++i) dual[k][i] *= inverse;
    for (int i = 0; i < 3; ++i)
      for (int j = 0; j < 3; ++j) {
        F[i][j] = u[0][i] * dual[0][j] + u[1][i] * dual[1][j] + u[2][i] * dual[2][j];
        if (i == j) F[i][j] += 1.0;
      }
    J = det_x * inverse;
    j = lanes::inverse_cube_root(J);
  }
};

// One piece: with the Gauss point in a function of its own, forced inline, a block of Prony material took 1.06 of the time.
template <class Law, bool with_energy, bool with_bound, bool seldom>
void add_fbar_forces(const Law &law, int history_size, int n, const int (*nodes)[8],
                     const double *x, const double *X, double *f, const HexKernel::Output &out)
{
  constexpr int W = simd::width;
  LostElements lost;
  Pack virial[6] = {}, dissipated_sum = {};

  for (int first = 0; first < n; first += W) {
    const LaneElements elements{nodes + first, n - first < W ? n - first : W};
    LaneHistory history{{}, elements.valid, 0, out.dt > 0.0, out.dissipation && out.dt > 0.0};
    if (history_size)
      for (int l = 0; l < W; ++l) history.lane[l] = out.history[first + elements.index(l)];

    Pack Y[3][8], y[3][8], u[3][8];
    gather_modes(elements, X, Y);
    gather_modes(elements, x, y);
    for (int i = 0; i < 3; ++i)
      for (int m = 1; m < 8; ++m) u[i][m] = y[i][m] - Y[i][m];

    // tf: derivative of the shear energy by the tangents; tv: that of 512 v
    Tangents tX, tu, tf, tv;
    modes_to_tangents(Y, tX);
    modes_to_tangents(u, tu);
    for (int k = 0; k < 3; ++k)
      for (int q = 0; q < 4; ++q)
        for (int i = 0; i < 3; ++i) tf[k][q][i] = tv[k][q][i] = Pack{};

    simd::Mask valid = ~simd::Mask{};
    Pack energy = Pack{}, dissipated = Pack{}, shear_bound = Pack{};
    Pack volume = Pack{}, volume_X = Pack{};
    Pack centre[Law::centre_size + 1] = {};
    for (int a = 0; a < 8; ++a) {
      Pack Xk[3][3], uk[3][3];
      for (int k = 0; k < 3; ++k)
        for (int i = 0; i < 3; ++i) {
          Xk[k][i] = tX[k][tangent_index(a, k)][i];
          uk[k][i] = tu[k][tangent_index(a, k)][i];
        }
      const FBarPoint point(Xk, uk);
      valid &= point.J > 0.0;
      volume += point.det_x;
      volume_X += point.det_X;

      Pack Q[3][3], w, d = Pack{};
      law.template at_gauss_point<with_energy>(point, history, centre, Q, w, d);
      history.offset += history_size / 8;

      const Pack dV = point.det_X * (1.0 / 512.0);
      if constexpr (with_energy) energy += dV * w;
      if (history.dissipation && history_size) dissipated += dV * d;
      Pack QF = Pack{};
      for (int i = 0; i < 3; ++i)
        for (int j = 0; j < 3; ++j) QF += Q[i][j] * point.F[i][j];
      const Pack back = (dV * QF) * ((1.0 / 3.0) / point.det_x);
      for (int k = 0; k < 3; ++k) {
        const int q = tangent_index(a, k);
        for (int i = 0; i < 3; ++i) {
          tf[k][q][i] += dV *
                  (Q[i][0] * point.dual[k][0] + Q[i][1] * point.dual[k][1] +
                   Q[i][2] * point.dual[k][2]) -
              back * point.normal[k][i];
          tv[k][q][i] += point.normal[k][i];
        }
      }
      if constexpr (with_bound)
        if (out.bound_at_gauss_points) {
          Pack s[6];
          lanes::deviatoric_kirchhoff(Q, point.F, s);
          const Pack here = symmetric_bound(s, out.bound_weights);
          shear_bound = a == 0 ? here : simd::max(here, shear_bound);
        }
    }

    // The centre of an element that is sound at the Gauss points is hardly ever lost, but the
    // criterion must not depend on which outputs are wanted.
    Pack Xk[3][3], uk[3][3];
    for (int k = 0; k < 3; ++k)
      for (int i = 0; i < 3; ++i) {
        Xk[k][i] = Y[i][1 << k];
        uk[k][i] = u[i][1 << k];
      }
    const FBarPoint middle(Xk, uk);
    valid &= middle.J > 0.0;

    const Pack poison = lost.poison(elements, first, valid);

    const Pack Jbar = volume / volume_X;
    const Pack p = law.bulk * (volume - volume_X) / volume_X;
    for (int k = 0; k < 3; ++k)
      for (int q = 0; q < 4; ++q)
        for (int i = 0; i < 3; ++i) tf[k][q][i] += (p * (1.0 / 512.0)) * tv[k][q][i];

    if constexpr (with_energy)
      store_lanes(elements, energy + (0.5 / 512.0) * p * (volume - volume_X) + poison,
                  out.energy + first);
    if (history.dissipation && history_size) {
      const Pack there = simd::generate([&](int l) {
        return l < elements.valid ? 1.0 : 0.0;
      });
      dissipated_sum += there * (dissipated + poison);
    }
    if constexpr (with_bound) {
      if (!out.bound_at_gauss_points) {
        Pack Q[3][3], s[6];
        law.at_centre(middle, centre, Q);
        lanes::deviatoric_kirchhoff(Q, middle.F, s);
        shear_bound = symmetric_bound(s, out.bound_weights);
      }
      store_lanes(elements, out.bound_weights.mean * p + shear_bound / Jbar + poison,
                  out.stress_bound + first);
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
  if (out.dissipation)
    for (int l = 0; l < W; ++l) *out.dissipation += dissipated_sum[l];
  if (out.inverted) *out.inverted = lost.first;
}

/// Checks the arguments and chooses the instance for the outputs that are wanted.
template <class Law>
void add_fbar_forces(const Law &law, int history_size, int n, const int (*nodes)[8],
                     const double *x, const double *X, double *f, const HexKernel::Output &out)
{
  if (history_size && n > 0) {
    if (!out.history)
      throw std::invalid_argument("a law with history needs Output::history, also for dt = 0");
    if (!(out.dt >= 0.0)) throw std::invalid_argument("Output::dt must not be negative or NaN");
  }
  choose_outputs(out, [&](auto energy, auto bound, auto seldom) {
    add_fbar_forces<Law, energy(), bound(), seldom()>(law, history_size, n, nodes, x, X, f, out);
  });
}

}    // namespace defe::fe

#endif
