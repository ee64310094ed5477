#include "defe/coupling/tied_surfaces.h"

#include "number_words.h"

#include <algorithm>
#include <cmath>

namespace defe {

// ---- forces ----

void TiedSurfaces::clear()
{
  first_.clear();
  node_.clear();
  matrix_.clear();
}

void TiedSurfaces::add(const Tie &tie, const int *node)
{
  first_.push_back({tie.nodes, node_.size(), matrix_.size()});
  node_.insert(node_.end(), node, node + tie.nodes);
  for (int a = 0; a < tie.nodes; a++)
    for (int b = 0; b < tie.nodes; b++) {
      const int row = std::max(a, b), column = std::min(a, b);
      matrix_.push_back(tie.M[row * (row + 1) / 2 + column]);
    }
}

struct TiedSurfaces::Local {
  double x[Tie::most_nodes][3],
      u[Tie::most_nodes][3];    // from the first node, so that no digits are lost
  double f[Tie::most_nodes][3];
};

void TiedSurfaces::evaluate(const Place &p, const double *x, const double *X, Local &l) const
{
  const int *node = &node_[p.node];
  const double *M = &matrix_[p.matrix];
  const std::size_t zero = 3 * static_cast<std::size_t>(node[0]);
  for (int a = 0; a < p.nodes; a++) {
    const std::size_t i = 3 * static_cast<std::size_t>(node[a]);
    for (int k = 0; k < 3; k++) {
      l.x[a][k] = x[i + k] - x[zero + k];
      l.u[a][k] = l.x[a][k] - (X[i + k] - X[zero + k]);
    }
  }
  for (int a = 0; a < p.nodes; a++) {
    double sum[3] = {0.0, 0.0, 0.0};
    for (int b = 0; b < p.nodes; b++)
      for (int k = 0; k < 3; k++) sum[k] += M[a * p.nodes + b] * l.u[b][k];
    for (int k = 0; k < 3; k++) l.f[a][k] = -sum[k];
  }
}

int TiedSurfaces::forces(const double *x, const double *X, double *f, const SumGrid &grid,
                         double *virial) const
{
  int beyond = -1;
  Local l;
  for (const auto &p : first_) {
    evaluate(p, x, X, l);
    for (int a = 0; a < p.nodes; a++) {
      const int i = node_[p.node + a];
      double *to = f + 3 * static_cast<std::size_t>(i);
      for (int k = 0; k < 3; k++) {
        double &value = l.f[a][k];
        if (grid.on()) {
          value = grid.round(value);
          if (grid.beyond(value)) beyond = i;
        }
        to[k] += value;
      }
      if (!virial) continue;
      for (int k = 0; k < 3; k++) virial[k] += l.x[a][k] * l.f[a][k];
      virial[3] += l.x[a][0] * l.f[a][1];
      virial[4] += l.x[a][0] * l.f[a][2];
      virial[5] += l.x[a][1] * l.f[a][2];
    }
  }
  return beyond;
}

double TiedSurfaces::energy(const double *x, const double *X, double *f) const
{
  double sum = 0.0;
  Local l;
  for (const auto &p : first_) {
    evaluate(p, x, X, l);
    for (int a = 0; a < p.nodes; a++)
      for (int k = 0; k < 3; k++) {
        f[3 * static_cast<std::size_t>(node_[p.node + a]) + k] += l.f[a][k];
        sum -= 0.5 * l.u[a][k] * l.f[a][k];
      }
  }
  return sum;
}

double TiedSurfaces::energy_of(int tie, const double *x, const double *X, const double *v,
                               double &power) const
{
  double sum = 0.0;
  power = 0.0;
  Local l;
  const Place &p = first_[tie];
  evaluate(p, x, X, l);
  for (int a = 0; a < p.nodes; a++)
    for (int k = 0; k < 3; k++) {
      sum -= 0.5 * l.u[a][k] * l.f[a][k];
      power += l.f[a][k] * v[3 * static_cast<std::size_t>(node_[p.node + a]) + k];
    }
  return sum;
}

// ---- words ----

ParsedTie parse_tie(const std::vector<std::string> &words)
{
  ParsedTie parsed;
  bool given[2] = {false, false};
  while (parsed.used < static_cast<int>(words.size())) {
    const std::string &key = words[parsed.used];
    const bool distance = key == "distance";
    if (!distance && key != "stiffness") break;
    double &value = distance ? parsed.rule.distance : parsed.rule.stiffness;
    bool &twice = given[distance ? 0 : 1];
    if (twice) {
      parsed.complaint = key + " is given twice";
      return parsed;
    }
    twice = true;
    if (parsed.used + 1 == static_cast<int>(words.size())) {
      parsed.complaint = key + " needs a number";
      return parsed;
    }
    value = positive_number(key, words[parsed.used + 1], parsed.complaint);
    if (!parsed.complaint.empty()) return parsed;
    parsed.used += 2;
  }
  return parsed;
}

std::string words_of(const TieRule &rule)
{
  std::string words = "stiffness " + written(rule.stiffness);
  if (rule.distance >= 0.0) words = "distance " + written(rule.distance) + " " + words;
  return words;
}

}    // namespace defe
