// Lattices of flat DEs: selective shear of corner_strain.h. How hard they bend, that uniform strain does not notice, that nothing loses its
// stiffness, and that no energy comes up where a joint leaves.

#include "de_block.h"

#include <gtest/gtest.h>

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <algorithm>
#include <memory>

using namespace defe;
using namespace defe::test;

namespace {

using Eigen::MatrixXd;
using Eigen::VectorXd;

std::vector<char> all(const Mesh &mesh)
{
  return std::vector<char>(mesh.hex.size(), 1);
}

/// What corner_strain.h says of a DE that has all joints, without selective shear.
double plain_energy(const GeneralCell &cell, const Vec3 y[6], const CornerModuli &m)
{
  double sum = 0.0;
  for (int corner = 0; corner < 8; ++corner) {
    Mat3 M, h, D;
    for (int a = 0; a < 3; ++a) {
      const int s = 2 * a + (corner >> a & 1);
      M.col(a) = cell.dX[s];
      h.col(a) = cell.face[s];
      D.col(a) = y[s];
    }
    const Mat3 F = D * M.inverse(), E = 0.5 * (F.transpose() * F - Mat3::Identity());
    sum += std::abs(h.determinant()) *
        (0.5 * m.lambda * E.trace() * E.trace() + m.mu * E.squaredNorm());
  }
  return sum;
}

/// A DE inside of a lattice with the edges `g`, in columns, its joints moved by `uneven` of their lengths.
GeneralCell cell_of_lattice(const Mat3 &g, std::mt19937 &random, double uneven)
{
  GeneralCell cell;
  cell.tie = 0;
  for (int s = 0; s < 6; ++s) {
    const double sign = s % 2 ? 1.0 : -1.0;
    const double size = uneven * g.colwise().norm().minCoeff();
    cell.dX[s] = sign * g.col(s / 2) + random_vector(random, size);
    cell.face[s] = 0.5 * sign * g.col(s / 2) + 0.5 * random_vector(random, size);
  }
  return cell;
}

/// Second derivatives in the six joint vectors of an energy that is quadratic in small displacements.
template <class Energy> MatrixXd stiffness(const GeneralCell &cell, const Energy &energy)
{
  const double step = 1e-5 * cell.dX[1].norm();
  const auto at = [&](int i, double di, int j, double dj) {
    Vec3 y[6];
    for (int s = 0; s < 6; ++s) y[s] = cell.dX[s];
    y[i / 3][i % 3] += di;
    y[j / 3][j % 3] += dj;
    return energy(y);
  };
  MatrixXd K(18, 18);
  for (int i = 0; i < 18; ++i)
    for (int j = 0; j <= i; ++j)
      K(i, j) = K(j, i) = (at(i, step, j, step) - at(i, step, j, -step) - at(i, -step, j, step) +
                           at(i, -step, j, -step)) /
          (4.0 * step * step);
  return K;
}

/// Stiffness of a block at rest, by its forces.
MatrixXd stiffness(const Block &block)
{
  const int n0 = block.nodes(), dofs = 3 * block.des();
  MatrixXd K(dofs, dofs);
  const double step = 1e-9;
  Vectors x = block.X, up, down;
  for (int j = 0; j < dofs; ++j) {
    double &moved = x[n0 + j / 3][j % 3];
    const double at = moved;
    moved = at + step;
    up.assign(x.size(), Vec3::Zero());
    block.joint_forces(x, up);
    moved = at - step;
    down.assign(x.size(), Vec3::Zero());
    block.joint_forces(x, down);
    moved = at;
    for (int i = 0; i < dofs; ++i)
      K(i, j) = (down[n0 + i / 3][i % 3] - up[n0 + i / 3][i % 3]) / (2.0 * step);
  }
  return 0.5 * (K + K.transpose());
}

/// How hard a lattice of n layers bends, by its energy in pure bending along m, by that of the solid.
double bending_energy(const Mat3 &edges, int layers, const Vec3 &m, const CornerModuli &moduli,
                      bool selective)
{
  std::mt19937 random(0);
  GeneralCell cell = cell_of_lattice(edges, random, 0.0);
  const Vec3 normal = edges.col(0).cross(edges.col(1)).normalized();
  const double thick = edges.col(2).dot(normal), volume = edges.determinant();
  const double curvature = 1e-5 / thick;
  double energy = 0.0;
  for (int k = 0; k < layers; ++k) {
    const double z0 = (k - 0.5 * (layers - 1)) * thick;
    const auto place = [&](const Vec3 &X) {
      const double along = X.dot(m), z = z0 + X.dot(normal);
      return Vec3(X + curvature * (z * along * m - 0.5 * along * along * normal));
    };
    unsigned present = 0x3f;
    cell.free = 0;
    if (k == 0) cell.free |= 1u << 4;
    if (k == layers - 1) cell.free |= 1u << 5;
    present &= ~static_cast<unsigned>(cell.free);
    Vec3 y[6], f[6];
    for (int s = 0; s < 6; ++s) y[s] = place(cell.dX[s]) - place(Vec3::Zero());
    energy += selective ? corner_strain_general(cell, y, present, moduli, f)
                        : plain_energy(cell, y, moduli);
  }
  const double whole = layers * thick, area = volume / thick;
  return energy / (area * moduli.mu * curvature * curvature * whole * whole * whole / 12.0);
}

Mesh flat(const Vec3 &edges, int nx, int ny, int nz, double moved = 0.0, double slope = 0.0)
{
  auto random = std::make_shared<std::mt19937>(3);
  return box_mesh(nx, ny, nz, 1.0, [=](const Vec3 &X) {
    Vec3 x = X.cwiseProduct(edges) + random_vector(*random, moved * edges.minCoeff());
    x[0] += slope * x[2];
    return x;
  });
}

/// Deflection at the end of a beam of DEs, by that of Timoshenko's beam: of edges r x 1 x 1. The
/// first column is held, the last one loaded.
double cantilever(double r, int layers, double nu, bool orthogonal, double slope = 0.0)
{
  const double h = 1e-3;
  const fe::IsotropicElastic material{70e9, nu, 2500.0};
  const int columns = r > 1.0 ? 10 : 16;
  const Mesh mesh = flat(Vec3(r * h, h, h), columns, 1, layers, 0.0, slope);
  Block block(mesh, all(mesh), material);
  block.orthogonal = orthogonal;
  const MatrixXd K = stiffness(block);
  const int n0 = block.nodes(), n = block.des();
  const double spacing = 0.5 * r * h, first = -0.5 * columns * r * h + 0.5 * spacing;
  std::vector<int> column(n), loose;
  for (int i = 0; i < n; ++i) {
    const Vec3 &X = block.X[n0 + i];
    column[i] = static_cast<int>(std::lround((X[0] - slope * X[2] - first) / spacing));
    if (column[i] > 0)
      for (int c = 0; c < 3; ++c) loose.push_back(3 * i + c);
  }
  const int dofs = static_cast<int>(loose.size()), last = 2 * columns - 1;
  MatrixXd k(dofs, dofs);
  VectorXd load = VectorXd::Zero(dofs);
  double loaded = 0.0;
  for (int i = 0; i < dofs; ++i) {
    for (int j = 0; j < dofs; ++j) k(i, j) = K(loose[i], loose[j]);
    if (loose[i] % 3 == 2 && column[loose[i] / 3] == last) {
      load[i] = 1.0;
      loaded += 1.0;
    }
  }
  load /= loaded;
  const double found = load.dot(k.llt().solve(load));
  const double L = last * spacing, height = layers * h, A = height * h;
  const double I = h * height * height * height / 12.0;
  const double expected = L * L * L / (3.0 * material.E * I) + 6.0 * L / (5.0 * material.mu() * A);
  return found / expected;
}

}    // namespace

