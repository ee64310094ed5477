/* ----------------------------------------------------------------------
   DEFE: adaptive finite elements to bonded discrete elements for LAMMPS
   https://www.lammps.org/
   This software is distributed under the GNU General Public License.
------------------------------------------------------------------------- */

// Contact of surfaces: the forces in coupling (surface_forces.h) on what the search has found, and what is
// booked of them. Forces on balls of other ranks go back with their ghosts.

#include "defe_system.h"

#include "defe_surface_search.h"

#include "atom.h"
#include "neighbor.h"
#include "update.h"

#include "defe/coupling/surface_contact.h"

#include <algorithm>
#include <cmath>
#include <tuple>

using namespace LAMMPS_NS;
using defe::Vec3;

// overlaps from before the first step are eased out within this many stable steps of the elements
static constexpr double EASE_STEPS = 2000.0;

namespace {

/** Contacts of an atom from step to step. */
class ContactRecords : public defe::ContactMemory {
 public:
  ContactRecords(DefeSystem &s, std::vector<char> &all,
                 const std::vector<defe::ConvertingHex> &gone_now) :
      sys(s),
      met(all), gone(gone_now)
  {
  }
  defe::ContactHistory *find(int i, int part) override
  {
    if (!met[i]) return nullptr;
    AtomContacts *t = sys.store.contacts_of(i);
    if (t)
      for (auto &face : t->faces)
        if (face.part == part) return &face;
    return nullptr;
  }
  defe::ContactHistory &make(int i, int part) override
  {
    met[i] = 1;
    auto &list = sys.store.contacts_at(i).faces;
    list.emplace_back();
    list.back().part = part;
    return list.back();
  }
  void drop(int i, int part) override
  {
    auto &list = sys.store.contacts_at(i).faces;
    for (auto &face : list)
      if (face.part == part) {
        face = list.back();
        list.pop_back();
        return;
      }
  }
  bool tied(int i, std::int64_t element) override
  {
    return sys.joints.tied(i, static_cast<tagint>(element));
  }
  bool newborn(int i) override
  {
    const DERecord *r = sys.store.de(i);
    return r && r->fresh;
  }
  bool inherits(int i, int part) override
  {
    // a DE that was an element with this contact a step ago
    if (newborn(i) && sys.store.de(i)->part != part) return true;
    // a tie that broke by shear while it was pressed
    const auto &jt = sys.joints;
    for (int ds : jt.debonded)
      if (jt.self[ds / 6] == i && jt.rec(ds / 6)->slot[ds % 6].part == part) return true;
    return false;
  }
  bool was_joined(int i, const defe::ContactFacet &facet) override
  {
    if (gone.empty() || !newborn(i)) return false;
    const tagint element = sys.store.de(i)->element;
    const auto at = std::lower_bound(gone.begin(), gone.end(), element,
                                     [](const defe::ConvertingHex &c, tagint id) {
                                       return c.id < id;
                                     });
    if (at == gone.end() || at->id != element) return false;
    tagint node[4];
    for (int k = 0; k < 4; k++) node[k] = sys.lmp->atom->tag[facet.node[k]];
    return at->has_node_of(node, 4);
  }

 private:
  DefeSystem &sys;
  std::vector<char> &met;
  const std::vector<defe::ConvertingHex> &gone;    // in this step, by ID
};

}    // namespace

DefeSurface::DefeSurface(DefeSystem &system) : DefeComponent(system) {}
DefeSurface::~DefeSurface() = default;

/* ---------------------------------------------------------------------- */

void DefeSurface::build()
{
  forget();
  fresh = sys.tables.fresh();
  if (!sys.model.contact()) return;
  if (!search) search = std::make_unique<DefeSurfaceSearch>(sys);
  search->run(tables);
  pack_facet_nodes();
  planes_fresh = true;
  met.assign(atom->nlocal, 0);
  std::vector<std::pair<int, int>> goes_on;    // contacts: atom and part
  for (const auto &p : tables.points) {
    const AtomContacts *t = sys.store.contacts_of(p.atom);
    met[p.atom] = t && !t->faces.empty();
    if (met[p.atom]) goes_on.emplace_back(p.atom, p.part);
  }
  std::sort(goes_on.begin(), goes_on.end());
  end_contacts_but(goes_on);
}

/* ----------------------------------------------------------------------
   the face that a point touched has converted, and there is no other one near
------------------------------------------------------------------------- */

void DefeSurface::end_contacts_but(const std::vector<std::pair<int, int>> &goes_on)
{
  for (int i : sys.store.contact_atoms()) {
    auto &faces = sys.store.contacts_of(i)->faces;
    const auto ends = [&](const FaceContact &face) {
      if (std::binary_search(goes_on.begin(), goes_on.end(), std::make_pair(i, face.part)))
        return false;
      sys.ledger.friction += face.tangential.stored();
      return true;
    };
    faces.erase(std::remove_if(faces.begin(), faces.end(), ends), faces.end());
  }
}

void DefeSurface::forget()
{
  tables.clear();
  facet_nodes.clear();
  near.forget();
}

/* ----------------------------------------------------------------------
   the facets at the current positions
------------------------------------------------------------------------- */

void DefeSurface::pack_facet_nodes()
{
  facet_nodes.clear();
  for (const auto &f : tables.facets)
    facet_nodes.push_back({f.node[0], f.node[1], f.node[2], f.node[3]});
}

void DefeSurface::update_planes()
{
  const int n = static_cast<int>(tables.facets.size());
  tables.planes.resize(n);
  if (n)
    defe::facet_planes(n, reinterpret_cast<const int(*)[4]>(facet_nodes.data()), &atom->x[0][0],
                       tables.planes.data());
}

/* ---------------------------------------------------------------------- */

