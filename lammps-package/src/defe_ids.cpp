/* ----------------------------------------------------------------------
   DEFE: adaptive finite elements to bonded discrete elements for LAMMPS
   https://www.lammps.org/
   This software is distributed under the GNU General Public License.
------------------------------------------------------------------------- */

#include "defe_system.h"
#include "lammps_protected.h"
#include "rendezvous.h"

#include "atom.h"
#include "comm.h"
#include "domain.h"
#include "error.h"
#include "fix.h"
#include "update.h"

#include <algorithm>
#include <unordered_set>

using namespace LAMMPS_NS;
using Rendezvous::Letters;

/* ----------------------------------------------------------------------
   index of an atom, -1 if it is not here. Atom::map() itself must not be asked for IDs
   above the largest one, which an atom that was deleted may have had.
------------------------------------------------------------------------- */

int DefeIds::local_of(tagint tag) const
{
  return (tag > 0 && tag <= atom->map_tag_max) ? atom->map(tag) : -1;
}

int DefeIds::nearest_to(int i, tagint id) const
{
  const int j = local_of(id);    // most have no images, and their positions need not be fetched
  return j < 0 || atom->sametag[j] < 0 ? j : domain->closest_image(i, j);
}

tagint DefeIds::de_tag(tagint lot, int place) const
{
  return now.base + sys.model.lot_size() * (lot - 1) + place + 1;
}

tagint DefeIds::last_de() const
{
  return now.base + sys.model.lot_size() * now.last_element;
}

/* ----------------------------------------------------------------------
   what others have inserted; once in a run, and after they have done so, a pass over all atoms
------------------------------------------------------------------------- */

void DefeIds::look_at_all()
{
  tagint mine[2] = {now.last_id, 0}, all[2];
  const tagint last = last_de();
  for (int i = 0; i < atom->nlocal && !looked; i++) {
    const tagint tag = atom->tag[i];
    mine[0] = MAX(mine[0], tag);
    if (!sys.store.de(i) && tag > now.base && tag <= last) mine[1] = 1;
  }
  looked = true;
  MPI_Allreduce(mine, all, 2, MPI_LMP_TAGINT, MPI_MAX, world);
  now.last_id = all[0];
  if (all[1]) now.lots_moved = 1;
}

bigint DefeIds::last_lot_in_use() const
{
  const int size = sys.model.lot_size();
  const bigint in_use = (static_cast<bigint>(now.last_id) - now.base + size - 1) / size;
  return MAX(in_use, static_cast<bigint>(now.last_element));
}

bigint DefeIds::highest_born(tagint last_element, bigint elements)
{
  look_at_all();
  const bigint last_lot = now.lots_moved ? last_lot_in_use() + elements : last_element;
  return now.base + sys.model.lot_size() * last_lot;
}

/* ----------------------------------------------------------------------
   lots of IDs for the elements of this rank that convert now, given by ID; collective

   The first lots have the numbers of the elements, so that an element's DEs have the same IDs in every
   run. LAMMPS gives new atoms the IDs that follow the largest one: as long as the last lot is not in use, they
   fall into lots that are still to be used. From then on lots are given out beyond all IDs, in the order of
   conversions, and of the elements' IDs within one: the same on any number of processors.
------------------------------------------------------------------------- */

std::vector<tagint> DefeIds::deal_lots(const std::vector<tagint> &elements)
{
  look_at_all();
  tagint mine = 0, last_element = 0;
  for (tagint id : elements) mine = MAX(mine, id);
  MPI_Allreduce(&mine, &last_element, 1, MPI_LMP_TAGINT, MPI_MAX, world);
  if (last_element == 0) return {};    // nothing converts

  std::vector<tagint> lots(elements);
  bigint last_lot = last_element;
  if (now.lots_moved) last_lot = deal_behind_all(elements, lots);
  const int size = sys.model.lot_size();
  if (now.base + size * last_lot > MAXTAGINT)
    error->all(FLERR,
               "Fix defe needs atom IDs up to {} at step {}: compile LAMMPS with -DLAMMPS_BIGBIG",
               now.base + size * last_lot, update->ntimestep);
  now.last_born = MAX(now.last_born, de_tag(static_cast<tagint>(last_lot), size - 1));
  now.last_id = MAX(now.last_id, now.last_born);
  return lots;
}

/* ----------------------------------------------------------------------
   lots beyond all IDs: each rank counts the elements of its share of all IDs, so that none holds more than
   that; returns the last lot
------------------------------------------------------------------------- */

