/* ----------------------------------------------------------------------
   DEFE: adaptive finite elements to bonded discrete elements for LAMMPS
   https://www.lammps.org/
   This software is distributed under the GNU General Public License.
------------------------------------------------------------------------- */

#ifndef LMP_DEFE_PRESTRESS_H
#define LMP_DEFE_PRESTRESS_H

#include "defe_component.h"
#include "defe_store.h"

#include "defe/fe/elastic.h"
#include "defe/types.h"

#include <array>
#include <memory>
#include <utility>
#include <vector>

namespace LAMMPS_NS {

struct DefeBatch;
struct HexRecord;

/** Of an element or a DE. */
struct DefeKeptStress {
  tagint element = 0;    // 0: it is a DE
  defe::Mat3 stress;
  defe::Mat3 map;    // follows from it
  bool mapped = false;
};

/** Stress of bodies before any load (keyword prestress; fe/prestress.h): found once, with the mesh, and kept by the
    atom that has the element, and by its DEs later on. Where no part has any, nothing is kept. */
class DefePrestress : protected DefeComponent, public DefeListField<DefeKeptStress> {
 public:
  using DefeComponent::DefeComponent;

  /** Some part has it: known when the options are read. */
  bool on() const { return on_; }
  void begin();

  /** The mesh was made or has grown: elements that have none yet get theirs; collective. */
  void mesh_made();
  /** Of all elements: the stable step is that much smaller, as a factor; collective. */
  double step_factor() const;

  /** Of an element that atom i has, or of a DE; null: it has none. */
  const defe::Mat3 *of_element(int i, const HexRecord &) const;
  const defe::Mat3 *of_de(int i) const;
  /** From reference positions to the stress-free shape: of an element of the batch, with a kernel that wants its own; and
      of a DE, identity if it has no stress. */
  const defe::Mat3 &map_of_element(int i, const HexRecord &, const DefeBatch &);
  defe::Mat3 map_of_de(int i);

  // an element of atom i becomes DEs

  void set_de(int i, const defe::Mat3 &stress);
  void remove(int i, tagint element);

  // ---- by atom ----

  int size(int i) const override;
  int pack(int i, double *buf) const override;
  int unpack(int i, const double *buf) override;
  int most() const override;

 private:
  using Kept = DefeKeptStress;
  using List = std::vector<Kept>;
  bool on_ = false;

  Kept *find(int i, tagint element) const;

  /** Elements of a part that have no stress yet, each with its first node. */
  using Waiting = std::vector<std::pair<int, const HexRecord *>>;
  Waiting waiting(int part) const;
  std::vector<std::array<double, 6>> evaluate(int part) const;
  void assign(int part, const Waiting &);
  struct Sums;
  void keep(int i, const HexRecord &, const defe::Mat3 &stress, const defe::fe::IsotropicElastic &,
            Sums &);
  void tell(int part, const Sums &) const;
};

}    // namespace LAMMPS_NS

#endif
