/* ----------------------------------------------------------------------
   DEFE: adaptive finite elements to bonded discrete elements for LAMMPS
   https://www.lammps.org/
   This software is distributed under the GNU General Public License.

   What would make results wrong without a word: fixes that move nodes and DEs in a way they cannot be
   moved, names that files cannot hold, time steps that change, energy from nowhere, numbers that are none.
------------------------------------------------------------------------- */

#include "fix_defe.h"

#include "rendezvous.h"
#include "style_names.h"

#include "atom.h"
#include "comm.h"
#include "error.h"
#include "force.h"
#include "group.h"
#include "modify.h"
#include "update.h"

#include "defe/coupling/two_clocks.h"
#include "defe/fe/hex8.h"

#include <algorithm>
#include <cmath>
#include <string>
#include <tuple>
#include <vector>

using namespace LAMMPS_NS;
using namespace FixConst;
using defe::fe::HexCoords;
using Rendezvous::Letters;

// shares of the energy that was put in: by which the balance may be off, and what velocity Verlet may
// add to that by its swing; and the strain, or speed in speeds of sound, below which energies are rounding
static constexpr double BALANCE_LIMIT = 0.05, SWING_LIMIT = 0.2, SMALLEST_MOTION = 1.0e-9;

// change of the length of an edge or diagonal of a rigid element
static constexpr double RIGID_LIMIT = 0.01;

// conversion stresses that an element has when it is first seen above its own, from which on that is told
static constexpr double JUMP_LIMIT = 2.0;

namespace {

/// Without the suffix of an accelerator package.
std::string plain_style(const Fix *ifix)
{
  std::string style = ifix->style;
  for (const char *suffix : {"/omp", "/kk", "/intel", "/opt", "/gpu"}) {
    const std::string s = suffix;
    if (style.size() > s.size() && style.compare(style.size() - s.size(), s.size(), s) == 0)
      style.resize(style.size() - s.size());
  }
  return style;
}

}    // namespace

/* ----------------------------------------------------------------------
   names of parts and materials must be such that a data file can hold them
------------------------------------------------------------------------- */

void FixDefe::check_name(const char *what, const std::string &name) const
{
  if (name.empty() || name.find_first_of(" \t\r\n\f\v#") != std::string::npos)
    error->all(
        FLERR,
        "Fix defe {} '{}': names must not be empty nor have blanks or #, data files could not "
        "hold them",
        what, name);
}

void FixDefe::check_numbers_as_names() const
{
  for (size_t k = 0; k < parts.size(); k++)
    for (size_t other = 0; other < parts.size(); other++)
      if (other != k && parts[k].name == std::to_string(other + 1))
        error->all(
            FLERR,
            "Fix defe: part {} has the name {}, which in data files is also the number of part "
            "{}: give it another name",
            k + 1, parts[k].name, parts[other].name);
}

/* ----------------------------------------------------------------------
   can elements of this part still convert? A conversion stress above Young's modulus says that
   nothing shall
------------------------------------------------------------------------- */

bool FixDefe::may_convert(const Part &p) const
{
  return p.convertible &&
      (p.stress <= material_of(p).elastic().E || (!p.start.empty() && !start_done));
}

/* ----------------------------------------------------------------------
   fixes that move nodes and DEs in a way that they cannot be moved; collective
------------------------------------------------------------------------- */

void FixDefe::check_movers()
{
  if (update->whichflag != 1 || update->nsteps == 0) return;
  check_spins();
  check_rigid_bodies();
  check_rigid_parts();
}

/* ----------------------------------------------------------------------
   DEs turn: friction and the moments of ties and surfaces act on their spins
------------------------------------------------------------------------- */

void FixDefe::check_spins()
{
  static const char *const turns[] = {"/sphere", "^rigid", "^poems$", "^move$", "^nve/noforce$"};
  for (const auto *ifix : modify->get_fix_list()) {
    if (!ifix->time_integrate || one_of(turns, plain_style(ifix))) continue;
    int mine = -1, which;
    for (size_t p = 0; p < parts.size(); p++)
      if (may_convert(parts[p]) && (ifix->groupbit & (1 | group->bitmask[parts[p].group])))
        mine = static_cast<int>(p);
    for (int i = 0; i < atom->nlocal; i++)
      if (de[i] && (atom->mask[i] & ifix->groupbit)) mine = MAX(mine, de[i]->part);
    MPI_Allreduce(&mine, &which, 1, MPI_INT, MPI_MAX, world);
    if (which >= 0)
      error->all(
          FLERR,
          "DEs of part {} are moved by fix {} {}, which does not turn them, so that friction "
          "and moments would be lost: use 'fix {} {} nve/sphere'",
          parts[which].name, ifix->id, ifix->style, ifix->id, group->names[parts[which].group]);
  }
}

