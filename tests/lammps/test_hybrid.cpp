// Other particles beside the glass: pair_style hybrid with granular and bonded spheres.
//
// timeout: 240

#include "glass_block.h"

#include "defe/coupling/penalty.h"

#include "pair.h"

#include <cmath>
#include <sstream>

using namespace defe::test;
using defe::Vec3;

namespace {

constexpr double h = 2e-3, dt = 5e-8;
constexpr double pi = 3.14159265358979323846;
constexpr double spring = 5e6, gamma_n = 2e4;    // of gran/hooke: N/m and 1/s

/// Sphere of type 3: grain.
struct Grain {
  Vec3 x, v;
  double radius = 2e-3;
  double mass() const { return 4.0 / 3.0 * pi * radius * radius * radius * 2500.0; }
};

/// LAMMPS numbers its pair styles, and with them the fixes that hold their contact histories, through
/// the whole life of a process: a second LAMMPS would not find them in the restart file of the first.
struct FreshPairNumbers : LAMMPS_NS::Pair {
  static void begin() { instance_total = 0; }
};

/// A block of n elements along each edge at the origin, DEs of type 4, beside grains of type 3.
struct Scene {
  int n[3] = {1, 1, 1};
  std::string start = "no", stress = "1e12";
  std::string pair = "hybrid defe/joint gran/hooke 5e6 NULL 2e4 NULL 0 0";
  std::string coeff = "pair_coeff 1*2 * none\npair_coeff 3 3 gran/hooke\npair_coeff 3 4 none\n"
                      "pair_coeff 4 4 defe/joint connective material cohesive 1e12 1e6 0.1 "
                      "contact 0.9 0.2\n";
  std::string options = "contact 0.2 check yes";
  std::vector<Grain> grains;

