// Runs that are killed while they write restart files, and disks that are full: there is always a
// file that goes on, and a truncated one is never taken for good.
//
// ranks: 1
// timeout: 240

#include "cracking_beam.h"
#include "failure.h"
#include "programs.h"

#include <gmock/gmock.h>

#include <csignal>
#include <sys/resource.h>

using namespace defe::test;
using defe::Vec3;
using testing::AllOf;
using testing::AnyOf;
using testing::HasSubstr;

namespace {

/// No force depends on velocities, so that a run in pieces is the same as one.
Block undamped_beam()
{
  Block block = cracking_beam();
  block.coeff = "connective material cohesive 6e7 10.0 0.1 contact 1.0 0.0";
  return block;
}

/// How read_restart ends on this file; "" if it is good. `step` is that of the file, and the state
/// goes to `state`. The run goes on for a few steps.
std::string read_and_go_on(const std::string &file, long *step = nullptr,
                           Particles *state = nullptr)
{
  return failure([&] {
    const Block block = undamped_beam();
    Lammps lmp;
    lmp.commands(block.header() + "read_restart " + file + "\n" + block.fix_only() +
                 block.motion());
    if (step) *step = lmp.step();
    if (state) *state = lmp.particles();
    lmp.run(3);
  });
}

/// The whole beam as an input file of lmp; velocities come from a restart file of step 0.
void write_input(const std::string &file, const std::string &events, const std::string &more)
{
  Block block = undamped_beam();
  {
    Lammps lmp;
    lmp.commands(block.script());
    bend(lmp, block);
    lmp.command("write_restart start.restart");
  }
  block.options = "events " + events;
  write_file(file,
             "plugin load " DEFE_PLUGIN_PATH "\n" + block.header() +
                 "read_restart start.restart\n" + block.fix_only() + block.motion() + more);
}

}    // namespace

TEST(Interrupted, KilledWhileItWritesRestarts)
{
  write_input("in.killed", "killed.txt", "restart 2 killed.a killed.b\nrun 100000\n");
  std::mt19937 random(2026);
  std::uniform_real_distribution<double> delay(0.0, 0.3);
  std::map<long, Particles> states;    // by step, from the files
  std::map<long, History> happened;    // up to that step
  int truncated = 0;
  for (int k = 0; k < 15; k++) {
    std::remove("killed.a");
    std::remove("killed.b");
    std::remove("killed.txt");
    std::vector<std::string> command = {
        DEFE_LMP_EXECUTABLE, "-in", "in.killed", "-log", "none", "-nocite"};
    if (k % 5 == 4) command.insert(command.begin(), {DEFE_SOURCE_DIR "/tools/mpirun.sh", "2"});
    const pid_t pid = start(command, "killed.out");
    ASSERT_TRUE(wait_for("killed.b", pid, 60.0)) << contents("killed.out");
    std::this_thread::sleep_for(std::chrono::duration<double>(delay(random)));
    kill_all(pid);

    int good = 0;
    for (const std::string file : {"killed.a", "killed.b"}) {
      long step = -1;
      Particles state;
      const std::string message = read_and_go_on(file, &step, &state);
      if (message.empty()) {
        good++;
        states[step] = state;
        History list = history("killed.txt");
        list.erase(std::remove_if(list.begin(), list.end(),
                                  [&](const auto &e) {
                                    return std::get<0>(e) > step;
                                  }),
                   list.end());
        happened[step] = list;
      } else {
        truncated++;
        EXPECT_THAT(message,
                    AnyOf(HasSubstr("Incomplete or corrupted LAMMPS restart file"),
                          HasSubstr("Invalid LAMMPS restart file"),
                          HasSubstr(file + " is damaged or was not finished")))
            << file << " after kill " << k;
      }
    }
    EXPECT_GE(good, 1) << "kill " << k;
  }
  EXPECT_GE(states.size(), 10u) << "a poor example";
  std::printf("%d of 30 files were truncated; steps %ld to %ld\n", truncated, states.begin()->first,
              states.rbegin()->first);

  // what they hold, and the event file, is what an uninterrupted run gives
  Lammps lmp;
  Block block = undamped_beam();
  block.options = "events uninterrupted.txt";
  lmp.commands(block.script());
  bend(lmp, block);
  double converted = 0.0;
  for (const auto &s : states) {
    if (s.first > 400)
      break;    // later on, the order of sums matters: it is not the same on 2 ranks
    lmp.run(s.first - lmp.step());
    EXPECT_LT(difference(lmp.particles(), s.second, &Particle::x), 2e-12) << "step " << s.first;
    EXPECT_EQ(happened.at(s.first), history("uninterrupted.txt")) << "step " << s.first;
    converted = lmp.fe(CONVERTED);
  }
  EXPECT_GT(converted, 0.0) << "a poor example";
}

