// The FE/DE patch test through LAMMPS: some elements of a block are converted, all particles are
// put where a linear displacement field has them, and the forces must vanish wherever the
// continuum's do.
//
// timeout: 120

#include "glass_block.h"
#include "mesh_file.h"

#include <Eigen/Geometry>

#include <cmath>

using namespace defe::test;
using defe::Mat3;
using defe::Vec3;

namespace {

constexpr int N = 5;    // elements per edge
constexpr double h = 2e-3;

/// Block of N x N x N elements, lower corner of the unsheared one at the origin.
struct Patch {
  Mat3 shear = Mat3::Identity();    // reference shape of the elements
  Mat3 F = Mat3::Identity();        // deformation gradient
  double nu = 0.2;
  int split = 2;
  std::vector<int> converted;    // element indices, from 0

  int des() const { return split * split * split; }
};

int component(int index, int axis, int n)
{
  return axis == 0 ? index % n : axis == 1 ? index / n % n : index / (n * n);
}

/// Largest force, in units of stress * h^2, on nodes and DEs for which `exact` says that it
/// vanishes: it is given the element coordinates of a DE, or the node coordinates (0..N) of a node.
template <class Exact> double residual(const Patch &patch, const Exact &exact)
{
  const std::string file = "patch.data";
  MeshFile mesh;
  mesh.add_block("glass", 1, N, N, N, h, [&](const Vec3 &X) {
    return Vec3(patch.shear * X);
  });
  mesh.write(file);

  Block block;
  block.nu = patch.nu;
  std::vector<Vec3> centres;
  for (int e : patch.converted)
    centres.push_back(patch.shear *
                      Vec3(h * (component(e, 0, N) + 0.5), h * (component(e, 1, N) + 0.5),
                           h * (component(e, 2, N) + 0.5)));
  block.regions = region_of("some", centres, h);
  block.convert += " start some split " + std::to_string(patch.split);
  block.options = "kernel lagrangian";
  Lammps lmp;
  lmp.commands(block.header() + block.box() + block.fix() + read_mesh(file) + block.motion());
  lmp.run(0);
  EXPECT_EQ(lmp.fe(DES), patch.des() * static_cast<double>(patch.converted.size()));
  EXPECT_EQ(lmp.fe(CONVERTED), static_cast<double>(patch.converted.size()));
  double largest = 0.0;
  const double modulus_h2 = block.E * h * h;
  // undeformed: rounding of x (1e-2 m, 1e-18) against h
  for (const auto &p : lmp.particles()) largest = std::max(largest, p.second.f.norm());
  EXPECT_LT(largest, 1e-13 * modulus_h2);

  const Vec3 c = patch.shear * Vec3::Constant(0.5 * N * h);
  lmp.change([&](Particle &p) {
    p.x = c + patch.F * (p.x - c);
  });
  lmp.run(0);

  const Mat3 green = 0.5 * (patch.F.transpose() * patch.F - Mat3::Identity());
  const double lambda = block.E * block.nu / ((1.0 + block.nu) * (1.0 - 2.0 * block.nu));
  const double mu = 0.5 * block.E / (1.0 + block.nu);
  const double stress = (lambda * green.trace() * Mat3::Identity() + 2.0 * mu * green).norm();
  largest = 0.0;
  int count = 0;
  double elsewhere = 0.0;
  constexpr int nodes = (N + 1) * (N + 1) * (N + 1);
  for (const auto &it : lmp.particles()) {
    const int k = static_cast<int>(it.first) - 1;
    int at[3];
    for (int a = 0; a < 3; a++)
      at[a] = k < nodes ? component(k, a, N + 1) : component((k - nodes) / patch.des(), a, N);
    const double f = it.second.f.norm() / (stress * h * h);
    if (exact(k >= nodes, at)) {
      largest = std::max(largest, f);
      count++;
    } else
      elsewhere = std::max(elsewhere, f);
  }
  EXPECT_GT(count, 50);
  EXPECT_GT(elsewhere, 0.01);    // the block's surface carries the stress
  return largest;
}

/// Every third element or so.
std::vector<int> some_elements(unsigned seed, const std::function<bool(const int *)> &eligible)
{
  std::mt19937 random(seed);
  std::vector<int> list;
  for (int e = 0; e < N * N * N; e++) {
    const int at[3] = {component(e, 0, N), component(e, 1, N), component(e, 2, N)};
    const bool chosen = random() % 5 < 2;
    if (chosen && eligible(at)) list.push_back(e);
  }
  return list;
}

/// Rotation by 0.4 rad about no particular axis.
Mat3 rotation()
{
  return Eigen::AngleAxisd(0.4, Vec3(1.0, -2.0, 0.5).normalized()).toRotationMatrix();
}

Mat3 sheared()
{
  Mat3 A;
  A << 1.0, 0.25, -0.1, 0.0, 0.9, 0.2, 0.0, 0.0, 1.1;
  return A;
}

/// Any linear field with elements converted inside. Positions of 1e-2 m have a rounding of 1e-18 m,
/// displacements over an element are 2e-5 m: relative forces of 1e-13 are rounding.
void inside(const Mat3 &shape, double nu, unsigned seed, int split = 2)
{
  Patch patch;
  patch.split = split;
  patch.shear = shape;
  patch.nu = nu;
  Mat3 U;
  U << 1.010, 0.004, -0.006, 0.004, 0.992, 0.003, -0.006, 0.003, 1.005;
  patch.F = rotation() * U;
  const auto inner = [](const int *at) {
    for (int a = 0; a < 3; a++)
      if (at[a] == 0 || at[a] == N - 1) return false;
    return true;
  };
  patch.converted = some_elements(seed, inner);
  ASSERT_GT(patch.converted.size(), 5u);
  const double r = residual(patch, [](bool is_de, const int *at) {
    if (is_de) return true;
    for (int a = 0; a < 3; a++)
      if (at[a] == 0 || at[a] == N) return false;
    return true;
  });
  EXPECT_LT(r, 1e-11);
}

/// Uniaxial stress along x with elements converted inside and at the free surfaces: only the two
/// end faces carry a load.
void uniaxial(const Mat3 &shape, double nu, unsigned seed, int split = 2)
{
  Patch patch;
  patch.split = split;
  patch.shear = shape;
  patch.nu = nu;
  const double e = 0.008;    // Green strain
  patch.F = rotation() *
      Vec3(std::sqrt(1.0 + 2.0 * e), std::sqrt(1.0 - 2.0 * nu * e), std::sqrt(1.0 - 2.0 * nu * e))
          .asDiagonal();
  patch.converted = some_elements(seed, [](const int *at) {
    return at[0] > 0 && at[0] < N - 1;
  });
  ASSERT_GT(patch.converted.size(), 20u);
  const double r = residual(patch, [](bool is_de, const int *at) {
    return is_de || (at[0] > 0 && at[0] < N);
  });
  EXPECT_LT(r, 1e-11);
}

}    // namespace

