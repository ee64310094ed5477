// Contacts that remember something are the same on any ranks and over a restart in their middle: overlaps that
// are eased out, DEs that took over the contact of a ball, bodies of one part.
//
// timeout: 240

#include "contact_scene.h"

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
  list.push_back({"takeover", ball_on_bar(0.1, 60.0, 5e-8), {}, 250, 150, true});
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
