#ifndef DEFE_COUPLING_GHOST_REACH_H
#define DEFE_COUPLING_GHOST_REACH_H

/// \file
/// How far around its sub-domain a rank must know nodes and DEs of others (ghosts): no farther than elements, joints
/// and contacts need.

#include <algorithm>

namespace defe {

/// Lengths by which more is provided than is needed now.
namespace ghosts {
  /// elements may become so much longer until more is provided
  constexpr double growth = 1.05;
  /// before a reneighbouring ghosts are a step behind
  constexpr double step_behind = 1.01;
  /// an element of which a node is missing is taken for so much longer
  constexpr double missing_node = 1.5;
  /// by the longest element: a DE behind the far face of an element that converts, which may have rotated about
  /// its tie
  constexpr double rotated_tie = 0.4;
  /// the same: three joints from a DE, for elements of any shape
  constexpr double three_joints = 0.55;
  /// the same two where an element may be a single DE, whose joints are twice as long
  constexpr double rotated_long_tie = 0.65;
  constexpr double three_long_joints = 2.05;
  /// by the longest diagonal of a face: an element from a point that gets into contact beside and under its face
  constexpr double beside_facet = 0.65;
  /// both may have moved since the lists were made
  constexpr double skins = 1.5;
}    // namespace ghosts

struct GhostNeeds {
  double longest = 0.0;           ///< distance between two nodes of an element
  double diagonal = 0.0;          ///< the same in the reference configuration
  double facet_diagonal = 0.0;    ///< longest one of a face there
  double largest_ball = 0.0;      ///< radius
  double skin = 0.0;
  bool des = false, contact = false;
  bool cracks = false;    ///< fronts of cracks look three joints around them
  bool tied = false;      ///< two elements are tied by their faces
  bool single = false;    ///< some elements become a single DE
};

/// Nodes of an element lie so far from its first node at most, those of one that is tied to it twice as far; ends of
/// joints and ties from their DE are nearer. With DEs and contact there is more to know beyond.
inline double ghost_reach(const GhostNeeds &n)
{
  const double joints = n.single ? ghosts::three_long_joints : ghosts::three_joints;
  const double tie = n.single ? ghosts::rotated_long_tie : ghosts::rotated_tie;
  double more = n.des ? (n.cracks ? joints : tie) * n.longest : 0.0;
  if (n.contact) {
    const double facet = n.facet_diagonal * n.longest / n.diagonal;
    more = std::max(
        more, std::max(ghosts::beside_facet * facet, n.largest_ball) + ghosts::skins * n.skin);
  }
  if (n.tied) more = std::max(more, n.longest);
  return n.longest + more;
}

}    // namespace defe

#endif
