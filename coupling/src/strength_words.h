#ifndef DEFE_COUPLING_STRENGTH_WORDS_H
#define DEFE_COUPLING_STRENGTH_WORDS_H

#include "criterion_words.h"

namespace defe {

/// Next number, the shape of a distribution: beyond these limits strengths could not be told from 0 or infinity.
inline double shape_of(fe::LawWords &words, std::string &complaint)
{
  const double shape = words.number("shape");
  if (!(shape >= 0.5 && shape <= 100.0))
    complaint = "shape must be 0.5 to 100, not " + words.last();
  return shape;
}

}    // namespace defe

#endif
