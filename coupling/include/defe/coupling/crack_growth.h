#ifndef DEFE_COUPLING_CRACK_GROWTH_H
#define DEFE_COUPLING_CRACK_GROWTH_H

/// \file
/// Where cracks start and how they go on: a law that does not know the mesh.
///
/// Judged by its own traction a joint feels sigma cos^2 of its angle only, and a crack stays on the
/// lattice row that it runs along. Here the stress says where a crack goes. Every cut (softening or
/// broken) joint remembers the crack's normal m and where the crack passes between its two DEs, p. All in the
/// reference frame, with second Piola-Kirchhoff stresses.
///
/// **Front.** A ring (crack_rings.h) with one cut joint holds a crack front. S_q = stress of the full
/// corners of the ring's DEs and of their face neighbours, s_1 its largest principal value;
/// m_q = largest principal direction of S_q + memory s_1 m m^T: the crack's next normal, which in an
/// equibiaxial field is the old one. Once m_q . S_j m_q reaches sigma_t at any intact joint j of the ring (S_j: corners
/// on both sides that share the joint), and m_q . S_q m_q `pull` sigma_t, the front moves: the joints whose DEs lie on
/// either side of the plane through p with normal m_q open. Fronts that meet at a joint add up their planes.
/// Planes of neighbouring rings differ by some degrees and tenths of d. Where one passes above a DE and the next one below it, it
/// would be cut off from both halves. So a DE with cut joints of this crack (normals within 60 degrees) stays on the side on
/// which they say that it is, and a plane that passes within `side_reach` of the joint's length on the other side passes it closely.
/// (The mean tension around a front that runs is 0.4 to 0.5 sigma_t, at least 0.22. In glass that is crushed under a ball
/// single joints are torn while the plane as a whole is pressed with 100 MPa: without `pull` cracks went on there, too.)
///
/// **Ligament.** The last intact joint of a ring opens when the stress along the mean normal of
/// the others reaches sigma_t; so does the one that is loaded most where an odd number >= 3 is cut.
///
/// **Nucleus.** Elsewhere a joint opens when sigma_1(S_j) reaches sigma_t (1 + scatter u), u in [0, 1) of a hash of its
/// place, if it is best aligned with the tension among the axes of its DEs, and first among such
/// joints of its DEs and their neighbours. Beside a crack (in a ring with a cut joint, or within
/// 1.5 d of the plane of a cut joint whose p is within d) it takes `overstrength` times as much: that is how cracks branch.
/// Both numbers are those of the joint's pair of types.
///
/// Where the strength of flaws is given (strength_field.h), that of the weaker DE takes the place of sigma_t for nuclei
/// between DEs of one type. A crack that runs needs no flaw: fronts, ligaments, branches and entries keep sigma_t.
///
/// **Entry.** Where a ring is open because finite elements are in its way, the front asks for those that the plane
/// through p with normal m needs: that it cuts between the DE at their face, the one to come behind it, and the next
/// one of the ring (placed as if the element were as long as its neighbour). It asks once its DE is not quiet and
/// m . S m, S of the corners at the tie, reaches `entry` sigma_t: they are
/// to convert, whatever their own stress. In a lattice that is turned the crack may pass on the other side of the
/// ring, and where it has come from nothing is stressed: then m . S m of the joints that are left of the ring counts, and
/// of its last DE at the tie there. Then the ring closes and the front goes on. It
/// goes on through an open ring of which three DEs are there, too, where its plane passes between these; where it does
/// not, once the ring has fired, the front asks for what is missing. (Why not for all that a ring lacks: coupling/README.md.)
/// `entry` is below 1 so that all
/// elements along a front have converted before it moves: where some had, fronts left their plane.
///
/// All decisions come from the state at their beginning, sums are ordered by ID and a joint is decided upon by the
/// rank of its DE of the lower ID, so neither numbering nor ranks matter.
///
/// Differences from the law's first form (prototypes): a nucleus competes only with joints that could
/// open themselves (else a joint that is loaded more but badly aligned keeps its neighbours shut);
/// rings of any size; memory 1 in place of 0.3, at which fronts in a strip of DEs between finite elements, two DEs wide
/// and so with little to average over, turned by 90 degrees where the stress along the crack is the larger one;
/// directions of nuclei in exactly equibiaxial tension come from the hash, not from rounding or the mesh.
///
/// What a step needs, and what ranks exchange: end of this file.

#include "defe/coupling/crack_rings.h"
#include "defe/coupling/crack_stress.h"
#include "defe/coupling/flaws_between.h"

#include <deque>
#include <vector>

namespace defe {

/// Of a cut joint, seen from its DE of the lower ID. Plain data.
struct CrackMemory {
  double m[3];    ///< unit normal, towards the other DE
  double f;       ///< p = X + f (X_other - X)
};

struct CrackStart {
  enum Origin { FRONT, LIGAMENT, NUCLEUS, BRANCH };

