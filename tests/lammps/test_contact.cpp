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
  return script_head() + R"(
    region          box block )" +
      box + R"(
    create_box      3 box
    region          end block INF 0.02 INF INF INF INF
    pair_style      defe/joint
    pair_coeff      2 2 connective material cohesive 1e12 1e6 0.1 contact 0.9 0.0
    group           particles empty
    fix             fe all defe material glass elastic )" +
      number(E) + " " + number(nu) + " " + number(rho) +
      R"( material wall rigid 7800 convert glass 1e12 type 2 group particles )" + convert +
      " contact " + number(factor) + more + R"(
    neighbor        0.0003 bin
    neigh_modify    every 1 delay 0 check yes
    timestep        )" +
      number(dt) + "\n";
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
  EXPECT_LT(lmp.fe(E_CONTACT), 1e-20 * energy.front());
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
               "create_hexes fe wall 3 x -0.014 5 0.0137 y -0.004 1 0 z -0.0133 4 0.0142\n" +
               motion);
  lmp.run(0);    // what converts, does so in the mesh's own position
  const Mat3 R = (Eigen::AngleAxisd(angle, Vec3(1.0, 0.3, 0.5).normalized())).toRotationMatrix();
  const Particles start = body(lmp.particles());
  // lowest point just above the floor; spheres reach deeper than their centres
  double lowest = 1.0;
  for (const auto &p : start) lowest = std::min(lowest, (R * p.second.x)[1] - p.second.radius);
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

// Two deformable blocks of other meshes collide, off each other's middle, with an edge of one 0.1
// mm beside the edge of the other: nobody else is there, so linear and angular momentum stay to
// rounding.
TEST(SurfaceContact, TwoBlocksCollide)
{
  for (const std::string convert : {"", "start all"}) {
    const double dt = 4e-8;
    Lammps lmp;
    lmp.commands(
        script(0.2, 0.5, dt, "-0.02 0.02 -0.02 0.03 -0.02 0.02", convert, " part other glass") +
        "create_hexes fe glass 1 x -0.004 4 0.004 y 0.00001 4 0.00801 z -0.004 4 0.004\n"
        "create_hexes fe other 1 x -0.0023 3 0.0072 y -0.006 2 0 z -0.0021 2 0.0041\n" +
        motion);
    lmp.run(0);
    const Mat3 R = Eigen::AngleAxisd(0.01, Vec3(1.0, 0.0, 1.0).normalized()).toRotationMatrix();
    lmp.change([&](Particle &p) {
      if (p.x[1] < 0.000005) return;
      p.x = R * p.x + Vec3(0.0, 5e-5, 0.0);    // still apart
      p.v = Vec3(1.0, -4.0, -1.0);
    });
    lmp.run(0);
    const Particles start = lmp.particles();
    const double before = lmp.fe(TOTAL), scale = momentum(start).norm();
    lmp.record({"f_fe[22]", "f_fe[13]"}, 5);
    lmp.run(1500);
    const Particles end = lmp.particles();
    const auto contact = lmp.recorded(1);
    EXPECT_GT(*std::max_element(contact.begin(), contact.end()), 0.02 * before) << convert;
    EXPECT_EQ(lmp.fe(E_CONTACT), 0.0) << "they still touch " << convert;
    EXPECT_LT(largest_deviation(lmp.recorded(0)), 0.005 * before) << convert;
    EXPECT_LT((momentum(end) - momentum(start)).norm(), 1e-12 * scale) << convert;
    EXPECT_LT((angular_momentum(end) - angular_momentum(start)).norm(), 1e-12 * scale * 0.01)
        << convert;
  }
}

namespace {

/// A block of 4 x 4 x 4 elements on a rigid base, pressed by a uniform pressure on top and brought
/// to rest by viscous forces. Returns y and syy of the elements' centres.
std::vector<std::vector<double>> press(const std::string &base, double pressure, double &base_force)
{
  const double dt = 1e-7, h = 2e-3;
  Lammps lmp;
  lmp.commands(script(0.0, 0.5, dt, "-0.02 0.03 -0.02 0.03 -0.02 0.03", "") +
               "create_hexes fe glass 1 x 0 4 0.008 y 0 4 0.008 z 0 4 0.008\n" + base + "\n" +
               motion +
               R"(
    # nodal forces of a uniform pressure: a quarter at the corners, half at the edges
    variable        wx atom 1-0.5*(x<1e-6||x>0.008-1e-6)
    variable        wz atom 1-0.5*(z<1e-6||z>0.008-1e-6)
    variable        fy atom v_wx*v_wz*)" +
               number(-pressure * h * h) + R"(
    fix             weight all store/state 0 v_fy
    variable        load atom f_weight
    region          top block INF INF 0.0079 INF INF INF
    group           top region top
    group           load intersect top nodes
    fix             press load addforce 0 v_load 0
    fix             calm nodes viscous 8
    compute         s nodes defe/hex/local y syy
    run             3000
  )");
  EXPECT_LT(lmp.fe(E_KINETIC), 1e-6 * lmp.fe(E_ELEMENTS)) << "it still moves";
  base_force = lmp.value("c_push[2]");
  return lmp.local("s");
}

}    // namespace

