// Joints and ties of a rank from their birth to their end: what is pending, softens, breaks; that energy is kept on
// the way; and that several ranks with their messages get what one gets.

#include "joint_world.h"

#include <gtest/gtest.h>

#include <random>

namespace defe {
namespace {

  using test::Block;
  using test::JointWorld;

  JointCoeff glass(bool lattice, const char *curve = "linear")
  {
    JointCoeff c;
    c.cohesive = {60e6, 10.0, 0.1, false, static_cast<unsigned char>(find_softening_curve(curve))};
    c.opening = static_cast<unsigned char>(find_opening_law(lattice ? "lattice" : "rings"));
    c.has_connective = c.has_cohesive = true;
    return c;
  }

  const fe::IsotropicElastic material{74.09e9, 0.2, 2500.0};
  constexpr double h = 2e-3;

  /// A bar of two elements along x, all DEs.
  Block bar()
  {
    return {test::box_mesh(2, 1, 1, h), {1, 1}, material};
  }
  /// The same; only the right element has become DEs, which are tied to the left one.
  Block half_bar()
  {
    return {test::box_mesh(2, 1, 1, h), {0, 1}, material};
  }

  int on_one(int)
  {
    return 0;
  }

  /// Uniaxial stress along x.
  void pull(JointWorld &w, double stress)
  {
    const double e = stress / material.E;
    for (std::size_t i = 0; i < w.x.size(); ++i) {
      const Vec3 &X = w.block.X[i];
      w.x[i] = Vec3((1.0 + e) * X[0], (1.0 - 0.2 * e) * X[1], (1.0 - 0.2 * e) * X[2]);
    }
  }

  TEST(JointStates, AStrengthThatIsReachedIsPendingUntilTheNextStep)
  {
    JointWorld w(bar(), glass(true), on_one);
    auto &jt = w.ranks[0]->jt;
    pull(w, 59e6);
    w.forces(1e-9);
    EXPECT_TRUE(jt.pending.empty());
    pull(w, 61e6);
    w.forces(1e-9);
    EXPECT_EQ(jt.pending.size(), 2u * 3u * 4u) << "both ends of three rows of four joints";
    EXPECT_TRUE(w.events.empty());
    EXPECT_FALSE(w.ranks[0]->states->damaged());
    for (int ds : jt.pending) {
      EXPECT_EQ(jt.state[ds], joint::CONNECTIVE);
      EXPECT_EQ(ds % 6 / 2, 0) << "along x";
    }
    const auto before = w.f;
    w.forces(1e-9);
    EXPECT_TRUE(jt.pending.empty());
    EXPECT_EQ(w.count(EventKind::COHESIVE), 12);
    EXPECT_TRUE(w.ranks[0]->states->damaged());
    EXPECT_EQ(jt.cohesive.size(), 12u) << "each by its lower ID";
    double most = 0.0;
    for (const Vec3 &f : before) most = std::max(most, f.norm());
    for (std::size_t i = 0; i < before.size(); ++i)
      EXPECT_NEAR(w.f[i][0], before[i][0], 1e-9 * most) << "the force goes on";
  }

  // What a joint needs from its strength on is not there before, and what was not found wanting does not make it.
  TEST(JointStates, OnlyJointsThatHaveReachedTheirStrengthKeepMore)
  {
    JointWorld w(bar(), glass(true), on_one);
    auto &jt = w.ranks[0]->jt;
    pull(w, 59e6);
    w.forces(1e-9);
    w.forces(1e-9);
    for (const DEJoints *r : jt.records) EXPECT_FALSE(r->soft);
    pull(w, 61e6);
    w.forces(1e-9);
    w.forces(1e-9);
    ASSERT_FALSE(jt.cohesive.empty());
    std::vector<bool> softens(jt.nde, false);
    for (int ds : jt.cohesive) {
      softens[ds / 6] = true;
      ASSERT_TRUE(jt.records[ds / 6]->soft);
      EXPECT_GE(CohesiveState::unpack(jt.soft_joint(ds).cohesive).s0, 60e6);
    }
    int without = 0;
    for (int d = 0; d < jt.nde; ++d)
      if (!softens[d]) without += !jt.records[d]->soft;
    EXPECT_GT(without, 0) << "the higher IDs of joints";
  }

