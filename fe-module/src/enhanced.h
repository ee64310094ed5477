#ifndef DEFE_FE_ENHANCED_H
#define DEFE_FE_ENHANCED_H

// The enhanced strain of an 8-node hexahedron (ElementType::enhanced).
//
// Wilson's incompatible displacements alpha_k (1 - xi_k^2), k = 1, 2, 3, in the form of Taylor, Beresford and Wilson
// (1976): their gradient is formed with the Jacobian matrix of the centre and weighted by j_0/j, so that its mean
// over the element vanishes and the patch test holds in any shape,
//   E~(xi) = sum_k xi_k sym(a_k x g_k)/j(xi),  g_k = j_0 grad xi_k at the centre,  a_k = -2 alpha_k.
// As an additive part of Green's strain (Simo and Armero 1992, Klinkel and Wagner 1997) it depends on the reference shape
// alone, so that W = W_compatible + h.a + 1/2 a.K_aa a, with
//   h_k = (sum over Gauss points of xi_k S) g_k,  S = C : E of the compatible strain,
// is least for a = -K_aa^-1 h, without iterations, and W(x) = W_compatible - 1/2 h.K_aa^-1 h has the exact gradient
// that S + C : E~ in place of S gives.
//
// K_aa couples different k by w_kl = sum over Gauss points of xi_k xi_l/j, which vanishes in parallelepipeds. Elsewhere it
// is replaced by sum_l |w_kl| on the diagonal: that is not less than w, so W stays between its minimum and
// W_compatible (never negative, no spurious modes), the patch test does not care, and three 3 x 3 blocks are
// left, w_k [(lambda + mu) g_k g_k^T + mu |g_k|^2 I], whose inverse is explicit.

#include "defe/fe/elastic.h"
#include "defe/fe/topology.h"

namespace defe::fe {

/// Of one element; loops over many have their own, one element per lane (enhanced_kernel.cpp).
class EnhancedStrain {
 public:
  EnhancedStrain(const HexCoords &X, const IsotropicElastic &material);

  /// The stress of the compatible strain at a Gauss point: to be called for each of the eight.
  void add(const Vec3 &gauss_point, const Mat3 &stress);

  /// E~ at any point.
  Mat3 at(const Vec3 &xi) const;
  /// What E~ adds to the strain energy.
  double energy() const;

  /// g_k, and K_aa^-1 h of mode k.
  const Vec3 &direction(int k) const { return g[k]; }
  Vec3 solve(int k, const Vec3 &h) const;

 private:
  HexCoords X;
  double lambda, mu;
  Vec3 g[3];
  Vec3 w;         // of the diagonal blocks
  Mat3 sum[3];    // of xi_k S

  Vec3 amplitude(int k) const { return -solve(k, sum[k] * g[k]); }
};

}    // namespace defe::fe

#endif
