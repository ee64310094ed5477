#ifndef DEFE_COUPLING_SHIELDING_H
#define DEFE_COUPLING_SHIELDING_H

/// \file
/// Crack shielding: an element waits where a crack beside it is about to unload it.
///
/// The stress ahead of a starting crack is so flat that neighbours reach the criterion a step or
/// two before the release wave arrives; which of them convert would depend on the time step. So an
/// element does not convert while a neighbour that lies in the direction of its own largest tension
/// has converted less than tau ago, unless its stress is far above the criterion. Neighbours in the
/// plane of the crack are not shielded: the crack runs freely. The rule is this
/// package's own; what it does to the glass beam is in examples/glass_beam/README.md.

#include "defe/types.h"

namespace defe {

/// A converted neighbour (of the 26 around an element).
struct Shield {
  Vec3 direction;    ///< from the element's centre to the neighbour's, any length > 0
  double time;       ///< when it converted
};

/// \param tension_direction  principal direction of the largest tension, any length > 0, any sign
/// \param sigma1             largest principal stress of the element
/// \param criterion          conversion stress
/// \param tau                shielding time, usually 3 h/c_d; <= 0 switches shielding off
/// \param cos_limit          a neighbour shields if |cos| of its direction to the tension is larger
/// \param override           at sigma1 >= override * criterion nothing shields
/// \return whether the element has to wait
bool shielded(const Vec3 &tension_direction, double sigma1, double criterion, double now,
              double tau, const Shield *shields, int n, double cos_limit = 0.7,
              double override = 1.2);

/// 3 h / c_d, c_d = sqrt((lambda + 2 mu) / rho).
double shielding_time(double h, double lambda, double mu, double rho);

}    // namespace defe

#endif
