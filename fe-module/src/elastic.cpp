#include "defe/fe/elastic.h"

#include <cmath>
#include <sstream>

namespace defe::fe {

double IsotropicElastic::lambda() const
{
  return E * nu / ((1.0 + nu) * (1.0 - 2.0 * nu));
}

double IsotropicElastic::mu() const
{
  return E / (2.0 * (1.0 + nu));
}

double IsotropicElastic::bulk() const
{
  return E / (3.0 * (1.0 - 2.0 * nu));
}

double IsotropicElastic::c_dilatational() const
{
  return std::sqrt((lambda() + 2.0 * mu()) / rho);
}

double IsotropicElastic::c_bar() const
{
  return std::sqrt(E / rho);
}

std::string IsotropicElastic::validate() const
{
  // written so that NaN fails as well
  std::ostringstream complaint;
  if (!(E > 0.0 && std::isfinite(E)))
    complaint << "Young's modulus must be positive, not " << E;
  else if (!(nu > -1.0 && nu < 0.5))
    complaint << "Poisson's ratio must lie between -1 and 0.5, not " << nu;
  else if (!(rho > 0.0 && std::isfinite(rho)))
    complaint << "density must be positive, not " << rho;
  return complaint.str();
}

}    // namespace defe::fe
