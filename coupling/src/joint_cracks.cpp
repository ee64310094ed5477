#include "defe/coupling/joint_cracks.h"

#include "prefetch_vector.h"

#include "defe/coupling/prefetch.h"

#include <algorithm>
#include <cmath>
#include <cstring>

namespace defe {

namespace {

  // the first number of a DE's table: six bits per slot, then one of each that is outer, one of each that is a tie, and
  // two of each that say how the element behind is turned
  constexpr int SLOT_BITS = 6, OUTER_BITS = 6 * SLOT_BITS, TIE_BITS = OUTER_BITS + 6,
                TURN_BITS = TIE_BITS + 6;
  enum : int64_t { JOINED = 1, CUT = 2, REMEMBERED = 4 };

  double as_double(std::int64_t bits)
  {
    double d;
    std::memcpy(&d, &bits, sizeof(d));
    return d;
  }

  std::int64_t as_integer(double d)
  {
    std::int64_t bits;
    std::memcpy(&bits, &d, sizeof(bits));
    return bits;
  }

  void pack(const CrackMemory &memory, double *buf)
  {
    for (int k = 0; k < 3; ++k) buf[k] = memory.m[k];
    buf[3] = memory.f;
  }

  CrackMemory unpack(const double *buf)
  {
    return {{buf[0], buf[1], buf[2]}, buf[3]};
  }

