// Strength that scatters: distributions against their closed forms, pieces against the body that they make up, and how
// distributions are given.

#include "defe/coupling/strength_field.h"
#include "defe/fe/hex8.h"

#include <gmock/gmock.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <set>

using namespace defe;
using testing::HasSubstr;

namespace {

using Words = std::vector<std::string>;

Flaws make(const Words &words)
{
  const auto parsed = parse_flaws(words);
  EXPECT_EQ(parsed.complaint, "");
  EXPECT_EQ(parsed.used, static_cast<int>(words.size()));
  return parsed.flaws;
}

// of area or volume 2
const Words weibull = {"weibull", "7", "70e6", "volume", "2", "seed", "12345"};
const Words threshold = {"threshold", "1.5", "30e6", "40e6", "volume", "2", "seed", "12345"};
const Words truncated = {"truncated", "5", "70e6", "60e6", "volume", "2", "seed", "12345"};

/// Share of pieces of this size that break below a stress.
double weibull_below(double stress, double size)
{
  return 1.0 - std::exp(-size / 2.0 * std::pow(stress / 70e6, 7.0));
}

double threshold_below(double stress, double size)
{
  return stress < 40e6 ? 0.0 : 1.0 - std::exp(-size / 2.0 * std::pow((stress - 40e6) / 30e6, 1.5));
}

double truncated_below(double stress, double size)
{
  const double H = std::pow(stress / 70e6, 5.0) - std::pow(60.0 / 70.0, 5.0);
  return stress < 60e6 ? 0.0 : 1.0 - std::exp(-size / 2.0 * H);
}

/// Largest distance between a sample and a distribution, times the root of its size. Of a sample from the distribution
/// itself it is above 1.63 once in a hundred times (Kolmogorov's limit).
constexpr double kolmogorov_1_percent = 1.63;

double kolmogorov(std::vector<double> sample, const std::function<double(double)> &below)
{
  std::sort(sample.begin(), sample.end());
  const double n = static_cast<double>(sample.size());
  double most = 0.0;
  for (std::size_t k = 0; k < sample.size(); k++) {
    const double F = below(sample[k]);
    most = std::max({most, F - k / n, (k + 1) / n - F});
  }
  return most * std::sqrt(n);
}

std::vector<double> draws(const Flaws &flaws, int n, double size)
{
  std::vector<double> all;
  for (int k = 0; k < n; k++) all.push_back(flaws.draw(1 + k / 8, k % 8, size));
  return all;
}

/// A box of this size at the origin, its edges along the axes.
fe::HexCoords box(double a, double b, double c)
{
  fe::HexCoords X;
  for (int k = 0; k < 8; k++)
    X.col(k) = 0.5 * Vec3(a * fe::hex_sign[k][0], b * fe::hex_sign[k][1], c * fe::hex_sign[k][2]);
  return X;
}

}    // namespace

TEST(StrengthField, Quantiles)
{
  EXPECT_DOUBLE_EQ(make(weibull).law->stress(1.0), 70e6);
  EXPECT_DOUBLE_EQ(make(weibull).law->stress(128.0), 140e6);
  EXPECT_DOUBLE_EQ(make(threshold).law->stress(8.0), 160e6);
  EXPECT_NEAR(make(threshold).law->stress(1e-12), 40e6, 10.0);
  EXPECT_NEAR(make(truncated).law->stress(1e-12), 60e6, 10.0);
  // far above the truncation it does not matter
  EXPECT_NEAR(make(truncated).law->stress(1e9), 70e6 * std::pow(1e9, 0.2), 10.0);
  EXPECT_EQ(make({"constant", "2e8"}).draw(5, 3, 1e-9), 2e8);
}

TEST(StrengthField, DrawsHaveTheDistributionForTheirSize)
{
  for (double size : {0.001, 2.0, 50.0}) {
    SCOPED_TRACE(size);
    EXPECT_LT(kolmogorov(draws(make(weibull), 4000, size),
                         [&](double s) {
                           return weibull_below(s, size);
                         }),
              kolmogorov_1_percent);
    EXPECT_LT(kolmogorov(draws(make(threshold), 4000, size),
                         [&](double s) {
                           return threshold_below(s, size);
                         }),
              kolmogorov_1_percent);
    EXPECT_LT(kolmogorov(draws(make(truncated), 4000, size),
                         [&](double s) {
                           return truncated_below(s, size);
                         }),
              kolmogorov_1_percent);
  }
  // it would be seen: sizes that differ by a fifth
  EXPECT_GT(kolmogorov(draws(make(weibull), 4000, 2.0),
                       [](double s) {
                         return weibull_below(s, 2.4);
                       }),
            2.0 * kolmogorov_1_percent);
}

