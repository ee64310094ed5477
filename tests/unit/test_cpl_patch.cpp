// The FE/DE patch test: any set of converted elements, any linear displacement field: nothing moves

#include "de_block.h"

#include <gtest/gtest.h>

#include <cstdio>
#include <string>

using namespace defe;
using namespace defe::test;

namespace {

constexpr int N = 5;    // elements per edge

int component(int e, int axis)
{
  return axis == 0 ? e % N : (axis == 1 ? e / N % N : e / (N * N));
}

bool inner_element(int e)
{
  for (int a = 0; a < 3; ++a)
    if (component(e, a) == 0 || component(e, a) == N - 1) return false;
  return true;
}

bool inner_node(int n)
{
  const int c[3] = {n % (N + 1), n / (N + 1) % (N + 1), n / ((N + 1) * (N + 1))};
  for (int a : c)
    if (a == 0 || a == N) return false;
  return true;
}

/// Rotation times stretch; rounded so that positions of the regular mesh are exact numbers and the
/// residual is that of the forces alone.
Mat3 random_gradient(std::mt19937 &random, double strain)
{
  Mat3 U = Mat3::Identity();
  for (int i = 0; i < 3; ++i)
    for (int j = 0; j < 3; ++j) U(i, j) += uniform(random, -strain, strain);
  Mat3 F = random_rotation(random) * U;
  for (int i = 0; i < 9; ++i)
    F(i / 3, i % 3) = std::ldexp(std::round(std::ldexp(F(i / 3, i % 3), 26)), -26);
  return F;
}

/// Scale of the stress: Frobenius norm of the second Piola-Kirchhoff stress.
double stress_norm(const fe::IsotropicElastic &m, const Mat3 &F)
{
  const Mat3 E = 0.5 * (F.transpose() * F - Mat3::Identity());
  return (m.lambda() * E.trace() * Mat3::Identity() + 2.0 * m.mu() * E).norm();
}

struct Residual {
  double largest = 0.0, sum2 = 0.0;
  long count = 0;

  void add(const Vec3 &force, double unit)
  {
    const double r = force.norm() / unit;
    largest = std::max(largest, r);
    sum2 += r * r / 3.0;
    count += 1;
  }
  /// root mean square of one component
  double rms() const { return std::sqrt(sum2 / count); }
};

/// Random sets of inner elements are converted; residual of all inner nodes and all DEs, in units
/// of sigma d^2 with d = h/2 = 0.5 of eight DEs, and so for other splits.
Residual patch_test(const std::function<Mesh(int)> &make, double nu, double strain, int tries = 10,
                    bool orthogonal = false, ElementSplit split = ElementSplit())
{
  std::mt19937 random(17);
  const fe::IsotropicElastic material{1.0, nu, 1.0};
  Residual residual;
  for (int k = 0; k < tries; ++k) {
    Mesh mesh = make(k);
    shuffle_local_axes(mesh, random);
    std::vector<char> converted(mesh.hex.size());
    for (std::size_t e = 0; e < converted.size(); ++e)
      converted[e] = inner_element(e) && uniform(random, 0.0, 1.0) < 0.15 * (k + 0.5) / tries * 6.0;
    Block block(mesh, converted, material, split);
    block.orthogonal = orthogonal;
    const Mat3 F = random_gradient(random, strain);
    const double unit = stress_norm(material, F) / (split.along() * split.along());
    Vectors f;
    block.forces(deformed(block.X, F), f);
    for (int i = 0; i < static_cast<int>(f.size()); ++i)
      if (block.mass[i] > 0.0 && (i >= block.nodes() || inner_node(i))) residual.add(f[i], unit);
  }
  return residual;
}

Mesh cubes(int)
{
  return box_mesh(N, N, N, 1.0);
}

Mesh sheared(int)
{
  Mat3 A;
  A << 1.0, 0.25, -0.125, 0.125, 0.75, 0.25, 0.0, -0.25, 1.25;
  return box_mesh(N, N, N, 1.0, [A](const Vec3 &X) {
    return Vec3(A * X);
  });
}

Mesh graded(int)
{
  return box_mesh(N, N, N, 1.0, [](const Vec3 &X) {
    return Vec3(X[0] < 0.0 ? 2.0 * X[0] : X[0], X[1] > 0.6 ? 1.5 * X[1] : X[1], 0.75 * X[2]);
  });
}

Mesh distorted(double amount, int seed)
{
  std::mt19937 random(seed);
  return box_mesh(N, N, N, 1.0, [&](const Vec3 &X) {
    return Vec3(X + random_vector(random, amount));
  });
}

}    // namespace

// d^2 = h^2/4: 1e-12 of sigma h^2 is 4e-12 here.
TEST(Patch, Cubes)
{
  for (double nu : {0.0, 0.2, 0.3, 0.4})
    for (double strain : {1e-3, 1e-2}) {
      EXPECT_LT(patch_test(cubes, nu, strain).largest, 4e-12);
      EXPECT_LT(patch_test(cubes, nu, strain, 10, true).largest, 4e-12);
    }
}

TEST(Patch, ShearedHexes)
{
  for (double nu : {0.0, 0.2, 0.4})
    for (double strain : {1e-3, 1e-2}) EXPECT_LT(patch_test(sheared, nu, strain).largest, 4e-12);
}

