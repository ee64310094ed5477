/* ----------------------------------------------------------------------
   DEFE: adaptive finite elements to bonded discrete elements for LAMMPS
   https://www.lammps.org/
   This software is distributed under the GNU General Public License.
------------------------------------------------------------------------- */

#include "defe_system.h"

#include "atom.h"
#include "comm.h"
#include "domain.h"
#include "error.h"
#include "update.h"

#include "defe/fe/hex8.h"
#include "defe/fe/principal.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <map>

using namespace LAMMPS_NS;
using defe::Mat3;
using defe::Vec3;
using defe::fe::HexCoords;

DefeBatch::DefeBatch(const DefePart &p, int part, const defe::fe::MaterialLaw &law,
                     const defe::fe::KernelChoice &choice) :
    ElementBatch(part, law, choice),
    convertible(p.convertible)
{
  if (convertible) bound_weights = p.criterion->bound();
}

void DefeBatch::cover(int e)
{
  const auto &idx = nodes(e);
  const auto ends = std::minmax_element(idx.begin(), idx.end());
  const Range its{*ends.first, *ends.second};
  cover(blocks, e / BLOCK, its);
  chunks.resize(blocks.size());
  if (chunks[e / BLOCK].known)
    for (int i : idx) chunks[e / BLOCK].add(i);
  cover(groups, e / (BLOCK * GROUP), its);
}

const DefeBatch::Chunks &DefeBatch::chunks_of(size_t block) const
{
  Chunks &its = chunks[block];
  if (its.known) return its;
  its.known = true;
  const int end = MIN(size(), static_cast<int>(block + 1) * BLOCK);
  for (int e = static_cast<int>(block) * BLOCK; e < end; e++)
    for (int i : nodes(e)) its.add(i);
  return its;
}

void DefeBatch::cover(std::vector<Range> &ranges, size_t which, const Range &also)
{
  if (which >= ranges.size()) ranges.push_back(also);
  ranges[which].first = MIN(ranges[which].first, also.first);
  ranges[which].last = MAX(ranges[which].last, also.last);
}

bool DefeBatch::may_have(const Range &range, const std::vector<int> &places, int limit) const
{
  if (range.last >= limit) return true;
  const auto at = std::lower_bound(places.begin(), places.end(), range.first);
  return at != places.end() && *at <= range.last;
}

DefeElements::DefeElements(DefeSystem &system) : DefeComponent(system), finite(scratch) {}

/* ----------------------------------------------------------------------
   local indices, once per reneighbouring
------------------------------------------------------------------------- */

void DefeElements::build()
{
  if (repairable())
    repair();
  else
    list_all();
  for (auto &b : all) {
    if (b.hex.capacity() > b.hex.size() + b.hex.size() / 4) b.hex.shrink_to_fit();
    b.finish();
  }
  listed = atom->nlocal;
  sys.store.settle();
}

/* ----------------------------------------------------------------------
   A conversion changes a few atoms: all others have the places that they had. Not so if atoms were sorted or many have
   come. In a periodic box another image of a node may have become the nearest one, if ghosts are new.
------------------------------------------------------------------------- */

bool DefeElements::repairable() const
{
  const bool same_images = sys.in_place.going_on() ||
      (!domain->xperiodic && !domain->yperiodic && !domain->zperiodic);
  if (listed < 0 || !same_images) return false;
  const auto &changed = sys.store.changed();
  return std::count_if(changed.begin(), changed.end(), [this](int i) {
           return i < atom->nlocal;
         }) < atom->nlocal / 8;
}

void DefeElements::list_all()
{
  clear();
  const HexRecord *lost = nullptr;
  const int nlocal = atom->nlocal;
  for (int i = 0; i < nlocal; i++) {
    if (i + 6 < nlocal) prefetch(sys.store.hexes(i + 6).data());
    if (const HexRecord *one = list_of(i)) lost = one;
  }
  if (lost) stop_lost(*lost);
}

/** It has a face that is free, or DEs behind one. */
static bool is_exposed(const HexRecord &h)
{
  return std::any_of(std::begin(h.nb), std::end(h.nb), [](tagint nb) {
    return nb <= 0;
  });
}

static bool has_des_behind(const HexRecord &h)
{
  return std::any_of(std::begin(h.nb), std::end(h.nb), [](tagint nb) {
    return nb < 0;
  });
}

/** Elements of atom i; one that has a node that is not here, if there is one. */
const HexRecord *DefeElements::list_of(int i)
{
  const HexRecord *lost = nullptr;
  for (auto &h : sys.store.hexes(i)) {
    std::array<int, 8> idx;
    if (local_hex(h, i, idx.data()))
      add(h, idx);
    else
      lost = &h;
  }
  return lost;
}

