#include "defe/coupling/large_pages.h"

#include <cstdint>
#include <gtest/gtest.h>
#include <numeric>

namespace {

constexpr std::size_t PAGE = defe::large_pages::PAGE;

bool aligned(const void *memory)
{
  return reinterpret_cast<std::uintptr_t>(memory) % PAGE == 0;
}

TEST(LargePages, LargeArraysBeginOnALargePage)
{
  const std::size_t limit = 2 * PAGE / sizeof(double);
  defe::LargeVector<double> above(limit + 1);
  EXPECT_TRUE(aligned(above.data()));
  EXPECT_EQ(above.front(), 0.0);
  EXPECT_EQ(above.back(), 0.0);
}

// from small pages to large ones and on: what is in it stays, and what is given back is what was taken (sanitizers look)
TEST(LargePages, VectorsGrowAndShrinkAcrossTheLimit)
{
  defe::LargeVector<int> v;
  for (int k = 0; k < 3000000; ++k) v.push_back(k);
  long long sum = std::accumulate(v.begin(), v.end(), 0LL);
  EXPECT_EQ(sum, 2999999LL * 3000000 / 2);
  EXPECT_TRUE(aligned(v.data()));
  v.resize(1000);
  v.shrink_to_fit();
  EXPECT_EQ(v.back(), 999);
  defe::LargeVector<int> other(v);
  EXPECT_EQ(other, v);
  other.assign(5000000, 7);
  other.swap(v);
  EXPECT_EQ(v[4999999], 7);
  EXPECT_EQ(other[999], 999);
}

TEST(LargePages, TooMuchIsRefused)
{
  defe::LargePages<double> pages;
  EXPECT_THROW(pages.allocate(static_cast<std::size_t>(-1) / sizeof(double)), std::bad_alloc);
}

}    // namespace