// nu = 0 and a smooth base. With a base of the same mesh the pressure is uniform to rounding. Where
// the base goes on beyond the block, its nodes at the block's border stand for areas of which half
// is not covered, and where its nodes lie elsewhere they push at other points: uniform roughly.
TEST(SurfaceContact, PressureOfAFlatBlockIsUniform)
{
  const double pressure = 10e6, area = 64e-6;
  const struct {
    const char *base;
    double tolerance;
  } cases[] = {{"create_hexes fe wall 3 x 0 4 0.008 y -0.002 1 0 z 0 4 0.008", 1e-6},
               {"create_hexes fe wall 3 x -0.002 6 0.010 y -0.002 1 0 z -0.002 6 0.010", 0.3},
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
  }
}

// ---- loose spheres ----

namespace {

/// Two single DEs, of two elements of 2 mm of which nothing else is left, with pair style
/// defe/contact: A flies at B with `velocity`, B's centre is at `offset` from A's.
struct Collision {
  double restitution, friction;
  Vec3 offset, velocity;
  double dt;
  int steps;
  std::string law = "";

  Block block() const
  {
    Block b;
    b.n[0] = b.n[1] = b.n[2] = 1;
    b.pair = "defe/contact";
    b.coeff = "contact " + number(restitution) + " " + number(friction) + " " + law;
    b.convert += " start all";
    b.dt = dt;
    return b;
  }
};

struct Outcome {
  Particles start, end;
  double damping, friction, total_before, total_after;
  int touching;    // steps
};

void start(Lammps &lmp, const Collision &c)
{
  const Block block = c.block();
  lmp.commands(block.header() + block.box() + block.fix() + block.mesh() +
               "create_hexes fe glass 1 x 0.01 1 0.012 y 0 1 0.002 z 0 1 0.002\n" + block.motion());
  lmp.run(0);
  EXPECT_EQ(lmp.fe(CONTACT), 2 * 12);    // born apart
  // 16 nodes had IDs 1 to 16: the DEs have 17 to 24 and 25 to 32
  lmp.commands("group some id 18:24 26:32\ndelete_atoms group some compress no");
  EXPECT_EQ(lmp.natoms(), 2);
  lmp.change([&](Particle &p) {
    if (p.tag == 17) {
      p.v = c.velocity;
      p.x = Vec3(0.001, 0.001, 0.001);
    } else
      p.x = Vec3(0.001, 0.001, 0.001) + c.offset;
  });
  lmp.run(0);
}

Outcome collide(const Collision &c)
{
  Lammps lmp;
  start(lmp, c);
  Outcome result;
  result.start = lmp.particles();
  result.total_before = lmp.fe(TOTAL);
  lmp.record({"f_fe[13]"}, 1);
  lmp.run(c.steps);
  result.end = lmp.particles();
  result.damping = lmp.fe(DAMPING);
  result.friction = lmp.fe(FRICTION);
  result.total_after = lmp.fe(TOTAL);
  EXPECT_EQ(lmp.fe(E_CONTACT), 0.0);
  result.touching = 0;
  for (double e : lmp.recorded()) result.touching += (e > 0.0);
  return result;
}

constexpr double d = 1e-3;               // diameter
constexpr double m = rho * d * d * d;    // mass of a cube d x d x d

}    // namespace

// Head-on: the velocity of separation is e times that of approach; the contact lasts half a period
// of the spring kn = E d with the reduced mass, less or more for the damping.
TEST(SphereContact, RestitutionIsTheGivenOne)
{
  for (const double e : {1.0, 0.7, 0.3}) {
    const double v = 3.0, dt = 1e-9;
    const Outcome r = collide({e, 0.0, Vec3(1.01 * d, 0.0, 0.0), Vec3(v, 0.0, 0.0), dt, 5000});
    const Vec3 va = r.end.at(17).v, vb = r.end.at(25).v;
    // 400 steps per contact: velocity Verlet is right to (omega dt)^2, damping with half-step
    // velocities to omega dt/2 of itself
    EXPECT_NEAR((vb - va)[0] / v, e, 0.004) << e;
    EXPECT_LT((m * (va + vb) - m * Vec3(v, 0.0, 0.0)).norm(), 1e-13 * m * v) << e;
    EXPECT_NEAR(r.damping, 0.25 * m * v * v * (1.0 - e * e), 0.005 * m * v * v) << e;
    EXPECT_NEAR(r.total_after / r.total_before, 1.0, 1e-5) << e;
    EXPECT_EQ(r.friction, 0.0);
    if (e == 1.0) {
      const double half_period = M_PI * std::sqrt(0.5 * m / (E * d));
      EXPECT_NEAR(r.touching * dt / half_period, 1.0, 0.01);
    }
  }
}

