// Walls that hold finite elements and DEs: rebound against closed forms, energy, friction, regions; the
// same on any number of ranks and over a restart.
//
// ranks: 1 2 4
// timeout: 240

#include "failure.h"
#include "glass_block.h"

#include <gmock/gmock.h>

#include <cmath>

using namespace defe::test;
using defe::Mat3;
using defe::Vec3;
using testing::AllOf;
using testing::HasSubstr;

namespace {

constexpr double h = 2e-3;
const double K = 74.09e9 / (3.0 * (1.0 - 2.0 * 0.2));

/// A block of 4 x 3 x 2 cubes just above the plane z = 0.
struct Drop {
  Vec3 velocity = Vec3(0.0, 0.0, -4.0);
  Vec3 turned = Vec3::Zero();    // angles about x and y
  Vec3 spin = Vec3::Zero();
  std::string wall = "zplane 0 NULL";
  std::string start;    // what is discrete from the beginning
  std::string more;     // of fix defe
  std::string convert = "1e12 type 2 group particles";
  double dt = 5e-8;

  Block block() const
  {
    Block b;
    b.lo[2] = 1e-9;
    b.coeff = "connective material cohesive 1e12 1e6 0.1 contact 1.0 0.0";
    b.convert = convert + start;
    b.options = more;
    b.dt = dt;
    return b;
  }

  void begin(Lammps &lmp, const std::string &regions = "") const
  {
    Block b = block();
    b.regions = regions;
    lmp.commands(b.script() + "fix floor all defe/wall " + wall + "\nrun 0\n");
    const Vec3 c = b.centre();
    const Mat3 turn =
        (Eigen::AngleAxisd(turned[0], Vec3::UnitX()) * Eigen::AngleAxisd(turned[1], Vec3::UnitY()))
            .toRotationMatrix();
    double lowest = 1.0;
    for (int corner = 0; corner < 8; corner++) {
      Vec3 x;
      for (int k = 0; k < 3; k++) x[k] = b.lo[k] + (corner >> k & 1) * b.n[k] * h - c[k];
      lowest = std::min(lowest, (turn * x)[2]);
    }
    const Vec3 centre(c[0], c[1], 1e-9 - lowest);
    lmp.change([&](Particle &p) {
      const Vec3 arm = turn * (p.x - c);
      p.x = centre + arm;
      p.v = velocity + spin.cross(arm);
    });
  }
};

Particles dropped(MPI_Comm comm, const Drop &drop, int steps)
{
  Lammps lmp(comm);
  drop.begin(lmp);
  lmp.run(steps);
  return lmp.particles();
}

}    // namespace

// On a wall much softer than itself the block is a mass on a spring, of as many elements of stiffness
// f_s K h as it stands on; whether it consists of finite elements or of DEs, or of both.
TEST(Wall, RebounceOnASoftFloor)
{
  for (const std::string start : {"", " start all", " start half"}) {
    Drop drop;
    drop.wall = "zplane 0 NULL stiffness 0.001";
    drop.start = start;
    const Block block = drop.block();
    Lammps lmp;
    drop.begin(lmp, "region half block INF 0.0041 INF INF INF INF units box");
    lmp.record({"f_floor[3]", "f_floor", "f_fe[22]", "f_fe[13]"}, 1);
    const double k = block.n[0] * block.n[1] * 0.001 * K * h, mass = block.mass();
    const double omega = std::sqrt(k / mass), v = -drop.velocity[2];
    const double pi = std::acos(-1.0);
    const int contact = static_cast<int>(std::lround(pi / omega / block.dt));
    lmp.run(contact + 30);
    const Particles after = lmp.particles();
    EXPECT_NEAR(momentum(after)[2] / mass, v, 0.01 * v) << start;
    const auto force = lmp.recorded(0), energy = lmp.recorded(1), total = lmp.recorded(2),
               springs = lmp.recorded(3);
    double impulse = 0.0, strongest = 0.0, most = 0.0;
    int touched = 0;
    for (size_t s = 0; s < force.size(); s++) {
      impulse -= force[s] * block.dt;    // on the floor: downwards
      strongest = std::max(strongest, -force[s]);
      most = std::max(most, energy[s]);
      touched += force[s] != 0.0;
      EXPECT_NEAR(springs[s], energy[s], 1e-12 * mass * v * v) << start;
    }
    EXPECT_NEAR(impulse, momentum(after)[2] + mass * v, 1e-9 * mass * v) << start;
    EXPECT_NEAR(strongest, mass * v * omega, 0.03 * mass * v * omega) << start;
    EXPECT_NEAR(most, 0.5 * mass * v * v, 0.01 * mass * v * v) << start;
    EXPECT_NEAR(touched, contact, 0.02 * contact) << start;
    EXPECT_LT(largest_deviation(total), 1e-4 * 0.5 * mass * v * v) << start;
    EXPECT_EQ(energy.back(), 0.0) << start;
  }
}

