#ifndef DEFE_COUPLING_JOINT_CRACKS_H
#define DEFE_COUPLING_JOINT_CRACKS_H

/// \file
/// Cracks among the joints of a rank: the law is crack_growth.h and crack_softening.h, here are its tables of the DEs of
/// this rank and of ghosts, and what goes in messages. A joint is decided upon, and computed, by the rank of its DE
/// of the lower ID; others hear of it with the states of joints. Called in the order that stands at the end of
/// crack_growth.h.

#include "defe/coupling/crack_growth.h"
#include "defe/coupling/crack_softening.h"
#include "defe/coupling/joint_table.h"
#include "defe/coupling/particles.h"

#include <array>
#include <unordered_map>
#include <vector>

namespace defe {

/// What cracks ask of a DE of this rank beyond the table of joints.
struct CrackDE {
  unsigned outer;    ///< see CrackLattice, as the next
  std::uint16_t turned;
  int part;
  double volume;
  Vec3 place;    ///< reference position, never wrapped
};

/// Who keeps the records of DEs, and finds particles by their IDs.
class CrackHost {
 public:
  virtual CrackDE describe(int de) const = 0;
  /// describe(de) comes soon: a hint to fetch its record.
  virtual void expect(int /*de*/) const {}
  /// Cracks of an owned DE, null: it has none; and the same, made if there are none.
  virtual std::vector<JointCrack> *find_cracks(int de) const = 0;
  virtual std::vector<JointCrack> &cracks_of(int de) = 0;
  /// The particle with this ID, of its images the one nearest to the DE; < 0: it is not here.
  virtual int nearest(int de, std::int64_t id) const = 0;
  /// Half of the periods of the box; infinite where it is not periodic.
  virtual Vec3 half_periods() const = 0;

 protected:
  ~CrackHost() = default;
};

class JointCracks {
 public:
  /// All of them stay; `particles` are those of the current evaluation.
  JointCracks(JointTable &, const MovingParticles &particles, CrackHost &);

  /// Strength of joints between DEs of two types, [types][types]; infinite where another law has them.
  void set_strengths(int types, std::vector<double> sigma_t, std::vector<CrackNuclei>,
                     const std::vector<CornerModuli> &);
  bool on() const { return types > 0; }
  static constexpr int most_types = 256;

  // ---- with new tables: prepare(), a message of up to TABLE_SIZE per DE, resolve() ----

  static constexpr int TABLE_SIZE = 3 + 6 + 6 * 4;
  void prepare();
  int pack_table(int d, double *buf) const;
  int unpack_table(int d, const double *buf);
  void resolve();

  // ---- a step ----

  /// Pending joints leave their corners: cut from now on.
  void cut_pending();

  /// Beside the half forces of a DE: its energy, and what its corners let go. Up to ENERGY_SIZE.
  static constexpr int ENERGY_SIZE = 7;
  int pack_energy(int d, double *buf) const;
  int unpack_energy(int d, const double *buf);
  void set_shares(int d, const std::array<double, 6> &share) { shares[d] = share; }

  /// A joint whose lower end is mine takes over what the corners let go; its traction then.
  double take_over(int joint, const CohesiveParameters &);
  void end_take_over() { shares.clear(); }
  /// Before joints of this rank that a crack cuts are computed: how their DEs have turned.
  void know(const std::vector<int> &joints);

  struct Broken {
    int joint;
    CrackJoint *law;
  };
  /// After know(), of broken joints: those whose planes are open are advanced, several at a time, and have no force.
  /// \return  true for these; the others are left to advance()
  const std::vector<char> &advance_open(const std::vector<Broken> &, double dt);

  /// JointRecord::plane of a broken joint that has just been computed.
  signed char resting(int joint, const CrackJoint &, double dt);
  /// A hint that this comes soon.
  void expect_resting(int joint) const;
  /// Whether the plane of a broken joint is open for this step, by what resting() has found before: then it is one step
  /// nearer to the end of its rest. One that turns with the spins does so.
  bool rests(int joint, JointCrack *, signed char &plane, double dt) const;
  /// \param friction  of a broken plane; \param dt  0 before a run
  CrackForces advance(int joint, CrackJoint &, const CohesiveParameters &, double friction,
                      double dt);
  /// The same for output: nothing changes.
  CrackForces look(int joint, const CohesiveParameters &, CrackJoint &) const;
  const std::array<int, 6> &partners(int d) const { return partner[d]; }
  int other_end(int joint) const { return partner[joint / 6][joint % 6]; }
  /// One of the other law softens from the end of this step on.
  void cut(int joint) { cutting.push_back(joint); }
  /// Its two DEs are for the contact of spheres from the end of this step on.
  void part(int joint) { parting.push_back(joint); }

  // ---- flaws that grow: JointTable::strength falls from step to step (joint_tension.cpp), before mark() ----

  struct Tension {
    int de;
    double value;
  };
  /// Of owned DEs that may bear more than `share` (by part) of their strength: largest tension of corners that share a joint.
  void find_tensions(const std::vector<double> &share, std::vector<Tension> &) const;
  /// Strengths of DEs and ghosts have fallen: the energies of owned DEs below which nothing starts, which ghosts need, too.
  void strengths_fell();
  double quiet_energy(int d) const { return quiet[d]; }
  void set_quiet_energy(int d, double energy) { quiet[d] = energy; }

