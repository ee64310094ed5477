/* ----------------------------------------------------------------------
   DEFE: adaptive finite elements to bonded discrete elements for LAMMPS
   https://www.lammps.org/
   This software is distributed under the GNU General Public License.
------------------------------------------------------------------------- */

#include "defe_system.h"

#include "atom.h"
#include "domain.h"
#include "error.h"
#include "fix.h"
#include "memory.h"
#include "update.h"

#include <algorithm>
#include <cstring>

using namespace LAMMPS_NS;

static constexpr int HEX_SIZE = doubles_of(sizeof(HexPod));
static constexpr int FACE_SIZE = doubles_of(sizeof(FaceContact));
static constexpr int SPHERE_SIZE = doubles_of(sizeof(SphereContact));
static constexpr int CRACK_SIZE = doubles_of(sizeof(JointCrack));
static constexpr int MAX_SHIELDS = 27;    // of an element: its neighbours, one more for a while

namespace {

template <class T> int put(double *buf, const T &data)
{
  memcpy(static_cast<void *>(buf), &data, sizeof(T));
  return doubles_of(sizeof(T));
}

template <class T> int take(const double *buf, T &data)
{
  memcpy(static_cast<void *>(&data), buf, sizeof(T));
  return doubles_of(sizeof(T));
}

template <class T> int put_all(double *buf, const std::vector<T> &list)
{
  int m = 0;
  for (const auto &one : list) m += put(&buf[m], one);
  return m;
}

template <class T> int take_all(const double *buf, std::vector<T> &list)
{
  int m = 0;
  for (auto &one : list) m += take(&buf[m], one);
  return m;
}

double packed(size_t n)
{
  return ubuf(static_cast<int>(n)).d;
}

int count(double number)
{
  return static_cast<int>(ubuf(number).i);
}

}    // namespace

/* ----------------------------------------------------------------------
   reference positions, and how many elements are at a node
------------------------------------------------------------------------- */

void DefeStore::Frames::grow(int n)
{
  memory->grow(ref, n, 3, "defe:xref");
  memory->grow(now, n, 3, "defe:xframe");
  memory->grow(elements, n, "defe:nelem");
}

void DefeStore::Frames::move(int from, int to)
{
  for (int k = 0; k < 3; k++) {
    ref[to][k] = ref[from][k];
    now[to][k] = now[from][k];
  }
  elements[to] = elements[from];
}

int DefeStore::Frames::pack(int i, double *buf) const
{
  for (int k = 0; k < 3; k++) buf[k] = ref[i][k];
  buf[3] = ubuf(elements[i]).d;
  return SIZE;
}

int DefeStore::Frames::unpack(int i, const double *buf)
{
  for (int k = 0; k < 3; k++) ref[i][k] = now[i][k] = buf[k];
  elements[i] = count(buf[3]);
  return SIZE;
}

/* ----------------------------------------------------------------------
   DEs, with what only some of them have
------------------------------------------------------------------------- */

static constexpr int DE_SIZE = doubles_of(sizeof(DEPod)) + doubles_of(sizeof(DERecord::slot));
static constexpr int SOFT_SIZE = doubles_of(sizeof(defe::SoftJoints));
static constexpr int TIE_SIZE = doubles_of(sizeof(TieNodes));
static constexpr unsigned IS_DE = 1, WITH_SOFT = 2, WITH_TIE = 4;

int DefeStore::DEs::most() const
{
  return 1 + DE_SIZE + SOFT_SIZE + TIE_SIZE;
}

int DefeStore::DEs::size(int i) const
{
  if (!of[i]) return 1;
  return 1 + DE_SIZE + (of[i]->soft ? SOFT_SIZE : 0) + (of[i]->tie ? TIE_SIZE : 0);
}

int DefeStore::DEs::pack(int i, double *buf) const
{
  const DERecord *r = of[i].get();
  buf[0] = packed(!r ? 0u : IS_DE | (r->soft ? WITH_SOFT : 0u) | (r->tie ? WITH_TIE : 0u));
  if (!r) return 1;
  int m = 1 + put(&buf[1], static_cast<const DEPod &>(*r));
  m += put(&buf[m], r->slot);
  if (r->soft) m += put(&buf[m], *r->soft);
  if (r->tie) m += put(&buf[m], *r->tie);
  return m;
}

int DefeStore::DEs::unpack(int i, const double *buf)
{
  const auto what = static_cast<unsigned>(count(buf[0]));
  of[i].reset();
  if (!what) return 1;
  set(i, std::make_unique<DERecord>());
  DERecord &r = *of[i];
  int m = 1 + take(&buf[1], static_cast<DEPod &>(r));
  m += take(&buf[m], r.slot);
  if (what & WITH_SOFT) {
    r.soft = std::make_unique<defe::SoftJoints>();
    m += take(&buf[m], *r.soft);
  }
  if (what & WITH_TIE) {
    r.tie = std::make_unique<TieNodes>();
    m += take(&buf[m], *r.tie);
  }
  return m;
}

