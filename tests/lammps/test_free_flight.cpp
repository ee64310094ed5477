// Bodies of finite elements that nothing holds: vibration and rotation conserve energy, linear and
// angular momentum, through periodic boundaries and from rank to rank.
//
// timeout: 240

#include "glass_block.h"

#include <Eigen/Geometry>

#include <cmath>

using namespace defe::test;
using defe::Vec3;

namespace {

const char *const kernels[] = {"kernel auto", "kernel lagrangian"};

/// E - dt^2/8 sum |f|^2/m, see force_term().
double shadow_energy(Lammps &lmp, double dt)
{
  return lmp.fe(TOTAL) - 0.125 * dt * dt * force_term(lmp.particles());
}

}    // namespace

// A beam 60 x 4 x 4 mm in its first free-free bending mode: 160 us, 8 periods (3 of the slower
// kernel). omega dt = 4e-3, so that the energy of velocity Verlet swings by (omega dt)^2/4 = 4e-6
// of itself at most.
TEST(Vibration, BendingKeepsEnergy)
{
  Block block;
  block.n[0] = 30;
  block.n[1] = block.n[2] = 2;
  block.box_lo[0] = -0.01;
  block.box_hi[0] = 0.07;
  block.dt = 1e-7;
  for (const char *kernel : kernels) {
    block.options = kernel;
    Lammps lmp;
    lmp.commands(block.script());
    const double bl = 4.7300407449, sigma = 0.9825022146;
    lmp.change([&](Particle &p) {
      const double z = bl / 0.06 * p.x[0];
      p.v[1] = std::cosh(z) + std::cos(z) - sigma * (std::sinh(z) + std::sin(z));
      // plane sections turn with the axis
      p.v[0] = -(p.x[1] - 0.002) * bl / 0.06 *
          (std::sinh(z) - std::sin(z) - sigma * (std::cosh(z) + std::cos(z)));
    });
    lmp.run(0);
    const Particles start = lmp.particles();
    const double energy = lmp.fe(TOTAL);
    EXPECT_NEAR(energy / kinetic_energy(start), 1.0, 1e-12);
    lmp.record({"f_fe[22]", "f_fe[9]"}, 40);
    lmp.run(kernel == kernels[0] ? 13000 : 5000);
    EXPECT_LT(largest_deviation(lmp.recorded(0)), 1e-5 * energy) << kernel;
    // all of it becomes strain energy, and kinetic energy again
    const auto strain = lmp.recorded(1);
    EXPECT_GT(*std::max_element(strain.begin(), strain.end()), 0.98 * energy);

    // sums of forces and moments vanish to rounding in every step: momenta of 13 000 steps
    const Particles end = lmp.particles();
    double scale = 0.0;
    for (const auto &p : start) scale += p.second.mass * p.second.v.norm();
    EXPECT_LT((momentum(end) - momentum(start)).norm(), 1e-11 * scale) << kernel;
    EXPECT_LT((angular_momentum(end) - angular_momentum(start)).norm(), 1e-11 * scale * 0.06)
        << kernel;
  }
}

// Random velocities excite all modes, up to omega dt = 0.6 where the energy itself swings by 9 %.
// In a linear system velocity Verlet keeps E - dt^2/8 sum |f|^2/m exactly; strains here are 2e-5.
TEST(Vibration, RandomMotionKeepsShadowEnergy)
{
  Block block;
  for (const char *kernel : kernels) {
    block.options = kernel;
    Lammps lmp;
    lmp.commands(block.script());
    lmp.change([](Particle &p) {
      p.v = 0.1 * random_of(p.tag, 1) + Vec3(1.0, 2.0, 3.0);
    });
    lmp.run(0);
    const Particles start = lmp.particles();
    const double rigid = 0.5 * momentum(start).squaredNorm() / total_mass(start);
    const double energy = shadow_energy(lmp, block.dt);
    double largest = 0.0, swing = 0.0;
    for (int k = 0; k < 10; k++) {
      lmp.run(197);
      largest = std::max(largest, std::abs(shadow_energy(lmp, block.dt) - energy));
      swing = std::max(swing, std::abs(lmp.fe(TOTAL) - energy));
    }
    EXPECT_LT(largest, 1e-5 * (energy - rigid)) << kernel;
    EXPECT_GT(swing, 1e-3 * (energy - rigid)) << kernel;    // it is not the energy that is constant
    const Particles end = lmp.particles();
    EXPECT_LT((momentum(end) - momentum(start)).norm(), 1e-12 * momentum(start).norm()) << kernel;
    EXPECT_LT((angular_momentum(end) - angular_momentum(start)).norm(),
              1e-12 * momentum(start).norm() * 0.01)
        << kernel;
  }
}