  TEST(JointStates, AnEvaluationBeforeARunSwitchesNothing)
  {
    JointWorld w(bar(), glass(true), on_one);
    pull(w, 61e6);
    w.forces(1e-9);
    w.forces(1e-9, false);
    EXPECT_EQ(w.ranks[0]->jt.pending.size(), 24u) << "found again";
    EXPECT_TRUE(w.events.empty());
  }

  /// The halves fly apart.
  void tear(JointWorld &w, double speed, int steps)
  {
    for (std::size_t i = 0; i < w.x.size(); ++i) w.v[i][0] = w.block.X[i][0] < 0.0 ? -speed : speed;
    w.forces(2e-9, false);
    for (int k = 0; k < steps; ++k) w.step(2e-9);
  }

  double lost(const JointWorld &w)
  {
    return w.sum(&EnergyLedger::fracture) + w.sum(&EnergyLedger::release);
  }

  class Torn : public ::testing::TestWithParam<bool> {};
  INSTANTIATE_TEST_SUITE_P(Laws, Torn, ::testing::Values(true, false), [](const auto &info) {
    return info.param ? "Lattice" : "Cracks";
  });

  // What comes in as motion is in motion, joints, and in the account at the end; and the fracture energy is that of
  // the joints that broke.
  TEST_P(Torn, EnergyIsKeptByEachCurveOfSoftening)
  {
    for (const auto *curve : softening_curves()) {
      SCOPED_TRACE(curve->name());
      JointWorld w(bar(), glass(GetParam(), curve->name()), on_one);
      tear(w, 8.0, 0);
      const double start = w.kinetic();
      tear(w, 8.0, 600);
      const int broken = w.count(EventKind::BROKEN);
      EXPECT_GE(broken, 4);
      EXPECT_EQ(broken % 4, 0) << "rows";
      EXPECT_NEAR(w.kinetic() + w.stored() + lost(w), start, 2e-3 * start);
      const double fracture = w.sum(&EnergyLedger::fracture);
      EXPECT_NEAR(fracture / (broken * 10.0 * 0.25 * h * h), 1.0, 0.1);
      EXPECT_EQ(w.broken, GetParam() ? broken : 0) << "without a plane they are spheres at once";
      if (GetParam()) continue;
      for (const auto &e : w.events) {
        EXPECT_TRUE(e.has_plane);
        EXPECT_NEAR(std::abs(e.m[0]), 1.0, 1e-2);
      }
    }
  }

  // The plane of a crack takes its two DEs until they are far apart; then they are spheres for each other.
  TEST(JointStates, APlaneIsLeftWhenItsSidesAreFarApart)
  {
    JointWorld w(bar(), glass(false), on_one);
    auto &jt = w.ranks[0]->jt;
    tear(w, 8.0, 600);
    const int broken = w.count(EventKind::BROKEN);
    ASSERT_GE(broken, 4);
    EXPECT_EQ(w.broken, 0);
    EXPECT_EQ(std::count(jt.state.begin(), jt.state.end(), joint::PLANE), 2 * broken);
    for (auto &x : w.x) x[0] += x[0] > 0.0 ? 0.4e-3 : 0.0;
    for (int k = 0; k < 25; ++k) w.forces(2e-9);    // open planes rest for up to 20 evaluations
    EXPECT_EQ(w.broken, broken);
    EXPECT_EQ(std::count(jt.state.begin(), jt.state.end(), joint::PLANE), 0);
    for (const auto &list : w.ranks[0]->cracks) EXPECT_TRUE(list.empty());
  }

