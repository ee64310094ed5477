// The material law that Developer_defe.rst adds as an example: its file compiles as one of fe-module/src
// would, is read as an input line, and is the law that it says it is.

#include "law_yeoh.cpp"

#include "test_fe_common.h"

#include "defe/fe/mooney_rivlin.h"

#include <gtest/gtest.h>

using namespace defe;
using namespace defe::fe;
using namespace defe::fe::test;

namespace {

std::shared_ptr<const MaterialLaw> yeoh(const std::vector<std::string> &words,
                                        std::string &complaint)
{
  LawWords numbers(words, yeoh_law.usage);
  std::shared_ptr<const MaterialLaw> law = yeoh_law.make(numbers, complaint);
  if (!numbers.complaint().empty()) complaint = numbers.complaint();
  return complaint.empty() ? law : nullptr;
}

constexpr double C1 = 0.7, C2 = 0.4, K = 20.0;

std::unique_ptr<HexKernel> kernel(const std::string &second)
{
  std::string complaint;
  const auto law = yeoh({"yeoh", "0.7", second, "20", "1"}, complaint);
  EXPECT_EQ(complaint, "");
  return law->make_kernel();
}

TEST(NewLaw, StressInSimpleShear)
{
  // J = 1, I1 = 3 + g^2: sigma_xy = 2 (C1 + 2 C2 g^2) g
  const auto k = kernel("0.4");
  const HexCoords X = box(1.0, 2.0, 0.5);
  for (double g : {0.1, 0.5, 1.5}) {
    Mat3 F = Mat3::Identity();
    F(0, 1) = g;
    EXPECT_NEAR(k->stress(F * X, X, Vec3::Zero())(0, 1), 2.0 * (C1 + 2.0 * C2 * g * g) * g, 1e-12)
        << g;
  }
}

TEST(NewLaw, ForcesAreTheGradientOfTheEnergy)
{
  Random random(3);
  const auto k = kernel("0.4");
  for (int n = 0; n < 5; n++) {
    const HexCoords X = random_hex(random);
    const HexCoords x = random.rotation() * (X + random.matrix<HexCoords>(0.08));
    const HexCoords f = forces(*k, x, X);
    double energy = 0.0;
    HexCoords unused = HexCoords::Zero();
    HexKernel::Output out;
    out.energy = &energy;
    k->add_forces(1, first_hex, x.data(), X.data(), unused.data(), out);
    EXPECT_NEAR(energy, k->energy(x, X), 1e-12);
    for (int q = 0; q < 24; q++) {
      HexCoords plus = x, minus = x;
      plus.data()[q] += 1e-5;
      minus.data()[q] -= 1e-5;
      EXPECT_NEAR(f.data()[q], (k->energy(minus, X) - k->energy(plus, X)) / 2e-5, 1e-7);
    }
  }
}

TEST(NewLaw, WithoutItsSecondConstantItIsNeoHooke)
{
  Random random(4);
  const auto k = kernel("0");
  const MooneyRivlinKernel neo_hooke({C1, 0.0, K, 1.0});
  const HexCoords X = random_hex(random), x = X + random.matrix<HexCoords>(0.1);
  EXPECT_LT((forces(*k, x, X) - forces(neo_hooke, x, X)).norm(), 1e-12);
}

TEST(NewLaw, RefusesWhatItCannotUse)
{
  std::string complaint;
  EXPECT_FALSE(yeoh({"yeoh", "0.7", "-1", "20", "1"}, complaint));
  EXPECT_NE(complaint.find("C2 must not be negative"), std::string::npos) << complaint;
  EXPECT_FALSE(yeoh({"yeoh", "0.7", "0.4"}, complaint));
  EXPECT_NE(complaint.find("bulk modulus K is missing: use yeoh C1 C2 K rho"), std::string::npos)
      << complaint;
}

}    // namespace
