#ifndef DEFE_COUPLING_CRACK_RINGS_H
#define DEFE_COUPLING_CRACK_RINGS_H

/// \file
/// Rings of a lattice of discrete elements (DEs).
///
/// Around every line in which cells of DEs meet, their centres form a closed ring whose neighbours
/// are joined: four DEs inside an element and across an element's face, as many as there are
/// elements around an inner edge of the mesh (elements that are a single DE have these rings only). A crack surface that
/// passes through a ring cuts two of its joints, so a ring with one cut joint holds a crack front (see crack_growth.h). At
/// the surface of the body the ring is open, and no crack front is looked for there; beside finite elements it is open, too.
///
/// Rings are walked when they are asked for (nothing is stored) and by the slots alone: any hex mesh.

#include "defe/types.h"

#include <cstdint>

namespace defe {

/// What the growth of cracks sees of the DEs of one rank. The arrays are the caller's. Joint
/// `6 * DE + slot` is the joint at that slot; both its ends have a number.
struct CrackLattice {
  enum State : unsigned char { INTACT = 0, SOFTENING = 1, BROKEN = 2 };

  int owned;    ///< DEs 0 .. owned - 1 are this rank's
  int n;        ///< the rest up to n are its ghosts: all within three joints of its own
  const std::int64_t *id;    ///< [n] unique, the same on all ranks
  const double (*X)[3];      ///< [n] reference positions, neighbours not wrapped
  const int (*partner)
      [6];    ///< [n] 6 * other DE + slot there; < 0: no joint to another DE that is known here
  const unsigned char *outer;    ///< [n] bit s set: slot s leads out of the DE's element
  const unsigned char *state;    ///< [6 n] of joints, the same at both ends
  /// [n] bit s set: slot s ends on the face of a finite element of the same part, of ghosts, too; null: none
  const unsigned char *ties = nullptr;
  /// [n] two bits per slot: of an outer slot, the node of the other element's face (a position on it) at the first node of
  /// ours. Where an element is a single DE it tells how the slots over there are turned; null: no such element.
  const std::uint16_t *turned = nullptr;
  /// [n] bits that belong to the place of the DE, see crack_place_key(): also across periodic borders the same
  /// for all images; null: they are made of X
  const std::uint64_t *key = nullptr;

  Vec3 vector(int joint) const    ///< from the DE of this end to the other one, reference
  {
    const double *a = X[joint / 6], *b = X[partner[joint / 6][joint % 6] / 6];
    return Vec3(b[0] - a[0], b[1] - a[1], b[2] - a[2]);
  }
  int other_end(int joint) const { return partner[joint / 6][joint % 6]; }
  /// The joint's number from the DE of the lower ID.
  int lower_end(int joint) const
  {
    const int other = other_end(joint);
    return id[joint / 6] < id[other / 6] ? joint : other;
  }
  bool cut(int joint) const { return state[joint] != INTACT; }
};

/// Bits that belong to a place: random, but the same whatever the numbering. Places are rounded to a hundredth of
/// `size` (that of the DE, or so), off the multiples of the mesh size, so that rounding does not matter.
std::uint64_t crack_place_key(const Vec3 &place, double size);

struct CrackRing {
  static constexpr int most = 12;

  int size = 0;
  int de[most + 1];
  int joint[most];    ///< joint[k] leads from de[k] to the next one, the last back to de[0]
  int open =
      -1;    ///< of an open ring: 6 * DE + slot where it ends, after joint[size - 1]; the DE is de[size]

  int des() const { return open < 0 ? size : size + 1; }

  int cut(const CrackLattice &lattice) const
  {
    int count = 0;
    for (int k = 0; k < size; ++k) count += lattice.cut(joint[k]);
    return count;
  }
};

/// The ring that leaves a DE through slot `out` and comes back through slot `back` (of another axis).
/// \return whether there is one; it is closed, of 3 to CrackRing::most DEs. Else `ring` holds what there is up to
///         the slot `open`, if that is known.
bool crack_ring(const CrackLattice &lattice, int de, int out, int back, CrackRing &ring);

}    // namespace defe

#endif
