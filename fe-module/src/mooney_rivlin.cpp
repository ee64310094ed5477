#include "defe/fe/mooney_rivlin.h"

#include "fbar.h"

#include <cmath>
#include <sstream>

namespace defe::fe {

namespace {

  struct MooneyRivlinLanes {
    double bulk, C10, C01;
    static constexpr int centre_size = 0;

    // Q = 2 C10 J^(-2/3) F + 2 C01 J^(-4/3) (I1 F - F C)
    template <bool with_energy>
    DEFE_INLINE void respond(const Deformation &d, Pack Q[3][3], Pack &energy) const
    {
      Pack C[3][3];
      for (int i = 0; i < 3; ++i)
        for (int j = i; j < 3; ++j)
          C[i][j] = C[j][i] = d.F[0][i] * d.F[0][j] + d.F[1][i] * d.F[1][j] + d.F[2][i] * d.F[2][j];
      const Pack I1 = C[0][0] + C[1][1] + C[2][2];
      const Pack j2 = d.j * d.j, c = (2.0 * C01) * j2 * j2, b = (2.0 * C10) * j2 + c * I1;
      for (int i = 0; i < 3; ++i)
        for (int j = 0; j < 3; ++j)
          Q[i][j] =
              b * d.F[i][j] - c * (d.F[i][0] * C[0][j] + d.F[i][1] * C[1][j] + d.F[i][2] * C[2][j]);
      if constexpr (with_energy) {
        const Pack I2 = C[0][0] * C[1][1] - C[0][1] * C[0][1] + C[1][1] * C[2][2] -
            C[1][2] * C[1][2] + C[0][0] * C[2][2] - C[0][2] * C[0][2];
        energy = C10 * (j2 * I1 - 3.0) + C01 * (j2 * j2 * I2 - 3.0);
      }
    }

    template <bool with_energy>
    DEFE_INLINE void at_gauss_point(const Deformation &d, const LaneHistory &, Pack *, Pack Q[3][3],
                                    Pack &energy, Pack &) const
    {
      respond<with_energy>(d, Q, energy);
    }

    DEFE_INLINE void at_centre(const Deformation &d, const Pack *, Pack Q[3][3]) const
    {
      Pack unused;
      respond<false>(d, Q, unused);
    }
  };

}    // namespace

std::string MooneyRivlin::validate() const
{
  // written so that NaN fails as well
  std::ostringstream complaint;
  if (!(C10 >= 0.0 && std::isfinite(C10)))
    complaint << "Mooney-Rivlin constant C10 must not be negative, not " << C10;
  else if (!(C01 >= 0.0 && std::isfinite(C01)))
    complaint << "Mooney-Rivlin constant C01 must not be negative, not " << C01;
  else if (!(C10 + C01 > 0.0))
    complaint << "one of the Mooney-Rivlin constants C10 and C01 must be positive";
  else if (!(K >= 2.0 / 3.0 * mu() && std::isfinite(K)))
    complaint << "bulk modulus must be at least 4/3 (C10 + C01) = " << 2.0 / 3.0 * mu() << ", not "
              << K << " (from Poisson's ratio: K = 4/3 (C10 + C01) (1 + nu)/(1 - 2 nu))";
  else if (!(elastic_from_bulk_shear(K, mu(), 1.0).nu < 0.5))
    complaint << "bulk modulus " << K << " is too large beside the shear modulus " << mu();
  else if (!(rho > 0.0 && std::isfinite(rho)))
    complaint << "density must be positive, not " << rho;
  return complaint.str();
}

MooneyRivlinKernel::MooneyRivlinKernel(const MooneyRivlin &m) :
    FBarKernel(m.validate(), m.K, elastic_from_bulk_shear(m.K, m.mu(), m.rho)), law(m)
{
}

void MooneyRivlinKernel::add_forces(int n, const int (*nodes)[8], const double *x, const double *X,
                                    double *f, const Output &out) const
{
  add_fbar_forces(MooneyRivlinLanes{law.K, law.C10, law.C01}, 0, n, nodes, x, X, f, out);
}

double MooneyRivlinKernel::shear_energy(const Mat3 &F, const double *) const
{
  const Mat3 C = std::pow(F.determinant(), -2.0 / 3.0) * F.transpose() * F;
  const double I1 = C.trace(), I2 = 0.5 * (I1 * I1 - C.squaredNorm());
  return law.C10 * (I1 - 3.0) + law.C01 * (I2 - 3.0);
}

Mat3 MooneyRivlinKernel::shear_stress(const Mat3 &F, const double *) const
{
  const Mat3 b = std::pow(F.determinant(), -2.0 / 3.0) * F * F.transpose();
  Mat3 s = 2.0 * law.C10 * b + 2.0 * law.C01 * (b.trace() * b - b * b);
  s.diagonal().array() -= s.trace() / 3.0;
  return s;
}

}    // namespace defe::fe
