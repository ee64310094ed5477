// Atoms that come later: grains poured onto a beam that cracks meanwhile, spheres made between runs,
// molecules dropped on elements. No two atoms have one ID, on any number of ranks and over a restart.
//
// ranks: 1 2 4
// timeout: 240

#include "cracking_beam.h"
#include "failure.h"

#include <gmock/gmock.h>

#include <fstream>
#include <set>

using namespace defe::test;
using defe::Vec3;
using testing::AllOf;
using testing::HasSubstr;

namespace {

constexpr double h = 2e-3;

/// The beam that cracks, under a space for grains of type 3.
Block beam(const std::string &events = "", MPI_Comm comm = MPI_COMM_WORLD)
{
  Block block = cracking_beam();
  block.coeff = "connective material cohesive 6e7 10.0 0.1 contact 0.9 0.2\n"
                "pair_coeff 2 3 contact 0.9 0.2";
  block.options = "contact 0.2";
  if (!events.empty()) {
    remove_file(events, comm);
    block.options += " events " + events;
  }
  return block;
}

std::string made(const Block &block)
{
  std::string box = block.box();
  box.replace(box.find("create_box 2"), 12, "create_box 3");
  return block.header() + box + block.fix() + block.mesh();
}

/// What moves the grains, and pours them: every 100 steps some, which take 70 steps to the beam.
std::string moving_grains(const Block &block)
{
  return block.motion() +
      "group grains type 3\nfix move3 grains nve/sphere\nfix weight grains gravity 1000 vector 0 0 "
      "-1\n";
}

std::string pour(int seed, const std::string &more = "")
{
  return "region slab block 0 0.032 0 0.01 0.0047 0.0057 units box\nfix rain grains pour 60 3 " +
      std::to_string(seed) +
      " region slab diam one 0.0004 dens 2500 2500 vol 0.002 50 vel 0 0 0 0 -200" + more + "\n";
}

struct Outcome {
  Particles particles;
  History events;
};

Outcome outcome(Lammps &lmp, const std::string &events, MPI_Comm comm, long after = -1)
{
  lmp.run(0);    // the file is written
  MPI_Barrier(comm);
  Outcome result{lmp.particles(), history(events, after)};
  MPI_Barrier(comm);
  return result;
}

int count(const Particles &all, int type)
{
  int n = 0;
  for (const auto &p : all) n += p.second.type == type;
  return n;
}

/// 300 steps of rain on the beam, with another cloud from step 150 on; a restart file in between.
Outcome rain(MPI_Comm comm, const std::string &events, const std::string &restart = "")
{
  Lammps lmp(comm);
  const Block block = beam(events, comm);
  lmp.commands(made(block) + moving_grains(block) + pour(4711));
  bend(lmp, block);
  lmp.run(150);
  if (!restart.empty()) lmp.command("write_restart " + restart);
  lmp.commands("unfix rain\nregion slab delete\n" + pour(815));
  lmp.run(150);
  return outcome(lmp, events, comm);
}

void expect_same(const Outcome &a, const Outcome &b)
{
  EXPECT_EQ(a.events, b.events);
  ASSERT_EQ(a.particles.size(), b.particles.size());
  EXPECT_LT(difference(a.particles, b.particles, &Particle::x), 1e-8 * h);
  for (const auto &p : a.particles) EXPECT_EQ(p.second.type, b.particles.at(p.first).type);
}

}    // namespace

// Grains come before the first conversion and between conversions.
TEST(Newcomers, PouredOnAPlateThatConverts)
{
  const std::string world = "rain.txt", alone = "rain_on_one_rank.txt";
  const Outcome here = rain(MPI_COMM_WORLD, world);
  EXPECT_GT(here.events.size(), 100u) << "a poor example";
  EXPECT_GT(count(here.particles, 2), 100) << "a poor example";
  EXPECT_GT(count(here.particles, 3), 50) << "a poor example";
  // not all DEs have the IDs of their elements
  const Block block = beam();
  const tagint beyond = block.nodes() + 8 * block.elements();
  int outside = 0;
  for (const auto &p : here.particles) outside += p.second.type == 2 && p.first > beyond;
  EXPECT_GT(outside, 0);
  if (size_of(MPI_COMM_WORLD) == 1) return;
  Outcome one;
  one.particles = on_one_rank([&] {
    return rain(MPI_COMM_SELF, alone).particles;
  });
  one.events = history(alone);
  expect_same(one, here);
}

