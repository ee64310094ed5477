/* ----------------------------------------------------------------------
   DEFE: adaptive finite elements to bonded discrete elements for LAMMPS
   https://www.lammps.org/
   This software is distributed under the GNU General Public License.

   Plugin entry: 'plugin load defeplugin.so' in a LAMMPS input script.
------------------------------------------------------------------------- */

#include "lammpsplugin.h"

#include "plugin_host.h"

#include "force.h"
#include "modify.h"
#include "plugin.h"
#include "version.h"

#include "compute_defe_atom.h"
#include "compute_defe_fragment_atom.h"
#include "compute_defe_hex_local.h"
#include "compute_defe_joint_local.h"
#include "create_hexes.h"
#include "fix_defe.h"
#include "fix_defe_vtk.h"
#include "fix_defe_wall.h"
#include "pair_defe_cohesive.h"
#include "pair_defe_connective.h"
#include "pair_defe_contact.h"
#include "pair_defe_joint.h"

#include <cstdlib>
#include <type_traits>

using namespace LAMMPS_NS;

template <class T> static void *one_argument(LAMMPS *lmp)
{
  return new T(lmp);
}

template <class T> static void *with_arguments(LAMMPS *lmp, int narg, char **arg)
{
  return new T(lmp, narg, arg);
}

/* ----------------------------------------------------------------------
   LAMMPS keeps one list of plugins per process, and ignores a style that is in it already, also if it
   came with another LAMMPS of the process: this one then knows nothing of it. Its maps are filled here.
   The library stays loaded as long as any of them lives, since each has opened it for itself.
------------------------------------------------------------------------- */

template <class Map, class Creator> static bool add(Map *map, const char *name, Creator creator)
{
  return map->emplace(name, reinterpret_cast<typename Map::mapped_type>(creator)).second;
}

static bool add_style(LAMMPS *lmp, const std::string &kind, const char *name,
                      void *(*creator)(LAMMPS *) )
{
  return kind == "pair" ? add(lmp->force->pair_map, name, creator)
                        : add(lmp->input->command_map, name, creator);
}

static bool add_style(LAMMPS *lmp, const std::string &kind, const char *name,
                      void *(*creator)(LAMMPS *, int, char **) )
{
  return kind == "fix" ? add(lmp->modify->fix_map, name, creator)
                       : add(lmp->modify->compute_map, name, creator);
}

extern "C" void lammpsplugin_init(void *lmp, void *handle, void *regfunc)
{
  auto *lammps = static_cast<LAMMPS *>(lmp);

#ifndef DEFE_LEVEL_NAME    // else the loader has looked at it
  if (!defe_wanted(lammps)) return;
  const char *level = std::getenv("DEFE_LEVEL");
  if (level && *level)
    lammps->error->all(
        FLERR,
        "The environment variable DEFE_LEVEL is set, but this defeplugin.so has one level only: "
        "unset it, or build DEFE with -D DEFE_PORTABLE=ON");
#endif

  auto register_plugin = reinterpret_cast<lammpsplugin_regfunc>(regfunc);
  lammpsplugin_t plugin;
  plugin.version = LAMMPS_VERSION;
  plugin.author = "the DEFE developers";
  plugin.handle = handle;

  // of a further LAMMPS in this process: register_plugin() would say that there is nothing to do

  const bool further = plugin_find("fix", "defe") >= 0;
  const auto style = [&](const char *kind, const char *name, const char *info, auto creator) {
    if (further) {
      add_style(lammps, kind, name, creator);
      return;
    }
    plugin.style = kind;
    plugin.name = name;
    plugin.info = info;
    if constexpr (std::is_same_v<decltype(creator), void *(*) (LAMMPS *)>)
      plugin.creator.v1 = reinterpret_cast<lammpsplugin_factory1 *>(creator);
    else
      plugin.creator.v2 = reinterpret_cast<lammpsplugin_factory2 *>(creator);
    (*register_plugin)(&plugin, lmp);
  };
  style("fix", "defe", "DEFE " DEFE_VERSION " fix defe", with_arguments<FixDefe>);
  style("fix", "defe/wall", "DEFE " DEFE_VERSION " fix defe/wall", with_arguments<FixDefeWall>);
  style("fix", "defe/vtk", "DEFE " DEFE_VERSION " fix defe/vtk", with_arguments<FixDefeVTK>);
  style("pair", "defe/joint", "DEFE " DEFE_VERSION " pair defe/joint", one_argument<PairDefeJoint>);
  style("pair", "defe/connective", "DEFE " DEFE_VERSION " pair defe/connective",
        one_argument<PairDefeConnective>);
  style("pair", "defe/cohesive", "DEFE " DEFE_VERSION " pair defe/cohesive",
        one_argument<PairDefeCohesive>);
  style("pair", "defe/contact", "DEFE " DEFE_VERSION " pair defe/contact",
        one_argument<PairDefeContact>);
  style("compute", "defe/atom", "DEFE " DEFE_VERSION " compute defe/atom",
        with_arguments<ComputeDefeAtom>);
  style("compute", "defe/fragment/atom", "DEFE " DEFE_VERSION " compute defe/fragment/atom",
        with_arguments<ComputeDefeFragmentAtom>);
  style("compute", "defe/hex/local", "DEFE " DEFE_VERSION " compute defe/hex/local",
        with_arguments<ComputeDefeHexLocal>);
  style("compute", "defe/joint/local", "DEFE " DEFE_VERSION " compute defe/joint/local",
        with_arguments<ComputeDefeJointLocal>);
  style("command", "create_hexes", "DEFE " DEFE_VERSION " command create_hexes",
        one_argument<CreateHexes>);
}
