// Restart files with flipped bits, cut short, or put together of two runs: refused in one line on all
// ranks before they do harm, whoever wrote them and whoever reads them. Some hundred files are read,
// each by a LAMMPS of its own: on two and four ranks that can take more than 20 s.
//
// timeout: 300

#include "cracking_beam.h"
#include "programs.h"

#include "defe_records.h"
#include "lmprestart.h"

#include <gmock/gmock.h>

#include <functional>
#include <set>

using namespace defe::test;
using defe::Vec3;
using testing::AllOf;
using testing::AnyOf;
using testing::HasSubstr;

namespace {

// at the end of a sealed file: checksum and length, then what LAMMPS looks for
constexpr size_t seal_size = 40, magic_size = sizeof(MAGIC_STRING);

/// What a rank of the communicator gets.
std::string from_first(std::string text, MPI_Comm comm)
{
  int n = static_cast<int>(text.size());
  MPI_Bcast(&n, 1, MPI_INT, 0, comm);
  text.resize(n);
  MPI_Bcast(&text[0], n, MPI_CHAR, 0, comm);
  return text;
}

/// First line of the error with which commands end, which is the same on all ranks; "" if none.
std::string failure(MPI_Comm comm, const std::string &script)
{
  std::string message;
  try {
    Lammps lmp(comm);
    lmp.commands(script);
  } catch (LAMMPS_NS::LAMMPSException &e) {
    message = e.what();
    message = message.substr(0, message.find('\n'));
  }
  EXPECT_EQ(message, from_first(message, comm)) << "other ranks know better";
  MPI_Barrier(comm);
  return message;
}

void write(MPI_Comm comm, const std::string &file, const std::string &text)
{
  if (rank_of(comm) == 0) write_file(file, text);
  MPI_Barrier(comm);
}

std::string flipped(std::string text, size_t bit)
{
  text[bit / 8] = static_cast<char>(text[bit / 8] ^ (1 << (bit % 8)));
  return text;
}

/// The beam cracks in step 100, with all kinds of joints and contacts.
Block beam()
{
  Block block = cracking_beam();
  block.options = "contact 0.2 friction 0.1";
  return block;
}

void write_restarts(MPI_Comm comm, const std::string &commands, int seed = 8)
{
  Lammps lmp(comm);
  const Block block = beam();
  lmp.commands(block.script());
  bend(lmp, block);
  if (seed != 8)
    lmp.change([&](Particle &p) {
      p.v += 1e-3 * random_of(p.tag, seed);
    });
  lmp.run(100);
  EXPECT_GT(lmp.fe(DES), 100) << "a poor example";
  EXPECT_GT(lmp.fe(CONTACT), 20) << "a poor example";
  EXPECT_GT(lmp.fe(COHESIVE) + lmp.fe(TIES), 0) << "a poor example";
  lmp.commands(commands);
}

std::string go_on(const std::string &file)
{
  const Block block = beam();
  return block.header() + "read_restart " + file + "\n" + block.fix_only() + block.motion() +
      "run 3\n";
}

/// Bits from the mark of the pair style to the end that LAMMPS looks for: all that LAMMPS reads after
/// its own header.
size_t random_bit(const std::string &text, std::mt19937 &random)
{
  const size_t first = text.find(LAMMPS_NS::RESTART_FORMAT), last = text.size() - magic_size;
  EXPECT_LT(first, last);
  return 8 * first + random() % (8 * (last - first));
}

/// While it lives, this process gets no more than another half GB.
class LittleMemory {
 public:
  LittleMemory()
  {
    getrlimit(RLIMIT_AS, &old);
    struct rlimit limit = old;
    long pages = 0;
    std::ifstream("/proc/self/statm") >> pages;
    if (pages == 0) return;
    limit.rlim_cur = static_cast<rlim_t>(pages * sysconf(_SC_PAGESIZE)) + (1ul << 29);
    setrlimit(RLIMIT_AS, &limit);
  }
  ~LittleMemory() { setrlimit(RLIMIT_AS, &old); }

 private:
  struct rlimit old;
};

const auto is_refused = AllOf(HasSubstr("damaged"), HasSubstr("use an older"));

}    // namespace