  int joint;    ///< 6 * DE + slot of the lower ID, which is owned
  CrackMemory memory;
  Origin origin;
};

struct CrackGrowthParameters {
  double memory = 1.0;    ///< weight of the old direction
  double pull = 0.2;      ///< tension around a front that moves, times sigma_t
  double entry = 0.3;     ///< of a front before a finite element, times sigma_t
};

/// What nuclei take between DEs of two types. Plain data, in restart files.
struct CrackNuclei {
  double overstrength = 2.0;    ///< beside a crack, times sigma_t; 1.3 to 2
  double scatter = 0.01;        ///< of the strength of nuclei; growth keeps sigma_t
};

/// Strength of the joint between two DEs by their types; infinite where none may be cut.
struct CrackStrength {
  const unsigned char *type;    ///< [n] of DEs
  int types;
  const double *sigma_t;            ///< [types * types]
  const CrackNuclei *nuclei;        ///< same
  const double *flaws = nullptr;    ///< [n] of DEs, see JointTable::strength; null: there are none

  double operator()(int a, int b) const { return sigma_t[type[a] * types + type[b]]; }
  const CrackNuclei &nucleus(int a, int b) const { return nuclei[type[a] * types + type[b]]; }
  /// Of a nucleus, before its scatter.
  double of_nucleus(int a, int b) const
  {
    const double sigma = (*this)(a, b);
    return flaws && type[a] == type[b] ? strength_between(flaws[a], flaws[b], sigma) : sigma;
  }
};

class CrackGrowth {
 public:
  using Ids = std::array<std::int64_t, 2>;    ///< of the two ends, the lower one first
  /// Share of sigma_t for crack_quiet_energy: what is below need not be looked at.
  static constexpr double quiet_share = 0.98;
  /// How far beside a DE a plane that it is known to be on the other side of passes it all the same, in lengths of the joint.
  static constexpr double side_reach = 0.3;

  /// Numbers of DEs have changed; cracks are forgotten and must be added again.
  void reset(const CrackLattice &lattice);
  /// A cut joint, of own DEs or ghosts, by either end.
  void add_crack(const CrackLattice &lattice, int joint, const CrackMemory &memory);
  /// Of all cracks at once, after reset(): costs less.
  void add_known_crack(const CrackLattice &lattice, int joint, const CrackMemory &memory);
  /// One that is no joint any more; before it loses its partner in the lattice.
  void remove_crack(const CrackLattice &lattice, int joint);
  /// A joint was cut by another law, or has lost its partner: for add_crack() and remove_crack() this is known.
  void joint_changes(const CrackLattice &lattice, int joint);

  /// Finds DEs whose corner stresses decide(): those with an intact joint that is not quiet, what fronts beside loud DEs
  /// average over, and those before ties.
  /// \param energy, quiet  [n] strain energy of DEs, ghosts as well; crack_quiet_energy (of the least sigma_t)
  /// \return the marked ones, own and ghosts, ascending
  const std::vector<int> &mark(const CrackLattice &lattice, const double *energy,
                               const double *quiet);
  bool marked(int de) const { return place[de] >= 0; }
  /// Room for the stress of a marked DE: to be filled for all of them before decide().
  CrackStress &stress(int de) { return stresses[place[de]]; }
  const CrackStress &stress(int de) const { return stresses[place[de]]; }

  /// \param starts  joints of own DEs (lower IDs) that open, ordered by their IDs
  void decide(const CrackLattice &lattice, const CrackStrength &strength,
              const CrackGrowthParameters &parameters, std::vector<CrackStart> &starts);

  /// Ties of own DEs behind which the last decide() found a crack that wants to go on: 6 * DE + slot, ascending.
  const std::vector<int> &entered() const { return entries; }

 private:
  struct Hot {    // an intact joint that may have reached its strength
    int joint;
    double limit;    // its sigma_t
    double value;    // sigma_1(S_j) / sigma_t
    double flaws;    // strength of a nucleus / sigma_t
    CrackNuclei nucleus;
    Vec3 direction;
    Mat3 S;
  };
  struct Vote {
    int joint;    // lower end
    std::int64_t key[4];
    Vec3 m;
    double below, above;
  };
  struct Front {
    Vec3 m;
    double tension;    // along it, around the front
  };
  struct Waiting {    // a front before a tie
    int crack, tie;
    CrackRing arc;         // joints that are left between the two; empty: the tie alone counts
    Vec3 missing;          // reference place of the DE behind the tie
    Vec3 next;             // and of the one after it in the ring
    bool known = false;    // both are
  };
  struct Crack {
    CrackMemory memory;
    bool stale = false;    // the rings must be found again
    bool wide =
        false;    // one is around an edge of more than four elements: whenever any joint changes
    std::vector<CrackRing> odd;
    std::vector<Waiting> before_ties;
  };

