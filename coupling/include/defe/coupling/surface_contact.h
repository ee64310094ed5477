#ifndef DEFE_COUPLING_SURFACE_CONTACT_H
#define DEFE_COUPLING_SURFACE_CONTACT_H

/// \file
/// Contact of surfaces as a potential: patches of facets, spheres and balls against facets.
///
/// A facet is taken by its affine part, x = mid + xi a + eta b (defe::FacetPlane). A patch is the quarter of
/// a facet at one of its nodes. Its depth below another facet is measured at the node x and, beside a rim, also
/// at the place y over the facet that is nearest to x:
///
///   E = K F(c) w(xi) w(eta) psi(g),    psi(g) = g^2/2 (1 + stiffening (g/D)^2),
///   2/g^2 = 1/g_x^2 + 1/g_y^2,   g_x = -h(x): the node below the plane of the facet,
///   g_y = (x - y).n/c: the patch's plane at y = mid + S(xi) a + S(eta) b, S: xi held within +-1
///
/// Both must be below: neither the plane of the facet nor that of the patch counts where only its
/// continuation is there. n is the patch's normal, n' the facet's.
/// w is a smooth ramp across each edge. Where the surface goes on beyond the edge, the ramp is that of the
/// node: the shares of both facets add up to 1, and it goes from one to the next without noticing.
/// Across a rim it is the part of the patch that is left on the facet, by its middle q: a rim that is
/// flush with the patch's own carries all of it, and over a rim it fades out.
/// F is the facing factor of c = -n.n', 1 for parallel surfaces and 0 from 75 degrees on, times the weight of
/// this side (SideWeight). D is the depth up to which a point can be told to be inside: what is deeper is
/// let through. Beside a rim the depth is limited by the way that the patch reaches over it, so that a body
/// beside a corner is not taken for one that is deep behind the face round the corner.
///
/// Everything is a smooth function of the positions of all nodes, and the forces are its exact
/// derivatives: energy, linear and angular momentum are conserved for any pair of meshes, and no history
/// is needed to know on which side a point is. Mortar-like penalty contact is described in Puso and
/// Laursen, Comput. Methods Appl. Mech. Engrg. 193 (2004) 601; the smooth shares are ours.

#include "defe/coupling/facet.h"

namespace defe {

/// Generalised force on the affine coordinates of a facet.
struct FacetLoad {
  Vec3 mid = Vec3::Zero(), a = Vec3::Zero(), b = Vec3::Zero();

