#ifndef DEFE_TEST_SPHERE_PAIR_H
#define DEFE_TEST_SPHERE_PAIR_H

// Two spheres in contact, integrated by velocity Verlet.

#include "defe/coupling/contact_law.h"
#include "defe/coupling/normal_law.h"

#include <Eigen/Geometry>
#include <gtest/gtest.h>

#include <cmath>
#include <functional>

namespace defe::test {

struct SpherePair {
  double ri = 1.0, rj = 1.0, mi = 2.0, mj = 2.0;
  double distance = 2.0;    // at contact
  Vec3 xi = Vec3::Zero(), xj = Vec3::Zero(), vi = Vec3::Zero(), vj = Vec3::Zero();
  Vec3 wi = Vec3::Zero(), wj = Vec3::Zero();
  TangentialSpring history{};
  double damped = 0.0, rubbed = 0.0;
  ContactResult r;
  ContactParameters p;
  std::function<NormalSpring(double overlap)> spring;    // instead of the stiffnesses of p

  explicit SpherePair(const ContactParameters &p) : p(p) {}

  double reduced() const { return mi * mj / (mi + mj); }
  double inertia_i() const { return 0.4 * mi * ri * ri; }
  double inertia_j() const { return 0.4 * mj * rj * rj; }

  void evaluate(double dt)
  {
    const double overlap = distance - (xi - xj).norm();
    NormalSpring s{};
    ContactParameters now = p;
    if (spring && overlap > 0.0) {
      s = spring(overlap);
      now = {s.kn, s.kt, p.restitution, p.friction, s.damping_factor * p.damping_ratio};
    }
    r = sphere_contact(xi - xj, vi - vj, wi, wj, ri, rj, distance, reduced(), dt, history, now);
    if (spring && overlap > 0.0) r.stored += s.energy_beyond(overlap);
    damped += r.damped;
    rubbed += r.rubbed;
  }
  void kick(double dt)
  {
    vi += 0.5 * dt / mi * r.force;
    vj -= 0.5 * dt / mj * r.force;
    wi += 0.5 * dt / inertia_i() * r.torque_i;
    wj += 0.5 * dt / inertia_j() * r.torque_j;
  }
  void step(double dt)
  {
    kick(dt);
    xi += dt * vi;
    xj += dt * vj;
    evaluate(dt);
    kick(dt);
  }
  /// Until they have touched and come apart; the steps in which they did.
  int collide(double dt)
  {
    evaluate(0.0);
    int steps = 0;
    for (int k = 0; k < 10000000; ++k) {
      step(dt);
      if (r.overlap > 0.0)
        ++steps;
      else if (steps)
        return steps;
    }
    ADD_FAILURE() << "the spheres never came apart";
    return steps;
  }
  /// Until the force has come and gone, which with damping is before the overlap does. It never pulls.
  void collide_until_no_force(double dt)
  {
    evaluate(0.0);
    bool pressed = false;
    for (int k = 0; k < 10000000; ++k) {
      step(dt);
      const double push = r.force.dot((xi - xj).normalized());
      EXPECT_GE(push, 0.0);
      if (push > 0.0) pressed = true;
      if (pressed && push == 0.0) return;
    }
    ADD_FAILURE() << "the force never ended";
  }
  double kinetic() const
  {
    return 0.5 *
        (mi * vi.squaredNorm() + mj * vj.squaredNorm() + inertia_i() * wi.squaredNorm() +
         inertia_j() * wj.squaredNorm());
  }
  Vec3 momentum() const { return mi * vi + mj * vj; }
  Vec3 angular_momentum() const
  {
    return mi * xi.cross(vi) + mj * xj.cross(vj) + inertia_i() * wi + inertia_j() * wj;
  }
};

}    // namespace defe::test

#endif
