#include "database/colmap_rows.h"

#include <algorithm>
#include <cmath>

#include "database/colmap_conventions.h"

namespace corrsel::core {
namespace {

// The numbers of COLMAP's camera models.
constexpr std::array<const char*, 12> kCameraModels = {"SIMPLE_PINHOLE",
                                                       "PINHOLE",
                                                       "SIMPLE_RADIAL",
                                                       "RADIAL",
                                                       "OPENCV",
                                                       "OPENCV_FISHEYE",
                                                       "FULL_OPENCV",
                                                       "FOV",
                                                       "SIMPLE_RADIAL_FISHEYE",
                                                       "RADIAL_FISHEYE",
                                                       "THIN_PRISM_FISHEYE",
                                                       "RAD_TAN_THIN_PRISM_FISHEYE"};
constexpr int kSimpleRadial = 2;       // f cx cy k
constexpr double kGuessedFocal = 1.2;  // of the larger side of the image, as COLMAP does
AffineFrame frameOf(const ColmapTable& table, std::size_t row, const cv::Point2f& at) {
  const auto value = [&](std::size_t column) { return table.at<float>(row, column); };
  if (table.columns == 6) return {value(2), value(3), at.x, value(4), value(5), at.y};
  const float cosine = value(2) * std::cos(value(3)), sine = value(2) * std::sin(value(3));
  return {cosine, -sine, at.x, sine, cosine, at.y};
}

}  // namespace

ColmapTable readColmapTable(const SqliteQuery& query, std::size_t value_bytes, const SqliteDatabase& database,
                            const std::string& place) {
  const auto refuse = [&](const std::string& text) {
    throw StoreError(StoreError::Kind::kContent, database.path().string() + ": " + place + text);
  };
  if (!query.isInteger(0) || query.integer(0) < 0) {
    refuse(": rows is '" + query.text(0) + "', expected a whole number");
  }
  if (!query.isInteger(1)) refuse(": cols is '" + query.text(1) + "', expected a whole number");
  if (!query.isBlob(2) && !query.isNull(2)) refuse(": data is no BLOB");
  const SqliteBlob bytes = query.blob(2);
  const std::int64_t rows = query.integer(0), columns = query.integer(1);
  if (rows == 0 && bytes.size == 0) return {};
  const std::size_t row_bytes = static_cast<std::size_t>(std::max<std::int64_t>(columns, 0)) * value_bytes;
  if (row_bytes == 0 || bytes.size % row_bytes || bytes.size / row_bytes != static_cast<std::size_t>(rows)) {
    refuse(": data has " + std::to_string(bytes.size) + " bytes, expected " + std::to_string(rows) + " x " +
           std::to_string(columns) + " x " + std::to_string(value_bytes) +
           " (rows, cols, bytes of a number); the database is damaged");
  }
  return {static_cast<std::size_t>(rows), static_cast<std::size_t>(columns), bytes.data};
}

std::vector<KeypointPair> readColmapPairs(const SqliteQuery& query, const SqliteDatabase& database,
                                          const std::string& place) {
  const ColmapTable table = readColmapTable(query, sizeof(std::uint32_t), database, place);
  if (table.rows && table.columns != 2) {
    throw StoreError(StoreError::Kind::kContent, database.path().string() + ": " + place + " has " +
                                                     std::to_string(table.columns) + " columns, expected 2");
  }
  std::vector<KeypointPair> pairs(table.rows);
  if (table.rows) std::memcpy(pairs.data(), table.data, table.rows * sizeof(KeypointPair));
  return pairs;
}

StoredKeypoints keypointsOf(const ColmapTable& table) {
  StoredKeypoints keypoints;
  keypoints.positions.reserve(table.rows);
  if (table.columns > 2) keypoints.frames.reserve(table.rows);
  for (std::size_t row = 0; row < table.rows; ++row) {
    const cv::Point2f at(table.at<float>(row, 0) - kColmapPixelCentre,
                         table.at<float>(row, 1) - kColmapPixelCentre);
    keypoints.positions.push_back(at);
    if (table.columns > 2) keypoints.frames.push_back(frameOf(table, row, at));
  }
  return keypoints;
}

std::vector<float> keypointValues(const StoredKeypoints& keypoints) {
  std::vector<float> values;
  values.reserve(keypoints.positions.size() * (keypoints.frames.empty() ? 2 : 6));
  for (std::size_t i = 0; i < keypoints.positions.size(); ++i) {
    values.push_back(keypoints.positions[i].x + kColmapPixelCentre);
    values.push_back(keypoints.positions[i].y + kColmapPixelCentre);
    if (keypoints.frames.empty()) continue;
    const AffineFrame& f = keypoints.frames[i];
    values.insert(values.end(), {f[0], f[1], f[3], f[4]});
  }
  return values;
}

std::string colmapModelName(std::int64_t number) {
  const bool known = number >= 0 && number < static_cast<std::int64_t>(kCameraModels.size());
  return known ? kCameraModels[static_cast<std::size_t>(number)] : "number " + std::to_string(number);
}

std::int64_t colmapModelNumber(const std::string& name) {
  return std::find(kCameraModels.begin(), kCameraModels.end(), name) - kCameraModels.begin();
}

ColmapCamera colmapCameraOf(const StoredImage& image) {
  if (image.camera) {
    ColmapCamera camera = cameraToColmap(*image.camera);
    camera.size = image.size;
    return camera;
  }
  const double width = image.size.width, height = image.size.height;
  return {kCameraModels[kSimpleRadial],
          image.size,
          {kGuessedFocal * std::max(width, height), width / 2, height / 2, 0}};
}

}  // namespace corrsel::core
