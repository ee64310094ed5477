// Rates of the finite-element kernels on a block of bricks, in element-steps per second: the
// counter items_per_second. The smallest block has the size of the paper's glass beam. The bare
// loops are what the processor could do at best: linear K u without rotation or criterion.

#include "defe/fe/enhanced_kernel.h"
#include "defe/fe/hex8.h"
#include "defe/fe/kernel.h"
#include "defe/fe/mooney_rivlin.h"
#include "defe/fe/prony.h"
#include "defe/fe/stable_step.h"

#include "hex_modes.h"    // private to fe-module: gather and scatter as the kernels do them

#include <benchmark/benchmark.h>

#include <array>
#include <cmath>
#include <memory>
#include <random>
#include <vector>

namespace {

using namespace defe;
using namespace defe::fe;

const IsotropicElastic glass{74.09e9, 0.2, 2500.0};
const MooneyRivlin rubber{1.60e6, 0.06e6, 331e6, 1100.0};
const Prony pvb{20e9, 1100.0, 0.69e6, {{0.33e9, 12.6}}};

// nx x ny x nz cubes of 2 mm, stretched and bent by strains of the order of glass at failure
struct Block {
  std::vector<std::array<int, 8>> hexes;
  std::vector<double> X, x, f;

  Block(int nx, int ny, int nz)
  {
    const double h = 2e-3;
    const auto node = [=](int i, int j, int k) {
      return (k * (ny + 1) + j) * (nx + 1) + i;
    };
    std::mt19937 random(1);
    std::uniform_real_distribution<double> noise(-1e-4 * h, 1e-4 * h);
    for (int k = 0; k <= nz; ++k)
      for (int j = 0; j <= ny; ++j)
        for (int i = 0; i <= nx; ++i) {
          const double r[3] = {i * h, j * h, k * h};
          X.insert(X.end(), r, r + 3);
          const double angle = 5e-3 * i / nx;
          x.push_back(r[0] * (1 + 8e-4) - angle * r[1] + noise(random));
          x.push_back(r[1] + angle * r[0] + noise(random));
          x.push_back(r[2] + noise(random));
        }
    for (int k = 0; k < nz; ++k)
      for (int j = 0; j < ny; ++j)
        for (int i = 0; i < nx; ++i) {
          std::array<int, 8> hex;
          for (int a = 0; a < 8; ++a)
            hex[a] = node(i + (hex_sign[a][0] + 1) / 2, j + (hex_sign[a][1] + 1) / 2,
                          k + (hex_sign[a][2] + 1) / 2);
          hexes.push_back(hex);
        }
    f.assign(X.size(), 0.0);
  }

  const int (*nodes() const)[8] { return reinterpret_cast<const int(*)[8]>(hexes.data()); }

