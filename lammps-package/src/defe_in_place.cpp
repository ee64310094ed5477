/* ----------------------------------------------------------------------
   DEFE: adaptive finite elements to bonded discrete elements for LAMMPS
   https://www.lammps.org/
   This software is distributed under the GNU General Public License.
------------------------------------------------------------------------- */

#include "defe_in_place.h"

#include "defe_system.h"
#include "lammps_protected.h"

#include "atom_vec.h"
#include "domain.h"
#include "fix.h"
#include "modify.h"
#include "update.h"

#include <algorithm>
#include <cmath>
#include <typeinfo>
#include <unordered_set>

using namespace LAMMPS_NS;
using namespace LAMMPS_NS::Protected;
using defe::Vec3;
using defe::fe::HexCoords;

DefeInPlace::DefeInPlace(DefeSystem &system) : DefeComponent(system), swaps(system) {}

/* ----------------------------------------------------------------------
   who else has something that a reneighbouring would have to make anew
------------------------------------------------------------------------- */

void DefeInPlace::look_at_commands()
{
  // of those that act before lists are built: ours, and those that then bring back what has left a periodic box, or is out of balance
  int known = 0;
  ours.clear();
  for (auto *ifix : modify->get_fix_list()) {
    const bool has_tables = ifix == sys.host || utils::strmatch(ifix->style, "^defe/wall");
    if (has_tables) ours.push_back(ifix);
    if (has_tables || utils::strmatch(ifix->style, "^balance") ||
        (utils::strmatch(ifix->style, "^rigid") && !utils::strmatch(ifix->style, "small")))
      known++;
  }
  const bool periodic = domain->xperiodic || domain->yperiodic || domain->zperiodic;
  const bool alone = comm->nprocs == 1 && !periodic;
  // what leaves a periodic box is brought back by reneighbouring, with other last digits: it must not depend on the ranks when
  allowed_ = sys.model.in_place && !(sys.model.reproducible && periodic) && neighbor->nlist == 0 &&
      neighbor->includegroup == 0 && neighbor->dist_check && !domain->box_change &&
      modify->n_post_integrate == 1 && modify->n_pre_neighbor == known &&
      modify->n_post_neighbor == 0 && atom->molecular == Atom::ATOMIC && atom->firstgroup < 0 &&
      (alone || typeid(*comm) == typeid(CommBrick));
}

// What may touch anything is at most so much of the skin away from where it was when LAMMPS last looked. It may go half the skin from
// there until LAMMPS reneighbours: from where it is now by this much more, and two things by twice that.
static constexpr double MOVED = 0.1;

double DefeInPlace::slack() const
{
  return (allowed_ ? 1.0 + 2.0 * MOVED : 1.0) * neighbor->skin;
}

/* ----------------------------------------------------------------------
   Where LAMMPS last saw an atom may be set to where it is now if no other rank has it as a ghost, and none will before it has moved by
   half the skin again: nothing but our tables depends on it.
------------------------------------------------------------------------- */

bool DefeInPlace::near_last_place(int i)
{
  const double *const then = neighbor->get_xhold()[i];
  double way = 0.0;
  for (int k = 0; k < 3; k++) way += (atom->x[i][k] - then[k]) * (atom->x[i][k] - then[k]);
  const double limit = MOVED * neighbor->skin;
  if (way <= limit * limit) return true;
  if (!away_from_borders(i, neighbor->skin)) return false;
  gone_on.push_back(i);
  return true;
}

void DefeInPlace::see_again()
{
  for (int i : gone_on) std::copy_n(atom->x[i], 3, neighbor->get_xhold()[i]);
  gone_on.clear();
}

/** Of this rank; what others have of it as ghosts may touch something there. */
bool DefeInPlace::hardly_moved()
{
  const auto stays = [this](int i) {
    return i >= atom->nlocal || near_last_place(i);
  };
  for (int i : sys.joints.self)
    if (!stays(i)) return false;
  for (int i : sys.tables.others())
    if (!stays(i)) return false;
  if (!sys.surface.all_of_points_and_facets(stays)) return false;
  auto *const brick = dynamic_cast<CommBrick *>(comm);
  for (int swap = 0; brick && swap < Swaps::count(brick); swap++) {
    const int *const list = Swaps::list(brick, swap);
    if (!std::all_of(list, list + Swaps::sent(brick, swap), stays)) return false;
  }
  return true;
}

