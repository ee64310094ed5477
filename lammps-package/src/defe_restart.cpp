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

#include "defe_restart_file.h"
#include "defe_system.h"

#include "atom.h"
#include "comm.h"
#include "domain.h"
#include "error.h"
#include "fix.h"
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

uint64_t DefeRestart::checksum_of(int i, const double *record, int n) const
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

int DefeRestart::pack(int i, double *buf) const
{
  // the step tells files of different restarts apart, of which a set may be left by a run that was
  // killed
  int m = sys.store.pack(i, buf);
  buf[m++] = ubuf(update->ntimestep).d;
  buf[0] = m + 1;    // as LAMMPS wants it
  const uint64_t sum = checksum_of(i, buf, m);
  memcpy(&buf[m++], &sum, sizeof(sum));
  return m;
}

bool DefeRestart::unpack(int i, int nth)
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
  if (size <= BESIDE_RECORD || sum != checksum_of(i, record, size - 1)) {
    if (read_.damaged++ == 0 || atom->tag[i] < read_.first) read_.first = atom->tag[i];
    return false;
  }
  read_.records++;
  read_.sum += sum;
  sys.store.unpack(i, record);

  const auto its_step = static_cast<bigint>(ubuf(record[size - 2]).i);
  if (its_step != step) {
    read_.other_steps++;
    read_.other_step = MAX(read_.other_step, its_step);
  }
  return true;
}

int DefeRestart::size(int i) const
{
  return sys.store.record_size(i) + BESIDE_RECORD;
}

/* ----------------------------------------------------------------------
   LAMMPS hands a new fix its data of the restart file and then asks for its mask: the last moment before
   others rely on the data. Collective, as the fix command is.
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

void DefeRestart::check()
{
  if (!sys.host->restart_reset) {
    const char *id = sys.host->id;
    const std::string other = FixesOfFile::other_id(modify, sys.host->style, id);
    if (!other.empty())
      error->all(FLERR,
                 "The restart file has the elements of fix {} defe, but this fix has the ID {}: "
                 "give it the ID {}",
                 other, id, other);
    return;
  }
  if (!read_.unchecked) return;
  read_.unchecked = false;

  const auto &c = read_;
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
               all[2], most[1], step);
  if (all[0] != c.records_of_file || sum != c.sum_of_file)
    error->all(
        FLERR,
        "The {} atoms are not the {} of the restart file: it is damaged or of two runs (use "
        "an older one), or atoms were added or deleted between read_restart and fix defe (do "
        "that after fix defe)",
        all[0], c.records_of_file);
}

/* ----------------------------------------------------------------------
   what is kept of the run as a whole: the state of each component that has one
------------------------------------------------------------------------- */

namespace {

struct GlobalState {
  char format[8];
  double ledger[defe::EnergyLedger::size];
  DefeCensus::State census;
  DefeIds::State ids;
  DefeMesh::State mesh;
  DefeAccount::State first;
  DefeKept::State kept;
  defe::Subcycle::State subcycle;
  bigint step, start_done, let_through;
  bigint events_lines, events_bytes, events_elements;
  uint64_t events_run, events_mesh, events_sum;
  bigint records;    // of atoms, and the sum of their checksums
  uint64_t records_sum;
  uint64_t after, after_sum;    // bytes that follow, and their checksum
  uint64_t own_sum;             // of all this, with 0 here
};

uint64_t own_sum(GlobalState g)
{
  g.own_sum = 0;
  return defe::checksum(&g, sizeof(g));
}

void put_events(GlobalState &g, const defe::EventLog::Written &written)
{
  g.events_lines = written.lines;
  g.events_bytes = written.bytes;
  g.events_elements = written.elements;
  g.events_run = written.run;
  g.events_mesh = written.mesh;
  g.events_sum = written.sum;
}

defe::EventLog::Written events_of(const GlobalState &g)
{
  defe::EventLog::Written written;
  written.lines = g.events_lines;
  written.bytes = g.events_bytes;
  written.elements = g.events_elements;
  written.run = g.events_run;
  written.mesh = g.events_mesh;
  written.sum = g.events_sum;
  return written;
}

}    // namespace

