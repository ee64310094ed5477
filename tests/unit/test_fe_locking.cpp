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
                        double step, bool linear) const
  {
    const int size = int(held.size());
    for (int iteration = 0;; ++iteration) {
      Eigen::VectorXd f = Eigen::VectorXd::Zero(size);
      kernel.add_forces(int(hexes.size()), nodes(), x[0].data(), coordinates(), f.data(), {});
      Eigen::VectorXd r = load + f;
      for (int i = 0; i < size; ++i)
        if (held[i]) r[i] = 0.0;
      if (linear ? iteration == 1 : r.norm() < 1e-9 * (load.norm() + f.norm())) return f;
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
  const double length = 10.0, angle = 1e-5;
  const double E = kernel.material().E, nu = kernel.material().nu;
  Sheet strip(10 * layers, layers, 1.0, [&](double s, double t) {
    return Vec3(length * s, t - 0.5, 0.0);
  });
  std::vector<Vec3> x = strip.X;
  // The exact field u = (c x y, -c x^2/2 - ..., 0) needs u_x at the ends only, and no traction.
  // It is given everywhere to begin with: the ends jump less.
  for (int j = 0; j <= strip.ny; ++j)
    for (int k = 0; k < 2; ++k)
      for (int i : {0, strip.nx}) {
        const int n = strip.node(i, j, k);
        strip.held[3 * n] = true;
        if (i > 0) x[n][0] += angle * x[n][1];
      }
  for (int k = 0; k < 2; ++k) strip.held[3 * strip.node(0, 0, k) + 1] = true;

  // linear: one step from the undeformed state, for prescribed displacements as a load
  const Eigen::VectorXd none = Eigen::VectorXd::Zero(int(strip.held.size()));
  const Eigen::VectorXd f = strip.solve(kernel, none, x, 1e-4, true);
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
  // Parasitic shear of a trilinear element makes a strip of n layers of cubes too stiff by
  // G/E' /n^2 = (1 - nu)/2/n^2 (the element's warping mode without its bubble), Poisson's ratio near
  // 1/2 or not.
  for (double nu : {0.495, 0.4999}) {
    const MooneyRivlinKernel fbar(rubber(nu));
    const LagrangianKernel plain(fbar.material());
    double error[4], locked[4];
    for (int i = 0; i < 4; ++i) {
      error[i] = bending_stiffness(fbar, 1 << i) - 1.0;
      locked[i] = bending_stiffness(plain, 1 << i) - 1.0;
      printf("nu %g layers %d: F-bar %.5f plain %.5f\n", nu, 1 << i, error[i], locked[i]);
    }
  }
}

}    // namespace
