// Wrong input ends with one line that says what is wrong.
//
// ranks: 1 2
// timeout: 120

#include "glass_block.h"
#include "mesh_file.h"

#include <gmock/gmock.h>

using namespace defe::test;
using defe::Vec3;
using testing::AllOf;
using testing::HasSubstr;

namespace {

/// The message that ends the script; empty if nothing does.
std::string failure(const std::string &script, MPI_Comm comm = MPI_COMM_WORLD)
{
  try {
    Lammps lmp(comm);
    lmp.commands(script);
  } catch (LAMMPS_NS::LAMMPSException &e) {
    std::string text = e.what();
    return text.substr(0, text.find('\n'));
  }
  return "";
}

std::string replaced(std::string text, const std::string &what, const std::string &by)
{
  const auto at = text.find(what);
  if (at == std::string::npos) throw std::runtime_error("'" + what + "' is not in the script");
  return text.replace(at, what.size(), by);
}

std::string good()
{
  return Block().script();
}

}    // namespace

TEST(Errors, GoodInputHasNone)
{
  EXPECT_EQ(failure(good() + "run 1"), "");
}

TEST(Errors, SettingsOfLammps)
{
  EXPECT_THAT(failure(replaced(good(), "newton off on", "newton off") + "run 0"),
              HasSubstr("'newton off on'"));
  EXPECT_THAT(failure(replaced(good(), "comm_modify vel yes", "") + "run 0"),
              HasSubstr("comm_modify vel yes"));
  EXPECT_THAT(failure(replaced(good(), "atom_style sphere", "atom_style atomic") + "run 0"),
              HasSubstr("atom_style sphere"));
  EXPECT_THAT(failure(good() + "run_style respa 2 2\nrun 0"), HasSubstr("run_style respa"));
  EXPECT_THAT(failure(good() + "atom_modify first nodes\nneigh_modify include nodes\nrun 0"),
              HasSubstr("neigh_modify include"));
}

TEST(Errors, TimeStep)
{
  // 2 mm cubes of glass: 2.2e-7 s
  EXPECT_THAT(failure(good() + "timestep 1e-6\nrun 0"),
              AllOf(HasSubstr("Time step 1e-06 is above the stable step"), HasSubstr("e-07")));
}

TEST(Errors, PairStyle)
{
  const std::string style = "pair_style defe/joint\npair_coeff 2 2 " + Block().coeff;
  EXPECT_THAT(failure(replaced(good(), style, "") + "run 0"),
              HasSubstr("use pair_style defe/joint"));
  EXPECT_THAT(failure(replaced(good(), style, "pair_style zero 0.002\npair_coeff * *") + "run 0"),
              HasSubstr("use pair_style defe/joint"));
  EXPECT_THAT(failure(replaced(good(), style, "pair_style defe/joint") + "run 0"),
              HasSubstr("pair coeffs are not set"));    // LAMMPS' own
  EXPECT_THAT(failure(replaced(good(), "pair_coeff 2 2", "pair_coeff 1 1") + "run 0"),
              AllOf(HasSubstr("part glass"), HasSubstr("pair_coeff 2 2")));
  EXPECT_THAT(
      failure(replaced(good(), style, "pair_style defe/joint\npair_coeff 2 2 connective material") +
              "run 0"),
      AllOf(HasSubstr("pair_coeff 2 2"), HasSubstr("cohesive")));
  EXPECT_THAT(failure(replaced(good(), "connective material", "connective 70e9 0.2") + "run 0"),
              HasSubstr("differs from material glass"));
  EXPECT_THAT(failure(replaced(good(), "connective material", "connective 74.09e9 0.7")),
              HasSubstr("nu must be between"));
  EXPECT_THAT(failure(replaced(good(), "contact 0.9", "contact 1.9")), HasSubstr("restitution"));
  EXPECT_THAT(failure(replaced(good(), "cohesive 1e12", "glue 1e12")),
              HasSubstr("Unknown pair_coeff keyword glue"));
  // without a fix defe
  EXPECT_THAT(failure(Block().header() + Block().box() +
                      "pair_style defe/joint\npair_coeff 2 2 connective 1e9 0.2 cohesive 1 1 0.1 "
                      "contact 0.9 0.1\nrun 0"),
              HasSubstr("define one"));
}

