// Ties with an adhesive strength: a plate of glass that is pulled, peeled and sheared off a soft
// one, and falls back on it.
//
// timeout: 240

#include "events.h"
#include "joints.h"
#include "mesh_file.h"

#include <gmock/gmock.h>

#include <cmath>
#include <functional>

using namespace defe::test;
using defe::Vec3;
using testing::HasSubstr;

namespace {

constexpr double h = 2e-3, area = 1e-6, G_f = 50.0, sigma = 5e6, dt = 4e-8;

/// n x n elements of glass on as many of a soft material, which share their nodes.
struct Laminate {
  int n = 1;
  double nu = 0.0, beta = 0.5, thickness = h;    // of the soft layer
  double G = G_f;
  std::string options = " contact 0.2";
  std::string adhesive = "adhesive glass soft";
  std::string curve;    // of softening
  std::string convert = "1e12 type 2 group particles start all";

  std::string header() const { return script_head(); }
  std::string fix() const
  {
    std::string s = "fix fe all defe material glass elastic 74e9 " + number(nu) +
        " 2500 material soft elastic 1e9 " + number(nu) + " 1100 convert glass " + convert +
        options;
    if (!adhesive.empty())
      s +=
          " " + adhesive + " " + number(sigma) + " " + number(G) + " " + number(beta) + " " + curve;
    return s + "\n";
  }
  std::string motion() const
  {
    return "group nodes type 1\nfix move1 nodes nve\nfix move2 particles nve/sphere\nneighbor "
           "3e-4 bin\nneigh_modify every 1 delay 0 check yes\ntimestep " +
        number(dt) + "\n";
  }
  void start(Lammps &lmp, MPI_Comm comm = MPI_COMM_WORLD) const
  {
    MeshFile mesh;
    mesh.add_block("soft", 1, n, n, 2, h, [&](const Vec3 &X) {
      return Vec3(X[0], X[1], X[2] < 1.5 * h ? X[2] * thickness / h : thickness + h);
    });
    for (size_t e = mesh.part.size() / 2; e < mesh.part.size(); e++) mesh.part[e] = "glass";
    const std::string file = "laminate" + std::to_string(size_of(comm)) + ".data";
    mesh.write(file, comm);
    lmp.commands(header() +
                 "region box block -0.02 0.03 -0.02 0.03 -0.02 0.03\ncreate_box 2 box\n"
                 "pair_style defe/joint\n"
                 "pair_coeff 2 2 connective material cohesive 1e12 1e6 0.1 contact 1.0 0.2\n"
                 "group particles empty\n" +
                 fix() + read_mesh(file) + motion() + "run 0\n");
  }
};

/// Let the glass go with a velocity that depends on where it is; the layer takes part from nothing at
/// its bottom to all at its top, so that there is no shock.
void throw_glass(Lammps &lmp, double thickness, const std::function<Vec3(const Vec3 &)> &velocity)
{
  lmp.change([&](Particle &p) {
    p.v = velocity(p.x) * std::min(1.0, p.x[2] / thickness);
  });
}

double bottom_of_glass(const Particles &all)
{
  double z = 1.0;
  for (const auto &p : all)
    if (p.second.type == 2) z = std::min(z, p.second.x[2]);
  return z;
}

/// Run until no tie is left; the energy balance of all steps.
std::vector<double> run_apart(Lammps &lmp, int ties, int steps)
{
  EXPECT_EQ(lmp.fe(TIES), ties);
  EXPECT_EQ(lmp.fe(TIES_SOFTENING), 0.0);
  lmp.record({"f_fe[23]"}, 1);
  lmp.run(steps);
  EXPECT_EQ(lmp.fe(TIES), 0.0);
  EXPECT_EQ(lmp.fe(TIES_SOFTENING), 0.0);
  EXPECT_EQ(lmp.fe(TIES_BROKEN), ties);
  EXPECT_EQ(lmp.fe(COHESIVE) + lmp.fe(CONTACT), 0.0);
  EXPECT_EQ(lmp.fe(E_TIES), 0.0);
  EXPECT_EQ(lmp.fe(E_COHESIVE), 0.0);
  return lmp.recorded();
}

}    // namespace

