#include "datasets/tum_rgbd.h"

#include <filesystem>
#include <iterator>
#include <stdexcept>

#include "base/text.h"
#include "corrsel/camera_formats.h"
#include "datasets/files.h"
#include "datasets/text_rows.h"
#include "datasets/trajectory.h"

namespace corrsel::core {
namespace {

namespace fs = std::filesystem;

constexpr char kImages[] = "rgb.txt", kPoses[] = "groundtruth.txt", kCalibration[] = "calibration.txt";
constexpr char kRemedy[] =
    "a sequence of TUM RGB-D holds rgb.txt, groundtruth.txt and the images that rgb.txt names; unpack it "
    "again";
constexpr int kSeconds = 9;  // decimals of a nanosecond

/// https://cvg.cit.tum.de/data/datasets/rgbd-dataset/file_formats, "Calibration of the color camera"; the
/// images of freiburg3 are published without distortion.
struct Published {
  const char *name, *abbreviation;
  double fx, fy, cx, cy;
  double distortion[5];
};

constexpr Published kPublished[] = {
    {"freiburg1", "fr1_", 517.3, 516.5, 318.6, 255.3, {0.2624, -0.9531, -0.0054, 0.0026, 1.1633}},
    {"freiburg2", "fr2_", 520.9, 521.0, 325.1, 249.7, {0.2312, -0.7849, -0.0033, -0.0001, 0.9172}},
    {"freiburg3", "fr3_", 535.4, 539.2, 320.1, 247.6, {0, 0, 0, 0, 0}},
};
const cv::Size kSize(640, 480);

bool isSequence(const std::string& folder) {
  return !existingFiles({below(folder, kImages)}).empty() || !existingFiles({below(folder, kPoses)}).empty();
}

Lens ownLens(const std::string& path) {
  const std::vector<TextRow> rows = readTextRows(path, kRemedy);
  const std::string meaning = "fx fy cx cy [k1 k2 p1 p2 [k3]]";
  if (rows.size() != 1) {
    throw DatasetError(path + ": has " + std::to_string(rows.size()) +
                       " lines where one is expected: " + meaning);
  }
  const std::size_t count = rows[0].words.size();
  if (count != 4 && count != 8 && count != 9) {
    rows[0].fail("has " + std::to_string(count) + " entries where 4, 8 or 9 are expected: " + meaning);
  }
  const std::vector<double> k = rows[0].numbers(0, count);
  const std::vector<double> distortion(k.begin() + 4, k.end());
  // The size is stated nowhere; that of the Kinect's images is needed to remove a distortion.
  return Lens("the camera of " + std::string(kCalibration),
              cameraFromOpenCv(cameraMatrix(k[0], k[1], k[2], k[3]), distortion,
                               distortion.empty() ? cv::Size() : kSize));
}

Lens lensOf(const std::string& folder) {
  const std::string path = below(folder, kCalibration), name = folderName(folder);
  if (!existingFiles({path}).empty()) {
    try {
      return ownLens(path);
    } catch (const std::invalid_argument& error) {
      throw DatasetError(path + ": " + error.what());
    }
  }
  for (const Published& camera : kPublished) {
    if (name.find(camera.name) == std::string::npos && name.find(camera.abbreviation) != 0) continue;
    return Lens("the camera of " + std::string(camera.name),
                cameraFromOpenCv(cameraMatrix(camera.fx, camera.fy, camera.cx, camera.cy),
                                 {std::begin(camera.distortion), std::end(camera.distortion)}, kSize));
  }
  throw DatasetError(
      folder +
      ": the camera is not known: the folder's name has none of freiburg1, freiburg2 and "
      "freiburg3, and there is no calibration.txt; write one with the line fx fy cx cy [k1 k2 p1 "
      "p2 [k3]], px");
}

Trajectory readPoses(const std::string& path) {
  Trajectory poses;
  for (const TextRow& row : readTextRows(path, kRemedy)) {
    row.requireWords(8, "timestamp tx ty tz qx qy qz qw");
    poses.add(row.time(0, kSeconds), poseIn(row, {7, 4, 5, 6}, 1));
  }
  if (poses.empty()) throw DatasetError(path + ": holds no pose; " + kRemedy);
  return poses;
}

std::vector<PosedFrame> readFrames(const std::string& folder, const PairChoice& choice,
                                   const std::shared_ptr<const Lens>& lens) {
  const Trajectory poses = readPoses(below(folder, kPoses));
  const auto gap = static_cast<std::int64_t>(choice.max_gap * 1e9);
  std::vector<PosedFrame> frames;
  for (const TextRow& row : readTextRows(below(folder, kImages), kRemedy)) {
    row.requireWords(2, "timestamp path");
    const std::optional<RigidMotion> pose = poses.at(row.time(0, kSeconds), gap);
    frames.push_back(
        {row.words[0], {below(folder, row.words[1]), lens}, pose.value_or(RigidMotion()), pose.has_value()});
  }
  return frames;
}

void addSequence(const std::string& name, const std::string& folder, const PairChoice& choice,
                 PosedDataset& dataset) {
  const std::string sequence = folderName(folder);
  const auto lens = std::make_shared<const Lens>(lensOf(folder));
  const std::size_t before = dataset.pairs.size();
  addSteps(name, sequence, readFrames(folder, choice, lens), choice, dataset);
  if (lens->distorted() && dataset.pairs.size() > before) {
    dataset.remarks.push_back(sequence + ": " + lens->text());
  }
}

std::vector<std::string> filesOf(const std::string& folder) {
  return {below(folder, kImages), below(folder, kPoses), below(folder, kCalibration)};
}

}  // namespace

PosedDataset readTumRgbd(const std::string& name, const std::string& root) {
  return readSequences(name, root, {"the sequences", kRemedy, isSequence, filesOf, addSequence});
}

bool hasTumRgbd(const std::string& root) { return !sequenceFolders(root, isSequence).empty(); }

}  // namespace corrsel::core
