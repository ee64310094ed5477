#include "criterion_words.h"

#include "defe/coupling/criterion.h"

namespace defe {

namespace {

  /// sqrt(3 J2) > sigma_c: equivalent stress of von Mises (Nachr. Ges. Wiss. Goettingen (1913) 582). The same in tension,
  /// compression and, by 1/sqrt(3), shear; blind to pressure.
  class Mises : public ConversionCriterion {
   public:
    explicit Mises(double stress) : stress(stress) {}
    double value(const Mat3 &s, Vec3 &direction) const override
    {
      fe::max_principal(s, direction);
      return fe::stress_bound(s, bound());    // the bound is the value
    }
    double limit() const override { return stress; }
    fe::StressBound bound() const override { return {0.0, 3.0}; }
    double tensile_stress() const override { return stress; }
    std::vector<double> numbers() const override { return {stress}; }

   private:
    double stress;
  };

  std::unique_ptr<ConversionCriterion> make(fe::LawWords &words, const fe::IsotropicElastic &,
                                            std::string &complaint)
  {
    return std::make_unique<Mises>(positive(words, "equivalent stress", complaint));
  }

}    // namespace

extern const CriterionEntry mises_criterion;
const CriterionEntry mises_criterion = {"mises", "mises stress", make};

}    // namespace defe
