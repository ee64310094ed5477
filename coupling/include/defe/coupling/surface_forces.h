#ifndef DEFE_COUPLING_SURFACE_FORCES_H
#define DEFE_COUPLING_SURFACE_FORCES_H

/// \file
/// Contact of surfaces on plain arrays: nodes (with the patches around them), DEs and balls against
/// facets. The tables are filled by the search, surface_search.h. The potential: surface_contact.h.
///
/// A contact begins without overlap: an overlap that no motion has made (there from the start, bared by a
/// conversion, left by a tie that broke) is remembered as an offset of the depth, and pushes nothing
/// until it has gone by itself, or is eased out.

#include "defe/coupling/facet.h"
#include "defe/coupling/friction.h"
#include "defe/exact_sum.h"

#include <cstdint>
#include <vector>

namespace defe {

/// A face of a finite element.
struct ContactFacet {
  int node[4];    ///< atom indices, counter-clockwise from outside
  int part;
  std::int64_t element;
  double area;                 ///< reference area
  double k_area;               ///< penalty stiffness per area (N/m3), negative for a rigid part
  double half_xi, half_eta;    ///< reference distances from the middle to the edges
  double depth_max;            ///< a node deeper than this is let through
  bool outer;                  ///< a free surface, not the border to DEs: see surface_forces()
  bool rim[4];    ///< edges at xi = 1, -1, eta = 1, -1: the surface ends there or bends sharply
};

/// The quarter of a facet at one of its nodes.
struct ContactPatch {
  int facet, corner;
};

/// A node with its patches, or a sphere, and the facets of one part that it may touch.
struct ContactPoint {
  int atom;
  int part;            ///< of the facets
  bool sharp;          ///< a node on a sharp edge of its body
  int first, count;    ///< facets: ContactPairs::candidates
  int own, nown;       ///< patches of a node: SurfaceTables::patches
  double r;            ///< 0 for nodes
  double area,
      k_own;    ///< of a sphere: area that it stands for, stiffness per area (negative: rigid)
  double
      half;    ///< of a sphere: half the width of that area; of a node: how far its patches reach
};

struct ContactBall {
  int atom, facet;
};

/// Points, and the facets of each.
struct ContactPairs {
  std::vector<ContactPoint> points;
  std::vector<int> candidates;
};

struct SurfaceTables : ContactPairs {
  std::vector<ContactFacet> facets;
  std::vector<FacetPlane> planes;    ///< of the positions now
  std::vector<ContactPatch> patches;
  std::vector<ContactBall> balls;
  void clear();
};

/// What a contact of a point with a part keeps from step to step. Plain data.
struct ContactHistory {
  double overlap;    ///< depth times area at the last step, offset included; of a sphere: depth
  double offset;     ///< depth that pushes nothing
  TangentialSpring tangential;
  double energy;    ///< without the spring, at the last step
  double push;      ///< of an eased contact at the last step, on its offset
  double eased;     ///< 1: the offset is an overlap from before the first step, which is eased out
};

class ContactMemory {
 public:
  virtual ~ContactMemory() = default;
  virtual ContactHistory *find(int atom, int part) = 0;    ///< null: none
  virtual ContactHistory &make(int atom, int part) = 0;
  virtual void drop(int atom, int part) = 0;
  /// A DE does not feel the elements that it is tied to.
  virtual bool tied(int atom, std::int64_t element) = 0;
  /// A DE that has come in this step: no motion has made what it overlaps.
  virtual bool newborn(int atom) = 0;
  /// An overlap of this point is a contact at once: it stands for one that was there already.
  virtual bool inherits(int atom, int part) = 0;
  /// The element that a DE was until this step has a node in common with this face. The two were one body and not
  /// in contact, of whatever parts they are: there is nothing to inherit.
  virtual bool was_joined(int atom, const ContactFacet &) = 0;
};

struct SurfaceArrays {
  const double *x, *v, *omega, *radius, *mass;    ///< omega, radius, mass: of balls and DEs
  double *f, *torque;
  double dt;
  double friction;
  bool moving;    ///< false: an evaluation without a step before it (setup, minimisation)
  /// The tables have changed in this step, after an evaluation with energy_only: the caller knows what that does to
  /// the energy, and books it himself.
  bool changed = false;
  /// No forces, only the energy: histories learn what the motion of this step has done, before the tables change.
  /// (Points whose contact has ended keep theirs.)
  bool energy_only = false;
  bool minimizing = false;    ///< an iteration: points get deeper without a speed
  double ease;                ///< share of all offsets that goes in this step, 0 = they stay
  bool virial = true;         ///< false: not asked for
  SumGrid force_grid, torque_grid;    ///< if on: of what is added to f and torque
};

/// A point that has got deeper than it can be followed.
struct LetThrough {
  int atom, facet;
  double depth;
  double energy;         ///< that is lost with it; < 0: what a ball is given as it comes out again
  bool counts = true;    ///< false: energy only
};

struct SurfaceResult {
  double energy = 0.0;      ///< of contact
  double springs = 0.0;     ///< of tangential springs
  double friction = 0.0;    ///< lost by rubbing in this step
  double eased = 0.0;       ///< put in by easing offsets
  double virial[6] = {0.0, 0.0, 0.0, 0.0, 0.0, 0.0};
  double offset_max = 0.0;    ///< largest overlap that began in this evaluation, and its atom
  int offset_atom = -1, offset_count = 0;
  double ball_depth =
      0.0;    ///< deepest ball in a facet without a step before it, and all their energy
  double ball_energy = 0.0;
  int ball_atom = -1;
  int beyond = -1;    ///< an atom with a force or torque beyond the grids
  std::vector<LetThrough> let_through;
  std::vector<LetThrough> inherited;    ///< contacts that began with an overlap, and their energy
};

/// A face that a conversion has bared meets only balls whose centre is over it: the others are on the DEs in
/// front of it or on the faces round its edges, and may have reached into it before it was bared.
///
/// Adds forces to f and torque.
/// \param near  pairs of the tables that may touch (surface_near.h); null: all
SurfaceResult surface_forces(const SurfaceTables &, const SurfaceArrays &, ContactMemory &,
                             const ContactPairs *near = nullptr);

/// Weight of a patch against a parallel facet: the finer side carries more, both sides add up to 1.
double side_weight(double own_area, double facet_area);

}    // namespace defe

#endif
