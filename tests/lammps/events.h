#ifndef DEFE_TEST_EVENTS_H
#define DEFE_TEST_EVENTS_H

// The event file of fix defe.

#include <array>
#include <fstream>
#include <sstream>
#include <stdexcept>
#include <string>
#include <vector>

namespace defe::test {

struct Event {
  long step;
  double time;
  std::string what;    // convert, cohesive, broken, adhesive, debonded
  long a, b;           // element and part, the two DEs, or DE and element
  double x[3], n[3], value;
};

/// All lines of the file, or those of one kind.
inline std::vector<Event> read_events(const std::string &file, const std::string &what = "")
{
  std::ifstream in(file);
  if (!in) throw std::runtime_error("cannot read " + file);
  std::vector<Event> events;
  std::string line;
  while (std::getline(in, line)) {
    if (line.empty() || line[0] == '#') continue;
    std::istringstream words(line);
    Event e;
    words >> e.step >> e.time >> e.what >> e.a >> e.b >> e.x[0] >> e.x[1] >> e.x[2] >> e.n[0] >>
        e.n[1] >> e.n[2] >> e.value;
    if (!words) throw std::runtime_error(file + ": cannot read line '" + line + "'");
    if (what.empty() || e.what == what) events.push_back(e);
  }
  return events;
}

/// (step, element) of the conversions after step `after`.
inline std::vector<std::array<long, 2>> conversions(const std::string &file, long after = -1)
{
  std::vector<std::array<long, 2>> list;
  for (const auto &e : read_events(file, "convert"))
    if (e.step > after) list.push_back({e.step, e.a});
  return list;
}

}    // namespace defe::test

#endif
