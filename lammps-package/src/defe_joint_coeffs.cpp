/* ----------------------------------------------------------------------
   DEFE: adaptive finite elements to bonded discrete elements for LAMMPS
   https://www.lammps.org/
   This software is distributed under the GNU General Public License.
------------------------------------------------------------------------- */

#include "defe_joint_coeffs.h"

#include "atom.h"
#include "error.h"

#include "defe/coupling/contact_law.h"
#include "defe/coupling/normal_law.h"

#include <cstring>
#include <stdexcept>
#include <string>
#include <vector>

using namespace LAMMPS_NS;

namespace {

template <class Law> std::string names_of(const std::vector<const Law *> &all)
{
  std::string names;
  for (const auto *law : all) names += (names.empty() ? "" : " or ") + std::string(law->name());
  return names;
}

/// What may follow the numbers of a keyword.
std::string words_after(const std::string &key)
{
  if (key == "contact") return ", or after its numbers " + names_of(defe::normal_laws());
  if (key == "cohesive")
    return ", or after its numbers reciprocal, overstrength X, scatter Y, " +
        names_of(defe::softening_curves()) + ", " + names_of(defe::opening_laws());
  return "";
}

}    // namespace

JointCoeffReader::JointCoeffReader(LAMMPS *lmp, int n, char **words) :
    Pointers(lmp), narg(n), arg(words)
{
}

void JointCoeffReader::need(int n, const char *what)
{
  if (iarg + n > narg) utils::missing_cmd_args(FLERR, std::string("pair_coeff ") + what, error);
}

double JointCoeffReader::number(int k)
{
  return utils::numeric(FLERR, arg[iarg + k], false, lmp);
}

void JointCoeffReader::read(defe::JointLaws &laws)
{
  find_types();
  defe::JointCoeff c;
  std::string before;
  while (iarg < narg) {
    const std::string key = arg[iarg];
    if (key == "connective") {
      need(2, "connective E nu");
      if (!laws.with_connective)
        error->all(FLERR, "Pair_coeff connective: this pair style has no connective joints");
      read_connective(c);
    } else if (key == "cohesive") {
      need(4, "cohesive sigma_t G_f beta");
      if (!laws.with_cohesive)
        error->all(FLERR, "Pair_coeff cohesive: this pair style has no cohesive joints");
      read_cohesive(c);
    } else if (key == "contact") {
      need(3, "contact restitution friction");
      if (!laws.with_contact)
        error->all(FLERR, "Pair_coeff contact: this pair style has no contact law");
      read_contact(c);
    } else
      error->all(FLERR, "Unknown pair_coeff keyword {}: use connective, cohesive or contact{}", key,
                 words_after(before));
    before = key;
  }
  assign(laws, c);
}

void JointCoeffReader::read_connective(defe::JointCoeff &c)
{
  c.has_connective = true;
  if (strcmp(arg[iarg + 1], "material") == 0) {
    iarg += 2;
    return;
  }
  need(3, "connective E nu");
  c.E = number(1);
  c.nu = number(2);
  if (!(c.E > 0.0)) error->all(FLERR, "Pair_coeff connective: E must be > 0, not {}", c.E);
  if (!(c.nu > -1.0 && c.nu < 0.5))
    error->all(FLERR, "Pair_coeff connective: nu must be between -1 and 0.5, not {}", c.nu);
  iarg += 3;
}

void JointCoeffReader::read_cohesive(defe::JointCoeff &c)
{
  c.has_cohesive = true;
  c.cohesive.sigma_t = number(1);
  c.cohesive.G_f = number(2);
  c.cohesive.beta = number(3);
  iarg += 4;
  read_words(c);
  if (!(c.cohesive.sigma_t > 0.0) || !(c.cohesive.G_f > 0.0) || !(c.cohesive.beta >= 0.0))
    error->all(FLERR, "Pair_coeff cohesive: sigma_t and G_f must be > 0, beta >= 0");
  if (c.cohesive.reciprocal && c.cohesive.beta == 0.0)
    error->all(FLERR, "Pair_coeff cohesive: beta must be > 0 with reciprocal");
}

