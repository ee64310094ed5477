// compute defe/fragment/atom: pieces that hold together.
//
// timeout: 240

#include "cracking_beam.h"
#include "joints.h"
#include "layers.h"

#include <cmath>
#include <set>

using namespace defe::test;
using defe::Vec3;
namespace DefeJoint = LAMMPS_NS::DefeJoint;

namespace {

using Labels = std::map<tagint, double>;

constexpr double rho = 2500.0;

/// The global vector, as in an input script: 1 fragments, 2 single DEs, 3 mass, 4 mass of single
/// DEs, 5 mass of the largest, 6 its ID.
struct Totals {
  double fragments, single, mass, single_mass, largest_mass, largest;
};

Totals totals(Lammps &lmp, const std::string &id)
{
  auto *c = lmp->modify->get_compute_by_id(id);
  c->compute_vector();
  const double *v = c->vector;
  return {v[0], v[1], v[2], v[3], v[4], v[5]};
}

/// The same on one rank from all records, by breadth-first search: lowest ID of each atom's piece.
Labels search(Lammps &lmp)
{
  const auto &store = defe_system(lmp).store;
  std::vector<LAMMPS_NS::HexPod> mine;
  for (int i = 0; i < lmp->atom->nlocal; i++)
    for (const auto &hex : store.hexes(i)) mine.push_back(hex);
  std::map<tagint, std::vector<tagint>> next;
  const auto join = [&](tagint a, tagint b) {
    next[a].push_back(b);
    next[b].push_back(a);
  };
  std::map<tagint, LAMMPS_NS::HexPod> hexes;
  for (const auto &hex : lmp.gather(mine)) {
    hexes[hex.id] = hex;
    for (tagint t : hex.node) join(hex.node[0], t);
  }
  for (const auto &it : joints(lmp)) {
    const auto &j = it.second;
    if (j.state == DefeJoint::CONTACT) continue;
    join(j.self, j.kind == DefeJoint::TIE ? hexes.at(j.other).node[0] : j.other);
  }
  Labels lowest;
  for (const auto &p : lmp.particles()) {
    if (lowest.count(p.first)) continue;
    std::vector<tagint> front = {p.first};
    lowest[p.first] = static_cast<double>(p.first);
    while (!front.empty()) {
      const tagint a = front.back();
      front.pop_back();
      for (tagint b : next[a])
        if (lowest.emplace(b, lowest[p.first]).second) front.push_back(b);
    }
  }
  return lowest;
}

/// Labels and totals against the search. Nothing but nodes and DEs is there.
void expect_right(Lammps &lmp, const std::string &id, const std::string &where)
{
  const Labels expected = search(lmp);
  EXPECT_EQ(lmp.per_atom(id), expected) << where;
  std::map<double, double> mass;
  std::map<double, int> atoms;
  double all = 0.0;
  for (const auto &p : lmp.particles()) {
    mass[expected.at(p.first)] += p.second.mass;
    atoms[expected.at(p.first)]++;
    all += p.second.mass;
  }
  Totals right{static_cast<double>(mass.size()), 0.0, all, 0.0, 0.0, 0.0};
  for (const auto &m : mass) {
    if (atoms[m.first] == 1) {
      right.single++;
      right.single_mass += m.second;
    }
    if (m.second > right.largest_mass * (1.0 + 1e-9)) right.largest = m.first;
    right.largest_mass = std::max(right.largest_mass, m.second);
  }
  const Totals found = totals(lmp, id);
  EXPECT_EQ(found.fragments, right.fragments) << where;
  EXPECT_EQ(found.single, right.single) << where;
  EXPECT_EQ(found.largest, right.largest) << where;
  EXPECT_NEAR(found.mass / right.mass, 1.0, 1e-12) << where;
  EXPECT_NEAR(found.single_mass, right.single_mass, 1e-12 * all) << where;
  EXPECT_NEAR(found.largest_mass / right.largest_mass, 1.0, 1e-12) << where;
}

/// A beam that falls to pieces in the middle: weak joints, struck hard.
Block crumbling()
{
  Block block = cracking_beam();
  block.coeff = "connective material cohesive 2e7 0.5 0.3 contact 0.9 0.2";
  block.convert = "4e7 type 2 group particles";
  return block;
}

void shake(Lammps &lmp, const Block &block)
{
  const Particles begin = lmp.particles();    // not wrapped
  lmp.change([&](Particle &p) {
    const Vec3 r = begin.at(p.tag).x - block.centre();
    const double s = r[0] / 0.004;
    p.v = Vec3(0.0, 25.0 * std::exp(-s * s), 0.0) + 0.5 * random_of(p.tag, 8);
  });
}

}    // namespace

