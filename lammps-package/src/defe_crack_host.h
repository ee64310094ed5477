/* ----------------------------------------------------------------------
   DEFE: adaptive finite elements to bonded discrete elements for LAMMPS
   https://www.lammps.org/
   This software is distributed under the GNU General Public License.
------------------------------------------------------------------------- */

#ifndef LMP_DEFE_CRACK_HOST_H
#define LMP_DEFE_CRACK_HOST_H

#include "defe_component.h"

#include "defe/coupling/joint_cracks.h"

namespace LAMMPS_NS {

/** What cracks ask of the records of DEs and of the box. */
class DefeCrackHost : public defe::CrackHost, protected DefeComponent {
 public:
  using DefeComponent::DefeComponent;
  defe::CrackDE describe(int de) const override;
  void expect(int de) const override;
  std::vector<defe::JointCrack> *find_cracks(int de) const override;
  std::vector<defe::JointCrack> &cracks_of(int de) override;
  int nearest(int de, std::int64_t id) const override;
  defe::Vec3 half_periods() const override;
};

}    // namespace LAMMPS_NS

#endif
