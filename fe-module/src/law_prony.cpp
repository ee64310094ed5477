#include "defe/fe/material_law.h"
#include "defe/fe/prony.h"
#include "defe/fe/stable_step.h"

namespace defe::fe {

namespace {

  class Viscoelastic : public MaterialLaw {
   public:
    explicit Viscoelastic(const Prony &m) :
        m(m), initial(elastic_from_bulk_shear(m.K, m.G_0(), m.rho))
    {
    }
    const IsotropicElastic &elastic() const override { return initial; }
    std::unique_ptr<HexKernel> make_kernel() const override
    {
      return std::make_unique<PronyKernel>(m);
    }
    double critical_step(const HexCoords &X) const override
    {
      return critical_step_fbar(X, initial);
    }

   private:
    Prony m;
    IsotropicElastic initial;
  };

  std::unique_ptr<MaterialLaw> make(LawWords &words, std::string &complaint)
  {
    Prony m;
    m.K = words.number("bulk modulus K");
    m.rho = words.number("density rho");
    m.G_inf = words.number("long-term shear modulus G_inf");
    const int n = words.count("number of Prony terms N", 0, Prony::max_terms);
    for (int i = 1; i <= n && words.complaint().empty(); ++i) {
      const std::string number = std::to_string(i);
      const double G = words.number(("shear modulus G_" + number).c_str());
      m.terms.push_back({G, words.number(("decay rate beta_" + number).c_str())});
    }
    complaint = m.validate();
    if (!complaint.empty()) return nullptr;
    return std::make_unique<Viscoelastic>(m);
  }

}    // namespace

extern const MaterialLawEntry prony_law;
const MaterialLawEntry prony_law = {"prony", "prony K rho G_inf N G_1 beta_1 ... G_N beta_N", make};

}    // namespace defe::fe
