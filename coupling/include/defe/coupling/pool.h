#ifndef DEFE_COUPLING_POOL_H
#define DEFE_COUPLING_POOL_H

#include "defe/coupling/large_pages.h"

#include <cstddef>

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
  static constexpr std::size_t PAGE = large_pages::PAGE;
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
    auto *slab = static_cast<Slab *>(large_pages::take(PAGE));
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
