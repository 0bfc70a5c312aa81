#pragma once

// For programs that use corrsel's matches: conversion of messages to OpenCV's points, keypoints and matches.
// This header needs only the messages and OpenCV's core module; no library of corrsel is linked.

#include <cmath>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <opencv2/core/types.hpp>
#include <stdexcept>
#include <string>
#include <unordered_map>
#include <utility>
#include <vector>

#include "corrsel/Correspondences.h"
#include "corrsel/Selection.h"

namespace corrsel {

/// Matches as OpenCV's functions expect them: DMatch::queryIdx is an index into the left keypoints, trainIdx
/// an index into the right ones.
struct KeypointsAndMatches {
  std::vector<cv::KeyPoint> left, right;
  std::vector<cv::DMatch> matches;  ///< one per match of the message, in its order
};

namespace consume_detail {

inline void requireLength(const char* message, const char* field, std::size_t length, std::size_t expected,
                          bool optional) {
  if (length == expected || (optional && length == 0)) return;
  throw std::invalid_argument(std::string(message) + " message: " + field + " has " + std::to_string(length) +
                              " elements, expected " + (optional ? "0 or " : "") + std::to_string(expected));
}

inline std::vector<cv::Point2f> points(const char* x_field, const std::vector<float>& x, const char* y_field,
                                       const std::vector<float>& y, std::size_t n) {
  requireLength("Correspondences", x_field, x.size(), n, false);
  requireLength("Correspondences", y_field, y.size(), n, false);
  std::vector<cv::Point2f> result(n);
  for (std::size_t i = 0; i < n; ++i) result[i] = {x[i], y[i]};
  return result;
}

/// The keypoints of one side of a message. A feature that several matches share becomes one keypoint.
class KeypointList {
 public:
  KeypointList(std::vector<cv::Point2f> points, const std::vector<float>& frames,
               const std::vector<std::uint32_t>& index)
      : points_(std::move(points)), frames_(frames), index_(index) {}

  /// Index of the keypoint of a match.
  int keypointOf(std::size_t match) {
    const int next = static_cast<int>(keypoints.size());
    if (!index_.empty()) {
      const auto found = numbers_.emplace(index_[match], next);
      if (!found.second) return found.first->second;
    }
    cv::KeyPoint keypoint;
    keypoint.pt = points_[match];
    if (!index_.empty()) keypoint.class_id = static_cast<int>(index_[match]);
    if (!frames_.empty()) {
      const float* const a = &frames_[6 * match];
      keypoint.size = 2 * std::sqrt(std::abs(a[0] * a[4] - a[1] * a[3]));
      const float degrees = std::atan2(a[3], a[0]) * static_cast<float>(180 / CV_PI);
      keypoint.angle = degrees < 0 ? degrees + 360 : degrees;
    }
    keypoints.push_back(keypoint);
    return next;
  }

  std::vector<cv::KeyPoint> keypoints;

 private:
  std::vector<cv::Point2f> points_;
  const std::vector<float>& frames_;
  const std::vector<std::uint32_t>& index_;
  std::unordered_map<std::uint32_t, int> numbers_;  ///< keypoints by the index of their feature
};

}  // namespace consume_detail

/// Positions in the left image, px, one per match. Throws std::invalid_argument that names an array whose
/// length is not the number of matches.
inline std::vector<cv::Point2f> leftPoints(const Correspondences& msg) {
  return consume_detail::points("left_x", msg.left_x, "left_y", msg.left_y, msg.left_x.size());
}

/// Positions in the right image, px, one per match. Throws as leftPoints() does.
inline std::vector<cv::Point2f> rightPoints(const Correspondences& msg) {
  return consume_detail::points("right_x", msg.right_x, "right_y", msg.right_y, msg.left_x.size());
}

/// Keypoints and the matches between them. If the message has indices of features, a feature of several
/// matches is one keypoint, with the index as class_id; otherwise every match has keypoints of its own, with
/// class_id -1. If the message has affine frames, the size of a keypoint is the diameter, px, of the circle
/// with the area of the frame's ellipse, and its angle is that of the frame's first axis, degrees in [0,
/// 360); otherwise they are 0 and -1. If the message has no distances, DMatch::distance is 1 - probability,
/// and without probabilities FLT_MAX, as in OpenCV. Throws std::invalid_argument that names an array of the
/// wrong length. O(matches).
inline KeypointsAndMatches toKeypoints(const Correspondences& msg) {
  using consume_detail::requireLength;
  const std::size_t n = msg.left_x.size();
  requireLength("Correspondences", "distance", msg.distance.size(), n, true);
  requireLength("Correspondences", "probability", msg.probability.size(), n, true);
  requireLength("Correspondences", "left_frame", msg.left_frame.size(), 6 * n, true);
  requireLength("Correspondences", "right_frame", msg.right_frame.size(), 6 * n, true);
  requireLength("Correspondences", "left_index", msg.left_index.size(), n, true);
  requireLength("Correspondences", "right_index", msg.right_index.size(), n, true);
  consume_detail::KeypointList left(leftPoints(msg), msg.left_frame, msg.left_index);
  consume_detail::KeypointList right(rightPoints(msg), msg.right_frame, msg.right_index);
  KeypointsAndMatches result;
  result.matches.reserve(n);
  for (std::size_t i = 0; i < n; ++i) {
    const float distance = !msg.distance.empty()      ? msg.distance[i]
                           : !msg.probability.empty() ? 1.0F - msg.probability[i]
                                                      : std::numeric_limits<float>::max();
    const int from = left.keypointOf(i), to = right.keypointOf(i);
    result.matches.emplace_back(from, to, distance);
  }
  result.left = std::move(left.keypoints);
  result.right = std::move(right.keypoints);
  return result;
}

/// Indices of the matches that a selection kept, in rising order. They are rows of the Correspondences with
/// the same stamp on the topic that the selector reads (`correspondences`), not on the topic `matches`, which
/// holds only the selected ones. Throws std::invalid_argument if n_input is not the length of the mask.
inline std::vector<std::uint32_t> selectedRows(const Selection& msg) {
  consume_detail::requireLength("Selection", "mask", msg.mask.size(), msg.n_input, false);
  std::vector<std::uint32_t> rows;
  for (std::size_t i = 0; i < msg.mask.size(); ++i) {
    if (msg.mask[i] != 0) rows.push_back(static_cast<std::uint32_t>(i));
  }
  return rows;
}

}  // namespace corrsel
