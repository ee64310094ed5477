#ifndef DEFE_FE_MOONEY_RIVLIN_H
#define DEFE_FE_MOONEY_RIVLIN_H

#include "defe/fe/fbar_kernel.h"

namespace defe::fe {

/// Rubber-like solid, W = C10 (I1bar - 3) + C01 (I2bar - 3) + K/2 (J - 1)^2 per reference volume,
/// with the invariants I1bar = tr Cbar, I2bar = (I1bar^2 - tr Cbar^2)/2 of Cbar = J^(-2/3) F^T F
/// (Mooney 1940, Rivlin 1948; C01 = 0 is neo-Hooke). Any consistent units.
struct MooneyRivlin {
  double C10 = 0.0;    ///< pressure
  double C01 = 0.0;    ///< pressure
  double K = 0.0;      ///< bulk modulus
  double rho = 0.0;    ///< mass density of the reference configuration

  double mu() const { return 2.0 * (C10 + C01); }    ///< shear modulus at small strain

  /// Empty if the constants are usable, else one line that says what is wrong with which value.
  /// C10 and C01 must not be negative (W is polyconvex then, and stable at any strain).
  std::string validate() const;
};

/// Hexahedra of any shape with this law; no history.
/// Throws std::invalid_argument if the material is not valid.
class MooneyRivlinKernel : public FBarKernel {
 public:
  explicit MooneyRivlinKernel(const MooneyRivlin &material);
  void add_forces(int n, const int (*nodes)[8], const double *x, const double *X, double *f,
                  const Output &out) const override;

 protected:
  double shear_energy(const Mat3 &F, const double *history) const override;
  Mat3 shear_stress(const Mat3 &F, const double *history) const override;

 private:
  MooneyRivlin law;
};

}    // namespace defe::fe

#endif
