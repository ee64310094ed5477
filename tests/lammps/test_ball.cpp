// A ball, a LAMMPS sphere that is no DE, against a block of glass: its finite elements, or the DEs
// that they have become.
//
// timeout: 240

#include "glass_block.h"
#include "programs.h"

#include <cmath>
#include <tuple>

using namespace defe::test;
using defe::Vec3;

namespace {

constexpr double h = 2e-3;

struct Hit {
  double radius = 5e-3;
  Vec3 at = Vec3(4.3e-3, 3.8e-3, 0.0);    // above the block
  Vec3 velocity = Vec3(0.0, 0.0, -2.0);
  std::string friction;
  std::string convert = "1e12 type 2 group particles";
  std::string factor = "0.2";
  double dt = 5e-8;
  double flat = 1.0;
  int along = 4;         // elements along x
  std::string law;       // of its contact with DEs
  std::string ghosts;    // commands on them
  std::string processors;

  Block block() const
  {
    Block b;
    b.flat = flat;
    b.processors = processors;
    b.n[0] = along;
    b.n[1] = 4;
    b.box_hi[0] += (along - 4) * h;
    b.n[2] = 2;
    b.dt = dt;
    b.options = "contact " + factor + friction;
    b.convert = convert;
    b.coeff = "connective material cohesive 1e12 1e6 0.1 contact 1.0 0.0\n"
              "pair_coeff 2 3 contact 1.0 " +
        std::string(friction.empty() ? "0 " : "0.3 ") + law;
    return b;
  }
  std::string motion() const
  {
    return block().motion() + "group ball type 3\nfix move3 ball nve/sphere\n" + ghosts;
  }
  double mass() const { return 4.0 / 3.0 * std::acos(-1.0) * radius * radius * radius * 7800.0; }

  void start(Lammps &lmp) const
  {
    const Block b = block();
    std::string box = b.box();
    box.replace(box.find("create_box 2"), 12, "create_box 3");
    const Vec3 c = at + Vec3(0.0, 0.0, 2.0 * h * flat + radius + 1e-7);
    lmp.commands(b.header() + box + b.fix() + b.mesh() + "create_atoms 3 single " + number(c[0]) +
                 " " + number(c[1]) + " " + number(c[2]) + "\nset type 3 diameter " +
                 number(2.0 * radius) + " density 7800\n" + motion() + "velocity ball set " +
                 number(velocity[0]) + " " + number(velocity[1]) + " " + number(velocity[2]) +
                 "\nrun 0\n");
  }
};

Particle ball_of(const Particles &all)
{
  for (const auto &p : all)
    if (p.second.type == 3) return p.second;
  throw std::runtime_error("no ball");
}

double sum(const std::vector<double> &a)
{
  double s = 0.0;
  for (double v : a) s += v;
  return s;
}

/// Let it hit and fly off again; force on the ball (z) at every step.
std::vector<double> bounce(const Hit &hit, int steps, Particles *last = nullptr)
{
  const double dt = hit.dt;
  Lammps lmp;
  hit.start(lmp);
  const Particles before = lmp.particles();
  const double energy0 = 0.5 * hit.mass() * hit.velocity.squaredNorm();
  EXPECT_NEAR(lmp.fe(E_KINETIC) / energy0, 1.0, 1e-12);    // it is in the account
  lmp.command("compute push ball reduce sum fx fy fz");
  lmp.record({"f_fe[22]", "c_push[3]", "c_push[1]"}, 1);
  lmp.run(steps);
  const Particles after = lmp.particles();
  const auto energy = lmp.recorded(0), force = lmp.recorded(1), along = lmp.recorded(2);
  const double scale = hit.mass() * hit.velocity.norm();
  EXPECT_LT((momentum(after) - momentum(before)).norm(), 1e-10 * scale);
  const Vec3 c = centre_of_mass(before);
  EXPECT_LT((angular_momentum(after, c) - angular_momentum(before, c)).norm(), 1e-9 * scale * h);
  EXPECT_LT(largest_deviation(energy), 2e-3 * energy0);
  EXPECT_EQ(lmp.fe(E_CONTACT), 0.0) << "it still touches";

  // its own force is that of the contact
  const Particle ball = ball_of(after);
  EXPECT_NEAR(sum(force) * dt, hit.mass() * (ball.v[2] - hit.velocity[2]), 1e-9 * scale);
  EXPECT_GT(ball.v[2], hit.velocity[2]);
  for (double f : force) EXPECT_GE(f, -1e-12 * hit.mass() / dt);    // it is never pulled
  if (hit.friction.empty()) {
    EXPECT_EQ(lmp.fe(FRICTION), 0.0);
    EXPECT_LT(ball.omega.norm(), 1e-10);
  } else {
    EXPECT_GT(lmp.fe(FRICTION), 0.0);
    EXPECT_GT(ball.omega[1], 0.0);    // it begins to roll
    EXPECT_LE(-sum(along), 0.3 * sum(force) * 1.1);
    EXPECT_GT(-sum(along), 0.05 * sum(force));
  }
  if (last) *last = after;
  return force;
}

}    // namespace

