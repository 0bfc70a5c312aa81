#include <gtest/gtest.h>

#include <limits>
#include <opencv2/imgproc.hpp>

#include "features/descriptors/patch_sift.h"
#include "features/parts/affine_patch.h"
#include "test_support.h"

namespace corrsel::core {
namespace {

using namespace testing;

/// Smooth random texture.
cv::Mat texture(cv::Size size, std::uint64_t seed = 1, double blur = 3) {
  Random random(seed);
  cv::Mat image(size, CV_32F);
  image.forEach<float>([](float& value, const int*) { value = 0; });
  for (int r = 0; r < size.height; ++r) {
    for (int c = 0; c < size.width; ++c) image.at<float>(r, c) = float(random.uniform(-1, 1));
  }
  cv::GaussianBlur(image, image, {}, blur);
  cv::normalize(image, image, 0, 255, cv::NORM_MINMAX);
  cv::Mat grey;
  image.convertTo(grey, CV_8U);
  return grey;
}

Features featuresOf(const std::vector<AffineFrame>& frames) {
  Features features;
  features.frames = frames;
  for (const AffineFrame& f : frames) features.keypoints.emplace_back(f[2], f[5], 2.0F);
  return features;
}

/// Similarity frames all over an image.
std::vector<AffineFrame> randomFrames(cv::Size size, int n, std::uint64_t seed = 2) {
  Random random(seed);
  std::vector<AffineFrame> frames;
  for (int i = 0; i < n; ++i) {
    const double s = random.uniform(1, 6), a = random.uniform(0, 2 * CV_PI);
    frames.push_back({float(s * std::cos(a)), float(-s * std::sin(a)),
                      float(random.uniform(0, size.width - 1)), float(s * std::sin(a)),
                      float(s * std::cos(a)), float(random.uniform(0, size.height - 1))});
  }
  return frames;
}

cv::Mat described(const cv::Mat& image, const std::vector<AffineFrame>& frames, bool root = false) {
  SiftOptions options;
  options.root = root;
  Features features = featuresOf(frames);
  PatchSift(options).describe(image, 1, Workspace::ofThread(), features);
  EXPECT_EQ(features.descriptors.rows, int(features.keypoints.size()));
  EXPECT_EQ(features.frames.size(), features.keypoints.size());
  return features.descriptors;
}

/// Frame followed by an affine map of the image, x' = map * x.
AffineFrame mapped(const cv::Matx23d& map, const AffineFrame& f) {
  const auto row = [&](int r, int c) {
    return map(r, 0) * f[std::size_t(c)] + map(r, 1) * f[std::size_t(3 + c)];
  };
  return {float(row(0, 0)), float(row(0, 1)), float(row(0, 2) + map(0, 2)),
          float(row(1, 0)), float(row(1, 1)), float(row(1, 2) + map(1, 2))};
}

TEST(PatchSift, SaysWhatItIs) {
  EXPECT_EQ(PatchSift().name(), "sift");
  const auto options = listOptions(PatchSift().options());
  EXPECT_EQ(options.back().name, "root");
}

TEST(PatchSift, GivesWholeNumbersOfLength512) {
  const cv::Mat image = texture({300, 200});
  for (const bool root : {false, true}) {
    const cv::Mat d = described(image, randomFrames(image.size(), 200), root);
    ASSERT_GT(d.rows, 180);
    EXPECT_EQ(d.cols, 128);
    EXPECT_EQ(d.type(), CV_32F);
    for (int i = 0; i < d.rows; ++i) {
      for (int k = 0; k < d.cols; ++k) {
        const float value = d.at<float>(i, k);
        ASSERT_TRUE(value >= 0 && value <= 255 && value == std::floor(value)) << value;
      }
      EXPECT_NEAR(cv::norm(d.row(i)), 512, 12);
    }
  }
}

TEST(PatchSift, RootIsTheSquareRootOfTheShares) {
  const cv::Mat image = texture({300, 200});
  const auto frames = randomFrames(image.size(), 50);
  const cv::Mat plain = described(image, frames), root = described(image, frames, true);
  ASSERT_EQ(plain.rows, root.rows);
  for (int i = 0; i < plain.rows; ++i) {
    const double sum = cv::sum(plain.row(i))[0];
    for (int k = 0; k < 128; ++k) {
      const double expected = 512 * std::sqrt(plain.at<float>(i, k) / sum);
      ASSERT_NEAR(root.at<float>(i, k), std::min(255.0, expected), 0.51);
    }
  }
}

TEST(PatchSift, FindsTheDirectionOfARamp) {
  // Brighter to the right: with the frame along x all gradients have direction 0, the first of each cell.
  cv::Mat image(100, 100, CV_8U);
  for (int c = 0; c < 100; ++c) image.col(c).setTo(2 * c);
  const double s = std::sqrt(0.5) * 3;
  const std::vector<std::pair<AffineFrame, int>> cases = {
      {{3, 0, 50, 0, 3, 50}, 0},
      {{0, -3, 50, 3, 0, 50}, 6},                              // first axis down: 270 degrees
      {{0, 3, 50, -3, 0, 50}, 2},                              // up: 90 degrees
      {{float(s), float(-s), 50, float(s), float(s), 50}, 7},  // down right: 315 degrees
  };
  for (const auto& [frame, direction] : cases) {
    const cv::Mat d = described(image, {frame});
    ASSERT_EQ(d.rows, 1);
    for (int k = 0; k < 128; ++k) {
      if (k % 8 == direction) {
        EXPECT_GT(d.at<float>(0, k), 20) << k;
      } else {
        EXPECT_LE(d.at<float>(0, k), 1) << k;
      }
    }
  }
}

TEST(PatchSift, CellsLieAlongTheAxes) {
  // Contrast in one quarter of the region only: right of and below the centre.
  cv::Mat image(100, 100, CV_8U, cv::Scalar(100));
  for (int r = 59; r < 64; ++r) {
    for (int c = 58; c < 64; ++c) image.at<std::uint8_t>(r, c) = 200;
  }
  const auto heaviestCell = [&](const AffineFrame& frame) {
    const cv::Mat d = described(image, {frame});
    int best = 0;
    double most = -1;
    for (int cell = 0; cell < 16; ++cell) {
      const double sum = cv::sum(d.colRange(8 * cell, 8 * cell + 8))[0];
      if (sum > most) {
        most = sum;
        best = cell;
      }
    }
    return best;
  };
  EXPECT_EQ(heaviestCell({2, 0, 50, 0, 2, 50}), 4 * 3 + 3);
  EXPECT_EQ(heaviestCell({-2, 0, 50, 0, -2, 50}), 0);
  EXPECT_EQ(heaviestCell({0, -2, 50, 2, 0, 50}), 4 * 0 + 3);  // first axis down, second axis to the left
}

TEST(PatchSift, TurnsWithTheImage) {
  const cv::Mat image = texture({301, 201});
  cv::Mat turned;
  cv::rotate(image, turned, cv::ROTATE_90_CLOCKWISE);
  const cv::Matx23d map(0, -1, 200, 1, 0, 0);
  std::vector<AffineFrame> left, right;
  for (const AffineFrame& frame : randomFrames(image.size(), 400)) {
    // A halved level ends one pixel before an odd side, so regions that reach over the border
    // differ.
    const float reach = 7.5F * (std::abs(frame[0]) + std::abs(frame[1])) + 8;
    if (frame[2] < reach || frame[5] < reach || frame[2] > 300 - reach || frame[5] > 200 - reach) continue;
    left.push_back(frame);
    right.push_back(mapped(map, frame));
  }
  const cv::Mat a = described(image, left), b = described(turned, right);
  ASSERT_EQ(a.rows, int(left.size()));
  ASSERT_EQ(b.rows, a.rows);
  ASSERT_GT(a.rows, 60);
  // Halved levels of images with odd sides hold the same pixels: only rounding differs.
  for (int i = 0; i < a.rows; ++i) EXPECT_LT(cv::norm(a.row(i), b.row(i)), 12) << i;
}

TEST(PatchSift, FollowsAffineFrames) {
  const cv::Mat image = texture({400, 300}, 1, 4);
  const cv::Matx23d map(1.3, 0.4, -20, -0.2, 0.9, 60);
  cv::Mat warped;
  cv::warpAffine(image, warped, map, {500, 400}, cv::INTER_CUBIC, cv::BORDER_REPLICATE);
  std::vector<AffineFrame> left, right;
  for (const AffineFrame& frame : randomFrames(image.size(), 300)) {
    if (frame[2] < 80 || frame[2] > 320 || frame[5] < 80 || frame[5] > 220) continue;
    left.push_back(frame);
    right.push_back(mapped(map, frame));
  }
  const cv::Mat a = described(image, left), b = described(warped, right);
  ASSERT_EQ(a.rows, int(left.size()));
  ASSERT_EQ(b.rows, a.rows);
  std::vector<double> same, other;
  for (int i = 0; i < a.rows; ++i) {
    same.push_back(cv::norm(a.row(i), b.row(i)));
    other.push_back(cv::norm(a.row(i), b.row((i + 1) % a.rows)));
  }
  EXPECT_LT(mean(same), 80);
  EXPECT_GT(mean(other), 300);
}

TEST(PatchSift, RemovesWhatCannotBeDescribed) {
  const float nan = std::numeric_limits<float>::quiet_NaN(), inf = std::numeric_limits<float>::infinity();
  cv::Mat image = texture({200, 200});
  image(cv::Rect(0, 0, 100, 100)).setTo(7);
  Features features = featuresOf({
      {2, 0, 150, 0, 2, 150},          // stays
      {nan, 0, 150, 0, 2, 150},        //
      {2, 0, 150, 0, inf, 150},        //
      {2, 0, nan, 0, 2, 150},          //
      {2, 0, -1, 0, 2, 150},           // outside
      {2, 0, 150, 0, 2, 199.5F},       // outside
      {2, 4, 150, 1, 2, 150},          // flat
      {0, 0, 150, 0, 0, 150},          // nothing
      {2, 0, 50, 0, 2, 50},            // one grey value
      {1e30F, 0, 150, 0, 1e30F, 150},  // mostly outside
      {2, 0, 199, 0, 2, 199},          // three quarters outside
      {2, 0, 190, 0, 2, 150},          // stays: less than half outside
  });
  for (std::size_t i = 0; i < features.keypoints.size(); ++i) features.keypoints[i].class_id = int(i);
  PatchSift().describe(image, 2, Workspace::ofThread(), features);
  ASSERT_EQ(features.keypoints.size(), 2u);
  EXPECT_EQ(features.keypoints[0].class_id, 0);
  EXPECT_EQ(features.keypoints[1].class_id, 11);
  EXPECT_EQ(features.frames[1][2], 190);
  EXPECT_EQ(features.descriptors.size(), cv::Size(128, 2));
  EXPECT_EQ(cv::norm(features.descriptors, described(image, features.frames)), 0);
}

TEST(PatchSift, SurvivesTinyImages) {
  for (const cv::Size size :
       {cv::Size(1, 1), cv::Size(2, 500), cv::Size(500, 2), cv::Size(1, 300), cv::Size(16, 16)}) {
    const cv::Mat image = texture(size, 3, 0.8);
    std::vector<AffineFrame> frames = randomFrames(size, 50);
    frames.push_back({0.1F, 0, 0, 0, 0.1F, 0});
    frames.push_back({1000, 0, 0, 0, 1000, 0});
    frames.push_back({0.05F, 0, 0, 0, 900, 0});
    const cv::Mat d = described(image, frames);
    EXPECT_LE(d.rows, int(frames.size()));
  }
  Features none;
  PatchSift().describe(texture({50, 50}), 2, Workspace::ofThread(), none);
  EXPECT_EQ(none.descriptors.rows, 0);
}

TEST(PatchSift, DoesNotDependOnThreads) {
  const cv::Mat image = texture({400, 300});
  const Features start = featuresOf(randomFrames(image.size(), 1000));
  Features expected = start;
  PatchSift().describe(image, 1, Workspace::ofThread(), expected);
  for (const int threads : {0, 2, 3, 7}) {
    Features features = start;
    PatchSift().describe(image, threads, Workspace::ofThread(), features);
    ASSERT_EQ(features.frames, expected.frames);
    EXPECT_EQ(cv::norm(features.descriptors, expected.descriptors, cv::NORM_INF), 0) << threads;
  }
}

/// A level whose pixel (r, c) has the grey level 3 c + 2 r + 5; its rows have gaps.
struct LinearLevel {
  cv::Mat pixels;
  ScaleLevel level;

