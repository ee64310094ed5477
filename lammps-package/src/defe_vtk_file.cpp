/* ----------------------------------------------------------------------
   DEFE: adaptive finite elements to bonded discrete elements for LAMMPS
   https://www.lammps.org/
   This software is distributed under the GNU General Public License.
------------------------------------------------------------------------- */

#include "defe_vtk_file.h"

#include <functional>

bool LAMMPS_NS::VtkWritten::has(const std::string &path, std::string_view data) const
{
  const auto found = sets.find(path);
  return found != sets.end() && found->second.size == data.size() &&
      found->second.hash == std::hash<std::string_view>()(data);
}

void LAMMPS_NS::VtkWritten::keep(const std::string &path, std::string_view data,
                                 const std::string &file)
{
  sets[path] = {data.size(), std::hash<std::string_view>()(data), file};
}

#ifndef DEFE_WITH_HDF5

const char *LAMMPS_NS::vtk_files_need()
{
  return DEFE_HDF5_PACKAGE;
}

std::string LAMMPS_NS::write_vtk_file(const std::string &, const defe::VtkGrid &, VtkWritten &,
                                      MPI_Comm)
{
  return "this build has no HDF5";
}

#else

#include <hdf5.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <cstdint>
#include <cstdio>
#include <cstring>
#include <deque>
#include <filesystem>
#include <system_error>
#include <utility>
#include <vector>

using defe::VtkField;
using defe::VtkGrid;
using LAMMPS_NS::VtkWritten;

namespace {

/** A handle of HDF5 with what closes it. */
class Handle {
 public:
  Handle(hid_t id, herr_t (*close)(hid_t)) : id(id), close(close) {}
  ~Handle()
  {
    if (id >= 0) close(id);
  }
  Handle(const Handle &) = delete;
  Handle &operator=(const Handle &) = delete;
  operator hid_t() const { return id; }
  /** False: what was written may not have come to the disk. */
  bool finish()
  {
    const bool good = id >= 0 && close(id) >= 0;
    id = -1;
    return good;
  }

 private:
  hid_t id;
  herr_t (*close)(hid_t);
};

/** HDF5 prints a stack of its errors by itself: the caller says in one line what is wrong. */
class Quiet {
 public:
  Quiet()
  {
    H5Eget_auto2(H5E_DEFAULT, &function, &data);
    H5Eset_auto2(H5E_DEFAULT, nullptr, nullptr);
  }
  ~Quiet() { H5Eset_auto2(H5E_DEFAULT, function, data); }

 private:
  H5E_auto2_t function;
  void *data;
};

bool all_good(bool good, MPI_Comm comm)
{
  int mine = good, all;
  MPI_Allreduce(&mine, &all, 1, MPI_INT, MPI_MIN, comm);
  return all;
}

/** Rows of a data set: of this rank, of the ranks before it, and of all. */
struct Rows {
  hsize_t mine, before, all;
};

template <std::size_t N>
std::array<Rows, N> rows_of(const std::array<std::size_t, N> &mine, MPI_Comm comm)
{
  std::array<unsigned long long, N> n, before = {}, all;
  int me;
  MPI_Comm_rank(comm, &me);
  std::copy(mine.begin(), mine.end(), n.begin());
  MPI_Exscan(n.data(), before.data(), N, MPI_UNSIGNED_LONG_LONG, MPI_SUM, comm);
  if (me == 0) before.fill(0);    // MPI leaves it undefined there
  MPI_Allreduce(n.data(), all.data(), N, MPI_UNSIGNED_LONG_LONG, MPI_SUM, comm);
  std::array<Rows, N> result;
  for (std::size_t k = 0; k < N; k++) result[k] = {n[k], before[k], all[k]};
  return result;
}

/** A data set, with what this rank has of it. */
struct DataSet {
  std::string path;    // in the group VTKHDF
  Rows rows;
  int columns;
  hid_t in_file, in_memory;
  std::string_view mine;
  bool referred = false;    // to an earlier file

