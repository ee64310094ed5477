/* ----------------------------------------------------------------------
   DEFE: adaptive finite elements to bonded discrete elements for LAMMPS
   https://www.lammps.org/
   This software is distributed under the GNU General Public License.

   Pieces that hold together. Sets of the atoms that one rank sees, labels between ranks and sums are
   in coupling/fragments.h; here is what holds what, and who sends what to whom.
------------------------------------------------------------------------- */

#include "compute_defe_fragment_atom.h"

#include "defe_system.h"
#include "rendezvous.h"

#include "atom.h"
#include "comm.h"
#include "error.h"
#include "fix.h"
#include "group.h"
#include "memory.h"
#include "modify.h"
#include "update.h"

#include "defe/coupling/fragments.h"

#include <algorithm>
#include <cstring>
#include <unordered_map>

using namespace LAMMPS_NS;
using defe::DisjointSets;
using defe::FragmentShare;
using defe::FragmentTotals;
using defe::LabelEdge;

static constexpr int NVALUES = 6;

/* ---------------------------------------------------------------------- */

ComputeDefeFragmentAtom::ComputeDefeFragmentAtom(LAMMPS *lmp, int narg, char **arg) :
    Compute(lmp, narg, arg)
{
  for (int k = 3; k < narg; k += 2) {
    if (strcmp(arg[k], "part") != 0)
      error->all(FLERR, "Unknown compute defe/fragment/atom keyword {}: use part", arg[k]);
    if (k + 1 == narg) utils::missing_cmd_args(FLERR, "compute defe/fragment/atom part", error);
    part_names.emplace_back(arg[k + 1]);
  }
  peratom_flag = 1;
  size_peratom_cols = 0;
  vector_flag = 1;
  size_vector = NVALUES;
  extvector = 0;
  comm_forward = 1;
  comm_reverse = 1;
  memory->create(vector, NVALUES, "defe/fragment/atom:vector");
}

ComputeDefeFragmentAtom::~ComputeDefeFragmentAtom()
{
  memory->destroy(vector);
  memory->destroy(fragment);
}

void ComputeDefeFragmentAtom::init()
{
  sys = DefeSystem::find(lmp);
  if (!sys) error->all(FLERR, "Compute defe/fragment/atom needs a fix defe");
  selected.assign(sys->model.parts.size(), part_names.empty());
  for (const auto &name : part_names) {
    const int p = sys->model.find_part(name);
    if (p < 0)
      error->all(FLERR, "Compute defe/fragment/atom part {}: fix {} has no part of this name", name,
                 sys->host->id);
    selected[p] = 1;
  }
  labelled_tables = -1;    // it may be another fix than before
}

void ComputeDefeFragmentAtom::compute_peratom()
{
  invoked_peratom = update->ntimestep;
  label_fragments();
}

void ComputeDefeFragmentAtom::compute_vector()
{
  invoked_vector = update->ntimestep;
  label_fragments();
}

int ComputeDefeFragmentAtom::local_of(tagint tag) const
{
  const int i = atom->map(tag);
  if (i < 0)
    error->one(FLERR,
               "Compute defe/fragment/atom: atom {} is missing on proc {} at step {}: it was lost "
               "or deleted",
               tag, comm->me, update->ntimestep);
  return i;
}

/* ----------------------------------------------------------------------
   Pieces change when a joint breaks, and when elements convert or atoms come and go: the last two
   make new tables. On any rank, since all must agree on what to do.
------------------------------------------------------------------------- */

static bigint broken_joints(const DefeSystem *sys)
{
  const auto first = sys->joints.state.begin();
  return std::count_if(first, first + 6 * static_cast<bigint>(sys->joints.nde), [](int state) {
    return state >= DefeJoint::CONTACT;
  });
}

