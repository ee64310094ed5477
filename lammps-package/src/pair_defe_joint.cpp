/* ----------------------------------------------------------------------
   DEFE: adaptive finite elements to bonded discrete elements for LAMMPS
   https://www.lammps.org/
   This software is distributed under the GNU General Public License.

   Bonded spheres. The laws are in coupling/; here are the loops and the bookkeeping.

   A joint between two DEs is known to both. The corners of a DE are computed by the rank
   that owns it; the two halves of a joint's force meet after one forward communication,
   so that both sides add up the same numbers. Changes of state are decided by the rank
   that owns the DE with the lower ID, and sent to the other.
------------------------------------------------------------------------- */

#include "pair_defe_joint.h"

#include "defe_cracks.h"
#include "defe_restart_file.h"

#include "defe_system.h"

#include "atom.h"
#include "comm.h"
#include "domain.h"
#include "error.h"
#include "force.h"
#include "memory.h"
#include "modify.h"
#include "neighbor.h"
#include "update.h"

#include "defe/coupling/bins.h"
#include "defe/coupling/conversion.h"
#include "defe/coupling/penalty.h"

#include <Eigen/SVD>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <stdexcept>

using namespace LAMMPS_NS;
using defe::Mat3;
using defe::Vec3;

/* ---------------------------------------------------------------------- */

PairDefeJoint::PairDefeJoint(LAMMPS *lmp) : Pair(lmp)
{
  single_enable = 0;
  restartinfo = 1;
  no_virial_fdotr_compute = 1;
  centroidstressflag = CENTROID_NOTAVAIL;
  finitecutflag = 1;
  comm_forward = DefeCracks::STRESS_SIZE;    // the most; pair_style hybrid asks at once
}

PairDefeJoint::~PairDefeJoint()
{
  if (copymode) return;
  if (allocated) {
    memory->destroy(setflag);
    memory->destroy(cutsq);
  }
}

/* ---------------------------------------------------------------------- */

void PairDefeJoint::allocate()
{
  allocated = 1;
  atom_types = atom->ntypes;
  const int n = atom_types + 1;
  memory->create(setflag, n, n, "pair:setflag");
  memory->create(cutsq, n, n, "pair:cutsq");

  // types of nodes need no coefficients; those of DEs are checked in init_style

  for (int i = 1; i < n; i++)
    for (int j = 1; j < n; j++) {
      setflag[i][j] = 1;
      cutsq[i][j] = 0.0;
    }
  coeffs.assign(static_cast<size_t>(n) * n, Coeff());
}

void PairDefeJoint::settings(int narg, char **arg)
{
  if (narg)
    error->all(FLERR, "Pair style {} takes no arguments, not {}; its numbers go to pair_coeff",
               force->pair_style ? force->pair_style : "defe/*", arg[0]);

  // without any pair_coeff it is init_style that says which ones are needed

  if (domain->box_exist && !allocated) allocate();
}

/* ----------------------------------------------------------------------
   I J connective (E nu | material) contact restitution friction
       cohesive sigma_t G_f beta [reciprocal] [lattice] [overstrength X] [scatter X]
------------------------------------------------------------------------- */

void PairDefeJoint::coeff(int narg, char **arg)
{
  if (narg < 3) utils::missing_cmd_args(FLERR, "pair_coeff", error);
  if (!allocated) allocate();

  int ilo, ihi, jlo, jhi;
  try {
    utils::bounds(FLERR, arg[0], 1, atom->ntypes, ilo, ihi, error);
    utils::bounds(FLERR, arg[1], 1, atom->ntypes, jlo, jhi, error);
  } catch (std::logic_error &) {    // LAMMPS hands on those of std::stol, for instance for "1*-"
    error->all(FLERR, "Pair_coeff: {} {} are no ranges of atom types", arg[0], arg[1]);
  }

  Coeff c;
  int iarg = 2;
  auto need = [&](int n, const char *what) {
    if (iarg + n > narg) utils::missing_cmd_args(FLERR, std::string("pair_coeff ") + what, error);
  };
  while (iarg < narg) {
    const std::string key = arg[iarg];
    if (key == "connective") {
      need(2, "connective E nu");
      if (!with_connective)
        error->all(FLERR, "Pair_coeff connective: this pair style has no connective joints");
      c.has_connective = true;
      if (strcmp(arg[iarg + 1], "material") == 0) {
        iarg += 2;
        continue;
      }
      need(3, "connective E nu");
      c.E = utils::numeric(FLERR, arg[iarg + 1], false, lmp);
      c.nu = utils::numeric(FLERR, arg[iarg + 2], false, lmp);
      if (!(c.E > 0.0)) error->all(FLERR, "Pair_coeff connective: E must be > 0, not {}", c.E);
      if (!(c.nu > -1.0 && c.nu < 0.5))
        error->all(FLERR, "Pair_coeff connective: nu must be between -1 and 0.5, not {}", c.nu);
      iarg += 3;
    } else if (key == "cohesive") {
      need(4, "cohesive sigma_t G_f beta");
      if (!with_cohesive)
        error->all(FLERR, "Pair_coeff cohesive: this pair style has no cohesive joints");
      c.has_cohesive = true;
      c.cohesive.sigma_t = utils::numeric(FLERR, arg[iarg + 1], false, lmp);
      c.cohesive.G_f = utils::numeric(FLERR, arg[iarg + 2], false, lmp);
      c.cohesive.beta = utils::numeric(FLERR, arg[iarg + 3], false, lmp);
      iarg += 4;
      iarg = crack_words(c, narg, arg, iarg);
      if (!(c.cohesive.sigma_t > 0.0) || !(c.cohesive.G_f > 0.0) || !(c.cohesive.beta >= 0.0))
        error->all(FLERR, "Pair_coeff cohesive: sigma_t and G_f must be > 0, beta >= 0");
      if (c.cohesive.reciprocal && c.cohesive.beta == 0.0)
        error->all(FLERR, "Pair_coeff cohesive: beta must be > 0 with reciprocal");
    } else if (key == "contact") {
      need(3, "contact restitution friction");
      if (!with_contact)
        error->all(FLERR, "Pair_coeff contact: this pair style has no contact law");
      c.has_contact = true;
      c.restitution = utils::numeric(FLERR, arg[iarg + 1], false, lmp);
      c.friction = utils::numeric(FLERR, arg[iarg + 2], false, lmp);
      if (!(c.restitution > 0.0 && c.restitution <= 1.0))
        error->all(FLERR, "Pair_coeff contact: restitution must be in (0, 1], not {}",
                   c.restitution);
      if (!(c.friction >= 0.0))
        error->all(FLERR, "Pair_coeff contact: friction must be >= 0, not {}", c.friction);
      c.damping_ratio = defe::damping_ratio(c.restitution);
      iarg += 3;
    } else
      error->all(FLERR, "Unknown pair_coeff keyword {}: use connective, cohesive or contact", key);
  }

  int count = 0;
  for (int i = ilo; i <= ihi; i++)
    for (int j = MAX(jlo, i); j <= jhi; j++) {
      coeff_of(i, j) = coeff_of(j, i) = c;
      count++;
    }
  if (count == 0) error->all(FLERR, "Pair_coeff: no pair of types {} {}", arg[0], arg[1]);
}

