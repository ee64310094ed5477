#include "defe/coupling/joint_lattice.h"

#include "defe/coupling/conversion.h"

#include <Eigen/LU>
#include <Eigen/SVD>

namespace defe {

void tie_points(int n, const int (*node)[4], const TieSpot *spot, const double *x, double *point)
{
  for (int t = 0; t < n; t++) {
    const double *w = weights_of(spot[t]);
    const double *p[4];
    for (int a = 0; a < 4; a++) p[a] = x + 3 * static_cast<std::ptrdiff_t>(node[t][a]);
    for (int k = 0; k < 3; k++)
      point[3 * t + k] = w[0] * p[0][k] + w[1] * p[1][k] + w[2] * p[2][k] + w[3] * p[3][k];
  }
}

void corner_half_forces(const OrthogonalLattice &lattice, int n, const GeneralCell *cell,
                        CornerTable *kept, const double *x, const double *points,
                        const CornerModuli *table, bool each_alone, HalfForces half_force,
                        double *energy)
{
  if (lattice.n > 0)
    corner_strain_orthogonal(lattice, x, points, table, half_force, energy, each_alone);
  for (int d = lattice.n; d < n; d++) {
    const double *xi = x + 3 * static_cast<std::ptrdiff_t>(lattice.self[d]);
    Vec3 y[6], hf[6];
    for (int s = 0; s < 6; s++) {
      const std::ptrdiff_t nb = lattice.nb[d][s];
      const double *p = nb >= 0 ? x + 3 * nb : points + 3 * ~nb;
      y[s] = Vec3(p[0] - xi[0], p[1] - xi[1], p[2] - xi[2]);
    }
    const GeneralCell &c = cell[d - lattice.n];
    const CornerModuli &moduli = table[lattice.material[d]];
    CornerTable &of_cell = kept[d - lattice.n];
    if (of_cell.present != lattice.present[d]) of_cell = CornerTable(c, lattice.present[d], moduli);
    energy[d] = corner_strain_general(c, of_cell, y, moduli, hf);
    for (int s = 0; s < 6; s++)
      for (int k = 0; k < 3; k++) half_force.of(d, s)[k] = hf[s][k];
  }
}

Vec3 turned_normal(const GeneralCell &cell, unsigned present, const Vec3 y[6], const Vec3 &normal,
                   const Vec3 &along)
{
  Mat3 A = Mat3::Zero();
  for (int q = 0; q < 6; q++)
    if (present & (1u << q)) A += y[q] * cell.dX[q].transpose();
  const Eigen::JacobiSVD<Mat3> svd(A, Eigen::ComputeFullU | Eigen::ComputeFullV);
  if (svd.singularValues()[1] <= 1e-6 * svd.singularValues()[0]) return along;
  Mat3 U = svd.matrixU();
  if ((U * svd.matrixV().transpose()).determinant() < 0.0) U.col(2) *= -1.0;
  return U * svd.matrixV().transpose() * normal;
}

TiePoint::TiePoint(const Vec3 &de, const Vec3 face[4], TieSpot spot) : weight_(weights_of(spot))
{
  Vec3 point = Vec3::Zero(), middle = Vec3::Zero();
  for (int a = 0; a < 4; a++) {
    point += weight_[a] * face[a];
    middle += 0.25 * face[a];
  }
  y_ = point - de;
  normal_ = (face[2] - face[0]).cross(face[3] - face[1]).normalized();
  if (normal_.dot(y_) < 0.0) normal_ = -normal_;
  // of the four nodes, and its inverse by the adjugate: both are symmetric
  double xx = 0.0, yy = 0.0, zz = 0.0, xy = 0.0, xz = 0.0, yz = 0.0;
  for (int a = 0; a < 4; a++) {
    const Vec3 r = arm_[a] = face[a] - middle;
    const double square = r.squaredNorm();
    xx += square - r[0] * r[0];
    yy += square - r[1] * r[1];
    zz += square - r[2] * r[2];
    xy -= r[0] * r[1];
    xz -= r[0] * r[2];
    yz -= r[1] * r[2];
  }
  const double cxx = yy * zz - yz * yz, cxy = xz * yz - xy * zz, cxz = xy * yz - xz * yy;
  const double by = 1.0 / (cxx * xx + cxy * xy + cxz * xz);
  const double ixy = cxy * by, ixz = cxz * by, iyz = (xy * xz - xx * yz) * by;
  inertia_inverse_ << cxx * by, ixy, ixz, ixy, (xx * zz - xz * xz) * by, iyz, ixz, iyz,
      (xx * yy - xy * xy) * by;
}

Vec3 TiePoint::slide(const Vec3 &de, const Vec3 face[4]) const
{
  Vec3 slide = -de, spin = Vec3::Zero();
  for (int a = 0; a < 4; a++) {
    slide += weight_[a] * face[a];
    spin += arm_[a].cross(face[a]);
  }
  slide -= (inertia_inverse_ * spin).cross(y_);
  slide -= slide.dot(normal_) * normal_;
  return slide;
}

void TiePoint::reactions(const Vec3 &force, Vec3 on_node[4]) const
{
  const Vec3 turn = inertia_inverse_ * y_.cross(force);
  for (int a = 0; a < 4; a++) on_node[a] = turn.cross(arm_[a]) - weight_[a] * force;
}

}    // namespace defe
