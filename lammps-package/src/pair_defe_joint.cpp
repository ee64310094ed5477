/* ----------------------------------------------------------------------
   DEFE: adaptive finite elements to bonded discrete elements for LAMMPS
   https://www.lammps.org/
   This software is distributed under the GNU General Public License.

   Bonded spheres. Joints and ties are coupling/joint_states.h; here are the arrays of LAMMPS, the messages
   between its steps, and what comes of them: events, contacts of spheres, energy and virial.
------------------------------------------------------------------------- */

#include "pair_defe_joint.h"

#include "defe_crack_host.h"
#include "defe_joint_coeffs.h"
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

#include <cmath>

using namespace LAMMPS_NS;

/* ---------------------------------------------------------------------- */

PairDefeJoint::PairDefeJoint(LAMMPS *lmp) : Pair(lmp)
{
  single_enable = 0;
  restartinfo = 1;
  no_virial_fdotr_compute = 1;
  centroidstressflag = CENTROID_NOTAVAIL;
  finitecutflag = 1;
  comm_forward = defe::JointCracks::STRESS_SIZE;    // the most; pair_style hybrid asks at once
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
  tables_seen = -1;    // it may be another fix than before
  contacts = std::make_unique<DefeSphereContacts>(*sys, laws);

  // no neighbour list is requested: nodes are the most of all atoms and would fill it, see
  // DefeSphereContacts::search()

  // elastic constants of each part

  laws.adhesives = sys->model.adhesives;
  laws.moduli = sys->model.corner_moduli;
  laws.young.clear();
  for (const auto &p : sys->model.parts)
    laws.young.push_back(sys->model.material_of(p).elastic().E);
  check_coefficients();
  tell_of_other_spheres();
  make_states();
}

/* ----------------------------------------------------------------------
   cracks are followed if they open the joints of any pair of types
------------------------------------------------------------------------- */

