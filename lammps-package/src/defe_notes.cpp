/* ----------------------------------------------------------------------
   DEFE: adaptive finite elements to bonded discrete elements for LAMMPS
   https://www.lammps.org/
   This software is distributed under the GNU General Public License.
------------------------------------------------------------------------- */

// Nothing is gathered: what must meet meets on the rank that an ID or a place is dealt to.

#include "defe_system.h"
#include "pair_defe_joint.h"
#include "rendezvous.h"

#include "atom.h"
#include "comm.h"
#include "domain.h"
#include "force.h"
#include "update.h"

#include "defe/coupling/mesh_measure.h"
#include "defe/fe/topology.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <map>
#include <set>
#include <string>
#include <tuple>
#include <unordered_map>
#include <utility>
#include <vector>

using namespace LAMMPS_NS;
using Rendezvous::cell_of;
using Rendezvous::Letters;

// nodes that are closer than this, in shortest edges of the mesh, are at one place
static constexpr double AT_ONE_PLACE = 1.0e-4;

// edge of the cells in which nodes at one place meet, in the same unit
static constexpr double CELL = 1.7;

namespace {

/// "a", "a and b", "a, b and c"
std::string listed(const std::vector<std::string> &names)
{
  std::string text;
  for (size_t k = 0; k < names.size(); k++)
    text += (k == 0 ? "" : k + 1 < names.size() ? ", " : " and ") + names[k];
  return text;
}

/// Sets of nodes that are connected by the elements of this rank.
class Connected {
 public:
  int index(tagint tag)
  {
    const auto made = known.emplace(tag, static_cast<int>(tags.size()));
    if (made.second) {
      tags.push_back(tag);
      lowest.push_back(tag);
      parent.push_back(made.first->second);
    }
    return made.first->second;
  }
  int root(int k)
  {
    while (parent[k] != k) k = parent[k] = parent[parent[k]];
    return k;
  }
  void join(int a, int b)
  {
    a = root(a);
    b = root(b);
    if (a == b) return;
    if (lowest[b] < lowest[a]) std::swap(a, b);
    parent[b] = a;
  }
  int count() const { return static_cast<int>(tags.size()); }
  tagint tag(int k) const { return tags[k]; }
  /// lowest ID of the set, as far as it is known
  tagint &lowest_of(int k) { return lowest[root(k)]; }

