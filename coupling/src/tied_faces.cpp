// Which area two faces have in common, and the matrix of their tie (tied_surfaces.h).

#include "defe/coupling/facet.h"
#include "defe/coupling/tied_quarters.h"
#include "defe/fe/hex8.h"

#include <Eigen/Dense>

#include <algorithm>
#include <cmath>
#include <vector>

namespace defe {

using fe::HexCoords;
using Vec2 = Eigen::Vector2d;

namespace {

  constexpr double facing = -0.7;             // cosine of normals that face each other
  constexpr double default_distance = 0.1;    // in sizes of the smaller face
  constexpr double least_area = 1e-9;         // of the smaller face: rounding
  constexpr double at_one_place = 1e-10;      // natural coordinate

  /// Six-point rule (Dunavant 1985) for triangles: polynomials up to degree 4 are exact, and products of two
  /// bilinear functions are such.
  constexpr double rule[2][2] = {{0.22338158967801146570, 0.44594849091596488632},
                                 {0.10995174365532186764, 0.09157621350977074346}};

  struct Face {
    Vec3 node[4];    // outward
    Vec3 normal;
    double area;
    explicit Face(const TiedElement &e)
    {
      for (int k = 0; k < 4; k++) node[k] = e.X.col(fe::hex_face[e.face][k]);
      normal = facet_area_vector(node);
      area = normal.norm();
      normal /= area;
    }
    Vec3 middle() const { return 0.25 * (node[0] + node[1] + node[2] + node[3]); }
  };

  /// The mean plane of a face.
  struct Plane {
    Vec3 origin, e1, e2;
    explicit Plane(const Face &f) : origin(f.middle())
    {
      e1 = f.node[1] + f.node[2] - f.node[0] - f.node[3];
      e1 = (e1 - e1.dot(f.normal) * f.normal).normalized();
      e2 = f.normal.cross(e1);
    }
    Vec2 of(const Vec3 &x) const { return {(x - origin).dot(e1), (x - origin).dot(e2)}; }
  };

  double cross(const Vec2 &a, const Vec2 &b)
  {
    return a[0] * b[1] - a[1] * b[0];
  }

  /// The part of a polygon on the left of the line from a to b (Sutherland and Hodgman).
  std::vector<Vec2> left_of(const std::vector<Vec2> &polygon, const Vec2 &a, const Vec2 &b)
  {
    std::vector<Vec2> kept;
    for (std::size_t k = 0; k < polygon.size(); k++) {
      const Vec2 &p = polygon[k], &q = polygon[(k + 1) % polygon.size()];
      const double hp = cross(b - a, p - a), hq = cross(b - a, q - a);
      if (hp >= 0.0) kept.push_back(p);
      if ((hp > 0.0 && hq < 0.0) || (hp < 0.0 && hq > 0.0))
        kept.push_back(p + hp / (hp - hq) * (q - p));
    }
    return kept;
  }

  double area_of(const std::vector<Vec2> &polygon)
  {
    double sum = 0.0;
    for (std::size_t k = 2; k < polygon.size(); k++)
      sum += 0.5 * cross(polygon[k - 1] - polygon[0], polygon[k] - polygon[0]);
    return sum;
  }

  /// Natural coordinates of a place on a face that is given by its four nodes in its plane.
  Vec2 natural_on(const Vec2 node[4], const Vec2 &x)
  {
    Vec2 s = Vec2::Zero();
    for (int i = 0; i < 20; i++) {
      double N[4];
      facet_shape(s[0], s[1], N);
      Eigen::Matrix2d J;
      J.col(0) = 0.25 * ((1.0 - s[1]) * (node[1] - node[0]) + (1.0 + s[1]) * (node[2] - node[3]));
      J.col(1) = 0.25 * ((1.0 - s[0]) * (node[3] - node[0]) + (1.0 + s[0]) * (node[2] - node[1]));
      const Vec2 step =
          J.inverse() * (x - N[0] * node[0] - N[1] * node[1] - N[2] * node[2] - N[3] * node[3]);
      s += step;
      if (!(step.norm() > 1e-14)) break;
    }
    return s;
  }

  /// Natural coordinates of a place in or near an element, to begin with the middle of a face.
  Vec3 natural_in(const HexCoords &X, int face, const Vec3 &x)
  {
    Vec3 xi = Vec3::Zero();
    xi[face / 2] = face % 2 ? 1.0 : -1.0;
    for (int i = 0; i < 20; i++) {
      const Vec3 step = fe::jacobian(X, xi).inverse() * (x - fe::interpolate(X, xi));
      xi += step;
      if (!(step.norm() > 1e-14)) break;
    }
    return xi;
  }

