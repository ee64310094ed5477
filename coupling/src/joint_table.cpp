#include "defe/coupling/joint_table.h"

#include "defe/coupling/conversion.h"
#include "defe/coupling/joint_lattice.h"

#include <algorithm>

namespace defe {

static_assert(sizeof(JointRecord) == 64, "a line of the cache: there are six for each DE");

void JointTable::clear()
{
  nde = orthogonal = nall = 0;
  for (int i : self)    // most particles are no DEs
    if (i < static_cast<int>(of_atom.size())) of_atom[i] = -1;
  self.clear();
  records.clear();
  nb.clear();
  partner.clear();
  present.clear();
  tie_element.clear();
  tie_part.clear();
  tie_spot.clear();
  contact_distances.clear();
  len.clear();
  half.clear();
  material.clear();
  free.clear();
  cell.clear();
  corners.clear();
  stress_free.clear();
  half_force.clear();
  rows.clear();
  energy.clear();
  strength.clear();
  state.clear();
  tie_node.clear();
  tie_point.clear();
  place_first.assign(1, 0);
  place_particle.clear();
  place_weight.clear();
  cohesive.clear();
  debonded.clear();
  asking.clear();
  newborn.clear();
  pending.clear();
}

namespace {

  /// Whether eight entries of a list follow one another at that distance.
  template <class F> bool follow(const F &entry, int distance)
  {
    const int first = entry(0);
    bool all = true;
    for (int l = 1; l < LatticeRow::size; ++l) all = all && entry(l) == first + distance * l;
    return all;
  }

}    // namespace

LatticeRow JointTable::row_from(int first) const
{
  const LatticeRow none;
  LatticeRow row;
  if (!follow(
          [&](int l) {
            return self[first + l];
          },
          1))
    return none;
  for (int s = 0; s < 6; ++s) {
    row.nb[s] = row.behind[s] = row.partner[s] = -1;
    const auto joint = [&](int l) {
      return partner[first + l][s];
    };
    if (joint(0) < 0) {
      for (int l = 0; l < LatticeRow::size; ++l)
        if (joint(l) >= 0 || (present[first + l] >> s & 1u)) return none;
      continue;
    }
    if (!follow(joint, 6) ||
        !follow(
            [&](int l) {
              return nb[first + l][s];
            },
            1))
      return none;
    row.nb[s] = nb[first][s];
    row.behind[s] = joint(0) / 6;
    row.partner[s] = static_cast<signed char>(joint(0) % 6);
    row.slots = static_cast<unsigned char>(row.slots | 1u << s);
  }
  row.self = self[first];
  return row;
}

void JointTable::find_rows()
{
  rows.clear();
  for (int d = 0; d + LatticeRow::size <= nde; d += LatticeRow::size) rows.push_back(row_from(d));
}

double JointTable::contact_distance(int d, std::int64_t other) const
{
  auto found = std::lower_bound(contact_distances.begin(), contact_distances.end(), d,
                                [](const ContactDistance &a, int de) {
                                  return a.de < de;
                                });
  for (; found != contact_distances.end() && found->de == d; ++found)
    if (found->other == other) return found->distance;
  return 0.0;
}

void JointTable::add_place(int d, int s, const std::vector<int> &particles,
                           const std::vector<double> &weights)
{
  nb[d][s] = ~(static_cast<int>(tie_node.size()) + places());
  present[d] = static_cast<unsigned char>(present[d] | 1u << s);
  place_particle.insert(place_particle.end(), particles.begin(), particles.end());
  place_weight.insert(place_weight.end(), weights.begin(), weights.end());
  place_first.push_back(static_cast<int>(place_particle.size()));
}

void JointTable::find_tie_points(const double *x)
{
  const int ties = static_cast<int>(tie_node.size());
  tie_points(ties, reinterpret_cast<const int(*)[4]>(tie_node.data()), tie_spot.data(), x,
             tie_point.data());
  for (int p = 0; p < places(); ++p) {
    double *point = &tie_point[3 * static_cast<std::size_t>(ties + p)];
    std::fill_n(point, 3, 0.0);
    for_place(~(ties + p), [&](int i, double weight) {
      for (int k = 0; k < 3; ++k) point[k] += weight * x[3 * static_cast<std::ptrdiff_t>(i) + k];
    });
  }
}

bool JointTable::tied(int atom, std::int64_t element) const
{
  const int d = of_atom[atom];
  for (int s = 0; s < 6; ++s)
    if (nb[d][s] < 0 && !is_place(nb[d][s]) && tie_element[~nb[d][s]] == element &&
        state[6 * d + s] != joint::CONTACT)
      return true;
  return false;
}

double JointTable::corner_energy(int d, unsigned present, const double *x,
                                 const CornerModuli &moduli, Vec3 half_force[6]) const
{
  const double *xd = x + 3 * static_cast<std::ptrdiff_t>(self[d]);
  Vec3 y[6];
  for (int s = 0; s < 6; ++s) {
    y[s].setZero();
    if (!(present & (1u << s))) continue;
    const int other = nb[d][s];
    for (int k = 0; k < 3; ++k) {
      double p = 0.0;
      if (other >= 0)
        p = x[3 * static_cast<std::ptrdiff_t>(other) + k];
      else if (is_place(other))
        for_place(other, [&](int i, double weight) {
          p += weight * x[3 * static_cast<std::ptrdiff_t>(i) + k];
        });
      else
        for (int a = 0; a < 4; ++a)
          p += weights_of(tie_spot[~other])[a] *
              x[3 * static_cast<std::ptrdiff_t>(tie_node[~other][a]) + k];
      y[s][k] = p - xd[k];
    }
  }
  if (d >= orthogonal)
    return corner_strain_general(cell[d - orthogonal], y, present, moduli, half_force);

  // one orthogonal DE: neighbours as points of its own

  double xs[21];
  for (int k = 0; k < 3; ++k) xs[k] = 0.0;
  int points[1][6];
  double length[1][6], border[1][6], force[1][6][3], energy_of_it[1];
  for (int s = 0; s < 6; ++s) {
    points[0][s] = s + 1;
    length[0][s] = len[d][s];
    border[0][s] = half[d][s];
    for (int k = 0; k < 3; ++k) xs[3 * (s + 1) + k] = y[s][k];
  }
  const int self_point = 0;
  const auto bits = static_cast<unsigned char>(present);
  const OrthogonalLattice one{1, &self_point, points, &bits, length, border, nullptr, &free[d]};
  const double sum = corner_strain_orthogonal(one, xs, nullptr, &moduli, force, energy_of_it);
  for (int s = 0; s < 6; ++s) half_force[s] = Vec3(force[0][s]);
  return sum;
}

}    // namespace defe
