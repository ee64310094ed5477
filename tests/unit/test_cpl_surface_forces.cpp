// Contact of surfaces on plain arrays: what the loop over the tables adds to the potential of pairs (see
// test_cpl_surface_contact.cpp): patches of a node together, histories, offsets, friction, balls.

#include "defe/coupling/surface_contact.h"
#include "defe/coupling/surface_near.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <random>
#include <set>

using namespace defe;

namespace {

constexpr double k_area = 3.0e12, spacing = 2e-3, depth_max = 1e-3, pi = 3.14159265358979323846;

class Memory : public ContactMemory {
 public:
  std::map<std::pair<int, int>, ContactHistory> all;
  bool inherit = false, born = false;
  std::set<int> joined_nodes;    // of the element that a DE was

  ContactHistory *find(int atom, int part) override
  {
    const auto it = all.find({atom, part});
    return it == all.end() ? nullptr : &it->second;
  }
  ContactHistory &make(int atom, int part) override { return all[{atom, part}]; }
  void drop(int atom, int part) override { all.erase({atom, part}); }
  bool tied(int, std::int64_t) override { return false; }
  bool newborn(int) override { return born; }
  bool inherits(int, int) override { return inherit; }
  bool was_joined(int, const ContactFacet &facet) override
  {
    return std::any_of(std::begin(facet.node), std::end(facet.node), [this](int node) {
      return joined_nodes.count(node) > 0;
    });
  }
};

/// Surfaces of square facets in z = const, and balls.
struct World {
  std::vector<double> x, v, omega, radius, mass, f, torque;
  SurfaceTables tables;
  Memory memory;
  double dt = 1e-8, friction = 0.0, ease = 0.0;
  bool moving = true, minimizing = false;
  struct Surface {
    int first_node, nodes, first_facet, facets;
  };
  std::vector<Surface> surfaces;

  int add_atom(const Vec3 &at, double r)
  {
    for (int k = 0; k < 3; ++k) {
      x.push_back(at[k]);
      v.push_back(0.0);
      omega.push_back(0.0);
    }
    radius.push_back(r);
    mass.push_back(r > 0.0 ? 1e-3 : 1e-5);
    return static_cast<int>(radius.size()) - 1;
  }

  Vec3 at(const std::vector<double> &a, int i) const
  {
    return Vec3(a[3 * i], a[3 * i + 1], a[3 * i + 2]);
  }

  /// n x n facets from `corner` on, seen from outside from above or from below.
  void add_surface(const Vec3 &corner, int n, double h, bool up)
  {
    const int part = static_cast<int>(surfaces.size()), first = static_cast<int>(radius.size());
    surfaces.push_back({first, (n + 1) * (n + 1), static_cast<int>(tables.facets.size()), n * n});
    for (int j = 0; j <= n; ++j)
      for (int i = 0; i <= n; ++i) add_atom(corner + Vec3(i * h, j * h, 0.0), 0.0);
    for (int j = 0; j < n; ++j)
      for (int i = 0; i < n; ++i) {
        const int a = first + i + (n + 1) * j;
        ContactFacet facet{};
        const int above[4] = {a, a + 1, a + n + 2, a + n + 1},
                  below[4] = {a, a + n + 1, a + n + 2, a + 1};
        std::copy_n(up ? above : below, 4, facet.node);
        facet.part = part;
        facet.element = static_cast<std::int64_t>(tables.facets.size());
        facet.area = h * h;
        facet.k_area = k_area;
        facet.half_xi = facet.half_eta = 0.5 * h;
        facet.depth_max = depth_max;
        facet.outer = true;
        const bool rim_x[2] = {i == n - 1, i == 0}, rim_y[2] = {j == n - 1, j == 0};
        for (int side = 0; side < 2; ++side) {
          facet.rim[side] = up ? rim_x[side] : rim_y[side];
          facet.rim[2 + side] = up ? rim_y[side] : rim_x[side];
        }
        tables.facets.push_back(facet);
      }
  }

  /// The nodes of one surface against the facets of another.
  void add_points(int nodes_of, int facets_of)
  {
    const Surface &own = surfaces[nodes_of], &other = surfaces[facets_of];
    for (int node = own.first_node; node < own.first_node + own.nodes; ++node) {
      ContactPoint point{};
      point.atom = node;
      point.part = facets_of;
      point.sharp = false;
      point.first = static_cast<int>(tables.candidates.size());
      point.count = other.facets;
      for (int k = 0; k < other.facets; ++k) tables.candidates.push_back(other.first_facet + k);
      point.own = static_cast<int>(tables.patches.size());
      for (int k = own.first_facet; k < own.first_facet + own.facets; ++k) {
        const int *n = tables.facets[k].node;
        const int corner = static_cast<int>(std::find(n, n + 4, node) - n);
        if (corner == 4) continue;
        tables.patches.push_back({k, corner});
        point.half = 1.1 * std::sqrt(0.5 * tables.facets[k].area);
      }
      point.nown = static_cast<int>(tables.patches.size()) - point.own;
      tables.points.push_back(point);
    }
  }

