// Elements of tied surfaces that convert: their DEs stay glued to the other part (keyword tied of fix defe).
//
// timeout: 240

#include "contact_scene.h"
#include "tied_blocks.h"

#include <gmock/gmock.h>

#include <algorithm>
#include <cmath>
#include <tuple>
#include <utility>
#include <vector>

using namespace defe::test;
using namespace defe::test::tied;
using defe::Mat3;
using defe::Vec3;
using testing::HasSubstr;
using testing::IsEmpty;

namespace {

/// One part is pulled away from the other, or both from each other.
void pull(Lammps &lmp, bool both = false)
{
  lmp.change([both](Particle &p) {
    const double z = p.x[2] - L;
    p.v = Vec3(20.0, -30.0, (both || z > 0.0 ? 1.5e3 : 0.0) * z) + 0.05 * random_of(p.tag, 7);
  });
}

const std::string seen = "compute seen all defe/joint/local id1 id2 atom2 kind state part damage "
                         "opening slip tn ts x y z nx ny nz area length length0\n";

/// Of a joint to a tied surface.
struct SeenRow {
  tagint de, other, atom2;
  int state, part;
  double damage, opening, slip, tn, ts;
  Vec3 point, normal;
  double area, length, length0;
  auto key() const { return std::tie(de, point[0], point[1], point[2]); }
  bool operator<(const SeenRow &r) const { return key() < r.key(); }
  bool operator==(const SeenRow &r) const
  {
    return key() == r.key() && other == r.other && atom2 == r.atom2 && state == r.state &&
        part == r.part && tn == r.tn && ts == r.ts && normal == r.normal && area == r.area &&
        length == r.length && length0 == r.length0;
  }
};

/// Sorted.
std::vector<SeenRow> seen_rows(Lammps &lmp)
{
  std::vector<SeenRow> rows;
  for (const auto &v : lmp.local("seen"))
    if (v[3] == 3.0)
      rows.push_back({static_cast<tagint>(v[0]), static_cast<tagint>(v[1]),
                      static_cast<tagint>(v[2]), static_cast<int>(v[4]), static_cast<int>(v[5]),
                      v[6], v[7], v[8], v[9], v[10], Vec3(v[11], v[12], v[13]),
                      Vec3(v[14], v[15], v[16]), v[17], v[18], v[19]});
  std::sort(rows.begin(), rows.end());
  return rows;
}

constexpr double lambda = E * nu / ((1.0 + nu) * (1.0 - 2.0 * nu)), mu = 0.5 * E / (1.0 + nu);

}    // namespace

// Both blocks bear one stress, and the glue has yielded to it. Then one converts as a whole, or both: no DE or node near the
// face is pushed, and what the springs of the tie had is in the account.
TEST(TiedConversion, PatchTest)
{
  Mat3 S = Mat3::Zero();
  S(2, 2) = 1e-3 * E;
  const Mat3 R = tilt();
  const Mat3 green = (1.0 + nu) / E * S - nu / E * S.trace() * Mat3::Identity();
  const Mat3 U = Mat3((Mat3::Identity() + 2.0 * green).diagonal().cwiseSqrt().asDiagonal());
  const Mat3 F = R * R * U * R.transpose();
  for (const auto &[n, m] : {std::pair(2, 3), std::pair(3, 2), std::pair(3, 3)})
    for (const std::string which : {"low", "high", "both"}) {
      SCOPED_TRACE(std::to_string(n) + " " + std::to_string(m) + " " + which);
      std::string options = "kernel lagrangian";
      if (which != "high") options += converting("low");
      if (which != "low") options += converting("high");
      Lammps lmp;
      lmp.commands(blocks(n, m, R, options + glued) + "timestep 1e-15\n");
      lmp.run(0);
      const double k = 2.0 * stiffness * (lambda + 2.0 * mu) / (L / n + L / m);
      const Vec3 shift = R * R * U * S * Vec3(0.0, 0.0, 1.0) / k;
      const tagint lower = (n + 1) * (n + 1) * (n + 1);
      lmp.change([&](Particle &p) {
        p.x = F * p.x + (p.tag > lower ? 1.0 : 0.0) * shift;
      });
      lmp.run(0);
      EXPECT_EQ(lmp.fe(CONVERTED), 0.0);
      const double stored = lmp.fe(E_ELEMENTS), balance = lmp.fe(BALANCE);
      lmp.run(5);
      const int low = n * n * n, high = m * m * m;
      EXPECT_EQ(lmp.fe(CONVERTED), which == "low" ? low : which == "high" ? high : low + high);
      EXPECT_NEAR(lmp.fe(BALANCE), balance, 1e-10 * stored);
      double most = 0.0, elsewhere = 0.0;
      int count = 0;
      for (const auto &it : lmp.particles()) {
        const double z = (F.inverse() * it.second.x)[0] * R.col(2)[0] +
            (F.inverse() * it.second.x)[1] * R.col(2)[1] +
            (F.inverse() * it.second.x)[2] * R.col(2)[2] - L;
        const double h = L / (z < 0.0 ? n : m);
        const double f = it.second.f.norm() / (S(2, 2) * 0.25 * h * h);
        if (std::abs(z) < 0.4 * h) {
          most = std::max(most, f);
          count++;
        } else
          elsewhere = std::max(elsewhere, f);
      }
      EXPECT_GE(count, 16 + 9);
      EXPECT_LT(most, 1e-6);
      EXPECT_GT(elsewhere, 0.1);
    }
}

