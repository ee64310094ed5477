#ifndef DEFE_TEST_CRACKING_BEAM_H
#define DEFE_TEST_CRACKING_BEAM_H

// A glass beam that is bent until it cracks, in the middle and then elsewhere: elements convert,
// joints soften and break, and fragments touch, for the 260 steps of a test.

#include "events.h"
#include "glass_block.h"

#include <tuple>

namespace defe::test {

inline Block cracking_beam()
{
  Block block;
  block.n[0] = 16;
  block.n[1] = 5;
  block.n[2] = 2;
  block.box_hi[0] = 0.05;
  block.convert = "5.6e7 type 2 group particles";
  block.coeff = "connective material cohesive 6e7 10.0 0.1 contact 0.9 0.2";
  return block;
}

/// The bending motion, with some noise; so many times as fast as it needs to be.
inline void bend(Lammps &lmp, const Block &block, double speed = 1.0)
{
  lmp.change([&](Particle &p) {
    const double s = (p.x[0] - block.centre()[0]) / 0.016;
    p.v = speed * (Vec3(0.0, 12.0 * (s * s - 1.0 / 3.0), 0.0) + 0.1 * random_of(p.tag, 8));
  });
}

/// What happened after step `after`: (step, what, id, id2) of conversions and joints.
using History = std::vector<std::tuple<long, std::string, long, long>>;

inline History history(const std::string &file, long after = -1)
{
  History list;
  for (const auto &e : read_events(file))
    if (e.step > after) list.emplace_back(e.step, e.what, e.a, e.b);
  return list;
}

/// The same events on all ranks and on one, and what is left of them over a restart in the middle. Files begin with `name`.
/// \param before  more events than this come before the restart
inline void same_on_any_ranks_and_over_a_restart(Block block, const std::string &name, int end,
                                                 std::size_t before = 0)
{
  constexpr int middle = 100;
  const std::string options = block.options;
  const auto run = [&](MPI_Comm comm, const std::string &events) {
    block.options = options + " events " + events;
    remove_file(events, comm);
    Lammps lmp(comm);
    lmp.commands(block.script());
    bend(lmp, block);
    lmp.run(middle);
    lmp.command("write_restart " + events + ".restart");
    lmp.run(end - middle);
    MPI_Barrier(comm);
    return lmp.particles();
  };
  run(MPI_COMM_WORLD, name + ".txt");
  const History whole = history(name + ".txt");
  on_one_rank([&] {
    return run(MPI_COMM_SELF, name + ".one.txt");
  });
  EXPECT_EQ(whole, history(name + ".one.txt"));
  const History rest = history(name + ".txt", middle);
  EXPECT_GT(rest.size(), 10u) << "a poor example";
  EXPECT_LT(rest.size() + before, whole.size()) << "a poor example";

  block.options = options + " events " + name + ".rest.txt";
  remove_file(name + ".rest.txt");
  Lammps lmp;
  lmp.commands(block.header() + "read_restart " + name + ".txt.restart\n" + block.fix_only() +
               block.motion());
  lmp.run(end - middle);
  MPI_Barrier(MPI_COMM_WORLD);
  EXPECT_EQ(history(name + ".rest.txt"), rest);
}

}    // namespace defe::test

#endif
