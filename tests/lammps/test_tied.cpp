// Surfaces of meshes that do not match, glued (keyword tied of fix defe).
//
// timeout: 240

#include "failure.h"
#include "tied_blocks.h"

#include <gmock/gmock.h>

#include <Eigen/Eigenvalues>
#include <Eigen/Geometry>

#include <cmath>
#include <functional>

using namespace defe::test;
using namespace defe::test::tied;
using defe::Mat3;
using defe::Vec3;
using testing::AllOf;
using testing::HasSubstr;

namespace {

/// Blocks that are apart only by what ties yield, under one stress everywhere: largest force, by that of the
/// stress on a face of an element, on nodes for which `exact` says that it vanishes. Their places: 0 to n.
double residual(int n, int m, const Mat3 &S, const std::function<bool(const int *, int)> &exact)
{
  const Mat3 R = tilt();
  Lammps lmp;
  lmp.commands(script(two_blocks(n, m, R), "tied low high kernel lagrangian"));
  lmp.run(0);
  double rest = 0.0;
  for (const auto &p : lmp.particles()) rest = std::max(rest, p.second.f.norm());
  EXPECT_LT(rest, 1e-13 * E * L * L);

  const double lambda = E * nu / ((1.0 + nu) * (1.0 - 2.0 * nu)), mu = 0.5 * E / (1.0 + nu);
  const Mat3 green = (1.0 + nu) / E * S - nu / E * S.trace() * Mat3::Identity();
  Mat3 U = Mat3::Identity() + 2.0 * green;
  U = Eigen::SelfAdjointEigenSolver<Mat3>(U).operatorSqrt();
  const Mat3 F = R * R * U * R.transpose();    // the blocks' own axes are those of R
  const double k = 2.0 * stiffness * (lambda + 2.0 * mu) / (L / n + L / m);
  const Vec3 shift = R * R * U * S * Vec3(0.0, 0.0, 1.0) / k;
  const tagint lower = (n + 1) * (n + 1) * (n + 1);
  lmp.change([&](Particle &p) {
    p.x = F * p.x + (p.tag > lower ? 1.0 : 0.0) * shift;
  });
  lmp.run(0);

  double largest = 0.0, elsewhere = 0.0;
  int count = 0;
  for (const auto &it : lmp.particles()) {
    const bool high = it.first > lower;
    const int edge = (high ? m : n) + 1;
    const int index = static_cast<int>(it.first - 1 - (high ? lower : 0));
    const int at[3] = {index % edge, index / edge % edge, index / edge / edge + (high ? 1000 : 0)};
    const double f = it.second.f.norm() / (S.norm() * std::pow(L / std::max(n, m), 2));
    if (exact(at, edge - 1)) {
      largest = std::max(largest, f);
      count++;
    } else
      elsewhere = std::max(elsewhere, f);
  }
  EXPECT_GT(count, 10);
  EXPECT_GT(elsewhere, 0.1);
  return largest;
}

/// Glued blocks that move and vibrate.
void shake(Lammps &lmp)
{
  lmp.change([](Particle &p) {
    p.v = Vec3(1.0, 2.0, -1.0) + Vec3(300.0, -200.0, 100.0).cross(p.x) + 0.5 * random_of(p.tag, 7);
  });
}

}    // namespace

// The stress is the same everywhere, whatever the meshes are: with it no node is pushed.
TEST(Tied, PatchTestOfUniaxialStress)
{
  Mat3 S = Mat3::Zero();
  S(2, 2) = 1e-3 * E;
  for (const auto &[n, m] : {std::pair(2, 3), std::pair(3, 2), std::pair(3, 5)})
    EXPECT_LT(residual(n, m, S,
                       [](const int *at, int edge) {
                         return at[2] > 0 && at[2] != 1000 + edge;
                       }),
              1e-8)
        << n << " " << m;
}

TEST(Tied, PatchTestOfShear)
{
  Mat3 S;
  S << 2.0, 0.5, 1.0, 0.5, -1.0, -0.7, 1.0, -0.7, 1.5;
  S *= 3e-4 * E;
  for (const auto &[n, m] : {std::pair(2, 3), std::pair(5, 3)})
    EXPECT_LT(residual(n, m, S,
                       [](const int *at, int edge) {
                         return at[2] > 0 && at[2] != 1000 + edge && at[0] > 0 && at[0] < edge &&
                             at[1] > 0 && at[1] < edge;
                       }),
              1e-8)
        << n << " " << m;
}

