// One hexahedron becomes eight DEs: what is conserved, and what is not.

#include "de_block.h"

#include "defe/coupling/facet.h"
#include "defe/fe/element_batch.h"
#include "defe/fe/prestress.h"

#include <gtest/gtest.h>

#include <cstdio>

using namespace defe;
using namespace defe::test;

namespace {

const fe::IsotropicElastic glass{74.09e9, 0.2, 2500.0};

fe::HexCoords cube(double h)
{
  fe::HexCoords X;
  for (int k = 0; k < 8; ++k)
    for (int a = 0; a < 3; ++a) X(a, k) = 0.5 * h * fe::hex_sign[k][a];
  return X;
}

fe::HexCoords random_hex(std::mt19937 &random, double amount)
{
  fe::HexCoords X = cube(2.0);
  for (int k = 0; k < 8; ++k) X.col(k) += random_vector(random, amount);
  return X;
}

}    // namespace

TEST(Conversion, Cube)
{
  const double h = 2e-3, mass = 3.0;
  const auto de = convert_hex(cube(h), cube(h), fe::HexCoords::Zero(), mass);
  for (int k = 0; k < 8; ++k) {
    EXPECT_EQ(de[k].place, k);
    EXPECT_DOUBLE_EQ(de[k].mass, mass / 8.0);
    EXPECT_NEAR(de[k].radius, h / 4.0, 1e-15 * h);
    EXPECT_NEAR(de[k].volume, h * h * h / 8.0, 1e-14 * h * h * h);
    EXPECT_EQ(de[k].omega, Vec3(Vec3::Zero()));
    for (int s = 0; s < 6; ++s) {
      Vec3 out = Vec3::Zero();
      out[s / 2] = s % 2 ? 1.0 : -1.0;
      EXPECT_LT((de[k].face[s] - out * h / 4.0).norm(), 1e-15 * h);
      EXPECT_LT((de[k].area_normal[s] - out * h * h / 4.0).norm(), 1e-15 * h * h);
      EXPECT_NEAR(de[k].area[s], h * h / 4.0, 1e-15 * h * h);
      // outer slots point away from the centre of the element
      EXPECT_EQ(ElementSplit().outer(k, s), out.dot(de[k].X) > 0.0);
    }
    for (int a = 0; a < 3; ++a) EXPECT_DOUBLE_EQ(de[k].X[a], fe::hex_sign[k][a] * h / 4.0);
    const GeneralCell cell = cell_of(de, k);
    EXPECT_TRUE(is_orthogonal(cell));
    for (int s = 0; s < 6; ++s)
      EXPECT_NEAR(cell.dX[s].norm(), ElementSplit().outer(k, s) ? 0.0 : h / 2.0, 1e-15 * h);
  }
}

TEST(Conversion, MassMomentumAndGeometryOfAnyHex)
{
  std::mt19937 random(1);
  for (int test = 0; test < 20; ++test) {
    const fe::HexCoords X = random_hex(random, 0.3), x = random_hex(random, 0.3);
    fe::HexCoords v;
    for (int k = 0; k < 8; ++k) v.col(k) = random_vector(random, 5.0);
    const double mass = 2.7;
    const ElementSplit split(1 + test % 3);
    const auto de = convert_hex(X, x, v, mass, split);
    ASSERT_EQ(static_cast<int>(de.size()), split.des());
    double m = 0.0, volume = 0.0;
    Vec3 momentum = Vec3::Zero(), before = Vec3::Zero(), centre = Vec3::Zero();
    for (int k = 0; k < 8; ++k) {
      before += mass / 8.0 * v.col(k);
      centre -= 0.125 * x.col(k);
    }
    for (int k = 0; k < split.des(); ++k) {
      m += de[k].mass;
      volume += de[k].volume;
      momentum += de[k].mass * de[k].v;
      centre += de[k].x / split.des();
      Vec3 closed = Vec3::Zero();
      for (int s = 0; s < 6; ++s) {
        closed += de[k].area_normal[s];
        EXPECT_GT(de[k].area_normal[s].dot(de[k].face[s]), 0.0);
        if (split.outer(k, s)) continue;
        const NewDE &other = de[split.beside(k, s)];
        EXPECT_LT((de[k].area_normal[s] + other.area_normal[s ^ 1]).norm(), 1e-14);
        EXPECT_LT((de[k].X + de[k].face[s] - other.X - other.face[s ^ 1]).norm(), 1e-14);
      }
      EXPECT_LT(closed.norm(), 1e-14);
    }
    EXPECT_NEAR(m, mass, 1e-15 * mass);
    EXPECT_NEAR(volume, fe::volume(X), 1e-13);
    EXPECT_LT((momentum - before).norm(), 1e-14 * mass * 5.0);
    EXPECT_LT(centre.norm(), 1e-14);    // the centre of mass stays
  }
}

