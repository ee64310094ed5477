/* ----------------------------------------------------------------------
   DEFE: adaptive finite elements to bonded discrete elements for LAMMPS
   https://www.lammps.org/
   This software is distributed under the GNU General Public License.
------------------------------------------------------------------------- */

#include "defe_strengths.h"

#include "defe_system.h"
#include "pair_defe_joint.h"

#include "atom.h"
#include "comm.h"
#include "error.h"
#include "force.h"
#include "group.h"

#include "defe/coupling/strength_field.h"
#include "defe/fe/hex8.h"
#include "defe/fe/periodic.h"

#include <algorithm>
#include <cmath>

using namespace LAMMPS_NS;
using defe::fe::HexCoords;

DefeStrengths::DefeStrengths(DefeSystem &system) : DefeComponent(system), references(system) {}

void DefeStrengths::begin()
{
  on_ = std::any_of(sys.model.parts.begin(), sys.model.parts.end(), [](const DefePart &p) {
    return p.strength.given();
  });
  growing_ = std::any_of(sys.model.parts.begin(), sys.model.parts.end(), [](const DefePart &p) {
    return p.strength.growth.on();
  });
  if (on_) sys.store.add_field(this);
}

void DefeStrengths::mesh_made()
{
  due = true;
  for (auto &one : of) one.reset();
}

/* ----------------------------------------------------------------------
   with new tables
------------------------------------------------------------------------- */

void DefeStrengths::elements_listed()
{
  if (!on_) return;
  if (due) draw();
  due = false;
  if (growing_) check_growth();
  find_limits();
}

void DefeStrengths::joints_listed()
{
  auto &jt = sys.joints;
  if (!on_ || sys.census.des() == 0) return;
  now.value.assign(atom->nlocal + atom->nghost, HUGE_VAL);
  for (int i = 0; i < atom->nlocal; i++)
    if (of[i] && of[i]->de > 0.0) now.value[i] = of[i]->de;
  sys.ghosts.forward(now, 1);
  jt.strength.resize(jt.nall);
  for (int d = 0; d < jt.nall; d++) jt.strength[d] = now.value[jt.self[d]];
}

int DefeStrengths::OfGhosts::pack_forward(int n, const int *list, const double *, double *buf)
{
  for (int k = 0; k < n; k++) buf[k] = value[list[k]];
  return n;
}

void DefeStrengths::OfGhosts::unpack_forward(int n, int first, const double *buf)
{
  std::copy_n(buf, n, &value[first]);
}

/* ----------------------------------------------------------------------
   all elements, once
------------------------------------------------------------------------- */

void DefeStrengths::draw()
{
  int mine = 0, any = 0;    // after a restart they have their strengths
  for (const auto &b : sys.elements.batches())
    for (int e = 0; e < b.size() && sys.model.parts[b.part()].strength.given() && !mine; e++)
      mine = find(b.nodes(e)[0], b.hex[e]->id) == nullptr;
  MPI_Allreduce(&mine, &any, 1, MPI_INT, MPI_MAX, world);
  if (!any) return;

  references.X.resize(atom->nlocal + atom->nghost);
  for (int i = 0; i < atom->nlocal; i++) std::copy_n(sys.store.x_ref(i), 3, references.X[i].data());
  sys.ghosts.forward(references, 3);
  for (size_t p = 0; p < sys.model.parts.size(); p++) {
    const auto &field = sys.model.parts[p].strength;
    if (!field.given()) continue;
    const auto bits = group_bits(static_cast<int>(p));
    std::vector<Found> found(field.flaws.size());
    const auto &all = sys.elements.batches();
    for (size_t k = 0; k < all.size(); k++)
      if (all[k].part() == static_cast<int>(p)) draw_batch(static_cast<int>(k), bits, found);
    tell(static_cast<int>(p), found);
  }
  references.X = {};
}

int DefeStrengths::References::pack_forward(int n, const int *list, const double *, double *buf)
{
  for (int k = 0; k < n; k++) std::copy_n(X[list[k]].data(), 3, buf + 3 * k);
  return 3 * n;
}

void DefeStrengths::References::unpack_forward(int n, int first, const double *buf)
{
  for (int k = 0; k < n; k++) std::copy_n(buf + 3 * k, 3, X[first + k].data());
}

/* ----------------------------------------------------------------------
   A face is on a surface if its four nodes are in the group and no element of the same part is behind it: the flaws
   of a face of glass are there when a film is bonded to it.
------------------------------------------------------------------------- */

