/* ----------------------------------------------------------------------
   DEFE: adaptive finite elements to bonded discrete elements for LAMMPS
   https://www.lammps.org/
   This software is distributed under the GNU General Public License.

   Walls for the nodes and DEs of fix defe. The forces are added with those of the elements, before
   LAMMPS collects the forces on ghosts: faces belong to the rank that owns their element.
------------------------------------------------------------------------- */

#include "fix_defe_wall.h"

#include "defe_system.h"

#include "atom.h"
#include "domain.h"
#include "error.h"
#include "modify.h"
#include "neighbor.h"
#include "region.h"
#include "update.h"

#include "defe/coupling/penalty.h"
#include "defe/coupling/wall.h"
#include "defe/fe/hex8.h"
#include "defe/fe/topology.h"

#include <cmath>
#include <cstring>

using namespace LAMMPS_NS;
using namespace FixConst;
using defe::Vec3;

// viscous coefficient of friction where a node or DE hardly slides, in masses per time step, for each
// of its faces; it is stable as long as all together stay below 2
static constexpr double STICK = 0.1;

/* ---------------------------------------------------------------------- */

FixDefeWall::FixDefeWall(LAMMPS *lmp, int narg, char **arg) : Fix(lmp, narg, arg)
{
  scalar_flag = 1;
  vector_flag = 1;
  size_vector = 3;
  global_freq = 1;
  extscalar = 1;
  extvector = 1;
  thermo_energy = 1;
  energy_global_flag = 1;
  thermo_virial = 1;
  virial_global_flag = 1;
  dynamic_group_allow = 1;

  for (int k = 1; k < narg; k++) words += std::string(arg[k]) + " ";

  int iarg = 3;
  auto need = [&](int n, const char *what) {
    if (iarg + n > narg)
      utils::missing_cmd_args(FLERR, std::string("fix defe/wall ") + what, error);
  };
  while (iarg < narg) {
    const std::string key = arg[iarg];
    if (key == "xplane" || key == "yplane" || key == "zplane") {
      need(3, key.c_str());
      const int dim = key[0] - 'x';
      if (domain->periodicity[dim])
        error->all(FLERR, "Fix defe/wall {}: the box is periodic in {}, so a wall has no two sides",
                   key, key[0]);
      double place[2];
      bool given[2];
      for (int k = 0; k < 2; k++) {
        given[k] = strcmp(arg[iarg + 1 + k], "NULL") != 0;
        if (given[k]) place[k] = utils::numeric(FLERR, arg[iarg + 1 + k], false, lmp);
        if (given[k]) planes.push_back({dim, k ? -1.0 : 1.0, place[k]});
      }
      if (!given[0] && !given[1])
        error->all(FLERR, "Fix defe/wall {}: give the place of a lower or an upper wall, or both",
                   key);
      if (given[0] && given[1] && !(place[0] < place[1]))
        error->all(FLERR, "Fix defe/wall {}: the lower wall must be below the upper one, not {} {}",
                   key, arg[iarg + 1], arg[iarg + 2]);
      iarg += 3;
    } else if (key == "region") {
      need(2, "region");
      if (!region_id.empty())
        error->all(FLERR, "Fix defe/wall takes one region: use another fix for another one");
      region_id = arg[iarg + 1];
      iarg += 2;
    } else if (key == "stiffness") {
      need(2, "stiffness");
      factor = utils::numeric(FLERR, arg[iarg + 1], false, lmp);
      if (!(factor > 0.0))
        error->all(FLERR, "Fix defe/wall stiffness factor must be > 0, not {}", arg[iarg + 1]);
      iarg += 2;
    } else if (key == "friction") {
      need(2, "friction");
      friction = utils::numeric(FLERR, arg[iarg + 1], false, lmp);
      if (!(friction >= 0.0))
        error->all(FLERR, "Fix defe/wall friction must be >= 0, not {}", arg[iarg + 1]);
      iarg += 2;
    } else
      error->all(
          FLERR,
          "Unknown fix defe/wall keyword {}: use xplane, yplane, zplane, region, stiffness or "
          "friction",
          key);
  }
  if (planes.empty() && region_id.empty())
    error->all(FLERR, "Fix defe/wall needs a wall: xplane, yplane, zplane or region");
  for (double &s : sums) s = 0.0;
}

