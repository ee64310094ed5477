// Tied surfaces whose elements have become DEs: what a quarter of a face is tied to, and the forces of that.

#include "defe/coupling/tied_quarters.h"

#include "joint_world.h"

#include "defe/coupling/mesh_measure.h"
#include "defe/fe/stable_step.h"

#include <gmock/gmock.h>

#include <Eigen/Dense>

#include <cmath>
#include <map>

using namespace defe;
using defe::fe::HexCoords;
using test::JointWorld;
using test::Vectors;

namespace {

const fe::IsotropicElastic glass{74.09e9, 0.2, 2500.0};

Mat3 tilt()
{
  return Eigen::AngleAxisd(0.4, Vec3(1.0, -2.0, 0.5).normalized()).toRotationMatrix();
}

/// Nothing breaks.
JointCoeff strong()
{
  JointCoeff c;
  c.cohesive = {1e15, 1e6, 0.1, false, static_cast<unsigned char>(find_softening_curve("linear"))};
  c.opening = static_cast<unsigned char>(find_opening_law("lattice"));
  c.has_connective = c.has_cohesive = true;
  return c;
}

/// Body A below z = 0, n x n elements in `layers` layers, and B above it, m x m; edges 1 x 1. R turns all.
struct Shape {
  int n, m;
  Mat3 R = Mat3::Identity();
  double height_a = 0.6, height_b = 0.8, gap = 0.0;
  int layers = 2;
};

test::Mesh mesh_of(const Shape &s)
{
  test::Mesh all;
  for (bool upper : {false, true}) {
    const int n = upper ? s.m : s.n;
    const double height = upper ? s.height_b : s.height_a;
    auto body = test::box_mesh(n, n, s.layers, 1.0);
    const auto offset = static_cast<std::int64_t>(all.X.size());
    for (const Vec3 &X : body.X)
      all.X.push_back(
          s.R *
          Vec3(X[0] / n, X[1] / n,
               (X[2] / s.layers + (upper ? 0.5 : -0.5)) * height + (upper ? s.gap : 0.0)));
    for (auto hex : body.hex) {
      for (auto &node : hex) node += offset;
      all.hex.push_back(hex);
    }
  }
  return all;
}

/// The two bodies, some of their elements DEs: what is tied as fix defe would.
struct Tied {
  Shape shape;
  int in_a;    // elements of A
  test::Block block;
  JointWorld world;
  TiedSurfaces springs;
  double stiffness = HUGE_VAL, frequency = 0.0;
  struct Hold {
    int de, slot;
    std::vector<TiedPiece> pieces;
    std::vector<int> ends;
    TiedPlace place;
  };
  std::vector<Hold> holds;

  /// a, b: whether an element of the bodies at these places of the face, 0..1, is converted
  template <class A, class B>
  Tied(const Shape &s, const A &a, const B &b, const TieRule &rule = {}) :
      shape(s), in_a(s.n * s.n * s.layers), block(mesh_of(s), which(s, a, b), glass),
      world(
          block, strong(),
          [](int) {
            return 0;
          },
          false)
  {
    find(rule);
    set_places({}, Mat3::Identity());
  }

  TiedElement element(int e) const
  {
    const HexCoords X = block.mesh.coords(e, block.mesh.X);
    const double V = fe::volume(X);
    return {X,
            e < in_a ? 5 : 4,
            V,
            glass.lambda() + 2.0 * glass.mu(),
            glass.rho * V,
            fe::max_frequency(X, glass)};
  }
  /// In the layer at the common face.
  bool at_face(int e) const
  {
    return e < in_a ? e >= in_a - shape.n * shape.n : e < in_a + shape.m * shape.m;
  }
  int nodes() const { return block.nodes(); }
  const test::Block::Particle &de(int d) const { return block.de[d]; }
  bool is_upper(int i) const
  {
    return i < nodes() ? i >= (shape.n + 1) * (shape.n + 1) * (shape.layers + 1)
                       : de(i - nodes()).element >= in_a;
  }
  Vec3 home(int i) const { return shape.R.transpose() * block.X[i]; }    // of the bodies' own axes

