#ifndef DEFE_TEST_JOINT_WORLD_H
#define DEFE_TEST_JOINT_WORLD_H

// Joints and ties of a block (de_block.h) by JointStates, on one "rank" or on several that exchange their messages: the
// particles are the nodes and then the DEs, on all ranks with the same numbers.

#include "de_block.h"

#include "defe/coupling/joint_states.h"

#include <memory>

namespace defe::test {

class JointRank : public CrackHost {
 public:
  JointTable jt;
  EnergyLedger ledger;
  StoredEnergy stored;
  std::unique_ptr<JointStates> states;
  Vectors f, torque;
  std::vector<DEJoints> records;
  std::vector<std::vector<JointCrack>> cracks;

  JointRank(const Block &b, const std::vector<int> &owned, const JointLaws &laws, bool boxes) :
      records(owned.size()), cracks(owned.size()), block(b)
  {
    std::vector<int> order(owned);
    for (int g = 0; g < b.des(); ++g)
      if (std::find(owned.begin(), owned.end(), g) == owned.end()) order.push_back(g);
    jt.nde = static_cast<int>(owned.size());
    jt.nall = b.des();
    jt.orthogonal = boxes ? jt.nde : 0;
    jt.of_atom.assign(b.X.size(), -1);
    for (int d = 0; d < jt.nall; ++d) {
      jt.self.push_back(b.nodes() + order[d]);
      jt.of_atom[jt.self[d]] = d;
    }
    jt.half_force.assign(18 * static_cast<std::size_t>(jt.nall), 0.0);
    jt.energy.assign(jt.nall, 0.0);
    jt.state.assign(6 * jt.nall, joint::CONNECTIVE);
    jt.material.assign(jt.nde, 0);
    jt.free.assign(jt.nde, 0);
    for (int d = 0; d < jt.nde; ++d) add(d, order[d], boxes);
    jt.tie_point.assign(3 * jt.tie_node.size() + 3, 0.0);
    states = std::make_unique<JointStates>(jt, laws, ledger, stored, *this);
  }
  ~JointRank() = default;

  int block_de(int d) const { return jt.self[d] - block.nodes(); }

  CrackDE describe(int d) const override
  {
    const auto &p = block.de[block_de(d)];
    CrackDE out{block.split.outer_slots(p.place), p.turned, 0, p.birth.volume, p.birth.X};
    return out;
  }
  std::vector<JointCrack> *find_cracks(int d) const override
  {
    return const_cast<std::vector<JointCrack> *>(&cracks[d]);
  }
  std::vector<JointCrack> &cracks_of(int d) override { return cracks[d]; }
  int nearest(int, std::int64_t id) const override { return static_cast<int>(id) - 1; }
  Vec3 half_periods() const override { return Vec3::Constant(HUGE_VAL); }

 private:
  const Block &block;