/* ---------------------------------------------------------------------- */

int FixDefeWall::setmask()
{
  return PRE_NEIGHBOR | PRE_REVERSE | MIN_PRE_NEIGHBOR | MIN_PRE_REVERSE;
}

/* ---------------------------------------------------------------------- */

void FixDefeWall::init()
{
  sys = nullptr;
  for (auto *ifix : modify->get_fix_list()) {
    if (ifix == this) break;
    if (strcmp(ifix->style, "defe") == 0) sys = DefeSystem::of(ifix);
  }
  if (!sys)
    error->all(
        FLERR,
        "Fix {} defe/wall holds the nodes and DEs of a fix defe, which must be defined before "
        "it",
        id);

  // the stiffness is that of the body, if it is not rigid itself

  stiffest = 0.0;
  for (const auto &p : sys->model.parts)
    if (!sys->model.material_of(p).rigid())
      stiffest = MAX(stiffest, sys->model.material_of(p).elastic().bulk());
  if (!(stiffest > 0.0))
    error->all(
        FLERR,
        "Fix {} defe/wall: all parts are rigid, but the stiffness of the contact is that of a "
        "material: define one in fix {} that is not rigid",
        id, sys->host->id);

  if (!region_id.empty()) {
    region = domain->get_region_by_id(region_id);
    if (!region) error->all(FLERR, "Region {} of fix {} defe/wall does not exist", region_id, id);
    if (region->dynamic || region->varshape)
      error->all(FLERR,
                 "Fix {} defe/wall: region {} moves; this wall stands still, a part of a rigid "
                 "material can move",
                 id, region_id);
    if (region->openflag || region->reglist)
      error->all(FLERR,
                 "Fix {} defe/wall: region {} is {}, so it is not known which side of a face is "
                 "inside: use several fixes with simple closed regions or planes",
                 id, region_id, region->openflag ? "open" : "made of other regions");
  }
}

/* ----------------------------------------------------------------------
   how deep the surface of a sphere (reach 0: a point) is in the wall, in which directions
   A centre that is behind the surface of a region is led back the shortest way.
------------------------------------------------------------------------- */

void FixDefeWall::add_overlap(double depth, const Vec3 &normal)
{
  if (depth > 0.0) overlaps.push_back({depth, normal});
}

void FixDefeWall::find_overlaps(const double *x, double reach)
{
  overlaps.clear();
  for (const auto &p : planes) {
    Vec3 n = Vec3::Zero();
    n[p.dim] = p.side;
    add_overlap(reach - p.side * (x[p.dim] - p.place), n);
  }
  if (!region) return;
  const auto *contact = region->contact;
  if (region->match(x[0], x[1], x[2])) {
    if (!(reach > 0.0)) return;
    const int count = region->surface(x[0], x[1], x[2], reach);
    for (int k = 0; k < count; k++) {
      const Vec3 off(contact[k].delx, contact[k].dely, contact[k].delz);
      if (contact[k].r > 0.0) add_overlap(reach - contact[k].r, off / contact[k].r);
    }
    return;
  }
  double point[3] = {x[0], x[1], x[2]};
  const double far = 2.0 * (domain->xprd + domain->yprd + domain->zprd);
  const int count = region->interior ? region->surface_exterior(point, far)
                                     : region->surface_interior(point, far);
  int nearest = -1;
  for (int k = 0; k < count; k++)
    if (contact[k].r > 0.0 && (nearest < 0 || contact[k].r < contact[nearest].r)) nearest = k;
  if (nearest < 0) return;    // on the surface itself
  const auto &c = contact[nearest];
  add_overlap(reach + c.r, -Vec3(c.delx, c.dely, c.delz) / c.r);
}

/* ----------------------------------------------------------------------
   outer faces of this rank's elements, and its DEs, that are near a wall
------------------------------------------------------------------------- */