 private:
  std::unordered_map<tagint, int> known;
  std::vector<tagint> tags, lowest;
  std::vector<int> parent;
};

/// The same over all ranks: a set that ends at the border of a rank goes on where its nodes are known
/// as well. One round of messages per rank that a body crosses, about only the nodes on such borders
/// after the first.
void connect_ranks(LAMMPS *lmp, MPI_Comm world, Connected &sets)
{
  struct Share {
    tagint node, lowest;
    int proc, index;
  };
  struct Reply {
    tagint lowest;
    int index;
  };
  std::vector<int> shared(sets.count());
  for (int k = 0; k < sets.count(); k++) shared[k] = k;
  for (int any = lmp->comm->nprocs > 1 ? 1 : 0; any;) {
    Letters<Share> shares(lmp);
    for (int k : shared)
      shares.to_id(sets.tag(k), {sets.tag(k), sets.lowest_of(k), lmp->comm->me, k});
    auto came = shares.send();
    std::sort(came.begin(), came.end(), [](const Share &a, const Share &b) {
      return a.node != b.node ? a.node < b.node : a.lowest < b.lowest;
    });
    Letters<Reply> replies(lmp);
    for (size_t k = 0; k < came.size();) {
      size_t end = k + 1;
      while (end < came.size() && came[end].node == came[k].node) end++;
      if (end > k + 1)
        for (size_t s = k; s < end; s++)
          replies.to_rank(came[s].proc, {came[k].lowest, came[s].index});
      k = end;
    }
    shared.clear();
    int changed = 0;
    for (const auto &r : replies.send()) {
      shared.push_back(r.index);
      tagint &lowest = sets.lowest_of(r.index);
      if (r.lowest >= lowest) continue;
      lowest = r.lowest;
      changed = 1;
    }
    MPI_Allreduce(&changed, &any, 1, MPI_INT, MPI_MAX, world);
  }
}

// ---- nodes at one place ----

/// A node on the surface of deformable elements, with the first part of these.
struct SurfaceNode {
  tagint tag;
  int part;
  double x[3];
};

/// Their places are known to the nodes' owners, their parts to the elements': both meet on the rank that
/// the ID is dealt to, and are returned there.
std::vector<SurfaceNode> surface_nodes(LAMMPS *lmp, const DefeSystem &sys)
{
  constexpr int NODE = -1;    // in place of the part: the node itself
  const auto *atom = lmp->atom;
  Letters<SurfaceNode> letters(lmp);
  std::vector<std::pair<tagint, int>> free;
  for (int i = 0; i < atom->nlocal; i++) {
    if (sys.store.elements_at(i) > 0) {
      SurfaceNode n{atom->tag[i], NODE, {atom->x[i][0], atom->x[i][1], atom->x[i][2]}};
      lmp->domain->remap(n.x);
      letters.to_id(n.tag, n);
    }
    for (const auto &h : sys.store.hexes(i)) {
      if (sys.model.material_of(sys.model.parts[h.part]).rigid()) continue;
      for (int f = 0; f < 6; f++)
        if (h.nb[f] == 0)
          for (int k : defe::fe::hex_face[f]) free.emplace_back(h.node[k], h.part);
    }
  }
  std::sort(free.begin(), free.end());
  free.erase(std::unique(free.begin(), free.end()), free.end());
  for (const auto &n : free) letters.to_id(n.first, {n.first, n.second, {0.0, 0.0, 0.0}});
  auto came = letters.send();
  std::sort(came.begin(), came.end(), [](const SurfaceNode &a, const SurfaceNode &b) {
    return a.tag != b.tag ? a.tag < b.tag : a.part < b.part;
  });
  size_t kept = 0;
  for (size_t k = 0; k + 1 < came.size(); k++) {
    if (came[k].part != NODE || came[k + 1].tag != came[k].tag) continue;
    const int part = came[k + 1].part;
    came[kept] = came[k];
    came[kept++].part = part;
  }
  came.resize(kept);
  return came;
}

/// A node in its cell or, as a guest, in one that it is at the border of.
struct Place {
  std::int64_t cell[3];
  tagint tag;
  int part, home;
  double x[3];
};

/// What meets in the cells that are dealt to this rank: sorted by cells, and by IDs in these.
std::vector<Place> sorted_by_cells(LAMMPS *lmp, const std::vector<SurfaceNode> &nodes, double size,
                                   double near)
{
  const auto *domain = lmp->domain;
  struct Copy {
    std::int64_t cell;
    double x;
    bool home;
  };
  Letters<Place> places(lmp);
  for (const auto &n : nodes) {
    std::vector<Copy> copies[3];    // per direction, of the node and of its image over the border
    for (int d = 0; d < 3; d++) {
      double image[2] = {n.x[d], n.x[d]};
      int images = 1;
      if (domain->periodicity[d]) {
        if (n.x[d] - domain->boxlo[d] <= near)
          image[images++] += domain->prd[d];
        else if (domain->boxhi[d] - n.x[d] <= near)
          image[images++] -= domain->prd[d];
      }
      for (int m = 0; m < images; m++)
        for (auto c = cell_of(image[m] - near, size); c <= cell_of(image[m] + near, size); c++)
          copies[d].push_back({c, image[m], m == 0 && c == cell_of(n.x[d], size)});
    }
    for (const auto &a : copies[0])
      for (const auto &b : copies[1])
        for (const auto &c : copies[2]) {
          const Place place{
              {a.cell, b.cell, c.cell}, n.tag, n.part, a.home && b.home && c.home, {a.x, b.x, c.x}};
          places.to_cell(place.cell, place);
        }
  }
  auto here = places.send();
  std::sort(here.begin(), here.end(), [](const Place &a, const Place &b) {
    return std::tie(a.cell[0], a.cell[1], a.cell[2], a.tag) <
        std::tie(b.cell[0], b.cell[1], b.cell[2], b.tag);
  });
  return here;
}

/// A node that lies on one of the part `on`.
struct Twin {
  tagint node, other;
  int part, on;
  double x[3];
};

/// All of this rank's cells; each pair from both sides. `other` is the one with the lowest ID.
std::vector<Twin> twins_in(const std::vector<Place> &here, double near)
{
  std::vector<Twin> twins;
  for (size_t first = 0, end; first < here.size(); first = end) {
    for (end = first + 1; end < here.size(); end++)
      if (!std::equal(here[end].cell, here[end].cell + 3, here[first].cell)) break;
    for (size_t a = first; a < end; a++) {
      const Place &n = here[a];
      if (!n.home) continue;
      std::map<int, tagint> lies_on;
      for (size_t b = first; b < end; b++) {
        const Place &o = here[b];
        if (o.tag == n.tag) continue;
        const double rsq = std::pow(o.x[0] - n.x[0], 2) + std::pow(o.x[1] - n.x[1], 2) +
            std::pow(o.x[2] - n.x[2], 2);
        if (rsq <= near * near) lies_on.emplace(o.part, o.tag);
      }
      for (const auto &o : lies_on)
        twins.push_back({n.tag, o.second, n.part, o.first, {n.x[0], n.x[1], n.x[2]}});
    }
  }
  return twins;
}

/// Pairs of parts, the lower number first, of which one has a face with all four nodes on nodes of the
/// other. Each rank knows those of its own elements.
std::set<std::pair<int, int>> matching_faces(LAMMPS *lmp, const DefeSystem &sys,
                                             const std::vector<Twin> &twins)
{
  struct Word {
    tagint node;
    int on;            // of a twin; -1: a face that asks
    int proc, face;    // who asks
  };
  Letters<Word> words(lmp);
  for (const auto &t : twins) words.to_id(t.node, {t.node, t.on, 0, 0});
  std::vector<int> part;    // of each free face
  for (int i = 0; i < lmp->atom->nlocal; i++)
    for (const auto &h : sys.store.hexes(i))
      for (int f = 0; f < 6; f++) {
        if (h.nb[f] != 0 || sys.model.material_of(sys.model.parts[h.part]).rigid()) continue;
        for (int k : defe::fe::hex_face[f])
          words.to_id(h.node[k], {h.node[k], -1, lmp->comm->me, static_cast<int>(part.size())});
        part.push_back(h.part);
      }
  auto came = words.send();
  std::sort(came.begin(), came.end(), [](const Word &a, const Word &b) {
    return a.node != b.node ? a.node < b.node : a.on > b.on;    // twins first
  });
  Letters<std::pair<int, int>> replies(lmp);    // face, and a part that one of its nodes lies on
  for (size_t k = 0, first = 0; k < came.size(); k++) {
    if (came[k].node != came[first].node) first = k;
    if (came[k].on < 0)
      for (size_t t = first; t < k && came[t].on >= 0; t++)
        replies.to_rank(came[k].proc, {came[k].face, came[t].on});
  }
  std::map<std::pair<int, int>, int> corners;
  std::set<std::pair<int, int>> pairs;
  for (const auto &r : replies.send())
    if (++corners[r] == 4) pairs.emplace(std::minmax(part[r.first], r.second));
  return pairs;
}

}    // namespace

