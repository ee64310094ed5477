#include "defe/fe/plastic.h"

#include "fbar.h"
#include "lane_functions.h"

#include <cmath>
#include <sstream>

namespace defe::fe {

namespace {

  // Symmetric tensors are xx yy zz xy xz yz throughout.
  constexpr int row[6] = {0, 1, 2, 0, 0, 1}, column[6] = {0, 1, 2, 1, 2, 2};
  constexpr int component[3][3] = {{0, 3, 4}, {3, 1, 5}, {4, 5, 2}};

  // places in the history of a Gauss point
  constexpr int old_strain = 0, flow = 6, plastic_strain = 12, plastic_rate = 13, temperature = 14;
  constexpr int short_history = 13, long_history = 15;

  DEFE_INLINE Pack trace(const Pack A[6])
  {
    return A[0] + A[1] + A[2];
  }

  DEFE_INLINE Pack contract(const Pack A[6], const Pack B[6])
  {
    return A[0] * B[0] + A[1] * B[1] + A[2] * B[2] +
        2.0 * (A[3] * B[3] + A[4] * B[4] + A[5] * B[5]);
  }

  // E = Cbar - I
  DEFE_INLINE void isochoric_strain(const Deformation &d, Pack E[6])
  {
    const Pack j2 = d.j * d.j;
    for (int c = 0; c < 6; ++c) {
      const int i = row[c], j = column[c];
      E[c] = j2 * (d.F[0][i] * d.F[0][j] + d.F[1][i] * d.F[1][j] + d.F[2][i] * d.F[2][j]);
      if (c < 3) E[c] -= 1.0;
    }
  }

  // (I + E)^-1 - I, for det(I + E) = 1
  DEFE_INLINE void inverse_less_one(const Pack E[6], Pack D[6])
  {
    D[0] = E[1] + E[2] + E[1] * E[2] - E[5] * E[5];
    D[1] = E[0] + E[2] + E[0] * E[2] - E[4] * E[4];
    D[2] = E[0] + E[1] + E[0] * E[1] - E[3] * E[3];
    D[3] = E[4] * E[5] - E[3] - E[3] * E[2];
    D[4] = E[3] * E[5] - E[4] - E[4] * E[1];
    D[5] = E[3] * E[4] - E[5] - E[5] * E[0];
  }

  // The elastic strain of a trial step: invariants of b_e = Fbar A Fbar^T, which are those of Cbar A.
  struct Trial {
    Pack tau;       // a third of the trace, less 1
    Pack J2, J3;    // of the deviator
    Pack root;      // sqrt(3 J2): von Mises stress by shear modulus

    DEFE_INLINE Trial(const Pack E[6], const Pack B[6])
    {
      // m = (I + E)(I + B) - I
      Pack m[3][3];
      for (int i = 0; i < 3; ++i)
        for (int j = 0; j < 3; ++j)
          m[i][j] = E[component[i][j]] + B[component[i][j]] +
              (E[component[i][0]] * B[component[0][j]] + E[component[i][1]] * B[component[1][j]] +
               E[component[i][2]] * B[component[2][j]]);
      tau = (m[0][0] + m[1][1] + m[2][2]) * (1.0 / 3.0);
      for (int i = 0; i < 3; ++i) m[i][i] -= tau;
      J2 = 0.5 * (m[0][0] * m[0][0] + m[1][1] * m[1][1] + m[2][2] * m[2][2]) + m[0][1] * m[1][0] +
          m[0][2] * m[2][0] + m[1][2] * m[2][1];
      J2 = J2 > 0.0 ? J2 : Pack{};
      J3 = m[0][0] * (m[1][1] * m[2][2] - m[1][2] * m[2][1]) -
          m[0][1] * (m[1][0] * m[2][2] - m[1][2] * m[2][0]) +
          m[0][2] * (m[1][0] * m[2][1] - m[1][1] * m[2][0]);
      root = simd::sqrt(3.0 * J2);
    }

    // t - 1 for det(alpha dev + t I) = 1: Newton's iteration from above, or near the root
    DEFE_INLINE Pack isochoric(const Pack &alpha) const
    {
      const Pack p = alpha * alpha * J2, constant = alpha * alpha * alpha * J3 - p;
      const auto improved = [&](const Pack &t) {
        return t - (t * (3.0 - p + t * (3.0 + t)) + constant) / (3.0 - p + t * (6.0 + 3.0 * t));
      };
      Pack t = alpha * alpha * tau;
      const simd::Mask gross = J2 > 0.01;
      if (__builtin_expect(simd::any(gross), false)) {
        // where all principal values of alpha dev + I t are above 1
        Pack above = alpha * root * (2.0 / 3.0);
        for (int i = 0; i < 20; ++i) above = improved(above);
        t = gross ? above : t;
      }
      for (int i = 0; i < 3; ++i) t = improved(t);
      return t;
    }