void FixDefeWall::pre_neighbor()
{
  faces.clear();
  spheres.clear();
  if (region) region->prematch();
  double **x = atom->x;
  const int *mask = atom->mask;
  const double skin = sys->in_place.slack();

  const auto bulk_of = [&](int part) {
    const auto &m = sys->model.material_of(sys->model.parts[part]);
    return m.rigid() ? stiffest : m.elastic().bulk();
  };

  for (int i = 0; i < atom->nlocal; i++) {
    if (sys->store.de(i)) {
      if (!(mask[i] & groupbit)) continue;
      const auto &r = *sys->store.de(i);
      find_overlaps(x[i], r.outer_distance + skin);
      if (overlaps.empty()) continue;
      const double k = factor * bulk_of(r.part) * 0.5 * r.outer_area * r.outer_area / r.volume;
      spheres.push_back({i, r.outer_distance, k});
      continue;
    }
    for (const auto &h : sys->store.hexes(i)) {
      int idx[8];
      bool known = false;
      for (int f = 0; f < 6; f++) {
        if (h.nb[f] > 0) continue;
        if (!known && !sys->elements.local_hex(h, i, idx))
          break;    // fix defe has stopped the run before
        known = true;
        Face face;
        bool near = false, in_group = true;
        Vec3 reference[4];
        for (int a = 0; a < 4; a++) {
          const int j = face.node[a] = idx[defe::fe::hex_face[f][a]];
          in_group = in_group && (mask[j] & groupbit);
          reference[a] = Vec3(sys->store.x_frame(j));
          find_overlaps(x[j], skin);
          near = near || !overlaps.empty();
        }
        if (!near || !in_group) continue;
        face.k_area = defe::penalty_stiffness_per_area(factor, bulk_of(h.part),
                                                       defe::fe::face_area(reference), h.volume);
        faces.push_back(face);
      }
    }
  }
  if (converting) sys->ledger.conv_strain += energy_before_conversion - energy_now();
  converting = false;
}

/* ---------------------------------------------------------------------- */

void FixDefeWall::pre_reverse(int /*eflag*/, int vflag)
{
  v_init(vflag);
  energy = 0.0;
  for (double &s : sums) s = 0.0;
  summed = false;
  if (region) region->prematch();
  push_faces();
  push_spheres();
  sums[3] = energy;
}

/* ---------------------------------------------------------------------- */

void FixDefeWall::tally(const Vec3 &arm, const Vec3 &force)
{
  for (int k = 0; k < 3; k++) sums[k] -= force[k];
  if (!vflag_global) return;
  const double w[6] = {arm[0] * force[0], arm[1] * force[1], arm[2] * force[2],
                       arm[0] * force[1], arm[0] * force[2], arm[1] * force[2]};
  for (int k = 0; k < 6; k++) virial[k] += w[k];
}

/* ----------------------------------------------------------------------
   each wall on its own, since in a corner a node may be in several: depths of the nodes in the
   wall-th one that each of them is in; false if there is none any more
------------------------------------------------------------------------- */

bool FixDefeWall::depths_of(const Face &face, size_t wall, double *depth, Vec3 *normal)
{
  bool any = false;
  for (int a = 0; a < 4; a++) {
    if (wall == 0) {
      find_overlaps(atom->x[face.node[a]], 0.0);
      of_node[a].swap(overlaps);
    }
    const bool in = wall < of_node[a].size();
    depth[a] = in ? of_node[a][wall].depth : 0.0;
    normal[a] = in ? of_node[a][wall].normal : Vec3(Vec3::Zero());
    any = any || in;
  }
  return any;
}

/* ---------------------------------------------------------------------- */

double FixDefeWall::energy_now()
{
  double sum = 0.0;
  for (const auto &face : faces) {
    Vec3 node[4], normal[4], force[4];
    double depth[4], push[4];
    for (int a = 0; a < 4; a++) node[a] = Vec3(atom->x[face.node[a]]);
    for (size_t wall = 0; depths_of(face, wall, depth, normal); wall++)
      sum += defe::wall_face(node, depth, normal, face.k_area, force, push);
  }
  for (const auto &s : spheres) {
    find_overlaps(atom->x[s.atom], s.reach);
    for (const auto &o : overlaps) sum += 0.5 * s.k * o.depth * o.depth;
  }
  return sum;
}

