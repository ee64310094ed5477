#ifndef DEFE_COUPLING_WALL_H
#define DEFE_COUPLING_WALL_H

/// \file
/// Contact with a fixed rigid wall by penalty: faces of elements, and spheres.

#include "defe/types.h"

namespace defe {

/// A face of an element against a wall. The wall presses on each node with the pressure k_area times its
/// depth, over a quarter of the area of the face that the wall sees, i.e. of its projection onto the
/// wall. Energy = 1/2 k_area sum_a P_a/4 depth_a^2 with P_a = max(0, -A.normal_a), A = area vector of
/// the face; the forces are its exact gradient as long as the wall is plane, so a body may turn on the
/// wall without gaining or losing energy.
/// \param node    four nodes, counter-clockwise seen from outside
/// \param depth   of each node in the wall, positive inside
/// \param normal  unit normals of the wall near each node, out of the wall
/// \param k_area  see penalty_stiffness_per_area()
/// \param force   on the nodes; set
/// \param push    normal force of each node, for friction; set
/// \return        the energy
double wall_face(const Vec3 node[4], const double depth[4], const Vec3 normal[4], double k_area,
                 Vec3 force[4], double push[4]);

/// Friction of something that slides on a wall, without memory: Coulomb's limit mu times push, and less
/// where it hardly slides: a viscous force, of `viscous` times the velocity. Creeps where Coulomb's
/// friction would hold.
/// \param velocity  of the point of contact; its part along the normal is left out
/// \param power     set to what is lost per time
Vec3 wall_friction(const Vec3 &velocity, const Vec3 &normal, double push, double mu, double viscous,
                   double &power);

}    // namespace defe

#endif
