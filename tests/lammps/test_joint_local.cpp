// compute defe/joint/local: what a joint carries, against closed forms.
//
// timeout: 240

#include "cracking_beam.h"
#include "joints.h"
#include "mesh_file.h"

#include <cmath>
#include <fstream>
#include <set>

using namespace defe::test;
using defe::Mat3;
using defe::Vec3;

namespace {

const std::string everything = "compute joints all defe/joint/local id1 id2 kind state part damage "
                               "opening slip tn ts x y z nx ny nz area length length0\n";

struct Row {
  tagint id1, id2;
  int kind, state, part;    // kind 1 joint, 2 tie; state 0 connective, 1 cohesive
  double damage, opening, slip, tn, ts;
  Vec3 point, normal;
  double area, length, length0;
};

/// All rows, by both IDs; each joint is there once.
std::map<std::pair<tagint, tagint>, Row> rows(Lammps &lmp)
{
  std::map<std::pair<tagint, tagint>, Row> result;
  for (const auto &v : lmp.local("joints")) {
    Row r{static_cast<tagint>(v[0]),
          static_cast<tagint>(v[1]),
          static_cast<int>(v[2]),
          static_cast<int>(v[3]),
          static_cast<int>(v[4]),
          v[5],
          v[6],
          v[7],
          v[8],
          v[9],
          Vec3(v[10], v[11], v[12]),
          Vec3(v[13], v[14], v[15]),
          v[16],
          v[17],
          v[18]};
    if (r.kind == 1) { EXPECT_LT(r.id1, r.id2); }
    // an element and a DE may have one ID
    EXPECT_TRUE(result.emplace(std::make_pair(r.id1, r.kind == 1 ? r.id2 : -r.id2), r).second)
        << r.id1 << " " << r.id2 << " twice";
  }
  return result;
}

/// As many of each kind and state as the fix counts.
void expect_counts(Lammps &lmp, const std::string &where)
{
  double count[2][2] = {{0.0, 0.0}, {0.0, 0.0}};
  for (const auto &r : rows(lmp)) count[r.second.kind - 1][r.second.state]++;
  EXPECT_EQ(count[0][0], lmp.fe(CONNECTIVE)) << where;
  EXPECT_EQ(count[0][1], lmp.fe(COHESIVE)) << where;
  EXPECT_EQ(count[1][0], lmp.fe(TIES)) << where;
  EXPECT_EQ(count[1][1], lmp.fe(TIES_SOFTENING)) << where;
}

double lambda_of(const Block &b)
{
  return b.E * b.nu / ((1.0 + b.nu) * (1.0 - 2.0 * b.nu));
}
double mu_of(const Block &b)
{
  return 0.5 * b.E / (1.0 + b.nu);
}

/// First Piola-Kirchhoff stress of the St Venant-Kirchhoff solid.
Mat3 nominal(const Mat3 &F, const Block &block)
{
  const Mat3 green = 0.5 * (F.transpose() * F - Mat3::Identity());
  return F * (lambda_of(block) * green.trace() * Mat3::Identity() + 2.0 * mu_of(block) * green);
}

/// 4 x 4 x 4 elements, the eight in the middle converted: every DE has six joints or ties.
Block core()
{
  Block block;
  block.n[0] = block.n[1] = block.n[2] = 4;
  block.options = "kernel lagrangian";
  block.regions = "region core block 0.002 0.006 0.002 0.006 0.002 0.006";
  block.convert += " start core";
  return block;
}

}    // namespace

