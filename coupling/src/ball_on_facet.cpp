#include "defe/coupling/surface_contact.h"

#include <algorithm>
#include <cmath>
#include <utility>

namespace defe {

namespace {

  constexpr int N = 4;    // Gauss points in each direction
  constexpr double place[N] = {-0.861136311594053, -0.339981043584856, 0.339981043584856,
                               0.861136311594053};
  constexpr double weight[N] = {0.347854845137454, 0.652145154862546, 0.652145154862546,
                                0.347854845137454};

  /// A number and its derivatives by xi, eta and h of the ball's centre.
  struct Moving {
    double value, by[3];
  };
  Moving middle_of(const Moving &lo, const Moving &hi)
  {
    Moving m{0.5 * (lo.value + hi.value), {}};
    for (int j = 0; j < 3; ++j) m.by[j] = 0.5 * (lo.by[j] + hi.by[j]);
    return m;
  }
  Moving half_of(const Moving &lo, const Moving &hi)
  {
    Moving m{0.5 * (hi.value - lo.value), {}};
    for (int j = 0; j < 3; ++j) m.by[j] = 0.5 * (hi.by[j] - lo.by[j]);
    return m;
  }
  /// The facet ends at 1 and -1.
  Moving clipped(const Moving &m, int sign)
  {
    return sign * m.value < 1.0 ? m : Moving{static_cast<double>(sign), {0.0, 0.0, 0.0}};
  }

  /// The disc of the facet's plane that is nearer than R, in natural coordinates.
  struct Disc {
    LocalPoint c;
    double square;            // of its radius
    double xi_xi, eta_eta;    // squares of to_xi and to_eta
    double skew;              // to_xi . to_eta
    double a, b;              // lengths

    Disc(const FacetPlane &g, const LocalPoint &centre, double R) :
        c(centre), square(R * R - c.h * c.h), xi_xi(g.to_xi.squaredNorm()),
        eta_eta(g.to_eta.squaredNorm()), skew(g.to_xi.dot(g.to_eta)), a(g.a.norm()), b(g.b.norm())
    {
    }

    /// Where the part of the disc that lies between eta = -1 and 1 ends along xi. False: there is none.
    bool end(int sign, Moving &to) const
    {
      const double radius = std::sqrt(square), T = std::sqrt(xi_xi);
      const double eta = c.eta + sign * radius * skew / T;    // of the disc's own end
      if (std::abs(eta) <= 1.0) {
        to = {c.xi + sign * radius * T, {1.0, 0.0, -sign * T * c.h / radius}};
      } else {
        const double off = c.eta - std::copysign(1.0, eta);    // from the edge, which cuts it
        const double chord = square - off * off / eta_eta;
        if (chord <= 0.0) return false;
        const double l = std::sqrt(chord);
        to = {c.xi - off * skew / eta_eta + sign * l / a,
              {1.0, -skew / eta_eta - sign * off / (eta_eta * l * a), -sign * c.h / (l * a)}};
      }
      to = clipped(to, sign);
      return true;
    }

    /// The part of the line xi = const that lies in the disc and in the facet. False: there is none.
    bool row(const Moving &xi, Moving &lo, Moving &hi) const
    {
      const double u = xi.value - c.xi, chord = square - u * u / xi_xi;
      if (chord <= 0.0) return false;
      const double l = std::sqrt(chord);
      for (int sign : {-1, 1}) {
        Moving &to = sign < 0 ? lo : hi;
        to.value = c.eta + u * skew / xi_xi + sign * l / b;
        for (int j = 0; j < 3; ++j) {
          const double du = xi.by[j] - (j == 0 ? 1.0 : 0.0);
          const double dl = ((j == 2 ? -c.h : 0.0) - u * du / xi_xi) / l;
          to.by[j] = (j == 1 ? 1.0 : 0.0) + du * skew / xi_xi + sign * dl / b;
        }
        to = clipped(to, sign);
      }
      return lo.value < hi.value;
    }
  };

  /// Weight of a point that is seen from the centre at the cosine c to the normal: a ball that rolls over an edge
  /// gets in front of the next face without noticing.
  Share facing_weight(double c)
  {
    constexpr double full = 0.3;
    if (c >= full) return {1.0, 0.0};
    const double z = c / full;
    return {z * z * (3.0 - 2.0 * z), 6.0 * z * (1.0 - z) / full};
  }

  /// Rows of points over what the ball reaches, no farther: it is felt where it touches, on edges and corners,
  /// too. All that it reaches moves with its centre, and so do the points. Half of the energy: rows along
  /// both axes count alike, so that the numbering of the nodes does not matter.
  class Rows {
   public:
    double energy = 0.0, pressure = 0.0, pressure_xi = 0.0, pressure_eta = 0.0;
    Vec3 total = Vec3::Zero(), by_xi = Vec3::Zero(), by_eta = Vec3::Zero();    // force on the facet
    double by_centre[3] = {
        0.0, 0.0, 0.0};    // -dE/d(xi, eta, h) of the centre by how the points move with it
    double quarter[2][2] = {{0.0, 0.0}, {0.0, 0.0}}, quarter_push[2][2] = {{0.0, 0.0}, {0.0, 0.0}};

