/* ----------------------------------------------------------------------
   DEFE: adaptive finite elements to bonded discrete elements for LAMMPS
   https://www.lammps.org/
   This software is distributed under the GNU General Public License.
------------------------------------------------------------------------- */

#ifndef LMP_DEFE_MESH_H
#define LMP_DEFE_MESH_H

#include "defe_component.h"
#include "defe_records.h"

#include "defe/fe/topology.h"

#include <vector>

namespace defe {
class MeshMeasure;
}    // namespace defe

namespace LAMMPS_NS {

struct DefeMeshDraft;

/** The mesh: neighbours, masses and checks of new elements, and what is known of all of them. */
class DefeMesh : protected DefeComponent {
 public:
  /** What restart files keep. */
  struct State {
    double dt_finite, dt_discrete, dt_joints, max_diagonal, max_facet, largest_force;
    double max_step_length;
    bigint hexes_per_node;
    double closed
        [3];    // period of the box along which the mesh is closed with itself, 0 where it is not
  };

  explicit DefeMesh(DefeSystem &);

  /** Append an element anchored at owned atom i (its first node). Topology is made in init(). */
  void add_hex(int i, tagint id, int part, const tagint *nodes);
  void changed() { dirty = true; }
  bigint last_hex_id() const;    // collective

  /** Neighbours, masses and checks of new elements; collective, does nothing and returns false if there are none.
      Pair styles call it in their init(), which comes before ours: they need the DEs' radii. */
  bool build();

  double max_diagonal() const { return now.max_diagonal; }    // of elements and of their faces
  double max_facet() const { return now.max_facet; }
  double max_step_length() const
  {
    return now.max_step_length;
  }                                                             // a quarter of the shortest edge
  double largest_force() const { return now.largest_force; }    // that an element bears at strain 1
  int hexes_per_node() const { return static_cast<int>(now.hexes_per_node); }
  /** Stable time steps, 0 = none; of DEs, and of DEs without ties. */
  double dt_finite() const { return now.dt_finite; }
  double dt_discrete() const { return now.dt_discrete; }
  double dt_joints() const { return now.dt_joints; }
  void *extract(const char *name);

  /** Periods of the box, infinite where it is not periodic: what fe::join_across_border() takes. */
  defe::Vec3 periods() const;
  /** Stops if the box has another period than when a mesh was closed across its border. */
  void check_closed() const;

  /** Largest radius of a DE of this type that a conversion can create. */
  double max_de_radius(int type) const;
  std::vector<double> &de_radii() { return de_radius_max; }

  void pack(State &s) const { s = now; }
  void unpack(const State &);

 private:
  State now{};
  bool dirty = false;
  bigint hexes_added = 0;               // to the mesh by this rank, since its topology was made
  std::vector<double> de_radius_max;    // per type

  void collect(DefeMeshDraft &);
  void make_directory(DefeMeshDraft &);
  void measure(DefeMeshDraft &);
  void add_masses(const DefeMeshDraft &);
  void find_neighbours(const DefeMeshDraft &);
  void find_tied(const DefeMeshDraft &);
  void tell() const;
  void check_splits(const DefeMeshDraft &) const;
  void find_coordinates(const DefeMeshDraft &, int first, int last,
                        std::vector<defe::fe::HexCoords> &) const;
  bool check_element(const HexRecord &, const defe::fe::HexCoords &) const;
  void reduce(const defe::MeshMeasure &);
  void sum_up_parts(const DefeMeshDraft &, const defe::MeshMeasure &);
  double mean_size(const std::vector<HexRecord *> &, int part) const;
};

}    // namespace LAMMPS_NS

#endif
