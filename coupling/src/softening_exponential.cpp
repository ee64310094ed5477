#include "defe/coupling/softening_curve.h"

#include <cmath>

namespace defe {

namespace {

  /// Falls steeply at first and has a long tail, as concrete and fibre-bridged cracks do: with x = kappa - kappa_0,
  ///   1 - D = (exp(-x/L) - exp(-U))/(1 - exp(-U)),   0 <= x <= U L,   U = 6.
  /// Its area L (1 - U/(exp(U) - 1)) is G_f/s_0. Without the end it is the curve of Karihaloo (Fracture Mechanics
  /// and Structural Concrete, 1995); with it, joints break.
  class Exponential : public SofteningCurve {
   public:
    const char *name() const override { return "exponential"; }
    double length(double s0, double G_f) const override
    {
      return U * G_f / (s0 * (1.0 - U / std::expm1(U)));
    }
    double damage(double from, double to, double kappa0, double length) const override
    {
      const double L = length / U;
      return (std::exp((kappa0 - from) / L) - std::exp((kappa0 - to) / L)) / all;
    }
    // kappa_0 times the integral of 1 - 2 D, and kappa D between the ends
    double dissipated(double energy, double from, double to, double kappa0,
                      double length) const override
    {
      const double L = length / U, D_from = damage(kappa0, from, kappa0, length),
                   D_to = damage(kappa0, to, kappa0, length);
      const double tail = L * (std::exp((kappa0 - from) / L) - std::exp((kappa0 - to) / L));
      const double area_of_D = ((to - from) - tail) / all;
      return energy * kappa0 * ((to - from) - 2.0 * area_of_D + to * D_to - from * D_from);
    }

   private:
    static constexpr double U = 6.0;
    const double all = -std::expm1(-U);
  };
  const Exponential exponential;

}    // namespace

extern const SofteningCurve &exponential_softening;
const SofteningCurve &exponential_softening = exponential;

}    // namespace defe
