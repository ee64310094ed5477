// main() of the tests that run LAMMPS on several MPI ranks.
//
// Rank 0 prints what GoogleTest prints; the other ranks print failures only. A test that fails on
// any rank counts as failed on all of them, so that the summary and the exit code agree.

#include <gtest/gtest.h>

#include <mpi.h>

#include <chrono>
#include <cstdio>
#include <string>
#include <thread>

namespace {

class RankListener : public testing::EmptyTestEventListener {
 public:
  explicit RankListener(MPI_Comm world)
  {
    // messages of this class must not meet those of LAMMPS
    MPI_Comm_dup(world, &comm);
    MPI_Comm_rank(comm, &rank);
    MPI_Comm_size(comm, &size);
  }

  void OnTestPartResult(const testing::TestPartResult &part) override
  {
    if (rank == 0 || !part.failed()) return;
    // one write per message, else those of several ranks mix
    const std::string text = "[rank " + std::to_string(rank) + "] " +
        (part.file_name() ? part.file_name() : "?") + ":" + std::to_string(part.line_number()) +
        ": Failure\n" + part.message() + "\n";
    std::fputs(text.c_str(), stderr);
    std::fflush(stderr);
  }

  // All ranks meet here after each test.
  void OnTestEnd(const testing::TestInfo &info) override
  {
    const bool failed_here = info.result()->Failed();
    int mine = failed_here ? rank : size, first_failed = size;
    MPI_Request request;
    MPI_Iallreduce(&mine, &first_failed, 1, MPI_INT, MPI_MIN, comm, &request);

    // A rank that left a failed test early leaves the others waiting inside LAMMPS for ever:
    // end the program while the message of the failure is still the last thing printed.
    using clock = std::chrono::steady_clock;
    const auto start = clock::now();
    int done = 0;
    for (MPI_Test(&request, &done, MPI_STATUS_IGNORE); !done;
         MPI_Test(&request, &done, MPI_STATUS_IGNORE)) {
      if (failed_here && clock::now() - start > std::chrono::seconds(60)) {
        std::fprintf(stderr, "[rank %d] %s.%s failed here; the other ranks still wait: giving up\n",
                     rank, info.test_suite_name(), info.name());
        std::fflush(stderr);
        MPI_Abort(comm, 1);
      }
      std::this_thread::sleep_for(std::chrono::microseconds(200));
    }
    if (first_failed < size && !failed_here && rank == 0)
      ADD_FAILURE() << "failed on rank " << first_failed;
  }

 private:
  MPI_Comm comm;
  int rank, size;
};

}    // namespace

int main(int argc, char **argv)
{
  MPI_Init(&argc, &argv);
  testing::InitGoogleTest(&argc, argv);

  int rank;
  MPI_Comm_rank(MPI_COMM_WORLD, &rank);
  auto &listeners = testing::UnitTest::GetInstance()->listeners();
  if (rank != 0) delete listeners.Release(listeners.default_result_printer());
  listeners.Append(new RankListener(MPI_COMM_WORLD));

  int mine = RUN_ALL_TESTS(), any = 0;
  MPI_Allreduce(&mine, &any, 1, MPI_INT, MPI_MAX, MPI_COMM_WORLD);
  MPI_Finalize();
  return any;
}
