#ifndef DEFE_FE_PERIODIC_H
#define DEFE_FE_PERIODIC_H

#include "defe/fe/topology.h"

namespace defe::fe {

/// Joins an element of a mesh that is closed across the border of a periodic box: its last elements have the nodes of
/// the first ones, which are given at the other side of the box. Corners are moved to their images next to the first
/// corner, along each axis along which the element is longer than half of the period as it is given, and would be
/// at most a quarter of it long then; along all others they stay as they are, to the last digit.
/// \param periods  of the box (length units); not finite or 0: not periodic along this axis
/// \return bit k: joined along axis k
unsigned join_across_border(HexCoords &X, const Vec3 &periods);

}    // namespace defe::fe

#endif
