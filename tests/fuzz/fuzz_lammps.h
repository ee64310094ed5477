#ifndef DEFE_FUZZ_LAMMPS_H
#define DEFE_FUZZ_LAMMPS_H

// One LAMMPS in this process, with DEFE's styles linked in, for the fuzz targets.
//
// Wrong input must end in an exception of LAMMPS' error class and in nothing else: whatever other
// exception, crash, sanitizer report or hang an input causes is a bug.

#include "atom.h"
#include "exceptions.h"
#include "input.h"
#include "lammps.h"

#include <cstddef>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <memory>
#include <string>
#include <vector>

/// What libFuzzer calls, and replay.cpp.
extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t *data, std::size_t size);
extern "C" int LLVMFuzzerInitialize(int *argc, char ***argv);

namespace defe::fuzz {

/// A new LAMMPS after these lines of input.
std::unique_ptr<LAMMPS_NS::LAMMPS> start(const std::vector<std::string> &script);

/// Calls something; true if LAMMPS' error class stopped it. The environment variable
/// DEFE_FUZZ_VERBOSE shows what it said.
template <class Do> bool refused(const Do &something)
{
  try {
    something();
  } catch (LAMMPS_NS::LAMMPSException &e) {
    if (std::getenv("DEFE_FUZZ_VERBOSE")) std::fprintf(stderr, "refused: %s", e.what());
    return true;
  }
  if (std::getenv("DEFE_FUZZ_VERBOSE")) std::fprintf(stderr, "accepted\n");
  return false;
}

/// Lines without their ends; a NUL ends the text as it does in LAMMPS' buffers.
std::vector<std::string> lines_of(const std::uint8_t *data, std::size_t size);

/// Words without LAMMPS' substitution of variables: no input may reach a shell.
std::vector<std::string> words_of(const std::string &line);

/// narg and arg as LAMMPS hands them to a style.
struct Arguments {
  explicit Arguments(std::vector<std::string> list) : words(std::move(list))
  {
    for (auto &w : words) arg.push_back(w.data());
  }
  int narg() const { return static_cast<int>(arg.size()); }
  std::vector<std::string> words;
  std::vector<char *> arg;
};

}    // namespace defe::fuzz

#endif
