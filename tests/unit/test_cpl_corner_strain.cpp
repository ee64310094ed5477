// Corner-strain joints: elastic law, objectivity, exact derivatives, momentum.

#include "de_block.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <memory>

using namespace defe;
using namespace defe::test;

namespace {

const fe::IsotropicElastic glass{74.09e9, 0.2, 2500.0};

Mesh cubes(int n = 3)
{
  return box_mesh(n, n, n, 2e-3);
}

Mesh sheared(int n = 3)
{
  Mat3 A;
  A << 1.0, 0.3, -0.2, 0.1, 0.8, 0.25, 0.0, -0.3, 1.2;
  return box_mesh(n, n, n, 2e-3, [A](const Vec3 &X) {
    return Vec3(A * X);
  });
}

Mesh distorted(double amount, int n = 3, unsigned seed = 11)
{
  auto random = std::make_shared<std::mt19937>(seed);
  const double h = 2e-3;
  return box_mesh(n, n, n, h, [=](const Vec3 &X) {
    return Vec3(X + random_vector(*random, amount * h));
  });
}

std::vector<char> all(const Mesh &mesh)
{
  return std::vector<char>(mesh.hex.size(), 1);
}

std::vector<char> some(const Mesh &mesh, std::mt19937 &random, double fraction = 0.5)
{
  std::vector<char> converted(mesh.hex.size());
  for (char &c : converted) c = uniform(random, 0.0, 1.0) < fraction;
  return converted;
}

void remove_some(Block &block, std::mt19937 &random, double fraction)
{
  for (int i = 0; i < block.des(); ++i)
    for (int s = 0; s < 6; ++s)
      if (uniform(random, 0.0, 1.0) < fraction) block.remove(i, s);
}

Vectors shaken(const Vectors &X, std::mt19937 &random, double size)
{
  Vectors x = X;
  for (Vec3 &p : x) p += random_vector(random, size);
  return x;
}

double largest(const Vectors &f)
{
  double m = 0.0;
  for (const Vec3 &v : f) m = std::max(m, v.norm());
  return m;
}

/// A DE in the middle of a cubic lattice of spacing d, and a joint vector set y = F dX.
GeneralCell cube_cell(double d)
{
  GeneralCell cell;
  cell.tie = 0;
  for (int s = 0; s < 6; ++s) {
    cell.dX[s].setZero();
    cell.dX[s][s / 2] = s % 2 ? d : -d;
    cell.face[s] = 0.5 * cell.dX[s];
  }
  return cell;
}

Mat3 saint_venant_kirchhoff(const fe::IsotropicElastic &m, const Mat3 &E)
{
  return m.lambda() * E.trace() * Mat3::Identity() + 2.0 * m.mu() * E;
}

}    // namespace

TEST(CornerStrain, ReducedLaws)
{
  for (double nu : {-0.3, 0.0, 0.2, 0.4, 0.49}) {
    const fe::IsotropicElastic m{3.0, nu, 1.0};
    const CornerModuli c{m.lambda(), m.mu()};
    EXPECT_DOUBLE_EQ(reduced_lambda(c, 3), m.lambda());
    // plane stress: S11 = E/(1 - nu^2) (E11 + nu E22)
    EXPECT_NEAR(reduced_lambda(c, 2), m.E * nu / (1.0 - nu * nu), 1e-14 * m.E);
    EXPECT_NEAR(reduced_lambda(c, 1) + 2.0 * c.mu, m.E, 1e-13);
    EXPECT_EQ(reduced_lambda(c, 0), 0.0);
  }
}