/* ----------------------------------------------------------------------
   the lowest node, of all ranks, of an element of the chosen parts that one of these fixes moves, unless it
   is in a held group; collective. Elements know their nodes, and the ranks that own these know who moves
   them: both meet where the ID is dealt to.
------------------------------------------------------------------------- */

struct FixDefe::MovedNode {
  tagint node = MAXTAGINT;
  int part = -1, mover = -1;    // -1: there is none
};

FixDefe::MovedNode FixDefe::first_moved(const std::vector<char> &of_parts,
                                        const std::vector<Fix *> &movers, int held) const
{
  MovedNode mine, first;
  if (movers.empty() || std::count(of_parts.begin(), of_parts.end(), 1) == 0) return first;
  Letters<MovedNode> letters(lmp);
  for (int i = 0; i < atom->nlocal; i++) {
    for (const auto &h : hexes[i])
      if (of_parts[h.part])
        for (tagint t : h.node) letters.to_id(t, {t, h.part, -1});
    if (de[i] || nelem[i] == 0 || (atom->mask[i] & held)) continue;
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

void FixDefe::check_rigid_bodies()
{
  std::vector<Fix *> bodies;
  for (auto *ifix : modify->get_fix_list())
    if (ifix->rigid_flag && ifix->time_integrate) bodies.push_back(ifix);
  std::vector<char> convert;
  for (const auto &p : parts) convert.push_back(may_convert(p));
  const MovedNode m = first_moved(convert, bodies, 0);
  if (m.part >= 0)
    error->all(
        FLERR,
        "Node {} is moved by fix {} {} and belongs to elements of part {}, which converts: "
        "the body would keep the mass that nodes lose then; make the elements at these nodes "
        "a part of their own that does not convert",
        m.node, bodies[m.mover]->id, bodies[m.mover]->style, parts[m.part].name);
}

/* ----------------------------------------------------------------------
   rigid elements have no forces of their own: if each of their nodes moves for itself they are crushed
------------------------------------------------------------------------- */

void FixDefe::check_rigid_parts()
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
  for (const auto &p : parts) rigid.push_back(material_of(p).rigid());
  const MovedNode m = first_moved(rigid, movers, held);
  if (m.part >= 0)
    error->all(
        FLERR,
        "Node {} of the rigid part {} is moved by fix {} {}, each node for itself, so that "
        "the part would be crushed: move its nodes by fix rigid or fix move, or hold them by "
        "fix setforce 0 0 0",
        m.node, parts[m.part].name, movers[m.mover]->id, movers[m.mover]->style);
}

/* ----------------------------------------------------------------------
   the time step, before a run and whenever a fix changes it
------------------------------------------------------------------------- */

void FixDefe::check_time_step(bool changed)
{
  const double dt = update->dt;
  checked_dt = dt;
  if (!(dt >= 0.0))
    error->all(FLERR, "Time step {} is negative or no number: fix defe cannot run backwards", dt);
  if (dt_finite > 0.0 && subcycle.every() * dt > dt_finite)
    error->all(FLERR,
               "Time step {}{}{} is above the stable step of the finite elements {:.6g}: use a "
               "smaller timestep{}{}",
               dt, subcycle.every() > 1 ? fmt::format(" times every {}", subcycle.every()) : "",
               changed ? fmt::format(" at step {}", update->ntimestep) : "", dt_finite,
               subcycle.every() > 1 ? " or every" : "",
               changed ? ", in fix dt/reset by its Tmax" : "");

  // of what only warns, a fix that changes the step again and again is told once

  const bool any_convertible = std::any_of(parts.begin(), parts.end(), [](const Part &p) {
    return p.convertible;
  });
  const bool above = any_convertible && dt_discrete > 0.0 && dt > dt_discrete;
  if (above && !(changed && warned_of_step) && comm->me == 0)
    error->warning(FLERR, "Time step {} is above the safe step of the discrete elements {:.6g}", dt,
                   dt_discrete);
  const bool resonant =
      any_convertible && dt_joints > 0.0 && defe::clocks_resonate(subcycle.every(), dt, dt_joints);
  if (resonant && !(changed && warned_of_step) && comm->me == 0)
    error->warning(
        FLERR,
        "Fix defe every {}: half an oscillation of the discrete elements fits between two "
        "evaluations of the finite elements with the time step {}, and can gain energy from "
        "them without end: use a smaller timestep or every",
        subcycle.every(), dt);
  warned_of_step = above || resonant || (changed && warned_of_step);
}

void FixDefe::reset_dt()
{
  if (update->whichflag == 1) check_time_step(true);
}

/* ----------------------------------------------------------------------
   the criterion is asked at every step: an element that is far above it at once tells of a load that comes
   faster than steps follow, and neighbours convert with it that would have been relieved. (Those that the
   shielding may have held back do not tell.) No message of its own: it travels with the marks.
------------------------------------------------------------------------- */

void FixDefe::note_jump(tagint tag, double ratio)
{
  if (jump_told || ratio < JUMP_LIMIT || ratio < jump.ratio) return;
  if (ratio == jump.ratio && tag > jump.id) return;
  jump.ratio = ratio;
  jump.id = tag;
  marked_here = 2;
}

void FixDefe::report_jump()
{
  jump_told = true;
  struct {
    double ratio;
    int rank;
  } mine = {jump.ratio, comm->me}, most;
  MPI_Allreduce(&mine, &most, 1, MPI_DOUBLE_INT, MPI_MAXLOC, world);
  tagint lowest = mine.ratio == most.ratio ? jump.id : MAXTAGINT, tag;
  MPI_Allreduce(&lowest, &tag, 1, MPI_LMP_TAGINT, MPI_MIN, world);
  if (comm->me == 0)
    error->warning(
        FLERR,
        "Fix defe: element {} was {:.3g} times above its conversion stress when it was first seen "
        "above (step {}): the load comes faster than the steps can follow, and more converts than "
        "should: use a smaller timestep, less load at the start, or a higher conversion stress",
        tag, most.ratio, last_step);
}

/* ----------------------------------------------------------------------
   does this atom count in the kinetic energy of the account, and what others do to it in their work?
   Balls do if they are in the group and meet anything of ours.
------------------------------------------------------------------------- */

bool FixDefe::in_account(int i) const
{
  return de[i] || nelem[i] > 0 ||
      (atom->radius[i] > 0.0 && (atom->mask[i] & groupbit) && contact_factor > 0.0);
}

/* ----------------------------------------------------------------------
   what changes the energy of our atoms without being in the account, in words; empty if nothing does
   Collective.
------------------------------------------------------------------------- */

std::string FixDefe::unseen_work() const
{
  int mine[2] = {0, 0}, all[2];    // groups of our atoms; are there spheres that do not count
  for (int i = 0; i < atom->nlocal; i++) {
    if (in_account(i))
      mine[0] |= atom->mask[i];
    else if (atom->radius[i] > 0.0)
      mine[1] = 1;
  }
  for (const auto &p : parts)
    if (p.convertible) mine[0] |= 1 | group->bitmask[p.group];
  MPI_Allreduce(mine, all, 2, MPI_INT, MPI_BOR, world);

  static const char *const seen[] = {"^nve$",       "^nve/sphere$",  "^nve/bpm/sphere$", "^rigid$",
                                     "^rigid/nve$", "^rigid/small$", "^rigid/nve/small$"};
  static const char *const changes[] = {"^temp/",     "^momentum",       "^recenter",
                                        "^evaporate", "^viscosity$",     "^heat$",
                                        "^ehex$",     "^python/invoke$", "^thermal/conductivity$"};
  for (const auto &ifix : modify->get_fix_list()) {
    const auto style = plain_style(ifix);
    if (ifix == this || utils::strmatch(style, "^defe")) continue;
    const bool moves = ifix->time_integrate ||
        (ifix->setmask() & (INITIAL_INTEGRATE | POST_INTEGRATE | FINAL_INTEGRATE)) ||
        one_of(changes, style);
    const bool box = (ifix->box_change & ~BOX_CHANGE_DOMAIN) != 0;
    const bool ours = group->dynamic[ifix->igroup] || (ifix->groupbit & all[0]);
    if (box || (moves && ours && !one_of(seen, style)))
      return fmt::format("the work of fix {} {}", ifix->id, ifix->style);
  }
  static const char *const known[] = {"^defe/", "^zero$", "^none$"};
  if (force->pair_style && !one_of(known, force->pair_style))
    return fmt::format("what other styles of pair_style {} store and lose", force->pair_style);
  if (force->bond && atom->nbonds > 0)
    return fmt::format("what bond_style {} stores and loses", force->bond_style);
  if (all[1] && (contact_factor > 0.0 || des_total > 0))
    return fmt::format(
        "what spheres take along that are not in the group of fix {}, or that it has "
        "no contact for",
        id);
  return "";
}

/* ----------------------------------------------------------------------
   before a run: can its balance be watched?
------------------------------------------------------------------------- */

void FixDefe::prepare_energy_watch()
{
  energy_watched = false;
  if (energy_check == ENERGY_NO || update->whichflag != 1 || update->nsteps == 0) return;
  const auto unseen = unseen_work();
  energy_watched = unseen.empty();
  if (energy_watched) return;
  balance_known = false;
  if (energy_check == ENERGY_STOP)
    error->all(FLERR,
               "Fix defe check energy stop: {} is not in its account of energies (entry 21), so "
               "that the balance cannot be watched: remove it, or 'check energy stop'",
               unseen);
  say(fmt::format("the energy balance (entry 23 of f_{}) is not watched: {} is not in it", id,
                  unseen));
}

/* ----------------------------------------------------------------------
   the first step of a run, before anything moves: what commands between runs have put in or taken out
   does not count, what the balance has been off by in earlier runs does
------------------------------------------------------------------------- */

void FixDefe::begin_energy_watch()
{
  if (!energy_watched) return;
  vector_step = -1;
  fill_vector();
  vector_step = -1;
  const double balance = vector_values[defe::entries::BALANCE];
  balance_start = balance_known ? balance_start + (balance - balance_last) : balance;
  balance_last = balance;
  balance_known = true;
  swing_start = energy_swing();
  energy_put_in =
      MAX(energy_put_in, balance_start + MAX(0.0, vector_values[defe::entries::EXTERNAL]));
}

/* ----------------------------------------------------------------------
   velocity Verlet keeps E - dt^2/8 sum f^2/m in a linear system, so that E itself swings by that sum: at the
   limit of stability by a good part of it, and without harm
------------------------------------------------------------------------- */

double FixDefe::energy_swing() const
{
  double mine = 0.0, all = 0.0;
  for (int i = 0; i < atom->nlocal; i++) {
    if (!in_account(i)) continue;
    const double *f = atom->f[i], *t = atom->torque[i], r = atom->radius[i];
    double square = f[0] * f[0] + f[1] * f[1] + f[2] * f[2];
    if (r > 0.0) square += (t[0] * t[0] + t[1] * t[1] + t[2] * t[2]) / (0.4 * r * r);
    mine += square / atom->rmass[i];
  }
  MPI_Allreduce(&mine, &all, 1, MPI_DOUBLE, MPI_SUM, world);
  return 0.125 * update->dt * update->dt * all;
}

/* ----------------------------------------------------------------------
   numbers that are none, energy from nowhere, rigid elements that change their shape; collective
------------------------------------------------------------------------- */

void FixDefe::watch_energy()
{
  watch_rigid_elements();
  if (energy_check == ENERGY_NO) return;
  fill_vector();
  vector_step = -1;    // fixes may still change velocities in this step
  const auto &w = vector_values;
  for (int k = 0; k < size_vector; k++)
    if (!std::isfinite(w[k]))
      error->all(
          FLERR,
          "Entry {} of f_{} is no number at step {}: a coefficient of pair_coeff or fix defe "
          "is beyond all bounds, or the run has become unstable (use a smaller timestep)",
          k + 1, id, update->ntimestep);
  if (!energy_watched || !balance_known) return;

  double stiffest = 0.0;
  for (const auto &m : materials)
    if (!m.rigid()) stiffest = MAX(stiffest, m.elastic().E / m.elastic().rho);
  const double floor = mass_total * stiffest * SMALLEST_MOTION * SMALLEST_MOTION;
  balance_last = w[defe::entries::BALANCE];
  energy_put_in = MAX(energy_put_in, balance_start + MAX(0.0, w[defe::entries::EXTERNAL]));
  const double off = balance_last - balance_start;
  if (std::abs(off) <= MAX(BALANCE_LIMIT * energy_put_in, floor)) return;
  const double swing = MIN(MAX(swing_start, energy_swing()), SWING_LIMIT * energy_put_in);
  if (std::abs(off) <= BALANCE_LIMIT * energy_put_in + swing) return;
  const auto what = fmt::format(
      "Fix defe: the energy balance is off by {:.4g} at step {}, {:.3g} % of the {:.4g} that was "
      "put in (entry 23 of f_{}): the run is not to be trusted, use a smaller timestep",
      off, update->ntimestep, 100.0 * std::abs(off) / energy_put_in, energy_put_in, id);
  if (energy_check == ENERGY_STOP) error->all(FLERR, what);
  if (!energy_told && comm->me == 0) error->warning(FLERR, what);
  energy_told = true;
}

/* ---------------------------------------------------------------------- */

void FixDefe::watch_rigid_elements()
{
  HexCoords x, X;
  for (const auto &b : batches) {
    if (!b.rigid) continue;
    for (size_t e = 0; e < b.node.size(); e++) {
      hex_coords(b.node[e].data(), x, X);
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
          b.hex[e]->id, parts[b.hex[e]->part].name, 100.0 * worst, update->ntimestep);
    }
  }
}
