// Contact of surfaces (nodes and DEs against facets) and of loose spheres.
//
// timeout: 240

#include "glass_block.h"
#include "mesh_file.h"

#include <Eigen/Geometry>

#include <cmath>

using namespace defe::test;
using defe::Mat3;
using defe::Vec3;

namespace {

constexpr double E = 74.09e9, rho = 2500.0;
const double c_bar = std::sqrt(E / rho);

/// Glass (type 1, DEs type 2) and a rigid part (type 3) that nothing moves.
std::string script(double nu, double factor, double dt, const std::string &box,
                   const std::string &convert, const std::string &more = "")
{
  return R"(
    units           si
    atom_style      sphere
    newton          off on
    comm_modify     vel yes
    boundary        f f f
    region          box block )" + box + R"(
    create_box      3 box
    region          end block INF 0.02 INF INF INF INF
    pair_style      defe/joint
    pair_coeff      2 2 connective material cohesive 1e12 1e6 0.1 contact 0.9 0.0
    group           particles empty
    fix             fe all defe material glass elastic )" + number(E) + " " + number(nu) + " " +
      number(rho) + R"( material wall rigid 7800 convert glass 1e12 type 2 group particles )" +
      convert + " contact " + number(factor) + more + R"(
    neighbor        0.0003 bin
    neigh_modify    every 1 delay 0 check yes
    timestep        )" + number(dt) + "\n";
}

const std::string motion = R"(
    group           nodes type 1
    group           wall type 3
    group           body type 1 2
    fix             move1 nodes nve
    fix             move2 particles nve/sphere
    compute         push wall reduce sum fx fy fz
)";

/// Glass particles only.
Particles body(const Particles &all)
{
  Particles result;
  for (const auto &p : all)
    if (p.second.type != 3) result.insert(p);
  return result;
}

double sum(const std::vector<double> &a)
{
  double s = 0.0;
  for (double v : a) s += v;
  return s;
}

/// reference.md: a glass bar 200 x 10 x 10 mm meets a rigid wall at 1 m/s: rho c v = 13.61 MPa for
/// 2 L/c = 73.5 us.
void bar_hits_wall(const std::string &convert, double tolerance)
{
  const double L = 0.2, dt = 6e-8;
  Lammps lmp;
  lmp.commands(script(0.2, 2.0, dt, "-0.01 0.21 -0.01 0.02 -0.01 0.02", convert) +
               "create_hexes fe glass 1 x 0 80 0.2 y 0 4 0.01 z 0 4 0.01\n"
               "create_hexes fe wall 3 x -0.005 1 0 y -0.003 2 0.0133 z -0.003 2 0.0133\n" +
               motion + "velocity nodes set -1 0 0");
  lmp.record({"c_push[1]", "f_fe[22]"}, 5);
  lmp.run(1500);    // 90 us
  const auto force = lmp.recorded(0);
  const auto energy = lmp.recorded(1);

  // Longitudinal waves in a bar are those of theory but for the radial motion, which rings with a
  // period of some us. The compliance of the contact delays start and end alike (by some 0.5 us).
  const double expected = -rho * c_bar * 1e-4;    // pushes the wall to negative x
  std::vector<double> plateau(force.begin() + static_cast<long>(15e-6 / (5 * dt)),
                              force.begin() + static_cast<long>(65e-6 / (5 * dt)));
  EXPECT_NEAR(sum(plateau) / plateau.size() / expected, 1.0, tolerance);
  std::vector<double> above;
  for (double f : force) above.push_back(f - 0.5 * expected);
  const double on = zero_crossing(above), off = zero_crossing(above, 60e-6 / (5 * dt));
  EXPECT_NEAR((off - on) * 5 * dt / (2.0 * L / c_bar), 1.0, tolerance);

  // it flies off as it came, momentum by the impulse of the wall, energy constant
  EXPECT_EQ(lmp.fe(E_CONTACT), 0.0);
  const Particles end = body(lmp.particles());
  const double m = 0.05;
  EXPECT_NEAR(momentum(end)[0] / m, 1.0, 0.03);
  EXPECT_NEAR(-sum(force) * 5 * dt, momentum(end)[0] + m, 1e-3 * m);
  EXPECT_LT(largest_deviation(energy), 1e-3 * energy.front());
}

