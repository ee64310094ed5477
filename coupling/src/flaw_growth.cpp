#include "defe/coupling/flaw_growth.h"

#include "criterion_words.h"
#include "number_words.h"

#include "defe/fe/material_law.h"

#include <algorithm>
#include <cmath>

namespace defe {

double FlawGrowth::B() const
{
  return 2.0 * K_Ic * K_Ic / ((n - 2.0) * v_0 * Y * Y * M_PI);
}

double FlawGrowth::weakened(double strength, double tension, double dt) const
{
  if (!(tension > 0.0) || !(tension < strength) || !std::isfinite(strength)) return strength;
  // share of S^(n-2) that goes
  const double lost = std::pow(tension / strength, n) * strength * strength * dt / B();
  const double left = lost < 1.0 ? strength * std::exp(std::log1p(-lost) / (n - 2.0))
                                 : 0.5 * tension;
  return std::max(left, 0.5 * tension);
}

double FlawGrowth::least_share() const
{
  return std::pow(1e-12, 1.0 / n);
}

double FlawGrowth::inert_rate(double strength) const
{
  constexpr double share = 0.99;
  return std::pow(share, n + 1.0) * strength * strength * strength /
      ((n + 1.0) * B() * (1.0 - std::pow(share, n - 2.0)));
}

std::string FlawGrowth::words() const
{
  return "rate " + written(v_0) + " " + written(K_Ic) + " exponent " + written(n) + " geometry " +
      written(Y);
}

ParsedGrowth parse_growth(const std::vector<std::string> &words)
{
  ParsedGrowth parsed;
  FlawGrowth &g = parsed.growth;
  fe::LawWords numbers(words, "rate v0 KIc");
  std::string complaint;
  g.v_0 = positive(numbers, "v0", complaint);
  g.K_Ic = positive(numbers, "KIc", complaint);
  parsed.used = numbers.used();
  parsed.complaint = numbers.complaint().empty() ? complaint : numbers.complaint();
  bool given[2] = {false, false};
  while (parsed.complaint.empty() && parsed.used < static_cast<int>(words.size())) {
    const std::string key = words[parsed.used];
    const bool exponent = key == "exponent";
    if (!exponent && key != "geometry") break;
    const bool there = parsed.used + 1 < static_cast<int>(words.size());
    bool &twice = given[exponent ? 0 : 1];
    (exponent ? g.n : g.Y) =
        positive_number(key, there ? words[parsed.used + 1] : "", parsed.complaint);
    if (twice) parsed.complaint = key + " is given twice";
    twice = true;
    parsed.used += 2;
  }
  if (parsed.complaint.empty() && !(g.n >= 5.0 && g.n <= 200.0))
    parsed.complaint = "exponent must be 5 to 200, not " + written(g.n);
  return parsed;
}

}    // namespace defe
