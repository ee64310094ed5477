// Restart files and event files that are damaged at random: each is refused in one line that says what to
// do, or it was no damage and the run ends as it would have. Seeded; some seconds here, as long as one
// likes with
//
//   DEFE_FUZZ_SECONDS=600 DEFE_FUZZ_SEED=7 lammps_file_fuzz     (tests/fuzz.sh --files 600)
//
// ranks: 1 2
// timeout: 240

#include "cracking_beam.h"
#include "programs.h"

#include "defe_records.h"
#include "lmprestart.h"

#include <gmock/gmock.h>

#include <chrono>
#include <functional>

using namespace defe::test;
using testing::AllOf;
using testing::AnyOf;
using testing::HasSubstr;

namespace {

constexpr int at_restart = 100, last = 110;
constexpr size_t magic_size = sizeof(MAGIC_STRING);    // LAMMPS looks for it at the end

/// So many files, or as long as the environment says.
class Budget {
 public:
  explicit Budget(int files) : left(files)
  {
    if (const char *text = std::getenv("DEFE_FUZZ_SECONDS")) seconds = 0.5 * std::atof(text);
  }
  bool more()
  {
    tried++;
    if (seconds == 0.0) return left-- > 0;
    int go =
        std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count() < seconds;
    MPI_Bcast(&go, 1, MPI_INT, 0, MPI_COMM_WORLD);
    return go;
  }
  ~Budget()
  {
    if (seconds > 0.0 && rank_of(MPI_COMM_WORLD) == 0) std::printf("%ld files\n", tried - 1);
  }

 private:
  long left, tried = 0;
  double seconds = 0.0;
  std::chrono::steady_clock::time_point start = std::chrono::steady_clock::now();
};

unsigned seed()
{
  const char *text = std::getenv("DEFE_FUZZ_SEED");
  return text ? static_cast<unsigned>(std::atol(text)) : 2026u;
}

std::string from_first(std::string text)
{
  int n = static_cast<int>(text.size());
  MPI_Bcast(&n, 1, MPI_INT, 0, MPI_COMM_WORLD);
  text.resize(n);
  MPI_Bcast(&text[0], n, MPI_CHAR, 0, MPI_COMM_WORLD);
  return text;
}

/// A change at random of the bytes from `first` to `end`; `other` is another file of that kind.
std::string damaged(std::string text, size_t first, size_t end, const std::string &other,
                    std::mt19937 &random)
{
  const auto place = [&] {
    return first + random() % (end - first);
  };
  const size_t a = place(), n = std::min<size_t>(1 + random() % (1u << random() % 12), end - a);
  switch (random() % 9) {
    case 0:
      text[a] = static_cast<char>(text[a] ^ (1 << random() % 8));
      break;
    case 1:
      for (size_t k = a; k < a + n; k++) text[k] = static_cast<char>(random());
      break;
    case 2:
      std::fill_n(text.begin() + static_cast<long>(a), n, static_cast<char>(random() % 2 ? 0 : -1));
      break;
    case 3: {    // a number that is too large, negative or none
      const int32_t ints[] = {INT32_MAX, INT32_MIN, -1, 0, 1 << 30};
      const double reals[] = {1e300, -1e300, HUGE_VAL, NAN, 1e-300};
      char bytes[8];
      const int which = static_cast<int>(random() % 5);
      const size_t size = random() % 2 ? 4 : 8;
      if (size == 4) std::memcpy(bytes, &ints[which], 4);
      if (size == 8) std::memcpy(bytes, &reals[which], 8);
      for (size_t k = 0; k < size && a + k < end; k++) text[a + k] = bytes[k];
      break;
    }
    case 4:
      text.erase(a, n);
      break;
    case 5:
      text.insert(a, text.substr(place(), n));
      break;
    case 6: {
      const std::string moved = text.substr(place(), n);
      text.replace(a, std::min(moved.size(), end - a), moved.substr(0, end - a));
      break;
    }
    case 7:
      if (a < other.size()) text.replace(a, n, other.substr(a, n));
      break;
    default:
      text = text.substr(0, a) + text.substr(end);
  }
  return text;
}

Block beam(const std::string &events)
{
  Block block = cracking_beam();
  block.options = "contact 0.2 friction 0.1 events " + events;
  return block;
}

void write_files(const std::string &name, double speed)
{
  const Block block = beam(name + ".txt");
  remove_file(name + ".txt");
  Lammps lmp;
  lmp.commands(block.script());
  bend(lmp, block, speed);
  lmp.run(at_restart);
  EXPECT_GT(lmp.fe(DES), 100) << "a poor example";
  lmp.commands("write_restart " + name + ".restart\nwrite_restart " + name + ".set.%");
  lmp.run(last - at_restart);
}

/// LAMMPS does not close the file that it reads when that ends in an error; a long run would have none left.
void close_left_open()
{
  for (int fd = 3; fd < 64; fd++) {
    char name[4096];
    const auto n = readlink(("/proc/self/fd/" + std::to_string(fd)).c_str(), name, sizeof(name));
    if (n > 0 && std::string(name, static_cast<size_t>(n)).find("/fuzz.") != std::string::npos)
      close(fd);
  }
}

struct End {
  std::string message;    // "" if it got there
  Particles particles;
};

End go_on(const std::string &restart, const std::string &events)
{
  End end;
  const Block block = beam(events);
  try {
    Lammps lmp;
    lmp.commands(block.header() + "read_restart " + restart + "\n" + block.fix_only() +
                 block.motion());
    lmp.run(last - at_restart);
    end.particles = lmp.particles();
  } catch (LAMMPS_NS::LAMMPSException &e) {
    end.message = e.what();
    end.message = end.message.substr(0, end.message.find('\n'));
  }
  close_left_open();
  EXPECT_EQ(end.message, from_first(end.message)) << "other ranks know better";
  MPI_Barrier(MPI_COMM_WORLD);
  return end;
}

void write(const std::string &file, const std::string &text)
{
  if (rank_of(MPI_COMM_WORLD) == 0) write_file(file, text);
  MPI_Barrier(MPI_COMM_WORLD);
}

}    // namespace

