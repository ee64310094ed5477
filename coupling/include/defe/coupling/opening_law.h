#ifndef DEFE_COUPLING_OPENING_LAW_H
#define DEFE_COUPLING_OPENING_LAW_H

/// \file
/// When a joint between two DEs begins to soften, and along which normal. A law is a file of its own (see
/// src/opening_lattice.cpp) and a line in src/opening_law.cpp. How its traction falls from then on is softening_curve.h.

#include "defe/coupling/cohesive.h"

#include <string>
#include <vector>

namespace defe {

class OpeningLaw {
 public:
  OpeningLaw() = default;
  OpeningLaw(const OpeningLaw &) = delete;
  OpeningLaw &operator=(const OpeningLaw &) = delete;
  virtual ~OpeningLaw();

  /// As in an input line.
  virtual const char *name() const = 0;

  /// True: cracks decide (crack_growth.h), by the stress of the solid and sigma_t, and the joint softens along the
  /// normal of its crack (crack_softening.h). False: the traction of the joint decides, and it softens along its own
  /// normal (joint_softening.h).
  virtual bool by_cracks() const = 0;

  /// Whether its traction, t_n along the normal of the joint's face and t_s in its plane, starts it. The equivalent
  /// traction (cohesive.h) must be > 0 then.
  virtual bool starts(double t_n, double t_s, const CohesiveParameters &) const = 0;

  /// A traction that is smaller, in whatever direction, does not start it: the only number that is asked for joints that
  /// are not loaded.
  virtual double least_traction(const CohesiveParameters &) const = 0;
};

/// All registered laws; JointCoeff has the number of one, 0 unless another is given.
const std::vector<const OpeningLaw *> &opening_laws();

/// -1: there is none of this name.
int find_opening_law(const std::string &name);

/// Names of those by cracks, or of the others, as in "this or that".
std::string names_of_opening_laws(bool by_cracks);

/// That of ties (fix defe adhesive): their normal is that of the face.
const OpeningLaw &opening_law_of_ties();

}    // namespace defe

#endif
