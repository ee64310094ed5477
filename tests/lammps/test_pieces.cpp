// A run in pieces is the run as a whole, also where forces depend on velocities: restitution and friction
// of DEs, balls and nodes, and of walls. Pieces end as planned, by fix halt, by a time limit or by a
// signal, and go on in the same program or from a restart file, on other ranks, too.
//
// timeout: 240

#include "cracking_beam.h"
#include "failure.h"

#include "fix_external.h"
#include "timer.h"

#include <gmock/gmock.h>

#include <csignal>
#include <functional>

using namespace defe::test;
using defe::Vec3;
using testing::AllOf;
using testing::HasSubstr;

namespace {

constexpr double h = 2e-3;
constexpr bigint early = 60, last = 160;

/// A block of which half are DEs slides on a base that slides on a wall; two balls slide on the block, one on
/// its elements and one on its DEs. It cracks.
struct Slide {
  Block block;
  std::string events;

  Slide()
  {
    block.n[0] = 6;
    block.n[1] = 3;
    block.regions = "region half block 0.006 INF INF INF INF INF";
    block.convert = "2e7 type 2 group particles start half";
    block.coeff = "connective material cohesive 2e7 5.0 0.3 contact 0.7 0.3\n"
                  "pair_coeff 2 3 contact 0.6 0.3";
    block.options = "part base glass contact 0.5 friction 0.2";
  }
  std::string fix() const
  {
    Block b = block;
    if (!events.empty()) b.options += " events " + events;
    return b.fix_only();
  }
  std::string motion() const
  {
    return block.motion() +
        "group balls type 3\nfix move3 balls nve/sphere\nfix down all gravity 500 vector 0.1 -1 0\n"
        "fix table all defe/wall yplane -0.004 NULL friction 0.3\n";
  }
  void start(Lammps &lmp) const
  {
    std::string box = block.box();
    box.replace(box.find("create_box 2"), 12, "create_box 3");
    lmp.commands(block.header() + box + block.regions + "\npair_style defe/joint\npair_coeff 2 2 " +
                 block.coeff + "\ngroup particles empty\n" + fix() + block.mesh() +
                 "create_hexes fe base 1 x -0.0013 7 0.0137 y -0.004 2 -0.00001 z -0.001 3 0.005\n"
                 "create_atoms 3 single 0.003 0.009001 0.0021\n"
                 "create_atoms 3 single 0.0085 0.009001 0.0015\n"
                 "set type 3 diameter 0.006 density 7800\n" +
                 motion());
    lmp.change([](Particle &p) {
      p.v = p.x[1] > -5e-6 ? Vec3(3.0, -6.0, 1.0) : Vec3(1.0, -2.0, 0.0);
      p.v += 0.1 * random_of(p.tag, 12);
      if (p.type == 3) {
        p.v = Vec3(-2.0, -9.0, 2.0);
        p.omega = Vec3(100.0, 300.0, -500.0);
      }
    });
  }
  void read(Lammps &lmp, const std::string &file) const
  {
    lmp.commands(block.header() + "read_restart " + file + "\n" + block.regions + "\n" + fix() +
                 motion());
  }
};

struct State {
  bigint step = 0;
  Particles particles;
  std::map<int, double> entries;
};

State state_of(Lammps &lmp)
{
  State s;
  s.step = lmp.step();
  s.particles = lmp.particles();
  for (int k = ELEMENTS; k <= FIRST_DAMAGE; k++) s.entries[k] = lmp.fe(static_cast<Entry>(k));
  return s;
}

/// Of the run as a whole at this step.
const State &whole(bigint step)
{
  static std::map<bigint, State> states;
  State &state = states[step];
  if (!state.particles.empty()) return state;
  Lammps lmp;
  Slide().start(lmp);
  lmp.run(step);
  state = state_of(lmp);
  const double all = state.entries.at(E_KINETIC);
  EXPECT_GT(state.entries.at(FRICTION), 1e-4 * all) << "a poor example";
  EXPECT_GT(state.entries.at(DAMPING), 1e-6 * all) << "a poor example";
  if (step < last) return state;
  EXPECT_GT(state.entries.at(CONVERTED), 18) << "a poor example";    // those of the start, and more
  EXPECT_GT(state.entries.at(CONTACT), 0) << "a poor example";
  return state;
}

/// Two LAMMPS cannot be alive at the same time: these first.
void whole_runs()
{
  whole(early);
  whole(last);
}

/// Rounding: until it cracks (more if other ranks were there before), and after that, when it grows tenfold in some 30 steps.
void expect_same(Lammps &lmp, const std::string &what, bool other_ranks = false,
                 bool same_clock = true)
{
  const State b = state_of(lmp);
  const State &a = whole(b.step);
  const double rounding = b.step < last ? (other_ranks ? 1e-12 : 1e-14) : 1e-10;
  ASSERT_EQ(a.particles.size(), b.particles.size()) << what;
  EXPECT_LT(difference(a.particles, b.particles, &Particle::x), 1e-3 * rounding * h) << what;
  EXPECT_LT(difference(a.particles, b.particles, &Particle::v),
            rounding * largest(a.particles, &Particle::v))
      << what;
  EXPECT_LT(difference(a.particles, b.particles, &Particle::omega),
            10 * rounding * largest(a.particles, &Particle::omega))
      << what;
  const double total = std::abs(a.entries.at(E_KINETIC));
  for (const auto &e : a.entries) {
    double tolerance = 0.0;
    if (!same_clock && (e.first == FIRST_CONVERSION || e.first == FIRST_DAMAGE)) continue;
    if (e.first == S1_MAX)
      tolerance = 1e-7 * e.second;
    else if (e.first > BALANCE)
      tolerance = 1e-15 * std::abs(e.second);
    else if (e.first >= E_ELEMENTS)
      tolerance = 10 * rounding * total;
    EXPECT_NEAR(e.second, b.entries.at(e.first), tolerance) << what << ", f_fe[" << e.first << "]";
  }
}

/// To the next state that is looked at, and to the end.
void go_on(Lammps &lmp, const std::string &what, bool other_ranks = false)
{
  for (const bigint step : {early, last}) {
    if (lmp.step() >= step) continue;
    lmp.run(step - lmp.step());
    expect_same(lmp, what + ", step " + std::to_string(step), other_ranks);
  }
}

/// What ends a run at this step, on all ranks.
void at_step(Lammps &lmp, bigint step, const std::function<void(Lammps &)> &something)
{
  struct Task {
    Lammps *lmp;
    bigint step;
    std::function<void(Lammps &)> something;
  };
  static Task task;
  task = {&lmp, step, something};
  lmp.command("fix watch all external pf/callback 1 1");
  auto *fix = dynamic_cast<LAMMPS_NS::FixExternal *>(lmp->modify->get_fix_by_id("watch"));
  fix->set_callback(
      [](void *, bigint now, int n, tagint *, double **, double **f) {
        for (int i = 0; i < n; i++) f[i][0] = f[i][1] = f[i][2] = 0.0;
        if (now == task.step) task.something(*task.lmp);
      },
      nullptr);
}

}    // namespace

