// A law of opening as a file of coupling/src would have it; the line in opening_law.cpp is that of the test that
// includes it, test_cpl_opening_law.cpp.

#include "defe/coupling/opening_law.h"

namespace defe {

namespace {

  /// By the normal traction alone, whatever the shear.
  class Tension : public OpeningLaw {
   public:
    const char *name() const override { return "tension"; }
    bool by_cracks() const override { return false; }
    bool starts(double t_n, double, const CohesiveParameters &law) const override
    {
      return t_n >= law.sigma_t;
    }
    double least_traction(const CohesiveParameters &law) const override { return law.sigma_t; }
  };
  const Tension tension;

}    // namespace

extern const OpeningLaw &tension_opening;
const OpeningLaw &tension_opening = tension;

}    // namespace defe
