// Criteria of conversion through LAMMPS: elements convert at the strain of the closed form, not before; a
// cracking beam is the same on any number of ranks and over a restart.

#include "cracking_beam.h"

#include <gmock/gmock.h>

#include <cmath>
#include <functional>

using namespace defe::test;
using defe::Mat3;
using defe::Vec3;

namespace {

constexpr double E = 74.09e9, nu = 0.2;
constexpr double lambda = E * nu / ((1.0 + nu) * (1.0 - 2.0 * nu)), mu = E / (2.0 * (1.0 + nu));

/// Elements that have converted after a step with a strain, with this in the place of the conversion stress.
double converted(const std::string &criterion, const std::string &options, const Mat3 &strain)
{
  Block block;
  block.n[0] = block.n[1] = block.n[2] = 2;
  block.convert = criterion + " type 2 group particles";
  block.options = options + " shield no";
  block.dt = 1e-15;
  Lammps lmp;
  lmp.commands(block.script());
  lmp.change([&](Particle &p) {
    p.x += strain * p.x;
  });
  lmp.run(2);
  return lmp.fe(CONVERTED);
}

/// Principal strains in uniaxial stress s.
Mat3 uniaxial(double s)
{
  return Vec3(s / E, -nu * s / E, -nu * s / E).asDiagonal();
}

/// The body turned, so that no axis is special.
Mat3 turned(const Mat3 &strain)
{
  const Mat3 R = Eigen::AngleAxisd(0.6, Vec3(1.0, 2.0, -1.0).normalized()).toRotationMatrix();
  return R * strain * R.transpose();
}

/// They all convert 1 % above the limit, none 1 % below: the kernels differ at second order of the strain.
void expect_limit(const std::string &criterion, const Mat3 &at_limit)
{
  for (const std::string options : {"kernel auto", "kernel lagrangian stress gauss"}) {
    SCOPED_TRACE(criterion + " " + options);
    EXPECT_EQ(converted(criterion, options, 0.99 * turned(at_limit)), 0.0);
    EXPECT_EQ(converted(criterion, options, 1.01 * turned(at_limit)), 8.0);
  }
}

}    // namespace

TEST(Criterion, PrincipalStrain)
{
  expect_limit("strain 7e-4", Vec3(7e-4, 3e-4, -2e-3).asDiagonal());
  expect_limit("strain 7e-4", uniaxial(-7e-4 / nu * E));    // lateral to a compression
}

TEST(Criterion, VonMises)
{
  expect_limit("mises 8e7", uniaxial(8e7));
  expect_limit("mises 8e7", uniaxial(-8e7));
  Mat3 shear = Mat3::Zero();
  shear(0, 1) = shear(1, 0) = 8e7 / std::sqrt(3.0) / (2.0 * mu);
  expect_limit("mises 8e7", shear);
}

TEST(Criterion, MohrCoulomb)
{
  const double phi = 35.0 / 180.0 * 3.14159265358979323846;
  expect_limit("mohr 4e7 35", uniaxial(2.0 * 4e7 * std::cos(phi) / (1.0 + std::sin(phi))));
  expect_limit("mohr 4e7 35", uniaxial(-2.0 * 4e7 * std::cos(phi) / (1.0 - std::sin(phi))));
  const Mat3 pressed = -2e-3 * Mat3::Identity();
  EXPECT_EQ(converted("mohr 4e7 35", "", pressed), 0.0);
}

TEST(Criterion, NameOfTheDefault)
{
  expect_limit("principal 5e7", uniaxial(5e7));
  expect_limit("5e7", uniaxial(5e7));
}

// The largest principal stress, entry 8, has nothing to do with the criterion.
TEST(Criterion, EntryOfTheLargestStress)
{
  Block block;
  block.convert = "mises 1e12 type 2 group particles";
  Lammps lmp;
  lmp.commands(block.script());
  const Mat3 strain = Vec3(-1e-3, 2e-4, 1e-4).asDiagonal();
  lmp.change([&](Particle &p) {
    p.x += strain * p.x;
  });
  lmp.run(0);
  const double expected = lambda * strain.trace() + 2.0 * mu * 2e-4;
  EXPECT_LT(expected, 0.0);
  EXPECT_NEAR(lmp.fe(S1_MAX), expected, 2e-3 * std::abs(expected));
}

TEST(Criterion, SameOnAnyRanksAndOverARestart)
{
  for (const std::string criterion : {"strain 7.6e-4", "mises 5.6e7", "mohr 4e7 20"}) {
    SCOPED_TRACE(criterion);
    Block block = cracking_beam();
    block.convert = criterion + " type 2 group particles";
    same_on_any_ranks_and_over_a_restart(block, "criterion", 220);
  }
}

TEST(Criterion, WrongOnesAreRefused)
{
  const auto message = [](const std::string &criterion) {
    Block block;
    block.convert = criterion + " type 2 group particles";
    try {
      Lammps lmp;
      lmp.commands(block.script());
    } catch (LAMMPS_NS::LAMMPSException &e) {
      return std::string(e.what());
    }
    return std::string();
  };
  EXPECT_THAT(message("tresca 5e7"),
              testing::HasSubstr("Fix defe convert glass: unknown criterion tresca: give the "
                                 "conversion stress, or use principal, strain, mises or mohr"));
  EXPECT_THAT(message("mohr 4e7"),
              testing::HasSubstr("must be a number, not type: use mohr cohesion angle"));
  EXPECT_THAT(message("0"), testing::HasSubstr("conversion stress must be > 0, not 0"));
}
