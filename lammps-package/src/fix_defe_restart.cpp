/* ----------------------------------------------------------------------
   DEFE: adaptive finite elements to bonded discrete elements for LAMMPS
   https://www.lammps.org/
   This software is distributed under the GNU General Public License.
------------------------------------------------------------------------- */

// Restart files. What is DEFE's in them is checked in two ways: the file as a whole by its seal,
// before anything of it is used (see defe_restart_file.h), and here the record of each atom, with the
// motion that LAMMPS keeps of it, by a checksum, and all records by the sum of their checksums. That
// sum depends neither on ranks nor on order. It is there without a pair style of DEFE, too, and finds
// records that came to the wrong atom in memory.

#include "fix_defe.h"

#include "defe_restart_file.h"

#include "atom.h"
#include "comm.h"
#include "domain.h"
#include "error.h"
#include "modify.h"
#include "update.h"

#include "defe/coupling/checksum.h"

#include <cmath>
#include <cstring>

using namespace LAMMPS_NS;

static constexpr int BESIDE_RECORD = 2;    // doubles: the step, the checksum

/* ----------------------------------------------------------------------
   of a record, and of what LAMMPS writes of its atom. Not of its groups: they may
   be defined anew before this fix.
------------------------------------------------------------------------- */

uint64_t FixDefe::restart_checksum(int i, const double *record, int n) const
{
  // positions are remapped into the box when the file is read: a second time changes nothing

  double x[3] = {atom->x[i][0], atom->x[i][1], atom->x[i][2]};
  imageint image = atom->image[i];
  if (std::isfinite(x[0]) && std::isfinite(x[1]) && std::isfinite(x[2])) domain->remap(x, image);

  defe::Checksum sum;
  sum.add(record, sizeof(double) * n);
  sum.add(x, sizeof(x));
  sum.add(atom->v[i], 3 * sizeof(double));
  sum.add(atom->omega[i], 3 * sizeof(double));
  sum.add(&atom->radius[i], sizeof(double));
  sum.add(&atom->rmass[i], sizeof(double));
  const int64_t integers[3] = {atom->tag[i], atom->type[i], static_cast<int64_t>(image)};
  sum.add(integers, sizeof(integers));
  return sum.value();
}

/* ----------------------------------------------------------------------
   the same record as in an exchange with each atom, the cumulative energies once
------------------------------------------------------------------------- */

int FixDefe::pack_restart(int i, double *buf)
{
  // the step tells files of different restarts apart, of which a set may be left by a run that was
  // killed
  int m = pack_record(i, buf);
  buf[m++] = ubuf(update->ntimestep).d;
  buf[0] = m + 1;    // as LAMMPS wants it
  const uint64_t sum = restart_checksum(i, buf, m);
  memcpy(&buf[m++], &sum, sizeof(sum));
  return m;
}

void FixDefe::unpack_restart(int i, int nth)
{
  // the records of all fixes come one after the other, each with its size at the front: sizes are
  // not believed beyond the room that LAMMPS has

  const double *extra = atom->extra[i];
  const int room = atom->nextra_store;
  int m = 0;
  auto size_at = [&](int m) {
    const bool good = m < room && extra[m] >= 1.0 && extra[m] <= room - m;
    return good ? static_cast<int>(extra[m]) : 0;
  };
  bool good = true;
  for (int k = 0; k < nth && good; k++) {
    const int size = size_at(m);
    m += size;
    good = size > 0;
  }
  const double *record = extra + m;
  const int size = good ? size_at(m) : 0;
  uint64_t sum = 0;
  if (size > BESIDE_RECORD) memcpy(&sum, &record[size - 1], sizeof(sum));
  if (size <= BESIDE_RECORD || sum != restart_checksum(i, record, size - 1)) {
    if (restart_check.damaged++ == 0 || atom->tag[i] < restart_check.first)
      restart_check.first = atom->tag[i];
    set_arrays(i);    // check_restart() ends this
    return;
  }
  restart_check.records++;
  restart_check.sum += sum;
  unpack_record(i, record);

  const auto step = static_cast<bigint>(ubuf(record[size - 2]).i);
  if (step != restart_step) {
    restart_check.other_steps++;
    restart_check.other_step = MAX(restart_check.other_step, step);
  }
}

int FixDefe::size_restart(int i)
{
  return record_size(i) + BESIDE_RECORD;
}

int FixDefe::maxsize_restart()
{
  return restart_maxsize;
}

/* ----------------------------------------------------------------------
   LAMMPS gives a new fix what a restart file has for it, and then asks for its mask: the
   last moment before others build on that. Collective, as the fix command is.
------------------------------------------------------------------------- */

namespace {

/// The fixes that a restart file had something for; LAMMPS shows only their number.
struct FixesOfFile : Modify {
  using Modify::Modify;
  static std::string other_id(Modify *modify, const char *style, const char *id)
  {
    for (int k = 0; k < modify->nfix_restart_global; k++) {
      const std::string found = (modify->*(&FixesOfFile::id_restart_global))[k];
      if ((modify->*(&FixesOfFile::used_restart_global))[k] == 0 && found != id &&
          strcmp((modify->*(&FixesOfFile::style_restart_global))[k], style) == 0)
        return found;
    }
    return "";
  }
};

}    // namespace

