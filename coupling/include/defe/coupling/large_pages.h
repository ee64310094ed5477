#ifndef DEFE_COUPLING_LARGE_PAGES_H
#define DEFE_COUPLING_LARGE_PAGES_H

#include <cstddef>
#include <cstdlib>
#include <memory>
#include <new>
#include <vector>

#if defined(__linux__)
#include <sys/mman.h>
#endif

namespace defe {

/// Memory on large pages, where the system has them: a hint only. Where arrays do not fit into the caches, looking up where a small page
/// lies takes as long as reading it.
namespace large_pages {
  constexpr std::size_t PAGE = std::size_t(1) << 21;

  /// \param bytes  a multiple of PAGE; for std::free(). Throws std::bad_alloc.
  inline void *take(std::size_t bytes)
  {
    void *memory = std::aligned_alloc(PAGE, bytes);
    if (!memory) throw std::bad_alloc();
#if defined(MADV_HUGEPAGE)
    madvise(memory, bytes, MADV_HUGEPAGE);
#endif
    return memory;
  }
}    // namespace large_pages

/// For std::vector: arrays of more than two large pages lie on such, smaller ones where all others do.
template <class T> struct LargePages {
  using value_type = T;
  LargePages() = default;
  template <class U> LargePages(const LargePages<U> &) {}

  T *allocate(std::size_t n)
  {
    if (!large(n)) return std::allocator<T>().allocate(n);
    if (n > (static_cast<std::size_t>(-1) - large_pages::PAGE) / sizeof(T)) throw std::bad_alloc();
    const std::size_t pages = (n * sizeof(T) + large_pages::PAGE - 1) / large_pages::PAGE;
    return static_cast<T *>(large_pages::take(pages * large_pages::PAGE));
  }
  void deallocate(T *memory, std::size_t n)
  {
    if (large(n))
      std::free(memory);
    else
      std::allocator<T>().deallocate(memory, n);
  }
  friend bool operator==(const LargePages &, const LargePages &) { return true; }
  friend bool operator!=(const LargePages &, const LargePages &) { return false; }

 private:
  static bool large(std::size_t n) { return n > 2 * large_pages::PAGE / sizeof(T); }
};

template <class T> using LargeVector = std::vector<T, LargePages<T>>;

}    // namespace defe

#endif
