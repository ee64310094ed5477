// fix defe/vtk: its files hold what the computes give, the same on any ranks and over a restart.
// tests/tools/test_vtk.py opens them by VTK.
//
// timeout: 300

#include "cracking_beam.h"
#include "failure.h"
#include "programs.h"
#include "tied_blocks.h"
#include "vtk_file.h"

#include <gmock/gmock.h>

#include <algorithm>
#include <cmath>

using namespace defe::test;
using defe::Vec3;
using testing::AllOf;
using testing::HasSubstr;

namespace {

using Id = std::pair<long, long>;

/// All values of one kind by ID, with the positions of its points.
using Values = std::map<Id, std::vector<double>>;

Values by_id(const VtkFile &file, const std::vector<std::string> &names, const std::string &id,
             const std::string &id2 = "")
{
  Values result;
  for (size_t c = 0; c < file.ncells(); c++) {
    // a vertex has its values at its point
    const bool vertex = file.at("Types")[c] == 1;
    const std::string folder = vertex ? "PointData/" : "CellData/";
    const size_t n = vertex ? file.corner(c, 0) : c;
    std::vector<double> values;
    for (const auto &name : names) {
      const auto &all = file.at(folder + name);
      const size_t width = all.size() / (vertex ? file.npoints() : file.ncells());
      values.insert(values.end(), &all[n * width], &all[n * width] + width);
    }
    const int corners = static_cast<int>(file.at("Offsets")[c + 1] - file.at("Offsets")[c]);
    for (int a = 0; a < corners; a++)
      values.insert(values.end(), file.xyz(file.corner(c, a)), file.xyz(file.corner(c, a)) + 3);
    const Id key = {file.at(folder + id)[n], id2.empty() ? 0 : file.at(folder + id2)[n]};
    EXPECT_TRUE(result.emplace(key, values).second) << key.first << " " << key.second << " twice";
  }
  return result;
}

const std::vector<std::string> hex_values = {"part", "stress", "s1", "vonmises"},
                               sphere_values = {"type",   "part",     "element", "radius",
                                                "damage", "fragment", "velocity"},
                               joint_values = {"kind", "state", "part", "damage", "opening",
                                               "slip", "tn",    "ts",   "area",   "length"};

Values hexes_of(const std::string &base, int step)
{
  return by_id(VtkFile(base + "_elements_" + std::to_string(step) + ".hdf"), hex_values, "id");
}
Values spheres_of(const std::string &base, int step)
{
  return by_id(VtkFile(base + "_spheres_" + std::to_string(step) + ".hdf"), sphere_values, "id");
}
Values joints_of(const std::string &base, int step)
{
  return by_id(VtkFile(base + "_joints_" + std::to_string(step) + ".hdf"), joint_values, "id1",
               "id2");
}

/// Node values by their ID.
Values nodes_of(const std::string &base, int step)
{
  const VtkFile file(base + "_elements_" + std::to_string(step) + ".hdf");
  Values result;
  for (size_t p = 0; p < file.npoints(); p++) {
    std::vector<double> values(file.xyz(p), file.xyz(p) + 3);
    for (const char *name : {"PointData/velocity", "PointData/displacement"})
      values.insert(values.end(), &file.at(name)[3 * p], &file.at(name)[3 * p] + 3);
    EXPECT_TRUE(result.emplace(Id(static_cast<long>(file.point("node", p)), 0), values).second)
        << "a node is there twice";
  }
  return result;
}

/// Forces are summed in another order on other ranks. Relative to the largest value of each column.
void expect_near(const Values &a, const Values &b, const std::string &what)
{
  ASSERT_EQ(a.size(), b.size()) << what;
  ASSERT_GT(a.size(), 0u) << what << ": a poor example";
  std::vector<double> largest(a.begin()->second.size(), 0.0);
  for (const auto &one : a)
    for (size_t k = 0; k < largest.size(); k++)
      largest[k] = std::max(largest[k], std::fabs(one.second[k]));
  for (const auto &one : a) {
    const auto other = b.find(one.first);
    ASSERT_TRUE(other != b.end()) << what << " " << one.first.first << " is missing";
    for (size_t k = 0; k < largest.size(); k++)
      ASSERT_NEAR(one.second[k], other->second[k], 1e-7 * largest[k])
          << what << " " << one.first.first << " " << one.first.second << ", column " << k;
  }
}

void expect_same(const std::string &one, const std::string &other, int step)
{
  expect_near(hexes_of(one, step), hexes_of(other, step), "element");
  expect_near(nodes_of(one, step), nodes_of(other, step), "node");
  expect_near(spheres_of(one, step), spheres_of(other, step), "sphere");
  expect_near(joints_of(one, step), joints_of(other, step), "joint");
}

std::string vtk(const std::string &base, int every = 20, const std::string &more = "")
{
  return "fix vtk all defe/vtk " + std::to_string(every) + " " + base + " " + more + "\n";
}

/// A beam at step `steps`, which is written.
void run_beam(Lammps &lmp, const std::string &commands, int steps)
{
  const Block block = cracking_beam();
  lmp.commands(block.script() + commands);
  bend(lmp, block, 3.0);
  lmp.run(steps);
}

}    // namespace

