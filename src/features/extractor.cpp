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
  // OpenCV's BRISK looks beyond the border of a part of an image.
  if (image.channels() == 1) return image.isSubmatrix() ? image.clone() : image;
  cv::Mat grey;
  cv::cvtColor(image, grey, image.channels() == 3 ? cv::COLOR_BGR2GRAY : cv::COLOR_BGRA2GRAY);
  return grey;
}

void sortAndCap(const DetectorOptions& options, const cv::Size& image_size, Features& features) {
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

/// Reduces an image that is larger than allowed.
cv::Mat reduced(const cv::Mat& grey, double max_megapixels) {
  const double scale = std::sqrt(max_megapixels * 1e6 / (static_cast<double>(grey.cols) * grey.rows));
  if (scale >= 1) return grey;
  cv::Mat result;
  const auto side = [scale](int length) { return std::max(1, static_cast<int>(length * scale)); };
  cv::resize(grey, result, {side(grey.cols), side(grey.rows)}, 0, 0, cv::INTER_AREA);
  return result;
}

/// From pixels of the reduced area to those of the whole image.
class ToWhole {
 public:
  ToWhole(const cv::Size& from, const cv::Rect& area)
      : reduced_(from != area.size()),
        left_(static_cast<float>(area.x)),
        top_(static_cast<float>(area.y)),
        x_(static_cast<float>(area.width) / static_cast<float>(from.width)),
        y_(static_cast<float>(area.height) / static_cast<float>(from.height)) {}

  cv::Point2f operator()(const cv::Point2f& p) const {
    if (!reduced_) return {p.x + left_, p.y + top_};
    return {(p.x + 0.5F) * x_ - 0.5F + left_, (p.y + 0.5F) * y_ - 0.5F + top_};
  }

  void apply(Features& features) const {
    // x and y differ by roundings to whole pixels only: shapes and angles stay.
    const float scale = std::sqrt(x_ * y_);
    for (std::size_t i = 0; i < features.keypoints.size(); ++i) {
      cv::KeyPoint& keypoint = features.keypoints[i];
      AffineFrame& frame = features.frames[i];
      if (reduced_) {
        keypoint.size *= scale;
        for (const std::size_t k : {0, 1, 3, 4}) frame[k] *= scale;
      }
      keypoint.pt = (*this)(keypoint.pt);
      frame[2] = keypoint.pt.x;
      frame[5] = keypoint.pt.y;
    }
  }

 private:
  bool reduced_;
  float left_, top_, x_, y_;
};

/// The part of the area that is inside the image.
cv::Rect visibleArea(const cv::Rect& area, const cv::Size& image) {
  if (area.empty()) return {{0, 0}, image};
  // In 64 bits, since the sums of any numbers must fit.
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
                                " px, as the image");
  }
}

/// Whether the pixel of the mask below a place is not zero.
PlaceFilter unmasked(const cv::Mat& mask, const ToWhole& to_whole) {
  return [&mask, &to_whole](const cv::Point2f& place) {
    const cv::Point2f at = to_whole(place);
    const int x = std::clamp(static_cast<int>(std::floor(at.x + 0.5F)), 0, mask.cols - 1);
    const int y = std::clamp(static_cast<int>(std::floor(at.y + 0.5F)), 0, mask.rows - 1);
    return mask.at<std::uint8_t>(y, x) != 0;
  };
}

}  // namespace

FeatureExtractor::FeatureExtractor(std::string name, std::unique_ptr<Detector> detector,
                                   std::unique_ptr<Descriptor> descriptor)
    : name_(std::move(name)), detector_(std::move(detector)), descriptor_(std::move(descriptor)) {}

FeatureExtractor::~FeatureExtractor() = default;

Features FeatureExtractor::extract(const cv::Mat& image, int threads, const FeatureRegion& region) const {
  Features features;
  features.image_size = image.size();
  Stopwatch watch;
  checkImage(image);
  checkMask(region.mask, image.size());
  const cv::Rect area = visibleArea(region.area, image.size());
  const bool masked = !region.mask.empty() && cv::countNonZero(region.mask(area)) < area.area();
  const cv::Mat grey = reduced(toGrey(image(area)), detector_->options().max_megapixels);
  const ToWhole to_whole(grey.size(), area);
  const PlaceFilter allowed = unmasked(region.mask, to_whole);
  if (descriptor_ == nullptr) {
    const auto& detector = dynamic_cast<const SelfDescribingDetector&>(*detector_);
    if (masked) {
      detector.detectAndDescribeWhere(grey, threads, allowed, features);
    } else {
      detector.detectAndDescribe(grey, threads, features);
    }
  } else if (masked) {
    detector_->detectWhere(grey, threads, allowed, features);
  } else {
    detector_->detect(grey, threads, features);
  }
  sortAndCap(detector_->options(), grey.size(), features);
  features.detect_seconds = watch.restart();
  if (descriptor_ != nullptr) {
    descriptor_->describe(grey, threads, features);
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
