// Layered beams of glass and PVB in static bending, against the closed forms of composite and
// sandwich beams.
//
// A beam of span L on two supports under the load q(x) = q0 sin(pi x / L) bends into a sine for
// any of these theories. Half of it is meshed, one element wide and in plane strain; the motion is
// damped until it rests.
//
// 14 s of processor time: the soft interlayer makes the slowest mode slow against the time step of
// the glass, and it has to come to rest.
//
// ranks: 1
// timeout: 300

#include "layers.h"

#include <cmath>

using namespace defe::test;

namespace {

constexpr double pi = 3.14159265358979323846;
constexpr double E = 74.09e9, nu = 0.2, rho_glass = 2500.0, rho_pvb = 1100.0;
constexpr double plane_strain = E / (1.0 - nu * nu), G_glass = E / 2.0 / (1.0 + nu);

struct Beam {
  std::vector<Layer> layers;
  std::string pvb;      // law and constants
  double span, step;    // element length
  double dt;
};

/// Deflection in the middle per q0, expected to be near `estimate` (it sets the damping only).
double deflection(const Beam &b, double estimate)
{
  const double width = b.step, q0 = 1.0e-6 / estimate;    // about 1 um
  const int n = static_cast<int>(std::lround(0.5 * b.span / b.step));
  layered(b.layers, equidistant(0.0, 0.5 * b.span, n), {0.0, width}, 1).write("sandwich.data");
  double height = 0.0, mass = 0.0;
  for (const auto &layer : b.layers) {
    height += layer.thickness;
    mass += layer.thickness * (layer.part == "pvb" ? rho_pvb : rho_glass);
  }
  // critical damping of the sine: nodes of the mean mass
  double nodes = 1.0;
  for (const auto &layer : b.layers) nodes += layer.n;
  const double node_mass = mass * b.step * width / (2.0 * nodes);
  const double omega = std::sqrt(1.0 / estimate / mass), period = 2.0 * pi / omega;

  Lammps lmp;
  lmp.commands(script_head() + R"(
    region          box block -0.002 0.1 -0.01 0.02 -0.002 0.004
    create_box      1 box
    pair_style      zero 1e-3
    pair_coeff      * *
    fix             fe all defe material glass elastic )" +
               number(E) + " " + number(nu) + " " + number(rho_glass) + " material pvb " + b.pvb +
               "\n" + read_mesh("sandwich.data") + R"(
    region          end block INF 1e-9 INF INF INF INF
    region          middle block )" +
               number(0.5 * b.span - 1e-9) + R"( INF INF INF INF INF
    region          top block INF INF )" +
               number(height - 1e-9) + R"( INF INF INF
    group           end region end
    group           middle region middle
    group           top region top
    neighbor        1e-4 bin
    timestep        )" +
               number(b.dt) + R"(
    fix             move all nve
    # the load of a node: half the width, and half a length at the ends
    variable        load atom -)" +
               number(0.5 * q0 * width * b.step) + "*sin(" + number(pi / b.span) +
               R"(*x)*(1-0.5*gmask(middle))
    fix             load top addforce 0 v_load 0
    fix             damping all viscous )" +
               number(2.0 * omega * node_mass) + R"(
    fix             support end setforce NULL 0 NULL
    fix             symmetry middle setforce 0 NULL NULL
    fix             plane all setforce NULL NULL 0
    thermo_style    custom step
  )");
  // the rest position of the middle
  lmp.run(0);
  const double start = lmp.value("xcm(middle,y)");
  lmp.run(static_cast<bigint>(1.5 * period / b.dt));
  const double before = start - lmp.value("xcm(middle,y)");
  lmp.run(static_cast<bigint>(0.25 * period / b.dt));
  const double w = start - lmp.value("xcm(middle,y)");
  EXPECT_NEAR(w, before, 1e-3 * w) << "not at rest";
  return w / q0;
}

