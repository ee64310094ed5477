#include "strength_words.h"

#include "defe/coupling/strength_field.h"

#include <cmath>

namespace defe {

namespace {

  /// H = (sigma/scale)^shape - (sigma_0/scale)^shape above sigma_0, 0 below: what is left of a two-parameter Weibull
  /// distribution of those pieces that a proof test with sigma_0 does not break. Left-truncated Weibull of float glass:
  /// Ballarini, Pisano, Royer-Carfagni, J. Eng. Mech. 142 (2016) 04016100.
  class Truncated : public StrengthLaw {
   public:
    Truncated(double shape, double scale, double least) :
        shape(shape), scale(scale), least(least), passed(std::pow(least / scale, shape))
    {
    }
    double stress(double hazard) const override
    {
      return scale * std::pow(hazard + passed, 1.0 / shape);
    }
    std::vector<double> numbers() const override { return {shape, scale, least}; }

   private:
    double shape, scale, least, passed;
  };

  std::unique_ptr<StrengthLaw> make(fe::LawWords &words, std::string &complaint)
  {
    const double shape = shape_of(words, complaint);
    const double scale = positive(words, "scale", complaint);
    const double least = positive(words, "truncation", complaint);
    if (!std::isfinite(std::pow(least / scale, shape)))
      complaint = "the truncation is too far above the scale: nothing is left of the distribution";
    return std::make_unique<Truncated>(shape, scale, least);
  }

}    // namespace

extern const StrengthLawEntry truncated_strength;
const StrengthLawEntry truncated_strength = {"truncated", "truncated shape scale sigma_0", make};

}    // namespace defe
