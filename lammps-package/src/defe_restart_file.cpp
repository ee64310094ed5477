/* ----------------------------------------------------------------------
   DEFE: adaptive finite elements to bonded discrete elements for LAMMPS
   https://www.lammps.org/
   This software is distributed under the GNU General Public License.
------------------------------------------------------------------------- */

#include "defe_restart_file.h"

#include "defe_records.h"

#include "comm.h"
#include "error.h"
#include "input.h"
#include "lammps.h"
#include "lmprestart.h"
#include "platform.h"
#include "utils.h"

#include "defe/coupling/seal.h"

#include <cstdint>
#include <cstring>
#include <memory>
#include <vector>

using namespace LAMMPS_NS;

namespace {

const std::string magic(MAGIC_STRING, sizeof(MAGIC_STRING));    // LAMMPS looks for it at the end

using File = std::unique_ptr<FILE, int (*)(FILE *)>;

File open_file(const std::string &name, const char *mode)
{
  return File(fopen(name.c_str(), mode), fclose);
}

std::string file_of_set(const std::string &pattern, const std::string &which)
{
  std::string name = pattern;
  return name.replace(name.find('%'), 1, which);
}

/// The rank that reads file k of n: LAMMPS' own choice, so that a file that only one rank can see is
/// looked at by that one.
int rank_of_file(int64_t k, int64_t n, int64_t nprocs)
{
  return static_cast<int>(n >= nprocs ? k % nprocs : (k * nprocs + n - 1) / n);
}

void broadcast(std::string &text, int root, MPI_Comm world)
{
  int n = static_cast<int>(text.size());
  MPI_Bcast(&n, 1, MPI_INT, root, world);
  text.resize(n);
  if (n) MPI_Bcast(&text[0], n, MPI_CHAR, root, world);
}

/// Collective: if a rank has a complaint, all ranks stop with the first one's.
void stop_if_any(LAMMPS *lmp, std::string complaint)
{
  const int me = lmp->comm->me;
  int mine = complaint.empty() ? lmp->comm->nprocs : me, first;
  MPI_Allreduce(&mine, &first, 1, MPI_INT, MPI_MIN, lmp->world);
  if (first == lmp->comm->nprocs) return;
  broadcast(complaint, first, lmp->world);
  lmp->error->all(FLERR, complaint);
}

/// Number of files beside a base file, from what LAMMPS writes last into it; 0: it is not that.
int files_of_base(FILE *fp)
{
  int last[3];    // flag of the layout, number of files, end of the layout
  const long size = sizeof(last) + magic.size();
  if (fseek(fp, -size, SEEK_END) || fread(last, sizeof(int), 3, fp) != 3) return 0;
  return last[0] == MULTIPROC && last[2] == -1 && last[1] > 0 ? last[1] : 0;
}

}    // namespace

/* ----------------------------------------------------------------------
   LAMMPS looks for errors before it closes a restart file, when its end may not yet be on the
   disk: look at the end itself. The seal comes last: what was not finished has none.
------------------------------------------------------------------------- */

void LAMMPS_NS::seal_restart_file(LAMMPS *lmp, const std::string &pattern)
{
  const int me = lmp->comm->me, nprocs = lmp->comm->nprocs;
  const bool set = pattern.find('%') != std::string::npos;
  const std::string base = set ? file_of_set(pattern, "base") : pattern;
  auto incomplete = [](const std::string &file) {
    return "Restart file " + file + " is incomplete: is the disk full?";
  };

  File file(nullptr, fclose);
  std::string complaint;
  int nfiles = 0;
  if (me == 0) {
    file = open_file(base, "r+b");
    if (!file || !defe::ends_with(file.get(), magic))
      complaint = incomplete(base);
    else if (set) {
      nfiles = files_of_base(file.get());
      if (nfiles == 0)
        complaint =
            "Restart file " + base + " is not laid out as in the LAMMPS that fix defe knows";
    }
  }
  stop_if_any(lmp, complaint);
  MPI_Bcast(&nfiles, 1, MPI_INT, 0, lmp->world);

  std::vector<uint64_t> mine(nfiles, 0), sums(nfiles, 0);
  for (int k = 0; k < nfiles; k++) {
    if (rank_of_file(k, nfiles, nprocs) != me) continue;
    const std::string name = file_of_set(pattern, std::to_string(k));
    const File one = open_file(name, "rb");
    if (!one || !defe::ends_with(one.get(), magic) ||
        !defe::checksum_of_file(one.get(), -1, mine[k])) {
      complaint = incomplete(name);
      break;
    }
  }
  if (set) {
    stop_if_any(lmp, complaint);
    MPI_Reduce(mine.data(), sums.data(), nfiles, MPI_UINT64_T, MPI_SUM, 0, lmp->world);
  }

  if (me == 0) {
    const bool good = defe::append_seal(file.get(), sums, magic);
    if (fclose(file.release()) || !good) complaint = incomplete(base);
  }
  stop_if_any(lmp, complaint);
}

