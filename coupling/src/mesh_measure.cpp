#include "defe/coupling/mesh_measure.h"

#include "defe/coupling/conversion.h"
#include "defe/fe/hex8.h"
#include "defe/fe/stable_step.h"

#include <algorithm>
#include <cmath>

namespace defe {

using fe::HexCoords;

StableSteps discrete_steps(const HexCoords &X, const fe::IsotropicElastic &elastic, double mass,
                           ElementSplit split)
{
  const CornerModuli moduli{elastic.lambda(), elastic.mu()};
  const auto all = convert_hex(X, X, HexCoords::Zero(), mass, split);
  const double its = mass / split.des();
  StableSteps steps;
  steps.des = 0.5 * fe::critical_step(X, elastic);
  for (int k = 0; k < split.des(); k++) {
    auto cell = cell_of(all, k, split);
    double behind[6];
    for (int s = 0; s < 6; s++)
      if (split.outer(k, s)) cell.dX[s] = 2.0 * cell.face[s];
    steps.joints = std::min(steps.joints, lattice_critical_step(cell, 0x3f, moduli, its));
    steps.des = std::min(steps.des, softening_critical_step(cell, 0x3f, moduli, its));
    for (int s = 0; s < 6; s++) {
      behind[s] = its;
      if (!split.outer(k, s)) continue;
      // the eighth that a node has of the element behind, by the ties of a face that it takes: their weights are a
      // contraction, of n x n ties times n^2/4
      behind[s] = 0.5 * mass / (split.along() * split.along());
      cell.dX[s] = cell.face[s];
      cell.tie |= static_cast<unsigned char>(1 << s);
    }
    steps.des = std::min(steps.des, lattice_critical_step(cell, 0x3f, moduli, its, behind));
  }
  return steps;
}

double slenderness(const HexCoords &X)
{
  const Eigen::RowVector3d lengths = fe::jacobian(X, Vec3::Zero()).colwise().norm();
  return lengths.maxCoeff() / lengths.minCoeff();
}

MeshMeasure::MeshMeasure(std::vector<Part> parts, int types, bool exact) :
    parts_(std::move(parts)), exact_(exact), radius_(types + 1, 0.0), part_sums_(parts_.size()),
    known_(exact)
{
}

void MeshMeasure::add(int part, const HexCoords &X, double volume, double mass)
{
  const Part &p = parts_[part];
  sizes_.add(X);
  PartSums &sums = part_sums_[part];
  sums.size += std::cbrt(volume);
  sums.number += 1.0;
  if (slenderness(X) > (1.0 + 1e-9) * slender_from) sums.slender += 1.0;
  if (!p.law->rigid()) {
    sizes_.add_force(X, p.law->elastic());
    const StableSteps its = steps_of(part, X, mass);
    steps_.elements = std::min(steps_.elements, its.elements);
    steps_.des = std::min(steps_.des, its.des);
    steps_.joints = std::min(steps_.joints, its.joints);
  }
  if (!p.converts) return;
  double r = 0.5 * std::cbrt(volume / p.split.des());
  if (!fe::is_box(X))
    for (const auto &d : convert_hex(X, X, HexCoords::Zero(), mass, p.split))
      r = std::max(r, d.radius);
  radius_[p.type] = std::max(radius_[p.type], r);
}

StableSteps MeshMeasure::steps_of(int part, const HexCoords &X, double mass)
{
  const Part &p = parts_[part];
  const HexCoords shape = known_.shape(X);
  if (const auto *known = known_.find(part, shape)) return *known;
  StableSteps its;
  if (p.converts) {
    const auto &elastic = p.law->elastic();
    its = discrete_steps(shape, elastic, exact_ ? elastic.rho * fe::volume(shape) : mass, p.split);
  }
  its.elements = p.law->critical_step(shape);
  known_.add(part, shape, its);
  return its;
}

}    // namespace defe