// Total energy while it tumbles over the floor, in any attitude. What LAMMPS itself takes for potential
// and kinetic energy agrees.
TEST(Wall, TumblingKeepsItsEnergy)
{
  for (const std::string start : {"", " start half"})
    for (const Vec3 &turned : {Vec3(0.3, 0.0, 0.0), Vec3(0.7, -0.4, 0.0), Vec3(-1.2, 0.9, 0.0)}) {
      Drop drop;
      drop.start = start;
      drop.turned = turned;
      drop.spin = Vec3(300.0, -200.0, 500.0);
      Lammps lmp;
      drop.begin(lmp, "region half block INF 0.0041 INF INF INF INF units box");
      lmp.command("thermo_modify norm no");
      lmp.record({"f_fe[22]", "pe+ke", "f_floor[3]", "f_fe[14]"}, 1);
      lmp.run(1500);
      const double brought = lmp.recorded(3).front();
      EXPECT_LT(largest_deviation(lmp.recorded(0)), 1e-4 * brought) << start << turned.transpose();
      if (start.empty()) { EXPECT_LT(largest_deviation(lmp.recorded(1)), 1e-4 * brought); }
      EXPECT_EQ(lmp.fe(EXTERNAL), 0.0);
      double impulse = 0.0;
      for (double f : lmp.recorded(2)) impulse -= f * drop.block().dt;
      EXPECT_GT(impulse, 0.05 * drop.block().mass() * 4.0) << "a poor example";
      for (const auto &p : lmp.particles()) EXPECT_GT(p.second.x[2], -0.02 * h);
    }
}

// Elements convert while they are pressed on the floor; entry 23 also knows what that does to the energy
// of the contact.
TEST(Wall, ConversionsOnTheFloor)
{
  Drop drop;
  drop.velocity = Vec3(0.0, 0.0, -10.0);
  drop.convert = "3e6 type 2 group particles";
  drop.dt = 2.5e-8;
  Lammps lmp;
  drop.begin(lmp);
  lmp.record({"f_fe[23]", "f_floor", "f_fe[2]", "f_fe[14]"}, 1);
  lmp.run(300);
  const auto balance = lmp.recorded(0), springs = lmp.recorded(1), converted = lmp.recorded(2);
  const double brought = lmp.recorded(3).front();
  EXPECT_LT(largest_deviation(balance), 1e-3 * brought);
  int pressed = 0;
  for (size_t s = 1; s < springs.size(); s++)
    pressed += converted[s] > converted[s - 1] && springs[s] > 1e-3 * brought;
  EXPECT_GT(pressed, 1) << "a poor example";
  EXPECT_GT(std::abs(lmp.fe(CONV_STRAIN)), 5e-3 * brought);
}

// Sliding: friction is mu times the push, its work is what the total loses of kinetic energy.
TEST(Wall, FrictionIsItsCoefficientTimesThePush)
{
  for (const std::string start : {"", " start all"}) {
    Drop drop;
    drop.start = start;
    drop.velocity = Vec3(6.0, 8.0, -4.0);
    drop.wall = "zplane 0 NULL stiffness 0.01 friction 0.15";
    Lammps lmp;
    drop.begin(lmp);
    const Particles before = lmp.particles();
    lmp.record({"f_fe[22]", "f_floor[1]", "f_floor[2]", "f_floor[3]"}, 1);
    lmp.run(800);
    const double kinetic = 0.5 * drop.block().mass() * drop.velocity.squaredNorm();
    EXPECT_LT(largest_deviation(lmp.recorded(0)), 1e-3 * kinetic) << start;
    EXPECT_GT(lmp.fe(FRICTION), 0.05 * kinetic) << start;
    const auto fx = lmp.recorded(1), fy = lmp.recorded(2), fz = lmp.recorded(3);
    Vec3 impulse = Vec3::Zero();
    for (size_t s = 0; s < fx.size(); s++) impulse += drop.block().dt * Vec3(fx[s], fy[s], fz[s]);
    EXPECT_LT((momentum(lmp.particles()) - momentum(before) + impulse).norm(),
              1e-9 * impulse.norm());
    EXPECT_NEAR(impulse[0], -0.15 * 0.6 * impulse[2], 0.002 * std::abs(impulse[2])) << start;
    EXPECT_NEAR(impulse[1], -0.15 * 0.8 * impulse[2], 0.002 * std::abs(impulse[2])) << start;
  }
}