// Momentum, energy; one piece; nothing to warn of. The springs of ties are worth 2e-4 of the energy.
TEST(TiedConversion, StaysGluedInMotion)
{
  for (const std::string which : {"high", "low", "both"})
    for (const std::string contact : {"", " contact 0.2"}) {
      SCOPED_TRACE(which + contact);
      std::string options;
      if (which != "high") options += converting("low");
      if (which != "low") options += converting("high");
      Lammps lmp;
      lmp.commands(blocks(2, 3, Mat3::Identity(), options + glued + contact));
      lmp.command("compute pieces all defe/fragment/atom");
      WarningLog log(lmp, "conversion.log");
      pull(lmp, true);
      lmp.run(0);
      const double before = lmp.fe(BALANCE);
      const auto start = lmp.particles();
      lmp.run(600);
      EXPECT_GE(lmp.fe(CONVERTED), 8.0);
      EXPECT_NEAR(lmp.fe(BALANCE), before, 4e-4 * before);
      EXPECT_EQ(lmp.fe(E_CONTACT), 0.0);
      EXPECT_LT((momentum(lmp.particles()) - momentum(start)).norm(),
                1e-11 * momentum(start).norm());
      EXPECT_EQ(lmp.value("c_pieces[1]"), 1.0);
      EXPECT_THAT(log.warnings(), IsEmpty());
    }
}

