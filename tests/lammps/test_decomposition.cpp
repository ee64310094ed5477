// One rank or many, whatever the grid of processors: the same forces.
//
// timeout: 240

#include "glass_block.h"
#include "mesh_file.h"

#include "comm.h"

#include <Eigen/Geometry>

#include <cmath>

using namespace defe::test;
using defe::Mat3;
using defe::Vec3;

namespace {

std::vector<std::string> grids()
{
  switch (size_of(MPI_COMM_WORLD)) {
    case 1:
      return {"1 1 1"};
    case 2:
      return {"2 1 1", "1 2 1", "1 1 2"};
    case 4:
      return {"1 1 4", "2 2 1", "4 1 1", "1 2 2"};
  }
  return {"* * *"};
}

constexpr int nx = 6, ny = 5, nz = 4;
constexpr double h = 2e-3;

/// Every node off its place by up to 15 % of the edge.
MeshFile irregular_mesh()
{
  MeshFile mesh;
  tagint tag = 0;
  mesh.add_block("glass", 1, nx, ny, nz, h, [&](const Vec3 &X) {
    return Vec3(X + 0.15 * h * random_of(++tag, 3));
  });
  return mesh;
}

/// Sheared by per cents, turned, every node off its place, and moving.
void deform(Lammps &lmp)
{
  Mat3 F;
  F << 1.01, 0.05, -0.02, 0.0, 0.98, 0.03, 0.01, 0.0, 1.02;
  F = Eigen::AngleAxisd(0.3, Vec3(1.0, 1.0, -2.0).normalized()).toRotationMatrix() * F;
  const Vec3 c(0.5 * nx * h, 0.5 * ny * h, 0.5 * nz * h);
  lmp.change([&](Particle &p) {
    p.v = 20.0 * random_of(p.tag, 5) + Vec3(3e3, -1e3, 2e3).cross(p.x - c);
    p.x = c + F * (p.x - c) + 0.01 * h * random_of(p.tag, 4);
  });
}

/// Forces may differ by the order of summation: 1e-16 of the largest terms, of which there are some
/// ten per node. Positions are the same numbers.
void expect_same_forces(const Particles &reference, const Particles &here, const std::string &grid,
                        double tolerance = 1e-12)
{
  ASSERT_EQ(reference.size(), here.size()) << grid;
  const double scale = largest(reference, &Particle::f);
  EXPECT_GT(scale, 0.0);
  EXPECT_LT(difference(reference, here, &Particle::f), tolerance * scale) << grid;
  const double torque = largest(reference, &Particle::torque);
  EXPECT_LE(difference(reference, here, &Particle::torque), tolerance * torque) << grid;
  for (const auto &p : reference)
    EXPECT_NEAR(p.second.mass / here.at(p.first).mass, 1.0, 1e-14) << grid << " atom " << p.first;
}

/// A block of which elements here and there convert at the start. A region holds what LAMMPS has
/// inside the box: with a period, centres above `high` are given there.
Block scattered(double high = 1.0, double period = 0.0)
{
  Block block;
  block.n[0] = nx;
  block.n[1] = ny;
  block.n[2] = nz;
  std::vector<Vec3> some;
  std::mt19937 random(11);
  for (int k = 0; k < nz; k++)
    for (int j = 0; j < ny; j++)
      for (int i = 0; i < nx; i++)
        if (random() % 3 == 0) {
          Vec3 c = block.element_centre(i, j, k);
          for (double &x : c)
            if (x > high) x -= period;
          some.push_back(c);
        }
  block.regions = region_of("some", some, h);
  block.convert += " start some";
  return block;
}

}    // namespace

TEST(Decomposition, IrregularFiniteElements)
{
  irregular_mesh().write("irregular.data");
  const auto forces = [](MPI_Comm comm, const std::string &grid) {
    Block block;
    block.processors = grid;
    Lammps lmp(comm);
    lmp.commands(block.header() + block.box() + block.fix() + read_mesh("irregular.data") +
                 block.motion());
    deform(lmp);
    lmp.run(0);
    const Particles first = lmp.particles();
    lmp.run(1);
    return std::make_pair(first, lmp.particles());
  };
  const Particles first = on_one_rank([&] {
    return forces(MPI_COMM_SELF, "1 1 1").first;
  });
  const Particles second = on_one_rank([&] {
    return forces(MPI_COMM_SELF, "1 1 1").second;
  });
  for (const auto &grid : grids()) {
    const auto here = forces(MPI_COMM_WORLD, grid);
    expect_same_forces(first, here.first, grid);
    expect_same_forces(second, here.second, grid);
  }
}

