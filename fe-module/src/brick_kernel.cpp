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
// component, and K does not notice. So K falls apart into eight 3 x 3 blocks.
struct BrickKernel::Data {
  CorotationalShape shape;
  double block[8][3][3];
  ElementType type;

  Data(const HexCoords &X, const IsotropicElastic &material, ElementType type) :
      shape(X, box_frame(X)), type(type)
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

  DEFE_INLINE void apply(const Pack u[3][8], Pack p[3][8]) const
  {
    for (int b = 0; b < 8; ++b)
      for (int i = 0; i < 3; ++i) {
        const int mi = b ^ (1 << i);
        if (mi == 0) continue;    // no force on a translation, nor from one
        Pack sum = Pack{};
        for (int j = 0; j < 3; ++j) {
          const int mj = b ^ (1 << j);
          if (mj != 0) sum += block[b][i][j] * u[j][mj];
        }
        p[i][mi] = sum;
      }
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
