#ifndef DEFE_COUPLING_VTK_SERIES_H
#define DEFE_COUPLING_VTK_SERIES_H

/// \file
/// The files of a run that ParaView opens as one time series: one file per kind (elements, spheres, ...) and
/// written step, and per kind a list of them with their times (ParaView's file-series-version 1.0).

#include <cstdint>
#include <string>
#include <vector>

namespace defe {

class VtkSeries {
 public:
  struct Step {
    std::int64_t step;
    double time;
  };

  /// \param base  of the names of all files, with its folder
  VtkSeries(const std::string &base, const std::vector<std::string> &kinds) :
      base(base), kinds_(kinds)
  {
  }

  const std::vector<std::string> &kinds() const { return kinds_; }

  /// BASE_elements_100.hdf and BASE_elements.hdf.series: ParaView takes these endings for VTKHDF in all releases
  /// that can read it, .vtkhdf only in newer ones than 5.11.
  std::string file(const std::string &kind, std::int64_t step) const;
  std::string list_file(const std::string &kind) const;

  const std::vector<Step> &steps() const { return written; }
  bool has(std::int64_t step) const { return !written.empty() && written.back().step >= step; }
  void add(std::int64_t step, double time) { written.push_back({step, time}); }

  /// The list of a kind.
  std::string list(const std::string &kind) const;

  // for restart files: a run that goes on with the same files lists what was written before it

  std::string pack() const;
  /// False: it is of other files; the series is empty then.
  bool unpack(const char *record);

 private:
  std::string base;
  std::vector<std::string> kinds_;
  std::vector<Step> written;

  std::string key() const;
};

/// Writes a text in place of a file, which is never seen half written. What is wrong, or "".
std::string replace_file(const std::string &file, const std::string &text);

}    // namespace defe

#endif