// Bit by bit what the computes give at this step, each element, sphere and joint once.
TEST(Vtk, FilesHoldWhatComputesGive)
{
  Lammps lmp;
  run_beam(lmp,
           vtk("values") +
               "compute h all defe/hex/local id part sxx syy szz sxy syz sxz s1 vonmises x y z\n"
               "compute j all defe/joint/local id1 id2 kind state part damage opening slip tn ts "
               "area length x y z\ncompute d all defe/atom damage element\n"
               "compute f all defe/fragment/atom\n",
           60);
  const auto hexes = hexes_of("values", 60), spheres = spheres_of("values", 60);
  const auto joints = joints_of("values", 60), nodes = nodes_of("values", 60);
  const auto particles = lmp.particles();

  const auto hex_rows = lmp.local("h");
  EXPECT_EQ(hexes.size(), hex_rows.size());
  EXPECT_GT(hexes.size(), 30u);
  for (const auto &row : hex_rows) {
    const auto &v = hexes.at({row[0], 0});
    for (size_t k = 1; k < 10; k++) EXPECT_EQ(v[k - 1], row[k]) << "element " << row[0];
    for (int k = 0; k < 3; k++) {
      double centre = 0.0;
      for (int a = 0; a < 8; a++) centre += 0.125 * v[9 + 3 * a + k];
      EXPECT_NEAR(centre, row[10 + k], 1e-14);
    }
  }
  for (const auto &n : nodes) {
    const auto &p = particles.at(n.first.first);
    const Vec3 v(&n.second[3]), u(&n.second[6]);
    EXPECT_EQ(Vec3(&n.second[0]), p.x);
    EXPECT_EQ(v, p.v);
    EXPECT_GT(u.norm(), 1e-8);
    EXPECT_LT(u.norm(), 1e-4);
  }

  const auto damage = lmp.per_atom("d", 1), element = lmp.per_atom("d", 2);
  const auto fragment = lmp.per_atom("f");
  EXPECT_GT(spheres.size(), 50u);
  size_t expected = 0;
  for (const auto &p : particles) {
    if (p.second.radius == 0.0) continue;
    expected++;
    const auto &v = spheres.at({p.first, 0});
    const std::vector<double> should = {2.0,
                                        1.0,
                                        element.at(p.first),
                                        p.second.radius,
                                        damage.at(p.first),
                                        fragment.at(p.first),
                                        p.second.v[0],
                                        p.second.v[1],
                                        p.second.v[2],
                                        p.second.x[0],
                                        p.second.x[1],
                                        p.second.x[2]};
    EXPECT_EQ(v, should) << "sphere " << p.first;
  }
  EXPECT_EQ(spheres.size(), expected);

  const auto joint_rows = lmp.local("j");
  EXPECT_EQ(joints.size(), joint_rows.size());
  int ties = 0, softening = 0;
  for (const auto &row : joint_rows) {
    const auto &v = joints.at({row[0], row[1]});
    for (size_t k = 2; k < 12; k++) EXPECT_EQ(v[k - 2], row[k]) << row[0] << " " << row[1];
    const Vec3 from(&v[10]), to(&v[13]);
    EXPECT_EQ(from, particles.at(row[0]).x);
    EXPECT_NEAR((to - from).norm(), row[11], 1e-15);
    const Vec3 end = row[2] == 1.0 ? particles.at(row[1]).x : Vec3(&row[12]);
    EXPECT_NEAR((to - end).norm(), 0.0, 1e-16);
    ties += row[2] == 2.0;
    softening += row[3] == 1.0;
  }
  EXPECT_GT(ties, 10);
  EXPECT_GT(softening, 10);
}

