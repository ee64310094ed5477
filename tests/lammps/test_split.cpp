// One, eight or 27 discrete elements for a finite one (convert ... split): strength, work of cracks, ranks, restarts,
// bodies of DEs only, and inputs that cannot be. The patch test: test_patch.cpp.
//
// timeout: 300

#include "cracking_beam.h"
#include "failure.h"
#include "mesh_file.h"

#include <gmock/gmock.h>

using namespace defe::test;
using defe::Vec3;
using testing::HasSubstr;

namespace {

std::string split_of(int along)
{
  return "split " + std::to_string(along);
}

}    // namespace

// A block in homogeneous tension cracks at sigma_t, whether its elements convert on the way or are DEs from the start.
TEST(Split, Strength)
{
  constexpr double sigma_t = 60e6, rise = 0.0025, dt = 1e-8;
  for (int along : {1, 2, 3})
    for (const bool start : {false, true}) {
      SCOPED_TRACE(std::to_string(along) + (start ? " DEs" : " adaptive"));
      Block block;
      block.dt = dt;
      block.n[0] = block.n[1] = block.n[2] = 3;
      block.coeff = "connective material cohesive 6e7 10.0 0.1 contact 0.9 0.2";
      block.convert = "5.6e7 type 2 group particles " + split_of(along);
      if (start) block.convert += " start all";
      block.options = "shield no events block.txt";
      remove_file("block.txt");
      {
        Lammps lmp;
        lmp.commands(block.script() +
                     "fix drive1 nodes setforce 0 0 0\nfix drive2 particles setforce 0 0 0\n");
        lmp.change([&](Particle &p) {
          const Vec3 u = sigma_t / block.E * Vec3(p.x[0], -block.nu * p.x[1], -block.nu * p.x[2]);
          p.x += 0.9 * u;
          p.v = rise / dt * u;
        });
        lmp.run(60);
        EXPECT_EQ(lmp.fe(CONVERTED), block.elements());
        EXPECT_EQ(lmp.fe(DES), block.elements() * along * along * along);
      }
      MPI_Barrier(MPI_COMM_WORLD);
      const auto damage = read_events("block.txt", "cohesive");
      ASSERT_FALSE(damage.empty());
      // decided upon in the step before
      EXPECT_NEAR(0.9 + rise * static_cast<double>(damage.front().step - 1), 1.0, 0.01);
      EXPECT_GT(std::abs(damage.front().n[0]), 0.999);
      MPI_Barrier(MPI_COMM_WORLD);
    }
}

// Torn in two: what cracks take is G_f times the area of the joints that they have damaged, and the account is closed.
TEST(Split, WorkOfCracksThroughABar)
{
  for (int along : {1, 2, 3}) {
    SCOPED_TRACE(along);
    Block bar;
    bar.n[0] = 5;
    bar.n[1] = bar.n[2] = 2;
    const double G_f = 300.0, area = bar.h * bar.h / (along * along);    // of a joint
    bar.coeff = "connective material cohesive 6e7 300 0.1 contact 0.9 0.2";
    bar.convert = "5.4e7 type 2 group particles " + split_of(along);
    bar.dt = 4e-8;
    bar.options = "events bar.txt";
    remove_file("bar.txt");
    Lammps lmp;
    lmp.commands(bar.script() +
                 "region left block INF 0.0013 INF INF INF INF\nregion right block 0.0087 INF INF "
                 "INF INF INF\nregion ends union 2 left right\nfix pull all setforce 0 NULL NULL "
                 "region ends\ncompute joints all defe/joint/local id1 id2 damage\n");
    lmp.change([&](Particle &p) {
      const double s = p.x[0] - 0.005, bulge = 0.2 * 6.5e-4;
      p.v = Vec3(0.6 * s / 0.005, 0.0, 0.0);
      p.x = Vec3(p.x[0] + 6.5e-4 * s, (1.0 - bulge) * p.x[1], (1.0 - bulge) * p.x[2]);
    });
    lmp.run(0);
    const double before = lmp.fe(BALANCE);
    lmp.run(1000);
    MPI_Barrier(MPI_COMM_WORLD);
    double damaged = 0.0;
    for (const auto &e : read_events("bar.txt", "broken")) damaged += area * std::abs(e.n[0]);
    EXPECT_GE(damaged, 3.99 * bar.h * bar.h) << "it has not come apart";
    for (const auto &row : lmp.local("joints"))
      if (row[2] < 1.0) damaged += area * row[2];
    EXPECT_NEAR(lmp.fe(FRACTURE) / (G_f * damaged), 1.0, 0.05);
    EXPECT_NEAR(lmp.fe(BALANCE), before, 2e-3 * lmp.fe(FRACTURE));
  }
}

// A beam that bends until it cracks, fragments that touch: on any ranks, and over a restart in between. Adaptive, and of
// nothing but DEs.
TEST(Split, SameOnAnyRanksAndOverARestart)
{
  for (const auto &[name, start] : {std::pair("split", " "), {"all", " start all "}})
    for (int along : {1, 3}) {
      SCOPED_TRACE(name + std::to_string(along));
      Block beam = cracking_beam();
      beam.convert += start + split_of(along);
      beam.options = "check yes";
      beam.dt = along == 1 ? 5e-8 : 4e-8;
      same_on_any_ranks_and_over_a_restart(beam, name + std::to_string(along), 260);
    }
}

