// Fuzz target: the mesh of a data file. The input is a header line ("N hexes") and the lines of
// section Hexes, handed over as LAMMPS' read_data does it, and then used by `run 0`.

#include "fuzz_lammps.h"

#include "defe_system.h"
#include "fix.h"
#include "modify.h"

#include <algorithm>

using namespace LAMMPS_NS;
using namespace defe::fuzz;

namespace {

constexpr bigint CHUNK = 4;          // lines at a time; read_data's is 1024
constexpr std::size_t LINE = 255;    // read_data cuts longer lines

/// A part that converts, a rigid one, and the nodes of 4 x 2 x 2 cubes: IDs 1 to 45, x fastest.
std::unique_ptr<LAMMPS> with_nodes()
{
  return start({"units si", "atom_style sphere", "newton off on", "comm_modify vel yes",
                "boundary f f f", "region box block -0.02 0.02 -0.02 0.02 -0.02 0.02",
                "create_box 2 box", "pair_style defe/joint",
                "pair_coeff 2 2 connective material cohesive 60e6 10 0.1 contact 0.9 0.2",
                "fix fe all defe material glass elastic 74e9 0.2 2500 material steel rigid 7800 "
                "convert glass 1e5 type 2 start all contact 0.2",
                "lattice sc 0.001", "region nodes block 0 4.5 0 2.5 0 2.5",
                "create_atoms 1 region nodes", "set group all diameter 0.0", "timestep 1e-9",
                "thermo_modify lost ignore"});
}

void read_mesh(Fix *fix, const std::vector<std::string> &lines)
{
  std::string line = lines[0].substr(0, LINE) + "\n";
  fix->read_data_header(line.data());
  const bigint n = fix->read_data_skip_lines(nullptr);
  const bigint there = static_cast<bigint>(lines.size()) - 1;
  for (bigint read = 0; read < n;) {
    const bigint chunk = std::min(n - read, CHUNK);
    if (read + chunk > there) return;    // read_data: "Unexpected end of data file"
    std::string text;
    for (bigint k = 0; k < chunk; k++) text += lines[1 + read + k].substr(0, LINE) + "\n";
    fix->read_data_section(nullptr, static_cast<int>(chunk), text.data(), 0);
    read += chunk;
  }
}

}    // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t *data, std::size_t size)
{
  // nodes are many and the same: the LAMMPS is used until elements have changed it
  static std::unique_ptr<LAMMPS> lmp;
  const auto lines = lines_of(data, size);
  if (lines.empty()) return 0;
  if (!lmp) lmp = with_nodes();
  auto *fix = lmp->modify->get_fix_by_id("fe");
  bool changed = false;
  const bool wrong = refused([&] {
    read_mesh(fix, lines);
    for (int i = 0; i < lmp->atom->nlocal; i++)
      changed = changed || !DefeSystem::of(fix)->store.hexes(i).empty();
    if (changed) lmp->input->one("run 0");
  });
  if (wrong || changed) lmp.reset();
  return 0;
}
