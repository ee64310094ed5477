/* ----------------------------------------------------------------------
   DEFE: adaptive finite elements to bonded discrete elements for LAMMPS
   https://www.lammps.org/
   This software is distributed under the GNU General Public License.
------------------------------------------------------------------------- */

#include "defe_vtk_kinds.h"

#include "defe_system.h"

#include "atom.h"
#include "comm.h"
#include "compute.h"
#include "domain.h"
#include "error.h"
#include "fix.h"
#include "group.h"
#include "modify.h"
#include "region.h"
#include "update.h"

#include <algorithm>
#include <tuple>

using namespace LAMMPS_NS;
using defe::VtkGrid;

/* ---------------------------------------------------------------------- */

DefeVtkKind::DefeVtkKind(const std::string &name, LAMMPS *lmp, Fix *host) :
    Pointers(lmp), name(name), host(host), sys(DefeSystem::find(lmp))
{
}

void DefeVtkKind::choose(const std::vector<std::string> &names)
{
  const auto &materials = sys->model.materials;
  const bool flaws = sys->strengths.on();
  const bool metals = std::any_of(materials.begin(), materials.end(), [](const DefeMaterial &m) {
    return m.law->yields();
  });
  const auto &all = fields();
  if (names.empty())
    for (size_t k = 0; k < all.size(); k++)
      if ((flaws || !all[k].needs_flaws) && (metals || !all[k].needs_metal))
        chosen.push_back(static_cast<int>(k));
  for (const auto &word : names) {
    const auto found = std::find_if(all.begin(), all.end(), [&word](const Field &f) {
      return word == f.name;
    });
    if (found == all.end()) {
      std::string list;
      for (const auto &f : all) list += std::string(list.empty() ? "" : ", ") + f.name;
      error->all(FLERR, "Unknown fix defe/vtk value {} of {}: use some of {}", word, name, list);
    }
    if (found->needs_flaws && !flaws)
      error->all(FLERR, "Fix defe/vtk {} {} needs the keyword strength of fix defe", name, word);
    if (found->needs_metal && !metals)
      error->all(FLERR,
                 "Fix defe/vtk {} {} needs a part of the law plastic or johnson-cook in fix defe",
                 name, word);
    const int k = static_cast<int>(found - all.begin());
    if (has(k)) error->all(FLERR, "Fix defe/vtk {} {} is there twice", name, word);
    chosen.push_back(k);
  }
}

bool DefeVtkKind::has(int field) const
{
  return std::find(chosen.begin(), chosen.end(), field) != chosen.end();
}

void DefeVtkKind::add_compute(const std::string &group_name, const std::string &text)
{
  compute_ids.push_back(std::string(host->id) + "_" + name + std::to_string(compute_ids.size()));
  modify->add_compute(compute_ids.back() + " " + group_name + " " + text);
}

void DefeVtkKind::delete_computes()
{
  for (const auto &id : compute_ids)
    if (modify->get_compute_by_id(id)) modify->delete_compute(id);
}

void DefeVtkKind::init()
{
  sys = DefeSystem::find(lmp);
  if (!sys) error->all(FLERR, "Fix defe/vtk needs a fix defe");
  computes.clear();
  for (const auto &id : compute_ids) {
    auto *found = modify->get_compute_by_id(id);
    if (!found)
      error->all(FLERR,
                 "Fix {} defe/vtk: its compute {} was deleted: define the fix again, or leave out "
                 "the uncompute command",
                 host->id, id);
    computes.push_back(found);
  }
}

void DefeVtkKind::sort_by_tag(std::vector<int> &atoms) const
{
  const auto *tag = atom->tag;
  std::sort(atoms.begin(), atoms.end(), [tag](int i, int j) {
    return tag[i] < tag[j];
  });
}

bigint DefeVtkKind::before_me(size_t mine) const
{
  const auto n = static_cast<bigint>(mine);
  bigint sum;
  MPI_Scan(&n, &sum, 1, MPI_LMP_BIGINT, MPI_SUM, world);
  return sum - n;
}

