// Stress before any load (keyword prestress of fix defe): a tempered pane stays still, edges relax, elements become
// DEs that carry the stress, cracks release it, and the account knows its energy.

#include "cracking_beam.h"
#include "failure.h"
#include "mesh_file.h"

#include <gmock/gmock.h>

#include <array>
#include <cmath>
#include <functional>

using namespace defe::test;
using defe::Vec3;
using testing::HasSubstr;

namespace {

constexpr double surface = -100e6;

/// Of 8 mm, in layers of 2 mm.
Block pane(int across = 6)
{
  Block block;
  block.n[0] = block.n[1] = across;
  block.n[2] = 4;
  block.options = "prestress glass parabola z 0 0.008 surface -100e6";
  return block;
}

/// Mean of the parabola over a layer, from the lower face.
double layer_stress(int k, int layers = 4)
{
  const auto integral = [](double s) {    // of (3 s^2 - 1)/2, s from -1 to 1
    return 0.5 * (s * s * s - s);
  };
  const double low = 2.0 * k / layers - 1.0, high = 2.0 * (k + 1) / layers - 1.0;
  return surface * (integral(high) - integral(low)) / (high - low);
}

/// Closed form for elements with the means over their layers: (1 - nu)/E s^2 per volume.
double stored_energy(const Block &b)
{
  double sum = 0.0;
  for (int k = 0; k < b.n[2]; k++)
    sum += (1.0 - b.nu) / b.E * std::pow(layer_stress(k, b.n[2]), 2) * b.h * b.h * b.h * b.n[0] *
        b.n[1];
  return sum;
}

/// Commands that hold the nodes at the four edges.
std::string held_edges(const Block &b)
{
  const double e = 0.01 * b.h;
  std::string s = "region inner block";
  for (int k = 0; k < 2; k++)
    s += " " + number(b.lo[k] + e) + " " + number(b.lo[k] + b.n[k] * b.h - e);
  return s +
      " INF INF\ngroup inner region inner\ngroup edges subtract all inner\n"
      "group held intersect edges nodes\nfix held held setforce 0 0 0\n";
}

const std::string computes = "compute hexes all defe/hex/local id sxx syy szz sxy sxz syz z s1\n";

using Choice = std::pair<std::string, std::function<void(Block &)>>;

/// Ways to the same stress: kernels of layers, of each element, by variables, and with DEs inside.
const Choice choices[] = {{"layers",
                           [](Block &) {
                           }},
                          {"lagrangian",
                           [](Block &b) {
                             b.options += " kernel lagrangian";
                           }},
                          {"reproducible",
                           [](Block &b) {
                             b.options += " reproducible yes";
                           }},
                          {"DEs inside",
                           [](Block &b) {
                             b.regions = "region core block 0.004 0.008 0.002 0.010 INF INF\n";
                             b.convert += " start core";
                           }},
                          {"every", [](Block &b) {
                             b.options += " every 2";
                           }}};

}    // namespace

TEST(Prestress, PaneWithHeldEdgesStaysStill)
{
  for (const auto &[name, change] : choices) {
    SCOPED_TRACE(name);
    Block block = pane();
    change(block);
    const double sigma_A = std::abs(surface) * block.h * block.h, energy = stored_energy(block);
    Lammps lmp;
    lmp.commands(block.script() + held_edges(block) + computes);
    lmp.run(0);
    // the digits of positions, and of the shapes where these are rounded
    const double small = name == "reproducible" ? 2e-9 : 1e-10;
    double force = 0.0;
    for (const auto &p : lmp.particles()) force = std::max(force, p.second.f.norm());
    EXPECT_LT(force, small * sigma_A);
    const double stored = lmp.fe(E_ELEMENTS) + lmp.fe(E_JOINTS) + lmp.fe(E_TIES);
    EXPECT_NEAR(stored, energy, 3e-3 * energy) << "laws at a strain of 1e-3";
    EXPECT_NEAR(lmp.fe(TOTAL), stored, 1e-12 * energy);
    for (const auto &row : lmp.local("hexes")) {
      const double s = layer_stress(static_cast<int>(row[7] / block.h));
      EXPECT_NEAR(row[1], s, 2e-3 * std::abs(surface));
      EXPECT_NEAR(row[2], s, 2e-3 * std::abs(surface));
      for (int k = 3; k < 7; k++) EXPECT_NEAR(row[k], 0.0, 1e-3 * std::abs(surface));
    }
    lmp.run(200);
    EXPECT_LT(largest(lmp.particles(), &Particle::v), 1e-8);
    EXPECT_NEAR(lmp.fe(TOTAL), stored, 1e-11 * stored);
  }
}

