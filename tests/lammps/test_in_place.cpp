// Conversions in place: they need no reneighbouring, and nothing else differs.

#include "cracking_beam.h"

#include "atom.h"
#include "comm.h"
#include "domain.h"
#include "neighbor.h"

#include <algorithm>

using namespace defe::test;
using defe::Vec3;

namespace {

constexpr int last = 220;

/// A beam that stands across, 20 mm from the nearest border of up to four ranks side by side, or upon one; others have a block
/// that stays whole.
struct Scene {
  std::string options;
  double from = 0.04;
  std::string map = "yes";
  std::string more;    // commands before the run
  std::string boundary = "f f f";
  std::string processors = "* 1 1";

  Block block() const
  {
    Block b = cracking_beam();
    b.boundary = boundary;
    b.processors = processors;
    std::copy_n(std::initializer_list<int>{5, 16, 2}.begin(), 3, b.n);
    b.lo[0] = from;
    b.box_lo[0] = -0.03;
    b.box_hi[0] = 0.17;
    b.box_hi[1] = 0.052;
    b.options = "check yes contact 0.2 " + options;
    return b;
  }
  std::string header() const { return "atom_modify map " + map + "\n"; }
};

void bend_across(Lammps &lmp, const Block &block)
{
  lmp.change([&](Particle &p) {
    if (p.x[0] > 0.12 && p.x[0] < 0.15) return;
    const double s = (p.x[1] - block.centre()[1]) / 0.016;
    p.v = Vec3(12.0 * (s * s - 1.0 / 3.0), 0.0, 0.0) + 0.1 * random_of(p.tag, 8);
  });
}

struct Outcome {
  History events;
  Particles particles;
  bigint builds;    // of neighbour lists
  double energy;
};

std::string setup_of(const Scene &scene, const Block &block)
{
  return block.header() + scene.header() + block.box() + block.fix() + block.mesh() +
      "create_hexes fe glass 1 x 0.13 5 0.14 y 0 10 0.02 z 0 2 0.004\n" + block.motion() +
      scene.more;
}

Outcome run(const Scene &scene, MPI_Comm comm = MPI_COMM_WORLD)
{
  const std::string file = size_of(comm) == 1 ? "in_place.one.txt" : "in_place.txt";
  remove_file(file, comm);
  Outcome outcome;
  {
    Block block = scene.block();
    block.options += " events " + file;
    Lammps lmp(comm);
    lmp.commands(setup_of(scene, block));
    bend_across(lmp, block);
    lmp.run(last);
    outcome.particles = lmp.particles();
    outcome.builds = lmp->neighbor->ncalls;
    outcome.energy = lmp.fe(TOTAL);
  }
  MPI_Barrier(comm);
  outcome.events = history(file);
  MPI_Barrier(comm);    // all have read it before it is written anew
  return outcome;
}

int steps_of_conversion(const History &events)
{
  int count = 0;
  long before = -1;
  for (const auto &e : events)
    if (std::get<1>(e) == "convert" && std::get<0>(e) != before) {
      before = std::get<0>(e);
      count++;
    }
  return count;
}

/// Last digits differ: what leaves a periodic box is brought back at other steps.
void expect_nearly_same(const Outcome &a, const Outcome &b)
{
  EXPECT_EQ(a.events, b.events);
  EXPECT_NEAR(a.energy, b.energy, 1e-9 * b.energy);
  ASSERT_EQ(a.particles.size(), b.particles.size());
  for (auto p = a.particles.begin(), q = b.particles.begin(); p != a.particles.end(); ++p, ++q) {
    ASSERT_EQ(p->first, q->first);
    ASSERT_LT((p->second.x - q->second.x).norm(), 1e-12) << "atom " << p->first;
    ASSERT_LT((p->second.v - q->second.v).norm(), 1e-7) << "atom " << p->first;
  }
}

void expect_same(const Outcome &a, const Outcome &b)
{
  EXPECT_EQ(a.events, b.events);
  EXPECT_DOUBLE_EQ(a.energy, b.energy);    // a sum in the order of the atoms, which differs
  ASSERT_EQ(a.particles.size(), b.particles.size());
  for (auto p = a.particles.begin(), q = b.particles.begin(); p != a.particles.end(); ++p, ++q) {
    ASSERT_EQ(p->first, q->first);
    ASSERT_EQ(p->second.x, q->second.x) << "atom " << p->first;
    ASSERT_EQ(p->second.v, q->second.v) << "atom " << p->first;
  }
}

/// With and without reneighbouring for conversions: the same, to the last bit with exact sums where nothing is brought back into a
/// periodic box, and LAMMPS' lists are hardly ever made anew.
void expect_in_place(Scene scene)
{
  const bool periodic = scene.boundary != "f f f";
  const std::string exact = periodic ? "" : "reproducible yes ";
  scene.options = exact + "inplace no";
  const auto by_lists = run(scene);
  const int conversions = steps_of_conversion(by_lists.events);
  ASSERT_GT(conversions, 12) << "a poor example";
  EXPECT_GE(by_lists.builds, conversions);
  scene.options = exact;
  const auto in_place = run(scene);
  if (periodic)
    expect_nearly_same(in_place, by_lists);
  else
    expect_same(in_place, by_lists);
  EXPECT_LT(in_place.builds, conversions / 3) << "of " << conversions << " conversions";
}

}    // namespace

