#include "surface_faces.h"

#include "defe/fe/topology.h"

#include <Eigen/Geometry>

#include <algorithm>
#include <cmath>

namespace defe::search {

// faces at an edge that form an angle of more than 30 degrees: a rim
static constexpr double rim_cosine = 0.866;

void SurfaceFaces::build(const SurfaceScene &s)
{
  scene = &s;
  all.clear();
  extent_max = 0.0;
  all.reserve(2 * s.elements.size());
  const double *coords = s.particles.x;
  for (std::size_t e = 0; e < s.elements.size(); e++) {
    const SurfaceElement &element = s.elements[e];
    for (int f = 0; f < 6; f++) {
      if (!(element.bare >> f & 1)) continue;
      all.emplace_back();
      Face &face = all.back();
      const double *p[4];
      for (int a = 0; a < 4; a++) {
        face.node[a] = element.node[fe::hex_face[f][a]];
        p[a] = coords + 3 * static_cast<std::ptrdiff_t>(face.node[a]);
      }
      face.id = element.id;
      face.element = static_cast<int>(e);
      face.face = f;
      face.free = element.free >> f & 1;
      face.extent = 0.0;
      double d1[3], d2[3];
      for (int d = 0; d < 3; d++) {
        face.centre[d] = 0.25 * (p[0][d] + p[1][d] + p[2][d] + p[3][d]);
        d1[d] = p[2][d] - p[0][d];
        d2[d] = p[3][d] - p[1][d];
      }
      double length = 0.0;
      for (int d = 0; d < 3; d++) {
        face.normal[d] = d1[(d + 1) % 3] * d2[(d + 2) % 3] - d1[(d + 2) % 3] * d2[(d + 1) % 3];
        length += face.normal[d] * face.normal[d];
      }
      length = std::sqrt(length);
      for (double &n : face.normal) n /= length;
      for (const double *q : p) face.extent = std::max(face.extent, dist_sq(q, face.centre));
      extent_max = std::max(extent_max, face.extent);
    }
  }
  extent_max = std::sqrt(extent_max);
  list_by_node();
}

void SurfaceFaces::list_by_node()
{
  for (int i : nodes) number[i] = -1;
  nodes.clear();
  if (static_cast<int>(number.size()) < scene->particles.nall)
    number.resize(scene->particles.nall, -1);
  first_at.assign(1, 0);
  for (const auto &face : all)
    for (int node : face.node) {
      if (number[node] < 0) {
        number[node] = static_cast<int>(nodes.size());
        nodes.push_back(node);
        first_at.push_back(0);
      }
      first_at[number[node] + 1]++;
    }
  for (std::size_t n = 0; n < nodes.size(); n++) first_at[n + 1] += first_at[n];
  faces_at.resize(first_at.back());
  std::vector<int> next(first_at.begin(), first_at.end() - 1);
  for (std::size_t f = 0; f < all.size(); f++)
    for (int node : all[f].node) faces_at[next[number[node]]++] = static_cast<int>(f);
  sharp_node.assign(nodes.size(), 2);
  normals.resize(all.size());
  normal_known.assign(all.size(), 0);
}

const Vec3 &SurfaceFaces::reference_normal(int face)
{
  Vec3 &n = normals[face];
  if (normal_known[face]) return n;
  normal_known[face] = 1;
  const int *node = all[face].node;
  const auto X = [this, node](int k) {
    return Vec3(scene->particles.reference(node[k]));
  };
  n = (X(2) - X(0)).cross(X(3) - X(1)).normalized();
  return n;
}

void SurfaceFaces::find_rims(int face, bool rim[4])
{
  const Vec3 &n = reference_normal(face);
  static constexpr int edge_at[4] = {1, 3, 2, 0};    // xi = 1: nodes 1 and 2, ...
  for (int e = 0; e < 4; e++) {
    const int a = all[face].node[edge_at[e]], b = all[face].node[(edge_at[e] + 1) % 4];
    rim[e] = true;
    for (int c = first_of(a); c < end_of(a) && rim[e]; c++) {
      const int other = faces_at[c];
      if (other == face) continue;
      const int *node = all[other].node;
      if (node[0] != b && node[1] != b && node[2] != b && node[3] != b) continue;
      if (reference_normal(other).dot(n) > rim_cosine) rim[e] = false;
    }
  }
}

bool SurfaceFaces::sharp(int i)
{
  char &known = sharp_node[number[i]];
  if (known != 2) return known == 1;
  known = 0;
  const int first = first_of(i), end = end_of(i);
  for (int c = first; c < end && !known; c++)
    for (int d = first; d < c && !known; d++)
      if (reference_normal(faces_at[c]).dot(reference_normal(faces_at[d])) <= rim_cosine) known = 1;
  return known == 1;
}

}    // namespace defe::search
