// Sums that do not depend on the order of the additions.

#include "defe/exact_sum.h"

#include "test_fe_common.h"

#include "defe/fe/kernel.h"
#include "defe/fe/material_law.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>
#include <random>

using namespace defe;
using namespace defe::fe;

namespace {

std::vector<double> contributions(double scale, int n, unsigned seed)
{
  std::mt19937 random(seed);
  std::uniform_real_distribution<double> uniform(-1.0, 1.0);
  std::vector<double> v(n);
  for (double &a : v) a = scale * std::pow(uniform(random), 5);    // many sizes
  return v;
}

}    // namespace

TEST(ExactSum, AnyOrderGivesTheSameBits)
{
  for (double scale : {1e-9, 3.0, 2.96e5, 1e30}) {
    const SumGrid grid = sum_grid(scale);
    std::vector<double> plain = contributions(2.0 * scale, 32, 1), rounded = plain;
    for (double &v : rounded) {
      v = grid.round(v);
      EXPECT_FALSE(grid.beyond(v));
    }
    std::vector<int> order(plain.size());
    std::iota(order.begin(), order.end(), 0);
    std::mt19937 random(2);
    const double sum = std::accumulate(rounded.begin(), rounded.end(), 0.0);
    const double first = std::accumulate(plain.begin(), plain.end(), 0.0);
    bool plain_differs = false;
    for (int k = 0; k < 1000; k++) {
      std::shuffle(order.begin(), order.end(), random);
      double a = 0.0, b = 0.0, c = 0.0;    // in two parts, as ranks do
      for (size_t i = 0; i < order.size(); i++) {
        (i % 3 ? a : b) += rounded[order[i]];
        c += plain[order[i]];
      }
      ASSERT_EQ(a + b, sum);
      plain_differs = plain_differs || c != first;
    }
    EXPECT_TRUE(plain_differs) << "a poor example";
  }
}

TEST(ExactSum, SixteenAtTheLimitAreExact)
{
  const SumGrid grid = sum_grid(1.0);
  const double q = grid.quantum();
  EXPECT_EQ(std::ldexp(1.0, -47), q);
  EXPECT_FALSE(grid.beyond(grid.limit));
  EXPECT_TRUE(grid.beyond(std::nextafter(grid.limit, HUGE_VAL)));
  EXPECT_TRUE(grid.beyond(-2.0 * grid.limit));
  EXPECT_FALSE(grid.beyond(std::numeric_limits<double>::quiet_NaN()));
  EXPECT_EQ(grid.round(grid.limit - q), grid.limit - q);
  double sum = 0.0;
  for (int k = 0; k < 16; k++) {
    EXPECT_TRUE(adds_exactly(sum, grid.limit - q));
    sum += grid.limit - q;
  }
  EXPECT_EQ(sum, 16.0 * grid.limit - 16.0 * q);
}

TEST(ExactSum, RoundsToTheNearestQuantum)
{
  const SumGrid grid = sum_grid(5.0);
  const double q = grid.quantum();
  for (double v : contributions(10.0, 1000, 3)) {
    const double r = grid.round(v);
    EXPECT_LE(std::abs(r - v), 0.5 * q);
    EXPECT_EQ(std::remainder(r, q), 0.0);
    EXPECT_EQ(grid.round(-v), -r);
    EXPECT_EQ(grid.round(r), r);
  }
}

TEST(ExactSum, ShortMassesOfANodeAddInAnyOrder)
{
  std::mt19937 random(4);
  std::uniform_real_distribution<double> power(0.0, 4.0);
  for (int k = 0; k < 1000; k++) {
    std::vector<double> m(8);
    for (double &v : m) {
      const double mass = 2e-5 * std::pow(10.0, power(random));
      v = 0.125 * short_mass(mass);
      EXPECT_NEAR(8.0 * v / mass, 1.0, std::ldexp(1.0, -36));
    }
    double sum = 0.0;
    for (double v : m) {
      ASSERT_TRUE(adds_exactly(sum, v));
      sum += v;
    }
    std::shuffle(m.begin(), m.end(), random);
    for (double v : m) sum -= v;
    ASSERT_EQ(sum, 0.0);
  }
  EXPECT_FALSE(adds_exactly(1.0, 1e-17));
  EXPECT_FALSE(adds_exactly(short_mass(1.1), short_mass(1.1e-9)));
}

