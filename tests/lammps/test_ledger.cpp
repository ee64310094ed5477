// The energy ledger: what other forces do is counted as external work, and the balance closes.
//
// timeout: 120

#include "glass_block.h"

#include <cmath>

using namespace defe::test;
using defe::Vec3;

namespace {

/// `load` (commands after the fixes that move things) acts on a free block; energy gained = work.
/// `impulse`: what the force gives to the block, from outside.
void free_block(const std::string &load, const std::string &start, const Vec3 &force,
                double tolerance)
{
  Block block;
  block.regions = "region half block INF 0.004 INF INF INF INF";
  block.convert += start;
  Lammps lmp;
  lmp.commands(block.script() + load);
  lmp.change([](Particle &p) {
    p.v = Vec3(1.0, 0.0, -0.5);
  });
  lmp.run(0);
  const Particles before = lmp.particles();
  const double total = lmp.fe(TOTAL), kinetic = lmp.fe(E_KINETIC);
  EXPECT_NEAR(total / kinetic, 1.0, 1e-12);
  lmp.record({"f_fe[22]", "f_fe[21]"}, 10);
  const int steps = 1000;
  lmp.run(steps);
  const double gain =
      lmp.fe(E_KINETIC) + lmp.fe(E_ELEMENTS) + lmp.fe(E_JOINTS) + lmp.fe(E_TIES) - total;
  const double work = lmp.fe(EXTERNAL);
  EXPECT_GT(work, 0.5 * total) << load;    // much more than rounding
  // the work is that of the kicks of velocity Verlet, exactly; the energy swings by (omega dt)^2/4
  // of the strain energy, a small part of it
  EXPECT_NEAR(gain / work, 1.0, tolerance) << load;
  EXPECT_LT(largest_deviation(lmp.recorded(0)), tolerance * work) << load;
  // momentum: the first and the last kick are half ones
  const Vec3 impulse = steps * block.dt * force;
  const Particles after = lmp.particles();
  EXPECT_LT((momentum(after) - momentum(before) - impulse).norm(), 1e-9 * impulse.norm()) << load;
}

}    // namespace

// On a corner of the block, so that it turns and vibrates: 36 N on three nodes.
TEST(Ledger, WorkOfAddForceIsBooked)
{
  const std::string load = "group corner id 1 2 3\nfix push corner addforce 4 -2 8\n";
  free_block(load, "", Vec3(12.0, -6.0, 24.0), 2e-3);
}

// Gravity acts on nodes and DEs alike: g m, 2e5 m/s2.
TEST(Ledger, WorkOfGravityIsBooked)
{
  const std::string load = "fix fall all gravity 2e5 vector 0 -1 0\n";
  const Block block;
  for (const std::string start : {"", " start half", " start all"})
    free_block(load, start, Vec3(0.0, -2e5 * block.mass(), 0.0), 1e-6);
}

// A support that does not move does no work; the body vibrates on it with constant energy.
TEST(Ledger, SupportAtRestDoesNoWork)
{
  for (const std::string start : {"", " start half"}) {
    Block block;
    block.n[0] = 10;
    block.regions = "region half block 0.008 0.014 INF INF INF INF";
    block.convert += start;
    Lammps lmp;
    lmp.commands(block.script() +
                 "region foot block INF 1e-6 INF INF INF INF\ngroup foot region foot\n"
                 "fix hold foot setforce 0 0 0\n");
    lmp.change([](Particle &p) {
      p.v = Vec3(0.0, 50.0 * p.x[0], 10.0 * p.x[0]);
    });
    lmp.run(0);
    const double total = lmp.fe(TOTAL);
    lmp.record({"f_fe[22]", "f_fe[21]", "f_fe[14]"}, 10);
    lmp.run(2000);
    const auto kinetic = lmp.recorded(2);
    EXPECT_LT(*std::min_element(kinetic.begin(), kinetic.end()), 0.2 * total);
    EXPECT_LT(largest_deviation(lmp.recorded(1)), 1e-15 * total) << start;
    // omega dt = 0.003 for the lowest mode; higher ones come in with the sudden start
    EXPECT_LT(largest_deviation(lmp.recorded(0)), 1e-4 * total) << start;
  }
}

// Viscous forces take out what they do: external work is negative, the total stays.
TEST(Ledger, WorkOfViscousForcesIsBooked)
{
  Block block;
  Lammps lmp;
  lmp.commands(block.script() + "fix calm all viscous 2\n");
  lmp.change([&](Particle &p) {
    p.v = 3.0 * random_of(p.tag, 1);
  });
  lmp.run(0);
  const double total = lmp.fe(TOTAL);
  lmp.record({"f_fe[22]", "f_fe[21]"}, 10);
  lmp.run(400);
  const auto work = lmp.recorded(1);
  EXPECT_LT(work.back(), -0.5 * total);
  // random motion has omega dt up to 0.6, and the viscous force is that of half-step velocities
  EXPECT_LT(largest_deviation(lmp.recorded(0)), 0.05 * total);
}

// Pulled by a moving grip until it breaks: all entries together close the balance.
TEST(Ledger, BalanceOfABreakingBlock)
{
  Block block;
  block.n[0] = 8;
  block.n[1] = block.n[2] = 2;
  block.dt = 3e-8;
  block.convert = "5.6e7 type 2 group particles";
  block.coeff = "connective material cohesive 6e7 10 0.1 contact 0.9 0.2";
  Lammps lmp;
  lmp.commands(block.script() + R"(
    region          left block INF 1e-6 INF INF INF INF
    region          right block 0.0159 INF INF INF INF INF
    group           left region left
    group           right region right
    velocity        right set 4 0 0
    fix             hold left setforce 0 0 0
    fix             pull right setforce 0 0 0
  )");
  lmp.change([&](Particle &p) {
    p.v = Vec3(4.0 * p.x[0] / 0.016, 0.0, 0.0);
    if (p.x[0] < 1e-6) p.v.setZero();
  });
  lmp.run(0);
  const double start = lmp.fe(TOTAL);
  lmp.record({"f_fe[22]", "f_fe[23]", "f_fe[21]", "f_fe[15]", "f_fe[16]"}, 5);
  lmp.run(1200);
  EXPECT_GT(lmp.fe(CONVERTED), 3);
  EXPECT_GT(lmp.fe(CONTACT), 15);
  const double work = lmp.fe(EXTERNAL), g_f = 10.0 * 1e-6;
  EXPECT_GT(work, start);
  // every broken joint has given exactly G_f d^2, softening ones less
  EXPECT_GE(lmp.fe(FRACTURE), 0.999 * g_f * lmp.fe(CONTACT));
  EXPECT_LE(lmp.fe(FRACTURE), 1.001 * g_f * (lmp.fe(CONTACT) + lmp.fe(COHESIVE)));
  EXPECT_GT(lmp.fe(RELEASE), lmp.fe(FRACTURE));    // strength-controlled: 34 J/m2, 10 of it G_f
  EXPECT_LT(largest_deviation(lmp.recorded(1)), 0.01 * (start + work));
  // the total loses what conversions lose, and never gains
  const auto total = lmp.recorded(0);
  for (size_t k = 1; k < total.size(); k++)
    EXPECT_LT(total[k], total[0] + 0.01 * (start + work)) << k;
}