// Oblique with gross sliding (Chung and Ooi 2011, test 4, for two equal spheres): the tangential
// impulse is mu times the normal one, whatever happens on the way.
TEST(SphereContact, TangentialImpulseIsFrictionTimesNormal)
{
  const double mu = 0.15, e = 0.8;
  // the line of centres at contact is y; A comes along, steeply
  const double vn = 2.0, vt = 4.0;
  const double fly = 0.01 * d / vn;    // time to touch
  const Outcome r = collide({e, mu, Vec3(vt * fly, 1.01 * d, 0.0), Vec3(vt, vn, 0.0), 1e-9, 10000});
  const auto &a = r.end.at(17), &b = r.end.at(25);
  // normal: as head-on; the line of centres turns by vt t/d = 2e-3 in the contact
  const double normal = m * b.v[1], tangential = m * b.v[0];
  EXPECT_NEAR(normal / (0.5 * m * (1.0 + e) * vn), 1.0, 0.01);
  EXPECT_NEAR(tangential / normal, mu, 0.005);
  // the points of contact still slide: each sphere's velocity and 2.5 times as much of spin
  const double slip = (a.v - b.v)[0] - 0.5 * d * (a.omega[2] + b.omega[2]);
  EXPECT_NEAR(slip / (vt - 7.0 * tangential / m), 1.0, 0.01);
  EXPECT_GT(slip, 0.4 * vt);
  // both spin the same way: a torque of r times the tangential impulse, I = 0.4 m r^2
  for (const auto *p : {&a, &b}) {
    EXPECT_NEAR(std::abs(p->omega[2]) / (tangential * 0.5 * d / (0.4 * m * 0.25 * d * d)), 1.0,
                0.01);
    EXPECT_GT(p->omega[2] * a.omega[2], 0.0);
  }
  EXPECT_LT((momentum(r.end) - momentum(r.start)).norm(), 1e-13 * m * 5.0);
  EXPECT_LT((angular_momentum(r.end) - angular_momentum(r.start)).norm(), 1e-12 * m * 5.0 * d);
  EXPECT_GT(r.friction, 0.0);
  EXPECT_NEAR(r.total_after / r.total_before, 1.0, 1e-3);
}

// A slow grazing collision sticks: the tangential spring gives part of the motion back, no friction
// is lost if the coefficient is large.
TEST(SphereContact, StickingKeepsTheEnergy)
{
  const double vn = 2.0, vt = 0.5, fly = 0.01 * d / vn;
  for (const std::string law : {"linear", "hertz"}) {
    const Outcome r =
        collide({1.0, 10.0, Vec3(vt * fly, 1.01 * d, 0.0), Vec3(vt, vn, 0.0), 1e-9, 10000, law});
    EXPECT_LT((momentum(r.end) - momentum(r.start)).norm(), 1e-13 * m * 5.0);
    EXPECT_LT((angular_momentum(r.end) - angular_momentum(r.start)).norm(), 1e-12 * m * 5.0 * d);
    EXPECT_NE(r.end.at(17).omega[2], 0.0);
    EXPECT_LT(kinetic_energy(r.end), kinetic_energy(r.start) * (1.0 + 1e-4));
    EXPECT_NEAR(r.total_after / r.total_before, 1.0, 1e-3) << law;
  }
}

// The duration of Hertz' collision, 2.87 (m^2/(R E*^2 v))^(1/5) with the reduced numbers, which depends on the speed;
// and the restitution, which does not.
TEST(SphereContact, HertzCollisionLastsAsLongAsItShould)
{
  for (const double v : {1.0, 8.0})
    for (const double e : {1.0, 0.5}) {
      const double E_star = 0.5 * E / (1.0 - 0.2 * 0.2), R = 0.25 * d;
      const double duration = 2.868266 * std::pow(0.25 * m * m / (R * E_star * E_star * v), 0.2);
      const double dt = duration / 1000.0;
      const Outcome r =
          collide({e, 0.0, Vec3(d + 5.0 * dt * v, 0.0, 0.0), Vec3(v, 0.0, 0.0), dt, 2000, "hertz"});
      EXPECT_NEAR((r.end.at(25).v - r.end.at(17).v)[0] / v, e, 0.004);
      EXPECT_NEAR(r.damping, 0.25 * m * v * v * (1.0 - e * e), 0.005 * m * v * v);
      EXPECT_NEAR(r.total_after / r.total_before, 1.0, 1e-5);
      if (e == 1.0) { EXPECT_NEAR(r.touching / 1000.0, 1.0, 3e-3) << v; }
    }
}

