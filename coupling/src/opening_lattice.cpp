#include "defe/coupling/opening_law.h"

namespace defe {

namespace {

  /// Gao and Zang, Eng. Anal. Bound. Elem. 42 (2014) 27: each joint by its own traction, under tension, when the
  /// equivalent traction reaches sigma_t. Cracks run along the rows of the lattice.
  class Lattice : public OpeningLaw {
   public:
    const char *name() const override { return "lattice"; }
    bool by_cracks() const override { return false; }
    bool starts(double t_n, double t_s, const CohesiveParameters &law) const override
    {
      return t_n > 0.0 && equivalent_traction(t_n, t_s, law) >= law.sigma_t;
    }
    double least_traction(const CohesiveParameters &law) const override
    {
      if (law.reciprocal && law.beta < 1.0) return law.sigma_t * law.beta;
      if (!law.reciprocal && law.beta > 1.0) return law.sigma_t / law.beta;
      return law.sigma_t;
    }
  };
  const Lattice lattice;

}    // namespace

extern const OpeningLaw &lattice_opening;
const OpeningLaw &lattice_opening = lattice;

}    // namespace defe