  /// Offsets as if all had been converted at x.
  void set_places(const Vectors &x, const Mat3 &F)
  {
    auto &jt = world.ranks[0]->jt;
    jt.place_first.assign(1, 0);
    jt.place_particle.clear();
    jt.place_weight.clear();
    for (auto &h : holds) {
      const auto &p = block.de[h.de];
      const int i = nodes() + h.de;
      const double depth =
          p.birth.face[h.slot].dot(p.birth.area_normal[h.slot]) / p.birth.area[h.slot];
      h.place = tied_place(h.pieces, depth);
      Vec3 dX = -block.X[i];
      for (std::size_t k = 0; k < h.ends.size(); k++) dX += h.place.weight[k] * block.X[h.ends[k]];
      if (!x.empty()) {
        Vec3 y = -x[i];
        for (std::size_t k = 0; k < h.ends.size(); k++) y += h.place.weight[k] * x[h.ends[k]];
        dX = F.inverse() * y;
      }
      jt.cell[h.de].dX[h.slot] = dX;
      jt.cell[h.de].face[h.slot] = h.place.share * dX;
      jt.add_place(h.de, h.slot, h.ends, h.place.weight);
      JointRecord &r = world.ranks[0]->records[h.de].slot[h.slot];
      r.area = p.birth.area[h.slot];
      for (int k = 0; k < 3; k++) r.normal[k] = p.birth.area_normal[h.slot][k] / r.area;
    }
    jt.tie_point.assign(3 * (jt.tie_node.size() + jt.places()) + 3, 0.0);
    world.ranks[0]->states->new_tables();
  }

  /// Of everything; returns the energy.
  double forces(const Vectors &x, Vectors &f)
  {
    world.x = x;
    world.forces(0.0, false);
    f = world.f;
    double energy = world.stored();
    const fe::EnhancedKernel kernel(glass);
    std::vector<double> energies(block.elements.size());
    fe::HexKernel::Output out;
    out.energy = energies.data();
    if (!block.elements.empty())
      kernel.add_forces(static_cast<int>(block.elements.size()),
                        reinterpret_cast<const int(*)[8]>(block.elements.data()), x[0].data(),
                        block.X[0].data(), f[0].data(), out);
    for (double e : energies) energy += e;
    return energy + springs.energy(x[0].data(), block.X[0].data(), f[0].data());
  }

 private:
  template <class A, class B> static std::vector<char> which(const Shape &s, const A &a, const B &b)
  {
    std::vector<char> converted;
    for (bool upper : {false, true}) {
      const int n = upper ? s.m : s.n;
      for (int k = 0; k < s.layers; k++)
        for (int j = 0; j < n; j++)
          for (int i = 0; i < n; i++) {
            const double u = (i + 0.5) / n, v = (j + 0.5) / n;
            converted.push_back(upper ? b(u, v) : a(u, v));
          }
    }
    return converted;
  }

