#include "datasets/heinly_generated.h"

#include <cmath>
#include <filesystem>
#include <stdexcept>

#include "datasets/files.h"
#include "datasets/generator.h"

namespace corrsel::core {
namespace {

namespace fs = std::filesystem;

struct Scene {
  const char* name;
  const char* photograph;
  bool zoom;  // else rotation
  int pairs;
};

// Distant views need photographs of high resolution.
constexpr Scene kScenes[] = {
    {"zoom_1", "scenetext03.jpg", true, 7},
    {"zoom_2", "scenetext04.jpg", true, 7},
    {"rotation_1", "aero1.jpg", false, 7},
    {"rotation_2", "building.jpg", false, 8},
};

constexpr double kMaxZoom = 4.0;  // size left / size right

/// Scene of a pair, and the pair's place in it (0-based).
struct Place {
  const Scene& scene;
  int strength;
};

Place placeOf(std::size_t index) {
  std::size_t first = 0;
  for (const Scene& scene : kScenes) {
    const std::size_t end = first + static_cast<std::size_t>(scene.pairs);
    if (index < end) return {scene, static_cast<int>(index - first)};
    first = end;
  }
  throw std::out_of_range("heinly_generated dataset: no pair " + std::to_string(index));
}

/// Zooms end at the largest one; rotations leave out the full turn.
cv::Matx33d homographyOf(const Place& place, const cv::Size& size) {
  const double step = place.strength + 1.0;
  if (place.scene.zoom) return similarity(std::pow(kMaxZoom, step / place.scene.pairs), 0.0, size);
  return similarity(1.0, 360.0 * step / (place.scene.pairs + 1), size);
}

std::string photographPath(const std::string& root, const Scene& scene) {
  return (fs::path(root) / scene.photograph).string();
}

}  // namespace

HeinlyGeneratedReader::HeinlyGeneratedReader(const std::string& root, int seed) : root_(root), seed_(seed) {
  requireFolder(root, "dataset 'heinly_generated'", kSampleRemedy);
  if (HeinlyGeneratedReader::files().empty()) {
    throw DatasetError("dataset 'heinly_generated': '" + root + "' has none of the photographs; " +
                       kSampleRemedy);
  }
}

std::size_t HeinlyGeneratedReader::size() const {
  std::size_t pairs = 0;
  for (const Scene& scene : kScenes) pairs += static_cast<std::size_t>(scene.pairs);
  return pairs;
}

PairId HeinlyGeneratedReader::id(std::size_t index) const {
  const Place place = placeOf(index);
  return {"heinly_generated", place.scene.name, "0-" + std::to_string(place.strength + 1)};
}

ImagePair HeinlyGeneratedReader::read(std::size_t index) const {
  const Place place = placeOf(index);
  ImagePair pair;
  pair.id = id(index);
  const cv::Mat photograph = readImageFile(photographPath(root_, place.scene), kSampleRemedy);
  pair.truth.kind = TruthKind::kHomography;
  pair.truth.matrix = homographyOf(place, photograph.size());
  pair.left = antialiased(photograph, pair.truth.matrix);
  pair.right = warp(pair.left, pair.truth.matrix);
  Random random = engineOf(seed_, place.scene.name, place.strength);
  addNoise(pair.right, random);
  return pair;
}

void HeinlyGeneratedReader::check(std::size_t index) const {
  requireImageFile(photographPath(root_, placeOf(index).scene), kSampleRemedy);
}

std::vector<std::string> HeinlyGeneratedReader::files() const {
  std::vector<std::string> paths;
  for (const Scene& scene : kScenes) paths.push_back(photographPath(root_, scene));
  return existingFiles(paths);
}

}  // namespace corrsel::core
