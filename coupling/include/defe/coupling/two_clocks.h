#ifndef DEFE_COUPLING_TWO_CLOCKS_H
#define DEFE_COUPLING_TWO_CLOCKS_H

/// \file
/// Resonance of the impulse method.

#include <cmath>

namespace defe {

/// Whether impulses of slow forces at every m-th step can pump energy into an oscillation that joints hold,
/// which velocity Verlet follows at every step: they hit it in step with itself when its phase advances by
/// pi from one impulse to the next (Biesiadecki and Skeel, J. Comput. Phys. 109 (1993) 318). A
/// step dt takes the phase of the fastest one, of stable step 2/omega, on by 2 asin(omega dt/2). All slower
/// ones are safe when that one is.
/// \param fast_step  stable step of the fast oscillations alone
inline bool clocks_resonate(int every, double dt, double fast_step)
{
  if (every == 1) return false;
  constexpr double pi = 3.14159265358979323846;
  return dt >= fast_step || 2.0 * every * std::asin(dt / fast_step) >= pi;
}

}    // namespace defe

#endif
