// Contacts that remember something are the same on any ranks and over a restart in their middle: overlaps that
// are eased out, DEs that took over the contact of a ball, bodies of one part. And what is said, once and by
// one rank for all.
//
// timeout: 240

#include "contact_scene.h"

#include <gmock/gmock.h>

#include <cmath>

using namespace defe::test;
using defe::Vec3;

namespace {

/// Cases with something to remember in the middle of a contact, and steps to that middle.
struct Remembers {
  std::string what;
  Scene scene;
  std::function<Vec3(const Particle &)> velocity;
  int before, after;
  bool ball;
};

std::vector<Remembers> remembers()
{
  std::vector<Remembers> list;
  {
    Scene s;    // offsets that are being eased out, in bodies that rotate and rub
    s.dt = 1e-7;
    s.contact = "contact 0.2 friction 0.2";
    for (int side : {-1, 1})
      s.add(side < 0 ? "glass" : "pane", side < 0 ? 1 : 2, {4, 2, 2}, 2e-3, [&](const Vec3 &X) {
        return Vec3(X + side * Vec3(4e-3 - 2e-5, 3e-4, 2e-4));
      });
    list.push_back({"overlap", s,
                    [](const Particle &p) {
                      return p.type == 1 ? Vec3(3.0, 0.5, 0.0) : Vec3(-3.0, 0.0, 0.7);
                    },
                    40, 200, false});
  }
  list.push_back({"takeover", ball_on_bar(0.1, 60.0, 5e-8, "lattice"), {}, 250, 150, true});
  {
    Scene s;    // DEs and elements of one part
    s.dt = 2e-8;
    s.contact = "contact 0.2 friction 0.3";
    s.coeff = "connective material cohesive 1e12 1e6 0.1 contact 0.9 0.3";
    s.regions = "region left block INF 0 INF INF INF INF";
    s.convert = "convert glass 1e12 type 4 group particles start left";
    s.add("glass", 1, {2, 2, 2}, 2e-3, [](const Vec3 &X) {
      return Vec3(turn(0.3, Vec3(1, 1, 1)) * X - Vec3(2.75e-3, 0.0, 0.0));
    });
    s.add("glass", 2, {3, 3, 3}, 2e-3, [](const Vec3 &X) {
      return Vec3(X + Vec3(3.1e-3, 0.3e-3, 0.4e-3));
    });
    s.add("glass", 2, {2, 2, 2}, 2e-3, [](const Vec3 &X) {
      return Vec3(turn(0.4, Vec3(1, 0, 1)) * X + Vec3(9.3e-3, 0.9e-3, -0.4e-3));
    });
    list.push_back({"one part", s,
                    [](const Particle &p) {
                      return Vec3(p.type == 4 ? 30.0 : p.x[0] > 6.1e-3 ? -40.0 : 0.0, 0.0, 1.0);
                    },
                    900, 500, false});
  }
  return list;
}

void begin(Lammps &lmp, const Remembers &r, MPI_Comm comm, const std::string &file)
{
  r.scene.start(lmp, comm, file);
  lmp.run(0);
  if (r.velocity)
    lmp.change([&](Particle &p) {
      p.v = r.velocity(p);
    });
}

}    // namespace

TEST(SameResult, OnAnyRanks)
{
  for (const auto &r : remembers()) {
    SCOPED_TRACE(r.what);
    const Particles one = on_one_rank([&] {
      Lammps lmp(MPI_COMM_SELF);
      begin(lmp, r, MPI_COMM_SELF, "one_rank.data");
      lmp.run(r.before + r.after);
      return lmp.particles();
    });
    Lammps lmp;
    begin(lmp, r, MPI_COMM_WORLD, "all_ranks.data");
    lmp.run(r.before + r.after);
    const Particles all = lmp.particles();
    EXPECT_LT(difference(one, all, &Particle::x), 1e-13);
    EXPECT_LT(difference(one, all, &Particle::v), 1e-9 * largest(one, &Particle::v));
  }
}

TEST(SameResult, OverARestartInContact)
{
  for (const auto &r : remembers()) {
    SCOPED_TRACE(r.what);
    Particles through;
    std::vector<double> ledger;
    const auto account = [](Lammps &lmp) {
      std::vector<double> a;
      for (const Entry e : {CONVERTED, E_CONTACT, FRICTION, EXTERNAL, TOTAL, BALANCE})
        a.push_back(lmp.fe(e));
      return a;
    };
    double converted = 0.0;
    {
      Lammps lmp;
      begin(lmp, r, MPI_COMM_WORLD, "restarted.data");
      lmp.command("restart " + std::to_string(r.before) + " contact.a contact.b");
      lmp.run(r.before);
      EXPECT_GT(lmp.fe(E_CONTACT), 0.0);
      converted = lmp.fe(CONVERTED);
      lmp.command("restart 0");
      lmp.run(r.after);
      through = lmp.particles();
      ledger = account(lmp);
    }
    if (r.ball) {
      EXPECT_GT(converted, 0.0);
      EXPECT_GT(ledger[0], converted) << "some are to convert afterwards, too";
    }
    Lammps lmp;
    lmp.commands(Scene::header() + "read_restart contact.a\n" + r.scene.regions + "\n" +
                 r.scene.fix_only() + r.scene.motion());
    if (r.ball) lmp.command("fix move3 ball nve/sphere");
    lmp.run(r.after);
    const Particles again = lmp.particles();
    EXPECT_LT(difference(through, again, &Particle::x), 1e-14);
    EXPECT_LT(difference(through, again, &Particle::v), 1e-10 * largest(through, &Particle::v));
    const auto now = account(lmp);
    for (size_t k = 0; k < now.size(); k++)
      EXPECT_NEAR(now[k], ledger[k], 1e-12 * (std::abs(ledger[k]) + std::abs(ledger[4]))) << k;
  }
}

