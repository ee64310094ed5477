/* ----------------------------------------------------------------------
   DEFE: adaptive finite elements to bonded discrete elements for LAMMPS
   https://www.lammps.org/
   This software is distributed under the GNU General Public License.
------------------------------------------------------------------------- */

#include "defe_system.h"

#include "atom.h"
#include "domain.h"
#include "error.h"
#include "output.h"
#include "thermo.h"
#include "update.h"

#include <cmath>
#include <limits>

using namespace LAMMPS_NS;
using defe::fe::HexCoords;

// change of the length of an edge or diagonal of a rigid element
static constexpr double RIGID_LIMIT = 0.01;

/* ----------------------------------------------------------------------
   does any node or DE move faster than anything physical?
------------------------------------------------------------------------- */

void DefeWatch::speed() const
{
  const double *v = atom->nlocal ? atom->v[0] : nullptr;
  const double limit = sys.mesh.max_step_length() / update->dt;
  int beyond = 0;
  for (int i = 0; i < 3 * atom->nlocal; i++) beyond += !(std::abs(v[i]) <= limit);
  if (beyond) stop_exploded();
}

/* ----------------------------------------------------------------------
   part and element of an atom, in words
------------------------------------------------------------------------- */

std::string DefeWatch::describe(int i) const
{
  const double *x = atom->x[i], *X = sys.store.x_ref(i);
  std::string where = fmt::format(" at {:.6g} {:.6g} {:.6g} (reference {:.6g} {:.6g} {:.6g})", x[0],
                                  x[1], x[2], X[0], X[1], X[2]);
  if (sys.store.de(i))
    return fmt::format("DE {} of element {} of part {}", atom->tag[i], sys.store.de(i)->element,
                       sys.model.parts[sys.store.de(i)->part].name) +
        where;
  for (const auto &b : sys.elements.batches())
    for (int e = 0; e < b.size(); e++)
      for (int a : b.nodes(e))
        if (a == i)
          return fmt::format("Node {} of element {} of part {}", atom->tag[i], b.hex[e]->id,
                             sys.model.parts[b.hex[e]->part].name) +
              where;
  return fmt::format("{} {}", sys.store.elements_at(i) > 0 ? "Node" : "Atom", atom->tag[i]) + where;
}

/* ----------------------------------------------------------------------
   an atom that moves by a quarter of an edge in one step, or whose position is not a number: the run has become
   unstable. The message names the fastest one.
------------------------------------------------------------------------- */

void DefeWatch::stop_exploded() const
{
  const double limit = sys.mesh.max_step_length() / update->dt;
  int worst = -1;
  double fastest = 0.0;
  for (int i = 0; i < atom->nlocal; i++) {
    if (!sys.store.is_ours(i)) continue;
    const double *v = atom->v[i], *f = atom->f[i], *x = atom->x[i];
    const double speed = std::sqrt(v[0] * v[0] + v[1] * v[1] + v[2] * v[2]);
    const bool lost = !std::isfinite(speed + f[0] + f[1] + f[2] + x[0] + x[1] + x[2]);
    if (!lost && !(speed > MAX(limit, fastest))) continue;
    worst = i;
    fastest = speed;
    if (lost) break;
  }
  if (worst < 0) return;
  if (fastest > limit)
    error->one(
        FLERR,
        "{} moves by {:.4g} per step at step {}, more than a quarter of the shortest edge: the "
        "run has become unstable; use a smaller timestep, or look at what pushes it",
        describe(worst), fastest * update->dt, update->ntimestep);
  error->one(
      FLERR,
      "{} has a position, velocity or force that is not a number at step {}: the run has become "
      "unstable; use a smaller timestep, or look at what pushes it",
      describe(worst), update->ntimestep);
}

/* ----------------------------------------------------------------------
   LAMMPS deletes atoms that leave through a fixed wall of the box and says how many.
   They are reported before that, while they are still here. Loose DEs may go if the user says so
   (thermo_modify lost ignore or warn).
------------------------------------------------------------------------- */

void DefeWatch::walls()
{
  // a cheap test first

  double lo[3], hi[3];
  for (int d = 0; d < 3; d++) {
    lo[d] = domain->boundary[d][0] == 1 ? domain->boxlo[d] : -std::numeric_limits<double>::max();
    hi[d] = domain->boundary[d][1] == 1 ? domain->boxhi[d] : HUGE_VAL;
  }
  const double *all = atom->nlocal ? atom->x[0] : nullptr;
  int outside = 0;
  for (int i = 0; i < atom->nlocal; i++)
    for (int d = 0; d < 3; d++) outside += !(all[3 * i + d] >= lo[d] && all[3 * i + d] < hi[d]);
  if (!outside) return;

  const bool may_go = output->thermo && output->thermo->lostflag != Thermo::ERROR;
  for (int i = 0; i < atom->nlocal; i++) {
    if (!sys.store.is_ours(i)) continue;
    const double *x = atom->x[i];
    int out = -1;
    for (int d = 0; d < 3; d++) {
      if (domain->periodicity[d]) continue;
      if (domain->boundary[d][0] == 1 && !(x[d] >= domain->boxlo[d])) out = d;
      if (domain->boundary[d][1] == 1 && !(x[d] < domain->boxhi[d])) out = d;
      if (!std::isfinite(x[d])) out = d;
    }
    if (out < 0) continue;
    const bool loose = sys.store.is_loose(i);
    if (!may_go || !loose)
      error->one(
          FLERR,
          "{} has left the box through its wall in {} at step {}: make the box larger or its "
          "boundary s or m{}",
          describe(i), "xyz"[out], update -> ntimestep,
          loose ? ", or let fragments go with thermo_modify lost ignore" : "");
    sys.census.let_go(atom->rmass[i]);
    sys.ledger.external -= sys.work.kinetic_energy(i);    // it takes its energy along
  }
}

/* ---------------------------------------------------------------------- */

void DefeWatch::rigid_elements() const
{
  HexCoords x, X;
  for (const auto &b : sys.elements.batches()) {
    if (!b.rigid()) continue;
    for (int e = 0; e < b.size(); e++) {
      sys.elements.coords(b.nodes(e).data(), x, X);
      double worst = 0.0;
      for (int a = 1; a < 8; a++) {    // from the first node: edges and diagonals
        const double length = (X.col(a) - X.col(0)).norm();
        worst = MAX(worst, std::abs((x.col(a) - x.col(0)).norm() - length) / length);
      }
      if (worst <= RIGID_LIMIT) continue;
      error->one(
          FLERR,
          "Element {} of the rigid part {} has changed its shape by {:.3g} % at step {}: its "
          "nodes must move as one body, by fix rigid or fix move",
          b.hex[e]->id, sys.model.parts[b.hex[e]->part].name, 100.0 * worst, update->ntimestep);
    }
  }
}
