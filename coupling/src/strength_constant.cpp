#include "criterion_words.h"

#include "defe/coupling/strength_field.h"

namespace defe {

namespace {

  /// One strength: of the inside, where flaws of the surface decide.
  class Constant : public StrengthLaw {
   public:
    explicit Constant(double strength) : strength(strength) {}
    double stress(double) const override { return strength; }
    std::vector<double> numbers() const override { return {strength}; }
    bool random() const override { return false; }

   private:
    double strength;
  };

  std::unique_ptr<StrengthLaw> make(fe::LawWords &words, std::string &complaint)
  {
    return std::make_unique<Constant>(positive(words, "strength", complaint));
  }

}    // namespace

extern const StrengthLawEntry constant_strength;
const StrengthLawEntry constant_strength = {"constant", "constant strength", make};

}    // namespace defe