/// Bending stiffness per width and shear compliance of layers that stay plane together. E and G of
/// each layer; the shear flow follows from equilibrium.
double composite(const std::vector<Layer> &layers, const std::vector<double> &modulus,
                 const std::vector<double> &shear, double span)
{
  double ES = 0.0, EA = 0.0, y = 0.0;
  for (size_t k = 0; k < layers.size(); k++) {
    EA += modulus[k] * layers[k].thickness;
    ES += modulus[k] * layers[k].thickness * (y + 0.5 * layers[k].thickness);
    y += layers[k].thickness;
  }
  const double neutral = ES / EA;
  double B = 0.0;
  y = -neutral;
  for (size_t k = 0; k < layers.size(); k++) {
    const double t = layers[k].thickness;
    B += modulus[k] * (std::pow(y + t, 3) - std::pow(y, 3)) / 3.0;
    y += t;
  }
  double compliance = 0.0, flow = 0.0;
  y = -neutral;
  for (size_t k = 0; k < layers.size(); k++) {
    const int n = 2000;
    const double dy = layers[k].thickness / n;
    for (int i = 0; i < n; i++) {
      const double middle = flow + modulus[k] * (y + 0.25 * dy) * 0.5 * dy;
      compliance += middle * middle / (B * B * shear[k]) * dy;
      flow += modulus[k] * (y + 0.5 * dy) * dy;
      y += dy;
    }
  }
  const double a = pi / span;
  return 1.0 / (B * std::pow(a, 4)) + compliance / (a * a);
}

}    // namespace

// Glass 2 mm on PVB 6 mm, as stiff as it is in an impact: a third of the stiffness is that of the
// PVB and of its distance.
TEST(Sandwich, TwoLayersBendAsACompositeBeam)
{
  const double G = 0.33e9, K = 20e9;
  const Beam b = {{{"pvb", 0.006, 8}, {"glass", 0.002, 4}},
                  "prony " + number(K) + " " + number(rho_pvb) + " 0.69e6 1 " + number(G - 0.69e6) +
                      " 1e-3",
                  0.07,
                  5e-4,
                  6e-8};
  const double E_pvb = 9.0 * K * G / (3.0 * K + G), nu_pvb = 0.5 * E_pvb / G - 1.0;
  const double exact =
      composite(b.layers, {E_pvb / (1.0 - nu_pvb * nu_pvb), plane_strain}, {G, G_glass}, b.span);
  const double w = deflection(b, exact);
  EXPECT_NEAR(w / exact, 1.0, 0.03);
  // without the PVB it would be far from that
  EXPECT_GT(composite({b.layers[1]}, {plane_strain}, {G_glass}, b.span) / exact, 1.8);
}

// Glass / PVB / glass with a soft and a stiff interlayer: faces that bend by themselves, coupled by
// the shear of the core (partial interaction: Stamm and Witte; Allen, Analysis and Design of
// Structural Sandwich Panels),
//   B = B_f + B_s / (1 + (pi/L)^2 B_s / S),  B_f = sum E h^3/12,  B_s = E h d^2 / 2,  S = G d^2 / t.
TEST(Sandwich, ThreeLayersBendAsASandwich)
{
  const double h = 0.002, t = 0.76e-3, span = 0.08, d = h + t, a = pi / span;
  const double Bf = plane_strain * h * h * h / 6.0, Bs = 0.5 * plane_strain * h * d * d;
  for (double G : {10e6, 330e6}) {
    const double S = G * d * d / t;
    const double B = Bf + Bs / (1.0 + a * a * Bs / S);
    const double exact = 1.0 / (B * std::pow(a, 4));
    const Beam b = {{{"glass", h, 5}, {"pvb", t, 2}, {"glass", h, 5}},
                    "mooney " + number(0.5 * G) + " 0 " + number(60.0 * G) + " " + number(rho_pvb),
                    span,
                    4e-4,
                    3.5e-8};
    const double w = deflection(b, exact);
    EXPECT_NEAR(w / exact, 1.0, 0.03) << G;
    // neither loose nor rigidly coupled
    EXPECT_GT(B, 1.2 * Bf);
    EXPECT_LT(B, 0.95 * (Bf + Bs));
  }
}