int DefeVtkKind::pack_forward(int, const int *, double *)
{
  return 0;
}
void DefeVtkKind::unpack_forward(int, int, const double *) {}
int DefeVtkKind::pack_reverse(int, int, double *)
{
  return 0;
}
void DefeVtkKind::unpack_reverse(int, const int *, const double *) {}

/* ----------------------------------------------------------------------
   elements
------------------------------------------------------------------------- */

const std::vector<DefeVtkKind::Field> &DefeVtkElements::fields() const
{
  static const std::vector<Field> all = {{"id", 1, true, false},
                                         {"part", 1, true, false},
                                         {"stress", 6, false, false},
                                         {"s1", 1, false, false},
                                         {"vonmises", 1, false, false},
                                         {"strength", 1, false, true},
                                         {"plastic", 1, false, false, true},
                                         {"node", 1, true, false},
                                         {"velocity", 3, false, false},
                                         {"displacement", 3, false, false}};
  return all;
}

void DefeVtkElements::add_computes()
{
  add_compute(group->names[host->igroup],
              "defe/hex/local x y z id part sxx syy szz sxy sxz syz s1 vonmises" +
                  std::string(has(STRENGTH) ? " strength" : "") +
                  std::string(has(PLASTIC) ? " plastic" : ""));
}

/* ----------------------------------------------------------------------
   elements of this rank that are written, by their ID: the order of atoms changes, and what stays as it was
   is not written again
------------------------------------------------------------------------- */

void DefeVtkElements::find_hexes(Region *region)
{
  const auto *rows = compute(0).array_local;
  hexes.clear();
  used.assign(atom->nlocal + atom->nghost, 0);
  int row = -1;
  for (int i = 0; i < atom->nlocal; i++) {
    if (!(atom->mask[i] & host->groupbit)) continue;
    for (const auto &h : sys->store.hexes(i)) {
      row++;
      if (region && !region->match(rows[row][0], rows[row][1], rows[row][2])) continue;
      Hex hex;
      hex.id = h.id;
      hex.row = row;
      if (!sys->elements.local_hex(h, i, hex.node.data()))
        error->one(FLERR, "Fix defe/vtk: a node of element {} is missing at step {}: it was lost",
                   h.id, update->ntimestep);
      for (int a : hex.node) used[a] = 1;
      hexes.push_back(hex);
    }
  }
  std::sort(hexes.begin(), hexes.end(), [](const Hex &a, const Hex &b) {
    return a.id < b.id;
  });
}

/* ----------------------------------------------------------------------
   a node is a point of the rank that owns it, whose number in the file the others get to know
------------------------------------------------------------------------- */

void DefeVtkElements::add_nodes(VtkGrid &grid)
{
  comm->reverse_comm(host);
  number.assign(atom->nlocal + atom->nghost, -1);
  std::vector<int> mine;
  for (int i = 0; i < atom->nlocal; i++)
    if (used[i]) mine.push_back(i);
  sort_by_tag(mine);
  for (int i : mine) {
    number[i] = static_cast<bigint>(grid.npoints());
    add_node(i, grid);
  }
  const bigint before = before_me(grid.npoints());
  for (int i : mine) number[i] += before;
  comm->forward_comm(host);
}

/* ----------------------------------------------------------------------
   its position is not wrapped, so that elements across a periodic boundary keep their shape
------------------------------------------------------------------------- */

void DefeVtkElements::add_node(int i, VtkGrid &grid) const
{
  double x[3], u[3];
  domain->unmap(atom->x[i], atom->image[i], x);
  for (int k = 0; k < 3; k++) u[k] = atom->x[i][k] - sys->store.x_frame(i)[k];
  grid.add_point(x);
  auto field = grid.point_fields.begin();
  for (int c : chosen) {
    if (c < CELLS) continue;
    if (c == NODE)
      field->add(static_cast<double>(atom->tag[i]));
    else
      field->add(c == VELOCITY ? atom->v[i] : u);
    ++field;
  }
}