  explicit LinearLevel(cv::Size size, double step = 2) : pixels(size.height, size.width + 10, CV_16S) {
    pixels.setTo(32640);
    for (int r = 0; r < size.height; ++r) {
      for (int c = 0; c < size.width; ++c) {
        pixels.at<std::int16_t>(r, c) = std::int16_t(kGreyUnit * std::min(255, 2 * c + r + 5));
      }
    }
    level = {pixels.ptr<std::int16_t>(), size.width + 10, size.width, size.height, step, 1};
  }
};

/// The sample of row r and column c, counted from the centre.
float sampleAt(const Patch& patch, int r, int c) {
  return patch.values[(r + Patch::kHalf) * Patch::kPitch + c + Patch::kHalf];
}

TEST(AffinePatch, SamplesALinearImageExactly) {
  const LinearLevel image({80, 60});
  const AffineFrame frame{2.5F, -0.5F, 70.3F, 1, 2, 61.7F};
  Patch patch;
  EXPECT_EQ(samplePatch(image.level, frame, 0.5, patch), 0);
  for (int r = -15; r <= 15; ++r) {
    for (int c = -15; c <= 15; ++c) {
      const double x = 70.3 + 0.5 * (2.5 * c - 0.5 * r), y = 61.7 + 0.5 * (c + 2 * r);
      EXPECT_NEAR(sampleAt(patch, r, c), x + 0.5 * y + 5, 0.01);
    }
  }
  // Everything lies to the left of the image, where the first column is repeated.
  EXPECT_EQ(samplePatch(image.level, {0, 0, -50, 0, 0, 20}, 0.5, patch), 31 * 31);
  EXPECT_EQ(sampleAt(patch, 0, 0), 10 + 5);
}

TEST(AffinePatch, RepeatsTheBorder) {
  const LinearLevel image({80, 60}, 1);
  Patch patch;
  // Sample (r, c) is pixel (r + 58, c + 10).
  EXPECT_EQ(samplePatch(image.level, {2, 0, 10, 0, 2, 58}, 0.5, patch), 5 * 31 + 14 * 26);
  for (int r = -15; r <= 15; ++r) {
    for (int c = -15; c <= 15; ++c) {
      EXPECT_EQ(sampleAt(patch, r, c), 2 * std::max(0, c + 10) + std::min(59, r + 58) + 5);
    }
  }
}

TEST(AffinePatch, FramesOfAnySizeAreSampled) {
  // Positions beyond the range of whole numbers are computed in another way, with the same result.
  const LinearLevel image({80, 60}, 1);
  Patch small, large;
  const AffineFrame frame{2000, 0, 40, 0, 2, 30};
  const int outside = samplePatch(image.level, frame, 0.5, small);
  EXPECT_EQ(outside, 30 * 31);
  EXPECT_EQ(samplePatch(image.level, {1e9F, 0, 40, 0, 2, 30}, 0.5, large), outside);
  for (int r = -15; r <= 15; ++r) {
    for (int c = -15; c <= 15; ++c) {
      ASSERT_EQ(sampleAt(small, r, c), sampleAt(large, r, c));
      ASSERT_EQ(sampleAt(small, r, c), (c < 0 ? 0 : c > 0 ? 158 : 80) + r + 30 + 5);
    }
  }
  // An image that is wider than the kernels' positions.
  cv::Mat wide(60, 40000, CV_16S, cv::Scalar(10 * kGreyUnit));
  wide.at<std::int16_t>(30, 35000) = 100 * kGreyUnit;
  const ScaleLevel level{wide.ptr<std::int16_t>(), 40000, 40000, 60, 1, 1};
  EXPECT_EQ(samplePatch(level, {2, 0, 35000, 0, 2, 30}, 0.5, small), 0);
  EXPECT_EQ(sampleAt(small, 0, 0), 100);
  EXPECT_EQ(sampleAt(small, 0, 1), 10);
}

TEST(AffinePatch, ChoosesTheLevelFromBelow) {
  std::vector<ScaleLevel> levels(3);
  levels[0].sigma = 1;
  levels[1].sigma = 2;
  levels[2].sigma = 4;
  EXPECT_EQ(levelFor(levels, 0.5).sigma, 1);
  EXPECT_EQ(levelFor(levels, 1.9).sigma, 1);
  EXPECT_EQ(levelFor(levels, 2).sigma, 2);
  EXPECT_EQ(levelFor(levels, 100).sigma, 4);
}

TEST(AffinePatch, MeasuresHalfAxes) {
  const HalfAxes axes = halfAxes({float(3 * std::cos(1)), float(-2 * std::sin(1)), 7, float(3 * std::sin(1)),
                                  float(2 * std::cos(1)), 8});
  EXPECT_NEAR(axes.smaller, 2, 1e-6);
  EXPECT_NEAR(axes.larger, 3, 1e-6);
  EXPECT_NEAR(halfAxes({2, 0, 0, 0, -5, 0}).smaller, 2, 1e-6);  // mirrored
}

}  // namespace
}  // namespace corrsel::core
