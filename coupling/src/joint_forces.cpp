// JointStates: forces of joints and ties, and their output.

#include "defe/coupling/joint_states.h"

#include "prefetch_vector.h"

#include "defe/coupling/conversion.h"
#include "defe/coupling/prefetch.h"
#include "defe/triples.h"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <type_traits>

namespace defe {

// --- corners ----------------------------------------------------------------

void JointStates::half_forces(bool each_alone)
{
  if (jt.nde == 0) return;
  jt.find_tie_points(particles.x);
  const OrthogonalLattice lattice{jt.orthogonal,
                                  jt.self.data(),
                                  reinterpret_cast<const int(*)[6]>(jt.nb.data()),
                                  jt.present.data(),
                                  reinterpret_cast<const double(*)[6]>(jt.len.data()),
                                  reinterpret_cast<const double(*)[6]>(jt.half.data()),
                                  jt.material.data(),
                                  jt.free.data(),
                                  jt.rows.data()};
  jt.corners.resize(jt.cell.size());
  corner_half_forces(lattice, jt.nde, jt.cell.data(), jt.corners.data(), particles.x,
                     jt.tie_point.data(), laws.moduli.data(), each_alone, jt.half_forces(),
                     jt.energy.data());
}

void JointStates::without_connective()
{
  for (int d = 0; d < jt.nde; ++d) {
    jt.present[d] = 0;
    for (int s = 0; s < 6; ++s)
      if (jt.record(d, s).kind != joint::NONE)
        jt.record(d, s).state = jt.state[6 * d + s] = joint::CONTACT;
  }
}

void JointStates::gather(ForceSums &sums)
{
  constexpr int ahead = 8, n = LatticeRow::size;
  above.clear();
  const bool rows = !sums.tally.on();
  for (int d = 0; d < jt.nde; ++d) {
    if (rows && d % n == 0 && d + n <= jt.nde && gather_row(d / n, sums)) {
      d += n - 1;
      continue;
    }
    if (d + ahead < jt.nde)
      for (int other : jt.partner[d + ahead])
        __builtin_prefetch(jt.half_force_of(std::max(other, 0)));
    if (sums.tally.on() || !gather_quiet(d, sums)) gather(d, sums);
  }
  // strain energy of DEs after their conversion, to compare with that before
  for (int d : jt.newborn) ledger.conv_strain -= jt.energy[d];
}

namespace {

  using simd::Pack;

  DEFE_INLINE Pack load(const double *p)
  {
    Pack v;
    std::memcpy(&v, p, sizeof(v));
    return v;
  }

