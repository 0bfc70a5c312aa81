#include "datasets/posed_pairs.h"

#include <map>
#include <opencv2/core.hpp>
#include <set>
#include <stdexcept>

#include "base/text.h"
#include "datasets/dataset_report.h"
#include "datasets/files.h"
#include "datasets/posed_truth.h"

namespace corrsel::core {
namespace {

/// From pixels of an image to pixels of the image after it was turned by a quarter counter-clockwise.
cv::Matx33d turnedPixels(const cv::Size& size) { return {0, 1, 0, -1, 0, size.width - 1.0, 0, 0, 1}; }

/// The same for the frame of the camera.
const cv::Matx33d kTurnedFrame(0, 1, 0, -1, 0, 0, 0, 0, 1);

/// One image of a pair after all that is done to it.
struct Prepared {
  cv::Mat image;
  Camera camera;     ///< of this image
  RigidMotion turn;  ///< from the frame of the camera to that of the image
};

Prepared prepared(const PosedImage& posed, const cv::Mat& stored) {
  Prepared result;
  try {
    result.image = posed.lens->undistorted(stored);
  } catch (const std::invalid_argument& error) {
    throw DatasetError(posed.path + ": " + error.what() +
                       "; give the image in the size for which its camera was calibrated");
  }
  result.camera = posed.lens->camera();
  result.camera.size = result.image.size();
  for (int turn = 0; turn < posed.quarter_turns; ++turn) {
    result.camera.matrix = turnedPixels(result.image.size()) * result.camera.matrix * kTurnedFrame.t();
    cv::rotate(result.image, result.image, cv::ROTATE_90_COUNTERCLOCKWISE);
    result.camera.size = result.image.size();
    result.turn.rotation = kTurnedFrame * result.turn.rotation;
  }
  return result;
}

/// Whether the image is another one than the stored one.
bool isChanged(const PosedImage& image) { return image.lens->distorted() || image.quarter_turns != 0; }

}  // namespace

PosedPairReader::PosedPairReader(PosedDataset dataset, std::string root)
    : dataset_(std::move(dataset)), root_(std::move(root)) {
  std::map<PairId, int> used;
  for (PosedPair& pair : dataset_.pairs) {
    const int number = ++used[pair.id];
    if (number > 1) pair.id.pair += "#" + std::to_string(number);
  }
}

const PosedPair& PosedPairReader::usable(std::size_t index) const {
  const PosedPair& pair = dataset_.pairs.at(index);
  if (!pair.fault.empty()) throw DatasetError(pair.fault);
  return pair;
}

ImagePair PosedPairReader::read(std::size_t index) const {
  const PosedPair& posed = usable(index);
  ImagePair pair;
  pair.id = posed.id;
  readImages(root_, posed.left.path, posed.right.path, dataset_.remedy, pair);
  if (isChanged(posed.left)) pair.left_name.clear();
  if (isChanged(posed.right)) pair.right_name.clear();
  const Prepared left = prepared(posed.left, pair.left), right = prepared(posed.right, pair.right);
  pair.left = left.image;
  pair.right = right.image;
  const RigidMotion motion = right.turn * posed.motion * left.turn.inverse();
  pair.left_camera = left.camera;
  pair.right_camera = right.camera;
  RelativePose pose;
  pose.rotation = motion.rotation;
  pose.translation = motion.translation;
  pair.truth = truthOf(pose, left.camera, right.camera);
  return pair;
}

void PosedPairReader::check(std::size_t index) const {
  const PosedPair& posed = usable(index);
  requireImageFile(posed.left.path, dataset_.remedy);
  requireImageFile(posed.right.path, dataset_.remedy);
}

std::vector<std::string> PosedPairReader::files() const {
  std::set<std::string> images;
  for (const PosedPair& pair : dataset_.pairs) {
    if (!pair.fault.empty()) continue;
    images.insert(pair.left.path);
    images.insert(pair.right.path);
  }
  std::vector<std::string> paths = dataset_.files;
  paths.insert(paths.end(), images.begin(), images.end());
  return existingFiles(paths);
}

std::vector<std::string> sequenceFolders(const std::string& root,
                                         bool (*is_sequence)(const std::string& folder),
                                         std::vector<std::string>* ignored) {
  if (is_sequence(root)) return {root};
  std::vector<std::string> folders;
  for (const std::string& folder : subfolders(root)) {
    if (is_sequence(below(root, folder))) {
      folders.push_back(below(root, folder));
    } else if (ignored != nullptr) {
      ignored->push_back(folder);
    }
  }
  return folders;
}

void addSteps(const std::string& name, const std::string& sequence, const std::vector<PosedFrame>& frames,
              const PairChoice& choice, PosedDataset& dataset) {
  const auto step = static_cast<std::size_t>(choice.step);
  std::vector<PosedPair> pairs;
  std::size_t without_pose = 0, too_near = 0;
  for (std::size_t i = 0; i + step < frames.size(); ++i) {
    const PosedFrame &left = frames[i], &right = frames[i + step];
    if (!left.known || !right.known) {
      ++without_pose;
      continue;
    }
    PosedPair pair;
    pair.motion = right.pose.inverse() * left.pose;
    if (cv::norm(pair.motion.translation) < choice.min_baseline) {
      ++too_near;
      continue;
    }
    pair.id = {name, sequence, left.name + "-" + right.name};
    pair.left = left.image;
    pair.right = right.image;
    pairs.push_back(std::move(pair));
  }
  const std::size_t found = pairs.size();
  for (const std::size_t i : evenlySpaced(found, static_cast<std::size_t>(choice.max_pairs))) {
    dataset.pairs.push_back(std::move(pairs[i]));
  }
  const std::size_t all = frames.size() > step ? frames.size() - step : 0;
  std::string remark =
      sequence + ": of the " + std::to_string(all) + " pairs of its " + std::to_string(frames.size()) +
      " images that are " + std::to_string(choice.step) + " frames apart, " +
      std::to_string(std::min(found, static_cast<std::size_t>(choice.max_pairs))) + " are used";
  if (without_pose > 0) {
    remark += ", " + std::to_string(without_pose) + " are left out because an image has no pose within " +
              formatNumber(choice.max_gap) + " s before and after it";
  }
  if (too_near > 0) {
    remark += ", " + std::to_string(too_near) + " are left out because their baseline is below " +
              formatNumber(choice.min_baseline) + " m";
  }
  dataset.remarks.push_back(remark + " (step, max_pairs, max_gap, min_baseline in " +
                            std::string(PairChoice::kFile) + ")");
}

PosedDataset readSequences(const std::string& name, const std::string& root, const SequenceFormat& format) {
  requireFolder(root, "dataset '" + name + "'", "set the path to the folder that holds " + format.content);
  const PairChoice choice = readPairChoice(root);
  PosedDataset dataset;
  dataset.remedy = format.remedy;
  dataset.files = {below(root, PairChoice::kFile)};
  for (const std::string& folder : sequenceFolders(root, format.is_sequence, &dataset.ignored)) {
    const std::vector<std::string> files = format.files(folder);
    dataset.files.insert(dataset.files.end(), files.begin(), files.end());
    try {
      format.add(name, folder, choice, dataset);
    } catch (const DatasetError& error) {
      dataset.addBroken(name, folderName(folder), error.what());
    }
  }
  if (dataset.pairs.empty() && !dataset.remarks.empty()) {
    failWithoutPairs(name, root, joinList(dataset.remarks, "; "));
  }
  return dataset;
}

void failWithoutPairs(const std::string& name, const std::string& root, const std::string& why) {
  throw DatasetError("dataset '" + name + "': '" + root + "' gives no pair: " + why);
}

}  // namespace corrsel::core
