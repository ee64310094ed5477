// Contact of two spheres: restitution, friction, rotation, energy. A ball on a round patch.

#include "sphere_pair.h"

#include "defe/coupling/penalty.h"

#include <stdexcept>

using namespace defe;

namespace {

using Pair = test::SpherePair;

double period(const ContactParameters &p, double reduced)
{
  return 2.0 * std::acos(-1.0) / std::sqrt(p.kn / reduced);
}

}    // namespace

TEST(Contact, DampingRatio)
{
  EXPECT_EQ(damping_ratio(1.0), 0.0);
  EXPECT_NEAR(damping_ratio(std::exp(-2.0)), 1.0, 1e-6);
  EXPECT_NEAR(damping_ratio(1e-4), 0.5 / std::sqrt(1e-4), 0.5);
  // slightly damped: the usual formula e = exp(-pi zeta)
  EXPECT_NEAR(damping_ratio(0.99), -std::log(0.99) / std::acos(-1.0), 1e-4);
  double last = -1.0;
  for (double e = 1.0; e > 1e-4; e *= 0.97) {
    EXPECT_GT(damping_ratio(e), last);
    last = damping_ratio(e);
  }
}

TEST(Contact, ParametersAreChecked)
{
  EXPECT_NO_THROW(contact_parameters(1.0, 0.0, 1.0, 0.0));
  EXPECT_THROW(contact_parameters(0.0, 1.0, 0.5, 0.1), std::invalid_argument);
  EXPECT_THROW(contact_parameters(1.0, -1.0, 0.5, 0.1), std::invalid_argument);
  EXPECT_THROW(contact_parameters(1.0, 1.0, 0.0, 0.1), std::invalid_argument);
  EXPECT_THROW(contact_parameters(1.0, 1.0, 1.1, 0.1), std::invalid_argument);
  EXPECT_THROW(contact_parameters(1.0, 1.0, 0.5, -0.1), std::invalid_argument);
  EXPECT_THROW(contact_parameters(1.0, 1.0, std::nan(""), 0.1), std::invalid_argument);
}

TEST(Contact, MeasuredRestitution)
{
  for (double e : {1.0, 0.95, 0.9, 0.7, 0.5, 0.3, 0.135, 0.1, 0.05}) {
    Pair pair(contact_parameters(1e6, 0.0, e, 0.0));
    pair.mj = 5.0;
    pair.xi = Vec3(2.0 * (1.0 + 1e-9), 0.0, 0.0);
    pair.vi = Vec3(-3.0, 0.0, 0.0);
    pair.vj = Vec3(1.0, 0.0, 0.0);
    const double dt = period(pair.p, pair.reduced()) / 20000.0 * (e < 0.2 ? 0.2 : 1.0);
    const double before = pair.kinetic();
    pair.collide_until_no_force(dt);
    EXPECT_NEAR((pair.vi - pair.vj)[0], 4.0 * e, 4.0 * 2e-3 * e) << e;
    EXPECT_NEAR(pair.momentum()[0], -2.0 * 3.0 + 5.0 * 1.0, 1e-12);
    EXPECT_NEAR(pair.kinetic() + pair.damped + pair.r.stored, before, 2e-3 * before);
  }
  // the damping ratio is found from e if nobody has filled it in
  Pair pair({1e6, 0.0, 0.5, 0.0});
  pair.xi = Vec3(2.0, 0.0, 0.0);
  pair.vi = Vec3(-1.0, 0.0, 0.0);
  pair.collide(period(pair.p, pair.reduced()) / 20000.0);
  EXPECT_NEAR((pair.vi - pair.vj)[0], 0.5, 2e-3);
}

