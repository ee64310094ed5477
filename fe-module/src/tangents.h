#ifndef DEFE_FE_TANGENTS_H
#define DEFE_FE_TANGENTS_H

// Tangent vectors dx/dxi_k at the Gauss points, one element per lane, for total Lagrangian kernels.
// dx/dxi_1 does not depend on xi_1 (and so on): there are 3 x 4 different tangent vectors at the
// eight Gauss points, and they come from the modes (hex_modes.h) in two butterflies.

#include "hex_modes.h"

namespace defe::fe {

inline constexpr double gauss = 0.57735026918962576451;    // 1/sqrt(3)

/// Tangents at the Gauss points times 8: t[k][q][i] = component i of 8 dv/dxi_k, where bit 0 of q
/// is the sign of xi_(k+1) and bit 1 that of xi_(k+2) (cyclic).
using Tangents = Pack[3][4][3];

DEFE_INLINE int tangent_index(int point, int k)
{
  return (hex_sign[point][(k + 1) % 3] > 0 ? 1 : 0) + (hex_sign[point][(k + 2) % 3] > 0 ? 2 : 0);
}

DEFE_INLINE void modes_to_tangents(const Pack v[3][8], Tangents t)
{
  for (int k = 0; k < 3; ++k) {
    const int m = 1 << k, ma = 1 << (k + 1) % 3, mb = 1 << (k + 2) % 3;
    for (int i = 0; i < 3; ++i) {
      const Pack a0 = v[i][m] - gauss * v[i][m | ma];
      const Pack a1 = v[i][m] + gauss * v[i][m | ma];
      const Pack b0 = v[i][m | mb] - gauss * v[i][7];
      const Pack b1 = v[i][m | mb] + gauss * v[i][7];
      t[k][0][i] = a0 - gauss * b0;
      t[k][1][i] = a1 - gauss * b1;
      t[k][2][i] = a0 + gauss * b0;
      t[k][3][i] = a1 + gauss * b1;
    }
  }
}

/// The transpose: g[i][m] = - sum over points of t_k dphi_m/dxi_k.
DEFE_INLINE void tangents_to_forces(const Tangents t, Pack g[3][8])
{
  for (int i = 0; i < 3; ++i) {
    g[i][0] = g[i][3] = g[i][5] = g[i][6] = g[i][7] = Pack{};
    for (int k = 0; k < 3; ++k) {
      const int m = 1 << k, ma = 1 << (k + 1) % 3, mb = 1 << (k + 2) % 3;
      const Pack a0 = t[k][0][i] + t[k][2][i], a1 = t[k][1][i] + t[k][3][i];
      const Pack b0 = t[k][2][i] - t[k][0][i], b1 = t[k][3][i] - t[k][1][i];
      g[i][m] = -(a0 + a1);
      g[i][m | ma] -= gauss * (a1 - a0);
      g[i][m | mb] -= gauss * (b0 + b1);
      g[i][7] -= (gauss * gauss) * (b1 - b0);
    }
  }
}

DEFE_INLINE void cross(const Pack a[3], const Pack b[3], Pack c[3])
{
  c[0] = a[1] * b[2] - a[2] * b[1];
  c[1] = a[2] * b[0] - a[0] * b[2];
  c[2] = a[0] * b[1] - a[1] * b[0];
}

DEFE_INLINE Pack dot(const Pack a[3], const Pack b[3])
{
  return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}

}    // namespace defe::fe

#endif
