#ifndef DEFE_TEST_LAYERS_H
#define DEFE_TEST_LAYERS_H

// Bricks of bonded layers: parts that share nodes.

#include "mesh_file.h"

namespace defe::test {

struct Layer {
  std::string part;
  double thickness;
  int n;
};

/// Layers on top of each other along y, from y = 0; nodes of type 1. x and z: node lines.
inline MeshFile layered(const std::vector<Layer> &layers, const std::vector<double> &x,
                        const std::vector<double> &z, int types)
{
  MeshFile mesh;
  mesh.types = types;
  std::vector<double> y = {0.0};
  std::vector<std::string> part;
  for (const auto &layer : layers) {
    const double low = y.back();
    for (int k = 1; k <= layer.n; k++) {
      y.push_back(low + layer.thickness * k / layer.n);
      part.push_back(layer.part);
    }
  }
  const tagint nx = static_cast<tagint>(x.size()), ny = static_cast<tagint>(y.size());
  for (double c : z)
    for (double b : y)
      for (double a : x) {
        mesh.X.emplace_back(a, b, c);
        mesh.type.push_back(1);
      }
  for (size_t k = 0; k + 1 < z.size(); k++)
    for (size_t j = 0; j + 1 < y.size(); j++)
      for (size_t i = 0; i + 1 < x.size(); i++) {
        std::array<tagint, 8> nodes;
        for (int a = 0; a < 8; a++)
          nodes[a] = 1 + static_cast<tagint>(i) + (fe::hex_sign[a][0] + 1) / 2 +
              nx *
                  (static_cast<tagint>(j) + (fe::hex_sign[a][1] + 1) / 2 +
                   ny * (static_cast<tagint>(k) + (fe::hex_sign[a][2] + 1) / 2));
        mesh.hex.push_back(nodes);
        mesh.part.push_back(part[j]);
      }
  mesh.lo = Vec3(x.front() - 0.001, -0.001, z.front() - 0.001);
  mesh.hi = Vec3(x.back() + 0.001, y.back() + 0.001, z.back() + 0.001);
  return mesh;
}

/// n + 1 equidistant values.
inline std::vector<double> equidistant(double from, double to, int n)
{
  std::vector<double> values;
  for (int k = 0; k <= n; k++) values.push_back(from + (to - from) * k / n);
  return values;
}

}    // namespace defe::test

#endif
