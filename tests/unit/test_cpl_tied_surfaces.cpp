// Faces of two meshes that do not match, glued: what they have in common, and the forces of that.

#include "defe/coupling/tied_surfaces.h"
#include "defe/fe/hex8.h"
#include "defe/fe/stable_step.h"

#include <gmock/gmock.h>

#include <Eigen/Dense>

#include <cmath>
#include <random>
#include <vector>

using namespace defe;
using defe::fe::HexCoords;

namespace {

const fe::IsotropicElastic glass{74.09e9, 0.2, 2500.0};

Mat3 tilt()
{
  return Eigen::AngleAxisd(0.4, Vec3(1.0, -2.0, 0.5).normalized()).toRotationMatrix();
}

Eigen::Map<Vec3> vector(std::vector<double> &all, int i)
{
  return Eigen::Map<Vec3>(&all[3 * static_cast<std::size_t>(i)]);
}

/// n x n elements of one layer, edge 1, between two heights; sheared and rotated as a whole.
struct Layer {
  int n;
  std::vector<Vec3> X;                      // of nodes
  std::vector<std::array<int, 8>> hexes;    // node 0 first, order of C3D8
  Layer(int count, double low, double high, const Mat3 &shape) : n(count)
  {
    for (double z : {low, high})
      for (int j = 0; j <= n; j++)
        for (int i = 0; i <= n; i++) X.push_back(shape * Vec3(double(i) / n, double(j) / n, z));
    const int up = (n + 1) * (n + 1);
    for (int j = 0; j < n; j++)
      for (int i = 0; i < n; i++) {
        const int a = j * (n + 1) + i;
        hexes.push_back(
            {a, a + 1, a + n + 2, a + n + 1, a + up, a + 1 + up, a + n + 2 + up, a + n + 1 + up});
      }
  }
  HexCoords coords(int e) const
  {
    HexCoords c;
    for (int a = 0; a < 8; a++) c.col(a) = X[hexes[e][a]];
    return c;
  }
  TiedElement element(int e, int face) const
  {
    const HexCoords c = coords(e);
    const double V = fe::volume(c);
    return {
        c, face, V, glass.lambda() + 2.0 * glass.mu(), glass.rho * V, fe::max_frequency(c, glass)};
  }
};

/// A lower layer, tied by its upper faces to the lower ones of an upper layer.
struct Glued {
  Layer lower, upper;
  std::vector<double> X;
  TiedSurfaces ties;
  double area = 0.0, frequency = 0.0, stiffness = HUGE_VAL;
  Glued(const Layer &l, const Layer &u, const TieRule &rule = {}) : lower(l), upper(u)
  {
    for (const auto *layer : {&lower, &upper})
      for (const auto &x : layer->X) X.insert(X.end(), x.data(), x.data() + 3);
    const int offset = static_cast<int>(lower.X.size());
    struct Found {
      Tie tie;
      int a, b;
    };
    std::vector<Found> found;
    for (int a = 0; a < static_cast<int>(lower.hexes.size()); a++)
      for (int b = 0; b < static_cast<int>(upper.hexes.size()); b++) {
        const Tie tie = tie_faces(lower.element(a, 5), upper.element(b, 4), rule);
        if (tie.nodes == 0) continue;
        stiffness = std::min(stiffness, tie.stiffness);
        found.push_back({tie, a, b});
      }
    for (auto &[tie, a, b] : found) {
      tie.set_stiffness(stiffness);
      int node[Tie::most_nodes];
      for (int k = 0; k < tie.nodes; k++)
        node[k] = k < 4 ? lower.hexes[a][fe::hex_face[5][k]]
                        : offset + upper.hexes[b][tied_node_of_b(4, k - 4)];
      ties.add(tie, node);
      area += tie.area;
      frequency = std::max(frequency, tie.frequency());
    }
  }
  int nodes() const { return static_cast<int>(X.size()) / 3; }
  Vec3 at(const std::vector<double> &v, int i) const
  {
    return {v[3 * i], v[3 * i + 1], v[3 * i + 2]};
  }
  std::vector<double> forces(const std::vector<double> &x) const
  {
    std::vector<double> f(X.size(), 0.0);
    ties.forces(x.data(), X.data(), f.data(), {}, nullptr);
    return f;
  }
  /// x = F X
  std::vector<double> moved(const Mat3 &F) const
  {
    std::vector<double> x(X.size());
    for (int i = 0; i < nodes(); i++) vector(x, i) = F * at(X, i);
    return x;
  }
  std::vector<double> shaken(unsigned seed) const
  {
    std::mt19937 random(seed);
    std::normal_distribution<double> by(0.0, 0.05);
    auto x = moved(tilt());
    for (double &v : x) v += by(random);
    return x;
  }
};

double largest(const std::vector<double> &v)
{
  double most = 0.0;
  for (double a : v) most = std::max(most, std::abs(a));
  return most;
}

Mat3 strained()
{
  Mat3 U;
  U << 1.010, 0.004, -0.006, 0.004, 0.992, 0.003, -0.006, 0.003, 1.005;
  return tilt() * U;
}

Mat3 sheared()
{
  Mat3 A;
  A << 1.0, 0.25, -0.1, 0.0, 0.9, 0.2, 0.0, 0.0, 1.1;
  return A;
}

}    // namespace

