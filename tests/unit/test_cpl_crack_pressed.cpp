// A crack in glass that is pressed: it goes on where its plane is drawn open, not where one joint is torn

#include "crack_body.h"

#include <gtest/gtest.h>

using namespace defe;
using namespace defe::test;

namespace {

constexpr double h = 2e-3, d = 1e-3;
const CohesiveParameters law{60e6, 10.0, 0.1, false};

struct Decided {
  int fronts = 0;
  double torn =
      0.0;    // largest stress along the crack's normal at a joint of a ring with a front, over sigma_t
};

/// A block with a notch up to x = 0.4 d of the plane y = 0, under the stress `across` along y. DEs above the plane in
/// the column that is next are drawn away from it until a joint holds 1.1 sigma_t.
Decided decide(double across, const CrackGrowthParameters &parameters)
{
  CrackBody body(box_mesh(6, 6, 4, h), law, true);
  body.parameters = parameters;
  const Vec3 n = Vec3::UnitY();
  body.notch(
      [](const Vec3 &p) {
        return p[0] < 0.4 * d;
      },
      n, 0.1 * d);
  const Mat3 F = strain_of(across * law.sigma_t * n * n.transpose());
  Decided out;
  for (double lift = 0.0; out.torn < 1.1 && lift < 1e-5; lift += 1e-8) {
    for (int i = 0; i < body.n; ++i) {
      const Vec3 X = body.reference(i);
      body.x[i] = F * X;
      const bool next = X[0] > 0.0 && X[0] < d && X[1] > 0.0 && X[1] < d && std::abs(X[2]) < d;
      if (next) body.x[i] += lift * n;
    }
    body.forces();
    body.decide();
    const CrackLattice l = body.lattice();
    out.fronts = 0;
    for (const CrackStart &s : body.starts) out.fronts += s.origin == CrackStart::FRONT;
    out.torn = 0.0;
    for (int i = 0; i < body.n; ++i)
      for (int s = 0; s < 6; ++s) {
        const int other = body.partner[i][s];
        if (other < 0 || l.cut(6 * i + s) || !body.growth.marked(i)) continue;
        const Vec3 c = body.reference(i) + 0.5 * l.vector(6 * i + s);
        if (c[0] < 0.0 || c[0] > d || std::abs(c[1]) > d || !body.growth.marked(other / 6))
          continue;
        const CrackStress &a = body.growth.stress(i), &b = body.growth.stress(other / 6);
        const Mat3 S = (crack_tensor(a.slot[s]) + crack_tensor(b.slot[other % 6])) /
            (a.slot_volume[s] + b.slot_volume[other % 6]);
        out.torn = std::max(out.torn, n.dot(S * n) / law.sigma_t);
      }
  }
  return out;
}

}    // namespace

TEST(CrackPressed, GoesOnOnlyWhereItIsDrawnOpen)
{
  const CrackGrowthParameters usual;
  CrackGrowthParameters anywhere;
  anywhere.pull = -HUGE_VAL;
  for (const auto &[across, moves] :
       {std::pair{0.4, true}, {0.0, false}, {-3.0, false}, {-5.0, false}}) {
    const Decided r = decide(across, usual);
    EXPECT_GE(r.torn, 1.1) << across;
    EXPECT_EQ(r.fronts > 0, moves) << across;
    EXPECT_GT(decide(across, anywhere).fronts, 0) << across;
  }
}
