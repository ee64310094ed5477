/* ----------------------------------------------------------------------
   DEFE: adaptive finite elements to bonded discrete elements for LAMMPS
   https://www.lammps.org/
   This software is distributed under the GNU General Public License.
------------------------------------------------------------------------- */

#include "defe_system.h"
#include "lammps_releases.h"

#include "atom.h"
#include "comm.h"
#include "domain.h"
#include "error.h"
#include "fix.h"
#include "memory.h"
#include "neighbor.h"

#include "defe/coupling/ghost_reach.h"
#include "defe/fe/hex8.h"

#include <algorithm>

using namespace LAMMPS_NS;
using defe::fe::HexCoords;

/* ----------------------------------------------------------------------
   distance from its sub-domain to which a rank needs ghosts
------------------------------------------------------------------------- */

double DefeGhosts::reach(double ball_radius) const
{
  defe::GhostNeeds needs;
  needs.longest = longest_provided;
  needs.diagonal = sys.mesh.max_diagonal();
  needs.facet_diagonal = sys.mesh.max_facet();
  needs.largest_ball = ball_radius;
  needs.skin = neighbor->skin;
  needs.des = sys.census.des() > 0;
  needs.cracks = sys.marks.cracks_ask();
  needs.tied = sys.tied.on();
  needs.single = sys.model.any_single();
  needs.contact = sys.model.contact_factor > 0.0;
  return defe::ghost_reach(needs);
}

/* ----------------------------------------------------------------------
   more ghosts from the next exchange on, if elements have grown longer or there are DEs now
------------------------------------------------------------------------- */

void DefeGhosts::provide(double longest)
{
  double all = 0.0;
  MPI_Allreduce(&longest, &all, 1, MPI_DOUBLE, MPI_MAX, world);
  if (defe::ghosts::step_behind * all > longest_provided)
    longest_provided = defe::ghosts::growth * all;
  if (!raise()) return;
  comm->setup();
  if (neighbor->style) neighbor->setup_bins();
}

bool DefeGhosts::enough() const
{
  bool all = comm->cutghostuser >= reach();
  for (int t = 1; t <= atom->ntypes && by_type(); t++)
    all = all && comm->cutusermulti[neighbor->type2collection[t]] >= reach(ball[t]);
  return all;
}

/* ----------------------------------------------------------------------
   to what is needed now; false if that was there
------------------------------------------------------------------------- */

bool DefeGhosts::raise()
{
  if (enough()) return false;
  comm->cutghostuser = MAX(comm->cutghostuser, reach());
  for (int t = 1; t <= atom->ntypes && by_type(); t++) {
    double &cut = comm->cutusermulti[neighbor->type2collection[t]];
    cut = MAX(cut, reach(ball[t]));
  }
  return true;
}

/* ----------------------------------------------------------------------
   before a run: elements may be much longer than they were in the reference configuration, or
   have been moved by commands. Images do not matter: elements are shorter than half of a periodic box.
------------------------------------------------------------------------- */

void DefeGhosts::find_all_nodes()
{
  if (!any()) return;
  for (int attempt = 0; attempt < 5; attempt++) {
    make_for_setup();
    double longest = 0.0;
    int missing = longest_of_all(longest) ? 0 : 1, any = 0;
    MPI_Allreduce(&missing, &any, 1, MPI_INT, MPI_MAX, world);
    if (any) longest = MAX(longest, defe::ghosts::missing_node * longest_provided);
    provide(longest);
    if (!any) return;
  }
}

/* ----------------------------------------------------------------------
   distance between nodes of an element; false if one has a node that is not here
------------------------------------------------------------------------- */

bool DefeGhosts::longest_of_all(double &longest) const
{
  bool found = true;
  for (int i = 0; i < atom->nlocal; i++)
    for (const auto &h : sys.store.hexes(i)) {
      HexCoords now;
      bool complete = true;
      for (int a = 0; a < 8 && complete; a++) {
        const int j = sys.ids.local_of(h.node[a]);
        complete = j >= 0;
        if (!complete) break;
        double del[3];
        for (int d = 0; d < 3; d++) del[d] = atom->x[j][d] - atom->x[i][d];
        minimum_image(*domain, del);
        for (int d = 0; d < 3; d++) now(d, a) = del[d];
      }
      if (!complete)
        found = false;
      else
        longest = MAX(longest, defe::fe::max_diagonal(now));
    }
  return found;
}

/* ----------------------------------------------------------------------
   before the first setup there are no ghosts
------------------------------------------------------------------------- */

void DefeGhosts::make_for_setup()
{
  domain->pbc();
  domain->reset_box();
  comm->setup();
  if (neighbor->style) neighbor->setup_bins();
  comm->exchange();
  comm->borders();
}

/* ----------------------------------------------------------------------
   on a reneighbouring step LAMMPS does not update ghosts: they are still where they were a step ago.
   What follows needs current positions and velocities.
------------------------------------------------------------------------- */

void DefeGhosts::update_positions()
{
  Positions positions(atom);
  forward(positions, 6);
}

int DefeGhosts::Positions::pack_forward(int n, const int *list, const double *shift, double *buf)
{
  int m = 0;
  for (int ii = 0; ii < n; ii++) {
    for (int k = 0; k < 3; k++) buf[m++] = atom->x[list[ii]][k] + shift[k];
    for (int k = 0; k < 3; k++) buf[m++] = atom->v[list[ii]][k];
  }
  return m;
}

