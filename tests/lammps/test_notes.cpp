// Notes at the first run: the exact line where something is hardly what was meant, and none where it is.

#include "layers.h"

#include <gmock/gmock.h>

#include <fstream>

using namespace defe::test;
using defe::Vec3;

namespace {

using Notes = std::vector<std::string>;

const std::string HEADER = "units si\natom_style sphere\nnewton off on\ncomm_modify vel yes\n";
const std::string BOX = "region box block -0.02 0.02 -0.02 0.02 -0.02 0.02\ncreate_box 4 box\n";
const std::string ELASTIC = "pair_style zero 1e-3\npair_coeff * *\n";
const std::string MATERIALS =
    "fix fe all defe material glass elastic 70e9 0.2 2500 material pvb elastic 1e9 0.4 1070 "
    "material ram rigid 7850 material stand rigid 7850 ";
const std::string MOVE = "neighbor 3e-4 bin\ntimestep 1e-8\nfix move all nve\n";
const std::string HOLD = "group rigid type 3\nfix hold rigid setforce 0 0 0\n";

const std::string GLASS = "create_hexes fe glass 1 x -0.008 4 0.008 y 0 2 0.004 z 0 1 0.002\n";
// an element above it, and at it, with every other node at a node of the glass
const std::string RAM = "create_hexes fe ram 3 x -0.002 2 0.002 y 0 2 0.004 z 0.004 1 0.006\n";
const std::string PVB = "create_hexes fe pvb 2 x -0.008 8 0.008 y 0 4 0.004 z 0.002 1 0.003\n";

/// What a log file holds: the notes in it.
class Log {
 public:
  Log(Lammps &lmp, const std::string &name) : lmp(lmp), file(name) { lmp.command("log " + file); }
  Notes notes()
  {
    lmp.command("log none");
    MPI_Barrier(MPI_COMM_WORLD);
    Notes found;
    std::ifstream in(file);
    EXPECT_TRUE(in.good()) << file;
    for (std::string line; std::getline(in, line);)
      if (line.compare(0, 6, "Note: ") == 0) found.push_back(line.substr(6));
    MPI_Barrier(MPI_COMM_WORLD);
    return found;
  }

 private:
  Lammps &lmp;
  std::string file;
};

/// Of one run of no steps.
Notes notes_of(const std::string &script)
{
  Lammps lmp;
  Log log(lmp, "notes.txt");
  lmp.commands(script + "run 0\n");
  return log.notes();
}

/// Of parts that are made by `meshes`, with these options of fix defe.
Notes parts(const std::string &meshes, const std::string &options = "",
            const std::string &boundary = "boundary f f f\n")
{
  return notes_of(HEADER + boundary + BOX + ELASTIC + MATERIALS + options + "\n" + meshes + MOVE);
}

const std::string NO_CONTACT =
    "parts glass and ram have no contact: they pass through each other; add 'contact 0.2' to fix "
    "defe";
const std::string UNTIED =
    "15 nodes of part pvb lie on nodes of part glass and are not joined (node 31 on node 16 at "
    "-0.008 0 0.002): they come apart; to bond them, let the elements share these nodes "
    "(tools/mesh2data --merge)";

/// A snake of cubes of 2 mm in the plane z = 0, over all ranks and back: five rows of nine cubes, each
/// joined with the next at one end. `without` leaves out one cube.
MeshFile snake(int without = -1)
{
  MeshFile all;
  all.add_block("glass", 1, 9, 9, 1, 2e-3, [](const Vec3 &X) {
    return Vec3(X - Vec3(0.009, 0.009, 0.001));
  });
  MeshFile mesh;
  mesh.types = 4;
  std::vector<tagint> id(all.X.size(), 0);
  for (size_t e = 0; e < all.hex.size(); e++) {
    const int i = static_cast<int>(e) % 9, j = static_cast<int>(e) / 9;
    if (j % 2 == 1 && i != (j % 4 == 1 ? 8 : 0)) continue;
    if (static_cast<int>(e) == without) continue;
    std::array<tagint, 8> nodes;
    for (int a = 0; a < 8; a++) {
      const auto k = static_cast<size_t>(all.hex[e][a] - 1);
      if (!id[k]) {
        mesh.X.push_back(all.X[k]);
        mesh.type.push_back(1);
        id[k] = static_cast<tagint>(mesh.X.size());
      }
      nodes[a] = id[k];
    }
    mesh.hex.push_back(nodes);
    mesh.part.push_back("glass");
  }
  mesh.lo = Vec3::Constant(-0.02);
  mesh.hi = Vec3::Constant(0.02);
  return mesh;
}

}    // namespace

