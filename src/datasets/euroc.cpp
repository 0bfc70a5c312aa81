#include "datasets/euroc.h"

#include <yaml-cpp/yaml.h>

#include <filesystem>
#include <map>
#include <stdexcept>

#include "base/text.h"
#include "corrsel/camera_formats.h"
#include "datasets/dataset_report.h"
#include "datasets/files.h"
#include "datasets/text_rows.h"
#include "datasets/trajectory.h"

namespace corrsel::core {
namespace {

namespace fs = std::filesystem;

constexpr char kSensors[] = "mav0", kLeft[] = "cam0", kRight[] = "cam1", kTable[] = "data.csv",
               kSensor[] = "sensor.yaml", kPoses[] = "state_groundtruth_estimate0";
constexpr char kRemedy[] =
    "a sequence of EuRoC holds mav0/cam0 (and cam1) with data.csv, data/ and sensor.yaml; unpack it again";
constexpr int kNanoseconds = 0;  // decimals of a nanosecond

bool isFolder(const std::string& path) {
  std::error_code ignored;
  return fs::is_directory(path, ignored);
}

bool isFile(const std::string& path) { return !existingFiles({path}).empty(); }

bool isSequence(const std::string& folder) { return isFolder(below(folder, kSensors)); }

/// A sensor.yaml.
class SensorFile {
 public:
  explicit SensorFile(const std::string& path) : path_(path) {
    if (!isFile(path)) throw DatasetError(path + ": the file is missing; " + kRemedy);
    try {
      root_ = YAML::LoadFile(path);
    } catch (const YAML::Exception& error) {
      throw DatasetError(path + ": not readable as YAML: " + error.what() + "; " + kRemedy);
    }
    if (!root_.IsMap()) throw DatasetError(path + ": has no lines 'key: value'; " + kRemedy);
  }

  /// The numbers of a list.
  std::vector<double> numbers(const std::string& key) const {
    const YAML::Node entry = root_[key];
    const YAML::Node node = entry && entry.IsMap() ? entry["data"] : entry;
    try {
      return node.as<std::vector<double>>();
    } catch (const YAML::Exception&) {
      fail(key, node ? "is not a list of numbers" : "is missing");
    }
  }

  std::vector<double> numbers(const std::string& key, std::size_t count) const {
    std::vector<double> values = numbers(key);
    if (values.size() != count) {
      fail(key, "has " + std::to_string(values.size()) + " numbers where " + std::to_string(count) +
                    " are expected");
    }
    return values;
  }

  bool has(const std::string& key) const { return static_cast<bool>(root_[key]); }

  /// A word; empty where there is none.
  std::string word(const std::string& key) const {
    return root_[key] && root_[key].IsScalar() ? root_[key].Scalar() : "";
  }

  /// The camera, with the names of EuRoC or of Kalibr for its coefficients.
  Camera camera() const {
    KalibrCamera camera;
    camera.camera_model = word("camera_model");
    camera.intrinsics = numbers("intrinsics");
    camera.distortion_model = word("distortion_model");
    camera.distortion_coeffs =
        numbers(has("distortion_coeffs") ? "distortion_coeffs" : "distortion_coefficients");
    const std::vector<double> size = numbers("resolution", 2);
    try {
      camera.resolution = imageSize(size[0], size[1]);
      return cameraFromKalibr(camera);
    } catch (const std::invalid_argument& error) {
      throw DatasetError(path_ + ": " + error.what() + "; undistort the images of other cameras first");
    }
  }

  RigidMotion toBody() const {
    try {
      return motionOf(cv::Matx44d(numbers("T_BS", 16).data()));
    } catch (const std::invalid_argument& error) {
      fail("T_BS", std::string("is not a rigid motion: ") + error.what());
    }
  }

 private:
  [[noreturn]] void fail(const std::string& key, const std::string& fault) const {
    throw DatasetError(path_ + ": '" + key + "' " + fault + "; " + kRemedy);
  }

