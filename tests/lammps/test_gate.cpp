// The gate for code that is moved: a beam and a pane that convert, break and touch, with and without two clocks,
// with and without exact sums, and each again from a restart file of the middle.
//
// Their events (step, kind, IDs) are those stored in gate/, on any number of ranks: unlike digits, they do not
// depend on the machine. All digits are compared by tests/gate.sh, which runs this program with the plugins of
// two builds (DEFE_GATE_PLUGIN; nothing is compared with gate/ then) and compares the files that it leaves:
// NAME.values (the fix's vector, energies, pressure), NAME.atoms, NAME.joints and NAME.events.
// (That exact sums give the same bits on any number of ranks is the claim of test_reproducible.)
//
// DEFE_GATE_STORE=FOLDER writes the lists of events there, for a change that is meant.

#include "events.h"
#include "layers.h"
#include "programs.h"

#include <fstream>

using namespace defe::test;

namespace {

struct Scene {
  std::string name, fix, mesh, ball, velocity;
  int middle, steps;    // a restart file is written in the middle of the crack
  double dt;
  std::string law = "lattice";    // what is added to the coefficients of cohesive
};

/// How it is run.
struct Way {
  int every;
  bool exact;
};

std::string plugin()
{
  const char *other = std::getenv("DEFE_GATE_PLUGIN");
  return other ? other : DEFE_PLUGIN_PATH;
}

const std::string header = script_head();

std::string fix_of(const Scene &s, const Way &w, const std::string &output)
{
  // checked are the exact ones, whose masses are rounded, see DefeModel::element_mass()
  return "fix fe all defe " + s.fix + " every " + std::to_string(w.every) + " reproducible " +
      (w.exact ? "yes check yes" : "no") + " events " + output + ".events\n";
}

/// Motion and output.
std::string run_of(const Scene &s, const std::string &output)
{
  const bool sphere = !s.ball.empty();    // of type 3; else these are nodes
  return std::string("group nodes type 1") + (sphere ? "" : " 3") +
      "\ngroup ball type 3\nfix move1 nodes nve\nfix move2 particles nve/sphere\n" +
      (sphere ? "fix move3 ball nve/sphere\n" : "") +
      "neighbor 2e-4 bin\n"
      "neigh_modify every 1 delay 0 check yes\ntimestep " +
      number(s.dt) +
      "\ncompute joints all defe/joint/local id1 id2 kind state damage opening slip tn ts length\n"
      "fix values all ave/time 10 1 10 f_fe[*] c_thermo_pe c_thermo_press[*] format \" %.17g\" "
      "file " +
      output + ".values\ndump atoms all custom 50 " + output +
      ".atoms id type x y z vx vy vz omegax omegay omegaz fx fy fz tqx tqy tqz radius mass\n"
      "dump_modify atoms sort id format float %.17g\n";
}

void write_joints(Lammps &lmp, const std::string &output)
{
  lmp.command("write_dump all local " + output +
              ".joints index c_joints[*] modify format float %.17g");
}

void from_the_start(const Scene &s, const Way &w, const std::string &output)
{
  Lammps lmp(MPI_COMM_WORLD, plugin());
  lmp.commands(header +
               "region box block -0.03 0.03 -0.012 0.028 -0.012 0.022\ncreate_box 3 box\n"
               "pair_style defe/joint\n"
               "pair_coeff 2 2 connective material cohesive 6e7 10.0 0.1 " +
               s.law + " contact 0.9 0.2\n" +
               "pair_coeff 2 3 contact 0.8 0.3\ngroup particles empty\n" + fix_of(s, w, output) +
               s.mesh + s.ball + run_of(s, output) + s.velocity);
  lmp.run(s.middle);
  lmp.command("write_restart " + output + ".restart");
  lmp.run(s.steps - s.middle);
  write_joints(lmp, output);
  EXPECT_GT(lmp.fe(CONVERTED), 8.0);
  EXPECT_GT(lmp.fe(CONTACT), 8.0);
  if (!s.law.empty()) {
    EXPECT_GT(lmp.fe(DAMPING), 0.0);
  }    // else planes are closed, and spheres need not touch
  EXPECT_GT(lmp.fe(FRICTION), 0.0);
}

void from_the_middle(const Scene &s, const Way &w, const std::string &from,
                     const std::string &output)
{
  Lammps lmp(MPI_COMM_WORLD, plugin());
  lmp.commands(header + "read_restart " + from + ".restart\n" + fix_of(s, w, output) +
               run_of(s, output));
  lmp.run(s.steps - s.middle);
  write_joints(lmp, output);
}

/// Step, kind and IDs of the events, a line each.
std::string list_of(const std::string &file)
{
  MPI_Barrier(MPI_COMM_WORLD);
  std::ostringstream list;
  for (const auto &e : read_events(file))
    list << e.step << ' ' << e.what << ' ' << e.a << ' ' << e.b << '\n';
  return list.str();
}

/// Where two lists begin to differ.
void expect_same_list(const std::string &found, const std::string &expected)
{
  if (found == expected) return;
  std::istringstream a(found), b(expected);
  for (int n = 1;; n++) {
    std::string one = "(end)", other = "(end)";
    std::getline(a, one);
    std::getline(b, other);
    if (one == other) continue;
    ADD_FAILURE() << "event " << n << " is " << one << ", expected " << other;
    return;
  }
}

void pass(const Scene &s)
{
  for (const Way &w : {Way{1, false}, Way{2, false}, Way{1, true}, Way{2, true}}) {
    const std::string title = s.name + (w.every > 1 ? ".every2" : "");
    const std::string output = title + (w.exact ? ".exact" : "");
    SCOPED_TRACE(output);
    for (const std::string &file : {output, output + ".again"}) remove_file(file + ".events");
    from_the_start(s, w, output);
    from_the_middle(s, w, output, output + ".again");
    if (std::getenv("DEFE_GATE_PLUGIN")) continue;
    const std::string events = list_of(output + ".events"),
                      again = list_of(output + ".again.events");
    const char *store = std::getenv("DEFE_GATE_STORE");
    if (store && rank_of(MPI_COMM_WORLD) == 0)
      write_file(std::string(store) + "/" + title + ".events", events);
    MPI_Barrier(MPI_COMM_WORLD);
    expect_same_list(events, contents(DEFE_SOURCE_DIR "/tests/lammps/gate/" + title + ".events"));
    ASSERT_LT(again.size(), events.size());
    EXPECT_GT(again.size(), 0u);
    expect_same_list(again, events.substr(events.size() - again.size()));
  }
}

// numbers that look random, of the ID alone
const std::string noise =
    "variable n1 atom (id*37%101)/101-0.5\nvariable n2 atom (id*53%103)/103-0.5\n"
    "variable n3 atom (id*71%107)/107-0.5\n";

}    // namespace

