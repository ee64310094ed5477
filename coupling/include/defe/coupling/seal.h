#ifndef DEFE_COUPLING_SEAL_H
#define DEFE_COUPLING_SEAL_H

/// \file
/// A seal at the end of a file that says what all before it must be: of a file that was cut, altered
/// or not finished it does not fit or is not there. It can hold the checksums of other files that
/// belong to this one. The last bytes of a sealed file are those that a reader looks for at its end.

#include <cstdint>
#include <cstdio>
#include <string>
#include <vector>

namespace defe {

enum class SealState { GOOD, MISSING, BROKEN };

/// Appends the seal of the file, which is open for reading and writing, and then `end`. `others` are
/// the checksums of files that belong to it. False: it could not be read or written.
bool append_seal(std::FILE *file, const std::vector<std::uint64_t> &others, const std::string &end);

/// Looks at a whole file: before the last `end_bytes` there is a seal that fits all before. `others`
/// is only set if the seal is good. The place in the file is where it was.
SealState check_seal(std::FILE *file, std::size_t end_bytes, std::vector<std::uint64_t> &others);

/// Checksum of the first bytes of a file, or of all (-1). False: it cannot be read.
bool checksum_of_file(std::FILE *file, std::int64_t bytes, std::uint64_t &sum);

/// A file ends with these bytes; the place in it is its end afterwards.
bool ends_with(std::FILE *file, const std::string &end);

}    // namespace defe

#endif
