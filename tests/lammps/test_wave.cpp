// A free bar carries a pulse along at the bar speed sqrt(E/rho).
//
// timeout: 120

#include "lammps_run.h"

#include <cmath>

using namespace defe::test;

namespace {

constexpr double E = 74.09e9, rho = 2500.0;    // glass
constexpr double L = 0.2, dt = 1.5e-7;         // dt: 0.9 of the critical step for nu = 0.2
const double c = std::sqrt(E / rho);           // 5443.9 m/s

/// A free bar of 200 mm along x, width x width, with so many elements across.
std::string bar(double nu, double width, int across)
{
  const std::string end = " 0 " + std::to_string(across) + " " + number(width);
  return script_head() + R"(
    region          box block -0.01 0.21 -0.005 0.015 -0.005 0.015
    create_box      1 box
    pair_style      zero 0.002
    pair_coeff      * *
    fix             fe all defe material glass elastic )" +
      number(E) + " " + number(nu) + " " + number(rho) + "\ncreate_hexes fe glass 1 x 0 100 0.2 y" +
      end + " z" + end + "\nfix move all nve\nneighbor 0.0002 bin\ntimestep " + number(dt) + "\n";
}

/// The bar 200 x 10 x 10 mm with a velocity V(x) = cos^2(pi x/(2 W)) for x < W (a bump of full
/// width 2 W and its mirror image at the free end x = 0). d'Alembert: half of it runs off to the
/// right, as V(x - c t)/2.
void pulse(double nu, double W)
{
  Lammps lmp;
  lmp.commands(bar(nu, 0.01, 5));
  lmp.commands("variable W equal " + number(W) + R"(
    variable        V atom (x<v_W)*cos(PI*x/(2*v_W))^2
    velocity        all set v_V 0 0
    variable        mvx atom mass*vx*x
    variable        mv atom mass*vx
    compute         sums all reduce sum v_mvx v_mv
    region          gauge block 0.1599 0.1601 INF INF INF INF
    group           gauge region gauge
    compute         gauge gauge reduce ave vx
  )");
  lmp.record({"c_gauge", "f_fe[22]", "c_sums[1]", "c_sums[2]"}, 1);
  const double end = 0.155 / c;    // the pulse still is inside the bar, its front at end c + W
  lmp.run(static_cast<bigint>(std::ceil(end / dt)));
  const auto v = lmp.recorded(0), energy = lmp.recorded(1), mvx = lmp.recorded(2),
             mv = lmp.recorded(3);

  // The pulse reaches half its height at x = 0.16 when x = c t + W/2. Asked: 1 %. Both dispersions
  // (mesh: k^2 h^2/24, lateral inertia: nu^2 r_p^2 k^2/2, k = pi/W) are below 0.3 %.
  std::vector<double> above;
  for (double a : v) above.push_back(a - 0.25);
  const double arrival = zero_crossing(above) * dt;
  EXPECT_NEAR((0.16 - W / 2.0) / arrival / c, 1.0, 0.01);

  // The peak passes with half the initial velocity; the bump's edges are not smooth, and dispersion
  // of what is short in it takes 2 (nu = 0) and 4 per cent off the height.
  double peak = 0.0;
  for (double a : v) peak = std::max(peak, a);
  EXPECT_NEAR(peak, 0.49, 0.015);

  // The centroid of the momentum moves with the speed of the longest waves, free of dispersion:
  // d/dt sum(m v x) = sum(m v^2) + sum(f x), the second term the longitudinal stress in the bar.
  // Left are the nonlinearity (strains of 1e-4 = v/c), and the waves faster than the bar's that
  // start where the initial velocity field lacks the lateral motion: 6e-4 with nu = 0.2, 3e-6 with
  // nu = 0.
  const size_t i = static_cast<size_t>(0.08 / c / dt), j = v.size() - 1;
  const double speed = (mvx[j] / mv[j] - mvx[i] / mv[i]) / (static_cast<double>(j - i) * dt);
  EXPECT_NEAR(speed / c, 1.0, nu == 0.0 ? 5e-5 : 2e-3);

  // omega dt = pi c dt/W = 0.06: the energy of velocity Verlet swings by its square/4
  EXPECT_LT(largest_deviation(energy), 1e-3 * energy.front());
  EXPECT_NEAR(mv.back() / mv.front(), 1.0, 1e-10);    // nothing holds it
}

}    // namespace

TEST(Wave, PulseInBarWithoutLateralContraction)
{
  pulse(0.0, 0.04);
}

TEST(Wave, PulseInGlassBar)
{
  pulse(0.2, 0.04);
}

// fix viscous with rho c A at the nodes of an end takes up the wave (fix_defe.rst, Edges). A bar of one
// row of elements without lateral contraction: there is one speed, and each of the four nodes has A = h^2/4.
TEST(Wave, NonReflectingEnd)
{
  const double h = 2e-3, W = 0.04;
  const auto left = [&](bool quiet) {
    Lammps lmp;
    lmp.commands(bar(0.0, h, 1) + R"(
      region          right block 0.1999 INF INF INF INF INF
      group           right region right
      variable        V atom (x<0.04)*cos(PI*x/0.08)^2
      velocity        all set v_V 0 0)");
    if (quiet) lmp.command("fix quiet right viscous " + number(rho * c * h * h / 4.0));
    lmp.run(0);
    const double energy = lmp.fe(TOTAL);
    lmp.run(static_cast<bigint>((0.2 + 2.0 * W) / c / dt));
    // the work that the dashpots take is external: total = elastic + kinetic + what they took
    EXPECT_NEAR(lmp.fe(TOTAL) / energy, 1.0, 1e-3);
    return (lmp.fe(E_ELEMENTS) + lmp.fe(E_KINETIC)) / energy;
  };
  EXPECT_NEAR(left(false), 1.0, 1e-3);
  // of the energy; 1 % of the velocity comes back
  EXPECT_LT(left(true), 1e-3);
}
