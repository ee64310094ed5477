/* ----------------------------------------------------------------------
   DEFE: adaptive finite elements to bonded discrete elements for LAMMPS
   https://www.lammps.org/
   This software is distributed under the GNU General Public License.

   The pair style beside others: which pairs of types are its own, whether DEs of all types that
   there are have their coefficients, and what particles nothing acts between.
------------------------------------------------------------------------- */

#include "pair_defe_joint.h"

#include "defe_system.h"

#include "atom.h"
#include "comm.h"
#include "error.h"
#include "force.h"
#include "pair_hybrid.h"

#include <cmath>

using namespace LAMMPS_NS;

namespace {

/** The map of pair_style hybrid from pairs of types to its styles. It is protected, and its public
    questions go by names of styles, which may occur twice: a derived class may point at it. */
struct HybridMap : PairHybrid {
  static int count(PairHybrid *h, int i, int j) { return (h->*(&HybridMap::nmap))[i][j]; }
  static const Pair *style(PairHybrid *h, int i, int j, int k)
  {
    return (h->*(&HybridMap::styles))[(h->*(&HybridMap::map))[i][j][k]];
  }
};

}    // namespace

/* ----------------------------------------------------------------------
   alone, all pairs of types are ours; in hybrid, those that its map gives us, or will give by mixing
   Neighbour lists cannot be asked: this style makes its own candidates.
------------------------------------------------------------------------- */

void PairDefeJoint::map_types()
{
  const size_t n = laws.types + 1;
  auto *hybrid = dynamic_cast<PairHybrid *>(force->pair);
  laws.acting.assign(n * n, hybrid ? 0 : defe::JointLaws::OURS);
  if (!hybrid) return;

  // pair_match() with a number returns an only match whatever the number

  const auto *first = force->pair_match("^defe/", 0, 1);
  const auto *second = force->pair_match("^defe/", 0, 2);
  if (second && second != first)
    error->all(FLERR, "There can be only one pair style defe/*: remove the others from hybrid");

  for (int i = 1; i <= laws.types; i++)
    for (int j = i; j <= laws.types; j++) {
      int a = i, b = j;
      if (!hybrid->setflag[i][j]) {    // two types of one style are mixed; else hybrid refuses
        if (HybridMap::count(hybrid, i, i) != 1 || HybridMap::count(hybrid, j, j) != 1 ||
            HybridMap::style(hybrid, i, i, 0) != HybridMap::style(hybrid, j, j, 0))
          continue;
        b = a;
      }
      char who = 0;
      for (int k = 0; k < HybridMap::count(hybrid, a, b); k++)
        who |= HybridMap::style(hybrid, a, b, k) == this ? defe::JointLaws::OURS
                                                         : defe::JointLaws::OTHERS;
      laws.acting[i * n + j] = laws.acting[j * n + i] = who;
    }
}

/* ----------------------------------------------------------------------
   DEs of all types that there are or can be born must have the coefficients that the style uses, also
   those whose type was changed by the set command: without them joints would have no strength at all
------------------------------------------------------------------------- */

