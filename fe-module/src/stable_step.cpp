#include "defe/fe/stable_step.h"

#include "defe/fe/hex8.h"

#include <Eigen/Eigenvalues>
#include <cmath>

namespace defe::fe {

namespace {

  double frequency(const Eigen::Matrix<double, 24, 24> &K, const HexCoords &X, double rho)
  {
    using Solver = Eigen::SelfAdjointEigenSolver<Eigen::Matrix<double, 24, 24>>;
    return std::sqrt(Solver(K, Eigen::EigenvaluesOnly).eigenvalues()[23] / nodal_mass(X, rho));
  }

}    // namespace

double max_frequency(const HexCoords &X, const IsotropicElastic &material, ElementType type)
{
  const auto K = type == ElementType::enhanced ? stiffness_enhanced(X, material)
                                               : stiffness(X, material);
  return frequency(K, X, material.rho);
}

double critical_step(const HexCoords &X, const IsotropicElastic &material, ElementType type)
{
  return 2.0 / max_frequency(X, material, type);
}

double max_frequency_fbar(const HexCoords &X, const IsotropicElastic &initial)
{
  return frequency(stiffness_fbar(X, initial), X, initial.rho);
}

double critical_step_fbar(const HexCoords &X, const IsotropicElastic &initial)
{
  return 2.0 / max_frequency_fbar(X, initial);
}

}    // namespace defe::fe
