#ifndef DEFE_COUPLING_JOINT_STATES_H
#define DEFE_COUPLING_JOINT_STATES_H

/// \file
/// Joints and ties of a rank from their birth to their end: connective, pending, cohesive, broken.
///
/// A joint between two DEs is known to both. The corners of a DE are computed by the rank that owns it; the two halves of a
/// joint's force meet after one message, so that both sides add up the same numbers. Changes of state are decided by the
/// rank that owns the DE of the lower ID, and sent to the other.
///
/// A joint that reaches its strength is pending: it becomes cohesive in the next step, before its forces, so that a
/// restart finds forces that belong to the states.
///
/// An evaluation of forces, with the messages between its parts:
///
///     begin(particles, dt, moving)
///     with new tables: new_tables(); with cracks, before it, cracks()->prepare(), a message, cracks()->resolve()
///     switch_pending()
///     half_forces(); message HALF_FORCES; gather(sums)
///     soften(sums); find_pending();
///     with cracks and moving, when finite elements act: cracks()->mark(), a message, decide_cracks()
///     message STATES; adopt_states()
///
/// What comes of it for others is in events(), broken() and damaged().

#include "defe/coupling/event_log.h"
#include "defe/coupling/force_sums.h"
#include "defe/coupling/joint_cracks.h"
#include "defe/coupling/joint_lattice.h"
#include "defe/coupling/joint_laws.h"
#include "defe/coupling/joint_softening.h"
#include "defe/coupling/joint_table.h"
#include "defe/coupling/ledger.h"

#include <array>
#include <memory>
#include <vector>

namespace defe {

/// A joint or tie changes its state.
struct JointEvent {
  int joint;
  EventKind what;
  double value;
  bool has_plane;    ///< a crack cuts it by a plane of its own: m and f as in CrackJoint
  double m[3], f;
};

/// Two DEs that no joint holds any more.
struct LooseDEs {
  int i, j;           ///< particles; j < 0: a tie is broken
  double distance;    ///< see SoftJoint::contact_distance
};

/// What there is to see of a joint, a tie or a joint to a tied place that is not broken, after an evaluation of forces.
struct JointView {
  double t_n, t_s;         ///< traction: tension positive, and size of its tangential part
  double damage;           ///< D
  double opening, slip;    ///< e_n and |e_s| of the cohesive law, 0 before
  double length;    ///< from the DE to the other one, to the point on the face or to the tied place
  Vec3 point;       ///< where it crosses the border between the two
  Vec3 normal;      ///< out of the DE
};

class JointStates {
 public:
  /// Keeps references to all of them, and takes from the laws now which joints cracks cut: make a new one if laws change.
  JointStates(JointTable &, const JointLaws &, EnergyLedger &, StoredEnergy &, CrackHost &);

  /// Null: no joints are cut by cracks.
  JointCracks *cracks() { return cracks_.get(); }

  /// The same as before with arrays that may lie elsewhere.
  void set_particles(const MovingParticles &p) { particles = p; }
  /// \param dt      0 before a run
  /// \param moving  false: an evaluation before a run
  void begin(const MovingParticles &, double dt, bool moving);
  void new_tables();
  /// Joints that have begun to soften, or are closed planes, by another law than the present one (with a plane or without).
  struct OtherLaw {
    int count = 0;
    int first = -1;    ///< (lower type * (types+1) + higher type) * 2 + (it has a plane); the least
  };
  OtherLaw of_other_law() const;

  void switch_pending();
  void half_forces(bool each_alone);
  void gather(ForceSums &);
  /// A style without connective joints: nothing is joined.
  void without_connective();
  void soften(ForceSums &);
  void find_pending();
  /// In steps in which elements may convert: ties whose elements a crack wants are marked.
  void decide_cracks();
  void adopt_states();

  // messages: of one DE, up to the size

  static constexpr int FORCES_SIZE = 1 + 18 + JointCracks::ENERGY_SIZE;
  int forces_size() const { return cracks_ ? FORCES_SIZE : 1 + 18; }
  int pack_forces(int d, double *buf) const;
  int unpack_forces(int d, const double *buf);
  int states_size() const { return cracks_ ? 1 + 6 * JointCracks::MEMORY_SIZE : 1; }
  int pack_states(int d, double *buf) const;
  int unpack_states(int d, const double *buf);

