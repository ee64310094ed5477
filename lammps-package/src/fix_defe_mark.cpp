/* ----------------------------------------------------------------------
   DEFE: adaptive finite elements to bonded discrete elements for LAMMPS
   https://www.lammps.org/
   This software is distributed under the GNU General Public License.

   Which elements convert: their criterion, and shields.
------------------------------------------------------------------------- */

#include "fix_defe.h"

#include "error.h"

#include "defe/fe/hex8.h"

using namespace LAMMPS_NS;
using defe::Vec3;
using defe::fe::HexCoords;

/* ----------------------------------------------------------------------
   the criterion of a part, as in the script; returns the number of words that belong to it
------------------------------------------------------------------------- */

int FixDefe::set_criterion(Part &p, const std::vector<std::string> &words)
{
  const auto parsed = defe::parse_criterion(words, material_of(p).elastic());
  if (!parsed.complaint.empty())
    error->all(FLERR, "Fix defe convert {}: {}", p.name, parsed.complaint);
  p.criterion = parsed.criterion;
  p.stress = p.criterion->tensile_stress();
  p.criterion_words = parsed.entry == defe::conversion_criteria().front() ? "" : parsed.entry->name;
  for (double number : p.criterion->numbers())
    p.criterion_words += fmt::format("{}{}", p.criterion_words.empty() ? "" : " ", number);
  return parsed.used;
}

/* ----------------------------------------------------------------------
   the criterion's value of an element, at its centre or the largest of its Gauss points
------------------------------------------------------------------------- */

double FixDefe::criterion_value(const Batch &b, int e, Vec3 &direction) const
{
  const auto &criterion = *parts[kernels[b.kernel].part].criterion;
  const auto &kernel = *kernels[b.kernel].kernel;
  HexCoords x, X;
  hex_coords(b.node[e].data(), x, X);
  if (!gauss_stress) return criterion.value(kernel.stress(x, X, Vec3::Zero()), direction);
  double largest = -1.0e300;
  for (const auto &xi : defe::fe::gauss_points()) {
    Vec3 here;
    const double value = criterion.value(kernel.stress(x, X, xi), here);
    if (value <= largest) continue;
    largest = value;
    direction = here;
  }
  return largest;
}

/* ----------------------------------------------------------------------
   must it wait for what a crack beside it will do? Shields that have had their time are dropped.
------------------------------------------------------------------------- */

bool FixDefe::is_shielded(HexRecord &h, const Part &p, double value, const Vec3 &direction) const
{
  if (!shield || !h.extra || h.extra->shields.empty()) return false;
  const double time = now(), tau = p.shield_time;
  auto &list = h.extra->shields;
  for (size_t k = 0; k < list.size();)
    if (time - list[k].time >= tau) {
      list[k] = list.back();
      list.pop_back();
    } else
      k++;
  return defe::shielded(direction, value, p.criterion->limit(), time, tau, list.data(),
                        static_cast<int>(list.size()));
}

/* ----------------------------------------------------------------------
   which elements convert at the next step
------------------------------------------------------------------------- */

void FixDefe::mark_elements()
{
  marked_here = 0;
  jump = Jump();
  for (auto &b : batches) {
    if (!b.convertible) continue;
    const Part &p = parts[kernels[b.kernel].part];
    const double limit = p.criterion->limit();
    const int n = static_cast<int>(b.node.size());
    int above = 0;
    for (int e = 0; e < n; e++) above += b.bound[e] > limit;
    if (!above) continue;
    for (int e = 0; e < n; e++) {
      if (!(b.bound[e] > limit)) continue;
      HexRecord &h = *b.hex[e];
      Vec3 direction(1.0, 0.0, 0.0);
      const double value = criterion_value(b, e, direction);
      if (!(value > limit) || is_shielded(h, p, value, direction)) continue;
      h.marked = 1;
      marked_here = MAX(marked_here, 1);
      if (!h.extra || h.extra->shields.empty()) note_jump(h.id, value / limit);
    }
  }
  if (!jt.asking.empty()) marked_here = MAX(marked_here, 1);
  ask_marks();
}