// ---- no contact ----

TEST(NoContact, PartsThatCanMeet)
{
  EXPECT_EQ(parts(GLASS + RAM), Notes{NO_CONTACT});
  EXPECT_EQ(parts(GLASS + RAM, "contact 0.2"), Notes());
  EXPECT_EQ(parts(GLASS + RAM, "contact 0"), Notes()) << "the user has said so";
  EXPECT_EQ(parts(GLASS), Notes());
}

TEST(NoContact, ManyParts)
{
  const std::string above = "create_hexes fe pvb 2 x -0.008 8 0.008 y 0 4 0.004 z 0.008 1 0.01\n";
  EXPECT_EQ(parts(GLASS + RAM + above),
            Notes{"parts glass, pvb and ram have no contact: they pass through each other where "
                  "they share no nodes; add 'contact 0.2' to fix defe"});
}

TEST(NoContact, RigidPartsHaveNoneAnyway)
{
  EXPECT_EQ(parts(RAM + "create_hexes fe stand 4 x -0.002 2 0.002 y 0 2 0.004 z -0.004 1 -0.002\n"),
            Notes());
}

TEST(NoContact, LayersThatShareNodesAreOneBody)
{
  auto mesh = layered({{"glass", 0.004, 2}, {"pvb", 0.002, 1}, {"glass", 0.004, 2}},
                      equidistant(-0.01, 0.01, 12), equidistant(-0.01, 0.01, 12), 4);
  mesh.lo = Vec3::Constant(-0.02);
  mesh.hi = Vec3::Constant(0.02);
  mesh.write("layers.data");
  EXPECT_EQ(parts(read_mesh("layers.data")), Notes());
}

/// Its pieces on a rank are connected through other ranks only.
TEST(NoContact, BodyThatCrossesRanksManyTimes)
{
  snake().write("snake.data");
  EXPECT_EQ(parts(read_mesh("snake.data")), Notes());
  snake(4 + 9 * 4).write("cut.data");    // the middle of the third row
  EXPECT_EQ(parts(read_mesh("cut.data")),
            Notes{"2 bodies of part glass have no contact: they pass through each other; add "
                  "'contact 0.2' to fix defe"});
}

TEST(NoContact, Spheres)
{
  const std::string balls = "create_atoms 4 single 0 0 0.01\ncreate_atoms 4 single 0 0 -0.01\n"
                            "set type 4 diameter 0.004 density 2500\n";
  EXPECT_EQ(parts(GLASS + balls),
            Notes{"2 spheres have no contact with finite elements: they pass through them; add "
                  "'contact 0.2' to fix defe"});
  EXPECT_EQ(parts(RAM + balls), Notes()) << "balls have no contact with rigid parts";
}

// ---- nodes at one place ----

TEST(Untied, PartsMeshedOneByOne)
{
  EXPECT_EQ(parts(GLASS + PVB, "contact 0"), Notes{UNTIED});
  std::string with = UNTIED;
  const std::string apart = "come apart";
  with.replace(with.find(apart), apart.size(), "meet by contact only");
  EXPECT_EQ(parts(GLASS + PVB, "contact 0.2"), Notes{with});
}

