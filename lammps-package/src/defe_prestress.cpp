/* ----------------------------------------------------------------------
   DEFE: adaptive finite elements to bonded discrete elements for LAMMPS
   https://www.lammps.org/
   This software is distributed under the GNU General Public License.
------------------------------------------------------------------------- */

#include "defe_prestress.h"

#include "defe_system.h"
#include "rendezvous.h"

#include "atom.h"
#include "comm.h"
#include "error.h"
#include "input.h"
#include "variable.h"

#include "defe/coupling/prestress_rule.h"
#include "defe/fe/hex8.h"
#include "defe/fe/periodic.h"

#include <algorithm>
#include <cmath>

using namespace LAMMPS_NS;
using defe::Mat3;
using defe::PrestressRule;
using defe::fe::HexCoords;
using Rendezvous::Letters;

static constexpr int KEPT_SIZE = 1 + 6;    // doubles: ID and stress
static constexpr int CHUNK = 16384;        // elements per round of messages
static constexpr int ROW[6] = {0, 1, 2, 0, 0, 1}, COLUMN[6] = {0, 1, 2, 1, 2, 2};

void DefePrestress::begin()
{
  on_ = std::any_of(sys.model.parts.begin(), sys.model.parts.end(), [](const DefePart &p) {
    return p.prestress.given();
  });
  if (on_) sys.store.add_field(this);
}

/* ----------------------------------------------------------------------
   elements have their stress from here on, whatever becomes of positions and variables
------------------------------------------------------------------------- */

void DefePrestress::mesh_made()
{
  if (!on_) return;
  for (size_t p = 0; p < sys.model.parts.size(); p++) {
    if (!sys.model.parts[p].prestress.given()) continue;
    const int part = static_cast<int>(p);
    const auto list = waiting(part);
    const int mine = list.empty() ? 0 : 1;
    int any = 0;
    MPI_Allreduce(&mine, &any, 1, MPI_INT, MPI_MAX, world);
    if (any) assign(part, list);
  }
}

DefePrestress::Waiting DefePrestress::waiting(int part) const
{
  Waiting list;
  for (int i = 0; i < atom->nlocal; i++)
    for (const auto &h : sys.store.hexes(i))
      if (h.part == part && !find(i, h.id)) list.emplace_back(i, &h);
  return list;
}

/* ----------------------------------------------------------------------
   values of the variables at the atoms of this rank; empty if there are none
------------------------------------------------------------------------- */

std::vector<std::array<double, 6>> DefePrestress::evaluate(int part) const
{
  const DefePart &p = sys.model.parts[part];
  if (p.prestress.kind != PrestressRule::VARIABLES) return {};
  std::vector<std::array<double, 6>> values(atom->nlocal, {0.0, 0.0, 0.0, 0.0, 0.0, 0.0});
  std::vector<double> one(atom->nlocal + 1);
  for (int k = 0; k < 6; k++) {
    const std::string &name = p.prestress.variable[k];
    if (name.empty()) continue;
    const int index = input->variable->find(name.c_str());
    if (index < 0)
      error->all(FLERR,
                 "Fix defe prestress {}: there is no variable {}: define it before the first run",
                 p.name, name);
    if (!input->variable->atomstyle(index))
      error->all(FLERR,
                 "Fix defe prestress {}: variable {} must be of style atom, as it is evaluated at "
                 "the nodes",
                 p.name, name);
    input->variable->compute_atom(index, 0, one.data(), 1, 0);
    for (int i = 0; i < atom->nlocal; i++) values[i][k] = one[i];
  }
  return values;
}

/* ----------------------------------------------------------------------
   an element learns of its nodes, which may be on other ranks, where their IDs are dealt to (a rendezvous)
------------------------------------------------------------------------- */

namespace {

struct NodeDatum {
  double x[3], stress[6];
  tagint tag;
};

struct NodeRequest {
  tagint tag;
  int proc, element, corner;
};

struct NodeReply {
  double x[3], stress[6];
  int element, corner;
};

}    // namespace

struct DefePrestress::Sums {
  double energy = 0.0, elements = 0.0;
  double low = HUGE_VAL, high = -HUGE_VAL;    // extent across the pane
  double strain = 0.0;                        // the largest, and of which element
  tagint element = MAXTAGINT;
};