  CrackMemory memory_of(const CrackJoint &law)
  {
    return {{law.m[0], law.m[1], law.m[2]}, law.f};
  }

}    // namespace

JointCracks::JointCracks(JointTable &table, const MovingParticles &p, CrackHost &h) :
    jt(table), particles(p), host(h)
{
}

void JointCracks::set_strengths(int n, std::vector<double> strength,
                                std::vector<CrackNuclei> of_nuclei,
                                const std::vector<CornerModuli> &of_parts)
{
  sigma_t = std::move(strength);
  nuclei = std::move(of_nuclei);
  moduli = of_parts;
  least_strength = *std::min_element(sigma_t.begin(), sigma_t.end());
  types = std::isfinite(least_strength) ? n : 0;
}

CrackLattice JointCracks::lattice() const
{
  return {jt.nde,
          jt.nall,
          id.data(),
          reinterpret_cast<const double(*)[3]>(X.data()),
          reinterpret_cast<const int(*)[6]>(partner.data()),
          outer.data(),
          state.data(),
          ties.data(),
          turned.data(),
          key.data()};
}

// new tables: this rank's part

void JointCracks::prepare()
{
  const int n = jt.nde, nall = jt.nall;
  id.resize(nall);
  X.resize(nall);
  type.resize(nall);
  for (int d = 0; d < nall; ++d) {
    const int i = jt.self[d];
    id[d] = particles.id[i];
    type[d] = static_cast<unsigned char>(particles.type[i]);
    for (int k = 0; k < 3; ++k) X[d][k] = particles.reference(i)[k];
  }
  partner.assign(nall, {-1, -1, -1, -1, -1, -1});
  of_ghost.assign(nall - n, {});
  outer.assign(nall, 0);
  turned.assign(nall, 0);
  ties.assign(nall, 0);
  state.assign(6 * static_cast<size_t>(nall), CrackLattice::INTACT);
  quiet.assign(nall, HUGE_VAL);
  key.assign(nall, 0);
  least_volume.clear();
  cuts.clear();
  constexpr int ahead = 3;
  for (int d = 0; d < n; ++d) {
    if (d + ahead < n) host.expect(d + ahead);
    const CrackDE r = host.describe(d);
    outer[d] = static_cast<unsigned char>(r.outer);
    turned[d] = r.turned;
    key[d] = crack_place_key(r.place, std::cbrt(r.volume));
    const double least = d < jt.orthogonal ? 0.5 * r.volume
                                           : crack_least_volume(jt.cell[d - jt.orthogonal]);
    quiet[d] =
        crack_quiet_energy(least, moduli[r.part], least_strength_at(d), CrackGrowth::quiet_share);
    if (!jt.strength.empty()) least_volume.push_back(least);
    const auto *const cracked = host.find_cracks(d);
    for (int s = 0; s < 6; ++s) {
      const JointRecord &slot = jt.record(d, s);
      if (slot.kind == joint::TIE && slot.state == joint::CONNECTIVE && slot.part == r.part)
        ties[d] = static_cast<unsigned char>(ties[d] | 1u << s);
      if (slot.kind != joint::DE || jt.partner[d][s] < 0) continue;
      partner[d][s] = jt.partner[d][s];
      if (jt.state[6 * d + s] != joint::CONNECTIVE) state[6 * d + s] = CrackLattice::SOFTENING;
      if (!cracked) continue;
      for (const JointCrack &c : *cracked)
        if (c.slot == s) cuts.push_back({6 * d + s, memory_of(c.law)});
    }
  }
}

/// At which something starts at one of its joints.
double JointCracks::least_strength_at(int d) const
{
  double least = least_strength;
  for (int s = 0; s < 6 && !jt.strength.empty(); ++s)
    if (jt.partner[d][s] >= 0)
      least = std::min(least, jt.flaws_between(d, jt.partner[d][s] / 6, least));
  return least;
}

/// While tables are made.
JointCracks::FarEnd JointCracks::far_end(int d, int s) const
{
  if (d >= jt.nde) return of_ghost[d - jt.nde][s];
  const int there = partner[d][s];
  return there < 0 ? FarEnd{} : FarEnd{id[there / 6], there % 6};
}

int JointCracks::pack_table(int d, double *buf) const
{
  int64_t bits = static_cast<int64_t>(outer[d]) << OUTER_BITS |
      static_cast<int64_t>(ties[d]) << TIE_BITS | static_cast<int64_t>(turned[d]) << TURN_BITS;
  int m = 3;
  buf[1] = quiet[d];
  memcpy(&buf[2], &key[d], sizeof(double));
  auto cut = std::lower_bound(cuts.begin(), cuts.end(), 6 * d, [](const Cut &c, int joint) {
    return c.joint < joint;
  });
  for (int s = 0; s < 6; ++s) {
    const auto [there, its_slot] = far_end(d, s);
    if (!there) continue;
    int64_t b = JOINED | static_cast<int64_t>(its_slot) << 3;
    if (state[6 * d + s]) b |= CUT;
    buf[m++] = as_double(there);
    while (cut != cuts.end() && cut->joint < 6 * d + s) ++cut;
    if (cut != cuts.end() && cut->joint == 6 * d + s) {
      b |= REMEMBERED;
      pack(cut->memory, &buf[m]);
      m += 4;
    }
    bits |= b << (SLOT_BITS * s);
  }
  buf[0] = as_double(bits);
  return m;
}

int JointCracks::unpack_table(int d, const double *buf)
{
  const auto bits = as_integer(buf[0]);
  outer[d] = static_cast<unsigned char>(bits >> OUTER_BITS & 63);
  turned[d] = static_cast<std::uint16_t>(bits >> TURN_BITS & 4095);
  ties[d] = static_cast<unsigned char>(bits >> TIE_BITS & 63);
  quiet[d] = buf[1];
  memcpy(&key[d], &buf[2], sizeof(double));
  int m = 3;
  for (int s = 0; s < 6; ++s) {
    const int64_t b = bits >> (SLOT_BITS * s) & ((1 << SLOT_BITS) - 1);
    if (!(b & JOINED)) continue;
    of_ghost[d - jt.nde][s] = {as_integer(buf[m++]), static_cast<int>(b >> 3 & 7)};
    if (b & CUT) state[6 * d + s] = CrackLattice::SOFTENING;
    if (b & REMEMBERED) {
      // messages of several ranks come in any order
      const auto place =
          std::upper_bound(cuts.begin(), cuts.end(), 6 * d + s, [](int joint, const Cut &c) {
            return joint < c.joint;
          });
      cuts.insert(place, {6 * d + s, unpack(&buf[m])});
      m += 4;
    }
  }
  return m;
}

// the other ends of the joints of ghosts, as far as this rank has them. The nearest image of an ID may be that of another
// side of a periodic box: joints are shorter than half of it.

void JointCracks::find_partners_of_ghosts()
{
  const Vec3 half_period = host.half_periods();
  for (int d = jt.nde; d < jt.nall; ++d)
    for (int s = 0; s < 6; ++s) {
      const auto [there, t] = far_end(d, s);
      if (there <= 0) continue;
      const int j = host.nearest(d, there);
      const int e = j < 0 ? -1 : jt.of_atom[j];
      if (e < 0) continue;
      bool near = true;
      for (int k = 0; k < 3; ++k) near = near && !(std::abs(X[e][k] - X[d][k]) > half_period[k]);
      if (near && far_end(e, t).id == id[d]) partner[d][s] = 6 * e + t;
    }
}

void JointCracks::resolve()
{
  find_partners_of_ghosts();

  // the lower end knows first

  for (int ds = 0; ds < 6 * jt.nall; ++ds) {
    const int there = partner[ds / 6][ds % 6];
    if (there >= 0 && id[ds / 6] < id[there / 6]) state[there] = state[ds];
  }
  growth.reset(lattice());
  moved_.clear();
  poorer_.clear();
  coming.clear();
  parting.clear();
  cutting.clear();
  shares.clear();
  for (const auto &[joint, memory] : cuts) {
    if (other_end(joint) < 0) continue;
    if (state[joint])
      growth.add_known_crack(lattice(), joint, memory);
    else
      coming.push_back({joint, memory});
  }
  cuts.clear();
}

void JointCracks::cut_pending()
{
  for (const Cut &c : coming) {
    const int there = other_end(c.joint);
    state[c.joint] = state[there] = CrackLattice::SOFTENING;
    poorer_.insert(poorer_.end(), {c.joint / 6, there / 6});
    growth.add_crack(lattice(), c.joint, c.memory);
  }
  coming.clear();
  memories.clear();
}

// energies are not negative, except by rounding: the sign says whether shares follow

int JointCracks::pack_energy(int d, double *buf) const
{
  const auto share = shares.find(d);
  buf[0] = std::copysign(jt.energy[d], share == shares.end() ? 1.0 : -1.0);
  if (share == shares.end()) return 1;
  for (int s = 0; s < 6; ++s) buf[1 + s] = share->second[s];
  return ENERGY_SIZE;
}

int JointCracks::unpack_energy(int d, const double *buf)
{
  jt.energy[d] = std::abs(buf[0]);
  if (!std::signbit(buf[0])) return 1;
  auto &share = shares[d];
  for (int s = 0; s < 6; ++s) share[s] = buf[1 + s];
  return ENERGY_SIZE;
}

double JointCracks::budget(int joint) const
{
  double sum = 0.0;
  for (int end : {joint, other_end(joint)}) {
    const auto share = shares.find(end / 6);
    if (share != shares.end()) sum += share->second[end % 6];
  }
  return sum;
}

double JointCracks::take_over(int joint, const CohesiveParameters &par)
{
  JointCrack &c = *find(joint);
  crack_take_over(c.law, geometry(joint), budget(joint), moduli[jt.material[joint / 6]], par);
  return c.law.s0;
}

CrackEnd JointCracks::end(int d, End &store) const
{
  const CrackLattice l = lattice();
  unsigned present = 0;
  const Vec3 xd = particles.position(jt.self[d]);
  for (int s = 0; s < 6; ++s) {
    store.dX[s].setZero();
    store.y[s].setZero();
    if (partner[d][s] < 0) continue;
    store.dX[s] = l.vector(6 * d + s);
    store.y[s] = particles.position(jt.self[partner[d][s] / 6]) - xd;
    if (!state[6 * d + s]) present |= 1u << s;
  }
  return {store.dX, store.y, present};
}

// What several joints need to know of a DE in one evaluation.

void JointCracks::know(const std::vector<int> &joints)
{
  known_place.resize(jt.nall, -1);
  for (int d : known_des)
    if (d < jt.nall) known_place[d] = -1;
  known_des.clear();
  for (int joint : joints)
    for (int d : {joint / 6, other_end(joint) / 6}) {
      if (known_place[d] >= 0) continue;
      known_place[d] = static_cast<int>(known_des.size());
      known_des.push_back(d);
    }
  const size_t n = known_des.size();
  known_vectors.resize(std::max(n, known_vectors.size()));
  known_turns.resize(std::max(n, known_turns.size()));
  known_turning.assign(n, -1.0);
  known_ends.clear();
  constexpr size_t ahead = 4;
  for (size_t k = 0; k < n; ++k) {
    if (k + 2 * ahead < n) prefetch(&partner[known_des[k + 2 * ahead]]);
    if (k + ahead < n) {
      const int next = known_des[k + ahead];
      prefetch_vector(particles.at(jt.self[next]));
      prefetch_vector(particles.omega + 3 * static_cast<std::ptrdiff_t>(jt.self[next]));
      for (int there : partner[next])
        if (there >= 0) {
          prefetch_vector(X[there / 6].data());
          prefetch_vector(particles.at(jt.self[there / 6]));
        }
    }
    known_ends.push_back(end(known_des[k], known_vectors[k]));
  }
  de_rotations(static_cast<int>(n), known_ends.data(), known_turns.data());
  for (size_t k = 0; k < n; ++k) known_ends[k].turn = &known_turns[k];
  know_with_cut(joints);
}

/// Of DEs that are poor in joints also the rotation by these and the cut one.
void JointCracks::know_with_cut(const std::vector<int> &joints)
{
  poor_ends.clear();
  poor_joints.clear();
  for (int joint : joints)
    for (int here : {joint, other_end(joint)}) {
      const CrackEnd &end = known_end(here / 6);
      if (!crack_joint_has_a_say(*end.turn, end.present)) continue;
      poor_ends.push_back({end.dX, end.y, end.present | 1u << here % 6});
      poor_joints.push_back(here);
    }
  const size_t n = poor_ends.size();
  poor_turns.resize(std::max(n, poor_turns.size()));
  de_rotations(static_cast<int>(n), poor_ends.data(), poor_turns.data());
  for (size_t k = 0; k < n; ++k)
    known_ends[known_place[poor_joints[k] / 6]].with[poor_joints[k] % 6] = &poor_turns[k];
}

CrackGeometry JointCracks::geometry(int joint) const
{
  const JointRecord &slot = jt.record(joint);
  return {
      lattice().vector(joint), slot.area * Vec3(slot.normal), {joint % 6, other_end(joint) % 6}};
}

namespace {

