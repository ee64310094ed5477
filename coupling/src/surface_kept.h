#ifndef DEFE_COUPLING_SURFACE_KEPT_H
#define DEFE_COUPLING_SURFACE_KEPT_H

// Part of the search for contacts (surface_search.h): what of the last search still holds. A conversion changes few
// faces, and nothing moves far between two of them.

#include "surface_facets.h"

#include <cstddef>
#include <cstdint>
#include <utility>
#include <vector>

namespace defe::search {

class KeptSearch {
 public:
  // What is near is looked for with some room, so that it holds while neither point nor facet moves by more than `slack`
  // skins, or turns by more than `turn`. Since two met, each may have done so twice: once before, once after. What
  // the limits of ContactPoints then change by is at most 8 times slack (a distance by 4, and with it the sizes of both, which
  // count up to 1.5 times), and a cosine by 4 times turn.
  static constexpr double slack = 0.04, turn = 0.01;
  static constexpr double skins = 1.0 + 8.0 * slack;
  static constexpr double facing_kept = facing - 5.0 * turn;

  /// The next search is a whole one.
  void forget()
  {
    marks.clear();
    known.clear();
  }
  void compare(const SurfaceScene &, const SurfaceFaces &, const ContactFacets &);

  /// A node of a facet, or a DE: it has the index that it had, has hardly moved, and all faces at it are those that
  /// were there.
  bool still(int particle) const
  {
    const Mark *mark = find(marks, particle);
    return mark && mark->still;
  }
  /// A facet with four such nodes: its index in the last search and in this one. -1: there is none.
  int facet_before(int now) const { return before[now]; }
  int facet_now(int before) const { return now[before]; }
  /// Facets that the last search has not looked at, or that have changed.
  const std::vector<int> &new_facets() const { return fresh; }

 private:
  struct Mark {
    int particle;
    int facet;    // of the last search, one whose first node it is, -1: none
    bool still;
    std::int64_t id;
    std::uint64_t faces;    // sum over the names of those at it
    double place[3];        // where it was when it was searched for
  };
  std::vector<Mark> marks, marks_before;
  std::vector<int> mark_at;    // by particle, of those that have one
  const Mark *find(const std::vector<Mark> &list, int particle) const
  {
    const auto at = static_cast<std::size_t>(mark_at[particle]);
    return at < list.size() && list[at].particle == particle ? &list[at] : nullptr;
  }
  struct Known {
    std::int64_t element;
    int face, next;      // next: one with the same first node
    double normal[3];    // when it was searched for
  };
  std::vector<Known> known, known_before;
  std::vector<int> before, now, fresh;    // facets

  struct Settings {
    double skin = 0.0, factor = 0.0;
    std::vector<SurfacePart> parts;
    std::vector<std::pair<int, int>> tied_parts;
  } settings;
  bool same_settings(const SurfaceScene &);
  void look_at(int particle, const SurfaceScene &, const SurfaceFaces &);
  int find_before(const Face &) const;
};

}    // namespace defe::search

#endif
