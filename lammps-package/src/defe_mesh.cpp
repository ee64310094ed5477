/* ----------------------------------------------------------------------
   DEFE: adaptive finite elements to bonded discrete elements for LAMMPS
   https://www.lammps.org/
   This software is distributed under the GNU General Public License.
------------------------------------------------------------------------- */

// Neighbours, masses and checks of new elements. Nothing here is gathered: what an element needs of a node or of
// a neighbour meets it on the rank that its ID is dealt to (a rendezvous).

#include "defe_system.h"
#include "rendezvous.h"

#include "atom.h"
#include "comm.h"
#include "domain.h"
#include "error.h"

#include "defe/coupling/mesh_measure.h"
#include "defe/coupling/shielding.h"
#include "defe/fe/hex8.h"
#include "defe/fe/periodic.h"
#include "defe/fe/topology.h"

#include <algorithm>
#include <cmath>
#include <cstring>

using namespace LAMMPS_NS;
using defe::Vec3;
using defe::fe::HexCoords;
using Rendezvous::Letters;

namespace {

struct NodeDatum {
  double x[3];
  tagint tag;
  int proc, local;
};

struct NodeRequest {
  tagint tag;
  int proc, element, corner;
};

struct NodeReply {
  double x[3];
  int element, corner, found;
};

struct MassShare {
  tagint tag, element;
  double mass;
};

struct MassReply {
  double mass;
  int local, count;
};

struct FaceDatum : defe::fe::ElementFace<tagint> {
  int proc, local, part;
};

struct FaceReply {
  tagint element;
  int local, face, nbface, nbrot, nbpart;
};

// elements per round of messages: what is under way at a time stays small beside the mesh itself
constexpr int CHUNK = 16384;

/** Elements by the rounds in which IDs of theirs have their turn: not all are asked in each. */
class ElementsByRound {
 public:
  /// \param rounds_of  (element, f): f(round) for each of its IDs
  template <class F> ElementsByRound(int n, int rounds, const F &rounds_of) : first(rounds + 1, 0)
  {
    std::vector<int> seen(rounds, -1);
    const auto for_each = [&](const auto &f) {
      std::fill(seen.begin(), seen.end(), -1);
      for (int e = 0; e < n; e++)
        rounds_of(e, [&](int round) {
          if (seen[round] != e) f(e, round);
          seen[round] = e;
        });
    };
    for_each([this](int, int round) {
      first[round + 1]++;
    });
    for (int r = 0; r < rounds; r++) first[r + 1] += first[r];
    element.resize(first.back());
    auto next = first;
    for_each([&](int e, int round) {
      element[next[round]++] = e;
    });
  }
  /// in their order
  const int *begin(int round) const { return element.data() + first[round]; }
  const int *end(int round) const { return element.data() + first[round + 1]; }

 private:
  std::vector<size_t> first;
  std::vector<int> element;
};

tagint lowest_node(const HexRecord &h, int face)
{
  const int *corner = defe::fe::hex_face[face];
  return MIN(MIN(h.node[corner[0]], h.node[corner[1]]), MIN(h.node[corner[2]], h.node[corner[3]]));
}

}    // namespace

/** A mesh that was just made or read. */
struct LAMMPS_NS::DefeMeshDraft {
  std::vector<HexRecord *> hex;    // mine
  std::vector<double> mass;
  std::vector<NodeDatum> nodes;    // those whose IDs are dealt to this rank, sorted
  int rounds = 1;                  // of messages, the same on all ranks

  const NodeDatum *node(tagint tag) const
  {
    const auto found =
        std::lower_bound(nodes.begin(), nodes.end(), tag, [](const NodeDatum &a, tagint t) {
          return a.tag < t;
        });
    return found != nodes.end() && found->tag == tag ? &*found : nullptr;
  }
  /// round in which all that concerns this ID is treated; the nodes of an element have few different ones
  int round_of(tagint id, int nprocs) const
  {
    constexpr int beside = 1024;    // IDs that have the same
    return static_cast<int>(id / nprocs / beside % rounds);
  }
};

DefeMesh::DefeMesh(DefeSystem &system) : DefeComponent(system), de_radius_max(atom->ntypes + 1, 0.0)
{
  now.hexes_per_node = 1;
}

void DefeMesh::add_hex(int i, tagint hexid, int part, const tagint *nodes)
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
  sys.store.hexes(i).push_back(std::move(h));
  hexes_added++;
  dirty = true;
}

