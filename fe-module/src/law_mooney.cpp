#include "defe/fe/material_law.h"
#include "defe/fe/mooney_rivlin.h"
#include "defe/fe/stable_step.h"

namespace defe::fe {

namespace {

  class Mooney : public MaterialLaw {
   public:
    explicit Mooney(const MooneyRivlin &m) :
        m(m), initial(elastic_from_bulk_shear(m.K, m.mu(), m.rho))
    {
    }
    const IsotropicElastic &elastic() const override { return initial; }
    std::unique_ptr<HexKernel> make_kernel() const override
    {
      return std::make_unique<MooneyRivlinKernel>(m);
    }
    double critical_step(const HexCoords &X) const override
    {
      return critical_step_fbar(X, initial);
    }

   private:
    MooneyRivlin m;
    IsotropicElastic initial;
  };

  std::unique_ptr<MaterialLaw> make(LawWords &words, std::string &complaint)
  {
    MooneyRivlin m;
    m.C10 = words.number("Mooney-Rivlin constant C10");
    m.C01 = words.number("Mooney-Rivlin constant C01");
    m.K = words.number("bulk modulus K");
    m.rho = words.number("density rho");
    complaint = m.validate();
    if (!complaint.empty()) return nullptr;
    return std::make_unique<Mooney>(m);
  }

}    // namespace

extern const MaterialLawEntry mooney_law;
const MaterialLawEntry mooney_law = {"mooney", "mooney C10 C01 K rho", make};

}    // namespace defe::fe
