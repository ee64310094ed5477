// Blocks that convert into discrete elements while they fly: what is conserved, what is not, and
// that nothing happens to them afterwards.
//
// timeout: 300

#include "glass_block.h"

#include <Eigen/SVD>

#include <cmath>
#include <set>

using namespace defe::test;
using defe::Mat3;
using defe::Vec3;

namespace {

const Vec3 velocity(12.0, -7.0, 3.0), spin(1500.0, -800.0, 2500.0);

Block flying_block()
{
  Block block;
  block.boundary = "p p p";
  block.box_lo[0] = block.box_lo[1] = block.box_lo[2] = -0.009;
  block.box_hi[0] = block.box_hi[1] = block.box_hi[2] = 0.019;
  return block;
}

/// Rigid motion of the undeformed block; the state before the first step.
struct Flight {
  Particles particles;
  double total, balance, kinetic, conv_kinetic, conv_strain;
  double converted, des, connective, ties;
};

void start(Lammps &lmp, const Block &block)
{
  lmp.commands(block.script());
  const Vec3 c = block.centre();
  lmp.change([&](Particle &p) {
    p.v = velocity + spin.cross(p.x - c);
  });
  lmp.run(0);
}

Flight state(Lammps &lmp)
{
  return {lmp.particles(),      lmp.fe(TOTAL),       lmp.fe(BALANCE),   lmp.fe(E_KINETIC),
          lmp.fe(CONV_KINETIC), lmp.fe(CONV_STRAIN), lmp.fe(CONVERTED), lmp.fe(DES),
          lmp.fe(CONNECTIVE),   lmp.fe(TIES)};
}

/// Largest distance of a particle from where a rigid motion of the positions `before` takes it.
double deformation(const Particles &before, const Particles &after)
{
  const Vec3 a = centre_of_mass(before), b = centre_of_mass(after);
  Mat3 H = Mat3::Zero();
  for (const auto &p : before) H += (after.at(p.first).x - b) * (p.second.x - a).transpose();
  const Eigen::JacobiSVD<Mat3> svd(H, Eigen::ComputeFullU | Eigen::ComputeFullV);
  const Mat3 R = svd.matrixU() * svd.matrixV().transpose();
  double largest = 0.0;
  for (const auto &p : before)
    largest = std::max(largest, (after.at(p.first).x - b - R * (p.second.x - a)).norm());
  return largest;
}

/// Convert the elements of `region` ("all" or a region's ID; n of them) at step 0, compare with the
/// same block that stays finite, and let it fly for 10 000 steps.
void convert_and_fly(const Block &finite_block, const std::string &region, int n)
{
  Flight before;
  {
    Lammps lmp;
    start(lmp, finite_block);
    before = state(lmp);
  }
  Block block = finite_block;
  block.convert += " start " + region;
  Lammps lmp;
  start(lmp, block);
  const Flight after = state(lmp);

  // conversion itself: mass, linear momentum, centre of mass to rounding
  const double m = block.element_mass(), mass = block.mass(), h = block.h;
  EXPECT_EQ(after.converted, n);
  EXPECT_EQ(after.des, 8 * n);
  EXPECT_EQ(static_cast<bigint>(after.particles.size()), lmp.natoms());
  EXPECT_NEAR(total_mass(before.particles) / mass, 1.0, 1e-14);
  EXPECT_NEAR(total_mass(after.particles) / mass, 1.0, 1e-14);
  const Vec3 p0 = momentum(before.particles);
  EXPECT_LT((momentum(after.particles) - p0).norm(), 1e-14 * p0.norm());
  EXPECT_LT((centre_of_mass(after.particles) - centre_of_mass(before.particles)).norm(), 1e-16);

  // conversion.h: a cube's moment of inertia falls from m h^2/2 to m h^2/8 + m h^2/40 (spins), the
  // angular momentum of its centre's motion stays
  const Vec3 c = block.centre();
  const Vec3 l0 = angular_momentum(before.particles, c), l1 = angular_momentum(after.particles, c);
  const double loss = (1.0 / 2.0 - 1.0 / 8.0 - 1.0 / 40.0) * n * m * h * h;
  EXPECT_LT((l1 - (l0 - loss * spin)).norm(), 1e-12 * l0.norm());
  EXPECT_LT(l1.norm(), 0.99 * l0.norm());    // it is no small effect

  // and with it the kinetic energy; nothing is strained
  const double energy_loss = 0.5 * loss * spin.squaredNorm();
  EXPECT_NEAR(after.conv_kinetic / energy_loss, 1.0, 1e-9);
  EXPECT_NEAR((before.kinetic - after.kinetic) / energy_loss, 1.0, 1e-9);
  EXPECT_NEAR(after.conv_strain, 0.0, 1e-15 * before.total);
  EXPECT_NEAR(after.balance / before.total, 1.0, 1e-13);
  for (const auto &it : after.particles) {
    const auto &p = it.second;
    if (p.radius == 0.0) continue;
    EXPECT_NEAR(p.mass / m, 0.125, 1e-15);
    EXPECT_NEAR(p.radius / h, 0.25, 1e-15);
    EXPECT_LT((p.omega - spin).norm(), 1e-11 * spin.norm());
    EXPECT_LT((p.v - velocity - spin.cross(p.x - c)).norm(), 1e-13 * p.v.norm());
  }

  // the flight
  lmp.record({"f_fe[22]", "f_fe[23]", "f_fe[4]", "f_fe[7]"}, 100);
  lmp.run(10000);
  const Flight end = state(lmp);
  EXPECT_EQ(lmp.fe(CONVERTED), n);
  EXPECT_EQ(lmp.fe(COHESIVE) + lmp.fe(CONTACT), 0.0);
  EXPECT_EQ(largest_deviation(lmp.recorded(2)), 0.0);
  EXPECT_EQ(largest_deviation(lmp.recorded(3)), 0.0);
  // rotation: (omega dt)^2/4 = 6e-9 of the energy; strain energy, 1e-6 of it, swings by per cents
  EXPECT_LT(largest_deviation(lmp.recorded(0)), 1e-6 * after.total);
  EXPECT_LT(largest_deviation(lmp.recorded(1)), 1e-6 * after.total);
  // 10 000 steps of rounding
  EXPECT_LT((momentum(end.particles) - p0).norm(), 1e-12 * p0.norm());
  const Vec3 c1 = centre_of_mass(end.particles);
  EXPECT_LT((c1 - c - 10000 * block.dt * velocity).norm(), 1e-12 * (c1 - c).norm());
  EXPECT_LT((angular_momentum(end.particles, c1) - l1).norm(), 1e-11 * l1.norm());
  // strains are (omega r/c)^2 = 8e-6
  EXPECT_LT(deformation(after.particles, end.particles), 2e-5 * 5 * h);
  const double turn = std::acos(
      std::min(1.0,
               (end.particles.begin()->second.x - end.particles.rbegin()->second.x)
                   .normalized()
                   .dot((after.particles.begin()->second.x - after.particles.rbegin()->second.x)
                            .normalized())));
  EXPECT_GT(turn, 0.5);
}

}    // namespace

