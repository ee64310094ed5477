/* ----------------------------------------------------------------------
   DEFE: adaptive finite elements to bonded discrete elements for LAMMPS
   https://www.lammps.org/
   This software is distributed under the GNU General Public License.
------------------------------------------------------------------------- */

// The event file: conversions and joints that change state. A restart goes on with the file only if it
// begins with just what the run had written up to the restart file: its length and checksum are in there.
// The head names run and mesh, so that a file of another run can be told from one that was cut.

#include "fix_defe.h"

#include "atom.h"
#include "comm.h"
#include "domain.h"
#include "error.h"
#include "update.h"

#include <algorithm>
#include <cstring>
#include <memory>
#include <system_error>

#include <sys/stat.h>
#include <unistd.h>

using namespace LAMMPS_NS;

static constexpr char HEAD[] = "# DEFE events: run ";
static constexpr char OLD_HEAD[] = "# step time event ";    // of files without names

using File = std::unique_ptr<FILE, int (*)(FILE *)>;

/* ---------------------------------------------------------------------- */

void FixDefe::record_event(const Event &e)
{
  if (!event_file.empty()) events.push_back(e);
}

/* ----------------------------------------------------------------------
   names of the run and of its mesh: checksums of how they begin, the same on any number of ranks
------------------------------------------------------------------------- */

void FixDefe::name_run()
{
  if (event_file.empty() || written.run) return;
  uint64_t mine[2] = {0, 0}, all[2];
  bigint elements = 0;
  for (int i = 0; i < atom->nlocal; i++) {
    defe::Checksum one;
    double x[3];
    domain->unmap(atom->x[i], atom->image[i], x);
    one.add(x, sizeof(x));
    one.add(atom->v[i], 3 * sizeof(double));
    one.add(&atom->radius[i], sizeof(double));
    const int64_t integers[2] = {atom->tag[i], atom->type[i]};
    one.add(integers, sizeof(integers));
    mine[0] += one.value();
    for (const auto &h : hexes[i]) {
      defe::Checksum hex;
      const int64_t names[2] = {h.id, h.part};
      hex.add(names, sizeof(names));
      hex.add(h.node, sizeof(h.node));
      hex.add(xref[i], 3 * sizeof(double));
      mine[1] += hex.value();
      elements++;
    }
  }
  MPI_Allreduce(mine, all, 2, MPI_UINT64_T, MPI_SUM, world);
  MPI_Allreduce(&elements, &written.elements, 1, MPI_LMP_BIGINT, MPI_SUM, world);
  defe::Checksum run;
  run.add(all, sizeof(all));
  const uint64_t laws = kept_laws();
  run.add(&laws, sizeof(laws));
  for (const auto &p : parts) {
    const std::string text = describe_part(p);
    run.add(text.c_str(), text.size() + 1);
    run.add(&p.stress, sizeof(double));
  }
  run.add(&update->dt, sizeof(double));
  written.run = run.value() | 1;    // 0: it has no name
  written.mesh = all[1];
}

/* ----------------------------------------------------------------------
   on the first rank, before anything is written: what is wrong with a file of this name, "" if it may be
   overwritten, or go on from the restart file
------------------------------------------------------------------------- */

std::string FixDefe::complaint_of_events()
{
  struct stat info;
  const bool exists = stat(event_file.c_str(), &info) == 0;
  if (exists && !S_ISREG(info.st_mode)) return "";
  const std::string another = "or give another name to the keyword events";

  const bool goes_on = events_continued && !written.name.empty();
  if (!exists)
    return goes_on && written.name == event_file
        ? fmt::format("Fix defe: event file {} of the run that the restart file is of is missing: "
                      "put it back, {}",
                      event_file, another)
        : "";
  const File file(fopen(event_file.c_str(), "rb"), fclose);
  if (!file) return "";    // opening it for writing says why
  char line[256] = "";
  const bool empty = !fgets(line, sizeof(line), file.get());
  const bool ours = utils::strmatch(line, std::string("^") + HEAD) ||
      utils::strmatch(line, std::string("^") + OLD_HEAD);

  if (!goes_on) {
    if (empty) return "";
    if (!ours)
      return fmt::format("Fix defe: file {} is there and is no event file: remove it, {}",
                         event_file, another);
    return events_continued ? fmt::format("Fix defe: event file {} is there, but the run of the "
                                          "restart file wrote no events: remove it, {}",
                                          event_file, another)
                            : "";
  }

  const std::string should =
      fmt::format("that of run {:016x} with a mesh of {} elements", written.run, written.elements);
  if (!ours)
    return fmt::format("Fix defe: file {} is no event file: put back {}, {}", event_file, should,
                       another);
  const std::string head = fmt::format("{}{:016x}", HEAD, written.run);
  if (strncmp(line, head.c_str(), head.size()) != 0)
    return fmt::format("Fix defe: event file {} is of another run: put back {}, {}", event_file,
                       should, another);
  if (info.st_size < written.bytes)
    return fmt::format("Fix defe: event file {} has {} of the {} bytes that it had at step {} of "
                       "the restart file: events are missing; put back the whole file, {}",
                       event_file, info.st_size, written.bytes, restart_step, another);
  rewind(file.get());
  defe::Checksum sum;
  std::vector<char> buffer(1 << 16);
  bigint left = written.bytes;
  while (left > 0) {
    const size_t n = MIN(left, static_cast<bigint>(buffer.size()));
    if (fread(buffer.data(), 1, n, file.get()) != n) break;
    sum.add(buffer.data(), n);
    left -= static_cast<bigint>(n);
  }
  if (left || sum.value() != written.sum_of_restart)
    return fmt::format("Fix defe: event file {} is not as it was at step {} of the restart file "
                       "(its checksum is wrong): put back the file of that run, {}",
                       event_file, restart_step, another);
  written.sum = sum;
  return "";
}

