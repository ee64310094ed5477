#include "defe/coupling/conversion.h"

#include "defe/coupling/facet.h"
#include "defe/fe/hex8.h"

#include <Eigen/LU>
#include <cmath>

namespace defe {

namespace {

  Vec3 corner_of(int node)
  {
    return Vec3(fe::hex_sign[node][0], fe::hex_sign[node][1], fe::hex_sign[node][2]);
  }

}    // namespace

Vec3 place_of_de(const fe::HexCoords &x, int node)
{
  return fe::interpolate(x, 0.5 * corner_of(node));
}

std::array<NewDE, 8> convert_hex(const fe::HexCoords &X, const fe::HexCoords &x,
                                 const fe::HexCoords &v, double mass)
{
  std::array<NewDE, 8> result;
  for (int k = 0; k < 8; ++k) {
    NewDE &de = result[k];
    const Vec3 centre = 0.5 * corner_of(k);
    de.node = k;
    de.X = fe::interpolate(X, centre);
    de.x = fe::interpolate(x, centre);
    de.v = fe::interpolate(v, centre);
    de.mass = mass / 8.0;

    // jacobian(v) = dv/dxi
    const Mat3 L = fe::jacobian(v, centre) * fe::jacobian(x, centre).inverse();
    de.omega = 0.5 * Vec3(L(2, 1) - L(1, 2), L(0, 2) - L(2, 0), L(1, 0) - L(0, 1));

    // A part of a trilinear hexahedron between natural coordinate planes is one itself.
    fe::HexCoords eighth, now;
    for (int m = 0; m < 8; ++m) {
      eighth.col(m) = fe::interpolate(X, centre + 0.5 * corner_of(m));
      now.col(m) = fe::interpolate(x, centre + 0.5 * corner_of(m));
    }
    de.volume = fe::volume(eighth);
    de.radius = 0.5 * std::cbrt(de.volume);
    for (int s = 0; s < 6; ++s) {
      Vec3 patch[4], middle = centre;
      for (int m = 0; m < 4; ++m) patch[m] = eighth.col(fe::hex_face[s][m]);
      middle[s / 2] += s % 2 ? 0.5 : -0.5;
      de.face[s] = fe::interpolate(X, middle) - de.X;
      de.area_normal[s] = facet_area_vector(patch);
      de.area[s] = de.area_normal[s].norm();
      for (int m = 0; m < 4; ++m) patch[m] = now.col(fe::hex_face[s][m]);
      de.reach[s] = (fe::interpolate(x, middle) - de.x).dot(facet_area_vector(patch).normalized());
    }
  }
  return result;
}

GeneralCell cell_of(const std::array<NewDE, 8> &de, int k)
{
  GeneralCell cell;
  cell.tie = 0;
  for (int s = 0; s < 6; ++s) {
    cell.face[s] = de[k].face[s];
    if (slot_is_outer(k, s))
      cell.dX[s].setZero();
    else
      cell.dX[s] = de[fe::hex_edge_neighbor(k, s / 2)].X - de[k].X;
  }
  return cell;
}

double tie_rotation(const Vec3 &X, const Vec3 &x, const Vec3 face_X[4], const Vec3 face_x[4])
{
  Vec3 along[2];
  double length = 0.0;
  for (int now = 0; now < 2; ++now) {
    const Vec3 *p = now ? face_x : face_X;
    Vec3 tie = now ? -x : -X;
    for (int k = 0; k < 4; ++k) tie += tie_weight[k] * p[k];
    const Vec3 t1 = (p[1] - p[3]).normalized();
    const Vec3 n = t1.cross(p[2] - p[0]).normalized();
    along[now] = Vec3(tie.dot(t1), tie.dot(n.cross(t1)), 0.0);
    if (!now) length = tie.norm();
  }
  return (along[1] - along[0]).norm() / length;
}

double conversion_kinetic_loss(const fe::HexCoords &v, double mass, const std::array<NewDE, 8> &de)
{
  double loss = 0.0;
  for (int k = 0; k < 8; ++k) {
    const NewDE &d = de[k];
    loss += 0.5 * mass / 8.0 * v.col(k).squaredNorm();
    loss -= 0.5 * d.mass * (d.v.squaredNorm() + 0.4 * d.radius * d.radius * d.omega.squaredNorm());
  }
  return loss;
}

}    // namespace defe