/* ----------------------------------------------------------------------
   elements with a node whose place has another atom now, or is that of a ghost that is new, are listed anew, and those that begin
   at the same atom. In place ghosts only move in memory.
------------------------------------------------------------------------- */

void DefeElements::repair()
{
  const int limit = MIN(listed, atom->nlocal);
  const bool same_ghosts = sys.in_place.going_on();
  std::vector<int> places;
  for (int i : sys.store.changed())
    if (i < atom->nlocal) places.push_back(i);
  std::sort(places.begin(), places.end());
  std::vector<int> anchors = places;    // atoms whose elements are listed anew
  for (auto &b : all)
    b.for_blocks(places, limit, [&](int e) {
      auto idx = b.nodes(e);
      bool other = false, moved = false;
      for (int &i : idx)
        if (same_ghosts && i >= listed) {
          const int now = sys.in_place.place_of_ghost(i);
          other = other || now < 0;
          moved = moved || now != i;
          i = now;
        } else
          other = other || i >= limit || sys.store.changed(i);
      if (other && idx[0] >= 0 && idx[0] < limit)
        anchors.push_back(idx[0]);
      else if (moved && !other)
        b.renumber(e, idx);
    });
  std::sort(anchors.begin(), anchors.end());
  anchors.erase(std::unique(anchors.begin(), anchors.end()), anchors.end());
  drop(anchors, limit);

  const HexRecord *lost = nullptr;
  for (int i : anchors)
    if (const HexRecord *one = list_of(i)) lost = one;
  if (lost) stop_lost(*lost);
}

/** Elements that begin at these atoms, and at places from `limit` on. */
void DefeElements::drop(const std::vector<int> &anchors, int limit)
{
  std::map<std::pair<int, int>, int> now;    // elements that go: -1, or have another place
  for (size_t k = 0; k < all.size(); k++) {
    DefeBatch &b = all[k];
    const int batch = static_cast<int>(k);
    std::vector<int> going;
    b.for_blocks(anchors, limit, [&](int e) {
      const int anchor = b.nodes(e)[0];
      if (anchor >= limit || std::binary_search(anchors.begin(), anchors.end(), anchor))
        going.push_back(e);
    });
    std::map<int, int> from;    // where what is at a place was at first
    for (auto e = going.rbegin(); e != going.rend(); ++e) {    // from the last one
      now[{batch, *e}] = -1;
      const int end = b.size() - 1;
      if (end != *e) {
        const auto moved = from.find(end);
        from[*e] = moved == from.end() ? end : moved->second;
        now[{batch, from[*e]}] = *e;
      }
      b.remove(*e);
    }
  }
  // the lists are as long as the surface, and next to nothing in them is concerned: most of it is told by a few bits
  const auto bit = [](int e) {
    return std::uint64_t(1) << (e & 63);
  };
  std::uint64_t concerned = 0;
  for (const auto &one : now) concerned |= bit(one.first.second);
  for (auto *list : {&exposed_, &fronts_, &noticed_, &marked_}) {
    size_t n = 0;
    for (const auto &one : *list) {
      const auto found = concerned & bit(one.second) ? now.find(one) : now.end();
      const int e = found == now.end() ? one.second : found->second;
      if (e >= 0) (*list)[n++] = {one.first, e};
    }
    list->resize(n);
  }
}

void DefeElements::check() const
{
  size_t records = 0, listed_here = 0, bare = 0, to_convert = 0;
  for (int i = 0; i < atom->nlocal; i++) records += sys.store.hexes(i).size();
  for (const auto &b : all)
    for (int e = 0; e < b.size(); e++) {
      const HexRecord &h = *b.hex[e];
      const int i = b.nodes(e)[0];
      const auto &its = sys.store.hexes(i);
      int idx[8];
      const bool same = i < atom->nlocal && !its.empty() && &h >= its.data() &&
          &h < its.data() + its.size() && local_hex(h, i, idx) &&
          std::equal(idx, idx + 8, b.nodes(e).begin());
      if (!same)
        error->one(FLERR, "Fix defe at step {}: element {} of the table is not that of its atom",
                   update->ntimestep, e);
      listed_here++;
      bare += is_exposed(h);
      to_convert += h.marked != 0;
    }
  if (records != listed_here || bare != exposed_.size() || to_convert != marked_.size())
    error->one(
        FLERR,
        "Fix defe at step {}: {} elements are listed, {} with free faces, {} to convert: there "
        "are {}, {}, {}",
        update->ntimestep, listed_here, exposed_.size(), marked_.size(), records, bare, to_convert);
}