/* ---------------------------------------------------------------------- */

void PairDefeJoint::init_style()
{
  if (!atom->radius_flag || !atom->rmass_flag || !atom->omega_flag)
    error->all(FLERR, "Pair style defe/* needs atom_style sphere");
  if (comm->ghost_velocity == 0)
    error->all(FLERR, "Pair style defe/* needs velocities of ghosts: add comm_modify vel yes");
  if (force->newton == 0)
    error->all(FLERR, "Pair style defe/* needs 'newton off on' or 'newton on'");

  map_types();
  sys = DefeSystem::find(lmp);
  if (!sys) error->all(FLERR, "Pair style defe/* joins the DEs of a fix defe: define one");
  sys->mesh.build();
  screen_built = candidates_built = -1;    // it may be another fix than before

  // no neighbour list is requested: nodes are the most of all atoms and would fill it, see
  // update_candidates()

  // elastic constants of each part

  table.clear();
  young.clear();
  for (const auto &p : sys->model.parts) {
    const auto &m = sys->model.material_of(p);
    table.push_back({m.elastic().lambda(), m.elastic().mu()});
    young.push_back(m.elastic().E);
    if (m.rigid()) table.back() = {0.0, 0.0};
  }
  check_coefficients();
  note_other_spheres();
  prepare_cracks();
}

double PairDefeJoint::init_one(int i, int j)
{
  // largest radii there are or ever will be: lists must find the DEs born during a run

  double mine[2] = {0.0, 0.0}, all[2];
  for (int k = 0; k < atom->nlocal; k++) {
    if (atom->type[k] == i) mine[0] = MAX(mine[0], atom->radius[k]);
    if (atom->type[k] == j) mine[1] = MAX(mine[1], atom->radius[k]);
  }
  MPI_Allreduce(mine, all, 2, MPI_DOUBLE, MPI_MAX, world);
  const double ri = MAX(all[0], MAX(sys->mesh.max_de_radius(i), sys->checks.radius_to_come(i)));
  const double rj = MAX(all[1], MAX(sys->mesh.max_de_radius(j), sys->checks.radius_to_come(j)));
  if (i == j && sys->mesh.max_de_radius(i) > 0.0 && force->pair != this)
    return ri + MAX(ri, largest_met_by_others(i));
  if (ri > 0.0 && rj > 0.0) return ri + rj;

  // nodes have no radius and enter no list; but without any cutoff LAMMPS adds no skin and puts all
  // atoms into one bin

  return 0.05 * sys->mesh.max_diagonal();
}

/* ---------------------------------------------------------------------- */

void PairDefeJoint::compute(int eflag, int vflag)
{
  ev_init(eflag, vflag);
  auto &stored = sys->stored;
  stored = defe::StoredEnergy();
  if (sys->census.des() > 0) {
    update_screen();
    if (with_cohesive) switch_joints();    // of the last step
    connective_and_ties();
    if (with_cohesive) {
      cohesive_forces();
      criterion();
    }
  }
  if (with_contact) contact_forces();
  if (eflag_global) eng_vdwl += stored.joints + stored.ties + stored.cohesive + stored.contact;
}

/* ----------------------------------------------------------------------
   virial of a force on atom i, del = x_i - (point of the reaction)
------------------------------------------------------------------------- */

void PairDefeJoint::tally(const double *del, const double *force, int i)
{
  const double v[6] = {del[0] * force[0], del[1] * force[1], del[2] * force[2],
                       del[0] * force[1], del[0] * force[2], del[1] * force[2]};
  if (vflag_global)
    for (int k = 0; k < 6; k++) virial[k] += v[k];
  if (vflag_atom)
    for (int k = 0; k < 6; k++) vatom[i][k] += v[k];
}

/* ---------------------------------------------------------------------- */

void PairDefeJoint::connective_and_ties()
{
  auto &jt = sys->joints;
  double **x = atom->x;
  double **f = atom->f;
  const int n = jt.nde;

  if (!with_connective) {
    for (int d = 0; d < n; d++) {
      jt.present[d] = 0;
      for (int s = 0; s < 6; s++)
        if (jt.rec[d]->slot[s].kind != DefeJoint::NONE)
          jt.rec[d]->slot[s].state = jt.state[6 * d + s] = DefeJoint::CONTACT;
      jt.rec[d]->newborn = 0;
    }
    jt.newborn.clear();
    return;
  }

  // points on the faces of finite elements

  const int nties = static_cast<int>(jt.tie_node.size());
  for (int t = 0; t < nties; t++) {
    const auto &node = jt.tie_node[t];
    for (int k = 0; k < 3; k++)
      jt.tie_point[3 * t + k] = defe::tie_weight[0] * x[node[0]][k] +
          defe::tie_weight[1] * x[node[1]][k] + defe::tie_weight[2] * x[node[2]][k] +
          defe::tie_weight[3] * x[node[3]][k];
  }

  // corners of my DEs

  auto *half = reinterpret_cast<double(*)[6][3]>(jt.half_force.data());
  if (jt.north > 0) {
    const defe::OrthogonalLattice lattice{jt.north,
                                          jt.self.data(),
                                          reinterpret_cast<const int(*)[6]>(jt.nb.data()),
                                          jt.present.data(),
                                          reinterpret_cast<const double(*)[6]>(jt.len.data()),
                                          reinterpret_cast<const double(*)[6]>(jt.half.data()),
                                          jt.material.data()};
    defe::corner_strain_orthogonal(lattice, &x[0][0], jt.tie_point.data(), table.data(), half,
                                   jt.energy.data(), sys->model.reproducible);
  }
  for (int d = jt.north; d < n; d++) {
    const double *xi = x[jt.self[d]];
    Vec3 y[6], hf[6];
    for (int s = 0; s < 6; s++) {
      const int nb = jt.nb[d][s];
      const double *p = nb >= 0 ? x[nb] : &jt.tie_point[3 * ~nb];
      y[s] = Vec3(p[0] - xi[0], p[1] - xi[1], p[2] - xi[2]);
    }
    jt.energy[d] = defe::corner_strain_general(jt.cell[d - jt.north], y, jt.present[d],
                                               table[jt.material[d]], hf);
    for (int s = 0; s < 6; s++)
      for (int k = 0; k < 3; k++) half[d][s][k] = hf[s][k];
  }

  comm_mode = HALF_FORCES;
  comm->forward_comm(this, with_cracks ? 18 + DefeCracks::ENERGY_SIZE : 18);

  // both halves of each joint; ties act on the nodes of the face

  reached.clear();
  auto &stored = sys->stored;
  const bool vflag = vflag_global || vflag_atom;
  const auto &grid = sys->sums.force_grid();
  for (int d = 0; d < n; d++) {
    const int i = jt.self[d];
    double fi[3] = {0.0, 0.0, 0.0};
    int joints = 0, ties = 0;
    for (int s = 0; s < 6; s++) {
      if (!(jt.present[d] & (1u << s))) continue;
      const double *h = half[d][s];
      const int nb = jt.nb[d][s];
      if (nb >= 0) {
        const int other = jt.partner[d][s];
        const double *g = &jt.half_force[other / 6][3 * (other % 6)];
        const double fx = h[0] - g[0], fy = h[1] - g[1], fz = h[2] - g[2];
        fi[0] += fx;
        fi[1] += fy;
        fi[2] += fz;
        if (fx * fx + fy * fy + fz * fz > screen[d][s]) reached.push_back(6 * d + s);
        joints++;
        if (vflag) {
          const double del[3] = {x[i][0] - x[nb][0], x[i][1] - x[nb][1], x[i][2] - x[nb][2]};
          tally(del, h, i);
        }
      } else {
        const auto &node = jt.tie_node[~nb];
        for (int k = 0; k < 3; k++) fi[k] += h[k];
        if (grid.on())
          pull_exactly(node.data(), h);
        else
          for (int a = 0; a < 4; a++)
            for (int k = 0; k < 3; k++) f[node[a]][k] -= defe::tie_weight[a] * h[k];
        if (h[0] * h[0] + h[1] * h[1] + h[2] * h[2] > screen[d][s]) reached.push_back(6 * d + s);
        ties++;
        if (vflag) {
          const double *p = &jt.tie_point[3 * ~nb];
          const double del[3] = {x[i][0] - p[0], x[i][1] - p[1], x[i][2] - p[2]};
          tally(del, h, i);
        }
      }
    }
    for (int k = 0; k < 3; k++) f[i][k] += sys->sums.on_grid(grid, fi[k], i);
    const double e = jt.energy[d];
    if (ties) {
      stored.ties += e * ties / (joints + ties);
      stored.joints += e * joints / (joints + ties);
    } else
      stored.joints += e;
  }

  // strain energy of DEs after their conversion, to set against what was there before

  for (int d : jt.newborn) {
    sys->ledger.conv_strain -= jt.energy[d];
    jt.rec[d]->newborn = 0;
  }
  jt.newborn.clear();
}

