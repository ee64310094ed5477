#include "corotational.h"
#include "defe/fe/hex8.h"

namespace defe::fe {

struct CongruentKernel::Data {
  static constexpr bool rectangular = false;
  static constexpr int size = 21;    // all modes but the translations
  CorotationalShape shape;
  double K[size][size];    // row or column 7 i + m - 1: component i of mode m

  Data(const HexCoords &X, const Eigen::Matrix<double, 24, 24> &nodal) : shape(X, Mat3::Identity())
  {
    Eigen::Matrix<double, 24, size> T;
    T.setZero();
    for (int a = 0; a < 8; ++a)
      for (int i = 0; i < 3; ++i)
        for (int m = 1; m < 8; ++m) T(3 * a + i, 7 * i + m - 1) = hex_mode(m, a);
    // 8 from the displacements' modes, 8 from the forces'
    const Eigen::Matrix<double, size, size> modal = T.transpose() * nodal * T / 64.0;
    for (int r = 0; r < size; ++r)
      for (int c = 0; c < size; ++c) K[r][c] = 0.5 * (modal(r, c) + modal(c, r));
  }

  DEFE_INLINE void apply(const Pack u[3][8], Pack p[3][8]) const
  {
    for (int i = 0; i < 3; ++i) {
      Pack sum[7] = {};    // seven rows at a time stay in registers
      for (int j = 0; j < 3; ++j)
        for (int m = 0; m < 7; ++m) {
          const Pack v = u[j][m + 1];
          const double *row = &K[7 * j + m][7 * i];    // K is symmetric: a column
          for (int r = 0; r < 7; ++r) sum[r] += row[r] * v;
        }
      for (int r = 0; r < 7; ++r) p[i][r + 1] = sum[r];
    }
  }
};

CongruentKernel::CongruentKernel(const HexCoords &X, const IsotropicElastic &material) :
    CorotationalKernel(X, material), data(std::make_unique<const Data>(reference(), K))
{
}

CongruentKernel::~CongruentKernel() = default;

void CongruentKernel::add_forces(int n, const int (*nodes)[8], const double *x, const double *,
                                 double *f, const Output &out) const
{
  add_corotational_forces(*data, elastic, n, nodes, x, f, out);
}

}    // namespace defe::fe