TEST(Conversion, SpinIsHalfTheCurlInTheCurrentConfiguration)
{
  std::mt19937 random(2);
  const fe::HexCoords X = random_hex(random, 0.2);
  const Mat3 F = random_rotation(random) * (Mat3::Identity() + 0.3 * Mat3::Random());
  const fe::HexCoords x = F * X;
  const Vec3 omega(1.0, -2.0, 3.0);
  Mat3 D = Mat3::Random();
  D = (D + D.transpose()).eval();
  fe::HexCoords v;
  for (int k = 0; k < 8; ++k)
    v.col(k) = Vec3(4.0, 5.0, 6.0) + omega.cross(Vec3(x.col(k))) + D * x.col(k);
  for (const NewDE &d : convert_hex(X, x, v, 1.0)) {
    EXPECT_LT((d.omega - omega).norm(), 1e-13);
    EXPECT_LT((d.v - Vec3(4.0, 5.0, 6.0) - omega.cross(d.x) - D * d.x).norm(), 1e-13);
    EXPECT_LT((d.x - F * d.X).norm(), 1e-14);
  }
}

// Uniform strain: the energy of a block does not change whichever inner elements are converted,
// ties included.
TEST(Conversion, UniformStrainEnergyEqualsThatOfTheFiniteElements)
{
  std::mt19937 random(3);
  Mat3 A;
  A << 1.0, 0.25, -0.125, 0.125, 0.75, 0.25, 0.0, -0.25, 1.25;
  const int N = 5;
  for (int along : {1, 2, 3})
    for (bool sheared : {false, true}) {
      const double fraction = 0.5;
      Mesh mesh = box_mesh(N, N, N, 2e-3, [&](const Vec3 &X) {
        return sheared ? Vec3(A * X) : X;
      });
      shuffle_local_axes(mesh, random);
      std::vector<char> none(mesh.hex.size(), 0), some = none;
      for (int e = 0; e < N * N * N; ++e) {
        const int c[3] = {e % N, e / N % N, e / N / N};
        some[e] = *std::min_element(c, c + 3) > 0 && *std::max_element(c, c + 3) < N - 1 &&
            uniform(random, 0.0, 1.0) < fraction;
      }
      const Block finite(mesh, none, glass);
      Block mixed(mesh, some, glass, ElementSplit(along));
      Mat3 H;
      for (int k = 0; k < 9; ++k) H(k / 3, k % 3) = uniform(random, -1e-3, 1e-3);
      const Mat3 F = random_rotation(random) * (Mat3::Identity() + H);
      Vectors f;
      const double energy = finite.forces(deformed(finite.X, F), f);
      EXPECT_NEAR(mixed.forces(deformed(mixed.X, F), f), energy, 1e-10 * energy);
      if (sheared) continue;
      mixed.orthogonal = true;
      EXPECT_NEAR(mixed.forces(deformed(mixed.X, F), f), energy, 1e-10 * energy);
    }
}

// Corner volumes of distorted hexes (midpoint rule) against the true ones.
TEST(Conversion, VolumesOfDistortedHexes)
{
  std::mt19937 random(4);
  const double amount[3] = {0.05, 0.10, 0.20};
  for (double q : amount) {
    double worst = 0.0, sum = 0.0, exact = 0.0;
    for (int test = 0; test < 100; ++test) {
      const fe::HexCoords X = random_hex(random, 2.0 * q);
      const auto de = convert_hex(X, X, fe::HexCoords::Zero(), 1.0);
      double corners = 0.0;
      for (int k = 0; k < 8; ++k)
        for (int c = 0; c < 8; ++c) {
          const Vec3 *const h = de[k].face;
          corners += std::abs(h[c & 1].dot(h[2 + (c >> 1 & 1)].cross(h[4 + (c >> 2 & 1)])));
        }
      worst = std::max(worst, std::abs(corners / fe::volume(X) - 1.0));
      sum += corners;
      exact += fe::volume(X);
    }
    std::printf("nodes moved by up to %2.0f %%: volumes within %.1e, mean %.1e\n", 100.0 * q, worst,
                sum / exact - 1.0);
    EXPECT_LT(worst, 0.2 * q * q);
    EXPECT_LT(std::abs(sum / exact - 1.0), 0.01 * q * q);
  }
}

