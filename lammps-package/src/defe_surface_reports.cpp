/* ----------------------------------------------------------------------
   DEFE: adaptive finite elements to bonded discrete elements for LAMMPS
   https://www.lammps.org/
   This software is distributed under the GNU General Public License.
------------------------------------------------------------------------- */

// What contacts have met, in words: on all ranks together, each kind once.

#include "defe_system.h"

#include "atom.h"
#include "comm.h"
#include "error.h"
#include "fix.h"
#include "update.h"

#include <cmath>

using namespace LAMMPS_NS;

// A ball may begin this deep in a face, in radii: a rounding of the mesh or a ball that rests, not a mistake.
static constexpr double BALL_SHARE = 0.01;

/* ----------------------------------------------------------------------
   points that are deeper than contact can follow: the first one is reported, all are counted
------------------------------------------------------------------------- */

void DefeSurface::note_let_through(int i, double depth)
{
  through_count++;
  if (first_through.step >= 0) return;
  first_through.step = update->ntimestep;
  first_through.tag = atom->tag[i];
  first_through.depth = depth;
  for (int k = 0; k < 3; k++) first_through.x[k] = atom->x[i][k];
}

/* ----------------------------------------------------------------------
   before the first step
------------------------------------------------------------------------- */

void DefeSurface::note_overlaps(const defe::SurfaceResult &r, bool moving)
{
  if (!moving && r.offset_count > 0) {
    overlaps += r.offset_count;
    if (r.offset_max > overlap_depth) {
      overlap_depth = r.offset_max;
      overlap_tag = atom->tag[r.offset_atom];
    }
  }
  if (!balls_placed && r.ball_atom >= 0) {
    ball_energy = r.ball_energy;
    ball_depth = r.ball_depth;
    ball_share = ball_depth / atom->radius[r.ball_atom];
    ball_tag = atom->tag[r.ball_atom];
  }
  balls_placed = true;
}

/* ---------------------------------------------------------------------- */

void DefeSurface::report()
{
  bigint mine[2] = {through_count, overlaps}, all[2];
  MPI_Allreduce(mine, all, 2, MPI_LMP_BIGINT, MPI_SUM, world);
  through_total = all[0];
  if (all[0] > 0 && !through_told) report_let_through();
  if (all[1] > 0 && !overlaps_told) report_overlaps(all[1]);
  if (balls_placed && !balls_told) report_balls();
}

void DefeSurface::report_let_through()
{
  through_told = true;
  // the first one, of all ranks
  struct {
    double step;
    int rank;
  } first = {first_through.step < 0 ? HUGE_VAL : static_cast<double>(first_through.step), comm->me},
    winner;
  MPI_Allreduce(&first, &winner, 1, MPI_DOUBLE_INT, MPI_MINLOC, world);
  MPI_Bcast(&first_through, sizeof(first_through), MPI_BYTE, winner.rank, world);
  if (comm->me == 0)
    error->warning(
        FLERR,
        "Contact of fix defe: atom {} got {:.4g} deep at step {} near {:.6g} {:.6g} {:.6g}, "
        "deeper "
        "than contact reaches, and is let through: raise the factor of contact, or take smaller "
        "elements or a smaller timestep (all cases are counted in entry 29 of f_{})",
        first_through.tag, first_through.depth, first_through.step, first_through.x[0],
        first_through.x[1], first_through.x[2], sys.host->id);
}

void DefeSurface::report_overlaps(bigint count)
{
  overlaps_told = true;
  struct {
    double depth;
    int rank;
  } deepest = {overlap_depth, comm->me}, winner;
  MPI_Allreduce(&deepest, &winner, 1, MPI_DOUBLE_INT, MPI_MAXLOC, world);
  tagint tag = overlap_tag;
  MPI_Bcast(&tag, 1, MPI_LMP_TAGINT, winner.rank, world);
  if (sys.model.refuse_overlaps)
    error->all(
        FLERR,
        "Contact of fix defe: {} contacts overlap before the first step, the deepest by {:.4g} "
        "(atom {}): "
        "move the bodies apart, or let overlaps be eased out with 'contact {} overlap ease'",
        count, winner.depth, tag, sys.model.contact_factor);
  if (comm->me == 0)
    error->warning(FLERR,
                   "Contact of fix defe: {} contacts overlap before the first step, the deepest "
                   "by {:.4g} (atom "
                   "{}); they are eased out, and the work of that counts as external",
                   count, winner.depth, tag);
}

/* ----------------------------------------------------------------------
   a ball that begins in a face: it has no memory by which it could be eased out, and what is deep would
   throw it out with energy from nothing
------------------------------------------------------------------------- */

void DefeSurface::report_balls()
{
  balls_told = true;
  struct {
    double depth;
    int rank;
  } mine = {ball_depth, comm->me}, deepest;
  MPI_Allreduce(&mine, &deepest, 1, MPI_DOUBLE_INT, MPI_MAXLOC, world);
  if (deepest.depth == 0.0) return;
  double energy;
  MPI_Allreduce(&ball_energy, &energy, 1, MPI_DOUBLE, MPI_SUM, world);
  MPI_Bcast(&ball_tag, 1, MPI_LMP_TAGINT, deepest.rank, world);
  MPI_Bcast(&ball_share, 1, MPI_DOUBLE, deepest.rank, world);
  const auto what = fmt::format("Contact of fix defe: ball {} begins {:.4g} deep in a face",
                                ball_tag, deepest.depth);
  if (sys.model.refuse_overlaps) error->all(FLERR, "{}: move it out", what);
  if (ball_share > BALL_SHARE && !sys.model.ease_overlaps)
    error->all(FLERR,
               "{}, {:.3g} % of its radius: it would be thrown out with the energy {:.4g} that "
               "contacts of balls store; move it out (or write 'contact {} overlap ease')",
               what, 100.0 * ball_share, energy, sys.model.contact_factor);
  if (comm->me == 0)
    error->warning(FLERR,
                   "{}: what contacts of balls store at the start, {:.4g}, throws them out; move "
                   "balls out of the body",
                   what, energy);
}

/* ----------------------------------------------------------------------
   restart files
------------------------------------------------------------------------- */

bigint DefeSurface::all_let_through() const
{
  bigint sum = 0;
  MPI_Reduce(&through_count, &sum, 1, MPI_LMP_BIGINT, MPI_SUM, 0, world);
  return sum;
}

void DefeSurface::go_on(bigint let_through, bool started)
{
  if (comm->me == 0) through_count = let_through;
  overlaps_told = balls_placed = started;
  through_told = let_through > 0;
}
