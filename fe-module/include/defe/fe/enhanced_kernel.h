#ifndef DEFE_FE_ENHANCED_KERNEL_H
#define DEFE_FE_ENHANCED_KERNEL_H

#include "defe/fe/kernel.h"

namespace defe::fe {

/// Enhanced hexahedra (ElementType) of any valid shape, each with its own: total Lagrangian St Venant-Kirchhoff as
/// LagrangianKernel, with Green's strain enhanced. stress() is F S F^T / det F with the enhanced S and the F of the
/// nodes. Equal to an enhanced BrickKernel for boxes but for the second order in strain.
/// In compression of tens of per cent enhanced elements are known to lose their stiffness against hourglassing
/// (Wriggers and Reese 1996): a material for such strains had better be plain.
/// Throws std::invalid_argument if the material is not valid.
class EnhancedKernel : public HexKernel {
 public:
  explicit EnhancedKernel(const IsotropicElastic &material);
  void add_forces(int n, const int (*nodes)[8], const double *x, const double *X, double *f,
                  const Output &out) const override;
  bool uses_reference() const override { return true; }
  double energy(const HexCoords &x, const HexCoords &X,
                const double *history = nullptr) const override;
  Mat3 stress(const HexCoords &x, const HexCoords &X, const Vec3 &xi,
              const double *history = nullptr) const override;
  const IsotropicElastic &material() const override { return elastic; }

 private:
  IsotropicElastic elastic;
};

}    // namespace defe::fe

#endif
