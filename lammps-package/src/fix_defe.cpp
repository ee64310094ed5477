/* ----------------------------------------------------------------------
   DEFE: adaptive finite elements to bonded discrete elements for LAMMPS
   https://www.lammps.org/
   This software is distributed under the GNU General Public License.
------------------------------------------------------------------------- */

#include "fix_defe.h"

#include "defe_citation.h"
#include "defe_options.h"
#include "defe_surface_search.h"
#include "defe_system.h"

#include "atom.h"
#include "citeme.h"
#include "compute.h"
#include "domain.h"
#include "error.h"
#include "force.h"
#include "modify.h"
#include "output.h"
#include "update.h"

#include <cstring>

using namespace LAMMPS_NS;
using namespace FixConst;

static constexpr int WATCH_EVERY = 16;       // steps between looks at the speed of all atoms
static constexpr int FLUSH_EVERY = 1000;     // steps between writes of the event file
static constexpr int ENERGY_EVERY = 1000;    // and between looks at the balance of energies

/* ---------------------------------------------------------------------- */

FixDefe::FixDefe(LAMMPS *lmp, int narg, char **arg) :
    Fix(lmp, narg, arg), system(std::make_unique<DefeSystem>(lmp, this)), sys(*system)
{
  check_commands(narg);
  if (lmp->citeme) lmp->citeme->add(cite_defe);
  set_flags();
  DefeOptions(sys, narg, arg).read();

  // elements find their nodes by ID

  if (atom->map_style == Atom::MAP_NONE) {
    atom->map_user = Atom::MAP_YES;
    atom->map_init();
    atom->map_set();
  }
  sys.clock.begin();
  sys.store.grow(atom->nmax);
  atom->add_callback(Atom::GROW);
  atom->add_callback(Atom::RESTART);
  for (int i = 0; i < atom->nlocal; i++) sys.store.clear(i);
}

FixDefe::~FixDefe()
{
  if (modify->get_fix_by_id(id)) {
    atom->delete_callback(id, Atom::GROW);
    atom->delete_callback(id, Atom::RESTART);
  }
}

void FixDefe::check_commands(int narg)
{
  if (!atom->radius_flag || !atom->rmass_flag || !atom->omega_flag)
    error->all(FLERR, "Fix defe keeps nodes and DEs as spheres: use atom_style sphere");
  if (domain->triclinic)
    error->all(
        FLERR,
        "Fix defe does not support triclinic boxes: make an orthogonal one with region block");
  if (domain->dimension != 3) error->all(FLERR, "Fix defe needs a three-dimensional box");
  if (force->ftm2v != 1.0 || force->mvv2e != 1.0)
    error->all(FLERR,
               "Fix defe needs consistent units, in which force = mass x acceleration: si, cgs, "
               "micro, nano or lj, not {}",
               update->unit_style);
  if (narg < 4) utils::missing_cmd_args(FLERR, "fix defe", error);
}

void FixDefe::set_flags()
{
  restart_peratom = 1;
  restart_global = 1;
  restart_file = 1;    // none of its own: it looks at what was written, and seals it
  create_attribute = 1;
  force_reneighbor = 1;
  next_reneighbor = -1;
  pre_exchange_migrate = 1;    // it creates and deletes atoms there
  stores_ids = 1;
  maxexchange_dynamic = 1;
  comm_forward = MAX(DefeSurfaceSearch::MESSAGE_SIZE, DefeConversion::MARKED_SIZE);
  comm_reverse = 3;
  wd_header = 1;
  wd_section = 1;
  thermo_energy = 1;
  energy_global_flag = 1;
  thermo_virial = 1;
  virial_global_flag = 1;
  dynamic_group_allow = 1;
  no_change_box = 1;    // no triclinic boxes
  nevery = 1;

  scalar_flag = 1;
  extscalar = 1;
  vector_flag = 1;
  size_vector = defe::entries::COUNT;
  extvector = 0;
  global_freq = 1;
}

/* ---------------------------------------------------------------------- */

int FixDefe::setmask()
{
  sys.restart.check();    // the last that LAMMPS asks of a new fix
  return INITIAL_INTEGRATE | POST_INTEGRATE | PRE_EXCHANGE | PRE_NEIGHBOR | PRE_REVERSE |
      POST_FORCE | END_OF_STEP | POST_RUN | MIN_PRE_EXCHANGE | MIN_PRE_NEIGHBOR | MIN_PRE_REVERSE;
}

void FixDefe::init()
{
  sys.checks.before_mesh();
  if (sys.mesh.build()) init_computes_of_mass();
  sys.audit.account_for_deleted();
  sys.checks.after_mesh();
  sys.work.find_forced_groups();
  sys.clock.follow(update->ntimestep);
  sys.kept.initialized();
  sys.ghosts.find_largest_ball();
  if (sys.model.reproducible) sys.sums.make_grids();
  sys.ids.forget_newcomers();
  sys.ghosts.set_cutoff();
  if (update->whichflag == 1) sys.checks.time_step(false);
  sys.energy_watch.prepare();
  sys.notes.say_all();
  sys.account.forget();
}

