#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <optional>
#include <string>
#include <vector>

#include "corrsel/camera_formats.h"
#include "corrsel/database/pair_store.h"
#include "database/sqlite.h"

// The contents of rows of COLMAP's tables.

namespace corrsel::core {

template <typename Value>
SqliteBlob bytesOf(const std::vector<Value>& values) {
  return {reinterpret_cast<const unsigned char*>(values.data()), values.size() * sizeof(Value)};
}

template <typename Value, std::size_t count>
SqliteBlob bytesOf(const std::array<Value, count>& values) {
  return {reinterpret_cast<const unsigned char*>(values.data()), sizeof(values)};
}

/// Rows and columns of numbers in a BLOB, which need not be aligned.
struct ColmapTable {
  std::size_t rows = 0, columns = 0;
  const unsigned char* data = nullptr;

  template <typename Value>
  Value at(std::size_t row, std::size_t column) const {
    Value value;
    std::memcpy(&value, data + (row * columns + column) * sizeof(Value), sizeof(Value));
    return value;
  }
};

/// Reads the columns rows, cols and data, which are the first ones of a query. The table lives as long as the
/// query's row. Throws StoreError.
/// @param value_bytes  of one number
/// @param place        table and row, for messages
ColmapTable readColmapTable(const SqliteQuery& query, std::size_t value_bytes, const SqliteDatabase& database,
                            const std::string& place);

/// As readColmapTable() for pairs of numbers of keypoints. Throws StoreError.
std::vector<KeypointPair> readColmapPairs(const SqliteQuery& query, const SqliteDatabase& database,
                                          const std::string& place);

/// The numbers of a BLOB; absent where it is NULL or empty. @return false for any other length
template <std::size_t count>
bool readNumbers(SqliteBlob bytes, std::optional<std::array<double, count>>& numbers) {
  if (bytes.size == 0) return true;
  if (bytes.size != count * sizeof(double)) return false;
  std::memcpy(numbers.emplace().data(), bytes.data, bytes.size);
  return true;
}

/// Keypoints of a table of float with 2 columns (x y), 4 (also scale and angle) or 6 (also a11 a12 a21 a22).
StoredKeypoints keypointsOf(const ColmapTable& table);

/// The columns x y, or x y a11 a12 a21 a22 of keypoints with frames.
std::vector<float> keypointValues(const StoredKeypoints& keypoints);

/// COLMAP's name of the camera model of a number; "number 42" where it is not known.
std::string colmapModelName(std::int64_t number);

/// The number of a model that cameraToColmap() gives.
std::int64_t colmapModelNumber(const std::string& name);

/// The camera of an image; one with a guessed focal length where it is not known. Throws what
/// cameraToColmap() throws.
ColmapCamera colmapCameraOf(const StoredImage& image);

}  // namespace corrsel::core