// Bits anywhere in what LAMMPS reads after its header: programs that get little memory and time all
// end with one line.
TEST(Damaged, Programs)
{
  if (size_of(MPI_COMM_WORLD) > 1) GTEST_SKIP() << "the programs run on one rank";
  write_restarts(MPI_COMM_WORLD, "write_restart whole.restart");
  write_file("in.damaged", "plugin load " DEFE_PLUGIN_PATH "\n" + go_on("damaged.restart"));
  const std::string whole = contents("whole.restart");
  const auto run = [&](const std::string &text) {
    write_file("damaged.restart", text);
    const pid_t pid = start({DEFE_LMP_EXECUTABLE, "-in", "in.damaged", "-log", "none", "-nocite"},
                            "damaged.out", 2L << 30);
    return wait_for_end(pid, 30.0);
  };
  ASSERT_EQ(run(whole), 0) << contents("damaged.out");
  std::mt19937 random(11);
  for (int k = 0; k < 20; k++) {    // half a second each, to start; many more are read below
    const size_t bit = random_bit(whole, random);
    EXPECT_EQ(run(flipped(whole, bit)), 1) << "bit " << bit;
    const std::string out = contents("damaged.out");
    const auto at = out.find("ERROR");
    ASSERT_NE(at, std::string::npos) << "bit " << bit << out;
    EXPECT_EQ(out.find("ERROR", at + 1), std::string::npos) << out;
    EXPECT_THAT(out.substr(at, out.find('\n', at) - at),
                AllOf(is_refused, HasSubstr("damaged.restart")))
        << "bit " << bit;
  }
}

// 200 bits on one rank, fewer on more, of files that others wrote; and cut, with the end that LAMMPS looks for.
// There is no room for what a wrong size would ask for, and ctest ends what hangs.
TEST(Damaged, SingleFiles)
{
  const LittleMemory limit;
  for (const auto &change : changes_of_ranks()) {
    const bool all = change == changes_of_ranks().front();    // of the others, fewer
    on_ranks(change.first, [](MPI_Comm comm) {
      write_restarts(comm, "write_restart whole.restart");
    });
    on_ranks(change.second, [all](MPI_Comm comm) {
      const std::string whole = from_first(contents("whole.restart"), comm);
      EXPECT_EQ(failure(comm, go_on("whole.restart")), "");
      std::mt19937 random(12);
      for (int k = 0; k < (!all ? 10 : size_of(comm) == 1 ? 200 : 60); k++) {
        const size_t bit = random_bit(whole, random);
        write(comm, "bad.restart", flipped(whole, bit));
        EXPECT_THAT(failure(comm, go_on("bad.restart")), is_refused) << "bit " << bit;
      }
      const std::string magic = whole.substr(whole.size() - magic_size);
      const size_t first = whole.find(LAMMPS_NS::RESTART_FORMAT);
      for (int k = 0; k < 20; k++) {
        const size_t size = k == 0 ? whole.size() - magic_size - seal_size
                                   : first + random() % (whole.size() - first);
        if (size == whole.size() - magic_size) continue;
        write(comm, "bad.restart", whole.substr(0, size) + magic);
        EXPECT_THAT(failure(comm, go_on("bad.restart")), is_refused) << size << " bytes";
      }
    });
  }
}

