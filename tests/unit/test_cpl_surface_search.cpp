// The search for contacts of surfaces: which facets are looked at, their geometry, rims and sharp edges, what is
// left out. That no contact is missed: test_cpl_surface_all_pairs.cpp.

#include "defe/coupling/surface_search.h"

#include "surface_world.h"

#include <gtest/gtest.h>

using namespace defe;
using namespace defe::test;

namespace {

constexpr double pi = 3.14159265358979323846;
constexpr int edge_nodes[4][2] = {{1, 2}, {3, 0}, {2, 3}, {0, 1}};    // at xi = 1, -1, eta = 1, -1

/// What is at x > 0 slopes downwards.
SurfaceWorld::Map bent(double degrees, const Vec3 &by)
{
  const double slope = std::tan(degrees * pi / 180.0);
  return [=](const Vec3 &at) {
    const Vec3 x = at + by;
    return Vec3(x[0], x[1], x[2] - slope * std::max(x[0], 0.0));
  };
}

/// Rims and sharp nodes of the upper side of a block of 6 x 6 x 3 that bends at x = 0, under an anvil.
struct Bend {
  int rims = 0, no_rims = 0, sharp = 0, smooth = 0;    // at the bend
  int wrong = 0;                                       // elsewhere at x < 0
  explicit Bend(double degrees, bool bent_later = false)
  {
    SurfaceWorld w;
    const auto map = bent(degrees, Vec3(-3, 0, -3));
    w.add_block(0, {6, 6, 3}, 1.0, bent_later ? shift(Vec3(-3, 0, -3)) : map);
    if (bent_later)
      for (auto &p : w.particles) p.x = map(p.X + Vec3(3, 0, 3));
    w.add_block(1, {2, 2, 1}, 2.9, shift(Vec3(-2.92, 0.13, 0.03)));
    w.search();
    const auto at_bend = [](const Vec3 &X) {
      return std::abs(X[0]) < 1e-9;
    };
    const auto at_end = [](const Vec3 &X, int d) {
      return d == 0 ? X[0] < -3 + 1e-9 : X[1] < 1e-9 || X[1] > 6 - 1e-9;
    };
    for (size_t k = 0; k < w.tables.facets.size(); ++k) {
      const ContactFacet &f = w.tables.facets[k];
      if (f.part != 0 || w.tables.planes[k].normal[2] < 0.5) continue;
      for (int e = 0; e < 4; ++e) {
        const Vec3 a = w.particles[f.node[edge_nodes[e][0]]].X,
                   b = w.particles[f.node[edge_nodes[e][1]]].X;
        const bool end = (at_end(a, 0) && at_end(b, 0)) || (at_end(a, 1) && at_end(b, 1));
        if (at_bend(a) && at_bend(b))
          ++(f.rim[e] ? rims : no_rims);
        else if (a[0] + b[0] < 0.0 && f.rim[e] != end)
          ++wrong;
      }
    }
    for (const auto &p : w.tables.points) {
      const Vec3 X = w.particles[p.atom].X;
      if (p.part != 1 || X[2] < -1e-9 || X[0] > 1e-9) continue;
      const bool end = at_end(X, 0) || at_end(X, 1);
      if (at_bend(X) && !end)
        ++(p.sharp ? sharp : smooth);
      else if (p.sharp != end)
        ++wrong;
    }
  }
};

}    // namespace

TEST(SurfaceSearch, AnEmptySceneHasNoContacts)
{
  SurfaceWorld w;
  w.search();
  EXPECT_EQ(w.finder.looked_at(), 0);
  w.add_particle(Vec3::Zero(), 1.0);    // a ball without a mesh
  w.add_de(Vec3(1.5, 0, 0), 1.0, 0);
  w.search();
  EXPECT_TRUE(w.tables.facets.empty() && w.tables.points.empty() && w.tables.balls.empty());
}

// A body alone, and one that is farther away than anything reaches, cost no closer look.
TEST(SurfaceSearch, FacetsWithNothingNearAreNotLookedAt)
{
  SurfaceWorld w;
  w.add_block(0, {8, 8, 8}, 1.0, shift(Vec3::Zero()));
  w.search();
  EXPECT_EQ(w.finder.looked_at(), 0);
  w.add_block(1, {8, 8, 8}, 1.0, shift(Vec3(20.0, 0, 0)));
  w.add_particle(Vec3(4, 4, 18.0), 5.0);    // a large ball is told by itself
  w.search();
  EXPECT_EQ(w.finder.looked_at(), 0);
  EXPECT_TRUE(w.tables.facets.empty() && w.tables.points.empty() && w.tables.balls.empty());
}