/* ----------------------------------------------------------------------
   they take the mass of their group in init(), which comes before ours: without a pair style of DEFE the nodes had
   none of their own then
------------------------------------------------------------------------- */

void FixDefe::init_computes_of_mass()
{
  for (auto *compute : modify->get_compute_list())
    for (const char *style : {"com", "gyration", "msd"})
      if (strcmp(compute->style, style) == 0) compute->init();
}

void FixDefe::setup_pre_exchange()
{
  sys.watch.walls();
  sys.elements.look_at_histories();
  sys.store.update_maxexchange();
  sys.ghosts.set_cutoff_of_types();
  if (!update->setupflag) return;    // write_data comes here too
  sys.ghosts.find_all_nodes();
  sys.events.name_run();
  if (update->whichflag == 1) sys.conversion.convert_start();
}

void FixDefe::setup(int vflag)
{
  sys.in_place.look_at_commands();
  sys.work.after_setup();
  sys.kept.set_up();
  if (sys.model.contact()) sys.surface.report();
  sys.kept.take();
  sys.events.flush();    // a file that cannot be written ends the run here, not after hours
  post_force(vflag);
  sys.marks.begin_run();
}

/* ----------------------------------------------------------------------
   a step: first half kick
------------------------------------------------------------------------- */

void FixDefe::initial_integrate(int /*vflag*/)
{
  if (!sys.kept.running()) sys.kept.begin_run();
  if (sys.work.begin_step()) sys.energy_watch.begin();
  sys.work.first_half();
  sys.clock.subcycle().advance(update->dt);
}

/* ----------------------------------------------------------------------
   the last moment before LAMMPS decides whether to reneighbour: not for what converts, if it needs none
------------------------------------------------------------------------- */

void FixDefe::post_integrate()
{
  sys.marks.answer();
  if (sys.marks.due()) sys.conversion.convert_in_place();
}

/* ----------------------------------------------------------------------
   only if it does: conversion, ghosts, tables
------------------------------------------------------------------------- */

void FixDefe::pre_exchange()
{
  sys.watch.walls();
  sys.store.update_maxexchange();
  const double longest = sys.elements.longest();
  if (sys.marks.due()) sys.conversion.convert();
  sys.ghosts.provide(longest);
}

void FixDefe::min_pre_exchange()
{
  sys.watch.walls();
  sys.ghosts.provide(sys.elements.longest());
}

void FixDefe::pre_neighbor()
{
  sys.tables.build();
}

/* ----------------------------------------------------------------------
   internal forces of the elements and contact of surfaces
   here, not in pre_force: the pair style's own virial must not count them
------------------------------------------------------------------------- */

void FixDefe::pre_reverse(int /*eflag*/, int vflag)
{
  v_init(vflag);
  sys.mesh.check_closed();    // fixes that strain the box do not reneighbour
  sys.account.forget();       // minimisers evaluate forces many times in a step
  double virial_fe[6] = {0.0, 0.0, 0.0, 0.0, 0.0, 0.0};
  double *const asked = vflag_global ? virial_fe : nullptr;
  sys.elements.forces(asked);
  if (sys.model.contact()) sys.surface.forces(asked);
  if (sys.model.reproducible) sys.sums.check_range(false);
  for (int k = 0; k < 6 && asked; k++) virial[k] += virial_fe[k];
}

/* ----------------------------------------------------------------------
   all ghost forces have arrived: what is added after us is external
------------------------------------------------------------------------- */

void FixDefe::post_force(int /*vflag*/)
{
  if (sys.model.reproducible) sys.sums.check_range(true);
  sys.work.keep_internal();
}

/* ----------------------------------------------------------------------
   after the second half kick
------------------------------------------------------------------------- */

void FixDefe::end_of_step()
{
  if (sys.work
          .after_setup_only()) {    // no first half kick: rerun sets positions and asks for forces
    check_rerun();
    sys.account.forget();
    sys.clock.begin();
    return;
  }
  const bool last = update->ntimestep == update->laststep;
  sys.work.second_half();
  if (update->ntimestep % WATCH_EVERY == 0 || update->ntimestep == output->next_restart || last)
    sys.watch.speed();
  if (sys.clock.subcycle().due()) {
    sys.strengths.grow_elements();
    sys.marks.mark();
  }
  sys.clock.step_done();
  sys.account.forget();
  if (update->ntimestep % ENERGY_EVERY == 0 || last) sys.energy_watch.look();
  if (update->ntimestep % FLUSH_EVERY == 0) sys.events.flush();
}

void FixDefe::check_rerun()
{
  int mine = 0, any = 0;
  for (const auto &b : sys.elements.batches()) mine = mine || b.has_histories();
  MPI_Allreduce(&mine, &any, 1, MPI_INT, MPI_MAX, world);
  if (any)
    error->all(FLERR,
               "Fix defe: rerun cannot follow materials with a memory (prony, plastic, "
               "johnson-cook): what is in a dump does not tell their stress");
  if (sys.strengths.growing())
    error->all(FLERR,
               "Fix defe: rerun cannot follow flaws that grow (strength ... rate): how far they "
               "have grown is not in a dump");
  if (sys.marks.any() || sys.census.des() > 0)
    error->all(FLERR,
               "Fix defe: rerun cannot follow a body in which elements convert (step {}); it "
               "works for finite elements only",
               update->ntimestep);
}