void DefeVtkElements::add_hex(const double *row, VtkGrid &grid) const
{
  const int column[CELLS] = {3, 4, 5, 11, 12, 13, has(STRENGTH) ? 14 : 13};
  auto field = grid.cell_fields.begin();
  for (int c : chosen) {
    if (c >= CELLS) continue;
    if (c == STRESS) {
      double tensor[6];
      defe::vtk_tensor(row + column[c], tensor);
      field->add(tensor);
    } else
      field->add(row[column[c]]);
    ++field;
  }
}

void DefeVtkElements::collect(Region *region, VtkGrid &grid)
{
  for (int c : chosen) {
    const auto &f = fields()[c];
    (c < CELLS ? grid.cell_fields : grid.point_fields).emplace_back(f.name, f.components, f.whole);
  }
  compute(0).compute_local();
  const auto *rows = compute(0).array_local;
  find_hexes(region);
  add_nodes(grid);
  for (const auto &hex : hexes) {
    std::int64_t point[8];
    for (int a = 0; a < 8; a++) point[a] = number[hex.node[a]];
    grid.add_cell(VtkGrid::HEXAHEDRON, point);
    add_hex(rows[hex.row], grid);
  }
}

int DefeVtkElements::pack_forward(int n, const int *list, double *buf)
{
  for (int k = 0; k < n; k++) buf[k] = static_cast<double>(number[list[k]]);
  return n;
}

void DefeVtkElements::unpack_forward(int n, int first, const double *buf)
{
  for (int k = 0; k < n; k++) number[first + k] = static_cast<bigint>(buf[k]);
}

int DefeVtkElements::pack_reverse(int n, int first, double *buf)
{
  for (int k = 0; k < n; k++) buf[k] = used[first + k];
  return n;
}

void DefeVtkElements::unpack_reverse(int n, const int *list, const double *buf)
{
  for (int k = 0; k < n; k++)
    if (buf[k] != 0.0) used[list[k]] = 1;
}

/* ----------------------------------------------------------------------
   spheres
------------------------------------------------------------------------- */

const std::vector<DefeVtkKind::Field> &DefeVtkSpheres::fields() const
{
  static const std::vector<Field> all = {
      {"id", 1, true, false},       {"type", 1, true, false},      {"part", 1, true, false},
      {"element", 1, true, false},  {"radius", 1, false, false},   {"damage", 1, false, false},
      {"fragment", 1, true, false}, {"velocity", 3, false, false}, {"omega", 3, false, false},
      {"strength", 1, false, true}};
  return all;
}

void DefeVtkSpheres::add_computes()
{
  add_compute("all", "defe/atom damage element" + std::string(has(STRENGTH) ? " strength" : ""));
  if (has(FRAGMENT)) add_compute("all", "defe/fragment/atom");
}

void DefeVtkSpheres::add_values(int i, VtkGrid &grid) const
{
  const auto *de = sys->store.de(i);
  auto field = grid.point_fields.begin();
  for (int c : chosen) {
    auto &f = *field++;
    switch (c) {
      case ID:
        f.add(static_cast<double>(atom->tag[i]));
        break;
      case TYPE:
        f.add(atom->type[i]);
        break;
      case PART:
        f.add(de ? de->part + 1 : 0);
        break;
      case ELEMENT:
        f.add(compute(0).array_atom[i][1]);
        break;
      case RADIUS:
        f.add(atom->radius[i]);
        break;
      case DAMAGE:
        f.add(compute(0).array_atom[i][0]);
        break;
      case FRAGMENT:
        f.add(compute(1).vector_atom[i]);
        break;
      case VELOCITY:
        f.add(atom->v[i]);
        break;
      case OMEGA:
        f.add(atom->omega[i]);
        break;
      case STRENGTH:
        f.add(compute(0).array_atom[i][2]);
        break;
    }
  }
}