// Uniform strain: a joint carries P N, with P the first Piola-Kirchhoff stress and N the reference
// normal: force over reference area. Under uniaxial strain eps that is (lambda + 2 mu) eps along it
// and lambda eps across it.
TEST(JointLocal, TractionIsThatOfTheContinuum)
{
  const Block block = core();
  const double eps = 1e-6;
  Mat3 uniaxial = Mat3::Identity(), any;
  uniaxial(0, 0) += eps;
  any << 1.006, 0.004, -0.002, 0.0, 0.998, 0.003, 0.001, 0.0, 1.003;
  for (const Mat3 &F : {uniaxial, any}) {
    Lammps lmp;
    lmp.commands(block.script() + everything +
                 "compute ends all defe/joint/local id1 id2 kind atom2\n");
    lmp.run(0);
    const Particles begin = lmp.particles();
    for (const auto &row : lmp.local("ends")) {
      if (row[2] == 1.0) {
        EXPECT_EQ(row[3], row[1]);
        continue;
      }
      // the corner of the cube that the DE stands for, of h/2
      const Vec3 out = begin.at(row[3]).x - begin.at(row[0]).x;
      EXPECT_LT((out.cwiseAbs() - Vec3::Constant(0.25 * block.h)).norm(), 1e-15) << row[0];
      EXPECT_EQ(begin.at(row[3]).radius, 0.0);
    }
    const Vec3 c = block.centre();
    lmp.change([&](Particle &p) {
      p.x = c + F * (p.x - c);
    });
    lmp.run(0);
    const auto all = rows(lmp);
    ASSERT_EQ(all.size(), 3u * 3u * 4u * 4u + 6u * 4u * 4u);
    expect_counts(lmp, "");
    const Mat3 P = nominal(F, block);
    const double tolerance = 1e-9 * P.norm() + 1e-13 * block.E;    // rounding of positions
    const double d = 0.5 * block.h;
    for (const auto &it : all) {
      const Row &r = it.second;
      const Vec3 n = F.inverse() * r.normal;
      int axis;
      n.cwiseAbs().maxCoeff(&axis);
      const Vec3 N = (n[axis] > 0.0 ? 1.0 : -1.0) * Vec3::Unit(axis);
      const double reach = r.kind == 1 ? d : 0.5 * d;
      const Vec3 along = (F * N).normalized();
      const Vec3 normal = r.kind == 1 ? along : Vec3(F.inverse().transpose() * N).normalized();
      const Vec3 t = P * N;
      EXPECT_LT((r.normal - normal).norm(), 1e-12);
      EXPECT_NEAR(r.tn, t.dot(normal), tolerance);
      EXPECT_NEAR(r.ts, (t - t.dot(normal) * normal).norm(), tolerance);
      EXPECT_NEAR(r.area / (d * d), 1.0, 1e-12);
      EXPECT_NEAR(r.length0 / reach, 1.0, 1e-12);
      EXPECT_NEAR(r.length / (F * N).norm() / reach, 1.0, 1e-12);
      const Vec3 X = begin.at(r.id1).x + 0.5 * d * N;    // on the border of the two cells
      EXPECT_LT((r.point - c - F * (X - c)).norm(), 1e-16);
      EXPECT_EQ(r.state, 0);
      EXPECT_EQ(r.part, 1);
      EXPECT_EQ(r.damage + r.opening + r.slip, 0.0);
      if (&F == &uniaxial || F == uniaxial) {
        const double expected =
            (axis == 0 ? lambda_of(block) + 2.0 * mu_of(block) : lambda_of(block)) * eps;
        EXPECT_NEAR(r.tn / expected, 1.0, 10.0 * eps);
      }
      if (r.kind == 1) {
        EXPECT_LT((begin.at(r.id2).x - begin.at(r.id1).x - d * N).norm(), 1e-15);
      } else {
        // the tied element is the one behind
        const Vec3 E = block.element_centre((r.id2 - 1) % 4, (r.id2 - 1) / 4 % 4, (r.id2 - 1) / 16);
        EXPECT_LT((E - begin.at(r.id1).x).cwiseAbs().maxCoeff(), 0.8 * block.h);
        EXPECT_NEAR((E - X)[axis] * N[axis] / block.h, 0.5, 1e-9);
      }
    }
  }
}

