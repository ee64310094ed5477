#ifndef DEFE_COUPLING_STRENGTH_FIELD_H
#define DEFE_COUPLING_STRENGTH_FIELD_H

/// \file
/// Strength that scatters: the stress at which flaws of the surface, or of the inside, start a crack. A distribution
/// is a file of its own (see src/strength_weibull.cpp) and a line in src/strength_field.cpp.
///
/// Weakest link: flaws are independent, so a piece of size A (area of a surface, or volume) survives the stress sigma
/// with the probability
///
///     P = exp(-(A/A0) H(sigma))
///
/// H(sigma) >= 0 never falls, and A0 is the size for which it is given. With u uniform in (0, 1) the strength of the
/// piece is H^-1(-(A0/A) ln u), and the least of the strengths of pieces that make up a body is distributed as that of
/// the body, whatever the pieces: it does not depend on the mesh.
///
/// One draw for each place of an element (ElementSplit), that is for the DE that is born there: from its share of the
/// element's volume and, of its faces on a named surface, of their area. The strength of a DE is the least of its draws,
/// that of an element the least of its places: the body has the same distribution before elements convert and after it.
/// What is drawn is a function of the seed, the surface, the ID of the element and the number of the place alone: the
/// same for any ranks, in any order, whether the element converts late or is discrete from the start.

#include "defe/coupling/element_split.h"
#include "defe/coupling/flaw_growth.h"
#include "defe/fe/material_law.h"
#include "defe/types.h"

#include <cstdint>
#include <memory>
#include <string>
#include <vector>

namespace defe {

class StrengthLaw {
 public:
  StrengthLaw() = default;
  StrengthLaw(const StrengthLaw &) = delete;
  StrengthLaw &operator=(const StrengthLaw &) = delete;
  virtual ~StrengthLaw();

  /// H^-1: the stress at which H reaches `hazard` > 0.
  virtual double stress(double hazard) const = 0;

  /// As given after the name.
  virtual std::vector<double> numbers() const = 0;

  /// False: the same everywhere; there is no size, and no seed.
  virtual bool random() const { return true; }
};

/// How a distribution is registered: see src/strength_field.cpp.
struct StrengthLawEntry {
  const char *name;
  const char *usage;    ///< name and parameters, as in an input line
  /// Reads the numbers. Sets `complaint` to one line and returns null if they are not usable.
  std::unique_ptr<StrengthLaw> (*make)(fe::LawWords &words, std::string &complaint);
};

/// All registered distributions.
const std::vector<const StrengthLawEntry *> &strength_laws();

/// Flaws of a surface, or of the inside.
struct Flaws {
  std::shared_ptr<const StrengthLaw> law;
  const char *name = "";     ///< of the law
  std::string surface;       ///< empty: the inside
  double reference = 1.0;    ///< A0, an area or a volume
  std::int64_t seed = 0;

  /// Strength of the piece of this size at a place of an element; infinite if there is nothing of it.
  double draw(std::int64_t element, int place, double size) const;
  /// As in an input line, from the name of the law on; numbers in one way of writing.
  std::string words() const;
};

struct ParsedFlaws {
  Flaws flaws;
  std::string complaint;    ///< one line: what is wrong with which value, and what to write instead
  int used = 0;             ///< number of words that belong to it
};

/// words: the name of a distribution, its numbers, and in any order the rest; then whatever else follows on the line.
///
///     weibull shape scale                ... volume V0 seed N                 of the inside
///     threshold shape scale sigma_u      ... area A0 seed N surface NAME      of the faces of a surface
///     truncated shape scale sigma_0
///     constant strength                  ... [surface NAME]
ParsedFlaws parse_flaws(const std::vector<std::string> &words);

/// Of a place of an element: what of its volume and of each of its faces belongs to it (0: the face is elsewhere).
struct PlaceSize {
  double volume;
  double area[6];
};
std::vector<PlaceSize> place_sizes(const fe::HexCoords &X, ElementSplit = ElementSplit());

/// All flaws of a part.
struct StrengthField {
  std::vector<Flaws> flaws;
  FlawGrowth growth = {};

  bool given() const { return !flaws.empty(); }
  /// Strengths of the DEs of an element by its places.
  /// \param faces  of each of the flaws: a bit for each face of the element that is on their surface; inside: not used
  std::vector<double> draw(std::int64_t element, const std::vector<PlaceSize> &,
                           const std::vector<unsigned> &faces) const;
};

}    // namespace defe

#endif
