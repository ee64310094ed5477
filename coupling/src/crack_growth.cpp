#include "defe/coupling/crack_growth.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <stdexcept>

namespace defe {

namespace {

  using Ids = CrackGrowth::Ids;

  Ids ids(const CrackLattice &lattice, int lower_end)
  {
    return {lattice.id[lower_end / 6], lattice.id[lattice.other_end(lower_end) / 6]};
  }

  Vec3 centre(const CrackLattice &lattice, int joint)
  {
    return Vec3(lattice.X[joint / 6]) + 0.5 * lattice.vector(joint);
  }

  /// Random bits of a joint: its place, or those of its two DEs.
  std::uint64_t joint_key(const CrackLattice &lattice, int joint)
  {
    if (!lattice.key) return crack_place_key(centre(lattice, joint), lattice.vector(joint).norm());
    const std::uint64_t a = lattice.key[joint / 6], b = lattice.key[lattice.other_end(joint) / 6];
    std::uint64_t h = (a ^ b) * 0xbf58476d1ce4e5b9ull + a + b;    // either end may be the lower one
    h = (h ^ (h >> 27)) * 0x94d049bb133111ebull;
    return h ^ (h >> 31);
  }

  /// The share of 21 of the bits in [0, 1).
  double uniform(std::uint64_t hash, int which)
  {
    return static_cast<double>(hash >> (21 * which) & 0x1fffff) / 0x200000;
  }

  Vec3 random_direction(std::uint64_t hash)
  {
    const double z = 2.0 * uniform(hash, 1) - 1.0, angle = 2.0 * M_PI * uniform(hash, 2);
    const double r = std::sqrt(1.0 - z * z);
    return Vec3(r * std::cos(angle), r * std::sin(angle), z);
  }

  /// Whether no axis of either DE is closer to m than this joint; ties count as best.
  bool best_aligned(const CrackLattice &lattice, int joint, const Vec3 &m)
  {
    const double own = std::abs(lattice.vector(joint).normalized().dot(m));
    for (int end : {joint, lattice.other_end(joint)})
      for (int s = 0; s < 6; ++s) {
        if (s / 2 == end % 6 / 2 || lattice.partner[end / 6][s] < 0) continue;
        if (std::abs(lattice.vector(6 * (end / 6) + s).normalized().dot(m)) > own + 1e-6)
          return false;
      }
    return true;
  }

  /// Call f(joint) for all joints of the DEs of a joint and of their neighbours, by their lower ends; some twice.
  /// Stops when f returns false.
  template <class F> bool all_around(const CrackLattice &lattice, int joint, F f)
  {
    const auto joints_of = [&](int de) {
      for (int s = 0; s < 6; ++s)
        if (lattice.partner[de][s] >= 0 && !f(lattice.lower_end(6 * de + s))) return false;
      return true;
    };
    for (int end : {joint, lattice.other_end(joint)}) {
      if (!joints_of(end / 6)) return false;
      for (int s = 0; s < 6; ++s) {
        const int next = lattice.partner[end / 6][s];
        if (next >= 0 && next != joint && next != lattice.other_end(joint) && !joints_of(next / 6))
          return false;
      }
    }
    return true;
  }

  CrackStart make_start(const CrackLattice &lattice, int joint, const Vec3 &m, double f,
                        CrackStart::Origin origin)
  {
    const double sign = lattice.vector(joint).dot(m) < 0.0 ? -1.0 : 1.0;
    return {joint, {{sign * m[0], sign * m[1], sign * m[2]}, std::clamp(f, 0.05, 0.95)}, origin};
  }

  /// Where the DE behind a tie will be, if the element there is as long as the DE's own was.
  /// \return false: the DE has broken off its own
  bool behind_tie(const CrackLattice &lattice, int tie, Vec3 &place)
  {
    const int inner = tie ^ 1;    // slots of an axis are 2 k and 2 k + 1
    if (lattice.partner[inner / 6][inner % 6] < 0) return false;
    place = Vec3(lattice.X[tie / 6]) - lattice.vector(inner);
    return true;
  }

