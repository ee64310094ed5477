// Conversions that are collected: at most one step of every so many converts.

#include "cracking_beam.h"

#include <algorithm>
#include <cmath>
#include <iterator>

using namespace defe::test;

namespace {

constexpr int last = 220;

Block collecting(const std::string &options)
{
  Block block = cracking_beam();
  block.options = options;
  return block;
}

History run(const std::string &options, const std::string &file, MPI_Comm comm = MPI_COMM_WORLD,
            const std::vector<std::string> &pieces = {"run " + std::to_string(last)},
            const std::string &restarts = "")
{
  const Block block = collecting(options + " events " + file);
  remove_file(file, comm);
  {
    Lammps lmp(comm);
    lmp.commands(block.script() + restarts);
    bend(lmp, block);
    for (const auto &piece : pieces) lmp.command(piece);
  }
  MPI_Barrier(comm);
  const auto list = history(file);
  MPI_Barrier(comm);    // all have read it before it is written anew
  return list;
}

History conversions_of(const History &all)
{
  History list;
  std::copy_if(all.begin(), all.end(), std::back_inserter(list), [](const auto &e) {
    return std::get<1>(e) == "convert";
  });
  return list;
}

}    // namespace

// Elements convert in the last evaluation's wake of a window only, every marked one: the first no later than that,
// and what was seen above its stress once converts, even if it is relieved until then.
TEST(Collect, OnlyAtTheEndOfAWindow)
{
  const auto at_once = conversions_of(run("", "at_once.txt"));
  ASSERT_GT(at_once.size(), 20u) << "a poor example";
  struct Case {
    std::string options;
    int window, first;    // steps of conversions are `first` beyond a multiple of the window
  };
  for (const Case &c : {Case{"collect 6", 6, 0}, Case{"every 3 collect 6 check yes", 6, 5},
                        Case{"every 3 collect 2", 3, 2}}) {
    const auto list = conversions_of(run(c.options, "collected.txt"));
    ASSERT_GT(list.size(), 20u) << c.options;
    for (const auto &e : list) EXPECT_EQ(std::get<0>(e) % c.window, c.first) << c.options;
    const long soon = std::get<0>(list.front()) - std::get<0>(at_once.front());
    EXPECT_GE(soon, 0) << c.options;
    EXPECT_LT(soon, c.window + 3) << c.options;
    // of those that were the first to convert without windows all convert now, with the first
    for (const auto &e : at_once)
      if (std::get<0>(e) == std::get<0>(at_once.front())) {
        const bool found = std::any_of(list.begin(), list.end(), [&](const auto &other) {
          return std::get<0>(other) == std::get<0>(list.front()) &&
              std::get<2>(other) == std::get<2>(e);
        });
        EXPECT_TRUE(found) << c.options << ", element " << std::get<2>(e);
      }
  }
}

// A window of one step is none.
TEST(Collect, OneStepIsAsBefore)
{
  EXPECT_EQ(run("collect 1", "one_step.txt"), run("", "none.txt"));
}

// The window in which a crack that runs at half the speed of shear waves comes one DE farther.
TEST(Collect, AutoIsAsLongAsACrackNeeds)
{
  const Block block = cracking_beam();
  const double shear = std::sqrt(block.E / (2.0 * (1.0 + block.nu)) / block.rho);
  const int window = static_cast<int>(0.5 * block.h / (0.5 * shear * block.dt));
  ASSERT_GT(window, 3) << "a poor example";
  const auto by_itself = run("collect auto", "auto.txt");
  ASSERT_GT(conversions_of(by_itself).size(), 20u) << "a poor example";
  EXPECT_EQ(by_itself, run("collect " + std::to_string(window), "window.txt"));
}

TEST(Collect, SameOnAnyRanks)
{
  for (const std::string options : {"collect 7", "collect auto"}) {
    const auto here = run(options, "ranks.txt");
    if (rank_of(MPI_COMM_WORLD) == 0) {
      EXPECT_EQ(here, run(options, "alone.txt", MPI_COMM_SELF)) << options;
    }
    MPI_Barrier(MPI_COMM_WORLD);
  }
}

// In a window elements are marked and wait: over restarts and runs in pieces, too.
TEST(Collect, RestartsAndPiecesInAWindow)
{
  for (const std::string options : {"every 3 collect 12", "collect auto"}) {
    SCOPED_TRACE(options);
    const auto whole = run(options, "whole.txt", MPI_COMM_WORLD, {"run " + std::to_string(last)},
                           "restart 1 window.*.restart\n");
    ASSERT_GT(conversions_of(whole).size(), 20u) << "a poor example";
    // the longest wait is that of the first elements, which are marked up to a window before they convert
    const long first = std::get<0>(conversions_of(whole).front());
    for (const long step : {first - 5, first - 1}) {
      const Block block = collecting(options + " events part.txt");
      remove_file("part.txt");
      {
        Lammps lmp;
        lmp.commands(block.header() + "read_restart window." + std::to_string(step) + ".restart\n" +
                     block.fix_only() + block.motion());
        lmp.run(static_cast<int>(last - step));
      }
      MPI_Barrier(MPI_COMM_WORLD);
      EXPECT_EQ(history("part.txt"), history("whole.txt", step)) << "from step " << step;
      MPI_Barrier(MPI_COMM_WORLD);
    }
    std::vector<std::string> pieces;
    for (int k = 0; k < last; k += 20)
      for (const char *piece : {"run 3", "run 8 pre no", "run 9"}) pieces.emplace_back(piece);
    EXPECT_EQ(run(options, "pieces.txt", MPI_COMM_WORLD, pieces), whole);
  }
}