  void update_planes()
  {
    std::vector<int> nodes;
    for (const auto &facet : tables.facets) nodes.insert(nodes.end(), facet.node, facet.node + 4);
    tables.planes.resize(tables.facets.size());
    facet_planes(static_cast<int>(tables.facets.size()),
                 reinterpret_cast<const int(*)[4]>(nodes.data()), x.data(), tables.planes.data());
  }

  SurfaceArrays arrays()
  {
    SurfaceArrays a{};
    a.x = x.data();
    a.v = v.data();
    a.omega = omega.data();
    a.radius = radius.data();
    a.mass = mass.data();
    a.f = f.data();
    a.torque = torque.data();
    a.dt = dt;
    a.friction = friction;
    a.moving = moving;
    a.minimizing = minimizing;
    a.ease = ease;
    a.virial = true;
    return a;
  }

  SurfaceResult evaluate()
  {
    update_planes();
    f.assign(x.size(), 0.0);
    torque.assign(x.size(), 0.0);
    return surface_forces(tables, arrays(), memory);
  }

  double energy()
  {
    update_planes();
    const auto kept = memory.all;
    SurfaceArrays a = arrays();
    a.energy_only = true;
    const double sum = surface_forces(tables, a, memory).energy;
    memory.all = kept;
    return sum;
  }

  /// As if all overlaps had come by motion: histories that are deeper than anything.
  void let_overlap()
  {
    for (const auto &point : tables.points) {
      ContactHistory history{};
      history.overlap = 1.0;
      memory.all[{point.atom, point.part}] = history;
    }
  }

  void move(int surface, const Vec3 &by)
  {
    const Surface &s = surfaces[surface];
    for (int i = s.first_node; i < s.first_node + s.nodes; ++i)
      for (int k = 0; k < 3; ++k) x[3 * i + k] += by[k];
  }

  void set_velocity(int surface, const Vec3 &to)
  {
    const Surface &s = surfaces[surface];
    for (int i = s.first_node; i < s.first_node + s.nodes; ++i)
      for (int k = 0; k < 3; ++k) v[3 * i + k] = to[k];
  }

  Vec3 force_on(int surface) const
  {
    Vec3 sum = Vec3::Zero();
    const Surface &s = surfaces[surface];
    for (int i = s.first_node; i < s.first_node + s.nodes; ++i) sum += at(f, i);
    return sum;
  }

  /// All forces together, and their moments, against the largest one.
  void expect_balance() const
  {
    Vec3 sum = Vec3::Zero(), moment = Vec3::Zero();
    double largest = 0.0, way = 0.0;
    for (int i = 0; i < static_cast<int>(radius.size()); ++i) {
      sum += at(f, i);
      moment += at(x, i).cross(at(f, i)) + at(torque, i);
      largest = std::max(largest, at(f, i).norm());
      way = std::max(way, at(x, i).norm());
    }
    EXPECT_GT(largest, 0.0);
    EXPECT_LT(sum.norm(), 1e-12 * largest);
    EXPECT_LT(moment.norm(), 1e-12 * largest * way);
  }
};

/// A block of 3 x 3 facets that has sunk into a plane of 7 x 7.
World block_on_plane(double depth)
{
  World w;
  w.add_surface(Vec3::Zero(), 7, spacing, true);
  w.add_surface(Vec3(2 * spacing, 2 * spacing, -depth), 3, spacing, false);
  w.add_points(0, 1);
  w.add_points(1, 0);
  return w;
}
constexpr double block_area = 9 * spacing * spacing;

double psi(double depth)
{
  return penalty_potential(depth, depth_max).energy;
}
double push_at(double depth)
{
  return block_area * k_area * penalty_potential(depth, depth_max).force;
}

/// Turns a surface about its middle and shifts it.
void tilt(World &w, int surface, const Vec3 &axis, double angle)
{
  const auto &s = w.surfaces[surface];
  Vec3 middle = Vec3::Zero();
  for (int i = s.first_node; i < s.first_node + s.nodes; ++i) middle += w.at(w.x, i) / s.nodes;
  const Vec3 u = axis.normalized();
  for (int i = s.first_node; i < s.first_node + s.nodes; ++i) {
    const Vec3 r = w.at(w.x, i) - middle;
    const Vec3 turned =
        std::cos(angle) * r + std::sin(angle) * u.cross(r) + (1.0 - std::cos(angle)) * u.dot(r) * u;
    for (int k = 0; k < 3; ++k) w.x[3 * i + k] = middle[k] + turned[k];
  }
}

}    // namespace