/* ----------------------------------------------------------------------
   square of the joint force below which the criterion need not be looked at;
   infinite where there is no joint to decide on, or where the other side decides
------------------------------------------------------------------------- */

void PairDefeJoint::update_screen()
{
  if (screen_built == sys->tables.built()) return;
  screen_built = sys->tables.built();
  if (update->setupflag && with_cohesive) check_laws();
  if (with_cracks) update_crack_tables();
  const auto &jt = sys->joints;
  const std::array<double, 6> never = {HUGE_VAL, HUGE_VAL, HUGE_VAL, HUGE_VAL, HUGE_VAL, HUGE_VAL};
  screen.assign(jt.nde, never);
  mirrored.clear();
  if (!with_cohesive) return;
  for (int d = 0; d < jt.nde; d++)
    for (int s = 0; s < 6; s++) {
      const int i = jt.self[d], j = jt.nb[d][s];
      const bool tie = j < 0;
      const auto *adhesive = tie ? sys->model.adhesive_of(jt.material[d], jt.tie_part[~j])
                                 : nullptr;
      if (tie ? !adhesive : jt.partner[d][s] < 0) continue;
      if (!tie && atom->tag[i] > atom->tag[j]) {
        if (jt.partner[d][s] >= 6 * jt.nde) mirrored.push_back(6 * d + s);
        continue;
      }
      if (jt.state[6 * d + s] != DefeJoint::CONNECTIVE || (!tie && by_crack(d, s))) continue;
      const auto &par = tie ? adhesive->law : coeff_of(atom->type[i], atom->type[j]).cohesive;
      double limit = par.sigma_t * jt.area[d][s];
      if (par.reciprocal && par.beta < 1.0) limit *= par.beta;
      if (!par.reciprocal && par.beta > 1.0) limit /= par.beta;
      screen[d][s] = limit * limit * (1.0 - 1.0e-12);
    }
}

/* ----------------------------------------------------------------------
   connective joints that reach the strength become cohesive in the next step
   here they are only noted: a restart then finds forces that belong to the states
------------------------------------------------------------------------- */

void PairDefeJoint::criterion()
{
  auto &jt = sys->joints;
  double **x = atom->x;
  drop_notes();

  for (int ds : reached) {
    const int d = ds / 6, s = ds % 6;
    const int i = jt.self[d], j = jt.nb[d][s];
    JointSlot &slot = jt.rec[d]->slot[s];
    const double *h = &jt.half_force[d][3 * s];

    if (j < 0) {    // a tie: all of its force is the DE's half
      const auto &par = sys->model.adhesive_of(jt.material[d], slot.part)->law;
      const TiePoint tie = tie_point(d, s);
      const Vec3 t = Vec3(h) / slot.area;
      const double tn = t.dot(tie.normal);
      const Vec3 ts = t - tn * tie.normal;
      if (!(tn > 0.0) || defe::equivalent_traction(tn, ts.norm(), par) < par.sigma_t) continue;
      const auto &moduli = table[jt.material[d]];
      const auto stiffness = defe::joint_stiffness(moduli.lambda, moduli.mu, jt.len[d][s]);
      const auto state = defe::cohesive_start(tn, ts, stiffness, par);
      state.pack(slot.cohesive);
      slot.length0 = tie.y.dot(tie.normal) - state.e_n;
      note_joint(ds);
      continue;
    }

    const int other = jt.partner[d][s];
    const double *g = &jt.half_force[other / 6][3 * (other % 6)];
    const auto &par = coeff_of(atom->type[i], atom->type[j]).cohesive;

    const Vec3 t = Vec3(h[0] - g[0], h[1] - g[1], h[2] - g[2]) / slot.area;
    const Vec3 y(x[j][0] - x[i][0], x[j][1] - x[i][1], x[j][2] - x[i][2]);
    const double length = y.norm();
    const Vec3 along = y / length;
    const Vec3 normal = d < jt.north ? along : face_normal(d, s, along);
    const double tn = t.dot(normal);
    const double ts = (t - tn * normal).norm();
    if (!(tn > 0.0) || defe::equivalent_traction(tn, ts, par) < par.sigma_t) continue;

    const double an = t.dot(along);
    const auto &moduli = table[jt.material[d]];
    const auto stiffness = defe::joint_stiffness(moduli.lambda, moduli.mu, jt.len[d][s]);
    const auto state = defe::cohesive_start(an, t - an * along, stiffness, par);
    state.pack(slot.cohesive);
    slot.length0 = length - state.e_n;
    note_joint(ds);
    if (other < 6 * jt.nde) note_joint(other);
  }

  if (with_cracks) decide_cracks();

  // joints that the rank of the lower ID decides on: take over its state and what it noted

  comm_mode = STATES;
  comm->forward_comm(this, with_cracks ? 1 + 6 * DefeCracks::MEMORY_SIZE : 1);
  for (int ds : mirrored) adopt_state(ds, jt.state[jt.partner[ds / 6][ds % 6]]);
  if (with_cracks) {
    cracks->end_of_step();
    for_drops([this](int d, unsigned leaving) {
      share_out_release(d, leaving);
    });
  }
}