  CrackForces open_plane()
  {
    CrackForces out;
    out.force = out.torque = out.at[0] = out.at[1] = Vec3::Zero();
    for (auto &arms : out.arm)
      for (Vec3 &f : arms) f.setZero();
    out.dissipated = out.fracture = out.excess = out.work_new = out.rubbed = 0.0;
    out.damage = 1.0;
    out.newly_broken = out.separated = false;
    return out;
  }

}    // namespace

CrackForces JointCracks::look(int joint, const CohesiveParameters &par, CrackJoint &law) const
{
  End near, far;
  const int there = other_end(joint);
  return crack_update(law, geometry(joint), end(joint / 6, near), end(there / 6, far),
                      particles.position(jt.self[there / 6]) -
                          particles.position(jt.self[joint / 6]),
                      Vec3::Zero(), moduli[jt.material[joint / 6]], par);
}

bool JointCracks::rests(int joint, JointCrack *crack, signed char &plane, double dt) const
{
  // before a run, what rested in the last step still does

  if (std::abs(plane) <= (dt > 0.0 ? 2 : 1)) return false;
  if (!(dt > 0.0)) return true;
  if (plane < 0) {
    plane++;
    crack_turn(crack->law, spin_of(joint, dt));
  } else
    plane--;
  return true;
}

/// Mean rotation of the spins of a joint's DEs in a step.
Vec3 JointCracks::spin_of(int joint, double dt) const
{
  return 0.5 * dt *
      (particles.spin(jt.self[joint / 6]) + particles.spin(jt.self[other_end(joint) / 6]));
}

CrackForces JointCracks::advance(int joint, CrackJoint &law, const CohesiveParameters &par,
                                 double friction, double dt)
{
  const CrackEnd &near = known_end(joint / 6), &far = known_end(other_end(joint) / 6);
  const int s = joint % 6;
  const Vec3 y = near.y[s];

  // far apart, whatever the rotation

  const JointRecord &slot = jt.record(joint);
  const CrackGeometry g = {near.dX[s], slot.area * Vec3(slot.normal), {s, other_end(joint) % 6}};
  if (law.broken && y.norm() > 1.2 * g.d.norm()) {
    CrackForces out = open_plane();
    out.excess = law.stored;
    out.separated = true;
    law.stored = 0.0;
    return out;
  }
  return crack_update(law, g, near, far, y, spin_of(joint, dt), moduli[jt.material[joint / 6]], par,
                      friction);
}

const std::vector<char> &JointCracks::advance_open(const std::vector<Broken> &joints, double dt)
{
  constexpr size_t ahead = 8, lot = 64;
  const size_t n = joints.size();
  was_open.resize(n);
  BrokenPlane planes[lot];
  bool open[lot];
  for (size_t first = 0; first < n; first += lot) {
    const size_t here = std::min(lot, n - first);
    for (size_t k = 0; k < here; ++k) {
      if (first + k + ahead < n) prefetch(joints[first + k + ahead].law);
      const auto [joint, law] = joints[first + k];
      const int there = other_end(joint);
      planes[k] = {law,
                   &known_end(joint / 6),
                   &known_end(there / 6),
                   {joint % 6, there % 6},
                   spin_of(joint, dt)};
    }
    crack_update_open(static_cast<int>(here), planes, open);
    for (size_t k = 0; k < here; ++k) was_open[first + k] = open[k];
  }
  return was_open;
}

// A broken joint whose plane is open is not computed until it may have closed: nothing around it is expected to
// move more than four times as fast as now, relative to each other.

signed char JointCracks::resting(int joint, const CrackJoint &law, double dt)
{
  constexpr int longest = 20;
  const double gap = Vec3(law.e).dot(Vec3(law.m));
  if (!(gap > 0.0) || !(dt > 0.0)) return 1;
  const int near = joint / 6, there = other_end(joint);
  const double length = known_end(near).dX[joint % 6].norm();
  const double apart =
      (particles.velocity(jt.self[there / 6]) - particles.velocity(jt.self[near])).norm();
  double turning = 0.0;
  bool held = false;
  const int ends[2] = {joint, there};
  for (int k = 0; k < 2; ++k) {
    if (!crack_frame_from(law, k)) continue;
    held = true;
    turning = std::max(turning, turning_of(ends[k] / 6));
    if (law.used[k] >> ends[k] % 6 & 1)    // the joint itself has a say
      turning = std::max(turning, apart / length);
  }
  if (!held) turning = spin_of(joint, 1.0).norm();
  const double closing = apart + 2.0 * turning * length;
  const double steps = std::min(static_cast<double>(longest), 0.25 * gap / (closing * dt));
  const int rest = steps >= 1.0 ? static_cast<int>(2.0 + steps) : 1;
  return static_cast<signed char>(held ? rest : -rest);
}

void JointCracks::expect_resting(int joint) const
{
  for (int d : {joint / 6, other_end(joint) / 6}) {
    if (known_turning[known_place[d]] >= 0.0) continue;
    for (int there : partner[d])
      if (there >= 0)
        prefetch_vector(particles.v + 3 * static_cast<std::ptrdiff_t>(jt.self[there / 6]));
  }
}

/// Most by which the joints that a DE's rotation is taken from turn, per time. Several planes ask for it.
double JointCracks::turning_of(int d)
{
  double &most = known_turning[known_place[d]];
  if (most >= 0.0) return most;
  most = 0.0;
  const Vec3 v = particles.velocity(jt.self[d]);
  const CrackEnd &end = known_end(d);
  for (int s = 0; s < 6; ++s) {
    if (!(end.present >> s & 1u)) continue;
    const Vec3 by = particles.velocity(jt.self[partner[d][s] / 6]) - v;
    most = std::max(most, by.norm() / end.dX[s].norm());
  }
  return most;
}

void JointCracks::arms(int d, Vec3 y[6]) const
{
  const Vec3 xd = particles.position(jt.self[d]);
  for (int s = 0; s < 6; ++s) {
    const int nb = jt.nb[d][s];
    y[s] = Vec3(nb >= 0 ? particles.at(nb) : &jt.tie_point[3 * ~nb]) - xd;
  }
}

GeneralCell JointCracks::cell(int d) const
{
  if (d >= jt.orthogonal) return jt.cell[d - jt.orthogonal];
  GeneralCell c;
  c.tie = 0;
  c.free = jt.free[d];
  for (int s = 0; s < 6; ++s) {
    const int nb = jt.nb[d][s];
    c.face[s] = Vec3(jt.record(d, s).face);
    c.dX[s].setZero();
    if (nb < 0) {
      c.dX[s] = c.face[s];
      c.tie = static_cast<unsigned char>(c.tie | 1u << s);
    } else if (nb != jt.self[d])
      c.dX[s] = Vec3(particles.reference(nb)) - Vec3(X[d].data());
  }
  return jt.stress_free.empty() ? c : stress_free_cell(c, jt.stress_free[d]);
}

// unit vectors of the axes of an orthogonal cell: from its neighbours, whose positions are near in memory

Mat3 JointCracks::axes(int d) const
{
  Mat3 A;
  for (int a = 0; a < 3; ++a) {
    const int s = partner[d][2 * a + 1] >= 0 ? 2 * a + 1 : 2 * a;
    const double sign = s % 2 ? 1.0 : -1.0;
    A.col(a) = partner[d][s] >= 0 ? Vec3(sign / jt.len[d][s] * lattice().vector(6 * d + s))
                                  : Vec3(sign / jt.half[d][s] * Vec3(jt.record(d, s).face));
  }
  if (!jt.stress_free.empty())
    A.colwise().normalize();    // len and half are not those of the vectors
  return A;
}

double JointCracks::release(int d, unsigned leaving, double share[6]) const
{
  Vec3 y[6];
  arms(d, y);
  return crack_release(cell(d), y, jt.present[d], leaving, moduli[jt.material[d]], share);
}

// decisions

void JointCracks::fill(CrackBox &box, int d) const
{
  box.axes = axes(d);
  std::copy_n(jt.len[d].data(), 6, box.length);
  std::copy_n(jt.half[d].data(), 6, box.half);
  arms(d, box.y);
  box.present = jt.present[d];
  box.free = jt.free[d];
  box.moduli = moduli[jt.material[d]];
}

void JointCracks::mark()
{
  foreign.clear();
  boxes.clear();
  boxed.clear();
  for (int d : growth.mark(lattice(), jt.energy.data(), quiet.data())) {
    if (d < jt.orthogonal) {
      fill(boxes.emplace_back(), d);
      boxed.push_back(d);
    } else if (d < jt.nde) {
      Vec3 y[6];
      arms(d, y);
      growth.stress(d) = crack_stress(cell(d), y, jt.present[d], moduli[jt.material[d]]);
    } else
      growth.stress(d) = CrackStress{};
  }
  const int n = static_cast<int>(boxes.size());
  box_stress.resize(n);
  crack_stress_orthogonal(n, boxes.data(), box_stress.data());
  for (int k = 0; k < n; ++k) growth.stress(boxed[k]) = box_stress[k];
}

int JointCracks::pack_stress(int n, const int *list, double *buf) const
{
  int m = 1;
  for (int k = 0; k < n; ++k) {
    const int d = jt.of_atom[list[k]];
    if (d < 0) continue;
    const CrackStress *s = nullptr;
    if (d < jt.nde) {
      if (growth.marked(d)) s = &growth.stress(d);
    } else {    // on its way to a third rank
      const auto found = foreign.find(d);
      if (found != foreign.end()) s = &found->second;
    }
    if (!s) continue;
    buf[m++] = k;
    memcpy(&buf[m], s, sizeof(CrackStress));
    m += CrackStress::size;
  }
  buf[0] = m;
  return m;
}

void JointCracks::unpack_stress(int first, const double *buf)
{
  const int size = static_cast<int>(buf[0]);
  for (int m = 1; m < size; m += 1 + CrackStress::size) {
    const int d = jt.of_atom[first + static_cast<int>(buf[m])];
    memcpy(&foreign[d], &buf[m + 1], sizeof(CrackStress));
    if (growth.marked(d)) growth.stress(d) = foreign[d];
  }
}

void JointCracks::decide()
{
  started.clear();
  const CrackLattice l = lattice();
  growth.decide(l,
                {type.data(), types, sigma_t.data(), nuclei.data(),
                 jt.strength.empty() ? nullptr : jt.strength.data()},
                CrackGrowthParameters(), decisions);
  for (const auto &start : decisions) {
    const int joint = start.joint, there = other_end(joint);
    End near, far;
    JointCrack crack;
    memset(static_cast<void *>(&crack), 0, sizeof(crack));
    crack.slot = joint % 6;
    if (!crack_start(crack.law, Vec3(start.memory.m), start.memory.f, geometry(joint),
                     Vec3(jt.half_force_of(joint)) - Vec3(jt.half_force_of(there)),
                     end(joint / 6, near), end(there / 6, far),
                     particles.position(jt.self[there / 6]) -
                         particles.position(jt.self[joint / 6])))
      continue;
    forget(joint);
    host.cracks_of(joint / 6).push_back(crack);
    moved_.push_back(joint / 6);
    started.push_back(joint);
    remember(joint, start.memory);
  }
}

void JointCracks::remember(int joint, const CrackMemory &memory)
{
  memories[joint] = memory;
  if (other_end(joint) >= 0) coming.push_back({joint, memory});
}

void JointCracks::keep_pending(int joint)
{
  remember(joint, memory_of(find(joint)->law));
}

void JointCracks::forget_pending()
{
  coming.clear();
  memories.clear();
}

bool JointCracks::pack_memory(int joint, double *buf) const
{
  const auto found = memories.find(joint);
  if (found == memories.end()) return false;
  pack(found->second, buf);
  return true;
}

void JointCracks::unpack_memory(int joint, const double *buf)
{
  remember(joint, unpack(buf));
}

void JointCracks::end_of_step()
{
  for (int joint : cutting) {
    const int there = other_end(joint);
    if (there < 0) continue;
    state[joint] = state[there] = CrackLattice::SOFTENING;
    poorer_.insert(poorer_.end(), {joint / 6, there / 6});
    growth.joint_changes(lattice(), joint);
  }
  cutting.clear();
  for (int joint : parting) {
    const int there = other_end(joint);
    if (there < 0) continue;
    growth.remove_crack(lattice(), joint);
    for (int end : {joint, there}) partner[end / 6][end % 6] = -1;
  }
  parting.clear();
}

JointCrack *JointCracks::find(int joint) const
{
  if (auto *list = host.find_cracks(joint / 6))
    for (auto &c : *list)
      if (c.slot == joint % 6) return &c;
  return nullptr;
}

void JointCracks::forget(int joint)
{
  auto *list = host.find_cracks(joint / 6);
  if (!list) return;
  moved_.push_back(joint / 6);
  list->erase(std::remove_if(list->begin(), list->end(),
                             [joint](const JointCrack &c) {
                               return c.slot == joint % 6;
                             }),
              list->end());
}

double JointCracks::memory_usage() const
{
  return static_cast<double>(id.capacity()) *
      (sizeof(id[0]) + sizeof(X[0]) + sizeof(partner[0]) + sizeof(quiet[0]) + sizeof(key[0]) +
       12.0);
}

}    // namespace defe