/// Nodes of a support that happen to be at those of the glass, but no face fits: it is put there.
TEST(Untied, SupportInContact)
{
  const std::string support =
      "create_hexes fe pvb 2 x -0.008 6 0 y 0 2 0.004 z -0.002 1 0\n";    // 1.33 mm, glass 4 mm
  const std::string lower = "create_hexes fe pvb 2 x -0.0085 3 0 y 0 2 0.004 z -0.002 1 0\n";
  EXPECT_EQ(parts(GLASS + support, "contact 0.2").size(), 1u) << "two faces of the glass fit";
  EXPECT_EQ(parts(GLASS + lower, "contact 0.2"), Notes()) << "nodes at x = 0 only";
  EXPECT_EQ(parts(GLASS + lower, "contact 0"),
            Notes{"3 nodes of part pvb lie on nodes of part glass and are not joined (node 46 on "
                  "node 3 at 0 0 0): they come apart; to bond them, let the elements share these "
                  "nodes (tools/mesh2data --merge)"});
}

TEST(Untied, RigidPartThatTouches)
{
  EXPECT_EQ(parts(GLASS + "create_hexes fe ram 3 x -0.008 4 0.008 y 0 2 0.004 z 0.002 1 0.006\n",
                  "contact 0.2"),
            Notes());
}

/// One part in four blocks: at the edge where they meet three nodes lie on the first one.
TEST(Untied, OnePart)
{
  std::string blocks;
  for (const char *y : {" y -0.004 2 0", " y 0 2 0.004"})
    for (const char *x : {" x -0.004 2 0", " x 0 2 0.004"})
      blocks += std::string("create_hexes fe glass 1") + x + y + " z 0 1 0.002\n";
  EXPECT_EQ(parts(blocks, "contact 0"),
            Notes{"22 nodes of part glass lie on other ones of the same part and are not joined "
                  "(node 19 on node 3 at 0 -0.004 0): they come apart; to bond them, let the "
                  "elements share these nodes (tools/mesh2data --merge)"});
}

TEST(Untied, OnePartInContact)
{
  const std::string block = "create_hexes fe glass 1 x -0.004 2 0 y 0 2 0.004 z 0 1 0.002\n";
  EXPECT_EQ(
      parts(block + "create_hexes fe glass 1 x 0 2 0.004 y 0 2 0.004 z 0 1 0.002\n", "contact 0.2"),
      Notes{"6 nodes of part glass lie on other ones of the same part and are not joined "
            "(node 19 on node 3 at 0 0 0): they meet by contact only; to bond them, let the "
            "elements share these nodes (tools/mesh2data --merge)"});
  EXPECT_EQ(
      parts(block + "create_hexes fe glass 1 x 0 2 0.004 y 0 3 0.004 z 0 1 0.003\n", "contact 0.2"),
      Notes())
      << "no face fits";
}

/// Both ends of a bar that fills a periodic box are at one place.
TEST(Untied, AcrossThePeriodicBorder)
{
  const std::string rest = " y 0 1 0.002 z 0 1 0.002\n";
  const std::string bar = "create_hexes fe glass 1 x -0.02 10 0.02" + rest;
  EXPECT_EQ(parts(bar, "contact 0", "boundary p f f\n"),
            Notes{"4 nodes of part glass lie on other ones of the same part and are not joined "
                  "(node 11 on node 1 at -0.02 0 0): they come apart; to bond them, let the "
                  "elements share these nodes (tools/mesh2data --merge)"});
  EXPECT_EQ(
      parts("create_hexes fe glass 1 x -0.02 9 0.016" + rest, "contact 0", "boundary p f f\n"),
      Notes());
}

/// A ten thousandth of the shortest edge, 0.1 um here.
TEST(Untied, HowNear)
{
  auto shifted = [](const std::string &by) {
    return parts(GLASS + PVB + "group pvb type 2\ndisplace_atoms pvb move 0 0 " + by + "\n",
                 "contact 0");
  };
  EXPECT_EQ(shifted("0.9e-7").size(), 1u);
  EXPECT_EQ(shifted("-0.9e-7").size(), 1u);
  EXPECT_EQ(shifted("1.1e-7"), Notes());
}

