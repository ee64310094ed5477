#ifndef DEFE_TEST_VTK_FILE_H
#define DEFE_TEST_VTK_FILE_H

// Files of fix defe/vtk, read by HDF5; each rank reads for itself.

#include <hdf5.h>

#include <map>
#include <stdexcept>
#include <string>
#include <vector>

namespace defe::test {

class VtkFile {
 public:
  explicit VtkFile(const std::string &name)
  {
    const hid_t file = H5Fopen(name.c_str(), H5F_ACC_RDONLY, H5P_DEFAULT);
    if (file < 0) throw std::runtime_error("cannot open " + name);
    for (const char *set : {"Points", "Connectivity", "Offsets", "Types"}) read(file, set);
    for (const char *group : {"PointData", "CellData"}) {
      const hid_t folder = H5Gopen2(file, (std::string("VTKHDF/") + group).c_str(), H5P_DEFAULT);
      H5Literate(folder, H5_INDEX_NAME, H5_ITER_INC, nullptr, note_name, this);
      H5Gclose(folder);
      for (const auto &n : names) read(file, std::string(group) + "/" + n);
      names.clear();
    }
    H5Fclose(file);
  }

  std::size_t npoints() const { return at("Points").size() / 3; }
  std::size_t ncells() const { return at("Types").size(); }
  bool has(const std::string &name) const { return sets.count(name) > 0; }
  const std::vector<double> &at(const std::string &name) const
  {
    const auto found = sets.find(name);
    if (found == sets.end()) throw std::runtime_error("no data set " + name);
    return found->second;
  }
  double cell(const std::string &name, std::size_t c) const { return at("CellData/" + name)[c]; }
  double point(const std::string &name, std::size_t p) const { return at("PointData/" + name)[p]; }
  /// The file that a data set is in, if it is another one.
  std::string file_of(const std::string &name) const
  {
    const auto found = links.find(name);
    return found == links.end() ? "" : found->second;
  }
  const double *xyz(std::size_t p) const { return &at("Points")[3 * p]; }
  /// Corner a of cell c.
  std::size_t corner(std::size_t c, int a) const
  {
    return static_cast<std::size_t>(
        at("Connectivity")[static_cast<std::size_t>(at("Offsets")[c]) + a]);
  }

 private:
  std::map<std::string, std::vector<double>> sets;
  std::map<std::string, std::string> links;
  std::vector<std::string> names;

  static herr_t note_name(hid_t, const char *name, const H5L_info_t *, void *self)
  {
    static_cast<VtkFile *>(self)->names.emplace_back(name);
    return 0;
  }

  void read(hid_t file, const std::string &name)
  {
    H5L_info_t info;
    H5Lget_info(file, ("VTKHDF/" + name).c_str(), &info, H5P_DEFAULT);
    if (info.type == H5L_TYPE_EXTERNAL) {
      std::vector<char> value(info.u.val_size);
      H5Lget_val(file, ("VTKHDF/" + name).c_str(), value.data(), value.size(), H5P_DEFAULT);
      const char *other = nullptr;
      H5Lunpack_elink_val(value.data(), value.size(), nullptr, &other, nullptr);
      links[name] = other;
    }
    const hid_t set = H5Dopen2(file, ("VTKHDF/" + name).c_str(), H5P_DEFAULT);
    if (set < 0) throw std::runtime_error("no data set " + name);
    const hid_t space = H5Dget_space(set);
    auto &values = sets[name];
    values.resize(static_cast<std::size_t>(H5Sget_simple_extent_npoints(space)));
    if (!values.empty())
      H5Dread(set, H5T_NATIVE_DOUBLE, H5S_ALL, H5S_ALL, H5P_DEFAULT, values.data());
    H5Sclose(space);
    H5Dclose(set);
  }
};

}    // namespace defe::test

#endif
