// Meshes that go to a data file and come back, and runs that stop in the middle of a crack.
//
// timeout: 240

#include "cracking_beam.h"
#include "mesh_file.h"

#include "defe_records.h"

#include <gmock/gmock.h>

#include <fstream>
#include <functional>
#include <iterator>

#include <cmath>
#include <set>

using namespace defe::test;
using defe::Vec3;
using testing::HasSubstr;

namespace {

constexpr double h = 2e-3;

std::string two_parts()
{
  return R"(
    pair_style      defe/joint
    pair_coeff      3 3 connective material cohesive 1e12 1e6 0.1 contact 0.9 0.2
    group           particles empty
    fix             fe all defe material glass elastic 74.09e9 0.2 2500 &
                                material steel elastic 210e9 0.3 7800 part plate glass &
                                convert plate 1e12 type 3 group particles
    timestep        5e-8
    neighbor        0.0003 bin
  )";
}

std::string header()
{
  return script_head();
}

/// id, part, x, y, z of all elements, by ID
std::map<int, std::vector<double>> elements(Lammps &lmp)
{
  std::map<int, std::vector<double>> result;
  for (const auto &row : lmp.local("hexes")) result[static_cast<int>(row[0])] = row;
  return result;
}

constexpr int middle = 100, end = 300;

/// Read the restart file and go on; the conversions after the restart.
std::vector<std::array<long, 2>> go_on(MPI_Comm comm, const std::string &restart,
                                       const std::string &events, Particles *last = nullptr)
{
  Block block = cracking_beam();
  block.options = "events " + events;
  remove_file(events, comm);    // after a restart it is continued
  Lammps lmp(comm);
  lmp.commands(block.header() + "read_restart " + restart + "\n" + block.fix_only() +
               block.motion());
  EXPECT_EQ(lmp.step(), middle);
  lmp.run(end - middle);
  if (last) *last = lmp.particles();
  MPI_Barrier(comm);
  return conversions(events);
}

}    // namespace

// Two parts beside each other, an irregular one from a file and one made by create_hexes; elements
// and nodes come back with their IDs, parts and masses, and with the same forces when deformed.
TEST(DataFile, RoundTripOfTwoParts)
{
  MeshFile mesh;
  tagint tag = 0;
  mesh.types = 3;
  mesh.add_block("steel", 2, 3, 3, 4, h, [&](const Vec3 &X) {
    return Vec3(X + 0.1 * h * random_of(++tag, 9));
  });
  mesh.write("steel.data");
  const std::string computes = "compute hexes all defe/hex/local id part x y z";
  const auto deform = [](Particle &p) {
    p.x += 0.02 * h * random_of(p.tag, 10);
  };

  Particles first, forces;
  std::map<int, std::vector<double>> hexes;
  {
    Lammps lmp;
    lmp.commands(header() +
                 "region box block -0.02 0.03 -0.02 0.03 -0.02 0.03\ncreate_box 3 box\n" +
                 two_parts() + read_mesh("steel.data") +
                 "create_hexes fe plate 1 x 0.010 3 0.016 y 0 2 0.004 z 0 4 0.01\n" + computes);
    lmp.command("write_data both.data");    // before any run
    lmp.run(0);
    first = lmp.particles();
    hexes = elements(lmp);
    lmp.change(deform);
    lmp.run(0);
    forces = lmp.particles();
  }
  ASSERT_EQ(hexes.size(), 3u * 3u * 4u + 3u * 2u * 4u);
  EXPECT_EQ(hexes.at(1)[1], 2.0);     // part steel
  EXPECT_EQ(hexes.at(37)[1], 3.0);    // part plate
  EXPECT_EQ(first.size(), 4u * 4u * 5u + 4u * 3u * 5u);
  // a lumped mass each: of an irregular mesh it is the sum that is known, but for the border's
  // shape
  EXPECT_NEAR(total_mass(first), 7800 * 36 * h * h * h + 2500 * 24 * h * 2e-3 * 2.5e-3,
              0.02 * total_mass(first));

  for (const std::string file : {"both.data", "again.data"}) {
    Lammps lmp;
    lmp.commands(header() +
                 "region box block -0.02 0.03 -0.02 0.03 -0.02 0.03\ncreate_box 3 box\n" +
                 two_parts() + read_mesh(file) + computes);
    if (file == "both.data") lmp.command("write_data again.data");
    lmp.run(0);
    const Particles back = lmp.particles();
    ASSERT_EQ(back.size(), first.size());
    // write_data writes 17 digits
    EXPECT_EQ(difference(first, back, &Particle::x), 0.0);
    for (const auto &p : first) {
      EXPECT_EQ(p.second.type, back.at(p.first).type);
      EXPECT_NEAR(p.second.mass / back.at(p.first).mass, 1.0, 1e-15);
    }
    const auto same = elements(lmp);
    ASSERT_EQ(same.size(), hexes.size());
    for (const auto &e : hexes)
      for (int k = 0; k < 5; k++)
        EXPECT_NEAR(e.second[k], same.at(e.first)[k], k < 2 ? 0.0 : 1e-17) << "element " << e.first;
    lmp.change(deform);
    lmp.run(0);
    // the order of nodes differs: rounding of the sums
    EXPECT_LT(difference(forces, lmp.particles(), &Particle::f),
              1e-12 * largest(forces, &Particle::f));
  }
}

