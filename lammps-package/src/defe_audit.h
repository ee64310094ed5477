/* ----------------------------------------------------------------------
   DEFE: adaptive finite elements to bonded discrete elements for LAMMPS
   https://www.lammps.org/
   This software is distributed under the GNU General Public License.
------------------------------------------------------------------------- */

#ifndef LMP_DEFE_AUDIT_H
#define LMP_DEFE_AUDIT_H

#include "defe_component.h"
#include "defe_records.h"

#include <unordered_map>
#include <vector>

namespace LAMMPS_NS {

/** Is all as it must be? The records of elements and joints against each other. */
class DefeAudit : protected DefeComponent {
 public:
  using DefeComponent::DefeComponent;

  /** Elements, nodes, DEs and joints as the ranks know them; needs no ghosts and no tables. Collective. */
  void records(const char *when) const;
  /** The mass of each node is that of its elements' eighths, and no mass is lost; after the tables were
      made. Collective. */
  void masses() const;
  /** Before a run: were atoms deleted since the last one, and may they be? */
  void account_for_deleted() const;

 private:
  using Known = std::unordered_map<tagint, const HexPod *>;
  struct Element;
  struct Joint;
  struct Tie;
  void elements(const char *when, std::vector<Element> &here, Known &) const;
  void neighbours(const char *when, const Known &) const;
  void nodes(const char *when) const;
  void joints(const char *when, const Known &) const;
  std::vector<Joint> one_side(const char *when, const std::vector<Joint> &came,
                              const Known &) const;
  void both_sides(const char *when, std::vector<Joint>) const;
  void ends_of_ties(const char *when, const std::vector<Tie> &, const Known &) const;
  void ties_of_faces() const;
};

}    // namespace LAMMPS_NS

#endif
