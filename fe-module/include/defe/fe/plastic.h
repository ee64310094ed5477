#ifndef DEFE_FE_PLASTIC_H
#define DEFE_FE_PLASTIC_H

#include "defe/fe/fbar_kernel.h"

namespace defe::fe {

/// Metal: J2 plasticity at finite strain. Any consistent units.
///
/// Multiplicative, with neo-Hookean springs as in Prony: one for the elastic strain b_e = Fbar A Fbar^T, and with
/// kinematic hardening one beside it, of what is stored in the back stress,
///   W = K/2 (J - 1)^2 + G_b/2 (tr Cbar - 3) + G_e/2 (tr(Cbar A) - 3),  det A = 1,  A = I at the start,
/// where A = C_p^-1 lives in the reference configuration: the law is exactly objective, and the forces are the
/// gradient of W while A is held. A spring beside a spring with a slider is Prager's linear kinematic hardening: with
/// G_b = G H_k/(3 G + H_k), G_e = G - G_b, r = G_e/G, and a slider that yields at r sigma_y(eps), its rate of
/// plastic strain eps'/r. H_k = 0: r = 1.
///
/// Yield: von Mises stress G_e sqrt(3/2) |dev b_e| = r sigma_y (Kirchhoff stresses: Cauchy's times J),
///   sigma_y = (yield + hardening eps^exponent) (1 + rate_factor ln max(eps'/rate_unit, 1)) (1 - (T/melting)^softening)
/// (Johnson and Cook 1983, 7th Int. Symp. Ballistics; T: rise of temperature, T' = heating sigma_y eps', adiabatic;
/// melting: rise at which the metal melts).
///
/// Flow: the Lie derivative of b_e is proportional to I 3/tr(b_e^-1) - b_e. This flow keeps det b_e and the principal
/// axes, dissipates for any b_e, and to first order of the elastic strain is the associated one; in uniaxial stress it
/// is that exactly. eps is what the dissipated work is conjugate to: eps' = dissipation/sigma_y.
///
/// A step is implicit (Simo 1992): b_e = alpha dev(b_trial) + t I with t by det b_e = 1, hence
/// A' = alpha A + (t - alpha t_trial) Cbar^-1, t_trial = tr(b_trial)/3, and no principal axes are needed. The plastic
/// strain of the step is the integral of the dissipation over the way back at held Fbar, (1 - alpha) times its
/// integrand at the middle: in uniaxial stress exact but for some 1/40 of the square of the step's plastic strain. The
/// temperature of sigma_y is that at the start of the step.
struct Plastic {
  double K = 0.0;      ///< bulk modulus
  double G = 0.0;      ///< shear modulus
  double rho = 0.0;    ///< mass density of the reference configuration

  double yield = 0.0;
  double hardening = 0.0;
  double exponent = 1.0;
  double kinematic = 0.0;    ///< slope H_k of the back stress over plastic strain, uniaxial

  double rate_factor = 0.0;    ///< 0: no influence of rate
  double rate_unit = 1.0;

  double softening = 0.0;    ///< exponent of temperature, 0: no influence of temperature
  double melting = 1.0;
  double heating = 0.0;    ///< Taylor-Quinney coefficient by density and specific heat

  /// sigma_y = yield + hardening eps
  bool linear() const { return exponent == 1.0 && rate_factor == 0.0 && softening == 0.0; }

  /// Empty if the constants are usable, else one line that says what is wrong with which value.
  std::string validate() const;
};

/// Hexahedra of any shape with this law.
/// History of each Gauss point, symmetric tensors as xx yy zz xy xz yz in axes of the reference configuration:
/// Cbar - I of the last step, A - I, eps; unless linear() also the rate of eps in the last step, and the rise of
/// temperature.
/// Throws std::invalid_argument if the material is not valid.
class PlasticKernel : public FBarKernel {
 public:
  static constexpr bool yields = true;
  explicit PlasticKernel(const Plastic &material);
  void add_forces(int n, const int (*nodes)[8], const double *x, const double *X, double *f,
                  const Output &out) const override;
  int point_history_size() const override;
  PlasticState plastic_state(const double *history) const override;

 protected:
  double shear_energy(const Mat3 &F, const double *history) const override;
  Mat3 shear_stress(const Mat3 &F, const double *history) const override;

 private:
  Plastic law;
};

}    // namespace defe::fe

#endif
