// Nuclei of cracks: overstrength and scatter of pair_coeff, on any ranks and over a restart

#include "events.h"
#include "glass_block.h"

#include <gtest/gtest.h>

#include <algorithm>

using namespace defe;
using namespace defe::test;

namespace {

using Cuts = std::vector<std::array<long, 3>>;    // step and the two DEs

Block block_with(const std::string &words)
{
  Block block;
  block.n[1] = 8;
  block.dt = 1e-8;
  block.convert = "1e12 type 2 group particles start all";
  block.coeff = "connective material cohesive 60e6 10 0.1 " + words + " contact 0.9 0.2";
  return block;
}

void pull(Lammps &lmp, const Block &block)
{
  lmp.change([&](Particle &p) {
    p.v = Vec3(0.0, 4000.0 * (p.x[1] - block.centre()[1]), 0.0) + 0.05 * random_of(p.tag, 3);
  });
}

Cuts cuts(const std::string &file, long after = -1)
{
  Cuts all;
  for (const Event &e : read_events(file, "cohesive"))
    if (e.step > after) all.push_back({e.step, e.a, e.b});
  std::sort(all.begin(), all.end());
  return all;
}

constexpr int middle = 28, end = 50;

/// Joints cut while the block is drawn apart; FILE.*.restart is written on the way.
Cuts draw(const std::string &words, const std::string &file, MPI_Comm comm = MPI_COMM_WORLD)
{
  Block block = block_with(words);
  block.options = "events " + file;
  remove_file(file, comm);
  {
    Lammps lmp(comm);
    lmp.commands(block.script() + "restart " + std::to_string(middle) + " " + file +
                 ".*.restart\n");
    pull(lmp, block);
    lmp.run(end);
  }
  MPI_Barrier(comm);
  return cuts(file);
}

}    // namespace

TEST(Nuclei, ScatterAndOverstrengthOfAPairOfTypes)
{
  const Cuts usual = draw("", "usual.txt");
  ASSERT_GT(usual.size(), 100u);
  EXPECT_EQ(draw("overstrength 2 scatter 0.01", "written.txt"), usual) << "the defaults";
  EXPECT_GT(draw("overstrength 1", "crowded.txt").size(), usual.size());
  // the weakest joints keep the strength, and neighbours do not wait for each other
  const Cuts spread = draw("scatter 0.5", "spread.txt");
  EXPECT_NEAR(spread.front()[0], usual.front()[0], 1);
  EXPECT_GT(spread.size(), usual.size());
}

// Coefficients come from the restart file: no pair_coeff after read_restart.
TEST(Nuclei, OnAnyRanksAndOverARestart)
{
  const std::string words = "overstrength 1.3 scatter 0.3";
  const Cuts whole = draw(words, "whole.txt");
  if (rank_of(MPI_COMM_WORLD) == 0) { EXPECT_EQ(draw(words, "one.txt", MPI_COMM_SELF), whole); }
  MPI_Barrier(MPI_COMM_WORLD);
  Cuts late;
  for (const auto &c : whole)
    if (c[0] > middle) late.push_back(c);
  EXPECT_GT(late.size(), 5u) << "a poor example";
  EXPECT_LT(late.size() + 5, whole.size()) << "a poor example";

  Block block = block_with(words);
  block.options = "events on.txt";
  remove_file("on.txt");
  {
    Lammps lmp;
    lmp.commands(block.header() + "read_restart whole.txt." + std::to_string(middle) +
                 ".restart\n" + block.fix_only() + block.motion());
    lmp.run(end - middle);
  }
  MPI_Barrier(MPI_COMM_WORLD);
  EXPECT_EQ(cuts("on.txt", middle), late);
}