// What the conversion of a moving element costs. Uniform velocity: nothing. A velocity gradient:
// three quarters of its energy, less what goes into the spins.
TEST(Conversion, KineticEnergyBalance)
{
  const double h = 2e-3, mass = 2.0, rate = 100.0;
  const fe::HexCoords X = cube(h);
  fe::HexCoords v = fe::HexCoords::Zero();
  for (int k = 0; k < 8; ++k) v.col(k) = Vec3(1.0, 2.0, 3.0);
  auto de = convert_hex(X, X, v, mass);
  EXPECT_NEAR(conversion_kinetic_loss(v, mass, de), 0.0, 1e-14);

  v.setZero();
  v.row(0) = rate * X.row(0);    // a uniform stretching: lumped 1/2 m (rate h/2)^2
  de = convert_hex(X, X, v, mass);
  const double lumped = 0.5 * mass * std::pow(rate * h / 2.0, 2);
  EXPECT_NEAR(conversion_kinetic_loss(v, mass, de), 0.75 * lumped, 1e-12 * lumped);

  // of 27 DEs two thirds lie at 2/3 of the edge: 8/27 are left; of a single one nothing
  EXPECT_NEAR(conversion_kinetic_loss(v, mass, convert_hex(X, X, v, mass, ElementSplit(3))),
              19.0 / 27.0 * lumped, 1e-12 * lumped);
  EXPECT_NEAR(conversion_kinetic_loss(v, mass, convert_hex(X, X, v, mass, ElementSplit(1))), lumped,
              1e-12 * lumped);

  const Vec3 omega(0.0, 0.0, rate);    // a rotation
  for (int k = 0; k < 8; ++k) v.col(k) = omega.cross(Vec3(X.col(k)));
  de = convert_hex(X, X, v, mass);
  EXPECT_NEAR(conversion_kinetic_loss(v, mass, de),
              0.5 * mass * h * h * rate * rate * (1.0 / 2.0 - 1.0 / 8.0 - 1.0 / 40.0), 1e-10);
}

// Angular momentum about any point: lumped element m h^2/2 omega, DEs m h^2/8 omega and their spins
// m h^2/40 omega. The orbital part of the centre of mass is kept exactly.
TEST(Conversion, AngularMomentumBalance)
{
  const double h = 2.0, mass = 3.0;
  const fe::HexCoords X = cube(h);
  const Vec3 omega(0.3, -0.2, 0.5), drift(1.0, 2.0, 3.0), at(10.0, 20.0, -5.0);
  fe::HexCoords x = X, v;
  x.colwise() += at;
  for (int k = 0; k < 8; ++k) v.col(k) = drift + omega.cross(Vec3(X.col(k)));
  Vec3 before = Vec3::Zero(), after = Vec3::Zero(), spin = Vec3::Zero();
  for (int k = 0; k < 8; ++k) before += mass / 8.0 * Vec3(x.col(k)).cross(Vec3(v.col(k)));
  for (const NewDE &d : convert_hex(X, x, v, mass)) {
    after += d.mass * d.x.cross(d.v);
    spin += 0.4 * d.mass * d.radius * d.radius * d.omega;
  }
  const Vec3 orbital = mass * at.cross(drift);
  EXPECT_LT((before - orbital - mass * h * h / 2.0 * omega).norm(), 1e-12 * orbital.norm());
  EXPECT_LT((after - orbital - mass * h * h / 8.0 * omega).norm(), 1e-12 * orbital.norm());
  EXPECT_LT((spin - mass * h * h / 40.0 * omega).norm(), 1e-14);
}