// ---- conversion stress ----

namespace {

Notes converting(
    const std::string &convert, const std::string &pair = "defe/joint",
    const std::string &coeff = "connective material cohesive 60e6 10 0.1 contact 0.9 0.2")
{
  return notes_of(HEADER + "boundary f f f\n" + BOX + "pair_style " + pair + "\npair_coeff 4 4 " +
                  coeff + "\ngroup particles empty\n" + MATERIALS + "convert glass " + convert +
                  " contact 0.2\n" + GLASS + "group nodes type 1\nneighbor 3e-4 bin\n" +
                  "timestep 1e-8\nfix move1 nodes nve\nfix move2 particles nve/sphere\n");
}

}    // namespace

TEST(Strength, ConversionAboveIt)
{
  const std::string rest = " type 4 group particles";
  EXPECT_EQ(
      converting("90e6" + rest),
      Notes{"part glass converts at 9e+07, above the strength 6e+07 of its joints (pair_coeff "
            "4 4 cohesive): they are overstressed when they are born; convert at 0.90 to "
            "0.95 of the strength"});
  EXPECT_EQ(converting("56e6" + rest), Notes());
  EXPECT_EQ(converting("60e6" + rest), Notes());
  EXPECT_EQ(converting("1e12" + rest), Notes()) << "above Young's modulus: nothing shall convert";
  EXPECT_EQ(converting("90e6" + rest + " start all"), Notes());
  EXPECT_EQ(converting("90e6" + rest, "defe/connective", "connective material"), Notes())
      << "joints without a strength";
}

// ---- conversions that are collected ----

TEST(Collecting, LongerThanACrackNeeds)
{
  // a time step of 1e-8, edges of 2 mm, a crack that runs at half of 3.42 mm/us: 58.5 steps
  const std::string convert = "56e6 type 4 group particles collect ";
  EXPECT_EQ(converting(convert + "58"), Notes());
  EXPECT_EQ(
      converting(convert + "60"),
      Notes{"with collect 60 elements of part glass wait for up to 6e-07, in which a crack can "
            "run 0.00102, more than the spacing of DEs (0.001): cracks stop, and others start "
            "in their place; use collect 58 or less"});
  EXPECT_EQ(converting("1e12 type 4 group particles collect 60"), Notes());
  EXPECT_EQ(converting(convert + "auto"), Notes());
}

// ---- elements that are longer than thick ----

TEST(Slender, ElementsThatConvert)
{
  const auto pane = [](const std::string &type, int layers, const std::string &stress,
                       const std::string &more = "") {
    return notes_of(HEADER + "boundary f f f\n" + BOX + "pair_style defe/joint\n" +
                    "pair_coeff 4 4 connective material cohesive 60e6 10 0.1 contact 0.9 0.2\n" +
                    "group particles empty\nfix fe all defe material glass elastic 74e9 0.2 2500 " +
                    type + " convert glass " + stress + " type 4 group particles contact 0.2\n" +
                    "create_hexes fe glass 1 x 0 3 0.006 y 0 3 0.006 z 0 " +
                    std::to_string(layers) +
                    " 0.002\ngroup nodes type 1\nneighbor 3e-4 bin\ntimestep 1e-8\n" +
                    "fix move1 nodes nve\nfix move2 particles nve/sphere\n" + more);
  };
  EXPECT_EQ(pane("enhanced", 2, "56e6"), Notes());
  const std::string note =
      " elements of part glass are more than 2.5 times as long as thick: where they are "
      "bent and convert, DEs store more energy than they did (3 times at 4:1); use shorter "
      "elements there, or plain ones";
  EXPECT_EQ(pane("enhanced", 4, "56e6"), Notes{"36" + note});
  // a mesh that grows is counted anew
  const Notes grown =
      pane("enhanced", 4, "56e6",
           "run 0\ncreate_hexes fe glass 1 x 0.01 1 0.012 y 0 1 0.002 z 0 4 0.002\n");
  EXPECT_THAT(grown, testing::Contains("40" + note));
  EXPECT_EQ(pane("plain", 4, "56e6"), Notes());
  EXPECT_EQ(pane("enhanced", 4, "1e12"), Notes()) << "nothing shall convert";
}