// larger than the facets, about as large, and smaller
TEST(Ball, BouncesOfAnySizeWithoutLosingEnergy)
{
  for (double radius : {8e-3, 2e-3, 0.5e-3}) {
    Hit hit;
    hit.radius = radius;
    Particles last;
    (void) bounce(hit, radius > 5e-3 ? 2000 : 1200, &last);
    // the block takes part of the energy as vibration; the ball of the smallest mass comes back
    if (radius < 1e-3) { EXPECT_GT(ball_of(last).v[2], 1.5); }
  }
}

TEST(Ball, ObliqueWithFriction)
{
  for (double radius : {5e-3, 0.5e-3}) {
    Hit hit;
    hit.radius = radius;
    hit.velocity = Vec3(2.0, 0.0, -2.0);
    hit.friction = " friction 0.3";
    if (radius < 1e-3) hit.dt = 2.5e-8;    // its tangential spring is stiff for so light a spin
    (void) bounce(hit, 1500);
  }
}

// DEs give the ball the same push as the elements that they were, those of flat and of tall cells, too. They
// take 5 to 8 % less of it: the smooth face presses from the first touch, a DE that is hit beside its middle
// as if it were hit there.
TEST(Ball, HitsDiscreteBlock)
{
  for (const auto &[radius, flat] :
       {std::pair(5e-3, 1.0), {2e-3, 1.0}, {5e-3, 0.5}, {5e-3, 0.75}, {5e-3, 1.5}}) {
    SCOPED_TRACE(flat);
    Hit hit;
    hit.radius = radius;
    hit.flat = flat;
    hit.dt = flat < 1.0 ? 2.5e-8 : 5e-8;
    const auto finite = bounce(hit, 3000);
    hit.convert += " start all";
    const auto discrete = bounce(hit, 3000);
    const auto most = [](const std::vector<double> &a) {
      return *std::max_element(a.begin(), a.end());
    };
    const auto lasts = [](const std::vector<double> &a) {
      return static_cast<double>(std::count_if(a.begin(), a.end(), [](double f) {
        return f > 0.0;
      }));
    };
    EXPECT_NEAR(sum(discrete) / sum(finite), 0.96, 0.05);
    EXPECT_NEAR(most(discrete) / most(finite), 1.0, 0.1);
    EXPECT_NEAR(lasts(discrete) / lasts(finite), 1.0, 0.1);
  }
}

// Elements convert while the ball presses on them: the account goes on without a jump.
TEST(Ball, ElementsConvertUnderIt)
{
  for (const auto &[flat, law, split] : {std::tuple(1.0, "", 2),
                                         {0.75, "", 2},
                                         {0.5, "", 2},
                                         {1.5, "", 2},
                                         {1.0, "hertz", 2},
                                         {1.0, "", 1},
                                         {1.0, "", 3}}) {
    SCOPED_TRACE(flat);
    SCOPED_TRACE(split);
    Hit hit;
    hit.flat = flat;
    hit.law = law;
    hit.at = Vec3(4e-3, 4e-3, 0.0);
    hit.radius = 10e-3;
    hit.velocity = Vec3(0.0, 0.0, -4.0);
    hit.convert = (flat > 1.0 ? "2e6" : "4e6") + std::string(" type 2 group particles split ") +
        std::to_string(split);
    hit.dt = 2e-8;
    Lammps lmp;
    hit.start(lmp);
    const double energy0 = 0.5 * hit.mass() * hit.velocity.squaredNorm();
    lmp.record({"f_fe[22]", "f_fe[2]", "f_fe[13]"}, 1);
    lmp.run(1000);
    const auto energy = lmp.recorded(0), converted = lmp.recorded(1), pressed = lmp.recorded(2);
    double rise = 0.0, stored = 0.0;
    for (size_t k = 1; k < energy.size(); k++) {
      rise = std::max(rise, energy[k] - energy[0]);
      if (converted[k] > converted[k - 1]) stored = std::max(stored, pressed[k - 1]);
    }
    EXPECT_GE(converted.back(), 4.0);
    EXPECT_GT(stored, 2e-3 * energy0) << "a poor example: it did not press";
    EXPECT_LT(rise, 1e-3 * energy0);
  }
}

