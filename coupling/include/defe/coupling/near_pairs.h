#ifndef DEFE_COUPLING_NEAR_PAIRS_H
#define DEFE_COUPLING_NEAR_PAIRS_H

#include "defe/coupling/bins.h"

#include <algorithm>
#include <utility>
#include <vector>

namespace defe {

/// Calls f(i, j) once for each two of the small spheres that are nearer than `farthest`, and for each large and each
/// small one. Cells have the size of small spheres; of large ones there are few.
/// \param x  3 doubles per sphere
template <class F>
void for_near_pairs(const std::vector<int> &small, const std::vector<int> &large, const double *x,
                    double farthest, F f)
{
  struct Sphere {
    double x[3];
    int index;
  };
  std::vector<Sphere> spheres;
  spheres.reserve(small.size());
  for (int i : small) {
    const double *p = x + 3 * static_cast<std::size_t>(i);
    spheres.push_back({{p[0], p[1], p[2]}, i});
  }
  const CellList<Sphere> list(std::move(spheres), farthest);
  const int n = static_cast<int>(list.all().size());
  for (int a = 0; a < n; a++) {
    const Sphere &one = list.all()[a];
    list.runs_around(one.x, [&](int first, int last) {
      for (int b = std::max(first, a + 1); b < last; b++) {
        const Sphere &other = list.all()[b];
        double rsq = 0.0;
        for (int k = 0; k < 3; k++) rsq += (one.x[k] - other.x[k]) * (one.x[k] - other.x[k]);
        if (rsq < farthest * farthest) f(one.index, other.index);
      }
    });
  }
  for (int i : large)
    for (int j : small) f(i, j);
}

}    // namespace defe

#endif
