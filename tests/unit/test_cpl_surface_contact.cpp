// Contact of surfaces: patches, spheres and balls against facets are potentials whose forces are exact
// derivatives, continuous where one facet takes over from the next.

#include "defe/coupling/surface_contact.h"

#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <functional>
#include <random>

using namespace defe;

namespace {

using Nodes = std::array<Vec3, 4>;

FacetPlane plane_of(const Nodes &x)
{
  static constexpr int node[1][4] = {{0, 1, 2, 3}};
  double flat[12];
  for (int k = 0; k < 4; ++k)
    for (int c = 0; c < 3; ++c) flat[3 * k + c] = x[k][c];
  FacetPlane plane;
  facet_planes(1, node, flat, &plane);
  return plane;
}

/// A patch (or sphere, or ball) and a facet: coordinates 0..3 of the patch's facet (or the centre), 4..7 of
/// the facet.
struct State {
  Nodes own, facet;
};

struct Result {
  double energy = 0.0;
  State force;
};

Result zero()
{
  Result r;
  for (auto *n : {&r.force.own, &r.force.facet})
    for (Vec3 &f : *n) f.setZero();
  return r;
}

void add_load(const FacetLoad &load, Nodes &f)
{
  for (int k = 0; k < 4; ++k) f[k] += load.on_node(k);
}

Result patch(const State &s, int corner, const SurfacePair &pair, double offset)
{
  Result r = zero();
  const FacetPlane own = plane_of(s.own), facet = plane_of(s.facet);
  const SurfaceContact c = patch_on_facet(own, corner, s.own[corner], facet, pair);
  if (c.share == 0.0) return r;
  FacetLoad on_own, on_facet;
  r.energy = patch_force(c, offset, own, corner, facet, pair, r.force.own[corner], on_own, on_facet)
                 .energy;
  add_load(on_own, r.force.own);
  add_load(on_facet, r.force.facet);
  return r;
}

Result sphere(const State &s, double radius, const SurfacePair &pair)
{
  Result r = zero();
  const FacetPlane facet = plane_of(s.facet);
  const SurfaceContact c = sphere_on_facet(s.own[0], radius, facet, pair);
  if (c.share == 0.0) return r;
  FacetLoad on_facet;
  r.energy = sphere_force(c, 0.0, radius, facet, pair, r.force.own[0], on_facet).energy;
  add_load(on_facet, r.force.facet);
  return r;
}

Result ball(const State &s, double radius)
{
  Result r = zero();
  FacetLoad on_facet;
  r.energy =
      ball_on_facet(s.own[0], radius, plane_of(s.facet), 1.0, 4.0, r.force.own[0], on_facet).energy;
  add_load(on_facet, r.force.facet);
  return r;
}

/// Forces against central differences of the energy, relative to the largest force; momentum and angular
/// momentum to rounding.
void expect_potential(const State &s, const std::function<Result(const State &)> &contact,
                      double tolerance)
{
  const Result r = contact(s);
  double largest = 0.0;
  Vec3 sum = Vec3::Zero(), moment = Vec3::Zero();
  for (int k = 0; k < 4; ++k) {
    sum += r.force.own[k] + r.force.facet[k];
    moment += s.own[k].cross(r.force.own[k]) + s.facet[k].cross(r.force.facet[k]);
    largest = std::max({largest, r.force.own[k].norm(), r.force.facet[k].norm()});
  }
  ASSERT_GT(r.energy, 0.0);
  EXPECT_LT(sum.norm(), 1e-13 * largest);
  EXPECT_LT(moment.norm(), 1e-12 * largest);
  const double step = 1e-6;
  for (int side = 0; side < 2; ++side)
    for (int k = 0; k < 4; ++k)
      for (int c = 0; c < 3; ++c) {
        State plus = s, minus = s;
        (side ? plus.facet : plus.own)[k][c] += step;
        (side ? minus.facet : minus.own)[k][c] -= step;
        const double expected = (contact(minus).energy - contact(plus).energy) / (2.0 * step);
        EXPECT_NEAR((side ? r.force.facet : r.force.own)[k][c], expected, tolerance * largest)
            << (side ? "facet" : "own") << " node " << k << " component " << c;
      }
}

const SurfacePair unit_pair{1.0, 0.5, 0.4, 1.0, 1.0, 1.0};
const Nodes square = {Vec3(-1, -1, 0), Vec3(1, -1, 0), Vec3(1, 1, 0), Vec3(-1, 1, 0)};

class Random {
 public:
  double operator()(double low, double high)
  {
    return std::uniform_real_distribution<double>(low, high)(engine);
  }
  Vec3 vector(double size)
  {
    return Vec3((*this)(-size, size), (*this)(-size, size), (*this)(-size, size));
  }

