// Meshes that are closed with themselves across the borders of a periodic box: there is no border in them.

#include "cracking_beam.h"
#include "failure.h"
#include "mesh_file.h"

#include <gmock/gmock.h>

#include <cmath>
#include <functional>

using namespace defe::test;
using defe::Vec3;
using testing::AllOf;
using testing::HasSubstr;

namespace {

/// Closed along `axes`; the box begins somewhere, and the mesh with it.
Block closed_block(const std::string &axes, int x, int y, int z)
{
  Block block;
  block.n[0] = x;
  block.n[1] = y;
  block.n[2] = z;
  block.closed = axes;
  const double low[3] = {-0.0013, 0.0021, 0.0};
  for (int k = 0; k < 3; k++) {
    if (axes.find("xyz"[k]) == std::string::npos) continue;
    block.boundary[2 * k] = 'p';
    block.lo[k] = block.box_lo[k] = low[k];
    block.box_hi[k] = low[k] + block.n[k] * block.h;
  }
  return block;
}

/// The same mesh in a file: the last elements have the nodes of the first ones.
std::string mesh_in_file(const Block &b, const std::string &file, MPI_Comm comm)
{
  MeshFile mesh;
  int lines[3];
  for (int k = 0; k < 3; k++) {
    lines[k] = b.n[k] + (b.closed.find("xyz"[k]) == std::string::npos ? 1 : 0);
    mesh.lo[k] = b.box_lo[k];
    mesh.hi[k] = b.box_hi[k];
  }
  for (int k = 0; k < lines[2]; k++)
    for (int j = 0; j < lines[1]; j++)
      for (int i = 0; i < lines[0]; i++) {
        mesh.X.push_back(Vec3(b.lo[0] + i * b.h, b.lo[1] + j * b.h, b.lo[2] + k * b.h));
        mesh.type.push_back(1);
      }
  for (int k = 0; k < b.n[2]; k++)
    for (int j = 0; j < b.n[1]; j++)
      for (int i = 0; i < b.n[0]; i++) {
        std::array<tagint, 8> nodes;
        for (int a = 0; a < 8; a++) {
          int at[3] = {i, j, k};
          for (int d = 0; d < 3; d++)
            at[d] = (at[d] + (defe::fe::hex_sign[a][d] + 1) / 2) % lines[d];
          nodes[a] = 1 + at[0] + lines[0] * (at[1] + lines[1] * at[2]);
        }
        mesh.hex.push_back(nodes);
        mesh.part.push_back("glass");
      }
  mesh.write(file, comm);
  return read_mesh(file);
}

double modulus_of_waves(const Block &b)
{
  return b.E * (1.0 - b.nu) / ((1.0 + b.nu) * (1.0 - 2.0 * b.nu));
}

}    // namespace

// Displacements a sin(k x) in a body without any surface: each element is strained by the difference of its two planes of
// nodes, and the force on a node is -2 M/h (1 - cos(k h)) u times its area, closed forms of uniform elements.
TEST(ClosedMesh, ForcesOfAWaveWithoutAnySurface)
{
  for (const bool from_file : {false, true})
    for (const std::string options : {"", "kernel lagrangian", "reproducible yes"}) {
      SCOPED_TRACE(options + (from_file ? " from a file" : ""));
      Block b = closed_block("xyz", 8, 4, 6);
      b.options = options;
      Lammps lmp;
      lmp.commands(b.header() + b.box() + b.fix() +
                   (from_file ? mesh_in_file(b, "closed.data", MPI_COMM_WORLD) : b.mesh()) +
                   b.motion());
      lmp.run(0);
      const Particles before = lmp.particles();
      ASSERT_EQ(before.size(), 8u * 4u * 6u) << "as many nodes as elements";
      const double area = b.h * b.h, M = modulus_of_waves(b), a = 1e-8;
      const double k = 2.0 * M_PI / (b.n[0] * b.h);
      for (const auto &[tag, p] : before) {
        EXPECT_NEAR(p.mass / b.element_mass(), 1.0, 1e-9);
        EXPECT_LT(p.f.norm(), 1e-14 * M * area) << "but for the digits of places";
      }
      lmp.change([&](Particle &p) {
        p.x[0] += a * std::sin(k * (p.x[0] - b.lo[0]));
      });
      lmp.run(0);
      const double stiffness = 2.0 * M * area / b.h * (1.0 - std::cos(k * b.h));
      for (const auto &[tag, p] : lmp.particles()) {
        const double u = a * std::sin(k * (before.at(tag).x[0] - b.lo[0]));
        EXPECT_NEAR(p.f[0], -stiffness * u, 2e-5 * stiffness * a);
        EXPECT_NEAR(p.f[1], 0.0, 2e-5 * stiffness * a);
        EXPECT_NEAR(p.f[2], 0.0, 2e-5 * stiffness * a);
      }
      const double energy = 0.25 * stiffness * a * a * b.elements();
      EXPECT_NEAR(lmp.fe(E_ELEMENTS), energy, 2e-5 * energy);
    }
}

