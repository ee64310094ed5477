// The glass beam of the paper, elastic, against figures computed outside this project with
// CalculiX 2.20 (C3D8: plain 2 x 2 x 2 integration): static bending, the largest eigenfrequency,
// the lowest elastic ones; and the critical time step.

#include "test_fe_common.h"

#include "defe/fe/enhanced_kernel.h"
#include "defe/fe/stable_step.h"

#include <Eigen/Eigenvalues>
#include <gtest/gtest.h>

#include <algorithm>
#include <vector>

using namespace defe;
using namespace defe::fe;
using namespace defe::fe::test;

namespace {

using Vector = std::vector<double>;

// 1 mm column, 99 columns of 2 mm, 1 mm column; 10 elements high, 5 wide.
struct Beam : Mesh {
  static constexpr int nx = 101, ny = 10, nz = 5;
  Vector mass;                                   // per degree of freedom
  Eigen::Matrix<double, 24, 24> wide, narrow;    // the two distinct stiffness matrices

  // the numbering gives a band of 3 (layer + 8) degrees of freedom
  static int node(int i, int j, int k) { return (i * (ny + 1) + j) * (nz + 1) + k; }
  static int element(int i, int j, int k) { return (i * ny + j) * nz + k; }
  static constexpr int band = 3 * ((ny + 1) * (nz + 1) + (nz + 1) + 2);

  Beam()
  {
    for (int i = 0; i <= nx; ++i)
      for (int j = 0; j <= ny; ++j)
        for (int k = 0; k <= nz; ++k) {
          const double x = i == 0 ? -0.1 : i == nx ? 0.1 : -0.099 + 0.002 * (i - 1);
          X.emplace_back(x, 0.002 * j, 0.002 * k);
        }
    mass.assign(3 * X.size(), 0.0);
    for (int i = 0; i < nx; ++i)
      for (int j = 0; j < ny; ++j)
        for (int k = 0; k < nz; ++k) {
          std::array<int, 8> hex;
          for (int a = 0; a < 8; ++a)
            hex[a] = node(i + (hex_sign[a][0] + 1) / 2, j + (hex_sign[a][1] + 1) / 2,
                          k + (hex_sign[a][2] + 1) / 2);
          hexes.push_back(hex);
          const double m = nodal_mass(shape(int(hexes.size()) - 1), glass.rho);
          for (int n : hex)
            for (int c = 0; c < 3; ++c) mass[3 * n + c] += m;
        }
    narrow = stiffness(shape(0), glass);
    wide = stiffness(shape(element(1, 0, 0)), glass);
  }

  const Eigen::Matrix<double, 24, 24> &element_stiffness(int e) const
  {
    const int i = e / (ny * nz);
    return i == 0 || i == nx - 1 ? narrow : wide;
  }

  // plain loops here and below: they stay fast in builds without optimisation
  Vector apply_stiffness(const Vector &u) const
  {
    Vector f(u.size(), 0.0);
    for (int e = 0; e < int(hexes.size()); ++e) {
      const double *K = element_stiffness(e).data();
      double ue[24], fe[24] = {};
      for (int i = 0; i < 24; ++i) ue[i] = u[3 * hexes[e][i / 3] + i % 3];
      for (int j = 0; j < 24; ++j, K += 24)
        for (int i = 0; i < 24; ++i) fe[i] += K[i] * ue[j];
      for (int i = 0; i < 24; ++i) f[3 * hexes[e][i / 3] + i % 3] += fe[i];
    }
    return f;
  }
};

// Cholesky factors of K + shift M with some degrees of freedom held, as a band matrix.
class BandSolver {
 public:
  BandSolver(const Beam &beam, double shift, const std::vector<int> &held) :
      size(int(beam.mass.size())), L(std::size_t(size) * (Beam::band + 1), 0.0), is_held(size)
  {
    for (int i : held) is_held[i] = true;
    for (int e = 0; e < int(beam.hexes.size()); ++e)
      for (int i = 0; i < 24; ++i)
        for (int j = 0; j < 24; ++j) {
          const int row = 3 * beam.hexes[e][i / 3] + i % 3,
                    column = 3 * beam.hexes[e][j / 3] + j % 3;
          if (row >= column && !is_held[row] && !is_held[column])
            at(row)[column] += beam.element_stiffness(e)(i, j);
        }
    for (int i = 0; i < size; ++i) at(i)[i] = is_held[i] ? 1.0 : at(i)[i] + shift * beam.mass[i];

    for (int i = 0; i < size; ++i) {
      double *row = at(i);
      for (int j = first(i); j <= i; ++j) {
        const double *other = at(j);
        double sum = row[j];
        for (int k = std::max(first(i), first(j)); k < j; ++k) sum -= row[k] * other[k];
        row[j] = i == j ? std::sqrt(sum) : sum / other[j];
      }
    }
  }

