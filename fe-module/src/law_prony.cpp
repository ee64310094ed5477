#include "fbar_law.h"

#include "defe/fe/prony.h"

namespace defe::fe {

namespace {

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
    return FBarLaw<Prony, PronyKernel>::make(m, m.G_0(), complaint);
  }

}    // namespace

extern const MaterialLawEntry prony_law;
const MaterialLawEntry prony_law = {"prony", "prony K rho G_inf N G_1 beta_1 ... G_N beta_N", make};

}    // namespace defe::fe
