#ifndef DEFE_FE_HEX_MODES_H
#define DEFE_FE_HEX_MODES_H

// The nodal values v_a of a trilinear field and its coefficients by monomials,
//   v(xi) = sum_m c_m phi_m(xi),  phi_m = product of the natural coordinates whose bit is set in m
// (bit 0: xi, 1: eta, 2: zeta), are related by a Walsh-Hadamard transform: 8 c_m = sum_a
// phi_m(a) v_a, v_a = sum_m phi_m(a) c_m. Mode 0 is the mean; modes 1, 2, 4 are the gradient at the
// centre. With c~_m = 8 c_m on the way in, and forces f_a = sum_m phi_m(a) g_m on the way out,
// sum_a f_a . v_a = sum_m g_m . c~_m: no factors of 8 in the loops.

#include "defe/exact_sum.h"
#include "defe/fe/kernel.h"
#include "defe/simd.h"

#include <cstddef>
#include <limits>
#include <type_traits>

namespace defe::fe {

using simd::Pack;

/// The node at each corner; a corner's bits are set where its natural coordinate is +1.
inline constexpr int hex_corner_node[8] = {0, 1, 3, 2, 4, 5, 7, 6};

/// phi_m at node a.
constexpr int hex_mode(int m, int a)
{
  return (m & 1 ? hex_sign[a][0] : 1) * (m & 2 ? hex_sign[a][1] : 1) * (m & 4 ? hex_sign[a][2] : 1);
}

/// v[corner] -> v~[mode], in place.
DEFE_INLINE void nodes_to_modes(Pack v[8])
{
  for (int bit = 1; bit < 8; bit *= 2)
    for (int i = 0; i < 8; ++i)
      if (!(i & bit)) {
        const Pack minus = v[i], plus = v[i | bit];
        v[i] = plus + minus;
        v[i | bit] = plus - minus;
      }
}

/// g[mode] -> f[corner], in place: the transpose of the above.
DEFE_INLINE void modes_to_nodes(Pack g[8])
{
  for (int bit = 1; bit < 8; bit *= 2)
    for (int i = 0; i < 8; ++i)
      if (!(i & bit)) {
        const Pack even = g[i], odd = g[i | bit];
        g[i] = even - odd;
        g[i | bit] = even + odd;
      }
}

/// Element of each lane: the last pack of a list is filled up with its last element, whose copies
/// are computed and dropped.
struct LaneElements {
  const int (*nodes)[8];
  int valid;

  int index(int l) const { return l < valid ? l : valid - 1; }
};

/// The elements of a list that turned inside out: the first of them, and NaN in their lanes.
struct LostElements {
  int first = -1;    ///< in the list, -1 = none

