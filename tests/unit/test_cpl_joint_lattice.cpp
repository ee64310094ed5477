// Joints and ties of all DEs on plain arrays: the lattice as a list against one DE at a time, points of ties, and
// what a tie does to the nodes of its face.

#include "defe/coupling/joint_lattice.h"

#include "defe/coupling/conversion.h"

#include <Eigen/Geometry>
#include <gtest/gtest.h>
#include <random>

namespace defe {
namespace {

  class Random {
   public:
    explicit Random(unsigned seed) : engine(seed) {}
    Vec3 vector(double size)
    {
      std::uniform_real_distribution<double> u(-size, size);
      return Vec3(u(engine), u(engine), u(engine));
    }

   private:
    std::mt19937 engine;
  };

  const Mat3 turn = Eigen::AngleAxisd(0.7, Vec3(1.0, 2.0, -1.0).normalized()).toRotationMatrix();

  /// A face in the plane x = 1 about the axis, its nodes from (1, -1, -1) around.
  struct Face {
    Vec3 p[4] = {Vec3(1, -1, -1), Vec3(1, 1, -1), Vec3(1, 1, 1), Vec3(1, -1, 1)};
  };

  TEST(TiePoints, AreWeightedMeansOfTheNodes)
  {
    const double x[] = {0, 0, 0, 4, 0, 0, 4, 4, 0, 0, 4, 0};
    const int node[2][4] = {{0, 1, 2, 3}, {2, 3, 0, 1}};
    double point[6];
    const TieSpot spot[2] = {TieSpot::QUARTER, TieSpot::QUARTER};
    tie_points(2, node, spot, x, point);
    EXPECT_DOUBLE_EQ(point[0], 1.0);    // a quarter of the face, by its own corner
    EXPECT_DOUBLE_EQ(point[1], 1.0);
    EXPECT_DOUBLE_EQ(point[3], 3.0);
    EXPECT_DOUBLE_EQ(point[4], 3.0);
  }

  TEST(TiePoint, SeesItsFaceFromTheDE)
  {
    Face f;
    const TiePoint tie(Vec3(0.5, -0.5, -0.5), f.p);
    EXPECT_TRUE(tie.y().isApprox(Vec3(0.5, 0.0, 0.0), 1e-14));
    EXPECT_TRUE(tie.normal().isApprox(Vec3(1.0, 0.0, 0.0), 1e-14));
    const TiePoint from_behind(Vec3(1.5, -0.5, -0.5), f.p);
    EXPECT_TRUE(from_behind.normal().isApprox(Vec3(-1.0, 0.0, 0.0), 1e-14)) << "out of the DE";
    EXPECT_DOUBLE_EQ(from_behind.length(), 0.5);
  }

  TEST(TiePoint, ARigidMotionIsNoSlide)
  {
    Face f;
    Random random(1);
    const Vec3 de(0.4, -0.6, -0.3), w = random.vector(2.0), v0 = random.vector(3.0);
    const TiePoint tie(de, f.p);
    Vec3 v[4];
    for (int a = 0; a < 4; a++) v[a] = v0 + w.cross(f.p[a]);
    EXPECT_NEAR(tie.slide(v0 + w.cross(de), v).norm(), 0.0, 1e-13);
    for (auto &one : v) one += Vec3(0.0, 0.25, 0.0);
    EXPECT_TRUE(tie.slide(v0 + w.cross(de), v).isApprox(Vec3(0.0, 0.25, 0.0), 1e-12));
  }

  TEST(TiePoint, ReactionsKeepBothMomentaAndTheWork)
  {
    Face f;
    Random random(2);
    for (int k = 0; k < 5; k++) {
      for (auto &p : f.p) p = turn * p + random.vector(0.2);
      const Vec3 de = turn * Vec3(0.4, -0.6, -0.3), force = random.vector(10.0);
      const TiePoint tie(de, f.p);
      Vec3 on[4], sum = force, moment = de.cross(force);
      tie.reactions(force, on);
      for (int a = 0; a < 4; a++) {
        sum += on[a];
        moment += f.p[a].cross(on[a]);
      }
      EXPECT_NEAR(sum.norm(), 0.0, 1e-12 * force.norm());
      EXPECT_NEAR(moment.norm(), 0.0, 1e-11 * force.norm());

      // a force along the face does the work of the slide
      const Vec3 along = force - force.dot(tie.normal()) * tie.normal(), v_de = random.vector(1.0);
      Vec3 v[4];
      for (auto &one : v) one = random.vector(1.0);
      tie.reactions(along, on);
      double power = along.dot(v_de);
      for (int a = 0; a < 4; a++) power += on[a].dot(v[a]);
      EXPECT_NEAR(power, -along.dot(tie.slide(v_de, v)), 1e-11 * force.norm());
    }
  }

