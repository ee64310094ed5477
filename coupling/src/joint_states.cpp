#include "defe/coupling/joint_states.h"

#include "defe/coupling/conversion.h"

#include <algorithm>
#include <cmath>

namespace defe {

namespace {

  // Beside the state, in messages to other ranks: the joint becomes cohesive in the next step; and the same, the plane
  // of the crack follows.
  constexpr int PENDING = 4, PENDING_WITH_PLANE = 5;

}    // namespace

JointStates::JointStates(JointTable &table, const JointLaws &l, EnergyLedger &sums, StoredEnergy &s,
                         CrackHost &h) :
    jt(table),
    laws(l), host(h), ledger(sums), stored(s)
{
  cracks_ = std::make_unique<JointCracks>(jt, particles, host);
  cracks_->set_strengths(laws.types + 1, laws.crack_strengths(), laws.crack_nuclei(), laws.moduli);
  if (!cracks_->on()) cracks_.reset();
  for (const auto &c : laws.coeffs) crack_cuts.push_back(cracks_ && laws.opening(c).by_cracks());
  both_laws = cracks_ && laws.any_by_traction();
}

void JointStates::begin(const MovingParticles &p, double step, bool moves)
{
  particles = p;
  dt = step;
  moving = moves;
  events_.clear();
  broken_.clear();
  damaged_ = false;
}

// --- laws -------------------------------------------------------------------

const CohesiveParameters &JointStates::law_of(int d, int s) const
{
  return laws.of(particles.type[jt.self[d]], particles.type[jt.nb[d][s]]).cohesive;
}

/// That by which a joint starts: between DEs of one type flaws have their say.
CohesiveParameters JointStates::law_at_start(int d, int s) const
{
  CohesiveParameters law = law_of(d, s);
  const int other = jt.partner[d][s];
  if (other >= 0 && particles.type[jt.self[d]] == particles.type[jt.nb[d][s]])
    law.sigma_t = jt.flaws_between(d, other / 6, law.sigma_t);
  return law;
}

const CohesiveParameters &JointStates::adhesive_law(int d, int s) const
{
  return laws.adhesive_of(jt.material[d], jt.tie_part[~jt.nb[d][s]])->law;
}

const OpeningLaw &JointStates::opening(int d, int s) const
{
  const int other = jt.nb[d][s];
  if (other < 0) return opening_law_of_ties();
  return laws.opening(laws.of(particles.type[jt.self[d]], particles.type[other]));
}

/// Whether the joint is cut by a plane of its own; else its normal is that of the mesh.
bool JointStates::by_crack(int d, int s) const
{
  if (!cracks_) return false;
  const int other = jt.nb[d][s];
  if (other < 0) return false;
  return crack_cuts[laws.index(particles.type[jt.self[d]], particles.type[other])];
}

bool JointStates::at_lower_id(int d, int s) const
{
  return particles.id[jt.self[d]] < particles.id[jt.nb[d][s]];
}

// What has begun to soften, or is a closed plane, must go on by the law that it began with.
JointStates::OtherLaw JointStates::of_other_law() const
{
  OtherLaw found;
  for (int ds = 0; ds < 6 * jt.nde; ++ds) {
    const int d = ds / 6, s = ds % 6;
    const JointRecord &slot = jt.record(d, s);
    if (slot.kind != joint::DE || jt.nb[d][s] < 0 || !at_lower_id(d, s)) continue;
    if (slot.state != joint::COHESIVE && !slot.plane && slot.pending != 1) continue;
    bool has_plane = false;
    if (const auto *list = host.find_cracks(d))
      for (const auto &c : *list) has_plane = has_plane || c.slot == s;
    if (has_plane == by_crack(d, s)) continue;
    const int a = particles.type[jt.self[d]], b = particles.type[jt.nb[d][s]];
    const int code = 2 * laws.index(std::min(a, b), std::max(a, b)) + has_plane;
    found.first = found.count ? std::min(found.first, code) : code;
    ++found.count;
  }
  return found;
}

// --- tables -----------------------------------------------------------------

void JointStates::new_tables()
{
  jt.find_rows();
  least_threshold.assign(jt.nde, HUGE_VAL);
  least_of_row.assign(jt.rows.size(), HUGE_VAL);
  softening_list.clear();
  decided_elsewhere.clear();
  wanted.assign(jt.nall, 0);
  for (int d = 0; d < jt.nde; ++d)
    for (int s = 0; s < 6; ++s)
      if (jt.partner[d][s] >= 6 * jt.nde)
        wanted[d] = static_cast<unsigned char>(wanted[d] | 1u << s);
  if (!laws.with_cohesive) return;
  for (int d = 0; d < jt.nde; ++d)
    for (int s = 0; s < 6; ++s) {
      least_threshold[d] = std::min(least_threshold[d], threshold_of(d, s));
      if (jt.nb[d][s] >= 0 && jt.partner[d][s] >= 6 * jt.nde && !at_lower_id(d, s))
        decided_elsewhere.push_back(6 * d + s);
    }
  for (std::size_t r = 0; r < jt.rows.size(); ++r)
    least_of_row[r] = *std::min_element(&least_threshold[LatticeRow::size * r],
                                        &least_threshold[LatticeRow::size * r] + LatticeRow::size);
}

/// Square of the force below which the strength cannot be reached; infinite where there is no joint to decide on, or
/// where the other side decides.
double JointStates::threshold_of(int d, int s) const
{
  const bool tie = jt.nb[d][s] < 0;
  if (tie && jt.is_place(jt.nb[d][s])) return HUGE_VAL;
  if (tie ? !laws.adhesive_of(jt.material[d], jt.tie_part[~jt.nb[d][s]]) : jt.partner[d][s] < 0)
    return HUGE_VAL;
  if (!tie && !at_lower_id(d, s)) return HUGE_VAL;
  if (jt.state[6 * d + s] != joint::CONNECTIVE) return HUGE_VAL;
  const double traction =
      opening(d, s).least_traction(tie ? adhesive_law(d, s) : law_at_start(d, s));
  if (!std::isfinite(traction)) return HUGE_VAL;
  const double limit = jt.record(d, s).area * traction;
  return limit * limit * (1.0 - 1.0e-12);
}

// --- strength reached -------------------------------------------------------

bool JointStates::starts(int d, int s)
{
  JointRecord &slot = jt.record(d, s);
  const double *h = jt.half_force_of(6 * d + s);
  SoftJoint start{};
  auto softening_joint = softening(slot, start);
  const auto keep = [&](bool starts) {    // most of those that are looked at do not
    if (!starts) return false;
    SoftJoint &soft = jt.soft_joint(6 * d + s);
    std::copy_n(start.cohesive, CohesiveState::size, soft.cohesive);
    soft.length0 = start.length0;
    return true;
  };
  if (jt.nb[d][s] < 0) {    // a tie: all of its force is the DE's half
    const auto tie = tie_point(d, s);
    return keep(start_softening(softening_joint, Vec3(h) / slot.area, tie.normal(), tie.normal(),
                                tie.length(), stiffness(d, s), opening(d, s), adhesive_law(d, s)));
  }
  const double *g = jt.half_force_of(jt.partner[d][s]);
  const Vec3 t = Vec3(h[0] - g[0], h[1] - g[1], h[2] - g[2]) / slot.area;
  const Vec3 y = particles.position(jt.nb[d][s]) - particles.position(jt.self[d]);
  const double length = y.norm();
  const Vec3 along = y / length;
  const Vec3 normal = d < jt.orthogonal ? along : face_normal(d, s, along);
  return keep(start_softening(softening_joint, t, normal, along, length, stiffness(d, s),
                              opening(d, s), law_at_start(d, s)));
}

void JointStates::make_pending(int joint)
{
  jt.record(joint).pending = 1;
  mark_pending(joint);
}

/// The message of states asks for the bits: records are far apart in memory.
void JointStates::mark_pending(int joint)
{
  jt.pending.push_back(joint);
  unsigned char &slots = pending_of[joint / 6];
  slots = static_cast<unsigned char>(slots | 1u << joint % 6);
}

/// Before they are found anew. Before a run cracks do not decide again: their step is over.
void JointStates::forget_pending()
{
  if (cracks_) cracks_->forget_pending();
  std::vector<int> before;
  before.swap(jt.pending);
  pending_of.assign(jt.nde, 0);
  for (int ds : before) {
    if (!moving && jt.partner[ds / 6][ds % 6] >= 0 && by_crack(ds / 6, ds % 6)) {
      mark_pending(ds);
      if (cracks_->find(ds)) cracks_->keep_pending(ds);
    } else
      jt.record(ds).pending = 0;
  }
}

void JointStates::find_pending()
{
  forget_pending();
  for (int ds : above)
    if (starts(ds / 6, ds % 6)) {
      make_pending(ds);
      const int other = jt.partner[ds / 6][ds % 6];
      if (other >= 0 && other < 6 * jt.nde) make_pending(other);
    }
}

void JointStates::decide_cracks()
{
  cracks_->decide();
  for (int ds : cracks_->starts()) {
    make_pending(ds);
    const int other = jt.partner[ds / 6][ds % 6];
    if (other < 6 * jt.nde) make_pending(other);
  }
  for (int ds : jt.asking) jt.record(ds).asks = 0;
  jt.asking = cracks_->entered();
  for (int ds : jt.asking) jt.record(ds).asks = 1;
}

// --- from pending to cohesive -----------------------------------------------

/// f(d, leaving) for each owned DE with pending joints: which ones they are.
template <class F> void JointStates::for_leaving(F f)
{
  std::sort(jt.pending.begin(), jt.pending.end());
  for (std::size_t k = 0; k < jt.pending.size();) {
    const int d = jt.pending[k] / 6;
    unsigned leaving = 0;
    for (; k < jt.pending.size() && jt.pending[k] / 6 == d; ++k) leaving |= 1u << jt.pending[k] % 6;
    f(d, leaving);
  }
}

/// What corners let go when joints leave them. The kicks of velocity Verlet belong to the old law up to half-way
/// between the two steps: it is their energy now, less the work that their forces of now would have done in the
/// second half of the step. For an energy that goes with the square of the stretches that is exact.
double JointStates::release_of_pending()
{
  double release = 0.0;
  for_leaving([&](int d, unsigned leaving) {
    Vec3 before[6], after[6];
    const unsigned present = jt.present[d];
    const auto &moduli = laws.moduli[jt.material[d]];
    const double drop = jt.corner_energy(d, present, particles.x, moduli, before) -
        jt.corner_energy(d, present & ~leaving, particles.x, moduli, after);
    double work = 0.0;
    for (int s = 0; s < 6; ++s) {
      if (!(present & 1u << s)) continue;
      const int nb = jt.nb[d][s];
      Vec3 speed = -particles.velocity(jt.self[d]);
      if (nb >= 0)
        speed += particles.velocity(nb);
      else if (jt.is_place(nb))
        jt.for_place(nb, [&](int i, double weight) {
          speed += weight * particles.velocity(i);
        });
      else
        for (int a = 0; a < 4; ++a)
          speed += weights_of(jt.tie_spot[~nb])[a] * particles.velocity(jt.tie_node[~nb][a]);
      work += dt * speed.dot(before[s] - after[s]);
    }
    release += drop - 0.5 * work;
    // a DE beside a conversion of this step: its drop is no loss of the conversion
    if (std::binary_search(jt.newborn.begin(), jt.newborn.end(), d)) ledger.conv_strain -= drop;
  });
  return release;
}

/// What this DE's corners let go, for the joints that leave them in the next step.
void JointStates::share_out_release(int d, unsigned leaving)
{
  bool any = false;
  for (int s = 0; s < 6; ++s) any = any || ((leaving & 1u << s) && by_crack(d, s));
  if (!any) return;
  double share[6];
  cracks_->release(d, leaving, share);
  for (int s = 0; s < 6; ++s)
    if ((leaving & 1u << s) && by_crack(d, s)) jt.soft_joint(6 * d + s).stored = share[s];
}

/// First that all ranks know of the joints, then what both ends let go.
void JointStates::begin_cracks()
{
  cracks_->cut_pending();
  std::array<double, 6> share{};
  for (std::size_t k = 0; k < jt.pending.size(); ++k) {    // they are sorted
    const int d = jt.pending[k] / 6, s = jt.pending[k] % 6;
    if (by_crack(d, s)) share[s] = jt.soft_joint(6 * d + s).stored;
    if (k + 1 < jt.pending.size() && jt.pending[k + 1] / 6 == d) continue;
    cracks_->set_shares(d, share);
    share.fill(0.0);
  }
}

void JointStates::switch_pending()
{
  if (!moving) return;
  ledger.release += release_of_pending();
  if (cracks_) begin_cracks();
  for (int ds : jt.pending) switch_joint(ds);
  jt.pending.clear();
}

void JointStates::switch_joint(int ds)
{
  const int d = ds / 6, s = ds % 6;
  JointRecord &slot = jt.record(d, s);
  slot.state = joint::COHESIVE;
  slot.pending = 0;
  jt.state[ds] = joint::COHESIVE;
  jt.present[d] = static_cast<unsigned char>(jt.present[d] & ~(1u << s));
  const bool tie = slot.kind == joint::TIE;
  if (!tie && !at_lower_id(d, s)) return;
  slot.pending = 2;    // its energy is booked with its first force
  SoftJoint &soft = jt.soft_joint(ds);
  soft.stored = soft.lost = 0.0;
  jt.cohesive.push_back(ds);
  if (!tie) damaged_ = true;
  if (!tie && by_crack(d, s)) {    // its strength is not known yet
    taking_over.push_back(ds);
    return;
  }
  if (!tie && cracks_) cracks_->cut(ds);
  event(d, s, tie ? EventKind::ADHESIVE : EventKind::COHESIVE,
        CohesiveState::unpack(soft.cohesive).s0);
}

// --- to the end -------------------------------------------------------------

/// A joint breaks; its other end too if it is here, else its owner learns it from ours.
void JointStates::set_broken(int d, int s)
{
  for (int ds : {6 * d + s, jt.partner[d][s]}) {
    if (ds < 0 || ds >= 6 * jt.nde) continue;
    jt.record(ds).state = joint::CONTACT;
    jt.state[ds] = joint::CONTACT;
  }
  if (cracks_ && jt.partner[d][s] >= 0) cracks_->part(6 * d + s);
  broken_.push_back({jt.self[d], jt.nb[d][s], 0.0});
}

/// A joint is broken, but the plane of its crack takes pressure as long as it is closed or nearly so.
void JointStates::close_plane(int d, int s)
{
  for (int ds : {6 * d + s, jt.partner[d][s]}) {
    if (ds < 0 || ds >= 6 * jt.nde) continue;
    jt.record(ds).state = joint::CONTACT;
    jt.record(ds).plane = 1;
    jt.state[ds] = joint::PLANE;
  }
}

/// From now on the two are spheres for each other. Each rank finds the distance at which they begin to touch from
/// the positions of this step.
void JointStates::leave_plane(int d, int s)
{
  cracks_->forget(6 * d + s);
  cracks_->part(6 * d + s);
  const int other = jt.partner[d][s];
  adopt_state(6 * d + s, joint::CONTACT);
  if (other >= 0 && other < 6 * jt.nde) {
    jt.record(other).plane = 0;
    set_contact_distance(other, jt.records[d]->contact_distance(s));
    jt.state[other] = joint::CONTACT;
  }
}

/// State of a joint of this rank, as that of its lower end has it.
void JointStates::adopt_state(int ds, int state)
{
  const int d = ds / 6, s = ds % 6;
  JointRecord &slot = jt.record(d, s);
  if ((state & PENDING) && slot.pending != 1) make_pending(ds);
  state &= ~PENDING;
  if (state == jt.state[ds]) return;
  const bool was_plane = jt.state[ds] == joint::PLANE;
  jt.state[ds] = static_cast<unsigned char>(state);
  slot.plane = state == joint::PLANE;
  slot.state = static_cast<signed char>(slot.plane ? joint::CONTACT : state);
  if (state != joint::CONTACT) return;
  const int i = jt.self[d], j = jt.nb[d][s];
  // at the distance itself, rounding would decide on each number of ranks anew whether they are in contact
  if (was_plane)
    set_contact_distance(ds,
                         (1.0 - 1.0e-9) * (particles.position(j) - particles.position(i)).norm());
  broken_.push_back({i, j, jt.records[d]->contact_distance(s)});
}

void JointStates::set_contact_distance(int ds, double distance)
{
  auto &list = jt.contact_distances;
  jt.soft_joint(ds).contact_distance = distance;
  const int other = jt.nb[ds / 6][ds % 6];
  const auto behind =
      std::find_if(list.begin(), list.end(), [ds](const JointTable::ContactDistance &a) {
        return a.de > ds / 6;
      });
  list.insert(behind, {ds / 6, particles.id[other], distance});
}

void JointStates::event(int d, int s, EventKind what, double value)
{
  JointEvent e{6 * d + s, what, value, false, {0.0, 0.0, 0.0}, 0.5};
  if (by_crack(d, s))
    if (const JointCrack *crack = cracks_->find(6 * d + s)) {
      e.has_plane = true;
      std::copy_n(crack->law.m, 3, e.m);
      e.f = crack->law.f;
    }
  events_.push_back(e);
}

// --- messages ---------------------------------------------------------------

void JointStates::adopt_states()
{
  for (int ds : decided_elsewhere) adopt_state(ds, jt.state[jt.partner[ds / 6][ds % 6]]);
  if (!cracks_) return;
  cracks_->end_of_step();
  wake_beside_cuts();
  for_leaving([this](int d, unsigned leaving) {
    share_out_release(d, leaving);
  });
}

int JointStates::pack_states(int d, double *buf) const
{
  int bits = 0, m = 1;
  const unsigned pending = d < jt.nde ? pending_of[d] : 0u;
  for (int s = 0; s < 6; ++s) {
    int state = jt.state[6 * d + s];
    if (pending >> s & 1u) state |= PENDING;
    if (cracks_ && (state & PENDING) && cracks_->pack_memory(6 * d + s, &buf[m])) {
      state = PENDING_WITH_PLANE;
      m += JointCracks::MEMORY_SIZE;
    }
    bits |= state << (3 * s);
  }
  buf[0] = bits;
  return m;
}

int JointStates::unpack_states(int d, const double *buf)
{
  const int bits = static_cast<int>(buf[0]);
  int m = 1;
  for (int s = 0; s < 6; ++s) {
    int state = (bits >> (3 * s)) & 7;
    if (state == PENDING_WITH_PLANE) {
      cracks_->unpack_memory(6 * d + s, &buf[m]);
      m += JointCracks::MEMORY_SIZE;
      state = PENDING;
    }
    const bool changed = jt.state[6 * d + s] != state;
    jt.state[6 * d + s] = static_cast<unsigned char>(state);
    if (!cracks_ || !changed || cracks_->other_end(6 * d + s) < 0) continue;
    if (state == joint::CONTACT) cracks_->part(6 * d + s);
    if (state == joint::COHESIVE && both_laws) cracks_->cut(6 * d + s);
  }
  return m;
}

double JointStates::memory_usage() const
{
  return static_cast<double>(least_threshold.capacity()) * sizeof(double) +
      (cracks_ ? cracks_->memory_usage() : 0.0);
}

}    // namespace defe