  Vector solve(Vector b) const
  {
    for (int i = 0; i < size; ++i) {
      if (is_held[i]) b[i] = 0.0;
      const double *row = at(i);
      for (int k = first(i); k < i; ++k) b[i] -= row[k] * b[k];
      b[i] /= row[i];
    }
    for (int i = size - 1; i >= 0; --i) {
      const double *row = at(i);
      b[i] /= row[i];
      for (int k = first(i); k < i; ++k) b[k] -= row[k] * b[i];
    }
    return b;
  }

 private:
  int size;
  Vector L;
  std::vector<bool> is_held;

  static int first(int row) { return std::max(0, row - Beam::band); }
  // row i of the band, to be indexed by column
  double *at(int i) { return L.data() + std::size_t(i) * Beam::band + Beam::band; }
  const double *at(int i) const { return L.data() + std::size_t(i) * Beam::band + Beam::band; }
};

// Eigenvalues of a symmetric operator by Lanczos' method from a random start.
template <class Operator> Vector lanczos(int size, int steps, const Operator &apply)
{
  Random random(1);
  std::vector<Vector> basis;
  Vector v(size);
  for (double &vi : v) vi = random.uniform(-1.0, 1.0);
  Eigen::VectorXd diagonal(steps), off_diagonal(steps);
  const auto dot = [size](const Vector &a, const Vector &b) {
    double sum = 0.0;
    for (int i = 0; i < size; ++i) sum += a[i] * b[i];
    return sum;
  };
  for (int s = 0; s < steps; ++s) {
    // full orthogonalisation, or copies of the extreme eigenvalues appear
    for (int twice = 0; twice < 2; ++twice)
      for (const Vector &b : basis) {
        const double p = dot(b, v);
        for (int i = 0; i < size; ++i) v[i] -= p * b[i];
      }
    const double norm = std::sqrt(dot(v, v));
    if (s > 0) off_diagonal[s - 1] = norm;
    for (double &vi : v) vi /= norm;
    basis.push_back(v);
    v = apply(v);
    diagonal[s] = dot(basis.back(), v);
  }
  Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> solver;
  solver.computeFromTridiagonal(diagonal, off_diagonal.head(steps - 1), Eigen::EigenvaluesOnly);
  const Eigen::VectorXd values = solver.eigenvalues();
  return Vector(values.data(), values.data() + steps);
}

TEST(Beam, Mass)
{
  const Beam beam;
  double sum = 0.0;
  for (double m : beam.mass) sum += m / 3.0;
  EXPECT_NEAR(sum, 0.1, 1e-14);
  EXPECT_EQ(beam.hexes.size(), 5050u);
}

TEST(Beam, StaticBending)
{
  const Beam beam;
  // held in y along two lines at the bottom, at one point against the other rigid motions
  const int left = 3, right = Beam::nx - 3;
  ASSERT_NEAR(beam.X[Beam::node(left, 0, 0)][0], -0.095, 1e-15);
  ASSERT_NEAR(beam.X[Beam::node(right, 0, 0)][0], 0.095, 1e-15);
  std::vector<int> held;
  for (int k = 0; k <= Beam::nz; ++k) {
    held.push_back(3 * Beam::node(left, 0, k) + 1);
    held.push_back(3 * Beam::node(right, 0, k) + 1);
  }
  held.push_back(3 * Beam::node(left, 0, 0));
  held.push_back(3 * Beam::node(left, 0, 0) + 2);
  held.push_back(3 * Beam::node(right, 0, 0) + 2);

  const int middle = Beam::nx / 2;    // the column whose planes are at x = -1 and 1 mm
  ASSERT_NEAR(beam.X[Beam::node(middle, 0, 0)][0], -0.001, 1e-15);
  Vector load(beam.mass.size(), 0.0);
  for (int i : {middle, middle + 1})
    for (int k = 0; k <= Beam::nz; ++k) {
      const double share = k == 0 || k == Beam::nz ? 0.1 : 0.2;
      load[3 * Beam::node(i, Beam::ny, k) + 1] = -500.0 / 2.0 * share;
    }

  const Vector u = BandSolver(beam, 0.0, held).solve(load);

  // at x = 0, z = 5 mm: the mean of four nodes
  const auto deflection = [&](int j) {
    double sum = 0.0;
    for (int i : {middle, middle + 1})
      for (int k : {2, 3}) sum += 0.25 * u[3 * Beam::node(i, j, k) + 1];
    return sum;
  };
  EXPECT_NEAR(deflection(Beam::ny), -1.489687e-4, 1e-9);
  EXPECT_NEAR(deflection(0), -1.480272e-4, 1e-9);

  const double expected[3] = {31.01643e6, 31.05824e6, 31.06857e6};
  for (int k = 0; k < Beam::nz; ++k) {
    const int e = Beam::element(middle, 0, k);
    HexCoords ue;
    for (int i = 0; i < 24; ++i) ue.data()[i] = u[3 * beam.hexes[e][i / 3] + i % 3];
    const Mat3 s = linear_stress(beam.shape(e), ue, glass, Vec3::Zero());
    EXPECT_NEAR(s(0, 0), expected[k < 3 ? k : 4 - k], 10.0) << k;
  }
}

TEST(Beam, LargestEigenfrequencyAndCriticalStep)
{
  const Beam beam;
  const int size = int(beam.mass.size());
  const Vector values = lanczos(size, 80, [&](Vector v) {
    for (int i = 0; i < size; ++i) v[i] /= std::sqrt(beam.mass[i]);
    v = beam.apply_stiffness(v);
    for (int i = 0; i < size; ++i) v[i] /= std::sqrt(beam.mass[i]);
    return v;
  });
  const double omega = std::sqrt(values.back());
  EXPECT_NEAR(omega, 9.575827e6, 1.0);
  EXPECT_NEAR(2.0 / omega, 2.08859e-7, 1e-12);

  // The elements' own smallest step is a safe bound. It is 18 % below the mesh's, because half of
  // the nodes of a narrow column are also loaded with the mass of a wide one.
  const double bound = std::min(critical_step(beam.shape(0), glass),
                                critical_step(beam.shape(Beam::element(1, 0, 0)), glass));
  EXPECT_LE(bound, 2.0 / omega);
  EXPECT_GT(bound, 0.8 * 2.0 / omega);
}

TEST(Beam, LowestElasticFrequencies)
{
  const Beam beam;
  const int size = int(beam.mass.size());
  const double shift = std::pow(2.0 * M_PI * 500.0, 2);
  const BandSolver solver(beam, shift, {});

  // Rigid motions, to be kept out of the iteration; scaled by sqrt(M) as all vectors here.
  std::vector<Vector> rigid(6, Vector(size));
  for (int n = 0; n < size / 3; ++n) {
    const Vec3 r = beam.X[n] - Vec3(0.0, 0.01, 0.005);
    for (int m = 0; m < 6; ++m) {
      const Vec3 motion = m < 3 ? Vec3(Vec3::Unit(m)) : Vec3::Unit(m - 3).cross(r);
      for (int c = 0; c < 3; ++c) rigid[m][3 * n + c] = std::sqrt(beam.mass[3 * n]) * motion[c];
    }
  }
  const auto without_rigid = [&](Vector v) {
    for (const Vector &r : rigid) {    // orthogonal: centre of mass and principal axes
      double rr = 0.0, rv = 0.0;
      for (int i = 0; i < size; ++i) {
        rr += r[i] * r[i];
        rv += r[i] * v[i];
      }
      for (int i = 0; i < size; ++i) v[i] -= rv / rr * r[i];
    }
    return v;
  };

  Vector values = lanczos(size, 30, [&](Vector v) {
    v = without_rigid(v);
    for (int i = 0; i < size; ++i) v[i] *= std::sqrt(beam.mass[i]);
    v = solver.solve(v);
    for (int i = 0; i < size; ++i) v[i] *= std::sqrt(beam.mass[i]);
    return without_rigid(v);
  });
  std::reverse(values.begin(), values.end());
  const double expected[5] = {1399.46, 2711.25, 3798.58, 6456.95, 7074.85};
  for (int m = 0; m < 5; ++m)
    EXPECT_NEAR(std::sqrt(1.0 / values[m] - shift) / (2.0 * M_PI), expected[m], 0.0051);
}

TEST(CriticalStep, OfOneElementAgainstPowerIteration)
{
  Random random(2);
  for (int i = 0; i < 10; ++i) {
    const HexCoords X = random_hex(random);
    const ElementType type = i % 2 ? ElementType::enhanced : ElementType::plain;
    const auto K = i % 2 ? stiffness_enhanced(X, unit) : stiffness(X, unit);
    Eigen::Matrix<double, 24, 1> v = random.matrix<Eigen::Matrix<double, 24, 1>>(1.0);
    for (int j = 0; j < 20000; ++j) v = (K * v).normalized();
    const double omega = std::sqrt(v.dot(K * v) / nodal_mass(X, unit.rho));
    EXPECT_NEAR(max_frequency(X, unit, type), omega, 1e-10 * omega);
    EXPECT_NEAR(critical_step(X, unit, type), 2.0 / omega, 1e-9 / omega);
  }
}

TEST(CriticalStep, OfElementsIsSafeForRandomMeshes)
{
  // 3 x 2 x 2 elements with every node moved at random: the mesh is slower than its worst element,
  // but not by much
  for (unsigned seed = 0; seed < 5; ++seed) {
    Random random(seed);
    const int n[3] = {3, 2, 2};
    const auto node = [&n](int i, int j, int k) {
      return (i * (n[1] + 1) + j) * (n[2] + 1) + k;
    };
    Mesh mesh;
    for (int i = 0; i <= n[0]; ++i)
      for (int j = 0; j <= n[1]; ++j)
        for (int k = 0; k <= n[2]; ++k)
          mesh.X.push_back(Vec3(1.0 * i, 0.7 * j, 1.3 * k) + random.matrix<Vec3>(0.1));
    const int size = 3 * int(mesh.X.size());
    Eigen::MatrixXd K = Eigen::MatrixXd::Zero(size, size);
    Eigen::VectorXd mass = Eigen::VectorXd::Zero(size);
    double worst = 0.0;
    for (int i = 0; i < n[0]; ++i)
      for (int j = 0; j < n[1]; ++j)
        for (int k = 0; k < n[2]; ++k) {
          std::array<int, 8> hex;
          for (int a = 0; a < 8; ++a)
            hex[a] = node(i + (hex_sign[a][0] + 1) / 2, j + (hex_sign[a][1] + 1) / 2,
                          k + (hex_sign[a][2] + 1) / 2);
          mesh.hexes.push_back(hex);
          const HexCoords X = mesh.shape(int(mesh.hexes.size()) - 1);
          const auto Ke = stiffness(X, unit);
          worst = std::max(worst, max_frequency(X, unit));
          for (int a = 0; a < 8; ++a) {
            mass.segment<3>(3 * hex[a]).array() += nodal_mass(X, unit.rho);
            for (int b = 0; b < 8; ++b)
              K.block<3, 3>(3 * hex[a], 3 * hex[b]) += Ke.block<3, 3>(3 * a, 3 * b);
          }
        }
    const Eigen::VectorXd scale = mass.cwiseSqrt().cwiseInverse();
    const Eigen::MatrixXd A = scale.asDiagonal() * K * scale.asDiagonal();
    const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> solver(A, Eigen::EigenvaluesOnly);
    const double omega = std::sqrt(solver.eigenvalues()[size - 1]);
    EXPECT_LE(omega, worst);
    EXPECT_GT(omega, 0.8 * worst);
  }
}

TEST(CriticalStep, OfACubeInClosedForm)
{
  // The breathing mode u = e x of a nearly incompressible cube: W = 9/2 K V e^2 against a kinetic
  // energy of 1/2 m w^2 e^2 |x|^2 with |x|^2 = 3 h^2/4 at all nodes.
  const IsotropicElastic stiff{1.0, 0.499, 1.0};
  const double h = 2.0;
  const double omega =
      std::sqrt(9.0 * stiff.bulk() * h * h * h / (stiff.rho * h * h * h) / (3.0 * h * h / 4.0));
  EXPECT_NEAR(max_frequency(box(h, h, h), stiff), omega, 1e-12 * omega);
}

TEST(CriticalStep, ScalesWithSizeAndWaveSpeed)
{
  Random random(3);
  const HexCoords X = random_hex(random);
  const double dt = critical_step(X, unit);
  EXPECT_NEAR(critical_step(1e-3 * X, unit), 1e-3 * dt, 1e-15 * dt);
  EXPECT_NEAR(critical_step(X, {4.0 * unit.E, unit.nu, unit.rho}), dt / 2.0, 1e-12 * dt);
  EXPECT_NEAR(critical_step(X, {unit.E, unit.nu, 4.0 * unit.rho}), dt * 2.0, 1e-12 * dt);
}

TEST(CriticalStep, VelocityVerletIsStableBelowAndUnstableAbove)
{
  Random random(4);
  const HexCoords X = random_hex(random);
  const LagrangianKernel plain(unit);
  const EnhancedKernel enhanced(unit);
  const double m = nodal_mass(X, unit.rho);
  const auto final_amplitude = [&](double factor, ElementType type) {
    const HexKernel &kernel = type == ElementType::plain ? static_cast<const HexKernel &>(plain)
                                                         : enhanced;
    const double dt = factor * critical_step(X, unit, type);
    Random noise(5);
    HexCoords x = X + noise.matrix<HexCoords>(1e-9);
    HexCoords v = HexCoords::Zero(), f = forces(kernel, x, X);
    for (int step = 0; step < 2000; ++step) {
      v += 0.5 * dt / m * f;
      x += dt * v;
      f = forces(kernel, x, X);
      v += 0.5 * dt / m * f;
    }
    return (x - X).cwiseAbs().maxCoeff();
  };
  for (ElementType type : {ElementType::plain, ElementType::enhanced}) {
    EXPECT_LT(final_amplitude(0.999, type), 1e-7);
    EXPECT_FALSE(final_amplitude(1.001, type) < 1e-4);    // or NaN
  }
}

}    // namespace