bool ComputeDefeFragmentAtom::up_to_date() const
{
  const int mine = labelled_tables == sys->tables.built() && labelled_first == update->firststep &&
      labelled_broken == broken_joints(sys) && !group->dynamic[igroup];
  int all = 0;
  MPI_Allreduce(&mine, &all, 1, MPI_INT, MPI_MIN, world);
  return all;
}

void ComputeDefeFragmentAtom::label_fragments()
{
  if (up_to_date()) return;
  labelled_tables = sys->tables.built();
  labelled_first = update->firststep;
  labelled_broken = broken_joints(sys);
  if (atom->nmax > nmax) {
    nmax = atom->nmax;
    memory->destroy(fragment);
    memory->create(fragment, nmax, "defe/fragment/atom:fragment");
    vector_atom = fragment;
  }

  find_active();
  const int nlocal = atom->nlocal;
  DisjointSets sets(nlocal + atom->nghost);
  join(sets);
  const auto whole = merged_labels(sets);
  for (int i = 0; i < nlocal; i++) fragment[i] = active[i] ? static_cast<double>(whole[i]) : 0.0;
  sum_up(sets, whole);

  active = shared = std::vector<char>();
  label = owner_label = std::vector<std::int64_t>();
}

bool ComputeDefeFragmentAtom::takes_part(const HexPod &hex, int *node) const
{
  if (!selected[hex.part]) return false;
  for (int a = 0; a < 8; a++) {
    node[a] = local_of(hex.node[a]);
    if (!(atom->mask[node[a]] & groupbit)) return false;
  }
  return true;
}

/* ----------------------------------------------------------------------
   Who takes part: DEs of the group and of the parts, and the nodes of elements of these parts all of
   whose nodes are in the group.
------------------------------------------------------------------------- */

void ComputeDefeFragmentAtom::find_active()
{
  const int nlocal = atom->nlocal, nall = nlocal + atom->nghost;
  if (igroup == 0 && part_names.empty()) {
    active.assign(nall, 1);
    for (int i = 0; i < nlocal; i++)
      active[i] = sys->store.de(i) ||
          sys->store.elements_at(i) > 0;    // others are never asked for
    return;
  }
  if (group->dynamic[igroup]) {
    comm_mode = MASK;
    comm->forward_comm(this);
  }
  active.assign(nall, 0);
  for (int i = 0; i < nlocal; i++) {
    int node[8];
    for (const auto &h : sys->store.hexes(i))
      if (takes_part(h, node))
        for (int j : node) active[j] = 1;
    const auto *de = sys->store.de(i);
    if (de) active[i] = selected[de->part] && (atom->mask[i] & groupbit);
  }
  comm_mode = ACTIVE;
  comm->reverse_comm(this);
  comm->forward_comm(this);
}

/* ----------------------------------------------------------------------
   elements hold their nodes together, joints two DEs, ties a DE and the nodes of a face, tied surfaces two elements
   An atom may be here several times, as images of itself: the one that map() knows stands for all.
------------------------------------------------------------------------- */

void ComputeDefeFragmentAtom::join(DisjointSets &sets)
{
  const int nlocal = atom->nlocal;
  for (int i = 0; i < nlocal; i++) {
    if (!active[i]) continue;
    int corner[8];
    for (const auto &h : sys->store.hexes(i))
      if (takes_part(h, corner))
        for (int a = 1; a < 8; a++) sets.join(corner[0], corner[a]);
    for (const auto &nodes : sys->tied.joined_at(i)) {
      const int a = local_of(nodes.first), b = local_of(nodes.second);
      if (active[a] && active[b]) sets.join(a, b);
    }
    const auto *de = sys->store.de(i);
    if (!de) continue;
    if (const auto *pieces = sys->tied_des.of_de(i))
      for (const auto &piece : *pieces)
        for (tagint end : piece.end) {
          const int j = local_of(end);
          if (active[j]) sets.join(i, j);
        }
    for (int s = 0; s < 6; s++) {
      const auto &slot = de->slot[s];
      if (slot.kind == DefeJoint::NONE || slot.state == DefeJoint::CONTACT) continue;
      if (slot.kind == DefeJoint::DE) {
        const int j = local_of(de->other[s]);
        if (active[j]) sets.join(i, j);
      } else if (selected[slot.part]) {
        int node[4];
        bool in = true;
        for (int a = 0; a < 4; a++) {
          node[a] = local_of(de->tie->of[s][a]);
          in = in && active[node[a]];
        }
        if (in)
          for (int j : node) sets.join(i, j);
      }
    }
  }
}

