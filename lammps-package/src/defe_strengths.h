/* ----------------------------------------------------------------------
   DEFE: adaptive finite elements to bonded discrete elements for LAMMPS
   https://www.lammps.org/
   This software is distributed under the GNU General Public License.
------------------------------------------------------------------------- */

#ifndef LMP_DEFE_STRENGTHS_H
#define LMP_DEFE_STRENGTHS_H

#include "defe_component.h"
#include "defe_ghosts.h"
#include "defe_store.h"

#include <array>
#include <memory>
#include <string>
#include <utility>
#include <vector>

namespace defe {
class JointCracks;
}

namespace LAMMPS_NS {

struct DefeBatch;
struct HexRecord;

/** Of a DE, or of the elements that an atom has. */
struct DefeDrawnStrengths {
  // by place; of elements with fewer places than others the rest is infinite
  using Places = std::vector<double>;
  double de = 0.0;    // > 0: it is one
  std::vector<std::pair<tagint, Places>> hexes;
};

/** Strengths by flaws (keyword strength; strength_field.h): drawn once per element, with the first tables, and kept by the
    atom that has the element, and by its DEs later on. Where no part has any, nothing is kept and nothing sent. */
class DefeStrengths : protected DefeComponent, public DefeSparseField<DefeDrawnStrengths> {
 public:
  explicit DefeStrengths(DefeSystem &);

  /** Some part has flaws: known when the options are read. */
  bool on() const { return on_; }
  void begin();

  /** The mesh was made or has grown: all elements are drawn anew. */
  void mesh_made();
  /** With new tables of elements, but before those of joints. */
  void elements_listed();
  /** With new tables of joints: their strengths, of ghosts too. */
  void joints_listed();

  /** What an element of a batch must exceed to convert, as its criterion measures; null: the same for all. */
  const double *limits(int batch) const
  {
    return on_ && !batches[batch].limit.empty() ? batches[batch].limit.data() : nullptr;
  }
  double least_limit(int batch) const { return batches[batch].least; }

  /** The least of an element that atom i has; 0: its part has none, or they are not drawn yet. */
  double of_element(int i, const HexRecord &) const;
  /** By its places (ElementSplit), null if there are none. */
  const std::vector<double> *of_places(int i, const HexRecord &) const;
  /** Of a DE; 0: it is none, or has none. */
  double of_de(int i) const;

  // flaws that grow (rate): strengths fall

  bool growing() const { return growing_; }
  /** In a step in which the elements were evaluated, before they are marked. */
  void grow_elements();
  /** In such a step, when DEs know their energies, before cracks are decided on. */
  void grow_des(defe::JointCracks &);

  // an element of atom i becomes DEs

  void set_de(int i, double strength);
  void remove(int i, tagint element);

  double memory_usage() const;

  // ---- by atom ----

  int size(int i) const override;
  int pack(int i, double *buf) const override;
  int unpack(int i, const double *buf) override;
  int most() const override;

 private:
  using Places = DefeDrawnStrengths::Places;
  using Drawn = DefeDrawnStrengths;
  bool on_ = false, growing_ = false, due = true;

  struct Batch {
    std::vector<double> limit;
    double least;
    double by_strength;              // limit of an element over the least of its strengths
    std::vector<Places *> places;    // where flaws grow
  };
  std::vector<Batch> batches;

  struct Found {
    double size = 0.0, least = 1.0e300;    // of flaws, in all elements of this rank
  };
  void draw();
  void draw_batch(int batch, const std::vector<int> &bits, std::vector<Found> &);
  std::vector<int> group_bits(int part) const;
  void tell(int part, const std::vector<Found> &) const;
  void find_limits();
  double share_of_strength(int part) const;
  int hex_size() const;
  Places *find(int i, tagint element) const;
  void check_growth() const;
  void grow_batch(int batch, double dt);
  void grow_element(const DefeBatch &, int e, double dt, Places &) const;

  /** Reference positions of ghosts as their owners have them: never wrapped, so that sizes are the same on all ranks. */
  class References : public DefeMessage {
   public:
    explicit References(DefeSystem &s) : sys(s) {}
    std::vector<std::array<double, 3>> X;
    int pack_forward(int n, const int *list, const double *shift, double *buf) override;
    void unpack_forward(int n, int first, const double *buf) override;

   private:
    DefeSystem &sys;
  } references;

  /** Strengths of DEs, or other numbers. */
  class OfGhosts : public DefeMessage {
   public:
    std::vector<double> value;    // by atom
    int pack_forward(int n, const int *list, const double *shift, double *buf) override;
    void unpack_forward(int n, int first, const double *buf) override;
  } now;
};

}    // namespace LAMMPS_NS

#endif
