#include "defe/coupling/facet.h"

#include <Eigen/Geometry>

#include <algorithm>
#include <cfloat>
#include <cmath>
#include <cstddef>

namespace defe {

namespace {

  /// x(xi, eta) = c[0] + xi c[1] + eta c[2] + xi eta c[3]
  struct Bilinear {
    Vec3 c[4];

    explicit Bilinear(const Vec3 x[4])
    {
      c[0] = 0.25 * (x[0] + x[1] + x[2] + x[3]);
      c[1] = 0.25 * (-x[0] + x[1] + x[2] - x[3]);
      c[2] = 0.25 * (-x[0] - x[1] + x[2] + x[3]);
      c[3] = 0.25 * (x[0] - x[1] + x[2] - x[3]);
    }
    Vec3 point(double xi, double eta) const { return c[0] + xi * c[1] + eta * (c[2] + xi * c[3]); }
    Vec3 along_xi(double eta) const { return c[1] + eta * c[3]; }
    Vec3 along_eta(double xi) const { return c[2] + xi * c[3]; }
    Vec3 normal(double xi, double eta) const
    {
      const Vec3 n = along_xi(eta).cross(along_eta(xi));
      const double length = n.norm();
      return length > 0.0 ? Vec3(n / length) : Vec3(Vec3::Zero());
    }
  };

