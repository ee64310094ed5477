#ifndef DEFE_COUPLING_ELEMENT_SPLIT_H
#define DEFE_COUPLING_ELEMENT_SPLIT_H

/// \file
/// How an element is split into discrete elements (DEs): n along each of its natural axes, n = 1, 2 or 3.
///
/// Each has a place, a number from 0 to n^3 - 1. The first eight are at the corners and have the numbers of the nodes
/// there; of the other places of n = 3 (middles of edges, of faces, of the element) xi runs first. The only place of
/// n = 1 is at no corner.
///
/// Slots of a DE: 2 * axis + (0: negative, 1: positive natural direction). An outer slot leads through the element's face
/// of that number (fe::hex_face), an inner one to the DE beside it in its element.

#include "defe/fe/topology.h"
#include "defe/types.h"

#include <vector>

namespace defe {

/// Where on a face a tie ends: at the middle of the DE's patch of it. The nodes of the face are ordered from the one that
/// is nearest; of the middle of an edge its two are the first ones.
enum class TieSpot : unsigned char { QUARTER, CORNER, EDGE, MIDDLE };

/// The face's bilinear shape functions there; the nodes take the tie's force by them. QUARTER is the corner of n = 2,
/// CORNER that of n = 3, MIDDLE serves n = 3 and n = 1.
inline constexpr double tie_weights[4][4] = {{9.0 / 16.0, 3.0 / 16.0, 1.0 / 16.0, 3.0 / 16.0},
                                             {25.0 / 36.0, 5.0 / 36.0, 1.0 / 36.0, 5.0 / 36.0},
                                             {5.0 / 12.0, 5.0 / 12.0, 1.0 / 12.0, 1.0 / 12.0},
                                             {0.25, 0.25, 0.25, 0.25}};

constexpr const double *weights_of(TieSpot spot)
{
  return tie_weights[static_cast<int>(spot)];
}

class ElementSplit {
 public:
  static constexpr int usual = 2, most = 3;

  explicit constexpr ElementSplit(int along = usual) : n(along) {}
  constexpr int along() const { return n; }
  constexpr int des() const { return n * n * n; }
  bool operator==(const ElementSplit &other) const { return n == other.n; }

  /// Half of the edge of a DE's cell in natural coordinates.
  double half() const { return 1.0 / n; }
  /// Natural coordinates of the middle of a cell.
  Vec3 centre(int place) const;
  /// n times these: whole numbers from 1 - n to n - 1.
  void position(int place, int q[3]) const;
  /// Which of the element's corners it is at: -1 or 1 along each axis, 0 where it is in the middle.
  Vec3 sign(int place) const;
  /// -1: none.
  int node_at(int place) const { return n > 1 && place < 8 ? place : -1; }

  bool outer(int place, int slot) const;
  /// A bit per slot.
  unsigned outer_slots(int place) const;
  /// The place beside it in the element, of an inner slot.
  int beside(int place, int slot) const;

  /// The places at a face of the element.
  std::vector<int> on_face(int face) const;

  /// Of an outer slot: position on the face (fe::hex_face) of the node from which a tie's nodes are listed.
  int first_on_face(int place, int face) const;
  TieSpot spot(int place, int face) const;
  /// The place behind an outer slot in a neighbour of the same split.
  /// \param other, rotation  the neighbour's face, and the position on it of the first node of ours
  int behind(int place, int face, int other, int rotation) const;
  /// What the DE behind is known by (JointRecord::corner): its place. Where that says nothing, as it is the only one, the
  /// neighbour's node at the first node of our face: how it is turned.
  int behind_code(int place, int face, int other, int rotation) const;
  int place_of_code(int code) const { return n == 1 ? 0 : code; }

 private:
  int n;
  int number(const int q[3]) const;
};

}    // namespace defe

#endif
