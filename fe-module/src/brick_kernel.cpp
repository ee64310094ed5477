#include "corotational.h"
#include "defe/fe/hex8.h"

#include <algorithm>
#include <stdexcept>

namespace defe::fe {

namespace {

  // Mean edge vectors: for a box all four along an axis are equal, to rounding.
  Mat3 mean_edges(const HexCoords &X)
  {
    Mat3 edges = Mat3::Zero();
    for (int a = 0; a < 8; ++a)
      for (int k = 0; k < 3; ++k) edges.col(k) += 0.25 * hex_sign[a][k] * (X.col(a) - X.col(0));
    return edges;
  }

  // Axes of a box.
  Mat3 box_frame(const HexCoords &X)
  {
    return polar_rotation(mean_edges(X).colwise().normalized());
  }

  // The exact box nearest to X, in frame Q, node 0 at the origin.
  HexCoords exact_box(const HexCoords &X, const Mat3 &Q)
  {
    const Vec3 length = mean_edges(X).colwise().norm().transpose();
    HexCoords box;
    for (int a = 0; a < 8; ++a)
      for (int k = 0; k < 3; ++k) box(k, a) = hex_sign[a][k] > 0 ? length[k] : 0.0;
    return Q * box;
  }

  const HexCoords &require_box(const HexCoords &X)
  {
    if (!is_box(X)) throw std::invalid_argument("BrickKernel: the hexahedron is not a box");
    return X;
  }

}    // namespace

// On modes, component c of mode m of a box couples only with others of the same block m xor 2^c:
// reflecting the box in a plane through its centre changes the sign of some modes and of one
// component, and K does not notice. So K falls apart into eight 3 x 3 blocks. Linear modes have uniform strain, whose stress does no
// work on the others: for them it is the law of the material.
struct BrickKernel::Data {
  CorotationalShape shape;
  double block[8][3][3];
  ElementType type;
  double lambda_V, mu2_V;    // lambda and 2 mu times the volume

  Data(const HexCoords &X, const IsotropicElastic &material, ElementType type) :
      shape(X, box_frame(X)), type(type), lambda_V(material.lambda() * volume(X)),
      mu2_V(2.0 * material.mu() * volume(X))
  {
    const HexCoords local = box_frame(X).transpose() * X;
    const Eigen::Matrix<double, 24, 24> K = type == ElementType::enhanced
        ? stiffness_enhanced(local, material)
        : stiffness(local, material);
    for (int b = 0; b < 8; ++b)
      for (int i = 0; i < 3; ++i)
        for (int j = 0; j < 3; ++j) {
          const int mi = b ^ (1 << i), mj = b ^ (1 << j);
          double sum = 0.0;
          for (int a = 0; a < 8; ++a)
            for (int c = 0; c < 8; ++c)
              sum += hex_mode(mi, a) * hex_mode(mj, c) * K(3 * a + i, 3 * c + j);
          block[b][i][j] = sum / 64.0;    // 8 from the displacements' modes, 8 from the forces'
        }
  }

  DEFE_INLINE void set_stress(const Pack E[6], Pack VS[6]) const
  {
    const Pack mean = lambda_V * (E[0] + E[1] + E[2]);
    for (int k = 0; k < 6; ++k) VS[k] = k < 3 ? mean + mu2_V * E[k] : mu2_V * E[k];
  }

  // The higher modes' part of the blocks, one by one: as loops over all of them compilers leave them rolled up, and modes in memory.
  DEFE_INLINE void apply(const Pack u[3][8], Pack p[3][8]) const
  {
    for (int c = 0; c < 3; ++c) {
      const int i = (c + 1) % 3, j = (c + 2) % 3;
      const auto &K = block[1 << c];    // modes c i and c j
      const Pack ui = u[i][1 << c | 1 << i], uj = u[j][1 << c | 1 << j];
      p[i][1 << c | 1 << i] = K[i][i] * ui + K[i][j] * uj;
      p[j][1 << c | 1 << j] = K[j][i] * ui + K[j][j] * uj;
      p[c][7] = block[7 ^ 1 << c][c][c] * u[c][7];
    }
    for (int i = 0; i < 3; ++i)
      p[i][7 ^ 1 << i] =
          block[7][i][0] * u[0][6] + block[7][i][1] * u[1][5] + block[7][i][2] * u[2][3];
  }
};

BrickKernel::BrickKernel(const HexCoords &X, const IsotropicElastic &material, ElementType type) :
    CorotationalKernel(exact_box(require_box(X), box_frame(X)), material, type),
    data(std::make_unique<const Data>(reference(), material, type))
{
}

BrickKernel::~BrickKernel() = default;

void BrickKernel::add_forces(int n, const int (*nodes)[8], const double *x, const double *,
                             double *f, const Output &out) const
{
  add_corotational_forces(*data, elastic, n, nodes, x, f, out);
}

}    // namespace defe::fe