  std::string header() const
  {
    return "units si\natom_style sphere\natom_modify map yes\nnewton off on\ncomm_modify vel yes\n"
           "boundary f f f\n";
  }
  std::string fix() const
  {
    return "fix fe all defe material glass elastic 74.09e9 0.2 2500 convert glass " + stress +
        " type 4 group particles start " + start + " " + options + "\n";
  }
  std::string motion() const
  {
    return "group nodes type 1\ngroup grains type 3\nfix move1 nodes nve\n"
           "fix move2 particles nve/sphere\nfix move3 grains nve/sphere\n"
           "neighbor 4e-4 bin\nneigh_modify every 1 delay 0 check yes\ntimestep " +
        number(dt) + "\n";
  }
  void start_run(Lammps &lmp, bool run = true) const
  {
    std::string s = header() +
        "region box block -0.02 0.03 -0.02 0.03 -0.02 0.03\ncreate_box 4 box\npair_style " + pair +
        "\n" + coeff + "group particles empty\n" + fix() + "create_hexes fe glass 1";
    for (int k = 0; k < 3; k++)
      s += std::string(" ") + "xyz"[k] + " 0 " + std::to_string(n[k]) + " " + number(n[k] * h);
    s += "\n";
    for (const auto &g : grains)
      s += "create_atoms 3 single " + number(g.x[0]) + " " + number(g.x[1]) + " " + number(g.x[2]) +
          "\n";
    if (!grains.empty())
      s += "set type 3 diameter " + number(2.0 * grains[0].radius) + " density 2500\n";
    lmp.commands(s + motion());
    const tagint nodes = (n[0] + 1) * (n[1] + 1) * (n[2] + 1);
    lmp.change([&](Particle &p) {
      if (p.type == 3) p.v = grains[p.tag - nodes - 1].v;
    });
    if (run) lmp.run(0);
  }
};

std::vector<Particle> of_type(const Particles &all, int type)
{
  std::vector<Particle> some;
  for (const auto &p : all)
    if (p.second.type == type) some.push_back(p.second);
  return some;
}

/// Restitution of a damped spring that lets go where it began.
double restitution(double k, double damping, double mass)
{
  const double omega = std::sqrt(k / mass - 0.25 * damping * damping);
  return std::exp(-0.5 * pi * damping / omega);
}

/// Loose DEs (they are born so), far from each other, one of them in the way of a grain that flies
/// along -x with 2 m/s; the velocities of DE and grain afterwards, and their least distance.
struct Struck {
  double de, grain, nearest, others;
  double m_de, m_grain;
};
Struck strike_one(const std::string &style, const std::string &coeff)
{
  const int steps = 2000;
  Scene scene;
  scene.start = "all";
  scene.pair = style;
  scene.coeff = "pair_coeff 1*2 * none\npair_coeff 3 3 gran/hooke\n"
                "pair_coeff 4 4 defe/contact contact 0.9 0\n" +
      coeff;
  scene.grains = {{Vec3(0.02, 0.02, 0.02), Vec3::Zero()}};
  Lammps lmp;
  scene.start_run(lmp);
  lmp.command("timestep 1e-8");    // of which a contact of one DE takes some hundred
  const Vec3 centre(0.5 * h, 0.5 * h, 0.5 * h);
  const Vec3 corner = centre + 4.0 * Vec3(0.25 * h, 0.25 * h, 0.25 * h);
  lmp.change([&](Particle &p) {
    if (p.type == 4) p.x = centre + 4.0 * (p.x - centre);
    if (p.type != 3) return;
    p.x = corner + Vec3(0.5 * 0.5 * h + scene.grains[0].radius + 1.2e-6, 0.0, 0.0);
    p.v = Vec3(-2.0, 0.0, 0.0);
  });
  tagint struck = 0;
  for (const auto &p : of_type(lmp.particles(), 4))
    if ((p.x - corner).norm() < 0.1 * h) struck = p.tag;
  lmp.command("group struck id " + std::to_string(struck));
  lmp.record({"xcm(grains,x)-xcm(struck,x)"}, 1);
  lmp.run(steps);

  const Particles all = lmp.particles();
  const Particle grain = of_type(all, 3).front(), de = all.at(struck);
  Struck result{de.v[0], grain.v[0], 1.0, 0.0, de.mass, grain.mass};
  for (double distance : lmp.recorded()) result.nearest = std::min(result.nearest, distance);
  for (const auto &p : of_type(all, 4))
    if (p.tag != struck) result.others = std::max(result.others, p.v.norm());
  return result;
}

/// Forces on the grain (z) at every step while it bounces off a face of finite elements.
std::vector<double> bounce_off_face(const std::string &pair, const std::string &coeff)
{
  Scene scene;
  scene.n[0] = scene.n[1] = 4;
  scene.n[2] = 2;
  scene.pair = pair;
  scene.coeff = coeff;
  const double R = Grain().radius;
  scene.grains = {{Vec3(4.3e-3, 3.8e-3, 2.0 * h + R + 1e-7), Vec3(0.0, 0.0, -4.0)}};
  Lammps lmp;
  scene.start_run(lmp);
  const Particles before = lmp.particles();
  lmp.command("compute push grains reduce sum fz");
  lmp.record({"c_push", "f_fe[22]"}, 1);
  lmp.run(800);
  const Particles after = lmp.particles();
  const double p = scene.grains[0].mass() * 4.0;
  EXPECT_LT((momentum(after) - momentum(before)).norm(), 1e-10 * p);
  EXPECT_GT(of_type(after, 3).front().v[2], 1.0);
  EXPECT_LT(largest_deviation(lmp.recorded(1)), 2e-3 * 0.5 * p * 4.0);
  return lmp.recorded(0);
}

}    // namespace

// Two grains far from the glass: the closed form of a damped spring, while an element lies there, or
// its eight DEs.
TEST(Hybrid, GrainsBounceByTheirOwnStyle)
{
  for (const std::string start : {"no", "all"})
    for (const std::string style : {"hybrid", "hybrid/overlay"}) {
      Scene scene;
      scene.start = start;
      scene.pair.replace(0, 6, style);
      const double R = Grain().radius;
      scene.grains = {{Vec3(-0.010, 0.018, 0.003), Vec3(2.0, 0.0, 0.0)},
                      {Vec3(-0.010 + 2.0 * R + 1e-7, 0.018, 0.003), Vec3(-2.0, 0.0, 0.0)}};
      Lammps lmp;
      scene.start_run(lmp);
      lmp.run(2000);
      const auto grains = of_type(lmp.particles(), 3);
      const double e = restitution(spring, gamma_n, 0.5 * scene.grains[0].mass());
      ASSERT_TRUE(e > 0.5 && e < 0.95) << e;
      // contact begins and ends between two steps
      EXPECT_NEAR(grains[1].v[0] / 2.0, e, 2.0 * gamma_n * dt) << style << ", start " << start;
      EXPECT_NEAR(grains[0].v[0] / -2.0, e, 2.0 * gamma_n * dt) << style << ", start " << start;
      EXPECT_EQ(lmp.fe(CONVERTED), start == "all" ? 1.0 : 0.0);
    }
}

