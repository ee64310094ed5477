#ifndef DEFE_TEST_DE_BLOCK_H
#define DEFE_TEST_DE_BLOCK_H

// Meshes of hexahedra of which some elements are converted, assembled as a LAMMPS run would do it:
// DEs joined to siblings and to the DEs of converted neighbours at the common corner node, tied to
// the faces of neighbours that are still finite.

#include "defe/coupling/conversion.h"
#include "defe/coupling/corner_strain.h"
#include "defe/fe/enhanced_kernel.h"
#include "defe/fe/hex8.h"
#include "defe/fe/topology.h"

#include <Eigen/Geometry>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <functional>
#include <random>
#include <vector>

namespace defe::test {

using Vectors = std::vector<Vec3>;

struct Mesh {
  Vectors X;
  std::vector<std::array<std::int64_t, 8>> hex;

  fe::HexCoords coords(int e, const Vectors &x) const
  {
    fe::HexCoords c;
    for (int k = 0; k < 8; ++k) c.col(k) = x[hex[e][k]];
    return c;
  }
};

/// nx x ny x nz hexes of edge h, centred at the origin, every node moved by `map`; element
/// (i, j, k) has number i + nx (j + ny k).
inline Mesh box_mesh(int nx, int ny, int nz, double h,
                     const std::function<Vec3(const Vec3 &)> &map = nullptr)
{
  Mesh mesh;
  const auto node = [&](int i, int j, int k) {
    return i + (nx + 1) * (j + (ny + 1) * k);
  };
  for (int k = 0; k <= nz; ++k)
    for (int j = 0; j <= ny; ++j)
      for (int i = 0; i <= nx; ++i) {
        const Vec3 X(h * (i - 0.5 * nx), h * (j - 0.5 * ny), h * (k - 0.5 * nz));
        mesh.X.push_back(map ? map(X) : X);
      }
  for (int k = 0; k < nz; ++k)
    for (int j = 0; j < ny; ++j)
      for (int i = 0; i < nx; ++i) {
        std::array<std::int64_t, 8> hex;
        for (int m = 0; m < 8; ++m)
          hex[m] = node(i + (fe::hex_sign[m][0] + 1) / 2, j + (fe::hex_sign[m][1] + 1) / 2,
                        k + (fe::hex_sign[m][2] + 1) / 2);
        mesh.hex.push_back(hex);
      }
  return mesh;
}

/// Number the nodes of every element anew, by one of the 24 rotations of a cube: nothing may depend
/// on the local axes.
inline void shuffle_local_axes(Mesh &mesh, std::mt19937 &random)
{
  for (auto &hex : mesh.hex) {
    int axis[3] = {0, 1, 2}, sign[3];
    std::shuffle(axis, axis + 3, random);
    for (int &s : sign) s = random() % 2 ? 1 : -1;
    Mat3 R = Mat3::Zero();
    for (int a = 0; a < 3; ++a) R(axis[a], a) = sign[a];
    if (R.determinant() < 0.0) R.col(2) *= -1.0;
    const auto old = hex;
    for (int m = 0; m < 8; ++m) {
      const Vec3 turned = R * Vec3(fe::hex_sign[m][0], fe::hex_sign[m][1], fe::hex_sign[m][2]);
      for (int k = 0; k < 8; ++k)
        if (turned == Vec3(fe::hex_sign[k][0], fe::hex_sign[k][1], fe::hex_sign[k][2]))
          hex[m] = old[k];
    }
  }
}

class Block {
 public:
  struct Particle {
    int element, place;
    NewDE birth;
    GeneralCell cell;
    unsigned present = 0;
    std::uint16_t turned = 0;    ///< see CrackLattice
    int nb[6] = {};              ///< other end: particle number, or ~number of the tie
    int nb_slot[6] = {};         ///< the other DE's slot of the same joint
  };

  Mesh mesh;
  fe::IsotropicElastic material;
  CornerModuli moduli;
  std::vector<char> converted;
  std::vector<Particle> de;
  std::vector<std::array<int, 4>> tie;    ///< face nodes, from the nearest one on
  std::vector<TieSpot> spot;              ///< of ties
  ElementSplit split;
  std::vector<std::array<int, 8>> elements;
  Vectors X;                   ///< nodes, then DEs
  std::vector<double> mass;    ///< of nodes (living elements only), then DEs
  bool orthogonal = false;     ///< forces by corner_strain_orthogonal