void DefeStrengths::draw_batch(int batch, const std::vector<int> &bits, std::vector<Found> &found)
{
  const DefeBatch &b = sys.elements.batches()[batch];
  const auto &field = sys.model.parts[b.part()].strength;
  std::vector<unsigned> faces(bits.size());
  for (int e = 0; e < b.size(); e++) {
    const HexRecord &h = *b.hex[e];
    const auto &idx = b.nodes(e);
    HexCoords X;
    for (int a = 0; a < 8; a++)
      for (int k = 0; k < 3; k++) X(k, a) = references.X[idx[a]][k];
    defe::fe::join_across_border(X, sys.mesh.periods());
    const auto sizes = defe::place_sizes(X, sys.model.parts[b.part()].split);
    for (size_t k = 0; k < bits.size(); k++) {
      faces[k] = 0;
      for (int f = 0; f < 6 && bits[k]; f++) {
        bool in = h.nb[f] == 0 || h.nbpart[f] != h.part;
        for (int a : defe::fe::hex_face[f]) in = in && (atom->mask[idx[a]] & bits[k]);
        if (in) faces[k] |= 1u << f;
      }
      for (const auto &one : sizes) {
        if (!bits[k]) found[k].size += one.volume;
        for (int f = 0; f < 6; f++)
          if (faces[k] >> f & 1u) found[k].size += one.area[f];
      }
    }
    Places strength = field.draw(h.id, sizes, faces);
    strength.resize(sys.model.lot_size(), HUGE_VAL);
    auto &drawn = of[idx[0]];
    if (!drawn) drawn = std::make_unique<Drawn>();
    drawn->hexes.emplace_back(h.id, strength);
    for (size_t k = 0; k < bits.size(); k++)
      found[k].least =
          std::min(found[k].least, *std::min_element(strength.begin(), strength.end()));
  }
}

/* ----------------------------------------------------------------------
   bits of the groups of surfaces; 0: the inside
------------------------------------------------------------------------- */

std::vector<int> DefeStrengths::group_bits(int part) const
{
  std::vector<int> bits;
  for (const auto &f : sys.model.parts[part].strength.flaws) {
    const int igroup = f.surface.empty() ? -1 : group->find(f.surface);
    if (!f.surface.empty() && igroup < 0)
      error->all(FLERR,
                 "Fix defe strength {}: there is no group {}: define the group of the nodes of "
                 "that surface before the first run",
                 sys.model.parts[part].name, f.surface);
    bits.push_back(igroup < 0 ? 0 : group->bitmask[igroup]);
  }
  return bits;
}

/* ----------------------------------------------------------------------
   what was found, of all ranks; a surface without a face is a mistake
------------------------------------------------------------------------- */

void DefeStrengths::tell(int part, const std::vector<Found> &found) const
{
  const DefePart &p = sys.model.parts[part];
  for (size_t k = 0; k < found.size(); k++) {
    const auto &f = p.strength.flaws[k];
    double size = 0.0, least = 0.0;
    MPI_Allreduce(&found[k].size, &size, 1, MPI_DOUBLE, MPI_SUM, world);
    MPI_Allreduce(&found[k].least, &least, 1, MPI_DOUBLE, MPI_MIN, world);
    if (size == 0.0 && !f.surface.empty())
      error->all(FLERR,
                 "Fix defe strength {}: no face of the part has its four nodes in group {} and no "
                 "other element of the part behind it: put the nodes of the surface into the group "
                 "before the first run",
                 p.name, f.surface);
    if (comm->me == 0)
      utils::logmesg(lmp, "Fix defe: strength of part {}: {}, on {} {:.6g}\n", p.name, f.words(),
                     f.surface.empty() ? "a volume of" : "an area of", size);
    if (k + 1 == found.size() && comm->me == 0)
      utils::logmesg(lmp, "Fix defe: strength of part {}: least {:.6g}\n", p.name, least);
    if (k + 1 == found.size() && comm->me == 0 && p.strength.growth.on())
      utils::logmesg(lmp,
                     "Fix defe: strength of part {}: {}, of weight where tension rises by less "
                     "than {:.3g} per unit of time\n",
                     p.name, p.strength.growth.words(), p.strength.growth.inert_rate(least));
  }
}

/* ----------------------------------------------------------------------
   an element converts at the same share of its strength as without flaws: conversion stress by sigma_t. Without joints
   that soften there is no sigma_t, and it converts at its strength.
------------------------------------------------------------------------- */

