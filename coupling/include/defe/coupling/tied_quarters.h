#ifndef DEFE_COUPLING_TIED_QUARTERS_H
#define DEFE_COUPLING_TIED_QUARTERS_H

/// \file
/// Tied surfaces (tied_surfaces.h) whose elements have become eight DEs. Each of the four DEs behind a tied face gets a joint
/// to one place of the other part: the mean one of the area that its quarter of the face has in common with it,
///
///     p = sum of w_k x_k,    w_k = integral N_k dA / area,
///
/// over all faces that are there. N_k are the shape functions of the other part's nodes; where that part has become
/// DEs, too, the bilinear functions through the four DEs behind its face, p being in their plane. The joint acts in the
/// corner strains of the DE (corner_strain.h), with which its crack parts it from its neighbours, not from the other part. In
/// linear displacement fields p moves as a point of the body. Under constant stress each node gets what the other part's
/// nodal forces are, and each DE the stress times its area: of a joint between two DEs either one has the share that
/// ends at the face. (Where a quarter lies half on nodes, half on DEs, p is not straight above the DE, and some per cent
/// of the force on it are missing.) Forces have no sum and no moment.
///
/// Written for this package; the integrals are those of mortar methods (Puso and Laursen 2004).

#include "defe/coupling/tied_surfaces.h"

#include <array>
#include <vector>

namespace defe {

/// What a quarter of a face has in common with a face of the other part, in the reference configuration.
struct TiedQuarter {
  double area = 0.0;    ///< 0: nothing
  std::array<double, 4>
      weight{};    ///< of the other face's nodes, order of fe::hex_face; their sum is 1
};

/// Of A's face, by node of it in the order of fe::hex_face. B's face may be at a distance, see TieRule: what
/// is in common is that of tie_faces().
std::array<TiedQuarter, 4> tied_quarters(const TiedElement &a, const TiedElement &b);

/// Distance of the DEs behind the face of an element.
double depth_of_des(const TiedElement &);

/// The same place where the other element has become DEs: of the four behind its face, in the plane through them.
std::array<double, 4> weights_of_des(const std::array<double, 4> &of_nodes);

/// One of the faces that a DE is tied to.
struct TiedPiece {
  double area;                     ///< in common
  std::array<double, 4> weight;    ///< of its nodes, or of the DEs behind it
  bool discrete;                   ///< DEs
  double depth;                    ///< of these behind the face
};

/// Less of a quarter than this is not held.
constexpr double least_tied_share = 0.5;

struct TiedPlace {
  std::vector<double> weight;    ///< 4 for each piece
  /// Of the vector from the DE to the place: up to the border of its cell
  double share;
};

/// Of all that a DE is tied to with one face. depth: of the DE behind its face.
TiedPlace tied_place(const std::vector<TiedPiece> &, double depth);

}    // namespace defe

#endif