void FixDefe::check_restart()
{
  if (!restart_reset) {
    const std::string other = FixesOfFile::other_id(modify, style, id);
    if (!other.empty())
      error->all(FLERR,
                 "The restart file has the elements of fix {} defe, but this fix has the ID {}: "
                 "give it the ID {}",
                 other, id, other);
    return;
  }
  if (!restart_check.unread) return;
  restart_check.unread = false;

  const auto &c = restart_check;
  bigint mine[3] = {c.records, c.damaged, c.other_steps}, all[3];
  MPI_Allreduce(mine, all, 3, MPI_LMP_BIGINT, MPI_SUM, world);
  bigint last[2] = {c.damaged ? -static_cast<bigint>(c.first) : -MAXBIGINT, c.other_step}, most[2];
  MPI_Allreduce(last, most, 2, MPI_LMP_BIGINT, MPI_MAX, world);
  uint64_t sum;
  MPI_Allreduce(&c.sum, &sum, 1, MPI_UINT64_T, MPI_SUM, world);
  if (all[1])
    error->all(FLERR,
               "Checksums of {} atoms do not fit what was read, the first is atom {}: the restart "
               "file is damaged (use an older one), or the atoms were changed between read_restart "
               "and fix defe (do that after fix defe)",
               all[1], -most[0]);
  if (all[2])
    error->all(FLERR,
               "Restart files do not belong together: {} atoms are of step {}, the base file of "
               "step {}; use an older set of files",
               all[2], most[1], restart_step);
  if (all[0] != c.records_of_file || sum != c.sum_of_file)
    error->all(
        FLERR,
        "The {} atoms are not the {} of the restart file: it is damaged or of two runs (use "
        "an older one), or atoms were added or deleted between read_restart and fix defe (do "
        "that after fix defe)",
        all[0], c.records_of_file);
}

/* ---------------------------------------------------------------------- */

namespace {
struct GlobalState {
  char format[8];
  double ledger[defe::EnergyLedger::size];
  bigint des_total, hexes_total, conversions_total;
  tagint de_base, last_element, last_id, last_born;
  int lots_moved, start_done, hexes_per_node;
  double dt_finite, dt_discrete, dt_joints, max_diagonal, max_facet, first_conversion, first_damage;
  double largest_force;
  bigint through, nodes_total, des_gone, kept_step, kept_natoms;
  bigint step, events_lines, events_bytes, events_elements;
  defe::Subcycle::State subcycle;
  double mass_total, mass_gone, max_step_length;
  bigint records;    // of atoms, and the sum of their checksums
  uint64_t records_sum, kept_law, events_run, events_mesh, events_sum;
  uint64_t after, after_sum;    // bytes that follow, and their checksum
  uint64_t own_sum;             // of all this, with 0 here
};

uint64_t own_sum(GlobalState g)
{
  g.own_sum = 0;
  return defe::checksum(&g, sizeof(g));
}
}    // namespace