  void add(int d, int g, bool boxes)
  {
    const auto &p = block.de[g];
    jt.records.push_back(&records[d]);
    jt.nb.emplace_back();
    jt.partner.push_back({-1, -1, -1, -1, -1, -1});
    jt.len.emplace_back();
    jt.half.emplace_back();
    jt.present.push_back(static_cast<unsigned char>(p.present));
    if (!boxes) jt.cell.push_back(p.cell);
    Vec3 areas[6], other_areas[6];
    corner_areas(p.cell, p.present, areas);
    for (int s = 0; s < 6; ++s) {
      JointRecord &r = records[d].slot[s];
      Vec3 area = areas[s];
      jt.nb[d][s] = jt.self[d];
      jt.half[d][s] = jt.len[d][s] = p.cell.face[s].norm();
      if (p.present >> s & 1u) {
        jt.len[d][s] = p.cell.dX[s].norm();
        if (p.nb[s] >= 0) {
          const auto &other = block.de[p.nb[s]];
          corner_areas(other.cell, other.present, other_areas);
          area -= other_areas[p.nb_slot[s]];
          r.kind = joint::DE;
          r.partner = static_cast<signed char>(p.nb_slot[s]);
          jt.nb[d][s] = block.nodes() + p.nb[s];
          jt.partner[d][s] = 6 * jt.of_atom[jt.nb[d][s]] + p.nb_slot[s];
        } else {
          r.kind = joint::TIE;
          jt.nb[d][s] = ~static_cast<int>(jt.tie_node.size());
          jt.tie_node.push_back({});
          std::copy_n(block.tie[~p.nb[s]].begin(), 4, jt.tie_node.back().begin());
          jt.tie_element.push_back(1);
          jt.tie_part.push_back(0);
          jt.tie_spot.push_back(block.spot[~p.nb[s]]);
        }
      }
      r.area = area.norm();
      const Vec3 normal = area.normalized();
      for (int k = 0; k < 3; ++k) {
        r.face[k] = p.cell.face[s][k];
        r.normal[k] = normal[k];
      }
    }
  }
};

class JointWorld {
 public:
  Block block;
  JointLaws laws;
  Vectors x, v, f, omega;
  std::vector<std::unique_ptr<JointRank>> ranks;
  std::vector<JointEvent> events;
  int broken = 0;

  /// \param rank_of  by DE
  JointWorld(const Block &b, const JointCoeff &coeff, const std::function<int(int)> &rank_of,
             bool boxes = true, const std::vector<const OpeningLaw *> &openings = opening_laws()) :
      block(b),
      x(b.X), v(b.X.size(), Vec3::Zero()), f(v), omega(v), type(b.X.size(), 1), id(b.X.size())
  {
    laws.set_types(1);
    laws.openings = openings;
    laws.coeffs.assign(4, coeff);
    laws.acting.assign(4, JointLaws::OURS);
    laws.moduli = {block.moduli};
    laws.adhesives = {{0, 0, coeff.cohesive}};
    for (std::size_t i = 0; i < id.size(); ++i) id[i] = static_cast<std::int64_t>(i) + 1;
    std::vector<std::vector<int>> owned;
    for (int g = 0; g < block.des(); ++g) {
      const std::size_t r = rank_of(g);
      if (owned.size() <= r) owned.resize(r + 1);
      owned[r].push_back(g);
    }
    for (const auto &list : owned)
      ranks.push_back(std::make_unique<JointRank>(block, list, laws, boxes));
    for (auto &r : ranks) r->states->set_particles(particles());
    const bool cracks = ranks[0]->states->cracks();
    if (cracks) {
      for (auto &r : ranks) r->states->cracks()->prepare();
      forward(
          [](JointRank &from, int d, double *buf) {
            from.states->cracks()->pack_table(d, buf);
          },
          [](JointRank &to, int d, double *buf) {
            to.states->cracks()->unpack_table(d, buf);
          });
      for (auto &r : ranks) r->states->cracks()->resolve();
    }
    for (auto &r : ranks) r->states->new_tables();
  }

  MovingParticles particles() const
  {
    MovingParticles p;
    p.nlocal = p.nall = static_cast<int>(x.size());
    p.x = x[0].data();
    p.X = block.X[0].data();
    p.id = id.data();
    p.v = v[0].data();
    p.omega = omega[0].data();
    p.type = type.data();
    return p;
  }

