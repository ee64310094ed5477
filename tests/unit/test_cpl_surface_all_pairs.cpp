// The search for contacts of surfaces against all pairs of random scenes: no contact is missed until the next
// search, and not much is looked at for nothing; numbering and ranks do not matter.

#include "defe/coupling/surface_contact.h"
#include "defe/coupling/surface_search.h"

#include "surface_world.h"

#include <gtest/gtest.h>

using namespace defe;
using namespace defe::test;

namespace {

constexpr double pi = 3.14159265358979323846;
constexpr int edge_nodes[4][2] = {{1, 2}, {3, 0}, {2, 3}, {0, 1}};    // at xi = 1, -1, eta = 1, -1

Vec3 random_vector(std::mt19937 &random, double size)
{
  std::uniform_real_distribution<double> u(-1.0, 1.0);
  Vec3 v;
  do v = Vec3(u(random), u(random), u(random));
  while (v.norm() > 1.0 || v.norm() < 1e-3);
  return size * v;
}

/// A face of an element, measured by the test itself.
struct Face {
  int element, part, body;
  int node[4];
  FacetPlane plane;
  double area, half_xi, half_eta, depth_max;
  bool rim[4];
  SurfaceWorld::Name name;
};

Vec3 reference_normal(const SurfaceWorld &w, const int (&n)[4])
{
  return (w.particles[n[2]].X - w.particles[n[0]].X)
      .cross(w.particles[n[3]].X - w.particles[n[1]].X)
      .normalized();
}

std::vector<Face> all_faces(const SurfaceWorld &w)
{
  std::vector<Face> faces;
  std::vector<double> x;
  for (const auto &p : w.particles) x.insert(x.end(), p.x.data(), p.x.data() + 3);
  for (size_t e = 0; e < w.elements.size(); ++e)
    for (int f = 0; f < 6; ++f) {
      if (!(w.elements[e].bare >> f & 1)) continue;
      Face face;
      face.element = static_cast<int>(e);
      face.part = w.elements[e].part;
      face.body = w.elements[e].body;
      Vec3 P[4];
      for (int a = 0; a < 4; ++a) {
        face.node[a] = w.elements[e].node[fe::hex_face[f][a]];
        P[a] = w.particles[face.node[a]].X;
      }
      facet_planes(1, &face.node, x.data(), &face.plane);
      face.area = fe::face_area(P);
      const Vec3 a = 0.25 * (P[1] + P[2] - P[0] - P[3]), b = 0.25 * (P[2] + P[3] - P[0] - P[1]);
      face.half_xi = a.cross(b).norm() / b.norm();
      face.half_eta = a.cross(b).norm() / a.norm();
      face.depth_max = 0.5 * std::min(w.elements[e].volume / face.area, std::sqrt(face.area));
      face.name = w.name(face.node, w.elements[e].id);
      faces.push_back(face);
    }
  for (auto &face : faces)
    for (int k = 0; k < 4; ++k) {
      face.rim[k] = true;
      for (const auto &other : faces)
        if (&other != &face &&
            std::count(other.node, other.node + 4, face.node[edge_nodes[k][0]]) &&
            std::count(other.node, other.node + 4, face.node[edge_nodes[k][1]]) &&
            reference_normal(w, other.node).dot(reference_normal(w, face.node)) >
                std::cos(30.0 * pi / 180.0))
          face.rim[k] = false;
    }
  return faces;
}

/// Two bodies of different meshes in random positions, with a gap of less than the skin or a small overlap.
void two_bodies(SurfaceWorld &w, std::mt19937 &random, double h2, int part2 = 1)
{
  const auto turn = [&] {
    return Eigen::AngleAxisd(pi * random_vector(random, 1.0)[0],
                             random_vector(random, 1.0).normalized())
        .toRotationMatrix();
  };
  const Mat3 first = turn(), second = turn();
  w.add_block(0, {4, 4, 4}, 1.0, [&](const Vec3 &x) {
    return Vec3(first * (x - Vec3::Constant(2.0)));
  });
  const int n = static_cast<int>(std::round(3.0 / h2));
  const size_t start = w.particles.size();
  w.add_block(part2, {n, n, n}, h2, [&](const Vec3 &x) {
    return Vec3(second * (x - Vec3::Constant(0.5 * n * h2)));
  });
  // along a direction until the first node of either is on the other's surface, or a little farther
  const Vec3 way = random_vector(random, 1.0).normalized();
  const auto inside = [](const Vec3 &x, double half) {
    return x.cwiseAbs().maxCoeff() < half;
  };
  double s = 0.0;
  for (bool meet = true; meet; s += 0.02) {
    meet = false;
    for (size_t i = 0; i < w.particles.size() && !meet; ++i)
      meet = i < start ? inside(second.transpose() * (w.particles[i].X - s * way), 0.5 * n * h2)
                       : inside(first.transpose() * (w.particles[i].X + s * way), 2.0);
  }
  s += std::uniform_real_distribution<double>(-0.15, 0.05)(random);
  for (size_t i = start; i < w.particles.size(); ++i) {
    w.particles[i].X += s * way;
    w.particles[i].x = w.particles[i].X;
  }
}

struct Missed {
  int touching = 0, missed = 0;
};

/// Of the nodes and DEs against all facets, as they are now, those in contact that were not found.
Missed compare_with_all_pairs(const SurfaceWorld &w)
{
  Missed result;
  const auto found = w.found();
  const auto faces = all_faces(w);
  const auto is_found = [&](int i, const Face &f) {
    const auto it = found.find({w.particles[i].id, f.part});
    return it != found.end() &&
        std::count(it->second.candidates.begin(), it->second.candidates.end(), f.name);
  };
  const auto pair_with = [](const Face &f, double half) {
    SurfacePair pair{1.0, half / f.half_xi, half / f.half_eta, f.half_xi, f.half_eta, f.depth_max};
    std::copy_n(f.rim, 4, pair.rim);
    return pair;
  };
  const auto count = [&](const SurfaceContact &c, double depth_max, int i, const Face &f) {
    if (!(c.share > 0.0) || !(c.depth > 0.0) || c.raw_depth > depth_max) return;
    ++result.touching;
    if (!is_found(i, f)) ++result.missed;
  };
  for (const auto &own : faces)
    for (int corner = 0; corner < 4; ++corner)
      for (const auto &f : faces) {
        const int i = own.node[corner];
        if (f.body == own.body || w.particles[i].ghost) continue;
        const double half = 0.5 * std::min(own.half_xi, own.half_eta);
        count(patch_on_facet(own.plane, corner, w.particles[i].x, f.plane, pair_with(f, half)),
              f.depth_max, i, f);
      }
  for (size_t i = 0; i < w.particles.size(); ++i) {
    const auto &p = w.particles[i];
    if (p.part < 0 || p.ghost) continue;
    for (const auto &f : faces) {
      auto pair = pair_with(f, 0.5 * std::sqrt(p.area));
      pair.depth_max = p.distance + f.depth_max;
      const LocalPoint at = local_point(f.plane, p.x);
      if (at.h < -1.5 * f.depth_max) continue;    // on the far side
      SurfaceContact c;
      sphere_on_facet(at, p.distance, pair, c);
      count(c, pair.depth_max, static_cast<int>(i), f);
    }
  }
  return result;
}

/// Everything moves by half the skin, bodies as a whole; the second one against the first.
void move_by_half_the_skin(SurfaceWorld &w, std::mt19937 &random)
{
  Vec3 middle[3] = {Vec3::Zero(), Vec3::Zero(), Vec3::Zero()};
  std::vector<int> body(w.particles.size(), 2);
  for (const auto &e : w.elements)
    for (int i : e.node) body[i] = e.body;
  int n[3] = {0, 0, 0};
  for (size_t i = 0; i < body.size(); ++i) {
    middle[body[i]] += w.particles[i].x;
    ++n[body[i]];
  }
  Vec3 way = random_vector(random, 0.8);
  if (n[1] > 0) way += (middle[0] / n[0] - middle[1] / n[1]).normalized();
  for (size_t i = 0; i < body.size(); ++i) {
    const Vec3 by = body[i] == 0 ? Vec3(-way) : body[i] == 1 ? way : random_vector(random, 1.0);
    w.particles[i].x += 0.5 * w.skin * by.normalized();
  }
}

}    // namespace