void FixDefeWall::note_energy()
{
  energy_before_conversion = energy_now();
  converting = true;
}

/* ---------------------------------------------------------------------- */

void FixDefeWall::push_faces()
{
  double **x = atom->x;
  double **v = atom->v;
  double **f = atom->f;
  const bool rubs = friction > 0.0 && update->whichflag == 1;
  const double dt = update->dt;
  for (const auto &face : faces) {
    Vec3 node[4], normal[4], force[4];
    double depth[4], push[4];
    for (int a = 0; a < 4; a++) node[a] = Vec3(x[face.node[a]]);
    for (size_t wall = 0; depths_of(face, wall, depth, normal); wall++) {
      energy += defe::wall_face(node, depth, normal, face.k_area, force, push);
      for (int a = 0; a < 4; a++) {
        const int i = face.node[a];
        if (rubs && push[a] > 0.0) {
          double power;
          force[a] += defe::wall_friction(Vec3(v[i]), normal[a], push[a], friction,
                                          STICK * atom->rmass[i] / dt, power);
          if (!update->setupflag) sys->ledger.friction += power * dt;
        }
        for (int k = 0; k < 3; k++)
          f[i][k] += sys->sums.on_grid(sys->sums.force_grid(), force[a][k], i);
        tally(-depth[a] * normal[a], force[a]);
      }
    }
  }
}

/* ---------------------------------------------------------------------- */

void FixDefeWall::push_spheres()
{
  double **f = atom->f;
  const bool rubs = friction > 0.0 && update->whichflag == 1;
  const double dt = update->dt;
  for (const auto &s : spheres) {
    const int i = s.atom;
    find_overlaps(atom->x[i], s.reach);
    if (overlaps.empty()) continue;
    const bool loose = rubs && sys->store.is_loose(i);
    for (const auto &o : overlaps) {
      const double push = s.k * o.depth;
      energy += 0.5 * push * o.depth;
      Vec3 force = push * o.normal;
      const Vec3 arm = (o.depth - s.reach) * o.normal;    // to the wall
      if (rubs) {
        // a loose one may roll: a push along the surface of a solid sphere meets 2/7 of its mass.
        // Joints do not know the spin of DEs: one that is held slides like a node.
        double c = STICK * atom->rmass[i] / dt, power;
        Vec3 slip(atom->v[i]);
        if (loose) {
          slip += Vec3(atom->omega[i]).cross(arm);
          c /= 3.5;
        }
        const Vec3 drag = defe::wall_friction(slip, o.normal, push, friction, c, power);
        if (loose) {
          const Vec3 moment = arm.cross(drag);
          for (int k = 0; k < 3; k++)
            atom->torque[i][k] += sys->sums.on_grid(sys->sums.torque_grid(), moment[k], i);
        }
        force += drag;
        if (!update->setupflag) sys->ledger.friction += power * dt;
      }
      for (int k = 0; k < 3; k++) f[i][k] += sys->sums.on_grid(sys->sums.force_grid(), force[k], i);
      tally(-arm, force);
    }
  }
}

/* ---------------------------------------------------------------------- */

double FixDefeWall::compute_scalar()
{
  return compute_vector(3);
}

double FixDefeWall::compute_vector(int n)
{
  if (!summed) MPI_Allreduce(sums, sums_all, 4, MPI_DOUBLE, MPI_SUM, world);
  summed = true;
  return sums_all[n];
}

/* ----------------------------------------------------------------------
   fix defe counts this energy among that of contacts
------------------------------------------------------------------------- */

void *FixDefeWall::extract(const char *name, int &dim)
{
  dim = 0;
  if (strcmp(name, "energy") == 0) return &energy;
  return nullptr;
}

/* ---------------------------------------------------------------------- */

double FixDefeWall::memory_usage()
{
  return static_cast<double>(faces.capacity() * sizeof(Face) + spheres.capacity() * sizeof(Sphere));
}
