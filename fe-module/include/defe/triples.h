#ifndef DEFE_TRIPLES_H
#define DEFE_TRIPLES_H

/// \file
/// Vectors of three numbers that lie side by side in memory, and the same beside each other in packs. For loops that read positions and write
/// forces of neighbours: one by one, that takes longer than what is computed with them. With AVX and without it the
/// arithmetic is the same, and no number is touched that is not asked for. As defe/simd.h only for .cpp files.

#include "defe/simd.h"

#include <algorithm>

namespace defe::simd {

/// Three numbers that lie side by side.
class Triple {
 public:
#if defined(__AVX__)
  DEFE_INLINE Triple() : v(_mm256_setzero_pd()) {}
  DEFE_INLINE explicit Triple(const double *p) :
      v(_mm256_maskload_pd(p, _mm256_setr_epi64x(-1, -1, -1, 0)))
  {
  }
  friend DEFE_INLINE Triple operator+(const Triple &a, const Triple &b)
  {
    return Triple(_mm256_add_pd(a.v, b.v));
  }
  friend DEFE_INLINE Triple operator-(const Triple &a, const Triple &b)
  {
    return Triple(_mm256_sub_pd(a.v, b.v));
  }
  DEFE_INLINE Triple squares() const
  {
    return Triple(_mm256_mul_pd(v, v));
  }
  friend DEFE_INLINE Triple larger(const Triple &a, const Triple &b)
  {
    return Triple(_mm256_max_pd(a.v, b.v));
  }

 private:
  __m256d v;    // the fourth is 0

  DEFE_INLINE explicit Triple(__m256d of) : v(of) {}
#else
  DEFE_INLINE Triple() : v{0.0, 0.0, 0.0} {}
  DEFE_INLINE explicit Triple(const double *p) : v{p[0], p[1], p[2]} {}
  friend DEFE_INLINE Triple operator+(const Triple &a, const Triple &b)
  {
    return {a.v[0] + b.v[0], a.v[1] + b.v[1], a.v[2] + b.v[2]};
  }
  friend DEFE_INLINE Triple operator-(const Triple &a, const Triple &b)
  {
    return {a.v[0] - b.v[0], a.v[1] - b.v[1], a.v[2] - b.v[2]};
  }
  DEFE_INLINE Triple squares() const
  {
    return {v[0] * v[0], v[1] * v[1], v[2] * v[2]};
  }
  friend DEFE_INLINE Triple larger(const Triple &a, const Triple &b)
  {
    return {a.v[0] > b.v[0] ? a.v[0] : b.v[0], a.v[1] > b.v[1] ? a.v[1] : b.v[1],
            a.v[2] > b.v[2] ? a.v[2] : b.v[2]};
  }

 private:
  double v[3];

  DEFE_INLINE Triple(double x, double y, double z) : v{x, y, z} {}
#endif

 public:
  DEFE_INLINE double operator[](int i) const
  {
    return v[i];
  }
};

/// Four of them, from anywhere.
class FourTriples {
 public:
#if defined(__AVX__)
  DEFE_INLINE explicit FourTriples(const double *const *p)
  {
    const __m256i three = _mm256_setr_epi64x(-1, -1, -1, 0);
    for (int l = 0; l < 4; ++l) v[l] = _mm256_maskload_pd(p[l], three);
  }
  friend DEFE_INLINE FourTriples operator-(const FourTriples &a, const FourTriples &b)
  {
    FourTriples d;
    for (int l = 0; l < 4; ++l) d.v[l] = _mm256_sub_pd(a.v[l], b.v[l]);
    return d;
  }
  /// x[l] = scale[l] times the first number of the l-th one, and so on.
  DEFE_INLINE void store_scaled(const double *scale, double *x, double *y, double *z) const
  {
    const __m256d xz01 = _mm256_unpacklo_pd(v[0], v[1]), y01 = _mm256_unpackhi_pd(v[0], v[1]);
    const __m256d xz23 = _mm256_unpacklo_pd(v[2], v[3]), y23 = _mm256_unpackhi_pd(v[2], v[3]);
    const __m256d by = _mm256_loadu_pd(scale);
    _mm256_storeu_pd(x, _mm256_mul_pd(by, _mm256_permute2f128_pd(xz01, xz23, 0x20)));
    _mm256_storeu_pd(y, _mm256_mul_pd(by, _mm256_permute2f128_pd(y01, y23, 0x20)));
    _mm256_storeu_pd(z, _mm256_mul_pd(by, _mm256_permute2f128_pd(xz01, xz23, 0x31)));
  }

 private:
  __m256d v[4];
#else
  DEFE_INLINE explicit FourTriples(const double *const *p)
  {
    for (int l = 0; l < 4; ++l)
      for (int c = 0; c < 3; ++c) v[l][c] = p[l][c];
  }
  friend DEFE_INLINE FourTriples operator-(const FourTriples &a, const FourTriples &b)
  {
    FourTriples d;
    for (int l = 0; l < 4; ++l)
      for (int c = 0; c < 3; ++c) d.v[l][c] = a.v[l][c] - b.v[l][c];
    return d;
  }
  DEFE_INLINE void store_scaled(const double *scale, double *x, double *y, double *z) const
  {
    for (int l = 0; l < 4; ++l) {
      x[l] = scale[l] * v[l][0];
      y[l] = scale[l] * v[l][1];
      z[l] = scale[l] * v[l][2];
    }
  }

