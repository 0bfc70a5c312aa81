#include "corrsel/tracking/track_drawing.h"

#include <algorithm>
#include <cmath>
#include <opencv2/imgproc.hpp>
#include <stdexcept>
#include <string>

#include "corrsel/matching/match_drawing.h"
#include "matching/drawing_ground.h"

namespace corrsel::core {
namespace {

constexpr int kSubpixelBits = 4;
constexpr float kLargest = 1e5F;  ///< px; beyond it the fixed-point numbers of OpenCV's lines overflow

cv::Point fixed(const cv::Point2f& point) {
  return {cvRound(std::ldexp(point.x, kSubpixelBits)), cvRound(std::ldexp(point.y, kSubpixelBits))};
}

bool drawable(const cv::Point2f& point) {
  return std::abs(point.x) < kLargest && std::abs(point.y) < kLargest;  // false for NaN
}

}  // namespace

TrackDrawing::TrackDrawing(std::size_t tail) : tail_(tail) {
  if (tail == 0) throw std::invalid_argument("tail = 0 frames must be at least 1");
}

void TrackDrawing::add(const std::vector<std::uint64_t>& ids, const std::vector<cv::Point2f>& points) {
  if (ids.size() != points.size()) {
    throw std::invalid_argument(std::to_string(ids.size()) + " ids of " + std::to_string(points.size()) +
                                " points");
  }
  Frame frame;
  for (std::size_t i = 0; i < ids.size(); ++i) {
    if (drawable(points[i])) frame[ids[i]] = points[i];
  }
  frames_.push_back(std::move(frame));
  if (frames_.size() > tail_ + 1) frames_.pop_front();
}

cv::Mat TrackDrawing::draw(const cv::Mat& image) const {
  cv::Mat picture = toColour(image);
  if (picture.data == image.data) picture = image.clone();
  if (frames_.empty()) return picture;
  const MatchColours colours;
  for (const auto& [id, point] : frames_.back()) {
    cv::Point2f newer = point;
    std::size_t seen = 0;
    for (auto frame = frames_.rbegin() + 1; frame != frames_.rend(); ++frame) {
      const auto older = frame->find(id);
      if (older == frame->end()) continue;
      cv::line(picture, fixed(newer), fixed(older->second), colours.correct, 1, cv::LINE_AA, kSubpixelBits);
      newer = older->second;
      ++seen;
    }
    const double share = static_cast<double>(seen) / static_cast<double>(tail_);
    const cv::Scalar colour = colours.selected * (1 - share) + colours.correct * share;
    cv::circle(picture, fixed(point), 2 << kSubpixelBits, colour, cv::FILLED, cv::LINE_AA, kSubpixelBits);
  }
  return picture;
}

}  // namespace corrsel::core
