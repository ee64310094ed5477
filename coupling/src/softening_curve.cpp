#include "defe/coupling/softening_curve.h"

namespace defe {

// one line per curve, here and in the table below; files with restart data have their numbers: append only
extern const SofteningCurve &linear_softening;         // softening_linear.cpp
extern const SofteningCurve &exponential_softening;    // softening_exponential.cpp

const std::vector<const SofteningCurve *> &softening_curves()
{
  static const std::vector<const SofteningCurve *> all = {&linear_softening,
                                                          &exponential_softening};
  return all;
}

SofteningCurve::~SofteningCurve() = default;

int find_softening_curve(const std::string &name)
{
  const auto &all = softening_curves();
  for (std::size_t k = 0; k < all.size(); ++k)
    if (name == all[k]->name()) return static_cast<int>(k);
  return -1;
}

}    // namespace defe
