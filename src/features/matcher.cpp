#include "corrsel/features/matcher.h"

#include <limits>
#include <opencv2/features2d.hpp>
#include <stdexcept>
#include <string>

namespace corrsel::core {
namespace {

std::string describe(const cv::Mat& descriptors) {
  return std::to_string(descriptors.cols) + " x " + cv::typeToString(descriptors.type());
}

}  // namespace

Correspondences matchFeatures(const Features& left, const Features& right) {
  Correspondences matches;
  matches.left_size = left.image_size;
  matches.right_size = right.image_size;
  if (left.keypoints.empty() || right.keypoints.empty()) return matches;
  if (left.descriptors.type() != right.descriptors.type() ||
      left.descriptors.cols != right.descriptors.cols) {
    throw std::invalid_argument("descriptors differ: left " + describe(left.descriptors) + ", right " +
                                describe(right.descriptors));
  }
  const bool binary = left.descriptors.type() == CV_8U;
  if (!binary && left.descriptors.type() != CV_32F) {
    throw std::invalid_argument("descriptors are " + describe(left.descriptors) +
                                "; needed: CV_8U or CV_32F");
  }
  const cv::BFMatcher matcher(binary ? cv::NORM_HAMMING : cv::NORM_L2);
  std::vector<std::vector<cv::DMatch>> nearest;
  matcher.knnMatch(left.descriptors, right.descriptors, nearest, 2);
  for (const std::vector<cv::DMatch>& candidates : nearest) {
    // A descriptor that holds NaN has no neighbour.
    if (candidates.empty()) continue;
    const cv::DMatch& best = candidates.front();
    const auto l = static_cast<std::uint32_t>(best.queryIdx), r = static_cast<std::uint32_t>(best.trainIdx);
    matches.add(left.keypoints[l].pt, right.keypoints[r].pt);
    matches.distance.push_back(best.distance);
    matches.second_distance.push_back(candidates.size() > 1 ? candidates[1].distance
                                                            : std::numeric_limits<float>::quiet_NaN());
    matches.left_index.push_back(l);
    matches.right_index.push_back(r);
    if (!left.frames.empty() && !right.frames.empty()) {
      matches.left_frame.push_back(left.frames[l]);
      matches.right_frame.push_back(right.frames[r]);
    }
  }
  return matches;
}

}  // namespace corrsel::core
