// The event file that a restart goes on with: it is the one that the run had written, to the last byte, or
// it is refused before anything of it is cut. What the script changes beside is said.
//
// ranks: 1 2

#include "cracking_beam.h"
#include "programs.h"

#include <gmock/gmock.h>

#include <functional>

using namespace defe::test;
using defe::Vec3;
using testing::AllOf;
using testing::HasSubstr;
using testing::Not;
using testing::StartsWith;

namespace {

constexpr int at_restart = 120, last = 160;

void write(const std::string &file, const std::string &text)
{
  if (rank_of(MPI_COMM_WORLD) == 0) write_file(file, text);
  MPI_Barrier(MPI_COMM_WORLD);
}

std::string read(const std::string &file)
{
  MPI_Barrier(MPI_COMM_WORLD);
  const std::string text = contents(file);
  MPI_Barrier(MPI_COMM_WORLD);
  return text;
}

Block beam(const std::string &events)
{
  Block block = cracking_beam();
  block.options = events.empty() ? "" : "events " + events;
  return block;
}

/// Up to step `last`, with a restart file at step `at_restart`; what the event file holds at both.
std::string first_run(const std::string &events, const std::string &restart, double speed = 1.0,
                      std::string *then = nullptr)
{
  const Block block = beam(events);
  remove_file(events);
  Lammps lmp;
  lmp.commands(block.script());
  bend(lmp, block, speed);
  lmp.run(at_restart);
  lmp.command("write_restart " + restart);
  if (then) *then = read(events);
  lmp.run(last - at_restart);
  return read(events);
}

/// How the run that goes on with this file ends; the same on all ranks.
std::string go_on(const std::string &restart, const std::string &events)
{
  std::string message;
  const Block block = beam(events);
  try {
    Lammps lmp;
    lmp.commands(block.header() + "read_restart " + restart + "\n" + block.fix_only() +
                 block.motion());
    lmp.run(last - at_restart);
  } catch (LAMMPS_NS::LAMMPSException &e) {
    message = e.what();
    message = message.substr(0, message.find('\n'));
  }
  std::string first = message;
  int n = static_cast<int>(first.size());
  MPI_Bcast(&n, 1, MPI_INT, 0, MPI_COMM_WORLD);
  first.resize(n);
  MPI_Bcast(&first[0], n, MPI_CHAR, 0, MPI_COMM_WORLD);
  EXPECT_EQ(message, first) << "other ranks know better";
  return message;
}

std::string lines_of_events(const std::string &text)
{
  std::istringstream in(text);
  std::string line, all;
  while (std::getline(in, line))
    if (line[0] != '#') all += line + "\n";
  return all;
}

}    // namespace

TEST(EventFile, HeadNamesRunAndMesh)
{
  const std::string text = first_run("named.txt", "named.restart");
  const std::string head = text.substr(0, text.find('\n'));
  EXPECT_THAT(head, AllOf(StartsWith("# DEFE events: run "), HasSubstr("mesh of 160 elements")));
  const auto with = [&](const std::function<void(Block &)> &change) {
    Block block = beam("other.txt");
    change(block);
    remove_file("other.txt");
    Lammps lmp;
    lmp.commands(block.script());
    bend(lmp, block);
    lmp.run(1);
    const std::string other = read("other.txt");
    return other.substr(0, other.find('\n'));
  };
  EXPECT_EQ(with([](Block &) {
            }),
            head);
  const std::string mesh = head.substr(head.find("mesh")), run = head.substr(0, head.find("mesh"));
  const std::string faster = with([](Block &b) {
    b.dt *= 0.5;
  });
  EXPECT_THAT(faster, AllOf(HasSubstr(mesh), Not(HasSubstr(run))));
  const std::string larger = with([](Block &b) {
    b.h *= 1.01;
  });
  EXPECT_THAT(larger, AllOf(Not(HasSubstr(mesh)), Not(HasSubstr(run))));
  if (rank_of(MPI_COMM_WORLD) == 0) {    // the same on any number of ranks
    const Block block = beam("alone.txt");
    remove_file("alone.txt", MPI_COMM_SELF);
    Lammps lmp(MPI_COMM_SELF);
    lmp.commands(block.script());
    bend(lmp, block);
    lmp.run(1);
    EXPECT_THAT(contents("alone.txt"), StartsWith(head + "\n"));
  }
  MPI_Barrier(MPI_COMM_WORLD);
}

