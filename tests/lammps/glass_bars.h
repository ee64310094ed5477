#ifndef DEFE_TEST_GLASS_BARS_H
#define DEFE_TEST_GLASS_BARS_H

// Many small bars of glass side by side in one box, all pulled or bent alike, each until it breaks at a strength of its own.

#include "events.h"
#include "lammps_run.h"

#include <algorithm>
#include <cmath>
#include <string>
#include <vector>

namespace defe::test {

struct Bars {
  int rows = 10, columns = 10;
  int along = 4, across = 2;    // elements of a bar
  double length = 4e-3, width = 2e-3;
  double E = 74.09e9, nu = 0.2, rho = 2500.0;
  double sigma_t = 60e6, convert = 54e6;
  std::string start;                  // of keyword convert
  std::string coeff = "scatter 0";    // behind the numbers of cohesive
  std::string strength = "strength glass constant 60e6";
  std::string options;
  bool bend =
      false;    // or pull. At their centers elements do not see what their outer DEs will bear
  double most = 80e6;    // tension at the end of all steps; bent, of the outermost DEs
  int steps = 400;

  int count() const { return rows * columns; }
  double h() const { return length / along; }
  double dt() const { return 5e-8 * h() / 1e-3 * std::sqrt(rho / 2500.0); }
  double rate() const { return most / E / (steps * dt()); }
  double pitch() const { return 2.0 * width; }
  double volume() const { return length * width * width; }
  double surface() const { return 4.0 * length * width + 2.0 * width * width; }
  /// Tension at the end of a step.
  double tension(double step) const { return E * rate() * step * dt(); }

  std::string header() const { return script_head(); }
  std::string fix() const
  {
    return "fix fe all defe material glass elastic " + number(E) + " " + number(nu) + " " +
        number(rho) + " convert glass " + number(convert) + " type 2 group particles " + start +
        " shield no stress " + (bend ? "gauss " : "centre ") + strength + " " + options + "\n";
  }
  std::string mesh() const
  {
    std::string s;
    for (int b = 0; b < count(); b++) {
      s += "create_hexes fe glass 1 x 0 " + std::to_string(along) + " " + number(length);
      for (int k = 0; k < 2; k++) {
        const double lo = pitch() * (k ? b / columns : b % columns);
        s += std::string(k ? " z " : " y ") + number(lo) + " " + std::to_string(across) + " " +
            number(lo + width);
      }
      s += "\n";
    }
    return s;
  }
  /// The ends are drawn apart at a constant rate: nodes there, and DEs that take their place.
  std::string motion() const
  {
    return "region left block INF " + number(0.3 * h()) + " INF INF INF INF\nregion right block " +
        number(length - 0.3 * h()) +
        " INF INF INF INF INF\nregion ends union 2 left right\ngroup nodes type 1\n"
        "fix move1 nodes nve\nfix move2 particles nve/sphere\nfix pull all setforce 0 NULL NULL "
        "region ends\n"
        "neighbor 5e-4 bin\nneigh_modify every 1 delay 0 check yes\ntimestep " +
        number(dt()) + "\n";
  }
  std::string script() const
  {
    return header() + "region box block -0.01 " + number(length + 0.01) + " -0.01 " +
        number(pitch() * columns + 0.01) + " -0.01 " + number(pitch() * rows + 0.01) +
        "\ncreate_box 2 box\npair_style defe/joint\npair_coeff 2 2 connective material cohesive " +
        number(sigma_t) + " 10 0.1 " + coeff + " contact 0.9 0.2\ngroup particles empty\n" + fix() +
        mesh() + motion();
  }
  /// A field that is in equilibrium at any time grows with the rate, from rest to motion at once: uniaxial tension
  /// everywhere, or pure bending about z, tension where y is least.
  void load(Lammps &lmp) const
  {
    lmp.change([this](Particle &p) {
      double at[3] = {p.x[0] - 0.5 * length, 0.0, 0.0};    // from the middle of the bar
      for (int k = 1; k < 3; k++)    // a bar begins at a multiple of the pitch
        at[k] = p.x[k] - pitch() * std::floor((p.x[k] + 0.25 * width) / pitch()) - 0.5 * width;
      const auto [x, y, z] = at;
      if (!bend) {
        p.v = rate() * Vec3(x, -nu * y, -nu * z);
        return;
      }
      const double curving = rate() / outermost();
      p.v = curving * Vec3(-x * y, 0.5 * (x * x + nu * (y * y - z * z)), nu * y * z);
    });
  }
  /// Of the middles of DEs, from that of the bar.
  double outermost() const { return 0.5 * width * (1.0 - 0.5 / across); }
  /// Area of the surface of DEs, weighted with the power `shape` of their tension over the largest.
  double effective_surface(double shape) const
  {
    if (!bend) return surface();
    const int n = 2 * across, m = 2 * along;
    double sum = 0.0;
    for (int i = 0; i < m; i++)
      for (int j = 0; j < n / 2; j++)
        for (int k = 0; k < n; k++) {
          const int faces = (i == 0) + (i == m - 1) + (j == 0) + (k == 0) + (k == n - 1);
          const double tension = (n - 1.0 - 2.0 * j) / (n - 1.0);
          sum += faces * 0.25 * h() * h() * std::pow(tension, shape);
        }
    return sum;
  }
  int bar_of(const double *x) const
  {
    return static_cast<int>((x[2] + 0.25 * width) / pitch()) * columns +
        static_cast<int>((x[1] + 0.25 * width) / pitch());
  }

