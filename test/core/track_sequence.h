#pragma once

#include <algorithm>
#include <cmath>
#include <map>
#include <memory>
#include <opencv2/imgproc.hpp>
#include <string>
#include <utility>
#include <vector>

#include "corrsel/features/extractor.h"
#include "corrsel/matching/matcher.h"
#include "corrsel/matching/sequence.h"
#include "corrsel/random.h"
#include "corrsel/selectors/factory.h"
#include "corrsel/tracking/gap_bridge.h"
#include "corrsel/tracking/track_keeper.h"

namespace corrsel::core::testing {

/// Images of a camera that turns, zooms and moves in front of a textured wall, while a textured board in
/// front of the wall shifts against it. Where every point goes is known.
class TrackSequence {
 public:
  static constexpr int kWidth = 640, kHeight = 480;

  explicit TrackSequence(std::uint64_t seed, double noise = 3)
      : random_(seed), noise_(noise), wall_(texture(1400, 1200)), board_(texture(200, 160)) {}

  /// Image number k; every one has noise of its own. Call it once for each k, in ascending order.
  cv::Mat image(int k) {
    cv::Mat picture, front, covered;
    cv::warpPerspective(wall_, picture, layer(k, false), {kWidth, kHeight}, cv::INTER_AREA);
    cv::warpPerspective(board_, front, layer(k, true), {kWidth, kHeight}, cv::INTER_AREA);
    const cv::Mat all(board_.size(), CV_8U, cv::Scalar(255));
    cv::warpPerspective(all, covered, layer(k, true), {kWidth, kHeight}, cv::INTER_NEAREST);
    front.copyTo(picture, covered);
    for (int y = 0; y < picture.rows; ++y) {
      for (int x = 0; x < picture.cols; ++x) {
        auto& pixel = picture.at<std::uint8_t>(y, x);
        pixel = cv::saturate_cast<std::uint8_t>(pixel + noise_ * random_.normal());
      }
    }
    return picture;
  }

  /// By how much a point of image `to` misses the place of a point of image `from`, px. Near the edge of the
  /// board, whatever layer fits better counts.
  double error(int from, const cv::Point2f& at, int to, const cv::Point2f& found) const {
    const cv::Point2d on_board = map(layer(from, true).inv(), at);
    const double inside =
        std::min({on_board.x, on_board.y, board_.cols - on_board.x, board_.rows - on_board.y});
    constexpr double kEdge = 10;  // px, about the radius of a small feature's patch
    double least = 1e9;
    for (const bool front : {false, true}) {
      if (front ? inside < -kEdge : inside > kEdge) continue;
      const cv::Point2d there = map(layer(to, front) * layer(from, front).inv(), at);
      least = std::min(least, std::hypot(there.x - found.x, there.y - found.y));
    }
    return least;
  }

 private:
  /// Maps the texture of a layer into image k.
  static cv::Matx33d layer(int k, bool front) {
    const double angle = 0.01 * k, zoom = 1 + 0.006 * k, c = zoom * std::cos(angle),
                 s = zoom * std::sin(angle);
    const cv::Matx33d camera(c, -s, kWidth / 2.0, s, c, kHeight / 2.0, 1e-5 * k, -1e-5 * k, 1);
    const double x = front ? 60 - 5.0 * k : -600 - 3.0 * k, y = front ? -60 + 2.0 * k : -550 + 1.0 * k;
    return camera * cv::Matx33d(1, 0, x, 0, 1, y, 0, 0, 1);
  }

  static cv::Point2d map(const cv::Matx33d& h, const cv::Point2d& p) {
    const cv::Vec3d q = h * cv::Vec3d(p.x, p.y, 1);
    return {q[0] / q[2], q[1] / q[2]};
  }

  cv::Mat texture(int width, int height) {
    cv::Mat image(height, width, CV_8U, cv::Scalar(128));
    for (int i = 0; i < width * height / 250; ++i) {
      const int x = int(random_.index(std::uint32_t(width))), y = int(random_.index(std::uint32_t(height)));
      const int size = 4 + int(random_.index(24));
      const cv::Scalar grey(random_.index(256));
      if (i % 2 == 0) {
        cv::rectangle(image, cv::Rect(x, y, size, size), grey, cv::FILLED);
      } else {
        cv::circle(image, {x, y}, size / 2, grey, cv::FILLED);
      }
    }
    cv::GaussianBlur(image, image, {}, 0.8);
    return image;
  }

  Random random_;
  const double noise_;
  const cv::Mat wall_, board_;
};

/// The sights of every track that was seen at least twice.
using TrackSights = std::map<std::uint64_t, std::vector<TrackSight>>;

/// Follows features over images as the nodelets do: each image is matched with the one before, and `selector`
/// decides, also about gaps.
class ImageTracker {
 public:
  ImageTracker(const std::string& features, const AlgorithmOptions& options, std::size_t max_gap,
               const std::string& selector = "auto")
      : extractor_(createExtractor(features, options)),
        selector_(createSelector(selector)),
        keeper_(max_gap, GapBridge(selector_)) {}

  void add(const cv::Mat& image) {
    const std::uint64_t id = ++frames_;
    auto features = std::make_shared<const Features>(extractor_->extract(image));
    TrackKeeper::Frame frame{id, {}, features};
    for (const cv::KeyPoint& keypoint : features->keypoints) frame.points.push_back(keypoint.pt);
    if (previous_ == nullptr) {
      keeper_.add(std::move(frame));
    } else {
      const Correspondences matches = matchFeatures(*features, *previous_);
      keeper_.add(std::move(frame), id - 1, selectedLinks(matches, selector_->select(matches).mask));
    }
    previous_ = features;
    bridged_ += keeper_.counts().bridged;
    const std::vector<FeatureTrack> tracks = keeper_.tracks();
    for (std::uint32_t i = 0; i < tracks.size(); ++i) {
      if (tracks[i].age < 2) continue;
      std::vector<TrackSight>& sights = sights_[tracks[i].id];
      if (tracks[i].age == 2) sights.push_back(tracks[i].first);
      sights.push_back({id, i, tracks[i].point});
    }
  }

  const TrackSights& sights() const { return sights_; }
  std::size_t bridged() const { return bridged_; }

 private:
  std::unique_ptr<FeatureExtractor> extractor_;
  std::shared_ptr<const Selector> selector_;
  TrackKeeper keeper_;
  std::shared_ptr<const Features> previous_;
  std::uint64_t frames_ = 0;
  std::size_t bridged_ = 0;
  TrackSights sights_;
};

}  // namespace corrsel::core::testing
