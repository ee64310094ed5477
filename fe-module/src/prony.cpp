#include "defe/fe/prony.h"

#include "fbar.h"

#include <cmath>
#include <sstream>

namespace defe::fe {

namespace {

  // Symmetric tensors are xx yy zz xy xz yz throughout.
  constexpr int index[3][3] = {{0, 3, 4}, {3, 1, 5}, {4, 5, 2}};

  DEFE_INLINE Pack determinant(const Pack A[6])
  {
    return A[0] * (A[1] * A[2] - A[5] * A[5]) - A[3] * (A[3] * A[2] - A[5] * A[4]) +
        A[4] * (A[3] * A[5] - A[1] * A[4]);
  }

  DEFE_INLINE Pack second_invariant(const Pack A[6])
  {
    return A[0] * A[1] - A[3] * A[3] + A[1] * A[2] - A[5] * A[5] + A[0] * A[2] - A[4] * A[4];
  }

  // det(I + A) - 1
  DEFE_INLINE Pack volume_strain(const Pack A[6])
  {
    return (A[0] + A[1] + A[2]) + second_invariant(A) + determinant(A);
  }

  // (I + A)^-1
  DEFE_INLINE void inverse_of_one_plus(const Pack A[6], Pack inverse[6])
  {
    const Pack x = 1.0 + A[0], y = 1.0 + A[1], z = 1.0 + A[2];
    const Pack factor = 1.0 / (1.0 + volume_strain(A));
    inverse[0] = (y * z - A[5] * A[5]) * factor;
    inverse[1] = (x * z - A[4] * A[4]) * factor;
    inverse[2] = (x * y - A[3] * A[3]) * factor;
    inverse[3] = (A[4] * A[5] - A[3] * z) * factor;
    inverse[4] = (A[3] * A[5] - A[4] * y) * factor;
    inverse[5] = (A[3] * A[4] - A[5] * x) * factor;
  }

  // P = A B
  DEFE_INLINE void multiply(const Pack A[6], const Pack B[6], Pack P[3][3])
  {
    for (int i = 0; i < 3; ++i)
      for (int j = 0; j < 3; ++j)
        P[i][j] = A[index[i][0]] * B[index[0][j]] + A[index[i][1]] * B[index[1][j]] +
            A[index[i][2]] * B[index[2][j]];
  }

  // tr(P R)
  DEFE_INLINE Pack trace_of_product(const Pack P[3][3], const Pack R[3][3])
  {
    Pack sum = Pack{};
    for (int i = 0; i < 3; ++i)
      for (int j = 0; j < 3; ++j) sum += P[i][j] * R[j][i];
    return sum;
  }

  DEFE_INLINE Pack log1p(const Pack &m)
  {
    return simd::generate([&m](int l) {
      return std::log1p(m[l]);
    });
  }

  // log(1 + m) - m, without cancellation for small m
  DEFE_INLINE Pack log1p_rest(const Pack &m)
  {
    // log(1 + m) = 2 (s + s^3/3 + s^5/5 + ...) with s = m/(2 + m), and 2 s - m = -s m
    const Pack s = m / (2.0 + m), q = s * s;
    Pack rest = 2.0 * s * q *
            (1.0 / 3.0 + q * (1.0 / 5.0 + q * (1.0 / 7.0 + q * (1.0 / 9.0 + q * (1.0 / 11.0))))) -
        s * m;
    const simd::Mask large = simd::abs(m) > 0.05;
    if (__builtin_expect(simd::any(large), false)) rest = large ? log1p(m) - m : rest;
    return rest;
  }

  // 1 - (1 - exp(-h))/h, decay = 1 - exp(-h); by its series h/2! - h^2/3! + ... where it cancels
  double rise(double h, double decay)
  {
    if (h > 0.1) return 1.0 - decay / h;
    double sum = 0.0;
    for (int i = 10; i >= 2; --i) sum = (1.0 - h * sum) / i;
    return h * sum;
  }

  struct PronyLanes {
    double bulk, G_inf, G_0;
    int terms;
    const Prony::Term *term;
    double a[Prony::max_terms], b[Prony::max_terms];    // weights of D' - B and D - B (prony.h)

    static constexpr int centre_size = 6;    // sum of G_i B_i

    PronyLanes(const Prony &law, double dt) :
        bulk(law.K), G_inf(law.G_inf), G_0(law.G_0()), terms(static_cast<int>(law.terms.size())),
        term(law.terms.data())
    {
      for (int i = 0; i < terms; ++i) {
        const double h = dt * term[i].beta, decay = -std::expm1(-h);
        a[i] = rise(h, decay);
        b[i] = decay - a[i];
      }
    }

