#ifndef DEFE_COUPLING_POOL_H
#define DEFE_COUPLING_POOL_H

#include <cstddef>
#include <cstdlib>
#include <new>

#if defined(__linux__)
#include <sys/mman.h>
#endif

namespace defe {

/// Memory for many objects of one type that are made in one place and asked for in another: on large pages, where the
/// system has them, and one after the other. In small pages, scattered, looking up where a page lies takes longer than
/// reading it. It is kept for the next ones. Each thread has its own, since a program may run several LAMMPS.
template <class T> class Pool {
 public:
  static void *take()
  {
    Pool &pool = the();
    if (!pool.free) pool.grow();
    Place *place = pool.free;
    pool.free = place->next;
    return place;
  }
  static void give(void *used)
  {
    if (!used) return;
    auto *place = static_cast<Place *>(used);
    place->next = the().free;
    the().free = place;
  }

 private:
  static constexpr std::size_t PAGE = std::size_t(1) << 21;
  union Place {
    Place *next;
    alignas(T) char object[sizeof(T)];
  };
  struct Slab {
    Slab *before;
    Place place[1];
  };
  static_assert(sizeof(Slab) <= PAGE && alignof(Slab) <= PAGE, "smaller than a large page");
  Place *free = nullptr;
  Slab *slabs = nullptr;    // all of them, to the end of the program

  static Pool &the()
  {
    static thread_local Pool &pool = *new Pool;
    return pool;
  }
  void grow()
  {
    void *page = std::aligned_alloc(PAGE, PAGE);
    if (!page) throw std::bad_alloc();
#if defined(MADV_HUGEPAGE)
    madvise(page, PAGE, MADV_HUGEPAGE);    // a hint only
#endif
    auto *slab = static_cast<Slab *>(page);
    slab->before = slabs;
    slabs = slab;
    const std::size_t n = (PAGE - offsetof(Slab, place)) / sizeof(Place);
    for (std::size_t k = n; k-- > 0;) {
      slab->place[k].next = free;
      free = &slab->place[k];
    }
  }
};

}    // namespace defe

#endif