// The first step and each twentieth, and the last one only once.
TEST(Vtk, StepsAreThoseOfADump)
{
  Lammps lmp;
  run_beam(lmp, vtk("steps", 20, "joints state elements id"), 20);
  lmp.run(25);
  const std::string series = contents("steps_elements.hdf.series");
  MPI_Barrier(MPI_COMM_WORLD);
  EXPECT_EQ(series,
            "{\n  \"file-series-version\" : \"1.0\",\n  \"files\" : [\n"
            "    { \"name\" : \"steps_elements_0.hdf\", \"time\" : 0 },\n"
            "    { \"name\" : \"steps_elements_20.hdf\", \"time\" : 1e-06 },\n"
            "    { \"name\" : \"steps_elements_40.hdf\", \"time\" : 2e-06 }\n  ]\n}\n");
  EXPECT_LT(size_of_file("steps_elements_45.hdf"), 0);
  EXPECT_LT(size_of_file("steps_spheres_40.hdf"), 0);
  const VtkFile elements("steps_elements_0.hdf"), joints("steps_joints_0.hdf");
  EXPECT_EQ(elements.ncells(), 160u);
  EXPECT_TRUE(elements.has("CellData/id"));
  EXPECT_FALSE(elements.has("CellData/s1"));
  EXPECT_EQ(joints.ncells(), 0u);
  EXPECT_TRUE(joints.has("CellData/state"));
}

TEST(Vtk, SameOnAnyRanksAndOverARestart)
{
  constexpr int middle = 40, end = 64;
  const auto run = [&](MPI_Comm comm, const std::string &base) {
    Lammps lmp(comm);
    const Block block = cracking_beam();
    lmp.commands(block.script() + vtk(base, 16));
    bend(lmp, block, 3.0);
    lmp.run(middle);
    lmp.command("write_restart " + base + ".restart");
    lmp.run(end - middle);
    MPI_Barrier(comm);
    return lmp.particles();
  };
  run(MPI_COMM_WORLD, "ranks");
  on_one_rank([&] {
    return run(MPI_COMM_SELF, "one");
  });
  expect_same("ranks", "one", 32);
  expect_same("ranks", "one", end);

  // what comes after the restart file is written again, and what came before stays listed

  const std::string list = contents("ranks_joints.hdf.series");
  const auto hexes = hexes_of("ranks", end);
  const auto spheres = spheres_of("ranks", end);
  const auto joints = joints_of("ranks", end);
  MPI_Barrier(MPI_COMM_WORLD);
  remove_file("ranks_elements_64.hdf");
  Lammps lmp;
  const Block block = cracking_beam();
  lmp.commands(block.header() + "read_restart ranks.restart\n" + block.fix_only() + block.motion() +
               vtk("ranks", 16));
  lmp.run(10);
  const std::string begun = contents("ranks_joints.hdf.series");
  EXPECT_THAT(begun, HasSubstr("ranks_joints_32.hdf"));
  lmp.run(end - middle - 10);
  EXPECT_EQ(contents("ranks_joints.hdf.series"), list);
  expect_near(hexes_of("ranks", end), hexes, "element");
  expect_near(spheres_of("ranks", end), spheres, "sphere");
  expect_near(joints_of("ranks", end), joints, "joint");
  MPI_Barrier(MPI_COMM_WORLD);
}

