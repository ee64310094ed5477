// Shape functions, quadrature, checks of the element shape; materials; principal stresses.

#include "test_fe_common.h"

#include "defe/fe/principal.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <limits>
#include <regex>
#include <string>

using namespace defe;
using namespace defe::fe;
using namespace defe::fe::test;

namespace {

const double inf = std::numeric_limits<double>::infinity();
const double nan = std::nan("");

Vec3 corner(int a)
{
  return {double(hex_sign[a][0]), double(hex_sign[a][1]), double(hex_sign[a][2])};
}

TEST(Shape, IsOneAtItsNodeAndZeroAtTheOthers)
{
  for (int a = 0; a < 8; ++a)
    EXPECT_EQ((shape(corner(a)) - Eigen::Matrix<double, 8, 1>::Unit(a)).norm(), 0.0) << a;
}

TEST(Shape, PartitionOfUnity)
{
  Random random(1);
  for (int i = 0; i < 100; ++i) {
    const Vec3 xi = random.matrix<Vec3>(1.0);
    EXPECT_NEAR(shape(xi).sum(), 1.0, 1e-15);
    EXPECT_LT(shape_gradient(xi).colwise().sum().norm(), 1e-15);
  }
}

TEST(Shape, GradientIsTheDerivative)
{
  // trilinear: a central difference along one axis is exact but for rounding
  Random random(2);
  for (int i = 0; i < 20; ++i) {
    const Vec3 xi = random.matrix<Vec3>(1.0);
    for (int k = 0; k < 3; ++k) {
      const Vec3 step = 0.25 * Vec3::Unit(k);
      const Eigen::Matrix<double, 8, 1> difference = (shape(xi + step) - shape(xi - step)) / 0.5;
      EXPECT_LT((difference - shape_gradient(xi).col(k)).norm(), 1e-15);
    }
  }
}

TEST(Shape, InterpolatesLinearFieldsExactly)
{
  Random random(3);
  const HexCoords X = random_hex(random);
  const Mat3 A = random.matrix<Mat3>(1.0);
  const Vec3 xi = random.matrix<Vec3>(1.0);
  EXPECT_LT((interpolate(A * X, xi) - A * interpolate(X, xi)).norm(), 1e-15);
  // the gradient of that field is A
  EXPECT_LT((jacobian(A * X, xi) * jacobian(X, xi).inverse() - A).norm(), 1e-14);
}

TEST(Quadrature, PointsAreOrderedAndIntegrateCubics)
{
  for (int a = 0; a < 8; ++a) EXPECT_NEAR(gauss_points()[a].dot(corner(a)), std::sqrt(3.0), 1e-15);
  for (int p = 0; p <= 3; ++p)
    for (int q = 0; q <= 3; ++q)
      for (int r = 0; r <= 3; ++r) {
        double sum = 0.0;
        for (const Vec3 &xi : gauss_points())
          sum += std::pow(xi[0], p) * std::pow(xi[1], q) * std::pow(xi[2], r);
        const auto exact = [](int n) {
          return n % 2 ? 0.0 : 2.0 / (n + 1);
        };
        EXPECT_NEAR(sum, exact(p) * exact(q) * exact(r), 1e-14) << p << q << r;
      }
}

// Volume = 1/3 of the flux of X through the bilinear faces, integrated exactly by 3 x 3 points.
double volume_by_divergence_theorem(const HexCoords &X)
{
  const double point[3] = {-std::sqrt(0.6), 0.0, std::sqrt(0.6)};
  const double weight[3] = {5.0 / 9.0, 8.0 / 9.0, 5.0 / 9.0};
  double sum = 0.0;
  for (const auto &face : hex_face) {
    Vec3 p[4];
    for (int i = 0; i < 4; ++i) p[i] = X.col(face[i]);
    for (int i = 0; i < 3; ++i)
      for (int j = 0; j < 3; ++j) {
        const double s = point[i], t = point[j];
        const Vec3 r = 0.25 *
            ((1 - s) * (1 - t) * p[0] + (1 + s) * (1 - t) * p[1] + (1 + s) * (1 + t) * p[2] +
             (1 - s) * (1 + t) * p[3]);
        const Vec3 rs = 0.25 * ((1 - t) * (p[1] - p[0]) + (1 + t) * (p[2] - p[3]));
        const Vec3 rt = 0.25 * ((1 - s) * (p[3] - p[0]) + (1 + s) * (p[2] - p[1]));
        sum += weight[i] * weight[j] * r.dot(rs.cross(rt)) / 3.0;
      }
  }
  return sum;
}

TEST(Volume, OfRandomHexesByTheDivergenceTheorem)
{
  Random random(4);
  for (int i = 0; i < 50; ++i) {
    const HexCoords X = random_hex(random);
    EXPECT_NEAR(volume(X), volume_by_divergence_theorem(X), 1e-14);
  }
}

TEST(Volume, FarFromTheOriginKeepsItsDigits)
{
  HexCoords X = box(2e-3, 1e-3, 4e-3);
  X.colwise() += Vec3(10.0, -20.0, 30.0);
  // coordinates are rounded to 4e-15, 4e-12 of an edge
  EXPECT_NEAR(volume(X) / 8e-9, 1.0, 2e-11);
}

TEST(Mass, OfANodeIsAnEighth)
{
  EXPECT_NEAR(nodal_mass(box(1e-3, 2e-3, 2e-3), 2500.0), 1.25e-6, 1e-20);
  Random random(5);
  const HexCoords X = random_hex(random);
  EXPECT_NEAR(8.0 * nodal_mass(X, 3.0), 3.0 * volume_by_divergence_theorem(X), 1e-13);
}

TEST(Lengths, OfABox)
{
  const HexCoords X = box(3.0, 2.0, 6.0);
  EXPECT_NEAR(characteristic_length(X), 2.0, 1e-14);
  EXPECT_NEAR(max_diagonal(X), 7.0, 1e-14);
  EXPECT_NEAR(max_face_diagonal(X), std::sqrt(45.0), 1e-14);
}

TEST(Lengths, AreaOfPlaneAndWarpedFaces)
{
  Random random(6);
  const Mat3 R = random.rotation();
  // shoelace: 7.5
  const Vec3 plane[4] = {R * Vec3(0, 0, 1), R * Vec3(3, 0, 1), R * Vec3(4, 2, 1),
                         R * Vec3(0.5, 2.5, 1)};
  EXPECT_NEAR(face_area(plane), 7.5, 1e-14);

  // hyperbolic paraboloid z = c s t on [-1, 1]^2: 4 (1 + c^2/3) + O(c^4)
  const double c = 0.01;
  const Vec3 warped[4] = {{-1, -1, c}, {1, -1, -c}, {1, 1, c}, {-1, 1, -c}};
  EXPECT_NEAR(face_area(warped), 4.0 * (1.0 + c * c / 3.0), 1e-8);
}

TEST(CheckHex, GoodOnes)
{
  Random random(7);
  for (double scale : {1e-6, 1.0, 1e6}) {
    const HexCheck check = check_hex(scale * box(1.0, 2.0, 1e-3));
    EXPECT_EQ(check.verdict, HexCheck::good);
    EXPECT_NEAR(check.min_gauss_jacobian / std::pow(scale, 3), 2e-3 / 8.0, 1e-15);
    EXPECT_NEAR(check.min_corner_jacobian / std::pow(scale, 3), 2e-3 / 8.0, 1e-15);
    EXPECT_EQ(check_hex(scale * random_hex(random)).verdict, HexCheck::good);
  }
}

TEST(CheckHex, RefusesInvertedFlatAndNonFiniteOnesInOneLine)
{
  const auto complaint = [](const HexCoords &X) {
    const HexCheck check = check_hex(X);
    EXPECT_EQ(check.verdict, HexCheck::bad);
    const std::string text = describe_bad_hex(4711, X, check);
    EXPECT_EQ(text.find('\n'), std::string::npos);
    EXPECT_NE(text.find("4711"), std::string::npos);
    return text;
  };

  HexCoords mirrored = box(1.0, 1.0, 1.0);
  mirrored.row(2) *= -1.0;
  EXPECT_NE(complaint(mirrored).find("inverted"), std::string::npos);
  EXPECT_NE(complaint(mirrored).find("(1 1 -1)"), std::string::npos);

  HexCoords one_node_through = box(1.0, 1.0, 1.0);
  one_node_through.col(6) = Vec3(-0.9, -0.9, -0.9);
  EXPECT_NE(complaint(one_node_through).find("inverted"), std::string::npos);

  EXPECT_NE(complaint(box(1.0, 1.0, 1e-7)).find("flat"), std::string::npos);
  EXPECT_EQ(check_hex(HexCoords::Zero()).verdict, HexCheck::bad);

  HexCoords unset = box(1.0, 1.0, 1.0);
  unset(1, 3) = nan;
  EXPECT_NE(complaint(unset).find("not a finite number"), std::string::npos);
  unset(1, 3) = inf;
  EXPECT_NE(complaint(unset).find("not a finite number"), std::string::npos);
}

TEST(CheckHex, ReentrantCornerIsSuspiciousOnly)
{
  HexCoords X = box(1.0, 1.0, 1.0);
  X.col(0) = Vec3(0.4, 0.4, 0.4);    // beyond the plane of its three neighbours, x + y + z = 1
  const HexCheck check = check_hex(X);
  EXPECT_EQ(check.verdict, HexCheck::suspicious);
  EXPECT_LT(check.min_corner_jacobian, 0.0);
  EXPECT_GT(check.min_gauss_jacobian, 0.0);
  EXPECT_NE(describe_bad_hex(7, X, check).find("corner"), std::string::npos);
}

TEST(Stiffness, EnergyOfUniformStrain)
{
  Random random(8);
  for (int i = 0; i < 10; ++i) {
    const HexCoords X = random_hex(random);
    const Mat3 H = random.matrix<Mat3>(1.0), e = 0.5 * (H + H.transpose());
    const HexCoords u = H * X;
    const Eigen::Map<const Eigen::Matrix<double, 24, 1>> v(u.data());
    const double exact =
        volume(X) * (0.5 * unit.lambda() * e.trace() * e.trace() + unit.mu() * e.squaredNorm());
    EXPECT_NEAR(0.5 * v.dot(stiffness(X, unit) * v), exact, 1e-13);
    const Mat3 s = unit.lambda() * e.trace() * Mat3::Identity() + 2.0 * unit.mu() * e;
    EXPECT_LT((linear_stress(X, u, unit, random.matrix<Vec3>(1.0)) - s).norm(), 1e-13);
  }
}

TEST(Elastic, Moduli)
{
  // glass of the benchmark; wave speeds from its reference figures
  EXPECT_NEAR(glass.lambda(), 20.5805556e9, 1e2);
  EXPECT_NEAR(glass.mu(), 30.8708333e9, 1e2);
  EXPECT_NEAR(glass.bulk(), glass.lambda() + 2.0 / 3.0 * glass.mu(), 1e-4);
  EXPECT_NEAR(glass.c_bar(), 5443.9, 0.05);
  EXPECT_NEAR(glass.c_dilatational(), 5738.4, 0.05);
}

TEST(Elastic, ValidateNamesTheBadConstant)
{
  using testing::HasSubstr;
  EXPECT_EQ(glass.validate(), "");
  EXPECT_EQ((IsotropicElastic{1.0, -0.99, 1.0}.validate()), "");
  EXPECT_THAT((IsotropicElastic{0.0, 0.2, 1.0}.validate()), HasSubstr("Young"));
  EXPECT_THAT((IsotropicElastic{nan, 0.2, 1.0}.validate()), HasSubstr("Young"));
  EXPECT_THAT((IsotropicElastic{inf, 0.2, 1.0}.validate()), HasSubstr("Young"));
  EXPECT_THAT((IsotropicElastic{1.0, 0.5, 1.0}.validate()), HasSubstr("Poisson"));
  EXPECT_THAT((IsotropicElastic{1.0, -1.0, 1.0}.validate()), HasSubstr("Poisson"));
  EXPECT_THAT((IsotropicElastic{1.0, nan, 1.0}.validate()), HasSubstr("Poisson"));
  EXPECT_THAT((IsotropicElastic{1.0, 0.2, -2500.0}.validate()), HasSubstr("-2500"));
  EXPECT_THAT((IsotropicElastic{1.0, 0.2, nan}.validate()), HasSubstr("density"));
}

TEST(Principal, RotatedDiagonalTensor)
{
  Random random(9);
  for (int i = 0; i < 50; ++i) {
    const Mat3 R = random.rotation();
    const Vec3 values(-3.0, 5.0, 1.0);
    const Mat3 s = R * values.asDiagonal() * R.transpose();
    Vec3 direction;
    EXPECT_NEAR(max_principal(s), 5.0, 1e-14);
    EXPECT_NEAR(max_principal(s, direction), 5.0, 1e-14);
    EXPECT_NEAR(std::abs(direction.dot(R.col(1))), 1.0, 1e-14);
  }
}

TEST(Principal, BoundIsABoundAndExactInUniaxialTension)
{
  Random random(10);
  for (int i = 0; i < 1000; ++i) {
    const Mat3 A = random.matrix<Mat3>(1.0), s = A + A.transpose();
    EXPECT_GE(max_principal_bound(s), max_principal(s) - 1e-15);
    const double J2 = 0.5 * (s - s.trace() / 3.0 * Mat3::Identity()).squaredNorm();
    EXPECT_LE(max_principal_bound(s), max_principal(s) + std::sqrt(J2 / 3.0) + 1e-15);
  }
  const Vec3 n = random.rotation().col(0);
  const Mat3 uniaxial = 60e6 * n * n.transpose();
  EXPECT_NEAR(max_principal(uniaxial), 60e6, 1e-6);
  EXPECT_NEAR(max_principal_bound(uniaxial), 60e6, 1e-6);
  EXPECT_NEAR(max_principal(-uniaxial), 0.0, 1e-6);
}

}    // namespace