// Other styles of LAMMPS: granular with a given restitution; repulsive Lennard-Jones, which gives all back.
TEST(Hybrid, GrainsBounceByOtherStyles)
{
  struct Style {
    std::string name, coeff;
    double e, gap, dt;
  };
  const std::vector<Style> styles = {
      {"granular",
       "granular hooke 5e6 0.7 tangential linear_nohistory 0 0 damping coeff_restitution", 0.7,
       1e-7, 1e-8},
      {"granular", "granular hertz/material 70e9 0 0.2 tangential linear_nohistory 0 0", 1.0, 1e-7,
       1e-8},
      {"lj/cut 0.00449", "lj/cut 1e-4 4e-3", 1.0, 5e-4, 5e-8}};
  for (const auto &style : styles) {
    Scene scene;
    scene.start = "all";
    scene.pair = "hybrid defe/joint " + style.name;
    scene.coeff = "pair_coeff 1*2 * none\npair_coeff 3 4 none\npair_coeff 3 3 " + style.coeff +
        "\npair_coeff 4 4 defe/joint connective material cohesive 1e12 1e6 0.1 contact 0.9 0.2\n";
    scene.grains = {{Vec3(-0.010, 0.018, 0.003), Vec3(2.0, 0.0, 0.0)},
                    {Vec3(-0.010 + 4e-3 + style.gap, 0.018, 0.003), Vec3(-2.0, 0.0, 0.0)}};
    Lammps lmp;
    scene.start_run(lmp);
    lmp.command("timestep " + number(style.dt));
    lmp.run(style.dt > 1e-8 ? 16000 : 8000);
    const auto grains = of_type(lmp.particles(), 3);
    EXPECT_NEAR(grains[1].v[0] / 2.0, style.e, 2e-3) << style.coeff;
    EXPECT_NEAR(grains[0].v[0] / -2.0, style.e, 2e-3) << style.coeff;
  }
}

// A grain strikes one loose DE: what acts between them is what the map says.
TEST(Hybrid, GrainAgainstDEByTheMap)
{
  const std::string gran = " gran/hooke 5e6 NULL 2e4 NULL 0 0";
  const double v = 2.0, reach = 2e-3 + 0.5e-3;
  const auto after = [v](const Struck &s, double e) {    // speeds of DE and grain, centrally struck
    const double M = s.m_de + s.m_grain;
    return std::array<double, 2>{-(1.0 + e) * s.m_grain / M * v, -(s.m_grain - e * s.m_de) / M * v};
  };
  const auto reduced = [](const Struck &s) {
    return s.m_de * s.m_grain / (s.m_de + s.m_grain);
  };

  // none: it flies through
  const auto none = strike_one("hybrid defe/contact" + gran, "pair_coeff 3 4 none\n");
  EXPECT_EQ(none.grain, -v);
  EXPECT_EQ(none.de, 0.0);
  EXPECT_NEAR(none.nearest, reach + 1.2e-6 - 2000 * 1e-8 * v, 1e-12);

  // the granular style's spring
  const auto other = strike_one("hybrid defe/contact" + gran, "pair_coeff 3 4 gran/hooke\n");
  const double e = restitution(spring, gamma_n, reduced(other));
  EXPECT_NEAR(other.de, after(other, e)[0], 2e-3 * v);
  EXPECT_NEAR(other.grain, after(other, e)[1], 2e-3 * v);

  // that of defe, undamped: all comes back, and at the turning point all is stored in the patch
  const std::string undamped = " gran/hooke 5e6 NULL 0 NULL 0 0";
  const double area = 1e-6, k_area = 0.2 * 74.09e9 / (3.0 * (1.0 - 0.4)) * area / (2.0 * 1e-9);
  const auto stored = [&](const Struck &s, double k) {
    const double depth = reach - s.nearest;
    return (defe::ball_on_patch(depth, 2e-3, area, k_area).energy + 0.5 * k * depth * depth) /
        (0.5 * reduced(s) * v * v);
  };
  const auto ours =
      strike_one("hybrid defe/contact" + undamped, "pair_coeff 3 4 defe/contact contact 1 0\n");
  EXPECT_NEAR(ours.de, after(ours, 1.0)[0], 2e-3 * v);
  EXPECT_NEAR(ours.grain, after(ours, 1.0)[1], 2e-3 * v);
  EXPECT_NEAR(stored(ours, 0.0), 1.0, 5e-3);

  // overlay: both at once
  const auto two =
      strike_one("hybrid/overlay defe/contact" + undamped,
                 "pair_coeff 3 4 defe/contact contact 1 0\npair_coeff 3 4 gran/hooke\n");
  EXPECT_NEAR(two.de, after(two, 1.0)[0], 2e-3 * v);
  EXPECT_NEAR(stored(two, spring), 1.0, 5e-3);
  for (const auto &s : {none, other, ours, two}) EXPECT_EQ(s.others, 0.0);
}