// A plane that is a face of a region is the same plane; round walls keep the energy, too.
TEST(Wall, FaceOfARegionIsThePlane)
{
  Drop drop;
  drop.turned = Vec3(0.3, 0.2, 0.0);
  const Particles plane = dropped(MPI_COMM_WORLD, drop, 600);
  drop.wall = "region bin";
  for (const std::string region :
       {"block -0.1 0.1 -0.1 0.1 0.0 0.1 units box", "plane 0 0 0 0 0 1 units box",
        "block -0.1 0.1 -0.1 0.1 -0.1 0.0 units box side out"}) {
    Lammps lmp;
    drop.begin(lmp, "region bin " + region);
    lmp.run(600);
    EXPECT_LT(difference(plane, lmp.particles(), &Particle::x), 1e-12 * h) << region;
  }
  for (const std::string start : {"", " start half"})
    for (const std::string region : {"sphere 0.004 0.003 0.011 0.0121 units box",
                                     "cylinder y 0.004 0.0085 0.0094 -0.1 0.1 units box",
                                     "sphere 0.004 0.003 -0.02 0.02 units box side out"}) {
      drop.start = start;
      drop.turned = Vec3::Zero();
      Lammps lmp;
      drop.begin(lmp,
                 "region half block INF 0.0041 INF INF INF INF units box\nregion bin " + region);
      lmp.record({"f_fe[22]", "f_floor"}, 1);
      lmp.run(1000);
      const double brought = 0.5 * drop.block().mass() * 16.0;
      EXPECT_LT(largest_deviation(lmp.recorded(0)), 1e-3 * brought) << start << region;
      double most = 0.0;
      for (double e : lmp.recorded(1)) most = std::max(most, e);
      EXPECT_GT(most, 0.01 * brought) << "a poor example";
    }
}

// Bricks of a rigid material, moved by fix rigid: the stiffness is that of another part.
TEST(Wall, RigidPartBounces)
{
  Block block;
  block.lo[2] = 1e-9;
  block.options = "material ram rigid 7800";
  std::string mesh = block.mesh();
  mesh.replace(mesh.find("glass"), 5, "ram");
  Lammps lmp;
  lmp.commands(
      block.header() + block.box() + block.fix() + mesh +
      "group nodes type 1\nfix move1 nodes rigid/nve single\nfix move2 particles nve/sphere\n"
      "neighbor 0.0005 bin\ntimestep 2e-8\nvelocity nodes set 0 0 -4\n"
      "fix floor all defe/wall zplane 0 NULL stiffness 0.02\n");
  lmp.run(2000);
  const Particles after = lmp.particles();
  EXPECT_NEAR(momentum(after)[2] / total_mass(after), 4.0, 1e-3);
}

TEST(Wall, AnyNumberOfRanks)
{
  if (size_of(MPI_COMM_WORLD) == 1) return;
  Drop drop;
  drop.turned = Vec3(0.3, -0.2, 0.0);
  drop.velocity = Vec3(6.0, 0.0, -4.0);
  drop.wall = "zplane 0 NULL xplane NULL 0.009 friction 0.2";
  const Particles one = on_one_rank([&] {
    return dropped(MPI_COMM_SELF, drop, 500);
  });
  const Particles all = dropped(MPI_COMM_WORLD, drop, 500);
  EXPECT_LT(difference(one, all, &Particle::x), 1e-11 * h);
  EXPECT_LT(difference(one, all, &Particle::v), 1e-8);
}

