#ifndef DEFE_COUPLING_NUMBER_WORDS_H
#define DEFE_COUPLING_NUMBER_WORDS_H

#include <string>

namespace defe {

/// The shortest words that are the same number.
std::string written(double number);

/// The value of a word, > 0; else the complaint is set.
double positive_number(const std::string &key, const std::string &word, std::string &complaint);

}    // namespace defe

#endif
