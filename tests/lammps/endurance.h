#ifndef DEFE_TEST_ENDURANCE_H
#define DEFE_TEST_ENDURANCE_H

// Long runs: many conversions, many steps. The normal suite runs them short, tests/verification in
// full length.

#include "glass_block.h"
#include "joints.h"

#include <Eigen/Geometry>

#include <cmath>

namespace defe::test {

/// Keywords that every run gets on its line of fix defe (invariant checks, ...).
const std::string endurance_options = "";

/// Sum of mass and momentum, without gathering the particles. In long double: a million equal masses
/// are summed, and rounding adds up.
struct Sums {
  long double mass = 0.0;
  Vec3 p = Vec3::Zero();

  Sums(Lammps &lmp, int type = 0)
  {
    const auto *atom = lmp->atom;
    long double mine[4] = {0.0, 0.0, 0.0, 0.0}, all[4];
    for (int i = 0; i < atom->nlocal; i++) {
      if (type && atom->type[i] != type) continue;
      mine[0] += atom->rmass[i];
      for (int k = 0; k < 3; k++)
        mine[1 + k] += static_cast<long double>(atom->rmass[i]) * atom->v[i][k];
    }
    MPI_Allreduce(mine, all, 4, MPI_LONG_DOUBLE, MPI_SUM, MPI_COMM_WORLD);
    mass = all[0];
    for (int k = 0; k < 3; k++) p[k] = static_cast<double>(all[1 + k]);
  }
};

/// A block of n x n x n elements whose nodes fly apart at random, hit by a rigid plate at 60 m/s.
/// At least `conversions` elements convert within `steps`: no atom is lost, the mass stays as it
/// was, and the block gains the momentum that the plate loses.
inline void shatter(int n, int steps, double conversions)
{
  Block block;
  for (int k = 0; k < 3; k++) {
    block.n[k] = n;
    block.box_lo[k] = -0.004 - (k == 1 ? 0.004 : 0.0);
    block.box_hi[k] = n * block.h + 0.004;
  }
  block.boundary = "s s s";
  block.convert = "5.6e7 type 2 group particles";
  block.coeff = "connective material cohesive 6e7 10.0 0.1 contact 0.9 0.2";
  block.options = "material plate rigid 7800 contact 0.2 " + endurance_options;
  block.dt = 6e-8;
  std::string box = block.box();
  box.replace(box.find("create_box 2"), 12, "create_box 3");
  const double edge = n * block.h;
  Lammps lmp;
  lmp.commands(block.header() + box + block.fix() + block.mesh() + "create_hexes fe plate 3 x " +
               number(0.25 * edge) + " 4 " + number(0.75 * edge) + " y -0.00401 1 -0.00001 z " +
               number(0.25 * edge) + " 4 " + number(0.75 * edge) + "\n" + block.motion() +
               "group plate type 3\nfix ram plate rigid/nve single\n" +
               "neigh_modify binsize 0.002\nthermo 10\nthermo_modify lost error flush yes\n"
               "thermo_style custom step atoms f_fe[2] f_fe[4] f_fe[5] f_fe[6] f_fe[22]\n");
  lmp.change([&](Particle &p) {
    p.v = p.type == 3 ? Vec3(0.0, 60.0, 0.0) : Vec3(12.0 * random_of(p.tag, 21));
  });
  lmp.run(0);
  const Sums first(lmp), plate_first(lmp, 3);
  const double hexes = lmp.fe(ELEMENTS);
  EXPECT_EQ(hexes, static_cast<double>(n) * n * n + 16.0);
  EXPECT_NEAR(static_cast<double>(first.mass) / (block.mass() + 7800 * 0.25 * edge * edge * 0.004),
              1.0, 1e-12);

  lmp.run(steps);
  const Sums last(lmp), plate_last(lmp, 3);
  const double converted = lmp.fe(CONVERTED);
  const Vec3 impulse = plate_first.p - plate_last.p;
  const double mass_change = static_cast<double>(last.mass / first.mass - 1.0L);
  if (rank_of(MPI_COMM_WORLD) == 0)
    std::printf("%.0f of %.0f elements converted, %.0f joints softening, %.0f broken; mass %.1e, "
                "impulse %.4g N s, momentum %.1e of it\n",
                converted, hexes, lmp.fe(COHESIVE), lmp.fe(CONTACT), mass_change, impulse.norm(),
                (last.p - first.p).norm() / impulse.norm());
  EXPECT_GE(converted, conversions);
  EXPECT_EQ(lmp.fe(DES), 8.0 * converted);
  EXPECT_EQ(lmp.fe(ELEMENTS), hexes - converted);
  // every DE is there, and every node that still has elements
  bigint mine[2] = {0, 0}, all[2];
  const auto &store = defe_system(lmp).store;
  for (int i = 0; i < lmp->atom->nlocal; i++) {
    mine[0] += store.de(i) != nullptr;
    mine[1] += store.de(i) == nullptr && store.elements_at(i) == 0;
  }
  MPI_Allreduce(mine, all, 2, MPI_LMP_BIGINT, MPI_SUM, MPI_COMM_WORLD);
  EXPECT_EQ(static_cast<double>(all[0]), lmp.fe(DES));
  EXPECT_EQ(all[1], 0) << "nodes without elements are left";
  EXPECT_NEAR(mass_change, 0.0, 1e-12);
  EXPECT_GT(impulse.norm(), 1e-3 * plate_first.p.norm()) << "a poor example";
  EXPECT_LT((last.p - first.p).norm(), 1e-10 * impulse.norm());
}

/// A fragment of 2 x 2 x 4 DEs (two converted elements) that tumbles, alone in a periodic box. It
/// starts without strain, and so vibrates for ever: nothing damps it.
inline void tumble(bigint steps, MPI_Comm comm = MPI_COMM_WORLD)
{
  Block block;
  block.n[0] = 2;
  block.n[1] = block.n[2] = 1;
  block.boundary = "p p p";
  for (int k = 0; k < 3; k++) {
    block.box_lo[k] = -0.012;
    block.box_hi[k] = 0.012;
  }
  block.convert += " start all";
  block.options = endurance_options;
  Lammps lmp(comm);
  lmp.commands(block.script() + "thermo_style custom step\nthermo 0\n");
  lmp.run(0);
  const Particles begin = lmp.particles();
  const Vec3 omega(1e4, 4e4, 1e4), v(5.0, -3.0, 2.0), c = block.centre();
  lmp.change([&](Particle &p) {
    p.v = v + omega.cross(begin.at(p.tag).x - c);
    p.omega = omega;
  });
  lmp.run(0);
  const Particles first = lmp.particles();
  const double energy = lmp.fe(TOTAL);
  const Vec3 l = angular_momentum(first, c);
  const Joints bonds = joints(lmp);
  ASSERT_EQ(bonds.size(), 2u * (4u * 3u + 2u * 8u));    // each from both sides

  // lengths of the joints in the first and in the last tenth of the time, means over 200 moments
  // that do not follow the vibration
  struct Window {
    std::map<std::pair<tagint, int>, double> mean;
    double longest = 0.0;
  } window[2];
  bigint done = 0;
  double drift = 0.0, swing = 0.0;
  for (int part = 0; part < 2; part++) {
    for (int k = 1; k <= 200; k++) {
      const bigint until = part * (steps - steps / 10) + k * (steps / 10) / 200 - k % 3 * 7;
      lmp.run(until - done);
      done = until;
      const Particles now = lmp.particles();
      for (const auto &b : bonds) {
        const double length = (now.at(b.second.other).x - now.at(b.second.self).x).norm();
        window[part].mean[b.first] += length / 200;
        window[part].longest = std::max(window[part].longest, std::abs(length / 1e-3 - 1.0));
      }
      swing = std::max(swing, std::abs(lmp.fe(TOTAL) / energy - 1.0));
    }
  }
  for (const auto &m : window[0].mean)
    drift = std::max(drift, std::abs(m.second - window[1].mean.at(m.first)) / 1e-3);
  const Particles last = lmp.particles();
  const Vec3 centre = centre_of_mass(last);
  if (rank_of(MPI_COMM_WORLD) == 0)
    std::printf("%lld steps, %.0f turns: energy within %.1e, joints within %.1e at first and %.1e "
                "at last, their means move by %.1e; angular momentum %.1e, centre %.1e m\n",
                static_cast<long long>(done), done * block.dt * omega.norm() / (2.0 * M_PI), swing,
                window[0].longest, window[1].longest, drift,
                (angular_momentum(last, centre) - l).norm() / l.norm(),
                (centre - c - done * block.dt * v).norm());
  EXPECT_EQ(joints(lmp).size(), bonds.size());
  EXPECT_LT(swing, 1e-4);
  EXPECT_LT(window[0].longest, 1e-3);
  EXPECT_LT(window[1].longest, 1e-3);
  EXPECT_LT(drift, 3e-5);
  EXPECT_LT((angular_momentum(last, centre) - l).norm(), 1e-9 * l.norm());
  EXPECT_LT((centre - c - done * block.dt * v).norm(), 1e-10);
}

}    // namespace defe::test

#endif