TEST(Errors, FixDefe)
{
  const auto with = [](const std::string &options, const std::string &convert) {
    Block block;
    block.options = options;
    if (!convert.empty()) block.convert = convert;
    return failure(block.script());
  };
  EXPECT_THAT(with("", "1e12 type 3 group particles"),
              HasSubstr("atom type 3 does not exist (1 to 2)"));
  EXPECT_THAT(with("", "1e12 type 2 group pieces"), HasSubstr("group pieces does not exist"));
  EXPECT_THAT(with("", "1e12 type 2 start nowhere"),
              HasSubstr("start must be no, all or a region"));
  EXPECT_THAT(with("", "1e12 group particles"), HasSubstr("type N"));
  EXPECT_THAT(with("", "-5 type 2"), HasSubstr("conversion stress must be > 0"));
  EXPECT_THAT(with("convert wood 1 type 2", ""), HasSubstr("unknown part wood"));
  EXPECT_THAT(with("part panel wood", ""), HasSubstr("unknown material wood"));
  EXPECT_THAT(with("material glass rigid 1", ""), HasSubstr("defined twice"));
  EXPECT_THAT(with("material wood elastic 1e9 0.5 600", ""), HasSubstr("Fix defe material wood"));
  EXPECT_THAT(with("material wood plastic 1e9", ""), HasSubstr("law plastic"));
  EXPECT_THAT(with("material ball rigid 7800 convert ball 1e6 type 2", ""), HasSubstr("is rigid"));
  EXPECT_THAT(with("kernel fast", ""), HasSubstr("kernel must be"));
  EXPECT_THAT(with("colour blue", ""), HasSubstr("Unknown fix defe keyword colour"));
  EXPECT_THAT(with("contact", ""), HasSubstr("contact"));
  EXPECT_THAT(failure(good() + "fix fe2 all defe material glass elastic 1e9 0.2 1000\nrun 0"),
              HasSubstr("Only one fix defe"));
}

TEST(Errors, OrderOfCommands)
{
  const std::string fix = Block().fix_only();
  EXPECT_THAT(failure(replaced(good(), fix, "fix lb all balance 100 1.0 shift xyz 5 1.1\n" + fix) +
                      "run 0"),
              AllOf(HasSubstr("Fix lb balance"), HasSubstr("after fix fe")));
  EXPECT_THAT(failure(replaced(good(), fix, Block().mesh() + fix)), HasSubstr("fe"));
  Block block;
  block.convert += " start all";
  EXPECT_THAT(failure(block.script() + "run 1\n" + block.mesh()),
              HasSubstr("before elements convert"));
}

TEST(Errors, CreateHexes)
{
  const auto with = [](const std::string &rest) {
    return failure(Block().header() + Block().box() + Block().fix() + "create_hexes " + rest);
  };
  EXPECT_THAT(with("fe wood 1 x 0 1 1 y 0 1 1 z 0 1 1"), HasSubstr("no part wood"));
  EXPECT_THAT(with("fx glass 1 x 0 1 1 y 0 1 1 z 0 1 1"), HasSubstr("not the ID of a fix defe"));
  EXPECT_THAT(with("fe glass 7 x 0 1 1 y 0 1 1 z 0 1 1"), HasSubstr("atom type 7 does not exist"));
  EXPECT_THAT(with("fe glass 1 x 0 1 0.001 y 0.01 1 0.002 z 0 1 0.001"), HasSubstr("must go up"));
  EXPECT_THAT(with("fe glass 1 x 0 0 0.001 y 0 1 0.001 z 0 1 0.001"), HasSubstr("0 elements"));
  EXPECT_THAT(with("fe glass 1 x 0 1 0.001 z 0 1 0.001"), HasSubstr("expected 'y"));
  EXPECT_THAT(with("fe glass 1 x 0 1 0.001 y 0 1 0.001 z 0 1 0.001 w"),
              HasSubstr("unknown word w"));
}

