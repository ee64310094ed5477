#include "defe/fe/element_batch.h"

#include "defe/fe/hex8.h"

#include <algorithm>

namespace defe::fe {

KernelChoice::KernelChoice(const MaterialLaw &law, const HexCoords &X, const KernelRules &rules) :
    shape(rules.exact ? rounded_shape(X) : X),
    of_shape(!law.rigid() && !rules.lagrangian && law.has_shape_kernel(shape)), exact(rules.exact)
{
}

ElementBatch::ElementBatch(int part, const MaterialLaw &law, const KernelChoice &choice) :
    part_(part), choice_(choice)
{
  if (!law.rigid())
    kernel_ = choice.of_shape ? law.make_shape_kernel(choice.shape) : law.make_kernel();
}

bool ElementBatch::takes(int part, const KernelChoice &c) const
{
  if (part != part_) return false;
  if (rigid()) return true;
  if (c.of_shape != choice_.of_shape) return false;
  if (!c.of_shape) return true;
  return c.exact ? choice_.shape == c.shape : congruent(choice_.shape, c.shape);
}

void ElementBatch::clear()
{
  node_.clear();
  bound_.clear();
  history_.clear();
}

void ElementBatch::add(const std::array<int, 8> &nodes, double *history)
{
  node_.push_back(nodes);
  if (history) history_.push_back(history);
}

void ElementBatch::finish()
{
  if (node_.capacity() > node_.size() + node_.size() / 4) node_.shrink_to_fit();
  bound_.assign(node_.size(), 0.0);
}

ElementBatch::Faults ElementBatch::forces(const double *x, const double *X, double *f,
                                          const Output &what)
{
  Faults faults;
  if (rigid() || node_.empty()) return faults;
  HexKernel::Output out;
  if (what.bound) {
    out.stress_bound = bound_.data();
    out.bound_weights = *what.bound;
  }
  out.bound_at_gauss_points = what.bound_at_gauss_points;
  out.virial = what.virial;
  if (!history_.empty()) {
    out.history = history_.data();
    out.dt = what.history_step;
    out.dissipation = what.dissipation;
  }
  out.inverted = &faults.inverted;
  if (what.grid) {
    out.grid = what.grid;
    out.beyond = &faults.beyond;
  }
  kernel_->add_forces(size(), flat(), x, X, f, out);
  return faults;
}

void ElementBatch::energy(const double *x, const double *X, double *f, double &sum)
{
  if (rigid() || node_.empty()) return;
  energy_.assign(node_.size(), 0.0);
  HexKernel::Output out;
  out.energy = energy_.data();
  if (!history_.empty()) out.history = history_.data();
  kernel_->add_forces(size(), flat(), x, X, f, out);
  for (double e : energy_) sum += e;
}

double ElementBatch::longest(const double *x, double enough, double longest) const
{
  for (const auto &idx : node_) {
    double box = 0.0;    // a bound: diagonal of the box around it
    for (int d = 0; d < 3; d++) {
      double lo = x[3 * idx[0] + d], hi = lo;
      for (int a = 1; a < 8; a++) {
        lo = std::min(lo, x[3 * idx[a] + d]);
        hi = std::max(hi, x[3 * idx[a] + d]);
      }
      box += (hi - lo) * (hi - lo);
    }
    if (box <= enough * enough) continue;
    HexCoords now;
    for (int a = 0; a < 8; a++)
      for (int d = 0; d < 3; d++) now(d, a) = x[3 * idx[a] + d];
    longest = std::max(longest, max_diagonal(now));
  }
  return longest;
}

}    // namespace defe::fe
