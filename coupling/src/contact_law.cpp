#include "defe/coupling/contact_law.h"

#include <Eigen/Geometry>

#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <string>

namespace defe {

namespace {

  /// Restitution of the spring and dashpot that cannot pull. The contact ends when the force is
  /// zero, at w t = phi = atan2(2 b w, b^2 - w^2) = 2 acos(zeta), with e = exp(-(b/w) phi).
  double restitution_of(double zeta)
  {
    const double w2 = 1.0 - zeta * zeta;
    if (std::abs(w2) < 1e-12) return std::exp(-2.0);
    if (w2 > 0.0) return std::exp(-2.0 * zeta * std::acos(zeta) / std::sqrt(w2));
    return std::exp(-2.0 * zeta * std::acosh(zeta) / std::sqrt(-w2));
  }

}    // namespace

double damping_ratio(double restitution)
{
  if (restitution >= 1.0) return 0.0;
  const double e = std::max(restitution, 1e-4);
  double low = 0.0, high = 1.0;
  while (restitution_of(high) > e) high *= 2.0;
  for (int i = 0; i < 60; ++i) {
    const double middle = 0.5 * (low + high);
    (restitution_of(middle) > e ? low : high) = middle;
  }
  return 0.5 * (low + high);
}

ContactParameters contact_parameters(double kn, double kt, double restitution, double friction)
{
  const auto require = [](bool ok, const char *what, double value) {
    if (!ok) throw std::invalid_argument(std::string(what) + ", not " + std::to_string(value));
  };
  require(kn > 0.0 && std::isfinite(kn), "normal contact stiffness must be > 0", kn);
  require(kt >= 0.0 && std::isfinite(kt), "tangential contact stiffness must be >= 0", kt);
  require(restitution > 0.0 && restitution <= 1.0, "restitution must be in (0, 1]", restitution);
  require(friction >= 0.0 && std::isfinite(friction), "friction must be >= 0", friction);
  return {kn, kt, restitution, friction, damping_ratio(restitution)};
}

ContactResult sphere_contact(const Vec3 &xi_minus_xj, const Vec3 &v_rel, const Vec3 &omega_i,
                             const Vec3 &omega_j, double ri, double rj, double contact_distance,
                             double reduced_mass, double dt, TangentialSpring &tangential,
                             const ContactParameters &p)
{
  ContactResult r;
  r.force.setZero();
  r.torque_i.setZero();
  r.torque_j.setZero();
  r.stored = r.damped = r.rubbed = 0.0;
  r.slipping = false;

  const double distance = xi_minus_xj.norm();
  r.overlap = contact_distance - distance;
  if (!(r.overlap > 0.0) || distance == 0.0) {
    r.rubbed = tangential.stored();    // a rest of the last step
    tangential = {};
    return r;
  }

  const Vec3 n = xi_minus_xj / distance;
  const double arm_i = distance * ri / (ri + rj), arm_j = distance - arm_i;

  // normal
  const double zeta = p.damping_ratio >= 0.0 ? p.damping_ratio : damping_ratio(p.restitution);
  const double v_n = n.dot(v_rel);
  const double spring = p.kn * r.overlap;
  const double F_n = std::max(0.0, spring - 2.0 * zeta * std::sqrt(p.kn * reduced_mass) * v_n);
  // v_rel is that of half a step ago (velocity Verlet); the force works with that of now
  r.damped = (spring - F_n) * (v_n + 0.5 * dt * F_n / reduced_mass) * dt;
  r.stored = 0.5 * spring * r.overlap;
  r.force = F_n * n;

  // tangential: the spring turns with the pair about n
  const Vec3 old(tangential.s), turned = old + 0.5 * dt * n.dot(omega_i + omega_j) * n.cross(old);
  const double length = turned.norm(), kept = length > 0.0 ? old.norm() / length : 1.0;
  for (int k = 0; k < 3; ++k) tangential.s[k] = kept * turned[k];
  const Vec3 slip_rate = v_rel - v_n * n - (arm_i * omega_i + arm_j * omega_j).cross(n);
  const FrictionResult along =
      coulomb_friction(tangential, n, dt * slip_rate, p.kt, p.friction * F_n);
  r.slipping = along.slipping;
  r.rubbed = along.rubbed;
  r.stored += along.stored;
  const Vec3 &F_t = along.force;
  r.force += F_t;
  const Vec3 moment = n.cross(F_t);
  r.torque_i = -arm_i * moment;
  r.torque_j = -arm_j * moment;
  return r;
}

}    // namespace defe
