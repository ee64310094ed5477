// What LAMMPS' own output sees: energy, pressure, stresses per node and per element, damage, events
// and the pictures' triangles.
//
// timeout: 120

#include "events.h"
#include "glass_block.h"

#include <Eigen/Eigenvalues>

#include <cmath>
#include <set>

using namespace defe::test;
using defe::Mat3;
using defe::Vec3;

namespace {

Mat3 gradient()
{
  Mat3 F;
  F << 1.006, 0.004, -0.002, 0.0, 0.998, 0.003, 0.001, 0.0, 1.003;
  return F;
}

/// Cauchy stress of the St Venant-Kirchhoff solid.
Mat3 cauchy(const Mat3 &F, const Block &block)
{
  const double lambda = block.E * block.nu / ((1.0 + block.nu) * (1.0 - 2.0 * block.nu));
  const double mu = 0.5 * block.E / (1.0 + block.nu);
  const Mat3 green = 0.5 * (F.transpose() * F - Mat3::Identity());
  const Mat3 S = lambda * green.trace() * Mat3::Identity() + 2.0 * mu * green;
  return F * S * F.transpose() / F.determinant();
}

double von_mises(const Mat3 &s)
{
  const Mat3 deviator = s - s.trace() / 3.0 * Mat3::Identity();
  return std::sqrt(1.5) * deviator.norm();
}

/// Uniformly strained block, kernel lagrangian; `inner` elements converted.
void strain(Lammps &lmp, const Block &block, const Mat3 &F)
{
  lmp.commands(block.script());
  lmp.run(0);
  const Vec3 c = block.centre();
  lmp.change([&](Particle &p) {
    p.x = c + F * (p.x - c);
  });
}

}    // namespace

// A uniformly strained block has the stress times its volume for virial, whoever carries the
// stress: elements, joints or ties; and its energy is that of the solid, as pe and in the fix's
// vector.
TEST(Output, PressureAndEnergyOfUniformStrain)
{
  Block block;
  block.n[0] = block.n[1] = block.n[2] = 4;
  block.options = "kernel lagrangian";
  const Mat3 F = gradient();
  const Mat3 sigma = cauchy(F, block);
  const double volume0 = std::pow(4 * block.h, 3), box = std::pow(0.05, 3);
  const Mat3 expected = sigma * F.determinant() * volume0 / box;
  const double lambda = block.E * block.nu / ((1.0 + block.nu) * (1.0 - 2.0 * block.nu));
  const double mu = 0.5 * block.E / (1.0 + block.nu);
  const Mat3 green = 0.5 * (F.transpose() * F - Mat3::Identity());
  const double energy =
      volume0 * (0.5 * lambda * green.trace() * green.trace() + mu * green.squaredNorm());

  for (const int converted : {0, 3}) {
    if (converted) {
      block.regions = region_of("some",
                                {block.element_centre(1, 1, 1), block.element_centre(2, 1, 1),
                                 block.element_centre(1, 2, 2)},
                                block.h);
      block.convert += " start some";
    }
    for (const char *newton : {"newton off on", "newton on"}) {
      Lammps lmp;
      std::string script = block.script();
      script.replace(script.find("newton off on"), 13, newton);
      lmp.commands(script +
                   "compute push all pressure NULL virial\ncompute pe all pe\n"
                   "thermo_style custom step pe c_push[1] c_push[2] c_push[3] c_push[4] "
                   "c_push[5] c_push[6]");
      lmp.run(0);
      EXPECT_EQ(lmp.fe(CONVERTED), converted);
      const Vec3 c = block.centre();
      lmp.change([&](Particle &p) {
        p.x = c + F * (p.x - c);
      });
      lmp.run(0);
      const int order[6][2] = {{0, 0}, {1, 1}, {2, 2}, {0, 1}, {0, 2}, {1, 2}};
      for (int k = 0; k < 6; k++)
        EXPECT_NEAR(lmp.value("c_push[" + std::to_string(k + 1) + "]"),
                    -expected(order[k][0], order[k][1]), 1e-10 * expected.norm())
            << newton << ", component " << k << ", " << converted << " converted";
      EXPECT_NEAR(lmp.value("c_pe") / energy, 1.0, 1e-10) << newton;
      EXPECT_NEAR((lmp.fe(E_ELEMENTS) + lmp.fe(E_JOINTS) + lmp.fe(E_TIES)) / energy, 1.0, 1e-10);
      if (converted) {
        EXPECT_GT(lmp.fe(E_JOINTS), 0.0);
        EXPECT_GT(lmp.fe(E_TIES), 0.0);
      }
    }
  }
}