// The same mesh read twice, with offsets for atom IDs and positions, is two bodies. (Elements need
// IDs of their own: the second copy has another file.)
TEST(DataFile, ReadTwiceItIsTwoBodies)
{
  MeshFile one, two;
  one.types = two.types = 3;
  one.add_block("steel", 2, 2, 2, 2, h, [](const Vec3 &X) {
    return X;
  });
  two = one;
  one.write("one.data");
  // read with `add append`: atom IDs go up by the largest there is
  if (rank_of(MPI_COMM_WORLD) == 0) {
    std::ifstream in("one.data");
    std::ofstream out("two.data");
    std::string line;
    bool hexes = false;
    while (std::getline(in, line)) {
      if (hexes && !line.empty())
        line = std::to_string(100 + std::stoi(line)) + line.substr(line.find(' '));
      if (line == "Hexes") hexes = true;
      out << line << "\n";
    }
  }
  MPI_Barrier(MPI_COMM_WORLD);
  Lammps lmp;
  lmp.commands(header() + "region box block -0.02 0.03 -0.02 0.03 -0.02 0.03\ncreate_box 3 box\n" +
               two_parts() + read_mesh("one.data") +
               "read_data two.data add append shift 0.006 0 0 fix fe hexes Hexes\n" +
               "compute hexes all defe/hex/local id part x y z\n");
  lmp.run(0);
  const auto hexes = elements(lmp);
  ASSERT_EQ(hexes.size(), 16u);
  EXPECT_EQ(lmp.natoms(), 54);
  for (int e = 1; e <= 8; e++)
    EXPECT_NEAR(hexes.at(100 + e)[2] - hexes.at(e)[2], 0.006, 1e-16) << "element " << e;
  EXPECT_NEAR(total_mass(lmp.particles()), 16 * 7800 * h * h * h, 1e-15);
}

// With all its joints, contacts and shields the state goes through the file: the same elements convert at
// the same steps. How exact it is, test_pieces.cpp asks.
TEST(Restart, SameConversionsFromTheMiddleOfACrack)
{
  const bool root = rank_of(MPI_COMM_WORLD) == 0;
  Block block = cracking_beam();
  std::vector<std::array<long, 2>> whole;
  Particles last;
  {
    block.options = "events whole.txt";
    remove_file("whole.txt");
    Lammps lmp;
    lmp.commands(block.script() + "restart " + std::to_string(middle) + " mid.*.restart\n");
    bend(lmp, block);
    lmp.run(end);
    last = lmp.particles();
    MPI_Barrier(MPI_COMM_WORLD);
    whole = conversions("whole.txt", middle);
    const auto before = conversions("whole.txt").size() - whole.size();
    EXPECT_GT(before, 8u) << "a poor example";
    EXPECT_GT(whole.size(), 8u) << "a poor example";
    EXPECT_GT(lmp.fe(CONTACT), 20) << "a poor example";
  }
  if (root) {
    // one rank writes a restart file of its own
    block.options = "events one.txt";
    remove_file("one.txt", MPI_COMM_SELF);
    Lammps lmp(MPI_COMM_SELF);
    lmp.commands(block.script() + "restart " + std::to_string(middle) + " one.*.restart\n");
    bend(lmp, block);
    lmp.run(end);
    EXPECT_EQ(conversions("one.txt", middle), whole) << "on one rank";
  }
  MPI_Barrier(MPI_COMM_WORLD);
  const std::string step = std::to_string(middle);

  Particles here;
  EXPECT_EQ(go_on(MPI_COMM_WORLD, "mid." + step + ".restart", "same.txt", &here), whole);
  ASSERT_EQ(here.size(), last.size());
  EXPECT_LT(difference(last, here, &Particle::x), 1e-8);    // velocities of 10 m/s, 6 us: 6e-5 m
  EXPECT_EQ(go_on(MPI_COMM_WORLD, "one." + step + ".restart", "more.txt"), whole);
  if (root) { EXPECT_EQ(go_on(MPI_COMM_SELF, "mid." + step + ".restart", "fewer.txt"), whole); }
}