  /// Least distance inside the square. Newton's method on f = |p - x|^2/2, with Gauss and Newton's
  /// matrix where the true one is not positive, steps cut at the border and halved until f falls.
  /// Returns false if the search ends on the border (the edges then have the answer).
  bool closest_inside(const Vec3 &p, const Bilinear &facet, double &xi, double &eta)
  {
    xi = eta = 0.0;
    Vec3 r = p - facet.c[0];
    for (int iteration = 0; iteration < 50; ++iteration) {
      const Vec3 a = facet.along_xi(eta), b = facet.along_eta(xi);
      double descent_xi = r.dot(a), descent_eta = r.dot(b);
      const double aa = a.squaredNorm(), bb = b.squaredNorm();
      double ab = a.dot(b) - r.dot(facet.c[3]);
      if (ab * ab >= 0.99 * aa * bb) ab = a.dot(b);

      // on the border and pushed outward: slide along it
      const bool stop_xi = std::abs(xi) == 1.0 && xi * descent_xi >= 0.0;
      const bool stop_eta = std::abs(eta) == 1.0 && eta * descent_eta >= 0.0;
      if (stop_xi) descent_xi = ab = 0.0;
      if (stop_eta) descent_eta = ab = 0.0;
      const double det = aa * bb - ab * ab;
      if (!(det > 1e-20 * aa * bb)) return false;    // no area
      const double dxi = (bb * descent_xi - ab * descent_eta) / det;
      const double deta = (aa * descent_eta - ab * descent_xi) / det;

      // Close to the minimum rounding hides the descent: short steps are taken as they are.
      const bool close = std::abs(dxi) < 1e-6 && std::abs(deta) < 1e-6;
      const double f = r.squaredNorm();
      double new_xi, new_eta, step = 1.0;
      Vec3 new_r;
      for (;; step *= 0.5) {
        new_xi = std::clamp(xi + step * dxi, -1.0, 1.0);
        new_eta = std::clamp(eta + step * deta, -1.0, 1.0);
        new_r = p - facet.point(new_xi, new_eta);
        if (close || new_r.squaredNorm() <= f || step < 1e-6) break;
      }
      const double moved = std::max(std::abs(new_xi - xi), std::abs(new_eta - eta));
      xi = new_xi;
      eta = new_eta;
      r = new_r;
      if (moved < 1e-6) break;    // the next step would be its square
    }
    constexpr double inside = 1.0 - 1e-10;
    return std::abs(xi) < inside && std::abs(eta) < inside;
  }

}    // namespace

void facet_shape(double xi, double eta, double N[4])
{
  N[0] = 0.25 * (1.0 - xi) * (1.0 - eta);
  N[1] = 0.25 * (1.0 + xi) * (1.0 - eta);
  N[2] = 0.25 * (1.0 + xi) * (1.0 + eta);
  N[3] = 0.25 * (1.0 - xi) * (1.0 + eta);
}

Vec3 facet_point(const Vec3 node[4], double xi, double eta)
{
  return Bilinear(node).point(xi, eta);
}

Vec3 facet_area_vector(const Vec3 node[4])
{
  return 0.5 * (node[2] - node[0]).cross(node[3] - node[1]);
}

double facet_area(const Vec3 node[4])
{
  const Bilinear facet(node);
  const double g = 1.0 / std::sqrt(3.0);
  double area = 0.0;
  for (double xi : {-g, g})
    for (double eta : {-g, g}) area += facet.along_xi(eta).cross(facet.along_eta(xi)).norm();
  return area;
}

Vec3 facet_normal(const Vec3 node[4], double xi, double eta)
{
  return Bilinear(node).normal(xi, eta);
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
  double warp[W], aa[W], bb[W], area[W];
  for (int first = 0; first < n; first += W) {
    const int count = std::min(W, n - first);
    for (int l = 0; l < W; ++l) {
      const int *nodes = node[first + std::min(l, count - 1)];
      for (int m = 0; m < 4; ++m)
        for (int k = 0; k < 3; ++k) p[m][k][l] = x[3 * static_cast<std::ptrdiff_t>(nodes[m]) + k];
    }
    for (int l = 0; l < W; ++l) {
      double skew[3];
      for (int k = 0; k < 3; ++k) {
        mid[k][l] = 0.25 * (p[0][k][l] + p[1][k][l] + p[2][k][l] + p[3][k][l]);
        a[k][l] = 0.25 * (p[1][k][l] + p[2][k][l] - p[0][k][l] - p[3][k][l]);
        b[k][l] = 0.25 * (p[2][k][l] + p[3][k][l] - p[0][k][l] - p[1][k][l]);
        skew[k] = 0.25 * (p[0][k][l] - p[1][k][l] + p[2][k][l] - p[3][k][l]);
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
      warp[l] = std::abs(skew[0] * normal[0][l] + skew[1] * normal[1][l] + skew[2] * normal[2][l]);
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
      g.warp = warp[l];
      g.aa = aa[l];
      g.bb = bb[l];
      g.area = area[l];
    }
  }
}

FacetPoint closest_point(const Vec3 &p, const Vec3 node[4])
{
  FacetPoint r;
  r.feature = FacetFeature::face;
  r.which = 0;
  const Bilinear facet(node);
  if (closest_inside(p, facet, r.xi, r.eta)) {
    r.closest = facet.point(r.xi, r.eta);
  } else {
    double best = -1.0;
    for (int e = 0; e < 4; ++e) {
      const Vec3 edge = node[(e + 1) % 4] - node[e];
      const double length2 = edge.squaredNorm();
      const double along = edge.dot(p - node[e]);
      const double t = along <= 0.0 ? 0.0 : (along >= length2 ? 1.0 : along / length2);
      const Vec3 point = t == 1.0 ? node[(e + 1) % 4] : Vec3(node[e] + t * edge);
      const double distance2 = (p - point).squaredNorm();
      if (best >= 0.0 && distance2 >= best) continue;
      best = distance2;
      r.closest = point;
      const double natural[4][2] = {
          {2.0 * t - 1.0, -1.0}, {1.0, 2.0 * t - 1.0}, {1.0 - 2.0 * t, 1.0}, {-1.0, 1.0 - 2.0 * t}};
      r.xi = natural[e][0];
      r.eta = natural[e][1];
      const bool vertex = t == 0.0 || t == 1.0;
      r.feature = vertex ? FacetFeature::vertex : FacetFeature::edge;
      r.which = vertex ? (t == 0.0 ? e : (e + 1) % 4) : e;
    }
  }
  facet_shape(r.xi, r.eta, r.N);
  r.normal = facet.normal(r.xi, r.eta);
  const Vec3 from = p - r.closest;
  r.distance = std::copysign(from.norm(), from.dot(r.normal) < 0.0 ? -1.0 : 1.0);
  return r;
}

FacetPoint project_point(const Vec3 &p, const Vec3 node[4], double xi, double eta)
{
  const Bilinear facet(node);
  FacetPoint r;
  r.xi = std::clamp(xi, -2.0, 2.0);
  r.eta = std::clamp(eta, -2.0, 2.0);
  for (int iteration = 0; iteration < 20; ++iteration) {
    const Vec3 a = facet.along_xi(r.eta), b = facet.along_eta(r.xi);
    const Vec3 off = p - facet.point(r.xi, r.eta);
    const double ra = off.dot(a), rb = off.dot(b);
    const double aa = a.squaredNorm(), bb = b.squaredNorm();
    const double ab = a.dot(b) - off.dot(facet.c[3]);
    const double det = aa * bb - ab * ab;
    if (!(det > 1e-20 * aa * bb)) break;    // no area, or beyond the radius of curvature
    const double dxi = (bb * ra - ab * rb) / det, deta = (aa * rb - ab * ra) / det;
    r.xi = std::clamp(r.xi + dxi, -2.0, 2.0);
    r.eta = std::clamp(r.eta + deta, -2.0, 2.0);
    // the next step would be the square of this one, times how far the facet is from a parallelogram
    const double step = std::abs(dxi) + std::abs(deta), square = step * step;
    if (step < 0.1 && square * square * facet.c[3].squaredNorm() < 1e-28 * std::min(aa, bb)) break;
  }
  r.closest = facet.point(r.xi, r.eta);
  facet_shape(r.xi, r.eta, r.N);
  r.normal = facet.normal(r.xi, r.eta);
  const bool on = std::abs(r.xi) <= 1.0 && std::abs(r.eta) <= 1.0;
  r.feature = on ? FacetFeature::face : FacetFeature::edge;
  r.which = 0;
  const Vec3 off = p - r.closest;
  r.distance = std::copysign(off.norm(), off.dot(r.normal) < 0.0 ? -1.0 : 1.0);
  return r;
}

}    // namespace defe
