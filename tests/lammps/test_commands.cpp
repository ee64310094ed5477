// Commands of LAMMPS between, before and instead of runs: each does the right thing or is refused
// in one line that says why.
//
// ranks: 1 2 4
// timeout: 240

#include "cracking_beam.h"
#include "failure.h"
#include "mesh_file.h"

#include <gmock/gmock.h>

#include <cmath>

using namespace defe::test;
using defe::Vec3;
using testing::AllOf;
using testing::HasSubstr;

namespace {

constexpr double h = 2e-3;

/// 1e-9 of an element edge
constexpr double same_place = 1e-9 * h;

/// The cracking beam, ready for its first step; with damping and friction, or without.
void make_beam(Lammps &lmp, const std::string &events = "", const std::string &more = "",
               bool damped = false)
{
  Block block = cracking_beam();
  // joint by joint there is rubble that rubs
  if (damped) block.coeff = "connective material cohesive 6e7 10.0 0.1 lattice contact 0.9 0.2";
  if (!damped) block.coeff = "connective material cohesive 6e7 10.0 0.1 contact 1.0 0.0";
  if (!events.empty()) {
    remove_file(events);
    block.options = "events " + events;
  }
  lmp.commands(block.header() + more + block.box() + block.fix() + block.mesh() + block.motion());
  bend(lmp, block);
}

struct Outcome {
  Particles particles;
  History events;
  double balance, fracture;
};

Outcome outcome(Lammps &lmp, const std::string &events, long after = -1)
{
  MPI_Barrier(MPI_COMM_WORLD);    // rank 0 has written
  const History list = history(events, after);
  MPI_Barrier(MPI_COMM_WORLD);    // all have read: it may be removed
  return {lmp.particles(), list, lmp.fe(BALANCE), lmp.fe(FRACTURE)};
}

/// The beam without interruption.
const Outcome &straight(long steps, bool damped = false)
{
  static std::map<std::pair<long, bool>, Outcome> known;
  const auto which = std::make_pair(steps, damped);
  if (!known.count(which)) {
    Lammps lmp;
    make_beam(lmp, "straight.txt", "", damped);
    lmp.run(steps);
    known[which] = outcome(lmp, "straight.txt");
  }
  return known.at(which);
}

void expect_same(const Outcome &a, const Outcome &b, const std::string &what,
                 double tolerance = same_place)
{
  EXPECT_EQ(a.events, b.events) << what;
  ASSERT_EQ(a.particles.size(), b.particles.size()) << what;
  EXPECT_LT(difference(a.particles, b.particles, &Particle::x), tolerance) << what;
  EXPECT_NEAR(a.balance, b.balance, 1e-9 * std::abs(a.balance)) << what;
  EXPECT_NEAR(a.fracture, b.fracture, 1e-9 * std::abs(a.fracture)) << what;
}

}    // namespace

TEST(Commands, SeveralRunsAreOne)
{
  EXPECT_GT(straight(200, true).events.size(), 50u) << "a poor example";
  const std::vector<std::string> ways = {
      "run 60\nrun 0\nrun 40\nrun 0\nrun 100", "run 60\nrun 140 pre no post no",
      "run 200 every 30 NULL", "run 200 every 50 \"variable dummy equal 1\"", "run 200 upto"};
  const Outcome &whole = straight(200, true);    // with forces that depend on velocities
  for (const auto &way : ways) {
    Lammps lmp;
    make_beam(lmp, "several.txt", "", true);
    lmp.commands(way);
    expect_same(whole, outcome(lmp, "several.txt"), way);
  }
}

TEST(Commands, RunZeroChangesNothing)
{
  Lammps lmp;
  make_beam(lmp, "zero.txt", "", true);
  lmp.run(100);
  const Outcome before = outcome(lmp, "zero.txt");
  const double damping = lmp.fe(DAMPING), friction = lmp.fe(FRICTION), released = lmp.fe(RELEASE),
               joints = lmp.fe(CONNECTIVE), cohesive = lmp.fe(COHESIVE);
  EXPECT_GT(damping, 0.0) << "a poor example";
  EXPECT_GT(friction, 0.0) << "a poor example";
  for (int k = 0; k < 3; k++) lmp.run(0);
  const Outcome after = outcome(lmp, "zero.txt");
  EXPECT_EQ(before.events, after.events);
  EXPECT_EQ(difference(before.particles, after.particles, &Particle::x), 0.0);
  EXPECT_EQ(difference(before.particles, after.particles, &Particle::v), 0.0);
  EXPECT_NEAR(before.balance, after.balance, 1e-9 * std::abs(before.balance));
  EXPECT_EQ(before.fracture, after.fracture);
  EXPECT_EQ(lmp.fe(DAMPING), damping);
  EXPECT_EQ(lmp.fe(FRICTION), friction);
  EXPECT_EQ(lmp.fe(RELEASE), released);
  EXPECT_EQ(lmp.fe(CONNECTIVE), joints);
  EXPECT_EQ(lmp.fe(COHESIVE), cohesive);
}