TEST(Output, StressesOfNodesAndElements)
{
  Block block;
  block.options = "kernel lagrangian";
  const Mat3 F = gradient(), sigma = cauchy(F, block);
  Lammps lmp;
  strain(lmp, block, F);
  lmp.commands("compute node all defe/atom vonmises s1 elements\n"
               "compute hex all defe/hex/local id part x y z sxx syy szz sxy sxz syz s1 vonmises\n"
               "compute one nodes defe/atom s1");
  lmp.run(0);
  const Eigen::SelfAdjointEigenSolver<Mat3> eigen(sigma);
  const double s1 = eigen.eigenvalues()[2], tolerance = 1e-9 * sigma.norm();
  for (const auto &p : lmp.per_atom("node", 1)) EXPECT_NEAR(p.second, von_mises(sigma), tolerance);
  for (const auto &p : lmp.per_atom("node", 2)) EXPECT_NEAR(p.second, s1, tolerance);
  for (const auto &p : lmp.per_atom("one")) EXPECT_NEAR(p.second, s1, tolerance);
  double sum = 0.0;
  for (const auto &p : lmp.per_atom("node", 3)) sum += p.second;
  EXPECT_EQ(sum, 8.0 * block.elements());

  std::set<int> ids;
  const Vec3 c = block.centre();
  for (const auto &row : lmp.local("hex")) {
    const int id = static_cast<int>(row[0]) - 1;
    EXPECT_TRUE(ids.insert(id).second);
    EXPECT_EQ(row[1], 1.0);
    const Vec3 X = block.element_centre(id % block.n[0], id / block.n[0] % block.n[1],
                                        id / (block.n[0] * block.n[1]));
    EXPECT_LT((Vec3(row[2], row[3], row[4]) - c - F * (X - c)).norm(), 1e-16);
    const int order[6][2] = {{0, 0}, {1, 1}, {2, 2}, {0, 1}, {0, 2}, {1, 2}};
    for (int k = 0; k < 6; k++) EXPECT_NEAR(row[5 + k], sigma(order[k][0], order[k][1]), tolerance);
    EXPECT_NEAR(row[11], s1, tolerance);
    EXPECT_NEAR(row[12], von_mises(sigma), tolerance);
  }
  EXPECT_EQ(ids.size(), static_cast<size_t>(block.elements()));
  EXPECT_NEAR(lmp.fe(S1_MAX), s1, tolerance);
}

