// The material law of the page lammps-package/doc/Developer_defe.rst, as a file of fe-module/src would
// have it: test_fe_new_law.cpp shows that it works, tests/tools/test_howto.py that the page has it.

#include "fbar.h"
#include "fbar_law.h"

#include <cmath>
#include <string>

namespace defe::fe {

namespace {

  /// Yeoh (1990): W = C1 (I1bar - 3) + C2 (I1bar - 3)^2 + K/2 (J - 1)^2.
  struct Yeoh {
    double C1, C2, K, rho;

    double mu() const { return 2.0 * C1; }    // shear modulus at small strain

    std::string validate() const
    {
      if (!(C1 > 0.0)) return "Yeoh constant C1 must be positive, not " + std::to_string(C1);
      if (!(C2 >= 0.0)) return "Yeoh constant C2 must not be negative, not " + std::to_string(C2);
      if (!(K >= 2.0 / 3.0 * mu()))
        return "bulk modulus must be at least 4/3 C1, not " + std::to_string(K);
      if (!(rho > 0.0)) return "density must be positive, not " + std::to_string(rho);
      return "";
    }
  };

  /// The response of several elements at once: what fbar.h asks of a law.
  struct YeohLanes {
    double bulk, C1, C2;
    static constexpr int centre_size = 0;

    // dw/dF is the isochoric part of Q = 2 (C1 + 2 C2 (I1bar - 3)) J^(-2/3) F
    template <bool with_energy>
    DEFE_INLINE void respond(const Deformation &d, Pack Q[3][3], Pack &energy) const
    {
      Pack I = Pack{};
      for (int i = 0; i < 3; ++i)
        for (int j = 0; j < 3; ++j) I += d.F[i][j] * d.F[i][j];
      const Pack e = d.j * d.j * I - 3.0, q = (2.0 * C1 + 4.0 * C2 * e) * d.j * d.j;
      for (int i = 0; i < 3; ++i)
        for (int j = 0; j < 3; ++j) Q[i][j] = q * d.F[i][j];
      if constexpr (with_energy) energy = C1 * e + C2 * e * e;
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

  class YeohKernel : public FBarKernel {
   public:
    explicit YeohKernel(const Yeoh &m) :
        FBarKernel(m.validate(), m.K, elastic_from_bulk_shear(m.K, m.mu(), m.rho)), law(m)
    {
    }
    void add_forces(int n, const int (*nodes)[8], const double *x, const double *X, double *f,
                    const Output &out) const override
    {
      add_fbar_forces(YeohLanes{law.K, law.C1, law.C2}, 0, n, nodes, x, X, f, out);
    }

   protected:
    double shear_energy(const Mat3 &F, const double *) const override
    {
      const double e = excess(F);
      return law.C1 * e + law.C2 * e * e;
    }
    Mat3 shear_stress(const Mat3 &F, const double *) const override
    {
      Mat3 s = 2.0 * (law.C1 + 2.0 * law.C2 * excess(F)) * std::pow(F.determinant(), -2.0 / 3.0) *
          F * F.transpose();
      s.diagonal().array() -= s.trace() / 3.0;
      return s;
    }

   private:
    static double excess(const Mat3 &F)
    {
      return std::pow(F.determinant(), -2.0 / 3.0) * F.squaredNorm() - 3.0;
    }
    Yeoh law;
  };

  std::unique_ptr<MaterialLaw> make(LawWords &words, std::string &complaint)
  {
    Yeoh m;
    m.C1 = words.number("Yeoh constant C1");
    m.C2 = words.number("Yeoh constant C2");
    m.K = words.number("bulk modulus K");
    m.rho = words.number("density rho");
    return FBarLaw<Yeoh, YeohKernel>::make(m, m.mu(), complaint);
  }

}    // namespace

extern const MaterialLawEntry yeoh_law;
const MaterialLawEntry yeoh_law = {"yeoh", "yeoh C1 C2 K rho", make};

}    // namespace defe::fe
