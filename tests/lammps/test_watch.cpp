// What would make results wrong without a word is refused, named, or right: fixes that move nodes and DEs in a
// way they cannot be moved, work that is not in the account, energy from nowhere, time steps that change.
//
// timeout: 240

#include "contact_scene.h"
#include "failure.h"
#include "joints.h"

#include <gmock/gmock.h>

#include <cmath>

using namespace defe::test;
using defe::Vec3;
using testing::AllOf;
using testing::HasSubstr;

namespace {

/// A box and fix defe for the meshes below.
std::string body(const std::string &convert, const std::string &options = "")
{
  Block block;
  block.box_hi[0] = 0.04;
  std::string box = block.box();
  box.replace(box.find("create_box 2"), 12, "create_box 4");
  return block.header() + box + "pair_style defe/joint\npair_coeff 2 2 " + block.coeff +
      "\ngroup particles empty\nregion rr block 0.002 0.004 INF INF INF INF\n"
      "fix fe all defe material glass elastic 74.09e9 0.2 2500 material ram rigid 7800 part foot "
      "glass "
      "convert glass " +
      convert + " type 2 group particles " + options + "\n";
}

const std::string GLASS = "create_hexes fe glass 1 x 0 4 0.008 y 0 3 0.006 z 0 2 0.004\n";
const std::string RAM = "create_hexes fe ram 3 x 0 2 0.004 y 0.0061 2 0.0101 z 0 2 0.004\n";
const std::string SETTINGS =
    "neighbor 5e-4 bin\nneigh_modify every 1 delay 0 check yes\ntimestep 5e-8\n";
const std::string SPHERES = "fix move2 particles nve/sphere\n";

}    // namespace

// ---- who moves what ----

// The nodes of a rigid body lose mass when their elements convert, and fix rigid does not know.
TEST(Movers, RigidBodyOfAConvertingPart)
{
  const std::string halves =
      "group nodes type 1\nregion l block INF 0.0041 INF INF INF INF\ngroup lefty region l\n"
      "group rest subtract nodes lefty\nfix move1 rest nve\n" +
      SPHERES + SETTINGS;
  for (const std::string rigid : {"rigid/nve single", "rigid single"})
    for (const std::string convert : {"1e15", "56e6"}) {
      const std::string start = convert == "1e15" ? " start rr" : "";
      EXPECT_THAT(
          failure(body(convert, start) + GLASS + halves + "fix rg lefty " + rigid + "\nrun 5"),
          AllOf(HasSubstr("Node 1 is moved by fix rg " + rigid.substr(0, rigid.find(' '))),
                HasSubstr("elements of part glass, which converts"),
                HasSubstr("a part of their own that does not convert")));
    }
  // nothing converts, or what is rigid has a part of its own and one more layer between
  EXPECT_EQ(failure(body("1e15") + GLASS + halves + "fix rg lefty rigid/nve single\nrun 5"), "");
  const std::string foot = "create_hexes fe foot 1 x -0.004 2 0 y 0 3 0.006 z 0 2 0.004\n";
  EXPECT_EQ(
      failure(
          body("56e6") + GLASS + foot +
          "group nodes type 1\nregion l block INF -0.001 INF INF INF INF\ngroup lefty region l\n"
          "group rest subtract nodes lefty\nfix move1 rest nve\n" +
          SPHERES + SETTINGS + "fix rg lefty rigid/nve single\nrun 5"),
      "");
}