void DefePrestress::assign(int part, const Waiting &list)
{
  const DefePart &p = sys.model.parts[part];
  const auto &elastic = sys.model.material_of(p).elastic();
  const bool parabola = p.prestress.kind == PrestressRule::PARABOLA;
  const auto values = evaluate(part);
  Letters<NodeDatum> letters(lmp);
  for (int i = 0; i < atom->nlocal; i++) {
    NodeDatum datum{};
    std::copy_n(sys.store.x_ref(i), 3, datum.x);
    if (!values.empty()) std::copy_n(values[i].data(), 6, datum.stress);
    datum.tag = atom->tag[i];
    letters.to_id(datum.tag, datum);
  }
  auto nodes = letters.send();
  const auto before = [](const NodeDatum &a, const NodeDatum &b) {
    return a.tag < b.tag;
  };
  std::sort(nodes.begin(), nodes.end(), before);

  const int n = static_cast<int>(list.size()), mine = n / CHUNK + 1;
  int rounds = 1;
  MPI_Allreduce(&mine, &rounds, 1, MPI_INT, MPI_MAX, world);
  Sums sums;
  for (int round = 0; round < rounds; round++) {
    const int first = MIN(n, round * CHUNK), last = MIN(n, first + CHUNK);
    Letters<NodeRequest> requests(lmp);
    for (int e = first; e < last; e++)
      for (int a = 0; a < 8; a++) {
        const tagint tag = list[e].second->node[a];
        requests.to_id(tag, {tag, comm->me, e - first, a});
      }
    Letters<NodeReply> replies(lmp);
    for (const auto &r : requests.send()) {
      NodeReply reply{};
      NodeDatum wanted{};
      wanted.tag = r.tag;
      const auto found = std::lower_bound(nodes.begin(), nodes.end(), wanted, before);
      if (found == nodes.end() || found->tag != r.tag)
        error->one(FLERR, "Fix defe prestress {}: node {} of an element does not exist", p.name,
                   r.tag);
      std::copy_n(found->x, 3, reply.x);
      std::copy_n(found->stress, 6, reply.stress);
      reply.element = r.element;
      reply.corner = r.corner;
      replies.to_rank(r.proc, reply);
    }
    std::vector<std::array<NodeReply, 8>> corners(last - first);
    for (const auto &r : replies.send()) corners[r.element][r.corner] = r;
    for (int e = first; e < last; e++) {
      HexCoords X;
      Mat3 stress = Mat3::Zero();
      for (int a = 0; a < 8; a++) {    // in this order on all ranks
        const NodeReply &node = corners[e - first][a];
        for (int k = 0; k < 3; k++) X(k, a) = node.x[k];
        for (int k = 0; k < 6; k++) stress(ROW[k], COLUMN[k]) += 0.125 * node.stress[k];
      }
      defe::fe::join_across_border(X, sys.mesh.periods());
      stress = Mat3(stress.selfadjointView<Eigen::Upper>());
      if (parabola) {
        const auto &pane = p.prestress.parabola;
        stress = pane.over(X);
        sums.low = MIN(sums.low, X.row(pane.axis).minCoeff());
        sums.high = MAX(sums.high, X.row(pane.axis).maxCoeff());
      }
      keep(list[e].first, *list[e].second, stress, elastic, sums);
      sums.energy += defe::fe::energy_of_stress(stress, elastic) * defe::fe::volume(X);
      sums.elements += 1.0;
    }
  }
  tell(part, sums);
}

void DefePrestress::keep(int i, const HexRecord &h, const Mat3 &stress,
                         const defe::fe::IsotropicElastic &elastic, Sums &sums)
{
  const double norm = defe::fe::strain_of_stress(stress, elastic).norm();
  const double strain = std::isfinite(norm) ? norm : HUGE_VAL;
  if (strain > sums.strain || (strain == sums.strain && h.id < sums.element)) sums.element = h.id;
  sums.strain = MAX(sums.strain, strain);
  add(i, {h.id, defe::fe::rounded_stress(stress, elastic), Mat3::Identity(), false});
}

/* ----------------------------------------------------------------------
   what was found, of all ranks
------------------------------------------------------------------------- */

void DefePrestress::tell(int part, const Sums &mine) const
{
  const DefePart &p = sys.model.parts[part];
  double strain = 0.0;
  MPI_Allreduce(&mine.strain, &strain, 1, MPI_DOUBLE, MPI_MAX, world);
  const tagint its = mine.strain == strain ? mine.element : MAXTAGINT;
  tagint element = 0;
  MPI_Allreduce(&its, &element, 1, MPI_LMP_TAGINT, MPI_MIN, world);
  if (!(strain <= defe::largest_prestrain))
    error->all(FLERR,
               "Fix defe prestress {}: element {} would have a strain of {:.3g}, more than {}: "
               "give stresses in the units of the script",
               p.name, element, strain, defe::largest_prestrain);
  const double sums[2] = {mine.energy, mine.elements}, most[2] = {mine.high, -mine.low};
  double all[2], extent[2];
  MPI_Allreduce(sums, all, 2, MPI_DOUBLE, MPI_SUM, world);
  MPI_Allreduce(most, extent, 2, MPI_DOUBLE, MPI_MAX, world);
  const auto &pane = p.prestress.parabola;
  const double slack = 1.0e-6 * (pane.upper - pane.lower);
  if (p.prestress.kind == PrestressRule::PARABOLA &&
      !(std::abs(extent[0] - pane.upper) <= slack && std::abs(extent[1] + pane.lower) <= slack))
    error->all(FLERR,
               "Fix defe prestress {}: the part reaches from {:.8g} to {:.8g} along {}, not from "
               "{:.8g} to {:.8g}: the stress would not be in equilibrium",
               p.name, -extent[1], extent[0], "xyz"[pane.axis], pane.lower, pane.upper);
  if (comm->me == 0)
    utils::logmesg(lmp,
                   "Fix defe: prestress of part {}: {}, in {} elements, stored energy {:.6g}\n",
                   p.name, p.prestress.words(), static_cast<bigint>(all[1]), all[0]);
}

