#include "defe/coupling/words.h"

#include <gtest/gtest.h>

using defe::same_words;

TEST(Words, NumbersAreComparedAsNumbers)
{
  EXPECT_TRUE(same_words("elastic 74.09e9 0.2 2500", "elastic 7.409e10 .20  2.5e3"));
  EXPECT_TRUE(same_words("2500, DEs of type 2", "2.5e3, DEs of type 2"));
  EXPECT_TRUE(same_words("", "  "));
  EXPECT_FALSE(same_words("elastic 74.09e9", "elastic 74.08e9"));
  EXPECT_FALSE(same_words("2500, DEs", "2500 DEs"));
  EXPECT_FALSE(same_words("2500 2500", "2500"));
  EXPECT_FALSE(same_words("2500", "2500 2500"));
  EXPECT_FALSE(same_words("glass", "pvb"));
  EXPECT_FALSE(same_words("0", "glass"));
  EXPECT_FALSE(same_words("glass", "0"));
  // names are no numbers, and not equal because they begin with one
  EXPECT_FALSE(same_words("1a", "1b"));
  EXPECT_FALSE(same_words("nan", "NAN"));
}
