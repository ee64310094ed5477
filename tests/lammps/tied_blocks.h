#ifndef DEFE_TEST_TIED_BLOCKS_H
#define DEFE_TEST_TIED_BLOCKS_H

// Two glass blocks whose meshes do not match, one on the other.

#include "glass_block.h"
#include "mesh_file.h"

#include <Eigen/Geometry>

namespace defe::test::tied {

constexpr double E = 74.09e9, nu = 0.2, rho = 2500.0;    // glass
constexpr double L = 6e-3;                               // edge of a block
constexpr double stiffness = 4.0;                        // the default

inline Mat3 tilt()
{
  return Eigen::AngleAxisd(0.4, Vec3(1.0, -2.0, 0.5).normalized()).toRotationMatrix();
}

/// A block of n^3 elements and one of m^3 on it, turned by R. Element IDs and nodes: first the lower block.
inline MeshFile two_blocks(int n, int m, const Mat3 &R, double gap = 0.0)
{
  MeshFile mesh;
  mesh.add_block("low", 1, n, n, n, L / n, [&](const Vec3 &X) {
    return Vec3(R * X);
  });
  mesh.add_block("high", 1, m, m, m, L / m, [&](const Vec3 &X) {
    return Vec3(R * (X + Vec3(0.0, 0.0, L + gap)));
  });
  return mesh;
}

constexpr double period = 0.05;    // of the box of before_mesh()

/// 2^3 elements and 3^3 on them, each block moved on its own: to where they meet across borders of the periodic box.
inline MeshFile blocks_apart(const Vec3 &low, const Vec3 &high)
{
  MeshFile mesh;
  mesh.add_block("low", 1, 2, 2, 2, L / 2, [&](const Vec3 &X) {
    return Vec3(X + low);
  });
  mesh.add_block("high", 1, 3, 3, 3, L / 3, [&](const Vec3 &X) {
    return Vec3(X + Vec3(0.0, 0.0, L) + high);
  });
  return mesh;
}

inline std::string fix_of(const std::string &options)
{
  return "fix fe all defe material glass elastic " + number(E) + " " + number(nu) + " " +
      number(rho) + " part low glass part high glass " + options + "\n";
}

inline std::string before_mesh(const std::string &options)
{
  return script_head() +
      "region box block -0.02 0.03 -0.02 0.03 -0.02 0.03\ncreate_box 2 box\n"
      "pair_style zero 0.002\npair_coeff * *\n" +
      fix_of(options);
}

inline const std::string motion =
    "group nodes type 1\nfix move nodes nve\nneighbor 5e-4 bin\ntimestep 5e-8\n";

inline std::string script(const MeshFile &mesh, const std::string &options,
                          MPI_Comm comm = MPI_COMM_WORLD, const std::string &file = "tied.data")
{
  mesh.write(file, comm);
  return before_mesh(options) + read_mesh(file) + motion;
}

// Elements of them convert.

inline const std::string strong = "cohesive 1e12 1e6 0.1", weak = "cohesive 60e6 0.5 0.1";

inline std::string converting(const std::string &part, const std::string &more = "")
{
  return " convert " + part + " 20e6 type 2 group particles" + more;
}
inline const std::string glued = " tied low high check yes";

inline std::string pair_lines(const std::string &law)
{
  return "pair_style defe/joint\npair_coeff 2 2 connective material " + law + " contact 0.9 0.2\n";
}

/// Before the mesh.
inline std::string head(const std::string &options, const std::string &law,
                        const std::string &boundary = "f f f")
{
  std::string text = before_mesh(options);
  text.replace(text.find("f f f"), 5, boundary);
  text.replace(text.find("pair_style"), text.find("fix fe") - text.find("pair_style"),
               pair_lines(law) + "group particles empty\n");
  return text;
}

inline const std::string moving = motion + "timestep 1e-8\nfix move2 particles nve/sphere\n";

inline std::string blocks(int n, int m, const Mat3 &R, const std::string &options,
                          const std::string &law = strong, MPI_Comm comm = MPI_COMM_WORLD,
                          const std::string &file = "conversion.data")
{
  two_blocks(n, m, R).write(file, comm);
  return head(options, law) + read_mesh(file) + moving;
}

}    // namespace defe::test::tied

#endif
