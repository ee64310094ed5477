// Facets: area vector, plane, what is out of reach; penalty stiffness.

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

}    // namespace

// Exact for warped facets: the mean of the normals, weighted by area, by a fine sum.
TEST(Facet, AreaVector)
{
  EXPECT_LT((facet_area_vector(square) - Vec3(0, 0, 4)).norm(), 1e-15);
  std::mt19937 random(3);
  for (int test = 0; test < 20; ++test) {
    Vec3 node[4];
    for (int i = 0; i < 4; ++i) node[i] = square[i] + random_vector(random, 0.3);
    const auto point = [&](double xi, double eta) {
      double N[4];
      facet_shape(xi, eta, N);
      return Vec3(N[0] * node[0] + N[1] * node[1] + N[2] * node[2] + N[3] * node[3]);
    };
    Vec3 vector = Vec3::Zero();
    const int n = 40;
    const double h = 2.0 / n;
    for (int i = 0; i < n; ++i)
      for (int j = 0; j < n; ++j) {
        const double xi = -1.0 + (i + 0.5) * h, eta = -1.0 + (j + 0.5) * h;
        const Vec3 a = (point(xi + 1e-4, eta) - point(xi - 1e-4, eta)) / 2e-4;
        const Vec3 b = (point(xi, eta + 1e-4) - point(xi, eta - 1e-4)) / 2e-4;
        vector += h * h * a.cross(b);
      }
    EXPECT_LT((facet_area_vector(node) - vector).norm(), 1e-6);
  }
}

// The impactor's 18 lower nodes (3 x 6, 4 x 10 mm) against the glass.
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
      const Vec3 del = 1.7 * a[k] - 0.4 * b[k] + 0.3 * normal;
      EXPECT_NEAR(del.dot(g.to_xi), 1.7, 1e-11);
      EXPECT_NEAR(del.dot(g.to_eta), -0.4, 1e-11);
      // the height of a parallelogram is its area by its base
      EXPECT_NEAR(g.half_xi(), a[k].cross(b[k]).norm() / b[k].norm(), 1e-12);
      EXPECT_NEAR(g.half_eta(), a[k].cross(b[k]).norm() / a[k].norm(), 1e-12);
    }
  }
}

// Of a warped facet the plane is that of the middles of its edges.
TEST(FacetPlane, OfAWarpedFacet)
{
  const Vec3 node[4] = {{0, 0, 0.1}, {2, 0, -0.1}, {2, 2, 0.1}, {0, 2, -0.1}};
  const int index[1][4] = {{0, 1, 2, 3}};
  FacetPlane g;
  facet_planes(1, index, node[0].data(), &g);
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