// DEs at a tied surface are joined to the other part by lines of kind 3, to the face: as the compute says, the same on any ranks
// and over a restart.
TEST(Vtk, TiedSurfaces)
{
  using namespace tied;
  constexpr int middle = 120, end = 200;
  const std::string options = converting("low") + converting("high") + glued + " contact 0.2";
  const std::string seen =
      "compute j all defe/joint/local id1 id2 kind state part damage opening slip tn ts area "
      "length x y z\n";
  const auto only_tied = [](const std::string &base) {
    Values some;
    for (const auto &v : joints_of(base, end))
      if (v.second[0] == 3.0) some.insert(v);
    return some;
  };
  const auto run = [&](MPI_Comm comm, const std::string &base) {
    Lammps lmp(comm);
    lmp.commands(blocks(2, 3, tilt(), options, weak, comm, base + ".data") + seen + vtk(base, 40));
    lmp.change([](Particle &p) {
      const Vec3 n = tilt().col(2);
      p.v = 1.5e3 * (p.x.dot(n) - L) * n + 0.05 * random_of(p.tag, 7);
    });
    lmp.run(middle);
    lmp.command("write_restart " + base + ".restart");
    lmp.run(end - middle);
    MPI_Barrier(comm);
    const auto joints = only_tied(base);
    EXPECT_GT(joints.size(), 16u);
    const auto particles = lmp.particles();
    size_t rows = 0;
    for (const auto &row : lmp.local("j")) {
      if (row[2] != 3.0) continue;
      rows++;
      const auto &v = joints.at({row[0], row[1]});
      for (size_t k = 2; k < 12; k++) EXPECT_EQ(v[k - 2], row[k]) << row[0] << " " << row[1];
      EXPECT_EQ(Vec3(&v[10]), particles.at(row[0]).x);
      EXPECT_LT((Vec3(&v[13]) - Vec3(&row[12])).norm(), 1e-16);
      EXPECT_LE((Vec3(&v[13]) - Vec3(&v[10])).norm(), row[11] * (1.0 + 1e-9));
    }
    EXPECT_EQ(rows, joints.size());
    return particles;
  };
  run(MPI_COMM_WORLD, "glued");
  on_one_rank([&] {
    return run(MPI_COMM_SELF, "glued_one");
  });
  const auto all = only_tied("glued");
  expect_near(all, only_tied("glued_one"), "joint to a tied surface");
  MPI_Barrier(MPI_COMM_WORLD);
  Lammps lmp;
  lmp.commands(script_head() + "read_restart glued.restart\n" + pair_lines(weak) + fix_of(options) +
               moving + vtk("glued", 40));
  lmp.run(end - middle);
  MPI_Barrier(MPI_COMM_WORLD);
  expect_near(only_tied("glued"), all, "joint to a tied surface");
}

// A fresh run begins the series anew, and so does one that goes on under another name.
TEST(Vtk, ASeriesIsBegunAnew)
{
  for (int k = 0; k < 2; k++) {
    Lammps lmp;
    run_beam(lmp, vtk("anew", 4 + 4 * k, "elements id"), 8);
    EXPECT_EQ(contents("anew_elements.hdf.series").find("anew_elements_4.hdf") == std::string::npos,
              k == 1);
    lmp.command("write_restart anew.restart");
  }
  Lammps lmp;
  const Block block = cracking_beam();
  lmp.commands(block.header() + "read_restart anew.restart\n" + block.fix_only() + block.motion() +
               vtk("other", 4, "elements id"));
  lmp.run(4);
  const std::string list = contents("other_elements.hdf.series");
  EXPECT_THAT(list, HasSubstr("other_elements_12.hdf"));
  EXPECT_EQ(list.find("_elements_0.hdf"), std::string::npos);
  MPI_Barrier(MPI_COMM_WORLD);
}