// A block torn in two: damage is the fraction of joints that are not connective, the fix counts
// each joint once, and the event file tells the same story.
TEST(Output, DamageAndEvents)
{
  Block block;
  block.n[0] = 6;
  block.dt = 3e-8;
  block.convert = "1e12 type 2 group particles start middle";
  block.coeff = "connective material cohesive 6e7 10 0.1 contact 0.9 0.2";
  block.regions = "region middle block 0.004 0.008 INF INF INF INF";
  block.options = "events events.txt";
  remove_file("events.txt");
  Lammps lmp;
  lmp.commands(block.script() +
               "compute joints all defe/atom damage connective cohesive contact ties\n");
  const Vec3 c = block.centre();
  lmp.change([&](Particle &p) {
    p.v = Vec3(p.x[0] > c[0] ? 4.0 : -4.0, 0.0, 0.0);
  });
  lmp.run(0);
  EXPECT_EQ(lmp.fe(CONVERTED), 12);
  // 4 x 6 x 4 DEs: joints between neighbours, ties on both sides
  EXPECT_EQ(lmp.fe(CONNECTIVE), 3 * 6 * 4 + 4 * 5 * 4 + 4 * 6 * 3);
  lmp.run(400);
  std::map<std::string, int> counted;
  MPI_Barrier(MPI_COMM_WORLD);
  const auto events = read_events("events.txt");
  for (const auto &e : events) counted[e.what]++;
  EXPECT_EQ(counted["convert"], 12);
  EXPECT_EQ(counted["broken"], lmp.fe(CONTACT));
  EXPECT_EQ(counted["cohesive"], lmp.fe(COHESIVE) + lmp.fe(CONTACT));
  EXPECT_GE(counted["broken"], 24);    // torn through
  const auto damage = lmp.per_atom("joints", 1), connective = lmp.per_atom("joints", 2),
             cohesive = lmp.per_atom("joints", 3), contact = lmp.per_atom("joints", 4),
             ties = lmp.per_atom("joints", 5);
  double sums[4] = {0.0, 0.0, 0.0, 0.0};
  std::map<tagint, int> lost;
  for (const auto &e : events)
    if (e.what == "cohesive") {
      lost[e.a]++;
      lost[e.b]++;
    }
  for (const auto &p : lmp.particles()) {
    const tagint t = p.first;
    const double all = connective.at(t) + cohesive.at(t) + contact.at(t) + ties.at(t);
    EXPECT_NEAR(damage.at(t), all > 0.0 ? (cohesive.at(t) + contact.at(t)) / all : 0.0, 1e-15);
    EXPECT_EQ(cohesive.at(t) + contact.at(t), lost.count(t) ? lost.at(t) : 0);
    EXPECT_EQ(all > 0.0, p.second.type == 2);
    sums[0] += connective.at(t);
    sums[1] += cohesive.at(t);
    sums[2] += contact.at(t);
    sums[3] += ties.at(t);
  }
  EXPECT_EQ(sums[0], 2.0 * lmp.fe(CONNECTIVE));
  EXPECT_EQ(sums[1], 2.0 * lmp.fe(COHESIVE));
  EXPECT_EQ(sums[2], 2.0 * lmp.fe(CONTACT));
  EXPECT_EQ(sums[3], lmp.fe(TIES));
  EXPECT_EQ(lmp.fe(TIES), 2 * 24);

  // first damage is the first such event; each joint goes one way
  double first = 1.0;
  std::map<std::pair<long, long>, std::string> last;
  for (const auto &e : events) {
    if (e.what == "convert") continue;
    first = std::min(first, e.time);
    std::string &before = last[{e.a, e.b}];
    EXPECT_LT(e.a, e.b);
    EXPECT_EQ(before, e.what == "cohesive" ? "" : "cohesive") << e.a << " " << e.b;
    before = e.what;
    // damage, or the traction along the crack, which at an angle to the joint may be below the strength
    EXPECT_GE(e.value, e.what == "cohesive" ? 1e7 : 1.0);
    EXPECT_NEAR(e.n[0] * e.n[0] + e.n[1] * e.n[1] + e.n[2] * e.n[2], 1.0, 1e-3);
  }
  EXPECT_NEAR(lmp.fe(FIRST_DAMAGE), first, 1e-12);
  EXPECT_EQ(lmp.fe(FIRST_CONVERSION), 0.0);
}

// The outer faces for dump image, two triangles each, clockwise seen from outside: together they
// enclose minus the volume of the elements.
TEST(Output, TrianglesOfPictures)
{
  Block block;
  for (const bool convert : {false, true}) {
    if (convert) {
      block.regions = region_of(
          "some", {block.element_centre(1, 1, 0), block.element_centre(3, 2, 1)}, block.h);
      block.convert += " start some";
    }
    Lammps lmp;
    lmp.commands(block.script());
    lmp.run(0);
    int *objects;
    double **data;
    const int n = lmp->modify->get_fix_by_id("fe")->image(objects, data);
    double mine[2] = {static_cast<double>(n), 0.0}, all[2];
    for (int k = 0; k < n; k++) {
      const Vec3 a(data[k] + 1), b(data[k] + 4), c(data[k] + 7);
      EXPECT_EQ(data[k][0], 1.0);    // colour by the nodes' type
      mine[1] += a.dot(b.cross(c)) / 6.0;
    }
    MPI_Allreduce(mine, all, 2, MPI_DOUBLE, MPI_SUM, MPI_COMM_WORLD);
    const int faces = 2 * (4 * 3 + 3 * 2 + 4 * 2);
    // a middle element at the surface (one outer face) uncovers 5 faces, one at a corner (three) 3
    EXPECT_EQ(all[0], 2.0 * (convert ? faces + 4 : faces));
    EXPECT_NEAR(all[1] / std::pow(block.h, 3), -(block.elements() - (convert ? 2 : 0)), 1e-9);
  }
}