// With contact, which must not push what is glued; with two clocks; with surfaces that are a little apart.
TEST(Tied, MomentaAndEnergyAreKept)
{
  struct Case {
    std::string options;
    double gap;
  };
  for (const Case &c : {Case{"", 0.0}, Case{"contact 0.2", 0.0}, Case{"every 2 contact 0.2", 0.0},
                        Case{"", 1e-4}}) {
    SCOPED_TRACE(c.options + " " + number(c.gap));
    Lammps lmp;
    lmp.commands(script(two_blocks(2, 3, tilt(), c.gap), "tied low high " + c.options) +
                 "timestep 2e-8\n");
    shake(lmp);
    lmp.run(0);
    const auto before = lmp.particles();
    lmp.record({"f_fe[22]", "f_fe[13]", "f_fe[9]"}, 4);
    lmp.run(800);
    const auto after = lmp.particles();
    const double p = momentum(before).norm(), l = angular_momentum(before).norm();
    EXPECT_LT((momentum(after) - momentum(before)).norm(), 1e-12 * p);
    EXPECT_LT((angular_momentum(after) - angular_momentum(before)).norm(), 1e-9 * l);
    const auto total = lmp.recorded(0), contact = lmp.recorded(1), elastic = lmp.recorded(2);
    const double vibration = *std::max_element(elastic.begin(), elastic.end());
    EXPECT_LT(largest_deviation(total), (c.options.empty() ? 0.02 : 0.05) * vibration);
    for (double e : contact) EXPECT_EQ(e, 0.0);
    EXPECT_GT(vibration, 1e-6 * total.front());
    // they are still one body
    const auto in = [&](const Particles &all, tagint a, tagint b) {
      return (all.at(a).x - all.at(b).x).norm();
    };
    EXPECT_NEAR(in(after, 1, 27 + 64), in(before, 1, 27 + 64), 1e-5);
  }
}

TEST(Tied, StepThatIsNamedIsStable)
{
  Lammps lmp;
  lmp.commands(script(two_blocks(3, 3, Mat3::Identity()), "tied low high"));
  lmp.run(0);
  int dim;
  const auto step = [&dim](Lammps &l) {
    return *static_cast<double *>(l->modify->get_fix_by_id("fe")->extract("dt_finite", dim));
  };
  Lammps alone;
  alone.commands(
      script(two_blocks(3, 3, Mat3::Identity()), "contact 0.2", MPI_COMM_WORLD, "alone.data"));
  alone.run(0);
  EXPECT_LT(step(lmp), 0.8 * step(alone));
  EXPECT_GT(step(lmp), 0.5 * step(alone));
  lmp.commands("timestep " + number(0.99 * step(lmp)));
  shake(lmp);
  lmp.record({"f_fe[9]"}, 10);
  lmp.run(3000);
  const auto elastic = lmp.recorded();
  const double early = *std::max_element(elastic.begin(), elastic.begin() + 50);
  EXPECT_LT(*std::max_element(elastic.end() - 50, elastic.end()), 2.0 * early);
}

TEST(Tied, SameOnAnyRanks)
{
  for (const std::string options : {"", "reproducible yes"}) {
    const auto run = [&](MPI_Comm comm, const std::string &file) {
      Lammps lmp(comm);
      lmp.commands(
          script(two_blocks(2, 3, tilt()), "check yes tied low high " + options, comm, file));
      lmp.command("compute pieces all defe/fragment/atom");
      shake(lmp);
      lmp.run(300);
      EXPECT_EQ(lmp.value("c_pieces[1]"), 1.0);
      return lmp.particles();
    };
    const auto one = on_one_rank([&]() {
      return run(MPI_COMM_SELF, "one.data");
    });
    const auto all = run(MPI_COMM_WORLD, "all.data");
    EXPECT_LE(difference(all, one, &Particle::x), options.empty() ? 1e-14 : 0.0);
    EXPECT_LE(difference(all, one, &Particle::v), options.empty() ? 1e-8 : 0.0);
  }
}