// A body that flies through its own borders, DEs and all, feels nothing of it.
TEST(ClosedMesh, MovesAsAWhole)
{
  Block b = closed_block("xy", 5, 4, 3);
  b.regions = "region some block -0.0013 0.0027 INF INF INF INF\n";
  b.convert += " start some";
  Lammps lmp;
  lmp.commands(b.script());
  lmp.run(0);
  EXPECT_EQ(lmp.fe(CONVERTED), 2.0 * 4 * 3);
  // joints within elements and between them, around the body along y
  EXPECT_EQ(lmp.fe(CONNECTIVE), 3.0 * 8 * 6 + 4.0 * 8 * 6 + 4.0 * 8 * 5);
  EXPECT_EQ(lmp.fe(TIES), 2.0 * 8 * 6) << "on both sides along x";
  const Vec3 v(300.0, -200.0, 50.0);
  lmp.change([&](Particle &p) {
    p.v = v;
  });
  lmp.run(600);    // 9 mm, once around along x
  for (const auto &[tag, p] : lmp.particles()) EXPECT_LT((p.v - v).norm(), 1e-6);
  EXPECT_NEAR(lmp.fe(E_KINETIC), 0.5 * b.mass() * v.squaredNorm(),
              1e-9 * b.mass() * v.squaredNorm());
  EXPECT_LT(lmp.fe(E_ELEMENTS) + lmp.fe(E_JOINTS) + lmp.fe(E_TIES), 1e-12 * lmp.fe(E_KINETIC));
}

TEST(ClosedMesh, StrengthsAreThoseOfTheSameElementsInsideABox)
{
  const std::string computes = "compute hexes all defe/hex/local id strength\n";
  const auto drawn = [&](const Block &b) {
    Lammps lmp;
    lmp.commands(b.script() + computes + "run 0\n");
    std::map<long, double> of;
    for (const auto &row : lmp.local("hexes")) of[std::lround(row[0])] = row[1];
    return of;
  };
  Block b = closed_block("xy", 5, 4, 3);
  b.options = "strength glass weibull 4 50e6 volume 8e-9 seed 5";
  const auto closed = drawn(b);
  b.closed = "";
  b.boundary = "f f f";
  for (int k = 0; k < 2; k++) b.box_hi[k] += b.h;
  const auto open = drawn(b);
  ASSERT_EQ(open.size(), 60u);
  ASSERT_EQ(closed.size(), 60u);
  for (const auto &[id, strength] : open) EXPECT_NEAR(closed.at(id) / strength, 1.0, 1e-9);
}

// ---- a piece of a large tempered pane, without edges ----

namespace {

constexpr double surface = -163e6;

Block pane(int across)
{
  Block b = closed_block("xy", across, across, 4);
  b.options = "prestress glass parabola z 0 0.008 surface -163e6";
  return b;
}

/// Of the means of the parabola over the layers: (1 - nu)/E s^2 per volume.
double stored_energy(const Block &b)
{
  const auto integral = [](double s) {
    return 0.5 * (s * s * s - s);
  };
  double sum = 0.0;
  for (int k = 0; k < b.n[2]; k++) {
    const double low = 2.0 * k / b.n[2] - 1.0, high = 2.0 * (k + 1) / b.n[2] - 1.0;
    const double s = surface * (integral(high) - integral(low)) / (high - low);
    sum += (1.0 - b.nu) / b.E * s * s * b.h * b.h * b.h * b.n[0] * b.n[1];
  }
  return sum;
}

}    // namespace

TEST(ClosedMesh, ATemperedPaneStaysStill)
{
  using Choice = std::pair<std::string, std::function<void(Block &)>>;
  for (const auto &[name, change] :
       {Choice{"layers",
               [](Block &) {
               }},
        Choice{"lagrangian",
               [](Block &b) {
                 b.options += " kernel lagrangian";
               }},
        Choice{"DEs at the borders", [](Block &b) {
                 b.regions = "region edges block 0.0007 0.0067 0.0041 0.0101 INF INF side out\n";
                 b.convert += " start edges";
               }}}) {
    SCOPED_TRACE(name);
    Block b = pane(5);
    change(b);
    const double energy = stored_energy(b), sigma_A = std::abs(surface) * b.h * b.h;
    Lammps lmp;
    lmp.commands(b.script());
    lmp.run(0);
    EXPECT_EQ(lmp.fe(CONVERTED), name == "DEs at the borders" ? 16.0 * 4 : 0.0);
    EXPECT_LT(largest(lmp.particles(), &Particle::f), 1e-10 * sigma_A);
    const double stored = lmp.fe(E_ELEMENTS) + lmp.fe(E_JOINTS) + lmp.fe(E_TIES);
    EXPECT_NEAR(stored, energy, 3e-3 * energy) << "laws at a strain of 2e-3";
    lmp.run(200);
    EXPECT_LT(largest(lmp.particles(), &Particle::v), 1e-8);
    EXPECT_NEAR(lmp.fe(TOTAL), stored, 1e-11 * stored);
  }
}

