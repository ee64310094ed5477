// The paper's glass beam: its first five elements convert, and one crack runs through it. The same
// elements at the same steps on any number of ranks.
//
// The list of conversions of the first 30 us is compared with data/beam_30us.txt. After a
// deliberate change of the model, write it anew from one rank and look at what changed:
//   DEFE_UPDATE_REFERENCE=1 tools/mpirun.sh 1 build/release/tests/lammps_beam
//   git diff tests/lammps/data
//
// timeout: 300

#include "bending.h"
#include "events.h"

#include <cmath>
#include <fstream>
#include <set>

using namespace defe::test;

namespace {

constexpr double contact_factor = 0.2125;    // as in examples/glass_beam

std::string script(double dt, const std::string &options, const std::string &law = "",
                   const std::string &elements = "")
{
  Bending b;
  b.box = "-0.11 0.11 -0.01 0.035 -0.01 0.02";
  b.glass = "material glass elastic 74.09e9 0.2 2500 " + elements;
  b.elements = elements;
  b.options = "convert glass 56e6 type 4 group particles events events.txt contact " +
      number(contact_factor) + " " + options;
  b.mesh = "create_hexes fe glass 1 x -0.100 1 -0.099 99 0.099 1 0.100 y 0 10 0.020 z 0 5 0.010";
  b.outer = "0.100";
  b.inner = "0.090";
  b.height = "0.020";
  b.block_top = "0.024";
  b.dt = dt;
  b.law = law;
  return b.script();
}

/// Times in us: the first conversion, the crack at a height of 16 mm, and through.
struct Timeline {
  double first, upper, through;
  long converted, centre;    // in the first 90 us, and of these in the middle
};

Timeline crack(double dt, const std::string &options, const std::string &law)
{
  remove_file("events.txt");
  Lammps lmp;
  lmp.commands(script(dt, options, law));
  lmp.record({"f_fe[22]"}, 20);
  lmp.run(static_cast<bigint>(std::lround(1e-4 / dt)));
  const auto total = lmp.recorded();
  EXPECT_LT(*std::max_element(total.begin(), total.end()), 1.001 * total.front()) << options;
  EXPECT_GT(total.back(), 0.99 * total.front()) << options;

  // the crack plane x = 0 lies between two layers of DEs; layers of 1 mm over the depth
  Timeline t{1e6 * lmp.fe(FIRST_CONVERSION), -1.0, -1.0, 0, 0};
  std::vector<double> layer(20, 1.0);
  MPI_Barrier(MPI_COMM_WORLD);
  for (const auto &e : read_events("events.txt")) {
    if (e.what == "convert" && e.time < 90e-6) {
      t.converted++;
      t.centre += std::abs(e.x[0]) < 1e-6;
    }
    if (e.what == "broken" && std::abs(e.x[0]) < 5e-4 && std::abs(e.n[0]) > 0.9) {
      double &first = layer.at(static_cast<size_t>(e.x[1] / 1e-3));
      first = std::min(first, e.time);
    }
  }
  t.upper = 1e6 * layer[15];
  t.through = 1e6 * *std::max_element(layer.begin(), layer.end());
  return t;
}

/// With all glass discrete from the start it is 26.0, 40.6 and 68.2 us for either law.
void expect_crack(double dt, const std::string &options, long most)
{
  const Timeline t = crack(dt, options, "");
  EXPECT_NEAR(t.first, 26.0, 1.0);
  EXPECT_NEAR(t.upper, 39.5, 2.0);
  EXPECT_NEAR(t.through, 68.2, 1.0);
  EXPECT_GE(t.centre, 48);
  EXPECT_LE(t.converted, most);
}

/// \param file  in data: the conversions that are expected
void first_thirty_microseconds(const std::string &elements, const std::string &file)
{
  const std::string reference_file = DEFE_SOURCE_DIR "/tests/lammps/data/" + file;
  const double dt = 6e-8;
  const int steps = 500;
  remove_file("events.txt");
  Lammps lmp;
  lmp.commands(script(dt, "", "", elements));
  lmp.run(0);
  EXPECT_EQ(lmp.fe(ELEMENTS), 5050 + 100 + 20);
  EXPECT_NEAR(total_mass(lmp.particles()), 0.1 + 2 * 0.00096 + 1.0, 1e-12);
  const double initial = lmp.fe(TOTAL);
  EXPECT_NEAR(initial / (0.5 * 1.0 * 3.13 * 3.13), 1.0, 1e-12);
  lmp.record({"f_fe[22]", "f_fe[2]", "f_fe[8]"}, 10);
  lmp.run(steps);

  // issue 2, section 5: 26 +- 1 us, the five elements at the bottom of the centre column. The glass
  // has 101 columns in x, column 51 is the one in the middle; layers of z have 101 * 10 elements
  EXPECT_NEAR(lmp.fe(FIRST_CONVERSION), 26e-6, 1e-6);
  const auto list = conversions("events.txt");
  ASSERT_GE(list.size(), 5u);
  EXPECT_EQ(static_cast<double>(list.size()), lmp.fe(CONVERTED));
  std::set<long> first, bottom;
  for (int k = 0; k < 5; k++) first.insert(list[k][1]);
  for (int k = 0; k < 5; k++) bottom.insert(1 + 50 + 101 * 10 * k);
  EXPECT_EQ(first, bottom);
  EXPECT_NEAR(static_cast<double>(list[0][0]) * dt, lmp.fe(FIRST_CONVERSION), 1e-12);

  // energy: constant within 0.05 % before the first conversion, never rising by more than 0.1 %
  const auto total = lmp.recorded(0), converted = lmp.recorded(1), s1 = lmp.recorded(2);
  for (size_t k = 0; k < total.size(); k++) {
    if (converted[k] == 0.0) { EXPECT_NEAR(total[k] / initial, 1.0, 5e-4) << "step " << 10 * k; }
    EXPECT_LT(total[k] / initial, 1.001) << "step " << 10 * k;
    // with shielding an element may be above the criterion, up to 1.2 times
    EXPECT_LT(s1[k], 1.3 * 56e6) << "step " << 10 * k;
  }

  // the list
  if (std::getenv("DEFE_UPDATE_REFERENCE") && size_of(MPI_COMM_WORLD) == 1) {
    std::ofstream out(reference_file);
    out << "# step and element of the conversions in the first 30 us of the glass beam, "
        << elements << " elements\n";
    for (const auto &c : list) out << c[0] << " " << c[1] << "\n";
  }
  std::vector<std::array<long, 2>> reference;
  std::ifstream in(reference_file);
  std::string line;
  while (std::getline(in, line)) {
    if (line.empty() || line[0] == '#') continue;
    std::istringstream words(line);
    std::array<long, 2> c;
    words >> c[0] >> c[1];
    reference.push_back(c);
  }
  EXPECT_EQ(list, reference) << elements;
}

}    // namespace

