#ifndef DEFE_COUPLING_PREFETCH_H
#define DEFE_COUPLING_PREFETCH_H

#include <cstddef>

namespace defe {

/// Asks the memory for what a loop needs some turns later: records of DEs and their neighbours are far apart, and waiting
/// for one after the other takes longer than what is computed of them. Null, for what is not there, asks for nothing.
template <class T> inline void prefetch(const T *what)
{
  if (!what) return;
  constexpr std::size_t line = 64;
  const char *const first = reinterpret_cast<const char *>(what);
  for (std::size_t k = 0; k < sizeof(T); k += line) __builtin_prefetch(first + k);
  // records do not begin where lines do
  if constexpr (sizeof(T) > alignof(T)) __builtin_prefetch(first + sizeof(T) - 1);
}

}    // namespace defe

#endif
