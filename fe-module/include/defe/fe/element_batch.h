#ifndef DEFE_FE_ELEMENT_BATCH_H
#define DEFE_FE_ELEMENT_BATCH_H

#include "defe/fe/kernel.h"
#include "defe/fe/material_law.h"

#include <array>
#include <memory>
#include <vector>

namespace defe::fe {

/// Which elements share a kernel. The choice depends on the element alone: not on others, and not on where it is
/// computed.
struct KernelRules {
  bool lagrangian = false;    ///< no kernels for one shape
  bool exact = false;    ///< shapes are rounded, so that a kernel does not depend on who came first
  bool own_stress =
      false;    ///< each element has a stress of its own: no kernels for one shape and stress
};

/// Which kernel an element of this material gets.
struct KernelChoice {
  /// \param prestress  what the element has at X (prestress.h); null: it is stress-free there
  KernelChoice(const MaterialLaw &law, const HexCoords &X, const KernelRules &rules,
               const Mat3 *prestress = nullptr);
  HexCoords shape;
  bool of_shape;    ///< one for elements congruent to the shape, and with this stress, only
  bool exact;
  bool prestressed;
  Mat3 stress;
};

/// Elements of one part that share a kernel, as flat arrays of local node indices: all boxes of one shape, or all
/// other elements. Elements of rigid parts have no kernel. Those with a prestress have kernels of their stress-free shape;
/// where the kernel serves any shape, each brings its own (own_reference()).
class ElementBatch {
 public:
  /// An empty one for elements of this part with that kernel.
  ElementBatch(int part, const MaterialLaw &law, const KernelChoice &);
  bool takes(int part, const KernelChoice &) const;

  int part() const { return part_; }
  bool rigid() const { return !kernel_; }
  const HexKernel &kernel() const { return *kernel_; }
  int history_size() const { return kernel_ ? kernel_->history_size() : 0; }

  int size() const { return static_cast<int>(node_.size()); }
  const std::array<int, 8> &nodes(int e) const { return node_[e]; }
  /// What the last forces() left: a bound of what the criterion says of the element's stress.
  double bound(int e) const { return bound_[e]; }
  const double *bounds() const { return bound_.data(); }
  bool has_histories() const { return !history_.empty(); }

  /// Elements have stress-free shapes of their own: these go with add(), and the kernel wants them for X.
  bool own_reference() const { return kernel_ && choice_.prestressed && !choice_.of_shape; }
  /// Of one of them, node 0 at the origin.
  HexCoords reference(int e) const;
  /// What brings one of them that has this stress at X to its stress-free shape.
  Mat3 stress_free_map(const Mat3 &sigma) const;

  /// No elements; memory is kept for those to come.
  void clear();
  /// \param history  history_size() doubles that outlive the table; null if that is 0
  /// \param stress_free  shape, if own_reference()
  void add(const std::array<int, 8> &nodes, double *history,
           const HexCoords *stress_free = nullptr);
  /// The last element takes the place of element e.
  void remove(int e);
  /// The nodes of element e have other indices.
  void renumber(int e, const std::array<int, 8> &nodes) { node_[e] = nodes; }
  /// After the last one: gives back memory that is far too much. Bounds of new elements are 0.
  void finish();

  /// What forces() adds besides the forces; null pointers and a grid that is off cost nothing.
  struct Output {
    const StressBound *bound = nullptr;    ///< null: no bounds are asked for
    bool bound_at_gauss_points = false;
    double *virial = nullptr;         ///< [6], see HexKernel::Output
    double *dissipation = nullptr;    ///< [1] of materials with a history
    double history_step = 0.0;        ///< time by which histories advance
    const SumGrid *grid = nullptr;
  };
  /// First element, if there is one, that is inside out, and that has a force beyond the grid; else -1.
  struct Faults {
    int inverted = -1, beyond = -1;
  };
  /// Adds the forces on the nodes. x, X and f: 3 doubles per node.
  Faults forces(const double *x, const double *X, double *f, const Output &);

  /// Adds the strain energy of each element to the sum, one after the other; their forces are added to f, in
  /// passing.
  void energy(const double *x, const double *X, double *f, double &sum);

  /// Largest distance between two nodes of an element; those that are certainly not longer than `enough` may be
  /// left out. At least `longest`.
  double longest(const double *x, double enough, double longest) const;

 private:
  int part_;
  KernelChoice choice_;
  std::unique_ptr<HexKernel> kernel_;
  std::vector<std::array<int, 8>> node_;
  std::vector<double> bound_;
  std::vector<double *> history_;    // empty if the material has none
  std::vector<double> energy_;
  // with own_reference(): stress-free positions, and positions and forces of each element's nodes for itself
  std::vector<double> own_X_, own_x_, own_f_;
  std::vector<std::array<int, 8>> own_node_;

  void make_prestressed_kernel(const MaterialLaw &);
  void add_forces(const double *x, const double *X, double *f, const HexKernel::Output &);
  static const int (*flat(const std::vector<std::array<int, 8>> &list))[8]
  {
    return reinterpret_cast<const int(*)[8]>(list.data());
  }
};

}    // namespace defe::fe

#endif
