#ifndef DEFE_COUPLING_PARTICLES_H
#define DEFE_COUPLING_PARTICLES_H

/// \file
/// The particles of a rank as the caller has them: a view, nothing is copied.

#include "defe/types.h"

#include <cstddef>
#include <cstdint>

namespace defe {

/// IDs of particles, kept in 32 or 64 bits.
class Ids {
 public:
  Ids() = default;
  Ids(const std::int32_t *ids) : narrow(ids) {}
  Ids(const std::int64_t *ids) : wide(ids) {}
  std::int64_t operator[](int i) const { return narrow ? narrow[i] : wide[i]; }

 private:
  const std::int32_t *narrow = nullptr;
  const std::int64_t *wide = nullptr;
};

/// Nodes, DEs and other spheres: first the rank's own, then ghosts.
struct Particles {
  int nlocal = 0, nall = 0;
  const double *x = nullptr;         ///< positions, three numbers each
  const double *X = nullptr;         ///< reference positions, in the periodic frame of x
  const double *radius = nullptr;    ///< 0 for nodes
  Ids id;

  const double *at(int i) const { return x + 3 * static_cast<std::ptrdiff_t>(i); }
  const double *reference(int i) const { return X + 3 * static_cast<std::ptrdiff_t>(i); }
};

/// The same with what joints and contacts of spheres need of their motion.
struct MovingParticles : Particles {
  const double *v = nullptr, *omega = nullptr;    ///< three numbers each
  const int *type = nullptr;

  Vec3 position(int i) const { return Vec3(at(i)); }
  Vec3 velocity(int i) const { return Vec3(v + 3 * static_cast<std::ptrdiff_t>(i)); }
  Vec3 spin(int i) const { return Vec3(omega + 3 * static_cast<std::ptrdiff_t>(i)); }
};

}    // namespace defe

#endif
