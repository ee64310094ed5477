#ifndef DEFE_TEST_LAMMPS_RUN_H
#define DEFE_TEST_LAMMPS_RUN_H

// LAMMPS in a test: starting it quietly, giving it commands, and getting at what it computed.
//
// Everything here is collective: all ranks of the communicator call it, and all get the same
// answer. With the environment variable DEFE_TEST_LOG set, each LAMMPS writes log.SUITE.TEST.N.

#include "defe/coupling/ledger.h"
#include "defe/types.h"

#include "atom.h"
#include "compute.h"
#include "domain.h"
#include "exceptions.h"
#include "fix.h"
#include "input.h"
#include "lammps.h"
#include "modify.h"
#include "update.h"
#include "variable.h"

#include <gtest/gtest.h>
#include <mpi.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <map>
#include <memory>
#include <sstream>
#include <stdexcept>
#include <string>
#include <vector>

namespace defe::test {

using LAMMPS_NS::bigint;
using LAMMPS_NS::tagint;

/// Entries of fix defe's vector, from 0: entry k is f_fe[k + 1] of an input script.
using namespace defe::entries;

/// A node or a DE. x is unwrapped.
struct Particle {
  tagint tag;
  int type;
  double radius, mass;
  Vec3 x, v, f, omega, torque;
};
using Particles = std::map<tagint, Particle>;

/// Numbers in a command must come back as they were.
inline std::string number(double a)
{
  char text[40];
  std::snprintf(text, sizeof text, "%.17g", a);
  return text;
}

inline int rank_of(MPI_Comm comm)
{
  int rank;
  MPI_Comm_rank(comm, &rank);
  return rank;
}

inline int size_of(MPI_Comm comm)
{
  int size;
  MPI_Comm_size(comm, &size);
  return size;
}

/// What a script begins with.
inline std::string script_head(const std::string &boundary = "f f f")
{
  return "units si\natom_style sphere\nnewton off on\ncomm_modify vel yes\nboundary " + boundary +
      "\n";
}

/// Rank 0 removes a file that an earlier run of the test may have left.
inline void remove_file(const std::string &file, MPI_Comm comm = MPI_COMM_WORLD)
{
  if (rank_of(comm) == 0) std::remove(file.c_str());
  MPI_Barrier(comm);
}

class Lammps {
 public:
  explicit Lammps(MPI_Comm comm = MPI_COMM_WORLD, const std::string &plugin = DEFE_PLUGIN_PATH) :
      comm(comm)
  {
    std::string log = "none";
    if (std::getenv("DEFE_TEST_LOG")) {
      static int count = 0;
      const auto *test = testing::UnitTest::GetInstance()->current_test_info();
      log = std::string("log.") + test->test_suite_name() + "." + test->name() + "." +
          std::to_string(++count);
      std::replace(log.begin(), log.end(), '/', '_');
    }
    std::vector<std::string> arguments = {"test", "-screen", "none", "-log", log, "-nocite"};
    std::vector<char *> pointers;
    for (auto &a : arguments) pointers.push_back(a.data());
    lmp = std::make_unique<LAMMPS_NS::LAMMPS>(static_cast<int>(pointers.size()), pointers.data(),
                                              comm);
    command("plugin load " + plugin);
  }

  /// Lines of an input script; '&' at the end of a line continues it.
  Lammps &commands(const std::string &script)
  {
    std::istringstream in(script);
    std::string line, whole;
    while (std::getline(in, line)) {
      const auto last = line.find_last_not_of(" \t");
      if (last == std::string::npos) continue;
      if (line[last] == '&') {
        whole += line.substr(0, last) + " ";
        continue;
      }
      command(whole + line);
      whole.clear();
    }
    return *this;
  }

  void command(const std::string &line) { lmp->input->one(line); }

  void run(bigint steps) { command("run " + std::to_string(steps)); }

  LAMMPS_NS::LAMMPS *operator->() { return lmp.get(); }