    // plastic strain by -d alpha on the way back (plastic.h)
    DEFE_INLINE Pack strain_rate(const Pack &alpha, const Pack &tau_there) const
    {
      const Pack t = 1.0 + tau_there;
      return (1.5 / root) * (2.0 * J2 * t - 3.0 * alpha * J3) / (3.0 * t * t - alpha * alpha * J2);
    }
  };

  // sigma_y = yield + hardening eps
  struct LinearHardening {
    double sigma, slope;

    LinearHardening(const Plastic &law, double) : sigma(law.yield), slope(law.hardening) {}

    struct Point {
      const LinearHardening &law;
      Pack start;    // yield stress before the step

      DEFE_INLINE Point(const LinearHardening &law, const LaneHistory &, const Pack &strain) :
          law(law), start(law.sigma + law.slope * strain)
      {
      }
      // The plastic strain of the step by sigma_y = stress - stiffness * strain; 0 where stress <= start.
      DEFE_INLINE Pack flow(const Pack &stress, const Pack &stiffness, const Pack &) const
      {
        return stress > start ? (stress - start) / (stiffness + law.slope) : Pack{};
      }
      DEFE_INLINE Pack guess() const { return Pack{}; }
      DEFE_INLINE void store(const LaneHistory &, const Pack &, const Pack &) const {}
    };
  };

  struct JohnsonCook {
    double sigma, hardening, exponent, rate_factor, softening, melting, heating;
    double dt, rate_strain;    // plastic strain of a step at the reference rate

    JohnsonCook(const Plastic &law, double dt) :
        sigma(law.yield), hardening(law.hardening), exponent(law.exponent),
        rate_factor(law.rate_factor), softening(law.softening), melting(law.melting),
        heating(law.heating), dt(dt), rate_strain(dt * law.rate_unit)
    {
    }

    struct Point {
      const JohnsonCook &law;
      Pack strain, soft, rise, start, rate;

      DEFE_INLINE Point(const JohnsonCook &law, const LaneHistory &history, const Pack &strain) :
          law(law), strain(strain), rise(history.load(temperature)),
          rate(history.load(plastic_rate))
      {
        soft = simd::broadcast(1.0);
        if (law.softening > 0.0) {
          const Pack T = rise * (1.0 / law.melting);
          const Pack left = 1.0 - power(T, law.softening);
          soft = left > 0.0 ? left : Pack{};
        }
        start = soft * (law.sigma + law.hardening * power(strain, law.exponent));
      }

      // x^n for x >= 0
      DEFE_INLINE static Pack power(const Pack &x, double n)
      {
        const Pack positive = x > 1e-300 ? x : simd::broadcast(1e-300);
        return lanes::exp(n * lanes::log(positive));
      }

      // sigma_y after a plastic strain d, and its derivative
      DEFE_INLINE Pack stress(const Pack &d, Pack &slope) const
      {
        const Pack eps = strain + d, power_law = law.hardening * power(eps, law.exponent);
        const Pack hard = soft * (law.sigma + power_law);
        const Pack hard_slope = soft * (law.exponent * power_law / eps);
        const Pack relative = d * (1.0 / law.rate_strain);
        const simd::Mask fast = relative > 1.0;
        const Pack factor = fast ? 1.0 + law.rate_factor * lanes::log(relative)
                                 : simd::broadcast(1.0);
        slope = hard_slope * factor + (fast ? law.rate_factor * hard / d : Pack{});
        return hard * factor;
      }

      // As above. Newton's iteration between bounds; a lane that has converged stays as it is, whatever others do.
      DEFE_INLINE Pack flow(const Pack &sigma, const Pack &stiffness, const Pack &first) const
      {
        const simd::Mask flows = sigma > start;
        Pack high = flows ? (sigma - start) / stiffness : simd::broadcast(1.0);
        Pack low = 1e-9 * high;
        Pack d = first > low ? (first < high ? first : high) : high;
        simd::Mask open = flows;
        for (int i = 0; i < 40 && simd::any(open); ++i) {
          Pack slope;
          const Pack excess = stress(d, slope) + stiffness * d - sigma;
          high = excess > 0.0 ? d : high;
          low = excess > 0.0 ? low : d;
          Pack next = d - excess / (slope + stiffness);
          const simd::Mask outside = (next <= low) | (next >= high);
          if (simd::any(outside)) next = outside ? simd::sqrt(low * high) : next;
          open &= simd::abs(excess) > 1e-13 * sigma;
          d = open ? next : d;
        }
        return flows ? d : Pack{};
      }
      DEFE_INLINE Pack guess() const { return rate * law.dt; }
      DEFE_INLINE void store(const LaneHistory &history, const Pack &step, const Pack &stress) const
      {
        history.store(plastic_rate, step * (1.0 / law.dt));
        history.store(temperature, rise + law.heating * stress * step);
      }
    };
  };

