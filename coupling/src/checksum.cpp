#include "defe/coupling/checksum.h"

#include <cstring>

namespace defe {

namespace {

  constexpr std::uint64_t P1 = 0x9E3779B185EBCA87ull, P2 = 0xC2B2AE3D27D4EB4Full,
                          P3 = 0x165667B19E3779F9ull, P4 = 0x85EBCA77C2B2AE63ull,
                          P5 = 0x27D4EB2F165667C5ull;

  constexpr std::size_t STRIPE = 32;

  std::uint64_t rotate(std::uint64_t a, int bits)
  {
    return (a << bits) | (a >> (64 - bits));
  }

  /// Little-endian values, as the method defines them, on any processor.
  template <class T> std::uint64_t load(const unsigned char *p)
  {
#if defined(__BYTE_ORDER__) && __BYTE_ORDER__ == __ORDER_BIG_ENDIAN__
    std::uint64_t a = 0;
    for (std::size_t k = 0; k < sizeof(T); k++) a |= static_cast<std::uint64_t>(p[k]) << (8 * k);
    return a;
#else
    T a;
    std::memcpy(&a, p, sizeof(T));
    return a;
#endif
  }

  std::uint64_t round_of(std::uint64_t lane, std::uint64_t input)
  {
    return rotate(lane + input * P2, 31) * P1;
  }

  void take_stripe(std::uint64_t *lane, const unsigned char *p)
  {
    for (int k = 0; k < 4; k++) lane[k] = round_of(lane[k], load<std::uint64_t>(p + 8 * k));
  }

}    // namespace

Checksum::Checksum(std::uint64_t seed) :
    lane{seed + P1 + P2, seed + P2, seed, seed - P1}, seed(seed)
{
}

void Checksum::add(const void *data, std::size_t bytes)
{
  if (bytes == 0) return;    // data may be null
  const auto *p = static_cast<const unsigned char *>(data);
  const std::size_t held = total % STRIPE;
  total += bytes;
  if (held + bytes < STRIPE) {
    std::memcpy(rest + held, p, bytes);
    return;
  }
  if (held) {
    std::memcpy(rest + held, p, STRIPE - held);
    take_stripe(lane, rest);
    p += STRIPE - held;
    bytes -= STRIPE - held;
  }
  for (; bytes >= STRIPE; bytes -= STRIPE, p += STRIPE) take_stripe(lane, p);
  std::memcpy(rest, p, bytes);
}

std::uint64_t Checksum::value() const
{
  std::uint64_t h;
  if (total >= STRIPE) {
    h = rotate(lane[0], 1) + rotate(lane[1], 7) + rotate(lane[2], 12) + rotate(lane[3], 18);
    for (const auto l : lane) h = (h ^ round_of(0, l)) * P1 + P4;
  } else
    h = seed + P5;
  h += total;

  const unsigned char *p = rest, *const end = rest + total % STRIPE;
  for (; p + 8 <= end; p += 8) h = rotate(h ^ round_of(0, load<std::uint64_t>(p)), 27) * P1 + P4;
  if (p + 4 <= end) {
    h = rotate(h ^ (load<std::uint32_t>(p) * P1), 23) * P2 + P3;
    p += 4;
  }
  for (; p < end; p++) h = rotate(h ^ (*p * P5), 11) * P1;

  h = (h ^ (h >> 33)) * P2;
  h = (h ^ (h >> 29)) * P3;
  return h ^ (h >> 32);
}

std::uint64_t checksum(const void *data, std::size_t bytes, std::uint64_t seed)
{
  Checksum c(seed);
  c.add(data, bytes);
  return c.value();
}

}    // namespace defe
