#include "benchmark/dataset_check.h"

#include <cmath>
#include <functional>
#include <map>
#include <opencv2/core/types.hpp>
#include <utility>

#include "base/size_text.h"
#include "base/text.h"
#include "benchmark/feature_cache.h"
#include "corrsel/features/extractor.h"
#include "corrsel/matching/matcher.h"
#include "geometry/homography.h"

namespace corrsel::core {
namespace {

constexpr char kFeatures[] = "orb+orb";
// As many as are needed to find 25 correct matches of a hard pair, and few enough for some seconds in total.
const AlgorithmOptions kOptions = {{"orb", {{"max_features", "1000"}, {"max_megapixels", "1"}}}};
constexpr std::size_t kCacheBytes = std::size_t{64} << 20U;

constexpr double kMinShare = 0.05;  // of the left image that the ground truth maps into the right one
// With fewer images that agree, nobody knows which of them is the odd one.
constexpr std::size_t kAgreeing = 3;

/// Share of the points of a grid over the image for which a condition holds.
double shareOf(const cv::Size& image, const std::function<bool(double x, double y)>& holds) {
  constexpr int kSteps = 40;
  int count = 0;
  for (int row = 0; row < kSteps; ++row) {
    for (int column = 0; column < kSteps; ++column) {
      count += holds((column + 0.5) / kSteps * image.width, (row + 0.5) / kSteps * image.height) ? 1 : 0;
    }
  }
  return static_cast<double>(count) / (kSteps * kSteps);
}

double shareMappedInto(const cv::Matx33d& homography, const cv::Size& left, const cv::Size& right) {
  const cv::Matx33d h = inFront(homography, left.width / 2.0, left.height / 2.0);
  return shareOf(left, [&](double x, double y) {
    const cv::Vec3d mapped = h * cv::Vec3d(x, y, 1);
    return mapped[2] > 0 && mapped[0] >= 0 && mapped[0] < right.width * mapped[2] && mapped[1] >= 0 &&
           mapped[1] < right.height * mapped[2];
  });
}

double shareOfCrossingLines(const cv::Matx33d& fundamental, const cv::Size& left, const cv::Size& right) {
  return shareOf(left, [&](double x, double y) {
    const cv::Vec3d line = fundamental * cv::Vec3d(x, y, 1);
    bool above = false, below = false;
    for (const double corner_x : {0.0, static_cast<double>(right.width)}) {
      for (const double corner_y : {0.0, static_cast<double>(right.height)}) {
        (line[0] * corner_x + line[1] * corner_y + line[2] > 0 ? above : below) = true;
      }
    }
    return above && below;
  });
}

/// What is odd about the sizes of a pair by itself; empty: nothing.
std::string oddity(const ImagePair& pair) {
  const GroundTruth& truth = pair.truth;
  const cv::Size left = pair.left.size(), right = pair.right.size();
  const std::string sizes = "the images have " + sizeText(left) + " and " + sizeText(right) + " px";
  const auto percent = [](double share) { return formatNumber(std::round(1000 * share) / 10) + " %"; };
  if (truth.kind == TruthKind::kHomography) {
    const double share = shareMappedInto(truth.matrix, left, right);
    if (share < kMinShare) {
      return "the homography maps " + percent(share) + " of the left image into the right one (" + sizes +
             "); the images or the homography are of another pair, or the images have been scaled";
    }
  }
  if (truth.kind == TruthKind::kFundamental) {
    const double share = shareOfCrossingLines(truth.matrix, left, right);
    if (share < kMinShare) {
      return "the epipolar lines of " + percent(share) + " of the left image cross the right one (" + sizes +
             "); the images or the matrix are of another pair, or the images have been scaled";
    }
  }
  if (truth.kind == TruthKind::kDisparity && truth.disparity.size() != left) {
    return "the disparities have " + sizeText(truth.disparity.size()) + " px, and the left image has " +
           sizeText(left) + " px; give one disparity per pixel of the left image";
  }
  if (!truth.pose) return "";
  const struct {
    const char* side;
    const cv::Matx33d& camera;
    cv::Size size;
  } cameras[] = {{"left", truth.pose->left_camera, left}, {"right", truth.pose->right_camera, right}};
  for (const auto& [side, camera, size] : cameras) {
    const double x = camera(0, 2), y = camera(1, 2);
    if (x >= 0 && x < size.width && y >= 0 && y < size.height) continue;
    return std::string("the principal point of the ") + side + " camera, (" + formatNumber(x) + ", " +
           formatNumber(y) + "), lies outside of its image of " + sizeText(size) +
           " px; the calibration is probably of images of another size";
  }
  return "";
}

/// The left or the right images of a sequence by their sizes.
struct SequenceSizes {
  struct Images {
    std::size_t count = 0;
    PairId first;
  };
  std::map<std::pair<int, int>, Images> images;  ///< by width and height