  /// Since begin().
  const std::vector<JointEvent> &events() const { return events_; }
  const std::vector<LooseDEs> &broken() const { return broken_; }
  bool damaged() const { return damaged_; }    ///< a joint between DEs began to soften

  /// At the positions of the particles that were set last.
  /// \param joint  of an owned DE; of a cohesive one, that of the lower ID
  JointView view(int joint) const;

  double memory_usage() const;

 private:
  JointTable &jt;
  const JointLaws &laws;
  CrackHost &host;
  EnergyLedger &ledger;
  StoredEnergy &stored;
  MovingParticles particles;
  double dt = 0.0;
  bool moving = false;

  std::unique_ptr<JointCracks> cracks_;
  bool both_laws = false;    // some joints are cut by cracks, others judged by their traction
  std::vector<char>
      crack_cuts;    // by types, as JointLaws::coeffs: joints are cut by planes of their own

  std::vector<unsigned char>
      wanted;    // of DEs and ghosts, a bit per slot: another rank has the DE at the other end
  std::vector<double> least_threshold;      // by DE: of its joints
  std::vector<double> least_of_row;         // of JointTable::rows
  std::vector<int> above;                   // joints with more force than that
  std::vector<unsigned char> pending_of;    // of each DE of this rank, a bit per slot
  std::vector<int> decided_elsewhere;       // joints whose state another rank decides
  std::vector<int> taking_over;             // joints that a crack has cut in this step
  /// What is asked in each step of the joints in JointTable::cohesive, in their order: their records are far apart in
  /// memory, and most rest.
  struct Softening {
    JointRecord *record;
    SoftJoint *soft;
    JointCrack *crack;    // null: none cuts it
    signed char plane;    // as in the record
  };
  std::vector<Softening> softening_list;
  std::vector<char> flagged;    // by DE, while that list is brought up to date
  std::vector<int> awake,
      cut_by_cracks;    // softening joints and planes that are computed now: index in this list; joint
  std::vector<JointCracks::Broken> broken_planes;    // of these

  std::vector<JointEvent> events_;
  std::vector<LooseDEs> broken_;
  bool damaged_ = false;

  const CohesiveParameters &law_of(int d, int s) const;
  CohesiveParameters law_at_start(int d, int s) const;
  const CohesiveParameters &adhesive_law(int d, int s) const;
  const OpeningLaw &opening(int d, int s) const;
  bool by_crack(int d, int s) const;
  bool at_lower_id(int d, int s) const;
  JointStiffness stiffness(int d, int s) const
  {
    return laws.stiffness(jt.material[d], jt.len[d][s]);
  }

  // states: joint_states.cpp
  double threshold_of(int d, int s) const;
  bool reaches(double force_squared, int d, int s) const
  {
    return force_squared > least_threshold[d] && force_squared > threshold_of(d, s);
  }
  bool starts(int d, int s);
  void mark_pending(int joint);
  void make_pending(int joint);
  void forget_pending();
  template <class F> void for_leaving(F f);
  double release_of_pending();
  void share_out_release(int d, unsigned leaving);
  void begin_cracks();
  void switch_joint(int joint);
  void set_broken(int d, int s);
  void close_plane(int d, int s);
  void leave_plane(int d, int s);
  void adopt_state(int joint, int state);
  void set_contact_distance(int joint, double distance);
  void event(int d, int s, EventKind what, double value);

  // forces: joint_forces.cpp
  void gather(int d, ForceSums &);
  bool gather_row(int row, ForceSums &);
  bool gather_quiet(int d, ForceSums &);
  void take_over_cracks();
  void list_softening();
  void wake_beside_cuts();
  void find_awake();
  void leave_out_open();
  void forget_ended();
  void soften_tie(int d, int s, SoftJoint &, ForceSums &);
  void soften_joint(int d, int s, SoftJoint &, ForceSums &);
  void soften_crack(int d, int s, SoftJoint &, CrackJoint &, ForceSums &);
  void apply_crack(int d, int s, const CrackForces &, ForceSums &);
  void book(const SofteningStep &);
  Vec3 face_normal(int d, int s, const Vec3 &along) const;
  TiePoint tie_point(int d, int s) const;
  static SofteningJoint softening(JointRecord &, SoftJoint &);
};

}    // namespace defe

#endif
