/* ----------------------------------------------------------------------
   DEFE: adaptive finite elements to bonded discrete elements for LAMMPS
   https://www.lammps.org/
   This software is distributed under the GNU General Public License.
------------------------------------------------------------------------- */

#include "fix_defe_vtk.h"

#include "defe_system.h"
#include "defe_vtk_file.h"
#include "defe_vtk_kinds.h"

#include "comm.h"
#include "domain.h"
#include "error.h"
#include "force.h"
#include "modify.h"
#include "region.h"
#include "update.h"

#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstring>

using namespace LAMMPS_NS;
using namespace FixConst;

static const char *const kind_names[] = {"elements", "spheres", "joints"};

/* ---------------------------------------------------------------------- */

FixDefeVTK::FixDefeVTK(LAMMPS *lmp, int narg, char **arg) : Fix(lmp, narg, arg)
{
  if (narg < 5) utils::missing_cmd_args(FLERR, "fix defe/vtk", error);
  if (const char *package = vtk_files_need())
    error->all(FLERR,
               "Fix defe/vtk: this DEFE was built without HDF5: install the package {} and build "
               "DEFE again",
               package);
  nevery = utils::inumeric(FLERR, arg[3], false, lmp);
  if (nevery <= 0) error->all(FLERR, "Fix defe/vtk: every N steps: N must be > 0, not {}", arg[3]);
  if (!DefeSystem::find(lmp))
    error->all(FLERR, "Fix defe/vtk needs a fix defe, which must be defined before it");
  base = arg[4];
  check_base();

  restart_global = 1;
  time_depend = 1;    // steps are in the names of the files
  dynamic_group_allow = 1;
  comm_forward = 1;
  comm_reverse = 1;
  parse(narg, arg);
  std::vector<std::string> names;
  for (const auto &k : kinds) {
    k->add_computes();
    names.push_back(k->name);
  }
  series = std::make_unique<defe::VtkSeries>(base, names);
}

FixDefeVTK::~FixDefeVTK()
{
  for (auto &k : kinds) k->delete_computes();
}

/* ----------------------------------------------------------------------
   names that no file can have are found out now and not at the first step that is written
------------------------------------------------------------------------- */

void FixDefeVTK::check_base() const
{
  if (base.find_first_of("*%") != std::string::npos || base.empty() || base.back() == '/')
    error->all(FLERR,
               "Fix defe/vtk: {} is no beginning of file names: give it without * and %, as in "
               "output/pane for output/pane_elements_100.hdf",
               base);
  const auto slash = base.find_last_of('/');
  const std::string folder = slash == std::string::npos ? "." : base.substr(0, slash + 1);
  std::string complaint;
  if (comm->me == 0 && access(folder.c_str(), W_OK | X_OK) != 0)
    complaint = "cannot write into folder " + folder + ": " + std::strerror(errno);
  stop_by_first_rank(complaint);
  for (const auto *other : modify->get_fix_by_style("^defe/vtk$")) {
    const auto *vtk = dynamic_cast<const FixDefeVTK *>(other);
    if (vtk && other != this && vtk->base == base)
      error->all(FLERR, "Fix defe/vtk: fix {} writes files {} already: give another name",
                 other->id, base);
  }
}

/* ---------------------------------------------------------------------- */

void FixDefeVTK::parse(int narg, char **arg)
{
  const auto is_kind = [](const std::string &word) {
    return std::find(std::begin(kind_names), std::end(kind_names), word) != std::end(kind_names);
  };
  int iarg = 5;
  while (iarg < narg) {
    const std::string key = arg[iarg++];
    if (key == "region") {
      if (iarg == narg) utils::missing_cmd_args(FLERR, "fix defe/vtk region", error);
      region_id = arg[iarg++];
      if (!domain->get_region_by_id(region_id))
        error->all(FLERR, "Fix defe/vtk region {} does not exist", region_id);
    } else if (is_kind(key)) {
      std::vector<std::string> fields;
      while (iarg < narg && strcmp(arg[iarg], "region") != 0 && !is_kind(arg[iarg]))
        fields.emplace_back(arg[iarg++]);
      add_kind(key, fields);
    } else
      error->all(FLERR, "Unknown fix defe/vtk keyword {}: use elements, spheres, joints or region",
                 key);
  }
  if (!kinds.empty()) return;
  for (const std::string name : kind_names)
    if (name != "joints" || force->pair_match("^defe/", 0)) add_kind(name, {});
}