namespace {

/// Struck beside the border: cracks run through it.
Block struck_pane()
{
  Block b = pane(8);
  b.convert = "88e6 type 2 group particles";
  b.coeff = "connective material cohesive 88e6 8 1 contact 0.9 0.2";
  b.options += " stress gauss contact 0.1";
  b.dt = 4e-8;
  return b;
}

void strike(Lammps &lmp, const Block &b)
{
  lmp.change([&](Particle &p) {
    const bool row = std::abs(p.x[0] - b.lo[0]) < 0.1 * b.h;
    if (row && std::abs(p.x[1] - b.lo[1]) < 0.1 * b.h) p.v = Vec3(0.0, 30.0, 0.0);
    if (row && std::abs(p.x[1] - b.lo[1] - 7.0 * b.h) < 0.1 * b.h) p.v = Vec3(0.0, -30.0, 0.0);
  });
}

}    // namespace

TEST(ClosedMesh, CracksOnAnyRanksAndOverARestart)
{
  constexpr int middle = 40, end = 160;
  Block b = struck_pane();
  const std::string options = b.options;
  const auto run = [&](MPI_Comm comm, const std::string &events) {
    b.options = options + " events " + events;
    remove_file(events, comm);
    Lammps lmp(comm);
    lmp.commands(b.script());
    strike(lmp, b);
    lmp.run(0);
    const double before = lmp.fe(TOTAL);
    lmp.run(middle);
    EXPECT_LT(lmp.fe(TOTAL), before) << "energy out of nothing";
    lmp.command("write_restart " + events + ".restart");
    lmp.run(end - middle);
    EXPECT_LT(lmp.fe(TOTAL), before) << "energy out of nothing";
    EXPECT_NEAR(lmp.fe(BALANCE), before, 1e-2 * before);
    MPI_Barrier(comm);
    return lmp.particles();
  };
  run(MPI_COMM_WORLD, "closed.txt");
  const History whole = history("closed.txt");
  on_one_rank([&] {
    return run(MPI_COMM_SELF, "closed.one.txt");
  });
  EXPECT_EQ(whole, history("closed.one.txt"));
  const History rest = history("closed.txt", middle);
  EXPECT_GT(rest.size(), 100u) << "a poor example";
  EXPECT_GT(whole.size(), rest.size() + 10) << "a poor example";
  // both sides of both borders have converted: the first and last elements along x and y
  bool converted[2][2] = {};
  for (const auto &e : read_events("closed.txt", "convert")) {
    const long column = (e.a - 1) % 8, row = (e.a - 1) / 8 % 8;
    for (int k = 0; k < 2; k++) {
      const long at = k ? row : column;
      if (at == 0 || at == 7) converted[k][at == 7] = true;
    }
  }
  for (const auto &axis : converted)
    for (const bool side : axis) EXPECT_TRUE(side);

  b.options = options + " events closed.rest.txt";
  remove_file("closed.rest.txt");
  Lammps lmp;
  lmp.commands(b.header() + "read_restart closed.txt.restart\n" + b.fix_only() + b.motion());
  lmp.run(end - middle);
  EXPECT_EQ(rest, history("closed.rest.txt"));
}

// References of nodes stay, and would no longer fit across the border.
TEST(ClosedMesh, TheBoxKeepsItsLength)
{
  const Block b = closed_block("xy", 5, 4, 3);
  {
    Lammps lmp;
    lmp.commands(
        b.script() +
        "run 1\nwrite_restart kept.restart\nchange_box all z final -0.03 0.04 units box\nrun 1\n");
    EXPECT_THAT(failure(lmp, "change_box all x scale 1.001 remap units box\nrun 0"),
                AllOf(HasSubstr("closed with itself across the periodic border in x"),
                      HasSubstr("0.01 from border"), HasSubstr("0.01001 there now")));
  }
  {
    Lammps lmp;
    lmp.commands(b.script() + "fix strain all deform 1 y erate 1e4 remap x\n");
    EXPECT_THAT(failure(lmp, "run 100"), HasSubstr("across the periodic border in y"));
  }
  Lammps lmp;
  lmp.commands(b.header() + "read_restart kept.restart\n" + b.fix_only() + b.motion() + "run 0\n");
  EXPECT_THAT(failure(lmp, "fix strain all deform 1 x scale 1.01 remap x\nrun 10"),
              HasSubstr("across the periodic border in x"));
}

TEST(ClosedMesh, TheBoxStaysPeriodic)
{
  Lammps lmp;
  lmp.commands(closed_block("x", 5, 4, 3).script() + "run 0\n");
  EXPECT_THAT(failure(lmp, "change_box all boundary f f f\nrun 0"),
              HasSubstr("the box is not periodic there now"));
}
