/* ----------------------------------------------------------------------
   DEFE: adaptive finite elements to bonded discrete elements for LAMMPS
   https://www.lammps.org/
   This software is distributed under the GNU General Public License.
------------------------------------------------------------------------- */

#ifndef LMP_DEFE_SURFACE_H
#define LMP_DEFE_SURFACE_H

#include "defe_component.h"
#include "defe_records.h"

#include "defe/coupling/conversion_plan.h"
#include "defe/coupling/surface_near.h"

#include <array>
#include <memory>
#include <utility>
#include <vector>

namespace LAMMPS_NS {

class DefeSurfaceSearch;

/** Contact of surfaces: what the search and the forces of coupling work on, and what they found. */
class DefeSurface : protected DefeComponent {
 public:
  explicit DefeSurface(DefeSystem &);
  ~DefeSurface() override;

  void build();     // with the neighbour lists
  void forget();    // local indices are invalid
  /** Whether this is true of all nodes and DEs that may be in contact, owned and ghost. */
  template <class F> bool all_of_points_and_facets(const F &is) const
  {
    for (const auto &point : tables.points)
      if (!is(point.atom)) return false;
    for (const auto &facet : tables.facets)
      for (int node : facet.node)
        if (!is(node)) return false;
    return true;
  }
  /** Onto owned and ghost atoms; adds to the virial if there is one. */
  void forces(double *virial);
  double energy() const { return energy_; }    // at the last force evaluation, this rank

  /** Elements are about to convert: the energy of contacts is booked from the old to the new ones. */
  void begin_conversion();
  /** The elements that convert in this step, by ID: what they shared nodes with they were not in contact with. */
  void elements_gone(const std::vector<defe::ConvertingHex> &);
  /** Of this rank, with a face that one of them has left. */
  void element_beside(const HexRecord &);
  /** Energy of balls on a quarter of an element's face that converts: the DE at that node takes it over, or the only one. */
  struct BallShare {
    tagint element, node, ball;
    double energy, push;
  };
  void ball_shares(const defe::ConversionPlan &, std::vector<BallShare> &) const;

  /** Distance from the centre at which a sphere begins, for spheres that are not bonded to it and
      facets of other parts: of a DE its outer face, of others their radius. Owned and ghost. */
  double reach_of(int i) const;
  /** Stiffness of a ball or a facet of another part against a DE (N/m): f_s K A^2/nV of its outer face (split n),
      which is that of the same area of its element (of eight DEs: four times A, eight times V), so that a contact does
      not change at a conversion. 0 if there is no contact of surfaces. */
  double ball_stiffness(int part, int i) const;

  /** What contacts have met since the last report, each kind reported once; collective. */
  void report();
  bigint let_through() const { return through_total; }

  /** For restart files: of all ranks, on the first one; collective. */
  bigint all_let_through() const;
  void go_on(bigint let_through, bool started);

 private:
  defe::SurfaceTables tables;
  std::unique_ptr<DefeSurfaceSearch> search;
  defe::NearSurface near;
  const defe::ContactPairs &near_pairs(defe::ContactMemory &);
  std::vector<std::array<int, 4>> facet_nodes;    // of its facets, closely packed
  bool planes_fresh = false;                      // they belong to the current positions
  bool to_book = false;      // a conversion waits for the contact energy of its DEs
  std::vector<int> fresh;    // DEs of this step's conversion
  // owned atoms that may have contacts: most points have none, and looking up the record of each costs as much as
  // all the rest
  std::vector<char> met;
  double energy_ = 0.0;

  bigint through_count = 0;    // points that were let through, by this rank
  bigint through_total = 0;
  struct Through {
    bigint step = -1;
    tagint tag = 0;
    double depth = 0.0, x[3] = {0.0, 0.0, 0.0};
  } first_through;
  bool through_told = false, overlaps_told = false, balls_told = false;
  bigint overlaps = 0;    // contacts that began overlapped, before the first step
  double overlap_depth = 0.0;
  tagint overlap_tag = 0;
  bool balls_placed = false;    // their overlaps from now on come from motion
  // of balls that begin in a face, the deepest one also by its radius
  double ball_depth = 0.0, ball_energy = 0.0, ball_share = 0.0;
  tagint ball_tag = 0;

  void end_contacts_but(const std::vector<std::pair<int, int>> &goes_on);
  void pack_facet_nodes();
  void update_planes();
  defe::SurfaceArrays arrays(bool virial) const;
  void book(const defe::SurfaceResult &);
  void note_overlaps(const defe::SurfaceResult &, bool moving);
  void note_let_through(int i, double depth);
  void report_let_through();
  void report_overlaps(bigint count);
  void report_balls();
};

}    // namespace LAMMPS_NS

#endif