/* ----------------------------------------------------------------------
   at the first run after the mesh was made or has grown; collective
------------------------------------------------------------------------- */

void DefeNotes::say_all()
{
  if (!due || !update->whichflag) return;
  due = false;
  strengths();
  laws();
  collecting();
  slender();
  bodies();
  untied();
}

void DefeNotes::say(const std::string &note)
{
  if (comm->me != 0 || std::find(said.begin(), said.end(), note) != said.end()) return;
  said.push_back(note);
  utils::logmesg(lmp, "Note: " + note + "\n");
}

/* ----------------------------------------------------------------------
   elements that convert above the strength of the joints that they become. A conversion stress above
   Young's modulus is no mistake: nothing is meant to convert. Nor does the stress matter where all is
   discrete from the start.
------------------------------------------------------------------------- */

void DefeNotes::strengths()
{
  for (const auto &p : sys.model.parts) {
    if (!p.convertible || p.start == "all" || p.stress > sys.model.material_of(p).elastic().E)
      continue;
    for (const char *style : {"^defe/joint", "^defe/cohesive"}) {
      const auto *pair = dynamic_cast<PairDefeJoint *>(force->pair_match(style, 0));
      if (!pair) continue;
      const double strength = pair->joint_strength(p.type);
      if (p.stress > strength)
        say(fmt::format("part {} converts at {:.6g}, above the strength {:.6g} of its joints "
                        "(pair_coeff {} {} cohesive): they are overstressed when they are born; "
                        "convert at 0.90 to 0.95 of the strength",
                        p.name, p.stress, strength, p.type, p.type));
      break;
    }
  }
}

