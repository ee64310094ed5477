#ifndef DEFE_TEST_FE_COMMON_H
#define DEFE_TEST_FE_COMMON_H

#include "defe/fe/hex8.h"
#include "defe/fe/kernel.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <random>
#include <vector>

namespace defe::fe::test {

inline const IsotropicElastic glass{74.09e9, 0.2, 2500.0};
inline const IsotropicElastic unit{1.0, 0.3, 1.0};    // E = 1: forces and energies of order 1

class Random {
 public:
  explicit Random(unsigned seed) : engine(seed) {}

  double uniform(double lo, double hi)
  {
    return std::uniform_real_distribution<double>(lo, hi)(engine);
  }

  template <class Matrix> Matrix matrix(double size)
  {
    Matrix m;
    for (int i = 0; i < m.size(); ++i) m.data()[i] = uniform(-size, size);
    return m;
  }

  Mat3 rotation()
  {
    std::normal_distribution<double> normal;
    const double w = normal(engine), x = normal(engine), y = normal(engine), z = normal(engine);
    return Eigen::Quaterniond(w, x, y, z).normalized().toRotationMatrix();
  }

 private:
  std::mt19937 engine;
};

inline HexCoords box(double a, double b, double c)
{
  HexCoords X;
  for (int n = 0; n < 8; ++n)
    X.col(n) << (hex_sign[n][0] + 1) / 2 * a, (hex_sign[n][1] + 1) / 2 * b,
        (hex_sign[n][2] + 1) / 2 * c;
  return X;
}

/// Unit cube, every node moved, turned and stretched: no two edges or angles alike.
inline HexCoords random_hex(Random &random)
{
  HexCoords X;
  do {
    X = box(1.0, 1.0, 1.0) + random.matrix<HexCoords>(0.2);
    X = random.rotation() * (Mat3::Identity() + random.matrix<Mat3>(0.2)) * X;
  } while (check_hex(X).verdict != HexCheck::good);
  return X;
}

inline constexpr int first_hex[1][8] = {{0, 1, 2, 3, 4, 5, 6, 7}};

/// Histories of n elements, all zero or all equal to the given one.
struct Histories {
  std::vector<double> values;
  std::vector<double *> of_element;

  Histories(const HexKernel &kernel, int n, const double *same = nullptr) :
      values(std::size_t(n) * kernel.history_size())
  {
    const int size = kernel.history_size();
    for (int e = 0; e < n; ++e) {
      of_element.push_back(values.data() + std::size_t(e) * size);
      if (same && size) std::copy(same, same + size, of_element.back());
    }
  }
  Histories(const Histories &) = delete;

  HexKernel::Output output(double dt = 0.0) const
  {
    HexKernel::Output out;
    out.history = of_element.data();
    out.dt = dt;
    return out;
  }
};

/// Forces of one element, all outputs off; history null: never strained.
inline HexCoords forces(const HexKernel &kernel, const HexCoords &x, const HexCoords &X,
                        const double *history = nullptr)
{
  HexCoords f = HexCoords::Zero();
  kernel.add_forces(1, first_hex, x.data(), X.data(), f.data(),
                    Histories(kernel, 1, history).output());
  return f;
}

/// sum_a x_a x f_a about node 0
inline Vec3 moment(const HexCoords &x, const HexCoords &f)
{
  Vec3 sum = Vec3::Zero();
  for (int a = 0; a < 8; ++a) sum += (x.col(a) - x.col(0)).cross(f.col(a));
  return sum;
}

/// A hex mesh for assembling.
struct Mesh {
  std::vector<std::array<int, 8>> hexes;
  std::vector<Vec3> X;

  const int (*nodes() const)[8] { return reinterpret_cast<const int(*)[8]>(hexes.data()); }
  const double *coordinates() const { return X[0].data(); }

  HexCoords shape(int e) const
  {
    HexCoords c;
    for (int a = 0; a < 8; ++a) c.col(a) = X[hexes[e][a]];
    return c;
  }
};

}    // namespace defe::fe::test

#endif
