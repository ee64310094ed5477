#include "defe/coupling/de_rotation.h"

#include "defe/simd.h"

#include <Eigen/Geometry>
#include <Eigen/LU>
#include <algorithm>
#include <cmath>

namespace defe {

namespace {

  using simd::Mask;
  using simd::Pack;

  /// Least product of the stiffnesses against turning about the three axes, over the cube of their sum, for which joints say
  /// how a DE has turned: 0.037 for three or six perpendicular ones, 0.031 for two, 0.015 for two at 45 degrees, 0 on a line.
  /// Below, what little they say about the axis of the line is magnified: beside softening joints that is a stiffness beyond
  /// all others, and the time step too long.
  constexpr double line_limit = 0.015;

  /// The same of the present vectors: 10 degrees for two. What is left of the rotation about the line is noise, and it turns over
  /// as the joints pass through.
  constexpr double line_limit_now = 0.001;

  /// Least 1 / sum of 1/s, s the stiffnesses against turning about the three axes of joints of length 1, for which they hold a DE
  /// on all sides: 4/3 for six joints, 0.67 for three perpendicular ones, 0.55 for a T, 0.4 for two.
  constexpr double poor_limit = 0.6;

  struct Symmetric {
    Pack xx, yy, zz, xy, xz, yz;

    /// The adjugate, which is symmetric as well.
    Symmetric adjugate() const
    {
      return {yy * zz - yz * yz, xx * zz - xz * xz, xx * yy - xy * xy,
              xz * yz - xy * zz, xy * yz - xz * yy, xy * xz - xx * yz};
    }
    Pack determinant(const Symmetric &adj) const { return xx * adj.xx + xy * adj.xy + xz * adj.xz; }
    Pack trace() const { return xx + yy + zz; }

    void add_square(const Pack v[3], const Pack &by = simd::broadcast(1.0))
    {
      xx += by * v[0] * v[0];
      yy += by * v[1] * v[1];
      zz += by * v[2] * v[2];
      xy += by * v[0] * v[1];
      xz += by * v[0] * v[2];
      yz += by * v[1] * v[2];
    }

    /// Of a sum of squares of vectors: against turning them.
    Symmetric stiffness() const
    {
      const Pack t = trace();
      return {t - xx, t - yy, t - zz, -xy, -xz, -yz};
    }

    /// Of a sum of squares of vectors: these are not nearly on a line.
    Mask off_a_line(double limit) const
    {
      const Pack sum = 2.0 * trace();
      const Symmetric stiff = stiffness();
      return stiff.determinant(stiff.adjugate()) > limit * sum * sum * sum;
    }
  };

  /// Of some DEs, one per lane.
  struct Lanes {
    Pack A[3][3], size;    // sum y dX^T over its norm
    Pack straight;         // the largest eigenvalue without strain
    Mask defined, poor;

    Lanes(int n, const CrackEnd *end)
    {
      const auto of = [&](const auto &value) {
        return simd::generate([&](int l) {
          return value(end[l < n ? l : 0]);
        });
      };
      Symmetric P{}, now{}, unit{};    // sum dX dX^T, sum y y^T, and that of the directions of dX
      for (auto &row : A)
        for (Pack &a : row) a = Pack{};
      for (int s = 0; s < 6; ++s) {
        Pack X[3], y[3];
        for (int i = 0; i < 3; ++i) {
          X[i] = of([=](const CrackEnd &e) {
            return e.present >> s & 1u ? e.dX[s][i] : 0.0;
          });
          y[i] = of([=](const CrackEnd &e) {
            return e.present >> s & 1u ? e.y[s][i] : 0.0;
          });
        }
        P.add_square(X);
        const Pack square = X[0] * X[0] + X[1] * X[1] + X[2] * X[2];
        unit.add_square(X, square > 0.0 ? 1.0 / square : Pack{});
        now.add_square(y);
        for (int i = 0; i < 3; ++i)
          for (int k = 0; k < 3; ++k) A[i][k] += y[i] * X[k];
      }
      const Symmetric stiff = unit.stiffness(), adjugate = stiff.adjugate();
      poor = ~(stiff.determinant(adjugate) > poor_limit * adjugate.trace());
      straight = P.trace() /
          simd::sqrt(P.xx * P.xx + P.yy * P.yy + P.zz * P.zz +
                     2.0 * (P.xy * P.xy + P.xz * P.xz + P.yz * P.yz));
      Pack square = Pack{};
      for (const auto &row : A)
        for (const Pack &a : row) square += a * a;
      size = simd::sqrt(square);
      defined = P.off_a_line(line_limit) & now.off_a_line(line_limit_now) & (size > 0.0);
      const Pack inverse = defined ? 1.0 / size : Pack{};
      for (int i = 0; i < 3; ++i)
        for (int k = 0; k < 3; ++k) A[i][k] *= inverse;
    }
  };

