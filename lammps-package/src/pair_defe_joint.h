/* -*- c++ -*- ----------------------------------------------------------
   DEFE: adaptive finite elements to bonded discrete elements for LAMMPS
   https://www.lammps.org/
   This software is distributed under the GNU General Public License.
------------------------------------------------------------------------- */

#ifdef PAIR_CLASS
// clang-format off
PairStyle(defe/joint,PairDefeJoint);
// clang-format on
#else

#ifndef LMP_PAIR_DEFE_JOINT_H
#define LMP_PAIR_DEFE_JOINT_H

#include "pair.h"

#include "defe/coupling/force_sums.h"
#include "defe/coupling/joint_laws.h"
#include "defe/coupling/joint_states.h"

#include <memory>

namespace LAMMPS_NS {

class DefeCrackHost;
class DefeSphereContacts;

/** Bonded spheres with the three joint types. The thin variants switch stages off. */
class PairDefeJoint : public Pair {
 public:
  PairDefeJoint(class LAMMPS *);
  ~PairDefeJoint() override;
  void compute(int, int) override;
  void settings(int, char **) override;
  void coeff(int, char **) override;
  void init_style() override;
  double init_one(int, int) override;
  void write_restart(FILE *) override;
  void read_restart(FILE *) override;
  void write_restart_settings(FILE *) override;
  void read_restart_settings(FILE *) override;
  int pack_forward_comm(int, int *, double *, int, int *) override;
  void unpack_forward_comm(int, int, double *) override;
  double memory_usage() override;

  /** Of slot s of DE d in DefeSystem::joints; of a cohesive joint, d is the DE of the lower ID. */
  defe::JointView view(int d, int s);

  uint64_t laws_checksum() const { return laws.checksum(); }

  /** Strength of the joints between DEs of this type (pair_coeff ... cohesive). */
  double joint_strength(int type) const { return laws.of(type, type).cohesive.sigma_t; }
  /** They are cut by cracks, not one by one. */
  bool cut_by_cracks(int type) const
  {
    return std::isfinite(laws.crack_strengths()[type * (laws.types + 1) + type]);
  }

  /** The laws of these joints. */
  const defe::CohesiveParameters &joint_law(int type) const { return laws.of(type, type).cohesive; }
  const defe::OpeningLaw &opening_law(int type) const { return laws.opening(laws.of(type, type)); }

 protected:
  defe::JointLaws laws;

 private:
  struct DefeSystem *sys = nullptr;
  std::unique_ptr<DefeCrackHost> crack_host;
  std::unique_ptr<defe::JointStates> states;
  std::unique_ptr<DefeSphereContacts> contacts;
  bigint tables_seen = -1;
  enum { FORCES, STATES, PARTS, CRACK_TABLE, CRACK_STRESS } message = FORCES;

  void allocate();
  void make_states();
  defe::MovingParticles particles() const;
  void forward(decltype(message), int size);
  void update_tables();
  void check_laws();
  void joint_forces(defe::ForceSums &);
  void strength_reached();
  void report();
  void record(const defe::JointEvent &);
  void contact_forces(const defe::VirialTally &);

  // ---- beside other particles and pair styles: pair_defe_others.cpp ----
  bool told_of_others = false;
  void map_types();
  void check_coefficients();
  void tell_of_other_spheres();
  double largest_met_by_others(int i) const;
};

}    // namespace LAMMPS_NS

#endif
#endif
