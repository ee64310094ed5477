#include "criterion_words.h"

#include "defe/coupling/criterion.h"

namespace defe {

namespace {

  /// sigma_1 > sigma_c: Rankine's criterion, in tension.
  class Principal : public ConversionCriterion {
   public:
    explicit Principal(double stress) : stress(stress) {}
    double value(const Mat3 &s, Vec3 &direction) const override
    {
      return fe::max_principal(s, direction);
    }
    double limit() const override { return stress; }
    fe::StressBound bound() const override { return {1.0, 2.0}; }
    double tensile_stress() const override { return stress; }
    std::vector<double> numbers() const override { return {stress}; }

   private:
    double stress;
  };

  std::unique_ptr<ConversionCriterion> make(fe::LawWords &words, const fe::IsotropicElastic &,
                                            std::string &complaint)
  {
    return std::make_unique<Principal>(positive(words, "conversion stress", complaint));
  }

}    // namespace

extern const CriterionEntry principal_criterion;
const CriterionEntry principal_criterion = {"principal", "principal stress", make};

}    // namespace defe