const defe::ContactPairs &DefeSurface::near_pairs(defe::ContactMemory &memory)
{
  return near.find(tables, atom->nlocal + atom->nghost > 0 ? &atom->x[0][0] : nullptr, memory,
                   neighbor->skin);
}

/* ---------------------------------------------------------------------- */

double DefeSurface::reach_of(int i) const
{
  const double reach = sys.tables.outer_reach()[i];
  return reach > 0.0 ? reach : atom->radius[i];
}

double DefeSurface::ball_stiffness(int part, int i) const
{
  const auto &m = sys.model.material_of(sys.model.parts[part]);
  return sys.model.contact_factor * m.elastic().bulk() * sys.tables.outer_length()[i];
}

/* ---------------------------------------------------------------------- */

defe::SurfaceArrays DefeSurface::arrays(bool virial) const
{
  defe::SurfaceArrays a;
  const bool any = atom->nlocal + atom->nghost > 0;
  a.x = any ? &atom->x[0][0] : nullptr;
  a.v = any ? &atom->v[0][0] : nullptr;
  a.f = any ? &atom->f[0][0] : nullptr;
  a.omega = any ? &atom->omega[0][0] : nullptr;
  a.torque = any ? &atom->torque[0][0] : nullptr;
  a.radius = atom->radius;
  a.mass = atom->rmass;
  a.dt = update->dt;
  a.friction = sys.model.contact_friction;
  a.moving = !update->setupflag && update->whichflag != 2;
  a.minimizing = !update->setupflag && update->whichflag == 2;
  a.virial = virial;
  a.force_grid = sys.sums.force_grid();
  a.torque_grid = sys.sums.torque_grid();
  a.ease = sys.mesh.dt_finite() > 0.0 ? MIN(1.0, update->dt / (EASE_STEPS * sys.mesh.dt_finite()))
                                      : 0.0;
  return a;
}

/* ----------------------------------------------------------------------
   forces, onto owned and ghost atoms
------------------------------------------------------------------------- */

void DefeSurface::forces(double *virial)
{
  if (!planes_fresh) update_planes();
  planes_fresh = false;
  ContactRecords memory(sys, met, search->gone);
  auto a = arrays(virial != nullptr);
  a.changed = to_book;
  const auto r = defe::surface_forces(tables, a, memory, &near_pairs(memory));
  energy_ = r.energy + r.springs;
  if (r.beyond >= 0) sys.sums.set_beyond(r.beyond);
  sys.ledger.friction += r.friction;
  sys.ledger.external += r.eased;
  for (int k = 0; k < 6 && virial; k++) virial[k] += r.virial[k];
  book(r);
  if (to_book) {
    sys.ledger.conv_strain -= r.energy - r.eased;
    to_book = false;
  }
  note_overlaps(r, a.moving);
  for (int d : fresh) sys.joints.rec(d)->fresh = 0;
  fresh.clear();
  search->gone.clear();
}

/* ----------------------------------------------------------------------
   energies that an evaluation of contacts has found to be lost, or to come from elsewhere
------------------------------------------------------------------------- */

void DefeSurface::book(const defe::SurfaceResult &r)
{
  // what a broken tie held is still here
  for (const auto &one : r.inherited)
    if (!sys.store.de(one.atom)->fresh) sys.ledger.release -= one.energy;
  for (const auto &t : r.let_through) {
    sys.ledger.through += t.energy;
    if (t.counts) note_let_through(t.atom, t.depth);
  }
}

/* ----------------------------------------------------------------------
   energy of contact at the current positions, with the tables from before the conversion
------------------------------------------------------------------------- */

void DefeSurface::begin_conversion()
{
  if (!sys.model.contact()) return;
  if (!search) search = std::make_unique<DefeSurfaceSearch>(sys);    // at the start of a run
  update_planes();
  planes_fresh = false;
  ContactRecords memory(sys, met, search->gone);
  auto a = arrays(false);
  a.energy_only = true;
  const auto r = defe::surface_forces(tables, a, memory, &near_pairs(memory));
  book(r);
  sys.ledger.conv_strain += r.energy;
  to_book = true;
}

/* ---------------------------------------------------------------------- */

void DefeSurface::elements_gone(const std::vector<defe::ConvertingHex> &all)
{
  if (!search) return;
  search->gone = all;
  search->beside.clear();
}

void DefeSurface::element_beside(const HexRecord &h)
{
  if (search) search->beside.emplace_back(h.node[0], h.id);
}

/* ----------------------------------------------------------------------
   energy of balls on the quarters of elements of this rank that convert now, by element and corner node:
   their DEs take it over
------------------------------------------------------------------------- */

void DefeSurface::ball_shares(const defe::ConversionPlan &plan,
                              std::vector<BallShare> &shares) const
{
  for (const auto &pair : tables.balls) {
    const auto &facet = tables.facets[pair.facet];
    const auto element = static_cast<tagint>(facet.element);
    if (!facet.outer || !plan.converting(element)) continue;
    Vec3 force = Vec3::Zero();
    defe::FacetLoad load;
    const auto r =
        defe::ball_on_facet(Vec3(atom->x[pair.atom]), atom->radius[pair.atom],
                            tables.planes[pair.facet], facet.k_area, facet.area, force, load);
    for (int q = 0; q < 4; q++)
      if (r.quarter[q] > 0.0)
        shares.push_back({element, atom->tag[facet.node[q]], atom->tag[pair.atom], r.quarter[q],
                          r.quarter_push[q]});
  }
  // several faces of one DE may have met the same ball
  std::sort(shares.begin(), shares.end(), [](const BallShare &a, const BallShare &b) {
    return std::tie(a.element, a.node, a.ball) < std::tie(b.element, b.node, b.ball);
  });
}
