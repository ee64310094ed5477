#ifndef DEFE_FE_TOPOLOGY_H
#define DEFE_FE_TOPOLOGY_H

#include "defe/types.h"

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

namespace defe::fe {

/// Coordinates (or any vector per node) of one hexahedron: column a = node a.
using HexCoords = Eigen::Matrix<double, 3, 8>;

/// Natural coordinates of the nodes; the order is that of Abaqus C3D8 and VTK_HEXAHEDRON.
inline constexpr int hex_sign[8][3] = {{-1, -1, -1}, {1, -1, -1}, {1, 1, -1}, {-1, 1, -1},
                                       {-1, -1, 1},  {1, -1, 1},  {1, 1, 1},  {-1, 1, 1}};

/// Nodes of the faces -xi, +xi, -eta, +eta, -zeta, +zeta; the right-hand normal points outward.
inline constexpr int hex_face[6][4] = {{0, 4, 7, 3}, {1, 2, 6, 5}, {0, 1, 5, 4},
                                       {3, 7, 6, 2}, {0, 3, 2, 1}, {4, 5, 6, 7}};

namespace detail {
  inline constexpr int hex_edge[8][3] = {{1, 3, 4}, {0, 2, 5}, {3, 1, 6}, {2, 0, 7},
                                         {5, 7, 0}, {4, 6, 1}, {7, 5, 2}, {6, 4, 3}};
}

/// The node at the other end of the edge that leaves `node` (0..7) along natural axis 0..2.
constexpr int hex_edge_neighbor(int node, int axis)
{
  return detail::hex_edge[node][axis];
}

/// Position 0..3 of a local node in hex_face[face], -1 if it is not on that face.
constexpr int hex_face_position(int face, int node)
{
  for (int i = 0; i < 4; ++i)
    if (hex_face[face][i] == node) return i;
  return -1;
}

/// A face as one element has it. Id: any integer type.
template <class Id> struct ElementFace {
  Id key[4];     ///< its node IDs in ascending order: the same for both elements
  Id node[4];    ///< in the order of hex_face, outward
  Id element;
  int face;    ///< 0..5

  ElementFace() = default;
  ElementFace(const Id hex[8], int face, Id element) : element(element), face(face)
  {
    for (int i = 0; i < 4; ++i) key[i] = node[i] = hex[hex_face[face][i]];
    std::sort(key, key + 4);
  }
};

namespace detail {
  /// A face that two elements have is behind the one as it is before the other: from there its nodes run the other
  /// way round. Position on `other` of the first node of `mine`; -1 if they run the same way, -2 if the nodes are a
  /// face in one of the two orders only.
  template <class Id> int face_rotation(const ElementFace<Id> &mine, const ElementFace<Id> &other)
  {
    int rotation = 0;
    while (rotation < 3 && other.node[rotation] != mine.node[0]) ++rotation;
    bool back = true, same = true;
    for (int q = 0; q < 4; ++q) {
      back = back && other.node[(rotation - q + 4) % 4] == mine.node[q];
      same = same && other.node[(rotation + q) % 4] == mine.node[q];
    }
    return back ? rotation : same ? -1 : -2;
  }
}    // namespace detail

/// Finds the faces that two elements have, and tells both: match(mine, other, rotation), where rotation is the
/// position on the other's face of the first node of mine. Face: an ElementFace with whatever else is needed.
/// Sorts the faces. Serial and rendezvous search both end here.
/// \return what is wrong, in one line that names elements by ID; "" if nothing is
template <class Face, class Match>
std::string match_faces(std::vector<Face> &faces, const Match &match)
{
  const auto name = [](const Face &f) {
    return std::to_string(f.element);
  };
  const auto same = [](const Face &a, const Face &b) {
    return std::equal(a.key, a.key + 4, b.key);
  };
  std::sort(faces.begin(), faces.end(), [](const Face &a, const Face &b) {
    for (int k = 0; k < 4; ++k)
      if (a.key[k] != b.key[k]) return a.key[k] < b.key[k];
    return a.element < b.element;
  });
  for (std::size_t k = 0; k + 1 < faces.size(); ++k) {
    const Face &a = faces[k], &b = faces[k + 1];
    if (!same(a, b)) continue;
    if (k + 2 < faces.size() && same(b, faces[k + 2]))
      return "Elements " + name(a) + ", " + name(b) + " and " + name(faces[k + 2]) +
          " share one face: the mesh overlaps itself";
    const int rotation = detail::face_rotation(a, b);
    if (rotation < 0)
      return "Elements " + name(a) + " and " + name(b) +
          (rotation == -1
               ? " share a face but lie on the same side of it: one of them is numbered inside out"
               : " share four nodes that are a face in the order of one of them only: the other "
                 "one is "
                 "numbered wrongly");
    match(a, b, rotation);
    match(b, a, detail::face_rotation(b, a));
    ++k;
  }
  return "";
}

/// What lies behind one face of an element.
struct FaceNeighbor {
  int element = -1;    ///< index in the list of hexes, -1 for an outer face
  int face = -1;       ///< which of that element's faces it is
  /// the neighbour's local numbers (0..7) of the nodes hex_face[own face][0..3]
  std::array<int, 4> node = {-1, -1, -1, -1};
};

/// Face neighbours of all hexes: result[e][f] is behind face f of element e. Serial.
/// Throws std::runtime_error, naming elements by index, with the complaint of match_faces() above.
std::vector<std::array<FaceNeighbor, 6>>
match_faces(const std::vector<std::array<std::int64_t, 8>> &hexes);

}    // namespace defe::fe

#endif