/* ----------------------------------------------------------------------
   contacts, and cracks of joints
------------------------------------------------------------------------- */

static int size_of_contacts(const AtomContacts &t)
{
  return FACE_SIZE * static_cast<int>(t.faces.size()) +
      SPHERE_SIZE * static_cast<int>(t.spheres.size()) +
      CRACK_SIZE * static_cast<int>(t.cracks.size());
}

static constexpr int CONTACTS_HEAD = 3;

int DefeStore::Contacts::size(int i) const
{
  return CONTACTS_HEAD + (of[i] ? size_of_contacts(*of[i]) : 0);
}

int DefeStore::Contacts::most() const
{
  int most = 0;
  for (int i : places(atom->nlocal)) most = MAX(most, size_of_contacts(*of[i]));
  return CONTACTS_HEAD + most;
}

int DefeStore::Contacts::pack(int i, double *buf) const
{
  const AtomContacts *t = of[i].get();
  int m = 0;
  buf[m++] = packed(t ? t->faces.size() : 0u);
  buf[m++] = packed(t ? t->spheres.size() : 0u);
  buf[m++] = packed(t ? t->cracks.size() : 0u);
  if (!t) return m;
  m += put_all(&buf[m], t->faces);
  m += put_all(&buf[m], t->spheres);
  m += put_all(&buf[m], t->cracks);
  return m;
}

int DefeStore::Contacts::unpack(int i, const double *buf)
{
  int m = 0;
  const int faces = count(buf[m++]);
  const int spheres = count(buf[m++]);
  const int cracks = count(buf[m++]);
  of[i].reset();
  if (faces + spheres + cracks == 0) return m;
  AtomContacts &t = at(i);
  t.faces.resize(faces);
  t.spheres.resize(spheres);
  t.cracks.resize(cracks);
  m += take_all(&buf[m], t.faces);
  m += take_all(&buf[m], t.spheres);
  m += take_all(&buf[m], t.cracks);
  return m;
}

/* ----------------------------------------------------------------------
   elements, with their shields and the histories of their materials
------------------------------------------------------------------------- */

void DefeStore::Elements::move(int from, int to)
{
  of[to] = std::move(of[from]);
  of[from].clear();
}

int DefeStore::Elements::size(int i) const
{
  int n = 1;
  for (const auto &h : of[i]) {
    n += HEX_SIZE + 2;
    if (h.extra) n += static_cast<int>(4 * h.extra->shields.size() + h.extra->history.size());
  }
  return n;
}

int DefeStore::Elements::most() const
{
  return 1 +
      sys->mesh.hexes_per_node() * (HEX_SIZE + 2 + 4 * MAX_SHIELDS + sys->elements.history_most());
}

int DefeStore::Elements::pack(int i, double *buf) const
{
  int m = 0;
  buf[m++] = packed(of[i].size());
  for (const auto &h : of[i]) {
    m += put(&buf[m], static_cast<const HexPod &>(h));
    buf[m++] = packed(h.extra ? h.extra->shields.size() : 0u);
    buf[m++] = packed(h.extra ? h.extra->history.size() : 0u);
    if (!h.extra) continue;
    for (const auto &s : h.extra->shields) {
      for (int k = 0; k < 3; k++) buf[m++] = s.direction[k];
      buf[m++] = s.time;
    }
    for (double q : h.extra->history) buf[m++] = q;
  }
  return m;
}

int DefeStore::Elements::unpack(int i, const double *buf)
{
  int m = 0;
  const int n = count(buf[m++]);
  of[i].clear();
  for (int e = 0; e < n; e++) {
    HexRecord h;
    m += take(&buf[m], static_cast<HexPod &>(h));
    const int shields = count(buf[m++]);
    const int history = count(buf[m++]);
    for (int s = 0; s < shields; s++) {
      defe::Shield shield;
      for (int k = 0; k < 3; k++) shield.direction[k] = buf[m++];
      shield.time = buf[m++];
      h.with_extra().shields.push_back(shield);
    }
    if (history) {
      h.with_extra().history.assign(buf + m, buf + m + history);
      m += history;
    }
    of[i].push_back(std::move(h));
  }
  return m;
}

/* ---------------------------------------------------------------------- */

DefeStore::DefeStore(DefeSystem &system) : DefeComponent(system)
{
  frames.memory = memory;
  contacts.atom = atom;
  elements.sys = &sys;
  fields = {&frames, &contacts, &des, &elements};
}