  struct Point {
    double weight, N[4];    // of A's face
    Vec3 xi;                // in B
    double distance;
  };

  /// Points of integration over a polygon in A's plane.
  std::vector<Point> points_of(const std::vector<Vec2> &polygon, const Face &a, const Plane &plane,
                               const TiedElement &b)
  {
    Vec2 flat[4], middle = Vec2::Zero();
    for (int k = 0; k < 4; k++) flat[k] = plane.of(a.node[k]);
    for (const auto &p : polygon) middle += p / static_cast<double>(polygon.size());
    std::vector<Point> points;
    for (std::size_t k = 0; k < polygon.size(); k++) {
      const Vec2 corner[3] = {middle, polygon[k], polygon[(k + 1) % polygon.size()]};
      const double area = 0.5 * cross(corner[1] - corner[0], corner[2] - corner[0]);
      for (const auto &orbit : rule)
        for (int c = 0; c < 3; c++) {
          Point point;
          point.weight = orbit[0] * area;
          const Vec2 place = (1.0 - 2.0 * orbit[1]) * corner[c] +
              orbit[1] * (corner[(c + 1) % 3] + corner[(c + 2) % 3]);
          const Vec2 s = natural_on(flat, place);
          facet_shape(s[0], s[1], point.N);
          Vec3 X = Vec3::Zero();
          for (int n = 0; n < 4; n++) X += point.N[n] * a.node[n];
          point.xi = natural_in(b.X, b.face, X);
          Vec3 on_face = point.xi;
          on_face[b.face / 2] = b.face % 2 ? 1.0 : -1.0;
          point.distance = (X - fe::interpolate(b.X, on_face)).norm();
          points.push_back(point);
        }
    }
    return points;
  }

  /// What a polygon in A's plane has in common with B's face, which is seen from behind there.
  std::vector<Vec2> within(std::vector<Vec2> polygon, const Face &b, const Plane &plane)
  {
    for (int k = 3; k >= 0 && !polygon.empty(); k--)
      polygon = left_of(polygon, plane.of(b.node[(k + 1) % 4]), plane.of(b.node[k]));
    return polygon;
  }

  /// Largest share of a face's area that one of its nodes has.
  double largest_share(const Face &f)
  {
    double share[4] = {0.0, 0.0, 0.0, 0.0};
    const double g = 1.0 / std::sqrt(3.0);
    for (double s : {-g, g})
      for (double t : {-g, g}) {
        const Vec3 along =
            0.25 * ((1.0 - t) * (f.node[1] - f.node[0]) + (1.0 + t) * (f.node[2] - f.node[3]));
        const Vec3 across =
            0.25 * ((1.0 - s) * (f.node[3] - f.node[0]) + (1.0 + s) * (f.node[2] - f.node[1]));
        double N[4];
        facet_shape(s, t, N);
        for (int k = 0; k < 4; k++) share[k] += N[k] * along.cross(across).norm();
      }
    return *std::max_element(share, share + 4);
  }

  /// By what a tie of k = 1 raises the squared frequency of an element. A tie's matrix is not larger than the
  /// diagonal of the sums of its rows' magnitudes (Gershgorin), which is shared out over the masses of
  /// the elements at a node, as theirs are: the bound of Irons and Treharne holds with it.
  /// amount: largest sum of magnitudes of shape functions at a point, 2 if the faces are at one place.
  double raise(const TiedElement &e, const Face &f, double amount)
  {
    return amount * (amount - 1.0) * largest_share(f) / (0.125 * e.mass);
  }

  double compliance(const TiedElement &e, const Face &f)
  {
    return e.modulus > 0.0 ? e.volume / (f.area * e.modulus) : 0.0;
  }