  /// DEs whose stresses decide, then a message of up to STRESS_SIZE per DE, then decide().
  static constexpr int STRESS_SIZE = 2 + CrackStress::size;
  void mark();
  int pack_stress(int n, const int *list, double *buf) const;
  void unpack_stress(int first, const double *buf);
  void decide();
  /// Joints that were decided upon and start: they are pending.
  const std::vector<int> &starts() const { return started; }
  const std::vector<int> &entered() const { return growth.entered(); }

  /// With the state of a joint that starts, at its lower end: false if it does not.
  static constexpr int MEMORY_SIZE = 4;
  bool pack_memory(int joint, double *buf) const;
  void unpack_memory(int joint, const double *buf);
  /// Forget pending joints; keep one that was.
  void forget_pending();
  void keep_pending(int joint);
  /// All ranks know the states: joints that have come apart leave the lattice.
  void end_of_step();

  /// Energy that the corners of DE d let go if joints leave them, and each one's share of it.
  double release(int d, unsigned leaving, double share[6]) const;
  JointCrack *find(int joint) const;
  void forget(int joint);
  /// DEs whose cracks are at other places in memory than before, since new tables or forget_moved().
  const std::vector<int> &moved() const { return moved_; }
  void forget_moved() { moved_.clear(); }
  /// DEs, ghosts as well, that have lost a joint since new tables or forget_poorer(): what the rotation at their open planes is taken
  /// from must be found again before it has moved, so these are not to rest in this step.
  const std::vector<int> &poorer() const { return poorer_; }
  void forget_poorer() { poorer_.clear(); }

  double memory_usage() const;

 private:
  JointTable &jt;
  const MovingParticles &particles;
  CrackHost &host;
  int types = 0;
  std::vector<double> sigma_t;
  std::vector<CrackNuclei> nuclei;
  double least_strength = 0.0;
  double least_strength_at(int d) const;
  std::vector<CornerModuli> moduli;    // per part

  std::vector<std::int64_t> id;
  std::vector<std::array<double, 3>> X;
  std::vector<std::array<int, 6>> partner;
  struct FarEnd {
    std::int64_t id = 0;    // of the other DE, 0: none
    int slot = 0;           // of the joint there
  };
  std::vector<std::array<FarEnd, 6>> of_ghost;
  FarEnd far_end(int d, int s) const;
  std::vector<unsigned char> outer, state, ties, type;
  std::vector<std::uint16_t> turned;
  std::vector<double> quiet;
  std::vector<double>
      least_volume;    // by owned DE, where flaws have strengths: crack_least_volume
  std::vector<std::uint64_t> key;
  CrackLattice lattice() const;

  CrackGrowth growth;
  std::vector<CrackStart> decisions;
  std::vector<int> started;
  struct Cut {
    int joint;
    CrackMemory memory;
  };
  std::vector<Cut> cuts;       // while tables are made: of lower ends, ascending
  std::vector<Cut> coming;     // pending: joints that are cut in the next step
  std::vector<int> cutting;    // of the other law, softening from the end of this step on
  std::vector<int> parting;    // joints that leave the lattice at the end of this step
  // by DE or lower end, own and of ghosts, which may be on their way to a third rank
  std::unordered_map<int, std::array<double, 6>> shares;
  std::unordered_map<int, CrackStress> foreign;
  std::unordered_map<int, CrackMemory> memories;
  void remember(int joint, const CrackMemory &);
  std::vector<int> moved_, poorer_;

  struct End {
    Vec3 dX[6], y[6];
  };
  // of the DEs of joints that are computed in this evaluation
  std::vector<int> known_place;    // by DE; -1: not one of them
  std::vector<int> known_des;
  std::vector<End> known_vectors;
  std::vector<CrackEnd> known_ends;
  std::vector<DERotation> known_turns;
  std::vector<double> known_turning;    // see turning_of(); < 0: nobody has asked yet
  const CrackEnd &known_end(int d) const { return known_ends[known_place[d]]; }
  std::vector<CrackEnd> poor_ends;    // CrackEnd::with of these
  std::vector<int> poor_joints;
  std::vector<DERotation> poor_turns;
  void know_with_cut(const std::vector<int> &joints);
  std::vector<char> was_open;

  std::vector<CrackBox> boxes;    // of DEs that are marked, see mark()
  std::vector<CrackStress> box_stress;
  std::vector<int> boxed;
  double budget(int joint) const;    // what both ends let go for it
  void fill(CrackBox &, int d) const;
  CrackEnd end(int d, End &) const;
  GeneralCell cell(int d) const;
  Mat3 axes(int d) const;
  void arms(int d, Vec3 y[6]) const;
  CrackGeometry geometry(int joint) const;
  Vec3 spin_of(int joint, double dt) const;
  double turning_of(int d);
  void find_partners_of_ghosts();
};

}    // namespace defe

#endif
