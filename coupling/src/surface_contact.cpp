#include "defe/coupling/surface_contact.h"

#include <algorithm>
#include <cmath>

namespace defe {

Mat3 FacetLoad::virial(const FacetPlane &g, const Vec3 &origin) const
{
  return (g.mid - origin) * mid.transpose() + g.a * a.transpose() + g.b * b.transpose();
}

namespace {

  /// Distribution function of the patch: 0 for u <= -1, 1 for u >= 1.
  Share ramp(double u)
  {
    if (u <= -1.0) return {0.0, 0.0};
    if (u >= 1.0) return {1.0, 0.0};
    return {0.5 + u * (0.75 - 0.25 * u * u), 0.75 * (1.0 - u * u)};
  }

  /// Smooth min(t, 1): t - t^2/4 up to t = 2.
  Share limiter(double t)
  {
    if (t <= 0.0) return {0.0, 0.0};
    if (t >= 2.0) return {1.0, 0.0};
    return {t * (1.0 - 0.25 * t), 1.0 - 0.5 * t};
  }

  /// |z| with its corner rounded off below t/20.
  Share smooth_abs(double z, double t)
  {
    const double e = 0.05 * t, root = std::sqrt(z * z + e * e);
    return {root - e, z / root};
  }

  /// Vectors from the middle of a patch to the middles of its sides.
  Vec3 half_side(const FacetPlane &own, int k)
  {
    return 0.5 * (k ? own.b : own.a);
  }

  /// How far a patch reaches to both sides of its middle, in natural coordinates of a facet.
  void reach_of_patch(const FacetPlane &own, const FacetPlane &facet, const SurfacePair &pair,
                      double reach[2])
  {
    reach[0] = reach[1] = 0.0;
    for (int k = 0; k < 2; ++k) {
      const Vec3 v = half_side(own, k);
      reach[0] += smooth_abs(v.dot(facet.to_xi), pair.t_xi).value;
      reach[1] += smooth_abs(v.dot(facet.to_eta), pair.t_eta).value;
    }
  }

  /// Ways from the middle to the rims: edge 2*axis+0 at +1, 2*axis+1 at -1.
  void ways_to_rims(const LocalPoint &q, const double reach[2], const SurfacePair &pair,
                    double way[4])
  {
    way[0] = (1.0 - q.xi + reach[0]) * pair.half_xi;
    way[1] = (1.0 + q.xi + reach[0]) * pair.half_xi;
    way[2] = (1.0 - q.eta + reach[1]) * pair.half_eta;
    way[3] = (1.0 + q.eta + reach[1]) * pair.half_eta;
    for (int e = 0; e < 4; ++e)
      if (!pair.rim[e]) way[e] = HUGE_VAL;
  }

  bool far_from_rims(const LocalPoint &q, const SurfacePair &pair, double g)
  {
    return (!pair.rim[0] || (1.0 - q.xi) * pair.half_xi >= 2.0 * g) &&
        (!pair.rim[1] || (1.0 + q.xi) * pair.half_xi >= 2.0 * g) &&
        (!pair.rim[2] || (1.0 - q.eta) * pair.half_eta >= 2.0 * g) &&
        (!pair.rim[3] || (1.0 + q.eta) * pair.half_eta >= 2.0 * g);
  }

  void limit_depth(SurfaceContact &c, const double way[4])
  {
    c.depth = c.raw_depth;
    for (int e = 0; e < 4; ++e) {
      c.limited[e] = limiter(way[e] / c.raw_depth).value;
      c.depth *= c.limited[e];
    }
  }

  /// Share along one axis: ramps at +1 and -1, by the middle of the patch at rims, else by its node.
  struct AxisShare {
    double value, by_middle, by_point;
  };
  AxisShare axis_share(double middle, double point, double t, bool rim_plus, bool rim_minus)
  {
    AxisShare r{1.0, 0.0, 0.0};
    // far inside, nothing needs to be divided
    const double plus = 1.0 - (rim_plus ? middle : point);
    if (plus < t) {
      const Share share = ramp(plus / t);
      r.value = share.value;
      (rim_plus ? r.by_middle : r.by_point) -= share.slope / t;
    }
    const double minus = 1.0 + (rim_minus ? middle : point);
    if (minus < t) {
      const Share share = ramp(minus / t);
      r.value += share.value - 1.0;
      (rim_minus ? r.by_middle : r.by_point) += share.slope / t;
    }
    if (r.value <= 0.0) return {0.0, 0.0, 0.0};
    return r;
  }

