#include "defe/coupling/words.h"

#include <cstdlib>
#include <sstream>

namespace defe {

namespace {

  /// The number that a word is or begins with, and what comes after it.
  std::string split_number(const std::string &word, double &number)
  {
    char *end = nullptr;
    number = std::strtod(word.c_str(), &end);
    return end == word.c_str() ? word : "\n" + std::string(end);
  }

}    // namespace

bool same_words(const std::string &a, const std::string &b)
{
  std::istringstream in_a(a), in_b(b);
  std::string one, other;
  while (true) {
    const bool more = static_cast<bool>(in_a >> one);
    if (more != static_cast<bool>(in_b >> other)) return false;
    if (!more) return true;
    if (one == other) continue;
    double x = 0.0, y = 0.0;
    const std::string rest_a = split_number(one, x), rest_b = split_number(other, y);
    if (rest_a != rest_b || rest_a[0] != '\n' || x != y) return false;
  }
}

}    // namespace defe