// Joints to tied surfaces are seen by compute defe/joint/local, with the stress and the area of what is glued.
TEST(TiedConversion, IsSeen)
{
  Mat3 S = Mat3::Zero();
  S(2, 2) = 1e-3 * E;
  const double green = S(2, 2) / E, nominal = std::sqrt(1.0 + 2.0 * green) * S(2, 2);
  for (const std::string which : {"low", "high", "both"}) {
    SCOPED_TRACE(which);
    std::string options = "kernel lagrangian";
    if (which != "high") options += converting("low");
    if (which != "low") options += converting("high");
    Lammps lmp;
    lmp.commands(blocks(2, 3, Mat3::Identity(), options + glued) + "timestep 1e-15\n" + seen +
                 "compute element all defe/atom element\n");
    lmp.run(0);
    EXPECT_TRUE(seen_rows(lmp).empty());
    const auto before = lmp.particles();
    const Vec3 F(std::sqrt(1.0 - 2.0 * nu * green), std::sqrt(1.0 - 2.0 * nu * green),
                 std::sqrt(1.0 + 2.0 * green));
    const double k = 2.0 * stiffness * (lambda + 2.0 * mu) / (L / 2 + L / 3);
    const double glue = nominal / k;
    lmp.change([&](Particle &p) {
      p.x = F.cwiseProduct(p.x) + (p.tag > 27 ? glue : 0.0) * Vec3(0.0, 0.0, 1.0);
    });
    lmp.run(5);
    const auto all = lmp.particles();
    const auto element = lmp.per_atom("element");
    double area[2] = {0.0, 0.0};
    int count = 0;
    for (const auto &r : seen_rows(lmp)) {
      count++;
      const bool upper = element.at(r.de) > 8.0;
      area[upper] += r.area;
      EXPECT_EQ(r.state, 0);
      EXPECT_EQ(r.part, upper ? 3 : 2);    // the material is one, too
      EXPECT_EQ(r.damage + r.opening + r.slip, 0.0);
      EXPECT_NEAR(r.tn, nominal, 1e-6 * nominal);
      EXPECT_LT(r.ts, 1e-6 * nominal);
      EXPECT_LT((r.normal - Vec3(0.0, 0.0, upper ? -1.0 : 1.0)).norm(), 1e-9);
      EXPECT_NEAR(r.length / r.length0, F[2], 1e-9);
      // at the face, straight ahead of its DE
      const Vec3 x = all.at(r.de).x;
      EXPECT_GT(r.point[2], F[2] * L - 1e-12);
      EXPECT_LT(r.point[2], F[2] * L + glue + 1e-12);
      EXPECT_LT(std::hypot(r.point[0] - x[0], r.point[1] - x[1]), 1e-9);
      // the element is one of the other part, at the surface, over or under the DE, at least with most of its quarter
      const int m = upper ? 2 : 3, number = static_cast<int>(r.other) - (upper ? 1 : 9);
      ASSERT_TRUE(number >= 0 && number < m * m * m);
      EXPECT_EQ(number / (m * m), upper ? m - 1 : 0);
      const double h = L / m, edge = L / (upper ? 12 : 8);
      const double away[2] = {std::abs(x[0] / F[0] - (number % m + 0.5) * h),
                              std::abs(x[1] / F[1] - (number / m % m + 0.5) * h)};
      EXPECT_LT(std::max(away[0], away[1]), 0.5 * h + 0.5 * edge);
      // what counts most is a node of it, or one of its DEs
      if (element.at(r.atom2) > 0.0)
        EXPECT_EQ(element.at(r.atom2), static_cast<double>(r.other));
      else {
        EXPECT_LT((before.at(r.atom2).x - x).head(2).cwiseAbs().maxCoeff(), h);
        EXPECT_EQ(r.atom2 > 27, !upper);
      }
      EXPECT_EQ(element.at(r.atom2) > 0.0, which == "both");
    }
    EXPECT_EQ(count, which == "low" ? 16 : which == "high" ? 36 : 52);
    EXPECT_NEAR(area[0] + area[1], L * L, 1e-9 * L * L);
    if (which == "both") { EXPECT_NEAR(area[0], 0.6 * L * L, 1e-9 * L * L); }    // of 3 + 2
    EXPECT_EQ(lmp.fe(TIES), 0.0);
  }
}

// The same bits on any ranks, also where joints break.
TEST(TiedConversion, SameOnAnyRanks)
{
  for (const auto &[law, options] :
       {std::pair(strong, converting("high")),
        std::pair(strong, converting("low") + converting("high")),
        std::pair(weak, converting("low") + converting("high") + " contact 0.2")}) {
    SCOPED_TRACE(options + " " + law);
    const auto run = [&, law = law, options = options](MPI_Comm comm, const std::string &file,
                                                       std::vector<SeenRow> &rows) {
      Lammps lmp(comm);
      lmp.commands(blocks(2, 3, tilt(), options + glued + " reproducible yes", law, comm, file) +
                   seen);
      lmp.change([](Particle &p) {
        const Vec3 n = tilt().col(2);
        p.v = 1.5e3 * (p.x.dot(n) - L) * n + 0.05 * random_of(p.tag, 7);
      });
      lmp.run(300);
      EXPECT_GT(lmp.fe(CONVERTED), 8.0);
      rows = seen_rows(lmp);
      return lmp.particles();
    };
    std::vector<SeenRow> one_seen, all_seen;
    const auto one = on_one_rank([&]() {
      return run(MPI_COMM_SELF, "one.data", one_seen);
    });
    const auto several = run(MPI_COMM_WORLD, "all.data", all_seen);
    EXPECT_GT(all_seen.size(), 16u);
    if (rank_of(MPI_COMM_WORLD) == 0) { EXPECT_EQ(all_seen, one_seen); }
    EXPECT_EQ(several.size(), one.size());
    EXPECT_EQ(difference(several, one, &Particle::x), 0.0);
    EXPECT_EQ(difference(several, one, &Particle::v), 0.0);
  }
}

