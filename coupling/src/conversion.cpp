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

Vec3 place_of_de(const fe::HexCoords &x, int place, ElementSplit split)
{
  return fe::interpolate(x, split.centre(place));
}

std::vector<NewDE> convert_hex(const fe::HexCoords &X, const fe::HexCoords &x,
                               const fe::HexCoords &v, double mass, ElementSplit split)
{
  std::vector<NewDE> result(split.des());
  const double half = split.half();
  for (int k = 0; k < split.des(); ++k) {
    NewDE &de = result[k];
    const Vec3 centre = split.centre(k);
    de.place = k;
    de.X = fe::interpolate(X, centre);
    de.x = fe::interpolate(x, centre);
    de.v = fe::interpolate(v, centre);
    de.mass = mass / split.des();

    // jacobian(v) = dv/dxi
    const Mat3 L = fe::jacobian(v, centre) * fe::jacobian(x, centre).inverse();
    de.omega = 0.5 * Vec3(L(2, 1) - L(1, 2), L(0, 2) - L(2, 0), L(1, 0) - L(0, 1));

    // A part of a trilinear hexahedron between natural coordinate planes is one itself.
    fe::HexCoords cell, now;
    for (int m = 0; m < 8; ++m) {
      cell.col(m) = fe::interpolate(X, centre + half * corner_of(m));
      now.col(m) = fe::interpolate(x, centre + half * corner_of(m));
    }
    de.volume = fe::volume(cell);
    de.radius = 0.5 * std::cbrt(de.volume);
    for (int s = 0; s < 6; ++s) {
      Vec3 patch[4], middle = centre;
      for (int m = 0; m < 4; ++m) patch[m] = cell.col(fe::hex_face[s][m]);
      middle[s / 2] += s % 2 ? half : -half;
      de.face[s] = fe::interpolate(X, middle) - de.X;
      de.area_normal[s] = facet_area_vector(patch);
      de.area[s] = de.area_normal[s].norm();
      for (int m = 0; m < 4; ++m) patch[m] = now.col(fe::hex_face[s][m]);
      de.reach[s] = (fe::interpolate(x, middle) - de.x).dot(facet_area_vector(patch).normalized());
    }
  }
  return result;
}

GeneralCell cell_of(const std::vector<NewDE> &all, int place, ElementSplit split)
{
  GeneralCell cell;
  cell.tie = cell.free = 0;
  for (int s = 0; s < 6; ++s) {
    cell.face[s] = all[place].face[s];
    if (split.outer(place, s))
      cell.dX[s].setZero();
    else
      cell.dX[s] = all[split.beside(place, s)].X - all[place].X;
  }
  return cell;
}

double tie_rotation(const Vec3 &X, const Vec3 &x, const Vec3 face_X[4], const Vec3 face_x[4],
                    TieSpot spot)
{
  Vec3 along[2];
  double length = 0.0;
  for (int now = 0; now < 2; ++now) {
    const Vec3 *p = now ? face_x : face_X;
    Vec3 tie = now ? -x : -X;
    for (int k = 0; k < 4; ++k) tie += weights_of(spot)[k] * p[k];
    // two lines on the face that are the same ones from either side
    const bool edge = spot == TieSpot::EDGE;
    const Vec3 first = edge ? Vec3((p[1] - p[0]) + (p[2] - p[3])) : Vec3(p[1] - p[3]);
    const Vec3 second = edge ? Vec3((p[2] - p[1]) + (p[3] - p[0])) : Vec3(p[2] - p[0]);
    const Vec3 t1 = first.normalized();
    const Vec3 n = t1.cross(second).normalized();
    along[now] = Vec3(tie.dot(t1), tie.dot(n.cross(t1)), 0.0);
    if (!now) length = tie.norm();
  }
  return (along[1] - along[0]).norm() / length;
}

double conversion_kinetic_loss(const fe::HexCoords &v, double mass, const std::vector<NewDE> &all)
{
  double loss = 0.0;
  std::size_t k = 0;
  const auto take = [&](const NewDE &d) {
    loss -= 0.5 * d.mass * (d.v.squaredNorm() + 0.4 * d.radius * d.radius * d.omega.squaredNorm());
  };
  for (; k < 8; ++k) {
    loss += 0.5 * mass / 8.0 * v.col(static_cast<int>(k)).squaredNorm();
    if (k < all.size()) take(all[k]);
  }
  for (; k < all.size(); ++k) take(all[k]);
  return loss;
}

}    // namespace defe
