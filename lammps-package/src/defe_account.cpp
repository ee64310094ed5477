/* ----------------------------------------------------------------------
   DEFE: adaptive finite elements to bonded discrete elements for LAMMPS
   https://www.lammps.org/
   This software is distributed under the GNU General Public License.
------------------------------------------------------------------------- */

#include "defe_system.h"

#include "atom.h"
#include "comm.h"
#include "error.h"
#include "update.h"

#include <cmath>

using namespace LAMMPS_NS;
namespace entries = defe::entries;

/* ----------------------------------------------------------------------
   elastic energy of elements and surface contact, for fix_modify energy yes
------------------------------------------------------------------------- */

double DefeAccount::scalar()
{
  return values()[entries::E_ELEMENTS] + surface_energy;
}

/* ----------------------------------------------------------------------
   between runs these are the values of the last one: commands like write_restart move atoms to other
   ranks, and the tables of local indices do not hold any more
------------------------------------------------------------------------- */

const defe::EntryValues &DefeAccount::values()
{
  if (between_runs || step == update->ntimestep) return vector;
  step = update->ntimestep;
  fill(true);
  return vector;
}

const defe::EntryValues &DefeAccount::energies()
{
  if (between_runs || step == update->ntimestep) return vector;
  fill(false);
  return vector;
}

void DefeAccount::end_run()
{
  values();
  between_runs = true;
}

/* ----------------------------------------------------------------------
   of this rank, at this step
------------------------------------------------------------------------- */

void DefeAccount::count_joints_and_motion(defe::EntryValues &mine)
{
  // with a slow clock, nodes have had half of the impulse of m steps, or are still to get it: their
  // kinetic energy is that of the velocity which the elements' forces of now would have given them

  double ahead = 0.0;
  const double *force = nullptr;
  if (!sys.clock.subcycle().due()) {
    ahead = sys.clock.subcycle().velocity_lead(update->dt);
    force = sys.elements.finite_forces();
  }

  static constexpr defe::Entry of_joint[] = {entries::CONNECTIVE, entries::COHESIVE,
                                             entries::CONTACT};
  static constexpr defe::Entry of_tie[] = {entries::TIES, entries::TIES_SOFTENING,
                                           entries::TIES_BROKEN};
  double kinetic = 0.0;
  const int nlocal = atom->nlocal;
  for (int i = 0; i < nlocal; i++) {
    if (const DERecord *r = sys.store.de(i)) {
      for (int s = 0; s < 6; s++) {
        const JointRecord &slot = r->slot[s];
        if (slot.kind == DefeJoint::TIE)
          mine[of_tie[slot.state]] += 1.0;
        else if (slot.kind == DefeJoint::DE && atom->tag[i] < r->other[s])
          mine[of_joint[slot.state]] += 1.0;
      }
    } else if (!sys.work.in_account(i))
      continue;
    kinetic += sys.work.kinetic_energy(i);
    if (ahead == 0.0 || sys.store.de(i)) continue;
    for (int k = 0; k < 3; k++) {
      const double v = atom->v[i][k];
      if (v == 0.0) continue;    // held
      const double dv = ahead * force[3 * i + k] / atom->rmass[i];
      kinetic += 0.5 * atom->rmass[i] * (dv * dv - 2.0 * v * dv);
    }
  }
  mine[entries::E_KINETIC] = kinetic;
}

/* ---------------------------------------------------------------------- */

void DefeAccount::fill(bool with_stress)
{
  struct Sums {
    defe::EntryValues entry{};
    double surface = 0.0, gone = 0.0;
  } mine, all;
  static_assert(sizeof(Sums) == (entries::COUNT + 2) * sizeof(double),
                "it is reduced as one array");

  mine.entry[entries::E_ELEMENTS] = sys.elements.energy();
  count_joints_and_motion(mine.entry);
  mine.entry[entries::E_JOINTS] = sys.stored.joints;
  mine.entry[entries::E_TIES] = sys.stored.ties;
  mine.entry[entries::E_COHESIVE] = sys.stored.cohesive;
  mine.entry[entries::E_CONTACT] = sys.stored.contact + sys.checks.wall_energy();
  sys.ledger.fill(mine.entry);
  mine.surface = sys.surface.energy();
  mine.gone = static_cast<double>(sys.census.gone());
  MPI_Allreduce(&mine, &all, entries::COUNT + 2, MPI_DOUBLE, MPI_SUM, world);
  double s1_all = -HUGE_VAL;
  if (with_stress) {
    const double s1 = sys.elements.largest_stress();
    MPI_Allreduce(&s1, &s1_all, 1, MPI_DOUBLE, MPI_MAX, world);
  }

  auto &w = vector;
  w = all.entry;
  surface_energy = all.surface;
  w[entries::E_CONTACT] += all.surface;
  w[entries::ELEMENTS] = static_cast<double>(sys.census.elements());
  w[entries::CONVERTED] = static_cast<double>(sys.census.converted());
  w[entries::DES] = static_cast<double>(sys.census.des()) - all.gone;
  w[entries::S1_MAX] = s1_all > -1.0e300 ? s1_all : 0.0;
  sys.surface.report();
  w[entries::LET_THROUGH] = static_cast<double>(sys.surface.let_through());
  w[entries::TOTAL] = defe::total_of(w);
  w[entries::BALANCE] = defe::balance_of(w);
  first_times(&w[entries::FIRST_CONVERSION]);
}

/* ----------------------------------------------------------------------
   of all ranks, -1 if there is none
------------------------------------------------------------------------- */

void DefeAccount::first_times(double times[2]) const
{
  double mine[2] = {first.conversion, first.damage};
  for (auto &t : mine)
    if (t < 0.0) t = HUGE_VAL;
  MPI_Allreduce(mine, times, 2, MPI_DOUBLE, MPI_MIN, world);
  for (int k = 0; k < 2; k++)
    if (times[k] == HUGE_VAL) times[k] = -1.0;
}

void DefeAccount::note_damage()
{
  if (first.damage < 0.0) first.damage = sys.clock.now();
}

void DefeAccount::note_conversion()
{
  if (first.conversion < 0.0) first.conversion = sys.clock.now();
}

void DefeAccount::pack(State &s) const
{
  double times[2];
  first_times(times);
  s.conversion = times[0];
  s.damage = times[1];
}