  Block(const Mesh &m, const std::vector<char> &which, const fe::IsotropicElastic &material,
        ElementSplit s = ElementSplit()) :
      mesh(m),
      material(material), moduli{material.lambda(), material.mu()}, converted(which), split(s),
      X(m.X)
  {
    const int ne = static_cast<int>(mesh.hex.size());
    mass.assign(X.size(), 0.0);
    std::vector<int> first(ne, -1);
    for (int e = 0; e < ne; ++e) {
      const fe::HexCoords C = mesh.coords(e, mesh.X);
      const double m_e = material.rho * fe::volume(C);
      if (!converted[e]) {
        std::array<int, 8> nodes;
        for (int k = 0; k < 8; ++k) {
          nodes[k] = static_cast<int>(mesh.hex[e][k]);
          mass[nodes[k]] += m_e / 8.0;
        }
        elements.push_back(nodes);
        continue;
      }
      first[e] = static_cast<int>(de.size());
      const auto born = convert_hex(C, C, fe::HexCoords::Zero(), m_e, split);
      for (int k = 0; k < split.des(); ++k) {
        Particle p;
        p.element = e;
        p.place = k;
        p.birth = born[k];
        p.cell = cell_of(born, k, split);
        de.push_back(p);
      }
    }
    for (const Particle &p : de) {
      X.push_back(p.birth.X);
      mass.push_back(p.birth.mass);
    }

    const auto neighbors = fe::match_faces(mesh.hex);
    for (Particle &p : de)
      for (int s = 0; s < 6; ++s) {
        if (!split.outer(p.place, s)) {
          p.nb[s] = first[p.element] + split.beside(p.place, s);
          p.nb_slot[s] = s ^ 1;
        } else {
          const fe::FaceNeighbor &other = neighbors[p.element][s];
          if (other.element < 0) {
            p.cell.free |= 1u << s;
            continue;
          }
          const int at = split.first_on_face(p.place, s);
          if (converted[other.element]) {
            const int rotation = fe::hex_face_position(other.face, other.node[0]);
            p.nb[s] = first[other.element] + split.behind(p.place, s, other.face, rotation);
            if (split.des() == 1) p.turned |= static_cast<std::uint16_t>(rotation << 2 * s);
            p.nb_slot[s] = other.face;
            p.cell.dX[s] = de[p.nb[s]].birth.X - p.birth.X;
          } else {
            std::array<int, 4> nodes;
            for (int i = 0; i < 4; ++i)
              nodes[i] = static_cast<int>(mesh.hex[p.element][fe::hex_face[s][(at + i) % 4]]);
            p.nb[s] = ~static_cast<int>(tie.size());
            p.nb_slot[s] = -1;
            p.cell.tie |= 1u << s;
            tie.push_back(nodes);
            spot.push_back(split.spot(p.place, s));
            p.cell.dX[s] = tie_point(tie.size() - 1, mesh.X) - p.birth.X;
          }
        }
        p.present |= 1u << s;
      }
  }

  /// Take a joint out, at both its ends.
  void remove(int i, int s)
  {
    if (!(de[i].present >> s & 1u)) return;
    de[i].present &= ~(1u << s);
    if (de[i].nb[s] >= 0) de[de[i].nb[s]].present &= ~(1u << de[i].nb_slot[s]);
  }

  int nodes() const { return static_cast<int>(mesh.X.size()); }
  int des() const { return static_cast<int>(de.size()); }

  Vec3 tie_point(int t, const Vectors &x) const
  {
    Vec3 p = Vec3::Zero();
    for (int i = 0; i < 4; ++i) p += weights_of(spot[t])[i] * x[tie[t][i]];
    return p;
  }

