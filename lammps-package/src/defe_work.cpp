/* ----------------------------------------------------------------------
   DEFE: adaptive finite elements to bonded discrete elements for LAMMPS
   https://www.lammps.org/
   This software is distributed under the GNU General Public License.
------------------------------------------------------------------------- */

#include "defe_system.h"
#include "style_names.h"

#include "atom.h"
#include "fix.h"
#include "group.h"
#include "modify.h"
#include "update.h"

using namespace LAMMPS_NS;
using namespace FixConst;

/* ----------------------------------------------------------------------
   does this atom count in the kinetic energy of the account, and the work of other fixes on it as external work?
   Balls do if they are in the group and can meet elements or DEs.
------------------------------------------------------------------------- */

bool DefeWork::in_account(int i) const
{
  return sys.store.is_ours(i) ||
      (atom->radius[i] > 0.0 && (atom->mask[i] & sys.host->groupbit) && sys.model.contact());
}

double DefeWork::kinetic_energy(int i) const
{
  const double *v = atom->v[i], *w = atom->omega[i];
  return 0.5 * atom->rmass[i] *
      (v[0] * v[0] + v[1] * v[1] + v[2] * v[2] +
       0.4 * atom->radius[i] * atom->radius[i] * (w[0] * w[0] + w[1] * w[1] + w[2] * w[2]));
}

/* ----------------------------------------------------------------------
   groups that forces of other fixes act on: those of the fixes that change forces after this one, or all atoms if
   one of them is not known to keep to its group, or has a dynamic group
------------------------------------------------------------------------- */

int DefeWork::groups_forced() const
{
  int bits = 0;
  bool after = false;
  for (auto *ifix : modify->get_fix_list()) {
    if (ifix == sys.host) after = true;
    if (!after || ifix == sys.host || !(ifix->setmask() & (POST_FORCE | POST_FORCE_RESPA)))
      continue;
    static const char *const keeps[] = {"^setforce", "^addforce", "^aveforce",    "^gravity",
                                        "^viscous",  "^wall/",    "^lineforce",   "^planeforce",
                                        "^drag",     "^efield",   "^spring/self", "^rigid",
                                        "^langevin", "^damping/"};
    const bool known = one_of(keeps, ifix->style);
    bits |= known && !group->dynamic[ifix->igroup] ? ifix->groupbit : 1;    // bit 1 is group all
  }
  return bits;
}

/* ----------------------------------------------------------------------
   all ghost forces have arrived: what is added from here on is external
------------------------------------------------------------------------- */

void DefeWork::keep_internal()
{
  if (sys.model.reproducible) sys.sums.check_range(true);
  double **f = atom->f;
  f_internal.resize(6 * forced_.size());
  for (size_t q = 0; q < forced_.size(); q++)
    for (int k = 0; k < 3; k++) {
      f_internal[6 * q + k] = f[forced_[q]][k];
      f_internal[6 * q + 3 + k] = atom->torque[forced_[q]][k];
    }
}

/* ----------------------------------------------------------------------
   power of all forces of others, with velocities at the full step
------------------------------------------------------------------------- */

double DefeWork::power_of_others() const
{
  double **f = atom->f;
  double **v = atom->v;
  double power = 0.0;
  for (size_t q = 0; q < forced_.size(); q++) {
    const int i = forced_[q];
    for (int k = 0; k < 3; k++) power += (f[i][k] - f_internal[6 * q + k]) * v[i][k];
    if (!(atom->radius[i] > 0.0)) continue;    // nodes do not turn
    for (int k = 0; k < 3; k++)
      power += (atom->torque[i][k] - f_internal[6 * q + 3 + k]) * atom->omega[i][k];
  }
  return power;
}

/* ---------------------------------------------------------------------- */

void DefeWork::find_forced_groups()
{
  forced_bits = groups_forced();
}

void DefeWork::list_forced()
{
  const auto is_one = [this](int i) {
    return (atom->mask[i] & forced_bits) && in_account(i);
  };
  if (!sys.in_place.going_on()) {
    forced_.clear();
    for (int i = 0; i < atom->nlocal && forced_bits; i++)
      if (is_one(i)) forced_.push_back(i);
    return;
  }
  const auto &store = sys.store;
  forced_.erase(std::remove_if(forced_.begin(), forced_.end(),
                               [&store](int i) {
                                 return store.changed(i);
                               }),
                forced_.end());
  const auto kept = static_cast<std::ptrdiff_t>(forced_.size());
  for (int i : store.changed())
    if (i < atom->nlocal && is_one(i)) forced_.push_back(i);
  std::sort(forced_.begin() + kept, forced_.end());
  std::inplace_merge(forced_.begin(), forced_.begin() + kept, forced_.end());
}

/* ----------------------------------------------------------------------
   the first half kick uses the forces of the last step, or those of setup
------------------------------------------------------------------------- */

bool DefeWork::begin_step()
{
  const bool first = setup;
  if (first) external_power = power_of_others();
  setup = false;
  return first;
}

void DefeWork::first_half()
{
  sys.ledger.external += 0.5 * update->dt * external_power;
}

void DefeWork::second_half()
{
  external_power = power_of_others();
  sys.ledger.external += 0.5 * update->dt * external_power;
}
