#ifndef DEFE_COUPLING_PRESTRESS_RULE_H
#define DEFE_COUPLING_PRESTRESS_RULE_H

/// \file
/// How a script says which stress a body has before any load (fe/prestress.h).

#include "defe/fe/prestress.h"

#include <array>
#include <string>
#include <vector>

namespace defe {

struct PrestressRule {
  enum Kind { NONE, PARABOLA, VARIABLES } kind = NONE;
  fe::ParabolaStress parabola{};
  /// Names of atom-style variables for xx yy zz xy xz yz; empty: 0.
  std::array<std::string, 6> variable;

  bool given() const { return kind != NONE; }
  /// As in the script, numbers with all their digits.
  std::string words() const;
};

struct ParsedPrestress {
  PrestressRule rule;
  std::string complaint;    ///< one line, if it is not usable
  int used = 0;             ///< number of words that belong to it
};

/// words: what follows the name of the part, and whatever else is on the line.
///
///     parabola x|y|z LOWER UPPER surface S
///     variables v_XX v_YY v_ZZ v_XY v_XZ v_YZ       NULL in place of one: 0
ParsedPrestress parse_prestress(const std::vector<std::string> &words);

/// Of small strain: far beyond what any brittle material bears, and what elements were made for.
constexpr double largest_prestrain = 0.05;

}    // namespace defe

#endif
