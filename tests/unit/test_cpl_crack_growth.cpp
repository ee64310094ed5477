// Where cracks start and go on: rings, strength in every direction, numbering, ranks

#include "crack_body.h"

#include <gtest/gtest.h>

#include <set>

using namespace defe;
using namespace defe::test;

namespace {

constexpr double h = 2e-3, d = 1e-3;
const CohesiveParameters law{60e6, 10.0, 0.1, false};

/// As many quadrilaterals around an edge, two elements high.
Mesh around_an_edge(int k)
{
  Mesh mesh;
  for (int layer = 0; layer < 3; ++layer) {
    mesh.X.emplace_back(0.0, 0.0, h * layer);
    for (int i = 0; i < 2 * k; ++i) {
      const double a = M_PI * i / k, r = i % 2 ? 1.3 * h : h;
      mesh.X.emplace_back(r * std::cos(a), r * std::sin(a), h * layer);
    }
  }
  const int m = 2 * k + 1;
  for (int layer = 0; layer < 2; ++layer)
    for (int i = 0; i < k; ++i) {
      const std::array<std::int64_t, 4> quad{0, 1 + 2 * i, 2 + 2 * i, 1 + (2 * i + 2) % (2 * k)};
      std::array<std::int64_t, 8> hex;
      for (int q = 0; q < 4; ++q) {
        hex[q] = quad[q] + m * layer;
        hex[q + 4] = quad[q] + m * (layer + 1);
      }
      mesh.hex.push_back(hex);
    }
  return mesh;
}

using RingKey = std::set<std::int64_t>;

std::map<RingKey, int> all_rings(const CrackBody &body)
{
  std::map<RingKey, int> rings;
  CrackRing ring;
  for (int i = 0; i < body.n; ++i)
    for (int s = 0; s < 6; ++s)
      for (int t = 0; t < 6; ++t) {
        if (s / 2 == t / 2 || !crack_ring(body.lattice(), i, s, t, ring)) continue;
        RingKey key;
        for (int k = 0; k < ring.size; ++k) {
          key.insert(body.id[ring.de[k]]);
          EXPECT_EQ(ring.joint[k] / 6, ring.de[k]);
          EXPECT_EQ(body.lattice().other_end(ring.joint[k]) / 6, ring.de[(k + 1) % ring.size]);
        }
        EXPECT_EQ(static_cast<int>(key.size()), ring.size);
        rings[key] += 1;
      }
  return rings;
}

std::vector<Vec3> directions()
{
  std::vector<Vec3> all = {Vec3(1, 1, 0).normalized(), Vec3(1, 1, 1).normalized()};
  for (double angle : {0.0, 15.0, 30.0, 45.0})
    all.push_back(Vec3(std::cos(angle * M_PI / 180.0), std::sin(angle * M_PI / 180.0), 0.0));
  std::mt19937 random(4);
  std::normal_distribution<double> normal;
  for (int k = 0; k < 20; ++k)
    all.push_back(Vec3(normal(random), normal(random), normal(random)).normalized());
  return all;
}

Mesh strength_mesh(int kind)
{
  std::mt19937 random(9);
  Mesh mesh = box_mesh(4, 4, 4, h, [&](const Vec3 &X) {
    if (kind == 1) return Vec3(2.0 * X[0], X[1], X[2]);
    return kind == 2 ? Vec3(X + random_vector(random, 0.2 * h)) : X;
  });
  if (kind == 2) shuffle_local_axes(mesh, random);
  return mesh;
}

/// Only joints of DEs that have all their joints may be cut.
void spare_the_surface(CrackBody &body)
{
  for (int i = 0; i < body.n; ++i) body.type[i] = body.present[i] != 0x3f;
}

/// Stress at which the first joint starts, over sigma_t; and how its normal lies.
double first_start(CrackBody &body, const Mat3 &S, std::vector<CrackStart> *starts = nullptr)
{
  for (double share = 0.94; share < 1.2; share += 0.005) {
    const Mat3 F = strain_of(share * S);
    for (int i = 0; i < body.n; ++i) body.x[i] = F * body.reference(i);
    body.forces();
    body.decide();
    if (starts) *starts = body.starts;
    if (!body.starts.empty()) return share;
  }
  return HUGE_VAL;
}

}    // namespace

