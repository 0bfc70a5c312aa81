#include "corrsel/features/extractor.h"

#include <algorithm>
#include <cmath>
#include <future>
#include <numeric>
#include <opencv2/imgproc.hpp>
#include <stdexcept>
#include <tuple>

#include "corrsel/features/cap.h"
#include "corrsel/stopwatch.h"

namespace corrsel::core {
namespace {

cv::Mat toGrey(const cv::Mat& image) {
  if (image.empty()) throw std::invalid_argument("image is empty");
  if (image.depth() != CV_8U || image.channels() == 2 || image.channels() > 4) {
    throw std::invalid_argument("image has type " + cv::typeToString(image.type()) +
                                "; needed: 8 bits with 1, 3 (BGR) or 4 (BGRA) channels");
  }
  // OpenCV's BRISK looks beyond the border of a part of an image.
  if (image.channels() == 1) return image.isSubmatrix() ? image.clone() : image;
  cv::Mat grey;
  cv::cvtColor(image, grey, image.channels() == 3 ? cv::COLOR_BGR2GRAY : cv::COLOR_BGRA2GRAY);
  return grey;
}

/// Strongest first; ties are broken by position, scale and angle, so that threads inside OpenCV cannot
/// reorder them.
bool stronger(const cv::KeyPoint& a, const cv::KeyPoint& b) {
  return std::make_tuple(-a.response, a.pt.y, a.pt.x, a.size, a.angle, a.octave, a.class_id) <
         std::make_tuple(-b.response, b.pt.y, b.pt.x, b.size, b.angle, b.octave, b.class_id);
}

/// Puts the features into the given order, dropping those it does not name.
void reorder(const std::vector<int>& order, Features& features) {
  std::vector<cv::KeyPoint> keypoints;
  std::vector<AffineFrame> frames;
  for (const int i : order) {
    keypoints.push_back(features.keypoints[static_cast<std::size_t>(i)]);
    frames.push_back(features.frames[static_cast<std::size_t>(i)]);
  }
  features.keypoints = std::move(keypoints);
  features.frames = std::move(frames);
  if (features.descriptors.empty()) return;
  cv::Mat descriptors(static_cast<int>(order.size()), features.descriptors.cols, features.descriptors.type());
  int row = 0;
  for (const int i : order) features.descriptors.row(i).copyTo(descriptors.row(row++));
  features.descriptors = descriptors;
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

/// Features of a reduced image in coordinates of the whole one.
void enlarge(const cv::Size& from, const cv::Size& to, Features& features) {
  if (from == to) return;
  const float x = static_cast<float>(to.width) / static_cast<float>(from.width);
  const float y = static_cast<float>(to.height) / static_cast<float>(from.height);
  for (std::size_t i = 0; i < features.keypoints.size(); ++i) {
    cv::KeyPoint& keypoint = features.keypoints[i];
    AffineFrame& frame = features.frames[i];
    // x and y differ by roundings to whole pixels only: shapes and angles stay.
    const float scale = std::sqrt(x * y);
    keypoint.size *= scale;
    for (const std::size_t k : {0, 1, 3, 4}) frame[k] *= scale;
    frame[2] = (frame[2] + 0.5F) * x - 0.5F;
    frame[5] = (frame[5] + 0.5F) * y - 0.5F;
    keypoint.pt = {frame[2], frame[5]};
  }
}

}  // namespace

FeatureExtractor::FeatureExtractor(std::string name, std::unique_ptr<Detector> detector,
                                   std::unique_ptr<Descriptor> descriptor)
    : name_(std::move(name)), detector_(std::move(detector)), descriptor_(std::move(descriptor)) {}

Features FeatureExtractor::extract(const cv::Mat& image, int threads) const {
  Features features;
  features.image_size = image.size();
  Stopwatch watch;
  const cv::Mat grey = reduced(toGrey(image), detector_->options().max_megapixels);
  if (descriptor_ == nullptr) {
    dynamic_cast<const SelfDescribingDetector&>(*detector_).detectAndDescribe(grey, threads, features);
  } else {
    detector_->detect(grey, threads, features);
  }
  sortAndCap(detector_->options(), grey.size(), features);
  features.detect_seconds = watch.restart();
  if (descriptor_ != nullptr) {
    descriptor_->describe(grey, threads, features);
    features.describe_seconds = watch.seconds();
  }
  enlarge(grey.size(), image.size(), features);
  return features;
}

std::vector<std::pair<std::string, const OptionSet*>> FeatureExtractor::options() const {
  std::vector<std::pair<std::string, const OptionSet*>> result = {{detector_->name(), &detector_->options()}};
  if (descriptor_ != nullptr) result.emplace_back(descriptor_->name(), &descriptor_->options());
  return result;
}

std::pair<Features, Features> extractPair(const FeatureExtractor& extractor, const cv::Mat& left,
                                          const cv::Mat& right, int threads) {
  if (threads <= 1) return {extractor.extract(left), extractor.extract(right)};
  const int each = threads / 2;
  auto other =
      std::async(std::launch::async, [&extractor, &right, each] { return extractor.extract(right, each); });
  Features first = extractor.extract(left, threads - each);
  return {std::move(first), other.get()};
}

}  // namespace corrsel::core