  void add(const PairId& id, const cv::Size& size) {
    Images& same = images[{size.width, size.height}];
    if (same.count++ == 0) same.first = id;
  }

  /// The sentence about the only image that has another size; empty where there is no such image.
  std::string odd(const std::string& side) const {
    if (images.size() != 2) return "";
    const bool first_is_odd = images.begin()->second.count == 1;
    const auto &one = first_is_odd ? *images.begin() : *images.rbegin(),
               &others = first_is_odd ? *images.rbegin() : *images.begin();
    if (one.second.count != 1 || others.second.count < kAgreeing) return "";
    const auto sizeOf = [](const auto& entry) { return sizeText({entry.first.first, entry.first.second}); };
    return one.second.first.text() + ": the " + side + " image has " + sizeOf(one) + " px, and the " + side +
           " images of the other pairs of the sequence have " + sizeOf(others) +
           " px; it is probably scaled or of another sequence";
  }
};

}  // namespace

struct PairInspector::Tools {
  std::unique_ptr<FeatureExtractor> extractor = createExtractor(kFeatures, kOptions);
  FeatureCache cache{kCacheBytes};
  MatchOptions match;
  std::map<std::pair<std::string, std::string>, SequenceSizes> sizes;  ///< by "dataset/sequence" and side
};

PairInspector::PairInspector(int threads) : tools_(std::make_unique<Tools>()), threads_(threads) {
  tools_->match.mutual = true;
}

PairInspector::PairInspector(PairInspector&&) noexcept = default;
PairInspector::~PairInspector() = default;

void PairInspector::add(const ImagePair& pair) {
  if (!pair.left.empty() && !pair.right.empty()) addSizes(pair);
  if (pair.truth.kind == TruthKind::kNone || pair.truth.kind == TruthKind::kLabels) return;
  Correspondences found;
  if (!pair.given) {
    const auto [left, right] = tools_->cache.extractPair(*tools_->extractor, pair.left, pair.right, threads_);
    found = matchFeatures(*left, *right, tools_->match, threads_);
  }
  Correspondences matches = pair.given ? *pair.given : found;
  pair.addCamerasTo(matches);
  for (TruthCheck check : checkTruth(pair.truth, pair.other_readings, matches)) {
    check.id = pair.id;
    check.features = pair.given ? kGivenFeatures : kFeatures;
    checks_.push_back(check);
  }
}

void PairInspector::addSizes(const ImagePair& pair) {
  const std::string odd = oddity(pair);
  if (!odd.empty()) odd_.push_back(pair.id.text() + ": " + odd);
  const std::string sequence = pair.id.dataset + "/" + pair.id.sequence;
  tools_->sizes[{sequence, "left"}].add(pair.id, pair.left.size());
  tools_->sizes[{sequence, "right"}].add(pair.id, pair.right.size());
}

std::vector<std::string> PairInspector::oddSizes() const {
  std::vector<std::string> all = odd_;
  for (const auto& [images, sizes] : tools_->sizes) {
    const std::string odd = sizes.odd(images.second);
    if (!odd.empty()) all.push_back(odd);
  }
  return all;
}

std::vector<TruthWarning> PairInspector::doubtfulTruths() const { return truthWarnings(checks_); }

std::vector<std::string> PairInspector::findings() const {
  std::vector<std::string> lines;
  for (const std::string& odd : oddSizes()) lines.push_back("odd: " + odd);
  for (const TruthWarning& warning : doubtfulTruths()) lines.push_back("doubtful: " + warning.text());
  return lines;
}

}  // namespace corrsel::core
