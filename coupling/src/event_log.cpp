#include "defe/coupling/event_log.h"

#include <algorithm>
#include <cerrno>
#include <cinttypes>
#include <cstdio>
#include <cstring>
#include <filesystem>
#include <memory>
#include <system_error>

namespace defe {

namespace {

  constexpr char head_of_file[] = "# DEFE events: run ";
  constexpr char old_head[] = "# step time event ";    // of files without names
  const std::string another = "or give another name to the keyword events";

  using File = std::unique_ptr<FILE, int (*)(FILE *)>;

  std::string hex(std::uint64_t number)
  {
    char text[20];
    std::snprintf(text, sizeof text, "%016" PRIx64, number);
    return text;
  }

  bool begins_with(const char *line, const std::string &start)
  {
    return std::strncmp(line, start.c_str(), start.size()) == 0;
  }

  bool is_there(const std::string &file)
  {
    std::error_code none;
    return std::filesystem::exists(file, none);
  }

  bool is_plain(const std::string &file)
  {
    std::error_code none;
    return std::filesystem::is_regular_file(file, none);
  }

  std::int64_t size_of(const std::string &file)
  {
    std::error_code none;
    return static_cast<std::int64_t>(std::filesystem::file_size(file, none));
  }

}    // namespace

const char *name_of(EventKind kind)
{
  static const char *const names[] = {"convert", "cohesive", "broken", "adhesive", "debonded"};
  return names[static_cast<int>(kind)];
}

bool comes_before(const Event &a, const Event &b)
{
  if (a.step != b.step) return a.step < b.step;
  if (a.what != b.what) return a.what < b.what;
  return a.a != b.a ? a.a < b.a : a.b < b.b;
}

std::string line_of(const Event &e)
{
  char text[400];
  std::snprintf(text, sizeof text,
                "%" PRId64 " %.9g %s %" PRId64 " %" PRId64 " %.9g %.9g %.9g %.4g %.4g %.4g %.6g\n",
                e.step, e.time, name_of(e.what), e.a, e.b, e.x[0], e.x[1], e.x[2], e.n[0], e.n[1],
                e.n[2], e.value);
  return text;
}

void EventLog::name_run(std::uint64_t run, std::uint64_t mesh, std::int64_t elements)
{
  state.run = run | 1;    // 0: it has no name
  state.mesh = mesh;
  state.elements = elements;
}

std::vector<Event> EventLog::take()
{
  std::vector<Event> taken;
  taken.swap(waiting);
  return taken;
}

EventLog::Written EventLog::written() const
{
  Written now = state;
  now.sum = sum.value();
  return now;
}

void EventLog::go_on(const Written &then, std::int64_t step)
{
  state = then;
  sum = Checksum();
  continued = true;
  is_open = false;
  restart_step = step;
}

std::string EventLog::open(bool writes)
{
  std::string complaint;
  if (writes) {
    complaint = refusal();
    if (!complaint.empty()) return complaint;
    complaint = continued && !state.name.empty() && is_plain(file) ? cut() : begin();
  }
  is_open = true;
  continued = false;
  state.name = file;
  return complaint;
}

/// A file that this run does not continue: may it be overwritten?
std::string EventLog::refusal_of_other(bool empty, bool ours) const
{
  if (empty) return "";
  if (!ours) return "file " + file + " is there and is no event file: remove it, " + another;
  if (continued)
    return "event file " + file +
        " is there, but the run of the restart file wrote no events: remove it, " + another;
  return "";
}

std::string EventLog::refusal()
{
  const bool exists = is_there(file);
  if (exists && !is_plain(file)) return "";
  const bool goes_on = continued && !state.name.empty();
  if (!exists)
    return goes_on && state.name == file ? "event file " + file +
            " of the run that the restart file is of is missing: put it back, " + another
                                         : "";
  const File in(std::fopen(file.c_str(), "rb"), std::fclose);
  if (!in) return "";    // opening it for writing says why
  char line[256] = "";
  const bool empty = !std::fgets(line, sizeof(line), in.get());
  const bool ours = begins_with(line, head_of_file) || begins_with(line, old_head);
  if (!goes_on) return refusal_of_other(empty, ours);

  const std::string should = "that of run " + hex(state.run) + " with a mesh of " +
      std::to_string(state.elements) + " elements";
  if (!ours) return "file " + file + " is no event file: put back " + should + ", " + another;
  if (!begins_with(line, head_of_file + hex(state.run)))
    return "event file " + file + " is of another run: put back " + should + ", " + another;
  const std::int64_t size = size_of(file);
  if (size < state.bytes)
    return "event file " + file + " has " + std::to_string(size) + " of the " +
        std::to_string(state.bytes) + " bytes that it had at step " + std::to_string(restart_step) +
        " of the restart file: events are missing; put back the whole file, " + another;
  std::rewind(in.get());
  Checksum found;
  std::vector<char> buffer(1 << 16);
  std::int64_t left = state.bytes;
  while (left > 0) {
    const auto n =
        static_cast<std::size_t>(std::min(left, static_cast<std::int64_t>(buffer.size())));
    if (std::fread(buffer.data(), 1, n, in.get()) != n) break;
    found.add(buffer.data(), n);
    left -= static_cast<std::int64_t>(n);
  }
  if (left || found.value() != state.sum)
    return "event file " + file + " is not as it was at step " + std::to_string(restart_step) +
        " of the restart file (its checksum is wrong): put back the file of that run, " + another;
  sum = found;
  return "";
}

std::string EventLog::cut() const
{
  if (size_of(file) <= state.bytes) return "";
  std::error_code error;
  std::filesystem::resize_file(file, static_cast<std::uintmax_t>(state.bytes), error);
  return error ? "cannot write its event file " + file + ": " + error.message() : "";
}

std::string EventLog::begin()
{
  std::string head = head_of_file + hex(state.run) + ", mesh of " + std::to_string(state.elements) +
      " elements with checksum " + hex(state.mesh) + "\n";
  if (continued && state.lines > 0)
    head += "# from step " + std::to_string(restart_step) + " on; " + std::to_string(state.lines) +
        " events before are in " + state.name + "\n";
  head +=
      "# step time event id id2 X Y Z nx ny nz value\n"
      "# event convert: id = element, id2 = part, X = reference centre, value = mass\n"
      "# event cohesive, broken: id, id2 = the two DEs, X = where the crack passes between them, "
      "n = its normal, both reference, value = equivalent traction, or damage (1)\n"
      "# event adhesive, debonded: the same of a tie, id = DE, id2 = element, X = "
      "reference point on its face\n";
  state.bytes = 0;
  sum = Checksum();
  return write(head, "w");
}

std::string EventLog::write(const std::string &text, const char *mode)
{
  FILE *out = std::fopen(file.c_str(), mode);
  bool good = out && std::fwrite(text.data(), 1, text.size(), out) == text.size();
  if (out && std::fclose(out)) good = false;
  if (!good) return "cannot write its event file " + file + ": " + std::strerror(errno);
  sum.add(text.data(), text.size());
  state.bytes += static_cast<std::int64_t>(text.size());
  return "";
}

std::string EventLog::append(std::vector<Event> &&events)
{
  if (events.empty()) return "";
  std::sort(events.begin(), events.end(), comes_before);
  std::string text;
  for (const auto &e : events) text += line_of(e);
  const std::string complaint = write(text, "a");
  state.lines += static_cast<std::int64_t>(events.size());
  return complaint;
}

}    // namespace defe
