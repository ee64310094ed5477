// Meshes that go to a data file and come back, and runs that stop in the middle of a crack.
//
// timeout: 240

#include "events.h"
#include "glass_block.h"
#include "mesh_file.h"

#include <cmath>
#include <set>

using namespace defe::test;
using defe::Vec3;

namespace {

constexpr double h = 2e-3;

std::string two_parts()
{
  return R"(
    pair_style      defe/joint
    pair_coeff      3 3 connective material cohesive 1e12 1e6 0.1 contact 0.9 0.2
    group           particles empty
    fix             fe all defe material glass elastic 74.09e9 0.2 2500 &
                                material steel elastic 210e9 0.3 7800 part plate glass &
                                convert plate 1e12 type 3 group particles
    timestep        5e-8
    neighbor        0.0003 bin
  )";
}

std::string header()
{
  return R"(
    units           si
    atom_style      sphere
    newton          off on
    comm_modify     vel yes
    boundary        f f f
  )";
}

/// id, part, x, y, z of all elements, by ID
std::map<int, std::vector<double>> elements(Lammps &lmp)
{
  std::map<int, std::vector<double>> result;
  for (const auto &row : lmp.local("hexes")) result[static_cast<int>(row[0])] = row;
  return result;
}

/// A beam that is bent until it cracks, in the middle and then elsewhere: conversions go on for the
/// 260 steps of the test.
Block cracking_block()
{
  Block block;
  block.n[0] = 16;
  block.n[1] = 5;
  block.n[2] = 2;
  block.box_hi[0] = 0.05;
  block.convert = "5.6e7 type 2 group particles";
  block.coeff = "connective material cohesive 6e7 10.0 0.1 contact 0.9 0.2";
  return block;
}

constexpr int middle = 100, end = 260;

void pull(Lammps &lmp, const Block &block)
{
  lmp.change([&](Particle &p) {
    const double s = (p.x[0] - block.centre()[0]) / 0.016;
    p.v = Vec3(0.0, 12.0 * (s * s - 1.0 / 3.0), 0.0) + 0.1 * random_of(p.tag, 8);
  });
}

/// Read the restart file and go on; the conversions after the restart.
std::vector<std::array<long, 2>> go_on(MPI_Comm comm, const std::string &restart,
                                       const std::string &events, Particles *last = nullptr)
{
  Block block = cracking_block();
  block.options = "events " + events;
  remove_file(events, comm);    // after a restart it is continued
  Lammps lmp(comm);
  lmp.commands(block.header() + "read_restart " + restart + "\n" + block.fix_only() +
               block.motion());
  EXPECT_EQ(lmp.step(), middle);
  lmp.run(end - middle);
  if (last) *last = lmp.particles();
  MPI_Barrier(comm);
  return conversions(events);
}

}    // namespace

