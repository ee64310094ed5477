#include "strength_words.h"

#include "defe/coupling/strength_field.h"

#include <cmath>

namespace defe {

namespace {

  /// H = ((sigma - sigma_u)/scale)^shape above sigma_u, 0 below: Weibull, J. Appl. Mech. 18 (1951) 293, with three
  /// parameters. Nothing breaks below sigma_u.
  class Threshold : public StrengthLaw {
   public:
    Threshold(double shape, double scale, double least) : shape(shape), scale(scale), least(least)
    {
    }
    double stress(double hazard) const override
    {
      return least + scale * std::pow(hazard, 1.0 / shape);
    }
    std::vector<double> numbers() const override { return {shape, scale, least}; }

   private:
    double shape, scale, least;
  };

  std::unique_ptr<StrengthLaw> make(fe::LawWords &words, std::string &complaint)
  {
    const double shape = shape_of(words, complaint);
    const double scale = positive(words, "scale", complaint);
    const double least = positive(words, "threshold", complaint);
    return std::make_unique<Threshold>(shape, scale, least);
  }

}    // namespace

extern const StrengthLawEntry threshold_strength;
const StrengthLawEntry threshold_strength = {"threshold", "threshold shape scale sigma_u", make};

}    // namespace defe