  bool is_tie(const CrackLattice &lattice, int end)
  {
    return (lattice.ties[end / 6] >> end % 6 & 1u) != 0;
  }

}    // namespace

// --- cracks -----------------------------------------------------------------

void CrackGrowth::Cracks::reset(std::size_t joints)
{
  of.assign(joints, nullptr);
  taken = count = 0;
}

CrackGrowth::Crack &CrackGrowth::Cracks::operator[](int joint)
{
  if (of[joint]) return *of[joint];
  if (taken == all.size()) all.emplace_back();
  Crack &crack = all[taken++];
  crack.stale = crack.wide = false;
  crack.odd.clear();
  crack.before_ties.clear();
  of[joint] = &crack;
  ++count;
  return crack;
}

void CrackGrowth::Cracks::erase(int joint)
{
  if (!of[joint]) return;
  of[joint] = nullptr;
  --count;
}

void CrackGrowth::reset(const CrackLattice &lattice)
{
  cracks.reset(6 * static_cast<std::size_t>(lattice.n));
  for (auto *list : {&live, &stale, &wide}) list->clear();
  changed = false;
  place.assign(lattice.n, -1);
  loud.assign(lattice.n, 0);
  loud_list.clear();
  active.clear();
  close.clear();
  fronts.clear();
  waiting.clear();
}

void CrackGrowth::find_again(const CrackLattice &lattice, int joint, Crack &crack)
{
  changed = true;
  if (crack.stale) return;
  crack.stale = true;
  stale.push_back({ids(lattice, joint), joint, &crack});
}

void CrackGrowth::add_crack(const CrackLattice &lattice, int joint, const CrackMemory &memory)
{
  const int lower = lattice.lower_end(joint);
  cracks[lower].memory = memory;
  joint_changes(lattice, lower);
}

void CrackGrowth::add_known_crack(const CrackLattice &lattice, int joint, const CrackMemory &memory)
{
  const int lower = lattice.lower_end(joint);
  Crack &crack = cracks[lower];
  crack.memory = memory;
  find_again(lattice, lower, crack);
}

void CrackGrowth::remove_crack(const CrackLattice &lattice, int joint)
{
  const int lower = lattice.lower_end(joint);
  joint_changes(lattice, lower);
  for (auto *list : {&live, &stale, &wide})
    list->erase(std::remove_if(list->begin(), list->end(),
                               [lower](const Listed &c) {
                                 return c.joint == lower;
                               }),
                list->end());
  cracks.erase(lower);
}

/// Rings of up to four DEs are found again for all cracks that may share one with it.
void CrackGrowth::joint_changes(const CrackLattice &lattice, int joint)
{
  changed = true;
  all_around(lattice, joint, [&](int other) {
    if (Crack *const crack = cracks.find(other)) find_again(lattice, other, *crack);
    return true;
  });
}

Vec3 CrackGrowth::crack_point(const CrackLattice &lattice, int joint) const
{
  return Vec3(lattice.X[joint / 6]) + cracks.at(joint).memory.f * lattice.vector(joint);
}

// --- which DEs are looked at ------------------------------------------------

void CrackGrowth::activate(int de)
{
  if (place[de] >= 0) return;
  place[de] = 0;
  active.push_back(de);
}

/// Rings with an odd number of cut joints, each once: from its first cut joint; and where it waits before ties.
void CrackGrowth::find_rings(const CrackLattice &lattice, int joint, Crack &crack) const
{
  crack.odd.clear();
  crack.before_ties.clear();
  crack.stale = crack.wide = false;
  CrackRing ring;
  for (int t = 0; t < 6; ++t) {
    if (t / 2 == joint % 6 / 2) continue;
    const bool closed = crack_ring(lattice, joint / 6, joint % 6, t, ring);
    if (ring.size > 4) crack.wide = true;
    if (!closed) continue;
    if (ring.cut(lattice) % 2 == 0) continue;
    bool first = true;
    for (int k = 0; k < ring.size; ++k) {
      const int other = lattice.lower_end(ring.joint[k]);
      if (lattice.cut(other) && ids(lattice, other) < ids(lattice, joint)) first = false;
    }
    if (first) crack.odd.push_back(ring);
  }
  if (lattice.ties) find_waiting(lattice, joint, crack);
}

/// The crack between the two DEs of a cut joint goes on between their ties along another axis; or through joints of
/// one of them, where the ring is open at a tie of the other.
void CrackGrowth::find_waiting(const CrackLattice &lattice, int joint, Crack &crack) const
{
  CrackRing arc;
  for (int end : {joint, lattice.other_end(joint)})
    for (int s = 0; s < 6; ++s) {
      const int here = 6 * (end / 6) + s;
      if (s / 2 == end % 6 / 2 || lattice.partner[end / 6][s] >= 0) continue;
      const bool closed = crack_ring(lattice, end / 6, end % 6, s, arc);
      if (arc.size > 4) crack.wide = true;
      Waiting front;
      front.crack = joint;
      if (is_tie(lattice, here)) {
        front.tie = here;
        front.known = behind_tie(lattice, here, front.missing);
        if (arc.size > 1)
          front.next = Vec3(lattice.X[lattice.other_end(arc.joint[1]) / 6]);
        else
          front.known = front.known && arc.open >= 0 && is_tie(lattice, arc.open) &&
              behind_tie(lattice, arc.open, front.next);
        crack.before_ties.push_back(front);
      }
      if (closed || arc.open < 0 || arc.size < 2 || arc.cut(lattice) > 1 ||
          !is_tie(lattice, arc.open))
        continue;
      front.tie = arc.open;
      front.arc = arc;
      // of longer arcs the other end is not known on all ranks
      front.known = arc.size == 2 && behind_tie(lattice, arc.open, front.missing) &&
          is_tie(lattice, here) && behind_tie(lattice, here, front.next);
      const Vec3 X(lattice.X[end / 6]);
      if (front.known && (front.next - front.missing).norm() < 0.5 * (front.next - X).norm())
        front.next = X;    // one DE is missing, behind both ties
      crack.before_ties.push_back(front);
    }
}

/// Those that joints which have changed may share a ring with; the others keep their place in the order of IDs.
void CrackGrowth::update_live(const CrackLattice &lattice)
{
  for (const Listed &c : wide) find_again(lattice, c.joint, *c.crack);
  wide.clear();
  live.erase(std::remove_if(live.begin(), live.end(),
                            [](const Listed &c) {
                              return c.crack->stale;
                            }),
             live.end());
  const auto kept = static_cast<std::ptrdiff_t>(live.size());
  for (const Listed &c : stale) {
    find_rings(lattice, c.joint, *c.crack);
    if (c.crack->wide) wide.push_back(c);
    if (!c.crack->odd.empty() || !c.crack->before_ties.empty()) live.push_back(c);
  }
  stale.clear();
  const auto by_ids = [](const Listed &a, const Listed &b) {
    return a.ids < b.ids;
  };
  std::sort(live.begin() + kept, live.end(), by_ids);
  std::inplace_merge(live.begin(), live.begin() + kept, live.end(), by_ids);
  changed = false;
}

/// Those with an intact joint that may open, and those that wait beside a loud DE, in the order of IDs.
template <class F> void CrackGrowth::find_fronts(const CrackLattice &lattice, const F &may_open)
{
  if (changed) update_live(lattice);
  for (const Listed &c : live) {
    const Crack *const crack = c.crack;
    for (const Waiting &front : crack->before_ties) {
      bool any_loud = loud[front.tie / 6];
      for (int k = 1; k < front.arc.size; ++k) any_loud = any_loud || loud[front.arc.de[k]];
      if (any_loud) waiting.push_back(front);
      // a crack may go on in what is there of the ring
      if (front.arc.size == 2 && may_open(front.arc.de[1], front.arc.de[2]))
        fronts.push_back(front.arc);
    }
    for (const CrackRing &ring : crack->odd) {
      bool any = false;
      for (int k = 0; k < ring.size; ++k)
        any = any ||
            (!lattice.cut(ring.joint[k]) &&
             may_open(ring.de[k], ring.de[k + 1 < ring.size ? k + 1 : 0]));
      if (any) fronts.push_back(ring);
    }
  }
}

const std::vector<int> &CrackGrowth::mark(const CrackLattice &lattice, const double *energy,
                                          const double *quiet)
{
  if (static_cast<int>(place.size()) != lattice.n)
    throw std::logic_error("CrackGrowth: reset() before mark()");
  for (int d : active) place[d] = -1;
  for (int d : loud_list) loud[d] = 0;
  active.clear();
  loud_list.clear();
  close.clear();
  fronts.clear();
  waiting.clear();
  for (int d = 0; d < lattice.n; ++d)
    if (energy[d] >= quiet[d]) {
      loud[d] = 1;
      loud_list.push_back(d);
    }
  if (loud_list.empty()) return active;

  // the energy of both ends says more than that of each alone
  const auto may_open = [&](int a, int b) {
    return (loud[a] || loud[b]) && !(energy[a] + energy[b] < quiet[a] + quiet[b]);
  };
  for (int d : loud_list)
    for (int s = 0; s < 6; ++s) {
      const int joint = 6 * d + s, other = lattice.partner[d][s];
      if (other < 0 || lattice.cut(joint)) continue;
      const int e = other / 6, lower = lattice.lower_end(joint);
      if (!may_open(d, e)) continue;
      if (lower != joint && loud[e]) continue;    // the other end says so
      activate(d);
      activate(e);
      close.push_back(lower);
    }
  find_fronts(lattice, may_open);
  for (const Waiting &front : waiting) {
    const auto look = [&](int d) {
      bool near = loud[d];
      for (int s = 0; s < 6; ++s)
        near = near || (lattice.partner[d][s] >= 0 && loud[lattice.partner[d][s] / 6]);
      if (near) activate(d);
    };
    look(front.tie / 6);
    for (int k = 1; k < front.arc.size; ++k) look(front.arc.de[k]);
  }
  for (const CrackRing &ring : fronts)
    for (int k = 0; k < ring.des(); ++k) {
      const int d = ring.de[k];
      activate(d);
      for (int s = 0; s < 6; ++s)
        if (lattice.partner[d][s] >= 0) activate(lattice.partner[d][s] / 6);
    }
  std::sort(active.begin(), active.end());
  for (std::size_t k = 0; k < active.size(); ++k) place[active[k]] = static_cast<int>(k);
  stresses.resize(active.size());
  return active;
}

// --- decisions --------------------------------------------------------------

void CrackGrowth::find_hot(const CrackLattice &lattice, const CrackStrength &strength)
{
  hot.clear();
  hot_of.assign(6 * active.size(), -1);
  for (int joint : close) {
    const int d = joint / 6, s = joint % 6, other = lattice.partner[d][s];
    const double limit = strength(d, other / 6), of_nucleus = strength.of_nucleus(d, other / 6);
    const double least = 0.98 * std::min(limit, of_nucleus);
    const CrackStress &a = stresses[place[d]], &b = stresses[place[other / 6]];
    const double volume = a.slot_volume[s] + b.slot_volume[other % 6];
    if (!(volume > 0.0) || !std::isfinite(limit)) continue;
    double sum[6];
    for (int k = 0; k < 6; ++k) sum[k] = a.slot[s][k] + b.slot[other % 6][k];
    if (largest_principal_bound(sum) < least * volume) continue;
    const Mat3 S = crack_tensor(sum) / volume;
    const Principal p = largest_principal(S);
    if (p.value < least) continue;
    hot_of[6 * place[d] + s] = static_cast<int>(hot.size());
    hot.push_back({joint, limit, p.value / limit, of_nucleus / limit,
                   strength.nucleus(d, other / 6), p.direction, S / limit});
  }
}

const CrackGrowth::Hot *CrackGrowth::hot_joint(const CrackLattice &lattice, int joint) const
{
  const int lower = lattice.lower_end(joint);
  if (!marked(lower / 6)) return nullptr;
  const int k = hot_of[6 * place[lower / 6] + lower % 6];
  return k < 0 ? nullptr : &hot[k];
}

CrackGrowth::Front CrackGrowth::front(const CrackLattice &lattice, const CrackRing &ring,
                                      const Vec3 &old, double memory) const
{
  std::vector<std::pair<std::int64_t, int>> des;
  for (int k = 0; k < ring.des(); ++k) {
    const int d = ring.de[k];
    des.emplace_back(lattice.id[d], d);
    for (int s = 0; s < 6; ++s)
      if (lattice.partner[d][s] >= 0)
        des.emplace_back(lattice.id[lattice.partner[d][s] / 6], lattice.partner[d][s] / 6);
  }
  std::sort(des.begin(), des.end());
  des.erase(std::unique(des.begin(), des.end()), des.end());
  Mat3 full = Mat3::Zero(), all = Mat3::Zero();
  double full_volume = 0.0, all_volume = 0.0;
  for (const auto &[id, d] : des) {
    const CrackStress &s = stresses[place[d]];
    full += crack_tensor(s.full);
    full_volume += s.full_volume;
    for (int q = 0; q < 6; ++q) {
      all += crack_tensor(s.slot[q]);
      all_volume += s.slot_volume[q];
    }
  }
  if (!(all_volume > 0.0)) return {old, 0.0};
  const Mat3 S = full_volume > 0.0 ? Mat3(full / full_volume) : Mat3(all / all_volume);
  const double s1 = std::max(largest_principal(S).value, 0.0);
  const Vec3 m = largest_principal(S + memory * s1 * old * old.transpose(), old).direction;
  return {m.dot(old) < 0.0 ? Vec3(-m) : m, m.dot(S * m)};
}

/// On which side of a crack with normal m the cut joints of a DE say that it is: 1, -1; 0 if none does, or both.
int CrackGrowth::side(const CrackLattice &lattice, int de, const Vec3 &m) const
{
  int found = 0;
  for (int s = 0; s < 6; ++s) {
    const int joint = 6 * de + s;
    if (lattice.partner[de][s] < 0 || !lattice.cut(joint)) continue;
    const int lower = lattice.lower_end(joint);
    const Crack *const crack = cracks.find(lower);
    if (!crack) continue;
    const double along = m.dot(Vec3(crack->memory.m));
    if (std::abs(along) < 0.5) continue;    // of a crack that crosses this one
    const int here = (lower == joint) == (along > 0.0) ? -1 : 1;
    if (found != 0 && here != found) return 0;
    found = here;
  }
  return found;
}

/// Of the ends of a joint over a plane. Those of DEs that are known to be on the other side: the plane passes them closely.
CrackGrowth::Heights CrackGrowth::heights(const CrackLattice &lattice, int joint, const Vec3 &m,
                                          const Vec3 &p) const
{
  const Vec3 e = lattice.vector(joint);
  const auto kept = [&](int de, double over) {
    const bool near = std::abs(over) < side_reach * e.norm();
    return near && side(lattice, de, m) * over < 0.0 ? -1e-9 * over : over;
  };
  const double below = m.dot(Vec3(lattice.X[joint / 6]) - p);
  return {kept(joint / 6, below), kept(lattice.other_end(joint) / 6, below + m.dot(e))};
}

void CrackGrowth::vote(const CrackLattice &lattice, const CrackRing &ring,
                       const CrackGrowthParameters &par)
{
  int cut = -1;
  bool may_fire = false;
  for (int k = 0; k < ring.size; ++k) {
    if (lattice.cut(ring.joint[k])) cut = lattice.lower_end(ring.joint[k]);
    const Hot *h = hot_joint(lattice, ring.joint[k]);
    may_fire = may_fire || (h && h->value >= 1.0);
  }
  if (!may_fire) return;    // m.S m <= s_1
  const auto [m, tension] = front(lattice, ring, normal(cut), par.memory);
  const Vec3 p = crack_point(lattice, cut);
  bool fires = false;
  for (int k = 0; k < ring.size; ++k) {
    const Hot *h = hot_joint(lattice, ring.joint[k]);
    fires = fires || (h && m.dot(h->S * m) >= 1.0 && tension >= par.pull * h->limit);
  }
  if (!fires) return;
  bool goes_on = false;
  for (int k = 0; k < ring.size; ++k) {
    const int joint = lattice.lower_end(ring.joint[k]);
    if (lattice.cut(joint)) continue;
    const auto [below, above] = heights(lattice, joint, m, p);
    goes_on = goes_on || (below < 0.0) != (above < 0.0);
    if (joint / 6 >= lattice.owned) continue;
    const Ids a = ids(lattice, joint), c = ids(lattice, cut);
    votes.push_back({joint, {a[0], a[1], c[0], c[1]}, m, below, above});
  }
  if (!goes_on && ring.open >= 0 && ring.open / 6 < lattice.owned) entries.push_back(ring.open);
}

void CrackGrowth::count_votes(const CrackLattice &lattice, const CrackStrength &strength,
                              std::vector<CrackStart> &starts)
{
  std::sort(votes.begin(), votes.end(), [](const Vote &a, const Vote &b) {
    return std::lexicographical_compare(a.key, a.key + 4, b.key, b.key + 4);
  });
  for (std::size_t k = 0; k < votes.size();) {
    const int joint = votes[k].joint;
    Vec3 m = Vec3::Zero();
    double below = 0.0, above = 0.0;
    for (; k < votes.size() && votes[k].joint == joint; ++k) {
      const double sign = m.dot(votes[k].m) < 0.0 ? -1.0 : 1.0;
      m += sign * votes[k].m;
      below += sign * votes[k].below;
      above += sign * votes[k].above;
    }
    if ((below < 0.0) == (above < 0.0) ||
        !std::isfinite(strength(joint / 6, lattice.other_end(joint) / 6)))
      continue;
    starts.push_back(
        make_start(lattice, joint, m.normalized(), below / (below - above), CrackStart::FRONT));
  }
}

void CrackGrowth::ligament(const CrackLattice &lattice, const CrackRing &ring,
                           std::vector<CrackStart> &starts) const
{
  Vec3 sum = Vec3::Zero();
  std::vector<std::pair<Ids, int>> cut;
  for (int k = 0; k < ring.size; ++k) {
    const int joint = lattice.lower_end(ring.joint[k]);
    if (lattice.cut(joint)) cut.emplace_back(ids(lattice, joint), joint);
  }
  std::sort(cut.begin(), cut.end());
  const Hot *most = nullptr;
  for (int k = 0; k < ring.size; ++k) {
    const Hot *h = hot_joint(lattice, ring.joint[k]);
    if (h && h->value >= 1.0 &&
        (!most || h->value > most->value ||
         (h->value == most->value && ids(lattice, h->joint) < ids(lattice, most->joint))))
      most = h;
  }
  if (!most || most->joint / 6 >= lattice.owned) return;
  for (const auto &[key, joint] : cut) {
    if (!cracks.find(joint)) continue;    // broken by something else
    const Vec3 m = normal(joint);
    sum += m.dot(most->direction) < 0.0 ? Vec3(-m) : m;
  }
  if (sum.norm() < 1.0) return;    // they say nothing in common
  const Vec3 m = sum.normalized();
  if (m.dot(most->S * m) >= 1.0)
    starts.push_back(make_start(lattice, most->joint, m, 0.5, CrackStart::LIGAMENT));
}

bool CrackGrowth::shielded(const CrackLattice &lattice, int joint) const
{
  if (cracks.empty()) return false;
  CrackRing ring;
  for (int t = 0; t < 6; ++t)
    if (t / 2 != joint % 6 / 2 && crack_ring(lattice, joint / 6, joint % 6, t, ring) &&
        ring.cut(lattice) > 0)
      return true;
  const Vec3 c = centre(lattice, joint);
  const double d = lattice.vector(joint).norm();
  return !all_around(lattice, joint, [&](int other) {
    if (!cracks.find(other)) return true;
    const Vec3 away = c - crack_point(lattice, other), m = normal(other);
    const double across = away.dot(m);
    return std::abs(across) >= 1.5 * d || (away - across * m).norm() >= 1.01 * d;
  });
}

/// A nucleus is held by the strength of flaws, a branch by sigma_t; `excess`: what the joint bears is so many times that.
bool CrackGrowth::could_start(const CrackLattice &lattice, const Hot &h, bool branch,
                              double *excess, Vec3 *m) const
{
  const double strength = branch ? 1.0 : h.flaws;
  if (h.value < strength) return false;
  const std::uint64_t hash = joint_key(lattice, h.joint);
  *excess = h.value / (strength * (1.0 + h.nucleus.scatter * uniform(hash, 0)));
  if (*excess < 1.0) return false;
  *m = largest_principal(h.S, random_direction(hash)).direction;
  return best_aligned(lattice, h.joint, *m);
}

void CrackGrowth::nuclei(const CrackLattice &lattice, std::vector<CrackStart> &starts) const
{
  for (const Hot &h : hot) {
    double excess, other_excess;
    Vec3 m, other_m;
    if (h.joint / 6 >= lattice.owned || !could_start(lattice, h, h.flaws > 1.0, &excess, &m))
      continue;
    const bool shield = shielded(lattice, h.joint);
    if (h.flaws != 1.0 && !could_start(lattice, h, shield, &excess, &m)) continue;
    if (shield && excess < h.nucleus.overstrength) continue;
    const bool first = all_around(lattice, h.joint, [&](int joint) {
      if (joint == h.joint) return true;
      const Hot *other = hot_joint(lattice, joint);
      if (!other || !could_start(lattice, *other, shield, &other_excess, &other_m)) return true;
      if (other_excess > excess * (1.0 + 1e-9)) return false;
      return other_excess < excess * (1.0 - 1e-9) || ids(lattice, h.joint) < ids(lattice, joint);
    });
    if (first)
      starts.push_back(
          make_start(lattice, h.joint, m, 0.5, shield ? CrackStart::BRANCH : CrackStart::NUCLEUS));
  }
}

/// Tension across the crack, at the tie or a joint that is left between it and the crack.
bool CrackGrowth::wants_to_enter(const CrackLattice &lattice, const CrackStrength &strength,
                                 const Waiting &front, double share) const
{
  const int d = front.tie / 6;
  const double limit = strength(d, d);
  if (!std::isfinite(limit)) return false;
  const Vec3 m = normal(front.crack);
  const auto pulled = [&](const Mat3 &sum, double volume) {
    return volume > 0.0 && m.dot(sum * m) >= share * limit * volume;
  };
  if (marked(d)) {
    const CrackStress &s = stresses[place[d]];
    if (pulled(crack_tensor(s.slot[front.tie % 6]), s.slot_volume[front.tie % 6])) return true;
  }
  for (int k = 1; k < front.arc.size; ++k) {    // 0: the cut one
    const int joint = lattice.lower_end(front.arc.joint[k]), other = lattice.other_end(joint);
    if (!marked(joint / 6) || !marked(other / 6)) continue;
    const CrackStress &a = stresses[place[joint / 6]], &b = stresses[place[other / 6]];
    if (pulled(crack_tensor(a.slot[joint % 6]) + crack_tensor(b.slot[other % 6]),
               a.slot_volume[joint % 6] + b.slot_volume[other % 6]))
      return true;
  }
  return false;
}

/// Does the plane of the crack pass between the DE behind the tie and its neighbours in the ring, or closer to them than a
/// tenth of their spacing?
bool CrackGrowth::needed(const CrackLattice &lattice, const Waiting &front) const
{
  if (!front.known) return true;
  constexpr double margin = 0.1;
  const Vec3 m = normal(front.crack), p = crack_point(lattice, front.crack);
  const Vec3 last(lattice.X[front.tie / 6]);
  const double near = margin * (front.missing - last).norm();
  double lowest = HUGE_VAL, highest = -HUGE_VAL;
  for (const Vec3 &X : {last, front.missing, front.next}) {
    const double along = m.dot(X - p);
    lowest = std::min(lowest, along);
    highest = std::max(highest, along);
  }
  return lowest < near && highest > -near;
}

void CrackGrowth::enter(const CrackLattice &lattice, const CrackStrength &strength, double share)
{
  for (const Waiting &front : waiting)
    if (front.tie / 6 < lattice.owned && needed(lattice, front) &&
        wants_to_enter(lattice, strength, front, share))
      entries.push_back(front.tie);
}

void CrackGrowth::decide(const CrackLattice &lattice, const CrackStrength &strength,
                         const CrackGrowthParameters &par, std::vector<CrackStart> &starts)
{
  starts.clear();
  entries.clear();
  if (active.empty()) return;
  enter(lattice, strength, par.entry);
  find_hot(lattice, strength);
  if (!hot.empty()) open(lattice, strength, par, starts);
  std::sort(entries.begin(), entries.end());
  entries.erase(std::unique(entries.begin(), entries.end()), entries.end());
}

void CrackGrowth::open(const CrackLattice &lattice, const CrackStrength &strength,
                       const CrackGrowthParameters &par, std::vector<CrackStart> &starts)
{
  votes.clear();
  for (const CrackRing &ring : fronts)
    if (ring.cut(lattice) == 1) vote(lattice, ring, par);
  count_votes(lattice, strength, starts);
  for (const CrackRing &ring : fronts)
    if (ring.open < 0 && ring.cut(lattice) > 1) ligament(lattice, ring, starts);
  nuclei(lattice, starts);

  // one start per joint, what a front says first
  std::stable_sort(starts.begin(), starts.end(), [&](const CrackStart &a, const CrackStart &b) {
    const Ids ia = ids(lattice, a.joint), ib = ids(lattice, b.joint);
    return ia != ib ? ia < ib : a.origin < b.origin;
  });
  starts.erase(std::unique(starts.begin(), starts.end(),
                           [](const CrackStart &a, const CrackStart &b) {
                             return a.joint == b.joint;
                           }),
               starts.end());
}

}    // namespace defe