void PairDefeJoint::make_states()
{
  crack_host = std::make_unique<DefeCrackHost>(*sys);
  states =
      std::make_unique<defe::JointStates>(sys->joints, laws, sys->ledger, sys->stored, *crack_host);
  if (states->cracks() && laws.types >= defe::JointCracks::most_types)
    error->all(FLERR, "Pair style defe/* follows cracks with up to {} atom types, not {}",
               defe::JointCracks::most_types - 1, laws.types);
  sys->marks.let_cracks_ask(states->cracks() != nullptr);
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

defe::MovingParticles PairDefeJoint::particles() const
{
  defe::MovingParticles p;
  p.nlocal = atom->nlocal;
  p.nall = atom->nlocal + atom->nghost;
  if (p.nall == 0) return p;
  p.x = &atom->x[0][0];
  p.X = sys->store.x_frame(0);
  p.radius = atom->radius;
  p.id = atom->tag;
  p.v = &atom->v[0][0];
  p.omega = &atom->omega[0][0];
  p.type = atom->type;
  return p;
}

defe::JointView PairDefeJoint::view(int d, int s)
{
  states->set_particles(particles());
  return states->view(6 * d + s);
}

/* ---------------------------------------------------------------------- */

void PairDefeJoint::compute(int eflag, int vflag)
{
  ev_init(eflag, vflag);
  defe::ForceSums sums{nullptr, nullptr, &sys->sums.rounding(), {}};
  if (atom->nlocal + atom->nghost > 0) {
    sums.f = &atom->f[0][0];
    sums.torque = &atom->torque[0][0];
  }
  sums.tally = {vflag_global ? virial : nullptr, vflag_atom ? vatom : nullptr};
  auto &stored = sys->stored;
  stored = defe::StoredEnergy();
  if (sys->census.des() > 0) joint_forces(sums);
  if (laws.with_contact) contact_forces(sums.tally);
  if (eflag_global) eng_vdwl += stored.joints + stored.ties + stored.cohesive + stored.contact;
}

void PairDefeJoint::joint_forces(defe::ForceSums &sums)
{
  const bool moving = !update->setupflag;
  states->begin(particles(), moving ? update->dt : 0.0, moving);
  update_tables();
  if (laws.with_cohesive) states->switch_pending();    // of the last step
  if (laws.with_connective) {
    states->half_forces(sys->model.reproducible);
    forward(FORCES, states->forces_size());
    states->gather(sums);
  } else
    states->without_connective();
  for (int d : sys->joints.newborn) sys->joints.rec(d)->newborn = 0;
  sys->joints.newborn.clear();
  if (laws.with_cohesive) {
    states->soften(sums);
    strength_reached();
  }
  report();
}

void PairDefeJoint::strength_reached()
{
  states->find_pending();
  // cracks are decided on with the clock of the finite elements: on its way through a DE a crack meets several of
  // their steps
  if (states->cracks() && !update->setupflag && sys->clock.subcycle().due()) {
    sys->strengths.grow_des(*states->cracks());
    states->cracks()->mark();
    forward(CRACK_STRESS, defe::JointCracks::STRESS_SIZE);
    states->decide_cracks();
  }
  forward(STATES, states->states_size());
  states->adopt_states();
}

void PairDefeJoint::update_tables()
{
  if (tables_seen == sys->tables.built()) return;
  tables_seen = sys->tables.built();
  if (update->setupflag && laws.with_cohesive) check_laws();
  if (auto *cracks = states->cracks()) {
    cracks->prepare();
    forward(CRACK_TABLE, defe::JointCracks::TABLE_SIZE);
    cracks->resolve();
  }
  states->new_tables();
}

/* ----------------------------------------------------------------------
   before a run: what has begun to soften, or is a closed plane, goes on by the law that it began with
------------------------------------------------------------------------- */

void PairDefeJoint::check_laws()
{
  const auto found = states->of_other_law();
  bigint mine = found.count, all = 0;
  int example = found.count ? found.first : MAXSMALLINT, first = MAXSMALLINT;
  MPI_Allreduce(&mine, &all, 1, MPI_LMP_BIGINT, MPI_SUM, world);
  if (all == 0) return;
  MPI_Allreduce(&example, &first, 1, MPI_INT, MPI_MIN, world);
  const int types = first / 2;
  const std::string before = defe::names_of_opening_laws(first % 2);
  error->all(FLERR,
             "Pair_coeff {} {} cohesive: {} joints have cracked by the law {}, which cannot "
             "change: give it {} as before",
             types / (laws.types + 1), types % (laws.types + 1), all, before, before);
}

/* ----------------------------------------------------------------------
   what joints did in this evaluation
------------------------------------------------------------------------- */

void PairDefeJoint::report()
{
  if (states->damaged()) sys->account.note_damage();
  for (const auto &e : states->events()) record(e);
  for (const auto &pair : states->broken()) contacts->add(pair.i, pair.j, pair.distance);
}

void PairDefeJoint::record(const defe::JointEvent &what)
{
  const auto &jt = sys->joints;
  const int d = what.joint / 6, s = what.joint % 6;
  const int i = jt.self[d], j = jt.nb[d][s];
  const JointRecord &slot = jt.record(what.joint);
  const bool tie = slot.kind == DefeJoint::TIE;
  const double *Xi = sys->store.x_frame(i), *Xj = tie ? nullptr : sys->store.x_frame(j);
  defe::Event e;
  e.step = update->ntimestep;
  e.time = sys->clock.now();
  e.what = what.what;
  e.a = atom->tag[i];
  e.b = jt.rec(d)->other[s];
  double len = 0.0;
  for (int k = 0; k < 3; k++) {
    e.x[k] = tie ? Xi[k] + slot.face[k] : Xi[k] + what.f * (Xj[k] - Xi[k]);
    e.n[k] = what.has_plane ? what.m[k] : tie ? slot.normal[k] : Xj[k] - Xi[k];
    len += e.n[k] * e.n[k];
  }
  for (double &n : e.n) n /= std::sqrt(len);
  const double frame[3] = {e.x[0], e.x[1], e.x[2]};
  domain->unmap(frame, atom->image[i], e.x);    // reference positions are never wrapped
  e.value = what.value;
  sys->events.record(e);
}

/* ----------------------------------------------------------------------
   spheres that no joint holds
------------------------------------------------------------------------- */

void PairDefeJoint::contact_forces(const defe::VirialTally &tally)
{
  if (contacts->outdated()) {
    if (sys->census.des() > 0) {
      sys->joints.material.resize(sys->joints.nall);    // those of ghosts come from their owners
      forward(PARTS, 1);
    }
    contacts->search();
  }
  contacts->forces(tally);
}

/* ---------------------------------------------------------------------- */

void PairDefeJoint::forward(decltype(message) what, int size)
{
  message = what;
  comm->forward_comm(this, size);
}

int PairDefeJoint::pack_forward_comm(int n, int *list, double *buf, int, int *)
{
  if (n == 0) return 0;    // tiled ranks send empty messages, too
  if (message == CRACK_STRESS) return states->cracks()->pack_stress(n, list, buf);
  const auto &jt = sys->joints;
  int m = 0;
  for (int k = 0; k < n; k++) {
    const int d = jt.of_atom[list[k]];
    if (d < 0) continue;
    if (message == FORCES)
      m += states->pack_forces(d, &buf[m]);
    else if (message == PARTS)
      buf[m++] = jt.material[d];
    else if (message == CRACK_TABLE)
      m += states->cracks()->pack_table(d, &buf[m]);
    else
      m += states->pack_states(d, &buf[m]);
  }
  return m;
}

void PairDefeJoint::unpack_forward_comm(int n, int first, double *buf)
{
  if (n == 0) return;
  if (message == CRACK_STRESS) {
    states->cracks()->unpack_stress(first, buf);
    return;
  }
  auto &jt = sys->joints;
  int m = 0;
  for (int i = first; i < first + n; i++) {
    const int d = jt.of_atom[i];
    if (d < 0) continue;
    if (message == FORCES)
      m += states->unpack_forces(d, &buf[m]);
    else if (message == PARTS)
      jt.material[d] = static_cast<unsigned char>(buf[m++]);
    else if (message == CRACK_TABLE)
      m += states->cracks()->unpack_table(d, &buf[m]);
    else
      m += states->unpack_states(d, &buf[m]);
  }
}

/* ---------------------------------------------------------------------- */

void PairDefeJoint::write_restart(FILE *fp)
{
  write_restart_settings(fp);
  const int n = laws.types;
  fwrite(&n, sizeof(int), 1, fp);
  fwrite(laws.coeffs.data(), sizeof(defe::JointCoeff), laws.coeffs.size(), fp);
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
    utils::sfread(FLERR, laws.coeffs.data(), sizeof(defe::JointCoeff), laws.coeffs.size(), fp,
                  nullptr, error);
  MPI_Bcast(laws.coeffs.data(), static_cast<int>(laws.coeffs.size() * sizeof(defe::JointCoeff)),
            MPI_BYTE, 0, world);
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
  return (contacts ? contacts->memory_usage() : 0.0) + (states ? states->memory_usage() : 0.0) +
      Pair::memory_usage();
}
