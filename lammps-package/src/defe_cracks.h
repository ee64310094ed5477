/* ----------------------------------------------------------------------
   DEFE: adaptive finite elements to bonded discrete elements for LAMMPS
   https://www.lammps.org/
   This software is distributed under the GNU General Public License.
------------------------------------------------------------------------- */

#ifndef LMP_DEFE_CRACKS_H
#define LMP_DEFE_CRACKS_H

#include "pointers.h"

#include "defe_joint_table.h"

#include "defe/coupling/crack_growth.h"
#include "defe/coupling/crack_softening.h"

#include <array>
#include <unordered_map>
#include <vector>

namespace LAMMPS_NS {

/** Cracks that go where the stress sends them: the law is coupling/crack_growth.h and crack_softening.h,
    here are its tables of the DEs of this rank and of ghosts, and what goes in messages. The
    pair style calls it in the order that stands at the end of crack_growth.h. Numbers of DEs and
    joints (6 * DE + slot) are those of JointTable. */
class DefeCracks : protected Pointers {
 public:
  DefeCracks(class LAMMPS *, struct DefeSystem *);

  /** Strength of joints between DEs of two types, [types][types]; infinite where another law has them. */
  void set_strengths(int types, std::vector<double> sigma_t, std::vector<defe::CrackNuclei>,
                     const std::vector<defe::CornerModuli> &);
  bool on() const { return types > 0; }

  // ---- with new tables: prepare(), forward_comm of up to TABLE_SIZE per DE, resolve() ----

  static constexpr int TABLE_SIZE = 3 + 6 + 6 * 4;
  void prepare();
  int pack_table(int d, double *buf) const;
  int unpack_table(int d, const double *buf);
  void resolve();

  // ---- a step ----

  /** Joints that were noted leave their corners: cut from now on. */
  void cut_noted();

  /** Beside the half forces of a DE: its energy, and what its corners let go. Up to ENERGY_SIZE. */
  static constexpr int ENERGY_SIZE = 7;
  int pack_energy(int d, double *buf) const;
  int unpack_energy(int d, const double *buf);
  void set_shares(int d, const std::array<double, 6> &share) { shares[d] = share; }

  /** A joint whose lower end is mine takes over what the corners let go; its traction then. */
  double take_over(int joint, const defe::CohesiveParameters &);
  void end_take_over() { shares.clear(); }
  /** Before the joints of an evaluation are computed. */
  void forget_ends();

  /** JointSlot::plane of a broken joint that has just been computed. */
  signed char resting(int joint, const defe::CrackJoint &, double dt) const;
  /** Whether the plane of a broken joint is open for this step, by what resting() has found before. */
  static bool rests(signed char &plane, double dt);
  /** \param friction  of a broken plane; \param dt  0 before a run */
  defe::CrackForces advance(int joint, defe::CrackJoint &, const defe::CohesiveParameters &,
                            double friction, double dt);
  /** The same for output: nothing changes. */
  defe::CrackForces look(int joint, const defe::CohesiveParameters &, defe::CrackJoint &) const;
  const std::array<int, 6> &partners(int d) const { return partner[d]; }
  int other_end(int joint) const { return partner[joint / 6][joint % 6]; }
  /** One of the other law softens from the end of this step on. */
  void cut(int joint) { cutting.push_back(joint); }
  /** Its two DEs are for the contact of spheres from the end of this step on. */
  void part(int joint) { parting.push_back(joint); }

  /** DEs whose stresses decide, then a forward_comm of up to STRESS_SIZE per DE, then decide(). */
  static constexpr int STRESS_SIZE = 2 + defe::CrackStress::size;
  void mark();
  int pack_stress(int n, const int *list, double *buf) const;
  void unpack_stress(int first, const double *buf);
  void decide();
  /** Joints that were decided upon and start: they are noted. */
  const std::vector<int> &starts() const { return noted; }
  const std::vector<int> &entered() const { return growth.entered(); }

  /** With the state of a joint that starts, at its lower end: false if it does not. */
  static constexpr int MEMORY_SIZE = 4;
  bool pack_memory(int joint, double *buf) const;
  void unpack_memory(int joint, const double *buf);
  /** Forget what was noted; keep one that was. */
  void forget_noted();
  void keep_noted(int joint);
  /** All ranks know the states: joints that have come apart leave the lattice. */
  void end_of_step();

  /** Energy that the corners of DE d let go if joints leave them, and each one's share of it. */
  double release(int d, unsigned leaving, double share[6]) const;
  JointCrack *find(int joint) const;
  void forget(int joint);

  double memory_usage() const;

 private:
  DefeSystem *sys;
  JointTable &jt;
  int types = 0;
  std::vector<double> sigma_t;
  std::vector<defe::CrackNuclei> nuclei;
  double least_strength = 0.0;
  std::vector<defe::CornerModuli> moduli;    // per part

  std::vector<std::int64_t> id;
  std::vector<std::array<double, 3>> X;
  std::vector<std::array<int, 6>> partner;
  std::vector<std::array<tagint, 6>> other;            // ID of the other DE, 0: none
  std::vector<std::array<signed char, 6>> its_slot;    // of the joint, at the other DE
  std::vector<unsigned char> corner, state, ties, type;
  std::vector<double> quiet;
  std::vector<std::uint64_t> key;
  defe::CrackLattice lattice() const;

  defe::CrackGrowth growth;
  std::vector<defe::CrackStart> decisions;
  std::vector<int> noted;
  std::unordered_map<int, defe::CrackMemory> cuts;    // while tables are made: of lower ends
  struct Cut {
    int joint;
    defe::CrackMemory memory;
  };
  std::vector<Cut> coming;     // noted: joints that are cut in the next step
  std::vector<int> cutting;    // of the other law, softening from the end of this step on
  std::vector<int> parting;    // joints that leave the lattice at the end of this step
  // by DE or lower end, own and of ghosts, which may be on their way to a third rank
  std::unordered_map<int, std::array<double, 6>> shares;
  std::unordered_map<int, defe::CrackStress> foreign;
  std::unordered_map<int, defe::CrackMemory> memories;
  void remember(int joint, const defe::CrackMemory &);

  struct End {
    defe::Vec3 dX[6], y[6];
  };
  // of the DEs of joints that have been computed in this evaluation
  struct KnownEnd {
    End vectors;
    defe::DERotation turn;
    unsigned present;
  };
  std::vector<int> known_place;    // by DE; -1: not yet
  std::vector<int> known_des;
  std::vector<KnownEnd> known;
  void know(int d);
  defe::CrackEnd known_end(int d) const;

  std::vector<defe::CrackBox> boxes;    // of DEs that are marked, see mark()
  std::vector<defe::CrackStress> box_stress;
  std::vector<int> boxed;
  double budget(int joint) const;    // what both ends let go for it
  defe::CrackEnd end(int d, End &) const;
  defe::GeneralCell cell(int d) const;
  defe::Mat3 axes(int d) const;
  void arms(int d, defe::Vec3 y[6]) const;
  defe::CrackGeometry geometry(int joint) const;
  void find_partners_of_ghosts();
};

}    // namespace LAMMPS_NS

#endif
