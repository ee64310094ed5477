#ifndef DEFE_SIMD_H
#define DEFE_SIMD_H

/// Packs of doubles for the hot loops: one lane per element. Only for .cpp files and internal
/// headers; the width depends on the compiler's -march, so a Pack must never be part of an
/// interface between separately built parts.
///
/// The vector types of GCC and Clang bring + - * / and comparisons; everything is plain IEEE
/// arithmetic, and lanes never influence each other.

#include <cmath>
#include <utility>

#if defined(__AVX512F__) || defined(__AVX__) || defined(__SSE2__)
#include <immintrin.h>
#endif

namespace defe::simd {

#if defined(__GNUC__)

#if defined(__AVX512F__)
inline constexpr int width = 8;
#elif defined(__AVX__)
inline constexpr int width = 4;
#else
inline constexpr int width = 2;    // SSE2, NEON, VSX
#endif

using Pack = double __attribute__((vector_size(width * sizeof(double))));
using Mask = long long __attribute__((vector_size(width * sizeof(long long))));    // 0 or -1

inline double lane(const Pack &p, int l)
{
  return p[l];
}
inline void set_lane(Pack &p, int l, double v)
{
  p[l] = v;
}
inline bool lane(const Mask &m, int l)
{
  return m[l] != 0;
}
inline Mask inverse(const Mask &m)
{
  return ~m;
}

#else    // one lane at a time

inline constexpr int width = 1;
using Pack = double;
using Mask = bool;

inline double lane(Pack p, int)
{
  return p;
}
inline void set_lane(Pack &p, int, double v)
{
  p = v;
}
inline bool lane(Mask m, int)
{
  return m;
}
inline Mask inverse(Mask m)
{
  return !m;
}

#endif

namespace detail {
template <class F, std::size_t... L>
inline __attribute__((always_inline)) Pack generate(const F &value, std::index_sequence<L...>)
{
  return Pack{value(static_cast<int>(L))...};
}
}    // namespace detail

/// {value(0), value(1), ...}
template <class F> inline __attribute__((always_inline)) Pack generate(const F &value)
{
  return detail::generate(value, std::make_index_sequence<width>());
}

inline Pack broadcast(double v)
{
  return generate([v](int) { return v; });
}

inline Mask always()
{
  return inverse(Mask{});
}

inline Pack select(const Mask &m, const Pack &yes, const Pack &no)
{
  return m ? yes : no;
}

inline Pack max(const Pack &a, const Pack &b)
{
  return a > b ? a : b;
}

inline Pack abs(const Pack &a)
{
  return a < 0.0 ? -a : a;
}

inline Pack sqrt(const Pack &a)
{
#if defined(__AVX512F__)
  return _mm512_maskz_sqrt_pd(0xff, a);    // the plain form makes GCC 12 warn (its bug 105593)
#elif defined(__AVX__)
  return _mm256_sqrt_pd(a);
#elif defined(__SSE2__)
  return _mm_sqrt_pd(a);
#else
  return generate([&a](int l) { return std::sqrt(lane(a, l)); });
#endif
}

/// True if the condition holds in any lane.
inline bool any(const Mask &m)
{
#if defined(__AVX512F__) && defined(__AVX512DQ__)
  return _mm512_movepi64_mask(reinterpret_cast<__m512i>(m)) != 0;
#elif defined(__AVX__)
  return _mm256_movemask_pd(reinterpret_cast<__m256d>(m)) != 0;
#elif defined(__SSE2__)
  return _mm_movemask_pd(reinterpret_cast<__m128d>(m)) != 0;
#elif defined(__GNUC__)
  long long bits = 0;
  for (int l = 0; l < width; ++l) bits |= m[l];
  return bits != 0;
#else
  return m;
#endif
}

}    // namespace defe::simd

#endif
