#include "defe/coupling/facet.h"

#include <Eigen/Geometry>

#include <algorithm>
#include <cfloat>
#include <cmath>
#include <cstddef>

namespace defe {

void facet_shape(double xi, double eta, double N[4])
{
  N[0] = 0.25 * (1.0 - xi) * (1.0 - eta);
  N[1] = 0.25 * (1.0 + xi) * (1.0 - eta);
  N[2] = 0.25 * (1.0 + xi) * (1.0 + eta);
  N[3] = 0.25 * (1.0 - xi) * (1.0 + eta);
}

Vec3 facet_area_vector(const Vec3 node[4])
{
  return 0.5 * (node[2] - node[0]).cross(node[3] - node[1]);
}

double FacetPlane::half_xi() const
{
  return std::sqrt(area / bb);
}

double FacetPlane::half_eta() const
{
  return std::sqrt(area / aa);
}

bool FacetPlane::out_of_reach(const Vec3 &p, double r, double depth, double aside,
                              double drift) const
{
  const Vec3 del = p - mid;
  const double height = del.dot(normal);
  const double xi = std::abs(del.dot(to_xi)), eta = std::abs(del.dot(to_eta));
  // a place on the plane moves with mid + xi a + eta b
  const double moved = 0.5 * drift * (2.0 + xi + eta);
  if (height > r + moved || -height > depth + moved) return true;
  return (xi - 1.0) * half_xi() > aside + moved || (eta - 1.0) * half_eta() > aside + moved;
}

void facet_planes(int n, const int (*node)[4], const double *x, FacetPlane *plane)
{
  constexpr int W = 8;    // facets side by side
  double p[4][3][W], mid[3][W], a[3][W], b[3][W], normal[3][W], to_xi[3][W], to_eta[3][W];
  double aa[W], bb[W], area[W];
  for (int first = 0; first < n; first += W) {
    const int count = std::min(W, n - first);
    for (int l = 0; l < W; ++l) {
      const int *nodes = node[first + std::min(l, count - 1)];
      for (int m = 0; m < 4; ++m)
        for (int k = 0; k < 3; ++k) p[m][k][l] = x[3 * static_cast<std::ptrdiff_t>(nodes[m]) + k];
    }
    for (int l = 0; l < W; ++l) {
      for (int k = 0; k < 3; ++k) {
        mid[k][l] = 0.25 * (p[0][k][l] + p[1][k][l] + p[2][k][l] + p[3][k][l]);
        a[k][l] = 0.25 * (p[1][k][l] + p[2][k][l] - p[0][k][l] - p[3][k][l]);
        b[k][l] = 0.25 * (p[2][k][l] + p[3][k][l] - p[0][k][l] - p[1][k][l]);
      }
      const double a0 = a[0][l], a1 = a[1][l], a2 = a[2][l];
      const double b0 = b[0][l], b1 = b[1][l], b2 = b[2][l];
      const double n0 = a1 * b2 - a2 * b1, n1 = a2 * b0 - a0 * b2, n2 = a0 * b1 - a1 * b0;
      const double ab = a0 * b0 + a1 * b1 + a2 * b2;
      aa[l] = a0 * a0 + a1 * a1 + a2 * a2;
      bb[l] = b0 * b0 + b1 * b1 + b2 * b2;
      area[l] = n0 * n0 + n1 * n1 + n2 * n2;
      const double inverse = 1.0 / std::max(area[l], DBL_MIN);
      const double unit = std::sqrt(inverse);
      normal[0][l] = n0 * unit;
      normal[1][l] = n1 * unit;
      normal[2][l] = n2 * unit;
      for (int k = 0; k < 3; ++k) {
        to_xi[k][l] = inverse * (bb[l] * a[k][l] - ab * b[k][l]);
        to_eta[k][l] = inverse * (aa[l] * b[k][l] - ab * a[k][l]);
      }
    }
    for (int l = 0; l < count; ++l) {
      FacetPlane &g = plane[first + l];
      for (int k = 0; k < 3; ++k) {
        g.mid[k] = mid[k][l];
        g.a[k] = a[k][l];
        g.b[k] = b[k][l];
        g.normal[k] = normal[k][l];
        g.to_xi[k] = to_xi[k][l];
        g.to_eta[k] = to_eta[k][l];
      }
      g.aa = aa[l];
      g.bb = bb[l];
      g.area = area[l];
    }
  }
}

}    // namespace defe
