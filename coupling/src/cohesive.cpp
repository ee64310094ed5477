#include "defe/coupling/cohesive.h"

#include <algorithm>
#include <cmath>

namespace defe {

namespace {

  /// s/k_n of an elastic stretch: convex in it, so the largest value along a straight increment is
  /// at one of its ends.
  double stretch(double e_n, double e_s, const JointStiffness &k, const CohesiveParameters &p)
  {
    return equivalent_traction(k.k_n * e_n, k.k_s * e_s, p) / k.k_n;
  }

}    // namespace

void CohesiveState::pack(double *buffer) const
{
  buffer[0] = e_n;
  for (int i = 0; i < 3; ++i) buffer[1 + i] = e_s[i];
  buffer[4] = s0;
  buffer[5] = kappa;
}

CohesiveState CohesiveState::unpack(const double *buffer)
{
  return {buffer[0], Vec3(buffer[1], buffer[2], buffer[3]), buffer[4], buffer[5]};
}

JointStiffness joint_stiffness(double lambda, double mu, double length)
{
  const double E = mu * (3.0 * lambda + 2.0 * mu) / (lambda + mu);
  return {(lambda + 2.0 * mu) / length, E / length, mu / length};
}

double equivalent_traction(double t_n, double t_s, const CohesiveParameters &p)
{
  const double shear = p.reciprocal ? t_s / p.beta : p.beta * t_s;
  const double tension = std::max(t_n, 0.0);
  return std::sqrt(tension * tension + shear * shear);
}

CohesiveState cohesive_start(double t_n, const Vec3 &t_s, const JointStiffness &k,
                             const CohesiveParameters &p)
{
  const double s0 = equivalent_traction(t_n, t_s.norm(), p);
  return {t_n / (t_n > 0.0 ? k.k_n : k.k_c), t_s / k.k_s, s0, s0 / k.k_n};
}

namespace {

  struct Pull {
    double t_n;
    Vec3 t_s;
    double stored;
  };

  /// Tractions and stored energy of a state of which this share of the stiffness is left in tension.
  Pull pull(double e_n, const Vec3 &e_s, double intact, const JointStiffness &k)
  {
    const double opening = std::max(e_n, 0.0), closing = std::min(e_n, 0.0);
    return {intact * k.k_n * opening + k.k_c * closing, intact * k.k_s * e_s,
            0.5 * intact * (k.k_n * opening * opening + k.k_s * e_s.squaredNorm()) +
                0.5 * k.k_c * closing * closing};
  }

}    // namespace

CohesiveResult cohesive_update(CohesiveState &state, double de_n, const Vec3 &de_s,
                               const JointStiffness &k, const CohesiveParameters &p)
{
  const double kappa0 = state.s0 / k.k_n;
  const SofteningCurve &curve = softening_curve(p.softening);
  const double delta_c = curve.length(state.s0, p.G_f);
  const double old_e_n = state.e_n, old_kappa = state.kappa;
  const Vec3 old_e_s = state.e_s;

  state.e_n += de_n;
  state.e_s += de_s;
  const double now = stretch(state.e_n, state.e_s.norm(), k, p);

  const double before = stretch(old_e_n, old_e_s.norm(), k, p);

  double dissipated = 0.0;
  const double kappa = std::min(now, kappa0 + delta_c);
  if (kappa > state.kappa && now > before) {
    // Y dw with Y = (k_n <e_n>^2 + k_s |e_s|^2)/2 is (Y/kappa^2) kappa^2 dw, and Y/kappa^2 depends on the direction of
    // the stretch only: trapezoidal rule over the part of the increment that does damage. While the joint
    // is closed on the way there, its opening does not count.
    const double opens = old_e_n < 0.0 && state.e_n > 0.0 ? -old_e_n / de_n : 0.0;
    const double begins = opens > 0.0 ? stretch(0.0, (old_e_s + opens * de_s).norm(), k, p)
                                      : before;
    const auto direction = [&](double at) {
      const double share = now > begins ? std::clamp((at - begins) / (now - begins), 0.0, 1.0)
                                        : 1.0;
      const double f = opens + (1.0 - opens) * share;
      const double e_n = std::max(old_e_n + f * de_n, 0.0);
      const Vec3 e_s = old_e_s + f * de_s;
      const double size = stretch(e_n, e_s.norm(), k, p);
      return 0.5 * (k.k_n * e_n * e_n + k.k_s * e_s.squaredNorm()) / (size * size);
    };
    const double mean = 0.5 * (direction(state.kappa) + direction(kappa));
    dissipated = curve.dissipated(mean, state.kappa, kappa, kappa0, delta_c);
    state.kappa = kappa;
  }

  CohesiveResult r;
  r.damage = std::min(curve.damage(kappa0, state.kappa, kappa0, delta_c), 1.0);
  r.broken = state.kappa >= kappa0 + delta_c;
  if (r.broken) r.damage = 1.0;    // whatever the rounding of the quotient
  const double intact_before = old_kappa >= kappa0 + delta_c
      ? 0.0
      : kappa0 / old_kappa * (1.0 - curve.damage(kappa0, old_kappa, kappa0, delta_c));
  const Pull old = pull(old_e_n, old_e_s, intact_before, k);
  const Pull now_pull = pull(state.e_n, state.e_s, kappa0 / state.kappa * (1.0 - r.damage), k);
  r.t_n = now_pull.t_n;
  r.t_s = now_pull.t_s;
  r.stored = now_pull.stored;
  r.work_new = r.broken ? 0.0 : 0.5 * (r.t_n * de_n + r.t_s.dot(de_s));
  r.work = r.work_new + 0.5 * (old.t_n * de_n + old.t_s.dot(de_s));
  r.excess = r.work - ((r.broken ? 0.0 : r.stored) - old.stored) - dissipated;
  r.dissipated = dissipated;
  return r;
}

void cohesive_rotate(CohesiveState &state, const Vec3 &n_new)
{
  const double length2 = state.e_s.squaredNorm();
  state.e_s -= n_new.dot(state.e_s) * n_new;
  const double left2 = state.e_s.squaredNorm();
  if (left2 > 0.0) state.e_s *= std::sqrt(length2 / left2);
}

double cohesive_total_release(double s0, const JointStiffness &k, const CohesiveParameters &p)
{
  return 0.5 * s0 * s0 / k.k_n + p.G_f;
}

double toughness_limit(double E, double G_f, double sigma_t)
{
  return 2.0 * E * G_f / (sigma_t * sigma_t);
}

}    // namespace defe