TEST(Pieces, ManyRuns)
{
  whole_runs();
  for (const std::string option : {"", " pre no", " pre no post no"}) {
    Lammps lmp;
    Slide().start(lmp);
    for (bigint step = 0; step < last;) {
      const bigint steps = std::min<bigint>(1 + step % 7, (step < early ? early : last) - step);
      lmp.command("run " + std::to_string(steps) + (step ? option : ""));
      step += steps;
      if (step == early) expect_same(lmp, "run ..." + option);
    }
    expect_same(lmp, "run ..." + option);
  }
  Lammps lmp;
  Slide().start(lmp);
  lmp.command("run " + std::to_string(last) + " every 20 \"write_restart every.restart\"");
  expect_same(lmp, "every 20");
}

// What is marked for conversion, and the age of shields, outlast a clock that is set between runs without setup.
TEST(Pieces, ClockSetWithoutSetup)
{
  whole_runs();
  for (const std::string clock : {"1000", "0"})
    for (const bool every : {false, true}) {
      Lammps lmp;
      Slide().start(lmp);
      lmp.command("thermo_style custom step");    // LAMMPS forgets the energy when its clock is set
      bigint done = 0;
      for (const bigint step : {early, last}) {
        if (every)
          lmp.command("run " + std::to_string(step - done) + (done ? " pre no" : "") +
                      " every 1 \"reset_timestep " + clock + "\"");
        else
          for (bigint k = done; k < step; k++)
            lmp.commands("run 1" + std::string(k ? " pre no\n" : "\n") + "reset_timestep " + clock);
        done = step;
        lmp.command("reset_timestep " + std::to_string(step));
        expect_same(lmp, clock + (every ? " every 1" : ""), false, false);
      }
    }
}

// Commands that send atoms to other ranks, make other ghosts or move atoms need a setup after them.
TEST(Pieces, CommandsThatNeedASetup)
{
  Block block;
  Lammps lmp;
  lmp.commands(block.script() + "min_modify dmax 1e-6");
  for (const std::string command : {"write_restart between.restart", "write_data between.data",
                                    "displace_atoms nodes move 1e-9 0 0"}) {
    for (const std::string &run :
         {command + "\nrun 3 pre no", "run 4 pre no every 2 \"" + command + "\""}) {
      EXPECT_EQ(failure(lmp, "run 1"), "");
      EXPECT_THAT(failure(lmp, run),
                  AllOf(HasSubstr("moved, made or deleted atoms, or sorted them anew"),
                        HasSubstr("leave out 'pre no'")))
          << run;
    }
    EXPECT_EQ(failure(lmp, command + "\nrun 3\nrun 4 every 2 \"" + command + "\""), "") << command;
  }
  EXPECT_THAT(failure(lmp, "minimize 0 0 1 1\nrun 1 pre no"), HasSubstr("leave out 'pre no'"));
}

