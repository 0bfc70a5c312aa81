#include "evaluation/repeatability.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>
#include <opencv2/core.hpp>
#include <tuple>
#include <utility>

#include "geometry/homography.h"
#include "points/place_index.h"

namespace corrsel::core {
namespace {

/// The matrix of a frame and its centre.
struct Ellipse {
  cv::Matx22d matrix;
  cv::Vec2d centre;

  double area() const { return std::abs(cv::determinant(matrix)); }  // divided by pi
};

Ellipse ellipseOf(const AffineFrame& frame) {
  return {{frame[0], frame[1], frame[3], frame[4]}, {frame[2], frame[5]}};
}

/// Intersection divided by union of the unit disc and an ellipse.
double overlapWithUnitDisc(const Ellipse& ellipse) {
  const cv::Matx22d shape = ellipse.matrix * ellipse.matrix.t();
  const double half_width = std::sqrt(shape(0, 0)), slope = shape(0, 1) / shape(0, 0);
  const double half_height = ellipse.area() / half_width;  // on the vertical through the centre
  const double begin = std::max(-1.0, ellipse.centre[0] - half_width);
  const double end = std::min(1.0, ellipse.centre[0] + half_width);
  if (end <= begin) return 0;
  // Vertical chords, closer to each other near the ends, where their lengths change fastest.
  constexpr int kChords = 48;
  const double middle = (begin + end) / 2, half = (end - begin) / 2;
  double intersection = 0;
  for (int i = 0; i < kChords; ++i) {
    const double angle = (i + 0.5) * CV_PI / kChords;
    const double x = middle - half * std::cos(angle), t = (x - ellipse.centre[0]) / half_width;
    const double disc = std::sqrt(std::max(0.0, 1 - x * x));
    const double y = ellipse.centre[1] + slope * (x - ellipse.centre[0]);
    const double reach = half_height * std::sqrt(std::max(0.0, 1 - t * t));
    const double chord = std::min(disc, y + reach) - std::max(-disc, y - reach);
    if (chord > 0) intersection += chord * std::sin(angle);
  }
  intersection *= half * CV_PI / kChords / CV_PI;  // in units of the disc's area
  return intersection / (1 + ellipse.area() - intersection);
}

/// As ellipseOverlap(); 0 where it would be below `min_overlap`, which must be more than 1/2.
double overlapIfAtLeast(const Ellipse& a, const cv::Matx22d& inverse, const Ellipse& b, double scale,
                        double min_overlap) {
  const Ellipse relative{inverse * b.matrix, inverse * (b.centre - a.centre) / scale};
  const double area = relative.area();
  if (area < min_overlap || area * min_overlap > 1) return 0;
  // With its centre outside, less than half of the second ellipse is inside of the first one.
  if (relative.centre.dot(relative.centre) >= 1) return 0;
  const double overlap = overlapWithUnitDisc(relative);
  return overlap >= min_overlap ? overlap : 0;
}

/// The centres of ellipses, by place.
PlaceIndex centresOf(const std::vector<Ellipse>& ellipses, double reach) {
  PlaceIndex places;
  places.clear(ellipses.size(), static_cast<float>(reach));
  for (const Ellipse& ellipse : ellipses)
    places.add(static_cast<float>(ellipse.centre[0]), static_cast<float>(ellipse.centre[1]));
  return places;
}

/// The ellipses of finite frames with an area, each once, ordered by position.
std::vector<Ellipse> regions(const std::vector<AffineFrame>& frames) {
  std::vector<Ellipse> result;
  const auto shape = [](const Ellipse& e) { return e.matrix * e.matrix.t(); };
  const auto same = [&shape](const Ellipse& a, const Ellipse& b) {
    constexpr double kRounding = 1e-4;
    return a.centre == b.centre && cv::norm(shape(a) - shape(b)) <= kRounding * cv::norm(shape(a));
  };
  for (const AffineFrame& frame : frames) {
    const bool finite = std::all_of(frame.begin(), frame.end(), [](float v) { return std::isfinite(v); });
    const Ellipse ellipse = ellipseOf(frame);
    if (finite && ellipse.area() > 0) result.push_back(ellipse);
  }
  std::sort(result.begin(), result.end(), [&shape](const Ellipse& a, const Ellipse& b) {
    const auto key = [&shape](const Ellipse& e) {
      const cv::Matx22d s = shape(e);
      return std::make_tuple(e.centre[0], e.centre[1], e.area(), s(0, 0), s(0, 1));
    };
    return key(a) < key(b);
  });
  result.erase(std::unique(result.begin(), result.end(), same), result.end());
  return result;
}

bool inside(const cv::Vec2d& point, const cv::Size& size) {
  return point[0] >= -0.5 && point[1] >= -0.5 && point[0] <= size.width - 0.5 &&
         point[1] <= size.height - 0.5;
}

/// The image of an ellipse under a homography; false where the centre is not in front of the camera.
bool project(const cv::Matx33d& h, const Ellipse& from, Ellipse& to) {
  const cv::Vec3d image = h * cv::Vec3d(from.centre[0], from.centre[1], 1);
  if (image[2] <= 0) return false;
  to.centre = {image[0] / image[2], image[1] / image[2]};
  const cv::Matx22d derivative(h(0, 0) - to.centre[0] * h(2, 0), h(0, 1) - to.centre[0] * h(2, 1),
                               h(1, 0) - to.centre[1] * h(2, 0), h(1, 1) - to.centre[1] * h(2, 1));
  to.matrix = derivative * from.matrix * (1 / image[2]);
  return true;
}

}  // namespace

double ellipseOverlap(const AffineFrame& a, const AffineFrame& b, double scale) {
  const std::vector<Ellipse> first = regions({a}), second = regions({b});
  if (first.empty() || second.empty()) return 0;
  const cv::Matx22d inverse = first[0].matrix.inv();
  return overlapWithUnitDisc(
      {inverse * second[0].matrix, inverse * (second[0].centre - first[0].centre) * (1 / scale)});
}

double Repeatability::share() const {
  const std::size_t fewer = std::min(left, right);
  return fewer > 0 ? static_cast<double>(repeated) / static_cast<double>(fewer)
                   : std::numeric_limits<double>::quiet_NaN();
}

Repeatability repeatability(const std::vector<AffineFrame>& left, const cv::Size& left_size,
                            const std::vector<AffineFrame>& right, const cv::Size& right_size,
                            const cv::Matx33d& homography) {
  const cv::Matx33d forward = inFront(homography, 0.5 * left_size.width, 0.5 * left_size.height);
  const cv::Matx33d backward = forward.inv();
  std::vector<Ellipse> projected, detected;
  Ellipse image;
  for (const Ellipse& ellipse : regions(left)) {
    if (project(forward, ellipse, image) && inside(image.centre, right_size)) projected.push_back(image);
  }
  for (const Ellipse& ellipse : regions(right)) {
    if (project(backward, ellipse, image) && inside(image.centre, left_size)) detected.push_back(ellipse);
  }
  const PlaceIndex places = centresOf(detected, kOverlapRadius);
  std::vector<std::tuple<double, std::size_t, std::size_t>> pairs;  // negative overlap, left, right
  for (std::size_t i = 0; i < projected.size(); ++i) {
    const Ellipse& a = projected[i];
    const double scale = kOverlapRadius / std::sqrt(a.area());
    const cv::Matx22d inverse = a.matrix.inv();
    places.visitNear(a.centre[0], a.centre[1], scale * std::hypot(a.matrix(0, 0), a.matrix(0, 1)),
                     scale * std::hypot(a.matrix(1, 0), a.matrix(1, 1)), [&](std::size_t j) {
                       const double overlap =
                           overlapIfAtLeast(a, inverse, detected[j], scale, 1 - kMaxOverlapError);
                       if (overlap > 0) pairs.emplace_back(-overlap, i, j);
                       return false;
                     });
  }
  std::sort(pairs.begin(), pairs.end());
  std::vector<char> used_left(projected.size(), 0), used_right(detected.size(), 0);
  Repeatability result{projected.size(), detected.size(), 0};
  for (const auto& [overlap, i, j] : pairs) {
    if (used_left[i] || used_right[j]) continue;
    used_left[i] = used_right[j] = 1;
    ++result.repeated;
  }
  return result;
}

double agreement(const std::vector<AffineFrame>& frames, const std::vector<AffineFrame>& others,
                 double distance, double scale) {
  std::vector<Ellipse> ellipses;
  ellipses.reserve(others.size());
  for (const AffineFrame& frame : others) ellipses.push_back(ellipseOf(frame));
  const PlaceIndex places = centresOf(ellipses, std::max(distance, 1.0));
  std::size_t found = 0;
  for (const AffineFrame& frame : frames) {
    const Ellipse own = ellipseOf(frame);
    const bool there = places.visitNear(own.centre[0], own.centre[1], distance, distance, [&](std::size_t i) {
      const cv::Vec2d offset = ellipses[i].centre - own.centre;
      const double ratio = std::sqrt(ellipses[i].area() / own.area());
      return offset.dot(offset) <= distance * distance && std::abs(ratio - 1) <= scale;
    });
    found += there ? 1 : 0;
  }
  return frames.empty() ? std::numeric_limits<double>::quiet_NaN()
                        : static_cast<double>(found) / static_cast<double>(frames.size());
}

}  // namespace corrsel::core