// nu = 0: mu/E' = 1/2, and the field of beam theory is that of the lattice. Energy by that of E/(2 mu) = 1.
TEST(Bending, PureBendingOfBoxesIsThatOfCubes)
{
  const CornerModuli moduli{0.0, 35e9};
  for (double r : {1.0, 2.0, 3.0, 5.0, 20.0})
    for (int n : {1, 2, 4, 8})
      for (double width : {1.0, r}) {
        const Mat3 edges = 1e-3 * Vec3(r, width, 1.0).asDiagonal();
        const double expected = (n * n - 1.0) / (n * n) + 1.5 * (n - 1.0) / (n * n * n);
        EXPECT_NEAR(bending_energy(edges, n, Vec3::UnitX(), moduli, true), expected, 1e-5)
            << r << " " << n;
      }
}

// Oblique in the plane or through the thickness: what is added to the solid's energy, by that of cubes.
TEST(Bending, PureBendingOfObliqueCells)
{
  const CornerModuli moduli{0.0, 35e9};
  Mat3 rhombus, slanted;
  rhombus << 4.0, 2.0, 0.0, 0.0, 3.4641, 0.0, 0.0, 0.0, 1.0;
  slanted << 4.0, 0.0, 0.25, 0.0, 4.0, 0.0, 0.0, 0.0, 1.0;
  const int n = 4;
  for (const Mat3 &edges : {rhombus, slanted})
    for (int k = 0; k < 8; ++k) {
      const Vec3 m(std::cos(0.4 * k), std::sin(0.4 * k), 0.0);
      const auto more = [&](bool selective) {
        return (bending_energy(1e-3 * edges, n, m, moduli, selective) - 1.0 + 1.0 / (n * n)) *
            (n * n * n) / (1.5 * (n - 1));
      };
      EXPECT_LT(more(true), 1.5) << k;
      EXPECT_GT(more(false), 10.0 * more(true)) << k;
    }
}

