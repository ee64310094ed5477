#ifndef DEFE_TEST_PROGRAMS_H
#define DEFE_TEST_PROGRAMS_H

// Files, and programs that a test starts and kills.

#include <dirent.h>
#include <fcntl.h>
#include <sys/resource.h>
#include <sys/stat.h>
#include <sys/wait.h>
#include <unistd.h>

#include <chrono>
#include <csignal>
#include <cstdlib>
#include <cstring>
#include <fstream>
#include <sstream>
#include <string>
#include <thread>
#include <vector>

extern char **environ;

namespace defe::test {

inline long size_of_file(const std::string &file)
{
  struct stat info;
  return stat(file.c_str(), &info) == 0 ? static_cast<long>(info.st_size) : -1;
}

inline std::string contents(const std::string &file)
{
  std::ifstream in(file, std::ios::binary);
  std::ostringstream text;
  text << in.rdbuf();
  return text.str();
}

inline void write_file(const std::string &file, const std::string &text)
{
  std::ofstream(file, std::ios::binary) << text;
}

// ---- programs ----

/// Starts a program with its output in `log`. It knows nothing of the MPI job that this test is.
/// `memory`: it gets no more than this (bytes of addresses).
inline pid_t start(const std::vector<std::string> &command, const std::string &log, long memory = 0)
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
  // (the address sanitizer reserves terabytes of addresses, which it does not use)
  if (memory && !std::getenv("DEFE_SANITIZER_RUNTIME")) {
    const struct rlimit limit = {static_cast<rlim_t>(memory), static_cast<rlim_t>(memory)};
    setrlimit(RLIMIT_AS, &limit);
  }
  execve(argv[0], argv.data(), envp.data());
  _exit(127);
}

/// The processes that this one started.
inline std::vector<pid_t> children(pid_t parent)
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
inline void kill_all(pid_t pid)
{
  const auto ranks = children(pid);
  kill(pid, SIGKILL);
  for (pid_t rank : ranks) kill(rank, SIGKILL);
  waitpid(pid, nullptr, 0);
}

inline bool wait_for(const std::string &file, pid_t pid, double seconds)
{
  const auto end = std::chrono::steady_clock::now() + std::chrono::duration<double>(seconds);
  while (std::chrono::steady_clock::now() < end) {
    if (size_of_file(file) >= 0) return true;
    if (waitpid(pid, nullptr, WNOHANG) == pid) return false;
    std::this_thread::sleep_for(std::chrono::milliseconds(1));
  }
  return false;
}

/// Waits for its end: its exit code, -signal, or -1000 when it was killed after so many seconds.
inline int wait_for_end(pid_t pid, double seconds)
{
  const auto end = std::chrono::steady_clock::now() + std::chrono::duration<double>(seconds);
  int status = 0;
  while (waitpid(pid, &status, WNOHANG) != pid) {
    if (std::chrono::steady_clock::now() > end) {
      kill_all(pid);
      return -1000;
    }
    std::this_thread::sleep_for(std::chrono::milliseconds(1));
  }
  return WIFEXITED(status) ? WEXITSTATUS(status) : -WTERMSIG(status);
}

}    // namespace defe::test

#endif
