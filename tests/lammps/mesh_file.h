#ifndef DEFE_TEST_MESH_FILE_H
#define DEFE_TEST_MESH_FILE_H

// Meshes in LAMMPS data files, for `read_data FILE add append fix fe hexes Hexes`.

#include "lammps_run.h"

#include "defe/fe/topology.h"

#include <array>
#include <cstdio>
#include <functional>
#include <string>
#include <vector>

namespace defe::test {

struct MeshFile {
  std::vector<Vec3> X;                                           // node k has ID k + 1
  std::vector<std::array<tagint, 8>> hex;                        // element e has ID e + 1
  std::vector<std::string> part;                                 // of each element
  std::vector<int> type;                                         // of each node
  std::vector<tagint> ids;                                       // of elements, if not e + 1
  Vec3 lo = Vec3::Constant(-0.02), hi = Vec3::Constant(0.03);    // box
  int types = 2;

  /// nx x ny x nz hexes with edges h, nodes moved by `map`.
  void add_block(const std::string &name, int node_type, int nx, int ny, int nz, double h,
                 const std::function<Vec3(const Vec3 &)> &map)
  {
    const tagint first = static_cast<tagint>(X.size()) + 1;
    for (int k = 0; k <= nz; k++)
      for (int j = 0; j <= ny; j++)
        for (int i = 0; i <= nx; i++) {
          X.push_back(map(Vec3(i * h, j * h, k * h)));
          type.push_back(node_type);
        }
    for (int k = 0; k < nz; k++)
      for (int j = 0; j < ny; j++)
        for (int i = 0; i < nx; i++) {
          std::array<tagint, 8> nodes;
          for (int a = 0; a < 8; a++)
            nodes[a] = first + i + (fe::hex_sign[a][0] + 1) / 2 +
                (nx + 1) *
                    (j + (fe::hex_sign[a][1] + 1) / 2 +
                     (ny + 1) * (k + (fe::hex_sign[a][2] + 1) / 2));
          hex.push_back(nodes);
          part.push_back(name);
        }
  }

  /// Rank 0 writes; all wait for it.
  void write(const std::string &file, MPI_Comm comm = MPI_COMM_WORLD) const
  {
    if (rank_of(comm) == 0) {
      FILE *fp = std::fopen(file.c_str(), "w");
      if (!fp) throw std::runtime_error("cannot write " + file);
      std::fprintf(fp, "mesh of a test\n\n%zu atoms\n%d atom types\n%zu hexes\n\n", X.size(), types,
                   hex.size());
      for (int k = 0; k < 3; k++)
        std::fprintf(fp, "%.17g %.17g %clo %chi\n", lo[k], hi[k], "xyz"[k], "xyz"[k]);
      std::fprintf(fp, "\nAtoms # sphere\n\n");
      for (size_t n = 0; n < X.size(); n++)
        std::fprintf(fp, "%zu %d 0 1 %.17g %.17g %.17g\n", n + 1, type[n], X[n][0], X[n][1],
                     X[n][2]);
      std::fprintf(fp, "\nHexes\n\n");
      for (size_t e = 0; e < hex.size(); e++) {
        std::fprintf(fp, "%lld %s", static_cast<long long>(ids.empty() ? e + 1 : ids[e]),
                     part[e].c_str());
        for (tagint t : hex[e]) std::fprintf(fp, " %lld", static_cast<long long>(t));
        std::fprintf(fp, "\n");
      }
      std::fclose(fp);
    }
    MPI_Barrier(comm);
  }
};

/// The command that reads it.
inline std::string read_mesh(const std::string &file)
{
  return "read_data " + file + " add append fix fe hexes Hexes\n";
}

}    // namespace defe::test

#endif