// Sheared elements: joints are not perpendicular to the faces that they cross; the whole traction is
// that of the continuum all the same.
TEST(JointLocal, TractionIsThatOfTheContinuumInSkewElements)
{
  Block block = core();
  MeshFile mesh;
  Mat3 shear = Mat3::Identity();
  shear(0, 1) = 0.25;
  shear(2, 0) = -0.15;
  mesh.add_block("glass", 1, 4, 4, 4, block.h, [&](const Vec3 &X) {
    return Vec3(shear * X);
  });
  mesh.write("skew.data");
  std::vector<Vec3> centres;
  for (int k = 1; k < 3; k++)
    for (int j = 1; j < 3; j++)
      for (int i = 1; i < 3; i++) centres.push_back(shear * block.element_centre(i, j, k));
  block.regions = region_of("core", centres, block.h);
  Mat3 F;
  F << 1.006, 0.004, -0.002, 0.0, 0.998, 0.003, 0.001, 0.0, 1.003;
  Lammps lmp;
  lmp.commands(block.header() + block.box() + block.fix() + read_mesh("skew.data") +
               block.motion() + everything);
  lmp.run(0);
  lmp.change([&](Particle &p) {
    p.x = F * p.x;
  });
  lmp.run(0);
  const auto all = rows(lmp);
  ASSERT_EQ(all.size(), 3u * 3u * 4u * 4u + 6u * 4u * 4u);
  const Mat3 P = nominal(F, block);
  double sum = 0.0, expected = 0.0;
  for (const auto &it : all) {
    const Row &r = it.second;
    // reference normal of a face: a row of the inverse of the shear
    double nearest = 1e300;
    for (int axis = 0; axis < 3; axis++) {
      const double t = (P * shear.inverse().transpose().col(axis).normalized()).norm();
      nearest = std::min(nearest, std::abs(std::hypot(r.tn, r.ts) - t));
    }
    EXPECT_LT(nearest, 1e-9 * P.norm()) << r.id1 << " " << r.id2;
    sum += r.area;
  }
  for (int axis = 0; axis < 3; axis++)
    expected +=
        5.0 * 16.0 * 0.25 * block.h * block.h * shear.inverse().transpose().col(axis).norm();
  EXPECT_NEAR(sum / expected, 1.0, 1e-12);    // det(shear) = 1
}

// A bar, stretched unevenly along its axis: through every section goes the force that the atoms on
// one side of it feel, be it a section of joints or of ties.
TEST(JointLocal, ForceThroughASectionIsThatOnOneSideOfIt)
{
  Block block;
  block.nu = 0.0;
  block.n[0] = 6;
  block.n[1] = block.n[2] = 2;
  block.regions = "region middle block 0.004 0.008 INF INF INF INF";
  block.convert += " start middle";
  Lammps lmp;
  lmp.commands(block.script() + everything);
  lmp.run(0);
  const Particles begin = lmp.particles();
  lmp.change([&](Particle &p) {
    const double s = p.x[0] / 0.012;
    p.x[0] += 1e-6 * std::sin(5.0 * s) + 2e-6 * s * s;
  });
  lmp.run(0);
  const Particles now = lmp.particles();
  std::map<int, double> through, sections;    // by X in quarters of a millimetre
  for (const auto &it : rows(lmp)) {
    const Row &r = it.second;
    if (std::abs(r.normal[0]) < 0.9) continue;
    EXPECT_LT(r.ts, 1e-3 * block.E * 1e-6);
    const double X = begin.at(r.id1).x[0] + 0.5e-3 * (r.normal[0] > 0.0 ? 1.0 : -1.0);
    through[static_cast<int>(std::lround(4e3 * X))] += r.tn * r.area;
    sections[static_cast<int>(std::lround(4e3 * X))] += r.area;
  }
  ASSERT_EQ(through.size(), 5u);    // 4 to 8 mm, the first and the last of ties
  for (const auto &s : through) {
    EXPECT_NEAR(sections[s.first], 16e-6, 1e-15);
    double left = 0.0;
    for (const auto &p : now) {
      // at the borders to the elements, the nodes of the face are on the elements' side
      const double X = begin.at(p.first).x[0], at = s.first / 4e3;
      const bool in = std::abs(X - at) < 1e-9 ? at < 0.006 : X < at;
      if (in) left += p.second.f[0];
    }
    EXPECT_NEAR(s.second / left, 1.0, 1e-9) << "section at " << s.first / 4.0 << " mm";
    EXPECT_GT(std::abs(left), 10.0) << "a poor example";
  }
}

