/* ----------------------------------------------------------------------
   DEFE: adaptive finite elements to bonded discrete elements for LAMMPS
   https://www.lammps.org/
   This software is distributed under the GNU General Public License.
------------------------------------------------------------------------- */

#ifndef LMP_DEFE_CENSUS_H
#define LMP_DEFE_CENSUS_H

#include "defe_component.h"

namespace LAMMPS_NS {

/** How many elements, nodes and DEs there are on all ranks, and what has left the box. */
class DefeCensus : protected DefeComponent {
 public:
  /** What restart files keep. */
  struct State {
    bigint elements, nodes, des, converted, gone;
    double mass, mass_gone;
  };

  using DefeComponent::DefeComponent;
  bigint elements() const { return now.elements; }
  bigint nodes() const { return now.nodes; }
  bigint des() const { return now.des; }    // those that have gone included
  bigint converted() const { return now.converted; }
  double mass() const { return now.mass; }
  /** Of this rank: DEs that left the box, as the user allowed, and their mass. */
  bigint gone() const { return now.gone; }
  double mass_gone() const { return now.mass_gone; }

  void set_elements(bigint n) { now.elements = n; }
  /** Counted and weighed; collective. */
  void weigh_nodes();
  void convert(bigint elements, bigint nodes_gone, bigint des_born);
  void let_go(double mass);
  /** Atoms may have been deleted: false if there are as many as before; collective. */
  bool recount();
  /** Compares the numbers that are here with those that should be; collective. */
  void check(const char *when) const;

  void pack(State &) const;    // collective
  void unpack(const State &);

 private:
  State now{};
};

}    // namespace LAMMPS_NS

#endif