// The stress of a DE, from its half forces, is that of the solid in every direction.
TEST(CornerStrain, IsotropicModuliInEveryDirection)
{
  std::mt19937 random(1);
  std::vector<Vec3> directions = {{1, 0, 0},  {0, 1, 0}, {0, 0, 1}, {1, 1, 0},
                                  {0, 1, -1}, {1, 1, 1}, {1, -1, 1}};
  for (int k = 0; k < 10; ++k) directions.push_back(random_vector(random, 1.0));
  const double d = 1e-3, strain = 1e-4;
  const GeneralCell cube = cube_cell(d);
  for (double nu : {0.0, 0.2, 0.4}) {
    const fe::IsotropicElastic m{74.09e9, nu, 2500.0};
    for (const Vec3 &direction : directions) {
      const Vec3 n = direction.normalized();
      // Green strain of uniaxial stress along n; F is any root of it, here a rotated one
      const Mat3 E = strain * ((1.0 + nu) * n * n.transpose() - nu * Mat3::Identity());
      const Mat3 U = Mat3::Identity() + E - 0.5 * E * E + 0.5 * E * E * E;    // to 1e-16
      const Mat3 F = random_rotation(random) * U;
      Vec3 y[6], f[6];
      Mat3 P = Mat3::Zero();
      for (int s = 0; s < 6; ++s) y[s] = F * cube.dX[s];
      const double energy = corner_strain_general(cube, y, 0x3f, {m.lambda(), m.mu()}, f);
      // of the two ends of a joint this is one: half the force, the whole vector
      for (int s = 0; s < 6; ++s) P += f[s] * cube.dX[s].transpose() / (d * d * d);
      const Mat3 S = F.inverse() * P;
      const Mat3 expected = m.E * strain * n * n.transpose();
      EXPECT_LT((S - expected).norm(), 1e-10 * m.E * strain) << "nu " << nu << " n " << n;
      EXPECT_NEAR(energy, 0.5 * m.E * strain * strain * d * d * d,
                  1e-10 * m.E * strain * strain * d * d * d);
    }
  }
}

// A bar of DEs with free sides, pulled in uniaxial stress: the sides are in balance (reduced laws),
// every cross-section carries E eps A.
TEST(CornerStrain, FreeBarHasYoungsModulusAndPoissonsRatio)
{
  for (double nu : {0.0, 0.2, 0.4})
    for (int axis = 0; axis < 3; ++axis) {
      const fe::IsotropicElastic m{1.0, nu, 1.0};
      const Mesh mesh = box_mesh(3, 3, 3, 1.0);
      Block block(mesh, all(mesh), m);
      Vec3 stretch;
      const double eps = 1e-3;
      for (int a = 0; a < 3; ++a) stretch[a] = std::sqrt(1.0 + 2.0 * (a == axis ? eps : -nu * eps));
      const Vectors x = deformed(block.X, stretch.asDiagonal());
      Vectors f;
      for (bool orthogonal : {false, true}) {
        block.orthogonal = orthogonal;
        block.forces(x, f);
        double pull = 0.0;
        for (int i = 0; i < block.des(); ++i) {
          const Vec3 &force = f[block.nodes() + i];
          const double along = block.X[block.nodes() + i][axis];
          if (along > 1.1) {
            pull += force[axis];    // the outermost layer, held by the puller
          } else if (along > -1.1) {
            EXPECT_LT(force.norm(), 1e-12 * eps);
          }
        }
        // first Piola-Kirchhoff stress of S = E eps, on 3 x 3
        EXPECT_NEAR(pull, -stretch[axis] * m.E * eps * 9.0, 1e-10 * eps * 9.0) << nu << axis;
      }
    }
}

TEST(CornerStrain, RigidRotationGivesNoForce)
{
  std::mt19937 random(2);
  for (const Mesh &mesh : {cubes(), sheared(), distorted(0.2)}) {
    Block block(mesh, some(mesh, random), glass);
    remove_some(block, random, 0.1);
    for (double angle : {1e-6, 1e-3, 0.1, 1.0, 3.0}) {
      const Mat3 R =
          Eigen::AngleAxisd(angle, random_vector(random, 1.0).normalized()).toRotationMatrix();
      Vectors x = deformed(block.X, R), f(x.size(), Vec3::Zero());
      for (Vec3 &p : x) p += Vec3(1e-3, -2e-3, 3e-3);
      const double energy = block.joint_forces(x, f);
      EXPECT_LT(largest(f), 1e-13 * glass.E * 1e-6);
      EXPECT_LT(energy, 1e-24 * glass.E * 1e-9 * block.des());
    }
  }
}