  void find(const TieRule &rule)
  {
    const int ne = static_cast<int>(block.mesh.hex.size());
    std::vector<int> first(ne, -1);
    for (int d = block.des(); d-- > 0;) first[block.de[d].element] = d;
    struct Found {
      Tie tie;
      int a, b;
    };
    std::vector<Found> found;
    std::map<std::pair<int, int>, Hold> hold;    // by DE and slot
    for (int a = 0; a < in_a; a++)
      for (int b = in_a; b < ne; b++) {
        if (!at_face(a) || !at_face(b)) continue;
        const Tie tie = tie_faces(element(a), element(b), rule);
        if (tie.nodes == 0) continue;
        stiffness = std::min(stiffness, tie.stiffness);
        found.push_back({tie, a, b});
        for (const auto &[own, other] : {std::pair(a, b), std::pair(b, a)}) {
          if (!block.converted[own]) continue;
          const auto its = element(own), theirs = element(other);
          const auto quarters = tied_quarters(its, theirs);
          for (int q = 0; q < 4; q++) {
            if (quarters[q].area == 0.0) continue;
            const int d = first[own] + fe::hex_face[its.face][q];
            Hold &h = hold[{d, its.face}];
            h.de = d;
            h.slot = its.face;
            const bool discrete = block.converted[other];
            h.pieces.push_back({quarters[q].area,
                                discrete ? weights_of_des(quarters[q].weight) : quarters[q].weight,
                                discrete, depth_of_des(theirs)});
            for (int corner : fe::hex_face[theirs.face])
              h.ends.push_back(discrete ? nodes() + first[other] + corner
                                        : static_cast<int>(block.mesh.hex[other][corner]));
          }
        }
      }
    for (const auto &h : hold) holds.push_back(h.second);
    for (auto &[tie, a, b] : found) {
      tie.set_stiffness(stiffness);
      frequency = std::max(frequency, tie.frequency({true, true}));
      if (block.converted[a] || block.converted[b]) continue;
      int node[Tie::most_nodes];
      for (int k = 0; k < tie.nodes; k++)
        node[k] = static_cast<int>(k < 4 ? block.mesh.hex[a][fe::hex_face[5][k]]
                                         : block.mesh.hex[b][tied_node_of_b(4, k - 4)]);
      springs.add(tie, node);
    }
  }
};

bool all(double, double)
{
  return true;
}
bool none(double, double)
{
  return false;
}
bool left(double u, double)
{
  return u < 0.5;
}
bool right(double u, double)
{
  return u > 0.5;
}

Mat3 strain_of(const Mat3 &stress)
{
  return (1.0 + glass.nu) / glass.E * stress -
      glass.nu / glass.E * stress.trace() * Mat3::Identity();
}

/// Both bodies under one stress, one shifted by what the glue yields: largest force on a particle of which
/// `counts` says that it should have none, by the stress on a quarter of a face of its body.
template <class Counts> double residual(Tied &g, const Mat3 &S, const Counts &counts)
{
  const Mat3 &R = g.shape.R;
  Mat3 U = Mat3::Identity() + 2.0 * strain_of(S);
  U = Eigen::SelfAdjointEigenSolver<Mat3>(U).operatorSqrt();
  const Mat3 F = R * R * U * R.transpose();
  const Vec3 shift = R * R * U * S * Vec3(0.0, 0.0, 1.0) / g.stiffness;
  auto x = test::deformed(g.block.X, F);
  for (int i = 0; i < static_cast<int>(x.size()); i++)
    if (g.is_upper(i)) x[i] += shift;
  g.set_places(x, F);
  Vectors f;
  g.forces(x, f);
  double most = 0.0, elsewhere = 0.0;
  int count = 0;
  for (int i = 0; i < static_cast<int>(x.size()); i++) {
    if (g.block.mass[i] == 0.0) continue;
    const double edge = 0.5 / (g.is_upper(i) ? g.shape.m : g.shape.n);
    const double its = f[i].norm() / (S.norm() * edge * edge);
    if (counts(g.home(i))) {
      most = std::max(most, its);
      count++;
    } else
      elsewhere = std::max(elsewhere, its);
  }
  EXPECT_GT(count, 4);
  EXPECT_GT(elsewhere, 0.1);
  return most;
}

Mat3 uniaxial()
{
  Mat3 S = Mat3::Zero();
  S(2, 2) = 1e-3 * glass.E;
  return S;
}

Mat3 general()
{
  Mat3 S;
  S << 2.0, 0.5, 1.0, 0.5, -1.0, -0.7, 1.0, -0.7, 1.5;
  return 3e-4 * glass.E * S;
}

/// Nodes of the common face and the DEs beside it: nothing of the outer layers, whose free faces are not drawn.
bool near_the_face(const Vec3 &X)
{
  return X[2] > -0.08 && X[2] < 0.11;
}

/// What no DE at the rim, which lacks a joint, pulls at.
bool inside(const Vec3 &X)
{
  return near_the_face(X) && std::max(std::abs(X[0]), std::abs(X[1])) < 0.5 - 0.334;
}

}    // namespace