// Flat elements, whose DEs have selective shear: it asks which joints there were, besides those that are there.
TEST(Split, FlatElementsOnAnyRanksAndOverARestart)
{
  for (int along : {1, 2}) {
    SCOPED_TRACE(along);
    Block beam = cracking_beam();
    beam.flat = 0.6;
    beam.convert += " " + split_of(along);
    beam.options = "check yes";
    beam.dt = 4e-8;
    same_on_any_ranks_and_over_a_restart(beam, "flat" + std::to_string(along), 260);
  }
}

// With flaws, whose strengths travel with elements and DEs.
TEST(Split, WithFlawsOnAnyRanksAndOverARestart)
{
  Block beam = cracking_beam();
  beam.convert += " " + split_of(3);
  beam.dt = 4e-8;
  beam.options = "strength glass weibull 8 9e7 volume 1e-9 seed 3";
  same_on_any_ranks_and_over_a_restart(beam, "flaws", 260);
}

// Of 27 DEs those in the middle of an edge of their element are, from the start, as deep behind faces round the corner as
// contact reaches: nothing goes through these faces.
TEST(Split, NoneIsLetThroughFacesRoundTheCorner)
{
  Lammps lmp;
  lmp.commands(script_head() + R"(
    region          box block -0.04 0.04 -0.01 0.03 -0.01 0.02
    create_box      4 box
    pair_style      defe/joint
    pair_coeff      4 4 connective material cohesive 60e6 10.0 0.1 contact 0.9 0.2
    group           particles empty
    fix             fe all defe material glass elastic 74.09e9 0.2 2500 material block rigid 1.0e6 &
                            convert glass 56e6 type 4 group particles split 3 contact 0.2
    create_hexes    fe glass 1  x -0.031 31 0.031  y 0.000 5 0.010  z 0 3 0.006
    create_hexes    fe block 3  x -0.003  3 0.003  y 0.010 2 0.014  z 0 3 0.006
    group           nodes type 1
    group           block type 3
    velocity        block set 0 -2 0
    fix             move1 nodes nve
    fix             move2 particles nve/sphere
    fix             move3 block rigid/nve single
    timestep        4e-8
    neighbor        0.0002 bin
    neigh_modify    every 1 delay 0 check yes
)");
  lmp.run(800);
  EXPECT_GT(lmp.fe(CONTACT), 100) << "a poor example";
  EXPECT_EQ(lmp.fe(LET_THROUGH), 0);
}

TEST(Split, RefusedInputs)
{
  Block block;
  for (const char *wrong : {"0", "4"}) {
    block.convert = std::string("1e12 type 2 group particles split ") + wrong;
    EXPECT_THAT(failure(block.script()),
                HasSubstr(std::string("convert glass: split must be 1, 2 or 3 (an element becomes "
                                      "1, 8 or 27 DEs), not ") +
                          wrong));
  }
  block.convert = "1e12 type 2 group particles split";
  EXPECT_THAT(failure(block.script()), HasSubstr("convert ... split"));
}

// A corner that is pushed to the middle of its element: eight DEs have their volumes, one of 27 has none.
TEST(Split, ElementsThatAreTooDistorted)
{
  if (size_of(MPI_COMM_WORLD) > 1) GTEST_SKIP() << "the rank that has the element stops all others";
  MeshFile mesh;
  mesh.add_block("glass", 1, 1, 1, 1, 2e-3, [](const Vec3 &X) {
    return X.minCoeff() > 1e-3 ? Vec3(0.5 * X) : X;
  });
  mesh.write("pushed.data");
  const auto with = [](int along) {
    Block block;
    block.convert += " " + split_of(along);
    return failure(block.header() + block.box() + block.fix() + read_mesh("pushed.data") +
                   block.motion() + "run 0\n");
  };
  EXPECT_EQ(with(2), "");
  EXPECT_THAT(with(3), HasSubstr("at that corner a DE would have no volume: mend the mesh there"));
}

TEST(Split, PartsThatTouchNeedTheSame)
{
  MeshFile mesh;
  mesh.add_block("glass", 1, 2, 2, 2, 2e-3, [](const Vec3 &X) {
    return X;
  });
  for (size_t e = 0; e < mesh.part.size(); e++)
    if (e % 2) mesh.part[e] = "other";
  mesh.write("touch.data");
  const auto with = [](const std::string &second) {
    Block block;
    block.convert = "1e12 type 2 group particles split 3";
    block.options = "part other glass " + second;
    return failure(block.header() + block.box() + block.fix() + read_mesh("touch.data") +
                   block.motion() + "run 0\n");
  };
  EXPECT_EQ(with("convert other 1e12 type 2 group particles split 3"), "");
  EXPECT_EQ(with(""), "");
  EXPECT_THAT(with("convert other 1e12 type 2 group particles"),
              HasSubstr("parts glass (split 3) and other (split 2) have faces in common"));
}

TEST(Split, ARestartWithAnotherOne)
{
  Block block;
  block.convert += " split 3";
  {
    Lammps lmp;
    lmp.commands(block.script());
    lmp.run(0);
    lmp.command("write_restart split.restart");
  }
  const auto go_on = [&] {
    return failure(block.header() + "read_restart split.restart\n" + block.fix_only() +
                   block.motion() + "run 0\n");
  };
  EXPECT_EQ(go_on(), "");
  block.convert = "1e12 type 2 group particles";
  EXPECT_THAT(go_on(), HasSubstr("split 3"));
}