// Elements of the second body of 1, 1/2 and 1/4 of the size of the first one's, at once.
TEST(SurfaceSearchAllPairs, NoContactIsMissedUntilTheNextSearch)
{
  std::mt19937 random(11);
  int touching = 0, candidates = 0, points = 0;
  for (double h : {1.0, 0.5, 0.25})
    for (int test = 0; test < (h < 0.4 ? 12 : 40); ++test) {
      SurfaceWorld w;
      w.skin = 0.1;
      two_bodies(w, random, h, test % 2);    // of one part, too
      w.search();
      candidates += static_cast<int>(w.tables.candidates.size());
      points += static_cast<int>(w.tables.points.size());
      move_by_half_the_skin(w, random);
      const Missed m = compare_with_all_pairs(w);
      EXPECT_EQ(m.missed, 0) << "test " << test << ", h " << h << ", of " << m.touching;
      touching += m.touching;
    }
  EXPECT_GT(touching, 1000);
  // and not much is looked at for nothing: a node has four patches that may touch one facet
  EXPECT_LT(candidates, 8 * touching);
  EXPECT_LT(candidates, 6 * points);
}

// One mesh with elements of 1, 1/2 and 1/8 beside each other against one of 1/2: a grid for each size.
TEST(SurfaceSearchAllPairs, ElementsOfSeveralSizesAreFoundAtOnce)
{
  SurfaceWorld w;
  w.add_block(0, {2, 4, 1}, 1.0, shift(Vec3(0, 0, -1)));
  w.add_block(0, {4, 8, 1}, 0.5, shift(Vec3(2, 0, -0.5)));
  w.add_block(0, {16, 32, 1}, 0.125, shift(Vec3(4, 0, -0.125)));
  w.add_block(1, {11, 7, 1}, 0.5, shift(Vec3(0.13, 0.21, 0.03)));
  std::mt19937 random(5);
  for (int test = 0; test < 8; ++test) {
    w.skin = 0.05;
    for (auto &p : w.particles) p.x = p.X;
    w.search();
    for (auto &p : w.particles) p.x[2] += (p.X[2] > 0.0 ? -0.5 : 0.5) * w.skin;
    const Missed m = compare_with_all_pairs(w);
    EXPECT_EQ(m.missed, 0);
    EXPECT_GT(m.touching, 1000);
    // facets of 1 do not make those of 1/8 be looked at from as far away
    for (const auto &p : w.tables.points)
      for (int c = p.first; c < p.first + p.count; ++c) {
        const auto &f = w.tables.facets[w.tables.candidates[c]];
        const Vec3 &mid = w.tables.planes[w.tables.candidates[c]].mid;
        const double size = std::sqrt(f.area) + p.half;
        EXPECT_LT((w.particles[p.atom].X - mid).norm(), 1.6 * size + 1.5 * w.skin);
      }
  }
}

