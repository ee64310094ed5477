/* ----------------------------------------------------------------------
   DEFE: adaptive finite elements to bonded discrete elements for LAMMPS
   https://www.lammps.org/
   This software is distributed under the GNU General Public License.
------------------------------------------------------------------------- */

#ifndef LMP_DEFE_JOINT_COEFFS_H
#define LMP_DEFE_JOINT_COEFFS_H

#include "pointers.h"

#include "defe/coupling/joint_laws.h"

namespace LAMMPS_NS {

/** Reads the arguments of pair_coeff: I J connective (E nu | material) cohesive sigma_t G_f beta
    [reciprocal] [linear|exponential] [rings|lattice] [overstrength X] [scatter X] contact restitution
    friction [linear|hertz]. */
class JointCoeffReader : protected Pointers {
 public:
  JointCoeffReader(LAMMPS *, int narg, char **arg);
  void read(defe::JointLaws &);

 private:
  const int narg;
  char **const arg;
  int iarg = 2;
  int ilo = 0, ihi = 0, jlo = 0, jhi = 0;    // types
  void find_types();
  void need(int n, const char *what);
  double number(int k);
  void read_connective(defe::JointCoeff &);
  void read_cohesive(defe::JointCoeff &);
  void read_words(defe::JointCoeff &);
  void read_contact(defe::JointCoeff &);
  void assign(defe::JointLaws &, const defe::JointCoeff &) const;
};

}    // namespace LAMMPS_NS

#endif