bool DefeInPlace::possible()
{
  gone_on.clear();
  if (!allowed_ || sys.census.des() == 0 || !sys.ghosts.enough()) return false;
  enum { NOT_HERE, BORDER, LEAVING, THIN, LAST, COUNT };    // LAST, COUNT: of elements
  tagint mine[COUNT + 1] = {0}, all[COUNT + 1];
  if (!hardly_moved()) mine[NOT_HERE] = 1;
  mine[THIN] = thin();
  int births = 0;
  for (const auto &one : sys.elements.marked()) {
    const DefeBatch &b = sys.elements.batches()[one.first];
    const auto &nodes = b.nodes(one.second);
    if (!std::all_of(nodes.begin(), nodes.end(), [this](int i) {
          return away_from_borders(i, 0.0);
        })) {
      mine[BORDER] = 1;
      if (!borders_can_change()) mine[NOT_HERE] = 1;
      if (!births_stay(b, one.second)) mine[LEAVING] = 1;
    }
    births += sys.model.parts[b.part()].split.des();
    mine[LAST] = MAX(mine[LAST], b.hex[one.second]->id);
  }
  mine[COUNT] = static_cast<tagint>(sys.elements.marked().size());
  MPI_Allreduce(&mine[COUNT], &all[COUNT], 1, MPI_LMP_TAGINT, MPI_SUM, world);
  MPI_Allreduce(mine, all, COUNT, MPI_LMP_TAGINT, MPI_MAX, world);
  if (all[NOT_HERE] || (all[LEAVING] && all[THIN])) return false;
  at_border_ = all[BORDER] != 0;
  leaving = all[LEAVING] != 0;
  const bigint last = sys.ids.highest_born(all[LAST], all[COUNT]);
  int fits = last <= MAXTAGINT && Map::make_room(atom, memory, births, static_cast<tagint>(last));
  MPI_Allreduce(MPI_IN_PLACE, &fits, 1, MPI_INT, MPI_MIN, world);
  return fits != 0;
}

/* ----------------------------------------------------------------------
   at a border
------------------------------------------------------------------------- */

/** Of whole sub-domains, side by side; where types are in collections by their sizes these are found anew with each list. */
bool DefeInPlace::borders_can_change() const
{
  return typeid(*comm) == typeid(CommBrick) &&
      (comm->mode == Comm::SINGLE ||
       (comm->mode == Comm::MULTI && !neighbor->interval_collection_flag));
}

/** No DE of this element would be of another rank. */
bool DefeInPlace::births_stay(const DefeBatch &b, int e) const
{
  HexCoords x, X;
  sys.elements.coords(b.nodes(e).data(), x, X);
  const auto &split = sys.model.parts[b.part()].split;
  for (int place = 0; place < split.des(); place++)
    if (swaps.is_other_ranks(defe::place_of_de(x, place, split).data())) return false;
  return true;
}

/** A DE, which may lie 3/4 of an element outside, may belong to a rank beyond the next one. */
bool DefeInPlace::thin() const
{
  for (int d = 0; d < 3; d++)
    if (comm->procgrid[d] > 1 && domain->subhi[d] - domain->sublo[d] < sys.mesh.max_diagonal())
      return true;
  return false;
}

/* ----------------------------------------------------------------------
   other ranks, and images of this one, know nothing of what happens farther inside than ghosts come from
------------------------------------------------------------------------- */

bool DefeInPlace::away_from_borders(int i, double more) const
{
  if (i >= atom->nlocal) return false;
  for (int d = 0; d < 3; d++) {
    const double far = MAX(comm->cutghost[d], sys.ghosts.reach()) + neighbor->skin;
    const bool low = comm->myloc[d] > 0 || domain->periodicity[d];
    const bool high = comm->myloc[d] < comm->procgrid[d] - 1 || domain->periodicity[d];
    if (atom->x[i][d] < domain->sublo[d] + (low ? far : 0.0) + more) return false;
    if (atom->x[i][d] > domain->subhi[d] - (high ? far : 0.0) - more) return false;
  }
  return true;
}

/* ----------------------------------------------------------------------
   atoms go
------------------------------------------------------------------------- */

void DefeInPlace::begin()
{
  going_on_ = true;
  see_again();
  listed = ghosts_at = atom->nlocal;
  place_before.clear();
  gone.clear();
}

/** Of the atom that is at this place now. */
int DefeInPlace::take_place_before(int i)
{
  const auto before = place_before.find(i);
  if (before == place_before.end()) return i;
  const int place = before->second;
  place_before.erase(before);
  return place;
}

void DefeInPlace::remove(int i)
{
  Map::remove(atom, atom->tag[i]);
  gone.insert(take_place_before(i));
}

void DefeInPlace::moved(int from, int to)
{
  const int first = take_place_before(from);
  place_before[to] = first;
  atom->map_one(atom->tag[to], to);
  atom->sametag[to] = atom->sametag[from];
  std::copy_n(neighbor->get_xhold()[from], 3, neighbor->get_xhold()[to]);
}

/* ----------------------------------------------------------------------
   ghosts follow the last local atom
------------------------------------------------------------------------- */

void DefeInPlace::make_room(int births)
{
  first_born = atom->nlocal;
  update_messages();
  if (at_border_) swaps.forget_ghosts(listed);
  shift_ghosts(first_born + births);
  if (!at_border_) shift_in_map();
}