// Clocks go back or jump, in the middle of a crack: shields keep their age, damping its forces.
TEST(Commands, ClocksGoBackOrJumpInTheMiddleOfACrack)
{
  const Outcome &whole = straight(200, true);
  for (const long start : {0L, 1000000L}) {
    Lammps lmp;
    make_beam(lmp, "reset.txt", "", true);
    lmp.run(100);
    lmp.command("reset_timestep " + std::to_string(start));
    EXPECT_EQ(lmp.step(), start);
    lmp.run(100);
    Outcome here = outcome(lmp, "reset.txt");
    ASSERT_EQ(here.events.size(), whole.events.size());
    for (size_t k = 0; k < here.events.size(); k++)
      if (std::get<0>(whole.events[k]) > 100) std::get<0>(here.events[k]) += 100 - start;
    expect_same(whole, here, "reset_timestep " + std::to_string(start));
  }
}

// Computes that take the mass of their group before fix defe gives nodes theirs; with a pair style of DEFE and without.
TEST(Commands, CentreOfMassInTheFirstRun)
{
  for (const std::string pair :
       {"pair_style zero 0.002\npair_coeff * *\n",
        "pair_style defe/joint\npair_coeff 2 2 connective 74e9 0.2 cohesive 6e7 10.0 0.1\n"}) {
    SCOPED_TRACE(pair);
    Lammps lmp;
    lmp.commands(script_head() +
                 "region box block -0.01 0.02 -0.01 0.01 -0.01 0.01\ncreate_box 2 box\n" + pair +
                 "group particles empty\nfix fe all defe material glass elastic 74e9 0.2 2500 "
                 "material lead elastic 16e9 0.44 11340\n"
                 "create_hexes fe glass 1 x 0 2 0.004 y 0 1 0.002 z 0 1 0.002\n"
                 "create_hexes fe lead 1 x 0.006 2 0.010 y 0 1 0.002 z 0 1 0.002\n"
                 "group nodes type 1\nfix move nodes nve\ntimestep 5e-8\nneighbor 5e-4 bin\n"
                 "compute centre nodes com\ncompute size nodes gyration\n");
    lmp.run(0);
    const double glass = 2500.0, lead = 11340.0, x = (2e-3 * glass + 8e-3 * lead) / (glass + lead);
    EXPECT_NEAR(lmp.value("c_centre[1]"), x, 1e-15);
    EXPECT_NEAR(lmp.value("c_centre[2]"), 1e-3, 1e-15);
    // across 1 mm; along the masses of two elements at their ends and in the middle
    double xx = 0.0;
    for (int k = 0; k < 3; k++) {
      const double share = k == 1 ? 0.5 : 0.25;
      xx += share * (glass * std::pow(2e-3 * k - x, 2) + lead * std::pow(6e-3 + 2e-3 * k - x, 2));
    }
    EXPECT_NEAR(lmp.value("c_size[1]"), xx / (glass + lead), 1e-12 * xx / (glass + lead));
    EXPECT_NEAR(lmp.value("c_size[2]"), 1e-6, 1e-15);
  }
}

TEST(Commands, Clear)
{
  const Outcome &whole = straight(100);
  Lammps lmp;
  make_beam(lmp, "clear.txt");
  lmp.run(70);
  lmp.command("clear");
  lmp.command("plugin load " DEFE_PLUGIN_PATH);
  make_beam(lmp, "clear.txt");
  lmp.run(100);
  expect_same(whole, outcome(lmp, "clear.txt"), "clear");
}