// DEs of several sizes on the surface of a body, and born in it.
TEST(SurfaceSearchAllPairs, NoContactOfADEIsMissedUntilTheNextSearch)
{
  std::mt19937 random(17);
  std::uniform_real_distribution<double> u(-1.0, 1.0);
  int touching = 0, candidates = 0;
  for (int test = 0; test < 20; ++test) {
    SurfaceWorld w;
    const Mat3 turn = Eigen::AngleAxisd(pi * u(random), random_vector(random, 1.0).normalized())
                          .toRotationMatrix();
    w.add_block(0, {4, 4, 4}, 1.0, [&](const Vec3 &x) {
      return Vec3(turn * (x - Vec3::Constant(2.0)));
    });
    for (int k = 0; k < 40; ++k) {
      const double r = k % 2 ? 0.25 : 0.5;
      Vec3 at = 2.3 * Vec3(u(random), u(random), u(random));
      at[k % 3] = (u(random) > 0.0 ? 1.0 : -1.0) * (2.0 + r * (0.7 + 0.5 * u(random)));
      w.add_de(turn * at, r, 1);
    }
    w.search();
    candidates += static_cast<int>(w.tables.candidates.size());
    move_by_half_the_skin(w, random);
    const Missed m = compare_with_all_pairs(w);
    EXPECT_EQ(m.missed, 0) << test;
    touching += m.touching;
  }
  EXPECT_GT(touching, 500);
  EXPECT_LT(candidates, 5 * touching);
}