TEST(CrackRings, FourInBlocksWhateverTheLocalAxes)
{
  std::mt19937 random(1);
  Mesh mesh = box_mesh(3, 3, 3, h, [&](const Vec3 &X) {
    return Vec3(X + random_vector(random, 0.2 * h));
  });
  shuffle_local_axes(mesh, random);
  const CrackBody body(mesh, law, false);
  const auto rings = all_rings(body);
  EXPECT_EQ(rings.size(), 3u * 5 * 5 * 6);    // of a lattice of 6 x 6 x 6
  for (const auto &[key, count] : rings) {
    EXPECT_EQ(key.size(), 4u);
    EXPECT_EQ(count, 8);    // from each of its DEs, both ways
  }
}

TEST(CrackRings, AsManyAsElementsAroundAnEdge)
{
  for (int k : {3, 4, 5, 6}) {
    std::mt19937 random(k);
    Mesh mesh = around_an_edge(k);
    shuffle_local_axes(mesh, random);
    const CrackBody body(mesh, law, false);
    int odd = 0;
    for (const auto &[key, count] : all_rings(body)) {
      EXPECT_EQ(count, 2 * static_cast<int>(key.size()));
      if (k != 4 && static_cast<int>(key.size()) == k) {
        ++odd;
        for (std::int64_t id : key) {
          const Vec3 X = body.reference(static_cast<int>(id) - 1);
          EXPECT_LT(std::hypot(X[0], X[1]), 0.7 * h);
        }
      } else {
        EXPECT_EQ(key.size(), 4u);
      }
    }
    EXPECT_EQ(odd, k == 4 ? 0 : 4);
  }
}

// A stress that the joints left can bear is found, whether or not the others are there; turning it changes nothing.
TEST(CrackStress, FullAndReducedCorners)
{
  std::mt19937 random(13);
  const Mat3 turn = random_rotation(random), R = random_rotation(random);
  const CrackBody body(box_mesh(2, 2, 2, h,
                                [&](const Vec3 &X) {
                                  return Vec3(turn * X);
                                }),
                       law, true);
  for (int i = 0; i < body.n; ++i) {
    if (body.present[i] != 0x3f) continue;
    Mat3 line = Mat3::Zero(), plane = Mat3::Zero(), solid;
    line(0, 0) = 1.0;
    plane.topLeftCorner(2, 2) << 1.0, 0.4, 0.4, -0.5;
    solid << 1.0, 0.2, -0.3, 0.2, 0.5, 0.6, -0.3, 0.6, -0.2;
    const std::pair<unsigned, Mat3> cases[] = {
        {0x03, line}, {0x0f, plane}, {0x3f, solid}, {0x3f, line}, {0x15, line}};
    for (const auto &[present, local] : cases) {
      const Mat3 S = law.sigma_t * turn * local * turn.transpose(), F = R * strain_of(S);
      Vec3 y[6];
      for (int s = 0; s < 6; ++s) y[s] = F * body.block.de[i].cell.dX[s];
      const CrackStress stress = crack_stress(body.block.de[i].cell, y, present, body.moduli);
      if (present == 0x15 || present == 0x3f) {
        EXPECT_NEAR(stress.full_volume, (present == 0x15 ? 0.125 : 1.0) * d * d * d,
                    1e-12 * d * d * d);
        EXPECT_LT((crack_tensor(stress.full) / stress.full_volume - S).norm(), 1e-9 * S.norm());
      }
      for (int s = 0; s < 6; ++s) {
        if (!(present >> s & 1u)) {
          EXPECT_EQ(stress.slot_volume[s], 0.0);
          continue;
        }
        EXPECT_NEAR(stress.slot_volume[s], 0.5 * d * d * d, 1e-12 * d * d * d);
        if (present != 0x15 || s == 0) {
          EXPECT_LT((crack_tensor(stress.slot[s]) / stress.slot_volume[s] - S).norm(),
                    1e-9 * S.norm());
        }
      }
    }
  }
}