  /// A force f on the material point at y, that moves with the facet as a rigid offset of its plane:
  /// moment and resultant are those of f at y. (xi, eta, h): coordinates of y, see local_point().
  void add(const FacetPlane &g, const Vec3 &f, double xi, double eta, double h)
  {
    mid += f;
    a += xi * f - h * f.dot(g.to_xi) * g.normal;
    b += eta * f - h * f.dot(g.to_eta) * g.normal;
  }
  /// Force on node k (0..3).
  Vec3 on_node(int k) const;
  /// Sum of x_k f_k^T over the nodes, with x from `origin`.
  Mat3 virial(const FacetPlane &, const Vec3 &origin) const;
};

/// Signs of the natural coordinates of a facet's nodes.
constexpr int facet_sign[4][2] = {{-1, -1}, {1, -1}, {1, 1}, {-1, 1}};

inline Vec3 FacetLoad::on_node(int k) const
{
  return 0.25 * (mid + facet_sign[k][0] * a + facet_sign[k][1] * b);
}

/// p = mid + xi a + eta b + h normal.
struct LocalPoint {
  double xi, eta, h;
};
inline LocalPoint local_point(const FacetPlane &g, const Vec3 &p)
{
  const Vec3 r = p - g.mid;
  return {r.dot(g.to_xi), r.dot(g.to_eta), r.dot(g.normal)};
}

/// A value and its derivative.
struct Share {
  double value, slope;
};
/// Share of a patch that lies between the edges at -1 and 1 of a facet, if its middle is at `xi` and it
/// reaches t to both sides: 1 where all of it does, 0 beyond. Continuous with its derivative.
Share patch_share(double xi, double t);

/// S: xi up to 1, then bends to 1 + width at 1 + 2 width and beyond; the same at -1. Only at rims.
Share held_over_facet(double xi, double width, bool rim_plus = true, bool rim_minus = true);
constexpr double hold_width = 0.02;    // of the half width of the patch

/// Weight of one side of a pair of surfaces, as a function of c. Parallel surfaces share the contact, the
/// finer one takes more of it. Where they are not parallel (p(c) = 0 from 25 degrees on), the nodes of sharp
/// edges and corners carry all of it and those of flat surfaces nothing: an edge slides over the nodes of a
/// floor without noticing. The weights of both sides add up to 1.
struct SideWeight {
  double parallel = 1.0;    ///< weight of this side for parallel surfaces
  bool sharp = true;        ///< the node is on a sharp edge of its body
};

/// F(c): 0 for c <= facing_limit, 1 for c >= parallel_limit (5 degrees), a smooth step between, times the
/// weight of the side.
constexpr double facing_limit = 0.25, parallel_limit = 0.9962;
Share facing_factor(double c, const SideWeight &);

/// psi and its derivative. Energy per stiffness. g < 0: 0.
struct Penalty {
  double energy, force;
};
constexpr double stiffening = 10.0;
inline Penalty penalty_potential(double g, double depth_max)
{
  if (g <= 0.0) return {0.0, 0.0};
  const double u = g / depth_max, s = stiffening * u * u;
  return {0.5 * g * g * (1.0 + s), g * (1.0 + 2.0 * s)};
}

/// Constants of a patch or sphere against one facet.
struct SurfacePair {
  double stiffness;      ///< K, N/m: penalty per area times area times the weight of this side
  double t_xi, t_eta;    ///< half width of the patch in natural coordinates of the facet
  double half_xi, half_eta;    ///< reference distances from the middle of the facet to its edges
  double depth_max;            ///< D
  bool rim[4] = {true, true, true, true};    ///< edges at xi = 1, -1, eta = 1, -1
  SideWeight weight = {};
};

/// Where a patch or sphere is on a facet. share == 0: no contact.
struct SurfaceContact {
  double share = 0.0;        ///< F w w
  double depth = 0.0;        ///< limited depth
  double raw_depth = 0.0;    ///< depth below the plane; > D: let through, share is what it would be
  LocalPoint point;          ///< of the node or sphere
  LocalPoint middle;         ///< of the patch's middle
  Share held_xi, held_eta;    ///< S
  double cosine;              ///< c
  double at_node, at_held;    ///< g_x, g_y
  double facing, d_facing, share_xi, share_eta;
  double by_middle[2], by_point[2];    ///< derivatives of the shares by xi and eta of q and of x
  double limited[4];                   ///< factor of the depth by each edge, 1 = not limited
};

/// \param own     facet of the patch; corner: which of its nodes
/// \param node    that node's position
/// False: no contact, and only the share (0) is set.
bool patch_on_facet(const FacetPlane &own, int corner, const Vec3 &node, const FacetPlane &facet,
                    const SurfacePair &, SurfaceContact &);
inline SurfaceContact patch_on_facet(const FacetPlane &own, int corner, const Vec3 &node,
                                     const FacetPlane &facet, const SurfacePair &pair)
{
  SurfaceContact c;
  patch_on_facet(own, corner, node, facet, pair, c);
  return c;
}

struct SurfaceForce {
  double energy;
  double normal;    ///< magnitude of the force along the facet's normal
};

/// Energy and forces of the patch, its depth reduced by `offset`.
SurfaceForce patch_force(const SurfaceContact &, double offset, const FacetPlane &own, int corner,
                         const FacetPlane &facet, const SurfacePair &, Vec3 &on_node,
                         FacetLoad &on_own, FacetLoad &on_facet);

/// The same for a sphere of radius r, which is at depth r - h; t of the pair is for half its size.
bool sphere_on_facet(const LocalPoint &centre, double r, const SurfacePair &, SurfaceContact &);
inline SurfaceContact sphere_on_facet(const Vec3 &centre, double r, const FacetPlane &facet,
                                      const SurfacePair &pair)
{
  SurfaceContact c;
  sphere_on_facet(local_point(facet, centre), r, pair, c);
  return c;
}
SurfaceForce sphere_force(const SurfaceContact &, double offset, double r, const FacetPlane &facet,
                          const SurfacePair &, Vec3 &on_sphere, FacetLoad &on_facet);

/// A ball of any radius against a facet that is in front of its centre: the penalty pressure
/// k_A (R - r) on the facet's points, r = |y - c|, E = k_A/2 integral (R - r)^2 w(h/r) dA over those nearer
/// than R, by 2 x 16 Gauss points on the part of the facet that it can reach. So it begins where they touch, on
/// edges and corners, too. On a plane of facets it is pi k_A R d^3/3 for small d = R - h, wherever the ball lands.
/// w is 1 where the ball is seen from the facet at more than 17 degrees (h/r > 0.3), and 0 in its plane: a ball
/// that rolls over an edge gets in front of the next facet without noticing.
struct BallForce {
  double energy = 0.0;
  double normal = 0.0;       ///< force along the facet's normal
  double xi, eta;            ///< centre of pressure
  double quarter[4];         ///< energy of the quarter at each node
  double quarter_push[4];    ///< and its force along the normal
};
/// \param k_area  penalty stiffness per area (N/m3);  \param area  reference area of the facet
BallForce ball_on_facet(const Vec3 &centre, double R, const FacetPlane &facet, double k_area,
                        double area, Vec3 &on_ball, FacetLoad &on_facet);

}    // namespace defe

#endif