TEST(EventFile, OnlyItsOwnIsContinued)
{
  std::string then;
  const std::string whole = first_run("own.txt", "own.restart", 1.0, &then);
  const std::string other = first_run("other.txt", "other.restart", 0.99);
  ASSERT_GT(whole.size(), then.size() + 100) << "a poor example";
  ASSERT_EQ(whole.substr(0, then.size()), then);
  const std::string middle = then.substr(0, then.size() / 2);

  // as it was at the restart file, or longer: it ends as before
  for (const std::string &file : {then, whole, then + "nonsense"}) {
    write("own.txt", file);
    EXPECT_EQ(go_on("own.restart", "own.txt"), "");
    EXPECT_EQ(read("own.txt"), whole);
  }
  std::string edited = whole;
  edited[then.size() / 2] = edited[then.size() / 2] == '1' ? '2' : '1';
  const std::vector<std::pair<std::string, std::string>> bad = {
      {"units si\nrun 10\n", "is no event file"},
      {"# my own notes\n" + whole, "is no event file"},
      {"", "is no event file"},
      {other, "is of another run"},
      {middle, "events are missing"},
      {then.substr(0, then.size() - 1), "events are missing"},
      {edited, "checksum is wrong"},
  };
  for (const auto &b : bad) {
    write("own.txt", b.first);
    EXPECT_THAT(go_on("own.restart", "own.txt"),
                AllOf(HasSubstr(b.second), HasSubstr("own.txt"), HasSubstr("put back")));
    EXPECT_EQ(read("own.txt"), b.first) << "nothing is cut";
  }
  remove_file("own.txt");
  EXPECT_THAT(go_on("own.restart", "own.txt"),
              HasSubstr("own.txt of the run that the restart file is of is missing"));

  // under another name: the same file, none yet, or a foreign one
  write("renamed.txt", whole);
  EXPECT_EQ(go_on("own.restart", "renamed.txt"), "");
  EXPECT_EQ(read("renamed.txt"), whole);
  remove_file("rest.txt");
  EXPECT_EQ(go_on("own.restart", "rest.txt"), "");
  EXPECT_EQ(lines_of_events(read("rest.txt")), lines_of_events(whole.substr(then.size())));
  EXPECT_THAT(read("rest.txt"),
              AllOf(StartsWith(whole.substr(0, whole.find('\n'))),
                    HasSubstr("# from step 120 on; "), HasSubstr("own.txt")));
  write("renamed.txt", other);
  EXPECT_THAT(go_on("own.restart", "renamed.txt"), HasSubstr("is of another run"));
  EXPECT_EQ(read("renamed.txt"), other);
}

// A run that had no event file gets one, but not in the place of another.
TEST(EventFile, NewFilesReplaceOnlyEventFiles)
{
  {
    const Block block = beam("");
    Lammps lmp;
    lmp.commands(block.script());
    bend(lmp, block);
    lmp.run(at_restart);
    lmp.command("write_restart none.restart");
  }
  const std::string whole = first_run("full.txt", "full.restart");
  remove_file("late.txt");
  EXPECT_EQ(go_on("none.restart", "late.txt"), "");
  EXPECT_THAT(read("late.txt"), StartsWith("# DEFE events: run "));
  write("late.txt", whole);
  EXPECT_THAT(go_on("none.restart", "late.txt"), HasSubstr("wrote no events"));
  EXPECT_EQ(read("late.txt"), whole);

  const auto begin = [&] {
    std::string message;
    const Block block = beam("begin.txt");
    try {
      Lammps lmp;
      lmp.commands(block.script() + "run 1\n");
    } catch (LAMMPS_NS::LAMMPSException &e) {
      message = e.what();
    }
    return message;
  };
  write("begin.txt", "units si\n");
  EXPECT_THAT(begin(),
              AllOf(HasSubstr("begin.txt is there and is no event file"),
                    HasSubstr("another name to the keyword events")));
  EXPECT_EQ(read("begin.txt"), "units si\n");
  for (const std::string &old : {std::string(), whole, std::string("# step time event id id2\n")}) {
    write("begin.txt", old);
    EXPECT_EQ(begin(), "");
    EXPECT_THAT(read("begin.txt"), StartsWith("# DEFE events: run "));
    EXPECT_EQ(lines_of_events(read("begin.txt")), "");
  }
}

// What the script says otherwise than the one before: one line each, none for numbers that are written
// in another way.
TEST(Script, ChangesAreSaid)
{
  const std::string same = "fix fe all defe material glass elastic 74.09e9 0.2 2500 convert glass "
                           "5.6e7 type 2 group particles contact 0.2 friction 0.1";
  {
    const Block block = cracking_beam();
    Lammps lmp;
    lmp.commands(block.header() + block.box() + "pair_style defe/joint\npair_coeff 2 2 " +
                 block.coeff + "\ngroup particles empty\n" + same + "\n" + block.mesh() +
                 block.motion() + "run 2\nwrite_restart script.restart\n");
  }
  const auto said = [](const std::string &fix) {
    remove_file("script.log");
    const Block block = cracking_beam();
    Lammps lmp;
    lmp.commands(block.header() + "log script.log\nread_restart script.restart\n" + fix + "\n" +
                 block.motion() + "run 1\nlog none\n");
    std::istringstream in(read("script.log"));
    std::string line, notes;
    while (std::getline(in, line))
      if (line.find("in the restart file") != std::string::npos) notes += line + "\n";
    return notes;
  };
  EXPECT_EQ(said(same), "");
  EXPECT_EQ(
      said("fix fe all defe material glass elastic 7.409e10 .2 2.5e3 convert glass 56e6 type 2 "
           "group particles contact .20 friction 1e-1 shield on"),
      "");
  EXPECT_EQ(said("fix fe all defe material glass elastic 74.09e9 0.2 2500 convert glass 5e7 type 2 "
                 "group particles contact 0.3 shield no stress gauss kernel lagrangian every 2"),
            "Note: fix fe defe has contact 0.3, and had 0.2 in the restart file\n"
            "Note: fix fe defe has contact ... friction 0, and had 0.1 in the restart file\n"
            "Note: fix fe defe has convert glass 50000000, and had 56000000 in the restart file\n"
            "Note: fix fe defe has every 2, and had 1 in the restart file\n"
            "Note: fix fe defe has kernel lagrangian, and had auto in the restart file\n"
            "Note: fix fe defe has shield no, and had yes in the restart file\n"
            "Note: fix fe defe has stress gauss, and had centre in the restart file\n");
  EXPECT_THROW(
      said("fix fe all defe material glass elastic 74.1e9 0.2 2500 convert glass 5.6e7 type 2 "
           "group particles contact 0.2 friction 0.1"),
      LAMMPS_NS::LAMMPSException);
}
