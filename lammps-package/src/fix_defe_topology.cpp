/* ----------------------------------------------------------------------
   DEFE: adaptive finite elements to bonded discrete elements for LAMMPS
   https://www.lammps.org/
   This software is distributed under the GNU General Public License.

   The mesh: neighbours, masses and checks of new elements, and the data file.
   Nothing here is gathered: what an element needs of a node or of a neighbour
   meets it on the rank that its ID is dealt to (a rendezvous).
------------------------------------------------------------------------- */

#include "fix_defe.h"

#include "rendezvous.h"

#include "atom.h"
#include "comm.h"
#include "domain.h"
#include "error.h"
#include "text_file_reader.h"
#include "tokenizer.h"
#include "update.h"

#include "defe/coupling/conversion.h"
#include "defe/coupling/shielding.h"
#include "defe/fe/hex8.h"
#include "defe/fe/stable_step.h"

#include <algorithm>
#include <cmath>
#include <cstring>

using namespace LAMMPS_NS;
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

/// Safe step of the eight DEs of an element, of which each may be tied by its three outer faces;
/// the elements at the other ends of the ties have a quarter of their mass left for themselves.
/// \param joints  gets the step of DEs with joints alone: ties hardly change their fastest oscillation, only
///                what can be proven of it
double discrete_step(const HexCoords &X, const defe::fe::IsotropicElastic &elastic, double mass,
                     double &joints)
{
  const defe::CornerModuli moduli{elastic.lambda(), elastic.mu()};
  const auto eight = defe::convert_hex(X, X, HexCoords::Zero(), mass);
  double dt = 0.5 * defe::fe::critical_step(X, elastic);
  joints = HUGE_VAL;
  for (int k = 0; k < 8; k++) {
    auto cell = defe::cell_of(eight, k);
    for (int s = 0; s < 6; s++)
      if (defe::slot_is_outer(k, s)) cell.dX[s] = 2.0 * cell.face[s];
    joints = MIN(joints, defe::lattice_critical_step(cell, 0x3f, moduli, 0.125 * mass));
    dt = MIN(dt, defe::softening_step_share * joints);
    for (int s = 0; s < 6; s++)
      if (defe::slot_is_outer(k, s)) {
        cell.dX[s] = cell.face[s];
        cell.tie |= static_cast<unsigned char>(1 << s);
      }
    dt = MIN(dt, defe::lattice_critical_step(cell, 0x3f, moduli, 0.125 * mass));
  }
  return dt;
}

}    // namespace

struct FixDefe::Mesh {
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
  /// round in which all that concerns this ID is treated
  int round_of(tagint id, int nprocs) const { return static_cast<int>(id / nprocs % rounds); }
};

/* ----------------------------------------------------------------------
   neighbours, node masses, checks; once after the mesh was made or read
------------------------------------------------------------------------- */

