#ifndef DEFE_TEST_SURFACE_WORLD_H
#define DEFE_TEST_SURFACE_WORLD_H

// Bodies of hexahedra, DEs and balls for the search for contacts, as a rank of a LAMMPS run would show
// them, and what the search finds in terms of IDs.

#include "defe/coupling/surface_search.h"
#include "defe/fe/hex8.h"
#include "defe/types.h"

#include <Eigen/Geometry>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <functional>
#include <map>
#include <random>
#include <set>
#include <tuple>
#include <vector>

namespace defe::test {

struct SurfaceWorld : SurfaceTies {
  struct Particle {
    Vec3 x, X;
    double radius = 0.0, distance = 0.0, length = 0.0;
    std::int64_t id;
    bool ghost = false;
    int part = -1;    // of a DE
    double area = 0.0;
  };
  struct Element {
    std::int64_t id;
    std::array<int, 8> node;
    int part;
    double volume;
    unsigned bare, free;
    int body;    // of one call of add_block()
  };
  std::vector<Particle> particles;
  std::vector<Element> elements;
  std::vector<SurfacePart> parts = std::vector<SurfacePart>(40, SurfacePart{false, 40e9});
  double skin = 0.1, factor = 0.2;
  std::set<std::tuple<int, int, std::int64_t>> lasting_ties;    // particle, part, element
  std::map<std::pair<int, int>, double> tied_faces;             // particle, part

  int add_particle(const Vec3 &X, double radius = 0.0)
  {
    Particle p;
    p.x = p.X = X;
    p.radius = radius;
    p.id = static_cast<std::int64_t>(particles.size()) + 1;
    particles.push_back(p);
    return static_cast<int>(particles.size()) - 1;
  }
  int add_de(const Vec3 &X, double radius, int part)
  {
    const int i = add_particle(X, radius);
    Particle &p = particles[i];
    p.distance = radius;
    p.part = part;
    p.area = 4.0 * radius * radius;
    p.length = radius;
    return i;
  }

  using Map = std::function<Vec3(const Vec3 &)>;
  /// n elements of edge h from 0 on, through `map`; index of the first one.
  int add_block(int part, const std::array<int, 3> &n, double h, const Map &map)
  {
    const int first_node = static_cast<int>(particles.size()),
              first = static_cast<int>(elements.size());
    for (int k = 0; k <= n[2]; ++k)
      for (int j = 0; j <= n[1]; ++j)
        for (int i = 0; i <= n[0]; ++i) add_particle(map(h * Vec3(i, j, k)));
    for (int k = 0; k < n[2]; ++k)
      for (int j = 0; j < n[1]; ++j)
        for (int i = 0; i < n[0]; ++i) {
          Element e;
          e.id = static_cast<std::int64_t>(elements.size()) + 1;
          e.part = part;
          e.body = bodies;
          fe::HexCoords X;
          for (int a = 0; a < 8; ++a) {
            const auto &sign = fe::hex_sign[a];
            e.node[a] = first_node + i + (sign[0] > 0) +
                (n[0] + 1) * (j + (sign[1] > 0) + (n[1] + 1) * (k + (sign[2] > 0)));
            X.col(a) = particles[e.node[a]].X;
          }
          e.volume = fe::volume(X);
          const int at[3] = {i, j, k};
          e.bare = 0;
          for (int f = 0; f < 6; ++f)
            if (at[f / 2] == (f % 2 ? n[f / 2] - 1 : 0)) e.bare |= 1u << f;
          e.free = e.bare;
          elements.push_back(e);
        }
    ++bodies;
    return first;
  }

  /// Particles and elements in another order, ghosts last. IDs stay.
  void renumber(unsigned seed)
  {
    std::mt19937 random(seed);
    std::vector<int> order(particles.size());
    for (size_t i = 0; i < order.size(); ++i) order[i] = static_cast<int>(i);
    std::shuffle(order.begin(), order.end(), random);
    apply(order);
    std::shuffle(elements.begin(), elements.end(), random);
  }
  void apply(std::vector<int> order)
  {
    std::stable_partition(order.begin(), order.end(), [this](int i) {
      return !particles[i].ghost;
    });
    std::vector<int> now(order.size());
    std::vector<Particle> moved;
    for (size_t k = 0; k < order.size(); ++k) {
      now[order[k]] = static_cast<int>(k);
      moved.push_back(particles[order[k]]);
    }
    particles = moved;
    for (auto &e : elements)
      for (int &i : e.node) i = now[i];
  }
  void ghosts_last()
  {
    std::vector<int> order(particles.size());
    for (size_t i = 0; i < order.size(); ++i) order[i] = static_cast<int>(i);
    apply(order);
  }

  /// The last particle takes the place of one that no element has.
  void drop_particle(int i)
  {
    const int last = static_cast<int>(particles.size()) - 1;
    std::set<std::tuple<int, int, std::int64_t>> ties;
    for (auto [particle, part, element] : lasting_ties)
      if (particle != i) ties.insert({particle == last ? i : particle, part, element});
    lasting_ties = ties;
    for (auto &e : elements)
      for (int &node : e.node)
        if (node == last) node = i;
    particles[i] = particles[last];
    particles.pop_back();
  }
  /// An element becomes eight DEs, tied to those beside it, whose faces are bared; nodes that no element has go. The last
  /// element takes its place.
  void convert(int e)
  {
    const Element gone = elements[e];
    elements[e] = elements.back();
    elements.pop_back();
    std::vector<std::int64_t> beside;
    for (auto &other : elements)
      for (int f = 0; f < 6; ++f) {
        const auto has = [&](int a) {
          return std::count(gone.node.begin(), gone.node.end(), other.node[fe::hex_face[f][a]]) > 0;
        };
        if (!has(0) || !has(1) || !has(2) || !has(3)) continue;
        other.bare |= 1u << f;
        beside.push_back(other.id);
      }
    Vec3 middle = Vec3::Zero();
    for (int i : gone.node) middle += 0.125 * particles[i].x;
    for (int i : gone.node) {
      const Vec3 at = 0.5 * (particles[i].x + middle);
      const int de = add_de(at, 0.25 * std::cbrt(gone.volume), gone.part);
      particles[de].id = ++newest;
      for (std::int64_t element : beside) lasting_ties.insert({de, gone.part, element});
    }
    std::set<int, std::greater<int>> unused(gone.node.begin(), gone.node.end());
    for (const auto &other : elements)
      for (int i : other.node) unused.erase(i);
    for (int i : unused) drop_particle(i);
  }

