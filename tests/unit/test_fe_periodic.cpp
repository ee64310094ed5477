// Elements of meshes that are closed across the border of a periodic box.

#include "test_fe_common.h"

#include "defe/fe/hex8.h"
#include "defe/fe/periodic.h"

#include <gtest/gtest.h>

#include <cmath>

using namespace defe;
using namespace defe::fe;
using namespace defe::fe::test;

namespace {

const Vec3 periods(1.0, 2.0, HUGE_VAL);

/// A brick from `low`, its corners wrapped into the box that begins at 0.
HexCoords brick(const Vec3 &low, const Vec3 &edges, bool wrapped)
{
  HexCoords X;
  for (int a = 0; a < 8; ++a)
    for (int k = 0; k < 3; ++k) {
      X(k, a) = low[k] + (hex_sign[a][k] > 0 ? edges[k] : 0.0);
      if (wrapped && std::isfinite(periods[k]))
        X(k, a) -= periods[k] * std::floor(X(k, a) / periods[k]);
    }
  return X;
}

TEST(JoinAcrossBorder, CornersComeToTheFirst)
{
  const Vec3 edges(0.25, 0.125, 3.0);
  for (const auto &[low, axes] : {std::pair<Vec3, unsigned>{{0.875, 0.5, -1.0}, 1},
                                  {{0.5, 1.9375, -1.0}, 2},
                                  {{0.875, 1.9375, -1.0}, 3},
                                  {{0.75, 1.875, -1.0}, 3}}) {    // corners on the border itself
    HexCoords X = brick(low, edges, true);
    EXPECT_EQ(join_across_border(X, periods), axes);
    EXPECT_EQ(X, brick(low, edges, false));    // all are sums of powers of two
    EXPECT_EQ(check_hex(X).verdict, HexCheck::good);
  }
}

// The same element with the numbers of its corners turned, so that the first one is at the other side of the box.
TEST(JoinAcrossBorder, WhereTheFirstCornerIs)
{
  const HexCoords whole = brick({0.875, 0.5, 0.0}, {0.25, 0.125, 1.0}, false);
  HexCoords X = brick({0.875, 0.5, 0.0}, {0.25, 0.125, 1.0}, true), turned = X, expected = whole;
  const int half_turn[8] = {2, 3, 0, 1, 6, 7, 4, 5};
  for (int a = 0; a < 8; ++a) {
    turned.col(a) = X.col(half_turn[a]);
    expected.col(a) = whole.col(half_turn[a]) - Vec3(1.0, 0.0, 0.0);
  }
  EXPECT_EQ(join_across_border(turned, periods), 1u);
  EXPECT_EQ(turned, expected);
  EXPECT_DOUBLE_EQ(volume(turned), 0.25 * 0.125);
}

TEST(JoinAcrossBorder, OthersStayToTheLastDigit)
{
  Random random(3);
  for (int i = 0; i < 100; ++i) {
    HexCoords X =
        0.3 * random.matrix<HexCoords>(0.5);    // shorter than half of the box, outside it, too
    X.colwise() += random.matrix<Vec3>(5.0);
    const HexCoords before = X;
    EXPECT_EQ(join_across_border(X, periods), 0u);
    EXPECT_EQ(X, before);
  }
}

// Longer than half of the box, and its images as long as a quarter or more: not an element of a closed mesh.
TEST(JoinAcrossBorder, LongElementsStay)
{
  for (const double length : {0.51, 0.6, 0.74}) {
    HexCoords X = brick({0.1, 0.1, 0.0}, {length, 0.1, 0.1}, false);
    const HexCoords before = X;
    EXPECT_EQ(join_across_border(X, periods), 0u);
    EXPECT_EQ(X, before);
  }
}

}    // namespace