/// Nodes, DEs and balls as ghosts, each to its own distance.
const std::string by_type = "neighbor 0.0005 multi\ncomm_modify mode multi reduce/multi vel yes\n";

TEST(Ball, SameOnAnyNumberOfRanks)
{
  for (double radius : {5e-3, 0.5e-3})
    for (const std::string convert :
         {"1e12 type 2 group particles", "1e12 type 2 group particles start all",
          "2e6 type 2 group particles"}) {
      Hit hit;
      hit.law = radius < 1e-3 ? "hertz" : "linear";
      hit.radius = radius;
      hit.velocity = Vec3(1.0, 0.5, -3.0);
      hit.friction = " friction 0.3";
      hit.convert = convert;
      hit.dt = 2.5e-8;
      double converted = 0.0;
      const auto run = [&](MPI_Comm comm, const Hit &h) {
        Lammps lmp(comm);
        h.start(lmp);
        lmp.run(1000);
        converted = lmp.fe(CONVERTED);
        return lmp.particles();
      };
      const Particles one = on_one_rank([&] {
        return run(MPI_COMM_SELF, hit);
      });
      for (const auto &ghosts : {std::string(), by_type, "comm_style tiled\n" + by_type}) {
        SCOPED_TRACE(convert + ", " + ghosts);
        Hit way = hit;
        way.ghosts = ghosts;
        const Particles all = run(MPI_COMM_WORLD, way);
        EXPECT_LT(difference(one, all, &Particle::x), 1e-13);
        EXPECT_LT(difference(one, all, &Particle::v), 1e-7);
        if (convert[0] == '2' && radius > 1e-3) { EXPECT_GE(converted, 1.0) << "a poor example"; }
      }
    }
}

// Contact is computed at the facet: a ball alone must be known as far as it reaches. In a long bar most ranks
// then know few nodes of others; LAMMPS' own way is one distance for all, which a note says.
TEST(Ball, AloneIsKnownFarAway)
{
  const auto ghosts = [](const std::string &how, std::string &log) {
    Hit hit;
    hit.along = 24;
    hit.radius = 10e-3;
    hit.processors = "* 1 1";
    hit.ghosts = how;
    Lammps lmp;
    lmp.command("log ghosts.txt");
    hit.start(lmp);
    lmp.command("log none");
    MPI_Barrier(MPI_COMM_WORLD);
    log = contents("ghosts.txt");
    MPI_Barrier(MPI_COMM_WORLD);
    int mine = lmp->atom->nghost, all = 0;
    MPI_Allreduce(&mine, &all, 1, MPI_INT, MPI_SUM, MPI_COMM_WORLD);
    return all;
  };
  std::string single, multi;
  const int far = ghosts("", single), near = ghosts(by_type, multi);
  if (size_of(MPI_COMM_WORLD) == 1) {
    EXPECT_EQ(far, 0);
    EXPECT_EQ(single.find("Note: ghosts"), std::string::npos);
    return;
  }
  // 5.9 mm for 20.5, which are more than a rank has of the bar
  EXPECT_LT(near, 0.6 * far);
  EXPECT_GT(near, 0);
  EXPECT_NE(single.find("comm_modify mode multi reduce/multi vel yes"), std::string::npos)
      << single;
  EXPECT_EQ(multi.find("Note: ghosts"), std::string::npos) << multi;
}