// In pure tension every tie takes its fracture energy, whatever the time step makes of the switch.
TEST(Adhesive, PulledApartTakesFractureEnergy)
{
  for (const std::string curve : {"", "linear", "exponential"}) {
    SCOPED_TRACE(curve);
    Laminate laminate;
    laminate.curve = curve;
    laminate.beta = curve.empty() ? 0.0 : 0.5;
    laminate.options += " events adhesive.txt";
    remove_file("adhesive.txt");
    {
      Lammps lmp;
      laminate.start(lmp);
      throw_glass(lmp, laminate.thickness, [](const Vec3 &) {
        return Vec3(0.0, 0.0, 20.0);
      });
      const auto energy = run_apart(lmp, 4, curve == "exponential" ? 600 : 200);    // it has a tail
      EXPECT_NEAR(lmp.fe(FRACTURE) / (4.0 * G_f * area), 1.0, 1e-9);
      EXPECT_GE(lmp.fe(RELEASE), 0.0);
      EXPECT_LT(largest_deviation(energy), 2e-3 * energy.front());
      EXPECT_EQ(lmp.fe(E_CONTACT), 0.0);
      EXPECT_GT(bottom_of_glass(lmp.particles()), 1.02 * h + 0.25 * h);
    }
    MPI_Barrier(MPI_COMM_WORLD);
    const auto started = read_events("adhesive.txt", "adhesive");
    const auto ended = read_events("adhesive.txt", "debonded");
    ASSERT_EQ(started.size(), 4u);
    ASSERT_EQ(ended.size(), 4u);
    EXPECT_EQ(read_events("adhesive.txt", "cohesive").size(), 0u);
    for (const auto &e : started) {
      EXPECT_EQ(e.b, 1);    // the soft element
      EXPECT_GE(e.value, sigma);
      EXPECT_LT(e.value, 1.5 * sigma);
      EXPECT_NEAR(e.x[2], h, 1e-12);
      EXPECT_NEAR(e.n[2], -1.0, 1e-12);
    }
    for (const auto &e : ended) {
      EXPECT_EQ(e.value, 1.0);
      EXPECT_GT(e.step, started.front().step);
    }
    MPI_Barrier(MPI_COMM_WORLD);    // all have read it
  }
}

// Without the keyword ties do not break.
TEST(Adhesive, TiesWithoutAdhesiveHold)
{
  Laminate laminate;
  laminate.adhesive.clear();
  Lammps lmp;
  laminate.start(lmp);
  throw_glass(lmp, laminate.thickness, [](const Vec3 &) {
    return Vec3(0.0, 0.0, 10.0);
  });
  lmp.run(200);
  EXPECT_EQ(lmp.fe(TIES), 4.0);
  EXPECT_EQ(lmp.fe(TIES_BROKEN), 0.0);
}

// A free pair that is peeled, or sheared and pulled: momenta stay to rounding, and energy.
TEST(Adhesive, PeelAndShear)
{
  for (bool peel : {true, false}) {
    Laminate laminate;
    laminate.n = 2;
    laminate.nu = 0.2;
    Lammps lmp;
    laminate.start(lmp);
    throw_glass(lmp, laminate.thickness, [&](const Vec3 &x) {
      if (peel) return Vec3(0.0, 0.0, 10.0 + 20.0 * x[0] / (2.0 * h));
      return Vec3(30.0, 5.0, 8.0);
    });
    const Particles before = lmp.particles();
    const auto energy = run_apart(lmp, 16, 500);
    const Particles after = lmp.particles();
    const double scale = total_mass(before) * 10.0;
    EXPECT_LT((momentum(after) - momentum(before)).norm(), 1e-10 * scale);
    const Vec3 c = centre_of_mass(before);
    EXPECT_LT((angular_momentum(after, c) - angular_momentum(before, c)).norm(), 1e-10 * scale * h);
    EXPECT_LT(largest_deviation(energy), 3e-3 * energy.front());
    // shear costs more: G_f k_n/(beta^2 k_s) of it alone
    const double all = 16.0 * G_f * area;
    EXPECT_GT(lmp.fe(FRACTURE), 0.999 * all);
    if (peel)
      EXPECT_LT(lmp.fe(FRACTURE), 1.3 * all);
    else
      EXPECT_GT(lmp.fe(FRACTURE), 1.3 * all);
  }
}

