/* ----------------------------------------------------------------------
   DEFE: adaptive finite elements to bonded discrete elements for LAMMPS
   https://www.lammps.org/
   This software is distributed under the GNU General Public License.
------------------------------------------------------------------------- */

#include "defe_tied_des.h"

#include "defe_system.h"

#include "atom.h"
#include "comm.h"
#include "error.h"
#include "update.h"

#include "defe/coupling/conversion_plan.h"

#include <Eigen/LU>

#include <algorithm>
#include <cmath>
#include <tuple>

using namespace LAMMPS_NS;
using defe::Vec3;

/** Doubles of a piece in messages and files. */
static constexpr int PIECE = 6 + 6 + 1 + 3 + 4;

void DefeTiedDEs::begin()
{
  on_ = !sys.model.tied.empty();    // also if nothing converts before a restart
  if (on_) sys.store.add_field(this);
}

bool DefeTiedDEs::stay(int part, int other) const
{
  for (int p : {part, other})
    if (sys.model.parts[p].convertible &&
        sys.model.parts[p].split.along() != defe::ElementSplit::usual)
      return false;
  return true;
}

/* ----------------------------------------------------------------------
   a new mesh
------------------------------------------------------------------------- */

void DefeTiedDEs::forget_all()
{
  for (auto &list : of) list.reset();
}

void DefeTiedDEs::keep(int i, const DefeTiedPiece &piece)
{
  add(i, piece);
}

void DefeTiedDEs::sort()
{
  for (int i = 0; i < atom->nlocal && on_; i++)
    if (of[i])
      std::sort(of[i]->begin(), of[i]->end(), [](const auto &p, const auto &q) {
        return std::tie(p.own, p.place, p.slot, p.other, p.other_face) <
            std::tie(q.own, q.place, q.slot, q.other, q.other_face);
      });
}

/* ----------------------------------------------------------------------
   places
------------------------------------------------------------------------- */

DefeTiedDEs::List::const_iterator DefeTiedDEs::end_of_slot(List::const_iterator first,
                                                           List::const_iterator end)
{
  return std::find_if(first, end, [first](const DefeTiedPiece &p) {
    return p.slot != first->slot;
  });
}

defe::TiedPlace DefeTiedDEs::place_of(List::const_iterator first, List::const_iterator end,
                                      double depth) const
{
  std::vector<defe::TiedPiece> pieces;
  for (auto p = first; p != end; ++p) pieces.push_back(p->of);
  return defe::tied_place(pieces, depth);
}

int DefeTiedDEs::local_end(int i, tagint end) const
{
  const int j = sys.ids.nearest_to(i, end);
  if (j < 0)
    error->one(FLERR,
               "Atom {}, which DE or node {} is tied to by a surface, is missing on proc {} at "
               "step {}: it was lost or deleted, or the communication cutoff is too small (raise "
               "it with comm_modify cutoff)",
               end, atom->tag[i], comm->me, update->ntimestep);
  return j;
}

/* ----------------------------------------------------------------------
   elements convert
------------------------------------------------------------------------- */

unsigned DefeTiedDEs::faces(int i, tagint element) const
{
  unsigned bits = 0;
  if (on_ && of[i])
    for (const auto &p : *of[i])
      if (p.own == element) bits |= 1u << p.slot;
  return bits;
}

// The glue has yielded, and the joint that takes its place does not yield: it is that much longer, so that its force is
// that of the element's stress.

DefeTiedDEs::List DefeTiedDEs::born(int i, tagint element, const defe::NewDE &de,
                                    const defe::Mat3 &F, bool &lost) const
{
  List all;
  if (!on_ || !of[i]) return all;
  for (const auto &p : *of[i])
    if (p.own == element && p.place == de.place) all.push_back(p);
  for (auto first = all.begin(); first != all.end();) {
    const auto end = all.begin() + (end_of_slot(first, all.cend()) - all.cbegin());
    double area = 0.0;
    for (auto p = first; p != end; ++p) area += p->of.area;
    if (area < defe::least_tied_share * de.area[first->slot]) {
      lost = true;
      first = all.erase(first, end);
      continue;
    }
    const int s = first->slot;
    const double depth = de.face[s].dot(de.area_normal[s]) / de.area[s];
    const auto place = place_of(first, end, depth);
    Vec3 y = -de.x, dX = -de.X;
    const double *w = place.weight.data();
    for (auto p = first; p != end; ++p)
      for (tagint tag : p->end) {
        const int j = local_end(i, tag);
        y += *w * Vec3(atom->x[j]);
        dX += *w++ * Vec3(sys.store.x_frame(j));
      }
    const Vec3 offset = F.inverse() * y - dX;
    for (auto p = first; p != end; ++p) std::copy_n(offset.data(), 3, p->offset);
    first = end;
  }
  for (auto &p : all) p.own = 0;
  return all;
}

void DefeTiedDEs::set_de(int i, const List &list)
{
  if (on_ && !list.empty()) of[i] = std::make_unique<List>(list);
}

void DefeTiedDEs::remove(int i, tagint element)
{
  if (!on_ || !of[i]) return;
  drop_if(i, [element](const DefeTiedPiece &p) {
    return p.own == element;
  });
}

void DefeTiedDEs::book(const defe::ConversionPlan &plan)
{
  for (int d = 0; d < sys.joints.nde && on_; d++) {
    const List *list = of[sys.joints.self[d]].get();
    if (!list || std::none_of(list->begin(), list->end(), [&plan](const DefeTiedPiece &p) {
          return plan.converting(p.other) != nullptr;
        }))
      continue;
    DERecord &r = *sys.joints.rec(d);
    if (!r.newborn) sys.ledger.conv_strain += sys.tables.de_energy(d, sys.joints.present[d]);
    r.newborn = 1;
  }
}

