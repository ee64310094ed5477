#ifndef DEFE_COUPLING_SURFACE_POINTS_H
#define DEFE_COUPLING_SURFACE_POINTS_H

// Part of the search for contacts (surface_search.h): the points of this rank, that is its nodes on
// free surfaces and its DEs, and the facets that each may touch.

#include "surface_kept.h"

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
  void run(const SurfaceScene &, SurfaceFaces &, ContactFacets &, const KeptSearch &,
           SurfaceTables &);
  int searched_for() const { return static_cast<int>(anew.size()); }

 private:
  struct Point {
    int particle, part;
    int de;              // index into SurfaceScene::des, -1: a node
    double r, aside;     // how far beside a facet it still counts
    unsigned against;    // directions of normals that it may press on
    int sharp;           // of a node: 0, 1, or not yet looked at, -1
    int size;            // class of its reach
  };
  using List = CellList<Candidate>;

  const SurfaceScene *scene = nullptr;
  SurfaceFaces *faces = nullptr;
  ContactFacets *facets = nullptr;
  SurfaceTables *tables = nullptr;
  const KeptSearch *kept = nullptr;
  double skin = 0.0;    // with room for what is kept
  std::vector<Point> points;
  std::vector<int> nodes;                    // owned ones on free surfaces, in order
  std::vector<int> part_of;                  // of these, by their numbers
  std::vector<int> first_corner, corners;    // their free facets, by their numbers
  int corners_from(int node) const { return first_corner[faces->number_of(node)]; }
  int corners_to(int node) const { return first_corner[faces->number_of(node) + 1]; }
  // facets that each point is near, with that room, in the order of IDs: near[first_near[n]] to near[first_near[n + 1]]
  std::vector<int> first_near, near;
  // of the last search
  std::vector<Point> points_before;
  std::vector<int> first_near_before, near_before;
  std::vector<int> point_at;    // by particle, if it was one

  std::vector<int> before;    // of each point: which one it was then, -1: it is searched for anew
  std::vector<int> anew, rest;    // points: these, and those that new facets are near
  using Pairs = std::vector<std::pair<int, int>>;    // of point and facet
  Pairs near_anew, near_rest;
  std::vector<int> own, met;    // facets of one point: its patches, those that it may touch
  // what is being searched for: these points, near these facets (null: all)
  const std::vector<int> *sought = nullptr, *those = nullptr;
  Pairs *found = nullptr;
  const Point &point(int n) const { return points[(*sought)[n]]; }
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
  void keep_last();
  int point_before(const Point &) const;
  void choose_points();
  void choose_of_rest();
  void sort_facets();
  void find_near(const std::vector<int> &which, const std::vector<int> *only, Pairs &);
  void merge();
  void look_at(int n, const Candidate &);
  int group_from(int first);
  void fill_lanes(int first, int last);
  unsigned within_reach(const Candidate &) const;
  double own_reach(const Point &) const;
  double reach_of(const Point &) const;
  bool any_near(const Facing &, int first, int last) const;
  bool is_near(const Point &, int facet);
  void find_near_group(int first, int last);
  bool may_touch(const Point &, const Candidate &);
  bool joined(int node, const ContactFacet &) const;
  bool glued(const Point &, const ContactFacet &) const;
  bool faces_it(int node, int facet, double least) const;
  bool goes_on(const Point &, const double *x, int facet, double far);
  void make_tables();
  void add_patches(const Point &);
  bool sharp(Point &);
  double radius_against(const Point &, int part) const;
};

}    // namespace defe::search

#endif
