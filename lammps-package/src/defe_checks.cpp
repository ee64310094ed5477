/* ----------------------------------------------------------------------
   DEFE: adaptive finite elements to bonded discrete elements for LAMMPS
   https://www.lammps.org/
   This software is distributed under the GNU General Public License.
------------------------------------------------------------------------- */

#include "defe_system.h"
#include "fix_defe_wall.h"
#include "style_names.h"

#include "atom.h"
#include "comm.h"
#include "error.h"
#include "fix.h"
#include "force.h"
#include "group.h"
#include "min.h"
#include "modify.h"
#include "neighbor.h"
#include "update.h"

#include "defe/coupling/two_clocks.h"

#include <algorithm>

using namespace LAMMPS_NS;
using namespace FixConst;

/* ---------------------------------------------------------------------- */

void DefeChecks::before_mesh() const
{
  if (!force->newton)
    error->all(FLERR,
               "Fix defe adds forces to ghost nodes: use 'newton off on' (or 'newton on'), not "
               "'newton off'");
  if (neighbor->includegroup)
    error->all(FLERR, "Fix defe cannot be used with neigh_modify include: remove it");
  // nodes, DEs and balls are told apart by type
  if (comm->mode != Comm::SINGLE && comm->mode != Comm::MULTI)    // later releases have no other
    error->all(FLERR,
               "Fix defe does not know comm_modify mode multi/old: use mode single, or multi with "
               "neighbor style multi");
  if (comm->mode == Comm::MULTI && neighbor->interval_collection_flag)
    error->all(
        FLERR,
        "Fix defe needs collections of types for comm_modify mode multi: remove neigh_modify "
        "collection/interval (or use collection/type)");
  if (modify->get_fix_by_style("^defe$").size() > 1)
    error->all(FLERR, "Only one fix defe at a time: one fix holds any number of parts");
  if (utils::strmatch(update->integrate_style, "^respa"))
    error->all(FLERR, "Fix defe does not support run_style respa: use verlet");
  order_of_fixes();

  const bool converting = sys.model.any_convertible();
  bond_fixes(converting);
  if (converting && (!force->pair || !force->pair_match("^defe/", 0)))
    error->all(FLERR,
               "Fix defe converts elements into DEs that no pair style joins: use pair_style "
               "defe/joint");
  if (sys.model.contact() && comm->ghost_velocity == 0)
    error->all(FLERR, "Fix defe contact needs velocities of ghosts: add comm_modify vel yes");
}

void DefeChecks::order_of_fixes() const
{
  const char *id = sys.host->id;
  for (const auto &ifix : modify->get_fix_list()) {
    if (ifix == sys.host) break;
    if (ifix->pre_exchange_migrate)
      error->all(FLERR, "Fix {} {} migrates atoms and must be defined after fix {} defe", ifix->id,
                 ifix->style, id);
    for (const char *style : {"^pour", "^deposit", "^evaporate", "^gcmc"})
      if (utils::strmatch(ifix->style, style))
        error->all(
            FLERR,
            "Fix {} {} creates or deletes atoms and must be defined after fix {} defe, which "
            "needs them as they were at the last step",
            ifix->id, ifix->style, id);
    if (ifix->setmask() & POST_FORCE)
      error->all(FLERR,
                 "Fix {} {} changes forces and must be defined after fix {} defe, which keeps the "
                 "account of external work",
                 ifix->id, ifix->style, id);
  }
}

/* ---------------------------------------------------------------------- */

void DefeChecks::after_mesh() const
{
  integrators();
  movers();
  adhesives();
  granular_walls();
  minimizer();
  radii_of_nodes();
}

/* ----------------------------------------------------------------------
   nodes are points
------------------------------------------------------------------------- */

void DefeChecks::radii_of_nodes() const
{
  tagint mine = MAXTAGINT, all;
  for (int i = 0; i < atom->nlocal; i++)
    if (sys.store.is_node(i) && atom->radius[i] != 0.0) mine = MIN(mine, atom->tag[i]);
  MPI_Allreduce(&mine, &all, 1, MPI_LMP_TAGINT, MPI_MIN, world);
  if (all < MAXTAGINT)
    error->all(FLERR, "Node {} of the mesh was given a radius: nodes are spheres of radius 0", all);
}

/* ----------------------------------------------------------------------
   adhesives need a pair style that softens joints, and contact for what happens after they are broken; ties that
   soften (after a restart) need their adhesive
------------------------------------------------------------------------- */

