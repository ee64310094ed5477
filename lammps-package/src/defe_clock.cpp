/* ----------------------------------------------------------------------
   DEFE: adaptive finite elements to bonded discrete elements for LAMMPS
   https://www.lammps.org/
   This software is distributed under the GNU General Public License.
------------------------------------------------------------------------- */

#include "defe_system.h"

#include "atom.h"
#include "update.h"

using namespace LAMMPS_NS;

double DefeClock::now() const
{
  return update->atime + (update->ntimestep - update->atimestep) * update->dt;
}

/* ----------------------------------------------------------------------
   the clock may have been set back or forward since the last step (reset_timestep): shields keep their age,
   forces of the last step remain so, and whatever waits for a step waits just as long as before
------------------------------------------------------------------------- */

void DefeClock::follow(bigint step)
{
  const double time = update->atime + (step - update->atimestep) * update->dt;
  if (time != time_)
    for (int i = 0; i < atom->nlocal; i++)
      for (auto &h : sys.store.hexes(i))
        if (h.extra)
          for (auto &s : h.extra->shields) s.time += time - time_;
  time_ = time;
  sys.kept.follow(last_step_, step);
  sys.marks.follow(step - last_step_);
  last_step_ = step;
}

void DefeClock::step_done()
{
  time_ = now();
  last_step_ = update->ntimestep;
}
