// Issue 3: memory per rank falls with the number of ranks. A block of 500 000 elements on all
// ranks, against the share of one rank alone.
//
// ranks: 1 2 4
// timeout: 3600

#include "glass_block.h"
#include "joints.h"

#include "comm.h"
#include "info.h"

#include <cmath>
#include <sys/resource.h>

using namespace defe::test;

namespace {

/// Largest resident set of this process so far (bytes).
double peak()
{
  rusage usage;
  getrusage(RUSAGE_SELF, &usage);
  return 1024.0 * static_cast<double>(usage.ru_maxrss);
}

/// nx x ny x nz elements, a few steps. LAMMPS' own count (bytes).
double run(MPI_Comm comm, int nx, int ny, int nz)
{
  Block block;
  const int n[3] = {nx, ny, nz};
  for (int k = 0; k < 3; k++) {
    block.n[k] = n[k];
    block.box_lo[k] = -0.001;
    block.box_hi[k] = n[k] * block.h + 0.001;
  }
  // one layer is discrete, of which each rank has its share
  block.processors = "1 * *";
  block.regions = "region slice block INF " + number(0.75 * block.h) + " INF INF INF INF";
  block.convert += " start slice";
  block.options = "contact 0.2";
  Lammps lmp(comm);
  lmp.commands(block.script() + "neigh_modify binsize 0.002\nthermo_style custom step\n");
  lmp.run(3);
  EXPECT_EQ(lmp.fe(ELEMENTS) + lmp.fe(CONVERTED), static_cast<double>(nx) * ny * nz);
  EXPECT_EQ(lmp.fe(DES), 8.0 * ny * nz);
  LAMMPS_NS::Info info(lmp.operator->());
  double meminfo[3];
  info.get_memory_info(meminfo);
  return meminfo[0] * 1024.0 * 1024.0;
}

}    // namespace

TEST(Memory, PerRank)
{
  // one rank's share first: the peak never falls
  const int ranks = size_of(MPI_COMM_WORLD), nx = 80, ny = 80, nz = 80;    // 512 000
  const double empty = peak();
  const double share = run(MPI_COMM_SELF, nx, ny, nz / ranks);
  const double peak_share = peak() - empty;
  MPI_Barrier(MPI_COMM_WORLD);
  const double whole = run(MPI_COMM_WORLD, nx, ny, nz);
  const double peak_whole = peak() - empty;
  double most = 0.0;
  MPI_Allreduce(&peak_whole, &most, 1, MPI_DOUBLE, MPI_MAX, MPI_COMM_WORLD);
  if (rank_of(MPI_COMM_WORLD) == 0)
    std::printf("%d ranks: peak RSS per rank %.0f MB (program itself %.0f MB; a share of %d "
                "elements alone %.0f MB), LAMMPS counts %.0f MB (%.0f MB)\n",
                ranks, most / 1e6, empty / 1e6, nx * ny * nz / ranks, peak_share / 1e6, whole / 1e6,
                share / 1e6);

  // ghosts lie four elements deep around a domain of 40 x 40 x 80: half as many again as its own
  EXPECT_LT(most, 1.5 * peak_share);
}