// Elements are written again when some have converted, or when others are on a rank; what did not change is in one file.
// Atoms are sorted in between, which must not matter.
TEST(Vtk, WhatDidNotChangeIsWrittenOnce)
{
  Lammps lmp;
  const Block block = cracking_beam();
  lmp.commands(block.script() + "atom_modify sort 1 0\n" +
               vtk("once", 2, "elements spheres id radius"));
  bend(lmp, block, 3.0);
  lmp.run(40);
  const auto file = [](const std::string &kind, int step) {
    return VtkFile("once_" + kind + "_" + std::to_string(step) + ".hdf");
  };
  const std::vector<std::string> mesh = {"Connectivity", "Offsets",       "Types",
                                         "CellData/id",  "CellData/part", "PointData/node"};
  std::string origin = "once_elements_0.hdf";
  int changes = 0, same = 0;
  for (int step = 0; step <= 40; step += 2) {
    const VtkFile now = file("elements", step);
    const VtkFile before = file("elements", std::max(step - 2, 0));
    const bool changed = now.at("CellData/id") != before.at("CellData/id") ||
        now.at("PointData/node") != before.at("PointData/node");
    if (changed) origin = "once_elements_" + std::to_string(step) + ".hdf";
    (changed ? changes : same)++;
    for (const auto &name : mesh) {
      if (changed) continue;
      EXPECT_EQ(now.at(name), before.at(name)) << step << " " << name;
      if (step > 0) { EXPECT_NE(now.file_of(name), "") << step << " " << name; }
    }
    if (changed) { EXPECT_EQ(now.file_of("CellData/id"), "") << step; }
    if (!changed && step > 0) { EXPECT_EQ(now.file_of("CellData/id"), origin); }
    if (step > 0) {
      EXPECT_EQ(now.file_of("Points"), "");
      EXPECT_EQ(now.file_of("PointData/velocity"), "");
    }
  }
  EXPECT_GT(changes, 2);
  EXPECT_GT(same, 3);
  // spheres: those of the last conversion
  const VtkFile last = file("spheres", 40), before = file("spheres", 38);
  if (last.at("PointData/id") == before.at("PointData/id")) {
    EXPECT_NE(last.file_of("PointData/radius"), "");
  }
  MPI_Barrier(MPI_COMM_WORLD);
}

// A run that goes on from a restart file refers to its own files alone: an earlier run may have written others.
TEST(Vtk, ARunRefersToItsOwnFiles)
{
  const Block block = cracking_beam();
  {
    Lammps lmp;
    lmp.commands(block.script() + vtk("own", 2));
    lmp.run(4);
    lmp.command("write_restart own.restart");
    lmp.run(4);
    EXPECT_EQ(VtkFile("own_elements_6.hdf").file_of("Connectivity"), "own_elements_0.hdf");
  }
  Lammps lmp;
  lmp.commands(block.header() + "read_restart own.restart\n" + block.fix_only() + block.motion() +
               vtk("own", 2));
  lmp.run(4);
  MPI_Barrier(MPI_COMM_WORLD);
  EXPECT_EQ(VtkFile("own_elements_6.hdf").file_of("Connectivity"), "");
  EXPECT_EQ(VtkFile("own_elements_8.hdf").file_of("Connectivity"), "own_elements_6.hdf");
  EXPECT_EQ(VtkFile("own_elements_8.hdf").at("Connectivity"),
            VtkFile("own_elements_4.hdf").at("Connectivity"));
  EXPECT_THAT(contents("own_elements.hdf.series"), HasSubstr("own_elements_8.hdf"));
  MPI_Barrier(MPI_COMM_WORLD);
}

