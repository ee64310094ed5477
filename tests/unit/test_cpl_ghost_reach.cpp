// What a rank must know around its sub-domain.

#include "defe/coupling/ghost_reach.h"

#include <gtest/gtest.h>

#include <cmath>

using namespace defe;

namespace {

GhostNeeds cube()    // of edge 1
{
  GhostNeeds n;
  n.longest = n.diagonal = std::sqrt(3.0);
  n.facet_diagonal = std::sqrt(2.0);
  n.skin = 0.1;
  return n;
}

}    // namespace

TEST(GhostReach, ElementsAloneNeedTheirDiagonal)
{
  EXPECT_DOUBLE_EQ(ghost_reach(cube()), std::sqrt(3.0));
}

TEST(GhostReach, ContactNeedsWhatIsBesideAFace)
{
  GhostNeeds n = cube();
  n.contact = true;
  EXPECT_DOUBLE_EQ(ghost_reach(n), std::sqrt(3.0) + 0.65 * std::sqrt(2.0) + 0.15);
  n.longest *= 2.0;    // faces grow as elements do
  EXPECT_DOUBLE_EQ(ghost_reach(n), 2.0 * (std::sqrt(3.0) + 0.65 * std::sqrt(2.0)) + 0.15);
  n.largest_ball = 10.0;
  EXPECT_DOUBLE_EQ(ghost_reach(n), 2.0 * std::sqrt(3.0) + 10.0 + 0.15);
}

TEST(GhostReach, TiedElementsNeedEachOther)
{
  GhostNeeds n = cube();
  n.tied = true;
  EXPECT_DOUBLE_EQ(ghost_reach(n), 2.0 * std::sqrt(3.0));
}

TEST(GhostReach, TheLargerNeedCounts)
{
  GhostNeeds n = cube();
  n.des = true;
  EXPECT_DOUBLE_EQ(ghost_reach(n), 1.4 * std::sqrt(3.0));
  n.contact = true;
  n.facet_diagonal = 1e-3;
  EXPECT_DOUBLE_EQ(ghost_reach(n), 1.4 * std::sqrt(3.0));
}
