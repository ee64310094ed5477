/* ----------------------------------------------------------------------
   DEFE: adaptive finite elements to bonded discrete elements for LAMMPS
   https://www.lammps.org/
   This software is distributed under the GNU General Public License.
------------------------------------------------------------------------- */

// Nothing is gathered: faces that may lie on each other meet on the rank that the cell around them is dealt to.

#include "defe_tied_surfaces.h"

#include "defe_system.h"
#include "rendezvous.h"

#include "atom.h"
#include "comm.h"
#include "domain.h"
#include "error.h"
#include "update.h"

#include "defe/coupling/conversion_plan.h"
#include "defe/fe/hex8.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <tuple>

using namespace LAMMPS_NS;
using defe::Tie;
using defe::Vec3;
using defe::fe::HexCoords;
using Rendezvous::cell_of;
using Rendezvous::Letters;

static constexpr double LOOK_AROUND =
    0.25;    // for surfaces that are too far apart, in diagonals of a face

/** A face in one of the cells that it may meet others in. Plain data. */
struct DefeTiedSurfaces::Guest {
  std::int64_t cell[3];
  int pair, side, image;
  tagint id, node[8];
  double lo[3], hi[3];    // of the face, and as far around it as it looks
  double X[24], frequency;
  int part, face, proc, atom;
};

struct DefeTiedSurfaces::Box {
  double lo[3] = {HUGE_VAL, HUGE_VAL, HUGE_VAL}, hi[3] = {-HUGE_VAL, -HUGE_VAL, -HUGE_VAL};
  void add(const double *x)
  {
    for (int d = 0; d < 3; d++) {
      lo[d] = MIN(lo[d], x[d]);
      hi[d] = MAX(hi[d], x[d]);
    }
  }
  Box changed(const Vec3 &low, const Vec3 &high) const
  {
    Box box;
    for (int d = 0; d < 3; d++) {
      box.lo[d] = lo[d] + low[d];
      box.hi[d] = hi[d] + high[d];
    }
    return box;
  }
  Box moved(const Vec3 &by) const { return changed(by, by); }
  Box wider(double by) const { return changed(Vec3::Constant(-by), Vec3::Constant(by)); }
  bool meets(const double *other_lo, const double *other_hi) const
  {
    for (int d = 0; d < 3; d++)
      if (other_lo[d] > hi[d] || other_hi[d] < lo[d]) return false;
    return true;
  }
};

struct DefeTiedSurfaces::Answer {
  int atom, pair, face_a, face_b;
  Kept kept;
};

struct DefeTiedSurfaces::PieceAnswer {
  int atom;
  DefeTiedPiece piece;
};

/** With the ranks that they go to. */
struct DefeTiedSurfaces::Answers {
  std::vector<std::pair<int, Answer>> ties;
  std::vector<std::pair<int, PieceAnswer>> pieces;
};

/** Of a pair of parts. */
struct DefeTiedSurfaces::Sums {
  double area = 0.0, count = 0.0, area_apart = 0.0;    // added
  // largest; of least_apart and stiffness the least, negative
  double distance = 0.0, stiffness = -HUGE_VAL, least_apart = -HUGE_VAL, most_apart = 0.0;
  static constexpr int added = 3, largest = 4;
};

DefeTiedSurfaces::DefeTiedSurfaces(DefeSystem &system) : DefeComponent(system) {}

void DefeTiedSurfaces::begin()
{
  on_ = !sys.model.tied.empty();
  if (on_) sys.store.add_field(this);
}

/* ----------------------------------------------------------------------
   a new mesh
------------------------------------------------------------------------- */

void DefeTiedSurfaces::begin_mesh()
{
  shown.clear();
  for (auto &list : of) list.reset();
  sys.tied_des.forget_all();
}

