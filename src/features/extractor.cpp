#include "corrsel/features/extractor.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <future>
#include <numeric>
#include <opencv2/imgproc.hpp>
#include <stdexcept>
#include <tuple>
#include <utility>

#include "base/parallel.h"
#include "base/stopwatch.h"
#include "features/descriptors/descriptor.h"
#include "features/detectors/detector.h"
#include "features/parts/feature_list.h"
#include "features/parts/place_mask.h"
#include "features/parts/spread.h"

namespace corrsel::core {
namespace {

std::string sizeText(const cv::Size& size) {
  return std::to_string(size.width) + "x" + std::to_string(size.height);
}

void checkImage(const cv::Mat& image) {
  if (image.empty()) throw std::invalid_argument("image is empty");
  if (image.depth() != CV_8U || image.channels() == 2 || image.channels() > 4) {
    throw std::invalid_argument("image has type " + cv::typeToString(image.type()) +
                                "; needed: 8 bits with 1, 3 (BGR) or 4 (BGRA) channels");
  }
}

cv::Mat toGrey(const cv::Mat& image) {
  // OpenCV's BRISK reads pixels beyond the border of an image that is a part of another one.
  if (image.channels() == 1) return image.isSubmatrix() ? image.clone() : image;
  cv::Mat grey;
  cv::cvtColor(image, grey, image.channels() == 3 ? cv::COLOR_BGR2GRAY : cv::COLOR_BGRA2GRAY);
  return grey;
}

/// Sorts features, strongest first, and keeps max_features of them.
void sortAndCut(const DetectorOptions& options, const cv::Size& image_size, Features& features) {
  std::vector<int> order(features.keypoints.size());
  std::iota(order.begin(), order.end(), 0);
  std::sort(order.begin(), order.end(), [&features](int a, int b) {
    return stronger(features.keypoints[static_cast<std::size_t>(a)],
                    features.keypoints[static_cast<std::size_t>(b)]);
  });
  const auto most = static_cast<std::size_t>(options.max_features);
  if (most > 0 && order.size() > most) {
    if (options.spread) {
      std::vector<cv::Point2f> points;
      for (const int i : order) points.push_back(features.keypoints[static_cast<std::size_t>(i)].pt);
      std::vector<int> kept;
      for (const std::size_t rank : spreadOverImage(points, image_size, most)) {
        kept.push_back(order[rank]);
      }
      order = std::move(kept);
    } else {
      order.resize(most);
    }
  }
  reorder(order, features);
}

/// The image, reduced to at most max_megapixels.
cv::Mat reduced(const cv::Mat& grey, double max_megapixels) {
  const double scale = std::sqrt(max_megapixels * 1e6 / (static_cast<double>(grey.cols) * grey.rows));
  if (scale >= 1) return grey;
  cv::Mat result;
  const auto side = [scale](int length) { return std::max(1, static_cast<int>(length * scale)); };
  cv::resize(grey, result, {side(grey.cols), side(grey.rows)}, 0, 0, cv::INTER_AREA);
  return result;
}

/// The part of the area that is inside the image.
cv::Rect visibleArea(const cv::Rect& area, const cv::Size& image) {
  if (area.empty()) return {{0, 0}, image};
  // In 64 bits, because the sum of two arbitrary ints must fit.
  const auto end = [](int begin, int length, int most) {
    return static_cast<int>(std::min<std::int64_t>(std::int64_t{begin} + length, most));
  };
  const cv::Point first(std::max(area.x, 0), std::max(area.y, 0));
  const cv::Point last(end(area.x, area.width, image.width), end(area.y, area.height, image.height));
  if (last.x <= first.x || last.y <= first.y) {
    throw std::invalid_argument("the area of " + sizeText(area.size()) + " px at (" + std::to_string(area.x) +
                                ", " + std::to_string(area.y) + ") lies outside the image of " +
                                sizeText(image) + " px");
  }
  return {first, last};
}

void checkMask(const cv::Mat& mask, const cv::Size& image) {
  if (mask.empty()) return;
  if (mask.type() != CV_8UC1) {
    throw std::invalid_argument("mask has type " + cv::typeToString(mask.type()) +
                                "; needed: 8 bits with 1 channel");
  }
  if (mask.size() != image) {
    throw std::invalid_argument("mask has " + sizeText(mask.size()) + " px; needed: " + sizeText(image) +
                                " px, the size of the image");
  }
}

}  // namespace

FeatureExtractor::FeatureExtractor(std::string name, std::unique_ptr<Detector> detector,
                                   std::unique_ptr<Descriptor> descriptor)
    : name_(std::move(name)), detector_(std::move(detector)), descriptor_(std::move(descriptor)) {
  if (descriptor_ == nullptr && !detector_->describesKeypoints()) {
    throw std::invalid_argument("features '" + name_ + "': the detector " + detector_->name() +
                                " does not describe its keypoints; needed: a descriptor");
  }
}

FeatureExtractor::~FeatureExtractor() = default;

Features FeatureExtractor::extract(const cv::Mat& image, int threads, const FeatureRegion& region) const {
  Features features;
  features.image_size = image.size();
  Stopwatch watch;
  checkImage(image);
  checkMask(region.mask, image.size());
  const cv::Rect area = visibleArea(region.area, image.size());
  DetectionRequest request;
  request.image = reduced(toGrey(image(area)), detector_->options().max_megapixels);
  request.threads = threads;
  request.describe = descriptor_ == nullptr;
  const AreaTransform to_whole(request.image.size(), area);
  // A mask that allows the whole area is left out, since masks cost OpenCV's detectors time.
  if (!region.mask.empty() && cv::countNonZero(region.mask(area)) < area.area()) {
    request.mask = PlaceMask(region.mask, to_whole);
  }
  detector_->detect(request, features);
  sortAndCut(detector_->options(), request.image.size(), features);
  features.detect_seconds = watch.restart();
  if (descriptor_ != nullptr) {
    descriptor_->describe(request.image, threads, features);
    features.describe_seconds = watch.seconds();
  }
  to_whole.apply(features);
  return features;
}

std::vector<std::pair<std::string, const OptionSet*>> FeatureExtractor::options() const {
  std::vector<std::pair<std::string, const OptionSet*>> result = {{detector_->name(), &detector_->options()}};
  if (descriptor_ != nullptr) result.emplace_back(descriptor_->name(), &descriptor_->options());
  return result;
}

std::pair<Features, Features> extractPair(const FeatureExtractor& extractor, const cv::Mat& left,
                                          const cv::Mat& right, int threads, const FeatureRegion& left_region,
                                          const FeatureRegion& right_region) {
  if (threads <= 1)
    return {extractor.extract(left, 1, left_region), extractor.extract(right, 1, right_region)};
  const int each = threads / 2;
  Features first, second;
  Crew crew;
  std::future<void> other = crew.start([&] { second = extractor.extract(right, each, right_region); });
  first = extractor.extract(left, threads - each, left_region);
  other.get();
  return {std::move(first), std::move(second)};
}

}  // namespace corrsel::core