  /// By lower end. Most cuts of a step are looked for around other joints, and not found.
  class Cracks {
   public:
    /// For so many joints, of which none is cut.
    void reset(std::size_t joints);
    /// Made if it is not there; stays where it is until reset().
    Crack &operator[](int joint);
    Crack *find(int joint) const { return of[joint]; }
    const Crack &at(int joint) const { return *of[joint]; }
    void erase(int joint);
    bool empty() const { return count == 0; }

   private:
    std::vector<Crack *> of;    // null: not cut
    std::deque<Crack> all;      // kept, with the memory of their lists
    std::size_t taken = 0, count = 0;
  } cracks;
  struct Listed {
    Ids ids;
    int joint;
    Crack *crack;
  };
  std::vector<Listed> live;    // those with a front, in the order of IDs
  std::vector<Listed> stale, wide;
  bool changed = false;
  std::vector<int> close;    // joints whose energy is enough for their strength, by lower end
  std::vector<int> place;    // [n] index into stresses, or < 0
  std::vector<unsigned char> loud;
  std::vector<int> loud_list, active;
  std::vector<CrackStress> stresses;
  std::vector<CrackRing> fronts;
  std::vector<Waiting> waiting;
  std::vector<int> entries;
  std::vector<Hot> hot;
  std::vector<int> hot_of;    // [6 * active] by lower end
  std::vector<Vote> votes;

  void find_again(const CrackLattice &, int joint, Crack &);
  void update_live(const CrackLattice &);
  void find_rings(const CrackLattice &, int joint, Crack &) const;
  void find_waiting(const CrackLattice &, int joint, Crack &) const;
  bool needed(const CrackLattice &, const Waiting &) const;
  template <class F> void find_fronts(const CrackLattice &, const F &may_open);
  bool wants_to_enter(const CrackLattice &, const CrackStrength &, const Waiting &,
                      double share) const;
  void enter(const CrackLattice &, const CrackStrength &, double share);
  void open(const CrackLattice &, const CrackStrength &, const CrackGrowthParameters &,
            std::vector<CrackStart> &);
  void activate(int de);
  void find_hot(const CrackLattice &, const CrackStrength &);
  const Hot *hot_joint(const CrackLattice &, int joint) const;
  Vec3 crack_point(const CrackLattice &, int joint) const;
  Vec3 normal(int joint) const { return Vec3(cracks.at(joint).memory.m); }
  Front front(const CrackLattice &, const CrackRing &, const Vec3 &old, double memory) const;
  int side(const CrackLattice &, int de, const Vec3 &m) const;
  struct Heights {
    double below, above;
  };
  Heights heights(const CrackLattice &, int joint, const Vec3 &m, const Vec3 &p) const;
  void vote(const CrackLattice &, const CrackRing &, const CrackGrowthParameters &);
  void ligament(const CrackLattice &, const CrackRing &, std::vector<CrackStart> &) const;
  void count_votes(const CrackLattice &, const CrackStrength &, std::vector<CrackStart> &);
  bool shielded(const CrackLattice &, int joint) const;
  bool could_start(const CrackLattice &, const Hot &, bool branch, double *excess, Vec3 *m) const;
  void nuclei(const CrackLattice &, std::vector<CrackStart> &) const;
};

// In a step (joint_cracks.h, called by joint_states.h):
//   1. Joints that the last step started leave the corners at both ends (states, present); add_crack() for
//      each, on every rank that knows both of its DEs.
//   2. Corner kernel. With the 18 numbers of half forces go the energy of each DE and, of DEs that have lost
//      joints, their 6 shares of crack_release(), as of the step before.
//   3. crack_take_over() for new joints, then crack_update() for all softening joints and for broken
//      ones that are not apart, by the rank of the lower ID; forces on ghosts are added up as always.
//   4. mark(); crack_stress() for the own ones among the marked, which are forwarded. Both ranks mark alike as
//      far as ghosts reach.
//   5. decide(); crack_start() for what it returns (false: it does not open). With the states go the CrackMemory
//      (4 numbers) of each joint that starts. Then crack_release() for each own DE that is to lose joints, and
//      remove_crack() for joints that have come apart.
// With new lists of neighbours: reset(), add_crack() for all cut joints whose DEs are both known, ghosts
// among themselves included. Of ghosts a rank needs ID, reference position, corner, type, the other
// ends (IDs, slots), and states and CrackMemory of their joints; as far as three joints away.
// CrackJoint is all that a joint keeps; CrackGrowth has no history, so restarts need nothing else.
// A quiet body pays one comparison per DE, and one number per ghost.

}    // namespace defe

#endif
