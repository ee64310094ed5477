/* ----------------------------------------------------------------------
   DEFE: adaptive finite elements to bonded discrete elements for LAMMPS
   https://www.lammps.org/
   This software is distributed under the GNU General Public License.
------------------------------------------------------------------------- */

#include "fix_defe.h"

#include "style_names.h"

#include "atom.h"
#include "atom_vec.h"
#include "comm.h"
#include "domain.h"
#include "error.h"
#include "force.h"
#include "group.h"
#include "memory.h"
#include "modify.h"
#include "neighbor.h"
#include "output.h"
#include "pair.h"
#include "region.h"
#include "update.h"

#include "defe/coupling/ghost_reach.h"
#include "defe/fe/hex8.h"
#include "defe/fe/principal.h"

#include <algorithm>
#include <cmath>
#include <cstring>

using namespace LAMMPS_NS;
using namespace FixConst;
using defe::Mat3;
using defe::Vec3;
using defe::fe::HexCoords;

static constexpr size_t MAX_PARTS = 127;     // a signed char in the records
static constexpr int WATCH_EVERY = 16;       // steps between looks at the speed of all atoms
static constexpr int FLUSH_EVERY = 1000;     // steps between writes of the event file
static constexpr int ENERGY_EVERY = 1000;    // and between looks at the balance of energies

static constexpr int doubles(size_t bytes)
{
  return static_cast<int>((bytes + sizeof(double) - 1) / sizeof(double));
}

static constexpr int HEX_SIZE = doubles(sizeof(HexPod));
static constexpr int DE_SIZE = doubles(sizeof(DERecord));
static constexpr int TOUCH_SIZE = doubles(sizeof(DefeTouch));
static constexpr int SPHERE_SIZE = doubles(sizeof(SphereTouch));
static constexpr int CRACK_SIZE = doubles(sizeof(JointCrack));
static constexpr int KEPT_SIZE = doubles(sizeof(FixDefe::KeptForces));
static constexpr int MAX_SHIELDS = 27;    // of an element: its neighbours, one more for a while
static constexpr int RECORD_SIZE = 1 + 3 + 1 + 1 + 1 + 1 + 1 + 1 + 1 + 1;    // of any atom

/* ---------------------------------------------------------------------- */

FixDefe::FixDefe(LAMMPS *lmp, int narg, char **arg) : Fix(lmp, narg, arg)
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

  restart_peratom = 1;
  restart_global = 1;
  restart_file = 1;    // none of its own: it looks at what was written, and seals it
  create_attribute = 1;
  force_reneighbor = 1;
  next_reneighbor = -1;
  pre_exchange_migrate = 1;    // it creates and deletes atoms there
  stores_ids = 1;
  maxexchange_dynamic = 1;
  comm_forward = MAX(SURFACE_SIZE, MARKED_SIZE);
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

  if (narg < 4) utils::missing_cmd_args(FLERR, "fix defe", error);

  auto material_index = [this](const std::string &name) {
    for (size_t i = 0; i < materials.size(); i++)
      if (materials[i].name == name) return static_cast<int>(i);
    return -1;
  };
  auto add_part = [this](const std::string &name, int material) {
    Part p;
    p.name = name;
    p.material = material;
    if (parts.size() == MAX_PARTS)
      error->all(FLERR, "Fix defe can hold no more than {} parts", MAX_PARTS);
    parts.push_back(p);
  };

  int iarg = 3;
  auto need = [&](int n, const char *what) {
    if (iarg + n > narg) utils::missing_cmd_args(FLERR, std::string("fix defe ") + what, error);
  };

  while (iarg < narg) {
    const std::string key = arg[iarg];
    if (key == "material") {
      need(3, "material");
      Material m;
      m.name = arg[iarg + 1];
      check_name("material", m.name);
      if (material_index(m.name) >= 0)
        error->all(FLERR, "Fix defe material {} is defined twice", m.name);
      const auto parsed =
          defe::fe::parse_material(std::vector<std::string>(arg + iarg + 2, arg + narg));
      if (!parsed.complaint.empty())
        error->all(FLERR, "Fix defe material {}: {}", m.name, parsed.complaint);
      m.law = parsed.law;
      for (int k = 0; k < parsed.used; k++)
        m.words += std::string(k ? " " : "") + arg[iarg + 2 + k];
      iarg += 2 + parsed.used;
      materials.push_back(m);
      add_part(m.name, static_cast<int>(materials.size()) - 1);

    } else if (key == "part") {
      need(3, "part");
      const int m = material_index(arg[iarg + 2]);
      if (m < 0)
        error->all(FLERR, "Fix defe part {}: unknown material {}", arg[iarg + 1], arg[iarg + 2]);
      if (find_part(arg[iarg + 1]) >= 0)
        error->all(FLERR, "Fix defe part {} is defined twice", arg[iarg + 1]);
      check_name("part", arg[iarg + 1]);
      add_part(arg[iarg + 1], m);
      iarg += 3;

    } else if (key == "convert") {
      need(3, "convert");
      const int ip = find_part(arg[iarg + 1]);
      if (ip < 0) error->all(FLERR, "Fix defe convert: unknown part {}", arg[iarg + 1]);
      Part &p = parts[ip];
      if (material_of(p).rigid())
        error->all(FLERR, "Fix defe convert: part {} is rigid and cannot convert", p.name);
      if (!material_of(p).law->linear())
        error->all(
            FLERR,
            "Fix defe convert: part {} cannot convert: DEs have the law elastic, its material "
            "{} has another one",
            p.name, material_of(p).name);
      p.convertible = true;
      p.group = group->find("all");
      iarg += 2 + set_criterion(p, std::vector<std::string>(arg + iarg + 2, arg + narg));
      while (iarg < narg) {
        const std::string opt = arg[iarg];
        if (opt == "type") {
          need(2, "convert ... type");
          p.type = utils::inumeric(FLERR, arg[iarg + 1], false, lmp);
          if (p.type < 1 || p.type > atom->ntypes)
            error->all(FLERR, "Fix defe convert {}: atom type {} does not exist (1 to {})", p.name,
                       p.type, atom->ntypes);
        } else if (opt == "group") {
          need(2, "convert ... group");
          p.group = group->find(arg[iarg + 1]);
          if (p.group < 0)
            error->all(FLERR,
                       "Fix defe convert {}: group {} does not exist; define it first, for "
                       "instance 'group {} empty'",
                       p.name, arg[iarg + 1], arg[iarg + 1]);
        } else if (opt == "start") {
          need(2, "convert ... start");
          p.start = arg[iarg + 1];
          if (p.start == "no") p.start.clear();
          if (!p.start.empty() && p.start != "all" && !domain->get_region_by_id(p.start))
            error->all(FLERR, "Fix defe convert {}: start must be no, all or a region, not {}",
                       p.name, p.start);
        } else
          break;
        iarg += 2;
      }
      if (p.type == 0)
        error->all(FLERR, "Fix defe convert {}: give the atom type of its DEs: type N", p.name);

    } else if (key == "adhesive") {
      need(6, "adhesive");
      Adhesive a;
      int *const which[2] = {&a.part, &a.base};
      for (int k = 0; k < 2; k++) {
        *which[k] = find_part(arg[iarg + 1 + k]);
        if (*which[k] < 0)
          error->all(FLERR, "Fix defe adhesive: unknown part {}: define it before",
                     arg[iarg + 1 + k]);
      }
      a.law.sigma_t = utils::numeric(FLERR, arg[iarg + 3], false, lmp);
      a.law.G_f = utils::numeric(FLERR, arg[iarg + 4], false, lmp);
      a.law.beta = utils::numeric(FLERR, arg[iarg + 5], false, lmp);
      a.law.reciprocal = false;
      if (!(a.law.sigma_t > 0.0) || !(a.law.G_f > 0.0) || !(a.law.beta >= 0.0))
        error->all(FLERR,
                   "Fix defe adhesive {} {}: strength and fracture energy must be > 0 and beta >= "
                   "0, not {} {} {}",
                   arg[iarg + 1], arg[iarg + 2], a.law.sigma_t, a.law.G_f, a.law.beta);
      if (adhesive_of(a.part, a.base))
        error->all(FLERR, "Fix defe adhesive {} {} is given twice", arg[iarg + 1], arg[iarg + 2]);
      adhesives.push_back(a);
      iarg += 6;

    } else if (key == "contact") {
      need(2, "contact");
      contact_given = true;
      contact_factor = utils::numeric(FLERR, arg[iarg + 1], false, lmp);
      if (!(contact_factor >= 0.0))
        error->all(FLERR, "Fix defe contact factor must be >= 0, not {}", arg[iarg + 1]);
      iarg += 2;
      if (iarg < narg && strcmp(arg[iarg], "friction") == 0) {
        need(2, "contact f_s friction");
        contact_friction = utils::numeric(FLERR, arg[iarg + 1], false, lmp);
        if (!(contact_friction >= 0.0))
          error->all(FLERR, "Fix defe friction must be >= 0, not {}", arg[iarg + 1]);
        iarg += 2;
      }
      if (iarg < narg && strcmp(arg[iarg], "overlap") == 0) {
        need(2, "contact f_s overlap");
        refuse_overlaps = strcmp(arg[iarg + 1], "refuse") == 0;
        ease_overlaps = strcmp(arg[iarg + 1], "ease") == 0;
        if (!refuse_overlaps && !ease_overlaps)
          error->all(FLERR, "Fix defe contact overlap is ease or refuse, not {}", arg[iarg + 1]);
        iarg += 2;
      }

    } else if (key == "shield") {
      need(2, "shield");
      shield = utils::logical(FLERR, arg[iarg + 1], false, lmp);
      iarg += 2;

    } else if (key == "stress") {
      need(2, "stress");
      if (strcmp(arg[iarg + 1], "centre") == 0)
        gauss_stress = false;
      else if (strcmp(arg[iarg + 1], "gauss") == 0)
        gauss_stress = true;
      else
        error->all(FLERR, "Fix defe stress must be centre or gauss, not {}", arg[iarg + 1]);
      iarg += 2;

    } else if (key == "kernel") {
      need(2, "kernel");
      if (strcmp(arg[iarg + 1], "auto") == 0)
        force_lagrangian = false;
      else if (strcmp(arg[iarg + 1], "lagrangian") == 0)
        force_lagrangian = true;
      else
        error->all(FLERR, "Fix defe kernel must be auto or lagrangian, not {}", arg[iarg + 1]);
      iarg += 2;

    } else if (key == "every") {
      need(2, "every");
      const int every = utils::inumeric(FLERR, arg[iarg + 1], false, lmp);
      if (every < 1) error->all(FLERR, "Fix defe every must be at least 1 step, not {}", every);
      subcycle.set_every(every);
      iarg += 2;

    } else if (key == "check") {
      need(2, "check");
      if (strcmp(arg[iarg + 1], "energy") == 0) {
        need(3, "check energy");
        const std::string how = arg[iarg + 2];
        if (how != "no" && how != "warn" && how != "stop")
          error->all(FLERR, "Fix defe check energy is no, warn or stop, not {}", how);
        energy_check = how == "no" ? ENERGY_NO : how == "warn" ? ENERGY_WARN : ENERGY_STOP;
        iarg += 3;
      } else {
        checking = utils::logical(FLERR, arg[iarg + 1], false, lmp);
        iarg += 2;
      }

    } else if (key == "reproducible") {
      need(2, "reproducible");
      reproducible = utils::logical(FLERR, arg[iarg + 1], false, lmp);
      iarg += 2;

    } else if (key == "events") {
      need(2, "events");
      event_log.set_file(arg[iarg + 1]);
      iarg += 2;

    } else
      error->all(FLERR,
                 "Unknown fix defe keyword {}: use material, part, convert, adhesive, contact, "
                 "shield, stress, kernel, every, check, reproducible or events",
                 key);
  }

  if (materials.empty()) error->all(FLERR, "Fix defe needs at least one material");
  check_numbers_as_names();
  for (const auto &a : adhesives) {
    if (!parts[a.part].convertible)
      error->all(FLERR,
                 "Fix defe adhesive {0} {1}: elements of part {0} do not convert, so it has no "
                 "ties: name the part that converts first",
                 parts[a.part].name, parts[a.base].name);
    if (parts[a.base].convertible)
      error->all(FLERR,
                 "Fix defe adhesive {0} {1}: part {1} converts: the joints between two parts that "
                 "convert have their strength by pair_coeff cohesive",
                 parts[a.part].name, parts[a.base].name);
  }
  for (const auto &p : parts) {
    const auto &e = material_of(p).elastic();
    corner_moduli.push_back(material_of(p).rigid() ? defe::CornerModuli{0.0, 0.0}
                                                   : defe::CornerModuli{e.lambda(), e.mu()});
  }
  de_radius_max.assign(atom->ntypes + 1, 0.0);

  // elements find their nodes by ID

  if (atom->map_style == Atom::MAP_NONE) {
    atom->map_user = Atom::MAP_YES;
    atom->map_init();
    atom->map_set();
  }

  clock = now();

  FixDefe::grow_arrays(atom->nmax);
  atom->add_callback(Atom::GROW);
  atom->add_callback(Atom::RESTART);
  for (int i = 0; i < atom->nlocal; i++) FixDefe::set_arrays(i);
}