  bigint step() const { return lmp->update->ntimestep; }
  bigint natoms() const { return lmp->atom->natoms; }

  double fe(Entry entry)
  {
    auto *fix = lmp->modify->get_fix_by_id("fe");
    if (!fix) throw std::runtime_error("no fix fe");
    return fix->compute_vector(entry);
  }

  /// Value of a formula in LAMMPS' own notation.
  double value(const std::string &formula) { return lmp->input->variable->compute_equal(formula); }

  /// Record equal-style formulas ("c_1", "f_fe[3]/2", ...) every `every` steps of the runs that
  /// follow, the first step included.
  void record(const std::vector<std::string> &formulas, int every)
  {
    std::string list;
    for (size_t k = 0; k < formulas.size(); k++) {
      const std::string name = "recorded" + std::to_string(k);
      command("variable " + name + " equal \"" + formulas[k] + "\"");
      list += " v_" + name;
    }
    command("fix recorder all vector " + std::to_string(every) + list);
  }

  /// The record of value k.
  std::vector<double> recorded(int k = 0)
  {
    auto *fix = lmp->modify->get_fix_by_id("recorder");
    std::vector<double> result;
    if (fix->array_flag)
      for (int i = 0; i < fix->size_array_rows; i++) result.push_back(fix->compute_array(i, k));
    else
      for (int i = 0; i < fix->size_vector; i++) result.push_back(fix->compute_vector(i));
    return result;
  }

  /// All nodes and DEs, by ID.
  Particles particles()
  {
    const auto *atom = lmp->atom;
    std::vector<Particle> mine;
    for (int i = 0; i < atom->nlocal; i++) {
      Particle p;
      p.tag = atom->tag[i];
      p.type = atom->type[i];
      p.radius = atom->radius[i];
      p.mass = atom->rmass[i];
      double x[3];
      lmp->domain->unmap(atom->x[i], atom->image[i], x);
      p.x = Vec3(x[0], x[1], x[2]);
      p.v = Vec3(atom->v[i][0], atom->v[i][1], atom->v[i][2]);
      p.f = Vec3(atom->f[i][0], atom->f[i][1], atom->f[i][2]);
      p.omega = Vec3(atom->omega[i][0], atom->omega[i][1], atom->omega[i][2]);
      p.torque = Vec3(atom->torque[i][0], atom->torque[i][1], atom->torque[i][2]);
      mine.push_back(p);
    }
    Particles result;
    for (const auto &p : gather(mine))
      if (!result.emplace(p.tag, p).second)
        throw std::runtime_error("atom ID " + std::to_string(p.tag) + " exists twice");
    return result;
  }

  /// A column of a per-atom compute, by atom ID; column 0 = its only one.
  std::map<tagint, double> per_atom(const std::string &id, int column = 0)
  {
    auto *compute = lmp->modify->get_compute_by_id(id);
    if (!compute) throw std::runtime_error("no compute " + id);
    compute->compute_peratom();
    std::vector<double> mine;
    for (int i = 0; i < lmp->atom->nlocal; i++) {
      mine.push_back(static_cast<double>(lmp->atom->tag[i]));
      mine.push_back(column ? compute->array_atom[i][column - 1] : compute->vector_atom[i]);
    }
    std::map<tagint, double> result;
    const auto all = gather(mine);
    for (size_t k = 0; k < all.size(); k += 2) result[static_cast<tagint>(all[k])] = all[k + 1];
    return result;
  }

  /// The rows of a local compute, of all ranks.
  std::vector<std::vector<double>> local(const std::string &id)
  {
    auto *compute = lmp->modify->get_compute_by_id(id);
    if (!compute) throw std::runtime_error("no compute " + id);
    compute->compute_local();
    const int columns = std::max(1, compute->size_local_cols);
    std::vector<double> mine;
    for (int i = 0; i < compute->size_local_rows; i++)
      for (int k = 0; k < columns; k++)
        mine.push_back(compute->size_local_cols ? compute->array_local[i][k]
                                                : compute->vector_local[i]);
    const auto all = gather(mine);
    std::vector<std::vector<double>> rows;
    for (size_t k = 0; k < all.size(); k += columns)
      rows.emplace_back(all.begin() + k, all.begin() + k + columns);
    return rows;
  }

