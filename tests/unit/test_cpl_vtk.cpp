// What is written for ParaView: cells and tensors as VTK has them, and the list of a time series.

#include "defe/coupling/vtk_grid.h"
#include "defe/coupling/vtk_series.h"

#include <gmock/gmock.h>

#include <cstdio>
#include <fstream>
#include <sstream>

using namespace defe;
using testing::ElementsAre;
using testing::HasSubstr;

TEST(Vtk, CellsFollowOneAnother)
{
  VtkGrid grid;
  const double x[3] = {1.0, 2.0, 3.0};
  grid.add_point(x);
  EXPECT_EQ(grid.npoints(), 1u);
  const std::int64_t hex[8] = {10, 11, 12, 13, 14, 15, 16, 17}, line[2] = {3, 1}, one = 7;
  grid.add_cell(VtkGrid::HEXAHEDRON, hex);
  grid.add_cell(VtkGrid::LINE, line);
  grid.add_cell(VtkGrid::VERTEX, &one);
  EXPECT_EQ(grid.ncells(), 3u);
  EXPECT_THAT(grid.types, ElementsAre(12, 3, 1));
  EXPECT_THAT(grid.ends, ElementsAre(8, 10, 11));
  EXPECT_THAT(grid.connectivity, ElementsAre(10, 11, 12, 13, 14, 15, 16, 17, 3, 1, 7));
}

// ParaView names six components XX, YY, ZZ, XY, YZ, XZ.
TEST(Vtk, TensorHasParaViewsOrder)
{
  const double s[6] = {1.0, 2.0, 3.0, 12.0, 13.0, 23.0};    // xx yy zz xy xz yz
  double t[6];
  vtk_tensor(s, t);
  EXPECT_THAT(t, ElementsAre(1.0, 2.0, 3.0, 12.0, 23.0, 13.0));
}

TEST(Vtk, SeriesNamesItsFilesBesideIt)
{
  VtkSeries series("out/pa\"ne", {"elements", "joints"});
  EXPECT_EQ(series.file("joints", 50), "out/pa\"ne_joints_50.hdf");
  EXPECT_EQ(series.list_file("joints"), "out/pa\"ne_joints.hdf.series");
  EXPECT_FALSE(series.has(0));
  series.add(0, 0.0);
  series.add(50, 2.5e-6);
  EXPECT_TRUE(series.has(50));
  EXPECT_FALSE(series.has(51));
  EXPECT_EQ(series.list("joints"),
            "{\n  \"file-series-version\" : \"1.0\",\n  \"files\" : [\n"
            "    { \"name\" : \"pa\\\"ne_joints_0.hdf\", \"time\" : 0 },\n"
            "    { \"name\" : \"pa\\\"ne_joints_50.hdf\", \"time\" : 2.5e-06 }\n  ]\n}\n");
}

TEST(Vtk, SeriesGoesOnWithTheSameFilesOnly)
{
  VtkSeries series("out/pane", {"elements", "joints"});
  series.add(0, 0.0);
  series.add(50, 2.5e-6);
  const std::string record = series.pack();
  VtkSeries same("out/pane", {"elements", "joints"});
  ASSERT_TRUE(same.unpack(record.c_str()));
  EXPECT_EQ(same.list("elements"), series.list("elements"));
  for (VtkSeries other :
       {VtkSeries("out/pane2", {"elements", "joints"}), VtkSeries("out/pane", {"elements"})}) {
    EXPECT_FALSE(other.unpack(record.c_str()));
    EXPECT_TRUE(other.steps().empty());
  }
  EXPECT_FALSE(same.unpack("another record"));
}

TEST(Vtk, FileIsReplacedAsAWhole)
{
  const std::string file = "vtk.series";
  const auto contents = [](const std::string &name) {
    std::ifstream in(name);
    std::ostringstream text;
    text << in.rdbuf();
    return text.str();
  };
  EXPECT_EQ(replace_file(file, "a long text\n"), "");
  EXPECT_EQ(replace_file(file, "short\n"), "");
  EXPECT_EQ(contents(file), "short\n");
  EXPECT_FALSE(std::ifstream(file + ".tmp"));
  std::remove(file.c_str());
  EXPECT_THAT(replace_file("no/such/folder/vtk.series", "text"),
              HasSubstr("cannot write no/such/folder/vtk.series: No such file"));
}