// Another fix for another mesh, after the first one broke its own to pieces.
TEST(Commands, UnfixAndANewFix)
{
  const Outcome &whole = straight(100, true);
  Lammps lmp;
  make_beam(lmp, "", "", true);
  lmp.run(70);
  lmp.command("unfix fe");
  EXPECT_THAT(failure(lmp, "run 0"), HasSubstr("fix defe"));
  lmp.commands("delete_atoms group all\nunfix move1\nunfix move2\nreset_timestep 0");
  Block block = cracking_beam();
  remove_file("second.txt");
  block.options = "events second.txt";
  lmp.commands(block.fix_only() + block.mesh() + block.motion());
  bend(lmp, block);
  lmp.run(100);
  expect_same(whole, outcome(lmp, "second.txt"), "second fix");
}

// Nodes and DEs of the first fix stay as atoms that nothing holds.
TEST(Commands, NewFixBesideTheAtomsOfTheOld)
{
  Lammps lmp;
  make_beam(lmp);
  lmp.run(70);
  const auto old = lmp.natoms();
  lmp.commands("unfix fe\ngroup old union all");
  Block block;
  block.lo[1] = 0.015;
  lmp.commands("unfix move1\n" + block.fix_only() + block.mesh());
  lmp.commands("group new subtract all old\nfix move1 new nve\nvelocity old set 0 0 0");
  lmp.command("velocity new set 1.0 2.0 3.0");
  lmp.run(10);
  EXPECT_EQ(lmp.natoms(), old + block.nodes());
  EXPECT_EQ(lmp.fe(ELEMENTS), block.elements());
  EXPECT_EQ(lmp.fe(DES), 0);
  EXPECT_NEAR(lmp.fe(E_KINETIC) / (0.5 * block.mass() * 14.0), 1.0, 1e-10);
  EXPECT_NEAR(lmp.fe(E_ELEMENTS), 0.0, 1e-15);
}

TEST(Commands, Replicate)
{
  Lammps lmp;
  make_beam(lmp);
  EXPECT_THAT(failure(lmp, "replicate 2 1 1"), HasSubstr("Cannot replicate"));
}

TEST(Commands, ResetAtomsId)
{
  Lammps lmp;
  make_beam(lmp);
  lmp.run(10);
  EXPECT_THAT(failure(lmp, "reset_atoms id"), HasSubstr("fix defe storing atom IDs"));
}

TEST(Commands, Respa)
{
  Lammps lmp;
  Block block;
  lmp.commands(block.script() + "run_style respa 2 2");
  EXPECT_THAT(failure(lmp, "run 0"), HasSubstr("run_style respa"));
}

TEST(Commands, WriteCoeff)
{
  Lammps lmp;
  make_beam(lmp);
  lmp.run(1);
  EXPECT_EQ(failure(lmp, "write_coeff beam.coeff"), "");
}

// ---- deleting ----

namespace {

/// Two bodies far from each other, the second one with elements that convert at the start.
void two_bodies(Lammps &lmp, bool both)
{
  Block block;
  block.regions = "region half block 0.003 INF INF INF INF INF";
  block.convert += " start half";
  block.options = "part other glass";
  lmp.commands(block.script());
  if (both) lmp.commands("create_hexes fe other 1 x 0.0 2 0.004 y 0.015 2 0.019 z 0 2 0.004");
  lmp.commands("group nodes type 1");
  lmp.change([](Particle &p) {
    p.v = random_of(p.tag, 4);
  });
}

constexpr double upper = 0.012;    // between the two

}    // namespace

// The body that stays moves as if the other one had never been.
TEST(DeleteAtoms, AWholeBody)
{
  Particles alone;
  double elements, kinetic;
  {
    Lammps lmp;
    two_bodies(lmp, false);
    lmp.run(60);
    alone = lmp.particles();
    elements = lmp.fe(ELEMENTS);
    kinetic = lmp.fe(E_KINETIC);
  }
  for (const bool finite : {true, false}) {    // which of the two goes
    Lammps lmp;
    two_bodies(lmp, true);
    lmp.run(30);
    const double all = lmp.fe(ELEMENTS);
    const double gone = finite ? 8 : elements;
    EXPECT_EQ(all, elements + 8);
    lmp.command(std::string("region gone block INF INF ") +
                (finite ? number(upper) + " INF" : "INF " + number(upper)) + " INF INF");
    lmp.commands("delete_atoms region gone compress no");
    EXPECT_EQ(failure(lmp, "run 30"), "");
    EXPECT_EQ(lmp.fe(ELEMENTS), all - gone);
    const Particles left = lmp.particles();
    if (finite) {
      // IDs of DEs depend on the number of nodes: compare sums
      EXPECT_EQ(left.size(), alone.size());
      EXPECT_NEAR(lmp.fe(E_KINETIC) / kinetic, 1.0, 1e-2);
      EXPECT_LT((centre_of_mass(left) - centre_of_mass(alone)).norm(), 1e-6);
    } else {
      EXPECT_EQ(left.size(), 27u);
      EXPECT_EQ(lmp.fe(TIES), 0);
      EXPECT_EQ(lmp.fe(CONNECTIVE), 0);
    }
  }
}

