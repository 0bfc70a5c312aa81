#pragma once

#include <gtest/gtest.h>

#include <algorithm>
#include <atomic>
#include <cmath>
#include <cstdint>
#include <cstdlib>
#include <exception>
#include <filesystem>
#include <numeric>
#include <opencv2/core.hpp>
#include <string>
#include <utility>
#include <vector>

#include "base/deadline.h"
#include "corrsel/correspondences.h"
#include "corrsel/datasets/reader.h"
#include "corrsel/evaluation/errors.h"
#include "corrsel/evaluation/metrics.h"
#include "corrsel/evaluation/statistics.h"
#include "corrsel/random.h"
#include "corrsel/selectors/factory.h"
#include "kernels/kernels.h"
#include "test_paths.h"

namespace corrsel::core::testing {

/// Returns the message of the exception that `action` throws; empty if it throws none.
template <typename Error = std::exception, typename Action>
std::string errorOf(const Action& action) {
  try {
    action();
  } catch (const Error& error) {
    return error.what();
  }
  return "";
}

/// Whether a message has all of these parts, which a user needs: the name of the input, its value, what is
/// valid.
inline ::testing::AssertionResult mentions(const std::string& message,
                                           const std::vector<std::string>& parts) {
  for (const std::string& part : parts) {
    if (message.find(part) == std::string::npos) {
      return ::testing::AssertionFailure() << "no \"" << part << "\" in: " << message;
    }
  }
  return ::testing::AssertionSuccess();
}

/// Every selector and every preset: "name" or "name:preset".
inline std::vector<std::string> allSpecs() {
  std::vector<std::string> specs;
  for (const std::string& name : selectorNames()) {
    specs.push_back(name);
    for (const std::string& preset : selectorPresets(name)) specs.push_back(name + ":" + preset);
  }
  return specs;
}

/// True in a build with AddressSanitizer, in which the longest tests would take minutes.
#if defined __SANITIZE_ADDRESS__  // GCC
#define CORRSEL_ADDRESS_SANITIZER 1
#elif defined __has_feature  // Clang
#define CORRSEL_ADDRESS_SANITIZER __has_feature(address_sanitizer)
#else
#define CORRSEL_ADDRESS_SANITIZER 0
#endif
#if CORRSEL_ADDRESS_SANITIZER
inline constexpr bool kSanitized = true;
#else
inline constexpr bool kSanitized = false;
#endif

inline bool contains(const std::string& text, const std::string& part) {
  return text.find(part) != std::string::npos;
}

/// Restores the kernel level that was in use, at the end of a test that forces others.
class LevelGuard {
 public:
  ~LevelGuard() { setKernelLevel(before_); }

 private:
  KernelLevel before_ = kernelLevel();
};

/// Replaces the clock of deadlines while the object lives. It advances by the same time whenever it is read,
/// and only then, so the effect of a time limit does not depend on the machine.
class TickingClock : private Clock {
 public:
  explicit TickingClock(double seconds_per_look) : tick_(seconds_per_look) {}
  ~TickingClock() override { setDeadlineClock(before_); }
  TickingClock(const TickingClock&) = delete;
  TickingClock& operator=(const TickingClock&) = delete;

  /// Number of times the clock has been read.
  int looks() const { return looks_; }

 private:
  double seconds() override { return tick_ * looks_++; }