void DefeVtkSpheres::collect(Region *region, VtkGrid &grid)
{
  for (int c : chosen) {
    const auto &f = fields()[c];
    grid.point_fields.emplace_back(f.name, f.components, f.whole);
  }
  compute(0).compute_peratom();
  if (has(FRAGMENT)) compute(1).compute_peratom();
  std::vector<int> mine;
  for (int i = 0; i < atom->nlocal; i++) {
    const double *x = atom->x[i];
    if (!(atom->mask[i] & host->groupbit) || atom->radius[i] == 0.0) continue;
    if (!region || region->match(x[0], x[1], x[2])) mine.push_back(i);
  }
  sort_by_tag(mine);
  for (int i : mine) {
    double whole[3];
    domain->unmap(atom->x[i], atom->image[i], whole);
    grid.add_point(whole);
    add_values(i, grid);
  }
  std::int64_t point = before_me(grid.npoints());
  for (size_t k = 0; k < grid.npoints(); k++, point++) grid.add_cell(VtkGrid::VERTEX, &point);
}

/* ----------------------------------------------------------------------
   joints
------------------------------------------------------------------------- */

const std::vector<DefeVtkKind::Field> &DefeVtkJoints::fields() const
{
  static const std::vector<Field> all = {
      {"id1", 1, true, false},      {"id2", 1, true, false},   {"kind", 1, true, false},
      {"state", 1, true, false},    {"part", 1, true, false},  {"damage", 1, false, false},
      {"opening", 1, false, false}, {"slip", 1, false, false}, {"tn", 1, false, false},
      {"ts", 1, false, false},      {"area", 1, false, false}, {"length", 1, false, false}};
  return all;
}

void DefeVtkJoints::add_computes()
{
  std::string text = "defe/joint/local x y z";    // and all fields, in their order
  for (const auto &f : fields()) text += std::string(" ") + f.name;
  add_compute(group->names[host->igroup], text);
}

void DefeVtkJoints::collect(Region *region, VtkGrid &grid)
{
  constexpr int FIRST = 3, ID1 = 3, ID2 = 4, KIND = 5;    // columns of the compute
  for (int c : chosen) {
    const auto &f = fields()[c];
    grid.cell_fields.emplace_back(f.name, f.components, f.whole);
  }
  compute(0).compute_local();
  const auto *rows = compute(0).array_local;
  std::vector<const double *> mine;
  for (int r = 0; r < compute(0).size_local_rows; r++)
    if (!region || region->match(rows[r][0], rows[r][1], rows[r][2])) mine.push_back(rows[r]);
  // stable: a surface may tie two faces of a DE to one element
  std::stable_sort(mine.begin(), mine.end(), [](const double *a, const double *b) {
    return std::tie(a[ID1], a[ID2], a[KIND]) < std::tie(b[ID1], b[ID2], b[KIND]);
  });
  for (const double *row : mine) {
    const int i = atom->map(static_cast<tagint>(row[ID1]));
    const double *end = row;    // of a tie and at a tied surface: the point on the face
    if (static_cast<int>(row[KIND]) == DefeJoint::DE)
      end = atom->x[domain->closest_image(i, atom->map(static_cast<tagint>(row[ID2])))];
    double from[3], to[3];
    domain->unmap(atom->x[i], atom->image[i], from);
    for (int k = 0; k < 3; k++) to[k] = from[k] + end[k] - atom->x[i][k];
    grid.add_point(from);
    grid.add_point(to);
    for (size_t k = 0; k < chosen.size(); k++) grid.cell_fields[k].add(row[FIRST + chosen[k]]);
  }
  const bigint before = before_me(grid.npoints());
  for (size_t k = 0; k < grid.npoints(); k += 2) {
    const auto first = before + static_cast<bigint>(k);
    const std::int64_t point[2] = {first, first + 1};
    grid.add_cell(VtkGrid::LINE, point);
  }
}