/* ----------------------------------------------------------------------
   before the first write: the file is looked at and cut to where the restart file was written, since what
   the interrupted run wrote after that happens again. Collective.
------------------------------------------------------------------------- */

void FixDefe::open_events()
{
  name_run();
  std::string complaint;
  if (comm->me == 0) complaint = complaint_of_events();
  stop_by_first_rank(complaint);
  event_header = true;
  if (comm->me == 0) {
    struct stat info;
    const bool there = stat(event_file.c_str(), &info) == 0 && S_ISREG(info.st_mode);
    if (events_continued && !written.name.empty() && there) {
      if (info.st_size > written.bytes && truncate(event_file.c_str(), written.bytes))
        complaint = fmt::format("Fix defe cannot write its event file {}: {}", event_file,
                                utils::getsyserror());
    } else {
      const bool later = events_continued && written.lines > 0;
      std::string head = fmt::format("{}{:016x}, mesh of {} elements with checksum {:016x}\n", HEAD,
                                     written.run, written.elements, written.mesh);
      if (later)
        head += fmt::format("# from step {} on; {} events before are in {}\n", restart_step,
                            written.lines, written.name);
      head += "# step time event id id2 X Y Z nx ny nz value\n"
              "# event convert: id = element, id2 = part, X = reference centre, value = mass\n"
              "# event cohesive, broken: id, id2 = the two DEs, X = reference middle of the "
              "joint, n = reference direction, value = equivalent traction, or damage (1)\n"
              "# event adhesive, debonded: the same of a tie, id = DE, id2 = element, X = "
              "reference point on its face\n";
      written.bytes = 0;
      written.sum = defe::Checksum();
      complaint = write_events(head, "w");
    }
  }
  events_continued = false;
  written.name = event_file;
  stop_by_first_rank(complaint);
}

/* ---------------------------------------------------------------------- */

std::string FixDefe::write_events(const std::string &text, const char *mode)
{
  FILE *fp = fopen(event_file.c_str(), mode);
  bool good = fp && fwrite(text.data(), 1, text.size(), fp) == text.size();
  if (fp && fclose(fp)) good = false;
  if (!good)
    return fmt::format("Fix defe cannot write its event file {}: {}", event_file,
                       utils::getsyserror());
  written.sum.add(text.data(), text.size());
  written.bytes += static_cast<bigint>(text.size());
  return "";
}

void FixDefe::stop_by_first_rank(std::string complaint)
{
  int n = static_cast<int>(complaint.size());
  MPI_Bcast(&n, 1, MPI_INT, 0, world);
  if (n == 0) return;
  complaint.resize(n);
  MPI_Bcast(&complaint[0], n, MPI_CHAR, 0, world);
  error->all(FLERR, complaint);
}

/* ---------------------------------------------------------------------- */

void FixDefe::flush_events()
{
  if (event_file.empty()) return;
  if (!event_header) open_events();
  const int bytes = static_cast<int>(events.size() * sizeof(Event));
  std::vector<int> count(comm->nprocs), offset(comm->nprocs);
  MPI_Gather(&bytes, 1, MPI_INT, count.data(), 1, MPI_INT, 0, world);
  std::vector<Event> all;
  if (comm->me == 0) {
    int sum = 0;
    for (int p = 0; p < comm->nprocs; p++) {
      offset[p] = sum;
      sum += count[p];
    }
    all.resize(sum / sizeof(Event));
  }
  MPI_Gatherv(events.data(), bytes, MPI_BYTE, all.data(), count.data(), offset.data(), MPI_BYTE, 0,
              world);
  events.clear();

  std::string complaint;
  if (!all.empty()) {
    std::sort(all.begin(), all.end(), [](const Event &a, const Event &b) {
      if (a.step != b.step) return a.step < b.step;
      if (a.what != b.what) return a.what < b.what;
      return a.a != b.a ? a.a < b.a : a.b < b.b;
    });
    static const char *const name[] = {"convert", "cohesive", "broken", "adhesive", "debonded"};
    std::string text;
    for (const auto &e : all)
      text += fmt::format("{} {:.9g} {} {} {} {:.9g} {:.9g} {:.9g} {:.4g} {:.4g} {:.4g} {:.6g}\n",
                          e.step, e.time, name[e.what], e.a, e.b, e.x[0], e.x[1], e.x[2], e.n[0],
                          e.n[1], e.n[2], e.value);
    complaint = write_events(text, "a");
    written.lines += static_cast<bigint>(all.size());
  }
  stop_by_first_rank(complaint);
}