// Neither the order of particles and elements nor which of the particles are on this rank changes what is found
// for one of them, or its order.
TEST(SurfaceSearchAllPairs, WhatIsFoundDependsOnIDsOnly)
{
  std::mt19937 random(23);
  SurfaceWorld w;
  two_bodies(w, random, 0.5);
  for (int k = 0; k < 60; ++k) w.add_particle(random_vector(random, 4.0), k % 2 ? 0.3 : 2.5);
  for (int k = 0; k < 60; ++k) w.add_de(random_vector(random, 3.0), 0.4, k % 2);
  w.search();
  const auto found = w.found();
  const auto balls = w.found_balls();
  EXPECT_GT(found.size(), 50u);
  EXPECT_GT(balls.size(), 100u);
  for (unsigned seed = 1; seed < 5; ++seed) {
    w.renumber(seed);
    w.search();
    EXPECT_TRUE(w.found() == found);
    EXPECT_TRUE(w.found_balls() == balls);
  }
  // two ranks: each particle is a ghost on one of them
  auto sum = w.found();
  sum.clear();
  std::set<std::pair<std::int64_t, SurfaceWorld::Name>> sum_balls;
  for (int rank = 0; rank < 2; ++rank) {
    for (auto &p : w.particles) p.ghost = (p.X[0] > 0.0) != (rank == 1);
    w.ghosts_last();
    w.search();
    for (const auto &one : w.found()) EXPECT_TRUE(sum.insert(one).second);
    for (const auto &one : w.found_balls()) EXPECT_TRUE(sum_balls.insert(one).second);
  }
  EXPECT_TRUE(sum == found);
  EXPECT_EQ(sum_balls.size(), balls.size());
  for (const auto &one : balls) EXPECT_EQ(sum_balls.count(one), 1u);
}

// With nothing else around, and its centre far away from all facets.
TEST(SurfaceSearchAllPairs, ALargeBallAlone)
{
  SurfaceWorld w;
  w.add_block(0, {8, 8, 8}, 1.0, shift(Vec3::Zero()));
  w.add_particle(Vec3(4, 4, 38.05), 30.0);
  w.search();
  int expected = 0;
  for (const auto &f : all_faces(w))
    expected += (f.plane.mid - w.particles.back().x).norm() < 30.0 + std::sqrt(0.5) + w.skin;
  EXPECT_EQ(static_cast<int>(w.tables.balls.size()), expected);
  EXPECT_GT(expected, 16);
  EXPECT_LT(w.finder.looked_at(), 2 * 64);
}

