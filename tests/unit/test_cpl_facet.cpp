// Closest points of bilinear facets; penalty stiffness.

#include "defe/coupling/facet.h"
#include "defe/coupling/penalty.h"

#include "de_block.h"

#include <Eigen/Geometry>
#include <gtest/gtest.h>

#include <array>
#include <random>
#include <vector>

using namespace defe;
using namespace defe::test;

namespace {

const Vec3 square[4] = {Vec3(0, 0, 0), Vec3(2, 0, 0), Vec3(2, 2, 0), Vec3(0, 2, 0)};

void expect_consistent(const FacetPoint &r, const Vec3 &p, const Vec3 node[4], double size)
{
  double sum = 0.0;
  Vec3 from_shapes = Vec3::Zero();
  for (int i = 0; i < 4; ++i) {
    EXPECT_GE(r.N[i], 0.0);
    sum += r.N[i];
    from_shapes += r.N[i] * node[i];
  }
  EXPECT_NEAR(sum, 1.0, 1e-14);
  EXPECT_LT((from_shapes - r.closest).norm(), 1e-13 * size);
  EXPECT_LE(std::abs(r.xi), 1.0);
  EXPECT_LE(std::abs(r.eta), 1.0);
  EXPECT_NEAR(std::abs(r.distance), (p - r.closest).norm(), 1e-14 * size);
  EXPECT_NEAR(r.normal.norm(), 1.0, 1e-13);
}

/// Least distance by trying a fine grid, refined.
double by_brute_force(const Vec3 &p, const Vec3 node[4])
{
  double best = 1e300, xi0 = 0.0, eta0 = 0.0, width = 1.0;
  for (int level = 0; level < 12; ++level, width *= 0.25) {
    const double cx = xi0, cy = eta0;
    const int n = level ? 5 : 30;
    for (int i = -n; i <= n; ++i)
      for (int j = -n; j <= n; ++j) {
        const double xi = std::clamp(cx + width * i / n, -1.0, 1.0);
        const double eta = std::clamp(cy + width * j / n, -1.0, 1.0);
        const double d = (p - facet_point(node, xi, eta)).norm();
        if (d < best) {
          best = d;
          xi0 = xi;
          eta0 = eta;
        }
      }
  }
  return best;
}

}    // namespace

TEST(Facet, FaceEdgeVertex)
{
  struct Case {
    Vec3 p, closest;
    FacetFeature feature;
    int which;
    double distance;
  };
  const Case cases[] = {
      {{0.5, 1.5, 0.3}, {0.5, 1.5, 0.0}, FacetFeature::face, 0, 0.3},
      {{0.5, 1.5, -0.3}, {0.5, 1.5, 0.0}, FacetFeature::face, 0, -0.3},    // behind
      {{1.0, 1.0, 0.0}, {1.0, 1.0, 0.0}, FacetFeature::face, 0, 0.0},
      {{0.5, -3.0, 4.0}, {0.5, 0.0, 0.0}, FacetFeature::edge, 0, 5.0},
      {{2.3, 0.7, 0.4}, {2.0, 0.7, 0.0}, FacetFeature::edge, 1, 0.5},
      {{0.7, 2.3, -0.4}, {0.7, 2.0, 0.0}, FacetFeature::edge, 2, -0.5},    // behind, beside an edge
      {{-0.3, 0.7, 0.4}, {0.0, 0.7, 0.0}, FacetFeature::edge, 3, 0.5},
      {{-1.0, -2.0, 2.0}, {0.0, 0.0, 0.0}, FacetFeature::vertex, 0, 3.0},
      {{3.0, -2.0, 2.0}, {2.0, 0.0, 0.0}, FacetFeature::vertex, 1, 3.0},
      {{3.0, 4.0, -2.0}, {2.0, 2.0, 0.0}, FacetFeature::vertex, 2, -3.0},
      {{-1.0, 4.0, 2.0}, {0.0, 2.0, 0.0}, FacetFeature::vertex, 3, 3.0},
  };
  for (const Case &c : cases) {
    const FacetPoint r = closest_point(c.p, square);
    EXPECT_LT((r.closest - c.closest).norm(), 1e-14);
    EXPECT_EQ(r.feature, c.feature);
    EXPECT_EQ(r.which, c.which);
    EXPECT_NEAR(r.distance, c.distance, 1e-14);
    EXPECT_LT((r.normal - Vec3(0, 0, 1)).norm(), 1e-15);
    expect_consistent(r, c.p, square, 2.0);
  }
}