// Faces of finite elements meet grains by the contact of fix defe, whatever the map says of DEs.
TEST(Hybrid, GrainAgainstFaceIsOfFixDefe)
{
  const std::string de = "connective material cohesive 1e12 1e6 0.1 contact 0.9 0.2\n";
  const std::string hybrid = "hybrid defe/joint gran/hooke 5e6 NULL 2e4 NULL 0 0";
  const std::string common =
      "pair_coeff 1*2 * none\npair_coeff 3 3 gran/hooke\npair_coeff 4 4 defe/joint " + de;
  const auto plain = bounce_off_face("defe/joint", "pair_coeff 4 4 " + de);
  double scale = 0.0;
  for (double f : plain) scale = std::max(scale, f);
  ASSERT_GT(scale, 10.0);
  for (const std::string map : {"none", "gran/hooke", "defe/joint contact 0.9 0.2"}) {
    const auto force = bounce_off_face(hybrid, common + "pair_coeff 3 4 " + map + "\n");
    ASSERT_EQ(force.size(), plain.size());
    for (size_t k = 0; k < force.size(); k++)
      EXPECT_NEAR(force[k], plain[k], 1e-9 * scale) << map << ", step " << k;
  }
}

// Grains with friction rain on a block that converts and cracks under them: the same on any number of
// ranks, and over a restart in the middle, on which the pair_coeff commands are given again. What rounding
// becomes in softening joints is measured: on one rank, with grains that start an ulp faster or slower.
TEST(Hybrid, HailOnCrackingGlass)
{
  Scene scene;
  scene.n[0] = scene.n[1] = 6;
  scene.n[2] = 2;
  scene.stress = "15e6";
  scene.pair = "hybrid defe/joint gran/hooke/history 5e6 NULL 0 NULL 0.3 1";
  scene.coeff = "pair_coeff 1*2 * none\npair_coeff 3 3 gran/hooke/history\n"
                "pair_coeff 3 4 gran/hooke/history\npair_coeff 4 4 defe/joint connective material "
                "cohesive 40e6 10 0.1 contact 0.9 0.2\n";
  scene.options = "contact 0.2 friction 0.2 check yes";
  for (int k = 0; k < 12; k++) {
    const double x = (0.15 + 0.35 * (k % 3)) * 6 * h, y = (0.15 + 0.35 * (k / 3 % 2)) * 6 * h;
    const Vec3 shift = 8e-5 * random_of(k + 1, 5);
    scene.grains.push_back({Vec3(x, y, 2 * h + 2.0e-3 + 1e-4 + 4.3e-3 * (k / 6)) + shift,
                            Vec3(3.0 * (k % 2) - 1.5, 2.0, -30.0 + 3.0 * (k / 6))});
  }
  constexpr int middle = 350, end = 700;
  // scene.grains touch each other in pairs only after they have met the glass

  const auto whole = [&](MPI_Comm comm, const std::string &restart) {
    FreshPairNumbers::begin();
    Lammps lmp(comm);
    scene.start_run(lmp, false);
    lmp.run(middle);
    if (!restart.empty()) lmp.command("write_restart " + restart);
    lmp.run(end - middle);
    return lmp.particles();
  };
  Grown grown;
  const Particles reference = on_one_rank([&] {
    const Particles as_it_is = whole(MPI_COMM_SELF, "");
    const auto grains = scene.grains;
    grown = grown_rounding(as_it_is, [&](unsigned k) {
      for (size_t g = 0; g < grains.size(); g++)
        scene.grains[g].v = grains[g].v + 3.6e-15 * random_of(static_cast<tagint>(g + 1), 20 + k);
      return whole(MPI_COMM_SELF, "");
    });
    scene.grains = grains;
    return as_it_is;
  });
  MPI_Bcast(&grown, 2, MPI_DOUBLE, 0, MPI_COMM_WORLD);
  const double scale = largest(reference, &Particle::v);
  EXPECT_LT(grown.v, 1e-7 * scale) << "a poor example";
  const auto same = [&](const Particles &here, const char *what) {
    EXPECT_LT(difference(reference, here, &Particle::x), 1e-10 * h + 10.0 * grown.x) << what;
    EXPECT_LT(difference(reference, here, &Particle::v), 1e-9 * scale + 10.0 * grown.v) << what;
  };
  const std::string file = "hail.restart";
  same(whole(MPI_COMM_WORLD, file), "uninterrupted");

  FreshPairNumbers::begin();
  Lammps lmp;
  lmp.commands(scene.header() + "read_restart " + file + "\n" + scene.coeff + scene.fix() +
               scene.motion());
  ASSERT_EQ(lmp.step(), middle);
  lmp.run(end - middle);
  same(lmp.particles(), "over a restart");
  EXPECT_GT(lmp.fe(CONVERTED), 3.0);
  EXPECT_GT(lmp.fe(CONTACT), 3.0);

  // all that happened to them: hits on glass, on DEs and on each other
  for (const auto &g : of_type(lmp.particles(), 3)) EXPECT_GT(g.omega.norm(), 0.0);
}

