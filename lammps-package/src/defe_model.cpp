/* ----------------------------------------------------------------------
   DEFE: adaptive finite elements to bonded discrete elements for LAMMPS
   https://www.lammps.org/
   This software is distributed under the GNU General Public License.
------------------------------------------------------------------------- */

#include "defe_model.h"

#include "defe/exact_sum.h"

#include <algorithm>
#include <cstring>

using namespace LAMMPS_NS;

/* ---------------------------------------------------------------------- */

bool DefeModel::enhanced(const DefePart &p) const
{
  return strcmp(material_of(p).law->elements(), "enhanced") == 0;
}

int DefeModel::find_part(const std::string &name) const
{
  for (size_t i = 0; i < parts.size(); i++)
    if (parts[i].name == name) return static_cast<int>(i);
  return -1;
}

bool DefeModel::are_tied(int part, int other) const
{
  return std::any_of(tied.begin(), tied.end(), [=](const DefeTiedPair &p) {
    return (p.a == part && p.b == other) || (p.a == other && p.b == part);
  });
}

/* ---------------------------------------------------------------------- */

std::string DefeModel::describe(const DefePart &p) const
{
  return p.name + ": " + material_of(p).words +
      (p.convertible ? ", DEs of type " + std::to_string(p.type) : "") +
      (p.convertible && !(p.split == defe::ElementSplit())
           ? ", split " + std::to_string(p.split.along())
           : "");
}

/* ----------------------------------------------------------------------
   mass of an element: a node's shares can be added and taken away in any order
------------------------------------------------------------------------- */

double DefeModel::element_mass(const DefePart &p, double volume) const
{
  const double mass = material_of(p).elastic().rho * volume;
  return reproducible ? defe::short_mass(mass) : mass;
}

/* ---------------------------------------------------------------------- */

int DefeModel::lot_size() const
{
  int most = any_convertible() ? 0 : defe::ElementSplit().des();
  for (const DefePart &p : parts)
    if (p.convertible) most = std::max(most, p.split.des());
  return most;
}

bool DefeModel::any_single() const
{
  return std::any_of(parts.begin(), parts.end(), [](const DefePart &p) {
    return p.convertible && p.split.des() == 1;
  });
}

/* ---------------------------------------------------------------------- */

bool DefeModel::any_convertible() const
{
  return std::any_of(parts.begin(), parts.end(), [](const DefePart &p) {
    return p.convertible;
  });
}
