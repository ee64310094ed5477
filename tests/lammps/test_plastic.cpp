// Metals through LAMMPS: a bar pulled beyond yield and let go, the same on any ranks and over a restart while it flows;
// what is told of plastic strain and heat; minimization, in which nothing flows.

#include "lammps_run.h"

#include <algorithm>

using namespace defe::test;

namespace {

constexpr double E = 200e9, rho = 7830.0, h = 1e-3;

const std::string steel =
    "johnson-cook 200e9 0.29 7830 792e6 510e6 0.26 0.014 1 thermal 1.03 293 1793 477 0.9";

/// A bar of 8 x 2 x 2 cubes along x, one end held, the other drawn at 40 m/s: 5000/s.
struct Bar {
  std::string material;
  std::string options = "";    // of fix defe

  std::string head() const { return script_head(); }
  std::string fix() const
  {
    return "pair_style zero 0.001\npair_coeff * *\ngroup particles empty\nfix fe all defe material "
           "steel " +
        material + " " + options + "\n";
  }
  std::string mesh() const
  {
    return "region box block -0.002 0.014 -0.003 0.005 -0.003 0.005\ncreate_box 2 box\n" + fix() +
        "create_hexes fe steel 1 x 0 8 0.008 y 0 2 0.002 z 0 2 0.002\n"
        "region left block INF 1e-6 INF INF INF INF\ngroup left region left\n"
        "region right block 0.007999 INF INF INF INF INF\ngroup right region right\n"
        // as if all of it was drawn out evenly from the start
        "variable v atom x*5000\nvelocity all set v_v NULL NULL\n";
  }
  std::string motion() const
  {
    return "group nodes type 1\nfix move1 nodes nve\nfix hold left setforce 0 NULL NULL\n"
           "fix pull right setforce 0 NULL NULL\nneighbor 0.0005 bin\ntimestep 2e-8\n"
           "compute state all defe/hex/local id sxx plastic heating syy\n";
  }
  std::string script() const { return head() + mesh() + motion(); }
};

/// Rows of the compute in the order of the IDs.
std::vector<std::vector<double>> states(Lammps &lmp)
{
  auto rows = lmp.local("state");
  std::sort(rows.begin(), rows.end());
  return rows;
}

TEST(Plastic, BarInTensionIsAtItsYieldStress)
{
  const double A = 792e6, B = 510e6, n = 0.26, C = 0.014, m = 1.03;
  Lammps lmp;
  lmp.commands(Bar{steel}.script());
  lmp.record({"f_fe[23]"}, 50);
  lmp.run(1000);
  // 2e-5 s at 5000/s: 10 %
  for (const auto &row : states(lmp)) {
    const double eps = row[2], T = row[3];
    EXPECT_NEAR(eps, 0.095, 0.01);
    const double flow =
        (A + B * std::pow(eps, n)) * (1.0 + C * std::log(5000.0)) * (1.0 - std::pow(T / 1500.0, m));
    // the means of the element's points, at a rate that swings a little
    EXPECT_NEAR(row[1] - row[4], flow, 0.01 * flow);
    // 0.9 of the work, of about 1100 MPa over eps
    EXPECT_NEAR(T, 0.9 * 0.93 * flow * eps / (rho * 477.0), 0.05 * T);
  }
  // the energy that came in is kinetic, stored or dissipated, the last by far
  EXPECT_LT(largest_deviation(lmp.recorded()), 2e-3 * lmp.fe(VISCOUS));
  EXPECT_NEAR(lmp.fe(VISCOUS), 32e-9 * 1.06e9 * 0.095, 0.1 * lmp.fe(VISCOUS));

  // let go, it keeps its plastic strain
  const auto before = states(lmp);
  lmp.commands("unfix hold\nunfix pull\nfix damp all viscous 0.5");
  lmp.run(2000);
  const auto after = states(lmp);
  for (size_t k = 0; k < after.size(); k++) {
    EXPECT_NEAR(after[k][2], before[k][2], 0.01);
    EXPECT_LT(std::abs(after[k][1]), 0.1 * A);
  }
}

TEST(Plastic, LinearHardening)
{
  Lammps lmp;
  lmp.commands(Bar{"plastic 200e9 0.29 7830 800e6 2e9"}.script());
  lmp.run(1000);
  for (const auto &row : states(lmp)) {
    EXPECT_NEAR(row[1] - row[4], 800e6 + 2e9 * row[2], 3e-3 * 800e6);
    EXPECT_NEAR(row[2], 0.095, 0.01);
    EXPECT_EQ(row[3], 0.0);
  }
}

TEST(Plastic, TheSameOnAnyRanksAndOverARestartInTheMiddleOfFlow)
{
  for (const std::string &options : {std::string("every 2"), std::string("reproducible yes")}) {
    const Bar bar{steel, options};
    // unequal, so that the flow is not uniform
    const auto bend = [](Particle &p) {
      p.v[1] = 30.0 * p.x[0] / 0.008;
    };
    const auto one = on_one_rank([&] {
      Lammps lmp(MPI_COMM_SELF);
      lmp.commands(bar.script());
      lmp.change(bend);
      lmp.run(400);
      return lmp.particles();
    });
    double plastic, dissipated;
    {
      Lammps lmp;
      lmp.commands(bar.script());
      lmp.change(bend);
      lmp.command("restart 200 plastic.*");
      lmp.run(400);
      EXPECT_LT(difference(one, lmp.particles(), &Particle::x), 1e-13);
      plastic = states(lmp)[5][2];
      dissipated = lmp.fe(VISCOUS);
      EXPECT_GT(plastic, 0.01);
    }
    Lammps lmp;
    lmp.commands(bar.head() + "read_restart plastic.200\n" + bar.fix() + bar.motion());
    EXPECT_EQ(lmp.step(), 200);
    lmp.run(0);
    EXPECT_GT(states(lmp)[5][2], 0.005);
    lmp.run(200);
    EXPECT_LT(difference(one, lmp.particles(), &Particle::x), 1e-13);
    EXPECT_NEAR(states(lmp)[5][2], plastic, 1e-9);
    EXPECT_NEAR(lmp.fe(VISCOUS), dissipated, 1e-9 * dissipated);
    remove_file("plastic.200");
    remove_file("plastic.400");
  }
}

TEST(Plastic, NothingFlowsInAMinimization)
{
  Lammps lmp;
  lmp.commands(Bar{"plastic 200e9 0.29 7830 800e6 2e9"}.script());
  lmp.commands("velocity all set 0 0 0\ndisplace_atoms right move 1e-4 0 0\nunfix "
               "move1\nmin_modify dmax 1e-5\n"
               "fix x right setforce 0 0 0\nfix y left setforce 0 0 0\nminimize 0 1e-3 200 400");
  for (const auto &row : states(lmp)) {
    EXPECT_EQ(row[2], 0.0);
    EXPECT_GT(row[1], 1.5e9);
  }
  lmp.command("fix move1 nodes nve");
  lmp.run(10);
  EXPECT_GT(states(lmp)[3][2], 0.001);
}

}    // namespace