// In the middle of a collision with friction: depths, springs and elements come through the file,
// and no force here depends on velocities (restitution 1). A second `run` is the same thing.
TEST(Restart, InTheMiddleOfACollision)
{
  Block block;
  block.regions = "region half block 0.003 INF INF INF INF INF";
  block.coeff = "connective material cohesive 1e12 1e6 0.1 contact 1.0 0.2";
  block.convert += " start half";
  block.options = "part base glass contact 0.5 friction 0.2";
  const std::string base =
      "create_hexes fe base 1 x -0.0013 4 0.0107 y -0.004 2 -0.00001 z -0.001 2 0.005\n";
  const auto fall = [](Particle &p) {
    if (p.x[1] > -0.000005) p.v = Vec3(3.0, -6.0, 1.0) + 0.1 * random_of(p.tag, 12);
  };
  Particles whole, twice, after;
  double total;
  {
    Lammps lmp;
    lmp.commands(block.script() + base);
    lmp.command("group nodes type 1");
    lmp.change(fall);
    lmp.run(300);
    whole = lmp.particles();
    total = lmp.fe(TOTAL);
  }
  {
    Lammps lmp;
    lmp.commands(block.script() + base);
    lmp.command("group nodes type 1");
    lmp.change(fall);
    lmp.run(80);
    EXPECT_GT(lmp.fe(E_CONTACT), 0.01 * total);
    EXPECT_GT(lmp.fe(FRICTION), 0.0);
    lmp.command("write_restart collision.restart");
    lmp.run(220);
    twice = lmp.particles();
  }
  {
    Lammps lmp;
    lmp.commands(block.header() + "read_restart collision.restart\n" + block.regions + "\n" +
                 block.fix_only() + block.motion());
    EXPECT_EQ(lmp.step(), 80);
    lmp.run(220);
    after = lmp.particles();
    EXPECT_NEAR(lmp.fe(TOTAL) / total, 1.0, 1e-9);    // cumulative entries too
  }
  // rounding of 1e-18 m grows through some hundred slips to 3e-14 m; it moves by 1e-4 m, 6 m/s
  EXPECT_LT(difference(whole, twice, &Particle::x), 1e-12);
  EXPECT_LT(difference(whole, after, &Particle::x), 1e-12);
  EXPECT_LT(difference(whole, after, &Particle::v), 1e-6);
}

// ---- any step, any number of ranks ----

namespace {

/// 1e-9 of an element edge
constexpr double same_place = 1e-9 * h;

struct State {
  Particles particles;
  std::map<int, double> entries;
  History events;    // after the restart
};

State state_of(Lammps &lmp, const std::string &events, long after, MPI_Comm comm)
{
  State state;
  state.particles = lmp.particles();
  for (int k = ELEMENTS; k <= FIRST_DAMAGE; k++) state.entries[k] = lmp.fe(static_cast<Entry>(k));
  MPI_Barrier(comm);
  state.events = history(events, after);
  MPI_Barrier(comm);
  return state;
}

void expect_same(const State &a, const State &b, const std::string &what)
{
  EXPECT_EQ(a.events, b.events) << what;
  ASSERT_EQ(a.particles.size(), b.particles.size()) << what;
  EXPECT_LT(difference(a.particles, b.particles, &Particle::x), same_place) << what;
  const double total = std::abs(a.entries.at(TOTAL));
  for (const auto &e : a.entries) {
    double tolerance = 0.0;
    if (e.first == S1_MAX)
      tolerance = 1e-5 * e.second;
    else if (e.first >= E_ELEMENTS && e.first <= BALANCE)
      tolerance = 1e-8 * total;
    else if (e.first > BALANCE)
      tolerance = 1e-18;
    EXPECT_NEAR(e.second, b.entries.at(e.first), tolerance) << what << ", f_fe[" << e.first << "]";
  }
}

/// A formula of the next step in the list, for `restart`.
std::string next_of(const std::vector<long> &steps)
{
  std::string s;
  long last = -1;
  for (const long step : steps) {
    s += std::to_string(step) + "*(step>=" + std::to_string(last) + ")*(step<" +
        std::to_string(step) + ")+";
    last = step;
  }
  return s + "100000000*(step>=" + std::to_string(last) + ")";
}

}    // namespace

