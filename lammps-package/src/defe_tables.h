/* ----------------------------------------------------------------------
   DEFE: adaptive finite elements to bonded discrete elements for LAMMPS
   https://www.lammps.org/
   This software is distributed under the GNU General Public License.
------------------------------------------------------------------------- */

#ifndef LMP_DEFE_TABLES_H
#define LMP_DEFE_TABLES_H

#include "defe_component.h"
#include "defe_ghosts.h"
#include "defe_joint_table.h"

#include <array>
#include <vector>

namespace LAMMPS_NS {

/** Makes the tables of local indices anew with the neighbour lists. */
class DefeTables : protected DefeComponent {
 public:
  explicit DefeTables(DefeSystem &);
  void build();
  bigint built() const { return built_; }    // how often, also within one step
  /** Local indices are invalid until the next reneighbouring. */
  void forget();

  // DEs seen from outside, owned and ghost, 0 for other atoms: distance of their outer face, and its
  // A^2/2V, which times f_s K is a penalty stiffness
  const std::vector<double> &outer_reach() const { return outer.reach; }
  const std::vector<double> &outer_length() const { return outer.length; }
  /** Two DEs at tied surfaces of two parts: the ties bear their pressure (DefeTiedDEs). */
  bool glued(int i, int j) const;
  /** Spheres that are no DEs, owned and ghost, in order; ghosts of DEs among them. */
  const std::vector<int> &others() const { return others_; }

  // what joints were ties from the start of a DE, broken ones too: few, while its record is large and far away

  struct Tied {
    int de;
    int part;    // of the element
    tagint element;
    double distance;    // of the face
  };
  const std::vector<Tied> &tied() const { return tied_; }    // by DE
  int first_tied(int d) const { return first_tied_[d]; }     // up to the number of DEs
  double outer_area(int d) const { return outer_area_[d]; }
  /** Those with DERecord::fresh. */
  const std::vector<int> &fresh() const { return fresh_; }

  /** Strain energy of the corners of DE d with these joints; at the end the force on it by each joint. */
  double de_energy(int d, unsigned present) const;

 private:
  bigint built_ = 0;

  struct Draft {
    int atom;
    std::array<int, 6> nb;
    std::array<double, 6> len, half;
    defe::Mat3 stress_free;    // only if some part has a prestress
  };
  std::vector<Draft> general_drafts;    // kept: new pages would cost more than what is in them
  void update_frames();
  void build_joints();
  void draft_cell(int i, Draft &, defe::GeneralCell &);
  void make_stress_free(Draft &, defe::GeneralCell &);
  void add_de(const Draft &);
  void list_des();
  void fill_slots(int d);
  void add_tie(int d, int s);
  void find_others();
  std::vector<int> others_;
  std::vector<Tied> tied_;
  std::vector<int> first_tied_, fresh_;
  std::vector<double> outer_area_;

  class Outer : public DefeMessage {
   public:
    explicit Outer(DefeSystem &s) : sys(s) {}
    std::vector<double> reach, length;
    std::vector<int> glued;    // 1 + part of DEs that a surface ties; else 0
    void clear();
    void resize(int n);
    void set(int i, double distance, double its_length, int glue);
    static constexpr int SIZE = 6;
    int pack_forward(int n, const int *list, const double *shift, double *buf) override;
    void unpack_forward(int n, int first, const double *buf) override;

   private:
    DefeSystem &sys;
    std::vector<int> known;    // DEs
  } outer;
};

}    // namespace LAMMPS_NS

#endif