/* ----------------------------------------------------------------------
   joints judged by their own traction, whose strength depends on the direction in the mesh; and a weak shear that is
   asked for where the largest principal stress alone decides
------------------------------------------------------------------------- */

void DefeNotes::laws()
{
  const auto *pair = dynamic_cast<PairDefeJoint *>(force->pair_match("^defe/joint", 0));
  if (!pair) pair = dynamic_cast<PairDefeJoint *>(force->pair_match("^defe/cohesive", 0));
  if (!pair) return;
  for (const auto &p : sys.model.parts) {
    if (!p.convertible || (p.start.empty() && p.stress > sys.model.material_of(p).elastic().E))
      continue;
    const auto &law = pair->joint_law(p.type);
    const auto &opening = pair->opening_law(p.type);
    if (!opening.by_cracks()) {
      double strength[3];    // of a tension along an axis, the diagonal of a face, that of a cube
      for (int k = 0; k < 3; k++) {
        const double normal = 1.0 / (k + 1.0);
        const double shear = std::sqrt(normal * (1.0 - normal));
        strength[k] = law.sigma_t / defe::equivalent_traction(normal, shear, law);
      }
      say(fmt::format("with {} and beta {:.4g} part {} breaks at {:.3g} along the lines of its "
                      "mesh, at {:.3g} along the diagonals of faces and {:.3g} along those of "
                      "elements, and cracks follow the lines (pair_coeff {} {}): without {} "
                      "they do not know the mesh",
                      opening.name(), law.beta, p.name, strength[0], strength[1], strength[2],
                      p.type, p.type, opening.name()));
    } else if (law.reciprocal && law.beta < 1.0)
      say(fmt::format("part {} is not weaker in shear for 'reciprocal' and beta {:.4g} (pair_coeff "
                      "{} {}): its cracks start where the largest principal stress is {:.6g}, and "
                      "beta counts when they slide; with lattice joints break under a shear of "
                      "{:.3g}",
                      p.name, law.beta, p.type, p.type, law.sigma_t, law.beta * law.sigma_t));
  }
}

/* ----------------------------------------------------------------------
   windows in which cracks run too far, see DefeMarks::longest_window()
------------------------------------------------------------------------- */

void DefeNotes::collecting()
{
  if (sys.model.collect <= 1) return;
  const double waits = sys.model.collect * update->dt;
  std::vector<std::string> names;
  double way = 0.0, room = 0.0;    // of the part in which a crack runs farthest beyond
  for (const auto &p : sys.model.parts) {
    if (!sys.marks.waits(p)) continue;
    const double spacing = sys.marks.de_spacing(p), run = waits * sys.marks.crack_speed(p);
    if (run <= spacing) continue;
    names.push_back(p.name);
    if (run * room > way * spacing || names.size() == 1) {
      way = run;
      room = spacing;
    }
  }
  if (names.empty()) return;
  say(fmt::format(
      "with collect {} elements of {} {} wait for up to {:.3g}, in which a crack can run "
      "{:.3g}, more than the spacing of DEs ({:.3g}): cracks stop, and others start in their "
      "place; "
      "use collect {} or less",
      sys.model.collect, names.size() > 1 ? "parts" : "part", listed(names), waits, way, room,
      sys.marks.longest_window()));
}

