#ifndef DEFE_COUPLING_SOFTENING_CURVE_H
#define DEFE_COUPLING_SOFTENING_CURVE_H

/// \file
/// How the traction of a softening joint falls from its strength to nothing: the law that is in cohesive.h. A curve is a
/// file of its own (see src/softening_linear.cpp) and a line in src/softening_curve.cpp.
///
/// With kappa the largest stretch so far, and kappa_0 that at the switch, the equivalent traction is s_0 (1 - D), D the
/// damage, which goes from 0 at kappa_0 to 1 at kappa_0 + length(): there the joint is broken. The area
/// under the curve is G_f, whatever its form.

#include <cstddef>
#include <string>
#include <vector>

namespace defe {

class SofteningCurve {
 public:
  SofteningCurve() = default;
  SofteningCurve(const SofteningCurve &) = delete;
  SofteningCurve &operator=(const SofteningCurve &) = delete;
  virtual ~SofteningCurve();

  /// As in an input line.
  virtual const char *name() const = 0;

  /// Stretch between the switch and the end.
  virtual double length(double s0, double G_f) const = 0;

  /// D(to) - D(from); D is counted from kappa0. Neither is beyond the end.
  virtual double damage(double from, double to, double kappa0, double length) const = 0;

  /// What is dissipated from `from` to `to`: `energy` times the integral of kappa^2 dw, which with the share of the
  /// stiffness that is left, 1 - w = (kappa_0/kappa)(1 - D), is that of kappa_0 (1 - D + kappa D') d kappa.
  /// \param energy  of the undamaged joint, over the square of its stretch
  virtual double dissipated(double energy, double from, double to, double kappa0,
                            double length) const = 0;
};

/// All registered curves; cohesive.h has the number of one, 0 unless another is given.
const std::vector<const SofteningCurve *> &softening_curves();

inline const SofteningCurve &softening_curve(int number)
{
  return *softening_curves()[number];
}

/// -1: there is none of this name.
int find_softening_curve(const std::string &name);

}    // namespace defe

#endif
