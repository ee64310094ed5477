#ifndef DEFE_FE_PRESTRESS_H
#define DEFE_FE_PRESTRESS_H

/// \file
/// Stress that a body has before any load, as tempered glass has it.
///
/// An element whose nodes are where they were placed, X, has the Cauchy stress sigma. Free of all load it would have
/// another shape: G X, with a symmetric G near I that follows from sigma and the law. The deformation from there to X is
/// the same everywhere in the element, so that X has exactly the stress sigma, whatever the shape: the forces on the
/// nodes are those of sigma on the element's faces, and elements whose sigma is in equilibrium do not move. A
/// kernel made of the stress-free shape needs to know nothing of it.

#include "defe/fe/elastic.h"
#include "defe/fe/kernel.h"

namespace defe::fe {

/// Small strain of an isotropic elastic body under a stress.
Mat3 strain_of_stress(const Mat3 &sigma, const IsotropicElastic &);

/// Elastic energy per volume at small strain, sigma : C^-1 : sigma / 2.
double energy_of_stress(const Mat3 &sigma, const IsotropicElastic &);

/// G: what has the shape G X when free has the stress sigma at X.
/// \param cauchy_of  the law: Cauchy stress of a deformation gradient F that is symmetric and near I
template <class Law>
Mat3 stress_free_map(const Mat3 &sigma, const IsotropicElastic &elastic, const Law &cauchy_of)
{
  // the law is nearly that of small strain: each pass makes the error smaller by some times the strain
  Mat3 strain = strain_of_stress(sigma, elastic);
  for (int pass = 0; pass < 30; ++pass) {
    const Mat3 F = Mat3::Identity() + strain;
    const Mat3 error = strain_of_stress(sigma - cauchy_of(F), elastic);
    strain += error;
    if (!(error.norm() > 1e-15)) break;
  }
  return (Mat3::Identity() + strain).inverse();
}

/// The same for St Venant-Kirchhoff's law, by which joints of DEs go (corner_strain.h).
Mat3 stress_free_map(const Mat3 &sigma, const IsotropicElastic &elastic);

/// Stress that a kernel's forces stand for: their virial by the volume, the mean over the element. Elastic laws only.
/// \param X  ignored if the kernel holds its shape itself
Mat3 mean_cauchy_stress(const HexKernel &, const HexCoords &x, const HexCoords &X);

/// A pane's stress by its depth z: in both directions of its plane
///   s(z) = surface (3 (2 (z - middle)/h)^2 - 1)/2,  h = upper - lower,
/// `surface` at both faces, -surface/2 in the middle, and none across. Neither force nor moment over the thickness.
struct ParabolaStress {
  int axis;    ///< across the pane: 0, 1, 2
  double lower, upper, surface;

  /// Mean over the 2 x 2 x 2 Gauss points. In layers that lie flat in the pane it is that of the parabola over the layer,
  /// the same for all their elements, whatever shape these have in the plane.
  Mat3 over(const HexCoords &X) const;
};

/// Rounded to some 1e-15 of Young's modulus, so that elements of a layer have the same bits and share a kernel.
Mat3 rounded_stress(const Mat3 &sigma, const IsotropicElastic &);

}    // namespace defe::fe

#endif