// LAMMPS ends the run around it, and would go on without calling setup.
TEST(Pieces, RunInsideARun)
{
  const std::string end =
      "a run, rerun or minimize among the commands of 'run ... every' has ended";
  for (const std::string inner : {"run 1", "run 1 pre no post no", "minimize 0 0 1 1"}) {
    Lammps lmp;
    Block block;
    lmp.commands(block.script() + "min_modify dmax 1e-6");
    for (const std::string option : {"", " pre no"}) {
      EXPECT_THAT(failure(lmp, "run 1\nrun 10" + option + " every 5 \"" + inner + "\""),
                  AllOf(HasSubstr(end), HasSubstr("at step"), HasSubstr("in a loop")))
          << inner << option;
      EXPECT_EQ(failure(lmp, "run 1\nrun 5" + option + " every 5 \"" + inner + "\""), "")
          << inner << option;    // there is no second piece
    }
  }
}

// The step is looked at in runs without setup, too.
TEST(Pieces, TimeStepOfARunWithoutSetup)
{
  Lammps lmp;
  lmp.commands(Block().script() + "run 1\ntimestep 1e-6");
  EXPECT_THAT(failure(lmp, "run 1 pre no"), HasSubstr("Time step 1e-06 is above the stable step"));
  EXPECT_EQ(failure(lmp, "timestep 5e-8\nrun 1 pre no"), "");
}

TEST(Pieces, EndsThatNoStepKnowsOf)
{
  whole_runs();
  for (const int step : {37, 101}) {
    {
      Lammps lmp;
      Slide().start(lmp);
      lmp.commands("variable step equal step\nfix stop all halt 1 v_step >= " +
                   std::to_string(step) + " error continue message no\nrun 100000\nunfix stop");
      lmp.command("write_restart halted.restart");
      EXPECT_EQ(lmp.step(), step);
      go_on(lmp, "fix halt");
    }
    {
      Lammps lmp;
      Slide().read(lmp, "halted.restart");
      EXPECT_EQ(lmp.step(), step);
      go_on(lmp, "restart after fix halt");
    }
    {
      Lammps lmp;
      Slide().start(lmp);
      static LAMMPS_NS::Timer *timer;
      timer = lmp->timer;
      const auto old = std::signal(SIGUSR1, [](int) {
        timer->force_timeout();
      });
      at_step(lmp, step, [](Lammps &) {
        std::raise(SIGUSR1);
      });
      lmp.commands("run 100000\nunfix watch\ntimer timeout 0\nrun 1000\ntimer timeout off");
      std::signal(SIGUSR1, old);
      EXPECT_EQ(lmp.step(), step);
      go_on(lmp, "signal and time limit");
    }
  }
}

// Written in the middle of a run, by all ranks and by one, and read by all and by one.
TEST(Pieces, RestartFiles)
{
  whole_runs();
  const bool root = rank_of(MPI_COMM_WORLD) == 0;
  const auto write = [](MPI_Comm comm, const std::string &name) {
    Lammps lmp(comm);
    Slide().start(lmp);
    lmp.command("restart 33 " + name + ".*");
    lmp.run(105);
    lmp.command("write_restart " + name + ".105");
  };
  write(MPI_COMM_WORLD, "pieces");
  if (root) write(MPI_COMM_SELF, "alone");
  MPI_Barrier(MPI_COMM_WORLD);
  for (const std::string name : {"pieces", "alone"})
    for (const std::string step : {"33", "66", "99", "105"}) {
      Lammps lmp;
      Slide().read(lmp, name + "." + step);
      go_on(lmp, name + " " + step, name == "alone");
    }
  const Particles &all = whole(early).particles;
  if (root && size_of(MPI_COMM_WORLD) > 1) {
    Particles one;
    Lammps lmp(MPI_COMM_SELF);
    Slide().read(lmp, "pieces.33");
    lmp.run(early - lmp.step());
    one = lmp.particles();
    EXPECT_LT(difference(all, one, &Particle::v), 1e-12 * largest(all, &Particle::v));
  }
  MPI_Barrier(MPI_COMM_WORLD);
}

// Whoever changes something between two runs gets the forces of what there is then: those of a beginning.
TEST(Pieces, WhatWasChanged)
{
  for (const std::string change : {"velocity balls set 0 0 0", "displace_atoms nodes move 0 1e-7 0",
                                   "pair_coeff 2 3 contact 0.9 0.1", "unfix table"}) {
    Particles forces[2];
    for (const bool kept : {true, false}) {
      Lammps lmp;
      Slide().start(lmp);
      lmp.run(50);
      lmp.command(change);
      if (!kept)    // a run that begins here: nothing is kept of atoms that were touched
        lmp.change([](Particle &p) {
          p.omega[0] = std::nextafter(p.omega[0], 1.0);
        });
      lmp.run(0);
      forces[kept] = lmp.particles();
    }
    EXPECT_LT(difference(forces[0], forces[1], &Particle::f),
              1e-9 * largest(forces[0], &Particle::f))
        << change;
  }
}
