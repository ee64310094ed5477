// How a script gives the stress before any load: what restart files compare is what was read, and what is wrong is named.

#include "defe/coupling/prestress_rule.h"

#include <gmock/gmock.h>
#include <sstream>

using namespace defe;
using testing::HasSubstr;

namespace {

ParsedPrestress parse(const std::string &text)
{
  std::istringstream in(text);
  std::vector<std::string> words;
  for (std::string word; in >> word;) words.push_back(word);
  return parse_prestress(words);
}

}    // namespace

TEST(PrestressRule, WordsComeBack)
{
  const auto pane = parse("parabola y -0.001 7e-3 surface -1.02e8 contact 0.1");
  EXPECT_EQ(pane.complaint, "");
  EXPECT_EQ(pane.used, 6);
  EXPECT_EQ(pane.rule.parabola.axis, 1);
  EXPECT_EQ(pane.rule.parabola.upper, 0.007);
  EXPECT_EQ(pane.rule.words(), "parabola y -0.001 0.007 surface -102000000");
  EXPECT_EQ(parse(pane.rule.words()).rule.words(), pane.rule.words());

  const auto any = parse("variables v_a NULL v_b NULL NULL v_a shield no");
  EXPECT_EQ(any.complaint, "");
  EXPECT_EQ(any.used, 7);
  EXPECT_EQ(any.rule.variable[2], "b");
  EXPECT_EQ(any.rule.words(), "variables v_a NULL v_b NULL NULL v_a");
  EXPECT_FALSE(PrestressRule().given());
}

TEST(PrestressRule, WhatIsWrongIsNamed)
{
  EXPECT_THAT(parse("").complaint, HasSubstr("use parabola"));
  EXPECT_THAT(parse("line 1").complaint, HasSubstr("not line"));
  EXPECT_THAT(parse("parabola z 0 1").complaint, HasSubstr("surface STRESS"));
  EXPECT_THAT(parse("parabola w 0 1 surface 1").complaint, HasSubstr("not w"));
  EXPECT_THAT(parse("parabola z 0 top surface 1").complaint, HasSubstr("not top"));
  EXPECT_THAT(parse("parabola z 1 1 surface 1").complaint, HasSubstr("above the lower one"));
  EXPECT_THAT(parse("variables v_a 0 0 0 0 0").complaint, HasSubstr("not 0"));
  EXPECT_THAT(parse("variables NULL NULL NULL NULL NULL NULL").complaint, HasSubstr("leave"));
}
