/* ----------------------------------------------------------------------
   DEFE: adaptive finite elements to bonded discrete elements for LAMMPS
   https://www.lammps.org/
   This software is distributed under the GNU General Public License.
------------------------------------------------------------------------- */

#ifndef LMP_DEFE_CONVERSION_H
#define LMP_DEFE_CONVERSION_H

#include "defe_component.h"
#include "defe_ghosts.h"
#include "defe_records.h"

#include "defe/coupling/conversion.h"
#include "defe/coupling/conversion_plan.h"

#include <array>
#include <unordered_map>
#include <vector>

namespace LAMMPS_NS {

/** Carries out a ConversionPlan, in the step after the criterion was met: in place (defe_in_place.h), or else in pre_exchange,
    and LAMMPS then migrates the new atoms and rebuilds its lists. */
class DefeConversion : protected DefeComponent {
 public:
  explicit DefeConversion(DefeSystem &);

  /** All marked elements of all ranks; in pre_exchange. */
  void convert();
  /** The same before LAMMPS decides whether to reneighbour, if no reneighbouring is needed for it: else false. */
  bool convert_in_place();
  /** What is discrete from the start, before the first setup. */
  void convert_start();
  bool start_done() const { return start_done_; }
  void go_on(bool start_done) { start_done_ = start_done; }

  // most that goes per atom and round
  static constexpr int MARKED_SIZE = 2 + 2 + 8 + 24;

 private:
  bool start_done_ = false;

  void convert_marked();
  struct Own;
  struct Draft;
  void mark_start();
  bool any_start() const;
  void tell_neighbours(std::vector<defe::ConvertingHex> &&);
  void collect_marked(Draft &);
  void ties_to_joints(const defe::ConversionPlan &);
  void update_beside(const defe::ConversionPlan &);
  void add_shields(const defe::ConversionPlan &, HexRecord &, const std::array<int, 8> &idx);
  void record_conversion(const Own &);
  void add_births(Draft &, const Own &);
  static void fill_record(DERecord &, const defe::NewDE &, const defe::PlannedDE &);
  void break_joint_to_older(tagint tag, DERecord &, int slot, const defe::PlannedDE &,
                            const defe::NewDE &, const std::array<int, 8> &idx,
                            const defe::fe::HexCoords &element);
  double contact_distance_if_separated(int i, const tagint *face, int place, int side,
                                       const defe::fe::HexCoords &element, int part) const;
  bigint remove_converted(const Draft &);
  void take_losses();
  bigint delete_nodes();
  void create_des(Draft &);
  void take_ball_shares(int i, const Draft &, tagint element, tagint node, bool of_all_nodes);
  void finish(bigint converted, bigint nodes_gone, bigint born);
  void leave_to_reneighbouring(int born);

  /** Elements that convert, with their nodes. */
  class Marked : public DefeMessage {
   public:
    explicit Marked(DefeSystem &s) : sys(s) {}
    std::vector<defe::ConvertingHex>
        converting;    // at least those with a node on this rank, by ID
    // by atom: index into converting, and corner
    std::unordered_map<int, std::vector<std::pair<int, int>>> at;
    int round = 0;
    int pack_forward(int n, const int *list, const double *shift, double *buf) override;
    void unpack_forward(int n, int first, const double *buf) override;

   private:
    DefeSystem &sys;
  } marked;

  /** Mass and elements that nodes lose. */
  class Loss : public DefeMessage {
   public:
    std::vector<double> mass;
    std::vector<int> count;
    std::vector<int> nodes;    // that lose something, each once; all others have zeros
    void begin(int n);
    void add(int i, double m, int n);
    int pack_reverse(int n, int first, double *buf) override;
    void unpack_reverse(int n, const int *list, const double *buf) override;
  } loss;
};

}    // namespace LAMMPS_NS

#endif
