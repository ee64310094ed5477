#ifndef DEFE_COUPLING_SURFACE_POINTS_H
#define DEFE_COUPLING_SURFACE_POINTS_H

// Part of the search for contacts (surface_search.h): the points of this rank, that is its nodes on
// free surfaces and its DEs, and the facets that each may touch.

#include "surface_facets.h"

#include <map>
#include <utility>
#include <vector>

namespace defe::search {

/// Facets of about one size around a place, in cells.
struct Candidate {
  double x[3];
  double extent;
  int part, facet;
  unsigned directions;
};

class ContactPoints {
 public:
  void run(const SurfaceScene &, SurfaceFaces &, ContactFacets &, SurfaceTables &);

 private:
  struct Point {
    int particle, part;
    int de;              // index into SurfaceScene::des, -1: a node
    double r, aside;     // how far beside a facet it still counts
    unsigned against;    // directions of normals that it may press on
    int size;            // class of its reach
  };
  using List = CellList<Candidate>;

  const SurfaceScene *scene = nullptr;
  SurfaceFaces *faces = nullptr;
  ContactFacets *facets = nullptr;
  SurfaceTables *tables = nullptr;
  std::vector<Point> points;
  std::vector<int> part_of;                  // of owned nodes on free surfaces
  std::vector<int> first_corner, corners;    // free facets of each owned node
  std::vector<std::pair<int, int>> near;     // indices of point and facet
  struct Group {
    double x[3], radius;    // of points that are near each other
    double reach;           // the largest of a point
    unsigned against;       // of all of them
  } group;
  std::vector<Candidate> around;    // all that points of a group may be near
  static constexpr int most = 8;    // points of a group
  /// The points of a group side by side; the last one pads.
  struct Lanes {
    double x[3][most], r[most], aside[most], behind[most], reach[most];
  } lanes;
  std::vector<int> of_lane[most];    // candidates that are left for each of them
  /// Facets of about one size that points of one class may meet. For nodes those that face one way, since most of what
  /// is near a node looks along with its own facets; a facet aslant is in several.
  struct Facing {
    List list;
    unsigned direction;                 // of `directions`, all for DEs
    std::vector<unsigned> near_cell;    // whether there is any around each cell
  };
  // by kind, nodes and DEs, and by the class of the points' reach
  std::map<int, std::vector<Facing>> lists[2];

  void find_corners();
  void find_points();
  void sort_facets();
  void find_near();
  void look_at(int n, const Candidate &);
  int group_from(int first);
  void fill_lanes(int first, int last);
  unsigned within_reach(const Candidate &) const;
  double own_reach(const Point &) const;
  double reach_of(const Point &) const;
  bool any_near(const Facing &, int first, int last) const;
  void find_near_group(int first, int last);
  bool may_touch(const Point &, const Candidate &);
  bool joined(int node, const ContactFacet &) const;
  bool glued(const Point &, const ContactFacet &) const;
  bool faces_it(int node, int facet) const;
  bool goes_on(const Point &, const double *x, int facet);
  void make_tables();
  void add_patches(const Point &);
  double radius_against(const Point &, int part) const;
};

}    // namespace defe::search

#endif