// Exactly the pairs nearer than the skin by their spheres, large balls and small ones, with the facets of
// elements of this rank, in the order of IDs.
TEST(SurfaceSearchAllPairs, BallsMeetTheFacetsAround)
{
  std::mt19937 random(31);
  SurfaceWorld w;
  two_bodies(w, random, 0.5);
  w.parts[1].rigid = true;
  for (auto &p : w.particles) p.ghost = p.X[1] > 0.5;
  for (int k = 0; k < 80; ++k) {
    const int i =
        w.add_particle(random_vector(random, 4.0), k % 4 == 0 ? 2.0 + 0.02 * k : 0.1 + 0.01 * k);
    w.particles[i].ghost = k % 3 == 0;
  }
  w.renumber(7);
  w.search();
  std::vector<std::tuple<std::int64_t, int, SurfaceWorld::Name>> expected;
  int of_ghosts = 0;
  for (const auto &p : w.particles) {
    if (p.radius == 0.0) continue;
    for (const auto &f : all_faces(w)) {
      double extent = 0.0;
      for (int i : f.node) extent = std::max(extent, (w.particles[i].x - f.plane.mid).norm());
      if ((f.plane.mid - p.x).norm() > p.radius + extent + w.skin) continue;
      if (f.part == 1 || w.particles[w.elements[f.element].node[0]].ghost) {
        ++of_ghosts;
        continue;
      }
      expected.emplace_back(p.id, f.part, f.name);
    }
  }
  EXPECT_GT(of_ghosts, 50);
  EXPECT_GT(expected.size(), 500u);
  auto found = w.found_balls();
  ASSERT_EQ(found.size(), expected.size());
  for (size_t k = 1; k < found.size(); ++k) {
    EXPECT_LE(found[k - 1].first, found[k].first);
    if (found[k - 1].first == found[k].first) {
      EXPECT_LE(found[k - 1].second.first, found[k].second.first);
    }
  }
  std::sort(expected.begin(), expected.end());
  std::sort(found.begin(), found.end());
  for (size_t k = 0; k < found.size(); ++k) {
    EXPECT_EQ(found[k].first, std::get<0>(expected[k]));
    EXPECT_EQ(found[k].second, std::get<2>(expected[k]));
  }
}

// A search that takes over what holds of the last one finds what a whole one does, in the same order, when elements
// convert, atoms get other places, ties end, balls come and DEs grow.
TEST(SurfaceSearchAllPairs, WhatStaysIsKept)
{
  std::mt19937 random(41);
  const auto below = [&](size_t n) {
    return static_cast<int>(random() % n);
  };
  int anew = 0, all = 0, lasting = 0;
  for (int test = 0; test < 8; ++test) {
    SurfaceWorld w;
    two_bodies(w, random, test % 2 ? 0.5 : 1.0, test % 4 > 1);
    for (auto &p : w.particles) p.ghost = test % 3 == 1 && p.X[0] > 0.7;
    for (int k = 0; k < 20; ++k) w.add_particle(random_vector(random, 4.0), k % 2 ? 0.3 : 2.5);
    if (test % 3 == 1) w.ghosts_last();
    w.search();
    for (int round = 0; round < 20; ++round) {
      const bool other_order = round % 7 == 6;
      for (int k = below(3); k > 0; --k) w.convert(below(w.elements.size()));
      if (round % 3 == 1) w.add_particle(random_vector(random, 4.0), 0.4);
      if (test % 3 == 1) w.ghosts_last();
      if (round % 4 == 2 && !w.lasting_ties.empty())
        w.lasting_ties.erase(std::next(w.lasting_ties.begin(), below(w.lasting_ties.size())));
      auto &some = w.particles[below(w.particles.size())];
      if (some.part >= 0) some.distance *= 1.1;
      if (other_order) w.renumber(random());
      w.search();
      lasting += static_cast<int>(w.lasting_ties.size());
      ASSERT_TRUE(w.found() == w.found(w.search_whole())) << test << ", " << round;
      if (!other_order && test % 3 != 1) {
        anew += w.finder.searched_for();
        all += w.points_of_whole;
      }
      ASSERT_TRUE(w.agrees()) << test << ", " << round;
    }
  }
  EXPECT_GT(lasting, 100);
  EXPECT_GT(all, 5000);
  EXPECT_LT(anew, 0.5 * all);
}

