#ifndef DEFE_COUPLING_MESH_MEASURE_H
#define DEFE_COUPLING_MESH_MEASURE_H

#include "defe/coupling/element_split.h"
#include "defe/fe/element_sizes.h"
#include "defe/fe/material_law.h"

#include <vector>

namespace defe {

/// Stable time steps; 1e300: none.
struct StableSteps {
  double elements = 1.0e300;
  double des = 1.0e300;       ///< of the DEs that elements become
  double joints = 1.0e300;    ///< of DEs without ties
};

/// Steps of the DEs of an element (`des` and `joints`), of which each may be tied by its outer faces; the elements at the
/// other ends of the ties have a quarter of their mass left for themselves. Ties hardly change the fastest oscillation of
/// DEs, only what can be proven of it: therefore `joints`.
StableSteps discrete_steps(const fe::HexCoords &X, const fe::IsotropicElastic &elastic, double mass,
                           ElementSplit = ElementSplit());

/// Longest by shortest distance of the middles of opposite faces.
double slenderness(const fe::HexCoords &X);

/// What a run needs to know of all elements of a mesh.
class MeshMeasure {
 public:
  struct Part {
    const fe::MaterialLaw *law;
    bool converts;
    int type;    ///< of its DEs
    ElementSplit split = ElementSplit();
  };

  /// \param exact  see fe::ShapeCache
  MeshMeasure(std::vector<Part> parts, int types, bool exact);

  /// An element of that volume and mass.
  void add(int part, const fe::HexCoords &X, double volume, double mass);

  const fe::ElementSizes &sizes() const { return sizes_; }
  const StableSteps &steps() const { return steps_; }
  /// Largest radius of a DE, by type from 0.
  const std::vector<double> &de_radius() const { return radius_; }
  /// Sums over the elements of a part; doubles, to be summed over ranks.
  struct PartSums {
    double size = 0.0;    ///< cube roots of volumes
    double number = 0.0;
    double slender =
        0.0;    ///< number of those that are more than `slender_from` times as long as thick
  };
  const std::vector<PartSums> &part_sums() const { return part_sums_; }

  /// Eight DEs of an element that is bent cannot do without shear: by 2:1 they store up to 1.4 times its energy, by 4:1 3 times.
  static constexpr double slender_from = 2.5;

 private:
  std::vector<Part> parts_;
  bool exact_;
  fe::ElementSizes sizes_;
  StableSteps steps_;
  std::vector<double> radius_;
  std::vector<PartSums> part_sums_;
  fe::ShapeCache<StableSteps> known_;

  StableSteps steps_of(int part, const fe::HexCoords &X, double mass);
};

}    // namespace defe

#endif