TEST(TiedQuarters, MakeUpWhatTheFacesHaveInCommon)
{
  for (const auto &[n, m] : {std::pair(1, 1), std::pair(3, 2), std::pair(2, 5)}) {
    const Tied g({n, m, tilt()}, all, none);
    double area = 0.0;
    std::map<int, double> of_node;
    for (const auto &h : g.holds) {
      double its = 0.0, sum = 0.0;
      for (const auto &p : h.pieces) its += p.area;
      EXPECT_NEAR(its, 0.25 / (n * n), 1e-12);
      area += its;
      Vec3 place = Vec3::Zero();
      for (std::size_t k = 0; k < h.ends.size(); k++) {
        sum += h.place.weight[k];
        of_node[h.ends[k]] += its * h.place.weight[k];
        place += h.place.weight[k] * g.block.X[h.ends[k]];
      }
      EXPECT_NEAR(sum, 1.0, 1e-12);
      // the middle of the quarter
      const auto &birth = g.de(h.de).birth;
      EXPECT_LT((place - birth.X - birth.face[h.slot]).norm(), 1e-12);
    }
    EXPECT_NEAR(area, 1.0, 1e-12);
    // integral of the shape functions
    for (const auto &[node, share] : of_node) {
      const Vec3 X = g.home(node);
      const double x = std::abs(std::abs(X[0]) - 0.5) < 1e-9 ? 0.5 : 1.0;
      const double y = std::abs(std::abs(X[1]) - 0.5) < 1e-9 ? 0.5 : 1.0;
      EXPECT_NEAR(share, x * y / (m * m), 1e-12);
    }
  }
}

TEST(TiedQuarters, OfMatchingMeshesAreJointsBetweenTwoDEs)
{
  const Tied g({2, 2, tilt()}, all, all);
  EXPECT_EQ(g.holds.size(), 32u);
  for (const auto &h : g.holds) {
    int partners = 0;
    for (std::size_t k = 0; k < h.ends.size(); k++)
      if (std::abs(h.place.weight[k]) > 1e-12) {
        EXPECT_NEAR(h.place.weight[k], 1.0, 1e-12);
        partners++;
        const Vec3 to = g.home(h.ends[k]) - g.home(g.nodes() + h.de);
        EXPECT_LT(std::hypot(to[0], to[1]), 1e-12);
      }
    EXPECT_EQ(partners, 1);
    EXPECT_NEAR(h.place.share, g.de(h.de).element < g.in_a ? 3.0 / 7.0 : 4.0 / 7.0, 1e-12);
  }
}

// Constant stress passes, whatever of both has converted.
TEST(TiedQuarters, PatchTestOfUniaxialStress)
{
  for (const auto &[n, m] : {std::pair(2, 2), std::pair(3, 2), std::pair(2, 3), std::pair(5, 3)}) {
    SCOPED_TRACE(std::to_string(n) + " on " + std::to_string(m));
    for (double gap : {0.0, 0.01}) {
      Shape s{n, m, tilt()};
      s.gap = gap;
      Tied below(s, all, none), above(s, none, all), both(s, all, all);
      EXPECT_LT(residual(below, uniaxial(), near_the_face), 1e-9) << gap;
      EXPECT_LT(residual(above, uniaxial(), near_the_face), 1e-9) << gap;
      EXPECT_LT(residual(both, uniaxial(), near_the_face), 1e-9) << gap;
    }
    Tied half({n, m, tilt()}, left, none);    // springs beside it
    EXPECT_LT(residual(half, uniaxial(), near_the_face), 1e-9);
  }
}

TEST(TiedQuarters, PatchTestOfAnyStress)
{
  for (const auto &[n, m] : {std::pair(4, 4), std::pair(5, 3), std::pair(3, 5), std::pair(4, 6)}) {
    SCOPED_TRACE(std::to_string(n) + " on " + std::to_string(m));
    const Shape s{n, m, tilt()};
    Tied below(s, all, none), above(s, none, all), both(s, all, all);
    EXPECT_LT(residual(below, general(), inside), 1e-9);
    EXPECT_LT(residual(above, general(), inside), 1e-9);
    EXPECT_LT(residual(both, general(), inside), 1e-9);
  }
}

