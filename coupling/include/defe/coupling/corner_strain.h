#ifndef DEFE_COUPLING_CORNER_STRAIN_H
#define DEFE_COUPLING_CORNER_STRAIN_H

/// \file
/// Corner-strain joints: the elastic continuum of discrete elements (DEs) before it breaks.
///
/// Each DE is the mass point of one eighth of a hexahedron and has six joint slots, one through
/// each face of its cell: slot = 2 * axis + side, axis 0..2 natural axis of its hexahedron, side 0
/// the negative and 1 the positive natural direction. At each of the cell's eight corners
/// (one slot of each axis) three joints meet. With the reference joint vectors M_a and the current
/// ones y_a the corner stores the St Venant-Kirchhoff energy w psi(E) of
///
///   E = (F^T F - I) / 2,   F = [y_1 y_2 y_3] [M_1 M_2 M_3]^-1,   w = |det(h_1, h_2, h_3)|
///
/// with h_a the vector from the DE to the middle of its cell's boundary at slot a, whatever is on
/// the other side (DE, element or nothing). Where joints are missing (surface, broken, softening)
/// psi is minimised over the missing columns, which is closed form: plane stress in the plane of
/// two joints, uniaxial stress along one. Forces are exact derivatives.
/// Only dot products of joint vectors enter, so forces are objective under any rotation, and
/// linear and angular momentum are conserved; particle rotations play no part.
///
/// **Selective shear.** Where a lattice bends, the joints along it turn against each other from one side of a DE to the
/// other: in u_x = k x z, u_z = -k x^2/2 the corners towards +x are sheared by -k L_x/2 and those towards -x by +k L_x/2, which no
/// bent solid is. With cubes that makes up for what DEs lack since they stand inside of the surface; where the cell is longer
/// than thick it is too much, as (L_x/L_z)^2. So of the shear of a longer axis a and a shorter one b the difference between the two
/// sides on a counts with s = (L_b/L_a)^2 only (L the lengths of the cell):
///
///   W = sum w psi(E) - (1 - s) mu/2 V_+ V_-/(V_+ + V_-) (gamma_+ - gamma_-)^2,   gamma_+- = sum w 2 E_ab / V_+-
///
/// (sums over the corners on one side of a; V_+- their volume). Where one side is missing it is minimised over
/// gamma of that side, as psi is over the columns, so that no energy comes up where a joint leaves: with g = V_+/V of the side that is left
/// - (1 - s)(1 - g)/(1 - (1 - s) g) mu/2 V_+ gamma_+^2. At a face that was free from the start the shear of the other side is
/// that of the whole cell, without any such term. Uniform strain has no difference: all of the above holds. W is positive where it was,
/// and never larger. A lattice of n layers then bends (n^2 - 1)/n^2 + 3 (mu/E') (n - 1)/n^3 times as hard as the solid, flat or not
/// (tests/unit/test_cpl_bending.cpp). Selective reduced integration of finite elements is alike: that would be s = 0, and have
/// modes without energy.
/// Cells of which no side is shorter than 0.99 of another are cubes here.
///
/// A classical variant with normal and shear springs (Cundall and Strack, Geotechnique 29 (1979) 47) would be a
/// file of its own with the same slots and half forces; it needs particle orientations, and torques beside the
/// forces.
///
/// The joint traction is the mean of (F S) N over the corners that share the joint: sum of the two
/// ends' half forces over the joint's area, see corner_areas().
///
/// Patch test (tests/unit/test_cpl_patch.cpp): in any linear displacement field every DE and every
/// inner node of a mixed FE/DE mesh is in balance to rounding for boxes, graded or not, and for
/// parallelepipeds; distorted hexes leave some per cent (0.6, 1.1, 2.3 % rms of sigma d^2 with
/// nodes moved by up to 5, 10, 20 % of the edge).
///
/// Any consistent units. Written for this package: it has no source, but the tests. h_a is not half the joint
/// vector where a DE is on the other side: between elements of different size that misses the
/// border of the element, and boxes graded 2:1 leave 15 % of sigma d^2 in the patch test.

#include "defe/types.h"

#include <cstddef>

