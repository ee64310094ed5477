#include "defe/fe/topology.h"

#include <stdexcept>

namespace defe::fe {

std::vector<std::array<FaceNeighbor, 6>>
match_faces(const std::vector<std::array<std::int64_t, 8>> &hexes)
{
  std::vector<std::array<FaceNeighbor, 6>> result(hexes.size());
  std::vector<ElementFace<std::int64_t>> faces;
  for (std::size_t e = 0; e < hexes.size(); ++e)
    for (int face = 0; face < 6; ++face)
      faces.emplace_back(hexes[e].data(), face, static_cast<std::int64_t>(e));
  const auto complaint =
      match_faces(faces, [&result](const auto &mine, const auto &other, int rotation) {
        FaceNeighbor &n = result[mine.element][mine.face];
        n.element = static_cast<int>(other.element);
        n.face = other.face;
        for (int i = 0; i < 4; ++i) n.node[i] = hex_face[other.face][(rotation - i + 4) % 4];
      });
  if (!complaint.empty()) throw std::runtime_error(complaint);
  return result;
}

}    // namespace defe::fe
