// The event file: order and form of its lines, and what a run from a restart file goes on with, cuts or refuses.

#include "defe/coupling/event_log.h"

#include <gmock/gmock.h>

#include <algorithm>
#include <cstdio>
#include <fstream>
#include <random>
#include <sstream>

using namespace defe;
using testing::AllOf;
using testing::HasSubstr;
using testing::StartsWith;

namespace {

std::string read(const std::string &file)
{
  std::ifstream in(file, std::ios::binary);
  std::ostringstream text;
  text << in.rdbuf();
  return text.str();
}

void write(const std::string &file, const std::string &text)
{
  std::ofstream(file, std::ios::binary) << text;
}

Event event(std::int64_t step, EventKind what, std::int64_t a, std::int64_t b = 0)
{
  return {step, 1e-7 * static_cast<double>(step), what, a, b, {0.1, 0.2, 0.3}, {0, 1, 0}, 0.5};
}

/// A file of its own for each test, and none is left.
class EventFile : public testing::Test {
 protected:
  EventFile() { std::remove(name.c_str()); }
  ~EventFile() override { std::remove(name.c_str()); }

  /// A run that has written its events up to step 10.
  EventLog first_run() const
  {
    EventLog log;
    log.set_file(name);
    log.name_run(0x1234, 0xabcd, 160);
    EXPECT_EQ(log.open(true), "");
    EXPECT_EQ(
        log.append({event(3, EventKind::CONVERT, 7, 1), event(10, EventKind::COHESIVE, 8, 9)}), "");
    return log;
  }

  /// One that goes on from there.
  EventLog second_run(const EventLog::Written &then) const
  {
    EventLog log;
    log.set_file(name);
    log.go_on(then, 10);
    return log;
  }

  const std::string name = std::string("events.") +
      testing::UnitTest::GetInstance()->current_test_info()->name() + ".txt";
};

}    // namespace

TEST(Events, OrderDoesNotDependOnWhoReports)
{
  const std::vector<Event> sorted = {
      event(1, EventKind::CONVERT, 9),     event(1, EventKind::COHESIVE, 2, 3),
      event(1, EventKind::COHESIVE, 2, 4), event(1, EventKind::COHESIVE, 3, 1),
      event(1, EventKind::BROKEN, 1, 2),   event(1, EventKind::ADHESIVE, 1, 2),
      event(1, EventKind::DEBONDED, 1, 2), event(2, EventKind::CONVERT, 1)};
  auto mixed = sorted;
  std::mt19937 random(1);
  for (int k = 0; k < 20; k++) {
    std::shuffle(mixed.begin(), mixed.end(), random);
    std::sort(mixed.begin(), mixed.end(), comes_before);
    for (size_t n = 0; n < sorted.size(); n++) EXPECT_EQ(line_of(mixed[n]), line_of(sorted[n]));
  }
}

TEST(Events, Line)
{
  const Event e{12345678901,
                1.0 / 3.0,
                EventKind::DEBONDED,
                5,
                -6,
                {-0.0125, 1e-20, 123456.789},
                {1.0, -0.70710678, 0.0},
                6.02214076e23};
  EXPECT_EQ(line_of(e),
            "12345678901 0.333333333 debonded 5 -6 -0.0125 1e-20 123456.789 1 -0.7071 0 "
            "6.02214e+23\n");
  EXPECT_STREQ(name_of(EventKind::CONVERT), "convert");
  EXPECT_STREQ(name_of(EventKind::COHESIVE), "cohesive");
  EXPECT_STREQ(name_of(EventKind::BROKEN), "broken");
  EXPECT_STREQ(name_of(EventKind::ADHESIVE), "adhesive");
}

TEST(Events, WithoutAFileNoneAreKept)
{
  EventLog log;
  log.record(event(1, EventKind::CONVERT, 1));
  EXPECT_FALSE(log.on());
  EXPECT_TRUE(log.take().empty());
  log.set_file("never_opened.txt");
  log.record(event(1, EventKind::CONVERT, 1));
  EXPECT_EQ(log.take().size(), 1u);
  EXPECT_TRUE(log.take().empty());
}