namespace defe {

/// Lame constants of the undamaged solid.
struct CornerModuli {
  double lambda, mu;
};

/// lambda of the reduced law S = lambda_e tr(E) I + 2 mu E at a corner where `joints` of three
/// joints are present: 3 lambda (solid), 2 plane stress, 1 uniaxial (E - 2 mu), 0 zero.
double reduced_lambda(const CornerModuli &moduli, int joints);

/// Eight DEs beside each other in a lattice: their particles follow one another, and so do those at the other ends of
/// their joints. What belongs to them is then read without asking for each where it is.
struct LatticeRow {
  static constexpr int size = 8;
  int self = -1;                  ///< index of the first one into x; -1: they are no such row
  int nb[6] = {};                 ///< of the other end of its joint; -1: none of them has one there
  int behind[6] = {};             ///< DE at that end
  signed char partner[6] = {};    ///< slot there
  unsigned char slots = 0;        ///< bit s set: they have joints there
};

/// Where half forces are: three numbers for each joint.
struct HalfForces {
  double *first;
  std::ptrdiff_t to_de, to_slot;    ///< numbers from one DE, and slot, to the next

  /// All of a DE beside each other.
  HalfForces(double (*f)[6][3]) : first(reinterpret_cast<double *>(f)), to_de(18), to_slot(3) {}
  /// Those of one slot beside each other, of n DEs. Of a neighbour one alone is asked for: the rest of its own would come
  /// with it, and leave again before its turn.
  HalfForces(double *f, int n) : first(f), to_de(3), to_slot(3 * static_cast<std::ptrdiff_t>(n)) {}
  double *of(int d, int s) const { return first + to_de * d + to_slot * s; }
};

/// DEs whose joints are mutually perpendicular (boxes: cubes or bricks, also graded). All arrays
/// are the caller's; nothing is kept.
struct OrthogonalLattice {
  int n;                           ///< number of DEs
  const int *self;                 ///< [n] index of the DE into x
  const int (*nb)[6];              ///< [n] other end: >= 0 index into x, < 0 index ~nb into points;
                                   ///< ignored where the joint is absent
  const unsigned char *present;    ///< [n] bit s set: slot s is a connective joint
  const double (*len)[6];          ///< [n] reference length of the joint; > 0, also where absent
  const double (*half)[6];         ///< [n] distance to the border of the cell, |GeneralCell::face|,
                                   ///< also where there is a joint: not half of len
  const unsigned char *material;          ///< [n] index into the table of moduli; null: all 0
  const unsigned char *free = nullptr;    ///< [n] as GeneralCell::free; null: none
  const LatticeRow *rows =
      nullptr;    ///< [n / 8] of each eight of them, where they are one; null: not known
};

/// Forces of the corners of every DE of an orthogonal lattice.
///
/// \param x           3 doubles per atom, current positions
/// \param points      3 doubles per tie point, current positions; may be null without ties
/// \param table       moduli by material
/// \param half_force  [n] force on the DE itself by its own four corners at each joint (0 where
///                    absent); the other end takes the opposite. The whole joint force on i is
///                    half_force[i][s] - half_force[j][t], t the other end's slot.
/// \param energy      [n] strain energy of the DE's own corners; may be null
/// \param each_alone  a DE's forces have the same bits whatever DEs are beside it in the list; else those
///                    with all joints take a shorter formula only where all of some have all
/// \return sum of the energies if energy is given, else 0
double corner_strain_orthogonal(const OrthogonalLattice &lattice, const double *x,
                                const double *points, const CornerModuli *table,
                                HalfForces half_force, double *energy, bool each_alone = false);

/// Reference geometry of a DE's cell in any hexahedron.
struct GeneralCell {
  Vec3 dX[6];      ///< joint vector, from the DE to the other end; 0 where there never was one
  Vec3 face[6];    ///< h_a: from the DE to the middle of the quarter of the element's face (outer
                   ///< slots) or mid-section (inner slots)
  unsigned char tie;    ///< bit s set: slot s ends on an element's face
  unsigned char free =
      0;    ///< bit s set: there never was a joint at slot s, it is at the surface of the body
};

/// The cell of a DE as its corners see it if they have a stress where it was placed: that of the stress-free shape
/// (fe/prestress.h). Uniform in the cell, so that all joints at the placed lengths carry exactly that stress.
GeneralCell stress_free_cell(const GeneralCell &placed, const Mat3 &map);

/// What the corners of one DE in any hexahedron need to know of its cell as long as it has these joints: made once, used in many steps.
/// Plain data, 1 kB. Order of components: xx yy zz xy xz yz of the three joints at a corner, by the axes they are on.
struct CornerTable {
  /// Pairs of slots that meet at a corner: each slot with itself, then those of two axes.
  static constexpr int pairs = 18;
  static constexpr unsigned nothing = ~0u;

