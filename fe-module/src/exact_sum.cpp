#include "defe/exact_sum.h"

namespace defe {

SumGrid sum_grid(double scale)
{
  const int exponent = std::ilogb(scale) + 1;    // scale < 2^exponent
  SumGrid grid;
  grid.shift = std::ldexp(1.5, exponent - 48 + 52);
  grid.limit = std::ldexp(1.0, exponent - 48 + 49);
  return grid;
}

double short_mass(double v)
{
  constexpr int digits = 36;
  const int exponent = std::ilogb(v) - digits + 1;
  return std::ldexp(std::nearbyint(std::ldexp(v, -exponent)), exponent);
}

}    // namespace defe
