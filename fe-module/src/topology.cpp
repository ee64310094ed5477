#include "defe/fe/topology.h"

#include <algorithm>
#include <sstream>
#include <stdexcept>
#include <unordered_map>

namespace defe::fe {

FaceKey::FaceKey(std::int64_t a, std::int64_t b, std::int64_t c, std::int64_t d) : id{a, b, c, d}
{
  std::sort(id.begin(), id.end());
}

FaceKey::FaceKey(const std::array<std::int64_t, 8> &hex, int face) :
    FaceKey(hex[hex_face[face][0]], hex[hex_face[face][1]], hex[hex_face[face][2]],
            hex[hex_face[face][3]])
{
}

std::size_t FaceKeyHash::operator()(const FaceKey &key) const noexcept
{
  // splitmix64 of each id: ids of neighbouring faces differ in few low bits
  std::uint64_t h = 0;
  for (std::int64_t id : key.id) {
    std::uint64_t z = h + static_cast<std::uint64_t>(id) + 0x9e3779b97f4a7c15ULL;
    z = (z ^ (z >> 30)) * 0xbf58476d1ce4e5b9ULL;
    z = (z ^ (z >> 27)) * 0x94d049bb133111ebULL;
    h = z ^ (z >> 31);
  }
  return static_cast<std::size_t>(h);
}

std::array<int, 4> match_face_nodes(const std::array<std::int64_t, 8> &hex, int face,
                                    const std::array<std::int64_t, 8> &neighbor)
{
  std::array<int, 4> local;
  for (int i = 0; i < 4; ++i) {
    const std::int64_t id = hex[hex_face[face][i]];
    const auto it = std::find(neighbor.begin(), neighbor.end(), id);
    if (it == neighbor.end()) {
      std::ostringstream text;
      text << "node " << id << " of a shared face is missing in the neighbour element";
      throw std::runtime_error(text.str());
    }
    local[i] = static_cast<int>(it - neighbor.begin());
  }
  return local;
}

namespace {

  [[noreturn]] void fail(const std::string &what, const FaceKey &key)
  {
    std::ostringstream text;
    text << what << " (face with nodes " << key.id[0] << " " << key.id[1] << " " << key.id[2] << " "
         << key.id[3] << ")";
    throw std::runtime_error(text.str());
  }

  // Seen from outside one element, a shared face turns the other way round than seen from outside
  // the other one. -1: opposite sense, as it should be; 1: the same sense; 0: the four nodes are not
  // in cyclic order on the neighbour, so the two elements do not share a surface at all.
  int sense(const std::array<int, 4> &neighbor_node, int neighbor_face)
  {
    int position[4];
    for (int i = 0; i < 4; ++i) position[i] = hex_face_position(neighbor_face, neighbor_node[i]);
    const int turn = (position[1] - position[0] + 4) % 4;
    for (int i = 1; i < 4; ++i)
      if ((position[(i + 1) % 4] - position[i] + 4) % 4 != turn) return 0;
    return turn == 1 ? 1 : turn == 3 ? -1 : 0;
  }

}    // namespace

std::vector<std::array<FaceNeighbor, 6>>
match_faces(const std::vector<std::array<std::int64_t, 8>> &hexes)
{
  std::vector<std::array<FaceNeighbor, 6>> result(hexes.size());
  std::unordered_map<FaceKey, std::pair<int, int>> first_owner;
  first_owner.reserve(hexes.size() * 3 + 16);

  for (int e = 0; e < static_cast<int>(hexes.size()); ++e) {
    const auto &hex = hexes[e];

    auto sorted = hex;
    std::sort(sorted.begin(), sorted.end());
    const auto twice = std::adjacent_find(sorted.begin(), sorted.end());
    if (twice != sorted.end()) {
      std::ostringstream text;
      text << "element " << e << " has node " << *twice << " more than once";
      throw std::runtime_error(text.str());
    }

    for (int face = 0; face < 6; ++face) {
      const FaceKey key(hex, face);
      const auto [it, is_first] = first_owner.try_emplace(key, e, face);
      if (is_first) continue;

      const auto [other, other_face] = it->second;
      FaceNeighbor &mine = result[e][face];
      FaceNeighbor &theirs = result[other][other_face];
      if (theirs.element >= 0) {
        std::ostringstream text;
        text << "elements " << other << ", " << theirs.element << " and " << e << " share a face";
        fail(text.str(), key);
      }
      mine = {other, other_face, match_face_nodes(hex, face, hexes[other])};
      theirs = {e, face, match_face_nodes(hexes[other], other_face, hex)};

      const int turn = sense(mine.node, other_face);
      if (turn != -1) {
        std::ostringstream text;
        text << "elements " << other << " and " << e
             << (turn == 1 ? " lie on the same side of a shared face"
                           : " share four nodes that are a face in one order only");
        fail(text.str(), key);
      }
    }
  }
  return result;
}

}    // namespace defe::fe