  std::string path_;
  YAML::Node root_;
};

/// One of the cameras, and the images that it took.
struct CameraFolder {
  std::shared_ptr<const Lens> lens;
  RigidMotion to_body;
  std::map<std::int64_t, std::string> images;  ///< paths by time, ns
};

CameraFolder readCamera(const std::string& folder) {
  const std::string path = below(folder, kSensor);
  const SensorFile sensor(path);
  CameraFolder camera;
  camera.to_body = sensor.toBody();
  try {
    camera.lens = std::make_shared<const Lens>(fs::path(folder).filename().string(), sensor.camera());
  } catch (const std::invalid_argument& error) {
    throw DatasetError(path + ": " + error.what());
  }
  for (const TextRow& row : readTextRows(below(folder, kTable), kRemedy)) {
    row.requireWords(2, "timestamp [ns], filename");
    camera.images[row.time(0, kNanoseconds)] = below(below(folder, "data"), row.words[1]);
  }
  if (camera.images.empty()) throw DatasetError(below(folder, kTable) + ": names no image; " + kRemedy);
  return camera;
}

/// The poses of the body of the cameras.
Trajectory readPoses(const std::string& folder) {
  const std::string sensor_path = below(folder, kSensor), path = below(folder, kTable);
  RigidMotion truth_to_body;
  if (isFile(sensor_path)) {
    const SensorFile sensor(sensor_path);
    if (sensor.has("T_BS")) truth_to_body = sensor.toBody();
  }
  const RigidMotion from_body = truth_to_body.inverse();
  Trajectory poses;
  for (const TextRow& row : readTextRows(path, kRemedy)) {
    if (row.words.size() < 8) {
      row.fail("has " + std::to_string(row.words.size()) +
               " entries, at least 8 are expected (timestamp [ns], position x y z [m], quaternion w x y z)");
    }
    poses.add(row.time(0, kNanoseconds), poseIn(row, {4, 5, 6, 7}, 1) * from_body);
  }
  if (poses.empty()) throw DatasetError(path + ": holds no pose; " + kRemedy);
  return poses;
}

void addStereo(const std::string& name, const std::string& sequence, const CameraFolder& left,
               const CameraFolder& right, const PairChoice& choice, PosedDataset& dataset) {
  std::vector<PosedPair> pairs;
  for (const auto& [time, image] : left.images) {
    const auto other = right.images.find(time);
    if (other == right.images.end()) continue;
    PosedPair pair;
    pair.id = {name, sequence, std::to_string(time) + "-stereo"};
    pair.left = {image, left.lens};
    pair.right = {other->second, right.lens};
    pair.motion = right.to_body.inverse() * left.to_body;
    pairs.push_back(std::move(pair));
  }
  const std::vector<std::size_t> used =
      evenlySpaced(pairs.size(), static_cast<std::size_t>(choice.max_pairs));
  for (const std::size_t i : used) dataset.pairs.push_back(pairs[i]);
  dataset.remarks.push_back(
      sequence + ": " + std::to_string(used.size()) + " of " + std::to_string(pairs.size()) +
      " stereo pairs are used (max_pairs in " + std::string(PairChoice::kFile) + "), " +
      std::to_string(left.images.size() - pairs.size()) + " of " + std::to_string(left.images.size()) +
      " images of cam0 have none of cam1 at their "
      "time");
}

void addSequence(const std::string& name, const std::string& folder, const PairChoice& choice,
                 PosedDataset& dataset) {
  const std::string sequence = folderName(folder), sensors = below(folder, kSensors);
  const CameraFolder left = readCamera(below(sensors, kLeft));
  if (left.lens->distorted()) dataset.remarks.push_back(sequence + ": " + left.lens->text());
  if (choice.pairs != FramePairs::kSteps) {
    if (isFolder(below(sensors, kRight))) {
      const CameraFolder right = readCamera(below(sensors, kRight));
      if (right.lens->distorted()) dataset.remarks.push_back(sequence + ": " + right.lens->text());
      addStereo(name, sequence, left, right, choice, dataset);
    } else {
      dataset.remarks.push_back(sequence + ": there are no stereo pairs, because mav0/cam1 is missing");
    }
  }
  if (choice.pairs == FramePairs::kStereo) return;
  const std::string poses_folder = below(sensors, kPoses);
  if (!isFolder(poses_folder)) {
    dataset.remarks.push_back(sequence + ": there are no pairs of different times, because mav0/" +
                              std::string(kPoses) + " is missing");
    return;
  }
  const Trajectory poses = readPoses(poses_folder);
  const auto gap = static_cast<std::int64_t>(choice.max_gap * 1e9);
  std::vector<PosedFrame> frames;
  for (const auto& [time, image] : left.images) {
    const std::optional<RigidMotion> body = poses.at(time, gap);
    frames.push_back({std::to_string(time),
                      {image, left.lens},
                      body ? *body * left.to_body : RigidMotion(),
                      body.has_value()});
  }
  addSteps(name, sequence, frames, choice, dataset);
}

std::vector<std::string> filesOf(const std::string& folder) {
  std::vector<std::string> files;
  for (const char* const sensor : {kLeft, kRight, kPoses}) {
    for (const char* const file : {kTable, kSensor}) {
      files.push_back(below(below(below(folder, kSensors), sensor), file));
    }
  }
  return files;
}

}  // namespace

PosedDataset readEuroc(const std::string& name, const std::string& root) {
  return readSequences(name, root, {"the sequences", kRemedy, isSequence, filesOf, addSequence});
}

bool hasEuroc(const std::string& root) { return !sequenceFolders(root, isSequence).empty(); }

}  // namespace corrsel::core