// Deflection of a beam whose end is loaded, elements r x 1 x 1 in layers, by that of Timoshenko's beam. One layer of cubes yields 8 % more,
// since the outer halves of its two layers of DEs lack shear. With sections inclined by 14 degrees it is stiffer, by the strain along the
// normal. (Without selective shear: 0.72, 0.46, 0.21 with one layer of 2:1, 3:1 and 5:1, and 0.65, 0.41, 0.19 where inclined.)
TEST(Bending, Cantilever)
{
  for (double r : {1.0, 2.0, 3.0, 5.0})
    for (int layers : {1, 2, 4}) {
      const double found = cantilever(r, layers, 0.2, true);
      EXPECT_GT(found, 0.975) << r << " " << layers;
      EXPECT_LT(found, layers == 1 ? 1.085 : 1.0) << r << " " << layers;
      if (layers == 4) continue;
      const double inclined = cantilever(r, layers, 0.2, false, 0.25);
      EXPECT_GT(inclined, 0.94) << r << " " << layers;
      EXPECT_LT(inclined, 1.0) << r << " " << layers;
    }
}

TEST(Bending, UniformStrainDoesNotNotice)
{
  std::mt19937 random(2);
  const CornerModuli moduli{20e9, 30e9};
  for (double uneven : {0.0, 0.3})
    for (int k = 0; k < 20; ++k) {
      const Mat3 g = random_rotation(random) *
          Mat3(Vec3(uniform(random, 1.0, 5.0), uniform(random, 1.0, 5.0), 1.0).asDiagonal());
      const GeneralCell cell = cell_of_lattice(g, random, uneven);
      Mat3 F;
      for (int c = 0; c < 9; ++c) F(c / 3, c % 3) = (c % 4 == 0) + uniform(random, -0.1, 0.1);
      Vec3 y[6], f[6];
      for (int s = 0; s < 6; ++s) y[s] = F * cell.dX[s];
      const double expected = plain_energy(cell, y, moduli);
      EXPECT_NEAR(corner_strain_general(cell, y, 0x3f, moduli, f), expected, 1e-12 * expected);
      // a cut at a surface that was there from the start says nothing either
      for (int s = 0; s < 6 && uneven == 0.0; ++s) {
        GeneralCell rim = cell, cut = cell;
        rim.free = static_cast<unsigned char>(1u << s);
        Vec3 of_rim[6];
        const double e = corner_strain_general(rim, y, 0x3f & ~(1u << s), moduli, of_rim);
        EXPECT_GE(e * (1.0 + 1e-12), corner_strain_general(cut, y, 0x3f & ~(1u << s), moduli, f));
        corner_strain_general(cell, y, 0x3f, moduli, f);
        EXPECT_LT((of_rim[s ^ 1] - f[s ^ 1]).norm(), 1e-11 * f[s ^ 1].norm())
            << "the joint on the other side has the whole traction";
      }
    }
}

