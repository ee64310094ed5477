/* ----------------------------------------------------------------------
   DEFE: adaptive finite elements to bonded discrete elements for LAMMPS
   https://www.lammps.org/
   This software is distributed under the GNU General Public License.

   The defeplugin.so of the portable build (-D DEFE_PORTABLE=ON): itself for any x86-64, it loads the best of the
   plugins beside it that the processors of all ranks can run:

     defeplugin-v1.so   x86-64-v1: any x86-64 (SSE2)
     defeplugin-v3.so   x86-64-v3: AVX2, FMA
     defeplugin-v4.so   x86-64-v4: AVX-512

   The environment variable DEFE_LEVEL sets the level, for the same digits on different machines.
------------------------------------------------------------------------- */

#include "lammpsplugin.h"

#include "plugin_host.h"

#include <dlfcn.h>

#include <algorithm>
#include <array>
#include <cstdlib>
#include <filesystem>
#include <string>

using namespace LAMMPS_NS;

namespace {

struct Level {
  const char *name, *meaning;
};
const std::array<Level, 3> levels = {{{"v1", "SSE2"}, {"v3", "AVX2"}, {"v4", "AVX-512"}}};

/// Index of the best level that this processor (and its operating system) can run.
int level_of_processor()
{
  if (__builtin_cpu_supports("x86-64-v4")) return 2;
  return __builtin_cpu_supports("x86-64-v3") ? 1 : 0;
}

constexpr int WORD_UNKNOWN = -2, TOO_HIGH = -1;

/// What DEFE_LEVEL asks for on this rank, else the best.
int level_of_rank()
{
  const int best = level_of_processor();
  const char *word = std::getenv("DEFE_LEVEL");
  if (!word || !*word) return best;
  const auto *found = std::find_if(levels.begin(), levels.end(), [word](const Level &level) {
    return std::string(word) == level.name;
  });
  if (found == levels.end()) return WORD_UNKNOWN;
  const int level = static_cast<int>(found - levels.begin());
  return level <= best ? level : TOO_HIGH;
}

/// The same on all ranks, or an error on all of them.
int level_of_run(LAMMPS *lammps)
{
  const int mine = level_of_rank();
  int level;
  MPI_Allreduce(&mine, &level, 1, MPI_INT, MPI_MIN, lammps->world);
  if (level == WORD_UNKNOWN)
    lammps->error->all(FLERR,
                       "The environment variable DEFE_LEVEL must be v1, v3 or v4, or not be set");
  if (level == TOO_HIGH)
    lammps->error->all(FLERR,
                       "The environment variable DEFE_LEVEL asks for instructions that a processor "
                       "of this run lacks: "
                       "set a lower level (v1, v3), or none");
  return level;
}

/// Beside this file, wherever a link to it lies. (Asked for is a name that no other plugin has.)
std::string plugin_of(int level)
{
  Dl_info here;
  if (!dladdr(reinterpret_cast<void *>(&level_of_processor), &here)) return "";
  std::error_code failed;
  const auto file = std::filesystem::canonical(here.dli_fname, failed);
  return (file.parent_path() / (std::string("defeplugin-") + levels[level].name + ".so")).string();
}

}    // namespace

extern "C" void lammpsplugin_init(void *lmp, void *handle, void *regfunc)
{
  auto *lammps = static_cast<LAMMPS *>(lmp);
  if (!defe_wanted(lammps)) return;
  const int level = level_of_run(lammps);
  const std::string file = plugin_of(level);

  // it stays open to the end of the process: LAMMPS closes this loader when it unloads the styles

  void *library = dlopen(file.c_str(), RTLD_NOW | RTLD_LOCAL);
  const std::string reason = library ? "it is no plugin" : dlerror();
  void *init = library ? dlsym(library, "lammpsplugin_init") : nullptr;
  const int mine = init != nullptr;
  int all;
  MPI_Allreduce(&mine, &all, 1, MPI_INT, MPI_MIN, lammps->world);
  if (!all)
    lammps->error->all(FLERR, "{} cannot be loaded ({}): install DEFE again", file,
                       mine ? "on another rank" : reason);
  if (lammps->comm->me == 0)
    utils::logmesg(lammps, "DEFE " DEFE_VERSION " with the instructions of x86-64-{} ({})\n",
                   levels[level].name, levels[level].meaning);
  reinterpret_cast<lammpsplugin_initfunc>(init)(lmp, handle, regfunc);
}
