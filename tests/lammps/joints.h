#ifndef DEFE_TEST_JOINTS_H
#define DEFE_TEST_JOINTS_H

// Every joint as the two DEs know it, read from the records of fix defe. Header only: the fix
// itself lives in the plugin.

#include "lammps_run.h"

#include "defe_system.h"

#include <array>
#include <map>
#include <utility>

namespace defe::test {

/// One of the six joint slots of a DE.
struct Joint {
  tagint self;
  int slot;
  int kind, state, pending;    // DefeJoint::Kind, DefeJoint::State
  tagint other;                // DE, or element of a tie
  int partner;
  double damage;    // kappa of the cohesive law: kept by the DE with the lower ID
};
using Joints = std::map<std::pair<tagint, int>, Joint>;

inline LAMMPS_NS::DefeSystem &defe_system(Lammps &lmp)
{
  int dim;
  auto *fix = lmp->modify->get_fix_by_id("fe");
  void *system = fix ? fix->extract("defe", dim) : nullptr;
  if (!system) throw std::runtime_error("no fix fe of style defe");
  return *static_cast<LAMMPS_NS::DefeSystem *>(system);
}

/// All slots with a joint or a tie, of all ranks, by (DE, slot).
inline Joints joints(Lammps &lmp)
{
  const auto &store = defe_system(lmp).store;
  std::vector<Joint> mine;
  for (int i = 0; i < lmp->atom->nlocal; i++) {
    const auto *de = store.de(i);
    if (!de) continue;
    for (int s = 0; s < 6; s++) {
      const auto &slot = de->slot[s];
      if (slot.kind == LAMMPS_NS::DefeJoint::NONE) continue;
      const bool softening =
          slot.state == LAMMPS_NS::DefeJoint::COHESIVE && lmp->atom->tag[i] < de->other[s];
      double kappa = softening ? de->soft->of[s].cohesive[5] : 0.0;
      if (const auto *touch = store.contacts_of(i))
        for (const auto &c : touch->cracks)
          if (softening && c.slot == s) kappa = c.law.kappa;
      mine.push_back({lmp->atom->tag[i], s, slot.kind, slot.state, slot.pending, de->other[s],
                      slot.partner, kappa});
    }
  }
  Joints result;
  for (const auto &j : lmp.gather(mine)) result[{j.self, j.slot}] = j;
  return result;
}

/// Both DEs of each joint know it, and in one state.
inline void expect_mutual(const Joints &all, const std::string &where)
{
  for (const auto &it : all) {
    const Joint &j = it.second;
    if (j.kind != LAMMPS_NS::DefeJoint::DE) continue;
    const auto back = all.find({j.other, j.partner});
    if (back == all.end() || back->second.other != j.self) {
      // a broken joint may outlive the DE on its other side
      EXPECT_EQ(j.state, LAMMPS_NS::DefeJoint::CONTACT)
          << where << ": DE " << j.self << " slot " << j.slot << " is joined to DE " << j.other
          << ", which does not know it";
      continue;
    }
    EXPECT_EQ(j.state, back->second.state) << where << ": DEs " << j.self << " and " << j.other;
  }
}

}    // namespace defe::test

#endif
