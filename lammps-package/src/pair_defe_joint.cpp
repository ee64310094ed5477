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
#include "defe_sphere_contacts.h"
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

#include <algorithm>
#include <cmath>
#include <cstring>

using namespace LAMMPS_NS;
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
  laws.set_types(atom->ntypes);
  const int n = laws.types + 1;
  memory->create(setflag, n, n, "pair:setflag");
  memory->create(cutsq, n, n, "pair:cutsq");

  // types of nodes need no coefficients; those of DEs are checked in init_style

  for (int i = 1; i < n; i++)
    for (int j = 1; j < n; j++) {
      setflag[i][j] = 1;
      cutsq[i][j] = 0.0;
    }
}

void PairDefeJoint::settings(int narg, char **arg)
{
  if (narg)
    error->all(FLERR, "Pair style {} takes no arguments, not {}; its numbers go to pair_coeff",
               force->pair_style ? force->pair_style : "defe/*", arg[0]);

  // without any pair_coeff it is init_style that says which ones are needed

  if (domain->box_exist && !allocated) allocate();
}

void PairDefeJoint::coeff(int narg, char **arg)
{
  if (narg < 3) utils::missing_cmd_args(FLERR, "pair_coeff", error);
  if (!allocated) allocate();
  JointCoeffReader(lmp, narg, arg).read(laws);
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
  screen_built = -1;    // it may be another fix than before
  contacts = std::make_unique<DefeSphereContacts>(*sys, laws);

  // no neighbour list is requested: nodes are the most of all atoms and would fill it, see
  // DefeSphereContacts::search()

  // elastic constants of each part

  laws.moduli = sys->model.corner_moduli;
  laws.young.clear();
  for (const auto &p : sys->model.parts)
    laws.young.push_back(sys->model.material_of(p).elastic().E);
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
  tally.all = vflag_global ? virial : nullptr;
  tally.each = vflag_atom ? vatom : nullptr;
  auto &stored = sys->stored;
  stored = defe::StoredEnergy();
  if (sys->census.des() > 0) {
    update_screen();
    if (laws.with_cohesive) switch_joints();    // of the last step
    connective_and_ties();
    if (laws.with_cohesive) {
      cohesive_forces();
      criterion();
    }
  }
  if (laws.with_contact) contact_forces();
  if (eflag_global) eng_vdwl += stored.joints + stored.ties + stored.cohesive + stored.contact;
}

/* ---------------------------------------------------------------------- */

void PairDefeJoint::connective_and_ties()
{
  if (!laws.with_connective) {
    without_connective();
    return;
  }
  half_forces();
  comm_mode = HALF_FORCES;
  comm->forward_comm(this, with_cracks ? 18 + DefeCracks::ENERGY_SIZE : 18);
  reached.clear();
  for (int d = 0; d < sys->joints.nde; d++) gather(d);
  book_newborn();
}

void PairDefeJoint::without_connective()
{
  auto &jt = sys->joints;
  for (int d = 0; d < jt.nde; d++) {
    jt.present[d] = 0;
    for (int s = 0; s < 6; s++)
      if (jt.rec[d]->slot[s].kind != DefeJoint::NONE)
        jt.rec[d]->slot[s].state = jt.state[6 * d + s] = DefeJoint::CONTACT;
    jt.rec[d]->newborn = 0;
  }
  jt.newborn.clear();
}

/* ----------------------------------------------------------------------
   corners of my DEs
------------------------------------------------------------------------- */

void PairDefeJoint::half_forces()
{
  auto &jt = sys->joints;
  if (jt.nde == 0) return;
  const double *x = &atom->x[0][0];
  defe::tie_points(static_cast<int>(jt.tie_node.size()),
                   reinterpret_cast<const int(*)[4]>(jt.tie_node.data()), x, jt.tie_point.data());
  const defe::OrthogonalLattice lattice{jt.north,
                                        jt.self.data(),
                                        reinterpret_cast<const int(*)[6]>(jt.nb.data()),
                                        jt.present.data(),
                                        reinterpret_cast<const double(*)[6]>(jt.len.data()),
                                        reinterpret_cast<const double(*)[6]>(jt.half.data()),
                                        jt.material.data()};
  defe::corner_half_forces(lattice, jt.nde, jt.cell.data(), x, jt.tie_point.data(),
                           laws.moduli.data(), sys->model.reproducible,
                           reinterpret_cast<double(*)[6][3]>(jt.half_force.data()),
                           jt.energy.data());
}

/* ----------------------------------------------------------------------
   both halves of each joint of a DE; ties act on the nodes of the face
------------------------------------------------------------------------- */