// A block, eight DEs without joints (the pair style breaks them at once), and a rigid block: IDs are
// the lowest ones, masses those of the bodies.
TEST(FragmentAtom, BodiesAndLooseDEs)
{
  Block block;
  block.pair = "defe/contact";
  block.coeff = "contact 0.9 0.2";
  block.convert += " start corner";
  block.regions = "region corner block INF 0.002 INF 0.002 INF 0.002";
  block.options = "material ram rigid 7800";
  Lammps lmp;
  lmp.commands(block.script() +
               "create_hexes fe ram 1 x -0.01 2 -0.006 y 0 1 0.002 z 0 1 0.002\n"
               "create_atoms 1 single 0.02 0.02 0.02\n"
               "set atom 73 diameter 0.002 density 1000\n"    // a ball is no piece of anything
               "compute pieces all defe/fragment/atom\n");
  lmp.run(0);
  const double one = block.element_mass();
  const auto label = lmp.per_atom("pieces");
  const auto t = totals(lmp, "pieces");
  EXPECT_EQ(t.fragments, 10.0);
  EXPECT_EQ(t.single, 8.0);
  EXPECT_NEAR(t.single_mass / one, 1.0, 1e-13);
  EXPECT_NEAR(t.largest_mass / (23.0 * one), 1.0, 1e-13);
  EXPECT_NEAR(t.mass / (one * (24.0 + 2.0 * 7800.0 / rho)), 1.0, 1e-13);
  EXPECT_EQ(t.largest, 2.0);    // node 1 was of the converted element only
  for (const auto &p : lmp.particles()) {
    const double tag = static_cast<double>(p.first);
    if (p.first == 73)
      EXPECT_EQ(label.at(p.first), 0.0);
    else if (p.second.type == 2)
      EXPECT_EQ(label.at(p.first), tag);
    else
      EXPECT_EQ(label.at(p.first), p.first <= 60 ? 2.0 : 61.0) << p.first;
  }
}

// A serpentine: one body, which crosses the borders between ranks again and again, so that no rank
// has more than loose ends of it. Cut in the middle it is two, equal in mass: the largest is the one
// of the lower ID.
TEST(FragmentAtom, SerpentineOverManyBorders)
{
  const int n = 12, rows = 7;    // rows of n elements, joined at alternating ends
  const double h = 2e-3;
  for (const bool cut : {false, true}) {
    MeshFile mesh;
    mesh.add_block("glass", 1, n, 2 * rows - 1, 1, h, [](const Vec3 &X) {
      return X;
    });
    MeshFile snake = mesh;
    snake.hex.clear();
    snake.part.clear();
    std::set<tagint> used;
    for (int j = 0; j < 2 * rows - 1; j++)
      for (int i = 0; i < n; i++) {
        const bool row = j % 2 == 0, link = !row && i == (j % 4 == 1 ? n - 1 : 0);
        if (!row && !link) continue;
        if (cut && j == rows - 1 && i > 4 && i < 7) continue;    // two elements of the middle row
        snake.hex.push_back(mesh.hex[j * n + i]);
        snake.part.push_back("glass");
        for (tagint t : snake.hex.back()) used.insert(t);
      }
    // nodes without elements are refused: number those that are left anew
    std::map<tagint, tagint> number;
    MeshFile left = snake;
    left.X.clear();
    left.type.clear();
    for (tagint t : used) {
      left.X.push_back(mesh.X[t - 1]);
      left.type.push_back(1);
      number[t] = static_cast<tagint>(left.X.size());
    }
    for (auto &hex : left.hex)
      for (tagint &t : hex) t = number.at(t);
    left.hi = Vec3(0.04, 0.04, 0.01);
    left.lo = Vec3(-0.01, -0.01, -0.01);
    left.write("serpentine.data");

    const std::string np = std::to_string(size_of(MPI_COMM_WORLD));
    for (const std::string &grid : {std::string("* * *"), np + " 1 1", "1 " + np + " 1"}) {
      SCOPED_TRACE(grid + (cut ? ", cut" : ""));
      Block block;
      block.processors = grid;
      block.box_lo[0] = block.box_lo[1] = block.box_lo[2] = -0.01;
      block.box_hi[0] = block.box_hi[1] = 0.04;
      block.box_hi[2] = 0.01;
      Lammps lmp;
      lmp.commands(block.header() + block.box() + block.fix() + read_mesh("serpentine.data") +
                   block.motion() + "compute pieces all defe/fragment/atom\n");
      lmp.run(0);
      const auto t = totals(lmp, "pieces");
      const double m = block.element_mass() * static_cast<double>(left.hex.size());
      EXPECT_EQ(t.fragments, cut ? 2.0 : 1.0);
      EXPECT_NEAR(t.largest_mass / m, cut ? 0.5 : 1.0, 1e-12);
      EXPECT_EQ(t.largest, 1.0);
      expect_right(lmp, "pieces", grid);
    }
  }
}