// The same to the last bit, with exact sums: LAMMPS' lists are made anew at other steps, and atoms are in another order.
TEST(InPlace, NothingElseDiffers)
{
  for (const std::string map : {"array", "hash"}) {
    SCOPED_TRACE("map " + map);
    Scene scene;
    scene.map = map;
    expect_in_place(scene);
  }
}

// DEs have IDs above those of all atoms before: the array of LAMMPS' map grows for them, and nobody reneighbours for that.
TEST(InPlace, IdsBeyondTheMap)
{
  Scene scene;
  scene.map = "array";
  const Block block = scene.block();
  Lammps lmp(MPI_COMM_WORLD);
  lmp.commands(setup_of(scene, block));
  bend_across(lmp, block);
  int steps = 0;
  for (; steps < last && lmp.fe(DES) == 0.0; steps += 5) lmp.run(5);
  tagint mine = 0, highest = 0;
  for (int i = 0; i < lmp->atom->nlocal; ++i) mine = std::max(mine, lmp->atom->tag[i]);
  MPI_Allreduce(&mine, &highest, 1, MPI_LMP_TAGINT, MPI_MAX, MPI_COMM_WORLD);
  lmp->atom->map_tag_max = highest;
  lmp.run(last - steps);
  EXPECT_GT(lmp->atom->map_tag_max, highest) << "a poor example";
  EXPECT_EQ(lmp->neighbor->ncalls, 0);
  for (int i = 0; i < lmp->atom->nlocal; ++i) EXPECT_EQ(lmp->atom->map(lmp->atom->tag[i]), i);
}

// A beam upon the border of two ranks, which is between two layers of elements, or upon that of a periodic box: other ranks and
// images learn of what has gone and come.
TEST(InPlace, UponABorder)
{
  const bool alone = size_of(MPI_COMM_WORLD) == 1;
  struct Case {
    std::string boundary, map, mode;
    double from;
  };
  for (const auto &c :
       {Case{"f f f", "array", "single", 0.066}, Case{"f f f", "hash", "single", 0.066},
        Case{"p f f", "array", "single", -0.036}, Case{"p f f", "hash", "single", -0.036},
        Case{"p f f", "array", "single", alone ? -0.035 : -0.036},
        Case{"f f f", "array", "multi", 0.066}}) {
    SCOPED_TRACE(c.boundary + ", map " + c.map + ", comm_modify " + c.mode);
    Scene scene;
    scene.from = c.from;
    scene.boundary = c.boundary;
    scene.map = c.map;
    if (c.mode == "multi") scene.more = "neighbor 5e-4 multi\ncomm_modify mode multi vel yes\n";
    expect_in_place(scene);
  }
}

