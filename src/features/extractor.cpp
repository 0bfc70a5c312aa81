#include "corrsel/features/extractor.h"

#include <algorithm>
#include <cstdint>
#include <future>
#include <opencv2/core.hpp>
#include <stdexcept>
#include <utility>

#include "base/parallel.h"
#include "base/stopwatch.h"
#include "features/descriptors/descriptor.h"
#include "features/detectors/detector.h"
#include "features/parts/feature_list.h"
#include "features/parts/grey_image.h"
#include "features/parts/image_options.h"
#include "features/parts/place_mask.h"

namespace corrsel::core {
namespace {

std::string sizeText(const cv::Size& size) {
  return std::to_string(size.width) + "x" + std::to_string(size.height);
}

/// The part of the area that is inside the image.
cv::Rect visibleArea(const cv::Rect& area, const cv::Size& image) {
  if (area.empty()) return {{0, 0}, image};
  // In 64 bits, because the sum of two arbitrary ints must fit.
  const auto end = [](int begin, int length, int limit) {
    return static_cast<int>(std::min<std::int64_t>(std::int64_t{begin} + length, limit));
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
                                   std::unique_ptr<Descriptor> descriptor, const ImageOptions& image)
    : name_(std::move(name)),
      detector_(std::move(detector)),
      descriptor_(std::move(descriptor)),
      image_(std::make_unique<const ImageOptions>(image)) {
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
  const DetectorOptions& options = detector_->options();
  GreyBuffer& buffer = request.workspace.part<GreyBuffer>();
  request.image = equalized(toGrey(image(area), options.max_megapixels, buffer), *image_, buffer);
  request.threads = threads;
  request.describe = descriptor_ == nullptr;
  std::vector<ScaleLevel> levels;
  request.levels = &levels;
  const AreaTransform to_whole(request.image.size(), area);
  // A mask that allows the whole area is left out, since masks cost OpenCV's detectors time.
  if (!region.mask.empty() && cv::countNonZero(region.mask(area)) < area.area()) {
    request.mask = PlaceMask(region.mask, to_whole);
  }
  detector_->detect(request, features);
  keepStrongest(options.max_features, options.spread, request.image.size(), features);
  features.detect_seconds = watch.restart();
  if (descriptor_ != nullptr) {
    if (levels.empty()) {
      descriptor_->describe(request.image, threads, request.workspace, features);
    } else {
      descriptor_->describeOn(levels, request.image, threads, request.workspace, features);
    }
    features.describe_seconds = watch.seconds();
  }
  to_whole.apply(features);
  return features;
}

cv::Size FeatureExtractor::searchedSize(const cv::Size& image) const {
  return reducedSize(image, detector_->options().max_megapixels);
}

std::vector<std::pair<std::string, const OptionSet*>> FeatureExtractor::options() const {
  std::vector<std::pair<std::string, const OptionSet*>> result = {{detector_->name(), &detector_->options()}};
  if (descriptor_ != nullptr) result.emplace_back(descriptor_->name(), &descriptor_->options());
  result.emplace_back(kImageOptions, image_.get());
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
