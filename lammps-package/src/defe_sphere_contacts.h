/* ----------------------------------------------------------------------
   DEFE: adaptive finite elements to bonded discrete elements for LAMMPS
   https://www.lammps.org/
   This software is distributed under the GNU General Public License.
------------------------------------------------------------------------- */

#ifndef LMP_DEFE_SPHERE_CONTACTS_H
#define LMP_DEFE_SPHERE_CONTACTS_H

#include "defe_component.h"

#include "defe/coupling/contact_law.h"
#include "defe/coupling/force_sums.h"
#include "defe/coupling/joint_laws.h"
#include "defe/coupling/normal_law.h"

#include <utility>
#include <vector>

namespace LAMMPS_NS {

struct SphereContact;

/** Contact of DEs that no joint holds, with each other and with other spheres. */
class DefeSphereContacts : protected DefeComponent {
 public:
  DefeSphereContacts(DefeSystem &, const defe::JointLaws &);

  /** The tables have changed since the last search: materials of ghosts are to be sent before the next. */
  bool outdated() const;
  void search();
  /** A joint broke: its two DEs may touch. distance: see SoftJoint::contact_distance. */
  void add(int i, int j, double distance = 0.0);
  void forces(const defe::VirialTally &);
  double memory_usage() const;

 private:
  const defe::JointLaws &laws;
  bigint built = -1;    // tables of the last search
  struct Candidate {
    int i, j;              // i is owned; j too and above i, or a ghost
    double distance;       // of a broken joint: see SoftJoint::contact_distance
    bool apart = false;    // they have no records of each other
  };
  std::vector<Candidate> candidates;
  std::vector<std::pair<tagint, tagint>> broken_now;    // DEs whose joint broke in this step

  void consider(int i, int j);
  bool joined(int de, int j) const;
  double reach_of(const Candidate &, double rsq) const;
  defe::DEMaterial material_of(int i) const;
  defe::NormalSpring spring_of(int i, int j, double reach, double overlap) const;
  defe::ContactParameters parameters(int i, int j, const defe::NormalSpring &) const;
  void contact(Candidate &, const defe::VirialTally &);
  void book(int i, int j, double share, const defe::ContactResult &);
  void contact_with_ball(int i, int j, const defe::VirialTally &);

  SphereContact *find_contact(int i, int j) const;
  SphereContact &new_contact(int i, int j);
  defe::TangentialSpring &spring(int i, int j);
  double forget_contact(int i, int j);
};

}    // namespace LAMMPS_NS

#endif