// Cut anywhere, it is refused.
TEST(Interrupted, TruncatedFiles)
{
  {
    const Block block = undamped_beam();
    Lammps lmp;
    lmp.commands(block.script());
    bend(lmp, block);
    lmp.run(100);
    EXPECT_GT(lmp.fe(DES), 0) << "a poor example";
    lmp.command("write_restart whole.restart");
  }
  ASSERT_EQ(read_and_go_on("whole.restart"), "");
  const std::string whole = contents("whole.restart");
  const long size = static_cast<long>(whole.size());
  std::mt19937 random(7);
  std::vector<long> sizes = {0, 1, 15, 16, 17, 100, size - 17, size - 16, size - 1};
  for (int k = 0; k < 30; k++) sizes.push_back(static_cast<long>(random() % size));
  for (const long n : sizes) {
    write_file("cut.restart", whole.substr(0, n));
    EXPECT_THAT(read_and_go_on("cut.restart"),
                AnyOf(HasSubstr("Incomplete or corrupted LAMMPS restart file"),
                      HasSubstr("Invalid LAMMPS restart file"),
                      HasSubstr("Restart file byte ordering is not recognized")))
        << n << " of " << size << " bytes";
  }
}

// One file of a set is cut, or missing, or from another step.
TEST(Interrupted, SetsOfFiles)
{
  {
    const Block block = undamped_beam();
    Lammps lmp;
    lmp.commands(block.script());
    bend(lmp, block);
    lmp.run(90);
    lmp.command("write_restart set.% ");
    write_file("old.0", contents("set.0"));
    lmp.run(10);
    lmp.command("write_restart set.%");
  }
  EXPECT_EQ(read_and_go_on("set.%"), "");
  const std::string first = contents("set.0");
  ASSERT_GT(first.size(), 1000u);
  write_file("set.0", first.substr(0, first.size() / 2));
  EXPECT_THAT(read_and_go_on("set.%"), HasSubstr("set.0 is damaged or does not belong"));
  std::remove("set.0");
  EXPECT_THAT(read_and_go_on("set.%"), HasSubstr("Cannot open restart file"));
  write_file("set.0", contents("old.0"));
  EXPECT_THAT(read_and_go_on("set.%"), HasSubstr("set.0 is damaged or does not belong"));
}

TEST(Interrupted, FullDisk)
{
  const Block block = undamped_beam();
  Block small = block;
  small.n[0] = small.n[1] = small.n[2] = 1;
  for (const Block &b : {block, small}) {
    Lammps lmp;
    lmp.commands(b.script());
    lmp.run(2);
    EXPECT_THAT(failure([&] {
                  lmp.command("write_restart /dev/full");
                }),
                HasSubstr("estart"))
        << b.n[0];
  }

  // the limit of the process for files: all but the last bytes have room
  std::string full;
  {
    Lammps lmp;
    lmp.commands(block.script());
    lmp.run(2);
    lmp.command("write_restart full.restart");
    full = contents("full.restart");
  }
  struct rlimit old;
  getrlimit(RLIMIT_FSIZE, &old);
  std::signal(SIGXFSZ, SIG_IGN);
  for (const long missing : {1L, 100L, 5000L, static_cast<long>(full.size()) - 1}) {
    std::remove("full.restart");
    Lammps lmp;
    lmp.commands(block.script());
    lmp.run(2);
    struct rlimit limit = old;
    limit.rlim_cur = full.size() - missing;
    setrlimit(RLIMIT_FSIZE, &limit);
    const std::string message = failure([&] {
      lmp.command("write_restart full.restart");
    });
    setrlimit(RLIMIT_FSIZE, &old);
    EXPECT_THAT(message, HasSubstr("estart")) << missing << " bytes too few";
    EXPECT_NE(read_and_go_on("full.restart"), "") << missing << " bytes too few";
  }
  std::signal(SIGXFSZ, SIG_DFL);
}

TEST(Interrupted, FoldersThatAreNotThere)
{
  Block block = undamped_beam();
  {
    Lammps lmp;
    lmp.commands(block.script() + "restart 2 nowhere/a nowhere/b");
    EXPECT_THAT(failure([&] {
                  lmp.run(5);
                }),
                AllOf(HasSubstr("Cannot open restart file"), HasSubstr("nowhere")));
  }
  for (const std::string file : {"nowhere/events.txt", "/dev/full"}) {
    block.options = "events " + file;
    Lammps lmp;
    lmp.commands(block.script());
    bend(lmp, block);
    // not only after hours, when there is something to write
    EXPECT_THAT(failure([&] {
                  lmp.run(2000);
                }),
                AllOf(HasSubstr("cannot write its event file"), HasSubstr(file)));
    EXPECT_EQ(lmp.step(), 0);
  }
}
