#include "fbar_law.h"

#include "defe/fe/plastic.h"

namespace defe::fe {

namespace {

  using Law = FBarLaw<Plastic, PlasticKernel>;

  /// E nu rho. Sets `complaint` if they are out of range.
  Plastic elastic_part(LawWords &words, std::string &complaint)
  {
    IsotropicElastic e;
    e.E = words.number("Young's modulus E");
    e.nu = words.number("Poisson's ratio nu");
    e.rho = words.number("density rho");
    complaint = e.validate();
    Plastic m;
    m.K = e.bulk();
    m.G = e.mu();
    m.rho = e.rho;
    return m;
  }

  std::unique_ptr<MaterialLaw> make_plastic(LawWords &words, std::string &complaint)
  {
    Plastic m = elastic_part(words, complaint);
    m.yield = words.number("yield stress sigma_y");
    m.hardening = words.number("hardening modulus H");
    if (words.optional({"kinematic"}) == 0)
      m.kinematic = words.number("kinematic hardening modulus H_k");
    return complaint.empty() ? Law::make(m, m.G, complaint) : nullptr;
  }

  std::unique_ptr<MaterialLaw> make_johnson_cook(LawWords &words, std::string &complaint)
  {
    Plastic m = elastic_part(words, complaint);
    m.yield = words.number("yield stress A");
    m.hardening = words.number("hardening stress B");
    m.exponent = words.number("hardening exponent n");
    m.rate_factor = words.number("rate factor C");
    m.rate_unit = words.number("reference rate");
    if (complaint.empty() && words.optional({"thermal"}) == 0) {
      m.softening = words.number("thermal exponent m");
      const double start = words.number("starting temperature T_0");
      m.melting = words.number("melting temperature T_melt") - start;
      const double heat = words.number("specific heat c_p"),
                   fraction = words.number("heated fraction chi");
      if (!(m.softening > 0.0))
        complaint = "thermal exponent m must be positive: leave out thermal for a metal that does "
                    "not soften";
      else if (!(m.melting > 0.0))
        complaint = "melting temperature T_melt must be above the starting temperature T_0";
      else if (!(heat > 0.0))
        complaint = "specific heat c_p must be positive";
      else if (!(fraction >= 0.0 && fraction <= 1.0))
        complaint = "heated fraction chi of the plastic work must lie between 0 and 1";
      m.heating = fraction / (m.rho * heat);
    }
    return complaint.empty() ? Law::make(m, m.G, complaint) : nullptr;
  }

}    // namespace

extern const MaterialLawEntry plastic_law;
const MaterialLawEntry plastic_law = {"plastic", "plastic E nu rho sigma_y H [kinematic H_k]",
                                      make_plastic};

extern const MaterialLawEntry johnson_cook_law;
const MaterialLawEntry johnson_cook_law = {
    "johnson-cook", "johnson-cook E nu rho A B n C rate [thermal m T_0 T_melt c_p chi]",
    make_johnson_cook};

}    // namespace defe::fe
