#include "defe/fe/element_batch.h"

#include "defe/fe/hex8.h"
#include "defe/fe/prestress.h"

#include <algorithm>

namespace defe::fe {

KernelChoice::KernelChoice(const MaterialLaw &law, const HexCoords &X, const KernelRules &rules,
                           const Mat3 *prestress) :
    shape(rules.exact ? rounded_shape(X) : X),
    of_shape(!law.rigid() && !rules.lagrangian && !(prestress && rules.own_stress)),
    exact(rules.exact), prestressed(prestress != nullptr),
    stress(prestress ? *prestress : Mat3(Mat3::Zero()))
{
  if (!of_shape) return;
  // to first order, which is exact enough to tell whether a box stays one
  HexCoords free = shape;
  if (prestressed) free -= strain_of_stress(stress, law.elastic()) * shape;
  of_shape = law.has_shape_kernel(free);
}

ElementBatch::ElementBatch(int part, const MaterialLaw &law, const KernelChoice &choice) :
    part_(part), choice_(choice)
{
  if (law.rigid()) return;
  if (choice.of_shape && choice.prestressed)
    make_prestressed_kernel(law);
  else
    kernel_ = choice.of_shape ? law.make_shape_kernel(choice.shape) : law.make_kernel();
}

void ElementBatch::make_prestressed_kernel(const MaterialLaw &law)
{
  const HexCoords X = choice_.shape.colwise() - choice_.shape.col(0);
  const Mat3 map = fe::stress_free_map(choice_.stress, law.elastic(), [&](const Mat3 &F) {
    return mean_cauchy_stress(*law.make_shape_kernel(F.inverse() * X), X, X);
  });
  kernel_ = law.make_shape_kernel(map * X);
}

Mat3 ElementBatch::stress_free_map(const Mat3 &sigma) const
{
  HexCoords cube;
  for (int a = 0; a < 8; ++a)
    for (int k = 0; k < 3; ++k) cube(k, a) = hex_sign[a][k];
  return fe::stress_free_map(sigma, kernel_->material(), [&](const Mat3 &F) {
    return mean_cauchy_stress(*kernel_, cube, F.inverse() * cube);
  });
}

HexCoords ElementBatch::reference(int e) const
{
  return Eigen::Map<const HexCoords>(&own_X_[24 * static_cast<size_t>(e)]);
}

bool ElementBatch::takes(int part, const KernelChoice &c) const
{
  if (part != part_) return false;
  if (rigid()) return true;
  if (c.of_shape != choice_.of_shape || c.prestressed != choice_.prestressed) return false;
  if (!c.of_shape) return true;
  if (c.stress != choice_.stress) return false;
  return c.exact ? choice_.shape == c.shape : congruent(choice_.shape, c.shape);
}

void ElementBatch::clear()
{
  node_.clear();
  bound_.clear();
  history_.clear();
  own_X_.clear();
}

void ElementBatch::add(const std::array<int, 8> &nodes, double *history,
                       const HexCoords *stress_free)
{
  node_.push_back(nodes);
  if (history) history_.push_back(history);
  if (stress_free) own_X_.insert(own_X_.end(), stress_free->data(), stress_free->data() + 24);
}

void ElementBatch::remove(int e)
{
  const auto drop = [e](auto &list, size_t each) {
    if (list.empty()) return;
    const size_t last = list.size() - each;
    if (each * e != last) std::copy_n(list.begin() + last, each, list.begin() + each * e);
    list.resize(last);
  };
  const size_t last = node_.size() - 1, at = static_cast<size_t>(e);
  if (at < bound_.size()) bound_[at] = last < bound_.size() ? bound_[last] : 0.0;
  if (bound_.size() > last) bound_.resize(last);
  drop(node_, 1);
  drop(history_, 1);
  drop(own_X_, 24);
}

void ElementBatch::finish()
{
  if (node_.capacity() > node_.size() + node_.size() / 4) node_.shrink_to_fit();
  bound_.resize(node_.size(), 0.0);
  if (!own_reference()) return;
  own_node_.resize(node_.size());
  for (size_t e = 0; e < node_.size(); ++e)
    for (int a = 0; a < 8; ++a) own_node_[e][a] = static_cast<int>(8 * e) + a;
}

/// With stress-free shapes of their own, elements do not share nodes: positions are copied, and forces added after.
void ElementBatch::add_forces(const double *x, const double *X, double *f,
                              const HexKernel::Output &out)
{
  if (!own_reference()) {
    kernel_->add_forces(size(), flat(node_), x, X, f, out);
    return;
  }
  const size_t n = node_.size();
  own_x_.resize(24 * n);
  own_f_.assign(24 * n, 0.0);
  const auto at = [](size_t e, int a) {
    return 3 * (8 * e + static_cast<size_t>(a));
  };
  for (size_t e = 0; e < n; ++e)
    for (int a = 0; a < 8; ++a)
      std::copy_n(x + 3 * static_cast<std::ptrdiff_t>(node_[e][a]), 3, &own_x_[at(e, a)]);
  kernel_->add_forces(size(), flat(own_node_), own_x_.data(), own_X_.data(), own_f_.data(), out);
  for (size_t e = 0; e < n; ++e)
    for (int a = 0; a < 8; ++a)
      for (int k = 0; k < 3; ++k)
        f[3 * static_cast<std::ptrdiff_t>(node_[e][a]) + k] += own_f_[at(e, a) + k];
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
  add_forces(x, X, f, out);
  return faults;
}

void ElementBatch::energy(const double *x, const double *X, double *f, double &sum)
{
  if (rigid() || node_.empty()) return;
  energy_.assign(node_.size(), 0.0);
  HexKernel::Output out;
  out.energy = energy_.data();
  if (!history_.empty()) out.history = history_.data();
  add_forces(x, X, f, out);
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