void FixDefe::write_restart(FILE *fp)
{
  flush_events();    // else those up to here would be missing when the run is killed later
  if (running) keep_forces();

  double mine[defe::EnergyLedger::size];
  ledger.pack(mine);
  GlobalState g;
  memset(static_cast<void *>(&g), 0, sizeof(g));    // gaps, too: they are in the checksum
  memcpy(g.format, RESTART_FORMAT, sizeof(RESTART_FORMAT));

  // the largest record is asked of rank 0 alone, after this

  int largest = BESIDE_RECORD + 1;
  const bigint nlocal = atom->nlocal;
  uint64_t sum = 0;
  for (int i = 0; i < nlocal; i++) {
    const int size = size_restart(i);
    if (size > static_cast<int>(scratch.size())) scratch.resize(size);
    pack_restart(i, scratch.data());
    uint64_t one;
    memcpy(&one, &scratch[size - 1], sizeof(one));
    sum += one;
    largest = MAX(largest, size);
  }
  MPI_Allreduce(&largest, &restart_maxsize, 1, MPI_INT, MPI_MAX, world);
  MPI_Reduce(&sum, &g.records_sum, 1, MPI_UINT64_T, MPI_SUM, 0, world);
  MPI_Reduce(&nlocal, &g.records, 1, MPI_LMP_BIGINT, MPI_SUM, 0, world);

  MPI_Reduce(mine, g.ledger, defe::EnergyLedger::size, MPI_DOUBLE, MPI_SUM, 0, world);
  MPI_Reduce(&mass_gone, &g.mass_gone, 1, MPI_DOUBLE, MPI_SUM, 0, world);
  MPI_Reduce(&des_gone, &g.des_gone, 1, MPI_LMP_BIGINT, MPI_SUM, 0, world);
  MPI_Reduce(&through_count, &g.through, 1, MPI_LMP_BIGINT, MPI_SUM, 0, world);
  g.nodes_total = nodes_total;
  g.mass_total = mass_total;
  g.max_step_length = max_step_length;
  g.subcycle = subcycle.state();
  g.kept_step = kept_step;
  g.kept_law = kept_law;
  g.step = update->ntimestep;
  const defe::EventLog::Written written = event_log.written();
  g.events_lines = written.lines;
  g.events_bytes = written.bytes;
  g.events_elements = written.elements;
  g.events_run = written.run;
  g.events_mesh = written.mesh;
  g.events_sum = written.sum;
  g.kept_natoms = kept_natoms;
  g.des_total = des_total;
  g.hexes_total = hexes_total;
  g.conversions_total = conversions_total;
  double first[2] = {first_conversion, first_damage}, both[2];
  for (auto &t : first)
    if (t < 0.0) t = HUGE_VAL;
  MPI_Allreduce(first, both, 2, MPI_DOUBLE, MPI_MIN, world);
  g.first_conversion = both[0] == HUGE_VAL ? -1.0 : both[0];
  g.first_damage = both[1] == HUGE_VAL ? -1.0 : both[1];
  g.de_base = de_base;
  g.last_element = last_element;
  g.last_id = last_id;
  g.last_born = last_born;
  g.lots_moved = lots_moved;
  g.start_done = start_done;
  g.hexes_per_node = hexes_per_node;
  g.dt_finite = dt_finite;
  g.dt_discrete = dt_discrete;
  g.dt_joints = dt_joints;
  g.max_diagonal = max_diagonal;
  g.max_facet = max_facet;
  g.largest_force = largest_force;
  if (comm->me == 0) {
    const std::string rest = pack_script();
    g.after = rest.size();
    g.after_sum = defe::checksum(rest.data(), rest.size());
    g.own_sum = own_sum(g);
    const int bytes = static_cast<int>(sizeof(GlobalState) + rest.size());
    fwrite(&bytes, sizeof(int), 1, fp);
    fwrite(&g, sizeof(GlobalState), 1, fp);
    fwrite(rest.data(), 1, rest.size(), fp);
  }
}

void FixDefe::restart(char *buf)
{
  GlobalState g;
  memcpy(static_cast<void *>(&g), buf, sizeof(GlobalState));
  if (memcmp(g.format, RESTART_FORMAT, sizeof(RESTART_FORMAT)) != 0)
    error->all(FLERR,
               "The restart file was written by another version of fix defe, or is damaged: go on "
               "with that version, or use an older file");
  buf += sizeof(GlobalState);
  if (g.own_sum != own_sum(g) || g.after_sum != defe::checksum(buf, g.after))
    error->all(
        FLERR,
        "The restart file is damaged: the checksum of fix defe's part is wrong; use an older "
        "file");
  restart_check = RestartCheck();
  restart_check.unread = true;
  restart_check.records_of_file = g.records;
  restart_check.sum_of_file = g.records_sum;
  defe::EventLog::Written written;
  written.name = unpack_script(buf, g.after);
  if (comm->me == 0) {
    ledger.unpack(g.ledger);
    through_count = g.through;
    mass_gone = g.mass_gone;
    des_gone = g.des_gone;
  }
  if (!subcycle.go_on(g.subcycle))
    error->all(
        FLERR,
        "Fix defe in the restart file had every {}, now every {}: change it only at a step at "
        "which both clocks meet (a multiple of {})",
        g.subcycle.every, subcycle.every(), g.subcycle.every);
  nodes_total = g.nodes_total;
  mass_total = g.mass_total;
  max_step_length = g.max_step_length;
  kept_step = g.kept_step;
  kept_law = g.kept_law;
  restart_step = last_step = g.step;
  written.lines = g.events_lines;
  written.bytes = g.events_bytes;
  written.elements = g.events_elements;
  written.run = g.events_run;
  written.mesh = g.events_mesh;
  written.sum = g.events_sum;
  event_log.go_on(written, restart_step);
  kept_natoms = g.kept_natoms;
  des_total = g.des_total;
  hexes_total = g.hexes_total;
  conversions_total = g.conversions_total;
  first_conversion = g.first_conversion;
  first_damage = g.first_damage;
  de_base = g.de_base;
  last_element = g.last_element;
  last_id = g.last_id;
  last_born = g.last_born;
  lots_moved = g.lots_moved;
  start_done = g.start_done;
  notes_due = !start_done;
  overlaps_told = balls_placed = start_done;
  through_told = g.through > 0;
  hexes_per_node = g.hexes_per_node;
  dt_finite = g.dt_finite;
  dt_discrete = g.dt_discrete;
  dt_joints = g.dt_joints;
  max_diagonal = g.max_diagonal;
  max_facet = g.max_facet;
  largest_force = g.largest_force;
  mesh_dirty = false;
}

/* ----------------------------------------------------------------------
   after LAMMPS has written a restart file: it is looked at, and sealed
------------------------------------------------------------------------- */

void FixDefe::write_restart_file(const char *name)
{
  if (running) drop_kept_forces();
  seal_restart_file(lmp, name);
}