bigint DefeIds::deal_behind_all(const std::vector<tagint> &elements,
                                std::vector<tagint> &lots) const
{
  struct Request {
    tagint element;
    int proc, index;
  };
  Letters<Request> requests(lmp);
  for (size_t k = 0; k < elements.size(); k++)
    requests.to_rank(
        static_cast<int>(static_cast<bigint>(elements[k] - 1) * comm->nprocs / now.last_element),
        {elements[k], comm->me, static_cast<int>(k)});
  auto came = requests.send();
  std::sort(came.begin(), came.end(), [](const Request &a, const Request &b) {
    return a.element < b.element;
  });
  const auto count = static_cast<bigint>(came.size());
  bigint up_to_me = 0, total = 0;
  MPI_Scan(&count, &up_to_me, 1, MPI_LMP_BIGINT, MPI_SUM, world);
  MPI_Allreduce(&count, &total, 1, MPI_LMP_BIGINT, MPI_SUM, world);

  const bigint first = last_lot_in_use() + 1;
  struct Answer {
    tagint lot;
    int index;
  };
  Letters<Answer> answers(lmp);
  for (bigint k = 0; k < count; k++)
    answers.to_rank(came[k].proc,
                    {static_cast<tagint>(first + up_to_me - count + k), came[k].index});
  for (const auto &a : answers.send()) lots[a.index] = a.lot;
  return first + total - 1;
}

/* ----------------------------------------------------------------------
   a fix has just inserted this atom: the energy that it brings is external
------------------------------------------------------------------------- */

void DefeIds::register_newcomer(int i)
{
  if (atom->radius[i] > 0.0 && (atom->mask[i] & sys.host->groupbit) &&
      sys.model.contact_factor > 0.0)
    sys.ledger.external += sys.work.kinetic_energy(i);
  if (atom->tag[i] > now.base && atom->tag[i] <= now.last_born)
    doubtful_newcomers.push_back(atom->tag[i]);
  looked = false;
}

/* ----------------------------------------------------------------------
   the number of atoms has changed: does one that came have the ID of a DE? Not if IDs follow the largest
   one, which is what LAMMPS' fixes do by default.
------------------------------------------------------------------------- */

void DefeIds::check_newcomers()
{
  natoms_known = atom->natoms;
  const int mine = doubtful_newcomers.empty() ? 0 : 1;
  int any = 0;
  MPI_Allreduce(&mine, &any, 1, MPI_INT, MPI_MAX, world);
  if (!any) return;

  Letters<tagint> ids(lmp), des(lmp);
  for (tagint tag : doubtful_newcomers) ids.to_id(tag, tag);
  doubtful_newcomers.clear();
  for (int i = 0; i < atom->nlocal; i++)
    if (sys.store.de(i)) des.to_id(atom->tag[i], atom->tag[i]);
  const auto came = ids.send(), there = des.send();
  const std::unordered_set<tagint> known(there.begin(), there.end());
  tagint twice = MAXTAGINT, first;
  for (tagint tag : came)
    if (known.count(tag)) twice = MIN(twice, tag);
  MPI_Allreduce(&twice, &first, 1, MPI_LMP_TAGINT, MPI_MIN, world);
  if (first < MAXTAGINT)
    error->all(FLERR,
               "An atom was inserted at step {} with ID {}, which a DE has: let fix pour and fix "
               "deposit take the IDs that follow the largest one ('id max', their default)",
               update->ntimestep, first);
}

/* ---------------------------------------------------------------------- */

void DefeIds::begin()
{
  tagint last = 0;
  for (int i = 0; i < atom->nlocal; i++) last = MAX(last, atom->tag[i]);
  MPI_Allreduce(&last, &now.base, 1, MPI_LMP_TAGINT, MPI_MAX, world);
  now.last_element = static_cast<tagint>(sys.mesh.last_hex_id());
  now.last_id = now.base;
  now.last_born = 0;
  now.lots_moved = 0;
  const bigint of_des =
      static_cast<bigint>(now.base) + sys.model.lot_size() * static_cast<bigint>(now.last_element);
  if (of_des > MAXTAGINT)
    error->all(FLERR, "Fix defe needs atom IDs up to {}: compile LAMMPS with -DLAMMPS_BIGBIG",
               of_des);
}

void DefeIds::forget_newcomers()
{
  natoms_known = atom->natoms;
  doubtful_newcomers.clear();
  looked = false;
}

bool DefeIds::natoms_changed() const
{
  return atom->natoms != natoms_known;
}

/* ----------------------------------------------------------------------
   Of LAMMPS' map: what exchange() and borders() take for granted, and no more, since filling it takes a pass over all atoms.
   It has a number for each local atom, and by array a place for each ID.
------------------------------------------------------------------------- */

void DefeIds::make_room_in_map(int born)
{
  tagint mine = 0, highest = 0;
  for (int i = atom->nlocal - born; i < atom->nlocal; i++) mine = MAX(mine, atom->tag[i]);
  MPI_Allreduce(&mine, &highest, 1, MPI_LMP_TAGINT, MPI_MAX, world);
  if (highest > atom->map_tag_max) {
    const tagint ahead = highest + highest / 8;
    const bool array = atom->map_style == Atom::MAP_ARRAY;
    atom->map_tag_max = array && ahead < MAXSMALLINT ? ahead : highest;
    if (array) atom->map_init(0);
  }
  if (atom->nlocal > Protected::Map::room_for_images(atom)) atom->map_set();
}