// Before anything converts, when an element is marked, when it converts, and in the middle of the
// cracks; with damping, friction and shields. Conversions, changes of joints, the ledger and
// positions are those of the uninterrupted run.
TEST(Restart, AnyStepAnyRanks)
{
  const Block plain = cracking_beam();
  constexpr long last = 250;
  State whole[5];    // by restart, from the uninterrupted run on all ranks
  std::vector<long> steps;
  {
    Block block = plain;
    block.options = "events any.txt";
    remove_file("any.txt");
    Lammps lmp;
    lmp.commands(block.script());
    bend(lmp, block);
    lmp.run(last);
    const State state = state_of(lmp, "any.txt", -1, MPI_COMM_WORLD);
    long first = 0, damage = 0;
    for (const auto &e : state.events) {
      if (!first && std::get<1>(e) == "convert") first = std::get<0>(e);
      if (!damage && std::get<1>(e) == "cohesive") damage = std::get<0>(e);
    }
    ASSERT_GT(first, 10) << "a poor example";
    ASSERT_GT(damage, 0) << "a poor example";
    steps = {first / 2, first - 1, first, std::max(damage, first + 1), 100};
    std::sort(steps.begin(), steps.end());
    ASSERT_LT(steps[3], steps[4]) << "a poor example";
    for (int k = 0; k < 5; k++) {
      whole[k] = state;
      auto &list = whole[k].events;
      list.erase(std::remove_if(list.begin(), list.end(),
                                [&](const auto &e) {
                                  return std::get<0>(e) <= steps[k];
                                }),
                 list.end());
      EXPECT_GT(list.size(), 30u) << "a poor example";
    }
  }
  const auto name = [](int ranks, long step) {
    return "any" + std::to_string(ranks) + "." + std::to_string(step);
  };
  std::set<int> written;
  for (const auto &change : changes_of_ranks()) {
    const int from = change.first, to = change.second;
    if (written.insert(from).second)
      on_ranks(from, [&](MPI_Comm comm) {
        Lammps lmp(comm);
        lmp.commands(plain.script() + "variable next equal \"" + next_of(steps) +
                     "\"\nrestart v_next any" + std::to_string(from) + ".*\n");
        bend(lmp, plain);
        lmp.run(110);
      });
    for (const bool tiled : {false, true}) {
      for (int k = 0; k < 5; k++) {
        // all steps on the same ranks; on others, and tiled, where much goes on
        if ((tiled || change != changes_of_ranks().front()) && k != 2 && k != 4) continue;
        if (tiled && k == 2) continue;
        on_ranks(to, [&](MPI_Comm comm) {
          Block block = plain;
          block.options = "events part.txt";
          remove_file("part.txt", comm);
          Lammps lmp(comm);
          lmp.commands(block.header() + (tiled ? "comm_style tiled\n" : "") + "read_restart " +
                       name(from, steps[k]) + "\n" + block.fix_only() + block.motion() +
                       (tiled ? "balance 1.0 rcb\n" : ""));
          EXPECT_EQ(lmp.step(), steps[k]);
          lmp.run(last - steps[k]);
          expect_same(whole[k], state_of(lmp, "part.txt", -1, comm),
                      "written by " + std::to_string(from) + ", read by " + std::to_string(to) +
                          " ranks at step " + std::to_string(steps[k]) + (tiled ? ", tiled" : ""));
        });
      }
    }
  }
}