void DefeElements::add(HexRecord &h, const std::array<int, 8> &idx)
{
  if (h.kernel < 0) {
    HexCoords X;
    for (int a = 0; a < 8; a++)
      for (int k = 0; k < 3; k++) X(k, a) = sys.store.x_frame(idx[a])[k];
    h.kernel = batch_of(h.part, X, sys.prestress.of_element(idx[0], h));
  }
  DefeBatch &b = all[h.kernel];
  if (is_exposed(h)) exposed_.emplace_back(h.kernel, b.size());
  if (h.noticed && is_exposed(h)) noticed_.emplace_back(h.kernel, b.size());
  if (has_des_behind(h)) fronts_.emplace_back(h.kernel, b.size());
  if (h.marked) marked_.emplace_back(h.kernel, b.size());
  double *history = nullptr;
  if (b.history_size() > 0) {
    auto &list = h.with_extra().history;
    list.resize(b.history_size(), 0.0);
    history = list.data();
  }
  if (b.own_reference()) {
    HexCoords x, X;
    kernel_coords(h, idx.data(), x, X);
    b.add(h, idx, history, &X);
  } else
    b.add(h, idx, history, nullptr);
}

void DefeElements::stop_lost(const HexRecord &h) const
{
  tagint node = 0;
  for (tagint t : h.node)
    if (sys.ids.local_of(t) < 0) node = t;
  error->one(FLERR,
             "Node {} of element {} is missing on proc {} at step {}: it was lost, or the element "
             "is larger than the communication cutoff (raise it with comm_modify cutoff){}",
             node, h.id, comm->me, update->ntimestep, sys.checks.minimizer_hint());
}

void DefeElements::clear()
{
  for (auto &b : all) b.clear();    // they keep their memory
  exposed_.clear();
  fronts_.clear();
  noticed_.clear();
  marked_.clear();
}

/* ----------------------------------------------------------------------
   elements that are to convert are few: they are listed, not searched for among all
------------------------------------------------------------------------- */

void DefeElements::mark(int batch, int e)
{
  HexRecord &h = *all[batch].hex[e];
  if (h.marked) return;
  h.marked = 1;
  marked_.emplace_back(batch, e);
}

void DefeElements::notice_only(const std::vector<char> &of_exposed)
{
  for (const auto &one : noticed_) all[one.first].hex[one.second]->noticed = false;
  noticed_.clear();
  for (size_t k = 0; k < exposed_.size(); k++) {
    if (!of_exposed[k]) continue;
    noticed_.push_back(exposed_[k]);
    all[exposed_[k].first].hex[exposed_[k].second]->noticed = true;
  }
}

void DefeElements::notice_at(const std::vector<int> &nodes)
{
  if (nodes.empty()) return;
  for_elements_at(nodes, [this](int k, int e) {
    HexRecord &h = *all[k].hex[e];
    if (h.noticed || !is_exposed(h)) return;
    h.noticed = true;
    noticed_.emplace_back(k, e);
  });
}

void DefeElements::unmark_all()
{
  for (const auto &one : marked_) all[one.first].hex[one.second]->marked = 0;
  marked_.clear();
}

void DefeElements::forget_kernels()
{
  history_read = history_most();
  all.clear();
  exposed_.clear();
  fronts_.clear();
  noticed_.clear();
  marked_.clear();
  listed = -1;
}

int DefeElements::history_most() const
{
  int most = history_read;
  for (const auto &b : all) most = MAX(most, b.history_size());
  return most;
}

void DefeElements::look_at_histories()
{
  history_read = 0;
  for (int i = 0; i < atom->nlocal; i++)
    for (const auto &h : sys.store.hexes(i))
      if (h.extra) history_read = MAX(history_read, static_cast<int>(h.extra->history.size()));
}

/* ----------------------------------------------------------------------
   local indices of an element's nodes, the images closest to its first node
------------------------------------------------------------------------- */

void DefeElements::coords(const int *idx, HexCoords &x, HexCoords &X) const
{
  for (int a = 0; a < 8; a++)
    for (int k = 0; k < 3; k++) {
      x(k, a) = atom->x[idx[a]][k];
      X(k, a) = sys.store.x_frame(idx[a])[k];
    }
}

void DefeElements::kernel_coords(const HexRecord &h, const int *idx, HexCoords &x,
                                 HexCoords &X) const
{
  coords(idx, x, X);
  if (h.kernel < 0 || !all[h.kernel].own_reference()) return;
  const Mat3 &map = sys.prestress.map_of_element(idx[0], h, all[h.kernel]);
  X = (map * (X.colwise() - X.col(0))).eval();
}

