// Contact of finite elements is a potential: energy and momenta of bodies of any meshes that meet.
//
// ranks: 1 2
// timeout: 240

#include "contact_scene.h"

#include <cmath>

using namespace defe::test;
using defe::Mat3;
using defe::Vec3;

namespace {

/// Radius of the cap's upper side; it is highest at the origin.
constexpr double curvature = 0.03;

/// A cap of a sphere of 3 x 3 elements of 7 mm, 2 mm thick; a flat pane of that mesh, bent.
Vec3 bent(const Vec3 &X)
{
  const double r = curvature + (X[1] > 0.0 ? 0.0 : -0.002);
  const double angle = std::hypot(X[0], X[2]) / curvature;
  if (angle == 0.0) return Vec3(0.0, r - curvature, 0.0);
  const double out = r * std::sin(angle) / (angle * curvature);
  return Vec3(out * X[0], r * std::cos(angle) - curvature, out * X[2]);
}

/// A block of 3 x 3 x 3 elements of 2 mm, turned at random, comes down on the pane at `at`.
Scene drop(unsigned seed, double at_x, double at_z, double dt)
{
  Scene s;
  s.dt = dt;
  s.contact = "contact 0.5";
  s.add("pane", 2, {3, 1, 3}, 7e-3, bent);
  const Vec3 axis = random_of(1, seed), angle = random_of(2, seed);
  const Mat3 R = turn(0.9 * angle[0], axis);
  s.add("glass", 1, {3, 3, 3}, 2e-3, [&](const Vec3 &X) {
    return Vec3(R * X);
  });
  // no part of it that is over the pane is in the sphere
  double lift = -1.0;
  for (int i = 0; i < 13 * 13 * 13; i++) {
    const Vec3 p = R * (0.5e-3 * Vec3(i % 13 - 6, i / 13 % 13 - 6, i / 169 - 6));
    const double x = p[0] + at_x, z = p[2] + at_z;
    if (std::max(std::abs(x), std::abs(z)) > 10.1e-3) continue;
    lift = std::max(lift, std::sqrt(curvature * curvature - x * x - z * z) - curvature - p[1]);
  }
  for (size_t k = 0; k < s.mesh.X.size(); k++)
    if (s.mesh.type[k] == 1) s.mesh.X[k] += Vec3(at_x, lift + 5e-5, at_z);
  return s;
}

}    // namespace

namespace {

/// The block of drop() flies down at 10 m/s and turns.
Flight drop_on_pane(unsigned seed, double at_x, double at_z, double dt)
{
  Lammps lmp;
  drop(seed, at_x, at_z, dt).start(lmp);
  Particles block;
  for (const auto &p : lmp.particles())
    if (p.second.type == 1) block.insert(p);
  Vec3 middle = Vec3::Zero();
  for (const auto &p : block) middle += p.second.x / static_cast<double>(block.size());
  const Vec3 spin = 1e3 * random_of(3, seed);
  lmp.change([&](Particle &p) {
    if (p.type == 1) p.v = Vec3(3.0, -10.0, -2.0) + spin.cross(p.x - middle);
  });
  return fly(lmp, static_cast<int>(6e-5 / dt));
}

}    // namespace

// The error of the time integration is 1.5e-5 at this step, and falls with its square at least, see below.
TEST(ContactEnergy, BlockOnCurvedPane)
{
  struct Place {
    double x, z, contact;
  };
  // the middle, edges and corners between its elements, its rim, its corner, half over them
  const Place places[10] = {{0.0, 0.0, 0.1},        {3.5e-3, 0.0, 0.1},    {3.5e-3, 3.5e-3, 0.1},
                            {-3.2e-3, 1.1e-3, 0.1}, {7.0e-3, -2e-3, 0.1},  {10.2e-3, 0.0, 0.002},
                            {-9.5e-3, 3.4e-3, 0.1}, {9.8e-3, 9.8e-3, 0.1}, {-1e-3, 11.5e-3, 0.1},
                            {2e-3, -12.5e-3, 0.01}};
  for (unsigned k = 0; k < 10; k++) {
    SCOPED_TRACE(k);
    const Flight f = drop_on_pane(100 + k, places[k].x, places[k].z, 5e-8);
    EXPECT_GT(f.contact, places[k].contact) << "a poor example: it hardly touched";
    EXPECT_LT(f.deviation, 5e-5);
    EXPECT_LT(f.momentum, 1e-13);
    EXPECT_LT(f.angular, 1e-13);
    EXPECT_EQ(f.through, 0.0);
  }
}