// Points on the normal of a known point, on either side of warped facets.
TEST(Facet, PointsOnNormalsOfWarpedFacets)
{
  std::mt19937 random(1);
  for (int test = 0; test < 2000; ++test) {
    Vec3 node[4];
    const Mat3 R = random_rotation(random);
    for (int i = 0; i < 4; ++i)
      node[i] = R * (square[i] + random_vector(random, 0.2)) + Vec3(5.0, -3.0, 1.0);
    const double xi = uniform(random, -0.99, 0.99), eta = uniform(random, -0.99, 0.99);
    const double distance = uniform(random, -0.4, 0.4);
    const Vec3 p = facet_point(node, xi, eta) + distance * facet_normal(node, xi, eta);
    const FacetPoint r = closest_point(p, node);
    EXPECT_EQ(r.feature, FacetFeature::face);
    EXPECT_NEAR(r.xi, xi, 1e-9);
    EXPECT_NEAR(r.eta, eta, 1e-9);
    EXPECT_NEAR(r.distance, distance, 1e-12);
    expect_consistent(r, p, node, 5.0);
  }
}

// Random points anywhere near random facets, slender and skew ones too.
TEST(Facet, NoPointOfTheFacetIsNearer)
{
  std::mt19937 random(2);
  for (int test = 0; test < 200; ++test) {
    Vec3 node[4];
    const double slender = test % 3 == 0 ? 0.05 : 1.0;
    Mat3 skew = Mat3::Identity();
    skew(0, 1) = test % 4 == 1 ? 1.5 : 0.0;
    for (int i = 0; i < 4; ++i)
      node[i] = skew *
          (Vec3(1.0, slender, 1.0).cwiseProduct(square[i]) + random_vector(random, 0.15 * slender));
    const Vec3 p =
        Vec3(1.0, slender, 0.0) + Vec3(2.0, 2.0, 1.0).cwiseProduct(random_vector(random, 1.0));
    const FacetPoint r = closest_point(p, node);
    expect_consistent(r, p, node, 2.0);
    EXPECT_LT(std::abs(r.distance), by_brute_force(p, node) + 1e-7) << "test " << test;
  }
}

TEST(Facet, DegenerateFacets)
{
  // a triangle: two nodes coincide
  const Vec3 triangle[4] = {Vec3(0, 0, 0), Vec3(2, 0, 0), Vec3(0, 2, 0), Vec3(0, 2, 0)};
  FacetPoint r = closest_point(Vec3(0.5, 0.5, 0.7), triangle);
  EXPECT_LT((r.closest - Vec3(0.5, 0.5, 0.0)).norm(), 1e-12);
  EXPECT_NEAR(r.distance, 0.7, 1e-12);
  r = closest_point(Vec3(2.0, 2.0, 0.0), triangle);
  EXPECT_LT((r.closest - Vec3(1.0, 1.0, 0.0)).norm(), 1e-12);
  // a line and a point
  const Vec3 line[4] = {Vec3(0, 0, 0), Vec3(1, 0, 0), Vec3(2, 0, 0), Vec3(3, 0, 0)};
  EXPECT_NEAR(closest_point(Vec3(1.5, 1.0, 0.0), line).distance, 1.0, 1e-14);
  const Vec3 point[4] = {Vec3(1, 1, 1), Vec3(1, 1, 1), Vec3(1, 1, 1), Vec3(1, 1, 1)};
  r = closest_point(Vec3(1, 1, 3), point);
  EXPECT_NEAR(r.distance, 2.0, 1e-14);
  EXPECT_EQ(r.normal.norm(), 0.0);
}

