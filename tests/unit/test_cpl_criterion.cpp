// Criteria of conversion against their closed forms, their bounds, and how they are given.

#include "defe/coupling/criterion.h"

#include <gmock/gmock.h>

#include <Eigen/Geometry>

#include <cmath>
#include <random>

using namespace defe;
using testing::HasSubstr;

namespace {

constexpr double pi = 3.14159265358979323846;

fe::IsotropicElastic glass()
{
  fe::IsotropicElastic m;
  m.E = 74e9;
  m.nu = 0.2;
  m.rho = 2500.0;
  return m;
}

std::shared_ptr<const ConversionCriterion> make(const std::vector<std::string> &words)
{
  const auto parsed = parse_criterion(words, glass());
  EXPECT_EQ(parsed.complaint, "");
  EXPECT_EQ(parsed.used, static_cast<int>(words.size()));
  return parsed.criterion;
}

std::vector<std::shared_ptr<const ConversionCriterion>> all_criteria()
{
  return {make({"5e7"}), make({"strain", "7e-4"}), make({"mises", "8e7"}),
          make({"mohr", "4e7", "35"}), make({"mohr", "4e7", "0"})};
}

Mat3 diagonal(double a, double b, double c)
{
  return Vec3(a, b, c).asDiagonal();
}

double value(const ConversionCriterion &c, const Mat3 &s)
{
  Vec3 direction;
  return c.value(s, direction);
}

Mat3 random_stress(std::mt19937 &random)
{
  std::uniform_real_distribution<double> uniform(-1e8, 1e8);
  const Mat3 a = Mat3::NullaryExpr([&] {
    return uniform(random);
  });
  return 0.5 * (a + a.transpose());
}

}    // namespace

TEST(Criterion, LargestPrincipalStress)
{
  const auto c = make({"principal", "56e6"});
  EXPECT_EQ(c->limit(), 56e6);
  EXPECT_NEAR(value(*c, diagonal(-9e7, 3e7, 1e7)), 3e7, 1.0);
  EXPECT_NEAR(value(*c, diagonal(-9e7, -3e7, -1e7)), -1e7, 1.0);
  EXPECT_EQ(make({"56e6"})->limit(), 56e6);
}

// The strain of Hooke's law: e_1 = (s_1 - nu (s_2 + s_3))/E; in lateral compression -nu s/E.
TEST(Criterion, LargestPrincipalStrain)
{
  const auto c = make({"strain", "7e-4"});
  const double E = glass().E, nu = glass().nu;
  EXPECT_NEAR(value(*c, diagonal(3e7, 1e7, -9e7)), (3e7 - nu * (1e7 - 9e7)) / E, 1e-12);
  EXPECT_NEAR(value(*c, diagonal(0.0, 0.0, -9e7)), nu * 9e7 / E, 1e-12);
  EXPECT_DOUBLE_EQ(c->tensile_stress(), 7e-4 * E);
  // the same as from the strain itself
  std::mt19937 random(3);
  for (int n = 0; n < 20; n++) {
    const Mat3 e = 1e-12 * random_stress(random);
    const Mat3 s = glass().lambda() * e.trace() * Mat3::Identity() + 2.0 * glass().mu() * e;
    EXPECT_NEAR(value(*c, s), fe::max_principal(e), 1e-15);
  }
}

TEST(Criterion, VonMises)
{
  const auto c = make({"mises", "8e7"});
  EXPECT_NEAR(value(*c, diagonal(5e7, 0.0, 0.0)), 5e7, 1.0);
  EXPECT_NEAR(value(*c, diagonal(0.0, -5e7, 0.0)), 5e7, 1.0);
  EXPECT_NEAR(value(*c, diagonal(5e7, 5e7, 5e7)), 0.0, 1.0);
  Mat3 shear = Mat3::Zero();
  shear(0, 1) = shear(1, 0) = 4e7;
  EXPECT_NEAR(value(*c, shear), std::sqrt(3.0) * 4e7, 1.0);
  EXPECT_NEAR(value(*c, diagonal(6e7, 2e7, -1e7)),
              std::sqrt(0.5 * (4.0 * 4.0 + 3.0 * 3.0 + 7.0 * 7.0)) * 1e7, 1.0);
}