  /// False: the share is 0.
  bool take_share(SurfaceContact &c, const SurfacePair &pair, double facing)
  {
    const AxisShare xi = axis_share(c.middle.xi, c.point.xi, pair.t_xi, pair.rim[0], pair.rim[1]);
    if (xi.value == 0.0) return false;
    const AxisShare eta =
        axis_share(c.middle.eta, c.point.eta, pair.t_eta, pair.rim[2], pair.rim[3]);
    c.share_xi = xi.value;
    c.share_eta = eta.value;
    c.by_middle[0] = xi.by_middle * eta.value;
    c.by_middle[1] = xi.value * eta.by_middle;
    c.by_point[0] = xi.by_point * eta.value;
    c.by_point[1] = xi.value * eta.by_point;
    const double share = facing * xi.value * eta.value;
    c.share = std::max(share, 0.0);
    return share > 0.0;
  }

  /// Derivatives of the limited depth by the depth and by the four ways.
  void limited_slopes(const SurfaceContact &c, const double way[4], double &by_depth,
                      double by_way[4])
  {
    const double g = c.raw_depth;
    double all = 1.0;
    for (double l : c.limited) all *= l;
    by_depth = all;
    for (int e = 0; e < 4; ++e) {
      by_way[e] = 0.0;
      const double t = way[e] / g;
      const double slope = limiter(t).slope;
      if (slope == 0.0) continue;
      double others = 1.0;
      for (int o = 0; o < 4; ++o)
        if (o != e) others *= c.limited[o];
      by_way[e] = others * slope;
      by_depth -= by_way[e] * t;    // (t is finite where there is a slope)
    }
  }

}    // namespace

Share patch_share(double xi, double t)
{
  const Share plus = ramp((1.0 - xi) / t), minus = ramp((1.0 + xi) / t);
  return {plus.value + minus.value - 1.0, (minus.slope - plus.slope) / t};
}

Share held_over_facet(double xi, double width, bool rim_plus, bool rim_minus)
{
  if (xi > 0.0 ? !rim_plus : !rim_minus) return {xi, 1.0};
  const double beyond = std::abs(xi) - 1.0;
  if (beyond <= 0.0) return {xi, 1.0};
  if (beyond >= 2.0 * width) return {std::copysign(1.0 + width, xi), 0.0};
  return {std::copysign(1.0 + beyond - beyond * beyond / (4.0 * width), xi),
          1.0 - beyond / (2.0 * width)};
}

namespace {