TEST(SurfaceForces, BlockOnPlaneIsThePressureTimesItsArea)
{
  const double depth = 4e-5;
  World w = block_on_plane(depth);
  w.let_overlap();
  const SurfaceResult r = w.evaluate();
  EXPECT_NEAR(r.energy, k_area * block_area * psi(depth), 1e-12 * r.energy);
  EXPECT_NEAR(w.force_on(1)[2], push_at(depth), 1e-12 * push_at(depth));
  EXPECT_LT(w.force_on(1).head<2>().norm(), 1e-12 * push_at(depth));
  EXPECT_NEAR(w.energy(), r.energy, 1e-14 * r.energy);
  w.expect_balance();
  // sum of x f: only zz, the depth times the force
  EXPECT_NEAR(r.virial[2], -depth * push_at(depth), 1e-10 * depth * push_at(depth));
  EXPECT_EQ(r.offset_count, 0);
  EXPECT_TRUE(r.let_through.empty());
}

TEST(SurfaceForces, VirialIsLeftOutIfNobodyAsks)
{
  World w = block_on_plane(4e-5);
  w.let_overlap();
  const SurfaceResult with = w.evaluate();
  const auto forces = w.f;
  w.update_planes();
  w.f.assign(w.x.size(), 0.0);
  SurfaceArrays a = w.arrays();
  a.virial = false;
  const SurfaceResult without = surface_forces(w.tables, a, w.memory);
  EXPECT_LT(with.virial[2], 0.0);
  for (double virial : without.virial) EXPECT_EQ(virial, 0.0);
  EXPECT_EQ(w.f, forces);
  EXPECT_EQ(without.energy, with.energy);
}

// Somewhere, tilted: forces are the derivative of the energy, also where patches are taken together
TEST(SurfaceForces, AreTheDerivativeOfTheEnergy)
{
  std::mt19937 random(3);
  std::uniform_real_distribution<double> uniform(-1.0, 1.0);
  for (int trial = 0; trial < 6; ++trial) {
    World w = block_on_plane(1e-4);
    tilt(w, 1, Vec3(uniform(random), uniform(random), uniform(random)), 0.02 * uniform(random));
    w.move(1, spacing * Vec3(uniform(random), uniform(random), 0.0));
    w.let_overlap();
    w.evaluate();
    const auto forces = w.f;
    w.expect_balance();
    double largest = 0.0;
    for (double f : forces) largest = std::max(largest, std::abs(f));
    const double step = 1e-9;
    for (size_t c = 0; c < w.x.size(); c += 7) {
      const double here = w.x[c];
      w.x[c] = here + step;
      const double plus = w.energy();
      w.x[c] = here - step;
      const double minus = w.energy();
      w.x[c] = here;
      EXPECT_NEAR(forces[c], (minus - plus) / (2.0 * step), 1e-5 * largest)
          << "trial " << trial << " component " << c;
    }
  }
}

// The loop takes all patches of a node together where it can: against the sum over patches, one by one
TEST(SurfaceForces, PatchesTogetherAreTheirSum)
{
  std::mt19937 random(5);
  std::uniform_real_distribution<double> uniform(-1.0, 1.0);
  for (int trial = 0; trial < 20; ++trial) {
    World w;
    w.add_surface(Vec3::Zero(), 7, spacing, true);
    w.add_surface(Vec3(2.5 * spacing, 2.5 * spacing, -1e-4), 2, 0.7 * spacing, false);
    w.add_points(1, 0);
    // up to 2 degrees: as parallel as counts; up to 20: each patch has its own facing factor
    tilt(w, 1, Vec3(uniform(random), uniform(random), uniform(random)),
         (trial % 2 ? 0.02 : 0.3) * uniform(random));
    w.move(1, (trial % 4 < 2 ? 1.0 : 3.5) * spacing * Vec3(uniform(random), uniform(random), 0.0));
    w.let_overlap();
    const SurfaceResult r = w.evaluate();

    double energy = 0.0;
    std::vector<double> forces(w.x.size(), 0.0);
    const auto add = [&](int node, const Vec3 &force) {
      for (int k = 0; k < 3; ++k) forces[3 * node + k] += force[k];
    };
    for (const auto &point : w.tables.points)
      for (int m = point.own; m < point.own + point.nown; ++m)
        for (int k = point.first; k < point.first + point.count; ++k) {
          const auto &patch = w.tables.patches[m];
          const auto &own = w.tables.facets[patch.facet];
          const auto &facet = w.tables.facets[w.tables.candidates[k]];
          const auto &o = w.tables.planes[patch.facet];
          const auto &g = w.tables.planes[w.tables.candidates[k]];
          const double half = 0.5 * own.half_xi;
          SurfacePair pair{0.25 * k_area * own.area, half / facet.half_xi,
                           half / facet.half_eta,    facet.half_xi,
                           facet.half_eta,           facet.depth_max};
          std::copy_n(facet.rim, 4, pair.rim);
          pair.weight = {side_weight(own.area, facet.area), false};
          const SurfaceContact c = patch_on_facet(o, patch.corner, w.at(w.x, point.atom), g, pair);
          if (c.share == 0.0) continue;
          Vec3 on_node = Vec3::Zero();
          FacetLoad on_own, on_facet;
          energy += patch_force(c, 0.0, o, patch.corner, g, pair, on_node, on_own, on_facet).energy;
          add(point.atom, on_node);
          for (int n = 0; n < 4; ++n) {
            add(own.node[n], on_own.on_node(n));
            add(facet.node[n], on_facet.on_node(n));
          }
        }
    ASSERT_GT(energy, 0.0);
    EXPECT_NEAR(r.energy, energy, 1e-10 * energy) << "trial " << trial;
    double largest = 0.0;
    for (double f : forces) largest = std::max(largest, std::abs(f));
    for (size_t c = 0; c < forces.size(); ++c)
      EXPECT_NEAR(w.f[c], forces[c], 1e-10 * largest) << "trial " << trial << " component " << c;
  }
}

