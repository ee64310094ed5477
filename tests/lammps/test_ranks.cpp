// One small beam that cracks through, hit by a rigid body, again and again with every decomposition:
// the same elements convert at the same steps, the same joints soften and break, and all particles
// are where they are on one rank.
//
// ranks: 1 3 4
// timeout: 400

#include "events.h"
#include "joints.h"

#include "glass_block.h"

#include <cmath>
#include <set>

using namespace defe::test;
using defe::Vec3;

namespace {

/// Keywords that every run of this file gets on its line of fix defe (invariant checks, ...).
const std::string fix_options = "";

constexpr double h = 2e-3, dt = 5e-8;

/// A beam that gets a bending velocity field and cracks at mid-span, and a rigid body on top of it.
struct Scene {
  double bending;               // m/s
  double at, speed, density;    // of the rigid body
  int steps;
  std::string law = "";
};

/// One clean crack; the body pushes one of the halves. 60 us.
const Scene clean{10.0, -0.014, 4.0, 3.1e4, 1000};

/// The body drives debris into the crack: DEs that hang by a joint or two, between others that they
/// hit every microsecond. Differences of rounding grow tenfold in 5 us there (from 1e-17 m, when
/// the order of summation is another one, to 1e-9 m in 60 us), as they do in a billiard: the test
/// stops at 27 us.
const Scene crushed{8.0, 0.0, 8.0, 6.25e6, 540, "lattice"};    // rubble

/// How a run is cut into domains. The defaults are those of the reference.
struct Domains {
  std::string name;
  std::string processors = "* * *";
  Vec3 lo = Vec3(-0.03, -0.012, -0.012), hi = Vec3(0.03, 0.028, 0.016);
  std::string boundary = "f f f";
  double skin = 2e-4;
  std::string style;     // commands before the box
  std::string before;    // commands before the run
};

/// What must not depend on it.
struct Outcome {
  std::vector<Event> events;
  Joints joints;
  Particles particles;
  double converted, des, cohesive, contact, ties, touching, total;
};

/// 21 x 4 x 2 elements of 2 mm with the crack plane x = 0 through the middle of a column, and a
/// rigid body on top of it.
Outcome crack(MPI_Comm comm, const Scene &scene, const Domains &domains)
{
  const std::string file = "ranks.txt";
  remove_file(file, comm);
  std::string box;
  for (int k = 0; k < 3; k++) box += " " + number(domains.lo[k]) + " " + number(domains.hi[k]);
  Lammps lmp(comm);
  lmp.commands("units si\natom_style sphere\nnewton off on\ncomm_modify vel yes\n" + domains.style +
               "\nboundary " + domains.boundary + "\nprocessors " + domains.processors +
               "\nregion box block" + box + R"(
    create_box      3 box
    pair_style      defe/joint
    pair_coeff      2 2 connective material cohesive 6e7 10.0 0.1 )" +
               scene.law + R"( contact 0.9 0.2
    group           particles empty
    fix             fe all defe material glass elastic 74.09e9 0.2 2500 &
                                material impactor rigid )" +
               number(scene.density) + R"( &
                                convert glass 5.6e7 type 2 group particles contact 0.2 &
                                events )" +
               file + " " + fix_options + R"(
    create_hexes    fe glass    1 x -0.021 21 0.021 y 0 4 0.008 z 0 2 0.004
    create_hexes    fe impactor 3 x )" +
               number(scene.at - 0.002) + " 2 " + number(scene.at + 0.002) +
               R"( y 0.00801 1 0.01001 z 0 2 0.004
    group           nodes    type 1
    group           impactor type 3
    fix             move1 nodes nve
    fix             move2 particles nve/sphere
    fix             ram   impactor rigid/nve single
    neigh_modify    every 1 delay 0 check yes
    neighbor        )" +
               number(domains.skin) + " bin\ntimestep " + number(dt) + "\n");
  const Particles start = lmp.particles();
  lmp.change([&](Particle &p) {
    const double s = start.at(p.tag).x[0] / 0.021;
    p.v = Vec3(0.0, scene.bending * (s * s - 1.0 / 3.0), 0.0) + 0.1 * random_of(p.tag, 8);
    if (p.type == 3) p.v = Vec3(0.0, -scene.speed, 0.0);
  });
  lmp.commands(domains.before);
  Outcome o;
  lmp.record({"f_fe[13]"}, 10);
  lmp.run(scene.steps);
  o.joints = joints(lmp);
  o.particles = lmp.particles();
  o.converted = lmp.fe(CONVERTED);
  o.des = lmp.fe(DES);
  o.cohesive = lmp.fe(COHESIVE);
  o.contact = lmp.fe(CONTACT);
  o.ties = lmp.fe(TIES);
  o.total = lmp.fe(TOTAL);
  const auto touching = lmp.recorded(0);
  o.touching = *std::max_element(touching.begin(), touching.end());
  EXPECT_EQ(static_cast<double>(lmp.natoms()), static_cast<double>(o.particles.size()));
  MPI_Barrier(comm);
  o.events = read_events(file);
  MPI_Barrier(comm);
  return o;
}

