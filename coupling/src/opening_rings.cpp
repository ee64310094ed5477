#include "defe/coupling/opening_law.h"

#include <cmath>

namespace defe {

namespace {

  /// Cracks grow through rings of joints, see crack_growth.h; a joint's own traction starts nothing.
  class Rings : public OpeningLaw {
   public:
    const char *name() const override { return "rings"; }
    bool by_cracks() const override { return true; }
    bool starts(double, double, const CohesiveParameters &) const override { return false; }
    double least_traction(const CohesiveParameters &) const override { return HUGE_VAL; }
  };
  const Rings rings;

}    // namespace

extern const OpeningLaw &rings_opening;
const OpeningLaw &rings_opening = rings;

}    // namespace defe
