// What a conversion makes of elements and of what is beside them: two elements that share a face, in every
// orientation of both, of which the neighbour converted before, converts now, or converts later.

#include "defe/coupling/conversion_plan.h"
#include "defe/fe/hex8.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>

#include <algorithm>
#include <cmath>
#include <map>
#include <set>

using namespace defe;
using fe::HexCoords;

namespace {

constexpr std::int64_t base = 1000;
using Nodes = std::array<std::int64_t, 8>;

/// The 24 ways to number the nodes of a cube: its rotations.
std::vector<std::array<int, 8>> orientations()
{
  std::vector<std::array<int, 8>> all;
  for (int a = 0; a < 3; a++)
    for (int b = 0; b < 3; b++) {
      if (a == b) continue;
      for (int signs = 0; signs < 4; signs++) {
        Vec3 u = Vec3::Zero(), v = Vec3::Zero();
        u[a] = signs & 1 ? -1.0 : 1.0;
        v[b] = signs & 2 ? -1.0 : 1.0;
        const Vec3 w = u.cross(v);
        std::array<int, 8> numbers;
        for (int k = 0; k < 8; k++) {
          const Vec3 at = fe::hex_sign[k][0] * u + fe::hex_sign[k][1] * v + fe::hex_sign[k][2] * w;
          for (int n = 0; n < 8; n++)
            if ((at - Vec3(fe::hex_sign[n][0], fe::hex_sign[n][1], fe::hex_sign[n][2])).norm() <
                0.1)
              numbers[k] = n;
        }
        all.push_back(numbers);
      }
    }
  return all;
}

/// Node IDs of two cubes beside each other along x: 3 x 2 x 2 nodes.
Nodes nodes_of_cube(int which, const std::array<int, 8> &numbers)
{
  Nodes nodes;
  for (int k = 0; k < 8; k++) {
    const int *sign = fe::hex_sign[numbers[k]];
    nodes[k] = 1 + which + (sign[0] + 1) / 2 + 3 * ((sign[1] + 1) / 2) + 6 * ((sign[2] + 1) / 2);
  }
  return nodes;
}

Vec3 position(std::int64_t node)
{
  const int n = static_cast<int>(node) - 1;
  return Vec3(n % 3, n / 3 % 2, n / 6);
}

/// Two elements, IDs 1 and 2; the DEs of element e have the IDs of lot e + 10.
struct Pair {
  Nodes nodes[2];
  HexNeighbors neighbors[2];
  std::vector<std::array<fe::FaceNeighbor, 6>> faces;

  Pair(const std::array<int, 8> &first, const std::array<int, 8> &second)
  {
    nodes[0] = nodes_of_cube(0, first);
    nodes[1] = nodes_of_cube(1, second);
    faces = fe::match_faces({nodes[0], nodes[1]});
    for (int e = 0; e < 2; e++) {
      neighbors[e] = HexNeighbors();
      for (int f = 0; f < 6; f++) {
        const auto &n = faces[e][f];
        if (n.element < 0) continue;
        neighbors[e].behind[f] = n.element + 1;
        neighbors[e].face[f] = static_cast<signed char>(n.face);
        neighbors[e].rotation[f] =
            static_cast<signed char>(fe::hex_face_position(n.face, n.node[0]));
        neighbors[e].part[f] = static_cast<signed char>(5 + n.element);
      }
    }
  }

  HexCoords coords(int e) const
  {
    HexCoords X;
    for (int a = 0; a < 8; a++) X.col(a) = position(nodes[e][a]);
    return X;
  }
  ConvertingHex converting(int e) const
  {
    ConvertingHex c{};
    c.id = e + 1;
    c.lot = e + 11;
    for (int a = 0; a < 8; a++) {
      c.node[a] = nodes[e][a];
      for (int k = 0; k < 3; k++) c.x[a][k] = position(nodes[e][a])[k];
    }
    return c;
  }
  ElementSplit split;
  std::vector<NewDE> eight(int e) const
  {
    const HexCoords X = coords(e);
    return convert_hex(X, X, HexCoords::Zero(), 1.0, split);
  }
  std::vector<PlannedDE> births(const ConversionPlan &plan, int e) const
  {
    return plan.births(converting(e), neighbors[e], eight(e), split);
  }
  /// Of the face that is shared.
  int face(int e) const
  {
    for (int f = 0; f < 6; f++)
      if (faces[e][f].element >= 0) return f;
    return -1;
  }
};

/// All DEs of both, by ID, with their places.
struct World {
  std::map<std::int64_t, PlannedDE> de;
  std::map<std::int64_t, Vec3> place;

