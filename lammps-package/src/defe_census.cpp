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

using namespace LAMMPS_NS;

void DefeCensus::weigh_nodes()
{
  bigint nodes = 0;
  double mass_here = 0.0;
  for (int i = 0; i < atom->nlocal; i++)
    if (sys.store.elements_at(i) > 0) {
      nodes++;
      mass_here += atom->rmass[i];
    }
  MPI_Allreduce(&nodes, &now.nodes, 1, MPI_LMP_BIGINT, MPI_SUM, world);
  MPI_Allreduce(&mass_here, &now.mass, 1, MPI_DOUBLE, MPI_SUM, world);
}

void DefeCensus::convert(bigint elements, bigint nodes_gone, bigint des_born)
{
  now.nodes -= nodes_gone;
  now.converted += elements;
  now.elements -= elements;
  now.des += des_born;
}

void DefeCensus::let_go(double mass)
{
  now.gone++;
  now.mass_gone += mass;
}

/* ---------------------------------------------------------------------- */

bool DefeCensus::recount()
{
  bigint mine[4] = {0, 0, 0, now.gone}, all[4];
  double mass = now.mass_gone;
  for (int i = 0; i < atom->nlocal; i++) {
    mine[0] += static_cast<bigint>(sys.store.hexes(i).size());
    mine[1] += sys.store.de(i) ? 1 : 0;
    mine[2] += sys.store.is_node(i) ? 1 : 0;
    if (sys.store.is_ours(i)) mass += atom->rmass[i];
  }
  MPI_Allreduce(mine, all, 4, MPI_LMP_BIGINT, MPI_SUM, world);
  if (all[0] == now.elements && all[1] + all[3] == now.des && all[2] == now.nodes) return false;
  now.elements = all[0];
  now.des = all[1] + all[3];
  now.nodes = all[2];
  MPI_Allreduce(&mass, &now.mass, 1, MPI_DOUBLE, MPI_SUM, world);
  return true;
}

void DefeCensus::check(const char *when) const
{
  bigint mine[3] = {0, 0, now.gone}, all[3];
  for (int i = 0; i < atom->nlocal; i++) {
    mine[0] += static_cast<bigint>(sys.store.hexes(i).size());
    mine[1] += sys.store.de(i) ? 1 : 0;
  }
  MPI_Allreduce(mine, all, 3, MPI_LMP_BIGINT, MPI_SUM, world);
  if (all[0] != now.elements || all[1] != now.des - all[2])
    error->all(FLERR,
               "Fix defe {} at step {}: {} elements and {} DEs are here, {} and {} should be", when,
               update->ntimestep, all[0], all[1], now.elements, now.des - all[2]);
}

/* ----------------------------------------------------------------------
   restart files: sums on the first rank, which keeps what has gone
------------------------------------------------------------------------- */

void DefeCensus::pack(State &s) const
{
  s = now;
  MPI_Reduce(&now.mass_gone, &s.mass_gone, 1, MPI_DOUBLE, MPI_SUM, 0, world);
  MPI_Reduce(&now.gone, &s.gone, 1, MPI_LMP_BIGINT, MPI_SUM, 0, world);
}

void DefeCensus::unpack(const State &s)
{
  now = s;
  if (comm->me == 0) return;
  now.mass_gone = 0.0;
  now.gone = 0;
}