// s K <= W <= K with K of the corners alone: nothing loses its stiffness, no step becomes smaller.
TEST(Bending, SpectrumIsBetweenThatOfCornersAndItsPart)
{
  std::mt19937 random(4);
  const CornerModuli moduli{20.0, 30.0};
  int softer = 0;
  for (int k = 0; k < 40; ++k) {
    const double uneven = k % 2 ? 0.4 : 0.0;
    const Vec3 edges(uniform(random, 1.0, 5.0), uniform(random, 1.0, 5.0), 1.0);
    Mat3 oblique = Mat3::Identity();
    if (k % 4 >= 2)
      for (int c : {1, 2, 5}) oblique(c / 3, c % 3) = uniform(random, -0.5, 0.5);
    const GeneralCell cell = cell_of_lattice(
        Mat3(random_rotation(random) * oblique * Mat3(edges.asDiagonal())), random, uneven);
    Vec3 f[6];
    const MatrixXd plain = stiffness(cell, [&](const Vec3 *y) {
      return plain_energy(cell, y, moduli);
    });
    const MatrixXd K = stiffness(cell, [&](const Vec3 *y) {
      return corner_strain_general(cell, y, 0x3f, moduli, f);
    });
    double longest = 0.0, shortest = HUGE_VAL;
    for (int a = 0; a < 3; ++a) {
      const double length = (cell.face[2 * a + 1] - cell.face[2 * a]).norm();
      longest = std::max(longest, length);
      shortest = std::min(shortest, length);
    }
    const double s = shortest / longest * (shortest / longest), size = plain.norm();
    const auto eigenvalues = [](const MatrixXd &A) {
      return VectorXd(Eigen::SelfAdjointEigenSolver<MatrixXd>(A).eigenvalues());
    };
    EXPECT_GT(eigenvalues(plain - K).minCoeff(), -1e-6 * size) << k;
    EXPECT_GT(eigenvalues(K - s * plain).minCoeff(), -1e-6 * size) << k;
    softer += (plain - K).norm() > 0.01 * size;
    const VectorXd all = eigenvalues(K), of_plain = eigenvalues(plain);
    const auto zeros = [size](const VectorXd &v) {
      return (v.array().abs() < 1e-5 * size).count();
    };
    EXPECT_EQ(zeros(all), zeros(of_plain)) << k;
  }
  EXPECT_GT(softer, 30) << "poor examples";
}

// The same in bodies with cut joints: what moves freely is as many as with cubes, of which the law is as it was.
TEST(Bending, NoModesWithoutEnergy)
{
  const fe::IsotropicElastic glass{70e9, 0.2, 2500.0};
  for (double cut : {0.0, 0.3}) {
    std::vector<long> zeros;
    for (const Vec3 &edges : {Vec3(1, 1, 1), Vec3(2, 2, 1), Vec3(5, 1, 2)})
      for (bool orthogonal : {true, false}) {
        const Mesh mesh = flat(1e-3 * edges, 2, 2, 2);
        Block block(mesh, all(mesh), glass);
        block.orthogonal = orthogonal;
        std::mt19937 random(9);
        for (int i = 0; i < block.des(); ++i)
          for (int s = 0; s < 6; ++s)
            if (uniform(random, 0.0, 1.0) < 0.5 * cut) block.remove(i, s);
        const VectorXd all =
            Eigen::SelfAdjointEigenSolver<MatrixXd>(stiffness(block)).eigenvalues();
        EXPECT_GT(all.minCoeff(), -1e-7 * all.maxCoeff());
        zeros.push_back((all.array() < 1e-6 * all.maxCoeff()).count());
        EXPECT_EQ(zeros.back(), zeros.front()) << edges.transpose() << " " << orthogonal;
      }
    if (cut == 0.0) { EXPECT_EQ(zeros.front(), 6); }
  }
}

// A joint that leaves takes energy along, whatever the state: bent, sheared or neither.
TEST(Bending, NoEnergyComesUpWhereAJointLeaves)
{
  std::mt19937 random(6);
  const CornerModuli moduli{20.0, 30.0};
  double least = 0.0;
  for (int k = 0; k < 4000; ++k) {
    const Mat3 g(Vec3(uniform(random, 1.0, 5.0), uniform(random, 1.0, 5.0), 1.0).asDiagonal());
    const GeneralCell cell = cell_of_lattice(g, random, 0.0);
    Vec3 y[6], f[6];
    for (int s = 0; s < 6; ++s) y[s] = cell.dX[s] + cell.dX[s].norm() * random_vector(random, 1e-4);
    // half of them: mainly what bending does
    if (k % 2)
      for (int s : {0, 1}) y[s] = cell.dX[s] + 1e-4 * cell.dX[1].norm() * Vec3(0.0, 0.0, 1.0);
    const unsigned present = 0x3f & ~(random() % 64 & random() % 64);
    const double before = corner_strain_general(cell, y, present, moduli, f);
    for (int s = 0; s < 6; ++s)
      if (present >> s & 1u)
        least = std::min(
            least, before / corner_strain_general(cell, y, present & ~(1u << s), moduli, f) - 1.0);
  }
  EXPECT_GT(least, -1e-3) << "the rest is of second order in the rotations of joints";
}
