// One, eight or 27 discrete elements for a finite one: places, slots, rings of cracks.

#include "crack_body.h"

#include "defe/coupling/mesh_measure.h"

#include <gtest/gtest.h>

#include <set>

using namespace defe;
using namespace defe::test;

TEST(ElementSplit, EveryPlaceOnce)
{
  for (int along : {1, 2, 3}) {
    const ElementSplit split(along);
    ASSERT_EQ(split.des(), along * along * along);
    std::set<std::array<int, 3>> places;
    for (int k = 0; k < split.des(); ++k) {
      int q[3];
      split.position(k, q);
      places.insert({q[0], q[1], q[2]});
      EXPECT_LT((split.centre(k) * along - Vec3(q[0], q[1], q[2])).norm(), 1e-15);
      for (int s = 0; s < 6; ++s) {
        const int axis = s / 2, way = s % 2 ? 1 : -1;
        EXPECT_EQ(split.outer(k, s), q[axis] == way * (along - 1));
        EXPECT_EQ(split.outer(k, s), (split.outer_slots(k) >> s & 1u) != 0);
        if (split.outer(k, s)) continue;
        int beside[3];
        split.position(split.beside(k, s), beside);
        EXPECT_EQ(beside[axis], q[axis] + 2 * way);
        EXPECT_EQ(split.beside(split.beside(k, s), s ^ 1), k);
      }
      if (k >= 8 || along == 1) {
        EXPECT_EQ(split.node_at(k), -1);
        continue;
      }
      EXPECT_EQ(split.node_at(k), k);
      for (int a = 0; a < 3; ++a) EXPECT_EQ(q[a], (along - 1) * fe::hex_sign[k][a]);
    }
    EXPECT_EQ(static_cast<int>(places.size()), split.des());
    for (int f = 0; f < 6; ++f) EXPECT_EQ(static_cast<int>(split.on_face(f).size()), along * along);
  }
}

// Elements that are a single DE know their neighbours' axes by the nodes of the faces only.
TEST(ElementSplit, RingsOfFourWhateverTheLocalAxes)
{
  std::mt19937 random(8);
  for (int along : {1, 3}) {
    Mesh mesh = box_mesh(4, 4, 4, 1.0);
    shuffle_local_axes(mesh, random);
    const CrackBody body(mesh, CohesiveParameters{60e6, 10.0, 0.1, false}, true, glass(),
                         ElementSplit(along));
    int rings = 0, expected = 0;
    for (int i = 0; i < body.n; ++i)
      for (int s = 0; s < 6; ++s)
        for (int t = 0; t < 6; ++t) {
          if (s / 2 == t / 2 || body.partner[i][s] < 0 || body.partner[i][t] < 0) continue;
          const Vec3 a = body.lattice().vector(6 * i + s), b = body.lattice().vector(6 * i + t);
          ++expected;
          CrackRing ring;
          ASSERT_TRUE(crack_ring(body.lattice(), i, s, t, ring));
          ++rings;
          ASSERT_EQ(ring.size, 4);
          const Vec3 X = body.reference(i), opposite = body.reference(ring.de[2]);
          EXPECT_LT((opposite - X - a - b).norm(), 1e-12);
        }
    EXPECT_EQ(rings, expected);
    EXPECT_GT(rings, 800);
  }
}

// A short bar that is torn in two: the joints of its cross-section take G_f by area, however many there are.
TEST(ElementSplit, TheWorkOfACrackIsThatOfItsArea)
{
  const double h = 2e-3, G_f = 300.0, strain = 7.6e-4, rate = 0.3, area = 4.0 * h * h;
  for (int along : {1, 2, 3}) {
    CrackBody body(box_mesh(6, 2, 2, h), CohesiveParameters{60e6, G_f, 0.1, false}, true, glass(),
                   ElementSplit(along));
    for (int i = 0; i < body.n; ++i) {
      const Vec3 X = body.reference(i);
      body.driven[i] = body.type[i] = std::abs(X[0]) > 2.0 * h;
      body.v[i] = Vec3(rate * X[0] / (3.0 * h), 0.0, 0.0);
      body.x[i] += strain * Vec3(X[0], -0.2 * X[1], -0.2 * X[2]);
    }
    const double dt = body.stable_step(0.3);
    body.forces();
    double broken = 0.0, fracture = 0.0;    // of joints that have come apart
    for (int step = 0; step < 4000 && broken < 0.999 * area; ++step) {
      body.step(dt);
      broken = fracture = 0.0;
      for (const auto &[joint, c] : body.cut) {
        if (!c.joint.broken) continue;
        broken += std::abs(c.geometry.a.dot(Vec3(c.joint.m)));
        fracture += c.fracture;
      }
    }
    EXPECT_GT(broken, 0.999 * area) << along;
    // not all are drawn apart squarely: 3 % with eight DEs
    EXPECT_NEAR(fracture / (G_f * broken), 1.0, 0.05) << along;
  }
}

TEST(ElementSplit, StableStepsGoWithTheSpacing)
{
  fe::HexCoords X;
  for (int k = 0; k < 8; ++k)
    for (int a = 0; a < 3; ++a) X(a, k) = 0.5e-3 * fe::hex_sign[k][a];
  const double mass = glass().rho * 1e-9;
  const auto one = discrete_steps(X, glass(), mass, ElementSplit(1));
  for (int along : {2, 3}) {
    const auto steps = discrete_steps(X, glass(), mass, ElementSplit(along));
    EXPECT_NEAR(steps.joints, one.joints / along, 4e-3 * steps.joints);
    EXPECT_LE(steps.des, steps.joints);
    EXPECT_GT(steps.des, 0.6 * steps.joints);
  }
}