TEST(Facet, AreaAndNormal)
{
  EXPECT_DOUBLE_EQ(facet_area(square), 4.0);
  EXPECT_LT((facet_area_vector(square) - Vec3(0, 0, 4)).norm(), 1e-15);
  std::mt19937 random(3);
  for (int test = 0; test < 20; ++test) {
    Vec3 node[4];
    for (int i = 0; i < 4; ++i) node[i] = square[i] + random_vector(random, 0.3);
    // the mean of the normals, weighted by area, by a fine sum
    Vec3 vector = Vec3::Zero();
    double area = 0.0;
    const int n = 40;
    const double h = 2.0 / n;
    for (int i = 0; i < n; ++i)
      for (int j = 0; j < n; ++j) {
        const double xi = -1.0 + (i + 0.5) * h, eta = -1.0 + (j + 0.5) * h;
        const Vec3 a =
            (facet_point(node, xi + 1e-4, eta) - facet_point(node, xi - 1e-4, eta)) / 2e-4;
        const Vec3 b =
            (facet_point(node, xi, eta + 1e-4) - facet_point(node, xi, eta - 1e-4)) / 2e-4;
        const Vec3 normal = a.cross(b);
        EXPECT_LT((normal.normalized() - facet_normal(node, xi, eta)).norm(), 1e-9);
        vector += h * h * normal;
        area += h * h * normal.norm();
      }
    EXPECT_LT((facet_area_vector(node) - vector).norm(), 1e-6);
    EXPECT_NEAR(facet_area(node), area, 2e-3 * area);
  }
}

// theory.md section 7: the impactor's 18 lower nodes (3 x 6, 4 x 10 mm) against the glass.
TEST(Penalty, ImpactorOfTheGlassBeam)
{
  const fe::IsotropicElastic glass{74.09e9, 0.2, 2500.0};
  const double A = 4e-6, V = 8e-9;
  const double k = penalty_stiffness_per_area(0.135, glass.bulk(), A, V);
  EXPECT_NEAR(k, 0.135 * glass.bulk() * 500.0, 1e-3);
  EXPECT_NEAR(k * A, 1.11e7, 0.005e7);    // one inner node
  // nodes in the edge planes z = 0 and 10 mm stand for half: 3 (4 + 2/2) = 15 full ones
  EXPECT_NEAR(k * A * 15.0, 1.67e8, 0.005e8);
}

TEST(ProjectPoint, FootOfTheNormalAlsoBesideTheFacet)
{
  // a warped facet, points over it and up to 0.2 (natural) beside it
  const Vec3 node[4] = {{0.0, 0.0, 0.0}, {1.0, 0.1, 0.05}, {1.1, 1.0, 0.0}, {-0.05, 0.9, 0.08}};
  for (double xi : {-1.2, -0.7, 0.0, 0.9, 1.15})
    for (double eta : {-1.1, 0.3, 1.2})
      for (double h : {-0.05, -1e-4, 0.03}) {
        const Vec3 n = defe::facet_normal(node, xi, eta);
        const Vec3 p = defe::facet_point(node, xi, eta) + h * n;
        const auto r = defe::project_point(p, node);
        EXPECT_NEAR(r.xi, xi, 1e-9);
        EXPECT_NEAR(r.eta, eta, 1e-9);
        EXPECT_NEAR(r.distance, h, 1e-12);
        // a force along the normal on p and its reaction on the nodes have no moment
        Vec3 foot = Vec3::Zero();
        double sum = 0.0;
        for (int a = 0; a < 4; ++a) {
          foot += r.N[a] * node[a];
          sum += r.N[a];
        }
        EXPECT_NEAR(sum, 1.0, 1e-14);
        EXPECT_LT((p - foot).cross(r.normal).norm(), 1e-9);
        EXPECT_EQ(r.feature == defe::FacetFeature::face,
                  std::abs(xi) <= 1.0 && std::abs(eta) <= 1.0);
      }
}