// Where the border of what has converted lies on the common edges of both meshes, nothing is lost; where a
// quarter lies partly on nodes, partly on DEs, its place is not straight above its DE: 6 per cent.
TEST(TiedQuarters, PatchTestBesideWhatHasNotConverted)
{
  Tied fitting({4, 2, tilt()}, left, left), opposite({4, 2, tilt()}, left, right);
  EXPECT_LT(residual(fitting, uniaxial(), near_the_face), 1e-9);
  EXPECT_LT(residual(opposite, uniaxial(), near_the_face), 1e-9);
  Tied between({3, 2, tilt()}, all, left);
  EXPECT_LT(residual(between, uniaxial(), near_the_face), 1e-9);
  for (const auto &[n, m] : {std::pair(2, 3), std::pair(5, 3)}) {
    Tied g({n, m, tilt()}, all, left);
    const double rest = residual(g, uniaxial(), near_the_face);
    EXPECT_LT(rest, 0.07) << n << " " << m;
    EXPECT_GT(rest, 0.05) << n << " " << m;
  }
}

// What is seen of them is the stress of the bodies, whatever has converted: traction P N, on areas that make up the whole face.
TEST(TiedQuarters, AreSeenWithTheStressThatPasses)
{
  for (const auto &[n, m] : {std::pair(4, 4), std::pair(5, 3), std::pair(4, 6)})
    for (const Mat3 &S : {uniaxial(), general()}) {
      SCOPED_TRACE(std::to_string(n) + " on " + std::to_string(m));
      const Shape s{n, m, tilt()};
      Tied below(s, all, none), above(s, none, all), both(s, all, all);
      for (Tied *g : {&below, &above, &both}) {
        residual(*g, S, inside);
        const Mat3 R = g->shape.R;
        Mat3 U = Mat3::Identity() + 2.0 * strain_of(S);
        U = Eigen::SelfAdjointEigenSolver<Mat3>(U).operatorSqrt();
        const double glue = 1.0001 * S.col(2).norm() / g->stiffness;
        const Vec3 t = R * R * U * S.col(2);    // of the lower body's surface
        double area = 0.0;
        int seen = 0;
        for (const auto &h : g->holds) {
          const auto v = g->world.ranks[0]->states->view(6 * h.de + h.slot);
          const double sign = g->is_upper(g->nodes() + h.de) ? -1.0 : 1.0;
          const Vec3 normal = sign * R * R.col(2);
          const double share = g->world.ranks[0]->jt.share_of_place(h.de, h.slot);
          EXPECT_NEAR(share, h.place.share, 1e-12);
          area += share * g->de(h.de).birth.area[h.slot];
          EXPECT_EQ(v.damage + v.opening + v.slip, 0.0);
          EXPECT_GT(v.normal.dot(normal), 1.0 - 1e-5);
          // the face is where it was, but for the strain of what is between it and the DEs
          EXPECT_LT(std::abs((U.inverse() * R.transpose() * R.transpose() * v.point)[2]), glue);
          const Vec3 X = g->home(g->nodes() + h.de);
          if (!inside(Vec3(X[0], X[1], 0.0))) continue;
          seen++;
          EXPECT_NEAR(std::hypot(v.t_n, v.t_s), t.norm(), 1e-8 * t.norm());
          if (S.isDiagonal()) {
            EXPECT_NEAR(v.t_n, t.norm(), 1e-8 * t.norm());
            EXPECT_LT((v.normal - normal).norm(), 1e-9);
          }
          const Vec3 y = (v.point - g->world.x[g->nodes() + h.de]) / share;
          EXPECT_NEAR(v.length, y.norm(), 1e-12);
        }
        EXPECT_NEAR(area, 1.0, 1e-12);
        EXPECT_GE(seen, 4);
      }
    }
}

