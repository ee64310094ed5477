#ifndef DEFE_TEST_FAILURE_H
#define DEFE_TEST_FAILURE_H

// How commands end: the first line of the message that ends them; empty if nothing does.

#include "lammps_run.h"

#include <functional>
#include <string>

namespace defe::test {

inline std::string failure(const std::function<void()> &something)
{
  try {
    something();
  } catch (LAMMPS_NS::LAMMPSException &e) {
    const std::string text = e.what();
    return text.substr(0, text.find('\n'));
  }
  return "";
}

inline std::string failure(Lammps &lmp, const std::string &commands)
{
  return failure([&] {
    lmp.commands(commands);
  });
}

/// In a LAMMPS of its own.
inline std::string failure(const std::string &commands, MPI_Comm comm = MPI_COMM_WORLD)
{
  return failure([&] {
    Lammps lmp(comm);
    lmp.commands(commands);
  });
}

}    // namespace defe::test

#endif
