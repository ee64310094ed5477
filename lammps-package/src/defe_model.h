/* ----------------------------------------------------------------------
   DEFE: adaptive finite elements to bonded discrete elements for LAMMPS
   https://www.lammps.org/
   This software is distributed under the GNU General Public License.
------------------------------------------------------------------------- */

#ifndef LMP_DEFE_MODEL_H
#define LMP_DEFE_MODEL_H

#include "lmptype.h"

#include "defe/coupling/corner_strain.h"
#include "defe/coupling/criterion.h"
#include "defe/coupling/element_split.h"
#include "defe/coupling/joint_laws.h"
#include "defe/coupling/prestress_rule.h"
#include "defe/coupling/strength_field.h"
#include "defe/coupling/tied_surfaces.h"
#include "defe/fe/material_law.h"

#include <memory>
#include <string>
#include <vector>

namespace LAMMPS_NS {

struct DefeMaterial {
  std::string name;
  std::string words;    // law, constants and type of elements
  std::shared_ptr<const defe::fe::MaterialLaw> law;
  bool rigid() const { return law->rigid(); }
  /** Density, and moduli of small and fast deformation. */
  const defe::fe::IsotropicElastic &elastic() const { return law->elastic(); }
};

struct DefePart {
  std::string name;
  int material = -1;
  bool convertible = false;
  std::shared_ptr<const defe::ConversionCriterion> criterion;
  std::string
      criterion_words;    // name and numbers; of the largest principal stress the number alone
  double stress = 0.0;    // in uniaxial tension, at which elements convert
  defe::StrengthField strength;    // of its flaws
  defe::PrestressRule prestress;
  defe::ElementSplit split;    // of its elements into DEs
  int type = 0;                // atom type of its DEs
  int group = 0;               // group its DEs join
  double shield_time = 0.0;    // tau = 3 h / c_d, from the mean element size
  bigint elements = 0;         // when its mesh was made
  bigint slender = 0;          // of these, much longer than thick, see MeshMeasure
  std::string start;           // region converted at step 0, "all", or empty
};

/** Parts whose surfaces are glued. */
struct DefeTiedPair {
  int a, b;
  defe::TieRule rule;
};

/** What the fix command says. Values only: defe_options.cpp reads them. */
struct DefeModel {
  std::vector<DefeMaterial> materials;
  std::vector<DefePart> parts;
  std::vector<defe::Adhesive> adhesives;
  std::vector<DefeTiedPair> tied;
  std::vector<defe::CornerModuli> corner_moduli;    // per part

  bool contact_given = false;    // the keyword, also with 0
  double contact_factor = 0.0;
  double contact_friction = 0.0;
  // overlaps that are there before the first step; of balls those that are deep are refused by default
  bool refuse_overlaps = false, ease_overlaps = false;

  // steps of a window at the end of which elements convert; 0: DefeMarks::window()
  int collect = 1;
  bool in_place = true;    // conversions need no reneighbouring where that is possible
  bool shield = true;
  bool gauss_stress = false;
  bool force_lagrangian = false;
  bool reproducible = false;
#if defined(NDEBUG) && !defined(DEFE_CHECK)
  bool checking = false;    // of all records after every reneighbouring
#else
  bool checking = true;
#endif
  enum EnergyCheck { ENERGY_NO, ENERGY_WARN, ENERGY_STOP } energy_check = ENERGY_WARN;

  bool contact() const
  {
    return contact_factor > 0.0;
  }
  const DefeMaterial &material_of(const DefePart &p) const
  {
    return materials[p.material];
  }
  /** Its elements are enhanced ones. */
  bool enhanced(const DefePart &) const;
  int find_part(const std::string &) const;
  bool any_convertible() const;
  /** IDs that are kept for the DEs of an element, of whatever part. */
  int lot_size() const;
  /** Some elements become a single DE. */
  bool any_single() const;
  /** Null: ties between these parts do not break. */
  const defe::Adhesive *adhesive_of(int part, int base) const
  {
    return defe::find_adhesive(adhesives, part, base);
  }
  bool are_tied(int part, int other) const;
  /** A node's shares can be added and taken away in any order, if sums are to be exact. */
  double element_mass(const DefePart &, double volume) const;
  /** Name, material and type of DEs, in words. */
  std::string describe(const DefePart &) const;
};

}    // namespace LAMMPS_NS

#endif
