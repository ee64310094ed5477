#ifndef DEFE_FE_ELEMENT_SIZES_H
#define DEFE_FE_ELEMENT_SIZES_H

#include "defe/fe/elastic.h"
#include "defe/fe/kernel.h"

#include <cstddef>
#include <vector>

namespace defe::fe {

/// Extremes of a mesh, in the reference configuration.
struct ElementSizes {
  double diagonal = 0.0;         ///< longest distance between two nodes of an element
  double face_diagonal = 0.0;    ///< and of a face
  double shortest_edge = 1.0e300;
  double largest_force = 0.0;    ///< that an element bears at a strain of 1

  void add(const HexCoords &X);
  /// Of an element that is not rigid.
  void add_force(const HexCoords &X, const IsotropicElastic &elastic);
};

/// What was computed for one element is that of all others of its part with the same shape.
template <class Value> class ShapeCache {
 public:
  /// exact: values are computed for rounded shapes (rounded_shape()), so that they do not depend on who came first.
  explicit ShapeCache(bool exact) : exact_(exact) {}

  /// The shape to compute with.
  HexCoords shape(const HexCoords &X) const { return exact_ ? rounded_shape(X) : X; }

  /// \param shape  as above; null if there was none like it
  const Value *find(int part, const HexCoords &shape) const
  {
    for (const auto &s : list_)
      if (s.part == part && (exact_ ? s.shape == shape : congruent(s.shape, shape)))
        return &s.value;
    return nullptr;
  }

  /// Kept unless there are many already: a mesh of elements that all differ is not searched again and again.
  void add(int part, const HexCoords &shape, const Value &value)
  {
    if (list_.size() < most) list_.push_back({shape, part, value});
  }

 private:
  static constexpr std::size_t most = 64;
  struct Entry {
    HexCoords shape;
    int part;
    Value value;
  };
  bool exact_;
  std::vector<Entry> list_;
};

}    // namespace defe::fe

#endif
