// Contact with a wall against closed forms: force is the gradient of the energy, a flat face presses with
// its area, friction slides at Coulomb's limit.

#include "defe/coupling/wall.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

using defe::Vec3;

namespace {

struct Face {
  Vec3 node[4];
  Vec3 normal = Vec3(0.0, 0.0, 1.0);    // of the plane z = 0
  double k_area = 3.0e12;

  double energy(Vec3 force[4], double push[4]) const
  {
    double depth[4];
    Vec3 n[4];
    for (int a = 0; a < 4; a++) {
      depth[a] = -node[a].dot(normal);
      n[a] = normal;
    }
    return defe::wall_face(node, depth, n, k_area, force, push);
  }
};

/// The lower face of a brick, counter-clockwise seen from below.
Face lower_face(double a, double b, double z)
{
  Face f;
  f.node[0] = Vec3(0, 0, z);
  f.node[1] = Vec3(0, b, z);
  f.node[2] = Vec3(a, b, z);
  f.node[3] = Vec3(a, 0, z);
  return f;
}

}    // namespace

TEST(Wall, FlatFacePressesWithItsArea)
{
  const double a = 2e-3, b = 3e-3, d = 1e-5;
  const Face f = lower_face(a, b, -d);
  Vec3 force[4], sum = Vec3::Zero();
  double push[4];
  const double energy = f.energy(force, push);
  for (int i = 0; i < 4; i++) {
    sum += force[i];
    EXPECT_NEAR(push[i], 0.25 * f.k_area * a * b * d, 1e-12 * f.k_area * a * b * d);
  }
  EXPECT_NEAR(sum[2], f.k_area * a * b * d, 1e-12 * sum[2]);
  EXPECT_NEAR(energy, 0.5 * f.k_area * a * b * d * d, 1e-12 * energy);
  EXPECT_LT(std::hypot(sum[0], sum[1]), 1e-12 * sum[2]);
}

// a face above the wall, one that looks away from it, and one that stands on it
TEST(Wall, FacesThatDoNotTouch)
{
  Vec3 force[4];
  double push[4];
  EXPECT_EQ(lower_face(2e-3, 2e-3, 1e-9).energy(force, push), 0.0);
  Face upper = lower_face(2e-3, 2e-3, -1e-5);
  std::swap(upper.node[1], upper.node[3]);
  EXPECT_EQ(upper.energy(force, push), 0.0);
  Face side;
  side.node[0] = Vec3(0, 0, -1e-5);
  side.node[1] = Vec3(2e-3, 0, -1e-5);
  side.node[2] = Vec3(2e-3, 0, 2e-3);
  side.node[3] = Vec3(0, 0, 2e-3);
  EXPECT_EQ(side.energy(force, push), 0.0);
  for (const auto &f : force) EXPECT_EQ(f.norm(), 0.0);
}

TEST(Wall, ForceIsTheGradientOfTheEnergy)
{
  std::mt19937 random(7);
  std::uniform_real_distribution<double> uniform(-1.0, 1.0);
  int touching = 0;
  for (int trial = 0; trial < 200; trial++) {
    Face f = lower_face(2e-3, 2e-3, -2e-5);
    for (auto &x : f.node) x += 3e-4 * Vec3(uniform(random), uniform(random), uniform(random));
    f.normal = (f.normal + 0.5 * Vec3(uniform(random), uniform(random), 0.0)).normalized();
    Vec3 force[4], other[4];
    double push[4];
    if (f.energy(force, push) == 0.0) continue;
    touching++;
    double scale = 0.0;
    for (const auto &v : force) scale = std::max(scale, v.norm());
    const double step = 1e-9;
    for (int a = 0; a < 4; a++)
      for (int k = 0; k < 3; k++) {
        Face plus = f, minus = f;
        plus.node[a][k] += step;
        minus.node[a][k] -= step;
        const double slope = (plus.energy(other, push) - minus.energy(other, push)) / (2.0 * step);
        EXPECT_NEAR(force[a][k], -slope, 1e-5 * scale) << "trial " << trial;
      }
    // what acts along the wall is internal to the face
    Vec3 sum = Vec3::Zero();
    for (const auto &v : force) sum += v;
    EXPECT_LT(sum.cross(f.normal).norm(), 1e-12 * scale);
  }
  EXPECT_GT(touching, 150);
}

// A rigid brick falls flat onto the wall: half a period of an oscillator, and off with its speed.
TEST(Wall, ReboundOfARigidBrick)
{
  const double a = 2e-3, mass = 2500.0 * a * a * a, v0 = 3.0;
  Face f = lower_face(a, a, 0.0);
  f.k_area = 4.0e9;
  const double omega = std::sqrt(f.k_area * a * a / mass), dt = 1e-3 / omega;
  double z = 0.0, v = -v0, deepest = 0.0;
  Vec3 force[4];
  double push[4];
  int steps = 0;
  double acceleration = 0.0;
  do {
    v += 0.5 * dt * acceleration;
    z += dt * v;
    for (auto &x : f.node) x[2] = z;
    f.energy(force, push);
    acceleration = (force[0] + force[1] + force[2] + force[3])[2] / mass;
    v += 0.5 * dt * acceleration;
    deepest = std::min(deepest, z);
    steps++;
  } while (z < 0.0 && steps < 100000);
  EXPECT_NEAR(v, v0, 1e-4 * v0);
  EXPECT_NEAR(deepest, -v0 / omega, 1e-4 * v0 / omega);
  EXPECT_NEAR(steps * dt * omega, std::acos(-1.0), 2e-3);
}

TEST(Wall, FrictionSlidesAtItsLimitAndCreepsBelow)
{
  const Vec3 n = Vec3(1.0, 2.0, -1.0).normalized(),
             along = n.cross(Vec3(0.0, 0.0, 1.0)).normalized();
  double power = 0.0;
  const Vec3 fast = defe::wall_friction(5.0 * along - 7.0 * n, n, 10.0, 0.3, 100.0, power);
  EXPECT_LT((fast + 3.0 * along).norm(), 1e-12);
  EXPECT_NEAR(power, 15.0, 1e-12);
  const Vec3 slow = defe::wall_friction(0.01 * along, n, 10.0, 0.3, 100.0, power);
  EXPECT_LT((slow + 1.0 * along).norm(), 1e-12);
  EXPECT_NEAR(power, 0.01, 1e-14);
  EXPECT_EQ(defe::wall_friction(-7.0 * n, n, 10.0, 0.3, 100.0, power).norm() > 1e-12, false);
  EXPECT_EQ(defe::wall_friction(Vec3::Zero(), n, 10.0, 0.3, 100.0, power).norm(), 0.0);
  EXPECT_EQ(power, 0.0);
}
