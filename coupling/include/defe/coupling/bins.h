#ifndef DEFE_COUPLING_BINS_H
#define DEFE_COUPLING_BINS_H

/// \file
/// Things with a position sorted into cells, to find those near a place.

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <vector>

namespace defe {

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
  std::size_t count() const { return static_cast<std::size_t>(n[0]) * n[1] * n[2]; }
  std::size_t index(int i, int j, int k) const
  {
    return i + static_cast<std::size_t>(n[0]) * (j + static_cast<std::size_t>(n[1]) * k);
  }
  void of(const double *x, int *c) const
  {
    for (int d = 0; d < 3; d++)
      c[d] = static_cast<int>(std::min(std::max((x[d] - lo[d]) * inverse, 0.0), n[d] - 1.0));
  }
  std::size_t of(const double *x) const
  {
    int c[3];
    of(x, c);
    return index(c[0], c[1], c[2]);
  }
  /// Every cell also gets the bits of the cells within `far` of it.
  void spread(std::vector<unsigned> &bits, int far) const
  {
    std::size_t stride = 1;
    std::vector<unsigned> from;
    for (int d = 0; d < 3; d++) {
      from = bits;
      for (int shift = 1; shift <= far && shift < n[d]; shift++) {
        const std::size_t off = shift * stride, count = stride * (n[d] - shift);
        for (std::size_t slab = 0; slab < bits.size(); slab += stride * n[d]) {
          for (std::size_t i = slab; i < slab + count; i++) bits[i] |= from[i + off];
          for (std::size_t i = slab; i < slab + count; i++) bits[i + off] |= from[i];
        }
      }
      stride *= n[d];
    }
  }
};

/// Items with a position, double x[3], sorted by cells. Those within `size` of a place are in the cells
/// around it, up to `far` in each direction (more: cells are smaller, and less is looked at that is too far away).
template <class Item> class CellList {
 public:
  CellList(std::vector<Item> &&unsorted, double size, int far_ = 1) : far(far_), reach(size)
  {
    for (const auto &item : unsorted) cells.add(item.x);
    cells.divide(size / far);
    start.assign(cells.count() + 1, 0);
    std::vector<std::size_t> cell(unsorted.size());
    for (std::size_t k = 0; k < unsorted.size(); k++) {
      cell[k] = cells.of(unsorted[k].x);
      start[cell[k] + 1]++;
    }
    for (std::size_t c = 0; c < cells.count(); c++) start[c + 1] += start[c];
    items.resize(unsorted.size());
    std::vector<int> next(start.begin(), start.end() - 1);
    for (std::size_t k = 0; k < unsorted.size(); k++) items[next[cell[k]]++] = unsorted[k];
  }
  const std::vector<Item> &all() const { return items; }

  std::size_t cell_of(const double *x) const { return cells.of(x); }
  /// Whether there may be anything within `size` of places that are within `beyond` of x.
  bool may_reach(const double *x, double beyond) const
  {
    const double most = (reach + beyond) * (1.0 + 1e-9);
    for (int d = 0; d < 3; d++)
      if (!(x[d] >= cells.lo[d] - most && x[d] <= cells.hi[d] + most)) return false;
    return true;
  }
  /// Of each cell: what bits(item) says of the items in it and in those around it.
  template <class F> std::vector<unsigned> bits_around(F bits) const
  {
    std::vector<unsigned> all(cells.count(), 0);
    for (std::size_t c = 0; c < all.size(); c++)
      for (int k = start[c]; k < start[c + 1]; k++) all[c] |= bits(items[k]);
    cells.spread(all, far);
    return all;
  }

  /// f(first, last) for runs of indices into all(), which hold all items within `size` of x, and few others.
  /// \param beyond  of the places around x that are meant
  template <class F> void runs_around(const double *x, F f, double beyond = 0.0) const
  {
    if (items.empty() || !may_reach(x, beyond)) return;
    const double most = (reach + beyond) * (1.0 + 1e-9), cell_size = 1.0 / cells.inverse;
    const double low[3] = {x[0] - most, x[1] - most, x[2] - most};
    const double high[3] = {x[0] + most, x[1] + most, x[2] + most};
    int from[3], to[3];
    cells.of(low, from);
    cells.of(high, to);
    const auto beside = [&](int d, int c) {    // from x to the layer of these cells
      const double at = x[d] - (cells.lo[d] + c * cell_size);
      return std::max(std::max(-at, at - cell_size), 0.0);
    };
    for (int k = from[2]; k <= to[2]; k++) {
      const double z = beside(2, k);
      for (int j = from[1]; j <= to[1]; j++) {
        const double y = beside(1, j);
        if (y * y + z * z > most * most) continue;
        f(start[cells.index(from[0], j, k)], start[cells.index(to[0], j, k) + 1]);
      }
    }
  }

 private:
  int far;
  double reach;
  Cells cells;
  std::vector<int> start;    // per cell, and the end
  std::vector<Item> items;
};

}    // namespace defe

#endif