  ElementSplit split;

  void add(const std::vector<PlannedDE> &planned, const std::vector<NewDE> &eight)
  {
    for (int k = 0; k < split.des(); k++) {
      EXPECT_EQ(de.count(planned[k].id), 0u) << "an ID twice";
      de[planned[k].id] = planned[k];
      place[planned[k].id] = eight[k].X;
    }
  }

  /// Every joint is one of two neighbours, along the slot's direction, and is known by both.
  void expect_whole() const
  {
    int across = 0;
    for (const auto &one : de)
      for (int s = 0; s < 6; s++) {
        const auto &slot = one.second.slot[s];
        if (slot.kind != PlannedSlot::JOINT) continue;
        const auto other = de.find(slot.other);
        ASSERT_NE(other, de.end());
        EXPECT_NEAR((place.at(slot.other) - place.at(one.first)).norm(), 1.0 / split.along(),
                    1e-12);
        const auto &back = other->second.slot[static_cast<int>(slot.partner)];
        EXPECT_EQ(back.kind, PlannedSlot::JOINT);
        EXPECT_EQ(back.other, one.first);
        EXPECT_EQ(static_cast<int>(back.partner), s);
        const int lot = split.des();
        across += (one.first - base - 1) / lot != (slot.other - base - 1) / lot;
      }
    EXPECT_EQ(across, 2 * split.along() * split.along())
        << "the joints through the face, seen from both sides";
  }
};

template <class Check> void for_all_orientations(const Check &check)
{
  const auto all = orientations();
  ASSERT_EQ(all.size(), 24u);
  ASSERT_EQ(std::set(all.begin(), all.end()).size(), 24u);
  for (size_t a = 0; a < all.size(); a++)
    for (size_t b = 0; b < all.size(); b++) {
      SCOPED_TRACE(std::to_string(a) + " " + std::to_string(b));
      check(Pair(all[a], all[b]));
    }
}

}    // namespace

TEST(ConversionPlan, BothNow)
{
  for_all_orientations([](const Pair &pair) {
    const ConversionPlan plan(base, {pair.converting(0), pair.converting(1)});
    World world;
    for (int e = 0; e < 2; e++) world.add(pair.births(plan, e), pair.eight(e));
    world.expect_whole();
    for (const auto &one : world.de)
      for (const auto &slot : one.second.slot) EXPECT_FALSE(slot.to_older);
  });
}

// First one, whose DEs are tied to the other; then that one, whose DEs take the places of the ties.
TEST(ConversionPlan, TheNeighborLater)
{
  for_all_orientations([](Pair pair) {
    World world;
    const ConversionPlan first(base, {pair.converting(0)});
    world.add(pair.births(first, 0), pair.eight(0));
    const int face = pair.face(1);

    int ties = 0;
    for (auto &one : world.de) {
      const int corner = static_cast<int>(one.first - base - 1) % 8;
      for (auto &slot : one.second.slot) {
        if (slot.kind != PlannedSlot::TIE) continue;
        ties++;
        EXPECT_EQ(slot.other, 2);
        EXPECT_EQ(static_cast<int>(slot.part), 6);
        EXPECT_EQ(static_cast<int>(slot.partner), face);
        EXPECT_EQ(slot.face_node[0], pair.nodes[0][corner]) << "begins at its own corner";
        EXPECT_EQ(pair.nodes[1][static_cast<int>(slot.corner)], pair.nodes[0][corner]);
        std::set<std::int64_t> of_face, of_slot(slot.face_node, slot.face_node + 4);
        for (int node : fe::hex_face[face]) of_face.insert(pair.nodes[1][node]);
        EXPECT_EQ(of_slot, of_face);
        // 9/16, 3/16, 1/16, 3/16: the third is the opposite one
        EXPECT_NEAR((position(slot.face_node[2]) - position(slot.face_node[0])).norm(),
                    std::sqrt(2.0), 1e-12);
      }
    }
    EXPECT_EQ(ties, 4);

    HexNeighbors &stays = pair.neighbors[1];
    for (auto &behind : stays.behind) behind = first.behind_now(behind);
    EXPECT_EQ(stays.behind[face], -11);

    const ConversionPlan second(base, {pair.converting(1)});
    for (auto &one : world.de)
      for (auto &slot : one.second.slot) {
        if (slot.kind != PlannedSlot::TIE) continue;
        slot.kind = PlannedSlot::JOINT;
        slot.other = second.joint_of_tie(slot.other, slot.corner);
      }
    const auto planned = pair.births(second, 1);
    int older = 0;
    for (const auto &de : planned)
      for (const auto &slot : de.slot) older += slot.to_older;
    EXPECT_EQ(older, 4);
    world.add(planned, pair.eight(1));
    world.expect_whole();
  });
}