// The faster form for boxes is the same, whatever joints are there.
TEST(CrackStress, BoxesHaveAShorterWay)
{
  std::mt19937 random(5);
  std::uniform_real_distribution<double> strain(-1e-2, 1e-2);
  const Mat3 turn = random_rotation(random);
  const CrackBody body(box_mesh(2, 2, 2, h,
                                [&](const Vec3 &X) {
                                  return Vec3(turn * Vec3(X[0], 2.0 * X[1], 0.7 * X[2]));
                                }),
                       law, true);
  std::vector<CrackBox> boxes;
  std::vector<CrackStress> general;
  for (int i = 0; i < body.n; ++i)
    for (unsigned present = 0; present < 64; ++present) {
      const auto &cell = body.block.de[i].cell;
      CrackBox box{};
      box.present = present & body.present[i];
      box.moduli = body.moduli;
      box.free = cell.free;
      for (int s = 0; s < 6; ++s) {
        box.y[s] =
            cell.dX[s] + cell.face[s].norm() * Vec3(strain(random), strain(random), strain(random));
        box.half[s] = cell.face[s].norm();
        box.length[s] = box.present >> s & 1u ? cell.dX[s].norm() : NAN;
        if (s % 2) box.axes.col(s / 2) = cell.face[s] / box.half[s];
      }
      boxes.push_back(box);
      general.push_back(crack_stress(cell, box.y, box.present, body.moduli));
    }
  boxes.pop_back();    // no multiple of what is done side by side
  const int n = static_cast<int>(boxes.size());
  std::vector<CrackStress> found(n);
  crack_stress_orthogonal(n, boxes.data(), found.data());
  const double size = 1e-12 * 1e-2 * body.moduli.mu * d * d * d;
  for (int i = 0; i < n; ++i) {
    const auto *a = reinterpret_cast<const double *>(&general[i]),
               *b = reinterpret_cast<const double *>(&found[i]);
    for (int k = 0; k < CrackStress::size; ++k)
      ASSERT_NEAR(a[k], b[k], std::max(size, 1e-11 * std::abs(a[k])))
          << i << " " << boxes[i].present << " " << k;
  }
}

// sigma_t in every direction, on cubes, bricks of 2:1 and distorted hexes; the crack is normal to the tension.
TEST(CrackGrowth, StrengthDoesNotKnowTheMesh)
{
  for (int kind : {0, 1, 2}) {
    CrackBody body(strength_mesh(kind), law, false);
    spare_the_surface(body);
    double least = HUGE_VAL, most = 0.0;
    for (const Vec3 &n : directions()) {
      std::vector<CrackStart> starts;
      const double uniaxial = first_start(body, law.sigma_t * n * n.transpose(), &starts);
      ASSERT_FALSE(starts.empty());
      for (const CrackStart &s : starts) EXPECT_GT(std::abs(Vec3(s.memory.m).dot(n)), 1.0 - 1e-6);
      const double equibiaxial =
          first_start(body, law.sigma_t * (Mat3::Identity() - n * n.transpose()), &starts);
      for (const CrackStart &s : starts) EXPECT_LT(std::abs(Vec3(s.memory.m).dot(n)), 1e-4);
      least = std::min({least, uniaxial, equibiaxial});
      most = std::max({most, uniaxial, equibiaxial});
    }
    EXPECT_GE(least, 0.985) << kind;
    EXPECT_LE(most, 1.015) << kind;
  }
}

// Distorted hexes pass the patch test within a per cent or two rms: in equilibrium, not in a given field, the
// first of a thousand joints bears up to 6 % more than the mean.
TEST(CrackGrowth, StrengthInEquilibriumOfADistortedMesh)
{
  CrackBody body(strength_mesh(2), law, false);
  for (int i = 0; i < body.n; ++i) body.type[i] = body.driven[i] = body.present[i] != 0x3f;
  for (const Vec3 &n :
       {Vec3(Vec3::UnitX()), Vec3(1, 1, 0).normalized(), Vec3(1, 2, 3).normalized()}) {
    const Mat3 S = law.sigma_t * n * n.transpose();
    std::fill(body.v.begin(), body.v.end(), Vec3(Vec3::Zero()));
    const Mat3 F = strain_of(S);
    for (int i = 0; i < body.n; ++i) body.x[i] = F * body.reference(i);
    body.forces();
    const double dt = body.stable_step();
    for (int step = 0; step < 200; ++step) {
      body.step(dt, CrackBody::NO_CRACKS);
      for (Vec3 &v : body.v) v *= 0.9;
    }
    std::vector<Vec3> u(body.n);
    for (int i = 0; i < body.n; ++i) u[i] = body.x[i] - body.reference(i);
    double at = 0.85;
    for (body.starts.clear(); body.starts.empty() && at < 1.2; at += 0.005) {
      for (int i = 0; i < body.n; ++i) body.x[i] = body.reference(i) + at * u[i];
      body.forces();
      body.decide();
    }
    EXPECT_GE(at - 0.005, 0.94) << n.transpose();
    EXPECT_LE(at - 0.005, 1.0) << n.transpose();
  }
}