/* ---------------------------------------------------------------------- */

void LAMMPS_NS::mark_restart_file(FILE *fp)
{
  fwrite(RESTART_FORMAT, 1, sizeof(RESTART_FORMAT), fp);
}

namespace {

/// The file that read_restart reads: a * in its name stands for the largest number that there is.
std::string name_of_file(const std::string &given)
{
  const auto folder = platform::path_dirname(given);
  std::string name = platform::path_basename(given);
  const auto star = name.find('*');
  if (star == std::string::npos) return given;
  std::string pattern = name;
  if (const auto percent = pattern.find('%'); percent != std::string::npos)
    pattern.replace(percent, 1, "base");
  const auto front = pattern.find('*');
  pattern.replace(front, 1, "\\d+");
  bigint last = -1;
  for (const auto &candidate : platform::list_directory(folder))
    if (utils::strmatch(candidate, pattern))
      last = MAX(last, std::stoll(utils::strfind(candidate.substr(front), "\\d+")));
  return platform::path_join(folder, name.replace(star, 1, std::to_string(last)));
}

}    // namespace

void LAMMPS_NS::check_restart_file(LAMMPS *lmp, FILE *fp)
{
  const int me = lmp->comm->me, nprocs = lmp->comm->nprocs;
  std::vector<uint64_t> sums;
  std::string complaint, pattern;
  if (me == 0) {
    const auto *input = lmp->input;
    const bool by_command =
        input->command && !strcmp(input->command, "read_restart") && input->narg > 0;
    const std::string name = by_command ? name_of_file(input->arg[0]) : "";
    const std::string shown = name.find('%') == std::string::npos ? name
                                                                  : file_of_set(name, "base");
    char mark[sizeof(RESTART_FORMAT)];
    if (fread(mark, 1, sizeof(RESTART_FORMAT), fp) != sizeof(RESTART_FORMAT) ||
        memcmp(mark, RESTART_FORMAT, sizeof(RESTART_FORMAT)) != 0)
      complaint = "Restart file " + shown +
          " was written by another version of DEFE, or is damaged: go on with that version, or use "
          "an older file";
    else {
      const auto state = defe::check_seal(fp, magic.size(), sums);
      if (state == defe::SealState::MISSING)
        complaint = "Restart file " + shown +
            " is damaged or was not finished (no checksum at its end): use an older file";
      else if (state == defe::SealState::BROKEN)
        complaint =
            "Restart file " + shown + " is damaged (its checksum is wrong): use an older file";
      else if (!sums.empty() && name.find('%') == std::string::npos)
        complaint = "Restart file " + shown +
            " is the base of a set of files: give read_restart its name with % for 'base'";
      else
        pattern = name;
    }
  }
  stop_if_any(lmp, complaint);

  int nfiles = static_cast<int>(sums.size());
  MPI_Bcast(&nfiles, 1, MPI_INT, 0, lmp->world);
  if (nfiles == 0) return;
  sums.resize(nfiles);
  MPI_Bcast(sums.data(), nfiles, MPI_UINT64_T, 0, lmp->world);
  broadcast(pattern, 0, lmp->world);
  for (int k = 0; k < nfiles; k++) {
    if (rank_of_file(k, nfiles, nprocs) != me) continue;
    const std::string name = file_of_set(pattern, std::to_string(k));
    const File one = open_file(name, "rb");
    uint64_t sum = 0;
    if (!one) {
      complaint = "Cannot open restart file " + name + ": " + utils::getsyserror();
      break;
    }
    if (!defe::checksum_of_file(one.get(), -1, sum) || sum != sums[k]) {
      complaint = "Restart file " + name +
          " is damaged or does not belong to the others of its set: use an older set";
      break;
    }
  }
  stop_if_any(lmp, complaint);
}