  /// Set positions and velocities of all particles: change(Particle &) may alter x and v.
  template <class Change> void change(const Change &change_one)
  {
    auto *atom = lmp->atom;
    for (int i = 0; i < atom->nlocal; i++) {
      Particle p;
      p.tag = atom->tag[i];
      p.type = atom->type[i];
      p.radius = atom->radius[i];
      p.mass = atom->rmass[i];
      p.x = Vec3(atom->x[i][0], atom->x[i][1], atom->x[i][2]);
      p.v = Vec3(atom->v[i][0], atom->v[i][1], atom->v[i][2]);
      p.omega = Vec3(atom->omega[i][0], atom->omega[i][1], atom->omega[i][2]);
      change_one(p);
      for (int k = 0; k < 3; k++) {
        atom->x[i][k] = p.x[k];
        atom->v[i][k] = p.v[k];
        atom->omega[i][k] = p.omega[k];
      }
    }
  }

  /// What each rank has, of all ranks, in the order of the ranks. T: plain data.
  template <class T> std::vector<T> gather(const std::vector<T> &mine) const
  {
    const int nprocs = size_of(comm), bytes = static_cast<int>(mine.size() * sizeof(T));
    std::vector<int> count(nprocs), offset(nprocs, 0);
    MPI_Allgather(&bytes, 1, MPI_INT, count.data(), 1, MPI_INT, comm);
    for (int p = 1; p < nprocs; p++) offset[p] = offset[p - 1] + count[p - 1];
    std::vector<T> all((offset.back() + count.back()) / sizeof(T));
    MPI_Allgatherv(mine.data(), bytes, MPI_BYTE, all.data(), count.data(), offset.data(), MPI_BYTE,
                   comm);
    return all;
  }