TEST(SurfaceForces, OverlapThatNoMotionMadePushesNothing)
{
  const double depth = 4e-5;
  World w = block_on_plane(depth);
  SurfaceResult r = w.evaluate();
  EXPECT_EQ(r.energy, 0.0);
  for (double f : w.f) EXPECT_EQ(f, 0.0);
  // 16 nodes of the block and the 16 of the plane below it
  EXPECT_EQ(r.offset_count, 32);
  EXPECT_NEAR(r.offset_max, depth, 1e-15);

  // deeper by motion: only what has come since counts
  const double more = 1e-6, speed = more / w.dt;
  w.set_velocity(1, Vec3(0, 0, -speed));
  w.move(1, Vec3(0, 0, -more));
  r = w.evaluate();
  EXPECT_EQ(r.offset_count, 0);
  EXPECT_NEAR(r.energy, k_area * block_area * psi(more), 1e-9 * r.energy);
  EXPECT_NEAR(w.force_on(1)[2], push_at(more), 1e-9 * push_at(more));
  w.expect_balance();

  // gone and come back: it was an overlap of then
  w.set_velocity(1, Vec3(0, 0, 2 * depth / w.dt));
  w.move(1, Vec3(0, 0, 2 * depth));
  r = w.evaluate();
  EXPECT_EQ(r.energy, 0.0);
  EXPECT_TRUE(w.memory.all.empty());
  w.set_velocity(1, Vec3(0, 0, -2 * depth / w.dt));
  w.move(1, Vec3(0, 0, -2 * depth));
  r = w.evaluate();
  EXPECT_EQ(r.offset_count, 0);
  EXPECT_NEAR(r.energy, k_area * block_area * psi(depth + more), 1e-9 * r.energy);
}

// Iterations of a minimiser have no velocity by which a point gets deeper, and still press it in
TEST(SurfaceForces, IterationsOfAMinimizerMakeNoOffset)
{
  const double depth = 4e-5;
  World w = block_on_plane(-1e-6);
  w.moving = false;
  SurfaceResult r = w.evaluate();
  w.minimizing = true;
  w.move(1, Vec3(0, 0, -1e-6 - depth));
  r = w.evaluate();
  EXPECT_EQ(r.offset_count, 0);
  EXPECT_NEAR(w.force_on(1)[2], push_at(depth), 1e-12 * push_at(depth));
  // an overlap at the start of a minimisation is one
  World first = block_on_plane(depth);
  first.moving = false;
  r = first.evaluate();
  EXPECT_EQ(r.offset_count, 32);
  EXPECT_EQ(r.energy, 0.0);
}

// A jump that no motion has made (here to a place where all of the block is over the surface) has no work:
// what it changes is booked, and the account stays closed
TEST(SurfaceForces, OverlapRaisedInMotionIsBooked)
{
  const double depth = 4e-5;
  // only the block's nodes press: those of the surface would lose what they press on at once
  World w;
  w.add_surface(Vec3::Zero(), 7, spacing, true);
  w.add_surface(Vec3(2 * spacing, 2 * spacing, -depth), 3, spacing, false);
  w.add_points(1, 0);
  const double aside = 4.6 * spacing;
  w.move(1, Vec3(aside, 0, 0));
  w.let_overlap();
  SurfaceResult r = w.evaluate();
  r = w.evaluate();    // histories know their energy from here on
  const double before = r.energy;
  EXPECT_GT(before, 0.0);
  EXPECT_LT(before, 0.4 * k_area * block_area * psi(depth));
  w.move(1, Vec3(-aside, 0, -0.2 * depth));
  r = w.evaluate();
  EXPECT_GT(r.offset_count, 0);
  EXPECT_GT(std::abs(r.energy - before), 1e-3 * before);
  double booked = 0.0;
  for (const auto &one : r.let_through) {
    EXPECT_FALSE(one.counts);
    booked += one.energy;
  }
  EXPECT_NEAR(r.energy + booked, before, 1e-12 * before);
}