void FixDefe::reset_dt()
{
  if (update->whichflag == 1) sys.checks.time_step(true);
}

void FixDefe::post_run()
{
  sys.marks.end_run();
  if (sys.kept.running()) sys.watch.speed();    // a run that halts early
  if (update->whichflag == 1) sys.kept.keep();
  sys.kept.end_run();
  sys.events.flush();
  if (sys.model.contact()) sys.surface.report();
  sys.account.end_run();
}

/* ----------------------------------------------------------------------
   data of atoms
------------------------------------------------------------------------- */

void FixDefe::grow_arrays(int nmax)
{
  sys.store.grow(nmax);
}

void FixDefe::copy_arrays(int i, int j, int /*delflag*/)
{
  if (i != j) sys.store.move(i, j);
}

void FixDefe::set_arrays(int i)
{
  sys.store.clear(i);
}

int FixDefe::pack_exchange(int i, double *buf)
{
  return sys.store.pack(i, buf);
}

int FixDefe::unpack_exchange(int i, double *buf)
{
  return sys.store.unpack(i, buf);
}

int FixDefe::pack_restart(int i, double *buf)
{
  return sys.restart.pack(i, buf);
}

void FixDefe::unpack_restart(int i, int nth)
{
  if (!sys.restart.unpack(i, nth)) sys.store.clear(i);
}

int FixDefe::size_restart(int i)
{
  return sys.restart.size(i);
}

int FixDefe::maxsize_restart()
{
  return sys.restart.largest();
}

void FixDefe::write_restart(FILE *fp)
{
  sys.restart.write(fp);
}

void FixDefe::write_restart_file(const char *name)
{
  sys.restart.written(name);
}

void FixDefe::restart(char *buf)
{
  sys.restart.read(buf);
}

/* ----------------------------------------------------------------------
   messages to ghosts and back
------------------------------------------------------------------------- */

int FixDefe::pack_forward_comm(int n, int *list, double *buf, int pbc_flag, int *pbc)
{
  return sys.ghosts.pack_forward(n, list, buf, pbc_flag, pbc);
}

void FixDefe::unpack_forward_comm(int n, int first, double *buf)
{
  sys.ghosts.unpack_forward(n, first, buf);
}

int FixDefe::pack_reverse_comm(int n, int first, double *buf)
{
  return sys.ghosts.pack_reverse(n, first, buf);
}

void FixDefe::unpack_reverse_comm(int n, int *list, double *buf)
{
  sys.ghosts.unpack_reverse(n, list, buf);
}

/* ----------------------------------------------------------------------
   data files
------------------------------------------------------------------------- */

void FixDefe::read_data_header(char *line)
{
  sys.hexes_file.read_header(line);
}

bigint FixDefe::read_data_skip_lines(char * /*keyword*/)
{
  return sys.hexes_file.skip_lines();
}

void FixDefe::read_data_section(char * /*keyword*/, int n, char *buf, tagint id_offset)
{
  sys.hexes_file.read_section(n, buf, id_offset);
}

void FixDefe::write_data_header(FILE *fp, int /*mth*/)
{
  sys.hexes_file.write_header(fp);
}

void FixDefe::write_data_section_size(int /*mth*/, int &nx, int &ny)
{
  sys.hexes_file.section_size(nx, ny);
}

void FixDefe::write_data_section_pack(int /*mth*/, double **buf)
{
  sys.hexes_file.pack_section(buf);
}

void FixDefe::write_data_section_keyword(int /*mth*/, FILE *fp)
{
  utils::print(fp, "\nHexes\n\n");
}

void FixDefe::write_data_section(int /*mth*/, FILE *fp, int n, double **buf, int /*index*/)
{
  sys.hexes_file.write_section(fp, n, buf);
}

/* ----------------------------------------------------------------------
   output
------------------------------------------------------------------------- */

double FixDefe::compute_scalar()
{
  return sys.account.scalar();
}

double FixDefe::compute_vector(int n)
{
  return sys.account.values()[n];
}

int FixDefe::image(int *&objs, double **&parms)
{
  return sys.picture.draw(objs, parms);
}

void *FixDefe::extract(const char *name, int &dim)
{
  dim = 0;
  if (strcmp(name, "defe") == 0) return &sys;
  return sys.mesh.extract(name);
}

double FixDefe::memory_usage()
{
  return sys.store.memory_usage() + sys.elements.memory_usage() + sys.kept.memory_usage() +
      sys.strengths.memory_usage() + sys.prestress.memory_usage() + sys.tied.memory_usage() +
      sys.tied_des.memory_usage() + sys.joints.self.capacity() * 330.0 +
      sys.joints.corners.capacity() * sizeof(defe::CornerTable);
}
