#include "defe/coupling/opening_law.h"

#include <cstddef>

namespace defe {

// one line per law, here and in the table below; files with restart data have their numbers: append only
extern const OpeningLaw &rings_opening;      // opening_rings.cpp
extern const OpeningLaw &lattice_opening;    // opening_lattice.cpp

const std::vector<const OpeningLaw *> &opening_laws()
{
  static const std::vector<const OpeningLaw *> all = {&rings_opening, &lattice_opening};
  return all;
}

OpeningLaw::~OpeningLaw() = default;

int find_opening_law(const std::string &name)
{
  const auto &all = opening_laws();
  for (std::size_t k = 0; k < all.size(); ++k)
    if (name == all[k]->name()) return static_cast<int>(k);
  return -1;
}

std::string names_of_opening_laws(bool by_cracks)
{
  std::string names;
  for (const auto *law : opening_laws())
    if (law->by_cracks() == by_cracks)
      names += (names.empty() ? "" : " or ") + std::string(law->name());
  return names;
}

const OpeningLaw &opening_law_of_ties()
{
  return lattice_opening;
}

}    // namespace defe
