// One element of the installed DEFE::fe, stretched in one direction, and a curve of DEFE::coupling: their values
// are those of the formulas.

#include "defe/coupling/softening_curve.h"
#include "defe/fe/kernel.h"

#include <cmath>
#include <cstdio>

int main()
{
  using namespace defe;
  const double E = 74.09e9, nu = 0.2, strain = 1e-6;
  fe::HexCoords X;
  X << 0, 1, 1, 0, 0, 1, 1, 0, 0, 0, 1, 1, 0, 0, 1, 1, 0, 0, 0, 0, 1, 1, 1, 1;
  const fe::LagrangianKernel kernel(fe::IsotropicElastic{E, nu, 2500});
  fe::HexCoords x = X;
  x.row(0) *= 1 + strain;
  const double stress = kernel.stress(x, X, Vec3::Zero(), nullptr)(0, 0);
  const double expected = E * (1 - nu) / ((1 + nu) * (1 - 2 * nu)) * strain;
  const double length = softening_curve(find_softening_curve("linear")).length(60e6, 10.0);
  std::printf("stress %g, expected %g; length %g\n", stress, expected, length);
  return std::abs(stress / expected - 1) > 1e-5 || std::abs(length / (2 * 10.0 / 60e6) - 1) > 1e-12;
}
