#ifndef DEFE_COUPLING_SURFACE_FACES_H
#define DEFE_COUPLING_SURFACE_FACES_H

// Part of the search for contacts (surface_search.h): the faces of all elements around.

#include "defe/coupling/surface_search.h"
#include "defe/types.h"

#include <cstddef>
#include <cstdint>
#include <vector>

namespace defe::search {

inline double dist_sq(const double *a, const double *b)
{
  const double x = a[0] - b[0], y = a[1] - b[1], z = a[2] - b[2];
  return x * x + y * y + z * z;
}

/// A face without an element behind it, as it is now.
struct Face {
  std::int64_t id;      // of its element
  int element, face;    // index into SurfaceScene::elements, local number
  bool free;            // not the border to DEs
  int node[4];
  double centre[3], normal[3];
  double extent;       // squared distance of its farthest node
  std::size_t cell;    // for who chooses among them
};

class SurfaceFaces {
 public:
  void build(const SurfaceScene &);
  std::vector<Face> all;
  double extent_max = 0.0;    // of all, not squared

  /// The four edges of a face at which its surface ends or bends sharply, in the reference configuration.
  void find_rims(int face, bool rim[4]);
  /// The faces at a node of this rank do not lie in one plane.
  bool sharp(int node);
  /// The nodes of all faces have numbers, in any order; other particles, which are most, -1.
  int number_of(int particle) const { return number[particle]; }
  int count_of_nodes() const { return static_cast<int>(nodes.size()); }
  /// The faces at a particle: all[at_nodes(k)] from k = first_of(particle) to end_of(particle).
  int first_of(int particle) const { return number[particle] < 0 ? 0 : first_at[number[particle]]; }
  int end_of(int particle) const
  {
    return number[particle] < 0 ? 0 : first_at[number[particle] + 1];
  }
  int at_nodes(int k) const { return faces_at[k]; }

 private:
  const SurfaceScene *scene = nullptr;
  std::vector<int> number;    // by particle; those of the last search are reset, not all
  std::vector<int> nodes;     // particles, by number
  std::vector<int> first_at, faces_at;    // faces at each node
  std::vector<Vec3> normals;              // in the reference configuration
  std::vector<char> normal_known;
  std::vector<char> sharp_node;    // 0 no, 1 yes, 2 not looked at

  void list_by_node();
  const Vec3 &reference_normal(int face);
};

}    // namespace defe::search

#endif