/* ----------------------------------------------------------------------
   the lowest ID in the whole fragment of each atom of this rank
------------------------------------------------------------------------- */

std::vector<std::int64_t> ComputeDefeFragmentAtom::merged_labels(DisjointSets &sets)
{
  const int nlocal = atom->nlocal, nall = nlocal + atom->nghost;
  std::vector<std::int64_t> id(atom->tag, atom->tag + nall);
  label = defe::lowest_of_sets(sets, id);
  owner_label = label;
  comm_mode = LABEL;
  comm->forward_comm(this);

  // sets that other ranks have atoms of: those with ghosts, and those whose atoms are in a set of
  // another rank

  defe::LabelMerge merge;
  std::vector<int> size(nall, 0);
  for (int i = 0; i < nall; i++) size[sets.find(i)]++;
  shared.assign(nall, 0);
  for (int i = nlocal; i < nall; i++) {
    if (size[sets.find(i)] == 1) continue;    // nothing of mine is joined to it
    shared[i] = 1;
    merge.add(label[i], owner_label[i]);
  }
  comm_mode = SHARED;
  comm->reverse_comm(this);
  for (int i = 0; i < nall; i++)
    if (shared[i]) shared[sets.find(i)] = 1;

  bigint edges = static_cast<bigint>(merge.edges().size()), edges_all = 0;
  MPI_Allreduce(&edges, &edges_all, 1, MPI_LMP_BIGINT, MPI_SUM, world);
  if (edges_all == 0) return label;

  const auto route = [this](const std::vector<LabelEdge> &list) {
    Rendezvous::Letters<LabelEdge> letters(lmp);
    for (const auto &e : list) letters.to_id(static_cast<tagint>(e.at), e);
    return letters.send();
  };
  int changed = 1;
  while (changed) {
    merge.take_large(route(merge.edges_for_large()));
    merge.take_small(route(merge.edges_for_small()));
    const int mine = merge.changed();
    MPI_Allreduce(&mine, &changed, 1, MPI_INT, MPI_MAX, world);
  }

  // ask the homes of my shared labels

  struct Question {
    std::int64_t label;
    int rank;
  };
  std::vector<std::int64_t> asked;
  for (int i = 0; i < nall; i++)
    if (shared[i] && sets.find(i) == i) asked.push_back(label[i]);
  std::sort(asked.begin(), asked.end());
  asked.erase(std::unique(asked.begin(), asked.end()), asked.end());
  Rendezvous::Letters<Question> questions(lmp);
  for (auto l : asked) questions.to_id(static_cast<tagint>(l), {l, comm->me});
  Rendezvous::Letters<LabelEdge> answers(lmp);
  for (const auto &q : questions.send()) answers.to_rank(q.rank, {q.label, merge.lowest(q.label)});
  std::unordered_map<std::int64_t, std::int64_t> lowest;
  for (const auto &a : answers.send()) lowest[a.at] = a.other;

  std::vector<std::int64_t> whole(label);
  for (int i = 0; i < nall; i++)
    if (shared[sets.find(i)]) whole[i] = lowest.at(label[i]);
  return whole;
}

/* ----------------------------------------------------------------------
   masses are those of elements and DEs: nodes between two parts have mass of both
   What lies on one rank alone is summed there; shares of the others meet at the home of the label.
------------------------------------------------------------------------- */

