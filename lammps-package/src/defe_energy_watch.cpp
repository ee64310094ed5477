/* ----------------------------------------------------------------------
   DEFE: adaptive finite elements to bonded discrete elements for LAMMPS
   https://www.lammps.org/
   This software is distributed under the GNU General Public License.
------------------------------------------------------------------------- */

#include "defe_system.h"
#include "style_names.h"

#include "atom.h"
#include "comm.h"
#include "error.h"
#include "fix.h"
#include "force.h"
#include "group.h"
#include "modify.h"
#include "update.h"

#include <cmath>

using namespace LAMMPS_NS;
using namespace FixConst;

// shares of the energy that was put in: by which the balance may be off, and what velocity Verlet may
// add to that by its swing; and the strain, or speed in speeds of sound, below which energies are rounding
static constexpr double BALANCE_LIMIT = 0.05, SWING_LIMIT = 0.2, SMALLEST_MOTION = 1.0e-9;

/* ----------------------------------------------------------------------
   what changes the energy of our atoms without being in the account, in words; empty if nothing does
   Collective.
------------------------------------------------------------------------- */

std::string DefeEnergyWatch::unseen_work() const
{
  int mine[2] = {0, 0}, all[2];    // groups of our atoms; are there spheres that do not count
  for (int i = 0; i < atom->nlocal; i++) {
    if (sys.work.in_account(i))
      mine[0] |= atom->mask[i];
    else if (atom->radius[i] > 0.0)
      mine[1] = 1;
  }
  for (const auto &p : sys.model.parts)
    if (p.convertible) mine[0] |= 1 | group->bitmask[p.group];
  MPI_Allreduce(mine, all, 2, MPI_INT, MPI_BOR, world);

  static const char *const seen[] = {"^nve$",       "^nve/sphere$",  "^nve/bpm/sphere$", "^rigid$",
                                     "^rigid/nve$", "^rigid/small$", "^rigid/nve/small$"};
  static const char *const changes[] = {"^temp/",     "^momentum",       "^recenter",
                                        "^evaporate", "^viscosity$",     "^heat$",
                                        "^ehex$",     "^python/invoke$", "^thermal/conductivity$"};
  for (const auto &ifix : modify->get_fix_list()) {
    const auto style = plain_style(ifix);
    if (ifix == sys.host || utils::strmatch(style, "^defe")) continue;
    const bool moves = ifix->time_integrate ||
        (ifix->setmask() & (INITIAL_INTEGRATE | POST_INTEGRATE | FINAL_INTEGRATE)) ||
        one_of(changes, style);
    const bool box = (ifix->box_change & ~Fix::BOX_CHANGE_DOMAIN) != 0;
    const bool ours = group->dynamic[ifix->igroup] || (ifix->groupbit & all[0]);
    if (box || (moves && ours && !one_of(seen, style)))
      return fmt::format("the work of fix {} {}", ifix->id, ifix->style);
  }
  static const char *const known[] = {"^defe/", "^zero$", "^none$"};
  if (force->pair_style && !one_of(known, force->pair_style))
    return fmt::format("what other styles of pair_style {} store and lose", force->pair_style);
  if (force->bond && atom->nbonds > 0)
    return fmt::format("what bond_style {} stores and loses", force->bond_style);
  if (all[1] && (sys.model.contact_factor > 0.0 || sys.census.des() > 0))
    return fmt::format(
        "what spheres take along that are not in the group of fix {}, or that it has "
        "no contact for",
        sys.host->id);
  return "";
}

/* ----------------------------------------------------------------------
   before a run: can its balance be watched?
------------------------------------------------------------------------- */

void DefeEnergyWatch::prepare()
{
  on = false;
  if (sys.model.energy_check == DefeModel::ENERGY_NO || update->whichflag != 1 ||
      update->nsteps == 0)
    return;
  const auto unseen = unseen_work();
  on = unseen.empty();
  if (on) return;
  balance_known = false;
  if (sys.model.energy_check == DefeModel::ENERGY_STOP)
    error->all(FLERR,
               "Fix defe check energy stop: {} is not in its account of energies (entry 21), so "
               "that the balance cannot be watched: remove it, or 'check energy stop'",
               unseen);
  sys.notes.say(fmt::format("the energy balance (entry 23 of f_{}) is not watched: {} is not in it",
                            sys.host->id, unseen));
}

