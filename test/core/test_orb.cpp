#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <opencv2/imgproc.hpp>

#include "corrsel/features/extractor.h"
#include "corrsel/matching/matcher.h"
#include "feature_checks.h"
#include "features/descriptors/orb.h"
#include "features/detectors/orb.h"
#include "features/parts/feature_list.h"
#include "features/parts/image_pyramid.h"
#include "kernels/kernels.h"
#include "test_support.h"

namespace corrsel::core {
namespace {

using namespace testing;

Features detect(const cv::Mat& image, const OrbOptions& options = {}, bool describe = true, int threads = 1,
                const PlaceMask& mask = {}) {
  Features features;
  OrbDetector(options).detect({image, threads, mask, describe}, features);
  features.image_size = image.size();
  return features;
}

OrbOptions withLimit(int most) {
  OrbOptions options;
  options.max_features = most;
  return options;
}

/// Noise under many shapes, so that a level has many more corners than its share.
cv::Mat busyPicture(const cv::Size& size = {640, 480}) {
  cv::Mat image = shapes(1, size);
  Random random(9);
  for (int y = 0; y < size.height; ++y) {
    for (int x = 0; x < size.width; ++x) {
      auto& grey = image.at<std::uint8_t>(y, x);
      grey = cv::saturate_cast<std::uint8_t>(grey + random.uniform(-30, 30));
    }
  }
  cv::GaussianBlur(image, image, {}, 0.7);
  return image;
}

TEST(Orb, KeypointsFollowTheConventions) {
  const cv::Mat image = busyPicture();
  const Features features = detect(image, withLimit(0));
  ASSERT_GT(features.keypoints.size(), 1000u);
  EXPECT_EQ(features.descriptors.size(), cv::Size(32, int(features.keypoints.size())));
  EXPECT_EQ(features.descriptors.type(), CV_8U);
  const std::vector<AffineFrame> frames = similarityFrames(features.keypoints);
  std::map<int, int> octaves;
  for (std::size_t i = 0; i < features.keypoints.size(); ++i) {
    const cv::KeyPoint& keypoint = features.keypoints[i];
    ++octaves[keypoint.octave];
    const double scale = std::pow(1.2, keypoint.octave);
    EXPECT_FLOAT_EQ(keypoint.size, float(31 * scale));
    EXPECT_GE(keypoint.angle, 0);
    EXPECT_LT(keypoint.angle, 360);
    EXPECT_EQ(keypoint.class_id, -1);
    EXPECT_GE(keypoint.pt.x, 30 * scale);
    EXPECT_LE(keypoint.pt.x, 640 - 30 * scale);
    for (std::size_t k = 0; k < 6; ++k)
      EXPECT_NEAR(features.frames[i][k], frames[i][k], 1e-4 * keypoint.size);
    if (i > 0) {
      EXPECT_FALSE(stronger(keypoint, features.keypoints[i - 1]));
    }
  }
  EXPECT_EQ(octaves.size(), 8u);
  for (const cv::KeyPoint& keypoint : detect(image, withLimit(0), false).keypoints) {
    EXPECT_FLOAT_EQ(keypoint.size, float(7 * std::pow(1.2, keypoint.octave)));
  }
}

TEST(Orb, FindsTheCornersOfASquare) {
  cv::Mat image(200, 200, CV_8U, cv::Scalar(40));
  cv::rectangle(image, {70, 80}, {129, 119}, 200, cv::FILLED);
  OrbOptions options;
  options.levels = 1;
  const Features features = detect(image, options);
  for (const cv::Point corner :
       {cv::Point(70, 80), cv::Point(129, 80), cv::Point(70, 119), cv::Point(129, 119)}) {
    double nearest = 100;
    for (const cv::KeyPoint& keypoint : features.keypoints) {
      const cv::Point2f offset = keypoint.pt - cv::Point2f(corner);
      const double distance = std::hypot(offset.x, offset.y);
      if (distance >= nearest) continue;
      nearest = distance;
      // The bright side is towards the centre of the square.
      const double angle = std::atan2(99.5 - corner.y, 99.5 - corner.x) * 180 / CV_PI;
      if (distance <= 2) {
        EXPECT_LT(std::abs(std::remainder(keypoint.angle - angle, 360)), 40);
      }
    }
    EXPECT_LE(nearest, 2) << corner;
  }
}

TEST(Orb, DoesNotDependOnThreadsNorKernels) {
  LevelGuard guard;
  const cv::Mat image = busyPicture();
  for (const int most : {0, 500}) {
    for (const bool spread : {false, true}) {
      OrbOptions options = withLimit(most);
      options.spread = spread;
      setKernelLevel(KernelLevel::kPlain);
      const Features expected = detect(image, options);
      ASSERT_GT(expected.keypoints.size(), 400u);
      for (const KernelLevel level : supportedKernelLevels()) {
        setKernelLevel(level);
        for (const int threads : {1, 2, 3, 7}) {
          SCOPED_TRACE(toString(level) + " " + std::to_string(threads));
          expectSame(detect(image, options, true, threads), expected);
        }
      }
    }
  }
}

/// The result of a limit, computed the long way from the scores and responses of all corners.
std::vector<cv::KeyPoint> limited(const cv::Mat& image, const Features& all, int most) {
  const std::vector<int> shares = levelShares(most, 1.2, 8);
  ImagePyramid pyramid;
  pyramid.start(image, 1.2, 8, false);
  for (int level = 1; level < 8; ++level) pyramid.reduce(level, Workspace::ofThread());
  std::vector<cv::KeyPoint> result;
  for (int number = 0; number < 8; ++number) {
    const PyramidLevel& level = pyramid.level(number);
    std::vector<std::pair<int, cv::KeyPoint>> corners;  // FAST's score
    for (const cv::KeyPoint& keypoint : all.keypoints) {
      if (keypoint.octave != number) continue;
      const cv::Point at = level.fromImage(keypoint.pt);
      std::array<std::uint8_t, 1 + kCornerPadding> score{};
      kernels().corners.scores(level.pixels + at.y * level.stride + at.x, level.stride, 1, 20, score.data());
      corners.emplace_back(score[0], keypoint);
    }
    const auto share = std::size_t(shares[std::size_t(number)]);
    std::vector<int> scores;
    for (const auto& corner : corners) scores.push_back(corner.first);
    std::sort(scores.rbegin(), scores.rend());
    const int least = share > 0 && scores.size() > 2 * share ? scores[2 * share - 1] : 0;
    std::vector<cv::KeyPoint> kept;
    for (const auto& [score, keypoint] : corners) {
      if (score >= least) kept.push_back(keypoint);
    }
    std::sort(kept.begin(), kept.end(), stronger);
    kept.resize(std::min(kept.size(), share));
    result.insert(result.end(), kept.begin(), kept.end());
  }
  std::sort(result.begin(), result.end(), stronger);
  return result;
}

/// The features of `all` at the given keypoints.
Features selected(const Features& all, const std::vector<cv::KeyPoint>& keypoints) {
  std::vector<int> order;
  for (const cv::KeyPoint& keypoint : keypoints) {
    for (std::size_t i = 0; i < all.keypoints.size(); ++i) {
      if (all.keypoints[i].pt == keypoint.pt && all.keypoints[i].octave == keypoint.octave)
        order.push_back(int(i));
    }
  }
  Features result = all;
  reorder(order, result);
  return result;
}

TEST(Orb, LimitsGiveTheSameAsAllCornersCutAfterwards) {
  const cv::Mat image = busyPicture();
  const Features all = detect(image, withLimit(0));
  for (const int most : {10, 100, 1000, 2000}) {
    SCOPED_TRACE(most);
    const Features expected = selected(all, limited(image, all, most));
    EXPECT_GT(expected.keypoints.size(), std::size_t(most) * 9 / 10);
    expectSame(detect(image, withLimit(most)), expected);
  }
}

TEST(Orb, SpreadGivesTheSameAsAllCornersSpreadAfterwards) {
  const cv::Mat image = busyPicture();
  Features expected = detect(image, withLimit(0));
  keepStrongest(300, true, image.size(), expected);
  OrbOptions options = withLimit(300);
  options.spread = true;
  expectSame(detect(image, options), expected);
}

TEST(Orb, MasksGiveTheSameAsAllCornersDroppedAfterwards) {
  const cv::Mat image = busyPicture();
  cv::Mat mask(image.size(), CV_8U, cv::Scalar(255));
  mask(cv::Rect(100, 0, 250, 480)).setTo(0);
  cv::circle(mask, {450, 300}, 60, 0, cv::FILLED);
  for (int x = 400; x < 640; x += 9) mask.col(x).setTo(0);
  const PlaceMask places(mask, AreaTransform(image.size(), {{0, 0}, image.size()}));
  Features all = detect(image, withLimit(0));
  places.apply(all);
  ASSERT_GT(all.keypoints.size(), 500u);
  for (const int threads : {1, 3}) {
    expectSame(detect(image, withLimit(0), true, threads, places), all);
    expectSame(detect(image, withLimit(400), true, threads, places), selected(all, limited(image, all, 400)));
    OrbOptions options = withLimit(200);
    options.spread = true;
    Features spread = all;
    keepStrongest(200, true, image.size(), spread);
    expectSame(detect(image, options, true, threads, places), spread);
  }
  const PlaceMask nothing(cv::Mat::zeros(image.size(), CV_8U),
                          AreaTransform(image.size(), {{0, 0}, image.size()}));
  EXPECT_TRUE(detect(image, {}, true, 1, nothing).keypoints.empty());
}

TEST(Orb, TheDescriptorOfItsOwnKeypointsIsTheSame) {
  const cv::Mat image = busyPicture();
  const Features expected = detect(image, withLimit(700));
  Features features = detect(image, withLimit(700), false);
  for (const int threads : {1, 3}) {
    Features described = features;
    OrbDescriptor().describe(image, threads, Workspace::ofThread(), described);
    ASSERT_EQ(described.keypoints.size(), expected.keypoints.size());
    EXPECT_EQ(cv::norm(described.descriptors, expected.descriptors, cv::NORM_INF), 0);
  }
}

TEST(Orb, TurnedImagesMatch) {
  const cv::Mat image = busyPicture({500, 500});
  const Features left = detect(image, withLimit(800));
  for (const double angle : {20.0, 90.0, 137.0, 180.0}) {
    const cv::Mat turn = cv::getRotationMatrix2D({249.5F, 249.5F}, -angle, 1);
    cv::Mat turned;
    cv::warpAffine(image, turned, turn, image.size(), cv::INTER_LINEAR, cv::BORDER_REFLECT);
    const Features right = detect(turned, withLimit(800));
    const Correspondences matches = matchFeatures(left, right);
    int inside = 0, correct = 0;
    for (std::size_t i = 0; i < matches.size(); ++i) {
      const cv::Vec2d x(matches.left_x[i], matches.left_y[i]);
      if (std::hypot(x[0] - 249.5, x[1] - 249.5) > 180) continue;
      ++inside;
      const double u = turn.at<double>(0, 0) * x[0] + turn.at<double>(0, 1) * x[1] + turn.at<double>(0, 2);
      const double v = turn.at<double>(1, 0) * x[0] + turn.at<double>(1, 1) * x[1] + turn.at<double>(1, 2);
      correct += std::hypot(u - matches.right_x[i], v - matches.right_y[i]) <= 4 ? 1 : 0;
    }
    EXPECT_GT(correct, 0.6 * inside) << angle;
    EXPECT_GT(inside, 200);
  }
}

TEST(Orb, BlankAndTinyImagesHaveNoFeatures) {
  for (const cv::Size size : {cv::Size(1, 1), cv::Size(62, 400), cv::Size(400, 62), cv::Size(300, 300)}) {
    EXPECT_TRUE(detect(cv::Mat(size, CV_8U, cv::Scalar(90)), {}, true, 2).keypoints.empty());
  }
  const cv::Mat image = shapes(1, {63, 63});
  EXPECT_TRUE(detect(image(cv::Rect(0, 0, 62, 63))).keypoints.empty());
  Features features = detect(image);  // one pixel is far enough from the border
  EXPECT_LE(features.keypoints.size(), 1u);
}

TEST(Orb, NarrowImagesHaveFeaturesOnTheLevelsThatAreLargeEnough) {
  for (int side = 60; side <= 100; side += 3) {
    for (const cv::Size size : {cv::Size(side, 240), cv::Size(240, side)}) {
      const Features features = detect(busyPicture(size));
      EXPECT_EQ(features.keypoints.empty(), side <= 62) << size;
      for (const cv::KeyPoint& keypoint : features.keypoints) {
        EXPECT_GT(side / std::pow(1.2, keypoint.octave), 62) << size;
      }
    }
  }
}

TEST(Orb, EveryPatchSizeAndScaleFactorWorks) {
  const cv::Mat image = busyPicture({400, 300});
  for (const int patch_size : {5, 6, 20, 64, 127}) {
    for (const double factor : {1.05, 1.9, 2.0, 3.0}) {
      OrbOptions options;
      options.patch_size = patch_size;
      options.scale_factor = factor;
      options.levels = 16;
      const Features features = detect(image, options, true, 2);
      EXPECT_GT(features.keypoints.size(), patch_size > 100 ? 20u : 100u) << patch_size << " " << factor;
      expectSame(detect(image, options), features);
    }
  }
}

TEST(Orb, NamesOptionsOutOfRange) {
  OrbOptions options;
  options.levels = 99;
  EXPECT_EQ(errorOf<std::invalid_argument>([&] { OrbDetector detector(options); }),
            "option levels = 99 is outside [1, 16]");
}

}  // namespace
}  // namespace corrsel::core
