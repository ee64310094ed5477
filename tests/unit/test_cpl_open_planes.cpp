// Planes of broken joints that are open, several at a time: what one by one gives, whoever is beside them

#include "crack_body.h"

#include <gtest/gtest.h>

#include <cstring>

using namespace defe;
using namespace defe::test;

namespace {

constexpr double d = 1e-3;
const CohesiveParameters law{60e6, 10.0, 0.1, false};
const CornerModuli moduli{glass().lambda(), glass().mu()};

/// A broken joint between two DEs that have any joints beside it, evaluated once; then both have moved on.
struct Pair {
  int slot[2];
  Vec3 dX[2][6], y[2][6];
  unsigned present[2];
  CrackEnd end[2];
  CrackGeometry geometry;
  CrackJoint joint;
  Vec3 spin;
  DERotation turn[2], with[2];

  explicit Pair(std::mt19937 &random)
  {
    std::uniform_real_distribution<double> real;
    std::uniform_int_distribution<int> any_slot(0, 5), any_joints(0, 63);
    slot[0] = any_slot(random);
    slot[1] = slot[0] ^ 1;
    const Mat3 turned = random_rotation(random);
    const double strain = real(random) < 0.9 ? 1e-3 : 0.1;
    for (int k = 0; k < 2; ++k) {
      for (int s = 0; s < 6; ++s) {
        dX[k][s] = (s % 2 ? d : -d) * Vec3::Unit(s / 2) + random_vector(random, 0.1 * d);
        y[k][s] = turned * dX[k][s] + random_vector(random, strain * d);
      }
      // all, or what cracks have left
      present[k] = (real(random) < 0.5 ? 0x3f : any_joints(random)) & ~(1u << slot[k]);
    }
    dX[1][slot[1]] = -dX[0][slot[0]];
    geometry = {dX[0][slot[0]], d * d * dX[0][slot[0]].normalized(), {slot[0], slot[1]}};
    const Vec3 m = (geometry.d / d + random_vector(random, 0.5)).normalized();
    joint = crack_broken(m, 0.5, geometry, moduli, law);
    const Eigen::Quaterniond q(turned);
    for (int k = 0; k < 4; ++k) joint.turn[k] = q.coeffs()[k];
    // open, closed, and now and then with a gap that rounding decides about
    const double gap[] = {3e-3, 1e-4, -1e-4, 0.0, 0.3};
    opens_by(gap[any_slot(random) % 5] * d * (turned * m) + random_vector(random, 1e-4 * d));
    spin.setZero();
    know();
    (void) update(0.3);

    const double jump = real(random) < 0.9 ? 1e-5 : 1e-1;
    for (auto &of : y)
      for (Vec3 &arm : of) arm += random_vector(random, jump * d);
    opens_by(random_vector(random, 1e-4 * d));
    spin = random_vector(random, real(random) < 0.9 ? 1e-3 : 0.1);
    if (real(random) < 0.1) present[0] &= present[0] - 1;    // it has lost one
    know();
  }
  Pair(const Pair &) = delete;

  CrackForces update(double friction)
  {
    return crack_update(joint, geometry, end[0], end[1], y[0][slot[0]], spin, moduli, law,
                        friction);
  }
  BrokenPlane plane() { return {&joint, &end[0], &end[1], {slot[0], slot[1]}, spin}; }
  bool poor() const
  {
    return crack_joint_has_a_say(turn[0], present[0]) || crack_joint_has_a_say(turn[1], present[1]);
  }

 private:
  void opens_by(const Vec3 &by)
  {
    y[0][slot[0]] += by;
    y[1][slot[1]] = -y[0][slot[0]];
  }
  void know()
  {
    for (int k = 0; k < 2; ++k) {
      end[k] = {dX[k], y[k], present[k]};
      turn[k] = de_rotation(end[k], present[k]);
      with[k] = de_rotation(end[k], present[k] | 1u << slot[k]);
      end[k].turn = &turn[k];
      if (crack_joint_has_a_say(turn[k], present[k])) end[k].with[slot[k]] = &with[k];
    }
  }
};

/// The numbers that may differ in their last digits: compilers fuse multiplications and additions as they like.
double difference(const CrackJoint &a, const CrackJoint &b)
{
  double most = 0.0;
  for (int k = 0; k < 3; ++k)
    most = std::max({most, std::abs(a.offset[k] - b.offset[k]) / d, std::abs(a.e[k] - b.e[k]) / d});
  for (int k = 0; k < 4; ++k) most = std::max(most, std::abs(a.turn[k] - b.turn[k]));
  return most;
}

}    // namespace