void ComputeDefeFragmentAtom::sum_up(DisjointSets &sets, const std::vector<std::int64_t> &whole)
{
  const int nlocal = atom->nlocal;
  std::vector<FragmentShare> of_set(whole.size(), FragmentShare{0, 0.0, 0, 0});
  for (int i = 0; i < nlocal; i++) {
    if (!active[i]) continue;
    auto &share = of_set[sets.find(i)];
    share.label = whole[i];
    if (sys->store.de(i)) {
      share.mass += atom->rmass[i];
      share.des++;
    }
    int node[8];
    for (const auto &h : sys->store.hexes(i)) {
      if (!takes_part(h, node)) continue;
      share.mass += sys->model.material_of(sys->model.parts[h.part]).elastic().rho * h.volume;
      share.elements++;
    }
  }

  std::vector<FragmentShare> fragments;
  Rendezvous::Letters<FragmentShare> letters(lmp);
  for (size_t r = 0; r < of_set.size(); r++) {
    if (of_set[r].label == 0) continue;
    if (shared[r])
      letters.to_id(static_cast<tagint>(of_set[r].label), of_set[r]);
    else
      fragments.push_back(of_set[r]);
  }
  for (const auto &f : defe::sum_shares(letters.send())) fragments.push_back(f);

  FragmentTotals mine;
  for (const auto &f : fragments) mine.add(f);
  const double sums[4] = {static_cast<double>(mine.fragments), static_cast<double>(mine.single_des),
                          mine.mass, mine.single_mass};
  double all[4], largest;
  MPI_Allreduce(sums, all, 4, MPI_DOUBLE, MPI_SUM, world);
  MPI_Allreduce(&mine.largest_mass, &largest, 1, MPI_DOUBLE, MPI_MAX, world);
  const std::int64_t candidate = defe::largest_fragment(fragments, largest);
  std::int64_t lowest;
  MPI_Allreduce(&candidate, &lowest, 1, MPI_INT64_T, MPI_MIN, world);
  vector[0] = all[0];
  vector[1] = all[1];
  vector[2] = all[2];
  vector[3] = all[3];
  vector[4] = largest;
  vector[5] = all[0] > 0.0 ? static_cast<double>(lowest) : 0.0;
}

/* ---------------------------------------------------------------------- */

int ComputeDefeFragmentAtom::pack_forward_comm(int n, int *list, double *buf, int, int *)
{
  int m = 0;
  for (int k = 0; k < n; k++) {
    const int i = list[k];
    if (comm_mode == MASK)
      buf[m++] = ubuf(atom->mask[i]).d;
    else if (comm_mode == ACTIVE)
      buf[m++] = active[i];
    else
      buf[m++] = ubuf(owner_label[i]).d;    // a ghost's goes on to the next rank
  }
  return m;
}

void ComputeDefeFragmentAtom::unpack_forward_comm(int n, int first, double *buf)
{
  int m = 0;
  for (int i = first; i < first + n; i++) {
    if (comm_mode == MASK)
      atom->mask[i] = static_cast<int>(ubuf(buf[m++]).i);
    else if (comm_mode == ACTIVE)
      active[i] = buf[m++] != 0.0;
    else
      owner_label[i] = ubuf(buf[m++]).i;
  }
}

int ComputeDefeFragmentAtom::pack_reverse_comm(int n, int first, double *buf)
{
  const auto &flag = comm_mode == ACTIVE ? active : shared;
  for (int k = 0; k < n; k++) buf[k] = flag[first + k];
  return n;
}

void ComputeDefeFragmentAtom::unpack_reverse_comm(int n, int *list, double *buf)
{
  auto &flag = comm_mode == ACTIVE ? active : shared;
  for (int k = 0; k < n; k++)
    if (buf[k] != 0.0) flag[list[k]] = 1;
}

double ComputeDefeFragmentAtom::memory_usage()
{
  return static_cast<double>(nmax) * sizeof(double);
}
