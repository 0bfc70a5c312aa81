#pragma once

#include <hdf5.h>

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <utility>
#include <vector>

namespace corrsel::core {

/// One of HDF5's identifiers, closed by its function.
class Hdf5Id {
 public:
  using Closing = herr_t (*)(hid_t);

  Hdf5Id(hid_t id, Closing closing) : id_(id), closing_(closing) {}
  ~Hdf5Id() {
    if (id_ >= 0) closing_(id_);
  }
  Hdf5Id(Hdf5Id&& other) noexcept : id_(std::exchange(other.id_, -1)), closing_(other.closing_) {}
  Hdf5Id& operator=(Hdf5Id&&) = delete;

  hid_t get() const { return id_; }
  explicit operator bool() const { return id_ >= 0; }

 private:
  hid_t id_;
  Closing closing_;
};

/// A file of HDF5 that exists. Paths name groups and data sets, with '/' between the names. The library
/// prints nothing; failures throw StoreError naming file and path.
///
/// Not thread-safe: the library may have been built without locks.
class Hdf5File {
 public:
  enum class Access { kRead, kWrite };

  explicit Hdf5File(const std::filesystem::path& path, Access access = Access::kRead);

  /// Names of what a group holds, in byte order. O(names).
  std::vector<std::string> members(const std::string& group) const;

  bool isGroup(const std::string& path) const;
  bool exists(const std::string& path) const;

  /// Extents of the dimensions of a data set; none for a single number.
  std::vector<std::size_t> shape(const std::string& data_set) const;

  /// Bytes of one number of a data set.
  std::size_t numberSize(const std::string& data_set) const;

  /// All numbers of a data set, row by row. The first one reads integers only.
  std::vector<std::int64_t> integers(const std::string& data_set) const;
  std::vector<float> floats(const std::string& data_set) const;

  /// Replaces the numbers of a data set, which keeps its type and shape.
  /// @pre as many values as the data set has
  void write(const std::string& data_set, const std::vector<std::int64_t>& values);
  void write(const std::string& data_set, const std::vector<float>& values);

  /// Sets an attribute of a group, in the types that h5py reads as str and float.
  void setAttribute(const std::string& group, const std::string& name, const std::string& text);
  void setAttribute(const std::string& group, const std::string& name, double number);

  /// Writes what is in memory to the file.
  void flush();

 private:
  [[noreturn]] void fail(const std::string& path, const std::string& fault) const;
  Hdf5Id openDataSet(const std::string& path) const;
  template <typename Number>
  std::vector<Number> read(const Hdf5Id& data_set, const std::string& path, hid_t type) const;
  template <typename Number>
  void writeAs(const std::string& path, hid_t type, const std::vector<Number>& values);
  void setAttribute(const std::string& group, const std::string& name, hid_t type, const void* value);

  std::filesystem::path path_;
  Hdf5Id file_;
};

}  // namespace corrsel::core
