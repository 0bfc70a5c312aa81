#include "matching/predicted_areas.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "base/parallel.h"
#include "geometry/rays.h"
#include "points/length_unit.h"

namespace corrsel::core {
namespace {

constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();

/// The size of a pixel in the middle of an image, rad.
double pixelAngle(const Camera& camera, const cv::Size2d& size) {
  const float x[] = {static_cast<float>(size.width / 2), static_cast<float>(camera.matrix(0, 2))};
  const float y[] = {static_cast<float>(size.height / 2), static_cast<float>(camera.matrix(1, 2))};
  Rays rays;
  unproject(camera, x, y, 2, rays);
  const double middle = rays.pixelAngle(0);
  return std::isnan(middle) ? rays.pixelAngle(1) : middle;
}

}  // namespace

/// A part of a path, which may be a point.
struct PredictedAreas::Segment {
  cv::Point2d from, to;
  double scale;           ///< of distances along rows
  double end_x, end_y;    ///< from `from`, scaled
  double inverse_square;  ///< of the length; 0 of a point

  double squaredDistance(double x, double y) const {
    const double dx = scale * (x - from.x), dy = y - from.y;
    const double along = std::min(1.0, std::max(0.0, (dx * end_x + dy * end_y) * inverse_square));
    const double off_x = dx - along * end_x, off_y = dy - along * end_y;
    return off_x * off_x + off_y * off_y;
  }
};

PredictedAreas::PredictedAreas(const Features& left, const Features& right, const Camera& left_camera,
                               const Camera& right_camera, const MotionGuess& guess, int threads)
    : camera_(right_camera),
      translation_(guess.translation),
      closed_(right_camera.model == Camera::Model::kEquirectangular) {
  indexRight(right);
  pixel_angle_ = pixelAngle(right_camera, size_);
  sigma_ = guess.rotation_sigma / pixel_angle_;
  predict(left, left_camera, guess, threads);
}

/// Sorts the right features into cells of a few each.
void PredictedAreas::indexRight(const Features& right) {
  constexpr double kPerCell = 3;
  for (const cv::KeyPoint& keypoint : right.keypoints) {
    right_x_.push_back(keypoint.pt.x);
    right_y_.push_back(keypoint.pt.y);
  }
  const cv::Size known = right.image_size.empty() ? camera_.size : right.image_size;
  unit_ = lengthUnit(known, right_x_, right_y_);
  size_ = known.empty() ? cv::Size2d(*std::max_element(right_x_.begin(), right_x_.end()) + 1,
                                     *std::max_element(right_y_.begin(), right_y_.end()) + 1)
                        : cv::Size2d(known);
  const double cell = std::sqrt(kPerCell * size_.area() / static_cast<double>(right_x_.size()));
  cells_.build(right_x_.data(), right_y_.data(), right_x_.size(),
               CellGrid::covering(0, 0, size_.width, size_.height, std::max(1.0, cell)));
  at_slot_.resize(cells_.slots());
  slot_x_.resize(cells_.slots());
  slot_y_.resize(cells_.slots());
  for (std::uint32_t i = 0; i < right_x_.size(); ++i) {
    const std::uint32_t slot = cells_.slotOf()[i];
    at_slot_[slot] = i;
    slot_x_[slot] = right_x_[i];
    slot_y_[slot] = right_y_[i];
  }
}

void PredictedAreas::predict(const Features& left, const Camera& left_camera, const MotionGuess& guess,
                             int threads) {
  constexpr std::size_t kBlock = 512;
  const std::size_t n = left.keypoints.size();
  directions_.resize(n);
  places_.assign(n, {kNaN, kNaN});
  forEachBlock(n, kBlock, threads, [&](std::size_t begin, std::size_t end) {
    std::vector<float> x, y;
    for (std::size_t i = begin; i < end; ++i) {
      x.push_back(left.keypoints[i].pt.x);
      y.push_back(left.keypoints[i].pt.y);
    }
    Rays rays;
    unproject(left_camera, x.data(), y.data(), x.size(), rays);
    for (std::size_t i = begin; i < end; ++i) {
      directions_[i] = guess.rotation * rays.direction(i - begin);
      cv::Point2d place;
      if (!std::isnan(directions_[i][0]) && project(camera_, directions_[i], place)) places_[i] = place;
    }
  });
}

/// What distances along a row are multiplied by.
double PredictedAreas::rowScale(double y) const {
  constexpr double kMin = 0.05;
  if (!closed_) return 1;
  return std::max(kMin, std::cos(((y + 0.5) / size_.height - 0.5) * CV_PI));
}

bool PredictedAreas::isInside(std::uint32_t left) const {
  return cv::Rect2d({0, 0}, size_).contains(places_[left]);  // false for NaN
}

/// The epipolar curve as a polyline, as far as it is in the image: its first point is that of infinite depth.
PredictedAreas::Path PredictedAreas::pathOf(const cv::Point2d& place, const cv::Vec3d& direction,
                                            double reach) const {
  const double step = camera_.isPlainPinhole() ? 128 : 64;  // px; lines are straight in a pinhole
  Path path = {place};
  if (!translation_) return path;
  const cv::Vec3d& end = *translation_;
  const double cosine = direction.dot(end);
  const cv::Vec3d across = end - cosine * direction;
  const double sine = cv::norm(across), angle = std::atan2(sine, cosine);
  if (!(sine > 1e-9)) return path;
  const int steps = static_cast<int>(angle / (step * pixel_angle_)) + 1;
  const cv::Rect2d seen(-reach, -reach, size_.width + 2 * reach, size_.height + 2 * reach);
  bool entered = closed_ || seen.contains(place);
  for (int k = 1; k <= steps; ++k) {
    const double turned = angle * k / steps;
    cv::Point2d next;
    if (!project(camera_, std::cos(turned) * direction + (std::sin(turned) / sine) * across, next)) break;
    if (closed_) {  // the way around the border
      while (next.x - path.back().x > size_.width / 2) next.x -= size_.width;
      while (path.back().x - next.x > size_.width / 2) next.x += size_.width;
    }
    path.push_back(next);
    const bool inside = closed_ || seen.contains(next);
    if (entered && !inside) break;
    entered = entered || inside;
  }
  return path;
}

/// Part k of a path: that from its point k - 1, or the only point.
PredictedAreas::Segment PredictedAreas::segmentOf(const Path& path, std::size_t k) const {
  Segment segment;
  segment.to = path[k];
  segment.from = path[k > 0 ? k - 1 : 0];
  segment.scale = rowScale((segment.from.y + segment.to.y) / 2);
  segment.end_x = segment.scale * (segment.to.x - segment.from.x);
  segment.end_y = segment.to.y - segment.from.y;
  const double square = segment.end_x * segment.end_x + segment.end_y * segment.end_y;
  segment.inverse_square = square > 0 ? 1 / square : 0;
  return segment;
}

/// Marks the right features that are within reach of a part of a path.
void PredictedAreas::mark(const Segment& segment, double reach, std::vector<std::uint64_t>& bits) const {
  const cv::Point2d middle = (segment.from + segment.to) / 2;
  const double half_width = std::abs(segment.to.x - segment.from.x) / 2 + reach / segment.scale;
  const double half_height = std::abs(segment.to.y - segment.from.y) / 2 + reach;
  if (middle.y + half_height < 0 || middle.y - half_height > size_.height) return;
  for (const double shift : {0.0, size_.width, -size_.width}) {
    const double x = middle.x + shift;
    if (x + half_width < 0 || x - half_width > size_.width) continue;
    cells_.visitRuns(x, middle.y, half_width, half_height, [&](std::uint32_t begin, std::uint32_t end) {
      for (std::uint32_t slot = begin; slot < end; ++slot) {
        const double squared = segment.squaredDistance(slot_x_[slot] - shift, slot_y_[slot]);
        const std::uint32_t i = at_slot_[slot];
        bits[i / 64] |= std::uint64_t{squared <= reach * reach} << (i % 64);
      }
    });
    if (!closed_) return;
  }
}

void PredictedAreas::distances(std::uint32_t left, double reach, const std::vector<std::uint32_t>& rights,
                               std::vector<double>& result) const {
  result.assign(rights.size(), std::numeric_limits<double>::infinity());
  if (std::isnan(places_[left].x)) return;
  const Path path = pathOf(places_[left], directions_[left], reach);
  for (std::size_t k = path.size() > 1 ? 1 : 0; k < path.size(); ++k) {
    const Segment segment = segmentOf(path, k);
    for (const double shift : {0.0, size_.width, -size_.width}) {
      for (std::size_t i = 0; i < rights.size(); ++i) {
        const std::uint32_t right = rights[i];
        result[i] = std::min(result[i], segment.squaredDistance(right_x_[right] - shift, right_y_[right]));
      }
      if (!closed_) break;
    }
  }
  for (double& distance : result) distance = std::sqrt(distance);
}

/// Finds the candidates of a group of queries.
void PredictedAreas::findTrains(double reach, CandidateGroup& group) const {
  cv::Point2d mean;
  cv::Vec3d direction;
  for (const std::uint32_t left : group.queries) {
    mean += places_[left] / static_cast<double>(group.queries.size());
    direction += directions_[left];
  }
  double extent = 0;
  const double scale = rowScale(mean.y);
  for (const std::uint32_t left : group.queries)
    extent =
        std::max(extent, cv::norm(cv::Vec2d(scale * (places_[left].x - mean.x), places_[left].y - mean.y)));
  const Path path = pathOf(mean, cv::normalize(direction), reach + extent);
  std::vector<std::uint64_t> bits((right_x_.size() + 63) / 64);
  for (std::size_t k = path.size() > 1 ? 1 : 0; k < path.size(); ++k)
    mark(segmentOf(path, k), reach + extent, bits);
  for (std::uint32_t word = 0; word < bits.size(); ++word) {
    for (std::uint64_t rest = bits[word]; rest != 0; rest &= rest - 1)
      group.trains.push_back(64 * word + static_cast<std::uint32_t>(__builtin_ctzll(rest)));
  }
}

std::vector<CandidateGroup> PredictedAreas::groups(double reach, int threads) const {
  constexpr double kSideOfReach = 1, kPerGroup = 8;
  // Places beyond it have no candidate, or a part of the epipolar line only.
  const double border = translation_ ? std::max(size_.width, size_.height) : reach;
  const double side = std::max(
      kSideOfReach * reach,
      std::sqrt(kPerGroup * size_.area() / std::max<double>(1, static_cast<double>(places_.size()))));
  std::vector<std::uint32_t> placed;
  std::vector<float> x, y;
  for (std::uint32_t i = 0; i < places_.size(); ++i) {
    const cv::Point2d& place = places_[i];
    if (!(place.x >= -border && place.x <= size_.width + border && place.y >= -border &&
          place.y <= size_.height + border))
      continue;
    placed.push_back(i);
    x.push_back(static_cast<float>(place.x));
    y.push_back(static_cast<float>(place.y));
  }
  PointCells cells;
  cells.build(
      x.data(), y.data(), x.size(),
      CellGrid::covering(-border, -border, size_.width + 2 * border, size_.height + 2 * border, side));
  std::vector<std::uint32_t> at_slot(placed.size());
  for (std::size_t k = 0; k < placed.size(); ++k) at_slot[cells.slotOf()[k]] = placed[k];
  std::vector<CandidateGroup> result;
  cells.visitCells([&](std::uint32_t begin, std::uint32_t end) {
    if (begin != end) result.push_back({{at_slot.begin() + begin, at_slot.begin() + end}, {}});
  });
  forEachBlock(result.size(), 8, threads, [&](std::size_t begin, std::size_t end) {
    for (std::size_t group = begin; group < end; ++group) findTrains(reach, result[group]);
  });
  return result;
}

}  // namespace corrsel::core
