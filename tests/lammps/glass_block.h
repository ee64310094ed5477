#ifndef DEFE_TEST_GLASS_BLOCK_H
#define DEFE_TEST_GLASS_BLOCK_H

// A block of glass cubes, alone in its box.

#include "lammps_run.h"

#include <random>

namespace defe::test {

struct Block {
  int n[3] = {4, 3, 2};
  double h = 2e-3;
  double flat = 1.0;    // height of the elements along z by h
  double lo[3] = {0.0, 0.0, 0.0};
  double box_lo[3] = {-0.02, -0.02, -0.02};
  double box_hi[3] = {0.03, 0.03, 0.03};
  std::string boundary = "f f f";
  std::string closed;    // axes across which the mesh is closed with itself
  double E = 74.09e9, nu = 0.2, rho = 2500.0;
  double dt = 5e-8;
  double skin = 5e-4;
  std::string processors;                                 // * * * if empty
  std::string regions;                                    // commands before the fix
  std::string options;                                    // of fix defe
  std::string convert = "1e12 type 2 group particles";    // of keyword convert
  std::string pair = "defe/joint";
  std::string coeff = "connective material cohesive 1e12 1e6 0.1 contact 0.9 0.2";

  int elements() const { return n[0] * n[1] * n[2]; }
  int nodes() const { return (n[0] + 1) * (n[1] + 1) * (n[2] + 1); }
  double mass() const { return elements() * element_mass(); }
  double element_mass() const { return rho * h * h * h * flat; }
  Vec3 centre() const
  {
    return Vec3(lo[0] + 0.5 * n[0] * h, lo[1] + 0.5 * n[1] * h, lo[2] + 0.5 * n[2] * h * flat);
  }
  Vec3 element_centre(int i, int j, int k) const
  {
    return Vec3(lo[0] + (i + 0.5) * h, lo[1] + (j + 0.5) * h, lo[2] + (k + 0.5) * h * flat);
  }

  std::string header() const
  {
    std::string s = script_head(boundary);
    if (!processors.empty()) s += "processors " + processors + "\n";
    return s;
  }

  std::string box() const
  {
    std::string s = "region box block";
    for (int k = 0; k < 3; k++) s += " " + number(box_lo[k]) + " " + number(box_hi[k]);
    return s + "\ncreate_box 2 box\n";
  }

  std::string fix() const
  {
    return regions + "\npair_style " + pair + "\npair_coeff 2 2 " + coeff +
        "\ngroup particles empty\n" + fix_only();
  }

  /// After read_restart, which brings the rest.
  std::string fix_only() const
  {
    return "fix fe all defe material glass elastic " + number(E) + " " + number(nu) + " " +
        number(rho) + " convert glass " + convert + " " + options + "\n";
  }

  std::string mesh() const
  {
    std::string s = "create_hexes fe glass 1";
    for (int k = 0; k < 3; k++)
      s += std::string(" ") + "xyz"[k] + " " + number(lo[k]) + " " + std::to_string(n[k]) + " " +
          number(lo[k] + n[k] * h * (k == 2 ? flat : 1.0));
    return s + (closed.empty() ? "\n" : " closed " + closed + "\n");
  }

  std::string motion() const
  {
    return "group nodes type 1\nfix move1 nodes nve\nfix move2 particles nve/sphere\nneighbor " +
        number(skin) + " bin\nneigh_modify every 1 delay 0 check yes\ntimestep " + number(dt) +
        "\n";
  }

  std::string script() const { return header() + box() + fix() + mesh() + motion(); }
};

/// A region that holds the centres of these elements, for `start`.
inline std::string region_of(const std::string &name, const std::vector<Vec3> &centres, double h)
{
  std::string s, list;
  for (size_t k = 0; k < centres.size(); k++) {
    const std::string one = name + std::to_string(k);
    s += "region " + one + " sphere " + number(centres[k][0]) + " " + number(centres[k][1]) + " " +
        number(centres[k][2]) + " " + number(0.1 * h) + "\n";
    list += " " + one;
  }
  if (centres.size() == 1) return s + "region " + name + " intersect 2" + list + list + "\n";
  return s + "region " + name + " union " + std::to_string(centres.size()) + list + "\n";
}

/// Random numbers that depend on the atom's ID only, in (-1, 1).
inline Vec3 random_of(tagint tag, unsigned seed)
{
  std::mt19937 random(static_cast<unsigned>(tag) * 7919u + seed);
  random.discard(10);
  std::uniform_real_distribution<double> uniform(-1.0, 1.0);
  const double a = uniform(random), b = uniform(random), c = uniform(random);
  return Vec3(a, b, c);
}

}    // namespace defe::test

#endif