  Share smooth_step(double x, double from, double to)
  {
    if (x <= from) return {0.0, 0.0};
    if (x >= to) return {1.0, 0.0};
    const double z = (x - from) / (to - from);
    return {z * z * (3.0 - 2.0 * z), 6.0 * z * (1.0 - z) / (to - from)};
  }

}    // namespace

Share facing_factor(double c, const SideWeight &weight)
{
  if (c >= parallel_limit) return {weight.parallel, 0.0};
  const Share F = smooth_step(c, facing_limit, parallel_limit);
  const Share p = smooth_step(c, 0.9063, parallel_limit);    // between 25 and 5 degrees
  const double rest = 1.0 - weight.parallel;
  const Share side = weight.sharp ? Share{1.0 - rest * p.value, -rest * p.slope}
                                  : Share{weight.parallel * p.value, weight.parallel * p.slope};
  return {F.value * side.value, F.slope * side.value + F.value * side.slope};
}

bool patch_on_facet(const FacetPlane &own, int corner, const Vec3 &node, const FacetPlane &facet,
                    const SurfacePair &pair, SurfaceContact &c)
{
  c.share = 0.0;
  c.point = local_point(facet, node);
  c.at_node = -c.point.h;
  if (c.at_node <= 0.0) return false;
  c.cosine = -own.normal.dot(facet.normal);
  const Share facing = facing_factor(c.cosine, pair.weight);
  if (facing.value == 0.0) return false;
  const Vec3 q = own.mid + 0.5 * (facet_sign[corner][0] * own.a + facet_sign[corner][1] * own.b);
  c.middle = local_point(facet, q);
  if (!take_share(c, pair, facing.value)) return false;
  c.facing = facing.value;
  c.d_facing = facing.slope;
  c.held_xi = held_over_facet(c.point.xi, hold_width * pair.t_xi, pair.rim[0], pair.rim[1]);
  c.held_eta = held_over_facet(c.point.eta, hold_width * pair.t_eta, pair.rim[2], pair.rim[3]);
  c.at_held = c.raw_depth = c.at_node;
  if (c.held_xi.slope < 1.0 || c.held_eta.slope < 1.0) {
    const Vec3 y = facet.mid + c.held_xi.value * facet.a + c.held_eta.value * facet.b;
    c.at_held = (node - y).dot(own.normal) / c.cosine;
    if (c.at_held <= 0.0) {
      c.share = 0.0;
      return false;
    }
    c.raw_depth =
        c.at_node * c.at_held * std::sqrt(2.0 / (c.at_node * c.at_node + c.at_held * c.at_held));
  }
  if (far_from_rims(c.middle, pair, c.raw_depth)) {
    c.depth = c.raw_depth;
    for (double &l : c.limited) l = 1.0;
    return true;
  }
  double reach[2], way[4];
  reach_of_patch(own, facet, pair, reach);
  ways_to_rims(c.middle, reach, pair, way);
  limit_depth(c, way);
  return true;
}

/// The node is beside the facet: it and the plane of its patch push by their own depths.
/// \return derivative by the cosine between the two planes
static double push_from_beside(const SurfaceContact &c, double normal, double rest,
                               const FacetPlane &own, const FacetPlane &facet, Vec3 &on_node,
                               FacetLoad &on_own, FacetLoad &on_facet)
{
  const double nn = c.at_node * c.at_node, hh = c.at_held * c.at_held;
  const double by_node = normal * c.raw_depth / (nn + hh) * hh / c.at_node;
  const double by_held = normal * c.raw_depth / (nn + hh) * nn / c.at_held;
  // the node against the plane of the facet, and along it where its own place counts for the share
  const Vec3 at_node = by_node * facet.normal + rest * c.by_point[0] * facet.to_xi +
      rest * c.by_point[1] * facet.to_eta;
  on_node += at_node;
  on_facet.add(facet, -at_node, c.point.xi, c.point.eta, c.point.h);
  // the plane of the patch against y, which is held over the facet
  const Vec3 u = by_held / c.cosine * own.normal;
  on_node -= u;
  on_facet.mid += u;
  on_facet.a += c.held_xi.value * u;
  on_facet.b += c.held_eta.value * u;
  const Vec3 along = c.held_xi.slope * facet.a.dot(u) * facet.to_xi +
      c.held_eta.slope * facet.b.dot(u) * facet.to_eta;
  on_node += along;
  on_facet.add(facet, -along, c.point.xi, c.point.eta, c.point.h);
  // its normal
  const Vec3 off = (c.point.xi - c.held_xi.value) * facet.a +
      (c.point.eta - c.held_eta.value) * facet.b + c.point.h * facet.normal;
  on_own.a += off.dot(own.to_xi) * u;
  on_own.b += off.dot(own.to_eta) * u;
  return by_held * c.at_held / c.cosine;
}

SurfaceForce patch_force(const SurfaceContact &c, double offset, const FacetPlane &own, int corner,
                         const FacetPlane &facet, const SurfacePair &pair, Vec3 &on_node,
                         FacetLoad &on_own, FacetLoad &on_facet)
{
  const Penalty psi = penalty_potential(c.depth - offset, pair.depth_max);
  SurfaceForce r{pair.stiffness * c.share * psi.energy, 0.0};
  if (psi.force == 0.0) return r;

  double by_depth = 1.0, by_way[4] = {0.0, 0.0, 0.0, 0.0};
  const double push = pair.stiffness * c.share * psi.force;
  // on the middle of the patch, as generalised forces along xi and eta
  const double rest = -pair.stiffness * c.facing * psi.energy;
  double q_xi = rest * c.by_middle[0], q_eta = rest * c.by_middle[1];

  const bool limited = c.limited[0] * c.limited[1] * c.limited[2] * c.limited[3] < 1.0;
  if (limited) {
    double reach[2], way[4];
    reach_of_patch(own, facet, pair, reach);
    ways_to_rims(c.middle, reach, pair, way);
    limited_slopes(c, way, by_depth, by_way);
    q_xi -= push * (by_way[1] - by_way[0]) * pair.half_xi;
    q_eta -= push * (by_way[3] - by_way[2]) * pair.half_eta;
    // the reach of the patch depends on how its sides lie
    const double on_reach[2] = {-push * (by_way[0] + by_way[1]) * pair.half_xi,
                                -push * (by_way[2] + by_way[3]) * pair.half_eta};
    for (int k = 0; k < 2; ++k) {
      const Vec3 v = half_side(own, k);
      const double z[2] = {v.dot(facet.to_xi), v.dot(facet.to_eta)}, w = v.dot(facet.normal);
      const Vec3 P = on_reach[0] * smooth_abs(z[0], pair.t_xi).slope * facet.to_xi +
          on_reach[1] * smooth_abs(z[1], pair.t_eta).slope * facet.to_eta;
      (k ? on_own.b : on_own.a) += 0.5 * P;
      on_facet.a -= z[0] * P - w * P.dot(facet.to_xi) * facet.normal;
      on_facet.b -= z[1] * P - w * P.dot(facet.to_eta) * facet.normal;
    }
  }

  r.normal = push * by_depth;
  double by_facing = pair.stiffness * c.d_facing * c.share_xi * c.share_eta * psi.energy;
  if (c.held_xi.slope == 1.0 && c.held_eta.slope == 1.0) {
    // the node is over the facet: y is its foot, and both depths are the same function
    const Vec3 P = r.normal * facet.normal + rest * c.by_point[0] * facet.to_xi +
        rest * c.by_point[1] * facet.to_eta;
    on_node += P;
    on_facet.add(facet, -P, c.point.xi, c.point.eta, c.point.h);
  } else {
    by_facing -= push_from_beside(c, r.normal, rest, own, facet, on_node, on_own, on_facet);
  }

  if (q_xi != 0.0 || q_eta != 0.0) {
    const Vec3 P = q_xi * facet.to_xi + q_eta * facet.to_eta;
    on_own.mid += P;
    on_own.a += 0.5 * facet_sign[corner][0] * P;
    on_own.b += 0.5 * facet_sign[corner][1] * P;
    on_facet.add(facet, -P, c.middle.xi, c.middle.eta, c.middle.h);
  }

  if (by_facing == 0.0) return r;
  on_own.a -= by_facing * own.to_xi.dot(facet.normal) * own.normal;
  on_own.b -= by_facing * own.to_eta.dot(facet.normal) * own.normal;
  on_facet.a -= by_facing * facet.to_xi.dot(own.normal) * facet.normal;
  on_facet.b -= by_facing * facet.to_eta.dot(own.normal) * facet.normal;
  return r;
}

bool sphere_on_facet(const LocalPoint &centre, double r, const SurfacePair &pair, SurfaceContact &c)
{
  c.point = c.middle = centre;
  c.raw_depth = r - centre.h;
  c.facing = 1.0;
  c.d_facing = 0.0;
  c.share = 0.0;
  if (c.raw_depth <= 0.0 || !take_share(c, pair, 1.0)) return false;
  if (far_from_rims(c.middle, pair, c.raw_depth)) {
    c.depth = c.raw_depth;
    for (double &l : c.limited) l = 1.0;
    return true;
  }
  const double reach[2] = {r / pair.half_xi, r / pair.half_eta};
  double way[4];
  ways_to_rims(c.middle, reach, pair, way);
  limit_depth(c, way);
  return true;
}

SurfaceForce sphere_force(const SurfaceContact &c, double offset, double r, const FacetPlane &facet,
                          const SurfacePair &pair, Vec3 &on_sphere, FacetLoad &on_facet)
{
  const Penalty psi = penalty_potential(c.depth - offset, pair.depth_max);
  SurfaceForce result{pair.stiffness * c.share * psi.energy, 0.0};
  if (psi.force == 0.0) return result;
  double by_depth = 1.0, by_way[4] = {0.0, 0.0, 0.0, 0.0};
  const double push = pair.stiffness * c.share * psi.force;
  const double rest = -pair.stiffness * psi.energy;
  double q_xi = rest * (c.by_middle[0] + c.by_point[0]),
         q_eta = rest * (c.by_middle[1] + c.by_point[1]);
  if (c.limited[0] * c.limited[1] * c.limited[2] * c.limited[3] < 1.0) {
    const double reach[2] = {r / pair.half_xi, r / pair.half_eta};
    double way[4];
    ways_to_rims(c.middle, reach, pair, way);
    limited_slopes(c, way, by_depth, by_way);
    q_xi -= push * (by_way[1] - by_way[0]) * pair.half_xi;
    q_eta -= push * (by_way[3] - by_way[2]) * pair.half_eta;
  }
  result.normal = push * by_depth;
  const Vec3 P = result.normal * facet.normal + q_xi * facet.to_xi + q_eta * facet.to_eta;
  on_sphere += P;
  on_facet.add(facet, -P, c.point.xi, c.point.eta, c.point.h);
  return result;
}

}    // namespace defe
