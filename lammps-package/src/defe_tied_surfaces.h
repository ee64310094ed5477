/* ----------------------------------------------------------------------
   DEFE: adaptive finite elements to bonded discrete elements for LAMMPS
   https://www.lammps.org/
   This software is distributed under the GNU General Public License.
------------------------------------------------------------------------- */

#ifndef LMP_DEFE_TIED_SURFACES_H
#define LMP_DEFE_TIED_SURFACES_H

#include "defe_component.h"
#include "defe_store.h"

#include "defe/coupling/tied_surfaces.h"

#include <algorithm>
#include <array>
#include <memory>
#include <utility>
#include <vector>

namespace defe {
class ConversionPlan;
}

namespace LAMMPS_NS {

struct DefeTiedPair;
struct HexRecord;

/** A tie with the IDs of its elements and nodes. Plain data. */
struct DefeKeptTie {
  tagint a, b;
  int stays;    // when its elements convert, their DEs are tied instead (DefeTiedDEs)
  std::array<tagint, defe::Tie::most_nodes> node;
  defe::Tie tie;
};

/** Surfaces that are glued (keyword tied; tied_surfaces.h): the ties are found once, with the mesh, and kept by the
    atom that has the element of the first part. Where none are asked for, nothing is kept. */
class DefeTiedSurfaces : protected DefeComponent, public DefeListField<DefeKeptTie> {
 public:
  explicit DefeTiedSurfaces(DefeSystem &);

  /** Known when the options are read. */
  bool on() const { return on_; }
  void begin();

  // a new mesh: each rank shows its elements, then all find their ties together

  void begin_mesh();
  void show(int i, const HexRecord &, const defe::fe::HexCoords &X);
  /** Returns the stable step of the elements with their ties, HUGE_VAL if there are none; collective. */
  double find();

  void build();    // with the neighbour lists
  void forget();
  /** As if they were elements, see DefeElements. Returns an atom with a force beyond the grid, -1: none. */
  int forces(double *f, const defe::SumGrid &, double *virial) const;
  double energy(double *f) const;

  /** Of each tie that atom i has: a node of the one element, and one of the other. */
  std::vector<std::pair<tagint, tagint>> joined_at(int i) const;

  // elements convert

  /** The ties of those that do end. */
  void end(const defe::ConversionPlan &);
  /** This element is not held, or not all of it. */
  void let_go(tagint element) { let_go_ = std::min(let_go_, element); }
  /** Once, if something was let go; collective. */
  void warn();

  // ---- by atom ----

  int size(int i) const override;
  int pack(int i, double *buf) const override;
  int unpack(int i, const double *buf) override;
  int most() const override;

 private:
  using Kept = DefeKeptTie;
  using List = std::vector<Kept>;
  bool on_ = false, told = false;
  tagint let_go_ = MAXTAGINT;    // of this conversion the least

  defe::TiedSurfaces tables;
  std::vector<std::pair<int, int>> listed;    // of the tables: atom, and number in its list

  /** An element of this rank with free faces, of a part that is tied. */
  struct Shown {
    int atom, part, faces;    // a bit for each free face
    tagint id, node[8];
    defe::fe::HexCoords X;
  };
  struct Guest;
  struct Box;
  struct Answer;
  struct PieceAnswer;
  struct Answers;
  struct Sums;
  std::vector<Shown> shown;

  std::vector<Box> boxes() const;
  std::vector<defe::Vec3> box_vectors() const;
  /** Numbers of the vectors by which a box comes to the other one. */
  static std::vector<int> images_near(const Box &, const Box &other,
                                      const std::vector<defe::Vec3> &vectors);
  std::vector<Guest> guests(const std::vector<Box> &, double size) const;
  template <class Letters> void send_to_cells(Guest &, double size, Letters &) const;
  bool meet_here(const Guest &, const Guest &, double size) const;
  template <class Meet>
  void for_pairs(const std::vector<Guest> &, double size, const Meet &meet) const;
  void meet(const Guest &a, const Guest &b, Answers &, std::vector<Sums> &) const;
  static void add_pieces(const Guest &own, const Guest &other, const defe::TiedElement &,
                         const defe::TiedElement &its, Answers &);
  void tell(const DefeTiedPair &, const Sums &) const;
};

}    // namespace LAMMPS_NS

#endif
