#ifndef DEFE_FE_HEX8_H
#define DEFE_FE_HEX8_H

#include "defe/fe/elastic.h"
#include "defe/fe/topology.h"

#include <array>
#include <string>

namespace defe::fe {

/// Trilinear shape functions at natural coordinates xi in [-1, 1]^3.
Eigen::Matrix<double, 8, 1> shape(const Vec3 &xi);

/// Their derivatives by the natural coordinates: row a = node a.
Eigen::Matrix<double, 8, 3> shape_gradient(const Vec3 &xi);

/// The 2 x 2 x 2 Gauss points (weight 1 each), point a in the octant of node a.
const std::array<Vec3, 8> &gauss_points();

/// The point (or any nodal vector) at natural coordinates xi.
Vec3 interpolate(const HexCoords &X, const Vec3 &xi);

/// Jacobian matrix dX_i/dxi_j.
Mat3 jacobian(const HexCoords &X, const Vec3 &xi);

/// Deformation gradient dx_i/dX_j; both positions relative to the first node, so that no digits are lost.
Mat3 deformation_gradient(const HexCoords &x, const HexCoords &X, const Vec3 &xi);

/// Volume; exact for any trilinear hexahedron.
double volume(const HexCoords &X);

/// Lumped mass of one node of an element: an eighth of the element's mass.
double nodal_mass(const HexCoords &X, double rho);

/// Area of the bilinear surface through four points in cyclic order (exact if they are coplanar,
/// 2 x 2 Gauss points otherwise).
double face_area(const Vec3 p[4]);

/// Volume by largest face area (the length in LS-DYNA's time step for solids).
double characteristic_length(const HexCoords &X);

/// Longest distance between any two nodes.
double max_diagonal(const HexCoords &X);

/// Longest diagonal of a face.
double max_face_diagonal(const HexCoords &X);

struct HexCheck {
  enum Verdict {
    good,          ///< positive Jacobian everywhere that matters
    suspicious,    ///< positive at the Gauss points, but not at every corner: usable, worth a warning
    bad            ///< inverted, flat or not finite: must be refused
  };
  Verdict verdict = good;
  double min_gauss_jacobian = 0.0;     ///< smallest det(dX/dxi) over the Gauss points
  double min_corner_jacobian = 0.0;    ///< smallest det(dX/dxi) over the nodes
};

/// Judges the shape of an element. `bad` means a Jacobian <= 1e-6 (mean edge / 2)^3 at a Gauss point
/// (a cube of the same mean edge has a million times more) or a coordinate that is not finite.
HexCheck check_hex(const HexCoords &X);

/// One line for a warning or an error: element id, what is wrong, and the eight node coordinates.
std::string describe_bad_hex(long long id, const HexCoords &X, const HexCheck &check);

/// Linear stiffness matrix, 2 x 2 x 2 Gauss points; row and column 3 a + i = node a, component i.
Eigen::Matrix<double, 24, 24> stiffness(const HexCoords &X, const IsotropicElastic &material);

/// The same with the mean dilatation of the element at all Gauss points (B-bar; Nagtegaal, Parks and
/// Rice 1974, Hughes 1980), the linearisation of FBarKernel: no volumetric locking.
Eigen::Matrix<double, 24, 24> stiffness_fbar(const HexCoords &X, const IsotropicElastic &material);

/// The same with enhanced modes (src/enhanced.h), which are condensed: its eigenvalues are not larger than those of
/// stiffness().
Eigen::Matrix<double, 24, 24> stiffness_enhanced(const HexCoords &X,
                                                 const IsotropicElastic &material);

/// Stress of a strain, lambda tr(e) I + 2 mu e.
Mat3 elastic_stress(const Mat3 &strain, const IsotropicElastic &material);

/// Linear stress C : sym(grad u) at natural coordinates xi, for nodal displacements u.
Mat3 linear_stress(const HexCoords &X, const HexCoords &u, const IsotropicElastic &material,
                   const Vec3 &xi);

}    // namespace defe::fe

#endif