// Boxes of different sizes side by side: needs the cell's thickness to be that of the element's
// eighth (with half the joint's length the residual would be some per cent).
TEST(Patch, GradedBoxes)
{
  for (double nu : {0.0, 0.2, 0.4}) {
    EXPECT_LT(patch_test(graded, nu, 1e-3).largest, 4e-12);
    EXPECT_LT(patch_test(graded, nu, 1e-3, 10, true).largest, 4e-12);
  }
}

// One or 27 DEs for an element: ties and joints, on any box or sheared hex. 1e-12 of sigma h^2; at thirds of edges
// positions are rounded, so the strain is not too small.
TEST(Patch, OtherSplits)
{
  for (int along : {1, 3}) {
    const ElementSplit split(along);
    const double limit = 1e-12 * along * along;
    for (double nu : {0.0, 0.3}) {
      for (bool orthogonal : {false, true}) {
        EXPECT_LT(patch_test(cubes, nu, 1e-2, 10, orthogonal, split).largest, limit) << along;
        EXPECT_LT(patch_test(graded, nu, 1e-2, 10, orthogonal, split).largest, limit) << along;
      }
      EXPECT_LT(patch_test(sheared, nu, 1e-2, 10, false, split).largest, limit) << along;
    }
  }
}

// Not exact, but small: the corner volumes do not match the areas of warped patches.
TEST(Patch, DistortedHexes)
{
  const double amount[3] = {0.05, 0.10, 0.20}, rms[3] = {0.006, 0.012, 0.024};
  for (int k = 0; k < 3; ++k) {
    const Residual r = patch_test(
        [&](int seed) {
          return distorted(amount[k], seed);
        },
        0.2, 1e-3, 20);
    std::printf("nodes moved by up to %2.0f %%: residual %.2f %% rms, %.1f %% at most\n",
                100.0 * amount[k], 100.0 * r.rms(), 100.0 * r.largest);
    EXPECT_GT(r.rms(), 0.7 * rms[k]);
    EXPECT_LT(r.rms(), 1.3 * rms[k]);
  }
}

// Conversions on the free sides of a bar under uniaxial stress: the reduced laws of the corners
// with missing joints are exact.
TEST(Patch, FreeSurfacesUnderUniaxialStress)
{
  std::mt19937 random(23);
  for (double nu : {0.0, 0.2, 0.4})
    for (bool orthogonal : {false, true})
      for (int axis = 0; axis < 3; ++axis) {
        const fe::IsotropicElastic material{1.0, nu, 1.0};
        Mesh mesh = cubes(0);
        shuffle_local_axes(mesh, random);
        std::vector<char> converted(mesh.hex.size());
        for (std::size_t e = 0; e < converted.size(); ++e) {
          const int along = component(e, axis);
          converted[e] = along > 0 && along < N - 1 && uniform(random, 0.0, 1.0) < 0.4;
        }
        Block block(mesh, converted, material);
        block.orthogonal = orthogonal;
        const double eps = 1e-2;
        Vec3 stretch;
        for (int a = 0; a < 3; ++a)
          stretch[a] = std::sqrt(1.0 + 2.0 * eps * (a == axis ? 1.0 : -nu));
        const Mat3 F = random_rotation(random) * stretch.asDiagonal();
        Vectors f;
        block.forces(deformed(block.X, F), f);
        Residual residual;
        for (int i = 0; i < static_cast<int>(f.size()); ++i)
          if (block.mass[i] > 0.0 && std::abs(block.X[i][axis]) < 2.4)
            residual.add(f[i], eps * 0.25);
        EXPECT_GT(residual.count, 100);
        EXPECT_LT(residual.largest, 4e-12);
      }
}

// The same on sheared hexes, uniaxial along their common edge direction: the planes of the joints
// that are left are then the free surfaces.
TEST(Patch, FreeSurfacesOfShearedHexes)
{
  std::mt19937 random(29);
  const fe::IsotropicElastic material{1.0, 0.3, 1.0};
  Mat3 A;
  A << 1.0, 0.25, 0.0, 0.0, 0.75, 0.0, 0.0, 0.0, 1.25;    // a prism with an oblique cross-section
  Mesh mesh = box_mesh(N, N, N, 1.0, [&](const Vec3 &X) {
    return Vec3(A * X);
  });
  shuffle_local_axes(mesh, random);
  std::vector<char> converted(mesh.hex.size());
  for (std::size_t e = 0; e < converted.size(); ++e) {
    const int along = component(e, 2);
    converted[e] = along > 0 && along < N - 1 && uniform(random, 0.0, 1.0) < 0.4;
  }
  const Block block(mesh, converted, material);
  const double eps = 1e-2;
  const Vec3 stretch(std::sqrt(1.0 - 0.6 * eps), std::sqrt(1.0 - 0.6 * eps),
                     std::sqrt(1.0 + 2.0 * eps));
  Vectors f;
  block.forces(deformed(block.X, stretch.asDiagonal()), f);
  Residual residual;
  for (int i = 0; i < static_cast<int>(f.size()); ++i)
    if (block.mass[i] > 0.0 && std::abs(block.X[i][2]) < 3.0) residual.add(f[i], eps * 0.25);
  EXPECT_GT(residual.count, 100);
  EXPECT_LT(residual.largest, 4e-12);
}
