#pragma once

#include <gtest/gtest.h>

#include <opencv2/core.hpp>

#include "corrsel/features/features.h"

namespace corrsel::core::testing {

/// Keypoints and frames, bit by bit.
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

/// Everything but the times, bit by bit.
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
