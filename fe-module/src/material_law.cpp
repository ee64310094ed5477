#include "defe/fe/material_law.h"

#include <algorithm>
#include <cerrno>
#include <cmath>
#include <cstdlib>

namespace defe::fe {

// one line per law, here and in the table below
extern const MaterialLawEntry elastic_law;         // law_elastic.cpp
extern const MaterialLawEntry mooney_law;          // law_mooney.cpp
extern const MaterialLawEntry prony_law;           // law_prony.cpp
extern const MaterialLawEntry plastic_law;         // law_plastic.cpp
extern const MaterialLawEntry johnson_cook_law;    // law_plastic.cpp
extern const MaterialLawEntry rigid_law;           // law_rigid.cpp

const std::vector<const MaterialLawEntry *> &material_laws()
{
  static const std::vector<const MaterialLawEntry *> laws = {
      &elastic_law, &mooney_law, &prony_law, &plastic_law, &johnson_cook_law, &rigid_law};
  return laws;
}

MaterialLaw::~MaterialLaw() = default;

const char *MaterialLaw::elements() const
{
  return "";
}

bool MaterialLaw::has_shape_kernel(const HexCoords &) const
{
  return false;
}

std::unique_ptr<HexKernel> MaterialLaw::make_shape_kernel(const HexCoords &) const
{
  return nullptr;
}

const std::string *LawWords::word(const char *name)
{
  if (!text.empty()) return nullptr;
  if (next >= static_cast<int>(words.size())) {
    text = std::string(name) + " is missing: use " + usage;
    return nullptr;
  }
  return &words[next++];
}

double LawWords::number(const char *name)
{
  const std::string *w = word(name);
  if (!w) return 0.0;
  char *end = nullptr;
  const double value = std::strtod(w->c_str(), &end);
  if (end == w->c_str() || *end != '\0' || !std::isfinite(value)) {
    text = std::string(name) + " must be a number, not " + *w + ": use " + usage;
    return 0.0;
  }
  return value;
}

int LawWords::count(const char *name, int lowest, int highest)
{
  const std::string *w = word(name);
  if (!w) return 0;
  char *end = nullptr;
  errno = 0;
  const long value = std::strtol(w->c_str(), &end, 10);
  if (errno || end == w->c_str() || *end != '\0' || value < lowest || value > highest) {
    text = std::string(name) + " must be an integer from " + std::to_string(lowest) + " to " +
        std::to_string(highest) + ", not " + *w + ": use " + usage;
    return 0;
  }
  return static_cast<int>(value);
}

int LawWords::optional(std::initializer_list<const char *> choices)
{
  if (!text.empty() || next >= static_cast<int>(words.size())) return -1;
  const auto found = std::find(choices.begin(), choices.end(), words[next]);
  if (found == choices.end()) return -1;
  ++next;
  return static_cast<int>(found - choices.begin());
}

namespace {

  // Elements of earlier versions were plain and had no word for it: their restart files know by that what they hold.
  std::string describe(const std::vector<std::string> &words, int used, const MaterialLaw &law)
  {
    const std::string elements = law.elements();
    std::string text;
    for (int k = 0; k < used; ++k)
      if (k == 0 || (words[k] != "enhanced" && words[k] != "plain"))
        text += (k ? " " : "") + words[k];
    return elements == "enhanced" ? text + " " + elements : text;
  }

}    // namespace

ParsedMaterial parse_material(const std::vector<std::string> &words)
{
  ParsedMaterial parsed;
  for (const MaterialLawEntry *entry : material_laws()) {
    if (words.empty() || words[0] != entry->name) continue;
    LawWords numbers(words, entry->usage);
    std::string complaint;
    auto law = entry->make(numbers, complaint);
    parsed.used = numbers.used();
    parsed.complaint = numbers.complaint().empty() ? complaint : numbers.complaint();
    if (!parsed.complaint.empty()) return parsed;
    parsed.description = describe(words, parsed.used, *law);
    parsed.law = std::move(law);
    return parsed;
  }

  parsed.complaint = words.empty() ? "Material law is missing: use "
                                   : "Unknown material law " + words[0] + ": use ";
  const auto &laws = material_laws();
  for (size_t i = 0; i < laws.size(); ++i)
    parsed.complaint += std::string(i == 0                    ? ""
                                        : i + 1 < laws.size() ? ", "
                                                              : " or ") +
        laws[i]->name;
  return parsed;
}

}    // namespace defe::fe
