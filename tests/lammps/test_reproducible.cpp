// fix defe reproducible yes: every bit is the same on any number of ranks, any decomposition, and over
// a restart: positions, velocities, spins, forces, records of DEs and elements, event files.
//
// ranks: 1 3 4
// timeout: 240

#include "contact_scene.h"
#include "glass_block.h"
#include "joints.h"
#include "layers.h"

#include "defe/coupling/checksum.h"

#include "comm.h"

#include <gmock/gmock.h>

#include <fstream>
#include <functional>
#include <iterator>

using namespace defe::test;
using defe::Vec3;

namespace {

/// How a run is cut into domains.
struct Domains {
  std::string processors = "* * *";
  std::string boundary = "f f f";
  std::string style;     // commands before the box
  std::string before;    // commands before the run
};

/// A body that cracks, and what is done to it.
struct Body {
  std::string name;
  std::string fix;      // materials and options of fix defe
  std::string mesh;     // commands that make it
  std::string more;     // commands after it
  std::string fixes;    // other fixes
  std::string box = "-0.03 0.03 -0.012 0.028 -0.012 0.016";
  std::string pair = "pair_coeff 2 2 connective material cohesive 6e7 10.0 0.1 contact 0.9 0.2\n"
                     "pair_coeff 2 3 contact 0.8 0.3\n";
  double bending = 10.0, dt = 5e-8;
  int steps = 400;
  std::function<void(Lammps &)> expect = [](Lammps &) {
  };    // is it a good example?
};

struct Outcome {
  std::map<tagint, uint64_t> atoms;    // checksums of all that there is of an atom
  std::string events;
};

std::map<tagint, uint64_t> checksums(Lammps &lmp)
{
  struct One {
    tagint tag;
    uint64_t sum;
  };
  std::vector<One> mine;
  const auto &store = defe_system(lmp).store;
  const auto *atom = lmp->atom;
  for (int i = 0; i < atom->nlocal; i++) {
    defe::Checksum sum;
    for (double **of : {atom->x, atom->v, atom->f, atom->omega, atom->torque})
      sum.add(of[i], 3 * sizeof(double));
    sum.add(&atom->rmass[i], sizeof(double));
    if (const auto *de = store.de(i)) sum.add(de->slot, sizeof(de->slot));
    if (const auto *touch = store.contacts_of(i)) {
      auto spheres = touch->spheres;    // in no order
      std::sort(spheres.begin(), spheres.end(), [](const auto &a, const auto &b) {
        return a.other < b.other;
      });
      for (const auto &s : spheres) sum.add(&s, sizeof(s));
      for (const auto &c : touch->cracks) sum.add(&c, sizeof(c));
      auto faces = touch->faces;
      std::sort(faces.begin(), faces.end(), [](const auto &a, const auto &b) {
        return a.part < b.part;
      });
      for (const auto &f : faces)
        sum.add(static_cast<const defe::ContactHistory *>(&f), sizeof(defe::ContactHistory));
    }
    auto hexes = std::vector<const LAMMPS_NS::HexRecord *>();
    for (const auto &h : store.hexes(i)) hexes.push_back(&h);
    std::sort(hexes.begin(), hexes.end(), [](const auto *a, const auto *b) {
      return a->id < b->id;
    });
    for (const auto *h : hexes) {
      sum.add(static_cast<const LAMMPS_NS::HexPod *>(h), sizeof(LAMMPS_NS::HexPod));
      if (h->extra) sum.add(h->extra->history.data(), h->extra->history.size() * sizeof(double));
    }
    mine.push_back({atom->tag[i], sum.value()});
  }
  std::map<tagint, uint64_t> all;
  for (const auto &one : lmp.gather(mine)) all[one.tag] = one.sum;
  return all;
}

std::string header(const Domains &d)
{
  return "units si\natom_style sphere\nnewton off on\ncomm_modify vel yes\n" + d.style +
      "\nboundary " + d.boundary + "\nprocessors " + d.processors + "\n";
}

std::string fix_of(const Body &s, const std::string &events)
{
  return "fix fe all defe " + s.fix + " reproducible yes events " + events + "\n";
}

std::string motion(const Body &s)
{
  return "group nodes type 1\ngroup ball type 3\nfix move1 nodes nve\n"
         "fix move2 particles nve/sphere\nfix move3 ball nve/sphere\n"
         "neighbor 2e-4 bin\nneigh_modify every 1 delay 0 check yes\ntimestep " +
      number(s.dt) + "\n" + s.fixes;
}

Outcome finish(Lammps &lmp, MPI_Comm comm, const std::string &events)
{
  Outcome o;
  o.atoms = checksums(lmp);
  MPI_Barrier(comm);
  std::ifstream in(events);
  o.events.assign(std::istreambuf_iterator<char>(in), {});
  MPI_Barrier(comm);
  return o;
}

/// restart: name of a restart file that is written at half of the steps; in two runs if `halves`.
Outcome run(MPI_Comm comm, const Body &s, const Domains &d, const std::string &restart,
            bool halves = false)
{
  const std::string events = size_of(comm) > 1 ? "bits.many.txt" : "bits.one.txt";
  remove_file(events, comm);
  Lammps lmp(comm);
  lmp.commands(header(d) + "region box block " + s.box +
               "\ncreate_box 3 box\npair_style defe/joint\n" + s.pair + "group particles empty\n" +
               fix_of(s, events) + s.mesh + s.more + motion(s));
  const Particles start = lmp.particles();
  lmp.change([&](Particle &p) {
    if (p.type == 3) return;
    const double r = start.at(p.tag).x[0] / 0.021;    // not wrapped
    p.v = Vec3(0.0, s.bending * (r * r - 1.0 / 3.0), 0.0) + 0.1 * random_of(p.tag, 8);
  });
  lmp.commands(d.before);
  lmp.command("restart " + std::to_string(s.steps / 2) + " " + restart + ".*");
  if (halves) lmp.run(s.steps / 2);
  lmp.run(halves ? s.steps - s.steps / 2 : s.steps);
  s.expect(lmp);
  return finish(lmp, comm, events);
}

/// The second half.
Outcome go_on(MPI_Comm comm, const Body &s, const Domains &d, const std::string &restart)
{
  const std::string events = "bits.again.txt";
  remove_file(events, comm);
  Lammps lmp(comm);
  lmp.commands(header(d) + "read_restart " + restart + "." + std::to_string(s.steps / 2) + "\n" +
               fix_of(s, events) + motion(s) + d.before);
  // the uninterrupted run makes its lists anew at its end, too
  lmp.command("restart " + std::to_string(s.steps / 2) + " " + restart + "_again.*");
  lmp.run(s.steps - s.steps / 2);
  return finish(lmp, comm, events);
}

void expect_same_bits(const Outcome &a, const Outcome &b, const std::string &name)
{
  SCOPED_TRACE(name);
  EXPECT_TRUE(a.events == b.events) << "event files differ";
  ASSERT_EQ(a.atoms.size(), b.atoms.size());
  int different = 0;
  for (const auto &one : a.atoms) {
    const auto other = b.atoms.find(one.first);
    if (other != b.atoms.end() && other->second == one.second) continue;
    if (different++ == 0) ADD_FAILURE() << "atom " << one.first << " differs";
  }
  EXPECT_EQ(different, 0) << "of " << a.atoms.size();
}

/// Lines of an event file after half of the steps.
std::string second_half(const std::string &events, const Body &scene)
{
  std::istringstream in(events);
  std::string rest;
  for (std::string line; std::getline(in, line);)
    if (line[0] != '#' && std::stol(line) > scene.steps / 2) rest += line + "\n";
  EXPECT_FALSE(rest.empty()) << "a poor example";
  return rest;
}

/// Every grid of this number of ranks, and moving borders.
std::vector<Domains> ways()
{
  std::vector<Domains> list;
  const int n = size_of(MPI_COMM_WORLD);
  for (int a = 1; a <= n; a++)
    for (int b = 1; a * b <= n; b++)
      if (n % (a * b) == 0) {
        Domains d;
        d.processors =
            std::to_string(a) + " " + std::to_string(b) + " " + std::to_string(n / a / b);
        list.push_back(d);
      }
  Domains d;
  d.style = "comm_style tiled";
  d.before = "fix balance all balance 10 1.0 rcb\n";
  list.push_back(d);
  d.before = "balance 1.0 rcb\n";
  list.push_back(d);
  d.style = "atom_modify sort 1 0.003";
  d.before.clear();
  list.push_back(d);
  return list;
}

void compare(const Body &scene, const std::string &boundary = "f f f", bool restarts = true)
{
  const bool root = rank_of(MPI_COMM_WORLD) == 0;
  Domains one;
  one.boundary = boundary;
  Outcome expected;
  const std::string restart = "bits.restart";
  if (root) expected = run(MPI_COMM_SELF, scene, one, restart);
  MPI_Barrier(MPI_COMM_WORLD);
  for (Domains &d : ways()) {
    d.boundary = boundary;
    const std::string name = scene.name + ": " + d.processors + " " + d.style + " " + d.before;
    const Outcome here = run(MPI_COMM_WORLD, scene, d, "bits.unused");
    if (root) expect_same_bits(expected, here, name);
  }
  if (!restarts) return;
  const Outcome halves = run(MPI_COMM_WORLD, scene, one, "bits.unused", true);
  if (root) expect_same_bits(expected, halves, scene.name + ": two runs");
  const Outcome again = go_on(MPI_COMM_WORLD, scene, one, restart);
  if (root)
    expect_same_bits({expected.atoms, second_half(expected.events, scene)},
                     {again.atoms, second_half(again.events, scene)}, scene.name + ": restart");
}

const std::string glass = "material glass elastic 74.09e9 0.2 2500 ";
const std::string beam = "create_hexes fe glass 1 x -0.021 21 0.021 y 0 4 0.008 z 0 2 0.004\n";
/// Hits the upper face aslant.
const std::string ball = "create_atoms 3 single 0.0013 0.01101 0.0021\n"
                         "set type 3 diameter 0.006 density 7800\nvelocity all set 0 0 0\n"
                         "group ball0 type 3\nvelocity ball0 set 12 -20 3\n";

Body cracking_beam()
{
  Body s;
  s.name = "beam";
  s.fix = glass + "convert glass 5.6e7 type 2 group particles contact 0.2 friction 0.3";
  s.mesh = beam;
  s.more = ball;
  s.expect = [](Lammps &lmp) {
    EXPECT_GT(lmp.fe(CONVERTED), 8);
    EXPECT_GT(lmp.fe(COHESIVE) + lmp.fe(CONTACT), 20);
    EXPECT_GT(lmp.fe(FRICTION), 0.0);
  };
  return s;
}

}    // namespace

