// The 3-D patch test of MacNeal and Harder, "A proposed standard set of problems to test finite
// element accuracy", Finite Elements in Analysis and Design 1 (1985) 3-20: a unit cube of seven
// irregular hexahedra, one inside and one at each face, under a linear displacement field.

#include "test_fe_common.h"

#include "defe/fe/enhanced_kernel.h"
#include "defe/fe/mooney_rivlin.h"
#include "defe/fe/plastic.h"
#include "defe/fe/prony.h"

#include <gtest/gtest.h>

#include <functional>
#include <memory>

using namespace defe;
using namespace defe::fe;
using namespace defe::fe::test;

namespace {

const IsotropicElastic material{1e6, 0.25, 1.0};

// Nodes 0..7: inner, 8..15: outer, both in the order of a hexahedron.
Mesh macneal_harder()
{
  Mesh mesh;
  mesh.X = {{0.249, 0.342, 0.192}, {0.826, 0.288, 0.288}, {0.850, 0.649, 0.263},
            {0.273, 0.750, 0.230}, {0.320, 0.186, 0.643}, {0.677, 0.305, 0.683},
            {0.788, 0.693, 0.644}, {0.165, 0.745, 0.702}};
  const HexCoords cube = box(1.0, 1.0, 1.0);
  for (int a = 0; a < 8; ++a) mesh.X.push_back(cube.col(a));

  mesh.hexes.push_back({0, 1, 2, 3, 4, 5, 6, 7});
  for (int face = 0; face < 6; ++face) {
    std::array<int, 8> hex;
    for (int a = 0; a < 8; ++a)
      hex[a] = hex_face_position(face, a) >= 0 ? 8 + a : hex_edge_neighbor(a, face / 2);
    mesh.hexes.push_back(hex);
  }
  return mesh;
}

Vec3 published_displacement(const Vec3 &X)
{
  const double x = X[0], y = X[1], z = X[2];
  return 1e-3 * Vec3(x + y / 2 + z / 2, x / 2 + y + z / 2, x / 2 + y / 2 + z);
}

Mat3 published_stress()
{
  Mat3 s = Mat3::Constant(400.0);
  s.diagonal().setConstant(2000.0);
  return s;
}

TEST(MacNealHarder, FillsTheUnitCubeWithOneSuspiciousElement)
{
  const Mesh mesh = macneal_harder();
  double sum = 0.0;
  int suspicious = 0;
  for (int e = 0; e < 7; ++e) {
    sum += volume(mesh.shape(e));
    const HexCheck check = check_hex(mesh.shape(e));
    EXPECT_NE(check.verdict, HexCheck::bad) << describe_bad_hex(e, mesh.shape(e), check);
    if (check.verdict == HexCheck::suspicious) ++suspicious;
  }
  EXPECT_NEAR(sum, 1.0, 1e-15);
  EXPECT_EQ(suspicious, 1);
}

TEST(MacNealHarder, LinearStressesAndEquilibrium)
{
  const Mesh mesh = macneal_harder();
  std::vector<Vec3> residual(16, Vec3::Zero());
  for (int e = 0; e < 7; ++e) {
    const HexCoords X = mesh.shape(e);
    HexCoords u;
    for (int a = 0; a < 8; ++a) u.col(a) = published_displacement(X.col(a));
    for (const Vec3 &xi : gauss_points())
      EXPECT_LT((linear_stress(X, u, material, xi) - published_stress()).norm(), 1e-9);
    EXPECT_LT((linear_stress(X, u, material, Vec3::Zero()) - published_stress()).norm(), 1e-9);

    HexCoords f;
    Eigen::Map<Eigen::Matrix<double, 24, 1>>(f.data()) =
        stiffness(X, material) * Eigen::Map<const Eigen::Matrix<double, 24, 1>>(u.data());
    for (int a = 0; a < 8; ++a) residual[mesh.hexes[e][a]] += f.col(a);
  }
  for (int n = 0; n < 8; ++n) EXPECT_LT(residual[n].norm(), 1e-10);    // of forces around 500
  for (int n = 8; n < 16; ++n) EXPECT_GT(residual[n].norm(), 100.0);
}

// the test as published: displacements given on the cube's corners only
void solve_for_inner_nodes(Eigen::Matrix<double, 24, 24> (*stiffness)(const HexCoords &,
                                                                      const IsotropicElastic &))
{
  const Mesh mesh = macneal_harder();
  Eigen::Matrix<double, 48, 48> K = Eigen::Matrix<double, 48, 48>::Zero();
  for (int e = 0; e < 7; ++e) {
    const auto Ke = stiffness(mesh.shape(e), material);
    for (int a = 0; a < 8; ++a)
      for (int b = 0; b < 8; ++b)
        K.block<3, 3>(3 * mesh.hexes[e][a], 3 * mesh.hexes[e][b]) += Ke.block<3, 3>(3 * a, 3 * b);
  }
  Eigen::Matrix<double, 24, 1> outer, exact;
  for (int n = 0; n < 8; ++n) {
    exact.segment<3>(3 * n) = published_displacement(mesh.X[n]);
    outer.segment<3>(3 * n) = published_displacement(mesh.X[8 + n]);
  }
  const Eigen::MatrixXd inner_stiffness = K.topLeftCorner<24, 24>();
  const Eigen::VectorXd inner = inner_stiffness.llt().solve(-K.topRightCorner<24, 24>() * outer);
  EXPECT_LT((inner - exact).cwiseAbs().maxCoeff(), 1e-16);
}

TEST(MacNealHarder, InnerNodesAreSolvedFor)
{
  solve_for_inner_nodes(stiffness);
  solve_for_inner_nodes(stiffness_enhanced);
}

// The kernels at finite strain and rotation: all laws give a uniform stress in a uniform
// deformation, so the inner nodes must still be in equilibrium.
using MakeKernel = std::function<std::unique_ptr<HexKernel>(const HexCoords &)>;

// relative to the outer nodes' forces; where those happen to need little pressure, to what a volume
// change of a tenth of the strain would need
double inner_residual(const Mesh &mesh, const Mat3 &F, double strain, const MakeKernel &make)
{
  std::vector<Vec3> x;
  for (const Vec3 &X : mesh.X) x.push_back(F * X + Vec3(0.1, 0.2, 0.3));
  std::vector<Vec3> f(16, Vec3::Zero());
  for (int e = 0; e < 7; ++e) {
    const auto kernel = make(mesh.shape(e));
    // with a history: the strain has come half a decay time ago
    kernel->add_forces(1, mesh.nodes() + e, x[0].data(), mesh.coordinates(), f[0].data(),
                       Histories(*kernel, 1).output(0.5));
  }
  double inner = 0.0, outer = 0.1 * strain * make(mesh.shape(0))->material().bulk();
  for (int n = 0; n < 8; ++n) {
    inner = std::max(inner, f[n].norm());
    outer = std::max(outer, f[8 + n].norm());
  }
  return inner / outer;
}

TEST(MacNealHarder, KernelsAtFiniteStrainAndRotation)
{
  const double mu = material.mu(), bulk = material.bulk();
  const MakeKernel kernels[] = {[](const HexCoords &) {
                                  return std::make_unique<LagrangianKernel>(material);
                                },
                                [](const HexCoords &) {
                                  return std::make_unique<EnhancedKernel>(material);
                                },
                                [&](const HexCoords &) {
                                  return std::make_unique<MooneyRivlinKernel>(
                                      MooneyRivlin{0.4 * mu, 0.1 * mu, bulk, material.rho});
                                },
                                [&](const HexCoords &) {
                                  return std::make_unique<PronyKernel>(
                                      Prony{bulk, material.rho, 0.2 * mu, {{0.8 * mu, 1.0}}});
                                },
                                // yields at a strain of 1e-4
                                [&](const HexCoords &) {
                                  Plastic m;
                                  m.K = bulk;
                                  m.G = mu;
                                  m.rho = material.rho;
                                  m.yield = 1e-4 * mu;
                                  m.hardening = 0.1 * mu;
                                  m.exponent = 0.5;
                                  return std::make_unique<PlasticKernel>(m);
                                },
                                // nearly incompressible: nu = 0.4999
                                [&](const HexCoords &) {
                                  return std::make_unique<MooneyRivlinKernel>(
                                      MooneyRivlin{0.4 * mu, 0.1 * mu, 5000.0 * mu, material.rho});
                                }};
  const Mesh mesh = macneal_harder();
  Random random(1);
  for (double strain : {1e-3, 0.2})
    for (int i = 0; i < 10; ++i) {
      const Mat3 F = random.rotation() * (Mat3::Identity() + random.matrix<Mat3>(strain));
      for (const MakeKernel &make : kernels)
        EXPECT_LT(inner_residual(mesh, F, strain, make), 1e-14 / strain) << &make - kernels;
    }
}

TEST(MacNealHarder, KernelStressesInTheLimitOfSmallStrain)
{
  // scaled down by 1e-4: finite strain changes the stresses by 1e-7 of themselves
  const double scale = 1e-4;
  const Mesh mesh = macneal_harder();
  const LagrangianKernel lagrangian(material);
  const EnhancedKernel enhanced(material);
  for (int e = 0; e < 7; ++e) {
    const HexCoords X = mesh.shape(e);
    HexCoords x;
    for (int a = 0; a < 8; ++a) x.col(a) = X.col(a) + scale * published_displacement(X.col(a));
    for (const Vec3 &xi : gauss_points()) {
      EXPECT_LT((lagrangian.stress(x, X, xi) / scale - published_stress()).norm(), 1e-3);
      EXPECT_LT((enhanced.stress(x, X, xi) / scale - published_stress()).norm(), 1e-3);
    }
  }
}

}    // namespace
