#include "defe/coupling/crack_softening.h"

#include "defe/simd.h"

#include <Eigen/Geometry>
#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <cstring>
#include <optional>

namespace defe {

namespace {

  struct Projected {
    double area, length;
  };

  Projected projected(const CrackGeometry &g, const Vec3 &m)
  {
    return {std::max(std::abs(g.a.dot(m)), 0.1 * g.a.norm()),
            std::max(std::abs(g.d.dot(m)), 0.1 * g.d.norm())};
  }

  /// Law of a joint that the crack cuts at an angle, weight of the shear: the user's on an axis, and 1 where the joint lies in
  /// the plane of the crack. There what slides along m is mostly a crack that opens, and must soften as such.
  CohesiveParameters oblique(const CohesiveParameters &par, const CrackGeometry &g, const Vec3 &m)
  {
    const double c = g.d.dot(m), along = std::min(c * c / g.d.squaredNorm(), 1.0);
    const double weight = par.reciprocal ? 1.0 / par.beta : par.beta;
    return {par.sigma_t, par.G_f, weight * along + std::max(weight, 1.0) * (1.0 - along), false,
            par.softening};
  }

  /// Of the joints that R was taken from: which, and whether they said how the DE has turned.
  constexpr unsigned joints_used = 0x3f, said_how = 0x40;

  /// Rotation of one end, and what it was taken from. It stays where the caller has it, if he does.
  class EndTurn {
   public:
    EndTurn(const CrackEnd &end, int slot)
    {
      unsigned use = end.present;
      find(end, use);
      if (slot >= 0 && crack_joint_has_a_say(*turn, use)) {
        use |= 1u << slot;
        find(end, use);
      }
      defined = turn->defined;
      used = static_cast<unsigned char>(use | (defined ? said_how : 0u));
    }
    /// By what it was taken from before.
    EndTurn(const CrackEnd &end, unsigned char before) : used(before)
    {
      find(end, before & joints_used);
      defined = turn->defined && (before & said_how) != 0;
    }
    EndTurn(const EndTurn &) = delete;
    EndTurn &operator=(const EndTurn &) = delete;

    const DERotation &operator*() const { return *turn; }
    const DERotation *operator->() const { return turn; }
    bool defined;
    unsigned char used;

   private:
    const DERotation *turn;
    std::optional<DERotation> own;

    void find(const CrackEnd &end, unsigned use)
    {
      turn = known_rotation(end, use);
      if (!turn) turn = &own.emplace(de_rotation(end, use));
    }
  };

  /// Mean rotation of the two DEs: polar factor of the sum of theirs.
  struct Frame {
    EndTurn end[2];
    Eigen::Quaterniond turn;
    bool defined;

    Frame(const CrackGeometry &geometry, const CrackEnd &near, const CrackEnd &far) :
        end{{near, geometry.slot[0]}, {far, geometry.slot[1]}}
    {
      find_mean();
    }
    Frame(const CrackEnd &near, const CrackEnd &far, const unsigned char used[2]) :
        end{{near, used[0]}, {far, used[1]}}
    {
      find_mean();
    }

   private:
    void find_mean()
    {
      const auto &[near, far] = end;
      defined = near.defined || far.defined;
      if (near.defined && far.defined) {
        const Eigen::Vector4d a(near->quaternion), b(far->quaternion);
        const Eigen::Vector4d sum = a + (a.dot(b) < 0.0 ? -1.0 : 1.0) * b;
        turn = Eigen::Quaterniond(Eigen::Vector4d(sum.normalized()));
      } else if (defined) {
        turn = Eigen::Quaterniond((near.defined ? near : far)->quaternion);
      }
    }
  };

  Eigen::Quaterniond last_turn(const CrackJoint &joint)
  {
    return Eigen::Quaterniond(joint.turn[3], joint.turn[0], joint.turn[1], joint.turn[2]);
  }

  void keep_turn(CrackJoint &joint, const Eigen::Quaterniond &q)
  {
    for (int k = 0; k < 4; ++k) joint.turn[k] = q.coeffs()[k];
  }

  Eigen::Quaterniond turned_by_spin(const CrackJoint &joint, const Vec3 &spin)
  {
    const double angle = spin.norm();
    if (angle == 0.0) return last_turn(joint);
    return Eigen::Quaterniond(Eigen::AngleAxisd(angle, spin / angle)) * last_turn(joint);
  }