bigint DefeMesh::last_hex_id() const
{
  bigint mine = 0, last = 0;
  for (int i = 0; i < atom->nlocal; i++)
    for (const auto &h : sys.store.hexes(i)) mine = MAX(mine, static_cast<bigint>(h.id));
  MPI_Allreduce(&mine, &last, 1, MPI_LMP_BIGINT, MPI_MAX, world);
  return last;
}

/* ----------------------------------------------------------------------
   once after the mesh was made or read
------------------------------------------------------------------------- */

bool DefeMesh::build()
{
  sys.store.end_reading();
  int mine = dirty ? 1 : 0, any = 0;
  MPI_Allreduce(&mine, &any, 1, MPI_INT, MPI_MAX, world);
  sys.hexes_file.require_section();
  if (!any) return false;
  dirty = false;
  sys.notes.mesh_made();
  sys.strengths.mesh_made();
  if (sys.census.des() > 0)
    error->all(FLERR, "Fix defe: all meshes must be made before elements convert");

  DefeMeshDraft mesh;
  collect(mesh);
  make_directory(mesh);
  sys.prestress.mesh_made();
  measure(mesh);
  add_masses(mesh);
  find_neighbours(mesh);
  find_tied(mesh);
  check_splits(mesh);
  sys.hexes_file.check_orphans();
  sys.ids.begin();
  sys.elements.forget_kernels();
  for (auto *h : mesh.hex) h->kernel = -1;

  tell();
  return true;
}

void DefeMesh::tell() const
{
  if (comm->me) return;
  utils::logmesg(lmp,
                 "Fix defe: {} hexahedra, stable time step {:.6g} (finite), {:.6g} (discrete)\n",
                 sys.census.elements(), now.dt_finite, now.dt_discrete);
  for (const auto &p : sys.model.parts) {
    if (p.elements == 0) continue;
    const auto &law = *sys.model.material_of(p).law;
    const std::string choice = law.elements();
    utils::logmesg(lmp, "  part {}: {} {} element{}\n", p.name, p.elements,
                   law.rigid()          ? "rigid"
                       : choice.empty() ? "F-bar"
                                        : choice,
                   p.elements == 1 ? "" : "s");
  }
  for (int k = 0; k < 3; k++)
    if (now.closed[k] != 0.0)
      utils::logmesg(lmp, "  closed with itself across the periodic border in {}\n", "xyz"[k]);
}

void DefeMesh::collect(DefeMeshDraft &mesh)
{
  int most = 1, most_of_all = 1;
  for (int i = 0; i < atom->nlocal; i++) {
    most = MAX(most, static_cast<int>(sys.store.hexes(i).size()));
    for (auto &h : sys.store.hexes(i)) mesh.hex.push_back(&h);
  }
  MPI_Allreduce(&most, &most_of_all, 1, MPI_INT, MPI_MAX, world);
  now.hexes_per_node = most_of_all;
  const bigint count = static_cast<bigint>(mesh.hex.size());
  bigint made = 0, total = 0;
  MPI_Allreduce(&hexes_added, &made, 1, MPI_LMP_BIGINT, MPI_SUM, world);
  made += sys.census.elements();
  hexes_added = 0;
  MPI_Allreduce(&count, &total, 1, MPI_LMP_BIGINT, MPI_SUM, world);
  sys.census.set_elements(total);
  if (total < made && comm->me == 0)
    error->warning(FLERR,
                   "{} of {} elements have gone since they were made: their first nodes were "
                   "deleted",
                   made - total, made);
  const int rounds = static_cast<int>(count / CHUNK) + 1;
  MPI_Allreduce(&rounds, &mesh.rounds, 1, MPI_INT, MPI_MAX, world);
}

/* ----------------------------------------------------------------------
   IDs are unique; each node is known to the rank that its ID is assigned to (rendezvous)
------------------------------------------------------------------------- */

