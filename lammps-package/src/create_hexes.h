/* -*- c++ -*- ----------------------------------------------------------
   DEFE: adaptive finite elements to bonded discrete elements for LAMMPS
   https://www.lammps.org/
   This software is distributed under the GNU General Public License.
------------------------------------------------------------------------- */

#ifdef COMMAND_CLASS
// clang-format off
CommandStyle(create_hexes,CreateHexes);
// clang-format on
#else

#ifndef LMP_CREATE_HEXES_H
#define LMP_CREATE_HEXES_H

#include "command.h"

#include <vector>

namespace LAMMPS_NS {

class CreateHexes : public Command {
 public:
  CreateHexes(class LAMMPS *lmp) : Command(lmp) {}
  void command(int, char **) override;

 private:
  std::vector<double> lines(int &iarg, int narg, char **arg, const char *axis);
};

}    // namespace LAMMPS_NS

#endif
#endif
