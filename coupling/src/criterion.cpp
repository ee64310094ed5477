#include "defe/coupling/criterion.h"

#include <cstdlib>

namespace defe {

// one line per criterion, here and in the table below
extern const CriterionEntry principal_criterion;    // criterion_principal.cpp
extern const CriterionEntry strain_criterion;       // criterion_strain.cpp
extern const CriterionEntry mises_criterion;        // criterion_mises.cpp
extern const CriterionEntry mohr_criterion;         // criterion_mohr.cpp

const std::vector<const CriterionEntry *> &conversion_criteria()
{
  static const std::vector<const CriterionEntry *> all = {&principal_criterion, &strain_criterion,
                                                          &mises_criterion, &mohr_criterion};
  return all;
}

ConversionCriterion::~ConversionCriterion() = default;

namespace {

  /// words[0] is its name
  ParsedCriterion parse(const CriterionEntry *entry, const std::vector<std::string> &words,
                        const fe::IsotropicElastic &material)
  {
    ParsedCriterion parsed;
    fe::LawWords numbers(words, entry->usage);
    std::string complaint;
    auto criterion = entry->make(numbers, material, complaint);
    parsed.entry = entry;
    parsed.used = numbers.used();
    parsed.complaint = numbers.complaint().empty() ? complaint : numbers.complaint();
    if (parsed.complaint.empty()) parsed.criterion = std::move(criterion);
    return parsed;
  }

  bool is_number(const std::string &word)
  {
    char *end = nullptr;
    std::strtod(word.c_str(), &end);
    return end != word.c_str() && *end == '\0';
  }

}    // namespace

ParsedCriterion parse_criterion(const std::vector<std::string> &words,
                                const fe::IsotropicElastic &material)
{
  const auto &all = conversion_criteria();
  if (!words.empty() && is_number(words[0])) {
    auto parsed = parse(all.front(), {all.front()->name, words[0]}, material);
    parsed.used--;
    return parsed;
  }
  for (const CriterionEntry *entry : all)
    if (!words.empty() && words[0] == entry->name) return parse(entry, words, material);

  ParsedCriterion parsed;
  parsed.complaint = words.empty()
      ? "the conversion stress is missing: give it, or use "
      : "unknown criterion " + words[0] + ": give the conversion stress, or use ";
  for (size_t i = 0; i < all.size(); ++i)
    parsed.complaint += std::string(i == 0                   ? ""
                                        : i + 1 < all.size() ? ", "
                                                             : " or ") +
        all[i]->name;
  return parsed;
}

}    // namespace defe