// A file per rank or per group of ranks: each is looked at, and that they belong together.
TEST(Damaged, SetsOfFiles)
{
  const int size = size_of(MPI_COMM_WORLD);
  for (const auto &change : changes_of_ranks()) {
    const int n = change.first;
    std::set<std::string> kinds = {""};
    if (n > 1) kinds.insert({" nfile " + std::to_string(n - 1), " fileper 2"});
    for (const std::string &kind : kinds) {
      on_ranks(n, [&](MPI_Comm comm) {
        write_restarts(comm, "write_restart other.%" + kind, 9);
        write_restarts(comm, "write_restart set.%" + kind + "\nwrite_restart set*.%" + kind);
      });
      const int files = kind.empty() ? n : kind == " fileper 2" ? (n + 1) / 2 : n - 1;
      on_ranks(change.second, [&](MPI_Comm comm) {
        EXPECT_EQ(failure(comm, go_on("set.%")), "") << n << kind;
        if (size <= 2) { EXPECT_EQ(failure(comm, go_on("set*.%")), "") << n << kind; }
        EXPECT_THAT(failure(comm, go_on("set.base")), HasSubstr("% for 'base'"));
        std::mt19937 random(13);
        for (int k = -1; k < files; k++) {
          const std::string file = "set." + (k < 0 ? "base" : std::to_string(k));
          const std::string whole = from_first(contents(file), comm);
          ASSERT_GE(whole.size(), 16 + magic_size);
          for (int j = 0; j < 6; j++) {
            const size_t bit = k < 0 ? random_bit(whole, random) : random() % (8 * whole.size());
            write(comm, file, flipped(whole, bit));
            EXPECT_THAT(failure(comm, go_on("set.%")), AllOf(is_refused, HasSubstr(file)))
                << "bit " << bit << kind;
          }
          if (whole.size() < 100) {    // no atoms: the same in any run
            write(comm, file, whole);
            continue;
          }
          write(comm, file,
                whole.substr(0, whole.size() / 2) + whole.substr(whole.size() - magic_size));
          EXPECT_THAT(failure(comm, go_on("set.%")), AllOf(is_refused, HasSubstr(file))) << kind;
          if (k >= 0) {    // of another run, at the same step
            write(comm, file, from_first(contents("other." + std::to_string(k)), comm));
            EXPECT_THAT(failure(comm, go_on("set.%")),
                        AllOf(HasSubstr("does not belong"), HasSubstr(file)))
                << kind;
            if (rank_of(comm) == 0) std::remove(file.c_str());
            MPI_Barrier(comm);
            EXPECT_THAT(failure(comm, go_on("set.%")),
                        AllOf(HasSubstr("Cannot open"), HasSubstr(file)));
          }
          write(comm, file, whole);
        }
        EXPECT_EQ(failure(comm, go_on("set.%")), "") << n << kind;
      });
    }
  }
}

// ---- without a pair style of DEFE: nobody looks at the file before LAMMPS reads it ----

namespace {

/// Finite elements alone, in motion across periodic borders.
Block elastic()
{
  Block block;
  block.boundary = "p p f";
  block.lo[0] = 0.026;
  return block;
}

std::string elastic_fix(const std::string &id = "fe")
{
  return "fix " + id + " all defe material glass prony 2e9 1100 1e6 2 3e8 2e5 1e8 1e6\n";
}

void write_elastic(MPI_Comm comm, const std::string &commands, int seed = 2)
{
  const Block block = elastic();
  Lammps lmp(comm);
  lmp.commands(block.header() + block.box() + "pair_style zero 0.001\npair_coeff * *\n" +
               "group particles empty\n" + elastic_fix() + block.mesh() + block.motion());
  lmp.change([seed](Particle &p) {
    p.v = 30.0 * random_of(p.tag, seed) + 200.0 * Vec3::UnitX();
  });
  lmp.run(60);
  lmp.commands(commands);
}

std::string elastic_go_on(const std::string &file, const std::string &before = "",
                          const std::string &id = "fe")
{
  const Block block = elastic();
  return block.header() + "read_restart " + file + "\n" + before + elastic_fix(id) +
      block.motion() + "run 3\n";
}

/// Where the atoms' records are in a single file, in bytes: LAMMPS' own layout.
std::vector<std::pair<size_t, size_t>> records(const std::string &text)
{
  std::vector<std::pair<size_t, size_t>> list;
  const auto integer = [&](size_t at) {
    int a = 0;
    if (at + sizeof(int) <= text.size()) std::memcpy(&a, &text[at], sizeof(int));
    return a;
  };
  const size_t end = text.size() - magic_size - seal_size - magic_size;
  for (size_t start = 0; start < end; start++) {
    if (integer(start) != MULTIPROC || integer(start + 4) != 0 || integer(start + 8) != -1)
      continue;
    list.clear();
    size_t at = start + 12;
    while (at < end && integer(at) == PERPROC && integer(at + 4) >= 0) {
      size_t next = at + 8;
      const size_t last = next + 8 * static_cast<size_t>(integer(at + 4));
      if (last > end) break;
      while (next < last) {
        double size;
        std::memcpy(&size, &text[next], 8);
        if (!(size >= 1.0) || size * 8 > last - next) break;
        list.emplace_back(next, 8 * static_cast<size_t>(size));
        next += list.back().second;
      }
      at = last;
    }
    if (at == end && !list.empty()) return list;
  }
  ADD_FAILURE() << "no records found";
  return list;
}

}    // namespace