TEST(CornerStrain, ForcesTurnWithTheBody)
{
  std::mt19937 random(3);
  for (const Mesh &mesh : {cubes(), distorted(0.15)})
    for (bool orthogonal : {false, true}) {
      Block block(mesh, some(mesh, random), glass);
      if (orthogonal && !is_orthogonal(block.de[0].cell)) continue;
      block.orthogonal = orthogonal;
      remove_some(block, random, 0.1);
      const Vectors x = shaken(block.X, random, 1e-5);
      Vectors f(x.size(), Vec3::Zero()), g = f;
      const double energy = block.joint_forces(x, f);
      const Mat3 R = random_rotation(random);
      EXPECT_NEAR(block.joint_forces(deformed(x, R), g), energy, 1e-11 * energy);
      for (std::size_t i = 0; i < x.size(); ++i)
        EXPECT_LT((g[i] - R * f[i]).norm(), 1e-11 * largest(f));
    }
}

TEST(CornerStrain, ForceIsTheDerivativeOfTheEnergy)
{
  std::mt19937 random(4);
  for (const Mesh &mesh : {cubes(2), sheared(2), distorted(0.2, 2)})
    for (double missing : {0.0, 0.2, 0.6}) {
      Block block(mesh, some(mesh, random), glass);
      remove_some(block, random, missing);
      const Vectors x0 = deformed(shaken(block.X, random, 1e-4), random_rotation(random));
      for (bool orthogonal : {false, true}) {
        bool box = true;
        for (const auto &p : block.de) box = box && is_orthogonal(p.cell);
        if (orthogonal && !box) continue;
        block.orthogonal = orthogonal;
        Vectors f(x0.size(), Vec3::Zero()), dummy = f;
        block.joint_forces(x0, f);
        const double step = 1e-8;
        for (std::size_t i = 0; i < x0.size(); ++i)
          for (int c = 0; c < 3; ++c) {
            Vectors x = x0;
            x[i][c] += step;
            const double up = block.joint_forces(x, dummy);
            x[i][c] = x0[i][c] - step;
            const double down = block.joint_forces(x, dummy);
            EXPECT_NEAR(f[i][c], (down - up) / (2.0 * step), 1e-6 * largest(f));
          }
      }
    }
}

TEST(CornerStrain, MomentumIsConserved)
{
  std::mt19937 random(5);
  for (const Mesh &mesh : {cubes(), distorted(0.2)})
    for (bool orthogonal : {false, true}) {
      Block block(mesh, some(mesh, random), glass);
      if (orthogonal && !is_orthogonal(block.de[0].cell)) continue;
      block.orthogonal = orthogonal;
      remove_some(block, random, 0.2);
      const Vectors x = deformed(shaken(block.X, random, 2e-4), random_rotation(random));
      Vectors f(x.size(), Vec3::Zero());
      block.joint_forces(x, f);
      Vec3 force = Vec3::Zero(), moment = Vec3::Zero();
      for (std::size_t i = 0; i < x.size(); ++i) {
        force += f[i];
        moment += x[i].cross(f[i]);
      }
      EXPECT_LT(force.norm(), 1e-12 * largest(f));
      EXPECT_LT(moment.norm(), 1e-12 * largest(f) * 1e-3);
    }
}

TEST(CornerStrain, EveryDEConservesAngularMomentumByItself)
{
  std::mt19937 random(6);
  const Mesh mesh = distorted(0.2);
  const Block block(mesh, some(mesh, random), glass);
  for (const auto &p : block.de) {
    Vec3 y[6], f[6], moment = Vec3::Zero();
    for (int s = 0; s < 6; ++s) y[s] = p.cell.dX[s] + random_vector(random, 1e-4);
    corner_strain_general(p.cell, y, p.present, block.moduli, f);
    double size = 0.0;
    for (int s = 0; s < 6; ++s) {
      moment += y[s].cross(f[s]);
      size += f[s].norm();
    }
    EXPECT_LT(moment.norm(), 1e-14 * size * 1e-3 * 10.0);
  }
}

TEST(CornerStrain, OrthogonalKernelEqualsGeneral)
{
  std::mt19937 random(7);
  const auto graded = [](const Vec3 &X) {
    return Vec3(X[0] < 0.0 ? 0.5 * X[0] : X[0], 1.5 * X[1], X[2] > 0.0 ? 0.7 * X[2] : X[2]);
  };
  for (const Mesh &mesh : {cubes(4), box_mesh(4, 4, 4, 2e-3, graded)})
    for (double missing : {0.0, 0.05, 0.5})
      for (double fraction : {1.0, 0.5}) {
        Block block(mesh, some(mesh, random, fraction), glass);
        remove_some(block, random, missing);
        const Vectors x = deformed(shaken(block.X, random, 1e-4), random_rotation(random));
        Vectors f(x.size(), Vec3::Zero()), g = f;
        const double energy = block.joint_forces(x, f);
        block.orthogonal = true;
        EXPECT_NEAR(block.joint_forces(x, g), energy, 1e-12 * energy);
        for (std::size_t i = 0; i < x.size(); ++i)
          EXPECT_LT((f[i] - g[i]).norm(), 1e-12 * largest(f));
      }
}

