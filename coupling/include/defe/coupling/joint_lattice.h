#ifndef DEFE_COUPLING_JOINT_LATTICE_H
#define DEFE_COUPLING_JOINT_LATTICE_H

/// \file
/// Joints and ties of all DEs of a rank on plain arrays: corner strains (corner_strain.h) of orthogonal and of other
/// cells, the points at which ties end on faces of elements, and how a tie carries force and moment.

#include "defe/coupling/corner_strain.h"
#include "defe/coupling/element_split.h"

namespace defe {

/// Points on faces: n times 3 doubles, from the faces' nodes in the order of TieSpot.
void tie_points(int n, const int (*node)[4], const TieSpot *, const double *x, double *point);

/// Half forces and energies of `n` DEs, of which the first lattice.n have orthogonal cells; its arrays are as long as
/// all, and so are half_force and energy.
/// \param cell  [n - lattice.n] of the others
/// \param kept  [n - lattice.n] their tables, made anew here where joints are not those that they are of
void corner_half_forces(const OrthogonalLattice &lattice, int n, const GeneralCell *cell,
                        CornerTable *kept, const double *x, const double *points,
                        const CornerModuli *table, bool each_alone, HalfForces half_force,
                        double *energy);

/// Normal of the face that a joint crosses, turned as the DE's joints are (the rotation that fits them best).
/// \param y       current joint vectors, of those that are present
/// \param normal  in the reference configuration
/// \param along   what is returned if the joints do not tell a rotation
Vec3 turned_normal(const GeneralCell &cell, unsigned present, const Vec3 y[6], const Vec3 &normal,
                   const Vec3 &along);

/// A tie that has left the corner strains, and the face that it ends on, as they are now. Its arm y turns with the face
/// (least squares over the four nodes), and the face takes the moment y x F as forces on them, so that angular
/// momentum is kept and no work is lost. Where neighbours carry the same shear these forces cancel. The DE cannot
/// take the moment: nothing holds its spin, it would roll away under any shear.
class TiePoint {
 public:
  /// \param face  nodes in the order of TieSpot
  TiePoint(const Vec3 &de, const Vec3 face[4], TieSpot = TieSpot::QUARTER);

  const Vec3 &y() const { return y_; }              ///< from the DE to the point on the face
  const Vec3 &normal() const { return normal_; }    ///< of the face, out of the DE
  double length() const { return y_.dot(normal_); }

  /// Velocity of the face against the DE, along the face.
  Vec3 slide(const Vec3 &de, const Vec3 face[4]) const;
  /// What the four nodes take of this force on the DE.
  void reactions(const Vec3 &force, Vec3 on_node[4]) const;

 private:
  Vec3 y_, normal_;
  Vec3 arm_[4];    // nodes, from their middle
  const double *weight_;
  Mat3 inertia_inverse_;
};

}    // namespace defe

#endif
