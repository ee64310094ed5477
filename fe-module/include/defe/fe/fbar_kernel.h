#ifndef DEFE_FE_FBAR_KERNEL_H
#define DEFE_FE_FBAR_KERNEL_H

#include "defe/fe/kernel.h"

#include <string>

namespace defe::fe {

/// Nearly incompressible hexahedra at finite strain: total Lagrangian, 2 x 2 x 2 Gauss points, with
/// the F-bar that does not lock,
///   Fbar = (Jbar/J)^(1/3) F,  J = det F,  Jbar = v/V (volume of the element by reference volume),
///   W = V K/2 (Jbar - 1)^2 + sum over Gauss points of dV w(Cbar),  Cbar = J^(-2/3) F^T F:
/// det Fbar = Jbar is the same at all points, and the isochoric part of Fbar is that of F. Forces
/// are the exact gradient of W, stress() is the Cauchy stress that belongs to Fbar.
///
/// This is the mean dilatation of Nagtegaal, Parks and Rice (1974) and Simo, Taylor and Pister
/// (1985), which to first order in the element's distortion is the F-bar of de Souza Neto et al.
/// (1996). Theirs takes J at the centre for Jbar, and the forces B^T sigma(Fbar), which are not the
/// gradient of any W: an explicit run would gain or lose energy. The gradient with J at the centre
/// would not pass the patch test in distorted elements (the gradient of the shape functions at the
/// centre is not their mean); with v/V it does.
///
/// A strip of n layers of cubes is too soft in plane-strain bending by 5/12/n^2 (nu = 1/2); the plain
/// element is too stiff by lambda/(4 G)/n^2, 1250 times for one layer with nu = 0.4999.
///
/// W is bounded for Jbar -> 0: like every other hexahedron these can be turned inside out, and then
/// they are reported as lost.
class FBarKernel : public HexKernel {
 public:
  static constexpr bool yields = false;    ///< MaterialLaw::yields()
  bool uses_reference() const override { return true; }
  double energy(const HexCoords &x, const HexCoords &X,
                const double *history = nullptr) const override;
  /// Between the Gauss points the history is interpolated (and extrapolated) trilinearly.
  Mat3 stress(const HexCoords &x, const HexCoords &X, const Vec3 &xi,
              const double *history = nullptr) const override;
  const IsotropicElastic &material() const override { return initial; }

  /// Gauss point p keeps its history at 8-node order p (gauss_points()), point_history_size()
  /// doubles each.
  int history_size() const override { return 8 * point_history_size(); }
  virtual int point_history_size() const { return 0; }

 protected:
  /// initial: the linear elastic solid for small and fast deformation. Throws
  /// std::invalid_argument with the complaint unless that is empty.
  FBarKernel(const std::string &complaint, double bulk, const IsotropicElastic &initial);

  /// w per reference volume, for a deformation gradient with det F > 0; history null = virgin.
  virtual double shear_energy(const Mat3 &F, const double *history) const = 0;
  /// Its deviatoric Kirchhoff stress, (dw/dF) F^T.
  virtual Mat3 shear_stress(const Mat3 &F, const double *history) const = 0;

  /// Enough for any point_history_size().
  static constexpr int max_point_history = 256;

  double bulk;    ///< K

 private:
  IsotropicElastic initial;
};

/// The linear elastic solid with this bulk and shear modulus.
IsotropicElastic elastic_from_bulk_shear(double bulk, double shear, double rho);

}    // namespace defe::fe

#endif