    // Q = J^(-2/3) F (G_0 I + sum of G_i B_i)
    DEFE_INLINE void respond(const Deformation &d, const Pack GB[6], Pack Q[3][3]) const
    {
      Pack T[6];
      const Pack j2 = d.j * d.j;
      for (int c = 0; c < 6; ++c) T[c] = j2 * (c < 3 ? G_0 + GB[c] : GB[c]);
      for (int i = 0; i < 3; ++i)
        for (int j = 0; j < 3; ++j)
          Q[i][j] =
              d.F[i][0] * T[index[0][j]] + d.F[i][1] * T[index[1][j]] + d.F[i][2] * T[index[2][j]];
    }

    template <bool with_energy>
    DEFE_INLINE void at_gauss_point(const Deformation &d, const LaneHistory &history, Pack *centre,
                                    Pack Q[3][3], Pack &energy, Pack &dissipated) const
    {
      constexpr int row[6] = {0, 1, 2, 0, 0, 1}, column[6] = {0, 1, 2, 1, 2, 2};
      Pack C[6], D[6], D_old[6];    // Cbar, Cbar^-1 - I
      const Pack j2 = d.j * d.j;
      if (history.advance) {
        // Cbar^-1 = J^(2/3) F^-1 F^-T, F^-1 = cof/J
        const auto &F = d.F;
        Pack cofactor[3][3];    // of row i: rows are (column i+1) x (column i+2) of F
        for (int i = 0; i < 3; ++i)
          for (int j = 0; j < 3; ++j)
            cofactor[i][j] = F[(j + 1) % 3][(i + 1) % 3] * F[(j + 2) % 3][(i + 2) % 3] -
                F[(j + 2) % 3][(i + 1) % 3] * F[(j + 1) % 3][(i + 2) % 3];
        const Pack factor = d.j / d.J;
        for (int c = 0; c < 6; ++c) {
          const int i = row[c], j = column[c];
          D[c] = factor *
              (cofactor[i][0] * cofactor[j][0] + cofactor[i][1] * cofactor[j][1] +
               cofactor[i][2] * cofactor[j][2]);
          if (c < 3) D[c] -= 1.0;
          D_old[c] = history.load(c);
        }
      }
      if (with_energy || history.dissipation)
        for (int c = 0; c < 6; ++c) {
          const int i = row[c], j = column[c];
          C[c] = j2 * (d.F[0][i] * d.F[0][j] + d.F[1][i] * d.F[1][j] + d.F[2][i] * d.F[2][j]);
        }
      Pack C_old[6];
      if (history.dissipation) {
        inverse_of_one_plus(D_old, C_old);
        dissipated = Pack{};
      }
      if constexpr (with_energy) energy = (0.5 * G_inf) * (C[0] + C[1] + C[2] - 3.0);

      Pack GB[6] = {};
      for (int t = 0; t < terms; ++t) {
        const int at = 6 * (t + 1);
        Pack B[6];
        for (int c = 0; c < 6; ++c) B[c] = history.load(at + c);
        if (history.advance) {
          Pack to_D[6], to_D_old[6], step[6];
          for (int c = 0; c < 6; ++c) {
            to_D[c] = D[c] - B[c];
            to_D_old[c] = D_old[c] - B[c];
            step[c] = a[t] * to_D[c] + b[t] * to_D_old[c];
          }
          if (history.dissipation)
            dissipated += (0.5 * term[t].G) * loss(B, step, to_D, to_D_old, C, C_old);
          for (int c = 0; c < 6; ++c) {
            B[c] += step[c];
            history.store(at + c, B[c]);
          }
        }
        for (int c = 0; c < 6; ++c) GB[c] += term[t].G * B[c];
        if constexpr (with_energy) {
          // tr(Cbar A) - 3 - ln det A
          Pack CB = Pack{};
          for (int c = 0; c < 6; ++c) CB += (c < 3 ? 1.0 : 2.0) * C[c] * B[c];
          energy += (0.5 * term[t].G) * ((C[0] + C[1] + C[2] - 3.0) + CB - log1p(volume_strain(B)));
        }
      }
      if (history.advance)
        for (int c = 0; c < 6; ++c) history.store(c, D[c]);
      for (int c = 0; c < 6; ++c) centre[c] += 0.125 * GB[c];
      respond(d, GB, Q);
    }

    DEFE_INLINE void at_centre(const Deformation &d, const Pack *centre, Pack Q[3][3]) const
    {
      respond(d, centre, Q);
    }

