// Finite elements every m-th step, everything else at every step.
//
// timeout: 240

#include "contact_scene.h"
#include "cracking_beam.h"

#include <gmock/gmock.h>

#include <set>

using namespace defe::test;
using defe::Vec3;

namespace {

/// A block that vibrates and turns, no DEs.
void swing(Lammps &lmp, const Block &block)
{
  lmp.change([&](Particle &p) {
    const Vec3 d = p.x - block.centre();
    p.v = Vec3(0.0, 0.0, 300.0).cross(d) + Vec3(1500.0 * d[0], -800.0 * d[1], 500.0 * d[0]);
  });
}

Block bar()
{
  Block block;
  block.n[0] = 8;
  block.n[1] = 2;
  block.n[2] = 2;
  block.dt = 3e-8;
  return block;
}

}    // namespace

// The total energy, at any step: kinetic energy is that of velocities in step with the positions.
TEST(TwoClocks, EnergyOfVibrationAtEveryStep)
{
  for (int m : {1, 2, 3, 4, 5}) {
    Block block = bar();
    block.options = "every " + std::to_string(m);
    Lammps lmp;
    lmp.commands(block.script());
    swing(lmp, block);
    lmp.record({"f_fe[22]", "f_fe[9]", "f_fe[14]"}, 1);
    lmp.run(600);
    const auto total = lmp.recorded(0), strain = lmp.recorded(1), kinetic = lmp.recorded(2);
    const double swing_of_strain = *std::max_element(strain.begin(), strain.end());
    EXPECT_GT(swing_of_strain, 0.1 * total[0]) << "a poor example";
    // velocity Verlet with the step m dt keeps its energy to (omega m dt)^2/8 of what swings, here
    // with waves down to the length of some elements
    EXPECT_LT(largest_deviation(total), 0.012 * m * m / 25.0 * swing_of_strain) << "every " << m;
  }
}

// The same motion, to second order in the step.
TEST(TwoClocks, SameMotion)
{
  std::vector<Particles> end;
  for (int m : {1, 2, 4}) {
    Block block = bar();
    block.options = "every " + std::to_string(m);
    Lammps lmp;
    lmp.commands(block.script());
    swing(lmp, block);
    lmp.run(400);
    end.push_back(lmp.particles());
  }
  const double two = difference(end[0], end[1], &Particle::x);
  const double four = difference(end[0], end[2], &Particle::x);
  EXPECT_LT(four, 1e-3 * largest(end[0], &Particle::x));
  // (4^2 - 1)/(2^2 - 1) = 5
  EXPECT_NEAR(four / two, 5.0, 0.5);
}

// A crack, its conversions and a restart between two evaluations of the elements.
TEST(TwoClocks, RestartBetweenTheClocks)
{
  Block block = cracking_beam();
  Particles whole;
  std::vector<std::array<long, 2>> list;
  {
    block.options = "every 3 check yes events whole.txt";
    remove_file("whole.txt");
    Lammps lmp;
    lmp.commands(block.script() + "restart 1 clock.*.restart\n");
    bend(lmp, block);
    lmp.run(103);
    lmp.command("restart 0");
    lmp.run(97);
    whole = lmp.particles();
    MPI_Barrier(MPI_COMM_WORLD);
    list = conversions("whole.txt");
    EXPECT_GT(list.size(), 16u) << "a poor example";
  }
  // marked at a multiple of 3, converted when the impulse of three steps has ended
  for (const auto &c : list) EXPECT_EQ(c[0] % 3, 2) << "element " << c[1];
  std::set<long> steps = {100, 101, 102};
  for (const auto &c : list)
    if (c[0] > 60 && c[0] < 100) steps.insert(c[0] - 1);    // marked, not yet converted
  EXPECT_GT(steps.size(), 3u);
  for (long step : steps) {
    block.options = "every 3 check yes events again.txt";
    remove_file("again.txt");
    Lammps lmp;
    lmp.commands(block.header() + "read_restart clock." + std::to_string(step) + ".restart\n" +
                 block.fix_only() + block.motion());
    lmp.run(200 - step);
    MPI_Barrier(MPI_COMM_WORLD);
    std::vector<std::array<long, 2>> rest;
    for (const auto &c : list)
      if (c[0] > step) rest.push_back(c);
    EXPECT_EQ(conversions("again.txt"), rest) << "from step " << step;
    EXPECT_LT(difference(whole, lmp.particles(), &Particle::x), 2e-12) << "from step " << step;
  }
  // another ratio of the clocks: only where they meet
  const auto failure = [&](long step) -> std::string {
    block.options = "every 2";
    Lammps lmp;
    try {
      lmp.commands(block.header() + "read_restart clock." + std::to_string(step) + ".restart\n" +
                   block.fix_only() + block.motion() + "run 1");
    } catch (std::exception &e) {
      return e.what();
    }
    return "";
  };
  EXPECT_EQ(failure(102), "");
  EXPECT_THAT(failure(101), testing::HasSubstr("both clocks meet (a multiple of 3)"));
}

