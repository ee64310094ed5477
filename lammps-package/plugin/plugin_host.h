/* -*- c++ -*- ----------------------------------------------------------
   DEFE: adaptive finite elements to bonded discrete elements for LAMMPS
   https://www.lammps.org/
   This software is distributed under the GNU General Public License.

   What the plugin and its loader ask first: does it fit the LAMMPS that loads it (a plugin of another LAMMPS or
   MPI loads, and crashes later), and is it there already?
------------------------------------------------------------------------- */

#ifndef LMP_DEFE_PLUGIN_HOST_H
#define LMP_DEFE_PLUGIN_HOST_H

#include "defe_build_info.h"

#include "comm.h"
#include "error.h"
#include "input.h"
#include "lammps.h"
#include "modify.h"
#include "utils.h"

#include <mpi.h>

#include <cstring>
#include <string>

namespace LAMMPS_NS {

// of each plugin by itself: LAMMPS loads them such that they would share inline functions
namespace {

  /// What does not fit, with the remedy; empty if all fits.
  [[maybe_unused]] std::string defe_misfit(const LAMMPS *lammps)
  {
    if (strcmp(lammps->version, DEFE_LAMMPS_VERSION) != 0)
      return std::string("This defeplugin.so was built for LAMMPS " DEFE_LAMMPS_VERSION
                         ", but is loaded by LAMMPS ") +
          lammps->version + ": rebuild DEFE with -D LAMMPS_SOURCE_DIR of this LAMMPS";
    char library[MPI_MAX_LIBRARY_VERSION_STRING] = "";
    int length = 0;
    MPI_Get_library_version(library, &length);
    if (strstr(library, DEFE_MPI_ID)) return "";
    library[strcspn(library, "\n\t,:(")] = '\0';    // the name is enough
    return std::string("This defeplugin.so was built with " DEFE_MPI_ID ", but LAMMPS runs with ") +
        library + ": rebuild DEFE with the MPI of this LAMMPS";
  }

  /// Stops the command `plugin load` of a plugin that does not fit. At LAMMPS' start (LAMMPS_PLUGIN_PATH) it is
  /// left out instead, and told of: scripts without DEFE run with any LAMMPS.
  [[maybe_unused]] bool defe_fits(LAMMPS *lammps)
  {
    const std::string misfit = defe_misfit(lammps);
    if (misfit.empty()) return true;
    const Input *input = lammps->input;
    const bool by_command = input->narg > 1 && strcmp(input->arg[0], "load") == 0;
    if (by_command) lammps->error->all(FLERR, misfit);
    if (lammps->comm->me == 0)
      utils::logmesg(lammps, "DEFE is left out. {} (or take it out of LAMMPS_PLUGIN_PATH)\n",
                     misfit);
    return false;
  }

  /// Is there anything to load? Else it has been said why not.
  [[maybe_unused]] bool defe_wanted(LAMMPS *lammps)
  {
    if (!defe_fits(lammps)) return false;
    if (!lammps->modify->fix_map->count("defe")) return true;
    if (lammps->comm->me == 0)
      utils::logmesg(lammps,
                     "DEFE is there already (loaded before, or part of this LAMMPS): this load "
                     "changes nothing\n");
    return false;
  }

}    // namespace

}    // namespace LAMMPS_NS

#endif