/* ----------------------------------------------------------------------
   f(d, leaving) for each of my DEs with noted joints: which ones they are
------------------------------------------------------------------------- */

template <class F> void PairDefeJoint::for_drops(F f)
{
  auto &jt = sys->joints;
  std::sort(jt.pending.begin(), jt.pending.end());
  for (size_t k = 0; k < jt.pending.size();) {
    const int d = jt.pending[k] / 6;
    unsigned leaving = 0;
    for (; k < jt.pending.size() && jt.pending[k] / 6 == d; k++) leaving |= 1u << jt.pending[k] % 6;
    f(d, leaving);
  }
}

/* ----------------------------------------------------------------------
   What corners let go when joints leave them. The kicks of velocity Verlet belong to the old law up to half-way
   between the two steps: it is their energy now, less the work that their forces of now would have done in the second
   half of the step. For an energy that goes with the square of the stretches that is exact.
------------------------------------------------------------------------- */

double PairDefeJoint::release_of_pending()
{
  const auto &jt = sys->joints;
  double **v = atom->v;
  double release = 0.0;
  for_drops([&](int d, unsigned leaving) {
    Vec3 before[6], after[6];
    const unsigned present = jt.present[d];
    const double drop = sys->tables.de_energy(d, present, before) -
        sys->tables.de_energy(d, present & ~leaving, after);
    double work = 0.0;
    for (int s = 0; s < 6; s++) {
      if (!(present & 1u << s)) continue;
      const int nb = jt.nb[d][s];
      Vec3 speed = -Vec3(v[jt.self[d]]);
      if (nb >= 0)
        speed += Vec3(v[nb]);
      else
        for (int a = 0; a < 4; a++) speed += defe::tie_weight[a] * Vec3(v[jt.tie_node[~nb][a]]);
      work += update->dt * speed.dot(before[s] - after[s]);
    }
    release += drop - 0.5 * work;
    // a DE beside a conversion of this step: its drop is no loss of the conversion
    if (jt.rec[d]->newborn) sys->ledger.conv_strain -= drop;
  });
  return release;
}

/* ----------------------------------------------------------------------
   carry out what the last step noted
------------------------------------------------------------------------- */

void PairDefeJoint::switch_joints()
{
  if (update->setupflag) return;
  auto &jt = sys->joints;
  sys->ledger.release += release_of_pending();
  if (with_cracks) begin_cracks();
  for (int ds : jt.pending) {
    const int d = ds / 6, s = ds % 6;
    JointSlot &slot = jt.rec[d]->slot[s];
    slot.state = DefeJoint::COHESIVE;
    slot.pending = 0;
    jt.state[ds] = DefeJoint::COHESIVE;
    jt.present[d] = static_cast<unsigned char>(jt.present[d] & ~(1u << s));
    screen[d][s] = HUGE_VAL;
    const bool tie = slot.kind == DefeJoint::TIE;
    if (!tie && atom->tag[jt.self[d]] > slot.other) continue;
    slot.pending = 2;    // its energy is booked with its first force
    slot.stored = slot.lost = 0.0;
    jt.cohesive.push_back(ds);
    if (!tie) sys->account.note_damage();
    if (!tie && by_crack(d, s)) continue;    // it is named when its strength is known
    if (!tie && with_cracks) cracks->cut(ds);
    event(d, s, tie ? defe::EventKind::ADHESIVE : defe::EventKind::COHESIVE,
          defe::CohesiveState::unpack(slot.cohesive).s0);
  }
  jt.pending.clear();
}

/* ----------------------------------------------------------------------
   normal of the face that a joint crosses, turned with the DE's cell
------------------------------------------------------------------------- */

Vec3 PairDefeJoint::face_normal(int d, int s, const Vec3 &along) const
{
  const auto &jt = sys->joints;
  double **x = atom->x;
  const double *xi = x[jt.self[d]];
  const auto &cell = jt.cell[d - jt.north];
  Mat3 A = Mat3::Zero();
  for (int q = 0; q < 6; q++) {
    if (!(jt.present[d] & (1u << q))) continue;
    const int nb = jt.nb[d][q];
    const double *p = nb >= 0 ? x[nb] : &jt.tie_point[3 * ~nb];
    A += Vec3(p[0] - xi[0], p[1] - xi[1], p[2] - xi[2]) * cell.dX[q].transpose();
  }
  const Eigen::JacobiSVD<Mat3> svd(A, Eigen::ComputeFullU | Eigen::ComputeFullV);
  if (svd.singularValues()[1] <= 1e-6 * svd.singularValues()[0]) return along;
  Mat3 U = svd.matrixU();
  if ((U * svd.matrixV().transpose()).determinant() < 0.0) U.col(2) *= -1.0;
  return U * svd.matrixV().transpose() * Vec3(jt.rec[d]->slot[s].normal);
}

/* ----------------------------------------------------------------------
   a joint breaks; its other end too if it is here, else its owner learns it from ours
------------------------------------------------------------------------- */

void PairDefeJoint::set_broken(int d, int s)
{
  auto &jt = sys->joints;
  for (int ds : {6 * d + s, jt.partner[d][s]}) {
    if (ds < 0 || ds >= 6 * jt.nde) continue;
    jt.rec[ds / 6]->slot[ds % 6].state = DefeJoint::CONTACT;
    jt.state[ds] = DefeJoint::CONTACT;
  }
  if (with_cracks && jt.partner[d][s] >= 0) cracks->part(6 * d + s);
  add_candidate(jt.self[d], jt.nb[d][s]);
}

void PairDefeJoint::event(int d, int s, defe::EventKind what, double value)
{
  auto &jt = sys->joints;
  const int i = jt.self[d], j = jt.nb[d][s];
  const JointSlot &slot = jt.rec[d]->slot[s];
  const bool tie = slot.kind == DefeJoint::TIE;
  const double *Xi = sys->store.x_frame(i), *Xj = tie ? nullptr : sys->store.x_frame(j);
  defe::Event e;
  e.step = update->ntimestep;
  e.time = sys->clock.now();
  e.what = what;
  e.a = atom->tag[i];
  e.b = slot.other;
  const JointCrack *crack = !tie && by_crack(d, s) ? cracks->find(6 * d + s) : nullptr;
  const double f = crack ? crack->law.f : 0.5;
  double len = 0.0;
  for (int k = 0; k < 3; k++) {
    e.x[k] = tie ? Xi[k] + slot.face[k] : Xi[k] + f * (Xj[k] - Xi[k]);
    e.n[k] = crack ? crack->law.m[k] : tie ? slot.normal[k] : Xj[k] - Xi[k];
    len += e.n[k] * e.n[k];
  }
  for (double &n : e.n) n /= std::sqrt(len);
  const double frame[3] = {e.x[0], e.x[1], e.x[2]};
  domain->unmap(frame, atom->image[i], e.x);    // reference positions are never wrapped
  e.value = value;
  sys->events.record(e);
}