    Rows(const Vec3 &ball, const LocalPoint &at, double radius, const FacetPlane &facet, double k) :
        centre(ball), c(at), R(radius), g(facet)
    {
      const Disc disc(g, c, R);
      Moving first, last;
      if (!disc.end(-1, first) || !disc.end(1, last) || first.value >= last.value) return;
      const Moving half = half_of(first, last), middle = middle_of(first, last);
      for (int p = 0; p < N; ++p) {
        Moving xi{middle.value + half.value * place[p], {}}, lo, hi;
        for (int j = 0; j < 3; ++j) xi.by[j] = middle.by[j] + half.by[j] * place[p];
        if (disc.row(xi, lo, hi)) row(k * weight[p], half, xi, half_of(lo, hi), middle_of(lo, hi));
      }
    }

   private:
    const Vec3 &centre;
    const LocalPoint &c;
    const double R;
    const FacetPlane &g;

    void row(double k, const Moving &half_xi, const Moving &xi, const Moving &half,
             const Moving &middle)
    {
      double stored = 0.0, spread = 0.0;
      Vec3 sum = Vec3::Zero();
      for (int q = 0; q < N; ++q) {
        const double eta = middle.value + half.value * place[q];
        const Vec3 off = g.mid + xi.value * g.a + eta * g.b - centre;
        const double distance = off.norm(), depth = R - distance;
        if (depth <= 0.0) continue;    // by rounding
        const Share w = facing_weight(c.h / distance);
        const double s = k * half_xi.value * half.value * weight[q], psi = 0.5 * s * depth * depth;
        const double push = s * depth * w.value + psi * w.slope * c.h / (distance * distance);
        const Vec3 f = push / distance * off;
        stored += psi * w.value;
        sum += f;
        by_eta += eta * f;
        spread += place[q] * f.dot(g.b);
        by_centre[2] -= psi * w.slope / distance;
        pressure += push;
        pressure_xi += push * xi.value;
        pressure_eta += push * eta;
        quarter[xi.value >= 0.0][eta >= 0.0] += psi * w.value;
        quarter_push[xi.value >= 0.0][eta >= 0.0] -= f.dot(g.normal);
      }
      energy += stored;
      total += sum;
      by_xi += xi.value * sum;
      const double along[2] = {sum.dot(g.a), sum.dot(g.b)};
      for (int j = 0; j < 3; ++j)
        by_centre[j] += along[0] * xi.by[j] + along[1] * middle.by[j] +
            (spread - stored / half.value) * half.by[j] - stored / half_xi.value * half_xi.by[j];
    }
  };

}    // namespace

BallForce ball_on_facet(const Vec3 &centre, double R, const FacetPlane &facet, double k_area,
                        double area, Vec3 &on_ball, FacetLoad &on_facet)
{
  BallForce result;
  result.xi = result.eta = 0.0;
  for (int q = 0; q < 4; ++q) result.quarter[q] = result.quarter_push[q] = 0.0;
  const LocalPoint c = local_point(facet, centre);
  if (c.h >= R || c.h <= 0.0) return result;

  const Rows one(centre, c, R, facet, 0.125 * k_area * area);
  const LocalPoint turned{c.eta, c.xi, c.h};
  FacetPlane g = facet;
  std::swap(g.a, g.b);
  std::swap(g.to_xi, g.to_eta);
  const Rows two(centre, turned, R, g, 0.125 * k_area * area);
  result.energy = one.energy + two.energy;
  if (result.energy == 0.0) return result;
  const double pressure = one.pressure + two.pressure;
  result.xi = (one.pressure_xi + two.pressure_eta) / pressure;
  result.eta = (one.pressure_eta + two.pressure_xi) / pressure;
  for (int q = 0; q < 4; ++q) {
    const bool xi = facet_sign[q][0] > 0, eta = facet_sign[q][1] > 0;
    result.quarter[q] = one.quarter[xi][eta] + two.quarter[eta][xi];
    result.quarter_push[q] = one.quarter_push[xi][eta] + two.quarter_push[eta][xi];
  }
  const Vec3 total = one.total + two.total;
  on_ball -= total;
  on_facet.mid += total;
  on_facet.a += one.by_xi + two.by_eta;
  on_facet.b += one.by_eta + two.by_xi;

  // It would be nothing but for the weight, if the quadrature were exact. (How the rows change with the strain
  // of the facet is left out.)
  const double by_h = one.by_centre[2] + two.by_centre[2];
  const Vec3 P = (one.by_centre[0] + two.by_centre[1]) * facet.to_xi +
      (one.by_centre[1] + two.by_centre[0]) * facet.to_eta + by_h * facet.normal;
  on_ball += P;
  on_facet.add(facet, -P, c.xi, c.eta, c.h);
  result.normal = by_h - total.dot(facet.normal);
  return result;
}

}    // namespace defe
