#include "defe/coupling/penalty.h"

namespace defe {

double penalty_stiffness_per_area(double f_s, double K, double A, double V)
{
  return f_s * K * A / V;
}

}    // namespace defe
