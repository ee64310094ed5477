#ifndef DEFE_TEST_CRACK_BODY_H
#define DEFE_TEST_CRACK_BODY_H

// A body of discrete elements that cracks, on one rank with plain arrays: it calls crack_growth.h and
// crack_softening.h in the order in which a run does.

#include "de_block.h"

#include "defe/coupling/crack_growth.h"
#include "defe/coupling/crack_softening.h"

#include <Eigen/Eigenvalues>

#include <map>

namespace defe::test {

/// Glass.
inline fe::IsotropicElastic glass()
{
  return {74.09e9, 0.2, 2500.0};
}

/// Deformation gradient, without rotation, of a second Piola-Kirchhoff stress in glass.
inline Mat3 strain_of(const Mat3 &S)
{
  const fe::IsotropicElastic g = glass();
  const Mat3 E = ((1.0 + g.nu) * S - g.nu * S.trace() * Mat3::Identity()) / g.E;
  // F^T F = I + 2 E
  return Eigen::SelfAdjointEigenSolver<Mat3>(Mat3::Identity() + 2.0 * E).operatorSqrt();
}

/// The elements of a mesh whose centre passes.
inline Mesh part_of(const Mesh &mesh, const std::function<bool(const Vec3 &)> &keep)
{
  Mesh part;
  part.X = mesh.X;
  for (const auto &hex : mesh.hex) {
    Vec3 c = Vec3::Zero();
    for (auto k : hex) c += mesh.X[k] / 8.0;
    if (keep(c)) part.hex.push_back(hex);
  }
  return part;
}

class CrackBody {
 public:
  Block block;
  int n;
  CornerModuli moduli;
  CohesiveParameters law;
  CrackGrowthParameters parameters;
  std::vector<CrackNuclei> nuclei = std::vector<CrackNuclei>(4);
  std::vector<double> flaws;    // strength by DE, see give_flaws()

  std::vector<std::int64_t> id;
  std::vector<std::array<double, 3>> X;
  std::vector<std::array<int, 6>> partner;
  std::vector<unsigned char> outer, state, present, type, free;
  std::vector<std::uint16_t> turned;
  std::vector<std::array<Vec3, 6>> area;    // whole joints, outward
  std::vector<double> volume, quiet, energy, mass;
  std::vector<Vec3> x, v, f;
  std::vector<char> driven;

  CrackGrowth growth;
  std::vector<CrackStart> starts;
  struct Cut {
    CrackJoint joint;
    CrackGeometry geometry;
    CrackStart::Origin origin;
    bool notch;
    double damage = 0.0, fracture = 0.0, lost = 0.0;
  };
  std::map<int, Cut> cut;    // by lower end
  double stored = 0.0, work = 0.0;

  CrackBody(const Mesh &mesh, const CohesiveParameters &law, bool boxes,
            const fe::IsotropicElastic &material = glass(), ElementSplit split = ElementSplit()) :
      block(mesh, std::vector<char>(mesh.hex.size(), 1), material, split),
      n(block.des()), moduli(block.moduli), law(law), boxes(boxes)
  {
    for (int i = 0; i < n; ++i) {
      const auto &p = block.de[i];
      id.push_back(1 + i);
      X.push_back({p.birth.X[0], p.birth.X[1], p.birth.X[2]});
      x.push_back(p.birth.X);
      mass.push_back(p.birth.mass);
      volume.push_back(p.birth.volume);
      outer.push_back(static_cast<unsigned char>(block.split.outer_slots(p.place)));
      turned.push_back(p.turned);
      present.push_back(static_cast<unsigned char>(p.present));
      partner.push_back({-1, -1, -1, -1, -1, -1});
      for (int s = 0; s < 6; ++s)
        if (p.present >> s & 1u) partner[i][s] = 6 * p.nb[s] + p.nb_slot[s];
    }
    area.resize(n);
    std::vector<std::array<Vec3, 6>> half_area(n);
    for (int i = 0; i < n; ++i) corner_areas(block.de[i].cell, present[i], half_area[i].data());
    for (int i = 0; i < n; ++i)
      for (int s = 0; s < 6; ++s) {
        area[i][s] = half_area[i][s];
        if (partner[i][s] >= 0) area[i][s] -= half_area[partner[i][s] / 6][partner[i][s] % 6];
      }
    state.assign(6 * n, CrackLattice::INTACT);
    type.assign(n, 0);
    driven.assign(n, 0);
    v.assign(n, Vec3::Zero());
    f.assign(n, Vec3::Zero());
    energy.assign(n, 0.0);
    for (int i = 0; i < n; ++i)
      quiet.push_back(crack_quiet_energy(crack_least_volume(block.de[i].cell), moduli, law.sigma_t,
                                         CrackGrowth::quiet_share));
    half.resize(n);
    growth.reset(lattice());
    prepare_boxes();
  }