  /// The sum of own[s] - other[s] for the vectors of eight DEs one behind the other.
  /// \return  the largest square of any component of these differences, without those that are no number
  template <class Count>
  DEFE_INLINE double sum_of_row(Count count, const double *const *own, const double *const *other,
                                double *sum)
  {
    constexpr int packs = 3 * LatticeRow::size / simd::width;
    Pack most = Pack{};
    for (int k = 0; k < packs; ++k) {
      Pack all = Pack{}, here = Pack{};
      for (int s = 0; s < count; ++s) {
        const Pack f = load(own[s] + simd::width * k) - load(other[s] + simd::width * k);
        all += f;
        here = simd::max(f * f, here);
      }
      most = simd::max(here, most);
      std::memcpy(sum + simd::width * k, &all, sizeof(all));
    }
    double largest = 0.0;
    for (int l = 0; l < simd::width; ++l) largest = std::max(largest, most[l]);
    return largest;
  }

}    // namespace

/// Eight DEs in a row, joined to other DEs only, and all far from their strength; false: they are not that.
bool JointStates::gather_row(int r, ForceSums &sums)
{
  constexpr int n = LatticeRow::size;
  const LatticeRow &row = jt.rows[r];
  const int d = n * r;
  if (row.self < 0) return false;
  for (int l = 0; l < n; ++l)
    if (jt.present[d + l] != row.slots) return false;
  const double *own[6], *other[6];
  int count = 0;
  for (int s = 0; s < 6; ++s) {
    if (!(row.slots >> s & 1u)) continue;
    own[count] = jt.half_force_of(d, s);
    other[count++] = jt.half_force_of(row.behind[s], row.partner[s]);
  }
  double sum[3 * n];
  const double largest = count == 6 ? sum_of_row(std::integral_constant<int, 6>(), own, other, sum)
                                    : sum_of_row(count, own, other, sum);
  // not less than the square of any of these forces
  if (!(3.0 * (1.0 + 1e-12) * largest <= least_of_row[r])) return false;
  auto &rounding = *sums.rounding;
  double *f = sums.force_on(row.self);
  if (rounding.force_grid().on())
    for (int k = 0; k < 3 * n; ++k)
      f[k] += rounding.on_grid(rounding.force_grid(), sum[k], row.self + k / 3);
  else
    for (int k = 0; k < 3 * n; ++k) f[k] += sum[k];
  for (int l = 0; l < n; ++l) stored.joints += jt.energy[d + l];
  return true;
}

/// The same for a DE that is joined to other DEs only, and far from its strength, as most are; false: it is none.
bool JointStates::gather_quiet(int d, ForceSums &sums)
{
  const unsigned present = jt.present[d];
  simd::Triple force, most;
  for (int s = 0; s < 6; ++s) {
    if (!(present >> s & 1u)) continue;
    const int other = jt.partner[d][s];
    if (other < 0) return false;
    const auto f = simd::Triple(jt.half_force_of(d, s)) - simd::Triple(jt.half_force_of(other));
    force = force + f;
    most = larger(f.squares(), most);    // NaN reaches nothing
  }
  // not less than the square of any of these forces
  const double bound = (1.0 + 1e-12) * (most[0] + most[1] + most[2]);
  if (!(bound <= least_threshold[d])) return false;
  const int i = jt.self[d];
  auto &rounding = *sums.rounding;
  double *f = sums.force_on(i);
  for (int k = 0; k < 3; ++k) f[k] += rounding.on_grid(rounding.force_grid(), force[k], i);
  stored.joints += jt.energy[d];
  return true;
}

/// Both halves of each joint of a DE; ties act on the nodes of the face.
void JointStates::gather(int d, ForceSums &sums)
{
  const int i = jt.self[d];
  auto &rounding = *sums.rounding;
  const SumGrid &grid = rounding.force_grid();
  const double *xi = particles.at(i);
  double fi[3] = {0.0, 0.0, 0.0};
  int joints = 0, ties = 0;
  for (int s = 0; s < 6; ++s) {
    if (!(jt.present[d] & (1u << s))) continue;
    const double *h = jt.half_force_of(d, s);
    const int nb = jt.nb[d][s];
    if (nb >= 0) {
      const double *g = jt.half_force_of(jt.partner[d][s]);
      const double fx = h[0] - g[0], fy = h[1] - g[1], fz = h[2] - g[2];
      fi[0] += fx;
      fi[1] += fy;
      fi[2] += fz;
      if (reaches(fx * fx + fy * fy + fz * fz, d, s)) above.push_back(6 * d + s);
      ++joints;
      if (sums.tally.on()) {
        const double *xn = particles.at(nb);
        const double del[3] = {xi[0] - xn[0], xi[1] - xn[1], xi[2] - xn[2]};
        sums.tally(del, h, i);
      }
    } else {
      for (int k = 0; k < 3; ++k) fi[k] += h[k];
      const auto pull = [&](int node, double weight) {
        double *fa = sums.force_on(node);
        for (int k = 0; k < 3; ++k) fa[k] -= rounding.on_grid(grid, weight * h[k], node);
      };
      if (jt.is_place(nb))
        jt.for_place(nb, pull);
      else
        for (int a = 0; a < 4; ++a) pull(jt.tie_node[~nb][a], weights_of(jt.tie_spot[~nb])[a]);
      if (reaches(h[0] * h[0] + h[1] * h[1] + h[2] * h[2], d, s)) above.push_back(6 * d + s);
      ++ties;
      if (sums.tally.on()) {
        const double *p = &jt.tie_point[3 * ~nb];
        const double del[3] = {xi[0] - p[0], xi[1] - p[1], xi[2] - p[2]};
        sums.tally(del, h, i);
      }
    }
  }
  double *f = sums.force_on(i);
  for (int k = 0; k < 3; ++k) f[k] += rounding.on_grid(grid, fi[k], i);
  const double e = jt.energy[d];
  if (ties) {
    stored.ties += e * ties / (joints + ties);
    stored.joints += e * joints / (joints + ties);
  } else
    stored.joints += e;
}

// The force of a joint between two ranks is the difference of both halves. A ghost may be on its way to a third rank.

int JointStates::pack_forces(int d, double *buf) const
{
  int m = 0;
  buf[m++] = wanted[d];
  for (int s = 0; s < 6; ++s)
    if (wanted[d] >> s & 1u) {
      std::copy_n(jt.half_force_of(d, s), 3, buf + m);
      m += 3;
    }
  return m + (cracks_ ? cracks_->pack_energy(d, buf + m) : 0);
}

int JointStates::unpack_forces(int d, const double *buf)
{
  int m = 0;
  wanted[d] = static_cast<unsigned char>(buf[m++]);
  for (int s = 0; s < 6; ++s)
    if (wanted[d] >> s & 1u) {
      std::copy_n(buf + m, 3, jt.half_forces().of(d, s));
      m += 3;
    }
  return m + (cracks_ ? cracks_->unpack_energy(d, buf + m) : 0);
}

// --- softening --------------------------------------------------------------

SofteningJoint JointStates::softening(JointRecord &slot, SoftJoint &soft)
{
  return {soft.cohesive, soft.length0, slot.area, soft.stored, soft.lost, slot.pending};
}

namespace {