/* ----------------------------------------------------------------------
   a tie and the face that it ends on, as they are now
------------------------------------------------------------------------- */

PairDefeJoint::TiePoint PairDefeJoint::tie_point(int d, int s) const
{
  const auto &jt = sys->joints;
  double **x = atom->x;
  const auto &node = jt.tie_node[~jt.nb[d][s]];
  Vec3 p[4], point = Vec3::Zero(), middle = Vec3::Zero();
  for (int a = 0; a < 4; a++) {
    p[a] = Vec3(x[node[a]]);
    point += defe::tie_weight[a] * p[a];
    middle += 0.25 * p[a];
  }
  TiePoint tie;
  tie.y = point - Vec3(x[jt.self[d]]);
  tie.normal = (p[2] - p[0]).cross(p[3] - p[1]).normalized();
  if (tie.normal.dot(tie.y) < 0.0) tie.normal = -tie.normal;
  Mat3 inertia = Mat3::Zero();
  for (int a = 0; a < 4; a++) {
    tie.arm[a] = p[a] - middle;
    inertia += tie.arm[a].squaredNorm() * Mat3::Identity() - tie.arm[a] * tie.arm[a].transpose();
  }
  tie.inertia_inverse = inertia.inverse();
  return tie;
}

/* ----------------------------------------------------------------------
   what a softening joint lets go in this step beside its dissipation: what a coarse step loses, and with
   the first force since the switch, this much less of what the corners let go
------------------------------------------------------------------------- */

double PairDefeJoint::release_of_step(JointSlot &slot, const defe::CohesiveResult &r)
{
  if (!slot.pending) return slot.area * r.excess;
  slot.pending = 0;
  return slot.area * (r.work_new - r.dissipated) - slot.stored;
}

/* ----------------------------------------------------------------------
   a softening tie. Its arm y turns with the face (least squares over the four nodes), and the
   face takes the moment y x F as forces on them, so that angular momentum is kept and no work is
   lost. Where neighbours carry the same shear these forces cancel. The DE cannot take the
   moment: nothing holds its spin, it would roll away under any shear.
------------------------------------------------------------------------- */

void PairDefeJoint::cohesive_tie(int d, int s)
{
  auto &jt = sys->joints;
  double **v = atom->v;
  double **f = atom->f;
  const double dt = update->setupflag ? 0.0 : update->dt;
  JointSlot &slot = jt.rec[d]->slot[s];
  const int i = jt.self[d];
  const auto &law = sys->model.adhesive_of(jt.material[d], slot.part)->law;
  const auto &moduli = table[jt.material[d]];
  const auto stiffness = defe::joint_stiffness(moduli.lambda, moduli.mu, jt.len[d][s]);
  const auto &node = jt.tie_node[~jt.nb[d][s]];
  auto state = defe::CohesiveState::unpack(slot.cohesive);

  const TiePoint tie = tie_point(d, s);
  const Vec3 &n = tie.normal;
  Vec3 slide = -Vec3(v[i]), spin = Vec3::Zero();
  for (int a = 0; a < 4; a++) {
    slide += defe::tie_weight[a] * Vec3(v[node[a]]);
    spin += tie.arm[a].cross(Vec3(v[node[a]]));
  }
  slide -= (tie.inertia_inverse * spin).cross(tie.y);
  slide -= slide.dot(n) * n;
  defe::cohesive_rotate(state, n);
  const auto r = defe::cohesive_update(state, tie.y.dot(n) - slot.length0 - state.e_n, dt * slide,
                                       stiffness, law);
  // the evaluation before a run is no step: not even the last digit changes
  if (!update->setupflag) state.pack(slot.cohesive);

  // of all that is lost until it breaks, G_f is the share of the fracture energy

  auto &ledger = sys->ledger;
  const double delta_c = 2.0 * law.G_f / state.s0;
  const double share = delta_c / (delta_c + state.s0 / stiffness.k_n);
  const double lost = slot.area * r.dissipated;
  ledger.fracture += share * lost;
  ledger.release += (1.0 - share) * lost;
  slot.lost += lost;
  if (!update->setupflag) slot.stored = slot.area * r.stored;
  if (r.broken) slot.stored = 0.0;
  ledger.release += release_of_step(slot, r);

  if (r.broken) {
    set_broken(d, s);
    jt.debonded.push_back(6 * d + s);
    event(d, s, defe::EventKind::DEBONDED, r.damage);
    return;
  }
  sys->stored.cohesive += slot.stored;

  const Vec3 force = slot.area * (r.t_n * n + r.t_s);
  const Vec3 turn = tie.inertia_inverse * tie.y.cross(force);
  const auto &grid = sys->sums.force_grid();
  for (int k = 0; k < 3; k++) f[i][k] += sys->sums.on_grid(grid, force[k], i);
  for (int a = 0; a < 4; a++) {
    const Vec3 on_node = turn.cross(tie.arm[a]) - defe::tie_weight[a] * force;
    for (int k = 0; k < 3; k++) f[node[a]][k] += sys->sums.on_grid(grid, on_node[k], node[a]);
    if (vflag_global || vflag_atom) {
      // relative to the DE: its own force has no share then
      const double *xa = atom->x[node[a]], *xi = atom->x[i];
      const double del[3] = {xa[0] - xi[0], xa[1] - xi[1], xa[2] - xi[2]};
      tally(del, on_node.data(), i);
    }
  }
}

/* ----------------------------------------------------------------------
   softening joints, each by the rank of its lower ID
------------------------------------------------------------------------- */

