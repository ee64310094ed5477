#ifndef DEFE_FE_STABLE_STEP_H
#define DEFE_FE_STABLE_STEP_H

#include "defe/fe/elastic.h"
#include "defe/fe/kernel.h"
#include "defe/fe/topology.h"

namespace defe::fe {

/// Largest eigenfrequency (rad/s) of one free element with lumped mass: sqrt of the largest
/// eigenvalue of M^-1 K, M = m_e/8. By a dense eigen-solve, exact to rounding. The largest value
/// over the elements of a mesh is an upper bound of the mesh's largest eigenfrequency (Irons and
/// Treharne 1971; it holds because the lumped masses of a mesh are sums of element masses).
/// In meshes of unlike elements it is some 10 to 20 % too high: 2.09e-7 s is the critical step of the
/// paper's beam, 1.71e-7 s that of its narrowest element.
/// That of an enhanced element is never larger than that of a plain one (see stiffness_enhanced()).
/// One call costs some 15 us: call it once per distinct shape.
double max_frequency(const HexCoords &X, const IsotropicElastic &material,
                     ElementType = ElementType::enhanced);

/// Critical step of central differences (velocity Verlet), 2/max_frequency. Damping or contact
/// stiffness lower it; a step of 0.9 times this value is customary.
double critical_step(const HexCoords &X, const IsotropicElastic &material,
                     ElementType = ElementType::enhanced);

/// The same for an FBarKernel: with its stiffness at rest, whose dilatation is the mean over the
/// element (stiffness_fbar() in hex8.h); `initial` is the kernel's material(). The step is that of
/// the undeformed body. An element squeezed or sheared to a fraction of its thickness needs that
/// fraction of it, and stretching a rubber by lambda raises its stiffness by up to lambda^2: leave
/// room.
double max_frequency_fbar(const HexCoords &X, const IsotropicElastic &initial);
double critical_step_fbar(const HexCoords &X, const IsotropicElastic &initial);

}    // namespace defe::fe

#endif
