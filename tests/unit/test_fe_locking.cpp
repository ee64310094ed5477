// Nearly incompressible layers: elements with F-bar converge to the exact solution as their order
// says; the plain element, of the same constants, is many times too stiff.

#include "test_fe_common.h"

#include "defe/fe/mooney_rivlin.h"

#include <Eigen/SparseCholesky>
#include <gtest/gtest.h>

#include <functional>

using namespace defe;
using namespace defe::fe;
using namespace defe::fe::test;

namespace {

using Matrix24 = Eigen::Matrix<double, 24, 24>;

/// -df/dx at x, by central differences.
Matrix24 tangent(const HexKernel &kernel, const HexCoords &x, const HexCoords &X, double step)
{
  Matrix24 K;
  for (int i = 0; i < 24; ++i) {
    HexCoords plus = x, minus = x;
    plus.data()[i] += step;
    minus.data()[i] -= step;
    const HexCoords d = (forces(kernel, minus, X) - forces(kernel, plus, X)) / (2.0 * step);
    K.col(i) = Eigen::Map<const Eigen::Matrix<double, 24, 1>>(d.data());
  }
  return 0.5 * (K + K.transpose());
}

/// nx x ny elements, one in z; plane strain.
struct Sheet : Mesh {
  int nx, ny;
  std::vector<bool> held;    // degrees of freedom

  int node(int i, int j, int k) const { return (i * (ny + 1) + j) * 2 + k; }

  Sheet(int nx, int ny, double thickness, const std::function<Vec3(double, double)> &map) :
      nx(nx), ny(ny)
  {
    for (int i = 0; i <= nx; ++i)
      for (int j = 0; j <= ny; ++j)
        for (int k = 0; k < 2; ++k)
          X.push_back(map(double(i) / nx, double(j) / ny) + Vec3(0.0, 0.0, k * thickness));
    for (int i = 0; i < nx; ++i)
      for (int j = 0; j < ny; ++j) {
        std::array<int, 8> hex;
        for (int a = 0; a < 8; ++a)
          hex[a] = node(i + (hex_sign[a][0] + 1) / 2, j + (hex_sign[a][1] + 1) / 2,
                        (hex_sign[a][2] + 1) / 2);
        hexes.push_back(hex);
      }
    held.assign(3 * X.size(), false);
    for (size_t n = 0; n < X.size(); ++n) held[3 * n + 2] = true;
  }

  HexCoords at(int e, const std::vector<Vec3> &x) const
  {
    HexCoords c;
    for (int a = 0; a < 8; ++a) c.col(a) = x[hexes[e][a]];
    return c;
  }

