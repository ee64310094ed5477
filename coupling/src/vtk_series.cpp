#include "defe/coupling/vtk_series.h"

#include <cerrno>
#include <cstdio>
#include <cstring>

namespace defe {

namespace {

  constexpr char magic[8] = "VTK 1";

  std::string without_folder(const std::string &file)
  {
    return file.substr(file.find_last_of('/') + 1);
  }

  std::string quoted(const std::string &text)
  {
    std::string result = "\"";
    for (char c : text) {
      if (c == '"' || c == '\\') result += '\\';
      result += c;
    }
    return result + "\"";
  }

}    // namespace

std::string VtkSeries::file(const std::string &kind, std::int64_t step) const
{
  return base + "_" + kind + "_" + std::to_string(step) + ".hdf";
}

std::string VtkSeries::list_file(const std::string &kind) const
{
  return base + "_" + kind + ".hdf.series";
}

std::string VtkSeries::list(const std::string &kind) const
{
  std::string text = "{\n  \"file-series-version\" : \"1.0\",\n  \"files\" : [";
  const char *between = "\n";
  for (const auto &s : written) {
    char time[40];
    std::snprintf(time, sizeof(time), "%.15g", s.time);
    text += between;
    text += "    { \"name\" : " + quoted(without_folder(file(kind, s.step))) +
        ", \"time\" : " + time + " }";
    between = ",\n";
  }
  return text + "\n  ]\n}\n";
}

/// What the files are: steps of other files cannot be listed.
std::string VtkSeries::key() const
{
  std::string key = base;
  for (const auto &kind : kinds_) key += "\n" + kind;
  return key;
}

std::string VtkSeries::pack() const
{
  const std::string files = key();
  const std::int64_t sizes[2] = {static_cast<std::int64_t>(files.size()),
                                 static_cast<std::int64_t>(written.size())};
  std::string record(magic, sizeof(magic));
  record.append(reinterpret_cast<const char *>(sizes), sizeof(sizes));
  record += files;
  record.append(reinterpret_cast<const char *>(written.data()), written.size() * sizeof(Step));
  return record;
}

bool VtkSeries::unpack(const char *record)
{
  written.clear();
  if (std::memcmp(record, magic, sizeof(magic)) != 0) return false;
  record += sizeof(magic);
  std::int64_t sizes[2];
  std::memcpy(sizes, record, sizeof(sizes));
  record += sizeof(sizes);
  if (key() != std::string(record, sizes[0])) return false;
  written.resize(sizes[1]);
  std::memcpy(written.data(), record + sizes[0], written.size() * sizeof(Step));
  return true;
}

std::string replace_file(const std::string &file, const std::string &text)
{
  const std::string fresh = file + ".tmp";
  FILE *out = std::fopen(fresh.c_str(), "w");
  bool good = out && std::fwrite(text.data(), 1, text.size(), out) == text.size();
  if (out && std::fclose(out)) good = false;
  if (good && std::rename(fresh.c_str(), file.c_str()) == 0) return "";
  return "cannot write " + file + ": " + std::strerror(errno);
}

}    // namespace defe
