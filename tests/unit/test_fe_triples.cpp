// Vectors of three in registers: the same numbers as one by one, and none but these are touched.

#include "defe/triples.h"

#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <limits>
#include <random>
#include <vector>

#if defined(__linux__)
#include <sys/mman.h>
#include <unistd.h>
#endif

namespace defe {
namespace {

  using simd::FourTriples;
  using simd::Triple;

  std::vector<double> numbers(int n)
  {
    std::mt19937 random(7);
    std::uniform_real_distribution<double> uniform(-1.0, 1.0);
    std::vector<double> list;
    for (int k = 0; k < n; ++k) list.push_back(uniform(random));
    return list;
  }

  TEST(Triples, AreThoseOfTheScalars)
  {
    const auto v = numbers(9);
    const Triple a(&v[0]), b(&v[3]), none;
    const Triple sum = a + b, difference = a - b, square = a.squares(), most = larger(a, b);
    for (int k = 0; k < 3; ++k) {
      EXPECT_EQ(sum[k], v[k] + v[3 + k]);
      EXPECT_EQ(difference[k], v[k] - v[3 + k]);
      EXPECT_EQ(square[k], v[k] * v[k]);
      EXPECT_EQ(most[k], std::max(v[k], v[3 + k]));
      EXPECT_EQ(none[k], 0.0);
    }
  }

  // Of two of which one is no number it is the second one, as of a > b ? a : b.
  TEST(Triples, TheLargerOneBesideNaNIsTheSecond)
  {
    const double none = std::numeric_limits<double>::quiet_NaN();
    const double first[3] = {none, 1.0, 2.0}, second[3] = {5.0, none, 3.0};
    const Triple most = larger(Triple(first), Triple(second));
    EXPECT_EQ(most[0], 5.0);
    EXPECT_TRUE(std::isnan(most[1]));
    EXPECT_EQ(most[2], 3.0);
  }

  TEST(Triples, FourFromAnywhereLieBesideEachOther)
  {
    const auto v = numbers(60);
    const double *a[4] = {&v[31], &v[0], &v[57], &v[12]}, *b[4] = {&v[3], &v[31], &v[3], &v[40]};
    const double scale[4] = {2.0, -0.3, 0.7, 1e-3};
    double x[4], y[4], z[4];
    (FourTriples(a) - FourTriples(b)).store_scaled(scale, x, y, z);
    for (int l = 0; l < 4; ++l) {
      EXPECT_EQ(x[l], scale[l] * (a[l][0] - b[l][0]));
      EXPECT_EQ(y[l], scale[l] * (a[l][1] - b[l][1]));
      EXPECT_EQ(z[l], scale[l] * (a[l][2] - b[l][2]));
    }
  }

  TEST(Triples, FourByFourAreTransposedAndBack)
  {
    const auto v = numbers(40);
    const double *from[4] = {&v[5], &v[0], &v[36], &v[17]};
    double column[4][4], row[4][4];
    double *to[4], *back[4];
    const double *of[4];
    for (int k = 0; k < 4; ++k) {
      to[k] = column[k];
      of[k] = column[k];
      back[k] = row[k];
    }
    simd::transpose_four(from, to);
    simd::transpose_four(of, back);
    for (int l = 0; l < 4; ++l)
      for (int j = 0; j < 4; ++j) {
        EXPECT_EQ(column[j][l], from[l][j]);
        EXPECT_EQ(row[l][j], from[l][j]);
      }
  }

#if defined(__linux__)
  // The last particle of an array may be the last thing that there is on a page, with nothing behind it.
  TEST(Triples, NothingBehindThemIsTouched)
  {
    const auto page = static_cast<std::size_t>(sysconf(_SC_PAGESIZE));
    void *two = mmap(nullptr, 2 * page, PROT_READ | PROT_WRITE, MAP_PRIVATE | MAP_ANONYMOUS, -1, 0);
    ASSERT_NE(two, MAP_FAILED);
    ASSERT_EQ(mprotect(static_cast<char *>(two) + page, page, PROT_NONE), 0);
    double *last = reinterpret_cast<double *>(static_cast<char *>(two) + page) - 3;
    for (int k = 0; k < 3; ++k) last[k] = k + 1.0;
    const Triple one(last);
    EXPECT_EQ(one[0] + one[1] + one[2], 6.0);
    const double *four[4] = {last, last, last, last},
                 *before[4] = {last - 3, last - 3, last - 3, last - 3};
    const double scale[4] = {1.0, 1.0, 1.0, 1.0};
    double x[4], y[4], z[4];
    (FourTriples(four) - FourTriples(before)).store_scaled(scale, x, y, z);
    EXPECT_EQ(z[3], 3.0);
    munmap(two, 2 * page);
  }
#endif

}    // namespace
}    // namespace defe
