// Joint laws: DEs per second. The orthogonal corner-strain kernel is the hot loop of pure DEM.

#include "defe/coupling/corner_strain.h"
#include "defe/coupling/joint_table.h"

#include <benchmark/benchmark.h>

#include <algorithm>
#include <array>
#include <numeric>
#include <random>
#include <vector>

using namespace defe;

namespace {

/// nx x ny x nz DEs of spacing d, x fastest; `broken` of the joints absent at random.
struct Block {
  std::vector<double> x;
  std::vector<int> self;
  std::vector<std::array<int, 6>> nb;
  std::vector<unsigned char> present;
  std::vector<std::array<double, 6>> len, half;
  std::vector<std::array<double, 18>> force;
  std::vector<double> energy;

  Block(int nx, int ny, int nz, double broken)
  {
    const double d = 1e-3;
    const int n = nx * ny * nz;
    std::mt19937 random(1);
    std::uniform_real_distribution<double> uniform(-1.0, 1.0);
    const auto at = [&](int i, int j, int k) {
      return i + nx * (j + ny * k);
    };
    self.resize(n);
    std::iota(self.begin(), self.end(), 0);
    nb.resize(n);
    present.assign(n, 0);
    len.assign(n, {d, d, d, d, d, d});
    half.assign(n, {d / 2, d / 2, d / 2, d / 2, d / 2, d / 2});
    force.resize(n);
    energy.resize(n);
    for (int k = 0; k < nz; ++k)
      for (int j = 0; j < ny; ++j)
        for (int i = 0; i < nx; ++i) {
          const int me = at(i, j, k);
          const int c[3] = {i, j, k}, size[3] = {nx, ny, nz};
          for (int a = 0; a < 3; ++a) x.push_back(d * (c[a] + 1e-3 * uniform(random)));
          for (int s = 0; s < 6; ++s) {
            int o[3] = {i, j, k};
            o[s / 2] += s % 2 ? 1 : -1;
            nb[me][s] = me;
            if (o[s / 2] < 0 || o[s / 2] >= size[s / 2]) continue;
            nb[me][s] = at(o[0], o[1], o[2]);
            if (uniform(random) >= 2.0 * broken - 1.0) present[me] |= 1u << s;
          }
        }
  }

  OrthogonalLattice lattice() const
  {
    using Ints = const int(*)[6];
    using Doubles = const double(*)[6];
    return {static_cast<int>(self.size()),
            self.data(),
            reinterpret_cast<Ints>(nb.data()),
            present.data(),
            reinterpret_cast<Doubles>(len.data()),
            reinterpret_cast<Doubles>(half.data()),
            nullptr};
  }
};

const CornerModuli glass{74.09e9 * 0.2 / (1.2 * 0.6), 74.09e9 / 2.4};

/// Where eight DEs and their neighbours follow one another.
LargeVector<LatticeRow> rows_of(const Block &block)
{
  JointTable table;
  table.nde = static_cast<int>(block.self.size());
  table.self.assign(block.self.begin(), block.self.end());
  table.nb.assign(block.nb.begin(), block.nb.end());
  table.present = block.present;
  for (int d = 0; d < table.nde; ++d) {
    table.partner.emplace_back();
    for (int s = 0; s < 6; ++s)
      table.partner[d][s] = block.nb[d][s] == d ? -1 : 6 * block.nb[d][s] + (s ^ 1);
  }
  table.find_rows();
  return table.rows;
}

/// The glass beam, 200 x 20 x 10 DEs. Argument: joints broken at random, per mille.
/// \param in_rows  as in LAMMPS, where the DEs of a lattice lie in rows; else as anywhere
void orthogonal(benchmark::State &state, bool with_energy, bool in_rows)
{
  Block block(200, 20, 10, 1e-3 * state.range(0));
  OrthogonalLattice lattice = block.lattice();
  const HalfForces force(block.force[0].data(), lattice.n);
  LargeVector<LatticeRow> rows;
  if (in_rows) {
    rows = rows_of(block);
    lattice.rows = rows.data();
  }
  for (auto _ : state) {
    corner_strain_orthogonal(lattice, block.x.data(), nullptr, &glass, force,
                             with_energy ? block.energy.data() : nullptr);
    benchmark::ClobberMemory();
  }
  state.SetItemsProcessed(state.iterations() * lattice.n);
}
BENCHMARK_CAPTURE(orthogonal, forces, false, false)->Arg(0)->Arg(10)->Arg(500);
BENCHMARK_CAPTURE(orthogonal, forces_and_energy, true, false)->Arg(0);
BENCHMARK_CAPTURE(orthogonal, forces_in_rows, false, true)->Arg(0)->Arg(10);

/// \param height  of a cell by its other edges
/// \param kept    what does not change with positions is made once
void general(benchmark::State &state, double height, bool kept)
{
  Block block(200, 20, 10, 0.0);
  GeneralCell cell{};
  for (int s = 0; s < 6; ++s) {
    cell.dX[s].setZero();
    cell.dX[s][s / 2] = (s % 2 ? 1e-3 : -1e-3) * (s / 2 == 2 ? height : 1.0);
    cell.face[s] = 0.5 * cell.dX[s];
  }
  const int n = static_cast<int>(block.self.size());
  std::vector<CornerTable> tables;
  for (int i = 0; i < n; ++i) tables.emplace_back(cell, block.present[i], glass);
  Vec3 y[6], f[6];
  for (auto _ : state)
    for (int i = 0; i < n; ++i) {
      for (int s = 0; s < 6; ++s)
        for (int c = 0; c < 3; ++c) y[s][c] = block.x[3 * block.nb[i][s] + c] - block.x[3 * i + c];
      if (kept)
        benchmark::DoNotOptimize(corner_strain_general(cell, tables[i], y, glass, f));
      else
        benchmark::DoNotOptimize(corner_strain_general(cell, y, block.present[i], glass, f));
      for (int s = 0; s < 6; ++s)
        for (int c = 0; c < 3; ++c) block.force[i][3 * s + c] = f[s][c];
    }
  state.SetItemsProcessed(state.iterations() * n);
}
BENCHMARK_CAPTURE(general, cubes, 1.0, true);
BENCHMARK_CAPTURE(general, flat, 0.5, true);
BENCHMARK_CAPTURE(general, cubes_without_tables, 1.0, false);
BENCHMARK_CAPTURE(general, flat_without_tables, 0.5, false);

}    // namespace
