/* ----------------------------------------------------------------------
   DEFE: adaptive finite elements to bonded discrete elements for LAMMPS
   https://www.lammps.org/
   This software is distributed under the GNU General Public License.
------------------------------------------------------------------------- */

#include "create_hexes.h"

#include "defe_system.h"

#include "atom.h"
#include "atom_vec.h"
#include "comm.h"
#include "domain.h"
#include "error.h"
#include "irregular.h"
#include "modify.h"

#include <cmath>

using namespace LAMMPS_NS;

/* ----------------------------------------------------------------------
   node lines of one axis: start, then pairs (number of elements, end)
------------------------------------------------------------------------- */

std::vector<double> CreateHexes::lines(int &iarg, int narg, char **arg, const char *axis)
{
  if (iarg >= narg || strcmp(arg[iarg], axis) != 0)
    error->all(FLERR, "Command create_hexes: expected '{} START N END ...'", axis);
  iarg++;
  if (iarg >= narg) utils::missing_cmd_args(FLERR, std::string("create_hexes ") + axis, error);
  std::vector<double> x{utils::numeric(FLERR, arg[iarg++], false, lmp)};
  while (iarg + 1 < narg && utils::is_integer(arg[iarg])) {
    const int n = utils::inumeric(FLERR, arg[iarg], false, lmp);
    const double from = x.back();
    const double to = utils::numeric(FLERR, arg[iarg + 1], false, lmp);
    if (n < 1) error->all(FLERR, "Command create_hexes {}: {} elements in a segment", axis, n);
    if (!(to > from) || !std::isfinite(to))
      error->all(FLERR, "Command create_hexes {}: segment from {} to {} must go up", axis, from,
                 to);
    if (static_cast<bigint>(x.size()) + n > MAXTAGINT / 4)
      error->all(FLERR, "Command create_hexes {}: too many nodes for the atom IDs of this LAMMPS",
                 axis);
    for (int k = 1; k <= n; k++)
      x.push_back(k == n ? to : from + (to - from) * (static_cast<double>(k) / n));
    iarg += 2;
  }
  if (x.size() < 2)
    error->all(FLERR, "Command create_hexes {}: give START N END, N an integer", axis);
  return x;
}

/* ---------------------------------------------------------------------- */

void CreateHexes::command(int narg, char **arg)
{
  if (domain->box_exist == 0)
    error->all(FLERR, "Command create_hexes must come after create_box or read_data");
  if (narg < 3) utils::missing_cmd_args(FLERR, "create_hexes", error);

  sys = DefeSystem::of(modify->get_fix_by_id(arg[0]));
  if (!sys) error->all(FLERR, "Command create_hexes: {} is not the ID of a fix defe", arg[0]);
  part = sys->model.find_part(arg[1]);
  if (part < 0) error->all(FLERR, "Command create_hexes: fix {} has no part {}", arg[0], arg[1]);
  type = utils::inumeric(FLERR, arg[2], false, lmp);
  if (type < 1 || type > atom->ntypes)
    error->all(FLERR, "Command create_hexes: atom type {} does not exist (1 to {})", type,
               atom->ntypes);
  if (sys->census.des() > 0)
    error->all(FLERR, "Command create_hexes: all meshes must be made before elements convert");
  int iarg = 3;
  line[0] = lines(iarg, narg, arg, "x");
  line[1] = lines(iarg, narg, arg, "y");
  line[2] = lines(iarg, narg, arg, "z");
  read_closed(iarg, narg, arg);
  if (iarg < narg) error->all(FLERR, "Command create_hexes: unknown word {}", arg[iarg]);
  check_box();

  for (int k = 0; k < 3; k++) n[k] = elements(k) + (closed[k] ? 0 : 1);
  const bigint nodes = n[0] * n[1] * n[2];
  first_hex = sys->mesh.last_hex_id() + 1;
  tagint mine = 0;
  for (int i = 0; i < atom->nlocal; i++) mine = MAX(mine, atom->tag[i]);
  MPI_Allreduce(&mine, &last_tag, 1, MPI_LMP_TAGINT, MPI_MAX, world);
  if (static_cast<bigint>(last_tag) + nodes > MAXTAGINT)
    error->all(FLERR, "Command create_hexes: too many nodes for the atom IDs of this LAMMPS");

  const int nlocal_before = atom->nlocal;
  create_nodes();
  sys->mesh.changed();
  bigint created = atom->nlocal - nlocal_before, all = 0;
  MPI_Allreduce(&created, &all, 1, MPI_LMP_BIGINT, MPI_SUM, world);
  if (all != nodes)
    error->all(FLERR, "Command create_hexes made {} of {} nodes: is the mesh inside the box?", all,
               nodes);
  register_atoms();
  if (comm->me == 0)
    utils::logmesg(lmp, "Created {} hexahedra and {} nodes of part {}\n",
                   elements(0) * elements(1) * elements(2), nodes, arg[1]);
}

/* ----------------------------------------------------------------------
   closed: the axes, as one word
------------------------------------------------------------------------- */

