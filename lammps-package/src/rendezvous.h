/* ----------------------------------------------------------------------
   DEFE: adaptive finite elements to bonded discrete elements for LAMMPS
   https://www.lammps.org/
   This software is distributed under the GNU General Public License.
------------------------------------------------------------------------- */

#ifndef LMP_DEFE_RENDEZVOUS_H
#define LMP_DEFE_RENDEZVOUS_H

#include "comm.h"
#include "irregular.h"
#include "lammps.h"
#include "lmptype.h"

#include <cmath>
#include <cstdint>
#include <vector>

namespace LAMMPS_NS::Rendezvous {

/** The rank on which all that concerns one ID meets. */
inline int rank_of(LAMMPS *lmp, tagint id)
{
  return static_cast<int>(id % lmp->comm->nprocs);
}

/** Number of the cell that a coordinate lies in; `size` is the edge of cells, whose borders are off the planes of a
    regular mesh. */
inline std::int64_t cell_of(double x, double size)
{
  return static_cast<std::int64_t>(std::floor(x / size + 0.37));
}

/** The rank on which all that concerns one cell meets. */
inline int rank_of(LAMMPS *lmp, const std::int64_t cell[3])
{
  std::uint64_t hash = 0;
  for (int d = 0; d < 3; d++) hash = hash * 1000003u + static_cast<std::uint64_t>(cell[d]);
  hash ^= hash >> 29;
  return static_cast<int>(hash % static_cast<std::uint64_t>(lmp->comm->nprocs));
}

/** Send each datum (plain data) to its rank; returns what arrived here. Collective. */
template <class T> std::vector<T> route(LAMMPS *lmp, std::vector<T> &send, std::vector<int> &proc)
{
  Irregular irregular(lmp);
  const int nrecv = irregular.create_data(static_cast<int>(send.size()), proc.data(), 1);
  std::vector<T> recv(nrecv + 1);
  irregular.exchange_data(reinterpret_cast<char *>(send.data()), sizeof(T),
                          reinterpret_cast<char *>(recv.data()));
  irregular.destroy_data();
  recv.resize(nrecv);
  return recv;
}

/** A list of data, each with the rank it goes to. */
template <class T> class Letters {
 public:
  explicit Letters(LAMMPS *lmp) : lmp(lmp) {}
  void to_rank(int p, const T &datum)
  {
    data.push_back(datum);
    proc.push_back(p);
  }
  void to_id(tagint id, const T &datum) { to_rank(rank_of(lmp, id), datum); }
  void to_cell(const std::int64_t cell[3], const T &datum) { to_rank(rank_of(lmp, cell), datum); }
  /** Collective. */
  std::vector<T> send() { return route(lmp, data, proc); }

 private:
  LAMMPS *lmp;
  std::vector<T> data;
  std::vector<int> proc;
};

}    // namespace LAMMPS_NS::Rendezvous

#endif
