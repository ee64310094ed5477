/* ----------------------------------------------------------------------
   DEFE: adaptive finite elements to bonded discrete elements for LAMMPS
   https://www.lammps.org/
   This software is distributed under the GNU General Public License.
------------------------------------------------------------------------- */

#include "defe_system.h"

#include "fix.h"
#include "modify.h"

using namespace LAMMPS_NS;

DefeComponent::DefeComponent(DefeSystem &s) : Pointers(s.lmp), sys(s) {}

DefeSystem::DefeSystem(LAMMPS *lammps, Fix *fix) :
    lmp(lammps), host(fix), clock(*this), store(*this), kept(*this), strengths(*this),
    prestress(*this), tied(*this), tied_des(*this), ids(*this), census(*this), mesh(*this),
    hexes_file(*this), elements(*this), ghosts(*this), tables(*this), sums(*this), surface(*this),
    marks(*this), conversion(*this), in_place(*this), work(*this), account(*this), events(*this),
    checks(*this), audit(*this), watch(*this), energy_watch(*this), notes(*this), script(*this),
    restart(*this), picture(*this)
{
  store.add_field(&kept);
}

DefeSystem *DefeSystem::of(Fix *fix)
{
  int dim;
  return fix ? static_cast<DefeSystem *>(fix->extract("defe", dim)) : nullptr;
}

DefeSystem *DefeSystem::find(LAMMPS *lmp)
{
  const auto fixes = lmp->modify->get_fix_by_style("^defe$");
  return fixes.empty() ? nullptr : of(fixes.front());
}