void CreateHexes::read_closed(int &iarg, int narg, char **arg)
{
  if (iarg >= narg || strcmp(arg[iarg], "closed") != 0) return;
  if (iarg + 1 == narg) utils::missing_cmd_args(FLERR, "create_hexes closed", error);
  const std::string axes = arg[iarg + 1];
  for (char axis : axes) {
    const int k = axis - 'x';
    if (k < 0 || k > 2 || closed[k])
      error->all(FLERR, "Command create_hexes closed: expected axes, as xy, not {}", axes);
    closed[k] = true;
    if (domain->boundary[k][0] != 0)
      error->all(FLERR,
                 "Command create_hexes closed: the box is not periodic in {}: use boundary p",
                 axis);
    const double length = line[k].back() - line[k].front();
    if (std::abs(length - domain->prd[k]) > 1.0e-9 * domain->prd[k])
      error->all(FLERR,
                 "Command create_hexes closed: the mesh is {:.10g} long in {}, the periodic box "
                 "{:.10g}: a closed mesh is as long as the box",
                 length, axis, domain->prd[k]);
    // all elements know their nodes by the nearest images
    for (bigint e = 0; e < elements(k); e++)
      if (line[k][e + 1] - line[k][e] > 0.25 * length)
        error->all(FLERR,
                   "Command create_hexes closed: an element from {} to {} in {} is longer than a "
                   "quarter of the box: use smaller ones",
                   line[k][e], line[k][e + 1], axis);
  }
  iarg += 2;
}

/* ----------------------------------------------------------------------
   boundary: 0 periodic, 1 fixed, else shrink-wrapped: a box that follows its atoms
------------------------------------------------------------------------- */

void CreateHexes::check_box() const
{
  for (int k = 0; k < 3; k++) {
    const char axis = "xyz"[k];
    const double from = line[k].front(), to = line[k].back();
    const bool below = domain->boundary[k][0] == 1 && from < domain->boxlo[k];
    // an atom on the upper face of the box counts as outside
    const bool above = domain->boundary[k][1] == 1 && to >= domain->boxhi[k];
    if (below || above)
      error->all(FLERR,
                 "Command create_hexes: mesh from {} to {} in {} reaches outside the box ({} to "
                 "below {}): "
                 "enlarge the box or use a shrink-wrapped boundary",
                 from, to, axis, domain->boxlo[k], domain->boxhi[k]);
    if (domain->boundary[k][0] == 0 && to - from > domain->prd[k])
      error->all(FLERR,
                 "Command create_hexes: mesh from {} to {} in {} is longer than the periodic box "
                 "({}) and would overlap itself",
                 from, to, axis, domain->prd[k]);
  }
}

/* ----------------------------------------------------------------------
   nodes of this rank, with the elements of which they are the first
------------------------------------------------------------------------- */

void CreateHexes::create_nodes()
{
  // sub-domains at the border of a non-periodic box are open-ended, as in read_data

  if (comm->nprocs > 0) {
    domain->init();
    domain->set_local_box();
  }
  const int periodic[3] = {domain->xperiodic, domain->yperiodic, domain->zperiodic};
  double lo[3], hi[3];
  for (int k = 0; k < 3; k++) {
    lo[k] = domain->sublo[k];
    hi[k] = domain->subhi[k];
    if (!periodic[k]) {
      if (domain->sublo[k] == domain->boxlo[k]) lo[k] = -HUGE_VAL;
      if (domain->subhi[k] == domain->boxhi[k]) hi[k] = HUGE_VAL;
    }
  }
  for (bigint k = 0; k < n[2]; k++)
    for (bigint j = 0; j < n[1]; j++)
      for (bigint i = 0; i < n[0]; i++) {
        const double ref[3] = {line[0][i], line[1][j], line[2][k]};
        double x[3] = {ref[0], ref[1], ref[2]};
        imageint image = ((imageint) IMGMAX << IMG2BITS) | ((imageint) IMGMAX << IMGBITS) | IMGMAX;
        domain->remap(x, image);
        bool inside = true;
        for (int d = 0; d < 3; d++) inside = inside && x[d] >= lo[d] && x[d] < hi[d];
        if (!inside) continue;
        atom->avec->create_atom(type, x);
        const int me = atom->nlocal - 1;
        atom->tag[me] = tag_of(i, j, k);
        atom->image[me] = image;
        atom->radius[me] = 0.0;
        atom->rmass[me] = 1.0;    // the lumped mass follows with the topology
        modify->create_attribute(me);
        sys->store.set_reference(me, ref);
        if (i < elements(0) && j < elements(1) && k < elements(2)) add_element(me, i, j, k);
      }
}

void CreateHexes::add_element(int me, bigint i, bigint j, bigint k)
{
  tagint node[8];
  static constexpr int corner[4][2] = {{0, 0}, {1, 0}, {1, 1}, {0, 1}};
  for (int a = 0; a < 8; a++)
    node[a] =
        tag_of((i + corner[a % 4][0]) % n[0], (j + corner[a % 4][1]) % n[1], (k + a / 4) % n[2]);
  const bigint id = first_hex + i + elements(0) * (j + elements(1) * k);
  sys->mesh.add_hex(me, static_cast<tagint>(id), part, node);
}

void CreateHexes::register_atoms()
{
  bigint nlocal = atom->nlocal;
  MPI_Allreduce(&nlocal, &atom->natoms, 1, MPI_LMP_BIGINT, MPI_SUM, world);
  atom->nghost = 0;
  atom->map_init();
  atom->map_set();

  // the first setup shrinks a shrink-wrapped box, and exchange moves atoms by one sub-domain only

  if (domain->nonperiodic == 2) {
    domain->reset_box();
    Irregular irregular(lmp);
    irregular.migrate_atoms(1);
    atom->map_init();
    atom->map_set();
  }
}