  void set_broken(CrackJoint &joint, const CrackGeometry &geometry, const CornerModuli &moduli,
                  const CohesiveParameters &par)
  {
    const JointStiffness k =
        joint_stiffness(moduli.lambda, moduli.mu, projected(geometry, Vec3(joint.m)).length);
    joint.k_m = k.k_n;
    joint.k_p = k.k_s;
    joint.s0 = par.sigma_t;
    joint.kappa = par.sigma_t / k.k_n + softening_curve(par.softening).length(par.sigma_t, par.G_f);
    joint.broken = 1;
  }

}    // namespace

bool crack_joint_has_a_say(const DERotation &turn, unsigned present)
{
  const bool several = (present & (present - 1)) != 0;
  return turn.poor && several;
}

// --- switch -----------------------------------------------------------------

double crack_release(const GeneralCell &cell, const Vec3 y[6], unsigned present, unsigned leaving,
                     const CornerModuli &moduli, double share[6])
{
  Vec3 half_force[6];
  leaving &= present;
  const double before = corner_strain_general(cell, y, present, moduli, half_force);
  const auto drop = [&](unsigned out) {
    return std::max(before - corner_strain_general(cell, y, present & ~out, moduli, half_force),
                    0.0);
  };
  const double all = drop(leaving);
  double sum = 0.0;
  for (int s = 0; s < 6; ++s) {
    share[s] = leaving >> s & 1u ? drop(1u << s) : 0.0;
    sum += share[s];
  }
  for (int s = 0; s < 6; ++s) share[s] *= sum > 0.0 ? all / sum : 0.0;
  return all;
}

bool crack_start(CrackJoint &joint, const Vec3 &m, double f, const CrackGeometry &geometry,
                 const Vec3 &force, const CrackEnd &near, const CrackEnd &far, const Vec3 &y)
{
  joint = CrackJoint{};
  joint.f = f;
  joint.turn[3] = 1.0;
  const Frame frame(geometry, near, far);
  for (int k = 0; k < 2; ++k) joint.used[k] = frame.end[k].used;
  if (frame.defined) keep_turn(joint, frame.turn);
  const Mat3 R = last_turn(joint).toRotationMatrix();
  const Vec3 t = R.transpose() * force / projected(geometry, m).area, place = R.transpose() * y;
  for (int k = 0; k < 3; ++k) {
    joint.m[k] = m[k];
    joint.e[k] = t[k];
    joint.offset[k] = -place[k];
  }
  return t.dot(m) > 1e-9 * t.norm();
}

void crack_take_over(CrackJoint &joint, const CrackGeometry &geometry, double budget,
                     const CornerModuli &moduli, const CohesiveParameters &par)
{
  constexpr double stiffest = 2.0;

  const Vec3 m(joint.m), t(joint.e);
  const Projected p = projected(geometry, m);
  const JointStiffness base = joint_stiffness(moduli.lambda, moduli.mu, p.length);
  double t_m = t.dot(m), k_m = base.k_n, k_p = base.k_s;
  Vec3 t_p = t - t_m * m;
  const double along = p.area * t_m * t_m / (2.0 * k_m);
  const double left = budget - along, pull2 = t_p.squaredNorm();
  // with next to nothing along the plane it is the joint of cohesive.h
  if (pull2 > 1e-12 * t_m * t_m)
    k_p = left > 1e-12 * budget ? std::clamp(p.area * pull2 / (2.0 * left), base.k_s, k_m) : k_m;

  const double needed = along + p.area * pull2 / (2.0 * k_p);
  if (!(budget > 1e-6 * needed)) {    // the corners held next to nothing: nothing to soften
    set_broken(joint, geometry, moduli, par);
    for (double &e : joint.e) e = 0.0;
    return;
  }
  if (needed > budget) {
    const double over = needed / budget, stiffer = std::min(over, stiffest);
    k_m *= stiffer;
    k_p *= stiffer;
    t_m *= std::sqrt(stiffer / over);
    t_p *= std::sqrt(stiffer / over);
  }
  joint.k_m = k_m;
  joint.k_p = k_p;
  joint.s0 = equivalent_traction(t_m, t_p.norm(), oblique(par, geometry, m));
  joint.kappa = joint.s0 / k_m;
  const Vec3 e = (t_m / k_m) * m + t_p / k_p;
  for (int k = 0; k < 3; ++k) {
    joint.e[k] = e[k];
    joint.offset[k] += e[k];
  }
  joint.stored = joint.taken = 0.5 * p.area * (t_m * t_m / k_m + t_p.squaredNorm() / k_p);
}

CrackJoint crack_broken(const Vec3 &m, double f, const CrackGeometry &geometry,
                        const CornerModuli &moduli, const CohesiveParameters &par)
{
  CrackJoint joint{};
  for (int k = 0; k < 3; ++k) {
    joint.m[k] = m[k];
    joint.offset[k] = -geometry.d[k];
  }
  joint.f = f;
  joint.turn[3] = 1.0;
  set_broken(joint, geometry, moduli, par);
  return joint;
}

bool crack_frame_from(const CrackJoint &joint, int end)
{
  return (joint.used[end] & said_how) != 0;
}

void crack_turn(CrackJoint &joint, const Vec3 &spin)
{
  keep_turn(joint, turned_by_spin(joint, spin));
}

// --- evaluation -------------------------------------------------------------

namespace {