// What stands for a contact that was there already has its overlap at once; its energy is reported
TEST(SurfaceForces, InheritedOverlap)
{
  const double depth = 4e-5;
  World w = block_on_plane(depth);
  w.memory.inherit = true;
  const SurfaceResult r = w.evaluate();
  EXPECT_EQ(r.offset_count, 0);
  EXPECT_NEAR(w.force_on(1)[2], push_at(depth), 1e-12 * push_at(depth));
  double inherited = 0.0;
  for (const auto &one : r.inherited) inherited += one.energy;
  EXPECT_EQ(r.inherited.size(), 32u);
  EXPECT_NEAR(inherited, r.energy, 1e-12 * r.energy);
}

namespace {

/// A DE of part 0 over the first facet; its number.
int add_de(World &w, const Vec3 &X, double r, double half)
{
  ContactPoint point{};
  point.atom = w.add_atom(X, r);
  point.part = 0;
  point.count = 1;
  point.r = r;
  point.half = half;
  point.area = 4.0 * half * half;
  point.k_own = k_area;
  w.tables.candidates.push_back(0);
  w.tables.points.push_back(point);
  return point.atom;
}

}    // namespace

/// A DE beside a distorted element lies below the plane of one of its faces, and over its rim by a hair: little overlap, but
/// far down. Once 3e-5 of 6e-3 J came from nothing so.
TEST(SurfaceForces, WhatADEIsBornBelowPushesNothing)
{
  const double r = 2.4e-4, half = 2.5e-4, below = 2e-4, hair = 1e-6;
  const auto beside = [&](double over) {
    World w;
    w.add_surface(Vec3::Zero(), 2, spacing, true);    // which goes on beyond that edge
    const int de = add_de(w, Vec3(spacing + half - over, 0.5 * spacing, -below), r, half);
    w.v[3 * de] = -2.0;
    return w;
  };
  World grown = beside(hair);
  ASSERT_GT(grown.evaluate().energy, 0.0) << "motion might have made it";

  World born = beside(hair);
  const int de = born.tables.points[0].atom;
  born.memory.born = true;
  EXPECT_EQ(born.evaluate().energy, 0.0);
  EXPECT_EQ(born.at(born.f, de).norm(), 0.0);
  born.memory.born = false;
  const double step = 2.0 * born.dt;
  for (int k = 0; k < 20; ++k) {    // nor does it when it goes on sideways
    born.x[3 * de] -= step;
    EXPECT_EQ(born.evaluate().energy, 0.0);
  }
  born.v[3 * de] = 0.0;
  born.v[3 * de + 2] = -2.0;
  born.x[3 * de + 2] -= step;    // only deeper
  EXPECT_GT(born.evaluate().energy, 0.0);
}

// A DE that is born below a face of another part takes over a contact of its element, but none with a neighbour that shared
// nodes with it: there was none.
TEST(SurfaceForces, WhatADEIsBornBelowIsInheritedFromOtherBodiesOnly)
{
  const double r = 2.4e-4, half = 2.5e-4, depth = 2e-5;
  const auto below = [&] {
    World w;
    w.add_surface(Vec3::Zero(), 1, spacing, true);
    add_de(w, Vec3(0.5 * spacing, 0.5 * spacing, r - depth), r, half);
    w.memory.born = w.memory.inherit = true;
    return w;
  };
  World pressed = below();
  pressed.memory.joined_nodes = {17, 18};    // of other faces
  const SurfaceResult taken = pressed.evaluate();
  ASSERT_EQ(taken.inherited.size(), 1u);
  const double exact = 0.5 * k_area * 4.0 * half * half * depth * depth;
  EXPECT_NEAR(taken.energy, exact, 0.02 * exact);    // hardens with the depth
  EXPECT_EQ(taken.inherited[0].energy, taken.energy);

  for (int node = 0; node < 4; ++node) {
    World joined = below();
    joined.memory.joined_nodes = {node};
    const SurfaceResult none = joined.evaluate();
    EXPECT_TRUE(none.inherited.empty());
    EXPECT_EQ(none.energy, 0.0);
    EXPECT_EQ(joined.at(joined.f, joined.tables.points[0].atom).norm(), 0.0);
    // from then on motion presses it
    joined.memory.born = false;
    const int de = joined.tables.points[0].atom;
    const double deeper = 1e-8;
    joined.v[3 * de + 2] = -deeper / joined.dt;
    joined.x[3 * de + 2] -= deeper;
    const double more = 0.5 * k_area * 4.0 * half * half * deeper * deeper;
    EXPECT_NEAR(joined.evaluate().energy, more, 1e-3 * more);
  }
}