  /// Newton's method from x, whose held degrees of freedom are where they shall be; returns the
  /// forces of the elements.
  Eigen::VectorXd solve(const HexKernel &kernel, const Eigen::VectorXd &load, std::vector<Vec3> &x,
                        double step) const
  {
    const int size = int(held.size());
    for (int iteration = 0;; ++iteration) {
      Eigen::VectorXd f = Eigen::VectorXd::Zero(size);
      kernel.add_forces(int(hexes.size()), nodes(), x[0].data(), coordinates(), f.data(), {});
      Eigen::VectorXd r = load + f;
      for (int i = 0; i < size; ++i)
        if (held[i]) r[i] = 0.0;
      if (r.norm() < 1e-6 * (load.norm() + f.norm())) return f;
      if (iteration == 25) throw std::runtime_error("no convergence");

      std::vector<Eigen::Triplet<double>> entries;
      for (int e = 0; e < int(hexes.size()); ++e) {
        const Matrix24 K = tangent(kernel, at(e, x), shape(e), step);
        for (int i = 0; i < 24; ++i)
          for (int j = 0; j < 24; ++j) {
            const int row = 3 * hexes[e][i / 3] + i % 3, column = 3 * hexes[e][j / 3] + j % 3;
            if (!held[row] && !held[column]) entries.emplace_back(row, column, K(i, j));
          }
      }
      for (int i = 0; i < size; ++i)
        if (held[i]) entries.emplace_back(i, i, 1.0);
      Eigen::SparseMatrix<double> K(size, size);
      K.setFromTriplets(entries.begin(), entries.end());
      const Eigen::VectorXd u = Eigen::SimplicialLDLT<Eigen::SparseMatrix<double>>(K).solve(r);
      for (size_t n = 0; n < x.size(); ++n) x[n] += u.segment<3>(3 * n);
    }
  }
};

MooneyRivlin rubber(double nu)    // E = 1
{
  const double mu = 1.0 / (2.0 * (1.0 + nu));
  return {0.4 * mu, 0.1 * mu, 1.0 / (3.0 * (1.0 - 2.0 * nu)), 1.0};
}

/// Bending moment of a strip of length 10, height 1 and width 1 in plane strain whose ends are
/// turned against each other, by the exact E/(1 - nu^2) I angle/length.
double bending_stiffness(const HexKernel &kernel, int layers)
{
  const double length = 10.0, angle = 1e-3;
  const double E = kernel.material().E, nu = kernel.material().nu;
  Sheet strip(10 * layers, layers, 1.0, [&](double s, double t) {
    return Vec3(length * s, t - 0.5, 0.0);
  });
  std::vector<Vec3> x = strip.X;
  // The exact field, u = (c x y, -c x^2/2 + ..., 0), has no traction but at the ends.
  for (int j = 0; j <= strip.ny; ++j)
    for (int k = 0; k < 2; ++k)
      for (int i : {0, strip.nx}) {
        const int n = strip.node(i, j, k);
        strip.held[3 * n] = true;
        if (i > 0) x[n][0] += angle * x[n][1];
      }
  for (int k = 0; k < 2; ++k) strip.held[3 * strip.node(0, 0, k) + 1] = true;

  const Eigen::VectorXd none = Eigen::VectorXd::Zero(int(strip.held.size()));
  const Eigen::VectorXd f = strip.solve(kernel, none, x, 1e-4);
  double moment = 0.0;
  for (int j = 0; j <= strip.ny; ++j)
    for (int k = 0; k < 2; ++k) {
      const int n = strip.node(strip.nx, j, k);
      moment -= f[3 * n] * strip.X[n][1];
    }
  return moment / (E / (1.0 - nu * nu) / 12.0 * angle / length);
}

TEST(Locking, ThinStripInBendingConvergesWithFBar)
{
  // In an element with edge h the bending field u_x = c x y leaves 1/n^2 of the strip's energy (n
  // layers), where only this much is right: E/(1 - nu^2), 4 G for nu = 1/2. With F-bar it costs its
  // deviatoric strain, 4/3 G, and parasitic shear, G: 5/12 too soft. In the plain element it costs
  // lambda + 2 G, and G. So both errors fall as 1/n^2, but from -0.4 or from hundreds.
  for (double nu : {0.495, 0.4999}) {
    const MooneyRivlinKernel fbar(rubber(nu));
    const LagrangianKernel plain(fbar.material());
    const double G = fbar.material().mu(), lambda = fbar.material().lambda();
    const double E = fbar.material().E / (1.0 - nu * nu);
    const double soft = 7.0 / 3.0 * G / E - 1.0, locked = (lambda + 3.0 * G) / E - 1.0;
    EXPECT_NEAR(soft, -5.0 / 12.0, 0.01);
    EXPECT_GT(locked, 20.0);
    for (int layers : {1, 2, 4, 8}) {
      const double error = bending_stiffness(fbar, layers) - 1.0;
      // 1e-4: the strip is bent by a finite angle
      EXPECT_NEAR(error, soft / (layers * layers), 1e-4) << nu << " " << layers;
      if (layers > 4) continue;
      const double plain_error = bending_stiffness(plain, layers) - 1.0;
      EXPECT_NEAR(plain_error, locked / (layers * layers), 1e-3 * locked) << nu << " " << layers;
    }
  }
}

/// Cook's membrane in plane strain, n x n elements: displacement of the upper right corner, in y.
double cook(const HexKernel &kernel, int n, double force, int increments)
{
  Sheet sheet(n, n, 1.0, [](double s, double t) {
    return Vec3(48.0 * s, (1.0 - s) * 44.0 * t + s * (44.0 + 16.0 * t), 0.0);
  });
  for (int j = 0; j <= n; ++j)
    for (int k = 0; k < 2; ++k)
      for (int i = 0; i < 2; ++i) sheet.held[3 * sheet.node(0, j, k) + i] = true;
  Eigen::VectorXd load = Eigen::VectorXd::Zero(int(sheet.held.size()));
  for (int j = 0; j <= n; ++j)
    for (int k = 0; k < 2; ++k)
      load[3 * sheet.node(n, j, k) + 1] = force / n * (j == 0 || j == n ? 0.25 : 0.5);
  std::vector<Vec3> x = sheet.X;
  for (int i = 1; i <= increments; ++i) sheet.solve(kernel, double(i) / increments * load, x, 1e-4);
  const int corner = sheet.node(n, n, 0);
  return x[corner][1] - sheet.X[corner][1];
}

TEST(Locking, CooksMembrane)
{
  // constants and force of Simo and Armero (1992), nu = 0.4999; corners make it converge slowly
  const double mu = 80.1938, K = 400889.8;
  const MooneyRivlinKernel fbar({0.5 * mu, 0.0, K, 1.0});
  const LagrangianKernel plain(fbar.material());
  for (double force : {1.0, 100.0}) {
    const int increments = force > 1.0 ? 10 : 1;
    double u[4];
    for (int i = 0; i < 4; ++i) u[i] = cook(fbar, 2 << i, force, increments);
    EXPECT_GT(u[1] - u[0], 2.0 * (u[2] - u[1]));
    EXPECT_GT(u[2] - u[1], 2.5 * (u[3] - u[2]));
    EXPECT_GT(u[3] - u[2], 0.0);
    const double a = u[2] - u[1], b = u[3] - u[2];
    const double limit = u[3] + b * b / (a - b);    // Aitken's extrapolation
    EXPECT_NEAR(u[3], limit, 0.02 * limit);
    if (force == 1.0) {
      EXPECT_LT(cook(plain, 4, force, 1), 0.3 * limit);
      EXPECT_LT(cook(plain, 16, force, 1), 0.4 * limit);
    } else {
      EXPECT_GT(u[3], 5.0);    // a strain of tens of per cent: by no means linear
    }
  }
}

}    // namespace
