#include "defe/coupling/mesh_measure.h"

#include "defe/coupling/conversion.h"
#include "defe/fe/hex8.h"
#include "defe/fe/stable_step.h"

#include <algorithm>
#include <cmath>

namespace defe {

using fe::HexCoords;

StableSteps discrete_steps(const HexCoords &X, const fe::IsotropicElastic &elastic, double mass)
{
  const CornerModuli moduli{elastic.lambda(), elastic.mu()};
  const auto eight = convert_hex(X, X, HexCoords::Zero(), mass);
  StableSteps steps;
  steps.des = 0.5 * fe::critical_step(X, elastic);
  for (int k = 0; k < 8; k++) {
    auto cell = cell_of(eight, k);
    for (int s = 0; s < 6; s++)
      if (slot_is_outer(k, s)) cell.dX[s] = 2.0 * cell.face[s];
    steps.joints = std::min(steps.joints, lattice_critical_step(cell, 0x3f, moduli, 0.125 * mass));
    steps.des = std::min(steps.des, softening_critical_step(cell, 0x3f, moduli, 0.125 * mass));
    for (int s = 0; s < 6; s++)
      if (slot_is_outer(k, s)) {
        cell.dX[s] = cell.face[s];
        cell.tie |= static_cast<unsigned char>(1 << s);
      }
    steps.des = std::min(steps.des, lattice_critical_step(cell, 0x3f, moduli, 0.125 * mass));
  }
  return steps;
}

double slenderness(const HexCoords &X)
{
  const auto lengths = fe::jacobian(X, Vec3::Zero()).colwise().norm();
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
  double r = 0.5 * std::cbrt(volume / 8.0);
  if (!fe::is_box(X))
    for (const auto &d : convert_hex(X, X, HexCoords::Zero(), mass)) r = std::max(r, d.radius);
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
    its = discrete_steps(shape, elastic, exact_ ? elastic.rho * fe::volume(shape) : mass);
  }
  its.elements = p.law->critical_step(shape);
  known_.add(part, shape, its);
  return its;
}

}    // namespace defe
