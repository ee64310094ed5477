#include "defe/coupling/normal_law.h"

#include <cmath>

namespace defe {

namespace {

  /// Two elastic spheres (Hertz 1882; Johnson, Contact Mechanics, 1985):
  ///   F = 4/3 E* sqrt(R*) g^(3/2),   1/E* = (1 - nu_i^2)/E_i + (1 - nu_j^2)/E_j,   1/R* = 1/R_i + 1/R_j
  /// with the tangential stiffness of Mindlin (J. Appl. Mech. 16 (1949) 259) without slip,
  ///   k_t = 8 G* sqrt(R* g),   1/G* = (2 - nu_i)/G_i + (2 - nu_j)/G_j.
  class Hertz : public NormalLaw {
   public:
    const char *name() const override { return "hertz"; }

    NormalSpring between_des(double overlap, const DEPair &p) const override
    {
      return spring(overlap, radius_of(p.radius[0], p.radius[1]),
                    1.0 / (normal_compliance(p.material[0]) + normal_compliance(p.material[1])),
                    1.0 / (shear_compliance(p.material[0]) + shear_compliance(p.material[1])));
    }

    NormalSpring sphere_on_de(double overlap, const SphereOnDE &p) const override
    {
      return spring(overlap, radius_of(p.R, p.radius), 1.0 / normal_compliance(p.material),
                    1.0 / shear_compliance(p.material));
    }

    double overlap_of_energy(double energy, const SphereOnDE &p) const override
    {
      if (energy <= 0.0) return 0.0;
      const double E = 1.0 / normal_compliance(p.material);
      return std::pow(15.0 / 8.0 * energy / (E * std::sqrt(radius_of(p.R, p.radius))), 0.4);
    }

   private:
    static double radius_of(double a, double b) { return a * b / (a + b); }
    static double normal_compliance(const DEMaterial &m) { return (1.0 - m.nu * m.nu) / m.E; }
    static double shear_compliance(const DEMaterial &m)
    {
      return (2.0 - m.nu) * 2.0 * (1.0 + m.nu) / m.E;
    }

    static NormalSpring spring(double overlap, double R, double E, double G)
    {
      const double a = std::sqrt(R * overlap);    // radius of the disc of contact
      NormalSpring s{};
      s.kn = 4.0 / 3.0 * E * a;
      s.force = s.kn * overlap;
      s.energy = 0.4 * s.force * overlap;
      s.kt = 8.0 * G * a;
      s.damping_factor = std::sqrt(1.25);
      return s;
    }
  };
  const Hertz hertz;

}    // namespace

extern const NormalLaw &hertz_normal;
const NormalLaw &hertz_normal = hertz;

}    // namespace defe