    // Dissipation of one term per G/2 while A = I + B changes by `step`: the stored energy that this
    // change sets free, mean of that at the old and that at the new strain,
    //   ln det(A + step) - ln det A - (C + C_old)/2 : step,
    // which is exact while the strain is held and of second order in dt otherwise. Rewritten
    // without differences of nearly equal numbers: with M = A^-1 step,
    //   A^-1 - C = A^-1 (C^-1 - A) C,  ln det(I + M) - tr M = log1p(m) - m + (m - tr M).
    DEFE_INLINE Pack loss(const Pack B[6], const Pack step[6], const Pack to_D[6],
                          const Pack to_D_old[6], const Pack C[6], const Pack C_old[6]) const
    {
      Pack A_inverse[6], P[3][3], R[3][3], M[3][3];
      inverse_of_one_plus(B, A_inverse);
      multiply(A_inverse, to_D, P);
      multiply(C, step, R);
      Pack force = trace_of_product(P, R);
      multiply(A_inverse, to_D_old, P);
      multiply(C_old, step, R);
      force = 0.5 * (force + trace_of_product(P, R));
      multiply(A_inverse, step, M);
      const Pack trace = M[0][0] + M[1][1] + M[2][2];
      const Pack higher = 0.5 * (trace * trace - trace_of_product(M, M)) +
          determinant(step) * determinant(A_inverse);
      return force + log1p_rest(trace + higher) + higher;
    }
  };

}    // namespace

double Prony::G_0() const
{
  double sum = G_inf;
  for (const Term &t : terms) sum += t.G;
  return sum;
}

std::string Prony::validate() const
{
  // written so that NaN fails as well
  std::ostringstream complaint;
  if (!(rho > 0.0 && std::isfinite(rho)))
    complaint << "density must be positive, not " << rho;
  else if (!(G_inf >= 0.0 && std::isfinite(G_inf)))
    complaint << "long-term shear modulus G_inf must not be negative, not " << G_inf;
  else if (terms.size() > max_terms)
    complaint << "a Prony series may have up to " << max_terms << " terms, not " << terms.size();
  for (size_t i = 0; complaint.str().empty() && i < terms.size(); ++i) {
    if (!(terms[i].G > 0.0 && std::isfinite(terms[i].G)))
      complaint << "shear modulus G of Prony term " << i + 1 << " must be positive, not "
                << terms[i].G;
    else if (!(terms[i].beta > 0.0 && std::isfinite(terms[i].beta)))
      complaint << "decay rate beta of Prony term " << i + 1 << " must be positive, not "
                << terms[i].beta;
  }
  if (!complaint.str().empty()) return complaint.str();

  if (!(G_0() > 0.0))
    complaint << "a Prony series needs G_inf > 0 or a term";
  else if (!(K >= 2.0 / 3.0 * G_0() && std::isfinite(K)))
    complaint << "bulk modulus must be at least 2/3 of the instantaneous shear modulus G_inf + G_1 "
                 "+ ... = "
              << G_0() << ", not " << K;
  else if (!(elastic_from_bulk_shear(K, G_0(), 1.0).nu < 0.5))
    complaint << "bulk modulus " << K << " is too large beside the shear modulus " << G_0();
  return complaint.str();
}

PronyKernel::PronyKernel(const Prony &m) :
    FBarKernel(m.validate(), m.K, elastic_from_bulk_shear(m.K, m.G_0(), m.rho)), law(m)
{
}

int PronyKernel::point_history_size() const
{
  return 6 * (1 + static_cast<int>(law.terms.size()));
}

void PronyKernel::add_forces(int n, const int (*nodes)[8], const double *x, const double *X,
                             double *f, const Output &out) const
{
  add_fbar_forces(PronyLanes(law, out.dt), history_size(), n, nodes, x, X, f, out);
}

namespace {

  Mat3 symmetric(const double *s)
  {
    Mat3 m;
    m << s[0], s[3], s[4], s[3], s[1], s[5], s[4], s[5], s[2];
    return m;
  }

}    // namespace

double PronyKernel::shear_energy(const Mat3 &F, const double *history) const
{
  const Mat3 C = std::pow(F.determinant(), -2.0 / 3.0) * F.transpose() * F;
  double w = 0.5 * law.G_inf * (C.trace() - 3.0);
  for (size_t i = 0; i < law.terms.size(); ++i) {
    const Mat3 A = history ? Mat3(Mat3::Identity() + symmetric(history + 6 * (i + 1)))
                           : Mat3::Identity();
    w += 0.5 * law.terms[i].G * (C.cwiseProduct(A).sum() - 3.0 - std::log(A.determinant()));
  }
  return w;
}

Mat3 PronyKernel::shear_stress(const Mat3 &F, const double *history) const
{
  Mat3 T = law.G_0() * Mat3::Identity();
  if (history)
    for (size_t i = 0; i < law.terms.size(); ++i)
      T += law.terms[i].G * symmetric(history + 6 * (i + 1));
  Mat3 s = std::pow(F.determinant(), -2.0 / 3.0) * F * T * F.transpose();
  s.diagonal().array() -= s.trace() / 3.0;
  return s;
}

}    // namespace defe::fe