TEST(DeleteAtoms, NodesOfAnElement)
{
  if (rank_of(MPI_COMM_WORLD) == 0) {    // found by one rank
    Block block;                         // 5 x 4 x 3 nodes, 24 elements
    for (const tagint node : {1, 2, 33, 60}) {
      Lammps lmp(MPI_COMM_SELF);
      lmp.commands(block.script());
      lmp.run(5);
      const std::string tag = std::to_string(node);
      lmp.command("group gone id " + tag);
      // the first node of an element takes it along: its neighbours miss it
      EXPECT_THAT(failure(lmp, "delete_atoms group gone compress no\nrun 5"),
                  AllOf(HasSubstr(node < 60 ? "element " : "node 60 "), HasSubstr("deleted"),
                        HasSubstr("only whole bodies")))
          << "node " << node;
    }
  }
  MPI_Barrier(MPI_COMM_WORLD);
}

// `compress yes`, the default, gives all atoms new IDs.
TEST(DeleteAtoms, CompressedIds)
{
  if (rank_of(MPI_COMM_WORLD) == 0) {    // found by one rank
    Lammps lmp(MPI_COMM_SELF);
    two_bodies(lmp, true);
    lmp.run(5);
    lmp.command("region gone block INF INF INF " + number(upper) + " INF INF");
    EXPECT_THAT(failure(lmp, "delete_atoms region gone\nrun 5"), HasSubstr("compress no"));
  }
  MPI_Barrier(MPI_COMM_WORLD);
}

TEST(DeleteAtoms, JoinedDiscreteElements)
{
  if (rank_of(MPI_COMM_WORLD) == 0) {    // found by one rank
    // one DE of the inside, one that ties hold, and all of them
    for (const std::string which : {"one", "tied", "all"}) {
      Lammps lmp(MPI_COMM_SELF);
      two_bodies(lmp, false);
      lmp.run(5);
      const auto all = lmp.particles();
      tagint inside = 0, tied = 0;
      for (const auto &p : all) {
        if (p.second.type != 2) continue;
        if (p.second.x[0] < 0.0050) tied = p.first;
        if (p.second.x[0] > 0.0060) inside = p.first;
      }
      ASSERT_GT(inside, 0);
      ASSERT_GT(tied, 0);
      if (which == "all")
        lmp.command("group gone type 2");
      else
        lmp.command("group gone id " + std::to_string(which == "one" ? inside : tied));
      EXPECT_THAT(failure(lmp, "delete_atoms group gone compress no\nrun 5"),
                  AllOf(HasSubstr("DE "), HasSubstr("deleted"), HasSubstr("only whole")))
          << which;
    }
  }
  MPI_Barrier(MPI_COMM_WORLD);
}

// Before the first run nothing is known but the elements themselves: those that have gone with
// their first nodes are counted.
TEST(DeleteAtoms, BeforeTheFirstRun)
{
  Block block;
  Lammps lmp;
  lmp.commands(block.script() +
               "group gone id 1\ndelete_atoms group gone compress no\n"
               "log before.log\nrun 0\nlog none");
  EXPECT_EQ(lmp.fe(ELEMENTS), block.elements() - 1);
  EXPECT_NEAR(total_mass(lmp.particles()) / (block.mass() - block.element_mass()), 1.0, 1e-14);
  if (rank_of(MPI_COMM_WORLD) == 0) {
    std::ifstream in("before.log");
    std::stringstream text;
    text << in.rdbuf();
    EXPECT_THAT(text.str(), HasSubstr("WARNING: 1 of 24 elements have gone"));
  }
}