  bool lasting(int de, int part, std::int64_t element) const override
  {
    return lasting_ties.count({des[de], part, element}) > 0;
  }
  double tied_face(int de, int part) const override
  {
    const auto it = tied_faces.find({des[de], part});
    return it == tied_faces.end() ? HUGE_VAL : it->second;
  }

  const SurfaceTables &search()
  {
    x.clear();
    X.clear();
    radius.clear();
    distance.clear();
    length.clear();
    id.clear();
    des.clear();
    scene = SurfaceScene();
    for (size_t i = 0; i < particles.size(); ++i) {
      const Particle &p = particles[i];
      x.insert(x.end(), p.x.data(), p.x.data() + 3);
      X.insert(X.end(), p.X.data(), p.X.data() + 3);
      radius.push_back(p.radius);
      distance.push_back(p.distance);
      length.push_back(p.length);
      id.push_back(p.id);
      if (!p.ghost) scene.particles.nlocal++;
      if (p.part < 0 || p.ghost) continue;
      des.push_back(static_cast<int>(i));
      scene.des.part.push_back(p.part);
      scene.des.area.push_back(p.area);
    }
    scene.particles.nall = static_cast<int>(particles.size());
    scene.particles.x = x.data();
    scene.particles.X = X.data();
    scene.particles.radius = radius.data();
    scene.particles.id = id.data();
    scene.des.count = static_cast<int>(des.size());
    scene.des.particle = des.data();
    scene.des.distance = distance.data();
    scene.des.length = length.data();
    for (const auto &e : elements) {
      scene.elements.push_back({e.id, e.node.data(), e.volume, e.part,
                                static_cast<unsigned char>(e.bare),
                                static_cast<unsigned char>(e.free)});
      fe::HexCoords at;
      for (int a = 0; a < 8; ++a) at.col(a) = particles[e.node[a]].X;
      scene.element_size = std::max(scene.element_size, fe::max_diagonal(at));
    }
    scene.parts = parts;
    scene.ties = this;
    scene.factor = factor;
    scene.skin = skin;
    finder.run(scene, tables);
    return tables;
  }
  bool agrees() const { return search_agrees(scene, tables); }
  const SurfaceScene &seen() const { return scene; }
  /// Of the same scene, by one that knows nothing of the last search.
  SurfaceTables search_whole() const
  {
    SurfaceTables whole;
    SurfaceSearch one;
    one.run(scene, whole);
    points_of_whole = one.searched_for();
    return whole;
  }

  /// A facet by its element and its lowest node IDs: the same in any numbering.
  using Name = std::pair<std::int64_t, std::array<std::int64_t, 4>>;
  Name name(const int (&node)[4], std::int64_t element) const
  {
    Name n;
    n.first = element;
    for (int k = 0; k < 4; ++k) n.second[k] = particles[node[k]].id;
    return n;
  }
  Name name(const SurfaceTables &t, int facet) const
  {
    return name(t.facets[facet].node, t.facets[facet].element);
  }

  struct Found {
    std::vector<Name> candidates, patches;
    bool sharp;
    double r, half, area, k_own;
    bool operator==(const Found &o) const
    {
      return std::tie(candidates, patches, sharp, r, half, area, k_own) ==
          std::tie(o.candidates, o.patches, o.sharp, o.r, o.half, o.area, o.k_own);
    }
  };
  /// Of each point (ID) and part, in the order of the tables.
  std::map<std::pair<std::int64_t, int>, Found> found() const { return found(tables); }
  std::map<std::pair<std::int64_t, int>, Found> found(const SurfaceTables &t) const
  {
    std::map<std::pair<std::int64_t, int>, Found> all;
    for (const auto &p : t.points) {
      Found f{{}, {}, p.sharp, p.r, p.half, p.area, p.k_own};
      for (int c = p.first; c < p.first + p.count; ++c)
        f.candidates.push_back(name(t, t.candidates[c]));
      for (int c = p.own; c < p.own + p.nown; ++c) f.patches.push_back(name(t, t.patches[c].facet));
      all[{particles[p.atom].id, p.part}] = f;
    }
    return all;
  }
  std::vector<std::pair<std::int64_t, Name>> found_balls() const
  {
    std::vector<std::pair<std::int64_t, Name>> all;
    for (const auto &b : tables.balls)
      all.emplace_back(particles[b.atom].id, name(tables, b.facet));
    return all;
  }

  SurfaceTables tables;
  SurfaceSearch finder;
  mutable int points_of_whole = 0;    // that the last search_whole() searched for

 private:
  int bodies = 0;
  std::int64_t newest = 1000000;    // ID of a DE that was born
  SurfaceScene scene;
  std::vector<double> x, X, radius, distance, length;
  std::vector<std::int64_t> id;
  std::vector<int> des;    // particles
};

inline SurfaceWorld::Map shift(const Vec3 &by)
{
  return [by](const Vec3 &x) {
    return Vec3(x + by);
  };
}

}    // namespace defe::test

#endif
