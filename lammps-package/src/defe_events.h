/* ----------------------------------------------------------------------
   DEFE: adaptive finite elements to bonded discrete elements for LAMMPS
   https://www.lammps.org/
   This software is distributed under the GNU General Public License.
------------------------------------------------------------------------- */

#ifndef LMP_DEFE_EVENTS_H
#define LMP_DEFE_EVENTS_H

#include "defe_component.h"

#include "defe/coupling/event_log.h"

#include <string>

namespace LAMMPS_NS {

/** The event file of all ranks: coupling/event_log.h knows how it looks. */
class DefeEvents : protected DefeComponent {
 public:
  using DefeComponent::DefeComponent;
  void set_file(const std::string &name) { log.set_file(name); }
  void record(const defe::Event &e) { log.record(e); }
  void name_run();
  /** The first rank writes: if it cannot, all stop. Collective. */
  void flush();

  defe::EventLog::Written written() const { return log.written(); }
  void go_on(const defe::EventLog::Written &w, bigint step) { log.go_on(w, step); }

 private:
  defe::EventLog log;
  void stop_by_first_rank(std::string complaint) const;
};

}    // namespace LAMMPS_NS

#endif
