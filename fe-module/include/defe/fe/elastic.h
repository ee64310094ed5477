#ifndef DEFE_FE_ELASTIC_H
#define DEFE_FE_ELASTIC_H

#include <string>

namespace defe::fe {

/// Isotropic linear elastic solid. Any consistent units; SI in all examples.
struct IsotropicElastic {
  double E = 0.0;      ///< Young's modulus
  double nu = 0.0;     ///< Poisson's ratio, -1 < nu < 1/2
  double rho = 0.0;    ///< mass density

  double lambda() const;    ///< first Lame constant, E nu / ((1 + nu)(1 - 2 nu))
  double mu() const;        ///< shear modulus, E / (2 (1 + nu))
  double bulk() const;      ///< bulk modulus, E / (3 (1 - 2 nu))

  double c_dilatational() const;    ///< speed of plane compression waves, sqrt((lambda + 2 mu)/rho)
  double c_bar() const;             ///< speed of waves in a thin bar, sqrt(E/rho)

  /// Empty if the constants are usable, else one line that says what is wrong with which value.
  std::string validate() const;
};

}    // namespace defe::fe

#endif
