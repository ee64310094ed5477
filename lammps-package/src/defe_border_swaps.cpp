/* ----------------------------------------------------------------------
   DEFE: adaptive finite elements to bonded discrete elements for LAMMPS
   https://www.lammps.org/
   This software is distributed under the GNU General Public License.
------------------------------------------------------------------------- */

#include "defe_border_swaps.h"

#include "defe_system.h"
#include "lammps_protected.h"

#include "atom_vec.h"
#include "domain.h"
#include "fix.h"
#include "modify.h"

#include <algorithm>

using namespace LAMMPS_NS;
using namespace LAMMPS_NS::Protected;

static constexpr int EXCHANGE_ROOM =
    1024;    // more than an atom without what fixes add, as in comm_brick.cpp

/* ----------------------------------------------------------------------
   as CommBrick::exchange(): dimension by dimension, to both sides, and those stay that lie in the sub-domain
------------------------------------------------------------------------- */

std::vector<double> DefeBorderSwaps::send_home(int first)
{
  sys.store.update_maxexchange();
  int most = atom->avec->maxexchange + EXCHANGE_ROOM;
  for (const auto *ifix : modify->get_fix_list()) most += ifix->maxexchange;
  std::vector<double> atoms;
  for (int i = atom->nlocal - 1; i >= first; i--) {
    if (!is_other_ranks(atom->x[i])) continue;
    const size_t at = atoms.size();
    atoms.resize(at + most);
    atoms.resize(at + atom->avec->pack_exchange(i, &atoms[at]));
    if (i < atom->nlocal - 1)
      atom->avec->copy(atom->nlocal - 1, i, 1);
    else
      sys.store.forget(i);
    atom->nlocal--;
  }

  for (int d = 0; d < 3; d++) {
    if (comm->procgrid[d] == 1) continue;
    std::vector<double> out, stay;
    const auto sort = [&](const std::vector<double> &from, std::vector<double> *others) {
      for (size_t m = 0; m < from.size();) {
        const size_t end = m + static_cast<size_t>(from[m]);
        auto *const to = is_mine(from[m + 1 + d], d) ? &stay : others;
        if (to) to->insert(to->end(), from.begin() + m, from.begin() + end);
        m = end;
      }
    };
    sort(atoms, &out);
    for (int back = 0; back < (comm->procgrid[d] > 2 ? 2 : 1); back++)
      sort(pass_on(out, comm->procneigh[d][back], comm->procneigh[d][1 - back]), nullptr);
    atoms = std::move(stay);
  }
  return atoms;
}

/** In the sub-domain along this dimension, or beyond a border that no other rank is behind. */
bool DefeBorderSwaps::is_mine(double x, int d) const
{
  const bool low = comm->myloc[d] > 0 || domain->periodicity[d];
  const bool high = comm->myloc[d] < comm->procgrid[d] - 1 || domain->periodicity[d];
  return !(low && x < domain->sublo[d]) && !(high && x >= domain->subhi[d]);
}

bool DefeBorderSwaps::is_other_ranks(const double *x) const
{
  for (int d = 0; d < 3; d++)    // with one rank a periodic border is wrapped around
    if (comm->procgrid[d] > 1 && !is_mine(x[d], d)) return true;
  return false;
}

std::vector<double> DefeBorderSwaps::pass_on(const std::vector<double> &out, int to, int from) const
{
  const int n = static_cast<int>(out.size());
  int coming = 0;
  MPI_Sendrecv(&n, 1, MPI_INT, to, 0, &coming, 1, MPI_INT, from, 0, world, MPI_STATUS_IGNORE);
  std::vector<double> in(coming);
  MPI_Sendrecv(out.data(), n, MPI_DOUBLE, to, 0, in.data(), coming, MPI_DOUBLE, from, 0, world,
               MPI_STATUS_IGNORE);
  return in;
}

/* ----------------------------------------------------------------------
   The order is that of CommBrick::borders(): the first two swaps of a dimension send what is here, with ghosts of the dimensions
   before; later ones what has come with the two before.
------------------------------------------------------------------------- */

void DefeBorderSwaps::edit(int born, double wider)
{
  brick = static_cast<CommBrick *>(comm);
  const int swaps = Swaps::count(brick);
  ghosts = atom->nghost;
  ghosts_came = 0;
  gone.assign(ghosts, 0);
  came.assign(swaps, {0, 0});
  lists.assign(swaps, {});

  int s = 0;
  for (int dim = 0; dim < 3; dim++) {
    int since = 0;    // of the ghosts that have come
    for (int pair = 0; pair < Swaps::pairs(brick, dim); pair++) {
      std::vector<int> candidates;
      for (int i = born; i < atom->nlocal && pair == 0; i++) candidates.push_back(i);
      for (int k = since; k < ghosts_came; k++) candidates.push_back(atom->nlocal + ghosts + k);
      since = ghosts_came;
      for (int back = 0; back < 2; back++, s++) {
        std::vector<int> add;
        if (pair < Swaps::pairs_sent(brick, dim, back))
          for (int i : candidates) {
            const double x = atom->x[i][dim];
            const int type = atom->type[i];
            if (x >= Swaps::low(brick, neighbor, s, type) - wider &&
                x <= Swaps::high(brick, neighbor, s, type) + wider)
              add.push_back(i);
          }
        exchange(s, add);
      }
    }
  }
  arrange();
}