void PairDefeJoint::cohesive_forces()
{
  auto &jt = sys->joints;
  double **x = atom->x;
  double **v = atom->v;
  double **f = atom->f;
  double **omega = atom->omega;
  double **torque = atom->torque;
  const double dt = update->setupflag ? 0.0 : update->dt;

  jt.debonded.clear();
  if (with_cracks) take_over_cracks();
  size_t kept = 0;
  for (size_t q = 0; q < jt.cohesive.size(); q++) {
    const int d = jt.cohesive[q] / 6, s = jt.cohesive[q] % 6;
    JointSlot &slot = jt.rec[d]->slot[s];
    if (slot.kind == DefeJoint::TIE) {
      cohesive_tie(d, s);
      if (slot.state == DefeJoint::COHESIVE) jt.cohesive[kept++] = jt.cohesive[q];
      continue;
    }
    if (by_crack(d, s)) {
      crack_forces(d, s);
      if (slot.state == DefeJoint::COHESIVE || slot.plane) jt.cohesive[kept++] = jt.cohesive[q];
      continue;
    }
    const int i = jt.self[d], j = jt.nb[d][s];
    const Coeff &c = coeff_of(atom->type[i], atom->type[j]);
    const auto &moduli = table[jt.material[d]];
    const auto stiffness = defe::joint_stiffness(moduli.lambda, moduli.mu, jt.len[d][s]);
    auto state = defe::CohesiveState::unpack(slot.cohesive);

    const Vec3 y(x[j][0] - x[i][0], x[j][1] - x[i][1], x[j][2] - x[i][2]);
    const double length = y.norm();
    const Vec3 n = y / length;
    const Vec3 w(0.5 * (omega[i][0] + omega[j][0]), 0.5 * (omega[i][1] + omega[j][1]),
                 0.5 * (omega[i][2] + omega[j][2]));
    Vec3 slide = Vec3(v[j][0] - v[i][0], v[j][1] - v[i][1], v[j][2] - v[i][2]) - w.cross(y);
    slide -= slide.dot(n) * n;
    defe::cohesive_rotate(state, n);
    const auto r = defe::cohesive_update(state, length - slot.length0 - state.e_n, dt * slide,
                                         stiffness, c.cohesive);
    if (!update->setupflag) state.pack(slot.cohesive);

    // of all that is lost until it breaks, G_f is the share of the fracture energy

    const double delta_c = 2.0 * c.cohesive.G_f / state.s0;
    const double share = delta_c / (delta_c + state.s0 / stiffness.k_n);
    const double lost = slot.area * r.dissipated;
    sys->ledger.fracture += share * lost;
    sys->ledger.release += (1.0 - share) * lost;
    slot.lost += lost;
    if (!update->setupflag) slot.stored = slot.area * r.stored;
    if (r.broken) slot.stored = 0.0;
    sys->ledger.release += release_of_step(slot, r);

    if (r.broken) {
      set_broken(d, s);
      event(d, s, defe::EventKind::BROKEN, r.damage);
      continue;
    }
    jt.cohesive[kept++] = jt.cohesive[q];
    sys->stored.cohesive += slot.stored;

    const Vec3 force = on_grid(slot.area * (r.t_n * n + r.t_s), i, false);
    const Vec3 moment = on_grid(0.5 * y.cross(force), i, true);
    for (int k = 0; k < 3; k++) {
      f[i][k] += force[k];
      f[j][k] -= force[k];
      torque[i][k] += moment[k];
      torque[j][k] += moment[k];
    }
    if (vflag_global || vflag_atom) {
      const double del[3] = {-y[0], -y[1], -y[2]};
      tally(del, force.data(), i);
    }
  }
  jt.cohesive.resize(kept);
}

/* ----------------------------------------------------------------------
   spheres near each other that no joint holds
   An own search: LAMMPS' neighbour lists would be built over all nodes. Each owner computes its side
   of a pair that two ranks share.
------------------------------------------------------------------------- */

void PairDefeJoint::add_candidate(int i, int j, double apart)
{
  if (!with_contact || j < 0) return;    // a tie: the face takes over
  if (j < atom->nlocal && j < i) std::swap(i, j);
  candidates.push_back({i, j, apart});
  broken_now.emplace_back(MIN(atom->tag[i], atom->tag[j]), MAX(atom->tag[i], atom->tag[j]));
}

void PairDefeJoint::update_candidates()
{
  if (candidates_built == sys->tables.built()) return;
  candidates_built = sys->tables.built();
  candidates.clear();
  auto &jt = sys->joints;
  if (sys->census.des() > 0) {
    jt.material.resize(jt.nall);    // those of ghosts come from their owners
    comm_mode = PARTS;
    comm->forward_comm(this, 1);
  }
  double **x = atom->x;
  const int *type = atom->type;
  const double *radius = atom->radius;
  const int nlocal = atom->nlocal;
  const int nall = nlocal + atom->nghost;

  // DEs and spheres of other origin that are not much larger go into a grid; large ones, of which
  // there are few, meet all others

  std::vector<int> small(jt.self), large;
  double largest = 0.0;
  for (int i : small) largest = MAX(largest, MAX(radius[i], sys->surface.reach_of(i)));
  const double limit = 4.0 * largest;
  for (int i = 0; i < nall; i++) {
    if (radius[i] == 0.0 || (!jt.of_atom.empty() && jt.of_atom[i] >= 0)) continue;
    if (!meets_des[type[i]]) continue;
    (radius[i] <= limit ? small : large).push_back(i);
    if (radius[i] <= limit) largest = MAX(largest, radius[i]);
  }
  if (jt.self.empty()) return;    // spheres of other origin have no law between them

  const double skin = neighbor->skin;
  const auto consider = [&](int i, int j) {
    if (i >= nlocal) std::swap(i, j);
    if (i >= nlocal) return;
    if (j < nlocal && j < i) std::swap(i, j);
    const int di = jt.of_atom[i], dj = jt.of_atom[j];
    if (di < 0 && dj < 0) return;
    if (!acts_on(type[i], type[j])) return;
    const bool with_ball = di < 0 || dj < 0;
    // with a ball: by the rank of the DE alone; the ball's force comes back with the ghosts
    if (with_ball && di < 0) {
      if (j >= nlocal) return;
      std::swap(i, j);
    }
    const double reach =
        (with_ball ? sys->surface.reach_of(i) + sys->surface.reach_of(j) : radius[i] + radius[j]) +
        skin;
    double rsq = 0.0;
    for (int k = 0; k < 3; k++) rsq += (x[i][k] - x[j][k]) * (x[i][k] - x[j][k]);
    if (rsq >= reach * reach) return;
    if (!with_ball)
      for (int s = 0; s < 6; s++) {
        const int nb = jt.nb[di][s];    // a joint may have broken since the tables were made
        if (nb >= 0 && nb != i && atom->tag[nb] == atom->tag[j] &&
            jt.state[6 * di + s] != DefeJoint::CONTACT)    // its plane may still take it
          return;
      }
    candidates.push_back({i, j, with_ball ? 0.0 : jt.distance_apart(di, atom->tag[j])});
  };

  struct Sphere {
    double x[3];
    int atom;
  };
  std::vector<Sphere> spheres;
  spheres.reserve(small.size());
  for (int i : small) spheres.push_back({{x[i][0], x[i][1], x[i][2]}, i});
  const double farthest = 2.0 * largest + skin;
  const defe::CellList<Sphere> list(std::move(spheres), farthest);
  for (int a = 0; a < static_cast<int>(list.all().size()); a++) {
    const Sphere &one = list.all()[a];
    list.runs_around(one.x, [&](int first, int last) {
      for (int b = MAX(first, a + 1); b < last; b++) {
        const Sphere &other = list.all()[b];
        double rsq = 0.0;
        for (int k = 0; k < 3; k++) rsq += (one.x[k] - other.x[k]) * (one.x[k] - other.x[k]);
        if (rsq < farthest * farthest) consider(one.atom, other.atom);
      }
    });
  }
  for (size_t a = 0; a < large.size(); a++)
    for (int i : small) consider(large[a], i);
}

/* ---------------------------------------------------------------------- */

void PairDefeJoint::forget_touch(int i, int j)
{
  AtomTouch *t = sys->store.touches(i);
  if (!t) return;
  for (auto &s : t->spheres)
    if (s.other == atom->tag[j]) {
      s = t->spheres.back();
      t->spheres.pop_back();
      return;
    }
}

/* ----------------------------------------------------------------------
   of exact sums, if they are asked for: the force of a tie on the nodes of its face, and a contribution
------------------------------------------------------------------------- */

