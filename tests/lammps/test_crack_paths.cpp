// A crack in a notched strip whose lattice is turned, through LAMMPS: it goes straight on, and takes G_f per
// area. Discrete elements from the start, and finite elements that convert before it. More orientations, and nodes
// moved at random, are in verification/test_all_crack_paths.cpp.
//
// 12 s of processor time on one rank: five strips, until a crack has run through, and six plates that branch.
//
// timeout: 240

#include "crack_strip.h"
#include "failure.h"

#include <gmock/gmock.h>

using namespace defe::test;
using defe::Mat3;
using defe::Vec3;

namespace {

/// They are measured on one rank; that ranks do not matter is a test of its own.
bool one_rank()
{
  return size_of(MPI_COMM_WORLD) == 1;
}

CrackStrip strip(const Mat3 &turn, double G_f, bool adaptive)
{
  CrackStrip s;
  s.turn = turn;
  s.G_f = G_f;
  s.adaptive = adaptive;
  return s;
}

}    // namespace

TEST(CrackPaths, DiscreteElements)
{
  if (!one_rank()) GTEST_SKIP() << "measured on one rank";
  expect_straight("22.5", strip(turned(22.5), 10.0, false), 0.05, 0.08);
  expect_straight("45, G_f 50", strip(turned(45), 50.0, false));
  CrackStrip tilted = strip(turned(22.5, 22.5), 10.0, false);
  tilted.thickness = 10.0;
  expect_straight("22.5 and 22.5", tilted);
}

// A crack that passes an element on its corner asks for it if it needs it: at 45 degrees it stopped for good there once.
// Most of what converts cracks.
TEST(CrackPaths, ElementsThatConvert)
{
  if (!one_rank()) GTEST_SKIP() << "measured on one rank";
  // Samples: with 4e-8 to 5.5e-8 s, 0.71 (one of eight) to 0.98 of what converts cracks, and the energy is 1.00 to 1.07 G_f.
  CrackStrip straight = strip(turned(45), 50.0, true), moved = strip(turned(30), 10.0, true);
  moved.moved = 0.15;
  for (const CrackPath &r :
       {expect_straight("45, G_f 50", straight), expect_straight("30, nodes moved", moved)})
    EXPECT_GE(r.holding, 0.8 * r.converted);
}

// Under a load ten times what a crack needs it branches, whatever the lattice, and no crack outruns Rayleigh waves.
TEST(CrackPaths, Branching)
{
  if (!one_rank()) GTEST_SKIP() << "measured on one rank";
  constexpr double rayleigh = 3192.0;
  for (double angle : {0.0, 22.5, 45.0})
    for (bool adaptive : {false, true}) {
      CrackStrip plate = strip(turned(angle), 10.0, adaptive);
      plate.left = -10.0;
      plate.right = 60.0;
      plate.tough_end = 4.0;
      plate.height = 60.0;
      plate.thickness = 2.0;
      plate.strain = 4.5e-4;
      plate.rate = 0.0;
      const MeshFile mesh = mesh_of(plate);
      Lammps lmp(MPI_COMM_SELF);
      prepare(lmp, plate, mesh, MPI_COMM_SELF);
      lmp.run(430);
      const auto events = read_events(plate.name + ".txt");
      const double first = speed_between(events, 5.0, 25.0),
                   second = speed_between(events, 25.0, 45.0);
      int arms = 0, places = 0;
      for (double x = 30.0; x < 57.0; x += 5.0) {
        arms = std::max(arms, arms_at(events, x));
        places += arms_at(events, x) >= 2;
      }
      std::printf("%4.1f deg%s: %.0f and %.0f m/s, arms %d, at %d of 6 places\n", angle,
                  adaptive ? ", adaptive" : "", first, second, arms, places);
      EXPECT_GT(first, 2000.0);
      EXPECT_GT(second, 2000.0);
      EXPECT_LT(first, rayleigh);
      EXPECT_LT(second, rayleigh);
      EXPECT_EQ(arms_at(events, 5.0), 1);
      EXPECT_GE(places, 3) << "at so many of six places there are two arms or more";
    }
}

// A joint that softens goes on by the law that it began with: another one is refused, also after a restart.
TEST(CrackPaths, LawsOfCracksCannotChange)
{
  const std::string joint = "pair_coeff 3*5 3*5 connective material cohesive 60e6 10 0.1",
                    contact = " contact 0.9 0.2\n";
  const CrackStrip s = strip(turned(0), 10.0, false);
  const MeshFile mesh = mesh_of(s);
  Lammps lmp;
  prepare(lmp, s, mesh, MPI_COMM_WORLD);
  lmp.commands(joint + contact + "run 5\nwrite_restart laws.restart\n");
  EXPECT_THAT(failure(lmp, joint + " lattice" + contact + "run 0"),
              testing::ContainsRegex(
                  "Pair_coeff 4 5 cohesive: [0-9]+ joints have cracked by the law rings, which "
                  "cannot change: give it rings as before"));
  for (const std::string law : {"", " rings", " lattice"}) {
    Lammps again;
    const std::string message = failure(again,
                                        header_of(s) + "read_restart laws.restart\n" + fix_of(s) +
                                            motion_of(s) + joint + law + contact + "run 5\n");
    EXPECT_EQ(message.find("give it rings as before") != std::string::npos, law == " lattice")
        << message;
  }
}

// All that happens, on any number of ranks and over a restart.
TEST(CrackPaths, SameOnAnyRanksAndOverARestart)
{
  constexpr int middle = 900, end = 1100;
  CrackStrip s = strip(turned(30), 10.0, true);
  s.options = "reproducible yes";
  const MeshFile mesh = mesh_of(s);
  s.name = "one";
  on_one_rank([&] {
    Lammps lmp(MPI_COMM_SELF);
    prepare(lmp, s, mesh, MPI_COMM_SELF);
    lmp.run(end - 40);
    return Particles();
  });
  s.name = "all";
  {
    Lammps lmp;
    prepare(lmp, s, mesh, MPI_COMM_WORLD);
    lmp.run(middle - 40);
    lmp.command("write_restart all.restart");
  }
  {
    Lammps lmp;
    lmp.commands(header_of(s) + "read_restart all.restart\n" + fix_of(s) + motion_of(s));
    lmp.run(end - middle);
  }
  MPI_Barrier(MPI_COMM_WORLD);
  const auto one = read_events("one.txt"), all = read_events("all.txt");
  ASSERT_EQ(one.size(), all.size());
  int late = 0;
  for (size_t k = 0; k < one.size(); k++) {
    const Event &e = one[k], &f = all[k];
    EXPECT_EQ(e.step, f.step);
    EXPECT_EQ(e.what, f.what);
    EXPECT_EQ(e.a, f.a);
    EXPECT_EQ(e.b, f.b);
    EXPECT_EQ(Vec3(e.x), Vec3(f.x));
    EXPECT_EQ(Vec3(e.n), Vec3(f.n));
    EXPECT_EQ(e.value, f.value);
    late += e.step > middle;
  }
  EXPECT_GT(late, 50) << "a poor example";
  EXPECT_LT(late, static_cast<int>(one.size()) - 50) << "a poor example";
}
