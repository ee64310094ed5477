#ifndef DEFE_COUPLING_JOINT_TABLE_H
#define DEFE_COUPLING_JOINT_TABLE_H

/// \file
/// Joints and ties of the DEs of a rank: what each of them keeps, and the table of local indices, which is made anew with
/// the neighbour lists.

#include "defe/coupling/corner_strain.h"
#include "defe/coupling/crack_softening.h"
#include "defe/coupling/element_split.h"
#include "defe/coupling/flaws_between.h"
#include "defe/coupling/large_pages.h"
#include "defe/coupling/particles.h"
#include "defe/coupling/pool.h"

#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <vector>

namespace defe {

namespace joint {
  enum Kind : signed char { NONE = 0, DE = 1, TIE = 2 };
  enum State : signed char { CONNECTIVE = 0, COHESIVE = 1, CONTACT = 2 };
  /// In JointTable::state only: CONTACT, and the plane of the crack still takes it, see JointRecord::plane
  constexpr signed char PLANE = 3;
  /// As a Kind, in output only: a joint to a tied place, which no record is of
  constexpr signed char PLACE = 3;
}    // namespace joint

/// What every one of the six joint slots of a DE has, but for the ID of its other end. Slot 2*a (2*a+1) looks along the negative
/// (positive) natural axis a of its element. Plain data, in restart files.
struct JointRecord {
  double area;         ///< reference area of the joint
  double face[3];      ///< reference vector from the DE to the middle of its patch of the face
  double normal[3];    ///< reference unit normal of the patch, pointing out of the DE
  signed char kind, state;
  signed char partner;    ///< slot of the joint on the other DE (also of the one a TIE becomes)
  signed char
      corner;    ///< ElementSplit::behind_code() of the DE at the other end, or that a TIE becomes
  signed char pending;    ///< 1: becomes cohesive in the next step, 2: did so in this one
  signed char part;       ///< TIE: part of the element
  /// CONTACT: not 0 while the two are pressed along the plane of their crack; at the lower end its size is 1 + the
  /// evaluations in which it need not be looked at, negative if it turns with the spins meanwhile
  signed char plane;
  signed char asks;    ///< TIE: 1: a crack wants to go on in the element, which is to convert
};

/// What only a joint has that has reached its strength or is broken. Plain data, in restart files.
struct SoftJoint {
  double cohesive[6];    ///< CohesiveState: e_n, e_s[3], s0, kappa
  double length0;        ///< joint length at which e_n vanishes
  double
      contact_distance;    ///< > 0: of a broken joint, distance below which the two DEs are in contact
  /// COHESIVE: stored energy, dissipated so far (J), kept by the lower ID; stored of a pending joint (1) that a
  /// crack cuts: what this end's corners would have let go
  double stored, lost;
};

/// Of all joints of a DE.
struct SoftJoints {
  SoftJoint of[6];
  static void *operator new(std::size_t) { return Pool<SoftJoints>::take(); }
  static void operator delete(void *r) { Pool<SoftJoints>::give(r); }
};

/// What a DE keeps of its joints: most DEs are those of a body that is whole, far from any crack.
struct DEJoints {
  JointRecord slot[6];
  std::unique_ptr<SoftJoints> soft;    ///< null: none of them has come that far

