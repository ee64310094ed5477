/* ----------------------------------------------------------------------
   DEFE: adaptive finite elements to bonded discrete elements for LAMMPS
   https://www.lammps.org/
   This software is distributed under the GNU General Public License.

   What others bring: atoms that come later (fix pour, fix deposit, create_atoms between
   runs) and the IDs of DEs, which must not be theirs; walls, communication, minimisers.
------------------------------------------------------------------------- */

#include "fix_defe.h"
#include "fix_defe_wall.h"

#include "rendezvous.h"

#include "atom.h"
#include "comm.h"
#include "error.h"
#include "min.h"
#include "modify.h"
#include "update.h"

#include <algorithm>
#include <unordered_set>

using namespace LAMMPS_NS;
using Rendezvous::Letters;

/* ----------------------------------------------------------------------
   largest radius of the spheres of this type that fixes are going to insert
------------------------------------------------------------------------- */

double FixDefe::radius_to_come(int type) const
{
  double largest = 0.0;
  for (const char *style : {"^pour", "^deposit"})
    for (auto *ifix : modify->get_fix_by_style(style)) {
      int itype = type;
      const auto *radius = static_cast<const double *>(ifix->extract("radius", itype));
      if (radius) largest = MAX(largest, *radius);
    }
  return largest;
}

/* ----------------------------------------------------------------------
   lots of eight IDs for the elements of this rank that convert now, given by ID; collective

   The first lots have the numbers of the elements, so that an element's DEs have the same IDs in every
   run. LAMMPS gives new atoms the IDs that follow the largest one there is: as long as the last lot is
   not in use, these are of lots to come. From then on lots are dealt beyond all IDs, in the order of
   conversions, and of the elements' IDs within one: on any number of processors the same.
------------------------------------------------------------------------- */

std::vector<tagint> FixDefe::deal_lots(const std::vector<tagint> &elements)
{
  tagint mine[3] = {last_id, 0, 0}, all[3];
  for (int i = 0; i < atom->nlocal; i++) {
    const tagint tag = atom->tag[i];
    mine[0] = MAX(mine[0], tag);
    if (!de[i] && tag > de_base && tag <= last_de()) mine[1] = 1;
  }
  for (tagint id : elements) mine[2] = MAX(mine[2], id);
  MPI_Allreduce(mine, all, 3, MPI_LMP_TAGINT, MPI_MAX, world);
  last_id = all[0];
  if (all[1]) lots_moved = true;
  if (all[2] == 0) return {};    // nothing converts

  std::vector<tagint> lots(elements);
  bigint last_lot = all[2];
  if (lots_moved) {

    // ranks count the elements of their share of all IDs, so that nobody sees more than that

    struct Request {
      tagint element;
      int proc, index;
    };
    Letters<Request> requests(lmp);
    for (size_t k = 0; k < elements.size(); k++)
      requests.to_rank(
          static_cast<int>(static_cast<bigint>(elements[k] - 1) * comm->nprocs / last_element),
          {elements[k], comm->me, static_cast<int>(k)});
    auto came = requests.send();
    std::sort(came.begin(), came.end(), [](const Request &a, const Request &b) {
      return a.element < b.element;
    });
    const auto count = static_cast<bigint>(came.size());
    bigint up_to_me = 0, total = 0;
    MPI_Scan(&count, &up_to_me, 1, MPI_LMP_BIGINT, MPI_SUM, world);
    MPI_Allreduce(&count, &total, 1, MPI_LMP_BIGINT, MPI_SUM, world);

    const bigint in_use = (static_cast<bigint>(last_id) - de_base + 7) / 8;
    const bigint first = MAX(in_use, static_cast<bigint>(last_element)) + 1;
    last_lot = first + total - 1;
    struct Answer {
      tagint lot;
      int index;
    };
    Letters<Answer> answers(lmp);
    for (bigint k = 0; k < count; k++)
      answers.to_rank(came[k].proc,
                      {static_cast<tagint>(first + up_to_me - count + k), came[k].index});
    for (const auto &a : answers.send()) lots[a.index] = a.lot;
  }
  if (de_base + 8 * last_lot > MAXTAGINT)
    error->all(FLERR,
               "Fix defe needs atom IDs up to {} at step {}: compile LAMMPS with -DLAMMPS_BIGBIG",
               de_base + 8 * last_lot, update->ntimestep);
  last_born = MAX(last_born, de_tag(static_cast<tagint>(last_lot), 7));
  last_id = MAX(last_id, last_born);
  return lots;
}

