#ifndef DEFE_SIMD_H
#define DEFE_SIMD_H

/// Packs of doubles for hot loops, one element (or particle) per lane. Only for .cpp files and
/// internal headers: the width depends on the compiler's -march, so a Pack must never be part of an
/// interface between separately built parts.
///
/// The vector types of GCC, Clang and compilers compatible with them bring + - * / and comparisons.
/// Everything is plain IEEE arithmetic, and lanes never influence each other.

#include <cmath>
#include <cstddef>
#include <utility>

#if defined(__SSE2__)
#include <immintrin.h>
#endif

#if !defined(__GNUC__)
#error "defe/simd.h needs the vector extensions of GCC or Clang"
#endif

#define DEFE_INLINE inline __attribute__((always_inline))

namespace defe::simd {

#if defined(__AVX512F__) && defined(__AVX512DQ__)
inline constexpr int width = 8;
#elif defined(__AVX__)
inline constexpr int width = 4;
#else
inline constexpr int width = 2;    // SSE2, NEON, VSX
#endif

using Pack = double __attribute__((vector_size(width * sizeof(double))));
using Mask = long long __attribute__((vector_size(width * sizeof(long long))));    // 0 or -1

namespace detail {
  template <class F, std::size_t... L>
  DEFE_INLINE Pack generate(const F &value, std::index_sequence<L...>)
  {
    return Pack{value(static_cast<int>(L))...};
  }
}    // namespace detail

/// {value(0), value(1), ...}
template <class F> DEFE_INLINE Pack generate(const F &value)
{
  return detail::generate(value, std::make_index_sequence<width>());
}

DEFE_INLINE Pack broadcast(double v)
{
  return generate([v](int) {
    return v;
  });
}

DEFE_INLINE Pack max(const Pack &a, const Pack &b)
{
  return a > b ? a : b;
}

DEFE_INLINE Pack abs(const Pack &a)
{
  return reinterpret_cast<Pack>(reinterpret_cast<Mask>(a) &
                                0x7fffffffffffffffLL);    // all but the sign
}

DEFE_INLINE Pack sqrt(const Pack &a)
{
#if defined(__AVX512F__) && defined(__AVX512DQ__)
  return _mm512_maskz_sqrt_pd(0xff, a);    // the plain form makes GCC 12 warn (its bug 105593)
#elif defined(__AVX__)
  return _mm256_sqrt_pd(a);
#elif defined(__SSE2__)
  return _mm_sqrt_pd(a);
#else
  return generate([&a](int l) {
    return std::sqrt(a[l]);
  });
#endif
}

/// Two numbers that lie side by side, wherever they are.
struct Pair {
  using Vector = double __attribute__((vector_size(2 * sizeof(double))));
  using InMemory = double
      __attribute__((vector_size(2 * sizeof(double)), aligned(sizeof(double)), may_alias));
  Vector v;

  static DEFE_INLINE Pair load(const double *from)
  {
    return {*reinterpret_cast<const InMemory *>(from)};
  }
  DEFE_INLINE void store(double *to) const { *reinterpret_cast<InMemory *>(to) = v; }
  friend DEFE_INLINE Pair operator+(const Pair &a, const Pair &b) { return {a.v + b.v}; }
};

/// True if the condition holds in any lane.
DEFE_INLINE bool any(const Mask &m)
{
#if defined(__AVX512F__) && defined(__AVX512DQ__)
  return _mm512_movepi64_mask(reinterpret_cast<__m512i>(m)) != 0;
#elif defined(__AVX__)
  return _mm256_movemask_pd(reinterpret_cast<__m256d>(m)) != 0;
#elif defined(__SSE2__)
  return _mm_movemask_pd(reinterpret_cast<__m128d>(m)) != 0;
#else
  long long bits = 0;
  for (int l = 0; l < width; ++l) bits |= m[l];
  return bits != 0;
#endif
}

/// Bit l: the condition holds in lane l.
DEFE_INLINE unsigned bits(const Mask &m)
{
#if defined(__AVX512F__) && defined(__AVX512DQ__)
  return _mm512_movepi64_mask(reinterpret_cast<__m512i>(m));
#elif defined(__AVX__)
  return static_cast<unsigned>(_mm256_movemask_pd(reinterpret_cast<__m256d>(m)));
#elif defined(__SSE2__)
  return static_cast<unsigned>(_mm_movemask_pd(reinterpret_cast<__m128d>(m)));
#else
  unsigned all = 0;
  for (int l = 0; l < width; ++l) all |= m[l] ? 1u << l : 0u;
  return all;
#endif
}

}    // namespace defe::simd

#endif