// On the worst of all planes, the shear traction less what friction holds is the cohesion.
TEST(Criterion, MohrCoulombIsCoulombOnTheWorstPlane)
{
  const double cohesion = 4e7;
  for (double degrees : {0.0, 20.0, 35.0, 60.0}) {
    const auto c = make({"mohr", "4e7", std::to_string(degrees)});
    const double phi = degrees * pi / 180.0;
    EXPECT_NEAR(c->tensile_stress(), 2.0 * cohesion * std::cos(phi) / (1.0 + std::sin(phi)), 10.0);
    const double compression = 2.0 * cohesion * std::cos(phi) / (1.0 - std::sin(phi));
    EXPECT_NEAR(value(*c, diagonal(-compression, 0, 0)), c->limit(), 1e-5 * compression);
    std::mt19937 random(5);
    for (int n = 0; n < 10; n++) {
      const Mat3 s = random_stress(random);
      // what would have to be added to the cohesion, over planes by their angle in the plane of s_1 and s_3
      const double s1 = fe::max_principal(s), s3 = -fe::max_principal(-s);
      double worst = -1e300;
      for (int k = 0; k <= 1800; k++) {
        const double angle = pi * k / 1800;
        const double normal = 0.5 * (s1 + s3) + 0.5 * (s1 - s3) * std::cos(2.0 * angle);
        const double shear = 0.5 * (s1 - s3) * std::abs(std::sin(2.0 * angle));
        worst = std::max(worst, shear + normal * std::tan(phi));
      }
      EXPECT_NEAR(value(*c, s) / c->limit(), worst / cohesion,
                  1e-4 * std::abs(worst / cohesion) + 1e-5)
          << degrees;
    }
  }
}

// Kernels let only elements through whose bound is above the limit.
TEST(Criterion, BoundsAreNowhereBelowAndSomewhereReached)
{
  std::mt19937 random(7);
  for (const auto &c : all_criteria()) {
    double closest = 1.0;
    for (int n = 0; n < 3000; n++) {
      const Mat3 s = random_stress(random);
      const double bound = fe::stress_bound(s, c->bound()), size = c->limit() / 5e7 * 1e8;
      const double gap = (bound - value(*c, s)) / size;
      EXPECT_GE(gap, -1e-12);
      closest = std::min(closest, gap);
    }
    EXPECT_LT(closest, 0.01);
  }
}

TEST(Criterion, TensileStressReachesTheLimit)
{
  for (const auto &c : all_criteria()) {
    EXPECT_NEAR(value(*c, diagonal(0.0, c->tensile_stress(), 0.0)), c->limit(), 1e-12 * c->limit());
    EXPECT_GT(c->limit(), 0.0);
  }
}

// No direction of space is another's better, and the direction is that of the largest tension.
TEST(Criterion, Isotropic)
{
  std::mt19937 random(11);
  const Mat3 R = Eigen::AngleAxisd(0.7, Vec3(1.0, -2.0, 0.5).normalized()).toRotationMatrix();
  const Mat3 s = diagonal(2e7, -6e7, 9e7);
  for (const auto &c : all_criteria()) {
    Vec3 direction;
    EXPECT_NEAR(c->value(R * s * R.transpose(), direction), value(*c, s), 1e-9 * c->limit());
    EXPECT_NEAR(std::abs(direction.dot(R.col(2))), 1.0, 1e-9);
  }
}

TEST(Criterion, WordsAreReadOrExplained)
{
  const auto used = [](const std::vector<std::string> &words) {
    return parse_criterion(words, glass()).used;
  };
  EXPECT_EQ(used({"56e6", "type", "4"}), 1);
  EXPECT_EQ(used({"mises", "56e6", "type", "4"}), 2);
  EXPECT_EQ(used({"mohr", "4e7", "35", "type", "4"}), 3);
  EXPECT_EQ(make({"mohr", "4e7", "35"})->numbers(), (std::vector<double>{4e7, 35.0}));
  for (const auto *entry : conversion_criteria()) EXPECT_THAT(entry->usage, HasSubstr(entry->name));

  const auto complaint = [](const std::vector<std::string> &words) {
    const auto parsed = parse_criterion(words, glass());
    EXPECT_EQ(parsed.criterion, nullptr);
    return parsed.complaint;
  };
  EXPECT_EQ(complaint({"0", "type", "4"}), "conversion stress must be > 0, not 0");
  EXPECT_EQ(complaint({"-1e6"}), "conversion stress must be > 0, not -1e6");
  EXPECT_THAT(complaint({"nan"}), HasSubstr("must be a number, not nan"));
  EXPECT_EQ(
      complaint({"tresca", "5"}),
      "unknown criterion tresca: give the conversion stress, or use principal, strain, mises or "
      "mohr");
  EXPECT_EQ(complaint({"mises", "type"}),
            "equivalent stress must be a number, not type: use mises stress");
  EXPECT_EQ(complaint({"strain", "-7e-4"}), "conversion strain must be > 0, not -7e-4");
  EXPECT_EQ(complaint({"mohr", "0", "35"}), "cohesion must be > 0, not 0");
  EXPECT_EQ(complaint({"mohr", "4e7", "90"}),
            "angle of internal friction must be from 0 to less than 90 degrees, not 90");
  EXPECT_THAT(complaint({"mohr", "4e7"}), HasSubstr("is missing: use mohr cohesion angle"));
  EXPECT_THAT(complaint({}), HasSubstr("is missing"));
}
