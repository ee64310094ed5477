#ifndef DEFE_COUPLING_FACET_H
#define DEFE_COUPLING_FACET_H

/// \file
/// Geometry of a bilinear quadrilateral facet: four nodes, counter-clockwise seen from outside,
/// x(xi, eta) = sum N_I x_I with natural coordinates (-1,-1), (1,-1), (1,1), (-1,1) at the nodes.
/// The facet may be warped.

#include "defe/types.h"

namespace defe {

enum class FacetFeature { face, edge, vertex };

struct FacetPoint {
  Vec3 closest;            ///< closest point of the facet
  double xi, eta;          ///< its natural coordinates
  double N[4];             ///< shape functions there, >= 0, sum 1
  FacetFeature feature;    ///< what the closest point lies on
  int which;               ///< edge e joins nodes e and e+1, vertex: the node; face: 0
  double distance;         ///< to the point; negative behind the facet
  Vec3 normal;             ///< outward unit normal of the facet at the closest point
};

/// Closest point of the facet to p: Newton's method on the natural coordinates; where that ends on
/// the border, the four edges in closed form. A warped facet may have several local minima for
/// points farther away than its radius of curvature: one of them is returned.
/// A facet without area has normal 0 where it has none, and distance >= 0.
FacetPoint closest_point(const Vec3 &p, const Vec3 node[4]);

/// Foot of the normal from p on the facet continued beyond its edges: |xi| or |eta| may be above 1
/// and shape functions negative, so that the reaction spread with N has no moment about p. For
/// points near the facet; xi and eta are kept within +-2. feature is face if the foot is on the
/// facet, else edge (which is 0). xi, eta: where to begin, for those who know it roughly.
FacetPoint project_point(const Vec3 &p, const Vec3 node[4], double xi = 0.0, double eta = 0.0);

void facet_shape(double xi, double eta, double N[4]);
Vec3 facet_point(const Vec3 node[4], double xi, double eta);

/// Area vector (outward, exact for any bilinear patch) and scalar area (exact if plane, 2 x 2
/// Gauss otherwise).
Vec3 facet_area_vector(const Vec3 node[4]);
double facet_area(const Vec3 node[4]);

/// A facet as if it were a parallelogram, for cheap tests. With a and b half the vectors between the
/// middles of opposite edges, a point p has the natural coordinates xi = (p - mid).to_xi,
/// eta = (p - mid).to_eta, and the height (p - mid).normal above the plane, from which the facet
/// itself deviates by up to `warp`. A facet without area has a normal of any length up to 1.
struct FacetPlane {
  Vec3 mid, normal, to_xi, to_eta, a, b;    // in the order of use
  double warp;
  double aa, bb, area;    ///< |a|^2, |b|^2, |a x b|^2

  /// Heights of the parallelogram in the directions of xi and eta, from the middle.
  double half_xi() const;
  double half_eta() const;

  /// True if a point at p cannot come less than r in front of the plane and less than `depth` below it, over
  /// the parallelogram or less than `aside` beside it, before it and the nodes have moved by drift/2
  /// each. False says nothing.
  bool out_of_reach(const Vec3 &p, double r, double depth, double aside, double drift) const;
};

/// Planes of n facets. node: indices of their nodes, three coordinates each in x.
void facet_planes(int n, const int (*node)[4], const double *x, FacetPlane *plane);

/// Outward unit normal at a point; 0 if degenerate there.
Vec3 facet_normal(const Vec3 node[4], double xi, double eta);

}    // namespace defe

#endif