void DefeTiedSurfaces::show(int i, const HexRecord &h, const HexCoords &X)
{
  const auto &tied = sys.model.tied;
  if (std::none_of(tied.begin(), tied.end(), [&h](const DefeTiedPair &pair) {
        return pair.a == h.part || pair.b == h.part;
      }))
    return;
  Shown one{i, h.part, 0, h.id, {}, X};
  std::copy_n(h.node, 8, one.node);
  for (int f = 0; f < 6; f++)
    if (h.nb[f] == 0) one.faces |= 1 << f;
  if (one.faces) shown.push_back(one);
}

/* ----------------------------------------------------------------------
   what the free faces of each part are within; of all ranks
------------------------------------------------------------------------- */

std::vector<DefeTiedSurfaces::Box> DefeTiedSurfaces::boxes() const
{
  const int n = static_cast<int>(sys.model.parts.size());
  std::vector<Box> mine(n), all(n);
  for (const auto &one : shown)
    for (int a = 0; a < 8; a++) mine[one.part].add(one.X.col(a).data());
  std::vector<double> high(6 * n), highest(6 * n);
  for (int p = 0; p < n; p++)
    for (int d = 0; d < 3; d++) {
      high[6 * p + d] = mine[p].hi[d];
      high[6 * p + 3 + d] = -mine[p].lo[d];
    }
  MPI_Allreduce(high.data(), highest.data(), 6 * n, MPI_DOUBLE, MPI_MAX, world);
  for (int p = 0; p < n; p++)
    for (int d = 0; d < 3; d++) {
      all[p].hi[d] = highest[6 * p + d];
      all[p].lo[d] = -highest[6 * p + 3 + d];
    }
  return all;
}

/* ----------------------------------------------------------------------
   from the box to itself and to its images in periodic directions; with each one its opposite
------------------------------------------------------------------------- */

std::vector<Vec3> DefeTiedSurfaces::box_vectors() const
{
  std::vector<Vec3> all = {Vec3::Zero()};
  for (int d = 0; d < 3; d++) {
    const size_t n = all.size();
    for (size_t m = 0; m < n && domain->periodicity[d]; m++)
      for (double sign : {-1.0, 1.0}) all.push_back(all[m] + sign * domain->prd[d] * Vec3::Unit(d));
  }
  return all;
}

std::vector<int> DefeTiedSurfaces::images_near(const Box &box, const Box &other,
                                               const std::vector<Vec3> &vectors)
{
  std::vector<int> near;
  for (size_t m = 0; m < vectors.size(); m++) {
    const Box there = box.moved(vectors[m]);
    if (other.meets(there.lo, there.hi)) near.push_back(static_cast<int>(m));
  }
  return near;
}

/* ----------------------------------------------------------------------
   faces near the other part of their pair, in all cells that they reach into
------------------------------------------------------------------------- */

std::vector<DefeTiedSurfaces::Guest> DefeTiedSurfaces::guests(const std::vector<Box> &around,
                                                              double size) const
{
  Letters<Guest> letters(lmp);
  const auto vectors = box_vectors();
  for (const auto &one : shown) {
    const auto &law = *sys.model.material_of(sys.model.parts[one.part]).law;
    double frequency = -1.0;
    for (int f = 0; f < 6; f++) {
      if (!(one.faces & (1 << f))) continue;
      Box box;
      for (int a : defe::fe::hex_face[f]) box.add(one.X.col(a).data());
      const double diagonal = (Vec3(box.hi) - Vec3(box.lo)).norm();
      for (size_t k = 0; k < sys.model.tied.size(); k++) {
        const auto &pair = sys.model.tied[k];
        if (one.part != pair.a && one.part != pair.b) continue;
        Guest g{};
        g.pair = static_cast<int>(k);
        g.side = one.part == pair.a ? 0 : 1;
        const double look = MAX(LOOK_AROUND * diagonal, 0.51 * pair.rule.distance);
        const auto near = images_near(box.wider(look), around[g.side ? pair.a : pair.b], vectors);
        if (near.empty()) continue;
        if (frequency < 0.0) frequency = 2.0 / law.critical_step(one.X);
        g.id = one.id;
        std::copy_n(one.node, 8, g.node);
        g.frequency = frequency;
        g.part = one.part;
        g.face = f;
        g.proc = comm->me;
        g.atom = one.atom;
        // over periodic borders the second part comes to the first one
        for (int m : g.side ? near : std::vector<int>{0}) {
          const Box there = box.moved(vectors[m]).wider(look);
          std::copy_n(there.lo, 3, g.lo);
          std::copy_n(there.hi, 3, g.hi);
          Eigen::Map<HexCoords>(g.X) = one.X.colwise() + vectors[m];
          g.image = m;
          send_to_cells(g, size, letters);
        }
      }
    }
  }
  auto here = letters.send();
  std::sort(here.begin(), here.end(), [](const Guest &p, const Guest &q) {
    return std::tie(p.cell[0], p.cell[1], p.cell[2], p.pair, p.side, p.id, p.face, p.image) <
        std::tie(q.cell[0], q.cell[1], q.cell[2], q.pair, q.side, q.id, q.face, q.image);
  });
  return here;
}

