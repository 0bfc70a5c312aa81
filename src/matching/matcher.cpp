#include "corrsel/matching/matcher.h"

#include <stdexcept>
#include <string>

#include "matching/putative.h"

namespace corrsel::core {
namespace {

std::string describe(const cv::Mat& descriptors) {
  return std::to_string(descriptors.cols) + " x " + cv::typeToString(descriptors.type());
}

void checkCount(const char* side, const Features& features) {
  if (static_cast<std::size_t>(features.descriptors.rows) == features.keypoints.size()) return;
  throw std::invalid_argument(std::string(side) + " features: " + std::to_string(features.keypoints.size()) +
                              " keypoints, but " + std::to_string(features.descriptors.rows) +
                              " descriptors; needed: one per keypoint");
}

}  // namespace

void checkDescriptors(const Features& left, const Features& right) {
  checkCount("left", left);
  checkCount("right", right);
  if (left.descriptors.type() != right.descriptors.type() ||
      left.descriptors.cols != right.descriptors.cols) {
    throw std::invalid_argument("descriptors differ: left " + describe(left.descriptors) + ", right " +
                                describe(right.descriptors));
  }
  if (left.descriptors.type() != CV_8U && left.descriptors.type() != CV_32F) {
    throw std::invalid_argument("descriptors are " + describe(left.descriptors) +
                                "; needed: CV_8U or CV_32F");
  }
}

Correspondences putativeMatches(const Features& left, const Features& right, const Neighbours& nearest,
                                bool mutual) {
  Correspondences matches;
  matches.left_size = left.image_size;
  matches.right_size = right.image_size;
  for (std::uint32_t l = 0; l < nearest.train.size(); ++l) {
    const std::uint32_t r = nearest.train[l];
    if (r == Neighbours::kNone || (mutual && nearest.query[r] != l)) continue;
    matches.add(left.keypoints[l].pt, right.keypoints[r].pt);
    matches.distance.push_back(nearest.distance[l]);
    matches.second_distance.push_back(nearest.second_distance[l]);
    matches.left_index.push_back(l);
    matches.right_index.push_back(r);
    if (!left.frames.empty() && !right.frames.empty()) {
      matches.left_frame.push_back(left.frames[l]);
      matches.right_frame.push_back(right.frames[r]);
    }
  }
  return matches;
}

void Matcher::configure(const OptionMap& options) {
  if (options.empty()) return;
  throw std::invalid_argument("unknown option " + options.begin()->first + "; the matcher has no options");
}

void MatchOptions::visit(OptionVisitor& visitor) const {
  visitor.flag("mutual", "Matching: keep features that are nearest to each other only",
               &MatchOptions::mutual);
  visitor.number(
      {"second_distance_radius", 0, 1000, "px",
       "Matching: smallest distance of the second neighbour from the first, for features found twice"},
      &MatchOptions::second_distance_radius);
}

Correspondences matchFeatures(const Features& left, const Features& right, const MatchOptions& options,
                              int threads) {
  options.check();
  if (left.keypoints.empty() || right.keypoints.empty()) return putativeMatches(left, right, {}, false);
  checkDescriptors(left, right);
  NeighbourSearch search;
  search.threads = threads;
  search.nearest_query = options.mutual;
  search.second_radius = options.second_distance_radius;
  search.train_keypoints = &right.keypoints;
  const Neighbours nearest = findNeighbours(left.descriptors, right.descriptors, search);
  return putativeMatches(left, right, nearest, options.mutual);
}

void DescriptorMatcher::configure(const OptionMap& options) {
  setOptions(options_, options, "match");
  options_.check();
}

Correspondences DescriptorMatcher::match(const Features& left, const Features& right) {
  return matchFeatures(left, right, options_, threads_);
}

}  // namespace corrsel::core
