#include "datasets/calibrated_generated.h"

#include <algorithm>
#include <iterator>
#include <stdexcept>

#include "base/checksum.h"
#include "corrsel/datasets/calibrated_scene.h"
#include "datasets/posed_truth.h"

namespace corrsel::core {
namespace {

struct Dataset {
  const char* name;
  double inlier_ratio;
};
constexpr Dataset kDatasets[] = {
    {"calibrated30_generated", 0.3}, {"calibrated70_generated", 0.7}, {"calibrated95_generated", 0.95}};

struct NamedCamera {
  const char* name;
  Camera (*make)();
};
constexpr NamedCamera kCameras[] = {{"pinhole", scenePinhole},
                                    {"rational", sceneRational},
                                    {"fisheye", sceneFisheye},
                                    {"equirectangular", scenePanorama}};
constexpr SceneMotion kMotions[] = {SceneMotion::kRest, SceneMotion::kRotation, SceneMotion::kGeneral,
                                    SceneMotion::kForward, SceneMotion::kPlane};
constexpr std::size_t kScenes = 25;  // of a camera and a motion

const Dataset* find(const std::string& name) {
  const auto* const found = std::find_if(std::begin(kDatasets), std::end(kDatasets),
                                         [&name](const Dataset& known) { return name == known.name; });
  return found == std::end(kDatasets) ? nullptr : found;
}

struct Place {
  const NamedCamera& camera;
  SceneMotion motion;
  std::size_t number;  ///< from 1
};

Place placeOf(std::size_t index) {
  const std::size_t sequence = index / kScenes;
  return {kCameras[sequence / std::size(kMotions)], kMotions[sequence % std::size(kMotions)],
          index % kScenes + 1};
}

}  // namespace

bool CalibratedGeneratedReader::isName(const std::string& name) { return find(name) != nullptr; }

CalibratedGeneratedReader::CalibratedGeneratedReader(const std::string& name, int seed)
    : name_(name), seed_(seed) {
  const Dataset* const dataset = find(name);
  if (dataset == nullptr) throw std::invalid_argument("'" + name + "' is no dataset of generated matches");
  inlier_ratio_ = dataset->inlier_ratio;
}

std::size_t CalibratedGeneratedReader::size() const {
  return std::size(kCameras) * std::size(kMotions) * kScenes;
}

PairId CalibratedGeneratedReader::id(std::size_t index) const {
  if (index >= size()) throw std::out_of_range(name_ + ": no pair " + std::to_string(index));
  const Place place = placeOf(index);
  return {name_, std::string(place.camera.name) + "_" + toString(place.motion), std::to_string(place.number)};
}

ImagePair CalibratedGeneratedReader::read(std::size_t index) const {
  ImagePair pair;
  pair.id = id(index);
  const Place place = placeOf(index);
  Checksum checksum;
  checksum.add(std::to_string(seed_) + "/" + pair.id.text());
  CalibratedSceneSpec spec;
  spec.left_camera = spec.right_camera = place.camera.make();
  spec.motion = place.motion;
  spec.inlier_ratio = inlier_ratio_;
  spec.seed = checksum.value();
  CalibratedScene scene = makeCalibratedScene(spec);
  pair.left_camera = spec.left_camera;
  pair.right_camera = spec.right_camera;
  pair.truth = truthOf(scene.pose, spec.left_camera, spec.right_camera);
  pair.given = std::move(scene.matches);
  return pair;
}

}  // namespace corrsel::core