  /// Tension at which the first joint of each bar softens; infinite: none has.
  std::vector<double> strengths(const std::string &events) const
  {
    std::vector<double> first(count(), HUGE_VAL);
    for (const Event &e : read_events(events, "cohesive")) {
      double &s = first[bar_of(e.x)];
      s = std::min(s, tension(static_cast<double>(e.step)));
    }
    return first;
  }
};

/// Shape and scale of a sample from a Weibull distribution, by maximum likelihood.
struct Fit {
  double shape, scale;
};

inline Fit fit_weibull(const std::vector<double> &sample)
{
  const double n = static_cast<double>(sample.size());
  double logs = 0.0;
  for (double s : sample) logs += std::log(s) / n;
  const auto sums = [&](double shape) {
    double powers = 0.0, weighted = 0.0;
    for (double s : sample) {
      const double l = std::log(s) - logs, power = std::exp(shape * l);
      powers += power;
      weighted += power * l;
    }
    return std::pair(powers, weighted);
  };
  double low = 0.1, high = 100.0;    // weighted/powers - 1/shape rises with the shape
  for (int k = 0; k < 60; k++) {
    const double shape = 0.5 * (low + high);
    const auto [powers, weighted] = sums(shape);
    (weighted / powers - 1.0 / shape < 0.0 ? low : high) = shape;
  }
  return {low, std::exp(logs) * std::pow(sums(low).first / n, 1.0 / low)};
}

/// Tension at which each bar broke, and the least strength that was drawn for it.
struct Broken {
  std::vector<double> tension, drawn;
};

inline Broken break_all(const Bars &bars, const std::string &events, MPI_Comm comm = MPI_COMM_WORLD)
{
  Bars with = bars;
  with.options = "events " + events;
  remove_file(events, comm);
  Broken result{{}, std::vector<double>(bars.count(), HUGE_VAL)};
  {
    Lammps lmp(comm);
    lmp.commands(
        with.script() +
        "compute drawn all defe/hex/local x y z strength\ncompute born all defe/atom strength\n");
    lmp.run(0);
    for (const auto &e : lmp.local("drawn")) {
      double &least = result.drawn[bars.bar_of(e.data())];
      least = std::min(least, e[3]);
    }
    const auto born = lmp.per_atom("born");
    for (const auto &[tag, p] : lmp.particles()) {
      double &least = result.drawn[bars.bar_of(p.x.data())];
      if (born.at(tag) > 0.0) least = std::min(least, born.at(tag));
    }
    with.load(lmp);
    lmp.run(with.steps);
  }
  MPI_Barrier(comm);
  result.tension = with.strengths(events);
  MPI_Barrier(comm);    // before the file is written anew
  return result;
}

/// Largest distance between a sample and a distribution, times the root of its size. Of a sample from the distribution
/// itself it is above 1.63 once in a hundred times.
constexpr double kolmogorov_1_percent = 1.63;

template <class F> double kolmogorov(std::vector<double> sample, const F &below)
{
  std::sort(sample.begin(), sample.end());
  const double n = static_cast<double>(sample.size());
  double most = 0.0;
  for (std::size_t k = 0; k < sample.size(); k++) {
    const double F_k = below(sample[k]), before = static_cast<double>(k) / n;
    most = std::max({most, F_k - before, before + 1.0 / n - F_k});
  }
  return most * std::sqrt(n);
}

}    // namespace defe::test

#endif