// Those of the group, in the region.
TEST(Vtk, GroupAndRegionChoose)
{
  Lammps lmp;
  const Block block = cracking_beam();
  lmp.commands(block.script() +
               "region left block INF 0.0155 INF INF INF INF\nregion low block INF INF INF 0.0045 "
               "INF INF\nfix vtk all defe/vtk 60 chosen region left\ngroup below region low\n"
               "fix vtk2 below defe/vtk 60 below elements id\n"
               "compute h all defe/hex/local x id\n"
               "compute b below defe/hex/local id\ncompute j all defe/joint/local x id1 id2\n");
  bend(lmp, block, 3.0);
  lmp.run(60);
  const auto left = [](const std::vector<std::vector<double>> &rows) {
    size_t n = 0;
    for (const auto &row : rows) n += row[0] < 0.0155;
    return n;
  };
  const auto hexes = hexes_of("chosen", 60);
  EXPECT_EQ(hexes.size(), left(lmp.local("h")));
  EXPECT_LT(hexes.size(), lmp.local("h").size());
  EXPECT_EQ(joints_of("chosen", 60).size(), left(lmp.local("j")));
  size_t spheres = 0;
  for (const auto &p : lmp.particles()) spheres += p.second.radius > 0.0 && p.second.x[0] < 0.0155;
  EXPECT_EQ(spheres_of("chosen", 60).size(), spheres);
  EXPECT_GT(spheres, 0u);
  EXPECT_EQ(by_id(VtkFile("below_elements_60.hdf"), {}, "id").size(), lmp.local("b").size());
  // and no node without an element
  const VtkFile file("chosen_elements_60.hdf");
  std::vector<int> at(file.npoints(), 0);
  for (double p : file.at("Connectivity")) at[static_cast<size_t>(p)]++;
  EXPECT_EQ(std::count(at.begin(), at.end(), 0), 0);
  MPI_Barrier(MPI_COMM_WORLD);
}

// Positions are not wrapped: no element spans the box, and the body moves on steadily.
TEST(Vtk, ElementsAcrossThePeriodicBoundaryKeepTheirShape)
{
  Block block;
  block.boundary = "p f f";
  block.box_hi[0] = 0.0085;    // the block ends at 8 mm
  Lammps lmp;
  lmp.commands(block.script() + "velocity all set 400 0 0\n" + vtk("across", 100, "elements"));
  lmp.run(200);    // by 4 mm
  const VtkFile file("across_elements_200.hdf");
  ASSERT_EQ(file.ncells(), static_cast<size_t>(block.elements()));
  ASSERT_EQ(file.npoints(), static_cast<size_t>(block.nodes()));
  for (size_t c = 0; c < file.ncells(); c++) {
    Vec3 lo = Vec3::Constant(1.0), hi = -lo;
    for (int a = 0; a < 8; a++) {
      const Vec3 x(file.xyz(file.corner(c, a)));
      lo = lo.cwiseMin(x);
      hi = hi.cwiseMax(x);
    }
    EXPECT_NEAR((hi - lo - Vec3::Constant(block.h)).norm(), 0.0, 1e-9) << "element " << c;
  }
  for (size_t p = 0; p < file.npoints(); p++) {
    EXPECT_NEAR(file.at("PointData/displacement")[3 * p], 4e-3, 1e-9);
    EXPECT_GT(file.xyz(p)[0], 4e-3 - 1e-9);
    EXPECT_LT(file.xyz(p)[0], 12e-3 + 1e-9);
  }
  MPI_Barrier(MPI_COMM_WORLD);
}

// What has yielded is told where a part can yield, and only there.
TEST(Vtk, PlasticStrainOfMetals)
{
  const auto bar = [](const std::string &law) {
    return script_head() +
        "region box block -0.002 0.014 -0.003 0.005 -0.003 0.005\ncreate_box 1 box\n"
        "pair_style zero 0.001\npair_coeff * *\nfix fe all defe material steel " +
        law +
        "\ncreate_hexes fe steel 1 x 0 4 0.008 y 0 1 0.002 z 0 1 0.002\nfix move all nve\n"
        "neighbor 0.0005 bin\ntimestep 5e-8\nvariable v atom x*x*6e5\nvelocity all set v_v NULL "
        "NULL\n";
  };
  Lammps lmp;
  lmp.commands(bar("plastic 200e9 0.3 7830 400e6 1e9") + vtk("metal", 40, "elements") +
               "compute h all defe/hex/local id plastic\n");
  lmp.run(40);
  const VtkFile file("metal_elements_40.hdf");
  const auto rows = lmp.local("h");
  ASSERT_EQ(rows.size(), 4u);
  double most = 0.0, least = 1.0;
  for (const auto &row : rows) {
    for (size_t c = 0; c < file.ncells(); c++)
      if (file.at("CellData/id")[c] == row[0]) {
        EXPECT_EQ(file.at("CellData/plastic")[c], row[1]);
      }
    most = std::max(most, row[1]);
    least = std::min(least, row[1]);
  }
  EXPECT_GT(most, 1e-3);    // it has yielded
  EXPECT_LT(least, 0.5 * most);

  Lammps elastic;
  elastic.commands(bar("elastic 200e9 0.3 7830") + vtk("elastic", 40, "elements"));
  elastic.run(0);
  EXPECT_FALSE(VtkFile("elastic_elements_0.hdf").has("CellData/plastic"));
}

