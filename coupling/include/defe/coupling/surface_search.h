#ifndef DEFE_COUPLING_SURFACE_SEARCH_H
#define DEFE_COUPLING_SURFACE_SEARCH_H

/// \file
/// Contact of surfaces: the search. Finds, on plain arrays, which nodes, DEs and balls may touch which
/// facets before anything has moved by more than half the skin, and fills the tables that
/// surface_forces() works on.
///
/// The rank that owns a node or DE treats it against the facets of all elements around, so that each
/// pair is treated once on any decomposition. Balls, spheres that are no DEs, are treated by the rank
/// that owns the facet's element. The order of candidates, patches and balls is that of IDs: it depends neither
/// on the decomposition nor on the order of particles and elements in memory.

#include "defe/coupling/particles.h"
#include "defe/coupling/surface_forces.h"

#include <cstdint>
#include <memory>
#include <utility>
#include <vector>

namespace defe {

/// An element with a face that no other element covers, of this rank or of one around.
struct SurfaceElement {
  std::int64_t id;
  const int *node;    ///< its eight particles (order: hex_face); the owner of the first one owns it
  double volume;      ///< reference volume
  int part;
  unsigned char bare;    ///< a bit for each face without an element behind it
  unsigned char
      free;    ///< of these, free surface: not the border to the DEs of a converted element
};

/// The DEs of this rank. Where one ends for facets of other parts: its outer face.
struct SurfaceDEs {
  int count = 0;
  const int *particle = nullptr;
  // of each particle
  const double *distance = nullptr;    ///< of the outer face from its centre; 0: no DE. Ghosts, too
  const double *length = nullptr;      ///< A^2/2V: times f_s K the penalty stiffness of that face
  // of each DE
  std::vector<int> part;
  std::vector<double> area;    ///< A, of the outer face
};

/// What the search needs to know of a part's material.
struct SurfacePart {
  bool rigid;
  double bulk;    ///< K, not used for rigid parts
};

/// Ties of DEs to elements; asked only about DEs within reach of a facet. de: index into SurfaceDEs.
class SurfaceTies {
 public:
  virtual ~SurfaceTies() = default;
  /// The DE is tied to this element of `part`, and that tie cannot end before the next search.
  virtual bool lasting(int de, int part, std::int64_t element) const = 0;
  /// Distance of the nearest face that was tied to `part` from the start, HUGE_VAL if there was none. Half of it if that
  /// is a tied surface (tied_quarters.h), which bears pressure itself.
  virtual double tied_face(int de, int part) const = 0;
};

struct SurfaceScene {
  Particles particles;

  std::vector<SurfaceElement> elements;    ///< own ones first, in any order
  SurfaceDEs des;
  /// Spheres that are no DEs are among these particles, owned and ghost; null: among all.
  const std::vector<int> *spheres = nullptr;
  std::vector<SurfacePart> parts;
  /// Parts whose surfaces are glued (tied_surfaces.h): their nodes and facets that were beside each other have no contact.
  std::vector<std::pair<int, int>> tied_parts;
  const SurfaceTies *ties = nullptr;
  double factor = 0.0;    ///< f_s, see penalty_stiffness_per_area()
  double skin = 0.0;
  double element_size =
      0.0;    ///< longest diagonal of all elements: larger balls are tested against every facet
};

/// Keeps its memory from one search to the next: new pages would cost more than the search. It also keeps what it has
/// found: points and facets that are still there, at the same index, and have hardly moved, are near each other as they were, and
/// only the rest is searched for. What comes out is what a whole search finds: what is near is looked for with some room, and
/// then left out as far as it is too far away now.
class SurfaceSearch {
 public:
  SurfaceSearch();
  ~SurfaceSearch();
  SurfaceSearch(const SurfaceSearch &) = delete;
  SurfaceSearch &operator=(const SurfaceSearch &) = delete;

  /// Replaces what is in the tables. Their facets are those that a point or ball may touch, and those of the
  /// nodes among these points; their planes are of the positions now.
  void run(const SurfaceScene &, SurfaceTables &);

  /// Of the elements of the scene: those with a facet that something else was in the neighbourhood of, and those that share
  /// a node with such a facet; 0 or 1. Until anything has moved by half the skin, or there is something new, a search among these
  /// alone finds what one among all does.
  void find_noticed(std::vector<char> &elements) const;

  /// The next search takes nothing from the last one.
  void forget();

  /// Of the DEs, and of the nodes of facets that something is near, those that the last search took nothing from the one
  /// before for.
  int searched_for() const;
  /// Facets that the last search took a closer look at: something else was in the neighbourhood.
  int looked_at() const;

 private:
  struct Work;
  std::unique_ptr<Work> work;
};

/// To check a search that has kept pairs, or that was one among the noticed elements only: whether a whole one among the elements of
/// this scene fills the tables with the same, to the last bit, but for the order of facets.
bool search_agrees(const SurfaceScene &, const SurfaceTables &);

}    // namespace defe

#endif