// Flipped bits of the records, and of positions, velocities, radii, masses and IDs that LAMMPS keeps.
// Not of LAMMPS' own size of the record (it may run away) and of the groups, which may be defined
// anew.
TEST(Damaged, RecordsWithoutPairStyle)
{
  for (const auto &change : changes_of_ranks()) {
    const bool all = change == changes_of_ranks().front();    // of the others, fewer
    on_ranks(change.first, [](MPI_Comm comm) {
      write_elastic(comm, "write_restart elastic.restart");
    });
    on_ranks(change.second, [all](MPI_Comm comm) {
      const std::string whole = from_first(contents("elastic.restart"), comm);
      EXPECT_EQ(failure(comm, elastic_go_on("elastic.restart")), "");
      const auto list = records(whole);
      ASSERT_EQ(list.size(), static_cast<size_t>(elastic().nodes()));

      const auto refused =
          AnyOf(is_refused, HasSubstr("Did not assign all restart atoms correctly"),
                HasSubstr("atom IDs"));
      std::mt19937 random(14);
      int ours = 0;
      for (int k = 0; k < (!all ? 10 : size_of(comm) == 1 ? 100 : 40); k++) {
        const auto &record = list[random() % list.size()];
        // LAMMPS' part of the record is smaller: each word of it is hit as often as all of ours
        const size_t words = record.second / 8, lammps = 16;
        size_t word = random() % 2 ? 1 + random() % (lammps - 1)
                                   : lammps + random() % (words - lammps);
        size_t bit = random() % 64;
        if (word == 6) continue;     // groups
        if (word == 5) bit %= 32;    // a type has 32 bits: the others say nothing
        // a position in another world: LAMMPS wraps it back through the periodic box for ever
        if (word <= 3 && bit >= 52) bit -= 32;
        if (word == 4) bit %= 8;    // a large ID, a large table
        const std::string bad = flipped(whole, 8 * (record.first + 8 * word) + bit);
        write(comm, "bad.restart", bad);
        const std::string message = failure(comm, elastic_go_on("bad.restart"));
        EXPECT_THAT(message, refused) << "word " << word << " of a record, bit " << bit;
        ours += message.find("Checksums of 1 atoms") != std::string::npos;
      }
      EXPECT_GT(ours, all ? 20 : 3) << "a poor example";

      // of what is written once
      int bytes = 0;
      const size_t global = whole.find(LAMMPS_NS::RESTART_FORMAT);
      std::memcpy(&bytes, &whole[global - sizeof(int)], sizeof(int));
      ASSERT_GT(bytes, 200);
      ASSERT_LT(bytes, 1000);
      for (int k = 0; k < (!all ? 5 : size_of(comm) == 1 ? 50 : 20); k++) {
        const size_t bit = 8 * global + random() % (8 * bytes);
        write(comm, "bad.restart", flipped(whole, bit));
        EXPECT_THAT(failure(comm, elastic_go_on("bad.restart")), is_refused) << "bit " << bit;
      }

      // one record twice, another one lost: each is good
      std::string bad = whole;
      size_t a = 0, b = 1;
      while (b + 1 < list.size() && list[b].second != list[a].second) b++;
      ASSERT_EQ(list[a].second, list[b].second);
      bad.replace(list[b].first, list[b].second, whole, list[a].first, list[a].second);
      write(comm, "bad.restart", bad);
      EXPECT_THAT(failure(comm, elastic_go_on("bad.restart")), HasSubstr("of two runs"));
    });
  }
}