void PairDefeJoint::gather(int d)
{
  const auto &jt = sys->joints;
  double **x = atom->x;
  double **f = atom->f;
  const int i = jt.self[d];
  const auto &grid = sys->sums.force_grid();
  const auto *half = reinterpret_cast<const double(*)[3]>(jt.half_force[d].data());
  double fi[3] = {0.0, 0.0, 0.0};
  int joints = 0, ties = 0;
  for (int s = 0; s < 6; s++) {
    if (!(jt.present[d] & (1u << s))) continue;
    const double *h = half[s];
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
      if (tally.on()) {
        const double del[3] = {x[i][0] - x[nb][0], x[i][1] - x[nb][1], x[i][2] - x[nb][2]};
        tally(del, h, i);
      }
    } else {
      const auto &node = jt.tie_node[~nb];
      for (int k = 0; k < 3; k++) fi[k] += h[k];
      for (int a = 0; a < 4; a++)
        for (int k = 0; k < 3; k++)
          f[node[a]][k] -= sys->sums.on_grid(grid, defe::tie_weight[a] * h[k], node[a]);
      if (h[0] * h[0] + h[1] * h[1] + h[2] * h[2] > screen[d][s]) reached.push_back(6 * d + s);
      ties++;
      if (tally.on()) {
        const double *p = &jt.tie_point[3 * ~nb];
        const double del[3] = {x[i][0] - p[0], x[i][1] - p[1], x[i][2] - p[2]};
        tally(del, h, i);
      }
    }
  }
  for (int k = 0; k < 3; k++) f[i][k] += sys->sums.on_grid(grid, fi[k], i);
  auto &stored = sys->stored;
  const double e = jt.energy[d];
  if (ties) {
    stored.ties += e * ties / (joints + ties);
    stored.joints += e * joints / (joints + ties);
  } else
    stored.joints += e;
}

/* ----------------------------------------------------------------------
   strain energy of DEs after their conversion, to set against what was there before
------------------------------------------------------------------------- */

void PairDefeJoint::book_newborn()
{
  auto &jt = sys->joints;
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
  if (update->setupflag && laws.with_cohesive) check_laws();
  if (with_cracks) update_crack_tables();
  const auto &jt = sys->joints;
  const std::array<double, 6> never = {HUGE_VAL, HUGE_VAL, HUGE_VAL, HUGE_VAL, HUGE_VAL, HUGE_VAL};
  screen.assign(jt.nde, never);
  mirrored.clear();
  if (!laws.with_cohesive) return;
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
      const auto &par = tie ? adhesive->law : laws.of(atom->type[i], atom->type[j]).cohesive;
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
  const auto &jt = sys->joints;
  drop_notes();
  for (int ds : reached)
    if (starts(ds / 6, ds % 6)) {
      note_joint(ds);
      const int other = jt.partner[ds / 6][ds % 6];
      if (other >= 0 && other < 6 * jt.nde) note_joint(other);
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
  contacts->add(jt.self[d], jt.nb[d][s]);
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
   spheres that no joint holds
------------------------------------------------------------------------- */

void PairDefeJoint::contact_forces()
{
  if (contacts->outdated()) {
    if (sys->census.des() > 0) {
      sys->joints.material.resize(sys->joints.nall);    // those of ghosts come from their owners
      comm_mode = PARTS;
      comm->forward_comm(this, 1);
    }
    contacts->search();
  }
  contacts->forces(tally);
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
  const int n = laws.types;
  fwrite(&n, sizeof(int), 1, fp);
  fwrite(laws.coeffs.data(), sizeof(JointCoeff), laws.coeffs.size(), fp);
}

void PairDefeJoint::read_restart(FILE *fp)
{
  read_restart_settings(fp);
  allocate();
  int n = 0;
  if (comm->me == 0) utils::sfread(FLERR, &n, sizeof(int), 1, fp, nullptr, error);
  MPI_Bcast(&n, 1, MPI_INT, 0, world);
  if (n != laws.types)
    error->all(FLERR, "Pair style defe/* in the restart file has {} atom types, not {}", n,
               laws.types);
  if (comm->me == 0)
    utils::sfread(FLERR, laws.coeffs.data(), sizeof(JointCoeff), laws.coeffs.size(), fp, nullptr,
                  error);
  MPI_Bcast(laws.coeffs.data(), static_cast<int>(laws.coeffs.size() * sizeof(JointCoeff)), MPI_BYTE,
            0, world);
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
  return (contacts ? contacts->memory_usage() : 0.0) + (cracks ? cracks->memory_usage() : 0.0) +
      Pair::memory_usage();
}