template <class Letters>
void DefeTiedSurfaces::send_to_cells(Guest &g, double size, Letters &letters) const
{
  std::int64_t first[3], last[3];
  for (int d = 0; d < 3; d++) {
    first[d] = cell_of(g.lo[d], size);
    last[d] = cell_of(g.hi[d], size);
  }
  for (g.cell[0] = first[0]; g.cell[0] <= last[0]; g.cell[0]++)
    for (g.cell[1] = first[1]; g.cell[1] <= last[1]; g.cell[1]++)
      for (g.cell[2] = first[2]; g.cell[2] <= last[2]; g.cell[2]++) letters.to_cell(g.cell, g);
}

/* ----------------------------------------------------------------------
   two that meet in several cells do so once: in the one that has the lowest place of what they have in common
------------------------------------------------------------------------- */

bool DefeTiedSurfaces::meet_here(const Guest &p, const Guest &q, double size) const
{
  for (int d = 0; d < 3; d++) {
    const double low = MAX(p.lo[d], q.lo[d]);
    if (low > MIN(p.hi[d], q.hi[d]) || p.cell[d] != cell_of(low, size)) return false;
  }
  return true;
}

template <class Meet>
void DefeTiedSurfaces::for_pairs(const std::vector<Guest> &here, double size,
                                 const Meet &meet) const
{
  for (size_t first = 0, end; first < here.size(); first = end) {
    for (end = first + 1; end < here.size(); end++)
      if (!std::equal(here[end].cell, here[end].cell + 3, here[first].cell) ||
          here[end].pair != here[first].pair)
        break;
    for (size_t a = first; a < end && here[a].side == 0; a++)
      for (size_t b = end; b > a + 1 && here[b - 1].side == 1; b--)
        if (meet_here(here[a], here[b - 1], size)) meet(here[a], here[b - 1]);
  }
}

void DefeTiedSurfaces::add_pieces(const Guest &own, const Guest &other,
                                  const defe::TiedElement &its, const defe::TiedElement &theirs,
                                  Answers &answers)
{
  PieceAnswer answer{};
  answer.atom = own.atom;
  DefeTiedPiece &piece = answer.piece;
  piece.own = own.id;
  piece.other = other.id;
  for (int k = 0; k < 4; k++) piece.end[k] = other.node[defe::fe::hex_face[other.face][k]];
  piece.slot = own.face;
  piece.other_face = other.face;
  piece.other_part = other.part;
  piece.of.depth = defe::depth_of_des(theirs);
  const auto quarters = defe::tied_quarters(its, theirs);
  for (int k = 0; k < 4; k++) {
    if (quarters[k].area == 0.0) continue;
    piece.place = defe::fe::hex_face[own.face][k];
    piece.of.area = quarters[k].area;
    piece.of.weight = quarters[k].weight;
    answers.pieces.emplace_back(own.proc, answer);
  }
}