/// A cube of glass falls on a rigid floor at 2 m/s, turned by `angle`, and jumps back.
void bounce(double angle, const std::string &convert, double friction = 0.0)
{
  const double dt = 5e-8;
  Lammps lmp;
  lmp.commands(script(0.2, 0.5, dt, "-0.02 0.02 -0.02 0.03 -0.02 0.02", convert,
                      friction > 0.0 ? " friction " + number(friction) : "") +
               "create_hexes fe glass 1 x -0.004 4 0.004 y 0 4 0.008 z -0.004 4 0.004\n"
               "create_hexes fe wall 3 x -0.014 5 0.0137 y -0.004 1 0 z -0.0133 4 0.0142\n" + motion);
  lmp.run(0);    // what converts, does so in the mesh's own position
  const Mat3 R = (Eigen::AngleAxisd(angle, Vec3(1.0, 0.3, 0.5).normalized())).toRotationMatrix();
  const Particles start = body(lmp.particles());
  // lowest point just above the floor; spheres reach deeper than their centres
  double lowest = 1.0;
  for (const auto &p : start)
    lowest = std::min(lowest, (R * p.second.x)[1] - p.second.radius);
  lmp.change([&](Particle &p) {
    if (p.type == 3) return;
    p.x = R * p.x - Vec3(0.0, lowest - 1e-6, 0.0);
    p.v = Vec3(0.0, -2.0, 0.0);
  });
  lmp.run(0);
  const double m = 512e-9 * rho, before = lmp.fe(TOTAL);
  EXPECT_NEAR(before / (0.5 * m * 4.0), 1.0, 1e-9);
  lmp.record({"f_fe[22]", "c_push[1]", "c_push[2]", "c_push[3]", "f_fe[13]"}, 1);
  lmp.run(1200);    // 60 us
  const Particles end = body(lmp.particles());

  const auto energy = lmp.recorded(0), contact = lmp.recorded(4);
  EXPECT_EQ(lmp.fe(E_CONTACT), 0.0) << "it still touches";
  EXPECT_GT(*std::max_element(contact.begin(), contact.end()), 0.02 * before);
  // asked: 1 %; the contact lasts some us, omega dt = 0.03, and 60 % of the energy pass through it
  EXPECT_LT(largest_deviation(energy), 2e-3 * before);
  // what the wall does not take, the body keeps: half a step at both ends of the sum is 0
  const Vec3 p = momentum(end) - Vec3(0.0, -2.0 * m, 0.0);
  const Vec3 impulse = -dt * Vec3(sum(lmp.recorded(1)), sum(lmp.recorded(2)), sum(lmp.recorded(3)));
  EXPECT_LT((p - impulse).norm(), 1e-9 * m);
  EXPECT_GT(p[1], 2.2 * m);
  if (friction == 0.0) {
    EXPECT_LT(std::hypot(p[0], p[2]), 0.02 * p[1]);    // the floor is flat
    EXPECT_EQ(lmp.fe(FRICTION), 0.0);
  } else {
    const double tangential = std::hypot(p[0], p[2]);
    EXPECT_LT(tangential, friction * p[1]);
    EXPECT_GT(tangential, 0.5 * friction * p[1]);
    EXPECT_GT(lmp.fe(FRICTION), 0.01 * before);
  }
}

}    // namespace

TEST(SurfaceContact, BarHitsRigidWall)
{
  bar_hits_wall("", 0.02);
}

// its first 20 mm are DEs: spheres against the facets of the wall
TEST(SurfaceContact, BarWithDiscreteEndHitsRigidWall)
{
  bar_hits_wall("start end", 0.02);
}

TEST(SurfaceContact, BlockBouncesFlat)
{
  bounce(0.0, "");
}

TEST(SurfaceContact, BlockBouncesOnItsEdge)
{
  bounce(0.6, "");
}

TEST(SurfaceContact, DiscreteBlockBounces)
{
  bounce(0.0, "start all");
  bounce(0.6, "start all");
}

TEST(SurfaceContact, BlockBouncesWithFriction)
{
  bounce(0.6, "", 0.3);
}

