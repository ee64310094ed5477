// Eight DEs in a row of a lattice are computed together, without asking for each where its neighbours are: what comes of it
// is what comes of each by itself, to the last bit.

#include "defe/coupling/joint_states.h"

#include <gtest/gtest.h>

#include <random>

namespace defe {
namespace {

  constexpr double d0 = 1e-3;

  JointLaws glass()
  {
    JointCoeff c;
    c.cohesive = {60e6, 10.0, 0.1, false};
    c.opening = static_cast<unsigned char>(find_opening_law("lattice"));
    c.has_connective = c.has_cohesive = true;
    JointLaws laws;
    laws.set_types(1);
    laws.coeffs.assign(4, c);
    laws.acting.assign(4, JointLaws::OURS);
    const double E = 74.09e9, nu = 0.2;
    laws.moduli = {{E * nu / ((1.0 + nu) * (1.0 - 2.0 * nu)), 0.5 * E / (1.0 + nu)}};
    return laws;
  }

  /// nx x ny x nz DEs, x fastest.
  struct Lattice : CrackHost {
    int size[3];
    JointLaws laws = glass();
    JointTable jt;
    EnergyLedger ledger;
    StoredEnergy stored;
    std::vector<DEJoints> records;
    std::vector<double> x, v, f, torque;
    std::vector<int> type;
    std::vector<std::int64_t> id;
    RoundedForces rounding;
    std::unique_ptr<JointStates> states;

    Lattice(int nx, int ny, int nz) : size{nx, ny, nz}, records(nx * ny * nz)
    {
      const int n = jt.nde = jt.nall = jt.orthogonal = nx * ny * nz;
      std::mt19937 random(3);
      std::uniform_real_distribution<double> noise(-1e-4 * d0, 1e-4 * d0);
      jt.len.assign(n, {d0, d0, d0, d0, d0, d0});
      jt.half.assign(n, {d0 / 2, d0 / 2, d0 / 2, d0 / 2, d0 / 2, d0 / 2});
      jt.material.assign(n, 0);
      jt.present.assign(n, 0);
      jt.free.assign(n, 0);
      jt.state.assign(6 * n, joint::CONNECTIVE);
      jt.energy.assign(n, 0.0);
      jt.half_force.assign(18 * n, 0.0);
      type.assign(n, 1);
      v.assign(3 * n, 0.0);
      for (int d = 0; d < n; ++d) {
        const int c[3] = {d % nx, d / nx % ny, d / (nx * ny)}, stride[3] = {1, nx, nx * ny};
        jt.self.push_back(d);
        jt.of_atom.push_back(d);
        jt.records.push_back(&records[d]);
        id.push_back(d + 1);
        jt.nb.emplace_back();
        jt.partner.emplace_back();
        for (int a = 0; a < 3; ++a) x.push_back(c[a] * d0 + noise(random));
        for (int s = 0; s < 6; ++s) {
          const int a = s / 2, to = c[a] + (s % 2 ? 1 : -1);
          const bool there = to >= 0 && to < size[a];
          const int other = there ? d + (s % 2 ? 1 : -1) * stride[a] : d;
          jt.nb[d][s] = other;
          jt.partner[d][s] = there ? 6 * other + (s ^ 1) : -1;
          JointRecord &r = records[d].slot[s];
          r = JointRecord{};
          r.area = d0 * d0;
          r.partner = static_cast<signed char>(s ^ 1);
          if (there)
            r.kind = joint::DE;
          else
            jt.free[d] = static_cast<unsigned char>(jt.free[d] | 1u << s);
          if (there) jt.present[d] = static_cast<unsigned char>(jt.present[d] | 1u << s);
        }
      }
    }
    ~Lattice() = default;

    int at(int i, int j, int k) const { return i + size[0] * (j + size[1] * k); }
    void soften(int d, int s)
    {
      for (int ds : {6 * d + s, jt.partner[d][s]})
        jt.present[ds / 6] = static_cast<unsigned char>(jt.present[ds / 6] & ~(1u << ds % 6));
    }
    /// \param rows  false: each DE by itself
    void compute(bool rows, bool each_alone)
    {
      MovingParticles p;
      p.nlocal = p.nall = jt.nde;
      p.x = p.X = x.data();
      p.v = p.omega = v.data();
      p.type = type.data();
      p.id = id.data();
      states = std::make_unique<JointStates>(jt, laws, ledger, stored, *this);
      stored = StoredEnergy();
      states->begin(p, 1e-8, true);
      states->new_tables();
      if (!rows)
        for (auto &row : jt.rows) row = LatticeRow();
      f.assign(x.size(), 0.0);
      torque = f;
      ForceSums sums{f.data(), torque.data(), &rounding, {}};
      states->half_forces(each_alone);
      states->gather(sums);
      states->find_pending();
    }

    CrackDE describe(int) const override { return {}; }
    std::vector<JointCrack> *find_cracks(int) const override { return nullptr; }
    std::vector<JointCrack> &cracks_of(int) override { return none; }
    int nearest(int, std::int64_t) const override { return -1; }
    Vec3 half_periods() const override { return Vec3::Constant(HUGE_VAL); }

   private:
    std::vector<JointCrack> none;
  };