// Nuclei in exactly equibiaxial tension: no direction in the plane is preferred.
TEST(CrackGrowth, EquibiaxialTensionHasNoFavouriteDirection)
{
  CrackBody body(box_mesh(10, 10, 4, h), law, true);
  spare_the_surface(body);
  body.nuclei[0].scatter = 0.0;
  double four = 0.0, two = 0.0;
  int count = 0;
  for (double angle : {0.0, 0.4}) {
    const Vec3 n = Eigen::AngleAxisd(angle, Vec3::UnitX()) * Vec3::UnitZ();
    std::vector<CrackStart> starts;
    (void) first_start(body, law.sigma_t * (Mat3::Identity() - n * n.transpose()), &starts);
    if (angle > 0.0) continue;
    for (const CrackStart &s : starts) {
      const double a = std::atan2(s.memory.m[1], s.memory.m[0]);
      four += std::cos(4.0 * a);
      two += std::cos(2.0 * a);
      ++count;
    }
  }
  EXPECT_GT(count, 20);
  EXPECT_LT(std::abs(four), 3.0 * std::sqrt(count));
  EXPECT_LT(std::abs(two), 3.0 * std::sqrt(count));
}

// What is left out by its energy could not have reached the strength.
TEST(CrackGrowth, QuietDEsAreNotLookedAt)
{
  CrackBody body(strength_mesh(2), law, false);
  const Vec3 n = Vec3(1, 2, 3).normalized();
  const auto marked_at = [&](double share, const Mat3 &S) {
    const Mat3 F = strain_of(share * law.sigma_t * S);
    for (int i = 0; i < body.n; ++i) body.x[i] = F * body.reference(i);
    body.forces();
    return body.growth.mark(body.lattice(), body.energy.data(), body.quiet.data()).size();
  };
  EXPECT_EQ(marked_at(0.0, Mat3::Zero()), 0u);
  EXPECT_EQ(marked_at(0.45, n * n.transpose()), 0u);
  EXPECT_GT(marked_at(0.8, n * n.transpose()), 0u);
  // hardest to see: all three tensions such that the energy is least for its largest
  const double nu = 0.2, side = nu / (1.0 - nu);
  const Mat3 hardest = n * n.transpose() + side * (Mat3::Identity() - n * n.transpose());
  std::mt19937 random(2);
  int strong = 0;
  for (double share : {0.97, 1.0, 1.05}) {
    marked_at(share, hardest);
    if (share > 1.0) {    // and one that is not uniform
      for (int i = 0; i < body.n; ++i) body.x[i] += random_vector(random, 2e-4 * h);
      body.forces();
      body.growth.mark(body.lattice(), body.energy.data(), body.quiet.data());
    }
    std::vector<CrackStress> stress;
    for (int i = 0; i < body.n; ++i) {
      CrackBody::End e;
      const CrackEnd de = body.end(i, e);
      stress.push_back(crack_stress(body.block.de[i].cell, e.y, de.present, body.moduli));
    }
    for (int joint = 0; joint < 6 * body.n; ++joint) {
      const int other = body.partner[joint / 6][joint % 6];
      if (other < joint) continue;
      const CrackStress &a = stress[joint / 6], &b = stress[other / 6];
      const Mat3 S = (crack_tensor(a.slot[joint % 6]) + crack_tensor(b.slot[other % 6])) /
          (a.slot_volume[joint % 6] + b.slot_volume[other % 6]);
      if (largest_principal(S).value < 0.98 * law.sigma_t) continue;
      EXPECT_TRUE(body.growth.marked(joint / 6) && body.growth.marked(other / 6));
      ++strong;
    }
  }
  EXPECT_GT(strong, 500);
}

