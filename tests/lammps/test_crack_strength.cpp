// Strength in every direction through LAMMPS: a block in homogeneous tension, its lattice turned, is damaged
// first at sigma_t, on cubes, bricks of 2:1 and nodes moved at random. DEFE_LONG_TESTS=1 adds directions.
//
// All nodes and DEs move as a homogeneous strain has it, so that the stress is known.
//
// ranks: 1

#include "crack_strip.h"

#include <random>

using namespace defe::test;
using defe::Mat3;
using defe::Vec3;

namespace {

constexpr double E = 74.09e9, nu = 0.2, sigma_t = 60e6, h = 2e-3;

struct Stretched {
  std::string name;
  Mat3 turn = Mat3::Identity();
  bool bricks = false;
  double moved = 0.0;
  bool adaptive = false, equibiaxial = false;
  std::string law = "";
  double about = 1.0;    // where it is looked for, by sigma_t
};

/// Stress at the first damage over sigma_t; on the way it grows by 0.25 % in each step.
double strength(const Stretched &b, std::vector<Event> *first = nullptr)
{
  const double begin = 0.9 * b.about, step = 0.0025 * b.about, dt = 1e-8;
  MeshFile mesh;
  tagint tag = 0;
  constexpr int n = 4;
  mesh.add_block("glass", 1, n, n, n, h, [&](const Vec3 &X) {
    Vec3 c = X - Vec3::Constant(0.5 * n * h) + b.moved * h * random_of(++tag, 5);
    if (b.bricks) c[0] *= 2.0;
    return Vec3(b.turn * c);
  });
  mesh.write("block.data");
  remove_file("strength.txt");
  Lammps lmp;
  lmp.commands(
      script_head() +
      "region box block -0.02 0.03 -0.02 0.03 -0.02 0.03\ncreate_box 2 box\npair_style defe/joint\n"
      "pair_coeff 2 2 connective material cohesive 60e6 10 0.1 " +
      b.law +
      " contact 0.9 0.2\n"
      "group particles empty\nfix fe all defe material glass elastic 74.09e9 0.2 2500 convert "
      "glass 56e6 "
      "type 2 group particles start " +
      (b.adaptive ? "no" : "all") + " shield no events strength.txt\n" + read_mesh("block.data") +
      "group nodes type 1\nfix move1 nodes nve\nfix move2 particles nve/sphere\n"
      "fix drive1 nodes setforce 0 0 0\nfix drive2 particles setforce 0 0 0\n"
      "neighbor 3e-4 bin\ntimestep " +
      number(dt) + "\n");
  Vec3 strain(-nu, 1.0, -nu);    // of a tension along y, or all across it
  if (b.equibiaxial) strain = Vec3(1.0 - nu, -2.0 * nu, 1.0 - nu);
  strain *= sigma_t / E;
  lmp.change([&](Particle &p) {
    const Vec3 u = strain.cwiseProduct(p.x);
    p.x += begin * u;
    p.v = step / dt * u;
  });
  lmp.run(60);
  MPI_Barrier(MPI_COMM_WORLD);
  std::vector<Event> events = read_events("strength.txt", "cohesive");
  if (events.empty()) return HUGE_VAL;
  const long when = events.front().step;
  if (first) {
    first->clear();
    for (const auto &e : events)
      if (e.step == when) first->push_back(e);
  }
  return begin + step * static_cast<double>(when - 1);    // decided upon in the step before
}

std::vector<std::pair<std::string, Mat3>> orientations()
{
  std::vector<std::pair<std::string, Mat3>> all = {{"0", turned(0)},
                                                   {"15", turned(15)},
                                                   {"30", turned(30)},
                                                   {"45", turned(45)},
                                                   {"[111]", with_along_y({1, 1, 1})}};
  std::mt19937 random(4);
  std::normal_distribution<double> normal;
  for (int k = 0; k < (std::getenv("DEFE_LONG_TESTS") ? 20 : 2); k++) {
    const double a = normal(random), b = normal(random), c = normal(random);
    all.emplace_back("random " + std::to_string(k), with_along_y(Vec3(a, b, c)));
  }
  return all;
}

void expect_strength(Stretched b, double tolerance)
{
  for (const auto &[name, turn] : orientations()) {
    b.turn = turn;
    std::vector<Event> first;
    const double s = strength(b, &first);
    EXPECT_NEAR(s, 1.0, tolerance) << b.name << " " << name;
    for (const auto &e : first)
      if (b.equibiaxial)
        EXPECT_LT(std::abs(e.n[1]), 1e-3) << b.name << " " << name;
      else
        EXPECT_GT(std::abs(e.n[1]), 1.0 - 1e-3) << b.name << " " << name;
  }
}

}    // namespace

TEST(CrackStrength, Cubes)
{
  expect_strength({"cubes"}, 0.03);
}

TEST(CrackStrength, Bricks)
{
  Stretched b{"bricks"};
  b.bricks = true;
  expect_strength(b, 0.03);
}

TEST(CrackStrength, NodesMoved)
{
  Stretched b{"moved"};
  b.moved = 0.2;
  expect_strength(b, 0.03);
}

TEST(CrackStrength, EquibiaxialTension)
{
  Stretched b{"equibiaxial"};
  b.equibiaxial = true;
  expect_strength(b, 0.03);
}

TEST(CrackStrength, ElementsThatConvert)
{
  Stretched b{"adaptive"};
  b.adaptive = true;
  expect_strength(b, 0.03);
}

// The paper's law knows the mesh: a joint feels cos^2 of its angle to the tension, and beta times the shear.
TEST(CrackStrength, LatticeLawKnowsTheMesh)
{
  for (const auto &[turn, cosine] : {std::pair(turned(0), 1.0),
                                     {turned(45), std::sqrt(0.5)},
                                     {with_along_y({1, 1, 1}), std::sqrt(1.0 / 3.0)}}) {
    Stretched b{"lattice"};
    b.law = "lattice";
    b.turn = turn;
    const double normal = cosine * cosine, shear = cosine * std::sqrt(1.0 - normal);
    b.about = 1.0 / std::hypot(normal, 0.1 * shear);
    EXPECT_NEAR(strength(b) / b.about, 1.0, 0.01);
  }
}