void DefeMesh::make_directory(DefeMeshDraft &mesh)
{
  // no element ID twice: those of their DEs follow from them

  {
    Letters<tagint> ids(lmp);
    for (const auto *h : mesh.hex) ids.to_id(h->id, h->id);
    auto came = ids.send();
    std::sort(came.begin(), came.end());
    const auto twice = std::adjacent_find(came.begin(), came.end());
    if (twice != came.end())
      error->one(FLERR, "Element ID {} is used twice: element IDs must be unique", *twice);
  }

  Letters<NodeDatum> nodes(lmp);
  for (int i = 0; i < atom->nlocal; i++) {
    const double *X = sys.store.x_ref(i);
    nodes.to_id(atom->tag[i], {{X[0], X[1], X[2]}, atom->tag[i], comm->me, i});
  }
  mesh.nodes = nodes.send();
  std::sort(mesh.nodes.begin(), mesh.nodes.end(), [](const NodeDatum &a, const NodeDatum &b) {
    return a.tag < b.tag;
  });
  for (size_t k = 1; k < mesh.nodes.size(); k++) {
    const auto &a = mesh.nodes[k - 1];
    const auto &b = mesh.nodes[k];
    if (a.tag == b.tag)
      error->one(FLERR,
                 "Atom ID {} is used twice, at {:.8g} {:.8g} {:.8g} and {:.8g} {:.8g} {:.8g}: IDs "
                 "of nodes must be unique",
                 b.tag, a.x[0], a.x[1], a.x[2], b.x[0], b.x[1], b.x[2]);
  }
}

/* ----------------------------------------------------------------------
   reference positions of each element's nodes: checks, masses, stable steps, sizes
------------------------------------------------------------------------- */

void DefeMesh::measure(DefeMeshDraft &mesh)
{
  const int n = static_cast<int>(mesh.hex.size());
  mesh.mass.resize(n);
  std::vector<defe::MeshMeasure::Part> kinds;
  for (const auto &p : sys.model.parts)
    kinds.push_back({sys.model.material_of(p).law.get(), p.convertible, p.type, p.split});
  defe::MeshMeasure measure(kinds, atom->ntypes, sys.model.reproducible);
  bigint suspicious = 0, all_suspicious = 0;
  unsigned closed = 0, all_closed = 0;
  const Vec3 period = periods();
  std::vector<HexCoords> coords;
  for (int round = 0; round < mesh.rounds; round++) {
    const int first = MIN(n, round * CHUNK), last = MIN(n, first + CHUNK);
    find_coordinates(mesh, first, last, coords);
    for (int e = first; e < last; e++) {
      HexRecord &h = *mesh.hex[e];
      HexCoords &X = coords[e - first];
      closed |= defe::fe::join_across_border(X, period);
      if (!check_element(h, X)) suspicious++;
      h.volume = defe::fe::volume(X);
      mesh.mass[e] = sys.model.element_mass(sys.model.parts[h.part], h.volume);
      measure.add(h.part, X, h.volume, mesh.mass[e]);
    }
  }
  MPI_Allreduce(&suspicious, &all_suspicious, 1, MPI_LMP_BIGINT, MPI_SUM, world);
  if (all_suspicious && comm->me == 0)
    error->warning(FLERR,
                   "{} elements have a non-positive Jacobian at a corner (positive at all Gauss "
                   "points): they are used, but the mesh is poor there",
                   all_suspicious);
  MPI_Allreduce(&closed, &all_closed, 1, MPI_UNSIGNED, MPI_BOR, world);
  for (int k = 0; k < 3; k++) now.closed[k] = all_closed >> k & 1u ? period[k] : 0.0;
  reduce(measure);
  sum_up_parts(mesh, measure);
}

void DefeMesh::find_coordinates(const DefeMeshDraft &mesh, int first, int last,
                                std::vector<HexCoords> &coords) const
{
  Letters<NodeRequest> requests(lmp);
  for (int e = first; e < last; e++)
    for (int a = 0; a < 8; a++)
      requests.to_id(mesh.hex[e]->node[a], {mesh.hex[e]->node[a], comm->me, e, a});
  Letters<NodeReply> replies(lmp);
  for (const auto &r : requests.send()) {
    NodeReply reply{{0.0, 0.0, 0.0}, r.element, r.corner, 0};
    if (const NodeDatum *node = mesh.node(r.tag)) {
      reply.found = 1;
      for (int k = 0; k < 3; k++) reply.x[k] = node->x[k];
    }
    replies.to_rank(r.proc, reply);
  }
  coords.resize(last - first);
  for (const auto &r : replies.send()) {
    const HexRecord &h = *mesh.hex[r.element];
    if (!r.found)
      error->one(FLERR, "Element {} of part {}: its node {} (number {} of 8) does not exist", h.id,
                 sys.model.parts[h.part].name, h.node[r.corner], r.corner + 1);
    for (int k = 0; k < 3; k++) coords[r.element - first](k, r.corner) = r.x[k];
  }
}

/* ----------------------------------------------------------------------
   false: the mesh can be used, but looks wrong
------------------------------------------------------------------------- */

