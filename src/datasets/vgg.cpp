#include "corrsel/datasets/vgg.h"

#include <algorithm>
#include <filesystem>

#include "corrsel/datasets/files.h"

namespace corrsel::core {
namespace {

namespace fs = std::filesystem;

constexpr int kPairsPerScene = 5;
constexpr const char* kExtensions[] = {".ppm", ".pgm", ".png", ".jpg"};
constexpr const char* kRemedy = "unpack the scene again (https://www.robots.ox.ac.uk/~vgg/research/affine/)";

/// Number of the right image of a pair, 2 to 6.
int rightNumber(std::size_t index) { return 2 + static_cast<int>(index % kPairsPerScene); }

std::vector<std::string> imageCandidates(const std::string& scene, int number) {
  std::vector<std::string> paths;
  for (const char* extension : kExtensions) {
    paths.push_back(scene + "/img" + std::to_string(number) + extension);
  }
  return paths;
}

std::string homographyPath(const std::string& scene, int number) {
  return scene + "/H1to" + std::to_string(number) + "p";
}

std::vector<std::string> sceneFiles(const std::string& scene) {
  std::vector<std::string> paths;
  for (int number = 1; number <= kPairsPerScene + 1; ++number) {
    const std::vector<std::string> images = existingFiles(imageCandidates(scene, number));
    if (!images.empty()) paths.push_back(images.front());
    const std::vector<std::string> homography = existingFiles({homographyPath(scene, number)});
    if (number > 1) paths.insert(paths.end(), homography.begin(), homography.end());
  }
  return paths;
}

cv::Mat readImage(const std::string& scene, int number) {
  const std::vector<std::string> images = existingFiles(imageCandidates(scene, number));
  if (images.empty()) {
    throw DatasetError(scene + "/img" + std::to_string(number) +
                       ": the image is missing (tried .ppm, .pgm, .png, .jpg); " + kRemedy);
  }
  return readImageFile(images.front(), kRemedy);
}

}  // namespace

VggReader::VggReader(const std::string& root) : root_(root) {
  requireFolder(root, "VGG dataset", "set the path to the folder that holds the scenes' folders");
  for (const fs::directory_entry& entry : fs::directory_iterator(root)) {
    if (entry.is_directory() && !sceneFiles(entry.path().string()).empty()) {
      scenes_.push_back(entry.path().filename().string());
    }
  }
  if (scenes_.empty()) {
    throw DatasetError(
        "VGG dataset: '" + root +
        "' has no subfolder with img1..img6 or H1to2p..H1to6p; set the path to the folder that "
        "holds the scenes' folders");
  }
  std::sort(scenes_.begin(), scenes_.end());
}

std::size_t VggReader::size() const { return scenes_.size() * kPairsPerScene; }

PairId VggReader::id(std::size_t index) const {
  return {"vgg", scenes_.at(index / kPairsPerScene), "1-" + std::to_string(rightNumber(index))};
}

ImagePair VggReader::read(std::size_t index) const {
  ImagePair pair;
  pair.id = id(index);
  const std::string scene = scenePath(index);
  pair.left = readImage(scene, 1);
  pair.right = readImage(scene, rightNumber(index));
  pair.truth.kind = TruthKind::kHomography;
  pair.truth.matrix = readHomographyFile(homographyPath(scene, rightNumber(index)), kRemedy);
  return pair;
}

std::vector<std::string> VggReader::files() const {
  std::vector<std::string> paths;
  for (const std::string& scene : scenes_) {
    const std::vector<std::string> of_scene = sceneFiles((fs::path(root_) / scene).string());
    paths.insert(paths.end(), of_scene.begin(), of_scene.end());
  }
  return paths;
}

std::string VggReader::scenePath(std::size_t index) const {
  return (fs::path(root_) / scenes_.at(index / kPairsPerScene)).string();
}

}  // namespace corrsel::core
