#ifndef DEFE_COUPLING_SELECTIVE_SHEAR_H
#define DEFE_COUPLING_SELECTIVE_SHEAR_H

/// \file
/// Selective shear (corner_strain.h) of cells of any shape. In boxes it is what corner_strain_orthogonal() does.
///
/// Where joints along axis a turn against each other by a deflection along the normal of the other two axes b, c, the strain is
/// T = (g^a (x) g^c + g^c (x) g^a)/2 with the dual vectors of the cell's axes. The strains of the DE's corners are one vector, with the
/// energy's inner product, and w f T with f = 1/V_+ on one side and -1/V_- on the other is another one. Of the part of the
/// former along the latter, 1 - s of the energy is taken away. So W stays positive in any cell, and uniform strain has no such
/// part. In oblique cells T has a trace, and terms of several pairs have something in common: their 1 - s are less by what
/// Gershgorin's circles need for the sum of all to stay below 1.

#include "corner_metric.h"

namespace defe {

/// No side of a cell is shorter than this part of another: a cube.
constexpr double cube_from = 0.99;

/// 1 - s of a pair of axes, from the square of the shorter one's length by that of the longer one.
inline double shear_to_drop(double ratio2)
{
  return ratio2 < cube_from * cube_from ? 1.0 - ratio2 : 0.0;
}

/// Of one pair of axes: the energy is less by scale/2 of the square of sum S : E over the corners, E the covariant strain, and
/// their contravariant stress times volume by scale times that sum times S. Order xx yy zz xy xz yz of the joints at a corner, then
/// the corner.
struct ShearTerm {
  double S[6][8];
  double scale;    ///< 1/energy

  /// Sum of S : E over the corners.
  double of(const double E[6][8]) const;
};

class SelectiveShear {
 public:
  explicit SelectiveShear(const GeneralCell &);

  bool any() const { return n > 0; }

  /// \param inverse  inverse metric at the corners in the order of ShearTerm; of absent joints 1 and 0
  /// \param w        volumes of the corners
  /// \return number of terms
  int terms(const GeneralCell &, unsigned present, const CornerModuli &, const double inverse[6][8],
            const double w[8], ShearTerm out[3]) const;

 private:
  struct Pair {
    int along, across;    ///< axes of the cell
    Vec3 a, b;            ///< dual vectors, of any length
    double drop;          ///< 1 - s
  };
  int n = 0;
  Pair list[3];

  double weights(const Pair &, const GeneralCell &, unsigned present, const double w[8],
                 double f[8]) const;
};

}    // namespace defe

#endif
