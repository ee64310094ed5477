#ifndef DEFE_COUPLING_CONVERSION_H
#define DEFE_COUPLING_CONVERSION_H

/// \file
/// Conversion of one hexahedron into discrete elements: eight, or as its ElementSplit says.
///
/// Each starts at the middle of its cell of the element.
/// Conserved: mass and linear momentum to rounding; strain energy and all forces where the strain
/// is uniform. Not conserved: of the velocity gradient within the element, kinetic energy and
/// angular momentum. The lumped element carries m/8 at each corner, eight DEs carry it at half the
/// distance from the centre: for a cube of edge h that turns as a rigid body the moment of inertia
/// falls from m h^2/2 (lumped) to m h^2/8, plus m h^2/40 of the spins (the solid has m h^2/6), and
/// of a uniform velocity gradient a quarter of the kinetic energy is left plus that of the spins (of 27 DEs 8/27, of a
/// single one nothing).
/// See conversion_kinetic_loss() for the energy ledger.
///
/// Eight DEs for an element: Lei and Zang, Comput. Mech. 46 (2010) 609, and "Adaptive combined DE/FE algorithm for
/// analyzing impact fracture problem" (the paper of the glass beam). Spins and the share of each DE are this
/// package's.

#include <vector>

#include "defe/coupling/corner_strain.h"
#include "defe/coupling/element_split.h"
#include "defe/fe/topology.h"
#include "defe/types.h"

namespace defe {

struct NewDE {
  Vec3 X, x, v;           ///< reference and current position, velocity
  Vec3 omega;             ///< half the curl of the velocity field, in the current configuration
  double mass;            ///< an equal share of the element's
  double radius;          ///< half the cube root of the volume: h/4 for one of eight of a cube
  double volume;          ///< reference volume of the cell, exact
  Vec3 face[6];           ///< reference vector from X to the middle of the cell's patch at the slot
  Vec3 area_normal[6];    ///< reference area vector of the patch, out along the slot
  double area[6];         ///< its length
  double reach[6];        ///< from x to the patch, along its normal, in the current shape
  int place;              ///< in the element, see ElementSplit
};

/// \param X, x, v  reference and current positions and velocities of the element's nodes
/// \param mass     of the element
/// The element must be valid (positive volume of every cell), which create and read check.
std::vector<NewDE> convert_hex(const fe::HexCoords &X, const fe::HexCoords &x,
                               const fe::HexCoords &v, double mass, ElementSplit = ElementSplit());

/// Where a DE of an element is born.
Vec3 place_of_de(const fe::HexCoords &x, int place, ElementSplit = ElementSplit());

/// Cell of a new DE with inner joints to its siblings filled in; outer dX are 0, no ties.
GeneralCell cell_of(const std::vector<NewDE> &all, int place, ElementSplit = ElementSplit());

/// How far a tie has turned on its face: the DE's movement along the face, as seen from the face, by
/// the reference length of the tie. That is the shear strain of a tie whose DE has other joints. A DE
/// whose only joint it is rotates freely about the tie point, since no element resists: the joint
/// that takes the place of the tie at a conversion would be bent from the start.
/// \param X, x            of the DE, reference and current
/// \param face_X, face_x  nodes of the face, from the first one of the TieSpot on; from either side
double tie_rotation(const Vec3 &X, const Vec3 &x, const Vec3 face_X[4], const Vec3 face_x[4],
                    TieSpot = TieSpot::QUARTER);

/// A tie that has turned by more than this many times the strain at which its material converts
/// holds nothing along the face any more: no joint takes its place when the element converts.
constexpr double tie_rotation_limit = 10.0;

/// Kinetic energy of the element's lumped nodes (m/8 each) less that of the DEs, spins included
/// (solid spheres). Negative only for very slender elements that spin about their long axis.
double conversion_kinetic_loss(const fe::HexCoords &v, double mass, const std::vector<NewDE> &);

}    // namespace defe

#endif
