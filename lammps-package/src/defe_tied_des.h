/* ----------------------------------------------------------------------
   DEFE: adaptive finite elements to bonded discrete elements for LAMMPS
   https://www.lammps.org/
   This software is distributed under the GNU General Public License.
------------------------------------------------------------------------- */

#ifndef LMP_DEFE_TIED_DES_H
#define LMP_DEFE_TIED_DES_H

#include "defe_component.h"
#include "defe_store.h"

#include "defe/coupling/tied_quarters.h"

#include <algorithm>
#include <array>
#include <memory>
#include <utility>
#include <vector>

namespace defe {
class ConversionPlan;
struct NewDE;
}    // namespace defe

namespace LAMMPS_NS {

struct JointTable;

/** What a quarter of a tied face has in common with one face of the other part. Plain data. */
struct DefeTiedPiece {
  tagint
      own;    // element that has the quarter; 0: it has become DEs, and the atom is the one of this quarter
  tagint other;     // element that has, or had, the other face
  tagint end[4];    // nodes of that face, or the DEs behind it, in the order of hex_face
  defe::TiedPiece of;
  double offset[3];    // of a DE: what its joint is longer by in the reference configuration
  int place, slot;     // of the DE in its element, and its face
  int other_face, other_part;

  /** Node, or DE, that weighs most. */
  tagint main_end() const
  {
    return end[std::max_element(of.weight.begin(), of.weight.end()) - of.weight.begin()];
  }
};

/** Tied surfaces of elements that become DEs (tied_quarters.h). What quarters have in common is found once, with the mesh;
    it is kept by the atom that has the element, and by its DEs later on. Where no parts are tied, nothing is kept. */
class DefeTiedDEs : protected DefeComponent, public DefeListField<DefeTiedPiece> {
 public:
  using List = std::vector<DefeTiedPiece>;
  using DefeComponent::DefeComponent;

  bool on() const { return on_; }
  void begin();
  /** Whether elements of two parts stay tied when they convert. */
  bool stay(int part, int other) const;

  // the mesh is new

  void forget_all();
  void keep(int i, const DefeTiedPiece &);
  /** In an order that does not depend on the ranks. */
  void sort();

  // elements convert: to begin with, all is as it was before

  /** A bit for each tied face of an element of atom i. */
  unsigned faces(int i, tagint element) const;
  /** What a DE of it is tied to. Less than half of a quarter is left out: `lost` tells so.
      \param F  deformation gradient there */
  List born(int i, tagint element, const defe::NewDE &, const defe::Mat3 &F, bool &lost) const;
  void set_de(int i, const List &list);
  void remove(int i, tagint element);
  /** Of DEs that were born before: the energy of those of which an end converts is booked. */
  void book(const defe::ConversionPlan &);
  /** Nodes of elements that convert are replaced by their DEs. */
  void replace_ends(const defe::ConversionPlan &);
  void replace_ends(const defe::ConversionPlan &, List &) const;

  // tables

  /** Cell of the DE of atom i: that it is tied, and how; false: it is not. */
  bool shape(int i, defe::GeneralCell &) const;
  void add_places(JointTable &, int d);
  void forget() { holds.clear(); }

  /** Ties bear pressure; what is tied meets the other part only if it has turned over, at half the distance of its
      face. Of a DE of the table of joints; HUGE_VAL: it is not tied to this part. */
  double contact_distance(int d, int part) const;
  /** All that it is tied to. */
  const List *of_de(int i) const { return on_ ? of[i].get() : nullptr; }
  /** Of what this slot of a DE is tied to, what has the largest area. */
  const DefeTiedPiece &main_piece(int i, int slot) const;

  // ---- by atom ----

  int size(int i) const override;
  int pack(int i, double *buf) const override;
  int unpack(int i, const double *buf) override;
  int most() const override;

 private:
  bool on_ = false;
  struct Hold {
    int de, part;
    double distance;
  };
  std::vector<Hold> holds;    // by DE

  int local_end(int i, tagint end) const;
  /** Those with the slot of the first one. */
  static List::const_iterator end_of_slot(List::const_iterator, List::const_iterator end);
  defe::TiedPlace place_of(List::const_iterator first, List::const_iterator end,
                           double depth) const;
};

}    // namespace LAMMPS_NS

#endif