// Mean and standard deviation by the gamma function.
TEST(StrengthField, MomentsOfWeibull)
{
  const auto all = draws(make(weibull), 20000, 0.02);
  const double scale = 70e6 * std::pow(100.0, 1.0 / 7.0);
  const double mean = scale * std::tgamma(1.0 + 1.0 / 7.0);
  const double deviation = std::sqrt(scale * scale * std::tgamma(1.0 + 2.0 / 7.0) - mean * mean);
  double sum = 0.0, squares = 0.0;
  for (double s : all) sum += s / 20000.0;
  for (double s : all) squares += (s - sum) * (s - sum) / 20000.0;
  EXPECT_NEAR(sum, mean, 3.0 * deviation / std::sqrt(20000.0));
  EXPECT_NEAR(std::sqrt(squares), deviation, 0.03 * deviation);
}

// The weakest of N pieces is as strong as the body.
TEST(StrengthField, PiecesMakeUpTheBody)
{
  constexpr int bodies = 1500;
  for (const auto &[words, below] : {std::pair{weibull, weibull_below},
                                     {threshold, threshold_below},
                                     {truncated, truncated_below}})
    for (int pieces : {3, 100}) {
      SCOPED_TRACE(words[0] + " of " + std::to_string(pieces));
      const Flaws flaws = make(words);
      std::vector<double> least(bodies, HUGE_VAL);
      for (int k = 0; k < bodies * pieces; k++) {
        double &body = least[k / pieces];
        body = std::min(body, flaws.draw(1 + k / 8, k % 8, 5.0 / pieces));
      }
      EXPECT_LT(kolmogorov(least,
                           [of = below](double s) {
                             return of(s, 5.0);
                           }),
                kolmogorov_1_percent);
    }
}

// One element, or 64: flaws of the inside and of the two faces at the ends of z.
TEST(StrengthField, OfABodyWhateverItsElements)
{
  const Words upper = {"weibull", "4", "90e6", "area", "0.5", "seed", "7", "surface", "upper"};
  const StrengthField field{{make(weibull), make(upper)}};
  const auto below = [](double s) {
    const double inside = 6.0 / 2.0 * std::pow(s / 70e6, 7.0);
    const double outside = 4.0 / 0.5 * std::pow(s / 90e6, 4.0);    // two faces of 1 x 2
    return 1.0 - std::exp(-inside - outside);
  };
  constexpr int bodies = 1000;
  std::int64_t id = 0;
  for (int n : {1, 4}) {
    const auto sizes = place_sizes(box(1.0 / n, 2.0 / n, 3.0 / n));
    std::vector<double> least(bodies, HUGE_VAL);
    for (double &body : least)
      for (int e = 0; e < n * n * n; e++) {
        unsigned faces = 0;
        if (e / (n * n) == 0) faces |= 1u << 4;
        if (e / (n * n) == n - 1) faces |= 1u << 5;
        const auto corners = field.draw(++id, sizes, {0u, faces});
        body = std::min(body, *std::min_element(corners.begin(), corners.end()));
      }
    EXPECT_LT(kolmogorov(least, below), kolmogorov_1_percent) << n;
  }
}

TEST(StrengthField, CornersShareVolumeAndFaces)
{
  fe::HexCoords X = box(1.0, 2.0, 3.0);
  X.col(6) += Vec3(0.2, 0.3, 0.4);
  const auto sizes = place_sizes(X);
  double volume = 0.0, whole[6] = {};
  for (int k = 0; k < 8; k++) {
    volume += sizes[k].volume;
    int faces = 0;
    for (int f = 0; f < 6; f++) {
      whole[f] += sizes[k].area[f];
      faces += sizes[k].area[f] > 0.0;
    }
    EXPECT_EQ(faces, 3);
  }
  EXPECT_NEAR(volume, fe::volume(X), 1e-12);
  EXPECT_NEAR(whole[0], 6.0, 1e-12);    // plane faces
  EXPECT_NEAR(whole[4], 2.0, 1e-12);

  const StrengthField field{
      {make({"constant", "2e8"}), make({"constant", "5e7", "surface", "left"})}};
  const auto strength = field.draw(1, place_sizes(box(1.0, 1.0, 1.0)), {0u, 1u});
  for (int k = 0; k < 8; k++)
    EXPECT_EQ(strength[k], fe::hex_sign[k][0] < 0 ? 5e7 : 2e8) << "the least of the draws";
}