DefeStore::~DefeStore()
{
  memory->destroy(frames.ref);
  memory->destroy(frames.now);
  memory->destroy(frames.elements);
}

void DefeStore::add_field(DefeField *field)
{
  fields.push_back(field);
}

void DefeStore::grow(int n)
{
  for (auto *field : fields) field->grow(n);
  changed_at.resize(n, 0);
}

void DefeStore::touch(int i)
{
  if (changed_at[i]) return;
  changed_at[i] = 1;
  changed_list.push_back(i);
}

void DefeStore::settle()
{
  for (int i : changed_list)
    if (i < static_cast<int>(changed_at.size())) changed_at[i] = 0;
  changed_list.clear();
}

void DefeStore::move(int from, int to)
{
  for (auto *field : fields) field->move(from, to);
  touch(to);
}

/* ---------------------------------------------------------------------- */

void DefeStore::clear(int i)
{
  touch(i);
  contacts.clear(i);
  sys.kept.clear(i);
  sys.strengths.clear(i);
  sys.prestress.clear(i);
  sys.tied.clear(i);
  sys.tied_des.clear(i);
  if (update->whichflag == 1 && !sys.ids.giving_birth()) sys.ids.register_newcomer(i);

  // read_data sets the arrays of new atoms after it has read the sections: keep the elements

  frames.elements[i] = 0;
  des.clear(i);
  const bool came = i < static_cast<int>(just_read.size()) && just_read[i];
  if (came)
    just_read[i] = 0;
  else
    hexes(i).clear();    // left by an atom that was deleted
  set_reference(i, atom->x[i]);
  if (reading) domain->unmap(atom->x[i], atom->image[i], frames.ref[i]);
}

void DefeStore::forget(int i)
{
  touch(i);
  hexes(i).clear();
  des.clear(i);
  contacts.clear(i);
  sys.strengths.clear(i);
  sys.prestress.clear(i);
  sys.tied.clear(i);
  sys.tied_des.clear(i);
}

void DefeStore::set_reference(int i, const double *x)
{
  for (int k = 0; k < 3; k++) frames.ref[i][k] = frames.now[i][k] = x[k];
}

AtomContacts &DefeStore::contacts_at(int i)
{
  return contacts.at(i);
}

const std::vector<int> &DefeStore::contact_atoms() const
{
  return contacts.places(atom->nlocal);
}

const std::vector<int> &DefeStore::de_atoms() const
{
  return des.places(atom->nlocal);
}

bool DefeStore::is_loose(int i) const
{
  const DERecord *r = de(i);
  return r && std::all_of(std::begin(r->slot), std::end(r->slot), [](const JointRecord &slot) {
           return slot.kind == DefeJoint::NONE || slot.state == DefeJoint::CONTACT;
         });
}

/* ----------------------------------------------------------------------
   LAMMPS makes the arrays of atoms that it reads after the sections: what these brought must be kept. Slots
   above nlocal may hold leftovers of atoms that moved away.
------------------------------------------------------------------------- */

void DefeStore::begin_reading()
{
  reading = true;
  for (int i = atom->nlocal; i < atom->nmax; i++) {
    hexes(i).clear();
    des.of[i].reset();
  }
}

void DefeStore::end_reading()
{
  reading = false;
  just_read.clear();
}

void DefeStore::came_with_file(int i)
{
  if (static_cast<int>(just_read.size()) <= i) just_read.resize(atom->nmax, 0);
  just_read[i] = 1;
}

/* ---------------------------------------------------------------------- */

int DefeStore::record_size(int i) const
{
  int n = 1;
  for (const auto *field : fields) n += field->size(i);
  return n;
}

int DefeStore::pack(int i, double *buf) const
{
  int m = 1;
  for (const auto *field : fields) m += field->pack(i, &buf[m]);
  buf[0] = m;
  return m;
}

int DefeStore::unpack(int i, const double *buf)
{
  int m = 1;
  touch(i);
  for (auto *field : fields) m += field->unpack(i, &buf[m]);
  return m;
}

void DefeStore::update_maxexchange()
{
  int n = 1;
  for (const auto *field : fields) n += field->most();
  sys.host->maxexchange = n;
}

double DefeStore::memory_usage() const
{
  double bytes = static_cast<double>(atom->nmax) *
      (6 * sizeof(double) + sizeof(int) + sizeof(elements.of[0]) + sizeof(des.of[0]) +
       sizeof(contacts.of[0]));
  for (int i = 0; i < atom->nlocal; i++) {
    bytes += hexes(i).capacity() * sizeof(HexRecord);
    if (const DERecord *r = de(i))
      bytes += sizeof(*r) + (r->soft ? sizeof(*r->soft) : 0) + (r->tie ? sizeof(*r->tie) : 0);
  }
  return bytes;
}
