/* -*- c++ -*- ----------------------------------------------------------
   DEFE: adaptive finite elements to bonded discrete elements for LAMMPS
   https://www.lammps.org/
   This software is distributed under the GNU General Public License.
------------------------------------------------------------------------- */

#ifdef PAIR_CLASS
// clang-format off
PairStyle(defe/joint,PairDefeJoint);
// clang-format on
#else

#ifndef LMP_PAIR_DEFE_JOINT_H
#define LMP_PAIR_DEFE_JOINT_H

#include "pair.h"

#include "defe_joint_laws.h"
#include "defe_tally.h"

#include "defe/coupling/event_log.h"
#include "defe/coupling/joint_lattice.h"
#include "defe/coupling/joint_softening.h"

#include <array>
#include <memory>
#include <vector>

namespace defe {
struct CrackForces;
}    // namespace defe

namespace LAMMPS_NS {

class DefeSphereContacts;
struct JointSlot;

/** Bonded spheres with the three joint types. The thin variants switch stages off. */
class PairDefeJoint : public Pair {
 public:
  PairDefeJoint(class LAMMPS *);
  ~PairDefeJoint() override;
  void compute(int, int) override;
  void settings(int, char **) override;
  void coeff(int, char **) override;
  void init_style() override;
  double init_one(int, int) override;
  void write_restart(FILE *) override;
  void read_restart(FILE *) override;
  void write_restart_settings(FILE *) override;
  void read_restart_settings(FILE *) override;
  int pack_forward_comm(int, int *, double *, int, int *) override;
  void unpack_forward_comm(int, int, double *) override;
  double memory_usage() override;

  /** What there is to see of a joint or tie that is not broken, after a force evaluation. */
  struct JointView {
    double t_n, t_s;         // traction: tension positive, and size of its tangential part
    double damage;           // D
    double opening, slip;    // e_n and |e_s| of the cohesive law, 0 before
    double length;           // from the DE to the other one or to the point on the face
    defe::Vec3 point;        // where it crosses the border between the two
    defe::Vec3 normal;       // out of the DE
  };
  /** Of slot s of DE d in DefeSystem::joints; of a cohesive joint, d is the DE of the lower ID. */
  JointView view(int d, int s) const;

  uint64_t laws_checksum() const { return laws.checksum(); }

  /** Strength of the joints between DEs of this type (pair_coeff ... cohesive). */
  double joint_strength(int type) const { return laws.of(type, type).cohesive.sigma_t; }

  /** The law of these joints, and whether each is judged by its own traction ("lattice"). */
  const defe::CohesiveParameters &joint_law(int type) const { return laws.of(type, type).cohesive; }
  bool joint_by_lattice(int type) const { return laws.of(type, type).lattice; }

 protected:
  JointLaws laws;

  struct DefeSystem *sys = nullptr;

  DefeTally tally;    // of this evaluation
  enum { HALF_FORCES, STATES, PARTS, CRACK_TABLE, CRACK_STRESS } comm_mode = HALF_FORCES;

  // ---- joints that cracks cut by their own planes: pair_defe_cracks.cpp ----
  std::unique_ptr<class DefeCracks> cracks;
  bool with_cracks = false, lattice_beside_cracks = false;
  void prepare_cracks();
  void check_laws();
  void update_crack_tables();
  bool by_crack(int d, int s) const;
  void note_joint(int ds);
  void drop_notes();
  void begin_cracks();
  void decide_cracks();
  void share_out_release(int d, unsigned leaving);
  void take_over_cracks();
  void crack_forces(int d, int s);
  void apply_crack(int d, int s, const defe::CrackForces &);
  void close_plane(int d, int s);
  void part_crack(int d, int s);
  void adopt_state(int ds, int state);
  void set_apart(int ds, double distance);
  int pack_state(int d, double *buf) const;
  int unpack_state(int d, const double *buf);

  std::vector<std::array<double, 6>> screen;    // per joint slot, see update_screen()
  std::vector<int> reached;                     // 6 * DE + slot of the joints above it
  std::vector<int> mirrored;    // same, of the joints whose state another rank decides
  bigint screen_built = -1;

  std::unique_ptr<DefeSphereContacts> contacts;

  // ---- beside other particles and pair styles: pair_defe_others.cpp ----
  bool others_noted = false;
  void map_types();
  void check_coefficients();
  void note_other_spheres();
  double largest_met_by_others(int i) const;

  void allocate();
  void connective_and_ties();
  void without_connective();
  void half_forces();
  void gather(int d);
  void book_newborn();
  void criterion();
  bool starts(int d, int s);
  void switch_joints();
  void update_screen();
  defe::Vec3 face_normal(int d, int s, const defe::Vec3 &along) const;
  defe::TiePoint tie_point(int d, int s) const;
  static defe::SofteningJoint softening(JointSlot &);
  void cohesive_forces();
  void cohesive_tie(int d, int s);
  void cohesive_joint(int d, int s);
  void book(const defe::SofteningStep &);
  void contact_forces();
  void event(int d, int s, defe::EventKind what, double value);
  void set_broken(int d, int s);
  template <class F> void for_drops(F f);
  double release_of_pending();
};

}    // namespace LAMMPS_NS

#endif
#endif