  /// Cosine of half of 0.1: farther (in rad) DEs do not turn between two evaluations.
  constexpr double largest_turn = 0.99875;

  /// With a turn by the spins of less than this, and by the joints of less than that (cosine of its half), the two are not as far
  /// apart as that.
  constexpr double small_spin = 0.04, small_turn = 0.9996;    // acos(small_turn) = 0.0283

  /// What R to go on from: that of the last evaluation, by the joints that it was taken from, if these have come or gone; with the
  /// spins, if it has turned over by itself. A whole body may turn as far, but then e is as before.
  Eigen::Quaterniond before_jump(const CrackJoint &joint, const CrackEnd &near, const CrackEnd &far,
                                 const Vec3 &y, const Vec3 &spin, const Frame &frame)
  {
    std::optional<Eigen::Quaterniond> same;
    if (frame.defined) same = frame.turn;
    if (joint.used[0] != frame.end[0].used || joint.used[1] != frame.end[1].used) {
      const Frame before(near, far, joint.used);
      same.reset();
      if (before.defined) same = before.turn;
    }
    if (same && spin.squaredNorm() < small_spin * small_spin &&
        std::abs(same->dot(last_turn(joint))) > small_turn)
      return *same;
    const Eigen::Quaterniond spun = turned_by_spin(joint, spin);
    if (!same || std::abs(same->dot(spun)) > largest_turn) return same.value_or(spun);
    const auto change = [&](const Eigen::Quaterniond &q) {
      return (Vec3(joint.offset) + q.toRotationMatrix().transpose() * y - Vec3(joint.e)).norm();
    };
    return change(*same) <= change(spun) ? *same : spun;
  }

  /// R of this evaluation. Where it jumps e does not: it is taken with the R to go on from.
  Mat3 present_frame(CrackJoint &joint, const CrackEnd &near, const CrackEnd &far, const Vec3 &y,
                     const Vec3 &spin, const Frame &frame)
  {
    const Eigen::Quaterniond turn = frame.defined ? frame.turn : turned_by_spin(joint, spin);
    const Mat3 R = turn.toRotationMatrix();
    const Eigen::Quaterniond old = before_jump(joint, near, far, y, spin, frame);
    if (old.coeffs() != turn.coeffs()) {
      const Vec3 jump = old.toRotationMatrix().transpose() * y - R.transpose() * y;
      for (int k = 0; k < 3; ++k) joint.offset[k] += jump[k];
    }
    for (int k = 0; k < 2; ++k) joint.used[k] = frame.end[k].used;
    keep_turn(joint, turn);
    return R;
  }

  /// Lets the stretch along the plane go that is beyond what friction holds.
  /// \return how much
  /// \param at  R^T y
  double slide(CrackJoint &joint, Vec3 &e, const Vec3 &at, const Vec3 &m, double held)
  {
    const Vec3 along = e - e.dot(m) * m;
    const double size = along.norm(), slip = size - held;
    // again at one place nothing changes, whatever the rounding of e
    if (!(slip > 1e-9 * held + 1e-14 * at.norm())) return 0.0;
    const Vec3 by = slip / size * along;
    for (int k = 0; k < 3; ++k) joint.offset[k] -= by[k];
    e = Vec3(joint.offset) + at;    // as the next evaluation will find it
    return slip;
  }