// ---- cracks and mesh ----

TEST(Laws, LatticeKnowsTheMesh)
{
  const auto notes = [](const std::string &law, const std::string &more = "") {
    return converting("56e6 type 4 group particles" + more, "defe/joint",
                      "connective material cohesive 60e6 10 " + law + " contact 0.9 0.2");
  };
  const std::string rest =
      " along those of elements, and cracks follow the lines (pair_coeff 4 4): "
      "without lattice they do not know the mesh";
  EXPECT_EQ(
      notes("0.1 lattice"),
      Notes{"with lattice and beta 0.1 part glass breaks at 6e+07 along the lines of its mesh, at "
            "1.19e+08 along the diagonals of faces and 1.78e+08" +
            rest});
  EXPECT_EQ(
      notes("1 lattice", " start all"),
      Notes{"with lattice and beta 1 part glass breaks at 6e+07 along the lines of its mesh, at "
            "8.49e+07 along the diagonals of faces and 1.04e+08" +
            rest});
  EXPECT_EQ(notes("0.1"), Notes());
  EXPECT_EQ(
      notes("0.1 reciprocal"),
      Notes{"part glass is not weaker in shear for 'reciprocal' and beta 0.1 (pair_coeff 4 4): its "
            "cracks start where the largest principal stress is 6e+07, and beta counts when they "
            "slide; with lattice joints break under a shear of 6e+06"});
  EXPECT_EQ(notes("1 reciprocal"), Notes());
}

// ---- once ----

TEST(Once, NotInLaterRuns)
{
  Lammps lmp;
  Log first(lmp, "first.txt");
  lmp.commands(HEADER + "boundary f f f\n" + BOX + ELASTIC + MATERIALS + "\n" + GLASS + RAM + MOVE +
               HOLD + "write_data notes.data\nrun 10\n");
  EXPECT_EQ(first.notes(), Notes{NO_CONTACT});
  Log second(lmp, "second.txt");
  lmp.commands("run 10\nrun 0\n");
  EXPECT_EQ(second.notes(), Notes());

  // a mesh that is added: what it brings is said, and nothing twice
  Log third(lmp, "third.txt");
  lmp.commands(PVB + "run 0\n");
  const std::string more =
      "parts glass, pvb and ram have no contact: they pass through each other where they share no "
      "nodes; add 'contact 0.2' to fix defe";
  const auto both = third.notes();
  ASSERT_EQ(both.size(), 2u);
  EXPECT_EQ(both[0], more);
  EXPECT_EQ(both[1].substr(0, 28), "15 nodes of part pvb lie on ");
  Log fourth(lmp, "fourth.txt");
  lmp.commands("create_hexes fe glass 1 x -0.008 4 0.008 y -0.01 2 -0.006 z 0 1 0.002\nrun 0\n");
  const auto notes = fourth.notes();
  ASSERT_EQ(notes.size(), 1u);
  EXPECT_EQ(notes[0].substr(0, 24), "2 bodies of part glass h");
}

TEST(Once, NotAfterARestart)
{
  const std::string script =
      HEADER + "boundary f f f\n" + BOX + ELASTIC + MATERIALS + "\n" + GLASS + RAM + MOVE + HOLD;
  {
    Lammps lmp;
    lmp.commands(script + "write_restart before.restart\nrun 10\nwrite_restart after.restart\n");
  }
  for (const bool said : {false, true}) {
    Lammps lmp;
    Log log(lmp, "restart.txt");
    lmp.commands(HEADER + "read_restart " + (said ? "after" : "before") + ".restart\n" + ELASTIC +
                 MATERIALS + "\n" + MOVE + HOLD + "run 10\n");
    EXPECT_EQ(log.notes(), said ? Notes() : Notes{NO_CONTACT});
  }
}