TEST(Contact, ForceIsTheSpringsAndNothingPulls)
{
  const ContactParameters p = contact_parameters(1e6, 1e6, 0.5, 0.3);
  TangentialSpring history{};
  const Vec3 none = Vec3::Zero();
  // contact distance less than the sum of the radii
  ContactResult r =
      sphere_contact(Vec3(0.0, 1.9, 0.0), none, none, none, 1.0, 1.2, 2.0, 1.0, 1e-6, history, p);
  EXPECT_NEAR(r.overlap, 0.1, 1e-15);
  EXPECT_LT((r.force - Vec3(0.0, 1e5, 0.0)).norm(), 1e-8);
  EXPECT_NEAR(r.stored, 0.5 * 1e6 * 0.01, 1e-9);
  EXPECT_EQ(r.torque_i, none);
  // leaving so fast that the dashpot would pull
  r = sphere_contact(Vec3(0.0, 1.9, 0.0), Vec3(0.0, 1e4, 0.0), none, none, 1.0, 1.2, 2.0, 1.0, 1e-6,
                     history, p);
  EXPECT_EQ(r.force, none);
  EXPECT_GT(r.damped, 0.0);
  // apart
  history = {{1.0, 0.0, 0.0}, 1e3};
  r = sphere_contact(Vec3(0.0, 2.1, 0.0), none, none, none, 1.0, 1.2, 2.0, 1.0, 1e-6, history, p);
  EXPECT_LT(r.overlap, 0.0);
  EXPECT_EQ(r.force, none);
  EXPECT_EQ(r.rubbed, 0.5);
  EXPECT_EQ(history.stored(), 0.0);
}

// A constant normal load, the other sphere dragged past slowly: stick up to mu F_n, then slip, and
// back after the direction is reversed.
TEST(Contact, CoulombSlip)
{
  const ContactParameters p = contact_parameters(1e6, 5e5, 1.0, 0.3);
  const Vec3 none = Vec3::Zero(), from_j(0.0, 0.0, 1.9);
  const double F_n = 1e6 * 0.1, speed = 0.2, dt = 1e-3;
  TangentialSpring history{};
  double displacement = 0.0, work = 0.0, rubbed = 0.0, stored = 0.0, force = 0.0;
  const double limit = p.friction * F_n;
  for (int k = 0; k < 1000; ++k) {
    const double v = k < 600 ? speed : -speed;
    const double before = force;
    const ContactResult r =
        sphere_contact(from_j, Vec3(v, 0.0, 0.0), none, none, 1.0, 1.0, 2.0, 1.0, dt, history, p);
    displacement += v * dt;
    force = r.force[0];
    work -= 0.5 * (force + before) * v * dt;
    rubbed += r.rubbed;
    stored = r.stored - 0.5 * 1e6 * 0.01;
    if (k < 600) {
      EXPECT_NEAR(force, -std::min(5e5 * displacement, limit), 1e-8);
      EXPECT_EQ(r.slipping, 5e5 * displacement > limit * (1.0 + 1e-12));
    }
    EXPECT_LE(std::abs(force), limit * (1.0 + 1e-12));
    EXPECT_GE(r.rubbed, 0.0);
    // torques of both: the same sense, half the distance each
    EXPECT_LT((r.torque_i - r.torque_j).norm(), 1e-8);
    EXPECT_NEAR(r.torque_i[1], -0.95 * force, 1e-8);
    EXPECT_NEAR(work, stored + rubbed, 1e-10 * (1.0 + work));
  }
  EXPECT_NEAR(rubbed, limit * (600 * speed * dt - limit / 5e5), 1e-6);
}

