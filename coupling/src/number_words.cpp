#include "number_words.h"

#include <cmath>
#include <cstdio>
#include <cstdlib>

namespace defe {

std::string written(double number)
{
  char text[32];
  std::snprintf(text, sizeof(text), "%.17g", number);
  for (int digits = 1; digits < 17; ++digits) {
    char shorter[32];
    std::snprintf(shorter, sizeof(shorter), "%.*g", digits, number);
    if (std::strtod(shorter, nullptr) == number) return shorter;
  }
  return text;
}

double positive_number(const std::string &key, const std::string &word, std::string &complaint)
{
  char *end = nullptr;
  const double number = std::strtod(word.c_str(), &end);
  if (end == word.c_str() || *end != '\0' || !std::isfinite(number) || !(number > 0.0))
    complaint = key + " must be a number > 0, not " + (word.empty() ? "nothing" : word);
  return number;
}

}    // namespace defe