  /// One evaluation, by the order at the head of joint_states.h.
  void forces(double dt, bool moving = true)
  {
    for (auto &r : ranks) {
      r->stored = StoredEnergy();
      r->f.assign(x.size(), Vec3::Zero());
      r->torque.assign(x.size(), Vec3::Zero());
      r->states->begin(particles(), moving ? dt : 0.0, moving);
      r->states->switch_pending();
      r->states->half_forces(true);
    }
    forward(
        [](JointRank &from, int d, double *buf) {
          from.states->pack_forces(d, buf);
        },
        [](JointRank &to, int d, double *buf) {
          to.states->unpack_forces(d, buf);
        });
    RoundedForces as_they_are;
    for (auto &r : ranks) {
      ForceSums sums{r->f[0].data(), r->torque[0].data(), &as_they_are, {}};
      r->states->gather(sums);
      r->states->soften(sums);
      r->states->find_pending();
    }
    if (moving && ranks[0]->states->cracks()) decide();
    forward(
        [](JointRank &from, int d, double *buf) {
          from.states->pack_states(d, buf);
        },
        [](JointRank &to, int d, double *buf) {
          to.states->unpack_states(d, buf);
        });
    for (auto &force : f) force.setZero();
    for (auto &r : ranks) {
      r->states->adopt_states();
      for (std::size_t i = 0; i < f.size(); ++i) f[i] += r->f[i];
      for (const auto &e : r->states->events()) events.push_back(e);
      broken += static_cast<int>(r->states->broken().size());
    }
  }

  /// Velocity Verlet of what is not fixed.
  void step(double dt, const std::vector<char> &fixed = {})
  {
    const auto kick = [&] {
      for (std::size_t i = 0; i < x.size(); ++i)
        if (block.mass[i] > 0.0 && (fixed.empty() || !fixed[i]))
          v[i] += 0.5 * dt / block.mass[i] * f[i];
    };
    kick();
    for (std::size_t i = 0; i < x.size(); ++i) x[i] += dt * v[i];
    forces(dt);
    kick();
  }

  int count(EventKind kind) const
  {
    return static_cast<int>(
        std::count_if(events.begin(), events.end(), [kind](const JointEvent &e) {
          return e.what == kind;
        }));
  }
  double sum(double EnergyLedger::*entry) const
  {
    double all = 0.0;
    for (const auto &r : ranks) all += r->ledger.*entry;
    return all;
  }
  double kinetic() const
  {
    double k = 0.0;
    for (std::size_t i = 0; i < x.size(); ++i) k += 0.5 * block.mass[i] * v[i].squaredNorm();
    return k;
  }
  double stored() const
  {
    double all = 0.0;
    for (const auto &r : ranks) all += r->stored.joints + r->stored.ties + r->stored.cohesive;
    return all;
  }

 private:
  std::vector<int> type;
  std::vector<std::int64_t> id;

  /// DEs of each rank to all others.
  template <class Pack, class Unpack> void forward(Pack pack, Unpack unpack)
  {
    std::vector<std::array<double, 64>> sent(block.des());
    for (auto &r : ranks)
      for (int d = 0; d < r->jt.nde; ++d) pack(*r, d, sent[r->block_de(d)].data());
    for (auto &r : ranks)
      for (int d = r->jt.nde; d < r->jt.nall; ++d) unpack(*r, d, sent[r->block_de(d)].data());
  }

  void decide()
  {
    std::vector<std::vector<double>> sent;
    for (auto &r : ranks) {
      r->states->cracks()->mark();
      sent.emplace_back(2 + r->jt.nde * JointCracks::STRESS_SIZE);
      r->states->cracks()->pack_stress(r->jt.nde, r->jt.self.data(), sent.back().data());
    }
    // a message is for particles one after the other: here each DE on its own
    for (std::size_t from = 0; from < ranks.size(); ++from)
      for (auto &to : ranks)
        if (to != ranks[from]) unpack_stress(*ranks[from], sent[from], *to);
    for (auto &r : ranks) r->states->decide_cracks();
  }
  static void unpack_stress(const JointRank &from, const std::vector<double> &sent, JointRank &to)
  {
    for (int m = 1; m < static_cast<int>(sent[0]); m += 1 + CrackStress::size) {
      std::array<double, 2 + CrackStress::size> one;
      one[0] = one.size();
      one[1] = 0.0;
      std::copy_n(&sent[m + 1], CrackStress::size, one.begin() + 2);
      to.states->cracks()->unpack_stress(from.jt.self[static_cast<int>(sent[m])], one.data());
    }
  }
};

}    // namespace defe::test

#endif