  /// The moment of the pair, as forces on the neighbours that its frame is taken from.
  void share_moment(CrackForces &out, const Frame &frame, const CrackEnd &near, const CrackEnd &far,
                    const CrackJoint &joint, const Vec3 &y)
  {
    const Vec3 moment = y.cross(out.force);
    if (!frame.defined) {
      out.torque = 0.5 * moment;
      return;
    }
    const bool both = frame.end[0].defined && frame.end[1].defined;
    const CrackEnd *const ends[2] = {&near, &far};
    for (int k = 0; k < 2; ++k) {
      if (!frame.end[k].defined) continue;
      add_moment(*frame.end[k], *ends[k], joint.used[k] & joints_used, (both ? 0.5 : 1.0) * moment,
                 out.arm[k]);
      for (const Vec3 &f : out.arm[k]) out.at[k] -= f;
    }
  }

}    // namespace

CrackForces crack_update(CrackJoint &joint, const CrackGeometry &geometry, const CrackEnd &near,
                         const CrackEnd &far, const Vec3 &y, const Vec3 &spin,
                         const CornerModuli &moduli, const CohesiveParameters &par, double friction)
{
  CrackForces out;
  out.force = out.torque = out.at[0] = out.at[1] = Vec3::Zero();
  for (auto &arms : out.arm)
    for (Vec3 &f : arms) f = Vec3::Zero();
  out.dissipated = out.fracture = out.excess = out.work_new = out.rubbed = 0.0;
  out.newly_broken = false;

  const Frame frame(geometry, near, far);
  const Mat3 R = present_frame(joint, near, far, y, spin, frame);
  const Vec3 m(joint.m), before(joint.e);
  const Vec3 at = R.transpose() * y;
  Vec3 e = Vec3(joint.offset) + at;
  const Vec3 moved = e - before;
  const Projected p = projected(geometry, m);
  const double k_c = joint_stiffness(moduli.lambda, moduli.mu, p.length).k_c;

  double t_m = 0.0, new_end = 0.0;    // work of half of the increment, by the pull of now
  Vec3 t_p = Vec3::Zero();
  if (!joint.broken) {
    const double e_m = before.dot(m), de_m = moved.dot(m);
    CohesiveState state{e_m, before - e_m * m, joint.s0, joint.kappa};
    const Vec3 de_p = moved - de_m * m;
    const CohesiveResult r =
        cohesive_update(state, de_m, de_p, {joint.k_m, k_c, joint.k_p}, oblique(par, geometry, m));
    const SofteningCurve &curve = softening_curve(par.softening);
    const double more_damage = curve.damage(joint.kappa, state.kappa, joint.s0 / joint.k_m,
                                            curve.length(joint.s0, par.G_f));
    joint.kappa = state.kappa;
    out.dissipated = p.area * r.dissipated;
    out.fracture = out.dissipated - more_damage * joint.taken;
    out.excess = p.area * r.excess;
    out.work_new = p.area * r.work_new;
    out.damage = r.damage;
    out.newly_broken = r.broken;
    joint.broken = r.broken;
    joint.stored = p.area * r.stored;
    t_m = r.t_n;
    t_p = r.t_s;
    if (r.broken) {
      joint.k_p = joint_stiffness(moduli.lambda, moduli.mu, p.length).k_s;
      slide(joint, e, at, m, 0.0);
    }
  }
  if (joint.broken) {
    const double limit = -friction * k_c * std::min(e.dot(m), 0.0);
    out.rubbed = p.area * limit * slide(joint, e, at, m, limit / joint.k_p);
    const double closing = std::min(e.dot(m), 0.0);
    t_m = k_c * closing;
    t_p = limit > 0.0 ? Vec3(joint.k_p * (e - e.dot(m) * m)) : Vec3(Vec3::Zero());
    joint.stored = 0.5 * p.area * (k_c * closing * closing + t_p.squaredNorm() / joint.k_p);
    out.damage = 1.0;
    new_end = 0.5 * p.area * (t_m * m + t_p).dot(moved);
    if (out.newly_broken) {    // the plane pushes on, where a joint of cohesive.h would be gone
      out.work_new = new_end;
      out.excess += new_end - joint.stored;
    }
  }
  for (int k = 0; k < 3; ++k) joint.e[k] = e[k];
  out.separated = joint.broken && (at - geometry.d).norm() > 0.2 * geometry.d.norm();
  if (out.separated) {
    out.excess +=
        joint.stored - new_end;    // of a closed plane that slid away: nobody takes it over
    out.work_new = 0.0;
    joint.stored = 0.0;
    return out;
  }
  out.force = p.area * (R * (t_m * m + t_p));
  if (out.force.squaredNorm() > 0.0) share_moment(out, frame, near, far, joint, y);
  return out;
}

// --- open planes, several at a time -----------------------------------------

namespace {

