// A ball on the faces of a block: felt where it touches, also on edges and corners, by the integral of its
// pressure, whatever its size and however the faces are numbered.

#include "defe/coupling/surface_contact.h"

#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <random>
#include <vector>

using namespace defe;

namespace {

using Nodes = std::array<Vec3, 4>;

constexpr double h = 2e-3;    // elements
constexpr double k_area = 1e13;

FacetPlane plane_of(const Nodes &x)
{
  double flat[12];
  for (int k = 0; k < 4; ++k)
    for (int d = 0; d < 3; ++d) flat[3 * k + d] = x[k][d];
  const int node[1][4] = {{0, 1, 2, 3}};
  FacetPlane plane;
  facet_planes(1, node, flat, &plane);
  return plane;
}

/// The faces of a block of 3 x 3 x 3 elements with a corner at the origin, which looks to +x, +y, +z.
std::vector<Nodes> block()
{
  std::vector<Nodes> faces;
  for (int axis = 0; axis < 3; ++axis)
    for (int i = -3; i < 0; ++i)
      for (int j = -3; j < 0; ++j) {
        const auto at = [&](int p, int q) {
          Vec3 x = Vec3::Zero();
          x[(axis + 1) % 3] = p * h;
          x[(axis + 2) % 3] = q * h;
          return x;
        };
        faces.push_back({at(i, j), at(i + 1, j), at(i + 1, j + 1), at(i, j + 1)});
      }
  return faces;
}

struct Push {
  double energy = 0.0;
  Vec3 force = Vec3::Zero();    // on the ball
};

Push push_on(const Vec3 &centre, double R, const std::vector<Nodes> &faces = block())
{
  Push all;
  for (const auto &face : faces) {
    FacetLoad load;
    const Vec3 sides = (face[1] - face[0]).cross(face[3] - face[0]);
    all.energy +=
        ball_on_facet(centre, R, plane_of(face), k_area, sides.norm(), all.force, load).energy;
  }
  return all;
}

/// The same by a fine grid of points on the part of each face that the ball can reach: the foot of its centre
/// is the nearest point of a convex body.
double integral(const Vec3 &centre, double R, const Vec3 &foot)
{
  double energy = 0.0;
  const int n = 400;
  for (int axis = 0; axis < 3; ++axis) {
    const double height = centre[axis];
    if (height <= 0.0 || height >= R) continue;
    const double reach = std::sqrt(R * R - (centre - foot).squaredNorm());
    double lo[2], hi[2];
    for (int k = 0; k < 2; ++k) {
      lo[k] = std::max(-3.0 * h, foot[(axis + 1 + k) % 3] - reach);
      hi[k] = std::min(0.0, foot[(axis + 1 + k) % 3] + reach);
    }
    if (lo[0] >= hi[0] || lo[1] >= hi[1]) continue;
    const double dA = (hi[0] - lo[0]) * (hi[1] - lo[1]) / (n * n);
    for (int i = 0; i < n; ++i)
      for (int j = 0; j < n; ++j) {
        Vec3 y = Vec3::Zero();
        y[(axis + 1) % 3] = lo[0] + (hi[0] - lo[0]) * (i + 0.5) / n;
        y[(axis + 2) % 3] = lo[1] + (hi[1] - lo[1]) * (j + 0.5) / n;
        const double g = R - (y - centre).norm();
        if (g > 0.0) energy += 0.5 * k_area * g * g * dA;
      }
  }
  return energy;
}

/// Where the ball stands over the block, and the point that it touches.
struct Place {
  const char *name;
  Vec3 foot, direction;
};
const Place places[] = {
    {"face", Vec3(-2.7e-3, -3.1e-3, 0.0), Vec3(0, 0, 1)},
    {"edge", Vec3(-2.7e-3, 0.0, 0.0), Vec3(0, 1, 1).normalized()},
    {"oblique edge", Vec3(-2.3e-3, 0.0, 0.0), Vec3(0, 1, 2).normalized()},
    {"corner", Vec3(0.0, 0.0, 0.0), Vec3(1, 1, 1).normalized()},
    {"oblique corner", Vec3(0.0, 0.0, 0.0), Vec3(1, 2, 1.5).normalized()},
};

}    // namespace

