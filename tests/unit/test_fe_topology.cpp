// Node, edge and face numbering of the hexahedron, and the matching of faces in a mesh.

#include "test_fe_common.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <set>
#include <stdexcept>

using namespace defe;
using namespace defe::fe;
using namespace defe::fe::test;

namespace {

using Hex = std::array<std::int64_t, 8>;

TEST(Topology, FaceNormalsPointOutward)
{
  const HexCoords X = box(2.0, 2.0, 2.0).colwise() - Vec3::Ones();
  for (int face = 0; face < 6; ++face) {
    const Vec3 outward = (face % 2 ? 1.0 : -1.0) * Vec3::Unit(face / 2);
    for (int i = 0; i < 4; ++i) {
      const Vec3 here = X.col(hex_face[face][i]), next = X.col(hex_face[face][(i + 1) % 4]),
                 last = X.col(hex_face[face][(i + 3) % 4]);
      EXPECT_EQ(here.dot(outward), 1.0);
      EXPECT_EQ(((next - here).cross(last - here) / 4.0 - outward).norm(), 0.0);
    }
  }
}

TEST(Topology, EdgeNeighborDiffersInOneCoordinate)
{
  for (int a = 0; a < 8; ++a)
    for (int axis = 0; axis < 3; ++axis) {
      const int b = hex_edge_neighbor(a, axis);
      for (int k = 0; k < 3; ++k)
        EXPECT_EQ(hex_sign[b][k], k == axis ? -hex_sign[a][k] : hex_sign[a][k]);
      EXPECT_EQ(hex_edge_neighbor(b, axis), a);
    }
}

TEST(Topology, FacePositionInvertsTheFaceTable)
{
  for (int face = 0; face < 6; ++face)
    for (int a = 0; a < 8; ++a) {
      const int position = hex_face_position(face, a);
      const bool on_face = hex_sign[a][face / 2] == (face % 2 ? 1 : -1);
      EXPECT_EQ(position >= 0, on_face);
      if (on_face) { EXPECT_EQ(hex_face[face][position], a); }
    }
}

// The 24 ways to number the same hexahedron: rotations of the cube.
std::vector<std::array<int, 8>> numberings()
{
  std::vector<std::array<int, 8>> result;
  for (int x = 0; x < 3; ++x)
    for (int y = 0; y < 3; ++y)
      for (int sx : {-1, 1})
        for (int sy : {-1, 1}) {
          if (x == y) continue;
          Vec3 ex = sx * Vec3::Unit(x), ey = sy * Vec3::Unit(y), ez = ex.cross(ey);
          std::array<int, 8> map;
          for (int a = 0; a < 8; ++a) {
            const Vec3 p = hex_sign[a][0] * ex + hex_sign[a][1] * ey + hex_sign[a][2] * ez;
            for (int b = 0; b < 8; ++b)
              if (hex_sign[b][0] == p[0] && hex_sign[b][1] == p[1] && hex_sign[b][2] == p[2])
                map[a] = b;
          }
          result.push_back(map);
        }
  return result;
}

TEST(MatchFaces, GridWithArbitraryLocalAxes)
{
  // 3 x 4 x 5 cells, ids with gaps, every element numbered in another of the 24 ways
  const int nx = 3, ny = 4, nz = 5;
  const auto orders = numberings();
  ASSERT_EQ(orders.size(), 24u);
  const auto id = [=](int i, int j, int k) {
    return std::int64_t(10) * ((k * (ny + 1) + j) * (nx + 1) + i) + 3;
  };
  Random random(1);
  std::vector<Hex> hexes;
  for (int k = 0; k < nz; ++k)
    for (int j = 0; j < ny; ++j)
      for (int i = 0; i < nx; ++i) {
        const auto &order = orders[static_cast<int>(random.uniform(0.0, 24.0))];
        Hex hex;
        for (int a = 0; a < 8; ++a) {
          const int *s = hex_sign[order[a]];
          hex[a] = id(i + (s[0] + 1) / 2, j + (s[1] + 1) / 2, k + (s[2] + 1) / 2);
        }
        hexes.push_back(hex);
      }

  const auto neighbors = match_faces(hexes);
  ASSERT_EQ(neighbors.size(), hexes.size());
  int inner = 0, outer = 0;
  for (int e = 0; e < int(hexes.size()); ++e)
    for (int face = 0; face < 6; ++face) {
      const FaceNeighbor &n = neighbors[e][face];
      if (n.element < 0) {
        ++outer;
        continue;
      }
      ++inner;
      EXPECT_NE(n.element, e);
      EXPECT_EQ(neighbors[n.element][n.face].element, e);
      EXPECT_EQ(neighbors[n.element][n.face].face, face);
      for (int i = 0; i < 4; ++i) {
        EXPECT_EQ(hexes[n.element][n.node[i]], hexes[e][hex_face[face][i]]);
        EXPECT_GE(hex_face_position(n.face, n.node[i]), 0);
      }
      // the neighbours of a cell are at distance 1 in the grid
      const int d = std::abs(n.element - e);
      EXPECT_TRUE(d == 1 || d == nx || d == nx * ny);
    }
  EXPECT_EQ(outer, 2 * (nx * ny + ny * nz + nx * nz));
  EXPECT_EQ(inner, 2 * ((nx - 1) * ny * nz + nx * (ny - 1) * nz + nx * ny * (nz - 1)));
}

const Hex below = {0, 1, 2, 3, 4, 5, 6, 7};
const Hex above = {4, 5, 6, 7, 8, 9, 10, 11};

std::string complaint(const std::vector<Hex> &hexes)
{
  try {
    match_faces(hexes);
  } catch (const std::runtime_error &e) {
    return e.what();
  }
  return "";
}

TEST(MatchFaces, RefusesThreeElementsAtAFace)
{
  EXPECT_EQ(complaint({below, above}), "");
  const std::string text = complaint({below, above, {4, 5, 6, 7, 12, 13, 14, 15}});
  EXPECT_THAT(text, testing::HasSubstr("Elements 0, 1 and 2 share one face"));
}

TEST(MatchFaces, RefusesElementsThatDoNotFitTogether)
{
  // two elements on the same side of 4 5 6 7: one of them is inside out
  EXPECT_THAT(complaint({below, {8, 9, 10, 11, 4, 5, 6, 7}}), testing::HasSubstr("same side"));
  // the same four nodes, but as a quadrilateral 4-6-5-7
  EXPECT_THAT(complaint({below, {4, 6, 5, 7, 8, 9, 10, 11}}),
              testing::HasSubstr("in the order of one of them only"));
}

}    // namespace