// When all is broken there are only contacts: damped, with friction and histories.
TEST(Restart, WhenAllIsBroken)
{
  Block block;
  block.n[0] = block.n[1] = block.n[2] = 2;
  block.convert += " start all";
  block.coeff = "connective material cohesive 3e7 5.0 0.3 lattice contact 0.7 0.3";
  State whole;
  {
    block.options = "events broken.txt";
    remove_file("broken.txt");
    Lammps lmp;
    lmp.commands(block.script());
    lmp.change([&](Particle &p) {
      p.v = 1e4 * (p.x - block.centre()) + random_of(p.tag, 3);
    });
    lmp.run(100);
    EXPECT_EQ(lmp.fe(CONNECTIVE) + lmp.fe(COHESIVE) + lmp.fe(ELEMENTS), 0.0) << "a poor example";
    lmp.change([&](Particle &p) {    // and together again
      p.v = -5e3 * (p.x - block.centre()) + random_of(p.tag, 3);
      p.omega = 1e4 * random_of(p.tag, 4);
    });
    lmp.commands("restart 150 broken.*.restart");
    lmp.run(200);
    EXPECT_GT(lmp.fe(DAMPING), 0.0) << "a poor example";
    EXPECT_GT(lmp.fe(FRICTION), 0.0) << "a poor example";
    whole = state_of(lmp, "broken.txt", 150, MPI_COMM_WORLD);
  }
  remove_file("rest.txt");
  block.options = "events rest.txt";
  Lammps lmp;
  lmp.commands(block.header() + "read_restart broken.150.restart\n" + block.fix_only() +
               block.motion());
  EXPECT_GT(lmp.step(), 0);
  lmp.run(150);
  expect_same(whole, state_of(lmp, "rest.txt", -1, MPI_COMM_WORLD), "all broken");
}

// write_restart between runs, and a file per rank; read again with and without the files' number of
// ranks.
TEST(Restart, BetweenRunsAndInManyFiles)
{
  const Block plain = cracking_beam();
  State whole;
  {
    Block block = plain;
    block.options = "events files.txt";
    remove_file("files.txt");
    Lammps lmp;
    lmp.commands(block.script() + "restart 90 files.%.*");
    bend(lmp, block);
    lmp.run(100);
    lmp.commands("write_restart between.restart\nwrite_restart between.% fileper 2\nrestart 0");
    lmp.run(100);
    whole = state_of(lmp, "files.txt", 100, MPI_COMM_WORLD);
  }
  const int size = size_of(MPI_COMM_WORLD);
  for (const std::string file : {"between.restart", "between.%", "files.%.90"})
    for (const int ranks : {size, (size + 1) / 2})
      on_ranks(ranks, [&](MPI_Comm comm) {
        Block block = plain;
        block.options = "events parts.txt";
        remove_file("parts.txt", comm);
        Lammps lmp(comm);
        lmp.commands(block.header() + "read_restart " + file + "\n" + block.fix_only() +
                     block.motion());
        lmp.run(200 - lmp.step());
        expect_same(whole, state_of(lmp, "parts.txt", 100, comm), file);
      });
}

// The run goes beyond its last restart file and ends there. Its event file is continued from the
// restart on: nothing twice, nothing missing.
TEST(Restart, EventFileIsContinued)
{
  Block block = cracking_beam();
  block.options = "events continued.txt";
  History whole, before;
  for (const bool interrupted : {false, true}) {
    remove_file("continued.txt");
    Lammps lmp;
    lmp.commands(block.script() + "restart 120 continued.*.restart");
    bend(lmp, block);
    lmp.run(interrupted ? 150 : 200);
    MPI_Barrier(MPI_COMM_WORLD);
    (interrupted ? before : whole) = history("continued.txt");
    MPI_Barrier(MPI_COMM_WORLD);
  }
  EXPECT_GT(std::count_if(before.begin(), before.end(),
                          [](const auto &e) {
                            return std::get<0>(e) > 120;
                          }),
            5)
      << "a poor example";
  for (int again = 0; again < 2; again++) {    // it may be interrupted more than once
    Lammps lmp;
    lmp.commands(block.header() + "read_restart continued.120.restart\n" + block.fix_only() +
                 block.motion());
    lmp.run(80);
    MPI_Barrier(MPI_COMM_WORLD);
    EXPECT_EQ(history("continued.txt"), whole);
    MPI_Barrier(MPI_COMM_WORLD);
  }
}