// Coordinates and heights of a parallelogram, whatever its neighbours in the batch are.
TEST(FacetPlane, CoordinatesOfAParallelogram)
{
  std::mt19937 random(3);
  for (const int n : {1, 7, 8, 19}) {
    std::vector<Vec3> x, mid, a, b;
    std::vector<std::array<int, 4>> node;
    for (int k = 0; k < n; ++k) {
      mid.push_back(random_vector(random, 5.0));
      a.push_back(random_vector(random, 1.0));
      b.push_back(random_vector(random, 1.0));
      // nodes of all facets, those of the last one first
      const int at = 4 * (n - 1 - k);
      node.push_back({at, at + 1, at + 2, at + 3});
      x.resize(4 * n);
      x[at] = mid[k] - a[k] - b[k];
      x[at + 1] = mid[k] + a[k] - b[k];
      x[at + 2] = mid[k] + a[k] + b[k];
      x[at + 3] = mid[k] - a[k] + b[k];
    }
    std::vector<FacetPlane> plane(n);
    facet_planes(n, reinterpret_cast<const int(*)[4]>(node.data()), x[0].data(), plane.data());
    for (int k = 0; k < n; ++k) {
      const FacetPlane &g = plane[k];
      const Vec3 normal = a[k].cross(b[k]).normalized();
      EXPECT_LT((g.mid - mid[k]).norm(), 1e-14);
      EXPECT_LT((g.normal - normal).norm(), 1e-12);
      EXPECT_LT(g.warp, 1e-14);
      const Vec3 del = 1.7 * a[k] - 0.4 * b[k] + 0.3 * normal;
      EXPECT_NEAR(del.dot(g.to_xi), 1.7, 1e-11);
      EXPECT_NEAR(del.dot(g.to_eta), -0.4, 1e-11);
      // the height of a parallelogram is its area by its base
      EXPECT_NEAR(g.half_xi(), a[k].cross(b[k]).norm() / b[k].norm(), 1e-12);
      EXPECT_NEAR(g.half_eta(), a[k].cross(b[k]).norm() / a[k].norm(), 1e-12);
    }
  }
}

// Warped: the corners are as far from the plane as it says.
TEST(FacetPlane, Warp)
{
  const Vec3 node[4] = {{0, 0, 0.1}, {2, 0, -0.1}, {2, 2, 0.1}, {0, 2, -0.1}};
  const int index[1][4] = {{0, 1, 2, 3}};
  FacetPlane g;
  facet_planes(1, index, node[0].data(), &g);
  EXPECT_NEAR(g.warp, 0.1, 1e-15);
  EXPECT_LT((g.mid - Vec3(1, 1, 0)).norm(), 1e-15);
  EXPECT_LT((g.normal - Vec3(0, 0, 1)).norm(), 1e-15);
}

// Points and spheres over a facet or a little beside it, after all have moved: before that, none was out
// of reach.
TEST(FacetPlane, NothingOutOfReachComesIntoContact)
{
  std::mt19937 random(4);
  const int index[1][4] = {{0, 1, 2, 3}};
  int contacts = 0, out = 0;
  for (int trial = 0; trial < 200000; ++trial) {
    const Mat3 turn = random_rotation(random);
    const double skin = uniform(random, 0.0, 0.3), depth = uniform(random, 0.1, 1.0);
    const double aside = uniform(random, 0.0, 0.8);
    Vec3 x[4];
    for (int a = 0; a < 4; ++a)
      x[a] = turn * (square[a] - Vec3(1, 1, 0) + random_vector(random, 0.15));
    const double r = trial % 2 ? uniform(random, 0.0, 0.8) : 0.0;
    const Vec3 p = random_vector(random, 2.5);
    FacetPlane before, after;
    facet_planes(1, index, x[0].data(), &before);
    const auto move = [&] {
      return Vec3(random_vector(random, 0.5 * skin / std::sqrt(3.0)));
    };
    Vec3 y[4];
    for (int a = 0; a < 4; ++a) y[a] = x[a] + move();
    const Vec3 q = p + move();
    facet_planes(1, index, y[0].data(), &after);
    const Vec3 del = q - after.mid;
    const double height = del.dot(after.normal);
    const bool contact = height < r && height > -depth &&
        (std::abs(del.dot(after.to_xi)) - 1.0) * after.half_xi() < aside &&
        (std::abs(del.dot(after.to_eta)) - 1.0) * after.half_eta() < aside;
    contacts += contact;
    const bool beyond = before.out_of_reach(p, r, depth, aside, skin);
    out += beyond;
    ASSERT_FALSE(contact && beyond) << "trial " << trial << ", r = " << r << ", skin = " << skin;
  }
  EXPECT_GT(contacts, 5000);
  EXPECT_GT(out, 80000) << "what is far away is out of reach";
}