  using simd::Mask;
  using simd::Pack;

  // The same sums in the same order as in crack_update().

  struct PackVector {
    Pack x, y, z;

    friend DEFE_INLINE PackVector operator+(const PackVector &a, const PackVector &b)
    {
      return {a.x + b.x, a.y + b.y, a.z + b.z};
    }
    friend DEFE_INLINE PackVector operator-(const PackVector &a, const PackVector &b)
    {
      return {a.x - b.x, a.y - b.y, a.z - b.z};
    }
    friend DEFE_INLINE PackVector operator*(const Pack &f, const PackVector &a)
    {
      return {f * a.x, f * a.y, f * a.z};
    }
    DEFE_INLINE Pack dot(const PackVector &b) const { return x * b.x + y * b.y + z * b.z; }
    DEFE_INLINE Pack norm() const { return simd::sqrt(dot(*this)); }
    DEFE_INLINE void store(int lane, double to[3]) const
    {
      to[0] = x[lane];
      to[1] = y[lane];
      to[2] = z[lane];
    }
  };

  struct PackQuaternion {
    Pack x, y, z, w;

    DEFE_INLINE Pack dot(const PackQuaternion &b) const
    {
      return (x * b.x + z * b.z) + (y * b.y + w * b.w);
    }
    /// R^T a.
    DEFE_INLINE PackVector back(const PackVector &a) const
    {
      const Pack tx = 2.0 * x, ty = 2.0 * y, tz = 2.0 * z;
      const Pack twx = tx * w, twy = ty * w, twz = tz * w, txx = tx * x, txy = ty * x, txz = tz * x;
      const Pack tyy = ty * y, tyz = tz * y, tzz = tz * z;
      return {(1.0 - (tyy + tzz)) * a.x + (txy + twz) * a.y + (txz - twy) * a.z,
              (txy - twz) * a.x + (1.0 - (txx + tzz)) * a.y + (tyz + twx) * a.z,
              (txz + twy) * a.x + (tyz - twx) * a.y + (1.0 - (txx + tyy)) * a.z};
    }
  };

  /// Reads number k of what each lane has.
  template <class Of> DEFE_INLINE PackVector vectors(const Of &of)
  {
    return {simd::generate([&](int l) {
              return of(l)[0];
            }),
            simd::generate([&](int l) {
              return of(l)[1];
            }),
            simd::generate([&](int l) {
              return of(l)[2];
            })};
  }

  template <class Of> DEFE_INLINE PackQuaternion quaternions(const Of &of)
  {
    const PackVector v = vectors(of);
    return {v.x, v.y, v.z, simd::generate([&](int l) {
              return of(l)[3];
            })};
  }

  /// Rotation of one end as EndTurn has it, of what the caller knows.
  struct KnownTurn {
    const double *quaternion;
    unsigned char used;
    bool known;

    KnownTurn(const CrackEnd &end, int slot)
    {
      static constexpr double none[4] = {0.0, 0.0, 0.0, 1.0};
      const DERotation *turn = end.turn;
      unsigned use = end.present;
      if (turn && crack_joint_has_a_say(*turn, use)) {
        use |= 1u << slot;
        turn = known_rotation(end, use);
      }
      known = turn != nullptr;
      const bool defined = known && turn->defined;
      quaternion = defined ? turn->quaternion : none;
      used = static_cast<unsigned char>(use | (defined ? said_how : 0u));
    }
    bool defined() const { return (used & said_how) != 0; }
  };