// One and 27 DEs for an element: the same, and ties end at the middles of patches.
TEST(ConversionPlan, OtherSplits)
{
  for (int along : {1, 3})
    for_all_orientations([along](Pair pair) {
      const ElementSplit split(along);
      pair.split = split;
      World now, later;
      now.split = later.split = split;
      const ConversionPlan both(base, {pair.converting(0), pair.converting(1)}, split.des());
      for (int e = 0; e < 2; e++) now.add(pair.births(both, e), pair.eight(e));
      now.expect_whole();

      const ConversionPlan first(base, {pair.converting(0)}, split.des());
      later.add(pair.births(first, 0), pair.eight(0));
      pair.neighbors[1].behind[pair.face(1)] = first.behind_now(1);
      const ConversionPlan second(base, {pair.converting(1)}, split.des());
      int ties = 0;
      for (auto &one : later.de)
        for (int s = 0; s < 6; s++) {
          PlannedSlot &slot = one.second.slot[s];
          if (slot.kind != PlannedSlot::TIE) continue;
          ties++;
          Vec3 end = Vec3::Zero();
          const int place = static_cast<int>((one.first - base - 1) % split.des());
          for (int a = 0; a < 4; a++)
            end += weights_of(split.spot(place, s))[a] * position(slot.face_node[a]);
          const Vec3 face = pair.eight(0)[place].X + pair.eight(0)[place].face[s];
          EXPECT_NEAR((end - face).norm(), 0.0, 1e-14);
          slot.kind = PlannedSlot::JOINT;
          slot.other = second.joint_of_tie(slot.other, split.place_of_code(slot.corner));
        }
      EXPECT_EQ(ties, along * along);
      later.add(pair.births(second, 1), pair.eight(1));
      later.expect_whole();
    });
}

// Both elements of a face ask whether a tie has turned too far, from the nodes that they list: one answer.
TEST(ConversionPlan, BothSidesOfATieSeeItTurnAlike)
{
  for (int along : {1, 2, 3})
    for_all_orientations([along](Pair pair) {
      const ElementSplit split(along);
      pair.split = split;
      const ConversionPlan first(base, {pair.converting(0)}, split.des());
      const auto old = pair.births(first, 0);
      pair.neighbors[1].behind[pair.face(1)] = first.behind_now(1);
      const ConversionPlan second(base, {pair.converting(1)}, split.des());
      const auto born = pair.births(second, 1);
      const auto moved = [](std::int64_t node) {    // a face that is no square any more
        const Vec3 X = position(node);
        return Vec3(X[0] + 0.1 * X[1] * X[2], 1.1 * X[1] + 0.2 * X[2], 0.9 * X[2] - 0.1 * X[1]);
      };
      const auto turned = [&](const PlannedSlot &slot, TieSpot spot) {
        Vec3 X[4], x[4];
        for (int a = 0; a < 4; a++) {
          X[a] = position(slot.face_node[a]);
          x[a] = moved(slot.face_node[a]);
        }
        return tie_rotation(Vec3(0.8, 0.3, 0.4), Vec3(0.7, 0.5, 0.2), X, x, spot);
      };
      int seen = 0;
      for (int k = 0; k < split.des(); k++)
        for (int s = 0; s < 6; s++) {
          const PlannedSlot &tie = old[k].slot[s];
          if (tie.kind != PlannedSlot::TIE) continue;
          const int place = split.place_of_code(tie.corner);
          const double its = turned(born[place].slot[tie.partner], split.spot(place, tie.partner));
          EXPECT_NEAR(turned(tie, split.spot(k, s)), its, 1e-14);
          seen++;
        }
      EXPECT_EQ(seen, along * along);
    });
}

