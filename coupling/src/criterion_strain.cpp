#include "criterion_words.h"

#include "defe/coupling/criterion.h"

namespace defe {

namespace {

  /// Largest principal strain, that of the Cauchy stress by Hooke's law:
  ///
  ///     e_1 = ((1 + nu) sigma_1 - 3 nu p)/E > e_c
  ///
  /// de Saint-Venant's criterion (Timoshenko, History of Strength of Materials, 1953, section 80). Lateral
  /// compression alone reaches it: plates and columns split along the load.
  class PrincipalStrain : public ConversionCriterion {
   public:
    PrincipalStrain(double strain, const fe::IsotropicElastic &m) :
        strain(strain), E(m.E), of_stress((1.0 + m.nu) / m.E), of_mean(3.0 * m.nu / m.E)
    {
    }
    double value(const Mat3 &s, Vec3 &direction) const override
    {
      return of_stress * fe::max_principal(s, direction) - of_mean * (s.trace() / 3.0);
    }
    double limit() const override { return strain; }
    fe::StressBound bound() const override { return {of_stress - of_mean, 2.0 * of_stress}; }
    double tensile_stress() const override { return E * strain; }
    std::vector<double> numbers() const override { return {strain}; }

   private:
    double strain, E, of_stress, of_mean;
  };

  std::unique_ptr<ConversionCriterion> make(fe::LawWords &words, const fe::IsotropicElastic &m,
                                            std::string &complaint)
  {
    return std::make_unique<PrincipalStrain>(positive(words, "conversion strain", complaint), m);
  }

}    // namespace

extern const CriterionEntry strain_criterion;
const CriterionEntry strain_criterion = {"strain", "strain value", make};

}    // namespace defe