bool DefeMesh::check_element(const HexRecord &h, const HexCoords &X) const
{
  const DefePart &p = sys.model.parts[h.part];
  for (int a = 1; a < 8; a++)
    for (int b = 0; b < a; b++)
      if (h.node[a] == h.node[b])
        error->one(FLERR,
                   "Element {} of part {} has node {} twice: wedges and tetrahedra written as "
                   "hexahedra are not supported",
                   h.id, p.name, h.node[a]);
  for (int k = 0; k < 3; k++) {
    const char axis = "xyz"[k];
    const double extent = X.row(k).maxCoeff() - X.row(k).minCoeff();
    if (domain->periodicity[k] && extent > 0.5 * domain->prd[k])
      error->one(
          FLERR,
          "Element {} of part {} is {:.6g} long in {}, more than half of the periodic box "
          "({:.6g}): make the box larger, or give the nodes' image flags in the data file; a "
          "mesh that is closed with itself needs four elements from border to border",
          h.id, p.name, extent, axis, domain->prd[k]);
  }
  const auto check = defe::fe::check_hex(X);
  if (check.verdict == defe::fe::HexCheck::bad)
    error->one(FLERR, "Part {}: {}; the node order must be that of Abaqus C3D8", p.name,
               defe::fe::describe_bad_hex(h.id, X, check));
  if (check.verdict == defe::fe::HexCheck::suspicious && p.convertible)
    for (const auto &size : defe::place_sizes(X, p.split))
      if (!(size.volume > 0.0))
        error->one(FLERR,
                   "Part {}: {}; at that corner a DE would have no volume: mend the mesh there, or "
                   "do not let that part convert",
                   p.name, defe::fe::describe_bad_hex(h.id, X, check));
  return check.verdict != defe::fe::HexCheck::suspicious;
}

/* ----------------------------------------------------------------------
   of all ranks
------------------------------------------------------------------------- */

void DefeMesh::reduce(const defe::MeshMeasure &measure)
{
  const auto &sizes = measure.sizes();
  const auto &steps = measure.steps();
  const double least[4] = {steps.elements, steps.des, steps.joints, sizes.shortest_edge};
  const double most[3] = {sizes.diagonal, sizes.face_diagonal, sizes.largest_force};
  double least_of_all[4], most_of_all[3];
  MPI_Allreduce(least, least_of_all, 4, MPI_DOUBLE, MPI_MIN, world);
  MPI_Allreduce(most, most_of_all, 3, MPI_DOUBLE, MPI_MAX, world);
  for (int k = 0; k < 3; k++)
    if (least_of_all[k] >= 1.0e300) least_of_all[k] = 0.0;
  const double smaller = sys.prestress.step_factor();
  now.dt_finite = smaller * least_of_all[0];
  now.dt_discrete = smaller * least_of_all[1];
  now.dt_joints = smaller * least_of_all[2];
  now.max_step_length = 0.25 * least_of_all[3];
  now.max_diagonal = most_of_all[0];
  now.max_facet = most_of_all[1];
  now.largest_force = most_of_all[2];
  MPI_Allreduce(measure.de_radius().data(), de_radius_max.data(),
                static_cast<int>(de_radius_max.size()), MPI_DOUBLE, MPI_MAX, world);
}

void DefeMesh::sum_up_parts(const DefeMeshDraft &mesh, const defe::MeshMeasure &measure)
{
  const auto &mine = measure.part_sums();
  std::vector<defe::MeshMeasure::PartSums> all(mine.size());
  static_assert(sizeof(all[0]) == 3 * sizeof(double), "three doubles");
  MPI_Allreduce(&mine[0].size, &all[0].size, 3 * static_cast<int>(mine.size()), MPI_DOUBLE, MPI_SUM,
                world);
  for (size_t p = 0; p < sys.model.parts.size(); p++) {
    const auto &m = sys.model.material_of(sys.model.parts[p]);
    sys.model.parts[p].elements = static_cast<bigint>(all[p].number);
    sys.model.parts[p].slender = static_cast<bigint>(all[p].slender);
    if (m.rigid() || all[p].number == 0.0) continue;
    const double mean = sys.model.reproducible ? mean_size(mesh.hex, static_cast<int>(p))
                                               : all[p].size / all[p].number;
    sys.model.parts[p].shield_time =
        defe::shielding_time(mean, m.elastic().lambda(), m.elastic().mu(), m.elastic().rho);
  }
}

/* ----------------------------------------------------------------------
   node masses, summed in the order of element IDs: the same on any number of ranks
------------------------------------------------------------------------- */