TEST(Decomposition, DiscreteElementsAndTies)
{
  const auto forces = [](MPI_Comm comm, const std::string &grid,
                         const std::string &newton = "newton off on") {
    Block block = scattered();
    block.processors = grid;
    Lammps lmp(comm);
    std::string script = block.script();
    lmp.commands(script.replace(script.find("newton off on"), 13, newton));
    lmp.run(0);
    EXPECT_GT(lmp.fe(TIES), 100);
    EXPECT_GT(lmp.fe(CONNECTIVE), 300);
    deform(lmp);
    lmp.run(1);
    return lmp.particles();
  };
  const Particles reference = on_one_rank([&] {
    return forces(MPI_COMM_SELF, "1 1 1");
  });
  for (const auto &grid : grids()) {
    expect_same_forces(reference, forces(MPI_COMM_WORLD, grid), grid);
    expect_same_forces(reference, forces(MPI_COMM_WORLD, grid, "newton on"), grid + " newton on");
  }
}

// Ghosts are not farther away than elements are long; elements that become longer, up to three times
// here, get more. A second run and a restart begin with long elements.
TEST(Decomposition, GhostsFollowElementsThatBecomeLonger)
{
  const std::string rubber =
      "fix fe all defe material rubber mooney 4e5 1e5 2e7 1100 part glass rubber\n";
  const auto script = [&](Block &block) {
    block.n[0] = nx;
    block.n[1] = block.n[2] = 2;
    block.box_lo[0] = -0.03;
    block.box_hi[0] = 0.05;
    block.dt = 2e-6;
    return block.header() + block.box() + "group particles empty\n" + rubber + block.mesh() +
        block.motion();
  };
  const auto hold = R"(
    region          left block INF 0.00001 INF INF INF INF
    region          right block 0.01199 INF INF INF INF INF
    group           left region left
    group           right region right
  )";
  const std::string pull = R"(
    group           ends union left right
    fix             pull ends setforce 0 0 0
  )";
  const double diagonal = std::sqrt(3.0) * h;
  const auto states = [&](MPI_Comm comm, const std::string &grid, int from) {
    Block block;
    block.processors = grid;
    Lammps lmp(comm);
    std::string commands = script(block);
    if (from) {
      commands = block.header() + "read_restart rubber.restart\n" + rubber + block.motion() + pull;
      lmp.commands(commands);
    } else {
      lmp.commands(commands + hold + pull +
                   "velocity left set -10 0 0\nvelocity right set 10 0 0\n");
      lmp.run(0);
      EXPECT_LT(lmp->comm->cutghostuser, 1.1 * diagonal);
      lmp.run(300);
      lmp.run(300);
    }
    if (size_of(comm) == 1 && !from) lmp.command("write_restart rubber.restart");
    lmp.run(1);
    if (size_of(comm) > 1) { EXPECT_GT(lmp->comm->cutghostuser, 1.6 * diagonal); }
    const Particles all = lmp.particles();
    double low = 1.0, high = 0.0;
    for (const auto &p : all) {
      low = std::min(low, p.second.x[0]);
      high = std::max(high, p.second.x[0]);
    }
    EXPECT_NEAR(high - low, 0.036, 1e-4);
    return all;
  };
  const Particles reference = on_one_rank([&] {
    return states(MPI_COMM_SELF, "1 1 1", 0);
  });
  for (const auto &grid : grids())
    for (const int from : {0, 1}) {
      const Particles here = states(MPI_COMM_WORLD, grid, from);
      ASSERT_EQ(reference.size(), here.size()) << grid;
      EXPECT_LT(difference(reference, here, &Particle::x), 1e-13) << grid;
      EXPECT_LT(difference(reference, here, &Particle::f), 1e-9 * largest(reference, &Particle::f))
          << grid;
    }
}

