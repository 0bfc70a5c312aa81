#include "database/hdf5_file.h"

#include <algorithm>

#include "corrsel/database/pair_store.h"

namespace corrsel::core {
namespace {

/// Keeps HDF5 from printing its errors, and restores what was set.
class Quiet {
 public:
  Quiet() {
    H5Eget_auto2(H5E_DEFAULT, &function_, &data_);
    H5Eset_auto2(H5E_DEFAULT, nullptr, nullptr);
  }
  ~Quiet() { H5Eset_auto2(H5E_DEFAULT, function_, data_); }
  Quiet(const Quiet&) = delete;
  Quiet& operator=(const Quiet&) = delete;

 private:
  H5E_auto2_t function_ = nullptr;
  void* data_ = nullptr;
};

Hdf5Id openFile(const std::filesystem::path& path, Hdf5File::Access access) {
  const Quiet quiet;
  const unsigned flags = access == Hdf5File::Access::kRead ? H5F_ACC_RDONLY : H5F_ACC_RDWR;
  Hdf5Id file(H5Fopen(path.c_str(), flags, H5P_DEFAULT), H5Fclose);
  if (file) return file;
  std::error_code ignored;
  const auto fault = [&](const std::string& text, StoreError::Kind kind) {
    return StoreError(kind, path.string() + ": " + text);
  };
  if (!std::filesystem::exists(path, ignored)) {
    throw fault("the file does not exist", StoreError::Kind::kStorage);
  }
  if (H5Fis_hdf5(path.c_str()) > 0) {
    throw fault("the HDF5 file cannot be opened; another program writes to it, or it is damaged",
                StoreError::Kind::kStorage);
  }
  throw fault("no HDF5 file, or it cannot be read; give the files that hloc wrote",
              StoreError::Kind::kContent);
}

herr_t addName(hid_t, const char* name, const H5L_info_t*, void* names) {
  static_cast<std::vector<std::string>*>(names)->emplace_back(name);
  return 0;
}

}  // namespace

Hdf5File::Hdf5File(const std::filesystem::path& path, Access access)
    : path_(path), file_(openFile(path, access)) {}

void Hdf5File::fail(const std::string& path, const std::string& fault) const {
  throw StoreError(StoreError::Kind::kContent, path_.string() + ", " + path + ": " + fault);
}

std::vector<std::string> Hdf5File::members(const std::string& group) const {
  const Quiet quiet;
  std::vector<std::string> names;
  const Hdf5Id id(H5Gopen2(file_.get(), group.c_str(), H5P_DEFAULT), H5Gclose);
  if (!id || H5Literate(id.get(), H5_INDEX_NAME, H5_ITER_NATIVE, nullptr, addName, &names) < 0) {
    fail(group, "the group cannot be read; the file is damaged");
  }
  std::sort(names.begin(), names.end());
  return names;
}

bool Hdf5File::isGroup(const std::string& path) const {
  const Quiet quiet;
  const Hdf5Id id(H5Oopen(file_.get(), path.c_str(), H5P_DEFAULT), H5Oclose);
  return id && H5Iget_type(id.get()) == H5I_GROUP;
}

bool Hdf5File::exists(const std::string& path) const {
  const Quiet quiet;
  // H5Lexists() wants the groups above to exist.
  for (std::size_t end = path.find('/'); end != std::string::npos; end = path.find('/', end + 1)) {
    if (H5Lexists(file_.get(), path.substr(0, end).c_str(), H5P_DEFAULT) <= 0) return false;
  }
  return H5Lexists(file_.get(), path.c_str(), H5P_DEFAULT) > 0;
}

Hdf5Id Hdf5File::openDataSet(const std::string& path) const {
  const Quiet quiet;
  Hdf5Id id(H5Dopen2(file_.get(), path.c_str(), H5P_DEFAULT), H5Dclose);
  if (!id) fail(path, "expected numbers, found none; the file is damaged or of another kind");
  return id;
}

std::vector<std::size_t> Hdf5File::shape(const std::string& data_set) const {
  const Hdf5Id id = openDataSet(data_set);
  const Quiet quiet;
  const Hdf5Id space(H5Dget_space(id.get()), H5Sclose);
  const int dimensions = H5Sget_simple_extent_ndims(space.get());
  if (dimensions < 0) fail(data_set, "the shape cannot be read; the file is damaged");
  std::vector<hsize_t> extents(static_cast<std::size_t>(dimensions));
  H5Sget_simple_extent_dims(space.get(), extents.data(), nullptr);
  return {extents.begin(), extents.end()};
}

std::size_t Hdf5File::numberSize(const std::string& data_set) const {
  const Hdf5Id id = openDataSet(data_set);
  const Quiet quiet;
  return H5Tget_size(Hdf5Id(H5Dget_type(id.get()), H5Tclose).get());
}

template <typename Number>
std::vector<Number> Hdf5File::read(const Hdf5Id& data_set, const std::string& path, hid_t type) const {
  const Quiet quiet;
  const Hdf5Id space(H5Dget_space(data_set.get()), H5Sclose);
  const hssize_t count = H5Sget_simple_extent_npoints(space.get());
  if (count < 0) fail(path, "the shape cannot be read; the file is damaged");
  std::vector<Number> values(static_cast<std::size_t>(count));
  if (count > 0 && H5Dread(data_set.get(), type, H5S_ALL, H5S_ALL, H5P_DEFAULT, values.data()) < 0) {
    fail(path, "the numbers cannot be read; the file is damaged");
  }
  return values;
}

std::vector<std::int64_t> Hdf5File::integers(const std::string& data_set) const {
  const Hdf5Id id = openDataSet(data_set);
  const Hdf5Id type(H5Dget_type(id.get()), H5Tclose);
  if (H5Tget_class(type.get()) != H5T_INTEGER) fail(data_set, "expected whole numbers");
  return read<std::int64_t>(id, data_set, H5T_NATIVE_INT64);
}

std::vector<float> Hdf5File::floats(const std::string& data_set) const {
  return read<float>(openDataSet(data_set), data_set, H5T_NATIVE_FLOAT);
}

template <typename Number>
void Hdf5File::writeAs(const std::string& path, hid_t type, const std::vector<Number>& values) {
  const Hdf5Id id = openDataSet(path);
  const Quiet quiet;
  if (values.empty()) return;
  if (H5Dwrite(id.get(), type, H5S_ALL, H5S_ALL, H5P_DEFAULT, values.data()) < 0) {
    throw StoreError(StoreError::Kind::kStorage,
                     path_.string() + ", " + path + ": cannot be written; is the disk full?");
  }
}

void Hdf5File::write(const std::string& data_set, const std::vector<std::int64_t>& values) {
  writeAs(data_set, H5T_NATIVE_INT64, values);
}

void Hdf5File::write(const std::string& data_set, const std::vector<float>& values) {
  writeAs(data_set, H5T_NATIVE_FLOAT, values);
}

void Hdf5File::setAttribute(const std::string& group, const std::string& name, hid_t type,
                            const void* value) {
  const Quiet quiet;
  const Hdf5Id object(H5Oopen(file_.get(), group.c_str(), H5P_DEFAULT), H5Oclose);
  if (object && H5Aexists(object.get(), name.c_str()) > 0) H5Adelete(object.get(), name.c_str());
  const Hdf5Id space(H5Screate(H5S_SCALAR), H5Sclose);
  const Hdf5Id attribute(H5Acreate2(object.get(), name.c_str(), type, space.get(), H5P_DEFAULT, H5P_DEFAULT),
                         H5Aclose);
  if (!attribute || H5Awrite(attribute.get(), type, value) < 0) {
    throw StoreError(StoreError::Kind::kStorage, path_.string() + ", " + group + ": the attribute " + name +
                                                     " cannot be written; is the disk full?");
  }
}

void Hdf5File::setAttribute(const std::string& group, const std::string& name, const std::string& text) {
  const Hdf5Id type(H5Tcopy(H5T_C_S1), H5Tclose);
  H5Tset_size(type.get(), H5T_VARIABLE);
  H5Tset_cset(type.get(), H5T_CSET_UTF8);
  const char* const value = text.c_str();
  setAttribute(group, name, type.get(), &value);
}

void Hdf5File::setAttribute(const std::string& group, const std::string& name, double number) {
  setAttribute(group, name, H5T_NATIVE_DOUBLE, &number);
}

void Hdf5File::flush() {
  const Quiet quiet;
  if (H5Fflush(file_.get(), H5F_SCOPE_GLOBAL) < 0) {
    throw StoreError(StoreError::Kind::kStorage,
                     path_.string() + ": cannot be written to the disk; is it full?");
  }
}

}  // namespace corrsel::core