void DefeMesh::add_masses(const DefeMeshDraft &mesh)
{
  const int nprocs = comm->nprocs, nlocal = atom->nlocal;
  const int n = static_cast<int>(mesh.hex.size());
  for (int i = 0; i < nlocal; i++) sys.store.set_elements_at(i, 0);

  const ElementsByRound elements(n, mesh.rounds, [&](int e, const auto &f) {
    for (tagint t : mesh.hex[e]->node) f(mesh.round_of(t, nprocs));
  });
  for (int round = 0; round < mesh.rounds; round++) {
    Letters<MassShare> shares(lmp);
    for (const int *e = elements.begin(round); e < elements.end(round); e++)
      for (tagint t : mesh.hex[*e]->node)
        if (mesh.round_of(t, nprocs) == round)
          shares.to_id(t, {t, mesh.hex[*e]->id, 0.125 * mesh.mass[*e]});
    auto came = shares.send();
    std::sort(came.begin(), came.end(), [](const MassShare &a, const MassShare &b) {
      return a.tag != b.tag ? a.tag < b.tag : a.element < b.element;
    });
    Letters<MassReply> replies(lmp);
    for (size_t k = 0; k < came.size();) {
      const NodeDatum &node = *mesh.node(came[k].tag);
      MassReply reply{0.0, node.local, 0};
      for (; k < came.size() && came[k].tag == node.tag; k++) {
        if (sys.model.reproducible && !defe::adds_exactly(reply.mass, came[k].mass))
          error->one(FLERR,
                     "Fix defe reproducible: elements at node {} have masses that differ too much "
                     "to be summed exactly (by more than 10^4): make their sizes more alike, or "
                     "do without reproducible",
                     node.tag);
        reply.mass += came[k].mass;
        reply.count++;
      }
      replies.to_rank(node.proc, reply);
    }
    for (const auto &r : replies.send()) {
      sys.store.set_elements_at(r.local, r.count);
      atom->rmass[r.local] = r.mass;
      if (atom->radius[r.local] != 0.0)
        error->one(FLERR, "Node {} of the mesh has radius {}: nodes are spheres of radius 0",
                   atom->tag[r.local], atom->radius[r.local]);
    }
  }
  sys.census.weigh_nodes();
}

/* ----------------------------------------------------------------------
   what is behind each face: the two elements of a face meet on the rank of its lowest node ID
------------------------------------------------------------------------- */

void DefeMesh::find_neighbours(const DefeMeshDraft &mesh)
{
  const int nprocs = comm->nprocs;
  const int n = static_cast<int>(mesh.hex.size());
  for (auto *h : mesh.hex)
    for (tagint &nb : h->nb) nb = 0;

  const ElementsByRound elements(n, mesh.rounds, [&](int e, const auto &its) {
    for (int f = 0; f < 6; f++) its(mesh.round_of(lowest_node(*mesh.hex[e], f), nprocs));
  });
  for (int round = 0; round < mesh.rounds; round++) {
    Letters<FaceDatum> faces(lmp);
    for (const int *e = elements.begin(round); e < elements.end(round); e++)
      for (int f = 0; f < 6; f++) {
        const HexRecord &h = *mesh.hex[*e];
        const tagint lowest = lowest_node(h, f);
        if (mesh.round_of(lowest, nprocs) != round) continue;
        faces.to_id(lowest, {{h.node, f, h.id}, comm->me, *e, h.part});
      }
    auto came = faces.send();
    Letters<FaceReply> replies(lmp);
    const auto complaint =
        defe::fe::match_faces(came, [&](const FaceDatum &me, const FaceDatum &other, int rotation) {
          replies.to_rank(me.proc,
                          {other.element, me.local, me.face, other.face, rotation, other.part});
        });
    if (!complaint.empty()) error->one(FLERR, complaint);
    for (const auto &r : replies.send()) {
      HexRecord &h = *mesh.hex[r.local];
      h.nb[r.face] = r.element;
      h.nbface[r.face] = static_cast<signed char>(r.nbface);
      h.nbrot[r.face] = static_cast<signed char>(r.nbrot);
      h.nbpart[r.face] = static_cast<signed char>(r.nbpart);
    }
  }
}

/* ----------------------------------------------------------------------
   surfaces that are glued
------------------------------------------------------------------------- */

