#include "datasets/colmap_model.h"

#include <algorithm>
#include <cmath>
#include <fstream>
#include <iterator>
#include <limits>
#include <stdexcept>
#include <type_traits>

#include "base/text.h"
#include "corrsel/datasets/reader.h"
#include "datasets/files.h"
#include "datasets/lens.h"
#include "datasets/text_rows.h"

namespace corrsel::core {
namespace {

constexpr char kRemedy[] = "export the model again (colmap model_converter)";
constexpr double kMaxExact = 9007199254740992;  // 2^53: up to it, doubles hold all whole numbers

/// The numbers of models in files, as src/colmap/sensor/models.h states them.
struct Model {
  const char* name;
  std::size_t parameters;
};
constexpr Model kModels[] = {
    {"SIMPLE_PINHOLE", 3},
    {"PINHOLE", 4},
    {"SIMPLE_RADIAL", 4},
    {"RADIAL", 5},
    {"OPENCV", 8},
    {"OPENCV_FISHEYE", 8},
    {"FULL_OPENCV", 12},
    {"FOV", 5},
    {"SIMPLE_RADIAL_FISHEYE", 4},
    {"RADIAL_FISHEYE", 5},
    {"THIN_PRISM_FISHEYE", 12},
    {"RAD_TAN_THIN_PRISM_FISHEYE", 16},
};

std::string fileOf(const std::string& folder, const char* name, bool binary) {
  return below(folder, std::string(name) + (binary ? ".bin" : ".txt"));
}

bool hasFiles(const std::string& folder, bool binary) {
  return existingFiles({fileOf(folder, "cameras", binary), fileOf(folder, "images", binary)}).size() == 2;
}

cv::Size sizeOf(double width, double height, const std::string& place) {
  try {
    return imageSize(width, height);
  } catch (const std::invalid_argument& error) {
    throw DatasetError(place + ": " + error.what() + "; " + kRemedy);
  }
}

void sortPoints(ColmapImage& image) {
  std::vector<std::int64_t>& points = image.points;
  std::sort(points.begin(), points.end());
  points.erase(std::unique(points.begin(), points.end()), points.end());
}

RigidMotion poseOf(const double* quaternion, const double* translation, const std::string& place) {
  try {
    return motionOf(quaternion[0], quaternion[1], quaternion[2], quaternion[3],
                    {translation[0], translation[1], translation[2]});
  } catch (const std::invalid_argument& error) {
    throw DatasetError(place + ": " + error.what() + "; " + kRemedy);
  }
}

std::int64_t wholeNumber(const TextRow& row, std::size_t word) {
  const double value = row.number(word);
  if (!(std::abs(value) <= kMaxExact) || value != std::floor(value)) {
    row.fail("entry " + std::to_string(word + 1) + ": '" + row.words[word] +
             "' is not a whole number up to " + "2^53; " + kRemedy);
  }
  return static_cast<std::int64_t>(value);
}

void readCamerasText(const std::string& path, ColmapModel& model) {
  for (const TextRow& row : readTextRows(path, kRemedy)) {
    if (row.words.size() < 4) {
      row.fail("has " + std::to_string(row.words.size()) +
               " entries, at least 4 are expected (CAMERA_ID MODEL WIDTH HEIGHT PARAMS...)");
    }
    ColmapModelCamera camera;
    camera.place = row.place();
    camera.id = wholeNumber(row, 0);
    camera.camera.model = row.words[1];
    camera.camera.size = sizeOf(row.number(2), row.number(3), camera.place);
    camera.camera.parameters = row.numbers(4, row.words.size() - 4);
    model.cameras.push_back(std::move(camera));
  }
}

/// What follows the first `count` words.
std::string withoutWords(const std::string& line, std::size_t count) {
  std::size_t at = line.find_first_not_of(' ');
  for (std::size_t i = 0; i < count; ++i) at = line.find_first_not_of(' ', line.find(' ', at));
  return line.substr(at, line.find_last_not_of(" \t") + 1 - at);
}

/// The first line of an image in text: eight numbers, the camera, and a name that may hold blanks.
ColmapImage imageOfLine(const TextRow& row, const std::string& line) {
  if (row.words.size() < 10) {
    row.fail("has " + std::to_string(row.words.size()) +
             " entries, at least 10 are expected (IMAGE_ID QW QX QY QZ TX TY TZ CAMERA_ID NAME)");
  }
  ColmapImage image;
  image.place = row.place();
  image.id = wholeNumber(row, 0);
  const std::vector<double> pose = row.numbers(1, 7);
  image.pose = poseOf(pose.data(), pose.data() + 4, image.place);
  image.camera = wholeNumber(row, 8);
  image.name = withoutWords(line, 9);
  return image;
}

/// Its second line: x, y and the id of the 3D point, or -1, of each of its points.
std::vector<std::int64_t> pointsOfLine(const TextRow& row) {
  if (row.words.size() % 3 != 0) {
    row.fail(
        "has " + std::to_string(row.words.size()) +
        " entries, which is no multiple of 3: the second line of an image holds X Y POINT3D_ID of each of "
        "its points");
  }
  std::vector<std::int64_t> points;
  for (std::size_t i = 2; i < row.words.size(); i += 3) {
    const std::int64_t point = wholeNumber(row, i);
    if (point >= 0) points.push_back(point);
  }
  return points;
}

/// readTextRows() would leave out the empty second line of an image without points.
void readImagesText(const std::string& path, ColmapModel& model) {
  std::ifstream stream(path);
  if (!stream) throw DatasetError(path + ": cannot be opened; check the permissions of the file");
  std::size_t number = 0;
  bool second = false;
  for (std::string line; std::getline(stream, line);) {
    ++number;
    if (!line.empty() && line.back() == '\r') line.pop_back();
    const TextRow row{path, number, splitList(line, ' ')};
    if (!second && (row.words.empty() || row.words.front()[0] == '#')) continue;
    if (second) {
      model.images.back().points = pointsOfLine(row);
      sortPoints(model.images.back());
    } else {
      model.images.push_back(imageOfLine(row, line));
    }
    second = !second;
  }
  if (second && !stream.eof()) throw DatasetError(path + ": cannot be read to its end; " + kRemedy);
}

/// A file of little-endian numbers.
class BinaryFile {
 public:
  explicit BinaryFile(const std::string& path) : path_(path) {
    std::ifstream stream(path, std::ios::binary);
    if (!stream) throw DatasetError(path + ": cannot be opened; check the permissions of the file");
    bytes_.assign(std::istreambuf_iterator<char>(stream), {});
  }