  HexCoords shape(int e) const
  {
    HexCoords Xe;
    for (int a = 0; a < 8; ++a)
      for (int i = 0; i < 3; ++i) Xe(i, a) = X[3 * hexes[e][a] + i];
    return Xe;
  }
};

Block block_of(int64_t size)
{
  if (size <= 5150) return {103, 10, 5};
  return {static_cast<int>(size / 2500), 50, 50};
}

enum Kind { brick, plain_brick, lagrangian, enhanced, mooney, prony };
enum Wanted { forces = 0, bound = 1, energy = 2, virial = 4, gauss_bound = 8, dissipation = 16 };

void add_forces(benchmark::State &state, Kind kind, int wanted)
{
  Block block = block_of(state.range(0));
  std::unique_ptr<HexKernel> kernel;
  if (kind == brick)
    kernel = std::make_unique<BrickKernel>(block.shape(0), glass);
  else if (kind == plain_brick)
    kernel = std::make_unique<BrickKernel>(block.shape(0), glass, ElementType::plain);
  else if (kind == lagrangian)
    kernel = std::make_unique<LagrangianKernel>(glass);
  else if (kind == enhanced)
    kernel = std::make_unique<EnhancedKernel>(glass);
  else if (kind == mooney)
    kernel = std::make_unique<MooneyRivlinKernel>(rubber);
  else
    kernel = std::make_unique<PronyKernel>(pvb);

  const int n = static_cast<int>(block.hexes.size());
  std::vector<double> bounds(n), energies(n);
  double virials[6] = {};
  int inverted;
  HexKernel::Output out;
  out.inverted = &inverted;
  if (wanted & (bound | gauss_bound)) out.stress_bound = bounds.data();
  if (wanted & gauss_bound) out.bound_at_gauss_points = true;
  if (wanted & energy) out.energy = energies.data();
  if (wanted & virial) out.virial = virials;
  double dissipated = 0.0;
  if (wanted & dissipation) out.dissipation = &dissipated;
  std::vector<double> history(static_cast<std::size_t>(n) * kernel->history_size());
  std::vector<double *> of_element;
  for (int e = 0; e < n; ++e) of_element.push_back(history.data() + e * kernel->history_size());
  out.history = of_element.data();
  out.dt = 1e-7;

  for (auto _ : state) {
    kernel->add_forces(n, block.nodes(), block.x.data(), block.X.data(), block.f.data(), out);
    benchmark::ClobberMemory();
  }
  if (inverted >= 0) state.SkipWithError("inverted element");
  state.SetItemsProcessed(state.iterations() * n);
}

void sizes(benchmark::internal::Benchmark *b)
{
  for (int size : {5150, 200000, 2000000}) b->Arg(size);
  b->Unit(benchmark::kMicrosecond);
}

void beam_only(benchmark::internal::Benchmark *b)
{
  b->Arg(5150)->Unit(benchmark::kMicrosecond);
}

BENCHMARK_CAPTURE(add_forces, brick, brick, forces)->Apply(beam_only);
BENCHMARK_CAPTURE(add_forces, brick_bound, brick, bound)->Apply(sizes);
BENCHMARK_CAPTURE(add_forces, brick_bound_energy, brick, bound | energy)->Apply(beam_only);
BENCHMARK_CAPTURE(add_forces, brick_gauss_bound, brick, gauss_bound)->Apply(beam_only);
BENCHMARK_CAPTURE(add_forces, brick_virial, brick, bound | virial)->Apply(beam_only);
BENCHMARK_CAPTURE(add_forces, plain_brick, plain_brick, forces)->Apply(beam_only);
BENCHMARK_CAPTURE(add_forces, lagrangian, lagrangian, forces)->Apply(beam_only);
BENCHMARK_CAPTURE(add_forces, enhanced, enhanced, forces)->Apply(beam_only);
BENCHMARK_CAPTURE(add_forces, enhanced_bound, enhanced, bound)->Apply(sizes);
BENCHMARK_CAPTURE(add_forces, enhanced_bound_energy, enhanced, bound | energy)->Apply(beam_only);
BENCHMARK_CAPTURE(add_forces, enhanced_gauss_bound, enhanced, gauss_bound)->Apply(beam_only);
BENCHMARK_CAPTURE(add_forces, lagrangian_bound, lagrangian, bound)->Apply(sizes);
BENCHMARK_CAPTURE(add_forces, lagrangian_bound_energy, lagrangian, bound | energy)
    ->Apply(beam_only);
BENCHMARK_CAPTURE(add_forces, lagrangian_gauss_bound, lagrangian, gauss_bound)->Apply(beam_only);

// Bare loops: gather, constant K times u, scatter, `width` elements at a time. What they add to
// nothing is bound by the gather and the scatter alone; the kernels add rotation and criterion.
enum BareLoop { gather_scatter, dense_K, brick_K };

template <BareLoop loop> void bare(benchmark::State &state)
{
  constexpr int W = simd::width;
  using simd::Pack;
  Block block = block_of(state.range(0));
  std::vector<double> u(block.x.size());
  for (size_t i = 0; i < u.size(); ++i) u[i] = block.x[i] - block.X[i];

  // K of the nodes, and its eight 3 x 3 blocks on modes: component c of mode m is in block m xor 2^c
  const Eigen::Matrix<double, 24, 24> K = stiffness(block.shape(0), glass);
  alignas(64) double dense[24][24], blocks[8][3][3];
  for (int i = 0; i < 24; ++i)
    for (int j = 0; j < 24; ++j) dense[i][j] = K(i, j);
  for (int b = 0; b < 8; ++b)
    for (int i = 0; i < 3; ++i)
      for (int j = 0; j < 3; ++j) {
        double sum = 0.0;
        for (int a = 0; a < 8; ++a)
          for (int c = 0; c < 8; ++c)
            sum += hex_mode(b ^ (1 << i), a) * hex_mode(b ^ (1 << j), c) * K(3 * a + i, 3 * c + j);
        blocks[b][i][j] = sum / 64.0;
      }

  const int n = static_cast<int>(block.hexes.size());
  const int(*const nodes)[8] = block.nodes();
  for (auto _ : state) {
    for (int first = 0; first < n; first += W) {
      const LaneElements elements{nodes + first, n - first < W ? n - first : W};
      if constexpr (loop == dense_K) {
        Pack v[24];
        for (int a = 0; a < 8; ++a) {
          const double *of_lane[W];
          for (int l = 0; l < W; ++l)
            of_lane[l] = entry(u.data(), elements.nodes[elements.index(l)][a]);
          for (int i = 0; i < 3; ++i)
            v[3 * a + i] = simd::generate([&](int l) {
              return of_lane[l][i];
            });
        }
        for (int a = 0; a < 8; ++a) {
          Pack f[3] = {};
          for (int j = 0; j < 24; ++j)
            for (int i = 0; i < 3; ++i) f[i] -= dense[3 * a + i][j] * v[j];
          for (int l = 0; l < elements.valid; ++l) {
            double *node = entry(block.f.data(), nodes[first + l][a]);
            for (int i = 0; i < 3; ++i) node[i] += f[i][l];
          }
        }
      } else {
        Pack v[3][8], p[3][8] = {};
        gather_modes(elements, u.data(), v);
        for (int b = 0; b < 8; ++b)
          for (int i = 0; i < 3; ++i) {
            const int mi = b ^ (1 << i);
            if constexpr (loop == gather_scatter) {
              p[i][mi] = v[i][mi];
            } else {
              if (mi == 0) continue;    // nodes_to_modes() leaves the mean out
              for (int j = 0; j < 3; ++j)
                if ((b ^ (1 << j)) != 0) p[i][mi] -= blocks[b][i][j] * v[j][b ^ (1 << j)];
            }
          }
        scatter_modes(elements, p, block.f.data());
      }
    }
    benchmark::ClobberMemory();
  }
  state.SetItemsProcessed(state.iterations() * n);
}
BENCHMARK_TEMPLATE(bare, gather_scatter)->Apply(beam_only);
BENCHMARK_TEMPLATE(bare, dense_K)->Apply(beam_only);
BENCHMARK_TEMPLATE(bare, brick_K)->Apply(sizes);
BENCHMARK_CAPTURE(add_forces, mooney, mooney, forces)->Apply(beam_only);
BENCHMARK_CAPTURE(add_forces, prony, prony, forces)->Apply(beam_only);
BENCHMARK_CAPTURE(add_forces, prony_dissipation, prony, dissipation)->Apply(beam_only);
BENCHMARK_CAPTURE(add_forces, prony_energy, prony, energy)->Apply(beam_only);

// per distinct element shape, once per run
void frequency(benchmark::State &state)
{
  const HexCoords X = block_of(1).shape(0);
  for (auto _ : state) benchmark::DoNotOptimize(max_frequency(X, glass));
}
BENCHMARK(frequency)->Unit(benchmark::kMicrosecond);

}    // namespace