// Elements that are left go to the data file and come back; of DEs it says what is lost.
TEST(DataFile, ElementsThatAreLeftComeBack)
{
  Block block = cracking_beam();
  std::map<int, std::vector<double>> left;
  Particles all;
  const std::string computes = "compute hexes all defe/hex/local id part\n";
  double mass = 0.0, elements_left = 0.0;
  {
    Lammps lmp;
    lmp.commands(block.script() + computes);
    bend(lmp, block);
    lmp.run(150);
    EXPECT_GT(lmp.fe(DES), 100) << "a poor example";
    EXPECT_GT(lmp.fe(CONTACT), 20) << "a poor example";
    lmp.commands("log cracked.log\nwrite_data cracked.data\nlog none");
    left = elements(lmp);
    all = lmp.particles();
    mass = total_mass(all);
    elements_left = lmp.fe(ELEMENTS);
  }
  MPI_Barrier(MPI_COMM_WORLD);
  if (rank_of(MPI_COMM_WORLD) == 0) {
    std::ifstream in("cracked.log");
    std::stringstream text;
    text << in.rdbuf();
    EXPECT_THAT(text.str(),
                HasSubstr("WARNING: Data file holds the " + std::to_string(left.size()) +
                          " finite elements"));
    EXPECT_THAT(text.str(), HasSubstr("are lost: use write_restart"));
  }
  Lammps lmp;
  lmp.commands(block.header() + block.box() + block.fix() + read_mesh("cracked.data") +
               block.motion() + computes);
  lmp.run(0);
  EXPECT_EQ(lmp.fe(ELEMENTS), elements_left);
  EXPECT_EQ(lmp.fe(DES), 0);
  EXPECT_NEAR(lmp.fe(E_ELEMENTS), 0.0, 1e-15);    // free of stress again
  const auto back = elements(lmp);
  ASSERT_EQ(back.size(), left.size());
  for (const auto &e : left) EXPECT_EQ(e.second[1], back.at(e.first)[1]) << "element " << e.first;
  const Particles again = lmp.particles();
  ASSERT_EQ(again.size(), all.size());
  EXPECT_EQ(difference(all, again, &Particle::x), 0.0);
  EXPECT_EQ(difference(all, again, &Particle::v), 0.0);
  // DEs are loose spheres now; nodes have the mass of what is left of their elements, now deformed
  EXPECT_NEAR(total_mass(again) / mass, 1.0, 1e-2);
}

// With `every 3` the clock of the finite elements stands between two evaluations.
TEST(Restart, TwoClocks)
{
  const Block plain = cracking_beam();
  State whole;
  {
    Block block = plain;
    block.options = "every 3 events clocks.txt";
    remove_file("clocks.txt");
    Lammps lmp;
    lmp.commands(block.script() + "variable next equal \"" + next_of({70, 71, 72}) +
                 "\"\nrestart v_next clocks.*\n");
    bend(lmp, block);
    lmp.run(220);
    EXPECT_GT(lmp.fe(CONVERTED), 20) << "a poor example";
    whole = state_of(lmp, "clocks.txt", 72, MPI_COMM_WORLD);
    EXPECT_GT(whole.events.size(), 30u) << "a poor example";
  }
  for (const int step : {70, 71, 72}) {
    Block block = plain;
    block.options = "every 3 events clock.txt";
    remove_file("clock.txt");
    Lammps lmp;
    lmp.commands(block.header() + "read_restart clocks." + std::to_string(step) + "\n" +
                 block.fix_only() + block.motion());
    lmp.run(220 - step);
    expect_same(whole, state_of(lmp, "clock.txt", 72, MPI_COMM_WORLD),
                "step " + std::to_string(step));
  }
}

