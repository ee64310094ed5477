/* ----------------------------------------------------------------------
   DEFE: adaptive finite elements to bonded discrete elements for LAMMPS
   https://www.lammps.org/
   This software is distributed under the GNU General Public License.
------------------------------------------------------------------------- */

#ifndef LMP_DEFE_STYLE_NAMES_H
#define LMP_DEFE_STYLE_NAMES_H

#include "fix.h"
#include "utils.h"

#include <algorithm>
#include <iterator>
#include <string>

namespace LAMMPS_NS {

/// Whether the name of a style matches one of these patterns of utils::strmatch().
template <size_t N> bool one_of(const char *const (&patterns)[N], const std::string &style)
{
  return std::any_of(std::begin(patterns), std::end(patterns), [&style](const char *pattern) {
    return utils::strmatch(style, pattern);
  });
}

/// Without the suffix of an accelerator package.
inline std::string plain_style(const Fix *ifix)
{
  std::string style = ifix->style;
  for (const char *suffix : {"/omp", "/kk", "/intel", "/opt", "/gpu"}) {
    const std::string s = suffix;
    if (style.size() > s.size() && style.compare(style.size() - s.size(), s.size(), s) == 0)
      style.resize(style.size() - s.size());
  }
  return style;
}

}    // namespace LAMMPS_NS

#endif
