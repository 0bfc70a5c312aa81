#include "datasets/colmap.h"

#include <algorithm>
#include <filesystem>
#include <map>
#include <opencv2/core.hpp>
#include <stdexcept>

#include "base/text.h"
#include "datasets/colmap_model.h"
#include "datasets/dataset_report.h"
#include "datasets/files.h"

namespace corrsel::core {
namespace {

namespace fs = std::filesystem;

constexpr char kImages[] = "images";

/// The folder of the model of a scene; empty where it has none.
std::string modelFolder(const std::string& scene) {
  for (const std::string& folder : {below(scene, "sparse/0"), below(scene, "sparse"), scene}) {
    if (hasColmapModel(folder)) return folder;
  }
  return "";
}

bool isScene(const std::string& folder) { return !modelFolder(folder).empty(); }

Lens lensOf(const ColmapModelCamera& camera) {
  try {
    return Lens("camera " + std::to_string(camera.id), cameraFromColmap(camera.camera));
  } catch (const std::invalid_argument& error) {
    throw DatasetError(camera.place + ": " + error.what() +
                       "; colmap image_undistorter makes images of the model PINHOLE");
  }
}

/// Two images, by index, and the number of points that both see.
struct Candidate {
  std::size_t left, right, points;
};

/// Pairs with enough common points, those with the most first.
std::vector<Candidate> candidatesOf(const std::vector<ColmapImage>& images, std::size_t min_points) {
  std::map<std::int64_t, std::vector<std::size_t>> seen_by;  // images by point, ascending
  for (std::size_t i = 0; i < images.size(); ++i) {
    for (const std::int64_t point : images[i].points) seen_by[point].push_back(i);
  }
  std::vector<Candidate> candidates;
  std::vector<std::size_t> common(images.size());
  for (std::size_t i = 0; i < images.size(); ++i) {
    std::fill(common.begin(), common.end(), 0);
    for (const std::int64_t point : images[i].points) {
      const std::vector<std::size_t>& others = seen_by[point];
      for (auto other = std::upper_bound(others.begin(), others.end(), i); other != others.end(); ++other) {
        ++common[*other];
      }
    }
    for (std::size_t j = i + 1; j < images.size(); ++j) {
      if (common[j] >= min_points) candidates.push_back({i, j, common[j]});
    }
  }
  std::stable_sort(candidates.begin(), candidates.end(),
                   [](const Candidate& a, const Candidate& b) { return a.points > b.points; });
  return candidates;
}

/// From the frame of one image to that of another one.
/// @param left, right  from the world's frame to theirs
RigidMotion motionBetween(const RigidMotion& left, const RigidMotion& right) {
  RigidMotion motion = right * left.inverse();
  // Images from one place, such as views of a panorama: a rounding error must not become a direction.
  constexpr double kRounding = 1e-9;
  const double distance = cv::norm(left.translation) + cv::norm(right.translation);
  if (cv::norm(motion.translation) <= kRounding * distance) motion.translation = {};
  return motion;
}

/// "a_b" for "a/b.jpg"
std::string pairName(const std::string& image) {
  std::string name = fs::path(image).replace_extension().string();
  std::replace(name.begin(), name.end(), '/', '_');
  return name;
}

/// The lenses of a model's cameras. They are made for the images that are used: a model may have thousands
/// of cameras, and a lens with distortion takes milliseconds.
class Lenses {
 public:
  explicit Lenses(const std::vector<ColmapModelCamera>& cameras) {
    for (const ColmapModelCamera& camera : cameras) cameras_.emplace(camera.id, camera);
  }

  /// Throws DatasetError.
  std::shared_ptr<const Lens> of(const ColmapImage& image) {
    const auto camera = cameras_.find(image.camera);
    if (camera == cameras_.end()) {
      throw DatasetError(image.place + ": the image " + image.name + " has the camera " +
                         std::to_string(image.camera) + ", which the model does not list");
    }
    std::shared_ptr<const Lens>& lens = lenses_[image.camera];
    if (lens == nullptr) lens = std::make_shared<const Lens>(lensOf(camera->second));
    return lens;
  }

 private:
  std::map<std::int64_t, ColmapModelCamera> cameras_;
  std::map<std::int64_t, std::shared_ptr<const Lens>> lenses_;
};

void addScene(const std::string& name, const std::string& scene, const PairChoice& choice,
              PosedDataset& dataset) {
  const std::string sequence = folderName(scene);
  ColmapModel model = readColmapModel(modelFolder(scene));
  std::vector<ColmapImage>& images = model.images;
  std::sort(images.begin(), images.end(),
            [](const ColmapImage& a, const ColmapImage& b) { return a.name < b.name; });
  Lenses lenses(model.cameras);
  const auto max_pairs = static_cast<std::size_t>(choice.max_pairs);
  const std::vector<Candidate> candidates = candidatesOf(images, static_cast<std::size_t>(choice.min_points));
  std::vector<PosedPair> pairs;
  std::map<std::shared_ptr<const Lens>, std::size_t> undistorted;  // images that are used
  for (const std::size_t i : evenlySpaced(candidates.size(), max_pairs)) {
    const ColmapImage &left = images[candidates[i].left], &right = images[candidates[i].right];
    PosedPair pair;
    pair.id = {name, sequence, pairName(left.name) + "-" + pairName(right.name)};
    try {
      pair.left = {below(below(scene, kImages), left.name), lenses.of(left)};
      pair.right = {below(below(scene, kImages), right.name), lenses.of(right)};
      for (const PosedImage& image : {pair.left, pair.right}) {
        if (image.lens->distorted()) ++undistorted[image.lens];
      }
    } catch (const DatasetError& error) {
      pair.fault = error.what();
    }
    pair.motion = motionBetween(left.pose, right.pose);
    pairs.push_back(std::move(pair));
  }
  std::sort(pairs.begin(), pairs.end(), [](const PosedPair& a, const PosedPair& b) { return a.id < b.id; });
  std::move(pairs.begin(), pairs.end(), std::back_inserter(dataset.pairs));
  dataset.remarks.push_back(
      sequence + ": " + std::to_string(std::min(max_pairs, candidates.size())) + " of the " +
      std::to_string(candidates.size()) + " pairs of its " + std::to_string(images.size()) +
      " images that see at least " + std::to_string(choice.min_points) +
      " common points are used (min_points, max_pairs in " + std::string(PairChoice::kFile) + ")");
  std::vector<std::string> texts;
  for (const auto& used : undistorted) texts.push_back(used.first->text());
  std::sort(texts.begin(), texts.end());
  if (!texts.empty()) {
    dataset.remarks.push_back(sequence + ": " + texts.front() +
                              (texts.size() > 1 ? "; those of " + std::to_string(texts.size() - 1) +
                                                      " more cameras are undistorted likewise"
                                                : ""));
  }
}

std::vector<std::string> filesOf(const std::string& scene) { return colmapFiles(modelFolder(scene)); }

}  // namespace

PosedDataset readColmap(const std::string& name, const std::string& root) {
  return readSequences(name, root,
                       {"the scenes",
                        "the images of a model lie in the folder 'images' of its scene, under the names that "
                        "the model has for them",
                        isScene, filesOf, addScene});
}

bool hasColmap(const std::string& root) { return !sequenceFolders(root, isScene).empty(); }

}  // namespace corrsel::core