/* ----------------------------------------------------------------------
   DEs of flat elements that are bent are born sheared. A few in a free mesh do no harm.
------------------------------------------------------------------------- */

void DefeNotes::slender()
{
  std::vector<std::string> names;
  bigint count = 0;
  for (const auto &p : sys.model.parts) {
    if (!p.convertible || p.stress > sys.model.material_of(p).elastic().E) continue;
    if (10 * p.slender <= p.elements || !sys.model.enhanced(p)) continue;
    names.push_back(p.name);
    count += p.slender;
  }
  if (names.empty()) return;
  say(fmt::format(
      "{} elements of {} {} are more than {:g} times as long as thick: where they are bent and "
      "convert, DEs store more energy than they did (3 times at 4:1); use shorter "
      "elements there, or plain ones",
      count, names.size() > 1 ? "parts" : "part", listed(names), defe::MeshMeasure::slender_from));
}

/* ----------------------------------------------------------------------
   bodies (elements that are connected by nodes) and balls, if there is no contact of surfaces and the script
   does not say that this is intended
------------------------------------------------------------------------- */

void DefeNotes::bodies()
{
  if (sys.model.contact_given) return;
  const size_t nparts = sys.model.parts.size();

  // each part of each body, counted where the lowest node of the body is dealt to

  Connected sets;
  for (int i = 0; i < atom->nlocal; i++)
    for (const auto &h : sys.store.hexes(i)) {
      const int first = sets.index(h.node[0]);
      for (int a = 1; a < 8; a++) sets.join(first, sets.index(h.node[a]));
    }
  connect_ranks(lmp, world, sets);
  struct Piece {
    tagint body;
    int part;
    bool operator<(const Piece &o) const { return body != o.body ? body < o.body : part < o.part; }
    bool operator==(const Piece &o) const { return body == o.body && part == o.part; }
  };
  auto unique = [](std::vector<Piece> &list) {
    std::sort(list.begin(), list.end());
    list.erase(std::unique(list.begin(), list.end()), list.end());
  };
  std::vector<Piece> pieces;
  for (int i = 0; i < atom->nlocal; i++)
    for (const auto &h : sys.store.hexes(i)) {
      const Piece p{sets.lowest_of(sets.index(h.node[0])), h.part};
      if (pieces.empty() || !(pieces.back() == p)) pieces.push_back(p);
    }
  unique(pieces);
  Letters<Piece> letters(lmp);
  for (const auto &p : pieces) letters.to_id(p.body, p);
  pieces = letters.send();
  unique(pieces);
  std::vector<bigint> mine(2 * nparts, 0), sum(2 * nparts);    // bodies, and the sum of their IDs
  for (const auto &p : pieces) {
    mine[2 * p.part]++;
    mine[2 * p.part + 1] += p.body;
  }
  MPI_Allreduce(mine.data(), sum.data(), static_cast<int>(mine.size()), MPI_LMP_BIGINT, MPI_SUM,
                world);

  // rigid parts have no contact with each other in any case

  std::vector<char> alone(nparts, 0);
  bool deformable = false;
  for (size_t p = 0; p < nparts; p++) {
    const bigint np = sum[2 * p];
    const bool soft = !sys.model.material_of(sys.model.parts[p]).rigid();
    deformable = deformable || (np > 0 && soft);
    for (size_t q = p + 1; q < nparts; q++) {
      const bigint nq = sum[2 * q];
      if (np == 0 || nq == 0 || (!soft && sys.model.material_of(sys.model.parts[q]).rigid()))
        continue;
      if (np == 1 && nq == 1 && sum[2 * p + 1] == sum[2 * q + 1]) continue;    // one body
      if (sys.model.are_tied(static_cast<int>(p), static_cast<int>(q))) continue;
      alone[p] = alone[q] = 1;
    }
  }
  std::vector<std::string> names;
  for (size_t p = 0; p < nparts; p++)
    if (alone[p]) names.push_back(sys.model.parts[p].name);
  if (!names.empty())
    say(fmt::format("parts {} have no contact: they pass through each other{}; add 'contact 0.2' "
                    "to fix defe",
                    listed(names), names.size() > 2 ? " where they share no nodes" : ""));
  for (size_t p = 0; p < nparts; p++)
    if (sum[2 * p] > 1 && !sys.model.material_of(sys.model.parts[p]).rigid())
      say(fmt::format("{} bodies of part {} have no contact: they pass through each other; add "
                      "'contact 0.2' to fix defe",
                      sum[2 * p], sys.model.parts[p].name));

  balls(deformable);
}

