/* ----------------------------------------------------------------------
   DEFE: adaptive finite elements to bonded discrete elements for LAMMPS
   https://www.lammps.org/
   This software is distributed under the GNU General Public License.
------------------------------------------------------------------------- */

#ifndef LMP_DEFE_CELLS_H
#define LMP_DEFE_CELLS_H

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <vector>

namespace LAMMPS_NS {

/// A box divided into cells, all in one array. Positions outside count to the nearest cell.
struct Cells {
  static constexpr double MOST = 4.0e6;    // cells; they become larger instead

  double lo[3] = {HUGE_VAL, HUGE_VAL, HUGE_VAL}, hi[3] = {-HUGE_VAL, -HUGE_VAL, -HUGE_VAL};
  double inverse = 0.0;
  int n[3] = {0, 0, 0};

  void add(const double *x)
  {
    for (int d = 0; d < 3; d++) {
      lo[d] = std::min(lo[d], x[d]);
      hi[d] = std::max(hi[d], x[d]);
    }
  }
  /// into cubes that are not smaller than size
  void divide(double size)
  {
    if (!(lo[0] <= hi[0])) return;
    for (;; size *= 1.5) {
      double cells = 1.0;
      for (int d = 0; d < 3; d++) cells *= std::floor((hi[d] - lo[d]) / size) + 1.0;
      if (cells <= MOST) break;
    }
    inverse = 1.0 / size;
    for (int d = 0; d < 3; d++) n[d] = static_cast<int>((hi[d] - lo[d]) * inverse) + 1;
  }
  size_t count() const { return static_cast<size_t>(n[0]) * n[1] * n[2]; }
  size_t index(int i, int j, int k) const
  {
    return i + static_cast<size_t>(n[0]) * (j + static_cast<size_t>(n[1]) * k);
  }
  void of(const double *x, int *c) const
  {
    for (int d = 0; d < 3; d++)
      c[d] = static_cast<int>(std::min(std::max((x[d] - lo[d]) * inverse, 0.0), n[d] - 1.0));
  }
  size_t of(const double *x) const
  {
    int c[3];
    of(x, c);
    return index(c[0], c[1], c[2]);
  }
  /// Every cell also gets what the cells within `far` of it hold.
  template <class Merge>
  void spread(std::vector<int> &value, int far, int nothing, Merge merge) const
  {
    size_t stride = 1;
    std::vector<int> line;
    for (int d = 0; d < 3; d++) {
      for (size_t slab = 0; slab < value.size(); slab += stride * n[d])
        for (size_t start = slab; start < slab + stride; start++) {
          line.resize(n[d]);
          bool any = false;
          for (int i = 0; i < n[d]; i++) {
            line[i] = value[start + i * stride];
            any = any || line[i] != nothing;
          }
          if (!any) continue;
          for (int i = 0; i < n[d]; i++)
            for (int j = std::max(i - far, 0); j <= std::min(i + far, n[d] - 1); j++)
              merge(value[start + i * stride], line[j]);
        }
      stride *= n[d];
    }
  }
};

}    // namespace LAMMPS_NS

#endif