  double tick_;
  std::atomic<int> looks_{0};
  Clock* before_ = setDeadlineClock(this);
};

/// Folder of a real dataset; empty if it does not exist, in which case the test must be skipped.
inline std::string sharedData(const std::string& name) {
  const std::string path = corrsel::testing::realDataDir() + "/" + name;
  return std::filesystem::is_directory(path) ? path : "";
}

/// Generated matches with the mask of the correct ones.
struct Scene {
  Correspondences matches;
  std::vector<std::uint8_t> inlier;
  cv::Matx33d model;  ///< homography or fundamental matrix, px
};

struct SceneOptions {
  std::size_t n = 500;
  double inlier_ratio = 0.6;
  double noise = 0.5;  ///< standard deviation of the right points, px
  std::uint64_t seed = 1;
};

inline constexpr int kSceneWidth = 800, kSceneHeight = 600;

inline cv::Point2d projected(const cv::Matx33d& h, double x, double y) {
  const cv::Vec3d p = h * cv::Vec3d(x, y, 1);
  return {p[0] / p[2], p[1] / p[2]};
}

/// Distance of the right point from the epipolar line of the left one, px.
inline double lineDistance(const cv::Matx33d& f, const cv::Point2d& left, const cv::Point2d& right) {
  const cv::Vec3d line = f * cv::Vec3d(left.x, left.y, 1);
  return std::abs(line.dot(cv::Vec3d(right.x, right.y, 1))) / std::hypot(line[0], line[1]);
}

/// Adds a match with descriptor distances: ratio below 0.6 if it is an inlier, above 0.87 if it is an
/// outlier.
inline void addMatch(Scene& scene, Random& random, const cv::Point2d& left, const cv::Point2d& right,
                     bool inlier) {
  Correspondences& m = scene.matches;
  m.left_x.push_back(static_cast<float>(left.x));
  m.left_y.push_back(static_cast<float>(left.y));
  m.right_x.push_back(static_cast<float>(right.x));
  m.right_y.push_back(static_cast<float>(right.y));
  m.distance.push_back(static_cast<float>(random.uniform(50, 150)));
  m.second_distance.push_back(
      static_cast<float>(inlier ? random.uniform(250, 400) : m.distance.back() * random.uniform(1, 1.15)));
  scene.inlier.push_back(inlier ? 1 : 0);
}

/// A point in [0, width) x [0, height). The order of the two draws is stated in both functions, because
/// compilers evaluate function arguments in different orders.
inline cv::Point2d uniformPoint(Random& random, double width, double height) {
  const double y = random.uniform(0, height);
  const double x = random.uniform(0, width);
  return {x, y};
}

/// A point with standard normal coordinates.
inline cv::Point2d normalPoint(Random& random) {
  const double y = random.normal();
  const double x = random.normal();
  return {x, y};
}

/// Matches of a plane seen by two cameras; outliers end anywhere, but at least 30 px from the truth.
inline Scene homographyScene(const SceneOptions& options = {}) {
  Random random(options.seed);
  Scene scene;
  scene.model = cv::Matx33d(0.9, -0.15, 90, 0.12, 0.95, -20, 1e-4, 5e-5, 1);
  scene.matches.left_size = scene.matches.right_size = {kSceneWidth, kSceneHeight};
  while (scene.inlier.size() < options.n) {
    const cv::Point2d left = uniformPoint(random, kSceneWidth - 1, kSceneHeight - 1);
    const cv::Point2d truth = projected(scene.model, left.x, left.y);
    const bool inlier = scene.inlier.size() < std::round(options.inlier_ratio * double(options.n));
    cv::Point2d right = uniformPoint(random, kSceneWidth - 1, kSceneHeight - 1);
    if (inlier) right = truth + options.noise * normalPoint(random);
    const bool visible =
        right.x >= 0 && right.y >= 0 && right.x <= kSceneWidth - 1 && right.y <= kSceneHeight - 1;
    if (!visible || (!inlier && cv::norm(right - truth) < 30)) continue;
    addMatch(scene, random, left, right, inlier);
  }
  return scene;
}

/// The matrix of both cameras of a stereoScene().
inline cv::Matx33d stereoCamera() { return {700, 0, 400, 0, 700, 300, 0, 0, 1}; }

/// Matches of points in space seen by two cameras; outliers end at least 20 px from the epipolar line.
inline Scene stereoScene(const SceneOptions& options = {}) {
  Random random(options.seed);
  Scene scene;
  const cv::Matx33d camera = stereoCamera();
  const double angle = 0.1;
  const cv::Matx33d rotation(std::cos(angle), 0, std::sin(angle), 0, 1, 0, -std::sin(angle), 0,
                             std::cos(angle));
  const cv::Vec3d shift(-1.0, 0.15, 0.2);
  const cv::Matx33d cross(0, -shift[2], shift[1], shift[2], 0, -shift[0], -shift[1], shift[0], 0);
  scene.model = camera.inv().t() * cross * rotation * camera.inv();
  scene.model *= 1.0 / cv::norm(scene.model);
  scene.matches.left_size = scene.matches.right_size = {kSceneWidth, kSceneHeight};
  while (scene.inlier.size() < options.n) {
    const cv::Point2d left = uniformPoint(random, kSceneWidth - 1, kSceneHeight - 1);
    const cv::Vec3d point = camera.inv() * cv::Vec3d(left.x, left.y, 1) * random.uniform(4, 12);
    const cv::Vec3d seen = camera * (rotation * point + shift);
    const bool inlier = scene.inlier.size() < std::round(options.inlier_ratio * double(options.n));
    cv::Point2d right = uniformPoint(random, kSceneWidth - 1, kSceneHeight - 1);
    if (inlier) {
      right = cv::Point2d(seen[0] / seen[2], seen[1] / seen[2]) + options.noise * normalPoint(random);
    }
    const bool visible =
        right.x >= 0 && right.y >= 0 && right.x <= kSceneWidth - 1 && right.y <= kSceneHeight - 1;
    if (!visible || (!inlier && lineDistance(scene.model, left, right) < 20)) continue;
    addMatch(scene, random, left, right, inlier);
  }
  return scene;
}

/// Gives a stereoScene() its cameras.
inline void addStereoCameras(Scene& scene) {
  Camera camera;
  camera.matrix = stereoCamera();
  camera.size = scene.matches.left_size;
  scene.matches.left_camera = scene.matches.right_camera = camera;
}

/// Whether a selector does nothing without the cameras of both images.
inline bool needsCameras(const Selector& selector) {
  const std::vector<std::string> needed = neededInput(selector);
  return std::find(needed.begin(), needed.end(), "left_camera") != needed.end();
}

/// Gives every match of a homographyScene() local frames: inliers the derivative of the homography with
/// `noise` added to each element, outliers a random turn, scale (0.5 to 2) and stretch (up to 1.5).
inline void addFrames(Scene& scene, double noise = 0.05, std::uint64_t seed = 1) {
  Random random(seed);
  Correspondences& m = scene.matches;
  const auto rotation = [](double angle) {
    return cv::Matx22d(std::cos(angle), -std::sin(angle), std::sin(angle), std::cos(angle));
  };
  for (std::size_t i = 0; i < m.size(); ++i) {
    const cv::Matx33d& h = scene.model;
    const cv::Point2d to = projected(h, m.left_x[i], m.left_y[i]);
    const double w = h(2, 0) * m.left_x[i] + h(2, 1) * m.left_y[i] + h(2, 2);
    cv::Matx22d map((h(0, 0) - to.x * h(2, 0)) / w, (h(0, 1) - to.x * h(2, 1)) / w,
                    (h(1, 0) - to.y * h(2, 0)) / w, (h(1, 1) - to.y * h(2, 1)) / w);
    if (!scene.inlier[i]) {
      const double scale = std::exp2(random.uniform(-1, 1)), stretch = random.uniform(1, 1.5);
      const cv::Matx22d axes(scale * stretch, 0, 0, scale / stretch);
      const cv::Matx22d first = rotation(random.uniform(0, 2 * CV_PI));
      const cv::Matx22d last = rotation(random.uniform(0, 2 * CV_PI));
      map = last * axes * first;
    }
    for (double& value : map.val) value += noise * random.normal();
    // The choice of the left frame does not matter.
    const cv::Matx22d turn = rotation(random.uniform(0, 2 * CV_PI));
    const cv::Matx22d left = random.uniform(2, 10) * turn;
    const cv::Matx22d right = map * left;
    m.left_frame.push_back({float(left(0, 0)), float(left(0, 1)), m.left_x[i], float(left(1, 0)),
                            float(left(1, 1)), m.left_y[i]});
    m.right_frame.push_back({float(right(0, 0)), float(right(0, 1)), m.right_x[i], float(right(1, 0)),
                             float(right(1, 1)), m.right_y[i]});
  }
}

/// The numbers 0 .. n-1 in random order.
inline std::vector<std::uint32_t> permutation(std::size_t n, std::uint64_t seed) {
  Random random(seed);
  std::vector<std::uint32_t> order(n);
  std::iota(order.begin(), order.end(), 0U);
  for (std::size_t i = n; i > 1; --i) std::swap(order[i - 1], order[random.index(std::uint32_t(i))]);
  return order;
}

/// A column's elements in the order given by `order`.
template <typename T>
std::vector<T> reordered(const std::vector<T>& column, const std::vector<std::uint32_t>& order) {
  std::vector<T> result;
  for (const std::uint32_t i : order) result.push_back(column[i]);
  return result;
}

/// Precision, recall and F in percent.
struct Quality {
  double precision = 0, recall = 0, f = 0;
};

inline Quality quality(const std::vector<std::uint8_t>& mask, const std::vector<std::uint8_t>& inlier) {
  double selected = 0, inliers = 0, both = 0;
  for (std::size_t i = 0; i < mask.size(); ++i) {
    selected += mask[i];
    inliers += inlier[i];
    both += mask[i] && inlier[i] ? 1 : 0;
  }
  return {100 * both / selected, 100 * both / inliers, 200 * both / (selected + inliers)};
}

/// A pair of AdelaideRMF without its images.
struct LabelledPair {
  std::string name;
  Correspondences matches;
  GroundTruth truth;
};

/// The pairs of AdelaideRMF, read once; empty if the dataset is missing.
inline const std::vector<LabelledPair>& adelaidePairs() {
  static const std::vector<LabelledPair> pairs = [] {
    std::vector<LabelledPair> read;
    const std::string folder = sharedData("adelaidermf");
    if (folder.empty()) return read;
    const auto reader = openDataset("adelaidermf", folder);
    for (std::size_t i = 0; i < reader->size(); ++i) {
      ImagePair pair = reader->read(i);
      read.push_back({pair.id.sequence, *pair.given, pair.truth});
    }
    return read;
  }();
  return pairs;
}

/// Means over AdelaideRMF of the per-pair values, in percent.
inline Quality adelaideMeans(const std::string& spec, const OptionMap& options = {}) {
  const auto selector = createSelector(spec, options);
  std::vector<double> precision, recall, f;
  for (const LabelledPair& pair : adelaidePairs()) {
    const Evaluation evaluation = evaluate(TruthKind::kLabels, groundTruthErrors(pair.truth, pair.matches),
                                           selector->select(pair.matches).mask);
    precision.push_back(100 * evaluation.metrics[0].precision);
    recall.push_back(100 * evaluation.metrics[0].recall_paper);
    f.push_back(100 * evaluation.metrics[0].f_paper);
  }
  return {mean(precision), mean(recall), mean(f)};
}

}  // namespace corrsel::core::testing