void FixDefeVTK::add_kind(const std::string &name, const std::vector<std::string> &fields)
{
  for (const auto &k : kinds)
    if (k->name == name) error->all(FLERR, "Fix defe/vtk keyword {} is there twice", name);
  std::unique_ptr<DefeVtkKind> kind;
  if (name == "elements")
    kind = std::make_unique<DefeVtkElements>(name, lmp, this);
  else if (name == "spheres")
    kind = std::make_unique<DefeVtkSpheres>(name, lmp, this);
  else
    kind = std::make_unique<DefeVtkJoints>(name, lmp, this);
  kind->choose(fields);
  kinds.push_back(std::move(kind));
}

/* ---------------------------------------------------------------------- */

int FixDefeVTK::setmask()
{
  return END_OF_STEP;
}

void FixDefeVTK::init()
{
  for (const auto &k : kinds) k->init();
  if (region_id.empty()) return;
  region = domain->get_region_by_id(region_id);
  if (!region) error->all(FLERR, "Fix defe/vtk region {} does not exist", region_id);
}

/* ----------------------------------------------------------------------
   as a dump: the first step of a run too, if its turn has come
------------------------------------------------------------------------- */

void FixDefeVTK::setup(int)
{
  if (update->ntimestep % nevery == 0) write();
}

void FixDefeVTK::end_of_step()
{
  write();
}

void FixDefeVTK::write()
{
  const bigint step = update->ntimestep;
  if (series->has(step)) return;    // the last run ended here
  if (region) region->prematch();
  for (const auto &k : kinds) {
    active = k.get();
    defe::VtkGrid grid;
    k->collect(region, grid);
    const std::string complaint =
        write_vtk_file(series->file(k->name, step), grid, written[k->name], world);
    if (!complaint.empty()) error->all(FLERR, "Fix defe/vtk: {}", complaint);
  }
  series->add(step, update->atime + (step - update->atimestep) * update->dt);
  std::string complaint;
  if (comm->me == 0)
    for (const auto &name : series->kinds())
      if (complaint.empty())
        complaint = defe::replace_file(series->list_file(name), series->list(name));
  stop_by_first_rank(complaint);
}

void FixDefeVTK::stop_by_first_rank(std::string complaint) const
{
  int n = static_cast<int>(complaint.size());
  MPI_Bcast(&n, 1, MPI_INT, 0, world);
  if (n == 0) return;
  complaint.resize(n);
  MPI_Bcast(&complaint[0], n, MPI_CHAR, 0, world);
  error->all(FLERR, "Fix defe/vtk: {}", complaint);
}

/* ----------------------------------------------------------------------
   the steps written so far: what comes after a restart file is written again, and listed once
------------------------------------------------------------------------- */

void FixDefeVTK::write_restart(FILE *fp)
{
  if (comm->me != 0) return;
  const std::string record = series->pack();
  const int size = static_cast<int>(record.size());
  fwrite(&size, sizeof(int), 1, fp);
  fwrite(record.data(), 1, size, fp);
}

void FixDefeVTK::restart(char *buf)
{
  if (!series->unpack(buf) && comm->me == 0)
    error->warning(FLERR,
                   "Fix defe/vtk: the run of the restart file wrote other files than {} of these "
                   "kinds: its steps are not in the new series",
                   base);
}

/* ---------------------------------------------------------------------- */

int FixDefeVTK::pack_forward_comm(int n, int *list, double *buf, int, int *)
{
  return active->pack_forward(n, list, buf);
}

void FixDefeVTK::unpack_forward_comm(int n, int first, double *buf)
{
  active->unpack_forward(n, first, buf);
}

int FixDefeVTK::pack_reverse_comm(int n, int first, double *buf)
{
  return active->pack_reverse(n, first, buf);
}

void FixDefeVTK::unpack_reverse_comm(int n, int *list, double *buf)
{
  active->unpack_reverse(n, list, buf);
}