namespace {

/// A block with a notch under a field that makes its whole front move, and nuclei start: noise on it.
void load(CrackBody &body, unsigned seed)
{
  const Vec3 n = Vec3(0.3, 1.0, 0.2).normalized();
  body.notch(
      [](const Vec3 &p) {
        return p[0] < 0.4 * d;
      },
      n, 0.3 * d);
  const Mat3 F = strain_of(1.25 * law.sigma_t * n * n.transpose());
  for (int i = 0; i < body.n; ++i) {
    const Vec3 X = body.reference(i);
    // noise of the place, not of the number
    const double a = 4e3 * X[0] + 1e3 * X[1] * (1 + seed), b = 3e3 * X[1] + 2e3 * X[2],
                 c = 5e3 * X[2] + X[0] * 2e3;
    body.x[i] = F * X + 4e-8 * Vec3(std::sin(a + b), std::cos(b + 2.0 * c), std::sin(c - a));
  }
  body.forces();
}

using Picture = std::map<std::array<long, 3>, std::array<double, 7>>;

/// Starts by place: normal (without sign), crack point, origin.
Picture picture(const CrackLattice &l, const std::vector<CrackStart> &starts)
{
  Picture p;
  for (const CrackStart &s : starts) {
    const Vec3 a(l.X[s.joint / 6]), m(s.memory.m);
    const Vec3 c = a + 0.5 * l.vector(s.joint), at = a + s.memory.f * l.vector(s.joint);
    Vec3 sign = m;
    if (m[1] < 0.0) sign = -m;
    p[{std::lround(c[0] / d * 1000.0), std::lround(c[1] / d * 1000.0),
       std::lround(c[2] / d * 1000.0)}] = {
        sign[0], sign[1], sign[2], at[0] / d, at[1] / d, at[2] / d, static_cast<double>(s.origin)};
  }
  return p;
}

void expect_same(const Picture &a, const Picture &b)
{
  ASSERT_EQ(a.size(), b.size());
  auto k = b.begin();
  for (const auto &[place, values] : a) {
    EXPECT_EQ(place, k->first);
    for (int i = 0; i < 7; ++i) EXPECT_NEAR(values[i], k->second[i], 1e-7);
    ++k;
  }
}

}    // namespace

// Cracks that are added and removed one by one, with fronts found again only where joints have changed, against all of
// them at once in new tables.
TEST(CrackGrowth, FrontsThatAreKeptAreThoseOfNewTables)
{
  CrackBody body(box_mesh(6, 6, 6, h,
                          [](const Vec3 &X) {
                            return X;
                          }),
                 law, false);
  load(body, 1);
  int fronts = 0, removed = 0;
  for (int k = 0; k < 6; ++k) {
    CrackGrowth anew;
    const CrackLattice l = body.lattice();
    anew.reset(l);
    for (const auto &[joint, c] : body.cut)
      anew.add_known_crack(l, joint, {{c.joint.m[0], c.joint.m[1], c.joint.m[2]}, c.joint.f});
    body.decide();
    EXPECT_EQ(anew.mark(l, body.energy.data(), body.quiet.data()),
              body.growth.mark(l, body.energy.data(), body.quiet.data()));
    body.find_stresses();
    for (int i = 0; i < body.n; ++i)
      if (anew.marked(i)) anew.stress(i) = body.growth.stress(i);
    std::vector<CrackStart> starts;
    anew.decide(l, body.strength(), body.parameters, starts);
    expect_same(picture(l, body.starts), picture(l, starts));
    for (const CrackStart &s : starts) fronts += s.origin == CrackStart::FRONT;
    body.open(body.starts);
    if (k != 3) continue;
    // some come apart
    std::vector<int> gone;
    for (const auto &[joint, c] : body.cut)
      if (gone.size() < 5) gone.push_back(joint);
    for (int joint : gone) {
      const int other = body.lattice().other_end(joint);
      body.growth.remove_crack(body.lattice(), joint);
      body.cut.erase(joint);
      for (int e : {joint, other}) body.partner[e / 6][e % 6] = -1;
      ++removed;
    }
  }
  EXPECT_GT(fronts, 20);
  EXPECT_EQ(removed, 5);
}