// Two bodies that meet at one face: the faces around are looked at, those on their far sides are not.
TEST(SurfaceSearch, FacetsNearAnotherBodyAreLookedAt)
{
  SurfaceWorld w;
  w.add_block(0, {8, 8, 8}, 1.0, shift(Vec3::Zero()));
  w.add_block(1, {8, 8, 8}, 1.0, shift(Vec3(8.05, 0, 0)));
  w.search();
  EXPECT_GE(w.finder.looked_at(), 2 * 64);
  EXPECT_LE(w.finder.looked_at(), 2 * (64 + 4 * 8 * 5));    // of 768
  // in contact are the two faces that meet, and the nodes' patches on the sides around
  std::map<int, int> normals;
  for (const auto &plane : w.tables.planes) {
    EXPECT_NEAR(plane.mid[0], 8.0, 1.6);
    if (std::abs(plane.normal[0]) > 0.9) ++normals[plane.normal[0] > 0.0 ? 1 : -1];
  }
  EXPECT_EQ(normals, (std::map<int, int>{{-1, 64}, {1, 64}}));
  // no other facet is left in the tables, where it would cost something in every step
  std::set<int> needed(w.tables.candidates.begin(), w.tables.candidates.end());
  for (const auto &patch : w.tables.patches) needed.insert(patch.facet);
  EXPECT_EQ(needed.size(), w.tables.facets.size());
  EXPECT_LT(w.tables.facets.size(), static_cast<size_t>(w.finder.looked_at()));
}

TEST(SurfaceSearch, RimsOfACubeAreItsEdges)
{
  SurfaceWorld w;
  w.add_block(0, {3, 3, 3}, 1.0, shift(Vec3::Zero()));
  w.add_particle(Vec3(1.5, 1.5, 1.5), 4.0);    // in touch with all faces
  w.search();
  EXPECT_EQ(w.tables.facets.size(), 54u);
  int rims = 0;
  for (const auto &f : w.tables.facets) {
    for (int k = 0; k < 4; ++k) {
      const Vec3 middle =
          0.5 * (w.particles[f.node[edge_nodes[k][0]]].X + w.particles[f.node[edge_nodes[k][1]]].X);
      int on = 0;    // planes of the cube
      for (int d = 0; d < 3; ++d) on += middle[d] < 1e-12 || middle[d] > 3.0 - 1e-12;
      EXPECT_EQ(f.rim[k], on == 2) << middle.transpose();
      rims += f.rim[k];
    }
  }
  EXPECT_EQ(rims, 12 * 3 * 2);
}

TEST(SurfaceSearch, BendsOfMoreThan30DegreesAreRimsAndSharp)
{
  for (double degrees : {0.0, 20.0, 40.0}) {
    const Bend bend(degrees);
    const bool sharp = degrees > 30.0;
    EXPECT_EQ(bend.rims, sharp ? 12 : 0) << degrees;    // six edges, from both sides
    EXPECT_EQ(bend.no_rims, sharp ? 0 : 12) << degrees;
    EXPECT_EQ(bend.sharp, sharp ? 5 : 0) << degrees;
    EXPECT_EQ(bend.smooth, sharp ? 0 : 5) << degrees;
    EXPECT_EQ(bend.wrong, 0) << degrees;
  }
}

// A plate that was made flat has no edge where it bends later.
TEST(SurfaceSearch, RimsAreThoseOfTheReferenceConfiguration)
{
  const Bend later(40.0, true);
  EXPECT_EQ(later.rims + later.sharp, 0);
  EXPECT_EQ(later.no_rims, 12);
  EXPECT_EQ(later.smooth, 5);
  EXPECT_EQ(later.wrong, 0);
}

