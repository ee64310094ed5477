#ifndef DEFE_COUPLING_CHECKSUM_H
#define DEFE_COUPLING_CHECKSUM_H

/// \file
/// Checksums of records and files: XXH64, the 64-bit xxHash of Y. Collet (github.com/Cyan4973/xxHash,
/// doc/xxhash_spec.md). It runs at the speed of memory, and a damaged record passes with a
/// probability of 2^-64. It guards against accidents, not against intent.

#include <cstddef>
#include <cstdint>

namespace defe {

class Checksum {
 public:
  explicit Checksum(std::uint64_t seed = 0);

  /// What follows what was added before.
  void add(const void *data, std::size_t bytes);

  /// Of all that was added so far.
  std::uint64_t value() const;

 private:
  std::uint64_t lane[4], seed, total = 0;
  unsigned char rest[32];    // the last bytes, fewer than a stripe
};

std::uint64_t checksum(const void *data, std::size_t bytes, std::uint64_t seed = 0);

}    // namespace defe

#endif