TEST(TwoClocks, SlowStepAboveTheStableOne)
{
  Block block = bar();
  block.dt = 1e-7;
  block.options = "every 4";
  Lammps lmp;
  lmp.commands(block.script());
  try {
    lmp.run(1);
    ADD_FAILURE() << "was accepted";
  } catch (std::exception &e) {
    EXPECT_THAT(e.what(), testing::HasSubstr("1e-07 times every 4 is above the stable step"));
  }
}

// DEs on finite elements and the noise of rounding: impulses of the elements in step with half an oscillation
// of the DEs made 100 J of nothing. It is warned of before the first step; within the
// bound nothing grows.
TEST(TwoClocks, ResonanceWithDEs)
{
  struct Case {
    int m;
    double dt;
    bool grows;
  };
  // DEs of 0.75 x 0.75 x 0.5 mm
  for (const Case &c : {Case{3, 4e-8, true}, Case{2, 5.5e-8, true}, Case{1, 4e-8, false},
                        Case{2, 4e-8, false}, Case{3, 3e-8, false}, Case{5, 1.8e-8, false}}) {
    Block block;
    block.n[1] = 3;
    block.n[2] = 4;
    block.h = 1.5e-3;
    block.flat = 1.0 / 1.5;
    block.dt = c.dt;
    block.regions = "region lower block INF INF INF INF INF 2e-3";
    block.convert = "1e15 type 2 group particles start lower";
    block.coeff = "connective material cohesive 1e15 1e15 0.1 contact 1.0 0.0";
    block.options = "every " + std::to_string(c.m);
    Lammps lmp;
    lmp.commands(block.script());
    lmp.change([](Particle &p) {
      p.v = 1e-3 * random_of(p.tag, 5);
    });
    WarningLog log(lmp, "log.resonance");
    lmp.record({"f_fe[23]", "f_fe[3]"}, 20);
    lmp.run(c.m * 1000);
    const auto balance = lmp.recorded(0);
    ASSERT_EQ(lmp.recorded(1).back(), 8.0 * 4 * 3 * 2);
    const std::string said = "Fix defe every";
    int warned = 0;
    for (const auto &line : log.warnings()) warned += line.compare(0, said.size(), said) == 0;
    EXPECT_EQ(warned, c.grows ? 1 : 0) << "every " << c.m << ", " << c.dt;
    // waves of the length of an element swing by (omega m dt)^2/8 of what they have
    if (c.grows)
      EXPECT_GT(balance.back(), 1e3 * balance.front()) << "every " << c.m << ", " << c.dt;
    else
      EXPECT_LT(largest_deviation(balance), 0.04 * balance.front())
          << "every " << c.m << ", " << c.dt;
  }
}