// Two parts beside each other, an irregular one from a file and one made by create_hexes; elements
// and nodes come back with their IDs, parts and masses, and with the same forces when deformed.
TEST(DataFile, RoundTripOfTwoParts)
{
  MeshFile mesh;
  tagint tag = 0;
  mesh.types = 3;
  mesh.add_block("steel", 2, 3, 3, 4, h, [&](const Vec3 &X) {
    return Vec3(X + 0.1 * h * random_of(++tag, 9));
  });
  mesh.write("steel.data");
  const std::string computes = "compute hexes all defe/hex/local id part x y z";
  const auto deform = [](Particle &p) {
    p.x += 0.02 * h * random_of(p.tag, 10);
  };

  Particles first, forces;
  std::map<int, std::vector<double>> hexes;
  {
    Lammps lmp;
    lmp.commands(header() +
                 "region box block -0.02 0.03 -0.02 0.03 -0.02 0.03\ncreate_box 3 box\n" +
                 two_parts() + read_mesh("steel.data") +
                 "create_hexes fe plate 1 x 0.010 3 0.016 y 0 2 0.004 z 0 4 0.01\n" + computes);
    lmp.command("write_data both.data");    // before any run
    lmp.run(0);
    first = lmp.particles();
    hexes = elements(lmp);
    lmp.change(deform);
    lmp.run(0);
    forces = lmp.particles();
  }
  ASSERT_EQ(hexes.size(), 3u * 3u * 4u + 3u * 2u * 4u);
  EXPECT_EQ(hexes.at(1)[1], 2.0);     // part steel
  EXPECT_EQ(hexes.at(37)[1], 3.0);    // part plate
  EXPECT_EQ(first.size(), 4u * 4u * 5u + 4u * 3u * 5u);
  // a lumped mass each: of an irregular mesh it is the sum that is known, but for the border's
  // shape
  EXPECT_NEAR(total_mass(first), 7800 * 36 * h * h * h + 2500 * 24 * h * 2e-3 * 2.5e-3,
              0.02 * total_mass(first));

  for (const std::string file : {"both.data", "again.data"}) {
    Lammps lmp;
    lmp.commands(header() +
                 "region box block -0.02 0.03 -0.02 0.03 -0.02 0.03\ncreate_box 3 box\n" +
                 two_parts() + read_mesh(file) + computes);
    if (file == "both.data") lmp.command("write_data again.data");
    lmp.run(0);
    const Particles back = lmp.particles();
    ASSERT_EQ(back.size(), first.size());
    // write_data writes 17 digits
    EXPECT_EQ(difference(first, back, &Particle::x), 0.0);
    for (const auto &p : first) {
      EXPECT_EQ(p.second.type, back.at(p.first).type);
      EXPECT_NEAR(p.second.mass / back.at(p.first).mass, 1.0, 1e-15);
    }
    const auto same = elements(lmp);
    ASSERT_EQ(same.size(), hexes.size());
    for (const auto &e : hexes)
      for (int k = 0; k < 5; k++)
        EXPECT_NEAR(e.second[k], same.at(e.first)[k], k < 2 ? 0.0 : 1e-17) << "element " << e.first;
    lmp.change(deform);
    lmp.run(0);
    // the order of nodes differs: rounding of the sums
    EXPECT_LT(difference(forces, lmp.particles(), &Particle::f),
              1e-12 * largest(forces, &Particle::f));
  }
}

// The same mesh read twice, with offsets for atom IDs and positions, is two bodies. (Elements need
// IDs of their own: the second copy has another file.)
TEST(DataFile, AppendedTwice)
{
  MeshFile one, two;
  one.types = two.types = 3;
  one.add_block("steel", 2, 2, 2, 2, h, [](const Vec3 &X) {
    return X;
  });
  two = one;
  one.write("one.data");
  // read with `add append`: atom IDs go up by the largest there is
  if (rank_of(MPI_COMM_WORLD) == 0) {
    std::ifstream in("one.data");
    std::ofstream out("two.data");
    std::string line;
    bool hexes = false;
    while (std::getline(in, line)) {
      if (hexes && !line.empty())
        line = std::to_string(100 + std::stoi(line)) + line.substr(line.find(' '));
      if (line == "Hexes") hexes = true;
      out << line << "\n";
    }
  }
  MPI_Barrier(MPI_COMM_WORLD);
  Lammps lmp;
  lmp.commands(header() + "region box block -0.02 0.03 -0.02 0.03 -0.02 0.03\ncreate_box 3 box\n" +
               two_parts() + read_mesh("one.data") +
               "read_data two.data add append shift 0.006 0 0 fix fe hexes Hexes\n" +
               "compute hexes all defe/hex/local id part x y z\n");
  lmp.run(0);
  const auto hexes = elements(lmp);
  ASSERT_EQ(hexes.size(), 16u);
  EXPECT_EQ(lmp.natoms(), 54);
  for (int e = 1; e <= 8; e++)
    EXPECT_NEAR(hexes.at(100 + e)[2] - hexes.at(e)[2], 0.006, 1e-16) << "element " << e;
  EXPECT_NEAR(total_mass(lmp.particles()), 16 * 7800 * h * h * h, 1e-15);
}