TEST(Newcomers, RestartInTheMiddle)
{
  const std::string whole = "rain_whole.txt", rest = "rain_rest.txt";
  Outcome expected = rain(MPI_COMM_WORLD, whole, "rain.restart");
  expected.events.erase(std::remove_if(expected.events.begin(), expected.events.end(),
                                       [](const auto &e) {
                                         return std::get<0>(e) <= 150;
                                       }),
                        expected.events.end());
  EXPECT_GT(expected.events.size(), 50u) << "a poor example";
  const auto go_on = [](MPI_Comm comm, const std::string &events) {
    Lammps lmp(comm);
    const Block block = beam(events, comm);
    lmp.commands(block.header() + "read_restart rain.restart\n" + block.fix_only() +
                 moving_grains(block) + pour(815));
    lmp.run(150);
    return outcome(lmp, events, comm);
  };
  expect_same(expected, go_on(MPI_COMM_WORLD, rest));
  if (size_of(MPI_COMM_WORLD) == 1) return;
  Outcome one;    // written by several ranks, read by one
  one.particles = on_one_rank([&] {
    return go_on(MPI_COMM_SELF, rest).particles;
  });
  one.events = history(rest);
  expect_same(expected, one);
}

// A sphere that is made between runs takes the ID after the last one: that of a DE to come.
TEST(Newcomers, CreatedBetweenRuns)
{
  std::vector<std::array<long, 2>> undisturbed;
  for (const int when : {-1, 0, 50}) {
    Lammps lmp;
    const Block block = beam("between.txt");
    lmp.commands(made(block) + moving_grains(block));
    bend(lmp, block);
    lmp.run(std::max(0, when));
    if (when >= 0)
      lmp.commands(
          "create_atoms 3 single 0.005 0.005 0.02 units box\nset type 3 diameter 0.001 density "
          "2500\ngroup grains type 3\nvelocity grains set 0 0 1");
    lmp.run(200 - std::max(0, when));
    EXPECT_GT(lmp.fe(DES), 100);
    MPI_Barrier(MPI_COMM_WORLD);
    const auto converted = conversions("between.txt");
    MPI_Barrier(MPI_COMM_WORLD);
    if (when < 0) {
      undisturbed = converted;
      continue;
    }
    EXPECT_EQ(converted, undisturbed);
    const Particles all = lmp.particles();
    EXPECT_EQ(count(all, 3), 1);
    for (const auto &p : all)
      if (p.second.type == 3) { EXPECT_GT(p.first, block.nodes()); }
  }
}

// On elements that do not convert; what a newcomer brings along is external work.
TEST(Newcomers, DepositedOnElements)
{
  if (rank_of(MPI_COMM_WORLD) == 0)
    std::ofstream("grain.mol") << "# a grain\n\n1 atoms\n\nCoords\n\n1 0 0 0\n\nTypes\n\n1 1\n\n"
                                  "Diameters\n\n1 0.001\n\nMasses\n\n1 2e-6\n";
  MPI_Barrier(MPI_COMM_WORLD);
  Lammps lmp;
  Block block;
  std::string script = block.header() + block.box() + block.fix() + block.mesh();
  script.replace(script.find("create_box 2"), 12, "create_box 3");
  const std::string convert = " convert glass " + block.convert + " ";
  script.replace(script.find(convert), convert.size(), " contact 0.2 ");
  lmp.commands(script + block.motion() +
               "group grains type 3\nfix move3 grains nve/sphere\nmolecule grain grain.mol\n"
               "region top block 0.001 0.007 0.001 0.005 0.0055 0.006 units box\n"
               "fix rain grains deposit 4 2 60 815 region top near 0.0012 mol grain vz -40 -40\n");
  lmp.record({"f_fe[22]", "f_fe[14]", "f_fe[21]", "count(grains)"}, 1);
  lmp.run(1200);
  EXPECT_EQ(lmp.natoms(), block.nodes() + 4);
  const double brought = 4 * 0.5 * 2e-6 * 40.0 * 40.0;
  EXPECT_NEAR(lmp.fe(EXTERNAL) / brought, 1.0, 1e-9);
  const auto total = lmp.recorded(0);
  EXPECT_LT(largest_deviation(total), 2e-3 * brought);
  int bounced = 0;
  for (const auto &p : lmp.particles()) bounced += p.second.type == 3 && p.second.v[2] > 5.0;
  EXPECT_EQ(bounced, 4);
}

// IDs that a fix counts by itself from its first insertion on run into those of DEs.
TEST(Newcomers, IDsThatAreCountedApart)
{
  Lammps lmp;
  const Block block = beam();
  lmp.commands(made(block) + moving_grains(block) + pour(4711));
  bend(lmp, block);
  lmp.run(150);
  lmp.commands("unfix rain\nregion slab delete\n" + pour(815, " id next"));
  EXPECT_THAT(failure(lmp, "run 150"),
              AllOf(HasSubstr("inserted"), HasSubstr("which a DE has"), HasSubstr("id max")));
}

TEST(Newcomers, InserterBeforeFixDefe)
{
  Lammps lmp;
  Block block = beam();
  std::string script = made(block);
  script.insert(script.find("fix fe"),
                "region top block 0 0.03 0 0.01 0.02 0.025 units box\n"
                "fix rain particles deposit 3 3 5 12345 region top near 0.002 units box\n");
  lmp.commands(script + moving_grains(block));
  EXPECT_THAT(failure(lmp, "run 1"),
              AllOf(HasSubstr("Fix rain deposit"), HasSubstr("after fix fe defe")));
}