// What has debonded meets the layer again, and does not get through 0.76 mm of it.
TEST(Adhesive, NothingTunnelsThroughTheLayer)
{
  for (const std::string friction : {"", " friction 0.3"}) {
    Laminate laminate;
    laminate.n = 2;
    laminate.nu = 0.2;
    laminate.thickness = 0.76e-3;
    laminate.options += friction;
    Lammps lmp;
    laminate.start(lmp);
    lmp.commands("region floor block INF INF INF INF INF 1e-6\ngroup floor region floor\n"
                 "fix hold floor setforce 0 0 0\n");
    throw_glass(lmp, laminate.thickness, [](const Vec3 &) {
      return Vec3(0.0, 0.0, 15.0);
    });
    (void) run_apart(lmp, 16, 200);
    EXPECT_EQ(lmp.fe(E_CONTACT), 0.0);
    lmp.change([](Particle &p) {
      if (p.type == 2) p.v = Vec3(1.0, 0.0, -15.0);
    });
    lmp.command("unfix recorder");
    lmp.command("run 0");
    lmp.command("compute low particles reduce min z");
    lmp.record({"f_fe[23]", "f_fe[13]", "c_low"}, 1);
    lmp.run(800);
    const auto energy = lmp.recorded(0), contact = lmp.recorded(1), low = lmp.recorded(2);
    EXPECT_GT(*std::max_element(contact.begin(), contact.end()), 0.05 * energy.front());
    EXPECT_LT(largest_deviation(energy), 5e-3 * energy.front());
    // the layer gives way, and so does the penalty; the spheres stay above its bottom
    EXPECT_GT(*std::min_element(low.begin(), low.end()), 0.25 * h);
    EXPECT_GT(momentum(lmp.particles())[2], 0.0);
    if (friction.empty())
      EXPECT_EQ(lmp.fe(FRICTION), 0.0);
    else
      EXPECT_GT(lmp.fe(FRICTION), 0.0);
  }
}

// Pressed and sheared: no contact on top of the tie as long as it holds.
TEST(Adhesive, TiedSpheresHaveNoContactWithTheirElements)
{
  for (const std::string contact : {" contact 0.2", ""}) {
    static Particles with;
    Laminate laminate;
    laminate.n = 2;
    laminate.nu = 0.2;
    laminate.adhesive.clear();
    laminate.options = contact;
    Lammps lmp;
    laminate.start(lmp);
    throw_glass(lmp, laminate.thickness, [](const Vec3 &) {
      return Vec3(0.0, 0.0, -5.0);
    });
    lmp.run(60);
    EXPECT_GT(lmp.fe(E_TIES), 0.0);
    EXPECT_EQ(lmp.fe(E_CONTACT), 0.0);
    if (!contact.empty())
      with = lmp.particles();
    else
      EXPECT_LT(difference(with, lmp.particles(), &Particle::x), 1e-15);
  }
}

