#ifndef DEFE_COUPLING_FACET_H
#define DEFE_COUPLING_FACET_H

/// \file
/// Geometry of a quadrilateral facet: four nodes, counter-clockwise seen from outside, with natural
/// coordinates (-1,-1), (1,-1), (1,1), (-1,1), and x(xi, eta) = sum N_I x_I. It may be warped; contact takes
/// it by its affine part, FacetPlane.

#include "defe/types.h"

namespace defe {

void facet_shape(double xi, double eta, double N[4]);

/// Area vector, outward: that of the bilinear facet, warped or not.
Vec3 facet_area_vector(const Vec3 node[4]);

/// A facet as if it were a parallelogram. With a and b half the vectors between the middles of opposite
/// edges, a point p has the natural coordinates xi = (p - mid).to_xi, eta = (p - mid).to_eta, and the
/// height (p - mid).normal above the plane. A facet without area has a normal of any length up to 1.
struct FacetPlane {
  Vec3 mid, normal, to_xi, to_eta, a, b;    // in the order of use
  double aa, bb, area;                      ///< |a|^2, |b|^2, |a x b|^2

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

}    // namespace defe

#endif