TEST(SurfaceForces, EasingBooksItsWork)
{
  const double depth = 4e-5;
  World w = block_on_plane(depth);
  w.moving = false;
  SurfaceResult r = w.evaluate();
  EXPECT_EQ(r.energy, 0.0);
  EXPECT_EQ(r.offset_count, 32);
  EXPECT_EQ(r.eased, 0.0);

  // at rest: the mean force on the offset, which is what the contact stores but for the length of the steps
  w.moving = true;
  w.ease = 0.1;
  double eased = 0.0, offset = depth, expected = 0.0;
  const auto step = [&](double sunk) {
    const double before = w.force_on(1)[2];
    r = w.evaluate();
    eased += r.eased;
    expected += 0.5 * (before + push_at(sunk - 0.9 * offset)) * 0.1 * offset;
    offset *= 0.9;
    EXPECT_NEAR(w.force_on(1)[2], push_at(sunk - offset), 1e-10 * push_at(sunk - offset));
  };
  for (int k = 0; k < 5; ++k) step(depth);
  EXPECT_NEAR(r.energy, k_area * block_area * psi(depth - offset), 1e-10 * r.energy);
  EXPECT_NEAR(eased, expected, 1e-11 * expected);
  EXPECT_NEAR(eased, r.energy, 1e-3 * r.energy);

  // while the block is lifted: and the work that it does
  const double lift = 5e-7;
  w.set_velocity(1, Vec3(0, 0, lift / w.dt));
  double work = 0.0;
  eased = expected = 0.0;
  const double stored = r.energy;
  for (int k = 1; k <= 5; ++k) {
    work += 0.5 * lift * w.force_on(1)[2];
    w.move(1, Vec3(0, 0, lift));
    step(depth - k * lift);
    work += 0.5 * lift * w.force_on(1)[2];
  }
  EXPECT_GT(work, 0.1 * stored);
  EXPECT_NEAR(eased, expected, 1e-11 * expected);
  EXPECT_NEAR(eased, r.energy - stored + work, 1e-4 * work);
}

TEST(SurfaceForces, LetThroughIsReportedInTheStepInWhichItHappens)
{
  World w;
  w.add_surface(Vec3::Zero(), 7, spacing, true);
  w.add_surface(Vec3(2 * spacing, 2 * spacing, -0.93 * depth_max), 3, spacing, false);
  w.add_points(1, 0);
  w.let_overlap();
  SurfaceResult r = w.evaluate();
  EXPECT_GT(w.force_on(1)[2], 0.0);
  EXPECT_TRUE(r.let_through.empty());

  const double step = 0.2 * depth_max;
  w.set_velocity(1, Vec3(0, 0, -step / w.dt));
  w.move(1, Vec3(0, 0, -step));
  r = w.evaluate();
  for (double f : w.f) EXPECT_EQ(f, 0.0);
  double energy = 0.0;
  for (const auto &one : r.let_through) {
    EXPECT_NEAR(one.depth, 1.13 * depth_max, 1e-12 * depth_max);
    EXPECT_TRUE(one.counts);
    energy += one.energy;
  }
  std::set<int> nodes;    // (each may be over several facets)
  for (const auto &one : r.let_through) nodes.insert(one.atom);
  EXPECT_EQ(nodes.size(), 16u);
  // what the block's side held, half of the contact: the mean of before and after
  const double held =
      0.5 * k_area * block_area * 0.5 * (psi(0.93 * depth_max) + psi(1.13 * depth_max));
  EXPECT_NEAR(energy, held, 1e-10 * held);

  w.move(1, Vec3(0, 0, -step));
  EXPECT_TRUE(w.evaluate().let_through.empty());

  // and back: what it is given comes off what was lost, and is not counted. (The history that it had is gone:
  // it is let in again as the contact that it was.)
  w.set_velocity(1, Vec3(0, 0, step / w.dt));
  w.move(1, Vec3(0, 0, step));
  EXPECT_TRUE(w.evaluate().let_through.empty());
  w.move(1, Vec3(0, 0, step));
  w.let_overlap();
  r = w.evaluate();
  energy = 0.0;
  for (const auto &one : r.let_through) {
    EXPECT_FALSE(one.counts);
    energy += one.energy;
  }
  EXPECT_NEAR(energy, -held, 1e-10 * held);
}

TEST(SurfaceForces, SlidingBlockRubs)
{
  const double depth = 4e-5, mu = 0.3, speed = 10.0;
  World w = block_on_plane(depth);
  w.let_overlap();
  w.friction = mu;
  w.dt = 1e-8;
  w.set_velocity(1, Vec3(speed, 0, 0));
  const double N = push_at(depth);
  SurfaceResult r;
  double work = 0.0, rubbed = 0.0;
  for (int step = 0; step < 400; ++step) {
    r = w.evaluate();
    // (the block is held where it is: only its velocity counts for friction)
    work += -w.force_on(1)[0] * speed * w.dt;
    rubbed += r.friction;
  }
  EXPECT_NEAR(w.force_on(1)[0], -mu * N, 1e-10 * N);
  EXPECT_NEAR(w.force_on(1)[2], N, 1e-10 * N);
  EXPECT_NEAR(r.friction, mu * N * speed * w.dt, 1e-10 * mu * N * speed * w.dt);
  w.expect_balance();
  // what is not rubbed off is in the springs. The spring grows before it pulls: half a step of its force
  EXPECT_NEAR(rubbed + r.springs, work, 0.5 * mu * N * speed * w.dt + 1e-9 * work);
  const double springs = 0.5 * mu * N * mu * N / (k_area * block_area);
  EXPECT_NEAR(r.springs, springs, 1e-10 * springs);

  // lifted off: the springs are let go, and what they held is lost
  w.set_velocity(1, Vec3(0, 0, 1.0));
  w.move(1, Vec3(0, 0, 2 * depth));
  r = w.evaluate();
  EXPECT_NEAR(r.friction, springs, 1e-10 * springs);
  EXPECT_EQ(r.springs, 0.0);
}