TEST(OpenPlanes, TogetherTheyAreWhatTheyAreOneByOne)
{
  std::mt19937 random(11);
  constexpr int n = 4001;    // no whole number of lots, whatever their size
  std::vector<std::unique_ptr<Pair>> pairs;
  std::vector<BrokenPlane> planes;
  std::vector<CrackJoint> before;
  for (int k = 0; k < n; ++k) {
    pairs.push_back(std::make_unique<Pair>(random));
    before.push_back(pairs[k]->joint);
    planes.push_back(pairs[k]->plane());
  }
  const auto open = std::make_unique<bool[]>(n);
  crack_update_open(n, planes.data(), open.get());

  int poor = 0, closed = 0, slid = 0, left = 0, count = 0, separated = 0;
  for (int k = 0; k < n; ++k) {
    SCOPED_TRACE(k);
    Pair &pair = *pairs[k];
    const CrackJoint together = pair.joint;
    pair.joint = before[k];
    const CrackForces r = pair.update(0.3);
    const Vec3 e(pair.joint.e), m(pair.joint.m);
    const bool settled = pair.joint.used[0] == before[k].used[0] &&
        pair.joint.used[1] == before[k].used[1] &&
        (pair.joint.used[0] | pair.joint.used[1]) >> 6 & 1u;
    if (open[k]) {
      ++count;
      poor += pair.poor();
      EXPECT_TRUE(settled);
      EXPECT_GT(e.dot(m), -1e-15 * d);
      EXPECT_LT(difference(together, pair.joint), 1e-13);
      EXPECT_EQ(together.stored, 0.0);
      EXPECT_EQ(std::memcmp(together.used, pair.joint.used, 2), 0);
      EXPECT_LT(r.force.norm(), 1e-12 * d * d * 60e6);
      EXPECT_EQ(r.excess, 0.0);
      EXPECT_EQ(r.rubbed, 0.0);
      EXPECT_FALSE(r.separated);
      slid += (Vec3(together.offset) - Vec3(before[k].offset)).norm() > 1e-8 * d;
      continue;
    }
    EXPECT_EQ(std::memcmp(&together, &before[k], sizeof(CrackJoint)), 0);
    closed += e.dot(m) < 0.0;
    separated += r.separated;
    // nothing but what the other one is for is left to it
    const double turned = std::abs(Eigen::Map<const Eigen::Vector4d>(before[k].turn)
                                       .dot(Eigen::Map<const Eigen::Vector4d>(pair.joint.turn)));
    const double far = pair.y[0][pair.slot[0]].norm() / pair.geometry.d.norm();
    EXPECT_TRUE(e.dot(m) < 1e-15 * d || !settled || r.separated || turned < 0.99961 ||
                pair.spin.norm() > 0.0399 || far > 1.2);
    left += e.dot(m) > 0.0 && !r.separated;
  }
  EXPECT_GT(count, n / 4);
  EXPECT_GT(poor, 100);
  EXPECT_GT(slid, 100);
  EXPECT_GT(closed, n / 10);
  EXPECT_GT(separated, 100);
  EXPECT_GT(left, 100);
}

TEST(OpenPlanes, NoneDependsOnThoseBesideIt)
{
  std::mt19937 random(12);
  constexpr int n = 37;
  std::vector<std::unique_ptr<Pair>> pairs;
  std::vector<BrokenPlane> planes;
  for (int k = 0; k < n; ++k) {
    pairs.push_back(std::make_unique<Pair>(random));
    planes.push_back(pairs[k]->plane());
  }
  bool open[n];
  std::vector<CrackJoint> start, alone;
  int count = 0;
  for (int k = 0; k < n; ++k) {
    start.push_back(pairs[k]->joint);
    crack_update_open(1, &planes[k], &open[k]);
    alone.push_back(pairs[k]->joint);
    count += open[k];
  }
  EXPECT_GT(count, 5);
  EXPECT_LT(count, n);
  for (int round = 0; round < 20; ++round) {
    std::vector<int> order(n);
    for (int k = 0; k < n; ++k) {
      order[k] = k;
      pairs[k]->joint = start[k];
    }
    std::shuffle(order.begin(), order.end(), random);
    std::vector<BrokenPlane> mixed;
    for (int k : order) mixed.push_back(planes[k]);
    bool now[n];
    crack_update_open(n, mixed.data(), now);
    for (int k = 0; k < n; ++k) {
      EXPECT_EQ(now[k], open[order[k]]);
      EXPECT_EQ(std::memcmp(&pairs[order[k]]->joint, &alone[order[k]], sizeof(CrackJoint)), 0);
    }
  }
}

// What the caller does not know of rotations is not guessed.
TEST(OpenPlanes, WithoutRotationsTheyAreLeft)
{
  std::mt19937 random(13);
  for (int k = 0; k < 50; ++k) {
    Pair pair(random);
    const CrackJoint before = pair.joint;
    pair.end[k % 2].turn = nullptr;
    BrokenPlane plane = pair.plane();
    bool open = true;
    crack_update_open(1, &plane, &open);
    EXPECT_FALSE(open);
    EXPECT_EQ(std::memcmp(&before, &pair.joint, sizeof(CrackJoint)), 0);
  }
}