void FixDefe::build_topology()
{
  reading = false;
  just_read.clear();
  int mine = mesh_dirty ? 1 : 0, dirty = 0;
  MPI_Allreduce(&mine, &dirty, 1, MPI_INT, MPI_MAX, world);
  require_hex_section();
  if (!dirty) return;
  mesh_dirty = false;
  notes_due = true;
  if (des_total > 0) error->all(FLERR, "Fix defe: all meshes must be made before elements convert");

  Mesh mesh;
  const int nlocal = atom->nlocal;
  int most = 0;
  for (int i = 0; i < nlocal; i++) {
    most = MAX(most, static_cast<int>(hexes[i].size()));
    for (auto &h : hexes[i]) mesh.hex.push_back(&h);
  }
  MPI_Allreduce(&most, &hexes_per_node, 1, MPI_INT, MPI_MAX, world);
  hexes_per_node = MAX(hexes_per_node, 1);
  const bigint count = static_cast<bigint>(mesh.hex.size());
  bigint made = 0;
  MPI_Allreduce(&hexes_added, &made, 1, MPI_LMP_BIGINT, MPI_SUM, world);
  made += hexes_total;
  hexes_added = 0;
  MPI_Allreduce(&count, &hexes_total, 1, MPI_LMP_BIGINT, MPI_SUM, world);
  if (hexes_total < made && comm->me == 0)
    error->warning(FLERR,
                   "{} of {} elements have gone since they were made: their first nodes were "
                   "deleted",
                   made - hexes_total, made);
  const int rounds = static_cast<int>(count / CHUNK) + 1;
  MPI_Allreduce(&rounds, &mesh.rounds, 1, MPI_INT, MPI_MAX, world);

  mesh_directory(mesh);
  mesh_shapes(mesh);
  mesh_masses(mesh);
  mesh_neighbours(mesh);
  if (mesh_from_file) check_orphans();

  // atom IDs of DEs follow those of all atoms, from the IDs of their elements

  tagint last = 0;
  for (int i = 0; i < nlocal; i++) last = MAX(last, atom->tag[i]);
  MPI_Allreduce(&last, &de_base, 1, MPI_LMP_TAGINT, MPI_MAX, world);
  last_element = static_cast<tagint>(last_hex_id());
  last_id = de_base;
  last_born = 0;
  lots_moved = false;
  const bigint last_de = static_cast<bigint>(de_base) + 8 * static_cast<bigint>(last_element);
  if (last_de > MAXTAGINT)
    error->all(FLERR, "Fix defe needs atom IDs up to {}: compile LAMMPS with -DLAMMPS_BIGBIG",
               last_de);

  kernels.clear();
  batches.clear();
  for (auto *h : mesh.hex) h->kernel = -1;

  if (comm->me == 0)
    utils::logmesg(lmp,
                   "Fix defe: {} hexahedra, stable time step {:.6g} (finite), {:.6g} (discrete)\n",
                   hexes_total, dt_finite, dt_discrete);
}

/* ----------------------------------------------------------------------
   atoms without radius that came with a mesh but belong to none of its elements: nothing would hold
   them, and they would count in masses and energies
------------------------------------------------------------------------- */

void FixDefe::check_orphans()
{
  mesh_from_file = false;
  struct {
    bigint count = 0;
    tagint first = MAXTAGINT;
  } mine, all;
  for (int i = 0; i < atom->nlocal; i++) {
    if (!(atom->mask[i] & groupbit) || atom->radius[i] > 0.0 || nelem[i] > 0) continue;
    mine.count++;
    mine.first = MIN(mine.first, atom->tag[i]);
  }
  MPI_Allreduce(&mine.count, &all.count, 1, MPI_LMP_BIGINT, MPI_SUM, world);
  MPI_Allreduce(&mine.first, &all.first, 1, MPI_LMP_TAGINT, MPI_MIN, world);
  if (all.count)
    error->all(
        FLERR,
        "{} atoms without a radius, the first with ID {}, belong to no element of the mesh: "
        "remove such orphan nodes (tools/mesh2data --drop-orphans), or give fix defe a group "
        "without them",
        all.count, all.first);
}

/* ----------------------------------------------------------------------
   IDs are unique; each node is known to the rank that its ID is dealt to
------------------------------------------------------------------------- */

void FixDefe::mesh_directory(Mesh &mesh)
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
  for (int i = 0; i < atom->nlocal; i++)
    nodes.to_id(atom->tag[i], {{xref[i][0], xref[i][1], xref[i][2]}, atom->tag[i], comm->me, i});
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
   reference positions of each element's nodes: checks, masses, stable step, sizes
------------------------------------------------------------------------- */