// Some ties broken, some softening: the same on any number of ranks, and after a restart.
/// On all ranks as on one, and over a restart.
static void peel(Laminate &laminate)
{
  laminate.n = 4;
  laminate.nu = 0.2;
  const auto velocity = [](const Vec3 &x) {
    return Vec3(1.0, 0.0, 25.0 * std::max(0.0, x[0] / h - 2.0));
  };
  constexpr int middle = 70, end = 140;
  const Particles one = on_one_rank([&] {
    Lammps lmp(MPI_COMM_SELF);
    laminate.start(lmp, MPI_COMM_SELF);
    throw_glass(lmp, laminate.thickness, velocity);
    lmp.run(end);
    return lmp.particles();
  });
  Particles all;
  double fracture, counts[3];
  {
    Lammps lmp;
    laminate.start(lmp);
    throw_glass(lmp, laminate.thickness, velocity);
    lmp.command("restart " + std::to_string(middle) + " adhesive.a adhesive.b");
    lmp.run(middle);
    EXPECT_GT(lmp.fe(TIES), 0.0);
    EXPECT_GT(lmp.fe(TIES_SOFTENING), 0.0);
    EXPECT_GT(lmp.fe(TIES_BROKEN), 0.0);
    lmp.run(end - middle);
    all = lmp.particles();
    fracture = lmp.fe(FRACTURE);
    counts[0] = lmp.fe(TIES), counts[1] = lmp.fe(TIES_SOFTENING), counts[2] = lmp.fe(TIES_BROKEN);
  }
  EXPECT_LT(difference(one, all, &Particle::x), 1e-12);
  EXPECT_LT(difference(one, all, &Particle::v), 1e-6);
  {
    Lammps lmp;
    lmp.commands(laminate.header() + "read_restart adhesive.a\n" + laminate.fix() +
                 laminate.motion());
    lmp.run(end - middle);
    EXPECT_LT(difference(all, lmp.particles(), &Particle::x), 1e-13);
    EXPECT_NEAR(lmp.fe(FRACTURE) / fracture, 1.0, 1e-9);
    EXPECT_EQ(lmp.fe(TIES), counts[0]);
    EXPECT_EQ(lmp.fe(TIES_SOFTENING), counts[1]);
    EXPECT_EQ(lmp.fe(TIES_BROKEN), counts[2]);
  }
}

TEST(Adhesive, DecompositionAndRestart)
{
  Laminate laminate;
  peel(laminate);
  laminate.adhesive.clear();
  Lammps lmp;
  lmp.commands(laminate.header() + "read_restart adhesive.a\n" + laminate.fix() +
               laminate.motion());
  try {
    lmp.run(1);
    ADD_FAILURE() << "softening ties without an adhesive must be refused";
  } catch (std::exception &e) {
    EXPECT_THAT(e.what(), HasSubstr("give 'adhesive' as before the restart"));
  }
}

TEST(Adhesive, ExponentialSofteningOnAnyRanksAndOverARestart)
{
  Laminate laminate;
  laminate.curve = "exponential";
  peel(laminate);
}

// What cannot be meant stops with one line.
TEST(Adhesive, BadInput)
{
  const auto fails = [](const std::string &adhesive, const std::string &message) {
    Lammps lmp;
    try {
      lmp.commands(
          "units si\natom_style sphere\nnewton off on\ncomm_modify vel yes\n"
          "region box block 0 1 0 1 0 1\ncreate_box 2 box\n"
          "fix fe all defe material glass elastic 74e9 0.2 2500 material soft elastic 1e9 "
          "0.4 1100 part other glass convert glass 56e6 type 2 convert other 56e6 type 2 " +
          adhesive + "\n");
      ADD_FAILURE() << adhesive;
    } catch (std::exception &e) {
      EXPECT_THAT(e.what(), HasSubstr(message)) << adhesive;
    }
  };
  fails("adhesive glass pvb 5e6 50 1", "unknown part pvb");
  fails("adhesive soft glass 5e6 50 1", "elements of part soft do not convert");
  fails("adhesive glass other 5e6 50 1", "part other converts");
  fails("adhesive glass soft 0 50 1", "must be > 0");
  fails("adhesive glass soft 5e6 -1 1", "must be > 0");
  fails("adhesive glass soft 5e6 50 -1", "must be > 0");
  fails("adhesive glass soft 5e6 50 1 adhesive glass soft 5e6 50 1", "given twice");
  fails("adhesive glass soft 5e6", "adhesive");
}