/* ----------------------------------------------------------------------
   the first step of a run, before anything moves: what commands between runs have put in or taken out
   does not count, what the balance has been off by in earlier runs does
------------------------------------------------------------------------- */

void DefeEnergyWatch::begin()
{
  if (!on) return;
  sys.account.forget();
  const auto &w = sys.account.energies();
  const double balance = w[defe::entries::BALANCE];
  balance_start = balance_known ? balance_start + (balance - balance_last) : balance;
  balance_last = balance;
  balance_known = true;
  swing_start = swing();
  put_in = MAX(put_in, balance_start + MAX(0.0, w[defe::entries::EXTERNAL]));
}

/* ----------------------------------------------------------------------
   velocity Verlet keeps E - dt^2/8 sum f^2/m in a linear system, so that E itself swings by that sum: at the
   limit of stability by a good part of it, and without harm
------------------------------------------------------------------------- */

double DefeEnergyWatch::swing() const
{
  double mine = 0.0, all = 0.0;
  for (int i = 0; i < atom->nlocal; i++) {
    if (!sys.work.in_account(i)) continue;
    const double *f = atom->f[i], *t = atom->torque[i], r = atom->radius[i];
    double square = f[0] * f[0] + f[1] * f[1] + f[2] * f[2];
    if (r > 0.0) square += (t[0] * t[0] + t[1] * t[1] + t[2] * t[2]) / (0.4 * r * r);
    mine += square / atom->rmass[i];
  }
  MPI_Allreduce(&mine, &all, 1, MPI_DOUBLE, MPI_SUM, world);
  return 0.125 * update->dt * update->dt * all;
}

/* ----------------------------------------------------------------------
   numbers that are none, energy from nowhere, rigid elements that change their shape; collective
------------------------------------------------------------------------- */

void DefeEnergyWatch::look()
{
  sys.watch.rigid_elements();
  if (sys.model.energy_check == DefeModel::ENERGY_NO) return;
  const auto &w = sys.account.energies();
  sys.account.forget();    // fixes may still change velocities in this step
  for (int k = 0; k < defe::entries::COUNT; k++)
    if (!std::isfinite(w[k]))
      error->all(
          FLERR,
          "Entry {} of f_{} is not a number at step {}: a coefficient of pair_coeff or fix defe "
          "is beyond all bounds, or the run has become unstable (use a smaller timestep)",
          k + 1, sys.host->id, update->ntimestep);
  if (!on || !balance_known) return;

  double stiffest = 0.0;
  for (const auto &m : sys.model.materials)
    if (!m.rigid()) stiffest = MAX(stiffest, m.elastic().E / m.elastic().rho);
  const double floor = sys.census.mass() * stiffest * SMALLEST_MOTION * SMALLEST_MOTION;
  balance_last = w[defe::entries::BALANCE];
  put_in = MAX(put_in, balance_start + MAX(0.0, w[defe::entries::EXTERNAL]));
  const double off = balance_last - balance_start;
  if (std::abs(off) <= MAX(BALANCE_LIMIT * put_in, floor)) return;
  const double swings = MIN(MAX(swing_start, swing()), SWING_LIMIT * put_in);
  if (std::abs(off) <= BALANCE_LIMIT * put_in + swings) return;
  const auto what = fmt::format(
      "Fix defe: the energy balance is off by {:.4g} at step {}, {:.3g} % of the {:.4g} that was "
      "put in (entry 23 of f_{}): the run is not to be trusted, use a smaller timestep",
      off, update->ntimestep, 100.0 * std::abs(off) / put_in, put_in, sys.host->id);
  if (sys.model.energy_check == DefeModel::ENERGY_STOP) error->all(FLERR, what);
  if (!told && comm->me == 0) error->warning(FLERR, what);
  told = true;
}
