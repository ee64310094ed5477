#ifndef DEFE_COUPLING_PENALTY_H
#define DEFE_COUPLING_PENALTY_H

/// \file
/// Penalty stiffness of surface contact.

namespace defe {

/// Stiffness per area, N/m3, of the LS-DYNA standard form k = f_s K A^2 / V for a segment of area
/// A of a solid element: k/A = f_s K A / V. K, A, V: bulk modulus, segment area and element volume
/// of the softer deformable side. A node or a DE takes this times the area it stands for, so that
/// the compliance of a contact does not change when elements become DEs.
double penalty_stiffness_per_area(double f_s, double K, double A, double V);

}    // namespace defe

#endif
