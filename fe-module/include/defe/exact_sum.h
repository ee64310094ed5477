#ifndef DEFE_EXACT_SUM_H
#define DEFE_EXACT_SUM_H

/// \file
/// Sums of doubles that do not depend on the order of the additions.
///
/// Every contribution is rounded to a multiple of one quantum q, a power of two. Multiples of q below
/// 2^53 q are doubles, and so are their sums and differences as long as these stay below that: no
/// addition rounds, and addition is associative. So forces can be summed in any order, in parts by
/// several ranks, and sent between them as plain doubles. This is the first level of the
/// reproducible sums of Demmel and Nguyen (2013) with a quantum that is known beforehand.

#include <cmath>

namespace defe {

/// The multiples of one quantum.
struct SumGrid {
  /// 1.5 * 2^52 quanta, a double whose last digit is the quantum; 0: there is no grid
  double shift = 0.0;
  /// Contributions beyond this are not for this grid: 16 of them still add up exactly.
  double limit = 0.0;

  bool on() const { return shift > 0.0; }
  double quantum() const { return std::ldexp(shift, -52) / 1.5; }

  /// The multiple nearest to v, for |v| <= limit; off by half a quantum at the most.
  double round(double v) const { return (v + shift) - shift; }
  /// Not for NaN: that is no matter of range.
  bool beyond(double v) const { return std::abs(v) > limit; }
};

/// Grid for contributions of which `scale` is a bound that none but a broken run comes near: quanta of
/// 2^-48 to 2^-47 of it, and a limit of 2 to 4 times it. scale: positive and finite.
SumGrid sum_grid(double scale);

/// v > 0 with only so many significant binary digits that sums of a node's shares, an eighth of each of
/// its elements, are exact in any order as long as these differ by a factor of 10^4 at the most.
double short_mass(double v);

/// Whether a + b is a double.
inline bool adds_exactly(double a, double b)
{
  const double sum = a + b, part = sum - a;
  return part == b && sum - part == a;
}

}    // namespace defe

#endif
