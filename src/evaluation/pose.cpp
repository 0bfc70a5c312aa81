#include "corrsel/evaluation/pose.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <opencv2/core.hpp>
#include <stdexcept>
#include <string>

#include "base/text.h"
#include "corrsel/random.h"
#include "geometry/cross_matrix.h"
#include "geometry/homography.h"
#include "geometry/rotation_vector.h"

namespace corrsel::core {
namespace {

constexpr double kInfinite = std::numeric_limits<double>::infinity();
constexpr double kSmallSine = 1e-9;
constexpr double kAtRest = 1e-9;  // difference of a rotation from the identity

double degrees(double radians) { return radians * 180.0 / CV_PI; }

/// The angle between two vectors. Near 0 and 180 degrees the cosine alone would lose half of the digits.
double angleBetween(const cv::Vec3d& a, const cv::Vec3d& b) {
  return degrees(std::atan2(cv::norm(a.cross(b)), a.dot(b)));
}

/// |R - R'| is 2 sqrt(2) times the sine of half the angle between the rotations.
double angleBetween(const cv::Matx33d& a, const cv::Matx33d& b) {
  return degrees(2 * std::asin(std::min(1.0, cv::norm(a - b) / std::sqrt(8.0))));
}

void requireErrors(const std::vector<double>& errors, double threshold) {
  if (!(threshold > 0)) {
    throw std::invalid_argument("threshold = " + formatNumber(threshold) + " is not above 0");
  }
  for (const double error : errors) {
    if (std::isnan(error) || error < 0) {
      throw std::invalid_argument("error = " + (std::isnan(error) ? "NaN" : formatNumber(error)) +
                                  " is no error: needed are numbers from 0; failed pairs are 180 degrees or "
                                  "infinite");
    }
  }
}

/// @param sorted  ascending
/// @param counts  how often each of them occurs
double areaUnder(const std::vector<double>& sorted, const std::vector<std::size_t>& counts,
                 double threshold) {
  std::size_t total = 0;
  for (const std::size_t count : counts) total += count;
  double area = 0, last_error = 0, recall = 0, reached = 0;
  for (std::size_t i = 0; i < sorted.size() && sorted[i] < threshold; ++i) {
    if (counts[i] == 0) continue;
    // Equal errors are a vertical line; only the first of them has a width.
    const double first = (reached + 1) / static_cast<double>(total);
    area += (sorted[i] - last_error) * (recall + first) / 2;
    reached += static_cast<double>(counts[i]);
    recall = reached / static_cast<double>(total);
    last_error = sorted[i];
  }
  return (area + (threshold - last_error) * recall) / threshold;
}

/// e^T C^-1 e of the first n parameters; NaN where C is not positive definite.
double squaredNorm(const cv::Vec<double, 5>& error, const cv::Matx<double, 5, 5>& covariance, int n) {
  cv::Mat c = cv::Mat(covariance)(cv::Rect(0, 0, n, n)).clone();
  cv::Mat solved = cv::Mat(error).rowRange(0, n).clone();
  if (!cv::checkRange(c) || !cv::checkRange(solved)) return kUndefined;
  if (!cv::solve(c, cv::Mat(error).rowRange(0, n), solved, cv::DECOMP_CHOLESKY)) return kUndefined;
  const double squared = cv::Mat(error).rowRange(0, n).dot(solved);
  return squared >= 0 ? squared : kUndefined;
}

/// (x, y, 1) in the frame of a camera with the inverse K.
cv::Vec3d ray(const cv::Matx33d& inverse, float x, float y) { return inverse * cv::Vec3d(x, y, 1); }

}  // namespace

PoseErrors poseErrors(const cv::Matx33d& rotation, const cv::Vec3d& translation, const RelativePose& truth) {
  PoseErrors errors;
  errors.rotation = angleBetween(rotation, truth.rotation);
  if (cv::norm(truth.translation) == 0) {
    errors.pose = errors.rotation;
    return errors;
  }
  if (cv::norm(translation) == 0) return errors;
  const double angle = angleBetween(translation, truth.translation);
  errors.translation = std::min(angle, 180.0 - angle);
  errors.pose = std::max(errors.rotation, errors.translation);
  return errors;
}

cv::Vec<double, 5> poseDeviation(const Pose& estimate, const RelativePose& truth) {
  const cv::Vec3d w = rotationVector(truth.rotation * estimate.rotation.t());
  cv::Vec<double, 5> error(w[0], w[1], w[2], kUndefined, kUndefined);
  const double length = cv::norm(truth.translation);
  if (length == 0 || cv::norm(estimate.translation) == 0) return error;
  const cv::Vec3d direction = truth.translation / length;
  cv::Vec3d b1, b2;
  translationBasis(estimate.translation, b1, b2);
  const cv::Vec2d across(direction.dot(b1), direction.dot(b2));
  const double sine = cv::norm(across), angle = std::atan2(sine, direction.dot(estimate.translation));
  const cv::Vec2d offset =
      sine > kSmallSine ? across * (angle / sine) : cv::Vec2d(angle > 1 ? angle : across[0], across[1]);
  error[3] = offset[0];
  error[4] = offset[1];
  return error;
}

bool NormalizedError::inside() const {
  return degrees > 0 && squared <= (degrees == 5 ? kChiSquared5 : kChiSquared3);
}

NormalizedError normalizedError(const PoseResult& estimate, const RelativePose& truth) {
  NormalizedError error;
  const bool translated = cv::norm(estimate.pose.translation) > 0;
  if (estimate.motion == Motion::kNone || translated != (cv::norm(truth.translation) > 0)) return error;
  const std::size_t degrees = translated ? 5 : 3;
  error.squared =
      squaredNorm(poseDeviation(estimate.pose, truth), estimate.covariance, static_cast<int>(degrees));
  error.degrees = std::isnan(error.squared) ? 0 : degrees;
  return error;
}

Motion trueMotion(const RelativePose& truth) {
  if (cv::norm(truth.translation) > 0) return Motion::kGeneral;
  return cv::norm(truth.rotation - cv::Matx33d::eye()) > kAtRest ? Motion::kRotation : Motion::kRest;
}

double errorAuc(std::vector<double> errors, double threshold) {
  requireErrors(errors, threshold);
  if (errors.empty()) return kUndefined;
  std::sort(errors.begin(), errors.end());
  return areaUnder(errors, std::vector<std::size_t>(errors.size(), 1), threshold);
}

Interval bootstrapAuc(const std::vector<std::vector<double>>& pairs, double threshold, std::uint64_t seed,
                      int resamples) {
  std::vector<double> sorted;
  for (const std::vector<double>& pair : pairs) sorted.insert(sorted.end(), pair.begin(), pair.end());
  requireErrors(sorted, threshold);
  std::sort(sorted.begin(), sorted.end());
  sorted.erase(std::unique(sorted.begin(), sorted.end()), sorted.end());
  std::vector<std::vector<std::size_t>> places;  // of each pair's errors
  for (const std::vector<double>& pair : pairs) {
    places.emplace_back();
    for (const double error : pair) {
      const auto place = std::lower_bound(sorted.begin(), sorted.end(), error) - sorted.begin();
      places.back().push_back(static_cast<std::size_t>(place));
    }
  }
  if (sorted.empty()) return {kUndefined, kUndefined};
  std::vector<std::size_t> counts(sorted.size());
  if (pairs.size() < 2) {
    for (const std::size_t place : places.front()) ++counts[place];
    const double area = areaUnder(sorted, counts, threshold);
    return {area, area};
  }
  Random random(seed);
  std::vector<double> areas(static_cast<std::size_t>(resamples));
  for (double& area : areas) {
    std::fill(counts.begin(), counts.end(), 0);
    for (std::size_t i = 0; i < pairs.size(); ++i) {
      for (const std::size_t place : places[random.index(static_cast<std::uint32_t>(pairs.size()))]) {
        ++counts[place];
      }
    }
    area = areaUnder(sorted, counts, threshold);
  }
  return {quantile(areas, 0.025), quantile(areas, 0.975)};
}

double thresholdAccuracy(double error, const std::vector<double>& thresholds) {
  const auto below =
      std::count_if(thresholds.begin(), thresholds.end(), [error](double t) { return error < t; });
  return thresholds.empty() ? kUndefined
                            : static_cast<double>(below) / static_cast<double>(thresholds.size());
}

std::vector<double> epipolarErrors(const RelativePose& truth, const Correspondences& matches) {
  if (cv::norm(truth.translation) == 0) {
    throw std::invalid_argument("translation = 0: a camera that only turned has no epipolar lines");
  }
  const cv::Matx33d essential = crossMatrix(truth.translation) * truth.rotation;
  const cv::Matx33d left_inverse = truth.left_camera.inv(), right_inverse = truth.right_camera.inv();
  std::vector<double> errors;
  errors.reserve(matches.size());
  for (std::size_t i = 0; i < matches.size(); ++i) {
    const cv::Vec3d left = ray(left_inverse, matches.left_x[i], matches.left_y[i]);
    const cv::Vec3d right = ray(right_inverse, matches.right_x[i], matches.right_y[i]);
    const cv::Vec3d right_line = essential * left, left_line = essential.t() * right;
    const double product = right.dot(right_line);
    const double error = product * product *
                         (1 / (right_line[0] * right_line[0] + right_line[1] * right_line[1]) +
                          1 / (left_line[0] * left_line[0] + left_line[1] * left_line[1]));
    errors.push_back(std::isfinite(error) ? error : kInfinite);
  }
  return errors;
}

double epipolarPrecision(const std::vector<double>& errors, const std::vector<std::uint8_t>& mask,
                         double threshold) {
  if (errors.size() != mask.size()) {
    throw std::invalid_argument("mask has " + std::to_string(mask.size()) + " elements for " +
                                std::to_string(errors.size()) + " matches");
  }
  std::size_t selected = 0, correct = 0;
  for (std::size_t i = 0; i < mask.size(); ++i) {
    if (mask[i] == 0) continue;
    ++selected;
    if (errors[i] < threshold) ++correct;
  }
  return selected == 0 ? 0.0 : static_cast<double>(correct) / static_cast<double>(selected);
}

double cornerError(const cv::Matx33d& homography, const cv::Matx33d& truth, const cv::Size& left_size) {
  if (left_size.empty()) throw std::invalid_argument("the size of the left image is empty");
  const double right = left_size.width - 1, bottom = left_size.height - 1;
  const cv::Matx33d h = inFront(homography, right / 2, bottom / 2);
  const cv::Matx33d t = inFront(truth, right / 2, bottom / 2);
  double sum = 0;
  for (const auto& [x, y] : {std::pair{0.0, 0.0}, {right, 0.0}, {0.0, bottom}, {right, bottom}}) {
    const cv::Vec3d a = h * cv::Vec3d(x, y, 1), b = t * cv::Vec3d(x, y, 1);
    if (!(a[2] * b[2] > 0)) return kInfinite;
    sum += std::hypot(a[0] / a[2] - b[0] / b[2], a[1] / a[2] - b[1] / b[2]);
  }
  return std::isfinite(sum) ? sum / 4 : kInfinite;
}

}  // namespace corrsel::core