  DEFE_INLINE void note(const LaneElements &elements, int start, int lane)
  {
    if (first < 0 && lane < elements.valid) first = start + lane;
  }
  DEFE_INLINE void note(const LaneElements &elements, int start, const simd::Mask &lost)
  {
    for (int l = 0; l < simd::width; ++l)
      if (lost[l]) note(elements, start, l);
  }
  /// To be added to the results of the pack that starts there.
  DEFE_INLINE Pack poison(const LaneElements &elements, int start, const simd::Mask &valid)
  {
    if (__builtin_expect(!simd::any(~valid), true)) return Pack{};
    note(elements, start, ~valid);
    return valid ? Pack{} : simd::broadcast(std::numeric_limits<double>::quiet_NaN());
  }
};

/// Where a node's entry starts in an array of 3 doubles per node.
template <class T> DEFE_INLINE T *entry(T *array, int node)
{
  return array + 3 * static_cast<std::ptrdiff_t>(node);
}

/// v~[component][mode] of a nodal vector (3 doubles per node) relative to its value at node 0.
/// The differences come first: sums of absolute coordinates would lose digits. Mode 0 is left
/// meaningless: nothing in an element depends on it.
DEFE_INLINE void gather_modes(const LaneElements &elements, const double *vector, Pack v[3][8])
{
  const auto gather = [&elements, vector](int corner, Pack value[3]) {
    const double *of_lane[simd::width];
    for (int l = 0; l < simd::width; ++l) {
      const int(&node)[8] = elements.nodes[elements.index(l)];
      of_lane[l] = entry(vector, node[hex_corner_node[corner]]);
    }
    for (int i = 0; i < 3; ++i)
      value[i] = simd::generate([&](int l) {
        return of_lane[l][i];
      });
  };

  Pack origin[3], value[3];
  gather(0, origin);
  for (int i = 0; i < 3; ++i) v[i][0] = Pack{};
  for (int corner = 1; corner < 8; ++corner) {
    gather(corner, value);
    for (int i = 0; i < 3; ++i) v[i][corner] = value[i] - origin[i];
  }
  for (int i = 0; i < 3; ++i) nodes_to_modes(v[i]);
}

/// f_a += g_a
DEFE_INLINE void add_to_nodes(const LaneElements &elements, const Pack g[3][8], double *f)
{
  // Components 0 and 1 of even lanes and of odd lanes side by side: they are added together.
  Pack xy[8][2];
  for (int corner = 0; corner < 8; ++corner) {
    const Pack &x = g[0][corner], &y = g[1][corner];
    xy[corner][0] = simd::generate([&](int l) {
      return l % 2 ? y[l - 1] : x[l];
    });
    xy[corner][1] = simd::generate([&](int l) {
      return l % 2 ? y[l] : x[l + 1];
    });
  }
  for (int l = 0; l < elements.valid; ++l)
    for (int corner = 0; corner < 8; ++corner) {
      double *node = entry(f, elements.nodes[l][hex_corner_node[corner]]);
      const double *both = reinterpret_cast<const double *>(&xy[corner][l % 2]) + l / 2 * 2;
      const simd::Pair sum = simd::Pair::load(node) + simd::Pair::load(both);
      sum.store(node);
      node[2] += g[2][corner][l];
    }
}

/// f_a += sum_m phi_m(a) g_m; destroys g.
DEFE_INLINE void scatter_modes(const LaneElements &elements, Pack g[3][8], double *f)
{
  for (int i = 0; i < 3; ++i) modes_to_nodes(g[i]);
  add_to_nodes(elements, g, f);
}

/// The same with contributions on a grid.
DEFE_INLINE void scatter_modes_exactly(const LaneElements &elements, int start, Pack g[3][8],
                                       double *f, const HexKernel::Output &out)
{
  const Pack shift = simd::broadcast(out.grid->shift), limit = simd::broadcast(out.grid->limit);
  simd::Mask beyond = simd::Mask{};
  for (int i = 0; i < 3; ++i) {
    modes_to_nodes(g[i]);
    for (int corner = 0; corner < 8; ++corner) {
      g[i][corner] = (g[i][corner] + shift) - shift;
      beyond |= simd::abs(g[i][corner]) > limit;
    }
  }
  if (__builtin_expect(out.beyond && simd::any(beyond), false))
    for (int l = elements.valid - 1; l >= 0; --l)
      if (beyond[l] && *out.beyond < 0) *out.beyond = start + l;
  add_to_nodes(elements, g, f);
}

/// One value per element.
DEFE_INLINE void store_lanes(const LaneElements &elements, const Pack &p, double *out)
{
  for (int l = 0; l < elements.valid; ++l) out[l] = p[l];
}

/// stress_bound() of a symmetric tensor (xx yy zz xy xz yz).
DEFE_INLINE Pack symmetric_bound(const Pack s[6], const StressBound &weights)
{
  const Pack p = (s[0] + s[1] + s[2]) * (1.0 / 3.0);
  const Pack dx = s[0] - p, dy = s[1] - p, dz = s[2] - p;
  const Pack J2 = 0.5 * (dx * dx + dy * dy + dz * dz) + (s[3] * s[3] + s[4] * s[4] + s[5] * s[5]);
  return weights.mean * p + weights.shear * simd::sqrt(J2 * (1.0 / 3.0));
}

/// virial (xx yy zz xy xz yz) += sum over nodes of y_a f_a = sum over modes, for the elements that
/// are there. Symmetric because the moments of f balance.
DEFE_INLINE void add_virial(const LaneElements &elements, const Pack y[3][8],
                            const Pack force[3][8], Pack virial[6])
{
  constexpr int row[6] = {0, 1, 2, 0, 0, 1}, column[6] = {0, 1, 2, 1, 2, 2};
  const Pack there = simd::generate([&](int l) {
    return l < elements.valid ? 1.0 : 0.0;
  });
  for (int k = 0; k < 6; ++k) {
    Pack sum = Pack{};
    for (int m = 1; m < 8; ++m) sum += y[row[k]][m] * force[column[k]][m];
    virial[k] += there * sum;
  }
}

DEFE_INLINE void sum_lanes(const Pack virial[6], double out[6])
{
  for (int k = 0; k < 6; ++k)
    for (int l = 0; l < simd::width; ++l) out[k] += virial[k][l];
}

/// Calls next with std::true_type or std::false_type: in the loops, what nobody wants shall cost nothing.
template <class F> void choose_output(bool wanted, const F &next)
{
  if (wanted)
    next(std::true_type());
  else
    next(std::false_type());
}

/// Whether forces are rounded to a grid, so that their sums have the same bits in any order.
inline bool sums_exactly(const HexKernel::Output &out)
{
  return out.grid && out.grid->on();
}

/// Scatters, also for outputs that are seldom wanted: virial and forces on a grid. An instance of the general
/// kernels for each of their combinations took twice as long to compile.
/// \param force  is destroyed
DEFE_INLINE void scatter_seldom(const LaneElements &elements, int start, const Pack y[3][8],
                                Pack force[3][8], double *f, Pack virial[6],
                                const HexKernel::Output &out)
{
  if (out.virial) add_virial(elements, y, force, virial);
  if (sums_exactly(out))
    scatter_modes_exactly(elements, start, force, f, out);
  else
    scatter_modes(elements, force, f);
}

/// Calls f(energy, bound, seldom), the last one for scatter_seldom().
template <class F> void choose_outputs(const HexKernel::Output &out, const F &f)
{
  choose_output(out.energy, [&](auto energy) {
    choose_output(out.stress_bound, [&](auto bound) {
      choose_output(out.virial || sums_exactly(out), [&](auto seldom) {
        f(energy, bound, seldom);
      });
    });
  });
}

}    // namespace defe::fe

#endif