// The state comes from a restart file: a block in which cracks run, with joints of all states,
// contacts, ties and elements. Forces at the first evaluation after reading it.
void cracked_block_from_restart(const std::string &law)
{
  const std::string coeff = "connective material cohesive 3e7 5.0 0.3 " + law + " contact 0.7 0.3";
  Block block;
  block.n[0] = nx;
  block.n[1] = ny;
  block.n[2] = nz;
  block.convert = "2.7e7 type 2 group particles";
  block.coeff = coeff;
  const auto read = [&](MPI_Comm comm, const std::string &grid) {
    Lammps lmp(comm);
    Block same = block;
    same.processors = grid;
    lmp.commands(same.header() + "read_restart cracked.restart\n" + same.fix_only() +
                 same.motion());
    lmp.run(0);
    EXPECT_GT(lmp.fe(COHESIVE), 5) << "a poor example";
    EXPECT_GT(lmp.fe(CONTACT), 20) << "a poor example";
    EXPECT_GT(lmp.fe(TIES), 20) << "a poor example";
    EXPECT_GT(lmp.fe(CONNECTIVE), 20) << "a poor example";
    if (!law.empty()) { EXPECT_GT(lmp.fe(E_CONTACT), 0.0) << "a poor example"; }
    return lmp.particles();
  };
  const Particles reference = on_one_rank([&] {
    {
      Lammps lmp(MPI_COMM_SELF);
      lmp.commands(block.script());
      lmp.change([&](Particle &p) {
        p.v = Vec3(0.0, 1500.0 * (p.x[1] - 0.005), 0.0) +
            Vec3(0.0, 0.0, 2e3).cross(p.x - block.centre()) + 0.5 * random_of(p.tag, 6);
      });
      lmp.run(150);
      lmp.command("write_restart cracked.restart");
    }
    return read(MPI_COMM_SELF, "1 1 1");
  });
  for (const auto &grid : grids()) expect_same_forces(reference, read(MPI_COMM_WORLD, grid), grid);
}

TEST(Decomposition, CrackedBlockFromRestart)
{
  cracked_block_from_restart("");
}

TEST(Decomposition, BlockCrackedAlongItsJointsFromRestart)
{
  cracked_block_from_restart("lattice");
}

// A block, half of it discrete, falls on a deformable and a rigid block and slides: surface contact
// of nodes and spheres with friction, sphere contact, on all grids and with both settings of
// newton.
TEST(Decomposition, CollisionsWithFriction)
{
  const auto states = [](MPI_Comm comm, const std::string &grid, const std::string &newton) {
    Block block;
    block.processors = grid;
    block.regions = "region half block 0.003 INF INF INF INF INF";
    block.convert += " start half";
    block.options = "part base glass material wall rigid 7800 contact 0.5 friction 0.2";
    Lammps lmp(comm);
    std::string script = block.script();
    script.replace(script.find("newton off on"), 13, newton);
    lmp.commands(script + R"(
      create_hexes    fe base 1 x -0.0013 2 0.0047 y -0.004 2 -0.00001 z -0.001 2 0.005
      create_hexes    fe wall 1 x 0.0048 1 0.012 y -0.003 1 -0.00001 z -0.0012 1 0.0051
      region          wall block 0.00475 INF INF -0.000005 INF INF
      group           wall region wall
      fix             hold wall setforce 0 0 0
    )");
    lmp.change([&](Particle &p) {
      if (p.x[1] > -0.000005) p.v = Vec3(3.0, -6.0, 1.0) + 0.1 * random_of(p.tag, 12);
    });
    lmp.record({"f_fe[13]", "f_fe[18]", "f_fe[22]"}, 5);
    lmp.run(300);
    const auto contact = lmp.recorded(0), total = lmp.recorded(2);
    EXPECT_GT(*std::max_element(contact.begin(), contact.end()), 0.1 * total.front());
    EXPECT_GT(lmp.recorded(1).back(), 0.002 * total.front());
    EXPECT_LT(largest_deviation(total), 0.02 * total.front());
    return lmp.particles();
  };
  const Particles reference = on_one_rank([&] {
    return states(MPI_COMM_SELF, "1 1 1", "newton off on");
  });
  for (const std::string newton : {"newton off on", "newton on"})
    for (const auto &grid : grids()) {
      const Particles here = states(MPI_COMM_WORLD, grid, newton);
      // 1e-18 m is the rounding of positions; 300 steps and some thousand slips between
      EXPECT_LT(difference(reference, here, &Particle::x), 1e-14) << grid << ", " << newton;
      EXPECT_LT(difference(reference, here, &Particle::v), 1e-8) << grid << ", " << newton;
      EXPECT_LT(difference(reference, here, &Particle::omega), 1e-3) << grid << ", " << newton;
    }
}