// 8 turns about the shortest axis, at 300 m/s at the corners: strains of 1e-3, far from small
// rotations. The block flies through the periodic box at the same time.
TEST(Rotation, SpinningBlockKeepsEnergyAndMomenta)
{
  Block block;
  block.boundary = "p p p";
  for (int k = 0; k < 3; k++) {
    block.box_lo[k] = -0.010;
    block.box_hi[k] = 0.020;
  }
  block.dt = 1e-7;
  const double spin = 6e4;
  const int steps = static_cast<int>(std::lround(8 * 2.0 * M_PI / spin / block.dt));
  for (const char *kernel : kernels) {
    block.options = kernel;
    Lammps lmp;
    lmp.commands(block.script());
    const Vec3 c = block.centre(), omega(0.0, 0.0, spin), v(40.0, -25.0, 10.0);
    lmp.change([&](Particle &p) {
      p.v = v + omega.cross(p.x - c);
    });
    lmp.run(0);
    const Particles start = lmp.particles();
    const double energy = lmp.fe(TOTAL);
    lmp.record({"f_fe[22]", "f_fe[9]"}, 50);
    double turned = 0.0, before = 0.0;
    const tagint corner = block.nodes();
    for (int k = 1; k <= 40; k++) {
      lmp.run(steps * k / 40 - steps * (k - 1) / 40);
      const Particles now = lmp.particles();
      const Vec3 d0 = start.at(corner).x - start.at(1).x, d = now.at(corner).x - now.at(1).x;
      const double angle = std::atan2(d0[0] * d[1] - d0[1] * d[0], d0[0] * d[0] + d0[1] * d[1]);
      turned += std::remainder(angle - before, 2.0 * M_PI);
      before = angle;
    }
    const Particles end = lmp.particles();

    // it widens by 1e-3 and turns slower by twice as much
    EXPECT_NEAR(turned / (16.0 * M_PI), 1.0, 5e-3) << kernel;
    double widest = 0.0;
    for (const auto &a : start) {
      const double d0 = (a.second.x - c).norm();
      const double d = (end.at(a.first).x - centre_of_mass(end)).norm();
      widest = std::max(widest, std::abs(d - d0) / d0);
    }
    EXPECT_LT(widest, 5e-3) << kernel;

    // rotation: (omega dt)^2/4 = 1e-5 of the energy; 2e-3 of it is strain energy that swings with
    // periods of some us, (omega dt)^2/4 = 5e-3 of that
    EXPECT_LT(largest_deviation(lmp.recorded(0)), 2e-5 * energy) << kernel;
    // rounding only
    EXPECT_LT((momentum(end) - momentum(start)).norm(), 1e-12 * momentum(start).norm()) << kernel;
    const Vec3 c0 = centre_of_mass(start), c1 = centre_of_mass(end);
    const double l0 = angular_momentum(start, c0).norm();
    EXPECT_LT((angular_momentum(end, c1) - angular_momentum(start, c0)).norm(), 1e-12 * l0)
        << kernel;
    EXPECT_LT((c1 - c0 - steps * block.dt * v).norm(), 1e-12 + 1e-9 * (c1 - c0).norm()) << kernel;
  }
}

// About the middle axis of inertia, a little off: it tumbles over, again and again. The angular
// momentum keeps its direction while the block takes all orientations.
TEST(Rotation, TumblingBlockKeepsTheDirectionOfItsMomentum)
{
  Block block;
  block.dt = 1e-7;
  const Vec3 c = block.centre(), omega(1e3, 3e4, 1e3);
  for (const char *kernel : kernels) {
    block.options = kernel;
    Lammps lmp;
    lmp.commands(block.script());
    lmp.change([&](Particle &p) {
      p.v = omega.cross(p.x - c);
    });
    lmp.run(0);
    const Particles start = lmp.particles();
    const double energy = lmp.fe(TOTAL);
    lmp.record({"f_fe[22]"}, 50);
    double lowest = 1.0;
    for (int k = 0; k < 50; k++) {
      lmp.run(200);
      const Particles now = lmp.particles();
      // the normal of the face y = 0, along the axis of rotation at first
      const Vec3 n = (now.at(block.n[0] + 1).x - now.at(1).x)
                         .cross(now.at((block.n[0] + 1) * (block.n[1] + 1) + 1).x - now.at(1).x)
                         .normalized();
      lowest = std::min(lowest, -n[1]);
    }
    EXPECT_LT(lowest, -0.8) << kernel;    // upside down
    const Particles end = lmp.particles();
    EXPECT_LT(largest_deviation(lmp.recorded(0)), 1e-5 * energy) << kernel;    // as above
    const Vec3 l0 = angular_momentum(start), l1 = angular_momentum(end);
    EXPECT_LT((l1 - l0).norm(), 1e-12 * l0.norm()) << kernel;
    EXPECT_LT((centre_of_mass(end) - c).norm(), 1e-12) << kernel;
  }
}
