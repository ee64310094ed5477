#include "defe/fe/material_law.h"

#include <cmath>
#include <limits>
#include <sstream>

namespace defe::fe {

namespace {

  class Rigid : public MaterialLaw {
   public:
    explicit Rigid(double rho) { m.rho = rho; }
    const IsotropicElastic &elastic() const override { return m; }
    bool rigid() const override { return true; }
    std::unique_ptr<HexKernel> make_kernel() const override { return nullptr; }
    double critical_step(const HexCoords &) const override
    {
      return std::numeric_limits<double>::infinity();
    }

   private:
    IsotropicElastic m;
  };

  std::unique_ptr<MaterialLaw> make(LawWords &words, std::string &complaint)
  {
    const double rho = words.number("density rho");
    if (rho > 0.0) return std::make_unique<Rigid>(rho);
    std::ostringstream text;
    text << "density must be positive, not " << rho;
    complaint = text.str();
    return nullptr;
  }

}    // namespace

extern const MaterialLawEntry rigid_law;
const MaterialLawEntry rigid_law = {"rigid", "rigid rho", make};

}    // namespace defe::fe