// Nodes of rigid elements have no forces that hold them together.
TEST(Movers, RigidPartMovedNodeByNode)
{
  const std::string script = body("1e15", "contact 0.2") + GLASS + RAM +
      "group nodes type 1\ngroup ram type 3\n" + SPHERES + SETTINGS + "velocity ram set 0 -60 0\n";
  for (const std::string style : {"nve", "nve/limit 0.1"})
    EXPECT_THAT(failure(script + "fix move1 nodes nve\nfix move3 ram " + style + "\nrun 10"),
                AllOf(HasSubstr("Node 61 of the rigid part ram is moved by fix move3 nve"),
                      HasSubstr("move its nodes by fix rigid or fix move, or hold them")));
  for (const std::string good :
       {"fix move3 ram rigid/nve single", "fix move3 ram move linear 0 -60 0",
        "fix move3 ram nve\nfix hold ram setforce 0 0 0", "velocity ram set 0 0 0"}) {
    Lammps lmp;
    EXPECT_EQ(failure(lmp, script + "fix move1 nodes nve\n" + good + "\nrun 100"), "") << good;
    // hit beside its middle it turns a little
    EXPECT_NEAR(lmp.value("bound(ram,ymax)-bound(ram,ymin)") / 4e-3, 1.0, 2e-3) << good;
  }
}

// Held in one direction only, it is crushed in the others: the shape of its elements tells. Found by one rank.
TEST(Movers, RigidElementsKeepTheirShape)
{
  if (size_of(MPI_COMM_WORLD) > 1) return;
  const std::string message =
      failure(body("1e15", "contact 0.2") + GLASS + RAM + "group nodes type 1\ngroup ram type 3\n" +
              SPHERES + SETTINGS +
              "fix move1 nodes nve\nfix move3 ram nve\nfix hold ram setforce 0 NULL 0\n"
              "velocity ram set 0 -60 0\nrun 1000");
  EXPECT_THAT(message,
              AllOf(HasSubstr("of the rigid part ram has changed its shape by"),
                    HasSubstr("at step 1000"), HasSubstr("fix rigid or fix move")));
}

// Spins that stand still would lose what friction and moments do to them.
TEST(Movers, DiscreteElementsTurn)
{
  for (const std::string start : {"", " start all"})
    for (const std::string style : {"nve", "nve/limit 0.1"}) {
      const std::string script = body("56e6", start) + GLASS +
          "group nodes type 1\nfix move1 nodes nve\n" + SETTINGS + "fix move2 particles ";
      EXPECT_THAT(failure(script + style + "\nrun 1"),
                  AllOf(HasSubstr("DEs of part glass are moved by fix move2 nve"),
                        HasSubstr("does not turn them"),
                        HasSubstr("use 'fix move2 particles nve/sphere'")));
      EXPECT_EQ(failure(script + "nve/sphere\nrun 1"), "");
    }
  // nothing can become a DE
  EXPECT_EQ(failure(body("1e15") + GLASS + SETTINGS + "fix move1 all nve\nrun 1"), "");
}

// ---- the account ----

namespace {

/// A block falls on a soft wall that acts on the nodes which are near it.
struct Fall {
  double work, deepest, deviation;
};

Fall fall(bool dynamic)
{
  Lammps lmp;
  lmp.commands(
      body("1e15") + GLASS + "group nodes type 1\nfix move1 nodes nve\n" + SPHERES + SETTINGS +
      "region near block INF INF INF -0.0001 INF INF\n" +
      (dynamic ? "group low dynamic nodes region near every 1\n" : "group low union nodes\n") +
      // 1e6 N/m per node, from y = -1e-4 on
      "fix soft low wall/harmonic ylo -0.0021 1e6 0.0 0.002 units box\n"
      "velocity nodes set 0 -5 0\n");
  lmp.run(0);
  const double total = lmp.fe(TOTAL);
  lmp.record({"f_fe[21]", "f_fe[23]"}, 1);
  lmp.run(1000);
  const auto work = lmp.recorded(0);
  return {lmp.fe(EXTERNAL), *std::min_element(work.begin(), work.end()),
          largest_deviation(lmp.recorded(1)) / total};
}

}    // namespace

// The members of a dynamic group change between reneighbourings: the work of fixes on it is seen all the same.
TEST(Account, FixesOnDynamicGroups)
{
  const Fall all = fall(false), near = fall(true);
  EXPECT_LT(all.deepest, -1e-3);
  EXPECT_NEAR(near.deepest / all.deepest, 1.0, 1e-9);
  EXPECT_LT(std::abs(near.work), 1e-3 * std::abs(near.deepest));    // an elastic wall gives it back
  EXPECT_LT(all.deviation, 1e-3);
  EXPECT_LT(near.deviation, 1e-3);
}

