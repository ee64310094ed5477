// Flaws that grow under load (strength ... rate): bars at four rates, strengths under a tension that is held, ranks and restarts.

#include "cracking_beam.h"
#include "failure.h"
#include "glass_bars.h"

#include "defe/coupling/flaw_growth.h"

#include <gmock/gmock.h>

#include <cmath>
#include <map>

using namespace defe::test;
using testing::HasSubstr;

namespace {

/// The tension of a bar is not even while elements beside the weakest place convert (test_strength_field.cpp).
constexpr double uneven = 0.04;

const std::string flaws =
    "strength glass weibull 7 50e6 area 4e-5 seed 31 surface all strength glass constant 300e6 ";

defe::FlawGrowth growth(double v_0)
{
  defe::FlawGrowth g;
  g.v_0 = v_0;
  g.K_Ic = 0.75e6;
  return g;
}

/// Tension at which a flaw of this strength breaks that is loaded with a constant rate.
double breaks_at(const defe::FlawGrowth &g, double strength, double rate)
{
  double low = 0.0, high = 1.0;
  for (int k = 0; k < 60; k++) {
    const double s = 0.5 * (low + high);
    const double grown =
        std::pow(s, g.n + 1.0) * std::pow(strength, 3.0) / ((g.n + 1.0) * g.B() * rate);
    (grown + std::pow(s, g.n - 2.0) < 1.0 ? low : high) = s;
  }
  return low * strength;
}

}    // namespace

// Density makes slow loads of fast ones: a hundred times as dense, ten times as slow in as many steps.
TEST(FlawGrowth, BarsAtFourRatesBreakAsTheClosedFormSays)
{
  const auto g = growth(1.0);
  int ranks;
  MPI_Comm_size(MPI_COMM_WORLD, &ranks);
  for (const std::string start : {"", "start all"}) {
    double inert = 0.0, slowest = 0.0;
    for (double dense : {1.0, 1e2, 1e4, 1e6}) {
      const bool between = dense == 1e2 || dense == 1e4;
      if (between && (!start.empty() || ranks > 2)) continue;    // takes long
      SCOPED_TRACE(start + " density times " + number(dense));
      Bars bars;
      bars.rows = bars.columns = 2;
      bars.steps = 200;
      bars.rho = 2500.0 * dense;
      bars.start = start;
      bars.strength = flaws + "strength " + "glass " + g.words();
      const auto broken = break_all(bars, "rates.txt");
      const double rate = bars.tension(1.0) / bars.dt();
      for (int b = 0; b < bars.count(); b++)
        EXPECT_NEAR(broken.tension[b] / breaks_at(g, broken.drawn[b], rate), 1.0, uneven)
            << "bar " << b;
      if (dense == 1.0) inert = broken.tension[0];
      slowest = broken.tension[0];
    }
    EXPECT_LT(slowest, 0.85 * inert);
  }
}