  Block cube()
  {
    return {test::box_mesh(2, 2, 2, h), {1, 1, 1, 1, 1, 1, 1, 1}, material};
  }

  // Open planes rest for some steps. DEs beside them lose the joints that their rotation is taken from meanwhile, and are far from
  // these when the plane is looked at again: it must be where it was (it closed by itself, with energy from nothing).
  TEST(JointStates, PlanesStayOpenWhereTheirDEsLoseOtherJoints)
  {
    double most = 0.0;
    for (unsigned seed = 1; seed <= 20; ++seed) {
      JointWorld w(cube(), glass(false), on_one);
      tear(w, 8.0, 400);
      ASSERT_GE(w.count(EventKind::BROKEN), 8);
      std::mt19937 random(seed);
      std::uniform_real_distribution<double> speed(-40.0, 40.0);
      for (Vec3 &v : w.v) v += Vec3(speed(random), speed(random), speed(random));
      const auto total = [&] {
        return w.kinetic() + w.stored() + lost(w) + w.sum(&EnergyLedger::friction);
      };
      w.forces(2e-9, false);
      double last = total();
      const double start = last;
      for (int k = 0; k < 60; ++k) {
        w.step(3e-8);
        const double now = total();
        if (k > 4) most = std::max(most, (now - last) / start);
        last = now;
      }
    }
    EXPECT_LT(most, 2e-3) << "of what there is, in one step (steps are long: 1e-3)";
  }

  TEST_P(Torn, TwoRanksGetWhatOneGets)
  {
    JointWorld one(bar(), glass(GetParam()), on_one);
    JointWorld two(bar(), glass(GetParam()), [](int de) {
      return de % 3 == 0;
    });
    for (auto *w : {&one, &two}) tear(*w, 8.0, 600);
    ASSERT_GE(one.count(EventKind::BROKEN), 4);
    for (auto kind : {EventKind::COHESIVE, EventKind::BROKEN})
      EXPECT_EQ(one.count(kind), two.count(kind));
    EXPECT_NEAR(lost(one), lost(two), 1e-9 * lost(one));
    for (std::size_t i = 0; i < one.x.size(); ++i)
      EXPECT_LT((one.x[i] - two.x[i]).norm(), 1e-12 * h);
    // a rank that only hears of a joint has the same state of it
    for (const auto &r : two.ranks)
      for (int d = 0; d < r->jt.nde; ++d)
        for (int s = 0; s < 6; ++s) {
          const int other = r->jt.partner[d][s];
          if (other >= 0) { EXPECT_EQ(r->jt.state[6 * d + s], r->jt.state[other]); }
        }
  }

  TEST(JointStates, ATieSoftensAndComesOff)
  {
    JointWorld w(half_bar(), glass(true), on_one);
    auto &r = *w.ranks[0];
    std::vector<char> fixed(w.x.size(), 0);
    for (int i = 0; i < w.block.nodes(); ++i) fixed[i] = 1;    // of the element
    for (std::size_t i = w.block.nodes(); i < w.x.size(); ++i) w.v[i][0] = 8.0;
    w.forces(2e-9, false);
    const double start = w.kinetic();
    for (int k = 0; k < 600; ++k) w.step(2e-9, fixed);
    EXPECT_EQ(w.count(EventKind::ADHESIVE), 4);
    EXPECT_EQ(w.count(EventKind::DEBONDED), 4);
    EXPECT_FALSE(r.states->damaged()) << "that is of joints between DEs";
    EXPECT_NEAR(w.kinetic() + w.stored() + lost(w), start, 2e-3 * start);
    for (int d = 0; d < r.jt.nde; ++d) EXPECT_FALSE(r.jt.tied(r.jt.self[d], 1));
  }

