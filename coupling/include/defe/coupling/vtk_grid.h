#ifndef DEFE_COUPLING_VTK_GRID_H
#define DEFE_COUPLING_VTK_GRID_H

/// \file
/// What one rank writes for ParaView: points, cells and their values, as an unstructured grid of VTK has them.
/// Cells may name points of other ranks: points are numbered through all ranks.

#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

namespace defe {

/// One value, vector or tensor per point or cell. Numbers that are whole are written as integers.
struct VtkField {
  std::string name;
  int components;
  bool whole;
  std::vector<double> values;

  VtkField(const std::string &name, int components, bool whole) :
      name(name), components(components), whole(whole)
  {
  }
  void add(double a) { values.push_back(a); }
  void add(const double *a) { values.insert(values.end(), a, a + components); }
};

struct VtkGrid {
  /// Types of cells, by VTK's numbers.
  enum Cell : unsigned char { VERTEX = 1, LINE = 3, HEXAHEDRON = 12 };
  static constexpr int corners(Cell c) { return c == HEXAHEDRON ? 8 : c == LINE ? 2 : 1; }

  std::vector<double> points;    ///< three coordinates each
  std::vector<unsigned char> types;
  std::vector<std::int64_t> connectivity;    ///< points of the cells, one cell after the other
  std::vector<std::int64_t> ends;            ///< of each cell in `connectivity`
  std::vector<VtkField> point_fields, cell_fields;

  std::size_t npoints() const { return points.size() / 3; }
  std::size_t ncells() const { return types.size(); }

  void add_point(const double *x) { points.insert(points.end(), x, x + 3); }
  /// \param corner  numbers of its points; a hexahedron has the order of an Abaqus C3D8, which is VTK's
  void add_cell(Cell type, const std::int64_t *corner);
};

/// Symmetric tensor from xx yy zz xy xz yz to the order in which ParaView names components: XX YY ZZ XY YZ XZ.
void vtk_tensor(const double *stress6, double *tensor);

}    // namespace defe

#endif