void DefeRestart::write(FILE *fp)
{
  sys.events.flush();    // else those up to here would be missing when the run is killed later
  if (sys.kept.running()) sys.kept.keep();

  GlobalState g;
  memset(static_cast<void *>(&g), 0, sizeof(g));    // gaps, too: they are in the checksum
  memcpy(g.format, RESTART_FORMAT, sizeof(RESTART_FORMAT));
  add_records(g.records_sum, g.records);

  double mine[defe::EnergyLedger::size];
  sys.ledger.pack(mine);
  MPI_Reduce(mine, g.ledger, defe::EnergyLedger::size, MPI_DOUBLE, MPI_SUM, 0, world);
  sys.census.pack(g.census);
  sys.ids.pack(g.ids);
  sys.mesh.pack(g.mesh);
  sys.account.pack(g.first);
  sys.kept.pack(g.kept);
  g.subcycle = sys.clock.subcycle().state();
  g.step = update->ntimestep;
  g.start_done = sys.conversion.start_done();
  g.let_through = sys.surface.all_let_through();
  put_events(g, sys.events.written());
  if (comm->me) return;
  const std::string rest = sys.script.pack();
  g.after = rest.size();
  g.after_sum = defe::checksum(rest.data(), rest.size());
  g.own_sum = own_sum(g);
  const int bytes = static_cast<int>(sizeof(GlobalState) + rest.size());
  fwrite(&bytes, sizeof(int), 1, fp);
  fwrite(&g, sizeof(GlobalState), 1, fp);
  fwrite(rest.data(), 1, rest.size(), fp);
}

/* ----------------------------------------------------------------------
   all records and their sum, on the first rank, which alone is asked for the largest one afterwards
------------------------------------------------------------------------- */

void DefeRestart::add_records(uint64_t &all_sums, bigint &records)
{
  int most = BESIDE_RECORD + 1;
  const bigint nlocal = atom->nlocal;
  uint64_t sum = 0;
  std::vector<double> record;
  for (int i = 0; i < nlocal; i++) {
    const int n = size(i);
    if (n > static_cast<int>(record.size())) record.resize(n);
    pack(i, record.data());
    uint64_t one;
    memcpy(&one, &record[n - 1], sizeof(one));
    sum += one;
    most = MAX(most, n);
  }
  MPI_Allreduce(&most, &largest_, 1, MPI_INT, MPI_MAX, world);
  MPI_Reduce(&sum, &all_sums, 1, MPI_UINT64_T, MPI_SUM, 0, world);
  MPI_Reduce(&nlocal, &records, 1, MPI_LMP_BIGINT, MPI_SUM, 0, world);
}

void DefeRestart::read(const char *buf)
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
  read_ = Read();
  read_.unchecked = true;
  read_.records_of_file = g.records;
  read_.sum_of_file = g.records_sum;
  auto written = events_of(g);
  written.name = sys.script.unpack(buf, g.after);
  auto &subcycle = sys.clock.subcycle();
  if (!subcycle.go_on(g.subcycle))
    error->all(
        FLERR,
        "Fix defe in the restart file had every {}, now every {}: change it only at a step at "
        "which both clocks meet (a multiple of {})",
        g.subcycle.every, subcycle.every(), g.subcycle.every);
  if (comm->me == 0) sys.ledger.unpack(g.ledger);
  sys.census.unpack(g.census);
  sys.ids.unpack(g.ids);
  sys.mesh.unpack(g.mesh);
  sys.account.unpack(g.first);
  sys.kept.unpack(g.kept);
  step = g.step;
  sys.clock.restarted_at(step);
  sys.events.go_on(written, step);
  const bool started = g.start_done != 0;
  sys.conversion.go_on(started);
  sys.notes.go_on(started);
  sys.surface.go_on(g.let_through, started);
}

/* ----------------------------------------------------------------------
   after LAMMPS has written a restart file: it is checked and sealed
------------------------------------------------------------------------- */

void DefeRestart::written(const char *name)
{
  if (sys.kept.running()) sys.kept.drop();
  seal_restart_file(lmp, name);
}