void DefeChecks::adhesives() const
{
  if (!sys.model.adhesives.empty() && !force->pair_match("defe/joint", 1) &&
      !force->pair_match("defe/cohesive", 1))
    error->all(FLERR,
               "Fix defe adhesive: ties soften with pair_style defe/joint or defe/cohesive only");
  if (!sys.model.adhesives.empty() && !(sys.model.contact()) && comm->me == 0)
    error->warning(
        FLERR,
        "Fix defe adhesive without the keyword contact: what has debonded passes through "
        "the faces");
  int mine[2] = {-1, -1}, all[2];
  for (int i = 0; i < atom->nlocal; i++) {
    if (!sys.store.de(i)) continue;
    for (const auto &slot : sys.store.de(i)->slot)
      if (slot.kind == DefeJoint::TIE && (slot.state == DefeJoint::COHESIVE || slot.pending) &&
          !sys.model.adhesive_of(sys.store.de(i)->part, slot.part)) {
        mine[0] = sys.store.de(i)->part;
        mine[1] = slot.part;
      }
  }
  MPI_Allreduce(mine, all, 2, MPI_INT, MPI_MAX, world);
  if (all[0] >= 0)
    error->all(FLERR,
               "Fix defe: ties of part {} to part {} are softening, but no adhesive is given for "
               "them: give 'adhesive' as before the restart",
               sys.model.parts[all[0]].name, sys.model.parts[all[1]].name);
}

/* ----------------------------------------------------------------------
   every DE that may be born must be moved by one fix, and no node by two
------------------------------------------------------------------------- */

void DefeChecks::integrators() const
{
  if (update->whichflag != 1 || update->nsteps == 0) return;
  std::vector<Fix *> movers;
  for (auto *ifix : modify->get_fix_list())
    if (ifix->time_integrate) movers.push_back(ifix);

  for (const auto &p : sys.model.parts) {
    if (!p.convertible) continue;
    const int bits = 1 | group->bitmask[p.group];
    std::vector<std::string> found;
    for (auto *ifix : movers)
      if (!ifix->rigid_flag && (ifix->groupbit & bits)) found.push_back(ifix->id);
    if (found.empty())
      error->all(FLERR,
                 "DEs of part {} (group {}) would be moved by no fix: add 'fix ID {} nve/sphere'",
                 p.name, group->names[p.group], group->names[p.group]);
    if (found.size() > 1)
      error->all(FLERR,
                 "DEs of part {} (group {}) would be moved by fix {} and fix {}: give each fix a "
                 "group of its own",
                 p.name, group->names[p.group], found[0], found[1]);
  }

  for (int i = 0; i < atom->nlocal; i++) {
    if (!sys.store.is_ours(i)) continue;
    const Fix *first = nullptr;
    for (const auto *ifix : movers) {
      if (!(atom->mask[i] & ifix->groupbit)) continue;
      if (first)
        error->one(FLERR,
                   "{} {} is moved by fix {} and by fix {}: give each fix a group of its own",
                   sys.store.de(i) ? "DE" : "Node", atom->tag[i], first->id, ifix->id);
      first = ifix;
    }
  }
}

/* ----------------------------------------------------------------------
   bonds of bpm styles keep their state by local indices between reneighbourings: it must be put away
   before conversions delete nodes
   When one breaks, LAMMPS (4Feb2025) looks it up in all neighbour lists, also in the one from which
   hybrid takes those of its styles: marks of touching pairs, which are cleared in the style's own list
   only, are taken for parts of atom indices there, and the program crashes.
------------------------------------------------------------------------- */

void DefeChecks::bond_fixes(bool converting) const
{
  bool after = false, breaking = false, history = false;
  const char *bonds = force->bond_style ? force->bond_style : "bpm";
  for (const auto *ifix : modify->get_fix_list()) {
    if (ifix == sys.host) after = true;
    const bool special = utils::strmatch(ifix->style, "^UPDATE_SPECIAL_BONDS$");
    if (converting && after && (special || utils::strmatch(ifix->style, "^BOND_HISTORY$")))
      error->all(FLERR,
                 "Bond_style {} must be given before fix {} defe: conversions would mix up the "
                 "states of its bonds",
                 bonds, sys.host->id);
    breaking = breaking || special;
    history = history || utils::strmatch(ifix->style, "^NEIGH_HISTORY");
  }
  if (breaking && history && force->pair_match("^hybrid", 0))
    error->all(FLERR,
               "Bond_style {} with bonds that break crashes LAMMPS beside contact histories in "
               "pair_style hybrid: use granular styles without history, or bonds with 'break no'",
               bonds);
}

/* ----------------------------------------------------------------------
   largest radius of the spheres of this type that fixes are going to insert
------------------------------------------------------------------------- */

