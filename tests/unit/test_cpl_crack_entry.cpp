// Cracks that come to finite elements: which ones they ask for.

#include "crack_body.h"

#include <gtest/gtest.h>

#include <memory>

using namespace defe;
using namespace defe::test;

namespace {

constexpr double h = 2e-3, d = 1e-3;
const CohesiveParameters law{60e6, 10.0, 0.1, false};

/// A block of which some elements have converted.
class Partly {
 public:
  explicit Partly(const std::function<bool(int, int)> &is_converted)
  {
    const Mesh mesh = box_mesh(4, 4, 4, h);
    std::vector<char> converted;
    for (int e = 0; e < 64; ++e) converted.push_back(is_converted(e % 4, e / 4 % 4));
    block = std::make_unique<Block>(mesh, converted, glass());
    n = block->des();
    type.assign(n, 0);
    state.assign(6 * n, CrackLattice::INTACT);
    for (int i = 0; i < n; ++i) {
      const auto &p = block->de[i];
      id.push_back(1 + i);
      X.push_back({p.birth.X[0], p.birth.X[1], p.birth.X[2]});
      outer.push_back(static_cast<unsigned char>(block->split.outer_slots(p.place)));
      ties.push_back(p.cell.tie);
      partner.emplace_back();
      for (int s = 0; s < 6; ++s)
        partner[i][s] = p.present >> s & 1u && p.nb[s] >= 0 ? 6 * p.nb[s] + p.nb_slot[s] : -1;
    }
  }

  CrackLattice lattice() const
  {
    return {n,
            n,
            id.data(),
            reinterpret_cast<const double(*)[3]>(X.data()),
            reinterpret_cast<const int(*)[6]>(partner.data()),
            outer.data(),
            state.data(),
            ties.data()};
  }

  /// Cuts the joints along y of these DEs that cross the plane y = level.
  void cut(double level, const std::function<bool(const Vec3 &)> &where)
  {
    for (int i = 0; i < n; ++i)
      for (int s = 0; s < 6; ++s) {
        const int there = partner[i][s];
        if (there < 0 || (X[i][1] < level) == (X[there / 6][1] < level) ||
            !where(Vec3(X[i].data())))
          continue;
        state[6 * i + s] = CrackLattice::BROKEN;
      }
  }

  /// Ties that fronts ask for, with nothing at DEs that are unloaded. Normal of the crack and of the tension.
  std::vector<int> asked(double tension, const std::function<bool(const Vec3 &)> &unloaded,
                         const Vec3 &normal = Vec3::UnitY(), const Vec3 &pull = Vec3::UnitY())
  {
    const CrackLattice l = lattice();
    CrackGrowth growth;
    growth.reset(l);
    for (int joint = 0; joint < 6 * n; ++joint)
      if (l.cut(joint) && l.lower_end(joint) == joint) {
        const Vec3 m = l.vector(joint)[1] < 0.0 ? Vec3(-normal) : normal;
        growth.add_crack(l, joint, {{m[0], m[1], m[2]}, 0.5});
      }
    const Mat3 F = strain_of(tension * pull * pull.transpose());
    const std::vector<double> all_loud(n, 1.0), quiet(n, 0.0);
    for (int i : growth.mark(l, all_loud.data(), quiet.data())) {
      Vec3 y[6];
      for (int s = 0; s < 6; ++s)
        y[s] = unloaded(Vec3(X[i].data())) ? block->de[i].cell.dX[s]
                                           : Vec3(F * block->de[i].cell.dX[s]);
      growth.stress(i) = crack_stress(block->de[i].cell, y, block->de[i].present, block->moduli);
    }
    const CrackNuclei nuclei;
    growth.decide(l, {type.data(), 1, &law.sigma_t, &nuclei}, {}, starts);
    for (int tie : growth.entered()) EXPECT_TRUE(ties[tie / 6] >> tie % 6 & 1u);
    return growth.entered();
  }

  std::vector<std::array<double, 3>> X;
  std::vector<CrackStart> starts;    // of the last asked()