// ---- what is said ----

// by the word of the user
TEST(Overlap, IsRefused)
{
  Scene s;
  s.contact = "contact 0.2 overlap refuse";
  for (int side : {-1, 1})
    s.add(side < 0 ? "glass" : "pane", side < 0 ? 1 : 2, {4, 2, 2}, 2e-3, [&](const Vec3 &X) {
      return Vec3(X + side * Vec3(4e-3 - 5e-6, 0.0, 0.0));
    });
  Lammps lmp;
  s.start(lmp);
  try {
    lmp.run(0);
    ADD_FAILURE() << "nothing was refused";
  } catch (LAMMPS_NS::LAMMPSException &e) {
    EXPECT_THAT(
        e.what(),
        testing::HasSubstr("18 contacts overlap before the first step, the deepest by 1e-05 "
                           "(atom 5): move the bodies apart"));
  }
}

// A ball has no memory by which it could be eased out: it is named, in the face and with its centre behind it, and
// refused if it is deep and nobody asks for 'overlap ease'.
TEST(Overlap, BallIsNamed)
{
  for (const double deep : {2e-5, 1e-4, 2e-3, 4.5e-3})
    for (const std::string how : {"", " overlap ease", " overlap refuse"}) {
      SCOPED_TRACE(number(deep) + how);
      const bool refuse = how == " overlap refuse" || (how.empty() && deep > 4e-5);
      Scene s;
      s.contact += how;
      s.add("glass", 1, {4, 4, 4}, 2e-3, [](const Vec3 &X) {
        return X;
      });
      s.more = "create_atoms 3 single 0.0003 " + number(8e-3 - deep) +
          " 0.0002\nset type 3 diameter 0.008 density 7800\ngroup ball type 3\nfix move3 ball "
          "nve/sphere\n";
      Lammps lmp;
      WarningLog log(lmp, "ball.txt");
      s.start(lmp);
      const std::string said = "Contact of fix defe: ball 126 begins " +
          std::string(deep == 2e-5       ? "2e-05"
                          : deep == 1e-4 ? "0.0001"
                          : deep == 2e-3 ? "0.002"
                                         : "0.004") +
          " deep in a face";
      if (refuse) {
        try {
          lmp.run(0);
          ADD_FAILURE() << "nothing was refused";
        } catch (LAMMPS_NS::LAMMPSException &e) {
          EXPECT_THAT(e.what(), testing::HasSubstr(said));
          EXPECT_THAT(e.what(), testing::HasSubstr("move it out"));
          if (how.empty()) {
            EXPECT_THAT(e.what(), testing::HasSubstr("'contact 0.2 overlap ease'"));
          }
        }
        continue;
      }
      lmp.run(0);
      lmp.run(0);
      int named = 0;
      for (const auto &line : log.warnings()) named += line.compare(0, said.size(), said) == 0;
      EXPECT_EQ(named, 1);
    }
}

// A ball that nothing can stop goes through: named once, with step and place, and counted; what that costs,
// and what it gets as it leaves, is in entry 30, and so the total stays.
TEST(LetThrough, FastBallIsNamedOnceAndItsEnergyBooked)
{
  Scene s;
  s.dt = 2e-10;    // with 1e-9 the energy is off by 4e-6 as it passes the face
  s.add("glass", 1, {4, 3, 3}, 2e-3, [](const Vec3 &X) {
    return X;
  });
  s.more = "create_atoms 3 single 0.0003 0.0041 0.0002\nset type 3 diameter 0.002 density 7800\n"
           "group ball type 3\nfix move3 ball nve/sphere\nvelocity ball set 0 -2000 0\n";
  Lammps lmp;
  WarningLog log(lmp, "fast.txt");
  s.start(lmp);
  const Flight f = fly(lmp, 33000);
  EXPECT_EQ(f.through, 1.0);
  EXPECT_GT(f.contact, 0.01);
  EXPECT_EQ(f.left, 0.0);
  EXPECT_LT(velocity_of(f.end, 3)[1], -1900.0);
  EXPECT_LT(f.deviation, 1e-6);
  EXPECT_LT(std::abs(lmp.value("f_fe[30]")), 1e-4 * f.energy0);    // on the way: 0.016
  int named = 0;
  for (const auto &line : log.warnings())
    if (line.find("is let through") != std::string::npos) {
      named++;
      EXPECT_THAT(line,
                  testing::StartsWith("Contact of fix defe: atom 81 got 0.001 deep at step 2764 "
                                      "near 0.000299989 0.00299717 0.000199935"));
    }
  EXPECT_EQ(named, 1);
}