double DefeChecks::radius_to_come(int type) const
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
   granular walls act on radii, and nodes have none: elements would fall through silently
------------------------------------------------------------------------- */

void DefeChecks::granular_walls() const
{
  for (auto *ifix : modify->get_fix_by_style("^wall/gran")) {
    tagint mine = MAXTAGINT, node;
    for (int i = 0; i < atom->nlocal; i++)
      if (sys.store.is_node(i) && (atom->mask[i] & ifix->groupbit)) mine = MIN(mine, atom->tag[i]);
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
   elements are about to convert: what this does to the energy of their contact with walls is known
   once the walls have found the new DEs
------------------------------------------------------------------------- */

void DefeChecks::note_energy_in_walls() const
{
  if (update->setupflag) return;    // no step yet, and no contact
  for (auto *ifix : modify->get_fix_by_style("^defe/wall$"))
    dynamic_cast<FixDefeWall *>(ifix)->note_energy();
}

/* ----------------------------------------------------------------------
   energy of this rank's contacts with walls
------------------------------------------------------------------------- */

double DefeChecks::wall_energy() const
{
  double sum = 0.0;
  int dim;
  for (auto *ifix : modify->get_fix_by_style("^defe/wall$"))
    sum += *static_cast<const double *>(ifix->extract("energy", dim));
  return sum;
}

/* ----------------------------------------------------------------------
   how far a minimiser may move a node at a time: in si units the default is 0.1 m
------------------------------------------------------------------------- */

namespace {
struct AnyMin : Min {
  static double longest_move(Min *min) { return min->*(&AnyMin::dmax); }
};
}    // namespace

std::string DefeChecks::minimizer_hint() const
{
  if (update->whichflag != 2) return "";
  return fmt::format("; the minimizer may move nodes too far: use min_modify dmax {:.1g}",
                     0.004 * sys.mesh.max_step_length());
}

void DefeChecks::minimizer() const
{
  if (update->whichflag != 2) return;
  const double most = sys.mesh.max_step_length();
  const double dmax = sys.census.elements() ? AnyMin::longest_move(update->minimize) : 0.0;
  if (dmax > most)
    error->all(
        FLERR,
        "Minimization may move nodes by {:.4g} at a time, more than a quarter of the shortest "
        "edge ({:.4g}), and would turn elements inside out: use min_modify dmax {:.1g}",
        dmax, 4.0 * most, 0.004 * most);
  if (sys.census.des() > 0)
    error->all(
        FLERR,
        "Fix defe cannot minimize with DEs: joints damage along a path in time; minimize before "
        "elements convert, or damp the motion with fix viscous");
}

/* ----------------------------------------------------------------------
   the time step, before a run and whenever a fix changes it
------------------------------------------------------------------------- */

void DefeChecks::time_step(bool changed)
{
  const double dt = update->dt, dt_finite = sys.mesh.dt_finite(),
               dt_discrete = sys.mesh.dt_discrete();
  const int every = sys.clock.subcycle().every();
  checked_dt = dt;
  if (!(dt >= 0.0))
    error->all(FLERR, "Time step {} is negative or not a number: fix defe cannot run backwards",
               dt);
  if (dt_finite > 0.0 && every * dt > dt_finite)
    error->all(FLERR,
               "Time step {}{}{} is above the stable step of the finite elements {:.6g}: use a "
               "smaller timestep{}{}",
               dt, every > 1 ? fmt::format(" times every {}", every) : "",
               changed ? fmt::format(" at step {}", update->ntimestep) : "", dt_finite,
               every > 1 ? " or every" : "", changed ? ", in fix dt/reset by its Tmax" : "");

  // of what only warns, a fix that changes the step again and again is told once

  const bool converting = sys.model.any_convertible();
  const bool above = converting && dt_discrete > 0.0 && dt > dt_discrete;
  if (above && !(changed && warned_of_step) && comm->me == 0)
    error->warning(FLERR, "Time step {} is above the safe step of the discrete elements {:.6g}", dt,
                   dt_discrete);
  const double dt_joints = sys.mesh.dt_joints();
  const bool resonant =
      converting && dt_joints > 0.0 && defe::clocks_resonate(every, dt, dt_joints);
  if (resonant && !(changed && warned_of_step) && comm->me == 0)
    error->warning(
        FLERR,
        "Fix defe every {}: half an oscillation of the discrete elements fits between two "
        "evaluations of the finite elements with the time step {}, and can gain energy from "
        "them without end: use a smaller timestep or every",
        every, dt);
  warned_of_step = above || resonant || (changed && warned_of_step);
}

bool DefeChecks::step_changed() const
{
  return update->dt != checked_dt;
}