// What has come loose may go, as in a run that takes fragments out of the way.
TEST(DeleteAtoms, LooseDiscreteElements)
{
  Block block;
  block.pair = "defe/contact";    // DEs are born loose
  block.coeff = "contact 0.9 0.2";
  block.regions = "region half block 0.003 INF INF INF INF INF";
  block.convert += " start half";
  Lammps lmp;
  lmp.commands(block.script());
  lmp.change([](Particle &p) {
    p.v = random_of(p.tag, 4);
  });
  lmp.run(20);
  const double elements = lmp.fe(ELEMENTS);
  lmp.command("region far block 0.0065 INF INF INF INF INF");
  lmp.command("group far region far");
  EXPECT_EQ(failure(lmp, "delete_atoms group far compress no\nrun 20"), "");
  EXPECT_EQ(lmp.fe(ELEMENTS), elements);
  EXPECT_LT(lmp.natoms(), 200);
}

// ---- moving and straining ----

namespace {

/// Energy of the block under a uniaxial strain that is held in the other two directions.
double strained_energy(const Block &b, double strain)
{
  const double lambda_2mu = b.E * (1.0 - b.nu) / ((1.0 + b.nu) * (1.0 - 2.0 * b.nu));
  const double volume = b.elements() * b.h * b.h * b.h;
  return 0.5 * lambda_2mu * strain * strain * volume;
}

}    // namespace

// displace_atoms strains what it displaces: the stress-free state is that of the mesh.
TEST(Moving, DisplaceAtomsStrainsWhatItDisplaces)
{
  for (const bool discrete : {false, true}) {
    Block block;
    if (discrete) {
      block.convert += " start all";
      block.nu = 0.0;    // else the outer cells, which lack joints, have less than the full strain
    }
    Lammps lmp;
    lmp.commands(block.script());
    lmp.run(0);
    const std::string what = discrete ? "discrete" : "finite";
    const auto energy = [&] {
      lmp.run(0);
      return lmp.fe(E_ELEMENTS) + lmp.fe(E_JOINTS);
    };
    const double strain = 1e-4, expected = strained_energy(block, strain);
    lmp.command("displace_atoms all move 0.001 0.002 -0.003 units box");
    EXPECT_NEAR(energy() / expected, 0.0, 1e-9) << what;
    lmp.command("displace_atoms all rotate 0 0 0 1 2 3 40 units box");
    EXPECT_NEAR(energy() / expected, 0.0, 1e-9) << what;
    lmp.command("displace_atoms all rotate 0 0 0 1 2 3 -40 units box");
    lmp.command("displace_atoms all move -0.001 -0.002 0.003 units box");
    lmp.command("displace_atoms all ramp x 0.0 " + number(strain * 0.008) +
                " x 0.0 0.008 units box");
    // the corotational brick is linear in the strain, joints have Green's strain e + e^2/2; at each
    // end the outer halves of the DEs have no joint that the ramp could stretch
    const double green = discrete ? std::pow(1.0 + 0.5 * strain, 2) : 1.0;
    const double stretched = discrete ? 14.0 / 16.0 : 1.0;
    EXPECT_NEAR(energy() / (expected * green * stretched), 1.0, 1e-8) << what;
  }
}

// `remap` moves the atoms with the box: a strain, as it should be. Without it nothing is strained.
TEST(Moving, ChangeBoxScale)
{
  Block block;
  const double strain = 1e-4;
  for (const std::string boundary : {"f f f", "p p p"}) {
    block.boundary = boundary;
    for (const bool remap : {true, false}) {
      Lammps lmp;
      lmp.commands(block.script());
      lmp.run(0);
      lmp.command("change_box all x scale " + number(1.0 + strain) + (remap ? " remap" : "") +
                  " units box");
      lmp.run(0);
      EXPECT_NEAR(lmp.fe(E_ELEMENTS) / strained_energy(block, strain), remap ? 1.0 : 0.0, 1e-9)
          << boundary << (remap ? " remap" : "");
    }
  }
}

// A block across a periodic border, strained with the box.
TEST(Moving, ChangeBoxScaleAcrossTheBorder)
{
  Block block;
  block.boundary = "p p p";
  block.lo[0] = 0.027;    // the box ends at 0.03
  const double strain = 1e-4;
  Lammps lmp;
  lmp.commands(block.script());
  lmp.run(0);
  EXPECT_NEAR(lmp.fe(E_ELEMENTS), 0.0, 1e-15);
  lmp.command("change_box all x scale " + number(1.0 + strain) + " remap units box");
  lmp.run(0);
  EXPECT_NEAR(lmp.fe(E_ELEMENTS) / strained_energy(block, strain), 1.0, 1e-9);
}