// The same stress by variables, on elements of any shape.
TEST(Prestress, ByVariablesAndInDistortedLayers)
{
  constexpr int n = 5, layers = 4;
  constexpr double h = 2e-3;
  for (const bool variables : {false, true}) {
    SCOPED_TRACE(variables);
    MeshFile mesh;
    tagint tag = 0;
    mesh.types = 2;
    mesh.add_block("glass", 1, n, n, layers, h, [&](const Vec3 &X) {
      Vec3 moved = X + 0.1 * h * random_of(++tag, 3);
      moved[2] = X[2];
      return moved;
    });
    mesh.write("layers.data");
    Block block = pane();
    if (variables) block.options = "prestress glass variables v_sxx NULL NULL v_sxy NULL v_syz";
    Lammps lmp;
    lmp.commands(block.header() + block.box() + block.fix() + read_mesh("layers.data") +
                 block.motion() +
                 "variable sxx atom 8e7\nvariable sxy atom -3e7\nvariable syz atom 2e7*(1+0*z)\n" +
                 computes);
    lmp.run(0);
    const double sigma_A = std::abs(surface) * h * h;
    int inner = 0;
    for (const auto &it : lmp.particles()) {
      const Vec3 x = it.second.x;
      if (std::min({x[0], x[1], variables ? x[2] : 1.0}) < 0.5 * h) continue;
      if (std::max({x[0], x[1], variables ? x[2] : 0.0}) > (n - 0.5) * h) continue;
      if (variables && x[2] > (layers - 0.5) * h) continue;
      EXPECT_LT(it.second.f.norm(), 1e-10 * sigma_A);
      inner++;
    }
    EXPECT_EQ(inner, (n - 1) * (n - 1) * (variables ? layers - 1 : layers + 1));
    if (!variables) continue;
    for (const auto &row : lmp.local("hexes")) {
      const double expected[6] = {8e7, 0.0, 0.0, -3e7, 0.0, 2e7};
      for (int k = 0; k < 6; k++) EXPECT_NEAR(row[1 + k], expected[k], 1e2);
    }
  }
}

// No force and no moment on the whole, and where the edges do not matter the stress stays when they have relaxed.
TEST(Prestress, EdgesRelax)
{
  Block block = pane(12);
  Lammps lmp;
  lmp.commands(block.script() + computes + "fix damping all viscous 10\n");
  lmp.run(0);
  Vec3 force = Vec3::Zero(), moment = Vec3::Zero(), half = Vec3::Zero();
  double largest_force = 0.0;
  const Vec3 c = block.centre();
  for (const auto &it : lmp.particles()) {
    const auto &p = it.second;
    force += p.f;
    moment += (p.x - c).cross(p.f);
    if (p.x[0] > c[0] + 0.1 * block.h) half += p.f;
    largest_force = std::max(largest_force, p.f.norm());
  }
  const double sigma_A = std::abs(surface) * block.h * block.h;
  EXPECT_GT(largest_force, 0.3 * sigma_A);
  EXPECT_LT(force.norm(), 1e-9 * sigma_A);
  EXPECT_LT(half.norm(), 1e-9 * sigma_A) << "through a section";
  EXPECT_LT(moment.norm(), 1e-9 * sigma_A * block.h);
  const double before = lmp.fe(E_ELEMENTS);
  lmp.run(1500);
  const auto after = lmp.particles();
  EXPECT_LT(largest(after, &Particle::f), 1e-3 * sigma_A) << "at rest";
  EXPECT_LT(lmp.fe(E_ELEMENTS), 0.99 * before);
  int looked_at = 0;
  for (const auto &row : lmp.local("hexes")) {
    const int id = static_cast<int>(std::lround(row[0])) - 1;
    const int i = id % 12, j = id / 12 % 12, k = id / 144;
    if (std::min(i, j) < 5 || std::max(i, j) > 6) continue;
    EXPECT_NEAR(row[1], layer_stress(k), 0.01 * std::abs(surface));
    EXPECT_NEAR(row[3], 0.0, 0.01 * std::abs(surface));
    looked_at++;
  }
  EXPECT_EQ(looked_at, 4 * 4);
}

TEST(Prestress, EnergyIsKept)
{
  for (const std::string start : {"", " start core", " start all"}) {
    SCOPED_TRACE(start);
    Block block = pane(4);
    block.dt = 1e-8;    // the swing of velocity Verlet falls with its square: 1e-3 at 4e-8
    block.regions = "region core block 0.002 0.006 0.002 0.006 INF INF\n";
    block.convert += start;
    Lammps lmp;
    lmp.commands(block.script());
    lmp.record({"f_fe[" + std::to_string(TOTAL + 1) + "]"}, 1);
    lmp.run(0);
    const double before = lmp.fe(TOTAL);
    EXPECT_GT(before, (start == " start all" ? 0.8 : 0.95) * stored_energy(block));
    lmp.run(300);
    EXPECT_GT(lmp.fe(E_KINETIC), 0.01 * before) << "the edges swing";
    EXPECT_LT(largest_deviation(lmp.recorded()), 3e-4 * before);
    // what DEs at the free edges cannot hold is booked where they are born
    EXPECT_NEAR(before + lmp.fe(CONV_STRAIN), stored_energy(block), 3e-3 * before);
  }
}