// A heavy field presses the ball on a block that stands: the contact carries its weight.
TEST(Ball, RestsWithItsWeightCarried)
{
  for (double radius : {5e-3, 0.5e-3}) {
    Hit hit;
    hit.radius = radius;
    hit.velocity.setZero();
    hit.at =
        Vec3(4e-3, 4e-3, 0.0);    // else it would slide, without friction, off the nearest point
    Lammps lmp;
    hit.start(lmp);
    const double g = 1e5;
    lmp.commands("fix calm2 nodes viscous 1.0\nregion floor block INF INF INF INF INF 1e-6\ngroup "
                 "floor region floor\n"
                 "fix weight ball gravity 1e5 vector 0 0 -1\n"
                 "fix calm ball viscous " +
                 number(hit.mass() * 1e5) + "\nfix hold floor setforce 0 0 0\n");
    lmp.run(8000);
    const Particle ball = ball_of(lmp.particles());
    const double weight = hit.mass() * g;
    EXPECT_LT(ball.f.norm(), 0.01 * weight);
    EXPECT_LT(ball.v.norm(), 0.02);
    EXPECT_NEAR(lmp.value("f_hold[3]") / -weight, 1.0, 0.02);
    EXPECT_GT(lmp.fe(E_CONTACT), 0.0);
    EXPECT_LT(ball.x[2], 2.0 * h + radius);
    EXPECT_GT(ball.x[2], 2.0 * h + 0.9 * radius);
  }
}

TEST(Ball, RestartInContact)
{
  for (const auto &[radius, ghosts] :
       {std::pair(5e-3, std::string()), {0.5e-3, std::string()}, {5e-3, by_type}}) {
    Hit hit;
    hit.radius = radius;
    hit.ghosts = ghosts;
    hit.at = Vec3(4.4e-3, 3.6e-3, 0.0);
    Particles all;
    {
      Lammps lmp;
      hit.start(lmp);
      lmp.command("restart 60 ball.a ball.b");
      lmp.run(60);
      EXPECT_GT(lmp.fe(E_CONTACT), 0.0);
      lmp.run(100);
      all = lmp.particles();
    }
    Lammps lmp;
    lmp.commands(hit.block().header() + "read_restart ball.a\n" + hit.block().fix_only() +
                 hit.motion());
    lmp.run(100);
    EXPECT_LT(difference(all, lmp.particles(), &Particle::x), 1e-14);
    EXPECT_LT(difference(all, lmp.particles(), &Particle::v), 1e-8);
  }
}

// No contact of surfaces: the ball goes through, and nothing happens.
TEST(Ball, GoesThroughWithoutContact)
{
  Hit hit;
  hit.factor = "0";
  Lammps lmp;
  hit.start(lmp);
  lmp.run(200);
  EXPECT_EQ(ball_of(lmp.particles()).v[2], -2.0);
}

// On edges and corners it is felt where it touches, like on a face, and no size of it is special.
TEST(Ball, OnEdgesAndCorners)
{
  const Vec3 edge = Vec3(1.0, 0.0, 1.0).normalized(), corner = Vec3(1.0, 1.0, 1.0).normalized();
  const auto push = [](const Vec3 &foot, const Vec3 &direction, double radius, double depth) {
    Hit hit;
    hit.radius = radius;
    hit.factor = "0.2 overlap ease";
    hit.velocity.setZero();
    hit.at = foot + (radius - depth) * direction - Vec3(0.0, 0.0, radius + 1e-7);
    Lammps lmp;
    hit.start(lmp);
    const Vec3 f = ball_of(lmp.particles()).f;
    EXPECT_GE(f.dot(direction), 0.98 * f.norm());
    return f.norm();
  };
  const double depth = 0.02e-3;
  for (const auto &[foot, direction] :
       {std::pair(Vec3(8e-3, 3.3e-3, 0.0), edge), {Vec3(8e-3, 8e-3, 0.0), corner}}) {
    std::vector<double> forces;
    for (const double radius : {0.5e-3, 1.0e-3, 1.41e-3, 1.42e-3, 2e-3, 3e-3}) {
      EXPECT_EQ(push(foot, direction, radius, -1e-9), 0.0) << radius;
      EXPECT_GT(push(foot, direction, radius, 1e-9), 0.0) << radius;
      forces.push_back(push(foot, direction, radius, depth));
    }
    EXPECT_NEAR(forces[3] / forces[2], 1.0, 0.01);
    // with the depth much smaller than the radius: the plane's R d^3 becomes sqrt(R) d^(5/2), and d^2 on a corner
    for (size_t k = 1; k < forces.size(); k++) EXPECT_GT(forces[k], 0.99 * forces[k - 1]);
  }
}
