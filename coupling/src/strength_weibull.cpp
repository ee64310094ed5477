#include "strength_words.h"

#include "defe/coupling/strength_field.h"

#include <cmath>

namespace defe {

namespace {

  /// H = (sigma/scale)^shape: Weibull, J. Appl. Mech. 18 (1951) 293, with two parameters.
  class Weibull : public StrengthLaw {
   public:
    Weibull(double shape, double scale) : shape(shape), scale(scale) {}
    double stress(double hazard) const override { return scale * std::pow(hazard, 1.0 / shape); }
    std::vector<double> numbers() const override { return {shape, scale}; }

   private:
    double shape, scale;
  };

  std::unique_ptr<StrengthLaw> make(fe::LawWords &words, std::string &complaint)
  {
    const double shape = shape_of(words, complaint);
    const double scale = positive(words, "scale", complaint);
    return std::make_unique<Weibull>(shape, scale);
  }

}    // namespace

extern const StrengthLawEntry weibull_strength;
const StrengthLawEntry weibull_strength = {"weibull", "weibull shape scale", make};

}    // namespace defe
