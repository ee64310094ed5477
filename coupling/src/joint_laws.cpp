#include "defe/coupling/joint_laws.h"

#include "defe/coupling/checksum.h"

#include <algorithm>
#include <cmath>

namespace defe {

void JointLaws::set_types(int n)
{
  types = n;
  coeffs.assign(static_cast<std::size_t>(n + 1) * (n + 1), JointCoeff());
}

const Adhesive *find_adhesive(const std::vector<Adhesive> &adhesives, int part, int base)
{
  for (const auto &a : adhesives)
    if (a.part == part && a.base == base) return &a;
  return nullptr;
}

std::vector<double> JointLaws::crack_strengths() const
{
  std::vector<double> strength(coeffs.size(), HUGE_VAL);
  if (!with_connective || !with_cohesive) return strength;
  for (std::size_t k = 0; k < coeffs.size(); ++k)
    if (coeffs[k].has_cohesive && opening(coeffs[k]).by_cracks())
      strength[k] = coeffs[k].cohesive.sigma_t;
  return strength;
}

std::vector<CrackNuclei> JointLaws::crack_nuclei() const
{
  std::vector<CrackNuclei> nuclei(coeffs.size());
  if (!with_connective || !with_cohesive) return nuclei;
  for (std::size_t k = 0; k < coeffs.size(); ++k)
    if (coeffs[k].has_cohesive) nuclei[k] = coeffs[k].nuclei;
  return nuclei;
}

bool JointLaws::any_by_traction() const
{
  return with_connective && with_cohesive &&
      std::any_of(coeffs.begin(), coeffs.end(), [this](const JointCoeff &c) {
           return c.has_cohesive && !opening(c).by_cracks();
         });
}

std::uint64_t JointLaws::checksum() const
{
  Checksum sum;
  for (const auto &c : coeffs) {
    const auto &law = c.cohesive;
    const double numbers[] = {c.E,
                              c.nu,
                              law.sigma_t,
                              law.G_f,
                              law.beta,
                              c.nuclei.overstrength,
                              c.nuclei.scatter,
                              c.restitution,
                              c.friction,
                              c.damping_ratio};
    const char flags[] = {c.has_connective,
                          c.has_cohesive,
                          c.has_contact,
                          law.reciprocal,
                          static_cast<char>(c.opening),
                          static_cast<char>(law.softening),
                          static_cast<char>(c.normal_law)};
    sum.add(numbers, sizeof(numbers));
    sum.add(flags, sizeof(flags));
  }
  return sum.value();
}

}    // namespace defe