void DefeTiedSurfaces::meet(const Guest &a, const Guest &b, Answers &answers,
                            std::vector<Sums> &sums) const
{
  const auto element = [this](const Guest &g) {
    const DefePart &p = sys.model.parts[g.part];
    const auto &m = sys.model.material_of(p);
    defe::TiedElement e;
    e.X = Eigen::Map<const HexCoords>(g.X);
    e.face = g.face;
    e.volume = defe::fe::volume(e.X);
    e.modulus = m.rigid() ? 0.0 : m.elastic().lambda() + 2.0 * m.elastic().mu();
    e.mass = m.elastic().rho * e.volume;
    e.frequency = g.frequency;
    return e;
  };
  Answer answer{};
  Tie &tie = answer.kept.tie;
  const auto its = element(a), theirs = element(b);
  tie = defe::tie_faces(its, theirs, sys.model.tied[a.pair].rule);
  Sums &s = sums[a.pair];
  if (tie.nodes == 0) {
    s.area_apart += tie.area;
    if (tie.area > 0.0) s.least_apart = MAX(s.least_apart, -tie.distance);
    s.most_apart = MAX(s.most_apart, tie.distance);
    return;
  }
  s.area += tie.area;
  s.count += 1.0;
  s.distance = MAX(s.distance, tie.distance);
  s.stiffness = MAX(s.stiffness, -tie.stiffness);
  answer.pair = a.pair;
  answer.atom = a.atom;
  answer.face_a = a.face;
  answer.face_b = b.face;
  answer.kept.a = a.id;
  answer.kept.b = b.id;
  for (int k = 0; k < tie.nodes; k++)
    answer.kept.node[k] = k < 4 ? a.node[defe::fe::hex_face[a.face][k]]
                                : b.node[defe::tied_node_of_b(b.face, k - 4)];
  answer.kept.stays = sys.tied_des.stay(a.part, b.part);
  answers.ties.emplace_back(a.proc, answer);
  if (!answer.kept.stays) return;
  add_pieces(a, b, its, theirs, answers);
  add_pieces(b, a, theirs, its, answers);
}

double DefeTiedSurfaces::find()
{
  double mine = 0.0, size = 0.0;
  for (const auto &one : shown) mine = MAX(mine, defe::fe::max_face_diagonal(one.X));
  MPI_Allreduce(&mine, &size, 1, MPI_DOUBLE, MPI_MAX, world);
  for (const auto &pair : sys.model.tied) size = MAX(size, pair.rule.distance);
  size = MAX(2.0 * size, 1.0e-100);
  Answers answers;
  std::vector<Sums> sums(sys.model.tied.size());
  for_pairs(guests(boxes(), size), size, [&](const Guest &a, const Guest &b) {
    meet(a, b, answers, sums);
  });

  // of one stiffness, that of the softest place of the two parts

  for (size_t k = 0; k < sums.size(); k++) {
    Sums all;
    MPI_Allreduce(&sums[k].area, &all.area, Sums::added, MPI_DOUBLE, MPI_SUM, world);
    MPI_Allreduce(&sums[k].distance, &all.distance, Sums::largest, MPI_DOUBLE, MPI_MAX, world);
    tell(sys.model.tied[k], all);
    sums[k] = all;
  }
  double frequency = 0.0, fastest = 0.0;
  Letters<Answer> letters(lmp);
  for (auto &one : answers.ties) {
    Tie &tie = one.second.kept.tie;
    const auto &pair = sys.model.tied[one.second.pair];
    tie.set_stiffness(-sums[one.second.pair].stiffness);
    frequency = MAX(
        frequency,
        tie.frequency({sys.model.parts[pair.a].convertible, sys.model.parts[pair.b].convertible}));
    letters.to_rank(one.first, one.second);
  }
  MPI_Allreduce(&frequency, &fastest, 1, MPI_DOUBLE, MPI_MAX, world);
  auto came = letters.send();
  std::sort(came.begin(), came.end(), [](const Answer &p, const Answer &q) {
    return std::tie(p.atom, p.kept.a, p.face_a, p.kept.b, p.face_b) <
        std::tie(q.atom, q.kept.a, q.face_a, q.kept.b, q.face_b);
  });
  for (const auto &one : came) add(one.atom, one.kept);
  Letters<PieceAnswer> pieces(lmp);
  for (const auto &one : answers.pieces) pieces.to_rank(one.first, one.second);
  for (const auto &one : pieces.send()) sys.tied_des.keep(one.atom, one.piece);
  sys.tied_des.sort();
  shown = {};
  return fastest > 0.0 ? 2.0 / fastest : HUGE_VAL;
}