TEST(FlawGrowth, UnderATensionThatIsHeld)
{
  const double E = 74.09e9, nu = 0.2, tension = 45e6, dt = 1e-15;
  const int steps = 12;
  const auto g = growth(5e10);
  const defe::Mat3 strain =
      defe::Vec3(tension / E, -nu * tension / E, -nu * tension / E).asDiagonal();
  for (const std::string how : {"stress centre", "stress gauss", "stress gauss every 3", "all",
                                "all every 3", "stress gauss prestress", "all prestress"}) {
    SCOPED_TRACE(how);
    Block block;
    const bool all = how.rfind("all", 0) == 0, before = how.find("prestress") != std::string::npos;
    block.options = (all ? how.substr(3) : how) +
        (before ? " glass variables v_held NULL NULL NULL NULL NULL" : "") +
        " strength glass truncated 4 100e6 55e6 volume 8e-9 seed 5 strength glass " + g.words();
    block.convert = std::string("600e9 type 2 group particles ") + (all ? "start all" : "");
    block.coeff = "connective material cohesive 600e6 10 0.1 contact 0.9 0.2";
    block.dt = dt;
    Lammps lmp;
    lmp.commands(
        block.script() + "variable held atom 45e6\n" +
        "compute hexes all defe/hex/local id strength\ncompute des all defe/atom strength\n");
    lmp.run(0);
    const auto strengths = [&] {
      std::map<long, double> found;
      if (all)
        for (const auto &[tag, s] : lmp.per_atom("des")) found[tag] = s;
      else
        for (const auto &row : lmp.local("hexes")) found[std::lround(row[0])] = row[1];
      return found;
    };
    const auto drawn = strengths();
    if (!before)
      lmp.change([&](Particle &p) {
        p.x += strain * p.x;
      });
    lmp.run(steps);
    double most = 0.0;
    for (const auto &[id, s] : strengths()) {
      const double lost = drawn.at(id) - s;
      const double expected = drawn.at(id) - g.weakened(drawn.at(id), tension, steps * dt);
      // the strain is finite: at its 16th power
      EXPECT_NEAR(lost, expected, 0.03 * expected + 1e-9 * drawn.at(id)) << drawn.at(id);
      most = std::max(most, drawn.at(id) / s);
    }
    EXPECT_GT(most, 1.05) << "a poor example";
  }
}

TEST(FlawGrowth, SameOnAnyRanksAndOverARestart)
{
  Block block = cracking_beam();
  block.options =
      "strength glass weibull 5 70e6 area 1e-5 seed 4 surface all strength glass constant "
      "200e6 strength glass rate 100 0.75e6";
  same_on_any_ranks_and_over_a_restart(block, "growth", 200, 10);
}

TEST(FlawGrowth, ThatIsSlowChangesNothingAndThatIsFastDoes)
{
  Block block = cracking_beam();
  const auto events = [&](const std::string &rate, const std::string &file) {
    block.options =
        "strength glass weibull 5 70e6 area 1e-5 seed 4 surface all strength glass constant "
        "200e6 " +
        rate + " events " + file;
    remove_file(file);
    {
      Lammps lmp;
      lmp.commands(block.script());
      bend(lmp, block);
      lmp.run(150);
    }
    MPI_Barrier(MPI_COMM_WORLD);
    return history(file);
  };
  const History without = events("", "inert.txt");
  EXPECT_GT(without.size(), 30u) << "a poor example";
  EXPECT_EQ(events("strength glass rate 1e-20 0.75e6", "slow.txt"), without);
  EXPECT_NE(events("strength glass rate 100 0.75e6", "fast.txt"), without);
}

TEST(FlawGrowth, WrongOnesAreRefused)
{
  const auto with = [](const std::string &options, const std::string &convert = "",
                       const std::string &law = "") {
    Block block;
    block.options = options;
    if (!convert.empty()) block.convert = convert + " type 2 group particles";
    block.coeff = "connective material cohesive 6e7 10.0 0.1" + law + " contact 0.9 0.2";
    return failure(block.script() + "run 0\n");
  };
  const std::string rate = "strength glass rate 6e-3 0.75e6 ",
                    flaw = "strength glass constant 50e6 ";
  EXPECT_EQ(with(flaw + rate), "");
  EXPECT_THAT(with(rate), HasSubstr("rate says how flaws grow, but there are none"));
  EXPECT_THAT(with(flaw + rate + rate), HasSubstr("Fix defe strength glass: rate is given twice"));
  EXPECT_THAT(with(flaw + "strength glass rate 6e-3"), HasSubstr("KIc"));
  EXPECT_THAT(with(flaw + "strength glass rate 6e-3 0.75e6 exponent 1"),
              HasSubstr("Fix defe strength glass rate: exponent must be 5 to 200, not 1"));
  EXPECT_THAT(with(flaw + rate, "mises 48e6"), HasSubstr("elements convert by 'mises 48000000'"));
  EXPECT_THAT(with(flaw + rate, "", " lattice"), HasSubstr("give pair_coeff 2 2 without lattice"));
}