TEST(Moving, ChangeBoxBoundary)
{
  const Outcome &whole = straight(120);
  Lammps lmp;
  make_beam(lmp, "boundary.txt");
  lmp.commands("run 40\nchange_box all boundary p p p\nrun 40\nchange_box all boundary s f s\n"
               "run 20\nchange_box all boundary f f f x final -0.02 0.05 z final -0.02 0.03 units "
               "box\nrun 20");
  expect_same(whole, outcome(lmp, "boundary.txt"), "boundaries");
}

TEST(Moving, ChangeBoxTriclinic)
{
  Lammps lmp;
  make_beam(lmp);
  EXPECT_THAT(failure(lmp, "change_box all triclinic\nrun 0"),
              AllOf(HasSubstr("triclinic"), HasSubstr("ix")));
}

TEST(Moving, Velocity)
{
  Block block;
  block.convert += " start half";
  block.regions = "region half block 0.003 INF INF INF INF INF";
  Lammps lmp;
  lmp.commands(block.script());
  lmp.run(0);
  lmp.command("velocity all set 1 2 3");
  lmp.run(0);
  EXPECT_NEAR(lmp.fe(E_KINETIC) / (0.5 * block.mass() * 14.0), 1.0, 1e-12);
  lmp.command("velocity all ramp vx 0 5 x 0 0.008 units box");
  lmp.command("velocity all zero linear");
  EXPECT_LT(momentum(lmp.particles()).norm(), 1e-12 * block.mass());
  lmp.run(20);
  EXPECT_LT(momentum(lmp.particles()).norm(), 1e-10 * block.mass());
  EXPECT_LT((centre_of_mass(lmp.particles()) - block.centre()).norm(), 1e-12);
}

// A body strained by displace_atoms relaxes to nothing; with DEs minimisation is refused.
TEST(Moving, MinimizeRelaxesElementsAndIsRefusedWithDEs)
{
  Block block;
  Lammps lmp;
  lmp.commands(block.script() + "min_modify dmax 1e-6");
  lmp.change([](Particle &p) {
    p.x += 1e-7 * random_of(p.tag, 2);
  });
  lmp.run(0);
  const double before = lmp.fe(E_ELEMENTS);
  EXPECT_GT(before, 1e-6);
  EXPECT_EQ(failure(lmp, "minimize 0 1e-9 5000 50000"), "");
  lmp.run(0);
  // the line search of LAMMPS ends at absolute changes of energy, which are large in si
  EXPECT_LT(lmp.fe(E_ELEMENTS), 1e-6 * before);
}

// The default is 0.1 in any units.
TEST(Moving, MinimizeInLongSteps)
{
  Block block;
  for (const std::string dmax : {"", "min_modify dmax 6e-4"}) {
    Lammps lmp;
    lmp.commands(block.script() + dmax);
    EXPECT_THAT(failure(lmp, "minimize 0 1e-6 10 100"),
                AllOf(HasSubstr("shortest edge (0.002)"), HasSubstr("min_modify dmax 2e-06")));
  }
}

TEST(Moving, MinimizeWithDiscreteElements)
{
  Block block;
  block.convert += " start all";
  Lammps lmp;
  lmp.commands(block.script() + "min_modify dmax 1e-6");
  lmp.run(0);
  EXPECT_THAT(failure(lmp, "minimize 0 1e-6 1000 10000"),
              AllOf(HasSubstr("minimize"), HasSubstr("DE")));
}

// ---- running over a dump ----