  template <class Hardening> struct PlasticLanes {
    double bulk, G, G_back, G_flow, ratio;    // G_back + G_flow = G, ratio = G_flow/G (plastic.h)
    Hardening hardening;

    static constexpr int centre_size = 6;    // A - I

    PlasticLanes(const Plastic &law, double dt) :
        bulk(law.K), G(law.G), G_back(law.G * law.kinematic / (3.0 * law.G + law.kinematic)),
        G_flow(G - G_back), ratio(G_flow / G), hardening(law, dt)
    {
    }

    // Q = J^(-2/3) F (G I + G_flow B)
    DEFE_INLINE void respond(const Deformation &d, const Pack B[6], Pack Q[3][3]) const
    {
      Pack T[6];
      const Pack j2 = d.j * d.j;
      for (int c = 0; c < 6; ++c) T[c] = j2 * (c < 3 ? G + G_flow * B[c] : G_flow * B[c]);
      for (int i = 0; i < 3; ++i)
        for (int j = 0; j < 3; ++j)
          Q[i][j] = d.F[i][0] * T[component[0][j]] + d.F[i][1] * T[component[1][j]] +
              d.F[i][2] * T[component[2][j]];
    }

    template <bool with_energy>
    DEFE_INLINE void at_gauss_point(const Deformation &d, const LaneHistory &history, Pack *centre,
                                    Pack Q[3][3], Pack &energy, Pack &dissipated) const
    {
      Pack B[6], E[6];
      for (int c = 0; c < 6; ++c) B[c] = history.load(flow + c);
      if (with_energy || history.advance) isochoric_strain(d, E);
      if (history.advance) {
        dissipated = advance(E, history, B);
        for (int c = 0; c < 6; ++c) history.store(old_strain + c, E[c]);
      }
      if constexpr (with_energy)
        energy = (0.5 * G) * trace(E) + (0.5 * G_flow) * (trace(B) + contract(E, B));
      for (int c = 0; c < 6; ++c) centre[c] += 0.125 * B[c];
      respond(d, B, Q);
    }

    DEFE_INLINE void at_centre(const Deformation &d, const Pack *centre, Pack Q[3][3]) const
    {
      respond(d, centre, Q);
    }

    // Plastic flow of a step: B and the rest of the history are changed. Returns what is dissipated.
    DEFE_INLINE Pack advance(const Pack E[6], const LaneHistory &history, Pack B[6]) const
    {
      const Trial trial(E, B);
      const Pack strain = history.load(plastic_strain), stress = G * trial.root;
      const typename Hardening::Point point(hardening, history, strain);
      const simd::Mask flows = stress > point.start;
      if (!simd::any(flows)) {
        point.store(history, Pack{}, stress);
        return Pack{};
      }
      // The strain rate at the middle of the way depends on where it ends, but little.
      Pack back = Pack{}, step = point.guess();
      for (int i = 0; i < 2; ++i) {
        const Pack middle = 1.0 - 0.5 * back;
        const Pack rate = ratio * trial.strain_rate(middle, trial.isochoric(middle));
        step = point.flow(stress, stress / rate, step);
        back = flows ? step / rate : Pack{};
      }
      const Pack alpha = 1.0 - back, tau = trial.isochoric(alpha);
      const Pack to_inverse = (1.0 + tau) - alpha * (1.0 + trial.tau),
                 rest = tau - alpha * trial.tau;
      Pack D[6], change[6], sum[6];
      inverse_less_one(E, D);
      for (int c = 0; c < 6; ++c) {
        const Pack flown = alpha * B[c] + to_inverse * D[c] + (c < 3 ? rest : Pack{});
        change[c] = flows ? flown - B[c] : Pack{};
        sum[c] = E[c] + history.load(old_strain + c);
        B[c] = flows ? flown : B[c];
        history.store(flow + c, B[c]);
      }
      history.store(plastic_strain, strain + step);
      point.store(history, step, alpha * stress);
      // - dW/dA : change, mean of that at the old and that at the new strain: with the work done by the mean of the old
      // and the new stress the energy is then balanced, but for the curvature of Cbar in x
      return (-0.25 * G_flow) * (2.0 * trace(change) + contract(sum, change));
    }
  };

}    // namespace

std::string Plastic::validate() const
{
  // written so that NaN fails as well
  const auto negative = [](double v) {
    return !(v >= 0.0 && std::isfinite(v));
  };
  std::ostringstream complaint;
  if (!(G > 0.0 && std::isfinite(G)))
    complaint << "shear modulus must be positive, not " << G;
  else if (!(K >= 2.0 / 3.0 * G && std::isfinite(K)))
    complaint << "Poisson's ratio of a metal must not be negative";
  else if (!(rho > 0.0 && std::isfinite(rho)))
    complaint << "density must be positive, not " << rho;
  else if (!(yield > 0.0 && std::isfinite(yield)))
    complaint << "yield stress must be positive, not " << yield;
  else if (!(yield <= 0.3 * G))
    complaint << "yield stress " << yield << " is above 0.3 of the shear modulus " << G
              << ": check the units";
  else if (negative(hardening))
    complaint << "hardening must not be negative, not " << hardening
              << ": softening depends on the mesh";
  else if (!(exponent > 0.0 && exponent <= 1.0))
    complaint << "hardening exponent n must be above 0 and not above 1, not " << exponent;
  else if (negative(kinematic))
    complaint << "kinematic hardening modulus must not be negative, not " << kinematic;
  else if (negative(rate_factor))
    complaint << "rate factor C must not be negative, not " << rate_factor;
  else if (!(rate_unit > 0.0 && std::isfinite(rate_unit)))
    complaint << "reference rate must be positive, not " << rate_unit;
  else if (negative(softening))
    complaint << "thermal exponent m must not be negative, not " << softening;
  else if (!(melting > 0.0 && std::isfinite(melting)))
    complaint << "melting must be a rise of temperature, not " << melting;
  else if (negative(heating))
    complaint << "heating by plastic work must not be negative, not " << heating;
  return complaint.str();
}

PlasticKernel::PlasticKernel(const Plastic &m) :
    FBarKernel(m.validate(), m.K, elastic_from_bulk_shear(m.K, m.G, m.rho)), law(m)
{
}

int PlasticKernel::point_history_size() const
{
  return law.linear() ? short_history : long_history;
}

void PlasticKernel::add_forces(int n, const int (*nodes)[8], const double *x, const double *X,
                               double *f, const Output &out) const
{
  if (law.linear())
    add_fbar_forces(PlasticLanes<LinearHardening>(law, out.dt), history_size(), n, nodes, x, X, f,
                    out);
  else
    add_fbar_forces(PlasticLanes<JohnsonCook>(law, out.dt), history_size(), n, nodes, x, X, f, out);
}

PlasticState PlasticKernel::plastic_state(const double *history) const
{
  PlasticState state;
  if (!history) return state;
  const int size = point_history_size();
  for (int p = 0; p < 8; ++p, history += size) {
    state.strain += 0.125 * history[plastic_strain];
    if (!law.linear()) state.temperature += 0.125 * history[temperature];
  }
  return state;
}

namespace {

  // A - I of a Gauss point
  Mat3 flown(const double *history)
  {
    if (!history) return Mat3::Zero();
    const double *s = history + flow;
    Mat3 B;
    B << s[0], s[3], s[4], s[3], s[1], s[5], s[4], s[5], s[2];
    return B;
  }

  // G_e
  double flow_modulus(const Plastic &law)
  {
    return law.G * 3.0 * law.G / (3.0 * law.G + law.kinematic);
  }

}    // namespace

double PlasticKernel::shear_energy(const Mat3 &F, const double *history) const
{
  const Mat3 C = std::pow(F.determinant(), -2.0 / 3.0) * F.transpose() * F;
  return 0.5 * law.G * (C.trace() - 3.0) +
      0.5 * flow_modulus(law) * C.cwiseProduct(flown(history)).sum();
}

Mat3 PlasticKernel::shear_stress(const Mat3 &F, const double *history) const
{
  const Mat3 T = law.G * Mat3::Identity() + flow_modulus(law) * flown(history);
  Mat3 s = std::pow(F.determinant(), -2.0 / 3.0) * F * T * F.transpose();
  s.diagonal().array() -= s.trace() / 3.0;
  return s;
}

}    // namespace defe::fe
