#include "fbar_law.h"

#include "defe/fe/mooney_rivlin.h"

namespace defe::fe {

namespace {

  std::unique_ptr<MaterialLaw> make(LawWords &words, std::string &complaint)
  {
    MooneyRivlin m;
    m.C10 = words.number("Mooney-Rivlin constant C10");
    m.C01 = words.number("Mooney-Rivlin constant C01");
    m.K = words.number("bulk modulus K");
    m.rho = words.number("density rho");
    return FBarLaw<MooneyRivlin, MooneyRivlinKernel>::make(m, m.mu(), complaint);
  }

}    // namespace

extern const MaterialLawEntry mooney_law;
const MaterialLawEntry mooney_law = {"mooney", "mooney C10 C01 K rho", make};

}    // namespace defe::fe