// Two elements that share an edge only, at the line where four ranks meet: the ranks of the two know
// of each other through a third.
TEST(FragmentAtom, AcrossTheCornerOfFourRanks)
{
  const double h = 2e-3;
  MeshFile mesh;
  const auto brick = [&](double x, double y, bool first) {
    std::array<tagint, 8> nodes;
    for (int a = 7; a >= 0;
         a--) {    // the shared nodes have neither the lowest nor the highest IDs
      const Vec3 X(x + 0.5 * h * defe::fe::hex_sign[a][0], y + 0.5 * h * defe::fe::hex_sign[a][1],
                   0.5 * h * defe::fe::hex_sign[a][2]);
      tagint found = 0;
      for (size_t k = 0; k < mesh.X.size() && !first; k++)
        if ((mesh.X[k] - X).norm() < 1e-9) found = static_cast<tagint>(k) + 1;
      if (!found) {
        mesh.X.push_back(X);
        mesh.type.push_back(1);
        found = static_cast<tagint>(mesh.X.size());
      }
      nodes[a] = found;
    }
    mesh.hex.push_back(nodes);
    mesh.part.push_back("glass");
  };
  brick(0.5 * h, 0.5 * h, true);
  brick(-0.5 * h, -0.5 * h, false);
  ASSERT_EQ(mesh.X.size(), 14u);
  mesh.lo = Vec3::Constant(-0.01);
  mesh.hi = Vec3::Constant(0.01);
  mesh.write("edge.data");
  Block block;
  const int np = size_of(MPI_COMM_WORLD);
  block.processors = np == 4 ? "2 2 1" : std::to_string(np) + " 1 1";
  for (int k = 0; k < 3; k++) block.box_hi[k] = -(block.box_lo[k] = -0.01);
  Lammps lmp;
  lmp.commands(block.header() + block.box() + block.fix() + read_mesh("edge.data") +
               block.motion() + "compute pieces all defe/fragment/atom\n");
  lmp.run(0);
  for (const auto &p : lmp.per_atom("pieces")) EXPECT_EQ(p.second, 1.0) << p.first;
  EXPECT_EQ(totals(lmp, "pieces").fragments, 1.0);
}

// All the way through a body that falls to pieces, against a search on one rank in all records; also
// cut in slices, in tiles, and with periodic borders that the body lies across.
TEST(FragmentAtom, PiecesAreThoseOfASearchOnOneRank)
{
  const std::string np = std::to_string(size_of(MPI_COMM_WORLD));
  struct Way {
    std::string processors, style, boundary, before;
  };
  for (const Way &way :
       {Way{"* * *", "", "f f f", ""}, Way{np + " 1 1", "", "p p p", ""},
        Way{"1 " + np + " 1", "", "f f f", ""},
        Way{"* * *", "comm_style tiled", "f f f", "fix balance all balance 20 1.0 rcb"}}) {
    SCOPED_TRACE(way.processors + " " + way.style + " " + way.boundary);
    Block block = crumbling();
    block.processors = way.processors;
    block.boundary = way.boundary;
    if (way.boundary == "p p p")
      for (int k = 0; k < 3; k++) {    // the beam lies across all of its borders
        block.box_lo[k] = 0.001 - (k == 0 ? 0.02 : 0.01);
        block.box_hi[k] = block.box_lo[k] + (k == 0 ? 0.06 : 0.03);
        block.lo[k] = block.box_hi[k] - 0.003;
      }
    Lammps lmp;
    lmp.commands(block.header() + way.style + "\n" + block.box() + block.fix() + block.mesh() +
                 block.motion() + way.before + "\ncompute pieces all defe/fragment/atom\n");
    shake(lmp, block);
    lmp.run(0);
    expect_right(lmp, "pieces", "start");
    EXPECT_EQ(totals(lmp, "pieces").fragments, 1.0);
    for (int k = 1; k <= 10; k++) {
      lmp.run(30);
      expect_right(lmp, "pieces", "step " + std::to_string(30 * k));
    }
    const auto t = totals(lmp, "pieces");
    EXPECT_GT(t.single, 5.0) << "a poor example";
    EXPECT_GT(t.fragments - t.single, 5.0) << "a poor example";
    EXPECT_GT(lmp.fe(TIES), 0.0) << "a poor example";
    EXPECT_GT(lmp.fe(ELEMENTS), 0.0) << "a poor example";
  }
}