  void give_flaws(const std::vector<double> &strength)
  {
    flaws = strength;
    for (int i = 0; i < n; ++i) {
      double least = law.sigma_t;
      for (int other : partner[i])
        if (other >= 0) least = std::min({least, flaws[i], flaws[other / 6]});
      quiet[i] = crack_quiet_energy(crack_least_volume(block.de[i].cell), moduli, least,
                                    CrackGrowth::quiet_share);
    }
  }

  CrackLattice lattice() const
  {
    return {n,
            n,
            id.data(),
            reinterpret_cast<const double(*)[3]>(X.data()),
            reinterpret_cast<const int(*)[6]>(partner.data()),
            outer.data(),
            state.data(),
            nullptr,
            turned.data()};
  }
  CrackStrength strength() const
  {
    static thread_local double table[4];
    table[0] = law.sigma_t;
    table[1] = table[2] = table[3] = HUGE_VAL;
    return {type.data(), 2, table, nuclei.data(), flaws.empty() ? nullptr : flaws.data()};
  }
  Vec3 reference(int i) const { return Vec3(X[i][0], X[i][1], X[i][2]); }
  CrackGeometry geometry(int joint) const
  {
    return {lattice().vector(joint),
            area[joint / 6][joint % 6],
            {joint % 6, lattice().other_end(joint) % 6}};
  }
  Vec3 arm(int joint) const { return x[lattice().other_end(joint) / 6] - x[joint / 6]; }

  struct End {
    Vec3 dX[6], y[6];
  };
  CrackEnd end(int i, End &store) const
  {
    for (int s = 0; s < 6; ++s) {
      const bool there = partner[i][s] >= 0;
      store.dX[s] = there ? lattice().vector(6 * i + s) : Vec3(Vec3::Zero());
      store.y[s] = there ? arm(6 * i + s) : Vec3(Vec3::Zero());
    }
    return {store.dX, store.y, present[i]};
  }

  /// Forces of everything at the present positions; softening joints advance.
  void forces(bool advance = true)
  {
    elastic();
    stored = 0.0;
    for (double e : energy) stored += e;
    for (auto &[joint, c] : cut) soften(joint, c, advance);
  }

  /// Of the DEs whose energy is high enough to matter.
  void find_stresses()
  {
    for (int i : growth.mark(lattice(), energy.data(), quiet.data())) {
      End e;
      const CrackEnd de = end(i, e);
      growth.stress(i) = crack_stress(block.de[i].cell, e.y, de.present, moduli);
    }
  }
  void decide()
  {
    find_stresses();
    growth.decide(lattice(), strength(), parameters, starts);
  }
  /// Decide, and carry out at once.
  int grow()
  {
    decide();
    open(starts);
    return static_cast<int>(starts.size());
  }