  void expect_same(Lattice &l, bool each_alone)
  {
    l.compute(false, each_alone);
    const auto f = l.f;
    const auto half = l.jt.half_force, energy = l.jt.energy;
    const auto pending = l.jt.pending;
    const double stored = l.stored.joints;
    for (int ds : pending) l.jt.record(ds).pending = 0;
    l.jt.pending.clear();
    l.compute(true, each_alone);
    EXPECT_EQ(l.f, f);
    EXPECT_EQ(l.jt.half_force, half);
    EXPECT_EQ(l.jt.energy, energy);
    EXPECT_EQ(l.jt.pending, pending);
    EXPECT_EQ(l.stored.joints, stored);
    for (int ds : pending) l.jt.record(ds).pending = 0;
    l.jt.pending.clear();
  }

  TEST(LatticeRows, AreFoundWhereAllFollowOneAnother)
  {
    Lattice l(16, 3, 3);
    l.jt.find_rows();
    ASSERT_EQ(l.jt.rows.size(), 18u);
    // both chunks of each line of 16 have an end, where one DE of eight has one neighbour less
    for (const auto &row : l.jt.rows) EXPECT_EQ(row.self, -1);

    Lattice longer(40, 3, 3);
    longer.jt.find_rows();
    ASSERT_EQ(longer.jt.rows.size(), 45u);
    for (int k = 0; k < 3; ++k)
      for (int j = 0; j < 3; ++j)
        for (int c = 0; c < 5; ++c) {
          const auto &row = longer.jt.rows[c + 5 * (j + 3 * k)];
          if (c == 0 || c == 4) {
            EXPECT_EQ(row.self, -1);
            continue;
          }
          const int d = longer.at(8 * c, j, k);
          EXPECT_EQ(row.self, d);
          unsigned slots = 3;
          slots |= (j > 0 ? 4u : 0u) | (j < 2 ? 8u : 0u) | (k > 0 ? 16u : 0u) | (k < 2 ? 32u : 0u);
          EXPECT_EQ(row.slots, slots);
          for (int s = 0; s < 6; ++s) {
            if (!(slots >> s & 1u)) continue;
            EXPECT_EQ(row.nb[s], longer.jt.nb[d][s]);
            EXPECT_EQ(6 * row.behind[s] + row.partner[s], longer.jt.partner[d][s]);
          }
        }
  }

  TEST(LatticeRows, AreNoneWhereOneIsElsewhere)
  {
    const auto self_of = [](auto change) {
      Lattice l(24, 3, 3);
      change(l);
      return l.jt.row_from(l.at(8, 1, 1)).self;
    };
    EXPECT_GE(self_of([](Lattice &) {
              }),
              0);
    EXPECT_EQ(self_of([](Lattice &l) {
                l.jt.self[l.at(10, 1, 1)] = 0;
              }),
              -1);
    EXPECT_EQ(self_of([](Lattice &l) {
                l.jt.nb[l.at(15, 1, 1)][3] = 0;
              }),
              -1);
    EXPECT_EQ(self_of([](Lattice &l) {
                l.jt.partner[l.at(12, 1, 1)][4] += 1;
              }),
              -1);
    EXPECT_EQ(self_of([](Lattice &l) {
                l.jt.partner[l.at(8, 1, 1)][0] = -1;
              }),
              -1);
    EXPECT_EQ(self_of([](Lattice &l) {
                l.jt.nb[l.at(9, 1, 1)][5] = ~0;
              }),
              -1)
        << "a tie";
  }

  TEST(LatticeRows, GiveTheBitsOfEachByItself)
  {
    for (bool each_alone : {false, true}) {
      Lattice l(37, 4, 3);
      expect_same(l, each_alone);
      EXPECT_GT(l.stored.joints, 0.0);
      EXPECT_TRUE(l.jt.pending.empty());
      // joints in the middle of a row soften: its neighbours still are in rows
      l.soften(l.at(12, 1, 1), 1);
      l.soften(l.at(20, 2, 1), 3);
      l.soften(l.at(29, 2, 2), 4);
      expect_same(l, each_alone);
    }
  }

  TEST(LatticeRows, RoundedForcesAreTheSame)
  {
    Lattice l(37, 4, 3);
    l.rounding.set_grids(sum_grid(1e4), sum_grid(1e4));
    expect_same(l, true);
    EXPECT_EQ(l.rounding.beyond(), -1);
    l.rounding.set_grids(sum_grid(1e-6), sum_grid(1e-6));
    expect_same(l, true);
    EXPECT_GE(l.rounding.beyond(), 0);
  }

  TEST(LatticeRows, StrengthIsReachedByTheSameJoints)
  {
    Lattice l(40, 3, 3);
    for (int d = 0; d < l.jt.nde;
         ++d)    // half of the strength along x, and more where DEs are moved
      l.x[3 * d] *= 1.0 + 0.5 * 60e6 / 74.09e9;
    for (int i = 21; i < 40; ++i) l.x[3 * l.at(i, 1, 1)] += 1e-3 * d0;
    l.x[3 * l.at(12, 0, 2)] += 2e-3 * d0;
    expect_same(l, true);
    l.compute(true, true);
    EXPECT_FALSE(l.jt.pending.empty());
    EXPECT_LT(l.jt.pending.size(), 60u);
  }

}    // namespace
}    // namespace defe