void DefeTiedSurfaces::tell(const DefeTiedPair &pair, const Sums &s) const
{
  const std::string names = sys.model.parts[pair.a].name + " " + sys.model.parts[pair.b].name;
  if (s.count == 0.0 && s.area_apart > 0.0)
    error->all(
        FLERR,
        "Fix defe tied {}: their surfaces are {:.4g} to {:.4g} apart, and no more than {} is "
        "bridged: move the parts together, or give a larger 'distance'",
        names, -s.least_apart, s.most_apart,
        pair.rule.distance < 0.0 ? "a tenth of the size of a face"
                                 : fmt::format("{:.4g}", pair.rule.distance));
  if (s.count == 0.0)
    error->all(
        FLERR,
        "Fix defe tied {}: there is nothing to tie, no free face of the one part lies on one "
        "of the other: check the meshes and the names",
        names);
  if (comm->me) return;
  utils::logmesg(lmp, "Fix defe: tied {}: {} pairs of faces, area {:.6g}{}\n", names,
                 static_cast<bigint>(s.count), s.area,
                 s.distance > 1.0e-6 * std::sqrt(s.area / s.count)
                     ? fmt::format(", up to {:.3g} apart", s.distance)
                     : "");
  if (s.area_apart > 0.0)
    error->warning(FLERR,
                   "Fix defe tied {}: an area of {:.4g} is not tied, where the surfaces are {:.4g} "
                   "to {:.4g} apart: give a larger 'distance' if it should be",
                   names, s.area_apart, -s.least_apart, s.most_apart);
}

/* ----------------------------------------------------------------------
   local indices, once per reneighbouring
------------------------------------------------------------------------- */

void DefeTiedSurfaces::build()
{
  forget();
  if (!on_) return;
  for (int i = 0; i < atom->nlocal; i++) {
    if (!of[i]) continue;
    for (size_t k = 0; k < of[i]->size(); k++) {
      const Kept &kept = (*of[i])[k];
      int node[Tie::most_nodes];
      for (int a = 0; a < kept.tie.nodes; a++) {
        node[a] = sys.ids.nearest_to(i, kept.node[a]);
        if (node[a] < 0)
          error->one(
              FLERR,
              "Node {} of element {}, which is tied to element {}, is missing on proc {} at step "
              "{}: it was lost or deleted, or the communication cutoff is too small (raise "
              "it with comm_modify cutoff)",
              kept.node[a], a < 4 ? kept.a : kept.b, a < 4 ? kept.b : kept.a, comm->me,
              update->ntimestep);
      }
      tables.add(kept.tie, node);
      listed.emplace_back(i, static_cast<int>(k));
    }
  }
}

void DefeTiedSurfaces::forget()
{
  tables.clear();
  listed.clear();
}

int DefeTiedSurfaces::forces(double *f, const defe::SumGrid &grid, double *virial) const
{
  if (!tables.count()) return -1;
  return tables.forces(&atom->x[0][0], sys.store.x_frame(0), f, grid, virial);
}

double DefeTiedSurfaces::energy(double *f) const
{
  return tables.count() ? tables.energy(&atom->x[0][0], sys.store.x_frame(0), f) : 0.0;
}

std::vector<std::pair<tagint, tagint>> DefeTiedSurfaces::joined_at(int i) const
{
  std::vector<std::pair<tagint, tagint>> nodes;
  if (on_ && of[i])
    for (const auto &one : *of[i]) nodes.emplace_back(one.node[0], one.node[4]);
  return nodes;
}