// Sphere on a heavy body with gross sliding, at the angle theta from the normal: tangential
// restitution 1 - mu (1 + e) cot theta, spin 5/2 of the change over the radius.
TEST(Contact, ObliqueImpactWithGrossSliding)
{
  for (double e : {1.0, 0.8, 0.5})
    for (double mu : {0.05, 0.092}) {
      const double theta = 1.2, speed = 4.0;
      Pair pair(contact_parameters(1e7, 1e7, e, mu));
      pair.mj = 1e12;
      pair.xi = Vec3(0.0, 0.0, 2.0 * (1.0 + 1e-9));
      pair.vi = speed * Vec3(std::sin(theta), 0.0, -std::cos(theta));
      const double before = pair.vi[0];
      // The contact should not move along the sphere j: large and flat.
      pair.rj = 1e6;
      pair.distance = pair.ri + pair.rj;
      pair.xj = Vec3(0.0, 0.0, pair.xi[2] - pair.distance * (1.0 + 1e-12));
      pair.collide(period(pair.p, pair.reduced()) / 20000.0);
      const double expected = 1.0 - mu * (1.0 + e) / std::tan(theta);
      EXPECT_NEAR(pair.vi[0] / before, expected, 1e-3) << "e " << e << " mu " << mu;
      EXPECT_NEAR(pair.wi[1] * pair.ri, 2.5 * before * (1.0 - expected), 4e-3 * before);
    }
}

// A pair that turns as a rigid body about any axis neither slips nor loses its tangential force.
TEST(Contact, PairThatRotatesAsARigidBody)
{
  const ContactParameters p = contact_parameters(1e6, 1e6, 0.5, 10.0);
  for (const Vec3 &axis : {Vec3(0, 0, 1), Vec3(1, 0, 0), Vec3(0, 1, 0), Vec3(1, 2, -1)}) {
    const Vec3 omega = 3.0 * axis.normalized();
    const double dt = 1e-4;
    TangentialSpring history{{0.0, 10.0, 5.0}, 1e3};
    const Vec3 x0(1.9, 0.0, 0.0), h0(history.s);
    Mat3 R = Mat3::Identity();
    ContactResult r;
    for (int k = 1; k <= 10000; ++k) {
      R = Eigen::AngleAxisd(omega.norm() * dt * k, omega.normalized()).toRotationMatrix();
      const Vec3 x = R * x0;
      r = sphere_contact(x, omega.cross(x), omega, omega, 0.8, 1.2, 2.0, 1.0, dt, history, p);
    }
    EXPECT_FALSE(r.slipping);
    EXPECT_NEAR(r.damped, 0.0, 1e-12);
    EXPECT_NEAR(Vec3(history.s).norm(), h0.norm(), 1e-9 * h0.norm());
    EXPECT_LT((Vec3(history.s) - R * h0).norm(),
              2e-3 * h0.norm());    // first order in dt about the normal
  }
}

// Any collision: linear and angular momentum to rounding, energy within the integrator's error.
TEST(Contact, MomentumAndEnergyOfACollision)
{
  Pair pair(contact_parameters(1e6, 8e5, 0.6, 0.4));
  pair.ri = 0.7;
  pair.rj = 1.1;
  pair.distance = 1.75;    // spheres that overlap in the reference state
  pair.mj = 7.0;
  pair.xi = Vec3(1.0, 1.0, 1.0).normalized() * 1.76;
  pair.vi = Vec3(-2.0, -1.0, 0.5);
  pair.vj = Vec3(1.0, 0.5, 0.7);
  pair.wi = Vec3(3.0, -2.0, 1.0);
  pair.wj = Vec3(-1.0, 4.0, 2.0);
  const Vec3 momentum = pair.momentum(), angular = pair.angular_momentum();
  const double energy = pair.kinetic();
  pair.collide(period(pair.p, pair.reduced()) / 50000.0);
  EXPECT_LT((pair.momentum() - momentum).norm(), 1e-10);
  EXPECT_LT((pair.angular_momentum() - angular).norm(), 1e-9);
  EXPECT_NEAR(pair.kinetic() + pair.damped + pair.rubbed, energy, 2e-3 * energy);
  EXPECT_GT(pair.damped, 0.0);
  EXPECT_GT(pair.rubbed, 0.0);
}

