// Fuzz target: what users write in input scripts. Each line of the input is one command; its first
// word chooses it, the others are its arguments:
//
//   fix ...      fix fe all defe ...
//   coeff ...    pair_coeff ...
//   style ...    pair_style defe/joint ...
//   mesh ...     create_hexes fe ...
//   atom ...     compute N all defe/atom ...
//   hex ...      compute N all defe/hex/local ...
//
// If nothing is refused, `run 0` and `run 1` follow.

#include "fuzz_lammps.h"

#include "compute.h"
#include "create_hexes.h"
#include "fix_defe.h"
#include "force.h"
#include "modify.h"
#include "pair.h"

using namespace LAMMPS_NS;
using namespace defe::fuzz;

namespace {

constexpr std::size_t MOST_LINES = 12;

/// Large meshes are no mistake, but they take long.
bool too_large(const std::vector<std::string> &words)
{
  double nodes = 1.0;
  for (const auto &w : words) {
    const auto digits = w.find_first_not_of("+0");
    if (w.find_first_not_of("+0123456789") != std::string::npos || digits == std::string::npos)
      continue;
    const std::size_t n = w.size() - digits;
    if (n > 10) continue;    // no 32-bit integer: refused
    nodes *= 1.0 + std::stod(w.substr(digits));
  }
  return nodes > 2000.0;
}

void command(LAMMPS *lmp, std::vector<std::string> words, int number)
{
  const std::string key = words[0];
  std::vector<std::string> list(words.begin() + 1, words.end());
  const std::string id = "c" + std::to_string(number);
  auto with = [&](std::vector<std::string> first) {
    first.insert(first.end(), list.begin(), list.end());
    return Arguments(first);
  };
  if (key == "fix") {
    // no file of the input's choice
    for (std::size_t k = 0; k + 1 < list.size(); k++)
      if (list[k] == "events") list[k + 1] = "/dev/null";
    auto a = with({"fe", "all", "defe"});
    lmp->modify->add_fix(a.narg(), a.arg.data(), 1);
  } else if (key == "coeff") {
    auto a = with({});
    if (lmp->force->pair && a.narg() > 0) lmp->force->pair->coeff(a.narg(), a.arg.data());
  } else if (key == "style") {
    auto a = with({});
    lmp->force->create_pair("defe/joint", 1);
    lmp->force->pair->settings(a.narg(), a.arg.data());
  } else if (key == "mesh") {
    if (too_large(list)) return;
    auto a = with({"fe"});
    CreateHexes(lmp).command(a.narg(), a.arg.data());
  } else if (key == "atom" || key == "hex") {
    auto a = with({id, "all", key == "atom" ? "defe/atom" : "defe/hex/local"});
    lmp->modify->add_compute(a.narg(), a.arg.data(), 1);
  }
}

}    // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t *data, std::size_t size)
{
  static const std::vector<std::string> script = {
      "units si",
      "atom_style sphere",
      "newton off on",
      "comm_modify vel yes",
      "boundary f f f",
      "region box block -0.02 0.02 -0.02 0.02 -0.02 0.02",
      "create_box 3 box",
      "region some block 0 0.002 INF INF INF INF",
      "group particles empty",
      "pair_style defe/joint",
      "fix move particles nve/sphere",
      "timestep 1e-9",
      "thermo_modify lost ignore"};
  static std::unique_ptr<LAMMPS> lmp;
  if (!lmp) lmp = start(script);

  bool used = false;
  const bool wrong = refused([&] {
    int number = 0;
    for (const auto &line : lines_of(data, size)) {
      const auto words = words_of(line);
      if (words.empty()) continue;
      if (number == MOST_LINES) break;
      used = true;
      command(lmp.get(), words, ++number);
    }
    if (!used || !lmp->modify->get_fix_by_id("fe")) return;
    lmp->input->one("run 0");    // DEs that nothing moves are no mistake here
    lmp->input->one("run 1");
    for (auto *compute : lmp->modify->get_compute_list()) {
      if (compute->peratom_flag && std::string(compute->style) == "defe/atom")
        compute->compute_peratom();
      if (compute->local_flag) compute->compute_local();
    }
  });
  if (wrong || used) lmp.reset();
  return 0;
}
