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
  struct DefeSystem *sys = nullptr;
  int part = -1, type = 0;
  std::vector<double> line[3];    // places of the nodes in x, y and z
  bigint n[3] = {0, 0, 0};        // and how many there are
  // the mesh is closed with itself across the periodic border: the last line of nodes is the first one
  bool closed[3] = {false, false, false};
  bigint first_hex = 0;
  tagint last_tag = 0;    // of the atoms before

  std::vector<double> lines(int &iarg, int narg, char **arg, const char *axis);
  void read_closed(int &iarg, int narg, char **arg);
  void check_box() const;
  bigint elements(int k) const { return static_cast<bigint>(line[k].size()) - 1; }
  void create_nodes();
  void add_element(int me, bigint i, bigint j, bigint k);
  void register_atoms();
  tagint tag_of(bigint i, bigint j, bigint k) const
  {
    return static_cast<tagint>(last_tag + 1 + i + n[0] * (j + n[1] * k));
  }
};

}    // namespace LAMMPS_NS

#endif
#endif
