#ifndef DEFE_COUPLING_CONVERSION_PLAN_H
#define DEFE_COUPLING_CONVERSION_PLAN_H

/// \file
/// What a conversion of several elements at once makes of them and of what is beside them: the discrete elements
/// (DEs) that are born, how each is held, which ties become joints, what lies behind faces from now on. No atoms are
/// made here: IDs in, IDs out. All ranks that have a part in a conversion plan it alike.

#include "defe/coupling/conversion.h"

#include <algorithm>
#include <cstdint>
#include <iterator>
#include <unordered_map>
#include <vector>

namespace defe {

/// An element that converts, as its neighbours know it. Plain data.
struct ConvertingHex {
  std::int64_t id;
  std::int64_t lot;    ///< its DEs have the IDs of this lot
  std::int64_t node[8];
  double x[8][3];    ///< current positions of the nodes

  fe::HexCoords coords() const;
  /// One of these is a node of the element.
  template <class Id> bool has_node_of(const Id *ids, int count) const
  {
    return std::find_first_of(ids, ids + count, std::begin(node), std::end(node)) != ids + count;
  }
};

/// What lies behind the six faces of an element.
struct HexNeighbors {
  std::int64_t behind[6];     ///< > 0 this element, 0 free surface, < 0 the DEs of lot -behind
  signed char face[6];        ///< the face, seen from that element
  signed char rotation[6];    ///< position on that face of the first node of ours
  signed char part[6];        ///< part of that element
  unsigned tied = 0;    ///< a bit for each free face that is tied to another part (tied_quarters.h)
};

/// How a DE is held in one of its six slots when it is born.
struct PlannedSlot {
  enum Kind : signed char { FREE, JOINT, TIE };
  Kind kind = FREE;
  /// A joint to a DE that was born before, which may have rotated about its tie since.
  bool to_older = false;
  signed char partner = 0;    ///< slot of the joint on the other DE (also of the one a tie becomes)
  signed char corner = 0;     ///< ElementSplit::behind_code() of the other DE
  signed char part = 0;       ///< of a tie: part of that element
  std::int64_t other = 0;     ///< joint: ID of the other DE; tie: that of the element
  /// outer slots with something behind: nodes of the face, from ElementSplit::first_on_face() onwards, of
  /// the middle of the face from the least ID onwards
  std::int64_t face_node[4] = {0, 0, 0, 0};
};

struct PlannedDE {
  std::int64_t id;
  PlannedSlot slot[6];
  /// Where it ends for spheres and for facets of other parts: distance and area of the nearest of its free faces,
  /// so that spheres of flat cells do not stand out of their surface, nor those of compressed elements; else its radius and
  /// the face of a cube.
  double outer_distance, outer_area;
};

class ConversionPlan {
 public:
  /// The DEs of lot n have the IDs de_base + lot_size (n - 1) + place + 1. `all`: the elements that convert now, at
  /// least those with a node here, in ascending order of their IDs.
  ConversionPlan(std::int64_t de_base, std::vector<ConvertingHex> all, int lot_size = 8);
  ConversionPlan(const ConversionPlan &) = delete;
  ConversionPlan &operator=(const ConversionPlan &) = delete;

  const std::vector<ConvertingHex> &all() const { return list; }
  /// Null: the element stays.
  const ConvertingHex *converting(std::int64_t element) const
  {
    const auto found = by_id.find(element);
    return found == by_id.end() ? nullptr : found->second;
  }
  std::int64_t de_id(std::int64_t lot, int place) const
  {
    return base + lot_size * (lot - 1) + place + 1;
  }

  /// The DEs of one of them, by place. all: convert_hex() of it.
  std::vector<PlannedDE> births(const ConvertingHex &, const HexNeighbors &,
                                const std::vector<NewDE> &all, ElementSplit = ElementSplit()) const;

  /// Nodes of the element lose this share of its mass each; those that no element has any more go.
  static constexpr double node_share = 0.125;

  /// The DE at this place of an element that a DE was tied to, 0 if the element stays.
  std::int64_t joint_of_tie(std::int64_t element, int place) const
  {
    const ConvertingHex *c = converting(element);
    return c ? de_id(c->lot, place) : 0;
  }

  /// What lies behind a face of an element that stays (HexNeighbors::behind), by what did.
  std::int64_t behind_now(std::int64_t behind) const
  {
    const ConvertingHex *c = behind > 0 ? converting(behind) : nullptr;
    return c ? -c->lot : behind;
  }

  /// The elements that convert and have a node of this one, each once, in an order that all ranks have.
  template <class Id> std::vector<const ConvertingHex *> around(const Id node[8]) const
  {
    std::vector<const ConvertingHex *> found;
    for (int a = 0; a < 8; a++) add_at(node[a], found);
    return found;
  }

  /// All nodes of elements that convert: f(ID).
  template <class F> void for_nodes(const F &f) const
  {
    for (const auto &one : at_node) f(one.first);
  }

 private:
  void add_at(std::int64_t node, std::vector<const ConvertingHex *> &found) const;
  PlannedSlot outer_slot(const ConvertingHex &, const HexNeighbors &, ElementSplit, int place,
                         int face) const;

  std::int64_t base;
  int lot_size;
  std::vector<ConvertingHex> list;
  std::unordered_map<std::int64_t, const ConvertingHex *> by_id;
  std::unordered_map<std::int64_t, std::vector<const ConvertingHex *>> at_node;
};

/// From a point to the centre of an element, for shields.
Vec3 direction_to(const ConvertingHex &, const Vec3 &from);

}    // namespace defe

#endif