  /// Adds to the matrix; returns the largest sum of magnitudes at a point.
  double integrate(Tie &tie, const std::vector<Point> &points, const TiedElement &b,
                   double stiffness)
  {
    double amount = 0.0;
    for (const auto &p : points) {
      Vec3 xi = p.xi;
      if (tie.nodes == 8) xi[b.face / 2] = b.face % 2 ? 1.0 : -1.0;
      const auto shape = fe::shape(xi);
      double w[Tie::most_nodes], magnitudes = 0.0;
      for (int k = 0; k < tie.nodes; k++) {
        w[k] = k < 4 ? p.N[k] : -shape[tied_node_of_b(b.face, k - 4)];
        magnitudes += std::abs(w[k]);
      }
      for (int row = 0; row < tie.nodes; row++)
        for (int column = 0; column <= row; column++)
          tie.M[row * (row + 1) / 2 + column] += stiffness * p.weight * w[row] * w[column];
      amount = std::max(amount, magnitudes);
    }
    return amount;
  }

}    // namespace

int tied_node_of_b(int face, int k)
{
  return k < 4 ? fe::hex_face[face][k] : fe::hex_face[face ^ 1][k - 4];
}

void Tie::set_stiffness(double k)
{
  for (double &m : M) m *= k / stiffness;
  stiffness = k;
}

double Tie::frequency(const std::array<bool, 2> &becomes) const
{
  double most = 0.0;
  for (int e = 0; e < 2; e++) {
    const double k = becomes[1 - e] ? std::max(stiffness, beside[1 - e]) : stiffness;
    most = std::max(most, squared[e] + k * raise[e]);
  }
  return std::sqrt(most);
}

Tie tie_faces(const TiedElement &a, const TiedElement &b, const TieRule &how)
{
  Tie tie;
  const Face fa(a), fb(b);
  if (!(fa.normal.dot(fb.normal) < facing)) return tie;
  const Plane plane(fa);
  std::vector<Vec2> polygon;
  for (const auto &x : fa.node) polygon.push_back(plane.of(x));
  polygon = within(std::move(polygon), fb, plane);
  const double smaller = std::min(fa.area, fb.area), area = area_of(polygon);
  if (!(area > least_area * smaller)) return tie;

  const auto points = points_of(polygon, fa, plane, b);
  double out_of_place = 0.0;
  for (const auto &p : points) {
    tie.distance = std::max(tie.distance, p.distance);
    out_of_place = std::max(out_of_place, std::abs(std::abs(p.xi[b.face / 2]) - 1.0));
  }
  tie.area = area;
  const double most = how.distance >= 0.0 ? how.distance : default_distance * std::sqrt(smaller);
  if (!(tie.distance <= most)) return tie;
  tie.nodes = out_of_place < at_one_place ? 8 : Tie::most_nodes;
  tie.stiffness = 2.0 * how.stiffness / (compliance(a, fa) + compliance(b, fb));
  const double amount = integrate(tie, points, b, tie.stiffness);
  tie.squared = {a.frequency * a.frequency, b.frequency * b.frequency};
  tie.raise = {raise(a, fa, amount), raise(b, fb, amount)};
  const double soft[2] = {compliance(a, fa), compliance(b, fb)};
  for (int e = 0; e < 2; e++) tie.beside[e] = soft[e] > 0.0 ? 4.0 / soft[e] : 0.0;
  return tie;
}

// ---- once they are DEs ----

std::array<TiedQuarter, 4> tied_quarters(const TiedElement &a, const TiedElement &b)
{
  std::array<TiedQuarter, 4> quarters;
  const Face fa(a), fb(b);
  if (!(fa.normal.dot(fb.normal) < facing)) return quarters;
  const Plane plane(fa);
  const Vec2 middle = plane.of(fa.middle());
  for (int q = 0; q < 4; q++) {
    const Vec2 node = plane.of(fa.node[q]);
    const auto beside = [&](int n) {
      return Vec2(0.5 * (node + plane.of(fa.node[n % 4])));
    };
    const auto polygon = within({node, beside(q + 1), middle, beside(q + 3)}, fb, plane);
    const double area = area_of(polygon);
    if (!(area > least_area * std::min(fa.area, fb.area))) continue;
    TiedQuarter &quarter = quarters[q];
    quarter.area = area;
    double sum = 0.0;
    for (const auto &p : points_of(polygon, fa, plane, b)) {
      Vec3 xi = p.xi;
      xi[b.face / 2] = b.face % 2 ? 1.0 : -1.0;
      const auto shape = fe::shape(xi);
      for (int k = 0; k < 4; k++) quarter.weight[k] += p.weight * shape[fe::hex_face[b.face][k]];
      sum += p.weight;
    }
    for (double &w : quarter.weight) w /= sum;
  }
  return quarters;
}

double depth_of_des(const TiedElement &e)
{
  return 0.25 * e.volume / Face(e).area;
}

std::array<double, 4> weights_of_des(const std::array<double, 4> &w)
{
  std::array<double, 4> of;
  for (int k = 0; k < 4; k++)
    of[k] = 2.25 * w[k] - 0.75 * (w[(k + 1) % 4] + w[(k + 3) % 4]) + 0.25 * w[(k + 2) % 4];
  return of;
}

TiedPlace tied_place(const std::vector<TiedPiece> &pieces, double depth)
{
  TiedPlace place;
  double sum = 0.0, area = 0.0;
  for (const auto &p : pieces) {
    const double share = p.discrete ? p.area * depth / (depth + p.depth) : p.area;
    sum += share;
    area += p.area;
    for (double w : p.weight) place.weight.push_back(share * w);
  }
  for (double &w : place.weight) w /= sum;
  place.share = sum / area;
  return place;
}

}    // namespace defe
