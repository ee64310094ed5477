#include "defe/coupling/prestress_rule.h"

#include "defe/fe/material_law.h"

#include <cstdio>

namespace defe {

namespace {

  constexpr const char *parabola_usage = "parabola x|y|z LOWER UPPER surface STRESS";
  constexpr const char *variables_usage =
      "variables with six atom-style variables, v_NAME or NULL, for xx yy zz xy xz yz";

  std::string written(double number)
  {
    char text[32];
    std::snprintf(text, sizeof text, "%.15g", number);
    return text;
  }

  std::string read_parabola(const std::vector<std::string> &words, fe::ParabolaStress &p)
  {
    if (words.size() < 6 || words[4] != "surface")
      return std::string("it must be ") + parabola_usage;
    p.axis = words[1] == "x" ? 0 : words[1] == "y" ? 1 : words[1] == "z" ? 2 : -1;
    if (p.axis < 0) return "parabola goes along x, y or z, not " + words[1];
    const std::vector<std::string> list = {words[0], words[2], words[3], words[5]};
    fe::LawWords numbers(list, parabola_usage);
    p.lower = numbers.number("lower face");
    p.upper = numbers.number("upper face");
    p.surface = numbers.number("stress of the surface");
    if (!numbers.complaint().empty()) return numbers.complaint();
    if (!(p.upper > p.lower))
      return "the upper face must be above the lower one, not " + words[2] + " and " + words[3];
    return "";
  }

  std::string read_variables(const std::vector<std::string> &words,
                             std::array<std::string, 6> &variable)
  {
    bool any = false;
    for (int k = 0; k < 6; ++k) {
      const std::string word = k + 1 < static_cast<int>(words.size()) ? words[k + 1] : "";
      if (word == "NULL") continue;
      if (word.size() < 3 || word.compare(0, 2, "v_") != 0)
        return std::string("use ") + variables_usage + (word.empty() ? "" : ", not " + word);
      variable[k] = word.substr(2);
      any = true;
    }
    return any ? "" : "all six variables are NULL: leave the keyword out";
  }

}    // namespace

std::string PrestressRule::words() const
{
  if (kind == PARABOLA)
    return std::string("parabola ") + "xyz"[parabola.axis] + " " + written(parabola.lower) + " " +
        written(parabola.upper) + " surface " + written(parabola.surface);
  std::string text = "variables";
  for (const auto &name : variable) text += name.empty() ? " NULL" : " v_" + name;
  return text;
}

ParsedPrestress parse_prestress(const std::vector<std::string> &words)
{
  ParsedPrestress parsed;
  const std::string kind = words.empty() ? "" : words[0];
  if (kind == "parabola") {
    parsed.rule.kind = PrestressRule::PARABOLA;
    parsed.complaint = read_parabola(words, parsed.rule.parabola);
    parsed.used = 6;
  } else if (kind == "variables") {
    parsed.rule.kind = PrestressRule::VARIABLES;
    parsed.complaint = read_variables(words, parsed.rule.variable);
    parsed.used = 7;
  } else
    parsed.complaint = std::string("use ") + parabola_usage + ", or " + variables_usage +
        (kind.empty() ? "" : ", not " + kind);
  return parsed;
}

}    // namespace defe