TEST(SurfaceSearch, FacetsHaveReferenceGeometryAndStiffness)
{
  SurfaceWorld w;
  w.parts[1].rigid = true;
  w.add_block(0, {1, 1, 1}, 1.0, [](const Vec3 &x) {
    return Vec3(2.0 * x[0], x[1], 3.0 * x[2]);
  });
  for (auto &p : w.particles) p.x[0] *= 1.1;    // stretched by now
  w.add_block(1, {1, 1, 1}, 2.0, shift(Vec3(0, 0, 3.02)));
  w.search();
  int tops = 0;
  for (size_t k = 0; k < w.tables.facets.size(); ++k) {
    const auto &f = w.tables.facets[k];
    if (f.part == 1) {
      EXPECT_LT(f.k_area, 0.0);
      continue;
    }
    EXPECT_NEAR(f.k_area, 0.2 * 40e9 * f.area / 6.0, 1.0);
    EXPECT_NEAR(f.depth_max, 0.5 * std::min(6.0 / f.area, std::sqrt(f.area)), 1e-12);
    if (w.tables.planes[k].normal[2] < 0.9) continue;
    ++tops;
    EXPECT_NEAR(f.area, 2.0, 1e-12);
    EXPECT_NEAR(std::min(f.half_xi, f.half_eta), 0.5, 1e-12);
    EXPECT_NEAR(std::max(f.half_xi, f.half_eta), 1.0, 1e-12);
    EXPECT_NEAR(w.tables.planes[k].mid[0], 1.1, 1e-12);
  }
  EXPECT_EQ(tops, 1);
}

namespace {

/// A groove: two slopes of one part that meet at its bottom at 50 degrees, x = 0.
void add_groove(SurfaceWorld &w)
{
  const double s = std::tan(65.0 * pi / 180.0);
  w.add_block(0, {8, 4, 2}, 0.25, [s](const Vec3 &at) {
    const double x = at[0] - 1.0;
    return Vec3(x, at[1], at[2] + s * std::abs(x));
  });
}

/// Pairs of a node and a facet of its part that share a node of the same ID, and all others.
std::array<int, 2> joined_and_not(const SurfaceWorld &w)
{
  std::array<int, 2> n = {0, 0};
  for (const auto &one : w.found())
    for (const auto &facet : one.second.candidates) {
      bool joined = false;
      for (const auto &patch : one.second.patches)
        for (std::int64_t id : patch.second)
          joined |= std::count(facet.second.begin(), facet.second.end(), id) > 0;
      ++n[!joined];
    }
  return n;
}

}    // namespace

TEST(SurfaceSearch, JoinedFacetsAreLeftOut)
{
  SurfaceWorld w;
  w.skin = 0.02;
  add_groove(w);
  w.search();
  const auto n = joined_and_not(w);
  EXPECT_EQ(n[0], 0);
  EXPECT_GT(n[1], 50);    // the slopes themselves do meet

  // a slope whose nodes at the bottom are ghosts with the same IDs is still joined to the other one
  std::map<int, int> ghost;
  for (auto &e : w.elements) {
    bool right = true;
    for (int i : e.node) right = right && w.particles[i].X[0] > -1e-9;
    if (!right) continue;
    for (int &i : e.node) {
      if (!ghost.count(i)) {
        SurfaceWorld::Particle p = w.particles[i];
        p.ghost = true;
        ghost[i] = static_cast<int>(w.particles.size());
        w.particles.push_back(p);
      }
      i = ghost[i];
    }
  }
  const auto whole = w.found();
  w.search();
  EXPECT_EQ(joined_and_not(w)[0], 0);
  EXPECT_TRUE(w.found() == w.found(w.search_whole()));
  int compared = 0;
  for (const auto &one : w.found()) {
    const auto &patches = one.second.patches;
    if (patches.empty() || one.second.patches != whole.at(one.first).patches) continue;
    EXPECT_EQ(one.second.candidates, whole.at(one.first).candidates);
    ++compared;
  }
  EXPECT_GT(compared, 10);
}

TEST(SurfaceSearch, RigidPartsDoNotMeet)
{
  for (bool rigid : {false, true}) {
    SurfaceWorld w;
    w.parts[1].rigid = true;
    w.parts[0].rigid = rigid;
    w.add_block(0, {2, 2, 2}, 1.0, shift(Vec3::Zero()));
    w.add_block(1, {2, 2, 2}, 1.0, shift(Vec3(0.2, 0.3, 2.05)));
    w.add_particle(Vec3(1, 1, 4.5), 0.5);    // a ball is rigid, too
    w.search();
    EXPECT_EQ(w.tables.points.empty(), rigid);
    EXPECT_TRUE(w.tables.balls.empty());
  }
}

