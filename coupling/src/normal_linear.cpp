#include "defe/coupling/normal_law.h"

#include "defe/coupling/penalty.h"

#include <algorithm>

namespace defe {

namespace {

  /// Two DEs: a spring E d of the softer material, so that a closed crack is as stiff as the solid. A sphere presses on
  /// the patch as it does on a face of an element.
  class Linear : public NormalLaw {
   public:
    const char *name() const override { return "linear"; }

    NormalSpring between_des(double overlap, const DEPair &p) const override
    {
      const DEMaterial &m = p.material[p.material[1].E < p.material[0].E];
      NormalSpring s{};
      s.kn = m.E * std::min(2.0 * std::min(p.radius[0], p.radius[1]), p.reach);
      s.force = s.kn * overlap;
      s.energy = 0.5 * s.force * overlap;
      s.kt = mindlin_stiffness(s.kn, m.nu);
      s.damping_factor = 1.0;
      return s;
    }

    NormalSpring sphere_on_de(double overlap, const SphereOnDE &p) const override
    {
      const BallOnPatch push = ball_on_patch(overlap, p.R, p.area, p.k_area);
      NormalSpring s{};
      s.force = push.force;
      s.energy = push.energy;
      s.kn = push.force / overlap;
      s.kt = mindlin_stiffness(s.kn, p.material.nu);
      s.damping_factor = push.damping_factor;
      return s;
    }

    double overlap_of_energy(double energy, const SphereOnDE &p) const override
    {
      return defe::overlap_of_energy(energy, p.R, p.area, p.k_area);
    }
  };
  const Linear linear;

}    // namespace

extern const NormalLaw &linear_normal;
const NormalLaw &linear_normal = linear;

}    // namespace defe