// So are torques: a ball that spins in oil, and one that is turned by a motor.
TEST(Account, TorquesOfOtherFixes)
{
  Lammps lmp;
  lmp.commands(
      body("1e15", "contact 0.2") + GLASS +
      "create_atoms 4 single 0.004 0.003 0.02\nset type 4 diameter 0.008 density 7800\n"
      "group ball type 4\ngroup nodes type 1\nfix move1 nodes nve\nfix move3 ball nve/sphere\n" +
      SPHERES + SETTINGS + "set group ball omega 300 0 100\nfix oil ball viscous/sphere 1e-4\n");
  lmp.run(0);
  const double total = lmp.fe(TOTAL);
  lmp.record({"f_fe[22]", "f_fe[21]"}, 10);
  lmp.run(1000);
  EXPECT_LT(lmp.fe(EXTERNAL), -0.1 * total);
  EXPECT_LT(largest_deviation(lmp.recorded(0)), 1e-6 * total);
}

// What is not in the account does not bring the balance off: atoms that do not count in its kinetic energy.
TEST(Account, WorkOnSpheresThatDoNotCount)
{
  Lammps lmp;
  lmp.commands(
      body("1e15") + GLASS +
      "create_atoms 4 single 0.004 0.003 0.02\nset type 4 diameter 0.008 density 7800\n"
      "group ball type 4\ngroup nodes type 1\nfix move1 nodes nve\nfix move3 ball nve/sphere\n" +
      SPHERES + SETTINGS + "fix fall ball gravity 1e5 vector 0 0 -1\nrun 100\n");
  EXPECT_LT(lmp.value("vcm(ball,z)"), -0.4);
  EXPECT_EQ(lmp.fe(EXTERNAL), 0.0);
}

namespace {

/// Lines of a log file that begin with this.
std::vector<std::string> lines_of(const std::string &file, const std::string &start)
{
  MPI_Barrier(MPI_COMM_WORLD);
  std::vector<std::string> found;
  std::ifstream in(file);
  for (std::string line; std::getline(in, line);)
    if (line.compare(0, start.size(), start) == 0) found.push_back(line);
  MPI_Barrier(MPI_COMM_WORLD);
  return found;
}

/// Flat bricks (1 : 100) of DEs in random motion, but small.
Block flat_bricks(const std::string &check)
{
  Block block;
  block.n[0] = block.n[1] = block.n[2] = 2;
  block.h = 0.01;
  block.flat = 0.01;
  block.skin = 1e-4;
  block.convert = "1e15 type 2 group particles start all";
  block.options = check;
  block.dt = 1e-9;
  return block;
}

void start_flat_bricks(Lammps &lmp, const std::string &check)
{
  lmp.commands(flat_bricks(check).script() + "run 0\n");
  lmp.change([](Particle &p) {
    p.v = 0.01 * random_of(p.tag, 1);
  });
}

double safe_step(Lammps &lmp)
{
  int dim;
  return *static_cast<double *>(lmp->modify->get_fix_by_id("fe")->extract("dt_discrete", dim));
}

/// Short runs with a time step that grows until the motion becomes unstable, beginning with this one; how they
/// end. The balance is looked at at the end of each.
std::string too_fast(Lammps &lmp, double dt, int &rounds)
{
  std::string message;
  int k = 0;
  for (; k < rounds && message.empty(); k++)
    message = failure(lmp, "timestep " + number(dt * (1.0 + 0.01 * k)) + "\nrun 20");
  rounds = k;
  return message;
}

}    // namespace