// A face that a conversion has bared is met, but it carries no patches.
TEST(SurfaceSearch, BaredFacesHaveNoPatches)
{
  SurfaceWorld w;
  w.add_block(0, {2, 2, 2}, 1.0, shift(Vec3::Zero()));
  w.add_block(1, {2, 2, 2}, 1.0, shift(Vec3(0.2, 0.3, 2.05)));
  for (auto &e : w.elements)
    if (e.part == 0) e.free &= ~(1u << 5);    // the upper side
  w.search();
  int outer = 0, bared = 0;
  for (const auto &p : w.tables.points) {
    for (int c = p.own; c < p.own + p.nown; ++c)
      EXPECT_TRUE(w.tables.facets[w.tables.patches[c].facet].outer);
    for (int c = p.first; c < p.first + p.count; ++c)
      ++(w.tables.facets[w.tables.candidates[c]].outer ? outer : bared);
  }
  EXPECT_GT(bared, 9);
}

TEST(SurfaceSearch, DEsEndWhereTheirElementDid)
{
  SurfaceWorld w;
  w.add_block(0, {2, 2, 2}, 1.0, shift(Vec3::Zero()));
  w.add_block(1, {2, 2, 2}, 1.0, shift(Vec3(0, 0, 2.8)));
  const int i = w.add_de(Vec3(0.4, 0.6, 2.4), 0.45, 1);
  auto &p = w.particles[i];
  p.distance = 0.4;
  p.area = 0.5;
  p.length = 0.3;
  const auto of_de = [&](int part) {
    w.search();
    for (const auto &point : w.tables.points)
      if (w.particles[point.atom].id == p.id && point.part == part) return point;
    return ContactPoint{-1, 0, false, 0, 0, 0, 0, -1.0, 0.0, 0.0, 0.0};
  };
  const ContactPoint other = of_de(0), own = of_de(1);
  EXPECT_EQ(other.r, 0.4);
  EXPECT_EQ(other.area, 0.5);
  EXPECT_DOUBLE_EQ(other.k_own, 0.2 * 40e9 * 0.3 / 0.5);
  EXPECT_DOUBLE_EQ(other.half, 0.5 * std::sqrt(0.5));
  EXPECT_EQ(other.nown, 0);
  EXPECT_FALSE(other.sharp);
  EXPECT_EQ(own.r, 0.4);    // the smaller one of the sphere and the outer face
  p.distance = 0.5;
  EXPECT_EQ(of_de(0).r, 0.5);
  EXPECT_EQ(of_de(1).r, 0.45);
  // not beyond a face that it was tied to from the start
  w.tied_faces[{i, 0}] = 0.35;
  EXPECT_EQ(of_de(0).r, 0.35);
  EXPECT_EQ(of_de(1).r, 0.45);
}

// A DE does not look at the facets of an element that it stays tied to, but at those around.
TEST(SurfaceSearch, LastingTiesAreLeftOut)
{
  SurfaceWorld w;
  w.add_block(0, {2, 2, 2}, 1.0, shift(Vec3::Zero()));
  const int i = w.add_de(Vec3(0.9, 0.6, 2.3), 0.4, 1);
  const auto elements = [&] {
    w.search();
    std::set<std::int64_t> seen;
    for (const auto &one : w.found())
      for (const auto &facet : one.second.candidates) seen.insert(facet.first);
    return seen;
  };
  const auto all = elements();
  EXPECT_EQ(all, (std::set<std::int64_t>{5, 6, 7, 8}));
  w.lasting_ties.insert({i, 0, 5});
  EXPECT_EQ(elements(), (std::set<std::int64_t>{6, 7, 8}));
  w.lasting_ties = {{i, 1, 5}};    // another part's
  EXPECT_EQ(elements(), all);
}

// IDs of 32 bits are read where they are.
TEST(SurfaceSearch, IDsOf32And64Bits)
{
  const std::int32_t narrow[2] = {7, -3};
  const std::int64_t wide[2] = {std::int64_t{1} << 40, -3};
  EXPECT_EQ(Ids(narrow)[0], 7);
  EXPECT_EQ(Ids(narrow)[1], -3);
  EXPECT_EQ(Ids(wide)[0], std::int64_t{1} << 40);
  EXPECT_EQ(Ids(wide)[1], -3);
}