void FixDefe::mesh_shapes(Mesh &mesh)
{
  const int n = static_cast<int>(mesh.hex.size());
  mesh.mass.resize(n);
  double dt = 1.0e300, diagonal = 0.0, facet = 0.0, shortest = 1.0e300, strongest = 0.0;
  bigint suspicious = 0;
  std::vector<double> radius(atom->ntypes + 1, 0.0);
  std::vector<double> size_sum(2 * parts.size(), 0.0);
  double dt_de = 1.0e300, dt_joint = 1.0e300;
  struct ShapeStep {
    HexCoords X;
    int part;
    double dt, dt_de, dt_joint;
  };
  std::vector<ShapeStep> steps;    // exact critical step per distinct shape

  std::vector<HexCoords> coords;
  for (int round = 0; round < mesh.rounds; round++) {
    const int first = MIN(n, round * CHUNK), last = MIN(n, first + CHUNK);
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
        error->one(FLERR, "Element {} of part {}: its node {} (number {} of 8) does not exist",
                   h.id, parts[h.part].name, h.node[r.corner], r.corner + 1);
      for (int k = 0; k < 3; k++) coords[r.element - first](k, r.corner) = r.x[k];
    }

    for (int e = first; e < last; e++) {
      HexRecord &h = *mesh.hex[e];
      const HexCoords &X = coords[e - first];
      double &mass = mesh.mass[e];
      const Part &p = parts[h.part];
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
              "({:.6g}): make the box larger, or give the nodes' image flags in the data file",
              h.id, p.name, extent, axis, domain->prd[k]);
      }
      const auto check = defe::fe::check_hex(X);
      if (check.verdict == defe::fe::HexCheck::bad)
        error->one(FLERR, "Part {}: {}; the node order must be that of Abaqus C3D8", p.name,
                   defe::fe::describe_bad_hex(h.id, X, check));
      if (check.verdict == defe::fe::HexCheck::suspicious) suspicious++;
      const Material &m = material_of(p);
      h.volume = defe::fe::volume(X);
      mass = element_mass(p, h.volume);
      diagonal = MAX(diagonal, defe::fe::max_diagonal(X));
      facet = MAX(facet, defe::fe::max_face_diagonal(X));
      for (int a = 0; a < 8; a++)
        for (int axis = 0; axis < 3; axis++)
          shortest = MIN(shortest, (X.col(defe::fe::hex_edge_neighbor(a, axis)) - X.col(a)).norm());
      size_sum[2 * h.part] += std::cbrt(h.volume);
      size_sum[2 * h.part + 1] += 1.0;
      if (!m.rigid()) {
        // an area is half of its diagonal squared at the most
        strongest = MAX(strongest,
                        (m.elastic().lambda() + 2.0 * m.elastic().mu()) * 0.5 *
                            std::pow(defe::fe::max_face_diagonal(X), 2));
        double step = -1.0, step_de = 1.0e300, step_joint = 1.0e300;
        const HexCoords shape = reproducible ? defe::fe::rounded_shape(X) : X;
        for (const auto &s : steps)
          if (s.part == h.part && (reproducible ? s.X == shape : defe::fe::congruent(s.X, X))) {
            step = s.dt;
            step_de = s.dt_de;
            step_joint = s.dt_joint;
            break;
          }
        if (step < 0.0) {
          const double its = reproducible ? m.elastic().rho * defe::fe::volume(shape) : mass;
          step = m.law->critical_step(shape);
          if (p.convertible) step_de = discrete_step(shape, m.elastic(), its, step_joint);
          if (steps.size() < 64) steps.push_back({shape, h.part, step, step_de, step_joint});
        }
        dt = MIN(dt, step);
        dt_de = MIN(dt_de, step_de);
        dt_joint = MIN(dt_joint, step_joint);
      }
      if (p.convertible) {
        double r = 0.5 * std::cbrt(h.volume / 8.0);
        if (!defe::fe::is_box(X))
          for (const auto &d : defe::convert_hex(X, X, HexCoords::Zero(), mass))
            r = MAX(r, d.radius);
        radius[p.type] = MAX(radius[p.type], r);
      }
    }
  }
  bigint all_suspicious = 0;
  MPI_Allreduce(&suspicious, &all_suspicious, 1, MPI_LMP_BIGINT, MPI_SUM, world);
  if (all_suspicious && comm->me == 0)
    error->warning(FLERR,
                   "{} elements have a non-positive Jacobian at a corner (positive at all Gauss "
                   "points): they are used, but the mesh is poor there",
                   all_suspicious);
  MPI_Allreduce(&dt, &dt_finite, 1, MPI_DOUBLE, MPI_MIN, world);
  MPI_Allreduce(&dt_de, &dt_discrete, 1, MPI_DOUBLE, MPI_MIN, world);
  MPI_Allreduce(&dt_joint, &dt_joints, 1, MPI_DOUBLE, MPI_MIN, world);
  if (dt_finite >= 1.0e300) dt_finite = 0.0;
  if (dt_discrete >= 1.0e300) dt_discrete = 0.0;
  if (dt_joints >= 1.0e300) dt_joints = 0.0;
  MPI_Allreduce(&diagonal, &max_diagonal, 1, MPI_DOUBLE, MPI_MAX, world);
  MPI_Allreduce(&facet, &max_facet, 1, MPI_DOUBLE, MPI_MAX, world);
  MPI_Allreduce(&strongest, &largest_force, 1, MPI_DOUBLE, MPI_MAX, world);
  MPI_Allreduce(&shortest, &max_step_length, 1, MPI_DOUBLE, MPI_MIN, world);
  max_step_length *= 0.25;
  MPI_Allreduce(radius.data(), de_radius_max.data(), static_cast<int>(radius.size()), MPI_DOUBLE,
                MPI_MAX, world);
  std::vector<double> size_all(size_sum.size());
  MPI_Allreduce(size_sum.data(), size_all.data(), static_cast<int>(size_sum.size()), MPI_DOUBLE,
                MPI_SUM, world);
  for (size_t p = 0; p < parts.size(); p++) {
    const auto &m = material_of(parts[p]);
    if (m.rigid() || size_all[2 * p + 1] == 0.0) continue;
    const double mean = reproducible ? mean_size(mesh.hex, static_cast<int>(p))
                                     : size_all[2 * p] / size_all[2 * p + 1];
    parts[p].shield_time =
        defe::shielding_time(mean, m.elastic().lambda(), m.elastic().mu(), m.elastic().rho);
  }
}

