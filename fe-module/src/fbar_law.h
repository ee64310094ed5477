#ifndef DEFE_FE_SRC_FBAR_LAW_H
#define DEFE_FE_SRC_FBAR_LAW_H

// A material law whose kernel is an FBarKernel: what all of them have in common.

#include "defe/fe/fbar_kernel.h"
#include "defe/fe/material_law.h"
#include "defe/fe/stable_step.h"

namespace defe::fe {

/// \tparam Constants  with bulk modulus K, density rho and validate()
template <class Constants, class Kernel> class FBarLaw : public MaterialLaw {
 public:
  /// Null, and a complaint, if the constants are out of range.
  static std::unique_ptr<MaterialLaw> make(const Constants &m, double initial_shear,
                                           std::string &complaint)
  {
    complaint = m.validate();
    if (!complaint.empty()) return nullptr;
    return std::unique_ptr<MaterialLaw>(new FBarLaw(m, initial_shear));
  }
  const IsotropicElastic &elastic() const override { return initial; }
  bool yields() const override { return Kernel::yields; }
  std::unique_ptr<HexKernel> make_kernel() const override { return std::make_unique<Kernel>(m); }
  double critical_step(const HexCoords &X) const override { return critical_step_fbar(X, initial); }

 private:
  FBarLaw(const Constants &m, double shear) :
      m(m), initial(elastic_from_bulk_shear(m.K, shear, m.rho))
  {
  }
  Constants m;
  IsotropicElastic initial;
};

}    // namespace defe::fe

#endif