void DefeMesh::find_tied(const DefeMeshDraft &mesh)
{
  if (!sys.tied.on()) return;
  sys.tied.begin_mesh();
  const int n = static_cast<int>(mesh.hex.size());
  std::vector<int> atom_of;    // that has the element: in the order of collect()
  for (int i = 0; i < atom->nlocal; i++)
    atom_of.insert(atom_of.end(), sys.store.hexes(i).size(), i);
  std::vector<HexCoords> coords;
  for (int round = 0; round < mesh.rounds; round++) {
    const int first = MIN(n, round * CHUNK), last = MIN(n, first + CHUNK);
    find_coordinates(mesh, first, last, coords);
    for (int e = first; e < last; e++) sys.tied.show(atom_of[e], *mesh.hex[e], coords[e - first]);
  }
  const double step = sys.prestress.step_factor() * sys.tied.find();
  if (step < now.dt_finite || now.dt_finite == 0.0) now.dt_finite = step;
}

/* ----------------------------------------------------------------------
   DEs on both sides of a face must match one to one; collective
------------------------------------------------------------------------- */

void DefeMesh::check_splits(const DefeMeshDraft &mesh) const
{
  const auto &parts = sys.model.parts;
  const int none = static_cast<int>(parts.size() * parts.size());
  int mine = none, first = none;
  for (const auto *h : mesh.hex)
    for (int f = 0; f < 6; f++) {
      const int other = h->nbpart[f];
      if (h->nb[f] == 0 || parts[h->part].split == parts[other].split) continue;
      if (parts[h->part].convertible && parts[other].convertible)
        mine =
            MIN(mine, MIN(h->part, other) * static_cast<int>(parts.size()) + MAX(h->part, other));
    }
  MPI_Allreduce(&mine, &first, 1, MPI_INT, MPI_MIN, world);
  if (first == none) return;
  const DefePart &a = parts[first / parts.size()], &b = parts[first % parts.size()];
  error->all(FLERR,
             "Fix defe convert: parts {} (split {}) and {} (split {}) have faces in common, where "
             "their DEs would not meet one to one: give both the same split, or do not let one of "
             "them convert",
             a.name, a.split.along(), b.name, b.split.along());
}

/* ----------------------------------------------------------------------
   largest radius of a DE of this type that a conversion can create
------------------------------------------------------------------------- */

double DefeMesh::max_de_radius(int type) const
{
  return (type >= 0 && type < static_cast<int>(de_radius_max.size())) ? de_radius_max[type] : 0.0;
}

/* ----------------------------------------------------------------------
   mean size of the elements of a part, to 1e-8; collective
------------------------------------------------------------------------- */

double DefeMesh::mean_size(const std::vector<HexRecord *> &mine, int part) const
{
  const double quantum = std::ldexp(1.0, std::ilogb(now.max_diagonal) - 26);
  bigint sum[2] = {0, 0}, all[2];
  for (const auto *h : mine) {
    if (h->part != part) continue;
    sum[0] += std::llround(std::cbrt(h->volume) / quantum);
    sum[1]++;
  }
  MPI_Allreduce(sum, all, 2, MPI_LMP_BIGINT, MPI_SUM, world);
  return quantum * static_cast<double>(all[0]) / static_cast<double>(all[1]);
}

void *DefeMesh::extract(const char *name)
{
  if (strcmp(name, "dt_finite") == 0) return &now.dt_finite;
  if (strcmp(name, "dt_discrete") == 0) return &now.dt_discrete;
  return nullptr;
}

/* ----------------------------------------------------------------------
   reference positions of the nodes stay when the box is strained: over the border of a closed mesh they would no longer fit
------------------------------------------------------------------------- */

Vec3 DefeMesh::periods() const
{
  Vec3 period;
  for (int k = 0; k < 3; k++) period[k] = domain->periodicity[k] ? domain->prd[k] : HUGE_VAL;
  return period;
}

void DefeMesh::check_closed() const
{
  for (int k = 0; k < 3; k++) {
    const double period = domain->periodicity[k] ? domain->prd[k] : 0.0;
    if (now.closed[k] != 0.0 && std::abs(period - now.closed[k]) > 1.0e-12 * now.closed[k])
      error->all(
          FLERR,
          "Fix defe: the mesh is closed with itself across the periodic border in {0}, {1:.8g} "
          "from border to border, and the box is {2} there now: a box that is strained, or "
          "no longer periodic, needs a mesh that is not closed (do without change_box, fix "
          "deform and fix nph in {0})",
          "xyz"[k], now.closed[k], period == 0.0 ? "not periodic" : fmt::format("{:.8g}", period));
  }
}

void DefeMesh::unpack(const State &s)
{
  now = s;
  dirty = false;
}