/* ----------------------------------------------------------------------
   node masses, summed in the order of element IDs: the same on any number of ranks
------------------------------------------------------------------------- */

void FixDefe::mesh_masses(const Mesh &mesh)
{
  const int nprocs = comm->nprocs, nlocal = atom->nlocal;
  const int n = static_cast<int>(mesh.hex.size());
  for (int i = 0; i < nlocal; i++) nelem[i] = 0;

  for (int round = 0; round < mesh.rounds; round++) {
    Letters<MassShare> shares(lmp);
    for (int e = 0; e < n; e++)
      for (tagint t : mesh.hex[e]->node)
        if (mesh.round_of(t, nprocs) == round)
          shares.to_id(t, {t, mesh.hex[e]->id, 0.125 * mesh.mass[e]});
    auto came = shares.send();
    std::sort(came.begin(), came.end(), [](const MassShare &a, const MassShare &b) {
      return a.tag != b.tag ? a.tag < b.tag : a.element < b.element;
    });
    Letters<MassReply> replies(lmp);
    for (size_t k = 0; k < came.size();) {
      const NodeDatum &node = *mesh.node(came[k].tag);
      MassReply reply{0.0, node.local, 0};
      for (; k < came.size() && came[k].tag == node.tag; k++) {
        if (reproducible && !defe::adds_exactly(reply.mass, came[k].mass))
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
      nelem[r.local] = r.count;
      atom->rmass[r.local] = r.mass;
      if (atom->radius[r.local] != 0.0)
        error->one(FLERR, "Node {} of the mesh has radius {}: nodes are spheres of radius 0",
                   atom->tag[r.local], atom->radius[r.local]);
    }
  }

  bigint nodes = 0;
  double mass_here = 0.0;
  for (int i = 0; i < nlocal; i++)
    if (nelem[i] > 0) {
      nodes++;
      mass_here += atom->rmass[i];
    }
  MPI_Allreduce(&nodes, &nodes_total, 1, MPI_LMP_BIGINT, MPI_SUM, world);
  MPI_Allreduce(&mass_here, &mass_total, 1, MPI_DOUBLE, MPI_SUM, world);
}

/* ----------------------------------------------------------------------
   what is behind each face: the two elements of a face meet at the lowest ID of its nodes
------------------------------------------------------------------------- */

void FixDefe::mesh_neighbours(const Mesh &mesh)
{
  const int nprocs = comm->nprocs;
  const int n = static_cast<int>(mesh.hex.size());
  for (auto *h : mesh.hex)
    for (tagint &nb : h->nb) nb = 0;

  for (int round = 0; round < mesh.rounds; round++) {
    Letters<FaceDatum> faces(lmp);
    for (int e = 0; e < n; e++)
      for (int f = 0; f < 6; f++) {
        const HexRecord &h = *mesh.hex[e];
        const int *corner = defe::fe::hex_face[f];
        const tagint lowest = MIN(MIN(h.node[corner[0]], h.node[corner[1]]),
                                  MIN(h.node[corner[2]], h.node[corner[3]]));
        if (mesh.round_of(lowest, nprocs) != round) continue;
        faces.to_id(lowest, {{h.node, f, h.id}, comm->me, e, h.part});
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
   data file: "N hexes" in the header, section Hexes with lines
   ID part node1 ... node8   (part: name or number)
------------------------------------------------------------------------- */

void FixDefe::read_data_header(char *line)
{
  bigint n = 0;
  try {
    ValueTokenizer values(line);
    n = values.next_bigint();
    if (values.next_string() != "hexes" || values.has_next())
      throw TokenizerException("other words", "");
  } catch (std::exception &e) {
    error->all(FLERR,
               "Fix defe cannot read the header line '{}' of the data file: {}; needed: N hexes",
               utils::trim(line), e.what());
  }
  if (n < 0) error->all(FLERR, "Data file has a negative number of hexes: {}", n);
  require_hex_section();
  nhex_header = hexes_awaited = n;

  // set_arrays comes after the sections: it must keep what they brought. Slots above nlocal may
  // hold leftovers of atoms that moved away.

  reading = mesh_from_file = true;
  for (int i = atom->nlocal; i < atom->nmax; i++) {
    hexes[i].clear();
    de[i].reset();
  }
}

bigint FixDefe::read_data_skip_lines(char * /*keyword*/)
{
  hexes_awaited = 0;    // the section is there; LAMMPS counts its lines
  return nhex_header;
}

/* ----------------------------------------------------------------------
   LAMMPS takes a file that ends before a section for complete
------------------------------------------------------------------------- */

void FixDefe::require_hex_section()
{
  if (hexes_awaited > 0)
    error->all(FLERR, "Data file announced {} hexes, but had no section Hexes: was the file cut?",
               hexes_awaited);
}

void FixDefe::read_data_section(char * /*keyword*/, int n, char *buf, tagint id_offset)
{
  mesh_dirty = true;
  std::vector<std::string> lines;
  std::vector<int> mine, found(n, 0);    // how many ranks own each element's first node
  for (const auto &raw : utils::split_lines(buf)) {
    const auto line = utils::trim(utils::trim_comment(raw));
    if (line.empty()) continue;
    if (static_cast<int>(lines.size()) == n)
      error->all(FLERR, "Section Hexes of the data file has more than {} lines: '{}'", n, line);
    tagint hexid = 0, node[8];
    int part = -1;
    try {
      ValueTokenizer values(line);
      hexid = values.next_tagint();
      auto name = values.next_string();
      part = find_part(name);
      if (part < 0 && utils::is_integer(name)) {
        const bigint number = ValueTokenizer(name).next_bigint();
        if (number >= 1 && number <= static_cast<bigint>(parts.size()))
          part = static_cast<int>(number) - 1;
      }
      if (part < 0) throw TokenizerException("unknown part", name);
      for (tagint &a : node) {
        const bigint tag = static_cast<bigint>(values.next_tagint()) + id_offset;
        if (tag <= 0 || tag > MAXTAGINT)
          throw TokenizerException("no node can have the ID", std::to_string(tag));
        a = static_cast<tagint>(tag);
      }
      if (values.has_next()) throw TokenizerException("too many items", "");
    } catch (std::exception &e) {
      error->all(FLERR, "Line '{}' of section Hexes: {}; needed: ID part and 8 node IDs", line,
                 e.what());
    }
    if (hexid <= 0) error->all(FLERR, "Line '{}' of section Hexes: element ID must be > 0", line);
    const int i = local_of(node[0]);
    mine.push_back(i >= 0 && i < atom->nlocal ? 1 : 0);
    if (mine.back()) {
      add_hex(i, hexid, part, node);
      if (static_cast<int>(just_read.size()) <= i) just_read.resize(atom->nmax, 0);
      just_read[i] = 1;
    }
    lines.push_back(line);
  }
  if (static_cast<int>(lines.size()) != n)
    error->all(FLERR,
               "Section Hexes of the data file: {0} lines hold {1} elements, not {0}: blank lines "
               "and comments count as lines, as in all sections of LAMMPS (remove them), or the "
               "header announces too many hexes",
               n, lines.size());
  MPI_Allreduce(mine.data(), found.data(), n, MPI_INT, MPI_SUM, world);
  for (int k = 0; k < n; k++)
    if (found[k] != 1)
      error->all(FLERR,
                 "Line '{}' of section Hexes: its first node {}; section Hexes must follow the "
                 "nodes",
                 lines[k], found[k] ? "exists more than once" : "does not exist");
}

/* ---------------------------------------------------------------------- */

void FixDefe::write_data_header(FILE *fp, int /*mth*/)
{
  utils::print(fp, "{} hexes\n", hexes_total);
  if (des_total > 0)
    error->warning(
        FLERR,
        "Data file holds the {} finite elements that are left; joints between the {} DEs "
        "are lost: use write_restart to go on",
        hexes_total, des_total);
}

void FixDefe::write_data_section_size(int /*mth*/, int &nx, int &ny)
{
  nx = 0;
  for (int i = 0; i < atom->nlocal; i++) nx += static_cast<int>(hexes[i].size());
  ny = 10;
}

void FixDefe::write_data_section_pack(int /*mth*/, double **buf)
{
  int n = 0;
  for (int i = 0; i < atom->nlocal; i++)
    for (const auto &h : hexes[i]) {
      buf[n][0] = ubuf(h.id).d;
      buf[n][1] = ubuf(h.part).d;
      for (int a = 0; a < 8; a++) buf[n][2 + a] = ubuf(h.node[a]).d;
      n++;
    }
}

void FixDefe::write_data_section_keyword(int /*mth*/, FILE *fp)
{
  utils::print(fp, "\nHexes\n\n");
}

void FixDefe::write_data_section(int /*mth*/, FILE *fp, int n, double **buf, int /*index*/)
{
  for (int k = 0; k < n; k++) {
    utils::print(fp, "{} {}", static_cast<tagint>(ubuf(buf[k][0]).i),
                 parts[static_cast<int>(ubuf(buf[k][1]).i)].name);
    for (int a = 0; a < 8; a++) utils::print(fp, " {}", static_cast<tagint>(ubuf(buf[k][2 + a]).i));
    fputc('\n', fp);
  }
}
