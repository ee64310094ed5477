/* ----------------------------------------------------------------------
   DEFE: adaptive finite elements to bonded discrete elements for LAMMPS
   https://www.lammps.org/
   This software is distributed under the GNU General Public License.
------------------------------------------------------------------------- */

#include "defe_strengths.h"

#include "defe_system.h"
#include "pair_defe_joint.h"

#include "atom.h"
#include "error.h"
#include "force.h"
#include "update.h"

#include "defe/coupling/joint_cracks.h"
#include "defe/fe/hex8.h"

#include <algorithm>
#include <cmath>

using namespace LAMMPS_NS;
using defe::Vec3;
using defe::fe::HexCoords;

/* ----------------------------------------------------------------------
   the flaws of DEs grow with the stress that cracks look at
------------------------------------------------------------------------- */

void DefeStrengths::check_growth() const
{
  const auto *pair = dynamic_cast<PairDefeJoint *>(force->pair_match("^defe/joint", 0));
  for (const DefePart &p : sys.model.parts)
    if (p.strength.growth.on() && (!pair || !pair->cut_by_cracks(p.type)))
      error->all(FLERR,
                 "Fix defe strength {} rate: flaws of DEs grow with the law rings of pair_style "
                 "defe/joint only: give pair_coeff {} {} without lattice, or leave out rate",
                 p.name, p.type, p.type);
}

/* ----------------------------------------------------------------------
   Tension at the end of a step stands for the steps since the last evaluation.
------------------------------------------------------------------------- */

void DefeStrengths::grow_elements()
{
  if (!growing_) return;
  const double dt = sys.clock.subcycle().every() * update->dt;
  for (size_t k = 0; k < batches.size(); k++)
    if (!batches[k].places.empty()) grow_batch(static_cast<int>(k), dt);
}

void DefeStrengths::grow_batch(int batch, double dt)
{
  const DefeBatch &b = sys.elements.batches()[batch];
  Batch &mine = batches[batch];
  const double share = sys.model.parts[b.part()].strength.growth.least_share() / mine.by_strength;
  const double *bound = b.bounds();
  for (int e = 0; e < b.size(); e++) {
    if (!(bound[e] > share * mine.limit[e])) continue;
    Places &all = *mine.places[e];
    grow_element(b, e, dt, all);
    mine.limit[e] = mine.by_strength * *std::min_element(all.begin(), all.end());
    mine.least = std::min(mine.least, mine.limit[e]);
  }
}

/* ----------------------------------------------------------------------
   with the tension at the centre, or each place with that at the Gauss point beside it (between Gauss points where it is
   at no corner)
------------------------------------------------------------------------- */

void DefeStrengths::grow_element(const DefeBatch &b, int e, double dt, Places &all) const
{
  const DefePart &p = sys.model.parts[b.part()];
  HexCoords x, X;
  sys.elements.kernel_coords(*b.hex[e], b.nodes(e).data(), x, X);
  Vec3 direction;
  double tension = 0.0;
  for (int c = 0; c < p.split.des(); c++) {
    if (sys.model.gauss_stress || c == 0) {
      const Vec3 xi = sys.model.gauss_stress ? p.split.sign(c) / std::sqrt(3.0)
                                             : Vec3(Vec3::Zero());
      tension = p.criterion->value(b.kernel().stress(x, X, xi), direction);
    }
    all[c] = p.strength.growth.weakened(all[c], tension, dt);
  }
}

/* ----------------------------------------------------------------------
   The owner of a DE lets its flaws grow; then all ranks that have the DE need its strength, and after that the
   energies below which nothing starts in it, which depend on its neighbours, too.
------------------------------------------------------------------------- */

void DefeStrengths::grow_des(defe::JointCracks &cracks)
{
  auto &jt = sys.joints;
  if (!growing_) return;
  std::vector<double> share;
  for (const DefePart &p : sys.model.parts)
    share.push_back(p.strength.growth.on() ? p.strength.growth.least_share() : HUGE_VAL);
  std::vector<defe::JointCracks::Tension> tensions;
  cracks.find_tensions(share, tensions);
  const double dt = sys.clock.subcycle().every() * update->dt;
  for (const auto &t : tensions) {
    const auto &growth = sys.model.parts[jt.material[t.de]].strength.growth;
    jt.strength[t.de] = growth.weakened(jt.strength[t.de], t.value, dt);
    of[jt.self[t.de]]->de = jt.strength[t.de];
  }
  now.value.assign(atom->nlocal + atom->nghost, HUGE_VAL);
  for (int d = 0; d < jt.nde; d++) now.value[jt.self[d]] = jt.strength[d];
  sys.ghosts.forward(now, 1);
  for (int d = jt.nde; d < jt.nall; d++) jt.strength[d] = now.value[jt.self[d]];
  cracks.strengths_fell();
  for (int d = 0; d < jt.nde; d++) now.value[jt.self[d]] = cracks.quiet_energy(d);
  sys.ghosts.forward(now, 1);
  for (int d = jt.nde; d < jt.nall; d++) cracks.set_quiet_energy(d, now.value[jt.self[d]]);
}