 private:
  std::mt19937 engine{7};
};

/// A facet that looks down on the square, turned and moved at random.
State random_pair(Random &random)
{
  State s;
  const Mat3 turn = (Eigen::AngleAxisd(random(-0.6, 0.6), Vec3(1, 0.3, 0).normalized()) *
                     Eigen::AngleAxisd(random(-3.0, 3.0), Vec3::UnitZ()))
                        .toRotationMatrix();
  const double size = random(0.4, 1.5);
  const Vec3 middle(random(-1.3, 1.3), random(-1.3, 1.3), random(-0.3, 0.1));
  for (int k = 0; k < 4; ++k) {
    const Vec3 down(square[k][0], -square[k][1], 0.0);
    s.own[k] = middle + turn * (size * down) + random.vector(0.05);
    s.facet[k] = square[k] + random.vector(0.1);
  }
  return s;
}

}    // namespace

TEST(SurfaceContact, PatchForceIsTheDerivativeOfTheEnergy)
{
  Random random;
  int limited = 0, shared = 0, count = 0;
  while (count < 300) {
    const State s = random_pair(random);
    const int corner = count % 4;
    const SurfaceContact c =
        patch_on_facet(plane_of(s.own), corner, s.own[corner], plane_of(s.facet), unit_pair);
    if (c.share < 1e-3 || c.depth < 1e-3) continue;
    count++;
    if (c.depth < c.raw_depth) limited++;
    if (c.share_xi * c.share_eta < 1.0) shared++;
    const double offset = count % 3 ? 0.0 : 0.3 * c.depth;
    expect_potential(
        s,
        [&](const State &t) {
          return patch(t, corner, unit_pair, offset);
        },
        2e-6);
  }
  EXPECT_GT(limited, 30);
  EXPECT_GT(shared, 100);
}

TEST(SurfaceContact, SphereForceIsTheDerivativeOfTheEnergy)
{
  Random random;
  for (int count = 0; count < 300;) {
    State s = random_pair(random);
    const double radius = 0.3;
    s.own[0][2] = random(-0.3, 0.3);
    const SurfaceContact c = sphere_on_facet(s.own[0], radius, plane_of(s.facet), unit_pair);
    if (c.share < 1e-3 || c.depth < 1e-3) continue;
    count++;
    expect_potential(
        s,
        [&](const State &t) {
          return sphere(t, radius, unit_pair);
        },
        2e-6);
  }
}

// What is left out, the change of the quadrature's rectangle with the facet's strain, is small, and
// nothing if the facet moves as a rigid body or the ball covers it.
TEST(SurfaceContact, BallForceIsTheDerivativeOfTheEnergy)
{
  Random random;
  for (int count = 0; count < 200;) {
    State s = random_pair(random);
    const double radius = random(0.3, 6.0);
    s.own[0] = Vec3(random(-1.2, 1.2), random(-1.2, 1.2), radius * (1.0 - random(0.01, 0.2)));
    if (!(ball(s, radius).energy > 1e-6)) continue;
    count++;
    const auto contact = [&](const State &t) {
      return ball(t, radius);
    };
    expect_potential(s, contact, 2e-2);
    const double step = 1e-6;
    const Vec3 f = contact(s).force.own[0];
    for (int c = 0; c < 3; ++c) {
      State plus = s, minus = s;
      plus.own[0][c] += step;
      minus.own[0][c] -= step;
      EXPECT_NEAR(f[c], (contact(minus).energy - contact(plus).energy) / (2.0 * step),
                  1e-5 * f.norm());
    }
  }
}

// A strip of four facets of different lengths: a patch that slides along it, and beyond its end.
TEST(SurfaceContact, SharesOfNeighboursAddUpToOne)
{
  const double lines[] = {0.0, 0.7, 1.1, 2.4, 3.0};
  const double reach = 0.3;    // of the patch, to each side
  for (double x = -0.5; x < 3.5; x += 0.01) {
    double sum = 0.0;
    for (int f = 0; f < 4; ++f) {
      const double half = 0.5 * (lines[f + 1] - lines[f]), mid = 0.5 * (lines[f + 1] + lines[f]);
      sum += patch_share((x - mid) / half, reach / half).value;
    }
    const double inside = std::min(x, 3.0 - x) / reach;
    if (inside >= 1.0)
      EXPECT_NEAR(sum, 1.0, 1e-14);
    else if (inside <= -1.0)
      EXPECT_NEAR(sum, 0.0, 1e-14);
    else
      EXPECT_NEAR(sum, 0.5 + 0.75 * inside - 0.25 * inside * inside * inside, 1e-14);
  }
}