/* ----------------------------------------------------------------------
   elements convert
------------------------------------------------------------------------- */

void DefeTiedSurfaces::end(const defe::ConversionPlan &plan)
{
  if (!on_) return;
  let_go_ = MAXTAGINT;
  // where nothing takes its place, the second half kick of this step is without it: the mean of both positions is lost
  const bool kicked = !update->setupflag && sys.clock.subcycle().every() == 1;
  const double half_a_step = kicked ? 0.5 * update->dt : 0.0;
  for (size_t t = listed.size(); t-- > 0;) {    // backwards: numbers of those before stay
    auto &list = *of[listed[t].first];
    const Kept &kept = list[listed[t].second];
    if (!plan.converting(kept.a) && !plan.converting(kept.b)) continue;
    if (!kept.stays)
      for (tagint element : {kept.a, kept.b})
        if (plan.converting(element)) let_go(element);
    double power = 0.0;
    sys.ledger.conv_strain += tables.energy_of(static_cast<int>(t), &atom->x[0][0],
                                               sys.store.x_frame(0), &atom->v[0][0], power);
    if (!kept.stays) sys.ledger.conv_strain += half_a_step * power;
    list.erase(list.begin() + listed[t].second);
  }
  forget();
}

void DefeTiedSurfaces::warn()
{
  if (!on_) return;
  tagint first = MAXTAGINT;
  MPI_Allreduce(&let_go_, &first, 1, MPI_LMP_TAGINT, MPI_MIN, world);
  if (first == MAXTAGINT || told) return;
  told = true;
  if (comm->me == 0)
    error->warning(
        FLERR,
        "Fix defe: element {}, which is tied to another part, converts at step {}, and not all of "
        "its face stays tied: what is held are quarters of it that are covered by half and more, "
        "if each "
        "element becomes eight DEs; let the other part reach as far, or give no other 'split'",
        first, update->ntimestep);
}

/* ----------------------------------------------------------------------
   as a field of the store
------------------------------------------------------------------------- */

static int kept_size(int nodes)
{
  return 4 + nodes + nodes * (nodes + 1) / 2;
}

int DefeTiedSurfaces::size(int i) const
{
  int n = 1;
  if (of[i])
    for (const auto &one : *of[i]) n += kept_size(one.tie.nodes);
  return n;
}

int DefeTiedSurfaces::most() const
{
  return largest_size(atom->nlocal);
}

int DefeTiedSurfaces::pack(int i, double *buf) const
{
  int m = 0;
  buf[m++] = ubuf(of[i] ? static_cast<int>(of[i]->size()) : 0).d;
  if (!of[i]) return m;
  for (const auto &one : *of[i]) {
    const int n = one.tie.nodes;
    buf[m++] = ubuf(n).d;
    buf[m++] = ubuf(one.a).d;
    buf[m++] = ubuf(one.b).d;
    buf[m++] = ubuf(one.stays).d;
    for (int k = 0; k < n; k++) buf[m++] = ubuf(one.node[k]).d;
    for (int k = 0; k < n * (n + 1) / 2; k++) buf[m++] = one.tie.M[k];
  }
  return m;
}

int DefeTiedSurfaces::unpack(int i, const double *buf)
{
  int m = 0;
  const int count = static_cast<int>(ubuf(buf[m++]).i);
  of[i].reset();
  if (count > 0) of[i] = std::make_unique<List>(count);
  for (int c = 0; c < count; c++) {
    Kept &one = (*of[i])[c];
    const int n = one.tie.nodes = static_cast<int>(ubuf(buf[m++]).i);
    one.a = static_cast<tagint>(ubuf(buf[m++]).i);
    one.b = static_cast<tagint>(ubuf(buf[m++]).i);
    one.stays = static_cast<int>(ubuf(buf[m++]).i);
    for (int k = 0; k < n; k++) one.node[k] = static_cast<tagint>(ubuf(buf[m++]).i);
    for (int k = 0; k < n * (n + 1) / 2; k++) one.tie.M[k] = buf[m++];
  }
  return m;
}