TEST(Conversion, TieWeightsAreTheShapeFunctionsAtThePatches)
{
  double N[4];
  facet_shape(-0.5, -0.5, N);
  for (int i = 0; i < 4; ++i) EXPECT_DOUBLE_EQ(weights_of(TieSpot::QUARTER)[i], N[i]);

  // ... and the tie point is the middle of the DE's patch, on any hex, whatever its split
  std::mt19937 random(5);
  const Mesh mesh = box_mesh(3, 1, 1, 1.0, [&](const Vec3 &X) {
    return Vec3(X + random_vector(random, 0.2));
  });
  for (int along : {1, 2, 3}) {
    const Block block(mesh, {0, 1, 0}, glass, ElementSplit(along));
    int ties = 0;
    for (const auto &p : block.de)
      for (int s = 0; s < 6; ++s)
        if (p.cell.tie >> s & 1u) {
          EXPECT_LT((p.cell.dX[s] - p.cell.face[s]).norm(), 1e-15);
          ++ties;
        }
    EXPECT_EQ(ties, 2 * along * along);
  }
}

// A strip of cubes in pure bending, `layers` through its height, before and after elements of it convert.
struct Bent {
  double before, element,
      after;    // strain energies: of the strip, of the element in its middle, of the strip
  double out_of_balance;    // largest force on an inner node or DE by that on the strip's ends
};

Bent bend(int layers, bool all)
{
  const fe::IsotropicElastic material{1.0, 0.0, 1.0};
  const double kappa = 1e-6;
  const Mesh mesh = box_mesh(7, 1, layers, 1.0);
  const int middle = 3;
  std::vector<char> none(mesh.hex.size(), 0), some = none;
  if (all)
    some.assign(some.size(), 1);
  else
    some[middle] = 1;
  const Block finite(mesh, none, material), mixed(mesh, some, material);
  const auto bent = [&](const Vec3 &X) {
    return Vec3(X + kappa * Vec3(X[0] * X[2], 0.0, -0.5 * X[0] * X[0]));
  };
  Vectors nodes;
  for (const Vec3 &X : mesh.X) nodes.push_back(bent(X));
  Vectors f, x = nodes;
  Bent result;
  result.before = finite.forces(nodes, f);
  const fe::HexCoords X = mesh.coords(middle, mesh.X);
  result.element = fe::EnhancedKernel(material).energy(mesh.coords(middle, nodes), X);
  for (const auto &p : mixed.de) x.push_back(place_of_de(mesh.coords(p.element, nodes), p.place));
  result.after = mixed.forces(x, f);
  double inner = 0.0, ends = 0.0;
  for (size_t i = 0; i < x.size(); ++i) {
    double &largest = std::abs(mixed.X[i][0]) > 2.9 ? ends : inner;
    largest = std::max(largest, f[i].norm());
  }
  result.out_of_balance = inner / ends;
  return result;
}

// DEs are born where the nodes say, so that mass and momentum stay where they are: not shifted by the enhanced modes,
// which would take all eight of them 3/32 of h^2 kappa to the outer side. One element of the strip loses a sixteenth of
// its energy, one that is half the height gains 1/128.
TEST(Conversion, OfABentElement)
{
  const Bent thin = bend(1, false), half = bend(2, false);
  EXPECT_NEAR((thin.after - thin.before) / thin.element, -1.0 / 16.0, 1e-5);
  EXPECT_NEAR((half.after - half.before) / half.element, 1.0 / 128.0, 1e-5);
  EXPECT_NEAR(half.element / thin.element, 4.0, 1e-5);
  // the moment passes the converted element, but for what shear is left in its ties
  EXPECT_LT(thin.out_of_balance, 0.85);
  EXPECT_LT(half.out_of_balance, 0.25);
  // all of them converted: in balance, and softer (at their ends, too)
  for (int layers : {1, 2}) {
    const Bent all = bend(layers, true);
    EXPECT_LT(all.out_of_balance, 1e-4);
    EXPECT_LT(all.after, all.before);
    EXPECT_GT(all.after, 0.85 * all.before);
  }
}