void PairDefeJoint::pull_exactly(const int *node, const double *force)
{
  for (int a = 0; a < 4; a++)
    for (int k = 0; k < 3; k++)
      atom->f[node[a]][k] -=
          sys->sums.on_grid(sys->sums.force_grid(), defe::tie_weight[a] * force[k], node[a]);
}

Vec3 PairDefeJoint::on_grid(Vec3 value, int i, bool torque)
{
  const auto &grid = torque ? sys->sums.torque_grid() : sys->sums.force_grid();
  for (double &v : value) v = sys->sums.on_grid(grid, v, i);
  return value;
}

/* ----------------------------------------------------------------------
   loose contacts
------------------------------------------------------------------------- */

void PairDefeJoint::contact_forces()
{
  update_candidates();
  std::sort(broken_now.begin(), broken_now.end());
  const auto &jt = sys->joints;
  double **x = atom->x;
  double **v = atom->v;
  double **f = atom->f;
  double **omega = atom->omega;
  double **torque = atom->torque;
  const double *radius = atom->radius;
  const double *rmass = atom->rmass;
  const int *type = atom->type;
  const int nlocal = atom->nlocal;
  const double dt = update->setupflag ? 0.0 : update->dt;

  const auto spring = [this](int i, int j) -> double * {
    SphereTouch *touch = find_touch(i, j);
    if (!touch) touch = &new_touch(i, j);
    return touch->shear;
  };

  for (const auto &c : candidates) {
    const int i = c.i, j = c.j;
    if (jt.of_atom[j] < 0) {
      contact_with_ball(i, j);
      continue;
    }
    // the two owners compute the same numbers if both begin with the same DE
    const bool turned = sys->model.reproducible && atom->tag[i] > atom->tag[j];
    const int a = turned ? j : i, b = turned ? i : j;
    const double sign = turned ? -1.0 : 1.0;
    const bool whole = j < nlocal;    // else the other half belongs to the other owner
    const double del[3] = {x[a][0] - x[b][0], x[a][1] - x[b][1], x[a][2] - x[b][2]};
    const double rsq = del[0] * del[0] + del[1] * del[1] + del[2] * del[2];
    const int da = jt.of_atom[a], db = jt.of_atom[b];
    const double ra = radius[a], rb = radius[b];
    double reach = ra + rb;
    bool apart = rsq >= reach * reach;

    // spheres of flat cells overlap from the start: contact begins at the reference distance

    if (!apart) {
      const double *Xa = sys->store.x_frame(a), *Xb = sys->store.x_frame(b);
      double ref = 0.0;
      for (int k = 0; k < 3; k++) ref += (Xa[k] - Xb[k]) * (Xa[k] - Xb[k]);
      reach = MIN(reach, std::sqrt(ref));
      if (c.apart > 0.0) reach = MIN(reach, c.apart);
      apart = rsq >= reach * reach;
    }
    if (apart) {
      forget_touch(i, j);
      if (whole) forget_touch(j, i);
      continue;
    }

    const Coeff &coeff = coeff_of(type[i], type[j]);
    double E = 0.0, nu = 0.2;
    for (int d : {da, db}) {
      const int part = jt.material[d];
      if (E == 0.0 || young[part] < E) {
        E = young[part];
        nu = 0.5 * table[part].lambda / (table[part].lambda + table[part].mu);
      }
    }
    if (E == 0.0) continue;
    const double kn = E * MIN(2.0 * MIN(radius[i], radius[j]), reach);
    auto par = defe::ContactParameters{kn, kn * 2.0 * (1.0 - nu) / (2.0 - nu), coeff.restitution,
                                       coeff.friction, coeff.damping_ratio};
    double *shear = spring(i, j);
    Vec3 history(sign * shear[0], sign * shear[1], sign * shear[2]);
    auto r = defe::sphere_contact(
        Vec3(del[0], del[1], del[2]), Vec3(v[a][0] - v[b][0], v[a][1] - v[b][1], v[a][2] - v[b][2]),
        Vec3(omega[a][0], omega[a][1], omega[a][2]), Vec3(omega[b][0], omega[b][1], omega[b][2]),
        ra, rb, reach, rmass[a] * rmass[b] / (rmass[a] + rmass[b]), dt, history, par);
    // the evaluation before a run is no step: springs stay as they are, nothing is rubbed off
    if (update->setupflag)
      r.stored += 0.5 * par.kt * (Vec3(shear).squaredNorm() - history.squaredNorm());
    else {
      for (int k = 0; k < 3; k++) shear[k] = sign * history[k];
      if (whole) {
        double *other = spring(j, i);
        for (int k = 0; k < 3; k++) other[k] = -sign * history[k];
      }
    }

    const Vec3 force = on_grid(r.force, i, false);
    const Vec3 torque_i = on_grid(turned ? r.torque_j : r.torque_i, i, true);
    for (int k = 0; k < 3; k++) {
      f[i][k] += sign * force[k];
      torque[i][k] += torque_i[k];
    }
    if (whole) {
      const Vec3 torque_j = on_grid(turned ? r.torque_i : r.torque_j, j, true);
      for (int k = 0; k < 3; k++) {
        f[j][k] -= sign * force[k];
        torque[j][k] += torque_j[k];
      }
    }
    const double share = whole ? 1.0 : 0.5;
    sys->stored.contact += share * r.stored;
    // a joint that broke while it was pressed: this much of what it held is still here
    if (!broken_now.empty() &&
        std::binary_search(
            broken_now.begin(), broken_now.end(),
            std::make_pair(MIN(atom->tag[i], atom->tag[j]), MAX(atom->tag[i], atom->tag[j]))))
      sys->ledger.release -= share * r.stored;
    if (!update->setupflag) {
      sys->ledger.damping += share * r.damped;
      sys->ledger.friction += share * r.rubbed;
    }
    if (vflag_global || vflag_atom) {
      const double half[3] = {share * del[0], share * del[1], share * del[2]};
      tally(half, r.force.data(), i);
    }
  }
  broken_now.clear();
}

/* ----------------------------------------------------------------------
   a DE of this rank and a ball, owned or ghost. The DE is a patch of the surface that the ball presses
   on (ball_on_patch); one that was just born takes over what the face of its element stored.
------------------------------------------------------------------------- */

