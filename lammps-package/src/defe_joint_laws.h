/* ----------------------------------------------------------------------
   DEFE: adaptive finite elements to bonded discrete elements for LAMMPS
   https://www.lammps.org/
   This software is distributed under the GNU General Public License.
------------------------------------------------------------------------- */

#ifndef LMP_DEFE_JOINT_LAWS_H
#define LMP_DEFE_JOINT_LAWS_H

#include "pointers.h"

#include "defe/coupling/cohesive.h"
#include "defe/coupling/corner_strain.h"
#include "defe/coupling/crack_growth.h"

#include <cstdint>
#include <vector>

namespace LAMMPS_NS {

/** What pair_coeff says of two types. Plain data: kept in restart files as bytes. */
struct JointCoeff {
  double E = 0.0, nu = 0.0;    // connective; 0 = take the material of the part
  defe::CohesiveParameters cohesive{0.0, 0.0, 0.0, false};
  defe::CrackNuclei nuclei;
  bool lattice = false;    // each joint is judged by its own traction, cracks know the mesh
  double restitution = 1.0, friction = 0.0, damping_ratio = 0.0;
  bool has_connective = false, has_cohesive = false, has_contact = false;
};

/** Laws of joints and of contact between types, and where they act. Values only. */
struct JointLaws {
  bool with_connective = true, with_cohesive = true, with_contact = true;    // by the style
  int types = 0;
  std::vector<JointCoeff> coeffs;    // (types+1)^2
  enum : char { OURS = 1, OTHERS = 2 };
  std::vector<char> acting;       // (types+1)^2: which styles act between two types
  std::vector<char> meets_des;    // per type: this style acts between it and DEs of some type

  std::vector<defe::CornerModuli> moduli;    // per part
  std::vector<double> young;                 // per part

  void set_types(int n);
  int index(int i, int j) const { return i * (types + 1) + j; }
  const JointCoeff &of(int i, int j) const { return coeffs[index(i, j)]; }
  bool acts_on(int i, int j) const { return acting[index(i, j)] & OURS; }
  defe::JointStiffness stiffness(int part, double length) const
  {
    return defe::joint_stiffness(moduli[part].lambda, moduli[part].mu, length);
  }
  double poisson(int part) const
  {
    return 0.5 * moduli[part].lambda / (moduli[part].lambda + moduli[part].mu);
  }
  uint64_t checksum() const;    // of all coefficients
};

/** Reads the arguments of pair_coeff: I J connective (E nu | material) cohesive sigma_t G_f beta
    [reciprocal] [lattice] [overstrength X] [scatter X] contact restitution friction. */
class JointCoeffReader : protected Pointers {
 public:
  JointCoeffReader(LAMMPS *, int narg, char **arg);
  void read(JointLaws &);

 private:
  const int narg;
  char **const arg;
  int iarg = 2;
  int ilo = 0, ihi = 0, jlo = 0, jhi = 0;    // types
  void find_types();
  void need(int n, const char *what);
  double number(int k);
  void read_connective(JointCoeff &);
  void read_cohesive(JointCoeff &);
  void read_words(JointCoeff &);
  void read_contact(JointCoeff &);
  void assign(JointLaws &, const JointCoeff &) const;
};

}    // namespace LAMMPS_NS

#endif
