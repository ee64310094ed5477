#ifndef DEFE_COUPLING_NORMAL_LAW_H
#define DEFE_COUPLING_NORMAL_LAW_H

/// \file
/// Normal force of two spheres against their overlap: the spring of contact_law.h, one of whose spheres or both are
/// discrete elements (DEs). A law is a file of its own (see src/normal_hertz.cpp) and a line in src/normal_law.cpp. It is
/// a potential: the force is the derivative of the energy, so that what is stored and what is lost add up.

#include <string>
#include <vector>

namespace defe {

struct DEMaterial {
  double E, nu;
};

/// Two DEs in contact.
struct DEPair {
  DEMaterial material[2];
  double radius[2];
  double reach;    ///< of the centres at which contact begins: the sum of the radii, or less
};

/// A sphere of other origin in contact with a DE, which is also the patch of the surface that it was as an element.
struct SphereOnDE {
  double R;               ///< of the sphere, which is taken as rigid
  DEMaterial material;    ///< of the DE
  double radius;          ///< of the DE
  double area;            ///< of the patch
  double k_area;          ///< penalty stiffness per area of the patch (N/m3)
};

/// At a given overlap > 0.
struct NormalSpring {
  double force, energy;
  double kn;    ///< force over overlap
  double kt;    ///< tangential stiffness that goes with it
  /// Of the damping ratio of the linear spring kn, so that the restitution is the same. With force = k g^n it is
  /// sqrt((1 + n)/2), exactly: g^((n+1)/2) over the time of which dt is g^((1-n)/2) is a linear damped oscillation.
  double damping_factor;

  /// Beyond that of a linear spring kn.
  double energy_beyond(double overlap) const { return energy - 0.5 * force * overlap; }
};

class NormalLaw {
 public:
  NormalLaw() = default;
  NormalLaw(const NormalLaw &) = delete;
  NormalLaw &operator=(const NormalLaw &) = delete;
  virtual ~NormalLaw();

  /// As in an input line.
  virtual const char *name() const = 0;

  virtual NormalSpring between_des(double overlap, const DEPair &) const = 0;
  virtual NormalSpring sphere_on_de(double overlap, const SphereOnDE &) const = 0;
  /// The overlap (>= 0) at which sphere_on_de() has this energy: an element that converts hands its contact on.
  virtual double overlap_of_energy(double energy, const SphereOnDE &) const = 0;
};

/// All registered laws; JointCoeff has the number of one, 0 unless another is given.
const std::vector<const NormalLaw *> &normal_laws();

inline const NormalLaw &normal_law(int number)
{
  return *normal_laws()[number];
}

/// -1: there is none of this name.
int find_normal_law(const std::string &name);

/// Tangential stiffness of two bodies of one material whose normal force has the slope kn (Mindlin, J. Appl. Mech. 16
/// (1949) 259).
inline double mindlin_stiffness(double kn, double nu)
{
  return kn * 2.0 * (1.0 - nu) / (2.0 - nu);
}

}    // namespace defe

#endif