TEST(Reproducible, CrackingBeamUnderABall)
{
  compare(cracking_beam());
}

TEST(Reproducible, TwoClocks)
{
  Body s = cracking_beam();
  s.name = "two clocks";
  s.fix += " every 2";
  compare(s);
}

// the periodic borders go through the crack
TEST(Reproducible, PeriodicBox)
{
  Body s = cracking_beam();
  s.box = "0.0003 0.0603 0.0047 0.0547 0.0012 0.0412";
  compare(s, "p p p");
}

TEST(Reproducible, DiscreteElementsThatFallApart)
{
  Body s = cracking_beam();
  s.name = "discrete";
  s.fix = glass +
      "convert glass 5.6e7 type 2 group particles start all contact 0.2 friction 0.3 shield no";
  s.fixes = "fix floor all defe/wall yplane -0.0001 NULL friction 0.2\n";
  s.bending = 20.0;
  s.expect = [](Lammps &lmp) {
    EXPECT_GT(lmp.fe(CONTACT), 50);
    EXPECT_GT(lmp.fe(DAMPING), 0.0);
    double largest = 0.0;
    for (const auto &p : lmp.particles())
      if (p.second.type == 2 && p.second.x[1] < p.second.radius - 1e-4)
        largest = std::max(largest, p.second.f.norm());
    EXPECT_GT(largest, 0.0) << "nothing is on the floor";
  };
  compare(s);
}

