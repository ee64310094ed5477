/* ----------------------------------------------------------------------
   DEFE: adaptive finite elements to bonded discrete elements for LAMMPS
   https://www.lammps.org/
   This software is distributed under the GNU General Public License.
------------------------------------------------------------------------- */

#include "defe_system.h"

#include "atom.h"
#include "comm.h"
#include "domain.h"
#include "error.h"
#include "update.h"

#include "defe/coupling/checksum.h"

using namespace LAMMPS_NS;

/* ----------------------------------------------------------------------
   names of the run and of its mesh: checksums of how they begin, the same on any number of ranks
------------------------------------------------------------------------- */

void DefeEvents::name_run()
{
  if (!log.on() || log.has_run()) return;
  uint64_t mine[2] = {0, 0}, all[2];
  bigint elements = 0, all_elements = 0;
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
    for (const auto &h : sys.store.hexes(i)) {
      defe::Checksum hex;
      const int64_t names[2] = {h.id, h.part};
      hex.add(names, sizeof(names));
      hex.add(h.node, sizeof(h.node));
      hex.add(sys.store.x_ref(i), 3 * sizeof(double));
      mine[1] += hex.value();
      elements++;
    }
  }
  MPI_Allreduce(mine, all, 2, MPI_UINT64_T, MPI_SUM, world);
  MPI_Allreduce(&elements, &all_elements, 1, MPI_LMP_BIGINT, MPI_SUM, world);
  defe::Checksum run;
  run.add(all, sizeof(all));
  const uint64_t laws = sys.kept.laws();
  run.add(&laws, sizeof(laws));
  for (const auto &p : sys.model.parts) {
    const std::string text = sys.model.describe(p);
    run.add(text.c_str(), text.size() + 1);
    run.add(&p.stress, sizeof(double));
    if (p.convertible && !utils::is_double(p.criterion_words))
      run.add(p.criterion_words.c_str(), p.criterion_words.size());
  }
  run.add(&update->dt, sizeof(double));
  log.name_run(run.value(), all[1], all_elements);
}

/* ----------------------------------------------------------------------
   the first rank writes: if it cannot, all stop
------------------------------------------------------------------------- */

void DefeEvents::stop_by_first_rank(std::string complaint) const
{
  int n = static_cast<int>(complaint.size());
  MPI_Bcast(&n, 1, MPI_INT, 0, world);
  if (n == 0) return;
  complaint.resize(n);
  MPI_Bcast(&complaint[0], n, MPI_CHAR, 0, world);
  error->all(FLERR, "Fix defe: {}", complaint);
}

/* ---------------------------------------------------------------------- */

void DefeEvents::flush()
{
  if (!log.on()) return;
  if (!log.opened()) {
    name_run();
    stop_by_first_rank(log.open(comm->me == 0));
  }
  const auto mine = log.take();
  const int bytes = static_cast<int>(mine.size() * sizeof(defe::Event));
  std::vector<int> count(comm->nprocs), offset(comm->nprocs);
  MPI_Gather(&bytes, 1, MPI_INT, count.data(), 1, MPI_INT, 0, world);
  std::vector<defe::Event> all;
  if (comm->me == 0) {
    int sum = 0;
    for (int p = 0; p < comm->nprocs; p++) {
      offset[p] = sum;
      sum += count[p];
    }
    all.resize(sum / sizeof(defe::Event));
  }
  MPI_Gatherv(mine.data(), bytes, MPI_BYTE, all.data(), count.data(), offset.data(), MPI_BYTE, 0,
              world);
  stop_by_first_rank(log.append(std::move(all)));
}
