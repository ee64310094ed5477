#ifndef DEFE_COUPLING_EVENT_LOG_H
#define DEFE_COUPLING_EVENT_LOG_H

/// \file
/// The event file: conversions, and joints that change state. Its head names run and mesh, so that a file of
/// another run can be told from one that was cut. A run that goes on from a restart file goes on with the file
/// only if it begins with just what the run had written until then.

#include "defe/coupling/checksum.h"

#include <cstdint>
#include <string>
#include <vector>

namespace defe {

enum class EventKind : int {
  CONVERT,     ///< an element becomes DEs
  COHESIVE,    ///< a joint begins to soften
  BROKEN,      ///< a joint is broken
  ADHESIVE,    ///< a tie begins to soften
  DEBONDED     ///< a tie is broken
};
/// As in the file.
const char *name_of(EventKind);

/// Plain data.
struct Event {
  std::int64_t step;
  double time;
  EventKind what;
  std::int64_t a, b;    ///< IDs: element and part, two DEs, or DE and element
  double x[3];          ///< reference position: element centre, or where the crack passes the joint
  double n[3];          ///< reference normal of the crack, or direction of the joint
  double value;         ///< mass, equivalent traction, or damage
};

/// Order in the file, the same on any number of ranks: by step, kind, IDs.
bool comes_before(const Event &, const Event &);

/// Its line in the file, with the end of the line.
std::string line_of(const Event &);

/// Events of one rank, and the file, which one rank writes. Functions that touch the file return what is wrong,
/// with the remedy, or "".
class EventLog {
 public:
  /// What is in the file; lines, bytes and sum are known to the writing rank.
  struct Written {
    std::string name;                     ///< of the file, empty if there was none
    std::uint64_t run = 0, mesh = 0;      ///< checksums that name them, 0 if they have no names yet
    std::int64_t elements = 0;            ///< of the mesh, at the beginning
    std::int64_t lines = 0, bytes = 0;    ///< lines: events of the run
    std::uint64_t sum = 0;                ///< checksum of these bytes
  };

  /// Without a name nothing is written.
  void set_file(const std::string &name) { file = name; }
  bool on() const { return !file.empty(); }
  const std::string &name() const { return file; }

  void name_run(std::uint64_t run, std::uint64_t mesh, std::int64_t elements);
  bool has_run() const { return state.run != 0; }

  void record(const Event &e)
  {
    if (on()) waiting.push_back(e);
  }
  /// Those since the last call.
  std::vector<Event> take();

  /// Before the first append, on all ranks: the writing one looks at what there is, and cuts it to what it was
  /// at the restart file, since what the interrupted run did after that happens again; or it begins a new file.
  /// Nothing is changed if the file is refused.
  std::string open(bool writes);
  bool opened() const { return is_open; }

  /// Events of all ranks since the last call, in any order; on the writing rank.
  std::string append(std::vector<Event> &&events);

  Written written() const;
  /// Of the restart file that was read, and its step.
  void go_on(const Written &then, std::int64_t step);

 private:
  std::string refusal();
  std::string refusal_of_other(bool empty, bool ours) const;
  std::string begin();
  std::string cut() const;
  std::string write(const std::string &text, const char *mode);

  std::string file;
  std::vector<Event> waiting;
  Written state;
  Checksum sum;
  bool is_open = false;
  bool continued = false;    // a restart file was read
  std::int64_t restart_step = -1;
};

}    // namespace defe

#endif