void PairDefeJoint::check_coefficients()
{
  const int n = laws.types + 1, nparts = static_cast<int>(sys->model.parts.size());
  std::vector<int> mine(static_cast<size_t>(nparts) * n, 0), has(mine.size());
  for (int p = 0; p < nparts; p++)
    if (sys->model.parts[p].convertible) mine[p * n + sys->model.parts[p].type] = 1;
  for (int i = 0; i < atom->nlocal; i++)
    if (const auto *r = sys->store.de(i)) mine[r->part * n + atom->type[i]] = 1;
  MPI_Allreduce(mine.data(), has.data(), static_cast<int>(mine.size()), MPI_INT, MPI_MAX, world);

  const std::string style = force->pair_match_ptr(this);
  const bool hybrid = force->pair != this;
  const std::string sub_style = hybrid ? " " + style : "";
  std::vector<int> part_of(n, -1);    // a part that has DEs of this type
  for (int p = 0; p < nparts; p++)
    for (int t = 1; t < n; t++) {
      if (!has[p * n + t]) continue;
      if (part_of[t] < 0) part_of[t] = p;
      const auto &part = sys->model.parts[p];
      const auto &m = sys->model.material_of(part);
      const defe::JointCoeff &c = laws.of(t, t);
      const std::string who = t == part.type
          ? fmt::format("DEs of part {} have type {}", part.name, t)
          : fmt::format("DEs of part {} were given type {}, theirs is {}", part.name, t, part.type);
      if (!laws.acts_on(t, t))
        error->all(FLERR,
                   "{}, which pair_style hybrid does not give to {}: give 'pair_coeff {} {} {}'",
                   who, style, t, t, style);
      if ((laws.with_connective && !c.has_connective) || (laws.with_cohesive && !c.has_cohesive) ||
          (laws.with_contact && !c.has_contact))
        error->all(FLERR, "{}: give 'pair_coeff {} {}{}' with{}{}{} coefficients", who, t, t,
                   sub_style, laws.with_connective ? " connective" : "",
                   laws.with_cohesive ? " cohesive" : "", laws.with_contact ? " contact" : "");
      if (c.has_connective && c.E > 0.0 &&
          (std::abs(c.E / m.elastic().E - 1.0) > 1e-9 || std::abs(c.nu - m.elastic().nu) > 1e-9))
        error->all(FLERR,
                   "Pair_coeff {} {} connective {} {} differs from material {} of part {}: E {}, "
                   "nu {} (or write 'connective material')",
                   t, t, c.E, c.nu, m.name, part.name, m.elastic().E, m.elastic().nu);
      if (laws.with_cohesive && t == part.type && comm->me == 0) {
        const double d = 2.0 * sys->mesh.max_de_radius(t);
        const double limit =
            defe::toughness_limit(m.elastic().E, c.cohesive.G_f, c.cohesive.sigma_t);
        if (d > limit)
          utils::logmesg(lmp,
                         "Joints of part {} are {:.4g} long, above 2 E G_f/sigma_t^2 = {:.4g}: "
                         "fracture is strength-controlled, a joint releases {:.4g} per area\n",
                         part.name, d, limit,
                         0.5 * c.cohesive.sigma_t * c.cohesive.sigma_t * d / m.elastic().E +
                             c.cohesive.G_f);
      }
    }

  // joints also run between DEs of different types

  for (int t = 1; t < n; t++)
    for (int u = t + 1; u < n; u++) {
      if (part_of[t] < 0 || part_of[u] < 0) continue;
      const defe::JointCoeff &c = laws.of(t, u);
      const bool missing = (laws.with_cohesive && !c.has_cohesive) ||
          (laws.with_contact && !c.has_contact);
      if (laws.acts_on(t, u) && !missing) continue;
      error->all(FLERR,
                 "DEs of parts {} and {} have types {} and {}: give 'pair_coeff {} {}{}' with{}{} "
                 "coefficients",
                 sys->model.parts[part_of[t]].name, sys->model.parts[part_of[u]].name, t, u, t, u,
                 sub_style, laws.with_cohesive ? " cohesive" : "",
                 laws.with_contact ? " contact" : "");
    }

  laws.meets_des.assign(n, 0);
  for (int t = 1; t < n; t++)
    for (int u = 1; u < n; u++)
      if (part_of[u] >= 0 && laws.acts_on(t, u)) laws.meets_des[t] = 1;
}

/* ----------------------------------------------------------------------
   alone, this style acts on DEs and what meets them: that other spheres do not meet each other is
   hardly what is wanted
------------------------------------------------------------------------- */

void PairDefeJoint::tell_of_other_spheres()
{
  if (told_of_others || force->pair != this) return;
  bigint mine = 0, all = 0;
  for (int i = 0; i < atom->nlocal; i++)
    if (atom->radius[i] > 0.0 && !sys->store.de(i)) mine++;
  MPI_Allreduce(&mine, &all, 1, MPI_LMP_BIGINT, MPI_SUM, world);
  if (all < 2) return;
  told_of_others = true;
  if (comm->me == 0)
    utils::logmesg(lmp,
                   "{} spheres that are no DEs pass through each other: let a style of their own "
                   "act between them, as in 'pair_style hybrid {} granular'\n",
                   all, force->pair_style);
}

/* ----------------------------------------------------------------------
   DEs will be born that other styles of hybrid do not know of when they tell their cutoffs: what a
   sphere of type i must be found beside, by our own cutoff of i with itself
------------------------------------------------------------------------- */

double PairDefeJoint::largest_met_by_others(int i) const
{
  const size_t n = laws.types + 1;
  double mine = 0.0, all = 0.0;
  for (int k = 0; k < atom->nlocal; k++)
    if (laws.acting[i * n + atom->type[k]] & defe::JointLaws::OTHERS)
      mine = MAX(mine, atom->radius[k]);
  MPI_Allreduce(&mine, &all, 1, MPI_DOUBLE, MPI_MAX, world);
  return all;
}