  /// The law of joints that know only their own traction.
  int grow_today()
  {
    starts.clear();
    const CrackLattice l = lattice();
    for (int i = 0; i < n; ++i)
      for (int s = 0; s < 6; ++s) {
        const int joint = 6 * i + s;
        if (partner[i][s] < 0 || l.cut(joint) || l.lower_end(joint) != joint) continue;
        const Vec3 t = joint_force(joint) / area[i][s].norm(), m = l.vector(joint).normalized();
        const double t_m = t.dot(m), limit = strength()(i, partner[i][s] / 6);
        if (t_m > 0.0 && equivalent_traction(t_m, (t - t_m * m).norm(), law) >= limit)
          starts.push_back({joint, {{m[0], m[1], m[2]}, 0.5}, CrackStart::FRONT});
      }
    open(starts);
    return static_cast<int>(starts.size());
  }

  Vec3 joint_force(int joint) const
  {
    const int other = lattice().other_end(joint);
    return half[joint / 6][joint % 6] - half[other / 6][other % 6];
  }

  /// As a run does it: starts of all joints; then what each DE lets go; then the joints take that over.
  void open(const std::vector<CrackStart> &list)
  {
    std::map<int, Cut> fresh;
    std::map<int, unsigned> leaving;
    for (const CrackStart &s : list) {
      const int other = lattice().other_end(s.joint);
      End a, b;
      Cut c{{}, geometry(s.joint), s.origin, false};
      if (!crack_start(c.joint, Vec3(s.memory.m), s.memory.f, c.geometry, joint_force(s.joint),
                       end(s.joint / 6, a), end(other / 6, b), arm(s.joint)))
        continue;
      fresh.emplace(s.joint, c);
      for (int e : {s.joint, other}) leaving[e / 6] |= 1u << e % 6;
    }
    std::map<int, std::array<double, 6>> share;
    for (const auto &[i, out] : leaving) {
      End e;
      end(i, e);
      released += crack_release(block.de[i].cell, e.y, present[i], out, moduli, share[i].data());
      present[i] = static_cast<unsigned char>(present[i] & ~out);
    }
    for (auto &[joint, c] : fresh) {
      const int other = lattice().other_end(joint);
      crack_take_over(c.joint, c.geometry,
                      share[joint / 6][joint % 6] + share[other / 6][other % 6], moduli, law);
      taken_over += c.joint.stored;
      state[joint] = state[other] = c.joint.broken ? CrackLattice::BROKEN : CrackLattice::SOFTENING;
      cut.emplace(joint, c);
      growth.add_crack(lattice(), joint, {{c.joint.m[0], c.joint.m[1], c.joint.m[2]}, c.joint.f});
    }
  }
  double released = 0.0, taken_over = 0.0;

  /// Joints that cross a plane are broken from the start.
  void notch(const std::function<bool(const Vec3 &)> &where, const Vec3 &m, double level)
  {
    for (int i = 0; i < n; ++i)
      for (int s = 0; s < 6; ++s) {
        const int joint = 6 * i + s;
        if (partner[i][s] < 0 || lattice().lower_end(joint) != joint) continue;
        const double below = reference(i).dot(m) - level, step = lattice().vector(joint).dot(m);
        if ((below < 0.0) == (below + step < 0.0)) continue;
        const double at = -below / step;
        const Vec3 p = reference(i) + at * lattice().vector(joint);
        if (!where(p)) continue;
        const int other = lattice().other_end(joint);
        const Vec3 normal = step < 0.0 ? Vec3(-m) : m;
        Cut c{crack_broken(normal, at, geometry(joint), moduli, law), geometry(joint),
              CrackStart::FRONT, true};
        state[joint] = state[other] = CrackLattice::BROKEN;
        for (int e : {joint, other}) present[e / 6] &= ~(1u << e % 6);
        cut.emplace(joint, c);
        growth.add_crack(lattice(), joint, {{normal[0], normal[1], normal[2]}, at});
      }
  }

  double kinetic() const
  {
    double k = 0.0;
    for (int i = 0; i < n; ++i) k += 0.5 * mass[i] * v[i].squaredNorm();
    return k;
  }

