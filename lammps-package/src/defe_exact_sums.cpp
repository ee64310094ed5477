/* ----------------------------------------------------------------------
   DEFE: adaptive finite elements to bonded discrete elements for LAMMPS
   https://www.lammps.org/
   This software is distributed under the GNU General Public License.
------------------------------------------------------------------------- */

// reproducible yes: the same bits on any number of ranks. Forces and torques are sums of multiples of
// one quantum, which are exact (defe/exact_sum.h); every contribution is computed by one formula from
// the same numbers, wherever that is done; what depends on a whole mesh is rounded before it is summed.

#include "defe_system.h"
#include "style_names.h"

#include "atom.h"
#include "comm.h"
#include "error.h"
#include "fix.h"
#include "force.h"
#include "modify.h"
#include "update.h"

#include <algorithm>
#include <cmath>

using namespace LAMMPS_NS;

/* ----------------------------------------------------------------------
   quanta from the largest force that an element bears before it is turned inside out
   From what a restart file keeps, so that a restart gets the same ones.
------------------------------------------------------------------------- */

void DefeExactSums::make_grids()
{
  if (sys.mesh.largest_force() > 0.0) {
    const double force =
        MAX(1.0, sys.model.contact_factor) * sys.mesh.largest_force();    // contacts may be stiffer
    rounding_.set_grids(
        defe::sum_grid(force),
        defe::sum_grid(force * MAX(sys.mesh.max_diagonal(), 2.0 * sys.ghosts.largest_ball())));
  }
  set_beyond(-1);
  note_unreproducible();
}

/* ----------------------------------------------------------------------
   what LAMMPS does in an order, or with a rounding, that depends on the ranks
------------------------------------------------------------------------- */

void DefeExactSums::note_unreproducible() const
{
  if (comm->me) return;
  std::string others;
  for (const auto *ifix : modify->get_fix_list()) {
    static const char *const sums[] = {"^rigid",    "^poems",   "^nvt",          "^npt",
                                       "^nph",      "^temp/",   "^press/",       "^momentum",
                                       "^recenter", "^spring$", "^spring/couple"};
    if (one_of(sums, ifix->style))
      others += fmt::format("{}fix {} {}", others.empty() ? "" : ", ", ifix->id, ifix->style);
  }
  // it takes all positions to reduced coordinates and back
  if (comm->nprocs > 1 && comm->style == Comm::BRICK) {
    const bool fix = !modify->get_fix_by_style("^balance").empty();
    if (fix || comm->layout == Comm::LAYOUT_NONUNIFORM)
      others += fmt::format("{}{}", others.empty() ? "" : ", ",
                            fix ? "fix balance with shift" : "the command balance, if with shift");
  }
  if (force->pair_style && utils::strmatch(force->pair_style, "^hybrid"))
    others += fmt::format("{}the other styles of pair_style {}", others.empty() ? "" : ", ",
                          force->pair_style);
  if (others.empty()) return;
  error->warning(
      FLERR,
      "Fix defe reproducible: LAMMPS' own sums and roundings depend on the ranks in {}: what "
      "these act on, and what it touches, is the same to rounding only",
      others);
}

/* ----------------------------------------------------------------------
   a force that is too large to be summed exactly ends the run; sums: those of all, after the ghosts'
   have arrived
------------------------------------------------------------------------- */

void DefeExactSums::check_range(bool sums)
{
  const int n = sums && force_grid().on() ? 3 * atom->nlocal : 0;
  if (n > 0) {
    const double *f = atom->f[0], *torque = atom->torque[0];
    const double most[2] = {8.0 * force_grid().limit, 8.0 * torque_grid().limit};
    int count = 0;
    for (int i = 0; i < n; i++) count += std::abs(f[i]) > most[0];
    for (int i = 0; i < n; i++) count += std::abs(torque[i]) > most[1];
    for (int i = 0; i < n && count; i++)
      if (std::abs(f[i]) > most[0] || std::abs(torque[i]) > most[1]) set_beyond(i / 3);
  }
  const int i = rounding_.beyond();
  if (i < 0) return;
  const double *x = atom->x[i];
  error->one(
      FLERR,
      "A force on atom {} at step {} near {:.6g} {:.6g} {:.6g} is too large for the exact sums "
      "of fix defe reproducible (limit {:.4g}): the run comes apart, use a smaller timestep, "
      "or do without reproducible",
      atom->tag[i], update->ntimestep, x[0], x[1], x[2], force_grid().limit);
}