// Domains that change during the run, in a brick and in a tiled decomposition, under a half
// converted block that turns and flies across the periodic borders. 400 steps let differences of
// rounding grow little: joints stay whole.
TEST(Decomposition, BalancedDuringTheRun)
{
  const auto positions = [](MPI_Comm comm, const std::string &style, const std::string &balance) {
    Block block = scattered();
    block.boundary = "p p p";
    for (int k = 0; k < 3; k++) {
      block.box_lo[k] = -0.006;
      block.box_hi[k] = 0.018;
    }
    Lammps lmp(comm);
    lmp.commands(block.header() + style + "\n" + block.box() + block.fix() + block.mesh() +
                 block.motion() + balance);
    lmp.change([&](Particle &p) {
      p.v = Vec3(200.0, -150.0, 100.0) + Vec3(2e4, 3e4, -1e4).cross(p.x - block.centre()) +
          random_of(p.tag, 7);
    });
    lmp.run(400);
    return lmp.particles();
  };
  const Particles reference = on_one_rank([&] {
    return positions(MPI_COMM_SELF, "", "");
  });
  const std::vector<std::pair<std::string, std::string>> ways = {
      {"", ""},
      {"", "fix balance all balance 17 1.0 shift xyz 10 1.05"},
      {"comm_style tiled", "fix balance all balance 23 1.0 rcb"}};
  for (const auto &way : ways) {
    const Particles here = positions(MPI_COMM_WORLD, way.first, way.second);
    ASSERT_EQ(reference.size(), here.size()) << way.second;
    // x of 1e-2 m is rounded to 1e-18 m; 400 steps, and the shortest waves do not damp it
    EXPECT_LT(difference(reference, here, &Particle::x), 1e-14) << way.second;
    EXPECT_LT(difference(reference, here, &Particle::v), 1e-8) << way.second;
  }
}

// A block across the borders of a periodic box feels nothing of them.
TEST(Decomposition, AcrossPeriodicBorders)
{
  for (const bool from_file : {false, true}) {
    const auto forces = [&](MPI_Comm comm, const std::string &grid, bool periodic) {
      // the upper corner of the periodic box lies in an element, between its first node and its
      // centre
      const double low = -0.0215, high = 0.0025;
      Block block = periodic ? scattered(high, high - low) : scattered();
      block.processors = grid;
      if (periodic) {
        block.boundary = "p p p";
        for (int k = 0; k < 3; k++) {
          block.box_lo[k] = low;
          block.box_hi[k] = high;
        }
      }
      Lammps lmp(comm);
      if (from_file) {
        MeshFile mesh;
        mesh.add_block("glass", 1, nx, ny, nz, h, [](const Vec3 &X) {
          return X;
        });
        for (int k = 0; k < 3; k++) {
          mesh.lo[k] = block.box_lo[k];
          mesh.hi[k] = block.box_hi[k];
        }
        const std::string file = periodic ? "periodic.data" : "free.data";
        mesh.write(file, comm);
        lmp.commands(block.header() + block.box() + block.fix() + read_mesh(file) + block.motion());
      } else
        lmp.commands(block.script());
      lmp.run(0);
      // image flags apart, x is the position in the box: shift it by what makes it unwrapped
      const Vec3 c = block.centre();
      std::map<tagint, Vec3> shift;
      for (const auto &p : lmp.particles()) shift[p.first] = p.second.x;
      lmp.change([&](Particle &p) {
        const Vec3 x = shift.at(p.tag), image = p.x - x;
        Mat3 F;
        F << 1.01, 0.05, -0.02, 0.0, 0.98, 0.03, 0.01, 0.0, 1.02;
        p.x = c + F * (x - c) + 0.01 * h * random_of(p.tag, 4) + image;
        p.v = 20.0 * random_of(p.tag, 5);
      });
      lmp.run(2);
      return lmp.particles();
    };
    const Particles reference = on_one_rank([&] {
      return forces(MPI_COMM_SELF, "1 1 1", false);
    });
    for (const auto &grid : grids()) {
      const Particles here = forces(MPI_COMM_WORLD, grid, true);
      // positions were wrapped and have other roundings: 1e-18 m, against displacements of 1e-5 m
      expect_same_forces(reference, here, grid, 1e-11);
      EXPECT_LT(difference(reference, here, &Particle::x), 1e-15) << grid;
    }
  }
}
