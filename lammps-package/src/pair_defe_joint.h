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

#include "defe/coupling/cohesive.h"
#include "defe/coupling/contact_law.h"
#include "defe/coupling/corner_strain.h"
#include "defe/coupling/crack_growth.h"
#include "defe/coupling/event_log.h"

#include <array>
#include <memory>
#include <vector>

namespace defe {
struct CrackForces;
}    // namespace defe

namespace LAMMPS_NS {

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

  /** Of all coefficients. */
  uint64_t laws_checksum() const;

  /** Strength of the joints between DEs of this type (pair_coeff ... cohesive). */
  double joint_strength(int type) const
  {
    return coeffs[type * (atom_types + 1) + type].cohesive.sigma_t;
  }
  /** The law of these joints, and whether each is judged by its own traction ("lattice"). */
  const defe::CohesiveParameters &joint_law(int type) const
  {
    return coeffs[type * (atom_types + 1) + type].cohesive;
  }
  bool joint_by_lattice(int type) const { return coeffs[type * (atom_types + 1) + type].lattice; }

 protected:
  bool with_connective = true, with_cohesive = true, with_contact = true;

  struct Coeff {
    double E = 0.0, nu = 0.0;    // connective; 0 = take the material of the part
    defe::CohesiveParameters cohesive{0.0, 0.0, 0.0, false};
    defe::CrackNuclei nuclei;
    bool lattice = false;    // each joint is judged by its own traction, cracks know the mesh
    double restitution = 1.0, friction = 0.0, damping_ratio = 0.0;
    bool has_connective = false, has_cohesive = false, has_contact = false;
  };
  int crack_words(Coeff &, int narg, char **arg, int iarg);
  std::vector<Coeff> coeffs;    // (ntypes+1)^2
  Coeff &coeff_of(int i, int j) { return coeffs[i * (atom_types + 1) + j]; }
  int atom_types = 0;

  struct DefeSystem *sys = nullptr;

  std::vector<defe::CornerModuli> table;    // per part
  std::vector<double> young;                // per part
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

  struct Candidate {
    int i, j;        // i is owned; j too and above i, or a ghost
    double apart;    // of a broken joint: see JointSlot
  };
  std::vector<Candidate> candidates;    // spheres near each other that no joint holds
  bigint candidates_built = -1;
  std::vector<std::pair<tagint, tagint>> broken_now;    // DEs whose joint broke in this step

  // ---- beside other particles and pair styles: pair_defe_others.cpp ----
  enum : char { OURS = 1, OTHERS = 2 };
  std::vector<char> acting;       // (ntypes+1)^2: which styles act between two types
  std::vector<char> meets_des;    // per type: this style acts between it and DEs of some type
  bool others_noted = false;
  bool acts_on(int i, int j) const { return acting[i * (atom_types + 1) + j] & OURS; }
  void map_types();
  void check_coefficients();
  void note_other_spheres();
  double largest_met_by_others(int i) const;

  void allocate();
  void connective_and_ties();
  void criterion();
  void switch_joints();
  void update_screen();
  defe::Vec3 face_normal(int d, int s, const defe::Vec3 &along) const;
  struct TiePoint {
    defe::Vec3 y;         // from the DE to the point on the face
    defe::Vec3 normal;    // of the face, out of the DE
    defe::Vec3 arm[4];    // nodes, from their middle
    defe::Mat3 inertia_inverse;
  };
  TiePoint tie_point(int d, int s) const;
  void cohesive_tie(int d, int s);
  void cohesive_forces();
  defe::Vec3 on_grid(defe::Vec3 value, int i, bool torque);
  void pull_exactly(const int *node, const double *force);
  void contact_forces();
  void update_candidates();
  void add_candidate(int i, int j, double apart = 0.0);
  void forget_touch(int i, int j);
  void contact_with_ball(int i, int j);
  struct SphereTouch *find_touch(int i, int j);
  struct SphereTouch &new_touch(int i, int j);
  void tally(const double *del, const double *force, int i);
  void event(int d, int s, defe::EventKind what, double value);
  void set_broken(int d, int s);
  template <class F> void for_drops(F f);
  double release_of_pending();
  double release_of_step(JointSlot &, const defe::CohesiveResult &);
};

}    // namespace LAMMPS_NS

#endif
#endif