TEST(ContactEnergy, ErrorFallsWithTheStep)
{
  const double coarse = drop_on_pane(100, 0.0, 0.0, 2e-8).deviation,
               fine = drop_on_pane(100, 0.0, 0.0, 1e-8).deviation;
  EXPECT_GT(coarse / fine, 3.8);
}

// Edges and corners of a cube that spins sweep over facets, their edges and nodes.
TEST(ContactEnergy, CubeSpinsOnPlate)
{
  for (int k = 0; k < 4; k++) {
    SCOPED_TRACE(k);
    const double dt = 5e-8;
    Scene s;
    s.dt = dt;
    s.contact = "contact 0.5";
    // finer, coarser, the same, seen from another angle
    const double h = (k == 0 ? 1e-3 : k == 1 ? 4e-3 : 2e-3);
    const int n = (k == 0 ? 10 : k == 1 ? 3 : 6);
    s.add("pane", 2, {n, k == 0 ? 2 : 1, n}, h, [&](const Vec3 &X) {
      return Vec3(turn(0.3 * k, Vec3(0, 1, 0)) * (X - Vec3(0.0, (k == 0 ? 1.0 : 0.5) * h, 0.0)));
    });
    const Mat3 R = turn(0.5 + 0.2 * k, Vec3(1.0, 0.1 * k, 0.4));
    double lowest = 1.0;
    const size_t first = s.mesh.X.size();
    s.add("glass", 1, {2, 2, 2}, 2e-3, [&](const Vec3 &X) {
      return Vec3(R * X);
    });
    for (size_t i = first; i < s.mesh.X.size(); i++) lowest = std::min(lowest, s.mesh.X[i][1]);
    const Vec3 c(0.3e-3, 2e-5 - lowest, -0.4e-3);
    for (size_t i = first; i < s.mesh.X.size(); i++) s.mesh.X[i] += c;
    Lammps lmp;
    s.start(lmp);
    const Vec3 spin(4e3, 3e4, -2e3);
    lmp.change([&](Particle &p) {
      if (p.type == 1) p.v = Vec3(0.0, -30.0, 0.0) + spin.cross(p.x - c);
    });
    const Flight f = fly(lmp, static_cast<int>(1.2e-4 / dt));
    EXPECT_GT(f.contact, 0.03) << "a poor example: it hardly touched";
    EXPECT_LT(f.deviation, 5e-5);
    EXPECT_LT(f.momentum, 1e-13);
    EXPECT_LT(f.angular, 1e-13);
    EXPECT_EQ(f.left, 0.0);
    EXPECT_EQ(f.through, 0.0);
  }
}

// ---- friction ----

namespace {

constexpr double mu = 0.3;

}    // namespace

// A block that a field presses on a plate slides: it is braked by mu g, to the moment when it stops.
TEST(ContactFriction, BlockSlidesToRest)
{
  const double g = 5e5, v0 = 12.0, dt = 5e-8;
  Scene s;
  s.dt = dt;
  s.contact = "contact 0.5 friction 0.3";
  s.add("pane", 2, {7, 1, 5}, 2.3e-3, [](const Vec3 &X) {
    return Vec3(X - Vec3(0.0, 1.15e-3, 0.0));
  });
  s.add("glass", 1, {3, 2, 3}, 2e-3, [](const Vec3 &X) {
    return Vec3(X + Vec3(-1e-3, 2e-3 + 1e-9, 0.2e-3));
  });
  s.more = "region floor block INF INF INF -0.0022 INF INF\ngroup floor region floor\ngroup block "
           "type 1\n";
  Lammps lmp;
  s.start(lmp);
  lmp.commands("fix weight block gravity " + number(g) +
               " vector 0 -1 0\nfix hold floor setforce 0 0 0\nvelocity block set " + number(v0) +
               " 0 0");
  lmp.run(0);
  const double m = 18 * 8e-9 * 2500.0, energy0 = 0.5 * m * v0 * v0;
  lmp.record({"f_fe[22]", "f_fe[18]", "vcm(block,x)", "vcm(block,y)"}, 1);
  const auto stop = static_cast<size_t>(v0 / (mu * g) / dt);
  lmp.run(static_cast<int>(stop) + 100);
  const auto total = lmp.recorded(0), rubbed = lmp.recorded(1), vx = lmp.recorded(2),
             vy = lmp.recorded(3);
  // half-way: what the plate has pushed, by the momentum of the block; friction is mu times that
  const size_t half = stop / 2;
  const double pushed = m * (g * dt * static_cast<double>(half) + vy[half] - vy[0]);
  EXPECT_NEAR(m * (vx[0] - vx[half]) / (mu * pushed), 1.0, 2e-3);
  EXPECT_NEAR(vx[half] / v0, 0.5, 0.05);    // it hops a little
  // the ledger against force times way of the block's middle, of which the lower side is a little ahead
  double work = 0.0;
  for (size_t k = 1; k <= half; k++) work += 0.5 * m * (vx[k - 1] * vx[k - 1] - vx[k] * vx[k]);
  EXPECT_NEAR(rubbed[half] / work, 1.0, 0.01);
  // at the end it sways on its tangential springs, and all has gone into friction
  EXPECT_LT(std::abs(vx.back()), 0.06 * v0);
  EXPECT_NEAR(rubbed.back() / energy0, 1.0, 0.01);
  EXPECT_LT(largest_deviation(total), 2e-3 * energy0);
}