TEST(FileFuzz, RestartFiles)
{
  write_files("fuzz", 1.0);
  write_files("fuzzed", 0.99);
  const std::string events = from_first(contents("fuzz.txt"));
  const End good = go_on("fuzz.restart", "fuzz.txt");
  ASSERT_EQ(good.message, "");
  struct Kind {
    std::string file, other, read;
    std::string whole, foreign;
  };
  std::vector<Kind> kinds = {{"fuzz.restart", "fuzzed.restart", "fuzz.restart", "", ""},
                             {"fuzz.set.base", "fuzzed.set.base", "fuzz.set.%", "", ""},
                             {"fuzz.set.0", "fuzzed.set.0", "fuzz.set.%", "", ""}};
  for (auto &k : kinds) {
    k.whole = from_first(contents(k.file));
    k.foreign = from_first(contents(k.other));
  }
  std::mt19937 random(seed());
  for (Budget budget(60); budget.more();) {
    const Kind &kind = kinds[random() % kinds.size()];
    // what comes before the mark, LAMMPS has used when DEFE sees the file
    const size_t mark = kind.whole.find(LAMMPS_NS::RESTART_FORMAT);
    const std::string bad = damaged(
        kind.whole, mark == std::string::npos ? 0 : mark,
        kind.whole.size() - (mark == std::string::npos ? 0 : magic_size), kind.foreign, random);
    write(kind.file, bad);
    const std::string message = go_on(kind.read, "fuzz.txt").message;
    write(kind.file, kind.whole);
    if (bad == kind.whole) {
      EXPECT_EQ(message, "");
      continue;
    }
    EXPECT_THAT(message,
                AnyOf(AllOf(HasSubstr("use an older"), HasSubstr("fuzz.")),
                      HasSubstr("Invalid LAMMPS restart file")))
        << kind.file;
    ASSERT_EQ(from_first(contents("fuzz.txt")), events) << "the event file was touched";
  }
  EXPECT_EQ(difference(good.particles, go_on("fuzz.restart", "fuzz.txt").particles, &Particle::x),
            0.0);
}

TEST(FileFuzz, EventFiles)
{
  write_files("fuzz", 1.0);
  write_files("fuzzed", 0.99);
  const std::string whole = from_first(contents("fuzz.txt"));
  const std::string other = from_first(contents("fuzzed.txt"));
  std::mt19937 random(seed() + 1);
  int continued = 0, refused = 0;
  for (Budget budget(60); budget.more();) {
    const std::string bad = damaged(whole, 0, whole.size(), other, random);
    write("fuzz.txt", bad);
    const std::string message = go_on("fuzz.restart", "fuzz.txt").message;
    const std::string then = from_first(contents("fuzz.txt"));
    if (message.empty()) {    // the damage was behind the restart file
      EXPECT_EQ(then, whole);
      continued++;
    } else {
      EXPECT_THAT(message, AllOf(HasSubstr("put back"), HasSubstr("fuzz.txt")));
      EXPECT_EQ(then, bad) << "it was touched";
      refused++;
    }
    if (HasFailure()) break;
  }
  EXPECT_GT(refused, 20);
  EXPECT_GT(continued, 0);
}