// Restarts before, in the middle of, and after the conversions.
TEST(TiedConversion, RestartsGoOn)
{
  const std::string options =
      converting("low") + converting("high") + glued + " contact 0.2 reproducible yes";
  for (int steps : {2, 25, 150})
    for (const auto &[writers, readers] : changes_of_ranks()) {
      SCOPED_TRACE(std::to_string(steps) + ": " + std::to_string(writers) + " " +
                   std::to_string(readers));
      Particles straight, again;
      std::vector<SeenRow> straight_seen, again_seen;
      const std::string file = "conversion.restart";
      double converted[2] = {0.0, 0.0};
      on_ranks(writers, [&](MPI_Comm comm) {
        Lammps lmp(comm);
        lmp.commands(blocks(2, 3, tilt(), options, weak, comm) + seen);
        lmp.change([](Particle &p) {
          const Vec3 n = tilt().col(2);
          p.v = 1.5e3 * (p.x.dot(n) - L) * n + 0.05 * random_of(p.tag, 7);
        });
        lmp.run(steps);
        converted[0] = lmp.fe(CONVERTED);
        lmp.command("write_restart " + file);
        lmp.run(150);
        converted[1] = lmp.fe(CONVERTED);
        straight = lmp.particles();
        straight_seen = seen_rows(lmp);
      });
      on_ranks(readers, [&](MPI_Comm comm) {
        Lammps lmp(comm);
        lmp.commands(script_head() + "read_restart " + file + "\n" + pair_lines(weak) +
                     fix_of(options) + moving + seen);
        lmp.run(150);
        again = lmp.particles();
        again_seen = seen_rows(lmp);
      });
      if (straight.empty() || again.empty()) continue;    // a rank that did not run both
      EXPECT_LE(converted[0], converted[1] - (steps == 2 ? 1.0 : 0.0));
      EXPECT_GT(converted[1], 8.0);
      EXPECT_EQ(straight.size(), again.size());
      EXPECT_GT(straight_seen.size(), 16u);
      EXPECT_EQ(straight_seen, again_seen);
      EXPECT_EQ(difference(straight, again, &Particle::x), 0.0);
      EXPECT_EQ(difference(straight, again, &Particle::v), 0.0);
    }
}

// Two blocks that meet across borders of a periodic box convert as they do inside it.
TEST(TiedConversion, AcrossPeriodicBorders)
{
  const std::string options = converting("low") + converting("high") + glued + " contact 0.2";
  const auto run = [&](const Vec3 &low, const Vec3 &high) {
    blocks_apart(low, high).write("periodic.data");
    Lammps lmp;
    lmp.commands(head(options, strong, "p p p") + read_mesh("periodic.data") + moving);
    lmp.command("compute pieces all defe/fragment/atom");
    lmp.change([&](Particle &p) {
      const bool upper = p.tag > 27;
      double z = p.x[2] - (upper ? high : low)[2] - L;
      z -= period * std::round(z / period);
      p.v = Vec3(10.0, 20.0, 1.5e3 * z);
    });
    lmp.run(0);
    const double before = lmp.fe(BALANCE);
    lmp.run(300);
    EXPECT_GT(lmp.fe(CONVERTED), 8.0);
    EXPECT_EQ(lmp.value("c_pieces[1]"), 1.0);
    EXPECT_NEAR(lmp.fe(BALANCE), before, 4e-4 * before);
    return lmp.particles();
  };
  const auto inside = run(Vec3::Zero(), Vec3::Zero());
  const Vec3 border(0.027, -0.022, 0.024);    // of the box: -0.02 to 0.03
  for (const auto &[low, high] :
       {std::pair(Vec3(0.0, 0.0, 0.024), Vec3(0.0, 0.0, 0.024 - period)),
        std::pair(border, Vec3(0.027 - period, -0.022 + period, 0.024 - period))}) {
    SCOPED_TRACE(number(high[0]) + " " + number(high[2]));
    EXPECT_LT(difference(run(low, high), inside, &Particle::v), 1e-5);
  }
}