TEST(Beam, FirstThirtyMicroseconds)
{
  first_thirty_microseconds("enhanced", "beam_30us.txt");
}

// a step or two earlier in each layer
TEST(Beam, FirstThirtyMicrosecondsWithPlainElements)
{
  first_thirty_microseconds("plain", "beam_30us_plain.txt");
}

TEST(Beam, OneCrackThroughTheMiddle)
{
  expect_crack(6e-8, "", 60);
}

// The paper's law and table.
TEST(Beam, JointByJoint)
{
  const Timeline t = crack(6e-8, "", "lattice");
  EXPECT_NEAR(t.first, 26.0, 1.0);
  EXPECT_NEAR(t.upper, 44.0, 2.0);
  EXPECT_NEAR(t.through, 70.0, 2.0);
  EXPECT_GE(t.centre, 48);
  EXPECT_LE(t.converted, 60);
}

// The result belongs to the model, not to the step, to shielding or to a second clock for the finite
// elements (one rank: time).
TEST(Beam, HalfTheStep)
{
  if (size_of(MPI_COMM_WORLD) > 1) GTEST_SKIP();
  expect_crack(3e-8, "", 60);
}

TEST(Beam, HalfTheStepWithoutShielding)
{
  if (size_of(MPI_COMM_WORLD) > 1) GTEST_SKIP();
  expect_crack(3e-8, "shield no", 110);
}

TEST(Beam, TwoClocks)
{
  expect_crack(6e-8, "every 2", 60);
}

TEST(Beam, TwoClocksWithHalfTheStep)
{
  if (size_of(MPI_COMM_WORLD) > 1) GTEST_SKIP();
  expect_crack(3e-8, "every 4", 60);
}
