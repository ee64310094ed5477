#include "criterion_words.h"

#include "defe/coupling/criterion.h"

#include <Eigen/Eigenvalues>
#include <cmath>

namespace defe {

namespace {

  /// Mohr-Coulomb, tension positive: on some plane the shear traction is above c - sigma_n tan(phi), which is
  ///
  ///     sigma_1 - k sigma_3 > f_t,  k = (1 - sin phi)/(1 + sin phi),  f_t = 2 c cos(phi)/(1 + sin phi)
  ///
  /// (Labuz and Zang, Rock Mech. Rock Eng. 45 (2012) 975). f_t is the strength in uniaxial tension, f_t/k that in
  /// compression. With sigma_1 = p + 2 sqrt(J2/3) cos(theta) and sigma_3 = p - 2 sqrt(J2/3) cos(pi/3 - theta) the value is
  /// p (1 - k) + 2 sqrt(J2/3) (cos(theta) + k cos(pi/3 - theta)), and the bracket has the amplitude
  /// sqrt(1 + k + k^2): the bound is the cone of Drucker and Prager that is inscribed into the pyramid.
  class MohrCoulomb : public ConversionCriterion {
   public:
    MohrCoulomb(double cohesion, double degrees) : cohesion(cohesion), degrees(degrees)
    {
      const double phi = degrees * (3.14159265358979323846 / 180.0);
      k = (1.0 - std::sin(phi)) / (1.0 + std::sin(phi));
      tension = 2.0 * cohesion * std::cos(phi) / (1.0 + std::sin(phi));
    }
    double value(const Mat3 &s, Vec3 &direction) const override
    {
      const Eigen::SelfAdjointEigenSolver<Mat3> solver(s);
      direction = solver.eigenvectors().col(2);
      return solver.eigenvalues()[2] - k * solver.eigenvalues()[0];
    }
    double limit() const override { return tension; }
    fe::StressBound bound() const override { return {1.0 - k, 2.0 * std::sqrt(1.0 + k + k * k)}; }
    double tensile_stress() const override { return tension; }
    std::vector<double> numbers() const override { return {cohesion, degrees}; }

   private:
    double cohesion, degrees, k, tension;
  };

  std::unique_ptr<ConversionCriterion> make(fe::LawWords &words, const fe::IsotropicElastic &,
                                            std::string &complaint)
  {
    const double cohesion = positive(words, "cohesion", complaint);
    const double degrees = words.number("angle of internal friction");
    if (complaint.empty() && !(degrees >= 0.0 && degrees < 90.0))
      complaint =
          "angle of internal friction must be from 0 to less than 90 degrees, not " + words.last();
    return std::make_unique<MohrCoulomb>(cohesion, degrees);
  }

}    // namespace

extern const CriterionEntry mohr_criterion;
const CriterionEntry mohr_criterion = {"mohr", "mohr cohesion angle", make};

}    // namespace defe
