// Checksums against the reference values of xxHash, and seals of files: whatever bit is changed,
// whatever is cut off or added, it is seen.

#include "defe/coupling/checksum.h"
#include "defe/coupling/seal.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cstring>
#include <memory>
#include <random>

using defe::check_seal;
using defe::checksum;
using defe::SealState;

namespace {

using File = std::unique_ptr<std::FILE, int (*)(std::FILE *)>;

/// A file that has no name and holds this.
File file_with(const std::string &text)
{
  File f(std::tmpfile(), std::fclose);
  EXPECT_TRUE(f);
  EXPECT_EQ(std::fwrite(text.data(), 1, text.size(), f.get()), text.size());
  std::rewind(f.get());
  return f;
}

std::string contents(std::FILE *f)
{
  std::rewind(f);
  std::string text;
  for (int c; (c = std::fgetc(f)) != EOF;) text += static_cast<char>(c);
  return text;
}

const std::string magic("the end\0", 8);

/// A file of `bytes` with a seal and the end that a reader wants.
std::string sealed(int bytes, const std::vector<std::uint64_t> &others)
{
  std::mt19937 random(5);
  std::string text;
  for (int k = 0; k < bytes; k++) text += static_cast<char>(random());
  const File f = file_with(text);
  EXPECT_TRUE(defe::append_seal(f.get(), others, magic));
  return contents(f.get());
}

SealState state_of(const std::string &text, std::vector<std::uint64_t> *found = nullptr)
{
  std::vector<std::uint64_t> others;
  const File f = file_with(text);
  std::fseek(f.get(), 3, SEEK_SET);
  const SealState state = check_seal(f.get(), magic.size(), others);
  EXPECT_EQ(std::ftell(f.get()), 3) << "the place is where it was";
  if (state != SealState::GOOD) { EXPECT_TRUE(others.empty()); }
  if (found) *found = others;
  return state;
}

}    // namespace

// XXH64 of its specification's implementation: xxhsum -H64, and the sanity check of xxHash, whose
// buffer this generator makes.
TEST(Checksum, ReferenceValues)
{
  EXPECT_EQ(checksum("", 0), 0xEF46DB3751D8E999ull);
  EXPECT_EQ(checksum(nullptr, 0), 0xEF46DB3751D8E999ull);
  EXPECT_EQ(checksum("abc", 3), 0x44BC2CF5AD770999ull);
  const char text[] = "Nobody inspects the spammish repetition";
  EXPECT_EQ(checksum(text, std::strlen(text)), 0xFBCEA83C8A378BF1ull);

  constexpr std::uint64_t prime32 = 2654435761u, prime64 = 11400714785074694797ull;
  std::vector<unsigned char> buffer(222);
  std::uint64_t generator = prime32;
  for (auto &b : buffer) {
    b = static_cast<unsigned char>(generator >> 56);
    generator *= prime64;
  }
  EXPECT_EQ(checksum(buffer.data(), 0, prime32), 0xAC75FDA2929B17EFull);
  EXPECT_EQ(checksum(buffer.data(), 1), 0xE934A84ADB052768ull);
  EXPECT_EQ(checksum(buffer.data(), 1, prime32), 0x5014607643A9B4C3ull);
  EXPECT_EQ(checksum(buffer.data(), 4), 0x9136A0DCA57457EEull);
  EXPECT_EQ(checksum(buffer.data(), 14), 0x8282DCC4994E35C8ull);
  EXPECT_EQ(checksum(buffer.data(), 14, prime32), 0xC3BD6BF63DEB6DF0ull);
  EXPECT_EQ(checksum(buffer.data(), 222), 0xB641AE8CB691C174ull);
  EXPECT_EQ(checksum(buffer.data(), 222, prime32), 0x20CB8AB7AE10C14Aull);
}

TEST(Checksum, InPiecesTheSame)
{
  std::mt19937 random(3);
  std::vector<unsigned char> data(1000);
  for (auto &b : data) b = static_cast<unsigned char>(random());
  for (int k = 0; k < 200; k++) {
    const std::size_t size = random() % data.size();
    defe::Checksum c(k);
    for (std::size_t done = 0; done < size;) {
      const std::size_t n = std::min<std::size_t>(size - done, random() % 70);
      c.add(data.data() + done, n);
      done += n;
    }
    ASSERT_EQ(c.value(), checksum(data.data(), size, k)) << size << " bytes";
  }
}

// Each bit of a record counts, and so does its length.
TEST(Checksum, EveryBit)
{
  std::vector<unsigned char> data(100, 0);
  const auto whole = checksum(data.data(), data.size());
  for (std::size_t bit = 0; bit < 8 * data.size(); bit++) {
    data[bit / 8] ^= 1u << (bit % 8);
    EXPECT_NE(checksum(data.data(), data.size()), whole) << "bit " << bit;
    data[bit / 8] ^= 1u << (bit % 8);
  }
  EXPECT_NE(checksum(data.data(), 99), whole);
}

TEST(Seal, EveryBitAndEveryLength)
{
  for (const std::vector<std::uint64_t> &others :
       {std::vector<std::uint64_t>{}, std::vector<std::uint64_t>{7, 0, 1ull << 63}}) {
    const std::string good = sealed(500, others);
    EXPECT_EQ(good.substr(good.size() - magic.size()), magic);
    std::vector<std::uint64_t> found;
    ASSERT_EQ(state_of(good, &found), SealState::GOOD);
    EXPECT_EQ(found, others);

    for (std::size_t bit = 0; bit < 8 * (good.size() - magic.size()); bit++) {
      std::string bad = good;
      bad[bit / 8] = static_cast<char>(bad[bit / 8] ^ (1 << (bit % 8)));
      EXPECT_NE(state_of(bad), SealState::GOOD) << "bit " << bit;
    }
    for (std::size_t n = 0; n < good.size(); n++)
      EXPECT_NE(state_of(good.substr(0, n)), SealState::GOOD) << n << " bytes";
    EXPECT_NE(state_of(good + "x"), SealState::GOOD);
    EXPECT_NE(state_of("x" + good), SealState::GOOD);
    // cut, with the end that a reader looks for
    EXPECT_EQ(state_of(good.substr(0, 300) + magic), SealState::MISSING);
  }
  EXPECT_EQ(state_of(""), SealState::MISSING);
  EXPECT_EQ(state_of(sealed(0, {})), SealState::GOOD);
}

// More than is read at a time.
TEST(Seal, LargeFile)
{
  std::string text = sealed(1000003, {});
  EXPECT_EQ(state_of(text), SealState::GOOD);
  text[700000] = static_cast<char>(text[700000] ^ 1);
  EXPECT_EQ(state_of(text), SealState::BROKEN);
}

TEST(Seal, FullDiskIsSeen)
{
  const File full(std::fopen("/dev/full", "r+b"), std::fclose);
  if (full) { EXPECT_FALSE(defe::append_seal(full.get(), {}, magic)); }
  const File only_read(std::fopen("/dev/null", "rb"), std::fclose);
  if (only_read) { EXPECT_FALSE(defe::append_seal(only_read.get(), {}, magic)); }
}

TEST(Seal, EndOfAFile)
{
  EXPECT_TRUE(defe::ends_with(file_with("abc the end").get(), "the end"));
  EXPECT_TRUE(defe::ends_with(file_with("the end").get(), "the end"));
  EXPECT_FALSE(defe::ends_with(file_with("the en").get(), "the end"));
  EXPECT_FALSE(defe::ends_with(file_with("").get(), "the end"));
  EXPECT_FALSE(defe::ends_with(file_with("the end.").get(), "the end"));
}