TEST(Rerun, FiniteElements)
{
  Block block;
  const auto shake = [](Particle &p) {
    p.v = 5.0 * random_of(p.tag, 2);
  };
  std::vector<double> elements, kinetic;
  remove_file("rerun.dump");
  {
    Lammps lmp;
    lmp.commands(block.script() +
                 "dump d all custom 20 rerun.dump id type x y z vx vy vz ix iy iz\n"
                 "dump_modify d format float %20.17g sort id");
    lmp.change(shake);
    lmp.record({"f_fe[9]", "f_fe[14]"}, 20);
    lmp.run(100);
    elements = lmp.recorded(0);
    kinetic = lmp.recorded(1);
    lmp.command("undump d");
  }
  ASSERT_EQ(elements.size(), 6u);
  Lammps lmp;
  lmp.commands(block.script());
  lmp.record({"f_fe[9]", "f_fe[14]"}, 20);
  EXPECT_EQ(failure(lmp, "rerun rerun.dump first 0 last 100 dump x y z vx vy vz ix iy iz box yes"),
            "");
  const auto again = lmp.recorded(0), moving = lmp.recorded(1);
  ASSERT_EQ(again.size(), elements.size());
  for (size_t k = 0; k < elements.size(); k++) {
    EXPECT_NEAR(again[k], elements[k], 1e-9 * elements.back()) << "snapshot " << k;
    EXPECT_NEAR(moving[k] / kinetic[k], 1.0, 1e-9) << "snapshot " << k;
  }
}

TEST(Rerun, WithDiscreteElements)
{
  remove_file("crack.dump");
  {
    Lammps lmp;
    make_beam(lmp, "", "");
    lmp.commands("dump d all custom 50 crack.dump id type x y z\n"
                 "dump_modify d format float %20.17g sort id\nrun 100\nundump d");
    EXPECT_GT(lmp.fe(DES), 0);
  }
  for (const bool before : {true, false}) {
    Lammps lmp;
    make_beam(lmp);
    if (!before) lmp.run(100);
    EXPECT_THAT(failure(lmp, "rerun crack.dump dump x y z"), HasSubstr("rerun")) << before;
  }
}

TEST(Rerun, MaterialsWithAMemory)
{
  const Block block;
  remove_file("memory.dump");
  const std::string made = block.header() + block.box() +
      "pair_style zero 0.001\npair_coeff * *\ngroup particles empty\n"
      "fix fe all defe material glass prony 2e9 1100 1e6 1 3e8 2e5\n" +
      block.mesh() + block.motion();
  {
    Lammps lmp;
    lmp.commands(made + "dump d all custom 10 memory.dump id x y z\nrun 10\nundump d");
  }
  Lammps lmp;
  lmp.commands(made);
  EXPECT_THAT(failure(lmp, "rerun memory.dump dump x y z"),
              AllOf(HasSubstr("rerun"), HasSubstr("memory")));
}

// ---- changing atoms ----

// Mass that is added to nodes takes part in the motion, but no DE could take it over.
TEST(Changing, MassOfNodes)
{
  if (rank_of(MPI_COMM_WORLD) == 0) {    // found by one rank
    Block block;
    block.options = "check no";    // which a debug build has on, and which notices it before
    {
      Lammps lmp(MPI_COMM_SELF);
      lmp.commands(block.script() + "run 1\nset type 1 mass 1e-3\nvelocity all set 1 0 0\nrun 1");
      EXPECT_NEAR(lmp.fe(E_KINETIC) / (0.5 * block.nodes() * 1e-3), 1.0, 1e-12);
    }
    for (const std::string mass : {"1e-3", "1e-9"}) {
      block.convert = "1e6 type 2 group particles";
      Lammps lmp(MPI_COMM_SELF);
      lmp.commands(block.script() + "run 1\nset type 1 mass " + mass);
      lmp.change([&](Particle &p) {
        p.v[0] = 10.0 * (p.x[0] - block.centre()[0]) / h;
      });
      EXPECT_THAT(failure(lmp, "run 100"), AllOf(HasSubstr("Node "), HasSubstr("mass"))) << mass;
    }
  }
  MPI_Barrier(MPI_COMM_WORLD);
}

TEST(Changing, RadiusOfNodes)
{
  Block block;
  Lammps lmp;
  lmp.commands(block.script());
  lmp.run(1);
  EXPECT_THAT(failure(lmp, "set atom 7 diameter 0.001\nrun 1"),
              AllOf(HasSubstr("Node 7"), HasSubstr("radius")));
}

// Types are names: of nodes any will do, and DEs keep their part. Types of DEs choose pair_coeff.
TEST(Changing, TypeOfNodes)
{
  const Outcome &whole = straight(100);
  Lammps lmp;
  make_beam(lmp, "type.txt");
  lmp.commands("run 50\nset group nodes type 2\nrun 50");
  expect_same(whole, outcome(lmp, "type.txt"), "set type");
}

// ---- beside others ----