void expect_same(const Outcome &a, const Outcome &b, const std::string &name)
{
  SCOPED_TRACE(name);
  EXPECT_EQ(a.converted, b.converted);
  EXPECT_EQ(a.des, b.des);
  EXPECT_NEAR(a.total / b.total, 1.0, 1e-9);

  // the event file, line by line; values are written with 6 digits
  const size_t n = std::min(a.events.size(), b.events.size());
  size_t k = 0;
  for (; k < n; k++) {
    const Event &e = a.events[k], &f = b.events[k];
    bool same = e.step == f.step && e.time == f.time && e.what == f.what && e.a == f.a &&
        e.b == f.b && std::abs(e.value - f.value) <= 2e-6 * std::abs(e.value);
    for (int c = 0; c < 3; c++)
      same = same && std::abs(e.x[c] - f.x[c]) < 1e-7 * h && std::abs(e.n[c] - f.n[c]) < 2e-4;
    if (same) continue;
    ADD_FAILURE() << "event " << k << ": step " << e.step << " " << e.what << " " << e.a << " "
                  << e.b << " at " << e.x[0] << " " << e.x[1] << " " << e.x[2] << " value "
                  << e.value << "; here step " << f.step << " " << f.what << " " << f.a << " "
                  << f.b << " at " << f.x[0] << " " << f.x[1] << " " << f.x[2] << " value "
                  << f.value;
    break;
  }
  EXPECT_EQ(a.events.size(), b.events.size());

  ASSERT_EQ(a.joints.size(), b.joints.size());
  expect_mutual(b.joints, name);
  int different = 0;
  double damage = 0.0;
  for (const auto &it : a.joints) {
    const Joint &j = it.second;
    const auto other = b.joints.find(it.first);
    if (other == b.joints.end() || other->second.kind != j.kind || other->second.state != j.state ||
        other->second.other != j.other || other->second.partner != j.partner ||
        other->second.pending != j.pending) {
      if (different++ == 0) ADD_FAILURE() << "DE " << j.self << " slot " << j.slot;
      continue;
    }
    damage = std::max(damage, std::abs(other->second.damage - j.damage));
  }
  EXPECT_EQ(different, 0) << "joint slots differ";
  EXPECT_LT(damage, 1e-9 * h);    // an opening

  // atoms: 1e-9 of an edge
  const double x = difference(a.particles, b.particles, &Particle::x);
  if (std::getenv("DEFE_TEST_LOG"))
    std::printf("%-40s dx %.2e  dv %.2e  domega %.2e  damage %.2e\n", name.c_str(), x,
                difference(a.particles, b.particles, &Particle::v),
                difference(a.particles, b.particles, &Particle::omega), damage);
  EXPECT_LT(x, 1e-9 * h);
  for (const auto &p : a.particles) {
    EXPECT_EQ(p.second.type, b.particles.at(p.first).type);
    EXPECT_NEAR(p.second.mass / b.particles.at(p.first).mass, 1.0, 1e-14);
  }
}