// Softening joints and ties follow the law: t_n = s0 (1 - D) opening/kappa, kappa = s0/k_n + D delta_c,
// and the strength at the switch s0 is what the event file says.
TEST(JointLocal, SofteningFollowsTheLaw)
{
  const double sigma = 6e7, G_f = 10.0, bond = 2e7, peel = 5.0, h = 2e-3;
  MeshFile mesh;
  mesh.add_block("glass", 1, 6, 3, 2, h, [](const Vec3 &X) {
    return X;
  });
  for (int k = 0; k < 2; k++)    // the lower row is another part
    for (int i = 0; i < 6; i++) mesh.part[k * 18 + i] = "base";
  mesh.write("two.data");
  Block block;
  block.dt = 2e-8;
  block.coeff = "connective material cohesive " + number(sigma) + " " + number(G_f) +
      " 0.1 lattice contact 0.9 0.2";
  block.convert += " start all";
  block.options = "part base glass adhesive glass base " + number(bond) + " " + number(peel) +
      " 0.5 events softening.txt";
  remove_file("softening.txt");
  Lammps lmp;
  lmp.commands(block.header() + block.box() + block.fix() + read_mesh("two.data") + block.motion() +
               everything);
  const Vec3 c = block.centre();
  lmp.run(0);
  lmp.change([&](Particle &p) {
    p.v = Vec3(5.0 * (p.x[0] - c[0]) / h, 4.0 * p.x[1] / h, 0.0) + 0.5 * random_of(p.tag, 3);
  });
  const double lambda = lambda_of(block), mu = mu_of(block);
  std::set<std::pair<tagint, tagint>> seen;
  int loading = 0, unloading = 0, ties = 0;
  const double digits = 5e-6;    // the event file writes s0 with six of them
  for (int step = 0; step < 60; step++) {
    lmp.run(5);
    MPI_Barrier(MPI_COMM_WORLD);
    std::map<std::pair<tagint, tagint>, double> s0;
    for (const auto &e : read_events("softening.txt"))
      if (e.what == "cohesive" || e.what == "adhesive") s0[{e.a, e.b}] = e.value;
    for (const auto &it : rows(lmp)) {
      const Row &r = it.second;
      if (r.state == 0) continue;
      const bool tie = r.kind == 2;
      ASSERT_TRUE(s0.count({r.id1, r.id2}));
      const double s = s0.at({r.id1, r.id2}), k_n = (lambda + 2.0 * mu) / r.length0,
                   k_s = mu / r.length0;
      const double delta_c = 2.0 * (tie ? peel : G_f) / s, kappa = s / k_n + r.damage * delta_c;
      EXPECT_GE(r.damage, 0.0);
      EXPECT_LT(r.damage, 1.0);
      const double intact = s * (1.0 - r.damage) / kappa;
      if (r.opening > 0.0)
        EXPECT_NEAR(r.tn, intact * r.opening, digits * s);
      else
        EXPECT_NEAR(r.tn, block.E / r.length0 * r.opening, digits * s);
      EXPECT_NEAR(r.ts, intact * k_s / k_n * r.slip, digits * s);
      const double beta = tie ? 0.5 : 0.1;
      const double stretch = std::hypot(std::max(r.opening, 0.0), beta * k_s / k_n * r.slip);
      EXPECT_LE(stretch, kappa * (1.0 + digits));
      (stretch > kappa * (1.0 - digits) ? loading : unloading)++;
      ties += tie;
    }
    expect_counts(lmp, "step " + std::to_string(lmp.step()));
  }
  EXPECT_GT(loading, 20) << "a poor example";
  EXPECT_GT(unloading, 20) << "a poor example";
  EXPECT_GT(ties, 20) << "a poor example";
  EXPECT_GT(lmp.fe(CONTACT), 0.0) << "a poor example";
}

