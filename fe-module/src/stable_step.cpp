#include "defe/fe/stable_step.h"

#include "defe/fe/hex8.h"

#include <Eigen/Eigenvalues>
#include <cmath>

namespace defe::fe {

double max_frequency(const HexCoords &X, const IsotropicElastic &material)
{
  using Solver = Eigen::SelfAdjointEigenSolver<Eigen::Matrix<double, 24, 24>>;
  const Solver solver(stiffness(X, material), Eigen::EigenvaluesOnly);
  return std::sqrt(solver.eigenvalues()[23] / nodal_mass(X, material.rho));
}

double critical_step(const HexCoords &X, const IsotropicElastic &material)
{
  return 2.0 / max_frequency(X, material);
}

}    // namespace defe::fe