namespace {

Scene beam()
{
  Scene s;
  s.name = "beam";
  s.fix = "material glass elastic 74.09e9 0.2 2500 material support elastic 5e9 0.4 2400 "
          "material block elastic 2e11 0.3 8e5 convert glass 5.6e7 type 2 group particles "
          "contact 0.2 friction 0.3";
  s.mesh = "create_hexes fe glass 1 x -0.021 21 0.021 y 0 4 0.008 z 0 2 0.004\n"
           "create_hexes fe support 1 x -0.021 2 -0.017 y -0.004 2 0 z 0 2 0.004\n"
           "create_hexes fe support 1 x 0.017 2 0.021 y -0.004 2 0 z 0 2 0.004\n"
           "create_hexes fe block 3 x -0.002 2 0.002 y 0.008 1 0.010 z 0 2 0.004\n";
  s.velocity = noise +
      "variable vx atom 0.2*v_n1\nvariable vy atom \"0.2*v_n2-15*(type==3)\"\n"
      "variable vz atom 0.2*v_n3\nvelocity all set v_vx v_vy v_vz\n";
  s.middle = 250;
  s.steps = 500;
  s.dt = 6e-8;
  return s;
}

Scene pane()
{
  MeshFile mesh = layered({{"lower", 0.002, 2}, {"inter", 0.00076, 1}, {"upper", 0.002, 2}},
                          equidistant(-0.006, 0.006, 12), equidistant(0.0, 0.010, 10), 3);
  for (size_t n = 0; n < mesh.X.size(); n++)    // one half is of cubes
    if (mesh.X[n][0] > 1e-6) mesh.X[n][0] += 1e-4 * (static_cast<double>(n * 37 % 101) / 101 - 0.5);
  mesh.write("gate.data");
  Scene s;
  s.name = "pane";
  s.fix = "material glass elastic 74.09e9 0.2 2500 part lower glass part upper glass "
          "material inter prony 20e9 1100 0.69e6 1 0.32931e9 12.6 "
          "convert lower 5.6e7 type 2 group particles convert upper 5.6e7 type 2 group particles "
          "adhesive lower inter 10e6 100 1 adhesive upper inter 10e6 100 1 stress gauss "
          "contact 0.1 friction 0.3";
  s.mesh = read_mesh("gate.data");
  s.ball = "create_atoms 3 single 0.0003 0.00775 0.0048\nset type 3 diameter 0.006 density 7850\n";
  s.velocity = "velocity ball set 4 -42 2\n";
  s.middle = 140;
  s.steps = 200;
  s.dt = 3e-8;
  return s;
}

/// Cracks by planes of their own.
Scene with_planes(Scene s)
{
  s.name += ".planes";
  s.law.clear();
  return s;
}

}    // namespace

TEST(Gate, BeamOnTwoSupportsUnderABlock)
{
  pass(beam());
}

TEST(Gate, LaminatedPaneUnderABall)
{
  pass(pane());
}

TEST(Gate, BeamWithPlanes)
{
  pass(with_planes(beam()));
}

TEST(Gate, PaneWithPlanes)
{
  pass(with_planes(pane()));
}
