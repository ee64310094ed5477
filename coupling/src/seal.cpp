#include "defe/coupling/seal.h"

#include "defe/coupling/checksum.h"

#include <algorithm>
#include <cstddef>
#include <cstring>

namespace defe {

namespace {

  constexpr char MARK[8] = {'D', 'E', 'F', 'E', 's', 'e', 'a', 'l'};

  struct Seal {
    char mark[8];
    std::uint64_t length;     // bytes before the seal, with the checksums of other files
    std::uint64_t content;    // their checksum
    std::uint64_t others;     // number of checksums of other files
    std::uint64_t own;        // checksum of this seal up to here
  };
  static_assert(sizeof(Seal) == 40, "no gaps: it is written as it is");

  std::uint64_t own_of(const Seal &s)
  {
    return checksum(&s, offsetof(Seal, own));
  }

  std::int64_t length_of(std::FILE *file)
  {
    return std::fseek(file, 0, SEEK_END) ? -1 : static_cast<std::int64_t>(std::ftell(file));
  }

  bool read_at(std::FILE *file, std::int64_t place, void *data, std::size_t bytes)
  {
    return place >= 0 && std::fseek(file, static_cast<long>(place), SEEK_SET) == 0 &&
        (bytes == 0 || std::fread(data, 1, bytes, file) == bytes);
  }

  SealState check(std::FILE *file, std::size_t end_bytes, std::vector<std::uint64_t> &others)
  {
    Seal s;
    const std::int64_t length =
        length_of(file) - static_cast<std::int64_t>(end_bytes + sizeof(Seal));
    if (!read_at(file, length, &s, sizeof(Seal)) || std::memcmp(s.mark, MARK, sizeof(MARK)) != 0)
      return SealState::MISSING;
    // only then are its sizes trusted, and memory allocated for them
    if (s.own != own_of(s) || s.length != static_cast<std::uint64_t>(length) ||
        s.others > s.length / sizeof(std::uint64_t))
      return SealState::BROKEN;
    std::uint64_t sum;
    if (!checksum_of_file(file, length, sum) || sum != s.content) return SealState::BROKEN;
    std::vector<std::uint64_t> list(s.others);
    const auto bytes = sizeof(std::uint64_t) * list.size();
    if (!read_at(file, length - static_cast<std::int64_t>(bytes), list.data(), bytes))
      return SealState::BROKEN;
    others = std::move(list);
    return SealState::GOOD;
  }

}    // namespace

bool checksum_of_file(std::FILE *file, std::int64_t bytes, std::uint64_t &sum)
{
  if (bytes < 0) bytes = length_of(file);
  if (bytes < 0 || std::fseek(file, 0, SEEK_SET)) return false;
  std::vector<char> block(1 << 18);
  Checksum c;
  while (bytes > 0) {
    const auto want = static_cast<std::size_t>(
        std::min<std::int64_t>(bytes, static_cast<std::int64_t>(block.size())));
    if (std::fread(block.data(), 1, want, file) != want) return false;
    c.add(block.data(), want);
    bytes -= static_cast<std::int64_t>(want);
  }
  sum = c.value();
  return true;
}

bool ends_with(std::FILE *file, const std::string &end)
{
  std::string last(end.size(), '\0');
  const bool same = read_at(file, length_of(file) - static_cast<std::int64_t>(end.size()), &last[0],
                            end.size()) &&
      last == end;
  return length_of(file) >= 0 && same;
}

bool append_seal(std::FILE *file, const std::vector<std::uint64_t> &others, const std::string &end)
{
  const auto bytes = sizeof(std::uint64_t) * others.size();
  const std::int64_t length = length_of(file);
  if (length < 0) return false;
  if (bytes && std::fwrite(others.data(), 1, bytes, file) != bytes) return false;
  Seal s;
  std::memcpy(s.mark, MARK, sizeof(MARK));
  s.length = static_cast<std::uint64_t>(length) + bytes;
  s.others = others.size();
  if (std::fflush(file) || !checksum_of_file(file, static_cast<std::int64_t>(s.length), s.content))
    return false;
  s.own = own_of(s);
  return length_of(file) >= 0 && std::fwrite(&s, sizeof(Seal), 1, file) == 1 &&
      std::fwrite(end.data(), 1, end.size(), file) == end.size() && std::fflush(file) == 0;
}

SealState check_seal(std::FILE *file, std::size_t end_bytes, std::vector<std::uint64_t> &others)
{
  const long place = std::ftell(file);
  const SealState state = check(file, end_bytes, others);
  return std::fseek(file, place, SEEK_SET) ? SealState::BROKEN : state;
}

}    // namespace defe