TEST(Patch, CubesInside)
{
  inside(Mat3::Identity(), 0.2, 1);
}

TEST(Patch, CubesInsideNearlyIncompressible)
{
  inside(Mat3::Identity(), 0.4, 2);
}

TEST(Patch, ShearedHexesInside)
{
  inside(sheared(), 0.3, 3);
}

TEST(Patch, CubesAtFreeSurfaces)
{
  uniaxial(Mat3::Identity(), 0.2, 4);
}

// sheared() keeps the lateral faces parallel to x
TEST(Patch, ShearedHexesAtFreeSurfaces)
{
  uniaxial(sheared(), 0.3, 5);
}

// Selective shear has no say in uniform strain. (Flatter ones touch the next but one, as spheres.)
TEST(Patch, FlatHexes)
{
  const Mat3 flat = Vec3(1.0, 0.8, 0.45).asDiagonal();
  inside(flat, 0.2, 9);
  inside(sheared() * flat, 0.3, 10);
  uniaxial(flat, 0.2, 11);
  uniaxial(sheared() * flat, 0.3, 12);
}

TEST(Patch, OtherSplits)
{
  for (int split : {1, 3}) {
    SCOPED_TRACE(split);
    inside(Mat3::Identity(), 0.2, 6, split);
    inside(sheared(), 0.3, 7, split);
    uniaxial(sheared(), 0.3, 8, split);
  }
}