// Records of another version would be read as nonsense.
TEST(Restart, OfAnotherVersion)
{
  const Block block = cracking_beam();
  for (const bool with_pair : {true, false}) {
    const std::string fix = with_pair ? block.fix_only()
                                      : "fix fe all defe material glass elastic 74.09e9 0.2 2500\n";
    {
      Lammps lmp;
      lmp.commands(block.header() + block.box() +
                   (with_pair
                        ? block.fix()
                        : "pair_style zero 0.004\npair_coeff * *\ngroup particles empty\n" + fix) +
                   block.mesh() + block.motion() + "run 0\nwrite_restart version.restart\n");
    }
    if (rank_of(MPI_COMM_WORLD) == 0) {
      std::fstream file("version.restart", std::ios::in | std::ios::out | std::ios::binary);
      const std::string bytes{std::istreambuf_iterator<char>(file), {}};
      const auto at = bytes.find(LAMMPS_NS::RESTART_FORMAT);
      ASSERT_NE(at, std::string::npos);
      file.seekp(static_cast<std::streamoff>(at));
      file << "DEFE 0";
    }
    MPI_Barrier(MPI_COMM_WORLD);
    Lammps lmp;
    try {
      lmp.commands(block.header() + "read_restart version.restart\n");
      EXPECT_FALSE(with_pair);    // it comes first
      lmp.commands(fix);
      FAIL();
    } catch (LAMMPS_NS::LAMMPSException &e) {
      EXPECT_THAT(e.what(),
                  HasSubstr(with_pair ? "another version of DEFE" : "another version of fix defe"));
    }
  }
}

// Elements go on as the type that they were: enhanced and plain ones have other energies at the same strain.
TEST(Restart, KeepsTheTypeOfElements)
{
  const auto fix = [](const std::string &type) {
    return "fix fe all defe material glass elastic 74.09e9 0.2 2500 " + type + "\n";
  };
  const Block block;
  const auto energy_after = [&](const std::string &before, const std::string &after) {
    {
      Lammps lmp;
      lmp.commands(block.header() + block.box() + "pair_style zero 0.004\npair_coeff * *\n" +
                   "group particles empty\n" + fix(before) + block.mesh() + block.motion());
      lmp.change([](Particle &p) {
        p.x += 1e-5 * random_of(p.tag, 1);
      });
      lmp.run(20);
      lmp.command("write_restart type.restart");
    }
    MPI_Barrier(MPI_COMM_WORLD);
    Lammps lmp;
    lmp.commands(block.header() + "read_restart type.restart\n" + fix(after) + block.motion());
    lmp.run(0);
    return lmp.fe(E_ELEMENTS);
  };
  const auto refusal = [&](const std::string &before, const std::string &after) {
    try {
      energy_after(before, after);
    } catch (LAMMPS_NS::LAMMPSException &e) {
      return std::string(e.what());
    }
    return std::string();
  };
  const double plain = energy_after("plain", "plain"), standard = energy_after("", "");
  EXPECT_EQ(energy_after("", "enhanced"), standard);
  EXPECT_GT(std::abs(plain - standard), 0.01 * plain);
  EXPECT_THAT(refusal("plain", ""),
              HasSubstr("was 'glass: elastic 74.09e9 0.2 2500' in the restart file and is 'glass: "
                        "elastic 74.09e9 0.2 2500 enhanced' now"));
  EXPECT_THAT(refusal("enhanced", "plain"), HasSubstr("in the restart file and is"));
}

// Viscoelastic elements remember their strain.
TEST(Restart, ViscoelasticElementsRememberTheirStrain)
{
  Block block;
  std::string fix = "fix fe all defe material glass prony 2e9 1100 1e6 2 3e8 2e5 1e8 1e6\n";
  const std::string made = block.header() + block.box() +
      "pair_style zero 0.001\npair_coeff * *\n" + "group particles empty\n" + fix + block.mesh() +
      block.motion();
  const auto shake = [](Particle &p) {
    p.v = 30.0 * random_of(p.tag, 2);
  };
  Particles whole;
  double total;
  {
    Lammps lmp;
    lmp.commands(made + "restart 60 prony.*");
    lmp.change(shake);
    lmp.run(200);
    whole = lmp.particles();
    total = lmp.fe(TOTAL);
  }
  for (const bool restarted : {true, false}) {
    Lammps lmp;
    if (restarted)
      lmp.commands(block.header() + "read_restart prony.60\n" + fix + block.motion());
    else {
      lmp.commands(made);
      lmp.change(shake);
      lmp.run(60);
    }
    EXPECT_EQ(lmp.step(), 60);
    lmp.run(140);
    EXPECT_LT(difference(whole, lmp.particles(), &Particle::x), same_place) << restarted;
    EXPECT_NEAR(lmp.fe(TOTAL) / total, 1.0, 1e-9) << restarted;
  }
}