TEST(Conversion, WholeBlockInFlight)
{
  Block block = flying_block();
  convert_and_fly(block, "all", block.elements());
}

// Ties in the middle: half of the block stays finite.
TEST(Conversion, HalfBlockInFlight)
{
  Block block = flying_block();
  block.regions = "region half block INF " + number(2 * block.h) + " INF INF INF INF";
  convert_and_fly(block, "half", block.elements() / 2);
}

// Elements here and there, ties in all directions.
TEST(Conversion, ScatteredElementsInFlight)
{
  Block block = flying_block();
  const std::vector<Vec3> some = {block.element_centre(0, 0, 0), block.element_centre(1, 1, 0),
                                  block.element_centre(2, 1, 0), block.element_centre(2, 1, 1),
                                  block.element_centre(3, 2, 1), block.element_centre(0, 2, 1)};
  block.regions = region_of("some", some, block.h);
  convert_and_fly(block, "some", static_cast<int>(some.size()));
}

// A block pulled apart: its elements convert by stress in many waves, on top of those from the
// start. Afterwards every node and every DE is what the list of the living elements says.
TEST(Conversion, BookkeepingAfterManyWaves)
{
  Block block;
  block.n[0] = 8;
  block.n[1] = 4;
  block.n[2] = 3;
  const std::vector<Vec3> some = {block.element_centre(0, 0, 0), block.element_centre(5, 1, 1),
                                  block.element_centre(5, 2, 1)};
  block.regions = region_of("some", some, block.h);
  block.convert = "3e7 type 2 group particles start some";
  Lammps lmp;
  lmp.commands(block.script());
  lmp.commands("compute nelem all defe/atom elements element\ncompute alive all defe/hex/local id");
  const Vec3 c = block.centre();
  // strain rates of up to 2000/s: 30 MPa after some steps, not everywhere at once
  lmp.change([&](Particle &p) {
    const double s = std::max(0.0, 1.0 - (p.x[0] - block.lo[0]) / 0.012);
    p.v = Vec3(5.0, -3.0, 2.0) + 1400.0 * s * Vec3(p.x[0] - c[0], 0.3 * (p.x[1] - c[1]), 0.0) +
        0.05 * random_of(p.tag, 2);
  });
  lmp.run(0);
  const Vec3 p0 = momentum(lmp.particles());
  const double balance = lmp.fe(BALANCE);
  lmp.record({"f_fe[2]", "f_fe[23]"}, 1);
  lmp.run(150);
  const auto converted = lmp.recorded(0);
  const int waves = static_cast<int>(std::set<double>(converted.begin(), converted.end()).size());
  const Particles all = lmp.particles();
  const auto nelem = lmp.per_atom("nelem", 1), element = lmp.per_atom("nelem", 2);
  std::set<int> alive;
  for (const auto &row : lmp.local("alive"))
    EXPECT_TRUE(alive.insert(static_cast<int>(row[0])).second) << "element " << row[0];

  const int n = block.elements();
  EXPECT_GT(waves, 10);
  EXPECT_GT(converted.back(), n / 4);
  EXPECT_LT(converted.back(), n - 5);
  EXPECT_EQ(alive.size(), n - converted.back());
  EXPECT_EQ(lmp.fe(ELEMENTS), static_cast<double>(alive.size()));
  EXPECT_EQ(lmp.fe(DES), 8.0 * (n - alive.size()));

  // what there must be: nodes of living elements, eight DEs of each of the others
  const double m = block.element_mass();
  std::map<tagint, double> mass;
  std::map<tagint, int> count, parent;
  for (int e = 1; e <= n; e++) {
    if (!alive.count(e)) {
      for (int k = 0; k < 8; k++) {
        const tagint tag = block.nodes() + 8 * (e - 1) + k + 1;
        mass[tag] = m / 8.0;
        parent[tag] = e;
      }
      continue;
    }
    const int i = (e - 1) % block.n[0], j = (e - 1) / block.n[0] % block.n[1],
              k = (e - 1) / (block.n[0] * block.n[1]);
    for (int a = 0; a < 8; a++) {
      const tagint tag =
          1 + i + a % 2 + (block.n[0] + 1) * (j + a / 2 % 2 + (block.n[1] + 1) * (k + a / 4));
      mass[tag] += m / 8.0;
      count[tag]++;
    }
  }
  EXPECT_EQ(all.size(), mass.size());
  EXPECT_EQ(lmp.natoms(), static_cast<bigint>(mass.size()));
  for (const auto &it : all) {
    ASSERT_TRUE(mass.count(it.first)) << "atom " << it.first;
    // a node loses up to seven eighths, each with the rounding of its mass
    EXPECT_NEAR(it.second.mass / mass.at(it.first), 1.0, 1e-14) << "atom " << it.first;
    const bool is_de = parent.count(it.first);
    EXPECT_EQ(it.second.type, is_de ? 2 : 1);
    EXPECT_EQ(it.second.radius > 0.0, is_de);
    EXPECT_EQ(nelem.at(it.first), is_de ? 0 : count.at(it.first)) << "atom " << it.first;
    EXPECT_EQ(element.at(it.first), is_de ? parent.at(it.first) : 0) << "atom " << it.first;
  }
  EXPECT_NEAR(total_mass(all) / block.mass(), 1.0, 1e-12);
  EXPECT_LT((momentum(all) - p0).norm(), 1e-12 * p0.norm());

  // Strain and kinetic energy that conversions lose are counted; what is left is the swing of the
  // energy in velocity Verlet: shortest waves have omega dt = 0.5, some per cent of their energy
  EXPECT_LT(largest_deviation(lmp.recorded(1)),
            0.01 * (balance - 0.5 * p0.squaredNorm() / block.mass()));
}