  std::size_t bytes() const { return referred ? 0 : mine.size(); }
};

bool fit_32_bits(const std::vector<std::int64_t> &values)
{
  return std::all_of(values.begin(), values.end(), [](std::int64_t v) {
    return v == static_cast<std::int32_t>(v);
  });
}

/** All data sets of a grid. One partition for all ranks: points at the borders of ranks are shared, and the file does
    not tell how many ranks wrote it. */
class Contents {
 public:
  Contents(const VtkGrid &g, const VtkWritten &written, MPI_Comm comm)
  {
    int me;
    MPI_Comm_rank(comm, &me);
    const auto size = rows_of<4>(
        {g.npoints(), g.ncells(), g.connectivity.size(), g.ncells() + (me == 0 ? 1 : 0)}, comm);
    points = size[0], cells = size[1], corners = size[2];
    add("Points", points, 3, H5T_IEEE_F64LE, H5T_NATIVE_DOUBLE, g.points);
    add("Types", cells, 1, H5T_STD_U8LE, H5T_NATIVE_UCHAR, g.types);
    std::vector<std::int64_t> offsets;    // where cells begin, and the end of the last
    if (me == 0) offsets.push_back(0);
    for (auto end : g.ends) offsets.push_back(static_cast<std::int64_t>(corners.before) + end);
    // VTK wants one type for both
    const bool large = static_cast<std::int64_t>(std::max(points.all, corners.all)) > INT32_MAX;
    const hid_t index = large ? H5T_STD_I64LE : H5T_STD_I32LE;
    add("Offsets", size[3], 1, index, H5T_NATIVE_INT64, own(std::move(offsets)));
    add("Connectivity", corners, 1, index, H5T_NATIVE_INT64, g.connectivity);
    for (const auto &f : g.point_fields) add(f, "PointData/", points);
    for (const auto &f : g.cell_fields) add(f, "CellData/", cells);

    // what is so on all ranks: values are small, values are the old ones
    const auto n = sets.size();
    std::vector<int> flags(2 * n), all(2 * n);
    for (std::size_t k = 0; k < n; k++) {
      flags[k] = small[k];
      flags[n + k] = written.has(sets[k].path, sets[k].mine);
    }
    MPI_Allreduce(flags.data(), all.data(), static_cast<int>(2 * n), MPI_INT, MPI_MIN, comm);
    for (std::size_t k = 0; k < n; k++) {
      if (all[k]) sets[k].in_file = H5T_STD_I32LE;
      sets[k].referred = all[n + k] && sets[k].rows.all > 0;
    }
  }
  Contents(const Contents &) = delete;
  Contents &operator=(const Contents &) = delete;

  Rows points, cells, corners;
  const std::vector<DataSet> &data_sets() const { return sets; }

  unsigned long long bytes() const
  {
    unsigned long long sum = 0;
    for (const auto &s : sets) sum += s.bytes();
    return sum;
  }

 private:
  std::vector<DataSet> sets;
  std::vector<char> small;    // of each: whole numbers that this rank can write with 32 bits
  std::deque<std::vector<std::int64_t>> owned;

  const std::vector<std::int64_t> &own(std::vector<std::int64_t> &&values)
  {
    owned.push_back(std::move(values));
    return owned.back();
  }
  template <class T>
  void add(const std::string &path, const Rows &rows, int columns, hid_t in_file, hid_t in_memory,
           const std::vector<T> &values, bool is_small = false)
  {
    sets.push_back({path,
                    rows,
                    columns,
                    in_file,
                    in_memory,
                    {reinterpret_cast<const char *>(values.data()), values.size() * sizeof(T)}});
    small.push_back(is_small);
  }
  void add(const VtkField &f, const std::string &folder, const Rows &rows)
  {
    if (!f.whole) {
      add(folder + f.name, rows, f.components, H5T_IEEE_F64LE, H5T_NATIVE_DOUBLE, f.values);
      return;
    }
    const auto &whole = own({f.values.begin(), f.values.end()});
    add(folder + f.name, rows, f.components, H5T_STD_I64LE, H5T_NATIVE_INT64, whole,
        fit_32_bits(whole));
  }
};

/** The open file, into which each rank writes its rows of the data sets. */
class Writer {
 public:
  Writer(hid_t group, MPI_Comm comm) : group(group) { MPI_Comm_rank(comm, &me); }

  bool good() const { return good_; }
  void check(bool ok) { good_ = good_ && ok; }

  void grid(const Contents &c, const VtkWritten &written)
  {
    total("NumberOfPoints", c.points.all);
    total("NumberOfCells", c.cells.all);
    total("NumberOfConnectivityIds", c.corners.all);
    for (const char *name : {"PointData", "CellData"}) {
      const Handle folder(H5Gcreate2(group, name, H5P_DEFAULT, H5P_DEFAULT, H5P_DEFAULT), H5Gclose);
      check(folder >= 0);
    }
    for (const auto &s : c.data_sets())
      if (s.referred)
        check(H5Lcreate_external(written.file_of(s.path).c_str(), ("/VTKHDF/" + s.path).c_str(),
                                 group, s.path.c_str(), H5P_DEFAULT, H5P_DEFAULT) >= 0);
      else
        data_set(s);
  }

 private:
  hid_t group;
  int me;
  bool good_ = true;

  /** The rows of all ranks, one rank's after the other's: each rank writes one piece of the file, for which no
      messages are needed. All ranks call it, since a data set is made by all. */
  void data_set(const DataSet &s)
  {
    const int dims = s.columns > 1 ? 2 : 1;
    const auto width = static_cast<hsize_t>(s.columns);
    const Rows &r = s.rows;
    const hsize_t all[2] = {r.all, width}, count[2] = {r.mine, width}, start[2] = {r.before, 0};
    const Handle space(H5Screate_simple(dims, all, nullptr), H5Sclose);
    const Handle set(
        H5Dcreate2(group, s.path.c_str(), s.in_file, space, H5P_DEFAULT, H5P_DEFAULT, H5P_DEFAULT),
        H5Dclose);
    check(set >= 0);
    if (r.mine == 0) return;
    const Handle memory(H5Screate_simple(dims, count, nullptr), H5Sclose);
    H5Sselect_hyperslab(space, H5S_SELECT_SET, start, nullptr, count, nullptr);
    check(H5Dwrite(set, s.in_memory, memory, space, H5P_DEFAULT, s.mine.data()) >= 0);
  }