/// On one rank, with everything at its defaults; for rank 0.
Outcome reference(const Scene &scene)
{
  const Outcome o = crack(MPI_COMM_SELF, scene, Domains());
  int plane = 0;
  long latest = 0;
  for (const auto &e : o.events) {
    plane += e.what == "broken" && std::abs(e.x[0]) < h && std::abs(e.n[0]) > 0.7;
    latest = e.step;
  }
  if (std::getenv("DEFE_TEST_LOG"))
    std::printf("reference: converted %g, cohesive %g, contact %g, ties %g, plane %d, last %ld, "
                "touching %g, total %g, events %zu\n",
                o.converted, o.cohesive, o.contact, o.ties, plane, latest, o.touching, o.total,
                o.events.size());
  EXPECT_GE(plane, 8 * 4 - 1) << "not cracked through";    // a pair under the impactor is pressed
  EXPECT_GT(latest, 0.7 * scene.steps) << "nothing happens in the end";
  EXPECT_GT(o.cohesive, 0) << "a poor example";
  EXPECT_GT(o.ties, 50) << "a poor example";
  EXPECT_GT(o.touching, 1e-4 * o.total) << "a poor example";
  expect_mutual(o.joints, "reference");
  return o;
}

void compare(const Scene &scene, const std::vector<Domains> &list)
{
  const bool root = rank_of(MPI_COMM_WORLD) == 0;
  Outcome expected;
  if (root) expected = reference(scene);
  MPI_Barrier(MPI_COMM_WORLD);
  for (const auto &domains : list) {
    const Outcome here = crack(MPI_COMM_WORLD, scene, domains);
    if (root) expect_same(expected, here, domains.name);
  }
}

/// Every `processors` grid of this number of ranks.
std::vector<std::string> grids()
{
  const int n = size_of(MPI_COMM_WORLD);
  std::vector<std::string> all;
  for (int a = 1; a <= n; a++)
    for (int b = 1; a * b <= n; b++)
      if (n % (a * b) == 0)
        all.push_back(std::to_string(a) + " " + std::to_string(b) + " " +
                      std::to_string(n / a / b));
  return all;
}

/// A uniform grid whose borders lie at x, y and z = `border` plus multiples of its domains' size.
Domains with_borders_at(const std::string &grid, const Vec3 &border)
{
  Domains d;
  d.name = grid + " with a border at " + number(border[0]) + " " + number(border[1]) + " " +
      number(border[2]);
  d.processors = grid;
  std::istringstream words(grid);
  for (int k = 0; k < 3; k++) {
    int n;
    words >> n;
    const double size = 0.07 / n;    // all of the body is in the box, wherever the border is
    d.lo[k] = border[k] - (n > 1 ? n / 2 * size : 0.5 * size);
    d.hi[k] = d.lo[k] + 0.07;
  }
  return d;
}

}    // namespace

// Borders on the crack plane and on faces of elements (0, 0.004, 0.002), in it but through
// single elements and DEs of the crack, and anywhere.
TEST(Ranks, EveryGridEveryBorder)
{
  std::vector<Domains> list;
  for (const auto &grid : grids())
    for (const Vec3 &border : {Vec3(0.0, 0.004, 0.002), Vec3(0.0003, 0.0047, 0.0012)})
      list.push_back(with_borders_at(grid, border));
  compare(clean, list);
}