// Two deformable blocks of other meshes collide, one edge first and off the other's middle: nobody
// else is there, so linear and angular momentum stay to rounding; every force has its reaction on
// the facet, distributed with the same moment but for the depth (see below).
TEST(SurfaceContact, TwoBlocksCollide)
{
  for (const std::string convert : {"", "start all"}) {
    const double dt = 4e-8;
    Lammps lmp;
    lmp.commands(script(0.2, 0.5, dt, "-0.02 0.02 -0.02 0.03 -0.02 0.02", convert,
                        " part other glass") +
                 "create_hexes fe glass 1 x -0.004 4 0.004 y 0.0001 4 0.0081 z -0.004 4 0.004\n"
                 "create_hexes fe other 1 x -0.0023 3 0.0072 y -0.006 2 0 z -0.0021 2 0.0041\n" +
                 motion);
    lmp.run(0);
    const Mat3 R = Eigen::AngleAxisd(0.01, Vec3(1.0, 0.0, 1.0).normalized()).toRotationMatrix();
    lmp.change([&](Particle &p) {
      if (p.x[1] < 0.00005) return;
      p.x = R * p.x;
      p.v = Vec3(1.0, -4.0, -1.0);
    });
    lmp.run(0);
    const Particles start = lmp.particles();
    const double before = lmp.fe(TOTAL), scale = momentum(start).norm();
    lmp.record({"f_fe[22]", "f_fe[13]"}, 5);
    lmp.run(1000);
    const Particles end = lmp.particles();
    const auto contact = lmp.recorded(1);
    EXPECT_GT(*std::max_element(contact.begin(), contact.end()), 0.02 * before) << convert;
    EXPECT_EQ(lmp.fe(E_CONTACT), 0.0) << "they still touch " << convert;
    EXPECT_LT(largest_deviation(lmp.recorded(0)), 0.005 * before) << convert;
    EXPECT_LT((momentum(end) - momentum(start)).norm(), 1e-12 * scale) << convert;
    // sphere and facet: the force goes through the point of contact; the sphere's centre is its
    // lever's other end
    EXPECT_LT((angular_momentum(end) - angular_momentum(start)).norm(), 1e-12 * scale * 0.01)
        << convert;
  if (rank_of(MPI_COMM_WORLD)==0) std::printf("%s energy %g contact %g P %g L %g\n",convert.c_str(), largest_deviation(lmp.recorded(0))/before,*std::max_element(contact.begin(), contact.end())/before,(momentum(end) - momentum(start)).norm()/scale,(angular_momentum(end) - angular_momentum(start)).norm()/scale/0.01);
  }
}

namespace {

/// A block of 4 x 4 x 4 elements on a rigid base, pressed by a uniform pressure on top and brought to
/// rest by viscous forces. Returns the elements' (y, syy, sxx, pressure of the base's nodes).
std::vector<std::vector<double>> press(const std::string &base, double pressure, double &base_force)
{
  const double dt = 1e-7, h = 2e-3;
  Lammps lmp;
  lmp.commands(script(0.0, 0.5, dt, "-0.02 0.03 -0.02 0.03 -0.02 0.03", "") +
               "create_hexes fe glass 1 x 0 4 0.008 y 0 4 0.008 z 0 4 0.008\n" + base + "\n" + motion +
               R"(
    # nodal forces of a uniform pressure: a quarter at the corners, half at the edges
    variable        wx atom 1-0.5*(x<1e-6||x>0.008-1e-6)
    variable        wz atom 1-0.5*(z<1e-6||z>0.008-1e-6)
    variable        fy atom v_wx*v_wz*)" + number(-pressure * h * h) + R"(
    fix             weight all store/state 0 v_fy
    variable        load atom f_weight
    region          top block INF INF 0.0079 INF INF INF
    group           top region top
    group           load intersect top nodes
    fix             press load addforce 0 v_load 0
    fix             calm nodes viscous 8
    compute         s all defe/hex/local y syy sxx szz
    run             3000
  )");
  EXPECT_LT(lmp.fe(E_KINETIC), 1e-6 * lmp.fe(E_ELEMENTS)) << "it still moves";
  base_force = lmp.value("c_push[2]");
  return lmp.local("s");
}

}    // namespace

// nu = 0 and a smooth base. With the base's nodes under the block's nodes the pressure is uniform to
// the nonlinearity (strain 1e-4); with a coarser base, whose nodes push at other points, roughly.
TEST(SurfaceContact, UniformPressure)
{
  const double pressure = 10e6, area = 64e-6;
  const struct {
    const char *base;
    double tolerance;
  } cases[] = {{"create_hexes fe wall 3 x 0 4 0.008 y -0.002 1 0 z 0 4 0.008", 1e-3},
               {"create_hexes fe wall 3 x -0.002 6 0.010 y -0.002 1 0 z -0.002 6 0.010", 1e-3},
               {"create_hexes fe wall 3 x -0.0031 4 0.0107 y -0.002 1 0 z -0.0033 5 0.0114", 0.3}};
  for (const auto &c : cases) {
    double force;
    const auto rows = press(c.base, pressure, force);
    ASSERT_EQ(rows.size(), 64u);
    EXPECT_NEAR(-force / (pressure * area), 1.0, 1e-4) << c.base;    // equilibrium
    double mean = 0.0, worst = 0.0;
    for (const auto &row : rows) {
      mean += row[1] / -pressure / 64.0;
      if (row[0] < 0.002) worst = std::max(worst, std::abs(row[1] / -pressure - 1.0));
    }
    EXPECT_NEAR(mean, 1.0, 1e-3) << c.base;
    EXPECT_LT(worst, c.tolerance) << c.base;
  if (rank_of(MPI_COMM_WORLD)==0) std::printf("force %g mean %g worst %g\n", -force / (pressure * area), mean, worst);
  }
}