// Flush rims: a facet on a facet of the same size carries as a pressure on its area, all at once.
TEST(SurfaceContact, FlushFacetsPressWithTheirWholeArea)
{
  State s;
  const double depth = 0.01;
  for (int k = 0; k < 4; ++k) {
    s.facet[k] = square[k];
    s.own[k] = Vec3(square[k][0], -square[k][1], -depth);
  }
  const double area = 4.0, k_area = 3.0;
  Result sum = zero();
  for (int corner = 0; corner < 4; ++corner) {
    const SurfacePair pair{0.25 * area * k_area, 0.5, 0.5, 1.0, 1.0, 1e3};
    const Result r = patch(s, corner, pair, 0.0);
    sum.energy += r.energy;
    for (int k = 0; k < 4; ++k) {
      sum.force.own[k] += r.force.own[k];
      sum.force.facet[k] += r.force.facet[k];
    }
  }
  EXPECT_NEAR(sum.energy / (0.5 * k_area * area * depth * depth), 1.0, 1e-8);
  for (int k = 0; k < 4; ++k) {
    EXPECT_NEAR(sum.force.own[k][2] / (0.25 * area * k_area * depth), 1.0, 1e-8);
    EXPECT_NEAR(sum.force.facet[k][2] / (0.25 * area * k_area * depth), -1.0, 1e-8);
    EXPECT_LT(sum.force.own[k].head<2>().norm(), 1e-12);
  }
}

// A body stands on another one, overhanging, its side half an element behind the side of the other: they
// touch by a thousandth only, and the sides must not take each other for deep inside.
TEST(SurfaceContact, SidesRoundACornerAreNoContact)
{
  const double touch = 1e-3;
  State s;
  // facet: side of the lower block, x = 0, z from -2 to 0, looks to +x
  s.facet = {Vec3(0, -1, -2), Vec3(0, 1, -2), Vec3(0, 1, 0), Vec3(0, -1, 0)};
  // patch: side of the upper block, at x = -0.9, z from -touch upwards, looks to -x
  s.own = {Vec3(-0.9, 1, -touch), Vec3(-0.9, -1, -touch), Vec3(-0.9, -1, 2 - touch),
           Vec3(-0.9, 1, 2 - touch)};
  const SurfacePair pair{1.0, 0.5, 0.5, 1.0, 1.0, 1.0};
  double side = 0.0;
  for (int corner = 0; corner < 4; ++corner) side += patch(s, corner, pair, 0.0).energy;
  const double standing = 0.5 * touch * touch;    // of one patch of the standing face
  EXPECT_LT(side, 1e-5 * standing);
}

TEST(SurfaceContact, NumberingOfTheNodesDoesNotMatter)
{
  Random random;
  for (int count = 0; count < 50;) {
    const State s = random_pair(random);
    const SurfacePair pair{1.0, 0.4, 0.4, 1.0, 1.0, 1.0};
    const Result r = patch(s, 1, pair, 0.0);
    if (r.energy == 0.0) continue;
    count++;
    for (int turn = 1; turn < 4; ++turn) {
      State t;
      for (int k = 0; k < 4; ++k) {
        t.own[k] = s.own[(k + turn) % 4];
        t.facet[k] = s.facet[(k + 4 - turn) % 4];
      }
      const Result q = patch(t, (1 + 4 - turn) % 4, pair, 0.0);
      EXPECT_NEAR(q.energy / r.energy, 1.0, 1e-11);
      for (int k = 0; k < 4; ++k)
        EXPECT_LT((q.force.own[k] - r.force.own[(k + turn) % 4]).norm(),
                  1e-11 * r.force.own[1].norm());
    }
  }
}

// Smooth plane of facets, ball of any size: the closed form, wherever it lands.
TEST(SurfaceContact, BallOnAPlaneOfFacets)
{
  const double k_area = 2.0;
  for (double R : {0.4, 2.0, 20.0}) {
    for (double depth : {0.002, 0.02, 0.1}) {
      const double d = depth * std::min(R, 1.0);
      // integral of (R - rho)^2/2 over the plane at height h
      const double h = R - d;
      const auto primitive = [R](double rho) {
        return R * R * rho * rho / 2.0 - 2.0 * R * rho * rho * rho / 3.0 +
            rho * rho * rho * rho / 4.0;
      };
      const double expected = k_area * M_PI * (primitive(R) - primitive(h));
      EXPECT_NEAR(expected / (k_area * M_PI * R * d * d * d / 3.0), 1.0, d / R);
      double low = 1e300, high = 0.0;
      for (int p = 0; p < 12; ++p) {
        const Vec3 centre(0.5 + 0.11 * p, 0.3 + 0.07 * p, h);
        double energy = 0.0, push = 0.0;
        Vec3 on_ball = Vec3::Zero();
        const int n = 8;
        for (int i = -n; i < n; ++i)
          for (int j = -n; j < n; ++j) {
            const Nodes x = {Vec3(i, j, 0), Vec3(i + 1, j, 0), Vec3(i + 1, j + 1, 0),
                             Vec3(i, j + 1, 0)};
            FacetLoad load;
            const BallForce f = ball_on_facet(centre, R, plane_of(x), k_area, 1.0, on_ball, load);
            energy += f.energy;
            push += f.normal;
          }
        EXPECT_NEAR(energy / expected, 1.0, 0.01) << R << " " << d << " " << centre.transpose();
        low = std::min(low, on_ball[2]);
        high = std::max(high, on_ball[2]);
        EXPECT_LT(on_ball.head<2>().norm(), 0.02 * on_ball[2]);
      }
      EXPECT_LT(high / low, 1.01) << R << " " << d;
    }
  }
}