// Every step of a run: what is kept from the step before is thrown away when a joint breaks.
TEST(FragmentAtom, EveryStepAsIfNew)
{
  const Block block = crumbling();
  std::vector<std::vector<double>> kept, anew;
  for (const bool all_steps : {true, false}) {
    Lammps lmp;
    lmp.commands(block.script() + "compute pieces all defe/fragment/atom\n");
    shake(lmp, block);
    if (all_steps) {
      lmp.record({"c_pieces[1]", "c_pieces[2]", "c_pieces[6]"}, 1);
      lmp.run(120);
      for (int k = 0; k < 3; k++) kept.push_back(lmp.recorded(k));
    } else
      for (int step = 0; step <= 120; step++) {
        lmp.run(step > 0);    // a setup before each
        const auto t = totals(lmp, "pieces");
        anew.resize(3);
        anew[0].push_back(t.fragments);
        anew[1].push_back(t.single);
        anew[2].push_back(t.largest);
      }
  }
  EXPECT_EQ(kept, anew);
  std::set<double> numbers(kept[0].begin(), kept[0].end());
  EXPECT_GT(numbers.size(), 5u) << "a poor example";
}

// Bonded layers glass, film, glass: one piece; the glass alone is two; a layer that is torn is two
// of its own while the film holds them. Masses are those of the layers, though nodes are shared.
TEST(FragmentAtom, PartsAndGroups)
{
  const double h = 2e-3;
  const auto mesh = layered({{"lower", h, 1}, {"film", 1e-3, 1}, {"upper", h, 1}},
                            equidistant(0.0, 0.02, 10), equidistant(0.0, 0.004, 2), 2);
  mesh.write("layers.data");
  Lammps lmp;
  lmp.commands(script_head() + R"(
    region          box block -0.01 0.03 -0.01 0.02 -0.01 0.02
    create_box      2 box
    region          middle block 0.008 0.010 INF INF INF INF
    pair_style      defe/joint
    pair_coeff      2 2 connective material cohesive 1e3 1e-9 0.1 lattice contact 0.9 0.2
    group           particles empty
    fix             fe all defe material glass elastic 74.09e9 0.2 2500 part lower glass part upper glass &
                                material film elastic 1e9 0.4 1100 &
                                convert lower 1e12 type 2 group particles start middle
    )" + read_mesh("layers.data") +
               R"(
    group           nodes type 1
    region          top block INF INF 0.0025 INF INF INF
    group           top region top
    fix             move1 nodes nve
    fix             move2 particles nve/sphere
    neighbor        0.0003 bin
    timestep        5e-8
    compute         all all defe/fragment/atom
    compute         lower all defe/fragment/atom part lower
    compute         glass all defe/fragment/atom part lower part upper
    compute         film all defe/fragment/atom part film
    compute         top top defe/fragment/atom
    compute         nodes nodes defe/fragment/atom part lower
    )");
  const double layer = rho * 0.02 * h * 0.004, film = 1100.0 * 0.02 * 1e-3 * 0.004;
  const auto expect = [&](const std::string &id, double fragments, double mass, double largest) {
    const auto t = totals(lmp, id);
    EXPECT_EQ(t.fragments, fragments) << id;
    EXPECT_NEAR(t.mass / mass, 1.0, 1e-12) << id;
    EXPECT_NEAR(t.largest_mass / largest, 1.0, 1e-12) << id;
  };
  lmp.run(0);
  ASSERT_EQ(lmp.fe(CONVERTED), 2.0);
  expect("all", 1.0, 2.0 * layer + film, 2.0 * layer + film);
  expect("lower", 1.0, layer, layer);
  expect("glass", 2.0, 2.0 * layer, layer);
  expect("film", 1.0, film, film);
  expect("top", 1.0, layer, layer);                  // its elements with all nodes there
  expect("nodes", 2.0, 0.9 * layer, 0.5 * layer);    // without the DEs in between
  // pulled along x, the joints of the 16 DEs break
  lmp.change([&](Particle &p) {
    if (p.x[1] < 0.0019) p.v[0] = 5.0 * (p.x[0] / 0.009 - 1.0);
  });
  lmp.run(60);
  ASSERT_GT(lmp.fe(CONTACT), 8.0) << "a poor example";
  const auto t = totals(lmp, "all"), lower = totals(lmp, "lower");
  EXPECT_EQ(t.fragments, 1.0);    // ties to the film hold
  EXPECT_GE(lower.fragments, 2.0);
  EXPECT_NEAR(lower.mass / layer, 1.0, 1e-12);
  const auto label = lmp.per_atom("lower"), whole = lmp.per_atom("all");
  tagint left = 0, right = 0;
  for (const auto &p : lmp.particles()) {
    EXPECT_EQ(whole.at(p.first), 1.0);
    if (p.second.x[1] > 0.0025 || p.second.type == 2) continue;
    if (p.second.x[0] < 1e-4) left = p.first;
    if (p.second.x[0] > 0.0199) right = p.first;
  }
  EXPECT_GT(label.at(left), 0.0);
  EXPECT_GT(label.at(right), 0.0);
  EXPECT_NE(label.at(left), label.at(right));
  EXPECT_EQ(lmp.value("C_lower[" + std::to_string(left) + "]"), label.at(left));
}