// What the fix writes once, checksums included, does not depend on the ranks that write.
TEST(Damaged, ChecksumsOfAnyRanks)
{
  const auto written_once = [](const std::string &file, MPI_Comm comm) {
    const std::string text = from_first(contents(file), comm);
    const size_t at = text.find(LAMMPS_NS::RESTART_FORMAT);
    int bytes = 0;
    if (at != std::string::npos) std::memcpy(&bytes, &text[at - sizeof(int)], sizeof(int));
    EXPECT_GT(bytes, 200);
    return text.substr(at, bytes);
  };
  for (const auto &change : changes_of_ranks()) {
    on_ranks(change.first, [](MPI_Comm comm) {
      write_elastic(comm, "write_restart elastic.restart");
    });
    on_ranks(change.second, [&](MPI_Comm comm) {
      const Block block = elastic();
      EXPECT_EQ(failure(comm,
                        block.header() + "read_restart elastic.restart\n" + elastic_fix() +
                            "write_restart again.restart noinit\n"),
                "");
      EXPECT_EQ(written_once("again.restart", comm), written_once("elastic.restart", comm));
    });
  }
}

// Files of two runs, without a pair style of DEFE: at the same step and at different ones.
TEST(Damaged, SetsOfTwoRunsWithoutPairStyle)
{
  const auto mix = [](const std::string &other) {
    MPI_Barrier(MPI_COMM_WORLD);
    write(MPI_COMM_WORLD, "set.0", from_first(contents(other), MPI_COMM_WORLD));
    return failure(MPI_COMM_WORLD, elastic_go_on("set.%"));
  };
  write_elastic(MPI_COMM_WORLD, "write_restart other.%", 3);
  write_elastic(MPI_COMM_WORLD,
                "write_restart set.%\nwrite_restart good.%\nrun 10\n"
                "write_restart later.%");
  EXPECT_EQ(mix("good.0"), "");
  EXPECT_THAT(mix("other.0"), HasSubstr("of two runs"));
  EXPECT_THAT(mix("later.0"), AllOf(HasSubstr("of step 70"), HasSubstr("of step 60")));
}

// ---- what is done between read_restart and fix defe ----

TEST(Damaged, CommandsBeforeTheFix)
{
  write_elastic(MPI_COMM_WORLD, "write_restart elastic.restart");
  const auto go = [](const std::string &before) {
    return failure(MPI_COMM_WORLD, elastic_go_on("elastic.restart", before));
  };
  EXPECT_EQ(go("group left id 1 2 3\ngroup nodes id 1\n"), "");    // groups are free
  for (const std::string before : {"velocity all set 1 0 0\n", "set atom 7 mass 1e-6\n"})
    EXPECT_THAT(
        go(before),
        AllOf(HasSubstr("between read_restart and fix defe"), HasSubstr("do that after fix defe")))
        << before;
  // deleting moves the last atom to the free place, and LAMMPS leaves its record behind
  EXPECT_THAT(go("group some id 3\ndelete_atoms group some compress no\n"),
              HasSubstr("between read_restart and fix defe"));
}

// Under another ID it would find no elements.
TEST(Damaged, OtherIdOfTheFix)
{
  const auto names =
      AllOf(HasSubstr("fix fe defe"), HasSubstr("has the ID fx"), HasSubstr("give it the ID fe"));
  write_elastic(MPI_COMM_WORLD, "write_restart elastic.restart");
  EXPECT_THAT(failure(MPI_COMM_WORLD, elastic_go_on("elastic.restart", "", "fx")), names);
  write_restarts(MPI_COMM_WORLD, "write_restart whole.restart");
  const Block block = beam();
  std::string fix = block.fix_only();
  fix.replace(fix.find("fe"), 2, "fx");
  EXPECT_THAT(failure(MPI_COMM_WORLD, block.header() + "read_restart whole.restart\n" + fix),
              names);
  // there may be a second one after it has gone
  EXPECT_EQ(failure(MPI_COMM_WORLD,
                    block.header() + "read_restart whole.restart\n" + block.fix_only() +
                        block.motion() + "run 0\n"),
            "");
}