// Energy from nowhere is named once with its step, or ends the run; at the safe step nothing is said.
TEST(Balance, EnergyFromNowhere)
{
  int rounds = 40;    // the first one says how many it takes
  for (const std::string check :
       {"check energy stop", "check energy warn", "check energy no", ""}) {
    Lammps lmp;
    remove_file("balance.txt");
    lmp.command("log balance.txt");
    start_flat_bricks(lmp, check);
    const double safe = safe_step(lmp);
    EXPECT_EQ(failure(lmp, "timestep " + number(0.9 * safe) + "\nrun 1000\nrun 500\n"), "");
    EXPECT_EQ(lines_of("balance.txt", "WARNING: Fix defe: the energy").size(), 0u);
    const auto message = too_fast(lmp, 1.3 * safe, rounds);
    lmp.command("log none");
    const auto warned = lines_of("balance.txt", "WARNING: Fix defe: the energy balance is off by");
    if (check == "check energy stop") {
      EXPECT_THAT(message,
                  AllOf(HasSubstr("the energy balance is off by"), HasSubstr("at step "),
                        HasSubstr("entry 23 of f_fe"), HasSubstr("smaller timestep")));
    } else {
      EXPECT_EQ(message, "");
      EXPECT_EQ(warned.size(), check == "check energy no" ? 0u : 1u) << check;
    }
  }
}

// After a restart the watch goes on.
TEST(Balance, IsWatchedAfterARestart)
{
  double safe;
  {
    Lammps lmp;
    start_flat_bricks(lmp, "");
    safe = safe_step(lmp);
    lmp.commands("timestep " + number(0.9 * safe) + "\nrun 300\nwrite_restart watch.restart");
  }
  const Block block = flat_bricks("check energy stop");
  Lammps lmp;
  lmp.commands(block.header() + "read_restart watch.restart\n" + block.fix_only() + block.motion() +
               "timestep " + number(0.9 * safe) + "\n");
  EXPECT_EQ(failure(lmp, "run 300"), "");
  int rounds = 40;
  EXPECT_THAT(too_fast(lmp, 1.3 * safe, rounds), HasSubstr("the energy balance is off by"));
}

// Where the account does not see all work, the balance is not watched, and that is said; it cannot stop a run.
TEST(Balance, IsNotWatchedWithWorkThatIsNotSeen)
{
  struct Case {
    std::string commands, named;
  };
  for (const Case &c : {Case{"fix pull right move linear 5 0 0\n", "the work of fix pull move"},
                        {"fix pull right nve\nfix strain all deform 1 x erate 10 remap x\n",
                         "the work of fix strain deform"},
                        {"fix pull right nve\nfix mirror right wall/reflect xhi 0.0081\n",
                         "the work of fix mirror wall/reflect"}})
    for (const std::string check : {"", "check energy stop", "check energy no"}) {
      Lammps lmp;
      remove_file("unseen.txt");
      lmp.command("log unseen.txt");
      const std::string script = body("1e15", check) + GLASS +
          "group nodes type 1\nregion r block 0.0079 INF INF INF INF INF\ngroup right region r\n"
          "group rest subtract nodes right\nfix move1 rest nve\n" +
          SPHERES + SETTINGS + c.commands;
      const auto message = failure(
          lmp,
          (c.commands.find("deform") == std::string::npos
               ? script
               : std::string(script).replace(script.find("boundary f f f"), 14, "boundary p f f")) +
              "run 200\nrun 200\n");
      lmp.command("log none");
      if (check == "check energy stop") {
        EXPECT_THAT(message,
                    AllOf(HasSubstr("check energy stop: " + c.named), HasSubstr("entry 21")));
        continue;
      }
      EXPECT_EQ(message, "");
      EXPECT_EQ(lines_of("unseen.txt", "WARNING: Fix defe: the energy").size(), 0u) << c.named;
      const auto notes = lines_of("unseen.txt", "Note: the energy balance");
      ASSERT_EQ(notes.size(), check.empty() ? 1u : 0u) << c.named;
      for (const auto &note : notes)
        EXPECT_THAT(note, HasSubstr("(entry 23 of f_fe) is not watched: " + c.named));
    }
}