// Kernels: the forces of elements that share nodes have the same bits in any order of the elements,
// cut into calls anywhere, and are those without a grid to half a quantum each.
TEST(ExactSum, ForcesOfAllKernels)
{
  HexCoords X;
  const double h = 2e-3;
  for (int a = 0; a < 8; ++a)
    for (int k = 0; k < 3; ++k) X(k, a) = hex_sign[a][k] > 0 ? h : 0.0;
  X.row(0).array() += 0.1;
  const double E = 74.09e9;
  const SumGrid grid = sum_grid(1.1 * E * h * h);
  for (const char *words : {"elastic 74.09e9 0.2 2500", "mooney 1e9 1e8 7e9 2500",
                            "prony 20e9 1100 0.69e6 1 0.32931e9 12.6"}) {
    std::vector<std::string> list;
    std::istringstream in(words);
    for (std::string w; in >> w;) list.push_back(w);
    const auto law = parse_material(list).law;
    std::vector<std::unique_ptr<HexKernel>> kernels;
    kernels.push_back(law->make_kernel());
    if (law->has_shape_kernel(X)) kernels.push_back(law->make_shape_kernel(X));
    for (const auto &kernel : kernels) {
      SCOPED_TRACE(words);
      // 21 elements in a row share faces
      constexpr int n = 21;
      std::vector<double> x, X0;
      std::mt19937 random(5);
      std::uniform_real_distribution<double> noise(-2e-3 * h, 2e-3 * h);
      for (int i = 0; i <= n; i++)
        for (int q = 0; q < 4; q++) {
          const double at[3] = {0.1 + h * i, q & 1 ? h : 0.0, q & 2 ? h : 0.0};
          for (double v : at) {
            X0.push_back(v);
            x.push_back(v + noise(random));
          }
        }
      std::vector<std::array<int, 8>> hex(n);
      for (int e = 0; e < n; e++)
        for (int a = 0; a < 8; a++)
          hex[e][a] =
              4 * (e + (hex_sign[a][0] > 0)) + (hex_sign[a][1] > 0) + 2 * (hex_sign[a][2] > 0);
      const auto forces = [&](const SumGrid *on, int cut) {
        std::vector<double> f(x.size(), 0.0), history(kernel->history_size() * n + 1, 0.0);
        std::vector<double *> rows;
        for (int e = 0; e < n; e++) rows.push_back(history.data() + e * kernel->history_size());
        HexKernel::Output out;
        int beyond = -1;
        out.grid = on;
        out.beyond = &beyond;
        for (int first = 0; first < n; first += cut) {
          out.history = rows.data() + first;
          kernel->add_forces(std::min(cut, n - first),
                             reinterpret_cast<const int(*)[8]>(&hex[first]), x.data(), X0.data(),
                             f.data(), out);
        }
        EXPECT_EQ(beyond, -1);
        return f;
      };
      const auto plain = forces(nullptr, n), exact = forces(&grid, n);
      for (size_t k = 0; k < plain.size(); k++)
        ASSERT_NEAR(exact[k], plain[k], 1.1 * grid.quantum() + 1e-15 * std::abs(plain[k]));
      for (int cut : {1, 3, 8, 13}) {
        std::shuffle(hex.begin(), hex.end(), random);
        ASSERT_EQ(forces(&grid, cut), exact) << cut;
      }
      // what is rounded off is less than what the last digits of positions make at 0.1 m
      auto moved = x;
      for (size_t k = 0; k < moved.size(); k++)
        moved[k] = std::nextafter(moved[k], k % 5 < 2 ? HUGE_VAL : -HUGE_VAL);
      std::swap(x, moved);
      const auto other = forces(nullptr, n);
      std::swap(x, moved);
      double change = 0.0;
      for (size_t k = 0; k < plain.size(); k++)
        change = std::max(change, std::abs(other[k] - plain[k]));
      if (law->linear()) { EXPECT_LT(0.5 * grid.quantum(), change); }
    }
  }
}

TEST(ExactSum, AForceBeyondTheGridIsNamed)
{
  const auto law = parse_material({"elastic", "74.09e9", "0.2", "2500"}).law;
  const auto kernel = law->make_kernel();
  std::vector<double> X, x;
  for (int e = 0; e < 3; e++)
    for (int a = 0; a < 8; ++a)
      for (int k = 0; k < 3; ++k) {
        X.push_back(hex_sign[a][k] > 0 ? 1.0 : 0.0);
        x.push_back(X.back() * (e == 1 ? 5.0 : 1.001));
      }
  const int nodes[3][8] = {
      {0, 1, 2, 3, 4, 5, 6, 7}, {8, 9, 10, 11, 12, 13, 14, 15}, {16, 17, 18, 19, 20, 21, 22, 23}};
  std::vector<double> f(x.size(), 0.0);
  const SumGrid grid = sum_grid(74.09e9);
  HexKernel::Output out;
  int beyond = -1;
  out.grid = &grid;
  out.beyond = &beyond;
  kernel->add_forces(3, nodes, x.data(), X.data(), f.data(), out);
  EXPECT_EQ(beyond, 1);
}

// Elements that differ by rounding get kernels of the same bits.
TEST(ExactSum, RoundedShapes)
{
  const double h = 2e-3;
  std::vector<HexCoords> seen;
  for (int i = 0; i < 1000; i++) {
    HexCoords X;
    for (int a = 0; a < 8; ++a) {
      X(0, a) = -0.1 + (hex_sign[a][0] > 0 ? i + 1 : i) * 0.2 / 1000;
      X(1, a) = (hex_sign[a][1] > 0 ? i % 7 + 1 : i % 7) * h;
      X(2, a) = (hex_sign[a][2] > 0 ? i % 5 + 1 : i % 5) * 0.01 / 5;
    }
    const HexCoords shape = rounded_shape(X);
    EXPECT_TRUE(congruent(shape, X, 1e-12));
    if (std::find(seen.begin(), seen.end(), shape) == seen.end()) seen.push_back(shape);
  }
  EXPECT_LE(seen.size(), 4u);    // one for each order of size of the place
}
