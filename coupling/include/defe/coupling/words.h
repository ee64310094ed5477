#ifndef DEFE_COUPLING_WORDS_H
#define DEFE_COUPLING_WORDS_H

/// \file
/// Words of input scripts.

#include <string>

namespace defe {

/// The same words, where numbers are compared as numbers: 7.409e10 is 74.09e9. What stands right behind or
/// before a word (a comma, a colon) belongs to it.
bool same_words(const std::string &a, const std::string &b);

}    // namespace defe

#endif
