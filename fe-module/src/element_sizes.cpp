#include "defe/fe/element_sizes.h"

#include "defe/fe/hex8.h"

#include <algorithm>
#include <cmath>

namespace defe::fe {

void ElementSizes::add(const HexCoords &X)
{
  diagonal = std::max(diagonal, max_diagonal(X));
  face_diagonal = std::max(face_diagonal, max_face_diagonal(X));
  for (int a = 0; a < 8; a++)
    for (int axis = 0; axis < 3; axis++)
      shortest_edge =
          std::min(shortest_edge, (X.col(hex_edge_neighbor(a, axis)) - X.col(a)).norm());
}

void ElementSizes::add_force(const HexCoords &X, const IsotropicElastic &elastic)
{
  // an area is half of its diagonal squared at the most
  largest_force =
      std::max(largest_force,
               (elastic.lambda() + 2.0 * elastic.mu()) * 0.5 * std::pow(max_face_diagonal(X), 2));
}

}    // namespace defe::fe
