/* ----------------------------------------------------------------------
   DEFE: adaptive finite elements to bonded discrete elements for LAMMPS
   https://www.lammps.org/
   This software is distributed under the GNU General Public License.
------------------------------------------------------------------------- */

#include "defe_crack_host.h"

#include "defe_system.h"

#include "atom.h"
#include "domain.h"

#include <cmath>

using namespace LAMMPS_NS;

defe::CrackDE DefeCrackHost::describe(int de) const
{
  const DERecord &r = *sys.joints.rec(de);
  const int i = sys.joints.self[de];
  const auto split = sys.model.parts[r.part].split;
  defe::CrackDE out{split.outer_slots(r.corner), 0, r.part, r.volume, {}};
  domain->unmap(sys.store.x_frame(i), atom->image[i], out.place.data());
  for (int s = 0; s < 6; s++) {
    const JointRecord &slot = r.slot[s];
    if (split.des() > 1 || slot.kind == DefeJoint::NONE) continue;
    const int first = defe::fe::hex_face_position(slot.partner, slot.corner);
    out.turned = static_cast<uint16_t>(out.turned | first << 2 * s);
  }
  return out;
}

void DefeCrackHost::expect(int de) const
{
  prefetch(sys.joints.rec(de));
  __builtin_prefetch(sys.store.contacts_of(sys.joints.self[de]));
}

std::vector<defe::JointCrack> *DefeCrackHost::find_cracks(int de) const
{
  AtomContacts *t = sys.store.contacts_of(sys.joints.self[de]);
  return t ? &t->cracks : nullptr;
}

std::vector<defe::JointCrack> &DefeCrackHost::cracks_of(int de)
{
  return sys.store.contacts_at(sys.joints.self[de]).cracks;
}

int DefeCrackHost::nearest(int de, std::int64_t id) const
{
  return sys.ids.nearest_to(sys.joints.self[de], static_cast<tagint>(id));
}

/* ----------------------------------------------------------------------
   of its two ends the nearest image may be that of another side of a periodic box: joints are shorter than half of it
------------------------------------------------------------------------- */

defe::Vec3 DefeCrackHost::half_periods() const
{
  defe::Vec3 half;
  for (int k = 0; k < 3; k++) half[k] = domain->periodicity[k] ? 0.5 * domain->prd[k] : HUGE_VAL;
  return half;
}