// A block that sticks is pushed over the rim: its springs get softer as their area does, or are let go. Nothing comes from
// nothing, and nothing is lost that is not said.
TEST(SurfaceForces, SpringsKeepTheirEnergyWhereTheAreaChanges)
{
  World w = block_on_plane(4e-5);
  w.let_overlap();
  w.friction = 10.0;
  w.set_velocity(1, Vec3(10.0, 0, 0));
  SurfaceResult r;
  for (int step = 0; step < 100; ++step) r = w.evaluate();
  const double stored = r.springs;
  EXPECT_NEAR(stored, 0.5 * k_area * block_area * 1e-5 * 1e-5, 1e-10 * stored);
  EXPECT_EQ(r.friction, 0.0);
  w.set_velocity(1, Vec3::Zero());
  double lost = 0.0, softest = 1.0;
  for (int step = 0; step < 70; ++step) {
    w.move(1, Vec3(1e-4, 0, 0));
    r = w.evaluate();
    lost += r.friction;
    EXPECT_NEAR((r.springs + lost) / stored, 1.0, 1e-12) << step;
    softest = std::min(softest, std::abs(w.force_on(1)[0]) / (k_area * block_area * 1e-5));
  }
  EXPECT_GT(lost, 0.2 * stored) << "none was let go";
  EXPECT_GT(r.springs, 0.2 * stored);
  EXPECT_LT(softest, 0.6);
}

TEST(SurfaceForces, SlidingBallRubs)
{
  const double R = 20e-3, depth = 1e-4, mu = 0.25, speed = 3.0;
  World w;
  w.dt = 1e-10;    // Coulomb's limit is below the viscous one
  w.add_surface(Vec3::Zero(), 9, spacing, true);
  const int ball = w.add_atom(Vec3(8.3e-3, 9.1e-3, R - depth), R);
  for (int k = 0; k < static_cast<int>(w.tables.facets.size()); ++k)
    w.tables.balls.push_back({ball, k});
  SurfaceResult r = w.evaluate();
  const double energy = pi * k_area * R * std::pow(depth, 3) / 3.0, push = 3.0 * energy / depth;
  EXPECT_NEAR(r.energy, energy, 0.03 * energy);
  EXPECT_NEAR(w.at(w.f, ball)[2], push, 0.03 * push);
  w.expect_balance();
  const double N = w.at(w.f, ball)[2], without = r.energy;

  w.friction = mu;
  w.v[3 * ball] = speed;
  r = w.evaluate();
  EXPECT_EQ(r.energy, without);
  // nothing is rubbed off by the part of the slip across the normals, which differ a little
  EXPECT_NEAR(w.at(w.f, ball)[0], -mu * N, 0.01 * mu * N);
  EXPECT_NEAR(r.friction, mu * N * speed * w.dt, 0.01 * mu * N * speed * w.dt);
  // it makes the ball roll: about +y, with the arm of its height
  EXPECT_NEAR(w.at(w.torque, ball)[1], mu * N * (R - depth), 0.01 * mu * N * R);
  w.expect_balance();

  // rolling: no slip at the height of the plane, and viscous friction for what is left across the normals
  w.dt = 1e-8;
  w.omega[3 * ball + 1] = speed / (R - depth);
  r = w.evaluate();
  EXPECT_LT(std::abs(w.at(w.f, ball)[0]), 0.05 * mu * N);
  EXPECT_LT(r.friction, 1e-3 * mu * N * speed * w.dt);
}

// Elements beside the rim of a floor convert while their neighbours press on it: what did not press takes nothing
// along, and the nodes that stay begin no new contact.
TEST(SurfaceForces, PatchesBesideTheRimMayGo)
{
  const double h = 2e-3, depth = 0.01 * depth_max;
  World w;
  w.add_surface(Vec3(-h, 0.0, 0.0), 2, h, true);
  w.add_surface(Vec3(0.0, 0.0, 0.0), 2, h, false);    // half of it over the floor
  w.add_points(1, 0);
  w.moving = true;
  w.set_velocity(1, Vec3(0.0, 0.0, -1.0));
  w.dt = 0.1 * depth;
  for (int step = 0; step < 10; ++step) {
    w.move(1, Vec3(0.0, 0.0, -0.1 * depth));
    (void) w.evaluate();
  }
  const double pressed = w.evaluate().energy;
  EXPECT_GT(pressed, 0.0);

  // the two facets beyond the floor go
  const auto beyond = [&](int facet) {
    double x = 0.0;
    for (int node : w.tables.facets[facet].node) x += 0.25 * w.x[3 * node];
    return facet >= w.surfaces[1].first_facet && x > h;
  };
  std::vector<ContactPatch> kept;
  for (auto &point : w.tables.points) {
    const int first = static_cast<int>(kept.size());
    for (int k = point.own; k < point.own + point.nown; ++k)
      if (!beyond(w.tables.patches[k].facet)) kept.push_back(w.tables.patches[k]);
    point.own = first;
    point.nown = static_cast<int>(kept.size()) - first;
  }
  ASSERT_EQ(kept.size(), 8u);
  w.tables.patches = kept;
  const SurfaceResult after = w.evaluate();
  EXPECT_EQ(after.offset_count, 0);
  EXPECT_NEAR(after.energy / pressed, 1.0, 1e-12);
}