bool DefeElements::local_hex(const HexRecord &h, int anchor, int *idx) const
{
  idx[0] = anchor;
  for (int a = 1; a < 8; a++) {
    idx[a] = sys.ids.nearest_to(anchor, h.node[a]);
    if (idx[a] < 0) return false;
  }
  return true;
}

/* ----------------------------------------------------------------------
   boxes of one shape and part share a kernel; all other shapes the Lagrangian one of their part
------------------------------------------------------------------------- */

int DefeElements::batch_of(int part, const HexCoords &X, const Mat3 *prestress)
{
  const DefePart &p = sys.model.parts[part];
  const auto &law = *sys.model.material_of(p).law;
  const bool own_stress = p.prestress.kind == defe::PrestressRule::VARIABLES;
  const defe::fe::KernelChoice choice(
      law, X, {sys.model.force_lagrangian, sys.model.reproducible, own_stress}, prestress);
  const auto found = std::find_if(all.begin(), all.end(), [&](const DefeBatch &b) {
    return b.takes(part, choice);
  });
  if (found != all.end()) return static_cast<int>(found - all.begin());
  all.emplace_back(p, part, law, choice);
  return static_cast<int>(all.size()) - 1;
}

/* ----------------------------------------------------------------------
   internal forces of this step
------------------------------------------------------------------------- */

void DefeElements::forces(double *virial)
{
  auto &subcycle = sys.clock.subcycle();
  if (subcycle.every() == 1 || update->whichflag == 2) {
    evaluate(&atom->f[0][0], update->setupflag ? 0.0 : subcycle.since_history(), virial);
  } else if (subcycle.due() || virial) {

    // two clocks, see subcycle.h

    const size_t n = 3 * (static_cast<size_t>(atom->nlocal) + atom->nghost);
    scratch.assign(n + 3, 0.0);
    evaluate(scratch.data(), !subcycle.due() || update->setupflag ? 0.0 : subcycle.since_history(),
             virial);
    if (subcycle.due() && n) {
      const int every = subcycle.every();
      double *f = &atom->f[0][0];
      for (size_t k = 0; k < n; k++) f[k] += every * scratch[k];
    }
  }
}

/* ----------------------------------------------------------------------
   forces of all elements of this rank and of their ties, added to f; bounds of the elements' stress
   material histories are advanced by history_step (0: they are not)
------------------------------------------------------------------------- */

void DefeElements::evaluate(double *f, double history_step, double *virial)
{
  defe::fe::ElementBatch::Output out;
  out.bound_at_gauss_points = sys.model.gauss_stress;
  out.virial = virial;
  out.history_step = history_step;
  out.dissipation = &sys.ledger.viscous;
  if (sys.model.reproducible) out.grid = &sys.sums.force_grid();
  for (auto &b : all) {
    if (b.rigid() || b.size() == 0) continue;
    out.bound = b.convertible ? &b.bound_weights : nullptr;
    const auto faults = b.forces(&atom->x[0][0], sys.store.x_frame(0), f, out);
    if (faults.inverted >= 0) stop_inverted(b, faults.inverted);
    if (faults.beyond >= 0) sys.sums.set_beyond(b.nodes(faults.beyond)[0]);
  }
  const int beyond = sys.tied.forces(f, sys.sums.force_grid(), virial);
  if (beyond >= 0) sys.sums.set_beyond(beyond);
  if (history_step > 0.0) sys.clock.subcycle().history_advanced();
}

void DefeElements::stop_inverted(const DefeBatch &b, int e) const
{
  const HexRecord &h = *b.hex[e];
  const double *x = atom->x[b.nodes(e)[0]];
  error->one(FLERR,
             "Element {} of part {} turned inside out at step {} near {:.6g} {:.6g} {:.6g}: "
             "use a smaller timestep, or let it convert earlier{}",
             h.id, sys.model.parts[h.part].name, update->ntimestep, x[0], x[1], x[2],
             sys.checks.minimizer_hint());
}

/* ----------------------------------------------------------------------
   stress and centre of one owned element, for output
------------------------------------------------------------------------- */