  /// Velocity Verlet; DEs that are driven keep their velocity, and their work is counted.
  enum Law { NO_CRACKS, NEW, TODAY };
  void step(double dt, Law cracks = NEW)
  {
    double power = 0.0;
    const auto half_kick = [&] {
      for (int i = 0; i < n; ++i)
        if (driven[i])
          power -= f[i].dot(v[i]);
        else
          v[i] += 0.5 * dt / mass[i] * f[i];
    };
    half_kick();
    for (int i = 0; i < n; ++i) x[i] += dt * v[i];
    forces();
    half_kick();
    work += 0.5 * dt * power;
    if (cracks == NEW) grow();
    if (cracks == TODAY) grow_today();
  }

  double stable_step(double share = 0.4) const
  {
    double least = HUGE_VAL;
    for (int i = 0; i < n; ++i)
      least = std::min(
          least, lattice_critical_step(block.de[i].cell, block.de[i].present, moduli, mass[i]));
    return share * least;
  }

 private:
  bool boxes;
  std::vector<std::array<Vec3, 6>> half;
  std::vector<int> self;
  std::vector<std::array<int, 6>> nb;
  std::vector<std::array<double, 6>> len, thick;

  void prepare_boxes()
  {
    for (int i = 0; i < n; ++i) {
      self.push_back(i);
      nb.emplace_back();
      len.emplace_back();
      thick.emplace_back();
      for (int s = 0; s < 6; ++s) {
        const bool there = partner[i][s] >= 0;
        nb[i][s] = there ? partner[i][s] / 6 : -1;
        len[i][s] = there ? lattice().vector(6 * i + s).norm() : 1.0;
        thick[i][s] = block.de[i].cell.face[s].norm();
      }
      free.push_back(block.de[i].cell.free);
    }
  }

  void elastic()
  {
    if (boxes) {
      const OrthogonalLattice l{n,
                                self.data(),
                                reinterpret_cast<const int(*)[6]>(nb.data()),
                                present.data(),
                                reinterpret_cast<const double(*)[6]>(len.data()),
                                reinterpret_cast<const double(*)[6]>(thick.data()),
                                nullptr,
                                free.data()};
      corner_strain_orthogonal(l, x[0].data(), nullptr, &moduli,
                               reinterpret_cast<double(*)[6][3]>(half.data()), energy.data());
    } else {
      for (int i = 0; i < n; ++i) {
        End e;
        end(i, e);
        energy[i] =
            corner_strain_general(block.de[i].cell, e.y, present[i], moduli, half[i].data());
      }
    }
    for (Vec3 &force : f) force.setZero();
    for (int i = 0; i < n; ++i)
      for (int s = 0; s < 6; ++s)
        if (present[i] >> s & 1u) {
          f[i] += half[i][s];
          f[partner[i][s] / 6] -= half[i][s];
        }
  }

  void soften(int joint, Cut &c, bool advance)
  {
    const int a = joint / 6, b = lattice().other_end(joint) / 6;
    const Vec3 y = arm(joint);
    // an open plane carries nothing: its frame need not be known
    if (c.joint.broken && (y - c.geometry.d).dot(Vec3(c.joint.m)) > 0.2 * c.geometry.d.norm())
      return;
    End ea, eb;
    CrackJoint trial = c.joint;
    const CrackForces r =
        crack_update(trial, c.geometry, end(a, ea), end(b, eb), y, Vec3::Zero(), moduli, law);
    stored += trial.stored;
    f[a] += r.force + r.at[0];
    f[b] += r.at[1] - r.force;
    for (int s = 0; s < 6; ++s) {
      if (partner[a][s] >= 0) f[partner[a][s] / 6] += r.arm[0][s];
      if (partner[b][s] >= 0) f[partner[b][s] / 6] += r.arm[1][s];
    }
    if (!advance) return;
    c.joint = trial;
    c.damage = r.damage;
    c.fracture += r.fracture;
    c.lost += r.dissipated;
    if (r.newly_broken) state[joint] = state[lattice().other_end(joint)] = CrackLattice::BROKEN;
  }
};

}    // namespace defe::test

#endif
