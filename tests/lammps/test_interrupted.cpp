// Runs that are killed while they write restart files, and disks that are full: there is always a
// file that goes on, and a truncated one is never taken for good.
//
// ranks: 1
// timeout: 240

#include "cracking_beam.h"

#include <gmock/gmock.h>

#include <csignal>
#include <dirent.h>
#include <fcntl.h>
#include <sys/resource.h>
#include <sys/stat.h>
#include <sys/wait.h>
#include <unistd.h>

#include <chrono>
#include <thread>

using namespace defe::test;
using defe::Vec3;
using testing::AllOf;
using testing::AnyOf;
using testing::HasSubstr;

extern char **environ;

namespace {

/// No force depends on velocities, so that a run in pieces is the same as one.
Block undamped_beam()
{
  Block block = cracking_beam();
  block.coeff = "connective material cohesive 6e7 10.0 0.1 contact 1.0 0.0";
  return block;
}

long size_of_file(const std::string &file)
{
  struct stat info;
  return stat(file.c_str(), &info) == 0 ? static_cast<long>(info.st_size) : -1;
}

std::string contents(const std::string &file)
{
  std::ifstream in(file, std::ios::binary);
  std::ostringstream text;
  text << in.rdbuf();
  return text.str();
}

void write_file(const std::string &file, const std::string &text)
{
  std::ofstream(file, std::ios::binary) << text;
}

std::string failure(const std::function<void()> &something)
{
  try {
    something();
  } catch (LAMMPS_NS::LAMMPSException &e) {
    const std::string text = e.what();
    return text.substr(0, text.find('\n'));
  }
  return "";
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

// ---- programs ----

/// Starts a program with its output in `log`. It knows nothing of the MPI job that this test is.
pid_t start(const std::vector<std::string> &command, const std::string &log)
{
  std::vector<std::string> environment;
  for (char **e = environ; *e; e++) {
    const std::string entry = *e;
    bool of_mpi = false;
    for (const char *prefix : {"OMPI_", "PMIX_", "PRTE_", "ORTE_", "PMI_", "MPI_", "HYDRA_"})
      of_mpi = of_mpi || entry.compare(0, std::strlen(prefix), prefix) == 0;
    if (!of_mpi) environment.push_back(entry);
  }
  // a plain lmp does not bring what a plugin with sanitizers needs
  if (const char *runtime = std::getenv("DEFE_SANITIZER_RUNTIME"))
    environment.push_back(std::string("LD_PRELOAD=") + runtime);
  std::vector<char *> argv, envp;
  for (const auto &a : command) argv.push_back(const_cast<char *>(a.c_str()));
  for (auto &e : environment) envp.push_back(e.data());
  argv.push_back(nullptr);
  envp.push_back(nullptr);

  const pid_t pid = fork();
  if (pid) return pid;
  const int in = open("/dev/null", O_RDONLY);
  const int out = open(log.c_str(), O_WRONLY | O_CREAT | O_TRUNC, 0644);
  dup2(in, 0);
  dup2(out, 1);
  dup2(out, 2);
  execve(argv[0], argv.data(), envp.data());
  _exit(127);
}

/// The processes that this one started.
std::vector<pid_t> children(pid_t parent)
{
  std::vector<pid_t> list;
  DIR *proc = opendir("/proc");
  if (!proc) return list;
  while (const dirent *entry = readdir(proc)) {
    if (entry->d_name[0] < '0' || entry->d_name[0] > '9') continue;
    const std::string stat = contents(std::string("/proc/") + entry->d_name + "/stat");
    const auto end = stat.rfind(')');    // pid (name) state parent
    if (end == std::string::npos) continue;
    std::istringstream words(stat.substr(end + 1));
    char state;
    long ppid = 0;
    words >> state >> ppid;
    if (ppid == parent) list.push_back(static_cast<pid_t>(std::atol(entry->d_name)));
  }
  closedir(proc);
  return list;
}

/// Kills it and what it started at once, as a node that goes down does.
void kill_all(pid_t pid)
{
  const auto ranks = children(pid);
  kill(pid, SIGKILL);
  for (pid_t rank : ranks) kill(rank, SIGKILL);
  waitpid(pid, nullptr, 0);
}

bool wait_for(const std::string &file, pid_t pid, double seconds)
{
  const auto end = std::chrono::steady_clock::now() + std::chrono::duration<double>(seconds);
  while (std::chrono::steady_clock::now() < end) {
    if (size_of_file(file) >= 0) return true;
    if (waitpid(pid, nullptr, WNOHANG) == pid) return false;
    std::this_thread::sleep_for(std::chrono::milliseconds(1));
  }
  return false;
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
                          HasSubstr("Invalid LAMMPS restart file")))
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
  EXPECT_THAT(read_and_go_on("set.%"), HasSubstr("Unexpected"));
  std::remove("set.0");
  EXPECT_THAT(read_and_go_on("set.%"), HasSubstr("Cannot open restart file"));
  write_file("set.0", contents("old.0"));
  EXPECT_THAT(read_and_go_on("set.%"), AllOf(HasSubstr("step 90"), HasSubstr("step 100")));
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