void PairDefeJoint::contact_with_ball(int i, int j)
{
  double **x = atom->x;
  double **v = atom->v;
  double **omega = atom->omega;
  const auto &jt = sys->joints;
  const double dt = update->setupflag ? 0.0 : update->dt;
  const Vec3 del = Vec3(x[i]) - Vec3(x[j]), speed = Vec3(v[i]) - Vec3(v[j]);
  const double ri = sys->surface.reach_of(i), rj = atom->radius[j], distance = del.norm();
  const double overlap = ri + rj - distance;
  SphereTouch *touch = find_touch(i, j);
  const bool inherits = touch && touch->inherit >= 0.0;
  const double offset = touch ? touch->offset : 0.0;
  if (!inherits && overlap <= offset) {
    forget_touch(i, j);
    return;
  }
  const int part = jt.material[jt.of_atom[i]];
  const double area = jt.rec[jt.of_atom[i]]->outer_area;
  const double k_area = sys->surface.ball_stiffness(part, i) / area;
  const Coeff &coeff = coeff_of(atom->type[i], atom->type[j]);
  if (!(k_area > 0.0)) return;
  if (!touch) {
    touch = &new_touch(i, j);
    // an overlap that no motion has made
    if (overlap > 4.0 * dt * speed.norm() + 1.0e-6 * ri) touch->offset = overlap;
  } else if (inherits)
    touch->offset = overlap - defe::overlap_of_energy(touch->inherit, rj, area, k_area);
  const double deep = overlap - touch->offset;
  const auto push = defe::ball_on_patch(deep, rj, area, k_area);
  if (!(deep > 0.0)) {
    if (inherits) touch->inherit = -1.0;
    return;
  }

  const double kn = push.force / deep;
  const double nu = 0.5 * table[part].lambda / (table[part].lambda + table[part].mu);
  const defe::ContactParameters par{kn, kn * 2.0 * (1.0 - nu) / (2.0 - nu), coeff.restitution,
                                    coeff.friction, coeff.damping_ratio * push.damping_factor};
  Vec3 history(touch->shear);
  auto r = defe::sphere_contact(
      del, speed, Vec3(omega[i]), Vec3(omega[j]), ri, rj, ri + rj - touch->offset,
      atom->rmass[i] * atom->rmass[j] / (atom->rmass[i] + atom->rmass[j]), dt, history, par);
  r.stored += push.energy - 0.5 * push.force * deep;
  if (inherits) {
    // the kicks of velocity Verlet belong to the old force up to half-way between the two steps
    sys->ledger.conv_strain -=
        push.energy + 0.5 * dt * (push.force - touch->push) * speed.dot(del) / distance;
    touch->inherit = -1.0;
  }
  // the evaluation before a run is no step: springs stay as they are, nothing is rubbed off
  if (update->setupflag)
    r.stored += 0.5 * par.kt * (Vec3(touch->shear).squaredNorm() - history.squaredNorm());
  else {
    for (int k = 0; k < 3; k++) touch->shear[k] = history[k];
    sys->ledger.damping += r.damped;
    sys->ledger.friction += r.rubbed;
  }
  const Vec3 force = on_grid(r.force, i, false);
  const Vec3 torque_i = on_grid(r.torque_i, i, true), torque_j = on_grid(r.torque_j, j, true);
  for (int k = 0; k < 3; k++) {
    atom->f[i][k] += force[k];
    atom->f[j][k] -= force[k];
    atom->torque[i][k] += torque_i[k];
    atom->torque[j][k] += torque_j[k];
  }
  sys->stored.contact += r.stored;
  if (vflag_global || vflag_atom) tally(del.data(), r.force.data(), i);
}

SphereTouch *PairDefeJoint::find_touch(int i, int j)
{
  AtomTouch *t = sys->store.touches(i);
  if (t)
    for (auto &s : t->spheres)
      if (s.other == atom->tag[j]) return &s;
  return nullptr;
}

SphereTouch &PairDefeJoint::new_touch(int i, int j)
{
  auto &list = sys->store.touch_at(i).spheres;
  list.push_back({atom->tag[j], {0.0, 0.0, 0.0}, 0.0, -1.0, 0.0});
  return list.back();
}

/* ---------------------------------------------------------------------- */

int PairDefeJoint::pack_forward_comm(int n, int *list, double *buf, int, int *)
{
  if (n == 0) return 0;    // tiled ranks send empty messages, too
  if (comm_mode == CRACK_STRESS) return cracks->pack_stress(n, list, buf);
  const auto &jt = sys->joints;
  int m = 0;
  for (int k = 0; k < n; k++) {
    const int d = jt.of_atom[list[k]];
    if (d < 0) continue;
    if (comm_mode == HALF_FORCES) {
      memcpy(&buf[m], jt.half_force[d].data(), 18 * sizeof(double));
      m += 18;
      if (with_cracks) m += cracks->pack_energy(d, &buf[m]);
    } else if (comm_mode == PARTS)
      buf[m++] = jt.material[d];
    else if (comm_mode == CRACK_TABLE)
      m += cracks->pack_table(d, &buf[m]);
    else
      m += pack_state(d, &buf[m]);
  }
  return m;
}

void PairDefeJoint::unpack_forward_comm(int n, int first, double *buf)
{
  if (n == 0) return;
  if (comm_mode == CRACK_STRESS) {
    cracks->unpack_stress(first, buf);
    return;
  }
  auto &jt = sys->joints;
  int m = 0;
  for (int i = first; i < first + n; i++) {
    const int d = jt.of_atom[i];
    if (d < 0) continue;
    if (comm_mode == HALF_FORCES) {
      memcpy(jt.half_force[d].data(), &buf[m], 18 * sizeof(double));
      m += 18;
      if (with_cracks) m += cracks->unpack_energy(d, &buf[m]);
    } else if (comm_mode == PARTS)
      jt.material[d] = static_cast<unsigned char>(buf[m++]);
    else if (comm_mode == CRACK_TABLE)
      m += cracks->unpack_table(d, &buf[m]);
    else
      m += unpack_state(d, &buf[m]);
  }
}

/* ---------------------------------------------------------------------- */

void PairDefeJoint::write_restart(FILE *fp)
{
  write_restart_settings(fp);
  const int n = atom_types;
  fwrite(&n, sizeof(int), 1, fp);
  fwrite(coeffs.data(), sizeof(Coeff), coeffs.size(), fp);
}

void PairDefeJoint::read_restart(FILE *fp)
{
  read_restart_settings(fp);
  allocate();
  int n = 0;
  if (comm->me == 0) utils::sfread(FLERR, &n, sizeof(int), 1, fp, nullptr, error);
  MPI_Bcast(&n, 1, MPI_INT, 0, world);
  if (n != atom_types)
    error->all(FLERR, "Pair style defe/* in the restart file has {} atom types, not {}", n,
               atom_types);
  if (comm->me == 0)
    utils::sfread(FLERR, coeffs.data(), sizeof(Coeff), coeffs.size(), fp, nullptr, error);
  MPI_Bcast(coeffs.data(), static_cast<int>(coeffs.size() * sizeof(Coeff)), MPI_BYTE, 0, world);
}

/* ----------------------------------------------------------------------
   hybrid asks its sub-styles for these alone. It is the first that DEFE sees of a restart
   file: all of the file is checked here, before more of it is used
------------------------------------------------------------------------- */

void PairDefeJoint::write_restart_settings(FILE *fp)
{
  mark_restart_file(fp);
}

void PairDefeJoint::read_restart_settings(FILE *fp)
{
  check_restart_file(lmp, fp);
}

double PairDefeJoint::memory_usage()
{
  return static_cast<double>(candidates.capacity()) * sizeof(Candidate) +
      (cracks ? cracks->memory_usage() : 0.0) + Pair::memory_usage();
}