// What LAMMPS would send on a reneighbouring step is there without one: all that is near, with the masses of now, and in the map.
TEST(InPlace, GhostsAtABorder)
{
  for (const std::string boundary : {"f f f", "p f f"})
    for (const std::string map : {"array", "hash"}) {
      SCOPED_TRACE(boundary + ", map " + map);
      Scene scene;
      scene.from = boundary == "f f f" ? 0.0653 : -0.0347;
      scene.boundary = boundary;
      scene.map = map;
      const Block block = scene.block();
      Lammps lmp(MPI_COMM_WORLD);
      lmp.commands(setup_of(scene, block));
      bend_across(lmp, block);
      lmp.run(last);
      ASSERT_GT(lmp.fe(CONVERTED), 20);
      ASSERT_LT(lmp->neighbor->lastcall, last - 20) << "a poor example";
      const auto all = lmp.particles();
      const auto &atom = *lmp->atom;
      const auto &domain = *lmp->domain;
      const int here = atom.nlocal + atom.nghost;

      for (int i = 0; i < here; ++i) {
        const auto owned = all.find(atom.tag[i]);
        ASSERT_NE(owned, all.end()) << "ghost " << atom.tag[i] << " has gone";
        const Particle &p = owned->second;
        EXPECT_EQ(atom.type[i], p.type);
        EXPECT_EQ(atom.radius[i], p.radius);
        EXPECT_EQ(atom.rmass[i], p.mass) << "atom " << p.tag;
        int k = lmp->atom->map(atom.tag[i]);
        EXPECT_TRUE(i >= atom.nlocal || k == i);
        while (k >= 0 && k != i) k = atom.sametag[k];
        EXPECT_EQ(k, i) << "atom " << p.tag << " is not in the map";
      }

      const double far = lmp->comm->cutghost[0] - 0.25 * lmp->neighbor->skin;
      int near = 0;
      for (const auto &one : all)
        for (int image = -1; image <= 1; ++image) {
          if (image != 0 && !domain.xperiodic) continue;
          const double x = one.second.x[0] + image * domain.xprd;
          bool inside = x > domain.sublo[0] - far && x < domain.subhi[0] + far;
          int k = lmp->atom->map(one.first);
          while (k >= 0 && std::abs(atom.x[k][0] - x) > 1e-9) k = atom.sametag[k];
          near += inside && k >= atom.nlocal;
          if (inside) { EXPECT_GE(k, 0) << "atom " << one.first << " at " << x << " is no ghost"; }
        }
      int others = 0;
      MPI_Allreduce(&near, &others, 1, MPI_INT, MPI_SUM, MPI_COMM_WORLD);
      if (size_of(MPI_COMM_WORLD) > 1 || domain.xperiodic) { EXPECT_GT(others, 100); }
    }
}

// Where the border goes through elements some of their DEs are another rank's.
TEST(InPlace, AcrossABorder)
{
  for (const std::string processors : {"* 1 1", "* * 1"})
    for (const std::string boundary : {"f f f", "p f f"}) {
      SCOPED_TRACE(boundary + ", processors " + processors);
      Scene scene;
      scene.processors = processors;
      scene.boundary = boundary;
      scene.from = boundary == "f f f" ? 0.0653 : -0.0347;
      expect_in_place(scene);
    }
}

// Periodic boxes: images of nodes are at other places in memory after each conversion.
TEST(InPlace, BesidePeriodicBorders)
{
  Scene scene;
  scene.boundary = "p f f";
  expect_in_place(scene);
  // to the last bit: then it must not depend on the ranks when atoms are wrapped around
  scene.options = "reproducible yes";
  const auto exact = run(scene);
  EXPECT_GE(exact.builds, steps_of_conversion(exact.events));
}

TEST(InPlace, SameOnAnyRanks)
{
  const auto here = run(Scene());
  if (rank_of(MPI_COMM_WORLD) == 0) { EXPECT_EQ(here.events, run(Scene(), MPI_COMM_SELF).events); }
  MPI_Barrier(MPI_COMM_WORLD);
}

// Who has lists of neighbours gets them anew.
TEST(InPlace, NotIfOthersHaveLists)
{
  const int conversions = steps_of_conversion(run(Scene()).events);
  for (const char *more :
       {"compute near all coord/atom cutoff 0.001\nthermo 1\ncompute most all reduce max c_near\n"
        "thermo_style custom step c_most\n",
        "comm_style tiled\n"}) {
    Scene scene;
    scene.more = more;
    const bool tiled = std::string(more) == "comm_style tiled\n";
    if (tiled && size_of(MPI_COMM_WORLD) == 1) continue;
    EXPECT_GE(run(scene).builds, conversions) << more;
  }
}

// Away from borders, and where one goes through elements.
TEST(InPlace, OverARestart)
{
  for (const double from : {0.04, 0.0653}) {
    SCOPED_TRACE(from);
    constexpr int middle = 100;
    Scene scene;
    scene.from = from;
    Block block = scene.block();
    run(scene);
    const std::string events = size_of(MPI_COMM_WORLD) == 1 ? "in_place.one.txt" : "in_place.txt";
    const History rest = history(events, middle);
    MPI_Barrier(MPI_COMM_WORLD);    // all have read it before it is written anew
    ASSERT_GT(steps_of_conversion(rest), 3) << "a poor example";
    scene.more = "restart " + std::to_string(middle) + " in_place.*.restart\n";
    run(scene);
    block.options += " events in_place.rest.txt";
    remove_file("in_place.rest.txt");
    {
      Lammps lmp;
      lmp.commands(block.header() + "read_restart in_place." + std::to_string(middle) +
                   ".restart\n" + block.fix_only() + block.motion());
      lmp.run(last - middle);
    }
    MPI_Barrier(MPI_COMM_WORLD);
    EXPECT_EQ(history("in_place.rest.txt"), rest);
    MPI_Barrier(MPI_COMM_WORLD);
  }
}
