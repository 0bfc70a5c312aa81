#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>

#include "corrsel/features/extractor.h"
#include "corrsel/matching/matcher.h"
#include "feature_checks.h"
#include "features/detectors/asift.h"
#include "features/parts/feature_list.h"
#include "test_support.h"

namespace corrsel::core {
namespace {

using namespace testing;

/// Blobs and boxes of all sizes.
cv::Mat picture(const cv::Size& size = {420, 360}) {
  Random random(3);
  cv::Mat image(size, CV_8U, cv::Scalar(128));
  const auto below = [&random](int bound) { return int(random.index(std::uint32_t(bound))); };
  for (int i = 0; i < 500; ++i) {
    const int y = below(size.height), x = below(size.width);
    const cv::Point centre(x, y);
    const int radius = 3 + below(14);
    if (i % 2) {
      cv::circle(image, centre, radius, below(256), cv::FILLED);
    } else {
      cv::rectangle(image, centre, centre + cv::Point(radius, 2 * radius), below(256), cv::FILLED);
    }
  }
  cv::GaussianBlur(image, image, {}, 0.8);
  return image;
}

/// Turned by 30 degrees and compressed three times across.
cv::Matx33d tilted() {
  const double c = std::cos(CV_PI / 6), s = std::sin(CV_PI / 6);
  return {c, -s, 190, s / 3, c / 3, 10, 0, 0, 1};
}

cv::Mat warped(const cv::Mat& image, const cv::Matx33d& map) {
  // Blurred along the direction that is compressed.
  const double sigma = 0.8 * std::sqrt(8.0);
  const cv::Matx22d turn(map(0, 0), map(0, 1), 3 * map(1, 0), 3 * map(1, 1));
  cv::Mat turned, small;
  cv::warpAffine(image, turned,
                 cv::Matx23d(turn(0, 0), turn(0, 1), map(0, 2), turn(1, 0), turn(1, 1), 3 * map(1, 2)),
                 {570, 580}, cv::INTER_LINEAR, cv::BORDER_CONSTANT, 128);
  cv::GaussianBlur(turned, turned, {1, 0}, 0.01, sigma);
  cv::warpAffine(turned, small, cv::Matx23d(1, 0, 0, 0, 1.0 / 3, 0), {570, 195}, cv::INTER_LINEAR,
                 cv::BORDER_REPLICATE);
  return small;
}

Features extract(const cv::Mat& image, const AsiftOptions& options = {}, int threads = 1) {
  Features features;
  features.image_size = image.size();
  DetectionRequest request{image, threads};
  request.describe = true;
  AsiftDetector(options).detect(request, features);
  return features;
}

std::vector<std::size_t> rightMatches(const Correspondences& m, const cv::Matx33d& map) {
  std::vector<std::size_t> right;
  for (std::size_t i = 0; i < m.size(); ++i) {
    const cv::Point2d truth = projected(map, m.left_x[i], m.left_y[i]);
    if (std::hypot(truth.x - m.right_x[i], truth.y - m.right_y[i]) <= 3) right.push_back(i);
  }
  return right;
}

cv::Matx22d linear(const AffineFrame& f) { return {f[0], f[1], f[3], f[4]}; }

TEST(Asift, MatchesATiltedViewWhereSiftDoesNot) {
  const cv::Mat left = picture(), right = warped(left, tilted());
  const Correspondences matches = matchFeatures(extract(left), extract(right));
  const std::size_t ours = rightMatches(matches, tilted()).size();
  const auto sift = createExtractor("sift+sift");
  const std::size_t theirs =
      rightMatches(matchFeatures(sift->extract(left), sift->extract(right)), tilted()).size();
  RecordProperty("asift", int(ours));
  RecordProperty("sift", int(theirs));
  EXPECT_GE(ours, 100u);
  EXPECT_GE(ours, 5 * theirs);
}

TEST(Asift, FramesFollowTheMap) {
  const cv::Mat left = picture(), right = warped(left, tilted());
  const Features l = extract(left), r = extract(right);
  const Correspondences m = matchFeatures(l, r);
  const cv::Matx22d map(tilted()(0, 0), tilted()(0, 1), tilted()(1, 0), tilted()(1, 1));
  const std::vector<AffineFrame> round_left = similarityFrames(l.keypoints),
                                 round_right = similarityFrames(r.keypoints);
  // How far the map between two frames is from the true one. Discs have no direction of their own: the
  // rotation that is left, by polar decomposition, does not count.
  const auto deviation = [&map](const AffineFrame& from, const AffineFrame& to) {
    const cv::Matx22d b = map * linear(from), a = linear(to);
    const cv::Matx22d difference = b.inv() * a;
    cv::Matx21d w;
    cv::Matx22d u, vt;
    cv::SVD::compute(difference, w, u, vt);
    return std::hypot(w(0) - 1, w(1) - 1);
  };
  std::vector<double> affine, similar, with_turn;
  for (const std::size_t i : rightMatches(m, tilted())) {
    affine.push_back(deviation(m.left_frame[i], m.right_frame[i]));
    similar.push_back(deviation(round_left[m.left_index[i]], round_right[m.right_index[i]]));
    const cv::Matx22d found = linear(m.right_frame[i]) * linear(m.left_frame[i]).inv();
    with_turn.push_back(cv::norm(found * map.inv() - cv::Matx22d::eye()));
  }
  const auto median = [](std::vector<double>& values) {
    std::nth_element(values.begin(), values.begin() + std::ptrdiff_t(values.size() / 2), values.end());
    return values[values.size() / 2];
  };
  ASSERT_GE(affine.size(), 100u);
  // Neighbouring views differ by a tilt of sqrt(2): a deviation of 0.29 if split evenly between the axes.
  EXPECT_LT(median(affine), 0.35);
  EXPECT_LT(median(affine), 0.5 * median(similar));
  EXPECT_LT(median(with_turn), 0.5);
}

TEST(Asift, KeypointsAreThoseOfTheFrames) {
  const Features f = extract(picture());
  ASSERT_GT(f.keypoints.size(), 500u);
  ASSERT_EQ(f.frames.size(), f.keypoints.size());
  int views = 0;
  for (std::size_t i = 0; i < f.keypoints.size(); ++i) {
    const cv::KeyPoint& k = f.keypoints[i];
    const AffineFrame& a = f.frames[i];
    ASSERT_TRUE(k.pt.x == a[2] && k.pt.y == a[5]);
    ASSERT_NEAR(k.size, 2 * std::sqrt(std::abs(cv::determinant(linear(a)))), 1e-3 * k.size);
    ASSERT_NEAR(std::remainder(std::atan2(a[3], a[0]) * 180 / CV_PI - k.angle, 360), 0, 1e-2);
    ASSERT_TRUE(k.angle >= 0 && k.angle < 360);
    ASSERT_TRUE(i == 0 || k.response <= f.keypoints[i - 1].response);
    views = std::max(views, k.class_id + 1);
  }
  EXPECT_GT(views, 20);
}

TEST(Asift, DescriptorsAreWholeNumbersOfOpenCvsLength) {
  const Features f = extract(picture());
  ASSERT_EQ(f.descriptors.rows, int(f.keypoints.size()));
  ASSERT_EQ(f.descriptors.type(), CV_32F);
  ASSERT_EQ(f.descriptors.cols, 128);
  for (int i = 0; i < f.descriptors.rows; ++i) {
    for (int k = 0; k < 128; ++k) {
      const float v = f.descriptors.at<float>(i, k);
      ASSERT_TRUE(v >= 0 && v <= 255 && v == std::round(v));
    }
    ASSERT_NEAR(cv::norm(f.descriptors.row(i)), 512, 40);
  }
}

TEST(Asift, DetectFindsTheSameFeatures) {
  Features detected;
  AsiftDetector().detect({picture()}, detected);
  expectSameKeypoints(detected, extract(picture()));
}

TEST(Asift, MergesViewsOfOneKeypoint) {
  AsiftOptions separate;
  separate.merge_distance = separate.merge_shape = 0;
  const AsiftOptions options;
  const Features f = extract(picture()), unmerged = extract(picture(), separate);
  EXPECT_LT(f.keypoints.size(), 0.9 * double(unmerged.keypoints.size()));
  for (std::size_t i = 0; i < f.frames.size(); ++i) {
    const cv::Matx22d back = linear(f.frames[i]).inv();
    for (std::size_t j = i + 1; j < f.frames.size(); ++j) {
      const cv::Vec2d d(f.frames[j][2] - f.frames[i][2], f.frames[j][5] - f.frames[i][5]);
      const bool same =
          cv::norm(back * d) < options.merge_distance - 1e-4 &&
          cv::norm(back * linear(f.frames[j]) - cv::Matx22d::eye()) < options.merge_shape - 1e-4;
      ASSERT_FALSE(same) << i << " " << j;
    }
  }
}

TEST(Asift, ThreadsChangeNothing) {
  const Features one = extract(picture());
  for (const int threads : {2, 3}) {
    const Features more = extract(picture(), {}, threads);
    expectSameKeypoints(one, more);
    EXPECT_EQ(cv::norm(one.descriptors, more.descriptors, cv::NORM_INF), 0);
  }
}

TEST(Asift, NothingInBlankTinyAndThinImages) {
  EXPECT_TRUE(extract(cv::Mat(200, 300, CV_8U, cv::Scalar(90))).keypoints.empty());
  for (const cv::Size& size : {cv::Size(1, 1), cv::Size(10, 10), cv::Size(1, 400), cv::Size(400, 1)}) {
    const Features f =
        extract(picture()(cv::Rect(0, 0, std::min(size.width, 420), std::min(size.height, 360))));
    EXPECT_TRUE(f.keypoints.empty()) << size;
    EXPECT_EQ(f.descriptors.rows, 0);
  }
  EXPECT_NO_THROW(extract(picture()(cv::Rect(0, 0, 16, 16))));
  EXPECT_NO_THROW(extract(picture()(cv::Rect(0, 0, 400, 20))));
}

TEST(Asift, OptionsOutOfRangeAreNamed) {
  AsiftOptions options;
  options.tilts = 9;
  EXPECT_TRUE(mentions(errorOf<std::invalid_argument>([&] { AsiftDetector detector(options); }),
                       {"tilts = 9", "[0, 8]"}));
}

TEST(Asift, AtMost15000FeaturesOnGraffiti) {
  const std::string folder = sharedData("vgg");
  if (folder.empty()) GTEST_SKIP() << "the vgg dataset is not here";
  const Features f = extract(cv::imread(folder + "/graf/img1.ppm", cv::IMREAD_GRAYSCALE), {}, 2);
  EXPECT_GT(f.keypoints.size(), 5000u);
  EXPECT_LE(f.keypoints.size(), 15000u);
}

}  // namespace
}  // namespace corrsel::core
