#ifndef DEFE_COUPLING_SURFACE_NEAR_H
#define DEFE_COUPLING_SURFACE_NEAR_H

/// \file
/// Contact of surfaces: of the pairs that the search has found within the skin of the neighbour lists, those that are so
/// near that they may touch in the next few steps. The rest cannot have a force, so that results do not
/// change by a bit; it is fifteen times as many.

#include "defe/coupling/surface_forces.h"

#include <vector>

namespace defe {

class NearSurface {
 public:
  /// The tables have changed, or what their indices mean.
  void forget() { known = false; }

  /// Pairs that may touch now; they are found again when something has moved too far since the last time.
  /// \param tables  with the planes of the positions x
  /// \param memory  points that it knows stay: their histories have to end
  /// \param skin    of the search
  const ContactPairs &find(const SurfaceTables &tables, const double *x, ContactMemory &memory,
                           double skin);

 private:
  bool known = false;
  double margin = 0.0;    // by which two things may come nearer to each other
  int steps = 0;          // since they were found
  ContactPairs pairs;
  std::vector<int> atoms;      // nodes of facets, and points
  std::vector<double> held;    // their positions when pairs were found
  std::vector<char> listed;

  void list_atoms(const SurfaceTables &);
  bool moved(const double *x) const;
  void choose_margin(double skin);
  void choose(const SurfaceTables &, const double *x, ContactMemory &);
};

}    // namespace defe

#endif