/* ----------------------------------------------------------------------
   one swap: entries of its list that have gone, and atoms that are new in it; what comes is put behind all ghosts
------------------------------------------------------------------------- */

void DefeBorderSwaps::exchange(int s, std::vector<int> &add)
{
  auto &list = lists[s];
  std::vector<double> message(2);    // how many have gone and are new, those, these
  for (int k = 0; k < Swaps::sent(brick, s); k++) {
    const int i = Swaps::list(brick, s)[k];
    if (i == GONE || (i >= atom->nlocal && gone[i - atom->nlocal]))
      message.push_back(ubuf(k).d);
    else
      list.push_back(i);
  }
  list.insert(list.end(), add.begin(), add.end());
  const size_t at = message.size();
  message[0] = ubuf(static_cast<int>(at - 2)).d;
  message[1] = ubuf(static_cast<int>(add.size())).d;
  message.resize(at + add.size() * Swaps::size_of_atom(brick));
  atom->avec->pack_border_vel(static_cast<int>(add.size()), add.data(), message.data() + at,
                              Swaps::across(brick, s), Swaps::shift(brick, s));
  if (Swaps::to(brick, s) != comm->me)
    message = pass_on(message, Swaps::to(brick, s), Swaps::from(brick, s));

  const int lost = static_cast<int>(ubuf(message[0]).i),
            came_now = static_cast<int>(ubuf(message[1]).i);
  const int first = Swaps::first(brick, s) - atom->nlocal;
  for (int k = 0; k < lost; k++) gone[first + static_cast<int>(ubuf(message[2 + k]).i)] = 1;
  came[s] = {ghosts_came, came_now};
  atom->avec->unpack_border_vel(came_now, atom->nlocal + ghosts + ghosts_came,
                                message.data() + 2 + lost);
  ghosts_came += came_now;
}

/* ----------------------------------------------------------------------
   the ghosts of a swap lie behind each other: those that have gone are closed up, those that have come are put behind the
   others of their swap
------------------------------------------------------------------------- */

void DefeBorderSwaps::arrange()
{
  const int nlocal = atom->nlocal, end = nlocal + ghosts;
  now.assign(ghosts + ghosts_came, -1);
  int place = nlocal;
  for (int s = 0; s < Swaps::count(brick); s++) {
    const int first = place, before = Swaps::first(brick, s) - nlocal;
    for (int g = before; g < before + Swaps::received(brick, s); g++)
      if (!gone[g]) now[g] = place++;
    for (int k = 0; k < came[s].count; k++) now[ghosts + came[s].first + k] = place++;
    Swaps::set_received(brick, s, first, place - first);
  }
  for (int s = 0; s < Swaps::count(brick); s++) {
    for (int &i : lists[s])
      if (i >= nlocal) i = now[i - nlocal];
    Swaps::set_sent(brick, s, lists[s]);
  }
  Swaps::make_room(brick);

  std::vector<tagint> ids_gone;
  for (int g = 0; g < ghosts; g++)
    if (gone[g]) ids_gone.push_back(atom->tag[nlocal + g]);
  const int aside = end + ghosts_came;
  if (aside + ghosts_came > atom->nmax) atom->avec->grow(DefeInPlace::roomy(aside + ghosts_came));
  for (int k = 0; k < ghosts_came; k++) atom->avec->copy(end + k, aside + k, 0);
  // their order stays: who moves down takes a place that has been left by one that does so, too, and likewise up
  for (int g = 0; g < ghosts; g++)
    if (!gone[g] && now[g] < nlocal + g) atom->avec->copy(nlocal + g, now[g], 0);
  for (int g = ghosts - 1; g >= 0; g--)
    if (!gone[g] && now[g] > nlocal + g) atom->avec->copy(nlocal + g, now[g], 0);
  for (int k = 0; k < ghosts_came; k++) atom->avec->copy(aside + k, now[ghosts + k], 0);
  for (int i = place; i < end; i++) sys.store.touch(i);
  atom->nghost = place - nlocal;
  Map::make_room_for_images(atom, memory, atom->nmax);
  enter_in_map(ids_gone);
}

/* ----------------------------------------------------------------------
   LAMMPS' map knows of all atoms with one ID the first, local ones are before ghosts; from there it goes on in sametag
------------------------------------------------------------------------- */

void DefeBorderSwaps::forget_ghosts(int first)
{
  for (int i = first; i < first + atom->nghost; i++) {
    const int known = atom->map(atom->tag[i]);
    if (known >= first)
      atom->map_one(atom->tag[i], -1);
    else if (known >= 0)
      atom->sametag[known] = -1;
  }
}

void DefeBorderSwaps::enter_in_map(const std::vector<tagint> &ids_gone)
{
  Map::make_room_in_hash(atom, ghosts_came);
  int *const sametag = atom->sametag;
  for (int i = atom->nlocal + atom->nghost - 1; i >= atom->nlocal; i--) {
    const int first = atom->map(atom->tag[i]);
    if (first >= 0 && first < atom->nlocal) {
      sametag[i] = sametag[first];
      sametag[first] = i;
    } else {
      sametag[i] = first;
      Map::set(atom, atom->tag[i], i);
    }
  }
  for (tagint tag : ids_gone)
    if (atom->map(tag) < 0) Map::remove(atom, tag);
}