TEST(Vtk, WrongInputIsRefused)
{
  const std::string script = cracking_beam().script();
  const auto refused = [&script](const std::string &words) {
    return failure(script + "fix vtk all defe/vtk " + words);
  };
  EXPECT_THAT(refused("0 a"), HasSubstr("N must be > 0, not 0"));
  EXPECT_THAT(refused("10 a.*.vtk"), HasSubstr("a.*.vtk is no beginning of file names"));
  EXPECT_THAT(refused("10 no/such/a"),
              HasSubstr("cannot write into folder no/such/: No such file or directory"));
  EXPECT_THAT(refused("10 a colour"), HasSubstr("Unknown fix defe/vtk keyword colour"));
  EXPECT_THAT(refused("10 a elements s2"),
              AllOf(HasSubstr("Unknown fix defe/vtk value s2 of elements"),
                    HasSubstr("id, part, stress, s1, vonmises")));
  EXPECT_THAT(refused("10 a elements s1 s1"), HasSubstr("elements s1 is there twice"));
  EXPECT_THAT(refused("10 a joints spheres joints"), HasSubstr("keyword joints is there twice"));
  EXPECT_THAT(refused("10 a spheres strength"),
              HasSubstr("spheres strength needs the keyword strength of fix defe"));
  EXPECT_THAT(refused("10 a elements plastic"),
              HasSubstr("elements plastic needs a part of the law plastic or johnson-cook"));
  EXPECT_THAT(refused("10 a region nowhere"), HasSubstr("region nowhere does not exist"));
  EXPECT_THAT(refused("10 a\nfix vtk2 all defe/vtk 20 a"),
              HasSubstr("fix vtk writes files a already"));
  EXPECT_THAT(failure(Block().header() + Block().box() + "fix vtk all defe/vtk 10 a"),
              HasSubstr("needs a fix defe, which must be defined before it"));
  EXPECT_THAT(refused("10 a elements\nuncompute vtk_elements0\nrun 0"),
              HasSubstr("Fix vtk defe/vtk: its compute vtk_elements0 was deleted"));
  // found at the first step: a folder of the name of a file
  if (rank_of(MPI_COMM_WORLD) == 0) mkdir("folder_elements_0.hdf", 0755);
  MPI_Barrier(MPI_COMM_WORLD);
  EXPECT_THAT(refused("10 folder\nrun 0"),
              HasSubstr("cannot write folder_elements_0.hdf: Is a directory"));
}

// A build without HDF5 has the style all the same, and says what is missing. In a program of its own: here the plugin
// with HDF5 is loaded.
TEST(Vtk, BuildWithoutHdf5NamesThePackage)
{
  if (size_of(MPI_COMM_WORLD) > 1) GTEST_SKIP() << "the program runs on one rank";
  write_file("in.without",
             "plugin load " DEFE_PLUGIN_WITHOUT_HDF5 "\n" + cracking_beam().script() +
                 vtk("without"));
  const pid_t lmp =
      start({DEFE_LMP_EXECUTABLE, "-in", "in.without", "-log", "none"}, "without.log");
  EXPECT_NE(wait_for_end(lmp, 60.0), 0);
  EXPECT_THAT(contents("without.log"),
              HasSubstr("Fix defe/vtk: this DEFE was built without HDF5: install the package "
                        "libhdf5-"));
}
