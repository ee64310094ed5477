/* ----------------------------------------------------------------------
   DEFE: adaptive finite elements to bonded discrete elements for LAMMPS
   https://www.lammps.org/
   This software is distributed under the GNU General Public License.
------------------------------------------------------------------------- */

#ifndef LMP_DEFE_CHECKS_H
#define LMP_DEFE_CHECKS_H

#include "defe_component.h"

#include <string>
#include <vector>

namespace LAMMPS_NS {

class Fix;
struct DefePart;

/** Checks before a run what other commands have set up, and refuses what would make results wrong. */
class DefeChecks : protected DefeComponent {
 public:
  using DefeComponent::DefeComponent;

  /** Settings and other fixes; before and after the mesh was built. Collective. */
  void before_mesh() const;
  void after_mesh() const;

  void time_step(bool changed);
  bool step_changed() const;
  /** How a minimiser may have caused an element that is lost or inside out. */
  std::string minimizer_hint() const;
  /** Largest radius of the spheres of this type that fixes are going to insert. */
  double radius_to_come(int type) const;
  /** Energy of this rank's contacts with walls; and it is about to change by a conversion. */
  double wall_energy() const;
  void note_energy_in_walls() const;

 private:
  bool warned_of_step = false;
  double checked_dt = -1.0;

  void order_of_fixes() const;
  void bond_fixes(bool converting) const;
  void integrators() const;
  void movers() const;
  void spins() const;
  void rigid_bodies() const;
  void rigid_parts() const;
  void adhesives() const;
  void granular_walls() const;
  void minimizer() const;
  void radii_of_nodes() const;
  bool may_convert(const DefePart &) const;
  struct MovedNode;
  MovedNode first_moved(const std::vector<char> &of_parts, const std::vector<Fix *> &movers,
                        int held) const;
};

}    // namespace LAMMPS_NS

#endif
