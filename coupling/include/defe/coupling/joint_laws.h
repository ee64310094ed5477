#ifndef DEFE_COUPLING_JOINT_LAWS_H
#define DEFE_COUPLING_JOINT_LAWS_H

/// \file
/// Laws of joints, ties and contacts between types of particles, and where they act. Values only.

#include "defe/coupling/cohesive.h"
#include "defe/coupling/corner_strain.h"
#include "defe/coupling/crack_growth.h"
#include "defe/coupling/opening_law.h"

#include <cstdint>
#include <vector>

namespace defe {

/// Of two types. Plain data: kept in restart files as bytes.
struct JointCoeff {
  double E = 0.0, nu = 0.0;    ///< connective; 0 = take the material of the part
  CohesiveParameters cohesive{0.0, 0.0, 0.0, false};
  CrackNuclei nuclei;
  unsigned char opening = 0;    ///< number in JointLaws::openings
  double restitution = 1.0, friction = 0.0, damping_ratio = 0.0;
  unsigned char normal_law = 0;    ///< of contact: number in normal_law.h
  bool has_connective = false, has_cohesive = false, has_contact = false;
};

/// Ties of DEs of `part` to elements of `base` that can break.
struct Adhesive {
  int part, base;
  CohesiveParameters law;
};

/// Null: ties between these parts do not break.
const Adhesive *find_adhesive(const std::vector<Adhesive> &, int part, int base);

struct JointLaws {
  bool with_connective = true, with_cohesive = true, with_contact = true;    ///< by the style
  int types = 0;
  std::vector<JointCoeff> coeffs;    ///< (types+1)^2
  enum : char { OURS = 1, OTHERS = 2 };
  std::vector<char> acting;       ///< (types+1)^2: which styles act between two types
  std::vector<char> meets_des;    ///< per type: this style acts between it and DEs of some type

  std::vector<const OpeningLaw *> openings = opening_laws();

  std::vector<CornerModuli> moduli;    ///< per part
  std::vector<double> young;           ///< per part
  std::vector<Adhesive> adhesives;

  void set_types(int n);
  int index(int i, int j) const { return i * (types + 1) + j; }
  const JointCoeff &of(int i, int j) const { return coeffs[index(i, j)]; }
  const OpeningLaw &opening(const JointCoeff &c) const { return *openings[c.opening]; }
  bool acts_on(int i, int j) const { return acting[index(i, j)] & OURS; }
  JointStiffness stiffness(int part, double length) const
  {
    return joint_stiffness(moduli[part].lambda, moduli[part].mu, length);
  }
  double poisson(int part) const
  {
    return 0.5 * moduli[part].lambda / (moduli[part].lambda + moduli[part].mu);
  }
  const Adhesive *adhesive_of(int part, int base) const
  {
    return find_adhesive(adhesives, part, base);
  }

  /// Strength of the joints that cracks cut by their own planes, (types+1)^2; infinite where there are none.
  std::vector<double> crack_strengths() const;
  std::vector<CrackNuclei> crack_nuclei() const;
  /// Whether joints between some types are judged by their own traction.
  bool any_by_traction() const;

  std::uint64_t checksum() const;    ///< of all coefficients
};

}    // namespace defe

#endif