// A block, of finite elements or of DEs, flies obliquely against a plate that nothing holds: it slides all
// the time, and the tangential impulse is mu times the normal one, against the motion. The account of
// friction is of first order in the step: half a step of it is in or out at any moment.
TEST(ContactFriction, TangentialImpulseIsFrictionTimesNormal)
{
  for (const std::string convert : {"", "convert glass 1e12 type 4 group particles start all"}) {
    SCOPED_TRACE(convert);
    Scene s;
    s.dt = 1e-8;
    s.convert = convert;
    s.contact = "contact 0.5 friction " + number(mu);
    s.coeff = "connective material cohesive 1e12 1e6 0.1 contact 1.0 " + number(mu);
    s.add("pane", 2, {6, 2, 6}, 2.3e-3, [](const Vec3 &X) {
      return Vec3(X - Vec3(0.0, 2.3e-3, 0.0));
    });
    s.add("glass", 1, {2, 1, 2}, 2e-3, [](const Vec3 &X) {
      return Vec3(X + Vec3(-1e-3, 1e-3 + 2e-5, 0.2e-3));
    });
    Lammps lmp;
    s.start(lmp);
    lmp.run(0);
    lmp.change([&](Particle &p) {
      if (p.x[1] > 1e-6) p.v = Vec3(30.0, -8.0, 12.0);
    });
    const Flight f = fly(lmp, 3000);
    EXPECT_GT(f.contact, 0.03);
    EXPECT_EQ(f.left, 0.0) << "they still touch";
    Vec3 impulse = Vec3::Zero(), spin = Vec3::Zero();
    for (const auto &it : f.end) {
      const Particle &p = it.second;
      if (p.type == 2) continue;
      impulse += p.mass * (p.v - f.start.at(p.tag).v);
      spin += 0.4 * p.mass * p.radius * p.radius * p.omega;
    }
    EXPECT_NEAR(std::hypot(impulse[0], impulse[2]) / impulse[1], mu, 0.002 * mu);
    EXPECT_NEAR(impulse[2] / impulse[0], 0.4, 0.005);
    EXPECT_LT(impulse[0], 0.0);
    EXPECT_GT(lmp.fe(FRICTION), 0.1 * f.energy0);
    EXPECT_LT(f.deviation, 1e-3);
    EXPECT_LT(f.momentum, 1e-13);
    EXPECT_LT(f.angular, 1e-13);
    // DEs are turned, with an arm of 1 mm, until their joints hold them
    if (!convert.empty()) { EXPECT_GT(spin.norm(), 1e-3 * 1e-3 * 1e-3 * impulse.norm()); }
  }
}

// ---- balls ----

namespace {

struct Drop {
  double R, x, z, v, dt;
  int n, layers;
  double gap;
};
constexpr double ball_h = 2e-3;

void start_ball(Lammps &lmp, const Drop &d)
{
  Scene s;
  s.dt = d.dt;
  const double y = 0.5 * d.layers * ball_h;
  s.add("glass", 1, {d.n, d.layers, d.n}, ball_h, [&](const Vec3 &X) {
    return Vec3(X - Vec3(0.0, y, 0.0));
  });
  s.mesh.hi[1] = 0.1;
  s.more = "region floor block INF INF INF " + number(-2.0 * y + 1e-6) +
      " INF INF\ngroup floor region floor\n"
      "create_atoms 3 single " +
      number(d.x) + " " + number(d.R + d.gap) + " " + number(d.z) + "\nset type 3 diameter " +
      number(2.0 * d.R) + " density 7800\ngroup ball type 3\n";
  s.start(lmp);
  lmp.commands("fix move3 ball nve/sphere\nfix hold floor setforce 0 0 0\nvelocity ball set 0 " +
               number(-d.v) +
               " 0\n"
               "compute push ball reduce sum fy\nrun 0\n");
}

}    // namespace

