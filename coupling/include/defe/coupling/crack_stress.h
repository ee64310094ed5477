#ifndef DEFE_COUPLING_CRACK_STRESS_H
#define DEFE_COUPLING_CRACK_STRESS_H

/// \file
/// Stresses of the corners of a DE, as the growth of cracks (crack_growth.h) asks for them.
///
/// Second Piola-Kirchhoff stress in the reference frame, S = sum over the present joints of a
/// corner S^ab M_a (x) M_b, with the reduced laws of corner_strain.h where joints are missing, and its selective shear. Rigid
/// rotation drops out.
/// Only a few DEs need it, so it is separate from the kernel that makes the forces.

#include "defe/coupling/corner_strain.h"

#include <cmath>

namespace defe {

/// Sums over a DE's corners; plain data, sent to the ghosts as it is. Order xx yy zz yz xz xy.
struct CrackStress {
  static constexpr int size = 49;    ///< doubles

  double slot[6][6];    ///< of the corners that share the joint at the slot: volume times stress
  double slot_volume[6];    ///< their volume; 0 where there is no joint
  double full[6];           ///< of the corners with all three joints
  double full_volume;
};
static_assert(sizeof(CrackStress) == CrackStress::size * sizeof(double), "no gaps");

/// \param y, present  as in corner_strain_general
CrackStress crack_stress(const GeneralCell &cell, const Vec3 y[6], unsigned present,
                         const CornerModuli &moduli);

/// A DE whose cell is_orthogonal().
struct CrackBox {
  Mat3 axes;           ///< unit vectors of the cell's axes, in columns
  double length[6];    ///< of the joints and ties; read where they are present
  double half[6];      ///< from the DE to the border of its cell
  Vec3 y[6];           ///< as in corner_strain_general
  unsigned present;
  CornerModuli moduli;
  unsigned free = 0;    ///< as GeneralCell::free
};

/// The same for many boxes side by side: several times faster. \param out  [n]
void crack_stress_orthogonal(int n, const CrackBox *box, CrackStress *out);

Mat3 crack_tensor(const double sum[6]);

/// Least volume of the corners of a DE that share a joint; of a box: half of it.
double crack_least_volume(const GeneralCell &cell);

/// Strain energy W s^2/(2 (lambda + 2 mu)), s = share of sigma_t, without which corners of volume W cannot have a mean
/// stress with the principal value s. A joint's corners are those of both its DEs: with the least volume of
/// each, it holds less than s if both together have less energy than this. (In uniaxial tension that is reached
/// at 0.67 s for nu = 0.2, since the energy of a DE is that of all its corners.)
double crack_quiet_energy(double least_volume, const CornerModuli &moduli, double sigma_t,
                          double share);

/// Upper bound of the largest principal value (order as in CrackStress), without an eigenproblem: p + 2 sqrt(J2/3).
inline double largest_principal_bound(const double s[6])
{
  const double xy = s[0] - s[1], yz = s[1] - s[2], zx = s[2] - s[0];
  const double J2 = (xy * xy + yz * yz + zx * zx) / 6.0 + s[3] * s[3] + s[4] * s[4] + s[5] * s[5];
  return (s[0] + s[1] + s[2]) / 3.0 + 2.0 * std::sqrt(J2 / 3.0);
}

/// Largest principal value and its direction (sign arbitrary).
struct Principal {
  double value;
  Vec3 direction;
};
Principal largest_principal(const Mat3 &S);

/// The same; where several directions serve equally (relative gap below 1e-6) it is `wish`, as far as possible.
Principal largest_principal(const Mat3 &S, const Vec3 &wish);

}    // namespace defe

#endif
