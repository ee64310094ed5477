/* ----------------------------------------------------------------------
   DEFE: adaptive finite elements to bonded discrete elements for LAMMPS
   https://www.lammps.org/
   This software is distributed under the GNU General Public License.
------------------------------------------------------------------------- */

#include "defe_system.h"
#include "rendezvous.h"
#include "style_names.h"

#include "atom.h"
#include "error.h"
#include "fix.h"
#include "group.h"
#include "modify.h"
#include "update.h"

#include <algorithm>
#include <tuple>

using namespace LAMMPS_NS;
using Rendezvous::Letters;

/* ----------------------------------------------------------------------
   can elements of this part still convert? A conversion stress above Young's modulus means that
   none is meant to
------------------------------------------------------------------------- */

bool DefeChecks::may_convert(const DefePart &p) const
{
  return p.convertible &&
      (p.stress <= sys.model.material_of(p).elastic().E ||
       (!p.start.empty() && !sys.conversion.start_done()));
}

/* ----------------------------------------------------------------------
   fixes that move nodes and DEs in a way that does not work; collective
------------------------------------------------------------------------- */

void DefeChecks::movers() const
{
  if (update->whichflag != 1 || update->nsteps == 0) return;
  spins();
  rigid_bodies();
  rigid_parts();
}

/* ----------------------------------------------------------------------
   DEs turn: friction and the moments of ties and surfaces act on their spins
------------------------------------------------------------------------- */

void DefeChecks::spins() const
{
  static const char *const turns[] = {"/sphere", "^rigid", "^poems$", "^move$", "^nve/noforce$"};
  for (const auto *ifix : modify->get_fix_list()) {
    if (!ifix->time_integrate || one_of(turns, plain_style(ifix))) continue;
    int mine = -1, which;
    for (size_t p = 0; p < sys.model.parts.size(); p++)
      if (may_convert(sys.model.parts[p]) &&
          (ifix->groupbit & (1 | group->bitmask[sys.model.parts[p].group])))
        mine = static_cast<int>(p);
    for (int i = 0; i < atom->nlocal; i++)
      if (sys.store.de(i) && (atom->mask[i] & ifix->groupbit))
        mine = MAX(mine, sys.store.de(i)->part);
    MPI_Allreduce(&mine, &which, 1, MPI_INT, MPI_MAX, world);
    if (which >= 0)
      error->all(
          FLERR,
          "DEs of part {} are moved by fix {} {}, which does not turn them, so that friction "
          "and moments would be lost: use 'fix {} {} nve/sphere'",
          sys.model.parts[which].name, ifix->id, ifix->style, ifix->id,
          group->names[sys.model.parts[which].group]);
  }
}

/* ----------------------------------------------------------------------
   the lowest node, of all ranks, of an element of the chosen parts that one of these fixes moves, unless it
   is in a held group; collective. Elements know their nodes, and the ranks that own these know which fix moves
   them: the two meet on the rank that the ID is assigned to (rendezvous).
------------------------------------------------------------------------- */

struct DefeChecks::MovedNode {
  tagint node = MAXTAGINT;
  int part = -1, mover = -1;    // -1: there is none
};

DefeChecks::MovedNode DefeChecks::first_moved(const std::vector<char> &of_parts,
                                              const std::vector<Fix *> &movers, int held) const
{
  MovedNode mine, first;
  if (movers.empty() || std::count(of_parts.begin(), of_parts.end(), 1) == 0) return first;
  Letters<MovedNode> letters(lmp);
  for (int i = 0; i < atom->nlocal; i++) {
    for (const auto &h : sys.store.hexes(i))
      if (of_parts[h.part])
        for (tagint t : h.node) letters.to_id(t, {t, h.part, -1});
    if (!sys.store.is_node(i) || (atom->mask[i] & held)) continue;
    for (size_t k = 0; k < movers.size(); k++)
      if (atom->mask[i] & movers[k]->groupbit)
        letters.to_id(atom->tag[i], {atom->tag[i], -1, static_cast<int>(k)});
  }
  auto came = letters.send();
  std::sort(came.begin(), came.end(), [](const MovedNode &a, const MovedNode &b) {
    return std::tie(a.node, a.part, a.mover) < std::tie(b.node, b.part, b.mover);    // movers first
  });
  for (size_t k = 1; k < came.size() && mine.part < 0; k++)
    if (came[k].node == came[k - 1].node && came[k].part >= 0 && came[k - 1].mover >= 0)
      mine = {came[k].node, came[k].part, came[k - 1].mover};
  MPI_Allreduce(&mine.node, &first.node, 1, MPI_LMP_TAGINT, MPI_MIN, world);
  if (mine.node != first.node) mine.part = mine.mover = -1;
  const int words[2] = {mine.part, mine.mover};
  int all[2];
  MPI_Allreduce(words, all, 2, MPI_INT, MPI_MAX, world);
  first.part = all[0];
  first.mover = all[1];
  return first;
}

/* ----------------------------------------------------------------------
   fix rigid knows the masses of its atoms from its init(): nodes must not lose theirs
------------------------------------------------------------------------- */

void DefeChecks::rigid_bodies() const
{
  std::vector<Fix *> bodies;
  for (auto *ifix : modify->get_fix_list())
    if (ifix->rigid_flag && ifix->time_integrate) bodies.push_back(ifix);
  std::vector<char> convert;
  for (const auto &p : sys.model.parts) convert.push_back(may_convert(p));
  const MovedNode m = first_moved(convert, bodies, 0);
  if (m.part >= 0)
    error->all(
        FLERR,
        "Node {} is moved by fix {} {} and belongs to elements of part {}, which converts: "
        "the body would keep the mass that nodes lose then; make the elements at these nodes "
        "a part of their own that does not convert",
        m.node, bodies[m.mover]->id, bodies[m.mover]->style, sys.model.parts[m.part].name);
}

/* ----------------------------------------------------------------------
   rigid elements have no forces of their own: if each of their nodes moves for itself they are crushed
------------------------------------------------------------------------- */

void DefeChecks::rigid_parts() const
{
  static const char *const keeps_shape[] = {"^rigid", "^poems$", "^move$", "^nve/noforce$",
                                            "^python/move$"};
  static const char *const holds[] = {"^setforce$", "^aveforce$", "^freeze$"};
  std::vector<Fix *> movers;
  int held = 0;
  for (auto *ifix : modify->get_fix_list()) {
    const auto style = plain_style(ifix);
    if (ifix->time_integrate && !one_of(keeps_shape, style)) movers.push_back(ifix);
    if (one_of(holds, style)) held |= ifix->groupbit;
  }
  std::vector<char> rigid;
  for (const auto &p : sys.model.parts) rigid.push_back(sys.model.material_of(p).rigid());
  const MovedNode m = first_moved(rigid, movers, held);
  if (m.part >= 0)
    error->all(
        FLERR,
        "Node {} of the rigid part {} is moved by fix {} {}, each node for itself, so that "
        "the part would be crushed: move its nodes by fix rigid or fix move, or hold them by "
        "fix setforce 0 0 0",
        m.node, sys.model.parts[m.part].name, movers[m.mover]->id, movers[m.mover]->style);
}
