#include "auto/plane_band.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "geometry/fundamental.h"
#include "points/length_unit.h"

namespace corrsel::core {
namespace {

constexpr double kBegin = 0.6, kEnd = 5;  // times the threshold of the plane
constexpr double kTrustedShare = 0.75;    // of the matches on the plane
constexpr double kPlace = 4;              // units of the image
constexpr std::size_t kMaxDisplaced = 200, kNearest = 4;
constexpr double kAlike = 0.4, kAlikeShare = 0.25;  // times the threshold of the plane; of the smaller one

}  // namespace

void PlaneBand::gather(const PlaneOfMatches& plane) {
  plane_ = &plane;
  const double squared = plane.threshold * plane.threshold;
  const auto on = std::count_if(plane.errors.begin(), plane.errors.end(),
                                [squared](double error) { return error <= squared; });
  const double trusted = (plane.ranked ? kTrustedShare : 1) * static_cast<double>(on);
  double seen_on = 0;
  members_.clear();
  const Correspondences& m = plane.pixels;
  const LengthUnits units = LengthUnits::of(m);
  left_places_.clear(64, static_cast<float>(kPlace * units.left));
  right_places_.clear(64, static_cast<float>(kPlace * units.right));
  for (const std::uint32_t i : plane.best_first) {
    if (plane.ranked && seen_on >= trusted) break;
    const double error = plane.errors[i];
    seen_on += error <= squared ? 1 : 0;
    if (!(error > kBegin * kBegin * squared && error <= kEnd * kEnd * squared)) continue;
    if (left_places_.isTaken(m.left_x[i], m.left_y[i]) || right_places_.isTaken(m.right_x[i], m.right_y[i]))
      continue;
    left_places_.add(m.left_x[i], m.left_y[i]);
    right_places_.add(m.right_x[i], m.right_y[i]);
    members_.push_back(i);
  }
}

PlaneBand::Direction PlaneBand::direction(const cv::Matx33d& fundamental, double tolerance) {
  const NormalizedMatches& m = plane_->matches;
  const cv::Matx33d transposed = fundamental.t();
  const cv::Vec3d epipole = leftNullVector(fundamental);
  const double width = tolerance * m.scale;
  std::size_t others = 0;
  chances_.clear();
  displaced_.clear();
  for (const std::uint32_t i : members_) {
    const cv::Vec3d left(m.left_x[i], m.left_y[i], 1), right(m.right_x[i], m.right_y[i], 1);
    const cv::Vec3d line = fundamental * left, left_line = transposed * right;
    const double right_normal = line[0] * line[0] + line[1] * line[1];
    const double normals = right_normal + left_line[0] * left_line[0] + left_line[1] * left_line[1];
    if (!(right_normal > 0) || std::abs(line.dot(right)) > width * std::sqrt(normals)) {
      ++others;
      continue;
    }
    const cv::Vec3d on_plane = plane_->homography * left;
    const double x = on_plane[0] / on_plane[2], y = on_plane[1] / on_plane[2];
    const double dx = right[0] - x, dy = right[1] - y, r = std::hypot(dx, dy);
    const double sine = std::min(1.0, width * std::sqrt(normals / right_normal) / r);
    chances_.push_back(2 / CV_PI * std::asin(sine));
    // Away from the epipole, wherever it lies.
    const double away = dx * (x * epipole[2] - epipole[0]) + dy * (y * epipole[2] - epipole[1]);
    displaced_.push_back({left[0] / m.scale, left[1] / m.scale, (away < 0 ? -r : r) / m.scale});
  }
  Direction best;
  for (int step = 1; step < 20; ++step) {
    const double share = 0.05 * step;
    double sum = static_cast<double>(others) * std::log1p(-share);
    for (const double chance : chances_) sum += std::log(share / chance + 1 - share);
    if (sum > best.log_ratio) best = {sum, share};
  }
  return best;
}

double PlaneBand::coherence() const {
  const std::size_t n = std::min(displaced_.size(), kMaxDisplaced);
  if (n <= kNearest) return 0;
  std::size_t alike = 0, alike_near = 0;
  for (std::size_t i = 0; i < n; ++i) {
    const Displaced& a = displaced_[i];
    std::array<double, kNearest> distances;
    std::array<bool, kNearest> near_alike{};
    distances.fill(std::numeric_limits<double>::infinity());
    for (std::size_t j = 0; j < n; ++j) {
      if (j == i) continue;
      const Displaced& b = displaced_[j];
      const double smaller = std::min(std::abs(a.length), std::abs(b.length));
      const bool is_alike =
          std::abs(a.length - b.length) <= std::max(kAlike * plane_->threshold, kAlikeShare * smaller);
      alike += is_alike ? 1 : 0;
      double distance = std::hypot(a.x - b.x, a.y - b.y);
      bool value = is_alike;
      for (std::size_t k = 0; k < kNearest; ++k) {
        if (distance >= distances[k]) continue;
        std::swap(distance, distances[k]);
        std::swap(value, near_alike[k]);
      }
    }
    alike_near += static_cast<std::size_t>(std::count(near_alike.begin(), near_alike.end(), true));
  }
  const double by_chance = static_cast<double>(alike) / static_cast<double>(n * (n - 1));
  const double near = static_cast<double>(alike_near) / static_cast<double>(n * kNearest);
  return by_chance < 1 ? (near - by_chance) / (1 - by_chance) : 1;
}

}  // namespace corrsel::core
