// Runs a fuzz target without libFuzzer: over files, and over mutations of them.
//
//   fuzz_NAME_replay [--mutate N] [--seed S] [--dictionary FILE] FILE-OR-FOLDER...
//
// The mutations are the same on every machine and in every run.

#include "fuzz_lammps.h"

#include <algorithm>
#include <cctype>
#include <csignal>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <random>
#include <sstream>

#include <unistd.h>

namespace {

constexpr unsigned LONGEST = 20;    // seconds that one input may take
constexpr std::size_t SIZE = 2048;
char current[SIZE + 1];
std::size_t current_size = 0;

/// Only what a signal handler may call.
void say_input(int signal)
{
  const char head[] = "\nthis input crashes or hangs:\n";
  bool ok = write(2, head, sizeof head - 1) > 0;
  ok = write(2, current, current_size) > 0 && ok;
  ok = write(2, "\n", 1) > 0 && ok;
  _exit(ok ? 128 + signal : 127);
}

void run(const std::string &input)
{
  current_size = std::min(input.size(), SIZE);
  std::memcpy(current, input.data(), current_size);
  alarm(LONGEST);
  LLVMFuzzerTestOneInput(reinterpret_cast<const std::uint8_t *>(input.data()), input.size());
  alarm(0);
}

std::string contents(const std::filesystem::path &file)
{
  std::ifstream in(file, std::ios::binary);
  return {std::istreambuf_iterator<char>(in), std::istreambuf_iterator<char>()};
}

/// Entries of libFuzzer's dictionaries: "word" in quotes, one per line.
std::vector<std::string> dictionary(const std::string &file)
{
  std::vector<std::string> words;
  std::istringstream in(contents(file));
  for (std::string line; std::getline(in, line);) {
    const auto first = line.find('"'), last = line.rfind('"');
    if (line.empty() || line[0] == '#' || first == last) continue;
    words.push_back(line.substr(first + 1, last - first - 1));
  }
  return words;
}

class Mutator {
 public:
  Mutator(std::vector<std::string> seeds, std::vector<std::string> words, unsigned seed) :
      seeds(std::move(seeds)), words(std::move(words)), random(seed)
  {
  }

  std::string next()
  {
    std::string s = seeds[below(seeds.size())];
    for (std::size_t k = 1 + below(3); k > 0; k--) s = changed(s);
    return s.substr(0, SIZE);
  }

 private:
  // std::uniform_int_distribution differs from library to library
  std::size_t below(std::size_t n) { return n ? random() % n : 0; }

  /// A token, of which a space or the end of a line may be the neighbour: [first, last)
  std::pair<std::size_t, std::size_t> token(const std::string &s)
  {
    std::size_t first = below(s.size());
    while (first > 0 && !std::isspace(static_cast<unsigned char>(s[first - 1]))) first--;
    std::size_t last = first;
    while (last < s.size() && !std::isspace(static_cast<unsigned char>(s[last]))) last++;
    return {first, last};
  }

  std::string changed(std::string s)
  {
    static const std::vector<std::string> numbers = {
        "0",           "1",   "-1",   "2",    "3",    "1e-300",  "1e300",      "1e400",
        "nan",         "inf", "-inf", "0.49", "0.5",  "-0.9999", "2147483647", "-2147483648",
        "1.",          ".",   "1e",   "",     "*",    "1*3",     "0x10",       "4294967297",
        "99999999999", "&",   "#",    "-0",   "1e-9", "1e9",     "1e308",      "5e-324"};
    if (s.empty()) return "fix";
    const auto t = token(s);
    const std::size_t length = t.second - t.first;
    switch (below(9)) {
      case 0:
        return s.replace(t.first, length, numbers[below(numbers.size())]);
      case 1:
        return s.replace(t.first, length, words.empty() ? "x" : words[below(words.size())]);
      case 2:    // a token less
        return s.erase(t.first, length);
      case 3:    // a token twice
        return s.insert(t.first, s.substr(t.first, length) + " ");
      case 4:    // two tokens change places
      {
        const auto u = token(s);
        if (u.first < t.second) return s;
        const std::string a = s.substr(t.first, length), b = s.substr(u.first, u.second - u.first);
        s.replace(u.first, b.size(), a);
        return s.replace(t.first, length, b);
      }
      case 5:    // cut
        return s.substr(0, below(s.size()));
      case 6:    // one byte
        s[below(s.size())] = static_cast<char>(below(256));
        return s;
      case 7:    // a line twice, or one from elsewhere
      {
        const auto &other = seeds[below(seeds.size())];
        const auto from = other.find('\n', below(other.size() + 1));
        if (from == std::string::npos) return s + "\n" + s;
        const auto to = other.find('\n', from + 1);
        return s + other.substr(from, to == std::string::npos ? to : to - from);
      }
      default: {
        auto at = s.find_first_of("0123456789", below(s.size()));
        if (at == std::string::npos) return s;
        s[at] = static_cast<char>('0' + below(10));
        return s;
      }
    }
  }

  std::vector<std::string> seeds, words;
  std::mt19937 random;
};

}    // namespace

int main(int argc, char **argv)
{
  LLVMFuzzerInitialize(&argc, &argv);
  for (int signal : {SIGALRM, SIGSEGV, SIGBUS, SIGFPE, SIGABRT}) std::signal(signal, say_input);

  long mutations = 0;
  unsigned seed = 1;
  std::vector<std::string> words;
  std::vector<std::filesystem::path> files;
  for (int k = 1; k < argc; k++) {
    const std::string a = argv[k];
    const bool more = k + 1 < argc;
    if (a == "--mutate" && more)
      mutations = std::atol(argv[++k]);
    else if (a == "--seed" && more)
      seed = static_cast<unsigned>(std::atol(argv[++k]));
    else if (a == "--dictionary" && more)
      words = dictionary(argv[++k]);
    else if (std::filesystem::is_directory(a))
      for (const auto &entry : std::filesystem::directory_iterator(a))
        files.push_back(entry.path());
    else
      files.emplace_back(a);
  }
  std::sort(files.begin(), files.end());
  std::vector<std::string> seeds;
  for (const auto &file : files) {
    seeds.push_back(contents(file));
    if (std::getenv("DEFE_FUZZ_VERBOSE")) std::fprintf(stderr, "%s: ", file.c_str());
    run(seeds.back());
  }
  if (seeds.empty()) {
    std::fprintf(stderr, "no input\n");
    return 2;
  }
  Mutator mutator(seeds, words, seed);
  for (long k = 0; k < mutations; k++) run(mutator.next());
  std::printf("%zu inputs and %ld mutations: no crash, no hang\n", seeds.size(), mutations);
  return 0;
}