  // ---- corners ----

  /// A DE at node 0 of an element with joints to three others, in a cell of this shape.
  GeneralCell cell_with(const Mat3 &shape)
  {
    GeneralCell cell;
    cell.tie = 0;
    for (int s = 0; s < 6; s++) {
      const double sign = s % 2 ? 1.0 : -1.0;
      cell.dX[s] = sign * shape.col(s / 2);
      cell.face[s] = 0.5 * cell.dX[s];
    }
    return cell;
  }

  TEST(JointLattice, OtherCellsBehindOrthogonalOnes)
  {
    // two DEs of cubes and one of a slanted cell, each with six ends of its own, the last one a tie
    const CornerModuli table[1] = {{20e9, 30e9}};
    Mat3 slanted = Mat3::Identity();
    slanted(0, 1) = 0.3;
    slanted.col(2) *= 0.5;    // flat: selective shear
    const GeneralCell cells[3] = {cell_with(Mat3::Identity()), cell_with(Mat3::Identity()),
                                  cell_with(slanted)};
    Random random(3);
    std::vector<double> x, points;
    int self[3], nb[3][6];
    double len[3][6], half[3][6];
    unsigned char present[3] = {0x3f, 0x1f, 0x3f}, material[3] = {0, 0, 0};
    Vec3 y[3][6];
    for (int d = 0; d < 3; d++) {
      self[d] = static_cast<int>(x.size()) / 3;
      const Vec3 at(10.0 * d, 0.0, 0.0);
      for (double v : at) x.push_back(v);
      for (int s = 0; s < 6; s++) {
        y[d][s] = turn * (cells[d].dX[s] + random.vector(1e-3));
        len[d][s] = cells[d].dX[s].norm();
        half[d][s] = cells[d].face[s].norm();
        auto &list = s == 5 ? points : x;
        nb[d][s] = static_cast<int>(list.size()) / 3;
        if (s == 5) nb[d][s] = ~nb[d][s];
        for (int k = 0; k < 3; k++) list.push_back(at[k] + y[d][s][k]);
      }
    }
    const OrthogonalLattice lattice{2, self, nb, present, len, half, material};
    double forces[3][6][3], energy[3];
    CornerTable kept;
    for (unsigned char joints : {0x3f, 0x3f, 0x3d, 0x3f}) {    // one is lost and comes back
      present[2] = joints;
      corner_half_forces(lattice, 3, &cells[2], &kept, x.data(), points.data(), table, false,
                         forces, energy);
      EXPECT_EQ(kept.present, joints);
      EXPECT_GT(kept.terms, 0);
      for (int d = 0; d < 3; d++) {
        Vec3 expected[6];
        const double e = corner_strain_general(cells[d], y[d], present[d], table[0], expected);
        EXPECT_GT(e, 0.0);
        EXPECT_NEAR(energy[d], e, 1e-9 * e);
        for (int s = 0; s < 6; s++)
          EXPECT_NEAR((Vec3(forces[d][s]) - expected[s]).norm(), 0.0, 1e-9 * expected[0].norm());
      }
    }
  }

  TEST(TurnedNormal, FollowsTheJointsAndNotTheirStretch)
  {
    Mat3 slanted = Mat3::Identity();
    slanted(0, 1) = 0.3;
    const GeneralCell cell = cell_with(slanted);
    Vec3 y[6];
    for (int s = 0; s < 6; s++) y[s] = 1.01 * (turn * cell.dX[s]);
    const Vec3 normal(0.0, 1.0, 0.0), along(1.0, 0.0, 0.0);
    EXPECT_TRUE(turned_normal(cell, 0x3f, y, normal, along).isApprox(turn * normal, 1e-12));
    EXPECT_TRUE(turned_normal(cell, 0x15, y, normal, along).isApprox(turn * normal, 1e-12))
        << "three joints are enough";
    EXPECT_EQ(turned_normal(cell, 0x01, y, normal, along), along) << "one is not";
  }

}    // namespace
}    // namespace defe