  /// Up to simd::width of them.
  void open_planes(int n, const BrokenPlane *planes, bool *open)
  {
    constexpr int width = simd::width;
    const CrackJoint *law[width];
    const double *y_of[width], *d_of[width], *turn_of[2][width];
    bool in_question[width];
    double has[2][width];
    for (int l = 0; l < width; ++l) {
      const BrokenPlane &plane = planes[l < n ? l : 0];
      law[l] = plane.joint;
      y_of[l] = plane.near->y[plane.slot[0]].data();
      d_of[l] = plane.near->dX[plane.slot[0]].data();
      const KnownTurn near(*plane.near, plane.slot[0]), far(*plane.far, plane.slot[1]);
      turn_of[0][l] = near.quaternion;
      turn_of[1][l] = far.quaternion;
      has[0][l] = near.defined();
      has[1][l] = far.defined();
      // R did not jump, and is known
      in_question[l] = law[l]->broken && near.known && far.known &&
          (near.defined() || far.defined()) && law[l]->used[0] == near.used &&
          law[l]->used[1] == far.used && plane.spin.squaredNorm() < small_spin * small_spin;
    }
    const auto lanes = [](const double *p) {
      Pack v;
      std::memcpy(&v, p, sizeof(v));
      return v;
    };

    const auto a = quaternions([&](int l) {
      return turn_of[0][l];
    });
    const auto b = quaternions([&](int l) {
      return turn_of[1][l];
    });
    const Pack sign = a.dot(b) < 0.0 ? simd::broadcast(-1.0) : simd::broadcast(1.0);
    const PackQuaternion sum{a.x + sign * b.x, a.y + sign * b.y, a.z + sign * b.z,
                             a.w + sign * b.w};
    const Pack size = simd::sqrt(sum.dot(sum));
    const Mask near = lanes(has[0]) > 0.0, both = near & (lanes(has[1]) > 0.0);
    const auto mean = [&](const Pack &s, const Pack &one, const Pack &other) {
      return both ? s / size : (near ? one : other);
    };
    const PackQuaternion turn{mean(sum.x, a.x, b.x), mean(sum.y, a.y, b.y), mean(sum.z, a.z, b.z),
                              mean(sum.w, a.w, b.w)};
    const auto last = quaternions([&](int l) {
      return law[l]->turn;
    });

    const auto y = vectors([&](int l) {
      return y_of[l];
    });
    const auto d = vectors([&](int l) {
      return d_of[l];
    });
    const auto m = vectors([&](int l) {
      return law[l]->m;
    });
    auto offset = vectors([&](int l) {
      return law[l]->offset;
    });
    const PackVector at = turn.back(y);
    PackVector e = offset + at;
    const Pack opening = e.dot(m);
    // without pressure nothing holds it along the plane, see slide()
    const PackVector along = e - opening * m;
    const Mask slips = along.norm() > 1e-14 * at.norm();
    const auto without = [&](const Pack &from, const Pack &slip) {
      return slips ? from - slip : from;
    };
    offset = {without(offset.x, along.x), without(offset.y, along.y), without(offset.z, along.z)};
    e = offset + at;
    const Pack size_d = d.norm();
    const unsigned is_open =
        simd::bits((simd::abs(turn.dot(last)) > small_turn) & (opening > 0.0) & (e.dot(m) > 0.0) &
                   ((at - d).norm() <= 0.2 * size_d) & (y.norm() <= 1.2 * size_d));
    for (int l = 0; l < n; ++l) {
      open[l] = in_question[l] && is_open >> l & 1u;
      if (!open[l]) continue;
      CrackJoint &joint = *planes[l].joint;
      offset.store(l, joint.offset);
      e.store(l, joint.e);
      joint.turn[0] = turn.x[l];
      joint.turn[1] = turn.y[l];
      joint.turn[2] = turn.z[l];
      joint.turn[3] = turn.w[l];
      joint.stored = 0.0;
    }
  }

}    // namespace

void crack_update_open(int n, const BrokenPlane *planes, bool *open)
{
  for (int first = 0; first < n; first += simd::width)
    open_planes(std::min(simd::width, n - first), planes + first, open + first);
}

}    // namespace defe
