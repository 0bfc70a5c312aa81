#include <gtest/gtest.h>

#include <map>
#include <opencv2/imgproc.hpp>

#include "corrsel/features/extractor.h"
#include "test_support.h"

namespace corrsel::core {
namespace {

using namespace testing;

/// Squares and discs of all sizes on a grey ground, with a little texture.
cv::Mat picture(int channels = 1, cv::Size size = {400, 300}, std::uint64_t seed = 1) {
  Random random(seed);
  cv::Mat image(size, CV_8UC(channels), cv::Scalar::all(128));
  const auto below = [&random](int bound) { return int(random.index(std::uint32_t(bound))); };
  for (int i = 0; i < 150; ++i) {
    const cv::Point centre(below(size.width), below(size.height));
    const int radius = 2 + below(14);
    const cv::Scalar colour(below(256), below(256), below(256), 255);
    if (i % 2) {
      cv::circle(image, centre, radius, colour, cv::FILLED);
    } else {
      cv::rectangle(image, centre, centre + cv::Point(radius, 2 * radius), colour, cv::FILLED);
    }
  }
  cv::GaussianBlur(image, image, {}, 0.8);
  return image;
}

void expectSame(const Features& a, const Features& b) {
  ASSERT_EQ(a.keypoints.size(), b.keypoints.size());
  for (std::size_t i = 0; i < a.keypoints.size(); ++i) {
    const cv::KeyPoint &p = a.keypoints[i], &q = b.keypoints[i];
    ASSERT_TRUE(p.pt == q.pt && p.size == q.size && p.angle == q.angle && p.response == q.response &&
                p.octave == q.octave)
        << i;
  }
  ASSERT_EQ(a.descriptors.size(), b.descriptors.size());
  EXPECT_EQ(a.descriptors.type(), b.descriptors.type());
  if (!a.descriptors.empty()) {
    EXPECT_EQ(cv::norm(a.descriptors, b.descriptors, cv::NORM_INF), 0);
  }
  EXPECT_EQ(a.image_size, b.image_size);
}

class EveryExtractor : public ::testing::TestWithParam<std::string> {
 protected:
  std::unique_ptr<FeatureExtractor> create(const OptionMap& options = {}) const {
    return createExtractor(GetParam(), options);
  }
};

TEST_P(EveryExtractor, DescribesEveryKeypoint) {
  const cv::Mat image = picture();
  const auto extractor = create();
  EXPECT_EQ(extractor->name(), GetParam());
  const Features features = extractor->extract(image);
  EXPECT_GT(features.keypoints.size(), 100u);
  EXPECT_EQ(features.descriptors.rows, int(features.keypoints.size()));
  EXPECT_EQ(features.descriptors.type(), GetParam() == "orb+orb" ? CV_8U : CV_32F);
  EXPECT_EQ(features.descriptors.cols, GetParam() == "orb+orb" ? 32 : 128);
  EXPECT_EQ(features.image_size, image.size());
  EXPECT_GT(features.detect_seconds, 0);
  EXPECT_GT(features.describe_seconds, 0);
  for (const cv::KeyPoint& p : features.keypoints) {
    EXPECT_TRUE(cv::Rect2f(0, 0, 400, 300).contains(p.pt)) << p.pt;
  }
}

TEST_P(EveryExtractor, FramesAreScaleAndAngle) {
  const Features f = createExtractor(GetParam())->extract(picture());
  ASSERT_EQ(f.frames.size(), f.keypoints.size());
  for (std::size_t i = 0; i < f.frames.size(); ++i) {
    const cv::KeyPoint& k = f.keypoints[i];
    const AffineFrame& a = f.frames[i];
    ASSERT_TRUE(a[2] == k.pt.x && a[5] == k.pt.y);
    ASSERT_NEAR(std::hypot(a[0], a[3]), k.size / 2, 1e-3);
    ASSERT_TRUE(a[0] == a[4] && a[1] == -a[3]);
    const double difference = std::atan2(a[3], a[0]) * 180 / CV_PI - k.angle;
    ASSERT_NEAR(std::remainder(difference, 360), 0, 1e-2);
  }
}

TEST_P(EveryExtractor, DescriptorsBelongToTheirKeypoints) {
  // Of a picture and the same picture moved by 8 px, equal descriptors must be 8 px apart.
  const cv::Mat image = picture(1, {408, 300});
  const Features a = create()->extract(image.colRange(0, 400)), b = create()->extract(image.colRange(8, 408));
  int equal = 0, moved = 0;
  for (int i = 0; i < a.descriptors.rows; ++i) {
    for (int j = 0; j < b.descriptors.rows; ++j) {
      if (cv::norm(a.descriptors.row(i), b.descriptors.row(j), cv::NORM_INF) != 0) continue;
      ++equal;
      const cv::Point2f motion = a.keypoints[std::size_t(i)].pt - b.keypoints[std::size_t(j)].pt;
      moved += cv::norm(motion - cv::Point2f(8, 0)) < 0.1;
    }
  }
  EXPECT_GT(equal, 20);
  EXPECT_GE(moved, 0.9 * equal);
}

TEST_P(EveryExtractor, StrongestFirst) {
  const Features features = create()->extract(picture());
  for (std::size_t i = 1; i < features.keypoints.size(); ++i) {
    ASSERT_GE(features.keypoints[i - 1].response, features.keypoints[i].response) << i;
  }
}

TEST_P(EveryExtractor, KeepsTheStrongestUpToTheCap) {
  const cv::Mat image = picture();
  const Features all = create()->extract(image);
  const Features some = create({{"max_features", "40"}})->extract(image);
  EXPECT_EQ(some.keypoints.size(), 40u);
  EXPECT_EQ(some.descriptors.rows, 40);
  // ORB hands out its cap over the levels of the pyramid.
  if (GetParam() == "sift+sift") {
    for (std::size_t i = 0; i < 40; ++i) {
      EXPECT_EQ(some.keypoints[i].pt, all.keypoints[i].pt);
      EXPECT_EQ(some.keypoints[i].response, all.keypoints[i].response);
    }
    // OpenCV builds the scale space from the largest octave that is asked for: descriptors change a little.
    EXPECT_LT(cv::norm(some.descriptors, all.descriptors.rowRange(0, 40), cv::NORM_INF), 40);
  }
  EXPECT_EQ(create({{"max_features", "1"}})->extract(image).keypoints.size(), 1u);
}

TEST_P(EveryExtractor, BlankAndTinyImagesHaveNoFeatures) {
  const std::vector<cv::Mat> images = {
      cv::Mat(200, 200, CV_8U, cv::Scalar(0)), cv::Mat(200, 200, CV_8UC3, cv::Scalar::all(255)),
      cv::Mat(1, 1, CV_8U, cv::Scalar(7)),     cv::Mat(1, 500, CV_8U, cv::Scalar(7)),
      cv::Mat(500, 1, CV_8U, cv::Scalar(7)),   picture()({0, 0, 8, 8}).clone()};
  for (const cv::Mat& image : images) {
    const Features features = create()->extract(image);
    EXPECT_TRUE(features.keypoints.empty()) << image.size();
    EXPECT_TRUE(features.descriptors.empty());
    EXPECT_EQ(features.image_size, image.size());
  }
}

TEST_P(EveryExtractor, SmallImagesDoNoHarm) {
  for (int side = 1; side <= 90; ++side) {
    const Features features = create()->extract(picture(1, {side, side}));
    ASSERT_EQ(features.descriptors.rows, int(features.keypoints.size())) << side;
  }
  const Features sixteen = create()->extract(picture()({100, 100, 16, 16}));
  EXPECT_EQ(sixteen.image_size, cv::Size(16, 16));
  EXPECT_EQ(sixteen.descriptors.rows, int(sixteen.keypoints.size()));
}

TEST_P(EveryExtractor, ColourIsTurnedToGrey) {
  const cv::Mat colour = picture(3);
  cv::Mat grey, with_alpha;
  cv::cvtColor(colour, grey, cv::COLOR_BGR2GRAY);
  cv::cvtColor(colour, with_alpha, cv::COLOR_BGR2BGRA);
  const Features expected = create()->extract(grey);
  EXPECT_GT(expected.keypoints.size(), 50u);
  expectSame(create()->extract(colour), expected);
  expectSame(create()->extract(with_alpha), expected);
}

TEST_P(EveryExtractor, PartsOfImagesAreImages) {
  const cv::Mat image = picture();
  const cv::Rect part(50, 40, 300, 200);
  expectSame(create()->extract(image(part)), create()->extract(image(part).clone()));
}

TEST_P(EveryExtractor, RefusesOtherImagesByName) {
  const auto refusal = [this](const cv::Mat& image) {
    return errorOf<std::invalid_argument>([&] { create()->extract(image); });
  };
  const std::string needed = "; needed: 8 bits with 1, 3 (BGR) or 4 (BGRA) channels";
  EXPECT_EQ(refusal({}), "image is empty");
  EXPECT_EQ(refusal(cv::Mat(100, 100, CV_16U, cv::Scalar(0))), "image has type CV_16UC1" + needed);
  EXPECT_EQ(refusal(cv::Mat(100, 100, CV_32FC3, cv::Scalar(0))), "image has type CV_32FC3" + needed);
  EXPECT_EQ(refusal(cv::Mat(100, 100, CV_8UC2, cv::Scalar(0))), "image has type CV_8UC2" + needed);
  EXPECT_EQ(refusal(cv::Mat(2, 2, CV_16U, cv::Scalar(0))), "image has type CV_16UC1" + needed);
}

TEST_P(EveryExtractor, DoesNotDependOnThreads) {
  const cv::Mat left = picture(1, {500, 400}, 2), right = picture(3, {400, 300}, 3);
  const auto extractor = create();
  const Features expected_left = create()->extract(left), expected_right = create()->extract(right);
  const int before = cv::getNumThreads();
  for (const int opencv_threads : {1, 2}) {
    cv::setNumThreads(opencv_threads);
    for (const int threads : {0, 1, 2}) {
      const auto [a, b] = extractPair(*extractor, left, right, threads);
      expectSame(a, expected_left);
      expectSame(b, expected_right);
    }
  }
  cv::setNumThreads(before);
  // An error on either side comes through, from the other thread too.
  for (const int threads : {1, 2}) {
    EXPECT_EQ(errorOf([&] { extractPair(*extractor, left, {}, threads); }), "image is empty");
    EXPECT_EQ(errorOf([&] { extractPair(*extractor, {}, right, threads); }), "image is empty");
  }
}

INSTANTIATE_TEST_SUITE_P(All, EveryExtractor, ::testing::ValuesIn(extractorNames()),
                         [](const ::testing::TestParamInfo<std::string>& info) {
                           return info.param.substr(0, info.param.find('+'));
                         });

TEST(Extractor, NamesWhatIsValid) {
  EXPECT_EQ(extractorNames(), (std::vector<std::string>{"sift+sift", "orb+orb"}));
  EXPECT_EQ(errorOf<std::invalid_argument>([] { createExtractor("sift+orb"); }),
            "unknown features 'sift+orb'; valid: sift+sift, orb+orb");
  EXPECT_EQ(
      errorOf<std::invalid_argument>([] {
        createExtractor("orb+orb", {{"sigma", "1"}});
      }),
      "unknown option orb.sigma; valid: max_features, scale_factor, levels, fast_threshold, patch_size");
}

TEST(Extractor, NamesOptionsOutOfRange) {
  const auto refusal = [](const std::string& name, const OptionMap& options) {
    return errorOf<std::invalid_argument>([&] { createExtractor(name, options); });
  };
  EXPECT_EQ(refusal("orb+orb", {{"max_features", "0"}}),
            "orb: option max_features = 0 is outside [1, 100000]");
  EXPECT_EQ(refusal("orb+orb", {{"scale_factor", "1"}}), "orb: option scale_factor = 1 is outside [1.05, 3]");
  EXPECT_EQ(refusal("sift+sift", {{"max_features", "-1"}}),
            "sift: option max_features = -1 is outside [0, 100000]");
  EXPECT_EQ(refusal("sift+sift", {{"sigma", "x"}}), "option sift.sigma: 'x' is not a number");
}

TEST(Extractor, OptionsReachTheAlgorithm) {
  const cv::Mat image = picture();
  const auto count = [&image](const std::string& name, const OptionMap& options) {
    return createExtractor(name, options)->extract(image).keypoints.size();
  };
  EXPECT_LT(count("sift+sift", {{"contrast_threshold", "0.15"}}), count("sift+sift", {}));
  EXPECT_LT(count("sift+sift", {{"edge_threshold", "2"}}), count("sift+sift", {}));
  EXPECT_NE(count("sift+sift", {{"sigma", "2.5"}}), count("sift+sift", {}));
  EXPECT_NE(count("sift+sift", {{"octave_layers", "5"}}), count("sift+sift", {}));
  EXPECT_LT(count("orb+orb", {{"levels", "1"}}), count("orb+orb", {}));
  EXPECT_LT(count("orb+orb", {{"fast_threshold", "100"}}), count("orb+orb", {}));
  EXPECT_NE(count("orb+orb", {{"scale_factor", "1.5"}}), count("orb+orb", {}));
  EXPECT_NE(count("orb+orb", {{"patch_size", "15"}}), count("orb+orb", {}));
}

TEST(Extractor, ExtremeOptionsDoNoHarm) {
  // Every option at both ends of its range, the others at their defaults.
  for (const std::string& name : extractorNames()) {
    for (const OptionText& option : listOptions(createExtractor(name)->options())) {
      const std::size_t comma = option.range.find(',');
      for (const std::string& value : {option.range.substr(1, comma - 1),
                                       option.range.substr(comma + 2, option.range.size() - comma - 3)}) {
        const Features features = createExtractor(name, {{option.name, value}})->extract(picture());
        EXPECT_EQ(features.descriptors.rows, int(features.keypoints.size()))
            << name << " " << option.name << " " << value;
      }
    }
  }
}

}  // namespace
}  // namespace corrsel::core