// Errors of the mesh are found by one rank.
TEST(Errors, Mesh)
{
  const auto script = [](const MeshFile &mesh) {
    mesh.write("wrong.data", MPI_COMM_SELF);
    return Block().header() + Block().box() + Block().fix() + read_mesh("wrong.data") +
        Block().motion() + "run 0";
  };
  if (rank_of(MPI_COMM_WORLD) == 0) {
    MeshFile good;
    good.add_block("glass", 1, 2, 1, 1, 2e-3, [](const Vec3 &X) {
      return X;
    });
    EXPECT_EQ(failure(script(good), MPI_COMM_SELF), "");

    MeshFile mesh = good;
    std::swap(mesh.hex[1][0], mesh.hex[1][6]);
    EXPECT_THAT(failure(script(mesh), MPI_COMM_SELF),
                AllOf(HasSubstr("Part glass"), HasSubstr("hexahedron 2 is inverted"),
                      HasSubstr("(0.002 0.002 0.002)")))
        << "inverted, with the coordinates of its nodes";
    mesh = good;
    mesh.hex[1][3] = mesh.hex[1][2];
    EXPECT_THAT(failure(script(mesh), MPI_COMM_SELF),
                AllOf(HasSubstr("Element 2"), HasSubstr("has node 6 twice")));
    mesh = good;
    mesh.hex[0][7] = 99;
    EXPECT_THAT(failure(script(mesh), MPI_COMM_SELF),
                AllOf(HasSubstr("Element 1"), HasSubstr("node 99"), HasSubstr("does not exist")));
    mesh = good;
    mesh.hex.push_back(mesh.hex[1]);
    mesh.part.push_back("glass");
    EXPECT_THAT(failure(script(mesh), MPI_COMM_SELF), HasSubstr("share"));
    mesh = good;
    mesh.part[1] = "wood";
    EXPECT_THAT(failure(script(mesh), MPI_COMM_SELF), AllOf(HasSubstr("Hexes"), HasSubstr("wood")));
    // a node where no element is: an atom of a node's type that nothing moves is no error
  }
  MPI_Barrier(MPI_COMM_WORLD);
}

// An element that is squeezed inside out during a run is named.
TEST(Errors, ElementTurnsInsideOut)
{
  if (rank_of(MPI_COMM_WORLD) == 0) {
    for (const char *kernel : {"kernel auto", "kernel lagrangian"}) {
      Block block;
      block.n[0] = block.n[1] = block.n[2] = 1;
      block.options = kernel;
      block.convert = "1e15 type 2 group particles";
      EXPECT_THAT(
          failure(block.script() +
                      "velocity nodes set 0 0 -8e3\nregion low block INF INF INF "
                      "INF INF 0.001\ngroup low region low\nvelocity low set 0 0 8e3\nrun 100",
                  MPI_COMM_SELF),
          AllOf(HasSubstr("Element 1 of part glass turned inside out at step"),
                HasSubstr("timestep")))
          << kernel;
    }
  }
  MPI_Barrier(MPI_COMM_WORLD);
}

TEST(Errors, RestartWithOtherParts)
{
  Block block;
  {
    Lammps lmp;
    lmp.commands(block.script() + "run 1\nwrite_restart parts.restart");
  }
  EXPECT_THAT(failure(block.header() + "read_restart parts.restart\n" + block.fix_only()), "");
  block.options = "part second glass";
  EXPECT_THAT(failure(block.header() + "read_restart parts.restart\n" + block.fix_only()),
              HasSubstr("1 parts"));
}