 private:
  double v[4][3];
#endif

  FourTriples() = default;
};

/// Four of them, one behind the other in memory.
class TriplesInRow {
 public:
#if defined(__AVX__)
  DEFE_INLINE explicit TriplesInRow(const double *p)
  {
    for (int k = 0; k < 3; ++k) v[k] = _mm256_loadu_pd(p + 4 * k);
  }
  friend DEFE_INLINE TriplesInRow operator-(const TriplesInRow &a, const TriplesInRow &b)
  {
    TriplesInRow d;
    for (int k = 0; k < 3; ++k) d.v[k] = _mm256_sub_pd(a.v[k], b.v[k]);
    return d;
  }
  /// As FourTriples.
  DEFE_INLINE void store_scaled(const double *scale, double *x, double *y, double *z) const
  {
    // x0 y0 x2 y2, z0 x1 z2 x3, y1 z1 y3 z3
    const __m256d xy = _mm256_blend_pd(v[0], v[1], 12);
    const __m256d zx = _mm256_permute2f128_pd(v[0], v[2], 0x21);
    const __m256d yz = _mm256_blend_pd(v[1], v[2], 12), by = _mm256_loadu_pd(scale);
    _mm256_storeu_pd(x, _mm256_mul_pd(by, _mm256_shuffle_pd(xy, zx, 10)));
    _mm256_storeu_pd(y, _mm256_mul_pd(by, _mm256_shuffle_pd(xy, yz, 5)));
    _mm256_storeu_pd(z, _mm256_mul_pd(by, _mm256_shuffle_pd(zx, yz, 10)));
  }

 private:
  __m256d v[3];
#else
  DEFE_INLINE explicit TriplesInRow(const double *p)
  {
    std::copy_n(p, 12, v);
  }
  friend DEFE_INLINE TriplesInRow operator-(const TriplesInRow &a, const TriplesInRow &b)
  {
    TriplesInRow d;
    for (int k = 0; k < 12; ++k) d.v[k] = a.v[k] - b.v[k];
    return d;
  }
  DEFE_INLINE void store_scaled(const double *scale, double *x, double *y, double *z) const
  {
    for (int l = 0; l < 4; ++l) {
      x[l] = scale[l] * v[3 * l];
      y[l] = scale[l] * v[3 * l + 1];
      z[l] = scale[l] * v[3 * l + 2];
    }
  }

 private:
  double v[12];
#endif

  TriplesInRow() = default;
};

/// to: x[0] y[0] z[0] x[1] ... z[3]
DEFE_INLINE void store_in_row(const double *x, const double *y, const double *z, double *to)
{
#if defined(__AVX__)
  const __m256d X = _mm256_loadu_pd(x), Y = _mm256_loadu_pd(y), Z = _mm256_loadu_pd(z);
  const __m256d xy = _mm256_unpacklo_pd(X, Y), zx = _mm256_shuffle_pd(Z, X, 10);
  const __m256d yz = _mm256_unpackhi_pd(Y, Z);
  _mm256_storeu_pd(to, _mm256_permute2f128_pd(xy, zx, 0x20));
  _mm256_storeu_pd(to + 4, _mm256_blend_pd(yz, xy, 12));
  _mm256_storeu_pd(to + 8, _mm256_permute2f128_pd(zx, yz, 0x31));
#else
  for (int l = 0; l < 4; ++l) {
    to[3 * l] = x[l];
    to[3 * l + 1] = y[l];
    to[3 * l + 2] = z[l];
  }
#endif
}

/// to[j][l] = from[l][j], for four by four of them.
DEFE_INLINE void transpose_four(const double *const *from, double *const *to)
{
#if defined(__AVX__)
  __m256d r[4];
  for (int l = 0; l < 4; ++l) r[l] = _mm256_loadu_pd(from[l]);
  const __m256d even01 = _mm256_unpacklo_pd(r[0], r[1]), odd01 = _mm256_unpackhi_pd(r[0], r[1]);
  const __m256d even23 = _mm256_unpacklo_pd(r[2], r[3]), odd23 = _mm256_unpackhi_pd(r[2], r[3]);
  _mm256_storeu_pd(to[0], _mm256_permute2f128_pd(even01, even23, 0x20));
  _mm256_storeu_pd(to[1], _mm256_permute2f128_pd(odd01, odd23, 0x20));
  _mm256_storeu_pd(to[2], _mm256_permute2f128_pd(even01, even23, 0x31));
  _mm256_storeu_pd(to[3], _mm256_permute2f128_pd(odd01, odd23, 0x31));
#else
  for (int l = 0; l < 4; ++l)
    for (int j = 0; j < 4; ++j) to[j][l] = from[l][j];
#endif
}

}    // namespace defe::simd

#endif