// A tie from the DE at the origin to the quarter point of a face of 2 x 2 above it.
TEST(TieSwing, OfADEThatTurnsAboutTheTiePoint)
{
  const Vec3 face[4] = {{0.5, 0.5, 0.5}, {0.5, -1.5, 0.5}, {-1.5, -1.5, 0.5}, {-1.5, 0.5, 0.5}};
  const Vec3 X = Vec3::Zero(), point(0.0, 0.0, 0.5);
  EXPECT_NEAR(tie_rotation(X, X, face, face), 0.0, 1e-15);
  std::mt19937 random(3);
  for (double angle : {0.01, 0.3, 1.2}) {
    // everything turns, and the DE in addition about the tie point, in any direction along the face
    const Mat3 R = Eigen::AngleAxisd(2.0, random_vector(random, 1.0).normalized()).matrix();
    const Vec3 axis = Vec3(random_vector(random, 1.0).cwiseProduct(Vec3(1, 1, 0))).normalized();
    const Vec3 x = R * (point + Eigen::AngleAxisd(angle, axis) * (X - point));
    Vec3 now[4], back[4], face_back[4];
    for (int k = 0; k < 4; ++k) now[k] = R * face[k];
    EXPECT_NEAR(tie_rotation(X, x, face, now), std::sin(angle), 1e-12);
    // the same seen from the other element, which goes round the face the other way
    for (int k = 0; k < 4; ++k) {
      back[k] = now[(4 - k) % 4];
      face_back[k] = face[(4 - k) % 4];
    }
    EXPECT_NEAR(tie_rotation(X, x, face_back, back), std::sin(angle), 1e-12);
  }
  // along the tie: no swing, whatever the pressure
  EXPECT_NEAR(tie_rotation(X, Vec3(0.0, 0.0, 0.1), face, face), 0.0, 1e-15);
}

// Layers of a tempered pane, of which some elements are DEs: at the places where it was put nothing moves, whatever has
// converted, and the energy is that of the stress.
TEST(Conversion, PrestressedLayersStayInEquilibrium)
{
  std::mt19937 random(9);
  const int N = 5, layers = 4;
  const double h = 2e-3, sigma_A = 100e6 * h * h;
  const fe::ParabolaStress pane{2, -0.5 * layers * h, 0.5 * layers * h, -100e6};
  const auto law = fe::parse_material({"elastic", "74.09e9", "0.2", "2500"}).law;
  for (double fraction : {0.0, 0.4, 1.0})
    for (bool orthogonal : {false, true}) {
      Mesh mesh = box_mesh(N, N, layers, h);
      shuffle_local_axes(mesh, random);
      std::vector<char> some(mesh.hex.size());
      for (int e = 0; e < static_cast<int>(some.size());
           ++e) {    // at the edges DEs let the stress go
        const int i = e % N, j = e / N % N;
        some[e] =
            std::min(i, j) > 0 && std::max(i, j) < N - 1 && uniform(random, 0.0, 1.0) < fraction;
      }
      Block block(mesh, some, glass);
      block.orthogonal = orthogonal;
      for (auto &p : block.de) {
        const Mat3 sigma = pane.over(mesh.coords(p.element, mesh.X));
        p.cell = stress_free_cell(p.cell, fe::stress_free_map(sigma, glass));
      }
      Vectors f(block.X.size(), Vec3::Zero());
      double energy = block.joint_forces(block.X, f), expected = 0.0;
      for (int e = 0; e < static_cast<int>(mesh.hex.size()); ++e) {
        const fe::HexCoords X = mesh.coords(e, mesh.X);
        const Mat3 sigma = pane.over(X);
        expected += fe::energy_of_stress(sigma, glass) * fe::volume(X);
        if (some[e]) continue;
        fe::ElementBatch batch(0, *law, fe::KernelChoice(*law, X, {}, &sigma));
        std::array<int, 8> nodes;
        std::copy(mesh.hex[e].begin(), mesh.hex[e].end(), nodes.begin());
        batch.add(nodes, nullptr);
        batch.finish();
        batch.forces(block.X[0].data(), nullptr, f[0].data(), {});
        batch.energy(block.X[0].data(), nullptr, Vectors(block.X.size(), Vec3::Zero())[0].data(),
                     energy);
      }
      int looked_at = 0;
      for (std::size_t i = 0; i < block.X.size(); ++i) {    // not at the edges, which want to move
        const Vec3 &X = block.X[i];
        if (std::max(std::abs(X[0]), std::abs(X[1])) > (0.5 * N - 0.3) * h) continue;
        EXPECT_LT(f[i].norm(), 1e-10 * sigma_A);
        ++looked_at;
      }
      EXPECT_GT(looked_at, 50);
      EXPECT_NEAR(energy, expected, 3e-3 * expected);    // laws at a strain of 1e-3
    }
}