/* ----------------------------------------------------------------------
   what may follow the numbers of "cohesive"
------------------------------------------------------------------------- */

void JointCoeffReader::read_words(defe::JointCoeff &c)
{
  std::string of_nuclei;
  for (; iarg < narg; iarg++) {
    const std::string word = arg[iarg];
    if (word == "reciprocal")
      c.cohesive.reciprocal = true;
    else if (const int opening = defe::find_opening_law(word); opening >= 0)
      c.opening = static_cast<unsigned char>(opening);
    else if (const int curve = defe::find_softening_curve(word); curve >= 0)
      c.cohesive.softening = static_cast<unsigned char>(curve);
    else if (word == "overstrength" || word == "scatter") {
      if (iarg + 1 >= narg) utils::missing_cmd_args(FLERR, "pair_coeff cohesive " + word, error);
      of_nuclei = word;
      double &number = word == "scatter" ? c.nuclei.scatter : c.nuclei.overstrength;
      number = utils::numeric(FLERR, arg[++iarg], false, lmp);
    } else
      break;
  }
  const auto &n = c.nuclei;
  if (!(n.overstrength >= 1.0 && n.overstrength <= 100.0))
    error->all(FLERR,
               "Pair_coeff cohesive: overstrength, of joints beside a crack in strengths, must be "
               "from 1 to 100, not {}",
               n.overstrength);
  if (!(n.scatter >= 0.0 && n.scatter <= 1.0))
    error->all(FLERR,
               "Pair_coeff cohesive: scatter, of the strength of nuclei, must be from 0 to 1, "
               "not {}",
               n.scatter);
  const auto &opening = *defe::opening_laws()[c.opening];
  if (!opening.by_cracks() && !of_nuclei.empty())
    error->all(FLERR,
               "Pair_coeff cohesive: with {} each joint has sigma_t and nothing else: leave {} out",
               opening.name(), of_nuclei);
}

void JointCoeffReader::read_contact(defe::JointCoeff &c)
{
  c.has_contact = true;
  c.restitution = number(1);
  c.friction = number(2);
  if (!(c.restitution > 0.0 && c.restitution <= 1.0))
    error->all(FLERR, "Pair_coeff contact: restitution must be in (0, 1], not {}", c.restitution);
  if (!(c.friction >= 0.0))
    error->all(FLERR, "Pair_coeff contact: friction must be >= 0, not {}", c.friction);
  c.damping_ratio = defe::damping_ratio(c.restitution);
  iarg += 3;
  if (const int law = iarg < narg ? defe::find_normal_law(arg[iarg]) : -1; law >= 0) {
    c.normal_law = static_cast<unsigned char>(law);
    iarg++;
  }
}

void JointCoeffReader::find_types()
{
  try {
    utils::bounds(FLERR, arg[0], 1, atom->ntypes, ilo, ihi, error);
    utils::bounds(FLERR, arg[1], 1, atom->ntypes, jlo, jhi, error);
  } catch (std::logic_error &) {    // LAMMPS hands on those of std::stol, for instance for "1*-"
    error->all(FLERR, "Pair_coeff: {} {} are no ranges of atom types", arg[0], arg[1]);
  }
}

void JointCoeffReader::assign(defe::JointLaws &laws, const defe::JointCoeff &c) const
{
  int count = 0;
  for (int i = ilo; i <= ihi; i++)
    for (int j = MAX(jlo, i); j <= jhi; j++) {
      laws.coeffs[laws.index(i, j)] = laws.coeffs[laws.index(j, i)] = c;
      count++;
    }
  if (count == 0) error->all(FLERR, "Pair_coeff: no pair of types {} {}", arg[0], arg[1]);
}