// A front steps up along its plane, over a DE; not where a joint of that DE which is cut says that it is above the crack, and the
// plane passes it closely.
TEST(CrackGrowth, ADEStaysOnItsSideOfTheCrack)
{
  const double angle = 35.0 * M_PI / 180.0;
  const Vec3 n(-std::sin(angle), std::cos(angle), 0.0);
  const CrackBody whole(box_mesh(6, 6, 6, h), law, true);
  const Mat3 F = strain_of(1.25 * law.sigma_t * n * n.transpose());
  const auto fronts = [](CrackBody &body) {
    body.decide();
    std::set<int> joints;
    for (const CrackStart &s : body.starts)
      if (s.origin == CrackStart::FRONT) joints.insert(s.joint);
    return joints;
  };
  constexpr double level = 0.1 * d;
  int close = 0, far = 0;
  for (double tip : {-2.4, -1.2, 0.52, 1.7}) {
    CrackBody body = whole;
    body.notch(
        [tip](const Vec3 &p) {
          return p[0] < tip * d;
        },
        n, level);
    for (int i = 0; i < body.n; ++i) body.x[i] = F * body.reference(i);
    body.forces();
    const CrackLattice l = body.lattice();
    for (int joint : fronts(body)) {
      const Vec3 e = l.vector(joint);
      if (std::abs(e[0]) < 0.9 * d) continue;
      const int under = (e[0] > 0.0 ? l.other_end(joint) : joint) / 6;    // the plane rises along x
      const bool kept =
          std::abs(n.dot(body.reference(under)) - level) < CrackGrowth::side_reach * e.norm();
      for (int s = 0; s < 6; ++s) {
        const int beside = 6 * under + s;
        if (l.partner[under][s] < 0 || l.vector(beside)[2] < 0.9 * d || l.cut(beside)) continue;
        for (bool above : {true, false}) {
          CrackBody other = body;
          const int lower = l.lower_end(beside);
          const double up = lower == beside ? -1.0
                                            : 1.0;    // along a normal that points at `under`
          const Vec3 m = up * Vec3(0.0, above ? 0.8 : -0.8, -0.6);
          other.state[lower] = other.state[l.other_end(lower)] = CrackLattice::SOFTENING;
          other.growth.add_crack(other.lattice(), lower, {{m[0], m[1], m[2]}, 0.5});
          EXPECT_EQ(fronts(other).count(joint), above && kept ? 0u : 1u);
          ++(kept ? close : far);
        }
      }
    }
  }
  EXPECT_GT(close, 8);
  EXPECT_GT(far, 8);
}

// Elements and their local axes in another order, IDs drawn anew: the same cracks.
TEST(CrackGrowth, NumberingDoesNotMatter)
{
  std::mt19937 random(6);
  Mesh mesh = box_mesh(6, 6, 6, h, [&](const Vec3 &X) {
    return Vec3(X + random_vector(random, 0.1 * h));
  });
  Picture first;
  for (int k = 0; k < 4; ++k) {
    Mesh other = mesh;
    if (k > 0) {
      std::shuffle(other.hex.begin(), other.hex.end(), random);
      shuffle_local_axes(other, random);
    }
    CrackBody body(other, law, false);
    if (k > 1) {
      std::shuffle(body.id.begin(), body.id.end(), random);
      body.growth.reset(body.lattice());
    }
    load(body, 1);
    body.decide();
    const Picture now = picture(body.lattice(), body.starts);
    int origins[4] = {};
    for (const CrackStart &s : body.starts) ++origins[s.origin];
    EXPECT_GT(origins[CrackStart::FRONT], 5);
    EXPECT_GT(origins[CrackStart::NUCLEUS], 5);
    if (k == 0)
      first = now;
    else
      expect_same(first, now);
  }
}

namespace {

/// The part of a body that one of two ranks knows: its own DEs, and ghosts as far as three joints.
struct Rank {
  std::vector<int> global;    // own first
  std::vector<std::int64_t> id;
  std::vector<std::array<double, 3>> X;
  std::vector<std::array<int, 6>> partner;
  std::vector<unsigned char> outer, state, type;
  std::vector<double> energy, quiet;
  int owned = 0;
  CrackGrowth growth;

