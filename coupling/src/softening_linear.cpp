#include "defe/coupling/softening_curve.h"

namespace defe {

namespace {

  /// Hillerborg, Modeer and Petersson, Cem. Concr. Res. 6 (1976) 773: D = (kappa - kappa_0)/delta_c, delta_c = 2 G_f/s_0.
  class Linear : public SofteningCurve {
   public:
    const char *name() const override { return "linear"; }
    double length(double s0, double G_f) const override { return 2.0 * G_f / s0; }
    double damage(double from, double to, double, double length) const override
    {
      return (to - from) / length;
    }
    // w = (1 + kappa_0/delta_c)(1 - kappa_0/kappa)
    double dissipated(double energy, double from, double to, double kappa0,
                      double length) const override
    {
      return energy * (1.0 + kappa0 / length) * kappa0 * (to - from);
    }
  };
  const Linear linear;

}    // namespace

extern const SofteningCurve &linear_softening;
const SofteningCurve &linear_softening = linear;

}    // namespace defe