TEST(TiedSurfaces, AllOfTheAreaIsTied)
{
  for (int n : {1, 3, 5})
    for (int m : {1, 2, 3}) {
      const Glued g(Layer(n, -0.3, 0.0, tilt()), Layer(m, 0.0, 0.4, tilt()));
      EXPECT_NEAR(g.area, 1.0, 1e-12) << n << " " << m;
    }
}

// and no distance between the surfaces changes that
TEST(TiedSurfaces, LinearFieldsHaveNoForces)
{
  const Mat3 shape = tilt() * sheared();
  for (double gap : {0.0, 0.02}) {
    const Glued g(Layer(5, -0.3, 0.0, shape), Layer(3, gap, 0.4, shape), {4.0, 0.1});
    EXPECT_GT(g.ties.count(), 25);
    const double modulus = glass.E / 0.3;    // times area: a force at displacement 1
    EXPECT_LT(largest(g.forces(g.moved(strained()))), 1e-13 * modulus) << gap;
    EXPECT_LT(largest(g.forces(g.moved(tilt() * tilt()))), 1e-13 * modulus) << gap;
    EXPECT_GT(largest(g.forces(g.shaken(1))), 1e-4 * modulus);
  }
}

TEST(TiedSurfaces, ForcesHaveNeitherSumNorMoment)
{
  for (double gap : {0.0, 0.02}) {
    const Glued g(Layer(3, -0.3, 0.0, sheared()), Layer(2, gap, 0.4, sheared()), {4.0, 0.1});
    const auto x = g.shaken(2);
    const auto f = g.forces(x);
    Vec3 sum = Vec3::Zero(), moment = Vec3::Zero();
    for (int i = 0; i < g.nodes(); i++) {
      sum += g.at(f, i);
      moment += g.at(x, i).cross(g.at(f, i));
    }
    EXPECT_LT(sum.norm(), 1e-12 * largest(f));
    EXPECT_LT(moment.norm(), 1e-12 * largest(f));
  }
}