  /// Largest root of the characteristic polynomial of Horn's matrix for A of Frobenius norm 1: the sum of the singular
  /// values (the least one negative if det A < 0). Newton's method, from above (all roots are real) or from that without
  /// strain: the polynomial is convex there, so that one step leads from below to above.
  Pack horn_eigenvalue(const Lanes &of)
  {
    const auto &A = of.A;
    Pack cofactors = Pack{}, det = Pack{};
    for (int i = 0; i < 3; ++i)
      for (int k = 0; k < 3; ++k) {
        const int i1 = (i + 1) % 3, i2 = (i + 2) % 3, k1 = (k + 1) % 3, k2 = (k + 2) % 3;
        const Pack c = A[i1][k1] * A[i2][k2] - A[i1][k2] * A[i2][k1];
        cofactors += c * c;
        if (i == 0) det += A[0][k] * c;
      }
    const Pack c0 = 1.0 - 4.0 * cofactors, g = of.straight;
    Pack x = (4.0 * g * g - 4.0) * g - 8.0 * det > 1.0 ? g : simd::broadcast(std::sqrt(3.0));
    Mask going = of.defined;
    for (int k = 0; k < 60 && simd::any(going); ++k) {
      const Pack p = ((x * x - 2.0) * x - 8.0 * det) * x + c0;
      const Pack slope = (4.0 * x * x - 4.0) * x - 8.0 * det;
      going &= slope > 0.0;
      const Pack step = going ? p / slope : Pack{};
      x -= step;
      going &= (k == 0 ? simd::abs(step) : step) > 1e-15;
    }
    return x;
  }

  /// Column c of the adjugate of a 4 x 4 matrix, by minors.
  Eigen::Vector4d adjugate_column(const Eigen::Matrix4d &N, int c)
  {
    Eigen::Vector4d v;
    for (int r = 0; r < 4; ++r) {
      Mat3 minor;
      for (int i = 0, p = 0; i < 4; ++i) {
        if (i == c) continue;
        for (int j = 0, q = 0; j < 4; ++j)
          if (j != r) minor(p, q++) = N(i, j);
        ++p;
      }
      v[r] = ((r + c) % 2 ? -1.0 : 1.0) * minor.determinant();
    }
    return v;
  }

  /// Eigenvector w x y z of a simple eigenvalue of Horn's matrix: the longest of the columns of the adjugate of N - x I,
  /// which is a multiple of v v^T. Of a rotation by any angle.
  Eigen::Vector4d longest_column(const Mat3 &A, double x)
  {
    Eigen::Matrix4d N;
    N(0, 0) = A.trace() - x;
    N.block<3, 1>(1, 0) = Vec3(A(2, 1) - A(1, 2), A(0, 2) - A(2, 0), A(1, 0) - A(0, 1));
    N.block<1, 3>(0, 1) = N.block<3, 1>(1, 0).transpose();
    N.block<3, 3>(1, 1) = A + A.transpose();
    N.block<3, 3>(1, 1).diagonal().array() -= A.trace() + x;
    Eigen::Vector4d v = adjugate_column(N, 0);
    for (int c = 1; c < 4; ++c) {
      const Eigen::Vector4d other = adjugate_column(N, c);
      if (other.squaredNorm() > v.squaredNorm()) v = other;
    }
    return v;
  }

  /// The eigenvector, normalized. With N - x I = [n a^T; a B] the column of w is (det B, -adj(B) a); only if it is
  /// short, i.e. the rotation by more than 120 degrees, the others are needed. By half a turn it is rounding alone, of any
  /// direction.
  void horn_eigenvector(const Lanes &of, const Pack &x, Pack q[4])
  {
    const auto &A = of.A;
    const Pack a[3] = {A[2][1] - A[1][2], A[0][2] - A[2][0], A[1][0] - A[0][1]};
    const Pack shift = A[0][0] + A[1][1] + A[2][2] + x;
    const Symmetric B{2.0 * A[0][0] - shift, 2.0 * A[1][1] - shift, 2.0 * A[2][2] - shift,
                      A[0][1] + A[1][0],     A[0][2] + A[2][0],     A[1][2] + A[2][1]};
    const Symmetric adj = B.adjugate();
    q[0] = B.determinant(adj);
    q[1] = -(adj.xx * a[0] + adj.xy * a[1] + adj.xz * a[2]);
    q[2] = -(adj.xy * a[0] + adj.yy * a[1] + adj.yz * a[2]);
    q[3] = -(adj.xz * a[0] + adj.yz * a[1] + adj.zz * a[2]);
    Pack square = q[0] * q[0] + q[1] * q[1] + q[2] * q[2] + q[3] * q[3];
    const Mask far = of.defined & ~((q[0] * q[0] >= 0.25 * square) & (square > 1e-16));
    if (__builtin_expect(simd::any(far), false))
      for (int l = 0; l < simd::width; ++l) {
        if (!far[l]) continue;
        Mat3 one;
        for (int i = 0; i < 3; ++i)
          for (int k = 0; k < 3; ++k) one(i, k) = A[i][k][l];
        const Eigen::Vector4d v = longest_column(one, x[l]);
        for (int k = 0; k < 4; ++k) q[k][l] = v[k];
        square[l] = v.squaredNorm();
      }
    const Pack inverse = 1.0 / simd::sqrt(square);
    for (int k = 0; k < 4; ++k) q[k] *= inverse;
  }