/// The same rows on any number of ranks, and after a restart in the middle.
static void expect_the_same_on_any_ranks_and_over_a_restart(const std::string &curve)
{
  Block block = cracking_beam();
  block.coeff = "connective material cohesive 6e7 20.0 0.1 " + curve + " contact 0.9 0.2";
  struct Flat {
    tagint a, b;
    int kind, state;
    double value[8];
  };
  const auto flat = [](Lammps &lmp) {
    std::vector<Flat> list;
    for (const auto &it : rows(lmp)) {
      const Row &r = it.second;
      list.push_back({r.id1,
                      r.id2,
                      r.kind,
                      r.state,
                      {r.damage, r.tn, r.ts, r.opening, r.slip, r.point[0], r.point[1], r.length}});
    }
    return list;
  };
  const auto expect_same = [](const std::vector<Flat> &a, const std::vector<Flat> &b,
                              const std::string &what) {
    const double tolerance[8] = {1e-6, 1.0, 1.0, 1e-13, 1e-13, 1e-12, 1e-12, 1e-12};    // of 6e7 Pa
    ASSERT_EQ(a.size(), b.size()) << what;
    for (size_t k = 0; k < a.size(); k++) {
      EXPECT_EQ(a[k].a, b[k].a) << what;
      EXPECT_EQ(a[k].b, b[k].b) << what;
      EXPECT_EQ(a[k].kind, b[k].kind) << what;
      EXPECT_EQ(a[k].state, b[k].state) << what;
      for (int v = 0; v < 8; v++)
        EXPECT_NEAR(a[k].value[v], b[k].value[v], tolerance[v])
            << what << ", value " << v << " of " << a[k].a << " " << a[k].b;
    }
  };
  const auto whole = [&](MPI_Comm comm, const std::string &file) {
    std::vector<Flat> middle, last;
    Lammps lmp(comm);
    lmp.commands(block.script() + everything);
    bend(lmp, block);
    lmp.run(100);
    middle = flat(lmp);
    expect_counts(lmp, "middle");
    if (!file.empty()) lmp.command("write_restart " + file);
    lmp.run(60);
    last = flat(lmp);
    EXPECT_GT(lmp.fe(COHESIVE), 5.0) << "a poor example";
    EXPECT_GT(lmp.fe(TIES), 20.0) << "a poor example";
    return std::make_pair(middle, last);
  };
  const auto here = whole(MPI_COMM_WORLD, "joints.restart");
  std::pair<std::vector<Flat>, std::vector<Flat>> alone;
  if (rank_of(MPI_COMM_WORLD) == 0) {
    alone = whole(MPI_COMM_SELF, "");
    expect_same(here.first, alone.first, "one rank, in the middle");
    expect_same(here.second, alone.second, "one rank, at the end");
  }
  MPI_Barrier(MPI_COMM_WORLD);
  Lammps lmp;
  lmp.commands(block.header() + "read_restart joints.restart\n" + block.fix_only() +
               block.motion() + everything);
  lmp.run(0);
  expect_same(here.first, flat(lmp), "restart, in the middle");
  lmp.run(60);
  expect_same(here.second, flat(lmp), "restart, at the end");
}

TEST(JointLocal, AnyRanksAndOverARestart)
{
  expect_the_same_on_any_ranks_and_over_a_restart("linear");
}

TEST(JointLocal, ExponentialSofteningOnAnyRanksAndOverARestart)
{
  expect_the_same_on_any_ranks_and_over_a_restart("exponential");
}

// Only joints both of whose DEs are in the group; dump local, compute reduce and fix ave/histo take it.
TEST(JointLocal, GroupsAndOutputOfLammps)
{
  const Block block = core();
  const double eps = 1e-4;
  Lammps lmp;
  lmp.commands(block.script() + everything + R"(
    region          left block INF 0.004 INF INF INF INF
    compute         t all defe/joint/local tn
    compute         a all defe/joint/local tn area
    compute         most all reduce max c_t inputs local
    compute         areas all reduce sum c_a[2] inputs local
    fix             histogram all ave/histo 1 1 1 -1e8 1e8 4 c_t kind local mode vector
    dump            rows all local 1 joints.dump index c_joints[1] c_joints[2] c_joints[9]
    thermo_style    custom step c_most c_areas
    )");
  lmp.run(0);
  const Vec3 c = block.centre();
  lmp.change([&](Particle &p) {
    p.x[0] = c[0] + (1.0 + eps) * (p.x[0] - c[0]);
  });
  lmp.commands("group left region left\ncompute left left defe/joint/local id1\n");
  lmp.run(0);
  // the left half: 2 x 4 x 4 DEs
  EXPECT_EQ(lmp.local("left").size(), 16u + 2u * 2u * 3u * 4u + (16u + 4u * 2u * 4u));
  const double expected =
      (1.0 + eps) * (lambda_of(block) + 2.0 * mu_of(block)) * (eps + 0.5 * eps * eps);
  EXPECT_NEAR(lmp.value("c_most") / expected, 1.0, 1e-9);
  EXPECT_NEAR(lmp.value("c_areas") / (240.0 * 0.25 * block.h * block.h), 1.0, 1e-12);
  lmp.command("undump rows");
  MPI_Barrier(MPI_COMM_WORLD);
  std::ifstream in("joints.dump");
  std::string line;
  int entries = 0;
  while (std::getline(in, line))
    if (!line.empty() && line.find("ITEM") == std::string::npos &&
        std::count(line.begin(), line.end(), ' ') >= 3)
      entries++;
  EXPECT_EQ(entries, 240);    // LAMMPS writes a step once
  auto *histogram = lmp->modify->get_fix_by_id("histogram");
  EXPECT_EQ(histogram->compute_vector(0), 240.0);
}