// glass, viscoelastic film, glass, which comes off the film; the plies rub against what is below
TEST(Reproducible, LaminateWithAdhesives)
{
  Body s;
  s.name = "laminate";
  s.fix = "material glass elastic 74.09e9 0.2 2500 part lower glass part upper glass "
          "material inter prony 20e9 1100 0.69e6 1 0.32931e9 1e4 "
          "convert lower 5.6e7 type 2 group particles convert upper 5.6e7 type 2 group particles "
          "adhesive lower inter 4e6 20 0.5 adhesive upper inter 4e6 20 0.5 stress gauss "
          "contact 0.2 friction 0.3";
  layered({{"lower", 0.004, 2}, {"inter", 0.00152, 1}, {"upper", 0.00248, 2}},
          equidistant(-0.021, 0.021, 21), equidistant(0.0, 0.004, 2), 3)
      .write("bits.data");
  s.mesh = read_mesh("bits.data");
  s.more = ball;
  s.bending = 25.0;
  s.expect = [](Lammps &lmp) {
    EXPECT_GT(lmp.fe(CONVERTED), 8);
    EXPECT_GT(lmp.fe(TIES_BROKEN) + lmp.fe(TIES_SOFTENING), 4);
    EXPECT_GT(lmp.fe(VISCOUS), 0.0);
  };
  compare(s);
}

// LAMMPS sums forces of rigid bodies, which is exact, and torques, centres and inertia, which is not: with the
// latter given and the former switched off the bits are the same. LAMMPS does not take such bodies from restart files.
TEST(Reproducible, RigidImpactorWithGivenInertia)
{
  Body s = cracking_beam();
  s.name = "rigid";
  s.fix += " material impactor rigid 6.25e6";
  s.more = "create_hexes fe impactor 3 x -0.002 2 0.002 y 0.00801 1 0.01001 z 0 2 0.004\n";
  s.fixes = "unfix move3\nfix move3 ball rigid/nve single torque * off off off infile bits.rigid\n";
  s.expect = [](Lammps &lmp) {
    EXPECT_GT(lmp.fe(CONVERTED), 4);
    EXPECT_NE(lmp.value("vcm(ball,y)"), -8.0);
  };
  if (rank_of(MPI_COMM_WORLD) == 0)
    std::ofstream("bits.rigid")
        << "1\n1 0.2 0.0 0.00901 0.002 3e-7 6e-7 3e-7 0 0 0 0 -8 0 0 0 0 0 0 0\n";
  MPI_Barrier(MPI_COMM_WORLD);
  compare(s, "f f f", false);
}