  /// Made, of zeros, if there is none.
  SoftJoint &soft_joint(int s)
  {
    if (!soft) soft = std::make_unique<SoftJoints>();
    return soft->of[s];
  }
  double contact_distance(int s) const { return soft ? soft->of[s].contact_distance : 0.0; }
  void set_contact_distance(int s, double distance)
  {
    if (soft || distance > 0.0) soft_joint(s).contact_distance = distance;
  }
};

/// What a joint that a crack cuts by its own plane remembers; kept by the DE of the lower ID. Plain data.
struct JointCrack {
  int slot, pad;
  CrackJoint law;
};

/// Indices of the DEs of a rank and of its ghosts, and of their joints and ties. A joint is 6 * DE + slot.
struct JointTable {
  int nde = 0;                                ///< owned DEs
  int orthogonal = 0;                         ///< of these, the first ones have orthogonal cells
  int nall = 0;                               ///< owned and ghost DEs
  LargeVector<int> self;                      ///< particle of a DE
  std::vector<int> of_atom;                   ///< DE of a particle, -1 = none
  LargeVector<std::array<int, 6>> nb;         ///< particle, or ~(index of tie point)
  LargeVector<std::array<int, 6>> partner;    ///< joint at the other DE, -1 = none
  std::vector<unsigned char> present;         ///< bit per slot: acts in the corner strains
  LargeVector<std::array<double, 6>> len, half;
  std::vector<unsigned char> material;
  std::vector<unsigned char> free;     ///< bit per slot: GeneralCell::free
  std::vector<GeneralCell> cell;       ///< of the DEs from `orthogonal` on
  std::vector<CornerTable> corners;    ///< of these, as their joints were in the last step
  /// Of owned DEs: from reference positions to the stress-free shape that len, half and cell are of; empty if no
  /// body has a stress to begin with (fe/prestress.h).
  std::vector<Mat3> stress_free;
  LargeVector<double> half_force;    ///< 18 per DE, owned and ghost, slot by slot
  HalfForces half_forces() { return {half_force.data(), nall}; }
  const double *half_force_of(int d, int s) const
  {
    return half_force.data() + 3 * (static_cast<std::ptrdiff_t>(nall) * s + d);
  }
  const double *half_force_of(int joint) const { return half_force_of(joint / 6, joint % 6); }
  LargeVector<LatticeRow> rows;    ///< of each eight owned DEs, where they are one
  /// With new tables.
  void find_rows();
  LargeVector<double> energy;
  LargeVector<unsigned char> state;    ///< 6 per DE, owned and ghost
  /// Stress at which flaws start a crack in a DE (strength_field.h), owned and ghost; infinite where they have no say,
  /// empty where they have none anywhere.
  std::vector<double> strength;
  std::vector<std::array<int, 4>> tie_node;    ///< per tie, as the next three
  std::vector<std::int64_t> tie_element;
  std::vector<signed char> tie_part;
  std::vector<TieSpot> tie_spot;
  std::vector<double> tie_point;    ///< of ties, and of tied places behind them
  // Tied surfaces (tied_quarters.h): places that DEs are tied to, never broken and of no JointRecord. In nb they follow the
  // ties of elements. Such DEs are not among the orthogonal ones.
  std::vector<int> place_first = {0};    ///< per place, where its particles begin; one more
  std::vector<int> place_particle;
  std::vector<double> place_weight;
  struct ContactDistance {
    int de;
    std::int64_t other;
    double distance;
  };
  std::vector<ContactDistance>
      contact_distances;        ///< SoftJoint::contact_distance, where there is one; by DE
  std::vector<int> pending;     ///< joints and ties that switch in the next step
  std::vector<int> newborn;     ///< DEs that wait for their first force evaluation
  std::vector<int> cohesive;    ///< softening joints and ties that this rank computes
  std::vector<int> debonded;    ///< ties that broke in this step
  std::vector<int> asking;      ///< ties with JointRecord::asks

  std::vector<DEJoints *> records;    ///< of owned DEs: the caller's
  JointRecord &record(int d, int s) const { return records[d]->slot[s]; }
  JointRecord &record(int joint) const { return record(joint / 6, joint % 6); }
  SoftJoint &soft_joint(int joint) const { return records[joint / 6]->soft_joint(joint % 6); }

  /// What takes the place of sigma_t where a crack starts between two DEs: the least of their strengths.
  double flaws_between(int d, int e, double sigma_t) const
  {
    return strength.empty() ? sigma_t : strength_between(strength[d], strength[e], sigma_t);
  }
  double contact_distance(int d, std::int64_t other) const;
  // A tied place, for the value of nb that leads to it

  bool is_place(int neighbor) const { return ~neighbor >= static_cast<int>(tie_node.size()); }
  /// f(particle, weight)
  template <class F> void for_place(int neighbor, const F &f) const
  {
    const std::size_t p = ~neighbor - tie_node.size();
    for (int k = place_first[p]; k < place_first[p + 1]; ++k) f(place_particle[k], place_weight[k]);
  }
  bool is_tied(int d, int s) const { return nb[d][s] < 0 && is_place(nb[d][s]); }
  /// Of the joint of a DE to a tied place: what part of it is on this side of the face. The rest of what passes there is
  /// borne by joints of the DEs on the other side.
  double share_of_place(int d, int s) const
  {
    const GeneralCell &c = cell[d - orthogonal];
    return std::sqrt(c.face[s].squaredNorm() / c.dX[s].squaredNorm());
  }
  int places() const { return static_cast<int>(place_first.size()) - 1; }
  /// Another place for this slot of a DE; after all ties of elements.
  void add_place(int d, int s, const std::vector<int> &particles,
                 const std::vector<double> &weights);
  /// Where ties and tied places are.
  void find_tie_points(const double *x);

  /// A DE has no contact with an element that it is tied to.
  bool tied(int atom, std::int64_t element) const;
  void clear();

  /// The eight DEs from `first` on, if they are one.
  LatticeRow row_from(int first) const;

  /// Strain energy of the corners of an owned DE with these joints, at positions x, and their half forces.
  double corner_energy(int d, unsigned present, const double *x, const CornerModuli &,
                       Vec3 half_force[6]) const;
};

}    // namespace defe

#endif
