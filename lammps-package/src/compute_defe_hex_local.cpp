/* ----------------------------------------------------------------------
   DEFE: adaptive finite elements to bonded discrete elements for LAMMPS
   https://www.lammps.org/
   This software is distributed under the GNU General Public License.
------------------------------------------------------------------------- */

#include "compute_defe_hex_local.h"

#include "defe_system.h"

#include "atom.h"
#include "error.h"
#include "memory.h"
#include "modify.h"
#include "update.h"

#include "defe/fe/principal.h"

#include <algorithm>
#include <map>
#include <string>

using namespace LAMMPS_NS;

/* ---------------------------------------------------------------------- */

ComputeDefeHexLocal::ComputeDefeHexLocal(LAMMPS *lmp, int narg, char **arg) :
    Compute(lmp, narg, arg)
{
  static const std::map<std::string, Quantity> names = {{"id", ID},
                                                        {"part", PART},
                                                        {"x", X},
                                                        {"y", Y},
                                                        {"z", Z},
                                                        {"sxx", SXX},
                                                        {"syy", SYY},
                                                        {"szz", SZZ},
                                                        {"sxy", SXY},
                                                        {"sxz", SXZ},
                                                        {"syz", SYZ},
                                                        {"s1", S1},
                                                        {"vonmises", VONMISES},
                                                        {"strength", STRENGTH},
                                                        {"plastic", PLASTIC},
                                                        {"heating", HEATING}};
  if (narg < 4) utils::missing_cmd_args(FLERR, "compute defe/hex/local", error);
  for (int k = 3; k < narg; k++) {
    auto found = names.find(arg[k]);
    if (found == names.end())
      error->all(
          FLERR,
          "Unknown compute defe/hex/local quantity {}: use id, part, x, y, z, sxx, syy, szz, "
          "sxy, sxz, syz, s1, vonmises, strength, plastic or heating",
          arg[k]);
    what.push_back(found->second);
  }
  local_flag = 1;
  size_local_cols = what.size() == 1 ? 0 : static_cast<int>(what.size());
}

ComputeDefeHexLocal::~ComputeDefeHexLocal()
{
  if (what.size() == 1)
    memory->destroy(vector_local);
  else
    memory->destroy(array_local);
}

void ComputeDefeHexLocal::init()
{
  sys = DefeSystem::find(lmp);
  if (!sys) error->all(FLERR, "Compute defe/hex/local needs a fix defe");
  if (!sys->strengths.on() && std::find(what.begin(), what.end(), STRENGTH) != what.end())
    error->all(FLERR, "Compute defe/hex/local strength needs the keyword strength of fix defe");
}

/* ----------------------------------------------------------------------
   elements whose first node is in the group, by the rank that owns it
------------------------------------------------------------------------- */

void ComputeDefeHexLocal::compute_local()
{
  invoked_local = update->ntimestep;
  const int ncol = static_cast<int>(what.size());
  int n = 0;
  for (int i = 0; i < atom->nlocal; i++)
    if (atom->mask[i] & groupbit) n += static_cast<int>(sys->store.hexes(i).size());
  size_local_rows = n;
  if (n > nmax) {
    nmax = n;
    if (ncol == 1) {
      memory->destroy(vector_local);
      memory->create(vector_local, nmax, "defe/hex/local:vector");
    } else {
      memory->destroy(array_local);
      memory->create(array_local, nmax, ncol, "defe/hex/local:array");
    }
  }
  n = 0;
  for (int i = 0; i < atom->nlocal; i++) {
    if (!(atom->mask[i] & groupbit)) continue;
    for (const auto &h : sys->store.hexes(i)) {
      double centre[3], s[6], s1;
      sys->elements.centre_stress(h, centre, s, s1);
      for (int c = 0; c < ncol; c++) {
        double value = 0.0;
        switch (what[c]) {
          case ID:
            value = static_cast<double>(h.id);
            break;
          case PART:
            value = h.part + 1;
            break;
          case X:
            value = centre[0];
            break;
          case Y:
            value = centre[1];
            break;
          case Z:
            value = centre[2];
            break;
          case SXX:
            value = s[0];
            break;
          case SYY:
            value = s[1];
            break;
          case SZZ:
            value = s[2];
            break;
          case SXY:
            value = s[3];
            break;
          case SXZ:
            value = s[4];
            break;
          case SYZ:
            value = s[5];
            break;
          case S1:
            value = s1;
            break;
          case VONMISES:
            value = defe::fe::von_mises(s);
            break;
          case STRENGTH:
            value = sys->strengths.of_element(i, h);
            break;
          case PLASTIC:
            value = sys->elements.plastic_state(h).strain;
            break;
          case HEATING:
            value = sys->elements.plastic_state(h).temperature;
            break;
        }
        if (ncol == 1)
          vector_local[n] = value;
        else
          array_local[n][c] = value;
      }
      n++;
    }
  }
}

double ComputeDefeHexLocal::memory_usage()
{
  return static_cast<double>(nmax) * what.size() * sizeof(double);
}