TEST(TiedSurfaces, ForcesAreTheSlopeOfTheEnergy)
{
  const Glued g(Layer(3, -0.3, 0.0, sheared()), Layer(2, 0.02, 0.4, sheared()), {4.0, 0.1});
  auto x = g.shaken(3);
  const auto f = g.forces(x);
  std::vector<double> unused(x.size(), 0.0);
  for (std::size_t k = 0; k < x.size(); k += 5) {
    const double here = x[k], step = 1e-4;
    x[k] = here + step;
    const double up = g.ties.energy(x.data(), g.X.data(), unused.data());
    x[k] = here - step;
    const double down = g.ties.energy(x.data(), g.X.data(), unused.data());
    x[k] = here;
    EXPECT_NEAR(f[k], -(up - down) / (2.0 * step), 1e-8 * largest(f));
  }
  double sum = 0.0;
  const auto v = g.shaken(4);
  double power = 0.0, expected = 0.0, its = 0.0;
  for (int t = 0; t < g.ties.count(); t++) {
    sum += g.ties.energy_of(t, x.data(), g.X.data(), v.data(), its);
    power += its;
  }
  for (std::size_t k = 0; k < f.size(); k++) expected += f[k] * v[k];
  EXPECT_NEAR(power, expected, 1e-12 * std::abs(expected));
  EXPECT_NEAR(sum, g.ties.energy(x.data(), g.X.data(), unused.data()), 1e-12 * sum);
}

// With the same stress in both bodies, one of them shifted by stress/stiffness, what ties and elements do to each node
// of the interface cancels: constant stress passes whatever the two meshes are, and however high their elements.
TEST(TiedSurfaces, ConstantStressPasses)
{
  for (const auto &[n, m] : {std::pair(3, 2), std::pair(5, 3), std::pair(1, 4)}) {
    Layer below(n, -0.3, 0.0, tilt()), above(m, 0.0, 0.4, tilt());
    std::mt19937 random(5);
    std::uniform_real_distribution<double> by(0.7, 1.3);
    for (int i = 0; i < (n + 1) * (n + 1); i++) below.X[i] -= by(random) * 0.3 * tilt().col(2);
    const Glued g(below, above);
    const Mat3 R = tilt();
    Mat3 strain;
    strain << 1.0, 0.2, 0.5, 0.2, -0.3, -0.4, 0.5, -0.4, 2.0;
    strain = R * (1e-4 * strain) * R.transpose();
    const Mat3 stress = fe::elastic_stress(strain, glass);
    const Vec3 shift = stress * R.col(2) / g.stiffness;    // of the upper body
    std::vector<double> x(g.X.size());
    const int offset = static_cast<int>(below.X.size());
    for (int i = 0; i < g.nodes(); i++)
      vector(x, i) = g.at(g.X, i) + strain * g.at(g.X, i) + (i < offset ? 0.0 : 1.0) * shift;
    auto f = g.forces(x);
    const double tied = largest(f);
    for (const auto *layer : {&below, &above})
      for (std::size_t e = 0; e < layer->hexes.size(); e++) {
        const HexCoords X = layer->coords(static_cast<int>(e)), u = strain * X;
        const Eigen::Matrix<double, 24, 1> force =
            -fe::stiffness(X, glass) * Eigen::Map<const Eigen::Matrix<double, 24, 1>>(u.data());
        for (int a = 0; a < 8; a++) {
          const int i = layer->hexes[e][a] + (layer == &below ? 0 : offset);
          vector(f, i) += force.segment<3>(3 * a);
        }
      }
    int inner = 0;
    for (const auto *layer : {&below, &above})
      for (int j = 1; j < layer->n; j++)
        for (int i = 1; i < layer->n; i++) {
          const int on_top = layer == &below ? (layer->n + 1) * (layer->n + 1) : offset;
          EXPECT_LT(g.at(f, on_top + j * (layer->n + 1) + i).norm(), 1e-9 * tied) << n << " " << m;
          inner++;
        }
    EXPECT_GT(inner, 4);
  }
}