// The same while bodies approach and slide along each other, now and then less than what is kept allows, are warped and
// convert. No contact is missed.
TEST(SurfaceSearchAllPairs, WhatMovesLittleIsKept)
{
  std::mt19937 random(43);
  int touching = 0, anew = 0, all = 0;
  for (int test = 0; test < 12; ++test) {
    SurfaceWorld w;
    two_bodies(w, random, test % 2 ? 0.5 : 1.0, test % 4 > 1);
    const bool warped = test % 3 == 2;
    std::vector<Vec3> way(3);
    for (auto &v : way) v = random_vector(random, 1.0);
    for (int round = 0; round < 28; ++round) {
      std::vector<int> body(w.particles.size(), 2);
      for (const auto &e : w.elements)
        for (int i : e.node) body[i] = e.body;
      const double far = (round % 6 ? 0.006 : 0.3) * w.skin;
      for (size_t i = 0; i < body.size(); ++i) {
        w.particles[i].x += far * way[body[i]];
        if (warped) w.particles[i].x += 0.02 * w.skin * random_vector(random, 1.0);
      }
      if (round % 2) w.convert(static_cast<int>(random() % w.elements.size()));
      w.lasting_ties.clear();
      w.search();
      ASSERT_TRUE(w.agrees()) << test << ", " << round;
      w.search_whole();
      anew += w.finder.searched_for();
      all += w.points_of_whole;
      if (round % 4 != 3 || warped) continue;
      const auto particles = w.particles;
      move_by_half_the_skin(w, random);
      const Missed m = compare_with_all_pairs(w);
      EXPECT_EQ(m.missed, 0) << test << ", " << round << ", of " << m.touching;
      touching += m.touching;
      w.particles = particles;
    }
  }
  EXPECT_GT(touching, 500);
  EXPECT_LT(anew, 0.7 * all);
  EXPECT_GT(anew, 0.3 * all);    // some have moved too far, or turned
}

// Among the elements that a search has noticed another one finds what it finds among all, as long as nothing has moved by more
// than a tenth of the skin; and most of two bodies is not noticed.
TEST(SurfaceSearchAllPairs, WhatIsNoticedIsEnough)
{
  std::mt19937 random(53);
  size_t noticed = 0, exposed = 0, candidates = 0;
  for (double h : {1.0, 0.5, 0.25})
    for (int test = 0; test < (h < 0.4 ? 12 : 40); ++test) {
      SurfaceWorld w;
      two_bodies(w, random, h, test % 2);
      if (test % 3 == 0) w.convert(static_cast<int>(random() % w.elements.size()));
      w.search();
      std::vector<char> which(w.seen().elements.size());
      w.finder.find_noticed(which);
      for (auto &p : w.particles) p.x += 0.08 * w.skin * random_vector(random, 1.0);
      w.search();
      const SurfaceScene all = w.seen();
      SurfaceScene few = all;
      few.elements.clear();
      for (size_t e = 0; e < which.size(); ++e)
        if (which[e]) few.elements.push_back(all.elements[e]);
      std::shuffle(few.elements.begin(), few.elements.end(), random);
      SurfaceSearch one;
      one.run(few, w.tables);
      EXPECT_TRUE(search_agrees(all, w.tables)) << "test " << test << ", h " << h;
      noticed += few.elements.size();
      for (const auto &e : w.elements) exposed += e.bare != 0;
      candidates += w.tables.candidates.size();
    }
  EXPECT_GT(candidates, 1000u);
  EXPECT_LT(noticed, exposed);
}

// The comparison itself: anything that is otherwise is seen.
TEST(SurfaceSearchAllPairs, OtherTablesAreSeen)
{
  std::mt19937 random(47);
  SurfaceWorld w;
  two_bodies(w, random, 0.5);
  w.add_particle(Vec3(0.0, 0.0, 4.0), 2.5);
  w.add_de(Vec3(0.0, 0.0, 2.4), 0.5, 1);
  w.search();
  EXPECT_TRUE(w.agrees());
  const auto tables = w.tables;
  const std::function<void(SurfaceTables &)> changes[] = {
      [](SurfaceTables &t) {
        --t.points.back().count;
      },
      [](SurfaceTables &t) {
        t.points.pop_back();
      },
      [](SurfaceTables &t) {
        t.points.front().half *= 1.0 + 1e-15;
      },
      [](SurfaceTables &t) {
        std::swap(t.candidates.front(), t.candidates.back());
      },
      [](SurfaceTables &t) {
        t.facets.front().rim[2] = !t.facets.front().rim[2];
      },
      [](SurfaceTables &t) {
        t.facets.back().node[3]++;
      },
      [](SurfaceTables &t) {
        t.patches.front().corner++;
      },
      [](SurfaceTables &t) {
        t.balls.pop_back();
      },
  };
  for (const auto &change : changes) {
    w.tables = tables;
    change(w.tables);
    EXPECT_FALSE(w.agrees());
  }
}