  unsigned present = nothing;    ///< joints that it is of
  int terms = 0;                 ///< of selective shear; 0 in cubes
  double inverse[6][8];    ///< of the metric of the joints at a corner; of absent joints 1 and 0
  double volume[8], lambda[8];    ///< of the corners
  /// Selective shear (selective_shear.h), summed over corners: times the pairs' strains twice what it takes away is
  /// scale times the square of it.
  double shear[3][pairs], scale[3];

  CornerTable() = default;
  CornerTable(const GeneralCell &, unsigned present, const CornerModuli &);
};

/// Corners of one DE in any hexahedron.
///
/// \param y           current joint vectors x_other - x_self; ignored where absent
/// \param present     bit s set: slot s is a connective joint
/// \param half_force  as above; set for all six slots
/// \return strain energy of the DE's own corners
double corner_strain_general(const GeneralCell &cell, const Vec3 y[6], unsigned present,
                             const CornerModuli &moduli, Vec3 half_force[6]);
/// \param table  of this cell and these moduli
double corner_strain_general(const GeneralCell &cell, const CornerTable &table, const Vec3 y[6],
                             const CornerModuli &moduli, Vec3 half_force[6]);

/// Reference area vectors (outward) that go with the half forces: uniform stress sigma at small
/// strain gives half_force[s] = sigma * half_area[s] at a DE with all joints present. The area of
/// a joint is the sum over its two ends (opposite signs); a tie's is that of its DE alone.
void corner_areas(const GeneralCell &cell, unsigned present, Vec3 half_area[6]);

/// Whether the cell may be handed to corner_strain_orthogonal with len = |dX| and
/// half = |face|: the vectors of different axes are perpendicular within tol (cosine).
bool is_orthogonal(const GeneralCell &cell, double tol = 1e-9);

/// Stable step of a cubic lattice of spacing d and infinite extent: 2 / omega_max, exact.
/// For nu <= 1/3 this is d / sqrt((lambda + 4 mu) / rho); above, a longer wave is faster.
double lattice_critical_step(double d, const CornerModuli &moduli, double rho);

/// Safe stable step from the neighbourhood of one DE, at the reference state: the least over all
/// DEs, and over half of fe::critical_step of the elements with ties (the ties take up to three
/// quarters of their mass), is stable for the whole. A proven bound, see critical_step.cpp: exact
/// for the cubic lattice if nu <= 1/3 (7 % low at nu = 0.4), 15 to 28 % low where there are ties.
/// (The ties' true effect on the step is 1 % or less for nu up to 0.3, 4 % at 0.4.)
///
/// \param mass           of the DE
/// \param present        joints that are present; fewer joints never shorten the true step
/// \param neighbor_mass  [6] mass of the DE at the other end; for a tie m_e/8 of the element behind
///                       it; null: all equal to mass
/// \return step; infinite without joints; 0 for cells so skew that the bound has no meaning
double lattice_critical_step(const GeneralCell &cell, unsigned present, const CornerModuli &moduli,
                             double mass, const double *neighbor_mass = nullptr);

/// The same where joints soften: as stiff along their planes as across, k = (lambda + 2 mu) area/length, as a joint that a
/// crack cuts can be (crack_softening.h). Of springs alone it is a bound, sqrt(2 m / sum k): each joint takes that share of
/// its DEs' masses; 0.76 of the lattice's step in cubes, 0.89 in flat cells of 2:1. With corners and rotations beside
/// them it is found by trying: bodies that the law has cracked have 1.19 times that and more (600 bodies), those in which a tenth
/// to nine tenths of the joints are cut at random 0.93 (CrackSoftening.StableStep...).
double softening_critical_step(const GeneralCell &cell, unsigned present,
                               const CornerModuli &moduli, double mass);

}    // namespace defe

#endif