/* ----------------------------------------------------------------------
   Stable steps are those of the reference shape. Volume, lengths and stiffness of the stress-free one differ by some
   times the strain, and so does what the stress itself adds to the stiffness.
------------------------------------------------------------------------- */

double DefePrestress::step_factor() const
{
  if (!on_) return 1.0;
  double mine = 0.0, most = 0.0;
  for (int i = 0; i < atom->nlocal; i++) {
    if (!of[i]) continue;
    for (const auto &h : sys.store.hexes(i)) {
      const Mat3 *stress = of_element(i, h);
      if (!stress) continue;
      const auto &elastic = sys.model.material_of(sys.model.parts[h.part]).elastic();
      mine = MAX(mine, defe::fe::strain_of_stress(*stress, elastic).norm());
    }
  }
  MPI_Allreduce(&mine, &most, 1, MPI_DOUBLE, MPI_MAX, world);
  return 1.0 - 3.0 * most;
}

/* ---------------------------------------------------------------------- */

DefePrestress::Kept *DefePrestress::find(int i, tagint element) const
{
  if (!on_ || i < 0 || !of[i]) return nullptr;
  for (auto &one : *of[i])
    if (one.element == element) return &one;
  return nullptr;
}

const Mat3 *DefePrestress::of_element(int i, const HexRecord &h) const
{
  const Kept *kept = find(i, h.id);
  return kept ? &kept->stress : nullptr;
}

const Mat3 *DefePrestress::of_de(int i) const
{
  const Kept *kept = find(i, 0);
  return kept ? &kept->stress : nullptr;
}

const Mat3 &DefePrestress::map_of_element(int i, const HexRecord &h, const DefeBatch &b)
{
  Kept &kept = *find(i, h.id);
  if (!kept.mapped) kept.map = b.stress_free_map(kept.stress);
  kept.mapped = true;
  return kept.map;
}

Mat3 DefePrestress::map_of_de(int i)
{
  Kept *kept = find(i, 0);
  if (!kept) return Mat3::Identity();
  const DefePart &p = sys.model.parts[sys.store.de(i)->part];
  if (!kept->mapped)
    kept->map = defe::fe::stress_free_map(kept->stress, sys.model.material_of(p).elastic());
  kept->mapped = true;
  return kept->map;
}

void DefePrestress::set_de(int i, const Mat3 &stress)
{
  of[i] = std::make_unique<List>();
  of[i]->push_back({0, stress, Mat3::Identity(), false});
}

void DefePrestress::remove(int i, tagint element)
{
  if (!on_ || !of[i]) return;
  drop_if(i, [element](const Kept &one) {
    return one.element == element;
  });
}

/* ----------------------------------------------------------------------
   as a field of the store
------------------------------------------------------------------------- */

int DefePrestress::size(int i) const
{
  return 1 + (of[i] ? KEPT_SIZE * static_cast<int>(of[i]->size()) : 0);
}

int DefePrestress::most() const
{
  return 1 + KEPT_SIZE * sys.mesh.hexes_per_node();
}

int DefePrestress::pack(int i, double *buf) const
{
  int m = 0;
  buf[m++] = ubuf(of[i] ? static_cast<int>(of[i]->size()) : 0).d;
  if (!of[i]) return m;
  for (const auto &one : *of[i]) {
    buf[m++] = ubuf(one.element).d;
    for (int k = 0; k < 6; k++) buf[m++] = one.stress(ROW[k], COLUMN[k]);
  }
  return m;
}

int DefePrestress::unpack(int i, const double *buf)
{
  int m = 0;
  const int count = static_cast<int>(ubuf(buf[m++]).i);
  of[i].reset();
  if (count > 0) of[i] = std::make_unique<List>();
  for (int n = 0; n < count; n++) {
    Kept one;
    one.element = static_cast<tagint>(ubuf(buf[m++]).i);
    for (int k = 0; k < 6; k++)
      one.stress(ROW[k], COLUMN[k]) = one.stress(COLUMN[k], ROW[k]) = buf[m++];
    of[i]->push_back(one);
  }
  return m;
}