void DefeElements::centre_stress(const HexRecord &h, double *centre, double *stress6,
                                 double &s1) const
{
  int idx[8];
  int anchor = sys.ids.local_of(h.node[0]);
  for (int k = 0; k < 3; k++) centre[k] = 0.0;
  for (int k = 0; k < 6; k++) stress6[k] = 0.0;
  s1 = 0.0;
  if (anchor < 0 || !local_hex(h, anchor, idx)) return;
  HexCoords x, X;
  kernel_coords(h, idx, x, X);
  for (int k = 0; k < 3; k++) centre[k] = x.row(k).mean();
  if (sys.model.material_of(sys.model.parts[h.part]).rigid() || h.kernel < 0) return;
  const bool virgin = !h.extra || h.extra->history.empty();
  const Mat3 s =
      all[h.kernel].kernel().stress(x, X, Vec3::Zero(), virgin ? nullptr : h.extra->history.data());
  stress6[0] = s(0, 0);
  stress6[1] = s(1, 1);
  stress6[2] = s(2, 2);
  stress6[3] = s(0, 1);
  stress6[4] = s(0, 2);
  stress6[5] = s(1, 2);
  s1 = defe::fe::max_principal(s);
}

defe::fe::PlasticState DefeElements::plastic_state(const HexRecord &h) const
{
  const bool virgin = h.kernel < 0 || !h.extra || h.extra->history.empty();
  return virgin ? defe::fe::PlasticState()
                : all[h.kernel].kernel().plastic_state(h.extra->history.data());
}

/* ----------------------------------------------------------------------
   largest distance between two nodes of an element of this rank; elements that are certainly within the ghost
   cutoff may be left out
------------------------------------------------------------------------- */

double DefeElements::longest() const
{
  double longest = 0.0;
  if ((comm->nprocs == 1 && atom->nghost == 0) || atom->nlocal == 0) return longest;
  for (const auto &b : all) longest = b.longest(&atom->x[0][0], sys.ghosts.provided(), longest);
  return longest;
}

/* ----------------------------------------------------------------------
   strain energy of all elements of this rank and of their ties at the current positions
------------------------------------------------------------------------- */

double DefeElements::energy()
{
  const size_t nall = atom->nlocal + atom->nghost;
  scratch.assign(3 * nall + 3, 0.0);
  double sum = 0.0;
  for (auto &b : all)
    if (b.size()) b.energy(&atom->x[0][0], sys.store.x_frame(0), scratch.data(), sum);
  return sum + sys.tied.energy(scratch.data());
}

/* ----------------------------------------------------------------------
   largest principal stress at the centres of elements of this rank that can convert, -1e300 if there are none
------------------------------------------------------------------------- */

double DefeElements::largest_stress() const
{
  // bounds of other criteria say nothing about it
  const auto bounded = [](const DefeBatch &b) {
    return b.bound_weights == defe::fe::StressBound();
  };
  const auto stress = [this](const DefeBatch &b, int e) {
    HexCoords x, X;
    kernel_coords(*b.hex[e], b.nodes(e).data(), x, X);
    return defe::fe::max_principal(b.kernel().stress(x, X, Vec3::Zero()));
  };
  // the one with the highest bound first: of the others few can have more
  const DefeBatch *highest = nullptr;
  int first = 0;
  for (const auto &b : all)
    if (b.convertible && bounded(b))
      for (int e = 0; e < b.size(); e++)
        if (!highest || b.bound(e) > highest->bound(first)) {
          highest = &b;
          first = e;
        }
  double s1 = highest ? stress(*highest, first) : -1.0e300;
  for (const auto &b : all)
    if (b.convertible)
      for (int e = 0; e < b.size(); e++)
        if (!bounded(b) || !(b.bound(e) <= s1)) s1 = MAX(s1, stress(b, e));
  return s1;
}

/* ----------------------------------------------------------------------
   what energy() has left on nodes of other ranks is sent to their owners
------------------------------------------------------------------------- */

const double *DefeElements::finite_forces()
{
  sys.ghosts.reverse(finite, 3);
  return scratch.data();
}

int DefeElements::FiniteMessage::pack_reverse(int n, int first, double *buf)
{
  if (n) std::copy_n(&force[3 * static_cast<size_t>(first)], 3 * n, buf);
  return 3 * n;
}

void DefeElements::FiniteMessage::unpack_reverse(int n, const int *list, const double *buf)
{
  int m = 0;
  for (int ii = 0; ii < n; ii++)
    for (int k = 0; k < 3; k++) force[3 * static_cast<size_t>(list[ii]) + k] += buf[m++];
}

double DefeElements::memory_usage() const
{
  double bytes = 0.0;
  for (const auto &b : all)
    bytes += b.hex.capacity() * (sizeof(std::array<int, 8>) + sizeof(HexRecord *) + sizeof(double));
  return bytes;
}
