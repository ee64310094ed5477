/* ----------------------------------------------------------------------
   DEFE: adaptive finite elements to bonded discrete elements for LAMMPS
   https://www.lammps.org/
   This software is distributed under the GNU General Public License.
------------------------------------------------------------------------- */

#include "defe_vtk_file.h"

#ifndef DEFE_WITH_HDF5

const char *LAMMPS_NS::vtk_files_need()
{
  return DEFE_HDF5_PACKAGE;
}

std::string LAMMPS_NS::write_vtk_file(const std::string &, const defe::VtkGrid &, MPI_Comm)
{
  return "this build has no HDF5";
}

#else

#include <hdf5.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <cstdio>
#include <cstring>
#include <filesystem>
#include <system_error>
#include <vector>

using defe::VtkField;
using defe::VtkGrid;

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

/** The open file, into which each rank writes its rows of the data sets. */
class Writer {
 public:
  Writer(hid_t group, MPI_Comm comm) : group(group), comm(comm) { MPI_Comm_rank(comm, &me); }

  bool good() const { return good_; }
  void check(bool ok) { good_ = good_ && ok; }

  /** Rows of the ranks before this one, and of all. */
  struct Rows {
    hsize_t mine, before, all;
  };
  template <std::size_t N> std::array<Rows, N> rows(const std::array<std::size_t, N> &mine) const
  {
    std::array<unsigned long long, N> n, before = {}, all;
    std::copy(mine.begin(), mine.end(), n.begin());
    MPI_Exscan(n.data(), before.data(), N, MPI_UNSIGNED_LONG_LONG, MPI_SUM, comm);
    if (me == 0) before.fill(0);    // MPI leaves it undefined there
    MPI_Allreduce(n.data(), all.data(), N, MPI_UNSIGNED_LONG_LONG, MPI_SUM, comm);
    std::array<Rows, N> result;
    for (std::size_t k = 0; k < N; k++) result[k] = {n[k], before[k], all[k]};
    return result;
  }

  /** The rows of all ranks, one rank's after the other's: each rank writes one piece of the file, for which no
      messages are needed. All ranks call it, since a data set is made by all. */
  void data_set(const char *name, const Rows &r, int columns, hid_t in_file, hid_t in_memory,
                const void *mine, hid_t where)
  {
    const int dims = columns > 1 ? 2 : 1;
    const auto width = static_cast<hsize_t>(columns);
    const hsize_t all[2] = {r.all, width}, count[2] = {r.mine, width}, start[2] = {r.before, 0};
    const Handle space(H5Screate_simple(dims, all, nullptr), H5Sclose);
    const Handle set(H5Dcreate2(where, name, in_file, space, H5P_DEFAULT, H5P_DEFAULT, H5P_DEFAULT),
                     H5Dclose);
    check(set >= 0);
    if (r.mine == 0) return;
    const Handle memory(H5Screate_simple(dims, count, nullptr), H5Sclose);
    H5Sselect_hyperslab(space, H5S_SELECT_SET, start, nullptr, count, nullptr);
    check(H5Dwrite(set, in_memory, memory, space, H5P_DEFAULT, mine) >= 0);
  }

  void integers(const char *name, const Rows &r, const std::vector<std::int64_t> &mine)
  {
    data_set(name, r, 1, H5T_STD_I64LE, H5T_NATIVE_INT64, mine.data(), group);
  }

  /** One number, which is known to all. */
  void total(const char *name, hsize_t number)
  {
    const auto value = static_cast<std::int64_t>(number);
    data_set(name, {me == 0 ? 1u : 0u, me == 0 ? 0u : 1u, 1u}, 1, H5T_STD_I64LE, H5T_NATIVE_INT64,
             &value, group);
  }

  void fields(const char *name, const Rows &r, const std::vector<VtkField> &list)
  {
    const Handle folder(H5Gcreate2(group, name, H5P_DEFAULT, H5P_DEFAULT, H5P_DEFAULT), H5Gclose);
    check(folder >= 0);
    for (const auto &f : list) {
      if (!f.whole) {
        data_set(f.name.c_str(), r, f.components, H5T_IEEE_F64LE, H5T_NATIVE_DOUBLE,
                 f.values.data(), folder);
        continue;
      }
      const std::vector<std::int64_t> whole(f.values.begin(), f.values.end());
      data_set(f.name.c_str(), r, f.components, H5T_STD_I64LE, H5T_NATIVE_INT64, whole.data(),
               folder);
    }
  }

  /** One partition for all ranks: points at the borders of ranks are shared, and the file does not tell how
      many ranks wrote it. */
  void grid(const VtkGrid &g)
  {
    const auto size =
        rows<4>({g.npoints(), g.ncells(), g.connectivity.size(), g.ncells() + (me == 0 ? 1 : 0)});
    const Rows &points = size[0], &cells = size[1], &corners = size[2];
    total("NumberOfPoints", points.all);
    total("NumberOfCells", cells.all);
    total("NumberOfConnectivityIds", corners.all);
    data_set("Points", points, 3, H5T_IEEE_F64LE, H5T_NATIVE_DOUBLE, g.points.data(), group);
    integers("Connectivity", corners, g.connectivity);
    data_set("Types", cells, 1, H5T_STD_U8LE, H5T_NATIVE_UCHAR, g.types.data(), group);

    std::vector<std::int64_t> offsets;    // where cells begin, and the end of the last
    if (me == 0) offsets.push_back(0);
    for (auto end : g.ends) offsets.push_back(static_cast<std::int64_t>(corners.before) + end);
    integers("Offsets", size[3], offsets);

    fields("PointData", points, g.point_fields);
    fields("CellData", cells, g.cell_fields);
  }

 private:
  hid_t group;
  MPI_Comm comm;
  int me;
  bool good_ = true;
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

/** Of the data of this rank in the file. */
unsigned long long bytes_of(const VtkGrid &g)
{
  auto numbers = g.points.size() + g.connectivity.size() + 2 * g.ncells();
  for (const auto *fields : {&g.point_fields, &g.cell_fields})
    for (const auto &f : *fields) numbers += f.values.size();
  return numbers * sizeof(double);
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
std::string try_file(const std::string &file, const VtkGrid &g, MPI_Comm comm)
{
  const unsigned long long mine = bytes_of(g);
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

std::string LAMMPS_NS::write_vtk_file(const std::string &file, const VtkGrid &g, MPI_Comm comm)
{
  const std::string complaint = try_file(file, g, comm);
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
    writer.grid(g);
    good = writer.good();
  }
  good = out.finish() && good;
  return all_good(good, comm) ? "" : "cannot write all of " + file + ": is the disk full?";
}

#endif
