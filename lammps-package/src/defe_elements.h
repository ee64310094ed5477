/* ----------------------------------------------------------------------
   DEFE: adaptive finite elements to bonded discrete elements for LAMMPS
   https://www.lammps.org/
   This software is distributed under the GNU General Public License.
------------------------------------------------------------------------- */

#ifndef LMP_DEFE_ELEMENTS_H
#define LMP_DEFE_ELEMENTS_H

#include "defe_component.h"
#include "defe_ghosts.h"
#include "defe_records.h"

#include "defe/fe/element_batch.h"

#include <algorithm>
#include <array>
#include <climits>
#include <cstdint>
#include <memory>
#include <string>
#include <utility>
#include <vector>

namespace LAMMPS_NS {

struct DefePart;

/** Elements of this rank that share a kernel, with their records. */
struct DefeBatch : defe::fe::ElementBatch {
  DefeBatch(const DefePart &, int part, const defe::fe::MaterialLaw &,
            const defe::fe::KernelChoice &);
  std::vector<HexRecord *> hex;
  // as in ElementBatch
  void add(HexRecord &h, const std::array<int, 8> &idx, double *history,
           const defe::fe::HexCoords *stress_free)
  {
    ElementBatch::add(idx, history, stress_free);
    hex.push_back(&h);
    cover(size() - 1);
  }
  void remove(int e)
  {
    ElementBatch::remove(e);
    hex[e] = hex.back();
    hex.pop_back();
    if (e < size()) cover(e);
    blocks.resize((size() + BLOCK - 1) / BLOCK);
    chunks.resize(blocks.size());
    groups.resize((blocks.size() + GROUP - 1) / GROUP);
  }
  void renumber(int e, const std::array<int, 8> &idx)
  {
    ElementBatch::renumber(e, idx);
    cover(e);
  }
  void clear()
  {
    ElementBatch::clear();
    hex.clear();
    blocks.clear();
    chunks.clear();
    groups.clear();
  }
  /** All elements with a node at one of these places, in order, or from `limit` on, are among those that f gets, in order:
      blocks of elements that have none there are left out, and groups of such blocks. */
  template <class F> void for_blocks(const std::vector<int> &places, int limit, const F &f) const
  {
    Chunks at;
    for (int i : places) at.add(i);
    for (size_t g = 0; g < groups.size(); g++) {
      if (!may_have(groups[g], places, limit)) continue;
      const size_t last = MIN(blocks.size(), (g + 1) * GROUP);
      for (size_t k = g * GROUP; k < last; k++) {
        if (!may_have(blocks[k], places, limit)) continue;
        if (blocks[k].last < limit && !chunks_of(k).meet(at)) continue;
        const int end = MIN(size(), static_cast<int>(k + 1) * BLOCK);
        for (int e = static_cast<int>(k) * BLOCK; e < end; e++) f(e);
      }
    }
  }

  bool convertible;
  defe::fe::StressBound bound_weights;    // of the criterion, if convertible

 private:
  static constexpr int BLOCK = 64;    // elements
  static constexpr int GROUP = 32;    // blocks
  struct Range {
    int first, last;
  };
  std::vector<Range> blocks, groups;    // of local indices of nodes, at least
  /** Of local indices, of which 32 in a row are one: a range is as wide as a layer of the mesh. */
  struct Chunks {
    std::array<std::uint64_t, 16> bits{};    // one for every 1024th
    bool known = false;
    void add(int i)
    {
      const int bit = i >> 5 & 1023;
      bits[bit >> 6] |= std::uint64_t(1) << (bit & 63);
    }
    bool meet(const Chunks &other) const
    {
      std::uint64_t both = 0;
      for (size_t k = 0; k < bits.size(); k++) both |= bits[k] & other.bits[k];
      return both != 0;
    }
  };
  mutable std::vector<Chunks> chunks;    // of blocks, at least; of those that have been asked for
  const Chunks &chunks_of(size_t block) const;
  void cover(int e);    // element e is new at its place
  static void cover(std::vector<Range> &, size_t which, const Range &);
  bool may_have(const Range &, const std::vector<int> &places, int limit) const;
};

/** The finite elements of this rank, in tables of local indices, and their forces. */
class DefeElements : protected DefeComponent {
 public:
  explicit DefeElements(DefeSystem &);