void DefeTiedDEs::replace_ends(const defe::ConversionPlan &plan)
{
  for (int i = 0; i < atom->nlocal && on_; i++)
    if (of[i]) replace_ends(plan, *of[i]);
}

void DefeTiedDEs::replace_ends(const defe::ConversionPlan &plan, List &list) const
{
  for (auto &p : list) {
    const auto *element = plan.converting(p.other);
    if (!element || p.of.discrete) continue;
    p.of.discrete = true;
    p.of.weight = defe::weights_of_des(p.of.weight);
    for (int k = 0; k < 4; k++)
      p.end[k] = static_cast<tagint>(plan.de_id(element->lot, defe::fe::hex_face[p.other_face][k]));
  }
}

/* ----------------------------------------------------------------------
   tables of local indices
------------------------------------------------------------------------- */

bool DefeTiedDEs::shape(int i, defe::GeneralCell &cell) const
{
  if (!on_ || !of[i]) return false;
  const auto &list = *of[i];
  for (auto first = list.begin(); first != list.end();) {
    const auto end = end_of_slot(first, list.end());
    const int s = first->slot;
    const JointRecord &slot = sys.store.de(i)->slot[s];
    const auto place = place_of(first, end, Vec3(slot.face).dot(Vec3(slot.normal)));
    Vec3 dX = Vec3(first->offset) - Vec3(sys.store.x_frame(i));
    const double *w = place.weight.data();
    for (auto p = first; p != end; ++p)
      for (tagint tag : p->end) dX += *w++ * Vec3(sys.store.x_frame(local_end(i, tag)));
    cell.dX[s] = dX;
    cell.face[s] = place.share * dX;
    cell.free &= ~(1u << s);
    first = end;
  }
  return true;
}

void DefeTiedDEs::add_places(JointTable &jt, int d)
{
  const int i = jt.self[d];
  if (!on_ || !of[i]) return;
  const auto &list = *of[i];
  for (auto first = list.begin(); first != list.end();) {
    const auto end = end_of_slot(first, list.end());
    const int s = first->slot;
    const JointRecord &slot = sys.store.de(i)->slot[s];
    const double depth = Vec3(slot.face).dot(Vec3(slot.normal));
    const auto place = place_of(first, end, depth);
    std::vector<int> particles;
    for (auto p = first; p != end; ++p) {
      for (tagint tag : p->end) particles.push_back(local_end(i, tag));
      holds.push_back({d, p->other_part, depth});
    }
    jt.add_place(d, s, particles, place.weight);
    first = end;
  }
}

double DefeTiedDEs::contact_distance(int d, int part) const
{
  double nearest = HUGE_VAL;
  auto at = std::lower_bound(holds.begin(), holds.end(), d, [](const Hold &h, int de) {
    return h.de < de;
  });
  for (; at != holds.end() && at->de == d; ++at)
    if (at->part == part) nearest = MIN(nearest, 0.5 * at->distance);
  return nearest;
}

const DefeTiedPiece &DefeTiedDEs::main_piece(int i, int slot) const
{
  const auto first = std::find_if(of[i]->cbegin(), of[i]->cend(), [slot](const DefeTiedPiece &p) {
    return p.slot == slot;
  });
  return *std::max_element(first, end_of_slot(first, of[i]->cend()),
                           [](const DefeTiedPiece &p, const DefeTiedPiece &q) {
                             return p.of.area < q.of.area;
                           });
}

/* ----------------------------------------------------------------------
   as a field of the store
------------------------------------------------------------------------- */

int DefeTiedDEs::size(int i) const
{
  return 1 + (of[i] ? PIECE * static_cast<int>(of[i]->size()) : 0);
}

int DefeTiedDEs::most() const
{
  return largest_size(atom->nlocal);
}

int DefeTiedDEs::pack(int i, double *buf) const
{
  int m = 0;
  buf[m++] = ubuf(of[i] ? static_cast<int>(of[i]->size()) : 0).d;
  if (!of[i]) return m;
  for (const auto &p : *of[i]) {
    for (tagint id : {p.own, p.other, p.end[0], p.end[1], p.end[2], p.end[3]})
      buf[m++] = ubuf(id).d;
    buf[m++] = p.of.area;
    buf[m++] = p.of.depth;
    for (double w : p.of.weight) buf[m++] = w;
    buf[m++] = ubuf(static_cast<int>(p.of.discrete)).d;
    for (double o : p.offset) buf[m++] = o;
    for (int k : {p.place, p.slot, p.other_face, p.other_part}) buf[m++] = ubuf(k).d;
  }
  return m;
}

int DefeTiedDEs::unpack(int i, const double *buf)
{
  int m = 0;
  const int count = static_cast<int>(ubuf(buf[m++]).i);
  of[i].reset();
  if (count > 0) of[i] = std::make_unique<List>(count);
  for (int c = 0; c < count; c++) {
    DefeTiedPiece &p = (*of[i])[c];
    for (tagint *id : {&p.own, &p.other, &p.end[0], &p.end[1], &p.end[2], &p.end[3]})
      *id = static_cast<tagint>(ubuf(buf[m++]).i);
    p.of.area = buf[m++];
    p.of.depth = buf[m++];
    for (double &w : p.of.weight) w = buf[m++];
    p.of.discrete = ubuf(buf[m++]).i != 0;
    for (double &o : p.offset) o = buf[m++];
    for (int *k : {&p.place, &p.slot, &p.other_face, &p.other_part})
      *k = static_cast<int>(ubuf(buf[m++]).i);
  }
  return m;
}
