#ifndef DEFE_COUPLING_CRITERION_WORDS_H
#define DEFE_COUPLING_CRITERION_WORDS_H

#include "defe/fe/material_law.h"

#include <string>

namespace defe {

/// Next number of a criterion, which must be > 0: else `complaint` says so in one line.
inline double positive(fe::LawWords &words, const char *what, std::string &complaint)
{
  const double number = words.number(what);
  if (!(number > 0.0)) complaint = std::string(what) + " must be > 0, not " + words.last();
  return number;
}

}    // namespace defe

#endif
