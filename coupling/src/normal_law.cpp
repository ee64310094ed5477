#include "defe/coupling/normal_law.h"

#include <cstddef>

namespace defe {

// one line per law, here and in the table below; files with restart data have their numbers: append only
extern const NormalLaw &linear_normal;    // normal_linear.cpp
extern const NormalLaw &hertz_normal;     // normal_hertz.cpp

const std::vector<const NormalLaw *> &normal_laws()
{
  static const std::vector<const NormalLaw *> all = {&linear_normal, &hertz_normal};
  return all;
}

NormalLaw::~NormalLaw() = default;

int find_normal_law(const std::string &name)
{
  const auto &all = normal_laws();
  for (std::size_t k = 0; k < all.size(); ++k)
    if (name == all[k]->name()) return static_cast<int>(k);
  return -1;
}

}    // namespace defe
