#ifndef DEFE_FE_TOPOLOGY_H
#define DEFE_FE_TOPOLOGY_H

#include "defe/types.h"

#include <array>
#include <cstddef>
#include <cstdint>
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

/// The face opposite to `face`.
constexpr int hex_opposite_face(int face)
{
  return face ^ 1;
}

/// A face of a mesh, whoever looks at it: its four node ids in ascending order.
struct FaceKey {
  std::array<std::int64_t, 4> id;

  FaceKey(std::int64_t a, std::int64_t b, std::int64_t c, std::int64_t d);

  /// Face 0..5 of the hexahedron with these eight node ids.
  FaceKey(const std::array<std::int64_t, 8> &hex, int face);

  bool operator==(const FaceKey &other) const { return id == other.id; }
  bool operator!=(const FaceKey &other) const { return id != other.id; }
  bool operator<(const FaceKey &other) const { return id < other.id; }
};

struct FaceKeyHash {
  std::size_t operator()(const FaceKey &key) const noexcept;
};

/// What lies behind one face of an element.
struct FaceNeighbor {
  int element = -1;    ///< index in the list of hexes, -1 for an outer face
  int face = -1;       ///< which of that element's faces it is
  /// the neighbour's local numbers (0..7) of the nodes hex_face[own face][0..3]
  std::array<int, 4> node = {-1, -1, -1, -1};
};

/// The neighbour's local numbers of the four nodes of `face`, in the order of hex_face[face].
/// Throws std::runtime_error if the neighbour does not have all four.
std::array<int, 4> match_face_nodes(const std::array<std::int64_t, 8> &hex, int face,
                                    const std::array<std::int64_t, 8> &neighbor);

/// Face neighbours of all hexes: result[e][f] is behind face f of element e. Serial, O(elements).
/// Throws std::runtime_error, naming elements by index and nodes by id, if three elements share a
/// face, if an element has a node twice, or if two elements lie on the same side of a shared face
/// (only the order of the nodes is looked at, not coordinates).
std::vector<std::array<FaceNeighbor, 6>>
match_faces(const std::vector<std::array<std::int64_t, 8>> &hexes);

}    // namespace defe::fe

template <> struct std::hash<defe::fe::FaceKey> : defe::fe::FaceKeyHash {
};

#endif
