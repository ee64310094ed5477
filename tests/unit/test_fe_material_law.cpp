// The registry of material laws: what an input line gives, and how it is refused.

#include "test_fe_common.h"

#include "defe/fe/material_law.h"
#include "defe/fe/mooney_rivlin.h"
#include "defe/fe/prony.h"
#include "defe/fe/stable_step.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <sstream>

using namespace defe;
using namespace defe::fe;
using namespace defe::fe::test;
using testing::HasSubstr;

namespace {

ParsedMaterial parse(const std::string &line)
{
  std::istringstream stream(line);
  std::vector<std::string> words;
  for (std::string word; stream >> word;) words.push_back(word);
  return parse_material(words);
}

TEST(MaterialLaw, Elastic)
{
  const auto m = parse("elastic 74.09e9 0.2 2500 material impactor");
  ASSERT_TRUE(m.law) << m.complaint;
  EXPECT_EQ(m.used, 4);
  EXPECT_EQ(m.law->elastic().E, 74.09e9);
  EXPECT_EQ(m.law->elastic().nu, 0.2);
  EXPECT_EQ(m.law->elastic().rho, 2500.0);
  EXPECT_TRUE(m.law->linear());
  EXPECT_FALSE(m.law->rigid());

  Random random(1);
  const HexCoords brick = box(1e-3, 2e-3, 3e-3), other = random_hex(random);
  EXPECT_TRUE(m.law->has_shape_kernel(brick));
  EXPECT_FALSE(m.law->has_shape_kernel(other));
  EXPECT_FALSE(m.law->make_shape_kernel(brick)->uses_reference());
  EXPECT_TRUE(m.law->make_kernel()->uses_reference());
  EXPECT_EQ(m.law->make_kernel()->history_size(), 0);
  EXPECT_EQ(m.law->critical_step(brick), critical_step(brick, glass));
}

TEST(MaterialLaw, ElasticElementsAreEnhancedOrPlain)
{
  const auto standard = parse("elastic 74.09e9 0.2 2500 material impactor");
  const auto enhanced = parse("elastic 74.09e9 0.2 2500 enhanced material impactor");
  const auto plain = parse("elastic 74.09e9 0.2 2500 plain");
  ASSERT_TRUE(standard.law && enhanced.law && plain.law);
  EXPECT_EQ(enhanced.used, 5);
  EXPECT_EQ(plain.used, 5);
  EXPECT_STREQ(standard.law->elements(), "enhanced");
  EXPECT_STREQ(plain.law->elements(), "plain");
  // of restart files of versions that had plain elements only
  EXPECT_EQ(plain.description, "elastic 74.09e9 0.2 2500");
  EXPECT_EQ(standard.description, "elastic 74.09e9 0.2 2500 enhanced");
  EXPECT_EQ(enhanced.description, standard.description);
  EXPECT_EQ(parse("rigid 2500 plain").description, "rigid 2500");
  EXPECT_EQ(parse("rigid 2500 plain").used, 2);

  Random random(2);
  const HexCoords brick = box(1e-3, 2e-3, 3e-3), other = random_hex(random);
  for (const HexCoords &X : {brick, other}) {
    const HexCoords x = X + 1e-3 * X.norm() * random.matrix<HexCoords>(1.0);
    const bool shaped = standard.law->has_shape_kernel(X);
    const auto kernel = [&](const ParsedMaterial &m) {
      return shaped ? m.law->make_shape_kernel(X) : m.law->make_kernel();
    };
    EXPECT_LT(kernel(standard)->energy(x, X), 0.95 * kernel(plain)->energy(x, X));
    EXPECT_EQ(kernel(standard)->energy(x, X), kernel(enhanced)->energy(x, X));
    EXPECT_EQ(standard.law->critical_step(X), critical_step(X, glass));
    EXPECT_EQ(plain.law->critical_step(X), critical_step(X, glass, ElementType::plain));
  }
}

TEST(MaterialLaw, Mooney)
{
  const auto m = parse("mooney 1.6e6 0.06e6 3.31e8 1100 part");
  ASSERT_TRUE(m.law) << m.complaint;
  EXPECT_EQ(m.used, 5);
  EXPECT_NEAR(m.law->elastic().mu(), 3.32e6, 1.0);
  EXPECT_NEAR(m.law->elastic().bulk(), 3.31e8, 10.0);
  EXPECT_EQ(m.law->elastic().rho, 1100.0);
  EXPECT_FALSE(m.law->linear());
  EXPECT_FALSE(m.law->yields());
  const HexCoords brick = box(1e-3, 2e-3, 3e-3);
  EXPECT_FALSE(m.law->has_shape_kernel(brick));
  EXPECT_EQ(m.law->make_shape_kernel(brick), nullptr);
  const auto kernel = m.law->make_kernel();
  EXPECT_NE(dynamic_cast<MooneyRivlinKernel *>(kernel.get()), nullptr);
  EXPECT_EQ(m.law->critical_step(brick), critical_step_fbar(brick, kernel->material()));
}

TEST(MaterialLaw, Prony)
{
  const auto m = parse("prony 20e9 1100 0.69e6 2 0.2e9 12.6 0.13e9 1e3 convert glass");
  ASSERT_TRUE(m.law) << m.complaint;
  EXPECT_EQ(m.used, 9);
  EXPECT_NEAR(m.law->elastic().mu(), 0.33069e9, 1.0);
  EXPECT_NEAR(m.law->elastic().bulk(), 20e9, 1.0);
  const auto kernel = m.law->make_kernel();
  EXPECT_EQ(kernel->history_size(), 8 * 6 * 3);
  const HexCoords brick = box(1e-3, 2e-3, 3e-3);
  EXPECT_EQ(m.law->critical_step(brick), critical_step_fbar(brick, kernel->material()));
  EXPECT_EQ(parse("prony 20e9 1100 0.69e6 0").used, 5);
}

TEST(MaterialLaw, Plastic)
{
  const HexCoords brick = box(1e-3, 2e-3, 3e-3);
  const auto m = parse("plastic 210e9 0.3 7800 400e6 1e9 convert glass");
  ASSERT_TRUE(m.law) << m.complaint;
  EXPECT_EQ(m.used, 6);
  EXPECT_FALSE(m.law->linear());
  EXPECT_TRUE(m.law->yields());
  EXPECT_NEAR(m.law->elastic().E, 210e9, 1.0);
  const auto kernel = m.law->make_kernel();
  EXPECT_EQ(kernel->history_size(), 8 * 13);
  EXPECT_EQ(m.law->critical_step(brick), critical_step_fbar(brick, kernel->material()));
  EXPECT_EQ(parse("plastic 210e9 0.3 7800 400e6 1e9 kinematic 2e9 part").used, 8);
  EXPECT_EQ(parse("johnson-cook 200e9 0.29 7830 792e6 510e6 0.26 0.014 1 part").used, 9);
  const auto heated =
      parse("johnson-cook 200e9 0.29 7830 792e6 510e6 0.26 0.014 1 thermal 1.03 293 1793 477 0.9");
  ASSERT_TRUE(heated.law) << heated.complaint;
  EXPECT_EQ(heated.used, 15);
  EXPECT_EQ(heated.law->make_kernel()->history_size(), 8 * 15);
}

TEST(MaterialLaw, Rigid)
{
  const auto m = parse("rigid 6.25e6");
  ASSERT_TRUE(m.law) << m.complaint;
  EXPECT_EQ(m.used, 2);
  EXPECT_TRUE(m.law->rigid());
  EXPECT_EQ(m.law->elastic().rho, 6.25e6);
  EXPECT_EQ(m.law->make_kernel(), nullptr);
  EXPECT_EQ(m.law->critical_step(box(1.0, 1.0, 1.0)), HUGE_VAL);
}

TEST(MaterialLaw, ComplaintsNameCauseAndRemedy)
{
  const auto refused = [](const std::string &line, const std::string &text) {
    const auto m = parse(line);
    EXPECT_EQ(m.law, nullptr) << line;
    EXPECT_THAT(m.complaint, HasSubstr(text)) << line;
    EXPECT_THAT(m.complaint, testing::Not(HasSubstr("\n")));
  };
  EXPECT_EQ(
      parse("rubber 1 2 3").complaint,
      "Unknown material law rubber: use elastic, mooney, prony, plastic, johnson-cook or rigid");
  refused("", "Material law is missing: use elastic");
  refused("elastic 74e9 0.2", "density rho is missing: use elastic E nu rho");
  refused("elastic 74e9 0.5 2500", "Poisson's ratio");
  refused("elastic 74GPa 0.2 2500", "Young's modulus E must be a number, not 74GPa");
  refused("elastic inf 0.2 2500", "must be a number, not inf");
  refused("elastic 74e9 nan 2500", "must be a number, not nan");
  refused("mooney 1.6e6 0.06e6 part", "bulk modulus K must be a number, not part: use mooney C10");
  refused("mooney 1.6e6 0.06e6 0.495 1100", "bulk modulus must be at least");
  refused("mooney -1.6e6 0.06e6 1e9 1100", "C10 must not be negative");
  refused("prony 20e9 1100 0.69e6 2 0.2e9 12.6 0.1e9", "decay rate beta_2 is missing");
  refused("prony 20e9 1100 0.69e6 2 0.2e9 -12.6 0.1e9 3", "beta of Prony term 1");
  refused("prony 20e9 1100 0.69e6 1.5 0.2e9 12.6", "must be an integer from 0 to 32, not 1.5");
  refused("prony 20e9 1100 0.69e6 99 0.2e9 12.6", "must be an integer from 0 to 32, not 99");
  refused("prony 1e3 1100 0.69e6 0", "bulk modulus must be at least");
  refused("plastic 210e9 0.3 7800 400e6",
          "hardening modulus H is missing: use plastic E nu rho sigma_y H");
  refused("plastic 210e9 0.3 7800 400e6 1e9 kinematic",
          "kinematic hardening modulus H_k is missing");
  refused("plastic 210e9 0.5 7800 400e6 1e9", "Poisson's ratio");
  refused("plastic 210e9 -0.1 7800 400e6 1e9", "Poisson's ratio");
  refused("plastic 210e9 0.3 7800 0 1e9", "yield stress must be positive, not 0");
  refused("plastic 210 0.3 7800 400e6 1e9", "check the units");
  refused("plastic 210e9 0.3 7800 400e6 -1e9", "hardening must not be negative");
  const std::string steel = "johnson-cook 200e9 0.29 7830 792e6 510e6 ";
  refused(steel + "0.26 0.014", "reference rate is missing");
  refused(steel + "26 0.014 1", "exponent n must be above 0 and not above 1, not 26");
  refused(steel + "0.26 -0.014 1", "rate factor C must not be negative");
  refused(steel + "0.26 0.014 0", "reference rate must be positive, not 0");
  refused(steel + "0.26 0.014 1 thermal 0 293 1793 477 0.9", "thermal exponent m must be positive");
  refused(steel + "0.26 0.014 1 thermal 1 293 200 477 0.9",
          "T_melt must be above the starting temperature T_0");
  refused(steel + "0.26 0.014 1 thermal 1 293 1793 0 0.9", "specific heat c_p must be positive");
  refused(steel + "0.26 0.014 1 thermal 1 293 1793 477 90",
          "chi of the plastic work must lie between 0 and 1");
  refused(steel + "0.26 0.014 1 thermal 1 293 1793 477", "heated fraction chi is missing");
  refused("rigid 0", "density must be positive, not 0");
  refused("rigid", "density rho is missing: use rigid rho");
}

TEST(MaterialLaw, EveryLawHasItsUsageAndRefusesToBeEmpty)
{
  for (const MaterialLawEntry *law : material_laws()) {
    EXPECT_EQ(std::string(law->usage).rfind(law->name, 0), 0u);
    const auto m = parse(law->name);
    EXPECT_EQ(m.law, nullptr);
    EXPECT_THAT(m.complaint, HasSubstr(law->usage));
  }
}

}    // namespace