  void to_matrix(const Pack q[4], Pack R[3][3])
  {
    const Pack &w = q[0], &x = q[1], &y = q[2], &z = q[3];
    R[0][0] = 1.0 - 2.0 * (y * y + z * z);
    R[1][1] = 1.0 - 2.0 * (x * x + z * z);
    R[2][2] = 1.0 - 2.0 * (x * x + y * y);
    R[0][1] = 2.0 * (x * y - w * z);
    R[1][0] = 2.0 * (x * y + w * z);
    R[0][2] = 2.0 * (x * z + w * y);
    R[2][0] = 2.0 * (x * z - w * y);
    R[1][2] = 2.0 * (y * z - w * x);
    R[2][1] = 2.0 * (y * z + w * x);
  }

  /// Inverse of the stiffness against turning, in space: H = tr(A R^T) - A R^T, whose eigenvalues are sums of two
  /// singular values.
  Symmetric response(const Lanes &of, const Pack R[3][3])
  {
    const auto entry = [&](int i, int k) {
      return of.A[i][0] * R[k][0] + of.A[i][1] * R[k][1] + of.A[i][2] * R[k][2];
    };
    const Pack xx = entry(0, 0), yy = entry(1, 1), zz = entry(2, 2);
    const Symmetric H{yy + zz,
                      xx + zz,
                      xx + yy,
                      -0.5 * (entry(0, 1) + entry(1, 0)),
                      -0.5 * (entry(0, 2) + entry(2, 0)),
                      -0.5 * (entry(1, 2) + entry(2, 1))};
    Symmetric inverse = H.adjugate();
    const Pack by = 1.0 / (H.determinant(inverse) * of.size);
    for (Pack *p : {&inverse.xx, &inverse.yy, &inverse.zz, &inverse.xy, &inverse.xz, &inverse.yz})
      *p *= by;
    return inverse;
  }

  void rotate(int n, const CrackEnd *end, DERotation *out)
  {
    const Lanes lanes(n, end);
    Pack q[4], R[3][3];
    horn_eigenvector(lanes, horn_eigenvalue(lanes), q);
    to_matrix(q, R);
    const Symmetric by = response(lanes, R);
    for (int l = 0; l < n; ++l) {
      DERotation &r = out[l];
      if (!lanes.defined[l]) {
        r = DERotation{};
        continue;
      }
      r.defined = true;
      r.poor = lanes.poor[l];
      for (int i = 0; i < 3; ++i)
        for (int k = 0; k < 3; ++k) r.R(i, k) = R[i][k][l];
      for (int k = 0; k < 4; ++k) r.quaternion[k] = q[(k + 1) % 4][l];
      r.response << by.xx[l], by.xy[l], by.xz[l], by.xy[l], by.yy[l], by.yz[l], by.xz[l], by.yz[l],
          by.zz[l];
    }
  }

}    // namespace

void de_rotations(int n, const CrackEnd *end, DERotation *out)
{
  for (int first = 0; first < n; first += simd::width)
    rotate(std::min(simd::width, n - first), end + first, out + first);
}

const DERotation *known_rotation(const CrackEnd &end, unsigned use)
{
  if (use == end.present) return end.turn;
  const unsigned more = use & ~end.present;
  const bool one_more = more && (more & (more - 1)) == 0 && use == (end.present | more);
  return one_more ? end.with[__builtin_ctz(more)] : nullptr;
}

DERotation de_rotation(const CrackEnd &end, unsigned use)
{
  if (const DERotation *known = known_rotation(end, use)) return *known;
  const CrackEnd by{end.dX, end.y, use};
  DERotation r;
  de_rotations(1, &by, &r);
  return r;
}

// d theta = response sum (R dX) x dy, so moment . d theta = sum dy . ((response moment) x (R dX))
void add_moment(const DERotation &r, const CrackEnd &end, unsigned use, const Vec3 &moment,
                Vec3 force[6])
{
  const Vec3 turn = r.response * moment;
  for (int s = 0; s < 6; ++s)
    if (use >> s & 1u) force[s] += turn.cross(r.R * end.dX[s]);
}

}    // namespace defe