// On a rigid frame, as a pane is held by it: both go on together.
TEST(TiedConversion, OnARigidPart)
{
  two_blocks(2, 3, Mat3::Identity()).write("rigid.data");
  std::string text = head(converting("high") + glued + " contact 0.2", strong);
  text.replace(text.find("part low glass"), 14, "material steel rigid 7800 part low steel");
  Lammps lmp;
  lmp.commands(
      text + read_mesh("rigid.data") +
      "group nodes type 1\ngroup frame id 1:27\ngroup free subtract nodes frame\n"
      "fix move free nve\nfix move2 particles nve/sphere\nfix move3 frame rigid/nve single\n"
      "neighbor 5e-4 bin\ntimestep 1e-8\n");
  lmp.command("compute pieces all defe/fragment/atom");
  lmp.change([](Particle &p) {
    const double z = p.x[2] - L;
    p.v = Vec3(20.0, -30.0, z > 1e-9 ? 1.5e3 * z : 0.0);
  });
  lmp.run(0);
  const double before = lmp.fe(BALANCE);
  const auto start = lmp.particles();
  lmp.run(1000);
  EXPECT_EQ(lmp.fe(CONVERTED), 27.0);
  EXPECT_NEAR(lmp.fe(BALANCE), before, 4e-4 * before);
  EXPECT_LT((momentum(lmp.particles()) - momentum(start)).norm(), 1e-11 * momentum(start).norm());
  EXPECT_EQ(lmp.value("c_pieces[1]"), 1.0);
}

// Joints that break do not tear the tie: of a block that falls to pieces a layer of DEs sticks to the other one.
TEST(TiedConversion, BrokenJointsLeaveItTied)
{
  Lammps lmp;
  lmp.commands(blocks(2, 3, Mat3::Identity(), converting("high") + glued + " contact 0.2",
                      "cohesive 60e6 0.01 0.1"));
  lmp.change([](Particle &p) {
    const Vec3 from = p.x - Vec3(0.5 * L, 0.5 * L, L);
    p.v = from[2] > 0.0 ? Vec3(2e4 * from) : Vec3(Vec3::Zero());
  });
  lmp.run(0);
  const double before = lmp.fe(BALANCE);
  lmp.run(6000);
  EXPECT_EQ(lmp.fe(CONVERTED), 27.0);
  EXPECT_GT(lmp.fe(Entry::CONTACT), 100.0);
  EXPECT_NEAR(lmp.fe(BALANCE), before, 1e-3 * before);
  // the frame of the lower block
  const auto all = lmp.particles();
  double top = 0.0;
  for (tagint corner : {19, 21, 25, 27}) top += 0.25 * all.at(corner).x[2];
  int held = 0, gone = 0;
  for (const auto &p : all) {
    if (p.second.type != 2) continue;
    const double z = p.second.x[2] - top;
    // as a hinge: it may turn, but not into the other block
    if (z > 0.49 * L / 12 && z < 1.1 * L / 12)
      held++;
    else if (z > 5.0 * L / 12)
      gone++;
  }
  EXPECT_EQ(held, 36);
  EXPECT_EQ(gone, 8 * 27 - 36);
}

// Less than half of a quarter is not held, nor what becomes 27 DEs: that is said.
TEST(TiedConversion, WhatIsLetGoIsSaid)
{
  const auto said = [](double aside, const std::string &more) {
    MeshFile mesh;
    mesh.add_block("low", 1, 2, 2, 2, L / 2, [](const Vec3 &X) {
      return X;
    });
    mesh.add_block("high", 1, 3, 3, 3, L / 3, [aside](const Vec3 &X) {
      return Vec3(X + Vec3(aside, 0.0, L));
    });
    mesh.write("aside.data");
    Lammps lmp;
    lmp.commands(head(converting("low", more) + glued, strong) + read_mesh("aside.data") + moving);
    lmp.change([](Particle &p) {
      p.v = Vec3(0.0, 0.0, 1.5e3 * (p.x[2] - L));
    });
    WarningLog log(lmp, "aside.log");
    lmp.run(0);
    const double before = lmp.fe(BALANCE);
    lmp.run(100);
    EXPECT_GT(lmp.fe(CONVERTED), 0.0);
    EXPECT_NEAR(lmp.fe(BALANCE), before, 4e-4 * before);
    return log.warnings();
  };
  EXPECT_THAT(said(0.3 * L / 4, ""), IsEmpty());
  EXPECT_THAT(said(0.7 * L / 4, ""),
              testing::ElementsAre(HasSubstr("not all of its face stays tied")));
  EXPECT_THAT(said(0.0, " split 3"),
              testing::Contains(HasSubstr("not all of its face stays tied")));
}