TEST(Ball, FeltWhereItTouches)
{
  for (const auto &p : places)
    for (const double R : {0.5e-3, 1.0e-3, 1.41e-3, 1.42e-3, 3.0e-3}) {
      SCOPED_TRACE(testing::Message() << p.name << ", R " << R);
      EXPECT_EQ(push_on(p.foot + (1.0 + 1e-9) * R * p.direction, R).energy, 0.0);
      EXPECT_GT(push_on(p.foot + (1.0 - 1e-9) * R * p.direction, R).energy, 0.0);
      for (const double depth : {1e-3, 0.01, 0.1}) {
        const Vec3 c = p.foot + (1.0 - depth) * R * p.direction;
        const Push r = push_on(c, R);
        EXPECT_NEAR(r.energy / integral(c, R, p.foot), 1.0, 0.01) << depth;
        EXPECT_GT(r.force.dot(p.direction), 0.95 * r.force.norm());
      }
    }
}

TEST(Ball, NumberingDoesNotMatter)
{
  std::mt19937 random(3);
  std::uniform_real_distribution<double> u(-1.0, 1.0);
  for (int count = 0; count < 2000;) {
    Nodes x = {Vec3(-1, -1, 0), Vec3(1, -1, 0), Vec3(1, 1, 0), Vec3(-1, 1, 0)};
    for (auto &n : x) n += 0.3 * Vec3(u(random), u(random), 0.0);
    const double R = 1.5 + u(random);
    const Vec3 c(1.2 * u(random), 1.2 * u(random), R * (1.0 - 0.1 * (1.001 + u(random))));
    FacetLoad load, turned;
    Vec3 a = Vec3::Zero(), b = Vec3::Zero();
    const double one = ball_on_facet(c, R, plane_of(x), 1.0, 4.0, a, load).energy;
    if (one < 1e-6) continue;
    count++;
    const double other =
        ball_on_facet(c, R, plane_of({x[1], x[2], x[3], x[0]}), 1.0, 4.0, b, turned).energy;
    EXPECT_NEAR(other / one, 1.0, 1e-11);
    EXPECT_LT((a - b).norm(), 1e-11 * a.norm());
  }
}

// One size more must not change anything but by that: no limit of sizes, of facets or of their diagonals.
TEST(Ball, NoJumpsBetweenSizes)
{
  for (const auto &p : places)
    for (double R = 0.5e-3; R < 3.0e-3; R += 0.01e-3) {
      const double depth = 0.02e-3;
      const double a = push_on(p.foot + (R - depth) * p.direction, R).force.norm();
      const double b =
          push_on(p.foot + (R + 0.01e-3 - depth) * p.direction, R + 0.01e-3).force.norm();
      EXPECT_NEAR(b / a, 1.0, 0.03) << p.name << " " << R;
    }
}

// Over an edge and over a corner, pressing: no jump in energy or force, and the force is the derivative.
TEST(Ball, RollsOverEdges)
{
  for (const double R : {0.7e-3, 1.42e-3, 3e-3})
    for (const double y : {-3e-3, -0.1e-3}) {
      Push last;
      double work = 0.0, largest = 0.0;
      const double depth = 0.1 * R, step = 2e-4 * R;
      double first = 0.0;
      for (double s = -1.0 * R; s < 0.9 * R; s += step) {
        const Push now = push_on(Vec3(s, y, R - depth), R);
        if (s == -R)
          first = now.energy;
        else {
          work -= 0.5 * (now.force[0] + last.force[0]) * step;
          EXPECT_NEAR(now.energy, first + work, 1e-3 * first) << s / R;
          EXPECT_LT((now.force - last.force).norm(), 0.02 * std::max(largest, now.force.norm()))
              << s / R;
        }
        largest = std::max(largest, now.force.norm());
        last = now;
      }
    }
}