void DefeNotes::balls(bool deformable)
{
  bigint mine = 0, all = 0;
  for (int i = 0; i < atom->nlocal; i++) mine += !sys.store.de(i) && atom->radius[i] > 0.0;
  MPI_Allreduce(&mine, &all, 1, MPI_LMP_BIGINT, MPI_SUM, world);
  if (all && deformable)
    say(fmt::format("{} no contact with finite elements: {} through them; add 'contact 0.2' to "
                    "fix defe",
                    all == 1 ? "1 sphere has" : fmt::format("{} spheres have", all),
                    all == 1 ? "it passes" : "they pass"));
}

/* ----------------------------------------------------------------------
   nodes on the surface of deformable elements that coincide with others: parts were meshed separately, and
   nothing joins them. Against a rigid part this is how a contact begins; between others as well, if there is
   contact of surfaces and their faces do not match
------------------------------------------------------------------------- */

void DefeNotes::untied()
{
  const double shortest = 4.0 * sys.mesh.max_step_length();
  if (!(shortest > 0.0) || sys.census.elements() == 0) return;
  const double near = AT_ONE_PLACE * shortest;
  const auto twins =
      twins_in(sorted_by_cells(lmp, surface_nodes(lmp, sys), CELL * shortest, near), near);

  // of two parts the later one lies on the earlier one, of two nodes of a part the higher ID

  struct Found {
    int on, part;
    bigint count;
    Twin example;    // the one with the lowest ID
  };
  std::map<std::pair<int, int>, Found> found;
  auto add = [&](const Found &f) {
    auto &sum = found.emplace(std::make_pair(f.on, f.part), Found{f.on, f.part, 0, f.example})
                    .first->second;
    sum.count += f.count;
    if (f.count && f.example.node <= sum.example.node) sum.example = f.example;
  };
  for (const auto &t : twins)
    if (t.on < t.part || (t.on == t.part && t.other < t.node)) add({t.on, t.part, 1, t});
  std::set<std::pair<int, int>> matching;
  if (sys.model.contact()) matching = matching_faces(lmp, sys, twins);

  // a line for each pair of parts, on the first rank

  Letters<Found> letters(lmp);
  for (const auto &f : found) letters.to_rank(0, f.second);
  for (const auto &m : matching) letters.to_rank(0, {m.first, m.second, 0, {}});
  const auto all = letters.send();
  found.clear();
  matching.clear();
  for (const auto &f : all) {
    if (f.count)
      add(f);
    else
      matching.emplace(f.on, f.part);
  }
  for (const auto &entry : found) {
    const Found &f = entry.second;
    const bool one = f.count == 1, same = f.on == f.part, contact = sys.model.contact();
    if (contact && !matching.count(entry.first)) continue;
    if (sys.model.are_tied(f.on, f.part)) continue;
    double x[3];
    for (int d = 0; d < 3; d++)    // no rounding errors of zero
      x[d] = std::abs(f.example.x[d]) < near ? 0.0 : f.example.x[d];
    say(fmt::format("{} node{} of part {} lie{} on {} of {} and {} not joined (node {} on node {} "
                    "at {:.6g} {:.6g} {:.6g}): they {}; to bond them, let the elements share these "
                    "nodes (tools/mesh2data --merge)",
                    f.count, one ? "" : "s", sys.model.parts[f.part].name, one ? "s" : "",
                    same ? (one ? "another one" : "other ones") : (one ? "a node" : "nodes"),
                    same ? "the same part" : "part " + sys.model.parts[f.on].name,
                    one ? "is" : "are", f.example.node, f.example.other, x[0], x[1], x[2],
                    contact ? "meet by contact only" : "come apart"));
  }
}