// Friction depends on velocities half a step ago, which no restart file holds.
TEST(Wall, GoesOnAfterARestart)
{
  for (const bool rubs : {false, true}) {
    Drop drop;
    drop.turned = Vec3(0.3, -0.2, 0.0);
    drop.velocity = Vec3(6.0, 0.0, -4.0);
    if (rubs) drop.wall += " friction 0.2";
    Particles whole;
    double total;
    {
      Lammps lmp;
      drop.begin(lmp);
      lmp.run(100);
      EXPECT_GT(lmp.value("f_floor"), 0.0) << "a poor example";
      lmp.command("write_restart wall.restart");
      lmp.run(200);
      whole = lmp.particles();
      total = lmp.fe(TOTAL);
    }
    Lammps lmp;
    const Block block = drop.block();
    lmp.commands(block.header() + "read_restart wall.restart\n" + block.fix_only() +
                 block.motion() + "fix floor all defe/wall " + drop.wall);
    lmp.run(200);
    EXPECT_LT(difference(whole, lmp.particles(), &Particle::x), (rubs ? 1e-6 : 1e-12) * h);
    EXPECT_NEAR(lmp.fe(TOTAL) / total, 1.0, rubs ? 1e-6 : 1e-12);
  }
}

TEST(Wall, MistakesAreRefused)
{
  struct Mistake {
    std::string commands, cause, remedy;
  };
  const Block block;
  const std::string region = "region round sphere 0 0 0 0.1 units box move v_a NULL NULL\n";
  const std::vector<Mistake> mistakes = {
      {"fix w all wall/gran hooke 1e5 NULL 1 NULL 0.5 0 zplane 0 NULL\nrun 0", "no radius",
       "fix defe/wall"},
      {"fix w all defe/wall friction 0.1", "needs a wall", "zplane"},
      {"fix w all defe/wall zplane NULL NULL", "place", "lower or an upper"},
      {"fix w all defe/wall zplane 1 0", "lower wall", "below"},
      {"fix w all defe/wall zplane 0", "zplane", "missing argument"},
      {"fix w all defe/wall zplane 0 NULL stiffness 0", "stiffness", "> 0"},
      {"fix w all defe/wall zplane 0 NULL friction -1", "friction", ">= 0"},
      {"fix w all defe/wall floor 0", "Unknown", "zplane"},
      {"fix w all defe/wall region nowhere\nrun 0", "nowhere", "does not exist"},
      {"variable a equal 0\n" + region + "fix w all defe/wall region round\nrun 0", "moves",
       "rigid"},
      {"region a block 0 1 0 1 0 1 open 1 units box\nfix w all defe/wall region a\nrun 0", "open",
       "closed"},
      {"region a block 0 1 0 1 0 1 units box\nregion b sphere 0 0 0 1 units box\n"
       "region c union 2 a b\nfix w all defe/wall region c\nrun 0",
       "other regions", "several"},
  };
  for (const auto &m : mistakes) {
    Lammps lmp;
    lmp.commands(block.script());
    EXPECT_THAT(failure(lmp, m.commands), AllOf(HasSubstr(m.cause), HasSubstr(m.remedy)))
        << m.commands;
  }
  Lammps lmp;
  Block periodic = block;
  periodic.boundary = "f f p";
  lmp.commands(periodic.script());
  EXPECT_THAT(failure(lmp, "fix w all defe/wall zplane 0 NULL"), HasSubstr("periodic"));
}

TEST(Wall, AllIsRigid)
{
  Block block;
  std::string script = block.script();
  const std::string material = "material glass elastic 74090000000 0.20000000000000001 2500 "
                               "convert glass 1e12 type 2 group particles";
  ASSERT_NE(script.find(material), std::string::npos) << script;
  script.replace(script.find(material), material.size(), "material glass rigid 2500");
  script.replace(script.find("nodes nve"), 9, "nodes rigid/nve single");
  Lammps lmp;
  lmp.commands(script + "fix w all defe/wall zplane 0 NULL");
  EXPECT_THAT(failure(lmp, "run 0"),
              AllOf(HasSubstr("all parts are rigid"), HasSubstr("define one")));
}

TEST(Wall, BeforeFixDefe)
{
  const Block block;
  Lammps lmp;
  lmp.commands(block.header() + block.box() + "fix w all defe/wall zplane 0 NULL\n" + block.fix() +
               block.mesh() + block.motion());
  EXPECT_THAT(failure(lmp, "run 0"), HasSubstr("must be defined before"));
}
