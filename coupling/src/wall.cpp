#include "defe/coupling/wall.h"

#include "defe/coupling/facet.h"

#include <algorithm>
#include <cmath>

namespace defe {

double wall_face(const Vec3 node[4], const double depth[4], const Vec3 normal[4], double k_area,
                 Vec3 force[4], double push[4])
{
  for (int a = 0; a < 4; a++) {
    force[a].setZero();
    push[a] = 0.0;
  }
  const Vec3 area = facet_area_vector(node);
  const Vec3 d02 = node[2] - node[0], d13 = node[3] - node[1];    // A = 1/2 d02 x d13
  double energy = 0.0;
  for (int a = 0; a < 4; a++) {
    const double seen = -area.dot(normal[a]);
    if (depth[a] <= 0.0 || seen <= 0.0) continue;
    push[a] = 0.25 * k_area * seen * depth[a];
    force[a] += push[a] * normal[a];

    // the area seen grows when the face is stretched along the wall: that takes energy, too
    const double per_area = 0.125 * k_area * depth[a] * depth[a];
    energy += per_area * seen;
    const Vec3 by_d02 = 0.5 * per_area * d13.cross(normal[a]);
    const Vec3 by_d13 = 0.5 * per_area * normal[a].cross(d02);
    force[2] += by_d02;
    force[0] -= by_d02;
    force[3] += by_d13;
    force[1] -= by_d13;
  }
  return energy;
}

Vec3 wall_friction(const Vec3 &velocity, const Vec3 &normal, double push, double mu, double viscous,
                   double &power)
{
  power = 0.0;
  const Vec3 slip = velocity - velocity.dot(normal) * normal;
  const double speed = slip.norm();
  if (!(speed > 0.0)) return Vec3::Zero();
  const double drag = std::min(mu * push, viscous * speed);
  power = drag * speed;
  return -drag / speed * slip;
}

}    // namespace defe