 private:
  MPI_Comm comm;
  std::unique_ptr<LAMMPS_NS::LAMMPS> lmp;
};

// ---- sums over particles ----

inline double total_mass(const Particles &all)
{
  double m = 0.0;
  for (const auto &p : all) m += p.second.mass;
  return m;
}

inline Vec3 momentum(const Particles &all)
{
  Vec3 sum = Vec3::Zero();
  for (const auto &p : all) sum += p.second.mass * p.second.v;
  return sum;
}

inline Vec3 centre_of_mass(const Particles &all)
{
  Vec3 sum = Vec3::Zero();
  for (const auto &p : all) sum += p.second.mass * p.second.x;
  return sum / total_mass(all);
}

/// About a fixed point, with the spins of the DEs (solid spheres).
inline Vec3 angular_momentum(const Particles &all, const Vec3 &about = Vec3::Zero())
{
  Vec3 sum = Vec3::Zero();
  for (const auto &it : all) {
    const auto &p = it.second;
    sum += p.mass * (p.x - about).cross(p.v) + 0.4 * p.mass * p.radius * p.radius * p.omega;
  }
  return sum;
}

inline double kinetic_energy(const Particles &all)
{
  double sum = 0.0;
  for (const auto &it : all) {
    const auto &p = it.second;
    sum += 0.5 * p.mass * (p.v.squaredNorm() + 0.4 * p.radius * p.radius * p.omega.squaredNorm());
  }
  return sum;
}

/// Sum of |f|^2/m. The velocity Verlet integrator keeps, in a linear system, exactly
/// E - dt^2/8 times this, where E = kinetic + potential energy at full steps: E itself swings with
/// the potential energy by (omega dt)^2/4.
inline double force_term(const Particles &all)
{
  double sum = 0.0;
  for (const auto &p : all) sum += p.second.f.squaredNorm() / p.second.mass;
  return sum;
}

/// First crossing of zero by a record of equidistant values, from `start` on, in units of its
/// interval; throws if there is none.
inline double zero_crossing(const std::vector<double> &a, double start = 0.0)
{
  for (size_t i = std::max<size_t>(1, static_cast<size_t>(std::ceil(start)) + 1); i < a.size(); i++)
    if (a[i - 1] != 0.0 && a[i - 1] * a[i] <= 0.0)
      return static_cast<double>(i - 1) + a[i - 1] / (a[i - 1] - a[i]);
  throw std::runtime_error("the record does not cross zero");
}

/// Let rank 0 do something with a LAMMPS of its own (MPI_COMM_SELF); all ranks get its particles.
template <class Do> Particles on_one_rank(const Do &something)
{
  std::vector<Particle> list;
  int n = -1;
  std::string failure;
  if (rank_of(MPI_COMM_WORLD) == 0) {
    try {
      for (const auto &p : something()) list.push_back(p.second);
      n = static_cast<int>(list.size());
    } catch (std::exception &e) {
      failure = e.what();
    }
  }
  MPI_Bcast(&n, 1, MPI_INT, 0, MPI_COMM_WORLD);
  if (n < 0) throw std::runtime_error("on one rank: " + failure);
  list.resize(n);
  MPI_Bcast(list.data(), static_cast<int>(n * sizeof(Particle)), MPI_BYTE, 0, MPI_COMM_WORLD);
  Particles result;
  for (const auto &p : list) result.emplace(p.tag, p);
  return result;
}

/// Do something on the first n ranks; the others wait.
template <class Do> void on_ranks(int n, const Do &something)
{
  MPI_Comm comm;
  const int rank = rank_of(MPI_COMM_WORLD);
  MPI_Comm_split(MPI_COMM_WORLD, rank < n ? 0 : MPI_UNDEFINED, rank, &comm);
  if (rank < n) {
    something(comm);
    MPI_Comm_free(&comm);
  }
  MPI_Barrier(MPI_COMM_WORLD);
}

/// Number of ranks that write a restart file, and that read it.
inline std::vector<std::pair<int, int>> changes_of_ranks()
{
  switch (size_of(MPI_COMM_WORLD)) {
    case 1:
      return {{1, 1}};
    case 2:
      return {{2, 2}, {1, 2}, {2, 1}};
  }
  return {{4, 4}, {1, 4}, {4, 1}, {3, 2}, {2, 4}};
}

/// Largest difference of a vector of the particles (member pointer) between two states.
inline double difference(const Particles &a, const Particles &b, Vec3 Particle::*what)
{
  double largest = 0.0;
  for (const auto &p : a) {
    const auto other = b.find(p.first);
    if (other == b.end() || a.size() != b.size()) {
      ADD_FAILURE() << a.size() << " and " << b.size() << " atoms; atom " << p.first
                    << " is missing";
      return 1e300;
    }
    largest = std::max(largest, (p.second.*what - other->second.*what).norm());
  }
  return largest;
}

/// What rounding grows to: the largest differences of positions and velocities to four runs that begin with a rounding of
/// their own, start(1) to start(4).
struct Grown {
  double x = 0.0, v = 0.0;
};

template <class Start> Grown grown_rounding(const Particles &as_it_is, const Start &start)
{
  Grown most;
  for (unsigned k = 1; k <= 4; k++) {
    const Particles other = start(k);
    most.x = std::max(most.x, difference(as_it_is, other, &Particle::x));
    most.v = std::max(most.v, difference(as_it_is, other, &Particle::v));
  }
  return most;
}

inline double largest(const Particles &a, Vec3 Particle::*what)
{
  double size = 0.0;
  for (const auto &p : a) size = std::max(size, (p.second.*what).norm());
  return size;
}

inline double largest_deviation(const std::vector<double> &a)
{
  double d = 0.0;
  for (double v : a) d = std::max(d, std::abs(v - a.front()));
  return d;
}

}    // namespace defe::test

#endif