// Crack shielding: in a bar under uniform tension all elements reach the criterion within a few
// steps. Without shielding they nearly all convert; with it the neighbours of those that did, in
// the direction of the tension, wait for the release wave; an element in the plane of the crack
// does not.
TEST(Conversion, ShieldingSparesNeighbours)
{
  const auto converted = [](const char *shield) {
    Block block;
    block.n[0] = 9;
    block.n[1] = 2;
    block.n[2] = 1;
    block.dt = 2e-8;
    block.convert = "5.6e7 type 2 group particles";
    block.coeff = "connective material cohesive 5.6e7 1.0 0.1 contact 0.9 0.2";
    block.options = std::string("shield ") + shield;
    Lammps lmp;
    lmp.commands(block.script() + "compute hexes all defe/hex/local id\n");
    // 55 MPa along x, 0.4 % more in the middle, and a slow pull
    const Vec3 c = block.centre();
    lmp.run(0);
    lmp.change([&](Particle &p) {
      const double d = (p.x[0] - c[0]) / block.h;
      const double strain = 55.5e6 / block.E;
      p.x[0] += strain * block.h * (d + 0.004 * std::max(-0.5, std::min(0.5, d)));
      p.x[1] -= block.nu * strain * (p.x[1] - c[1]);
      p.x[2] -= block.nu * strain * (p.x[2] - c[2]);
      p.v[0] = 60.0 * (p.x[0] - c[0]);
    });
    lmp.run(25);    // 0.5 us, half the shielding time of 1 us
    std::set<int> gone;
    for (int e = 1; e <= block.elements(); e++) gone.insert(e);
    for (const auto &row : lmp.local("hexes")) gone.erase(static_cast<int>(row[0]));
    return gone;
  };
  const std::set<int> with = converted("yes"), without = converted("no");
  EXPECT_TRUE(with.count(5) && with.count(14));    // the middle, both elements beside each other
  EXPECT_FALSE(with.count(4) || with.count(6) || with.count(13) || with.count(15));
  EXPECT_TRUE(without.count(4) && without.count(6) && without.count(13) && without.count(15));
}