double DefeStrengths::share_of_strength(int part) const
{
  const DefePart &p = sys.model.parts[part];
  double strength = 0.0;
  for (const char *style : {"^defe/joint", "^defe/cohesive"})
    if (const auto *pair = dynamic_cast<PairDefeJoint *>(force->pair_match(style, 0)))
      strength = std::max(strength, pair->joint_strength(p.type));
  return strength > 0.0 ? p.stress / strength : 1.0;
}

void DefeStrengths::find_limits()
{
  const auto &all = sys.elements.batches();
  batches.resize(all.size());
  for (size_t k = 0; k < all.size(); k++) {
    const DefeBatch &b = all[k];
    Batch &mine = batches[k];
    mine.limit.clear();
    mine.places.clear();
    mine.least = HUGE_VAL;
    const DefePart &p = sys.model.parts[b.part()];
    if (!b.convertible || !p.strength.given()) continue;
    // of the criterion's own measure, by the tension at which it is reached
    mine.by_strength = share_of_strength(b.part()) * p.criterion->limit() / p.stress;
    for (int e = 0; e < b.size(); e++) {
      mine.limit.push_back(mine.by_strength * of_element(b.nodes(e)[0], *b.hex[e]));
      mine.least = std::min(mine.least, mine.limit.back());
      if (p.strength.growth.on()) mine.places.push_back(find(b.nodes(e)[0], b.hex[e]->id));
    }
  }
}

/* ---------------------------------------------------------------------- */

DefeStrengths::Places *DefeStrengths::find(int i, tagint element) const
{
  if (!on_ || i < 0 || !of[i]) return nullptr;
  for (auto &one : of[i]->hexes)
    if (one.first == element) return &one.second;
  return nullptr;
}

double DefeStrengths::of_element(int i, const HexRecord &h) const
{
  const Places *all = find(i, h.id);
  return all ? *std::min_element(all->begin(), all->end()) : 0.0;
}

const std::vector<double> *DefeStrengths::of_places(int i, const HexRecord &h) const
{
  return find(i, h.id);
}

double DefeStrengths::of_de(int i) const
{
  return on_ && of[i] ? of[i]->de : 0.0;
}

void DefeStrengths::set_de(int i, double strength)
{
  if (!on_ || !std::isfinite(strength)) return;
  of[i] = std::make_unique<Drawn>();
  of[i]->de = strength;
}

void DefeStrengths::remove(int i, tagint element)
{
  if (!on_ || !of[i]) return;
  auto &list = of[i]->hexes;
  list.erase(std::remove_if(list.begin(), list.end(),
                            [element](const auto &one) {
                              return one.first == element;
                            }),
             list.end());
}

double DefeStrengths::memory_usage() const
{
  double bytes = static_cast<double>(of.capacity()) * sizeof(of[0]);
  for (const auto &one : of)
    if (one)
      bytes += sizeof(Drawn) +
          one->hexes.capacity() * (sizeof(one->hexes[0]) + sys.model.lot_size() * sizeof(double));
  return bytes;
}

/* ----------------------------------------------------------------------
   as a field of the store
------------------------------------------------------------------------- */

/** Doubles of an element: ID, and strengths. */
int DefeStrengths::hex_size() const
{
  return 1 + sys.model.lot_size();
}

int DefeStrengths::size(int i) const
{
  if (!of[i]) return 1;
  return of[i]->de > 0.0 ? 2 : 1 + hex_size() * static_cast<int>(of[i]->hexes.size());
}

int DefeStrengths::most() const
{
  return 1 + hex_size() * sys.mesh.hexes_per_node();
}

int DefeStrengths::pack(int i, double *buf) const
{
  const Drawn *drawn = of[i].get();
  const bool de = drawn && drawn->de > 0.0;
  buf[0] = ubuf(de ? -1 : drawn ? static_cast<int>(drawn->hexes.size()) : 0).d;
  if (de) {
    buf[1] = drawn->de;
    return 2;
  }
  int m = 1;
  if (drawn)
    for (const auto &one : drawn->hexes) {
      buf[m++] = ubuf(one.first).d;
      for (double s : one.second) buf[m++] = s;
    }
  return m;
}

int DefeStrengths::unpack(int i, const double *buf)
{
  const int count = static_cast<int>(ubuf(buf[0]).i);
  of[i].reset();
  if (count == 0) return 1;
  of[i] = std::make_unique<Drawn>();
  if (count < 0) {
    of[i]->de = buf[1];
    return 2;
  }
  int m = 1;
  of[i]->hexes.resize(count);
  for (auto &one : of[i]->hexes) {
    one.first = static_cast<tagint>(ubuf(buf[m++]).i);
    one.second.resize(sys.model.lot_size());
    for (double &s : one.second) s = buf[m++];
  }
  return m;
}