// A block that passes the rim of a floor by a hundredth of its facet is deep below the floor's plane beside it: it is let
// through nowhere. One that goes through the floor is.
TEST(SurfaceForces, BesideARimNothingIsLetThrough)
{
  for (const double overlap : {0.01, 0.5}) {
    World w;
    w.add_surface(Vec3::Zero(), 1, spacing, true);
    w.add_surface(Vec3((1.0 - overlap) * spacing, 0.0, -0.999 * depth_max), 1, spacing, false);
    w.add_points(1, 0);
    w.let_overlap();
    w.set_velocity(1, Vec3(0.0, 0.0, -1.0));
    w.dt = 0.002 * depth_max;
    (void) w.evaluate();
    w.move(1, Vec3(0.0, 0.0, -0.002 * depth_max));
    const SurfaceResult r = w.evaluate();
    if (overlap < 0.1)
      EXPECT_TRUE(r.let_through.empty());
    else
      EXPECT_GT(r.let_through.size(), 0u);
  }
}

// A tilted block and a sphere come down beside and over rims, slide and are lifted again: what is left out of the pairs
// has no force, whatever moves in between, at any speed.
TEST(SurfaceForces, PairsThatAreNearHaveAllOfTheForce)
{
  for (const double speed : {0.1, 3.0, 100.0}) {
    std::mt19937 random(9);
    std::uniform_real_distribution<double> uniform(-1.0, 1.0);
    World w = block_on_plane(-2e-5);
    tilt(w, 1, Vec3(1.0, 0.4, 0.0), 0.01);
    const int ball = w.add_atom(Vec3(3.2 * spacing, 6.9 * spacing, 0.5 * spacing + 1e-5), 0.0);
    ContactPoint sphere{};
    sphere.atom = ball;
    sphere.part = 0;
    sphere.r = sphere.half = 0.5 * spacing;
    sphere.area = spacing * spacing;
    sphere.k_own = k_area;
    sphere.first = static_cast<int>(w.tables.candidates.size());
    sphere.count = w.surfaces[0].facets;
    for (int k = 0; k < sphere.count; ++k) w.tables.candidates.push_back(k);
    w.tables.points.push_back(sphere);
    w.friction = 0.2;
    w.dt = 2e-7;

    World all = w;
    NearSurface near;
    std::size_t left = 0, evaluations = 0, pressed = 0, of_sphere = 0;
    const int steps = static_cast<int>(std::min(4000.0, 4e-4 / (speed * w.dt)));
    for (int step = 0; step < steps; ++step) {
      const double down = step < steps / 2 ? -speed : speed;
      for (World *one : {&w, &all}) {
        one->set_velocity(1, Vec3(0.5 * speed, 0.2 * speed, down));
        for (int k = 0; k < 3; ++k) one->v[3 * ball + k] = speed * Vec3(0.1, 0.8, 0.3 * down)[k];
      }
      for (std::size_t c = 0; c < w.x.size(); ++c) {
        w.v[c] += 0.1 * speed * uniform(random);
        all.v[c] = w.v[c];
        w.x[c] += w.dt * w.v[c];
        all.x[c] = w.x[c];
      }
      const SurfaceResult a = all.evaluate();
      w.update_planes();
      w.f.assign(w.x.size(), 0.0);
      w.torque.assign(w.x.size(), 0.0);
      const ContactPairs &pairs = near.find(w.tables, w.x.data(), w.memory, 4e-4);
      const SurfaceResult b = surface_forces(w.tables, w.arrays(), w.memory, &pairs);
      ASSERT_EQ(w.f, all.f) << "speed " << speed << " step " << step;
      ASSERT_EQ(w.torque, all.torque);
      ASSERT_EQ(a.energy, b.energy);
      ASSERT_EQ(a.friction, b.friction);
      ASSERT_EQ(w.memory.all.size(), all.memory.all.size());
      left += pairs.candidates.size();
      ++evaluations;
      pressed += a.energy > 0.0;
      of_sphere += all.memory.all.count({ball, 0});
    }
    EXPECT_GT(pressed, evaluations / 4);
    EXPECT_GT(of_sphere, 0u);
    EXPECT_LT(left, evaluations * w.tables.candidates.size() / 2);
  }
}
