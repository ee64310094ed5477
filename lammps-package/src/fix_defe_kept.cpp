/* ----------------------------------------------------------------------
   DEFE: adaptive finite elements to bonded discrete elements for LAMMPS
   https://www.lammps.org/
   This software is distributed under the GNU General Public License.
------------------------------------------------------------------------- */

// Runs in pieces. In a step, forces that depend on velocities (restitution, friction) see those of half a
// step ago; the setup of a next run has only those of the full step. So the forces of the last step are
// kept, of all atoms: friction acts on nodes and balls, too, and that an atom has not been moved is known
// only of those that are kept. When a run ends (also by fix halt, a time limit or a signal, which no step
// knows of in advance), or a restart file is written in the middle of one, LAMMPS still has them. The next
// setup takes them if nothing was changed in between: the run then goes on as if it had not ended.

#include "fix_defe.h"

#include "fix_defe_wall.h"
#include "pair_defe_joint.h"

#include "atom.h"
#include "domain.h"
#include "error.h"
#include "force.h"
#include "modify.h"
#include "update.h"

#include "defe/coupling/checksum.h"

#include <algorithm>
#include <cmath>

using namespace LAMMPS_NS;

/* ----------------------------------------------------------------------
   of an atom: all that forces depend on, but for its position, which may be remapped
------------------------------------------------------------------------- */

uint64_t FixDefe::kept_motion(int i) const
{
  defe::Checksum sum;
  sum.add(atom->v[i], 3 * sizeof(double));
  sum.add(atom->omega[i], 3 * sizeof(double));
  sum.add(&atom->radius[i], sizeof(double));
  sum.add(&atom->rmass[i], sizeof(double));
  const int64_t integers[2] = {atom->tag[i], atom->type[i]};
  sum.add(integers, sizeof(integers));
  return sum.value() | 1;    // 0: of this atom nothing is kept
}

/* ----------------------------------------------------------------------
   of what the script says about the forces that are kept
------------------------------------------------------------------------- */

uint64_t FixDefe::kept_laws() const
{
  defe::Checksum sum;
  auto add = [&sum](const std::string &text) {
    sum.add(text.c_str(), text.size() + 1);
  };
  const double numbers[2] = {contact_factor, contact_friction};
  sum.add(numbers, sizeof(numbers));
  const int integers[3] = {subcycle.every(), force_lagrangian, reproducible};
  sum.add(integers, sizeof(integers));
  add(force->pair_style ? force->pair_style : "none");
  if (const auto *pair = dynamic_cast<PairDefeJoint *>(force->pair_match("^defe/", 0))) {
    const uint64_t laws = pair->laws_checksum();
    sum.add(&laws, sizeof(laws));
  }
  for (auto *wall : modify->get_fix_by_style("^defe/wall"))
    if (const auto *w = dynamic_cast<FixDefeWall *>(wall)) add(w->words);
  return sum.value();
}

/* ----------------------------------------------------------------------
   at the end of a step, from the forces in LAMMPS' arrays: without those of other fixes, which add
   them again
------------------------------------------------------------------------- */

void FixDefe::keep_forces()
{
  kept_step = update->ntimestep;
  kept_natoms = atom->natoms;
  kept_law = kept_laws();
  kept.resize(hexes.size());
  for (int i = 0; i < atom->nlocal; i++) {
    KeptForces &k = kept[i];
    domain->unmap(atom->x[i], atom->image[i], k.x);
    k.motion = kept_motion(i);
    std::copy_n(atom->f[i], 3, k.f);
    std::copy_n(atom->torque[i], 3, k.torque);
  }
  for (size_t q = 0; q < forced.size(); q++) {
    KeptForces &k = kept[forced[q]];
    std::copy_n(&f_internal[6 * q], 3, k.f);
    std::copy_n(&f_internal[6 * q + 3], 3, k.torque);
  }
  update_maxexchange();
}

void FixDefe::drop_kept_forces()
{
  kept = std::vector<KeptForces>();
  update_maxexchange();
}

/* ----------------------------------------------------------------------
   the clock may have been put back or forward since the last step (reset_timestep): shields keep their
   age, forces of the last step are still those, and what waits for a step goes on waiting as long
------------------------------------------------------------------------- */

void FixDefe::follow_clock(bigint step)
{
  const double time = update->atime + (step - update->atimestep) * update->dt;
  if (time != clock)
    for (int i = 0; i < atom->nlocal; i++)
      for (auto &h : hexes[i])
        if (h.extra)
          for (auto &s : h.extra->shields) s.time += time - clock;
  clock = time;
  if (kept_step == last_step) kept_step = step;
  if (convert_step >= 0) {
    convert_step += step - last_step;
    next_reneighbor = convert_step;
  }
  last_step = step;
}

/* ----------------------------------------------------------------------
   the first step of a run, for which there may have been no setup (run ... pre no)
------------------------------------------------------------------------- */

void FixDefe::begin_run()
{
  const bigint step = update->ntimestep - 1;
  if (update->whichflag != 1)
    error->all(
        FLERR,
        "Fix defe: a run, rerun or minimize among the commands of 'run ... every' has ended the "
        "run around it at step {}, and LAMMPS would go on without a setup: write the pieces one "
        "after the other, in a loop ('label', 'run', 'next', 'jump')",
        step);
  int changed = needs_setup || (!kept.empty() && !kept_places()) ? 1 : 0, any = 0;
  MPI_Allreduce(&changed, &any, 1, MPI_INT, MPI_MAX, world);
  if (any)
    error->all(
        FLERR,
        "Fix defe: since the last run (step {}) commands have moved, made or deleted atoms, or "
        "sorted them anew as minimize, write_restart and write_data do, and 'run ... pre no' "
        "would go on with forces and neighbours of before: leave out 'pre no'",
        step);
  running = true;
  between_runs = false;
  follow_clock(step);
  if (update->dt != checked_dt) check_time_step(false);
  if (!kept.empty()) drop_kept_forces();
}

/* ---------------------------------------------------------------------- */

bool FixDefe::kept_places() const
{
  if (kept_natoms != atom->natoms || (kept.empty() && atom->nlocal > 0)) return false;
  for (int i = 0; i < atom->nlocal; i++) {
    double x[3];
    domain->unmap(atom->x[i], atom->image[i], x);
    for (int k = 0; k < 3; k++)
      if (!(std::abs(x[k] - kept[i].x[k]) <= 1.0e-10 * max_diagonal)) return false;
  }
  return true;
}

/* ---------------------------------------------------------------------- */

void FixDefe::continue_with_kept_forces()
{
  if (kept_step == update->ntimestep && kept_natoms == atom->natoms && kept_law == kept_laws()) {
    int same = kept_places() ? 1 : 0, all = 0;
    for (int i = 0; i < atom->nlocal && same; i++)
      if (kept[i].motion != kept_motion(i)) same = 0;
    MPI_Allreduce(&same, &all, 1, MPI_INT, MPI_MIN, world);
    for (int i = 0; i < atom->nlocal && all; i++) {
      std::copy_n(kept[i].f, 3, atom->f[i]);
      std::copy_n(kept[i].torque, 3, atom->torque[i]);
    }
  }
  drop_kept_forces();
}
