// DEs know their part by themselves, not by their atom type; and a type is not changed unnoticed.
//
// timeout: 120

#include "events.h"
#include "failure.h"
#include "glass_block.h"

#include <gmock/gmock.h>

using namespace defe::test;
using defe::Vec3;
using testing::AllOf;
using testing::HasSubstr;

namespace {

/// Two blocks of DEs of one type (or of two) that hit each other, of a soft and of a stiff material.
std::string two_materials(bool one_type)
{
  const std::string law = " connective material cohesive 1e12 1e6 0.1 contact 0.9 0.2\n";
  return script_head() + R"(
    processors      * 1 1
    region          box block -0.02 0.03 -0.02 0.03 -0.02 0.03
    create_box      3 box
    pair_style      defe/joint
  )" + "pair_coeff 2 2" +
      law + "pair_coeff 3 3" + law + "pair_coeff 2 3" + law + R"(
    group           particles empty
    fix             fe all defe material soft elastic 3e9 0.3 1200 &
                                material glass elastic 74.09e9 0.2 2500 &
                                convert soft 1e15 type 2 group particles start all &
                                convert glass 1e15 type )" +
      (one_type ? "2" : "3") + R"( group particles start all
    create_hexes    fe glass 1 x -0.0013 3 0.0047 y 0 2 0.004 z 0 2 0.004
    create_hexes    fe glass 1 x 0.0049 3 0.0109 y 0.0005 2 0.0045 z 0.0003 2 0.0043
    group           nodes type 1
    group           left id 1:36
    velocity        left set 30 0 0
    fix             move1 nodes nve
    fix             move2 particles nve/sphere
    neighbor        5e-4 bin
    timestep        5e-8
    neigh_modify    every 1 delay 0 check yes
  )";
}

struct Collision {
  Particles particles;
  double damping, friction;
};

Collision collide(bool one_type, MPI_Comm comm)
{
  Lammps lmp(comm);
  lmp.commands(two_materials(one_type));
  lmp.run(640);
  return {lmp.particles(), lmp.fe(DAMPING), lmp.fe(FRICTION)};
}

}    // namespace

// Contacts between DEs of two ranks have the stiffness of their material, whatever the type: the same
// collision on any number of ranks, and with a type for each part.
TEST(TypesOfDEs, GhostsKnowTheirPart)
{
  double own[2];
  const Particles reference = on_one_rank([&] {
    const Collision c = collide(true, MPI_COMM_SELF);
    own[0] = c.damping;
    own[1] = c.friction;
    return c.particles;
  });
  MPI_Bcast(own, 2, MPI_DOUBLE, 0, MPI_COMM_WORLD);
  EXPECT_GT(own[0], 1e-3);
  EXPECT_GT(own[1], 1e-3);
  for (bool one_type : {true, false}) {
    const Collision c = collide(one_type, MPI_COMM_WORLD);
    EXPECT_NEAR(c.damping / own[0], 1.0, 1e-9) << one_type;
    EXPECT_NEAR(c.friction / own[1], 1.0, 1e-9) << one_type;
    EXPECT_LT(difference(reference, c.particles, &Particle::x), 1e-14) << one_type;
    EXPECT_LT(difference(reference, c.particles, &Particle::v), 1e-9 * 30.0) << one_type;
  }
}

// set type on DEs: without coefficients of the new type, with itself and with the old one, the next run
// is refused; with them it goes on, with the coefficients of the new type.
TEST(TypesOfDEs, ChangedBySet)
{
  const std::string law = "connective material cohesive 60e6 10 0.1 contact 0.9 0.2";
  const std::string weak = "connective material cohesive 1e6 0.01 0.1 contact 0.9 0.2";
  const auto prepare = [&](Lammps &lmp) {
    Block block;
    block.coeff = law;
    block.options = "events types.events";
    block.convert = "1e12 type 2 group particles start all";
    std::string box = block.box();
    box.replace(box.find("create_box 2"), 12, "create_box 3");
    lmp.commands(block.header() + box + block.fix() + block.mesh() + block.motion() +
                 "run 0\nvelocity particles ramp vx -0.2 0.2 x 0 0.008 units box\n"
                 "region layer block 0.0033 0.0047 INF INF INF INF\ngroup layer region layer\n"
                 "set group layer type 3\n");
  };
  {
    Lammps lmp;
    prepare(lmp);
    EXPECT_THAT(failure(lmp, "run 10"),
                AllOf(HasSubstr("DEs of part glass were given type 3"),
                      HasSubstr("'pair_coeff 3 3'"), HasSubstr("connective cohesive contact")));
  }
  {
    Lammps lmp;
    prepare(lmp);
    EXPECT_THAT(failure(lmp, "pair_coeff 3 3 " + law + "\nrun 10"), HasSubstr("'pair_coeff 2 3'"));
  }
  for (const bool weaker : {false, true}) {
    Lammps lmp;
    prepare(lmp);
    lmp.commands("pair_coeff 3 3 " + (weaker ? weak : law) + "\npair_coeff 2 3 " + law);
    lmp.run(60);
    int across = 0;
    for (const auto &e : read_events("types.events", "cohesive")) {
      EXPECT_NEAR(e.x[0], 4e-3, 0.51e-3);    // only joints within the layer are weak
      if (std::abs(e.n[0]) > 0.9) across++;
    }
    EXPECT_EQ(across, weaker ? 6 * 4 : 0);
  }
}