TEST(TiedQuarters, ForcesHaveNeitherSumNorMomentAndAreTheSlopeOfTheEnergy)
{
  Shape s{3, 2, tilt()};
  s.gap = 0.01;
  for (int k = 0; k < 3; k++) {
    Tied g = k == 0 ? Tied(s, all, none) : k == 1 ? Tied(s, left, all) : Tied(s, left, right);
    std::mt19937 random(7);
    auto x = test::deformed(g.block.X, tilt());
    for (auto &p : x) p += test::random_vector(random, 1e-3);
    Vectors f, other;
    g.forces(x, f);
    Vec3 sum = Vec3::Zero(), moment = Vec3::Zero();
    double most = 0.0;
    for (std::size_t i = 0; i < x.size(); i++) {
      sum += f[i];
      moment += x[i].cross(f[i]);
      most = std::max(most, f[i].norm());
    }
    EXPECT_LT(sum.norm(), 1e-11 * most);
    EXPECT_LT(moment.norm(), 1e-11 * most);
    for (std::size_t i = 0; i < x.size(); i += 7) {
      if (g.block.mass[i] == 0.0) continue;
      const int c = static_cast<int>(i % 3);
      const double here = x[i][c], step = 1e-7;
      x[i][c] = here + step;
      const double up = g.forces(x, other);
      x[i][c] = here - step;
      const double down = g.forces(x, other);
      x[i][c] = here;
      EXPECT_NEAR(f[i][c], -(up - down) / (2.0 * step), 1e-5 * most);
    }
  }
}

TEST(TiedQuarters, BrokenJointsDoNotTearIt)
{
  Tied g({2, 2, tilt()}, all, none);
  // every joint within A is cut: what is left are the DEs at the face, on their places
  auto &jt = g.world.ranks[0]->jt;
  for (int d = 0; d < jt.nde; d++)
    for (int s = 0; s < 6; s++)
      if (jt.nb[d][s] >= 0) jt.present[d] &= static_cast<unsigned char>(~(1u << s));
  auto x = g.block.X;
  const double pull = 1e-3;
  for (const auto &h : g.holds) x[g.nodes() + h.de] -= pull * g.shape.R.col(2);
  Vectors f;
  g.forces(x, f);
  const double b = 0.075, area = 1.0 / 16.0;
  for (const auto &h : g.holds) {
    const double force = f[g.nodes() + h.de].dot(g.shape.R.col(2));
    EXPECT_NEAR(force, glass.E * area * pull / b, 0.03 * force);    // a bar of one DE
  }
  g.world.forces(1e-9);
  g.world.forces(1e-9);
  EXPECT_TRUE(g.world.events.empty());
}

// The step that the mesh asks for is that of any state of conversion.
TEST(TiedQuarters, NoModeIsFasterThanTheBound)
{
  for (const auto &[n, m] :
       {std::pair(1, 1), std::pair(2, 2), std::pair(2, 1), std::pair(1, 2), std::pair(3, 2)})
    for (int state = 0; state < 3; state++) {
      Shape s{n, m};
      s.height_a = 1.0 / n;
      s.height_b = 1.0 / m;
      s.layers = 1;
      Tied g = state == 0 ? Tied(s, all, none)
          : state == 1    ? Tied(s, none, all)
                          : Tied(s, all, all);
      std::vector<int> living;
      for (std::size_t i = 0; i < g.block.X.size(); i++)
        if (g.block.mass[i] > 0.0) living.push_back(static_cast<int>(i));
      const int size = 3 * static_cast<int>(living.size());
      Eigen::MatrixXd K(size, size);
      Vectors x = g.block.X, up, down;
      const double step = 1e-6;
      for (int k = 0; k < size; k++) {
        double &c = x[living[k / 3]][k % 3];
        const double here = c;
        c = here + step;
        g.forces(x, up);
        c = here - step;
        g.forces(x, down);
        c = here;
        for (int i = 0; i < size; i++)
          K(i, k) = (down[living[i / 3]][i % 3] - up[living[i / 3]][i % 3]) / (2.0 * step);
      }
      Eigen::VectorXd root(size);
      for (int i = 0; i < size; i++) root[i] = 1.0 / std::sqrt(g.block.mass[living[i / 3]]);
      const Eigen::MatrixXd scaled =
          root.asDiagonal() * (0.5 * (K + K.transpose())) * root.asDiagonal();
      const double fastest =
          std::sqrt(Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd>(scaled, Eigen::EigenvaluesOnly)
                        .eigenvalues()
                        .maxCoeff());
      double bound = 2.0 / g.frequency;
      for (int e : {0, g.in_a}) {
        const auto element = g.element(e);
        const auto steps = discrete_steps(element.X, glass, element.mass, ElementSplit());
        bound = std::min({bound, steps.joints, steps.des});
      }
      EXPECT_GT(2.0 / fastest, bound) << n << " on " << m << ", " << state;
    }
}
