#include "defe/coupling/vtk_grid.h"

#include <algorithm>

namespace defe {

void VtkGrid::add_cell(Cell type, const std::int64_t *corner)
{
  types.push_back(type);
  connectivity.insert(connectivity.end(), corner, corner + corners(type));
  ends.push_back(static_cast<std::int64_t>(connectivity.size()));
}

void vtk_tensor(const double *s, double *tensor)
{
  std::copy(s, s + 4, tensor);
  tensor[4] = s[5];
  tensor[5] = s[4];
}

}    // namespace defe