// With all its joints, contacts and shields the state goes through the file. Positions are exact;
// of forces, those that depend on velocities are recomputed with full-step velocities (damping of
// contacts), so that the promise is: the same elements at the same steps.
TEST(Restart, SameConversionsFromTheMiddleOfACrack)
{
  const bool root = rank_of(MPI_COMM_WORLD) == 0;
  Block block = cracking_block();
  std::vector<std::array<long, 2>> whole;
  Particles last;
  {
    block.options = "events whole.txt";
    remove_file("whole.txt");
    Lammps lmp;
    lmp.commands(block.script() + "restart " + std::to_string(middle) + " mid.*.restart\n");
    pull(lmp, block);
    lmp.run(end);
    last = lmp.particles();
    MPI_Barrier(MPI_COMM_WORLD);
    whole = conversions("whole.txt", middle);
    const auto before = conversions("whole.txt").size() - whole.size();
    EXPECT_GT(before, 8u) << "a poor example";
    EXPECT_GT(whole.size(), 8u) << "a poor example";
    EXPECT_GT(lmp.fe(CONTACT), 20) << "a poor example";
  }
  if (root) {
    // one rank writes a restart file of its own
    block.options = "events one.txt";
    remove_file("one.txt", MPI_COMM_SELF);
    Lammps lmp(MPI_COMM_SELF);
    lmp.commands(block.script() + "restart " + std::to_string(middle) + " one.*.restart\n");
    pull(lmp, block);
    lmp.run(end);
    EXPECT_EQ(conversions("one.txt", middle), whole) << "on one rank";
  }
  MPI_Barrier(MPI_COMM_WORLD);
  const std::string step = std::to_string(middle);

  Particles here;
  EXPECT_EQ(go_on(MPI_COMM_WORLD, "mid." + step + ".restart", "same.txt", &here), whole);
  ASSERT_EQ(here.size(), last.size());
  EXPECT_LT(difference(last, here, &Particle::x), 1e-8);    // velocities of 10 m/s, 6 us: 6e-5 m
  EXPECT_EQ(go_on(MPI_COMM_WORLD, "one." + step + ".restart", "more.txt"), whole);
  if (root) { EXPECT_EQ(go_on(MPI_COMM_SELF, "mid." + step + ".restart", "fewer.txt"), whole); }
}

// In the middle of a collision with friction: depths, springs and elements come through the file,
// and no force here depends on velocities (restitution 1). A second `run` is the same thing.
TEST(Restart, InTheMiddleOfACollision)
{
  Block block;
  block.regions = "region half block 0.003 INF INF INF INF INF";
  block.coeff = "connective material cohesive 1e12 1e6 0.1 contact 1.0 0.2";
  block.convert += " start half";
  block.options = "part base glass contact 0.5 friction 0.2";
  const std::string base =
      "create_hexes fe base 1 x -0.0013 4 0.0107 y -0.004 2 -0.00001 z -0.001 2 0.005\n";
  const auto fall = [](Particle &p) {
    if (p.x[1] > -0.000005) p.v = Vec3(3.0, -6.0, 1.0) + 0.1 * random_of(p.tag, 12);
  };
  Particles whole, twice, after;
  double total;
  {
    Lammps lmp;
    lmp.commands(block.script() + base);
    lmp.command("group nodes type 1");
    lmp.change(fall);
    lmp.run(300);
    whole = lmp.particles();
    total = lmp.fe(TOTAL);
  }
  {
    Lammps lmp;
    lmp.commands(block.script() + base);
    lmp.command("group nodes type 1");
    lmp.change(fall);
    lmp.run(100);
    EXPECT_GT(lmp.fe(E_CONTACT), 0.01 * total);
    EXPECT_GT(lmp.fe(FRICTION), 0.0);
    lmp.command("write_restart collision.restart");
    lmp.run(200);
    twice = lmp.particles();
  }
  {
    Lammps lmp;
    lmp.commands(block.header() + "read_restart collision.restart\n" + block.regions + "\n" +
                 block.fix_only() + block.motion());
    EXPECT_EQ(lmp.step(), 100);
    lmp.run(200);
    after = lmp.particles();
    EXPECT_NEAR(lmp.fe(TOTAL) / total, 1.0, 1e-9);    // cumulative entries too
  }
  // rounding of 1e-18 m grows through some hundred slips to 3e-14 m; it moves by 1e-4 m, 6 m/s
  EXPECT_LT(difference(whole, twice, &Particle::x), 1e-12);
  EXPECT_LT(difference(whole, after, &Particle::x), 1e-12);
  EXPECT_LT(difference(whole, after, &Particle::v), 1e-6);
}
