// The laminated beam of examples/laminated_beam: the same conversions on any number of ranks, energy
// that does not rise, and, with the moduli of glass in the interlayer, the beam of one piece.
//
// timeout: 300

#include "bending.h"
#include "events.h"
#include "layers.h"

#include <cmath>

using namespace defe::test;

namespace {

constexpr double E = 74.09e9, nu = 0.2;    // glass
const std::string glass = "elastic 74.09e9 0.2 2500";

/// Half as long as in the example. mesh: commands that make part lower, inter and upper, or one.
std::string script(const std::string &inter, const std::string &options, const std::string &mesh,
                   double height)
{
  Bending b;
  b.box = "-0.06 0.06 -0.012 0.04 -0.02 0.03";
  b.glass =
      "material glass " + glass + " part lower glass part upper glass material inter " + inter;
  b.options = "contact 0.2125 " + options;
  b.mesh = mesh;
  b.outer = "0.050";
  b.inner = "0.040";
  b.height = number(height);
  b.block_top = number(height + 0.004);
  return b.script() +
      "region sole block -0.0011 0.0011 INF 1e-4 INF INF\ngroup sole region sole\n"
      "thermo_style custom step\n";
}

std::vector<double> lines_of_x()
{
  std::vector<double> x = {-0.05};
  for (double a : equidistant(-0.049, 0.049, 49)) x.push_back(a);
  x.push_back(0.05);
  return x;
}

std::string laminate(MPI_Comm comm, const std::vector<double> &x = lines_of_x())
{
  layered({{"lower", 0.008, 4}, {"inter", 0.00152, 1}, {"upper", 0.008, 4}}, x,
          equidistant(0.0, 0.01, 5), 5)
      .write("laminate.data", comm);
  return read_mesh("laminate.data");
}

}    // namespace

TEST(Laminate, ConversionsAreTheSameOnAllRanks)
{
  const std::string options = "convert lower 56e6 type 4 group particles &\n"
                              "convert upper 56e6 type 4 group particles stress gauss check yes &\n"
                              "events ";
  const std::string prony = "prony 20e9 1100 0.69e6 1 0.32931e9 12.6";
  // not symmetric: rounding would decide to which side a crack goes
  auto x = lines_of_x();
  x.back() += 3e-4;
  const auto run = [&](MPI_Comm comm, const std::string &events) {
    Lammps lmp(comm);
    lmp.commands(script(prony, options + events, laminate(comm, x), 0.01752));
    lmp.record({"f_fe[22]"}, 5);
    lmp.run(600);
    const auto total = lmp.recorded();
    double lowest = total.front(), rise = 0.0;
    for (double e : total) {
      lowest = std::min(lowest, e);
      rise = std::max(rise, e - lowest);
    }
    EXPECT_LT(rise, 1e-3 * total.front());
    EXPECT_GT(lmp.fe(CONVERTED), 30.0);
    EXPECT_GT(lmp.fe(CONTACT), 50.0);
    return lmp.particles();
  };
  on_one_rank([&]() {
    return run(MPI_COMM_SELF, "events.one.txt");
  });
  MPI_Barrier(MPI_COMM_WORLD);
  run(MPI_COMM_WORLD, "events.txt");
  const auto all = conversions("events.txt"), one = conversions("events.one.txt");
  EXPECT_EQ(all, one);
  // both plies crack
  bool below = false, above = false;
  for (const auto &e : read_events("events.txt", "broken")) (e.x[1] < 0.008 ? below : above) = true;
  EXPECT_TRUE(below);
  EXPECT_TRUE(above);
}

// With the moduli of glass in the interlayer the laminated beam is the one of a single part and of
// an even mesh: force on the impactor and deflection within 1 %, by the elastic law and by those of
// interlayers. (St Venant-Kirchhoff and Mooney-Rivlin agree to first order of the strain, 1e-3.)
TEST(Laminate, WithAnInterlayerOfGlassItIsTheMonolithicBeam)
{
  const double G = E / 2.0 / (1.0 + nu), K = E / 3.0 / (1.0 - 2.0 * nu), height = 0.01752;
  struct Response {
    std::vector<double> impactor, sag;
  };
  const auto run = [&](const std::string &inter, const std::string &mesh) {
    Lammps lmp;
    lmp.commands(script(inter, "", mesh, height));
    lmp.record({"vcm(impactor,y)", "xcm(sole,y)"}, 10);
    lmp.run(1200);
    return Response{lmp.recorded(0), lmp.recorded(1)};
  };
  const auto one = run(glass,
                       "create_hexes fe glass 1 x -0.050 1 -0.049 49 0.049 1 0.050  y 0 9 " +
                           number(height) + " z 0 5 0.010\n");
  for (const std::string &inter :
       {glass, "mooney " + number(0.4 * G) + " " + number(0.1 * G) + " " + number(K) + " 2500",
        "prony " + number(K) + " 2500 " + number(0.5 * G) + " 1 " + number(0.5 * G) + " 1e-3"}) {
    const auto layers = run(inter, laminate(MPI_COMM_WORLD));
    ASSERT_EQ(layers.sag.size(), one.sag.size());
    double change = 0.0, sag = 0.0, dv = 0.0, ds = 0.0;
    for (size_t k = 0; k < one.sag.size(); k++) {
      change = std::max(change, std::abs(one.impactor[k] - one.impactor[0]));
      sag = std::max(sag, std::abs(one.sag[k] - one.sag[0]));
      dv = std::max(dv, std::abs(layers.impactor[k] - one.impactor[k]));
      ds = std::max(ds, std::abs(layers.sag[k] - one.sag[k]));
    }
    EXPECT_GT(sag, 5e-5);
    EXPECT_LT(dv, 0.01 * change) << inter;
    EXPECT_LT(ds, 0.01 * sag) << inter;
  }
}