TEST(Tied, RestartsGoOn)
{
  const std::string options = "tied low high";
  for (const auto &[writers, readers] : changes_of_ranks()) {
    Particles straight, first;
    const std::string file = "tied.restart";
    on_ranks(writers, [&](MPI_Comm comm) {
      Lammps lmp(comm);
      lmp.commands(script(two_blocks(2, 3, tilt()), options, comm));
      shake(lmp);
      lmp.run(150);
      lmp.command("write_restart " + file);
      lmp.run(150);
      straight = lmp.particles();
    });
    on_ranks(readers, [&](MPI_Comm comm) {
      Lammps lmp(comm);
      lmp.commands(script_head() + "read_restart " + file +
                   "\npair_style zero 0.002\npair_coeff * *\n" + fix_of(options) + motion);
      lmp.run(150);
      first = lmp.particles();
    });
    if (straight.empty() || first.empty()) continue;    // a rank that did not run both
    EXPECT_LT(difference(straight, first, &Particle::x), 1e-14);
    EXPECT_LT(difference(straight, first, &Particle::v), 1e-8);
  }
  for (const std::string other : {"", "tied low high stiffness 8", "tied high low"})
    EXPECT_THAT(failure(script_head() + "read_restart tied.restart\n" + fix_of(other)),
                HasSubstr("surfaces are tied once, with the mesh"));
}

// Two blocks that meet across borders of a periodic box move as they do inside it, with contact and over a restart.
// Nodes are wrapped when the mesh is read.
TEST(Tied, AcrossPeriodicBorders)
{
  struct Case {
    Vec3 low, high;    // where the blocks are, beside their places inside the box
  };
  const auto run = [&](const Vec3 &low, const Vec3 &high) {
    blocks_apart(low, high).write("periodic.data");
    const std::string options = "check yes contact 0.2 tied low high";
    std::string text = before_mesh(options);
    text.replace(text.find("f f f"), 5, "p p p");
    Lammps lmp;
    lmp.commands(text + read_mesh("periodic.data") + motion);
    lmp.command("compute pieces all defe/fragment/atom");
    lmp.change([](Particle &p) {
      p.v = Vec3(10.0, 20.0, -10.0) + 0.5 * random_of(p.tag, 7);
    });
    lmp.run(0);
    const double before = lmp.fe(TOTAL);
    lmp.run(150);
    lmp.command("write_restart periodic.restart");
    lmp.run(150);
    EXPECT_EQ(lmp.value("c_pieces[1]"), 1.0);
    EXPECT_NEAR(lmp.fe(TOTAL), before, 1e-3 * before);
    const auto end = lmp.particles();
    Lammps again;
    again.commands(script_head("p p p") +
                   "read_restart periodic.restart\npair_style zero 0.002\npair_coeff * *\n" +
                   fix_of(options) + motion);
    again.run(150);
    EXPECT_LT(difference(again.particles(), end, &Particle::v), 1e-8);
    return end;
  };
  const auto inside = run(Vec3::Zero(), Vec3::Zero());
  const Vec3 border(0.027, -0.022, 0.024);    // of the box: -0.02 to 0.03
  for (const Case &c :
       {Case{border, border}, Case{{0.0, 0.0, 0.024}, {0.0, 0.0, 0.024 - period}},
        Case{{0.027, -0.022, 0.024}, {0.027 - period, -0.022 + period, 0.024 - period}},
        Case{{0.027 - period, 0.0, 0.0}, {0.027, 0.0, 0.0}}}) {
    SCOPED_TRACE(number(c.high[0]) + " " + number(c.high[1]) + " " + number(c.high[2]));
    EXPECT_LT(difference(run(c.low, c.high), inside, &Particle::v), 1e-7);
  }
}

// Layers that fill a periodic box are tied on both sides.
TEST(Tied, LayersThatFillAPeriodicBox)
{
  const double h = L / 5;
  std::string text = script_head("p p p") + "region box block 0 " + number(L) + " 0 " + number(L) +
      " 0 " + number(L) + "\ncreate_box 2 box\npair_style zero 0.001\npair_coeff * *\n" +
      fix_of("tied low high check yes");
  text += "create_hexes fe low 1 x 0 5 " + number(L) + " y 0 5 " + number(L) + " z 0 3 " +
      number(3 * h) + "\ncreate_hexes fe high 1 x 0 7 " + number(L) + " y 0 7 " + number(L) +
      " z " + number(3 * h) + " 3 " + number(L) + "\n" + motion;
  Lammps lmp;
  lmp.commands(text);
  lmp.run(0);
  // one layer is moved up as a whole, by what a traction p takes
  const double p = 1e6, lambda = E * nu / ((1.0 + nu) * (1.0 - 2.0 * nu)),
               mu = 0.5 * E / (1.0 + nu);
  const double k = 2.0 * stiffness * (lambda + 2.0 * mu) / (h + 2.0 * h / 3.0);
  constexpr tagint lower = 6 * 6 * 4;
  lmp.change([&](Particle &q) {
    if (q.tag <= lower) q.x[2] += p / k;
  });
  lmp.run(0);
  double up = 0.0;
  for (const auto &q : lmp.particles())
    if (q.first <= lower) up += q.second.f[2];
  EXPECT_NEAR(up, -2.0 * p * L * L, 1e-9 * p * L * L);    // pulled back on both sides
}