  // The moments of ties are forces on the nodes of the face: no force or moment comes from nowhere.
  TEST(JointStates, ForcesAndMomentsAreInBalance)
  {
    for (bool boxes : {true, false}) {
      JointWorld w(half_bar(), glass(true), on_one, boxes);
      pull(w, 61e6);
      for (std::size_t i = 0; i < w.x.size(); ++i) w.v[i] = 3.0 * w.block.X[i] / h;
      w.forces(1e-9);
      w.forces(1e-9);
      ASSERT_EQ(w.count(EventKind::ADHESIVE), 4);
      Vec3 force = Vec3::Zero(), moment = Vec3::Zero();
      double scale = 0.0;
      for (std::size_t i = 0; i < w.x.size(); ++i) {
        force += w.f[i];
        moment += w.x[i].cross(w.f[i]) + w.ranks[0]->torque[i];
        scale += w.f[i].norm();
      }
      ASSERT_GT(scale, 0.0);
      EXPECT_LT(force.norm(), 1e-12 * scale);
      EXPECT_LT(moment.norm(), 1e-12 * scale * h);
    }
  }

  TEST(JointStates, ViewsTellTractionAndDamage)
  {
    JointWorld w(bar(), glass(true), on_one);
    const auto &r = *w.ranks[0];
    pull(w, 50e6);
    w.forces(1e-9);
    int along = -1;    // a joint in the middle
    for (int ds = 0; ds < 6 * r.jt.nde && along < 0; ++ds)
      if (ds % 6 == 1 && r.jt.partner[ds / 6][1] >= 0 &&
          r.jt.partner[ds / 6][1] / 6 / 8 != ds / 6 / 8)
        along = ds;
    ASSERT_GE(along, 0);
    const auto elastic = r.states->view(along);
    EXPECT_NEAR(elastic.t_n, 50e6, 0.1e6);
    EXPECT_LT(elastic.t_s, 1.0);
    EXPECT_EQ(elastic.damage, 0.0);
    pull(w, 61e6);
    w.forces(1e-9);
    pull(w, 80e6);
    w.forces(1e-9);
    const auto softening = r.states->view(along);
    EXPECT_GT(softening.damage, 0.0);
    EXPECT_LT(softening.t_n, 61e6);
    EXPECT_NEAR(softening.length, 0.5 * h * (1.0 + 80e6 / material.E), 1e-12);
  }

  // A joint that has begun to soften without a plane cannot go on by the law of cracks, nor the other way round.
  TEST(JointStates, ALawThatHasChangedIsFound)
  {
    JointWorld w(bar(), glass(true), on_one);
    auto &r = *w.ranks[0];
    pull(w, 61e6);
    w.forces(1e-9);
    EXPECT_EQ(r.states->of_other_law().count, 0);
    w.laws.coeffs.assign(4, glass(false));
    JointStates other(r.jt, w.laws, r.ledger, r.stored, r);
    other.set_particles(w.particles());
    const auto found = other.of_other_law();
    EXPECT_EQ(found.count, 12);
    EXPECT_EQ(found.first, 2 * w.laws.index(1, 1)) << "types 1 and 1, without a plane";
  }

  TEST(JointTable, CornerEnergyIsThatOfTheBlock)
  {
    for (bool boxes : {true, false}) {
      JointWorld w(half_bar(), glass(true), on_one, boxes);
      std::mt19937 random(5);
      for (auto &x : w.x) x += test::random_vector(random, 0.01 * h);
      std::vector<Vec3> f(w.x.size(), Vec3::Zero());
      const double whole = w.block.joint_forces(w.x, f);
      const auto &jt = w.ranks[0]->jt;
      double sum = 0.0;
      Vec3 half[6];
      for (int d = 0; d < jt.nde; ++d)
        sum += jt.corner_energy(d, jt.present[d], w.x[0].data(), w.block.moduli, half);
      w.forces(0.0, false);
      EXPECT_NEAR(sum, w.stored(), 1e-12 * sum);
      EXPECT_NEAR(sum, whole, 1e-12 * whole);
    }
  }

}    // namespace
}    // namespace defe
