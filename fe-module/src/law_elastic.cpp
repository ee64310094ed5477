#include "defe/fe/enhanced_kernel.h"
#include "defe/fe/material_law.h"
#include "defe/fe/stable_step.h"

namespace defe::fe {

namespace {

  class Elastic : public MaterialLaw {
   public:
    Elastic(const IsotropicElastic &m, ElementType type) : m(m), type(type) {}
    const IsotropicElastic &elastic() const override { return m; }
    bool linear() const override { return true; }
    const char *elements() const override
    {
      return type == ElementType::enhanced ? "enhanced" : "plain";
    }
    std::unique_ptr<HexKernel> make_kernel() const override
    {
      if (type == ElementType::enhanced) return std::make_unique<EnhancedKernel>(m);
      return std::make_unique<LagrangianKernel>(m);
    }
    bool has_shape_kernel(const HexCoords &X) const override { return is_box(X); }
    std::unique_ptr<HexKernel> make_shape_kernel(const HexCoords &X) const override
    {
      return std::make_unique<BrickKernel>(X, m, type);
    }
    double critical_step(const HexCoords &X) const override
    {
      return fe::critical_step(X, m, type);
    }

   private:
    IsotropicElastic m;
    ElementType type;
  };

  std::unique_ptr<MaterialLaw> make(LawWords &words, std::string &complaint)
  {
    IsotropicElastic m;
    m.E = words.number("Young's modulus E");
    m.nu = words.number("Poisson's ratio nu");
    m.rho = words.number("density rho");
    const bool plain = words.optional({"enhanced", "plain"}) == 1;
    complaint = m.validate();
    if (!complaint.empty()) return nullptr;
    return std::make_unique<Elastic>(m, plain ? ElementType::plain : ElementType::enhanced);
  }

}    // namespace

extern const MaterialLawEntry elastic_law;
const MaterialLawEntry elastic_law = {"elastic", "elastic E nu rho [enhanced|plain]", make};

}    // namespace defe::fe