void DefeInPlace::shift_ghosts(int to)
{
  const int by = to - ghosts_at, begin = ghosts_at, end = ghosts_at + atom->nghost;
  const int all = MAX(begin, to) + atom->nghost;
  if (all > atom->nmax) atom->avec->grow(roomy(all));
  Map::make_room_for_images(atom, memory, atom->nmax);
  Lists::make_room(neighbor, memory, atom->nmax);
  if (by == 0) return;
  ghosts_at = to;
  int *const sametag = atom->sametag;
  const auto move = [&](int i) {
    atom->avec->copy(i, i + by, 0);
    sametag[i + by] = sametag[i] < 0 ? -1 : sametag[i] + by;
  };
  if (by > 0)
    for (int i = end - 1; i >= begin; i--) move(i);
  else
    for (int i = begin; i < end; i++) move(i);
  for (int i = end + by; i < end; i++) sys.store.touch(i);

  auto *const brick = dynamic_cast<CommBrick *>(comm);
  for (int swap = 0; brick && swap < Swaps::count(brick); swap++) {
    int *const list = Swaps::list(brick, swap);
    for (int k = 0; k < Swaps::sent(brick, swap); k++)
      if (list[k] >= begin) list[k] += by;
    Swaps::first(brick, swap) += by;
  }
}

/** The map knows of all atoms with one ID the first, and local ones are before ghosts. */
void DefeInPlace::shift_in_map()
{
  const int by = ghosts_at - listed;
  if (by == 0) return;
  std::unordered_set<int> owned;
  for (int i = ghosts_at + atom->nghost - 1; i >= ghosts_at; i--) {
    const int first = atom->map(atom->tag[i]);
    if (first >= 0 && first < atom->nlocal)
      owned.insert(first);
    else
      atom->map_one(atom->tag[i], i);
  }
  for (int i : owned) atom->sametag[i] += by;
}

/* ----------------------------------------------------------------------
   local atoms that go to other ranks, and are at other places now
------------------------------------------------------------------------- */

void DefeInPlace::update_messages()
{
  auto *const brick = dynamic_cast<CommBrick *>(comm);
  if (!brick || (place_before.empty() && !at_border_)) return;
  std::unordered_map<int, int> place_now;
  for (const auto &one : place_before) place_now[one.second] = one.first;
  for (int i : gone) place_now[i] = DefeBorderSwaps::GONE;
  if (place_now.empty()) return;
  for (int swap = 0; swap < Swaps::count(brick); swap++) {
    int *const list = Swaps::list(brick, swap);
    for (int k = 0; k < Swaps::sent(brick, swap); k++) {
      if (list[k] >= listed) continue;
      const auto now = place_now.find(list[k]);
      if (now != place_now.end()) list[k] = now->second;
    }
  }
}

/* ----------------------------------------------------------------------
   all DEs are there
------------------------------------------------------------------------- */

void DefeInPlace::tell()
{
  for (int i = first_born; i < atom->nlocal; i++) domain->remap(atom->x[i], atom->image[i]);
  if (leaving) take_in(swaps.send_home(first_born));
  for (int i = first_born; i < atom->nlocal; i++) {
    Map::set(atom, atom->tag[i], i);
    atom->sametag[i] = -1;
    std::copy_n(atom->x[i], 3, neighbor->get_xhold()[i]);
  }
  if (!at_border_) return;
  // what has moved since LAMMPS last looked, twice: a DE's border, and what is beyond it
  swaps.edit(first_born, 2.0 * MOVED * neighbor->skin);
  sys.ghosts.update_masses();
}

/** DEs of other ranks' elements. */
void DefeInPlace::take_in(std::vector<double> &&atoms)
{
  int count = 0;
  for (size_t m = 0; m < atoms.size(); m += static_cast<size_t>(atoms[m])) count++;
  shift_ghosts(atom->nlocal + count);
  Map::make_room_in_hash(atom, count);
  for (size_t m = 0; m < atoms.size();) m += atom->avec->unpack_exchange(&atoms[m]);
}

/* ----------------------------------------------------------------------
   What nothing was near until now may have moved farther than these tables allow for: then LAMMPS reneighbours in this step
   after all.
------------------------------------------------------------------------- */

void DefeInPlace::make_tables()
{
  moved_too_far = false;
  for (auto *ifix : ours) ifix->pre_neighbor();
  see_again();
  int mine = moved_too_far, any = 0;
  MPI_Allreduce(&mine, &any, 1, MPI_INT, MPI_MAX, world);
  if (any) sys.host->next_reneighbor = update->ntimestep;
}

void DefeInPlace::watch(int i)
{
  if (i < atom->nlocal && !near_last_place(i)) moved_too_far = true;
}
