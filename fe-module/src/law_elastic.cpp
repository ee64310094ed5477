#include "defe/fe/material_law.h"
#include "defe/fe/stable_step.h"

namespace defe::fe {

namespace {

  class Elastic : public MaterialLaw {
   public:
    explicit Elastic(const IsotropicElastic &m) : m(m) {}
    const IsotropicElastic &elastic() const override { return m; }
    bool linear() const override { return true; }
    std::unique_ptr<HexKernel> make_kernel() const override
    {
      return std::make_unique<LagrangianKernel>(m);
    }
    bool has_shape_kernel(const HexCoords &X) const override { return is_box(X); }
    std::unique_ptr<HexKernel> make_shape_kernel(const HexCoords &X) const override
    {
      return std::make_unique<BrickKernel>(X, m);
    }
    double critical_step(const HexCoords &X) const override { return fe::critical_step(X, m); }

   private:
    IsotropicElastic m;
  };

  std::unique_ptr<MaterialLaw> make(LawWords &words, std::string &complaint)
  {
    IsotropicElastic m;
    m.E = words.number("Young's modulus E");
    m.nu = words.number("Poisson's ratio nu");
    m.rho = words.number("density rho");
    complaint = m.validate();
    if (!complaint.empty()) return nullptr;
    return std::make_unique<Elastic>(m);
  }

}    // namespace

extern const MaterialLawEntry elastic_law;
const MaterialLawEntry elastic_law = {"elastic", "elastic E nu rho", make};

}    // namespace defe::fe