TEST(Ranks, PeriodicAndShrinkWrappedBoundaries)
{
  std::vector<Domains> list;
  int k = 0;
  for (const auto &grid : grids()) {
    // the periodic borders themselves go through the crack
    Domains d;
    d.processors = grid;
    d.lo = Vec3(0.0003, 0.0047, 0.0012);
    d.hi = d.lo + Vec3(0.06, 0.05, 0.04);
    d.boundary = "p p p";
    d.name = grid + " " + d.boundary;
    list.push_back(d);
    // those of the ranks do
    d = with_borders_at(grid, Vec3(-0.0011, 0.0071, 0.0031));
    d.boundary = k++ % 2 ? "s s s" : "p s f";
    d.name = grid + " " + d.boundary;
    list.push_back(d);
  }
  compare(clean, list);
}

TEST(Ranks, BalanceBeforeAndDuringTheRun)
{
  struct Way {
    std::string boundary, commands;
  };
  std::vector<Domains> list;

  // domains along x as thin as an element or two, borders through elements and DEs of the crack
  const int n = size_of(MPI_COMM_WORLD);
  if (n > 1)
    for (const double thickness : {1.6e-3, 3.1e-3}) {
      if (n == 2 && thickness > 2e-3) continue;    // the same border
      Domains d;
      d.processors = std::to_string(n) + " 1 1";
      d.before = "balance 1.0 x";
      for (int k = 1; k < n; k++)
        d.before += " " + number(0.5 + (0.0002 + (k - n / 2) * thickness) / 0.06);
      d.name = d.before;
      list.push_back(d);
    }

  for (const Way &way :
       {Way{"f f f", "balance 1.0 shift xyz 20 1.01"},
        Way{"f f f", "fix balance all balance 10 1.0 shift xyz 20 1.01"},
        Way{"s s s", "balance 1.0 shift x 20 1.01\nfix balance all balance 7 1.0 shift x 20 1.01"},
        Way{"p p p", "fix balance all balance 13 1.0 shift xyz 20 1.01"}}) {
    Domains d;
    d.boundary = way.boundary;
    d.before = way.commands;
    d.name = way.boundary + " " + way.commands;
    list.push_back(d);
  }
  for (const Way &way : {Way{"f f f", ""}, Way{"f f f", "balance 1.0 rcb"},
                         Way{"s s s", "fix balance all balance 10 1.0 rcb"},
                         Way{"p p p", "balance 1.0 rcb\nfix balance all balance 1 1.0 rcb"}}) {
    Domains d;
    d.style = "comm_style tiled";
    d.boundary = way.boundary;
    d.before = way.commands;
    d.name = way.boundary + " tiled " + way.commands;
    list.push_back(d);
  }
  compare(clean, list);
}

TEST(Ranks, SortingAndSkins)
{
  std::vector<Domains> list;
  for (const std::string sort : {"atom_modify sort 0 0", "atom_modify sort 1 0.003"})
    for (const double skin : {1e-5, 1e-3, 3e-3}) {
      if (skin == 1e-3 && sort.back() == '0') continue;
      Domains d;
      d.style = sort;
      d.skin = skin;
      d.name = sort + " skin " + number(skin);
      list.push_back(d);
    }
  compare(clean, list);
}

// LAMMPS' map of more than a million IDs is a hash.
TEST(Ranks, MapOfAtomsByHash)
{
  Domains d;
  d.style = d.name = "atom_modify map hash";
  compare(clean, {d});
}

TEST(Ranks, DebrisInTheCrack)
{
  std::vector<Domains> list;
  for (const auto &grid : grids())
    list.push_back(with_borders_at(grid, Vec3(0.0003, 0.0047, 0.0012)));
  for (const std::string way :
       {"fix balance all balance 10 1.0 shift xyz 20 1.01", "fix balance all balance 1 1.0 rcb"}) {
    Domains d;
    if (way.find("rcb") != std::string::npos) d.style = "comm_style tiled";
    d.before = d.name = way;
    list.push_back(d);
  }
  for (const double skin : {1e-5, 1e-3}) {
    Domains d;
    d.style = "atom_modify sort 1 0.003";
    d.skin = skin;
    d.name = "skin " + number(skin);
    list.push_back(d);
  }
  compare(crushed, list);
}