  const std::vector<DefeBatch> &batches() const { return all; }
  /** Batch and number of elements with free faces, or with DEs behind a face. */
  const std::vector<std::pair<int, int>> &exposed() const { return exposed_; }
  /** The same of those with DEs behind a face. */
  const std::vector<std::pair<int, int>> &fronts() const { return fronts_; }
  /** Of the exposed ones those beside which there is anything that they may touch before the next reneighbouring. */
  const std::vector<std::pair<int, int>> &noticed() const { return noticed_; }
  void notice_only(const std::vector<char> &of_exposed);
  /** All that are exposed and have one of these nodes, too. */
  void notice_at(const std::vector<int> &nodes);
  /** The same of those that are to convert (HexPod::marked). */
  const std::vector<std::pair<int, int>> &marked() const { return marked_; }
  void mark(int batch, int e);
  void unmark_all();
  int history_most() const;    // doubles of material history that an element has
  void look_at_histories();

  /** f(number of the batch, element) for all that have one of these nodes, local indices. */
  template <class F> void for_elements_at(std::vector<int> places, const F &f)
  {
    std::sort(places.begin(), places.end());
    if (!places.empty() && places.back() >= static_cast<int>(meant.size()))
      meant.resize(places.back() + 1, 0);
    for (int i : places) meant[i] = 1;
    for (size_t k = 0; k < all.size(); k++)
      all[k].for_blocks(places, INT_MAX, [&](int e) {
        const auto &idx = all[k].nodes(e);
        if (std::any_of(idx.begin(), idx.end(), [this](int i) {
              return i < static_cast<int>(meant.size()) && meant[i];
            }))
          f(static_cast<int>(k), e);
      });
    for (int i : places) meant[i] = 0;
  }

  void build();    // with the neighbour lists
  /** Of the tables that there are only those of some atoms need to be made anew. */
  bool repairable() const;
  void check() const;       // that a table made anew would be the same, but for its order
  void forget_kernels();    // elements look theirs up again

  bool local_hex(const HexRecord &, int anchor, int *idx) const;
  /** Current and reference coordinates of the nodes of an element, from local indices. */
  void coords(const int *idx, defe::fe::HexCoords &x, defe::fe::HexCoords &X) const;
  /** The same as its kernel wants them: of a body with a prestress the stress-free shape. */
  void kernel_coords(const HexRecord &, const int *idx, defe::fe::HexCoords &x,
                     defe::fe::HexCoords &X) const;
  /** Of one owned element, for output. */
  void centre_stress(const HexRecord &, double *centre, double *stress6, double &s1) const;
  defe::fe::PlasticState plastic_state(const HexRecord &) const;
  double longest() const;

  /** Of this step, onto the atoms, with two clocks; adds to the virial if there is one. */
  void forces(double *virial);
  double energy();    // of all elements of this rank at the current positions
  double largest_stress() const;
  /** Forces of the elements on owned nodes, as energy() has left them, with those from other ranks. */
  const double *finite_forces();

  double memory_usage() const;

 private:
  std::vector<DefeBatch> all;
  std::vector<std::pair<int, int>> exposed_, fronts_, noticed_, marked_;
  std::vector<double> scratch;
  std::vector<char> meant;    // nodes in for_elements_at(); else 0
  int history_read = 0;
  int listed = -1;    // local atoms when the tables were made; -1: they are not to be used

  void clear();
  void list_all();
  void repair();
  void drop(const std::vector<int> &anchors, int limit);
  const HexRecord *list_of(int i);
  int batch_of(int part, const defe::fe::HexCoords &X, const defe::Mat3 *prestress);
  void add(HexRecord &, const std::array<int, 8> &idx);
  void stop_lost(const HexRecord &) const;
  void evaluate(double *f, double history_step, double *virial);
  void stop_inverted(const DefeBatch &, int e) const;

  class FiniteMessage : public DefeMessage {
   public:
    explicit FiniteMessage(std::vector<double> &f) : force(f) {}
    int pack_reverse(int n, int first, double *buf) override;
    void unpack_reverse(int n, const int *list, const double *buf) override;

   private:
    std::vector<double> &force;
  } finite;
};

}    // namespace LAMMPS_NS

#endif