// Any number of DEs, any mixture of full and broken lanes, two materials, no energy array.
TEST(CornerStrain, OrthogonalKernelChunks)
{
  std::mt19937 random(8);
  const CornerModuli table[2] = {{1.0, 2.0}, {3.0, 0.5}};
  const GeneralCell cell = cube_cell(1.0);
  for (int n = 0; n <= 33; ++n) {
    std::vector<double> x(3 * (7 * n + 1)), energy(n);
    std::vector<int> self(n);
    std::vector<std::array<int, 6>> nb(n);
    std::vector<unsigned char> present(n), material(n);
    std::vector<std::array<double, 6>> len(n), half(n);
    std::vector<std::array<double, 18>> force(n), again(n);
    for (int i = 0; i < n; ++i) {
      present[i] = random() % 3 ? 0x3f : random() % 64;
      material[i] = random() % 2;
      self[i] = 7 * i;
      for (int s = 0; s < 6; ++s) {
        nb[i][s] = 7 * i + 1 + s;
        len[i][s] = 1.0;
        half[i][s] = 0.5;
        for (int c = 0; c < 3; ++c)
          x[3 * nb[i][s] + c] = cell.dX[s][c] + uniform(random, -0.1, 0.1);
      }
    }
    const OrthogonalLattice lattice{n,
                                    self.data(),
                                    reinterpret_cast<const int(*)[6]>(nb.data()),
                                    present.data(),
                                    reinterpret_cast<const double(*)[6]>(len.data()),
                                    reinterpret_cast<const double(*)[6]>(half.data()),
                                    material.data()};
    const double total =
        corner_strain_orthogonal(lattice, x.data(), nullptr, table,
                                 reinterpret_cast<double(*)[6][3]>(force.data()), energy.data());
    EXPECT_EQ(corner_strain_orthogonal(lattice, x.data(), nullptr, table,
                                       reinterpret_cast<double(*)[6][3]>(again.data()), nullptr),
              0.0);
    double sum = 0.0;
    for (int i = 0; i < n; ++i) {
      Vec3 y[6], f[6];
      for (int s = 0; s < 6; ++s) y[s] = Eigen::Map<Vec3>(&x[3 * nb[i][s]]);
      const double e = corner_strain_general(cell, y, present[i], table[material[i]], f);
      EXPECT_NEAR(energy[i], e, 1e-14);
      sum += e;
      for (int s = 0; s < 6; ++s)
        for (int c = 0; c < 3; ++c) {
          EXPECT_NEAR(force[i][3 * s + c], f[s][c], 1e-14);
          EXPECT_EQ(force[i][3 * s + c], again[i][3 * s + c]);
        }
    }
    EXPECT_NEAR(total, sum, 1e-13 * (1.0 + n));
  }
}