// Neighbouring IDs, corners, seeds and surfaces have nothing to do with each other: u = exp(-H) of shape 1.
TEST(StrengthField, DrawsAreIndependent)
{
  const auto u = [](const Flaws &f, std::int64_t element, int corner) {
    return std::exp(-f.draw(element, corner, 1.0));
  };
  const auto flaws = [](const std::string &seed, const std::string &surface) {
    return make({"weibull", "1", "1", "area", "1", "seed", seed, "surface", surface});
  };
  const Flaws first = flaws("1", "a"), seed = flaws("2", "a"), surface = flaws("1", "b");
  constexpr int n = 20000;
  double mean = 0.0, with[4] = {};
  for (int k = 0; k < n; k++) {
    const double a = u(first, k, 0) - 0.5;
    mean += a / n;
    with[0] += a * (u(first, k + 1, 0) - 0.5) / n;
    with[1] += a * (u(first, k, 1) - 0.5) / n;
    with[2] += a * (u(seed, k, 0) - 0.5) / n;
    with[3] += a * (u(surface, k, 0) - 0.5) / n;
  }
  EXPECT_NEAR(mean, 0.0, 3.0 / std::sqrt(12.0 * n));
  for (double c : with) EXPECT_NEAR(12.0 * c, 0.0, 3.0 / std::sqrt(1.0 * n));
  // no two alike, also for large IDs
  std::set<double> all;
  for (std::int64_t k = 0; k < 1000; k++)
    for (int corner = 0; corner < 8; corner++) {
      all.insert(first.draw(k, corner, 1.0));
      all.insert(first.draw(k + (std::int64_t(1) << 40), corner, 1.0));
    }
  EXPECT_EQ(all.size(), 16000u);
}

TEST(StrengthField, NoSizeNoFlaw)
{
  EXPECT_EQ(make(weibull).draw(1, 0, 0.0), HUGE_VAL);
  EXPECT_EQ(make({"constant", "5e7", "surface", "a"}).draw(1, 0, 0.0), HUGE_VAL);
}

TEST(StrengthField, WordsAreReadOrExplained)
{
  EXPECT_EQ(parse_flaws({"constant", "2e8", "convert", "glass"}).used, 2);
  EXPECT_EQ(make({"weibull", "7.0", "70e6", "seed", "5", "area", "1e-2", "surface", "up"}).words(),
            "weibull 7 7e+07 area 0.01 seed 5 surface up");
  EXPECT_EQ(make({"constant", "0.1"}).words(), "constant 0.1");
  for (const auto *entry : strength_laws()) EXPECT_THAT(entry->usage, HasSubstr(entry->name));

  const auto complaint = [](const Words &words) {
    return parse_flaws(words).complaint;
  };
  EXPECT_EQ(complaint({"gauss", "5"}),
            "unknown distribution gauss: use weibull, threshold, truncated or constant");
  EXPECT_THAT(complaint({}), HasSubstr("the distribution is missing"));
  EXPECT_THAT(complaint({"weibull", "7", "volume"}),
              HasSubstr("must be a number, not volume: use weibull shape scale"));
  EXPECT_EQ(complaint({"weibull", "0", "70e6"}), "shape must be 0.5 to 100, not 0");
  EXPECT_EQ(complaint({"weibull", "7", "0"}), "scale must be > 0, not 0");
  EXPECT_EQ(complaint({"threshold", "101", "70e6", "5e6"}), "shape must be 0.5 to 100, not 101");
  EXPECT_THAT(complaint({"truncated", "100", "70e6", "70e10"}), HasSubstr("nothing is left"));
  EXPECT_EQ(complaint({"threshold", "7", "70e6", "-1"}), "threshold must be > 0, not -1");
  EXPECT_THAT(complaint({"weibull", "7", "70e6", "seed", "5"}), HasSubstr("volume V0"));
  EXPECT_THAT(complaint({"weibull", "7", "70e6", "area", "1", "seed", "5"}),
              HasSubstr("surface GROUP area A0"));
  EXPECT_THAT(complaint({"weibull", "7", "70e6", "volume", "1", "seed", "5", "surface", "up"}),
              HasSubstr("flaws of surface up need the area"));
  EXPECT_EQ(complaint({"weibull", "7", "70e6", "volume", "1"}),
            "give the seed of the random numbers: seed N");
  EXPECT_EQ(complaint({"weibull", "7", "70e6", "volume", "0", "seed", "5"}),
            "volume must be a number > 0, not 0");
  EXPECT_EQ(complaint({"weibull", "7", "70e6", "volume", "1", "seed"}),
            "seed must be a number > 0, not nothing");
  EXPECT_EQ(complaint({"weibull", "7", "70e6", "volume", "1", "seed", "1.5"}),
            "seed must be a whole number below 1e15, not 1.5");
  EXPECT_EQ(complaint({"weibull", "7", "70e6", "volume", "1", "volume", "2"}),
            "volume is given twice");
  EXPECT_THAT(complaint({"constant", "2e8", "volume", "1"}), HasSubstr("leave out area, volume"));
}