// Energies that are not numbers end the run, on all ranks.
TEST(Balance, NumbersThatAreNone)
{
  Lammps lmp;
  lmp.commands(Block().script() + "velocity nodes set 1 0 0\nrun 10\n");
  if (rank_of(MPI_COMM_WORLD) == size_of(MPI_COMM_WORLD) - 1)
    defe_system(lmp).ledger.fracture = std::nan("");
  EXPECT_THAT(failure(lmp, "run 20"),
              AllOf(HasSubstr("Entry 15 of f_fe is not a number at step 30"),
                    HasSubstr("pair_coeff"), HasSubstr("unstable")));
}

// ---- time steps ----

TEST(TimeStep, ChangedByAFix)
{
  Block block;
  const std::string script = block.script() + "velocity nodes set 0.01 0 0\n";
  // at 0.01 m/s it may move by 1e-8 m per step, which allows 1 us
  EXPECT_THAT(failure(script + "fix grow nodes dt/reset 10 NULL 1e-6 1e-8 units box\nrun 40"),
              AllOf(HasSubstr("above the stable step of the finite elements"),
                    HasSubstr("at step 0 "), HasSubstr("fix dt/reset")));
  EXPECT_EQ(failure(script + "fix grow nodes dt/reset 10 NULL 1e-7 1e-8 units box\nrun 40"), "");
}

TEST(TimeStep, Negative)
{
  Block block;
  block.dt = -1e-8;
  EXPECT_THAT(failure(block.script() + "run 1"), HasSubstr("Time step -1e-08 is negative"));
}

// ---- what is read ----

TEST(Names, CannotBeHeldByDataFiles)
{
  const Block block;
  const std::string front = block.header() + block.box() + "fix fe all defe ";
  for (const std::string name : {"\"glass pane\"", "\"glass#1\"", "\"glass\tpane\""}) {
    EXPECT_THAT(failure(front + "material " + name + " elastic 74e9 0.2 2500"),
                AllOf(HasSubstr("Fix defe material '"), HasSubstr("must not be empty nor have")));
    EXPECT_THAT(failure(front + "material glass elastic 74e9 0.2 2500 part " + name + " glass"),
                AllOf(HasSubstr("Fix defe part '"), HasSubstr("must not be empty nor have")));
  }
  EXPECT_THAT(failure(front + "material 2 elastic 74e9 0.2 2500 part other 2"),
              AllOf(HasSubstr("part 1 has the name 2"), HasSubstr("number of part other")));
  EXPECT_EQ(failure(front + "material 1 elastic 74e9 0.2 2500 part other 1"), "");
}

TEST(Hexes, BlankLinesAndComments)
{
  for (const std::string extra : {"\n", "# in the middle\n", "   \t\n"}) {
    if (rank_of(MPI_COMM_WORLD) == 0) {
      MeshFile mesh;
      mesh.add_block("glass", 1, 2, 1, 1, 2e-3, [](const Vec3 &X) {
        return X;
      });
      mesh.write("blank.data", MPI_COMM_SELF);
      std::ifstream in("blank.data");
      std::ostringstream all;
      all << in.rdbuf();
      std::string text = all.str();
      const std::string second = "2 glass 2 3 6 5 8 9 12 11\n";
      text.replace(text.find(second), second.size(), extra + second);
      in.close();
      std::ofstream("blank.data") << text;
    }
    MPI_Barrier(MPI_COMM_WORLD);
    const Block block;
    EXPECT_THAT(failure(block.header() + block.box() + block.fix() + read_mesh("blank.data")),
                AllOf(HasSubstr("2 lines hold 1 elements, not 2"),
                      HasSubstr("blank lines and comments count"), HasSubstr("remove them")));
  }
}