// each_alone: a DE's forces have the same bits in any list, whatever is beside it.
TEST(CornerStrain, BitsDoNotDependOnTheList)
{
  std::mt19937 random(9);
  const CornerModuli moduli{74.1e9 * 0.2 / 0.72, 74.1e9 / 2.4};
  constexpr int n = 61;
  std::vector<double> x;
  std::vector<int> self;
  std::vector<std::array<int, 6>> nb;
  std::vector<unsigned char> present;
  std::vector<std::array<double, 6>> len, half;
  for (int i = 0; i < n; ++i) {
    present.push_back(random() % 3 ? 0x3f : random() % 64);
    self.push_back(7 * i);
    nb.emplace_back();
    len.emplace_back();
    half.emplace_back();
    for (int c = 0; c < 3; ++c) x.push_back(uniform(random, 0.0, 0.1));
    for (int s = 0; s < 6; ++s) {
      nb[i][s] = 7 * i + 1 + s;
      len[i][s] = 1e-3;
      half[i][s] = 5e-4;
      for (int c = 0; c < 3; ++c)
        x.push_back(x[21 * i + c] + (c == s / 2 ? (s % 2 ? 1e-3 : -1e-3) : 0.0) +
                    uniform(random, -1e-6, 1e-6));
    }
  }
  const auto forces = [&](const std::vector<int> &list, bool each_alone) {
    const int m = static_cast<int>(list.size());
    std::vector<int> s;
    std::vector<std::array<int, 6>> neighbours;
    std::vector<unsigned char> there;
    for (int i : list) {
      s.push_back(self[i]);
      neighbours.push_back(nb[i]);
      there.push_back(present[i]);
    }
    const OrthogonalLattice lattice{m,
                                    s.data(),
                                    reinterpret_cast<const int(*)[6]>(neighbours.data()),
                                    there.data(),
                                    reinterpret_cast<const double(*)[6]>(len.data()),
                                    reinterpret_cast<const double(*)[6]>(half.data()),
                                    nullptr};
    std::vector<std::array<double, 18>> f(m);
    std::vector<double> energy(m);
    corner_strain_orthogonal(lattice, x.data(), nullptr, &moduli,
                             reinterpret_cast<double(*)[6][3]>(f.data()), energy.data(),
                             each_alone);
    std::vector<std::pair<std::array<double, 18>, double>> of(n);
    for (int k = 0; k < m; ++k) of[list[k]] = {f[k], energy[k]};
    return of;
  };
  std::vector<int> list(n);
  for (int i = 0; i < n; ++i) list[i] = i;
  const auto reference = forces(list, true), loose = forces(list, false);
  bool loose_differs = false;
  for (int k = 0; k < 20; ++k) {
    std::shuffle(list.begin(), list.end(), random);
    EXPECT_TRUE(forces(list, true) == reference);
    loose_differs = loose_differs || forces(list, false) != loose;
  }
  for (int i = 0; i < n; ++i) EXPECT_TRUE(forces({i}, true)[i] == reference[i]) << i;
  EXPECT_TRUE(loose_differs) << "a poor example";
}

// Half forces over half areas are the traction: what decides whether a joint breaks.
TEST(CornerStrain, AreasAndTractions)
{
  std::mt19937 random(9);
  const Mesh mesh = sheared();
  const Block block(mesh, all(mesh), glass);
  Mat3 H;
  for (int k = 0; k < 9; ++k) H(k / 3, k % 3) = uniform(random, -1e-7, 1e-7);
  const Mat3 stress = saint_venant_kirchhoff(glass, 0.5 * (H + H.transpose()));
  for (const auto &p : block.de) {
    if (p.present != 0x3f) continue;
    Vec3 area[6], y[6], f[6];
    corner_areas(p.cell, p.present, area);
    for (int s = 0; s < 6; ++s) y[s] = (Mat3::Identity() + H) * p.cell.dX[s];
    corner_strain_general(p.cell, y, p.present, block.moduli, f);
    for (int s = 0; s < 6; ++s) {
      EXPECT_LT((2.0 * area[s] - p.birth.area_normal[s]).norm(), 1e-12 * p.birth.area[s]);
      EXPECT_LT((f[s] - stress * area[s]).norm(), 1e-5 * stress.norm() * p.birth.area[s]);
    }
  }
}

TEST(CornerStrain, IsOrthogonal)
{
  for (const auto &mesh : {cubes(), box_mesh(2, 2, 2, 1.0, [](const Vec3 &X) {
                             return Vec3(X[0] * (X[0] > 0.0 ? 1.0 : 3.0), 2.0 * X[1], X[2]);
                           })}) {
    const Block block(mesh, all(mesh), glass);
    for (const auto &p : block.de) EXPECT_TRUE(is_orthogonal(p.cell));
  }
  const Mesh mesh = sheared();
  const Block block(mesh, all(mesh), glass);
  for (const auto &p : block.de) EXPECT_FALSE(is_orthogonal(p.cell));
  GeneralCell cell = cube_cell(1.0);
  cell.dX[3][0] = 1e-6;
  EXPECT_FALSE(is_orthogonal(cell));
  EXPECT_TRUE(is_orthogonal(cell, 1e-5));
}