  template <typename Number>
  Number next() {
    static_assert(std::is_arithmetic_v<Number>, "numbers only");
    require(sizeof(Number));
    Number value;
    std::copy_n(bytes_.data() + at_, sizeof(Number), reinterpret_cast<char*>(&value));
    at_ += sizeof(Number);
    return value;
  }

  /// A number of items of `bytes` bytes or more each.
  std::uint64_t count(std::size_t bytes) {
    const std::uint64_t value = next<std::uint64_t>();
    if (value > (bytes_.size() - at_) / bytes) failCutOff();
    return value;
  }

  std::string text() {
    const std::size_t end = bytes_.find('\0', at_);
    if (end == std::string::npos) failCutOff();
    const std::string value = bytes_.substr(at_, end - at_);
    at_ = end + 1;
    return value;
  }

  void skip(std::size_t bytes) {
    require(bytes);
    at_ += bytes;
  }

  const std::string& path() const { return path_; }

 private:
  void require(std::size_t bytes) const {
    if (bytes > bytes_.size() - at_) failCutOff();
  }

  [[noreturn]] void failCutOff() const {
    throw DatasetError(path_ + ": is cut off or not of COLMAP's binary format: it ends after " +
                       std::to_string(bytes_.size()) + " bytes; " + kRemedy);
  }

  std::string path_, bytes_;
  std::size_t at_ = 0;
};

void readCamerasBinary(const std::string& path, ColmapModel& model) {
  BinaryFile file(path);
  const std::uint64_t cameras = file.count(24);
  for (std::uint64_t i = 0; i < cameras; ++i) {
    ColmapModelCamera camera;
    camera.id = file.next<std::uint32_t>();
    const auto number = file.next<std::int32_t>();
    camera.place = path + ": camera " + std::to_string(camera.id);
    if (number < 0 || number >= static_cast<std::int32_t>(std::size(kModels))) {
      throw DatasetError(camera.place + " has the model number " + std::to_string(number) +
                         ", which is not known; " + kRemedy + " as text");
    }
    const Model& known = kModels[number];
    camera.camera.model = known.name;
    const auto width = static_cast<double>(file.next<std::uint64_t>());
    const auto height = static_cast<double>(file.next<std::uint64_t>());
    camera.camera.size = sizeOf(width, height, camera.place);
    for (std::size_t k = 0; k < known.parameters; ++k)
      camera.camera.parameters.push_back(file.next<double>());
    model.cameras.push_back(std::move(camera));
  }
}

void readImagesBinary(const std::string& path, ColmapModel& model) {
  BinaryFile file(path);
  const std::uint64_t images = file.count(73);
  for (std::uint64_t i = 0; i < images; ++i) {
    ColmapImage image;
    image.id = file.next<std::uint32_t>();
    image.place = path + ": image " + std::to_string(image.id);
    double pose[7];
    for (double& value : pose) value = file.next<double>();
    image.pose = poseOf(pose, pose + 4, image.place);
    image.camera = file.next<std::uint32_t>();
    image.name = file.text();
    const std::uint64_t points = file.count(24);
    for (std::uint64_t k = 0; k < points; ++k) {
      file.skip(2 * sizeof(double));
      const auto point = file.next<std::int64_t>();
      if (point >= 0) image.points.push_back(point);
    }
    sortPoints(image);
    model.images.push_back(std::move(image));
  }
}

}  // namespace

ColmapModel readColmapModel(const std::string& folder) {
  const bool binary = hasFiles(folder, true);
  ColmapModel model;
  const std::vector<std::string> files = colmapFiles(folder);
  const std::string &cameras = files[0], &images = files[1];
  for (const std::string& path : files) {
    if (existingFiles({path}).empty()) throw DatasetError(path + ": the file is missing; " + kRemedy);
  }
  if (binary) {
    readCamerasBinary(cameras, model);
    readImagesBinary(images, model);
  } else {
    readCamerasText(cameras, model);
    readImagesText(images, model);
  }
  return model;
}

std::vector<std::string> colmapFiles(const std::string& folder) {
  const bool binary = hasFiles(folder, true);
  return {fileOf(folder, "cameras", binary), fileOf(folder, "images", binary)};
}

bool hasColmapModel(const std::string& folder) { return hasFiles(folder, true) || hasFiles(folder, false); }

}  // namespace corrsel::core