// Elements of atoms that were deleted do not come back with atoms that take their places.
TEST(Hexes, OfDeletedAtomsAreGone)
{
  MeshFile mesh;
  mesh.add_block("glass", 1, 4, 2, 2, 2e-3, [](const Vec3 &X) {
    return X;
  });
  mesh.write("slots.data", MPI_COMM_WORLD);
  const Block block;
  for (const std::string doomed : {"all", "nodes"})
    for (const std::string next : {"create_hexes fe glass 1 x 0 3 0.006 y 0 2 0.004 z 0 2 0.004\n",
                                   "read_data slots.data add append fix fe hexes Hexes\n",
                                   "create_atoms 2 single 0.001 0.001 0.001\ncreate_hexes fe glass "
                                   "1 x 0 3 0.006 y 0 2 0.004 z 0 2 0.004\n"}) {
      Lammps lmp;
      const std::string script = block.header() + block.box() + block.fix() +
          read_mesh("slots.data") + "group nodes type 1\ndelete_atoms group " + doomed +
          " compress no\n" + next + block.motion();
      EXPECT_EQ(failure(lmp, script + "run 2"), "") << doomed << ", " << next;
      EXPECT_EQ(lmp.fe(ELEMENTS), next[0] == 'r' ? 16 : 12) << doomed << ", " << next;
    }
}

// ---- two LAMMPS in one process ----

TEST(Plugin, TwoInstances)
{
  const Block block;
  const auto run = [&](Lammps &lmp) {
    lmp.commands(block.script() + "velocity nodes ramp vx 0 1 x 0 0.008 units box\nrun 20");
    return lmp.particles();
  };
  const auto alone = [&] {
    Lammps lmp;
    return run(lmp);
  }();
  for (const bool first_ends_first : {true, false}) {
    auto a = std::make_unique<Lammps>(), b = std::make_unique<Lammps>();
    EXPECT_EQ(difference(alone, run(*a), &Particle::x), 0.0);
    EXPECT_EQ(difference(alone, run(*b), &Particle::x), 0.0);
    b->command("clear");
    b->command(std::string("plugin load ") + DEFE_PLUGIN_PATH);
    EXPECT_EQ(difference(alone, run(*b), &Particle::x), 0.0);
    (first_ends_first ? a : b).reset();
    auto &left = first_ends_first ? *b : *a;
    left.run(20);
    Lammps third;
    EXPECT_EQ(difference(alone, run(third), &Particle::x), 0.0);
    left.run(20);
    EXPECT_EQ(left.step(), 60);
  }
}

// ---- loads that come faster than steps ----

// A block that is drawn apart slowly reaches its conversion stress step by step; one that starts far above it, or whose
// strain grows by much of it in each step, is told of, once.
TEST(Jump, ElementsFarAboveTheirConversionStress)
{
  const auto warnings = [](const std::string &what) {
    Lammps lmp;
    lmp.commands(body("2e6") + GLASS + "group nodes type 1\nfix move1 nodes nve\n" + SPHERES +
                 SETTINGS);
    WarningLog log(lmp, "log.jump");
    lmp.commands(what);
    EXPECT_GT(lmp.fe(CONVERTED), 0.0);
    std::vector<std::string> found;
    for (const auto &w : log.warnings())
      if (w.find("times above its conversion stress") != std::string::npos) found.push_back(w);
    return found;
  };
  EXPECT_TRUE(warnings("velocity nodes ramp vx -0.5 0.5 x 0 0.008\nrun 40").empty());
  // 2 mm of glass at 50 m/s per edge: 74e9 Pa * 50/2e-3/s * 5e-8 s = 93 MPa in each step
  const auto fast = warnings("velocity nodes ramp vx -100 100 x 0 0.008\nrun 1\nrun 1");
  ASSERT_EQ(fast.size(), 1u);
  EXPECT_THAT(fast[0],
              AllOf(HasSubstr("Fix defe: element "), HasSubstr("(step 1)"),
                    HasSubstr("use a smaller timestep")));
  const auto strained = warnings("displace_atoms nodes ramp x 0 8e-6 x 0 0.008\nrun 1\nrun 1");
  ASSERT_EQ(strained.size(),
            1u);    // 1e-3 * 74.09e9 (1 - nu)/(1 + nu)/(1 - 2 nu) = 82.3 MPa, 41 times 2
  EXPECT_THAT(strained[0], AllOf(HasSubstr(" was 41.2 times above"), HasSubstr("(step 0)")));
}