TEST(TiedSurfaces, NoModeIsFasterThanTheBound)
{
  for (const auto &[n, m] : {std::pair(1, 1), std::pair(2, 2), std::pair(3, 2)}) {
    const Layer below(n, -0.3, 0.0, Mat3::Identity()), above(m, 0.0, 0.4, Mat3::Identity());
    const Glued g(below, above);
    const int size = 3 * g.nodes(), offset = static_cast<int>(below.X.size());
    Eigen::MatrixXd K = Eigen::MatrixXd::Zero(size, size);
    Eigen::VectorXd mass = Eigen::VectorXd::Zero(size);
    for (const auto *layer : {&below, &above})
      for (std::size_t e = 0; e < layer->hexes.size(); e++) {
        const HexCoords X = layer->coords(static_cast<int>(e));
        const auto Ke = fe::stiffness(X, glass);
        for (int a = 0; a < 8; a++) {
          const int i = layer->hexes[e][a] + (layer == &below ? 0 : offset);
          mass.segment<3>(3 * i).array() += fe::nodal_mass(X, glass.rho);
          for (int b = 0; b < 8; b++) {
            const int j = layer->hexes[e][b] + (layer == &below ? 0 : offset);
            K.block<3, 3>(3 * i, 3 * j) += Ke.block<3, 3>(3 * a, 3 * b);
          }
        }
      }
    for (int k = 0; k < size; k++) {
      auto x = g.X;
      x[k] += 1.0;
      const auto f = g.forces(x);
      for (int i = 0; i < size; i++) K(i, k) -= f[i];
    }
    const Eigen::VectorXd root = mass.cwiseSqrt().cwiseInverse();
    const Eigen::MatrixXd scaled = root.asDiagonal() * K * root.asDiagonal();
    const double fastest =
        std::sqrt(Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd>(scaled, Eigen::EigenvaluesOnly)
                      .eigenvalues()
                      .maxCoeff());
    EXPECT_LT(fastest, g.frequency);
    EXPECT_GT(fastest, 0.7 * g.frequency);
  }
}

TEST(TiedSurfaces, WhatIsTiedAndWhatNot)
{
  const Layer below(1, -1.0, 0.0, Mat3::Identity()), above(1, 0.05, 1.0, Mat3::Identity());
  const auto with = [&](int face_a, int face_b, const TieRule &rule) {
    return tie_faces(below.element(0, face_a), above.element(0, face_b), rule);
  };
  EXPECT_EQ(with(5, 4, {}).nodes, 12);    // a twentieth of the face apart
  EXPECT_NEAR(with(5, 4, {}).distance, 0.05, 1e-12);
  const Tie far = with(5, 4, {4.0, 0.01});
  EXPECT_EQ(far.nodes, 0);
  EXPECT_NEAR(far.area, 1.0, 1e-12);
  EXPECT_NEAR(far.distance, 0.05, 1e-12);
  for (int face : {0, 1, 2, 3, 5}) EXPECT_EQ(with(5, face, {}).area, 0.0);
  // half over an edge
  Layer aside = above;
  for (auto &x : aside.X) x += Vec3(0.5, 0.0, -0.05);
  const Tie half = tie_faces(below.element(0, 5), aside.element(0, 4), {});
  EXPECT_EQ(half.nodes, 8);
  EXPECT_NEAR(half.area, 0.5, 1e-12);
  for (auto &x : aside.X) x += Vec3(0.5, 0.0, 0.0);
  EXPECT_EQ(tie_faces(below.element(0, 5), aside.element(0, 4), {}).nodes, 0);
}

TEST(TiedSurfaces, Words)
{
  EXPECT_EQ(words_of(parse_tie({}).rule), "stiffness 4");
  const auto both = parse_tie({"distance", "1e-4", "stiffness", "8", "contact", "0.2"});
  EXPECT_EQ(both.used, 4);
  EXPECT_EQ(words_of(both.rule), "distance 0.0001 stiffness 8");
  EXPECT_EQ(parse_tie({"distance"}).complaint, "distance needs a number");
  EXPECT_EQ(parse_tie({"distance", "-1"}).complaint, "distance must be a number > 0, not -1");
  EXPECT_EQ(parse_tie({"stiffness", "x"}).complaint, "stiffness must be a number > 0, not x");
  EXPECT_EQ(parse_tie({"stiffness", "1", "stiffness", "2"}).complaint, "stiffness is given twice");
}
