#pragma once

#include <gtest/gtest.h>

#include <algorithm>
#include <cstdint>
#include <opencv2/core.hpp>
#include <opencv2/imgproc.hpp>
#include <string>
#include <vector>

#include "corrsel/features/extractor.h"
#include "corrsel/features/features.h"
#include "corrsel/random.h"
#include "test_support.h"

namespace corrsel::core::testing {

/// Squares and discs of all sizes on a grey ground, with a little texture.
inline cv::Mat shapes(int channels = 1, cv::Size size = {400, 300}, std::uint64_t seed = 1) {
  Random random(seed);
  cv::Mat image(size, CV_8UC(channels), cv::Scalar::all(128));
  const auto below = [&random](int bound) { return int(random.index(std::uint32_t(bound))); };
  for (int i = 0; i < 150; ++i) {
    // Compilers evaluate arguments in different orders: whatever is drawn has a statement of its own.
    const int y = below(size.height), x = below(size.width);
    const cv::Point centre(x, y);
    const int radius = 2 + below(14);
    const int third = below(256), second = below(256), first = below(256);
    const cv::Scalar colour(first, second, third, 255);
    if (i % 2) {
      cv::circle(image, centre, radius, colour, cv::FILLED);
    } else {
      cv::rectangle(image, centre, centre + cv::Point(radius, 2 * radius), colour, cv::FILLED);
    }
  }
  cv::GaussianBlur(image, image, {}, 0.8);
  return image;
}

/// Whether this version of OpenCV lacks one of the algorithms of the combination.
inline bool isMissing(const std::string& combination) {
  const std::vector<std::string> names = algorithmsOf(combination);
  const auto missing = missingAlgorithms();
  return std::any_of(missing.begin(), missing.end(), [&names](const auto& algorithm) {
    return std::find(names.begin(), names.end(), algorithm.first) != names.end();
  });
}

/// Combinations of the paper and others, without what this version of OpenCV lacks. Each detector and each
/// descriptor also occurs in another pairing.
inline std::vector<std::string> combinations() {
  std::vector<std::string> names = extractorNames();
  for (const char* mixed : {"cv_sift+cv_sift", "cv_orb+cv_orb", "sift+orb", "orb+brisk", "akaze+sift",
                            "sift+freak", "blob+sift", "hessian_affine+freak", "asift+sift"}) {
    if (!isMissing(mixed)) names.push_back(mixed);
  }
  if (kSanitized) {  // test_asift has it, in less time
    names.erase(std::remove_if(names.begin(), names.end(),
                               [](const std::string& name) { return algorithmsOf(name).front() == "asift"; }),
                names.end());
  }
  return names;
}

/// Converts a combination to the name of a test.
inline std::string combinationName(const ::testing::TestParamInfo<std::string>& info) {
  std::string name = info.param;
  std::replace(name.begin(), name.end(), '+', '_');
  return name;
}

/// Compares keypoints and frames bit by bit.
inline void expectSameKeypoints(const Features& a, const Features& b) {
  ASSERT_EQ(a.keypoints.size(), b.keypoints.size());
  for (std::size_t i = 0; i < a.keypoints.size(); ++i) {
    const cv::KeyPoint &p = a.keypoints[i], &q = b.keypoints[i];
    ASSERT_TRUE(p.pt == q.pt && p.size == q.size && p.angle == q.angle && p.response == q.response &&
                p.octave == q.octave && p.class_id == q.class_id)
        << i;
  }
  EXPECT_EQ(a.frames, b.frames);
}

/// Compares everything except the times bit by bit.
inline void expectSame(const Features& a, const Features& b) {
  expectSameKeypoints(a, b);
  ASSERT_EQ(a.descriptors.size(), b.descriptors.size());
  EXPECT_EQ(a.descriptors.type(), b.descriptors.type());
  if (!a.descriptors.empty()) {
    EXPECT_EQ(cv::norm(a.descriptors, b.descriptors, cv::NORM_INF), 0);
  }
  EXPECT_EQ(a.image_size, b.image_size);
}

}  // namespace corrsel::core::testing