  /** One number, which is known to all. */
  void total(const char *name, hsize_t number)
  {
    const auto value = static_cast<std::int64_t>(number);
    data_set({name,
              {me == 0 ? 1u : 0u, me == 0 ? 0u : 1u, 1u},
              1,
              H5T_STD_I64LE,
              H5T_NATIVE_INT64,
              {reinterpret_cast<const char *>(&value), sizeof(value)}});
  }
};

/** The head that names format and type. */
bool write_head(hid_t group)
{
  const int version[2] = {1, 0};
  const hsize_t two = 2;
  const Handle pair(H5Screate_simple(1, &two, nullptr), H5Sclose);
  const Handle v(H5Acreate2(group, "Version", H5T_STD_I32LE, pair, H5P_DEFAULT, H5P_DEFAULT),
                 H5Aclose);
  const char type[] = "UnstructuredGrid";
  const Handle text(H5Tcopy(H5T_C_S1), H5Tclose);
  H5Tset_size(text, sizeof(type) - 1);
  H5Tset_strpad(text, H5T_STR_NULLPAD);
  const Handle scalar(H5Screate(H5S_SCALAR), H5Sclose);
  const Handle t(H5Acreate2(group, "Type", text, scalar, H5P_DEFAULT, H5P_DEFAULT), H5Aclose);
  return H5Awrite(v, H5T_NATIVE_INT, version) >= 0 && H5Awrite(t, text, type) >= 0;
}

/** Too little room is an error before anything is written: HDF5 cannot close a file that it could not write, and
    crashes at the end of the program. */
bool has_room(const std::string &file, unsigned long long bytes)
{
  namespace fs = std::filesystem;
  constexpr unsigned long long heads = 1 << 16;    // more than those of groups and data sets take
  std::error_code error, none;
  const fs::path folder = fs::path(file).parent_path();
  const auto space = fs::space(folder.empty() ? "." : folder, error);
  if (error || space.capacity == 0) return true;    // the system does not say
  const auto replaced = fs::is_regular_file(file, none) ? fs::file_size(file, none) : 0;
  return space.available + (none ? 0 : replaced) >= bytes + heads;
}

/** Why a file cannot be made, as the system says it: HDF5 does not. */
std::string try_file(const std::string &file, unsigned long long mine, MPI_Comm comm)
{
  unsigned long long all = 0;
  int me, failure = 0;
  MPI_Comm_rank(comm, &me);
  MPI_Reduce(&mine, &all, 1, MPI_UNSIGNED_LONG_LONG, MPI_SUM, 0, comm);
  if (me == 0) {
    if (!has_room(file, all))
      failure = ENOSPC;
    else {
      FILE *out = std::fopen(file.c_str(), "wb");
      if (!out || std::fclose(out)) failure = errno;
    }
  }
  MPI_Bcast(&failure, 1, MPI_INT, 0, comm);
  return failure ? std::strerror(failure) : "";
}

}    // namespace

const char *LAMMPS_NS::vtk_files_need()
{
  return nullptr;
}

std::string LAMMPS_NS::write_vtk_file(const std::string &file, const VtkGrid &g,
                                      VtkWritten &written, MPI_Comm comm)
{
  const Contents contents(g, written, comm);
  const std::string complaint = try_file(file, contents.bytes(), comm);
  if (!complaint.empty()) return "cannot write " + file + ": " + complaint;
  const Quiet quiet;
  const Handle access(H5Pcreate(H5P_FILE_ACCESS), H5Pclose);
  H5Pset_fapl_mpio(access, comm, MPI_INFO_NULL);
  Handle out(H5Fcreate(file.c_str(), H5F_ACC_TRUNC, H5P_DEFAULT, access), H5Fclose);
  if (!all_good(out >= 0, comm)) return "cannot write " + file + " by HDF5";
  bool good;
  {
    const Handle group(H5Gcreate2(out, "VTKHDF", H5P_DEFAULT, H5P_DEFAULT, H5P_DEFAULT), H5Gclose);
    Writer writer(group, comm);
    writer.check(write_head(group));
    writer.grid(contents, written);
    good = writer.good();
  }
  good = out.finish() && good;
  if (!all_good(good, comm)) return "cannot write all of " + file + ": is the disk full?";
  // a link without a folder is looked for beside the file that has it
  const std::string name = std::filesystem::path(file).filename();
  for (const auto &s : contents.data_sets())
    if (!s.referred) written.keep(s.path, s.mine, name);
  return "";
}

#endif
