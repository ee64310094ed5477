/* ----------------------------------------------------------------------
   DEFE: adaptive finite elements to bonded discrete elements for LAMMPS
   https://www.lammps.org/
   This software is distributed under the GNU General Public License.
------------------------------------------------------------------------- */

#ifndef LMP_DEFE_SURFACE_SEARCH_H
#define LMP_DEFE_SURFACE_SEARCH_H

#include "defe_component.h"
#include "defe_ghosts.h"
#include "defe_records.h"
#include "defe_store.h"

#include "defe/coupling/bins.h"
#include "defe/coupling/conversion_plan.h"
#include "defe/coupling/surface_search.h"

#include <array>
#include <deque>
#include <memory>
#include <unordered_map>
#include <vector>

namespace LAMMPS_NS {

/** Lets the search see the mesh and the DEs of this rank and what comes from the ranks around; once per
    reneighbouring. After a conversion in place it sees those elements only beside which there is something, since most of a surface
    meets nothing. */
class DefeSurfaceSearch : protected DefeComponent {
 public:
  explicit DefeSurfaceSearch(DefeSystem &);
  void run(defe::SurfaceTables &);

  std::vector<defe::ConvertingHex>
      gone;    // elements near this rank that converted in this step, by ID
  /** And those of this rank beside them: first node, and ID. */
  std::vector<std::pair<tagint, tagint>> beside;

  // most that goes per atom and round
  static constexpr int HEX_SIZE = doubles_of(sizeof(HexPod));
  static constexpr int MESSAGE_SIZE = 2 + HEX_SIZE;

 private:
  defe::SurfaceSearch search;
  defe::SurfaceScene scene;
  std::deque<std::array<int, 8>> ghost_idx;

  using List = std::vector<std::pair<int, int>>;    // as in DefeElements
  void gather_elements(const List &);
  void send_elements(const List &);
  void send_beside();
  void send_exposed();
  void add_ghost_elements();
  void add_element(const HexPod &, const int *idx);
  void keep_noticed();
  void notice_around_gone();
  void add_nodes(const HexPod &, std::vector<int> &) const;
  void gather_des();
  void gather_parts();
  void check(const defe::SurfaceTables &, bool among_few);

  // elements with exposed faces that nothing was beside in the last search among all
  struct Unnoticed {
    double x[3];
    tagint first, id;    // its first node, and its own
  };
  std::unique_ptr<const defe::CellList<Unnoticed>> unnoticed;
  double far() const;

  class Ties : public defe::SurfaceTies {
   public:
    explicit Ties(DefeSystem &s) : sys(s) {}
    bool born_loose = false;    // ties hold nothing
    bool lasting(int de, int part, std::int64_t element) const override;
    double tied_face(int de, int part) const override;

   private:
    DefeSystem &sys;
  } ties;

  /** Exposed elements by first node: what of this rank's goes to others, and what they have sent. */
  class Exposed : public DefeMessage {
   public:
    explicit Exposed(const Atom *const &a) : atom(a) {}
    /** Of each own atom, and the end: index into `own`. */
    std::vector<int> first;
    std::vector<const HexPod *> own;
    /** Or of a few atoms. */
    std::unordered_map<int, std::vector<const HexPod *>> few;
    /** Of others, by ID of the first node. */
    std::unordered_map<tagint, std::vector<HexPod>> of_others;
    void forget(const defe::ConvertingHex &);
    /** What has come is theirs now. */
    void keep();

    int round = 0;
    int pack_forward(int n, const int *list, const double *shift, double *buf) override;
    void unpack_forward(int n, int first, const double *buf) override;

   private:
    const Atom *const &atom;
    std::unordered_map<int, std::vector<HexPod>> passing;    // by ghost: to go on to other ranks
    const HexPod *of_round(int i) const;
  } exposed;
};

}    // namespace LAMMPS_NS

#endif