TEST(ConversionPlan, WhatStaysIsLeftAlone)
{
  const auto numbers = orientations().front();
  const Pair pair(numbers, numbers);
  const ConversionPlan plan(base, {pair.converting(0)});
  EXPECT_NE(plan.converting(1), nullptr);
  EXPECT_EQ(plan.converting(2), nullptr);
  EXPECT_EQ(plan.joint_of_tie(2, 3), 0);
  for (std::int64_t behind : {0, -7, 2, 77}) EXPECT_EQ(plan.behind_now(behind), behind);
  EXPECT_EQ(plan.behind_now(1), -11);
}

TEST(ConversionPlan, FreeFacesEndTheSphere)
{
  const auto numbers = orientations().front();
  const Pair pair(numbers, numbers);
  const ConversionPlan plan(base, {pair.converting(0)});
  for (const auto &de :
       pair.births(plan, 0)) {    // a cube: every DE has a free face, a quarter away
    EXPECT_DOUBLE_EQ(de.outer_distance, 0.25);
    EXPECT_DOUBLE_EQ(de.outer_area, 0.25);
    int free = 0, ties = 0;
    for (const auto &slot : de.slot) {
      free += slot.kind == PlannedSlot::FREE;
      ties += slot.kind == PlannedSlot::TIE;
    }
    EXPECT_EQ(free + ties, 3);
  }
  // inside of a body it is a sphere of its own radius
  HexNeighbors inside = pair.neighbors[0];
  for (auto &behind : inside.behind) behind = 5;
  const auto eight = pair.eight(0);
  for (const auto &de : plan.births(pair.converting(0), inside, eight)) {
    EXPECT_DOUBLE_EQ(de.outer_distance, eight[0].radius);
    EXPECT_DOUBLE_EQ(de.outer_area, 4.0 * eight[0].radius * eight[0].radius);
  }
}

// A flat element: the nearest of its free faces, whichever slot it has.
TEST(ConversionPlan, NearestFreeFaceOfAFlatElement)
{
  for (const auto &numbers : orientations()) {
    const Pair pair(numbers, numbers);
    HexCoords flat = pair.coords(0);
    flat.row(1) *= 0.1;
    HexNeighbors alone{};
    const ConversionPlan plan(base, {pair.converting(0)});
    const auto eight = convert_hex(flat, flat, HexCoords::Zero(), 1.0);
    for (const auto &de : plan.births(pair.converting(0), alone, eight)) {
      EXPECT_NEAR(de.outer_distance, 0.025, 1e-12);
      EXPECT_NEAR(de.outer_area, 0.25, 1e-12);
    }
  }
}

// What presses on an element's face presses on that of its DEs, whatever they will be at rest.
TEST(ConversionPlan, FreeFacesOfACompressedElement)
{
  const auto numbers = orientations().front();
  const Pair pair(numbers, numbers);
  const HexCoords X = pair.coords(0);
  const Mat3 turn = Eigen::AngleAxisd(0.7, Vec3(1.0, 2.0, 3.0).normalized()).toRotationMatrix();
  const HexCoords x = turn * Vec3(1.01, 0.9, 1.02).asDiagonal() * X;
  HexNeighbors alone{};
  const ConversionPlan plan(base, {pair.converting(0)});
  for (const auto &de :
       plan.births(pair.converting(0), alone, convert_hex(X, x, HexCoords::Zero(), 1.0)))
    EXPECT_NEAR(de.outer_distance, 0.9 * 0.25, 1e-15);
}

TEST(ConversionPlan, AroundAnElementEachOnce)
{
  const auto numbers = orientations()[7];
  const Pair pair(numbers, numbers);
  const ConversionPlan both(base, {pair.converting(0), pair.converting(1)});
  const auto around = both.around(pair.nodes[0].data());
  ASSERT_EQ(around.size(), 2u);
  const std::int64_t far[8] = {31, 32, 33, 34, 35, 36, 37, 38};
  EXPECT_TRUE(both.around(far).empty());
  std::set<std::int64_t> nodes;
  both.for_nodes([&](std::int64_t node) {
    EXPECT_TRUE(nodes.insert(node).second);
  });
  EXPECT_EQ(nodes.size(), 12u);
  EXPECT_NEAR((direction_to(pair.converting(1), Vec3(0.5, 0.5, 0.5)) - Vec3(1, 0, 0)).norm(), 0.0,
              1e-15);
}

// Nodes lose what the DEs get.
TEST(ConversionPlan, SharesOfMass)
{
  const auto numbers = orientations().front();
  double mass = 0.0;
  for (const auto &de : Pair(numbers, numbers).eight(0)) mass += de.mass;
  EXPECT_DOUBLE_EQ(mass, 8 * ConversionPlan::node_share);
}