/* ---------------------------------------------------------------------- */

FixDefe::~FixDefe()
{
  take_marks();
  if (modify->get_fix_by_id(id)) {
    atom->delete_callback(id, Atom::GROW);
    atom->delete_callback(id, Atom::RESTART);
  }
  memory->destroy(xref);
  memory->destroy(xframe);
  memory->destroy(nelem);
}

/* ---------------------------------------------------------------------- */

int FixDefe::setmask()
{
  check_restart();    // the last that LAMMPS asks of a new fix
  return INITIAL_INTEGRATE | POST_INTEGRATE | PRE_EXCHANGE | PRE_NEIGHBOR | PRE_REVERSE |
      POST_FORCE | END_OF_STEP | POST_RUN | MIN_PRE_EXCHANGE | MIN_PRE_NEIGHBOR | MIN_PRE_REVERSE;
}

/* ---------------------------------------------------------------------- */

int FixDefe::find_part(const std::string &name) const
{
  for (size_t i = 0; i < parts.size(); i++)
    if (parts[i].name == name) return static_cast<int>(i);
  return -1;
}

/* ---------------------------------------------------------------------- */

void FixDefe::init()
{
  if (!force->newton)
    error->all(FLERR,
               "Fix defe adds forces to ghost nodes: use 'newton off on' (or 'newton on'), not "
               "'newton off'");
  if (neighbor->includegroup)
    error->all(FLERR, "Fix defe cannot be used with neigh_modify include: remove it");
  check_communication();
  if (modify->get_fix_by_style("^defe$").size() > 1)
    error->all(FLERR, "Only one fix defe at a time: one fix holds any number of parts");

  bool any_convertible = false;
  for (const auto &p : parts) any_convertible = any_convertible || p.convertible;
  if (utils::strmatch(update->integrate_style, "^respa"))
    error->all(FLERR, "Fix defe does not support run_style respa: use verlet");

  for (const auto &ifix : modify->get_fix_list()) {
    if (ifix == this) break;
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

  check_bond_fixes(any_convertible);

  if (any_convertible && (!force->pair || !force->pair_match("^defe/", 0)))
    error->all(FLERR,
               "Fix defe converts elements into DEs that no pair style joins: use pair_style "
               "defe/joint");

  if (contact_factor > 0.0 && comm->ghost_velocity == 0)
    error->all(FLERR, "Fix defe contact needs velocities of ghosts: add comm_modify vel yes");

  build_topology();
  account_for_deleted();
  check_integrators();
  check_movers();
  check_adhesives();
  check_walls();
  check_minimizer();
  forced_bits = groups_forced();

  if (update->whichflag == 2 && des_total > 0)
    error->all(
        FLERR,
        "Fix defe cannot minimize with DEs: joints damage along a path in time; minimize before "
        "elements convert, or damp the motion with fix viscous");

  // nodes are points

  tagint mine = MAXTAGINT, all;
  for (int i = 0; i < atom->nlocal; i++)
    if (!de[i] && nelem[i] > 0 && atom->radius[i] != 0.0) mine = MIN(mine, atom->tag[i]);
  MPI_Allreduce(&mine, &all, 1, MPI_LMP_TAGINT, MPI_MIN, world);
  if (all < MAXTAGINT)
    error->all(FLERR, "Node {} of the mesh was given a radius: nodes are spheres of radius 0", all);

  follow_clock(update->ntimestep);
  needs_setup = true;

  // elements, joints and facets need their nodes as ghosts, and facets the balls that can reach them

  double ball = 0.0;
  for (int i = 0; i < atom->nlocal && contact_factor > 0.0; i++)
    if (!de[i]) ball = MAX(ball, atom->radius[i]);
  MPI_Allreduce(&ball, &largest_ball, 1, MPI_DOUBLE, MPI_MAX, world);
  for (int type = 1; type <= atom->ntypes && contact_factor > 0.0; type++)
    largest_ball = MAX(largest_ball, radius_to_come(type));
  if (reproducible) make_grids();
  natoms_known = atom->natoms;
  doubtful_newcomers.clear();
  longest_provided = MAX(longest_provided, defe::ghosts::growth * max_diagonal);
  const double cut = ghost_reach();
  if (comm->cutghostuser < cut) {
    if (comm->me == 0 && comm->cutghostuser > 0.0)
      error->warning(FLERR, "Communication cutoff raised from {} to {} for fix defe",
                     comm->cutghostuser, cut);
    comm->cutghostuser = cut;
  }

  if (update->whichflag == 1) check_time_step(false);
  prepare_energy_watch();
  say_notes();
  vector_step = -1;
}

/* ----------------------------------------------------------------------
   largest radius of a DE of this type that can ever be born
------------------------------------------------------------------------- */

double FixDefe::max_de_radius(int type) const
{
  return (type >= 0 && type < static_cast<int>(de_radius_max.size())) ? de_radius_max[type] : 0.0;
}

/* ----------------------------------------------------------------------
   first setup of a run: conversion of what is to be discrete from the start
------------------------------------------------------------------------- */

void FixDefe::setup_pre_exchange()
{
  watch_walls();
  history_most = 0;
  for (int i = 0; i < atom->nlocal; i++)
    for (const auto &h : hexes[i])
      if (h.extra) history_most = MAX(history_most, static_cast<int>(h.extra->history.size()));
  update_maxexchange();

  // write_data comes here too

  if (!update->setupflag) return;
  find_all_nodes();
  name_run();
  if (update->whichflag != 1 || start_done) return;
  start_done = true;

  bool any = false;
  for (const auto &p : parts) {
    if (p.start.empty()) continue;
    any = true;
    if (p.start == "all") continue;
    auto region = domain->get_region_by_id(p.start);
    if (!region)
      error->all(FLERR, "Fix defe convert {}: start region {} does not exist any more", p.name,
                 p.start);
    region->prematch();
  }
  if (!any) return;

  make_ghosts_for_setup();
  pre_neighbor();

  for (auto &b : batches) {
    if (!b.convertible) continue;
    for (size_t e = 0; e < b.hex.size(); e++) {
      const Part &p = parts[b.hex[e]->part];
      if (p.start.empty()) continue;
      bool in = (p.start == "all");
      if (!in) {
        auto region = domain->get_region_by_id(p.start);
        double c[3] = {0.0, 0.0, 0.0};
        for (int a = 0; a < 8; a++)
          for (int k = 0; k < 3; k++) c[k] += 0.125 * atom->x[b.node[e][a]][k];
        domain->remap(c);
        in = region->match(c[0], c[1], c[2]) != 0;
      }
      b.hex[e]->marked = in;
    }
  }
  convert_marked();
  provide_ghosts(0.0);
}

/* ----------------------------------------------------------------------
   distance from its sub-domain to which a rank needs ghosts
------------------------------------------------------------------------- */

double FixDefe::ghost_reach() const
{
  defe::GhostNeeds needs;
  needs.longest = longest_provided;
  needs.diagonal = max_diagonal;
  needs.facet_diagonal = max_facet;
  needs.largest_ball = largest_ball;
  needs.skin = neighbor->skin;
  needs.des = des_total > 0;
  needs.cracks = cracks_ask;
  needs.contact = contact_factor > 0.0;
  return defe::ghost_reach(needs);
}

/* ----------------------------------------------------------------------
   largest distance between two nodes of an element of this rank; those that are certainly provided
   for may be left out
------------------------------------------------------------------------- */

double FixDefe::longest_element() const
{
  double longest = 0.0;
  if ((comm->nprocs == 1 && atom->nghost == 0) || atom->nlocal == 0) return longest;
  const double *x = &atom->x[0][0];
  const double enough = std::pow(longest_provided / defe::ghosts::step_behind, 2);
  for (const auto &b : batches)
    for (const auto &idx : b.node) {
      double box = 0.0;    // a bound: diagonal of the box around it
      for (int d = 0; d < 3; d++) {
        double lo = x[3 * idx[0] + d], hi = lo;
        for (int a = 1; a < 8; a++) {
          lo = MIN(lo, x[3 * idx[a] + d]);
          hi = MAX(hi, x[3 * idx[a] + d]);
        }
        box += (hi - lo) * (hi - lo);
      }
      if (box <= enough) continue;
      HexCoords now;
      for (int a = 0; a < 8; a++)
        for (int d = 0; d < 3; d++) now(d, a) = x[3 * idx[a] + d];
      longest = MAX(longest, defe::fe::max_diagonal(now));
    }
  return longest;
}

/* ----------------------------------------------------------------------
   more ghosts from the next exchange on, if elements have become longer or there are DEs now
------------------------------------------------------------------------- */

void FixDefe::provide_ghosts(double longest)
{
  double all = 0.0;
  MPI_Allreduce(&longest, &all, 1, MPI_DOUBLE, MPI_MAX, world);
  if (defe::ghosts::step_behind * all > longest_provided)
    longest_provided = defe::ghosts::growth * all;
  const double cut = ghost_reach();
  if (comm->cutghostuser >= cut) return;
  comm->cutghostuser = cut;
  comm->setup();
  if (neighbor->style) neighbor->setup_bins();
}

/* ----------------------------------------------------------------------
   before a run: elements may be much longer than they were in the reference configuration, or
   have been moved by commands. Images do not matter: elements are shorter than half of a periodic box.
------------------------------------------------------------------------- */

void FixDefe::find_all_nodes()
{
  if (comm->nprocs == 1 && !domain->xperiodic && !domain->yperiodic && !domain->zperiodic) return;
  for (int attempt = 0; attempt < 5; attempt++) {
    make_ghosts_for_setup();
    double longest = 0.0;
    int missing = 0, any = 0;
    for (int i = 0; i < atom->nlocal; i++)
      for (const auto &h : hexes[i]) {
        HexCoords now;
        bool complete = true;
        for (int a = 0; a < 8; a++) {
          const int j = local_of(h.node[a]);
          complete = complete && j >= 0;
          if (!complete) break;
          double del[3];
          for (int d = 0; d < 3; d++) del[d] = atom->x[j][d] - atom->x[i][d];
          domain->minimum_image(del);
          for (int d = 0; d < 3; d++) now(d, a) = del[d];
        }
        if (!complete)
          missing = 1;
        else
          longest = MAX(longest, defe::fe::max_diagonal(now));
      }
    MPI_Allreduce(&missing, &any, 1, MPI_INT, MPI_MAX, world);
    if (any) longest = MAX(longest, defe::ghosts::missing_node * longest_provided);
    provide_ghosts(longest);
    if (!any) return;
  }
}

/* ----------------------------------------------------------------------
   before the first setup there are no ghosts
------------------------------------------------------------------------- */

void FixDefe::make_ghosts_for_setup()
{
  domain->pbc();
  domain->reset_box();
  comm->setup();
  if (neighbor->style) neighbor->setup_bins();
  comm->exchange();
  comm->borders();
}

/* ---------------------------------------------------------------------- */

void FixDefe::pre_exchange()
{
  watch_walls();
  update_maxexchange();
  const double longest = longest_element();
  if (update->ntimestep == convert_step) {
    convert_step = -1;
    next_reneighbor = -1;
    convert_marked();
  }
  provide_ghosts(longest);
}

void FixDefe::min_pre_exchange()
{
  watch_walls();
  provide_ghosts(longest_element());
}

/* ----------------------------------------------------------------------
   local indices of everything; once per reneighbouring
------------------------------------------------------------------------- */

void FixDefe::pre_neighbor()
{
  const int nlocal = atom->nlocal;
  const int nall = nlocal + atom->nghost;
  between_runs = false;
  if (atom->natoms != natoms_known) check_newcomers();

  // reference positions in the periodic frame of x, for owned and ghost atoms

  const auto at_home = (static_cast<imageint>(IMGMAX) << IMG2BITS) |
      (static_cast<imageint>(IMGMAX) << IMGBITS) | IMGMAX;
  for (int i = 0; i < nlocal; i++) {
    for (int k = 0; k < 3; k++) xframe[i][k] = xref[i][k];
    if (atom->image[i] != at_home) domain->unmap_inv(xframe[i], atom->image[i]);
  }
  outer_reach.assign(nall, 0.0);
  outer_length.assign(nall, 0.0);
  for (int i = 0; i < nlocal; i++) {
    if (!de[i]) continue;
    outer_reach[i] = de[i]->outer_distance;
    outer_length[i] = 0.5 * de[i]->outer_area * de[i]->outer_area / de[i]->volume;
  }
  comm_mode = FRAME;
  comm->forward_comm(this, 5);

  // elements, in batches of one kernel

  for (auto &b : batches) b.clear();    // they keep their memory
  exposed.clear();
  tagint lost_hex = 0, lost_node = 0;
  for (int i = 0; i < nlocal; i++) {
    if (i + 6 < nlocal) prefetch(hexes[i + 6].data());
    for (auto &h : hexes[i]) {
      std::array<int, 8> idx;
      if (!local_hex(h, i, idx.data())) {
        lost_hex = h.id;
        for (int a = 0; a < 8; a++)
          if (local_of(h.node[a]) < 0) lost_node = h.node[a];
        continue;
      }
      if (h.kernel < 0) {
        HexCoords X;
        for (int a = 0; a < 8; a++)
          for (int k = 0; k < 3; k++) X(k, a) = xframe[idx[a]][k];
        h.kernel = kernel_of(h.part, X);
      }
      Batch &b = batches[h.kernel];
      if (contact_factor > 0.0 && std::any_of(std::begin(h.nb), std::end(h.nb), [](tagint nb) {
            return nb <= 0;
          }))
        exposed.emplace_back(h.kernel, static_cast<int>(b.hex.size()));
      b.node.push_back(idx);
      b.hex.push_back(&h);
      if (kernels[h.kernel].history > 0) {
        auto &history = h.with_extra().history;
        history.resize(kernels[h.kernel].history, 0.0);
        b.history.push_back(history.data());
      }
    }
  }
  if (lost_hex)
    error->one(
        FLERR,
        "Node {} of element {} is missing on proc {} at step {}: it was lost, or the element "
        "is larger than the communication cutoff (raise it with comm_modify cutoff){}",
        lost_node, lost_hex, comm->me, update->ntimestep, minimizer_hint());
  for (auto &b : batches) {
    if (b.node.capacity() > b.node.size() + b.node.size() / 4) {
      b.node.shrink_to_fit();
      b.hex.shrink_to_fit();
    }
    b.bound.assign(b.node.size(), 0.0);
  }

  // discrete elements and their joints

  jt.clear();
  jt.of_atom.assign(nall, -1);
  if (des_total > 0) {
    struct Draft {
      int atom;
      std::array<int, 6> nb;
      std::array<double, 6> len, half;
    };
    std::vector<Draft> ortho, general;
    for (int i = 0; i < nlocal; i++) {
      if (!de[i]) continue;
      if (i + 2 < nlocal) prefetch(de[i + 2].get());
      DERecord &r = *de[i];
      Draft draft;
      draft.atom = i;
      defe::GeneralCell cell;
      cell.tie = 0;
      for (int s = 0; s < 6; s++) {
        JointSlot &slot = r.slot[s];
        draft.nb[s] = i;
        cell.dX[s].setZero();
        cell.face[s] = Vec3(slot.face);
        draft.len[s] = draft.half[s] = cell.face[s].norm();
        if (slot.kind == DefeJoint::DE && (slot.state != DefeJoint::CONTACT || slot.plane)) {
          const int j = domain->closest_image(i, local_of(slot.other));
          if (j < 0 && slot.plane) {    // the other fragment was deleted
            slot.plane = 0;
            continue;
          }
          if (j < 0)
            error->one(FLERR,
                       "DE {} is joined to DE {}, which is missing on proc {} at step {}: it was "
                       "lost or deleted, or the communication cutoff is too small",
                       atom->tag[i], slot.other, comm->me, update->ntimestep);
          for (int k = 0; k < 3; k++) cell.dX[s][k] = xframe[j][k] - xframe[i][k];
          draft.nb[s] = j;
          draft.len[s] = cell.dX[s].norm();
        } else if (slot.kind == DefeJoint::TIE && slot.state != DefeJoint::CONTACT) {
          cell.tie |= 1 << s;
          cell.dX[s] = cell.face[s];
        }
      }
      if (defe::is_orthogonal(cell))
        ortho.push_back(draft);
      else {
        general.push_back(draft);
        jt.cell.push_back(cell);
      }
    }
    const int n = static_cast<int>(ortho.size() + general.size());
    jt.nde = n;
    jt.north = static_cast<int>(ortho.size());
    jt.self.reserve(n);
    for (const auto *list : {&ortho, &general})
      for (const auto &c : *list) {
        jt.of_atom[c.atom] = static_cast<int>(jt.self.size());
        jt.self.push_back(c.atom);
        jt.rec.push_back(de[c.atom].get());
        jt.nb.push_back(c.nb);
        jt.len.push_back(c.len);
        jt.half.push_back(c.half);
      }
    for (int i = nlocal; i < nall; i++)
      if (outer_reach[i] > 0.0) {
        jt.of_atom[i] = static_cast<int>(jt.self.size());
        jt.self.push_back(i);
      }
    jt.nall = static_cast<int>(jt.self.size());
    jt.partner.resize(n);
    jt.present.assign(n, 0);
    jt.area.resize(n);
    jt.material.resize(n);
    jt.half_force.assign(jt.nall, std::array<double, 18>{});
    jt.energy.assign(jt.nall, 0.0);
    jt.state.assign(6 * static_cast<size_t>(jt.nall), DefeJoint::CONNECTIVE);

    for (int d = 0; d < n; d++) {
      const int i = jt.self[d];
      if (d + 2 < n) prefetch(jt.rec[d + 2]);
      DERecord &r = *jt.rec[d];
      jt.material[d] = static_cast<unsigned char>(r.part);
      if (r.newborn) jt.newborn.push_back(d);
      for (int s = 0; s < 6; s++) {
        JointSlot &slot = r.slot[s];
        jt.partner[d][s] = -1;
        jt.state[6 * d + s] = slot.plane ? DefeJoint::PLANE : slot.state;
        jt.area[d][s] = slot.area;
        if (slot.apart > 0.0) jt.apart.push_back({d, slot.other, slot.apart});
        if (slot.kind == DefeJoint::NONE || jt.state[6 * d + s] == DefeJoint::CONTACT) continue;
        if (slot.kind == DefeJoint::DE) {
          const int j = jt.nb[d][s];
          if (jt.of_atom[j] >= 0) jt.partner[d][s] = 6 * jt.of_atom[j] + slot.partner;
        } else {
          std::array<int, 4> node;
          for (int k = 0; k < 4; k++) {
            node[k] = domain->closest_image(i, local_of(slot.face_node[k]));
            if (node[k] < 0)
              error->one(FLERR, "Node {} of the face that DE {} is tied to is missing at step {}",
                         slot.face_node[k], atom->tag[i], update->ntimestep);
          }
          jt.nb[d][s] = ~static_cast<int>(jt.tie_node.size());
          jt.tie_node.push_back(node);
          jt.tie_element.push_back(slot.other);
          jt.tie_part.push_back(slot.part);
          if (slot.asks) jt.asking.push_back(6 * d + s);
        }
        if (slot.state == DefeJoint::CONNECTIVE) jt.present[d] |= 1 << s;
        if (slot.pending == 1) jt.pending.push_back(6 * d + s);
        // a joint is computed by its lower ID, a tie by its only DE
        if ((slot.state == DefeJoint::COHESIVE || slot.plane) &&
            (slot.kind == DefeJoint::TIE || atom->tag[i] < slot.other))
          jt.cohesive.push_back(6 * d + s);
      }
    }
    jt.tie_point.assign(3 * jt.tie_node.size() + 3, 0.0);
  }

  forced.clear();
  for (int i = 0; i < nlocal; i++)
    if ((atom->mask[i] & forced_bits) && in_account(i)) forced.push_back(i);
  build_surfaces();
  tables_built++;
  vector_step = -1;
  if (checking) {
    check_records("after reneighbouring");
    check_masses();
  }
}

/* ---------------------------------------------------------------------- */

void FixDefe::Batch::clear()
{
  node.clear();
  hex.clear();
  bound.clear();
  history.clear();
}

void JointTable::clear()
{
  nde = north = nall = 0;
  self.clear();
  of_atom.clear();
  rec.clear();
  nb.clear();
  partner.clear();
  present.clear();
  area.clear();
  tie_element.clear();
  tie_part.clear();
  apart.clear();
  len.clear();
  half.clear();
  material.clear();
  cell.clear();
  half_force.clear();
  energy.clear();
  state.clear();
  tie_node.clear();
  tie_point.clear();
  cohesive.clear();
  debonded.clear();
  asking.clear();
  newborn.clear();
  pending.clear();
}

double JointTable::distance_apart(int d, tagint other) const
{
  auto found = std::lower_bound(apart.begin(), apart.end(), d, [](const Apart &a, int de) {
    return a.de < de;
  });
  for (; found != apart.end() && found->de == d; ++found)
    if (found->other == other) return found->distance;
  return 0.0;
}

/* ----------------------------------------------------------------------
   index of an atom, -1 if it is not here. Atom::map() itself must not be asked for IDs
   above the largest one, which an atom that was deleted may have had.
------------------------------------------------------------------------- */

int FixDefe::local_of(tagint tag) const
{
  return (tag > 0 && tag <= atom->map_tag_max) ? atom->map(tag) : -1;
}

/* ----------------------------------------------------------------------
   local indices of an element's nodes, the images closest to its first node
------------------------------------------------------------------------- */

void FixDefe::hex_coords(const int *idx, HexCoords &x, HexCoords &X) const
{
  for (int a = 0; a < 8; a++)
    for (int k = 0; k < 3; k++) {
      x(k, a) = atom->x[idx[a]][k];
      X(k, a) = xframe[idx[a]][k];
    }
}

bool FixDefe::local_hex(const HexRecord &h, int anchor, int *idx) const
{
  const bool images = atom->nghost > 0;
  idx[0] = anchor;
  for (int a = 1; a < 8; a++) {
    const int j = local_of(h.node[a]);
    if (j < 0) return false;
    idx[a] = (images && atom->sametag[j] >= 0) ? domain->closest_image(anchor, j) : j;
  }
  return true;
}

/* ----------------------------------------------------------------------
   boxes of one shape and part share a kernel; all other shapes the Lagrangian one of their part
   the choice depends on the element alone, not on the decomposition
------------------------------------------------------------------------- */

int FixDefe::kernel_of(int part, const HexCoords &X)
{
  const Material &m = material_of(parts[part]);
  const HexCoords own = reproducible ? defe::fe::rounded_shape(X) : X;
  const bool shape = !m.rigid() && !force_lagrangian && m.law->has_shape_kernel(own);
  for (size_t k = 0; k < kernels.size(); k++) {
    if (kernels[k].part != part) continue;
    if (m.rigid()) return static_cast<int>(k);
    if (kernels[k].of_shape != shape) continue;
    if (!shape ||
        (reproducible ? kernels[k].shape == own : defe::fe::congruent(kernels[k].shape, X)))
      return static_cast<int>(k);
  }
  Kernel k;
  k.part = part;
  k.of_shape = shape;
  k.shape = own;
  if (!m.rigid()) {
    k.kernel = shape ? m.law->make_shape_kernel(own) : m.law->make_kernel();
    k.history = k.kernel->history_size();
  }
  kernels.push_back(std::move(k));
  Batch b;
  b.kernel = static_cast<int>(batches.size());
  b.rigid = m.rigid();
  b.convertible = parts[part].convertible;
  batches.push_back(std::move(b));
  return static_cast<int>(kernels.size()) - 1;
}

/* ----------------------------------------------------------------------
   internal forces of the elements and contact of surfaces
   here, not in pre_force: the pair style's own virial must not count them
------------------------------------------------------------------------- */

void FixDefe::setup_pre_reverse(int eflag, int vflag)
{
  pre_reverse(eflag, vflag);
}

void FixDefe::pre_reverse(int /*eflag*/, int vflag)
{
  v_init(vflag);
  vector_step = -1;    // minimisers evaluate forces many times in a step
  for (double &v : virial_fe) v = 0.0;

  if (subcycle.every() == 1 || update->whichflag == 2) {
    evaluate_finite(&atom->f[0][0], update->setupflag ? 0.0 : subcycle.since_history());
  } else if (subcycle.due() || vflag_global) {

    // two clocks, see subcycle.h

    const size_t n = 3 * (static_cast<size_t>(atom->nlocal) + atom->nghost);
    scratch.assign(n + 3, 0.0);
    evaluate_finite(scratch.data(),
                    !subcycle.due() || update->setupflag ? 0.0 : subcycle.since_history());
    if (subcycle.due() && n) {
      const int every = subcycle.every();
      double *f = &atom->f[0][0];
      for (size_t k = 0; k < n; k++) f[k] += every * scratch[k];
    }
  }
  if (contact_factor > 0.0) contact_forces();
  if (reproducible) check_range(false);
  if (vflag_global)
    for (int k = 0; k < 6; k++) virial[k] += virial_fe[k];
}

/* ----------------------------------------------------------------------
   forces of all elements of this rank, added to f; bounds of their stress
   material histories are advanced by history_step (0 = not)
------------------------------------------------------------------------- */

void FixDefe::evaluate_finite(double *f, double history_step)
{
  int inverted = -1, beyond = -1;
  for (auto &b : batches) {
    if (b.rigid || b.node.empty()) continue;
    defe::fe::HexKernel::Output out;
    if (b.convertible) {
      out.stress_bound = b.bound.data();
      out.bound_weights = parts[kernels[b.kernel].part].criterion->bound();
    }
    out.bound_at_gauss_points = gauss_stress;
    if (vflag_global) out.virial = virial_fe;
    if (!b.history.empty()) {
      out.history = b.history.data();
      out.dt = history_step;
      out.dissipation = &ledger.viscous;
    }
    out.inverted = &inverted;
    inverted = -1;
    if (reproducible) {
      out.grid = &force_grid;
      out.beyond = &beyond;
    }
    kernels[b.kernel].kernel->add_forces(static_cast<int>(b.node.size()),
                                         reinterpret_cast<const int(*)[8]>(b.node.data()),
                                         &atom->x[0][0], &xframe[0][0], f, out);
    if (inverted >= 0) {
      const HexRecord &h = *b.hex[inverted];
      const double *x = atom->x[b.node[inverted][0]];
      error->one(FLERR,
                 "Element {} of part {} turned inside out at step {} near {:.6g} {:.6g} {:.6g}: "
                 "use a smaller timestep, or let it convert earlier{}",
                 h.id, parts[h.part].name, update->ntimestep, x[0], x[1], x[2], minimizer_hint());
    }
    if (beyond >= 0) beyond_grid = b.node[beyond][0];
    beyond = -1;
  }
  if (history_step > 0.0) subcycle.history_advanced();
}

/* ----------------------------------------------------------------------
   all ghost forces have arrived: what is added after us is external
------------------------------------------------------------------------- */

void FixDefe::post_force(int /*vflag*/)
{
  if (reproducible) check_range(true);
  double **f = atom->f;
  f_internal.resize(6 * forced.size());
  for (size_t q = 0; q < forced.size(); q++)
    for (int k = 0; k < 3; k++) {
      f_internal[6 * q + k] = f[forced[q]][k];
      f_internal[6 * q + 3 + k] = atom->torque[forced[q]][k];
    }
}

/* ----------------------------------------------------------------------
   power of all forces that are not ours, with velocities at the full step
------------------------------------------------------------------------- */

double FixDefe::power_of_others() const
{
  double **f = atom->f;
  double **v = atom->v;
  double power = 0.0;
  for (size_t q = 0; q < forced.size(); q++) {
    const int i = forced[q];
    for (int k = 0; k < 3; k++) power += (f[i][k] - f_internal[6 * q + k]) * v[i][k];
    if (!(atom->radius[i] > 0.0)) continue;    // nodes do not turn
    for (int k = 0; k < 3; k++)
      power += (atom->torque[i][k] - f_internal[6 * q + 3 + k]) * atom->omega[i][k];
  }
  return power;
}

/* ----------------------------------------------------------------------
   groups that forces of other fixes act on: those of the fixes that change forces after us, or all
   atoms if there is one of which it is not known to keep to its group, or whose group is dynamic
------------------------------------------------------------------------- */

int FixDefe::groups_forced() const
{
  int bits = 0;
  bool after = false;
  for (auto *ifix : modify->get_fix_list()) {
    if (ifix == this) after = true;
    if (!after || ifix == this || !(ifix->setmask() & (POST_FORCE | POST_FORCE_RESPA))) continue;
    static const char *const keeps[] = {"^setforce", "^addforce", "^aveforce",    "^gravity",
                                        "^viscous",  "^wall/",    "^lineforce",   "^planeforce",
                                        "^drag",     "^efield",   "^spring/self", "^rigid",
                                        "^langevin", "^damping/"};
    const bool known = one_of(keeps, ifix->style);
    bits |= known && !group->dynamic[ifix->igroup] ? ifix->groupbit : 1;    // bit 1 is group all
  }
  return bits;
}

/* ----------------------------------------------------------------------
   does any node or DE move faster than anything physical?
------------------------------------------------------------------------- */

void FixDefe::watch_speed()
{
  const double *v = atom->nlocal ? atom->v[0] : nullptr;
  const double limit = max_step_length / update->dt;
  int beyond = 0;
  for (int i = 0; i < 3 * atom->nlocal; i++) beyond += !(std::abs(v[i]) <= limit);
  if (beyond) stop_exploded();
}

/* ----------------------------------------------------------------------
   first half kick: the forces of the last step, or those of setup
------------------------------------------------------------------------- */

void FixDefe::initial_integrate(int /*vflag*/)
{
  if (!running) begin_run();
  if (after_setup) {
    external_power = power_of_others();
    begin_energy_watch();
  }
  after_setup = false;
  ledger.external += 0.5 * update->dt * external_power;
  subcycle.advance(update->dt);
}

/* ----------------------------------------------------------------------
   the last moment before LAMMPS decides whether to reneighbour
------------------------------------------------------------------------- */

void FixDefe::post_integrate()
{
  if (mark_request == MPI_REQUEST_NULL) return;
  take_marks();
  if (marked_anywhere) schedule_conversion(subcycle.steps_of_impulse() - 1);
  if (marked_anywhere > 1) report_jump();
}

/* ---------------------------------------------------------------------- */

void FixDefe::setup(int vflag)
{
  after_setup = true;
  needs_setup = false;
  convert_step = -1;    // what is marked is scheduled anew
  if (contact_factor > 0.0) report_contacts();
  continue_with_kept_forces();
  flush_events();    // a file that cannot be written ends the run here, not after hours
  post_force(vflag);

  // between two evaluations of the elements, those that were marked then stay so

  if (subcycle.due()) {
    for (auto &b : batches)
      if (b.convertible)
        for (auto *h : b.hex) h->marked = 0;
    mark_elements();
  } else {
    int mine = !jt.asking.empty(), any = 0;
    for (const auto &b : batches)
      if (b.convertible)
        for (const auto *h : b.hex) mine = mine || h->marked;
    MPI_Allreduce(&mine, &any, 1, MPI_INT, MPI_MAX, world);
    if (any) schedule_conversion(subcycle.steps_of_impulse() - subcycle.phase());
  }
}

/* ----------------------------------------------------------------------
   half of the impulse of m steps is still to come when elements are marked: they convert when
   their forces have ended
------------------------------------------------------------------------- */

void FixDefe::schedule_conversion(int steps)
{
  convert_step = update->ntimestep + steps;
  next_reneighbor = convert_step;
}

/* ----------------------------------------------------------------------
   all ranks must reneighbour together: one number is reduced while LAMMPS goes on
------------------------------------------------------------------------- */

void FixDefe::ask_marks()
{
  take_marks();
  MPI_Iallreduce(&marked_here, &marked_anywhere, 1, MPI_INT, MPI_MAX, world, &mark_request);
}

void FixDefe::take_marks()
{
  if (mark_request != MPI_REQUEST_NULL) MPI_Wait(&mark_request, MPI_STATUS_IGNORE);
}

/* ---------------------------------------------------------------------- */

void FixDefe::end_of_step()
{
  // no first half kick: rerun sets positions and asks for forces

  if (after_setup) {
    int mine = 0, any = 0;
    for (const auto &b : batches) mine = mine || !b.history.empty();
    MPI_Allreduce(&mine, &any, 1, MPI_INT, MPI_MAX, world);
    if (any)
      error->all(FLERR,
                 "Fix defe: rerun cannot follow materials with a memory (prony): what is in a dump "
                 "does not tell their stress");
    take_marks();
    if (des_total > 0 || convert_step >= 0 || marked_anywhere)
      error->all(FLERR,
                 "Fix defe: rerun cannot follow a body in which elements convert (step {}); it "
                 "works for finite elements only",
                 update->ntimestep);
    vector_step = -1;
    clock = now();
    return;
  }

  // second half kick of this step

  external_power = power_of_others();
  ledger.external += 0.5 * update->dt * external_power;
  if (update->ntimestep % WATCH_EVERY == 0 || update->ntimestep == output->next_restart ||
      update->ntimestep == update->laststep)
    watch_speed();

  if (subcycle.due()) mark_elements();
  clock = now();
  last_step = update->ntimestep;
  vector_step = -1;
  if (update->ntimestep % ENERGY_EVERY == 0 || update->ntimestep == update->laststep)
    watch_energy();
  if (update->ntimestep % FLUSH_EVERY == 0) flush_events();
}

/* ---------------------------------------------------------------------- */

void FixDefe::post_run()
{
  // whether elements convert in the next step is not asked again by a run with `pre no`

  const bool asked = mark_request != MPI_REQUEST_NULL;
  take_marks();
  if (asked && marked_anywhere) schedule_conversion(subcycle.steps_of_impulse());
  if (asked && marked_anywhere > 1) report_jump();
  if (running) watch_speed();    // a run that halts early
  if (update->whichflag == 1) keep_forces();
  running = false;
  flush_events();
  if (contact_factor > 0.0) report_contacts();
  fill_vector();
  between_runs = true;
}

/* ----------------------------------------------------------------------
   stress and centre of one owned element, for output
------------------------------------------------------------------------- */

void FixDefe::centre_stress(const HexRecord &h, double *centre, double *stress6, double &s1) const
{
  int idx[8];
  int anchor = local_of(h.node[0]);
  for (int k = 0; k < 3; k++) centre[k] = 0.0;
  for (int k = 0; k < 6; k++) stress6[k] = 0.0;
  s1 = 0.0;
  if (anchor < 0 || !local_hex(h, anchor, idx)) return;
  HexCoords x, X;
  hex_coords(idx, x, X);
  for (int k = 0; k < 3; k++) centre[k] = x.row(k).mean();
  if (material_of(parts[h.part]).rigid() || h.kernel < 0) return;
  const bool virgin = !h.extra || h.extra->history.empty();
  const Mat3 s = kernels[h.kernel].kernel->stress(x, X, Vec3::Zero(),
                                                  virgin ? nullptr : h.extra->history.data());
  stress6[0] = s(0, 0);
  stress6[1] = s(1, 1);
  stress6[2] = s(2, 2);
  stress6[3] = s(0, 1);
  stress6[4] = s(0, 2);
  stress6[5] = s(1, 2);
  s1 = defe::fe::max_principal(s);
}

/* ----------------------------------------------------------------------
   per-atom data
------------------------------------------------------------------------- */

void FixDefe::grow_arrays(int nmax)
{
  memory->grow(xref, nmax, 3, "defe:xref");
  memory->grow(xframe, nmax, 3, "defe:xframe");
  memory->grow(nelem, nmax, "defe:nelem");
  hexes.resize(nmax);
  de.resize(nmax);
  touch.resize(nmax);
  if (!kept.empty()) kept.resize(nmax);
}

void FixDefe::copy_arrays(int i, int j, int /*delflag*/)
{
  if (i == j) return;
  for (int k = 0; k < 3; k++) {
    xref[j][k] = xref[i][k];
    xframe[j][k] = xframe[i][k];
  }
  nelem[j] = nelem[i];
  if (!kept.empty()) kept[j] = kept[i];
  // LAMMPS copies only to move: the source slot is dead afterwards

  hexes[j] = std::move(hexes[i]);
  hexes[i].clear();
  de[j] = std::move(de[i]);
  touch[j] = std::move(touch[i]);
}

void FixDefe::set_arrays(int i)
{
  touch[i].reset();
  if (!kept.empty()) kept[i].motion = 0;
  if (update->whichflag == 1 && !giving_birth) register_newcomer(i);

  // read_data sets the arrays of new atoms after it has read the sections: keep the elements

  nelem[i] = 0;
  de[i].reset();
  const bool came = i < static_cast<int>(just_read.size()) && just_read[i];
  if (came)
    just_read[i] = 0;
  else
    hexes[i].clear();    // left by an atom that was deleted
  for (int k = 0; k < 3; k++) xref[i][k] = xframe[i][k] = atom->x[i][k];
  if (reading) domain->unmap(atom->x[i], atom->image[i], xref[i]);
}

void FixDefe::set_reference(int i, const double *x)
{
  for (int k = 0; k < 3; k++) xref[i][k] = xframe[i][k] = x[k];
}

void FixDefe::add_hex(int i, tagint hexid, int part, const tagint *nodes)
{
  HexRecord h;
  memset(static_cast<void *>(static_cast<HexPod *>(&h)), 0, sizeof(HexPod));    // gaps, too
  h.id = hexid;
  h.part = part;
  for (int a = 0; a < 8; a++) h.node[a] = nodes[a];
  for (int f = 0; f < 6; f++) {
    h.nb[f] = 0;
    h.nbface[f] = h.nbrot[f] = h.nbpart[f] = 0;
  }
  h.marked = 0;
  hexes[i].push_back(std::move(h));
  hexes_added++;
  mesh_dirty = true;
}

bigint FixDefe::last_hex_id() const
{
  bigint mine = 0, last = 0;
  for (int i = 0; i < atom->nlocal; i++)
    for (const auto &h : hexes[i]) mine = MAX(mine, static_cast<bigint>(h.id));
  MPI_Allreduce(&mine, &last, 1, MPI_LMP_BIGINT, MPI_MAX, world);
  return last;
}

/* ----------------------------------------------------------------------
   record of one atom: count, reference, elements at node, DE, elements
------------------------------------------------------------------------- */

int FixDefe::record_size(int i) const
{
  int n = RECORD_SIZE;
  if (de[i]) n += DE_SIZE;
  if (has_kept(i)) n += KEPT_SIZE;
  if (touch[i])
    n += TOUCH_SIZE * static_cast<int>(touch[i]->faces.size()) +
        SPHERE_SIZE * static_cast<int>(touch[i]->spheres.size()) +
        CRACK_SIZE * static_cast<int>(touch[i]->cracks.size());
  for (const auto &h : hexes[i]) {
    n += HEX_SIZE + 2;
    if (h.extra) n += static_cast<int>(4 * h.extra->shields.size() + h.extra->history.size());
  }
  return n;
}

int FixDefe::pack_record(int i, double *buf) const
{
  int m = 1;
  for (int k = 0; k < 3; k++) buf[m++] = xref[i][k];
  buf[m++] = ubuf(nelem[i]).d;
  buf[m++] = ubuf(de[i] ? 1 : 0).d;
  buf[m++] = ubuf(static_cast<int>(hexes[i].size())).d;
  buf[m++] = ubuf(touch[i] ? static_cast<int>(touch[i]->faces.size()) : 0).d;
  buf[m++] = ubuf(touch[i] && touch[i]->fresh ? 1 : 0).d;
  buf[m++] = ubuf(touch[i] ? static_cast<int>(touch[i]->spheres.size()) : 0).d;
  buf[m++] = ubuf(touch[i] ? static_cast<int>(touch[i]->cracks.size()) : 0).d;
  buf[m++] = ubuf(has_kept(i) ? 1 : 0).d;
  if (has_kept(i)) {
    memcpy(static_cast<void *>(&buf[m]), &kept[i], sizeof(KeptForces));
    m += KEPT_SIZE;
  }
  if (touch[i]) {
    for (const auto &t : touch[i]->faces) {
      memcpy(static_cast<void *>(&buf[m]), &t, sizeof(DefeTouch));
      m += TOUCH_SIZE;
    }
    for (const auto &t : touch[i]->spheres) {
      memcpy(static_cast<void *>(&buf[m]), &t, sizeof(SphereTouch));
      m += SPHERE_SIZE;
    }
    for (const auto &c : touch[i]->cracks) {
      memcpy(static_cast<void *>(&buf[m]), &c, sizeof(JointCrack));
      m += CRACK_SIZE;
    }
  }
  if (de[i]) {
    memcpy(static_cast<void *>(&buf[m]), de[i].get(), sizeof(DERecord));
    m += DE_SIZE;
  }
  for (const auto &h : hexes[i]) {
    memcpy(static_cast<void *>(&buf[m]), static_cast<const HexPod *>(&h), sizeof(HexPod));
    m += HEX_SIZE;
    buf[m++] = ubuf(h.extra ? static_cast<int>(h.extra->shields.size()) : 0).d;
    buf[m++] = ubuf(h.extra ? static_cast<int>(h.extra->history.size()) : 0).d;
    if (!h.extra) continue;
    for (const auto &s : h.extra->shields) {
      for (int k = 0; k < 3; k++) buf[m++] = s.direction[k];
      buf[m++] = s.time;
    }
    for (double q : h.extra->history) buf[m++] = q;
  }
  buf[0] = m;
  return m;
}

int FixDefe::unpack_record(int i, const double *buf)
{
  int m = 1;
  for (int k = 0; k < 3; k++) xref[i][k] = xframe[i][k] = buf[m++];
  nelem[i] = static_cast<int>(ubuf(buf[m++]).i);
  const int has_de = static_cast<int>(ubuf(buf[m++]).i);
  const int nhex = static_cast<int>(ubuf(buf[m++]).i);
  const int nfaces = static_cast<int>(ubuf(buf[m++]).i);
  const bool was_just_born = ubuf(buf[m++]).i != 0;
  const int nspheres = static_cast<int>(ubuf(buf[m++]).i);
  const int ncracks = static_cast<int>(ubuf(buf[m++]).i);
  if (ubuf(buf[m++]).i != 0) {
    kept.resize(hexes.size());
    memcpy(static_cast<void *>(&kept[i]), &buf[m], sizeof(KeptForces));
    m += KEPT_SIZE;
  } else if (!kept.empty())
    kept[i].motion = 0;
  touch[i].reset();
  if (nfaces + nspheres + ncracks > 0 || was_just_born) {
    AtomTouch &t = touch_at(i);
    t.fresh = was_just_born;
    t.faces.resize(nfaces);
    t.spheres.resize(nspheres);
    t.cracks.resize(ncracks);
    for (auto &face : t.faces) {
      memcpy(static_cast<void *>(&face), &buf[m], sizeof(DefeTouch));
      m += TOUCH_SIZE;
    }
    for (auto &sphere : t.spheres) {
      memcpy(static_cast<void *>(&sphere), &buf[m], sizeof(SphereTouch));
      m += SPHERE_SIZE;
    }
    for (auto &crack : t.cracks) {
      memcpy(static_cast<void *>(&crack), &buf[m], sizeof(JointCrack));
      m += CRACK_SIZE;
    }
  }
  de[i].reset();
  if (has_de) {
    de[i] = std::make_unique<DERecord>();
    memcpy(static_cast<void *>(de[i].get()), &buf[m], sizeof(DERecord));
    m += DE_SIZE;
  }
  hexes[i].clear();
  for (int e = 0; e < nhex; e++) {
    HexRecord h;
    memcpy(static_cast<void *>(static_cast<HexPod *>(&h)), &buf[m], sizeof(HexPod));
    m += HEX_SIZE;
    const int ns = static_cast<int>(ubuf(buf[m++]).i);
    const int nhistory = static_cast<int>(ubuf(buf[m++]).i);
    for (int s = 0; s < ns; s++) {
      defe::Shield sh;
      for (int k = 0; k < 3; k++) sh.direction[k] = buf[m++];
      sh.time = buf[m++];
      h.with_extra().shields.push_back(sh);
    }
    if (nhistory) {
      h.with_extra().history.assign(buf + m, buf + m + nhistory);
      m += nhistory;
    }
    hexes[i].push_back(std::move(h));
  }
  return m;
}

int FixDefe::pack_exchange(int i, double *buf)
{
  return pack_record(i, buf);
}

int FixDefe::unpack_exchange(int i, double *buf)
{
  return unpack_record(i, buf);
}

void FixDefe::update_maxexchange()
{
  for (const auto &k : kernels) history_most = MAX(history_most, k.history);
  int touches = 0;
  for (int i = 0; i < atom->nlocal; i++)
    if (touch[i])
      touches = MAX(touches,
                    TOUCH_SIZE * static_cast<int>(touch[i]->faces.size()) +
                        SPHERE_SIZE * static_cast<int>(touch[i]->spheres.size()) +
                        CRACK_SIZE * static_cast<int>(touch[i]->cracks.size()));

  // more than any atom has, also after a conversion that follows

  maxexchange = RECORD_SIZE + DE_SIZE + touches + (kept.empty() ? 0 : KEPT_SIZE) +
      hexes_per_node * (HEX_SIZE + 2 + 4 * MAX_SHIELDS + history_most);
}

/* ----------------------------------------------------------------------
   communication with ghosts
------------------------------------------------------------------------- */

int FixDefe::pack_forward_comm(int n, int *list, double *buf, int pbc_flag, int *pbc)
{
  if (n == 0) return 0;    // tiled ranks send empty messages, too
  double shift[3] = {0.0, 0.0, 0.0};
  if (pbc_flag) {
    shift[0] = pbc[0] * domain->xprd;
    shift[1] = pbc[1] * domain->yprd;
    shift[2] = pbc[2] * domain->zprd;
  }
  int m = 0;
  if (comm_mode == FRAME) {
    for (int ii = 0; ii < n; ii++) {
      for (int k = 0; k < 3; k++) buf[m++] = xframe[list[ii]][k] + shift[k];
      buf[m++] = outer_reach[list[ii]];
      buf[m++] = outer_length[list[ii]];
    }
  } else if (comm_mode == POSVEL) {
    for (int ii = 0; ii < n; ii++) {
      for (int k = 0; k < 3; k++) buf[m++] = atom->x[list[ii]][k] + shift[k];
      for (int k = 0; k < 3; k++) buf[m++] = atom->v[list[ii]][k];
    }
  } else if (comm_mode == SURFACE) {
    m = 1;
    for (int ii = 0; ii < n; ii++) {
      auto found = surface_at.find(list[ii]);
      if (found == surface_at.end() || comm_round >= static_cast<int>(found->second.size()))
        continue;
      buf[m++] = ubuf(ii).d;
      memcpy(static_cast<void *>(&buf[m]), &found->second[comm_round], sizeof(HexPod));
      m += HEX_SIZE;
    }
    buf[0] = ubuf(m).d;
  } else if (comm_mode == ASKED) {
    m = 1;
    for (int ii = 0; ii < n && !asked_at.empty(); ii++) {
      auto found = asked_at.find(list[ii]);
      if (found == asked_at.end()) continue;
      buf[m++] = ubuf(ii).d;
      buf[m++] = ubuf(static_cast<int>(found->second.size())).d;
      for (tagint element : found->second) buf[m++] = ubuf(element).d;
    }
    buf[0] = ubuf(m).d;
  } else if (comm_mode == MARKED) {
    m = 1;
    for (int ii = 0; ii < n && !marked_at.empty(); ii++) {
      auto found = marked_at.find(list[ii]);
      if (found == marked_at.end() || comm_round >= static_cast<int>(found->second.size()))
        continue;
      // positions from the atom that it goes with, so that no image matters
      const auto at = found->second[comm_round];
      const defe::ConvertingHex &c = converting[at.first];
      buf[m++] = ubuf(ii).d;
      buf[m++] = ubuf(c.id).d;
      buf[m++] = ubuf(c.lot).d;
      for (auto t : c.node) buf[m++] = ubuf(t).d;
      for (const auto &xa : c.x)
        // bit for bit, they are those of the element's first node: who uses them takes the nearest image
        for (int k = 0; k < 3; k++) buf[m++] = reproducible ? xa[k] : xa[k] - c.x[at.second][k];
    }
    buf[0] = ubuf(m).d;
  }
  return m;
}

void FixDefe::unpack_forward_comm(int n, int first, double *buf)
{
  int m = 0;
  const int last = first + n;
  if (comm_mode == FRAME) {
    for (int i = first; i < last; i++) {
      for (int k = 0; k < 3; k++) xframe[i][k] = buf[m++];
      outer_reach[i] = buf[m++];
      outer_length[i] = buf[m++];
    }
  } else if (comm_mode == POSVEL) {
    for (int i = first; i < last; i++) {
      for (int k = 0; k < 3; k++) atom->x[i][k] = buf[m++];
      for (int k = 0; k < 3; k++) atom->v[i][k] = buf[m++];
    }
  } else if (comm_mode == SURFACE && n > 0) {
    const int end = static_cast<int>(ubuf(buf[m++]).i);
    while (m < end) {
      const int i = first + static_cast<int>(ubuf(buf[m++]).i);
      HexPod h;
      memcpy(static_cast<void *>(&h), &buf[m], sizeof(HexPod));
      m += HEX_SIZE;
      surface_at[i].push_back(h);
    }
  } else if (comm_mode == ASKED && n > 0) {
    const int end = static_cast<int>(ubuf(buf[m++]).i);
    while (m < end) {
      auto &here =
          asked_at[first + static_cast<int>(ubuf(buf[m++]).i)];    // on its way to a third rank
      for (int k = static_cast<int>(ubuf(buf[m++]).i); k > 0; k--) {
        here.push_back(static_cast<tagint>(ubuf(buf[m++]).i));
        asked.insert(here.back());
      }
    }
  } else if (comm_mode == MARKED && n > 0) {
    const int end = static_cast<int>(ubuf(buf[m++]).i);
    while (m < end) {
      const int i = first + static_cast<int>(ubuf(buf[m++]).i);
      defe::ConvertingHex c;
      c.id = static_cast<tagint>(ubuf(buf[m++]).i);
      c.lot = static_cast<tagint>(ubuf(buf[m++]).i);
      for (auto &t : c.node) t = ubuf(buf[m++]).i;
      for (auto &xa : c.x)
        for (int k = 0; k < 3; k++) xa[k] = reproducible ? buf[m++] : atom->x[i][k] + buf[m++];
      const auto *corner = std::find(std::begin(c.node), std::end(c.node), atom->tag[i]);
      marked_at[i].emplace_back(static_cast<int>(converting.size()),
                                static_cast<int>(corner - std::begin(c.node)));
      converting.push_back(c);
    }
  }
}

int FixDefe::pack_reverse_comm(int n, int first, double *buf)
{
  int m = 0;
  if (comm_mode == FINITE) {
    const int size = 3 * n;
    if (n) memcpy(buf, &scratch[3 * static_cast<size_t>(first)], size * sizeof(double));
    return size;
  }
  for (int i = first; i < first + n; i++) {
    buf[m++] = loss_mass[i];
    buf[m++] = loss_count[i];
  }
  return m;
}

void FixDefe::unpack_reverse_comm(int n, int *list, double *buf)
{
  int m = 0;
  if (comm_mode == FINITE) {
    for (int ii = 0; ii < n; ii++)
      for (int k = 0; k < 3; k++) scratch[3 * static_cast<size_t>(list[ii]) + k] += buf[m++];
    return;
  }
  for (int ii = 0; ii < n; ii++) {
    loss_mass[list[ii]] += buf[m++];
    loss_count[list[ii]] += static_cast<int>(std::lround(buf[m++]));
  }
}

/* ---------------------------------------------------------------------- */

double FixDefe::memory_usage()
{
  double bytes = static_cast<double>(atom->nmax) *
      (6 * sizeof(double) + sizeof(int) + sizeof(hexes[0]) + sizeof(de[0]) + sizeof(touch[0]));
  for (int i = 0; i < atom->nlocal; i++) {
    bytes += hexes[i].capacity() * sizeof(HexRecord);
    if (de[i]) bytes += sizeof(DERecord);
  }
  for (const auto &b : batches)
    bytes += b.node.capacity() * (sizeof(b.node[0]) + sizeof(b.hex[0]) + sizeof(double));
  bytes += kept.capacity() * sizeof(KeptForces);
  bytes += jt.self.capacity() * 400.0;
  return bytes;
}

void *FixDefe::extract(const char *name, int &dim)
{
  dim = 0;
  if (strcmp(name, "defe") == 0) return this;
  if (strcmp(name, "dt_finite") == 0) return &dt_finite;
  if (strcmp(name, "dt_discrete") == 0) return &dt_discrete;
  return nullptr;
}
