#include "corrsel/tracking/flow_matcher.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <opencv2/imgproc.hpp>
#include <opencv2/video/tracking.hpp>
#include <unordered_map>
#include <utility>

#include "base/stopwatch.h"
#include "corrsel/evaluation/statistics.h"
#include "features/parts/grey_image.h"
#include "features/parts/visible_area.h"
#include "tracking/brightness.h"
#include "tracking/flow_points.h"

namespace corrsel::core {
namespace {

/// Patches that differ by more than this, as a multiple of what they differed by after the first step and in
/// grey levels, are renewed, or no longer believed.
constexpr float kRenewShare = 2, kRenewLevels = 2, kLostShare = 3, kLostLevels = 10;
constexpr int kCandidates = 6;      // for each point; most are near another one
constexpr int kRefillInterval = 5;  // images, at least, while the scene does not show max_points
/// OpenCV divides the least eigenvalue of the sums of squared gradients by the pixels, with this unit.
constexpr double kSquaredGradientUnit = 1024;
/// Mean squared gradient of white noise with a variance of 1, by the Scharr operator.
constexpr double kGradientOfNoise = 2.0 * (3 * 3 + 10 * 10 + 3 * 3) / (32.0 * 32.0);
/// Mean absolute difference of two normally distributed values of deviation 1: 2 / sqrt(pi).
constexpr double kMeanDifference = 1.1283791670955126;
constexpr float kUnknown = std::numeric_limits<float>::quiet_NaN();
/// A guess is near enough if it is wrong by less than this part of the window, for this share of the points.
constexpr double kNearShare = 4, kMostPoints = 0.9;
constexpr double kMinGradient = 1;  // grey levels per px, where images have no noise
const cv::TermCriteria kStop(cv::TermCriteria::COUNT + cv::TermCriteria::EPS, 20, 0.01);

float squaredDistance(const cv::Point2f& a, const cv::Point2f& b) { return (a - b).dot(a - b); }

}  // namespace

void FlowOptions::visit(OptionVisitor& visitor) const {
  using O = FlowOptions;
  visitor.text("detector", "Flow: detector of new points, used with its own options", &O::detector);
  visitor.integer({"max_points", 1, 100000, "-", "Flow: points that are followed at most"}, &O::max_points);
  visitor.number({"refill", 0, 1, "-",
                  "Flow: new points are detected when fewer than this share of max_points are left"},
                 &O::refill);
  visitor.number(
      {"min_distance", 0, 1000, "px", "Flow: smallest distance of two points; the older one stays"},
      &O::min_distance);
  visitor.integer(
      {"window", 5, 63, "px", "Flow: side of the patches that are compared; multiples of 8 are fastest"},
      &O::window);
  visitor.integer({"levels", 1, 8, "-", "Flow: levels of the pyramid; each one doubles the largest motion"},
                  &O::levels);
  visitor.number(
      {"max_error", 0.01, 100, "px", "Flow: largest distance of a point that was followed there and back"},
      &O::max_error);
  visitor.number({"max_deviation", 0.001, 100, "px",
                  "Flow: largest standard deviation of a position by the noise of the images"},
                 &O::max_deviation);
}

FlowMatcher::FlowMatcher(const FlowOptions& options, const AlgorithmOptions& detector_options)
    : options_(options), grey_(std::make_unique<GreyBuffer>()), brightness_(std::make_unique<Brightness>()) {
  options_.check();
  AlgorithmOptions given = detector_options;
  OptionMap& own = given[options_.detector];
  own["max_features"] = std::to_string(kCandidates * options_.max_points);
  own["spread"] = "true";
  // ORB keeps this distance from the border.
  if (own.count("patch_size") != 0 || options_.detector == "orb") {
    own["patch_size"] = std::to_string(options_.window);
  }
  // The descriptor is not used. This one describes the keypoints of every detector.
  detector_ = createExtractor(options_.detector + "+orb", given);
}

FlowMatcher::~FlowMatcher() = default;

void FlowMatcher::reset() {
  points_.clear();
  *brightness_ = {};
  filled_ = 0;
  images_since_refill_ = 0;
  usual_level_ = options_.levels - 1;
}

Features FlowMatcher::track(const cv::Mat& image, int threads, const FeatureRegion& region) {
  const Stopwatch watch;
  checkImage(image);
  const cv::Rect area = visibleArea(region, image.size());
  if (image.size() != size_) {
    reset();
    size_ = image.size();
  }
  const cv::Mat grey = toGrey(image, std::numeric_limits<double>::infinity(), *grey_);
  const std::size_t newest = freeImage();
  const cv::Size window(options_.window, options_.window);
  top_level_ =
      cv::buildOpticalFlowPyramid(adaptedToLight(grey), images_[newest], window, options_.levels - 1);
  follow(newest);
  dropOutside(area, region.mask);
  std::vector<cv::Point2f> places;
  for (const Point& point : points_) places.push_back(point.place);
  drop(keepDistant(places, size_, options_.min_distance));
  limitKeyframes(newest);
  refill(grey, newest, threads, area, region);
  previous_ = newest;
  Features features = result(size_);
  features.detect_seconds = watch.seconds();
  return features;
}

std::size_t FlowMatcher::freeImage() const {
  std::array<char, std::tuple_size_v<decltype(images_)>> used{};
  if (!points_.empty()) used[previous_] = 1;
  for (const Point& point : points_) used[point.image] = 1;
  return static_cast<std::size_t>(std::find(used.begin(), used.end(), 0) - used.begin());
}

float FlowMatcher::typicalResidual() const {
  std::vector<float> residuals;
  for (const Point& point : points_) {
    if (!std::isnan(point.first_residual)) residuals.push_back(point.first_residual);
  }
  if (residuals.empty()) return 0;
  const auto middle = residuals.begin() + static_cast<std::ptrdiff_t>(residuals.size() / 2);
  std::nth_element(residuals.begin(), middle, residuals.end());
  return *middle;
}

/// The smallest eigenvalue, in OpenCV's unit, with which the noise leaves places exact.
double FlowMatcher::minEigenvalue() const {
  const double noise = typicalResidual() / kMeanDifference;
  const double pixels = static_cast<double>(options_.window) * options_.window;
  const double gradient = 2 / (pixels * options_.max_deviation * options_.max_deviation) + kGradientOfNoise;
  return std::max(kMinGradient * kMinGradient, gradient * noise * noise) / kSquaredGradientUnit;
}

void FlowMatcher::step(const Pyramid& from, const Pyramid& to, int max_level, Steps& steps) const {
  steps.found.clear();
  if (steps.from.empty()) return;
  const cv::Size window(options_.window, options_.window);
  const double min_eigenvalue = minEigenvalue();
  const std::vector<cv::Point2f> guesses = steps.to;
  cv::calcOpticalFlowPyrLK(from, to, steps.from, steps.to, steps.found, steps.residuals, window, max_level,
                           kStop, cv::OPTFLOW_USE_INITIAL_FLOW, min_eigenvalue);
  std::vector<std::size_t> there;
  std::vector<cv::Point2f> turned, back;
  for (std::size_t i = 0; i < steps.from.size(); ++i) {
    if (steps.found[i] == 0) continue;
    there.push_back(i);
    turned.push_back(steps.to[i]);
    back.push_back(steps.from[i] + guesses[i] - steps.to[i]);
  }
  if (there.empty()) return;
  std::vector<std::uint8_t> returned;
  cv::calcOpticalFlowPyrLK(to, from, turned, back, returned, cv::noArray(), window, max_level, kStop,
                           cv::OPTFLOW_USE_INITIAL_FLOW, min_eigenvalue);
  for (std::size_t k = 0; k < there.size(); ++k) {
    const double error = squaredDistance(back[k], steps.from[there[k]]);
    steps.found[there[k]] = returned[k] != 0 && error <= options_.max_error * options_.max_error;
  }
}

void FlowMatcher::move(Point& point, const cv::Point2f& place) {
  point.step = place - point.place;
  point.place = place;
}

/// Follows the points without a residual from the images of their patches, as far as they still look like
/// them.
void FlowMatcher::stepFromPatches(std::size_t newest, int max_level, std::vector<float>& residuals) {
  const float typical = typicalResidual();
  for (std::size_t image = 0; image < images_.size(); ++image) {
    Steps steps;
    for (std::size_t i = 0; i < points_.size(); ++i) {
      if (points_[i].image != image || !std::isnan(residuals[i])) continue;
      steps.rows.push_back(i);
      steps.from.push_back(points_[i].patch);
      steps.to.push_back(points_[i].place + points_[i].step);
    }
    step(images_[image], images_[newest], max_level, steps);
    for (std::size_t k = 0; k < steps.found.size(); ++k) {
      Point& point = points_[steps.rows[k]];
      const float residual = steps.residuals[k];
      const float usual =
          std::isnan(point.first_residual) ? typical : std::max(typical, point.first_residual);
      if (steps.found[k] == 0 || residual > kLostShare * usual + kLostLevels) continue;
      if (std::isnan(point.first_residual)) point.first_residual = residual;
      residuals[steps.rows[k]] = residual;
      move(point, steps.to[k]);
    }
  }
}

/// Follows the points without a residual from the previous image.
void FlowMatcher::stepFromPrevious(std::size_t newest, std::vector<float>& residuals) {
  Steps steps;
  for (std::size_t i = 0; i < points_.size(); ++i) {
    if (!std::isnan(residuals[i]) || points_[i].image == previous_) continue;
    steps.rows.push_back(i);
    steps.from.push_back(points_[i].place);
    steps.to.push_back(points_[i].place + points_[i].step);
  }
  step(images_[previous_], images_[newest], top_level_, steps);
  for (std::size_t k = 0; k < steps.found.size(); ++k) {
    if (steps.found[k] == 0) continue;
    Point& point = points_[steps.rows[k]];
    residuals[steps.rows[k]] = steps.residuals[k];
    move(point, steps.to[k]);
    renew(point, newest);
  }
}

void FlowMatcher::renew(Point& point, std::size_t newest) const {
  point.image = newest;
  point.patch = point.place;
  point.level = levelAt(images_[newest].front(), point.patch);
}

/// The mean of the patch; NaN where it is not inside the image.
float FlowMatcher::levelAt(const cv::Mat& image, const cv::Point2f& place) const {
  const cv::Rect patch(cvRound(place.x) - options_.window / 2, cvRound(place.y) - options_.window / 2,
                       options_.window, options_.window);
  if ((patch & cv::Rect({0, 0}, image.size())) != patch) return kUnknown;
  return static_cast<float>(cv::mean(image(patch))[0]);
}

cv::Mat FlowMatcher::adaptedToLight(const cv::Mat& grey) {
  std::vector<double> values, expected;
  for (const Point& point : points_) {
    const float value = levelAt(grey, point.place + point.step);
    if (std::isnan(value) || std::isnan(point.level)) continue;
    values.push_back(value);
    expected.push_back(point.level);
  }
  *brightness_ = fitBrightness(values, expected, *brightness_);
  if (brightness_->gain == 1 && brightness_->offset == 0) return grey;
  grey.convertTo(adapted_, CV_8U, brightness_->gain, brightness_->offset);
  return adapted_;
}

/// The level at which a guess that is wrong by this much, px, is near enough.
int FlowMatcher::levelFor(double error) const {
  int level = 0;
  while (level < top_level_ && error * kNearShare > options_.window << level) ++level;
  return level;
}

void FlowMatcher::follow(std::size_t newest) {
  if (points_.empty()) return;
  std::vector<float> residuals(points_.size(), kUnknown);
  std::vector<cv::Point2f> guesses;
  for (const Point& point : points_) guesses.push_back(point.place + point.step);
  const float typical = typicalResidual();
  const int level = std::min(usual_level_, top_level_);
  stepFromPatches(newest, level, residuals);
  if (level < top_level_) stepFromPatches(newest, top_level_, residuals);
  stepFromPrevious(newest, residuals);
  std::vector<double> errors;
  std::vector<char> found(points_.size());
  for (std::size_t i = 0; i < points_.size(); ++i) {
    Point& point = points_[i];
    found[i] = !std::isnan(residuals[i]);
    if (found[i] == 0) continue;
    errors.push_back(std::sqrt(squaredDistance(point.place, guesses[i])));
    if (point.image != newest &&
        residuals[i] > kRenewShare * std::max(typical, point.first_residual) + kRenewLevels) {
      renew(point, newest);
      point.first_residual = kUnknown;
    }
  }
  if (!errors.empty()) usual_level_ = levelFor(quantile(errors, kMostPoints));
  drop(found);
}

void FlowMatcher::drop(const std::vector<char>& keep) {
  std::size_t kept = 0;
  for (std::size_t i = 0; i < points_.size(); ++i) {
    if (keep[i] != 0) points_[kept++] = points_[i];
  }
  points_.resize(kept);
}

void FlowMatcher::dropOutside(const cv::Rect& area, const cv::Mat& mask) {
  const cv::Point2f border(static_cast<float>(options_.window / 2), static_cast<float>(options_.window / 2));
  const cv::Point2f first = border, last = cv::Point2f(size_ - cv::Size(1, 1)) - border;
  std::vector<char> keep(points_.size());
  for (std::size_t i = 0; i < points_.size(); ++i) {
    const cv::Point2f& place = points_[i].place;
    // NaN is outside.
    const bool inside = place.x >= first.x && place.y >= first.y && place.x <= last.x && place.y <= last.y;
    const cv::Point pixel = inside ? cv::Point(cvRound(place.x), cvRound(place.y)) : cv::Point(-1, -1);
    keep[i] = inside && area.contains(pixel) && (mask.empty() || mask.at<std::uint8_t>(pixel) != 0);
  }
  drop(keep);
}

void FlowMatcher::limitKeyframes(std::size_t newest) {
  std::array<std::size_t, std::tuple_size_v<decltype(images_)>> counts{};
  for (const Point& point : points_) ++counts[point.image];
  counts[newest] = 0;
  while (std::count_if(counts.begin(), counts.end(), [](std::size_t n) { return n > 0; }) >
         static_cast<std::ptrdiff_t>(kKeyframes)) {
    std::size_t fewest = newest;
    for (std::size_t image = 0; image < counts.size(); ++image) {
      if (counts[image] > 0 && (fewest == newest || counts[image] < counts[fewest])) fewest = image;
    }
    for (Point& point : points_) {
      if (point.image == fewest) renew(point, newest);
    }
    counts[fewest] = 0;
  }
}

bool FlowMatcher::wantsPoints() const {
  const auto count = static_cast<double>(points_.size());
  if (count >= options_.refill * options_.max_points) return false;
  return count < options_.refill * static_cast<double>(filled_) || images_since_refill_ >= kRefillInterval ||
         filled_ == 0;
}

void FlowMatcher::refill(const cv::Mat& grey, std::size_t newest, int threads, const cv::Rect& area,
                         const FeatureRegion& region) {
  ++images_since_refill_;
  if (!wantsPoints()) return;
  FeatureRegion empty{area,
                      region.mask.empty() ? cv::Mat(size_, CV_8UC1, cv::Scalar(255)) : region.mask.clone()};
  std::vector<cv::Point2f> places, candidates;
  for (const Point& point : points_) {
    places.push_back(point.place);
    cv::circle(empty.mask, cv::Point(cvRound(point.place.x), cvRound(point.place.y)),
               static_cast<int>(options_.min_distance), cv::Scalar(0), cv::FILLED);
  }
  const Features found = detector_->detect(grey, threads, empty);
  for (const cv::KeyPoint& keypoint : found.keypoints) candidates.push_back(keypoint.pt);
  // Those without texture would be lost in the next image.
  Steps steps;
  steps.from = steps.to = candidates;
  step(images_[newest], images_[newest], 0, steps);
  std::vector<cv::Point2f> all = places;
  all.insert(all.end(), candidates.begin(), candidates.end());
  const std::vector<char> keep = keepDistant(all, size_, options_.min_distance);
  std::size_t kept = 0;
  for (std::size_t i = 0; i < candidates.size(); ++i) {
    if (keep[places.size() + i] != 0 && steps.found[i] != 0) candidates[kept++] = candidates[i];
  }
  candidates.resize(kept);
  for (const std::size_t i :
       chooseNew(candidates, places, size_, static_cast<std::size_t>(options_.max_points))) {
    points_.push_back({next_id_, newest, {}, candidates[i], {0, 0}, 0, kUnknown});
    renew(points_.back(), newest);
    next_id_ = next_id_ == std::numeric_limits<int>::max() ? 0 : next_id_ + 1;
  }
  filled_ = points_.size();
  images_since_refill_ = 0;
}

Features FlowMatcher::result(const cv::Size& size) const {
  Features features;
  features.image_size = size;
  features.keypoints.reserve(points_.size());
  for (const Point& point : points_) {
    features.keypoints.emplace_back(point.place, static_cast<float>(options_.window), -1.0F, 0.0F, 0,
                                    point.id);
  }
  return features;
}

Correspondences matchFlow(const Features& left, const Features& right) {
  std::unordered_map<int, std::uint32_t> rows;
  rows.reserve(right.keypoints.size());
  for (std::size_t i = 0; i < right.keypoints.size(); ++i) {
    rows.emplace(right.keypoints[i].class_id, static_cast<std::uint32_t>(i));
  }
  Correspondences matches;
  matches.left_size = left.image_size;
  matches.right_size = right.image_size;
  for (std::size_t i = 0; i < left.keypoints.size(); ++i) {
    const auto found = rows.find(left.keypoints[i].class_id);
    if (found == rows.end()) continue;
    const cv::Point2f &from = left.keypoints[i].pt, &to = right.keypoints[found->second].pt;
    matches.left_x.push_back(from.x);
    matches.left_y.push_back(from.y);
    matches.right_x.push_back(to.x);
    matches.right_y.push_back(to.y);
    matches.left_index.push_back(static_cast<std::uint32_t>(i));
    matches.right_index.push_back(found->second);
  }
  return matches;
}

}  // namespace corrsel::core