// Any ball is felt from where it touches, as the integral of its pressure over a plane says.
TEST(ContactBall, BeginsWhereItTouches)
{
  const double bulk = 74.09e9 / (3.0 * 0.6), k_area = 0.2 * bulk / ball_h;
  int k = 0;
  for (const double size : {0.25, 0.4, 0.7, 1.0, 2.0, 4.0, 9.0, 20.0})
    for (int place = 0; place < 3; place++) {
      SCOPED_TRACE(size);
      // 1e-4 of its radius in each step, so fast that the block does not yet feel it
      const double R = size * ball_h, dt = 1e-9;
      const Vec3 at = ball_h * random_of(++k, 7);
      Lammps lmp;
      start_ball(lmp, {R, at[0], at[2], 1e-4 * R / dt, dt, 4, 2, 0.5e-4 * R});
      lmp.record({"c_push"}, 1);
      lmp.run(11);
      const auto force = lmp.recorded();
      EXPECT_EQ(force[0], 0.0);
      EXPECT_GT(force[1], 0.0) << "it is 5e-5 of its radius deep";
      const double deep = 9.5e-4 * R;
      EXPECT_NEAR(force[10] / (std::acos(-1.0) * k_area * R * deep * deep), 1.0, 0.01);
    }
}

// The peak of its force does not depend on where it lands on the mesh.
TEST(ContactBall, PeakForceDoesNotDependOnThePlace)
{
  for (const double R : {1.5e-3, 4e-3, 20e-3}) {
    SCOPED_TRACE(R);
    double least = 1e300, most = 0.0;
    // on an element, an edge, a corner, and elsewhere
    for (const Vec3 &at : {Vec3(1e-3, 0.0, 1e-3), Vec3(1e-3, 0.0, 0.0), Vec3(0.0, 0.0, 0.0),
                           Vec3(1e-3 * random_of(4, 3)), Vec3(1e-3 * random_of(5, 3))}) {
      Lammps lmp;
      start_ball(lmp, {R, at[0], at[2], 3.0, R > 5e-3 ? 1e-7 : 5e-8, 8, 3, 1e-7});
      const double energy0 = lmp.fe(TOTAL);
      lmp.record({"c_push", "f_fe[22]"}, 1);
      lmp.run(R < 2e-3 ? 700 : 1500);
      const auto force = lmp.recorded(0);
      const auto peak = std::max_element(force.begin(), force.end());
      EXPECT_LT(*(force.end() - 1), *peak) << "the peak is still to come";
      least = std::min(least, *peak);
      most = std::max(most, *peak);
      EXPECT_LT(largest_deviation(lmp.recorded(1)), 1e-5 * energy0);
    }
    EXPECT_LT(most / least, 1.02);
  }
}

// A small ball that is pressed slowly on a fine mesh, with a stiff penalty: Hertz. The penalty is softer by its
// own compliance, the block of 12 mm and the elements of half the radius of contact are stiffer.
TEST(ContactBall, SmallBallOnAFineMeshIsHertz)
{
  const double R = 5e-3, deep = 5e-5, dt = 4e-9;
  const int press = 2500, rest = 500;
  Scene s;
  s.dt = dt;
  s.contact = "contact 20";
  const auto grow = [](double i) {
    return std::copysign(0.25e-3 * (std::pow(1.5, std::abs(i)) - 1.0) / 0.5, i);
  };
  s.add("glass", 1, {16, 8, 16}, 1.0, [&](const Vec3 &X) {
    return Vec3(grow(X[0]), grow(X[1] - 4.0), grow(X[2]));
  });
  s.more = "region floor block INF INF INF -0.012 INF INF\ngroup floor region floor\ncreate_atoms "
           "3 single 0 " +
      number(R + 1e-9) + " 0\nset type 3 diameter " + number(2.0 * R) +
      " density 7800\ngroup ball type 3\n";
  Lammps lmp;
  s.start(lmp);
  lmp.commands("fix move3 ball move linear 0 " + number(-deep / (press * dt)) +
               " 0\nfix hold floor setforce 0 0 0\ncompute push ball reduce sum fy");
  lmp.run(press);
  lmp.commands("unfix move3\nvelocity ball set 0 0 0");
  lmp.record({"c_push"}, 1);
  lmp.run(rest);
  double force = 0.0;
  for (double f : lmp.recorded()) force += f / (rest + 1);
  const double hertz = 4.0 / 3.0 * 74.09e9 / (1.0 - 0.04) * std::sqrt(R) * std::pow(deep, 1.5);
  EXPECT_NEAR(force / hertz, 1.0, 0.1);
}
