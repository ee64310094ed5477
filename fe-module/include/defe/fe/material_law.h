#ifndef DEFE_FE_MATERIAL_LAW_H
#define DEFE_FE_MATERIAL_LAW_H

#include "defe/fe/elastic.h"
#include "defe/fe/kernel.h"

#include <initializer_list>
#include <memory>
#include <string>
#include <vector>

namespace defe::fe {

/// A material as a user gives it, "LAW numbers...". What a law does for the code that uses it is
/// here; a new one is a file of its own (see src/law_mooney.cpp) and a line in
/// src/material_law.cpp.
class MaterialLaw {
 public:
  MaterialLaw() = default;
  MaterialLaw(const MaterialLaw &) = delete;
  MaterialLaw &operator=(const MaterialLaw &) = delete;
  virtual ~MaterialLaw();

  /// Density and the elastic constants of small and fast deformation (instantaneous moduli): for
  /// contact stiffness, wave speeds, time steps. Of a rigid body only rho is set.
  virtual const IsotropicElastic &elastic() const = 0;

  /// No deformation and no kernels.
  virtual bool rigid() const { return false; }

  /// Has plastic strain, see HexKernel::plastic_state().
  virtual bool yields() const { return false; }

  /// Linear isotropic elasticity, up to what finite rotation needs: the law that discrete elements
  /// can go on with. Elements of any other law cannot be converted.
  virtual bool linear() const { return false; }

  /// Of laws that have a choice, which elements it is: the word that follows their numbers.
  virtual const char *elements() const;

  /// A kernel for elements of any shape; null if rigid().
  virtual std::unique_ptr<HexKernel> make_kernel() const = 0;

  /// True if there is a faster kernel for all elements congruent to X, which make_shape_kernel(X)
  /// makes.
  virtual bool has_shape_kernel(const HexCoords &X) const;
  virtual std::unique_ptr<HexKernel> make_shape_kernel(const HexCoords &X) const;

  /// Critical time step of one element, see stable_step.h; infinite if rigid().
  virtual double critical_step(const HexCoords &X) const = 0;
};

/// Numbers of an input line for a law, taken one by one. The first word that is missing or not a
/// finite number makes the complaint, and everything read from then on is 0.
class LawWords {
 public:
  /// words[0] is the name of the law.
  LawWords(const std::vector<std::string> &words, const char *usage) : words(words), usage(usage) {}

  double number(const char *name);
  int count(const char *name, int lowest, int highest);
  /// Takes the next word if it is one of these, and returns which; else -1.
  int optional(std::initializer_list<const char *> choices);

  int used() const { return next; }
  /// The word that was read last.
  const std::string &last() const { return words[next - 1]; }
  const std::string &complaint() const { return text; }

 private:
  const std::vector<std::string> &words;
  const char *usage;
  int next = 1;
  std::string text;

  const std::string *word(const char *name);
};

/// How a law is registered: see src/material_law.cpp.
struct MaterialLawEntry {
  const char *name;
  const char *usage;    ///< name and parameters, as in an input line
  /// Reads the numbers. Sets `complaint` to one line and returns null if they are not usable.
  std::unique_ptr<MaterialLaw> (*make)(LawWords &words, std::string &complaint);
};

struct ParsedMaterial {
  std::shared_ptr<const MaterialLaw> law;    ///< null if there is a complaint
  std::string complaint;    ///< one line: what is wrong with which value, and what to write instead
  int used = 0;             ///< number of words that belong to the law, its name included
  /// Those words, in one form: enhanced elements are named though they are the default, plain ones are not.
  std::string description;
};

/// words: the name of a law, its numbers, and whatever else follows on the line.
///
///     elastic E nu rho [enhanced|plain]
///     mooney C10 C01 K rho
///     prony K rho G_inf N G_1 beta_1 ... G_N beta_N
///     plastic E nu rho sigma_y H [kinematic H_k]
///     johnson-cook E nu rho A B n C rate [thermal m T_0 T_melt c_p chi]
///     rigid rho
ParsedMaterial parse_material(const std::vector<std::string> &words);

/// All registered laws.
const std::vector<const MaterialLawEntry *> &material_laws();

}    // namespace defe::fe

#endif
