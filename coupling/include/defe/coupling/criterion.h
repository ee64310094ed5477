#ifndef DEFE_COUPLING_CRITERION_H
#define DEFE_COUPLING_CRITERION_H

/// \file
/// When an element converts: an isotropic measure of its Cauchy stress is above a limit. A criterion is a file of
/// its own (see src/criterion_mises.cpp) and a line in src/criterion.cpp.

#include "defe/fe/elastic.h"
#include "defe/fe/material_law.h"
#include "defe/fe/principal.h"
#include "defe/types.h"

#include <memory>
#include <string>
#include <vector>

namespace defe {

class ConversionCriterion {
 public:
  ConversionCriterion() = default;
  ConversionCriterion(const ConversionCriterion &) = delete;
  ConversionCriterion &operator=(const ConversionCriterion &) = delete;
  virtual ~ConversionCriterion();

  /// The measure of a Cauchy stress, and the principal direction of its largest tension: along it a neighbour
  /// that has converted shields (shielding.h).
  virtual double value(const Mat3 &stress, Vec3 &direction) const = 0;

  /// An element converts when the value is above.
  virtual double limit() const = 0;

  /// fe::stress_bound() with these weights is nowhere below value(): kernels compute it for all elements, and only
  /// those that it lets through are looked at. With principal values p + 2 sqrt(J2/3) cos(theta + ...), theta the
  /// Lode angle, a measure that is linear in them is largest at some theta whatever the stress.
  virtual fe::StressBound bound() const = 0;

  /// Stress in uniaxial tension at which the limit is reached: for comparisons with the strength of joints.
  virtual double tensile_stress() const = 0;

  /// As given after the name.
  virtual std::vector<double> numbers() const = 0;
};

/// How a criterion is registered: see src/criterion.cpp.
struct CriterionEntry {
  const char *name;
  const char *usage;    ///< name and parameters, as in an input line
  /// Reads the numbers. Sets `complaint` to one line and returns null if they are not usable.
  std::unique_ptr<ConversionCriterion> (*make)(fe::LawWords &words,
                                               const fe::IsotropicElastic &material,
                                               std::string &complaint);
};

struct ParsedCriterion {
  std::shared_ptr<const ConversionCriterion> criterion;    ///< null if there is a complaint
  const CriterionEntry *entry = nullptr;
  std::string complaint;    ///< one line: what is wrong with which value, and what to write instead
  int used = 0;             ///< number of words that belong to the criterion
};

/// words: the name of a criterion, its numbers, and whatever else follows on the line; a number alone is the largest
/// principal stress.
///
///     56e6
///     principal 56e6          largest principal stress
///     strain 7.5e-4           largest principal strain
///     mises 80e6              equivalent stress of von Mises
///     mohr 40e6 35            Mohr-Coulomb: cohesion, angle of internal friction in degrees
ParsedCriterion parse_criterion(const std::vector<std::string> &words,
                                const fe::IsotropicElastic &material);

/// All registered criteria; the first one is that of a number alone.
const std::vector<const CriterionEntry *> &conversion_criteria();

}    // namespace defe

#endif