void DefeGhosts::Positions::unpack_forward(int n, int first, const double *buf)
{
  int m = 0;
  for (int i = first; i < first + n; i++) {
    for (int k = 0; k < 3; k++) atom->x[i][k] = buf[m++];
    for (int k = 0; k < 3; k++) atom->v[i][k] = buf[m++];
  }
}

void DefeGhosts::update_masses()
{
  Masses masses(atom);
  forward(masses, 1);
}

int DefeGhosts::Masses::pack_forward(int n, const int *list, const double *, double *buf)
{
  for (int ii = 0; ii < n; ii++) buf[ii] = atom->rmass[list[ii]];
  return n;
}

void DefeGhosts::Masses::unpack_forward(int n, int first, const double *buf)
{
  std::copy_n(buf, n, atom->rmass + first);
}

/* ----------------------------------------------------------------------
   messages, sent through the fix
------------------------------------------------------------------------- */

void DefeGhosts::forward(DefeMessage &m, int size)
{
  message = &m;
  comm->forward_comm(sys.host, size);
  message = nullptr;
}

void DefeGhosts::reverse(DefeMessage &m, int size)
{
  message = &m;
  comm->reverse_comm(sys.host, size);
  message = nullptr;
}

int DefeGhosts::pack_forward(int n, const int *list, double *buf, int pbc_flag, const int *pbc)
{
  if (n == 0) return 0;    // tiled ranks send empty messages, too
  double shift[3] = {0.0, 0.0, 0.0};
  if (pbc_flag) {
    shift[0] = pbc[0] * domain->xprd;
    shift[1] = pbc[1] * domain->yprd;
    shift[2] = pbc[2] * domain->zprd;
  }
  return message->pack_forward(n, list, shift, buf);
}

void DefeGhosts::unpack_forward(int n, int first, const double *buf)
{
  if (n > 0) message->unpack_forward(n, first, buf);
}

int DefeGhosts::pack_reverse(int n, int first, double *buf)
{
  return message->pack_reverse(n, first, buf);
}

void DefeGhosts::unpack_reverse(int n, const int *list, const double *buf)
{
  message->unpack_reverse(n, list, buf);
}

/* ----------------------------------------------------------------------
   elements, joints and facets need their nodes as ghosts, and facets the balls that can reach them
------------------------------------------------------------------------- */

void DefeGhosts::find_largest_ball()
{
  std::vector<double> mine(atom->ntypes + 1, 0.0);
  ball.assign(atom->ntypes + 1, 0.0);
  largest_ball_ = 0.0;
  if (!sys.model.contact()) return;
  for (int i = 0; i < atom->nlocal; i++) {
    double &largest = mine[atom->type[i]];
    if (!sys.store.de(i)) largest = MAX(largest, atom->radius[i]);
  }
  MPI_Allreduce(mine.data(), ball.data(), atom->ntypes + 1, MPI_DOUBLE, MPI_MAX, world);
  for (int t = 1; t <= atom->ntypes; t++) {
    ball[t] = MAX(ball[t], sys.checks.radius_to_come(t));
    largest_ball_ = MAX(largest_ball_, ball[t]);
  }
}

void DefeGhosts::set_cutoff()
{
  longest_provided = MAX(longest_provided, defe::ghosts::growth * sys.mesh.max_diagonal());
  const double cut = reach();
  if (comm->cutghostuser >= cut) return;
  if (comm->me == 0 && comm->cutghostuser > 0.0)
    error->warning(FLERR, "Communication cutoff raised from {} to {} for fix defe",
                   comm->cutghostuser, cut);
  comm->cutghostuser = cut;
}

bool DefeGhosts::by_type() const
{
  return comm->mode == Comm::MULTI;
}

bool DefeGhosts::any() const
{
  return comm->nprocs > 1 || domain->xperiodic || domain->yperiodic || domain->zperiodic;
}

/* ----------------------------------------------------------------------
   Contacts of balls are computed where the facet or the DE is: all ranks that a ball reaches must know it, but
   its own rank need not know the nodes and DEs around it. In the mode multi each collection of types has its own distance.
------------------------------------------------------------------------- */

void DefeGhosts::set_cutoff_of_types()
{
  if (!by_type()) return tell_of_mode();
  // LAMMPS takes the larger of both, with a warning where this one is less
  comm->cutghostuser = MAX(comm->cutghostuser, neighbor->cutneighmax);
  if (!comm->cutusermulti || comm->ncollections_cutoff != neighbor->ncollections) {
    memory->destroy(comm->cutusermulti);
    comm->ncollections_cutoff = neighbor->ncollections;
    memory->create(comm->cutusermulti, comm->ncollections_cutoff, "comm:cutusermulti");
    std::fill_n(comm->cutusermulti, comm->ncollections_cutoff, 0.0);
  }
  raise();
}

/* ----------------------------------------------------------------------
   one ball can make ghosts of half of a body
------------------------------------------------------------------------- */

void DefeGhosts::tell_of_mode()
{
  constexpr double worth_it = 1.5;
  const double small = reach(0.0), large = MAX(comm->cutghostuser, neighbor->cutneighmax);
  if (told_of_mode || !any() || large < worth_it * small || largest_ball_ == 0.0) return;
  told_of_mode = true;
  if (comm->me == 0)
    utils::logmesg(
        lmp,
        "Note: ghosts of all atoms reach {:.4g}, since balls are that large; with 'neighbor {:.8g} "
        "multi' and 'comm_modify mode multi reduce/multi vel yes' those of nodes and DEs "
        "reach {:.4g}\n",
        large, neighbor->skin, small);
}

double DefeGhosts::provided() const
{
  return longest_provided / defe::ghosts::step_behind;
}
