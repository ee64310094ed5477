#ifndef DEFE_FE_PRONY_H
#define DEFE_FE_PRONY_H

#include "defe/fe/fbar_kernel.h"

#include <vector>

namespace defe::fe {

/// Viscoelastic solid: shear relaxes by a Prony series, volume is elastic. Any consistent units.
/// Relaxation modulus at small strain G(t) = G_inf + sum_i G_i exp(-beta_i t).
///
/// Finite strain: neo-Hookean springs, one of G_inf and one of each G_i in series with a dashpot,
///   W = K/2 (J - 1)^2 + G_inf/2 (tr Cbar - 3) + sum_i G_i/2 (tr(Cbar A_i) - 3 - ln det A_i),
///   dA_i/dt = beta_i (Cbar^-1 - A_i),  A_i = I at the start,  Cbar = J^(-2/3) F^T F
/// (the linear evolution law of Lubliner 1985, Mech. Res. Comm. 12, 93; with this W: the network of
/// Green and Tobolsky 1946, and Linder, Tkachuk and Miehe 2011, J. Mech. Phys. Solids 59, 2134).
/// What follows from it:
/// - deviatoric Kirchhoff stress dev(Fbar T Fbar^T) with T = G_inf I + sum_i G_i A_i, Fbar^T Fbar =
///   Cbar;
/// - at once the response is neo-Hookean with G_0 = G_inf + sum_i G_i, after long with G_inf; a
///   strain that is held relaxes by exactly G(t), however large it is;
/// - A_i is a weighted mean of I and of past Cbar^-1: positive definite, so the law is stable at
///   any strain; it lives in the reference configuration, so the law is exactly objective;
/// - dissipation per time sum_i G_i beta_i/2 (tr M_i + tr M_i^-1 - 6) >= 0, M_i = Cbar A_i.
/// Simo's (1987) convolution of the isochoric second Piola-Kirchhoff stress agrees at small strain,
/// but has no stored energy, and thus no energy balance, unless that stress is linear in strain.
///
/// Step of length dt: the exact convolution with a Cbar^-1 that changes linearly within the step
/// (Taylor, Pister and Goudreau 1970, for small strain). With h = beta dt, w = (1 - exp(-h))/h and
/// D = Cbar^-1 - I, primes at the end of the step,
///   A' = A + (1 - w) (I + D' - A) + (w - exp(-h)) (I + D - A).
/// Exact for a strain that is held, of second order in dt otherwise, stable for any dt. (The
/// mid-point form of Simo and Hughes 1998, ch. 10, has exp(-h/2) for w; it loses the viscous stress
/// of terms that decay within a step.)
struct Prony {
  struct Term {
    double G;       ///< shear modulus
    double beta;    ///< decay rate 1/tau
  };
  static constexpr int max_terms = 32;

  double K = 0.0;        ///< bulk modulus
  double rho = 0.0;      ///< mass density of the reference configuration
  double G_inf = 0.0;    ///< shear modulus after long
  std::vector<Term> terms;

  double G_0() const;    ///< shear modulus at once, G_inf + sum of G

  /// Empty if the constants are usable, else one line that says what is wrong with which value.
  std::string validate() const;
};

/// Hexahedra of any shape with this law.
/// History of each Gauss point: 6 (1 + number of terms) doubles, D of the last step and then A_i - I
/// of each term, as xx yy zz xy xz yz in axes of the reference configuration.
/// Throws std::invalid_argument if the material is not valid.
class PronyKernel : public FBarKernel {
 public:
  explicit PronyKernel(const Prony &material);
  void add_forces(int n, const int (*nodes)[8], const double *x, const double *X, double *f,
                  const Output &out) const override;
  int point_history_size() const override;

 protected:
  double shear_energy(const Mat3 &F, const double *history) const override;
  Mat3 shear_stress(const Mat3 &F, const double *history) const override;

 private:
  Prony law;
};

}    // namespace defe::fe

#endif