// Two spheres bonded by bpm/spring swing with the frequency of the bond; then they hit glass that
// converts and cracks, as one does that comes with them by pair_style hybrid.
TEST(Hybrid, BondedSpheresBesideGlass)
{
  const double k = 2e5;
  const auto script = [&](double down) {
    Scene scene;
    scene.n[0] = scene.n[1] = 4;
    scene.n[2] = 2;
    std::string s = "units si\natom_style hybrid bond sphere\natom_modify map yes\nnewton on off\n"
                    "comm_modify vel yes cutoff 0.008\nboundary f f f\n"
                    "special_bonds lj 0 1 1 coul 1 1 1\n"
                    "region box block -0.02 0.03 -0.02 0.03 -0.02 0.03\n"
                    "create_box 4 box bond/types 1 extra/bond/per/atom 4 extra/special/per/atom 8\n"
                    "pair_style hybrid defe/joint bpm/spring gran/hooke 5e6 NULL 0 NULL 0 0\n"
                    "pair_coeff 1*2 * none\npair_coeff 3 3 bpm/spring 1e5 4e-3 0\n"
                    "pair_coeff 3 4 gran/hooke\npair_coeff 4 4 defe/joint connective material "
                    "cohesive 18e6 10 0.1 lattice contact 0.9 0.2\n"
                    "bond_style bpm/spring smooth no\nbond_coeff 1 " +
        number(k) + " 0.5 0\ngroup particles empty\n";
    scene.stress = "15e6";
    s += scene.fix() + "create_hexes fe glass 1 x 0 4 0.008 y 0 4 0.008 z 0 2 0.004\n" +
        "create_atoms 3 single 0.002 0.004 0.0061\ncreate_atoms 3 single 0.0063 0.004 0.0061\n"
        "set type 3 diameter 4e-3 density 2500\ncreate_bonds single/bond 1 76 77\n" +
        scene.motion();
    for (const char *which : {"76", "77"})
      s += std::string("group one id ") + which + "\nvelocity one set " +
          (which[1] == '6' ? "-0.5" : "0.5") + " 0 " + number(-down) + "\ngroup one delete\n";
    return s;
  };

  {
    Lammps lmp;
    lmp.commands(script(0.0));
    lmp.command("group first id 76");
    lmp.record({"vcm(first,x)"}, 1);
    const double period = 2.0 * pi * std::sqrt(0.5 * Grain().mass() / k);
    lmp.run(static_cast<bigint>(2.3 * period / dt));
    const auto v = lmp.recorded();
    const double quarter = zero_crossing(v), three = zero_crossing(v, quarter + 10.0);
    EXPECT_NEAR(2.0 * (three - quarter) * dt / period, 1.0, 1e-4);
  }

  const auto hit = [&](MPI_Comm comm) {
    Lammps lmp(comm);
    lmp.commands(script(30.0));
    lmp.run(350);    // then rubble, in which rounding errors grow tenfold in 40 steps
    EXPECT_GT(lmp.fe(CONVERTED), 3.0);
    EXPECT_GT(lmp.fe(CONTACT), 3.0);
    return lmp.particles();
  };
  const Particles reference = on_one_rank([&] {
    return hit(MPI_COMM_SELF);
  });
  const Particles here = hit(MPI_COMM_WORLD);
  EXPECT_LT(difference(reference, here, &Particle::x), 1e-10 * h);
  EXPECT_LT(difference(reference, here, &Particle::v), 1e-9 * largest(reference, &Particle::v));
}