TEST_F(EventFile, HeadNamesRunAndMesh)
{
  const EventLog log = first_run();
  const std::string text = read(name);
  EXPECT_THAT(
      text,
      AllOf(StartsWith("# DEFE events: run 0000000000001235, mesh of 160 elements with "
                       "checksum 000000000000abcd\n# step time event id id2"),
            HasSubstr("\n3 3e-07 convert 7 1 0.1 0.2 0.3 0 1 0 0.5\n10 1e-06 cohesive 8 9 ")));
  EXPECT_EQ(log.written().bytes, static_cast<std::int64_t>(text.size()));
  EXPECT_EQ(log.written().sum, checksum(text.data(), text.size()));
  EXPECT_EQ(log.written().lines, 2);
}

// On other ranks the file is not touched.
TEST_F(EventFile, OneRankWrites)
{
  EventLog log;
  log.set_file(name);
  EXPECT_EQ(log.open(false), "");
  EXPECT_TRUE(log.opened());
  EXPECT_FALSE(std::ifstream(name).good());
}

TEST_F(EventFile, RestartCutsWhatHappensAgain)
{
  EventLog first = first_run();
  const auto then = first.written();
  first.append({event(12, EventKind::BROKEN, 8, 9)});
  const std::string whole = read(name);
  EventLog second = second_run(then);
  EXPECT_FALSE(second.opened());
  EXPECT_EQ(second.open(true), "");
  EXPECT_EQ(read(name), whole.substr(0, then.bytes));
  second.append({event(12, EventKind::BROKEN, 8, 9)});
  EXPECT_EQ(read(name), whole);
  EXPECT_EQ(second.written().sum, first.written().sum);
  EXPECT_EQ(second.written().lines, 3);
  EXPECT_EQ(second.written().run, first.written().run);
}

TEST_F(EventFile, WhatIsNotItsOwnIsRefusedAndLeftAlone)
{
  EventLog first = first_run();
  const auto then = first.written();
  const std::string whole = read(name);
  std::string edited = whole, other = whole;
  edited[whole.size() - 5] ^= 1;
  other[20] = '7';
  const std::vector<std::pair<std::string, std::string>> bad = {
      {"my notes\n", "is no event file"},
      {"", "is no event file"},
      {other, "is of another run: put back that of run 0000000000001235 with a mesh of 160"},
      {whole.substr(0, whole.size() - 1), "events are missing"},
      {edited, "its checksum is wrong"},
  };
  for (const auto &b : bad) {
    write(name, b.first);
    EventLog second = second_run(then);
    EXPECT_THAT(second.open(true),
                AllOf(HasSubstr(b.second), HasSubstr(name), HasSubstr("put back"),
                      HasSubstr("another name to the keyword events")));
    EXPECT_EQ(read(name), b.first);
    EXPECT_FALSE(second.opened());
  }
  std::remove(name.c_str());
  EXPECT_THAT(second_run(then).open(true), HasSubstr("is missing: put it back"));
}

TEST_F(EventFile, UnderAnotherNameTheRestFollows)
{
  EventLog first = first_run();
  auto then = first.written();
  then.name = "elsewhere.txt";
  std::remove(name.c_str());
  EventLog second = second_run(then);
  EXPECT_EQ(second.open(true), "");
  EXPECT_THAT(read(name), HasSubstr("\n# from step 10 on; 2 events before are in elsewhere.txt\n"));
  EXPECT_EQ(second.written().name, name);
}

TEST_F(EventFile, OnlyEventFilesAreReplaced)
{
  const auto begin = [&] {
    EventLog log;
    log.set_file(name);
    log.name_run(1, 2, 3);
    return log.open(true);
  };
  write(name, "units si\n");
  EXPECT_THAT(begin(), HasSubstr("is there and is no event file: remove it"));
  EXPECT_EQ(read(name), "units si\n");
  for (const std::string &old : {std::string(), std::string("# step time event id id2\n1 2 3\n"),
                                 std::string("# DEFE events: run 77\n")}) {
    write(name, old);
    EXPECT_EQ(begin(), "");
    EXPECT_THAT(read(name), StartsWith("# DEFE events: run 0000000000000001"));
  }
  // the run of the restart file had none
  EXPECT_THAT(second_run(EventLog::Written()).open(true), HasSubstr("wrote no events: remove it"));
}

TEST(Events, FileThatCannotBeWritten)
{
  EventLog log;
  log.set_file("no/such/folder/events.txt");
  log.name_run(1, 2, 3);
  EXPECT_THAT(log.open(true),
              AllOf(HasSubstr("cannot write its event file no/such"), HasSubstr("No such file")));
}