TEST(Beside, Balance)
{
  const Outcome &whole = straight(200);
  for (const std::string way : {"shift xyz 10 1.01", "rcb"}) {
    Lammps lmp;
    make_beam(lmp, "balance.txt", way == "rcb" ? "comm_style tiled\n" : "");
    lmp.commands("balance 1.0 " + way + "\nrun 110\nbalance 1.0 " + way + "\nrun 90");
    expect_same(whole, outcome(lmp, "balance.txt"), way);
  }
}

// Each collection of types with a ghost distance of its own; those by size, and LAMMPS' older way, are refused.
TEST(Beside, CommunicationModeMulti)
{
  const std::string multi = "neighbor 0.0005 multi\ncomm_modify mode multi vel yes\n";
  const Outcome &whole = straight(200);
  for (const std::string types : {"", "neigh_modify collection/type 1 *\n"}) {
    Lammps lmp;
    make_beam(lmp, "multi.txt");
    lmp.commands(multi + types + "run 100\ncomm_modify mode single\nrun 50\n" + multi + "run 50");
    expect_same(whole, outcome(lmp, "multi.txt"), "multi " + types);
  }
  {
    Lammps lmp;
    make_beam(lmp);
    lmp.commands(multi + "neigh_modify collection/interval 2 0.002 1.0");
    EXPECT_THAT(failure(lmp, "run 1"), HasSubstr("collection/type"));
  }
  Lammps lmp;
  make_beam(lmp);
  // LAMMPS 4Jul2026 refuses it itself
  EXPECT_THAT(failure(lmp, "comm_modify mode multi/old vel yes\nrun 1"),
              testing::AnyOf(HasSubstr("use mode single, or multi"),
                             HasSubstr("'multi/old' has been removed")));
}

TEST(Beside, AtomSort)
{
  const Outcome &whole = straight(200);
  Lammps lmp;
  make_beam(lmp, "sort.txt");
  lmp.commands("atom_modify sort 7 0.003\nrun 200");
  expect_same(whole, outcome(lmp, "sort.txt"), "sort");
}

// Other spheres: made before the first run they have IDs of their own.
TEST(Beside, OtherSpheres)
{
  const Outcome &whole = straight(100, true);
  Block block = cracking_beam();
  remove_file("others.txt");
  block.options = "events others.txt";
  block.coeff = "connective material cohesive 6e7 10.0 0.1 lattice contact 0.9 0.2";
  Lammps lmp;
  lmp.commands(block.header() + block.box() + block.fix() + block.mesh() +
               "create_atoms 2 single 0.0 0.027 0.0\nset group all mass 1e-6\n"
               "group other type 2\nset group other diameter 0.001 density 2500\n" +
               block.motion() + "fix move3 other nve/sphere");
  bend(lmp, block);
  lmp.command("velocity other set 0 0 -1");
  lmp.run(100);
  EXPECT_GT(lmp.fe(DES), 0);
  EXPECT_EQ(outcome(lmp, "others.txt").events.size(), whole.events.size());
  const Particles all = lmp.particles();
  const tagint sphere = block.nodes() + 1;
  ASSERT_TRUE(all.count(sphere));
  EXPECT_NEAR(all.at(sphere).x[2], -100 * block.dt, 1e-15);
  EXPECT_NEAR(all.at(sphere).v[2], -1.0, 1e-12);
}

// Spheres that fix deposit inserts; more of them in test_newcomers.cpp.
TEST(Beside, FixDeposit)
{
  const std::string rain =
      "region top block -0.015 0.025 0.02 0.025 -0.01 0.01 units box\n"
      "fix rain particles deposit 3 2 5 12345 region top near 0.002 units box\n";
  Lammps lmp;
  Block block;
  block.pair = "zero 0.001";
  block.coeff = "";
  std::string script = block.script();
  const std::string convert = " convert glass " + block.convert;
  script.erase(script.find(convert), convert.size());
  lmp.commands(script + "pair_coeff * *\n" + rain);
  lmp.command("velocity nodes set 1 0 0");
  lmp.run(100);
  EXPECT_EQ(lmp.natoms(), block.nodes() + 3);
  EXPECT_EQ(lmp.fe(ELEMENTS), block.elements());
  EXPECT_NEAR(lmp.fe(E_KINETIC) / (0.5 * block.mass()), 1.0, 1e-10);
}