// DEs whose only joint is a tie swing about its point. When the element behind converts, no joint is
// born bent in its place: energy would come from nowhere.
TEST(Conversion, OfAnElementWithDEsThatSwung)
{
  Block block;
  block.n[0] = 2;
  block.n[1] = block.n[2] = 1;
  block.regions = region_of("left", {block.element_centre(0, 0, 0)}, block.h);
  block.convert = "5e8 type 2 group particles start left";
  block.coeff =
      "connective material cohesive 1e3 1e-6 0.1 lattice contact 0.9 0.0";    // hold nothing
  Lammps lmp;
  lmp.commands(block.script());
  lmp.run(0);
  const Particles begin = lmp.particles();
  const Vec3 c = block.centre();
  const auto tied = [&](const Particle &p) {
    return begin.at(p.tag).radius > 0.0 && begin.at(p.tag).x[0] > c[0] - 0.5 * block.h;
  };
  // the joints of the eight break, four fly off
  lmp.change([&](Particle &p) {
    if (p.radius > 0.0) p.v = 2e3 * (p.x - block.element_centre(0, 0, 0));
    if (p.radius > 0.0 && !tied(p)) p.v[0] -= 5.0;
  });
  lmp.run(200);
  ASSERT_EQ(lmp.fe(CONNECTIVE), 0.0);
  ASSERT_EQ(lmp.fe(TIES), 4.0);
  // they swing, in the element's frame, by 0.2 to 0.3
  lmp.change([&](Particle &p) {
    p.v = tied(p) ? Vec3(0.0, 40.0, 0.0) : p.radius > 0.0 ? Vec3(-20.0, 0.0, 0.0) : Vec3::Zero();
  });
  lmp.run(60);
  EXPECT_EQ(lmp.fe(CONVERTED), 1.0);
  // and the element is torn
  const double middle = block.element_centre(1, 0, 0)[0];
  lmp.change([&](Particle &p) {
    p.v = Vec3(p.radius > 0.0 ? 0.0 : 1e5 * (begin.at(p.tag).x[0] - middle), 0.0, 0.0);
  });
  lmp.command("timestep 1e-8");
  lmp.run(0);
  const double total = lmp.fe(TOTAL), broken = lmp.fe(CONTACT);
  lmp.record({"f_fe[22]", "f_fe[2]"}, 1);
  lmp.run(200);
  const auto energy = lmp.recorded(0), converted = lmp.recorded(1);
  ASSERT_EQ(converted.back(), 2.0) << "a poor example";
  EXPECT_GE(lmp.fe(CONTACT), broken + 4.0);
  EXPECT_EQ(lmp.fe(TIES), 0.0);
  for (double e : energy) EXPECT_LT(e, total * (1.0 + 1e-3));
}