// As the page shows: masses and centres of the pieces by compute chunk/atom.
TEST(FragmentAtom, ChunksOfLammps)
{
  const Block block = crumbling();
  Lammps lmp;
  lmp.commands(block.script() + R"(
    compute         pieces all defe/fragment/atom
    compute         chunk all chunk/atom c_pieces nchunk every compress yes
    compute         mass all property/atom mass
    compute         masses all reduce/chunk chunk sum c_mass
    compute         ids all reduce/chunk chunk max c_pieces
    compute         velocities all vcm/chunk chunk
    fix             out all ave/time 100 1 100 c_masses mode vector file masses.txt
    thermo_style    custom step c_pieces[1] c_pieces[5]
    )");
  shake(lmp, block);
  lmp.run(300);
  const auto label = lmp.per_atom("pieces");
  std::map<double, double> mass;
  for (const auto &p : lmp.particles()) mass[label.at(p.first)] += p.second.mass;
  auto *masses = lmp->modify->get_compute_by_id("masses"),
       *ids = lmp->modify->get_compute_by_id("ids");
  masses->compute_vector();
  ids->compute_vector();
  ASSERT_EQ(masses->size_vector, static_cast<int>(mass.size()));
  EXPECT_GT(mass.size(), 10u) << "a poor example";
  double largest = 0.0;
  for (int k = 0; k < masses->size_vector; k++) {
    EXPECT_NEAR(masses->vector[k] / mass.at(ids->vector[k]), 1.0, 1e-12);
    largest = std::max(largest, masses->vector[k]);
  }
  EXPECT_NEAR(lmp.value("c_pieces[5]") / largest, 1.0, 1e-12);
}

// The compute keeps nothing over a restart; the pieces come out of the joints.
TEST(FragmentAtom, OverARestart)
{
  const Block block = crumbling();
  Labels whole, middle;
  const std::string compute = "compute pieces all defe/fragment/atom\n";
  {
    Lammps lmp;
    lmp.commands(block.script() + compute);
    shake(lmp, block);
    lmp.run(150);
    lmp.command("write_restart pieces.restart");
    middle = lmp.per_atom("pieces");
    lmp.run(60);
    whole = lmp.per_atom("pieces");
  }
  Lammps lmp;
  lmp.commands(block.header() + "read_restart pieces.restart\n" + block.fix_only() +
               block.motion() + compute);
  lmp.run(0);
  EXPECT_EQ(lmp.per_atom("pieces"), middle);
  lmp.run(60);
  EXPECT_EQ(lmp.per_atom("pieces"), whole);
  EXPECT_GT(totals(lmp, "pieces").fragments, 10.0) << "a poor example";
  EXPECT_NE(whole, middle) << "a poor example";
}