// A restart file has the law and the tangential spring: an oblique collision that is cut in the middle.
TEST(SphereContact, HertzOverARestart)
{
  const double vn = 2.0, vt = 3.0, dt = 2e-9;
  const Collision c{0.8, 0.3, Vec3(0.0, d + 1e-8, 0.0), Vec3(vt, vn, 0.0), dt, 0, "hertz"};
  constexpr int middle = 300, all = 2000;
  Particles whole;
  double energy = 0.0;
  {
    Lammps lmp;
    start(lmp, c);
    lmp.run(middle);
    EXPECT_GT(lmp.fe(E_CONTACT), 1e-3 * m * vn * vn) << "it does not touch";
    EXPECT_GT(lmp.fe(FRICTION), 0.0);
    lmp.command("write_restart hertz.restart");
    lmp.run(all - middle);
    whole = lmp.particles();
    energy = lmp.fe(TOTAL);
    EXPECT_EQ(lmp.fe(E_CONTACT), 0.0) << "it still touches";
  }
  Lammps lmp;
  lmp.commands(c.block().header() + "read_restart hertz.restart\n" + c.block().fix_only() +
               c.block().motion());
  lmp.run(all - middle);
  EXPECT_LT(difference(whole, lmp.particles(), &Particle::x), 1e-15);
  EXPECT_LT(difference(whole, lmp.particles(), &Particle::v), 1e-12 * vt);
  EXPECT_LT(difference(whole, lmp.particles(), &Particle::omega), 1e-12 * vt / d);
  EXPECT_NEAR(lmp.fe(TOTAL) / energy, 1.0, 1e-12);
}

// Fragments of bonded spheres: damping takes energy out, and the ledger knows how much.
TEST(SphereContact, WhatFragmentsLoseIsInTheAccount)
{
  Block block;
  block.n[0] = block.n[1] = block.n[2] = 2;
  block.coeff = "connective material cohesive 1e12 1e6 0.1 contact 0.6 0.3";
  block.convert += " start all";
  block.dt = 2e-8;
  Lammps lmp;
  lmp.commands(
      block.header() + block.box() + block.fix() + block.mesh() +
      "create_hexes fe glass 1 x 0.0011 2 0.0051 y 0.00401 2 0.00801 z -0.0001 2 0.0039\n" +
      block.motion());
  lmp.change([&](Particle &p) {
    if (p.x[1] > 0.004005) p.v = Vec3(1.0, -3.0, 0.5);
  });
  lmp.run(0);
  const Particles start = lmp.particles();
  const double before = lmp.fe(TOTAL), scale = momentum(start).norm();
  lmp.record({"f_fe[22]", "f_fe[13]", "f_fe[17]", "f_fe[18]"}, 5);
  lmp.run(2000);
  const Particles end = lmp.particles();
  const auto contact = lmp.recorded(1), damped = lmp.recorded(2), rubbed = lmp.recorded(3);
  EXPECT_GT(*std::max_element(contact.begin(), contact.end()), 0.05 * before);
  EXPECT_GT(damped.back(), 0.02 * before);
  EXPECT_GT(rubbed.back(), 1e-3 * before);
  // what is lost is lost; the dashpot's force is of half a step earlier than the velocity it is
  // booked with, which may have turned round since
  for (size_t k = 1; k < damped.size(); k++) EXPECT_GE(damped[k], damped[k - 1] - 1e-4 * before);
  for (size_t k = 1; k < rubbed.size(); k++) EXPECT_GE(rubbed[k], rubbed[k - 1]);
  EXPECT_LT(largest_deviation(lmp.recorded(0)), 0.01 * before);
  EXPECT_LT((momentum(end) - momentum(start)).norm(), 1e-12 * scale);
  EXPECT_LT((angular_momentum(end) - angular_momentum(start)).norm(), 1e-12 * scale * 0.01);
  EXPECT_LT(kinetic_energy(end), 0.95 * before);
  EXPECT_EQ(lmp.fe(COHESIVE) + lmp.fe(CONTACT), 0.0);
}