// What the option cannot hold is said.
TEST(Reproducible, WhatItCannotHoldIsSaid)
{
  const std::string log = "log.bits";
  Domains d;
  Body s = cracking_beam();
  Lammps lmp;
  WarningLog warnings(lmp, log);
  lmp.commands(header(d) +
               "region box block -0.03 0.03 -0.012 0.028 -0.012 0.016\n"
               "create_box 3 box\npair_style defe/joint\n" +
               s.pair + "group particles empty\n" + "fix fe all defe " + s.fix +
               " material impactor rigid 1e5 reproducible yes\n" + s.mesh +
               "create_hexes fe impactor 3 x -0.002 2 0.002 y 0.00801 1 0.01001 z 0 2 0.004\n"
               "group nodes type 1\ngroup ram type 3\nfix move1 nodes nve\n"
               "fix move2 particles nve/sphere\nfix move3 ram rigid/nve single\n"
               "fix lb all balance 10 1.1 shift x 10 1.1\ntimestep 5e-8\n");
  lmp.run(0);
  const auto said = warnings.warnings();
  const auto rounding = testing::AllOf(
      testing::HasSubstr("Fix defe reproducible"), testing::HasSubstr("fix move3 rigid/nve"),
      size_of(MPI_COMM_WORLD) > 1 ? testing::HasSubstr("fix balance with shift")
                                  : testing::HasSubstr("reproducible"));
  EXPECT_THAT(said, testing::Contains(rounding));
}

// The command leaves borders that a later fix balance might have made, but no fix.
TEST(Reproducible, BalanceByCommandIsNamed)
{
  Block block;
  block.options = "reproducible yes";
  Lammps lmp;
  lmp.commands(block.script());
  WarningLog warnings(lmp, "log.balanced");
  lmp.commands("balance 1.0 shift x 10 1.0\nrun 0");
  const auto named =
      testing::Contains(testing::AllOf(testing::HasSubstr("Fix defe reproducible"),
                                       testing::HasSubstr("the command balance, if with shift")));
  if (size_of(MPI_COMM_WORLD) > 1)
    EXPECT_THAT(warnings.warnings(), named);
  else
    EXPECT_THAT(warnings.warnings(), testing::Not(named));
}

TEST(Reproducible, ForcesAndMassesOutOfRange)
{
  if (rank_of(MPI_COMM_WORLD) > 0) return;    // error->one() would end the other ranks
  const auto message = [](const Block &block, bool stretch, const std::string &more) {
    try {
      Lammps lmp(MPI_COMM_SELF);
      lmp.commands(block.header() + block.box() + block.fix() + block.mesh() + more +
                   block.motion());
      lmp.run(0);
      if (stretch)
        lmp.change([](Particle &p) {
          p.x *= 6.0;
        });
      lmp.run(1);
    } catch (std::exception &e) {
      return std::string(e.what());
    }
    return std::string();
  };
  Block block;
  block.options = "reproducible yes kernel lagrangian";
  block.dt = 1e-12;
  block.box_hi[0] = block.box_hi[1] = block.box_hi[2] = 0.09;
  EXPECT_THAT(message(block, false, ""), testing::IsEmpty());
  EXPECT_THAT(
      message(block, true, ""),
      testing::AllOf(testing::HasSubstr("too large for the exact sums of fix defe reproducible"),
                     testing::HasSubstr("use a smaller timestep")));
  // two parts that share nodes, with densities of 1 to 10^8
  MeshFile mesh;
  mesh.add_block("glass", 1, 2, 1, 1, 2e-3, [](const Vec3 &X) {
    return X;
  });
  mesh.part[1] = "lead";
  mesh.write("bits_mass.data", MPI_COMM_SELF);
  try {
    Lammps lmp(MPI_COMM_SELF);
    Domains d;
    lmp.commands(header(d) + block.box() +
                 "fix fe all defe material glass elastic 7e10 0.2 2500 "
                 "material lead elastic 7e10 0.2 2.5123456e11 reproducible yes\n" +
                 read_mesh("bits_mass.data") + "fix move1 all nve\ntimestep 1e-8\nrun 0\n");
    ADD_FAILURE() << "not refused";
  } catch (std::exception &e) {
    EXPECT_THAT(e.what(), testing::HasSubstr("masses that differ too much to be summed exactly"));
  }
}