  Rank(const CrackBody &body, const std::function<bool(const Vec3 &)> &mine, std::mt19937 &random)
  {
    std::vector<int> depth(body.n, -1), local(body.n, -1);
    for (int i = 0; i < body.n; ++i)
      if (mine(body.reference(i))) {
        global.push_back(i);
        depth[i] = 0;
      }
    owned = static_cast<int>(global.size());
    for (std::size_t k = 0; k < global.size(); ++k)
      for (int other : body.partner[global[k]])
        if (depth[global[k]] < 3 && other >= 0 && depth[other / 6] < 0) {
          depth[other / 6] = depth[global[k]] + 1;
          global.push_back(other / 6);
        }
    std::shuffle(global.begin(), global.begin() + owned, random);
    std::shuffle(global.begin() + owned, global.end(), random);
    for (std::size_t k = 0; k < global.size(); ++k) local[global[k]] = static_cast<int>(k);
    for (int i : global) {
      id.push_back(body.id[i]);
      X.push_back(body.X[i]);
      outer.push_back(body.outer[i]);
      type.push_back(body.type[i]);
      energy.push_back(body.energy[i]);
      quiet.push_back(body.quiet[i]);
      partner.emplace_back();
      for (int s = 0; s < 6; ++s) {
        const int other = body.partner[i][s];
        partner.back()[s] = other >= 0 && local[other / 6] >= 0 ? 6 * local[other / 6] + other % 6
                                                                : -1;
        state.push_back(body.state[6 * i + s]);
      }
    }
    growth.reset(lattice());
    for (const auto &[joint, c] : body.cut)
      if (local[joint / 6] >= 0 && local[body.partner[joint / 6][joint % 6] / 6] >= 0)
        growth.add_crack(lattice(), 6 * local[joint / 6] + joint % 6,
                         {{c.joint.m[0], c.joint.m[1], c.joint.m[2]}, c.joint.f});
  }
  CrackLattice lattice() const
  {
    return {owned,
            static_cast<int>(global.size()),
            id.data(),
            reinterpret_cast<const double(*)[3]>(X.data()),
            reinterpret_cast<const int(*)[6]>(partner.data()),
            outer.data(),
            state.data()};
  }
};

}    // namespace

// Two ranks: each decides on its own, from stresses that the owner of a DE has made.
TEST(CrackGrowth, RanksDecideAlike)
{
  std::mt19937 random(16);
  Mesh mesh = box_mesh(8, 6, 6, h, [&](const Vec3 &X) {
    return Vec3(X + random_vector(random, 0.1 * h));
  });
  shuffle_local_axes(mesh, random);
  CrackBody body(mesh, law, false);
  load(body, 2);
  body.decide();
  const Picture serial = picture(body.lattice(), body.starts);
  for (int way = 0; way < 3; ++way) {
    const Vec3 normal = way == 0 ? Vec3::UnitX() : (way == 1 ? Vec3::UnitY() : Vec3(1, 1, 1));
    Picture together;
    std::size_t starts_in_all = 0;
    for (int rank = 0; rank < 2; ++rank) {
      Rank r(
          body,
          [&](const Vec3 &X) {
            return (X.dot(normal) < 0.1 * d) == (rank == 0);
          },
          random);
      const CrackLattice l = r.lattice();
      for (int i : r.growth.mark(l, r.energy.data(), r.quiet.data())) {
        // a DE that this rank looks at, its owner has looked at, too
        EXPECT_TRUE(body.growth.marked(r.global[i]));
        r.growth.stress(i) = body.growth.stress(r.global[i]);
      }
      std::vector<CrackStart> starts;
      r.growth.decide(l, {r.type.data(), 2, body.strength().sigma_t, body.nuclei.data()},
                      body.parameters, starts);
      starts_in_all += starts.size();
      for (const auto &entry : picture(l, starts)) together.insert(entry);
    }
    EXPECT_EQ(starts_in_all, serial.size());    // no joint by both
    expect_same(serial, together);
  }
}