/* ----------------------------------------------------------------------
   a fix has just inserted this atom: what energy it brings is external
------------------------------------------------------------------------- */

void FixDefe::register_newcomer(int i)
{
  if (atom->radius[i] > 0.0 && (atom->mask[i] & groupbit) && contact_factor > 0.0)
    ledger.external += kinetic_energy(i);
  if (atom->tag[i] > de_base && atom->tag[i] <= last_born)
    doubtful_newcomers.push_back(atom->tag[i]);
}

/* ----------------------------------------------------------------------
   the number of atoms has changed: does one that came have the ID of a DE? Not if IDs follow the largest
   one, which is what LAMMPS' fixes do by default.
------------------------------------------------------------------------- */

void FixDefe::check_newcomers()
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
    if (de[i]) des.to_id(atom->tag[i], atom->tag[i]);
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

/* ----------------------------------------------------------------------
   granular walls act on radii, which nodes have none of: elements would fall through without a word
------------------------------------------------------------------------- */

void FixDefe::check_walls()
{
  for (auto *ifix : modify->get_fix_by_style("^wall/gran")) {
    tagint mine = MAXTAGINT, node;
    for (int i = 0; i < atom->nlocal; i++)
      if (!de[i] && nelem[i] > 0 && (atom->mask[i] & ifix->groupbit))
        mine = MIN(mine, atom->tag[i]);
    MPI_Allreduce(&mine, &node, 1, MPI_LMP_TAGINT, MPI_MIN, world);
    if (node < MAXTAGINT)
      error->all(
          FLERR,
          "Fix {} {} does not hold finite elements, since nodes have no radius (node {} is in "
          "its group): hold nodes and DEs by a fix defe/wall, and give this one a group of "
          "other spheres",
          ifix->id, ifix->style, node);
  }
}

/* ----------------------------------------------------------------------
   elements are about to convert: what that does to the energy of their contact with walls will be
   known when the walls have found the new DEs
------------------------------------------------------------------------- */

void FixDefe::note_energy_in_walls()
{
  if (update->setupflag) return;    // no step yet, and no contact
  for (auto *ifix : modify->get_fix_by_style("^defe/wall$"))
    dynamic_cast<FixDefeWall *>(ifix)->note_energy();
}

/* ----------------------------------------------------------------------
   energy of this rank's contacts with walls
------------------------------------------------------------------------- */

double FixDefe::wall_energy() const
{
  double sum = 0.0;
  int dim;
  for (auto *ifix : modify->get_fix_by_style("^defe/wall$"))
    sum += *static_cast<const double *>(ifix->extract("energy", dim));
  return sum;
}

/* ----------------------------------------------------------------------
   elements and joints need all their atoms as ghosts, by one distance
------------------------------------------------------------------------- */

void FixDefe::check_communication()
{
  if (comm->mode != Comm::SINGLE)
    error->all(
        FLERR,
        "Fix defe needs ghosts of all nodes and DEs to one distance, which it sets itself: use "
        "comm_modify mode single (neighbor style multi may stay)");
}

/* ----------------------------------------------------------------------
   how far a minimiser may move a node at a time: in si units the default is 0.1 m
------------------------------------------------------------------------- */

namespace {
struct AnyMin : Min {
  static double longest_move(Min *min) { return min->*(&AnyMin::dmax); }
};
}    // namespace

std::string FixDefe::minimizer_hint() const
{
  if (update->whichflag != 2) return "";
  return fmt::format("; the minimizer may move nodes too far: use min_modify dmax {:.1g}",
                     0.004 * max_step_length);
}

void FixDefe::check_minimizer()
{
  if (update->whichflag != 2 || hexes_total == 0) return;
  const double dmax = AnyMin::longest_move(update->minimize);
  if (dmax > max_step_length)
    error->all(
        FLERR,
        "Minimization may move nodes by {:.4g} at a time, more than a quarter of the shortest "
        "edge ({:.4g}), and would turn elements inside out: use min_modify dmax {:.1g}",
        dmax, 4.0 * max_step_length, 0.004 * max_step_length);
}
