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

#include "defe_system.h"
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
#include <cstring>

using namespace LAMMPS_NS;

/* ----------------------------------------------------------------------
   of an atom: all that forces depend on except its position, which may be remapped
------------------------------------------------------------------------- */

uint64_t DefeKept::motion_of(int i) const
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
   of the settings that the kept forces depend on
------------------------------------------------------------------------- */

uint64_t DefeKept::laws() const
{
  defe::Checksum sum;
  auto add = [&sum](const std::string &text) {
    sum.add(text.c_str(), text.size() + 1);
  };
  const double numbers[2] = {sys.model.contact_factor, sys.model.contact_friction};
  sum.add(numbers, sizeof(numbers));
  const int integers[3] = {sys.clock.subcycle().every(), sys.model.force_lagrangian,
                           sys.model.reproducible};
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

void DefeKept::keep()
{
  now.step = update->ntimestep;
  now.natoms = atom->natoms;
  now.law = laws();
  kept.resize(room);
  for (int i = 0; i < atom->nlocal; i++) {
    Forces &k = kept[i];
    domain->unmap(atom->x[i], atom->image[i], k.x);
    k.motion = motion_of(i);
    std::copy_n(atom->f[i], 3, k.f);
    std::copy_n(atom->torque[i], 3, k.torque);
  }
  for (size_t q = 0; q < sys.work.forced().size(); q++) {
    Forces &k = kept[sys.work.forced()[q]];
    std::copy_n(sys.work.internal(q), 3, k.f);
    std::copy_n(sys.work.internal(q) + 3, 3, k.torque);
  }
  sys.store.update_maxexchange();
}

void DefeKept::drop()
{
  kept = std::vector<Forces>();
  sys.store.update_maxexchange();
}

/* ----------------------------------------------------------------------
   the first step of a run, for which there may have been no setup (run ... pre no)
------------------------------------------------------------------------- */

void DefeKept::begin_run()
{
  const bigint step = update->ntimestep - 1;
  if (update->whichflag != 1)
    error->all(
        FLERR,
        "Fix defe: a run, rerun or minimize among the commands of 'run ... every' has ended the "
        "run around it at step {}, and LAMMPS would go on without a setup: write the pieces one "
        "after the other, in a loop ('label', 'run', 'next', 'jump')",
        step);
  int changed = needs_setup || (!kept.empty() && !places_are_those()) ? 1 : 0, any = 0;
  MPI_Allreduce(&changed, &any, 1, MPI_INT, MPI_MAX, world);
  if (any)
    error->all(
        FLERR,
        "Fix defe: since the last run (step {}) commands have moved, made or deleted atoms, or "
        "sorted them anew as minimize, write_restart and write_data do, and 'run ... pre no' "
        "would go on with forces and neighbours of before: leave out 'pre no'",
        step);
  running_ = true;
  sys.account.begin_run();
  sys.clock.follow(step);
  if (sys.checks.step_changed()) sys.checks.time_step(false);
  if (!kept.empty()) drop();
}

/* ---------------------------------------------------------------------- */

bool DefeKept::places_are_those() const
{
  if (now.natoms != atom->natoms || (kept.empty() && atom->nlocal > 0)) return false;
  for (int i = 0; i < atom->nlocal; i++) {
    double x[3];
    domain->unmap(atom->x[i], atom->image[i], x);
    for (int k = 0; k < 3; k++)
      if (!(std::abs(x[k] - kept[i].x[k]) <= 1.0e-10 * sys.mesh.max_diagonal())) return false;
  }
  return true;
}

/* ---------------------------------------------------------------------- */

void DefeKept::take()
{
  if (now.step == update->ntimestep && now.natoms == atom->natoms && now.law == laws()) {
    int same = places_are_those() ? 1 : 0, all = 0;
    for (int i = 0; i < atom->nlocal && same; i++)
      if (kept[i].motion != motion_of(i)) same = 0;
    MPI_Allreduce(&same, &all, 1, MPI_INT, MPI_MIN, world);
    for (int i = 0; i < atom->nlocal && all; i++) {
      std::copy_n(kept[i].f, 3, atom->f[i]);
      std::copy_n(kept[i].torque, 3, atom->torque[i]);
    }
  }
  drop();
}

/* ----------------------------------------------------------------------
   forces of the last step stay those of the last step when the clock is set
------------------------------------------------------------------------- */

void DefeKept::follow(bigint last_step, bigint step)
{
  if (now.step == last_step) now.step = step;
}

double DefeKept::memory_usage() const
{
  return kept.capacity() * sizeof(Forces);
}

/* ----------------------------------------------------------------------
   as a field of the store
------------------------------------------------------------------------- */

void DefeKept::clear(int i)
{
  if (!kept.empty()) kept[i].motion = 0;
}

void DefeKept::grow(int n)
{
  room = n;
  if (!kept.empty()) kept.resize(n);
}

void DefeKept::move(int from, int to)
{
  if (!kept.empty()) kept[to] = kept[from];
}

int DefeKept::pack(int i, double *buf) const
{
  buf[0] = ubuf(has(i) ? 1 : 0).d;
  if (has(i)) memcpy(static_cast<void *>(&buf[1]), &kept[i], sizeof(Forces));
  return size(i);
}

int DefeKept::unpack(int i, const double *buf)
{
  if (ubuf(buf[0]).i == 0) {
    clear(i);
    return 1;
  }
  kept.resize(room);
  memcpy(static_cast<void *>(&kept[i]), &buf[1], sizeof(Forces));
  return 1 + SIZE;
}