namespace {

/// Deflection of a cantilever of two halves under a force at its end, by that of beam theory. mesh: makes
/// its parts low and high.
double deflection(const std::string &mesh, const std::string &options)
{
  constexpr double length = 0.024, H = 0.006, W = 0.003, F = 20.0;
  Lammps lmp;
  lmp.commands(before_mesh(options) + mesh + R"(
    group           nodes type 1
    neighbor        5e-4 bin
    timestep        5e-8
    region          clamp block INF 1e-9 INF INF INF INF
    group           clamp region clamp
    fix             hold clamp setforce 0 0 0
    region          tip block 0.0239 INF INF INF INF INF
    group           tip region tip
    variable        share equal 20/count(tip)
    variable        pot atom -v_share*(y-0.003)
    fix             press tip addforce 0 v_share 0 energy v_pot
    fix_modify      press energy yes
    variable        tipy equal xcm(tip,y)
    min_style       cg
    min_modify      dmax 1e-4 line forcezero
    run             0
    variable        before equal $(v_tipy)
    minimize        0 1e-9 5000 20000
  )");
  const double I = W * H * H * H / 12.0, G = E / (2.0 * (1.0 + nu));
  const double kappa = 10.0 * (1.0 + nu) / (12.0 + 11.0 * nu);
  const double expected =
      F * std::pow(length, 3) / (3.0 * E * I) + F * length / (kappa * G * W * H);
  return lmp.value("v_tipy-v_before") / expected;
}

}    // namespace

// A cantilever of two halves, glued across and along, bends as one of one piece: within 2 %.
TEST(Tied, CantileverOfTwoHalves)
{
  const double one = deflection("create_hexes fe low 1 x 0 24 0.024 y 0 6 0.006 z 0 3 0.003\n", "");
  EXPECT_NEAR(one, 1.0, 0.01);
  const double across =
      deflection("create_hexes fe low 1 x 0 12 0.012 y 0 6 0.006 z 0 3 0.003\n"
                 "create_hexes fe high 1 x 0.012 8 0.024 y 0 4 0.006 z 0 2 0.003\n",
                 "tied low high");
  EXPECT_NEAR(across / one, 1.0, 0.02);
  const double along =
      deflection("create_hexes fe low 1 x 0 24 0.024 y 0 3 0.003 z 0 3 0.003\n"
                 "create_hexes fe high 1 x 0 16 0.024 y 0.003 2 0.006 z 0 2 0.003\n",
                 "tied low high");
  EXPECT_NEAR(along / one, 1.0, 0.02);
}

TEST(Tied, WrongInput)
{
  const auto said = [](const MeshFile &mesh, const std::string &options) {
    return failure(script(mesh, options) + "run 0");
  };
  const auto good = two_blocks(2, 3, Mat3::Identity());
  EXPECT_EQ(said(good, "tied low high"), "");
  EXPECT_THAT(said(good, "tied low"), HasSubstr("missing argument"));
  EXPECT_THAT(said(good, "tied low hihg"), HasSubstr("unknown part hihg: define it before"));
  EXPECT_THAT(said(good, "tied low low"),
              HasSubstr("cannot be tied to itself: make its bodies two parts"));
  EXPECT_THAT(said(good, "tied low high tied high low"), HasSubstr("given twice"));
  EXPECT_THAT(said(good, "tied low high distance 0"),
              HasSubstr("distance must be a number > 0, not 0"));
  EXPECT_THAT(said(good, "tied low glass"),
              AllOf(HasSubstr("nothing to tie"), HasSubstr("check the meshes")));
  EXPECT_THAT(said(good, "material steel rigid 7800 part a steel part b steel tied a b"),
              HasSubstr("both parts are rigid"));
  EXPECT_THAT(said(two_blocks(2, 3, Mat3::Identity(), 5e-4), "tied low high"),
              AllOf(HasSubstr("0.0005 to 0.0005 apart"), HasSubstr("give a larger 'distance'")));
  EXPECT_THAT(said(two_blocks(2, 3, Mat3::Identity(), 5e-4), "tied low high distance 4e-4"),
              HasSubstr("no more than 0.0004 is bridged"));
  EXPECT_EQ(said(two_blocks(2, 3, Mat3::Identity(), 5e-4), "tied low high distance 6e-4"), "");
  EXPECT_THAT(said(two_blocks(2, 3, Mat3::Identity(), 5e-3), "tied low high"),
              HasSubstr("nothing to tie"));
}