// The scatter is of the strength of nuclei: spread evenly over the joints, and not below the strength.
TEST(CrackGrowth, ScatterOfNuclei)
{
  CrackBody body(box_mesh(8, 8, 8, h), law, true);
  spare_the_surface(body);
  const Vec3 n = Vec3::UnitY();
  const auto strong = [&](double scatter, double stress) {
    body.nuclei[0].scatter = scatter;
    const Mat3 F = strain_of(stress * law.sigma_t * n * n.transpose());
    for (int i = 0; i < body.n; ++i) body.x[i] = F * body.reference(i);
    body.forces();
    body.decide();
    return body.starts.size();
  };
  EXPECT_EQ(strong(0.3, 0.995), 0u);
  const auto few = strong(0.3, 1.01), many = strong(0.3, 1.15);
  EXPECT_GT(few, 0u);
  EXPECT_LT(few, many / 2);    // 67 and 175; with 0.01 they are the same
  EXPECT_EQ(strong(0.01, 1.011), strong(0.01, 1.15));
}

// One weak DE, the others are stronger than sigma_t; then DEs without a say.
TEST(CrackGrowth, FlawsSayWhereNucleiStart)
{
  CrackBody body(box_mesh(8, 8, 8, h), law, true);
  spare_the_surface(body);
  body.nuclei[0].scatter = 0.0;
  const Vec3 n = Vec3::UnitY();
  const auto starts = [&](double stress) {
    const Mat3 F = strain_of(stress * law.sigma_t * n * n.transpose());
    for (int i = 0; i < body.n; ++i) body.x[i] = F * body.reference(i);
    body.forces();
    body.decide();
    return body.starts.size();
  };
  int weak = 0;
  for (int i = 0; i < body.n; ++i)
    if (body.reference(i).cwiseAbs().maxCoeff() < 0.6 * d && body.type[i] == 0) weak = i;
  std::vector<double> strength(body.n, 2.6 * law.sigma_t);
  strength[weak] = 0.5 * law.sigma_t;
  body.give_flaws(strength);
  EXPECT_EQ(starts(0.49), 0u);
  for (double stress :
       {0.51, 1.5, 2.5}) {    // the overstrength of branches, 2, is none of its business
    EXPECT_EQ(starts(stress), 1u) << stress;
    const int joint = body.starts.front().joint;
    EXPECT_TRUE(joint / 6 == weak || body.partner[joint / 6][joint % 6] / 6 == weak);
    EXPECT_EQ(body.starts.front().origin, CrackStart::NUCLEUS);
  }
  EXPECT_GT(starts(2.7), 5u);
  strength[weak] = HUGE_VAL;    // the others decide, and alone it keeps sigma_t
  body.give_flaws(strength);
  EXPECT_EQ(starts(2.5), 0u);
  body.give_flaws(std::vector<double>(body.n, HUGE_VAL));
  EXPECT_EQ(starts(0.99), 0u);
  EXPECT_GT(starts(1.01), 5u);
}

// A joint that is left alone in its ring, and a crack's own neighbourhood.
void beside_a_crack(double flaws)
{
  CrackBody body(box_mesh(6, 6, 6, h), law, true);
  spare_the_surface(body);
  const Vec3 n = Vec3::UnitY();
  body.notch(
      [](const Vec3 &) {
        return true;
      },
      n, 0.1 * d);
  if (flaws > 0.0) body.give_flaws(std::vector<double>(body.n, flaws * law.sigma_t));
  for (const auto &[overstrength, stress, opens] :
       {std::tuple{2.0, 1.5, false}, {2.0, 2.2, true}, {1.3, 1.5, true}, {3.0, 2.2, false}}) {
    body.nuclei[0].overstrength = overstrength;
    const Mat3 F = strain_of(stress * law.sigma_t * n * n.transpose());
    for (int i = 0; i < body.n; ++i) body.x[i] = F * body.reference(i);
    body.forces();
    body.decide();
    bool beside = false;
    for (const CrackStart &s : body.starts) {
      const Vec3 c = body.reference(s.joint / 6) + 0.5 * body.lattice().vector(s.joint);
      beside = beside || std::abs(c[1] - 0.1 * d) < 1.5 * d;
    }
    EXPECT_EQ(body.starts.empty(), flaws > stress && !opens);
    EXPECT_EQ(beside, opens) << overstrength << ", " << stress;
  }
}

TEST(CrackGrowth, BesideACrackNothingNucleates)
{
  beside_a_crack(0.0);
  beside_a_crack(0.5);    // branches have sigma_t whatever the flaws
  beside_a_crack(5.0);
}