  /// A hint that the tie, if it is one, is computed soon: its nodes are far from the DE in memory.
  void expect_tie(const JointTable &jt, const MovingParticles &particles, int joint)
  {
    const int nb = jt.nb[joint / 6][joint % 6];
    if (nb >= 0) return;
    for (int node : jt.tie_node[~nb]) {
      prefetch_vector(particles.at(node));
      prefetch_vector(particles.v + 3 * static_cast<std::ptrdiff_t>(node));
    }
  }

}    // namespace

/// Each by the rank of its lower ID.
void JointStates::soften(ForceSums &sums)
{
  constexpr std::size_t ahead = 4;
  jt.debonded.clear();
  if (cracks_) take_over_cracks();
  list_softening();
  if (cracks_) wake_beside_cuts();
  find_awake();
  if (cracks_) leave_out_open();
  bool any_ended = false;
  // another crack of this DE may have come to its end a moment ago
  std::size_t seen = 0;    // of those that have moved: these are flagged
  const auto elsewhere = [&](int d) {
    const auto &moved = cracks_->moved();
    if (seen < moved.size()) flagged.resize(jt.nall, 0);
    for (; seen < moved.size(); ++seen) flagged[moved[seen]] = 1;
    return seen > 0 && flagged[d] != 0;
  };
  for (std::size_t n = 0; n < awake.size(); ++n) {
    if (n + ahead < awake.size()) {
      const Softening &next = softening_list[awake[n + ahead]];
      prefetch(next.record);
      if (next.plane == 0) prefetch(next.soft);
      prefetch(next.crack);
      if (next.plane != 0)
        cracks_->expect_resting(jt.cohesive[awake[n + ahead]]);
      else if (!next.crack)
        expect_tie(jt, particles, jt.cohesive[awake[n + ahead]]);
    }
    const int ds = jt.cohesive[awake[n]];
    Softening &one = softening_list[awake[n]];
    const int d = ds / 6, s = ds % 6;
    if (one.record->kind == joint::TIE)
      soften_tie(d, s, *one.soft, sums);
    else if (one.crack)
      soften_crack(d, s, *one.soft, (elsewhere(d) ? cracks_->find(ds) : one.crack)->law, sums);
    else
      soften_joint(d, s, *one.soft, sums);
    one.plane = one.record->plane;
    any_ended = any_ended || jt.state[ds] == joint::CONTACT;
  }
  for (std::size_t k = 0; k < seen; ++k) flagged[cracks_->moved()[k]] = 0;
  if (any_ended) forget_ended();
}

/// Those that are new since the last step; and where the cracks of a DE are now, if there is one more or less.
void JointStates::list_softening()
{
  const auto crack_of = [this](int ds) {
    return by_crack(ds / 6, ds % 6) ? cracks_->find(ds) : nullptr;
  };
  if (cracks_ && !cracks_->moved().empty()) {
    flagged.resize(jt.nall, 0);
    for (int d : cracks_->moved()) flagged[d] = 1;
    for (std::size_t k = 0; k < softening_list.size(); ++k)
      if (flagged[jt.cohesive[k] / 6]) softening_list[k].crack = crack_of(jt.cohesive[k]);
    for (int d : cracks_->moved()) flagged[d] = 0;
    cracks_->forget_moved();
  }
  const std::size_t n = jt.cohesive.size();
  for (std::size_t k = softening_list.size(); k < n; ++k) {
    if (cracks_ && k + 8 < n) __builtin_prefetch(host.find_cracks(jt.cohesive[k + 8] / 6));
    if (cracks_ && k + 4 < n)
      if (const auto *list = host.find_cracks(jt.cohesive[k + 4] / 6)) {
        __builtin_prefetch(list->data());
        prefetch(&jt.record(jt.cohesive[k + 4]));
        __builtin_prefetch(&jt.records[jt.cohesive[k + 4] / 6]->soft);
      }
    JointRecord &slot = jt.record(jt.cohesive[k]);
    softening_list.push_back(
        {&slot, &jt.soft_joint(jt.cohesive[k]), crack_of(jt.cohesive[k]), slot.plane});
  }
}

/// Open planes at DEs that have lost a joint are looked at now, while the joints that their rotation was taken from still are where
/// they were: later on these would say nothing, and e would jump.
void JointStates::wake_beside_cuts()
{
  if (cracks_->poorer().empty()) return;
  flagged.resize(jt.nall, 0);
  for (int d : cracks_->poorer()) flagged[d] = 1;
  for (std::size_t k = 0; k < softening_list.size(); ++k) {
    signed char &plane = softening_list[k].plane;
    const int ds = jt.cohesive[k];
    if (std::abs(plane) > 2 && (flagged[ds / 6] || flagged[cracks_->other_end(ds) / 6]))
      softening_list[k].record->plane = plane = plane < 0 ? -2 : 2;
  }
  for (int d : cracks_->poorer()) flagged[d] = 0;
  cracks_->forget_poorer();
}

/// All that soften, and the planes of broken ones that may be closed.
void JointStates::find_awake()
{
  awake.clear();
  cut_by_cracks.clear();
  const int n = static_cast<int>(jt.cohesive.size());
  for (int k = 0; k < n; ++k) {
    const int ds = jt.cohesive[k];
    Softening &one = softening_list[k];
    if (cracks_ && cracks_->rests(ds, one.crack, one.plane, dt)) {
      one.record->plane = one.plane;
      continue;
    }
    awake.push_back(k);
    if (one.crack) cut_by_cracks.push_back(ds);
  }
  if (cracks_) cracks_->know(cut_by_cracks);
}

/// Open planes have no force: they are dealt with all together, and only the others are looked at one by one.
void JointStates::leave_out_open()
{
  constexpr std::size_t ahead = 4;
  broken_planes.clear();
  for (int k : awake) {
    const Softening &one = softening_list[k];
    if (one.crack && one.plane != 0) broken_planes.push_back({jt.cohesive[k], &one.crack->law});
  }
  const auto &open = cracks_->advance_open(broken_planes, dt);
  std::size_t left = 0, broken = 0;
  for (std::size_t n = 0; n < awake.size(); ++n) {
    const int k = awake[n];
    Softening &one = softening_list[k];
    const bool is_plane = one.crack && one.plane != 0;
    if (!is_plane || !open[broken++]) {
      awake[left++] = k;
      continue;
    }
    if (broken + ahead < broken_planes.size())
      cracks_->expect_resting(broken_planes[broken + ahead].joint);
    one.plane = one.record->plane = cracks_->resting(jt.cohesive[k], one.crack->law, dt);
  }
  awake.resize(left);
}

/// Those that are broken, and that no plane takes any more.
void JointStates::forget_ended()
{
  std::size_t left = 0;
  for (std::size_t k = 0; k < jt.cohesive.size(); ++k) {
    if (jt.state[jt.cohesive[k]] == joint::CONTACT) continue;
    jt.cohesive[left] = jt.cohesive[k];
    softening_list[left++] = softening_list[k];
  }
  jt.cohesive.resize(left);
  softening_list.resize(left);
}

void JointStates::book(const SofteningStep &step)
{
  ledger.fracture += step.fracture;
  ledger.release += step.released;
  ledger.release += step.beside;
}

void JointStates::soften_tie(int d, int s, SoftJoint &soft, ForceSums &sums)
{
  const int i = jt.self[d];
  JointRecord &slot = jt.record(d, s);
  const auto &node = jt.tie_node[~jt.nb[d][s]];
  const auto tie = tie_point(d, s);
  Vec3 v[4];
  for (int a = 0; a < 4; ++a) v[a] = particles.velocity(node[a]);
  auto softening_joint = softening(slot, soft);
  const auto step = defe::soften(softening_joint, tie.normal(), tie.length(),
                                 dt * tie.slide(particles.velocity(i), v), moving, stiffness(d, s),
                                 adhesive_law(d, s));
  book(step);
  if (step.law.broken) {
    set_broken(d, s);
    jt.debonded.push_back(6 * d + s);
    event(d, s, EventKind::DEBONDED, step.law.damage);
    return;
  }
  stored.cohesive += soft.stored;

  Vec3 on_node[4];
  tie.reactions(step.force, on_node);
  auto &rounding = *sums.rounding;
  const SumGrid &grid = rounding.force_grid();
  double *f = sums.force_on(i);
  for (int k = 0; k < 3; ++k) f[k] += rounding.on_grid(grid, step.force[k], i);
  for (int a = 0; a < 4; ++a) {
    double *fa = sums.force_on(node[a]);
    for (int k = 0; k < 3; ++k) fa[k] += rounding.on_grid(grid, on_node[a][k], node[a]);
    if (!sums.tally.on()) continue;
    // relative to the DE: its own force has no share then
    const Vec3 del = particles.position(node[a]) - particles.position(i);
    sums.tally(del.data(), on_node[a].data(), i);
  }
}

void JointStates::soften_joint(int d, int s, SoftJoint &soft, ForceSums &sums)
{
  const int i = jt.self[d], j = jt.nb[d][s];
  JointRecord &slot = jt.record(d, s);
  const Vec3 y = particles.position(j) - particles.position(i);
  const double length = y.norm();
  const Vec3 n = y / length;
  const Vec3 w = 0.5 * (particles.spin(i) + particles.spin(j));
  Vec3 slide = particles.velocity(j) - particles.velocity(i) - w.cross(y);
  slide -= slide.dot(n) * n;
  auto softening_joint = softening(slot, soft);
  const auto step =
      defe::soften(softening_joint, n, length, dt * slide, moving, stiffness(d, s), law_of(d, s));
  book(step);
  if (step.law.broken) {
    set_broken(d, s);
    event(d, s, EventKind::BROKEN, step.law.damage);
    return;
  }
  stored.cohesive += soft.stored;

  const Vec3 force = sums.rounding->force(step.force, i);
  const Vec3 moment = sums.rounding->torque(0.5 * y.cross(force), i);
  double *fi = sums.force_on(i), *fj = sums.force_on(j);
  double *ti = sums.torque_on(i), *tj = sums.torque_on(j);
  for (int k = 0; k < 3; ++k) {
    fi[k] += force[k];
    fj[k] -= force[k];
    ti[k] += moment[k];
    tj[k] += moment[k];
  }
  if (sums.tally.on()) {
    const Vec3 del = -y;
    sums.tally(del.data(), force.data(), i);
  }
}

// --- cut by planes of their own ---------------------------------------------

void JointStates::take_over_cracks()
{
  for (int ds : taking_over)
    event(ds / 6, ds % 6, EventKind::COHESIVE, cracks_->take_over(ds, law_of(ds / 6, ds % 6)));
  taking_over.clear();
  cracks_->end_take_over();
}

/// A softening joint, or the closed plane of a broken one.
void JointStates::soften_crack(int d, int s, SoftJoint &soft, CrackJoint &law, ForceSums &sums)
{
  const int ds = 6 * d + s;
  JointRecord &slot = jt.record(ds);
  const JointCoeff &coeff = laws.of(particles.type[jt.self[d]], particles.type[jt.nb[d][s]]);
  const auto r =
      cracks_->advance(ds, law, coeff.cohesive, laws.with_contact ? coeff.friction : 0.0, dt);
  const double held = law.stored;

  ledger.fracture += r.fracture;
  ledger.friction += r.rubbed;
  ledger.release += r.dissipated - r.fracture;
  ledger.release += slot.pending ? r.work_new - r.dissipated - held : r.excess;
  slot.pending = 0;
  stored.cohesive += held;
  if (slot.state == joint::COHESIVE) {
    soft.lost += r.dissipated;
    soft.stored = law.broken ? 0.0 : held;
    if (law.broken) {
      close_plane(d, s);
      event(d, s, EventKind::BROKEN, 1.0);
    }
  }
  if (r.separated) {
    leave_plane(d, s);
    return;
  }
  if (slot.plane) slot.plane = cracks_->resting(ds, law, dt);
  apply_crack(d, s, r, sums);
}

/// Forces on both DEs and on the neighbours that their rotation is taken from: in balance, without a moment.
void JointStates::apply_crack(int d, int s, const CrackForces &r, ForceSums &sums)
{
  if (r.force.squaredNorm() == 0.0) return;
  const int there = cracks_->other_end(6 * d + s);
  const int end[2] = {d, there / 6};
  const int i = jt.self[d];
  auto &rounding = *sums.rounding;
  const auto pull = [&](int e, const Vec3 &by) {
    const int k = jt.self[e];
    double *f = sums.force_on(k);
    for (int c = 0; c < 3; ++c) f[c] += rounding.on_grid(rounding.force_grid(), by[c], k);
    if (!sums.tally.on() || e == d) return;
    // relative to the first DE: its own force has no share then
    const Vec3 del = particles.position(k) - particles.position(i);
    sums.tally(del.data(), by.data(), i);
  };
  pull(end[0], r.force + r.at[0]);
  pull(end[1], r.at[1] - r.force);
  for (int k = 0; k < 2; ++k)
    for (int q = 0; q < 6; ++q) {
      const int arm = cracks_->partners(end[k])[q];
      if (arm >= 0 && r.arm[k][q].squaredNorm() > 0.0) pull(arm / 6, r.arm[k][q]);
    }
  if (r.torque.squaredNorm() == 0.0) return;
  for (int e : end) {
    const int k = jt.self[e];
    const Vec3 moment = rounding.torque(r.torque, k);
    double *torque = sums.torque_on(k);
    for (int c = 0; c < 3; ++c) torque[c] += moment[c];
  }
}

// --- geometry ---------------------------------------------------------------

/// Normal of the face that a joint crosses, turned with the DE's cell.
Vec3 JointStates::face_normal(int d, int s, const Vec3 &along) const
{
  const Vec3 xi = particles.position(jt.self[d]);
  Vec3 y[6];
  for (int q = 0; q < 6; ++q) {
    const int nb = jt.nb[d][q];
    y[q] = Vec3(nb >= 0 ? particles.at(nb) : &jt.tie_point[3 * ~nb]) - xi;
  }
  return turned_normal(jt.cell[d - jt.orthogonal], jt.present[d], y, Vec3(jt.record(d, s).normal),
                       along);
}

TiePoint JointStates::tie_point(int d, int s) const
{
  Vec3 face[4];
  const int tie = ~jt.nb[d][s];
  for (int a = 0; a < 4; ++a) face[a] = particles.position(jt.tie_node[tie][a]);
  return {particles.position(jt.self[d]), face, jt.tie_spot[tie]};
}

// --- output -----------------------------------------------------------------

JointView JointStates::view(int ds) const
{
  const int d = ds / 6, s = ds % 6;
  const JointRecord &slot = jt.record(ds);
  const bool tie = slot.kind == joint::TIE, place = jt.is_tied(d, s);
  const double share = place ? jt.share_of_place(d, s) : 1.0;
  const Vec3 xi = particles.position(jt.self[d]);
  JointView v;
  Vec3 y;
  if (tie) {
    const auto point = tie_point(d, s);
    y = point.y();
    v.normal = point.normal();
    v.point = xi + y;
  } else if (place) {
    y = -xi;
    jt.for_place(jt.nb[d][s], [&](int i, double weight) {
      y += weight * particles.position(i);
    });
    v.normal = face_normal(d, s, y.normalized());
    v.point = xi + share * y;
  } else {
    y = particles.position(jt.nb[d][s]) - xi;
    v.normal = y.normalized();
    v.point = xi + 0.5 * y;
  }
  v.length = y.norm();
  v.damage = v.opening = v.slip = 0.0;
  const auto set_traction = [&v](const Vec3 &t) {
    v.t_n = t.dot(v.normal);
    v.t_s = (t - v.t_n * v.normal).norm();
  };

  if (place) {    // the force is that on the share of the area
    set_traction(Vec3(jt.half_force_of(ds)) / (share * slot.area));
    return v;
  }

  if (slot.state == joint::CONNECTIVE) {
    Vec3 force(jt.half_force_of(ds));
    if (!tie) {
      force -= Vec3(jt.half_force_of(jt.partner[d][s]));
      if (d >= jt.orthogonal) v.normal = face_normal(d, s, v.normal);
    }
    set_traction(force / slot.area);
    return v;
  }

  if (!tie && by_crack(d, s)) {    // along the crack and its plane
    CrackJoint crack = cracks_->find(ds)->law;
    const auto r = cracks_->look(ds, law_of(d, s), crack);
    const Vec3 m(crack.m), e(crack.e);
    v.normal = Eigen::Quaterniond(crack.turn[3], crack.turn[0], crack.turn[1], crack.turn[2]) * m;
    v.point = xi + crack.f * y;
    set_traction(r.force / slot.area);
    v.damage = r.damage;
    v.opening = e.dot(m);
    v.slip = (e - v.opening * m).norm();
    return v;
  }

  auto state = CohesiveState::unpack(jt.soft_joint(ds).cohesive);
  const auto r = cohesive_update(state, 0.0, Vec3::Zero(), stiffness(d, s),
                                 tie ? adhesive_law(d, s) : law_of(d, s));
  v.t_n = r.t_n;
  v.t_s = r.t_s.norm();
  v.damage = r.damage;
  v.opening = state.e_n;
  v.slip = state.e_s.norm();
  return v;
}

}    // namespace defe