// The penalty pressure over the patch, by a fine sum; disc of contact smaller and larger than the patch.
TEST(BallOnPatch, IsThePressureOverItsArea)
{
  const double R = 3.0, A = 0.5, k_A = 7.0, pi = std::acos(-1.0);
  const double covered = A / (2.0 * pi * R);
  for (double overlap : {0.1 * covered, 0.9 * covered, 1.1 * covered, 20.0 * covered}) {
    double energy = 0.0, force = 0.0;
    const int n = 100000;
    for (int k = 0; k < n; ++k) {
      // rings of equal areas: s^2 = A/pi (k + 1/2)/n
      const double depth = overlap - A / pi * (k + 0.5) / n / (2.0 * R);
      if (depth <= 0.0) break;
      force += k_A * A / n * depth;
      energy += 0.5 * k_A * A / n * depth * depth;
    }
    const BallOnPatch at = ball_on_patch(overlap, R, A, k_A);
    EXPECT_NEAR(at.energy / energy, 1.0, 1e-8);
    EXPECT_NEAR(at.force / force, 1.0, 1e-8);
    EXPECT_NEAR(overlap_of_energy(at.energy, R, A, k_A) / overlap, 1.0, 1e-12);
  }
  EXPECT_EQ(ball_on_patch(0.0, R, A, k_A).force, 0.0);
  EXPECT_EQ(ball_on_patch(-1.0, R, A, k_A).energy, 0.0);
  EXPECT_EQ(overlap_of_energy(0.0, R, A, k_A), 0.0);
}

// A ball on a patch: the force is the derivative of the energy, the overlap is found back from it, and
// it has both limits, the cap of a plane and a spring of the patch's area.
TEST(BallOnPatch, EnergyForceAndOverlap)
{
  const double R = 5e-3, A = 1e-6, k = 4e12, whole = A / (2.0 * M_PI * R);
  for (double o : {0.01 * whole, 0.5 * whole, 2.0 * whole, 50.0 * whole}) {
    const BallOnPatch at = ball_on_patch(o, R, A, k);
    const double step = 1e-5 * o;
    const BallOnPatch plus = ball_on_patch(o + step, R, A, k),
                      minus = ball_on_patch(o - step, R, A, k);
    EXPECT_NEAR((plus.energy - minus.energy) / (2.0 * step) / at.force, 1.0, 1e-8);
    EXPECT_NEAR((plus.force - minus.force) / (2.0 * step) / at.slope, 1.0, 1e-8);
    EXPECT_NEAR(overlap_of_energy(at.energy, R, A, k) / o, 1.0, 1e-10);
    if (o < whole) { EXPECT_NEAR(at.force / (M_PI * k * R * o * o), 1.0, 1e-12); }
  }
  EXPECT_NEAR(ball_on_patch(50.0 * whole, R, A, k).slope / (k * A), 1.0, 1e-12);
  EXPECT_EQ(overlap_of_energy(0.0, R, A, k), 0.0);
  EXPECT_EQ(ball_on_patch(-1e-6, R, A, k).force, 0.0);
}

// Restitution of a ball that falls on a patch, soft (a cap) and hard (a spring).
TEST(BallOnPatch, Restitution)
{
  const double R = 5e-3, A = 1e-6, k = 4e12, m = 1e-6;
  for (double e : {0.3, 0.6, 0.9})
    for (double v0 : {0.01, 1.0, 100.0}) {
      double o = 0.0, v = v0;
      const double dt = 1e-3 * std::sqrt(m / (k * A)) * std::max(1.0, std::cbrt(1.0 / v0));
      for (int i = 0; i < 10000000; ++i) {
        const BallOnPatch at = ball_on_patch(o, R, A, k);
        const double kn = o > 0.0 ? at.force / o : 0.0;
        const double c = 2.0 * damping_ratio(e) * at.damping_factor * std::sqrt(kn * m);
        const double push = std::max(0.0, at.force + c * v);
        v -= dt * push / m;
        o += dt * v;
        if (v < 0.0 && push == 0.0) break;
      }
      EXPECT_NEAR(-v / v0, e, 0.02) << v0;
    }
}
