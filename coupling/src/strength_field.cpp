#include "defe/coupling/strength_field.h"

#include "number_words.h"

#include "defe/coupling/conversion.h"

#include <algorithm>
#include <cmath>

namespace defe {

// one line per distribution, here and in the table below
extern const StrengthLawEntry weibull_strength;      // strength_weibull.cpp
extern const StrengthLawEntry threshold_strength;    // strength_threshold.cpp
extern const StrengthLawEntry truncated_strength;    // strength_truncated.cpp
extern const StrengthLawEntry constant_strength;     // strength_constant.cpp

const std::vector<const StrengthLawEntry *> &strength_laws()
{
  static const std::vector<const StrengthLawEntry *> all = {
      &weibull_strength, &threshold_strength, &truncated_strength, &constant_strength};
  return all;
}

StrengthLaw::~StrengthLaw() = default;

// --- draws ------------------------------------------------------------------

namespace {

  /// splitmix64 (Steele, Lea, Flood: OOPSLA 2014): every bit of the result depends on all bits.
  std::uint64_t mixed(std::uint64_t h)
  {
    h += 0x9e3779b97f4a7c15ull;
    h = (h ^ (h >> 30)) * 0xbf58476d1ce4e5b9ull;
    h = (h ^ (h >> 27)) * 0x94d049bb133111ebull;
    return h ^ (h >> 31);
  }

  /// In (0, 1), never an end of it.
  double uniform(std::uint64_t hash)
  {
    return (static_cast<double>(hash >> 12) + 0.5) * 0x1p-52;
  }

}    // namespace

double Flaws::draw(std::int64_t element, int place, double size) const
{
  if (!(size > 0.0)) return HUGE_VAL;
  if (!law->random()) return law->stress(1.0);
  std::uint64_t h = mixed(static_cast<std::uint64_t>(seed));
  for (char c : surface) h = mixed(h ^ static_cast<unsigned char>(c));
  h = mixed(h ^ static_cast<std::uint64_t>(element));
  h = mixed(h ^ static_cast<std::uint64_t>(place));
  return law->stress(-std::log(uniform(h)) * (reference / size));
}

std::vector<double> StrengthField::draw(std::int64_t element, const std::vector<PlaceSize> &sizes,
                                        const std::vector<unsigned> &faces) const
{
  std::vector<double> least(sizes.size(), HUGE_VAL);
  for (std::size_t k = 0; k < flaws.size(); ++k)
    for (std::size_t place = 0; place < sizes.size(); ++place) {
      double size = flaws[k].surface.empty() ? sizes[place].volume : 0.0;
      if (!flaws[k].surface.empty())
        for (int f = 0; f < 6; ++f)
          if (faces[k] >> f & 1u) size += sizes[place].area[f];
      least[place] = std::min(least[place], flaws[k].draw(element, static_cast<int>(place), size));
    }
  return least;
}

std::vector<PlaceSize> place_sizes(const fe::HexCoords &X, ElementSplit split)
{
  std::vector<PlaceSize> sizes;
  for (const NewDE &de : convert_hex(X, X, fe::HexCoords::Zero(), 1.0, split)) {
    PlaceSize one{de.volume, {}};
    for (int s = 0; s < 6; ++s) one.area[s] = split.outer(de.place, s) ? de.area[s] : 0.0;
    sizes.push_back(one);
  }
  return sizes;
}

// --- words ------------------------------------------------------------------

namespace {

  std::string names_of_laws()
  {
    std::string names;
    const auto &all = strength_laws();
    for (std::size_t i = 0; i < all.size(); ++i)
      names += std::string(i == 0 ? "" : i + 1 < all.size() ? ", " : " or ") + all[i]->name;
    return names;
  }

  struct Given {
    bool area = false, volume = false, seed = false, surface = false;
  };

  /// Keywords behind the numbers; from `parsed.used` on.
  Given read_rest(const std::vector<std::string> &words, ParsedFlaws &parsed)
  {
    Given given;
    Flaws &f = parsed.flaws;
    while (parsed.complaint.empty() && parsed.used < static_cast<int>(words.size())) {
      const std::string key = words[parsed.used];
      bool *const known = key == "area" ? &given.area
          : key == "volume"             ? &given.volume
          : key == "seed"               ? &given.seed
          : key == "surface"            ? &given.surface
                                        : nullptr;
      if (!known) break;
      const bool there = parsed.used + 1 < static_cast<int>(words.size());
      const std::string value = there ? words[parsed.used + 1] : "";
      if (*known) parsed.complaint = key + " is given twice";
      *known = true;
      if (key == "surface") {
        f.surface = value;
        if (!there) parsed.complaint = "surface needs the name of a group of nodes";
      } else if (key == "seed") {
        const double number = positive_number("seed", value, parsed.complaint);
        f.seed = number < 1e15 ? static_cast<std::int64_t>(number) : 0;
        if (parsed.complaint.empty() && static_cast<double>(f.seed) != number)
          parsed.complaint = "seed must be a whole number below 1e15, not " + value;
      } else
        f.reference = positive_number(key, value, parsed.complaint);
      parsed.used += 2;
    }
    return given;
  }

  std::string complaint_of(const Flaws &f, const Given &given)
  {
    if (!f.law->random()) {
      if (given.area || given.volume || given.seed)
        return std::string(f.name) +
            " is the same everywhere and for any size: leave out area, volume and seed";
      return "";
    }
    if (given.surface && (!given.area || given.volume))
      return "flaws of surface " + f.surface +
          " need the area that the scale belongs to: area A0, and no volume";
    if (!given.surface && (!given.volume || given.area))
      return "flaws of the inside need the volume that the scale belongs to: volume V0; those of a "
             "surface its name and an area: surface GROUP area A0";
    if (!given.seed) return "give the seed of the random numbers: seed N";
    return "";
  }

}    // namespace

std::string Flaws::words() const
{
  std::string text = name;
  for (double number : law->numbers()) text += " " + written(number);
  if (law->random())
    text += (surface.empty() ? " volume " : " area ") + written(reference) + " seed " +
        std::to_string(seed);
  return surface.empty() ? text : text + " surface " + surface;
}

ParsedFlaws parse_flaws(const std::vector<std::string> &words)
{
  ParsedFlaws parsed;
  const StrengthLawEntry *entry = nullptr;
  for (const auto *one : strength_laws())
    if (!words.empty() && words[0] == one->name) entry = one;
  if (!entry) {
    parsed.complaint =
        (words.empty() ? "the distribution is missing" : "unknown distribution " + words[0]) +
        std::string(": use ") + names_of_laws();
    return parsed;
  }
  fe::LawWords numbers(words, entry->usage);
  std::string complaint;
  auto law = entry->make(numbers, complaint);
  parsed.used = numbers.used();
  parsed.complaint = numbers.complaint().empty() ? complaint : numbers.complaint();
  if (!parsed.complaint.empty()) return parsed;
  parsed.flaws.law = std::move(law);
  parsed.flaws.name = entry->name;
  const Given given = read_rest(words, parsed);
  if (parsed.complaint.empty()) parsed.complaint = complaint_of(parsed.flaws, given);
  return parsed;
}

}    // namespace defe