  /// Strain energy; adds to f.
  double joint_forces(const Vectors &x, Vectors &f) const
  {
    const int n = des(), n0 = nodes();
    std::vector<std::array<Vec3, 6>> half(n);
    double energy = 0.0;
    if (orthogonal) {
      energy = orthogonal_forces(x, half);
    } else {
      for (int i = 0; i < n; ++i) {
        Vec3 y[6];
        for (int s = 0; s < 6; ++s)
          if (de[i].present >> s & 1u)
            y[s] =
                (de[i].nb[s] >= 0 ? x[n0 + de[i].nb[s]] : tie_point(~de[i].nb[s], x)) - x[n0 + i];
        energy += corner_strain_general(de[i].cell, y, de[i].present, moduli, half[i].data());
      }
    }
    for (int i = 0; i < n; ++i)
      for (int s = 0; s < 6; ++s) {
        if (!(de[i].present >> s & 1u)) continue;
        f[n0 + i] += half[i][s];
        if (de[i].nb[s] >= 0)
          f[n0 + de[i].nb[s]] -= half[i][s];
        else
          for (int k = 0; k < 4; ++k) {
            const int t = ~de[i].nb[s];
            f[tie[t][k]] -= weights_of(spot[t])[k] * half[i][s];
          }
      }
    return energy;
  }

  /// Everything: finite elements (enhanced, total Lagrangian) and joints. Returns the energy, sets f.
  double forces(const Vectors &x, Vectors &f) const
  {
    f.assign(x.size(), Vec3::Zero());
    double energy = joint_forces(x, f);
    const fe::EnhancedKernel kernel(material);
    std::vector<double> energies(elements.size());
    fe::HexKernel::Output out;
    out.energy = energies.data();
    if (!elements.empty())
      kernel.add_forces(static_cast<int>(elements.size()),
                        reinterpret_cast<const int(*)[8]>(elements.data()), x[0].data(),
                        X[0].data(), f[0].data(), out);
    for (double e : energies) energy += e;
    return energy;
  }

 private:
  double orthogonal_forces(const Vectors &x, std::vector<std::array<Vec3, 6>> &half) const
  {
    const int n = des(), n0 = nodes();
    std::vector<int> self(n);
    std::vector<std::array<int, 6>> nb(n);
    std::vector<unsigned char> present(n), free(n);
    std::vector<std::array<double, 6>> len(n), thick(n);
    std::vector<double> energy(n);
    Vectors points;
    for (std::size_t t = 0; t < tie.size(); ++t) points.push_back(tie_point(t, x));
    for (int i = 0; i < n; ++i) {
      self[i] = n0 + i;
      present[i] = de[i].present;
      free[i] = de[i].cell.free;
      for (int s = 0; s < 6; ++s) {
        const bool there = present[i] >> s & 1u;
        nb[i][s] = there ? (de[i].nb[s] >= 0 ? n0 + de[i].nb[s] : de[i].nb[s]) : -999999;
        len[i][s] = there ? de[i].cell.dX[s].norm() : 1.0;
        thick[i][s] = de[i].cell.face[s].norm();
      }
    }
    const OrthogonalLattice lattice{n,
                                    self.data(),
                                    reinterpret_cast<const int(*)[6]>(nb.data()),
                                    present.data(),
                                    reinterpret_cast<const double(*)[6]>(len.data()),
                                    reinterpret_cast<const double(*)[6]>(thick.data()),
                                    nullptr,
                                    free.data()};
    static_assert(sizeof(std::array<Vec3, 6>) == 18 * sizeof(double), "half forces are contiguous");
    return corner_strain_orthogonal(lattice, x[0].data(),
                                    points.empty() ? nullptr : points[0].data(), &moduli,
                                    reinterpret_cast<double(*)[6][3]>(half.data()), energy.data());
  }
};

/// x = F X for all nodes and DEs.
inline Vectors deformed(const Vectors &X, const Mat3 &F)
{
  Vectors x;
  for (const Vec3 &p : X) x.push_back(F * p);
  return x;
}

inline double uniform(std::mt19937 &random, double low, double high)
{
  return std::uniform_real_distribution<double>(low, high)(random);
}

inline Vec3 random_vector(std::mt19937 &random, double size)
{
  return Vec3(uniform(random, -size, size), uniform(random, -size, size),
              uniform(random, -size, size));
}

inline Mat3 random_rotation(std::mt19937 &random)
{
  const Vec3 axis = random_vector(random, 1.0).normalized();
  return Eigen::AngleAxisd(uniform(random, 0.0, 3.14), axis).toRotationMatrix();
}

}    // namespace defe::test

#endif
