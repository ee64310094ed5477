#include "defe/coupling/joint_cracks.h"

#include <algorithm>
#include <cmath>

namespace defe {

namespace {

  /// Of the corners that share a joint, where that is largest: a nucleus at the joint is judged by them, too. (At a free end
  /// half of a DE's corners bear nothing.)
  double tension_of(const CrackStress &s)
  {
    double most = 0.0;
    for (int q = 0; q < 6; ++q)
      if (s.slot_volume[q] > 0.0 && largest_principal_bound(s.slot[q]) > most * s.slot_volume[q])
        most = std::max(most, largest_principal(crack_tensor(s.slot[q])).value / s.slot_volume[q]);
    return most;
  }

}    // namespace

void JointCracks::find_tensions(const std::vector<double> &share,
                                std::vector<Tension> &tensions) const
{
  tensions.clear();
  std::vector<CrackBox> box;
  std::vector<int> general;
  for (int d = 0; d < jt.nde; ++d) {
    const double least = share[jt.material[d]] * jt.strength[d];
    if (!std::isfinite(least) ||
        !(jt.energy[d] > crack_quiet_energy(least_volume[d], moduli[jt.material[d]], least, 1.0)))
      continue;
    if (d >= jt.orthogonal) {
      general.push_back(d);
      continue;
    }
    fill(box.emplace_back(), d);
    tensions.push_back({d, 0.0});
  }
  std::vector<CrackStress> stress(box.size());
  crack_stress_orthogonal(static_cast<int>(box.size()), box.data(), stress.data());
  for (std::size_t k = 0; k < box.size(); ++k) tensions[k].value = tension_of(stress[k]);
  for (int d : general) {
    Vec3 y[6];
    arms(d, y);
    tensions.push_back(
        {d, tension_of(crack_stress(cell(d), y, jt.present[d], moduli[jt.material[d]]))});
  }
}

void JointCracks::strengths_fell()
{
  for (int d = 0; d < jt.nde; ++d)
    quiet[d] = crack_quiet_energy(least_volume[d], moduli[jt.material[d]], least_strength_at(d),
                                  CrackGrowth::quiet_share);
}

}    // namespace defe