  /// Middle of a joint.
  Vec3 middle(int joint) const { return Vec3(X[joint / 6].data()) + 0.5 * lattice().vector(joint); }

 private:
  std::unique_ptr<Block> block;
  int n;
  std::vector<std::int64_t> id;
  std::vector<std::array<int, 6>> partner;
  std::vector<unsigned char> outer, ties, type, state;
};

/// All has converted but a column of elements; a crack has come from the left along its lower face.
Partly crack_before_an_element()
{
  Partly body([](int i, int j) {
    return i != 2 || j != 2;
  });
  body.cut(0.0, [](const Vec3 &X) {
    return X[0] < 0.0;
  });
  return body;
}

/// Above that crack.
bool above(const Vec3 &X)
{
  return X[0] < 0.0 && X[1] > 0.0;
}

const double entry_stress = CrackGrowthParameters().entry * law.sigma_t;

}    // namespace

// A crack whose front stands before finite elements asks for them.
TEST(CrackGrowth, FrontsAskForElements)
{
  Partly body([](int i, int) {
    return i < 2;
  });
  const auto nothing = [](const Vec3 &) {
    return false;
  };
  body.cut(0.0, [](const Vec3 &) {
    return true;
  });
  EXPECT_TRUE(body.asked(0.9 * entry_stress, nothing).empty());
  const auto asked = body.asked(1.1 * entry_stress, nothing);
  EXPECT_EQ(asked.size(), 16u);    // both sides of the plane, eight DEs deep
  for (int tie : asked) EXPECT_LT(std::abs(body.X[tie / 6][1]), d);
}

// Where it passes below an element, what is behind the crack is unloaded: the joints ahead ask.
TEST(CrackGrowth, FrontsAskForElementsBesideTheirWay)
{
  Partly body = crack_before_an_element();
  EXPECT_TRUE(body.asked(0.9 * entry_stress, above).empty());
  const auto asked = body.asked(1.1 * entry_stress, above);
  EXPECT_EQ(asked.size(), 8u);    // of the DEs below the element, next to the crack
  for (int tie : asked) {
    EXPECT_NEAR(body.X[tie / 6][0], 0.5 * d, 1e-9 * d);
    EXPECT_NEAR(body.X[tie / 6][1], -0.5 * d, 1e-9 * d);
  }
}

// The same, but the crack goes down: it passes between the DEs left and right of it below the element, which is not asked for.
TEST(CrackGrowth, FrontsGoOnBesideElements)
{
  Partly body = crack_before_an_element();
  const Vec3 down = Vec3(1.0, 1.0, 0.0).normalized();
  EXPECT_TRUE(body.asked(0.9 * law.sigma_t, above, down, down).empty());
  EXPECT_TRUE(body.starts.empty());
  EXPECT_TRUE(body.asked(1.1 * law.sigma_t, above, down, down).empty());
  int there = 0;
  for (const CrackStart &start : body.starts) {
    const Vec3 c = body.middle(start.joint);
    const bool joint = std::abs(c[0]) < 1e-9 * d && std::abs(c[1] + 0.5 * d) < 1e-9 * d;
    there += joint && start.origin == CrackStart::FRONT;
    EXPECT_GT(std::abs(Vec3(start.memory.m).dot(down)), 0.99);
  }
  EXPECT_EQ(there, 8);    // DEs deep
}

// It did go down, but the tension turns it so that it now has to pass between the element and the DE below: it is asked
// for when the front would move, so that it does not stop for good.
TEST(CrackGrowth, FrontsAskForWhatTheyTurnOutToNeed)
{
  Partly body = crack_before_an_element();
  const Vec3 down = Vec3(1.0, 1.0, 0.0).normalized();
  EXPECT_TRUE(body.asked(0.9 * law.sigma_t, above, down).empty());
  const auto asked = body.asked(1.3 * law.sigma_t, above, down);
  EXPECT_EQ(asked.size(), 8u);
  for (int tie : asked) {
    EXPECT_NEAR(body.X[tie / 6][0], 0.5 * d, 1e-9 * d);
    EXPECT_NEAR(body.X[tie / 6][1], -0.5 * d, 1e-9 * d);
  }
}