TEST(Prestress, TheCriterionSeesIt)
{
  Block block = pane();
  block.convert = "30e6 type 2 group particles";
  block.options += " shield no";
  Lammps lmp;
  lmp.commands(block.script() + held_edges(block));
  lmp.run(0);
  EXPECT_NEAR(lmp.fe(S1_MAX), layer_stress(1), 2e-3 * std::abs(surface));
  EXPECT_GT(layer_stress(1), 35e6);
  EXPECT_LT(layer_stress(0), 0.0);
  lmp.run(2);
  EXPECT_EQ(lmp.fe(CONVERTED), 2.0 * 6 * 6);
}

TEST(Prestress, CracksOnAnyRanksAndOverARestart)
{
  Block block = cracking_beam();
  block.options = "prestress glass parabola y 0 0.01 surface -2e7";
  same_on_any_ranks_and_over_a_restart(block, "tempered", 260);
}

// What variables said is kept with the elements and their DEs; they need not be there any more.
TEST(Prestress, KeptOverARestart)
{
  Block block = pane(4);
  block.regions = "region core block 0.002 0.006 0.002 0.008 0 0.008\n";
  for (const std::string start : {"", " start core"}) {
    Block first = block;
    first.convert += start;
    first.options = "prestress glass variables v_s v_s NULL NULL NULL NULL";
    const std::string file = "kept.restart";
    for (const auto &[writers, readers] : changes_of_ranks()) {
      Particles last, again;
      on_ranks(writers, [&](MPI_Comm comm) {
        Lammps lmp(comm);
        lmp.commands(first.script() + "variable s atom 5e7*(1-4*(z/0.004-1)^2)\n");
        lmp.run(40);
        lmp.command("write_restart " + file);
        lmp.run(40);
        last = lmp.particles();
      });
      on_ranks(readers, [&](MPI_Comm comm) {
        Lammps lmp(comm);
        lmp.commands(first.header() + first.regions + "read_restart " + file + "\n" +
                     first.fix_only() + first.motion());
        lmp.run(40);
        again = lmp.particles();
      });
      if (rank_of(MPI_COMM_WORLD) > 0) continue;    // is in both
      EXPECT_GT(largest(last, &Particle::v), 0.1);
      EXPECT_LT(difference(last, again, &Particle::x), 1e-14);
      EXPECT_LT(difference(last, again, &Particle::v), 1e-8);
    }
  }
}

TEST(Prestress, Refused)
{
  const auto with = [](const std::string &options, const std::string &commands = "") {
    Block block = pane(2);
    block.options = options;
    block.regions = commands;
    return failure(block.script() + "run 0\n");
  };
  const std::string parabola = "prestress glass parabola z ";
  EXPECT_THAT(with("prestress pane parabola z 0 1 surface 1"), HasSubstr("unknown part pane"));
  EXPECT_THAT(with("prestress glass"), HasSubstr("fix defe prestress"));
  EXPECT_THAT(with("prestress glass line 1"), HasSubstr("not line"));
  EXPECT_THAT(with(parabola + "0 0.008"), HasSubstr("parabola x|y|z LOWER UPPER surface STRESS"));
  EXPECT_THAT(with("prestress glass parabola q 0 1 surface 1"), HasSubstr("not q"));
  EXPECT_THAT(with(parabola + "0.008 0 surface -1e8"), HasSubstr("above the lower one"));
  EXPECT_THAT(with(parabola + "0 0.008 surface high"), HasSubstr("must be a number, not high"));
  EXPECT_THAT(with(parabola + "0 0.008 surface -1e8 " + parabola + "0 0.008 surface -1e8"),
              HasSubstr("given twice"));
  EXPECT_THAT(with(parabola + "0 0.006 surface -1e8"),
              HasSubstr("reaches from 0 to 0.008 along z, not from 0 to 0.006"));
  EXPECT_THAT(with(parabola + "0 0.008 surface -1e12"), HasSubstr("units of the script"));
  const std::string nulls = " NULL NULL NULL NULL NULL";
  EXPECT_THAT(with("prestress glass variables NULL" + nulls), HasSubstr("leave the keyword out"));
  EXPECT_THAT(with("prestress glass variables v_a v_b"), HasSubstr("six atom-style variables"));
  EXPECT_THAT(with("prestress glass variables v_a" + nulls), HasSubstr("no variable a"));
  EXPECT_THAT(with("prestress glass variables v_a" + nulls, "variable a equal 1"),
              HasSubstr("must be of style atom"));
  EXPECT_THAT(with("prestress glass variables v_a" + nulls, "variable a atom 1e12*(id==7)"),
              HasSubstr("element 3 would have a strain of"));
  EXPECT_THAT(with("material gum mooney 1e5 1e4 1e9 1000 prestress gum parabola z 0 1 surface 1"),
              HasSubstr("only parts of the law elastic"));

  Block block = pane(2);
  {
    Lammps lmp;
    lmp.commands(block.script() + "run 0\nwrite_restart refused.restart\n");
  }
  block.options = parabola + "0 0.008 surface -5e7";
  try {
    Lammps lmp;
    lmp.commands(block.header() + "read_restart refused.restart\n" + block.fix_only());
    ADD_FAILURE() << "another stress was not refused";
  } catch (LAMMPS_NS::LAMMPSException &e) {
    EXPECT_THAT(e.what(), HasSubstr("give it as before"));
  }
}
